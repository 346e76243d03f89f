//! The part of a run that goes round for ever: every turn leads to where the next begins, with what moves on.

use std::collections::BTreeSet;

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use super::shape::{alike, joined};
use super::{Follower, Lost, items, lost};
use crate::advance::stretch;
use crate::assumption::Assumptions;
use crate::law::Condition;
use crate::name::Name;
use crate::proof::{Lemma, Moving, Statement, Step, StepId, carried_on};
use crate::scope::{bound_names, metavariables, read_names};
use crate::substitution::{Substitution, substitute_values};
use crate::term::{Node, Term};
use crate::value::{Relation, Value, ValueError};

/// The bits behind the point of the ends of an interval.
const MOST_BITS: usize = 256;

/// An interval that three values in turn stay in, if they go on as they began: towards a limit, by a fixed factor.
fn interval(numbers: &[BigRational; 3]) -> Option<(BigRational, BigRational)> {
    let factor = factor(numbers)?;
    if factor.abs() >= BigRational::one() {
        return None;
    }
    let step = &numbers[2] - &numbers[1];
    let next = &numbers[2] + &step * &factor;
    let limit = &numbers[2] + &step * &factor / (BigRational::one() - &factor);
    let all = [&numbers[2], &next, &limit];
    Some(((*all.iter().min()?).clone(), (*all.iter().max()?).clone()))
}

/// The same of numbers with roots, between rational ends a little outside.
pub fn interval_around(numbers: &[Value; 3]) -> Option<(BigRational, BigRational)> {
    let near = |number: &Value| {
        number.as_rational().or_else(|| number.enclosure().map(|(low, high)| (low + high) / BigInt::from(2)))
    };
    let rationals = [near(&numbers[0])?, near(&numbers[1])?, near(&numbers[2])?];
    let (low, high) = interval(&rationals)?;
    if numbers.iter().all(|number| number.as_rational().is_some()) {
        return Some((low, high));
    }
    // A fixed factor that is less than 1 leads from a little outside to less outside.
    let margin = (&high - &low) * BigRational::new(BigInt::one(), BigInt::from(64));
    let grid = (0..MOST_BITS).map(|bits| BigInt::one() << bits).find(|grid| &margin * grid >= BigRational::one())?;
    let down = ((low - &margin) * &grid).floor() / &grid;
    let up = ((high + &margin) * &grid).ceil() / &grid;
    Some((down, up))
}

/// The place on whose two sides three values in turn lie, ever farther from it or as far: none comes to it.
fn leaping(numbers: &[BigRational; 3]) -> Option<BigRational> {
    let factor = factor(numbers).filter(|factor| *factor <= -BigRational::one())?;
    Some(&numbers[0] + (&numbers[1] - &numbers[0]) / (BigRational::one() - factor))
}

/// How much larger the second of two steps is.
fn factor(numbers: &[BigRational; 3]) -> Option<BigRational> {
    let (before, step) = (&numbers[1] - &numbers[0], &numbers[2] - &numbers[1]);
    if before.is_zero() || step.is_zero() { None } else { Some(step / before) }
}

/// The values with which what follows starts, by their names, taken off the end of a run.
pub(super) fn starts(parts: &mut Vec<Term>) -> Vec<(Name, Value)> {
    let mut starts = Vec::new();
    while let Some(Node::Set(value, name)) = parts.last().map(Term::node) {
        starts.push((name.clone(), value.clone()));
        parts.pop();
    }
    starts.reverse();
    starts
}

/// A turn as the run writes it, and under the names of what moves the values of the next one.
pub(super) struct Turn {
    parts: Vec<Term>,
    nexts: Vec<Value>,
}

impl Turn {
    /// One that carries no values on.
    pub(super) fn plain(parts: Vec<Term>) -> Turn {
        Turn { parts, nexts: Vec::new() }
    }

    fn of(body: &Term, names: usize) -> Result<Turn, Lost> {
        let mut parts = items(body);
        let mut nexts: Vec<Value> = if names == 0 { Vec::new() } else { values_of(starts(&mut parts)) };
        // Of several, the images first.
        if names > 1 {
            nexts.truncate(nexts.len() / 2);
        }
        if nexts.len() == names { Ok(Turn { parts, nexts }) } else { lost("what moves on is not carried on") }
    }
}

