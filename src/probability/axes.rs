//! The directions in which a chain lives: all that its rounds need to know of the state is one linear form of it, or
//! two that move independently of each other.
//!
//! Noise that is measured and thrown away leaves states of several variables (position, pending command, pending
//! sample) of which only one combination matters. It is found exactly, with rationals.

use num_rational::BigRational;
use num_traits::{One, Zero};

use super::Question;
use super::chain::{Chain, Linear, Move, Region, Side};
use crate::rational::{product, quotient};

/// How many directions there may be; what is not used costs nothing.
pub const AXES: usize = 2;

/// A linear form of the state, without a constant.
pub type Direction = Vec<BigRational>;

/// The directions of each phase, by their axes; the phases for which a question is settled have none.
#[derive(Clone, Debug)]
pub struct Axes {
    /// By phase and axis.
    pub directions: Vec<[Option<Direction>; AXES]>,
    /// Whether what is asked for is certain, or out of the question, once a phase is reached.
    pub settled: Vec<Option<bool>>,
}

/// `ratio` with `other = ratio * direction`, if there is one that is not 0.
pub fn ratio(direction: &[BigRational], other: &[BigRational]) -> Option<BigRational> {
    let zero = BigRational::zero();
    let place = direction.iter().position(|factor| !factor.is_zero())?;
    let ratio = quotient(other.get(place)?, &direction[place]);
    let mut places = 0..direction.len().max(other.len());
    let fits = |place: usize| {
        let (one, other) = (direction.get(place).unwrap_or(&zero), other.get(place).unwrap_or(&zero));
        if one.is_zero() || other.is_zero() { one.is_zero() == other.is_zero() } else { product(one, &ratio) == *other }
    };
    (!ratio.is_zero() && places.all(fits)).then_some(ratio)
}

/// Whether a form does not depend on the state.
pub fn stateless(form: &Linear) -> bool {
    form.state.iter().all(Zero::is_zero)
}

/// The directions of a chain.
///
/// # Errors
/// Where there are more, or they do not fit together.
pub fn axes(chain: &Chain, question: &Question) -> Result<Axes, String> {
    let settled: Vec<Option<bool>> = (0..chain.phases.len()).map(|phase| settled(chain, question, phase)).collect();
    let live = |phase: usize| settled.get(phase).is_some_and(Option::is_none);
    let mut found: Vec<Vec<Direction>> = vec![Vec::new(); chain.phases.len()];
    let mut work: Vec<(usize, Direction)> = Vec::new();
    for (phase, moves) in chain.phases.iter().enumerate().filter(|(phase, _)| live(*phase)) {
        let forms = moves.iter().flat_map(|one| &one.tests).flat_map(Side::forms);
        work.extend(forms.map(|form| (phase, form.state.clone())));
        // What is shown in a phase is looked at on the way into it.
        let shown = shown(chain, phase)?;
        for (from, one) in moves_into(chain, phase).filter(|(from, _)| live(*from)) {
            let forms = shown.iter().flatten().flat_map(Side::forms);
            work.extend(forms.map(|form| (from, before(&form.state, one).state)));
        }
    }
    let mut links: Vec<((usize, usize), (usize, usize))> = Vec::new();
    // What a direction was before each move into its phase is a direction there.
    while let Some((phase, state)) = work.pop() {
        if state.iter().all(Zero::is_zero) || place_of(&found[phase], &state).is_some() {
            continue;
        }
        found[phase].push(state.clone());
        if found[phase].len() > AXES {
            return Err("the rounds depend on the state in more than two dimensions".to_string());
        }
        for (from, one) in moves_into(chain, phase).filter(|(from, _)| live(*from)) {
            work.push((from, before(&state, one).state));
        }
    }
    for phase in 0..chain.phases.len() {
        for (number, state) in found[phase].iter().enumerate() {
            for (from, one) in moves_into(chain, phase).filter(|(from, _)| live(*from)) {
                if let Some(place) = place_of(&found[from], &before(state, one).state) {
                    links.push(((from, place), (phase, number)));
                }
            }
        }
    }
    // Where nothing is drawn, every state is known, and its combinations may run into one.
    let directions = if random(chain) { labelled(found, &links)? } else { labelled(found, &[])? };
    Ok(Axes { directions, settled })
}

/// Whether anything is drawn.
pub(super) fn random(chain: &Chain) -> bool {
    chain.initial.iter().chain(chain.phases.iter().flatten()).any(|one| !one.draws.is_empty())
}

fn place_of(directions: &[Direction], state: &[BigRational]) -> Option<usize> {
    directions.iter().position(|direction| ratio(direction, state).is_some())
}

pub(super) fn before(direction: &[BigRational], one: &Move) -> Linear {
    Linear { state: direction.to_vec(), ..Linear::default() }.after(&one.image)
}

pub(super) fn moves_into(chain: &Chain, phase: usize) -> impl Iterator<Item = (usize, &Move)> {
    let all = chain.phases.iter().enumerate();
    all.flat_map(move |(from, moves)| {
        moves.iter().filter(move |one| one.next == Some(phase)).map(move |one| (from, one))
    })
}

type Place = (usize, usize);

