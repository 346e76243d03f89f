//! The first index at which a linear or geometric sequence lies in an interval, exactly.
//!
//! Both are brought to the question when `n`, or `c^n`, lies in an interval. These are monotone (for a negative c,
//! in its even and its odd part), so the first index that satisfies the one bound is the only one that needs to be
//! looked at: if it misses the other bound, so do all later ones.

mod logarithm;

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Signed, ToPrimitive};

pub(crate) use logarithm::NO_VALUE;

use super::affine::{Shape, shape};
use super::cut_off::Cut;
use super::end::not_rounded;
use super::interval::Interval;
use super::never::for_none;
use super::outgrown::outgrown;
use super::over::of_quotient;
use super::powers::{Found, Numbers, powers};
use super::{Comparison, Reach, Unknown};
use crate::assumption::Assumptions;
use crate::closed_form::{for_all_signs, with_known_parts};
use crate::name::Name;
use crate::value::{Atom, Relation, Value};

/// The latest index of a term that a reason writes down.
const LATEST_TOLD: u64 = 1_000;

/// What is asked: when a value, a function of the index, lies in an interval.
pub(super) struct Entry<'a> {
    pub(super) value: Value,
    pub(super) interval: Interval,
    pub(super) from: &'a Value,
    pub(super) until: Option<&'a Value>,
    /// Whether the index `until` surely has what is asked for, by another form.
    pub(super) at_end: bool,
    /// The sequence itself, for reasons.
    pub(super) form: &'a Value,
    pub(super) index: &'a Name,
    pub(super) known: &'a Assumptions,
}

/// The first index from `from` on, and before `until`, at which the value lies in the interval.
pub(super) fn enter(entry: &Entry) -> Result<Reach, Unknown> {
    let start = entry.value.with(entry.index, entry.from)?;
    let holds = |start: &Value| entry.interval.holds(start, entry.known) == Some(true);
    // Where a piece begins behind a way of symbols, what is rounded there may be known.
    let behind = entry.from.as_rational().is_none();
    if holds(&start) || behind && with_known_parts(&start, entry.known).is_some_and(|start| holds(&start)) {
        return entry.before_end(entry.from.clone(), Vec::new());
    }
    if let Some(never) = entry.never() {
        return Ok(never);
    }
    if let Some(cut) = Cut::of(&entry.value, entry.index, entry.known) {
        return cut.enter(entry);
    }
    let shape = match shape(&entry.value, entry.index) {
        Ok(shape) => shape,
        Err(other) => {
            if let Some(value) = of_size(&entry.value, entry.index, entry.known) {
                return enter(&Entry { value, interval: entry.interval.clone(), ..*entry });
            }
            return of_quotient(entry).or_else(|| outgrown(entry)).unwrap_or(Err(other));
        }
    };
    match shape {
        Shape::Constant => entry.constant(),
        // A step that is known to be none leaves it where it is.
        Shape::Linear { base, step } if entry.known.decide(Relation::Eq, &step, &Value::zero()) == Some(true) => {
            Entry { value: base, interval: entry.interval.clone(), ..*entry }.constant()
        }
        Shape::Linear { base, step } => match entry.sign(&step) {
            Ok(positive) => {
                let interval = entry.interval.pulled_back(&base, &step, positive)?;
                entry.linear(&interval)
            }
            Err(reach) => Ok(reach),
        },
        Shape::Geometric { limit, factor, ratio } => entry.geometric(&limit, &factor, &ratio),
    }
}

