//! A chain compiled to be run: machine numbers for what is drawn from a density, rationals for what is not, so that a
//! comparison of exact numbers is never decided by rounding. Where all these are whole, and not too large, machine numbers
//! are exact themselves.

mod compile;
mod foresight;
pub(super) mod lanes;
mod trim;

use std::cell::Cell;
use std::cmp::Ordering;
use std::sync::OnceLock;

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::Zero;

use self::compile::{distances, form, has_atoms, known, near, ticks, unit, whole};
use self::foresight::Foresight;
use self::trim::trimmed;
use super::Question;
use super::chain::{Chain, Linear, Move, Side};
use super::random::{Draws, Sampler, Source, pair};
use crate::value::Relation;

/// Bits of an exact number.
const MOST_BITS: u64 = 4_096;
/// Rounds of one run.
const MOST_ROUNDS: u64 = 1_000_000;

/// A linear form over the numbers of the state, followed by those that are drawn.
struct Form {
    terms: Vec<(usize, f64)>,
    constant: f64,
    /// The same exactly, where all that it depends on is known exactly.
    exact: Option<Linear>,
}

struct Test {
    relation: Relation,
    form: Form,
    /// Whether it may be just where a bound is: with a number that is drawn now from a density it never is.
    may_tie: bool,
}

/// What a sum is next to nothing beside, in relation to its parts: numbers that are equal are so close after many
/// roundings, and others hardly ever.
const TIE: f64 = 1e-12;

/// How the numbers of a run are kept.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Numbers {
    /// Machine numbers where what is not drawn from a density is whole; else as below.
    Whole,
    /// Rationals for what is not drawn from a density, machine numbers for the rest.
    Mixed,
    /// Rationals for all: a machine number that is drawn is one.
    Exact,
}

struct Stretch {
    /// Ticks; none: for ever.
    duration: Option<u64>,
    shown: Vec<Vec<Test>>,
}

/// A move to be run.
struct Step {
    samplers: Vec<Sampler>,
    /// Which of them matter, to it or to one that draws the same.
    needed: Vec<bool>,
    /// Whether it draws what the one before it draws.
    same: bool,
    /// Whether exact numbers matter in it.
    exact: bool,
    tests: Vec<Test>,
    stretches: Vec<Stretch>,
    image: Vec<Form>,
    next: Option<usize>,
    /// The gap of a run that could take it towards what is asked for: alternatives of tests, at the means of the draws.
    gaps: Vec<Vec<Test>>,
    means: Vec<f64>,
}

/// A chain with a question, to be run.
pub(super) struct Program {
    initial: Vec<Step>,
    phases: Vec<Vec<Step>>,
    /// How many moves it takes from a phase until what is asked for may be shown.
    distances: Vec<f64>,
    first: bool,
    deadline: u64,
    /// By phase, where exact numbers are whole machine numbers: which these are.
    whole: Option<Vec<Vec<bool>>>,
    /// How numbers are kept.
    numbers: Numbers,
    /// By phase, once it is asked for.
    foresight: OnceLock<Vec<Foresight>>,
    chain: Chain,
}

/// Whole numbers of a state, and the sum of the factors of a form, up to which sums of products are exact.
const MOST_WHOLE: f64 = (1u64 << 40) as f64;
const MOST_FACTORS: i64 = 1 << 11;

/// A run on its way.
#[derive(Clone, Default)]
pub(super) struct Runner {
    phase: Option<usize>,
    now: u64,
    round: u64,
    state: Vec<f64>,
    exact: Vec<BigRational>,
}

/// Space for the numbers of a round.
#[derive(Default)]
pub(super) struct Scratch {
    numbers: Vec<f64>,
    drawn: Vec<BigRational>,
    after: Vec<f64>,
    /// Whether a number was taken for equal to what it is compared with, as it is next to it.
    pub(super) tied: Cell<bool>,
}

