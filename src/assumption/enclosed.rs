//! The signs of a value whose variables lie between numbers: from whole numbers of a fixed length, between which each
//! part of it lies.

use std::collections::BTreeMap;

use num_bigint::BigInt;
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{One, Signed, ToPrimitive, Zero};

use super::Assumptions;
use super::linear::Bound;
use super::sign::Signs;
use crate::name::Name;
use crate::polynomial::Polynomial;
use crate::value::fixed::{BITS, Range, scaled};
use crate::value::{Atom, Value};

/// The highest exponent of an atom.
const MOST_EXPONENT: u32 = 16;
/// The most terms of a sum.
const MOST_TERMS: usize = 200;
/// The most variables.
const MOST_NAMES: usize = 6;
/// The highest exponent of a number whose power is computed.
const HIGHEST: i32 = 500;
/// The bits of such a number.
const LONGEST: u64 = 64;
/// How deep atoms may stand in one another.
const MOST_NESTED: usize = 8;

/// Where the variables lie: above the one and below the other, where there is one.
pub(super) type Ranges = BTreeMap<Name, (Option<BigRational>, Option<BigRational>)>;

impl Assumptions {
    /// The signs that a value may have, by the numbers that its variables lie between; none where one of them does not.
    pub(super) fn signs_enclosed(&self, value: &Value) -> Option<Signs> {
        signs_at(value, &self.ranges(value)?)
    }

    /// The integer part of a value, where the numbers that its variables lie between tell it.
    pub(super) fn floor_enclosed(&self, value: &Value) -> Option<BigRational> {
        let (low, high) = range_of(value, &self.ranges(value)?, MOST_NESTED)?;
        let floor = low >> BITS;
        (floor == high >> BITS).then(|| BigRational::from_integer(floor))
    }

    /// Where the variables of a value lie; none where nothing is known of one, or there are none or too many.
    fn ranges(&self, value: &Value) -> Option<Ranges> {
        let names = value.variables();
        if names.is_empty() || names.len() > MOST_NAMES {
            return None;
        }
        let range = |name: Name| {
            let range = self.range(&name);
            (range != (None, None)).then_some((name, range))
        };
        names.into_iter().map(range).collect()
    }

    /// The numbers that facts about a variable alone put it between; whole ones, if it is natural.
    pub(super) fn range(&self, name: &Name) -> (Option<BigRational>, Option<BigRational>) {
        let natural = self.naturals.contains(name);
        let one = |strict: bool| if strict { BigRational::one() } else { BigRational::zero() };
        let (mut low, mut high): (Option<BigRational>, Option<BigRational>) = (None, None);
        for constraint in self.constraints.iter().filter(|constraint| constraint.form.terms().len() <= 2) {
            let Some((factor, rest)) = line(&constraint.form, name) else { continue };
            let end = -rest / &factor;
            let (below, above) = match constraint.bound {
                Bound::Zero => (true, true),
                _ => (factor.is_positive(), factor.is_negative()),
            };
            let next = one(natural && end.is_integer() && matches!(constraint.bound, Bound::Positive));
            let whole = |end: BigRational, up: bool| match (natural, up) {
                (false, _) => end,
                (true, true) => end.ceil() + &next,
                (true, false) => end.floor() - &next,
            };
            let (from, until) = (whole(end.clone(), true), whole(end, false));
            if below && low.as_ref().is_none_or(|low| *low < from) {
                low = Some(from);
            }
            if above && high.as_ref().is_none_or(|high| *high > until) {
                high = Some(until);
            }
        }
        (low, high)
    }
}

/// The signs that a value may have where its variables lie there; none where that is not found out.
pub(super) fn signs_at(value: &Value, ranges: &Ranges) -> Option<Signs> {
    let (low, high) = range_of(value, ranges, MOST_NESTED)?;
    let mut signs = if low.is_positive() || high.is_negative() { Signs::NONZERO } else { Signs::ANY };
    if !low.is_negative() {
        signs = signs.and(Signs::NONNEGATIVE);
    }
    if !high.is_positive() {
        signs = signs.and(Signs::NONNEGATIVE.flipped());
    }
    Some(signs)
}

