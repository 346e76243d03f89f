//! The first index at which a sequence that is quadratic in it, symbols included, gets past a bound.

use crate::assumption::Assumptions;
use crate::closed_form::{Piece, with_known_parts};
use crate::name::Name;
use crate::value::{Atom, Relation, Value, ValueError};

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
        let form = side(&known.with_equations(piece.form.clone())).ok()?;
        let start = form.with(index, &piece.from).ok()?;
        let decided = |value: &Value, relation| {
            let plainly = known.decide(relation, value, &zero);
            plainly.or_else(|| known.decide(relation, &with_known_parts(value, known)?, &zero))
        };
        let [constant, linear, square] = coefficients(&form, index).ok().flatten()?;
        match decided(&start, above.negated()) {
            Some(true) => {}
            None if place == 0 => return asked(above, &start, &square, known),
            _ => return None,
        }
        // Of one line the shape says more.
        if pieces.len() == 1 && square.is_zero() {
            return None;
        }
        let is = |relation, value: &Value| decided(value, relation) == Some(true);
        // No step is greater than the first one.
        if pieces.len() == 1 && is(Relation::Lte, &square) && is(Relation::Lte, &square.add(&linear).ok()?) {
            let way = if above == relation { "rise" } else { "fall" };
            return Some(Reach::Never(format!("it does not {way} from where it begins")));
        }
        let rises = is(Relation::Gtr, &square) || square.is_zero() && is(Relation::Gtr, &linear);
        let falls = is(Relation::Lss, &square);
        if !rises && !falls {
            return bend(&square, known).filter(|_| place == 0);
        }
        // Up to the index behind the piece, where its form holds there still.
        let last = match piece.until.as_ref().zip(pieces.get(place + 1)) {
            None => None,
            Some((until, next)) => {
                let (end, other) = (form.with(index, until).ok()?, side(&next.form.with(index, until).ok()?).ok()?);
                let same = known.simplify(&end.sub(&other).ok()?).is_zero()
                    || known.decide(Relation::Eq, &end, &other) == Some(true);
                Some(if same { until.clone() } else { until.sub(&Value::one()).ok()? })
            }
        };
        if falls {
            let curve = Curve { form: &form, coefficients: [&constant, &linear, &square], above, index, known };
            match curve.within(&piece.from, last.as_ref())? {
                Some(found) => return Some(found),
                None => continue,
            }
        }
        let behind = || Some(Reach::At(known.simplify(&behind(&[constant, linear, square], above, known).ok()?), Vec::new()));
        let Some(last) = last else { return behind() };
        let end = form.with(index, &last).ok()?;
        match decided(&end, above) {
            Some(true) => return behind(),
            Some(false) => {}
            None => return Some(Reach::undecided(above, &end, &zero)),
        }
    }
    None
}

/// Where a parabola begins, if it bends; else whether it does.
fn asked(above: Relation, start: &Value, square: &Value, known: &Assumptions) -> Option<Reach> {
    let zero = Value::zero();
    if known.decide(Relation::Neq, square, &zero) == Some(true) {
        return Some(Reach::undecided(above, start, &zero));
    }
    bend(square, known)
}

/// Which way a parabola bends, where that is not known: of a square, or a sum of some, whether a part of it is 0.
fn bend(square: &Value, known: &Assumptions) -> Option<Reach> {
    let zero = Value::zero();
    let open = |relation: Relation, part: &Value| known.decide(relation, part, &zero).is_none();
    if known.decide(Relation::Gte, square, &zero) == Some(true) {
        let part = square.squares()?.into_iter().find(|part| open(Relation::Eq, part))?;
        return Some(Reach::undecided(Relation::Eq, &part, &zero));
    }
    [Relation::Gtr, Relation::Eq]
        .into_iter()
        .find(|relation| open(*relation, square))
        .map(|relation| Reach::undecided(relation, square, &zero))
}

/// What rises less and less, and then falls.
struct Curve<'a> {
    form: &'a Value,
    coefficients: [&'a Value; 3],
    above: Relation,
    index: &'a Name,
    known: &'a Assumptions,
}

