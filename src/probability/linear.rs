//! Rounds that are one linear map with independent noise: mean, variance and covariance as closed forms in the number
//! of rounds, and the chance at a time in as many steps as that number has binary digits.

mod passages;
mod precise;

pub(super) use passages::closer;

use num_rational::BigRational;
use num_traits::{One, Signed, ToPrimitive, Zero};

use super::chain::{Chain, Linear, Move, Region, add_product};
use super::{Enclosed, Question};
use crate::assumption::Assumptions;
use crate::closed_form::{Recurrence, Sequence, Solved};
use crate::distribution::Distribution;
use crate::elimination;
use crate::interval::{Interval, normal_between};
use crate::name::Name;
use crate::rational::{product, quotient};
use crate::recurrence::solve_all;
use crate::value::{Relation, Value};

/// Linear forms of the state that are followed.
const MOST_FORMS: usize = 4;
/// A chance that machine numbers tell less closely, or in proportion to it, is found with more digits.
const NARROW: (f64, f64) = (1e-12, 1e-6);

/// What is shown, round by round: linear forms of the state with their moments.
#[derive(Clone, Debug)]
pub struct Moments {
    /// What the forms are called; those that are not shown have no name of their own.
    names: Vec<Name>,
    /// What the mean of each becomes: factors of all means, and what is added.
    means: Vec<Vec<BigRational>>,
    /// The covariances of the noise of a round.
    noise: Vec<Vec<BigRational>>,
    /// The means at the start, and the covariances.
    start: (Vec<BigRational>, Vec<Vec<BigRational>>),
    /// Whether all noise is normal.
    normal: bool,
    /// When what is asked for is shown: over the first form.
    asked: Option<Vec<Between>>,
    /// How many rounds have passed at the time asked for.
    rounds: u64,
    /// The same in machine numbers.
    machine: Machine,
}

/// Maps of means and of covariances with where they start, and ranges, in intervals of machine numbers.
#[derive(Clone, Debug)]
struct Machine {
    means: (Matrix, Vec<Interval>),
    covariances: (Matrix, Vec<Interval>),
    asked: Vec<(Interval, Interval)>,
}

/// Ends of a range.
type Between = (Option<BigRational>, Option<BigRational>);

