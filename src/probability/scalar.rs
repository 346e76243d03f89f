//! A chain in one dimension: all that a round needs to know of the state is one linear form of it.
//!
//! Noise that is measured and thrown away leaves states of several variables (position, pending command, pending
//! sample) of which only one combination matters. It is found exactly, with rationals.

use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use super::Question;
use super::chain::{Chain, Linear, Move, Region, Side};
use crate::value::Relation;

/// An interval of reals; none stands for no bound.
pub type Range = (Option<BigRational>, Option<BigRational>);

/// What decides a way: a random number `factor * s + offset + noise`, or the next state itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Decider {
    /// Nothing: the way is always taken.
    Nothing,
    /// The next state.
    Next,
    /// A normal number.
    Noisy(Box<Noisy>),
}

/// A normal number `factor * s + offset + noise`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Noisy {
    /// How it depends on the state.
    pub factor: BigRational,
    /// What is added.
    pub offset: BigRational,
    /// The variance of the noise.
    pub variance: BigRational,
    /// Its covariance with the noise of the next state.
    pub covariance: BigRational,
}

/// One way through a round.
#[derive(Clone, Debug)]
pub struct Way {
    /// The chance of this part of the draws.
    pub weight: BigRational,
    /// What decides it.
    pub decider: Decider,
    /// Where the decider leads to what is asked for.
    pub success: Vec<Range>,
    /// Where it leads to what is asked for at the last moment only.
    pub last: Vec<Range>,
    /// Where it goes on.
    pub onward: Vec<Range>,
    /// The next state is `slope * s + shift` and noise of this variance.
    pub slope: BigRational,
    /// What is added.
    pub shift: BigRational,
    /// The variance of the noise.
    pub variance: BigRational,
}

/// A chain in one dimension.
#[derive(Clone, Debug)]
pub struct Scalar {
    /// The ways at the start, where the state is 0.
    pub start: Vec<Way>,
    /// The ways of every round.
    pub round: Vec<Way>,
    /// How many rounds there are.
    pub rounds: u64,
}

/// The chain of one phase in one dimension.
///
/// # Errors
/// What does not fit.
pub fn scalar(chain: &Chain, question: &Question) -> Result<Scalar, String> {
    let live = live_phase(chain)?;
    let moves = chain.phases.get(live).ok_or("a phase is missing")?;
    let duration = duration(moves)?;
    if chain.initial.iter().any(|one| one.next.is_some() && !one.stretches.is_empty()) {
        return Err("time passes before the first round".to_string());
    }
    let rounds = (&question.time / &duration).floor().to_integer();
    let rounds = num_traits::ToPrimitive::to_u64(&rounds).filter(|rounds| *rounds <= 1_000_000);
    let rounds = rounds.ok_or("there are too many rounds")?;
    let reducer = Reducer { chain, question, live, direction: direction(chain, live, moves)? };
    let all = |moves: &[Move], start: bool| -> Result<Vec<Way>, String> {
        let mut ways = Vec::new();
        for one in moves {
            ways.extend(reducer.ways(one, start)?);
        }
        Ok(ways)
    };
    Ok(Scalar { start: all(&chain.initial, true)?, round: all(moves, false)?, rounds })
}

/// The only phase from which there is a way back to itself.
fn live_phase(chain: &Chain) -> Result<usize, String> {
    let again = |phase: &usize| chain.phases[*phase].iter().any(|one| one.next == Some(*phase));
    let live: Vec<usize> = (0..chain.phases.len()).filter(again).collect();
    match live.as_slice() {
        [one] => Ok(*one),
        _ => Err(format!("{} phases repeat, and one is needed", live.len())),
    }
}

fn duration(moves: &[Move]) -> Result<BigRational, String> {
    let mut found: Option<BigRational> = None;
    for one in moves {
        let stretch = match one.stretches.as_slice() {
            [stretch] => stretch,
            [stretch, rest] if one.next.is_none() && rest.duration.is_none() => stretch,
            _ => return Err("a round has more than one stretch".to_string()),
        };
        let duration = stretch.duration.clone().filter(Signed::is_positive).ok_or("a round takes no time")?;
        if found.as_ref().is_some_and(|other| *other != duration) {
            return Err("the rounds differ in length".to_string());
        }
        found = Some(duration);
    }
    found.ok_or_else(|| "there is no round".to_string())
}

