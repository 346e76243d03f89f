//! A first index that is rounded, where what is compared is a line in the index, or a square less a bound: it passes the bound
//! behind the greater root, `ceil(E)` or `floor(E)+1`.

use super::first::Question;
use super::stretches::{Compared, Stretch};
use super::whole_parts::{rounded, with_known_parts};
use crate::assumption::Assumptions;
use crate::name::Name;
use crate::value::{Atom, Relation, Value};

impl Question<'_> {
    /// Whether in a stretch it does not hold before the index, as what is compared there has the sign of `n-k-E`, or of
    /// `T(n)^2 - S` for `E = a*sqrt(S)+b` and `T(n) = (n-k-b)/a` with a above 0.
    ///
    /// Before the index `n-k` is below E, so that T is below `sqrt(S)`: where it is not negative its square is below S, and where
    /// it is that is less than at the start, as it rises. At the index it is not below E.
    pub(super) fn behind_the_root(&self, stretch: &Stretch) -> Option<bool> {
        let compared = &self.compared;
        let (from, index_name) = (&stretch.from, &compared.recurrence.index);
        let index = Value::variable(index_name);
        if compared.known.is_natural(&self.at.sub(from).ok()?) != Some(true) {
            return Some(false);
        }
        let (relation, difference) = compared.above_zero(stretch)?;
        let rounded = rounded(self.at).filter(|rounded| rounded.up == (relation == Relation::Gte))?;
        let known = compared.within(stretch, []);
        let positive = |value: &Value| {
            known.gives_meaning(value) && known.decide(Relation::Gtr, value, &Value::zero()) == Some(true)
        };
        let beyond = index.sub(&rounded.rest).ok()?;
        let line = beyond.sub(&rounded.exact).ok()?;
        let defined = || self.defined_at(stretch, self.at, &compared.known);
        if positive(&known.simplify(&line.div(&difference).ok()?)) {
            return Some(defined());
        }
        let exact = rounded.exact.add(&rounded.rest).ok()?;
        if let Some(bent) = Bent::of(&difference, index_name)
            && (bent.below_the_lesser_root(&exact, &known) == Some(true)
                || bent.before_the_greater_root((from, &exact), relation, &known) == Some(true))
        {
            return Some(defined());
        }
        let (factor, rest, under) = root_of(&rounded.exact, &positive)?;
        let rising = beyond.sub(&rest).and_then(|beyond| beyond.div(&factor)).ok()?;
        let square = rising.mul(&rising).and_then(|square| square.sub(&under)).ok()?;
        let at_start = |value: &Value| value.with(&compared.recurrence.index, from);
        let stands = |relation: Relation, value: &Value| {
            at_start(value).is_ok_and(|value| compared.known.decide(relation, &value, &Value::zero()) == Some(true))
        };
        let starts_before = stands(relation.negated(), &difference) || stands(Relation::Gte, &rising);
        Some(
            starts_before
                && positive(&factor)
                && positive(&known.simplify(&square.div(&difference).ok()?))
                && defined(),
        )
    }

    /// Whether what is compared bends upwards and is 0 at E, behind where it is least: it is not below 0 from E on, and above 0 behind
    /// it.
    pub(super) fn holds_behind_the_root(&self, stretch: &Stretch) -> Option<bool> {
        let known = &self.compared.known;
        self.by_the_root(stretch, known, &|_, bent, root| {
            Some(bent.least_before(root, known) == Some(true) && bent.is_zero_at(root, known))
        })
    }

    /// Whether what is compared bends downwards and is 0 at E, and the index is known to lie before the other place where it is 0:
    /// between both, that is `-b/a - E` of `a*n^2 + b*n + c`, it is above 0.
    pub(super) fn holds_between_the_roots(&self, stretch: &Stretch, known: &Assumptions) -> Option<bool> {
        self.by_the_root(stretch, known, &|relation, bent, lesser| {
            let greater = bent.linear.div(&bent.half).and_then(|sum| sum.neg()?.sub(lesser)).ok()?;
            let before = if relation == Relation::Gte { Relation::Lte } else { Relation::Lss };
            Some(
                known.decide(Relation::Lss, &bent.half, &Value::zero()) == Some(true)
                    && bent.is_zero_at(lesser, known)
                    && known.decide(before, self.at, &known.simplify(&greater)) == Some(true),
            )
        })
    }

    /// Whether this tells that what is compared, which is to be above 0 or at least 0, is so at the index, given the E that the
    /// index is the first behind, or the first at.
    fn by_the_root(
        &self,
        stretch: &Stretch,
        known: &Assumptions,
        told: &dyn Fn(Relation, &Bent<'_>, &Value) -> Option<bool>,
    ) -> Option<bool> {
        let compared = &self.compared;
        if compared.known.is_natural(&self.at.sub(&stretch.from).ok()?) != Some(true) {
            return None;
        }
        let (relation, difference) = compared.above_zero(stretch)?;
        let rounded = rounded(self.at).filter(|rounded| rounded.up == (relation == Relation::Gte))?;
        let bent = Bent::of(&difference, &compared.recurrence.index)?;
        let root = rounded.exact.add(&rounded.rest).ok()?;
        Some(told(relation, &bent, &root)? && self.defined_at(stretch, self.at, known))
    }
}