fn values_of(sets: Vec<(Name, Value)>) -> Vec<Value> {
    sets.into_iter().map(|(_, value)| value).collect()
}

/// The values at one place in three turns, one after the other.
type Three = [Value; 3];
/// What moves: its name, where it begins, and its first three values.
type Followed = (Name, Value, Three);

/// The number of a value in a state, and of a component in it if that is what is meant.
type Place = (usize, Option<usize>);

/// What moves on, in which three turns it was seen, and what is supposed of it.
struct Base {
    moving: Moving,
    seen: Three,
    /// Where the value stands by itself in the states, if it is no value of the run.
    place: Option<Place>,
}

fn odd(error: ValueError) -> Lost {
    Lost(error.0)
}

impl Follower<'_> {
    /// Another one, for a lemma.
    pub(super) fn within<'h>(&'h self, hypotheses: &'h [Condition]) -> Follower<'h> {
        Follower { forgets: self.forgets, ..Follower::new(self.theory, hypotheses, true) }
    }

    /// From `… ~~ (Delay_t # O) ; next`, the same with what the run shows: written as the run writes it, without what it
    /// does not show.
    pub(super) fn showing(
        &mut self,
        step: StepId,
        (time, all): (&Value, &[Term]),
        shown: &[Term],
        next: &Term,
    ) -> Result<StepId, Lost> {
        let whole = stretch(time, all);
        let wanted = Term::seq([stretch(time, shown), next.clone()]);
        let same: BTreeSet<&Term> = shown.iter().collect();
        let more = |one: &&Term| !same.contains(one) && !shown.iter().any(|other| alike(one, other, &self.context));
        let hidden: Vec<Term> = all.iter().filter(more).cloned().collect();
        if hidden.is_empty() || !self.forgets {
            return self.same(step, &Term::seq([whole, next.clone()]), &wanted);
        }
        let kept: Vec<Term> = all.iter().filter(|one| !hidden.contains(one)).cloned().collect();
        let kept = stretch(time, &kept);
        let processes = [(Name::new("?P"), kept.clone()), (Name::new("?O"), Term::disable(hidden))];
        let with = Substitution { processes: processes.into(), ..Substitution::default() };
        let forget = self.script.push(Step::Law(Name::new("forget"), with));
        self.forgot = true;
        let forget = self.before(forget, next);
        let step = self.script.chain(vec![step, forget]);
        self.same(step, &Term::seq([kept, next.clone()]), &wanted)
    }

    /// `X ~~ loop(P)`, or with values that move on from turn to turn.
    pub(super) fn round_and_round(
        &mut self,
        body: &Term,
        starts: &[(Name, Value)],
        state: &Term,
    ) -> Result<StepId, Lost> {
        let turn = Turn::of(body, starts.len())?;
        if starts.is_empty() {
            let (kept, lemmas, forgot) = (self.script.steps.len(), self.lemmas.len(), self.forgot);
            self.forgot = false;
            let (step, next) = self.along(&turn.parts, state.clone())?;
            let plain = !self.forgot;
            self.forgot |= forgot;
            if plain && alike(&next, state, &self.context) {
                let wanted = Term::seq([body.clone(), state.clone()]);
                let equation = self.same(step, &Term::seq([body.clone(), next]), &wanted)?;
                return Ok(self.script.push(Step::UniqueLoop { body: body.clone(), equation }));
            }
            self.script.steps.truncate(kept);
            self.lemmas.truncate(lemmas);
        }
        self.turning(&turn, starts, state)
    }

    /// One turn from anywhere that the turns may begin, as a lemma.
    pub(super) fn turning(&mut self, turn: &Turn, starts: &[(Name, Value)], state: &Term) -> Result<StepId, Lost> {
        let (states, named) = self.three(turn, starts, state)?;
        let (mut bases, general) = self.generalised(&states, named)?;
        let mut hypotheses = self.context.hypotheses.to_vec();
        for base in &bases {
            hypotheses.extend(supposed(base)?);
        }
        hypotheses.extend(in_step(&bases));
        let inner = bases.iter().filter(|base| base.place.is_none());
        let own = inner.map(|base| (base.moving.name.clone(), Value::variable(&base.moving.variable))).collect();
        let parts: Result<Vec<Term>, _> = turn.parts.iter().map(|part| substitute_values(part, &own)).collect();
        let parts = parts.map_err(|stuck| Lost(stuck.0))?;
        let whole = Term::seq(parts.iter().cloned());
        let mut prover = self.within(&hypotheses);
        let (step, found) = prover.along(&parts, general.clone())?;
        let mut places = Vec::new();
        joined(&general, &found, &mut |one, other| {
            places.push(other.clone());
            Some(one.clone())
        })
        .ok_or_else(|| Lost("a turn leads to another state".to_string()))?;
        for base in &mut bases {
            if let Some((place, part)) = base.place {
                let whole = places[place].clone();
                let component = |number| whole.component(number);
                base.moving.next =
                    part.map_or(Some(whole.clone()), component).ok_or_else(|| Lost(format!("{whole} is no vector")))?;
            }
        }
        let nexts = bases.iter().map(|base| (base.moving.variable.clone(), base.moving.next.clone())).collect();
        let next = substitute_values(&general, &nexts).map_err(|stuck| Lost(stuck.0))?;
        let right = Term::seq([whole.clone(), next]);
        prover.same(step, &Term::seq([whole.clone(), found]), &right)?;
        let (connective, forgot, steps) = (prover.connective(), prover.forgot, prover.script.steps);
        self.forgot |= forgot;
        let name = Name::new(&format!("Turn{}", self.lemmas.len() + 1));
        self.lemmas.push(Lemma { name, statement: Statement { hypotheses, left: general, connective, right }, steps });
        let lemma = self.lemmas.len() - 1;
        let moving: Vec<Moving> = bases.into_iter().map(|base| base.moving).collect();
        carried_on(&whole, &moving).map_err(|stuck| Lost(stuck.0))?;
        Ok(self.script.push(Step::Turns { lemma, turn: whole, moving }))
    }

    /// The states at the start of three turns, and the values that the run carries on.
    fn three(&self, turn: &Turn, starts: &[(Name, Value)], state: &Term) -> Result<([Term; 3], Vec<Followed>), Lost> {
        let mut values: Vec<Value> = starts.iter().map(|(_, start)| start.clone()).collect();
        let mut seen = vec![values.clone()];
        let mut states = vec![state.clone()];
        for _ in 0..2 {
            let map = starts.iter().map(|(name, _)| name.clone()).zip(values).collect();
            let parts: Result<Vec<Term>, _> = turn.parts.iter().map(|part| substitute_values(part, &map)).collect();
            let last = states.last().cloned().unwrap_or_else(Term::stop);
            let next = self.within(self.context.hypotheses).along(&parts.map_err(|stuck| Lost(stuck.0))?, last)?.1;
            states.push(next);
            let nexts: Result<Vec<Value>, _> = turn.nexts.iter().map(|next| next.substitute(&map)).collect();
            values = nexts.map_err(odd)?;
            seen.push(values.clone());
        }
        let named = starts.iter().zip(&turn.nexts).enumerate();
        let named = named.map(|(number, ((name, _), next))| {
            let three = [0, 1, 2].map(|turn: usize| seen[turn][number].clone());
            (name.clone(), next.clone(), three)
        });
        let named = named.collect();
        match <[Term; 3]>::try_from(states) {
            Ok(states) => Ok((states, named)),
            Err(_) => lost("no turns were seen"),
        }
    }

    /// The state at the start of any turn, and what moves on in it.
    fn generalised(&self, states: &[Term; 3], named: Vec<(Name, Value, Three)>) -> Result<(Vec<Base>, Term), Lost> {
        let mut all: Vec<Three> = Vec::new();
        let mut later = Vec::new();
        let shape = || Lost("the states at the start of turns differ in more than values".to_string());
        joined(&states[0], &states[2], &mut |one, last| {
            later.push(last.clone());
            Some(one.clone())
        })
        .ok_or_else(shape)?;
        let mut later = later.into_iter();
        joined(&states[0], &states[1], &mut |one, next| {
            all.push([one.clone(), next.clone(), later.next()?]);
            Some(one.clone())
        })
        .ok_or_else(shape)?;
        let mut taken = Taken::of(self, states);
        let carried = !named.is_empty();
        let mut bases = Vec::new();
        for (name, next, seen) in named {
            let variable = taken.variable();
            let own = [(name.clone(), Value::variable(&variable))].into();
            let (start, next) = (seen[0].clone(), next.substitute(&own).map_err(odd)?);
            bases.push(Base { moving: Moving { variable, name, start, next }, seen, place: None });
        }
        let mut values = Vec::with_capacity(all.len());
        for (place, three) in all.into_iter().enumerate() {
            values.push(self.by_bases(&mut bases, three, (place, None), (carried, &mut taken))?);
        }
        let mut values = values.into_iter();
        let general = joined(&states[0], &states[0], &mut |_, _| values.next()).ok_or_else(shape)?;
        Ok((bases, general))
    }

    /// A value in terms of what moves on; if it moves by itself, that is something new which moves.
    fn by_bases(
        &self,
        bases: &mut Vec<Base>,
        three: Three,
        place: Place,
        (carried, taken): (bool, &mut Taken),
    ) -> Result<Value, Lost> {
        let equal = |one: &Value, other: &Value| {
            one == other || self.context.assumptions.decide(Relation::Eq, one, other) == Some(true)
        };
        if equal(&three[0], &three[1]) && equal(&three[1], &three[2]) {
            return Ok(three[0].clone());
        }
        if let [Some(one), Some(two), Some(last)] = [0, 1, 2].map(|turn: usize| three[turn].components()) {
            let parts = one.into_iter().zip(two).zip(last).enumerate();
            let parts = parts.map(|(part, ((one, two), last))| {
                self.by_bases(bases, [one, two, last], (place.0, Some(part)), (carried, taken))
            });
            return Value::vector(parts.collect::<Result<_, _>>()?).map_err(odd);
        }
        let (step, second) = (three[1].sub(&three[0]).map_err(odd)?, three[2].sub(&three[1]).map_err(odd)?);
        for base in bases.iter() {
            let [first, next, last] = &base.seen;
            let (own, after) = (next.sub(first).map_err(odd)?, last.sub(next).map_err(odd)?);
            let Ok(ratio) = step.div(&own) else { continue };
            let fits = after.mul(&ratio).is_ok_and(|wanted| equal(&wanted, &second));
            if fits && (ratio.as_rational().is_some() || own.as_rational().is_some()) {
                let from = Value::variable(&base.moving.variable).sub(first).map_err(odd)?;
                return from.mul(&ratio).and_then(|moved| moved.add(&three[0])).map_err(odd);
            }
        }
        if carried {
            return lost(format!("how {} moves on is not seen", three[0]));
        }
        let (variable, name) = (taken.variable(), taken.name());
        let own = Value::variable(&variable);
        if equal(&step, &second) {
            // So much more in each turn: the number of the turn tells how much.
            let (start, next) = (Value::zero(), own.add(&Value::one()).map_err(odd)?);
            let seen = [Value::zero(), Value::one(), Value::integer(2)];
            bases.push(Base { moving: Moving { variable, name, start, next }, seen, place: None });
            return own.mul(&step).and_then(|moved| moved.add(&three[0])).map_err(odd);
        }
        let (start, next) = (three[0].clone(), own.clone());
        bases.push(Base { moving: Moving { variable, name, start, next }, seen: three, place: Some(place) });
        Ok(own)
    }
}

