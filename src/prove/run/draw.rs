//! Parts of a way through a network that draws: each is a theorem of its own, from the state that the one before it left.

use super::{Follower, Lost};
use crate::advance::draw::Draws;
use crate::fact::Context;
use crate::kernel::Theory;
use crate::law::{Condition, Connective};
use crate::name::Name;
use crate::proof::{Proof, Statement, Step};
use crate::substitution::Stuck;
use crate::term::Term;
use crate::value::Value;

/// A proof that a network is weakly equal to a stretch and then another network, which may be about to draw.
///
/// # Errors
/// Where the network cannot be followed.
pub fn goes_on(theory: &Theory, hypotheses: &[Condition], from: &Term, stretch: &Term) -> Result<(Proof, Term), Lost> {
    let mut follower = Follower::new(theory, hypotheses, false);
    let (start, state) = follower.settled(from)?;
    let (step, next) = follower.past(stretch, &state)?;
    follower.script.chain(vec![start, step]);
    let right = Term::seq([stretch.clone(), next.clone()]);
    let statement =
        Statement { hypotheses: hypotheses.to_vec(), left: from.clone(), connective: follower.connective(), right };
    Ok((Proof { lemmas: Vec::new(), statement, steps: follower.script.steps }, next))
}

/// What a network draws in the instant in which it is; a value that is drawn before is called by its place.
///
/// # Errors
/// Where nothing is drawn, or it cannot be followed.
pub fn due(theory: &Theory, hypotheses: &[Condition], from: &Term) -> Result<Vec<(Name, Value)>, Lost> {
    let context = Context::new(&theory.assumptions, &theory.definitions, hypotheses);
    Ok(Draws::of(from, &context).map_err(|stuck| Lost(stuck.0))?.due().to_vec())
}

/// A proof that a network is weakly equal to what it draws, under these names, and then another network.
///
/// # Errors
/// As for [`due`].
pub fn draws(theory: &Theory, hypotheses: &[Condition], from: &Term, names: &[Name]) -> Result<(Proof, Term), Lost> {
    let context = Context::new(&theory.assumptions, &theory.definitions, hypotheses);
    let draws = Draws::of(from, &context).map_err(|stuck| Lost(stuck.0))?;
    let odd = |stuck: Stuck| Lost(stuck.0);
    let (right, next) = (draws.made(names, &context).map_err(odd)?, draws.after(names).map_err(odd)?);
    let (hypotheses, left) = (hypotheses.to_vec(), from.clone());
    let statement = Statement { hypotheses, left, connective: Connective::Weak, right };
    Ok((Proof::new(statement, vec![Step::Draw(from.clone(), names.to_vec())]), next))
}
