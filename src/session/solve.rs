//! `solve …`: the closed form with its conditions, how it was checked, and the first index that is looked for.

mod checked;
mod choices;
mod layout;
mod otherwise;
mod without_form;

use std::collections::BTreeMap;

use checked::no_earlier;
use choices::{choices, decided, required};
pub(super) use layout::in_layout;
pub(super) use layout::proof_of;
use layout::{is_title, proof, with_needs};
use otherwise::MOST_LEVELS;
pub(super) use otherwise::{Asked, with_otherwise};
use without_form::without_form;

use super::orders::{InOrders, by_first_legs, first_index, in_first_legs, in_orders};
use super::reading::Waiting;
use super::satisfies::cut;
use crate::assumption::Assumptions;
use crate::closed_form::{Case, Comparison, Form, Recurrence, Solved, compared, in_cases, needed, with_known_parts};
use crate::lower::{Expectation, Question};
use crate::name::Name;
use crate::recurrence::{
    InCase, Part, Reach, Resting, Special, Unknown, as_far_as, at_rest, behaviour, parameters, parts, reach, read_by,
    solve_in_cases, solve_until, special_cases,
};
use crate::report::Expected;
use crate::value::{Relation, Value};

/// The terms that are looked at for one that has no value.
const MOST_TO_REST: usize = 100;
/// The most conditions of parameters of which each case is looked at by itself.
const MOST_CHOICES: usize = 3;
/// The longest reason that is told whole, in characters.
const WIDEST: usize = 320;

/// The lines of the answer, and what came of the expectations, where the parameters are as the equations need them.
pub(super) fn answer(question: &Question, waiting: &Waiting, stop: &dyn Fn() -> bool) -> (Vec<String>, Vec<Expected>) {
    let known = &waiting.environment.assumptions;
    let (mut lines, expected) = chosen(question, (&waiting.expected, known), MOST_CHOICES, stop);
    lines.splice(0..0, question.notes.iter().cloned());
    (lines, expected)
}

/// The expectations with their texts, and what is known of the parameters.
type Given<'a> = (&'a [(Expectation, String)], &'a Assumptions);

/// The same, with what is known of the parameters: in each case of conditions of them by which the equations are chosen, as
/// far as these are so many at most. What the equations need is told where it is known that they do.
fn chosen(question: &Question, given: Given<'_>, most: usize, stop: &dyn Fn() -> bool) -> (Vec<String>, Vec<Expected>) {
    let (waiting, known) = given;
    let (mut question, mut known) = (question.clone(), known.clone());
    let mut needs = required(&mut question, &mut known, false);
    question = decided(&question, &known);
    let mut cases = if most > 0 { choices(&question, &known) } else { Vec::new() };
    if cases.is_empty() && !question.conditions.is_empty() {
        needs.extend(required(&mut question, &mut known, true));
        question = decided(&question, &known);
        cases = if most > 0 { choices(&question, &known) } else { Vec::new() };
    }
    let (lines, expected) = match cases.is_empty() {
        true => resting(&question, (waiting, &known), stop),
        false => in_choices(cases, (waiting, &known), most - 1, stop),
    };
    (with_needs(lines, &needs), expected)
}

/// The answer in each of these cases, with so many conditions more in each at most.
fn in_choices(
    cases: Vec<(Comparison, Question)>,
    (waiting, known): Given<'_>,
    most: usize,
    stop: &dyn Fn() -> bool,
) -> (Vec<String>, Vec<Expected>) {
    let mut told = Vec::new();
    let mut found: Vec<Vec<Expected>> = Vec::new();
    for ((relation, left, right), question) in cases {
        let mut known = known.clone();
        known.assume(relation, &left, &right);
        let (own, expected) = chosen(&question, (waiting, &known), most, stop);
        told.push((format!("if {}:", compared(&(relation, left, right))), own));
        found.push(expected);
    }
    let lines = in_layout(told, None);
    let met = |(place, (expectation, text)): (usize, &(Expectation, String))| {
        let mut each = found.iter().map(|case| case.get(place).is_some_and(|expected| expected.met));
        let met = if matches!(expectation, Expectation::Open) { each.any(|met| met) } else { each.all(|met| met) };
        Expected { text: text.clone(), met }
    };
    (lines, waiting.iter().enumerate().map(met).collect())
}

