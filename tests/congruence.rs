//! What every operator and projection must keep: strong and weak equality and refinement, judged on transition
//! systems; and these judged against the game on pairs of states, which shares nothing with them but the model.

mod common;

use std::collections::BTreeSet;

use common::*;
use pars::bisimulation::{self, Comparison, Reach};
use pars::definition::Definitions;
use pars::equivalence::{self, Evidence, Preorder, ProcessAnswer, Verdict, compare_processes};
use pars::law::Connective;
use pars::name::Name;
use pars::stepper::Stepper;
use pars::term::{Node, Term};
use pars::transition_system::{Bounds, Inputs, generate_pair};
use pars::value::Relation;

mod dice;
use dice::Dice;

/// As many instances as each property is tried on.
const INSTANCES: usize = 10_000;

impl Dice {
    fn leaf(&mut self) -> Term {
        let bit = |dice: &mut Dice| number(dice.roll(2) as i64);
        let port = |dice: &mut Dice| if dice.roll(2) == 0 { "c" } else { "d" };
        match self.roll(14) {
            0 => Term::stop(),
            1 => Term::abort(),
            2 => Term::idle(),
            3..=5 => wait(1 + self.roll(2) as i64),
            6 | 7 => observer("A", vec![bit(self)]),
            8 => observer("B", vec![]),
            9 => guard(Relation::Eq, bit(self), number(0)),
            10 => tau(),
            11 => input(port(self), "y"),
            _ => output(port(self), bit(self)),
        }
    }

    fn term(&mut self, size: u64) -> Term {
        if size <= 1 {
            return self.leaf();
        }
        let first = 1 + self.roll(size - 1);
        let (one, two) = (self.term(first), self.term(size - first));
        match self.roll(9) {
            0..=2 => Term::seq([one, two]),
            3 | 4 => Term::par([one, two]),
            5 | 6 => Term::disable([one, two]),
            7 => Term::otherwise(one, two),
            _ => again(Term::seq([wait(1), one])),
        }
    }

    /// The process inside a random context.
    fn context(&mut self, inside: [Term; 2]) -> [Term; 2] {
        let mut sides = inside;
        for _ in 0..1 + self.roll(2) {
            let size = 1 + self.roll(2);
            let other = self.term(size);
            let which = self.roll(11);
            sides = sides.map(|side| match which {
                0 => Term::seq([side, other.clone()]),
                1 => Term::seq([other.clone(), side]),
                2 | 3 => Term::par([side, other.clone()]),
                4..=6 => Term::disable([side, other.clone()]),
                7 => Term::otherwise(side, other.clone()),
                8 => Term::otherwise(other.clone(), side),
                9 => again(Term::seq([wait(1), side])),
                _ => private("c", side),
            });
        }
        sides
    }

    /// The same process said otherwise, somewhere inside; with internal steps if `weakly`.
    fn disguised(&mut self, term: &Term, weakly: bool) -> Term {
        let children = term.children();
        if !children.is_empty() && self.roll(3) > 0 {
            let chosen = self.roll(children.len() as u64) as usize;
            let mut parts: Vec<Term> = children.into_iter().cloned().collect();
            parts[chosen] = self.disguised(&parts[chosen], weakly);
            return term.with_children(parts);
        }
        match self.roll(if weakly { 8 } else { 6 }) {
            0 => Term::seq([Term::stop(), term.clone()]),
            1 => Term::disable([term.clone(), Term::idle()]),
            2 => Term::par([term.clone(), Term::abort()]),
            3 => Term::otherwise(Term::abort(), term.clone()),
            4 => Term::seq([term.clone(), Term::stop()]),
            5 => match term.node() {
                Node::Delay(_) => Term::disable([term.clone(), Term::par([term.clone(), term.clone()])]),
                _ => Term::seq([term.clone(), Term::stop()]),
            },
            6 => Term::seq([tau(), term.clone()]),
            _ => Term::seq([term.clone(), tau()]),
        }
    }

    /// A pair of which the second shows less here and there.
    fn hidden(&mut self, term: &Term) -> Term {
        match term.node() {
            Node::Observe(..) if self.roll(2) == 0 => Term::idle(),
            _ => {
                let parts: Vec<Term> = term.children().map(|part| self.hidden(part)).collect();
                if parts.is_empty() { term.clone() } else { term.with_children(parts) }
            }
        }
    }
}

/// Whether two closed terms are related; none where one has no meaning or it is not decided.
fn related(left: &Term, right: &Term, relation: Preorder) -> Option<bool> {
    let bounds = Bounds { states: 2_000, ..Bounds::default() };
    let answer = compare_processes(left, right, &Definitions::default(), relation, &bounds, &|| false).ok()?;
    match &answer.verdict {
        Verdict::Yes => Some(true),
        Verdict::No(evidence) => {
            loads(left, right, &answer, evidence);
            Some(false)
        }
        Verdict::Unknown(why) => {
            assert!(!why.contains("difference was found"), "{left} ~ {right}: {why}");
            None
        }
    }
}

