//! A chain over two coordinates that share their noise or lean on each other: the first decides, the second moves with
//! noise of its own.
//!
//! Odometry and position follow the same commands, so neither is independent of the other; but the drift between them
//! often is. Coordinates in which the noise comes apart are found exactly, with rationals.

use num_rational::BigRational;
use num_traits::{One, Signed, ToPrimitive, Zero};

use super::Question;
use super::axes::{Direction, before, combinations, moves_into, of_state, ratio, settled, shown};
use super::chain::{Chain, Linear, Move, Region};
use super::linear::combination;
use super::plan::{MOST_ROUNDS, duration};
use super::region::{Patch, Set};
use super::step::{SHARED, Sketch};

/// Random numbers that a round may be decided by.
pub(super) const DECIDERS: usize = 6;
/// The sets of a patch: the first coordinate, what is tilted, and from here on the deciders.
pub(super) const LOOKS: usize = 2;
/// How many sets there are.
pub(super) const PLACES: usize = LOOKS + DECIDERS;

/// The coordinates of a phase.
#[derive(Clone, Debug, Default)]
pub(super) struct Basis {
    /// What is looked at.
    pub first: Option<Direction>,
    /// What moves with noise of its own.
    pub second: Option<Direction>,
    /// Where a run ends by `second + slope * first` without noise: the slope.
    pub slope: Option<BigRational>,
}

/// A number that decides, given the state and the next first coordinate: `factor * u + second * v + follows * u' + offset`
/// and noise of this variance; where that is 0, it is known then.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Look {
    pub factor: BigRational,
    pub second: BigRational,
    pub follows: BigRational,
    pub offset: BigRational,
    pub rest: BigRational,
}

/// One way through a round: `u' = slope * u + shift`, `v' = keep * v + lean * u + drift`, each with noise.
#[derive(Clone, Debug)]
pub(super) struct Step {
    pub weight: BigRational,
    /// The phase to which it leads; none where what is asked for is settled by it.
    pub next: Option<usize>,
    /// Whether it leads to no phase, but is summed over a number as if that were the next state.
    pub summed: bool,
    /// Slope, shift, variance.
    pub first: [BigRational; 3],
    /// Keep, lean, drift, variance.
    pub second: [BigRational; 4],
    pub looks: Vec<Look>,
    /// What is looked at and leans on the second coordinate, as the next one and so much of u', u and v; at the end of a run as
    /// v and so much of u.
    pub tilt: [BigRational; 3],
    /// Where it leads to what is asked for, where it does at the last moment only, and where it goes on.
    pub success: Vec<Patch>,
    pub last: Vec<Patch>,
    pub onward: Vec<Patch>,
}

/// A chain over two coordinates.
#[derive(Debug)]
pub(super) struct Pair {
    pub bases: Vec<Basis>,
    pub phases: Vec<Vec<Step>>,
    /// How the system begins, where there is no state.
    pub start: Vec<Step>,
    pub rounds: u64,
}

/// The chain over two coordinates.
///
/// # Errors
/// What keeps it from being one.
pub(super) fn pair(chain: &Chain, question: &Question) -> Result<Pair, String> {
    let settled: Vec<Option<bool>> = (0..chain.phases.len()).map(|phase| settled(chain, question, phase)).collect();
    let open: Vec<usize> = (0..chain.phases.len()).filter(|phase| settled[*phase].is_none()).collect();
    let duration = duration(chain, &open)?.ok_or("there are no rounds")?;
    let rounds = (&question.time / &duration).floor().to_integer().to_u64();
    let rounds = rounds.filter(|rounds| *rounds <= MOST_ROUNDS).ok_or("there are too many rounds")?;
    let finals: Vec<Option<Final>> = (0..chain.phases.len()).map(|phase| last(chain, question, phase)).collect();
    let live: Vec<usize> = open.into_iter().filter(|phase| finals[*phase].is_none()).collect();
    let late = |one: &Move| one.stretches.iter().any(|stretch| stretch.duration.is_some());
    if chain.initial.iter().any(late) {
        return Err("time passes before the first round".to_string());
    }
    let mut coordinates = Coordinates { chain, live: &live, finals: &finals, bases: Vec::new() };
    coordinates.find()?;
    let bases = coordinates.bases;
    let steps = |moves: &[Move], phase: Option<usize>| {
        let mut steps = Vec::new();
        for one in moves {
            for (weight, drawn) in combinations(one)? {
                let sketch =
                    Sketch { chain, question, settled: &settled, finals: &finals, bases: &bases, one, phase, drawn };
                steps.extend(sketch.step(weight)?);
            }
        }
        Ok::<_, String>(steps)
    };
    let mut phases = vec![Vec::new(); chain.phases.len()];
    for phase in &live {
        phases[*phase] = steps(&chain.phases[*phase], Some(*phase))?;
    }
    let start = steps(&chain.initial, None)?;
    for step in &start {
        on_no_edge(step, step.next.and_then(|next| phases.get(next)).map_or(&[], Vec::as_slice))?;
    }
    let constant = constant(&bases, &phases, &start)?;
    for step in phases.iter_mut().flatten() {
        for look in step.looks.iter_mut().filter(|look| !look.second.is_zero()) {
            match &constant {
                Some(number) => look.offset += std::mem::take(&mut look.second) * number,
                // The chance of what decides a round that leads on must not depend on the second coordinate.
                // Nor must the place of a number that is known with the next first one.
                None if step.next.is_some() || look.rest.is_zero() => return Err(SHARED.to_string()),
                None => {}
            }
        }
    }
    Ok(Pair { bases, phases, start, rounds })
}

