//! Recurrences of every kind against plain iteration and against terms that another program computed.

mod common;

use std::collections::BTreeMap;

use common::question;
use num_rational::BigRational;
use pars::assumption::Assumptions;
use pars::closed_form::{Form, Layer, Nested, Piece, Recurrence, Sequence, Solved, layer};
use pars::lower::Environment;
use pars::name::Name;
use pars::parser::parse_value;
use pars::recurrence::{Reach, Special, reach, solve_all, special_cases};
use pars::value::{Relation, Value};
use proptest::prelude::*;

fn solved(text: &str) -> Solved {
    let (question, environment) = question(text);
    solve_all(question.recurrence, &environment.assumptions)
        .unwrap_or_else(|reason| panic!("{text}: {}", reason.reason))
}

fn value(text: &str) -> Value {
    let written = parse_value(text).unwrap_or_else(|error| panic!("{text}: {error:?}"));
    Environment::new().value(&written).unwrap_or_else(|error| panic!("{text}: {error:?}"))
}

fn int(number: i64) -> Value {
    Value::integer(number)
}

fn n() -> Name {
    Name::new("n")
}

#[test]
fn sixty_recurrences_have_their_terms() {
    assert_eq!(have_their_terms(include_str!("recurrences/sixty.txt")), 60);
}

#[test]
fn more_recurrences_have_their_terms() {
    assert!(have_their_terms(include_str!("recurrences/more.txt")) > 20);
}

/// How many stanzas there are, each of which is right.
fn have_their_terms(text: &str) -> usize {
    let mut kinds: BTreeMap<&str, usize> = BTreeMap::new();
    for stanza in text.split("\n\n").filter(|stanza| stanza.contains("solve ")) {
        let line = |word: &str| stanza.lines().find_map(|line| line.strip_prefix(word));
        let source = stanza.lines().filter(|line| line.starts_with("param ") || line.starts_with("solve "));
        let source = source.collect::<Vec<_>>().join("\n");
        let solved = solved(&source);
        let mut sequences = 0;
        for (name, terms) in stanza.lines().filter_map(|line| line.strip_prefix("terms ")?.split_once(": ")) {
            let terms: Vec<Value> = terms.split(", ").map(value).collect();
            assert_eq!(terms.len(), 20);
            for (place, wanted) in terms.iter().enumerate() {
                let at = solved.recurrence().from + place as i64;
                let found = solved.at(&Name::new(name), at).unwrap_or_else(|error| panic!("{source}: {error}"));
                let equal = solved.known().decide(Relation::Eq, &found, wanted);
                assert_eq!(equal, Some(true), "{source}: {name}({at}) is {wanted}, not {found}");
            }
            sequences += 1;
        }
        assert_eq!(sequences, solved.recurrence().sequences.len(), "{source}");
        if let Some((goal, wanted)) = line("find ").and_then(|find| find.split_once(" -> ")) {
            arrives(&format!("{source} find n with {goal}"), wanted);
        }
        *kinds.entry(line("kind ").expect("a kind")).or_insert(0) += 1;
    }
    kinds.values().sum()
}

#[test]
fn arrivals_are_found() {
    let mut count = 0;
    for stanza in include_str!("recurrences/arrivals.txt").split("\n\n").filter(|stanza| stanza.contains("solve ")) {
        let line = |word: &str| stanza.lines().find_map(|line| line.strip_prefix(word)).expect("a line");
        let (goal, wanted) = line("find ").split_once(" -> ").expect("an answer");
        arrives(&format!("solve {} find n with {goal}", line("solve ")), wanted);
        count += 1;
    }
    assert_eq!(count, 14);
}

