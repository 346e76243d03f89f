//! A first index in symbols is, for any numbers in their place, the one that the terms themselves show.

mod common;

use std::collections::BTreeMap;

use pars::assumption::Assumptions;
use pars::closed_form::{Comparison, Recurrence, Solved};
use pars::lower::Question;
use pars::name::Name;
use pars::recurrence::{Reach, reach, solve_until};
use pars::value::Value;

use common::*;

/// How often either case of what is not known is looked at.
const DEPTH: usize = 6;
/// The terms that are compared with each index, and the sets of numbers.
const TERMS: usize = 60;
const SETS: usize = 24;

/// Ways to move, of the parameters p, a, w, g and e.
const MOTIONS: [&str; 12] = [
    "x(n+1) = x(n)+w, x(0) = p",
    "x(n+1) = x(n)+a, x(0) = 0",
    "x(n+1) = x(n)+n+a, x(0) = p",
    "x(n+1) = x(n)-n/2+a, x(0) = 1",
    "x(n+1) = x(n)-w*n+2, x(0) = p",
    "x(n+1) = x(n)+clamp(g-x(n),-w,w), x(0) = p",
    "x(n+1) = x(n)+w*unit(g-x(n)), x(0) = 0",
    "x(n+1) = -x(n)+a, x(0) = p",
    "x(n+1) = min(x(n)+w,g), x(0) = p",
    "x(n+1) = max(x(n)-w,g), x(0) = 5",
    "x(n+1) = if x(n) < g then x(n)+w else x(n)-1/2, x(0) = p",
    "x(n+1) = max(x(n)+3-n/2,a), x(0) = p",
];

const GOALS: [&str; 9] = [
    "x(n) >= g",
    "x(n) < 3",
    "x(n) = g",
    "abs(x(n)-g) <= e",
    "abs(x(n)-4) < 1/2",
    "abs(x(n)-g) > 6",
    "x(n)^2 <= 20",
    "x(n)^2 >= 30",
    "x(n) > n+g",
];

/// Ways through the plane, with goals of their own.
const WAYS: [&str; 13] = [
    "x(n+1) = x(n)+3/5, y(n+1) = y(n)+4/5, x(0) = p, y(0) = a find n with norm((x(n),y(n))) <= 5",
    "x(n+1) = x(n)+3/5, y(n+1) = y(n)+4/5, x(0) = p, y(0) = a find n with norm((x(n),y(n))) >= 5",
    "x(n+1) = x(n)+w, y(n+1) = y(n), x(0) = p, y(0) = 3 find n with norm((x(n),y(n))) <= 7",
    "x(n+1) = x(n)+a, y(n+1) = y(n), x(0) = p, y(0) = 3 find n with norm((x(n)-1,y(n))) > 7",
    "x(n+1) = x(n)+w, y(n+1) = y(n)+a, x(0) = p, y(0) = g find n with x(n) >= y(n)",
    "x(n+1) = x(n)+w, y(n+1) = y(n)+2, x(0) = p, y(0) = g find n with max(abs(x(n)-3),abs(y(n)-1)) <= e",
    "x(n+1) = x(n)+1, y(n+1) = y(n)-w, x(0) = p, y(0) = g find n with abs(x(n))+abs(y(n)-1) <= e",
    "x(n+1) = x(n)+w, y(n+1) = y(n)-1, x(0) = p, y(0) = g find n with abs(x(n))+abs(y(n)-1) > e",
    "x(n+1) = x(n)+y(n), y(n+1) = y(n)+w, x(0) = p, y(0) = 0 find n with abs(x(n)-g) <= e",
    "x(n+1) = x(n)+y(n), y(n+1) = max(y(n)-w,0), x(0) = 0, y(0) = e find n with x(n) >= g",
    "x(n+1) = x(n)+y(n)/10, y(n+1) = y(n)+(w-x(n))/10-3/10*y(n), x(0) = 0, y(0) = 0 find n with x(n) >= w/2",
    "x(n+1) = x(n)+y(n)/2, y(n+1) = y(n)+(e-x(n))/2-y(n)/4, x(0) = 0, y(0) = 0 find n with abs(x(n)-e) <= e/9",
    "x(n+1) = x(n)+min(w,norm((g-x(n),a-y(n))))*3/5, y(n+1) = y(n)+min(w,norm((g-x(n),a-y(n))))*4/5, x(0) = g-3*e, y(0) = a-4*e find n with max(abs(x(n)-g),abs(y(n)-a)) <= 1",
];