/// The factor of a variable and the constant beside it, of a sum of nothing else.
fn line(form: &Polynomial<Atom>, name: &Name) -> Option<(BigRational, BigRational)> {
    let (mut factor, mut rest) = (None, BigRational::zero());
    for (monomial, number) in form.terms() {
        match monomial.factors() {
            [] => rest = number.clone(),
            [(Atom::Variable(own), 1)] if own == name => factor = Some(number.clone()),
            _ => return None,
        }
    }
    Some((factor?, rest))
}

/// Where a real lies, wherever it has a value.
fn range_of(value: &Value, ranges: &Ranges, nested: usize) -> Option<Range> {
    let (numerator, denominator) = value.polynomials()?;
    if let [(below, number)] = denominator.terms()
        && let Some(bases) = below.factors().iter().try_fold(Bases::new(), with_power)
    {
        let bases = bases.into_iter().map(|(name, base)| (name, base.recip())).collect();
        let above = range_of_sum(numerator, &bases, ranges, nested)?;
        return Some(times(&above, &scaled(&number.recip())));
    }
    let above = range_of_sum(numerator, &Bases::new(), ranges, nested)?;
    let (low, high) = range_of_sum(denominator, &Bases::new(), ranges, nested)?;
    if !low.is_positive() && !high.is_negative() {
        return None;
    }
    // 1/x falls on either side of 0.
    let one = BigInt::one() << (2 * BITS);
    Some(times(&above, &(one.div_floor(&high), one.div_ceil(&low))))
}

/// Of each variable the number whose power it is the exponent of.
type Bases = BTreeMap<Name, BigRational>;

/// The numbers with that of one more power of a number; none where it is something else.
fn with_power(mut bases: Bases, (atom, times): &(Atom, u32)) -> Option<Bases> {
    let Atom::Power(base, exponent) = atom else { return None };
    let base = base.as_rational().filter(|base| !base.is_zero() && *times <= MOST_EXPONENT)?;
    let entry = bases.entry(exponent.as_variable()?.clone()).or_insert_with(BigRational::one);
    *entry *= base.pow(i32::try_from(*times).ok()?);
    Some(bases)
}

/// What has the same atoms but for roots of numbers is taken together: of `2*x - x*sqrt(10)` x comes out. It all is
/// multiplied with the powers of these numbers.
fn range_of_sum(sum: &Polynomial<Atom>, bases: &Bases, ranges: &Ranges, nested: usize) -> Option<Range> {
    if sum.terms().len() > MOST_TERMS {
        return None;
    }
    let mut groups: BTreeMap<Vec<&(Atom, u32)>, Range> = BTreeMap::new();
    for (monomial, number) in sum.terms() {
        let (numbers, rest): (Vec<_>, Vec<_>) =
            monomial.factors().iter().partition(|(atom, _)| atom.is_root_of_number());
        let factor = product(scaled(number), &numbers, ranges, nested)?;
        let group = groups.entry(rest).or_default();
        *group = (&group.0 + factor.0, &group.1 + factor.1);
    }
    let mut total = (BigInt::zero(), BigInt::zero());
    for (atoms, factor) in groups {
        let (mut bases, mut rest) = (bases.clone(), Vec::new());
        for one in atoms {
            match with_power(bases.clone(), one) {
                Some(more) => bases = more,
                None => rest.push(one),
            }
        }
        let mut term = product(factor, &rest, ranges, nested)?;
        for (name, base) in bases.iter().filter(|(_, base)| !base.is_one()) {
            term = times(&term, &range_of_power(base, ranges.get(name)?)?);
        }
        total = (total.0 + term.0, total.1 + term.1);
    }
    Some(total)
}

fn product(start: Range, factors: &[&(Atom, u32)], ranges: &Ranges, nested: usize) -> Option<Range> {
    factors.iter().try_fold(start, |product, (atom, exponent)| {
        Some(times(&product, &power(&range_of_atom(atom, ranges, nested.checked_sub(1)?)?, *exponent)?))
    })
}

