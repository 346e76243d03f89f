//! The graph of pairs of states, and which of them differ after how many steps.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::rc::Rc;

use num_rational::BigRational;
use num_traits::One;

use super::draw::{alike, difference, distinct, symbolic_draw};
use super::{Comparison, Difference, Reach, Run, Side, Step, grain::grain, region};
use crate::definition::Definitions;
use crate::law::Connective;
use crate::model::explore::Label;
use crate::model::{Action, Meaningless, Model, Observation, Patience, State};
use crate::term::Term;
use crate::value::Value;

/// How many draws may follow one another in no time.
pub(super) const MOST_DRAWS: usize = 100;

/// What a label is compared by: all internal steps are alike.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Key {
    Tau,
    Act(Label),
}

/// A settled state, looked into once.
pub(super) struct Seen {
    pub(super) state: State,
    pub(super) shown: BTreeSet<Observation>,
    pub(super) moves: BTreeMap<Key, Vec<(Label, usize)>>,
    pub(super) patience: Patience,
    pub(super) offers: bool,
    /// The branches of a draw that is due; none otherwise.
    pub(super) chances: Vec<(BigRational, usize)>,
    /// Whether it holds a value that was drawn and is not known, or nothing is known of it: then it may be equal to
    /// others that look different.
    pub(super) blurred: bool,
}

/// One way to press the other side: it must reach one of the answers.
pub(super) struct Challenge {
    pub(super) side: Side,
    pub(super) label: Label,
    pub(super) answers: Vec<usize>,
}

pub(super) enum Pair {
    /// Not looked into.
    Open,
    /// Different at once.
    Apart(Box<Difference>),
    /// Different if some challenge has no answer but pairs that differ.
    Choice(Vec<Challenge>),
    /// Different if the chances of no matching of the branches agree; the pairs, row by row.
    Lottery(Vec<usize>),
}

/// How a pair was found to differ: after how many steps, and by which challenge.
#[derive(Clone, Copy)]
pub(super) struct Mark {
    rank: usize,
    challenge: usize,
}

/// A comparison at work.
pub(super) struct Game<'a> {
    pub(super) model: Model<'a>,
    pub(super) refines: bool,
    weak: bool,
    /// Whether something was passed over that could have told states apart.
    pub(super) undecided: bool,
    pub(super) reach: &'a Reach,
    pub(super) grain: BigRational,
    /// Where time is dense: what divides every delay.
    pub(super) unit: Option<BigRational>,
    pub(super) closures: HashMap<usize, Rc<Vec<usize>>>,
    places: HashMap<State, usize>,
    states: Vec<State>,
    pub(super) seen: Vec<Option<Rc<Seen>>>,
    pair_places: HashMap<(usize, usize), usize>,
    pub(super) pairs: Vec<((usize, usize), Pair)>,
    before: Vec<Vec<usize>>,
    pub(super) marks: Vec<Option<Mark>>,
    pub(super) drawing: usize,
    /// Whether some value was drawn that is not known.
    symbols: bool,
    /// The place of all states of which nothing is known, since what they do depends on such a value.
    unknown: Option<usize>,
}

