//! Whether what is asked in one round is answered the same way in all that follow.

use std::collections::BTreeMap;

use num_bigint::BigInt;

use super::{Test, open_name};
use crate::assumption::Assumptions;
use crate::closed_form::{Recurrence, Sequence};
use crate::name::Name;
use crate::recurrence::{Reach, reach, solve_until};
use crate::value::Value;

/// How long the answers stay the same.
pub(super) enum Answers {
    /// For ever.
    Forever,
    /// Until this holds, after so many rounds.
    Until(BigInt, Test),
    /// That is not known.
    Unknown,
}

/// Values that begin with these and become their images in each round.
pub(super) struct Values<'a> {
    pub(super) start: &'a BTreeMap<Name, Value>,
    pub(super) images: &'a BTreeMap<Name, Value>,
}

impl Values<'_> {
    /// How long all of these tests hold that hold at the start. Each follows from what held a round before, or never fails
    /// by what is known of the recurrence that the rounds make of the values.
    pub(super) fn answers(&self, tests: &[Test], known: &Assumptions, stop: &dyn Fn() -> bool) -> Answers {
        let mut before = known.clone();
        tests.iter().for_each(|test| before.assume(test.relation, &test.left, &test.right));
        let follows =
            |test: &Test| test.substitute(self.images).ok().and_then(|test| test.decide(&before)) == Some(true);
        let open: Vec<&Test> = tests.iter().filter(|test| !follows(test)).collect();
        if open.is_empty() {
            return Answers::Forever;
        }
        self.by_recurrence(&open, known, stop).unwrap_or(Answers::Unknown)
    }

    fn by_recurrence(&self, tests: &[&Test], known: &Assumptions, stop: &dyn Fn() -> bool) -> Option<Answers> {
        let mut recurrence = Recurrence { index: open_name(&Name::new("round")), from: 0, sequences: Vec::new() };
        let term = |name: &Name| (name.clone(), Value::variable(&recurrence.term(name, 0)));
        let terms: BTreeMap<Name, Value> = self.images.keys().map(term).collect();
        for (name, image) in self.images {
            let (start, next) = (vec![self.start.get(name)?.clone()], image.substitute(&terms).ok()?);
            recurrence.sequences.push(Sequence { name: name.clone(), start, next });
        }
        let solved = solve_until(recurrence.clone(), known, stop).ok();
        let mut first: Option<(BigInt, Test)> = None;
        for test in tests {
            let fails = test.negated();
            let Test { relation, left, right } = fails.substitute(&terms).ok()?;
            match reach(&recurrence, solved.as_ref(), (relation, &left, &right), known, stop) {
                Reach::Never(_) => {}
                Reach::At(index, conditions) if conditions.is_empty() => {
                    let index = index.as_rational()?.to_integer();
                    if first.as_ref().is_none_or(|(known, _)| index < *known) {
                        first = Some((index, fails));
                    }
                }
                _ => return None,
            }
        }
        Some(first.map_or(Answers::Forever, |(index, test)| Answers::Until(index, test)))
    }
}
