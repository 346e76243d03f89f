//! From which index on an exponential polynomial with rational coefficients keeps its sign, or its distance from 0:
//! where one real root outgrows all others, by exact rational bounds.

mod outgrown;

use std::cmp::Ordering;

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use outgrown::{is_matched, outgrown};

pub(super) use outgrown::rounded_up;

use super::dominant::{between, dominant, with_squared_roots};
use super::enclosed::Enclosed;
use super::{ExponentialPolynomial, middle_and_square};
use crate::univariate::Univariate;
use crate::value::{Relation, Value};

/// What is known of all late terms.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Tail {
    /// From this index on the comparison with 0 never holds, and why.
    Never(u64, String),
    /// Nothing, and why.
    Unknown(String),
}

/// The latest index from which on a bound is looked for.
const MOST: u64 = 4_096;
/// The most terms of a range that are looked at one by one.
const MOST_LISTED: u64 = 300;
/// How often differences are taken to see that a sum moves one way only.
const MOST_DIFFERENCES: usize = 3;
/// The furthest from its first term that a first index is looked for by halves.
const MOST_FAR: u64 = 1 << 22;
/// The bits of the terms that are enclosed, one attempt after the other, before they are computed.
const LENGTHS: [u64; 3] = [128, 512, 2_048];
/// The latest index of a term that is computed before it is enclosed.
const LATE: u64 = 1_000;
/// The bits of a bound.
const PRECISION: u32 = 40;
/// How often every second term is looked at by itself.
const MOST_HALVINGS: usize = 2;
/// How often the roots of a polynomial of higher degree are squared to bound them.
const SQUARINGS: u32 = 7;

/// `c * n^power * x^n` for one root, or a bound of it for several.
struct Part {
    /// Between these lies the size of the root.
    size: (BigRational, BigRational),
    /// Whether the root is positive, if it is real and known.
    root: Option<bool>,
    /// Between these lies the size of the coefficient.
    weight: (BigRational, BigRational),
    /// Whether the coefficient is positive, if it is real and known.
    sign: Option<bool>,
    power: usize,
}

/// Whether a sum with rational coefficients stands in a relation to 0 at all indices from one on, and before another if there
/// is one: term by term, by its tail, or by both ends where it moves one way only.
pub fn throughout(sum: &ExponentialPolynomial, relation: Relation, from: u64, until: Option<u64>) -> bool {
    throughout_by(sum, relation, from, until, MOST_DIFFERENCES)
}

fn throughout_by(
    sum: &ExponentialPolynomial,
    relation: Relation,
    from: u64,
    until: Option<u64>,
    differences: usize,
) -> bool {
    let holds = |at: u64| stands(sum, relation, at) == Some(true);
    if until.is_some_and(|until| until <= from) {
        return true;
    }
    if !holds(from) {
        return false;
    }
    if let Some(until) = until.filter(|until| until - from <= MOST_LISTED) {
        return (from + 1..until).all(holds);
    }
    if let Tail::Never(end, _) = tail(sum, relation.negated(), from) {
        return (from + 1..until.map_or(end, |until| until.min(end))).all(holds);
    }
    let Some(until) = until else { return false };
    // Between equal signs at both ends there is no other where it only rises or only falls.
    let one_way = |step: ExponentialPolynomial| {
        let ways = [Relation::Gte, Relation::Lte];
        ways.iter().any(|way| throughout_by(&step, *way, from, Some(until - 1), differences - 1))
    };
    if differences > 0 && relation != Relation::Neq && holds(until - 1) && step(sum).is_some_and(one_way) {
        return true;
    }
    until - from <= MOST && (from + 1..until).all(holds)
}

