//! The terms of a recurrence, made one by one as it says, within a limit of their length, and compared.

use std::collections::BTreeMap;

use super::stretches::{Compared, needs_of};
use crate::name::Name;
use crate::value::{Need, Value};

/// The bits that terms may have together, those where nothing else is left to try, and the longest of them; a part of a term with
/// symbols counts for so many.
const MOST_BITS: u64 = 1 << 24;
const MOST_BITS_AT_LAST: u64 = 1 << 28;
const LONGEST: u64 = 1 << 16;
const SYMBOLIC: u64 = 1 << 10;

/// What the recurrence reads at an index.
pub(super) struct Terms<'c> {
    compared: &'c Compared<'c>,
    now: Vec<Value>,
    images: BTreeMap<Name, Value>,
    step: i64,
    bits: u64,
    most: u64,
}

impl<'c> Terms<'c> {
    /// Those at the first index.
    pub(super) fn of(compared: &'c Compared<'c>) -> Terms<'c> {
        let now: Vec<Value> =
            compared.recurrence.sequences.iter().flat_map(|sequence| sequence.start.clone()).collect();
        let mut terms = Terms { compared, now, images: BTreeMap::new(), step: 0, bits: 0, most: MOST_BITS };
        terms.images = terms.read();
        terms
    }

    /// The same, where nothing else is left to try.
    pub(super) fn at_last(compared: &'c Compared<'c>) -> Terms<'c> {
        Terms { most: MOST_BITS_AT_LAST, ..Terms::of(compared) }
    }

    fn read(&self) -> BTreeMap<Name, Value> {
        let names = self.compared.recurrence.terms().into_iter().map(|(name, ..)| name);
        let mut images: BTreeMap<Name, Value> = names.zip(self.now.iter().cloned()).collect();
        images.insert(self.compared.recurrence.index.clone(), Value::integer(self.index()));
        images
    }

    /// The index.
    pub(super) fn index(&self) -> i64 {
        self.compared.recurrence.from.saturating_add(self.step)
    }

    /// The values, which tell all that follows where the index is not read.
    pub(super) fn state(&self) -> &[Value] {
        &self.now
    }

    /// Both sides of the comparison.
    pub(super) fn sides(&self) -> Option<[Value; 2]> {
        self.compared.sides(&self.images)
    }

    /// Whether the comparison holds here.
    pub(super) fn holds(&self) -> Option<bool> {
        self.compared.holds(&self.sides()?, &self.compared.known, &|_, _| None)
    }

    /// Whether both sides, as they are written, have a value here.
    pub(super) fn compares(&self) -> bool {
        self.grants([self.compared.wanted.1, self.compared.wanted.2]) == Some(true)
    }

    /// Whether these, as they are written, have a value here. A number to a negative power has one that is a number.
    fn grants<'v>(&self, values: impl IntoIterator<Item = &'v Value>) -> Option<bool> {
        let mut all = Some(true);
        for value in values {
            let image = value.substitute(&self.images).ok();
            let number = image.as_ref().is_some_and(|image| image.as_rational().is_some());
            for need in needs_of([value], &self.images)? {
                match (self.compared.known.grants(&need), &need) {
                    (Some(true), _) => {}
                    (_, Need::Natural(exponent)) if number && is_integer(exponent) => {}
                    (_, Need::Natural(_)) => all = None,
                    // Where it has a value all the same, a condition may have excluded what has none.
                    (Some(false), _) if image.is_none() => return Some(false),
                    _ => all = None,
                }
            }
        }
        all
    }

    /// Goes on to the next index: false where there are no terms at it, nothing where that is not known or they are too long.
    /// Each term must exist, whether or not it is compared.
    pub(super) fn advance(&mut self) -> Option<bool> {
        let sequences = &self.compared.recurrence.sequences;
        if !self.grants(sequences.iter().map(|sequence| &sequence.next))? {
            return Some(false);
        }
        let mut rest = self.now.iter().cloned();
        let mut later = Vec::with_capacity(self.now.len());
        for sequence in sequences {
            rest.next()?;
            later.extend(rest.by_ref().take(sequence.start.len().saturating_sub(1)));
            later.push(self.compared.known.simplify(&sequence.next.substitute(&self.images).ok()?));
        }
        (self.now, self.step) = (later, self.step + 1);
        let lengths = self.now.iter().map(length);
        let (longest, all) = lengths.fold((0, 0), |(longest, all), own| (own.max(longest), all + own));
        self.bits += all;
        if longest > LONGEST || self.bits > self.most {
            return None;
        }
        self.images = self.read();
        Some(true)
    }
}

fn is_integer(value: &Value) -> bool {
    value.as_rational().is_some_and(|number| number.is_integer())
}

/// What a term counts for, in bits.
fn length(value: &Value) -> u64 {
    match value.as_rational() {
        Some(number) => number.numer().bits() + number.denom().bits(),
        None => SYMBOLIC.saturating_mul(value.size() as u64),
    }
}