/// What is found in each case of what would have to be known.
fn cases(question: &Question, known: &Assumptions, case: &[Comparison], found: &mut Vec<(Vec<Comparison>, Reach)>) {
    let (relation, left, right) = question.find.as_ref().expect("a goal");
    let solved = solve_until(question.recurrence.clone(), known, &|| false);
    let recurrence = solved.as_ref().map_or(&question.recurrence, Solved::recurrence);
    let own = |solved: &Solved| solved.conditions().to_vec();
    let needed: Vec<Comparison> = solved.as_ref().map(own).unwrap_or_default();
    let open = match &solved {
        Err(unknown) => unknown.open.clone(),
        Ok(solved) => match reach(recurrence, Some(solved), (*relation, left, right), known, &|| false) {
            Reach::Unknown(unknown) => unknown.open,
            told => return found.push((case.iter().cloned().chain(needed).collect(), told)),
        },
    };
    let terms: Vec<Name> = question.recurrence.terms().into_iter().map(|(name, ..)| name).collect();
    let Some(open) = open.filter(|_| case.len() < DEPTH) else { return };
    let (relation, left, right) = *open;
    let names = || left.variables().into_iter().chain(right.variables());
    if names().any(|name| name == question.recurrence.index || terms.contains(&name)) {
        return;
    }
    for relation in [relation, relation.negated()] {
        let mut known = known.clone();
        known.assume(relation, &left, &right);
        if !known.contradictory() {
            let case: Vec<Comparison> = case.iter().cloned().chain([(relation, left.clone(), right.clone())]).collect();
            cases(question, &known, &case, found);
        }
    }
}

/// Whether a comparison holds of numbers; nothing where it has no value.
fn holds((relation, left, right): &Comparison, numbers: &BTreeMap<Name, Value>) -> Option<bool> {
    let (left, right) = (left.substitute(numbers).ok()?, right.substitute(numbers).ok()?);
    Assumptions::default().decide(*relation, &left, &right)
}

/// The first index among so many terms, as they are made one after the other.
fn among_terms(question: &Question, numbers: &BTreeMap<Name, Value>) -> Option<usize> {
    let put = |value: &Value| value.substitute(numbers).expect("a value");
    let mut recurrence: Recurrence = question.recurrence.clone();
    for sequence in &mut recurrence.sequences {
        sequence.start = sequence.start.iter().map(put).collect();
        sequence.next = put(&sequence.next);
    }
    let terms = recurrence.iterate(TERMS).expect("terms");
    let goal = question.find.as_ref().expect("a goal");
    (0..TERMS).find(|at| {
        let own = recurrence.sequences.iter().zip(&terms);
        let mut images: BTreeMap<Name, Value> =
            own.map(|(sequence, terms)| (recurrence.term(&sequence.name, 0), terms[*at].clone())).collect();
        images.insert(recurrence.index.clone(), int(i64::try_from(*at).expect("small")));
        images.extend(numbers.clone());
        holds(goal, &images) == Some(true)
    })
}

/// Sets of numbers for the parameters, of which w and e are above 0.
fn sets() -> impl Iterator<Item = BTreeMap<Name, Value>> {
    let mut state = 2012u64;
    let mut next = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        i64::try_from(state >> 40).expect("small")
    };
    (0..SETS).map(move |_| {
        let mut of = |name: &str| {
            let (top, below) = (next() % 25 - 12, next() % 3 + 1);
            let positive = ["w", "e"].contains(&name);
            (Name::new(name), frac(if positive { top.abs() + 1 } else { top }, below))
        };
        ["p", "a", "w", "g", "e"].map(&mut of).into()
    })
}

/// Compares each case of a question with what the terms show; how many were compared.
fn compared(asked: &str) -> usize {
    let (question, environment) = question(&format!("param p, a, g, w > 0, e > 0\nsolve {asked}\n"));
    let mut all = Vec::new();
    cases(&question, &environment.assumptions, &[], &mut all);
    let mut count = 0;
    for numbers in sets() {
        let shown = among_terms(&question, &numbers);
        let here = all.iter().filter(|(case, _)| case.iter().all(|one| holds(one, &numbers) == Some(true)));
        for (case, found) in here {
            let told = match found {
                Reach::At(at, conditions) if conditions.iter().all(|one| holds(one, &numbers) == Some(true)) => Some(
                    at.substitute(&numbers).unwrap_or_else(|error| panic!("{asked}: {at} at {numbers:?}: {error:?}")),
                ),
                Reach::At(..) => continue,
                _ => None,
            };
            let late = |value: &Value| {
                Assumptions::default().decide(pars::value::Relation::Gte, value, &int(TERMS as i64)) == Some(true)
            };
            let same = match (&told, shown) {
                (Some(at), None) => late(at),
                (Some(at), Some(shown)) => *at == int(shown as i64),
                (None, shown) => shown.is_none(),
            };
            assert!(same, "{asked}: {found:?} in {case:?}, and it is {shown:?} at {numbers:?}");
            count += 1;
        }
    }
    count
}

#[test]
fn of_motions_on_a_line() {
    let mut count = 0;
    for motion in MOTIONS {
        for goal in GOALS {
            count += compared(&format!("{motion} find n with {goal}"));
        }
    }
    // Most of them are answered in most cases.
    assert!(count > MOTIONS.len() * GOALS.len() * SETS / 2, "{count}");
}

#[test]
fn of_ways_through_the_plane() {
    let count: usize = WAYS.iter().map(|way| compared(way)).sum();
    assert!(count > WAYS.len() * SETS / 2, "{count}");
}
