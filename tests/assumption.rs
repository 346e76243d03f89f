//! What follows from assumptions: examples, and random checks that no answer is contradicted by an instance.

mod common;

use std::collections::BTreeMap;

use pars::assumption::Assumptions;
use pars::name::Name;
use pars::value::{Relation, Value};
use proptest::prelude::*;

use common::*;

fn assume(facts: &[(Value, Relation, Value)]) -> Assumptions {
    let mut known = Assumptions::default();
    facts.iter().for_each(|(left, relation, right)| known.assume(*relation, left, right));
    known
}

use Relation::{Eq, Gte, Gtr, Lss, Lte, Neq};

#[test]
fn signs_of_products() {
    let (t, v, a, b) = (var("t"), var("v"), var("a"), var("b"));
    let known = assume(&[(t.clone(), Gtr, int(0)), (v.clone(), Gtr, int(0)), (a.clone(), Neq, b.clone())]);
    let product = t.mul(&v).unwrap();
    assert_eq!(known.decide(Gtr, &product, &int(0)), Some(true));
    assert_eq!(known.decide(Eq, &b, &a), Some(false));
    assert_eq!(known.decide(Neq, &t.mul(&a).unwrap(), &t.mul(&b).unwrap()), Some(true));
    assert_eq!(known.decide(Gtr, &a.sub(&b).unwrap().abs().unwrap(), &int(0)), Some(true));
    assert_eq!(known.decide(Gtr, &a.sub(&b).unwrap(), &int(0)), None);
    assert_eq!(known.decide(Gtr, &int(1).div(&t).unwrap(), &int(0)), Some(true));
    assert_eq!(known.decide(Gtr, &a.div(&t).unwrap(), &b.div(&t).unwrap()), None);
    let square = a.mul(&a).unwrap();
    assert_eq!(known.decide(Gte, &square, &int(0)), Some(true));
    let whole = square.add(&b.mul(&b).unwrap()).unwrap().add(&int(1)).unwrap();
    assert_eq!(known.decide(Gtr, &whole, &int(0)), Some(true));
}

#[test]
fn linear_consequences() {
    let (a, b, p) = (var("a"), var("b"), var("p"));
    let known = assume(&[(a.clone(), Gtr, b.clone()), (b.clone(), Gte, p.clone())]);
    assert_eq!(known.decide(Gtr, &a, &p), Some(true));
    assert_eq!(known.decide(Lte, &a, &p), Some(false));
    assert_eq!(known.decide(Gtr, &b, &p), None);
    let equal = assume(&[(a.clone(), Eq, b.clone()), (b.clone(), Eq, int(3))]);
    assert_eq!(equal.decide(Eq, &a.mul(&a).unwrap(), &int(9)), Some(true));
    assert!(!known.contradictory() && !equal.contradictory());
    assert!(assume(&[(a.clone(), Gtr, b.clone()), (b.clone(), Gtr, a.clone())]).contradictory());
    assert!(assume(&[(a.clone(), Gtr, int(1)), (a.clone(), Lss, int(0))]).contradictory());
    assert!(assume(&[(a.clone(), Eq, b.clone()), (b, Neq, a)]).contradictory());
}

/// An equation between a variable and a maximum of it bounds the variable.
#[test]
fn what_is_known_of_a_maximum_is_known_of_what_stands_in_it() {
    let r = var("r");
    let clamped = Value::minimum(&[int(2), Value::maximum(&[int(0), r.clone()]).unwrap()]).unwrap();
    let known = assume(&[(r.sub(&clamped).unwrap(), Eq, int(0))]);
    assert_eq!(known.decide(Lte, &r, &int(2)), Some(true));
    assert_eq!(known.decide(Gte, &r, &int(0)), Some(true));
    assert_eq!(known.decide(Lte, &r, &int(1)), None);
    let beyond = Value::maximum(&[int(1), r.sub(&int(1)).unwrap()]).unwrap();
    assert_eq!(known.decide(Eq, &beyond, &int(1)), Some(true));
}

