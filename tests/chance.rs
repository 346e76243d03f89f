//! Draws and shortest runs of transition systems, against naive definitions on random systems.

use num_rational::BigRational;
use pars::equivalence::{Difference, Preorder, Verdict, compare};
use pars::transition_system::{Bounds, Builder, Label, Mark, TransitionSystem, aut};

mod naive;

mod dice;
use dice::Dice;

fn share(part: u64, whole: u64) -> BigRational {
    BigRational::new(part.into(), whole.into())
}

/// Some states draw one of two or three others, which do not.
fn drawing(dice: &mut Dice) -> TransitionSystem {
    let mut builder = Builder::new();
    let (acts, draws) = (2 + dice.roll(4), dice.roll(4));
    for _ in 0..acts + draws {
        let mut mark = Mark::plain();
        if dice.roll(8) == 0 {
            mark.shown.insert("A".to_string());
        }
        builder.state(mark);
    }
    let labels = ["a", "b"].map(|label| builder.label(Label::Act(label.into())));
    for _ in 0..dice.roll(2 * acts + 3) {
        let (from, to) = (dice.roll(acts) as u32, dice.roll(acts + draws) as u32);
        builder.transition(from, labels[dice.roll(2) as usize], to);
    }
    for state in acts..acts + draws {
        let whole = 2 + dice.roll(3);
        let mut parts = std::collections::BTreeMap::new();
        for _ in 0..whole {
            *parts.entry(dice.roll(acts) as u32).or_insert(0) += 1;
        }
        for (to, part) in parts {
            let label = builder.label(Label::Chance(share(part, whole)));
            builder.transition(state as u32, label, to);
        }
    }
    builder.finish(if draws > 0 && dice.roll(2) == 0 { acts as u32 } else { 0 }, None)
}

/// By the definition: the greatest relation in which steps are answered, and draws give each class the same chance.
fn alike(system: &TransitionSystem, one: u32, two: u32) -> bool {
    let count = system.states();
    let outcomes = |state: u32| -> Vec<(BigRational, u32)> {
        let found: Vec<_> = system.chances(state).into_iter().map(|(chance, to)| (chance.clone(), to)).collect();
        if found.is_empty() { vec![(share(1, 1), state)] } else { found }
    };
    let mut related = vec![vec![true; count]; count];
    let lifted = |related: &Vec<Vec<bool>>, one: u32, two: u32| {
        (0..count).all(|class| {
            let sum = |state: u32| -> BigRational {
                outcomes(state)
                    .into_iter()
                    .filter(|(_, to)| related[class][*to as usize])
                    .map(|(chance, _)| chance)
                    .sum()
            };
            sum(one) == sum(two)
        })
    };
    loop {
        let mut next = related.clone();
        for left in 0..count as u32 {
            for right in 0..count as u32 {
                let answers = |mover: u32, other: u32| {
                    system.steps(mover).iter().all(|(label, to)| {
                        system.after(other, *label).iter().any(|(_, answer)| lifted(&related, *to, *answer))
                    })
                };
                let draws = |state: u32| !system.chances(state).is_empty();
                // Of states that draw only the outcomes count.
                next[left as usize][right as usize] = related[left as usize][right as usize]
                    && !draws(left)
                    && !draws(right)
                    && system.mark(left) == system.mark(right)
                    && answers(left, right)
                    && answers(right, left);
            }
        }
        if next == related {
            return lifted(&related, one, two);
        }
        related = next;
    }
}

#[test]
fn draws_are_compared_by_the_chances_of_classes() {
    let seed = 19_910_628;
    println!("seed {seed}");
    let mut dice = Dice(seed);
    let mut counts = [0; 3];
    for round in 0..3_000 {
        let (left, right) = (drawing(&mut dice), drawing(&mut dice));
        // One after the other in one system, so that many are alike.
        let right =
            if dice.roll(2) == 0 { left.clone().begun_at(dice.roll(left.states() as u64) as u32) } else { right };
        let (union, second) = left.union(&right);
        let wanted = alike(&union, union.initial(), second);
        let said = format!("seed {seed}, round {round}:\n{}\n{}", aut::write(&left), aut::write(&right));
        match compare(&left, &right, Preorder::Strong, &Bounds::default(), &|| false) {
            Verdict::Yes => assert!(wanted, "{said}"),
            Verdict::No(evidence) => {
                assert!(!wanted, "{said}");
                counts[2] += usize::from(matches!(evidence.difference, Difference::Chances(..)));
            }
            Verdict::Unknown(why) => panic!("{why}: {said}"),
        }
        counts[usize::from(wanted)] += 1;
    }
    println!("{counts:?}");
    assert!(counts.iter().all(|count| *count > 200), "{counts:?}");
}

