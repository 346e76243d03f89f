//! Simulation, refinement, traces and weak bisimilarity of systems that draw at random, against naive definitions.

use std::collections::BTreeMap;

use num_rational::BigRational;
use num_traits::ToPrimitive;
use pars::equivalence::{Difference, Preorder, Verdict, compare};
use pars::transition_system::{Bounds, Builder, Label, Mark, TransitionSystem, aut};

/// A small generator; the same on every machine.
struct Dice(u64);

impl Dice {
    fn roll(&mut self, sides: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % sides
    }

    /// Another seed may be given, to try more.
    fn new(seed: u64) -> Dice {
        let seed = std::env::var("PARS_SEED").ok().and_then(|text| text.parse().ok()).unwrap_or(seed);
        println!("seed {seed}");
        Dice(seed)
    }
}

fn share(part: u64, whole: u64) -> BigRational {
    BigRational::new(part.into(), whole.into())
}

/// Some states draw one of a few others, which do not.
fn drawing(dice: &mut Dice, labels: &[Label]) -> TransitionSystem {
    let mut builder = Builder::new();
    let (acts, draws) = (2 + dice.roll(3), 1 + dice.roll(3));
    for _ in 0..acts + draws {
        let mut mark = Mark::plain();
        if dice.roll(6) == 0 {
            mark.shown.insert("A".to_string());
        }
        builder.state(mark);
    }
    let labels: Vec<u32> = labels.iter().map(|label| builder.label(label.clone())).collect();
    for _ in 0..1 + dice.roll(2 * acts + 3) {
        let (from, to) = (dice.roll(acts) as u32, dice.roll(acts + draws) as u32);
        builder.transition(from, labels[dice.roll(labels.len() as u64) as usize], to);
    }
    for state in acts..acts + draws {
        let whole = 2 + dice.roll(3);
        let mut parts = BTreeMap::new();
        for _ in 0..whole {
            *parts.entry(dice.roll(acts) as u32).or_insert(0) += 1;
        }
        for (to, part) in parts {
            let label = builder.label(Label::Chance(share(part, whole)));
            builder.transition(state as u32, label, to);
        }
    }
    builder.finish(if dice.roll(2) == 0 { acts as u32 } else { 0 }, None)
}

fn two(dice: &mut Dice, labels: &[Label]) -> (TransitionSystem, TransitionSystem) {
    let left = drawing(dice, labels);
    let right = if dice.roll(2) == 0 {
        left.clone().begun_at(dice.roll(left.states() as u64) as u32)
    } else {
        drawing(dice, labels)
    };
    (left, right)
}

fn acts() -> Vec<Label> {
    ["a", "b"].map(|text| Label::Act(text.into())).to_vec()
}

fn outcomes(system: &TransitionSystem, state: u32) -> Vec<(BigRational, u32)> {
    let found: Vec<_> = system.chances(state).into_iter().map(|(chance, to)| (chance.clone(), to)).collect();
    if found.is_empty() { vec![(share(1, 1), state)] } else { found }
}

fn draws(system: &TransitionSystem, state: u32) -> bool {
    !system.chances(state).is_empty()
}

/// Whether no outcomes are likelier than all that they are related to: every set of them is tried.
fn coupled(system: &TransitionSystem, related: &[Vec<bool>], one: u32, two: u32) -> bool {
    let (left, right) = (outcomes(system, one), outcomes(system, two));
    (0..1u32 << left.len()).all(|set| {
        let within = |at: usize| set >> at & 1 == 1;
        let mine: BigRational = (0..left.len()).filter(|at| within(*at)).map(|at| left[at].0.clone()).sum();
        let reached = |to: u32| (0..left.len()).any(|at| within(at) && related[left[at].1 as usize][to as usize]);
        let theirs: BigRational = right.iter().filter(|(_, to)| reached(*to)).map(|(chance, _)| chance.clone()).sum();
        mine <= theirs
    })
}