/// That more is known, or that it is known in two steps, loses nothing.
#[test]
fn what_has_nothing_to_do_with_it_hinders_nothing() {
    let (a, b, p, n, t, v) = (var("a"), var("b"), var("p"), var("n"), var("t"), var("v"));
    let length = t.mul(&v).unwrap();
    let rounds = p.sub(&a).unwrap().div(&length).unwrap().floor().unwrap().neg().unwrap();
    for more in 0..4 {
        let mut known = assume(&[(b.clone(), Gtr, int(0)), (a.clone(), Gtr, b.clone()), (p.clone(), Lss, b.clone())]);
        if more & 1 > 0 {
            known.assume(Lss, &p, &a);
        }
        if more & 2 > 0 {
            known.assume(Gtr, &a, &int(0));
        }
        known.assume(Gtr, &v, &int(0));
        known.assume(Gtr, &t, &int(0));
        assert_eq!(known.decide(Gtr, &rounds, &int(0)), Some(true), "{more}");
        known.assume_natural(&Name::new("n"));
        known.assume(Lss, &n, &rounds);
        let place = p.add(&n.mul(&length).unwrap()).unwrap();
        assert_eq!(known.decide(Lss, &place, &a), Some(true), "{more}");
        assert_eq!(known.decide(Lss, &place.add(&length).unwrap(), &a), None, "{more}");
    }
}

/// A condition may tell where a value divides by what is not 0.
#[test]
fn a_division_counts_where_its_condition_holds() {
    let r = var("r");
    let size = r.sub(&int(3)).unwrap().abs().unwrap();
    let moved = r.sub(&r.sub(&int(3)).unwrap().div(&size).unwrap()).unwrap();
    let next = Value::choose(Gtr, &size, &int(1), &moved, &int(3)).unwrap();
    let known = assume(&[(next.clone(), Eq, int(3))]);
    assert_eq!(known.decide(Neq, &next, &int(-2)), Some(true));
    assert_eq!(known.decide(Eq, &next, &int(3)), Some(true));
    assert_eq!(known.simplify(&next), int(3));
    assert_eq!(known.decide(Neq, &r, &int(3)), None);
    assert_eq!(Assumptions::default().decide(Neq, &next, &int(-2)), None);
}

/// What a condition in a value excludes from a division may be so: where the value is compared, nothing follows of it.
#[test]
fn a_division_that_a_condition_excludes_may_be_by_0() {
    let (k, u, z) = (var("k"), var("u"), var("z"));
    let root = int(2).sqrt().unwrap();
    let beyond = |x: &Value| Value::choose(Gtr, x, &int(0), &int(1).div(x).unwrap(), &int(5)).unwrap();
    for (relation, bound) in [(Neq, 3), (Gtr, 3), (Gte, 4)] {
        let past = k.sub(&root).unwrap();
        let known = assume(&[(k.clone(), Gte, root.clone()), (beyond(&past), relation, int(bound))]);
        assert_eq!(known.decide(Neq, &k, &root), None, "{relation:?}: 5 is so too");
        let known = assume(&[(k.clone(), Gte, int(0)), (beyond(&k), relation, int(bound))]);
        assert_eq!(known.decide(Neq, &k, &int(0)), None, "{relation:?}");
        assert_eq!(known.simplify(&beyond(&k)), beyond(&k), "{relation:?}");
    }
    let square = u.mul(&u).unwrap().sub(&int(2)).unwrap();
    let apart = Value::choose(Neq, &square, &int(0), &z.div(&square).unwrap(), &int(1)).unwrap();
    let known = assume(&[(u.clone(), Gte, int(0)), (apart, Gtr, int(0))]);
    assert_eq!(known.decide(Neq, &square, &int(0)), None);
    let known = assume(&[(u, Gte, int(0)), (square.clone(), Gte, int(0))]);
    let more = int(1).add(&Value::choose(Gtr, &square, &int(0), &int(1).div(&square).unwrap(), &int(0)).unwrap());
    for other in [int(1), more.unwrap()] {
        let value = Value::choose(Gtr, &beyond(&square), &int(3), &square, &other).unwrap();
        assert_eq!(known.decide(Gtr, &value, &int(0)), None, "it is 0 where 5 > 3");
    }
}

/// A case in which nothing is left to refute may be none.
#[test]
fn what_cannot_be_is_no_case() {
    let (t, v) = (var("t"), var("v"));
    let length = t.mul(&v).unwrap();
    let rounds = int(-10).div(&length).unwrap().floor().unwrap().neg().unwrap();
    let known = assume(&[(v, Gtr, int(0)), (t, Gtr, int(0)), (rounds, Gtr, int(1))]);
    let step = Value::minimum(&[length.clone(), int(10)]).unwrap();
    assert_eq!(known.decide(Neq, &step, &int(10)), Some(true));
    assert_eq!(known.decide(Lss, &length, &int(10)), Some(true));
    assert_eq!(known.decide(Lss, &length, &int(5)), None);
}

