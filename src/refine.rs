//! Refinement `P <= Q`: Q does the same and shows less. Both sides are walked in time together; what P shows
//! beyond Q is forgotten, and what remains must be equal.

use crate::fact::{Context, Facts};
use crate::name::Name;
use crate::proof::{Script, Step, StepId, hole};
use crate::simplify::Simplifier;
use crate::substitution::Substitution;
use crate::term::{Node, Term};
use crate::value::{Relation, Value};

/// A stretch of time with what is shown, as `(Delay_a # O)`, or some other process of known duration.
struct Stretch {
    term: Term,
    duration: Value,
}

/// Pieces that a side is cut into.
const MOST_PIECES: usize = 2_000;

/// Searches for `left <= right`; on success the step that proves it.
pub fn refine(left: &Term, right: &Term, simplifier: &mut Simplifier<'_>, context: &Context<'_>) -> Option<StepId> {
    if left == right {
        return Some(simplifier.script.push(Step::Reflexive(left.clone())));
    }
    if let Some(step) = forget(left, right, &mut simplifier.script, context) {
        return Some(step);
    }
    if *right == Term::idle() {
        let (silent, forgotten) = only(left, &[], simplifier, context)?;
        let nothing = equal(&silent, right, simplifier)?;
        return Some(simplifier.script.chain(vec![forgotten, nothing]));
    }
    // What is shown for ever, whatever else changes.
    let shown = disabled(right);
    if shown.iter().all(|part| Facts::of(part, context).observer)
        && let Some((kept, forgotten)) = only(left, &shown, simplifier, context)
        && let Some(same) = equal(&kept, right, simplifier)
    {
        return Some(simplifier.script.chain(vec![forgotten, same]));
    }
    match (left.node(), right.node()) {
        (Node::Loop(one), Node::Loop(two)) => {
            let inner = refine(one, two, simplifier, context)?;
            let shape = left.with_children(vec![Term::meta(&hole(1))]);
            Some(simplifier.script.push(Step::Congruence(shape, vec![inner])))
        }
        (Node::Else(a, b), Node::Else(c, d)) => {
            let steps = vec![refine(a, c, simplifier, context)?, refine(b, d, simplifier, context)?];
            let shape = left.with_children(vec![Term::meta(&hole(1)), Term::meta(&hole(2))]);
            Some(simplifier.script.push(Step::Congruence(shape, steps)))
        }
        _ => align(left, right, simplifier, context),
    }
}

/// `P # O <= P`, also below powers, when the two differ in observers alone.
fn forget(left: &Term, right: &Term, script: &mut Script, context: &Context<'_>) -> Option<StepId> {
    if left == right {
        return Some(script.push(Step::Reflexive(left.clone())));
    }
    if let (Node::Power(one, n, i), Node::Power(two, m, j)) = (left.node(), right.node())
        && (n, i) == (m, j)
    {
        let inner = forget(one, two, script, context)?;
        let shape = left.with_children(vec![Term::meta(&hole(1))]);
        return Some(script.push(Step::Congruence(shape, vec![inner])));
    }
    let parts = disabled(left);
    let kept = disabled(right);
    let mut extra = parts.clone();
    for part in &kept {
        let position = extra.iter().position(|other| other == part)?;
        extra.remove(position);
    }
    if extra.is_empty() || !extra.iter().all(|part| Facts::of(part, context).observer) {
        return None;
    }
    let mut substitution = Substitution::default();
    substitution.processes.insert(Name::new("?P"), right.clone());
    substitution.processes.insert(Name::new("?O"), Term::disable(extra));
    Some(script.push(Step::Law(Name::new("forget"), substitution)))
}

/// `O <= Idle`, by way of `O = Idle # O`.
fn forget_all(left: &Term, simplifier: &mut Simplifier<'_>) -> Option<StepId> {
    let both = Term::disable([Term::idle(), left.clone()]);
    let same = equal(left, &both, simplifier)?;
    let mut substitution = Substitution::default();
    substitution.processes.insert(Name::new("?P"), Term::idle());
    substitution.processes.insert(Name::new("?O"), left.clone());
    let step = simplifier.script.push(Step::Law(Name::new("forget"), substitution));
    Some(simplifier.script.chain(vec![same, step]))
}