fn range_of_atom(atom: &Atom, ranges: &Ranges, nested: usize) -> Option<Range> {
    let whole = |number: i64| BigInt::from(number) << BITS;
    match atom {
        Atom::Variable(name) => {
            let (low, high) = ranges.get(name)?;
            Some((scaled(low.as_ref()?).0, scaled(high.as_ref()?).1))
        }
        // Where it has a value, what it is taken of is not negative.
        Atom::Root(inner) => {
            let (low, high) = range_of(inner, ranges, nested)?;
            let low = low.max(BigInt::zero());
            (!high.is_negative()).then(|| ((low << BITS).sqrt(), (high << BITS).sqrt() + BigInt::one()))
        }
        Atom::Maximum(elements) => {
            let zero = (BigInt::zero(), BigInt::zero());
            elements.iter().try_fold(zero, |(low, high), element| {
                let own = range_of(element, ranges, nested)?;
                Some((low.max(own.0), high.max(own.1)))
            })
        }
        Atom::Positive(inner) => {
            let (low, high) = range_of(inner, ranges, nested)?;
            Some((whole(i64::from(low.is_positive())), whole(i64::from(high.is_positive()))))
        }
        Atom::Floor(inner) => {
            let (low, high) = range_of(inner, ranges, nested)?;
            Some(((low >> BITS) << BITS, (high >> BITS) << BITS))
        }
        Atom::Power(..) | Atom::Apply(..) => None,
    }
}

/// Where a power of a number lies, by the numbers that its exponent lies between: one of a base below 1 comes down to 0.
fn range_of_power(base: &BigRational, (low, high): &(Option<BigRational>, Option<BigRational>)) -> Option<Range> {
    let size = base.abs();
    let at = |exponent: BigRational| {
        let exponent = exponent.to_integer().to_i32().filter(|exponent| exponent.abs() <= HIGHEST)?;
        (size.numer().bits().max(size.denom().bits()) <= LONGEST).then(|| scaled(&size.pow(exponent)))
    };
    let first = low.as_ref().and_then(|low| at(low.floor()));
    let last = high.as_ref().and_then(|high| at(high.ceil()));
    let (first, last) = if size < BigRational::one() { (last, first) } else { (first, last) };
    let most = if size.is_one() { BigInt::one() << BITS } else { last?.1 };
    let least = first.map_or_else(BigInt::zero, |first| first.0);
    if base.is_positive() { Some((least, most)) } else { Some((-&most, most)) }
}

fn power(range: &Range, exponent: u32) -> Option<Range> {
    if exponent > MOST_EXPONENT {
        return None;
    }
    let mut product = range.clone();
    for _ in 1..exponent {
        product = times(&product, range);
    }
    // What is multiplied with itself an even number of times is not negative.
    if exponent.is_multiple_of(2) {
        product.0 = product.0.max(BigInt::zero());
    }
    Some(product)
}