fn silent(dice: &mut Dice) -> TransitionSystem {
    let mut builder = Builder::new();
    let states = 1 + dice.roll(5);
    (0..states).for_each(|_| {
        builder.state(Mark::plain());
    });
    let labels = [Label::Tau, Label::Act("a".into()), Label::Act("b".into())].map(|label| builder.label(label));
    for _ in 0..dice.roll(2 * states + 3) {
        let (from, to) = (dice.roll(states) as u32, dice.roll(states) as u32);
        builder.transition(from, labels[dice.roll(3) as usize], to);
    }
    builder.finish(0, None)
}

/// In how many steps two states of a system without inert steps are told apart, by trying one more again and again.
fn distance(system: &TransitionSystem, one: u32, two: u32) -> Option<usize> {
    let count = system.states();
    let closure = |state: u32| {
        let mut all = vec![state];
        let mut next = 0;
        while next < all.len() {
            for to in system.internal(all[next]) {
                if !all.contains(&to) {
                    all.push(to);
                }
            }
            next += 1;
        }
        all
    };
    let mut apart = vec![vec![false; count]; count];
    for steps in 1..=2 * count * count {
        let lost = |mine: u32, other: u32| apart[mine as usize][other as usize];
        let presses = |mover: u32, other: u32| {
            system.steps(mover).iter().any(|(label, target)| {
                let stays = *system.label(*label) == Label::Tau && !lost(*target, other);
                !stays
                    && closure(other).into_iter().all(|middle| {
                        system.after(middle, *label).iter().all(|(_, to)| lost(mover, middle) || lost(*target, *to))
                    })
            })
        };
        let mut next = apart.clone();
        for left in 0..count as u32 {
            for right in 0..count as u32 {
                next[left as usize][right as usize] |= presses(left, right) || presses(right, left);
            }
        }
        if next[one as usize][two as usize] {
            return Some(steps);
        }
        if next == apart {
            return None;
        }
        apart = next;
    }
    None
}

#[test]
fn the_run_that_tells_apart_what_is_not_branching_bisimilar_is_a_shortest_one() {
    let seed = 19_960_501;
    println!("seed {seed}");
    let mut dice = Dice(seed);
    let mut lengths = [0; 8];
    for round in 0..400 {
        let (left, right) = (silent(&mut dice), silent(&mut dice));
        let Verdict::No(evidence) = compare(&left, &right, Preorder::Branching, &Bounds::default(), &|| false) else {
            continue;
        };
        let (union, second) = left.union(&right);
        let same = |one: u32, two: u32| {
            naive::related(&union.clone().begun_at(one), &union.clone().begun_at(two), Preorder::Branching)
        };
        let mut block: Vec<u32> = Vec::new();
        for state in 0..union.states() as u32 {
            let known = (0..state).find(|other| same(*other, state)).map(|other| block[other as usize]);
            block.push(known.unwrap_or(block.iter().max().map_or(0, |most| most + 1)));
        }
        let quotient = union.quotient(&block, true);
        let wanted = distance(&quotient, block[union.initial() as usize], block[second as usize]);
        let last = usize::from(matches!(evidence.difference, Difference::Step(..)));
        let said = format!("seed {seed}, round {round}:\n{}\n{}", aut::write(&left), aut::write(&right));
        assert_eq!(Some(evidence.run.len() + last), wanted, "{said}");
        lengths[(evidence.run.len() + last).min(7)] += 1;
    }
    println!("{lengths:?}");
    assert!(lengths[1] > 50 && lengths[2] > 20, "{lengths:?}");
}