impl Program {
    /// With numbers that are kept so.
    ///
    /// # Errors
    /// Where durations have no common unit, or something cannot be drawn.
    pub(super) fn new(chain: &Chain, question: &Question, numbers: Numbers) -> Result<Program, String> {
        let chain = &trimmed(chain);
        let unit = unit(chain, question);
        let mut known = known(chain, numbers)?;
        let whole = (numbers == Numbers::Whole && whole(chain)).then(|| known.clone());
        if whole.is_some() {
            known.iter_mut().flatten().for_each(|known| *known = false);
        }
        let numbers = if whole.is_none() && numbers == Numbers::Whole { Numbers::Mixed } else { numbers };
        let widths: Vec<usize> = known.iter().map(Vec::len).collect();
        let compile = |moves: &[Move], from: Option<usize>| {
            let known_here: &[bool] = from.map_or(&[], |phase| known[phase].as_slice());
            let mut steps: Vec<Step> = Vec::new();
            for one in moves {
                let mut step = Step::new(one, known_here, &unit, numbers)?;
                step.exact |= one.next.is_some_and(|next| known.get(next).is_some_and(|known| known.contains(&true)));
                step.same = steps.last().is_some_and(|last| last.samplers == step.samplers && last.exact == step.exact);
                steps.push(step);
            }
            // What is drawn once must do for all that draw the same.
            for place in (1..steps.len()).rev() {
                let later = if steps[place].same { steps[place].needed.clone() } else { Vec::new() };
                steps[place - 1].needed.iter_mut().zip(later).for_each(|(needed, later)| *needed |= later);
            }
            Ok::<_, String>(steps)
        };
        let ticks = ticks(&question.time, &unit).ok_or("the time is too large for its finest part")?;
        let mut program = Program {
            initial: compile(&chain.initial, None)?,
            phases: Vec::new(),
            distances: distances(chain),
            first: question.first,
            deadline: ticks,
            whole,
            numbers,
            foresight: OnceLock::new(),
            chain: Chain::clone(chain),
        };
        for (phase, moves) in chain.phases.iter().enumerate() {
            program.phases.push(compile(moves, Some(phase))?);
        }
        for (phase, (steps, moves)) in program.phases.iter_mut().zip(&chain.phases).enumerate() {
            for (step, one) in steps.iter_mut().zip(moves) {
                let sides = asked_of(one, phase, &program.distances);
                let test = |side: &Side| {
                    let form = form(&side.form, widths[phase], &[], &[]);
                    Test { relation: side.relation, form, may_tie: false }
                };
                step.gaps = sides.iter().map(|sides| sides.iter().map(test).collect()).collect();
            }
        }
        Ok(program)
    }

    /// One more round; whether it happens, once that is decided.
    ///
    /// # Errors
    /// Where a run gets stuck, or never ends.
    pub(super) fn turn(
        &self,
        run: &mut Runner,
        source: &impl Draws,
        space: &mut Scratch,
    ) -> Result<Option<bool>, String> {
        let steps = run.phase.map_or(self.initial.as_slice(), |phase| self.phases[phase].as_slice());
        let width = run.state.len();
        space.numbers.clear();
        space.numbers.extend_from_slice(&run.state);
        let mut chosen = None;
        for step in steps {
            if !step.same {
                space.numbers.truncate(width);
                step.draw(source, run.round, space);
            }
            if step.tests.iter().all(|test| test.holds(space, run)) {
                chosen = Some(step);
                break;
            }
        }
        let Some(step) = chosen else { return Err(STUCK.to_string()) };
        for stretch in &step.stretches {
            let end = stretch.duration.map_or(u64::MAX, |duration| run.now.saturating_add(duration));
            let counts = run.now <= self.deadline && (self.first || end > self.deadline);
            let here = counts && stretch.shown.iter().any(|tests| tests.iter().all(|test| test.holds(space, run)));
            if here || (counts && !self.first) {
                return Ok(Some(here));
            }
            run.now = end;
        }
        let Some(next) = step.next.filter(|_| run.now <= self.deadline) else { return Ok(Some(false)) };
        space.after.clear();
        space.after.extend(step.image.iter().map(|form| form.at(&space.numbers)));
        if step.exact {
            run.exact = step.image.iter().map(|form| form.exactly(&run.exact, &space.drawn)).collect();
            if run.exact.iter().any(|number| number.denom().bits() > MOST_BITS || number.numer().bits() > MOST_BITS) {
                return Err("the exact numbers of a run grow too long".to_string());
            }
        }
        let known = self.whole.as_ref().and_then(|whole| whole.get(next)).into_iter().flatten();
        if known.zip(&space.after).any(|(known, number)| *known && number.abs() > MOST_WHOLE) {
            return Err(TOO_LARGE.to_string());
        }
        std::mem::swap(&mut run.state, &mut space.after);
        run.phase = Some(next);
        run.round += 1;
        if run.round > MOST_ROUNDS { Err(TOO_LONG.to_string()) } else { Ok(None) }
    }

