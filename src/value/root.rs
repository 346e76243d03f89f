//! Roots, integer parts, lengths.

use std::cmp::Ordering;

use num_bigint::BigInt;
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use super::denominator::leading_root;
use super::line::{Place, placed};
use super::power::{is_of_powers, with_powers};
use super::squares::{
    after_a_step_in_line, as_squares, rational_root, square_root, square_with_numbers, square_with_root, squares,
};
use super::{Atom, Content, Outcome, Real, Relation, Value, ValueError};
use crate::polynomial::{Monomial, Polynomial};

impl Value {
    /// The greatest integer that is not greater.
    ///
    /// # Errors
    /// Of a vector or distribution.
    pub fn floor(&self) -> Result<Value, ValueError> {
        if let Some(number) = self.as_rational() {
            return Ok(Value::rational(number.floor()));
        }
        if let Some((low, high)) = self.enclosure()
            && low.floor() == high.floor()
        {
            return Ok(Value::rational(low.floor()));
        }
        let (numerator, denominator) = self.real()?;
        if let (false, Some((lead, _))) = (denominator.is_one(), denominator.terms().first()) {
            // n + x/d has the numerator n*d + x: the whole multiple of d comes out, where d is one term also that by integers.
            let alone = denominator.terms().len() == 1;
            let integers = numerator.terms().iter().filter_map(|(monomial, number)| {
                let times = monomial.over(lead)?;
                let whole = if times.factors().is_empty() { number.floor() } else { number.clone() };
                let integral = times.factors().iter().all(|(atom, _)| alone && atom.is_integral());
                (integral && whole.is_integer()).then_some((times, whole))
            });
            let whole = Value::whole(Polynomial::of(integers.collect::<Vec<_>>()))?;
            if whole.is_zero() {
                return Atom::Floor(self.clone()).value();
            }
            let rest = self.sub(&whole)?;
            if rest.parts().is_some_and(|(_, denominator)| denominator.is_one()) {
                return rest.floor()?.add(&whole);
            }
            return Atom::Floor(rest).value()?.add(&whole);
        }
        let mut integers = Vec::new();
        for (monomial, number) in numerator.terms() {
            if monomial.factors().is_empty() {
                integers.push((monomial.clone(), number.floor()));
            } else if number.is_integer() && monomial.factors().iter().all(|(atom, _)| atom.is_integral()) {
                integers.push((monomial.clone(), number.clone()));
            }
        }
        let integers = Polynomial::of(integers);
        let rest = numerator.minus(&integers);
        let integers = Value::whole(integers)?;
        // What is left of a number is at least 0 and less than 1.
        if rest.as_constant().is_some() {
            Ok(integers)
        } else {
            Atom::Floor(Value::whole(rest)?).value()?.add(&integers)
        }
    }

    /// Numbers between which a number with roots of numbers lies; none of anything else.
    pub(crate) fn enclosure(&self) -> Option<Bounds> {
        let (numerator, denominator) = self.real().ok()?;
        if numerator.atoms().is_empty() && denominator.atoms().is_empty() {
            return None;
        }
        let (Some(top), Some(below)) = (between(numerator), between(denominator)) else {
            let number = |number| BigRational::new(number, BigInt::one() << super::fixed::BITS);
            return self.coarse_range().map(|(low, high)| (number(low), number(high)));
        };
        let crosses = !below.0.is_positive() && !below.1.is_negative();
        (!crosses).then(|| product(&top, &(below.1.recip(), below.0.recip())))
    }

    /// Whether a number with roots is less or greater than 0, where that is found out; none of anything else.
    pub(crate) fn order_of_roots(&self) -> Option<Ordering> {
        let sign = || {
            let (low, high) = self.enclosure()?;
            if low.is_positive() { Some(Ordering::Greater) } else { high.is_negative().then_some(Ordering::Less) }
        };
        self.coarse_order().or_else(sign)
    }

    /// The least integer that is not less.
    ///
    /// # Errors
    /// Of a vector or distribution.
    pub fn ceiling(&self) -> Result<Value, ValueError> {
        self.neg()?.floor()?.neg()
    }

