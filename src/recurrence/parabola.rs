//! The first index at which a sequence that is quadratic in it, symbols included, gets past a bound.

use crate::assumption::Assumptions;
use crate::closed_form::{Piece, with_known_parts};
use crate::name::Name;
use crate::value::{Relation, Value, ValueError};

use super::Reach;

/// The first index at which a value compares with 0, where its forms are linear or quadratic piece by piece, each begins on the
/// other side and bends this way, and in the end lies on this one for ever: behind the greater of its roots. Below 0 for ever
/// where nothing of one whole form rises. Between the ends of a piece nothing is greater than at both of them, and each
/// form holds also where the next one begins.
pub(super) fn past(pieces: &[Piece], index: &Name, relation: Relation, known: &Assumptions) -> Option<Reach> {
    let above = match relation {
        Relation::Gtr | Relation::Gte => relation,
        Relation::Lss | Relation::Lte => relation.mirrored(),
        Relation::Eq | Relation::Neq => return None,
    };
    let side = |form: &Value| if above == relation { Ok(form.clone()) } else { form.neg() };
    if pieces.len() > MOST_PIECES || pieces.first().is_none_or(|piece| !piece.from.is_zero()) {
        return None;
    }
    let zero = Value::zero();
    for (place, piece) in pieces.iter().enumerate() {
        let form = side(&piece.form).ok()?;
        let start = form.with(index, &piece.from).ok()?;
        let decided = |value: &Value, relation| {
            let plainly = known.decide(relation, value, &zero);
            plainly.or_else(|| known.decide(relation, &with_known_parts(value, known)?, &zero))
        };
        if decided(&start, above.negated()) != Some(true) {
            return None;
        }
        let [constant, linear, square] = coefficients(&form, index).ok().flatten()?;
        // Of one line the shape says more.
        if pieces.len() == 1 && square.is_zero() {
            return None;
        }
        let is = |relation, value: &Value| decided(value, relation) == Some(true);
        // No step is greater than the first one.
        if pieces.len() == 1 && is(Relation::Lte, &square) && is(Relation::Lte, &square.add(&linear).ok()?) {
            return Some(Reach::Never("it does not rise from where it begins".to_string()));
        }
        let rises = is(Relation::Gtr, &square) || square.is_zero() && is(Relation::Gtr, &linear);
        if !rises {
            return None;
        }
        let behind = || Some(Reach::At(known.simplify(&behind(&[constant, linear, square], above).ok()?), Vec::new()));
        let Some((until, next)) = piece.until.as_ref().zip(pieces.get(place + 1)) else { return behind() };
        let (end, other) = (form.with(index, until).ok()?, side(&next.form.with(index, until).ok()?).ok()?);
        if !known.simplify(&end.sub(&other).ok()?).is_zero() && known.decide(Relation::Eq, &end, &other) != Some(true) {
            return None;
        }
        match decided(&end, above) {
            Some(true) => return behind(),
            Some(false) => {}
            None => return Some(Reach::undecided(above, &end, &zero)),
        }
    }
    None
}

/// The most pieces that are looked at.
const MOST_PIECES: usize = 4;

/// The coefficients of `c + b*n + a*n^2`; none of another form.
fn coefficients(form: &Value, index: &Name) -> Result<Option<[Value; 3]>, ValueError> {
    let at = |number: i64| form.with(index, &Value::integer(number));
    let (zeroth, first, second) = (at(0)?, at(1)?, at(2)?);
    let square = second.sub(&first)?.sub(&first)?.add(&zeroth)?.div(&Value::integer(2))?;
    let linear = first.sub(&zeroth)?.sub(&square)?;
    let n = Value::variable(index);
    let whole = square.mul(&n)?.add(&linear)?.mul(&n)?.add(&zeroth)?;
    Ok((whole == *form).then_some([zeroth, linear, square]))
}

/// The first index behind the greater root, `(-b + sqrt(b^2 - 4*a*c)) / (2*a)`, or that of a line, `-c/b`.
fn behind([constant, linear, square]: &[Value; 3], relation: Relation) -> Result<Value, ValueError> {
    let root = if square.is_zero() {
        constant.neg()?.div(linear)?
    } else {
        let under = linear.mul(linear)?.sub(&square.mul(constant)?.mul(&Value::integer(4))?)?;
        under.sqrt()?.sub(linear)?.div(&square.mul(&Value::integer(2))?)?
    };
    match relation {
        Relation::Gte => root.ceiling(),
        _ => root.floor()?.add(&Value::one()),
    }
}
