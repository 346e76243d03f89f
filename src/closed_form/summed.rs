//! Comparisons of terms whose forms are sums over roots, which need not be written as values: of all terms from an index on,
//! or of those at even and at odd indices.

use std::collections::BTreeMap;

use num_rational::BigRational;
use num_traits::ToPrimitive;

use super::comparing::throughout_or_never;
use super::stretches::Compared;
use super::{Form, Solved};
use crate::exponential_polynomial::ExponentialPolynomial;
use crate::value::{Relation, Value};

/// How often every second term is looked at by itself.
const MOST_HALVINGS: usize = 2;

/// A value in the terms of offset 0 and the index as one sum over roots, and after how many first terms it is that.
pub(crate) fn sum_of(solved: &Solved, value: &Value) -> Option<(ExponentialPolynomial, u64)> {
    let recurrence = solved.recurrence();
    let index = &recurrence.index;
    let mut rest = value.clone();
    let mut sum = ExponentialPolynomial::zero();
    let (mut early, mut images) = (0, BTreeMap::new());
    for (name, place, _) in recurrence.terms().into_iter().filter(|(.., offset)| *offset == 0) {
        if !rest.mentions(&name) {
            continue;
        }
        let (first, own, form) = match &solved.forms()[place] {
            Form::Sum(first, own) => (first.len() as u64, own.clone(), None),
            Form::Value(first, own) => (first.len() as u64, ExponentialPolynomial::of(own, index)?, Some(own.clone())),
            Form::Pieces(pieces) => {
                let last = pieces.last()?;
                let since = &last.from.as_rational()? - BigRational::from_integer(recurrence.from.into());
                (since.to_u64()?, ExponentialPolynomial::of(&last.form, index)?, Some(last.form.clone()))
            }
            _ => return None,
        };
        early = early.max(first);
        match rest.linear_in(&name).filter(|(factor, _)| factor.as_rational().is_some()) {
            Some((factor, constant)) => {
                sum = sum.plus(&own.scale(&factor).ok()?).ok()?;
                rest = constant;
            }
            None => {
                images.insert(name, form.or_else(|| own.value(index))?);
            }
        }
    }
    let rest = rest.substitute(&images).ok()?;
    Some((sum.plus(&ExponentialPolynomial::of(&rest, index)?).ok()?, early))
}

/// The indices `m` of every second term of every second term of …, each even or odd, from one on.
struct Halves {
    odd: Vec<bool>,
    from: u64,
}

impl Halves {
    fn half(&self, odd: bool) -> Halves {
        // 2*m, or 2*m+1, is not before the first.
        let from = if odd { self.from / 2 } else { self.from.div_ceil(2) };
        Halves { odd: self.odd.iter().copied().chain([odd]).collect(), from }
    }
}

impl Compared<'_> {
    /// Whether the comparison holds at no index from one on.
    pub(super) fn never_of_sums(&self, solved: &Solved, from: i64) -> bool {
        let plain = [self.wanted.1.clone(), self.wanted.2.clone()];
        let never = |from: u64| self.never_of_halves(solved, &plain, &Halves { odd: Vec::new(), from });
        self.recurrence.from >= 0 && u64::try_from(from).is_ok_and(never)
    }

    fn never_of_halves(&self, solved: &Solved, plain: &[Value; 2], halves: &Halves) -> bool {
        let leaf = |value: &Value, relation: Relation| {
            let (sum, early) = sum_of(solved, value)?;
            let first = self.recurrence.from.unsigned_abs().saturating_add(early);
            let (mut sum, mut first) = (sum, Halves { odd: Vec::new(), from: first });
            for odd in &halves.odd {
                (sum, first) = (sum.half(*odd)?, first.half(*odd));
            }
            if halves.from < first.from {
                return None;
            }
            throughout_or_never(&sum, relation, halves.from, None)
        };
        self.holds(plain, &self.anywhere(), &leaf) == Some(false)
            || halves.odd.len() < MOST_HALVINGS
                && [false, true].iter().all(|odd| self.never_of_halves(solved, plain, &halves.half(*odd)))
    }
}
