//! The run of the system, leg by leg: rounds of one phase counted by its recurrence, until a leg starts as an
//! earlier one did.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};

use super::by_turns::{LegTurns, Parts};
use super::copies::Copies;
use super::count::Count;
use super::orbit::{Orbit, fresh, observers, without_moving};
use super::round::{Turn, is_known, is_long};
use super::supposed::Supposed;
use super::undecided::{self, Unsure, too_far};
use super::unit::Unit;
use crate::assumption::Assumptions;
use crate::definition::Definitions;
use crate::name::Name;
use crate::period::{Edge, End, Next, Period, Phase, Segment, Test};
use crate::recurrence::{Closed, Comparison};
use crate::scope::{bound_names, read_names};
use crate::term::Term;
use crate::value::{Atom, Relation, Value};

/// Rounds that are followed one by one where there is no closed form.
const MOST_ROUNDS: usize = 2_000;

/// How often a leg goes round.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Rounds {
    /// So many times.
    Count(Value),
    /// For ever; the reason.
    Forever(String),
}

/// A stretch of the run in one phase.
#[derive(Clone, Debug)]
pub struct Leg {
    /// The phase's number.
    pub phase: usize,
    /// How many rounds.
    pub rounds: Rounds,
    /// The variables at its start.
    pub start: BTreeMap<Name, Value>,
    /// The variables that change, with their closed forms.
    pub closed: Vec<(Name, Closed)>,
    /// The index that the closed forms use.
    pub index: Name,
    /// What the closed forms and the count rest on.
    pub conditions: Vec<Test>,
    /// Whether the leg goes on in the phase of the leg before.
    pub continues: bool,
    /// Its stretches.
    pub units: Vec<Unit>,
    /// The inequality that keeps its phase going, where there is one: the phase ends when both sides are equal.
    pub kept: Option<Test>,
}

/// The run of a system.
#[derive(Clone, Debug, Default)]
pub struct Trajectory {
    /// What passes before the first leg.
    pub opening: Vec<Unit>,
    /// The legs; from `cycle` on they repeat.
    pub legs: Vec<Leg>,
    /// Where the repetition starts.
    pub cycle: Option<usize>,
    /// What moves on from turn to turn, where the repetition is not exact: its legs are in these symbols.
    pub orbit: Option<Orbit>,
    /// How the run ends, if it does.
    pub end: Option<End>,
    /// Why the run is not known any further.
    pub open: Vec<String>,
    /// What is not decided there.
    pub asked: Vec<Comparison>,
    /// Whether no way through the phases ends the run or stops time: what is not known of it goes on for ever too.
    pub unending: bool,
    /// What is assumed, with what was found.
    pub assumptions: Assumptions,
    /// Counts of rounds that are supposed to exist, where this is asked.
    pub supposed: Vec<Supposed>,
    /// A name that means nothing yet.
    pub(super) symbol: Option<Name>,
    /// The legs that the last leg is by turns, which is for ever, where it is several.
    pub(super) parts: Parts,
    /// Whether it goes on by turns in which something counts on.
    pub(super) counts: bool,
}

/// Follows a run.
#[derive(Clone)]
pub(super) struct Walker<'a> {
    pub(super) period: &'a Period,
    pub(super) assumptions: Assumptions,
    pub(super) index: Name,
    /// Names that mean something already.
    pub(super) taken: BTreeSet<Name>,
    /// The wish to stop.
    pub(super) interrupted: &'a dyn Fn() -> bool,
    /// The leg that was given up, as far as it was followed.
    pub(super) partial: RefCell<Option<Leg>>,
    /// The counts that are supposed so far, where a phase is supposed to end of which it is not known.
    pub(super) supposed: Option<Vec<Supposed>>,
}

/// Why a run that was interrupted is not known any further.
const INTERRUPTED: &str = "interrupted";

