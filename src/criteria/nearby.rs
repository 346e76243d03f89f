//! How margins go right beside the value that a parameter has: as `(a + b*x) / (c + d*x)`, found from exact margins at
//! values so near that the run takes the same ways there.
//!
//! A formula stands only if it meets more points than it was made from. Nothing is decided by it: what is said to
//! repair a criterion is judged again.

use std::collections::BTreeMap;

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use crate::name::Name;
use crate::value::Value;

/// Points that a formula must meet; three of them determine it.
const POINTS: i64 = 5;
/// Bits by which the points differ from the value.
const BITS: u32 = 60;

/// `(a + b*x) / (c + d*x)`
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Formula {
    above: [BigRational; 2],
    below: [BigRational; 2],
}

impl Formula {
    /// Through all points; none where there is no such formula.
    fn through(points: &[(BigRational, BigRational)]) -> Option<Formula> {
        let [(x, u), (y, v), (z, w), ..] = points else { return None };
        let slope = |x: &BigRational, u: &BigRational, y: &BigRational, v: &BigRational| {
            let run = y - x;
            (!run.is_zero()).then(|| (v - u) / run)
        };
        let (first, second) = (slope(x, u, y, v)?, slope(y, v, z, w)?);
        let formula = if first == second {
            Formula { above: [u - &first * x, first], below: [BigRational::one(), BigRational::zero()] }
        } else {
            // u + (p - x) / (s + (p - y) / t), a continued fraction by Thiele.
            if first.is_zero() {
                return None;
            }
            let s = first.recip();
            let other = slope(x, u, z, w).filter(|slope| !slope.is_zero())?.recip();
            let t = (z - y) / (&other - &s);
            let below = [&s * &t - y, BigRational::one()];
            Formula { above: [u * &below[0] - x * &t, u + &t], below }
        };
        let meets = |(x, u): &(BigRational, BigRational)| formula.at(x).as_ref() == Some(u);
        points.iter().all(meets).then_some(formula)
    }

    /// Its value; none where it has none.
    pub(super) fn at(&self, x: &BigRational) -> Option<BigRational> {
        let below = &self.below[0] + &self.below[1] * x;
        (!below.is_zero()).then(|| (&self.above[0] + &self.above[1] * x) / below)
    }

    /// Where it is 0.
    pub(super) fn root(&self) -> Option<BigRational> {
        let root = (!self.above[1].is_zero()).then(|| -&self.above[0] / &self.above[1])?;
        self.at(&root).filter(Zero::is_zero).map(|_| root)
    }

    /// How steep it is.
    pub(super) fn slope(&self, x: &BigRational) -> Option<BigRational> {
        let below = &self.below[0] + &self.below[1] * x;
        let top = &self.above[1] * &self.below[0] - &self.above[0] * &self.below[1];
        (!below.is_zero()).then(|| top / (&below * &below))
    }

    /// As a formula to read.
    pub(super) fn value(&self, name: &Name) -> Option<Value> {
        let line = |[constant, factor]: &[BigRational; 2]| {
            let rest = Value::variable(name).scale(factor).ok()?;
            Value::rational(constant.clone()).add(&rest).ok()
        };
        line(&self.above)?.div(&line(&self.below)?).ok()
    }
}

/// The margins right above a value, or right below it, by criterion.
pub(super) fn nearby(
    value: &BigRational,
    up: bool,
    margins: &dyn Fn(&BigRational) -> Option<BTreeMap<Name, BigRational>>,
) -> BTreeMap<Name, Formula> {
    let size = if value.is_zero() { BigRational::one() } else { value.abs() };
    let step = size / BigRational::from_integer(BigInt::from(1_u64 << BITS));
    let step = if up { step } else { -step };
    let mut points: BTreeMap<Name, Vec<(BigRational, BigRational)>> = BTreeMap::new();
    for place in 1..=POINTS {
        let there = value + &step * BigRational::from_integer(place.into());
        let Some(found) = margins(&there) else { return BTreeMap::new() };
        for (name, margin) in found {
            points.entry(name).or_default().push((there.clone(), margin));
        }
    }
    let whole = |points: &Vec<(BigRational, BigRational)>| points.len() == POINTS as usize;
    points
        .into_iter()
        .filter(|(_, points)| whole(points))
        .filter_map(|(name, points)| Some((name, Formula::through(&points)?)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(above: i64, below: i64) -> BigRational {
        BigRational::new(above.into(), below.into())
    }

    fn of(margin: impl Fn(&BigRational) -> BigRational, value: &BigRational, up: bool) -> Option<Formula> {
        let name = Name::new("margin");
        let margins = |x: &BigRational| Some(BTreeMap::from([(name.clone(), margin(x))]));
        nearby(value, up, &margins).remove(&name)
    }

    #[test]
    fn lines_and_quotients_are_found_exactly() {
        let line = of(|x| number(10, 1) - x * number(20, 3), &number(1, 2), true).expect("a line");
        assert_eq!(line.root(), Some(number(3, 2)));
        assert_eq!(line.slope(&number(1, 2)), Some(number(-20, 3)));
        // 10 - 20/x: a time against a speed.
        let time = of(|x| number(10, 1) - number(20, 1) / x, &number(1, 1), true).expect("a quotient");
        assert_eq!(time.root(), Some(number(2, 1)));
        assert_eq!(time.slope(&number(1, 1)), Some(number(20, 1)));
        let (name, four) = (Name::new("v"), Value::integer(4));
        let there = time.value(&name).and_then(|value| value.with(&name, &four).ok());
        assert_eq!(there, Some(Value::integer(5)));
    }

    #[test]
    fn each_side_has_a_formula_of_its_own() {
        let bend = |x: &BigRational| if *x > number(1, 1) { x.clone() } else { number(3, 1) * x };
        let slope = |up| of(bend, &number(1, 1), up).and_then(|formula| formula.slope(&number(1, 1)));
        assert_eq!((slope(true), slope(false)), (Some(number(1, 1)), Some(number(3, 1))));
    }

    #[test]
    fn what_is_no_such_formula_has_none() {
        assert_eq!(of(|x| x * x * x, &number(1, 1), true), None);
        assert_eq!(of(|x| x * x, &number(1, 1), false), None);
    }
}
