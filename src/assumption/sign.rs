//! The signs that a value may have, from the signs of its parts alone.

use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use super::linear::{Bound, Constraint};
use super::{Assumptions, Relation};
use crate::polynomial::{Monomial, Polynomial};
use crate::value::{Atom, Value};

/// A set of signs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Signs(u8);

impl Signs {
    pub(super) const NEGATIVE: Signs = Signs(1);
    pub(super) const ZERO: Signs = Signs(2);
    pub(super) const POSITIVE: Signs = Signs(4);
    pub(super) const NONNEGATIVE: Signs = Signs(6);
    pub(super) const NONZERO: Signs = Signs(5);
    pub(super) const ANY: Signs = Signs(7);

    /// The signs of what stands in the relation to 0.
    pub(super) fn of(relation: Relation) -> Signs {
        match relation {
            Relation::Eq => Signs::ZERO,
            Relation::Neq => Signs::NONZERO,
            Relation::Gtr => Signs::POSITIVE,
            Relation::Gte => Signs::NONNEGATIVE,
            Relation::Lss => Signs::NEGATIVE,
            Relation::Lte => Signs(3),
        }
    }

    /// The signs of what stands in the relation to a number.
    pub(super) fn beyond(relation: Relation, bound: &BigRational) -> Signs {
        let own = Signs::of_number(bound);
        match relation {
            Relation::Eq => own,
            Relation::Neq if bound.is_zero() => Signs::NONZERO,
            Relation::Neq => Signs::ANY,
            Relation::Gtr if !bound.is_negative() => Signs::POSITIVE,
            Relation::Gte if !bound.is_negative() => Signs(own.0 | 4),
            Relation::Lss if !bound.is_positive() => Signs::NEGATIVE,
            Relation::Lte if !bound.is_positive() => Signs(own.0 | 1),
            _ => Signs::ANY,
        }
    }

    pub(super) fn of_number(number: &BigRational) -> Signs {
        if number.is_zero() {
            Signs::ZERO
        } else if number.is_positive() {
            Signs::POSITIVE
        } else {
            Signs::NEGATIVE
        }
    }

    pub(super) fn each() -> [Signs; 3] {
        [Signs::NEGATIVE, Signs::ZERO, Signs::POSITIVE]
    }

    pub(super) fn is_empty(self) -> bool {
        self.0 == 0
    }

    pub(super) fn within(self, other: Signs) -> bool {
        self.0 & !other.0 == 0
    }

    pub(super) fn and(self, other: Signs) -> Signs {
        Signs(self.0 & other.0)
    }

    pub(super) fn or(self, other: Signs) -> Signs {
        Signs(self.0 | other.0)
    }

    pub(super) fn without(self, other: Signs) -> Signs {
        Signs(self.0 & !other.0)
    }

    pub(super) fn flipped(self) -> Signs {
        Signs((self.0 & 2) | (self.0 & 1) << 2 | (self.0 & 4) >> 2)
    }

    /// What is to be found out of a factor where these signs are wanted of the product and the other factor has those.
    pub(super) fn beside(self, other: Signs) -> Signs {
        if other.within(Signs::POSITIVE) {
            self
        } else if other.within(Signs::NEGATIVE) {
            self.flipped()
        } else {
            Signs::ZERO
        }
    }

    /// The signs of a product.
    pub(super) fn times(self, other: Signs) -> Signs {
        let mut result = Signs(0);
        if self.0 & 4 != 0 {
            result = result.or(other);
        }
        if self.0 & 1 != 0 {
            result = result.or(other.flipped());
        }
        if self.0 & 2 != 0 && !other.is_empty() {
            result = result.or(Signs::ZERO);
        }
        result
    }

    /// The signs of a sum.
    pub(super) fn plus(self, other: Signs) -> Signs {
        let mut result = Signs(0);
        for first in Signs::each().into_iter().filter(|sign| sign.within(self)) {
            for second in Signs::each().into_iter().filter(|sign| sign.within(other)) {
                result = result.or(match (first, second) {
                    (Signs::ZERO, sign) | (sign, Signs::ZERO) => sign,
                    (a, b) if a == b => a,
                    _ => Signs::ANY,
                });
            }
        }
        result
    }

