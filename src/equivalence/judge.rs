//! Whether a formula holds of a state: decided on the behaviour alone, by one definition a line, sharing nothing with
//! the algorithms that found the formula.

mod worth;

use std::collections::{HashMap, HashSet};
use std::rc::Rc;

use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use super::formula::{Formulas, Node, Place};
use super::weak::shows;
use crate::transition_system::{Behaviour, Label, Mark, Trouble};

/// The most states, and the most questions, of one judgement.
const MOST: usize = 2_000_000;

/// Why a formula was not judged.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Doubt {
    /// It takes too many states or questions.
    TooMuch,
    /// A chance is known only up to some error, and that does not do.
    Close,
    /// A state has no meaning.
    Trouble(Trouble),
}

impl From<Trouble> for Doubt {
    fn from(trouble: Trouble) -> Doubt {
        Doubt::Trouble(trouble)
    }
}

type Judged<T> = Result<T, Doubt>;
type Steps = Rc<Vec<(Label, u32)>>;

/// Judges formulas on one behaviour.
pub(super) struct Judge<'b, B: Behaviour> {
    behaviour: &'b B,
    numbers: HashMap<B::State, u32>,
    states: Vec<B::State>,
    steps: HashMap<u32, Steps>,
    marks: HashMap<u32, Rc<Mark>>,
    closures: HashMap<u32, Rc<Vec<u32>>>,
    known: HashMap<(Place, u32), bool>,
    worths: HashMap<(Place, u32), worth::Worth>,
    asked: usize,
}

/// What must be known first.
enum Answer {
    Known(bool),
    First(Place, u32),
}

