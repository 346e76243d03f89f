//! The least change that repairs, between one that does not and one that does.

use std::collections::BTreeSet;

use num_rational::BigRational;
use num_traits::Signed;

use super::{Feedback, Goal, HALVINGS, MOST_DENOMINATOR, PARTS, Repair, Workshop, change, small};
use crate::criteria::Standing;
use crate::lower::{Ask, Criterion};
use crate::name::Name;
use crate::simplest::simplest;

impl Workshop<'_> {
    /// By halving, then the simplest number there is.
    pub(super) fn narrowed(
        &self,
        goal: Goal<'_>,
        parameter: &Name,
        value: &BigRational,
        (mut fails, mut works): (BigRational, BigRational),
    ) -> Option<Repair> {
        let at = |value: &BigRational| vec![(parameter.clone(), value.clone())];
        let met = |value: &BigRational| self.met(goal, &at(value));
        for round in 0..2 {
            for _ in 0..HALVINGS / 2 {
                let middle = (&fails + &works) / BigRational::from_integer(2.into());
                if met(&middle) { works = middle } else { fails = middle }
            }
            // A simple number may be just the place: met there, and not a little before.
            let simple = simplest(&fails, &works);
            let before = &simple + (value - &simple) * small();
            if round == 0 && simple != fails && met(&simple) && !met(&before) {
                (fails, works) = (before, simple);
                break;
            }
        }
        if let Some((before, nearer)) = self.nearer(goal, parameter, value, &works) {
            (fails, works) = (before, nearer);
            for _ in 0..HALVINGS / 2 {
                let middle = (&fails + &works) / BigRational::from_integer(2.into());
                if met(&middle) { works = middle } else { fails = middle }
            }
        }
        let simple = simplest(&fails, &works);
        if simple != fails && met(&simple) {
            works = simple.clone();
        }
        // Where it is open it may be met after all.
        let not_met = |value: &BigRational| self.standing(goal, &at(value)) == Some(Standing::NotMet);
        let mut repair = None;
        if simple.denom() < &MOST_DENOMINATOR.into() && simple != works {
            // The place itself does not count: a little further then.
            let further = self.further(goal, parameter, value, &works);
            repair = further.or_else(|| self.repair(goal, &at(&works)));
            if let Some(repair) = repair.as_mut().filter(|_| not_met(&simple)) {
                repair.not_at = Some(simple);
            }
        } else if works.denom() < &MOST_DENOMINATOR.into() {
            repair = self.repair(goal, &at(&works));
            if let Some(repair) = repair.as_mut().filter(|_| not_met(&fails)) {
                repair.least = Some((&works - &fails).abs());
            }
        }
        repair.or_else(|| self.further(goal, parameter, value, &works)).or_else(|| self.repair(goal, &at(&works)))
    }

    /// A place nearer to the present value at which the criterion is met, with one before it at which it is not: what is counted
    /// in rounds, or steps over a place, is met in several stretches. Chances are not looked for so often.
    fn nearer(
        &self,
        goal: Goal<'_>,
        parameter: &Name,
        value: &BigRational,
        works: &BigRational,
    ) -> Option<(BigRational, BigRational)> {
        if self.is_chance(goal) {
            return None;
        }
        let place = |part: i64| value + (works - value) * BigRational::new(part.into(), PARTS.into());
        let met = |part: &i64| !(self.judge.interrupted)() && self.met(goal, &[(parameter.clone(), place(*part))]);
        (1..PARTS).find(met).map(|first| (place(first - 1), place(first)))
    }

    /// The simplest number at which the criterion is met, a hundredth further from the present value at most: a
    /// hundredth of the change, or of the value itself where hardly any change is needed.
    fn further(&self, goal: Goal<'_>, parameter: &Name, present: &BigRational, works: &BigRational) -> Option<Repair> {
        let (change, hundredth) = (works - present, BigRational::new(1.into(), 100.into()));
        let far = if change.abs() < works.abs() * &hundredth { works.abs() } else { change.abs() };
        let further = works + change.signum() * far * hundredth;
        self.repair(goal, &[(parameter.clone(), simplest(works, &further))])
    }

    fn is_chance(&self, goal: Goal<'_>) -> bool {
        let asked = |one: &&Criterion| goal.is_none_or(|name| one.name == *name);
        self.criteria.all.iter().filter(asked).any(|one| matches!(one.kind, Ask::Probability { .. }))
    }

    /// Changes of one parameter that were found for other criteria, or for all, in place of those that go further the same
    /// way.
    pub(super) fn brought_nearer(&self, feedback: &mut [Feedback], all: &[Repair]) {
        let found: Vec<Repair> = feedback.iter().flat_map(|one| &one.single).chain(all).cloned().collect();
        let mut found: Vec<Repair> = found.into_iter().filter(|repair| repair.changes.len() == 1).collect();
        found.sort_by_key(change);
        for Feedback { name, single, .. } in feedback {
            if self.is_chance(Some(name)) {
                continue;
            }
            for repair in single.iter_mut() {
                // One that breaks nothing is not given up for one that does.
                let as_good = |one: &Repair| one.is_harmless() || !repair.is_harmless();
                let nearer = |one: &Repair| as_good(one) && change(one) < change(repair);
                let found = found.iter().filter(|one| one.ways() == repair.ways() && nearer(one));
                let met = found.into_iter().find(|one| self.met(Some(name), &one.point()));
                let Some([(parameter, present, place)]) = met.map(|one| one.changes.as_slice()) else { continue };
                let between = (present.clone(), place.clone());
                let nearest = self.narrowed(Some(name), parameter, present, between);
                if let Some(nearest) = nearest.filter(nearer) {
                    *repair = nearest;
                }
            }
            let mut seen = BTreeSet::new();
            single.retain(|one| seen.insert(one.point()));
        }
    }
}
