//! Roots of numbers in values: what the normal form makes of them, and what follows from assumptions, is so at random places.

mod common;

use std::cmp::Ordering;
use std::collections::BTreeMap;

use pars::assumption::Assumptions;
use pars::name::Name;
use pars::value::{Relation, Value};
use proptest::prelude::*;

use common::*;

/// A number, the number below its root, and the exponents of x and y.
type Part = (i64, usize, u8, u8);

const SQUARES: [i64; 7] = [1, 2, 3, 6, 17, 30, 34];

fn part() -> impl Strategy<Value = Part> {
    (-4..5i64, 0..SQUARES.len(), 0..3u8, 0..2u8)
}

fn sum(parts: &[Part]) -> Value {
    let power = |name: &str, exponent: u8| var(name).power(&number(exponent.into())).expect("a power");
    parts.iter().fold(number(0), |sum, (factor, place, first, second)| {
        let root = number(SQUARES[*place]).sqrt().expect("a root");
        let product = [root, power("x", *first), power("y", *second)]
            .iter()
            .try_fold(number(*factor), |product, one| product.mul(one));
        sum.add(&product.expect("a product")).expect("a sum")
    })
}

fn at(value: &Value, (x, y): (i64, i64)) -> Option<Value> {
    let half = |number: i64| Value::fraction(number, 2).expect("a number");
    value.substitute(&BTreeMap::from([(name("x"), half(x)), (name("y"), half(y))])).ok()
}

/// How a number with roots lies to another.
fn order(left: &Value, right: &Value) -> Option<Ordering> {
    let nothing = Assumptions::default();
    let is = |relation| nothing.decide(relation, left, right) == Some(true);
    match () {
        () if left.sub(right).ok()?.is_zero() => Some(Ordering::Equal),
        () if is(Relation::Lss) => Some(Ordering::Less),
        () if is(Relation::Gtr) => Some(Ordering::Greater),
        () => None,
    }
}

fn places() -> impl Strategy<Value = Vec<(i64, i64)>> {
    prop::collection::vec((-7..8i64, -7..8i64), 5)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn a_quotient_is_one_wherever_it_has_a_value(
        above in prop::collection::vec(part(), 1..4),
        below in prop::collection::vec(part(), 1..4),
        shared in prop::collection::vec(part(), 1..3),
        places in places(),
    ) {
        let (above, below, shared) = (sum(&above), sum(&below), sum(&shared));
        let [top, bottom] = [&above, &below].map(|one| one.mul(&shared).expect("a product"));
        let (Ok(plain), Ok(with)) = (above.over(&below), top.over(&bottom)) else { return Ok(()) };
        for place in places {
            let Some(divisor) = at(&bottom, place).filter(|divisor| !divisor.is_zero()) else { continue };
            let wanted = at(&above, place).expect("a number");
            for quotient in [&plain, &with] {
                let found = at(quotient, place).and_then(|found| found.mul(&at(&below, place)?).ok());
                prop_assert_eq!(found.as_ref(), Some(&wanted), "({})/({}) at {:?}, divided by {}", above, below, place, divisor);
            }
        }
    }

    #[test]
    fn the_root_of_a_square_is_the_size(parts in prop::collection::vec(part(), 1..3), places in places()) {
        let whole = sum(&parts);
        let Ok(root) = whole.mul(&whole).and_then(|square| square.sqrt()) else { return Ok(()) };
        for place in places {
            let (found, size) = (at(&root, place), at(&whole, place).and_then(|value| value.abs().ok()));
            let (Some(found), Some(size)) = (found, size) else { continue };
            prop_assert!(matches!(order(&found, &size), None | Some(Ordering::Equal)), "{root} of {whole} at {place:?}");
        }
    }

    #[test]
    fn what_is_decided_of_roots_is_so(
        facts in prop::collection::vec((prop::collection::vec(part(), 1..3), prop::collection::vec(part(), 1..3)), 1..4),
        (left, right) in (prop::collection::vec(part(), 1..4), prop::collection::vec(part(), 1..3)),
        factor in part(),
        first in (-7..8i64, -7..8i64),
        places in places(),
    ) {
        let mut known = Assumptions::default();
        let mut stated = Vec::new();
        for (one, other) in &facts {
            let (one, other) = (sum(one), sum(other));
            let here = at(&one, first).zip(at(&other, first)).and_then(|(one, other)| order(&one, &other));
            let relation = match here {
                Some(Ordering::Less) => Relation::Lss,
                Some(Ordering::Greater) => Relation::Gtr,
                Some(Ordering::Equal) => Relation::Lte,
                None => continue,
            };
            known.assume(relation, &one, &other);
            stated.push((relation, one, other));
        }
        prop_assert!(!known.contradictory(), "{known:?} is possible at {first:?}");
        // What is asked may be a fact with a factor, which a root hides.
        let mut asked = vec![(sum(&left), sum(&right))];
        let scale = sum(&[factor]);
        asked.extend(stated.iter().map(|(_, one, other)| (one.mul(&scale).expect("small"), other.mul(&scale).expect("small"))));
        let holds = |relation: Relation, one: &Value, other: &Value, place| {
            order(&at(one, place)?, &at(other, place)?).map(|order| relation.holds(order))
        };
        let relations = [Relation::Lss, Relation::Lte, Relation::Eq];
        let answers = asked.iter().flat_map(|(left, right)| relations.map(|relation| (relation, left, right)));
        let answers = answers.filter_map(|(relation, left, right)| Some((relation, left, right, known.decide(relation, left, right)?)));
        let answers: Vec<_> = answers.collect();
        for place in places.into_iter().chain([first]) {
            if !stated.iter().all(|(relation, one, other)| holds(*relation, one, other, place) == Some(true)) {
                continue;
            }
            for (relation, left, right, answer) in &answers {
                if let Some(truth) = holds(*relation, left, right, place) {
                    prop_assert_eq!(*answer, truth, "{} {} {} at {:?}", left, relation.symbol(), right, place);
                }
            }
        }
    }
}