/// A process that shows these alone, beneath sequences, loops and rounds, with the step from what it was.
fn only(term: &Term, kept: &[Term], simplifier: &mut Simplifier<'_>, context: &Context<'_>) -> Option<(Term, StepId)> {
    if let Node::Seq(_) | Node::Loop(_) | Node::Power(..) = term.node() {
        let parts = term.children().map(|part| only(part, kept, simplifier, context));
        let (parts, steps): (Vec<Term>, Vec<StepId>) = parts.collect::<Option<Vec<_>>>()?.into_iter().unzip();
        let shape = term.with_children((1..=parts.len()).map(|number| Term::meta(&hole(number))).collect());
        return Some((term.with_children(parts), simplifier.script.push(Step::Congruence(shape, steps))));
    }
    let parts = disabled(term).into_iter();
    let (shown, others): (Vec<Term>, Vec<Term>) = parts.partition(|part| Facts::of(part, context).observer);
    if !kept.iter().all(|part| shown.contains(part)) {
        return None;
    }
    if others.is_empty() && kept.is_empty() {
        return Some((Term::idle(), forget_all(term, simplifier)?));
    }
    let target = Term::disable(others.into_iter().chain(kept.iter().cloned()));
    let step = forget(term, &target, &mut simplifier.script, context)?;
    Some((target, step))
}

fn disabled(term: &Term) -> Vec<Term> {
    match term.node() {
        Node::Disable(parts) => parts.clone(),
        _ => vec![term.clone()],
    }
}

fn sequence(term: &Term) -> Vec<Term> {
    match term.node() {
        Node::Seq(parts) => parts.to_vec(),
        _ => vec![term.clone()],
    }
}

/// Splits the left side where the right side changes, forgets stretch by stretch, and joins again.
fn align(left: &Term, right: &Term, simplifier: &mut Simplifier<'_>, context: &Context<'_>) -> Option<StepId> {
    let mut pieces: Vec<Term> = sequence(left);
    pieces.reverse();
    let mut split: Vec<Term> = Vec::new();
    let mut targets: Vec<Term> = Vec::new();
    let mut steps: Vec<StepId> = Vec::new();
    // Where the pieces of each part of the right side end.
    let mut ends: Vec<usize> = Vec::new();
    let wanted = sequence(right);
    if wanted.len() == 1 && pieces.len() == 1 && Facts::of(right, context).duration.is_none() {
        return None;
    }
    let mut position = 0;
    while position < wanted.len() {
        let target = &wanted[position];
        position += 1;
        let Some(mut open) = Facts::of(target, context).duration.clone() else {
            let rest = match position == wanted.len() {
                true => Term::seq(std::mem::take(&mut pieces).into_iter().rev()),
                false => pieces.pop()?,
            };
            if wanted.len() == 1 && rest == *left {
                return None;
            }
            steps.push(refine(&rest, target, simplifier, context)?);
            split.push(rest);
            targets.push(target.clone());
            ends.push(targets.len());
            continue;
        };
        while context.assumptions.decide(Relation::Eq, &open, &Value::integer(0)) != Some(true) {
            let stretch = take(&mut pieces, &open, simplifier, context)?;
            open = context.assumptions.simplify(&open.sub(&stretch.duration).ok()?);
            let (shown, step) = only(&stretch.term, &shown_in(target, context), simplifier, context)?;
            steps.push(step);
            targets.push(shown);
            split.push(stretch.term);
            if split.len() > MOST_PIECES {
                return None;
            }
        }
        ends.push(targets.len());
    }
    pieces.reverse();
    if !pieces.is_empty() {
        return None;
    }
    let cut = Term::seq(split.iter().cloned());
    let before = equal(left, &cut, simplifier)?;
    let holes: Vec<Term> = (1..=steps.len()).map(|number| Term::meta(&hole(number))).collect();
    let middle = simplifier.script.push(Step::Congruence(Term::seq(holes), steps));
    let after =
        part_by_part(&targets, &ends, &wanted, simplifier).or_else(|| equal(&Term::seq(targets), right, simplifier))?;
    Some(simplifier.script.chain(vec![before, middle, after]))
}

/// What the pieces come to, each part of the right side by itself: the simplest form of the whole might fold a loop in one
/// of the two that it cannot fold in the other, where a delay before it is longer.
fn part_by_part(targets: &[Term], ends: &[usize], wanted: &[Term], simplifier: &mut Simplifier<'_>) -> Option<StepId> {
    let mut from = 0;
    let mut steps = Vec::new();
    for (end, part) in ends.iter().zip(wanted) {
        let own = targets.get(from..*end).filter(|own| !own.is_empty())?;
        steps.push(equal(&Term::seq(own.iter().cloned()), part, simplifier)?);
        from = *end;
    }
    let holes = (1..=steps.len()).map(|number| Term::meta(&hole(number)));
    Some(simplifier.script.push(Step::Congruence(Term::seq(holes.collect::<Vec<_>>()), steps)))
}

/// Two terms with one simplest form.
pub fn equal(left: &Term, right: &Term, simplifier: &mut Simplifier<'_>) -> Option<StepId> {
    let (one, two) = (simplifier.simplify(left), simplifier.simplify(right));
    if one.term != two.term {
        return None;
    }
    let back = simplifier.script.push(Step::Symmetric(two.step));
    Some(simplifier.script.chain(vec![one.step, back]))
}