#[test]
fn naturals() {
    let n = var("n");
    let mut known = Assumptions::default();
    known.assume_natural(&Name::new("n"));
    assert_eq!(known.is_natural(&n.add(&int(1)).unwrap()), Some(true));
    assert_eq!(known.is_natural(&n.sub(&int(1)).unwrap()), None);
    assert_eq!(known.is_natural(&n.add(&Value::fraction(1, 2).unwrap()).unwrap()), Some(false));
    assert_eq!(known.is_natural(&var("x")), None);
    known.assume(Neq, &n, &int(0));
    assert_eq!(known.is_natural(&n.sub(&int(1)).unwrap()), Some(true));
    assert_eq!(known.decide(Gte, &n, &int(1)), Some(true));
    assert_eq!(known.decide(Gtr, &n.mul(&int(2)).unwrap(), &int(1)), Some(true));
    let half = Value::fraction(1, 2).unwrap().power(&n).unwrap();
    assert_eq!(known.decide(Gtr, &half, &int(0)), Some(true));
    assert_eq!(known.decide(Lte, &half, &Value::fraction(1, 2).unwrap()), Some(true));
    assert_eq!(known.decide(Neq, &half, &int(0)), Some(true));
}

#[test]
fn maxima_and_conditions() {
    let (x, y) = (var("x"), var("y"));
    let none = Assumptions::default();
    let abs = x.abs().unwrap();
    assert_eq!(none.decide(Gte, &abs, &x), Some(true));
    assert_eq!(none.decide(Gte, &abs, &int(0)), Some(true));
    let sum = x.add(&y).unwrap().abs().unwrap();
    assert_eq!(none.decide(Lte, &sum, &abs.add(&y.abs().unwrap()).unwrap()), Some(true));
    let clamped = Value::clamp(&x, &int(-1), &int(1)).unwrap();
    assert_eq!(none.decide(Lte, &clamped.abs().unwrap(), &int(1)), Some(true));
    let choice = Value::choose(Gtr, &x, &int(0), &x, &int(0)).unwrap();
    assert_eq!(none.decide(Eq, &choice, &Value::maximum(&[int(0), x.clone()]).unwrap()), Some(true));
    let known = assume(&[(x.clone(), Gtr, y.clone())]);
    let choice = Value::choose(Gtr, &x, &y, &int(7), &x).unwrap();
    assert_eq!(known.simplify(&choice), int(7));
    assert_eq!(known.decide(Eq, &choice, &int(7)), Some(true));
    assert_eq!(known.simplify(&x.sub(&y).unwrap().abs().unwrap()), x.sub(&y).unwrap());
}

#[test]
fn steps_of_a_contraction() {
    // With 0 < k < 1 and p < g each step p + k*(g-p) stays below g and comes closer.
    let (k, g, p) = (var("k"), var("g"), var("p"));
    let known = assume(&[(k.clone(), Gtr, int(0)), (k.clone(), Lss, int(1)), (p.clone(), Lss, g.clone())]);
    let next = p.add(&k.mul(&g.sub(&p).unwrap()).unwrap()).unwrap();
    assert_eq!(known.decide(Lss, &next, &g), Some(true));
    assert_eq!(known.decide(Gtr, &next, &p), Some(true));
    assert_eq!(known.decide(Neq, &k, &int(1)), Some(true));
}

#[test]
fn undefined_sides_are_not_decided() {
    let x = var("x");
    let known = assume(&[(x.clone(), Gte, int(0))]);
    assert_eq!(known.decide(Gte, &int(1).div(&x).unwrap(), &int(0)), None);
    let vector = Value::vector(vec![x.clone(), int(1)]).unwrap();
    assert_eq!(known.decide(Eq, &vector, &vector), Some(true));
    assert_eq!(known.decide(Eq, &vector, &Value::vector(vec![x.clone(), int(2)]).unwrap()), Some(false));
    let normal = Value::distribution("Normal", vec![x, int(1)]).unwrap();
    assert_eq!(known.decide(Eq, &normal, &normal), Some(true));
    assert_eq!(known.decide(Eq, &normal, &int(1)), None);
}

/// An expression to be built over x, y and the natural n.
#[derive(Clone, Debug)]
enum Shape {
    Name(usize),
    Number(i64, i64),
    Two(usize, Box<Shape>, Box<Shape>),
    One(usize, Box<Shape>),
    If(Box<Shape>, Box<Shape>, Box<Shape>),
}