impl Compared<'_> {
    /// Whether what is compared bends downwards and is 0 at no number: it is below 0 everywhere.
    pub(super) fn is_below_its_bound(&self, stretch: &Stretch) -> Option<bool> {
        let (_, difference) = self.above_zero(stretch)?;
        let bent = Bent::of(&difference, &self.recurrence.index)?;
        let known = self.within(stretch, []);
        let is = |value: &Value| known.decide(Relation::Lss, value, &Value::zero()) == Some(true);
        Some(is(&bent.half) && known.gives_meaning(&difference) && is(&bent.under_root()?))
    }

    /// Whether it holds nowhere in a stretch with an end, as what is compared bends upwards and it does not hold at both ends, or bends
    /// downwards and rises still at the last index, where it does not hold.
    pub(super) fn is_below_up_to_the_end(&self, stretch: &Stretch) -> Option<bool> {
        let until = stretch.until.as_ref().filter(|until| self.known.is_natural(until) == Some(true))?;
        let last = until.sub(&Value::one()).ok()?;
        let (relation, difference) = self.above_zero(stretch)?;
        let bent = Bent::of(&difference, &self.recurrence.index)?;
        let is = |relation: Relation, value: &Value| {
            let decided = |value: &Value| self.known.decide(relation, value, &Value::zero());
            decided(value).or_else(|| decided(&with_known_parts(value, &self.known)?)) == Some(true)
        };
        let fails_at = |place: &Value| {
            difference.with(&self.recurrence.index, place).is_ok_and(|value| is(relation.negated(), &value))
        };
        let slope =
            bent.half.mul(&last).and_then(|half| half.add(&half)).and_then(|twice| twice.add(&bent.linear)).ok()?;
        let stands = if is(Relation::Gte, &bent.half) {
            fails_at(&stretch.from)
        } else {
            is(Relation::Lss, &bent.half) && is(Relation::Gte, &slope)
        };
        Some(stands && fails_at(&last) && self.within(stretch, []).gives_meaning(&difference))
    }

    /// What is compared as a difference that is to be above 0, or at least 0; of a root the square.
    fn above_zero(&self, stretch: &Stretch) -> Option<(Relation, Value)> {
        let (relation, [left, right]) = (self.wanted.0, &stretch.sides);
        let (relation, difference) = match relation {
            Relation::Gtr | Relation::Gte => (relation, left.sub(right).ok()?),
            Relation::Lss | Relation::Lte => (relation.mirrored(), right.sub(left).ok()?),
            Relation::Eq | Relation::Neq => return None,
        };
        let index = &self.recurrence.index;
        let root = difference.atoms().into_iter().find(|atom| matches!(atom, Atom::Root(_)) && atom.mentions(index));
        let Some(Atom::Root(inner)) = &root else { return Some((relation, difference)) };
        let part = Name::new("[part]");
        let (factor, rest) = difference.with_atom(root.as_ref()?, &Value::variable(&part)).ok()?.linear_in(&part)?;
        let bound = rest.neg().and_then(|rest| rest.div(&factor)).ok()?;
        let known = &self.known;
        let is = |relation: Relation, value: &Value| known.decide(relation, value, &Value::zero()) == Some(true);
        // Above a bound that is not negative a root is where what stands under it is above the square, and below it below.
        let over = inner.sub(&bound.mul(&bound).ok()?).ok().filter(|_| is(Relation::Gte, &bound))?;
        match (is(Relation::Gtr, &factor), is(Relation::Lss, &factor)) {
            (true, _) => Some((relation, over)),
            (_, true) => Some((relation, over.neg().ok()?)),
            _ => None,
        }
    }
}

