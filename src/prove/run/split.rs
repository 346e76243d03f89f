//! Runs in which something happens a number of times that may be none, or just once: where it is more, and where it is
//! not, the system is followed by itself.

use std::collections::BTreeSet;

use super::{Follower, Lost, Stage};
use crate::assumption::Assumptions;
use crate::fact::{Context, supposing};
use crate::kernel::Theory;
use crate::law::{Condition, Connective};
use crate::name::Name;
use crate::proof::{Lemma, Proof, Script, Statement, Step};
use crate::scope::{bound_names, subterms};
use crate::term::{Node, Term};
use crate::value::{Atom, Relation, Value};

/// The most numbers of rounds of which it is asked whether they are more than 0, or than 1.
const MOST_SPLITS: usize = 3;
/// The most values of which it is asked on one way whether they are more than 0.
const MOST_DECISIONS: usize = 4;

/// A proof that the system is weakly equal to the run, or weakly refined by one that shows less.
///
/// # Errors
/// Where the run is not of stretches, rounds and one loop, or the system cannot be followed.
pub fn runs(theory: &Theory, (system, run): (&Term, &Term), stages: &[Stage]) -> Result<Proof, Lost> {
    runs_where(theory, &[], (system, run), stages)
}

/// The same under hypotheses.
///
/// # Errors
/// As for [`runs`].
pub fn runs_where(
    theory: &Theory,
    hypotheses: &[Condition],
    (system, run): (&Term, &Term),
    stages: &[Stage],
) -> Result<Proof, Lost> {
    in_cases(theory, hypotheses, (system, run, stages), MOST_SPLITS)
}

fn in_cases(
    theory: &Theory,
    hypotheses: &[Condition],
    (system, run, stages): (&Term, &Term, &[Stage]),
    splits: usize,
) -> Result<Proof, Lost> {
    let lost = match directly(theory, hypotheses, (system, run, stages)) {
        Err(lost) if splits > 0 => lost,
        found => return found,
    };
    let context = Context::new(&theory.assumptions, &theory.definitions, hypotheses);
    let Some((count, bound)) = undecided(run, &context) else { return Err(lost) };
    let each = |all: &[Condition]| in_cases(theory, all, (system, run, stages), splits - 1);
    either(hypotheses, (system, run), (&count, &bound), &each)
}

/// A proof that one network shows what another does, from one for where a value is more than another and one for where it
/// is not.
///
/// # Errors
/// What is wrong with either proof, and where.
pub fn either(
    hypotheses: &[Condition],
    (left, right): (&Term, &Term),
    (value, bound): (&Value, &Value),
    each: &dyn Fn(&[Condition]) -> Result<Proof, Lost>,
) -> Result<Proof, Lost> {
    let case = |relation| {
        let mut all = hypotheses.to_vec();
        all.push(Condition::Compare(relation, value.clone(), bound.clone()));
        each(&all).map_err(|Lost(why)| Lost(format!("where {value} {} {bound}: {why}", relation.symbol())))
    };
    let (some, none) = (case(Relation::Gtr)?, case(Relation::Lte)?);
    let connective = some.statement.connective.join(none.statement.connective);
    let mut lemmas = Vec::new();
    let (holds, fails) = (added(&mut lemmas, some), added(&mut lemmas, none));
    let when = Condition::Compare(Relation::Gtr, value.clone(), bound.clone());
    let script = Script { steps: vec![Step::Cases { when, holds, fails }] };
    let (left, right) = (left.clone(), right.clone());
    let statement = Statement { hypotheses: hypotheses.to_vec(), left, connective, right };
    Ok(Proof { lemmas, ..script.finish(statement) })
}

/// A proof that one network is weakly equal to these stretches and then another: where the system decides by what its
/// values are, in each case by itself.
///
/// # Errors
/// As for [`runs`].
pub fn passes(
    theory: &Theory,
    hypotheses: &[Condition],
    (from, to): (&Term, &Term),
    stretches: &[Term],
) -> Result<Proof, Lost> {
    passes_in_cases(theory, hypotheses, (from, to, stretches), MOST_DECISIONS)
}

fn passes_in_cases(
    theory: &Theory,
    hypotheses: &[Condition],
    (from, to, stretches): (&Term, &Term, &[Term]),
    splits: usize,
) -> Result<Proof, Lost> {
    let directly = || super::passes_as_they_are(theory, hypotheses, (from, to), stretches);
    // Directions along an axis are long as they are, and short in each case.
    let long = splits == MOST_DECISIONS && divides_by_lengths(to);
    let first = if long { None } else { Some(directly()) };
    if let Some(Ok(_)) = first {
        return first.unwrap_or_else(directly);
    }
    let known = supposing(&theory.assumptions, hypotheses);
    let right = Term::seq(stretches.iter().cloned().chain([to.clone()]));
    // A case that cannot be needs no proof of its own.
    if splits < MOST_DECISIONS && known.contradictory() {
        return Ok(excluded(hypotheses, from, &right));
    }
    let compared = hypotheses.iter().filter_map(|condition| match condition {
        Condition::Compare(_, left, right) => Some([left, right]),
        _ => None,
    });
    let values = compared.flatten().chain(subterms(from).chain(subterms(to)).flat_map(|part| part.values()));
    // What a read will give is nothing that a case could be of.
    let bound: BTreeSet<Name> = bound_names(from).into_iter().chain(bound_names(to)).collect();
    let values = values.filter(|value| value.variables().is_disjoint(&bound));
    if splits > 0
        && let Some(value) = undecided_part(values.cloned().collect(), &known)
    {
        let each = |all: &[Condition]| passes_in_cases(theory, all, (from, to, stretches), splits - 1);
        if let Ok(proof) = either(hypotheses, (from, &right), (&value, &Value::zero()), &each) {
            return Ok(proof);
        }
    }
    first.unwrap_or_else(directly)
}

