//! Changes that are looked for more widely: what repairs one criterion tried on the others, more places, and the places
//! at which some margin becomes 0 on the ways that the run takes there; and changes that meet every criterion at once.

use std::collections::BTreeSet;

use num_rational::BigRational;

use super::{Feedback, Goal, HALVINGS, Point, Repair, Workshop, change, moved};
use crate::criteria::nearby::nearby;
use crate::name::Name;
use crate::simplest::simplest;

/// Runs that are judged in one wider search.
const MOST_JUDGED: usize = 300;
/// Runs that are judged for the formulas beside one place.
const FORMULAS: usize = 10;
/// Changes that meet every criterion of which are told.
const MOST_TOLD: usize = 3;

/// The factors of a wider search.
const FACTORS: [(i64, i64); 16] = [
    (101, 100),
    (9, 8),
    (5, 4),
    (3, 2),
    (7, 4),
    (2, 1),
    (5, 2),
    (3, 1),
    (4, 1),
    (5, 1),
    (6, 1),
    (8, 1),
    (10, 1),
    (16, 1),
    (64, 1),
    (256, 1),
];

/// The changes of these repairs, each once.
pub(super) fn points(repairs: &[Vec<Repair>]) -> Vec<Point> {
    let mut found: Vec<Point> = repairs.iter().flatten().map(Repair::point).collect();
    found.sort();
    found.dedup();
    found
}

impl Repair {
    /// The change, in the order of the names.
    pub(super) fn point(&self) -> Point {
        let mut point: Point = self.changes.iter().map(|(name, _, after)| (name.clone(), after.clone())).collect();
        point.sort();
        point
    }

    /// Which parameters it changes, and which way.
    pub(super) fn ways(&self) -> Vec<(Name, bool)> {
        let mut ways: Vec<(Name, bool)> =
            self.changes.iter().map(|(name, before, after)| (name.clone(), after > before)).collect();
        ways.sort();
        ways
    }
}

/// How many runs may still be judged.
struct Budget(usize);

impl Budget {
    fn spend(&mut self, runs: usize) -> bool {
        let enough = self.0 >= runs;
        self.0 = self.0.saturating_sub(runs);
        enough
    }
}

