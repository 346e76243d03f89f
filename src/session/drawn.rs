//! A way through a phase that draws, as theorems: the network passes to where draws are due, draws what is printed, and
//! for all values that may be drawn, and meet the tests of the way, it goes on so.

use std::cell::LazyCell;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::slice::Iter;

use num_rational::BigRational;
use num_traits::Zero;

use super::rounds::{Named, Rounds, passing};
use crate::advance::draw::nth;
use crate::assumption::Assumptions;
use crate::distribution::Distribution;
use crate::invariant::support;
use crate::law::Condition;
use crate::lower::Environment;
use crate::name::Name;
use crate::period::{Edge, Period, Segment, Test, open_name};
use crate::prove::run::{Lost, draws, due, goes_on};
use crate::scope::subterms;
use crate::substitution::substitute_values;
use crate::term::{Node, Term};
use crate::value::{Relation, Value, ValueError};

/// What is drawn at one moment.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Layer {
    /// Each value with its name and distribution.
    drawn: Vec<(Name, Value)>,
    /// Where a test asks of one of several values that are drawn under one name: the networks before and after, which
    /// tell which of them is which.
    between: Option<(Term, Term)>,
}

/// A way that is being followed.
struct Way<'a, 'r> {
    rounds: &'a Rounds<'r>,
    edge: &'a Edge,
    /// All tests of the ways that leave from there.
    asked: &'a [Test],
    /// What the variables of the phase are called, and what was drawn so far.
    named: Named,
    /// What is supposed of the variables.
    supposed: Vec<Condition>,
    state: Term,
    layers: Vec<Layer>,
    /// Whether of several that are drawn under one name, the last that is printed is taken for the first.
    backwards: bool,
}

/// Where a way has been followed to.
pub(super) struct Reached {
    /// What was drawn on the way, moment by moment.
    pub(super) layers: Vec<Layer>,
    /// What the variables of the phase, and what was drawn, are called in the state.
    pub(super) named: Named,
    /// What is supposed of them.
    pub(super) hypotheses: Vec<Condition>,
    /// The network there; none where what is supposed contradicts itself, so that the way is never taken.
    pub(super) state: Option<Term>,
}

fn odd(error: ValueError) -> Lost {
    Lost(error.0)
}

/// Has the kernel check a way up to where it has drawn all that it draws and all its segments have passed.
pub(super) fn followed(
    rounds: &Rounds<'_>,
    edge: &Edge,
    (named, supposed, state): (&Named, &[Condition], &Term),
    (asked, backwards): (&[Test], bool),
) -> Result<Reached, Lost> {
    let (named, state, supposed) = (named.clone(), state.clone(), supposed.to_vec());
    let mut way = Way { rounds, edge, asked, named, supposed, state, layers: Vec::new(), backwards };
    let mut segments = edge.segments.iter();
    loop {
        let hypotheses = way.hypotheses()?;
        match way.onward(&hypotheses, &mut segments) {
            Ok(true) => {}
            Ok(false) => {
                let state = Some(way.state);
                return Ok(Reached { layers: way.layers, named: way.named, hypotheses, state });
            }
            Err(_) if rounds.supposing(&hypotheses).contradictory() => {
                return Ok(Reached { layers: way.layers, named: way.named, hypotheses, state: None });
            }
            Err(why) => return Err(why),
        }
    }
}

/// What was drawn at one moment, as the kernel has checked it: the network before, what was supposed, and the names
/// that were given; with the network after.
type Moment = (Term, Vec<Condition>, Vec<Name>);

/// What is drawn somewhere, each value with its name and distribution, or why nothing is.
type Due = Result<Vec<(Name, Value)>, String>;

/// What ways have in common: those that leave from one place part only where a test tells them apart.
#[derive(Default)]
pub(super) struct Moments {
    due: HashMap<(Term, Vec<Condition>), Due>,
    after: HashMap<Moment, Term>,
}

impl Way<'_, '_> {
    /// One step on: a moment at which something is drawn, or else a segment that passes; false where all is done.
    fn onward(&mut self, hypotheses: &[Condition], segments: &mut Iter<'_, Segment>) -> Result<bool, Lost> {
        let why = match self.due(hypotheses) {
            Ok(due) => {
                self.draw(hypotheses, due)?;
                return Ok(true);
            }
            Err(why) => why,
        };
        let Some(segment) = segments.next() else {
            return if self.left().next().is_some() { Err(why) } else { Ok(false) };
        };
        let passed = passing(segment, &self.named)?;
        let (proof, next) = goes_on(self.rounds.theory, hypotheses, &self.state, &passed)?;
        self.rounds.check(&proof)?;
        self.state = next;
        Ok(true)
    }

