//! Runs in which something happens a number of times that may be none, or just once: where it is more, and where it is
//! not, the system is followed by itself.

use super::{Follower, Lost};
use crate::fact::Context;
use crate::kernel::Theory;
use crate::law::Condition;
use crate::name::Name;
use crate::proof::{Lemma, Proof, Script, Statement, Step};
use crate::scope::subterms;
use crate::term::{Node, Term};
use crate::value::{Relation, Value};

/// The most numbers of rounds of which it is asked whether they are more than 0, or than 1.
const MOST_SPLITS: usize = 3;

/// A proof that the system is weakly equal to the run, or weakly refined by one that shows less.
///
/// # Errors
/// Where the run is not of stretches, rounds and one loop, or the system cannot be followed.
pub fn runs(theory: &Theory, hypotheses: &[Condition], system: &Term, run: &Term) -> Result<Proof, Lost> {
    in_cases(theory, hypotheses, (system, run), MOST_SPLITS)
}

fn in_cases(
    theory: &Theory,
    hypotheses: &[Condition],
    (system, run): (&Term, &Term),
    splits: usize,
) -> Result<Proof, Lost> {
    let lost = match directly(theory, hypotheses, system, run) {
        Err(lost) if splits > 0 => lost,
        found => return found,
    };
    let context = Context::new(&theory.assumptions, &theory.definitions, hypotheses);
    let Some((count, bound)) = undecided(run, &context) else { return Err(lost) };
    let case = |relation| {
        let mut all = hypotheses.to_vec();
        all.push(Condition::Compare(relation, count.clone(), bound.clone()));
        let inside = |Lost(why): Lost| Lost(format!("where {count} {} {bound}: {why}", relation.symbol()));
        in_cases(theory, &all, (system, run), splits - 1).map_err(inside)
    };
    let (some, none) = (case(Relation::Gtr)?, case(Relation::Lte)?);
    let connective = some.statement.connective.join(none.statement.connective);
    let mut lemmas = Vec::new();
    let (holds, fails) = (added(&mut lemmas, some), added(&mut lemmas, none));
    let when = Condition::Compare(Relation::Gtr, count, bound);
    let script = Script { steps: vec![Step::Cases { when, holds, fails }] };
    let (left, right) = (system.clone(), run.clone());
    let statement = Statement { hypotheses: hypotheses.to_vec(), left, connective, right };
    Ok(Proof { lemmas, ..script.finish(statement) })
}

/// The system followed along the run as it is.
fn directly(theory: &Theory, hypotheses: &[Condition], system: &Term, run: &Term) -> Result<Proof, Lost> {
    let mut follower = Follower { forgets: true, ..Follower::new(theory, hypotheses, false) };
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
