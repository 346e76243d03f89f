//! Forms and first indices that depend on what is not known of parameters: each case is right for numbers, and every number
//! falls into one.

mod common;

use std::collections::BTreeMap;

use common::{question, ran};
use pars::assumption::Assumptions;
use pars::closed_form::{Form, Recurrence, Sequence, Solved};
use pars::name::Name;
use pars::recurrence::{at_rest, solve_all, solve_in_cases};
use pars::value::{Relation, Value};

type Numbers = BTreeMap<Name, Value>;

fn put(value: &Value, numbers: &Numbers) -> Value {
    value.substitute(numbers).unwrap_or_else(|error| panic!("{value}: {error}"))
}

fn with_numbers(recurrence: &Recurrence, numbers: &Numbers) -> Recurrence {
    let sequence = |one: &Sequence| Sequence {
        name: one.name.clone(),
        start: one.start.iter().map(|value| put(value, numbers)).collect(),
        next: put(&one.next, numbers),
    };
    let sequences = recurrence.sequences.iter().map(sequence).collect();
    Recurrence { index: recurrence.index.clone(), from: recurrence.from, sequences }
}

/// The term of a form in pieces or in one value, where parameters are numbers.
fn term(solved: &Solved, form: &Form, at: i64, numbers: &Numbers) -> Value {
    let (index, nothing) = (&solved.recurrence().index, Assumptions::default());
    let here = |value: &Value| put(&put(value, numbers), &BTreeMap::from([(index.clone(), Value::integer(at))]));
    let form = match form {
        Form::Pieces(pieces) => {
            let holds = |until: &Value| {
                nothing.decide(Relation::Lss, &Value::integer(at), &put(until, numbers)).expect("numbers compare")
            };
            &pieces.iter().find(|piece| piece.until.as_ref().is_none_or(holds)).expect("a piece").form
        }
        Form::Value(early, _) if (at as usize) < early.len() => return put(&early[at as usize], numbers),
        Form::Value(_, value) => value,
        other => return here(&other.value(index).expect("a value")),
    };
    here(form)
}

fn holds((relation, left, right): &(Relation, Value, Value), numbers: &Numbers) -> bool {
    Assumptions::default().decide(*relation, &put(left, numbers), &put(right, numbers)).expect("numbers compare")
}

/// Some numbers for the parameters, which meet what is assumed of them.
fn some_numbers(names: &[&str], known: &Assumptions) -> Vec<Numbers> {
    let pool: Vec<Value> = ["1/3", "1", "3/2", "2", "5", "7", "29/4"]
        .iter()
        .map(|text| {
            let (above, below) = text.split_once('/').unwrap_or((text, "1"));
            Value::fraction(above.parse().unwrap(), below.parse().unwrap()).unwrap()
        })
        .flat_map(|value| [value.neg().unwrap(), value])
        .collect();
    let mut all = vec![Numbers::new()];
    for name in names {
        let longer = |numbers: &Numbers| {
            let with = |value: &Value| {
                let mut numbers = numbers.clone();
                numbers.insert(Name::new(name), value.clone());
                numbers
            };
            pool.iter().map(with).collect::<Vec<_>>()
        };
        all = all.iter().flat_map(longer).collect();
    }
    let allowed =
        |numbers: &Numbers| known.iter().all(|(relation, value)| holds(&(relation, value, Value::zero()), numbers));
    all.retain(allowed);
    assert!(all.len() > 10, "too few numbers meet the assumptions");
    all
}

fn each_case_is_right(text: &str, names: &[&str]) {
    let (question, environment) = question(text);
    each_case_is_right_of(text, &question.recurrence, names, &environment.assumptions);
}

fn each_case_is_right_of(text: &str, recurrence: &Recurrence, names: &[&str], known: &Assumptions) {
    let unknown = solve_all(recurrence.clone(), known).expect_err("a form without cases");
    let cases = solve_in_cases(recurrence, &unknown, known, &|| false);
    assert!(cases.len() > 1, "{text}: {unknown}");
    let mut seen = vec![0; cases.len()];
    for numbers in some_numbers(names, known) {
        let wanted = with_numbers(recurrence, &numbers).iterate(14).expect("terms");
        let own: Vec<usize> =
            (0..cases.len()).filter(|place| cases[*place].assumed.iter().all(|one| holds(one, &numbers))).collect();
        assert!(!own.is_empty(), "{text}: {numbers:?} is in no case");
        for place in own {
            let case = &cases[place];
            if !case.found.conditions().iter().all(|one| holds(one, &numbers)) {
                continue;
            }
            seen[place] += 1;
            for (form, wanted) in case.found.forms().iter().zip(&wanted) {
                for (at, wanted) in wanted.iter().enumerate() {
                    let found = term(&case.found, form, at as i64, &numbers);
                    let same = Assumptions::default().decide(Relation::Eq, &found, wanted) == Some(true);
                    let title = case.title();
                    assert!(same, "{text}: {found} and not {wanted} at {at} if {title} with {numbers:?}");
                }
            }
        }
    }
    assert!(seen.iter().filter(|times| **times > 0).count() > 1, "{text}: {seen:?}");
}