    /// Whether it happens in one run.
    pub(super) fn happens(&self, source: &Source, space: &mut Scratch) -> Result<bool, String> {
        let mut run = Runner::default();
        loop {
            if let Some(found) = self.turn(&mut run, source, space)? {
                return Ok(found);
            }
        }
    }

    /// The phase in which a run is as it misses what is asked for; none where it happens, or the run ends before any phase.
    ///
    /// # Errors
    /// Where the run gets stuck, or more rounds pass than are left.
    pub(super) fn missed(&self, source: &Source, space: &mut Scratch, left: &mut u64) -> Result<Option<usize>, String> {
        let mut run = Runner::default();
        loop {
            *left = left.checked_sub(1).ok_or(TOO_LONG)?;
            if let Some(found) = self.turn(&mut run, source, space)? {
                return Ok(run.phase.filter(|_| !found));
            }
        }
    }

    /// Whether a number that is drawn from a density may be next to what it is compared with.
    pub(super) fn may_tie(&self) -> bool {
        let steps = self.initial.iter().chain(self.phases.iter().flatten());
        let shown =
            |step: &'_ Step| step.stretches.iter().flat_map(|stretch| stretch.shown.iter().flatten()).any(Test::ties);
        steps.into_iter().any(|step| step.tests.iter().any(Test::ties) || shown(step))
    }

    /// Whether all numbers are rationals.
    pub(super) fn is_exact(&self) -> bool {
        self.numbers == Numbers::Exact
    }

    /// Whether exact numbers are machine numbers.
    pub(super) fn is_whole(&self) -> bool {
        self.whole.is_some()
    }

    /// Whether nothing is drawn, so that all runs are alike.
    pub(super) fn is_certain(&self) -> bool {
        let steps = self.initial.iter().chain(self.phases.iter().flatten());
        steps.flat_map(|step| &step.samplers).all(|sampler| matches!(sampler, Sampler::Point(..)))
    }

    /// What each phase looks ahead to.
    fn foreseen(&self) -> Vec<Foresight> {
        let of = |(phase, moves): (usize, &Vec<Move>)| {
            let all: Vec<_> = moves
                .iter()
                .zip(&self.phases[phase])
                .map(|(one, step)| {
                    let lasting = step.stretches.iter().map(|stretch| stretch.duration.unwrap_or(u64::MAX));
                    (one, asked_of(one, phase, &self.distances), lasting.fold(0, u64::saturating_add))
                })
                .collect();
            Foresight::of(phase, &all, self.deadline)
        };
        self.chain.phases.iter().enumerate().map(of).collect()
    }

    /// How near a run is to what is asked for: the moves that it still takes, and how far the first of them is from being
    /// taken, by the effort that this takes, or as the square of that gap over the time that is left, by which a walk's
    /// chance to close it is ordered. Any measure gives an estimate without bias; a good one gives a narrow one.
    pub(super) fn nearness(&self, run: &Runner) -> f64 {
        let Some(phase) = run.phase else { return f64::NEG_INFINITY };
        let distance = self.distances[phase];
        let foresight = self.foresight.get_or_init(|| self.foreseen());
        if let Some(effort) = foresight[phase].effort(&run.state, self.deadline.saturating_sub(run.now)) {
            return -distance - effort / (1.0 + effort);
        }
        let left = self.deadline.saturating_sub(run.now) as f64 / self.deadline.max(1) as f64;
        let least = self.gap(run, phase);
        let far = if least == 0.0 { 0.0 } else { least * least / left };
        -distance - if far.is_finite() { far / (1.0 + far) } else { 1.0 }
    }