/// What is supposed of a value in all turns.
fn supposed(base: &Base) -> Result<Vec<Condition>, Lost> {
    let own = Value::variable(&base.moving.variable);
    if base.seen[0].is_zero() && base.seen[1] == Value::one() && base.seen[2] == Value::integer(2) {
        return Ok(vec![Condition::Natural(own)]);
    }
    let [first, next, last] = &base.seen;
    let (Some(one), Some(two), Some(three)) = (first.as_rational(), next.as_rational(), last.as_rational()) else {
        return supposed_of_roots(base);
    };
    let numbers = [one, two, three];
    let compare = |relation, bound: BigRational| Condition::Compare(relation, own.clone(), Value::rational(bound));
    if let Some(centre) = leaping(&numbers) {
        return Ok(vec![compare(Relation::Neq, centre)]);
    }
    if factor(&numbers).is_some_and(|factor| factor >= BigRational::one()) {
        let relation = if numbers[1] > numbers[0] { Relation::Gte } else { Relation::Lte };
        return Ok(vec![compare(relation, numbers[0].clone())]);
    }
    let Some((low, high)) = interval(&numbers) else { return lost(format!("where {first} moves is not seen")) };
    let low = low.min(numbers[0].clone()).min(numbers[1].clone());
    let high = high.max(numbers[0].clone()).max(numbers[1].clone());
    Ok(vec![compare(Relation::Gte, low), compare(Relation::Lte, high)])
}

