//! What is asked of a user's law before it is in force: that it is new, ends, holds in its examples, and that no small
//! instance contradicts it.

use std::collections::BTreeSet;

use crate::assumption::Assumptions;
use crate::definition::Definitions;
use crate::diagnostic::{Diagnostic, Span};
use crate::explain::run_lines;
use crate::fact::Context;
use crate::kernel::Theory;
use crate::law::{Condition, Connective, Law, Laws};
use crate::name::Name;
use crate::proof::Statement;
use crate::prove::{Answer, By, prove};
use crate::refute::{self, Limits, Refutation};
use crate::rewrite;
use crate::scope::{bound_names, condition_metavariables, metavariables, subterms};
use crate::simplify::Simplifier;
use crate::substitution::Substitution;
use crate::term::Term;
use crate::value::Value;

/// A warning, if there is one; what is wrong with the law otherwise.
pub type Admitted = Result<Option<Diagnostic>, Box<Diagnostic>>;

/// Instances tried on the model for each law.
const INSTANCES: usize = 2_000;

/// Looks at a law that is to come in force after `laws`, which stands at `span`. A law that could be tried on nothing
/// comes in force with a warning.
///
/// # Errors
/// What is wrong with it.
pub fn admit(laws: &Laws, law: &Law, span: Span, interrupted: &dyn Fn() -> bool) -> Admitted {
    let refuse = |code, message: String| Diagnostic::error(code, message).label(span, "this law");
    if let Some(other) = laws.iter().find(|other| other.name != law.name && renames(law, other)) {
        let message = format!("the law `{}` says the same as `{}`", law.name, other.name);
        return Err(Box::new(refuse("P0904", message).help("leave it out; the other is in force already")));
    }
    if law.oriented && endless_term(laws, law, interrupted).is_some() {
        let message = format!("with the law `{}` simplification does not end", law.name);
        let advice = "write `=` in place of `=>`: then it is used in proofs, but not to simplify";
        return Err(Box::new(refuse("P0903", message).help(advice)));
    }
    let limits = Limits { instances: INSTANCES, choices: 50 * INSTANCES, ..Limits::default() };
    let judged = refute::judge(law, &limits);
    if let Some(found) = judged.counterexample() {
        let message = format!("the law `{}` does not hold", law.name);
        let told = run_lines(found, law.connective);
        let diagnostic = told
            .into_iter()
            .fold(refuse("P0906", message), Diagnostic::note)
            .help("add the condition under which it holds, with `when`");
        return Err(Box::new(diagnostic));
    }
    for (left, right) in &law.examples {
        if !follows(laws, law, left, right, interrupted) {
            let message = format!("an example of the law `{}` does not follow from it", law.name);
            let example = format!("cannot prove {left} {} {right} by it", law.connective);
            return Err(Box::new(refuse("P0905", message).note(example)));
        }
    }
    let warning = fits_nothing(law).or_else(|| untried(law, &judged));
    Ok(warning.map(|message| Diagnostic::warning("P0924", message).label(span, "this law")))
}

/// Why no process is found to be an instance of a law: values that stand only in sums or products with each other are not
/// told apart. None where one is, on a side that the law is used from.
fn fits_nothing(law: &Law) -> Option<String> {
    let found_by_condition = law.conditions.iter().any(|condition| matches!(condition, Condition::Lasts(..)));
    let backwards = !law.oriented && law.connective.is_symmetric();
    let left = undetermined(&law.left);
    if left.is_empty() || found_by_condition || (backwards && undetermined(&law.right).is_empty()) {
        return None;
    }
    let names: Vec<&str> = left.iter().map(Name::as_str).collect();
    Some(format!(
        "the law `{}` fits nothing: in {} no value is that of {} alone, nor linear in it with the others known",
        law.name,
        law.left,
        names.join(" or ")
    ))
}

/// The metavariables that stand in values of a pattern, and that no value of an instance determines, one after the other.
fn undetermined(pattern: &Term) -> BTreeSet<Name> {
    let values: Vec<&Value> = subterms(pattern).flat_map(Term::values).collect();
    let mut open: BTreeSet<Name> = values.iter().flat_map(|value| value.variables()).filter(Name::is_meta).collect();
    // A result that a process binds is found as a name.
    bound_names(pattern).iter().for_each(|name| {
        open.remove(name);
    });
    loop {
        let before = open.len();
        for value in &values {
            let unknown: Vec<Name> = value.variables().into_iter().filter(|name| open.contains(name)).collect();
            if let [only] = unknown.as_slice()
                && value.linear_in(only).is_some()
            {
                open.remove(only);
            }
        }
        if open.len() == before {
            return open;
        }
    }
}

