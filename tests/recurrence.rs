//! Closed forms against plain iteration, and first indices against trying.

mod common;

use pars::assumption::Assumptions;
use pars::name::Name;
use pars::recurrence::{Closed, Goal, Reach, first, solve};
use pars::value::{Relation, Value};
use proptest::prelude::*;

use common::*;

fn clamp(x: &Value, low: &Value, high: &Value) -> Value {
    Value::clamp(x, low, high).unwrap()
}

fn r() -> Name {
    Name::new("r")
}

fn n() -> Name {
    Name::new("n")
}

/// Solves, and compares the first 20 terms with plain iteration.
fn form(map: &Value, start: &Value, known: &Assumptions) -> Closed {
    let closed = solve(map, &r(), start, &n(), known).unwrap();
    let mut value = start.clone();
    for step in 0..20 {
        let there = closed.at(&n(), &int(step), known).unwrap();
        let equal = known.decide(Relation::Eq, &there, &value);
        assert_eq!(equal, Some(true), "{map} at {step}: {there} is not {value}");
        value = known.simplify(&map.with(&r(), &value).unwrap());
    }
    closed
}

fn numeric(map: &Value, start: &Value) -> Closed {
    form(map, start, &Assumptions::default())
}

fn when(closed: &Closed, goal: Goal) -> Reach {
    first(closed, &n(), &goal, &Assumptions::default())
}

fn at(number: i64) -> Reach {
    Reach::At(int(number), Vec::new())
}

fn reason(reach: Reach) -> String {
    match reach {
        Reach::Never(reason) => reason,
        other => panic!("{other:?}"),
    }
}

#[test]
fn constant_speed() {
    // v = 1, t = 1/10 from 0 to 10
    let closed = numeric(&add(&var("r"), &frac(1, 10)), &int(0));
    assert_eq!(when(&closed, Goal::Equals(int(10))), at(100));
    let back = numeric(&sub(&var("r"), &frac(1, 10)), &int(10));
    assert_eq!(when(&back, Goal::Equals(int(0))), at(100));
    let missed = reason(when(&numeric(&add(&var("r"), &int(3)), &int(0)), Goal::Equals(int(10))));
    assert_eq!(missed, "it steps over it: it is 9 at n = 3 and 12 at n = 4");
    let away = reason(when(&back, Goal::Equals(int(11))));
    assert_eq!(away, "it moves away: it is 10, then 99/10, and so on");
}

#[test]
fn proportional_speed() {
    // s(d) = k*d: r + k*t*(g-r), to within 1/10 of 10
    for (kt, steps) in [(frac(1, 10), 44), (frac(1, 2), 7), (int(1), 1)] {
        let map = add(&var("r"), &mul(&kt, &sub(&int(10), &var("r"))));
        let closed = numeric(&map, &int(0));
        assert_eq!(when(&closed, Goal::Within(int(10), frac(1, 10))), at(steps));
        let exact = when(&closed, Goal::Equals(int(10)));
        if steps == 1 {
            assert_eq!(exact, at(1));
        } else {
            assert!(reason(exact).starts_with("what is left to 10 shrinks by the factor"));
        }
    }
}

#[test]
fn clamped_speed() {
    let step = |a: i64| clamp(&sub(&int(a), &var("r")), &int(-1), &int(1));
    let there = numeric(&add(&var("r"), &step(3)), &int(0));
    assert_eq!(when(&there, Goal::Equals(int(3))), at(3));
    let back = numeric(&add(&var("r"), &step(-1)), &int(3));
    assert_eq!(when(&back, Goal::Equals(int(-1))), at(4));
    // With t = 1/2 it approaches 3: 1/2, 1, 3/2, 2, 5/2, 11/4, …
    let half = numeric(&add(&var("r"), &mul(&frac(1, 2), &step(3))), &int(0));
    assert_eq!(half.pieces.len(), 2);
    let reason = reason(when(&half, Goal::Equals(int(3))));
    assert_eq!(reason, "what is left to 3 shrinks by the factor 1/2 each round, (1/2)^n, and is never 0: no n");
    assert_eq!(when(&half, Goal::Within(int(3), frac(1, 100))), at(11));
    assert_eq!(when(&half, Goal::Holds(Relation::Gtr, var("r"), int(2))), at(5));
    let distance = sub(&var("r"), &int(3)).abs().unwrap();
    assert_eq!(when(&half, Goal::Holds(Relation::Lte, distance, int(1))), at(4));
}

