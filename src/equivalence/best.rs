//! Traces and weak bisimilarity of processes that draw at random, by greatest chances.
//!
//! A trace has the greatest chance with which it can be followed when steps are chosen as well as can be; without
//! draws that is 0 or 1. Traces are tried from the shortest on, each as a function on states; where no step is a choice
//! these functions are linear, and those that depend on others tell nothing new (Tzeng 1992). Weak bisimilarity is that
//! of Desharnais, Gupta, Jagadeesan and Panangaden (2010): states are apart if one has a greater greatest chance to do
//! an action, with internal steps around it, and then to be in some of the classes.

use std::collections::{BTreeSet, HashMap, HashSet};

use num_rational::BigRational;
use num_traits::{One, Zero};

use super::evidence::{Difference, Found, atom};
use super::formula::{Formulas, Node, Place};
use super::optimum::{Spot, once, optimum};
use super::told::between;
use crate::transition_system::{Label, TransitionSystem};

/// What came of it.
pub(super) enum Told {
    Same,
    Different(Box<Found>),
    /// Not decided, for this reason.
    Unknown(String),
}

/// For each state.
type Worth = Vec<BigRational>;
/// A label and the mark of the state after it.
type Seen = (u32, u32);

/// The most functions of traces, and the longest trace.
const MOST_TRACES: usize = 3_000;
const LONGEST: usize = 200;
/// The most values that are held or made in one round.
const MOST_VALUES: usize = 3_000_000;
/// The most classes of which all sets are tried.
const MOST_CLASSES: usize = 10;

struct Search<'s> {
    system: &'s TransitionSystem,
    outcomes: Vec<Vec<(BigRational, u32)>>,
    /// The number of the internal label where internal steps do not count.
    silent: Option<u32>,
    weak: bool,
    /// The labels of steps that count.
    labels: Vec<u32>,
}

