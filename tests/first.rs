//! That an index is the first is checked apart from whoever found it: each other index is turned away.

mod common;

use pars::closed_form::{Comparison, Earlier, Solved, first};
use pars::recurrence::{Reach, reach, solve_until};
use pars::value::{Relation, Value};
use proptest::prelude::*;

use common::*;

/// How an index is shown to be the first, under these conditions.
fn shown(asked: &str, at: &Value, conditions: &[Comparison]) -> Option<Earlier> {
    let (question, environment) = question(asked);
    let known = &environment.assumptions;
    let solved: Option<Solved> = solve_until(question.recurrence.clone(), known, &|| false).ok();
    let (relation, left, right) = question.find.expect("a goal");
    first(&question.recurrence, solved.as_ref(), (relation, &left, &right), (at, conditions), known).ok()
}

/// The index that is found, shown to be the first, is that; and none of these is.
fn only(asked: &str, how: Earlier, others: &[Value]) {
    let (question, environment) = question(asked);
    let known = &environment.assumptions;
    let solved = solve_until(question.recurrence.clone(), known, &|| false).ok();
    let (relation, left, right) = question.find.expect("a goal");
    let found = reach(&question.recurrence, solved.as_ref(), (relation, &left, &right), known, &|| false);
    let Reach::At(at, conditions) = found else { panic!("{asked}: {found:?}") };
    assert_eq!(shown(asked, &at, &conditions), Some(how), "{asked}: {at}");
    for other in others {
        assert_eq!(shown(asked, other, &conditions), None, "{asked}: {other}");
    }
}

#[test]
fn a_first_index_is_shown_and_no_other() {
    let around = |at: i64| vec![int(at - 1), int(at + 1), int(at + 2), int(0), int(-1), frac(2 * at + 1, 2)];
    only("solve r(n+1) = r(n)+3, r(0) = 1 find n with r(n) >= 20\n", Earlier::OneByOne, &around(7));
    only("solve r(n+1) = r(n)/2+3, r(0) = 0 find n with abs(r(n)-6) <= 1/1000\n", Earlier::OneByOne, &around(13));
    // Late ones are not gone through one by one.
    only("solve r(n+1) = 101/100*r(n), r(0) = 1 find n with r(n) >= 10^6\n", Earlier::Forms, &around(1389));
    only("solve r(n+1) = max(r(n)-1,0), r(0) = 9000 find n with r(n) <= 10\n", Earlier::Forms, &around(8990));
    only("solve r(n+1) = -r(n), r(0) = 1 find n with r(n) = 1\n", Earlier::None, &[int(1), int(2)]);
    // A map without closed form is followed itself.
    only("solve r(n+1) = r(n)+1/r(n), r(0) = 1 find n with r(n) >= 5\n", Earlier::OneByOne, &[int(11), int(13)]);
}

#[test]
fn a_first_index_in_symbols_is_shown_and_no_other() {
    let (p, a, v) = (var("p"), var("a"), var("v"));
    let rounds = |rest: &Value| div(rest, &v).ceiling().unwrap();
    let way = rounds(&sub(&a, &p));
    let asked = "param v > 0, p, a\nsolve r(n+1) = r(n)+v, r(0) = p find n with r(n) >= a\n";
    let others = [way.clone(), add(&way, &int(1)), int(0), int(1), div(&sub(&a, &p), &v).floor().unwrap()];
    only(asked, Earlier::Forms, &others);
    let before = Value::maximum(&[int(0), sub(&way, &int(1))]).unwrap();
    assert_eq!(shown(asked, &before, &[]), None);
    // Where the way is known to be one, its end needs no other case.
    let asked = "param v > 0, p, a > p\nsolve r(n+1) = r(n)+v, r(0) = p find n with r(n) >= a\n";
    assert_eq!(shown(asked, &way, &[]), Some(Earlier::Forms));
    // Which of two pieces the index lies in is not known: within the last step it may be either.
    let close = rounds(&frac(99, 10));
    let asked = "param v > 0\nsolve r(n+1) = min(r(n)+v,10), r(0) = 0 find n with abs(r(n)-10) <= 1/10\n";
    only(asked, Earlier::Forms, &[rounds(&int(10)), rounds(&int(9)), sub(&close, &int(1))]);
    // Two that arrive in an order that is not known.
    let (first, second) = (rounds(&int(8)), div(&int(6), &var("w")).ceiling().unwrap());
    let asked =
        "param v > 0, w > 0\nsolve r(n+1) = (min(rx(n)+v,8),min(ry(n)+w,6)), r(0) = (0,0) find n with r(n) = (8,6)\n";
    only(asked, Earlier::Forms, &[first, second]);
}