/// The first index, not before `from`, at which a sum with rational coefficients stands in a relation to 0, where it moves one
/// way only and comes to it; nothing where that is not known.
pub fn first_by_halves(
    sum: &ExponentialPolynomial,
    relation: Relation,
    from: u64,
    stop: &dyn Fn() -> bool,
) -> Option<u64> {
    let holds = |at: u64| stands(sum, relation, at);
    let way = match relation {
        Relation::Gtr | Relation::Gte => Relation::Gte,
        Relation::Lss | Relation::Lte => Relation::Lte,
        Relation::Eq | Relation::Neq => return None,
    };
    if !throughout(&step(sum)?, way, from, None) {
        return None;
    }
    if holds(from)? {
        return Some(from);
    }
    // It holds at the later of two indices, and from there on for ever; at the earlier it does not.
    let (mut earlier, mut later) = (from, from + 1);
    while !holds(later)? {
        let distance = (later - from) * 2;
        (earlier, later) = (later, from + distance);
        if distance > MOST_FAR || stop() {
            return None;
        }
    }
    while later - earlier > 1 {
        let middle = earlier + (later - earlier) / 2;
        if holds(middle)? { later = middle } else { earlier = middle }
    }
    Some(later)
}

/// Whether a sum with rational coefficients stands in a relation to 0 at an index.
pub fn stands(sum: &ExponentialPolynomial, relation: Relation, at: u64) -> Option<bool> {
    Some(relation.holds(sign(sum, at)?))
}

/// How the term of an index lies to 0: a late one is not written down where its first bits tell.
fn sign(sum: &ExponentialPolynomial, at: u64) -> Option<Ordering> {
    let told = |bits: u64| enclosed(sum, at, bits)?.sign();
    let early = if at < LATE { None } else { LENGTHS.into_iter().find_map(told) };
    early.or_else(|| Some(term(sum, at)?.cmp(&BigRational::zero())))
}

/// Where the term of an index lies, if all roots are rational.
fn enclosed(sum: &ExponentialPolynomial, at: u64, bits: u64) -> Option<Enclosed> {
    let mut all = Enclosed::of(&BigRational::zero(), bits)?;
    let place = BigRational::from_integer(at.into());
    for (modulus, rows) in sum.parts() {
        let rational = |row: &Vec<Value>| row.first().filter(|_| row.len() == 1)?.as_rational();
        let numbers = rows.iter().map(rational).collect::<Option<Vec<_>>>()?;
        let factor = numbers.iter().rev().fold(BigRational::zero(), |sum, number| sum * &place + number);
        let power = Enclosed::of(&-modulus.coefficient(0), bits)?.raised(at)?;
        all = all.plus(&Enclosed::of(&factor, bits)?.times(&power)?)?;
    }
    Some(all)
}

/// The term of an index, a number.
fn term(sum: &ExponentialPolynomial, at: u64) -> Option<BigRational> {
    sum.at(at).ok()?.as_rational()
}

/// What it changes by from each index to the next.
fn step(sum: &ExponentialPolynomial) -> Option<ExponentialPolynomial> {
    sum.next().ok()?.plus(&sum.scale(&Value::integer(-1)).ok()?).ok()
}

/// From which index on, not before `from`, a sum is never in the relation to 0: of all terms, or of each second one.
pub fn tail(sum: &ExponentialPolynomial, relation: Relation, from: u64) -> Tail {
    tail_of_all(std::slice::from_ref(sum), relation, from)
}

/// From which index on, not before `from`, some sums are never all in the relation to 0: of all terms, or of each second one,
/// one of the sums is not.
pub fn tail_of_all(sums: &[ExponentialPolynomial], relation: Relation, from: u64) -> Tail {
    in_turns(sums, from, MOST_HALVINGS, &|sums, from| {
        let mut found = Tail::Unknown("there is no sum".to_string());
        for sum in sums {
            found = match (found, at_once(sum, relation, from)) {
                (Tail::Never(one, _), Tail::Never(other, why)) if other < one => Tail::Never(other, why),
                (found @ Tail::Never(..), _) => found,
                (Tail::Unknown(_), next) => next,
            };
        }
        found
    })
}