    /// The square root that is not negative.
    ///
    /// # Errors
    /// Of a negative number, a vector or a distribution.
    pub fn sqrt(&self) -> Result<Value, ValueError> {
        let (numerator, denominator) = self.real()?;
        if let Some(number) = self.as_rational() {
            if number.is_negative() {
                return Err(ValueError(format!("{number} has no square root")));
            }
            return root_of_number(&number);
        }
        if self.order_of_roots() == Some(Ordering::Less) {
            return Err(ValueError(format!("{self} is negative and has no square root")));
        }
        if denominator.is_one() {
            return root_of_polynomial(numerator);
        }
        if let Some(left) = after_a_step_in_line(numerator, denominator) {
            return left.abs();
        }
        let both = [numerator, denominator].map(|part| Value::whole(part.clone()));
        let [top, bottom] = [both[0].clone()?, both[1].clone()?];
        let signed = top.plainly_nonnegative() || is_of_powers(denominator);
        if signed && bottom.plainly_nonnegative() {
            return top.sqrt()?.div(&bottom.sqrt()?);
        }
        let content = numerator.content();
        root_of_number(&content)?.mul(&Atom::Root(self.scale(&content.recip())?).value()?)
    }

    /// The length of a vector; of a number, its absolute value.
    ///
    /// # Errors
    /// Of a distribution.
    pub fn norm(&self) -> Result<Value, ValueError> {
        self.in_each_choice(&|whole| whole.length())
    }

    fn length(&self) -> Outcome {
        let Content::Vector(parts) = &self.0.content else {
            return self.abs();
        };
        let parts: Vec<&Value> = parts.iter().filter(|part| !part.is_zero()).collect();
        if let [only] = parts.as_slice() {
            return only.abs();
        }
        let mut sum = Value::zero();
        for part in parts {
            sum = sum.add(&part.mul(part)?)?;
        }
        sum.sqrt()
    }

    /// The vector of length 1 in the same direction; of a number, its sign: 1, -1, and 0 of 0.
    ///
    /// # Errors
    /// Of the vector 0 or a distribution.
    pub fn unit(&self) -> Result<Value, ValueError> {
        if let Content::Vector(_) = &self.0.content {
            return self.in_each_choice(&|whole| whole.over(&whole.length()?));
        }
        Value::truth(Relation::Gtr, self, &Value::zero())?.sub(&Value::truth(Relation::Lss, self, &Value::zero())?)
    }
}

impl Value {
    /// Of a vector in whose components conditions stand, the image of what is chosen in each case: the length of a choice is
    /// the choice of lengths.
    fn in_each_choice(&self, image: &dyn Fn(&Value) -> Outcome) -> Outcome {
        let conditions = || self.atoms().into_iter().filter(|atom| matches!(atom, Atom::Positive(_)));
        let (Content::Vector(parts), Some(atom)) = (&self.0.content, conditions().next()) else { return image(self) };
        if conditions().count() > MOST_CONDITIONS {
            return image(self);
        }
        let chosen = |place: Place| {
            let part = |part: &Value| {
                let (above, below) = part.real()?;
                Value::quotient(placed(above, &atom, place), placed(below, &atom, place))
            };
            let parts = Value::each(parts, part)?;
            if parts.atoms().contains(&atom) { image(&parts) } else { parts.in_each_choice(image) }
        };
        let (Ok(holds), Ok(fails)) = (chosen(Place::Holds), chosen(Place::Fails)) else { return image(self) };
        let condition = atom.value()?;
        condition.mul(&holds)?.add(&Value::one().sub(&condition)?.mul(&fails)?)
    }
}

/// The most conditions in a vector in each case of which its length is looked at.
const MOST_CONDITIONS: usize = 8;

impl Atom {
    /// Whether it is an integer whatever its variables are; a name in an exponent is natural, and `floor(x)` may be below 0.
    pub(crate) fn is_integral(&self) -> bool {
        match self {
            Atom::Floor(_) | Atom::Positive(_) => true,
            Atom::Power(base, exponent) => {
                exponent.counts() && base.as_rational().is_some_and(|base| base.is_integer())
            }
            _ => false,
        }
    }
}