/// Why nothing speaks for a law that nothing speaks against; none where instances were tried.
pub fn untried(law: &Law, judged: &Refutation) -> Option<String> {
    let Refutation::None { instances, meaningless, .. } = judged else { return None };
    let (name, few) = (&law.name, meaningless == instances);
    match instances {
        0 => Some(format!("the law `{name}` was tried on nothing: no small instance meets its conditions")),
        1 if few => Some(format!("the law `{name}` was tried on nothing: its only small instance has no meaning")),
        _ if few => Some(format!(
            "the law `{name}` was tried on nothing: none of its {instances} small instances has a meaning"
        )),
        _ => None,
    }
}

/// Whether the law alone, after the units, proves the example.
fn follows(laws: &Laws, law: &Law, left: &Term, right: &Term, interrupted: &dyn Fn() -> bool) -> bool {
    let theory = Theory { laws: with(laws, law), ..Theory::default() };
    let statement =
        Statement { hypotheses: Vec::new(), left: left.clone(), connective: law.connective, right: right.clone() };
    let names = [law.name.clone()];
    let limits = rewrite::Limits::default();
    let alone = prove(&theory, &statement, &By::Laws(&names), limits, interrupted);
    matches!(alone, Answer::Proved(..))
        || matches!(prove(&theory, &statement, &By::Search, limits, interrupted), Answer::Proved(..))
}

fn with(laws: &Laws, law: &Law) -> Laws {
    let mut laws = laws.clone();
    if laws.get(&law.name).is_none() {
        laws.push(law.clone());
    }
    laws
}

/// A term whose simplification goes on with the law, where it ends without it.
pub fn endless_term(laws: &Laws, law: &Law, interrupted: &dyn Fn() -> bool) -> Option<Term> {
    let mut terms = vec![&law.left, &law.right];
    terms.extend(law.examples.iter().flat_map(|(left, right)| [left, right]));
    let theory = Theory { laws: with(laws, law), ..Theory::default() };
    terms.into_iter().find(|term| endless(&theory, law, term, interrupted)).cloned()
}

/// In stages, so that a law that doubles its term is caught while the term is small.
fn endless(theory: &Theory, law: &Law, term: &Term, interrupted: &dyn Fn() -> bool) -> bool {
    let context = Context::new(&theory.assumptions, &theory.definitions, &law.conditions);
    for fuel in [12, 200, 4_000] {
        let mut simplifier = Simplifier::new(theory, &context, interrupted).with_fuel(fuel);
        if law.connective == Connective::Weak {
            simplifier = simplifier.weakly(None);
        }
        let found = simplifier.simplify(term);
        if !simplifier.exhausted() {
            return false;
        }
        if found.term.size() > 1_000 + 50 * term.size() {
            return true;
        }
    }
    true
}

/// Whether one law is the other with its metavariables renamed.
fn renames(law: &Law, other: &Law) -> bool {
    law.connective == other.connective
        && law.oriented == other.oriented
        && law.conditions.len() == other.conditions.len()
        && canonical(law) == canonical(other)
}

/// The law with its metavariables numbered in the order in which they are first written.
fn canonical(law: &Law) -> Option<(Term, Term, Vec<Condition>)> {
    let mut order: Vec<Name> = Vec::new();
    let written = format!("{} {}", law.left, law.right);
    for piece in written.split('?').skip(1) {
        let end = piece.find(|letter: char| !letter.is_alphanumeric() && letter != '_').unwrap_or(piece.len());
        let name = Name::new(&format!("?{}", piece.get(..end).unwrap_or("")));
        if !order.contains(&name) {
            order.push(name);
        }
    }
    let mut all = metavariables(&law.left);
    all.extend(law.conditions.iter().flat_map(condition_metavariables));
    order.extend(all.into_iter().filter(|name| !order.contains(name)).collect::<Vec<_>>());
    let mut renaming = Substitution::default();
    for (number, name) in order.into_iter().enumerate() {
        let upper = name.as_str().chars().nth(1).is_some_and(char::is_uppercase);
        let fresh = Name::new(&format!("?{}{number}", if upper { 'P' } else { 'x' }));
        renaming.processes.insert(name.clone(), Term::meta(&fresh));
        renaming.values.insert(name.clone(), Value::variable(&fresh));
        renaming.names.insert(name.clone(), fresh.clone());
        renaming.sets.insert(name, [fresh].into());
    }
    let (assumptions, definitions) = (Assumptions::default(), Definitions::default());
    let context = Context::new(&assumptions, &definitions, &[]);
    let left = renaming.apply(&law.left, &context).ok()?;
    let right = renaming.apply(&law.right, &context).ok()?;
    let conditions: Result<Vec<Condition>, _> =
        law.conditions.iter().map(|condition| renaming.condition(condition, &context)).collect();
    let mut conditions = conditions.ok()?;
    conditions.sort();
    Some((left, right, conditions))
}