/// Whether a value of it divides by what a maximum or a condition stands in.
fn divides_by_lengths(network: &Term) -> bool {
    let folded = |value: Value| value.atoms().iter().any(|atom| matches!(atom, Atom::Maximum(_) | Atom::Positive(_)));
    subterms(network).any(|part| part.values().any(|value| value.denominator().is_some_and(folded)))
}

/// A proof that one network is another where what is supposed excludes itself.
fn excluded(hypotheses: &[Condition], left: &Term, right: &Term) -> Proof {
    let (left, right) = (left.clone(), right.clone());
    let script = Script { steps: vec![Step::Excluded(left.clone(), right.clone())] };
    script.finish(Statement { hypotheses: hypotheses.to_vec(), left, connective: Connective::Equal, right })
}

/// A value of which it depends whether it is more than 0 what these are: of a condition or a maximum in them, and the
/// plainest of those.
fn undecided_part(mut values: Vec<Value>, known: &Assumptions) -> Option<Value> {
    let open = |value: &Value| known.decide(Relation::Gtr, value, &Value::zero()).is_none();
    let mut seen: BTreeSet<Value> = BTreeSet::new();
    while let Some(value) = values.pop() {
        for atom in value.atoms() {
            let parts = atom.parts().into_iter().cloned();
            if !matches!(atom, Atom::Positive(_) | Atom::Maximum(_)) {
                values.extend(parts);
                continue;
            }
            for part in parts.filter(|part| !seen.contains(part)).collect::<Vec<_>>() {
                values.push(part.clone());
                seen.insert(part);
            }
        }
    }
    let folded = |value: &Value| value.atoms().iter().any(|atom| !matches!(atom, Atom::Variable(_) | Atom::Power(..)));
    let mut plain: Vec<Value> = seen.into_iter().collect();
    plain.sort_by_key(|value| (folded(value), value.atoms().len()));
    plain.into_iter().find(open)
}

/// The system followed along the run as it is.
fn directly(
    theory: &Theory,
    hypotheses: &[Condition],
    (system, run, stages): (&Term, &Term, &[Stage]),
) -> Result<Proof, Lost> {
    let mut follower = Follower { stages, forgets: true, ..Follower::new(theory, hypotheses, false) };
    let (start, state) = follower.settled(system)?;
    let step = follower.whole(run, state)?;
    follower.script.chain(vec![start, step]);
    let (connective, hypotheses) = (follower.connective(), hypotheses.to_vec());
    let statement = Statement { hypotheses, left: system.clone(), connective, right: run.clone() };
    Ok(Proof { lemmas: follower.lemmas, statement, steps: follower.script.steps })
}

/// A number of rounds that may be 0 and may be more; else one that may be 1 and may be more, as the last of some rounds
/// is another than the first. With what it may be.
fn undecided(run: &Term, context: &Context<'_>) -> Option<(Value, Value)> {
    let known = &context.assumptions;
    let counts = subterms(run).filter_map(|part| match part.node() {
        Node::Power(_, count, _) => Some(known.simplify(count)),
        _ => None,
    });
    let counts: Vec<Value> = counts.filter(|count| known.is_natural(count) == Some(true)).collect();
    [Value::zero(), Value::one()].into_iter().find_map(|bound| {
        let open = |count: &&Value| known.decide(Relation::Gtr, count, &bound).is_none();
        counts.iter().find(open).map(|count| (count.clone(), bound.clone()))
    })
}

/// Adds a proof as a lemma behind its own, each under a name of its own; its place.
fn added(lemmas: &mut Vec<Lemma>, proof: Proof) -> usize {
    let before = lemmas.len();
    let whole = Lemma { name: Name::new("Case"), statement: proof.statement, steps: proof.steps };
    for mut lemma in proof.lemmas.into_iter().chain([whole]) {
        lemma.steps.iter_mut().for_each(|step| step.renumber(&|of| of + before));
        let stem = lemma.name.as_str().trim_end_matches(|letter: char| letter.is_ascii_digit());
        lemma.name = Name::new(&format!("{stem}{}", lemmas.len() + 1));
        lemmas.push(lemma);
    }
    lemmas.len() - 1
}