/// Forms in symbols, with numbers in place of the symbols, against plain iteration with these numbers.
#[test]
fn symbolic_forms_agree_with_numbers() {
    let texts = [
        "solve u(n+2) = (a+b)*u(n+1) - a*b*u(n), u(0) = 1, u(1) = b",
        "solve u(n+3) = 3*a*u(n+2) - 3*a^2*u(n+1) + a^3*u(n), u(0) = 1, u(1) = 0, u(2) = b",
        "solve u(n+2) = a*u(n+1) + b*u(n) + n*a^n, u(0) = 1, u(1) = 0",
        "solve u(n+2) = a*b/(n+1)*u(n), u(0) = a, u(1) = 2",
        "solve x(n+1) = a*x(n) + y(n), y(n+1) = b*x(n) + a*y(n) + n, x(0) = 1, y(0) = 0",
        "solve x(n+1) = a*x(n) + y(n), y(n+1) = a*y(n) + z(n), z(n+1) = b*z(n), x(0) = 1, y(0) = 0, z(0) = 1",
    ];
    for text in texts {
        let solved = solved(&format!("param a, b\n{text}"));
        for numbers in [[value("3"), value("7")], [value("1/2"), value("5")], [value("-1"), value("4/3")]] {
            let put_in = |value: &Value| {
                let value =
                    value.with(&Name::new("a"), &numbers[0]).and_then(|value| value.with(&Name::new("b"), &numbers[1]));
                value.unwrap_or_else(|error| panic!("{text}: {error}"))
            };
            let none = Assumptions::default();
            for (relation, left, right) in solved.conditions() {
                assert_eq!(none.decide(*relation, &put_in(left), &put_in(right)), Some(true), "{text}");
            }
            let mut recurrence = solved.recurrence().clone();
            for sequence in &mut recurrence.sequences {
                sequence.next = put_in(&sequence.next);
                sequence.start = sequence.start.iter().map(put_in).collect();
            }
            for (sequence, terms) in recurrence.sequences.iter().zip(recurrence.iterate(9).expect("terms")) {
                for (at, term) in (0..).zip(&terms) {
                    let found = put_in(&solved.at(&sequence.name, at).expect("a term"));
                    assert_eq!(none.decide(Relation::Eq, &found, term), Some(true), "{text}: {found}, not {term}");
                }
            }
        }
    }
}

/// A form with a root holds only where what is under it is not negative: the check itself adds that.
#[test]
fn a_root_brings_its_condition() {
    let (question, environment) = question("param a\nsolve u(n+2) = a*u(n), u(0) = 1, u(1) = 0");
    let (recurrence, known) = (question.recurrence, environment.assumptions.clone());
    let text = |text: &str| environment.value(&parse_value(text).expect("a value")).expect("a value");
    let form = text("(sqrt(a)^n + (-sqrt(a))^n)/2");
    let with = |form: &Value| {
        Solved::check(recurrence.clone(), vec![Form::Value(Vec::new(), form.clone())], Vec::new(), &known)
    };
    let found = with(&form).expect("it holds where a is not negative");
    assert_eq!(found.conditions(), [(Relation::Gte, text("a"), Value::zero())]);
    // Of a negative number there is no root.
    let mut below = known.clone();
    below.assume(Relation::Lss, &text("a"), &Value::zero());
    assert!(Solved::check(recurrence.clone(), vec![Form::Value(Vec::new(), form)], Vec::new(), &below).is_err());
    assert!(with(&text("(sqrt(a)^n + (-sqrt(a))^n)/3")).is_err());
}

/// Turns with products are checked each: forged ones are refused.
#[test]
fn forged_turns_are_refused() {
    let (question, environment) = question("solve u(n+2) = (n+1)*u(n), u(0) = 1, u(1) = 1");
    let solved = solve_all(question.recurrence.clone(), &environment.assumptions).expect("a form");
    let [Form::Turns(forms)] = solved.forms() else { panic!("{:?}", solved.forms()) };
    let check = |forms: Vec<Form>| {
        Solved::check(question.recurrence.clone(), vec![Form::Turns(forms)], Vec::new(), &environment.assumptions)
    };
    assert!(check(forms.clone()).is_ok());
    assert!(check(vec![forms[1].clone(), forms[0].clone()]).is_err());
    assert!(check(vec![forms[0].clone(), Form::Value(Vec::new(), Value::one())]).is_err());
    assert!(check(vec![forms[0].clone()]).is_err());
}

#[test]
fn forms_that_go_round_are_checked() {
    let text = "param v > 0, L > 0\nsolve x(n+1) = if x(n) >= L then 0 else x(n)+v, x(0) = 0";
    let (question, environment) = question(text);
    let check = |form: &str| {
        let forms = vec![Form::Pieces(vec![Piece { from: int(0), until: None, form: value(form) }])];
        Solved::check(question.recurrence.clone(), forms, Vec::new(), &environment.assumptions).is_ok()
    };
    let wrong = ["v*mod(n,ceil(L/v))", "v*mod(n,ceil(L/v)+2)", "v*mod(n+1,ceil(L/v)+1)", "v*mod(n,L/v+1)", "v*n"];
    assert!(check("v*mod(n,ceil(L/v)+1)") && !wrong.into_iter().any(check));
}

