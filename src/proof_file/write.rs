//! A proof as the text of a proof file.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use super::text::{
    Claim, Moving as MovingText, Step as StepText, Substitution as SubstitutionText, Theory as TheoryText,
};
use super::{FORMAT, last_line};
use crate::kernel::Theory;
use crate::law::Laws;
use crate::lower::{Class, Entity, Environment, Quantity};
use crate::name::Name;
use crate::proof::{Moving, Proof, Statement, Step, hole};
use crate::scope::{calls, condition_parts, fill, metavariables};
use crate::substitution::Substitution;
use crate::term::Term;
use crate::value::Value;

/// The proof file of a proof in an environment. `own` are the program's own laws; others are written out.
///
/// # Errors
/// When a text cannot be written as JSON.
pub fn write(
    environment: &Environment,
    theory: &Theory,
    own: &Laws,
    proof: &Proof,
) -> Result<String, serde_json::Error> {
    let mut out = String::new();
    let declarations = declarations(environment, theory, proof);
    let text = TheoryText { declarations, rules: rules(theory, own, proof) };
    let _ = write!(out, "{{\"format\":{},\n\"theory\":", serde_json::to_string(FORMAT)?);
    out.push_str(&serde_json::to_string(&text)?);
    for (number, lemma) in proof.lemmas.iter().enumerate() {
        out.push_str(if number == 0 { ",\n\"lemmas\":[" } else { ",\n" });
        let _ = write!(out, "{{\"name\":{}", serde_json::to_string(lemma.name.as_str())?);
        proved(&mut out, &lemma.statement, &lemma.steps)?;
        out.push_str(if number + 1 == proof.lemmas.len() { "}]" } else { "}" });
    }
    proved(&mut out, &proof.statement, &proof.steps)?;
    out.push_str(",\n");
    let line = last_line(out.as_bytes());
    Ok(out + &line)
}

/// A claim with its steps.
fn proved(out: &mut String, statement: &Statement, steps: &[Step]) -> Result<(), serde_json::Error> {
    let claim = Claim {
        when: statement.hypotheses.iter().map(ToString::to_string).collect(),
        left: statement.left.to_string(),
        connective: statement.connective,
        right: statement.right.to_string(),
    };
    out.push_str(",\n\"claim\":");
    out.push_str(&serde_json::to_string(&claim)?);
    out.push_str(",\n\"steps\":[");
    for (number, one) in steps.iter().enumerate() {
        out.push_str(if number == 0 { "\n" } else { ",\n" });
        out.push_str(&serde_json::to_string(&step(one))?);
    }
    out.push_str("\n]");
    Ok(())
}

/// The laws used that are not the program's own, as they were written.
fn rules(theory: &Theory, own: &Laws, proof: &Proof) -> String {
    let used: BTreeSet<&Name> = proof
        .parts()
        .flat_map(|(_, steps)| steps)
        .filter_map(|step| if let Step::Law(name, _) = step { Some(name) } else { None })
        .filter(|name| own.get(name).is_none())
        .collect();
    let laws = used.into_iter().filter_map(|name| theory.laws.get(name));
    laws.map(|law| format!("{law}\n")).collect::<Vec<_>>().join("\n")
}

/// Parameters, functions, observers and processes on which the proof stands, in the language.
fn declarations(environment: &Environment, theory: &Theory, proof: &Proof) -> String {
    let mut out = String::new();
    for (name, quantity) in environment.quantities() {
        let _ = match quantity {
            Quantity::Parameter { class: Class::Distribution, .. } => writeln!(out, "param {name} : distribution"),
            Quantity::Parameter { constant: None, .. } => writeln!(out, "param {name}"),
            Quantity::Function { parameters, body: None } => {
                let names: Vec<&str> = parameters.iter().map(Name::as_str).collect();
                writeln!(out, "fn {name}({})", names.join(", "))
            }
            _ => Ok(()),
        };
    }
    for name in theory.assumptions.naturals() {
        let _ = writeln!(out, "param {name} : natural");
    }
    for (relation, value) in theory.assumptions.iter() {
        let _ = writeln!(out, "param {value} {} 0", relation.symbol());
    }
    for (name, entity) in environment.entities() {
        if let Entity::Observer(count) = entity
            && name.as_str() != "At"
        {
            let names: Vec<String> = (1..=*count).map(|number| format!("x{number}")).collect();
            let list = if names.is_empty() { String::new() } else { format!("({})", names.join(", ")) };
            let _ = writeln!(out, "observer {name}{list}");
        }
    }
    let used = used(theory, proof);
    for definition in theory.definitions.iter().filter(|definition| used.contains(&definition.name)) {
        let _ = writeln!(out, "{definition}");
    }
    out
}

/// The processes that the proof calls, directly or through others.
fn used(theory: &Theory, proof: &Proof) -> BTreeSet<Name> {
    let mut found = BTreeSet::new();
    let mut rest: Vec<Name> = Vec::new();
    for (statement, _) in proof.parts() {
        rest.extend(calls(&statement.left).into_iter().chain(calls(&statement.right)));
        rest.extend(statement.hypotheses.iter().flat_map(|condition| condition_parts(condition).0).flat_map(calls));
    }
    for step in proof.parts().flat_map(|(_, steps)| steps) {
        rest.extend(terms(step).into_iter().flat_map(calls));
        if let Step::Unique { name, .. } = step {
            rest.push(name.clone());
        }
    }
    while let Some(name) = rest.pop() {
        if found.insert(name.clone())
            && let Some(definition) = theory.definitions.get(&name)
        {
            rest.extend(calls(&definition.body));
        }
    }
    found
}