const NAMES: [&str; 3] = ["x", "y", "n"];

fn build(shape: &Shape) -> Option<Value> {
    Some(match shape {
        Shape::Name(place) => var(NAMES[*place]),
        Shape::Number(top, bottom) => Value::fraction(*top, *bottom).ok()?,
        Shape::Two(operator, left, right) => {
            let (left, right) = (build(left)?, build(right)?);
            match operator {
                0 | 1 => left.add(&right),
                2 | 3 => left.sub(&right),
                4 | 5 => left.mul(&right),
                6 => left.div(&right),
                7 => Value::maximum(&[left, right]),
                _ => Value::minimum(&[left, right]),
            }
            .ok()?
        }
        Shape::One(operator, inner) => {
            let inner = build(inner)?;
            match operator {
                0 => inner.abs(),
                1 => inner.floor(),
                2 => inner.sqrt(),
                3 => inner.power(&int(2)),
                4 => inner.power(&var("n")),
                _ => Value::fraction(1, 2).ok()?.power(&var("n")),
            }
            .ok()?
        }
        Shape::If(condition, then, other) => {
            Value::choose(Gtr, &build(condition)?, &int(0), &build(then)?, &build(other)?).ok()?
        }
    })
}

fn shape() -> impl Strategy<Value = Shape> {
    let leaf = prop_oneof![
        4 => (0..3usize).prop_map(Shape::Name),
        2 => (-3..4i64, 1..3i64).prop_map(|(top, bottom)| Shape::Number(top, bottom)),
    ];
    leaf.prop_recursive(3, 10, 3, |inner| {
        prop_oneof![
            6 => (0..9usize, inner.clone(), inner.clone())
                .prop_map(|(operator, a, b)| Shape::Two(operator, Box::new(a), Box::new(b))),
            2 => (0..6usize, inner.clone()).prop_map(|(operator, a)| Shape::One(operator, Box::new(a))),
            1 => (inner.clone(), inner.clone(), inner)
                .prop_map(|(a, b, c)| Shape::If(Box::new(a), Box::new(b), Box::new(c))),
        ]
    })
}

fn images(x: i64, y: i64, n: i64) -> BTreeMap<Name, Value> {
    let half = |number: i64| Value::fraction(number, 2).unwrap();
    [("x", half(x)), ("y", half(y)), ("n", int(n))].map(|(name, value)| (Name::new(name), value)).into()
}

/// What stands between two numbers that compare like this, one of several.
fn true_relation(order: std::cmp::Ordering, choice: usize) -> Relation {
    let fitting: Vec<Relation> = Relation::ALL.into_iter().filter(|relation| relation.holds(order)).collect();
    fitting[choice % fitting.len()]
}

proptest! {
    #![proptest_config(common::seeded(ProptestConfig { cases: 300, max_shrink_iters: 200, ..ProptestConfig::default() }))]

    #[test]
    fn no_answer_is_contradicted(
        facts in prop::collection::vec((shape(), shape(), 0..3usize), 0..4),
        (left, right) in (shape(), shape()),
        others in prop::collection::vec((-6..7i64, -6..7i64, 0..4i64), 6),
    ) {
        let (Some(left), Some(right)) = (build(&left), build(&right)) else { return Ok(()) };
        let point = images(others[0].0, others[0].1, others[0].2);
        let mut known = Assumptions::default();
        known.assume_natural(&Name::new("n"));
        for (one, other, choice) in &facts {
            let (Some(one), Some(other)) = (build(one), build(other)) else { continue };
            let (Ok(a), Ok(b)) = (one.substitute(&point), other.substitute(&point)) else { continue };
            let (Some(a), Some(b)) = (a.as_rational(), b.as_rational()) else { continue };
            known.assume(true_relation(a.cmp(&b), *choice), &one, &other);
        }
        prop_assert!(!known.contradictory(), "{:?} is possible at {:?}", known, point);
        let simple = known.simplify(&left);
        for (x, y, n) in others {
            let point = images(x, y, n);
            let holds = |relation: Relation, left: &Value, right: &Value| {
                let (a, b) = (left.substitute(&point).ok()?.as_rational()?, right.substitute(&point).ok()?.as_rational()?);
                Some(relation.holds(a.cmp(&b)))
            };
            if !known.iter().all(|(relation, value)| holds(relation, &value, &int(0)) == Some(true)) {
                continue;
            }
            if let Some(same) = holds(Eq, &left, &simple) {
                prop_assert!(same, "{} is not {} at {:?} under {:?}", left, simple, point, known);
            }
            for relation in Relation::ALL {
                if let (Some(answer), Some(truth)) = (known.decide(relation, &left, &right), holds(relation, &left, &right)) {
                    prop_assert_eq!(answer, truth, "{} {} {} at {:?} under {:?}", left, relation.symbol(), right, point, known);
                }
            }
        }
    }

    #[test]
    fn the_normal_form_keeps_the_value(shape in shape(), x in -6..7i64, y in -6..7i64, n in 0..4i64) {
        let point = images(x, y, n);
        let names = |name: &Name| point.get(name).cloned();
        if let (Some(whole), Some(direct)) = (build(&shape), evaluate(&shape, &names))
            && let Ok(value) = whole.substitute(&point)
        {
            prop_assert_eq!(value, direct, "{} at {:?}", whole, point);
        }
    }
}

