//! Chances of a chain with one number that noise of any kind is added to, as functions that are linear between nodes with
//! a proved bound ([`super::broken`]): the chance of success within k more rounds from each state, round by round from the
//! end. It is slower and wider than quadrature, which needs normal noise, and asks for no more than a density.

mod machine;

use num_rational::BigRational;
use num_traits::{ToPrimitive, Zero};

use self::machine::Machine;
use super::axes::{settled, shown};
use super::chain::{Chain, Linear, Move, Region, Side};
use super::kernel::near;
use super::noise::Noise;
use super::plan::duration;
use super::region::{Set, half, meet, whole};
use super::window::sampled;
use super::{Enclosed, Question};
use crate::distribution::Distribution;
use crate::interval::Interval;
use crate::rational::quotient;
use crate::value::Relation;

/// Rounds that are followed.
const MOST_ROUNDS: u64 = 2_000;
/// Products that are added up, cells of a phase at least and at most.
const WORK: f64 = 4e8;
const LEAST_CELLS: f64 = 150.0;
const MOST_CELLS: f64 = 4_000.0;
/// An answer that is wider than this says too little.
const WIDEST: f64 = 0.05;
/// How much more is done where a narrow answer is wanted, and how narrow that is.
const MORE: f64 = 8.0;
const NARROW: f64 = 1e-10;

/// Where a way leads.
#[derive(Clone, Debug)]
enum Target {
    /// To a phase.
    Phase(usize),
    /// To what is asked for where the number lies in this.
    Shown(Set),
}

/// One way through a round: its number is `slope * s + shift` with noise.
#[derive(Clone, Debug)]
struct Way {
    slope: BigRational,
    shift: BigRational,
    noises: Vec<Noise>,
    /// Where the state must lie, and then the number.
    states: Set,
    taken: Set,
    target: Target,
    /// The tests of the state, and what is asked for in the end.
    tests: Vec<Side>,
    region: Region,
}

/// A chance, surely between these.
///
/// # Errors
/// Where a phase has more than one variable, a test asks for other noise than moves the number, or rounds differ in length.
pub fn piecewise(chain: &Chain, question: &Question, wanted: f64) -> Result<Enclosed, String> {
    let settled: Vec<Option<bool>> = (0..chain.phases.len()).map(|phase| settled(chain, question, phase)).collect();
    let live: Vec<usize> = (0..chain.phases.len()).filter(|phase| settled[*phase].is_none()).collect();
    let rounds = match duration(chain, &live)? {
        Some(duration) => (&question.time / duration).floor().to_integer().to_u64(),
        None => Some(0),
    };
    let rounds = rounds.filter(|rounds| *rounds <= MOST_ROUNDS).ok_or("there are too many rounds")?;
    if chain.initial.iter().any(|one| one.stretches.iter().any(|stretch| stretch.duration.is_some())) {
        return Err("time passes before the first round".to_string());
    }
    let ways = |moves: &[Move]| moves.iter().map(|one| way(chain, &settled, one)).collect::<Result<Vec<Way>, String>>();
    let mut phases = vec![Vec::new(); chain.phases.len()];
    for phase in &live {
        phases[*phase] = ways(&chain.phases[*phase])?;
    }
    let resets = |way: &Way| way.noises.is_empty() && way.slope.is_zero() && matches!(way.target, Target::Phase(_));
    if phases.iter().flatten().any(resets) && compares_for_equality(chain) {
        return Err("a number to which rounds come back is compared for equality".to_string());
    }
    let (mut regions, mut sets) = (vec![Region::new(); chain.phases.len()], vec![Set::new(); chain.phases.len()]);
    for phase in &live {
        regions[*phase] = shown(chain, *phase)?;
        sets[*phase] = set(&regions[*phase], &Linear::variable())?;
    }
    let cells = {
        let work = if wanted <= NARROW { MORE * WORK } else { WORK };
        let count = phases.iter().flatten().count().max(1) as f64;
        (work / count / rounds.max(1) as f64).sqrt().clamp(LEAST_CELLS, MOST_CELLS)
    };
    let windows = sampled(chain, rounds);
    let nodes = (0..phases.len()).map(|phase| nodes(phase, &phases, &sets[phase], windows[phase], cells)).collect();
    let machine = Machine { first: question.first, phases, shown: sets, regions, nodes };
    let found = machine.chance(&ways(&chain.initial)?, rounds)?;
    let Interval { low, high } = found.interval();
    if high - low > WIDEST {
        return Err(format!("all that is found so is that it lies between {low:.3} and {high:.3}"));
    }
    Ok(found)
}