/// `a*abs(d*c^n) + b` as `a*abs(d)*abs(c)^n + b`, where the signs of d and c need not be known.
fn of_size(value: &Value, index: &Name, known: &Assumptions) -> Option<Value> {
    let maxima: Vec<Atom> = value.atoms().into_iter().filter(|atom| matches!(atom, Atom::Maximum(_))).collect();
    let [atom @ Atom::Maximum(elements)] = maxima.as_slice() else { return None };
    let [inner] = &**elements else { return None };
    let mark = Name::new("[size]");
    let (factor, rest) = value.with_atom(atom, &Value::variable(&mark)).ok()?.linear_in(&mark)?;
    // a*abs(e) = 2*a*max(0, e) - a*e
    let half = factor.mul(&Value::fraction(1, 2).ok()?).ok()?;
    let rest = rest.add(&inner.mul(&half).ok()?).ok()?;
    let Ok(Shape::Geometric { limit, factor, ratio }) = shape(inner, index) else { return None };
    if rest.mentions(index) || half.mentions(index) || !limit.is_zero() {
        return None;
    }
    let size = |value: &Value| value.abs().ok().map(|size| known.simplify(&size));
    let power = size(&ratio)?.power(&Value::variable(index)).ok()?;
    half.mul(&size(&factor)?.mul(&power).ok()?).ok()?.add(&rest).ok()
}

