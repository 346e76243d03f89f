//! A first index that depends on how two values lie to each other: the recurrence is solved in each order of them, and
//! where both orders give the same but for the side, that is written as one.

use super::solve::{Asked, found_lines, in_layout, left_out, proof_of, with_otherwise};
use crate::assumption::Assumptions;
use crate::closed_form::{Comparison, Recurrence, Solved, compared, holds_there, simpler};
use crate::lower::Question;
use crate::recurrence::{
    InCase, MOST_PAIRS, Reach, Unknown, as_far_as, either_way, lesser, pairs, parameters, reach, reach_since, read_by,
    solve_in_cases, solve_until,
};
use crate::value::{Relation, Value};
use crate::verify::Merge;

/// The answer in each order of two values.
pub(super) struct InOrders {
    pub(super) lines: Vec<String>,
    /// What was solved: all sequences, or those that the question reads.
    pub(super) recurrence: Recurrence,
    /// What was found in each, and what is known there.
    pub(super) found: Vec<(Reach, Assumptions)>,
    /// The same as one, where it can be written so.
    pub(super) merged: Option<Reach>,
    /// Whether some forms are not known for every index; then each case tells its proof.
    pub(super) in_part: bool,
}

/// One order: what is assumed, the forms, and what was found.
struct Case {
    order: Relation,
    known: Assumptions,
    solved: Solved,
    found: Reach,
}

