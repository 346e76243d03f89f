//! The greatest expected reward of a finite decision process whose rewards are at least 0: where to stop, or where to go
//! on, is chosen; draws are not. Exact, by improving a way of choosing (Howard 1960) component by component.

use num_rational::BigRational;
use num_traits::{One, Zero};

use crate::elimination::reduced;
use crate::transition_system::{Builder, Label, Mark};

/// A place of a decision process.
#[derive(Clone, Debug)]
pub(super) enum Spot {
    /// Goes on at random.
    Draw(Vec<(BigRational, usize)>),
    /// Stops with this reward, or goes on to one of these.
    Choice(BigRational, Vec<usize>),
}

/// The most places of one component with draws: they are solved for together.
const MOST_TOGETHER: usize = 80;

/// The greatest expected reward from each place; none where too many places lead to each other by draws.
pub(super) fn optimum(spots: &[Spot]) -> Option<Vec<BigRational>> {
    let mut value = vec![BigRational::zero(); spots.len()];
    for members in components(spots) {
        let cyclic = members.len() > 1 || targets(&spots[members[0]]).contains(&members[0]);
        if !cyclic {
            value[members[0]] = once(&spots[members[0]], &value);
        } else if members.iter().all(|place| matches!(spots[*place], Spot::Choice(..))) {
            let best = members.iter().map(|place| once(&spots[*place], &value)).max().unwrap_or_default();
            members.iter().for_each(|place| value[*place] = best.clone());
        } else if members.len() <= MOST_TOGETHER {
            improved(spots, &members, &mut value)?;
        } else {
            return None;
        }
    }
    Some(value)
}

fn targets(spot: &Spot) -> Vec<usize> {
    match spot {
        Spot::Draw(outcomes) => outcomes.iter().map(|(_, to)| *to).collect(),
        Spot::Choice(_, next) => next.clone(),
    }
}

/// What the place is worth when what it leads to is worth this.
pub(super) fn once(spot: &Spot, value: &[BigRational]) -> BigRational {
    match spot {
        Spot::Draw(outcomes) => outcomes.iter().map(|(chance, to)| chance * &value[*to]).sum(),
        Spot::Choice(reward, next) => {
            next.iter().map(|to| &value[*to]).max().map_or_else(|| reward.clone(), |most| most.max(reward).clone())
        }
    }
}

/// The places that lead to each other, those first that lead to no other.
fn components(spots: &[Spot]) -> Vec<Vec<usize>> {
    let mut builder = Builder::new();
    spots.iter().for_each(|_| {
        builder.state(Mark::plain());
    });
    let tau = builder.label(Label::Tau);
    for (place, spot) in spots.iter().enumerate() {
        targets(spot).into_iter().for_each(|to| builder.transition(place as u32, tau, to as u32));
    }
    let of = builder.finish(0, None).components().of;
    let mut all: Vec<Vec<usize>> = vec![Vec::new(); of.iter().max().map_or(0, |most| *most as usize + 1)];
    (0..spots.len()).for_each(|place| all[of[place] as usize].push(place));
    all.retain(|members| !members.is_empty());
    all
}

/// Begins with stopping everywhere and changes a choice only for something strictly better, so that it always stops.
fn improved(spots: &[Spot], members: &[usize], value: &mut [BigRational]) -> Option<()> {
    let own = |place: &usize| members.binary_search(place).ok();
    // What stopping or leaving gives at once.
    let leave: Vec<BigRational> = members
        .iter()
        .map(|place| match &spots[*place] {
            Spot::Draw(_) => BigRational::zero(),
            Spot::Choice(reward, next) => {
                let outside = next.iter().filter(|to| own(to).is_none()).map(|to| &value[*to]);
                outside.chain([reward]).max().cloned().unwrap_or_default()
            }
        })
        .collect();
    let mut chosen: Vec<Option<usize>> = vec![None; members.len()];
    loop {
        let now = solved(spots, members, &chosen, &leave, value)?;
        let mut better = false;
        for (at, place) in members.iter().enumerate() {
            let Spot::Choice(_, next) = &spots[*place] else { continue };
            let best = next.iter().filter_map(own).max_by_key(|to| &now[*to]);
            if let Some(best) = best.filter(|best| now[*best] > now[at]) {
                chosen[at] = Some(best);
                better = true;
            }
        }
        if !better {
            members.iter().zip(now).for_each(|(place, worth)| value[*place] = worth);
            return Some(());
        }
    }
}

/// What the members are worth under these choices: linear equations, solved by elimination.
fn solved(
    spots: &[Spot],
    members: &[usize],
    chosen: &[Option<usize>],
    leave: &[BigRational],
    value: &[BigRational],
) -> Option<Vec<BigRational>> {
    let count = members.len();
    let mut rows = vec![vec![BigRational::zero(); count + 1]; count];
    for (at, place) in members.iter().enumerate() {
        rows[at][at] = BigRational::one();
        match (&spots[*place], chosen[at]) {
            (Spot::Draw(outcomes), _) => {
                for (chance, to) in outcomes {
                    match members.binary_search(to) {
                        Ok(to) => rows[at][to] -= chance,
                        Err(_) => rows[at][count] += chance * &value[*to],
                    }
                }
            }
            (Spot::Choice(..), Some(to)) => rows[at][to] -= BigRational::one(),
            (Spot::Choice(..), None) => rows[at][count] = leave[at].clone(),
        }
    }
    let (rows, pivots) = reduced(rows, count);
    (pivots.len() == count).then(|| rows.into_iter().map(|row| row[count].clone()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn share(part: i64, whole: i64) -> BigRational {
        BigRational::new(part.into(), whole.into())
    }

    #[test]
    fn trying_again_and_again_arrives() {
        // 0 tries: with 1/3 it is back, with 1/3 it has won, with 1/3 it has lost half.
        let spots = [
            Spot::Choice(share(0, 1), vec![1]),
            Spot::Draw(vec![(share(1, 3), 0), (share(1, 3), 2), (share(1, 3), 3)]),
            Spot::Choice(share(1, 1), vec![]),
            Spot::Choice(share(1, 2), vec![]),
        ];
        assert_eq!(optimum(&spots), Some(vec![share(3, 4), share(3, 4), share(1, 1), share(1, 2)]));
    }

    #[test]
    fn going_round_for_ever_is_worth_nothing() {
        let spots = [Spot::Choice(share(0, 1), vec![1]), Spot::Choice(share(0, 1), vec![0])];
        assert_eq!(optimum(&spots), Some(vec![share(0, 1), share(0, 1)]));
    }
}
