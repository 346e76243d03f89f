//! The rounds of a period as theorems: from each phase the system passes as the round says, to the next phase with its
//! variables mapped.

mod taken;

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};

use super::compare::theory;
use super::drawn::{Layer, Moments, followed, named_alike, with_supports};
use super::entered::{bounds, counts, delays, met, more_than_none, needs};
use crate::advance::ORDER;
use crate::assumption::Assumptions;
use crate::definition::Definitions;
use crate::fact::supposing;
use crate::kernel::{Theory, check};
use crate::law::Condition;
use crate::lower::{Environment, System};
use crate::name::Name;
use crate::period::{Edge, End, Next, Period, Phase, Segment, Test, open_name, stretch};
use crate::proof::Proof;
use crate::prove::run::{self, Lost, ends, passes};
use crate::scope::subterms;
use crate::substitution::substitute_values;
use crate::term::{Node, Term};
use crate::value::{Need, Relation, Value, ValueError};

/// Ways that are looked at.
const MOST_WAYS: usize = 2_000;
/// Ways that may fail before no more are looked at, where the first is told, and where it is asked whether any may come to
/// what has no value.
const FEW_FAILURES: usize = 3;
const MOST_FAILURES: usize = 50;
/// Stretches of time on one way that are followed.
const MOST_STRETCHES: usize = 10_000;
/// Cases in which tests fail that are looked at.
const MOST_CASES: usize = 200;
/// The longest reason that is printed, in characters.
const WIDEST: usize = 160;

/// How many rounds the kernel has checked, and the first that it has not.
pub(super) fn checked(
    period: &Period,
    system: &System,
    environment: &Environment,
    interrupted: &dyn Fn() -> bool,
) -> Vec<String> {
    let Count { layers, all, why, .. } = count(period, (system, environment), FEW_FAILURES, interrupted);
    let proved = layers.iter().flatten().count();
    let ways = match period.along_the_run {
        true => "ways that the run takes from start and phases (no others were looked for), with their flow functions",
        false => "ways from start and phases, with their flow functions",
    };
    let Some(why) = why else {
        return match all {
            0 => Vec::new(),
            1 => vec!["by the kernel: the one way from the start, with its flow function".to_string()],
            _ => vec![format!("by the kernel: all {proved} {ways}")],
        };
    };
    let own = format!("by the kernel: {proved} of {all} {ways}");
    match taken::others(period, (system, environment), &layers, interrupted) {
        Some(told) => vec![format!("{own}; {told}"), format!("not checked by the kernel for all values: {why}")],
        None => vec![own, format!("not checked by the kernel: {why}")],
    }
}

/// What the kernel has checked of the phases of a system.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Grounds {
    /// Some way reads what may have no value: what is said of the phases says nothing there.
    Undefined(String),
    /// On some way it comes to something else in another order of what is communicated in one instant.
    Raced,
    /// Not every way.
    Less,
    /// Every way there is, none of which stops time.
    Ways,
    /// Every way, one of which is taken, whatever the values.
    All,
}

impl Grounds {
    /// Why a claim that rests on the phases is open, if it is.
    pub(super) fn open(&self) -> Option<String> {
        match self {
            Grounds::Undefined(why) => Some(no_value(why)),
            Grounds::Raced => Some(ORDER.to_string()),
            _ => None,
        }
    }
}

/// Why a claim about a system is open that may come to what has no value.
pub(super) fn no_value(why: &str) -> String {
    format!("the system may come to what has no value: {why}")
}

/// How far the phases of a system, as printed, are theorems.
pub(super) fn how_far(
    period: &Period,
    system: &System,
    environment: &Environment,
    interrupted: &dyn Fn() -> bool,
) -> Grounds {
    let mut edges = period.ways();
    let counted = count(period, (system, environment), MOST_FAILURES, interrupted);
    match (counted.undefined, counted.why) {
        (Some(why), _) => Grounds::Undefined(why),
        _ if counted.raced => Grounds::Raced,
        (None, Some(_)) => Grounds::Less,
        _ if edges.any(|edge| matches!(edge.next, Next::End(End::Livelock { .. }))) => Grounds::Less,
        _ if one_is_taken(period, &counted.layers, &environment.assumptions) => Grounds::All,
        _ => Grounds::Ways,
    }
}

