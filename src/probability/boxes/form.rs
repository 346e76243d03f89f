//! Values over drawn numbers, in interval arithmetic.

use std::collections::BTreeSet;

use num_rational::BigRational;
use num_traits::Signed;

use crate::interval::Interval;
use crate::name::Name;
use crate::period::Test;
use crate::value::{Atom, Need, Relation, Sum, Value, View};

const ZERO: Interval = Interval::exactly(0.0);
const ONE: Interval = Interval::exactly(1.0);

/// A value over drawn numbers.
#[derive(Clone, Debug)]
enum Form {
    Number(Interval),
    /// The number that is drawn at this place.
    Drawn(usize),
    /// Terms, each a number and powers of others.
    Sum(Vec<(Interval, Vec<(Form, u32)>)>),
    Quotient(Box<[Form; 2]>),
    /// The greatest, or the least.
    Greatest(Vec<Form>),
    Least(Vec<Form>),
    /// 1 where it is more than 0, else 0.
    Positive(Box<Form>),
    Floor(Box<Form>),
    Root(Box<Form>),
}

/// A comparison with 0.
#[derive(Clone, Debug)]
pub(super) struct Look {
    form: Form,
    relation: Relation,
}

impl Look {
    /// A test over numbers that are drawn, each named by its place among `names`.
    ///
    /// # Errors
    /// What stands in it that is no number then.
    pub(super) fn of(test: &Test, names: &[Name]) -> Result<Look, String> {
        let difference = test.left.sub(&test.right).map_err(|error| error.0)?;
        Ok(Look { form: Form::of(&difference, names)?, relation: test.relation })
    }

    /// What must hold for a value to be one, each as a comparison: it divides by nothing that is 0, and takes no root of what
    /// is negative.
    ///
    /// # Errors
    /// As for [`Look::of`], and for exponents that are drawn.
    pub(super) fn needs(value: &Value, names: &[Name]) -> Result<Vec<Look>, String> {
        let test = |need: Need| {
            let relation = match &need {
                Need::Nonzero(_) => Relation::Neq,
                Need::Nonnegative(_) => Relation::Gte,
                Need::Natural(_) => return Err(need.to_string()),
            };
            Look::of(&Test { relation, left: need.value().clone(), right: Value::zero() }, names)
        };
        value.needs().into_iter().map(test).collect()
    }

    /// The draws that it depends on in these ranges: a condition that is decided there depends on none.
    pub(super) fn places(&self, ranges: &[Interval]) -> BTreeSet<usize> {
        let mut found = BTreeSet::new();
        self.form.depends(ranges, &mut found);
        found
    }

    /// Whether it holds of all numbers of these ranges, or of none; nothing where that is open.
    pub(super) fn holds(&self, ranges: &[Interval]) -> Option<bool> {
        let Interval { low, high } = self.form.at(ranges);
        let (below, above) = (high < 0.0, low > 0.0);
        let zero = low == 0.0 && high == 0.0;
        match self.relation {
            Relation::Gtr if above => Some(true),
            Relation::Gtr if high <= 0.0 => Some(false),
            Relation::Gte if low >= 0.0 => Some(true),
            Relation::Gte if below => Some(false),
            Relation::Lss if below => Some(true),
            Relation::Lss if low >= 0.0 => Some(false),
            Relation::Lte if high <= 0.0 => Some(true),
            Relation::Lte if above => Some(false),
            Relation::Eq | Relation::Neq if zero => Some(self.relation == Relation::Eq),
            Relation::Eq | Relation::Neq if below || above => Some(self.relation == Relation::Neq),
            _ => None,
        }
    }
}

impl Form {
    fn of(value: &Value, names: &[Name]) -> Result<Form, String> {
        let View::Real(top, below) = value.view() else { return Err(format!("{value} is not a number")) };
        if let Some(chosen) = chosen(value, &top) {
            return chosen_of(chosen, names);
        }
        let sum = |sum: &Sum| -> Result<Form, String> {
            let terms = sum.iter().map(|(number, factors)| {
                let factors = factors.iter().map(|(atom, power)| Ok((Form::of_atom(atom, names)?, *power)));
                Ok((Interval::of(number), factors.collect::<Result<_, String>>()?))
            });
            let terms: Vec<(Interval, Vec<(Form, u32)>)> = terms.collect::<Result<_, String>>()?;
            Ok(match terms.as_slice() {
                [] => Form::Number(ZERO),
                [(number, factors)] if factors.is_empty() => Form::Number(*number),
                _ => Form::Sum(terms),
            })
        };
        let (top, below) = (sum(&top)?, sum(&below)?);
        Ok(match below {
            Form::Number(one) if one == ONE => top,
            below => Form::Quotient(Box::new([top, below])),
        })
    }

    fn of_atom(atom: &Atom, names: &[Name]) -> Result<Form, String> {
        let of = |value: &Value| Form::of(value, names).map(Box::new);
        match atom {
            Atom::Variable(name) => {
                let place = names.iter().position(|known| known == name);
                place.map(Form::Drawn).ok_or_else(|| format!("{name} is not a number"))
            }
            Atom::Maximum(parts) => {
                let parts = parts.iter().map(|part| Form::of(part, names));
                Ok(Form::Greatest(std::iter::once(Ok(Form::Number(ZERO))).chain(parts).collect::<Result<_, _>>()?))
            }
            Atom::Positive(part) => Ok(Form::Positive(of(part)?)),
            Atom::Floor(part) => Ok(Form::Floor(of(part)?)),
            Atom::Root(part) => Ok(Form::Root(of(part)?)),
            Atom::Power(..) | Atom::Apply(..) => {
                Err("powers with drawn exponents, and functions that are left open, are not followed".to_string())
            }
        }
    }