/// What is known of all terms, or of those at even and at odd indices.
fn in_turns(
    sums: &[ExponentialPolynomial],
    from: u64,
    halvings: usize,
    known: &dyn Fn(&[ExponentialPolynomial], u64) -> Tail,
) -> Tail {
    let found = known(sums, from);
    if halvings == 0 || matches!(found, Tail::Never(..)) {
        return found;
    }
    let mut latest = (from, String::new());
    for odd in [false, true] {
        let halves = sums.iter().map(|sum| sum.half(odd)).collect::<Option<Vec<_>>>();
        let Some(half) = halves else { return found };
        match in_turns(&half, from / 2, halvings - 1, known) {
            Tail::Never(until, why) => {
                let at = until.saturating_mul(2).saturating_add(1);
                latest = if at >= latest.0 { (at, why) } else { latest };
            }
            Tail::Unknown(_) => return found,
        }
    }
    // Apart in turns of more than two.
    const HALVES: &str = "taking even and odd indices apart, ";
    Tail::Never(
        latest.0,
        match latest.1.strip_prefix(HALVES) {
            Some(why) => format!("taking the indices apart in four turns, {why}"),
            None => format!("{HALVES}{}", latest.1),
        },
    )
}

fn at_once(sum: &ExponentialPolynomial, relation: Relation, from: u64) -> Tail {
    let Some(parts) = parts(sum) else {
        return Tail::Unknown("its coefficients are no numbers".to_string());
    };
    if parts.is_empty() && !matches!(relation, Relation::Eq | Relation::Gte | Relation::Lte) {
        return Tail::Never(from, "from there on both sides are equal".to_string());
    }
    let mut why = "no real root of its characteristic polynomial outgrows all others";
    for place in 0..parts.len() {
        let main = &parts[place];
        let less = |(other, part): (usize, &Part)| {
            other == place
                || part.size.1 < main.size.0
                || (part.power <= main.power && part.size == main.size && part.size.0 == part.size.1)
        };
        if main.sign.is_none() || main.root.is_none() || !parts.iter().enumerate().all(less) {
            continue;
        }
        match outgrowing(&parts, place, relation, from) {
            Ok(found) => return found,
            Err(reason) => why = reason,
        }
    }
    Tail::Unknown(why.to_string())
}

/// From which index on, not before `from`, a sum is farther from 0 than a bound: where one real root, of either sign,
/// outgrows all others and the bound.
pub fn outside(sum: &ExponentialPolynomial, bound: &BigRational, from: u64) -> Tail {
    in_turns(std::slice::from_ref(sum), from, MOST_HALVINGS, &|sums, from| match sums {
        [sum] => outside_at_once(sum, bound, from),
        _ => Tail::Unknown("it is asked of one sum".to_string()),
    })
}

fn outside_at_once(sum: &ExponentialPolynomial, bound: &BigRational, from: u64) -> Tail {
    let Some(mut parts) = parts(sum) else {
        return Tail::Unknown("its coefficients are no numbers".to_string());
    };
    let own = parts.len();
    parts.push(rational(&BigRational::one(), bound, 0));
    for place in 0..own {
        let main = &parts[place];
        if main.sign.is_none() || main.root.is_none() {
            continue;
        }
        let mut at = from.max(1);
        while at <= MOST {
            if outgrown(&parts, place, at) {
                let why = format!("from there on the {} outgrows all others", main.told());
                return Tail::Never(at, why);
            }
            at *= 2;
        }
    }
    Tail::Unknown("no real root of its characteristic polynomial outgrows all others".to_string())
}