/// The run of each side loads into the stepper, and leads where the run says.
fn loads(left: &Term, right: &Term, answer: &ProcessAnswer, evidence: &Evidence) {
    for (side, term) in [left, right].into_iter().enumerate() {
        let last = evidence.run.iter().rev().find_map(|step| if side == 0 { step.left } else { step.right });
        let mut stepper = Stepper::new(term, &Definitions::default()).expect("a meaning");
        stepper.load(&answer.choices[side].join("\n")).expect("a run");
        let end = last.map_or(&answer.states[side][0], |state| &answer.states[side][state as usize]);
        assert_eq!(stepper.state(), end, "{left} and {right}");
    }
}

/// The seed of a test; `PARS_SEED` makes others of it.
fn seeded(seed: u64) -> u64 {
    let more = std::env::var("PARS_SEED").ok().and_then(|text| text.parse().ok()).unwrap_or(0);
    let seed = seed.wrapping_add(more);
    println!("seed {seed}");
    seed
}

/// Draws pairs that are related until enough of them stay so in what `around` makes of them.
fn kept(
    seed: u64,
    relation: Preorder,
    pair: impl Fn(&mut Dice) -> [Term; 2],
    around: impl Fn(&mut Dice, [Term; 2]) -> [Term; 2],
) {
    if let Some(broken) = broken(seed, relation, pair, around) {
        panic!("{broken}");
    }
}

/// The first pair that does not stay related.
fn broken(
    seed: u64,
    relation: Preorder,
    pair: impl Fn(&mut Dice) -> [Term; 2],
    around: impl Fn(&mut Dice, [Term; 2]) -> [Term; 2],
) -> Option<String> {
    let seed = seeded(seed);
    let mut dice = Dice(seed);
    let mut done = 0;
    while done < INSTANCES {
        let [left, right] = pair(&mut dice);
        if related(&left, &right, relation) != Some(true) {
            continue;
        }
        // Several contexts for each pair.
        for _ in 0..4 {
            let [one, two] = around(&mut dice, [left.clone(), right.clone()]);
            let Some(still) = related(&one, &two, relation) else { continue };
            if !still {
                return Some(format!(
                    "seed {seed}, instance {done}: {left} and {right} are related, but not {one} and {two}"
                ));
            }
            // Equal terms say nothing.
            done += usize::from(one != two);
        }
    }
    None
}

fn with_room(work: impl FnOnce() + Send + 'static) {
    std::thread::Builder::new().stack_size(256 << 20).spawn(work).expect("a thread").join().expect("no failure");
}

#[test]
fn strong_equality_is_kept_by_every_operator() {
    with_room(|| kept(20_120_901, Preorder::Strong, same, |dice, pair| dice.context(pair)));
}

/// What is not kept is found: the search can fail.
#[test]
fn what_is_done_to_one_side_alone_is_found() {
    with_room(|| {
        let around = |dice: &mut Dice, pair: [Term; 2]| {
            let [one, two] = dice.context(pair);
            [one, Term::seq([two, Term::abort()])]
        };
        let found = broken(20_120_907, Preorder::Strong, same, around);
        assert!(found.is_some_and(|text| text.contains("are related, but not")));
    });
}

fn same(dice: &mut Dice) -> [Term; 2] {
    let size = 1 + dice.roll(3);
    let left = dice.term(size);
    let right = if dice.roll(4) == 0 { dice.term(size) } else { dice.disguised(&left, false) };
    [left, right]
}

#[test]
fn weak_equality_with_exact_endings_is_kept_by_every_operator() {
    let pair = |dice: &mut Dice| {
        let size = 1 + dice.roll(3);
        let left = dice.term(size);
        let right = dice.disguised(&left, true);
        [left, right]
    };
    with_room(move || kept(20_120_902, Preorder::Weak, pair, |dice, pair| dice.context(pair)));
}

#[test]
fn refinement_is_kept_by_every_operator() {
    let pair = |dice: &mut Dice| {
        let size = 1 + dice.roll(3);
        let inner = dice.term(size);
        let shown = Term::disable([inner.clone(), observer("A", vec![number(dice.roll(2) as i64)])]);
        let [left, right] = if dice.roll(2) == 0 { [shown, inner] } else { [shown.clone(), shown] };
        let right = dice.hidden(&right);
        [left, right]
    };
    with_room(move || kept(20_120_903, Preorder::Refinement, pair, |dice, pair| dice.context(pair)));
}