/// Whether something asks for equality, which has no chance where nothing has a chance of its own.
fn compares_for_equality(chain: &Chain) -> bool {
    let mut moves = chain.initial.iter().chain(chain.phases.iter().flatten());
    let equal = |side: &Side| matches!(side.relation, Relation::Eq | Relation::Neq);
    moves.any(|one| {
        let shown = one.stretches.iter().flat_map(|stretch| stretch.shown.iter().flatten());
        one.tests.iter().chain(shown).any(equal)
    })
}

impl Linear {
    /// The only variable.
    fn variable() -> Linear {
        Linear { state: vec![num_traits::One::one()], ..Linear::default() }
    }

    fn is_drawn(&self) -> bool {
        self.draws.iter().any(|factor| !factor.is_zero())
    }
}

/// A move as a way.
fn way(chain: &Chain, settled: &[Option<bool>], one: &Move) -> Result<Way, String> {
    let rest = || one.stretches.iter().find(|stretch| stretch.duration.is_none()).map(|rest| rest.shown.clone());
    let (next, region) = match one.next.map(|next| (next, settled.get(next).copied().flatten())) {
        Some((_, Some(true))) => (None, vec![Vec::new()]),
        Some((_, Some(false))) => (None, Region::new()),
        Some((next, None)) => (Some(next), Region::new()),
        None => (None, rest().unwrap_or_default()),
    };
    let image = next.and(one.image.first());
    if next.is_some() && one.image.len() > 1 {
        return Err("a phase has more than one variable".to_string());
    }
    let forms = || one.tests.iter().chain(region.iter().flatten()).map(|side| &side.form);
    let drawn = forms().find(|form| form.is_drawn());
    let form = match (image, drawn) {
        (Some(image), Some(_)) if !image.is_drawn() => {
            return Err("a test asks for noise that does not move the state".to_string());
        }
        (Some(image), _) => image.clone(),
        (None, drawn) => drawn.cloned().unwrap_or_else(Linear::variable),
    };
    let (mut states, mut taken) = (whole(), whole());
    for side in &one.tests {
        let place = if side.form.is_drawn() { &mut taken } else { &mut states };
        let against = if side.form.is_drawn() { &form } else { &Linear::variable() };
        *place = meet(place, &one_side(side, against)?);
    }
    let mut noises: Vec<Distribution> = Vec::new();
    for (factor, draw) in form.draws.iter().zip(&one.draws).filter(|(factor, _)| !factor.is_zero()) {
        let noise = draw.affine(factor, &BigRational::zero()).ok_or("a number of arrivals is multiplied")?;
        match noises.iter_mut().find_map(|other| Some((other.plus(&noise)?, other))) {
            Some((sum, other)) => *other = sum,
            None => noises.push(noise),
        }
    }
    let target = match next {
        Some(next) if chain.phases.get(next).is_some() => Target::Phase(next),
        Some(_) => return Err("a phase is missing".to_string()),
        None => Target::Shown(set(&region, &form)?),
    };
    let slope = match form.state.as_slice() {
        [] => BigRational::zero(),
        [slope] => slope.clone(),
        _ => return Err("a phase has more than one variable".to_string()),
    };
    let noises = noises.iter().map(Noise::of).collect::<Result<_, _>>()?;
    let tests = one.tests.iter().filter(|side| !side.form.is_drawn()).cloned().collect();
    let shift = form.constant.clone();
    Ok(Way { slope, shift, noises, states, taken, target, tests, region })
}

/// Where the number that a form stands for makes a region hold.
fn set(region: &Region, form: &Linear) -> Result<Set, String> {
    let mut all = Set::new();
    for sides in region {
        let mut both = whole();
        for side in sides {
            both = meet(&both, &one_side(side, form)?);
        }
        all.extend(both);
    }
    all.sort();
    Ok(all)
}

