//! Runs side by side: all that are in one phase at one time take a round together, each number of theirs in a column of its
//! own. They draw the same numbers as one by one, and do the same with them, so that each ends as it would alone.

use std::collections::BTreeMap;
use std::ops::Range;

use super::{Form, MOST_ROUNDS, MOST_WHOLE, Program, Step, TOO_LARGE, Test};
use crate::probability::random::Sources;

/// Runs that are followed together.
pub(in crate::probability) const LANES: u64 = 512;

/// Runs that are in one phase at one time, with the columns of their numbers.
#[derive(Default)]
struct Group {
    runs: Vec<u64>,
    columns: Vec<Vec<f64>>,
}

/// A phase and a time.
type Place = (Option<usize>, u64);

impl Program {
    /// Whether no exact number matters, so that runs may be followed side by side.
    pub(in crate::probability) fn is_plain(&self) -> bool {
        self.initial.iter().chain(self.phases.iter().flatten()).all(|step| !step.exact)
    }

    /// In how many of these runs it happens.
    ///
    /// # Errors
    /// Where a run gets stuck, or never ends.
    pub(in crate::probability) fn count(&self, seed: u64, runs: Range<u64>) -> Result<u64, String> {
        let start = Group { runs: runs.collect(), columns: Vec::new() };
        let mut groups: BTreeMap<Place, Group> = BTreeMap::from([((None, 0), start)]);
        let mut count = 0;
        for round in 0..=MOST_ROUNDS {
            let mut later = BTreeMap::new();
            for (place, group) in groups {
                count += self.turn_all(place, group, (seed, round), &mut later)?;
            }
            groups = later;
            if groups.is_empty() {
                return Ok(count);
            }
        }
        Err(super::TOO_LONG.to_string())
    }

    /// One more round of a group: in how many of its runs it happens, while the others go where they go.
    fn turn_all(
        &self,
        (phase, now): Place,
        mut group: Group,
        (seed, round): (u64, u64),
        later: &mut BTreeMap<Place, Group>,
    ) -> Result<u64, String> {
        let steps = phase.map_or(self.initial.as_slice(), |phase| self.phases[phase].as_slice());
        let width = group.columns.len();
        let mut count = 0;
        for step in steps {
            if group.runs.is_empty() {
                return Ok(count);
            }
            if !step.same {
                group.columns.truncate(width);
                step.draw_all(seed, round, &mut group);
            }
            let mut chosen = group.apart(&[&step.tests]);
            let time = self.watch(step, now, &mut chosen, &mut count);
            let Some(next) = step.next.filter(|_| time <= self.deadline && !chosen.runs.is_empty()) else { continue };
            let columns: Vec<Vec<f64>> = step.image.iter().map(|form| form.all(&chosen)).collect();
            let known = self.whole.as_ref().and_then(|whole| whole.get(next)).into_iter().flatten();
            let mut whole = known.zip(&columns).filter(|(known, _)| **known).flat_map(|(_, column)| column);
            if whole.any(|number| number.abs() > MOST_WHOLE) {
                return Err(TOO_LARGE.to_string());
            }
            later.entry((Some(next), time)).or_default().join(Group { runs: chosen.runs, columns });
        }
        if group.runs.is_empty() { Ok(count) } else { Err(super::STUCK.to_string()) }
    }

    /// Counts the runs in which it happens while a step passes, and leaves those that go on; then the time is this.
    fn watch(&self, step: &Step, mut now: u64, chosen: &mut Group, count: &mut u64) -> u64 {
        for stretch in &step.stretches {
            let end = stretch.duration.map_or(u64::MAX, |duration| now.saturating_add(duration));
            if now <= self.deadline && (self.first || end > self.deadline) {
                let shown: Vec<&Vec<Test>> = stretch.shown.iter().collect();
                if !shown.is_empty() {
                    *count += chosen.apart(&shown).runs.len() as u64;
                }
                if !self.first {
                    chosen.runs.clear();
                }
            }
            now = end;
        }
        now
    }
}