/// The bits behind the point of the bounds of a root.
const PRECISION: u64 = 256;

/// The most bits of a number whose root is enclosed.
const LONGEST: u64 = 1 << 16;

/// A lower and an upper bound.
type Bounds = (BigRational, BigRational);

fn root_between((above, below): &super::fixed::Quotient) -> Option<Bounds> {
    if above.is_negative() || above.bits() + below.bits() > LONGEST {
        return None;
    }
    let low = ((above << (2 * PRECISION)) / below).sqrt();
    let unit = BigInt::one() << PRECISION;
    Some((BigRational::new(low.clone(), unit.clone()), BigRational::new(low + BigInt::one(), unit)))
}

fn product(one: &Bounds, other: &Bounds) -> Bounds {
    let all = [&one.0 * &other.0, &one.0 * &other.1, &one.1 * &other.0, &one.1 * &other.1];
    let (mut low, mut high) = (all[0].clone(), all[0].clone());
    for number in all {
        low = low.min(number.clone());
        high = high.max(number);
    }
    (low, high)
}

fn between(polynomial: &Real) -> Option<Bounds> {
    let mut sum = (BigRational::zero(), BigRational::zero());
    for (monomial, number) in polynomial.terms() {
        let term = match (super::fixed::squared(monomial, number)?, number.is_negative()) {
            ((None, nested), _) if nested.is_empty() => (number.clone(), number.clone()),
            ((Some(square), nested), false) if nested.is_empty() => root_between(&square)?,
            ((Some(square), nested), true) if nested.is_empty() => {
                root_between(&square).map(|(low, high)| (-high, -low))?
            }
            _ => return None,
        };
        sum = (sum.0 + term.0, sum.1 + term.1);
    }
    Some(sum)
}

/// `sqrt(p/q) = sqrt(p*q)/q`, as the roots of different small primes.
pub(super) fn root_of_number(number: &BigRational) -> Outcome {
    let mut rational = BigRational::new(BigInt::one(), number.denom().clone());
    let mut roots = Vec::new();
    let product = number.numer() * number.denom();
    let whole = product.sqrt();
    if &whole * &whole == product {
        return Ok(Value::rational(rational * BigRational::from_integer(whole)));
    }
    for (factor, count) in super::power::factors(&product) {
        let root = factor.sqrt();
        let exact = &root * &root == factor;
        if exact {
            rational *= BigRational::from_integer(root.pow(count));
            continue;
        }
        rational *= BigRational::from_integer(factor.pow(count / 2));
        if count.is_odd() {
            roots.push((Atom::Root(Value::rational(BigRational::from_integer(factor))), 1));
        }
    }
    let monomial = Monomial::of(roots).ok_or_else(ValueError::too_large)?;
    Value::whole(Polynomial::term(monomial, rational))
}

