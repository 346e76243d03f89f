//! A run that is not what a property asks for, whatever the durations.

use std::collections::{BTreeMap, BTreeSet};

use super::claim::Found;
use crate::lasso::{After, Lasso, Misfit, Stretch, misfit};
use crate::lower::{Environment, Property, System};
use crate::name::Name;
use crate::report::Verdict;
use crate::sample::close;
use crate::scope::{read_names, subterms};
use crate::term::{Node, Term};
use crate::value::Value;
use crate::verify::property::Wanted;
use crate::verify::{self, Outcome};

/// Stretches of the run that are printed.
const MOST_PRINTED: usize = 12;

/// Refutes the claim, if a run of the system in the executable meaning cannot fit the property. Parameters without a
/// value are given one that meets what is assumed of them: the claim is made for all of those.
pub(super) fn contradict(
    system: &System,
    property: &Property,
    outcome: &Outcome,
    environment: &Environment,
    interrupted: &dyn Fn() -> bool,
    found: &mut Found,
) {
    let Some(body) = &property.body else { return };
    let Ok(wanted) = Wanted::of(body, &property.name) else { return };
    let whole = system.alone(&environment.definitions);
    // The parameters of the property need values too; beside the system they are found with its own.
    let asked = property_parameters(body, environment);
    let beside = Term::new(Node::Observe(Name::new("Asked"), asked));
    let values = match close(&Term::par([whole.clone(), beside]), environment, &[]) {
        Ok(closed) => closed.values,
        Err(why) => {
            // What could be given by hand is nothing to do here.
            let why = why.split(';').next().unwrap_or_default();
            found.trace.push(format!("no run was looked at: {why}"));
            return;
        }
    };
    let given: Vec<(Name, Value)> = values.iter().map(|(name, value, _)| (name.clone(), value.clone())).collect();
    let Ok(closed) = close(&whole, environment, &given) else { return };
    let given: BTreeMap<Name, Value> = given.into_iter().collect();
    let shown: BTreeSet<Term> = wanted.wants.iter().flat_map(|want| want.shown.iter().cloned()).collect();
    let lasso = Lasso::of(&closed.term, &closed.definitions, interrupted);
    if interrupted() {
        return;
    }
    let lasso = lasso.with_last_legs(outcome, &wanted, &given);
    let Some(misfit) = misfit(&lasso, &wanted, &given) else { return };
    found.verdict = Some(Verdict::Refuted);
    let why = std::mem::take(&mut found.remains);
    let refuted = matches!(outcome.verdict, verify::Verdict::Refuted { .. });
    let word = if refuted { "it does not" } else { "note" };
    found.trace.extend(why.into_iter().map(|line| format!("{word}: {line}")));
    if !given.is_empty() {
        let chosen: Vec<String> = given.iter().map(|(name, value)| format!("{name} = {value}")).collect();
        found.trace.push(format!("take {}", chosen.join(", ")));
    }
    found.trace.push(text(&misfit, &lasso));
    found.trace.push("the run:".to_string());
    let names: BTreeSet<Name> = shown.iter().filter_map(observer).collect();
    found.trace.extend(run_lines(&lasso.stretches, &names));
}

fn property_parameters(body: &Term, environment: &Environment) -> Vec<Value> {
    let parameter = |name: &Name| environment.quantity(name).is_some();
    let names: BTreeSet<Name> = subterms(body).flat_map(read_names).filter(parameter).collect();
    names.iter().map(Value::variable).collect()
}

fn observer(term: &Term) -> Option<Name> {
    match term.node() {
        Node::Observe(name, _) => Some(name.clone()),
        _ => None,
    }
}

fn text(misfit: &Misfit, lasso: &Lasso) -> String {
    let Misfit { time, asked, shown, repeats } = misfit;
    if *repeats && lasso.bounded {
        return format!("from time {time} on nothing that the run may show is what is asked, whatever the durations");
    }
    if *repeats {
        return format!(
            "from time {time} on the run repeats, and whatever the durations are, what is asked does not fit it"
        );
    }
    let shown = match shown {
        None if lasso.after == After::TimeStop => "time stops".to_string(),
        None => "the run has ended".to_string(),
        Some(shown) if shown.is_empty() => "nothing is shown".to_string(),
        Some(shown) => format!("{} is shown", shown.join(" with ")),
    };
    let asked = if asked.is_empty() { "more time".to_string() } else { asked.clone() };
    format!("no durations fit beyond time {time}: {asked} is asked for then, and {shown}")
}

fn run_lines(stretches: &[Stretch], names: &BTreeSet<Name>) -> Vec<String> {
    let mut time = num_rational::BigRational::from_integer(0.into());
    let mut lines = Vec::new();
    for stretch in stretches.iter().take(MOST_PRINTED) {
        let shown = stretch.shown.iter().filter(|(name, _)| names.is_empty() || names.contains(name));
        let shown = shown
            .filter_map(|(name, values)| Some(Term::new(Node::Observe(name.clone(), values.clone()?)).to_string()));
        lines.push(format!("  at {time}: {}", shown.collect::<Vec<_>>().join(", ")));
        time += &stretch.duration;
    }
    lines
}