/// Whether at the start and in each phase the tests of one of the ways hold, whatever the values and whatever is drawn.
/// What each way draws comes in the order of the ways.
fn one_is_taken(period: &Period, layers: &[Option<Vec<Layer>>], known: &Assumptions) -> bool {
    let mut layers = layers.iter();
    let mut covers = |edges: &[Edge], named: &Named| {
        let tests = edges.iter().map(|edge| edge.tests.iter().map(|test| test.substitute(named)).collect());
        let ways: Result<Vec<Vec<Test>>, ValueError> = tests.collect();
        let drawn = edges.iter().map(|edge| Some((edge, layers.next()?.as_deref()?)));
        let drawn: Option<Vec<(&Edge, &[Layer])>> = drawn.collect();
        let mut cases = MOST_CASES;
        drawn.is_some_and(|drawn| named_alike(&drawn))
            && ways.is_ok_and(|ways| one_holds(&ways, &with_supports(known, edges), &mut cases))
    };
    covers(&period.initial, &Named::new()) && period.phases.iter().all(|phase| covers(&phase.edges, &any_values(phase)))
}

/// Whether all tests of one of these ways hold: if some test of the first does not, then of the others.
fn one_holds(ways: &[Vec<Test>], known: &Assumptions, cases: &mut usize) -> bool {
    let holds = |test: &Test| known.decide(test.relation, &test.left, &test.right) == Some(true);
    let Some((first, others)) = ways.split_first() else { return known.contradictory() };
    first.iter().all(|test| {
        if holds(test) {
            return true;
        }
        let left = *cases > 0;
        *cases = cases.saturating_sub(1);
        let mut fails = known.clone();
        fails.assume(test.relation.negated(), &test.left, &test.right);
        left && one_holds(others, &fails, cases)
    })
}

/// The ways to phases and ends.
struct Count {
    /// What each draws; none for a way that the kernel has not checked.
    layers: Vec<Option<Vec<Layer>>>,
    /// How many there are.
    all: usize,
    /// Why the first is not checked, if one is not.
    why: Option<String>,
    /// What may have no value on a way that is followed otherwise.
    undefined: Option<String>,
    /// Whether one failed as another order of communications leads elsewhere.
    raced: bool,
}

/// Which ways to phases and ends the kernel has checked.
fn count(
    period: &Period,
    (system, environment): (&System, &Environment),
    most: usize,
    interrupted: &dyn Fn() -> bool,
) -> Count {
    with_rounds(period, (system, environment), |rounds, whole| {
        let counted = each(rounds, whole, most, interrupted);
        Count { undefined: rounds.undefined.take(), ..counted }
    })
}

