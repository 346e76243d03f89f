//! The run of a closed system as time goes on, until it repeats; and whether it can be what a property asks for, with
//! any durations at all. A property is refuted where it cannot: a match that was not found refutes nothing.

mod asking;
mod fit;

use std::collections::{BTreeMap, BTreeSet, HashMap};

use num_rational::BigRational;
use num_traits::{Signed, ToPrimitive};

use crate::assumption::Assumptions;
use crate::definition::Definitions;
use crate::model::{Action, Model, Patience, State};
use crate::name::Name;
use crate::period::{Segment, Test};
use crate::term::{Node, Term};
use crate::value::{Relation, Value};
use crate::verify::Outcome;
use crate::verify::property::Wanted;
use crate::verify::trajectory::{Leg, Rounds};
use crate::verify::unit::Unit;

pub use fit::{Misfit, misfit};

use asking::Asking;

/// Stretches of time between two changes after which a run is followed no further.
const MOST_STRETCHES: usize = 2_000;
/// Internal steps in one instant after which it is followed no further.
const MOST_STEPS: usize = 2_000;
/// Rounds of a leg that are looked at one by one.
const MOST_ROUNDS: i64 = 300;
/// The longest term of a run, in operators.
const MOST_TERM: usize = 5_000;
/// Bits of a number at which it is followed no further; of one with roots, which takes longer to compute with.
const MOST_BITS: u64 = 4_000;
const MOST_BITS_BESIDE_ROOTS: u64 = 500;

/// What may be shown: an observer, with its values where they are known.
pub type Sight = (Name, Option<Vec<Value>>);

/// A stretch of time in which nothing changes: how long, and what may be shown.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stretch {
    /// Its duration, greater than 0.
    pub duration: BigRational,
    /// All that may be shown; of what is not among it nothing is.
    pub shown: BTreeSet<Sight>,
}

/// What comes after the stretches of a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum After {
    /// These, again and again.
    Round(Vec<Stretch>),
    /// Nothing: the system has ended.
    End,
    /// Nothing: time stops, since internal steps go on for ever or nothing can happen.
    TimeStop,
    /// What is not known.
    Unknown,
}

/// A run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lasso {
    /// From the start.
    pub stretches: Vec<Stretch>,
    /// And then.
    pub after: After,
    /// Whether the run was not followed to its end, and what comes after is all that it may show from then on.
    pub bounded: bool,
    /// Whether what comes after is one stretch without end.
    pub endless: bool,
}

impl Lasso {
    /// The run of a closed system in which the first of several internal steps is taken, as far as it is followed until
    /// the work is `interrupted`.
    pub fn of(system: &Term, definitions: &Definitions, interrupted: &dyn Fn() -> bool) -> Lasso {
        let model = Model::new(definitions);
        let mut lasso = Lasso { stretches: Vec::new(), after: After::Unknown, bounded: false, endless: false };
        let Ok(mut state) = model.state(system) else { return lasso };
        let mut seen: HashMap<State, usize> = HashMap::new();
        while lasso.stretches.len() < MOST_STRETCHES && !interrupted() {
            let settled = match calm(&model, state) {
                Calm::Waits(state) => state,
                Calm::Ended => {
                    lasso.after = After::End;
                    return lasso;
                }
                Calm::Never => {
                    lasso.after = After::TimeStop;
                    return lasso;
                }
                Calm::Unknown => return lasso,
            };
            if let Some(start) = seen.get(&settled) {
                lasso.after = After::Round(lasso.stretches.split_off(*start));
                return lasso;
            }
            let Some((stretch, endless, next)) = stretch(&model, &settled) else { return lasso };
            if endless {
                (lasso.after, lasso.endless) = (After::Round(vec![stretch]), true);
                return lasso;
            }
            seen.insert(settled, lasso.stretches.len());
            lasso.stretches.push(stretch);
            state = next;
        }
        lasso
    }

    /// How long it takes from one state of the system to the same again, and from what time on that is so.
    pub fn round(&self) -> Option<(BigRational, BigRational)> {
        let After::Round(round) = &self.after else { return None };
        let total = |stretches: &[Stretch]| stretches.iter().map(|stretch| stretch.duration.clone()).sum();
        (!self.endless && !self.bounded).then(|| (total(round), total(&self.stretches)))
    }

    /// Where the run is not known to its end, all that its legs can show, if the last of them goes on for ever, or they
    /// come to a turn that moves on inside an interval. In which leg the run was left is not known.
    pub fn with_last_legs(mut self, outcome: &Outcome, wanted: &Wanted, values: &BTreeMap<Name, Value>) -> Lasso {
        let legs = &outcome.legs;
        let whole = |leg: &Leg| leg.conditions.is_empty() && !leg.units.is_empty();
        if self.after != After::Unknown || !legs.iter().all(whole) {
            return self;
        }
        let mut known = Assumptions::default();
        match (&outcome.orbit, legs.last()) {
            (Some((_, orbit)), _) => {
                for moving in &orbit.moving {
                    let symbol = Value::variable(&moving.symbol);
                    match &moving.between {
                        Some((low, high)) => {
                            known.assume(Relation::Gte, &symbol, low);
                            known.assume(Relation::Lte, &symbol, high);
                        }
                        None => known.assume_natural(&moving.symbol),
                    }
                }
            }
            (None, Some(leg)) if matches!(leg.rounds, Rounds::Forever(_)) => {}
            // The legs repeat in what the property depends on, though the run may not.
            (None, Some(_)) if outcome.period_term.is_some() => {}
            _ => return self,
        }
        let tests: Vec<Test> = wanted.wants.iter().flat_map(|want| want.tests.iter().cloned()).collect();
        let shown = wanted.wants.iter().flat_map(|want| &want.shown);
        let asking: Option<Vec<Asking>> = shown.map(|term| Asking::of(term, &tests, values)).collect();
        let all = || outcome.opening.iter().chain(legs.iter().flat_map(|leg| &leg.units)).collect::<Vec<&Unit>>();
        let units = match self.round_of_last(&all(), values) {
            Some((last, index, number)) => {
                known.assume(Relation::Gte, &Value::variable(index), &number);
                vec![last]
            }
            None => all(),
        };
        if let Some(shown) = asking.and_then(|asking| ever_shown(units.into_iter(), &asking, values, &known)) {
            self.bounded = true;
            self.after = After::Round(vec![Stretch { duration: BigRational::from_integer(1.into()), shown }]);
        }
        self
    }