/// The first index comes as wanted: `n = 8`, or `never`.
fn arrives(text: &str, wanted: &str) {
    let (question, environment) = question(text);
    let (relation, left, right) = question.find.expect("what to find");
    let solved = solve_all(question.recurrence.clone(), &environment.assumptions).ok();
    let found =
        reach(&question.recurrence, solved.as_ref(), (relation, &left, &right), &environment.assumptions, &|| false);
    match (&found, wanted.strip_prefix("n = ")) {
        (Reach::At(at, conditions), Some(number)) => {
            assert_eq!((at, conditions.is_empty()), (&value(number), true), "{text}");
        }
        (Reach::Never(_), None) => assert_eq!(wanted, "never", "{text}"),
        _ => panic!("{text}: {found:?}, not {wanted}"),
    }
}

#[test]
fn first_indices_of_systems() {
    let contracting = "solve x(n+1) = y(n), y(n+1) = z(n), z(n+1) = x(n)/3 + y(n)/3 + z(n)/4, \
                       x(0) = 3, y(0) = 5, z(0) = 1 find n with";
    arrives(&format!("{contracting} x(n) >= 6"), "never");
    arrives(&format!("{contracting} x(n) < 1/100"), "n = 137");
    arrives(&format!("{contracting} x(n) = 0"), "never");
    let fibonacci = "solve f(n+2) = f(n+1) + f(n), f(0) = 0, f(1) = 1 find n with";
    arrives(&format!("{fibonacci} f(n) = 6765"), "n = 20");
    arrives(&format!("{fibonacci} f(n) = 6766"), "never");
    arrives(&format!("{fibonacci} f(n) < 0"), "never");
    let spiral = "solve x(n+1) = x(n) - 4*y(n), y(n+1) = 4*x(n) + y(n), x(0) = 3, y(0) = 5 find n with";
    arrives(&format!("{spiral} abs(x(n)) + abs(y(n)) > 1000000"), "n = 9");
    let tribonacci = "solve f(n+3) = f(n+2) + f(n+1) + f(n), f(0) = 0, f(1) = 0, f(2) = 1 find n with";
    arrives(&format!("{tribonacci} f(n) = 504"), "n = 13");
    arrives(&format!("{tribonacci} f(n) = 505"), "never");
    let late = "solve h(n+1) = 2*h(n), h(3) = 1 find n with";
    arrives(&format!("{late} h(n) = 4"), "n = 5");
    arrives(&format!("{late} h(n) = 1/2"), "never");
}

#[test]
fn what_has_no_form_is_said_to_have_none() {
    for text in [
        "solve z(n+1) = z(n)^2 - 1/4, z(0) = 0",
        "solve z(n+1) = 2*z(n)*(1 - z(n)), z(0) = 1/3",
        "solve h(n+1) = h(n) + 1/((n-3)*(n-2)), h(0) = 0",
        "solve h(n+1) = n*h(n)/(n-5) + 1, h(3) = 1",
        "solve h(n+2) = (n+1)*h(n+1) + h(n), h(0) = 0, h(1) = 1",
        "param a solve h(n+1) = (n+a)*h(n) + 1, h(0) = 0",
        "solve x(n+1) = x(n)*y(n), y(n+1) = x(n) + y(n), x(0) = 1, y(0) = 1",
        "param a, b, c solve x(n+1) = a*y(n), y(n+1) = b*x(n) + z(n), z(n+1) = c*x(n), x(0) = 1, y(0) = 1, z(0) = 0",
    ] {
        let (question, environment) = question(text);
        let found = solve_all(question.recurrence, &environment.assumptions);
        assert!(found.is_err(), "{text}: {found:?}");
    }
}

fn sequence(name: &str, start: &[i64], next: &str) -> Sequence {
    let (zero, one) = (Name::new("f0"), Name::new("f1"));
    let index = n();
    let term = |offset| Value::variable(&pars::closed_form::term(&Name::new(name), &index, offset));
    let next = value(next).with(&zero, &term(0)).unwrap().with(&one, &term(1)).unwrap();
    Sequence { name: Name::new(name), start: start.iter().map(|number| int(*number)).collect(), next }
}