/// An index that is a number, where the pieces end at symbols.
#[test]
fn a_number_is_the_first_only_where_the_symbols_say_so() {
    let asked = "param v > 0\nsolve r(n+1) = min(r(n)+v,10), r(0) = 0 find n with r(n) = 10\n";
    for at in [0, 1, 5, 600] {
        assert_eq!(shown(asked, &int(at), &[]), None, "{at}");
    }
    let by = |v: Value| vec![(Relation::Eq, var("v"), v)];
    assert_eq!(shown(asked, &int(5), &by(int(2))), Some(Earlier::OneByOne));
    assert_eq!(shown(asked, &int(600), &by(frac(1, 60))), Some(Earlier::Forms));
    assert_eq!(shown(asked, &int(600), &by(frac(1, 61))), None);
}

/// What has no value for some parameter is the first nowhere, also where what it needs cancels: `(v+n*v)/v`, `0*(1/p)`.
#[test]
fn what_may_have_no_value_is_not_shown() {
    for (asked, at) in [
        ("param v >= 0\nsolve r(n+1) = r(n)+v, r(0) = v find n with r(n)/v >= 3\n", 2),
        ("param v >= 0\nsolve r(n+1) = r(n)+v, r(0) = v find n with r(n)/v >= 700\n", 699),
        ("param v >= 0\nsolve r(n+1) = r(n)+v, r(0) = v find n with r(n)/v >= 1\n", 0),
        ("param p >= 0\nsolve t(n+1) = 1/t(n), t(0) = p find n with (n-1)*t(n)+n >= 1\n", 1),
        ("param v >= 0\nsolve r(n+1) = sqrt(r(n)-1), r(0) = v find n with n >= 1\n", 1),
    ] {
        assert_eq!(shown(asked, &int(at), &[]), None, "{asked}");
    }
    let asked = "param v > 0\nsolve r(n+1) = r(n)+v, r(0) = v find n with r(n)/v >= 700\n";
    only(asked, Earlier::Forms, &[int(698), int(700)]);
    let asked = "param v > 0\nsolve r(n+1) = r(n)+v, r(0) = v find n with r(n)/v >= 3\n";
    only(asked, Earlier::OneByOne, &[int(1), int(3)]);
}

/// What is a square in the index passes a bound behind the greater of its roots, which is rounded.
#[test]
fn a_first_index_that_is_a_rounded_root_is_shown_and_no_other() {
    let around = |at: &Value| vec![add(at, &int(1)), sub(at, &int(1)), int(0), int(1)];
    let (a, v) = (var("a"), var("v"));
    for (asked, root) in [
        ("param a > 0\nsolve e(n+1) = e(n)+a, e(0) = 0 find n with e(n)^2 >= 100\n", div(&int(10), &a)),
        ("param v > 0\nsolve r(n+1) = r(n)+(v,0), r(0) = (0,3) find n with norm(r(n)) >= 5\n", div(&int(4), &v)),
        ("param v > 0, w > 0\nsolve r(n+1) = r(n)+(v,w), r(0) = (0,0) find n with norm(r(n)) >= 10\n", {
            let squares = add(&v.mul(&v).unwrap(), &var("w").mul(&var("w")).unwrap());
            div(&int(10), &squares.sqrt().unwrap())
        }),
    ] {
        let at = root.ceiling().unwrap();
        only(asked, Earlier::Forms, &around(&at));
    }
    // From rest with an even acceleration: D = a*n*(n-1)/2.
    let asked =
        "param a > 0, D > 0\nsolve x(n+1) = x(n)+y(n), y(n+1) = y(n)+a, x(0) = 0, y(0) = 0 find n with x(n) >= D\n";
    let under = add(&a.mul(&a).unwrap(), &int(8).mul(&a).unwrap().mul(&var("D")).unwrap());
    let root = div(&under.sqrt().unwrap(), &int(2).mul(&a).unwrap());
    let at = add(&sub(&root, &frac(1, 2)).ceiling().unwrap(), &int(1));
    only(asked, Earlier::Forms, &around(&at));
}

/// A condition that is needed may not be left out.
#[test]
fn conditions_count() {
    let asked = "param v\nsolve r(n+1) = r(n)+v, r(0) = 0 find n with r(n) >= 10\n";
    let way = div(&int(10), &var("v")).ceiling().unwrap();
    let positive = vec![(Relation::Gtr, var("v"), int(0))];
    assert_eq!(shown(asked, &way, &positive), Some(Earlier::Forms));
    assert_eq!(shown(asked, &way, &[]), None);
    assert_eq!(shown(asked, &way, &[(Relation::Lss, var("v"), int(0))]), None);
}