    /// The same whatever time is left: the moves that it still takes, and the gap itself. A run is measured by it as a whole,
    /// and one that comes near at the last look has come as near as another.
    pub(super) fn closeness(&self, run: &Runner) -> f64 {
        let Some(phase) = run.phase else { return f64::NEG_INFINITY };
        let gap = self.gap(run, phase);
        -self.distances[phase] - if gap.is_finite() { gap / (1.0 + gap) } else { 1.0 }
    }

    /// How far a run is from what the next move shows, or from taking it.
    fn gap(&self, run: &Runner, phase: usize) -> f64 {
        let mut least = f64::INFINITY;
        for step in &self.phases[phase] {
            let number = |place: usize| match run.state.get(place) {
                Some(number) => *number,
                None => step.means.get(place - run.state.len()).copied().unwrap_or_default(),
            };
            for tests in &step.gaps {
                let gap = tests.iter().map(|test| test.gap(&number)).fold(0.0, f64::max);
                least = least.min(gap);
            }
        }
        least
    }
}

/// What brings a run that takes a move nearer: that it is taken at all, if it leads on, else what it shows.
fn asked_of<'m>(one: &'m Move, phase: usize, distances: &[f64]) -> Vec<&'m Vec<Side>> {
    let nearer = one.next.is_some_and(|next| distances[next] < distances[phase]);
    if nearer { vec![&one.tests] } else { one.stretches.iter().flat_map(|stretch| &stretch.shown).collect() }
}

const STUCK: &str = "a run got stuck";
const TOO_LONG: &str = "a run has more than a million rounds";
const TOO_LARGE: &str = "the whole numbers of a run grow too large";

impl Step {
    fn new(one: &Move, known: &[bool], unit: &BigInt, numbers: Numbers) -> Result<Step, String> {
        let samplers: Vec<Sampler> = one.draws.iter().map(Sampler::of).collect::<Result<_, _>>()?;
        let discrete: Vec<bool> = samplers.iter().map(|sampler| numbers.keeps(sampler)).collect();
        let width = known.len();
        let compile = |linear: &Linear| {
            let form = form(linear, width, known, &discrete);
            Form { exact: form.exact.filter(|_| numbers != Numbers::Whole), ..form }
        };
        let test = |side: &Side| {
            let drawn = side.form.draws.iter().zip(&one.draws).filter(|(factor, _)| !factor.is_zero());
            let may_tie = drawn.map(|(_, draw)| draw).all(has_atoms);
            Test { relation: side.relation, form: compile(&side.form), may_tie }
        };
        let mut stretches = Vec::new();
        for stretch in &one.stretches {
            let duration = match &stretch.duration {
                Some(duration) => Some(ticks(duration, unit).ok_or("a duration is too large for the finest one")?),
                None => None,
            };
            let shown = stretch.shown.iter().map(|sides| sides.iter().map(test).collect()).collect();
            stretches.push(Stretch { duration, shown });
        }
        let tests: Vec<Test> = one.tests.iter().map(test).collect();
        let shown = stretches.iter().flat_map(|stretch: &Stretch| stretch.shown.iter().flatten());
        let exact = tests.iter().chain(shown).any(|test| test.form.exact.is_some());
        let forms = || one.tests.iter().chain(one.stretches.iter().flat_map(|stretch| stretch.shown.iter().flatten()));
        let forms = || forms().map(|side| &side.form).chain(&one.image);
        let needs = |place: usize| forms().any(|form| form.draws.get(place).is_some_and(|factor| !factor.is_zero()));
        Ok(Step {
            needed: (0..samplers.len()).map(needs).collect(),
            samplers,
            same: false,
            exact,
            tests,
            stretches,
            image: one.image.iter().map(compile).collect(),
            next: one.next,
            gaps: Vec::new(),
            means: one.draws.iter().map(|draw| near(&draw.mean())).collect(),
        })
    }

