//! Reads a system and the question about it.

use pars::invariant::Claim;
use pars::lower::{ClaimKind, Environment, Event, Likelihood, Lowered, System};
use pars::parser::parse;
use pars::period::{Test, analyse};
use pars::probability::Question;
use pars::probability::chain::{Chain, chain};
use pars::value::{Relation, Value};

/// What is asked of which system, in the last claim.
pub fn read(text: &str) -> (Environment, System, Claim, Question) {
    let text = format!("observer At(r), Done\n{text} >= 1/2");
    let parsed = parse(&text);
    assert!(parsed.diagnostics.is_empty(), "{:?}", parsed.diagnostics);
    let mut environment = Environment::default();
    let mut batch = environment.open(&parsed.items, &text);
    let mut last = None;
    for (index, item) in parsed.items.iter().enumerate() {
        match environment.step(&mut batch, index, item) {
            Ok(Lowered::Claim(claim)) => last = Some(claim.kind),
            Ok(_) => {}
            Err(errors) => panic!("{errors:?}"),
        }
    }
    let Some(ClaimKind::Likely { likelihood: Likelihood { system, event, .. }, .. }) = last else { panic!("no claim") };
    let Event::Shown { first, pattern, time } = event else { panic!("not shown") };
    let system = environment.system(&system).expect("a system").clone();
    let test = |(relation, left, right): (Relation, Value, Value)| Test { relation, left, right };
    let tests = pattern.conditions.into_iter().map(test).collect();
    let claim = Claim { shown: pattern.terms, variables: pattern.variables.clone(), tests };
    let names = pattern.variables.into_iter().collect();
    (environment, system, claim, Question { first, time: time.as_rational().expect("a number"), names })
}

/// The chain and the question of the last claim.
pub fn load(text: &str) -> (Chain, Question) {
    let (environment, system, claim, question) = read(text);
    let period = analyse(&system.components, &environment.definitions, &environment.assumptions).expect("a period");
    (chain(&period, &claim, &environment.assumptions).expect("a chain"), question)
}