/// The greatest relation in which steps are answered with outcomes that can be coupled.
fn below(system: &TransitionSystem, one: u32, two: u32, refines: bool) -> bool {
    let count = system.states() as u32;
    let mut related = vec![vec![true; count as usize]; count as usize];
    loop {
        let mut next = related.clone();
        for left in (0..count).filter(|state| !draws(system, *state)) {
            for right in (0..count).filter(|state| !draws(system, *state)) {
                let (mine, theirs) = (system.mark(left), system.mark(right));
                let looks = if refines { theirs.shown.is_subset(&mine.shown) } else { mine == theirs };
                let forth = system.steps(left).iter().all(|(label, to)| {
                    system.after(right, *label).iter().any(|(_, answer)| coupled(system, &related, *to, *answer))
                });
                let back = system.steps(right).iter().all(|(label, to)| {
                    system.after(left, *label).iter().any(|(_, answer)| coupled(system, &related, *answer, *to))
                });
                next[left as usize][right as usize] &= looks && forth && (back || !refines);
            }
        }
        if next == related {
            return coupled(system, &related, one, two);
        }
        related = next;
    }
}

#[test]
fn simulation_and_refinement_couple_the_outcomes() {
    let mut dice = Dice::new(19_910_101);
    let mut counts = [[0; 3]; 2];
    for round in 0..2_500 {
        let (left, right) = two(&mut dice, &acts());
        let (union, second) = left.union(&right);
        let said = format!("round {round}:\n{}\n{}", aut::write(&left), aut::write(&right));
        for (kind, relation) in [Preorder::Simulation, Preorder::Refinement].into_iter().enumerate() {
            let wanted = below(&union, union.initial(), second, kind == 1);
            match compare(&left, &right, relation, &Bounds::default(), &|| false) {
                Verdict::Yes => assert!(wanted, "{said}"),
                Verdict::No(evidence) => {
                    assert!(!wanted, "{said}");
                    counts[kind][2] += usize::from(matches!(evidence.difference, Difference::Chances(..)));
                }
                Verdict::Unknown(why) => panic!("{why}: {said}"),
            }
            counts[kind][usize::from(wanted)] += 1;
        }
        let both = below(&union, union.initial(), second, false) && below(&union, second, union.initial(), false);
        let found = compare(&left, &right, Preorder::SimulationEquivalence, &Bounds::default(), &|| false);
        assert_eq!(matches!(found, Verdict::Yes), both, "{said}");
        assert!(!matches!(found, Verdict::Unknown(_)), "{said}");
    }
    println!("{counts:?}");
    assert!(counts.iter().flatten().all(|count| *count > 100), "{counts:?}");
}

/// The greatest chance to follow this word of labels and looks, by trying every step.
fn follow(system: &TransitionSystem, state: u32, look: u32, word: &[(u32, u32)]) -> BigRational {
    let from = |state: u32| {
        if system.mark_number(state) != look {
            return BigRational::default();
        }
        let Some(((label, next), rest)) = word.split_first() else { return share(1, 1) };
        let after = system.after(state, *label).iter().map(|(_, to)| follow(system, *to, *next, rest));
        after.max().unwrap_or_default()
    };
    outcomes(system, state).into_iter().map(|(chance, to)| chance * from(to)).sum()
}

/// Whether all words of at most so many steps have the same chances.
fn same_chances(system: &TransitionSystem, one: u32, two: u32, longest: usize) -> bool {
    let marks: Vec<u32> = (0..system.marks().len() as u32).collect();
    let labels: Vec<u32> =
        (0..system.labels().len() as u32).filter(|label| !matches!(system.label(*label), Label::Chance(_))).collect();
    let mut words: Vec<Vec<(u32, u32)>> = vec![Vec::new()];
    for _ in 0..=longest {
        let differs = |word: &Vec<(u32, u32)>| {
            marks.iter().any(|look| follow(system, one, *look, word) != follow(system, two, *look, word))
        };
        if words.iter().any(differs) {
            return false;
        }
        let longer = |word: &Vec<(u32, u32)>| {
            let more = labels.iter().flat_map(|label| marks.iter().map(move |mark| (*label, *mark)));
            more.map(|step| word.iter().copied().chain([step]).collect()).collect::<Vec<Vec<(u32, u32)>>>()
        };
        let possible = |word: &Vec<(u32, u32)>| {
            marks.iter().any(|look| follow(system, one, *look, word) != BigRational::default())
        };
        words = words.iter().flat_map(longer).filter(possible).collect();
    }
    true
}