proptest! {
    #![proptest_config(seeded(ProptestConfig { cases: 60, ..ProptestConfig::default() }))]
    /// Of all indices up to one just that is shown at which the comparison holds first, by the terms themselves.
    #[test]
    fn just_the_first_is_shown(
        factor in prop_oneof![Just("1"), Just("1/2"), Just("-1/2"), Just("-1"), Just("3/2"), Just("0")],
        step in -3i64..4, start in -5i64..6, goal in -12i64..13, relation in prop_oneof![Just("="), Just(">="), Just("<"), Just("!=")],
        bound in prop_oneof![Just(""), Just("min"), Just("max"), Just("abs")],
    ) {
        let next = format!("{factor}*r(n)+{step}");
        let next = match bound { "" => next, "abs" => format!("abs({next})"), cut => format!("{cut}({next},4)") };
        let asked = format!("solve r(n+1) = {next}, r(0) = {start} find n with r(n) {relation} {goal}\n");
        let (question, _) = question(&asked);
        let holds = |value: &Value| {
            let order = value.as_rational().unwrap().cmp(&int(goal).as_rational().unwrap());
            question.find.as_ref().unwrap().0.holds(order)
        };
        let terms = question.recurrence.iterate(25).unwrap().remove(0);
        let least = terms.iter().position(holds);
        for at in 0..25 {
            let told = shown(&asked, &int(at), &[]);
            prop_assert_eq!(told.is_some(), least == Some(usize::try_from(at).unwrap()), "{}: {}", asked, at);
        }
    }
}

/// What is asked has a value there under conditions that cancel in the forms; they are said, and are those of the proof.
#[test]
fn what_it_needs_is_said_with_the_index() {
    for (asked, condition) in [
        ("param v >= 0\nsolve r(n+1) = r(n)+v, r(0) = v find n with r(n)/v >= 3\n", "if v != 0"),
        ("param v >= 0\nsolve r(n+1) = r(n)+v, r(0) = v find n with r(n)/v >= 700\n", "if v != 0"),
        ("param p >= 0\nsolve t(n+1) = 1/t(n), t(0) = p find n with (n-1)*t(n)+n >= 1\n", "if p != 0"),
        ("param a\nsolve r(n+1) = r(n)+1, r(0) = a find n with r(n)*sqrt(a) >= (a+5)*sqrt(a)\n", "if a >= 0"),
    ] {
        let told = String::from_utf8_lossy(&ran(asked).stdout).into_owned();
        assert!(told.lines().any(|line| line.trim() == condition), "{told}");
        assert!(!told.contains("the search alone"), "{told}");
    }
    let told =
        String::from_utf8_lossy(&ran("param v > 0\nsolve r(n+1) = r(n)+v, r(0) = v find n with r(n)/v >= 3\n").stdout)
            .into_owned();
    assert!(!told.contains("if v"), "{told}");
}

/// Of these it is shown apart from the search that no earlier index does.
#[test]
fn signs_by_what_forms_are_made_of_prove_first_indices() {
    let script = include_str!("cases/recurrences/by_parts_of_forms.pars");
    let told = String::from_utf8_lossy(&ran(script).stdout).into_owned();
    assert!(!told.contains("the search alone"), "{told}");
    // Two solves of a line, two that are never, one by a late power.
    assert_eq!(told.matches("checked by the forms").count(), 5, "{told}");
    let strictly = "n = if abs(p) < 1/10 then 0 else floor(log(1/10/abs(p))/log(1/2))+1 is the first";
    assert!(told.contains(strictly), "{told}");
}

/// Of none of these does it rest on the search that no earlier index does, or none at all, and none is open.
#[test]
fn squares_in_symbols_are_proved_in_every_case() {
    for asked in [
        "param p, a\nsolve x(n+1) = x(n)+a, x(0) = p find n with x(n)^2 > 10\n",
        "param p, a\nsolve x(n+1) = x(n)+n+a, x(0) = p find n with x(n) <= 0\n",
        "param g\nsolve x(n+1) = mod(x(n)+1,6), x(0) = 0 find n with x(n) = g\n",
        "param p, v\nsolve r(n+1) = r(n)+(v,0), r(0) = (p,5) find n with norm(r(n)) >= 10\n",
        "param p, w > 0\nsolve r(n+1) = r(n)+(w,1), r(0) = (p,0) find n with norm(r(n)) <= 10\n",
        "param a, g > 0, w > 0\nsolve x(n+1) = x(n)+w, x(0) = 0, y(n+1) = y(n)+a, y(0) = g find n with x(n)*y(n) >= 20\n",
        "param w > 0\nsolve r(n+1) = r(n)+w*unit((3,4)-r(n)), r(0) = (0,0) find n with norm(r(n)-(3,4)) <= 1/2\n",
        "param w > 0, e > 0, g > 0\nsolve r(n+1) = r(n)+w*unit(g-r(n)), r(0) = 0 find n with abs(r(n)-g) <= e\n",
    ] {
        let told = String::from_utf8_lossy(&ran(asked).stdout).into_owned();
        assert!(!told.contains("the search alone") && !told.contains("not known"), "{told}");
        assert!(told.contains("checked"), "{told}");
    }
}