/// The moments of what is shown at a time.
///
/// # Errors
/// What keeps a round from being one linear map.
pub fn moments(chain: &Chain, question: &Question) -> Result<Moments, String> {
    let (start, round) = match (chain.initial.as_slice(), question.first) {
        (_, true) => return Err("a first passage is no linear question".to_string()),
        ([start], false) if start.tests.is_empty() && start.stretches.is_empty() => {
            let phase = start.next.and_then(|phase| Some((phase, chain.phases.get(phase)?.as_slice())));
            match phase {
                Some((phase, [round])) if round.tests.is_empty() && round.next == Some(phase) => (start, round),
                _ => return Err("a round is not one linear map".to_string()),
            }
        }
        _ => return Err("a round is not one linear map".to_string()),
    };
    let [stretch] = round.stretches.as_slice() else { return Err("a round has more than one stretch".to_string()) };
    let duration = stretch.duration.clone().filter(Signed::is_positive).ok_or("a round takes no time")?;
    let rounds = (&question.time / &duration).floor().to_integer().to_u64().ok_or("there are too many rounds")?;
    if stretch.values.is_empty() || stretch.values.len() != question.names.len() {
        return Err("nothing is shown that has a name".to_string());
    }
    let phase = round.next.unwrap_or_default();
    let mut forms: Vec<Linear> = Vec::new();
    for value in &stretch.values {
        if value.draws.iter().any(|factor| !factor.is_zero()) {
            return Err("what is shown depends on what is drawn later".to_string());
        }
        forms.push(value.clone());
    }
    let mut names = question.names.clone();
    let mut means = Vec::new();
    let mut place = 0;
    while let Some(form) = forms.get(place).cloned() {
        let after = form.after(&round.image);
        let row = match combination(&forms, &after.state) {
            Some(factors) => factors,
            None => {
                let (state, name) =
                    further(&forms, &after.state, chain.variables.get(phase).map_or(&[], Vec::as_slice));
                let name = name.filter(|name| !names.contains(name));
                names.push(name.unwrap_or_else(|| Name::new(&format!("rest{}", forms.len() + 1))));
                forms.push(Linear { state, ..Linear::default() });
                combination(&forms, &after.state).ok_or("the forms do not fit together")?
            }
        };
        if forms.len() > MOST_FORMS {
            return Err(format!("more than {MOST_FORMS} combinations of the state matter"));
        }
        means.push((row, after));
        place += 1;
    }
    let after: Vec<Linear> = means.iter().map(|(_, after)| after.clone()).collect();
    let rows: Vec<Vec<BigRational>> =
        means.into_iter().map(|(row, after)| mean_row(row, &after, round, &forms)).collect();
    let first: Vec<Linear> = forms.iter().map(|form| form.after(&start.image)).collect();
    let begun: (Vec<BigRational>, Vec<Vec<BigRational>>) =
        (first.iter().map(|form| mean(form, start)).collect(), covariances(&first, start));
    let draws = || start.draws.iter().chain(&round.draws);
    let normal = draws().all(|draw| draw.normals().is_some_and(|parts| parts.len() == 1));
    let asked = asked(&stretch.shown, &forms[0]);
    let noise = covariances(&after, round);
    let machine = Machine::new(&rows, &noise, &begun, asked.as_deref().unwrap_or_default());
    Ok(Moments { names, means: rows, noise, start: begun, normal, asked, rounds, machine })
}

/// What forms lack for another to be a combination of them: one variable where that is enough, with its name, or else all
/// that the other is made of.
fn further(forms: &[Linear], state: &[BigRational], variables: &[Name]) -> (Vec<BigRational>, Option<Name>) {
    let alone = |place: usize| {
        let one = (0..state.len()).map(|other| if other == place { BigRational::one() } else { BigRational::zero() });
        let one: Vec<BigRational> = one.collect();
        let with = [forms, &[Linear { state: one.clone(), ..Linear::default() }]].concat();
        combination(&with, state).map(|_| (one, variables.get(place).cloned()))
    };
    let places = (0..state.len()).filter(|place| !state[*place].is_zero());
    places.into_iter().find_map(alone).unwrap_or_else(|| (state.to_vec(), None))
}

/// The factors with which the state parts of forms add up to another.
pub(super) fn combination(forms: &[Linear], state: &[BigRational]) -> Option<Vec<BigRational>> {
    let width = forms.iter().map(|form| form.state.len()).chain([state.len()]).max()?;
    let entry = |numbers: &[BigRational], place: usize| numbers.get(place).cloned().unwrap_or_default();
    // One equation for each variable of the state, solved by elimination.
    let equation = |place: usize| {
        let left = forms.iter().map(|form| entry(&form.state, place));
        left.chain([entry(state, place)]).collect::<Vec<BigRational>>()
    };
    elimination::combination((0..width).map(equation).collect(), forms.len())
}

/// The factors of all means, and what is added: the forms' constants count in the means.
fn mean_row(mut row: Vec<BigRational>, after: &Linear, round: &Move, forms: &[Linear]) -> Vec<BigRational> {
    row.resize(forms.len(), BigRational::zero());
    let noise = Linear { state: Vec::new(), ..after.clone() };
    let mut added = mean(&noise, round);
    for (factor, form) in row.iter().zip(forms) {
        add_product(&mut added, factor, &-&form.constant);
    }
    row.push(added);
    row
}

fn mean(form: &Linear, one: &Move) -> BigRational {
    let mut sum = form.constant.clone();
    for (factor, draw) in form.draws.iter().zip(&one.draws).filter(|(factor, _)| !factor.is_zero()) {
        add_product(&mut sum, factor, &draw.mean());
    }
    sum
}