fn terms(step: &Step) -> Vec<&Term> {
    match step {
        Step::Reflexive(term) | Step::Congruence(term, _) | Step::Unfold(term) => vec![term],
        Step::Law(_, with) | Step::Instance(_, with) | Step::Lemma(_, with) => with.processes.values().collect(),
        Step::Arithmetic(left, right) | Step::Suppose(left, right) | Step::Trust(left, _, right, _) => {
            vec![left, right]
        }
        Step::Excluded(left, right) => vec![left, right],
        Step::Unique { candidate, .. } => vec![candidate],
        Step::UniqueLoop { body, .. } => vec![body],
        Step::Advance(term, _)
        | Step::Draw(term, _)
        | Step::Rounds { round: term, .. }
        | Step::Turns { turn: term, .. } => vec![term],
        Step::Induction { left, right, .. } => vec![left, right],
        Step::Symmetric(_) | Step::Transitive(_) | Step::Cases { .. } => Vec::new(),
    }
}

fn step(step: &Step) -> StepText {
    match step {
        Step::Reflexive(term) => StepText::Reflexive { term: term.to_string() },
        Step::Symmetric(of) => StepText::Symmetric { of: *of },
        Step::Transitive(of) => StepText::Transitive { of: of.clone() },
        Step::Congruence(shape, of) => {
            let (context, holes) = holes(shape, of.len());
            StepText::Congruence { context: context.to_string(), holes, of: of.clone() }
        }
        Step::Law(name, with) => StepText::Law { law: name.to_string(), with: substitution(with) },
        Step::Arithmetic(left, right) => StepText::Arithmetic { left: left.to_string(), right: right.to_string() },
        Step::Unfold(call) => StepText::Unfold { call: call.to_string() },
        Step::Unique { name, candidate, equation } => {
            StepText::Unique { name: name.to_string(), candidate: candidate.to_string(), equation: *equation }
        }
        Step::UniqueLoop { body, equation } => StepText::UniqueLoop { body: body.to_string(), equation: *equation },
        Step::Suppose(left, right) => StepText::Suppose { left: left.to_string(), right: right.to_string() },
        Step::Induction { variable, left, right, base, step } => StepText::Induction {
            variable: variable.to_string(),
            left: left.to_string(),
            right: right.to_string(),
            base: *base,
            successor: *step,
        },
        Step::Instance(of, with) => StepText::Instance { of: *of, with: substitution(with) },
        Step::Lemma(of, with) => StepText::Lemma { of: *of, with: substitution(with) },
        Step::Advance(network, time) => {
            StepText::Advance { network: network.to_string(), time: time.as_ref().map(Value::to_string) }
        }
        Step::Draw(network, names) => {
            StepText::Draw { network: network.to_string(), names: names.iter().map(Name::to_string).collect() }
        }
        Step::Cases { when, holds, fails } => StepText::Cases { when: when.to_string(), holds: *holds, fails: *fails },
        Step::Excluded(left, right) => StepText::Excluded { left: left.to_string(), right: right.to_string() },
        Step::Rounds { lemma, variable, round, index, count } => StepText::Rounds {
            lemma: *lemma,
            variable: variable.to_string(),
            round: round.to_string(),
            index: index.to_string(),
            count: count.to_string(),
        },
        Step::Turns { lemma, turn, moving } => {
            StepText::Turns { lemma: *lemma, turn: turn.to_string(), moving: moving.iter().map(one_moving).collect() }
        }
        Step::Trust(left, connects, right, reason) => StepText::Trust {
            left: left.to_string(),
            connective: *connects,
            right: right.to_string(),
            reason: reason.clone(),
        },
    }
}

fn one_moving(one: &Moving) -> MovingText {
    let (start, next) = (one.start.to_string(), one.next.to_string());
    MovingText { variable: one.variable.to_string(), name: one.name.to_string(), start, next }
}

/// The context with names for its holes that no metavariable in it has.
fn holes(shape: &Term, count: usize) -> (Term, Vec<String>) {
    let taken = metavariables(shape);
    let mut stem = "?H".to_string();
    while taken.iter().any(|name| name.as_str().starts_with(&stem)) {
        stem.push('h');
    }
    let names: Vec<String> = (1..=count).map(|number| format!("{stem}{number}")).collect();
    let parts: BTreeMap<Name, Term> =
        names.iter().enumerate().map(|(index, name)| (hole(index + 1), Term::meta(&Name::new(name)))).collect();
    (fill(shape, &parts), names)
}

fn substitution(with: &Substitution) -> SubstitutionText {
    fn texts<T: ToString>(map: &BTreeMap<Name, T>) -> BTreeMap<String, String> {
        map.iter().map(|(name, image)| (name.to_string(), image.to_string())).collect()
    }
    SubstitutionText {
        processes: texts(&with.processes),
        values: texts::<Value>(&with.values),
        names: texts(&with.names),
        sets: with
            .sets
            .iter()
            .map(|(name, set)| (name.to_string(), set.iter().map(Name::to_string).collect()))
            .collect(),
    }
}