    /// The last of these, where it is rounds for ever that last equally long, with a number of a round that has begun, or
    /// is over, where the run was left: what is shown from then on is shown by that round or a later one.
    fn round_of_last<'u>(
        &self,
        units: &[&'u Unit],
        values: &BTreeMap<Name, Value>,
    ) -> Option<(&'u Unit, &'u Name, Value)> {
        let (last, before) = units.split_last()?;
        let Unit::Repeat { count: None, index, segments } = last else { return None };
        let number = |value: &Value| value.substitute(values).ok()?.as_rational();
        let round: BigRational = segments.iter().map(|segment| number(&segment.duration)).sum::<Option<_>>()?;
        let earlier = before.iter().map(|unit| number(&unit.duration().ok()??)).sum::<Option<BigRational>>()?;
        let so_far: BigRational = self.stretches.iter().map(|stretch| stretch.duration.clone()).sum();
        let over = so_far - earlier;
        (round.is_positive() && over.is_positive()).then(|| (*last, index, Value::rational((over / round).floor())))
    }
}

enum Calm {
    Waits(State),
    Ended,
    Never,
    Unknown,
}

/// The state once all internal steps of this instant are done.
fn calm(model: &Model<'_>, mut state: State) -> Calm {
    let mut passed: BTreeSet<State> = BTreeSet::new();
    for _ in 0..MOST_STEPS {
        let Ok(moves) = state.moves() else { return Calm::Unknown };
        if moves.iter().any(|step| matches!(step.action, Action::Draw(..))) {
            return Calm::Unknown;
        }
        let Some(step) = moves.iter().find(|step| matches!(step.action, Action::Tau(..))) else {
            return if matches!(state, State::Running(_)) { Calm::Waits(state) } else { Calm::Ended };
        };
        let Ok(next) = model.state(&step.next) else { return Calm::Unknown };
        if !passed.insert(std::mem::replace(&mut state, next)) {
            return Calm::Never;
        }
    }
    Calm::Unknown
}

/// What passes until something changes, whether that is for ever, and the state then.
fn stretch(model: &Model<'_>, state: &State) -> Option<(Stretch, bool, State)> {
    let moves = state.moves().ok()?;
    let shown: BTreeSet<Sight> = state.observations().into_iter().map(|(name, values)| (name, Some(values))).collect();
    let large =
        |value: &Value| value.bits() > if value.atoms().is_empty() { MOST_BITS } else { MOST_BITS_BESIDE_ROOTS };
    let sight = |sight: &Sight| sight.1.iter().flatten().any(large);
    if shown.iter().any(sight) || state.term().size() > MOST_TERM {
        return None;
    }
    match state.patience(&moves) {
        Patience::None => None,
        Patience::Unbounded => {
            let duration = BigRational::from_integer(1.into());
            Some((Stretch { duration, shown }, true, state.clone()))
        }
        Patience::Until(duration) => {
            let next = model.wait_state(state, &duration).ok()??;
            Some((Stretch { duration, shown }, false, next))
        }
    }
}

/// The segments of all rounds, where there are few.
fn each_round(unit: &Unit, count: Option<&Value>) -> Option<Vec<Segment>> {
    let count = count?.as_rational()?.to_integer().to_i64().filter(|count| *count <= MOST_ROUNDS)?;
    let rounds: Option<Vec<Vec<Segment>>> = (0..count).map(|number| unit.round(&Value::integer(number)).ok()).collect();
    Some(rounds?.into_iter().flatten().collect())
}

/// All that stretches may show that is wanted, in any of their rounds.
fn ever_shown<'a>(
    units: impl Iterator<Item = &'a Unit>,
    wanted: &[Asking],
    values: &BTreeMap<Name, Value>,
    known: &Assumptions,
) -> Option<BTreeSet<Sight>> {
    let mut shown = BTreeSet::new();
    for unit in units {
        let (segments, index) = match unit {
            Unit::Single(segment) => (vec![segment.clone()], None),
            Unit::Repeat { segments, index, count } => match each_round(unit, count.as_ref()) {
                Some(all) => (all, None),
                None => (segments.clone(), Some(index)),
            },
        };
        for term in segments.iter().flat_map(|segment| &segment.observed) {
            let Node::Observe(name, own) = term.node() else { return None };
            let own: Vec<Value> = own.iter().map(|value| value.substitute(values).ok()).collect::<Option<_>>()?;
            if own.iter().all(|value| value.variables().is_empty()) {
                shown.insert((name.clone(), Some(own)));
            } else if wanted.iter().any(|asking| asking.may_become(name, &own, index, known)) {
                shown.insert((name.clone(), None));
            }
        }
    }
    Some(shown)
}