/// The same of a number with roots: where it moves, and that it has come nearer with each turn.
fn supposed_of_roots(base: &Base) -> Result<Vec<Condition>, Lost> {
    let own = Value::variable(&base.moving.variable);
    let Some((low, high)) = interval_around(&base.seen) else {
        return lost(format!("where {} moves is not known", base.seen[0]));
    };
    let known = Assumptions::default();
    let mut ends = (Value::rational(low), Value::rational(high));
    for number in &base.seen[..2] {
        if known.decide(Relation::Lss, number, &ends.0) == Some(true) {
            ends.0 = number.clone();
        }
        if known.decide(Relation::Gtr, number, &ends.1) == Some(true) {
            ends.1 = number.clone();
        }
    }
    let compare = |relation, bound| Condition::Compare(relation, own.clone(), bound);
    Ok(vec![compare(Relation::Gte, ends.0), compare(Relation::Lte, ends.1)])
}

/// What moves in step with something before it: the one follows from the other, in all turns.
fn in_step(bases: &[Base]) -> Vec<Condition> {
    let with = |one: &Base, other: &Base| -> Option<Condition> {
        let moved = |base: &Base, turn: usize| base.seen[turn + 1].sub(&base.seen[turn]).ok();
        let ratio = moved(one, 0)?.div(&moved(other, 0)?).ok().filter(|ratio| ratio.as_rational().is_some())?;
        if moved(other, 1)?.mul(&ratio).ok()? != moved(one, 1)? {
            return None;
        }
        let from =
            Value::variable(&other.moving.variable).sub(&other.seen[0]).and_then(|from| from.mul(&ratio)).ok()?;
        let wanted = from.add(&one.seen[0]).ok()?;
        Some(Condition::Compare(Relation::Eq, Value::variable(&one.moving.variable), wanted))
    };
    let found = bases.iter().enumerate().map(|(place, one)| bases[..place].iter().find_map(|other| with(one, other)));
    found.flatten().collect()
}

/// Names that may not be used any more.
struct Taken(std::collections::BTreeSet<Name>);

impl Taken {
    fn of(follower: &Follower<'_>, states: &[Term]) -> Taken {
        let definitions = follower.theory.definitions.iter().map(|definition| &definition.body);
        let mut names = follower.context.assumptions.variables();
        for term in states.iter().chain(definitions) {
            names.extend(metavariables(term).into_iter().chain(read_names(term)).chain(bound_names(term)));
        }
        Taken(names)
    }

    fn fresh(&mut self, stem: &str) -> Name {
        let mut name = stem.to_string();
        while !self.0.insert(Name::new(&name)) {
            name.push('n');
        }
        Name::new(&name)
    }

    fn variable(&mut self) -> Name {
        self.fresh("?n")
    }

    fn name(&mut self) -> Name {
        self.fresh("n")
    }
}
