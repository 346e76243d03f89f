//! The executable meaning judges the law table: what does not hold is refuted, what holds is not.

mod common;

use common::*;
use pars::law::{Condition, Connective, Fact};
use pars::term::{Node, Term};
use pars::value::Relation;

/// Refuted by a counterexample, whose run replays (the search itself checks that).
fn refuted(left: Term, right: Term, conditions: &[Condition]) {
    let judged = try_to_refute(&left, &right, Connective::Equal, conditions);
    let found = judged.counterexample().unwrap_or_else(|| panic!("not refuted: {left:?} = {right:?}: {judged:?}"));
    let largest = found.processes.values().map(Term::size).max().unwrap_or(0);
    assert!(largest <= 4, "a larger counterexample than needed: {found:?}");
}

/// No counterexample, and enough instances that did have a meaning.
fn stands(left: Term, right: Term, conditions: &[Condition]) {
    stands_as(left, right, Connective::Equal, conditions);
}

fn stands_as(left: Term, right: Term, connective: Connective, conditions: &[Condition]) {
    let judged = try_to_refute(&left, &right, connective, conditions);
    match judged {
        pars::refute::Refutation::Refuted(found) => panic!("{left:?} = {right:?} refuted: {found:#?}"),
        pars::refute::Refutation::None { instances, meaningless, .. } => {
            assert!(instances > meaningless, "nothing was tried for {left:?} = {right:?}: {judged:?}");
        }
    }
}

fn is(fact: Fact, process: &str) -> Condition {
    Condition::Is(fact, p(process))
}

fn all(facts: &[Fact], processes: &[&str]) -> Vec<Condition> {
    processes.iter().flat_map(|name| facts.iter().map(|fact| is(*fact, name))).collect()
}

fn exclusive() -> Vec<Condition> {
    vec![Condition::Complementary(p("G"), p("H"))]
}

fn read(body: Term) -> Term {
    Term::seq([input("?c", "?y"), body])
}

#[test]
fn distribution_to_the_right_of_a_sequence_is_refuted() {
    refuted(seq([par([p("P"), p("Q")]), p("R")]), par([seq([p("P"), p("R")]), seq([p("Q"), p("R")])]), &[]);
    refuted(seq([dis([p("P"), p("Q")]), p("R")]), dis([seq([p("P"), p("R")]), seq([p("Q"), p("R")])]), &[]);
}

#[test]
fn distribution_of_a_prefix_is_refuted() {
    refuted(seq([p("R"), par([p("P"), p("Q")])]), par([seq([p("R"), p("P")]), seq([p("R"), p("Q")])]), &[]);
    let left = read(par([seq([p("G"), p("P")]), seq([p("H"), p("Q")])]));
    let right = par([read(seq([p("G"), p("P")])), read(seq([p("H"), p("Q")]))]);
    refuted(left, right, &exclusive());
}

#[test]
fn choices_under_disabling_are_refuted() {
    let (then, other) = (seq([p("G"), p("P")]), seq([p("H"), p("Q")]));
    refuted(dis([then.clone(), other.clone()]), par([then, other]), &exclusive());
}

#[test]
fn idempotence_with_communication_is_refuted() {
    refuted(par([p("P"), p("P")]), p("P"), &[]);
    refuted(dis([p("P"), p("P")]), p("P"), &[]);
}

#[test]
fn units_of_termination_are_refuted() {
    refuted(attempt(seq([p("P"), p("Q")])), seq([attempt(p("P")), attempt(p("Q"))]), &[]);
    refuted(par([p("P"), Term::stop()]), p("P"), &[]);
    refuted(par([p("P"), seq([p("Q"), Term::abort()])]), p("P"), &[]);
    refuted(dis([p("P"), Term::abort()]), Term::abort(), &[]);
    refuted(seq([p("P"), Term::abort()]), Term::abort(), &[]);
}

#[test]
fn distribution_of_disabling_is_refuted() {
    refuted(dis([par([p("P"), p("Q")]), p("R")]), par([dis([p("P"), p("R")]), dis([p("Q"), p("R")])]), &[]);
    let watched = par([dis([p("P"), p("O")]), p("Q")]);
    refuted(watched, dis([par([p("P"), p("Q")]), p("O")]), &[is(Fact::Observer, "O")]);
    refuted(dis([seq([p("P"), p("Q")]), p("R")]), seq([dis([p("P"), p("R")]), dis([p("Q"), p("R")])]), &[]);
}