/// The tail by the part that no other exceeds in size.
fn outgrowing(parts: &[Part], place: usize, relation: Relation, from: u64) -> Result<Tail, &'static str> {
    let main = &parts[place];
    let positive = match (main.root, main.sign) {
        (Some(true), sign) => sign,
        _ => None,
    };
    let never = match (relation, positive) {
        (Relation::Eq, _) => true,
        (Relation::Gtr | Relation::Gte, Some(positive)) => !positive,
        (Relation::Lss | Relation::Lte, Some(positive)) => positive,
        _ => false,
    };
    if !never {
        return Err("it holds for late terms, or for some of them");
    }
    // What is to be more than 0 need not be less.
    let larger = !matches!(relation, Relation::Gtr | Relation::Lss);
    let mut at = from.max(1);
    while at <= MOST {
        if is_matched(parts, place, at, larger) {
            let (verb, what) = match (relation, positive) {
                (Relation::Eq, _) => ("is never", "their difference"),
                (Relation::Gtr, _) => ("is never more than", "the difference of both sides"),
                (Relation::Lss, _) => ("is never less than", "the difference of both sides"),
                (_, Some(true)) => ("stays above", "the difference of both sides"),
                _ => ("stays below", "the difference of both sides"),
            };
            let why = match parts {
                [_] => format!("from there on {what} {verb} 0"),
                _ => {
                    let others = parts.iter().enumerate().filter(|(other, _)| *other != place);
                    let alike = others.into_iter().any(|(_, part)| part.size == main.size && part.power == main.power);
                    let how = match alike {
                        true if larger => "is more than all others together",
                        true => "is as much as all others together, or more",
                        false => "outgrows all others",
                    };
                    format!("from there on {what} {verb} 0: its {} {how}", main.told())
                }
            };
            return Ok(Tail::Never(at, why));
        }
        at *= 2;
    }
    Err("its parts are too close to each other")
}

impl Part {
    /// Which part it is: of a polynomial by its degree.
    fn told(&self) -> String {
        if self.root == Some(true) && self.size.0.is_one() && self.size.1.is_one() {
            return match self.power {
                0 => "constant part".to_string(),
                power => format!("part of degree {power}"),
            };
        }
        format!("part with the root of size {}", bound_text(&self.size))
    }
}

fn bound_text(size: &(BigRational, BigRational)) -> String {
    if size.0 == size.1 {
        return size.0.to_string();
    }
    let thousand = BigRational::from_integer(1000.into());
    let rounded = (&size.0 * &thousand).round() / thousand;
    format!("about {rounded}")
}

fn parts(sum: &ExponentialPolynomial) -> Option<Vec<Part>> {
    let mut all = Vec::new();
    for (modulus, rows) in sum.parts() {
        for (power, row) in rows.iter().enumerate() {
            let numbers = row.iter().map(Value::as_rational).collect::<Option<Vec<_>>>()?;
            if numbers.iter().all(BigRational::is_zero) {
                continue;
            }
            match modulus.degree() {
                1 => all.push(rational(&-modulus.coefficient(0), &numbers[0], power)),
                2 => all.extend(quadratic(modulus, &numbers, power)),
                _ => all.extend(higher(modulus, &numbers, power)),
            }
        }
    }
    Some(all)
}

fn rational(root: &BigRational, coefficient: &BigRational, power: usize) -> Part {
    let (size, weight) = (root.abs(), coefficient.abs());
    Part {
        size: (size.clone(), size),
        root: Some(root.is_positive()),
        weight: (weight.clone(), weight),
        sign: Some(coefficient.is_positive()),
        power,
    }
}

fn quadratic(modulus: &Univariate, numbers: &[BigRational], power: usize) -> Vec<Part> {
    let (middle, square) = middle_and_square(modulus);
    let inner = &numbers[0] + &numbers[1] * &middle;
    if square.is_negative() {
        let size = root_bounds(&modulus.coefficient(0), 2);
        // Twice the size of the complex coefficient.
        let length = &inner * &inner - &numbers[1] * &numbers[1] * &square;
        let weight = root_bounds(&length, 2).1 * BigRational::from_integer(2.into());
        return vec![Part { size, root: None, weight: (BigRational::zero(), weight), sign: None, power }];
    }
    let distance = root_bounds(&square, 2);
    let part = |side: BigRational| {
        let between = |base: &BigRational, factor: &BigRational| {
            let ends = [base + factor * &side * &distance.0, base + factor * &side * &distance.1];
            let [one, other] = ends;
            if one < other { (one, other) } else { (other, one) }
        };
        let (size, root) = sized(between(&middle, &BigRational::one()));
        let (weight, sign) = sized(between(&inner, &numbers[1]));
        Part { size, root, weight, sign, power }
    };
    vec![part(BigRational::one()), part(-BigRational::one())]
}

/// The size of a number between two others, and whether it is positive.
fn sized((low, high): (BigRational, BigRational)) -> ((BigRational, BigRational), Option<bool>) {
    if low.is_positive() {
        ((low, high), Some(true))
    } else if high.is_negative() {
        ((-high, -low), Some(false))
    } else {
        ((BigRational::zero(), high.max(-low)), None)
    }
}

