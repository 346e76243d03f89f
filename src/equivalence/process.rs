//! Closed processes compared by the systems that they are.

use num_rational::BigRational;
use num_traits::Zero;

use super::cells::by_cells;
use super::judge::Doubt;
use super::replay::choices;
use super::run::{RunStep, stands};
use super::{Preorder, Verdict, decide, strong_classes};
use crate::bisimulation::{Comparison, Reach, compare_densely};
use crate::definition::Definitions;
use crate::model::{Model, State};
use crate::term::Term;
use crate::transition_system::{
    Behaviour, Bounds, Clock, Cut, Generated, Inputs, Process, TransitionSystem, Trouble, generate, generate_pair,
};

/// How many foreign values are tried first for what is read from outside, and at most.
const OTHERS: [usize; 3] = [2, 3, 5];

/// What came of comparing two processes.
#[derive(Clone, Debug)]
pub struct ProcessAnswer {
    /// The answer.
    pub verdict: Verdict,
    /// What the states of each system are, for the run.
    pub states: [Vec<State>; 2],
    /// The number of states of each.
    pub sizes: [usize; 2],
    /// Where communications are offered while delays run, and were not tried at every moment that matters: they were
    /// tried at the multiples of this, so that "yes" says nothing of other times.
    pub moments: Option<BigRational>,
    /// Whether the values that were read stand for all.
    enough: bool,
    /// Whether chances are not exact, and whether what depends on a value in a cell was seen.
    pub(super) cells: (bool, bool),
    /// Whether it is not decided, and a value was drawn that is not known.
    open_draws: bool,
    /// For "no", the choices that lead each side through the run, as the stepper saves them; none where the side stands
    /// still.
    pub choices: [Vec<String>; 2],
}

/// The system of one closed process, for people or for comparing it with itself; what is read is one of a few values.
///
/// # Errors
/// [`Trouble`] where a state that is reached has no meaning.
pub fn system_of(
    term: &Term,
    definitions: &Definitions,
    bounds: &Bounds,
    stop: &dyn Fn() -> bool,
) -> Result<Generated<State>, Trouble> {
    let inputs = Inputs::of(&[term], definitions, OTHERS[0]);
    generate(&Process::new(term.clone(), definitions, Clock::Events, inputs), bounds, stop)
}

/// The smallest system that is strongly bisimilar to a closed process, with its time put together, and the number of
/// states of the process in ticks.
///
/// # Errors
/// [`Trouble`] where a state that is reached has no meaning, or depends on the value of a continuous draw.
pub fn minimised_system(
    term: &Term,
    definitions: &Definitions,
    bounds: &Bounds,
    stop: &dyn Fn() -> bool,
) -> Result<(TransitionSystem, usize), Trouble> {
    let inputs = Inputs::of(&[term], definitions, OTHERS[0]);
    let stopped = Term::stop();
    let (_, [found, _]) = generate_pair([term, &stopped], definitions, &inputs, bounds, 0, stop)?;
    let classes = strong_classes(&found.system, bounds.bytes);
    let mut small = match &classes {
        Some(classes) => found.system.quotient(classes, false).with_time_together(),
        None => found.system.clone(),
    };
    if classes.is_none() {
        small.cut = small.cut.or(Some(Cut::Memory(bounds.bytes)));
    }
    Ok((small, found.system.states()))
}

/// Compares two closed processes: both in the same ticks, and what they read from outside is one of a few values. Where
/// these do not stand for all, "yes" is unknown.
///
/// # Errors
/// [`Trouble`] where a state that is reached has no meaning, or depends on the value of a continuous draw.
pub fn compare_processes(
    left: &Term,
    right: &Term,
    definitions: &Definitions,
    relation: Preorder,
    bounds: &Bounds,
    stop: &dyn Fn() -> bool,
) -> Result<ProcessAnswer, Trouble> {
    let mut last = None;
    for others in OTHERS {
        let mut inputs = Inputs::of(&[left, right], definitions, others);
        let found = at_ticks([left, right], definitions, &inputs, relation, bounds, 0, stop);
        let mut found = match found {
            Ok(found) if !found.open_draws => found,
            other => match by_cells([left, right], definitions, &inputs, relation, bounds, stop) {
                Some((cut, found)) => {
                    inputs = cut;
                    found
                }
                None => other?,
            },
        };
        if inputs.cuts.is_none() && found.moments.is_some() && matches!(found.verdict, Verdict::Yes) && left != right {
            found = at_all_times(found, [left, right], definitions, &inputs, relation, bounds, stop)?;
        }
        let more_helps = inputs.symmetric && !relation.is_trace();
        let settled = !matches!(found.verdict, Verdict::Yes) || found.enough;
        if !settled {
            found.verdict = Verdict::Unknown(untried(&inputs));
        }
        last = Some(found);
        if settled || !more_helps {
            break;
        }
    }
    last.ok_or(Trouble::Coarse)
}