#[test]
fn every_number_has_the_form_of_its_case() {
    each_case_is_right("param g > 0, a > 0\nsolve r(n+1) = r(n)+clamp((g-r(n))/2,-a,a), r(0) = 0", &["g", "a"]);
    each_case_is_right(
        "param v > 0, d > 0, g > 0\nsolve r(n+1) = if abs(g-r(n)) > d then r(n)+v else r(n), r(0) = 0",
        &["v", "d", "g"],
    );
    each_case_is_right("param v > 0, g\nsolve r(n+1) = r(n)+clamp(g-r(n),-v,v), r(0) = 1", &["v", "g"]);
    each_case_is_right("param g > 0, b > 0\nsolve r(n+1) = min(r(n)+b, (r(n)+g)/2), r(0) = 1", &["g", "b"]);
}

/// Steps in proportion to what is left, cut off at a greatest one: the gain is no matter.
#[test]
fn steps_that_are_cut_off_have_forms_for_any_gain() {
    let cut_off = |gain: &str| format!("param g, v > 0\nsolve r(n+1) = r(n)+clamp({gain}*(g-r(n)),-v,v), r(0) = 1");
    for gain in ["1/4", "1/3", "3/4", "2/3", "4/5", "8/9"] {
        each_case_is_right(&cut_off(gain), &["g", "v"]);
    }
    each_case_is_right(&cut_off("k").replace("param", "param k > 0, k < 1,"), &["g", "v", "k"]);
    each_case_is_right("param p\nsolve e(n+1) = max(e(n)-1, 3/4*e(n)), e(0) = p", &["p"]);
    each_case_is_right("param p\nsolve r(n+1) = r(n)+clamp((10-r(n))/4,-1,1), r(0) = p", &["p"]);
}

/// It passes its goal and goes back and forth, or stays there if it comes to it.
#[test]
fn motion_without_a_stop_is_right_in_each_case() {
    each_case_is_right("param g, p, w > 0\nsolve r(n+1) = r(n)+w*unit(g-r(n)), r(0) = p", &["g", "p", "w"]);
    for (text, names) in [
        ("param a, w > 0\nsolve r(n+1) = r(n)+w*unit((2,3/2)-r(n)), r(0) = (a,0)", ["a", "w"]),
        ("param D > 0, w > 0\nsolve r(n+1) = r(n)+w*unit((3*D,4*D)-r(n)), r(0) = (0,0)", ["D", "w"]),
        ("param g, p\nsolve r(n+1) = r(n)+3/2*unit((g,p)-r(n)), r(0) = (2,0)", ["g", "p"]),
        ("param g, p\nsolve r(n+1) = r(n)+min(3,norm((g,g)-r(n)))*unit((g,g)-r(n)), r(0) = (p,p)", ["g", "p"]),
    ] {
        let (question, environment) = question(text);
        let (recurrence, _) = at_rest(&question.recurrence).expect("at the goal there is no direction");
        each_case_is_right_of(text, &recurrence, &names, &environment.assumptions);
    }
}

/// A speed and the time of a step stand nowhere but in their product.
#[test]
fn a_product_of_parameters_is_solved_as_one() {
    let text = "param v > 0, t > 0\nsolve r(n+1) = if norm((1,2)-r(n)) > v*t then r(n)+v*t*unit((1,2)-r(n)) else (1,2), \
                r(0) = (0,0)";
    let (question, environment) = question(text);
    let solved = solve_all(question.recurrence.clone(), &environment.assumptions).expect("a form");
    assert_eq!(solved.recurrence(), &question.recurrence);
    let speed = Value::variable(&Name::new("v")).mul(&Value::variable(&Name::new("t"))).unwrap();
    let root = Value::integer(5).sqrt().unwrap();
    let Form::Pieces(pieces) = &solved.forms()[0] else { panic!("{:?}", solved.forms()) };
    assert_eq!(pieces[0].until, Some(root.div(&speed).unwrap().ceiling().unwrap()));
}

#[test]
fn an_instance_needs_what_was_assumed() {
    let (question, environment) = question("param w > 0\nsolve r(n+1) = max(r(n)-w,0), r(0) = 3");
    let solved = solve_all(question.recurrence, &environment.assumptions).expect("a form");
    let (w, v, t) = (Name::new("w"), Value::variable(&Name::new("v")), Value::variable(&Name::new("t")));
    let product = v.mul(&t).unwrap();
    let mut known = Assumptions::default();
    assert!(solved.instance(&w, &product, &known).is_err(), "nothing is known of v*t");
    known.assume(Relation::Gtr, &v, &Value::zero());
    known.assume(Relation::Gtr, &t, &Value::zero());
    assert!(solved.instance(&w, &product, &known).is_ok());
    // A division has no meaning everywhere, and the index is bound.
    assert!(solved.instance(&w, &v.div(&t).unwrap(), &known).is_err());
    let mut natural = known.clone();
    natural.assume_natural(&Name::new("n"));
    natural.assume(Relation::Gtr, &Value::variable(&Name::new("n")), &Value::zero());
    assert!(solved.instance(&w, &Value::variable(&Name::new("n")), &natural).is_err());
}