/// The second coordinate, where nothing ever changes it.
fn constant(bases: &[Basis], phases: &[Vec<Step>], start: &[Step]) -> Result<Option<BigRational>, String> {
    let lands = |step: &&Step| step.next.is_some_and(|next| bases[next].second.is_some());
    if phases.iter().flatten().filter(lands).all(|step| step.second[3].is_positive()) {
        return Ok(None);
    }
    let same = |step: &Step| step.second[0].is_one() && step.second[1..].iter().all(Zero::is_zero);
    let mut known = start.iter().filter(lands).map(|step| (&step.second[2], step.second[3].is_zero()));
    let first = known.next();
    let all = phases.iter().flatten().filter(lands).all(same) && known.all(|other| Some(other) == first);
    match first {
        Some((number, true)) if all => Ok(Some(number.clone())),
        _ => Err("a round adds no noise to a combination of the state".to_string()),
    }
}

/// A guard that nothing random decides, and that is just met by a state that is known, would be met by both sides.
fn on_no_edge(start: &Step, phase: &[Step]) -> Result<(), String> {
    let known = |variance: &BigRational| variance.is_zero();
    let ([_, first, variance], [_, _, second, spread]) = (&start.first, &start.second);
    for step in phase {
        let form = second + &step.tilt[0] * first;
        for patch in step.success.iter().chain(&step.last).chain(&step.onward) {
            let ends = |set: &Set, place: &BigRational| {
                set.iter().any(|(low, high)| low.as_ref() == Some(place) || high.as_ref() == Some(place))
            };
            let now = known(variance) && ends(&patch[0], first);
            if now || (step.next.is_none() && known(variance) && known(spread) && ends(&patch[1], &form)) {
                return Err("the system begins on the edge of a guard".to_string());
            }
        }
    }
    Ok(())
}

/// What a move compares without noise.
fn edges(one: &Move) -> impl Iterator<Item = &super::chain::Side> {
    let silent = one.stretches.iter().filter(|stretch| stretch.duration.is_none());
    let asked = silent.flat_map(|stretch| stretch.shown.iter().flatten());
    one.tests.iter().chain(asked).filter(|side| side.form.draws.iter().all(Zero::is_zero))
}

/// What is asked for of a state that stays as it is: after its round, and at once.
pub(super) type Final = [Region; 2];

/// A phase that nothing random follows, and no other phase: what is asked for is decided on the way into it. None where it
/// is not such a phase.
fn last(chain: &Chain, question: &Question, phase: usize) -> Option<Final> {
    let [one] = chain.phases[phase].as_slice() else { return None };
    if one.next.is_some() || !one.tests.is_empty() {
        return None;
    }
    let silent = one.stretches.iter().find(|stretch| stretch.duration.is_none());
    let silent = silent.map_or(Some(Region::new()), |stretch| of_state(&stretch.shown))?;
    let at_once = shown(chain, phase).ok()?;
    match question.first {
        // Whatever is shown later is shown at once.
        true if silent.is_empty() || silent == at_once => Some([at_once.clone(), at_once]),
        true => None,
        false => Some([silent, at_once]),
    }
}

/// The coordinates in the making.
struct Coordinates<'a> {
    chain: &'a Chain,
    live: &'a [usize],
    finals: &'a [Option<Final>],
    bases: Vec<Basis>,
}

const TWO: &str = "the rounds depend on the state in more than two dimensions";
pub(super) const COMBINATIONS: &str = "several combinations of the state are looked at";
const LEAN: &str = "what is looked at leans on two dimensions of the state";