impl<'a> Game<'a> {
    pub(super) fn new(
        definitions: &'a Definitions,
        connective: Connective,
        reach: &'a Reach,
        left: &Term,
        right: &Term,
    ) -> Game<'a> {
        Game {
            model: Model::new(definitions),
            refines: connective.refines(),
            weak: connective.is_weak(),
            undecided: false,
            closures: HashMap::new(),
            reach,
            grain: grain([left, right], definitions),
            unit: None,
            places: HashMap::new(),
            states: Vec::new(),
            seen: Vec::new(),
            pair_places: HashMap::new(),
            pairs: Vec::new(),
            before: Vec::new(),
            marks: Vec::new(),
            drawing: 0,
            symbols: false,
            unknown: None,
        }
    }

    pub(super) fn decide(mut self, left: &Term, right: &Term) -> Result<Comparison, Meaningless> {
        let left = self.model.state(left)?;
        let right = self.model.state(right)?;
        self.decide_states(left, right)
    }

    pub(super) fn decide_states(&mut self, left: State, right: State) -> Result<Comparison, Meaningless> {
        self.symbols = left.holds_drawn() || right.holds_drawn();
        let left = self.place(left)?;
        let right = self.place(right)?;
        if left == right {
            // Equal states are the same, but a meaningless future must still be reported.
            self.sweep(left)?;
            return Ok(Comparison::Same);
        }
        self.pair(left, right);
        let mut next = 0;
        let mut complete = true;
        while next < self.pairs.len() {
            if next >= self.reach.pairs {
                complete = false;
                break;
            }
            let (left, right) = self.pairs[next].0;
            let looked = if self.weak { self.look_weakly(left, right)? } else { self.look(left, right)? };
            let apart = matches!(looked, Pair::Apart(_));
            for after in looked.pairs() {
                self.before[after].push(next);
            }
            self.pairs[next].1 = looked;
            if apart && next == 0 {
                break;
            }
            next += 1;
        }
        self.mark();
        Ok(match self.marks[0] {
            Some(_) => Comparison::Different(self.run()),
            None if complete && !self.undecided => Comparison::Same,
            None => Comparison::Unknown(self.reach.pairs),
        })
    }

    /// Looks into what a single state can reach, as far as the bound allows.
    pub(super) fn sweep(&mut self, start: usize) -> Result<(), Meaningless> {
        let mut open = vec![start];
        let mut done = BTreeSet::from([start]);
        while let Some(place) = open.pop() {
            if done.len() > self.reach.pairs {
                return Ok(());
            }
            let seen = self.seen(place)?;
            let mut after: Vec<usize> = seen.moves.values().flatten().map(|(_, to)| *to).collect();
            after.extend(seen.chances.iter().map(|(_, to)| *to));
            if let Patience::Until(time) = &seen.patience {
                after.push(self.passed(&seen, time)?);
            }
            open.extend(after.into_iter().filter(|place| done.insert(*place)));
        }
        Ok(())
    }

    /// The place of a state; a draw with a single branch is the state after it, and so is one from a continuous
    /// distribution, with a symbol for the value.
    pub(super) fn place(&mut self, state: State) -> Result<usize, Meaningless> {
        if let Some(place) = self.places.get(&state) {
            return Ok(*place);
        }
        let mut settled = Some(state.clone());
        for draws in 0.. {
            let Some(before) = &settled else { break };
            let moves = match before.moves() {
                Err(_) if self.is_blurred(before) => Vec::new(),
                moves => moves?,
            };
            settled = match moves.as_slice() {
                [only] if matches!(only.action, Action::Draw(_, Some(_))) => Some(self.model.state(&only.next)?),
                [only] if matches!(only.action, Action::Draw(_, None)) => {
                    self.symbols = true;
                    symbolic_draw(&self.model, before, only)
                }
                _ => break,
            };
            if draws > MOST_DRAWS {
                return Err(Meaningless { why: "it draws for ever in no time".into() });
            }
        }
        let Some(settled) = settled else {
            let unknown = self.unknown();
            self.places.insert(state, unknown);
            return Ok(unknown);
        };
        let place = match self.places.get(&settled) {
            Some(place) => *place,
            None => {
                self.states.push(settled.clone());
                self.seen.push(None);
                self.places.insert(settled, self.states.len() - 1);
                self.states.len() - 1
            }
        };
        self.places.insert(state, place);
        Ok(place)
    }

    fn is_blurred(&self, state: &State) -> bool {
        self.symbols && state.holds_drawn()
    }

    /// The place of a state of which nothing is known.
    fn unknown(&mut self) -> usize {
        if let Some(place) = self.unknown {
            return place;
        }
        let place = self.states.len();
        self.states.push(State::Aborted);
        self.seen.push(Some(Rc::new(Seen::unknown())));
        *self.unknown.insert(place)
    }

    /// The place of the state after a move or some time; unknown where it depends on a value that is not known.
    fn settled(&mut self, blurred: bool, after: Result<State, Meaningless>) -> Result<usize, Meaningless> {
        match after {
            Ok(state) => self.place(state),
            Err(_) if blurred => Ok(self.unknown()),
            Err(why) => Err(why),
        }
    }

    /// The place of the state after this time.
    pub(super) fn passed(&mut self, seen: &Seen, time: &BigRational) -> Result<usize, Meaningless> {
        self.settled(seen.blurred, self.model.pass(&seen.state, time))
    }

    pub(super) fn seen(&mut self, place: usize) -> Result<Rc<Seen>, Meaningless> {
        if let Some(seen) = &self.seen[place] {
            return Ok(seen.clone());
        }
        let state = self.states[place].clone();
        let blurred = self.is_blurred(&state);
        let steps = match state.moves() {
            Err(_) if blurred => return Ok(Rc::new(Seen::unknown())),
            steps => steps?,
        };
        let patience = state.patience(&steps);
        let offers = steps.iter().any(|step| matches!(step.action, Action::In(_) | Action::Out(..)));
        let mut moves: BTreeMap<Key, Vec<(Label, usize)>> = BTreeMap::new();
        let mut chances = Vec::new();
        for step in steps {
            let mut add = |game: &mut Self, value: Option<&Value>| -> Result<(), Meaningless> {
                let next = value.map_or_else(|| step.next.clone(), |value| step.with(value));
                let to = game.settled(blurred, game.model.state(&next))?;
                if let Action::Draw(_, Some((_, chance))) = &step.action {
                    chances.push((chance.clone(), to));
                    return Ok(());
                }
                let label = Label::Act(step.action.clone(), value.cloned());
                let key = if matches!(step.action, Action::Tau(..)) { Key::Tau } else { Key::Act(label.clone()) };
                let targets = moves.entry(key).or_default();
                if !targets.iter().any(|(_, other)| *other == to) {
                    targets.push((label, to));
                }
                Ok(())
            };
            if step.needs_value() {
                for value in &self.reach.inputs {
                    add(self, Some(value))?;
                }
            } else {
                add(self, None)?;
            }
        }
        let chances = if chances.is_empty() { chances } else { self.spread(chances)? };
        let shown = state.observations();
        let seen = Rc::new(Seen { state, shown, moves, patience, offers, chances, blurred });
        self.seen[place] = Some(seen.clone());
        Ok(seen)
    }

    pub(super) fn pair(&mut self, left: usize, right: usize) -> usize {
        if let Some(place) = self.pair_places.get(&(left, right)) {
            return *place;
        }
        let place = self.pairs.len();
        self.pairs.push(((left, right), Pair::Open));
        self.before.push(Vec::new());
        self.marks.push(None);
        self.pair_places.insert((left, right), place);
        place
    }

    fn look(&mut self, left: usize, right: usize) -> Result<Pair, Meaningless> {
        let (one, two) = (self.seen(left)?, self.seen(right)?);
        if !one.chances.is_empty() || !two.chances.is_empty() {
            let whole = |seen: &Seen, place| match seen.chances.is_empty() {
                true => vec![(BigRational::one(), place)],
                false => seen.chances.clone(),
            };
            let (rows, columns) = (whole(&one, left), whole(&two, right));
            let mut pairs = Vec::new();
            for (_, row) in &rows {
                for (_, column) in &columns {
                    pairs.push(self.pair(*row, *column));
                }
            }
            return Ok(Pair::Lottery(pairs));
        }
        if left == right {
            self.sweep(left)?;
            return Ok(Pair::Choice(Vec::new()));
        }
        let blurred = one.blurred || two.blurred;
        self.undecided |= blurred;
        if [left, right].into_iter().any(|place| Some(place) == self.unknown) {
            return Ok(Pair::Choice(Vec::new()));
        }
        if let Some(difference) = difference(&one, &two, self.refines) {
            return Ok(Pair::Apart(Box::new(difference)));
        }
        let mut challenges = Vec::new();
        for (key, targets) in &one.moves {
            let answers = two.answers(key);
            self.challenge(Side::Left, targets, &answers, &mut challenges);
            if !blurred && (targets.len() > 1 || answers.len() > 1) {
                self.challenge(Side::Right, &answers, targets, &mut challenges);
            }
        }
        for (key, targets) in two.moves.iter().filter(|_| blurred) {
            self.challenge(Side::Right, targets, &one.answers(key), &mut challenges);
        }
        if let Some(time) = self.slice(&one, &two) {
            let (after_one, after_two) = self.both_passed(&one, &two, &time)?;
            let answers = vec![self.pair(after_one, after_two)];
            challenges.push(Challenge { side: Side::Both, label: Label::Wait(time), answers });
        }
        Ok(Pair::Choice(challenges))
    }

    fn challenge(
        &mut self,
        side: Side,
        targets: &[(Label, usize)],
        answers: &[(Label, usize)],
        all: &mut Vec<Challenge>,
    ) {
        for (label, target) in targets {
            let answers = answers
                .iter()
                .map(|(_, answer)| match side {
                    Side::Right => self.pair(*answer, *target),
                    _ => self.pair(*target, *answer),
                })
                .collect();
            all.push(Challenge { side, label: label.clone(), answers });
        }
    }

    /// How long to wait next, if time changes anything.
    fn slice(&self, one: &Seen, two: &Seen) -> Option<BigRational> {
        let event = match (&one.patience, &two.patience) {
            (Patience::None, _) | (_, Patience::None) => return None,
            (Patience::Until(one), Patience::Until(two)) => one.min(two).clone(),
            (Patience::Until(time), _) | (_, Patience::Until(time)) => time.clone(),
            (Patience::Unbounded, Patience::Unbounded) => return None,
        };
        let meanwhile = || match &self.unit {
            Some(unit) => region::next([&one.state, &two.state], unit),
            None => self.grain.clone(),
        };
        Some(if one.offers || two.offers { event.min(meanwhile()) } else { event })
    }

    /// Marks the pairs that differ, those after the fewest steps first.
    fn mark(&mut self) {
        let mut level: Vec<usize> = Vec::new();
        for place in 0..self.pairs.len() {
            if matches!(self.pairs[place].1, Pair::Apart(_)) {
                self.marks[place] = Some(Mark { rank: 0, challenge: 0 });
                level.push(place);
            }
        }
        let mut rank = 0;
        while !level.is_empty() && self.marks[0].is_none() {
            rank += 1;
            let candidates: BTreeSet<usize> = level.iter().flat_map(|place| self.before[*place].clone()).collect();
            let found: Vec<(usize, usize)> = candidates
                .into_iter()
                .filter(|place| self.marks[*place].is_none())
                .filter_map(|place| Some((place, self.lost(place)?)))
                .collect();
            level = found.iter().map(|(place, _)| *place).collect();
            for (place, challenge) in found {
                self.marks[place] = Some(Mark { rank, challenge });
            }
        }
    }

    /// The challenge that this pair has no answer to, if there is one.
    fn lost(&self, place: usize) -> Option<usize> {
        match &self.pairs[place].1 {
            Pair::Choice(challenges) => challenges
                .iter()
                .position(|challenge| challenge.answers.iter().all(|answer| self.marks[*answer].is_some())),
            Pair::Lottery(pairs) => self.unbalanced(place, pairs).then_some(0),
            _ => None,
        }
    }

    /// The shortest separation of the first pair, against the other side's best answers.
    fn run(&self) -> Run {
        let mut steps = Vec::new();
        let mut place = 0;
        loop {
            match (&self.pairs[place].1, self.marks[place]) {
                (Pair::Apart(difference), _) => return Run { steps, difference: (**difference).clone() },
                (Pair::Choice(challenges), Some(mark)) => {
                    let challenge = &challenges[mark.challenge];
                    let rank = |place: usize| self.marks[place].map_or(0, |mark| mark.rank);
                    let best = challenge.answers.iter().copied().max_by_key(|answer| rank(*answer));
                    place = best.unwrap_or(place);
                    let (left, right) = self.pairs[place].0;
                    steps.push(Step {
                        side: challenge.side,
                        label: challenge.label.clone(),
                        left: self.states[left].clone(),
                        right: self.states[right].clone(),
                    });
                }
                _ => {
                    let (left, right) = self.pairs[place].0;
                    let named = |place| {
                        let chances = self.chances(place).into_iter();
                        chances.map(|(chance, place)| (chance, self.states[place].clone())).collect()
                    };
                    return Run { steps, difference: Difference::Chances(named(left), named(right)) };
                }
            }
        }
    }
}

impl Seen {
    /// A state of which nothing is known.
    fn unknown() -> Seen {
        let (shown, moves) = (BTreeSet::new(), BTreeMap::new());
        let (patience, chances) = (Patience::None, Vec::new());
        Seen { state: State::Aborted, shown, moves, patience, offers: false, chances, blurred: true }
    }

    /// Where the moves lead that may be alike.
    fn answers(&self, key: &Key) -> Vec<(Label, usize)> {
        match self.moves.get(key) {
            Some(answers) if !self.blurred => answers.clone(),
            _ => self.moves.iter().filter(|(other, _)| alike(other, key)).flat_map(|(_, to)| to.clone()).collect(),
        }
    }
}

impl Pair {
    fn pairs(&self) -> Vec<usize> {
        match self {
            Pair::Choice(challenges) => distinct(challenges.iter().flat_map(|challenge| challenge.answers.clone())),
            Pair::Lottery(pairs) => distinct(pairs.iter().copied()),
            _ => Vec::new(),
        }
    }
}