/// The answer in each order of two values, or in each case of something else, where it is known there and open without,
/// for this reason; nothing if there is no such pair or case.
pub(super) fn in_orders(
    question: &Question,
    solved: Result<&Solved, &Unknown>,
    (unknown, levels): (&Unknown, usize),
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Option<InOrders> {
    let recurrence = &question.recurrence;
    let (_, left, right) = question.find.as_ref()?;
    let pairs = pairs(recurrence, left, right, known);
    let mut starts = recurrence.sequences.iter().flat_map(|sequence| &sequence.start);
    let of_numbers = starts.all(|start| start.variables().is_empty());
    if pairs.is_empty() && of_numbers && parameters(recurrence, left, right).is_empty() {
        return None;
    }
    let without = solved.err();
    // What has first legs and no form as a whole has hardly one in any order of two values: that is tried last.
    let in_legs = || without.is_some() && as_far_as(recurrence, known, stop).is_ok();
    let by_legs = || if in_legs() { in_cases((question, levels), (unknown, true), known, stop) } else { None };
    let by_order = || by_order((question, levels), &pairs, known, stop);
    // For a form, or with one for the index.
    let in_cases = || in_cases((question, levels), (without.unwrap_or(unknown), false), known, stop);
    let where_solved = || where_solved((question, levels), without?, known, stop);
    let of_those_read = || without.and_then(|_| of_those_read((question, levels), known, stop));
    best(&[&by_legs, &by_order, &of_those_read, &in_cases, &where_solved], stop)
}

/// The answer in each order of one of these pairs, where it is known in all of them.
fn by_order(
    (question, levels): (&Question, usize),
    pairs: &[(Value, Value)],
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Option<InOrders> {
    let (relation, left, right) = question.find.as_ref()?;
    pairs.iter().take(MOST_PAIRS).find_map(|(one, other)| {
        let orders = [Relation::Lss, Relation::Eq, Relation::Gtr].into_iter();
        let mut cases = Vec::new();
        for order in orders {
            if known.decide(order, one, other) == Some(false) {
                continue;
            }
            let mut known = known.clone();
            known.assume(order, one, other);
            let solved = solve_until(question.recurrence.clone(), &known, stop).ok()?;
            let found = first_index(question, Some(&solved), (*relation, left, right), &known, stop);
            if stop() || matches!(found, Reach::Unknown(_)) {
                return None;
            }
            cases.push(Case { order, known, solved, found });
        }
        told(&cases, (question, levels), (one, other), stop)
    })
}

/// The answer of those sequences alone that the question reads.
fn of_those_read(
    (question, levels): (&Question, usize),
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Option<InOrders> {
    let (relation, left, right) = question.find.as_ref()?;
    let recurrence = question.recurrence.only(&read_by(&question.recurrence, &[left, right])?);
    let fewer = recurrence.sequences.len() < question.recurrence.sequences.len();
    let question = Question { recurrence, ..question.clone() };
    let recurrence = &question.recurrence;
    let solved = solve_until(recurrence.clone(), known, stop);
    // With fewer sequences, or it is the same question.
    match first_index(&question, solved.as_ref().ok(), (*relation, left, right), known, stop) {
        Reach::Unknown(unknown) if fewer => in_orders(&question, solved.as_ref(), (&unknown, levels), known, stop),
        _ => None,
    }
}

/// Whether nothing is told of an index, not even a formula.
fn is_open(found: &Reach) -> bool {
    matches!(found, Reach::Unknown(unknown) if unknown.formula.is_none())
}

/// The first answer that is known in each case, or else the first.
fn best(answers: &[&dyn Fn() -> Option<InOrders>], stop: &dyn Fn() -> bool) -> Option<InOrders> {
    let known = |answer: &InOrders| !answer.found.iter().any(|(found, _)| is_open(found));
    let mut open = None;
    for answer in answers {
        match answer() {
            Some(answer) if known(&answer) => return Some(answer),
            answer => open = open.or(answer),
        }
        if stop() {
            break;
        }
    }
    open
}

/// The answer in either case of what would have to be known for it; it may be open in some of them.
fn in_cases(
    (question, levels): (&Question, usize),
    (unknown, in_legs): (&Unknown, bool),
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Option<InOrders> {
    let ask = |known: &Assumptions| match in_legs {
        true => by_first_legs(question, known, stop).or_else(|why| match why {
            Some(why) => Err((why, None)),
            None => answer_or_open(question, known, stop),
        }),
        false => answer_or_open(question, known, stop),
    };
    in_each(either_way(&question.recurrence, known, unknown, &ask, stop)?, (question, levels), stop)
}

/// The answer in each case of what the forms need, where there are forms in each case alone.
fn where_solved(
    (question, levels): (&Question, usize),
    reason: &Unknown,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Option<InOrders> {
    let mut cases = Vec::new();
    for case in solve_in_cases(&question.recurrence, reason, known, stop) {
        let (known, solved) = (case.known, case.found);
        match asked_there(question, Some(&solved), &known, stop)? {
            Reach::Unknown(unknown) => {
                let ask = |known: &Assumptions| answer_or_open(question, known, stop);
                match either_way(&question.recurrence, &known, &unknown, &ask, stop) {
                    Some(inner) => cases.extend(inner.into_iter().map(|inner| InCase {
                        assumed: case.assumed.iter().cloned().chain(inner.assumed).collect(),
                        ..inner
                    })),
                    None => {
                        let found = (solved, Reach::Unknown(unknown));
                        cases.push(InCase { assumed: case.assumed, known, found });
                    }
                }
            }
            found => cases.push(InCase { assumed: case.assumed, known, found: (solved, found) }),
        }
    }
    in_each(cases, (question, levels), stop)
}

fn asked_there(
    question: &Question,
    solved: Option<&Solved>,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Option<Reach> {
    let (relation, left, right) = question.find.as_ref()?;
    Some(first_index(question, solved, (*relation, left, right), known, stop))
}

/// The first index of what is looked for. Where one of several is to hold and it is not found of all at once it is the first of
/// theirs.
pub(super) fn first_index(
    question: &Question,
    solved: Option<&Solved>,
    goal: (Relation, &Value, &Value),
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Reach {
    let recurrence = solved.map_or(&question.recurrence, Solved::recurrence);
    let own = question.find.as_ref().is_some_and(|(relation, left, right)| goal == (*relation, left, right));
    let later = || {
        let (solved, (from, (relation, left, right))) = (solved?, question.since.as_ref().filter(|_| own)?);
        match reach_since(solved, *from, (*relation, left, right), known, stop)? {
            Reach::Unknown(Unknown { open: None, .. }) => None,
            found => Some(as_simple(found, known)),
        }
    };
    // The first legs end, and what is asked of them all would be looked for long.
    let in_part = solved.is_some_and(|solved| solved.as_far().is_some());
    if let Some(found) = in_part.then(later).flatten() {
        return found;
    }
    let found = as_simple(reach(recurrence, solved, goal, known, stop), known);
    if let (Reach::Unknown(_), false) = (&found, in_part)
        && let Some(later) = later()
    {
        return later;
    }
    if let (Reach::Unknown(_), Some(solved), true) = (&found, solved.filter(|_| own), !in_part)
        && let Some(found) = of_those_together(question, solved, known, stop)
    {
        return found;
    }
    if !matches!(found, Reach::Unknown(_)) || question.either.is_empty() || !own {
        return found;
    }
    let (mut first, mut reasons): (Option<Value>, Vec<String>) = (None, Vec::new());
    for (relation, left, right) in &question.either {
        match reach(recurrence, solved, (*relation, left, right), known, stop) {
            Reach::Never(why) => reasons.push(why),
            Reach::At(at, conditions) if conditions.is_empty() => {
                first = match first {
                    None => Some(at),
                    Some(other) => lesser(other, at, known),
                };
                if first.is_none() {
                    return found;
                }
            }
            Reach::Unknown(unknown) if unknown.open.is_some() => return Reach::Unknown(unknown),
            _ => return found,
        }
    }
    first.map_or_else(|| Reach::Never(reasons.join("; ")), |at| Reach::At(at, Vec::new()))
}

/// Where several are to hold together: one of them never does, or all do where one of them does first.
fn of_those_together(
    question: &Question,
    solved: &Solved,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Option<Reach> {
    let recurrence = solved.recurrence();
    question.together.iter().enumerate().find_map(|(place, (relation, left, right))| {
        match reach(recurrence, Some(solved), (*relation, left, right), known, stop) {
            Reach::At(at, conditions) if conditions.is_empty() => {
                all_there(question, solved, place, &at).then(|| as_simple(Reach::At(at, conditions), known))
            }
            Reach::Never(why) => Some(Reach::Never(why)),
            _ => None,
        }
    })
}

/// Whether all that are to hold together hold at an index, but for one of them, of which that is known.
pub(super) fn all_there(question: &Question, solved: &Solved, but: usize, at: &Value) -> bool {
    let holds = |(relation, left, right): &Comparison| holds_there(solved, (*relation, left, right), at) == Some(true);
    question.together.iter().enumerate().all(|(place, one)| place == but || holds(one))
}

/// An index and its conditions as simple as what is known makes them, and the conditions the index.
fn as_simple(found: Reach, known: &Assumptions) -> Reach {
    let Reach::At(at, conditions) = found else { return found };
    // That something is whole is read as it is written.
    let ordered = |relation: Relation| !matches!(relation, Relation::Eq | Relation::Neq);
    let simple = |one: &Comparison| if ordered(one.0) { simpler(one, known) } else { one.clone() };
    let open = |(relation, left, right): &Comparison| known.decide(*relation, left, right) != Some(true);
    let conditions: Vec<Comparison> = conditions.iter().map(simple).filter(open).collect();
    let mut there = known.clone();
    conditions.iter().for_each(|(relation, left, right)| there.assume(*relation, left, right));
    let simple = there.simplify(&at);
    let shorter = simple.size() < at.size() && !there.contradictory();
    Reach::At(if shorter { simple } else { at }, conditions)
}

/// The forms and what is found with them, or what is open.
fn answer_or_open(question: &Question, known: &Assumptions, stop: &dyn Fn() -> bool) -> Result<(Solved, Reach), Open> {
    let solved = match solve_until(question.recurrence.clone(), known, stop) {
        Ok(solved) => solved,
        Err(unknown) => {
            return by_first_legs(question, known, stop).map_err(|why| (why.unwrap_or(unknown), None));
        }
    };
    match asked_there(question, Some(&solved), known, stop) {
        Some(Reach::Unknown(unknown)) => Err((unknown.clone(), Some(Box::new((solved, Reach::Unknown(unknown)))))),
        Some(found) => Ok((solved, found)),
        None => Err((Unknown::because("nothing is asked"), None)),
    }
}

/// The forms as far as they are known, where that is far enough for the first index.
///
/// # Errors
/// What would have to be known for it, if it is not far enough for that reason.
pub(super) fn by_first_legs(
    question: &Question,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Result<(Solved, Reach), Option<Unknown>> {
    let forms = as_far_as(&question.recurrence, known, stop)?;
    let last = forms.as_far().map(|as_far| as_far.last.clone()).ok_or(None)?;
    match asked_there(question, Some(&forms), known, stop).ok_or(None)? {
        Reach::At(at, conditions) if conditions.is_empty() && known.decide(Relation::Lte, &at, &last) == Some(true) => {
            Ok((forms, Reach::At(at, conditions)))
        }
        Reach::Unknown(unknown) if unknown.open.is_some() => Err(Some(unknown)),
        _ => Err(None),
    }
}

/// Whether the first index lies in the first legs, or would if something of parameters were known.
pub(super) fn in_first_legs(question: &Question, known: &Assumptions, stop: &dyn Fn() -> bool) -> bool {
    question.find.is_some() && !matches!(by_first_legs(question, known, stop), Err(None))
}

/// What is not known, with what is all the same.
type Open = (Unknown, Option<Box<(Solved, Reach)>>);

/// What is told in each of these cases; nothing where it is known in none.
fn in_each(
    cases: Vec<InCase<(Solved, Reach)>>,
    (question, levels): (&Question, usize),
    stop: &dyn Fn() -> bool,
) -> Option<InOrders> {
    let recurrence = &question.recurrence;
    let (relation, left, right) = question.find.as_ref()?;
    let goal = (*relation, left, right);
    let mut told = Vec::new();
    let in_part = cases.iter().any(|case| case.found.0.as_far().is_some());
    for case in &cases {
        let (solved, found) = &case.found;
        let asked = Asked { question, goal, forms: solved, levels };
        let own = with_otherwise(found, &asked, Vec::new(), &case.known, stop);
        let proof = in_part.then(|| proof_of(solved));
        let beside = left_out(solved, (question, true), &case.known, stop);
        let own = solved.lines().into_iter().chain(proof).chain(own).chain(beside);
        told.push((case.assumed.clone(), own.collect()));
    }
    let forms = cases.first().map(|case| case.found.0.lines().len());
    let lines = in_layout(joined(told).into_iter().map(|(case, own)| (title(&case), own)).collect(), forms);
    let found: Vec<(Reach, Assumptions)> = cases.into_iter().map(|case| (case.found.1, case.known)).collect();
    let known = found.iter().any(|(found, _)| !is_open(found));
    known.then(|| InOrders { lines, recurrence: recurrence.clone(), found, merged: None, in_part })
}

fn told(
    cases: &[Case],
    (question, levels): (&Question, usize),
    (one, other): (&Value, &Value),
    stop: &dyn Fn() -> bool,
) -> Option<InOrders> {
    let recurrence = &question.recurrence;
    let (relation, left, right) = question.find.as_ref()?;
    let goal = (*relation, left, right);
    let own = |case: &Case| {
        let asked = Asked { question, goal, forms: &case.solved, levels };
        let own = with_otherwise(&case.found, &asked, Vec::new(), &case.known, stop);
        case.solved.lines().into_iter().chain(own).collect()
    };
    let forms = cases.first().map(|case| case.solved.lines().len());
    let told = cases.iter().map(|case| (vec![(case.order, one.clone(), other.clone())], own(case))).collect();
    let mut lines = in_layout(joined(told).into_iter().map(|(case, own)| (title(&case), own)).collect(), forms);
    let merged = merged(cases, one, other);
    if let Some(found) = &merged {
        let all = found_lines(found, recurrence, &question.goal(goal));
        lines.extend(
            all.into_iter().enumerate().map(
                |(place, line)| {
                    if place == 0 { format!("in every order: {line}") } else { line }
                },
            ),
        );
    }
    (!cases.is_empty()).then(|| InOrders {
        lines,
        recurrence: recurrence.clone(),
        found: cases.iter().map(|case| (case.found.clone(), case.known.clone())).collect(),
        merged,
        in_part: false,
    })
}

/// What is told of each case, where that is the same of `=` and of one side as one: of `>=` or `<=`.
fn joined(told: Vec<(Vec<Comparison>, Vec<String>)>) -> Vec<(Vec<Comparison>, Vec<String>)> {
    let mut all: Vec<(Vec<Comparison>, Vec<String>)> = Vec::new();
    for (case, lines) in told {
        let both = all.last().filter(|(_, before)| *before == lines).and_then(|(before, _)| either(before, &case));
        match (both, all.last_mut()) {
            (Some(both), Some(last)) => last.0 = both,
            _ => all.push((case, lines)),
        }
    }
    all
}

/// Two cases that differ in one relation, which is `=` in one of them, as one.
fn either(before: &[Comparison], case: &[Comparison]) -> Option<Vec<Comparison>> {
    let mut other = before.iter().zip(case).filter(|(one, other)| one != other);
    let (Some((one, two)), None, true) = (other.next(), other.next(), before.len() == case.len()) else { return None };
    let relation = match (one.0, two.0) {
        (Relation::Lss, Relation::Eq) | (Relation::Eq, Relation::Lss) => Relation::Lte,
        (Relation::Gtr, Relation::Eq) | (Relation::Eq, Relation::Gtr) => Relation::Gte,
        _ => return None,
    };
    let whole = (relation, one.1.clone(), one.2.clone());
    ((&one.1, &one.2) == (&two.1, &two.2))
        .then(|| before.iter().map(|own| if own == one { whole.clone() } else { own.clone() }).collect())
}

/// `if r0 < 3 and g > 2*a:`
fn title(case: &[Comparison]) -> String {
    format!("if {}:", case.iter().map(compared).collect::<Vec<_>>().join(" and "))
}

/// What was found in all orders, as one: it must be what was found in each, under what is assumed there.
fn merged(cases: &[Case], one: &Value, other: &Value) -> Option<Reach> {
    let of = |order: Relation| cases.iter().find(|case| case.order == order);
    let (below, above) = (of(Relation::Lss)?, of(Relation::Gtr)?);
    let merge = Merge { difference: one.sub(other).ok()?, above: above.known.clone(), below: below.known.clone() };
    let (Reach::At(first, before), Reach::At(second, after)) = (&above.found, &below.found) else { return None };
    let at = merge.values(first, second)?;
    if before.len() != after.len() {
        return None;
    }
    let pair = |((relation, left, right), (own, low, high)): (&Comparison, &Comparison)| {
        Some((*relation, merge.values(left, low)?, merge.values(right, high)?)).filter(|_| relation == own)
    };
    let conditions = before.iter().zip(after).map(pair).collect::<Option<Vec<Comparison>>>()?;
    // It must have a value in each of them.
    if !cases.iter().all(|case| case.known.gives_meaning(&at)) {
        return None;
    }
    // Where both are equal the conditions must hold, and the index be the same.
    let same = of(Relation::Eq).is_none_or(|equal| {
        let known = |value: &Value| equal.known.simplify(value);
        let met = |(relation, left, right): &Comparison| {
            equal.known.decide(*relation, &known(left), &known(right)) == Some(true)
        };
        let Reach::At(here, none) = &equal.found else { return false };
        none.is_empty()
            && conditions.iter().all(met)
            && equal.known.decide(Relation::Eq, &known(&at), here) == Some(true)
    });
    same.then_some(Reach::At(at, conditions))
}
