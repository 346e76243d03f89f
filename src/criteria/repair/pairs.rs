//! Changes of two parameters.

use std::collections::BTreeSet;

use num_rational::BigRational;
use num_traits::One;

use super::{Goal, HALVINGS, MOST_PAIRS, Repair, Workshop, change, factors, moved};
use crate::name::Name;
use crate::simplest::simplest;

impl Workshop<'_> {
    /// Two parameters: what one repairs and breaks mended by another, or both moved together.
    pub(super) fn pairs(&self, goal: Goal<'_>, single: &[Repair]) -> Vec<Repair> {
        let mut found: Vec<Repair> = Vec::new();
        for repair in single.iter().take(4) {
            let Some((first, _, value)) = repair.changes.first() else { continue };
            for (second, present) in self.parameters.iter().filter(|(other, _)| other != first) {
                let sides = [true, false];
                found.extend(
                    sides.into_iter().filter_map(|up| self.mended(goal, (first, value), (second, present), up)),
                );
            }
        }
        if single.is_empty() {
            let all = self.parameters;
            let pairs = (0..all.len()).flat_map(|one| (one + 1..all.len()).map(move |other| (one, other)));
            for (one, other) in pairs.take(MOST_PAIRS) {
                if (self.judge.interrupted)() {
                    break;
                }
                found.extend(self.together(goal, &all[one], &all[other]));
            }
        }
        found.sort_by_key(change);
        found.truncate(4);
        found
    }

    /// The changes of one parameter among those of two that break nothing by themselves, the least of each parameter.
    pub(super) fn halves(&self, goal: Goal<'_>, pairs: &[Repair]) -> Vec<Repair> {
        let mut found: Vec<Repair> = Vec::new();
        for (parameter, _, value) in pairs.iter().flat_map(|pair| &pair.changes) {
            found.extend(self.harmless(goal, &[(parameter.clone(), value.clone())]));
        }
        found.sort_by_key(change);
        let mut seen = BTreeSet::new();
        found.retain(|one| one.changes.iter().all(|(parameter, ..)| seen.insert(parameter.clone())));
        found
    }

    /// A value of the second parameter with which the first repairs the criterion and nothing breaks.
    fn mended(
        &self,
        goal: Goal<'_>,
        (first, value): (&Name, &BigRational),
        (second, present): (&Name, &BigRational),
        up: bool,
    ) -> Option<Repair> {
        let point = |other: &BigRational| vec![(first.clone(), value.clone()), (second.clone(), other.clone())];
        let fine = |other: &BigRational| self.harmless(goal, &point(other));
        let mut fails = present.clone();
        let mut works = None;
        for factor in factors() {
            let next = moved(present, &factor, up);
            if fine(&next).is_some() {
                works = Some(next);
                break;
            }
            fails = next;
        }
        let mut works = works?;
        for _ in 0..HALVINGS / 2 {
            let middle = (&fails + &works) / BigRational::from_integer(2.into());
            if fine(&middle).is_some() { works = middle } else { fails = middle }
        }
        fine(&simplest(&fails, &works)).or_else(|| fine(&works))
    }

    /// Both parameters changed by one factor each, up or down.
    fn together(&self, goal: Goal<'_>, one: &(Name, BigRational), other: &(Name, BigRational)) -> Option<Repair> {
        let mut best: Option<Repair> = None;
        for (up, also_up) in [(true, true), (true, false), (false, true), (false, false)] {
            let point = |factor: &BigRational| {
                vec![(one.0.clone(), moved(&one.1, factor, up)), (other.0.clone(), moved(&other.1, factor, also_up))]
            };
            let fine = |factor: &BigRational| self.harmless(goal, &point(factor));
            let mut fails = BigRational::one();
            let mut works = None;
            for factor in [(5, 4), (2, 1), (8, 1)] {
                if (self.judge.interrupted)() {
                    return best;
                }
                let factor = BigRational::new(factor.0.into(), factor.1.into());
                if fine(&factor).is_some() {
                    works = Some(factor);
                    break;
                }
                fails = factor;
            }
            let Some(mut works) = works else { continue };
            for _ in 0..HALVINGS / 2 {
                let middle = (&fails + &works) / BigRational::from_integer(2.into());
                if fine(&middle).is_some() { works = middle } else { fails = middle }
            }
            let repair = fine(&simplest(&fails, &works)).or_else(|| fine(&works));
            if let Some(repair) = repair
                && best.as_ref().is_none_or(|best| change(&repair) < change(best))
            {
                best = Some(repair);
            }
        }
        best
    }
}