impl<'s> Search<'s> {
    fn new(system: &'s TransitionSystem, weak: bool) -> Search<'s> {
        let owned =
            |state: u32| system.chances(state).into_iter().map(|(chance, to)| (chance.clone(), to)).collect::<Vec<_>>();
        let passed_over = |label: &Label| matches!(label, Label::Chance(_)) || weak && *label == Label::Tau;
        Search {
            system,
            outcomes: (0..system.states() as u32).map(owned).collect(),
            silent: system.label_number(&Label::Tau).filter(|_| weak),
            weak,
            labels: (0..system.labels().len() as u32).filter(|label| !passed_over(system.label(*label))).collect(),
        }
    }

    /// The function on all states: a state that draws is worth what its outcomes are worth on average.
    fn spread(&self, of: impl Fn(u32) -> BigRational) -> Worth {
        let draws = |state: usize| !self.outcomes[state].is_empty();
        let plain: Worth = (0..self.system.states())
            .map(|state| if draws(state) { BigRational::zero() } else { of(state as u32) })
            .collect();
        let average =
            |state: usize| self.outcomes[state].iter().map(|(chance, to)| chance * &plain[*to as usize]).sum();
        (0..plain.len()).map(|state| if draws(state) { average(state) } else { plain[state].clone() }).collect()
    }

    /// The greatest chance with which some internal steps lead to what is worth this.
    fn closed(&self, worth: &Worth) -> Option<Worth> {
        let Some(tau) = self.silent else { return Some(worth.clone()) };
        let spot = |state: usize| {
            if !self.outcomes[state].is_empty() {
                let outcomes = self.outcomes[state].iter();
                return Spot::Draw(outcomes.map(|(chance, to)| (chance.clone(), *to as usize)).collect());
            }
            let next = self.system.after(state as u32, tau).iter().map(|(_, to)| *to as usize).collect();
            Spot::Choice(worth[state].clone(), next)
        };
        let spots: Vec<Spot> = (0..worth.len()).map(spot).collect();
        optimum(&spots)
    }

    /// The greatest chance to do this and then to be where it is worth this.
    fn before(&self, label: u32, worth: &Worth) -> Option<Worth> {
        let behind = self.closed(worth)?;
        let best = |state: u32| {
            let next = self.system.after(state, label).iter().map(|(_, to)| *to as usize).collect();
            once(&Spot::Choice(BigRational::zero(), next), &behind)
        };
        self.closed(&self.spread(best))
    }

    /// The same where the state looks so, and nothing elsewhere.
    fn looking(&self, mark: u32, worth: &Worth) -> Worth {
        let there = |state: u32| self.system.mark_number(state) == mark;
        self.spread(|state| if there(state) { worth[state as usize].clone() } else { BigRational::zero() })
    }

    /// Whether a step is never a choice, so that greatest chances are sums.
    fn is_linear(&self) -> bool {
        let single = |state: u32| self.labels.iter().all(|label| self.system.after(state, *label).len() <= 1);
        self.silent.is_none() && (0..self.system.states() as u32).all(single)
    }

    fn look(&self, mark: u32) -> Node {
        let mark = &self.system.marks()[mark as usize];
        if self.weak { Node::Ends(mark.ending.clone()) } else { Node::Looks(mark.clone()) }
    }

    /// That the trace can be followed from a state that looks so at first.
    fn trace_formula(&self, first: u32, word: &[Seen], formulas: &mut Formulas) -> Place {
        let mut next = formulas.add(Node::True);
        for place in (0..=word.len()).rev() {
            let mark = if place == 0 { first } else { word[place - 1].1 };
            let look = formulas.add(self.look(mark));
            let both = formulas.add(Node::And(vec![look, next]));
            next = match place.checked_sub(1) {
                Some(before) => {
                    let label = self.system.label(word[before].0).clone();
                    formulas.add(Node::Some(self.weak, label, both))
                }
                None if self.weak => formulas.add(Node::Some(true, Label::Tau, both)),
                None => both,
            };
        }
        next
    }
}

fn apart(mut formulas: Formulas, told: Place, (left, right): (BigRational, BigRational), slack: &BigRational) -> Told {
    formulas.draws = true;
    let holds_left = left > right;
    let (low, high) = (left.clone().min(right.clone()), left.clone().max(right.clone()));
    // Chances that are not exact may be off once for each draw on the way.
    let least = if slack.is_zero() { Some(high) } else { between(&low, &high) };
    let Some(least) = least else { return Told::Unknown(TOO_CLOSE.into()) };
    let root = formulas.add(Node::Best(told, least));
    let difference = Difference::Best(told, left, right);
    Told::Different(Box::new(Found { formulas, root, holds_left, steps: Vec::new(), difference }))
}

const TOO_CLOSE: &str = "the chances found differ by less than they may be off";
const TOO_MANY: &str = "there are too many traces with different greatest chances to compare them all";
const TOO_TANGLED: &str = "too many internal steps and draws lead to each other, or too many classes are left";

/// Whether the traces of two states have the same greatest chances.
pub(super) fn traces(
    system: &TransitionSystem,
    (left, right): (u32, u32),
    weak: bool,
    stop: &dyn Fn() -> bool,
) -> Told {
    let search = Search::new(system, weak);
    let marks: BTreeSet<u32> = (0..system.states() as u32).map(|state| system.mark_number(state)).collect();
    let mut known: Vec<(Worth, Vec<Seen>)> = vec![(vec![BigRational::one(); system.states()], Vec::new())];
    let mut told = New::of(search.is_linear());
    let mut next = 0;
    while let Some((worth, word)) = known.get(next).cloned() {
        next += 1;
        if known.len() > MOST_TRACES || known.len() * system.states() > MOST_VALUES || word.len() >= LONGEST || stop() {
            return Told::Unknown(TOO_MANY.into());
        }
        for mark in &marks {
            let looking = search.looking(*mark, &worth);
            let Some(here) = search.closed(&looking) else { return Told::Unknown(TOO_TANGLED.into()) };
            let (one, two) = (&here[left as usize], &here[right as usize]);
            if one != two {
                let mut formulas = Formulas::default();
                let place = search.trace_formula(*mark, &word, &mut formulas);
                return apart(formulas, place, (one.clone(), two.clone()), &system.slack);
            }
            for label in &search.labels {
                let Some(before) = search.before(*label, &looking) else {
                    return Told::Unknown(TOO_TANGLED.into());
                };
                if told.is_new(&before) {
                    let longer = [(*label, *mark)].into_iter().chain(word.iter().copied()).collect();
                    known.push((before, longer));
                }
            }
        }
    }
    Told::Same
}

/// Which functions tell something new.
struct New {
    linear: bool,
    known: HashSet<Worth>,
    /// Rows with the place of their first entry that is not 0, which is 1.
    rows: Vec<(usize, Worth)>,
}

impl New {
    fn of(linear: bool) -> New {
        New { linear, known: HashSet::new(), rows: Vec::new() }
    }