/// In units of measure in which one parameter is 1; nothing that is not the same in all units is shown so.
#[test]
fn a_first_index_is_shown_in_units_and_no_other() {
    let (v, w, g, d) = (var("v"), var("w"), var("g"), var("d"));
    let around = |at: &Value| vec![add(at, &int(1)), sub(at, &int(1)), int(0), int(1)];
    let throw = "y(n+1) = y(n)+u(n), u(n+1) = u(n)-g, y(0) = 0, u(0) = v find n with y(n) <= 0 and n > 0\n";
    let down = add(&div(&int(2).mul(&v).unwrap(), &g).ceiling().unwrap(), &int(1));
    only(&format!("param v > 0, g > 0\nsolve {throw}"), Earlier::Forms, &around(&down));
    // What is assumed of the unit and is no matter of units goes over nowhere, and is not needed.
    only(&format!("param v > 0, g > 0, g <= 3\nsolve {throw}"), Earlier::Forms, &around(&down));
    let away = div(&d, &add(&v.mul(&v).unwrap(), &w.mul(&w).unwrap()).sqrt().unwrap()).ceiling().unwrap();
    let line = "solve r(n+1) = r(n)+(v,w), r(0) = (0,0) find n with norm(r(n)) >= d\n";
    only(&format!("param v > 0, w > 0, d > 0\n{line}"), Earlier::Forms, &around(&away));
    // These are right for 1 alone.
    let straight = "param v > 0, d > 0\nsolve x(n+1) = x(n)+v, x(0) = 0 find n with x(n) >= d\n";
    let right = div(&d, &v).ceiling().unwrap();
    assert_eq!(shown(straight, &right, &[]), Some(Earlier::Forms));
    for at in [d.ceiling().unwrap(), d.mul(&v).unwrap().ceiling().unwrap(), div(&int(1), &v).ceiling().unwrap()] {
        assert_eq!(shown(straight, &at, &[]), None, "{at}");
    }
    let apart = "param v > 0, d > 0\nsolve x(n+1) = x(n)+1, x(0) = 0 find n with x(n) >= d*v\n";
    assert_eq!(shown(apart, &d.ceiling().unwrap(), &[]), None);
}

/// A ramp to a greatest speed, where the goal is met before that is reached, also just there.
#[test]
fn a_first_index_within_a_ramp_is_shown_and_no_other() {
    let (a, g) = (var("a"), var("g"));
    let ramp = "solve r(n+1) = r(n)+s(n), s(n+1) = min(s(n)+a,M), r(0) = 0, s(0) = 0 find n with r(n) >= g\n";
    let asked = format!("param a > 0, M > 0, g > 0, a*floor(-M/a)^2 >= 2*g+a*ceil(M/a)\n{ramp}");
    let under = add(&a.mul(&a).unwrap(), &int(8).mul(&a).unwrap().mul(&g).unwrap());
    let root = sub(&div(&under.sqrt().unwrap(), &int(2).mul(&a).unwrap()), &frac(1, 2));
    let at = add(&root.ceiling().unwrap(), &int(1));
    only(&asked, Earlier::Forms, &[add(&at, &int(1)), sub(&at, &int(1)), div(&var("M"), &a).ceiling().unwrap()]);
    // Where it may be met behind the ramp this is not the index.
    assert_eq!(shown(&format!("param a > 0, M > 0, g > 0\n{ramp}"), &at, &[]), None);
    for (a, m, g) in [(1, 3, 3), (1, 3, 2), (2, 7, 12), (1, 5, 10), (3, 4, 3), (1, 1, 1)] {
        let asked = format!("param a = {a}, M = {m}, g = {g}\n{ramp}");
        let (question, environment) = question(&asked);
        let solved = solve_until(question.recurrence.clone(), &environment.assumptions, &|| false).ok();
        let (relation, left, right) = question.find.expect("a goal");
        let known = &environment.assumptions;
        let found = reach(&question.recurrence, solved.as_ref(), (relation, &left, &right), known, &|| false);
        let (mut place, mut speed, mut count) = (0, 0, 0);
        while place < g {
            (place, speed, count) = (place + speed, (speed + a).min(m), count + 1);
        }
        assert_eq!(found, Reach::At(int(count), Vec::new()), "{asked}");
    }
}

/// Long terms are compared one by one where nothing else tells.
#[test]
fn a_late_index_of_long_terms_is_shown() {
    let asked = "solve h(n+1) = h(n)+1/(n+1), h(0) = 0 find n with h(n) >= 8\n";
    only(asked, Earlier::OneByOne, &[int(1673), int(1675)]);
}
