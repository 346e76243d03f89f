//! `solve …`: the closed form with its conditions, how it was checked, and the first index that is looked for.

use super::orders::{forms_in_orders, in_orders};
use super::reading::Waiting;
use crate::assumption::Assumptions;
use crate::closed_form::{Comparison, Form, Recurrence, Solved, needed};
use crate::lower::{Expectation, Question};
use crate::name::Name;
use crate::recurrence::{
    Behaviour, NO_VALUE, NoClosedForm, Part, Reach, Term, at_rest, behaviour, parts, reach, solve_until, special_cases,
};
use crate::report::Expected;
use crate::value::{Relation, Value};

/// The lines of the answer, and what came of the expectations. Where an equation has no value once the terms are at a point,
/// and no form for that reason, they stay there, which is said.
pub(super) fn answer(question: &Question, waiting: &Waiting, stop: &dyn Fn() -> bool) -> (Vec<String>, Vec<Expected>) {
    let known = &waiting.environment.assumptions;
    let solved = solve_until(question.recurrence.clone(), known, stop);
    let resting = if solved.is_err() { at_rest(&question.recurrence) } else { None };
    let Some((recurrence, distance, staying)) = resting else { return answered(question, solved, waiting, stop) };
    let at_rest = solve_until(recurrence.clone(), known, stop);
    if at_rest.is_err() {
        return answered(question, solved, waiting, stop);
    }
    let (mut lines, expected) = answered(&Question { recurrence, ..question.clone() }, at_rest, waiting, stop);
    let staying: Vec<&str> = staying.iter().map(Name::as_str).collect();
    let (verb, staying) = (if staying.len() == 1 { "is" } else { "are" }, staying.join(", "));
    lines.insert(0, format!("where {distance} = 0 the equation has no value: there {staying} {verb} taken to stay"));
    (lines, expected)
}

/// The same, given the forms of the recurrence, or why there are none.
fn answered(
    question: &Question,
    solved: Result<Solved, NoClosedForm>,
    waiting: &Waiting,
    stop: &dyn Fn() -> bool,
) -> (Vec<String>, Vec<Expected>) {
    let known = &waiting.environment.assumptions;
    let recurrence = &question.recurrence;
    if let Some(found) = in_orders(question, solved.as_ref().ok(), known, stop) {
        let mut lines = found.lines;
        lines.push(proof(recurrence));
        let met = |(expectation, text): &(Expectation, String)| {
            let met = match expectation {
                Expectation::Never => found.found.iter().all(|found| matches!(found, Reach::Never(_))),
                // It is told only where it is known in each order.
                Expectation::Proved => true,
                Expectation::Values(values) => values.iter().all(|(name, value)| {
                    is_met(name, value, recurrence, solved.as_ref().ok(), found.merged.as_ref(), known)
                }),
                _ => false,
            };
            Expected { text: text.clone(), met }
        };
        return (lines, waiting.expected.iter().map(met).collect());
    }
    let orders = match &solved {
        Ok(_) => Vec::new(),
        Err(_) => forms_in_orders(recurrence, known, stop).unwrap_or_default(),
    };
    let in_all = !orders.is_empty();
    let mut lines = match &solved {
        Ok(solved) => {
            let mut lines = solved.lines();
            lines.push(proof(recurrence));
            lines.extend(left_out(solved, question.find.as_ref(), known, stop));
            lines
        }
        Err(_) if in_all => each_order(recurrence, orders),
        Err(reason) => unsolved(recurrence, reason, known, stop),
    };
    let found = question.find.as_ref().map(|(relation, left, right)| {
        let found = reach(recurrence, solved.as_ref().ok(), (*relation, left, right), known, stop);
        lines.extend(found_lines(&found, recurrence, (*relation, left, right)));
        lines.extend(solved.iter().flat_map(|solved| also(solved, &found, known)));
        found
    });
    let solved = solved.ok();
    let met = |expectation: &Expectation| match expectation {
        Expectation::Open => match &found {
            Some(found) => matches!(found, Reach::Unknown(_)),
            None => solved.is_none() && !in_all,
        },
        Expectation::Never => matches!(found, Some(Reach::Never(_))),
        Expectation::Proved => (solved.is_some() || in_all) && !matches!(found, Some(Reach::Unknown(_))),
        Expectation::Values(values) => {
            values.iter().all(|(name, value)| is_met(name, value, recurrence, solved.as_ref(), found.as_ref(), known))
        }
        _ => false,
    };
    let expected =
        waiting.expected.iter().map(|(expectation, text)| Expected { text: text.clone(), met: met(expectation) });
    (lines, expected.collect())
}

