//! A system with numbers followed exactly, in the executable meaning, until all its states have been seen.

use std::collections::HashMap;

use num_rational::BigRational;
use num_traits::Zero;

use crate::assumption::Assumptions;
use crate::definition::Definitions;
use crate::invariant::{Claim, Rejected, meets, shown};
use crate::model::explore::{Label, successors};
use crate::model::{Action, Model, Move, Patience, State};
use crate::replay::Drawn;
use crate::term::{Node, Term};
use crate::value::{Relation, Value};

/// Bits of a number at which a run that only converges is given up, at the latest.
pub const MOST_BITS: u64 = 16_000;

/// Times from the start, with what is shown from then on.
pub type Shown = Vec<(Value, Vec<Term>)>;

/// A run: what is shown, and what is drawn.
#[derive(Clone, Debug)]
pub struct Run {
    /// What is shown, by time.
    pub shown: Shown,
    /// What is drawn, in turn.
    pub drawn: Vec<Drawn>,
}

/// Draws of a run that are told.
const MOST_TOLD: usize = 12;

impl Run {
    /// What it draws, in turn, as a sentence; nothing where it draws nothing.
    pub fn draws(&self) -> Option<String> {
        let listed =
            |values: &[Value], between: &str| values.iter().map(ToString::to_string).collect::<Vec<_>>().join(between);
        let one = |drawn: &Drawn| format!("{} from {}", listed(&drawn.values, ", "), listed(&drawn.from, " and "));
        let all: Vec<String> = self.drawn.iter().take(MOST_TOLD).map(one).collect();
        let more = if self.drawn.len() > MOST_TOLD { ", …" } else { "" };
        (!all.is_empty()).then(|| format!("where it draws, in turn: {}{more}", all.join(", ")))
    }
}

/// What came of following a system.
#[derive(Debug)]
pub enum Orbit {
    /// Every state that can be reached, in all of which the claim holds.
    Closed(Vec<State>),
    /// A run to a state that does not meet the claim.
    Broken(Run),
    /// Not followed to the end; why, and how many states met the claim.
    Unknown(String, usize),
}

struct Visit {
    state: State,
    from: usize,
    time: BigRational,
    /// What was drawn on the way to it.
    drawn: Option<Drawn>,
}

/// When to give up.
pub struct Limits<'a> {
    /// States that are followed: a system that has not repeated by then may run on for ever.
    pub states: usize,
    /// The longest number that is shown, in bits: a run that only converges is given up.
    pub bits: u64,
    /// Whether the user wants it to stop.
    pub interrupted: &'a dyn Fn() -> bool,
}

/// Follows a system.
pub fn follow(
    system: &Term,
    definitions: &Definitions,
    assumptions: &Assumptions,
    claim: &Claim,
    limits: &Limits<'_>,
) -> Orbit {
    let model = Model::new(definitions);
    let mut visits: Vec<Visit> = Vec::new();
    match explore(&model, system, assumptions, claim, &mut visits, limits) {
        Ok(None) => Orbit::Closed(visits.into_iter().map(|visit| visit.state).collect()),
        Ok(Some(place)) => Orbit::Broken(run_to(&visits, place, claim)),
        Err(Rejected(reason)) => Orbit::Unknown(reason, visits.len()),
    }
}

/// Breadth first; the place of a state that breaks the claim, if there is one.
fn explore(
    model: &Model,
    system: &Term,
    assumptions: &Assumptions,
    claim: &Claim,
    visits: &mut Vec<Visit>,
    limits: &Limits<'_>,
) -> Result<Option<usize>, Rejected> {
    let meaning = |error: crate::model::Meaningless| Rejected(error.why);
    let mut places: HashMap<State, usize> = HashMap::new();
    let start = model.state(system).map_err(meaning)?;
    places.insert(start.clone(), 0);
    visits.push(Visit { state: start, from: 0, time: BigRational::zero(), drawn: None });
    let mut next = 0;
    while next < visits.len() {
        let state = visits[next].state.clone();
        let time = visits[next].time.clone();
        if !meets(claim, &state, assumptions)? {
            return Ok(Some(next));
        }
        if state.moves().map_err(meaning)?.iter().any(Move::needs_value) {
            return Err(Rejected("the system draws from a distribution that is not finite".to_string()));
        }
        for (label, target) in successors(model, &state, &[]).map_err(meaning)? {
            if places.contains_key(&target) {
                continue;
            }
            if visits.len() >= limits.states
                || (next % 64 == 0 && (limits.interrupted)())
                || is_long(&target, limits.bits)
            {
                return Err(Rejected(format!("after {} states nothing has repeated", visits.len())));
            }
            let later = match &label {
                Label::Wait(passed) => &time + passed,
                Label::Act(..) => time.clone(),
            };
            places.insert(target.clone(), visits.len());
            visits.push(Visit { state: target, from: next, time: later, drawn: drawn(&label) });
        }
        next += 1;
    }
    Ok(None)
}

