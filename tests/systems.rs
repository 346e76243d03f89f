//! Transition systems: published verdicts, hostile files, and agreement with naive definitions on random systems.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use pars::equivalence::{Preorder, Verdict, compare, strong_partition};
use pars::transition_system::{Bounds, Builder, Label, Mark, TransitionSystem, aut};

mod naive;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases/systems")
}

fn load(name: &str) -> TransitionSystem {
    let text = std::fs::read_to_string(folder().join(format!("{name}.aut"))).expect("a system");
    aut::read(&text).unwrap_or_else(|wrong| panic!("{name}: {wrong:?}"))
}

fn verdict(left: &TransitionSystem, right: &TransitionSystem, relation: Preorder) -> bool {
    match compare(left, right, relation, &Bounds::default(), &|| false) {
        Verdict::Yes => true,
        Verdict::No(_) => false,
        Verdict::Unknown(why) => panic!("{}: {why}", relation.name()),
    }
}

#[test]
fn published_verdicts_are_reproduced() {
    let text = std::fs::read_to_string(folder().join("verdicts.txt")).expect("verdicts");
    let mut count = 0;
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let (pair, rest) = line.split_once(':').expect("a colon");
        let (verdicts, _) = rest.split_once('|').expect("a source");
        let names: Vec<&str> = pair.split_whitespace().collect();
        let wanted: Vec<bool> = verdicts.split_whitespace().map(|word| word == "y").collect();
        let (left, right) = (load(names[0]), load(names[1]));
        use Preorder::{Branching, Simulation, SimulationEquivalence, Strong, Trace, Weak, WeakTrace};
        let forward = [Strong, Weak, Branching, Trace, WeakTrace, Simulation].map(|it| verdict(&left, &right, it));
        let back = verdict(&right, &left, Simulation);
        let found: Vec<bool> = forward.into_iter().chain([back]).collect();
        assert_eq!(found, wanted, "{pair}");
        assert_eq!(verdict(&left, &right, SimulationEquivalence), wanted[5] && wanted[6], "{pair}");
        for relation in [Strong, Weak, Branching, Trace, WeakTrace] {
            assert_eq!(verdict(&right, &left, relation), verdict(&left, &right, relation), "{pair}");
        }
        count += 1;
    }
    assert!(count >= 12);
}

#[test]
fn a_difference_is_shown_by_a_formula_and_a_shortest_run() {
    let (late, early) = (load("choice-late"), load("choice-early"));
    let Verdict::No(evidence) = compare(&late, &early, Preorder::Strong, &Bounds::default(), &|| false) else {
        panic!("they differ");
    };
    assert!(["[a] <b>", "[a] <c>"].contains(&evidence.formula(1_000).as_str()), "{}", evidence.formula(1_000));
    assert_eq!(evidence.run.len(), 1);
    let (left, right) = (load("tau-law-3-left"), load("tau-law-3-right"));
    let Verdict::No(evidence) = compare(&left, &right, Preorder::Branching, &Bounds::default(), &|| false) else {
        panic!("they differ");
    };
    assert!(evidence.formula(1_000).contains('<'), "{}", evidence.formula(1_000));
}

#[test]
fn files_of_other_tools_are_read_and_written_back() {
    let spaced =
        "\u{feff}  des( 0 ,4, 3 )\r\n(0,a,1)\n ( 0 , \"b (1, 2)\" , 2 )\n(1,\"say \\\"x\\\\\\\"\",2)\n\n(2,i,0)\n\n";
    let system = aut::read(spaced).expect("a system");
    let labels: BTreeSet<Label> = system.labels().iter().cloned().collect();
    let act = |text: &str| Label::Act(text.to_string());
    assert_eq!(labels, [act("a"), act("b (1, 2)"), act("say \"x\\\""), Label::Tau].into());
    let again = aut::read(&aut::write(&system)).expect("what was written");
    assert_eq!(aut::write(&again), aut::write(&system));
    let bare = aut::read("des (0, 1, 2)\n(0, send(1,2), 1)\n").expect("a label with commas");
    assert_eq!(*bare.label(0), act("send(1,2)"));
}