/// Gives the directions that follow from one another the same axis, and two of one phase different ones.
fn labelled(found: Vec<Vec<Direction>>, links: &[(Place, Place)]) -> Result<Vec<[Option<Direction>; AXES]>, String> {
    let mut axis: Vec<Vec<Option<usize>>> = found.iter().map(|all| vec![None; all.len()]).collect();
    for phase in 0..found.len() {
        for number in 0..found[phase].len() {
            if axis[phase][number].is_some() {
                continue;
            }
            let label = (0..AXES).find(|label| !axis[phase].contains(&Some(*label)));
            let label = label.ok_or("the rounds depend on the state in more than two dimensions")?;
            let mut work = vec![(phase, number)];
            while let Some(place) = work.pop() {
                let other = axis[place.0].iter().position(|other| *other == Some(label));
                if other.is_some_and(|other| other != place.1) {
                    return Err("two combinations of the state run into one".to_string());
                }
                if axis[place.0][place.1].replace(label).is_none() {
                    let ends = links.iter().filter(|(one, other)| *one == place || *other == place);
                    work.extend(ends.map(|(one, other)| if *one == place { *other } else { *one }));
                }
            }
        }
    }
    let place = |(states, labels): (Vec<Direction>, Vec<Option<usize>>)| {
        let mut row: [Option<Direction>; AXES] = [None, None];
        for (state, label) in states.into_iter().zip(labels) {
            if let Some(entry) = label.and_then(|label| row.get_mut(label)) {
                *entry = Some(normed(state));
            }
        }
        row
    };
    Ok(found.into_iter().zip(axis).map(place).collect())
}

/// With 1 as the first factor that is not 0, so that phases which go on alike have the same numbers.
fn normed(direction: Direction) -> Direction {
    match direction.iter().find(|factor| !factor.is_zero()) {
        Some(first) => direction.iter().map(|factor| quotient(factor, first)).collect(),
        None => direction,
    }
}

/// What is asked for, over the state of a phase as it begins; the same whichever way is taken in it.
///
/// # Errors
/// Where it depends on what is drawn only then.
pub fn shown(chain: &Chain, phase: usize) -> Result<Region, String> {
    let moves = chain.phases.get(phase).ok_or("a phase is missing")?;
    let drawn = "what is shown depends on what is drawn later";
    let regions = moves.iter().map(|one| one.stretches.first().map(|stretch| &stretch.shown));
    let over_states = |region: Option<&Region>| region.map_or(Some(Region::new()), of_state).ok_or(drawn);
    let mut regions = regions.map(over_states).collect::<Result<Vec<Region>, &str>>()?.into_iter();
    let first = regions.next().unwrap_or_default();
    if regions.any(|other| other != first) {
        return Err("what is shown depends on the way that is taken".to_string());
    }
    Ok(first)
}

/// A region over the state alone, however much is drawn on the way; none where it depends on what is drawn.
pub(super) fn of_state(region: &Region) -> Option<Region> {
    let alone = |side: &Side| {
        let plain = side.forms().all(|form| form.draws.iter().all(Zero::is_zero));
        plain.then(|| side.with(|form| Linear { draws: Vec::new(), ..form.clone() }))
    };
    region.iter().map(|sides| sides.iter().map(alone).collect()).collect()
}

/// Whether what is asked for is certain from a phase on, whatever the state, or never shown again.
pub(super) fn settled(chain: &Chain, question: &Question, phase: usize) -> Option<bool> {
    let moves = chain.phases.get(phase)?;
    let surely = |region: &Region| region.iter().any(Vec::is_empty);
    let certain = |one: &Move| {
        let lasts = one.next.is_none() && one.stretches.last().is_some_and(|last| last.duration.is_none());
        let all = one.stretches.iter().all(|stretch| surely(&stretch.shown));
        let first = question.first && one.stretches.first().is_some_and(|first| surely(&first.shown));
        first || (lasts && all)
    };
    if !moves.is_empty() && moves.iter().all(certain) {
        return Some(true);
    }
    let nothing = |one: &Move| one.next.is_none() && one.stretches.iter().all(|stretch| stretch.shown.is_empty());
    moves.iter().all(nothing).then_some(false)
}

/// A weight, and a mean and a variance for each draw.
pub type Combination = (BigRational, Vec<(BigRational, BigRational)>);

/// Each combination of the normal parts of what a move draws: its weight, and means and variances.
///
/// # Errors
/// Where something else is drawn, or there are too many.
pub fn combinations(one: &Move) -> Result<Vec<Combination>, String> {
    let mut parts = vec![(BigRational::one(), Vec::new())];
    for draw in &one.draws {
        let normals = draw.normals().ok_or("what is drawn is neither normal nor a mixture of normals")?;
        let mut longer = Vec::new();
        for (weight, drawn) in &parts {
            for (share, mean, variance) in &normals {
                let mut drawn: Vec<(BigRational, BigRational)> = drawn.clone();
                drawn.push((mean.clone(), variance.clone()));
                longer.push((weight * share, drawn));
            }
        }
        parts = longer;
        if parts.len() > 64 {
            return Err("a round has too many combinations of draws".to_string());
        }
    }
    Ok(parts)
}