impl Coordinates<'_> {
    fn find(&mut self) -> Result<(), String> {
        let spans = self.spans()?;
        self.bases = vec![Basis::default(); self.chain.phases.len()];
        for phase in self.live {
            for state in self.deciding(*phase) {
                self.look(*phase, state)?;
            }
        }
        loop {
            self.carry()?;
            let idle = |phase: &&usize| self.bases[**phase].first.is_none() && !spans[**phase].is_empty();
            let Some(phase) = self.live.iter().find(idle).copied() else { break };
            self.choose(phase, &spans[phase])?;
        }
        for phase in self.live {
            let Some(first) = self.bases[*phase].first.clone() else { continue };
            let Some(other) = spans[*phase].iter().find(|form| ratio(&first, &form.state).is_none()) else { continue };
            let share = self.share(*phase, &first, &other.state)?;
            let first = Linear { state: first, ..Linear::default() };
            self.bases[*phase].second = Some(other.plus(&first.scaled(&-share)).state);
        }
        for phase in self.live {
            self.tilt(*phase)?;
        }
        Ok(())
    }

    fn moves_into(&self, phase: usize) -> impl Iterator<Item = (usize, &Move)> {
        moves_into(self.chain, phase).filter(|(from, _)| self.live.contains(from))
    }

    /// What a phase must know of the state: forms that none of the others combine to.
    fn spans(&self) -> Result<Vec<Vec<Linear>>, String> {
        let mut spans: Vec<Vec<Linear>> = vec![Vec::new(); self.chain.phases.len()];
        let mut work: Vec<(usize, Direction)> = Vec::new();
        for phase in self.live {
            let moves = || self.chain.phases[*phase].iter();
            let ends = moves().filter(|one| one.next.is_none()).flat_map(|one| &one.stretches);
            let asked = ends.filter(|stretch| stretch.duration.is_none()).flat_map(|one| one.shown.iter().flatten());
            let sides = moves().flat_map(|one| &one.tests).chain(asked);
            work.extend(sides.map(|side| (*phase, side.form.state.clone())));
            // What is shown in a phase is looked at on the way into it.
            for side in shown(self.chain, *phase)?.iter().flatten() {
                let before = |(from, one): (usize, &Move)| (from, before(&side.form.state, one).state);
                work.extend(self.moves_into(*phase).map(before));
            }
        }
        for (phase, last) in self.finals.iter().enumerate() {
            for side in last.iter().flatten().flatten().flatten() {
                let before = |(from, one): (usize, &Move)| (from, before(&side.form.state, one).state);
                work.extend(self.moves_into(phase).map(before));
            }
        }
        while let Some((phase, state)) = work.pop() {
            if combination(&spans[phase], &state).is_some() {
                continue;
            }
            if spans[phase].len() == 2 {
                return Err(TWO.to_string());
            }
            work.extend(self.moves_into(phase).map(|(from, one)| (from, before(&state, one).state)));
            spans[phase].push(Linear { state, ..Linear::default() });
        }
        Ok(spans)
    }

    /// What decides whether a round of a phase leads on.
    fn deciding(&self, phase: usize) -> Vec<Direction> {
        let goes_on = |one: &&Move| one.next.is_some_and(|next| self.live.contains(&next));
        let tests = self.chain.phases[phase].iter().filter(goes_on).flat_map(|one| &one.tests);
        tests.map(|side| side.form.state.clone()).collect()
    }

    fn look(&mut self, phase: usize, state: Direction) -> Result<bool, String> {
        match &self.bases[phase].first {
            _ if state.iter().all(Zero::is_zero) => Ok(false),
            Some(first) if ratio(first, &state).is_some() => Ok(false),
            Some(_) => Err(LEAN.to_string()),
            None => {
                self.bases[phase].first = Some(state);
                Ok(true)
            }
        }
    }

    /// Where nothing decides, the first coordinate is one of these that lean on no other.
    fn choose(&mut self, phase: usize, span: &[Linear]) -> Result<(), String> {
        let bases = self.bases.clone();
        let mut refused = String::new();
        let own = span.iter().map(|form| form.state.clone());
        for state in own.chain(self.kept(phase, span)) {
            self.bases[phase].first = Some(state);
            match self.carry() {
                Ok(()) => return Ok(()),
                Err(reason) => refused = reason,
            }
            self.bases.clone_from(&bases);
        }
        Err(refused)
    }

    /// The forms of a phase that a round makes multiples of themselves, where their factors are rational: of a matrix with
    /// the eigenvalues l and m the rows of A - m are multiples of a form with the eigenvalue l.
    fn kept(&self, phase: usize, span: &[Linear]) -> Vec<Direction> {
        let [one, other] = span else { return Vec::new() };
        let mut kept = Vec::new();
        for (_, round) in self.moves_into(phase).filter(|(from, _)| *from == phase) {
            let rows = [one, other].map(|form| combination(span, &before(&form.state, round).state));
            let [Some(top), Some(low)] = &rows else { continue };
            let ([a, b], [c, d]) = (top.as_slice(), low.as_slice()) else { continue };
            let square = (a - d) * (a - d) + BigRational::from_integer(4.into()) * b * c;
            let Some(root) = root(&square) else { continue };
            for root in [root.clone(), -root] {
                let value = (a + d + root) / BigRational::from_integer(2.into());
                let row = [(a - &value, b.clone()), (c.clone(), d - &value)];
                let found = row.into_iter().find(|(x, y)| !x.is_zero() || !y.is_zero());
                kept.extend(found.map(|(x, y)| one.scaled(&x).plus(&other.scaled(&y)).state));
            }
        }
        kept
    }

    /// What is looked at must be known a round before.
    fn carry(&mut self) -> Result<(), String> {
        let mut work: Vec<usize> = self.live.to_vec();
        while let Some(phase) = work.pop() {
            let Some(first) = self.bases[phase].first.clone() else { continue };
            let earlier: Vec<(usize, Direction)> =
                self.moves_into(phase).map(|(from, one)| (from, before(&first, one).state)).collect();
            for (from, state) in earlier {
                if self.look(from, state)? {
                    work.push(from);
                }
            }
        }
        Ok(())
    }

    /// How much of the first coordinate is to be taken from another form so that their noise comes apart.
    fn share(&self, phase: usize, first: &[BigRational], other: &[BigRational]) -> Result<BigRational, String> {
        for (_, one) in self.moves_into(phase) {
            let (first, other) = (before(first, one).draws, before(other, one).draws);
            for (_, drawn) in combinations(one)? {
                let inner = |left: &[BigRational], right: &[BigRational]| {
                    let both = left.iter().zip(right).zip(&drawn);
                    both.map(|((left, right), (_, variance))| left * right * variance).sum::<BigRational>()
                };
                let own = inner(&first, &first);
                if own.is_positive() {
                    return Ok(inner(&first, &other) / own);
                }
            }
        }
        Ok(BigRational::zero())
    }

    /// The one form of both coordinates by which a run ends without noise.
    fn tilt(&mut self, phase: usize) -> Result<(), String> {
        let ends = |one: &&Move| one.next.is_none_or(|next| !self.live.contains(&next));
        let ends = self.chain.phases[phase].iter().filter(ends).flat_map(edges);
        let sides = ends.map(|side| side.form.state.clone());
        let sides: Vec<Direction> = sides.chain(self.asked_after(phase)).collect();
        for state in sides {
            let Some((first, second)) = self.bases[phase].apart(&state) else { return Err(TWO.to_string()) };
            if second.is_zero() {
                continue;
            }
            let slope = first / second;
            if self.bases[phase].slope.replace(slope.clone()).is_some_and(|other| other != slope) {
                return Err(COMBINATIONS.to_string());
            }
        }
        Ok(())
    }

    /// What is asked for in the phases that end a run, and no noise changes on the way there.
    fn asked_after(&self, phase: usize) -> impl Iterator<Item = Direction> {
        let last = |one: &'_ Move| one.next.and_then(|next| self.finals[next].as_ref());
        let into = self.chain.phases[phase].iter().filter_map(move |one| Some((one, last(one)?)));
        let forms =
            into.flat_map(|(one, last)| last.iter().flatten().flatten().map(|side| before(&side.form.state, one)));
        forms.filter(|form| form.draws.iter().all(Zero::is_zero)).map(|form| form.state)
    }
}

/// The root of a rational, where that is one.
fn root(square: &BigRational) -> Option<BigRational> {
    let root = BigRational::new(square.numer().abs().sqrt(), square.denom().sqrt());
    (&root * &root == *square).then_some(root)
}

impl Look {
    /// For a number that is looked at elsewhere.
    pub(super) fn nothing() -> Look {
        let zero = BigRational::zero;
        Look { factor: zero(), second: zero(), follows: zero(), offset: zero(), rest: BigRational::one() }
    }
}

impl Basis {
    /// The factors of both coordinates in a direction.
    pub(super) fn apart(&self, state: &[BigRational]) -> Option<(BigRational, BigRational)> {
        let form = |direction: &Option<Direction>| direction.clone().map(|state| Linear { state, ..Linear::default() });
        let forms: Vec<Linear> = [form(&self.first), form(&self.second)].into_iter().flatten().collect();
        let factors = combination(&forms, state)?;
        let mut factors = factors.into_iter();
        let first = if self.first.is_some() { factors.next()? } else { BigRational::zero() };
        Some((first, factors.next().unwrap_or_default()))
    }
}