    /// The signs of a power.
    pub(super) fn power(self, exponent: u32) -> Signs {
        if exponent.is_odd() {
            return self;
        }
        self.times(self).without(Signs::NEGATIVE)
    }
}

impl Assumptions {
    /// The signs of an atom.
    pub(super) fn atom_signs(&self, atom: &Atom) -> Signs {
        let known = self.signs.get(atom).copied().unwrap_or(Signs::ANY);
        known.and(match atom {
            Atom::Variable(_) | Atom::Apply(..) => Signs::ANY,
            Atom::Power(base, _) => {
                let base = self.of_quotient(base);
                if base.within(Signs::NONZERO) && !base.within(Signs::POSITIVE) {
                    Signs::NONZERO
                } else if base.within(Signs::NONNEGATIVE) {
                    // 0^0 is 1, so a power of 0 may be positive.
                    base.or(Signs::POSITIVE)
                } else {
                    Signs::ANY
                }
            }
            Atom::Maximum(elements) => {
                let signs = elements.iter().map(|element| self.quick(element));
                signs.fold(Signs::ZERO, |all, one| {
                    if one.within(Signs::POSITIVE) || all.within(Signs::POSITIVE) {
                        Signs::POSITIVE
                    } else if one.within(Signs::of(Relation::Lte)) {
                        all
                    } else {
                        Signs::NONNEGATIVE
                    }
                })
            }
            Atom::Positive(part) => {
                let signs = self.quick(part);
                if signs.within(Signs::POSITIVE) {
                    Signs::POSITIVE
                } else if signs.within(Signs::of(Relation::Lte)) {
                    Signs::ZERO
                } else {
                    Signs::NONNEGATIVE
                }
            }
            Atom::Floor(part) => {
                let signs = self.of_quotient(part);
                if signs.within(Signs::NEGATIVE) {
                    Signs::NEGATIVE
                } else if signs.within(Signs::NONNEGATIVE) {
                    Signs::NONNEGATIVE
                } else {
                    Signs::ANY
                }
            }
            // A root is defined only where what stands under it is not negative.
            Atom::Root(part) => {
                let signs = self.quick(part).and(Signs::NONNEGATIVE);
                if signs.is_empty() { Signs::NONNEGATIVE } else { signs }
            }
        })
    }

    /// The signs of a value from those of its numerator and denominator, of which something may be assumed.
    fn of_quotient(&self, value: &Value) -> Signs {
        let signs = self.quick(value);
        let Some((top, below)) = value.polynomials().filter(|_| signs == Signs::ANY) else { return signs };
        let below = self.assumed(below);
        if below.within(Signs::NONZERO) { self.assumed(top).times(below) } else { signs }
    }

    /// The signs of a monomial.
    pub(super) fn monomial_signs(&self, monomial: &Monomial<Atom>) -> Signs {
        let turned = turned(monomial);
        let factors = turned.as_deref().unwrap_or(monomial.factors()).iter();
        factors.fold(Signs::POSITIVE, |signs, (atom, exponent)| signs.times(self.atom_signs(atom).power(*exponent)))
    }

    /// The signs of a polynomial, from the signs of its terms.
    pub(super) fn quick_signs(&self, form: &Polynomial<Atom>) -> Signs {
        let mut sum = Signs::ZERO;
        for (monomial, number) in form.terms() {
            sum = sum.plus(Signs::of_number(number).times(self.monomial_signs(monomial)));
            if sum == Signs::ANY {
                break;
            }
        }
        sum
    }

    /// The signs of a value, from the signs of its terms; any, when its denominator may be 0.
    pub(super) fn quick(&self, value: &Value) -> Signs {
        let Some((numerator, denominator)) = value.polynomials() else {
            return Signs::ANY;
        };
        if denominator.is_one() {
            return self.quick_signs(numerator);
        }
        let below = self.quick_signs(denominator);
        if below.within(Signs::NONZERO) { self.quick_signs(numerator).times(below) } else { Signs::ANY }
    }