/// The forms for the parameters that the conditions leave out, with the first index that is looked for.
fn left_out(
    solved: &Solved,
    find: Option<&(Relation, Value, Value)>,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Vec<String> {
    let mut lines = Vec::new();
    for special in special_cases(solved, known, stop) {
        let (recurrence, forms) = (special.solved.recurrence(), &special.solved);
        let mut own = forms.lines();
        own.push(proof(recurrence));
        if let Some((relation, left, right)) = find
            && let [Some(left), Some(right)] = [left, right].map(|side| special.put_in(side))
        {
            let goal = (*relation, &left, &right);
            let found = reach(recurrence, Some(forms), goal, forms.known(), stop);
            own.extend(found_lines(&found, recurrence, goal));
            own.extend(also(forms, &found, forms.known()));
        }
        lines.push(format!("where {}:", special.title()));
        lines.extend(own.into_iter().map(|line| format!("    {line}")));
    }
    lines
}

/// What the forms need, from which an index was found, beyond what was assumed and what is said of the index itself.
fn also(solved: &Solved, found: &Reach, known: &Assumptions) -> Vec<String> {
    let said = match found {
        Reach::At(_, conditions) => conditions.as_slice(),
        Reach::Never(_) => &[],
        Reach::Unknown(_) => return Vec::new(),
    };
    let open = |condition: &&Comparison| {
        let (relation, left, right) = condition;
        !said.contains(condition) && known.decide(*relation, left, right) != Some(true)
    };
    solved.conditions().iter().filter(open).map(needed).collect()
}

/// The forms in each order of two values.
fn each_order(recurrence: &Recurrence, orders: Vec<(String, Solved)>) -> Vec<String> {
    let mut lines = vec!["one closed form for each order:".to_string()];
    for (title, solved) in orders {
        lines.push(format!("if {title}:"));
        lines.extend(solved.lines().into_iter().map(|line| format!("    {line}")));
        lines.push(format!("    {}", proof(recurrence)));
    }
    lines
}

/// That there are no forms, and what is known without.
fn unsolved(
    recurrence: &Recurrence,
    reason: &NoClosedForm,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Vec<String> {
    let behaviour = behaviour(recurrence, known, stop);
    let parts = parts(recurrence, reason, known, stop);
    if parts.iter().all(|part| part.found.is_err()) {
        let mut lines = vec![format!("no closed form is known: {}", reason.0)];
        lines.extend(without_form(recurrence, &behaviour, |_| true));
        return lines;
    }
    let mut lines: Vec<String> = parts.iter().flat_map(part_lines).collect();
    let open = |name: &Name| parts.iter().any(|part| part.found.is_err() && part.names.contains(name));
    lines.extend(without_form(recurrence, &behaviour, open));
    lines
}

/// The forms of some sequences, or why these have none.
fn part_lines(part: &Part) -> Vec<String> {
    match &part.found {
        Ok(solved) => {
            let mut lines = solved.lines_of(&part.names);
            lines.push(proof(solved.recurrence()));
            lines
        }
        Err(reason) => {
            let names: Vec<&str> = part.names.iter().map(Name::as_str).collect();
            vec![format!("no closed form of {} is known: {}", names.join(", "), reason.0)]
        }
    }
}

/// How the forms were checked.
fn proof(recurrence: &Recurrence) -> String {
    let index = &recurrence.index;
    let starts = recurrence.sequences.iter().flat_map(|sequence| {
        let terms = sequence.start.iter().enumerate();
        terms.map(|(place, value)| format!("{}({}) = {value}", sequence.name, recurrence.from + place as i64))
    });
    let steps = recurrence
        .sequences
        .iter()
        .map(|sequence| format!("{} = {}", recurrence.term(&sequence.name, sequence.start.len()), sequence.next));
    let (starts, steps) = (starts.collect::<Vec<_>>().join(", "), steps.collect::<Vec<_>>().join(", "));
    format!("checked by induction on {index}: {starts}; for every {index} >= {}, {steps}", recurrence.from)
}

/// What is known without a form, of the sequences that have none.
fn without_form(recurrence: &Recurrence, behaviour: &Behaviour, open: impl Fn(&Name) -> bool) -> Vec<String> {
    let mut lines = Vec::new();
    if !behaviour.fixed_points.is_empty() {
        let points: Vec<String> = behaviour.fixed_points.iter().map(Value::to_string).collect();
        let word = if points.len() == 1 { "fixed point" } else { "fixed points" };
        let rest = if behaviour.all_fixed_points { "" } else { ", and others that are roots of higher degree" };
        lines.push(format!("{word} {}{rest}", points.join(" and ")));
    } else if behaviour.all_fixed_points {
        lines.push("it has no fixed point".to_string());
    }
    lines.extend(behaviour.motion.clone());
    let all = recurrence.sequences.iter().zip(&behaviour.terms);
    for (sequence, terms) in all.filter(|(sequence, _)| open(&sequence.name)) {
        let terms: Vec<String> = terms.iter().map(Term::text).collect();
        lines.push(format!("{} from {} on: {}, …", sequence.name, recurrence.from, terms.join(", ")));
    }
    lines
}

pub(super) fn found_lines(found: &Reach, recurrence: &Recurrence, goal: (Relation, &Value, &Value)) -> Vec<String> {
    let index = &recurrence.index;
    let goal = format!("{} {} {}", goal.1, goal.0.symbol(), goal.2);
    match found {
        Reach::At(at, conditions) => {
            let first = format!("{index} = {at} is the first with {goal}");
            std::iter::once(first).chain(conditions.iter().map(needed)).collect()
        }
        Reach::Never(reason) => vec![format!("never {goal}: {reason}")],
        Reach::Unknown(reason) if reason.ends_with(NO_VALUE) => {
            vec![format!("there is a first {index} with {goal}, but it is no value here: {reason}")]
        }
        Reach::Unknown(reason) => vec![format!("not known whether ever {goal}: {reason}")],
    }
}

/// Whether a named value came as expected: a form, a term, or the index that was looked for.
fn is_met(
    name: &Name,
    value: &Value,
    recurrence: &Recurrence,
    solved: Option<&Solved>,
    found: Option<&Reach>,
    known: &Assumptions,
) -> bool {
    let met = |name: &Name, value: &Value| is_met(name, value, recurrence, solved, found, known);
    if let Some(parts) = value.components() {
        let (base, at) = name.as_str().split_once('(').map_or((name.as_str(), None), |(base, at)| (base, Some(at)));
        let part = |place: usize| {
            let own = Name::new(base).component(place, parts.len());
            at.map_or(own.clone(), |at| Name::new(&format!("{own}({at}")))
        };
        return parts.iter().enumerate().all(|(place, value)| met(&part(place), value));
    }
    if *name == recurrence.index {
        return match found {
            Some(Reach::At(at, conditions)) => {
                let mut known = known.clone();
                conditions.iter().for_each(|(relation, left, right)| known.assume(*relation, left, right));
                known.decide(Relation::Eq, at, value) == Some(true)
            }
            _ => false,
        };
    }
    if let Some((place, _)) = recurrence.sequence(name) {
        return solved.is_some_and(|solved| same_form(place, value, recurrence, solved, known));
    }
    let Some((sequence, at)) = name.as_str().trim_end_matches(')').split_once('(') else { return false };
    let (Some((place, _)), Ok(at)) = (recurrence.sequence(&Name::new(sequence)), at.parse::<i64>()) else {
        return false;
    };
    let iterated = || {
        let count = usize::try_from(at.saturating_sub(recurrence.from)).ok().filter(|count| *count < 10_000)?;
        recurrence.iterate(count + 1).ok()?.get(place)?.get(count).cloned()
    };
    // In which piece a term lies may not be known where the term itself is.
    let term = solved.and_then(|solved| solved.at(&Name::new(sequence), at).ok()).or_else(iterated);
    let known = solved.map_or(known, Solved::known);
    term.is_some_and(|term| known.decide(Relation::Eq, &term, value) == Some(true))
}

/// Whether a form that was written down is right: by the same induction, or because it is the one that was found.
fn same_form(place: usize, value: &Value, recurrence: &Recurrence, solved: &Solved, known: &Assumptions) -> bool {
    let own = solved.forms()[place].value(&recurrence.index);
    if own.is_some_and(|own| solved.known().decide(Relation::Eq, &own, value) == Some(true)) {
        return true;
    }
    let mut forms = solved.forms().to_vec();
    forms[place] = Form::Value(Vec::new(), value.clone());
    Solved::check(recurrence.clone(), forms, solved.conditions().to_vec(), known).is_ok()
}