fn covariances(forms: &[Linear], one: &Move) -> Vec<Vec<BigRational>> {
    let variances: Vec<BigRational> = one.draws.iter().map(Distribution::variance).collect();
    let inner = |left: &Linear, right: &Linear| {
        let mut sum = BigRational::zero();
        for ((left, right), variance) in left.draws.iter().zip(&right.draws).zip(&variances) {
            if !left.is_zero() && !right.is_zero() {
                add_product(&mut sum, &product(left, right), variance);
            }
        }
        sum
    };
    forms.iter().map(|left| forms.iter().map(|right| inner(left, right)).collect()).collect()
}

/// Where the first form must lie, if that is all that is asked.
fn asked(region: &Region, form: &Linear) -> Option<Vec<Between>> {
    let mut all = Vec::new();
    for sides in region {
        let mut range: Between = (None, None);
        for side in sides {
            let ratio = super::axes::ratio(&form.state, &side.form.state)?;
            if side.form.draws.iter().any(|factor| !factor.is_zero()) {
                return None;
            }
            let bound = &form.constant - quotient(&side.form.constant, &ratio);
            let above = match side.relation {
                Relation::Gtr | Relation::Gte => !ratio.is_negative(),
                Relation::Lss | Relation::Lte => ratio.is_negative(),
                _ => return None,
            };
            let end = if above { &mut range.0 } else { &mut range.1 };
            let old = end.take();
            *end = Some(match old {
                Some(old) if above => old.max(bound),
                Some(old) => old.min(bound),
                None => bound,
            });
        }
        all.push(range);
    }
    Some(all)
}

impl Moments {
    /// Means, variances and covariances as closed forms in the number of rounds n, proved by induction.
    ///
    /// # Errors
    /// When none are found.
    pub fn solved(&self) -> Result<Solved, String> {
        let count = self.names.len();
        let term = |name: &Name| Value::variable(&crate::closed_form::term(name, &index(), 0));
        let sum = |parts: &mut dyn Iterator<Item = (BigRational, Value)>, added: &BigRational| {
            let zero = Ok(Value::rational(added.clone()));
            parts
                .filter(|(factor, _)| !factor.is_zero())
                .fold(zero, |sum: Result<Value, _>, (factor, value)| sum?.add(&Value::rational(factor).mul(&value)?))
        };
        let mut sequences = Vec::new();
        for (place, row) in self.means.iter().enumerate() {
            let mut parts = (0..count).map(|other| (row[other].clone(), term(&self.mean_name(other))));
            let next = sum(&mut parts, &row[count]).map_err(|error: crate::value::ValueError| error.0)?;
            let start = vec![Value::rational(self.start.0[place].clone())];
            sequences.push(Sequence { name: self.mean_name(place), start, next });
        }
        for (one, other) in pairs(count) {
            let part = |(left, right): (usize, usize)| {
                let factor = &self.means[one][left] * &self.means[other][right];
                (factor, term(&self.covariance_name(left.min(right), left.max(right))))
            };
            let all = (0..count).flat_map(|left| (0..count).map(move |right| (left, right)));
            let next = sum(&mut all.map(part), &self.noise[one][other]).map_err(|error| error.0)?;
            let start = vec![Value::rational(self.start.1[one][other].clone())];
            sequences.push(Sequence { name: self.covariance_name(one, other), start, next });
        }
        let recurrence = Recurrence { index: index(), from: 0, sequences };
        solve_all(recurrence, &Assumptions::default()).map_err(|error| error.reason)
    }

    fn mean_name(&self, place: usize) -> Name {
        Name::new(&format!("mean_{}", self.names[place]))
    }