/// The same where nothing is chosen. Where an equation has no value once the terms are at a point, and no form for
/// that reason, they stay there, which is said.
fn resting(question: &Question, given: Given<'_>, stop: &dyn Fn() -> bool) -> (Vec<String>, Vec<Expected>) {
    let (_, known) = given;
    let solved = solve_until(question.recurrence.clone(), known, stop);
    let resting = if solved.is_err() { at_rest(&question.recurrence) } else { None };
    let Some((recurrence, resting)) = resting else { return answered(question, solved, None, given, stop) };
    let at_rest = solve_until(recurrence.clone(), known, stop);
    let orders = at_rest.as_ref().err().map(|reason| solve_in_cases(&recurrence, reason, known, stop));
    let there = Question { recurrence, ..question.clone() };
    let open = orders.as_ref().is_some_and(Vec::is_empty) && !comes_to_rest(&question.recurrence);
    if open && !in_first_legs(&there, known, stop) {
        return answered(question, solved, None, given, stop);
    }
    let (mut lines, expected) = answered(&there, at_rest, orders, given, stop);
    lines.splice(0..0, resting.iter().map(Resting::told));
    (lines, expected)
}

/// Whether a recurrence of numbers has no value soon.
fn comes_to_rest(recurrence: &Recurrence) -> bool {
    let terms = recurrence.terms();
    let own = |name: &Name| *name == recurrence.index || terms.iter().any(|(term, ..)| term == name);
    let numbers = recurrence
        .sequences
        .iter()
        .all(|one| one.start.iter().all(|start| start.variables().is_empty()) && one.next.variables().iter().all(own));
    numbers && recurrence.iterate(MOST_TO_REST).is_err()
}

