//! Forms with integer parts of steps against each other, and of pursuits and ramps, against plain iteration with numbers for
//! the symbols; and what is not so is turned away by the induction.

mod common;

use std::collections::BTreeMap;

use num_rational::BigRational;
use pars::closed_form::{Form, Piece, Solved, Unchecked};
use pars::name::Name;
use pars::recurrence::{Reach, reach, solve_until};
use pars::value::Value;
use proptest::prelude::*;

use common::*;

type Values = BTreeMap<Name, Value>;

fn solved(asked: &str) -> Solved {
    let (question, environment) = question(asked);
    solve_until(question.recurrence, &environment.assumptions, &|| false).unwrap_or_else(|why| panic!("{asked}: {why}"))
}

/// The term of a form at an index, with these numbers for its symbols.
fn term(form: &Form, index: &Name, at: i64, numbers: &Values) -> Value {
    let put = |value: &Value| value.with(index, &int(at)).and_then(|value| value.substitute(numbers)).unwrap();
    match form {
        Form::Value(early, value) => {
            early.get(at as usize).map_or_else(|| put(value), |term| term.substitute(numbers).unwrap())
        }
        Form::Pieces(pieces) => {
            let here = |piece: &&Piece| {
                piece.until.as_ref().is_none_or(|until| put(until).as_rational() > int(at).as_rational())
            };
            put(&pieces.iter().find(here).expect("a piece").form)
        }
        other => put(&other.value(index).expect("a value")),
    }
}

fn numbers(all: &[(&str, BigRational)]) -> Values {
    all.iter().map(|(name, number)| (Name::new(name), Value::rational(number.clone()))).collect()
}

/// All forms against the terms that the equations make of these numbers.
fn agree(asked: &str, values: &Values) {
    let solved = solved(asked);
    let (question, _) = question(asked);
    let mut plain = question.recurrence.clone();
    for sequence in &mut plain.sequences {
        sequence.next = sequence.next.substitute(values).unwrap();
        sequence.start.iter_mut().for_each(|start| *start = start.substitute(values).unwrap());
    }
    for (form, terms) in solved.forms().iter().zip(plain.iterate(30).unwrap()) {
        for (at, wanted) in terms.iter().enumerate() {
            let found = term(form, &plain.index, at as i64, values);
            assert_eq!(&found, wanted, "{asked} at {at} with {values:?}");
        }
    }
}

fn small() -> impl Strategy<Value = BigRational> {
    (1i64..40, 1i64..7).prop_map(|(top, below)| BigRational::new(top.into(), below.into()))
}

proptest! {
    #![proptest_config(seeded(ProptestConfig { cases: 60, ..ProptestConfig::default() }))]

    #[test]
    fn steps_against_each_other_are_a_rotation(p in small(), q in small(), far in small(), guard in 0usize..4, below in any::<bool>()) {
        let step = ["if x(n) > c then x(n)-p else x(n)+q", "if x(n) >= c then x(n)-p else x(n)+q",
            "if x(n) < c then x(n)+q else x(n)-p", "if x(n) <= c then x(n)+q else x(n)-p"][guard];
        let side = if below { "d < c" } else { "d > c" };
        let asked = format!("param p > 0, q > 0, c, d, {side}\nsolve x(n+1) = {step}, x(0) = d\n");
        let centre = BigRational::from_integer(3.into());
        let start = if below { &centre - far } else { &centre + far };
        agree(&asked, &numbers(&[("p", p), ("q", q), ("c", centre), ("d", start)]));
    }

    #[test]
    fn pursuits_are_what_the_equations_make(v in small(), w in small(), d in small()) {
        let asked = "param w > 0, v > w, d > 0\nsolve x(n+1) = if x(n) < y(n) then x(n)+v else x(n), x(0) = 0, \
            y(n+1) = y(n)+w, y(0) = d\n";
        agree(asked, &numbers(&[("v", &v + &w), ("w", w), ("d", d)]));
    }

    #[test]
    fn what_is_counted_is_what_the_equations_make(a in small(), b in small(), w in small()) {
        let asked = "param a > 0, b > 0, w\nsolve x(n+1) = if y(n) > x(n) then x(n)+a else x(n), x(0) = 0, \
            y(n+1) = if y(n) > x(n) then y(n) else y(n)+b, y(0) = 1, \
            c(n+1) = if y(n) > x(n) then c(n)+w else c(n)-2, c(0) = 5\n";
        agree(asked, &numbers(&[("a", a), ("b", b), ("w", w)]));
    }

    #[test]
    fn controllers_that_saturate_are_what_the_equations_make(share in 1i64..9, u in small(), more in small()) {
        let asked = "param k > 0, k < 1, u > 0, g, g*k >= u\nsolve e(n+1) = e(n)-clamp(k*e(n),-u,u), e(0) = g\n";
        let k = BigRational::new(share.into(), 10.into());
        let far = &u / &k + more;
        agree(asked, &numbers(&[("k", k), ("u", u), ("g", far)]));
    }

    #[test]
    fn the_end_of_a_ramp_is_the_first_index_there(a in small(), w in small(), d in 1i64..200) {
        let asked = |more: &str| format!("param a > 0, w > 0, d > 0{more}\nsolve v(n+1) = min(v(n)+a,w), v(0) = 0, \
            p(n+1) = p(n)+v(n), p(0) = 0 find n with p(n) >= d\n");
        let values = numbers(&[("a", a.clone()), ("w", w.clone()), ("d", BigRational::from_integer(d.into()))]);
        agree(&asked(""), &values);
        // Which of the two parts it ends in is a question of the way that is gone in the first.
        let gone = "1/2*a*ceil(w/a)^2-1/2*a*ceil(w/a)";
        let on_the_ramp = (&w / &a).ceil() * ((&w / &a).ceil() - BigRational::from_integer(1.into())) * &a
            >= BigRational::from_integer((2 * d).into());
        let relation = if on_the_ramp { ">=" } else { "<" };
        let (question, environment) = question(&asked(&format!(", {gone} {relation} d")));
        let known = &environment.assumptions;
        let solved = solve_until(question.recurrence.clone(), known, &|| false).unwrap();
        let (relation, left, right) = question.find.expect("a goal");
        let found = reach(&question.recurrence, Some(&solved), (relation, &left, &right), known, &|| false);
        let Reach::At(at, _) = found else { panic!("no first index where {gone} is known: {found:?}") };
        let at = at.substitute(&values).unwrap().as_rational().expect("a number").to_integer();
        let way =
            |index: i64| term(&solved.forms()[1], &question.recurrence.index, index, &values).as_rational().unwrap();
        let (at, goal) = (i64::try_from(at).unwrap(), BigRational::from_integer(d.into()));
        prop_assert!(way(at) >= goal && (at == 0 || way(at - 1) < goal), "{at}");
    }
}