    fn depends(&self, ranges: &[Interval], found: &mut BTreeSet<usize>) {
        match self {
            Form::Number(_) => {}
            Form::Drawn(place) => {
                found.insert(*place);
            }
            Form::Sum(terms) => {
                terms.iter().flat_map(|(_, factors)| factors).for_each(|(factor, _)| factor.depends(ranges, found));
            }
            Form::Quotient(both) => both.iter().for_each(|part| part.depends(ranges, found)),
            Form::Greatest(parts) | Form::Least(parts) => parts.iter().for_each(|part| part.depends(ranges, found)),
            Form::Positive(part) => {
                let Interval { low, high } = part.at(ranges);
                if low <= 0.0 && high > 0.0 {
                    part.depends(ranges, found);
                }
            }
            Form::Floor(part) | Form::Root(part) => part.depends(ranges, found),
        }
    }

    fn at(&self, ranges: &[Interval]) -> Interval {
        match self {
            Form::Number(number) => *number,
            Form::Drawn(place) => ranges.get(*place).copied().unwrap_or(Interval::between(f64::MIN, f64::MAX)),
            Form::Sum(terms) => terms.iter().fold(ZERO, |sum, (number, factors)| {
                let term = factors.iter().fold(*number, |product, (factor, exponent)| {
                    let factor = power(factor.at(ranges), *exponent);
                    multiplied(product, factor)
                });
                together(sum, term)
            }),
            Form::Quotient(both) => both[0].at(ranges).over(both[1].at(ranges)),
            Form::Greatest(parts) | Form::Least(parts) => {
                let greatest = matches!(self, Form::Greatest(_));
                let both = |one: f64, other: f64| if greatest { one.max(other) } else { one.min(other) };
                let all = parts.iter().map(|part| part.at(ranges));
                let found = all.reduce(|a, b| Interval::between(both(a.low, b.low), both(a.high, b.high)));
                found.unwrap_or(ZERO)
            }
            Form::Positive(part) => {
                let part = part.at(ranges);
                let of = |positive: bool| if positive { 1.0 } else { 0.0 };
                Interval::between(of(part.low > 0.0), of(part.high > 0.0))
            }
            Form::Floor(part) => {
                let part = part.at(ranges);
                Interval::between(part.low.floor(), part.high.floor())
            }
            Form::Root(part) => part.at(ranges).root(),
        }
    }
}

/// A value with one maximum in it, as the greatest (or the least) of values without: `x + max(0,y-x)` is that of x and y,
/// which says more in interval arithmetic.
fn chosen(value: &Value, terms: &Sum) -> Option<(bool, Vec<Value>)> {
    if terms.len() < 2 || value.denominator()? != Value::one() {
        return None;
    }
    let maximum = |(number, factors): &(BigRational, Vec<(Atom, u32)>)| match factors.as_slice() {
        [(atom @ Atom::Maximum(parts), 1)] => Some((number.clone(), atom.clone(), parts.clone())),
        _ => None,
    };
    let mut all = terms.iter().filter_map(maximum);
    let (Some((number, atom, parts)), None) = (all.next(), all.next()) else { return None };
    let factor = Value::rational(number.clone());
    let rest = value.sub(&factor.mul(&atom.value().ok()?).ok()?).ok()?;
    let with = |part: &Value| factor.mul(part).and_then(|part| part.add(&rest)).ok();
    let parts = parts.iter().map(with).collect::<Option<Vec<_>>>()?;
    Some((number.is_positive(), std::iter::once(rest.clone()).chain(parts).collect()))
}

fn chosen_of((greatest, values): (bool, Vec<Value>), names: &[Name]) -> Result<Form, String> {
    let parts = values.iter().map(|value| Form::of(value, names)).collect::<Result<Vec<_>, _>>()?;
    Ok(if greatest { Form::Greatest(parts) } else { Form::Least(parts) })
}

/// A sum, whose ends are exact where the machine adds them exactly: so what lies up to a bound reaches it.
fn together(one: Interval, other: Interval) -> Interval {
    let wide = one.plus(other);
    let exact = |a: f64, b: f64, rounded: f64| {
        let sum = a + b;
        // What is lost in the sum, by Knuth.
        let own = sum - a;
        let lost = (a - (sum - own)) + (b - own);
        if lost == 0.0 { sum } else { rounded }
    };
    Interval::between(exact(one.low, other.low, wide.low), exact(one.high, other.high, wide.high))
}

/// A product, exact where both are single numbers whose product the machine has exactly.
fn multiplied(one: Interval, other: Interval) -> Interval {
    if one == ONE {
        return other;
    }
    let point = |interval: Interval| (interval.low == interval.high).then_some(interval.low);
    if let (Some(one), Some(other)) = (point(one), point(other)) {
        let product = one * other;
        // Where nothing is lost in the product; a very small one might have lost what does not show.
        if product.abs() > 1e-200 && product.is_finite() && one.mul_add(other, -product) == 0.0 {
            return Interval::exactly(product);
        }
    }
    one.times(other)
}

/// A power, which of an even exponent is not negative.
fn power(base: Interval, exponent: u32) -> Interval {
    let (even, across) = (exponent.is_multiple_of(2), base.low < 0.0 && base.high > 0.0);
    if even && base.low < 0.0 && (across || base.high <= 0.0) {
        let most = base.high.max(-base.low);
        let least = if across { 0.0 } else { -base.high };
        return power(Interval::between(least, most), exponent);
    }
    let product = (1..exponent).fold(base, |product, _| multiplied(product, base));
    if even { Interval::between(product.low.max(0.0), product.high) } else { product }
}