impl Entry<'_> {
    /// That no index has it, where symbols alone say so: `2^n - c` is above 0 for every n if c is below 0.
    fn never(&self) -> Option<Reach> {
        let symbolic = self.value.variables().iter().any(|name| name != self.index);
        if !symbolic || !self.value.mentions(self.index) {
            return None;
        }
        let (count, mut known) = (Value::variable(self.index), self.known.clone());
        known.assume(Relation::Gte, &count, self.from);
        if let Some(until) = self.until {
            known.assume(Relation::Lss, &count, until);
        }
        let holds = |value: &Value| self.interval.holds(value, &known);
        let found = holds(&self.value).or_else(|| for_all_signs(&self.value, &holds)) == Some(false);
        found.then(|| Reach::Never(for_none(self, &known)))
    }

    /// Whether a value is positive (else negative).
    fn sign(&self, value: &Value) -> Result<bool, Reach> {
        let zero = Value::zero();
        if self.known.decide(Relation::Gtr, value, &zero) == Some(true) {
            return Ok(true);
        }
        let is = |relation: Relation, value: &Value| self.known.decide(relation, value, &zero) == Some(true);
        if is(Relation::Lss, value) {
            return Ok(false);
        }
        let side = [Relation::Gte, Relation::Lte].into_iter().find(|side| is(*side, value));
        // A quotient is not 0 where what it divides is not.
        if let Some(side) = side
            && value.numerator().is_some_and(|above| is(Relation::Neq, &above))
        {
            return Ok(side == Relation::Gte);
        }
        // The side of its divisor says more than that of the whole.
        let divisor = value.denominator().filter(|below| below.as_rational().is_none());
        let open = |below: &Value| [Relation::Gtr, Relation::Lss].iter().all(|side| !is(*side, below));
        if let Some(below) = divisor.filter(open) {
            return Err(Reach::undecided(Relation::Gtr, &below, &zero));
        }
        // Where one side is excluded it is asked whether it is 0.
        Err(Reach::undecided(if side.is_some() { Relation::Eq } else { Relation::Gtr }, value, &zero))
    }

    pub(super) fn before_end(&self, at: Value, conditions: Vec<Comparison>) -> Result<Reach, Unknown> {
        let Some(until) = self.until else { return Ok(Reach::At(at, conditions)) };
        let mut known = self.known.clone();
        conditions.iter().for_each(|(relation, left, right)| known.assume(*relation, left, right));
        // A whole number is before `ceil(x)` if it is less than x.
        let decided =
            known.decide(Relation::Lss, &at, until).or_else(|| known.decide(Relation::Lss, &at, &not_rounded(until)?));
        Ok(match decided {
            Some(true) => Reach::At(at, conditions),
            Some(false) => Reach::Never(format!("it is not met before n = {until}")),
            None => Reach::undecided(Relation::Lss, &at, until),
        })
    }

    fn constant(&self) -> Result<Reach, Unknown> {
        match self.interval.holds(&self.value, self.known) {
            Some(true) => self.before_end(self.from.clone(), Vec::new()),
            Some(false) => Ok(Reach::Never(format!("it stays {}", self.form))),
            None => Ok(Reach::Unknown(self.question(&self.value))),
        }
    }

    /// What would have to be known of a value.
    fn question(&self, value: &Value) -> Unknown {
        let Interval { low, high } = &self.interval;
        let point = low.as_ref().filter(|_| self.interval.is_point()).map(|(wanted, _)| (Relation::Eq, wanted));
        let above = low.as_ref().map(|(low, strict)| (if *strict { Relation::Gtr } else { Relation::Gte }, low));
        let below = high.as_ref().map(|(high, strict)| (if *strict { Relation::Lss } else { Relation::Lte }, high));
        let undecided = |(relation, bound): &(Relation, &Value)| self.known.decide(*relation, value, bound).is_none();
        // Of two bounds the first that is not known.
        let bound = point.or_else(|| [above, below].into_iter().flatten().find(undecided));
        let open = bound.map(|(relation, bound)| Box::new((relation, value.clone(), bound.clone())));
        Unknown { open, ..Unknown::because(format!("it must be known whether {}", self.goal(value))) }
    }

    /// That a value lies in the interval.
    pub(super) fn goal(&self, value: &Value) -> String {
        let sides = [(&self.interval.low, ">", ">="), (&self.interval.high, "<", "<=")];
        if let (Some((wanted, _)), true) = (&self.interval.low, self.interval.is_point()) {
            return format!("{value} = {wanted}");
        }
        let bounds = sides.iter().filter_map(|(bound, open, shut)| {
            bound.as_ref().map(|(bound, strict)| format!("{value} {} {bound}", if *strict { open } else { shut }))
        });
        bounds.collect::<Vec<_>>().join(" and ")
    }

    /// The least n in an interval.
    fn linear(&self, interval: &Interval) -> Result<Reach, Unknown> {
        if let (Some(numbers), Some(from)) = (interval.numbers(), self.from.as_rational()) {
            let least = numbers.low.as_ref().map_or_else(
                || from.clone(),
                |(low, strict)| {
                    if *strict { low.floor() + BigRational::one() } else { low.ceil() }
                },
            );
            let at = least.max(from.clone());
            if numbers.below_high(&at) {
                return self.before_end(Value::rational(at), Vec::new());
            }
            return Ok(Reach::Never(self.missed(&at, &from)?));
        }
        if interval.is_point() {
            return self.linear_point(interval);
        }
        let Some((low, strict)) = &interval.low else {
            // It only grows: if it is not below the bound at the start, it never is.
            return Ok(match interval.holds(self.from, self.known) {
                Some(false) => Reach::Never(self.moving_away()?),
                _ => Reach::Unknown(self.question(&self.value.with(self.index, self.from)?)),
            });
        };
        let after = if *strict { low.floor()?.add(&Value::one())? } else { low.ceiling()? };
        let relation = if *strict { Relation::Gtr } else { Relation::Gte };
        let at = match self.known.decide(relation, self.from, low) {
            Some(true) => self.from.clone(),
            Some(false) => after,
            // A start that meets it may be the whole number after it, too.
            None if self.known.decide(Relation::Gte, &after, self.from) == Some(true) => after,
            None => Value::maximum(&[self.from.clone(), after])?,
        };
        let found = match &interval.high {
            None => self.before_end(at.clone(), Vec::new()),
            Some((high, strict)) => {
                let relation = if *strict { Relation::Lss } else { Relation::Lte };
                match self.known.decide(relation, &at, high) {
                    Some(true) => self.before_end(at.clone(), Vec::new()),
                    Some(false) => Ok(Reach::Never(format!("it steps over: n would lie between {low} and {high}"))),
                    None => self.before_end(at.clone(), vec![(relation, at.clone(), high.clone())]),
                }
            }
        };
        match found {
            Ok(Reach::Unknown(_)) => self.up_to_end(&at, interval).map_or(found, Ok),
            found => found,
        }
    }

    /// When n is a certain value: if that is a whole number, and not too early.
    fn linear_point(&self, interval: &Interval) -> Result<Reach, Unknown> {
        let Some((wanted, _)) = &interval.low else { return Ok(Reach::unknown(String::new())) };
        let wanted = self.known.simplify(wanted);
        let later = self.known.decide(Relation::Gte, &wanted, self.from);
        if later == Some(false) {
            return Ok(Reach::Never(self.moving_away()?));
        }
        // A whole number is not below itself, and every other number is none.
        if self.until.is_some_and(|until| wanted.ceiling().is_ok_and(|next| next == *until)) {
            return Ok(Reach::Never(format!("it is not met before n = {wanted}")));
        }
        let mut conditions = Vec::new();
        let whole = self.known.is_natural(&wanted);
        if whole == Some(false) {
            return Ok(Reach::Never(format!("it steps over it: n would be {wanted}, which is not a whole number")));
        }
        if whole.is_none() {
            let floor = self.known.simplify(&wanted.floor()?);
            match self.known.decide(Relation::Eq, &floor, &wanted) {
                Some(true) => {}
                Some(false) => {
                    let text = format!("it steps over it: n would be {wanted}, which is not a whole number");
                    return Ok(Reach::Never(text));
                }
                None => conditions.push((Relation::Eq, floor, wanted.clone())),
            }
        }
        if later.is_none() {
            conditions.push((Relation::Gte, wanted.clone(), self.from.clone()));
        }
        self.before_end(wanted, conditions)
    }

    fn moving_away(&self) -> Result<String, Unknown> {
        let start = self.form.with(self.index, self.from)?;
        let next = self.form.with(self.index, &self.from.add(&Value::one())?)?;
        Ok(format!("it moves away: it is {start}, then {next}, and so on"))
    }

    /// Why an index at which the sequence has passed the interval is too late.
    fn missed(&self, at: &BigRational, from: &BigRational) -> Result<String, Unknown> {
        if at <= from {
            return self.moving_away();
        }
        if *at > BigRational::from_integer(LATEST_TOLD.into()) {
            return Ok(format!("it steps over it between n = {} and n = {at}", at - BigRational::one()));
        }
        let before = self.form.with(self.index, &Value::rational(at - BigRational::one()))?;
        let after = self.form.with(self.index, &Value::rational(at.clone()))?;
        Ok(format!("it steps over it: it is {before} at n = {} and {after} at n = {at}", at - BigRational::one()))
    }

    fn geometric(&self, limit: &Value, factor: &Value, ratio: &Value) -> Result<Reach, Unknown> {
        if self.known.decide(Relation::Eq, factor, &Value::zero()) == Some(true) {
            return Entry { value: limit.clone(), interval: self.interval.clone(), ..*self }.constant();
        }
        if self.known.decide(Relation::Eq, ratio, &Value::one()) == Some(true) {
            let start = self.value.with(self.index, self.from)?;
            return match self.interval.holds(&start, self.known) {
                Some(true) => self.before_end(self.from.clone(), Vec::new()),
                Some(false) => Ok(Reach::Never(format!("it stays {}", self.form.with(self.index, self.from)?))),
                None => Ok(Reach::Unknown(self.question(&start))),
            };
        }
        if *ratio == Value::integer(-1) {
            return self.back_and_forth();
        }
        if let Some(never) = self.between_start_and_limit(limit, factor, ratio)? {
            return Ok(never);
        }
        if let Some(found) = self.same_power(limit, factor, ratio)? {
            return Ok(found);
        }
        if let Some(found) = self.on_either_side(limit, factor, ratio) {
            return found;
        }
        // Powers of what is more than 0 are too: a later form has the sign that it begins with.
        let begins = match self.known.decide(Relation::Gtr, ratio, &Value::zero()) {
            Some(true) if self.from.as_rational().is_none() => self.away_at_start(factor, ratio)?,
            _ => factor.clone(),
        };
        let positive = match self.sign(&begins) {
            Ok(positive) => positive,
            Err(_) if self.interval.is_point() => return self.point_of_unknown_side(limit, factor, ratio),
            Err(reach) => return Ok(self.logarithm(limit, factor, ratio)?.unwrap_or(reach)),
        };
        let interval = self.interval.pulled_back(limit, factor, positive)?;
        let numbers = (interval.numbers(), ratio.as_rational(), self.from.as_rational());
        if let (Some(numbers), Some(ratio), Some(from)) = numbers
            && let Some(from) = from.to_integer().to_u64()
        {
            return Ok(match powers(&ratio, &numbers, from) {
                Found::At(at) => return self.before_end(whole(at), Vec::new()),
                Found::Never => Reach::Never(self.passes(limit, &ratio, &numbers, from)?),
                Found::TooFar => Reach::unknown("it takes more steps than are counted exactly"),
            });
        }
        if self.interval.is_point() {
            return self.point_of_unknown_side(limit, factor, ratio);
        }
        let found = self.logarithm(limit, factor, ratio)?;
        if let Some(told) = found.or_else(|| self.side_of(ratio)) {
            return Ok(told);
        }
        let start = self.value.with(self.index, self.from)?;
        let open = if self.interval.holds(&start, self.known).is_none() { &start } else { &self.value };
        Ok(Reach::Unknown(self.question(open)))
    }

    /// As near to its limit on one side as on the other: how far it is away, of which the side does not matter.
    fn on_either_side(&self, limit: &Value, factor: &Value, ratio: &Value) -> Option<Result<Reach, Unknown>> {
        let (Some((low, strict)), Some((high, other))) = (&self.interval.low, &self.interval.high) else { return None };
        let far = self.known.simplify(&high.sub(limit).ok()?);
        let same = strict == other && self.known.simplify(&limit.sub(low).ok()?) == far;
        let positive = self.known.decide(Relation::Gtr, ratio, &Value::zero()) == Some(true);
        if !same
            || positive
            || self.interval.is_point()
            || ratio.as_rational().is_some_and(|_| far.as_rational().is_some())
        {
            return None;
        }
        let size = |value: &Value| value.abs().ok().map(|size| self.known.simplify(&size));
        let power = size(ratio)?.power(&Value::variable(self.index)).ok()?;
        let value = size(factor)?.mul(&power).ok()?;
        let interval = Interval { low: None, high: Some((far, *strict)) };
        Some(enter(&Entry { value, interval, ..*self }))
    }

    /// Of what goes back and forth between two values: the one that it begins at, or the other.
    fn back_and_forth(&self) -> Result<Reach, Unknown> {
        let mut values = Vec::new();
        for later in [0, 1] {
            let at = self.from.add(&Value::integer(later))?;
            let value = self.known.simplify(&self.value.with(self.index, &at)?);
            match self.interval.holds(&value, self.known) {
                Some(true) => return self.before_end(at, Vec::new()),
                Some(false) => values.push(self.form.with(self.index, &at)?),
                None => return Ok(Reach::Unknown(self.question(&value))),
            }
        }
        let told: Vec<String> = values.iter().map(ToString::to_string).collect();
        Ok(Reach::Never(format!("it is {} in turn for ever", told.join(" and "))))
    }

    /// What would have to be known of a ratio: its sign, and whether the powers grow or fall.
    fn side_of(&self, ratio: &Value) -> Option<Reach> {
        if ratio.as_rational().is_some() {
            return None;
        }
        [Value::zero(), Value::one()].iter().find_map(|bound| match ratio.sub(bound).map(|rest| self.sign(&rest)) {
            Ok(Err(Reach::Unknown(Unknown { open: Some(open), .. }))) => {
                let relation = open.0;
                Some(Reach::undecided(relation, ratio, bound))
            }
            _ => None,
        })
    }

    /// A sequence that goes from its start to its limit stays between them: if both lie on one side of the interval
    /// it never enters, and the limit itself it never reaches.
    fn between_start_and_limit(&self, limit: &Value, factor: &Value, ratio: &Value) -> Result<Option<Reach>, Unknown> {
        let (zero, known) = (Value::zero(), self.known);
        let contracts = known.decide(Relation::Gtr, ratio, &zero) == Some(true)
            && known.decide(Relation::Lss, ratio, &Value::one()) == Some(true);
        if !contracts || known.decide(Relation::Neq, factor, &zero) != Some(true) {
            return Ok(None);
        }
        let start = self.value.with(self.index, self.from)?;
        // Between two values of which one is outside and the other not inside, nothing is inside.
        let outside = |bound: &Option<(Value, bool)>, beyond: Relation, strictly: Relation| {
            bound.as_ref().is_some_and(|(bound, strict)| {
                known.decide(if *strict { beyond } else { strictly }, &start, bound) == Some(true)
                    && known.decide(beyond, limit, bound) == Some(true)
            })
        };
        let never = outside(&self.interval.low, Relation::Lte, Relation::Lss)
            || outside(&self.interval.high, Relation::Gte, Relation::Gtr);
        if never { Ok(Some(Reach::Never(self.closes_in(limit, ratio)?))) } else { Ok(None) }
    }

    /// Equality with a value when it is not known from which side the sequence comes.
    fn point_of_unknown_side(&self, limit: &Value, factor: &Value, ratio: &Value) -> Result<Reach, Unknown> {
        let (zero, known) = (Value::zero(), self.known);
        let start = self.value.with(self.index, self.from)?;
        let never_zero = |value: &Value| known.decide(Relation::Neq, value, &zero) == Some(true);
        let at_limit = self.interval.holds(limit, known) == Some(true);
        if at_limit && never_zero(factor) && never_zero(ratio) {
            return Ok(Reach::Never(format!("it is never equal: {} is not 0 for any n", self.value)));
        }
        let open = match [factor, ratio].into_iter().find(|value| !never_zero(value)) {
            Some(value) if at_limit => Unknown::undecided(Relation::Eq, value, &zero),
            _ if self.interval.holds(&start, known).is_some() => self.question(&self.value),
            _ => self.question(&start),
        };
        Ok(Reach::Unknown(open))
    }

    /// Why no power lies between the numbers.
    fn passes(&self, limit: &Value, ratio: &BigRational, numbers: &Numbers, from: u64) -> Result<String, Unknown> {
        let one = BigRational::one();
        if ratio.is_positive() {
            let falls = *ratio < one;
            let far = if falls {
                Numbers { low: None, high: numbers.high.clone() }
            } else {
                Numbers { low: numbers.low.clone(), high: None }
            };
            if let Found::At(at) = powers(ratio, &far, from)
                && at > from
            {
                return self.missed(&BigRational::from_integer(at.into()), &BigRational::from_integer(from.into()));
            }
            if !falls {
                return self.moving_away();
            }
        }
        self.closes_in(limit, &Value::rational(ratio.clone()))
    }

    /// Why a sequence that closes in on its limit does not meet the goal.
    fn closes_in(&self, limit: &Value, ratio: &Value) -> Result<String, Unknown> {
        // The limit of the sequence itself, where it is asked for this and not for a multiple of it.
        let rest = self.known.simplify(&self.form.sub(&self.value)?.add(limit)?);
        let rest = match shape(self.form, self.index) {
            Ok(Shape::Geometric { limit, .. }) if rest.mentions(self.index) => limit,
            _ => rest,
        };
        let one = BigRational::from_integer(BigInt::from(1));
        let grows = ratio.as_rational().is_some_and(|ratio| ratio.abs() > one);
        if self.interval.holds(limit, self.known) == Some(false) {
            return Ok(match grows {
                true => {
                    format!("it moves away from {rest}, to either side in turn, and never meets the goal on its way")
                }
                false => format!("it closes in on {rest} and never meets the goal on its way"),
            });
        }
        let (word, end) = if grows { ("grows", "and never comes near enough") } else { ("shrinks", "and is never 0") };
        Ok(format!("what is left to {rest} {word} by the factor {ratio} each round, ({ratio})^n, {end}: no n"))
    }
}

pub(super) fn whole(number: u64) -> Value {
    Value::rational(BigRational::from_integer(BigInt::from(number)))
}