/// The root of a polynomial: its content, and squares in what divides every term where the rest is not negative,
/// come out.
fn root_of_polynomial(polynomial: &Real) -> Outcome {
    if let Some((powers, rest)) = with_powers(polynomial) {
        return powers.mul(&root_of_polynomial(&rest)?);
    }
    let mut content = polynomial.content();
    let mut outer = Value::one();
    let mut inner = polynomial.scale(&content.recip());
    let mut even = Vec::new();
    let mut roots = Vec::new();
    for (atom, exponent) in polynomial.monomial_content().factors() {
        even.push((atom.clone(), exponent - exponent % 2));
        roots.push((atom.clone(), exponent / 2));
    }
    let square = Monomial::of(even).ok_or_else(ValueError::too_large)?;
    let rest = inner.without(&square);
    if Value::whole(rest.clone())?.plainly_nonnegative() || squares(&rest).is_some() || as_squares(&rest).is_some() {
        let root = Monomial::of(roots).ok_or_else(ValueError::too_large)?;
        outer = outer.mul(&Value::whole(Polynomial::term(root, BigRational::one()))?.abs()?)?;
        inner = rest;
    }
    // The length of a vector is the root of what shows its components.
    if let Some((times, multiple)) = as_squares(&inner) {
        (content, inner) = (content / times, multiple);
    }
    let number = root_of_number(&content)?;
    if inner.is_one() {
        return number.mul(&outer);
    }
    let symbols = outer.clone();
    let outer = number.mul(&outer)?;
    if let Some((greater, lesser)) = denested(&inner) {
        return outer.mul(&root_of_number(&greater)?.add(&root_of_number(&lesser.0)?.scale(&lesser.1)?)?);
    }
    let length = match squares(&inner).or_else(|| square_with_root(&inner)).as_deref() {
        Some([length]) => Some(length.clone()),
        _ => match square_root(&inner) {
            None => square_with_numbers(&inner)?,
            found => found,
        },
    };
    if let Some(length) = length {
        // A number with roots goes back to where it leaves none in front.
        let within = leading_root(&length).is_some();
        let length = Value::whole(length)?;
        return if within { symbols.mul(&number.mul(&length)?.abs()?) } else { outer.mul(&length.abs()?) };
    }
    outer.mul(&Atom::Root(Value::whole(inner)?).value()?)
}