    /// The same place of the same round gives the same number, whichever way it is drawn on.
    fn draw(&self, source: &impl Draws, round: u64, space: &mut Scratch) {
        let mut place = 0;
        while place < self.samplers.len() {
            let at = place as u64;
            match &self.samplers[place..] {
                _ if !self.needed[place] => {
                    space.numbers.push(0.0);
                    place += 1;
                }
                [Sampler::Normal(mean, sd), Sampler::Normal(mean2, sd2), ..] if place % 2 == 0 => {
                    let (one, other) = pair(source, round, at);
                    space.numbers.extend([mean + sd * one, mean2 + sd2 * other]);
                    place += 2;
                }
                [sampler, ..] => {
                    space.numbers.push(sampler.draw(source, round, at));
                    place += 1;
                }
                [] => break,
            }
        }
        if self.exact {
            space.drawn.clear();
            let numbers = &space.numbers[space.numbers.len() - self.samplers.len()..];
            let drawn = |(place, sampler): (usize, &Sampler)| {
                sampler.exactly(source, round, place as u64).or_else(|| BigRational::from_float(numbers[place]))
            };
            space.drawn.extend(self.samplers.iter().enumerate().map(|one| drawn(one).unwrap_or_default()));
        }
    }
}

impl Numbers {
    /// Whether what is drawn so is kept exactly.
    fn keeps(self, sampler: &Sampler) -> bool {
        match self {
            Numbers::Whole => false,
            Numbers::Mixed => sampler.is_discrete(),
            Numbers::Exact => true,
        }
    }
}

impl Test {
    fn ties(&self) -> bool {
        self.may_tie && self.form.exact.is_none()
    }

    fn holds(&self, space: &Scratch, run: &Runner) -> bool {
        let order = match &self.form.exact {
            Some(_) => self.form.exactly(&run.exact, &space.drawn).cmp(&BigRational::zero()),
            None => {
                let value = self.form.at(&space.numbers);
                space.tied.set(space.tied.get() || self.is_near(value, || self.form.size(&space.numbers)));
                self.order(value, || self.form.size(&space.numbers))
            }
        };
        self.relation.holds(order)
    }

    /// How a value compares with 0, of which the parts have this size.
    fn order(&self, value: f64, size: impl FnOnce() -> f64) -> Ordering {
        let tie = self.is_near(value, size);
        if tie { Ordering::Equal } else { value.total_cmp(&0.0) }
    }

    /// Whether a value, of which the parts have this size, is taken for 0.
    fn is_near(&self, value: f64, size: impl FnOnce() -> f64) -> bool {
        self.may_tie && value.abs() <= TIE * size()
    }

    /// How far it is from holding.
    fn gap(&self, number: &impl Fn(usize) -> f64) -> f64 {
        let terms = self.form.terms.iter().map(|(place, factor)| factor * number(*place));
        let value = self.form.constant + terms.sum::<f64>();
        match self.relation {
            Relation::Gtr | Relation::Gte => (-value).max(0.0),
            Relation::Lss | Relation::Lte => value.max(0.0),
            Relation::Eq => value.abs(),
            Relation::Neq => 0.0,
        }
    }
}

impl Form {
    fn at(&self, numbers: &[f64]) -> f64 {
        self.terms.iter().fold(self.constant, |sum, (place, factor)| sum + factor * numbers[*place])
    }

    /// The sizes of its parts, added up.
    fn size(&self, numbers: &[f64]) -> f64 {
        self.terms.iter().fold(self.constant.abs(), |sum, (place, factor)| sum + (factor * numbers[*place]).abs())
    }

    /// The exact value; 0 where that is not known.
    fn exactly(&self, state: &[BigRational], drawn: &[BigRational]) -> BigRational {
        let Some(linear) = &self.exact else { return BigRational::zero() };
        let mut sum = linear.constant.clone();
        let both = linear.state.iter().zip(state).chain(linear.draws.iter().zip(drawn));
        both.filter(|(factor, _)| !factor.is_zero()).for_each(|(factor, number)| sum += factor * number);
        sum
    }
}
