//! Recurrences whose left side is not the next term alone: `(n+1)*u(n+1) = n*u(n) + 1`, `u(n+2) - 3*u(n+1) + 2*u(n) = 0`. The
//! term that is furthest ahead stays on the left; what is added to it goes to the right, and what multiplies it divides there.

use std::borrow::Cow;
use std::collections::BTreeSet;

use super::scope::Lowerer;
use super::solve::subscripted;
use crate::ast::{Argument, Value as Written, ValueKind};
use crate::name::Name;

/// A term on the left side and where it stands: its offset, whether it is subtracted, its place among the parts, and what it is
/// multiplied with or divided by.
struct Leading {
    offset: i64,
    negative: bool,
    place: usize,
    term: Written,
    factors: Vec<(bool, Written)>,
}

impl Lowerer<'_> {
    /// The equation with nothing but a term on its left side; as it is where that is so, or where the left side has no next
    /// term of one of these sequences.
    pub(super) fn led<'a>(
        &mut self,
        left: &'a Written,
        right: &'a Written,
        names: &BTreeSet<Name>,
    ) -> Option<(Cow<'a, Written>, Cow<'a, Written>)> {
        let single = vec![(false, left.clone())];
        let parts = match &left.kind {
            ValueKind::Sum(parts) => parts,
            ValueKind::Product(_) | ValueKind::Negative(_) => &single,
            _ => return Some((Cow::Borrowed(left), Cow::Borrowed(right))),
        };
        let found: Vec<Leading> = parts
            .iter()
            .enumerate()
            .filter_map(|(place, (minus, part))| self.leading(place, *minus, part, names))
            .collect();
        let Some(most) = found.iter().map(|one| one.offset).max() else {
            return Some((Cow::Borrowed(left), Cow::Borrowed(right)));
        };
        let mut ahead = found.into_iter().filter(|one| one.offset == most);
        let Some(first) = ahead.next() else { return Some((Cow::Borrowed(left), Cow::Borrowed(right))) };
        if ahead.next().is_some() {
            let text =
                "two terms on the left side are equally far ahead: leave there the one that the equation is about";
            return self.wrong(left.span, text);
        }
        let span = right.span;
        let mut rest = vec![(false, right.clone())];
        let others = parts.iter().enumerate().filter(|(place, _)| *place != first.place);
        rest.extend(others.map(|(_, (minus, part))| (!minus, part.clone())));
        let mut kind = if rest.len() == 1 { right.kind.clone() } else { ValueKind::Sum(rest) };
        if first.negative {
            kind = ValueKind::Negative(Box::new(Written { span, kind }));
        }
        if !first.factors.is_empty() {
            let mut factors = vec![(false, Written { span, kind })];
            factors.extend(first.factors.into_iter().map(|(divides, factor)| (!divides, factor)));
            kind = ValueKind::Product(factors);
        }
        Some((Cow::Owned(first.term), Cow::Owned(Written { span, kind })))
    }

    /// A part of the left side as a term of which the index is not a number, with its factors.
    fn leading(&mut self, place: usize, negative: bool, part: &Written, names: &BTreeSet<Name>) -> Option<Leading> {
        match &part.kind {
            ValueKind::Negative(inner) => self.leading(place, !negative, inner, names),
            ValueKind::Product(parts) => {
                let mut terms = parts.iter().enumerate().filter(|(_, (divides, _))| !divides);
                let (own, offset) =
                    terms.find_map(|(number, (_, factor))| Some((number, self.ahead(factor, names)?)))?;
                let others = parts.iter().enumerate().filter(|(number, _)| *number != own);
                let factors = others.map(|(_, factor)| factor.clone()).collect();
                Some(Leading { offset, negative, place, term: parts[own].1.clone(), factors })
            }
            _ => {
                let offset = self.ahead(part, names)?;
                Some(Leading { offset, negative, place, term: part.clone(), factors: Vec::new() })
            }
        }
    }

    /// How far ahead of the index a term is; none of anything else.
    fn ahead(&mut self, written: &Written, names: &BTreeSet<Name>) -> Option<i64> {
        let call = match &written.kind {
            ValueKind::Name(name) => subscripted(name).map(|(call, _)| call),
            _ => None,
        };
        let ValueKind::Call(name, arguments) = &call.as_ref().unwrap_or(written).kind else { return None };
        let [Argument { label: None, value }] = arguments.as_slice() else { return None };
        if !names.contains(&name.name) {
            return None;
        }
        // What is wrong with an index is said where the term is read.
        let errors = self.errors.len();
        let found = self.place(value);
        self.errors.truncate(errors);
        let (variable, offset) = found?;
        variable.map(|_| offset)
    }
}