    fn is_new(&mut self, worth: &Worth) -> bool {
        if worth.iter().all(BigRational::is_zero) {
            return false;
        }
        if !self.linear {
            return self.known.insert(worth.clone());
        }
        let mut left = worth.clone();
        for (place, row) in &self.rows {
            let factor = left[*place].clone();
            if !factor.is_zero() {
                left.iter_mut().zip(row).for_each(|(entry, other)| *entry -= &factor * other);
            }
        }
        let Some(place) = left.iter().position(|entry| !entry.is_zero()) else { return false };
        let scale = left[place].clone();
        left.iter_mut().for_each(|entry| *entry /= &scale);
        self.rows.push((place, left));
        true
    }
}

/// What is asked of each state: the step, none for internal steps alone, and the classes in which it is to be then.
#[derive(Clone)]
struct Question {
    label: Option<u32>,
    classes: Vec<u32>,
}

/// Classes of the states that draw nothing, in rounds; the others are in none.
struct Weakly<'s> {
    search: Search<'s>,
    rounds: Vec<Vec<u32>>,
    /// What was asked to come to the next round.
    asked: Vec<Vec<(Question, Worth)>>,
}

/// No class.
const NONE: u32 = u32::MAX;

/// Whether two states are weakly bisimilar.
pub(super) fn weakly(system: &TransitionSystem, pair: (u32, u32), stop: &dyn Fn() -> bool) -> Told {
    let search = Search::new(system, true);
    let draws = |state: u32| !search.outcomes[state as usize].is_empty();
    let first = (0..system.states() as u32).map(|state| if draws(state) { NONE } else { system.mark_number(state) });
    let first = numbered(first.map(|class| vec![class]).collect(), &search);
    let mut found = Weakly { search, rounds: vec![first], asked: Vec::new() };
    let mut all_sets = false;
    loop {
        if let Some(told) = found.tell(pair) {
            return told;
        }
        if stop() {
            return Told::Unknown("stopped by you".into());
        }
        let Some(asked) = found.ask(all_sets) else {
            return Told::Unknown(TOO_TANGLED.into());
        };
        let class = found.rounds.last().cloned().unwrap_or_default();
        let key = |state: usize| -> Vec<BigRational> { asked.iter().map(|(_, worth)| worth[state].clone()).collect() };
        let next = numbered((0..class.len()).map(|state| (class[state], key(state))).collect(), &found.search);
        let grew =
            next.iter().filter(|class| **class != NONE).max() > class.iter().filter(|class| **class != NONE).max();
        found.asked.push(asked);
        found.rounds.push(next);
        let classes = found.count();
        match (grew, all_sets) {
            (true, _) => all_sets = false,
            (false, true) => break,
            (false, false) if classes > MOST_CLASSES => {
                let why = format!("alike in all that was tried, but {classes} classes have too many sets");
                return found.tell(pair).unwrap_or(Told::Unknown(why));
            }
            (false, false) => all_sets = true,
        }
    }
    found.tell(pair).unwrap_or(Told::Same)
}

/// Keys as numbers from 0 on, for the states that draw nothing.
fn numbered<K: Eq + std::hash::Hash>(keys: Vec<K>, search: &Search) -> Vec<u32> {
    let mut known: HashMap<K, u32> = HashMap::new();
    let number = |(state, key): (usize, K)| {
        if !search.outcomes[state].is_empty() {
            return NONE;
        }
        let next = known.len() as u32;
        *known.entry(key).or_insert(next)
    };
    keys.into_iter().enumerate().map(number).collect()
}