pub(super) fn is_long(state: &State, bits: u64) -> bool {
    state.observations().iter().any(|(_, values)| values.iter().any(|value| value.bits() > bits))
}

fn drawn(label: &Label) -> Option<Drawn> {
    match label {
        Label::Act(Action::Draw(from, Some((values, _))), _) => {
            Some(Drawn { from: from.clone(), values: values.clone() })
        }
        _ => None,
    }
}

/// What is shown on the way to a state, wherever time passes, and what is drawn.
fn run_to(visits: &[Visit], place: usize, claim: &Claim) -> Run {
    let mut path = vec![place];
    let mut at = place;
    while at != 0 {
        at = visits[at].from;
        path.push(at);
    }
    path.reverse();
    let states = path.iter().map(|place| (&visits[*place].time, &visits[*place].state));
    let drawn = path.iter().filter_map(|place| visits[*place].drawn.clone()).collect();
    Run { shown: shown_on(states, claim), drawn }
}

/// What these states show of what a claim speaks of, wherever time passes.
pub(super) fn shown_on<'s>(states: impl Iterator<Item = (&'s BigRational, &'s State)>, claim: &Claim) -> Shown {
    let names: Vec<_> = claim.shown.iter().filter_map(observer).collect();
    let mut run: Shown = Vec::new();
    for (time, state) in states {
        let passes = state.moves().is_ok_and(|moves| state.patience(&moves) != Patience::None);
        if !passes {
            continue;
        }
        let mut seen = shown(state);
        seen.retain(|term| observer(term).is_some_and(|name| names.contains(&name)));
        if run.last().is_none_or(|(_, before)| *before != seen) {
            run.push((Value::rational(time.clone()), seen));
        }
    }
    run
}

fn observer(term: &Term) -> Option<crate::name::Name> {
    match term.node() {
        Node::Observe(name, _) => Some(name.clone()),
        _ => None,
    }
}

/// Whether a state in which time passes shows what the claim speaks of.
pub fn speaks(states: &[State], claim: &Claim) -> bool {
    let applies = |state: &State| {
        let duties = claim.duties(&shown(state)).unwrap_or_default();
        let met = |duty: &crate::invariant::Duty| {
            duty.premises.iter().all(|premise| premise.decide(&Assumptions::default()) != Some(false))
        };
        duties.iter().any(met)
    };
    let passes = |state: &&State| state.moves().is_ok_and(|moves| state.patience(&moves) != Patience::None);
    states.iter().filter(passes).any(applies)
}

/// The least, or greatest, value that the left side of a claim's only test takes where time passes, as that is what
/// its right side bounds; a text.
pub fn extreme(states: &[State], claim: &Claim) -> Option<String> {
    let [test] = claim.tests.as_slice() else { return None };
    let least = match test.relation {
        Relation::Gtr | Relation::Gte => true,
        Relation::Lss | Relation::Lte => false,
        _ => return None,
    };
    let passes = |state: &&State| state.moves().is_ok_and(|moves| state.patience(&moves) != Patience::None);
    let mut values: Vec<BigRational> = Vec::new();
    for state in states.iter().filter(passes) {
        for duty in claim.duties(&shown(state)).ok()? {
            values.push(duty.tests.first()?.left.as_rational()?);
        }
    }
    let (word, value) = if least { ("least", values.iter().min()?) } else { ("greatest", values.iter().max()?) };
    Some(format!("the {word} {} in the whole run is {}", test.left, Value::rational(value.clone())))
}
