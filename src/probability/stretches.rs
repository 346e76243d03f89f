//! Rounds in which time passes several times, as rounds one behind the other.

use num_rational::BigRational;
use num_traits::{One, Zero};

use super::chain::{Chain, Linear, Move, Side, Stretch};

/// Phases that are made.
const MOST_MADE: usize = 64;

/// The chain with one stretch of time in each round, where all last equally long; none where it is so already, or cannot
/// be so.
pub(super) fn one_each(chain: &Chain) -> Option<Chain> {
    let moves = || chain.initial.iter().chain(chain.phases.iter().flatten());
    let timed = |one: &Move| one.stretches.iter().filter_map(|stretch| stretch.duration.clone()).collect::<Vec<_>>();
    let mut all = moves().flat_map(timed);
    let first = all.next()?;
    if all.any(|other| other != first) || !chain.phases.iter().flatten().any(|one| timed(one).len() > 1) {
        return None;
    }
    let mut whole = chain.clone();
    let mut phase = 0;
    while phase < whole.phases.len() {
        for place in 0..whole.phases[phase].len() {
            if timed(&whole.phases[phase][place]).len() < 2 {
                continue;
            }
            let next = whole.phases.len();
            if next > chain.phases.len() + MOST_MADE {
                return None;
            }
            let later = cut(&mut whole.phases[phase][place], next);
            whole.phases.push(vec![later]);
        }
        phase += 1;
    }
    Some(whole)
}

/// Cuts a move behind its first stretch; what is left of it leads from a phase of that number, whose state is that of the
/// move with all that it draws.
fn cut(one: &mut Move, next: usize) -> Move {
    let tests = one.tests.iter().flat_map(Side::forms);
    let shown = one.stretches.iter().flat_map(|stretch| stretch.shown.iter().flatten()).flat_map(Side::forms);
    let values = one.stretches.iter().flat_map(|stretch| &stretch.values);
    let forms = tests.chain(shown).chain(values).chain(&one.image);
    let width = forms.map(|form| form.state.len()).max().unwrap_or_default();
    let (zeros, count) = (vec![BigRational::zero(); width], one.draws.len());
    let moved = |form: &Linear| {
        let mut state = form.state.clone();
        state.resize(width, BigRational::zero());
        state.extend(form.draws.iter().cloned());
        state.resize(width + count, BigRational::zero());
        Linear { state, draws: Vec::new(), constant: form.constant.clone() }
    };
    let later = |stretch: Stretch| Stretch {
        shown: stretch.shown.iter().map(|sides| sides.iter().map(|side| side.with(moved)).collect()).collect(),
        values: stretch.values.iter().map(moved).collect(),
        ..stretch
    };
    let rest = one.stretches.split_off(1).into_iter().map(later).collect();
    let image = one.image.iter().map(moved).collect();
    let behind = Move { draws: Vec::new(), tests: Vec::new(), stretches: rest, image, next: one.next };
    let unit = |place: usize, length: usize| -> Vec<BigRational> {
        (0..length).map(|other| if other == place { BigRational::one() } else { BigRational::zero() }).collect()
    };
    let of_state = |place| Linear { state: unit(place, width), ..Linear::default() };
    let of_draw = |place| Linear { state: zeros.clone(), draws: unit(place, count), ..Linear::default() };
    one.image = (0..width).map(of_state).chain((0..count).map(of_draw)).collect();
    one.next = Some(next);
    behind
}
