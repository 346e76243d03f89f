//! What is asked of where a condition of an index fails.

use super::super::orders::{first_index, in_orders};
use super::checked::no_earlier_of;
use super::{also, found_lines, proof};
use crate::assumption::Assumptions;
use crate::closed_form::{Comparison, Solved, as_it_stands};
use crate::lower::Question;
use crate::recurrence::{Reach, solve_until};
use crate::value::{Relation, Value};

/// How often what a case leaves out is asked anew.
pub(in crate::session) const MOST_LEVELS: usize = 2;

/// An index of the terms of a question, with their forms, and how often what it leaves out is asked.
pub(in crate::session) struct Asked<'a> {
    pub(in crate::session) question: &'a Question,
    pub(in crate::session) goal: (Relation, &'a Value, &'a Value),
    pub(in crate::session) forms: &'a Solved,
    pub(in crate::session) levels: usize,
}

/// An index with its conditions, how it was checked, and what is so where one of these fails.
pub(in crate::session) fn with_otherwise(
    found: &Reach,
    asked: &Asked<'_>,
    also: Vec<String>,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Vec<String> {
    let recurrence = asked.forms.recurrence();
    let mut lines = found_lines(found, recurrence, &asked.question.goal(asked.goal));
    let never = is_never_otherwise(found, asked, known, stop);
    lines.extend(never.then(|| "else never".to_string()));
    lines.extend(also);
    lines.extend(no_earlier_of(found, asked, known));
    if let Reach::At(_, conditions) = found
        && !never
        && asked.levels > 0
    {
        lines.extend(where_one_fails(conditions, asked, known, stop));
    }
    lines
}

/// Whether there is no such index where one of its conditions fails, for each of them.
fn is_never_otherwise(found: &Reach, asked: &Asked<'_>, known: &Assumptions, stop: &dyn Fn() -> bool) -> bool {
    let (Reach::At(_, conditions), recurrence) = (found, asked.forms.recurrence()) else { return false };
    let fails = |(relation, left, right): &Comparison| {
        let mut known = known.clone();
        known.assume(relation.negated(), left, right);
        let solved = solve_until(recurrence.clone(), &known, stop);
        // What the forms need there must be known there, or be said of the forms already.
        let needed = solved.iter().flat_map(|solved| solved.conditions());
        let granted = |condition: &Comparison| {
            let (relation, left, right) = condition;
            asked.forms.conditions().contains(condition) || known.decide(*relation, left, right) == Some(true)
        };
        needed.into_iter().all(granted)
            && matches!(first_index(asked.question, solved.as_ref().ok(), asked.goal, &known, stop), Reach::Never(_))
    };
    !conditions.is_empty() && conditions.iter().all(fails)
}

/// The answer where a condition fails, for each of them, whether or not the others hold; nothing where it then has no value.
fn where_one_fails(
    conditions: &[Comparison],
    asked: &Asked<'_>,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Vec<String> {
    let mut lines = Vec::new();
    for (relation, left, right) in conditions {
        let mut known = known.clone();
        known.assume(relation.negated(), left, right);
        if known.contradictory() || !has_value(asked, &known) {
            continue;
        }
        lines.push(format!("if {}:", as_it_stands(&(relation.negated(), left.clone(), right.clone()))));
        lines.extend(answer_there(asked, &known, stop).into_iter().map(|line| format!("  {line}")));
    }
    lines
}

/// Whether what is asked, and what the terms are made of, is not known to have no value.
fn has_value(asked: &Asked<'_>, known: &Assumptions) -> bool {
    let sequences = || asked.forms.recurrence().sequences.iter();
    let values = sequences().flat_map(|sequence| sequence.start.iter().chain([&sequence.next]));
    let values = values.chain([asked.goal.1, asked.goal.2]);
    values.flat_map(Value::needs).all(|need| known.grants(&need) != Some(false))
}

/// The answer where this is known, without the forms, which are told already.
fn answer_there(asked: &Asked<'_>, known: &Assumptions, stop: &dyn Fn() -> bool) -> Vec<String> {
    let recurrence = asked.forms.recurrence();
    let (relation, left, right) = asked.goal;
    let question = Question {
        recurrence: recurrence.clone(),
        find: Some((relation, left.clone(), right.clone())),
        ..asked.question.clone()
    };
    let solved = solve_until(recurrence.clone(), known, stop);
    let found = first_index(&question, solved.as_ref().ok(), asked.goal, known, stop);
    let lines = match (&found, &solved) {
        (Reach::Unknown(unknown), _) => in_orders(&question, solved.as_ref(), (unknown, asked.levels - 1), known, stop)
            .map_or_else(|| found_lines(&found, recurrence, &question.goal(asked.goal)), |found| found.lines),
        (_, Ok(forms)) => {
            let asked = Asked { question: &question, forms, levels: asked.levels - 1, ..*asked };
            with_otherwise(&found, &asked, also(forms, &found, known), known, stop)
        }
        (_, Err(_)) => found_lines(&found, recurrence, &question.goal(asked.goal)),
    };
    let told: Vec<String> = asked.forms.lines().into_iter().chain([proof(recurrence)]).collect();
    lines.into_iter().filter(|line| !told.iter().any(|told| told == line.trim_start())).collect()
}