fn accepted(start: &[i64], next: &str, form: Form) -> bool {
    let recurrence = Recurrence { index: n(), from: 0, sequences: vec![sequence("f", start, next)] };
    Solved::check(recurrence, vec![form], Vec::new(), &Assumptions::default()).is_ok()
}

#[test]
fn wrong_forms_are_turned_away() {
    let plain = |text: &str| Form::Value(Vec::new(), value(text));
    assert!(accepted(&[1], "2*f0+3", plain("4*2^n-3")));
    assert!(!accepted(&[1], "2*f0+3", plain("5*2^n-3")), "the step holds, the start does not");
    assert!(!accepted(&[1], "2*f0+3", plain("1+4*n")), "the start holds, the step does not");
    assert!(!accepted(&[0, 1], "f1+f0", plain("n")), "both first values hold, and one step");
    assert!(!accepted(&[5], "f0", Form::Value(vec![int(5)], int(6))), "a jump after the first terms");
    assert!(accepted(&[5], "0", Form::Value(vec![int(5)], int(0))));
    let ratio = value("n+1");
    let product = Value::variable(&pars::closed_form::product());
    assert!(accepted(&[3], "(n+1)*f0", Form::Product(ratio.clone(), product.mul(&int(3)).unwrap())));
    assert!(!accepted(&[3], "(n+2)*f0", Form::Product(ratio.clone(), product.mul(&int(3)).unwrap())));
    assert!(!accepted(&[1], "n*f0", Form::Product(value("1/n"), int(1).div(&product).unwrap())), "divides by 0");
    assert!(!accepted(&[1], "f0/(n-3)", Form::Product(value("1/(n-3)"), product.clone())), "not defined at 3");
    let own = Value::variable(&pars::closed_form::term(&Name::new("f"), &n(), 0));
    assert!(!accepted(&[1], "f0", Form::Value(vec![int(1)], own)), "the form is the sequence itself");
    let turns = |one: &str, other: &str| Form::Turns(vec![plain(one), plain(other)]);
    assert!(accepted(&[1], "3-f0", turns("1", "2")));
    assert!(!accepted(&[1], "3-f0", turns("1", "1")));
    assert!(!accepted(&[1], "f0+1", turns("1+n", "2+n")), "each turn counts rounds");
    assert!(accepted(&[1], "f0+1", turns("1+2*n", "2+2*n")));
    let piece =
        |from: i64, until: Option<i64>, form: &str| Piece { from: int(from), until: until.map(int), form: value(form) };
    let pieces = |all: &[Piece]| Form::Pieces(all.to_vec());
    let down = "max(f0-3,1)";
    assert!(accepted(&[12], down, pieces(&[piece(0, Some(4), "12-3*n"), piece(4, None, "1")])));
    assert!(!accepted(&[12], down, pieces(&[piece(0, Some(5), "12-3*n"), piece(5, None, "1")])));
    assert!(!accepted(&[12], down, pieces(&[piece(0, Some(3), "12-3*n"), piece(3, None, "1")])));
    assert!(!accepted(&[12], down, pieces(&[piece(0, None, "12-3*n")])));
    assert!(!accepted(&[12], down, pieces(&[piece(0, Some(4), "12-3*n"), piece(5, None, "1")])), "a gap");
}

#[test]
fn what_conditions_leave_out_is_solved() {
    for (text, titles) in [
        ("param a, b solve u(n+1) = a*u(n) + b^n, u(0) = 1", vec!["a = b", "a = b, b = 0"]),
        ("param a, b, p solve u(n+1) = a*u(n) + b, u(0) = p", vec!["a = 1"]),
        ("param k, g, p solve u(n+1) = u(n) + k*(g-u(n)), u(0) = p", vec![]),
        ("param a, b solve u(n+2) = (a+b)*u(n+1) - a*b*u(n), u(0) = 0, u(1) = 1", vec!["a = b", "a = b, b = 0"]),
        ("param p, q solve u(n+2) = p*u(n+1) + q*u(n), u(0) = 2, u(1) = p", vec!["q = -1/4*p^2"]),
        ("param a > 1 solve u(n+1) = a*u(n) + 1, u(0) = 1", vec![]),
        ("param a > 0 solve u(n+1) = a^2*u(n) + a^n, u(0) = 0", vec!["a = 1"]),
        ("param a > 0, b > 0 solve u(n+2) = u(n)*a*b + 1, u(0) = 0, u(1) = 1", vec!["a = 1/b"]),
    ] {
        let (question, environment) = question(text);
        let solved = solve_all(question.recurrence, &environment.assumptions).expect("a form");
        let special = special_cases(&solved, &environment.assumptions, &|| false);
        assert_eq!(special.iter().map(Special::title).collect::<Vec<_>>(), titles, "{text}");
        for one in special {
            let recurrence = one.solved.recurrence();
            for (sequence, terms) in recurrence.sequences.iter().zip(recurrence.iterate(20).expect("terms")) {
                for (at, wanted) in terms.iter().enumerate() {
                    let found = one.solved.at(&sequence.name, at as i64).expect("a term");
                    let equal = one.solved.known().decide(Relation::Eq, &found, wanted);
                    assert_eq!(equal, Some(true), "{text}, {}: {wanted} at {at}, not {found}", one.title());
                }
            }
        }
    }
}