/// The expression with numbers from the start.
fn evaluate(shape: &Shape, names: &dyn Fn(&Name) -> Option<Value>) -> Option<Value> {
    Some(match shape {
        Shape::Name(place) => names(&Name::new(NAMES[*place]))?,
        Shape::Number(top, bottom) => Value::fraction(*top, *bottom).ok()?,
        Shape::Two(operator, left, right) => {
            let (left, right) = (evaluate(left, names)?, evaluate(right, names)?);
            match operator {
                0 | 1 => left.add(&right),
                2 | 3 => left.sub(&right),
                4 | 5 => left.mul(&right),
                6 => left.div(&right),
                7 => Value::maximum(&[left, right]),
                _ => Value::minimum(&[left, right]),
            }
            .ok()?
        }
        Shape::One(operator, inner) => {
            let (inner, n) = (evaluate(inner, names)?, names(&Name::new("n"))?);
            match operator {
                0 => inner.abs(),
                1 => inner.floor(),
                2 => inner.sqrt(),
                3 => inner.power(&int(2)),
                4 => inner.power(&n),
                _ => Value::fraction(1, 2).ok()?.power(&n),
            }
            .ok()?
        }
        Shape::If(condition, then, other) => {
            // Both branches are built, as they are symbolically: a branch that is not defined is left out of the test.
            let (condition, then, other) =
                (evaluate(condition, names)?, evaluate(then, names)?, evaluate(other, names)?);
            Value::choose(Gtr, &condition, &int(0), &then, &other).ok()?
        }
    })
}

/// A square and a root are factors that the normal form hides: `x*x-2*x+1`, and `s*s` of `s = norm((a,b))`, written
/// `a^2+b^2`.
#[test]
fn hidden_factors_give_signs() {
    let variable = |name: &str| Value::variable(&Name::new(name));
    let (a, b, v, zero) = (variable("a"), variable("b"), variable("v"), Value::zero());
    let gap = v.sub(&Value::integer(5)).expect("a value");
    let square = gap.mul(&gap).expect("a value");
    let mut known = Assumptions::default();
    assert_eq!(known.decide(Relation::Gte, &square, &zero), Some(true));
    assert_eq!(known.decide(Relation::Neq, &square, &zero), None);
    known.assume(Relation::Lss, &v, &Value::integer(5));
    assert_eq!(known.decide(Relation::Gtr, &square, &zero), Some(true));
    let length = Value::vector(vec![a.clone(), b.clone()]).expect("a vector").norm().expect("a length");
    let step = a.mul(&v).and_then(|product| product.div(&length)).expect("a value");
    let mut known = Assumptions::default();
    [&a, &b, &v].into_iter().for_each(|one| known.assume(Relation::Gtr, one, &zero));
    assert_eq!(known.decide(Relation::Lss, &step, &a), None, "a step may go past");
    known.assume(Relation::Gtr, &length, &v);
    assert_eq!(known.decide(Relation::Lss, &step, &a), Some(true));
}