/// The forms of the recurrence, or of its first legs where the first index that is asked for lies in them, and that index.
fn with_index(
    question: &Question,
    solved: Result<Solved, Unknown>,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> (Result<Solved, Unknown>, Option<Reach>) {
    let Some((relation, left, right)) = &question.find else { return (solved, None) };
    // Without forms the terms are looked at one by one, with symbols long.
    let symbolic = !parameters(&question.recurrence, left, right).is_empty();
    let in_legs = (symbolic && solved.is_err()).then(|| by_first_legs(question, known, stop));
    match in_legs {
        Some(Ok((forms, first))) => (Ok(forms), Some(first)),
        Some(Err(Some(why))) if question.since.is_some() => (solved, Some(Reach::Unknown(why))),
        in_legs => {
            let found = first_index(question, solved.as_ref().ok(), (*relation, left, right), known, stop);
            let found = match (found, in_legs) {
                (Reach::Unknown(_), Some(Err(Some(why)))) => Reach::Unknown(why),
                (found, _) => found,
            };
            (solved, Some(found))
        }
    }
}

/// The same, given the forms of the recurrence, or why there are none, and those in each case, where they were asked for.
fn answered(
    question: &Question,
    solved: Result<Solved, Unknown>,
    orders: Option<Vec<InCase<Solved>>>,
    (waiting, known): Given<'_>,
    stop: &dyn Fn() -> bool,
) -> (Vec<String>, Vec<Expected>) {
    let recurrence = &question.recurrence;
    let asked = question.find.as_ref().map(|(relation, left, right)| (*relation, left, right));
    let (solved, found) = with_index(question, solved, known, stop);
    if let Some(Reach::Unknown(unknown)) = &found
        && let Some(found) = in_orders(question, solved.as_ref(), (unknown, MOST_LEVELS), known, stop)
    {
        return in_each_order(found, question, solved.as_ref().ok(), (waiting, known), stop);
    }
    let orders = match &solved {
        Ok(_) => Vec::new(),
        Err(reason) => orders.unwrap_or_else(|| solve_in_cases(recurrence, reason, known, stop)),
    };
    let in_all = !orders.is_empty();
    let mut lines = match &solved {
        Ok(solved) => {
            let mut lines = solved.lines();
            lines.push(proof_of(solved));
            lines.extend(left_out(solved, (question, true), known, stop));
            lines
        }
        Err(_) if in_all => each_order(question, (recurrence, ""), orders.clone(), stop),
        Err(reason) => unsolved(question, reason, known, stop),
    };
    if let (Some(goal), Some(found)) = (asked, &found) {
        lines.extend(match &solved {
            Ok(forms) => {
                let asked = Asked { question, goal, forms, levels: MOST_LEVELS };
                with_otherwise(found, &asked, also(forms, found, known), known, stop)
            }
            Err(_) => {
                let told = found_lines(found, recurrence, &question.goal(goal));
                told.into_iter().chain(no_earlier(found, (recurrence, None), goal, known)).collect()
            }
        });
    }
    let solved = solved.ok();
    let met = |expectation: &Expectation| match expectation {
        Expectation::Open => match &found {
            Some(found) => matches!(found, Reach::Unknown(_)),
            None => solved.is_none() && !in_all,
        },
        Expectation::Never => matches!(found, Some(Reach::Never(_))),
        Expectation::Proved => (solved.is_some() || in_all) && !matches!(found, Some(Reach::Unknown(_))),
        Expectation::Values(values) => values.iter().all(|(name, value)| {
            let met = |solved, known| is_met(name, value, recurrence, solved, found.as_ref(), known);
            let in_each = || orders.iter().all(|case| met(Some(&case.found), &case.known));
            met(solved.as_ref(), known) || in_all && in_each()
        }),
        _ => false,
    };
    let expected = waiting.iter().map(|(expectation, text)| Expected { text: text.clone(), met: met(expectation) });
    (lines, expected.collect())
}

/// The same where an index was found in each order of two values, or in each case of something else.
fn in_each_order(
    found: InOrders,
    question: &Question,
    solved: Option<&Solved>,
    (waiting, known): Given<'_>,
    stop: &dyn Fn() -> bool,
) -> (Vec<String>, Vec<Expected>) {
    let InOrders { mut lines, recurrence: asked, found, merged, in_part } = found;
    // It is told with the forms: behind them where they are the same in each case, or behind all cases.
    let forms = lines.iter().position(|line| is_title(line)).filter(|before| *before > 0);
    if !in_part {
        lines.insert(forms.unwrap_or(lines.len()), proof(&asked));
    }
    if let Some(solved) = solved {
        lines.extend(left_out_of_all(&lines, solved, question, known, stop));
    }
    let recurrence = &question.recurrence;
    let met = |expectation: &Expectation| match expectation {
        Expectation::Never => found.iter().all(|(found, _)| matches!(found, Reach::Never(_))),
        Expectation::Proved => found.iter().all(|(found, _)| !matches!(found, Reach::Unknown(_))),
        Expectation::Open => found.iter().any(|(found, _)| matches!(found, Reach::Unknown(_))),
        Expectation::Values(values) => values.iter().all(|(name, value)| {
            let met =
                |found: Option<&Reach>, known: &Assumptions| is_met(name, value, recurrence, solved, found, known);
            let in_each = || found.iter().all(|(found, known)| met(Some(found), known));
            met(merged.as_ref(), known) || *name == recurrence.index && in_each()
        }),
        _ => false,
    };
    let expected = waiting.iter().map(|(expectation, text)| Expected { text: text.clone(), met: met(expectation) });
    (lines, expected.collect())
}

/// The same where the answer is told in cases, unless one of them tells it.
fn left_out_of_all(
    cases: &[String],
    solved: &Solved,
    question: &Question,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Vec<String> {
    let beside = left_out(solved, (question, true), known, stop);
    let told = |title: &String| cases.iter().any(|line| line.trim_start() == title);
    if beside.first().is_some_and(told) { Vec::new() } else { beside }
}

/// The forms for the parameters that the conditions leave out, with the first index that is looked for.
pub(super) fn left_out(
    solved: &Solved,
    (question, goal): (&Question, bool),
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Vec<String> {
    let mut lines = Vec::new();
    if solved.as_far().is_some() {
        return lines;
    }
    for special in special_cases(solved, known, stop) {
        let (recurrence, forms) = (special.solved.recurrence(), &special.solved);
        let mut own = forms.lines();
        own.push(proof(recurrence));
        own = with_needs(own, &still_required(&question.required, &special));
        if let (true, Some((relation, left, right))) = (goal, &question.find)
            && let [Some(left), Some(right)] = [left, right].map(|side| special.put_in(side))
        {
            let goal = (*relation, &left, &right);
            let found = reach(recurrence, Some(forms), goal, forms.known(), stop);
            let asked = Asked { question, goal, forms, levels: 0 };
            own.extend(with_otherwise(&found, &asked, also(forms, &found, forms.known()), forms.known(), stop));
        }
        lines.push(format!("where {}:", special.title()));
        lines.extend(own.into_iter().map(|line| format!("    {line}")));
    }
    lines
}

/// What the equations need beyond what is equal here, where it says anything.
fn still_required(required: &[Comparison], special: &Special) -> Vec<Comparison> {
    let here = |(relation, left, right): &Comparison| {
        let (left, right) = (special.put_in(left)?, special.put_in(right)?);
        Some((*relation, left, right))
    };
    let says =
        |(relation, left, right): &Comparison| Assumptions::default().decide(*relation, left, right) != Some(true);
    required.iter().map(|need| here(need).unwrap_or_else(|| need.clone())).filter(says).collect()
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
fn each_order(
    question: &Question,
    (recurrence, of): (&Recurrence, &str),
    orders: Vec<InCase<Solved>>,
    stop: &dyn Fn() -> bool,
) -> Vec<String> {
    let mut lines = vec![format!("one closed form{of} in each case:")];
    for case in orders {
        lines.push(format!("if {}:", case.title()));
        lines.extend(case.found.lines().into_iter().map(|line| format!("    {line}")));
        lines.push(format!("    {}", proof(recurrence)));
        lines.extend(
            left_out(&case.found, (question, false), &case.known, stop).into_iter().map(|line| format!("    {line}")),
        );
    }
    lines
}

/// That there are no forms, and what is known without.
fn unsolved(question: &Question, reason: &Unknown, known: &Assumptions, stop: &dyn Fn() -> bool) -> Vec<String> {
    let recurrence = &question.recurrence;
    let behaviour = behaviour(recurrence, known, stop);
    let parts = parts(recurrence, reason, known, stop);
    let told: Vec<Option<Vec<String>>> = parts.iter().map(|part| part_lines(part, question, known, stop)).collect();
    if told.iter().all(Option::is_none) {
        let mut lines = vec![format!("no closed form is known: {}", reason.reason)];
        // Where the last index is a number the terms say as much.
        let symbolic = |forms: &Solved| forms.as_far().is_some_and(|as_far| as_far.last.as_rational().is_none());
        if let Some(first_legs) = as_far_as(recurrence, known, stop).ok().filter(symbolic) {
            lines = vec![format!("no closed form is known for every {}; the first legs are these", recurrence.index)];
            lines.extend(first_legs.lines());
            lines.push(proof_of(&first_legs));
        }
        lines.extend(without_form(recurrence, &behaviour, |_| true));
        return lines;
    }
    let open: Vec<&Name> =
        parts.iter().zip(&told).filter(|(_, told)| told.is_none()).flat_map(|(part, _)| &part.names).collect();
    let mut lines = Vec::new();
    for (part, told) in parts.iter().zip(told) {
        lines.extend(told.unwrap_or_else(|| {
            let names: Vec<&str> = part.names.iter().map(Name::as_str).collect();
            let reason = part.found.as_ref().err().map(ToString::to_string).unwrap_or_default();
            vec![format!("no closed form of {} is known: {reason}", names.join(", "))]
        }));
    }
    lines.extend(without_form(recurrence, &behaviour, |name| open.contains(&name)));
    lines
}

/// The forms of some sequences, in each case if not at once; nothing where these have none.
fn part_lines(part: &Part, question: &Question, known: &Assumptions, stop: &dyn Fn() -> bool) -> Option<Vec<String>> {
    let recurrence = &question.recurrence;
    match &part.found {
        Ok(solved) => {
            let mut lines = solved.lines_of(&part.names);
            lines.push(proof(solved.recurrence()));
            Some(lines)
        }
        Err(reason) => {
            let terms: Vec<Value> = part.names.iter().map(|name| Value::variable(&recurrence.term(name, 0))).collect();
            // With all that they read.
            let alone = recurrence.only(&read_by(recurrence, &terms.iter().collect::<Vec<_>>())?);
            let cases = solve_in_cases(&alone, reason, known, stop);
            let names: Vec<&str> = alone.sequences.iter().map(|one| one.name.as_str()).collect();
            (!cases.is_empty())
                .then(|| each_order(question, (&alone, &format!(" of {}", names.join(", "))), cases, stop))
        }
    }
}

pub(super) fn found_lines(found: &Reach, recurrence: &Recurrence, goal: &str) -> Vec<String> {
    let index = &recurrence.index;
    match found {
        Reach::At(at, conditions) => {
            let first = format!("{index} = {at} is the first with {goal}");
            std::iter::once(first).chain(conditions.iter().map(needed)).collect()
        }
        Reach::Never(reason) => vec![format!("never {goal}: {}", cut(reason, WIDEST))],
        Reach::Unknown(Unknown { formula: Some(formula), .. }) => vec![
            format!("{index} = {} is the first with {goal}", formula.index),
            format!(
                "it is the least {index} with {}; this is told in words and not checked, as logarithms are no values here",
                formula.test
            ),
        ],
        Reach::Unknown(reason) if reason.has_no_value() => {
            vec![format!("there may be a first {index} with {goal}, but it is no value here: {reason}")]
        }
        Reach::Unknown(reason) => vec![format!("not known whether ever {goal}: {}", cut(&reason.to_string(), WIDEST))],
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
    // What comes after the last index of the forms is not as they say.
    let solved = solved.filter(|solved| solved.as_far().is_none());
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
                let cases = in_cases(value, &BTreeMap::new(), &known);
                let is = |case: &Case| case.known.decide(Relation::Eq, at, &case.value) == Some(true);
                cases.is_ok_and(|cases| cases.iter().all(is))
            }
            _ => false,
        };
    }
    let alone = name.as_str().strip_suffix(&format!("({})", recurrence.index)).map(Name::new);
    if let Some((place, _)) = recurrence.sequence(alone.as_ref().unwrap_or(name)) {
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
    // Without the cases that are excluded: a quotient may have a value in the others alone.
    let is = |term: &Value| known.decide(Relation::Eq, term, &known.simplify(value)) == Some(true);
    term.is_some_and(|term| is(&term) || with_known_parts(&term, known).is_some_and(|term| is(&term)))
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