#[test]
fn dithering() {
    // Full speed towards 7/2 in steps of 1: 0, 1, 2, 3, 4, 3, 4, …
    let r = var("r");
    let map = add(&r, &Value::choose(Relation::Lss, &r, &frac(7, 2), &int(1), &int(-1)).unwrap());
    let closed = numeric(&map, &int(0));
    assert!(reason(when(&closed, Goal::Equals(frac(7, 2)))).contains("in turn for ever"));
    assert_eq!(when(&closed, Goal::Equals(int(4))), at(4));
    assert_eq!(when(&closed, Goal::Holds(Relation::Neq, var("r"), int(0))), at(1));
}

#[test]
fn dead_beat() {
    // r + (a-r)/t*t = a
    let (p, a, t) = (var("p0"), var("a"), var("t"));
    let map = add(&var("r"), &mul(&div(&sub(&a, &var("r")), &t), &t));
    let mut known = Assumptions::default();
    known.assume(Relation::Gtr, &t, &int(0));
    let closed = form(&map, &p, &known);
    assert!(matches!(first(&closed, &n(), &Goal::Equals(a.clone()), &known), Reach::Unknown(_)));
    known.assume(Relation::Neq, &p, &a);
    assert_eq!(first(&closed, &n(), &Goal::Equals(a), &known), at(1));
}

#[test]
fn symbolic_constant_speed() {
    let (p, a, t, v) = (var("p0"), var("a"), var("t"), var("v"));
    let mut known = Assumptions::default();
    known.assume(Relation::Gtr, &t, &int(0));
    known.assume(Relation::Gtr, &v, &int(0));
    known.assume(Relation::Gtr, &a, &p);
    let closed = form(&add(&var("r"), &mul(&v, &t)), &p, &known);
    let steps = div(&sub(&a, &p), &mul(&v, &t));
    let Reach::At(found, conditions) = first(&closed, &n(), &Goal::Equals(a.clone()), &known) else { panic!() };
    assert_eq!(found, steps);
    assert_eq!(conditions, vec![(Relation::Eq, steps.floor().unwrap(), steps.clone())]);
    let Reach::At(found, conditions) = first(&closed, &n(), &Goal::Holds(Relation::Gte, var("r"), a), &known) else {
        panic!()
    };
    assert_eq!((found, conditions), (steps.ceiling().unwrap(), vec![]));
    let below = Goal::Holds(Relation::Lss, var("r"), p);
    assert!(matches!(first(&closed, &n(), &below, &known), Reach::Never(_)));
}

#[test]
fn symbolic_contraction() {
    let (p, g, k) = (var("p0"), var("g"), var("k"));
    let map = add(&var("r"), &mul(&k, &sub(&g, &var("r"))));
    let mut known = Assumptions::default();
    known.assume(Relation::Gtr, &k, &int(0));
    known.assume(Relation::Lss, &k, &int(1));
    known.assume(Relation::Lss, &p, &g);
    let closed = form(&map, &p, &known);
    assert!(matches!(first(&closed, &n(), &Goal::Equals(g.clone()), &known), Reach::Never(_)));
    let beyond = Goal::Holds(Relation::Gte, var("r"), g.clone());
    assert!(matches!(first(&closed, &n(), &beyond, &known), Reach::Never(_)));
    // From p0 to p0 + 10 with k = 1/2: the offset cancels.
    let map = add(&var("r"), &mul(&frac(1, 2), &sub(&add(&p, &int(10)), &var("r"))));
    let closed = form(&map, &p, &Assumptions::default());
    assert_eq!(when(&closed, Goal::Within(add(&p, &int(10)), frac(1, 10))), at(7));
}

#[test]
fn symbolic_clamp() {
    // r + clamp(a-r, -v*t, v*t) from below, at least one whole step away
    let (p, a, v) = (var("p0"), var("a"), var("v"));
    let map = add(&var("r"), &clamp(&sub(&a, &var("r")), &v.neg().unwrap(), &v));
    let mut known = Assumptions::default();
    known.assume(Relation::Gtr, &v, &int(0));
    known.assume(Relation::Gtr, &sub(&a, &p), &v);
    let closed = solve(&map, &r(), &p, &n(), &known).unwrap();
    assert!(closed.pieces.len() >= 2);
    assert_eq!(closed.pieces[0].form, add(&p, &mul(&var("n"), &v)));
    assert_eq!(closed.pieces.last().unwrap().form, a);
}

#[test]
fn unknown_factor() {
    let closed =
        solve(&add(&mul(&var("c"), &var("r")), &int(1)), &r(), &int(0), &n(), &Assumptions::default()).unwrap();
    assert_eq!(closed.conditions, vec![(Relation::Neq, var("c"), int(1))]);
}