/// The form of the state on which everything depends: that of the first guard, or of what is asked for.
fn direction(chain: &Chain, live: usize, moves: &[Move]) -> Result<Vec<BigRational>, String> {
    let region = shown(chain, live)?;
    let mut forms: Vec<Linear> = Vec::new();
    for one in moves {
        forms.extend(one.tests.iter().map(|side| side.form.clone()));
        if one.next == Some(live) {
            forms.extend(region.iter().flatten().map(|side| side.form.after(&one.image)));
        }
    }
    let found = forms.into_iter().map(|form| form.state).find(|state| state.iter().any(|factor| !factor.is_zero()));
    found.ok_or_else(|| "nothing in a round depends on the state".to_string())
}

/// What is asked for, over the state of a phase.
fn shown(chain: &Chain, phase: usize) -> Result<Region, String> {
    let moves = chain.phases.get(phase).ok_or("a phase is missing")?;
    let mut stretches = moves.iter().filter_map(|one| one.stretches.first());
    let first = stretches.next().map(|stretch| stretch.shown.clone()).unwrap_or_default();
    let drawn = |side: &Side| side.form.draws.iter().any(|factor| !factor.is_zero());
    if first.iter().flatten().any(drawn) {
        return Err("what is shown depends on what is drawn later".to_string());
    }
    Ok(first)
}

struct Reducer<'a> {
    chain: &'a Chain,
    question: &'a Question,
    live: usize,
    direction: Vec<BigRational>,
}

/// A form over the scalar state and the draws.
#[derive(Clone, Debug)]
struct Form {
    factor: BigRational,
    draws: Vec<BigRational>,
    offset: BigRational,
}

