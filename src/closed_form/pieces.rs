//! The induction for a form by pieces: within each piece, and from one to the next.

use num_rational::BigRational;
use num_traits::{Signed, Zero};

use super::check::{Induction, failed};
use super::{Piece, Unchecked};
use crate::assumption::Assumptions;
use crate::exponential_polynomial::exponentials;
use crate::name::Name;
use crate::value::{Atom, Relation, Value};

impl Induction<'_> {
    pub(super) fn pieces(&mut self, pieces: &[Piece]) -> Result<(), Unchecked> {
        let [sequence] = self.recurrence.sequences.as_slice() else {
            return Err(failed("a form by pieces is of one sequence"));
        };
        let ([start], Some(first)) = (sequence.start.as_slice(), pieces.first()) else {
            return Err(failed("a form by pieces begins with one value"));
        };
        let index = &self.recurrence.index;
        let term = self.recurrence.term(&sequence.name, 0);
        if first.from != Value::integer(self.recurrence.from)
            || !self.same(&first.form.with(index, &first.from)?, start)
        {
            return Err(failed("the form does not give the starting value"));
        }
        let count = Value::variable(index);
        let after = count.add(&Value::one())?;
        for (place, piece) in pieces.iter().enumerate() {
            let inside = piece.form.with(index, &after)?;
            let follows = |until: &Value| self.defined.known().decide(Relation::Lss, &piece.from, until) == Some(true);
            if !piece.until.as_ref().is_none_or(follows) {
                return Err(Unchecked(format!("it is not known that the piece from {} is not empty", piece.from)));
            }
            let last = match (&piece.until, pieces.get(place + 1)) {
                (None, None) => None,
                (Some(until), Some(next)) if *until == next.from => Some((until.sub(&Value::one())?, next)),
                _ => return Err(failed("the pieces have gaps")),
            };
            // Within the piece: from its first index to the one before its last.
            let mut known = self.defined.known().clone();
            known.assume(Relation::Gte, &count, &piece.from);
            if let Some((last, _)) = &last {
                known.assume(Relation::Lss, &count, last);
            }
            let image = sequence.next.with(&term, &piece.form)?;
            let only = last.as_ref().is_some_and(|(last, _)| *last == piece.from);
            if !only && !same_throughout(&image, &inside, piece, index, &known)? {
                return Err(Unchecked(format!("the step within the piece from {} could not be checked", piece.from)));
            }
            // From its last index to the next piece.
            if let Some((last, next)) = last {
                let image = sequence.next.with(index, &last)?.with(&term, &piece.form.with(index, &last)?)?;
                let first = next.form.with(index, &next.from)?;
                if !self.same(&image, &first) {
                    return Err(Unchecked(format!("{image} at {} is not known to be {first}", next.from)));
                }
            }
        }
        Ok(())
    }

    /// Whether two values are equal for all indices from one on.
    pub(super) fn same_since(&self, left: &Value, right: &Value, since: i64) -> Result<bool, Unchecked> {
        let (index, from) = (&self.recurrence.index, Value::integer(since));
        let mut known = self.defined.known().clone();
        known.assume(Relation::Gte, &Value::variable(index), &from);
        same_throughout(left, right, &Piece { from, until: None, form: left.clone() }, index, &known)
    }
}

/// Whether two values are equal for all indices of a piece. A power of a number above 1 is known to grow, and
/// `(-1)^n` is looked at as 1 and as -1.
fn same_throughout(
    left: &Value,
    right: &Value,
    piece: &Piece,
    index: &Name,
    known: &Assumptions,
) -> Result<bool, Unchecked> {
    if left == right {
        return Ok(true);
    }
    let sign = Atom::Power(Value::integer(-1), Value::variable(index));
    let mut known = known.clone();
    let mut bases = std::collections::BTreeSet::new();
    collect_bases(left, index, &mut bases);
    collect_bases(right, index, &mut bases);
    for base in bases {
        let power = base.power(&Value::variable(index))?;
        if base.as_rational().is_some_and(|base| base > BigRational::from_integer(1.into())) {
            if let Ok(least) = base.power(&piece.from) {
                known.assume(Relation::Gte, &power, &least);
            }
            if let Some(Ok(most)) = piece.until.as_ref().map(|until| base.power(until)) {
                known.assume(Relation::Lte, &power, &most);
            }
        }
    }
    assume_powers(piece, index, &mut known);
    if left.atoms().contains(&sign) || right.atoms().contains(&sign) || nested(left, &sign) {
        for side in [1, -1] {
            let [left, right] = [left, right].map(|value| with_sign(value, index, side));
            let (left, right) = (left?, right?);
            if !same_settled(&left, &right, &known)? {
                return Ok(false);
            }
        }
        return Ok(true);
    }
    same_settled(left, right, &known)
}