    /// A constraint on an integer, as sharp as it can be: `2*n - 1 > 0` is `n - 1 >= 0`.
    pub(super) fn tightened(&self, constraint: Constraint) -> Constraint {
        let Constraint { form, bound } = constraint;
        let content = form.content();
        let form = form.scale(&content.recip());
        let integral = form.terms().iter().all(|(monomial, _)| self.all_integral(monomial));
        if bound == Bound::Zero || !integral || form.as_constant().is_some() {
            return Constraint { form, bound };
        }
        let constant = form.constant_term();
        let rest = form.minus(&Polynomial::constant(constant.clone()));
        let divisor = rest.content();
        let least = if bound == Bound::Positive { constant - BigRational::one() } else { constant };
        let form = rest.scale(&divisor.recip()).plus(&Polynomial::constant((least / divisor).floor()));
        Constraint { form, bound: Bound::Nonnegative }
    }
}

/// The factors of a monomial with `(1-k)^n` for `(-1)^n*(k-1)^n`, of which the sign may be known; nothing where there are none.
pub(super) fn turned(monomial: &Monomial<Atom>) -> Option<Vec<(Atom, u32)>> {
    let odd = |(_, exponent): &(Atom, u32)| exponent.is_odd();
    let sign_of = |(atom, _): &(Atom, u32)| match atom {
        Atom::Power(_, count) if atom.is_sign() => Some(count.clone()),
        _ => None,
    };
    let mut factors = monomial.factors().to_vec();
    let mut found = false;
    for place in 0..factors.len() {
        let Some(count) = factors.get(place).filter(|one| odd(one)).and_then(sign_of) else { continue };
        let pair = factors.iter_mut().find_map(|factor| match &factor.0 {
            Atom::Power(base, own) if *own == count && odd(factor) && !factor.0.is_sign() => {
                Some((base.neg().ok()?, factor))
            }
            _ => None,
        });
        if let Some((base, factor)) = pair {
            factor.0 = Atom::Power(base, count);
            factors[place].1 += 1;
            found = true;
        }
    }
    found.then_some(factors)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::name::Name;

    #[test]
    fn a_power_of_what_is_negative_has_the_sign_of_the_power_of_minus_one() {
        let (k, n, one, zero) =
            (Value::variable(&Name::new("k")), Value::variable(&Name::new("n")), Value::one(), Value::zero());
        let mut known = Assumptions::default();
        known.assume(Relation::Lss, &k, &one);
        let power = k.sub(&one).unwrap().power(&n).unwrap();
        let sign = Value::integer(-1).power(&n).unwrap();
        let both = sign.mul(&power).unwrap();
        let over = sign.div(&power).unwrap();
        let with_factor = over.mul(&k.sub(&one).unwrap()).unwrap();
        for (value, relation, holds) in [
            (&both, Relation::Gtr, Some(true)),
            (&over, Relation::Gtr, Some(true)),
            (&with_factor, Relation::Lss, Some(true)),
            (&power, Relation::Gtr, None),
            (&power, Relation::Neq, Some(true)),
            (&both.mul(&sign).unwrap(), Relation::Gtr, None),
        ] {
            assert_eq!(known.decide(relation, value, &zero), holds, "{value}");
        }
        let nothing = Assumptions::default();
        assert_eq!(nothing.decide(Relation::Gte, &both, &zero), None);
    }

    #[test]
    fn signs_of_sums_and_products() {
        let (minus, plus) = (Signs::NEGATIVE, Signs::POSITIVE);
        assert_eq!(minus.times(minus), plus);
        assert_eq!(minus.plus(plus), Signs::ANY);
        assert_eq!(Signs::NONNEGATIVE.plus(plus), plus);
        assert_eq!(Signs::NONZERO.power(2), plus);
        assert_eq!(Signs::ANY.power(2), Signs::NONNEGATIVE);
        assert_eq!(Signs::ZERO.times(Signs::ANY), Signs::ZERO);
    }
}
