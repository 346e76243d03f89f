//! The later deadline by which a chance to come somewhere is high enough.

use num_rational::BigRational;
use num_traits::Signed;

use super::Workshop;
use crate::lower::{Ask, Criterion, Event, Likelihood};
use crate::simplest::simplest;
use crate::value::{Relation, Value};

/// The factors by which the deadline is put off.
const FACTORS: [(i64, i64); 8] = [(9, 8), (5, 4), (3, 2), (2, 1), (3, 1), (4, 1), (8, 1), (16, 1)];
/// Halvings of the time in which the least deadline lies.
const HALVINGS: usize = 12;

impl Workshop<'_> {
    /// The least deadline by which the criterion is met, about, found by halving and judged again; none where no later one
    /// is known to be enough, or it asks for something else.
    pub(super) fn deadline(&self, criterion: &Criterion) -> Option<BigRational> {
        let Ask::Probability { likelihood, relation, threshold } = &criterion.kind else { return None };
        let Event::Shown { first: true, pattern, time } = &likelihood.event else { return None };
        let present = time.as_rational().filter(Signed::is_positive)?;
        if !matches!(relation, Relation::Gtr | Relation::Gte) {
            return None;
        }
        let by = |time: &BigRational| Likelihood {
            event: Event::Shown { first: true, pattern: pattern.clone(), time: Value::rational(time.clone()) },
            ..likelihood.clone()
        };
        let chances = |chances: &super::Chances<'_>, time: &BigRational| {
            let likely = chances(&by(time), self.environment, (*relation, threshold)).ok()?;
            let low = likely.number.clone().or_else(|| BigRational::from_float(likely.low))?;
            // What is only simulated is not looked for any further.
            likely.sure.then(|| relation.holds(low.cmp(threshold)))
        };
        let enough = |time: &BigRational| if (self.judge.interrupted)() { None } else { chances(self.roughly, time) };
        let (mut short, mut long) = (present.clone(), None);
        for (top, bottom) in FACTORS {
            let later = &present * BigRational::new(top.into(), bottom.into());
            if enough(&later)? {
                long = Some(later);
                break;
            }
            short = later;
        }
        let mut long = long?;
        for _ in 0..HALVINGS {
            let middle = (&short + &long) / BigRational::from_integer(2.into());
            if enough(&middle)? {
                long = middle;
            } else {
                short = middle;
            }
        }
        // What comes in rounds comes at a simple time, if it is that by which it is enough.
        let middle = (&short + &long) / BigRational::from_integer(2.into());
        let simple = [simplest(&short, &long), simplest(&middle, &long)].into_iter().filter(|time| *time != short);
        simple.chain([long.clone()]).find(|time| chances(self.judge.chances, time) == Some(true))
    }
}