impl Curve<'_> {
    /// The first index, from the start of its piece on and up to the last of which it tells, at which it is above 0: behind the
    /// lesser of its roots, if it is above 0 there still, and rises at the start. `Some(None)`: it rises up to the last, and is not.
    fn within(&self, from: &Value, last: Option<&Value>) -> Option<Option<Reach>> {
        let zero = Value::zero();
        let decided = |relation: Relation, value: &Value| {
            let plainly = self.known.decide(relation, value, &zero);
            plainly.or_else(|| self.known.decide(relation, &with_known_parts(value, self.known)?, &zero))
        };
        let at = |index: &Value| self.form.with(self.index, index).ok();
        let [constant, linear, square] = self.coefficients;
        if let Some(last) = last {
            let end = at(last)?;
            match decided(self.above, &end) {
                Some(true) => {}
                Some(false) => {
                    let step = end.sub(&at(&last.sub(&Value::one()).ok()?)?).ok()?;
                    return (decided(Relation::Gte, &step) == Some(true)).then_some(None);
                }
                None => return Some(Some(Reach::undecided(self.above, &end, &zero))),
            }
        }
        // Where it is above 0 at the end it rises at the start.
        if last.is_none() {
            let slope = square.mul(from).and_then(|half| half.add(&half)).and_then(|twice| twice.add(linear)).ok()?;
            match decided(Relation::Gtr, &slope) {
                Some(true) => {}
                Some(false) => return Some(Some(Reach::Never("it moves away from where it begins".to_string()))),
                None => return Some(Some(Reach::undecided(Relation::Gtr, &slope, &zero))),
            }
        }
        let under = linear.mul(linear).ok()?.sub(&square.mul(constant).ok()?.mul(&Value::integer(4)).ok()?).ok()?;
        match decided(Relation::Gte, &under) {
            Some(true) => {}
            Some(false) => return Some(Some(Reach::Never("it turns back before it comes so far".to_string()))),
            None => return Some(Some(Reach::undecided(Relation::Gte, &under, &zero))),
        }
        let first = self.known.simplify(&behind(&[constant.clone(), linear.clone(), square.clone()], self.above, self.known).ok()?);
        // Up to a last one at which it is above 0 it is so from there on.
        if last.is_some() {
            return Some(Some(Reach::At(first, Vec::new())));
        }
        let there = self.known.simplify(&at(&first)?);
        Some(Some(match decided(self.above, &there) {
            Some(true) => Reach::At(first, Vec::new()),
            Some(false) => Reach::Never(format!("it turns back between {} = {first} and the one before", self.index)),
            None => Reach::At(first, vec![(self.above, there, zero)]),
        }))
    }
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

/// The first index behind the root `(-b + sqrt(b^2 - 4*a*c)) / (2*a)`, the greater one for a above 0 and else the lesser, or
/// that of a line, `-c/b`.
fn behind(
    [constant, linear, square]: &[Value; 3],
    relation: Relation,
    known: &Assumptions,
) -> Result<Value, ValueError> {
    let root = if square.is_zero() {
        constant.neg()?.div(linear)?
    } else {
        let under = linear.mul(linear)?.sub(&square.mul(constant)?.mul(&Value::integer(4))?)?;
        root_of(&under, known)?.sub(linear)?.div(&square.mul(&Value::integer(2))?)?
    };
    match relation {
        Relation::Gte => root.ceiling(),
        _ => root.floor()?.add(&Value::one()),
    }
}

/// The root of a value, with names that are not 0 and stand in it as squares before it: `v*sqrt(100-q^2)` of `100*v^2-q^2*v^2`.
fn root_of(value: &Value, known: &Assumptions) -> Result<Value, ValueError> {
    let (mut inner, mut before) = (value.clone(), Value::one());
    let shared = value.polynomials().map(|(top, _)| top.monomial_content());
    for (atom, exponent) in shared.iter().flat_map(|shared| shared.factors()) {
        let Atom::Variable(name) = atom else { continue };
        let name = Value::variable(name);
        if known.decide(Relation::Neq, &name, &Value::zero()) == Some(true) {
            for _ in 0..exponent / 2 {
                inner = inner.div(&name.mul(&name)?)?;
                before = before.mul(&known.simplify(&name.abs()?))?;
            }
        }
    }
    inner.sqrt()?.mul(&before)
}