fn times(one: &Range, other: &Range) -> Range {
    let products = [&one.0 * &other.0, &one.0 * &other.1, &one.1 * &other.0, &one.1 * &other.1];
    let least = products.iter().min().cloned().unwrap_or_default();
    let most = products.iter().max().cloned().unwrap_or_default();
    // A shift to the right goes down.
    let exact = most.is_zero() || most.trailing_zeros().is_some_and(|zeros| zeros >= BITS as u64);
    (least >> BITS, (most >> BITS) + if exact { BigInt::zero() } else { BigInt::one() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::value::Relation;

    fn between(facts: &[(&str, i64, i64)]) -> Assumptions {
        let mut known = Assumptions::default();
        for (name, low, high) in facts {
            let variable = Value::variable(&Name::new(name));
            known.assume(Relation::Gte, &variable, &Value::fraction(*low, 100).unwrap());
            known.assume(Relation::Lte, &variable, &Value::fraction(*high, 100).unwrap());
        }
        known
    }

    fn samples((low, high): (i64, i64)) -> impl Iterator<Item = f64> + Clone {
        (0..=8).map(move |place| (low as f64 + (high - low) as f64 * f64::from(place) / 8.0) / 100.0)
    }

    /// Of values that machine numbers are computed for at many points, none lies on a side that was excluded.
    #[test]
    fn no_point_lies_on_an_excluded_side() {
        let (x, y) = (Value::variable(&Name::new("x")), Value::variable(&Name::new("y")));
        let whole = Value::integer;
        let far = |a: i64, b: i64| Value::vector(vec![x.sub(&whole(a)).unwrap(), y.sub(&whole(b)).unwrap()]).unwrap();
        let mut decided = 0;
        for (a, b) in [(3, 4), (-2, 1), (0, 0), (1, -1)] {
            let length = far(a, b).norm().unwrap();
            for bound in [1, 2, 4, 5, 9] {
                let value = [
                    length.sub(&whole(bound)).unwrap(),
                    whole(1).div(&length.add(&x).unwrap()).and_then(|part| part.sub(&whole(bound))).unwrap(),
                    Value::maximum(&[x.clone(), y.clone()])
                        .unwrap()
                        .sub(&length.floor().unwrap())
                        .unwrap()
                        .add(&whole(bound - 4))
                        .unwrap(),
                ];
                for (one, other) in [((10, 12), (30, 33)), ((-210, -200), (95, 105)), ((290, 310), (399, 401))] {
                    let known = between(&[("x", one.0, one.1), ("y", other.0, other.1)]);
                    for (kind, value) in value.iter().enumerate() {
                        let Some(signs) = known.signs_enclosed(value) else { continue };
                        decided += usize::from(signs != Signs::ANY);
                        for (x, y) in samples(one).flat_map(|x| samples(other).map(move |y| (x, y))) {
                            let length = (x - a as f64).hypot(y - b as f64);
                            let near = match kind {
                                0 => length - bound as f64,
                                1 => 1.0 / (length + x) - bound as f64,
                                _ => x.max(y) - length.floor() + (bound - 4) as f64,
                            };
                            if near.abs() > 1e-9 {
                                let own = if near > 0.0 { Signs::POSITIVE } else { Signs::NEGATIVE };
                                assert!(own.within(signs), "{value} at {x}, {y}");
                            }
                        }
                    }
                }
            }
        }
        assert!(decided > 100, "{decided}");
    }

    #[test]
    fn powers_come_down_or_grow() {
        let n = Value::variable(&Name::new("n"));
        let power = |top, bottom| Value::fraction(top, bottom).unwrap().power(&n).unwrap();
        let mut known = Assumptions::default();
        known.assume(Relation::Gte, &n, &Value::integer(3));
        let less = |value: &Value, top, bottom| {
            known.signs_enclosed(&value.sub(&Value::fraction(top, bottom).unwrap()).unwrap())
        };
        assert_eq!(less(&power(1, 2), 13, 100), Some(Signs::NEGATIVE));
        assert_eq!(less(&power(1, 2), 12, 100), Some(Signs::ANY));
        assert_eq!(less(&power(1, 2), 1, 8), Some(Signs::NONNEGATIVE.flipped()));
        assert_eq!(less(&power(3, 2), 3, 1), None, "it grows");
        assert_eq!(less(&power(-1, 2), 1, 10), Some(Signs::ANY));
        assert_eq!(less(&power(-1, 2), 13, 100), Some(Signs::NEGATIVE));
        known.assume(Relation::Lte, &n, &Value::fraction(9, 2).unwrap());
        let less = |value: &Value, top, bottom| {
            known.signs_enclosed(&value.sub(&Value::fraction(top, bottom).unwrap()).unwrap())
        };
        assert_eq!(less(&power(3, 2), 3, 1), Some(Signs::POSITIVE));
        assert_eq!(less(&power(3, 2), 8, 1), Some(Signs::NEGATIVE));
        assert_eq!(less(&power(1, 2), 1, 33), Some(Signs::POSITIVE));
    }

    #[test]
    fn ends_count_and_what_is_not_bounded_is_left_to_others() {
        let x = Value::variable(&Name::new("x"));
        let known = between(&[("x", 0, 100)]);
        assert_eq!(known.signs_enclosed(&x), Some(Signs::NONNEGATIVE));
        assert_eq!(known.signs_enclosed(&x.sub(&Value::integer(1)).unwrap()), Some(Signs::NONNEGATIVE.flipped()));
        assert_eq!(known.signs_enclosed(&x.add(&Value::variable(&Name::new("y"))).unwrap()), None);
        assert_eq!(known.signs_enclosed(&Value::integer(1).div(&x).unwrap()), None);
        assert_eq!(known.signs_enclosed(&Value::integer(3)), None);
        let root = Value::integer(10).sqrt().unwrap().mul(&Value::integer(10)).unwrap();
        let whole = |value: &Value| known.floor_enclosed(value).map(|floor| floor.to_integer().to_i64());
        let fourth = x.div(&Value::integer(4)).unwrap();
        assert_eq!(whole(&root.add(&fourth).unwrap()), Some(Some(31)), "31.6 to 31.9");
        assert_eq!(whole(&root.sub(&x).unwrap()), None, "30.6 to 31.6");
    }
}