#[test]
fn wrong_sums_are_turned_away() {
    let at = |place: usize| Value::variable(&layer(place));
    let nested = |early: &[i64], layers: Vec<Layer>, value: Value| {
        Form::Nested(Nested { early: early.iter().map(|number| int(*number)).collect(), layers, value })
    };
    let harmonic = || vec![Layer::Sum(value("1/(n+1)"))];
    assert!(accepted(&[0], "f0+1/(n+1)", nested(&[], harmonic(), at(0))));
    assert!(!accepted(&[1], "f0+1/(n+1)", nested(&[], harmonic(), at(0))), "the step holds, the start does not");
    assert!(!accepted(&[0], "f0+1/(n+2)", nested(&[], harmonic(), at(0))), "the start holds, the step does not");
    assert!(!accepted(&[0, 1], "f1+1/(n+2)^2", nested(&[], harmonic(), at(0))), "both first values hold, and one step");
    assert!(accepted(&[7], "1/n", nested(&[7], Vec::new(), value("1/(n-1)"))).eq(&false), "not defined at 0");
    // What is divided by is a product that is never 0: not one with a factor 0, nor a sum, nor a later layer.
    let over = |ratio: &str| vec![Layer::Product(value(ratio)), Layer::Sum(int(1).div(&at(0)).unwrap())];
    let whole = at(0).mul(&at(1)).unwrap();
    let next = |layers: Vec<Layer>| nested(&[], layers, whole.clone());
    assert!(accepted(&[0], "(n+1)*f0+n+1", next(over("n+1"))));
    assert!(!accepted(&[0], "(n-3)*f0+n-3", next(over("n-3"))), "a factor is 0 at 3");
    // 1 over this is 1 wherever it is defined.
    let gone = "(if n = 3 then 0 else 1)";
    assert!(!accepted(&[0], &format!("{gone}*f0+{gone}"), next(over(gone))), "a factor is 0 at 3");
    assert!(
        !accepted(
            &[0],
            "f0+1/(n-3)-1/(n-3)",
            nested(&[], vec![Layer::Sum(value("1/(n-3)")), Layer::Sum(at(0).div(&at(0)).unwrap())], value("0"))
        ),
        "not defined at 3"
    );
    assert!(
        !accepted(
            &[0],
            "f0",
            nested(&[], vec![Layer::Sum(int(1)), Layer::Sum(int(1).div(&at(0)).unwrap())], value("0"))
        ),
        "divides by a sum that is 0"
    );
    assert!(!accepted(&[0], "f0+n", nested(&[], vec![Layer::Sum(at(1)), Layer::Sum(int(1))], at(0))), "a later layer");
    assert!(!accepted(&[0], "f0+n", nested(&[], vec![Layer::Sum(at(0))], at(0))), "a layer in itself");
}

#[test]
fn conditions_are_free_of_the_index() {
    let recurrence = Recurrence { index: n(), from: 0, sequences: vec![sequence("f", &[1], "2*f0")] };
    let forged = vec![(Relation::Eq, value("n"), int(0))];
    let form = Form::Value(Vec::new(), int(1));
    assert!(Solved::check(recurrence.clone(), vec![form], forged, &Assumptions::default()).is_err());
    let late = Form::Pieces(vec![Piece { from: int(0), until: None, form: value("2^n") }]);
    assert!(Solved::check(recurrence.clone(), vec![late], Vec::new(), &Assumptions::default()).is_ok());
    let own = Form::Pieces(vec![
        Piece { from: int(0), until: Some(value("n+1")), form: value("2^n") },
        Piece { from: value("n+1"), until: None, form: int(7) },
    ]);
    assert!(Solved::check(recurrence, vec![own], Vec::new(), &Assumptions::default()).is_err());
}