impl Step {
    /// Adds what is drawn, as [`Step::draw`] does for one run.
    fn draw_all(&self, seed: u64, round: u64, group: &mut Group) {
        let Group { runs, columns } = group;
        let sources = Sources { seed, runs, round };
        let mut place = 0;
        while let rest @ [_, ..] = &self.samplers[place..] {
            if !self.needed[place] {
                columns.push(Vec::new());
                place += 1;
                continue;
            }
            let drawn = sources.draw(rest, place as u64);
            place += drawn.len();
            columns.extend(drawn);
        }
    }
}

impl Group {
    /// Takes out the runs for which one of these alternatives holds.
    fn apart(&mut self, alternatives: &[&Vec<Test>]) -> Group {
        if self.runs.is_empty() || alternatives.iter().any(|tests| tests.is_empty()) {
            return std::mem::take(self);
        }
        let mut any = vec![false; self.runs.len()];
        for tests in alternatives {
            let mut all = vec![true; self.runs.len()];
            for test in *tests {
                let values = test.form.all(self);
                let sizes = if test.may_tie { test.form.sizes(self) } else { vec![0.0; values.len()] };
                let both = all.iter_mut().zip(values.iter().zip(&sizes));
                both.for_each(|(all, (value, size))| *all &= test.relation.holds(test.order(*value, || *size)));
            }
            any.iter_mut().zip(&all).for_each(|(any, all)| *any |= *all);
        }
        let taken = any.iter().filter(|any| **any).count();
        if taken == 0 {
            return Group::default();
        }
        if taken == any.len() {
            return std::mem::take(self);
        }
        let kept: Vec<bool> = any.iter().map(|any| !any).collect();
        let part = |places: &[bool]| Group {
            runs: only(&self.runs, places),
            columns: self.columns.iter().map(|column| only(column, places)).collect(),
        };
        let (taken, rest) = (part(&any), part(&kept));
        *self = rest;
        taken
    }

    fn join(&mut self, other: Group) {
        if self.runs.is_empty() {
            *self = other;
            return;
        }
        self.runs.extend(other.runs);
        self.columns.iter_mut().zip(other.columns).for_each(|(column, more)| column.extend(more));
    }
}

/// The entries at these places; none of a column that is not needed, which is empty.
fn only<T: Copy + Default>(all: &[T], places: &[bool]) -> Vec<T> {
    let mut some = vec![T::default(); all.len()];
    let mut count = 0;
    // Written whether it counts or not: nothing branches.
    for (one, place) in all.iter().zip(places) {
        some[count] = *one;
        count += usize::from(*place);
    }
    some.truncate(count);
    some
}

impl Form {
    /// The values for all runs of a group, as [`Form::at`] gives them for one.
    fn all(&self, group: &Group) -> Vec<f64> {
        let mut sums = vec![self.constant; group.runs.len()];
        for (place, factor) in &self.terms {
            sums.iter_mut().zip(&group.columns[*place]).for_each(|(sum, number)| *sum += factor * number);
        }
        sums
    }

