//! A proof file as a theory and a proof. Nothing in the file is believed.

use std::collections::{BTreeMap, HashMap};

use super::text::{self, Moving as MovingText, Step as StepText};
use super::{FORMAT, MOST_BYTES, MOST_STEPS, MOST_TEXT, Rejection, body, last_line};
use crate::kernel::Theory;
use crate::law::Condition;
use crate::lower::{Environment, Lowered};
use crate::name::Name;
use crate::parser::{parse, parse_condition, parse_term, parse_value};
use crate::proof::{Lemma, Moving, Proof, Statement, Step, hole};
use crate::scope::{bound_names, fill};
use crate::substitution::Substitution;
use crate::term::Term;
use crate::value::Value;

/// The theory and the proof of a file, over an environment with the program's own laws.
pub(super) fn read(environment: Environment, file: &text::File) -> Result<(Theory, Proof), Rejection> {
    let mut reader = Reader { environment, terms: HashMap::new() };
    reader.declare("the declarations", &file.theory.declarations)?;
    reader.declare("the rules", &file.theory.rules)?;
    if reader.environment.assumptions.contradictory() {
        return Err(Rejection::new("the assumptions contradict each other"));
    }
    let mut lemmas = Vec::with_capacity(file.lemmas.len());
    for lemma in &file.lemmas {
        let (statement, steps) = reader.proved(&lemma.claim, &lemma.steps)?;
        lemmas.push(Lemma { name: identifier(&lemma.name)?, statement, steps });
    }
    let (statement, steps) = reader.proved(&file.claim, &file.steps)?;
    let environment = reader.environment;
    let theory = Theory {
        assumptions: environment.assumptions.clone(),
        definitions: environment.definitions.clone(),
        laws: environment.laws.clone(),
    };
    Ok((theory, Proof { lemmas, statement, steps }))
}

/// The file as JSON, its size and its seal in order.
pub(super) fn open(bytes: &[u8]) -> Result<text::File, Rejection> {
    if bytes.len() > MOST_BYTES {
        return Err(Rejection::new(format!("the file has more than {} MiB", MOST_BYTES >> 20)));
    }
    let text = std::str::from_utf8(bytes).map_err(|_| Rejection::new("the file is not UTF-8 text"))?;
    let body = body(bytes).ok_or_else(|| Rejection::new("the file has no seal: it is cut off, or no proof file"))?;
    if bytes.get(body.len()..) != Some(last_line(body).as_bytes()) {
        return Err(Rejection::new("the seal does not fit: the file was changed after it was written"));
    }
    let file: text::File = serde_json::from_str(text).map_err(|error| Rejection::new(error.to_string()))?;
    if file.format != FORMAT {
        return Err(Rejection::new(format!("the format is not `{FORMAT}`")));
    }
    let steps = file.lemmas.iter().fold(file.steps.len(), |all, lemma| all.saturating_add(lemma.steps.len()));
    if steps > MOST_STEPS {
        return Err(Rejection::new(format!("the proof has more than {MOST_STEPS} steps")));
    }
    Ok(file)
}

struct Reader {
    environment: Environment,
    terms: HashMap<String, Term>,
}

impl Reader {
    /// Takes in declarations; claims and imports have no place in a proof file.
    fn declare(&mut self, what: &str, text: &str) -> Result<(), Rejection> {
        let parsed = parse(text);
        if !parsed.diagnostics.is_empty() {
            return Err(Rejection::within(what, text, &parsed.diagnostics));
        }
        for outcome in self.environment.declare(&parsed.items, text) {
            match outcome {
                Ok(Lowered::Declared { redefined, .. }) if redefined.is_empty() => {}
                Ok(Lowered::Law(_)) => {}
                Ok(Lowered::Declared { redefined, .. }) => {
                    let names: Vec<&str> = redefined.iter().map(Name::as_str).collect();
                    return Err(Rejection::new(format!("{what} declare {} again", names.join(", "))));
                }
                Ok(_) => return Err(Rejection::new(format!("{what} hold more than declarations"))),
                Err(diagnostics) => return Err(Rejection::within(what, text, &diagnostics)),
            }
        }
        Ok(())
    }

    fn proved(&mut self, claim: &text::Claim, steps: &[StepText]) -> Result<(Statement, Vec<Step>), Rejection> {
        let when: Result<Vec<Condition>, Rejection> = claim.when.iter().map(|text| self.condition(text)).collect();
        let (left, right) = (self.term(&claim.left)?, self.term(&claim.right)?);
        let statement = Statement { hypotheses: when?, left, connective: claim.connective, right };
        let mut read = Vec::with_capacity(steps.len());
        for (number, step) in steps.iter().enumerate() {
            read.push(self.step(step).map_err(|rejection| Rejection::at(number, rejection.reason))?);
        }
        Ok((statement, read))
    }

    fn term(&mut self, text: &str) -> Result<Term, Rejection> {
        if let Some(term) = self.terms.get(text) {
            return Ok(term.clone());
        }
        limited(text)?;
        let term = parse_term(text).and_then(|written| self.environment.part(&written));
        let term = term.map_err(|diagnostics| Rejection::within("the term", text, &diagnostics))?;
        // Where a script binds such a name, it is kept apart: read as it stands here, it would be captured.
        if let Some(name) = bound_names(&term).into_iter().find(|name| self.environment.quantity(name).is_some()) {
            return Err(Rejection::new(format!("the term {text} binds {name}, which is declared as a value")));
        }
        self.terms.insert(text.to_string(), term.clone());
        Ok(term)
    }