#[test]
fn divisors_become_conditions() {
    let (question, environment) = question("param a, b solve r(n+1) = a*r(n) + b, r(0) = 0");
    let solved = solve_all(question.recurrence, &environment.assumptions).unwrap();
    assert_eq!(solved.conditions().len(), 1, "{:?}", solved.conditions());
    let (_, other) = self::question("param a > 1, b solve r(n+1) = a*r(n) + b, r(0) = 0");
    let again = solve_all(solved.recurrence().clone(), &other.assumptions).unwrap();
    assert!(again.conditions().is_empty());
}

#[test]
fn a_parameter_of_the_same_name_is_not_the_index() {
    let text = "param n > 5, n : natural, a solve r(n+1) = max(r(n) - 3, 1), r(0) = 12 find n with r(n) = 12";
    arrives(text, "n = 0");
    let (question, environment) = question(text);
    let solved = solve_all(question.recurrence, &environment.assumptions).unwrap();
    assert_eq!(solved.at(&Name::new("r"), 2).unwrap(), int(6));
}

/// A system with a rational matrix, inputs and starting values.
fn system(matrix: &[Vec<BigRational>], inputs: &[(i64, i64)], start: &[i64]) -> Recurrence {
    let names: Vec<Name> = (0..matrix.len()).map(|place| Name::new(&format!("x{place}"))).collect();
    let index = n();
    let sequences = matrix.iter().enumerate().map(|(place, row)| {
        let mut next = Value::zero();
        for (number, name) in row.iter().zip(&names) {
            let term = Value::variable(&pars::closed_form::term(name, &index, 0));
            next = next.add(&term.mul(&Value::rational(number.clone())).unwrap()).unwrap();
        }
        let (factor, base) = inputs[place];
        let input = int(base).power(&Value::variable(&index)).unwrap().mul(&int(factor)).unwrap();
        let input = if base == 0 { int(factor).mul(&Value::variable(&index)).unwrap() } else { input };
        let next = next.add(&input).unwrap();
        Sequence { name: names[place].clone(), start: vec![int(start[place])], next }
    });
    Recurrence { index: index.clone(), from: 0, sequences: sequences.collect() }
}

fn entry() -> impl Strategy<Value = BigRational> {
    let number = (-3i64..=3, 1i64..=3).prop_map(|(top, bottom)| BigRational::new(top.into(), bottom.into()));
    prop_oneof![2 => Just(BigRational::from_integer(0.into())), 3 => number]
}

/// A matrix, an input for each row, and the starting values.
type Drawn = (Vec<Vec<BigRational>>, Vec<(i64, i64)>, Vec<i64>);

