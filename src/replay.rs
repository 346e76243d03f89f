//! Replaying a timed run in the executable meaning, with what it draws: what cannot be replayed is not shown as a refutation.

use std::collections::BTreeSet;

use num_rational::BigRational;
use num_traits::Zero;

use crate::definition::Definitions;
use crate::distribution::Distribution;
use crate::model::{Action, Model, Move, State};
use crate::name::Name;
use crate::term::{Node, Term};
use crate::value::Value;

/// Steps after which a replay is given up.
const MOST_STEPS: usize = 20_000;

/// What is drawn at once: from which distributions, and which values.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Drawn {
    /// The distributions.
    pub from: Vec<Value>,
    /// A value from each.
    pub values: Vec<Value>,
}

impl Drawn {
    /// The process after a move, if it is this draw: a value of a positive chance, or one where the density is positive.
    pub fn taken(&self, one: &Move) -> Option<Term> {
        match &one.action {
            Action::Draw(from, Some((values, _))) if *from == self.from && *values == self.values => {
                Some(one.next.clone())
            }
            Action::Draw(from, None) if *from == self.from => match (from.as_slice(), self.values.as_slice()) {
                ([from], [value]) => {
                    let number = value.as_rational()?;
                    Distribution::of(from).ok()?.supports(&number).then(|| one.with(value))
                }
                _ => None,
            },
            _ => None,
        }
    }
}

/// Whether a closed system that draws these values in turn, and no more than these, shows at each given time, once its
/// internal steps at that time are done, the observers given for it; only observers whose names are given in some entry
/// are looked at. But for what it draws the system must be deterministic: of several internal steps the first is taken.
pub fn replays(system: &Term, definitions: &Definitions, run: &[(Value, Vec<Term>)], drawn: &[Drawn]) -> bool {
    let names: BTreeSet<Name> = run.iter().flat_map(|(_, shown)| shown).filter_map(observer).collect();
    let model = Model::new(definitions);
    let mut now = BigRational::zero();
    let mut left = Left { steps: 0, drawn: drawn.iter() };
    let Ok(mut state) = model.state(system) else { return false };
    for (time, shown) in run {
        let Some(time) = time.as_rational() else { return false };
        if time < now {
            return false;
        }
        match model.wait_through(&state, &(&time - &now), &mut left) {
            Some(next) => state = next,
            None => return false,
        }
        now = time;
        let wanted: BTreeSet<(Name, Vec<Value>)> = shown.iter().filter_map(parts).collect();
        let seen: BTreeSet<(Name, Vec<Value>)> =
            state.observations().into_iter().filter(|(name, _)| names.contains(name)).collect();
        if wanted != seen {
            return false;
        }
    }
    !run.is_empty()
}

/// What a replay has done, and what it has still to draw.
struct Left<'a> {
    steps: usize,
    drawn: std::slice::Iter<'a, Drawn>,
}

fn observer(term: &Term) -> Option<Name> {
    parts(term).map(|(name, _)| name)
}

fn parts(term: &Term) -> Option<(Name, Vec<Value>)> {
    match term.node() {
        Node::Observe(name, values) => Some((name.clone(), values.clone())),
        _ => None,
    }
}

impl Model<'_> {
    /// Lets time pass with all draws and internal steps that come up, those due at the end included.
    fn wait_through(&self, from: &State, time: &BigRational, rest: &mut Left<'_>) -> Option<State> {
        let mut state = from.clone();
        let mut left = time.clone();
        loop {
            rest.steps += 1;
            if rest.steps > MOST_STEPS {
                return None;
            }
            let moves = state.moves().ok()?;
            if moves.iter().any(|step| matches!(step.action, Action::Draw(..))) {
                let drawn = rest.drawn.next()?;
                state = self.state(&moves.iter().find_map(|step| drawn.taken(step))?).ok()?;
                continue;
            }
            if let Some(step) = moves.iter().find(|step| matches!(step.action, Action::Tau(..))) {
                state = self.state(&step.next).ok()?;
                continue;
            }
            if left.is_zero() {
                return Some(state);
            }
            let passed = match state.patience(&moves) {
                crate::model::Patience::None => return None,
                crate::model::Patience::Until(next) if next < left => next,
                _ => left.clone(),
            };
            state = self.wait_state(&state, &passed).ok()??;
            left -= passed;
        }
    }
}