    fn value(&self, text: &str) -> Result<Value, Rejection> {
        limited(text)?;
        let value = parse_value(text).and_then(|written| self.environment.value(&written));
        value.map_err(|diagnostics| Rejection::within("the value", text, &diagnostics))
    }

    fn condition(&self, text: &str) -> Result<Condition, Rejection> {
        limited(text)?;
        let condition = parse_condition(text).and_then(|written| self.environment.condition(&written));
        condition.map_err(|diagnostics| Rejection::within("the condition", text, &diagnostics))
    }

    fn substitution(&mut self, with: &text::Substitution) -> Result<Substitution, Rejection> {
        let mut found = Substitution::default();
        for (name, text) in &with.processes {
            found.processes.insert(metavariable(name)?, self.term(text)?);
        }
        for (name, text) in &with.values {
            found.values.insert(metavariable(name)?, self.value(text)?);
        }
        for (name, text) in &with.names {
            found.names.insert(metavariable(name)?, identifier(text)?);
        }
        for (name, set) in &with.sets {
            let set: Result<_, _> = set.iter().map(|name| identifier(name)).collect();
            found.sets.insert(metavariable(name)?, set?);
        }
        Ok(found)
    }

    fn step(&mut self, step: &StepText) -> Result<Step, Rejection> {
        Ok(match step {
            StepText::Reflexive { term } => Step::Reflexive(self.term(term)?),
            StepText::Symmetric { of } => Step::Symmetric(*of),
            StepText::Transitive { of } => Step::Transitive(of.clone()),
            StepText::Congruence { context, holes, of } => {
                if holes.len() != of.len() {
                    return Err(Rejection::new("there must be one hole for each step that is used"));
                }
                Step::Congruence(self.context(context, holes)?, of.clone())
            }
            StepText::Law { law, with } => Step::Law(Name::new(law), self.substitution(with)?),
            StepText::Arithmetic { left, right } => Step::Arithmetic(self.term(left)?, self.term(right)?),
            StepText::Unfold { call } => Step::Unfold(self.term(call)?),
            StepText::Unique { name, candidate, equation } => {
                Step::Unique { name: identifier(name)?, candidate: self.term(candidate)?, equation: *equation }
            }
            StepText::UniqueLoop { body, equation } => Step::UniqueLoop { body: self.term(body)?, equation: *equation },
            StepText::Suppose { left, right } => Step::Suppose(self.term(left)?, self.term(right)?),
            StepText::Induction { variable, left, right, base, successor } => Step::Induction {
                variable: identifier(variable)?,
                left: self.term(left)?,
                right: self.term(right)?,
                base: *base,
                step: *successor,
            },
            StepText::Instance { of, with } => Step::Instance(*of, self.substitution(with)?),
            StepText::Lemma { of, with } => Step::Lemma(*of, self.substitution(with)?),
            StepText::Advance { network, time } => {
                let time = time.as_ref().map(|time| self.value(time)).transpose()?;
                Step::Advance(self.term(network)?, time)
            }
            StepText::Draw { network, names } => {
                let names: Result<_, Rejection> = names.iter().map(|name| identifier(name)).collect();
                Step::Draw(self.term(network)?, names?)
            }
            StepText::Cases { when, holds, fails } => {
                Step::Cases { when: self.condition(when)?, holds: *holds, fails: *fails }
            }
            StepText::Excluded { left, right } => Step::Excluded(self.term(left)?, self.term(right)?),
            StepText::Rounds { lemma, variable, round, index, count } => Step::Rounds {
                lemma: *lemma,
                variable: metavariable(variable)?,
                round: self.term(round)?,
                index: identifier(index)?,
                count: self.value(count)?,
            },
            StepText::Turns { lemma, turn, moving } => {
                let moving: Result<_, Rejection> = moving.iter().map(|one| self.moving(one)).collect();
                Step::Turns { lemma: *lemma, turn: self.term(turn)?, moving: moving? }
            }
            StepText::Trust { left, connective: connects, right, reason } => {
                Step::Trust(self.term(left)?, *connects, self.term(right)?, reason.clone())
            }
        })
    }

    fn moving(&mut self, one: &MovingText) -> Result<Moving, Rejection> {
        let (start, next) = (self.value(&one.start)?, self.value(&one.next)?);
        Ok(Moving { variable: metavariable(&one.variable)?, name: identifier(&one.name)?, start, next })
    }

    fn context(&mut self, text: &str, holes: &[String]) -> Result<Term, Rejection> {
        let shape = self.term(text)?;
        let mut parts = BTreeMap::new();
        for (index, name) in holes.iter().enumerate() {
            if parts.insert(metavariable(name)?, Term::meta(&hole(index + 1))).is_some() {
                return Err(Rejection::new(format!("the hole {name} is named twice")));
            }
        }
        Ok(fill(&shape, &parts))
    }
}

fn limited(text: &str) -> Result<(), Rejection> {
    if text.len() > MOST_TEXT {
        return Err(Rejection::new(format!("a term has more than {MOST_TEXT} bytes")));
    }
    Ok(())
}

fn metavariable(text: &str) -> Result<Name, Rejection> {
    let name = identifier(text)?;
    if name.is_meta() { Ok(name) } else { Err(Rejection::new(format!("`{name}` is no metavariable"))) }
}

fn identifier(text: &str) -> Result<Name, Rejection> {
    let letters = text.strip_prefix('?').unwrap_or(text);
    let fine = letters.starts_with(char::is_alphabetic)
        && letters.chars().all(|letter| letter.is_alphanumeric() || letter == '_' || letter == '\'');
    if fine && text.len() < 1_000 { Ok(Name::new(text)) } else { Err(Rejection::new("a name is malformed")) }
}