/// A root of a number lies between two rationals, so a multiple of it between what these allow; and it is no rational.
#[test]
fn roots_of_numbers_times_what_is_bounded() {
    let n = var("n");
    let root = int(8321).sqrt().unwrap();
    let value = root.mul(&n.add(&int(16380)).unwrap().abs().unwrap()).unwrap().div(&int(17_039_360)).unwrap();
    let known = assume(&[(n.clone(), Gte, int(0)), (n.clone(), Lte, int(1))]);
    let bound = |top: i64, below: i64| Value::fraction(top, below).unwrap();
    assert_eq!(known.decide(Gtr, &value, &bound(1, 10)), Some(false));
    assert_eq!(known.decide(Gtr, &value, &bound(8, 100)), Some(true));
    // sqrt(8321)*16380/17039360 = 0.087690…, and 0.087695… for n = 1: between these it depends on n.
    assert_eq!(known.decide(Gtr, &value, &bound(87_692, 1_000_000)), None);
    let two = int(2).sqrt().unwrap();
    assert_eq!(known.decide(Gtr, &two, &bound(14_142_135, 10_000_000)), Some(true));
    assert_eq!(known.decide(Gtr, &two, &bound(14_142_136, 10_000_000)), Some(false));
    let times = two.mul(&n).unwrap();
    assert_eq!(known.decide(Lte, &times, &bound(3, 2)), Some(true));
    assert_eq!(known.decide(Lte, &times, &bound(7, 5)), None);
}

/// `floor((a*n+b)/m)`
fn part(n: &Value, a: i64, b: i64, m: i64) -> Value {
    div(&add(&mul(&int(a), n), &int(b)), &int(m)).floor().unwrap()
}

/// The rest of a division.
fn rest(n: &Value, a: i64, b: i64, m: i64) -> Value {
    sub(&add(&mul(&int(a), n), &int(b)), &mul(&int(m), &part(n, a, b, m)))
}

#[test]
fn integer_parts_follow_from_one_another() {
    let n = var("n");
    // Where n+2 leaves 1 by 4, n leaves 3.
    let known = assume(&[(rest(&n, 1, 2, 4), Eq, int(1))]);
    assert_eq!(known.decide(Eq, &rest(&n, 1, 0, 4), &int(3)), Some(true));
    assert_eq!(known.decide(Eq, &rest(&n, 1, 1, 4), &int(0)), Some(true));
    assert_eq!(known.decide(Gtr, &rest(&n, 1, 0, 4), &int(3)), Some(false));
    // Between 0 and 1 there is no other integer part than 0.
    let known = assume(&[(n.clone(), Gte, int(0)), (n.clone(), Lss, int(1)), (rest(&n, 2, 0, 3), Gte, int(1))]);
    assert_eq!(known.decide(Gte, &n, &frac(1, 2)), Some(true));
    assert_eq!(known.decide(Eq, &part(&n, 2, 0, 3), &int(0)), Some(true));
    // No integer is half of an odd one.
    let (f, g) = (part(&n, 1, 0, 3), part(&var("m"), 1, 0, 5));
    assert!(assume(&[(mul(&int(2), &f), Eq, add(&mul(&int(2), &g), &int(1)))]).contradictory());
    assert!(!assume(&[(mul(&int(2), &f), Eq, add(&mul(&int(3), &g), &int(1)))]).contradictory());
}

proptest! {
    #![proptest_config(seeded(ProptestConfig { cases: 300, ..ProptestConfig::default() }))]
    /// What holds of numbers with integer parts is never refuted, nor is anything else told of them that does not.
    #[test]
    fn nothing_is_told_of_integer_parts_that_a_number_contradicts(
        n in -20i64..21, below in 1i64..4,
        facts in proptest::collection::vec((-3i64..4, -4i64..5, 2i64..5, 0usize..3), 1..4),
        (a, b, m, by) in (-3i64..4, -4i64..5, 2i64..5, -3i64..6),
    ) {
        let (name, value) = (var("n"), frac(n, below));
        let order = |one: &Value| one.with(&pars::name::Name::new("n"), &value).unwrap();
        let mut known = Assumptions::default();
        for (a, b, m, kind) in facts {
            let rest = rest(&name, a, b, m);
            let there = order(&rest);
            match kind {
                0 => known.assume(Eq, &rest, &there),
                1 => known.assume(Lte, &rest, &add(&there, &frac(1, 3))),
                _ => known.assume(Gtr, &rest, &sub(&there, &frac(1, 2))),
            }
        }
        let asked = rest(&name, a, b, m);
        prop_assert!(!known.contradictory());
        for relation in [Eq, Neq, Lss, Lte, Gtr, Gte] {
            let truth = Assumptions::default().decide(relation, &order(&asked), &int(by)).unwrap();
            let told = known.decide(relation, &asked, &int(by));
            prop_assert!(told.is_none_or(|told| told == truth), "{} {} {}: {:?}", asked, relation.symbol(), by, told);
        }
    }
}
