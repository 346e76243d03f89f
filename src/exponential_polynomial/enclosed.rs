//! Numbers between two of a fixed length, times a power of two: the sign of what is far too long to be written down.

use std::cmp::Ordering;

use num_bigint::BigInt;
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{One, Signed, ToPrimitive, Zero};

/// All numbers between `low * 2^exponent` and `high * 2^exponent`.
#[derive(Clone, Debug)]
pub struct Enclosed {
    low: BigInt,
    high: BigInt,
    exponent: i64,
    /// The bits that are kept of either end.
    bits: u64,
}

impl Enclosed {
    /// A number, to so many bits; nothing where its length is none of a machine word.
    pub fn of(number: &BigRational, bits: u64) -> Option<Enclosed> {
        let length = |number: &BigInt| i64::try_from(number.bits()).ok();
        let exponent = length(number.numer())?.checked_sub(length(number.denom())?)?.checked_sub(bits.to_i64()?)?;
        let shift = exponent.unsigned_abs().to_usize()?;
        let (above, below) = match exponent > 0 {
            true => (number.numer().clone(), number.denom() << shift),
            false => (number.numer() << shift, number.denom().clone()),
        };
        let (low, rest) = above.div_mod_floor(&below);
        let high = if rest.is_zero() { low.clone() } else { &low + BigInt::one() };
        Some(Enclosed { low, high, exponent, bits })
    }

    /// The product.
    pub fn times(&self, other: &Enclosed) -> Option<Enclosed> {
        let exponent = self.exponent.checked_add(other.exponent)?;
        let (low, high) = if !self.low.is_negative() && !other.low.is_negative() {
            (&self.low * &other.low, &self.high * &other.high)
        } else {
            let ends = [&self.low, &self.high].map(|one| [one * &other.low, one * &other.high]);
            (ends.iter().flatten().min()?.clone(), ends.iter().flatten().max()?.clone())
        };
        Enclosed { low, high, exponent, bits: self.bits }.shortened()
    }

    /// The sum.
    pub fn plus(&self, other: &Enclosed) -> Option<Enclosed> {
        // What is shorter than the last bit of the longer one counts as one of its last bits.
        let exponent = self.top()?.max(other.top()?).checked_sub(self.bits.to_i64()?)?;
        let (one, two) = (self.at(exponent)?, other.at(exponent)?);
        Some(Enclosed { low: one.low + two.low, high: one.high + two.high, exponent, bits: self.bits })
    }

    /// A power, by squaring.
    pub fn raised(&self, mut exponent: u64) -> Option<Enclosed> {
        let (mut square, mut power) = (self.clone(), Enclosed::of(&BigRational::one(), self.bits)?);
        loop {
            if exponent % 2 == 1 {
                power = power.times(&square)?;
            }
            exponent /= 2;
            if exponent == 0 {
                return Some(power);
            }
            square = square.times(&square)?;
        }
    }

    /// One over it; nothing where it may be 0.
    pub fn inverse(&self) -> Option<Enclosed> {
        if self.sign()? == Ordering::Equal {
            return None;
        }
        let places = usize::try_from(self.low.bits().max(self.high.bits()).max(self.bits)).ok()?.checked_mul(2)?;
        let one = BigInt::one() << places;
        let (low, (above, rest)) = (one.div_floor(&self.high), one.div_mod_floor(&self.low));
        let high = if rest.is_zero() { above } else { above + BigInt::one() };
        let exponent = self.exponent.checked_neg()?.checked_sub(i64::try_from(places).ok()?)?;
        Enclosed { low, high, exponent, bits: self.bits }.shortened()
    }

    /// The greater of two.
    pub fn greater(&self, other: &Enclosed) -> Option<Enclosed> {
        let exponent = self.top()?.max(other.top()?).checked_sub(self.bits.to_i64()?)?;
        let (one, two) = (self.at(exponent)?, other.at(exponent)?);
        Some(Enclosed { low: one.low.max(two.low), high: one.high.max(two.high), exponent, bits: self.bits })
    }

    /// The square root; nothing where it may be of a negative number.
    pub fn root(&self) -> Option<Enclosed> {
        if self.low.is_negative() {
            return None;
        }
        // An even exponent, and twice as many bits as the root is to have.
        let more = (2 * self.bits).saturating_sub(self.high.bits()).to_i64()?;
        let exponent = self.exponent.checked_sub(more)?;
        let even = self.at(exponent - exponent.rem_euclid(2))?;
        let (low, above) = (even.low.sqrt(), even.high.sqrt());
        let high = if &above * &above == even.high { above } else { above + BigInt::one() };
        Enclosed { low, high, exponent: even.exponent / 2, bits: self.bits }.shortened()
    }

    /// The greatest whole number that is not greater, where it is the same for all of them.
    pub fn floor(&self) -> Option<Enclosed> {
        let all = if self.exponent > 0 { self.clone() } else { self.whole_part()? };
        (all.low == all.high).then_some(all)
    }