#[test]
fn equality_is_kept_by_projection() {
    let project = |dice: &mut Dice, pair: [Term; 2]| {
        let names: BTreeSet<Name> = ["A", "B"].into_iter().filter(|_| dice.roll(2) == 0).map(Name::new).collect();
        let [left, right] = dice.context(pair);
        [left, right].map(|side| Term::new(Node::Project(side, names.clone())))
    };
    with_room(move || kept(20_120_904, Preorder::Strong, same, project));
}

/// Whether two terms with whole delays are alike at every moment that matters.
fn densely(left: &Term, right: &Term, relation: Preorder) -> Option<bool> {
    let definitions = Definitions::default();
    let inputs = Inputs::of(&[left, right], &definitions, 3).values;
    let refines = relation == Preorder::Refinement;
    let reach = Reach { inputs, ..Reach::default() };
    let unit = num_rational::BigRational::from_integer(1.into());
    match bisimulation::compare_densely(left, right, refines, &definitions, &reach, &unit).ok()? {
        Comparison::Same => Some(true),
        Comparison::Different(_) => Some(false),
        Comparison::Unknown(_) => None,
    }
}

/// Whether two terms are alike at multiples of a tick that is halved so often.
fn at_ticks(left: &Term, right: &Term, finer: u32) -> Option<bool> {
    let (definitions, bounds) = (Definitions::default(), Bounds { states: 3_000, ..Bounds::default() });
    let inputs = Inputs::of(&[left, right], &definitions, 3);
    let (_, [one, two]) = generate_pair([left, right], &definitions, &inputs, &bounds, finer, &|| false).ok()?;
    match equivalence::compare(&one.system, &two.system, Preorder::Strong, &bounds, &|| false) {
        Verdict::Yes => Some(true),
        Verdict::No(_) => Some(false),
        Verdict::Unknown(_) => None,
    }
}

#[test]
fn what_is_alike_at_every_moment_is_alike_at_all_ticks_and_the_other_way_round() {
    with_room(|| {
        let seed = seeded(19_941_231);
        let mut dice = Dice(seed);
        let mut counts = [0; 3];
        while counts[0] + counts[1] < 1_500 {
            let size = 2 + dice.roll(5);
            let left = dice.term(size);
            let right = if dice.roll(3) > 0 { dice.disguised(&left, false) } else { dice.term(size) };
            if left == right {
                continue;
            }
            let Some(found) = densely(&left, &right, Preorder::Strong) else { continue };
            let ticks: Vec<bool> = (0..4).filter_map(|finer| at_ticks(&left, &right, finer)).collect();
            // Ticks may be too coarse for a difference, but never show one that is not there.
            assert!(!found || ticks.iter().all(|same| *same), "seed {seed}: {left} and {right}: {ticks:?}");
            assert!(found || ticks.len() < 4 || ticks.contains(&false), "seed {seed}: {left} and {right}: {ticks:?}");
            counts[usize::from(found)] += 1;
            counts[2] += usize::from(!found && ticks.first() == Some(&true));
        }
        println!("{counts:?}");
        assert!(counts[0] > 300 && counts[1] > 300, "{counts:?}");
    });
}

#[test]
fn the_systems_agree_with_the_game_on_pairs() {
    with_room(|| {
        let seed = seeded(20_120_905);
        let mut dice = Dice(seed);
        let mut counts = [0; 4];
        while counts.iter().sum::<usize>() < INSTANCES {
            let size = 1 + dice.roll(4);
            let left = dice.term(size);
            let right = match dice.roll(3) {
                0 => dice.disguised(&left, false),
                1 => dice.hidden(&left),
                _ => dice.term(size),
            };
            let (relation, connective) = match dice.roll(2) {
                0 => (Preorder::Strong, Connective::Equal),
                _ => (Preorder::Refinement, Connective::Refines),
            };
            let definitions = Definitions::default();
            let inputs = Inputs::of(&[&left, &right], &definitions, 3).values;
            let reach = Reach { inputs, ..Reach::default() };
            let game = bisimulation::compare(&left, &right, connective, &definitions, &reach);
            let wanted = match game {
                Ok(Comparison::Same) => true,
                Ok(Comparison::Different(_)) => false,
                _ => continue,
            };
            let Some(found) = related(&left, &right, relation) else { continue };
            // The game meets half ticks alone here; the systems are compared at every moment that matters.
            let said = format!("seed {seed}: {left} and {right}, {}", relation.name());
            assert!(found == wanted || (wanted && densely(&left, &right, relation) == Some(false)), "{said}");
            counts[2 * usize::from(found) + usize::from(relation == Preorder::Strong)] += 1;
        }
        assert!(counts.iter().all(|count| *count > 500), "{counts:?}");
    });
}
