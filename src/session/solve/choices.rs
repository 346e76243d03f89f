//! Equations in which a condition of parameters alone chooses how a term depends on those before it,
//! `if k > 0 then x(n)/k else 1`: they are solved where it holds, and where it does not.

use std::collections::BTreeSet;

use crate::assumption::Assumptions;
use crate::closed_form::Comparison;
use crate::lower::Question;
use crate::name::Name;
use crate::value::{Atom, Relation, Value};

/// The question where the first such condition of which it is not known whether it holds does so, and where it does not;
/// nothing where there is none. Where an index is looked for, any condition of parameters is one, in what is looked for too:
/// of what holds in one case only an index would be made that has no value in the others.
pub(super) fn choices(question: &Question, known: &Assumptions) -> Vec<(Comparison, Question)> {
    let recurrence = &question.recurrence;
    let terms: Vec<Name> = recurrence.terms().into_iter().map(|(name, ..)| name).collect();
    let parameter = |name: &Name| *name != recurrence.index && !terms.contains(name);
    for atom in conditions(question) {
        let Atom::Positive(inner) = &atom else { continue };
        let open = known.decide(Relation::Gtr, inner, &Value::zero()).is_none();
        if open && known.gives_meaning(inner) && inner.variables().iter().all(parameter) {
            let mut cases = cases(question, &atom, inner).unwrap_or_default();
            if question.find.is_some() || depend(&cases, &terms) {
                cases.retain(|((relation, left, right), _)| known.decide(*relation, left, right) != Some(false));
                return cases;
            }
        }
    }
    Vec::new()
}

/// The question without the conditions of parameters of which it is known whether they hold.
pub(super) fn decided(question: &Question, known: &Assumptions) -> Question {
    let terms: Vec<Name> = question.recurrence.terms().into_iter().map(|(name, ..)| name).collect();
    let parameter = |name: &Name| *name != question.recurrence.index && !terms.contains(name);
    let holds = |atom: &Atom| {
        let Atom::Positive(inner) = atom else { return None };
        let free = inner.variables().iter().all(parameter) && known.gives_meaning(inner);
        let holds = known.decide(Relation::Gtr, inner, &Value::zero()).filter(|_| free)?;
        Some(Value::integer(holds.into()))
    };
    if !conditions(question).iter().any(|atom| holds(atom).is_some()) {
        return question.clone();
    }
    replaced(question, &mut { holds }).unwrap_or_else(|| question.clone())
}

/// Takes from the question what it is known to need, or all that it may need, and knows that it holds from then on; what it
/// is known not to need is left out.
pub(super) fn required(question: &mut Question, known: &mut Assumptions, all: bool) -> Vec<Comparison> {
    let mut needs = Vec::new();
    let before = known.clone();
    question.conditions.retain(|requirement| {
        let ways = requirement.ways.iter().flatten();
        let open: Vec<_> = ways.filter(|way| !excluded(way, &before)).collect();
        if requirement.ways.is_some() && open.is_empty() {
            return false;
        }
        let always = |(relation, left, right): &Comparison| before.decide(*relation, left, right) == Some(true);
        let asked = all || requirement.ways.is_none() || open.iter().any(|way| way.iter().all(always));
        if asked {
            let (relation, left, right) = &requirement.comparison;
            known.assume(*relation, left, right);
            needs.push(requirement.comparison.clone());
        }
        !asked
    });
    question.required.extend(needs.iter().cloned());
    needs
}

/// Whether these do not hold together.
fn excluded(way: &[Comparison], known: &Assumptions) -> bool {
    let mut known = known.clone();
    way.iter().for_each(|(relation, left, right)| known.assume(*relation, left, right));
    known.contradictory()
}

/// The question with values for conditions in it; what is looked for is told as it was.
fn replaced(question: &Question, images: &mut dyn FnMut(&Atom) -> Option<Value>) -> Option<Question> {
    let mut settled = question.clone();
    for sequence in &mut settled.recurrence.sequences {
        sequence.next = sequence.next.replace(images).ok()?;
        for start in &mut sequence.start {
            *start = start.replace(images).ok()?;
        }
    }
    if let Some((relation, left, right)) = &question.find {
        settled.asked = Some(question.goal((*relation, left, right)));
        settled.find = Some((*relation, left.replace(images).ok()?, right.replace(images).ok()?));
        for (_, left, right) in &mut settled.either {
            (*left, *right) = (left.replace(images).ok()?, right.replace(images).ok()?);
        }
    }
    Some(settled)
}

/// All that is asked and said of the terms.
fn values(question: &Question) -> impl Iterator<Item = &Value> {
    let sides = question.find.iter().flat_map(|(_, left, right)| [left, right]);
    let sequences = question.recurrence.sequences.iter();
    sequences.flat_map(|sequence| sequence.start.iter().chain([&sequence.next])).chain(sides)
}

/// The conditions in that, at any depth.
fn conditions(question: &Question) -> BTreeSet<Atom> {
    let mut found = BTreeSet::new();
    let mut open: Vec<Value> = values(question).cloned().collect();
    while let Some(value) = open.pop() {
        for atom in value.atoms() {
            open.extend(atom.parts().into_iter().cloned());
            if matches!(atom, Atom::Positive(_)) {
                found.insert(atom);
            }
        }
    }
    found
}

/// The question in each case of a condition, and of its opposite where that is asked for as well.
fn cases(question: &Question, atom: &Atom, inner: &Value) -> Option<Vec<(Comparison, Question)>> {
    let opposite = Atom::Positive(inner.neg().ok()?);
    let settled = |above: i64, below: i64| {
        let mut holds = |other: &Atom| match other == atom {
            true => Some(Value::integer(above)),
            false => (*other == opposite).then(|| Value::integer(below)),
        };
        replaced(question, &mut holds)
    };
    let (above, below, neither) = (settled(1, 0)?, settled(0, 1)?, settled(0, 0)?);
    let cases = match conditions(question).contains(&opposite) {
        false => vec![(Relation::Gtr, above), (Relation::Lte, neither)],
        true if values(&above).eq(values(&below)) => vec![(Relation::Neq, above), (Relation::Eq, neither)],
        true => vec![(Relation::Gtr, above), (Relation::Eq, neither), (Relation::Lss, below)],
    };
    Some(cases.into_iter().map(|(relation, found)| ((relation, inner.clone(), Value::zero()), found)).collect())
}

/// Whether it is more than a summand that differs from case to case.
fn depend(cases: &[(Comparison, Question)], terms: &[Name]) -> bool {
    let differ = |(one, other): (&Question, &Question)| {
        one.recurrence.sequences.iter().zip(&other.recurrence.sequences).any(|(one, other)| {
            let difference = one.next.sub(&other.next);
            difference.map_or(true, |difference| terms.iter().any(|name| difference.mentions(name)))
        })
    };
    cases.windows(2).any(|pair| differ((&pair[0].1, &pair[1].1)))
}