impl Reducer<'_> {
    fn ways(&self, one: &Move, start: bool) -> Result<Vec<Way>, String> {
        let mut ways = Vec::new();
        let mut parts: Vec<(BigRational, Vec<(BigRational, BigRational)>)> = vec![(BigRational::one(), Vec::new())];
        for draw in &one.draws {
            let normals = draw.normals().ok_or("what is drawn is neither normal nor a mixture of normals")?;
            let longer = parts.iter().flat_map(|(weight, drawn)| {
                normals.iter().map(move |(share, mean, variance)| {
                    let more = drawn.iter().cloned().chain([(mean.clone(), variance.clone())]).collect();
                    (weight * share, more)
                })
            });
            parts = longer.collect();
            if parts.len() > 64 {
                return Err("a round has too many combinations of draws".to_string());
            }
        }
        for (weight, drawn) in parts {
            ways.extend(self.way(one, weight, &drawn, start)?);
        }
        Ok(ways)
    }

    /// One way with normal draws of these means and variances; none where it is never taken.
    fn way(
        &self,
        one: &Move,
        weight: BigRational,
        drawn: &[(BigRational, BigRational)],
        start: bool,
    ) -> Result<Option<Way>, String> {
        let mut guards = Guards { reducer: self, drawn, start, base: None };
        let onward = one.next == Some(self.live);
        let mut next = Form { factor: BigRational::zero(), draws: Vec::new(), offset: BigRational::zero() };
        let mut region = Region::new();
        if onward {
            let linear = Linear { state: self.direction.clone(), ..Linear::default() };
            next = self.form(&linear.after(&one.image), drawn, start)?;
            region = shown(self.chain, self.live)?;
            for side in region.iter_mut().flatten() {
                side.form = side.form.after(&one.image);
            }
        }
        let Some(taken) = guards.range(&one.tests)? else { return Ok(None) };
        let mut asked = Vec::new();
        for sides in &region {
            asked.extend(guards.range(sides)?);
        }
        let inner = |left: &Form, right: &Form| inner(left, right, drawn);
        let (decider, transform) = self.decider(guards.base, onward.then_some(&next), &inner);
        let image =
            |range: Range| transform.as_ref().map_or(range.clone(), |(ratio, constant)| moved(&range, ratio, constant));
        let taken = image(taken);
        let asked: Vec<Range> = asked.into_iter().filter_map(|range| meet(&taken, &image(range))).collect();
        let (success, last, rest) = if !onward {
            let absorbed = if self.absorbs(one)? { vec![taken] } else { Vec::new() };
            (absorbed.clone(), absorbed, Vec::new())
        } else if self.question.first {
            (asked.clone(), asked.clone(), without(taken, asked))
        } else {
            (Vec::new(), asked, vec![taken])
        };
        let variance = inner(&next, &next);
        Ok(Some(Way { weight, decider, success, last, onward: rest, slope: next.factor, shift: next.offset, variance }))
    }

    /// Whether what a move leads to, outside the rounds, is what is asked for.
    fn absorbs(&self, one: &Move) -> Result<bool, String> {
        match one.next {
            Some(phase) => self.succeeds(phase),
            None => match one.stretches.iter().find(|stretch| stretch.duration.is_none()) {
                Some(stretch) if surely(Some(stretch)) => Ok(true),
                Some(stretch) if !stretch.shown.is_empty() => {
                    Err("what is shown at the end depends on the state".to_string())
                }
                _ => Ok(false),
            },
        }
    }

    /// What decides; with how its values are said over the next state, where it is that.
    fn decider(
        &self,
        base: Option<Form>,
        next: Option<&Form>,
        inner: &impl Fn(&Form, &Form) -> BigRational,
    ) -> (Decider, Option<(BigRational, BigRational)>) {
        let Some(base) = base else { return (Decider::Nothing, None) };
        if let Some(next) = next
            && let Some((ratio, constant)) = multiple(next, &base)
        {
            return (Decider::Next, Some((ratio, constant)));
        }
        let covariance = next.map_or_else(BigRational::zero, |next| inner(next, &base));
        let variance = inner(&base, &base);
        let noisy = Noisy { factor: base.factor, offset: base.offset, variance, covariance };
        (Decider::Noisy(Box::new(noisy)), None)
    }

    fn form(&self, linear: &Linear, drawn: &[(BigRational, BigRational)], start: bool) -> Result<Form, String> {
        let factor = if start { BigRational::zero() } else { self.along(&linear.state)? };
        let means: BigRational = linear.draws.iter().zip(drawn).map(|(factor, (mean, _))| factor * mean).sum();
        let mut draws = linear.draws.clone();
        draws.resize(drawn.len(), BigRational::zero());
        Ok(Form { factor, draws, offset: &linear.constant + means })
    }

    /// The factor by which a form of the state is the one on which everything depends.
    fn along(&self, state: &[BigRational]) -> Result<BigRational, String> {
        let place = self.direction.iter().position(|factor| !factor.is_zero()).unwrap_or(0);
        let zero = BigRational::zero();
        let ratio = state.get(place).unwrap_or(&zero) / self.direction.get(place).unwrap_or(&BigRational::one());
        let fits = |(place, factor): (usize, &BigRational)| state.get(place).unwrap_or(&zero) == &(factor * &ratio);
        if self.direction.iter().enumerate().all(fits) {
            Ok(ratio)
        } else {
            Err("the rounds depend on the state in more than one dimension".to_string())
        }
    }

    /// Whether what is asked for is shown in a phase whatever the state, for good; false if it is never shown again.
    fn succeeds(&self, phase: usize) -> Result<bool, String> {
        let moves = self.chain.phases.get(phase).ok_or("a phase is missing")?;
        let mut certain = !moves.is_empty();
        for other in moves {
            let lasts = other.next.is_none() && other.stretches.last().is_some_and(|last| last.duration.is_none());
            let all = other.stretches.iter().all(|stretch| surely(Some(stretch)));
            let first = self.question.first && surely(other.stretches.first());
            certain &= first || (lasts && all);
        }
        if certain {
            return Ok(true);
        }
        let never = moves
            .iter()
            .all(|other| other.next.is_none() && other.stretches.iter().all(|stretch| stretch.shown.is_empty()));
        if never { Ok(false) } else { Err("what follows the rounds depends on the state".to_string()) }
    }
}

/// The guards of one way, which must all compare multiples of one random number.
struct Guards<'a> {
    reducer: &'a Reducer<'a>,
    drawn: &'a [(BigRational, BigRational)],
    start: bool,
    base: Option<Form>,
}