#[test]
fn hostile_files_are_refused_with_their_place() {
    let cases = [
        ("", (1, 1)),
        ("des", (1, 4)),
        ("des (0, 1)", (1, 10)),
        ("des (3, 0, 3)", (1, 6)),
        ("des (0, 1, 2)\n(0, a, 7)", (2, 8)),
        ("des (0, 1, 2)\n(0, \"a, 1)", (2, 5)),
        ("des (0, 1, 2)\n(0, a 1)", (2, 5)),
        ("des (0, 2, 2)\n(0, a, 1)\n", (3, 1)),
        ("des (0, 1, 2)\n(0, a, 1)\n(0, b, 1)", (3, 1)),
        ("des (0, 1, 2)\n(0, , 1)", (2, 5)),
        ("des (0, 99999999999999999999, 2)", (1, 9)),
        ("des (0, 0, 150000000)", (1, 12)),
        ("des (0, 1, 2)\n(-1, a, 1)", (2, 2)),
        ("graph { }", (1, 1)),
        ("des (0, 1, 2)\n(0, ä, 1) x", (2, 11)),
    ];
    for (text, place) in cases {
        let wrong = aut::read(text).expect_err(text);
        assert_eq!((wrong.line, wrong.column), place, "{text:?}: {}", wrong.what);
    }
}

/// A small generator; the same on every machine.
struct Dice(u64);

impl Dice {
    fn roll(&mut self, sides: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % sides
    }
}

fn random(dice: &mut Dice) -> TransitionSystem {
    let mut builder = Builder::new();
    let states = 1 + dice.roll(7);
    for _ in 0..states {
        let mut mark = Mark::plain();
        if dice.roll(6) == 0 {
            mark.shown.insert("A".to_string());
        }
        builder.state(mark);
    }
    let labels = [Label::Tau, Label::Act("a".into()), Label::Act("b".into())].map(|label| builder.label(label));
    for _ in 0..dice.roll(2 * states + 3) {
        let (from, to) = (dice.roll(states) as u32, dice.roll(states) as u32);
        builder.transition(from, labels[dice.roll(3) as usize], to);
    }
    builder.finish(0, None)
}

/// The same system in other words: states doubled, which keeps it bisimilar, or changed by one transition.
fn variant(system: &TransitionSystem, dice: &mut Dice) -> TransitionSystem {
    let mut builder = Builder::new();
    let count = system.states() as u32;
    for state in (0..count).chain(0..count) {
        builder.state(system.mark(state).clone());
    }
    let labels: Vec<u32> = system.labels().iter().map(|label| builder.label(label.clone())).collect();
    for state in 0..count {
        for (label, to) in system.steps(state) {
            for copy in 0..2 {
                let target = to + count * dice.roll(2) as u32;
                builder.transition(state + copy * count, labels[*label as usize], target);
            }
        }
    }
    if dice.roll(2) == 0 {
        let (from, to) = (dice.roll(u64::from(2 * count)) as u32, dice.roll(u64::from(2 * count)) as u32);
        builder.transition(from, labels[dice.roll(labels.len() as u64) as usize], to);
    }
    builder.finish(0, None)
}

#[test]
fn every_relation_agrees_with_its_definition_on_random_systems() {
    let seed = 19_890_312;
    println!("seed {seed}");
    let mut dice = Dice(seed);
    let mut counts = std::collections::BTreeMap::new();
    for round in 0..1_500 {
        let left = random(&mut dice);
        let right = if dice.roll(2) == 0 { variant(&left, &mut dice) } else { random(&mut dice) };
        for (relation, name) in Preorder::ALL {
            let found = verdict(&left, &right, relation);
            let wanted = naive::related(&left, &right, relation);
            let texts = (aut::write(&left), aut::write(&right));
            assert_eq!(found, wanted, "seed {seed}, round {round}, {name}:\n{}\n{}", texts.0, texts.1);
            *counts.entry((name, found)).or_insert(0) += 1;
        }
    }
    println!("{counts:?}");
    assert!(counts.len() == 2 * Preorder::ALL.len() && counts.values().all(|count| *count > 50), "{counts:?}");
}

#[test]
fn the_partition_is_the_coarsest_stable_one() {
    let seed = 20_090_701;
    println!("seed {seed}");
    let mut dice = Dice(seed);
    for round in 0..4_000 {
        let one = random(&mut dice);
        let system = variant(&one, &mut dice);
        let partition = strong_partition(&system);
        let naive = naive::partition(&system);
        for one in 0..system.states() {
            for two in 0..system.states() {
                let (same, wanted) = (partition[one] == partition[two], naive[one] == naive[two]);
                assert_eq!(same, wanted, "seed {seed}, round {round}:\n{}", aut::write(&system));
            }
        }
        let small = system.quotient(&partition, false);
        assert!(verdict(&system, &small, Preorder::Strong), "seed {seed}, round {round}");
        assert_eq!(strong_partition(&small).iter().max().map_or(0, |most| *most as usize + 1), small.states());
    }
}
