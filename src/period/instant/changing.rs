//! A loop that goes round in no time with other values each time. One turn of it is gone through with variables for the
//! values that change: whatever these are, if what it asks of them is answered as it was, it is again where it was. What
//! remains is that the answers stay the same for ever: each follows from what was asked one turn before, or never fails
//! by what is known of the recurrence that the turns make of the values.

use std::collections::{BTreeMap, BTreeSet};

use num_bigint::BigInt;
use num_traits::ToPrimitive;

use super::{Clock, Earlier, Moment};
use crate::digest::Quick;
use crate::name::Name;
use crate::period::forever::{Answers, Values};
use crate::period::held::{Held, absorbed, first_held, name_variables};
use crate::period::run::{Env, Halt, Run, Settler};
use crate::period::step::{Slot, map_parts};
use crate::period::suppose::suppose;
use crate::period::told::go_round;
use crate::period::{End, Test, open_name};
use crate::scope::{bound_names, subterms};
use crate::term::Term;
use crate::value::{Sort, Value};

/// Turns of one loop that are taken together: of a loop that does one thing and another by turns.
const MOST_TOGETHER: usize = 4;
/// What one turn may ask.
const MOST_QUESTIONS: usize = 32;
/// How many times as many communications are made until it is asked again what could not be told.
const LATER: usize = 4;
/// How often more values than before may turn out to change.
const MOST_TRIALS: usize = 6;

/// The end of time, if the system is where it was earlier in this instant but for values, and goes on so for ever.
///
/// # Errors
/// Where it ends, but later than is followed.
pub(super) fn changing(clock: &Clock<'_>, moment: &mut Moment) -> Result<Option<End>, Halt> {
    let made = moment.communications.len();
    // No read or write has been made again before that.
    if made <= clock.operations.max(moment.quiet) {
        return Ok(None);
    }
    let Some((earlier, turn)) = turn(clock, moment) else { return Ok(None) };
    let (later, cycle) = (made.saturating_mul(LATER), earlier.cycle());
    match turn.goes_on(clock, moment) {
        _ if !turn.has_values(clock) => moment.quiet = later,
        Answers::Forever => return Ok(Some(End::Livelock { changes: turn.changes(clock), cycle })),
        Answers::Unknown => moment.quiet = later,
        // It may do another thing by turns.
        Answers::Until(turns, _) if turns <= BigInt::from(MOST_TOGETHER) => {}
        Answers::Until(turns, test) => {
            let turns = turns.to_usize().unwrap_or(usize::MAX);
            moment.quiet = made.saturating_add(turns.saturating_mul(made - earlier.at));
            if moment.quiet > clock.most_communications() {
                let names = turn.named(clock);
                let test = test.substitute(&names).unwrap_or(test);
                return Halt::because(format!("{} until {test}, for longer than is followed", go_round(&cycle)));
            }
        }
    }
    Ok(None)
}

/// A turn that led here from an earlier state and that leads back here, whatever changes.
fn turn(clock: &Clock<'_>, moment: &mut Moment) -> Option<(Earlier, Turn)> {
    let made = moment.communications.len();
    let earlier = moment.earlier.as_mut()?;
    if earlier.at >= made || earlier.draws != moment.path.draws.len() || earlier.unfolded.is_empty() {
        return None;
    }
    let alike = |(component, run): (&usize, &Run)| moment.state.get(*component).is_some_and(|now| same_place(now, run));
    if earlier.tried >= MOST_TOGETHER || !earlier.changed.iter().all(alike) {
        return None;
    }
    earlier.tried += 1;
    let earlier = earlier.clone();
    let mut turn = Turn::between(clock, moment, &earlier)?;
    for _ in 0..MOST_TRIALS {
        match turn.gone(clock, moment, (&earlier, made - earlier.at))? {
            (wider, false) => turn = wider,
            (turn, true) => return Some((earlier, turn)),
        }
    }
    None
}

impl Clock<'_> {
    /// One step on the way through a turn: true when this many communications have been made.
    fn step(&self, moment: &mut Moment, length: usize) -> Result<bool, Halt> {
        let ended = self.settle(moment)?.is_some();
        self.check_besides(moment)?;
        if !ended && moment.communications.len() == length {
            return Ok(true);
        }
        match ended || self.communicate_once(moment)?.is_some() {
            true => Halt::because("the instant is over"),
            false => Ok(false),
        }
    }
}

