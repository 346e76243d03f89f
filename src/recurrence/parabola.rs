//! The first index at which a sequence that is quadratic in it, symbols included, gets past a bound.

use crate::assumption::Assumptions;
use crate::closed_form::{Piece, with_known_parts};
use crate::name::Name;
use crate::value::{Atom, Relation, Value, ValueError};

use super::Reach;

/// The first index at which a value compares with 0, where its forms are linear or quadratic piece by piece, and each begins on
/// the other side: one that bends this way is there behind the greater of its roots, and between its ends it is nowhere greater
/// than at both of them. One that bends the other way is there behind the lesser, if it has not turned back before. Below 0 for
/// ever where nothing of one whole form rises.
pub(super) fn past(pieces: &[Piece], index: &Name, relation: Relation, known: &Assumptions) -> Option<Reach> {
    let above = upwards(relation)?;
    let side = |form: &Value| if above == relation { Ok(form.clone()) } else { form.neg() };
    if pieces.len() > MOST_PIECES || pieces.first().is_none_or(|piece| !piece.from.is_zero()) {
        return None;
    }
    let mut begins_below = false;
    for (place, piece) in pieces.iter().enumerate() {
        let form = side(&known.with_equations(piece.form.clone())).ok()?;
        let start = form.with(index, &piece.from).ok()?;
        let decided = |value: &Value, relation| decided(relation, value, known);
        let [constant, linear, square] = coefficients(&form, index).ok().flatten()?;
        let below = std::mem::take(&mut begins_below);
        match decided(&start, above.negated()) {
            Some(true) => {}
            None if below => {}
            None if place == 0 => return asked(above, &start, &square, known),
            _ => return None,
        }
        // Of one line the shape says more.
        if pieces.len() == 1 && square.is_zero() {
            return None;
        }
        if square.is_zero() && linear.is_zero() {
            match piece.until {
                Some(_) => continue,
                None => return Some(Reach::Never(format!("it stays {}", piece.form))),
            }
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
        let last = match pieces.get(place + 1) {
            None => None,
            Some(next) => Some(last_told(piece, &form, &side(&next.form).ok()?, index, known)?),
        };
        let curve = Curve { form: &form, coefficients: [&constant, &linear, &square], above, index, known };
        let found = match curve.up_to_rest(piece, &pieces[place + 1..], relation) {
            Some(found) => found,
            None if falls => curve.within(&piece.from, last.as_ref())?,
            None => curve.passed(last.as_ref())?,
        };
        if found.is_some() {
            return found;
        }
        // What is nowhere above 0 is not where the next form begins with the same.
        begins_below = falls && last.is_some() && last == piece.until && curve.is_bare();
    }
    None
}

/// The relation, or that of the opposites of both sides.
fn upwards(relation: Relation) -> Option<Relation> {
    match relation {
        Relation::Gtr | Relation::Gte => Some(relation),
        Relation::Lss | Relation::Lte => Some(relation.mirrored()),
        Relation::Eq | Relation::Neq => None,
    }
}

/// Whether all of these pieces, at least one, in which nothing moves, are there, or none is; else what would have to be known.
fn stands(pieces: &[Piece], index: &Name, relation: Relation, known: &Assumptions) -> Option<Result<bool, Reach>> {
    if pieces.iter().any(|piece| piece.form.mentions(index)) {
        return None;
    }
    let mut told = Vec::new();
    for piece in pieces {
        match decided(relation, &piece.form, known) {
            Some(holds) => told.push(holds),
            None => return Some(Err(Reach::undecided(relation, &piece.form, &Value::zero()))),
        }
    }
    told.dedup();
    if let [holds] = told.as_slice() { Some(Ok(*holds)) } else { None }
}

/// How a value compares with 0, where what is rounded in it may be known.
fn decided(relation: Relation, value: &Value, known: &Assumptions) -> Option<bool> {
    let zero = Value::zero();
    let plainly = known.decide(relation, value, &zero);
    plainly.or_else(|| known.decide(relation, &with_known_parts(value, known)?, &zero))
}

/// The last index of which the form of a piece tells: the one behind it, where the next form gives the same, else its own last.
fn last_told(piece: &Piece, form: &Value, next: &Value, index: &Name, known: &Assumptions) -> Option<Value> {
    let until = piece.until.as_ref()?;
    let (end, other) = (form.with(index, until).ok()?, next.with(index, until).ok()?);
    let same =
        known.simplify(&end.sub(&other).ok()?).is_zero() || known.decide(Relation::Eq, &end, &other) == Some(true);
    if same { Some(until.clone()) } else { until.sub(&Value::one()).ok() }
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

/// A parabola, or a line.
struct Curve<'a> {
    form: &'a Value,
    coefficients: [&'a Value; 3],
    above: Relation,
    index: &'a Name,
    known: &'a Assumptions,
}

impl Curve<'_> {
    /// What stands under the root in its roots.
    fn under(&self) -> Option<Value> {
        let [constant, linear, square] = self.coefficients;
        linear.mul(linear).ok()?.sub(&square.mul(constant).ok()?.mul(&Value::integer(4)).ok()?).ok()
    }

    /// Whether it has none.
    fn is_bare(&self) -> bool {
        self.under().is_some_and(|under| decided(Relation::Lss, &under, self.known) == Some(true))
    }

    /// The first index at which one that bends upwards, or rises, is above 0, before the last of which it tells: behind the greater of
    /// its roots. `Some(None)`: it is not up to the last.
    fn passed(&self, last: Option<&Value>) -> Option<Option<Reach>> {
        let [constant, linear, square] = self.coefficients.map(Value::clone);
        let behind = behind(&[constant, linear, square], self.above, self.known);
        let behind = || Some(Reach::At(self.known.simplify(behind.as_ref().ok()?), Vec::new()));
        let Some(last) = last else { return behind().map(Some) };
        let end = self.form.with(self.index, last).ok()?;
        Some(match decided(self.above, &end, self.known) {
            Some(true) => Some(behind()?),
            Some(false) => None,
            None => Some(Reach::undecided(self.above, &end, &Value::zero())),
        })
    }

    /// Of one that bends downwards the first index, from the start of its piece on and up to the last of which it tells, at which it
    /// is above 0: behind the lesser of its roots, if it is above 0 there still, and rises at the start. `Some(None)`: it rises up to
    /// the last, and is not.
    fn within(&self, from: &Value, last: Option<&Value>) -> Option<Option<Reach>> {
        let zero = Value::zero();
        let decided = |relation: Relation, value: &Value| decided(relation, value, self.known);
        let at = |index: &Value| self.form.with(self.index, index).ok();
        let [constant, linear, square] = self.coefficients;
        let under = self.under()?;
        let bare = decided(Relation::Lss, &under);
        if let Some(last) = last {
            let end = at(last)?;
            match decided(self.above, &end) {
                // It turns back before it comes so far.
                _ if bare == Some(true) => return Some(None),
                None if bare.is_none() => return Some(Some(Reach::undecided(Relation::Gte, &under, &zero))),
                Some(true) => {}
                Some(false) => {
                    let step = end.sub(&at(&last.sub(&Value::one()).ok()?)?).ok()?;
                    let rises = || decided(Relation::Gte, &step) == Some(true);
                    return (rises() || self.is_nowhere_within(from, last)).then_some(None);
                }
                None => return Some(Some(Reach::undecided(self.above, &end, &zero))),
            }
        } else {
            // Where it is above 0 at the end it rises at the start.
            let slope = square.mul(from).and_then(|half| half.add(&half)).and_then(|twice| twice.add(linear)).ok()?;
            match decided(Relation::Gtr, &slope) {
                Some(true) => {}
                Some(false) => return Some(Some(Reach::Never("it moves away from where it begins".to_string()))),
                None => return Some(Some(Reach::undecided(Relation::Gtr, &slope, &zero))),
            }
        }
        match decided(Relation::Gte, &under) {
            Some(true) => {}
            Some(false) => return Some(Some(Reach::Never("it turns back before it comes so far".to_string()))),
            None => return Some(Some(Reach::undecided(Relation::Gte, &under, &zero))),
        }
        let first = self
            .known
            .simplify(&behind(&[constant.clone(), linear.clone(), square.clone()], self.above, self.known).ok()?);
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

    /// The same where it is not known whether it is above 0 at the last index of its piece, behind which nothing moves. `Some(None)`:
    /// it is not up to there.
    fn up_to_rest(&self, piece: &Piece, later: &[Piece], relation: Relation) -> Option<Option<Reach>> {
        let (zero, two) = (Value::zero(), Value::integer(2));
        let [constant, linear, square] = self.coefficients;
        let until = piece.until.as_ref()?;
        let end = self.form.with(self.index, &until.sub(&Value::one()).ok()?).ok()?;
        if decided(self.above, &end, self.known).is_some() {
            return None;
        }
        let at_rest = stands(later, self.index, relation, self.known)?;
        let falls = decided(Relation::Lss, square, self.known) == Some(true);
        let slope = square.mul(&piece.from).ok()?.mul(&two).ok()?.add(linear).ok()?;
        let under = self.under()?;
        for (relation, value) in [(Relation::Gtr, &slope), (Relation::Gte, &under)].into_iter().filter(|_| falls) {
            match decided(relation, value, self.known) {
                Some(true) => {}
                // It only falls, or turns back before it comes so far.
                Some(false) => return Some(None),
                None => return Some(Some(Reach::undecided(relation, value, &zero))),
            }
        }
        let holds_at_rest = match at_rest {
            Ok(holds) => holds,
            Err(open) => return Some(Some(open)),
        };
        let all = [constant.clone(), linear.clone(), square.clone()];
        let root = self.known.simplify(&crossing(&all, self.known).ok()?);
        if !falls {
            return self.behind_it(&root, until, holds_at_rest);
        }
        // Both roots together are -b/a.
        let greater = self.known.simplify(&linear.div(square).ok()?.neg().ok()?.sub(&root).ok()?);
        self.between([&root, &greater], until, holds_at_rest)
    }

    /// Of one that bends upwards, or rises: behind its greater root, which comes before the end of the piece if it is above 0 at rest.
    fn behind_it(&self, root: &Value, until: &Value, holds_at_rest: bool) -> Option<Option<Reach>> {
        if holds_at_rest {
            return Some(Some(Reach::At(self.not_behind(root, until)?, Vec::new())));
        }
        let last = until.sub(&Value::one()).ok()?;
        let beyond = if self.above == Relation::Gte { Relation::Gtr } else { Relation::Gte };
        (self.known.decide(beyond, root, &last) == Some(true)).then_some(None)
    }

    /// Of one that bends downwards: behind its lesser root; where it is not above 0 at rest, and so again before the piece ends, if it
    /// is there before the greater one.
    fn between(&self, [lesser, greater]: [&Value; 2], until: &Value, holds_at_rest: bool) -> Option<Option<Reach>> {
        let surely =
            |relation: Relation, one: &Value, other: &Value| self.known.decide(relation, one, other) == Some(true);
        if holds_at_rest {
            let to_the_end = surely(Relation::Gtr, greater, &until.sub(&Value::one()).ok()?);
            return to_the_end.then(|| Some(Some(Reach::At(self.not_behind(lesser, until)?, Vec::new())))).flatten();
        }
        if !surely(Relation::Lss, greater, until) {
            return None;
        }
        let first = self.rounded(lesser)?;
        let before = if self.above == Relation::Gte { Relation::Lte } else { Relation::Lss };
        Some(Some(match self.known.decide(before, &first, greater) {
            Some(true) => Reach::At(first, Vec::new()),
            Some(false) => Reach::Never(format!("it turns back between {} = {first} and the one before", self.index)),
            None => Reach::At(first.clone(), vec![(before, first, greater.clone())]),
        }))
    }

    /// The first index behind a root, if it is known not to be behind this one.
    fn not_behind(&self, root: &Value, until: &Value) -> Option<Value> {
        let first = self.rounded(root)?;
        is_not_behind((root, &first), until, self.above == Relation::Gte, self.known).then_some(first)
    }

    /// The first index behind a root, or at it where that counts.
    fn rounded(&self, root: &Value) -> Option<Value> {
        let first = match self.above {
            Relation::Gte => root.ceiling(),
            _ => root.floor().and_then(|whole| whole.add(&Value::one())),
        };
        Some(self.known.simplify(&first.ok()?))
    }

    /// Whether it is at no index from one to another.
    fn is_nowhere_within(&self, from: &Value, last: &Value) -> bool {
        let (index, mut known) = (Value::variable(self.index), self.known.clone());
        known.assume(Relation::Gte, &index, from);
        known.assume(Relation::Lte, &index, last);
        known.decide(self.above, self.form, &Value::zero()) == Some(false)
    }
}

/// Whether the first index behind a root, or at it where that counts, is known not to be behind another: where that is `ceil(X)`, if the
/// root is not behind X.
pub(super) fn is_not_behind((root, first): (&Value, &Value), until: &Value, counts: bool, known: &Assumptions) -> bool {
    let before = if counts { Relation::Lte } else { Relation::Lss };
    known.decide(Relation::Lte, first, until) == Some(true)
        || before_rounding(until).is_some_and(|exact| known.decide(before, root, &exact) == Some(true))
}

/// X of `ceil(X)`.
pub(super) fn before_rounding(index: &Value) -> Option<Value> {
    let opposite = index.neg().ok()?;
    opposite.atoms().into_iter().find_map(|atom| match &atom {
        Atom::Floor(inner) if atom.value().is_ok_and(|value| value == opposite) => inner.neg().ok(),
        _ => None,
    })
}

/// The most pieces that are looked at.
const MOST_PIECES: usize = 4;

/// The coefficients of `c + b*n + a*n^2`; none of another form.
pub(super) fn coefficients(form: &Value, index: &Name) -> Result<Option<[Value; 3]>, ValueError> {
    let at = |number: i64| form.with(index, &Value::integer(number));
    let (zeroth, first, second) = (at(0)?, at(1)?, at(2)?);
    let square = second.sub(&first)?.sub(&first)?.add(&zeroth)?.div(&Value::integer(2))?;
    let linear = first.sub(&zeroth)?.sub(&square)?;
    let n = Value::variable(index);
    let whole = square.mul(&n)?.add(&linear)?.mul(&n)?.add(&zeroth)?;
    Ok((whole == *form).then_some([zeroth, linear, square]))
}

/// The first index behind a crossing, or at it where that counts.
fn behind(all: &[Value; 3], relation: Relation, known: &Assumptions) -> Result<Value, ValueError> {
    let root = crossing(all, known)?;
    match relation {
        Relation::Gte => root.ceiling(),
        _ => root.floor()?.add(&Value::one()),
    }
}

/// The root `(-b + sqrt(b^2 - 4*a*c)) / (2*a)`, the greater one for a above 0 and else the lesser, or that of a line, `-c/b`.
fn crossing([constant, linear, square]: &[Value; 3], known: &Assumptions) -> Result<Value, ValueError> {
    if square.is_zero() {
        return constant.neg()?.div(linear);
    }
    let under = linear.mul(linear)?.sub(&square.mul(constant)?.mul(&Value::integer(4))?)?;
    root_of(&under, known)?.sub(linear)?.div(&square.mul(&Value::integer(2))?)
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
