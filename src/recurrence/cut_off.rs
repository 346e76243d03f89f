//! `x := min(f(x), b)` and `x := max(f(x), b)` where f is affine: growth that a bound cuts off. If f keeps the order, and
//! takes b no further back, then what f alone leads to is cut off in the same way: `min(F(n), b)`.

use super::affine::affine_pieces;
use super::interval::Interval;
use super::search::{Entry, enter};
use super::{Closed, Comparison, Motion, Piece, Reach, Unknown};
use crate::assumption::Assumptions;
use crate::name::Name;
use crate::value::{Atom, Relation, Value};

/// The lesser or the greater of two values of which one alone reads a variable.
pub(super) struct Cut {
    /// The one that reads it.
    free: Value,
    bound: Value,
    /// Whether it is the lesser.
    least: bool,
}

impl Cut {
    /// A value as one that is cut off, if it is.
    pub(super) fn of(value: &Value, variable: &Name, known: &Assumptions) -> Option<Cut> {
        let folded = |atom: &Atom| matches!(atom, Atom::Maximum(_) | Atom::Positive(_)) && atom.mentions(variable);
        let atoms: Vec<Atom> = value.atoms().into_iter().filter(folded).collect();
        let [atom @ Atom::Maximum(elements)] = atoms.as_slice() else { return None };
        let [inner] = &**elements else { return None };
        let name = Name::new("[maximum]");
        let (factor, one) = value.with_atom(atom, &Value::variable(&name)).ok()?.linear_in(&name)?;
        let least = known.decide(Relation::Lss, &factor, &Value::zero()) == Some(true);
        if !least && known.decide(Relation::Gtr, &factor, &Value::zero()) != Some(true) {
            return None;
        }
        // a + c*max(0, e) is the greater of a and a + c*e, or the lesser of them where c is negative.
        let other = one.add(&factor.mul(inner).ok()?).ok()?;
        match (one.mentions(variable), other.mentions(variable)) {
            (true, false) => Some(Cut { free: one, bound: other, least }),
            (false, true) => Some(Cut { free: other, bound: one, least }),
            _ => None,
        }
    }

    /// How what is beyond the bound compares with it.
    fn onward(&self) -> Relation {
        if self.least { Relation::Gte } else { Relation::Lte }
    }

    fn with(&self, free: &Value) -> Option<Value> {
        let both = [free.clone(), self.bound.clone()];
        if self.least { Value::minimum(&both).ok() } else { Value::maximum(&both).ok() }
    }

    /// That the bound lies on the right side of one that bounds an interval from below, or from above.
    fn asked(&self, low: bool, (value, strict): &(Value, bool)) -> Comparison {
        let relation = match (low, strict) {
            (true, true) => Relation::Gtr,
            (true, false) => Relation::Gte,
            (false, true) => Relation::Lss,
            (false, false) => Relation::Lte,
        };
        // `l >= 50`, not `l-50 >= 0`.
        let constant = self.bound.polynomials().filter(|(_, below)| below.is_one());
        let constant = constant.map_or_else(Value::zero, |(above, _)| Value::rational(above.constant_term()));
        match (self.bound.sub(&constant), value.sub(&constant)) {
            (Ok(bound), Ok(value)) if !bound.is_zero() => (relation, bound, value),
            _ => (relation, self.bound.clone(), value.clone()),
        }
    }

    /// When the value lies in an interval first, from when the one that is not cut off lies in one.
    ///
    /// # Errors
    /// As [`enter`].
    pub(super) fn enter(&self, entry: &Entry<'_>) -> Result<Reach, Unknown> {
        // Of the lesser of two values both must be above what bounds it from below, and one below what bounds it from above.
        let (of_both, of_one) = (entry.interval.bound(self.least), entry.interval.bound(!self.least));
        let asked = |low: bool, side| self.asked(low, side);
        let decided = |(relation, left, right): &Comparison| entry.known.decide(*relation, left, right);
        let mut conditions = Vec::new();
        if let Some(needed) = of_both.map(|side| asked(self.least, side)) {
            match decided(&needed) {
                Some(true) => {}
                Some(false) => {
                    let side = if self.least { "more" } else { "less" };
                    return Ok(Reach::Never(format!("{} is never {side} than {}", entry.form, self.bound)));
                }
                None => conditions.push(needed),
            }
        }
        let other = match of_one.map(|side| asked(!self.least, side)) {
            None => None,
            Some(beyond) => match decided(&beyond) {
                Some(true) => None,
                Some(false) => of_one.cloned(),
                None => {
                    let (relation, left, right) = beyond;
                    return Ok(Reach::undecided(relation, &left, &right));
                }
            },
        };
        let interval = Interval::of_bounds(self.least, of_both.cloned(), other);
        let free = Entry { value: self.free.clone(), interval, ..*entry };
        match enter(&free) {
            Ok(Reach::At(at, more)) => Ok(Reach::At(at, conditions.into_iter().chain(more).collect())),
            // What is not known of the bound may keep it from where the other comes, and brings it nowhere else.
            found => found,
        }
    }
}

/// The form of such a map; `None` of any other.
///
/// # Errors
/// Where it is not known whether the map is one, or what the form of the affine map is.
pub(super) fn cut_off(motion: &Motion<'_>) -> Result<Option<Closed>, Unknown> {
    let Motion { map, variable, start, index, known } = *motion;
    let Some(cut) = Cut::of(map, variable, known) else { return Ok(None) };
    let Some((slope, _)) = cut.free.linear_in(variable) else { return Ok(None) };
    // It keeps the order, and takes the bound no further back.
    let (beyond, zero) = (cut.free.with(variable, &cut.bound)?.sub(&cut.bound)?, Value::zero());
    for (relation, value) in [(Relation::Gte, slope), (cut.onward(), beyond)] {
        match known.decide(relation, &value, &zero) {
            Some(true) => {}
            Some(false) => return Ok(None),
            None => return Err(Unknown::undecided(relation, &value, &zero)),
        }
    }
    let (pieces, conditions) = affine_pieces(&cut.free, variable, start, index, known)?;
    let [only] = pieces.as_slice() else { return Ok(None) };
    let Some(form) = cut.with(&only.form) else { return Ok(None) };
    let within = cut.onward().mirrored();
    let piece = |from: i64, until: Option<i64>, form: &Value| Piece {
        from: Value::integer(from),
        until: until.map(Value::integer),
        form: form.clone(),
    };
    let pieces = if known.decide(within, start, &cut.bound) == Some(true) {
        vec![piece(0, None, &form)]
    } else {
        vec![piece(0, Some(1), start), piece(1, None, &form)]
    };
    Ok(Some(Closed { variable: variable.clone(), pieces, conditions }))
}