/// What is quadratic in the index, `half*n^2 + linear*n + constant`, or linear.
struct Bent<'a> {
    form: &'a Value,
    index: &'a Name,
    half: Value,
    linear: Value,
    constant: Value,
}

impl<'a> Bent<'a> {
    fn of(form: &'a Value, index: &'a Name) -> Option<Bent<'a>> {
        let number = |number: i64| form.with(index, &Value::integer(number)).ok();
        let (zeroth, first, second) = (number(0)?, number(1)?, number(2)?);
        let step = first.sub(&zeroth).ok()?;
        let bend = second.sub(&first).and_then(|later| later.sub(&step)).ok()?;
        let half = bend.div(&Value::integer(2)).ok()?;
        let (linear, count) = (step.sub(&half).ok()?, Value::variable(index));
        let whole = half.mul(&count).and_then(|sum| sum.add(&linear)).and_then(|sum| sum.mul(&count)).ok()?;
        (whole.add(&zeroth).ok()? == *form).then_some(Bent { form, index, half, linear, constant: zeroth })
    }

    /// What stands under the root where it is 0: below 0 where it is 0 nowhere.
    fn under_root(&self) -> Option<Value> {
        let product = self.half.mul(&self.constant).and_then(|product| product.mul(&Value::integer(4))).ok()?;
        self.linear.mul(&self.linear).and_then(|square| square.sub(&product)).ok()
    }

    /// Whether it is 0 at a place that has a value.
    fn is_zero_at(&self, place: &Value, known: &Assumptions) -> bool {
        let there = || Some(known.simplify(&self.form.with(self.index, place).ok()?));
        known.gives_meaning(place)
            && there().is_some_and(|there| known.decide(Relation::Eq, &there, &Value::zero()) == Some(true))
    }

    /// Whether it is a square less and less above 0, `a*(n-m)^2 + s` with a below 0, that is 0 at a place not behind m: before
    /// that it only rises, so it is below 0.
    fn below_the_lesser_root(&self, place: &Value, known: &Assumptions) -> Option<bool> {
        let is = |relation: Relation, value: &Value| known.decide(relation, value, &Value::zero()) == Some(true);
        let middle = || self.linear.neg()?.div(&self.half.add(&self.half)?);
        Some(
            is(Relation::Lss, &self.half)
                && self.is_zero_at(place, known)
                && is(Relation::Gte, &middle().ok()?.sub(place).ok()?),
        )
    }

    /// Whether it bends upwards, and is least not behind a place.
    fn least_before(&self, place: &Value, known: &Assumptions) -> Option<bool> {
        let middle = self.linear.neg().and_then(|linear| linear.div(&self.half.add(&self.half)?)).ok()?;
        let is = |relation: Relation, value: &Value| known.decide(relation, value, &Value::zero()) == Some(true);
        Some(is(Relation::Gtr, &self.half) && is(Relation::Gte, &known.simplify(&place.sub(&middle).ok()?)))
    }

    /// Whether it does not bend downwards, is 0 at a place, and is not as wanted at the start: between both it lies below the
    /// line that joins them.
    fn before_the_greater_root(
        &self,
        (from, place): (&Value, &Value),
        wanted: Relation,
        known: &Assumptions,
    ) -> Option<bool> {
        let start = self.form.with(self.index, from).ok()?;
        Some(
            known.decide(Relation::Gte, &self.half, &Value::zero()) == Some(true)
                && known.decide(wanted.negated(), &start, &Value::zero()) == Some(true)
                && self.is_zero_at(place, known),
        )
    }
}

/// A value as `a*sqrt(S) + b`; one that is positive is the root of its square.
fn root_of(value: &Value, positive: &dyn Fn(&Value) -> bool) -> Option<(Value, Value, Value)> {
    let root = value.atoms().into_iter().find(|atom| matches!(atom, Atom::Root(_)));
    match &root {
        Some(Atom::Root(inner)) => {
            let part = Name::new("[part]");
            let (factor, rest) = value.with_atom(root.as_ref()?, &Value::variable(&part)).ok()?.linear_in(&part)?;
            Some((factor, rest, inner.clone()))
        }
        _ => positive(value).then(|| Some((Value::one(), Value::zero(), value.mul(value).ok()?))).flatten(),
    }
}