#[test]
fn thermostats_come_round_after_many_steps() {
    for (below, high, low) in [("18", "3", "1"), ("19", "3", "1"), ("37/2", "4", "1"), ("37/2", "5/2", "1")] {
        let asked = format!("solve t(n+1) = if t(n) < {below} then 9/10*t(n)+{high} else 9/10*t(n)+{low}, t(0) = 10\n");
        let solved = solved(&asked);
        let terms = solved.recurrence().iterate(150).unwrap().remove(0);
        for (at, wanted) in terms.iter().enumerate() {
            assert_eq!(solved.at(&Name::new("t"), at as i64).unwrap(), *wanted, "{asked} at {at}");
        }
    }
}

/// Whether the induction lets a form pass.
fn passes(asked: &str, form: Form) -> Result<Solved, Unchecked> {
    let (question, environment) = question(asked);
    Solved::check(question.recurrence, vec![form], Vec::new(), &environment.assumptions)
}

#[test]
fn what_is_no_rotation_is_turned_away() {
    let around = |step: &str| format!("param p > 0, q > 0, c\nsolve x(n+1) = {step}, x(0) = c\n");
    let asked = around("if x(n) > c then x(n)-p else x(n)+q");
    let form = solved(&asked).forms()[0].clone();
    assert!(passes(&asked, form.clone()).is_ok());
    // The same form of other equations: the bound on the other side, other steps, steps that are not known to be any.
    for other in [
        around("if x(n) >= c then x(n)-p else x(n)+q"),
        around("if x(n) > c then x(n)-q else x(n)+p"),
        around("if x(n) > c then x(n)-p else x(n)+2*q"),
        around("if x(n) > c+q/2 then x(n)-p else x(n)+q"),
        "param p, q > 0, c\nsolve x(n+1) = if x(n) > c then x(n)-p else x(n)+q, x(0) = c\n".to_string(),
        "param p > 0, q, c\nsolve x(n+1) = if x(n) > c then x(n)-p else x(n)+q, x(0) = c\n".to_string(),
        "param p > 0, q > 0, c\nsolve x(n+1) = if x(n) > c then x(n)-p else x(n)+q, x(0) = c+1\n".to_string(),
    ] {
        assert!(passes(&other, form.clone()).is_err(), "{other}");
    }
    // Other forms of the same equations.
    let Form::Value(_, value) = &form else { panic!("{form:?}") };
    let (p, q, n) = (var("p"), var("q"), var("n"));
    let whole = add(&p, &q);
    for wrong in [
        add(value, &int(1)),
        add(value, &whole),
        value.with(&Name::new("n"), &add(&n, &int(1))).unwrap(),
        value.with(&Name::new("p"), &q).unwrap(),
        add(value, &mul(&whole, &div(&n, &int(2)).floor().unwrap())),
    ] {
        assert!(passes(&asked, Form::Value(Vec::new(), wrong.clone())).is_err(), "{wrong}");
    }
}

#[test]
fn what_does_not_fall_is_turned_away() {
    // With a share above 1 what is left changes its sign, and with one below 0 it grows: neither is at rest within a step.
    let form = solved("param k > 0, k < 1, u > 0, g > 0, g*k <= u\nsolve e(n+1) = e(n)-clamp(k*e(n),-u,u), e(0) = g\n");
    let form = form.forms()[0].clone();
    for known in [
        "k > 0, u > 0, g > 0, g*k <= u",
        "k < 1, u > 0, g > 0, g*k <= u",
        "k > 0, k < 1, u > 0, g > 0",
        "k > 0, k < 1, g > 0",
    ] {
        let asked = format!(
            "param {}{known}\nsolve e(n+1) = e(n)-clamp(k*e(n),-u,u), e(0) = g\n",
            if known.contains("u > 0") { "" } else { "u, " }
        );
        assert!(passes(&asked, form.clone()).is_err(), "{known}");
    }
}
