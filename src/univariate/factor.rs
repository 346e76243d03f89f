//! Factors over the rational numbers: square-free parts, then factors modulo a prime, lifted (Hensel) and combined
//! (Zassenhaus). Every factor that is returned divides, by exact division.

use num_bigint::BigInt;
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{One, Signed, ToPrimitive, Zero};

use super::Univariate;
use super::residue::{self, Residues};

const PRIMES: [u64; 24] = [3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53, 59, 61, 67, 71, 73, 79, 83, 89, 97];
/// The primes that are tried for one with few factors.
const TRIED: usize = 3;
/// The most factors modulo a prime of which combinations are tried.
const MOST_FACTORS: usize = 14;

impl Univariate {
    /// Its monic factors with their multiplicity, but for constants: pairwise without common root, each without
    /// repeated root, and irreducible (unless the modular factors are more than can be combined).
    pub fn factors(&self) -> Vec<(Univariate, usize)> {
        let mut found = Vec::new();
        let mut rest = self.monic();
        let zeros = rest.coefficients().iter().take_while(|coefficient| coefficient.is_zero()).count();
        if rest.is_zero() {
            return found;
        }
        if zeros > 0 {
            found.push((Univariate::root(&BigRational::zero()), zeros));
            rest = Univariate::new(rest.coefficients()[zeros..].to_vec());
        }
        if rest.degree() == 2 {
            found.extend(rest.split_quadratic());
        } else {
            for (part, count) in rest.square_free() {
                found.extend(part.split().into_iter().map(|factor| (factor, count)));
            }
        }
        found.sort_by(|(one, _), (other, _)| (one.degree(), one).cmp(&(other.degree(), other)));
        found
    }

    /// The products of the factors of each multiplicity (Yun).
    fn square_free(&self) -> Vec<(Univariate, usize)> {
        if self.degree() == 0 {
            return Vec::new();
        }
        if self.degree() == 1 || modular(&self.integral()).is_some() {
            return vec![(self.monic(), 1)];
        }
        let slope = self.derivative();
        let shared = self.common_divisor(&slope);
        let quotient = |a: &Univariate, b: &Univariate| a.divide(b).map_or_else(Univariate::zero, |(whole, _)| whole);
        let mut rest = quotient(self, &shared);
        let mut change = quotient(&slope, &shared).minus(&rest.derivative());
        let mut found = Vec::new();
        for count in 1..=self.degree() {
            if rest.degree() == 0 {
                break;
            }
            let part = rest.common_divisor(&change);
            rest = quotient(&rest, &part);
            change = quotient(&change, &part).minus(&rest.derivative());
            if part.degree() > 0 {
                found.push((part, count));
            }
        }
        found
    }

    /// The factors of a square-free polynomial.
    fn split(&self) -> Vec<Univariate> {
        if self.degree() <= 1 {
            return vec![self.monic()];
        }
        if self.degree() == 2 {
            return self.split_quadratic().into_iter().map(|(factor, _)| factor).collect();
        }
        let whole = self.integral();
        let Some((prime, parts)) = fewest(&whole) else { return vec![self.monic()] };
        if parts.len() == 1 || parts.len() > MOST_FACTORS {
            return vec![self.monic()];
        }
        combine(whole, lift(self, prime, &parts))
    }

    /// The factors of a polynomial of degree two, with their multiplicity.
    fn split_quadratic(&self) -> Vec<(Univariate, usize)> {
        let monic = self.monic();
        let half = monic.coefficient(1) / BigRational::from_integer(2.into());
        let square = &half * &half - monic.coefficient(0);
        match rational_root(&square) {
            Some(root) if root.is_zero() => vec![(Univariate::root(&-half), 2)],
            Some(root) => vec![(Univariate::root(&(-&half - &root)), 1), (Univariate::root(&(root - half)), 1)],
            None => vec![(monic, 1)],
        }
    }
}

/// The square root of a rational number that is a square.
fn rational_root(number: &BigRational) -> Option<BigRational> {
    if number.is_negative() {
        return None;
    }
    let (top, bottom) = (number.numer().sqrt(), number.denom().sqrt());
    (&top * &top == *number.numer() && &bottom * &bottom == *number.denom()).then(|| BigRational::new(top, bottom))
}