fn systems() -> impl Strategy<Value = Drawn> {
    (1usize..=6).prop_flat_map(|size| {
        let matrix = prop::collection::vec(prop::collection::vec(entry(), size), size);
        let input = prop_oneof![3 => Just((0i64, 1i64)), 1 => (-2i64..=2, -1i64..=2)];
        (matrix, prop::collection::vec(input, size), prop::collection::vec(-5i64..=5, size))
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 80, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_systems_agree_with_iteration((matrix, inputs, start) in systems()) {
        let recurrence = system(&matrix, &inputs, &start);
        let terms = recurrence.iterate(25).unwrap();
        let solved = solve_all(recurrence.clone(), &Assumptions::default());
        prop_assert!(solved.is_ok(), "{:?}", solved);
        let solved = solved.unwrap();
        for (sequence, terms) in recurrence.sequences.iter().zip(&terms) {
            for (place, wanted) in terms.iter().enumerate() {
                prop_assert_eq!(&solved.at(&sequence.name, place as i64).unwrap(), wanted);
            }
        }
    }

    #[test]
    fn random_equations_of_high_order(coefficients in prop::collection::vec(-3i64..=3, 1..=6), start in prop::collection::vec(-4i64..=4, 6)) {
        let order = coefficients.len();
        let (name, index) = (Name::new("f"), n());
        let mut next = Value::zero();
        for (offset, number) in coefficients.iter().enumerate() {
            let term = Value::variable(&pars::closed_form::term(&name, &index, offset));
            next = next.add(&term.mul(&int(*number)).unwrap()).unwrap();
        }
        let start = start[..order].iter().map(|number| int(*number)).collect();
        let recurrence = Recurrence { index, from: 2, sequences: vec![Sequence { name: name.clone(), start, next }] };
        let terms = recurrence.iterate(30).unwrap();
        let solved = solve_all(recurrence, &Assumptions::default()).unwrap();
        for (place, wanted) in terms[0].iter().enumerate() {
            prop_assert_eq!(&solved.at(&name, place as i64 + 2).unwrap(), wanted);
        }
    }
}

#[test]
fn a_power_before_the_index_0_needs_a_base_that_is_not_0() {
    let nonzero = |text: &str| {
        let relation = |(relation, ..): &(Relation, Value, Value)| *relation == Relation::Neq;
        solved(text).conditions().iter().filter(|one| relation(one)).count()
    };
    assert_eq!(nonzero("param c\nsolve u(n+1) = c*u(n), u(0) = 2"), 0);
    assert_eq!(nonzero("param c\nsolve u(n+1) = c*u(n), u(-1) = 2"), 1);
    assert_eq!(nonzero("param c, c > 0\nsolve u(n+1) = c*u(n), u(-1) = 2"), 0);
    assert_eq!(nonzero("param c\nsolve x(n+1) = 2*x(n)+y(n), y(n+1) = c*y(n), x(-1) = 1, y(-1) = 1"), 2);
}

#[test]
fn wrong_pieces_of_systems_are_turned_away() {
    let [x, y] = ["x", "y"].map(Name::new);
    let terms = |text: &str| {
        let of = |value: Value, name: &Name| {
            value.with(name, &Value::variable(&pars::closed_form::term(name, &n(), 0))).unwrap()
        };
        of(of(value(text), &x), &y)
    };
    let fits = |next: &str, first: Form, second: &str| {
        let sequences = vec![
            Sequence { name: x.clone(), start: vec![int(2)], next: terms(next) },
            Sequence { name: y.clone(), start: vec![int(1)], next: terms("y/3") },
        ];
        let forms = vec![first, Form::Value(Vec::new(), value(second))];
        let recurrence = Recurrence { index: n(), from: 0, sequences };
        Solved::check(recurrence, forms, Vec::new(), &Assumptions::default()).is_ok()
    };
    let pieces = |first: &str, until: &str, second: &str| {
        let until = value(until);
        Form::Pieces(vec![
            Piece { from: int(0), until: Some(until.clone()), form: value(first) },
            Piece { from: until, until: None, form: value(second) },
        ])
    };
    // 2, 1, 1/3, 1/9, …
    let next = "max(x-1, y)";
    assert!(fits(next, pieces("2-n", "1", "3*(1/3)^n"), "(1/3)^n"));
    assert!(!fits(next, pieces("2-n", "3", "3*(1/3)^n"), "(1/3)^n"), "one index too late");
    assert!(!fits(next, pieces("2-n", "3/2", "3*(1/3)^n"), "(1/3)^n"), "no whole number");
    assert!(!fits(next, pieces("2-n", "2", "2-n"), "(1/3)^n"), "the region is left");
    assert!(!fits(next, pieces("2-n", "2", "3*(1/3)^n"), "(1/2)^n"), "the other one is wrong");
    assert!(!fits(next, pieces("3*(1/3)^n", "2", "3*(1/3)^n"), "(1/3)^n"), "another start");
    // A region that is left after more than a thousand steps: n^2 outgrows (101/100)^n for so long only.
    let long = "if n^2 + 2 > (101/100)^n then x + y else x";
    assert!(!fits(long, Form::Value(Vec::new(), value("7/2 - 3/2*(1/3)^n")), "(1/3)^n"));
    let late = "if (n+2)^2 < (101/100)^n then x else x + y";
    assert!(!fits(late, Form::Value(Vec::new(), value("7/2 - 3/2*(1/3)^n")), "(1/3)^n"));
    let always = "if n + 2 > (99/100)^n then x + y else x";
    assert!(fits(always, Form::Value(Vec::new(), value("7/2 - 3/2*(1/3)^n")), "(1/3)^n"));
}