    /// What is drawn here.
    fn due(&self, hypotheses: &[Condition]) -> Result<Vec<(Name, Value)>, Lost> {
        let place = (self.state.clone(), hypotheses.to_vec());
        let known = self.rounds.moments.borrow().due.get(&place).cloned();
        let found = known.unwrap_or_else(|| {
            let found = due(self.rounds.theory, hypotheses, &self.state).map_err(|Lost(why)| why);
            self.rounds.moments.borrow_mut().due.insert(place, found.clone());
            found
        });
        found.map_err(Lost)
    }

    /// The network behind what is drawn here under these names, which the kernel has checked.
    fn after(&self, hypotheses: &[Condition], labels: &[Name]) -> Result<Term, Lost> {
        let moment = (self.state.clone(), hypotheses.to_vec(), labels.to_vec());
        if let Some(known) = self.rounds.moments.borrow().after.get(&moment) {
            return Ok(known.clone());
        }
        let (proof, next) = draws(self.rounds.theory, hypotheses, &self.state, labels)?;
        self.rounds.check(&proof)?;
        self.rounds.moments.borrow_mut().after.insert(moment, next.clone());
        Ok(next)
    }

    /// What is not drawn yet.
    fn left(&self) -> impl Iterator<Item = &(Name, Value)> {
        self.edge.draws.iter().filter(|(name, _)| !self.named.contains_key(name))
    }

    /// What may be supposed here: of each value something, of what was drawn that it may be drawn, and the tests that ask
    /// of nothing that is drawn later.
    fn hypotheses(&self) -> Result<Vec<Condition>, Lost> {
        let own = self.named.values().map(|value| Condition::Compare(Relation::Eq, value.clone(), value.clone()));
        let mut hypotheses: Vec<Condition> = own.chain(self.supposed.iter().cloned()).collect();
        let later: BTreeSet<&Name> = self.left().map(|(name, _)| name).collect();
        let made = self.edge.draws.iter().filter(|(name, _)| !later.contains(name));
        let known = self.edge.tests.iter().filter(|test| later.iter().all(|name| !asks_of(test, name)));
        for test in made.flat_map(|(name, from)| support(name, from)).chain(known.cloned()) {
            let Test { relation, left, right } = test.substitute(&self.named).map_err(odd)?;
            hypotheses.push(Condition::Compare(relation, left, right));
        }
        Ok(hypotheses)
    }

    /// One moment at which these are drawn.
    fn draw(&mut self, hypotheses: &[Condition], due: Vec<(Name, Value)>) -> Result<(), Lost> {
        let mut layer: Vec<(Name, Value)> = Vec::new();
        let known = LazyCell::new(|| self.rounds.supposing(hypotheses));
        for (name, from) in &due {
            // What has been drawn just before is called by its place there, and by its label here.
            let place = |(place, (label, _)): (usize, &(Name, Value))| (nth(place), Value::variable(label));
            let places: Named = layer.iter().enumerate().map(place).collect();
            let mut fitting = None;
            for (label, printed) in self.left().filter(|(label, _)| called(label, name)) {
                let free = !layer.iter().any(|(other, _)| other == label);
                let here = printed.substitute(&self.named).map_err(odd)?;
                let from = &from.substitute(&places).map_err(odd)?;
                let equal = here == *from || known.simplify(&here) == known.simplify(from);
                if free && equal && (self.backwards || fitting.is_none()) {
                    fitting = Some((label.clone(), printed.clone()));
                }
            }
            let Some(found) = fitting else { return Err(Lost(format!("{name} is drawn from {from}"))) };
            layer.push(found);
        }
        // Which of several of one name is which is not told by their labels.
        let several = due.iter().enumerate().any(|(place, (name, _))| {
            let again = due.iter().enumerate().any(|(other, (same, _))| other != place && same == name);
            again && self.asked.iter().any(|test| asks_of(test, &layer[place].0))
        });
        let labels: Vec<Name> = layer.iter().map(|(label, _)| label.clone()).collect();
        let next = self.after(hypotheses, &labels)?;
        let open: Named = labels.iter().map(|label| (label.clone(), Value::variable(&open_name(label)))).collect();
        let next = substitute_values(&next, &open).map_err(|stuck| Lost(stuck.0))?;
        let before = std::mem::replace(&mut self.state, next.clone());
        self.named.extend(open);
        self.layers.push(Layer { drawn: layer, between: several.then_some((before, next)) });
        Ok(())
    }
}

fn asks_of(test: &Test, name: &Name) -> bool {
    test.left.mentions(name) || test.right.mentions(name)
}

/// Whether a label, as `w~2`, is of something that is drawn under this name.
fn called(label: &Name, name: &Name) -> bool {
    label.as_str().rsplit_once('~').is_some_and(|(plain, _)| plain == name.as_str())
}