/// Where the answer is told in cases, the values for which the form has none are told as they are without cases.
#[test]
fn what_the_form_leaves_out_is_told_beside_the_cases() {
    let ran = |script: &str| String::from_utf8_lossy(&common::ran(script).stdout).into_owned();
    let loan = "param i >= 0, P > 0, L > 0\nsolve b(n+1) = (1+i)*b(n)-P, b(0) = L find n with b(n) <= 0\n";
    let text = ran(loan);
    assert!(text.contains("if L-P/i > 0:") && text.matches("where i = 0:").count() == 1, "{text}");
    assert!(text.contains("n = ceil(L/P) is the first with b(n) <= 0"), "{text}");
    let turns = "param m : natural, p\n\
        solve u(n+1) = if n < m then u(n)+1 else u(n)-1, u(0) = p find n with u(n) <= 0\n";
    let text = ran(turns);
    assert!(text.matches("where m = 0:").count() == 1 && text.contains("n = max(ceil(p),0) is the first"), "{text}");
}

/// A condition of a first index is one without which there is none, where that is said; and the goal may be the start.
#[test]
fn where_a_condition_fails_there_is_never_such_an_index() {
    let ran = |script: &str| String::from_utf8_lossy(&common::ran(script).stdout).into_owned();
    let text = ran("param k > 0\nsolve r(n+1) = r(n)+k, r(0) = 0 find n with r(n) = 12\n");
    assert!(text.contains("if floor(12/k) = 12/k\n    else never\n    checked by the forms"), "{text}");
    let line = "param gx, gy, v > 0\nsolve r(n+1) = r(n)+(if norm((gx,gy)-r(n)) > v then v*unit((gx,gy)-r(n)) else (gx,gy)-r(n)), \
                r(0) = (0,0) find n with r(n) = (gx,gy)\n";
    let text = ran(line);
    assert!(
        text.contains("where gx = 0, gy = 0:") && text.contains("n = 0 is the first with r(n) = (gx,gy)"),
        "{text}"
    );
}

/// Where one time is right in each order of two delays, it is told behind them.
#[test]
fn a_period_in_each_order_of_delays_is_the_longer_of_them() {
    let script = "param a > 0, b > 0\nproc P = Delay_a ; Out_{x,1} ; P\nproc Q = In_x<u> ; Delay_b ; Q\nsystem S = P | Q\nperiod S\n";
    let text = String::from_utf8_lossy(&common::ran(script).stdout).into_owned();
    assert!(text.contains("in every order, lasting: max(b,a)"), "{text}");
    let script = script.replace("Delay_b ; Q", "Delay_b ; Delay_1 ; Q");
    let text = String::from_utf8_lossy(&common::ran(&script).stdout).into_owned();
    assert!(text.contains("in every order, lasting: max(b+1,a)"), "{text}");
}

/// Where one condition of an index fails the answer holds whether or not the others do.
#[test]
fn where_one_of_several_conditions_fails_the_others_may_fail_too() {
    let asked = "param a\nsolve r(n+1) = if n < 3 then r(n)+1 else r(n)-1, r(0) = 0 find n with r(n) = a\n";
    let told = String::from_utf8_lossy(&ran(asked).stdout).into_owned();
    let lines: Vec<&str> = told.lines().map(str::trim).collect();
    let place = lines.iter().position(|line| *line == "if a < 0:").unwrap_or_else(|| panic!("{told}"));
    // From the fourth term on it falls through whole numbers alone.
    assert_eq!(
        lines[place + 1..place + 4],
        ["n = 6-a is the first with r(n) = a", "if floor(-a)+6 = 6-a", "else never"],
        "{told}"
    );
}

fn printed(asked: &str) -> String {
    String::from_utf8_lossy(&ran(asked).stdout).into_owned()
}

#[test]
fn along_a_line_every_norm_is_told_of_any_goal_from_anywhere() {
    let step = "min(v,norm((gx,gy)-r(n)))*unit((gx,gy)-r(n))";
    for (start, near) in [("(0,0)", "max(abs(rx(n)-gx),abs(ry(n)-gy))"), ("(px,py)", "abs(rx(n)-gx)+abs(ry(n)-gy)")] {
        let asked = format!(
            "param v > 0, gx, gy, px, py, e > 0\nsolve r(n+1) = r(n)+{step}, r(0) = {start} find n with {near} <= e\n"
        );
        let text = printed(&asked);
        assert!(text.contains("    n = ceil(") && !text.contains("not known"), "{text}");
    }
    // Braking stops before, or never comes so far.
    let brakes = printed(
        "param s > 0, a > 0\nsolve x(n+1) = x(n)+u(n), u(n+1) = max(u(n)-a,0), x(0) = 0, u(0) = s find n with x(n) >= 10\n",
    );
    assert_eq!((brakes.matches("never x(n) >= 10").count(), brakes.matches("not known").count()), (2, 0), "{brakes}");
}