#[test]
fn unfolding_without_the_exit_is_refuted() {
    let guarded = [is(Fact::Guarded, "P")];
    refuted(again(p("P")), seq([p("P"), again(p("P"))]), &guarded);
    refuted(again(p("P")), seq([power(p("P"), "?n"), again(p("P"))]), &guarded);
    let both = all(&[Fact::Guarded], &["P", "Q"]);
    refuted(par([again(p("P")), again(p("Q"))]), again(par([p("P"), p("Q")])), &both);
}

#[test]
fn two_readers_of_one_writer_are_refuted() {
    let reader = |name: &str| seq([input("c", "y"), p(name)]);
    let writer = seq([output("c", number(0)), p("Q")]);
    let left = private("c", par([reader("P"), reader("R"), writer.clone()]));
    let right = private("c", par([seq([input("c", "y"), par([p("P"), p("R")])]), writer]));
    refuted(left, right, &[]);
}

#[test]
fn removing_a_communication_is_refuted_in_the_strong_sense() {
    refuted(seq([tau(), p("P")]), p("P"), &[]);
}

#[test]
fn delay_laws_on_what_is_no_delay_are_refuted() {
    let left = dis([power(dis([delay("?t"), p("P")]), "?n"), Term::idle()]);
    let length = var("?n").mul(&var("?t")).expect("a product");
    refuted(left, dis([Term::delay(length), p("P")]), &[]);
    refuted(dis([p("P"), Term::stop()]), p("P"), &[]);
    refuted(par([p("P"), p("Q")]), dis([p("P"), p("Q")]), &[]);
}

#[test]
fn laws_of_sequence_stand() {
    stands(seq([Term::stop(), p("P")]), p("P"), &[]);
    stands(seq([p("P"), Term::stop()]), p("P"), &[]);
    stands(seq([Term::abort(), p("P")]), Term::abort(), &[]);
    stands(seq([Term::idle(), p("P")]), Term::idle(), &[]);
    stands(seq([p("P"), p("Q")]), p("P"), &[is(Fact::NeverStops, "P")]);
    let bind = Term::new(Node::Set(var("?x"), name("?y")));
    let replaced = Term::new(Node::Replace(p("P"), name("?y"), var("?x")));
    // Where x reads y, P would read it anew.
    let unread = [Condition::Unread(bind.clone(), name("?y"))];
    stands(seq([bind.clone(), p("P")]), seq([bind, replaced]), &unread);
    let silent = vec![
        is(Fact::Silent, "R"),
        is(Fact::DrawsNothing, "R"),
        Condition::Apart(p("R"), p("P")),
        Condition::Apart(p("R"), p("Q")),
    ];
    stands(seq([p("R"), par([p("P"), p("Q")])]), par([seq([p("R"), p("P")]), seq([p("R"), p("Q")])]), &silent);
    stands(seq([p("R"), dis([p("P"), p("Q")])]), dis([seq([p("R"), p("P")]), seq([p("R"), p("Q")])]), &silent);
}

#[test]
fn laws_of_guards_stand() {
    let choice = |one: Term, two: Term| par([seq([p("G"), one]), seq([p("H"), two])]);
    stands(choice(p("P"), p("P")), p("P"), &exclusive());
    let left = seq([choice(p("P"), p("Q")), p("R")]);
    stands(left, choice(seq([p("P"), p("R")]), seq([p("Q"), p("R")])), &exclusive());
    let left = dis([choice(p("P"), p("Q")), p("R")]);
    stands(left, choice(dis([p("P"), p("R")]), dis([p("Q"), p("R")])), &exclusive());
    let left = par([choice(p("P"), p("Q")), p("R")]);
    stands(left, choice(par([p("P"), p("R")]), par([p("Q"), p("R")])), &exclusive());
    let both = seq([p("G"), par([p("P"), p("Q")])]);
    stands(both, par([seq([p("G"), p("P")]), seq([p("G"), p("Q")])]), &[is(Fact::Guard, "G")]);
    let moved = [is(Fact::Guard, "G"), is(Fact::NotStopped, "Q")];
    stands(seq([p("G"), dis([p("P"), p("Q")])]), dis([seq([p("G"), p("P")]), p("Q")]), &moved);
    stands(par([p("G"), p("H")]), Term::stop(), &exclusive());
    stands(seq([p("G"), p("H")]), Term::abort(), &exclusive());
}