/// Whether the ways that leave from one place name what they draw alike: two ways draw the same under the same names as
/// long as no test tells them apart, and where several are drawn under one name, of which tests ask, from one network to
/// one. So what their tests say of a name, they say of one value.
pub(super) fn named_alike(ways: &[(&Edge, &[Layer])]) -> bool {
    ways.iter().enumerate().all(|(place, (one, layers))| {
        ways[..place].iter().all(|(other, theirs)| {
            let shared = layers.iter().zip(*theirs).take_while(|(mine, other)| mine == other).count();
            shared == layers.len().max(theirs.len()) || told_apart(one, other, &layers[..shared])
        })
    })
}

/// Whether one of two ways has a test, of nothing that is drawn later, that the other has turned round.
fn told_apart(one: &Edge, other: &Edge, before: &[Layer]) -> bool {
    let drawn: BTreeSet<&Name> = before.iter().flat_map(|layer| &layer.drawn).map(|(name, _)| name).collect();
    let later =
        |edge: &Edge, test: &Test| edge.draws.iter().any(|(name, _)| !drawn.contains(name) && asks_of(test, name));
    one.tests.iter().any(|test| !later(one, test) && !later(other, test) && other.tests.contains(&test.negated()))
}

/// Whether the tests of two ways that leave from one place never hold together: some test of one is turned round in the
/// other.
pub(super) fn no_two_taken(period: &Period) -> bool {
    let apart = |edges: &[Edge]| {
        edges.iter().enumerate().all(|(place, one)| {
            edges[..place].iter().all(|other| one.tests.iter().any(|test| other.tests.contains(&test.negated())))
        })
    };
    apart(&period.initial) && period.phases.iter().all(|phase| apart(&phase.edges))
}

/// The assumptions with what is known of numbers that are drawn, where that depends on nothing else.
pub(super) fn with_supports(known: &Assumptions, edges: &[Edge]) -> Assumptions {
    let mut known = known.clone();
    let mut all: BTreeMap<&Name, Vec<&Value>> = BTreeMap::new();
    for (name, from) in edges.iter().flat_map(|edge| &edge.draws) {
        all.entry(name).or_default().push(from);
    }
    for (name, from) in all {
        let [first, others @ ..] = from.as_slice() else { continue };
        if first.variables().is_empty() && others.iter().all(|other| other == first) {
            for Test { relation, left, right } in support(name, first) {
                known.assume(relation, &left, &right);
            }
        }
    }
    known
}

/// Whether it may depend on what is drawn how long something lasts: some process that takes part draws, and some delay
/// takes a time that is not fixed.
pub(super) fn durations_are_drawn(system: &Term, environment: &Environment) -> bool {
    drawn_durations(system, environment).is_some()
}

/// Whether a duration may be drawn that is less than 0: some process that takes part draws numbers that may be so, or
/// some delay takes a time that is made from what is drawn.
pub(super) fn durations_below_are_drawn(system: &Term, environment: &Environment) -> bool {
    drawn_durations(system, environment) == Some(true)
}

/// Of a system where durations may depend on what is drawn, whether they may be less than 0.
fn drawn_durations(system: &Term, environment: &Environment) -> Option<bool> {
    let fixed = environment.assumptions.variables();
    let (mut seen, mut open) = (BTreeSet::new(), vec![(system.clone(), BTreeSet::new())]);
    let (mut draws, mut below, mut varies) = (false, false, false);
    while let Some((term, mut others)) = open.pop() {
        // Names that are drawn here and mean nothing else here.
        let mut drawn = BTreeSet::new();
        for part in subterms(&term) {
            match part.node() {
                Node::Ran(from, name) => {
                    draws = true;
                    below |= !Distribution::of(from).is_ok_and(|one| one.is_never_below(&BigRational::zero()));
                    drawn.insert(name.clone());
                }
                Node::In(_, name) | Node::Set(_, name) => {
                    others.insert(name.clone());
                }
                Node::Call(name, _) if seen.insert(name.clone()) => {
                    let definition = environment.definitions.get(name);
                    open.extend(definition.map(|one| (one.body.clone(), one.parameters.iter().cloned().collect())));
                }
                _ => {}
            }
        }
        for part in subterms(&term) {
            let Node::Delay(time) = part.node() else { continue };
            if !time.variables().is_subset(&fixed) {
                varies = true;
                let itself = |name: &Name| drawn.contains(name) && !others.contains(name);
                below |= !time.as_variable().is_some_and(itself);
            }
        }
    }
    (draws && varies).then_some(below)
}

/// Reasons with more of them, each said once.
pub(super) fn once(mut reasons: Vec<String>, mut more: Vec<String>) -> Vec<String> {
    more.retain(|one| !reasons.contains(one));
    reasons.append(&mut more);
    reasons
}
