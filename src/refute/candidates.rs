//! What the slots of a claim are filled with, simplest first.

use std::collections::BTreeSet;

use num_bigint::BigInt;
use num_rational::BigRational;

use super::slots::{Slot, Vocabulary, usual};
use crate::name::Name;
use crate::term::{Node, Term};
use crate::value::{Relation, Value};

/// One filling, with what it costs.
#[derive(Clone, Debug)]
pub(super) enum Candidate {
    Process(Term, usize),
    Value(Value, usize),
    Name(Name, usize),
}

impl Candidate {
    pub(super) fn cost(&self) -> usize {
        match self {
            Candidate::Process(_, cost) | Candidate::Value(_, cost) | Candidate::Name(_, cost) => *cost,
        }
    }
}

/// The name that stands for a process metavariable's parameter at this place.
pub(super) fn formal(place: usize) -> Name {
    Name::new(&format!("${place}"))
}

/// All candidates for a slot, by cost.
pub(super) fn candidates(slot: &Slot, vocabulary: &Vocabulary) -> Vec<Candidate> {
    match slot {
        Slot::Process(_, arity) => processes(*arity, vocabulary),
        Slot::Value(_) | Slot::Count(_) | Slot::Parameter(_) => {
            let priced = usual().into_iter().zip([1, 1, 1, 2, 2, 3]);
            let mentioned = vocabulary.numbers.iter().cloned().map(|number| (number, 2));
            let mut all: Vec<Candidate> =
                priced.chain(mentioned).map(|(number, cost)| Candidate::Value(Value::rational(number), cost)).collect();
            if let Slot::Value(_) = slot {
                for read in vocabulary.results.iter().filter(|name| !name.is_meta()).map(Value::variable) {
                    all.extend(read.add(&Value::integer(1)).ok().map(|next| Candidate::Value(next, 3)));
                    all.push(Candidate::Value(read, 2));
                }
            }
            all
        }
        Slot::Distribution(_) => distributions(),
        Slot::Port(_) => vocabulary.ports.iter().map(|name| Candidate::Name(name.clone(), 1)).collect(),
        Slot::Result(_) => vocabulary.results.iter().map(|name| Candidate::Name(name.clone(), 1)).collect(),
    }
}

fn distributions() -> Vec<Candidate> {
    let half = Value::rational(BigRational::new(BigInt::from(1), BigInt::from(2)));
    let point = |number| Value::distribution("Point", vec![Value::integer(number)]);
    let mut all = Vec::new();
    if let (Ok(zero), Ok(one)) = (point(0), point(1)) {
        if let Ok(coin) = Value::distribution("Mix", vec![half.clone(), zero.clone(), half, one]) {
            all.push(Candidate::Value(coin, 1));
        }
        all.push(Candidate::Value(zero, 1));
    }
    all
}

/// Single operators of cost 1 and of cost 2, over the given names and parameters.
fn single(arity: usize, vocabulary: &Vocabulary) -> (Vec<Term>, Vec<Term>) {
    let zero = Value::integer(0);
    let one = Value::integer(1);
    let node = Term::new;
    let port = |place: usize| vocabulary.ports[place].clone();
    let result = |place: usize| vocabulary.results[place].clone();
    let observer = |name: &str, values| node(Node::Observe(Name::new(name), values));
    let mut simple = vec![
        Term::stop(),
        Term::abort(),
        Term::delay(one.clone()),
        observer("A", Vec::new()),
        node(Node::Out(port(0), zero.clone())),
        node(Node::In(port(0), result(0))),
        node(Node::Set(zero.clone(), result(0))),
        Term::delay(Value::integer(2)),
        Term::idle(),
    ];
    let read = Value::variable(&result(0));
    let mut further = vec![
        observer("B", Vec::new()),
        node(Node::Guard(Relation::Eq, read.clone(), zero.clone())),
        node(Node::Guard(Relation::Neq, read.clone(), zero.clone())),
        node(Node::Out(port(0), read.clone())),
        observer("A", vec![read.clone()]),
        node(Node::Set(one.clone(), result(0))),
        node(Node::Set(one.clone(), result(1))),
        node(Node::Out(port(1), zero.clone())),
        node(Node::In(port(1), result(1))),
        node(Node::Guard(Relation::Eq, zero.clone(), one.clone())),
        node(Node::Guard(Relation::Eq, zero.clone(), zero.clone())),
    ];
    if let Some(Candidate::Value(coin, _)) = distributions().first() {
        further.push(node(Node::Ran(coin.clone(), result(0))));
    }
    for place in 0..arity {
        let value = Value::variable(&formal(place));
        simple.push(node(Node::Guard(Relation::Neq, value.clone(), one.clone())));
        simple.push(Term::delay(value.clone()));
        simple.push(observer("A", vec![value.clone()]));
        further.push(node(Node::Out(port(0), value.clone())));
        further.push(node(Node::Set(value, result(0))));
    }
    (simple, further)
}

/// Processes that wait for a drawn time and carry nothing: one that aborts then, and one that stops.
fn drawing(vocabulary: &Vocabulary) -> Vec<Term> {
    let half = || Value::rational(BigRational::new(BigInt::from(1), BigInt::from(2)));
    let point = |number| Value::distribution("Point", vec![Value::integer(number)]);
    let (Ok(one), Ok(two), Some(name)) = (point(1), point(2), vocabulary.results.first()) else { return Vec::new() };
    let Ok(coin) = Value::distribution("Mix", vec![half(), one, half(), two]) else { return Vec::new() };
    let draw = Term::new(Node::Ran(coin, name.clone()));
    let aborting = Term::seq([draw, Term::delay(Value::variable(name)), Term::abort()]);
    vec![aborting.clone(), Term::attempt(aborting)]
}

fn processes(arity: usize, vocabulary: &Vocabulary) -> Vec<Candidate> {
    let (simple, further) = single(arity, vocabulary);
    let mut seen: BTreeSet<Term> = BTreeSet::new();
    let mut all = Vec::new();
    let mut add = |term: Term, cost: usize| {
        if seen.insert(term.clone()) {
            all.push(Candidate::Process(term, cost));
        }
    };
    simple.iter().for_each(|term| add(term.clone(), 1));
    further.iter().for_each(|term| add(term.clone(), 2));
    let waits = |term: &&Term| matches!(term.node(), Node::Delay(_) | Node::Out(..) | Node::In(..));
    for body in simple.iter().filter(waits) {
        add(Term::new(Node::Loop(body.clone())), 2);
    }
    let useful = |term: &&Term| !matches!(term.node(), Node::Stop | Node::Abort);
    // Pairs of simple operators, then pairs with one further.
    for (firsts, seconds, cost) in [(&simple, &simple, 3), (&simple, &further, 4), (&further, &simple, 4)] {
        for first in firsts.iter() {
            for second in seconds.iter() {
                if useful(&first) {
                    add(Term::seq([first.clone(), second.clone()]), cost);
                }
                if useful(&first) && useful(&second) {
                    add(Term::par([first.clone(), second.clone()]), cost);
                    add(Term::disable([first.clone(), second.clone()]), cost);
                }
            }
        }
    }
    drawing(vocabulary).into_iter().for_each(|term| add(term, 3));
    for first in simple.iter().filter(waits) {
        for second in simple.iter().filter(useful) {
            add(Term::new(Node::Loop(Term::seq([first.clone(), second.clone()]))), 4);
            add(Term::new(Node::Loop(Term::disable([first.clone(), second.clone()]))), 4);
        }
        add(Term::new(Node::Loop(Term::seq([first.clone(), Term::abort()]))), 4);
    }
    all
}