fn reduced(whole: &[BigInt], prime: u64) -> Residues {
    let modulus = BigInt::from(prime);
    residue::trim(whole.iter().map(|number| number.mod_floor(&modulus).to_u64().unwrap_or(0)).collect())
}

/// A prime modulo which it stays as it is and square-free: then it is square-free.
fn modular(whole: &[BigInt]) -> Option<(u64, Residues)> {
    PRIMES
        .iter()
        .map(|prime| (*prime, reduced(whole, *prime)))
        .find(|(prime, image)| image.len() == whole.len() && residue::is_square_free(image, *prime))
}

/// Of some primes that with the fewest factors, and these.
fn fewest(whole: &[BigInt]) -> Option<(u64, Vec<Residues>)> {
    let mut best: Option<(u64, Vec<Residues>)> = None;
    let mut tried = 0;
    for prime in PRIMES {
        let image = reduced(whole, prime);
        if image.len() != whole.len() || !residue::is_square_free(&image, prime) {
            continue;
        }
        let parts = residue::factors(&residue::monic(&image, prime), prime);
        tried += 1;
        if best.as_ref().is_none_or(|(_, fewest)| parts.len() < fewest.len()) {
            best = Some((prime, parts));
        }
        if tried == TRIED || best.as_ref().is_some_and(|(_, parts)| parts.len() == 1) {
            break;
        }
    }
    best
}

/// Factors modulo a power of the prime, with that power: larger than twice any coefficient of any factor.
struct Lifted {
    modulus: BigInt,
    parts: Vec<Vec<BigInt>>,
}

fn lift(polynomial: &Univariate, prime: u64, parts: &[Residues]) -> Lifted {
    let whole = polynomial.integral();
    let size: BigInt = whole.iter().map(|number| number.abs()).sum();
    let lead = whole.last().cloned().unwrap_or_else(BigInt::one).abs();
    let bound = (size * lead * BigInt::from(2)) << whole.len();
    let mut modulus = BigInt::from(prime);
    let mut steps = 1;
    while modulus <= bound {
        modulus *= prime;
        steps += 1;
    }
    // Monic modulo the power.
    let lead = whole.last().cloned().unwrap_or_else(BigInt::one);
    let inverse = lead.extended_gcd(&modulus).x;
    let mut rest: Vec<BigInt> = whole.iter().map(|number| (number * &inverse).mod_floor(&modulus)).collect();
    let mut lifted = Vec::new();
    for (place, part) in parts.iter().enumerate() {
        if place + 1 == parts.len() {
            lifted.push(rest);
            break;
        }
        let others = parts[place + 1..].iter().fold(vec![1], |product, other| residue::times(&product, other, prime));
        let (own, other) = lift_pair(&rest, part, &others, prime, steps);
        lifted.push(own);
        rest = other;
    }
    Lifted { modulus, parts: lifted }
}

/// `(g, h)` with `f = g*h` modulo `prime^steps`, from factors modulo the prime; all monic.
fn lift_pair(f: &[BigInt], g: &[u64], h: &[u64], prime: u64, steps: u32) -> (Vec<BigInt>, Vec<BigInt>) {
    let (s, t) = residue::combination(g, h, prime);
    let whole = |part: &[u64]| part.iter().map(|number| BigInt::from(*number)).collect::<Vec<_>>();
    let (mut left, mut right) = (whole(g), whole(h));
    let mut power = BigInt::from(prime);
    for _ in 1..steps {
        let product = times(&left, &right);
        let error: Vec<BigInt> = f.iter().zip(&product).map(|(wanted, have)| (wanted - have) / &power).collect();
        let error = reduced(&error, prime);
        // error = g*y + h*x with deg x < deg g.
        let (quotient, x) = residue::divide(&residue::times(&t, &error, prime), g, prime);
        let y = residue::plus(&residue::times(&s, &error, prime), &residue::times(&quotient, h, prime), prime);
        for (place, number) in x.iter().enumerate() {
            left[place] += &power * number;
        }
        for (place, number) in y.iter().enumerate().take(right.len()) {
            right[place] += &power * number;
        }
        power *= prime;
    }
    (left, right)
}