/// Something asked of the rounds of a system, given it as a whole.
fn with_rounds<R>(
    period: &Period,
    (system, environment): (&System, &Environment),
    ask: impl FnOnce(&Rounds<'_>, &Term) -> R,
) -> R {
    let whole = system.alone(&environment.definitions);
    let theory = Theory { definitions: called_in(&whole, &environment.definitions), ..theory(environment) };
    let mut ports = Vec::new();
    let mut body = &whole;
    while let Node::New(port, inner) = body.node() {
        ports.push(port.clone());
        body = inner;
    }
    let rounds = Rounds { theory: &theory, period, ports, moments: RefCell::default(), undefined: RefCell::default() };
    ask(&rounds, &whole)
}

/// The ways from the start and from each phase, in order; where time stops there is no way.
fn ways(period: &Period) -> Vec<(Option<usize>, &Edge)> {
    let start = period.initial.iter().map(|edge| (None, edge));
    let edges = period.phases.iter().enumerate();
    let edges = edges.flat_map(|(number, phase)| phase.edges.iter().map(move |edge| (Some(number), edge)));
    start.chain(edges).filter(|(_, edge)| !matches!(edge.next, Next::End(End::Livelock { .. }))).collect()
}

fn each(rounds: &Rounds<'_>, whole: &Term, most: usize, interrupted: &dyn Fn() -> bool) -> Count {
    let all = ways(rounds.period);
    let mut layers = Vec::new();
    let (mut failed, mut raced) = (Vec::new(), false);
    for beside in all[..all.len().min(MOST_WAYS)].chunk_by(|(one, _), (other, _)| one == other) {
        if failed.len() >= most || interrupted() {
            break;
        }
        let found = |backwards| -> Vec<Result<Vec<Layer>, Lost>> {
            beside.iter().map(|(from, edge)| rounds.proved(*from, edge, (whole, backwards))).collect()
        };
        // All ways from one place name what they draw in one order: so one name is of one value.
        let mut results = found(false);
        if results.iter().any(Result::is_err) && beside.iter().any(|(_, edge)| !edge.draws.is_empty()) {
            let other = found(true);
            let all = other.iter().all(Result::is_ok);
            for (one, other) in results.iter_mut().zip(other) {
                if all || one.is_err() && other.is_ok() {
                    *one = other;
                }
            }
        }
        for ((from, edge), found) in beside.iter().zip(results) {
            raced |= found.as_ref().is_err_and(|Lost(why)| why == ORDER);
            failed.extend(found.as_ref().err().map(|Lost(why)| format!("{}: {}", named(*from, edge), short(why))));
            layers.push(found.ok());
        }
    }
    let unseen = (layers.len() < all.len()).then(|| format!("no more than {MOST_WAYS} are looked at"));
    Count { layers, all: all.len(), why: failed.into_iter().next().or(unseen), undefined: None, raced }
}

/// The definitions that a system comes to: facts about all others that a file has would be found for nothing.
fn called_in(whole: &Term, definitions: &Definitions) -> Definitions {
    let mut called = Definitions::default();
    let mut open = vec![whole.clone()];
    while let Some(term) = open.pop() {
        for part in subterms(&term) {
            let Node::Call(name, _) = part.node() else { continue };
            if let Some(definition) = definitions.get(name).filter(|_| called.get(name).is_none()) {
                called.insert(definition.clone());
                open.push(definition.body.clone());
            }
        }
    }
    called
}

fn named(from: Option<usize>, edge: &Edge) -> String {
    let from = from.map_or("start".to_string(), |number| format!("phase {}", number + 1));
    match edge.next {
        Next::Phase(number) => format!("{from} -> phase {}", number + 1),
        Next::End(End::Stopped) => format!("{from} -> stops"),
        Next::End(End::Aborted) => format!("{from} -> aborts"),
        Next::End(_) => format!("{from} -> waits for ever"),
    }
}

fn short(why: &str) -> String {
    if why.chars().count() <= WIDEST {
        return why.to_string();
    }
    why.chars().take(WIDEST).chain(" …".chars()).collect()
}

pub(super) struct Rounds<'a> {
    pub(super) theory: &'a Theory,
    period: &'a Period,
    ports: Vec<Name>,
    pub(super) moments: RefCell<Moments>,
    undefined: RefCell<Option<String>>,
}

/// What the variables of a phase are called in a theorem, where they stand for any value.
pub(super) type Named = BTreeMap<Name, Value>;

fn any_values(phase: &Phase) -> Named {
    phase.variables.iter().map(|name| (name.clone(), Value::variable(&open_name(name)))).collect()
}