/// One turn: what the places hold, with variables for what changes.
struct Turn {
    /// What the places hold now, and what they hold whatever changes.
    now: Vec<Value>,
    held: Vec<Held>,
    hints: Vec<Name>,
    /// What the variables are called.
    names: Vec<Name>,
    /// What they are after the turn.
    images: Vec<Value>,
    /// What is asked on the way.
    tests: Vec<Test>,
    /// The processes that were called.
    called: BTreeSet<Name>,
}

impl Turn {
    /// The turn that led here from an earlier state.
    fn between(clock: &Clock<'_>, moment: &Moment, earlier: &Earlier) -> Option<Turn> {
        let mut before = moment.state.clone();
        for (component, run) in &earlier.changed {
            *before.get_mut(*component)? = run.clone();
        }
        let (then, _) = entries(&before)?;
        let (now, hints) = entries(&moment.state)?;
        let constant = vec![false; now.len()];
        let first = first_held(&then, &[], |_| false);
        let held = (then.len() == now.len()).then(|| absorbed(&first, (&now, &[]), &constant, None))?;
        Some(Turn::of(clock, (now, hints), held))
    }

    fn of(clock: &Clock<'_>, (now, hints): (Vec<Value>, Vec<Name>), held: Vec<Held>) -> Turn {
        let names = name_variables(&held, &hints, clock.settler.reserved).iter().map(open_name).collect();
        let (images, tests, called) = (Vec::new(), Vec::new(), BTreeSet::new());
        Turn { now, held, hints, names, images, tests, called }
    }

    /// The first places of the variables, in their order.
    fn places(&self) -> impl Iterator<Item = usize> {
        let place = |class: usize| self.held.iter().position(|held| *held == Held::Class(class));
        (0..self.names.len()).filter_map(place)
    }

    /// The variables with what they are now.
    fn start(&self) -> BTreeMap<Name, Value> {
        let values = self.places().filter_map(|place| self.now.get(place));
        self.names.iter().cloned().zip(values.cloned()).collect()
    }

    /// Goes through the turn, of so many communications. It comes back, true, to where it was; or to where more changes,
    /// false, which has variables then. None where that cannot be told.
    fn gone(
        mut self,
        clock: &Clock<'_>,
        moment: &Moment,
        (earlier, length): (&Earlier, usize),
    ) -> Option<(Turn, bool)> {
        let start = self.start();
        let earlier = Some(Earlier { changed: Quick::default(), unfolded: Vec::new(), ..earlier.clone() });
        let state = self.state(&moment.state)?;
        let new = Moment { state, communications: Vec::new(), earlier, besides: None, ..moment.clone() };
        let mut new = new.settled_anew(moment.path.clone());
        let mut questions = 0;
        loop {
            match clock.step(&mut new, length) {
                Ok(true) => break,
                Ok(false) => {}
                Err(Halt::Split(question)) if questions < MOST_QUESTIONS => {
                    questions += 1;
                    let answer = question.test.substitute(&start).ok()?.decide(&moment.path.assumptions)?;
                    new = suppose(&clock.settler, &new, &question, answer)?;
                }
                Err(_) => return None,
            }
        }
        let back = new.state.iter().zip(&moment.state).all(|(one, other)| same_place(one, other));
        let (after, hints) = entries(&new.state)?;
        if !back || hints != self.hints || new.path.draws.len() != moment.path.draws.len() {
            return None;
        }
        self.images = self.places().filter_map(|place| after.get(place).cloned()).collect();
        let fits = self.held.iter().zip(&after).all(|(held, after)| match held {
            Held::Constant(value) => value == after,
            Held::Class(class) => self.images.get(*class) == Some(after),
        });
        if !fits {
            let held = absorbed(&self.held, (&after, &[]), &vec![false; after.len()], None);
            return Some((Turn::of(clock, (self.now, self.hints), held), false));
        }
        self.tests = new.path.tests.iter().skip(moment.path.tests.len()).map(|test| test.test.clone()).collect();
        self.called = new.earlier.into_iter().flat_map(|earlier| earlier.unfolded).collect();
        Some((self, true))
    }