/// `w < sqrt(34)` says of `3/34*w*sqrt(34)` that it is less than 3: the root, of two primes, is a factor of the difference.
#[test]
fn a_root_of_several_primes_is_a_hidden_factor() {
    let (w, n, step) = (var("w"), var("n"), var("t").mul(&var("v")).expect("a product"));
    for square in [2, 7, 34, 210] {
        let root = number(square).sqrt().expect("a root");
        let place = w.mul(&root).and_then(|product| product.mul(&Value::fraction(3, square)?)).expect("a value");
        let mut known = Assumptions::default();
        known.assume(Relation::Gtr, &w, &number(0));
        assert_eq!(known.decide(Relation::Lss, &place, &number(3)), None);
        known.assume(Relation::Lss, &w, &root);
        assert_eq!(known.decide(Relation::Lss, &place, &number(3)), Some(true), "{square}");
        assert_eq!(known.decide(Relation::Lss, &place, &Value::fraction(29, 10).expect("a number")), None, "{square}");
        // The same of steps of which n more are known to fit.
        let mut known = Assumptions::default();
        ["t", "v"].iter().for_each(|one| known.assume(Relation::Gtr, &var(one), &number(0)));
        known.assume_natural(&Name::new("n"));
        let fits =
            root.div(&step).and_then(|fits| fits.ceiling()).and_then(|fits| fits.sub(&number(1))).expect("a value");
        known.assume(Relation::Lss, &n, &fits);
        let gone = n.mul(&step).and_then(|gone| gone.mul(&root)).expect("a value");
        assert_eq!(known.decide(Relation::Lss, &gone, &number(square)), Some(true), "{square}");
        let left = gone.sub(&number(square)).and_then(|left| left.abs()).expect("a value");
        assert_eq!(known.simplify(&left), number(square).sub(&gone).expect("a value"));
    }
}

/// `(t*v-sqrt(34))^2` is seen to be a square, and `(x*sqrt(2)-2)/(x-sqrt(2))` to be the root of 2.
#[test]
fn what_a_root_hides_comes_out() {
    let step = var("t").mul(&var("v")).expect("a product");
    let root = number(34).sqrt().expect("a root");
    let left = step.sub(&root).expect("a value");
    let length = left.mul(&left).and_then(|square| square.sqrt()).expect("a value");
    assert_eq!(length, left.abs().expect("a size"));
    // Also where what all terms share is no square: of 2*(8*y^2+4*y*sqrt(6)+3).
    let six = var("y").mul(&number(4)).and_then(|first| first.add(&number(6).sqrt()?)).expect("a value");
    let square = six.mul(&six).expect("a square");
    assert_eq!(square.sqrt().expect("a root"), six.abs().expect("a size"));
    assert_eq!(Assumptions::default().decide(Relation::Gte, &square, &number(0)), Some(true));
    let two = number(2).sqrt().expect("a root");
    let top = var("x").mul(&two).and_then(|top| top.sub(&number(2))).expect("a value");
    let below = var("x").sub(&two).expect("a value");
    assert_eq!(top.over(&below).expect("a quotient"), two);
    assert_eq!(below.over(&top).expect("a quotient"), two.div(&number(2)).expect("half"));
}