impl Rounds<'_> {
    /// What is assumed where these hypotheses hold.
    pub(super) fn supposing(&self, hypotheses: &[Condition]) -> Assumptions {
        supposing(&self.theory.assumptions, hypotheses)
    }

    fn network(&self, state: &[Term], values: &Named) -> Result<Term, Lost> {
        let body = Term::par(state.iter().cloned());
        let body = substitute_values(&body, values).map_err(|stuck| Lost(stuck.0))?;
        Ok(self.ports.iter().rev().fold(body, |body, port| Term::new(Node::New(port.clone(), body))))
    }

    /// What is so wherever this state is entered: its delays run, its copies are counted, and it has a value.
    fn entered(&self, state: &[Term]) -> Vec<Condition> {
        let open = |left: &&Value| {
            let varies = left.variables().iter().any(Name::is_meta);
            varies || self.theory.assumptions.decide(Relation::Gtr, left, &Value::zero()) != Some(true)
        };
        let copies = counts(state).cloned().map(Condition::Natural);
        let granted = |need: &Need| self.theory.assumptions.grants(need) == Some(true);
        let always = needs(state).into_iter().filter(|(need, guards)| guards.is_empty() && !granted(need));
        let defined = always.map(|(need, _)| met(&need));
        let running = delays(state).filter(open).map(more_than_none);
        let mut all: Vec<Condition> = running.chain(copies).chain(defined).collect();
        let mut seen = BTreeSet::new();
        all.retain(|condition| seen.insert(condition.clone()));
        all
    }

    /// Has the kernel check that one way through a phase is what the system does, and returns what is drawn on it.
    /// Of several values that are drawn under one name, the last that is printed may be taken for the first.
    fn proved(&self, from: Option<usize>, edge: &Edge, (whole, backwards): (&Term, bool)) -> Result<Vec<Layer>, Lost> {
        let phase = from.and_then(|number| self.period.phases.get(number));
        let named = phase.map_or_else(Named::new, any_values);
        let left = phase.map_or(Ok(whole.clone()), |phase| self.network(&phase.state, &Named::new()))?;
        let mut running: Vec<Condition> = phase.map_or_else(Vec::new, |phase| self.entered(&phase.state));
        let bounds = phase.into_iter().flat_map(bounds);
        running.extend(bounds.map(|Test { relation, left, right }| Condition::Compare(relation, left, right)));
        if edge.draws.is_empty() {
            let mut hypotheses = supposed(edge, &named)?;
            hypotheses.extend(running);
            self.leads(edge, (&left, &edge.segments), &named, &hypotheses)?;
            return Ok(Vec::new());
        }
        let beside = phase.map_or(&self.period.initial, |phase| &phase.edges);
        let asked: Vec<Test> = beside.iter().flat_map(|edge| edge.tests.iter().cloned()).collect();
        let reached = followed(self, edge, (&named, &running, &left), (&asked, backwards))?;
        if let Some(state) = &reached.state {
            let led = self.leads(edge, (state, &[]), &reached.named, &reached.hypotheses);
            if led.is_err() && !self.supposing(&reached.hypotheses).contradictory() {
                led?;
            }
        }
        Ok(reached.layers)
    }

    /// In a phase, what is left of each delay that runs is more than 0, each number of copies that are to come is natural,
    /// and what stands in it has a value: so it is where the phase is entered.
    fn still_run(&self, phase: &Phase, map: &Named, hypotheses: &[Condition]) -> Result<(), Lost> {
        let known = self.supposing(hypotheses);
        for left in delays(&phase.state) {
            let left = left.substitute(map).map_err(odd)?;
            if known.decide(Relation::Gtr, &left, &Value::zero()) != Some(true) {
                return Err(Lost(format!("whether {left} > 0")));
            }
        }
        for bound in bounds(phase) {
            if bound.substitute(map).map_err(odd)?.decide(&known) != Some(true) {
                return Err(Lost(format!("whether {bound}")));
            }
        }
        for copies in counts(&phase.state) {
            let copies = copies.substitute(map).map_err(odd)?;
            if known.is_natural(&copies) != Some(true) {
                return Err(Lost(format!("whether {copies} is natural")));
            }
        }
        self.has_value(phase, map, known)
    }

    /// What stands in a phase has a value where it is entered; what stands behind guards, where these hold.
    fn has_value(&self, phase: &Phase, map: &Named, known: Assumptions) -> Result<(), Lost> {
        for (need, guards) in needs(&phase.state) {
            let mut here = known.clone();
            for (relation, left, right) in &guards {
                here.assume(*relation, &left.substitute(map).map_err(odd)?, &right.substitute(map).map_err(odd)?);
            }
            let Ok(image) = need.value().substitute(map) else {
                if !guards.is_empty() && here.contradictory() {
                    continue;
                }
                return Err(self.may_have_none(need.to_string()));
            };
            // Of parameters alone nothing is known but what is declared: a claim says nothing where they give no value.
            let open = image.variables().iter().any(Name::is_meta) || image.as_rational().is_some();
            let entered = need.substitute(map).map_err(odd)?;
            if open && here.grants(&entered) != Some(true) && !here.contradictory() {
                return Err(self.may_have_none(entered.to_string()));
            }
        }
        Ok(())
    }

    /// Has the kernel check that from here these segments pass and the way comes to where it leads.
    fn leads(
        &self,
        edge: &Edge,
        (left, segments): (&Term, &[Segment]),
        named: &Named,
        hypotheses: &[Condition],
    ) -> Result<(), Lost> {
        if segments.len() > MOST_STRETCHES {
            return Err(Lost(format!("more than {MOST_STRETCHES} stretches of time")));
        }
        let mut stretches = Vec::with_capacity(segments.len());
        for segment in segments {
            stretches.push(passing(segment, named)?);
        }
        let map = edge.map.iter().map(|(name, value)| Ok((open_name(name), value.substitute(named)?)));
        let map = map.collect::<Result<Named, ValueError>>().map_err(odd)?;
        let proof = match &edge.next {
            Next::Phase(next) => {
                let Some(target) = self.period.phases.get(*next) else { return Err(Lost("it leads nowhere".into())) };
                self.still_run(target, &map, hypotheses)?;
                let right = self.network(&target.state, &map)?;
                passes(self.theory, hypotheses, (left, &right), &stretches)?
            }
            Next::End(end) => {
                let end = match end {
                    End::Stopped => run::End::Stopped,
                    End::Aborted => run::End::Aborted,
                    End::Silent { observed, .. } => run::End::Silent(shown(observed, named)?),
                    End::Livelock { .. } => return Err(Lost("time stops".to_string())),
                };
                ends(self.theory, hypotheses, left, (&stretches, &end))?
            }
        };
        self.check(&proof)
    }

    /// Has the kernel check a proof, of what has a value wherever its hypotheses hold.
    pub(super) fn check(&self, proof: &Proof) -> Result<(), Lost> {
        let (why, undefined) = match check(self.theory, proof) {
            Err(rejected) => (rejected.reason.to_string(), rejected.reason.is_undefined()),
            Ok(theorem) => match theorem.reads().first() {
                None => return Ok(()),
                Some(need) => (need.to_string(), true),
            },
        };
        Err(if undefined { self.may_have_none(why) } else { Lost(why) })
    }

    /// Notes that there may be no value.
    fn may_have_none(&self, why: String) -> Lost {
        self.undefined.replace(Some(why.clone()));
        Lost(why)
    }
}