/// The next stretch of at most the time that is open, cut off if it is longer.
fn take(
    pieces: &mut Vec<Term>,
    open: &Value,
    simplifier: &mut Simplifier<'_>,
    context: &Context<'_>,
) -> Option<Stretch> {
    let mut piece = pieces.pop()?;
    if let Node::Loop(body) = piece.node() {
        pieces.push(piece.clone());
        rounds_of(body, open, pieces, context)?;
        piece = pieces.pop()?;
    }
    // What shows for ever shows for this time, and then for ever.
    if Facts::of(&piece, context).observer {
        let term = Term::disable([Term::delay(open.clone()), piece.clone()]);
        pieces.push(piece);
        return Some(Stretch { term, duration: open.clone() });
    }
    let duration = Facts::of(&piece, context).duration.clone()?;
    if context.assumptions.decide(Relation::Lte, &duration, open) == Some(true) {
        return Some(Stretch { term: piece, duration });
    }
    match piece.node() {
        Node::Seq(parts) => {
            pieces.extend(parts.iter().rev().cloned());
            take(pieces, open, simplifier, context)
        }
        Node::Power(body, count, index) => {
            let first = match index {
                Some(index) => at(body, index, &Value::integer(0))?,
                None => body.clone(),
            };
            let step = Facts::of(&first, context).duration.clone()?;
            let whole = open.div(&step).ok()?.floor().ok()?;
            let whole = if context.assumptions.decide(Relation::Gte, &whole, &Value::integer(1)) == Some(true) {
                whole
            } else {
                Value::integer(1)
            };
            let rest = count.sub(&whole).ok()?;
            let rounds = |body: Term, count: Value| Term::new(Node::Power(body, count, index.clone()));
            let shifted = match index {
                Some(index) => at(body, index, &Value::variable(index).add(&whole).ok()?)?,
                None => body.clone(),
            };
            if !rest.is_zero() {
                pieces.push(rounds(shifted, rest));
            }
            pieces.push(rounds(body.clone(), whole));
            take_checked(pieces, open, simplifier, context)
        }
        _ => {
            let rest = context.assumptions.simplify(&duration.sub(open).ok()?);
            pieces.push(with_delay(&piece, &rest)?);
            Some(Stretch { term: with_delay(&piece, open)?, duration: open.clone() })
        }
    }
}

/// As [`take`], but a power is not cut twice in a row.
fn take_checked(
    pieces: &mut Vec<Term>,
    open: &Value,
    simplifier: &mut Simplifier<'_>,
    context: &Context<'_>,
) -> Option<Stretch> {
    let duration = Facts::of(pieces.last()?, context).duration.clone()?;
    if context.assumptions.decide(Relation::Lte, &duration, open) == Some(true) {
        return take(pieces, open, simplifier, context);
    }
    let piece = pieces.pop()?;
    if let Node::Power(body, count, index) = piece.node()
        && count.as_rational().is_some_and(|n| n == Value::integer(1).as_rational().unwrap_or_default())
    {
        pieces.push(match index {
            Some(index) => at(body, index, &Value::integer(0))?,
            None => body.clone(),
        });
        return take(pieces, open, simplifier, context);
    }
    None
}

fn at(body: &Term, index: &Name, value: &Value) -> Option<Term> {
    let map = std::collections::BTreeMap::from([(index.clone(), value.clone())]);
    crate::substitution::substitute_values(body, &map).ok()
}

fn with_delay(piece: &Term, time: &Value) -> Option<Term> {
    let mut changed = false;
    let parts = disabled(piece).into_iter().map(|part| match part.node() {
        Node::Delay(_) => {
            changed = true;
            Term::delay(time.clone())
        }
        _ => part,
    });
    let term = Term::disable(parts.collect::<Vec<_>>());
    changed.then_some(term)
}

/// Puts the rounds of a loop before it that are needed for the time that is open: as many whole ones as fit, or the parts
/// of one.
fn rounds_of(body: &Term, open: &Value, pieces: &mut Vec<Term>, context: &Context<'_>) -> Option<()> {
    let step = Facts::of(body, context).duration.clone()?;
    if context.assumptions.decide(Relation::Gtr, &step, &Value::zero()) != Some(true) {
        return None;
    }
    let whole = open.div(&step).and_then(|rounds| rounds.floor()).ok().filter(|rounds| rounds.as_rational().is_some());
    match whole {
        Some(whole) if context.assumptions.decide(Relation::Gtr, &whole, &Value::one()) == Some(true) => {
            pieces.push(Term::new(Node::Power(body.clone(), whole, None)));
        }
        _ => pieces.extend(sequence(body).into_iter().rev()),
    }
    Some(())
}

/// What a stretch of the target shows.
fn shown_in(target: &Term, context: &Context<'_>) -> Vec<Term> {
    let stretch = if let Node::Power(body, ..) = target.node() { body } else { target };
    disabled(stretch).into_iter().filter(|part| Facts::of(part, context).observer).collect()
}
