//! The powers of one number in a piece as what such a power is since the piece began, which lies between 0 and 1 where they
//! fall: what is linear in it stands to 0 as it does at both ends.

use crate::assumption::Assumptions;
use crate::closed_form::Piece;
use crate::exponential_polynomial::exponentials;
use crate::name::Name;
use crate::value::{Atom, Relation, Value};

use num_rational::BigRational;

/// What such a power is called where it is above 0 and at most 1.
const FALLS: &str = "[fallen]";

/// Values of a piece whose form has the powers of one number with another name for what such a power is since the piece
/// began, `(3/4)^(n-from)`, which is at most 1, or at least 1: so they have no powers, of which each prime is one of its own.
pub(super) fn since_the_start(
    values: &[&Value; 2],
    piece: &Piece,
    index: &Name,
    known: &mut Assumptions,
) -> Option<[Value; 2]> {
    let one = Value::one();
    let bases = exponentials(&piece.form, index)?.into_keys().filter(|base| *base != one);
    let [base] = bases.collect::<Vec<_>>().try_into().ok()?;
    let (base, exponent) = least_root(base);
    let surely = |relation, bound: &Value| known.decide(relation, &base, bound) == Some(true);
    let falls = surely(Relation::Lte, &one);
    if !surely(Relation::Gtr, &Value::zero()) || !(falls || surely(Relation::Gte, &one)) {
        return None;
    }
    let power = base.power(&Value::variable(index)).ok()?;
    let since = Value::variable(&Name::new(if falls { FALLS } else { "[since]" }));
    let whole = since.mul(&base.power(&piece.from).ok()?).ok()?;
    // The power is a product of powers of primes, of which one is then what the others leave.
    let mark = Name::new("[prime]");
    let left_by_others = |prime: Atom| {
        let marked = power.with_atom(&prime, &Value::variable(&mark)).ok()?;
        let image = if let Some((factor, _)) = marked.linear_in(&mark) {
            whole.div(&factor).ok()?
        } else {
            marked.mul(&Value::variable(&mark)).ok()?.div(&whole).ok()?
        };
        (!image.mentions(&mark)).then_some((prime, image))
    };
    let (prime, image) = power.atoms().into_iter().find_map(left_by_others)?;
    known.assume(Relation::Gtr, &since, &Value::zero());
    let bound = if falls { Relation::Lte } else { Relation::Gte };
    known.assume(bound, &since, &one);
    known.assume(bound, &since.power(&Value::integer(exponent.into())).ok()?, &one);
    let put = |value: &Value| value.replace(&mut |atom| (*atom == prime).then(|| image.clone())).ok();
    Some([put(values[0])?, put(values[1])?])
}

/// 2/3 and 3 of 8/27: the number of which this is a power, and which.
fn least_root(base: Value) -> (Value, u32) {
    let Some(number) = base.as_rational() else { return (base, 1) };
    let root = |exponent: u32| {
        let root = BigRational::new(number.numer().nth_root(exponent), number.denom().nth_root(exponent));
        (root.pow(exponent as i32) == number).then(|| (Value::rational(root), exponent))
    };
    (2..=MOST_ROOT).rev().filter(|_| number > BigRational::from_integer(0.into())).find_map(root).unwrap_or((base, 1))
}

/// The highest root of a base that is looked for.
const MOST_ROOT: u32 = 6;

/// How a value stands to 0 that is linear in what has fallen since a piece began: as where that is 1, if it does not stand
/// otherwise where that is 0.
pub(super) fn on_both_sides(relation: Relation, value: &Value, known: &Assumptions) -> Option<bool> {
    let fallen = Name::new(FALLS);
    let (factor, least) = value.mentions(&fallen).then(|| value.linear_in(&fallen))??;
    let (most, zero) = (factor.add(&least).ok()?, Value::zero());
    if factor.mentions(&fallen) || least.mentions(&fallen) {
        return None;
    }
    let is = |relation, value: &Value| known.decide(relation, value, &zero) == Some(true);
    match relation {
        Relation::Gte | Relation::Gtr if is(relation, &most) && is(Relation::Gte, &least) => Some(true),
        Relation::Gtr if is(Relation::Lte, &most) && is(Relation::Lte, &least) => Some(false),
        _ => None,
    }
}