fn odd(error: ValueError) -> Lost {
    Lost(error.0)
}

fn shown(observed: &[Term], named: &Named) -> Result<Vec<Term>, Lost> {
    let shown: Result<Vec<Term>, _> = observed.iter().map(|term| substitute_values(term, named)).collect();
    shown.map_err(|stuck| Lost(stuck.0))
}

/// A segment as a process.
pub(super) fn passing(segment: &Segment, named: &Named) -> Result<Term, Lost> {
    Ok(stretch(&segment.duration.substitute(named).map_err(odd)?, &shown(&segment.observed, named)?))
}

/// Of each value something is supposed, if only that it is what it is; and the tests of the way.
fn supposed(edge: &Edge, named: &Named) -> Result<Vec<Condition>, Lost> {
    let own = named.values().map(|value| Condition::Compare(Relation::Eq, value.clone(), value.clone()));
    let mut hypotheses: Vec<Condition> = own.collect();
    for test in &edge.tests {
        let Test { relation, left, right } = test.substitute(named).map_err(odd)?;
        hypotheses.push(Condition::Compare(relation, left, right));
    }
    Ok(hypotheses)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn test(name: &str, relation: Relation, right: i64) -> Test {
        Test { relation, left: Value::variable(&Name::new(name)), right: Value::integer(right) }
    }

    fn one(ways: &[Vec<Test>], known: &Assumptions) -> bool {
        let mut cases = MOST_CASES;
        one_holds(ways, known, &mut cases)
    }

    #[test]
    fn some_way_is_taken_where_no_case_is_left_out() {
        let mut known = Assumptions::default();
        let (less, more) = (|at| vec![test("x", Relation::Lss, at)], |at| vec![test("x", Relation::Gte, at)]);
        assert!(one(&[less(3), more(3)], &known) && one(&[more(2), less(3)], &known) && one(&[vec![]], &known));
        assert!(!one(&[less(3), more(4)], &known), "between 3 and 4");
        assert!(!one(&[less(3), vec![test("x", Relation::Gtr, 3)]], &known), "3 itself");
        assert!(!one(&[], &known) && !one(&[less(3)], &known));
        let both = vec![test("x", Relation::Gtr, 0), test("y", Relation::Gtr, 0)];
        let (first, second) = (vec![test("x", Relation::Lte, 0)], vec![test("y", Relation::Lte, 0)]);
        assert!(one(&[both.clone(), first.clone(), second.clone()], &known));
        assert!(!one(&[both.clone(), first.clone()], &known) && !one(&[both, second], &known));
        known.assume(Relation::Lss, &Value::variable(&Name::new("x")), &Value::integer(3));
        assert!(one(&[less(3)], &known));
        let mut none = 0;
        assert!(!one_holds(&[more(1), less(1)], &known, &mut none), "within the cases that are looked at");
    }
}
