//! Systems that draw times which run beside each other and beside a mission: a failure that comes at random, a watchdog,
//! the first or the last of several waits.
//!
//! The system is followed as the kernel steps it ([`Instant`], [`Draws`]), with what is drawn as unknowns. Where it
//! matters which of two times is the earlier, both cases are followed; that they are equal has no chance, as every
//! number that is kept as an unknown has a density and the comparison is linear. The chance is the sum of the chances of
//! the cases in which it happens; cases that go the same way in the end are one.

mod pair;
mod region;

use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;

use num_rational::BigRational;
use num_traits::{One, Zero};

use super::direct::counted_from_nothing;
use super::{Enclosed, Question};
use crate::advance::Instant;
use crate::advance::draw::Draws;
use crate::assumption::Assumptions;
use crate::definition::Definitions;
use crate::distribution::Distribution;
use crate::fact::{Context, Facts};
use crate::interval::Interval;
use crate::invariant::Claim;
use crate::law::Condition;
use crate::name::Name;
use crate::scope::subterms;
use crate::substitution::substitute_values;
use crate::term::{Node, Term};
use crate::value::{Atom, Relation, Value, ValueError};
use region::{Form, Region};

/// Steps that are followed in all cases together.
const MOST_STEPS: usize = 1_500;
/// Cases within cases.
const MOST_DEPTH: usize = 120;
/// Kinds of distributions that are drawn from at one moment, in mixtures.
const MOST_KINDS: usize = 64;
/// How wide an interval may be that still says something.
const WIDEST: f64 = 0.05;

/// A chance.
pub struct Found {
    /// The chance.
    pub chance: Enclosed,
    /// How many cases there were.
    pub cases: usize,
    /// Whether a bound on an integral without closed form is part of it.
    pub wide: bool,
}

/// How it ends.
#[derive(Debug)]
enum Fate {
    Happens,
    Never,
    /// Where a form is positive, and where it is negative.
    Either(Form, Rc<Fate>, Rc<Fate>),
    /// What is drawn, and then.
    Drawn(Vec<(Name, Distribution)>, Rc<Fate>),
    /// One of several, with their weights.
    Mixed(Vec<(BigRational, Rc<Fate>)>),
}

/// The chance that it happens. Durations that are drawn below 0 count as 0.
///
/// # Errors
/// Where the system cannot be followed, compares what is drawn in another way than linearly, goes through too many
/// cases, or compares too many draws with each other for a narrow interval.
pub fn races(
    system: &Term,
    definitions: &Definitions,
    assumptions: &Assumptions,
    event: &Claim,
    question: &Question,
) -> Result<Found, String> {
    let (system, definitions) = counted_from_nothing(system, definitions)?;
    let facts = Facts::of(&system, &Context::new(assumptions, &definitions, &[]));
    // What has ended shows nothing, and goes on showing nothing.
    let stopped = if facts.may_abort { Term::otherwise(system, Term::stop()) } else { system };
    let lasting = if facts.may_stop || facts.may_abort { Term::seq([stopped, Term::idle()]) } else { stopped };
    // A port that only one part uses is never answered.
    let ports = facts.ports.names.iter().rev();
    let system = ports.fold(lasting, |body, port| Term::new(Node::New(port.clone(), body)));
    let mut walk = Walk {
        definitions: &definitions,
        assumptions,
        event,
        question,
        steps: 0,
        called: Vec::new(),
        known: HashMap::new(),
    };
    let rest = Value::rational(question.time.clone());
    let fate = walk.follow(system, rest, &Region::default(), 0).map_err(|reason| walk.told(reason))?;
    let mut found = Sum { chance: Interval::exactly(0.0), cases: 0, wide: false };
    found.add(&fate, &Region::default(), &BigRational::one())?;
    let chance = Enclosed::within(found.chance.probability());
    if chance.width() > WIDEST {
        return Err("several drawn times decide it together, and no narrow interval was found".to_string());
    }
    Ok(Found { chance, cases: found.cases, wide: found.wide })
}