#[test]
fn traces_have_greatest_chances() {
    let mut dice = Dice::new(19_920_401);
    let mut counts = [0; 4];
    for round in 0..1_500 {
        let (left, right) = two(&mut dice, &acts());
        let (union, second) = left.union(&right);
        let said = format!("round {round}:\n{}\n{}", aut::write(&left), aut::write(&right));
        match compare(&left, &right, Preorder::Trace, &Bounds::default(), &|| false) {
            Verdict::Yes => {
                assert!(same_chances(&union, union.initial(), second, 4), "{said}");
                counts[0] += 1;
                let strong = compare(&left, &right, Preorder::Strong, &Bounds::default(), &|| false);
                counts[3] += usize::from(matches!(strong, Verdict::No(_)));
            }
            Verdict::No(evidence) => {
                if let Difference::Best(_, one, two) = &evidence.difference {
                    assert_ne!(one, two, "{said}");
                    counts[1] += 1;
                }
                let strong = compare(&left, &right, Preorder::Strong, &Bounds::default(), &|| false);
                assert!(matches!(strong, Verdict::No(_)), "{said}");
            }
            // Chances multiply round a cycle, and steps are a choice.
            Verdict::Unknown(_) => {
                assert!(same_chances(&union, union.initial(), second, 3), "{said}");
                counts[2] += 1;
            }
        }
    }
    println!("{counts:?}");
    assert!(counts[0] > 200 && counts[1] > 200 && counts[2] < 400, "{counts:?}");
}

/// To draw before a step or behind it gives the traces the same chances, and is not bisimilar.
#[test]
fn a_trace_does_not_say_when_a_draw_was_made() {
    let coin = |first: bool| {
        let mut builder = Builder::new();
        (0..8).for_each(|_| {
            builder.state(Mark::plain());
        });
        let labels = [acts()[0].clone(), acts()[1].clone(), Label::Act("c".into()), Label::Chance(share(1, 2))];
        let [a, b, c, half] = labels.map(|label| builder.label(label));
        let steps = if first {
            vec![(0, half, 1), (0, half, 2), (1, a, 3), (2, a, 4), (3, b, 5), (4, c, 5)]
        } else {
            vec![(0, a, 1), (1, half, 3), (1, half, 4), (3, b, 5), (4, c, 5)]
        };
        steps.into_iter().for_each(|(from, label, to)| builder.transition(from, label, to));
        builder.finish(0, None)
    };
    let (before, behind) = (coin(true), coin(false));
    let is = |left: &TransitionSystem, right: &TransitionSystem, relation| {
        matches!(compare(left, right, relation, &Bounds::default(), &|| false), Verdict::Yes)
    };
    for relation in [Preorder::Trace, Preorder::WeakTrace] {
        assert!(is(&before, &behind, relation), "{}", relation.name());
    }
    for relation in [Preorder::Strong, Preorder::Weak, Preorder::Refinement, Preorder::Branching] {
        assert!(!is(&before, &behind, relation), "{}", relation.name());
    }
}

/// The greatest chances, nearly: as many internal steps as it takes, each round one more.
fn nearly(system: &TransitionSystem, label: Option<u32>, wanted: &dyn Fn(u32) -> bool) -> Vec<f64> {
    let number = |chance: &BigRational| chance.to_f64().expect("a number");
    let spread: Vec<Vec<(f64, u32)>> = (0..system.states() as u32)
        .map(|state| outcomes(system, state).iter().map(|(chance, to)| (number(chance), *to)).collect())
        .collect();
    let drawing: Vec<bool> = (0..system.states() as u32).map(|state| draws(system, state)).collect();
    let tau = system.label_number(&Label::Tau);
    let count = system.states() as u32;
    let close = |reward: Vec<f64>| {
        let mut value = vec![0.0f64; count as usize];
        for _ in 0..5_000 {
            let of = |state: u32| -> f64 {
                let best = |state: u32| {
                    let next = tau.map_or(&[][..], |tau| system.after(state, tau));
                    next.iter().map(|(_, to)| value[*to as usize]).fold(reward[state as usize], f64::max)
                };
                if drawing[state as usize] {
                    spread[state as usize].iter().map(|(chance, to)| chance * value[*to as usize]).sum()
                } else {
                    best(state)
                }
            };
            let next: Vec<f64> = (0..count).map(of).collect();
            if next.iter().zip(&value).all(|(one, two)| (one - two).abs() < 1e-12) {
                break;
            }
            value = next;
        }
        value
    };
    let there = |state: u32| if !drawing[state as usize] && wanted(state) { 1.0 } else { 0.0 };
    let behind = close((0..count).map(there).collect());
    let Some(label) = label else { return behind };
    let step = |state: u32| {
        let next = system.after(state, label).iter().map(|(_, to)| behind[*to as usize]);
        if drawing[state as usize] { 0.0 } else { next.fold(0.0, f64::max) }
    };
    close((0..count).map(step).collect())
}