    /// The state with the variables in it.
    fn state(&self, state: &[Run]) -> Option<Vec<Run>> {
        let mut held = self.held.iter();
        let mut next = || match held.next()? {
            Held::Constant(value) => Some(value.clone()),
            Held::Class(class) => self.names.get(*class).map(Value::variable),
        };
        let mut fill = |_: Slot<'_>, value: &Value| match value.components() {
            None => next().ok_or(()),
            Some(parts) => {
                let parts: Option<Vec<Value>> = parts.iter().map(|_| next()).collect();
                Value::vector(parts.ok_or(())?).map_err(|_| ())
            }
        };
        map_parts(state, &mut fill).ok()
    }

    /// Whether all that is read on the way has a value, whatever the variables are.
    fn has_values(&self, clock: &Clock<'_>) -> bool {
        let Settler { definitions, reserved, tails, .. } = &clock.settler;
        let called: Vec<_> = self.called.iter().filter_map(|name| definitions.get(name)).collect();
        let tails = tails.borrow();
        let terms: Vec<&Term> = called.iter().map(|definition| &definition.body).chain(tails.terms()).collect();
        let mut needs =
            terms.iter().flat_map(|term| subterms(term)).flat_map(Term::values).flat_map(Value::needs).peekable();
        if needs.peek().is_none() {
            return true;
        }
        let mut own: BTreeSet<Name> =
            called.iter().flat_map(|definition| definition.parameters.iter().cloned()).collect();
        own.extend(terms.iter().flat_map(|term| bound_names(term)));
        needs.all(|need| need.value().variables().iter().all(|name| reserved.contains(name) && !own.contains(name)))
    }

    /// Whether what is asked in one turn is answered the same way in all that follow.
    fn goes_on(&self, clock: &Clock<'_>, moment: &Moment) -> Answers {
        let images: BTreeMap<Name, Value> = self.names.iter().cloned().zip(self.images.iter().cloned()).collect();
        let values = Values { start: &self.start(), images: &images };
        values.answers(&self.tests, &moment.path.assumptions, clock.interrupted)
    }

    /// What people call the variables.
    fn named(&self, clock: &Clock<'_>) -> BTreeMap<Name, Value> {
        let mut taken = clock.settler.reserved.clone();
        taken.extend(self.images.iter().flat_map(Value::variables));
        let names = name_variables(&self.held, &self.hints, &taken);
        self.names.iter().cloned().zip(names.iter().map(Value::variable)).collect()
    }

    /// What changes in one turn, and what it is then, in the names that people use.
    fn changes(&self, clock: &Clock<'_>) -> Vec<(Name, Value)> {
        let names = self.named(clock);
        let changed = self.names.iter().zip(&self.images).filter(|(own, image)| **image != Value::variable(own));
        let told = |(own, image): (&Name, &Value)| {
            let name = names.get(own)?.variables().into_iter().next()?;
            Some((name, image.substitute(&names).ok()?))
        };
        changed.filter_map(told).collect()
    }
}

/// The values of a state, one by one, and what each is called; none where one is no number.
fn entries(state: &[Run]) -> Option<(Vec<Value>, Vec<Name>)> {
    let (mut entries, mut hints) = (Vec::new(), Vec::new());
    let mut take = |slot: Slot<'_>, value: &Value| -> Result<Value, ()> {
        let hint = if let Slot::Name(name) = slot { name.clone() } else { Name::new("rest") };
        let parts = value.components().unwrap_or_else(|| vec![value.clone()]);
        for (place, part) in parts.iter().enumerate() {
            if part.sort() != Sort::Real {
                return Err(());
            }
            hints.push(if value.sort() == Sort::Real { hint.clone() } else { hint.component(place, parts.len()) });
        }
        entries.extend(parts);
        Ok(value.clone())
    };
    map_parts(state, &mut take).ok()?;
    Some((entries, hints))
}

/// Whether two parts are about to do the same, but for values.
fn same_place(one: &Run, other: &Run) -> bool {
    let names = |one: &Env, other: &Env| one.keys().eq(other.keys());
    let all = |one: &[Run], other: &[Run]| {
        one.len() == other.len() && one.iter().zip(other).all(|(one, other)| same_place(one, other))
    };
    match (one, other) {
        (Run::Done(one), Run::Done(other)) => names(one, other),
        (Run::Aborted, Run::Aborted) | (Run::Delay(_), Run::Delay(_)) => true,
        (Run::Fresh(one, own), Run::Fresh(other, env)) | (Run::Wait(one, own), Run::Wait(other, env)) => {
            one == other && names(own, env)
        }
        (Run::Seq(one, own_rest, own, so_far), Run::Seq(other, rest, env, carried)) => {
            own_rest == rest && names(own, env) && names(so_far, carried) && same_place(one, other)
        }
        (Run::Else(one, own_second, own, own_kind), Run::Else(other, second, env, kind)) => {
            own_kind == kind && own_second == second && names(own, env) && same_place(one, other)
        }
        (Run::Par(one), Run::Par(other)) | (Run::Disable(one), Run::Disable(other)) => all(one, other),
        (Run::New(port, one), Run::New(own, other)) => port == own && same_place(one, other),
        (Run::Only(shown, one), Run::Only(own, other)) => shown == own && same_place(one, other),
        _ => false,
    }
}