#[test]
fn laws_of_parallel_stand() {
    stands(par([p("P"), Term::abort()]), p("P"), &[]);
    stands(par([p("P"), Term::stop()]), attempt(p("P")), &[]);
    stands(par([p("P"), Term::stop()]), p("P"), &[is(Fact::NeverAborts, "P")]);
    stands(attempt(attempt(p("P"))), attempt(p("P")), &[]);
    stands(par([p("P"), Term::idle()]), seq([attempt(p("P")), Term::idle()]), &[]);
    stands(par([p("P"), p("P")]), p("P"), &all(&[Fact::Silent, Fact::DrawsNothing], &["P"]));
    let tries = seq([p("P"), attempt(p("Q"))]);
    stands(attempt(seq([p("P"), p("Q")])), attempt(tries.clone()), &[is(Fact::BindsNothing, "P")]);
    let conditions = all(&[Fact::NeverAborts, Fact::BindsNothing], &["P"]);
    stands(attempt(seq([p("P"), p("Q")])), tries, &conditions);
    stands(attempt(par([p("P"), p("Q")])), par([attempt(p("P")), attempt(p("Q"))]), &[]);
    stands(attempt(dis([p("P"), p("Q")])), dis([attempt(p("P")), attempt(p("Q"))]), &[]);
    stands(attempt(seq([p("P"), Term::abort()])), attempt(p("P")), &[is(Fact::BindsNothing, "P")]);
    stands(seq([attempt(p("P")), Term::abort()]), seq([p("P"), Term::abort()]), &[]);
    let lasts = |name: &str| Condition::Lasts(p(name), var("?t"));
    let left = par([seq([p("P"), p("Q")]), seq([p("R"), p("S")])]);
    let right = seq([par([p("P"), p("R")]), par([p("Q"), p("S")])]);
    stands(left, right, &[lasts("P"), lasts("R")]);
}

#[test]
fn laws_of_disabling_stand() {
    stands(dis([p("P"), Term::stop()]), Term::stop(), &[is(Fact::NotStopped, "P")]);
    stands(dis([p("P"), Term::abort()]), Term::abort(), &[is(Fact::NotStopped, "P")]);
    stands(dis([p("P"), Term::idle()]), p("P"), &[]);
    stands(dis([p("P"), p("P")]), p("P"), &all(&[Fact::Silent, Fact::DrawsNothing], &["P"]));
    let mut conditions = all(&[Fact::Silent, Fact::NeverAborts, Fact::DrawsNothing], &["R"]);
    conditions.extend(all(&[Fact::BindsNothing], &["P", "Q"]));
    let right = par([dis([p("P"), p("R")]), dis([p("Q"), p("R")])]);
    stands(dis([par([p("P"), p("Q")]), p("R")]), right, &conditions);
    let right = dis([dis([p("P"), p("R")]), dis([p("Q"), p("R")])]);
    let conditions = all(&[Fact::Silent, Fact::DrawsNothing], &["R"]);
    stands(dis([dis([p("P"), p("Q")]), p("R")]), right, &conditions);
}

#[test]
fn laws_of_delays_stand() {
    let value = |text: &str| var(text);
    let sum = value("?a").add(&value("?b")).expect("a sum");
    stands(seq([delay("?a"), delay("?b")]), Term::delay(sum), &[]);
    let first = |name: &str| seq([delay("?a"), p(name)]);
    stands(par([first("P"), first("Q")]), seq([delay("?a"), par([p("P"), p("Q")])]), &[]);
    stands(dis([first("P"), first("Q")]), seq([delay("?a"), dis([p("P"), p("Q")])]), &[]);
    let least = [Condition::Compare(Relation::Lte, value("?a"), value("?b"))];
    let rest = Term::delay(value("?b").sub(&value("?a")).expect("a difference"));
    let later = seq([delay("?b"), p("Q")]);
    for (left, right) in [
        (par([first("P"), later.clone()]), seq([delay("?a"), par([p("P"), seq([rest.clone(), p("Q")])])])),
        (dis([first("P"), later.clone()]), seq([delay("?a"), dis([p("P"), seq([rest.clone(), p("Q")])])])),
        (par([delay("?a"), later.clone()]), seq([delay("?b"), attempt(p("Q"))])),
    ] {
        stands(left, right, &least);
    }
    let less = [Condition::Compare(Relation::Lss, value("?a"), value("?b"))];
    stands(dis([delay("?a"), later.clone()]), delay("?a"), &less);
    stands(
        par([first("A"), later.clone()]),
        later,
        &[less[0].clone(), is(Fact::NeverStops, "A"), is(Fact::Guard, "A")],
    );
}