impl<'b, B: Behaviour> Judge<'b, B> {
    pub(super) fn new(behaviour: &'b B) -> Judge<'b, B> {
        Judge {
            behaviour,
            numbers: HashMap::new(),
            states: Vec::new(),
            steps: HashMap::new(),
            marks: HashMap::new(),
            closures: HashMap::new(),
            known: HashMap::new(),
            worths: HashMap::new(),
            asked: 0,
        }
    }

    /// The number of a state here.
    pub(super) fn number(&mut self, state: &B::State) -> u32 {
        if let Some(number) = self.numbers.get(state) {
            return *number;
        }
        let number = self.states.len() as u32;
        self.states.push(state.clone());
        self.numbers.insert(state.clone(), number);
        number
    }

    /// The state of a number.
    pub(super) fn state(&self, number: u32) -> &B::State {
        &self.states[number as usize]
    }

    /// Forgets what it knows of formulas, for formulas of another evidence.
    pub(super) fn start(&mut self) -> Judged<u32> {
        let state = self.behaviour.start()?;
        Ok(self.number(&state))
    }

    fn steps(&mut self, state: u32) -> Judged<Steps> {
        if let Some(steps) = self.steps.get(&state) {
            return Ok(steps.clone());
        }
        if self.states.len() > MOST {
            return Err(Doubt::TooMuch);
        }
        let found = self.behaviour.steps(&self.states[state as usize].clone())?;
        let steps: Steps = Rc::new(found.into_iter().map(|(label, to)| (label, self.number(&to))).collect());
        self.steps.insert(state, steps.clone());
        Ok(steps)
    }

    pub(super) fn mark(&mut self, state: u32) -> Judged<Rc<Mark>> {
        if let Some(mark) = self.marks.get(&state) {
            return Ok(mark.clone());
        }
        let mark = Rc::new(self.behaviour.mark(&self.states[state as usize])?);
        self.marks.insert(state, mark.clone());
        Ok(mark)
    }

    /// The states after one step with this label.
    pub(super) fn after(&mut self, state: u32, label: &Label) -> Judged<Vec<u32>> {
        if let Label::Shows(text) = label {
            let unstable = self.steps(state)?.iter().any(|(label, _)| *label == Label::Tau);
            let same = shows(&*self.mark(state)?, unstable).as_ref() == Some(text);
            return Ok(if same { vec![state] } else { Vec::new() });
        }
        Ok(self.steps(state)?.iter().filter(|(other, _)| other == label).map(|(_, to)| *to).collect())
    }

    /// The states after any number of internal steps.
    fn closure(&mut self, state: u32) -> Judged<Rc<Vec<u32>>> {
        if let Some(closure) = self.closures.get(&state) {
            return Ok(closure.clone());
        }
        let mut all = vec![state];
        let mut seen = HashSet::from([state]);
        let mut next = 0;
        while next < all.len() {
            for to in self.after(all[next], &Label::Tau)? {
                if seen.insert(to) {
                    all.push(to);
                }
            }
            next += 1;
        }
        let closure = Rc::new(all);
        self.closures.insert(state, closure.clone());
        Ok(closure)
    }

    /// The states after one step with this label and any number of internal steps before and behind it.
    pub(super) fn weakly_after(&mut self, state: u32, label: &Label) -> Judged<Vec<u32>> {
        let before = self.closure(state)?;
        if *label == Label::Tau {
            return Ok(before.to_vec());
        }
        let mut found = Vec::new();
        let mut seen = HashSet::new();
        for middle in before.iter() {
            for to in self.after(*middle, label)? {
                for end in self.closure(to)?.iter() {
                    if seen.insert(*end) {
                        found.push(*end);
                    }
                }
            }
        }
        Ok(found)
    }

    /// Whether the formula holds in the state. Formulas must all be of one collection.
    pub(super) fn holds(&mut self, formulas: &Formulas, root: Place, state: u32) -> Judged<bool> {
        let mut open = vec![(root, state)];
        while let Some((place, at)) = open.pop() {
            self.asked += 1;
            if self.asked > MOST {
                return Err(Doubt::TooMuch);
            }
            if self.known.contains_key(&(place, at)) {
                continue;
            }
            match self.ask(formulas, place, at)? {
                Answer::Known(holds) => {
                    self.known.insert((place, at), holds);
                }
                Answer::First(other, there) => open.extend([(place, at), (other, there)]),
            }
        }
        Ok(self.known.get(&(root, state)).copied().unwrap_or(false))
    }

    fn ask(&mut self, formulas: &Formulas, place: Place, at: u32) -> Judged<Answer> {
        let joins = matches!(
            formulas.node(place),
            Node::Chance(..) | Node::Best(..) | Node::And(_) | Node::Or(_) | Node::Not(_)
        );
        if formulas.draws && !joins {
            let outcomes: Vec<u32> = self.outcomes(at)?.into_iter().map(|(_, to)| to).collect();
            if !outcomes.is_empty() {
                return Ok(self.any(outcomes.into_iter().map(|to| (place, to)), false));
            }
        }
        Ok(Answer::Known(match formulas.node(place) {
            Node::True => true,
            Node::False => false,
            Node::Ends(ending) => self.mark(at)?.ending == *ending,
            Node::Shows(shown) => self.mark(at)?.shown.contains(shown),
            Node::Hides(shown) => !self.mark(at)?.shown.contains(shown),
            Node::Looks(mark) => {
                let seen = self.mark(at)?;
                seen.ending == mark.ending && seen.shown == mark.shown
            }
            Node::Not(part) => match self.known.get(&(*part, at)) {
                Some(holds) => !holds,
                None => return Ok(Answer::First(*part, at)),
            },
            Node::And(parts) => return Ok(self.any(parts.iter().map(|part| (*part, at)), false)),
            Node::Or(parts) => return Ok(self.any(parts.iter().map(|part| (*part, at)), true)),
            Node::Some(weak, label, next) | Node::All(weak, label, next) => {
                let targets = if *weak { self.weakly_after(at, label)? } else { self.after(at, label)? };
                let some = matches!(formulas.node(place), Node::Some(..));
                return Ok(self.any(targets.into_iter().map(|to| (*next, to)), some));
            }
            Node::Best(part, least) => {
                let (worth, off) = self.worth(formulas, *part, at)?;
                at_least(&worth, least, &off)?
            }
            Node::Chance(part, least) => match self.sum(*part, at)? {
                Ok(chance) => at_least(&chance, least, &self.behaviour.slack())?,
                Err((place, state)) => return Ok(Answer::First(place, state)),
            },
            Node::Until(hold, label, next) => return self.until(*hold, label, *next, at),
        }))
    }

    /// With what chance the formula holds once the draws that are due in the state have been made.
    pub(super) fn chance(&mut self, formulas: &Formulas, place: Place, state: u32) -> Judged<BigRational> {
        loop {
            match self.sum(place, state)? {
                Ok(chance) => return Ok(chance),
                Err((place, state)) => {
                    self.holds(formulas, place, state)?;
                }
            }
        }
    }

    /// The outcomes of the draws that are due; none if none is.
    fn outcomes(&mut self, state: u32) -> Judged<Vec<(BigRational, u32)>> {
        let mut outcomes = Vec::new();
        for (label, to) in self.steps(state)?.iter() {
            if let Label::Chance(chance) = label {
                outcomes.push((chance.clone(), *to));
            }
        }
        Ok(outcomes)
    }

    /// The chance, or what must be known first.
    fn sum(&mut self, place: Place, state: u32) -> Judged<Result<BigRational, (Place, u32)>> {
        let mut outcomes = self.outcomes(state)?;
        if outcomes.is_empty() {
            outcomes.push((BigRational::one(), state));
        }
        let mut sum = BigRational::zero();
        for (chance, to) in outcomes {
            match self.known.get(&(place, to)) {
                Some(true) => sum += chance,
                Some(false) => {}
                None => return Ok(Err((place, to))),
            }
        }
        Ok(Ok(sum))
    }

    /// Whether one of the questions is answered so; known to be not so once all are answered otherwise.
    fn any(&self, questions: impl Iterator<Item = (Place, u32)>, so: bool) -> Answer {
        for (place, state) in questions {
            match self.known.get(&(place, state)) {
                Some(holds) if *holds == so => return Answer::Known(so),
                Some(_) => {}
                None => return Answer::First(place, state),
            }
        }
        Answer::Known(!so)
    }

    fn until(&mut self, hold: Place, label: &Label, next: Place, at: u32) -> Judged<Answer> {
        if *label == Label::Tau {
            match self.known.get(&(next, at)) {
                Some(true) => return Ok(Answer::Known(true)),
                Some(false) => {}
                None => return Ok(Answer::First(next, at)),
            }
        }
        let mut all = vec![at];
        let mut seen = HashSet::from([at]);
        let mut place = 0;
        while place < all.len() {
            let state = all[place];
            place += 1;
            match self.known.get(&(hold, state)) {
                Some(true) => {}
                Some(false) => continue,
                None => return Ok(Answer::First(hold, state)),
            }
            for to in self.after(state, label)? {
                match self.known.get(&(next, to)) {
                    Some(true) => return Ok(Answer::Known(true)),
                    Some(false) => {}
                    None => return Ok(Answer::First(next, to)),
                }
            }
            for to in self.after(state, &Label::Tau)? {
                if seen.insert(to) {
                    all.push(to);
                }
            }
        }
        Ok(Answer::Known(false))
    }
}

/// Whether a chance that may be off so far is at least this.
fn at_least(chance: &BigRational, least: &BigRational, off: &BigRational) -> Judged<bool> {
    let near = !off.is_zero() && (chance - least).abs() <= *off;
    if near { Err(Doubt::Close) } else { Ok(chance >= least) }
}