/// Where the number that a form stands for makes a side hold: what is compared is a multiple of it and a constant.
fn one_side(side: &Side, form: &Linear) -> Result<Set, String> {
    const OTHER: &str = "a test depends on other numbers than the one that is followed";
    if side.disc.is_some() {
        return Err("a test compares distances".to_string());
    }
    let (states, draws) = (side.form.state.len().max(form.state.len()), side.form.draws.len().max(form.draws.len()));
    let pair = |linear: &Linear| -> Vec<BigRational> {
        let filled = |own: &[BigRational], length: usize| {
            own.iter().cloned().chain(std::iter::repeat_with(BigRational::zero)).take(length).collect::<Vec<_>>()
        };
        [filled(&linear.state, states), filled(&linear.draws, draws)].concat()
    };
    let (own, basis) = (pair(&side.form), pair(form));
    let ratio = match own.iter().zip(&basis).find(|(own, _)| !own.is_zero()) {
        None => {
            let holds = side.relation.holds(side.form.constant.cmp(&BigRational::zero()));
            return Ok(if holds { whole() } else { Set::new() });
        }
        Some((_, basis)) if basis.is_zero() => return Err(OTHER.to_string()),
        Some((own, basis)) => quotient(own, basis),
    };
    if own.iter().zip(&basis).any(|(own, basis)| *own != basis * &ratio) {
        return Err(OTHER.to_string());
    }
    let constant = &side.form.constant - &form.constant * &ratio;
    Ok(match side.relation {
        Relation::Eq => Set::new(),
        Relation::Neq => whole(),
        relation => half(relation, &ratio, &constant),
    })
}

/// The ends of ranges.
fn ends(set: &Set) -> impl Iterator<Item = f64> {
    set.iter().flat_map(|(low, high)| [low, high]).flatten().map(near)
}

fn lies_in(set: &Set, place: f64) -> bool {
    set.iter().any(|(low, high)| {
        low.as_ref().is_none_or(|low| near(low) <= place) && high.as_ref().is_none_or(|high| place <= near(high))
    })
}

/// The nodes of a phase: where something changes, and as many more within its window.
fn nodes(phase: usize, ways: &[Vec<Way>], shown: &Set, window: Option<(f64, f64)>, cells: f64) -> Vec<f64> {
    let into = ways.iter().flatten().filter(|way| matches!(way.target, Target::Phase(next) if next == phase));
    let mut nodes: Vec<f64> = ends(shown).chain(into.flat_map(|way| ends(&way.taken))).collect();
    nodes.extend(ways[phase].iter().flat_map(|way| ends(&way.states)));
    if let Some((low, high)) = window.filter(|(low, high)| low < high) {
        let step = (high - low) / cells.floor();
        nodes.extend((0..=cells as u32).map(|place| low + step * f64::from(place)));
    }
    nodes.sort_by(f64::total_cmp);
    nodes.dedup();
    nodes
}

impl Way {
    /// Whether the tests of the state alone hold.
    fn open_at(&self, place: &BigRational) -> bool {
        self.tests.iter().all(|side| side_holds(side, place))
    }

    /// The number, before the noise.
    fn image(&self, place: &BigRational) -> BigRational {
        &self.slope * place + &self.shift
    }

    /// The number before the noise, at each node; just once where it is always the same.
    fn places(&self, nodes: &[f64]) -> Vec<f64> {
        let (slope, shift) = (near(&self.slope), near(&self.shift));
        if slope == 0.0 || nodes.is_empty() {
            return vec![shift];
        }
        nodes.iter().map(|node| slope * node + shift).collect()
    }
}

/// Whether what is asked for is shown in a state.
fn holds(region: &Region, place: &BigRational) -> bool {
    region.iter().any(|sides| sides.iter().all(|side| side_holds(side, place)))
}

fn side_holds(side: &Side, place: &BigRational) -> bool {
    side.relation.holds(at(&side.form, place).cmp(&BigRational::zero()))
}

fn at(form: &Linear, place: &BigRational) -> BigRational {
    form.state.first().map_or_else(BigRational::zero, |factor| factor * place) + &form.constant
}