fn times(left: &[BigInt], right: &[BigInt]) -> Vec<BigInt> {
    let mut product = vec![BigInt::zero(); (left.len() + right.len()).saturating_sub(1)];
    for (place, one) in left.iter().enumerate() {
        for (offset, other) in right.iter().enumerate() {
            product[place + offset] += one * other;
        }
    }
    product
}

/// The products of lifted factors that divide.
fn combine(whole: Vec<BigInt>, lifted: Lifted) -> Vec<Univariate> {
    let Lifted { modulus, mut parts } = lifted;
    let mut rest = rational(&whole);
    let mut found = Vec::new();
    let mut count = 1;
    'counts: while 2 * count <= parts.len() {
        for choice in choices(parts.len(), count) {
            let lead = rest.integral().last().cloned().unwrap_or_else(BigInt::one);
            let mut product = vec![lead];
            for place in &choice {
                product = times(&product, &parts[*place]).iter().map(|number| number.mod_floor(&modulus)).collect();
            }
            let half = &modulus / BigInt::from(2);
            let centred = product.into_iter().map(|number| if number > half { number - &modulus } else { number });
            let candidate = rational(&centred.collect::<Vec<_>>());
            if candidate.degree() == 0 {
                continue;
            }
            if let Some((quotient, remainder)) = rest.divide(&candidate.monic())
                && remainder.is_zero()
            {
                found.push(candidate.monic());
                rest = quotient;
                let mut place = 0;
                parts.retain(|_| {
                    place += 1;
                    !choice.contains(&(place - 1))
                });
                continue 'counts;
            }
        }
        count += 1;
    }
    if rest.degree() > 0 {
        found.push(rest.monic());
    }
    found
}

fn rational(whole: &[BigInt]) -> Univariate {
    Univariate::new(whole.iter().map(|number| BigRational::from_integer(number.clone())).collect())
}

/// All sets of so many places.
fn choices(places: usize, count: usize) -> Vec<Vec<usize>> {
    let mut all: Vec<Vec<usize>> = vec![Vec::new()];
    for _ in 0..count {
        all = all
            .iter()
            .flat_map(|set| {
                let next = set.last().map_or(0, |last| last + 1);
                (next..places).map(move |place| set.iter().copied().chain([place]).collect())
            })
            .collect();
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::univariate::polynomial;

    #[test]
    fn products_come_apart_again() {
        let pool: Vec<Univariate> = [
            &[-1, 1][..],
            &[2, 3],
            &[-1, -1, 1],
            &[1, 0, 1],
            &[1, 1, 1],
            &[-2, 0, 0, 1],
            &[1, 0, 0, 0, 1],
            &[1, 0, -10, 0, 1],
            &[-1, -1, 0, 0, 0, 1],
            &[7, 0, 3, 0, 0, 0, 5],
        ]
        .iter()
        .map(|coefficients| polynomial(coefficients).monic())
        .collect();
        for one in 0..pool.len() {
            for other in one..pool.len() {
                for third in [0, 3, 7] {
                    let mut wanted: Vec<Univariate> = vec![pool[one].clone(), pool[other].clone(), pool[third].clone()];
                    wanted.sort_by(|a, b| (a.degree(), a).cmp(&(b.degree(), b)));
                    let product = wanted.iter().fold(Univariate::one(), |all, factor| all.times(factor));
                    let found = product.factors();
                    let again: Vec<Univariate> =
                        found.iter().flat_map(|(factor, count)| vec![factor.clone(); *count]).collect();
                    assert_eq!(again, wanted);
                }
            }
        }
    }

    #[test]
    fn roots_of_unity() {
        // x^12 - 1 has a factor for each divisor of 12.
        let mut coefficients = vec![0; 13];
        (coefficients[0], coefficients[12]) = (-1, 1);
        assert_eq!(polynomial(&coefficients).factors().len(), 6);
        assert_eq!(polynomial(&[0, 0, 4, -4, 1]).factors().len(), 2);
    }
}