impl Guards<'_> {
    /// Where the random number must lie for all of these to hold; none if one of them never does.
    fn range(&mut self, sides: &[Side]) -> Result<Option<Range>, String> {
        let mut range: Range = (None, None);
        for side in sides {
            let form = self.reducer.form(&side.form, self.drawn, self.start)?;
            if inner(&form, &form, self.drawn).is_zero() {
                if !form.factor.is_zero() {
                    return Err("a guard depends on the state alone".to_string());
                }
                if !side.relation.holds(form.offset.cmp(&BigRational::zero())) {
                    return Ok(None);
                }
                continue;
            }
            match side.relation {
                Relation::Eq => return Ok(None),
                Relation::Neq => continue,
                _ => {}
            }
            let base = self.base.get_or_insert_with(|| form.clone());
            let parts = multiple(base, &form);
            let (ratio, constant) = parts.ok_or("the guards of a round depend on different random numbers")?;
            narrow(&mut range, side.relation, &ratio, &constant);
        }
        Ok(Some(range))
    }
}

/// The covariance of two forms, for a given state.
fn inner(left: &Form, right: &Form, drawn: &[(BigRational, BigRational)]) -> BigRational {
    left.draws.iter().zip(&right.draws).zip(drawn).map(|((a, b), (_, variance))| a * b * variance).sum()
}

/// Whether a stretch shows what is asked for, whatever the state.
fn surely(stretch: Option<&super::chain::Stretch>) -> bool {
    stretch.is_some_and(|stretch| stretch.shown.iter().any(Vec::is_empty))
}

/// `(r, c)` with `other = r * base + c`.
fn multiple(base: &Form, other: &Form) -> Option<(BigRational, BigRational)> {
    let place = base.draws.iter().position(|factor| !factor.is_zero())?;
    let ratio = &other.draws[place] / &base.draws[place];
    if ratio.is_zero() || other.factor != &ratio * &base.factor {
        return None;
    }
    let fits = base.draws.iter().zip(&other.draws).all(|(one, two)| *two == one * &ratio);
    fits.then(|| (ratio.clone(), &other.offset - &ratio * &base.offset))
}

/// Cuts a range of the base to where `ratio * base + constant REL 0`.
fn narrow(range: &mut Range, relation: Relation, ratio: &BigRational, constant: &BigRational) {
    let bound = -constant / ratio;
    let above = matches!(relation, Relation::Gtr | Relation::Gte) != ratio.is_negative();
    let end = if above { &mut range.0 } else { &mut range.1 };
    if end.as_ref().is_none_or(|old| if above { bound > *old } else { bound < *old }) {
        *end = Some(bound);
    }
}

/// A range of `ratio * x + constant` as a range of x.
fn moved(range: &Range, ratio: &BigRational, constant: &BigRational) -> Range {
    let place = |bound: &Option<BigRational>| bound.as_ref().map(|bound| (bound - constant) / ratio);
    let (low, high) = (place(&range.0), place(&range.1));
    if ratio.is_negative() { (high, low) } else { (low, high) }
}

fn meet(one: &Range, other: &Range) -> Option<Range> {
    let low = match (&one.0, &other.0) {
        (Some(a), Some(b)) => Some(a.max(b).clone()),
        (a, b) => a.clone().or(b.clone()),
    };
    let high = match (&one.1, &other.1) {
        (Some(a), Some(b)) => Some(a.min(b).clone()),
        (a, b) => a.clone().or(b.clone()),
    };
    if low.as_ref().zip(high.as_ref()).is_some_and(|(low, high)| low >= high) { None } else { Some((low, high)) }
}

/// A range without others.
fn without(range: Range, mut others: Vec<Range>) -> Vec<Range> {
    others.sort_by(|a, b| match (&a.0, &b.0) {
        (None, None) => std::cmp::Ordering::Equal,
        (None, _) => std::cmp::Ordering::Less,
        (_, None) => std::cmp::Ordering::Greater,
        (Some(a), Some(b)) => a.cmp(b),
    });
    let mut left = Vec::new();
    let mut rest = Some(range);
    for (low, high) in others {
        let Some(now) = rest.take() else { break };
        if let Some(low) = low {
            left.extend(meet(&now, &(None, Some(low))));
        }
        rest = high.and_then(|high| meet(&now, &(Some(high), None)));
    }
    left.extend(rest);
    left
}