fn higher(modulus: &Univariate, numbers: &[BigRational], power: usize) -> Vec<Part> {
    let largest = largest_root(modulus);
    let bound = |size: BigRational, count: usize| {
        let mut weight = BigRational::zero();
        for number in numbers.iter().rev() {
            weight = weight * &size + number.abs();
        }
        weight *= BigRational::from_integer(count.into());
        Part { size: (BigRational::zero(), size), root: None, weight: (BigRational::zero(), weight), sign: None, power }
    };
    let Some(found) = dominant(modulus, &largest) else { return vec![bound(largest, modulus.degree())] };
    let (weight, sign) = sized(between(numbers, &found.low, &found.high));
    let (size, root) = sized((found.low, found.high));
    vec![Part { size, root, weight, sign, power }, bound(found.others, modulus.degree() - 1)]
}

/// A bound of the sizes of all roots of a monic polynomial: that of Fujiwara, for a power of the roots (Graeffe).
fn largest_root(modulus: &Univariate) -> BigRational {
    let degree = modulus.degree();
    let squared = with_squared_roots(modulus, SQUARINGS);
    let sizes = (1..=degree).map(|back| {
        let number = squared.coefficient(degree - back).abs();
        root_bounds(&number, u32::try_from(back).unwrap_or(1)).1
    });
    let most = sizes.max().unwrap_or_else(BigRational::zero) * BigRational::from_integer(2.into());
    root_bounds(&most, 1 << SQUARINGS).1
}

/// Numbers between which a root of a number that is not negative lies.
pub(super) fn root_bounds(number: &BigRational, order: u32) -> (BigRational, BigRational) {
    if order == 2 {
        let (top, bottom) = (number.numer().sqrt(), number.denom().sqrt());
        if &top * &top == *number.numer() && &bottom * &bottom == *number.denom() {
            let root = BigRational::new(top, bottom);
            return (root.clone(), root);
        }
    }
    let bits = PRECISION * 4;
    let scale = BigInt::one() << (bits * order) as usize;
    let scaled = (number * BigRational::from_integer(scale)).floor().to_integer();
    let low = scaled.nth_root(order);
    let unit = BigInt::one() << bits as usize;
    (BigRational::new(low.clone(), unit.clone()), BigRational::new(low + BigInt::one(), unit))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_smaller_for_long_outgrows_in_the_end() {
        // n^2 - (101/100)^n is far above 0 from 2 to 1400, and far below 0 from 1600 on.
        let number = |top: i64, bottom: i64| Value::fraction(top, bottom).unwrap();
        let root = |top: i64, bottom: i64| Univariate::root(&BigRational::new(top.into(), bottom.into()));
        let mut sum = ExponentialPolynomial::zero();
        sum.include(&root(1, 1), vec![vec![number(0, 1)], vec![number(0, 1)], vec![number(1, 1)]]).unwrap();
        sum.include(&root(101, 100), vec![vec![number(-1, 1)]]).unwrap();
        assert!(!throughout(&sum, Relation::Gtr, 2, None));
        assert!(throughout(&sum, Relation::Gtr, 2, Some(1400)));
        assert!(throughout(&sum, Relation::Lss, 1600, None));
        let bound = BigRational::from_integer(12_000.into());
        let Tail::Never(from, _) = outside(&sum, &bound, 120) else { panic!("the power outgrows all") };
        assert!(from > 1467, "{from}");
    }

    #[test]
    fn roots_are_bounded() {
        let number = |top: i64, bottom: i64| BigRational::new(top.into(), bottom.into());
        let polynomial = Univariate::new(vec![number(-1, 1), number(-1, 1), number(0, 1), number(1, 1)]);
        let bound = largest_root(&polynomial);
        assert!(bound > number(1324, 1000) && bound < number(136, 100), "{bound}");
        let (low, high) = root_bounds(&number(2, 1), 2);
        assert!(&low * &low <= number(2, 1) && &high * &high > number(2, 1));
    }
}
