//! Weak equality is preserved by every context: random contexts, with the model as the judge.

mod common;

use common::*;
use pars::bisimulation::{Comparison, Reach, compare};
use pars::definition::Definitions;
use pars::law::Connective;
use pars::model::Model;
use pars::term::{Node, Term};
use proptest::prelude::*;

fn step() -> Term {
    Term::new(Node::New(name("k"), par([input("k", "y"), output("k", 1)])))
}

fn output(port: &str, value: i64) -> Term {
    Term::new(Node::Out(name(port), number(value)))
}

/// Processes that have not ended at their start.
fn running() -> impl Strategy<Value = Term> {
    prop_oneof![
        Just(Term::delay(number(1))),
        Just(Term::delay(number(2))),
        Just(Term::idle()),
        Just(output("c", 0)),
        Just(input("c", "z")),
        Just(seq([Term::delay(number(1)), output("c", 1)])),
        Just(seq([Term::delay(number(1)), Term::abort()])),
        Just(dis([input("c", "z"), Term::delay(number(1))])),
    ]
}

fn any_process() -> impl Strategy<Value = Term> {
    prop_oneof![4 => running(), 1 => Just(Term::stop()), 1 => Just(Term::abort())]
}

/// A context as a function of what is put in.
#[derive(Clone, Debug)]
enum Around {
    Then(Term),
    After(Term),
    Beside(Term),
    Against(Term),
    OrElse(Term),
    Private,
    Again,
}

fn around() -> impl Strategy<Value = Around> {
    prop_oneof![
        any_process().prop_map(Around::Then),
        any_process().prop_map(Around::After),
        any_process().prop_map(Around::Beside),
        any_process().prop_map(Around::Against),
        any_process().prop_map(Around::OrElse),
        Just(Around::Private),
        Just(Around::Again),
    ]
}

fn put(inner: Term, contexts: &[Around]) -> Term {
    contexts.iter().fold(inner, |inner, context| match context {
        Around::Then(other) => seq([inner, other.clone()]),
        Around::After(other) => seq([other.clone(), inner]),
        Around::Beside(other) => par([inner, other.clone()]),
        Around::Against(other) => dis([inner, other.clone()]),
        Around::OrElse(other) => Term::new(Node::Else(inner, other.clone())),
        Around::Private => Term::new(Node::New(name("c"), inner)),
        Around::Again => Term::new(Node::Loop(seq([inner, Term::delay(number(1))]))),
    })
}

#[test]
fn weak_equality_is_kept_by_every_context() {
    let mut runner = proptest::test_runner::TestRunner::new(seeded(ProptestConfig::with_cases(3_000)));
    let pairs = (running(), prop::collection::vec(around(), 0..4));
    let none = Definitions::default();
    let meant = |term: &Term| Model::new(&none).state(term).is_ok();
    let outcome = runner.run(&pairs, |(process, contexts)| {
        let left = put(seq([step(), process.clone()]), &contexts);
        let right = put(seq([Term::new(Node::Set(number(1), name("y"))), process]), &contexts);
        prop_assume!(meant(&left) && meant(&right));
        match compare(&left, &right, Connective::Weak, &none, &Reach { pairs: 2_000, ..Reach::default() }) {
            Ok(Comparison::Different(run)) => Err(TestCaseError::fail(format!("{left} ~~ {right}: {run:?}"))),
            _ => Ok(()),
        }
    });
    outcome.unwrap();
}

#[test]
fn a_step_before_an_end_is_told_apart_by_a_context() {
    let left = dis([seq([step(), Term::stop()]), input("d", "z")]);
    let right = dis([Term::new(Node::Set(number(1), name("y"))), input("d", "z")]);
    let found = compare(&left, &right, Connective::Weak, &Definitions::default(), &Reach::default());
    assert!(matches!(found, Ok(Comparison::Different(_))), "{found:?}");
}