#[test]
fn no_closed_form() {
    let none = Assumptions::default();
    assert!(solve(&mul(&var("r"), &var("r")), &r(), &frac(1, 2), &n(), &none).is_err());
    assert!(solve(&var("r").floor().unwrap(), &r(), &frac(1, 2), &n(), &none).is_err());
    let turn = Value::choose(Relation::Gtr, &var("r"), &int(2), &int(0), &add(&var("r"), &int(1))).unwrap();
    assert!(solve(&turn, &r(), &int(0), &n(), &none).unwrap_err().reason.contains("goes round"));
}

proptest! {
    #![proptest_config(common::seeded(ProptestConfig::with_cases(60)))]

    #[test]
    fn pieces_agree_with_iteration(
        (gain, time) in (1..8i64, 1..4i64),
        (low, high) in (1..5i64, 1..5i64),
        (start, goal) in (-12..13i64, -12..13i64),
    ) {
        // r + clamp(gain/4*(g-r), -low/2, high/2)*time/2
        let (g, r) = (frac(goal, 2), var("r"));
        let push = clamp(&mul(&frac(gain, 4), &sub(&g, &r)), &frac(-low, 2), &frac(high, 2));
        let map = add(&r, &mul(&push, &frac(time, 2)));
        let known = Assumptions::default();
        let Ok(closed) = solve(&map, &Name::new("r"), &frac(start, 2), &n(), &known) else { return Ok(()) };
        let mut value = frac(start, 2);
        let (mut met, mut near, mut over) = (None, None, None);
        for step in 0..40i64 {
            prop_assert_eq!(closed.at(&n(), &int(step), &known), Some(value.clone()));
            let distance = sub(&value, &g).abs().unwrap();
            let holds = |relation, left: &Value, right: &Value| known.decide(relation, left, right) == Some(true);
            met = met.or((value == g).then_some(step));
            near = near.or(holds(Relation::Lte, &distance, &frac(1, 3)).then_some(step));
            over = over.or(holds(Relation::Gtr, &value, &add(&g, &frac(1, 5))).then_some(step));
            value = map.with(&Name::new("r"), &value).unwrap();
        }
        let expect = |goal: Goal, tried: Option<i64>| match (when(&closed, goal), tried) {
            (Reach::At(found, _), Some(tried)) => found == int(tried),
            (Reach::At(found, _), None) => known.decide(Relation::Gte, &found, &int(40)) == Some(true),
            (Reach::Never(_), tried) => tried.is_none(),
            (Reach::Unknown(_), _) => false,
        };
        prop_assert!(expect(Goal::Equals(g.clone()), met));
        prop_assert!(expect(Goal::Within(g.clone(), frac(1, 3)), near));
        prop_assert!(expect(Goal::Holds(Relation::Gtr, var("r"), add(&g, &frac(1, 5))), over));
        let distance = sub(&var("r"), &g).abs().unwrap();
        prop_assert!(expect(Goal::Holds(Relation::Lte, distance, frac(1, 3)), near));
    }
}

/// `x(n+1) = if x(n) < 2^(-n) then x(n)+1 else x(n)/2-(n^2-5*n), x(3) = 0`, which is refused after a long search.
fn long() -> pars::closed_form::Recurrence {
    let (x, n) = (Name::new("x"), var("n"));
    let term = Value::variable(&pars::closed_form::term(&x, &Name::new("n"), 0));
    let half = frac(1, 2).power(&n).unwrap();
    let square = n.mul(&n).unwrap().sub(&n.mul(&int(5)).unwrap()).unwrap();
    let below = Value::truth(Relation::Lss, &term, &half).unwrap();
    let other = term.mul(&frac(1, 2)).unwrap().sub(&square).unwrap();
    let step = add(&term, &int(1)).sub(&other).unwrap();
    let next = add(&other, &below.mul(&step).unwrap());
    let sequence = pars::closed_form::Sequence { name: x, start: vec![int(0)], next };
    pars::closed_form::Recurrence { index: Name::new("n"), from: 3, sequences: vec![sequence] }
}

#[test]
fn a_search_ends_when_it_is_interrupted() {
    use pars::recurrence::solve_until;
    let asked = std::cell::Cell::new(0);
    let count = |most: usize| {
        asked.set(0);
        let stop = || {
            asked.set(asked.get() + 1);
            asked.get() > most
        };
        solve_until(long(), &Assumptions::default(), &stop).unwrap_err().reason
    };
    let whole = count(usize::MAX);
    let polls = asked.get();
    assert!(polls > 1_000, "{polls}");
    assert!(whole.starts_with("it is not known how long") && whole.contains("from n = "), "{whole}");
    // In the middle of it, and soon after it is asked for.
    assert_eq!(count(polls / 2), "interrupted");
    assert!(asked.get() < polls / 2 + 100, "{} of {polls}", asked.get());
}