    fn covariance_name(&self, one: usize, other: usize) -> Name {
        match one == other {
            true => Name::new(&format!("variance_{}", self.names[one])),
            false => Name::new(&format!("covariance_{}_{}", self.names[one], self.names[other])),
        }
    }

    /// How many rounds have passed at the time asked for.
    pub fn rounds(&self) -> u64 {
        self.rounds
    }

    /// Mean and variance of what is shown first, after so many rounds.
    pub fn at(&self, rounds: u64) -> (Interval, Interval) {
        let Machine { means, covariances, .. } = &self.machine;
        (power(&means.0, &means.1, rounds), power(&covariances.0, &covariances.1, rounds))
    }

    /// The chance at the time asked for.
    ///
    /// # Errors
    /// Where the noise is not normal, or more than what is shown first is asked for.
    pub fn chance(&self) -> Result<Enclosed, String> {
        if !self.normal {
            return Err("what is drawn is not normal".to_string());
        }
        if self.asked.is_none() {
            return Err("what is asked for depends on more than one random number".to_string());
        }
        let (mean, variance) = self.at(self.rounds);
        let first = self.chance_with(mean, variance);
        if let Some(found) = first.filter(is_narrow) {
            return Ok(Enclosed::within(found));
        }
        let (mean, variance) = self.precisely(self.rounds);
        let found = self.chance_with(mean, variance).or(first);
        found
            .map(Enclosed::within)
            .ok_or_else(|| "the variance is too small or too large for machine numbers".to_string())
    }

    fn chance_with(&self, mean: Interval, variance: Interval) -> Option<Interval> {
        let add = |sum: Interval, range: &(Interval, Interval)| Some(sum.plus(in_range(*range, mean, variance)?));
        let total = self.machine.asked.iter().try_fold(Interval::exactly(0.0), add)?;
        Some(total.probability())
    }

    /// Mean and variance of what is shown first, after so many rounds, with many more digits than machine numbers have.
    fn precisely(&self, rounds: u64) -> (Interval, Interval) {
        let covariances: Vec<Vec<BigRational>> = covariance_rows(&self.means, &self.noise);
        let spreads: Vec<BigRational> =
            pairs(self.names.len()).map(|(one, other)| self.start.1[one][other].clone()).collect();
        let mean = precise::power(&self.means, &self.start.0, rounds);
        let variance = precise::power(&covariances, &spreads, rounds);
        match (mean, variance) {
            (Some(mean), Some(variance)) => (mean, variance),
            _ => self.at(rounds),
        }
    }
}

impl Machine {
    fn new(
        means: &[Vec<BigRational>],
        noise: &[Vec<BigRational>],
        start: &(Vec<BigRational>, Vec<Vec<BigRational>>),
        asked: &[Between],
    ) -> Machine {
        let interval = |numbers: &[BigRational]| numbers.iter().map(Interval::of).collect::<Vec<Interval>>();
        let end = |end: &Option<BigRational>, other: f64| end.as_ref().map_or(Interval::exactly(other), Interval::of);
        let holds = |(low, high): &&Between| low.as_ref().zip(high.as_ref()).is_none_or(|(low, high)| low < high);
        let range = |(low, high): &Between| (end(low, f64::NEG_INFINITY), end(high, f64::INFINITY));
        let spreads = pairs(means.len()).map(|(one, other)| Interval::of(&start.1[one][other])).collect();
        Machine {
            means: (means.iter().map(|row| interval(row)).collect(), interval(&start.0)),
            covariances: (covariance_rows(means, noise).iter().map(|row| interval(row)).collect(), spreads),
            asked: asked.iter().filter(holds).map(range).collect(),
        }
    }
}

fn is_narrow(chance: &Interval) -> bool {
    let width = chance.high - chance.low;
    width <= NARROW.0 && width <= NARROW.1 * chance.high
}

