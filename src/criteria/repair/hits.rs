//! Changes with which a robot hits a place that it steps over now: such values lie apart, and no halving finds them.

use std::collections::BTreeMap;

use num_rational::BigRational;
use num_traits::{Signed, Zero};

use super::{Repair, Workshop, change};
use crate::criteria::Finding;
use crate::criteria::nearby::{Formula, nearby};
use crate::criteria::visit::values_of;
use crate::lower::Ask;
use crate::name::Name;
use crate::timeline::Follower;
use crate::value::Value;

/// Stretches of a run that are looked at.
const MOST_PLACES: usize = 256;
/// Values that are tried for one criterion, of those nearest to the present one.
const MOST_HITS: usize = 24;
/// Into so many parts a change is cut, to see which ways the run takes from each on.
const PARTS: i64 = 16;

impl Workshop<'_> {
    /// The nearest value at which some stretch of the run lies just on a goal and the criterion is met, where that is
    /// nearer than what was found.
    pub(super) fn hit(
        &self,
        finding: &Finding,
        (parameter, value): (&Name, &BigRational),
        hits: &[BigRational],
        found: Option<Repair>,
    ) -> Option<Repair> {
        if !self.is_arrival(finding) {
            return found;
        }
        let (goal, far) =
            (Some(&finding.name), found.as_ref().and_then(|found| Some(found.changes.first()?.2.clone())));
        let nearer = |root: &BigRational| far.as_ref().is_none_or(|far| (root - value).abs() < (far - value).abs());
        let hits = hits.iter().filter(|root| nearer(root)).take(MOST_HITS);
        let met = hits
            .into_iter()
            .find(|root| !(self.judge.interrupted)() && self.met(goal, &[(parameter.clone(), (*root).clone())]));
        let nearest = met.and_then(|root| self.narrowed(goal, parameter, value, (value.clone(), root.clone())));
        let nearest = match (nearest, found) {
            (Some(nearest), Some(found)) if change(&found) <= change(&nearest) => Some(found),
            (nearest, found) => nearest.or(found),
        };
        nearest.map(|nearest| self.hit_before(goal, (parameter, value), &nearest).unwrap_or(nearest))
    }

    /// A smaller change that hits a goal by other ways than those that the run takes beside the present value: of a place
    /// that counts as a goal only where it is met exactly, they lie apart.
    fn hit_before(
        &self,
        goal: Option<&Name>,
        (parameter, value): (&Name, &BigRational),
        found: &Repair,
    ) -> Option<Repair> {
        let (_, _, far) = found.changes.first()?;
        if !self.criteria.radius.is_zero() {
            return None;
        }
        let (parts, up) = (BigRational::from_integer(PARTS.into()), far > value);
        let part = |number: i64| value + (far - value) * BigRational::from_integer(number.into()) / &parts;
        let within = |root: &BigRational| (root > value) == up && (root < far) == up && root != value && root != far;
        let mut roots: Vec<BigRational> = Vec::new();
        for number in (1..PARTS).take_while(|_| !(self.judge.interrupted)()) {
            roots.extend(self.roots_beside(parameter, &part(number), up).into_iter().filter(within));
        }
        roots.sort_by_key(|root| (root - value).abs());
        roots.dedup();
        let met = |root: &&BigRational| {
            !(self.judge.interrupted)() && self.met(goal, &[(parameter.clone(), (*root).clone())])
        };
        let root = roots.iter().take(MOST_HITS).find(met)?;
        self.narrowed(goal, parameter, value, (value.clone(), root.clone()))
            .filter(|nearest| change(nearest) < change(found))
    }

    /// Whether a criterion is about when, or whether, a goal is reached.
    pub(super) fn is_arrival(&self, finding: &Finding) -> bool {
        let kind = self.criteria.all.iter().find(|one| one.name == finding.name).map(|one| &one.kind);
        matches!(kind, Some(Ask::Radius(_) | Ask::Leg { .. } | Ask::Round { .. }))
    }

    /// For each parameter the values upward and downward of the present one at which some stretch lies on a goal; none of
    /// any where they are not `wanted`.
    pub(super) fn hits(&self, wanted: bool) -> Vec<[Vec<BigRational>; 2]> {
        let beside = |(parameter, value): &(Name, BigRational)| {
            let wanted = wanted && !(self.judge.interrupted)();
            [true, false].map(|up| if wanted { self.hits_beside(parameter, value, up) } else { Vec::new() })
        };
        self.parameters.iter().map(beside).collect()
    }

    /// The same on one side of one parameter, by the ways that the run takes right beside the present value; the nearest
    /// first.
    fn hits_beside(&self, parameter: &Name, value: &BigRational, up: bool) -> Vec<BigRational> {
        let mut roots = self.roots_beside(parameter, value, up);
        roots.retain(|root| root != value && (root > value) == up && self.plausible(root, value));
        roots.sort_by_key(|root| (root - value).abs());
        roots.dedup();
        roots
    }

    /// Where the formulas are 0 by which stretches of the run are away from goals, beside a value.
    fn roots_beside(&self, parameter: &Name, value: &BigRational, up: bool) -> Vec<BigRational> {
        nearby(value, up, &|there| self.places(parameter, there)).values().filter_map(Formula::root).collect()
    }

    /// How far each stretch of the run lies from each goal, on every axis, when one parameter has another value.
    fn places(&self, parameter: &Name, value: &BigRational) -> Option<BTreeMap<Name, BigRational>> {
        let (criteria, environment) = self.elsewhere(&[(parameter.clone(), value.clone())])?;
        let term = environment.system(&criteria.system)?.term(&environment.definitions);
        let mut follower = Follower::new(&term, &environment.definitions);
        follower.follow(MOST_PLACES, self.judge.interrupted);
        let run = follower.run();
        let mut found = BTreeMap::new();
        for (stretch, shown) in run.stretches.iter().map(|one| &one.shown).enumerate() {
            for (number, goal) in criteria.goals.iter().enumerate() {
                for (place, values) in values_of(shown, &goal.observer).enumerate() {
                    for (axis, far) in apart(values, &goal.values).into_iter().enumerate() {
                        found.insert(Name::new(&format!("{stretch}.{number}.{place}.{axis}")), far);
                    }
                }
            }
        }
        Some(found)
    }
}

/// By how much two places differ, axis by axis.
fn apart(one: &[Value], other: &[Value]) -> Vec<BigRational> {
    let axes = |value: &Value| value.components().unwrap_or_else(|| vec![value.clone()]);
    let pairs = one.iter().flat_map(axes).zip(other.iter().flat_map(axes));
    pairs.filter_map(|(one, other)| one.sub(&other).ok()?.as_rational()).collect()
}