struct Walk<'a> {
    definitions: &'a Definitions,
    assumptions: &'a Assumptions,
    event: &'a Claim,
    question: &'a Question,
    steps: usize,
    /// What is called `drawn n` here, as the text calls it.
    called: Vec<Name>,
    /// How it ends from where nothing that was drawn matters any more: by the network and the time that is left.
    known: HashMap<(Term, Value), Rc<Fate>>,
}

fn odd(error: ValueError) -> String {
    error.0
}

/// What comes next.
enum Next {
    Fate(Rc<Fate>),
    /// It has to be known whether this is positive or negative.
    Whether(Form),
    /// Time passes: the network then, and the time that is left.
    Passed(Term, Value),
}

impl Walk<'_> {
    /// A reason as a sentence, in the names of the text.
    fn told(&self, mut reason: String) -> String {
        // Backwards, as `drawn 1` begins `drawn 12`.
        for (place, own) in self.called.iter().enumerate().rev() {
            reason = reason.replace(&format!("drawn {place}"), own.as_str());
        }
        if reason.starts_with("whether ") { format!("it must be known {reason}") } else { reason }
    }

    /// How it ends from here, with so much time left.
    fn follow(&mut self, state: Term, rest: Value, region: &Region, depth: usize) -> Result<Rc<Fate>, String> {
        let mentions = |name: &Name| subterms(&state).any(|part| part.values().any(|value| value.mentions(name)));
        let key =
            (!region.names().any(|name| rest.mentions(name) || mentions(name))).then(|| (state.clone(), rest.clone()));
        if let Some(fate) = key.as_ref().and_then(|key| self.known.get(key)) {
            return Ok(fate.clone());
        }
        if depth > MOST_DEPTH {
            return Err(format!("there are more than {MOST_DEPTH} cases within cases"));
        }
        let fate = self.onward(state, rest, region, depth)?;
        if let Some(key) = key {
            self.known.insert(key, fate.clone());
        }
        Ok(fate)
    }

    fn onward(&mut self, mut state: Term, mut rest: Value, region: &Region, depth: usize) -> Result<Rc<Fate>, String> {
        let positive = region.positive().map_err(odd)?;
        let supposed = |value: Value| Condition::Compare(Relation::Gtr, value, Value::zero());
        let hypotheses: Vec<Condition> = positive.into_iter().map(supposed).collect();
        let definitions = self.definitions;
        let context = Context::new(self.assumptions, definitions, &hypotheses);
        loop {
            self.steps += 1;
            if self.steps > MOST_STEPS {
                return Err(format!("there are more than {MOST_STEPS} steps to follow"));
            }
            let next = match Instant::of(&state, &context) {
                Ok(instant) => self.next(&instant, &rest, region, &context)?,
                Err(stuck) => match Draws::of(&state, &context) {
                    Ok(draws) => return self.drawn(&draws, &rest, region, &context, depth),
                    Err(_) => Next::Whether(guess(&state, region, &context).ok_or(stuck.0)?),
                },
            };
            match next {
                Next::Fate(fate) => return Ok(fate),
                Next::Passed(network, left) => (state, rest) = (network, left),
                Next::Whether(form) => return self.cases(&form, (&state, &rest), region, depth),
            }
        }
    }

    /// Both cases of what has to be known.
    fn cases(
        &mut self,
        form: &Form,
        (state, rest): (&Term, &Value),
        region: &Region,
        depth: usize,
    ) -> Result<Rc<Fate>, String> {
        let mut case = |form: &Form| match region.cut(form) {
            Some(region) => self.follow(state.clone(), rest.clone(), &region, depth + 1).map(Some),
            None => Ok(None),
        };
        let (above, below) = (case(form)?, case(&form.opposite())?);
        Ok(match (above, below) {
            (Some(above), Some(below)) => match (&*above, &*below) {
                (Fate::Happens, Fate::Happens) | (Fate::Never, Fate::Never) => above,
                _ => Rc::new(Fate::Either(form.clone(), above, below)),
            },
            (Some(one), None) | (None, Some(one)) => one,
            (None, None) => Rc::new(Fate::Never),
        })
    }

    /// What comes after an instant.
    fn next(&self, instant: &Instant, rest: &Value, region: &Region, context: &Context<'_>) -> Result<Next, String> {
        let known = &context.assumptions;
        let whether = |value: &Value| match Form::of(value, region) {
            Some(form) if !form.is_constant() => Ok(Next::Whether(form)),
            _ => Err(format!("it must be known whether {value} > 0")),
        };
        let delays = instant.delays();
        for delay in &delays {
            let over = delay.sub(rest).map_err(odd)?;
            if known.decide(Relation::Gtr, &over, &Value::zero()).is_none() {
                return whether(&over);
            }
        }
        let least = match least(&delays, region, known)? {
            Ok(least) => least,
            Err(difference) => return whether(&difference),
        };
        let left = least.map(|least| rest.sub(least)).transpose().map_err(odd)?;
        let last = left.as_ref().is_none_or(|left| known.decide(Relation::Gte, left, &Value::zero()) != Some(true));
        if self.question.first || last {
            match self.shown(instant, known)? {
                Ok(true) => return Ok(Next::Fate(Rc::new(Fate::Happens))),
                Ok(false) if last => return Ok(Next::Fate(Rc::new(Fate::Never))),
                Ok(false) => {}
                Err(value) => return whether(&value),
            }
        }
        match (least, left) {
            (Some(least), Some(left)) => match instant.after(least, context) {
                Ok(network) => Ok(Next::Passed(network, left)),
                Err(stuck) => guess(&instant.network(), region, context).map(Next::Whether).ok_or(stuck.0),
            },
            _ => Ok(Next::Fate(Rc::new(Fate::Never))),
        }
    }

    /// Whether what is asked for is shown, or of which value the sign has to be known.
    fn shown(&self, instant: &Instant, known: &Assumptions) -> Result<Result<bool, Value>, String> {
        for duty in self.event.duties(&instant.shown()).map_err(odd)? {
            let (mut all, mut open) = (true, None);
            for test in duty.premises.iter().chain(&duty.tests) {
                match test.decide(known) {
                    Some(holds) => all &= holds,
                    None => open = Some(test.left.sub(&test.right).map_err(odd)?),
                }
            }
            match open {
                Some(value) if all => return Ok(Err(value)),
                None if all => return Ok(Ok(true)),
                _ => {}
            }
        }
        Ok(Ok(false))
    }

    /// The cases of what is drawn.
    fn drawn(
        &mut self,
        draws: &Draws,
        rest: &Value,
        region: &Region,
        context: &Context<'_>,
        depth: usize,
    ) -> Result<Rc<Fate>, String> {
        let mut kinds = vec![(BigRational::one(), Vec::new())];
        for (_, from) in draws.due() {
            let parts = Distribution::of(from)?.parts();
            let longer = |(weight, kinds): &(BigRational, Vec<Distribution>)| {
                let more = |(share, part): &(BigRational, Distribution)| {
                    (weight * share, [kinds.as_slice(), std::slice::from_ref(part)].concat())
                };
                parts.iter().map(more).collect::<Vec<_>>()
            };
            kinds = kinds.iter().flat_map(longer).collect();
            if kinds.len() > MOST_KINDS {
                return Err(format!("more than {MOST_KINDS} kinds of numbers are drawn at one moment"));
            }
        }
        let fresh = |place: usize| Name::new(&format!("drawn {}", self.called.len() + place));
        let names: Vec<Name> = (0..draws.due().len()).map(fresh).collect();
        self.called.extend(draws.due().iter().map(|(own, _)| own.clone()));
        draws.made(&names, context).map_err(|stuck| stuck.0)?;
        let network = draws.after(&names).map_err(|stuck| stuck.0)?;
        let mut all = Vec::new();
        for (weight, kinds) in kinds {
            let (mut inside, mut points, mut drawn) = (region.clone(), BTreeMap::new(), Vec::new());
            for (name, kind) in names.iter().zip(kinds) {
                match certain(&kind) {
                    Some(number) => drop(points.insert(name.clone(), Value::rational(number))),
                    None => {
                        inside = inside.with(name, &kind).ok_or("a number is drawn that has no density known here")?;
                        drawn.push((name.clone(), kind));
                    }
                }
            }
            let network = substitute_values(&network, &points).map_err(|stuck| stuck.0)?;
            let fate = self.follow(network, rest.clone(), &inside, depth + 1)?;
            let plain = drawn.is_empty() || matches!(*fate, Fate::Happens | Fate::Never);
            all.push((weight, if plain { fate } else { Rc::new(Fate::Drawn(drawn, fate)) }));
        }
        Ok(match all.as_slice() {
            [(_, one)] => one.clone(),
            all if all.iter().all(|(_, fate)| matches!(**fate, Fate::Never)) => Rc::new(Fate::Never),
            _ => Rc::new(Fate::Mixed(all)),
        })
    }
}