impl Trajectory {
    /// The legs that are known with all their values: all, or those before the turns that move on.
    pub fn certain(&self) -> &[Leg] {
        match (&self.orbit, self.cycle) {
            (Some(_), Some(cycle)) => &self.legs[..cycle.min(self.legs.len())],
            _ => &self.legs,
        }
    }
}

/// The index of the rounds of a run that has come to rest: no name of a mission.
const STILL: &str = "[still]";

/// What is shown for ever, of the rounds of a run that has come to rest.
pub(super) fn at_rest(unit: &Unit) -> Option<&[Term]> {
    match unit {
        Unit::Repeat { count: None, index, segments } if index.as_str() == STILL => {
            segments.first().map(|segment| segment.observed.as_slice())
        }
        _ => None,
    }
}

impl Trajectory {
    /// What a run that has come to rest shows from then on, unit of time by unit of time.
    pub(super) fn still(&self) -> Option<Unit> {
        let Some(End::Silent { observed, .. }) = &self.end else { return None };
        let segments = vec![Segment { duration: Value::one(), observed: observed.clone() }];
        Some(Unit::Repeat { count: None, index: Name::new(STILL), segments })
    }

    /// A run that comes to rest as one that repeats what it shows then, with the place of that.
    pub(super) fn resting(&self) -> Option<(Trajectory, usize)> {
        let round = self.still()?.round(&Value::zero()).ok()?;
        let mut resting = self.clone();
        let cycle = resting.legs.len();
        let last = resting.legs.last()?.clone();
        let units = round.into_iter().map(Unit::Single).collect();
        let rounds = Rounds::Count(Value::one());
        resting.legs.push(Leg { rounds, closed: Vec::new(), units, continues: false, kept: None, ..last });
        resting.cycle = Some(cycle);
        resting.end = None;
        Some((resting, cycle))
    }
}

/// Assumes a test, unless it is of numbers and so known.
fn learn(assumptions: &mut Assumptions, test: &Test) {
    let of_numbers = test.left.variables().is_empty() && test.right.variables().is_empty();
    if !of_numbers || test.decide(assumptions) != Some(true) {
        assumptions.assume(test.relation, &test.left, &test.right);
    }
}

/// Whether it is an equation of what is cut off at a bound: beside the place where a leg ends it tells nothing, and every
/// later question would have to look at it.
fn is_cut_off(test: &Test) -> bool {
    let of = |value: &Value| value.atoms().iter().any(|atom| matches!(atom, Atom::Maximum(_)));
    test.relation == Relation::Eq && (of(&test.left) || of(&test.right))
}

/// Variables with their values.
pub(super) type Values = BTreeMap<Name, Value>;

/// Follows the run until it repeats, ends, or is not known any further. The property and the definitions tell which names
/// are taken.
pub fn walk(
    period: &Period,
    (definitions, assumptions): (&Definitions, &Assumptions),
    property: &Term,
    interrupted: &dyn Fn() -> bool,
) -> Trajectory {
    walk_from(period, (definitions, assumptions), property, None, interrupted)
}

/// The same; where `supposed` is given, each phase of which it is not known when it ends is supposed to end.
pub(super) fn walk_from(
    period: &Period,
    (definitions, assumptions): (&Definitions, &Assumptions),
    property: &Term,
    supposed: Option<Vec<Supposed>>,
    interrupted: &dyn Fn() -> bool,
) -> Trajectory {
    let mut taken: BTreeSet<Name> = assumptions.variables();
    // A count of rounds must not be called what copies are numbered by.
    let states = period.phases.iter().flat_map(|phase| &phase.state);
    for term in period.components.iter().chain(states).chain([property]) {
        taken.extend(read_names(term));
        taken.extend(bound_names(term));
    }
    taken.extend(period.phases.iter().flat_map(|phase| phase.variables.iter().cloned()));
    let index = ["i", "j", "k", "n"].into_iter().map(Name::new).find(|name| !taken.contains(name));
    let index = index.unwrap_or_else(|| Name::new("index"));
    // A symbol must not be bound by any process, whether it takes part or not.
    for definition in definitions.iter() {
        taken.extend(definition.parameters.iter().cloned());
        taken.extend(bound_names(&definition.body));
    }
    let partial = RefCell::new(None);
    let mut walker = Walker { period, assumptions: assumptions.clone(), index, taken, interrupted, partial, supposed };
    let unending = unending(period);
    let mut trajectory = Trajectory { unending, ..Trajectory::default() };
    if let Err(unsure) = walker.run(&mut trajectory) {
        (trajectory.open, trajectory.asked) = (unsure.reasons, unsure.asked);
        trajectory.legs.extend(walker.partial.take());
    }
    if let (Some(orbit), Some(cycle)) = (&trajectory.orbit, trajectory.cycle) {
        without_moving(&mut trajectory.legs[cycle..], orbit, &observers(property));
    }
    trajectory.symbol = Some(fresh(&walker.index, &mut walker.taken));
    trajectory.assumptions = walker.assumptions;
    trajectory.supposed = walker.supposed.unwrap_or_default();
    trajectory
}