/// `sqrt(a + b*sqrt(c)) = sqrt((a+d)/2) + sign(b)*sqrt((a-d)/2)` where a is positive and `d^2 = a^2 - b^2*c` for a number
/// d: both sides are not negative, and their squares are equal. The numbers under both roots, and the sign.
fn denested(polynomial: &Real) -> Option<(BigRational, (BigRational, BigRational))> {
    let [one, other] = polynomial.terms() else { return None };
    let (number, rooted) = if one.0.factors().is_empty() { (one, other) } else { (other, one) };
    if !number.0.factors().is_empty() || !number.1.is_positive() {
        return None;
    }
    let mut square = &rooted.1 * &rooted.1;
    for (atom, exponent) in rooted.0.factors() {
        let (Atom::Root(inner), 1) = (atom, exponent) else { return None };
        square *= inner.as_rational()?;
    }
    let rest = &number.1 * &number.1 - square;
    let distance = rational_root(&rest)?;
    let half = BigRational::new(BigInt::one(), BigInt::from(2));
    let (greater, lesser) = ((&number.1 + &distance) * &half, (&number.1 - &distance) * &half);
    Some((greater, (lesser, rooted.1.signum())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::name::Name;

    #[test]
    fn roots_of_numbers() {
        let root = |number: i64| Value::integer(number).sqrt().unwrap();
        assert_eq!(root(144), Value::integer(12));
        assert_eq!(root(12), root(3).mul(&Value::integer(2)).unwrap());
        assert_eq!(root(6), root(2).mul(&root(3)).unwrap());
        assert!(Value::integer(-1).sqrt().is_err());
    }

    #[test]
    fn roots_of_sums_with_roots() {
        let number = |a: i64, b: i64, c: i64| {
            let root = Value::integer(c).sqrt().unwrap().mul(&Value::integer(b)).unwrap();
            Value::integer(a).add(&root).unwrap()
        };
        // (sqrt(5) - 2)^2, (3 + sqrt(2))^2, (sqrt(7) + sqrt(3))^2
        assert_eq!(number(9, -4, 5).sqrt().unwrap(), number(-2, 1, 5));
        assert_eq!(number(11, 6, 2).sqrt().unwrap(), number(3, 1, 2));
        let sum = Value::integer(7).sqrt().unwrap().add(&Value::integer(3).sqrt().unwrap()).unwrap();
        assert_eq!(number(10, 2, 21).sqrt().unwrap(), sum);
        let (x, two) = (Value::variable(&Name::new("x")), Value::integer(2));
        let length = Value::vector(vec![x.clone(), Value::variable(&Name::new("y"))]).unwrap().norm().unwrap();
        let sum = length.mul(&Value::integer(3)).unwrap().sub(&x.mul(&two).unwrap()).unwrap();
        assert_eq!(sum.mul(&sum).unwrap().sqrt().unwrap(), sum.abs().unwrap());
        let product = x.mul(&Value::variable(&Name::new("y"))).unwrap().sub(&x).unwrap().add(&two).unwrap();
        assert_eq!(product.mul(&product).unwrap().sqrt().unwrap(), product.abs().unwrap());
        let sum = x.sub(&two).unwrap();
        assert_eq!(sum.mul(&sum).unwrap().sqrt().unwrap(), sum.abs().unwrap());
        // 1 + sqrt(2) is no square of a sum of two roots of numbers.
        let nested = number(1, 1, 2).sqrt().unwrap();
        assert_eq!(nested.mul(&nested).unwrap(), number(1, 1, 2));
        assert!(nested.to_string().contains("sqrt(sqrt(2)+1)"), "{nested}");
    }

    #[test]
    fn distances_to_places_in_halves_show_their_components() {
        let [x, y] = ["x", "y"].map(|name| Value::variable(&Name::new(name)));
        let fraction = |top: i64, below: i64| Value::fraction(top, below).unwrap();
        let from = |place: &Value, goal: Value| place.sub(&goal).unwrap();
        for (one, other, shown) in [
            (fraction(5, 2), fraction(7, 2), "1/2*norm((2*x-5,2*y-7))"),
            (fraction(1, 4), fraction(3, 4), "1/4*norm((4*x-1,4*y-3))"),
            (fraction(3, 10), fraction(9, 10), "1/10*norm((10*x-3,10*y-9))"),
            (fraction(5, 2), Value::integer(3), "1/2*norm((2*x-5,2*y-6))"),
        ] {
            let distance = Value::vector(vec![from(&x, one.clone()), from(&y, other.clone())]).unwrap().norm().unwrap();
            assert_eq!(distance.to_string(), shown);
            let square = distance.mul(&distance).unwrap();
            assert!(square.is_sum_of_squares(), "{square}");
            assert_eq!(square.scale(&BigRational::from_integer(8.into())).unwrap().sqrt().unwrap(), {
                distance.mul(&Value::integer(8).sqrt().unwrap()).unwrap()
            });
        }
        // One square, half of which has no root in numbers: sqrt(2*x^2-4*x*y*sqrt(3)+6*y^2).
        let root = y.mul(&Value::integer(3).sqrt().unwrap()).unwrap();
        let part = x.sub(&root).unwrap();
        let twice = part.mul(&part).unwrap().scale(&BigRational::from_integer(2.into())).unwrap();
        assert_eq!(twice.sqrt().unwrap(), Value::integer(2).sqrt().unwrap().mul(&part.abs().unwrap()).unwrap());
    }

    #[test]
    fn unit_of_a_number_is_its_sign() {
        let x = Name::new("x");
        let hidden = Value::maximum(&[Value::variable(&x), Value::zero()]).unwrap().unit().unwrap();
        for (number, sign) in [(-3, 0), (0, 0), (5, 1)] {
            let images = [(x.clone(), Value::integer(number))].into();
            assert_eq!(hidden.substitute(&images).unwrap(), Value::integer(sign));
            assert_eq!(Value::integer(number).unit().unwrap(), Value::integer(number.signum()));
        }
        let zero = Value::vector(vec![Value::zero(), Value::zero()]).unwrap();
        assert!(zero.unit().is_err());
    }

    #[test]
    fn length_of_a_unit_vector() {
        let (x, y) = (Value::variable(&Name::new("x")), Value::variable(&Name::new("y")));
        let vector = Value::vector(vec![x.clone(), y]).unwrap();
        assert_eq!(vector.unit().unwrap().norm().unwrap(), Value::one());
        let norm = vector.norm().unwrap();
        assert_eq!(norm.mul(&norm).unwrap().sqrt().unwrap(), norm);
        let half = x.add(&Value::fraction(7, 2).unwrap()).unwrap();
        let expected = x.add(&Value::fraction(1, 2).unwrap()).unwrap().floor().unwrap();
        assert_eq!(half.floor().unwrap(), expected.add(&Value::integer(3)).unwrap());
    }
}