/// The number that is drawn for certain.
fn certain(distribution: &Distribution) -> Option<BigRational> {
    match distribution {
        Distribution::Point(at) => Some(at.clone()),
        Distribution::Normal { mean, variance } if variance.is_zero() => Some(mean.clone()),
        _ => None,
    }
}

/// The least of the delays, or a difference of two whose sign has to be known for that.
fn least<'d>(
    delays: &'d [Value],
    region: &Region,
    known: &Assumptions,
) -> Result<Result<Option<&'d Value>, Value>, String> {
    let (drawn, plain): (Vec<&Value>, Vec<&Value>) =
        delays.iter().partition(|delay| region.names().any(|name| delay.mentions(name)));
    let mut least: Option<&Value> = None;
    for delay in plain.into_iter().chain(drawn) {
        let Some(before) = least else {
            least = Some(delay);
            continue;
        };
        match known.decide(Relation::Lss, delay, before) {
            Some(true) => least = Some(delay),
            Some(false) => {}
            None => return Ok(Err(delay.sub(before).map_err(odd)?)),
        }
    }
    Ok(Ok(least))
}

/// What may have to be known for a network to go on: whether a number that was drawn is positive, and comparisons and
/// durations in its text that are not decided. To tell cases apart is never wrong.
fn guess(network: &Term, region: &Region, context: &Context<'_>) -> Option<Form> {
    let mut bound: BTreeMap<Name, Value> = BTreeMap::new();
    for part in subterms(network) {
        if let Node::Set(value, name) = part.node() {
            bound.insert(name.clone(), value.clone());
        }
    }
    let mut differences: Vec<Value> = region.names().map(Value::variable).collect();
    for part in subterms(network) {
        let value = match part.node() {
            Node::Guard(_, left, right) => left.sub(right).ok(),
            Node::Delay(time) => Some(time.clone()),
            _ => None,
        };
        let Some(value) = value.and_then(|value| value.substitute(&bound).ok()) else { continue };
        for atom in value.atoms() {
            match atom {
                Atom::Maximum(parts) => differences.extend(parts.iter().cloned()),
                Atom::Positive(inner) => differences.push(inner),
                _ => {}
            }
        }
        differences.push(value);
    }
    let open = |value: &Value| context.assumptions.decide(Relation::Gtr, value, &Value::zero()).is_none();
    let forms = differences.into_iter().filter(open).filter_map(|value| Form::of(&value, region));
    forms.into_iter().find(|form| !form.is_constant())
}

/// Chances added up.
struct Sum {
    chance: Interval,
    cases: usize,
    wide: bool,
}

impl Sum {
    fn add(&mut self, fate: &Fate, region: &Region, weight: &BigRational) -> Result<(), String> {
        match fate {
            Fate::Never => {}
            Fate::Happens => {
                let (chance, wide) = region.chance();
                self.chance = self.chance.plus(chance.times(Interval::of(weight)));
                self.cases += 1;
                self.wide |= wide;
            }
            Fate::Either(form, above, below) => {
                for (form, fate) in [(form.clone(), above), (form.opposite(), below)] {
                    if let Some(region) = region.cut(&form) {
                        self.add(fate, &region, weight)?;
                    }
                }
            }
            Fate::Drawn(drawn, fate) => {
                let mut inside = region.clone();
                for (name, distribution) in drawn {
                    inside =
                        inside.with(name, distribution).ok_or("a number is drawn that has no density known here")?;
                }
                self.add(fate, &inside, weight)?;
            }
            Fate::Mixed(all) => {
                for (share, fate) in all {
                    self.add(fate, region, &(weight * share))?;
                }
            }
        }
        Ok(())
    }
}
