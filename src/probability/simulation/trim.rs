//! A chain without numbers of the state on which nothing depends.

use num_rational::BigRational;
use num_traits::Zero;

use crate::probability::chain::{Chain, Linear, Move};

/// The same chain for what is shown, with as few numbers in the state of each phase as that takes.
pub(super) fn trimmed(chain: &Chain) -> Chain {
    let kept = kept(chain);
    let from = |phase: Option<usize>| phase.map(|phase| kept[phase].as_slice()).unwrap_or_default();
    let moves = |moves: &[Move], phase: Option<usize>| -> Vec<Move> {
        let trim = |one: &Move| {
            let mut one = one.clone();
            let mut image = std::mem::take(&mut one.image);
            one.image = from(one.next).iter().filter_map(|place| image.get_mut(*place).map(std::mem::take)).collect();
            let shown = one.stretches.iter_mut().flat_map(|stretch| stretch.shown.iter_mut().flatten());
            let forms = one.tests.iter_mut().chain(shown).map(|side| &mut side.form).chain(&mut one.image);
            forms.for_each(|form| only(form, from(phase)));
            one
        };
        moves.iter().map(trim).collect()
    };
    let phases = chain.phases.iter().enumerate();
    let phases = phases.map(|(phase, all)| moves(all, Some(phase))).collect();
    Chain { initial: moves(&chain.initial, None), phases, variables: Vec::new() }
}

/// A form over some of the numbers of a state.
fn only(form: &mut Linear, kept: &[usize]) {
    let factor = |place: &usize| form.state.get(*place).cloned().unwrap_or_default();
    form.state = kept.iter().map(factor).collect::<Vec<BigRational>>();
}

/// The numbers of each phase that decide something, at once or through others.
fn kept(chain: &Chain) -> Vec<Vec<usize>> {
    let mut kept: Vec<Vec<usize>> = vec![Vec::new(); chain.phases.len()];
    loop {
        let mut more = false;
        for (phase, one) in
            chain.phases.iter().enumerate().flat_map(|(phase, all)| all.iter().map(move |one| (phase, one)))
        {
            let shown = one.stretches.iter().flat_map(|stretch| stretch.shown.iter().flatten());
            let wanted = one.next.map(|next| kept[next].clone()).unwrap_or_default();
            let image = wanted.iter().filter_map(|place| one.image.get(*place));
            for form in one.tests.iter().chain(shown).map(|side| &side.form).chain(image) {
                for (place, _) in form.state.iter().enumerate().filter(|(_, factor)| !factor.is_zero()) {
                    if let Err(at) = kept[phase].binary_search(&place) {
                        kept[phase].insert(at, place);
                        more = true;
                    }
                }
            }
        }
        if !more {
            return kept;
        }
    }
}