/// Whether every run goes on for ever, and time with it: no way ends or draws, and what a way lasts is the same in every
/// round, so that it does not shrink.
fn unending(period: &Period) -> bool {
    let goes_on = |edge: &Edge| matches!(edge.next, Next::Phase(_)) && edge.draws.is_empty();
    let steady = |phase: &Phase| {
        let fixed = |segment: &Segment| !phase.variables.iter().any(|name| segment.duration.mentions(name));
        phase.edges.iter().all(|edge| goes_on(edge) && edge.segments.iter().all(fixed))
    };
    period.initial.iter().all(goes_on) && period.phases.iter().all(steady)
}

/// Values after rounds by the closed forms, which say in simpler words what a round does to these variables.
fn said_by_forms(closed: &[(Name, Closed)], after: &Values, as_before: impl Fn(&Name) -> bool) -> Values {
    let names = closed.iter().map(|(name, _)| name).filter(|name| as_before(name));
    names.filter_map(|name| Some((name.clone(), after.get(name)?.clone()))).collect()
}

impl Walker<'_> {
    fn run(&mut self, trajectory: &mut Trajectory) -> Result<(), Unsure> {
        let edge = self.choose(&self.period.initial, &Values::new(), &self.assumptions)?;
        trajectory.opening = self.units_once(edge, &Values::new())?;
        let mut next = self.onward(edge, &Values::new())?;
        let mut values = self.image(edge, &Values::new())?;
        let mut history: Vec<(usize, Values)> = Vec::new();
        let mut changes = 0usize;
        let mut before = None;
        loop {
            let phase = match next {
                Next::End(end) => {
                    trajectory.end = Some(end);
                    return Ok(());
                }
                Next::Phase(phase) => phase,
            };
            let here = (phase, values.clone());
            if let Some(found) = history.iter().position(|earlier| *earlier == here) {
                trajectory.cycle = Some(found);
                return Ok(());
            }
            history.push(here);
            if let Some(turn) = self.turn(trajectory, phase, &values) {
                trajectory.cycle = Some(trajectory.legs.len());
                trajectory.legs.extend(turn.legs);
                trajectory.orbit = Some(turn.orbit);
                self.assumptions = turn.assumptions;
                return Ok(());
            }
            if (self.interrupted)() {
                return Err(Unsure::because(INTERRUPTED.to_string()));
            }
            changes += usize::from(before != Some(phase));
            too_far(history.len() - 1, changes, &values)?;
            let turns = self.legs_by_turns(&trajectory.legs, &history);
            let (parts, found) = match turns {
                Some(LegTurns { round, count, legs }) => (legs, self.counted(phase, &round, &values, count)),
                None => (Vec::new(), self.leg(phase, &values)),
            };
            let (mut leg, onward) = match found {
                Ok(found) => found,
                Err(unsure) => {
                    let Some(Copies { from, leg, onward }) = self.copies(&history) else { return Err(unsure) };
                    trajectory.legs.truncate(from);
                    history.truncate(from + 1);
                    (leg, onward)
                }
            };
            leg.continues = before == Some(phase);
            let forever = matches!(leg.rounds, Rounds::Forever(_));
            if forever {
                trajectory.goes_on(leg, parts);
                return Ok(());
            }
            trajectory.legs.push(leg);
            before = Some(phase);
            (next, values) = onward;
        }
    }

    /// One leg from these values, and where it leads.
    pub(super) fn leg(&mut self, phase: usize, values: &Values) -> Result<(Leg, (Next, Values)), Unsure> {
        let period = self.period;
        let Some(here) = period.phases.get(phase) else {
            return Err(Unsure::because("a phase is missing".to_string()));
        };
        let rounds: Vec<&Edge> = here.rounds(phase).collect();
        if rounds.len() > 1
            && let Some((round, count)) = self.one_of_several(phase, &here.edges, values)
        {
            return self.counted(phase, round, values, count);
        }
        if let [round] = rounds.as_slice() {
            match self.count(round, values) {
                Ok(count) => return self.counted(phase, round, values, count),
                Err(unsure) => {
                    // Without a closed form, numbers can still be followed one by one.
                    let other = if values.values().all(is_known) {
                        match self.stepwise(phase, values) {
                            Ok(found) => return Ok(found),
                            Err(other) => other,
                        }
                    } else {
                        self.choose(&here.edges, values, &self.assumptions).err().unwrap_or_default()
                    };
                    return match self.suppose(round, values) {
                        Some(count) => self.counted(phase, round, values, count),
                        None => Err(other.and(unsure)),
                    };
                }
            }
        }
        self.stepwise(phase, values)
    }

    /// Rounds one by one until the phase is left or the values repeat.
    fn stepwise(&mut self, phase: usize, values: &Values) -> Result<(Leg, (Next, Values)), Unsure> {
        let period = self.period;
        let Some(here) = period.phases.get(phase) else {
            return Err(Unsure::because("a phase is missing".to_string()));
        };
        let mut rounds: Vec<(&Edge, Values)> = Vec::new();
        let mut now = values.clone();
        let next = loop {
            if (self.interrupted)() {
                return Err(Unsure::because(INTERRUPTED.to_string()));
            }
            if let Some(found) = rounds.iter().position(|(_, earlier)| *earlier == now) {
                rounds.truncate(if found == 0 { rounds.len() } else { found });
                break Next::Phase(phase);
            }
            if rounds.len() >= MOST_ROUNDS || now.values().any(is_long) {
                *self.partial.borrow_mut() = Some(self.stepped(phase, values, &rounds)?);
                return Err(Unsure::because(format!(
                    "after {} rounds of one phase nothing has repeated",
                    rounds.len()
                )));
            }
            let edge = self.choose(&here.edges, &now, &self.assumptions)?;
            let onward = self.image(edge, &now)?;
            rounds.push((edge, std::mem::replace(&mut now, onward)));
            if edge.next != Next::Phase(phase) {
                break self.onward(edge, &rounds[rounds.len() - 1].1)?;
            }
            // Symbols are followed one round at a time.
            if !now.values().all(is_known) {
                break Next::Phase(phase);
            }
            if let Some(turns) = self.by_turns(&rounds) {
                if turns.from == 0 {
                    return self.counted(phase, &turns.round, values, turns.count);
                }
                now = rounds[turns.from].1.clone();
                rounds.truncate(turns.from);
                break Next::Phase(phase);
            }
        };
        Ok((self.stepped(phase, values, &rounds)?, (next, now)))
    }

    /// Rounds that were followed one by one, as a leg.
    fn stepped(&self, phase: usize, values: &Values, rounds: &[(&Edge, Values)]) -> Result<Leg, Unsure> {
        Ok(Leg {
            phase,
            rounds: Rounds::Count(Value::integer(rounds.len() as i64)),
            start: values.clone(),
            closed: Vec::new(),
            index: self.index.clone(),
            conditions: Vec::new(),
            continues: false,
            units: self.compressed(rounds)?,
            kept: self.always_kept(phase, rounds),
        })
    }

    /// A leg whose rounds are counted.
    fn counted(
        &mut self,
        phase: usize,
        round: &Edge,
        values: &Values,
        count: Count,
    ) -> Result<(Leg, (Next, Values)), Unsure> {
        let kept = count.stays.is_none().then(|| self.kept(phase, round)).flatten();
        let mut leg = Leg {
            phase,
            rounds: Rounds::Forever(count.reason.clone()),
            start: values.clone(),
            closed: count.closed.clone(),
            index: self.index.clone(),
            conditions: count.conditions.clone(),
            continues: false,
            units: Vec::new(),
            kept,
        };
        let Some(stays) = count.stays else {
            if let Some(Turn { rounds, onward, shown }) = self.until_it_repeats(values, &count) {
                leg.units = self.units(&round.segments, values, &shown, Some(&rounds))?;
                leg.rounds = Rounds::Count(rounds);
                return Ok((leg, (Next::Phase(phase), onward)));
            }
            leg.units = self.units(&round.segments, values, &count.closed, None)?;
            return Ok((leg, (Next::Phase(phase), values.clone())));
        };
        let mut assumptions = self.assumptions.clone();
        for condition in &count.conditions {
            learn(&mut assumptions, condition);
        }
        let stays = assumptions.simplify(&stays);
        let last = self.values_at(values, &count.closed, &stays)?;
        let mut known = assumptions.clone();
        if let Some(learned) = &count.learned {
            let learned = learned.substitute(&round.map)?.substitute(&last)?;
            learn(&mut assumptions, &learned);
            if !is_cut_off(&learned) {
                known = assumptions.clone();
            }
        }
        let exits: Vec<Edge> =
            self.period.phases[phase].edges.iter().filter(|edge| !std::ptr::eq(*edge, round)).cloned().collect();
        let edge = self.choose(&exits, &last, &assumptions)?;
        let same = edge.segments == round.segments;
        let total = if same { stays.add(&Value::one())? } else { stays.clone() };
        leg.rounds = Rounds::Count(stays.add(&Value::one())?);
        let shown = count.shown.as_ref().unwrap_or(&count.closed);
        leg.units = self.units(&round.segments, values, shown, Some(&total))?;
        if !same {
            leg.units.extend(self.units_once(edge, &last)?);
        }
        let mut onward = self.image(edge, &last)?;
        let after = self.values_at(values, &count.closed, &stays.add(&Value::one())?).unwrap_or_default();
        onward.extend(said_by_forms(&count.closed, &after, |name| edge.map.get(name) == round.map.get(name)));
        let next = self.onward(edge, &last)?;
        self.assumptions = known;
        Ok((leg, (next, onward)))
    }

    /// The one edge that is taken.
    pub(super) fn choose<'e>(
        &self,
        edges: &'e [Edge],
        values: &Values,
        assumptions: &Assumptions,
    ) -> Result<&'e Edge, Unsure> {
        let mut possible: Vec<(&Edge, Vec<Test>)> = Vec::new();
        'edges: for edge in edges {
            let mut open = Vec::new();
            for test in &edge.tests {
                let test = test.substitute(values)?;
                match test.decide(assumptions) {
                    Some(true) => {}
                    Some(false) => continue 'edges,
                    None => open.push(test),
                }
            }
            possible.push((edge, open));
        }
        match possible.as_slice() {
            [] => Err(Unsure::because("no way on was found".to_string())),
            // The edges cover all cases, so the one that is not ruled out is taken.
            [(edge, _)] => Ok(edge),
            _ => Err(undecided::between(&possible, assumptions)),
        }
    }

    pub(super) fn image(&self, edge: &Edge, values: &Values) -> Result<Values, Unsure> {
        let image =
            |(name, value): (&Name, &Value)| Ok((name.clone(), self.assumptions.simplify(&value.substitute(values)?)));
        edge.map.iter().map(image).collect()
    }
}
