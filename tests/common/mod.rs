//! Short ways to write terms in tests.
#![allow(dead_code)]

use std::io::Write;
use std::process::{Command, Output, Stdio};

use pars::assumption::Assumptions;
use pars::definition::{Definition, Definitions};
use pars::law::{Condition, Connective};
use pars::lower::{Environment, Lowered, Question};
use pars::name::Name;
use pars::parser::parse;
use pars::refute::{Limits, Refutation, refute};
use pars::term::{Node, Term};
use pars::value::{Relation, Value};

pub fn name(text: &str) -> Name {
    Name::new(text)
}

pub fn number(number: i64) -> Value {
    Value::integer(number)
}

pub fn var(text: &str) -> Value {
    Value::variable(&name(text))
}

/// The process metavariable of this name.
pub fn p(text: &str) -> Term {
    Term::meta(&name(&format!("?{text}")))
}

pub fn seq<const N: usize>(parts: [Term; N]) -> Term {
    Term::seq(parts)
}

pub fn par<const N: usize>(parts: [Term; N]) -> Term {
    Term::par(parts)
}

pub fn dis<const N: usize>(parts: [Term; N]) -> Term {
    Term::disable(parts)
}

pub fn attempt(body: Term) -> Term {
    Term::attempt(body)
}

pub fn again(body: Term) -> Term {
    Term::new(Node::Loop(body))
}

pub fn power(body: Term, count: &str) -> Term {
    Term::new(Node::Power(body, var(count), None))
}

pub fn delay(time: &str) -> Term {
    Term::delay(var(time))
}

pub fn wait(time: i64) -> Term {
    Term::delay(number(time))
}

pub fn input(port: &str, result: &str) -> Term {
    Term::new(Node::In(name(port), name(result)))
}

pub fn output(port: &str, value: Value) -> Term {
    Term::new(Node::Out(name(port), value))
}

pub fn private(port: &str, body: Term) -> Term {
    Term::new(Node::New(name(port), body))
}

pub fn guard(relation: Relation, left: Value, right: Value) -> Term {
    Term::new(Node::Guard(relation, left, right))
}

pub fn observer(text: &str, values: Vec<Value>) -> Term {
    Term::new(Node::Observe(name(text), values))
}

pub fn call(text: &str, values: Vec<Value>) -> Term {
    Term::new(Node::Call(name(text), values))
}

/// One internal communication.
pub fn tau() -> Term {
    private("i", par([input("i", "i"), output("i", number(0))]))
}

pub fn define(definitions: &mut Definitions, text: &str, parameters: &[&str], body: Term) {
    let recursive = calls(&body, &name(text));
    let parameters = parameters.iter().map(|parameter| name(parameter)).collect();
    definitions.insert(Definition { name: name(text), parameters, body, recursive });
}

fn calls(term: &Term, wanted: &Name) -> bool {
    matches!(term.node(), Node::Call(name, _) if name == wanted)
        || term.children().into_iter().any(|part| calls(part, wanted))
}

pub fn try_to_refute(left: &Term, right: &Term, connective: Connective, conditions: &[Condition]) -> Refutation {
    let limits = Limits { instances: 4_000, ..Limits::default() };
    refute(left, right, connective, conditions, &Definitions::default(), &Assumptions::default(), &limits)
}

/// A random test that tries the same cases every time; `PROPTEST_RNG_SEED=…` tries others.
pub fn seeded(config: proptest::test_runner::Config) -> proptest::test_runner::Config {
    use proptest::test_runner::RngSeed;
    let rng_seed = match config.rng_seed {
        RngSeed::Random => RngSeed::Fixed(2012),
        given => given,
    };
    proptest::test_runner::Config { rng_seed, failure_persistence: None, ..config }
}

pub fn int(number: i64) -> Value {
    Value::integer(number)
}

pub fn frac(top: i64, bottom: i64) -> Value {
    Value::fraction(top, bottom).unwrap()
}

pub fn add(a: &Value, b: &Value) -> Value {
    a.add(b).unwrap()
}

pub fn sub(a: &Value, b: &Value) -> Value {
    a.sub(b).unwrap()
}

pub fn mul(a: &Value, b: &Value) -> Value {
    a.mul(b).unwrap()
}

pub fn div(a: &Value, b: &Value) -> Value {
    a.div(b).unwrap()
}

/// Runs the program on a script.
pub fn ran(script: &str) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_pars"))
        .args(["run", "--color", "never", "-"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("pars runs");
    child.stdin.take().expect("an input").write_all(script.as_bytes()).expect("it reads");
    child.wait_with_output().expect("it ends")
}

/// The question of a text, with the environment in which it stands.
pub fn question(text: &str) -> (Question, Environment) {
    let mut environment = Environment::new();
    let parsed = parse(text);
    assert!(parsed.diagnostics.is_empty(), "{text}: {:?}", parsed.diagnostics);
    let mut found = None;
    for lowered in environment.declare(&parsed.items, text) {
        if let Lowered::Solve(solve) = lowered.unwrap_or_else(|error| panic!("{text}: {error:?}")) {
            found = Some(*solve);
        }
    }
    (found.expect("a question"), environment)
}

/// Processes `R0`, `R1`, … of which each hands what it reads on, from port `c0` to the port of this number; and their names,
/// each behind a bar.
pub fn relays(parts: usize) -> (String, String) {
    let relay = |place: usize| format!("proc R{place} = In_c{place}<x> ; Out_{{c{},x}} ; R{place}\n", place + 1);
    ((0..parts).map(relay).collect(), (0..parts).map(|place| format!(" | R{place}")).collect())
}