impl Weakly<'_> {
    fn count(&self) -> usize {
        let class = self.rounds.last().into_iter().flatten().filter(|class| **class != NONE);
        class.max().map_or(0, |most| *most as usize + 1)
    }

    /// The greatest chances to do something and then to be in one class, or in one of several.
    fn ask(&self, all_sets: bool) -> Option<Vec<(Question, Worth)>> {
        let (count, class) = (self.count() as u32, self.rounds.last()?);
        let sets: Vec<Vec<u32>> = if all_sets {
            let within = |set: u32| (0..count).filter(move |class| set >> class & 1 == 1);
            (1..1u32 << count).map(|set| within(set).collect()).collect()
        } else {
            (0..count).map(|class| vec![class]).collect()
        };
        let work = sets.len() * (self.search.labels.len() + 1) * class.len();
        if work > MOST_VALUES {
            return None;
        }
        let mut asked = Vec::new();
        for classes in sets {
            let there = |state: u32| classes.contains(&class[state as usize]);
            let worth = self.search.spread(|state| if there(state) { BigRational::one() } else { BigRational::zero() });
            asked.push((Question { label: None, classes: classes.clone() }, self.search.closed(&worth)?));
            for label in &self.search.labels {
                let question = Question { label: Some(*label), classes: classes.clone() };
                asked.push((question, self.search.before(*label, &worth)?));
            }
        }
        Some(asked)
    }

    /// Why the two differ, as far as is known.
    fn tell(&self, (left, right): (u32, u32)) -> Option<Told> {
        let slack = &self.search.system.slack;
        let draws = |state: u32| !self.search.outcomes[state as usize].is_empty();
        let mut writer = Writer { weakly: self, formulas: Formulas::default(), known: HashMap::new() };
        if !draws(left) && !draws(right) && self.rounds[0][left as usize] != self.rounds[0][right as usize] {
            let told = writer.tell(left, right)?;
            return Some(apart(writer.formulas, told, (BigRational::one(), BigRational::zero()), slack));
        }
        let differ = |(_, worth): &&(Question, Worth)| worth[left as usize] != worth[right as usize];
        let round = self.asked.iter().position(|asked| asked.iter().any(|one| differ(&one)))?;
        let (question, worth) = self.asked[round].iter().find(differ)?;
        let told = writer.ask(question, round)?;
        let values = (worth[left as usize].clone(), worth[right as usize].clone());
        Some(apart(writer.formulas, told, values, slack))
    }
}

struct Writer<'w, 's> {
    weakly: &'w Weakly<'s>,
    formulas: Formulas,
    known: HashMap<(u32, u32), Place>,
}

impl Writer<'_, '_> {
    /// That the question, asked of the classes of this round, comes true.
    fn ask(&mut self, question: &Question, round: usize) -> Option<Place> {
        let class = &self.weakly.rounds[round];
        let count = class.iter().filter(|class| **class != NONE).max().map_or(0, |most| *most + 1);
        let member = |wanted: u32| class.iter().position(|class| *class == wanted).map(|state| state as u32);
        let mut parts = Vec::new();
        for own in &question.classes {
            let mut all = Vec::new();
            for other in (0..count).filter(|other| !question.classes.contains(other)) {
                all.push(self.tell(member(*own)?, member(other)?)?);
            }
            parts.push(self.formulas.add(Node::And(all)));
        }
        let there = self.formulas.add(Node::Or(parts));
        let label = question.label.map_or(Label::Tau, |label| self.weakly.search.system.label(label).clone());
        Some(self.formulas.add(Node::Some(true, label, there)))
    }

    /// What holds of the first alone; both draw nothing.
    fn tell(&mut self, one: u32, two: u32) -> Option<Place> {
        if let Some(known) = self.known.get(&(one, two)) {
            return Some(*known);
        }
        let apart = |classes: &Vec<u32>| classes[one as usize] != classes[two as usize];
        let round = self.weakly.rounds.iter().position(apart)?;
        let node = match round.checked_sub(1) {
            None => atom(self.weakly.search.system, (one, two)),
            Some(before) => {
                let differ = |(_, worth): &&(Question, Worth)| worth[one as usize] != worth[two as usize];
                let (question, worth) = self.weakly.asked[before].iter().find(differ)?;
                let told = self.ask(question, before)?;
                let (left, right) = (worth[one as usize].clone(), worth[two as usize].clone());
                let best = Node::Best(told, left.clone().max(right.clone()));
                if left > right { best } else { Node::Not(self.formulas.add(best)) }
            }
        };
        let place = self.formulas.add(node);
        self.known.insert((one, two), place);
        Some(place)
    }
}