/// What the covariances become: for each pair of forms the factors of those of all pairs, and what is added.
fn covariance_rows(means: &[Vec<BigRational>], noise: &[Vec<BigRational>]) -> Vec<Vec<BigRational>> {
    let row = |(one, other): (usize, usize)| {
        let factor = |(left, right): (usize, usize)| {
            let mut whole = BigRational::zero();
            add_product(&mut whole, &means[one][left], &means[other][right]);
            if left != right {
                add_product(&mut whole, &means[one][right], &means[other][left]);
            }
            whole
        };
        pairs(means.len()).map(factor).chain([noise[one][other].clone()]).collect()
    };
    pairs(means.len()).map(row).collect()
}

/// The chance of a range of a normal number; none where its variance is too small or too large for machine numbers.
fn in_range((low, high): (Interval, Interval), mean: Interval, variance: Interval) -> Option<Interval> {
    if variance.low <= 0.0 || !variance.high.is_finite() || !mean.low.is_finite() || !mean.high.is_finite() {
        return None;
    }
    let spread = variance.root();
    let place = |bound: Interval| match bound.low.is_infinite() && bound.high.is_infinite() {
        true => bound,
        false => bound.minus(mean).over(spread),
    };
    Some(normal_between(place(low), place(high)).probability())
}

fn index() -> Name {
    Name::new("n")
}

fn pairs(count: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..count).flat_map(move |one| (one..count).map(move |other| (one, other)))
}

type Matrix = Vec<Vec<Interval>>;

/// Factors that are smaller count as all of this size: numbers next to 0 are slow.
const TINY: Interval = Interval { low: -1e-150, high: 1e-150 };

/// The first number of a state after an affine map, given by its rows of factors and what is added, applied so many times.
fn power(map: &Matrix, state: &[Interval], mut times: u64) -> Interval {
    let size = state.len();
    let (mut state, mut after) = (state.to_vec(), state.to_vec());
    let mut now: Vec<Interval> = map.concat();
    let mut square = now.clone();
    while times > 0 {
        if times % 2 == 1 {
            for (row, number) in now.chunks_exact(size + 1).zip(&mut after) {
                *number =
                    row.iter().zip(&state).fold(row[size], |sum, (factor, number)| sum.plus(factor.times(*number)));
            }
            std::mem::swap(&mut state, &mut after);
        }
        times /= 2;
        if times > 0 {
            squared(&now, size, &mut square);
            std::mem::swap(&mut now, &mut square);
        }
    }
    state.first().copied().unwrap_or(NOTHING)
}

const NOTHING: Interval = Interval::exactly(0.0);

/// An affine map applied twice.
fn squared(map: &[Interval], size: usize, square: &mut [Interval]) {
    for (row, sums) in map.chunks_exact(size + 1).zip(square.chunks_exact_mut(size + 1)) {
        sums.fill(NOTHING);
        sums[size] = row[size];
        let factors = row[..size].iter().zip(map.chunks_exact(size + 1));
        for (factor, other) in factors.filter(|(factor, _)| **factor != NOTHING) {
            sums.iter_mut().zip(other).for_each(|(sum, number)| *sum = sum.plus(factor.times(*number)));
        }
        let tiny = |sum: &&mut Interval| **sum != NOTHING && sum.low >= TINY.low && sum.high <= TINY.high;
        sums[..size].iter_mut().filter(tiny).for_each(|sum| *sum = TINY);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_form_is_a_combination_of_others() {
        let whole = |number: i64| BigRational::from_integer(number.into());
        let form = |state: &[i64]| Linear { state: state.iter().map(|n| whole(*n)).collect(), ..Linear::default() };
        let forms = [form(&[1, 0, 2]), form(&[0, 1, -1])];
        assert_eq!(combination(&forms, &form(&[3, -2, 8]).state), Some(vec![whole(3), whole(-2)]));
        assert_eq!(combination(&forms, &form(&[3, -2, 7]).state), None);
        assert_eq!(combination(&forms, &[]), Some(vec![BigRational::zero(), BigRational::zero()]));
    }
}