/// Classes are parted as long as a set of them is reached with different greatest chances; all sets are tried.
fn weakly(system: &TransitionSystem, one: u32, two: u32) -> bool {
    let labels: Vec<Option<u32>> = (0..system.labels().len() as u32)
        .filter(|label| !matches!(system.label(*label), Label::Chance(_) | Label::Tau))
        .map(Some)
        .chain([None])
        .collect();
    let mut class = vec![0u32; system.states()];
    loop {
        let count = class.iter().max().map_or(1, |most| most + 1);
        let mut all: Vec<Vec<f64>> = Vec::new();
        for set in 1..1u32 << count {
            for label in &labels {
                all.push(nearly(system, *label, &|state| set >> class[state as usize] & 1 == 1));
            }
        }
        let same = |one: u32, two: u32| all.iter().all(|of| (of[one as usize] - of[two as usize]).abs() < 1e-7);
        let plain: Vec<u32> = (0..system.states() as u32).filter(|state| !draws(system, *state)).collect();
        let mut next = class.clone();
        let mut members: Vec<u32> = Vec::new();
        for state in &plain {
            let alike = |other: &u32| class[*other as usize] == class[*state as usize] && same(*other, *state);
            let place = members.iter().position(alike).unwrap_or(members.len());
            if place == members.len() {
                members.push(*state);
            }
            next[*state as usize] = place as u32;
        }
        if members.len() as u32 == count || next == class {
            return same(one, two);
        }
        class = next;
    }
}

#[test]
fn weak_bisimilarity_compares_greatest_chances() {
    let mut dice = Dice::new(20_100_901);
    let mut labels = acts();
    labels.extend([Label::Tau, Label::Tau]);
    let mut counts = [0; 4];
    for round in 0..700 {
        let (left, right) = two(&mut dice, &labels);
        // Nothing is shown, so that labels tell all.
        let strip = |system: TransitionSystem| {
            let mut builder = Builder::new();
            (0..system.states()).for_each(|_| {
                builder.state(Mark::plain());
            });
            let labels: Vec<u32> = system.labels().iter().map(|label| builder.label(label.clone())).collect();
            for state in 0..system.states() as u32 {
                let steps = system.steps(state).iter();
                steps.for_each(|(label, to)| builder.transition(state, labels[*label as usize], *to));
            }
            builder.finish(system.initial(), None)
        };
        let (left, right) = (strip(left), strip(right));
        let (union, second) = left.union(&right);
        let said = format!("round {round}:\n{}\n{}", aut::write(&left), aut::write(&right));
        let wanted = weakly(&union, union.initial(), second);
        let strong = compare(&left, &right, Preorder::Strong, &Bounds::default(), &|| false);
        match compare(&left, &right, Preorder::Weak, &Bounds::default(), &|| false) {
            Verdict::Yes => {
                assert!(wanted, "{said}");
                counts[0] += 1;
                counts[3] += usize::from(matches!(strong, Verdict::No(_)));
            }
            Verdict::No(_) => {
                assert!(!wanted, "{said}");
                counts[1] += 1;
            }
            Verdict::Unknown(why) => {
                println!("{why}");
                counts[2] += 1;
            }
        }
    }
    println!("{counts:?}");
    assert!(counts[0] > 100 && counts[1] > 100 && counts[2] < 20 && counts[3] > 20, "{counts:?}");
}
