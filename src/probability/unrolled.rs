//! A chain with a copy of each phase for each round up to the time asked for.
//!
//! Of a question about one moment, each round then needs only what the later ones make of its state: where guards do not
//! cut anything, that is one linear form for each round, though over all rounds there may be many.

use num_rational::BigRational;
use num_traits::ToPrimitive;

use super::Question;
use super::chain::{Chain, Move};

/// Copies of phases.
const MOST_COPIES: u64 = 400;

/// The chain unrolled; none where it would be large, or a first passage is asked for, which looks at every round.
pub fn unrolled(chain: &Chain, question: &Question, duration: &BigRational) -> Option<Chain> {
    let rounds = (&question.time / duration).floor().to_integer().to_u64()?;
    let size = chain.phases.len();
    if question.first || rounds.checked_add(1)?.checked_mul(size as u64)? > MOST_COPIES {
        return None;
    }
    let mut phases = Vec::new();
    for round in 0..=rounds as usize {
        let last = round as u64 == rounds;
        phases.extend(chain.phases.iter().map(|moves| {
            let copy = |one: &Move| copied(one, (round + 1) * size, last);
            moves.iter().map(copy).collect::<Vec<Move>>()
        }));
    }
    Some(Chain { initial: chain.initial.clone(), phases, variables: Vec::new() })
}

/// A move into the copies that begin at this place; from the last round nothing matters but what is shown as it begins,
/// from the others nothing but where they lead.
fn copied(one: &Move, first: usize, last: bool) -> Move {
    let mut copy = one.clone();
    if last {
        copy.tests.clear();
        copy.image.clear();
        copy.next = None;
    } else {
        copy.next = one.next.map(|next| first + next);
        let timed = |stretch: &&mut super::chain::Stretch| stretch.duration.is_some();
        copy.stretches.iter_mut().filter(timed).for_each(|stretch| stretch.shown.clear());
    }
    copy
}