#[test]
fn laws_of_observers_stand() {
    let mut watched = vec![is(Fact::Observer, "O")];
    let over = |body: Term| dis([body, p("O")]);
    stands(over(par([p("P"), p("Q")])), par([over(p("P")), over(p("Q"))]), &watched);
    stands(over(dis([p("P"), p("Q")])), dis([over(p("P")), over(p("Q"))]), &watched);
    stands(attempt(over(p("P"))), over(attempt(p("P"))), &watched);
    stands(seq([over(delay("?a")), p("O")]), p("O"), &watched);
    stands(par([p("O"), Term::stop()]), p("O"), &watched);
    stands_as(over(p("P")), p("P"), Connective::Refines, &watched);
    stands_as(p("O"), Term::idle(), Connective::Refines, &watched);
    watched.push(Condition::Apart(p("P"), p("O")));
    stands(over(seq([p("P"), p("Q")])), seq([over(p("P")), over(p("Q"))]), &watched);
    watched.push(is(Fact::Guarded, "P"));
    stands(over(again(p("P"))), again(over(p("P"))), &watched);
}

#[test]
fn laws_of_loops_stand() {
    let guarded = [is(Fact::Guarded, "P")];
    let whole = again(p("P"));
    stands(whole.clone(), attempt(seq([p("P"), whole.clone()])), &guarded);
    stands(seq([whole.clone(), p("Q")]), whole.clone(), &all(&[Fact::Guarded, Fact::NeverAborts], &["P"]));
    stands(attempt(whole.clone()), whole, &guarded);
    let exits = attempt(p("P"));
    let once = all(&[Fact::Guarded, Fact::BindsNothing], &["P"]);
    stands(again(seq([p("P"), Term::abort()])), exits, &once);
    let pair = all(&[Fact::Silent, Fact::DrawsNothing, Fact::Guarded], &["P", "Q"]);
    let same: Vec<Condition> = ["P", "Q"].iter().map(|name| Condition::Lasts(p(name), var("?t"))).chain(pair).collect();
    stands(par([again(p("P")), again(p("Q"))]), again(par([p("P"), p("Q")])), &same);
    let twice = |body: Term| Term::new(Node::Power(body, number(2), None));
    stands(again(twice(p("P"))), again(p("P")), &once);
}

#[test]
fn laws_of_communication_stand() {
    let left = private("c", par([seq([input("c", "y"), p("P")]), seq([output("c", var("?x")), p("Q")])]));
    let step = par([input("c", "y"), output("c", var("?x"))]);
    let apart = Condition::Apart(Term::new(Node::Set(number(0), name("y"))), p("Q"));
    stands(left, private("c", seq([step, par([p("P"), p("Q")])])), &[apart, is(Fact::NeverAborts, "P")]);
    let free = [Condition::NoPort(p("P"), name("c"))];
    stands(private("c", p("P")), p("P"), &free);
    stands(private("c", seq([input("c", "y"), p("P")])), Term::idle(), &[]);
    let left = private("c", seq([p("P"), p("Q")]));
    stands(left, seq([private("c", p("P")), private("c", p("Q"))]), &[]);
    let body = |one: Term, two: Term| par([one, two]);
    let ends = |name: &str, last: Term| seq([p(name), last]);
    let (sent, got) = (output("k", number(0)), input("k", "z"));
    let left = private("k", body(again(ends("P", sent.clone())), again(ends("Q", got.clone()))));
    let right = again(private("k", body(ends("P", sent), ends("Q", got))));
    let mut fresh = vec![Condition::NoPort(p("P"), name("k")), Condition::NoPort(p("Q"), name("k"))];
    // The table leaves unsaid that the two loops share no name: on the right one round sees what the other bound.
    refuted(left.clone(), right.clone(), &fresh);
    fresh.extend([Condition::Apart(p("P"), p("Q")), Condition::Apart(p("Q"), p("P"))]);
    fresh.extend(["P", "Q"].map(|one| Condition::Apart(input("k", "z"), p(one))));
    stands(left, right, &fresh);
}