impl Workshop<'_> {
    /// Adds what repairs other criteria where it repairs this one too, and breaks nothing; of each parameter the least.
    pub(super) fn repaired_by_others(&self, name: &Name, points: &[Point], single: &mut Vec<Repair>) {
        let known: Vec<Point> = single.iter().map(Repair::point).collect();
        let others = points.iter().filter(|point| !known.contains(point));
        let mut found: Vec<Repair> = others.filter_map(|point| self.harmless(Some(name), point)).collect();
        found.sort_by_key(change);
        for repair in found {
            let of = |one: &Repair| one.changes.first().map(|(parameter, ..)| parameter.clone());
            if !single.iter().any(|one| one.is_harmless() && of(one) == of(&repair)) {
                single.push(repair);
            }
        }
    }

    /// The first change of one parameter that meets the goal and breaks nothing, of each that is found at the same
    /// factor. Where a change is known that meets the goal and breaks something, it is looked for beyond that first.
    pub(super) fn wider(&self, goal: Goal<'_>, harmful: &[Repair]) -> Vec<Repair> {
        let mut budget = Budget(MOST_JUDGED);
        let begun = |parameter: &Name, up: bool| {
            let ends = harmful.iter().filter_map(|one| match one.changes.as_slice() {
                [(name, before, after)] if name == parameter && (after > before) == up => Some(after.clone()),
                _ => None,
            });
            if up { ends.min() } else { ends.max() }
        };
        let beyond = self.outward(goal, &mut budget, &begun);
        if !beyond.is_empty() {
            return beyond;
        }
        let present = |parameter: &Name| self.parameters.iter().find(|(name, _)| name == parameter);
        self.outward(goal, &mut budget, &|name, up| {
            present(name).filter(|_| begun(name, up).is_none()).map(|(_, value)| value.clone())
        })
    }

    /// The same, of each parameter either way from a value on; not at all where none is given.
    fn outward(
        &self,
        goal: Goal<'_>,
        budget: &mut Budget,
        from: &dyn Fn(&Name, bool) -> Option<BigRational>,
    ) -> Vec<Repair> {
        let mut before: Vec<[Option<BigRational>; 2]> =
            self.parameters.iter().map(|(name, _)| [true, false].map(|up| from(name, up))).collect();
        for (above, below) in FACTORS {
            let factor = BigRational::new(above.into(), below.into());
            let mut found = Vec::new();
            for ((name, value), before) in self.parameters.iter().zip(&mut before) {
                for (up, before) in [true, false].into_iter().zip(before) {
                    if (self.judge.interrupted)() {
                        return found;
                    }
                    let next = moved(value, &factor, up);
                    let Some(last) = before.as_ref().filter(|last| next != **last && (next > **last) == up) else {
                        continue;
                    };
                    found.extend(self.about(goal, (name, value), (last, &next), budget));
                    *before = Some(next);
                }
            }
            if !found.is_empty() {
                found.sort_by_key(change);
                return found;
            }
        }
        Vec::new()
    }

    /// A change to this place, or to the nearest one before it with which it goes on so; or to a place nearby at which a
    /// margin is 0.
    fn about(
        &self,
        goal: Goal<'_>,
        (name, present): (&Name, &BigRational),
        (before, place): (&BigRational, &BigRational),
        budget: &mut Budget,
    ) -> Option<Repair> {
        let fine = |value: &BigRational, budget: &mut Budget| {
            if budget.spend(1) { self.harmless(goal, &[(name.clone(), value.clone())]) } else { None }
        };
        if let Some(mut repair) = fine(place, budget) {
            let (mut fails, mut works) = (before.clone(), place.clone());
            for _ in 0..HALVINGS / 2 {
                let middle = (&fails + &works) / BigRational::from_integer(2.into());
                match fine(&middle, budget) {
                    Some(nearer) => (works, repair) = (middle, nearer),
                    None => fails = middle,
                }
            }
            // Where any change is enough, it is one that can be told from none.
            if fails == *before && before == present {
                return fine(place, budget).or(Some(repair));
            }
            return fine(&simplest(&fails, &works), budget).or(Some(repair));
        }
        let mut roots: Vec<BigRational> = Vec::new();
        for up in [true, false] {
            if !budget.spend(FORMULAS) {
                return None;
            }
            let formulas = nearby(place, up, &|there| self.margins(name, there));
            roots.extend(formulas.values().filter_map(super::Formula::root));
        }
        // As far from the present value as others are that are tried, on the same side.
        let beyond = place + (place - present);
        let within = |root: &BigRational| {
            let (low, high) = if present < &beyond { (present, &beyond) } else { (&beyond, present) };
            low < root && root < high && self.plausible(root, present)
        };
        roots.retain(within);
        roots.sort_by_key(|root| num_traits::Signed::abs(&(root - present)));
        roots.dedup();
        roots.iter().find_map(|root| fine(root, budget))
    }

    /// Changes with which every criterion is met: of those that repair one, or of one parameter, or of two; of each
    /// parameter the least either way. There is none where nothing was found for some criterion.
    pub(super) fn all_at_once(&self, feedback: &[Feedback]) -> Vec<Repair> {
        if feedback.iter().any(|one| one.single.is_empty() && one.pairs.is_empty()) {
            return Vec::new();
        }
        let repairs: Vec<Vec<Repair>> =
            feedback.iter().map(|one| [one.single.as_slice(), one.pairs.as_slice()].concat()).collect();
        let mut found: Vec<Repair> = points(&repairs).iter().filter_map(|point| self.harmless(None, point)).collect();
        found.extend(self.wider(None, &[]));
        if found.is_empty() {
            let single: Vec<Repair> = feedback.iter().flat_map(|one| one.single.iter().take(2)).cloned().collect();
            found = self.pairs(None, &single);
        }
        found.sort_by_key(change);
        let mut seen = BTreeSet::new();
        found.retain(|one| seen.insert(one.ways()));
        found.truncate(MOST_TOLD);
        found
    }
}