/// Of the powers of numbers that a form consists of: those of a number above 1 grow with the index, the others fall.
fn assume_powers(piece: &Piece, index: &Name, known: &mut Assumptions) {
    let one = BigRational::from_integer(1.into());
    for base in exponentials(&piece.form, index).unwrap_or_default().into_keys() {
        let Some(size) = base.as_rational().map(|base| base.abs()).filter(|size| !size.is_zero() && *size != one)
        else {
            continue;
        };
        let base = Value::rational(size.clone());
        let Ok(power) = base.power(&Value::variable(index)) else { continue };
        let (first, last) = if size > one { (Relation::Gte, Relation::Lte) } else { (Relation::Lte, Relation::Gte) };
        if let Ok(bound) = base.power(&piece.from) {
            known.assume(first, &power, &bound);
        }
        if let Some(Ok(bound)) = piece.until.as_ref().map(|until| base.power(until)) {
            known.assume(last, &power, &bound);
        }
    }
}

/// Whether two values are equal, after each maximum and condition has become what it is known to be.
fn same_settled(left: &Value, right: &Value, known: &Assumptions) -> Result<bool, Unchecked> {
    let (left, right) = (settled(left, known)?, settled(right, known)?);
    Ok(left == right || known.decide(Relation::Eq, &left, &right) == Some(true))
}

fn settled(value: &Value, known: &Assumptions) -> Result<Value, Unchecked> {
    let mut result = value.clone();
    for atom in value.atoms() {
        let image = match &atom {
            Atom::Maximum(elements) => {
                let mut all = vec![Value::zero()];
                for element in elements.iter() {
                    all.push(settled(element, known)?);
                }
                let most = |one: &&Value| all.iter().all(|other| known.decide(Relation::Gte, one, other) == Some(true));
                match all.iter().find(most) {
                    Some(most) => most.clone(),
                    None => continue,
                }
            }
            Atom::Positive(inner) => match known.decide(Relation::Gtr, &settled(inner, known)?, &Value::zero()) {
                Some(holds) => Value::integer(i64::from(holds)),
                None => continue,
            },
            _ => continue,
        };
        result = result.with_atom(&atom, &image)?;
    }
    Ok(result)
}

/// The rational bases of powers with the index as exponent.
fn collect_bases(value: &Value, index: &Name, found: &mut std::collections::BTreeSet<Value>) {
    for atom in value.atoms().into_iter().filter(|atom| atom.mentions(index)) {
        match &atom {
            Atom::Power(base, exponent) if exponent.as_variable() == Some(index) => {
                found.insert(base.clone());
            }
            Atom::Maximum(elements) => elements.iter().for_each(|element| collect_bases(element, index, found)),
            Atom::Positive(inner) | Atom::Floor(inner) | Atom::Root(inner) => collect_bases(inner, index, found),
            _ => {}
        }
    }
}

fn nested(value: &Value, sign: &Atom) -> bool {
    value.atoms().into_iter().any(|atom| match &atom {
        Atom::Maximum(elements) => elements.iter().any(|element| nested(element, sign)),
        Atom::Positive(inner) => nested(inner, sign),
        other => other == sign,
    })
}

/// A value with `(-1)^n` replaced by 1 or -1.
fn with_sign(value: &Value, index: &Name, side: i64) -> Result<Value, Unchecked> {
    let mut result = value.clone();
    for atom in value.atoms().into_iter().filter(|atom| atom.mentions(index)) {
        let image = match &atom {
            Atom::Power(base, exponent) if *base == Value::integer(-1) && exponent.as_variable() == Some(index) => {
                Value::integer(side)
            }
            Atom::Maximum(elements) => {
                let mut all = vec![Value::zero()];
                for element in elements.iter() {
                    all.push(with_sign(element, index, side)?);
                }
                Value::maximum(&all)?
            }
            Atom::Positive(inner) => Value::truth(Relation::Gtr, &with_sign(inner, index, side)?, &Value::zero())?,
            _ => continue,
        };
        result = result.with_atom(&atom, &image)?;
    }
    Ok(result)
}