    /// The sizes of its parts, added up, for all runs of a group.
    fn sizes(&self, group: &Group) -> Vec<f64> {
        let mut sums = vec![self.constant.abs(); group.runs.len()];
        for (place, factor) in &self.terms {
            sums.iter_mut().zip(&group.columns[*place]).for_each(|(sum, number)| *sum += (factor * number).abs());
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use num_rational::BigRational;

    use super::*;
    use crate::distribution::Distribution;
    use crate::probability::Question;
    use crate::probability::chain::{Chain, Linear, Move, Side, Stretch};
    use crate::probability::random::Source;
    use crate::probability::simulation::{Numbers, Scratch};
    use crate::value::Relation;

    fn ratio(top: i64, bottom: i64) -> BigRational {
        BigRational::new(top.into(), bottom.into())
    }

    fn linear(state: &[i64], draws: &[i64], constant: i64) -> Linear {
        let all = |numbers: &[i64]| numbers.iter().map(|number| ratio(*number, 4)).collect();
        Linear { state: all(state), draws: all(draws), constant: ratio(constant, 4) }
    }

    fn side(form: Linear, relation: Relation) -> Side {
        Side::flat(form, relation)
    }

    /// Two phases of unequal length, numbers of all kinds, a guard between them, and a number that does not matter.
    fn chain() -> Chain {
        let normal = |variance| Distribution::Normal { mean: ratio(1, 3), variance };
        let coin = vec![(ratio(1, 2), normal(ratio(1, 4))), (ratio(1, 2), Distribution::Point(ratio(1, 7)))];
        let draws = vec![
            normal(ratio(1, 9)),
            normal(ratio(1, 4)),
            Distribution::Exponential { rate: ratio(2, 1), start: ratio(0, 1), rising: true },
            Distribution::Uniform { low: ratio(-1, 1), high: ratio(1, 1) },
            Distribution::Mixture(coin),
            normal(ratio(1, 1)),
            Distribution::Poisson { mean: ratio(2, 1) },
        ];
        let stretch = |duration, shown| Stretch { duration: Some(duration), shown, values: Vec::new() };
        let start = Move {
            draws: draws.clone(),
            tests: Vec::new(),
            stretches: Vec::new(),
            image: vec![linear(&[], &[4], 0), linear(&[], &[0, 4], 1)],
            next: Some(0),
        };
        let guard = |relation| vec![side(linear(&[4, 0], &[0, 4, 1], -12), relation)];
        let near = vec![side(linear(&[4, 0], &[], -9), Relation::Gtr), side(linear(&[4, 0], &[], -11), Relation::Lss)];
        let far = vec![side(linear(&[4, 0], &[], 12), Relation::Lte)];
        let on = Move {
            draws: draws.clone(),
            tests: guard(Relation::Lss),
            stretches: vec![stretch(ratio(1, 1), vec![near, far])],
            image: vec![linear(&[3, 0], &[0, 0, 0, 4, 0, 0, 1], 1), linear(&[1, 4], &[4], 0)],
            next: Some(0),
        };
        let over =
            Move { tests: guard(Relation::Gte), image: vec![linear(&[4, 0], &[0, 0, 0, 0, 4], 0)], ..on.clone() };
        let over = Move { stretches: vec![stretch(ratio(1, 2), Vec::new())], next: Some(1), ..over };
        let back = Move {
            draws: draws[..1].to_vec(),
            tests: Vec::new(),
            stretches: vec![stretch(ratio(3, 4), vec![vec![side(linear(&[4], &[4], -16), Relation::Gtr)]])],
            image: vec![linear(&[2], &[0], 0), linear(&[0], &[4], 0)],
            next: Some(0),
        };
        Chain { initial: vec![start], phases: vec![vec![on, over], vec![back]], variables: Vec::new() }
    }

    /// Steps of one, up or down.
    fn walk() -> Chain {
        let coin = [-1, 1].map(|step| (ratio(1, 2), Distribution::Point(ratio(step, 1))));
        let one = |state: &[i64], phase: usize| Move {
            draws: vec![Distribution::Mixture(coin.to_vec())],
            tests: Vec::new(),
            stretches: vec![Stretch {
                duration: Some(ratio(1, 1)),
                shown: if phase == 0 { Vec::new() } else { vec![vec![side(linear(&[4], &[], -12), Relation::Eq)]] },
                values: Vec::new(),
            }],
            image: vec![linear(state, &[4], 0)],
            next: Some(0),
        };
        Chain { initial: vec![one(&[], 0)], phases: vec![vec![one(&[4], 1)]], variables: Vec::new() }
    }

    #[test]
    fn runs_side_by_side_end_as_they_do_alone() {
        let all = [(chain(), true, Numbers::Mixed), (chain(), false, Numbers::Mixed), (walk(), true, Numbers::Whole)];
        for (chain, first, numbers) in all {
            let question = Question { first, time: ratio(9, 1), names: Vec::new() };
            let program = Program::new(&chain, &question, numbers).expect("a program");
            assert!(program.is_plain() && program.is_whole() == (numbers == Numbers::Whole));
            let mut space = Scratch::default();
            let mut alone = |run| program.happens(&Source::new(7, run), &mut space).map(u64::from).expect("a run");
            let ends: Vec<u64> = (0..700).map(&mut alone).collect();
            let together = program.count(7, 0..700).expect("runs");
            assert!(together == ends.iter().sum::<u64>() && 50 < together && together < 650, "{together}");
            for (run, end) in ends.iter().enumerate().take(100) {
                assert_eq!(program.count(7, run as u64..run as u64 + 1), Ok(*end), "{run}");
            }
        }
    }
}
