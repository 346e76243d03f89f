//! Replaying a timed run in the executable meaning: what cannot be replayed is not shown as a refutation.

use std::collections::BTreeSet;

use num_rational::BigRational;
use num_traits::Zero;

use crate::definition::Definitions;
use crate::distribution::Distribution;
use crate::model::{Action, Model, Move, Patience, State};
use crate::name::Name;
use crate::term::{Node, Term};
use crate::value::Value;

/// Steps after which a replay is given up: longer than any run that is looked for.
const MOST_STEPS: usize = 400_000;

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

/// Whether some run of a closed system that draws these values in turn, and no more than these, shows at each given
/// time, once its internal steps at that time are done, the observers given for it, and goes on showing them until the
/// next of these times; only observers whose names are given in some entry are looked at. All internal steps are followed.
pub fn replays(system: &Term, definitions: &Definitions, run: &[(Value, Vec<Term>)], drawn: &[Drawn]) -> bool {
    let names: BTreeSet<Name> = run.iter().flat_map(|(_, shown)| shown).filter_map(observer).collect();
    let model = Model::new(definitions);
    let Ok(state) = model.state(system) else { return false };
    let mut replay = Replay { model: &model, names, drawn, steps: 0 };
    let mut places = BTreeSet::from([Place { state, drawn: 0 }]);
    let mut now = BigRational::zero();
    let mut before = None;
    for (time, shown) in run {
        let Some(time) = time.as_rational().filter(|time| *time >= now) else { return false };
        let wanted: Seen = shown.iter().filter_map(parts).collect();
        let Some(reached) = replay.wait_through(places, &(&time - &now), before.as_ref()) else { return false };
        places = reached.into_iter().filter(|place| replay.seen(&place.state) == wanted).collect();
        if places.is_empty() {
            return false;
        }
        (now, before) = (time, Some(wanted));
    }
    !run.is_empty()
}

/// Observers with their values.
type Seen = BTreeSet<(Name, Vec<Value>)>;

/// A state, and how much was drawn on the way to it.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord)]
struct Place {
    state: State,
    drawn: usize,
}

struct Replay<'a> {
    model: &'a Model<'a>,
    names: BTreeSet<Name>,
    drawn: &'a [Drawn],
    steps: usize,
}

impl Replay<'_> {
    fn seen(&self, state: &State) -> Seen {
        state.observations().into_iter().filter(|(name, _)| self.names.contains(name)).collect()
    }

    /// The states after this time with all internal steps that come up, those due at the end included, where nothing
    /// else than this is shown meanwhile; none where that is given up.
    fn wait_through(
        &mut self,
        from: BTreeSet<Place>,
        time: &BigRational,
        shown: Option<&Seen>,
    ) -> Option<BTreeSet<Place>> {
        let mut reached = BTreeSet::new();
        let mut open: Vec<(Place, BigRational)> = from.into_iter().map(|place| (place, time.clone())).collect();
        let mut met: BTreeSet<(Place, BigRational)> = open.iter().cloned().collect();
        while let Some((place, left)) = open.pop() {
            self.steps += 1;
            if self.steps > MOST_STEPS {
                return None;
            }
            let moves = place.state.moves().ok()?;
            let mut next = Vec::new();
            let internal = |step: &&Move| matches!(step.action, Action::Tau(..) | Action::Draw(..));
            let mut instant = false;
            for step in moves.iter().filter(internal) {
                instant = true;
                let (after, drawn) = match step.action {
                    Action::Tau(..) => (Some(step.next.clone()), place.drawn),
                    _ => (self.drawn.get(place.drawn).and_then(|drawn| drawn.taken(step)), place.drawn + 1),
                };
                if let Some(after) = after {
                    let state = self.model.state(&after).ok()?;
                    next.push((Place { state, drawn }, left.clone()));
                }
            }
            if !instant && left.is_zero() {
                reached.insert(place);
                continue;
            }
            if !instant && shown.is_none_or(|shown| self.seen(&place.state) == *shown) {
                let passed = match place.state.patience(&moves) {
                    Patience::None => continue,
                    Patience::Until(next) if next < left => next,
                    _ => left.clone(),
                };
                let state = self.model.wait_state(&place.state, &passed).ok()??;
                next.push((Place { state, ..place }, &left - &passed));
            }
            open.extend(next.into_iter().filter(|place| met.insert(place.clone())));
        }
        Some(reached)
    }
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