/// Compares them at the ends of ticks, halved so often.
pub(super) fn at_ticks(
    terms: [&Term; 2],
    definitions: &Definitions,
    inputs: &Inputs,
    relation: Preorder,
    bounds: &Bounds,
    finer: u32,
    stop: &dyn Fn() -> bool,
) -> Result<ProcessAnswer, Trouble> {
    let (processes, [one, two]) = generate_pair(terms, definitions, inputs, bounds, finer, stop)?;
    let verdict = judged(&processes, [&one, &two], relation, bounds, stop);
    let sizes = [one.system.states(), two.system.states()];
    let reads = processes.iter().any(Process::reads);
    // Sets of states, which traces need, may hold more values than two states do.
    let enough = !reads || (!relation.is_trace() && inputs.suffice(&processes, [&one.states, &two.states]));
    let choices = replayed(&verdict, inputs, definitions, terms, [&one.states, &two.states], relation);
    let moments = processes[0].tick().filter(|_| processes[0].is_fine()).cloned();
    let exact = processes.iter().all(|process| process.slack().is_zero());
    let cells = (!exact, processes.iter().any(|process| process.draws().seen()));
    let touched = processes.iter().any(|process| process.draws().touched());
    let open_draws = touched && matches!(verdict, Verdict::Unknown(_));
    Ok(ProcessAnswer { verdict, states: [one.states, two.states], sizes, moments, enough, cells, open_draws, choices })
}

/// The pairs of states that are looked into for every moment.
const MOST_PAIRS: usize = 100_000;
/// How often ticks are halved to find the evidence for a difference between them.
const MOST_HALVED: u32 = 3;

/// Looks again at two that are alike at all ticks, at every moment that matters, where that is decided.
fn at_all_times(
    mut found: ProcessAnswer,
    terms: [&Term; 2],
    definitions: &Definitions,
    inputs: &Inputs,
    relation: Preorder,
    bounds: &Bounds,
    stop: &dyn Fn() -> bool,
) -> Result<ProcessAnswer, Trouble> {
    let (Preorder::Strong | Preorder::Refinement, Some(unit)) = (relation, found.moments.clone()) else {
        return Ok(found);
    };
    // A delay that is only met between ticks might not be a multiple of them.
    if !inputs.fixed_delays {
        return Ok(found);
    }
    let reach = Reach { pairs: MOST_PAIRS.min(bounds.states), inputs: inputs.values.clone() };
    let refines = relation == Preorder::Refinement;
    match compare_densely(terms[0], terms[1], refines, definitions, &reach, &unit)? {
        Comparison::Same => found.moments = None,
        Comparison::Unknown(_) => {}
        Comparison::Different(_) => {
            for finer in 2..2 + MOST_HALVED {
                let closer = at_ticks(terms, definitions, inputs, relation, bounds, finer, stop)?;
                if matches!(closer.verdict, Verdict::No(_)) {
                    return Ok(closer);
                }
            }
            let why =
                format!("alike at multiples of {unit}, but not at other times; no formula was found that shows it");
            found.verdict = Verdict::Unknown(why);
        }
    }
    Ok(found)
}

/// The choices of each side.
fn replayed(
    verdict: &Verdict,
    inputs: &Inputs,
    definitions: &Definitions,
    terms: [&Term; 2],
    states: [&[State]; 2],
    relation: Preorder,
) -> [Vec<String>; 2] {
    let Verdict::No(evidence) = verdict else { return [Vec::new(), Vec::new()] };
    let model = Model::new(definitions);
    let side = |side: usize| {
        let state = |number: u32| states[side].get(number as usize).cloned();
        let after = |step: &RunStep| (if side == 0 { step.left } else { step.right }).and_then(state);
        let start = model.state(terms[side]).ok()?;
        choices(&model, inputs, &start, &evidence.run, &after, relation.is_weak())
    };
    [side(0).unwrap_or_default(), side(1).unwrap_or_default()]
}

fn untried(inputs: &Inputs) -> String {
    let values: Vec<String> = inputs.values.iter().map(ToString::to_string).collect();
    format!("no difference while only {} are read from outside, which may not stand for all values", values.join(", "))
}

fn judged(
    processes: &[Process; 2],
    generated: [&Generated<State>; 2],
    relation: Preorder,
    bounds: &Bounds,
    stop: &dyn Fn() -> bool,
) -> Verdict {
    let [one, two] = generated;
    let systems: [&TransitionSystem; 2] = [&one.system, &two.system];
    let verdict = decide(systems[0], systems[1], relation, bounds, stop);
    let Verdict::No(evidence) = &verdict else { return verdict };
    let cut = systems[0].cut.or(systems[1].cut);
    let left = |state: u32| one.states.get(state as usize).cloned();
    let right = |state: u32| two.states.get(state as usize).cloned();
    // The model itself is asked, not the systems: so that a difference stands even where a bound was hit.
    processes.iter().for_each(|process| process.draws().forget());
    let stood = stands(evidence, [&processes[0], &processes[1]], [&left, &right], relation);
    if processes.iter().any(|process| process.draws().touched()) {
        let why = "the difference found rests on a value drawn from a continuous distribution; `prove` looks for one that does not";
        return Verdict::Unknown(why.into());
    }
    match (stood, cut) {
        (Ok(true), _) => verdict,
        (_, Some(cut)) => Verdict::Unknown(cut.to_string()),
        (Ok(false), None) => Verdict::Unknown("a difference was found that did not stand up to being checked".into()),
        (Err(Doubt::Close), None) => {
            Verdict::Unknown("a difference was found, but chances differ by less than they may be off".into())
        }
        (Err(_), None) => Verdict::Unknown("a difference was found, but checking it takes too much".into()),
    }
}
