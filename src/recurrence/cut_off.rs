//! `x := min(f(x), b)`, `x := max(f(x), b)` and `x := clamp(f(x), a, b)` where f is affine: growth that bounds cut off. If f
//! keeps the order, and takes b no further back, then what f alone leads to is cut off in the same way: `min(F(n), b)`.

use super::affine::affine_pieces;
use super::interval::Interval;
use super::search::{Entry, enter};
use super::{Closed, Comparison, Motion, Piece, Reach, Unknown};
use crate::assumption::Assumptions;
use crate::name::Name;
use crate::value::{Atom, Relation, Value};

/// The most ways to choose from the maxima of a map.
const MOST_BRANCHES: usize = 30;

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

/// A map that bounds cut off on one side or on both.
struct Bounded {
    free: Value,
    /// The bounds, each with how what is beyond it compares with it.
    bounds: Vec<(Value, Relation)>,
}

impl Bounded {
    fn of(map: &Value, variable: &Name, known: &Assumptions) -> Option<Bounded> {
        if let Some(cut) = Cut::of(map, variable, known) {
            let onward = cut.onward();
            return Some(Bounded { free: cut.free, bounds: vec![(cut.bound, onward)] });
        }
        let folded = |atom: &Atom| matches!(atom, Atom::Maximum(_) | Atom::Positive(_)) && atom.mentions(variable);
        let atoms: Vec<Atom> = map.atoms().into_iter().filter(folded).collect();
        let mut branches = vec![map.clone()];
        for atom in &atoms {
            let Atom::Maximum(elements) = atom else { return None };
            let all = branches.iter().flat_map(|one| {
                let zero = std::iter::once(Value::zero());
                zero.chain(elements.iter().cloned()).map(move |element| one.with_atom(atom, &element))
            });
            branches = all.collect::<Result<_, _>>().ok()?;
            if branches.len() > MOST_BRANCHES {
                return None;
            }
        }
        let (free, fixed): (Vec<Value>, Vec<Value>) = branches.into_iter().partition(|one| one.mentions(variable));
        free.iter().find_map(|free| {
            fixed.iter().find_map(|low| {
                let high = fixed.iter().find(|high| {
                    let ordered = known.decide(Relation::Lte, low, high) == Some(true);
                    let same = |cut: Value| known.decide(Relation::Eq, &cut, map) == Some(true);
                    ordered && between(free, low, high).is_some_and(same)
                })?;
                let bounds = vec![(low.clone(), Relation::Lte), (high.clone(), Relation::Gte)];
                Some(Bounded { free: free.clone(), bounds })
            })
        })
    }
}

/// `clamp(free, low, high)`
fn between(free: &Value, low: &Value, high: &Value) -> Option<Value> {
    let above = Value::maximum(&[free.clone(), low.clone()]).ok()?;
    Value::minimum(&[above, high.clone()]).ok()
}

/// The form of such a map; `None` of any other. A bound from which the map leads back is never met from within.
///
/// # Errors
/// Where it is not known whether the map is one, or what the form of the affine map is.
pub(super) fn cut_off(motion: &Motion<'_>) -> Result<Option<Closed>, Unknown> {
    let Motion { map, variable, start, index, known } = *motion;
    let Some(Bounded { free, bounds }) = Bounded::of(map, variable, known) else { return Ok(None) };
    let Some((slope, _)) = free.linear_in(variable) else { return Ok(None) };
    let (zero, decide) = (Value::zero(), |(relation, left, right): (Relation, &Value, &Value)| {
        known.decide(relation, left, right).ok_or_else(|| Unknown::undecided(relation, left, right))
    });
    // It keeps the order.
    if !decide((Relation::Gte, &slope, &zero))? {
        return Ok(None);
    }
    let mut kept = Vec::new();
    for (bound, onward) in bounds {
        let beyond = free.with(variable, &bound)?.sub(&bound)?;
        if decide((onward, &beyond, &zero))? {
            kept.push((bound, onward));
        } else if !decide((onward.mirrored(), start, &bound))? {
            return Ok(None);
        }
    }
    let (pieces, conditions) = affine_pieces(&free, variable, start, index, known)?;
    let [only] = pieces.as_slice() else { return Ok(None) };
    let cut = |form: Value, (bound, onward): &(Value, Relation)| match onward {
        Relation::Gte => Value::minimum(&[form, bound.clone()]),
        _ => Value::maximum(&[form, bound.clone()]),
    };
    let form = kept.iter().try_fold(only.form.clone(), cut)?;
    let piece = |from: i64, until: Option<i64>, form: &Value| Piece {
        from: Value::integer(from),
        until: until.map(Value::integer),
        form: form.clone(),
    };
    let within = |(bound, onward): &(Value, Relation)| known.decide(onward.mirrored(), start, bound) == Some(true);
    let pieces = if kept.iter().all(within) {
        vec![piece(0, None, &form)]
    } else {
        vec![piece(0, Some(1), start), piece(1, None, &form)]
    };
    Ok(Some(Closed { variable: variable.clone(), pieces, conditions }))
}