    /// The same of both ends.
    fn whole_part(&self) -> Option<Enclosed> {
        let shift = self.exponent.unsigned_abs().to_usize()?;
        Some(Enclosed { low: &self.low >> shift, high: &self.high >> shift, exponent: 0, bits: self.bits })
    }

    /// The whole number that it is, if it is one for certain.
    pub fn whole(&self) -> Option<i64> {
        // A whole number is not written with more places than that, and no others are shifted back to be compared.
        let short = self.exponent >= 0 || self.exponent.unsigned_abs() <= 4 * self.bits;
        let floor = self.floor().filter(|_| self.low == self.high && short)?;
        let shift = floor.exponent.to_usize().filter(|shift| *shift < 64)?;
        let exact = self.exponent >= 0 || (&floor.low << self.exponent.unsigned_abs().to_usize()?) == self.low;
        (&floor.low << shift).to_i64().filter(|_| exact)
    }

    /// How all of them lie to 0; nothing where they lie differently.
    pub fn sign(&self) -> Option<Ordering> {
        let zero = BigInt::zero();
        let (low, high) = (self.low.cmp(&zero), self.high.cmp(&zero));
        (low == high).then_some(low)
    }

    /// The exponent of the first bit.
    fn top(&self) -> Option<i64> {
        self.exponent.checked_add(self.low.bits().max(self.high.bits()).to_i64()?)
    }

    /// Over another power of two, rounded outward.
    fn at(&self, exponent: i64) -> Option<Enclosed> {
        let by = self.exponent.checked_sub(exponent)?;
        let shift = by.unsigned_abs().to_usize()?;
        let (low, high) = match by >= 0 {
            true => (&self.low << shift, &self.high << shift),
            // A shift to the right goes down.
            false => (&self.low >> shift, -(-&self.high >> shift)),
        };
        Some(Enclosed { low, high, exponent, bits: self.bits })
    }

    fn shortened(self) -> Option<Enclosed> {
        let more = self.low.bits().max(self.high.bits()).saturating_sub(self.bits).to_i64()?;
        if more == 0 { Some(self) } else { self.at(self.exponent.checked_add(more)?) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(above: i64, below: i64) -> BigRational {
        BigRational::new(above.into(), below.into())
    }

    #[test]
    fn the_ends_are_on_either_side() {
        let numbers: Vec<BigRational> =
            [(1, 3), (-22, 7), (0, 1), (5, 1), (-1, 1_000_003), (987_654_321, 2)].map(|(a, b)| number(a, b)).to_vec();
        let holds = |enclosed: &Enclosed, exact: &BigRational| {
            let two = BigRational::from_integer(2.into());
            let scale = two.pow(i32::try_from(enclosed.exponent).unwrap());
            let ends = [&enclosed.low, &enclosed.high].map(|end| BigRational::from_integer(end.clone()) * &scale);
            assert!(ends[0] <= *exact && *exact <= ends[1], "{exact} not in {ends:?}");
        };
        for bits in [3, 16, 64] {
            for one in &numbers {
                let first = Enclosed::of(one, bits).unwrap();
                holds(&first, one);
                match first.inverse() {
                    Some(inverse) => holds(&inverse, &one.recip()),
                    None => assert!(one.is_zero()),
                }
                if let Some(floor) = first.floor() {
                    holds(&floor, &one.floor());
                }
                assert_eq!(first.root().is_some(), !one.is_negative());
                if let Some(root) = first.root() {
                    holds(&root.times(&root).unwrap(), one);
                    let one = Enclosed::of(&BigRational::one(), bits).unwrap();
                    assert_eq!(one.root().and_then(|root| root.whole()), Some(1));
                }
                for power in [0, 1, 2, 5, 12] {
                    holds(&first.raised(power).unwrap(), &one.pow(i32::try_from(power).unwrap()));
                }
                for other in &numbers {
                    let second = Enclosed::of(other, bits).unwrap();
                    holds(&first.times(&second).unwrap(), &(one * other));
                    holds(&first.plus(&second).unwrap(), &(one + other));
                    holds(&first.greater(&second).unwrap(), one.max(other));
                }
            }
        }
    }

    #[test]
    fn a_whole_number_is_told_from_its_neighbours() {
        let whole = |above, below| Enclosed::of(&number(above, below), 64).and_then(|one| one.whole());
        assert_eq!(
            [whole(7, 1), whole(-7, 1), whole(0, 1), whole(1 << 40, 1)],
            [Some(7), Some(-7), Some(0), Some(1 << 40)]
        );
        assert_eq!([whole(7, 2), whole(22, 7), whole(-1, 3)], [None, None, None]);
    }

    #[test]
    fn a_sign_is_told_where_it_is_sure() {
        let third = Enclosed::of(&number(1, 3), 64).unwrap();
        let near = Enclosed::of(&number(-33_333_333, 100_000_000), 64).unwrap();
        assert_eq!(third.plus(&near).unwrap().sign(), Some(Ordering::Greater));
        let same = Enclosed::of(&number(-1, 3), 64).unwrap();
        assert_eq!(third.plus(&same).unwrap().sign(), None);
    }
}
