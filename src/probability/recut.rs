//! A chain whose rounds begin before their last numbers are drawn: a measurement that is looked at as a round ends, and
//! steers the next one, is then drawn in the round that it steers, and what a phase has to know is less.
//!
//! Moves that differ in nothing before the last draws become one; what these draws lead to is the *cut*, a phase over
//! what all of it is said by.

use num_rational::BigRational;
use num_traits::{Signed, Zero};

use super::Question;
use super::axes::settled;
use super::chain::{Chain, Linear, Move, Side, Stretch, add_product};
use super::linear::combination;
use super::plan::duration;
use crate::distribution::Distribution;
use crate::value::Relation;

/// Draws of a round that may belong to the next one.
const MOST_LATE: usize = 6;
/// Phases, with cuts among them.
const MOST_PHASES: usize = 64;

/// What the last draws lead to, over the numbers of the cut and these draws.
#[derive(Clone, PartialEq, Eq)]
struct Ending {
    tests: Vec<Side>,
    next: usize,
    image: Vec<Linear>,
}

/// A place between the early and the last draws of a round.
struct Cut {
    late: Vec<Distribution>,
    endings: Vec<Ending>,
    /// Its numbers: which variables of what it leads to.
    numbers: Vec<(usize, usize)>,
}

/// A move with the number of draws before its last ones, where it has these.
type Counted = (Move, Option<usize>);

/// Moves that differ in their last draws alone.
struct Group {
    base: Move,
    endings: Vec<Ending>,
}

/// The chain with rounds that begin before their last draws, one or more of them, and what is asked of it.
pub(super) fn later_rounds<'a>(
    chain: &'a Chain,
    question: &'a Question,
) -> impl Iterator<Item = (Chain, Question)> + use<'a> {
    (1..=MOST_LATE).filter_map(|late| {
        let (cut, delayed) = recut(chain, question, late)?;
        let mut question = question.clone();
        if delayed {
            let open = (0..cut.phases.len()).filter(|phase| settled(&cut, &question, *phase).is_none());
            question.time += duration(&cut, &open.collect::<Vec<usize>>()).ok().flatten()?;
        }
        Some((cut, question))
    })
}

/// The chain with the last so many draws of each round in the next one, and whether what is asked for happens a round
/// later there: where the last draws alone decide it. None where there is nothing to gain.
fn recut(chain: &Chain, question: &Question, late: usize) -> Option<(Chain, bool)> {
    let succeeds = (0..chain.phases.len()).map(|phase| question.first && settled(chain, question, phase) == Some(true));
    let mut cutter =
        Cutter { late, old: chain.phases.len(), cuts: Vec::new(), succeeds: succeeds.collect(), prompt: false };
    let mut phases = Vec::new();
    let plain = |moves: &[Move]| moves.iter().map(|one| (one.clone(), one.draws.len().checked_sub(late))).collect();
    for moves in &chain.phases {
        phases.push(cutter.moves(plain(moves))?);
    }
    let initial = cutter.moves(plain(&chain.initial))?;
    let mut done = 0;
    while done < cutter.cuts.len() {
        let (mut ended, open) = cutter.onward(done, chain)?;
        ended.extend(cutter.moves(open)?);
        phases.push(ended);
        done += 1;
        if phases.len() > MOST_PHASES {
            return None;
        }
    }
    let delayed = cutter.cuts.iter().any(|cut| cut.endings.iter().any(|ending| cutter.succeeds[ending.next]));
    if delayed && cutter.prompt {
        return None;
    }
    // Success that does not wait for the last draws would come in time.
    let open =
        phases.iter().enumerate().filter(|(place, _)| !cutter.succeeds.get(*place).is_some_and(|succeeds| *succeeds));
    let mut open = initial.iter().chain(open.flat_map(|(_, moves)| moves));
    let alone = open.all(|one| one.stretches.iter().all(|stretch| stretch.shown.is_empty()));
    (done > 0 && (alone || !delayed)).then(|| (reached(initial, phases), delayed))
}

struct Cutter {
    late: usize,
    old: usize,
    cuts: Vec<Cut>,
    /// The phases in which what is asked for has surely happened.
    succeeds: Vec<bool>,
    /// Whether one of these is reached without the last draws.
    prompt: bool,
}

impl Cutter {
    /// Moves that end at cuts.
    fn moves(&mut self, moves: Vec<Counted>) -> Option<Vec<Move>> {
        let (mut all, mut groups): (Vec<Move>, Vec<(Group, usize)>) = (Vec::new(), Vec::new());
        for (one, early) in moves {
            let waits = |form: &Linear| early.is_some_and(|early| !form.draws.iter().skip(early).all(Zero::is_zero));
            let (later, sooner): (Vec<Side>, Vec<Side>) = one.tests.iter().cloned().partition(|side| waits(&side.form));
            let mut shown = one.stretches.iter().flat_map(|stretch| stretch.shown.iter().flatten());
            if shown.any(|side| waits(&side.form)) {
                return None;
            }
            let cut = !later.is_empty() || one.image.iter().any(waits);
            let (Some(next), Some(early), true) = (one.next, early, cut) else {
                if !later.is_empty() {
                    return None;
                }
                self.prompt |= one.next.is_some_and(|next| self.succeeds[next]);
                all.push(one);
                continue;
            };
            let base = Move { tests: sooner, image: Vec::new(), next: None, ..one.clone() };
            let ending = Ending { tests: later, next, image: one.image.clone() };
            match groups.iter_mut().find(|(group, others)| *others == early && alike(&group.base, &base)) {
                Some((group, _)) => group.endings.push(ending),
                None => groups.push((Group { base, endings: vec![ending] }, early)),
            }
        }
        // The moves of a phase leave no case out and no two hold at once. Where that is told before the last draws, which of
        // them it is that a group leads to is told by these alone: its endings leave no case out either.
        for (place, (group, _)) in groups.iter().enumerate() {
            let mut others = all.iter().chain(groups[..place].iter().map(|(other, _)| &other.base));
            if !others.all(|other| exclude(&group.base.tests, &other.tests)) {
                return None;
            }
        }
        for (group, early) in groups {
            let (place, image) = self.cut(&group, early)?;
            let mut draws = group.base.draws;
            draws.truncate(early);
            all.push(Move { draws, image, next: Some(self.old + place), ..group.base });
        }
        Some(all)
    }

    /// The cut at which a group ends, with its numbers there.
    fn cut(&mut self, group: &Group, early: usize) -> Option<(usize, Vec<Linear>)> {
        let late = &group.base.draws[early..];
        let known = self.cuts.iter().enumerate().filter(|(_, cut)| cut.late == late);
        for (place, cut) in known {
            if let Some(image) = cut.fits(group, early) {
                return Some((place, image));
            }
        }
        let mut numbers: Vec<(usize, usize)> = Vec::new();
        let mut forms: Vec<Linear> = Vec::new();
        for (place, ending) in group.endings.iter().enumerate() {
            for (variable, form) in ending.image.iter().enumerate() {
                let plain = form.draws.iter().skip(early).all(Zero::is_zero);
                if plain && said(form, &forms, early).is_none() {
                    numbers.push((place, variable));
                    forms.push(form.clone());
                }
            }
        }
        let ending = |ending: &Ending| {
            let side = |side: &Side| Some(Side::flat(said(&side.form, &forms, early)?, side.relation));
            Some(Ending {
                tests: ending.tests.iter().map(side).collect::<Option<_>>()?,
                next: ending.next,
                image: ending.image.iter().map(|form| said(form, &forms, early)).collect::<Option<_>>()?,
            })
        };
        let endings = group.endings.iter().map(ending).collect::<Option<_>>()?;
        self.cuts.push(Cut { late: late.to_vec(), endings, numbers });
        Some((self.cuts.len() - 1, forms))
    }

    /// What happens from a cut on: the last draws, and a round of the phase to which they lead; first the moves that end
    /// there, then those that go on, as [`Cutter::moves`] takes them.
    fn onward(&self, place: usize, chain: &Chain) -> Option<(Vec<Move>, Vec<Counted>)> {
        let cut = &self.cuts[place];
        let (mut ended, mut all) = (Vec::new(), Vec::new());
        let length = |ending: &Ending| chain.phases.get(ending.next)?.first()?.stretches.first()?.duration.clone();
        let length = cut.endings.iter().filter(|ending| !self.succeeds[ending.next]).find_map(length);
        for ending in &cut.endings {
            if self.succeeds[ending.next] {
                let stretch = Stretch { duration: Some(length.clone()?), shown: Vec::new(), values: Vec::new() };
                let (draws, tests) = (cut.late.clone(), ending.tests.clone());
                let (stretches, image) = (vec![stretch], ending.image.clone());
                ended.push(Move { draws, tests, stretches, image, next: Some(ending.next) });
                continue;
            }
            for one in chain.phases.get(ending.next)? {
                let form = |form: &Linear| behind(form, &ending.image, cut);
                let side = |side: &Side| Side::flat(form(&side.form), side.relation);
                let stretch = |stretch: &Stretch| Stretch {
                    duration: stretch.duration.clone(),
                    shown: stretch.shown.iter().map(|all| all.iter().map(side).collect()).collect(),
                    values: stretch.values.iter().map(form).collect(),
                };
                let early = one.draws.len().checked_sub(self.late).map(|early| early + cut.late.len());
                let whole = Move {
                    draws: cut.late.iter().chain(&one.draws).cloned().collect(),
                    tests: ending.tests.iter().cloned().chain(one.tests.iter().map(side)).collect(),
                    stretches: one.stretches.iter().map(stretch).collect(),
                    image: one.image.iter().map(form).collect(),
                    next: one.next,
                };
                all.push((whole, early));
            }
        }
        Some((ended, all))
    }
}

impl Cut {
    /// The numbers with which a group ends here; none where it ends in other ways.
    fn fits(&self, group: &Group, early: usize) -> Option<Vec<Linear>> {
        if group.endings.len() != self.endings.len() {
            return None;
        }
        let pairs = self.endings.iter().zip(&group.endings);
        if pairs.clone().any(|(own, other)| own.next != other.next || own.tests.len() != other.tests.len()) {
            return None;
        }
        let number = |(place, variable): &(usize, usize)| group.endings.get(*place)?.image.get(*variable).cloned();
        let numbers = self.numbers.iter().map(number).collect::<Option<Vec<Linear>>>()?;
        let same = |own: &Linear, form: &Linear| {
            let mut said = own.after(&numbers);
            add_draws(&mut said, &own.draws, early);
            equal(&said, form)
        };
        for (own, other) in pairs {
            let tests = own.tests.iter().zip(&other.tests);
            let images = own.image.len() == other.image.len();
            let tested = tests.clone().all(|(own, side)| own.relation == side.relation && same(&own.form, &side.form));
            if !images || !tested || !own.image.iter().zip(&other.image).all(|(own, form)| same(own, form)) {
                return None;
            }
        }
        Some(numbers)
    }
}

/// Whether no values meet all tests of both: two of them bound one form from opposite sides.
fn exclude(one: &[Side], other: &[Side]) -> bool {
    let bounds = |sides: &[Side]| sides.iter().filter_map(Bound::of).collect::<Vec<Bound>>();
    let others = bounds(other);
    bounds(one).iter().any(|one| others.iter().any(|other| one.excludes(other) || other.excludes(one)))
}

/// `form > number`, `form >= number`, or the same with `<`, where the first factor of the form is 1.
struct Bound {
    form: Linear,
    number: BigRational,
    below: bool,
    strict: bool,
}

impl Bound {
    fn of(side: &Side) -> Option<Bound> {
        let lead = side.form.state.iter().chain(&side.form.draws).find(|factor| !factor.is_zero())?;
        let form = side.form.scaled(&lead.recip());
        let relation = if lead.is_negative() { side.relation.mirrored() } else { side.relation };
        let (below, strict) = match relation {
            Relation::Gtr => (true, true),
            Relation::Gte => (true, false),
            Relation::Lss => (false, true),
            Relation::Lte => (false, false),
            _ => return None,
        };
        let number = -form.constant.clone();
        Some(Bound { form: Linear { constant: BigRational::zero(), ..form }, number, below, strict })
    }

    /// Whether this one bounds the form from below, and the other from above and no higher.
    fn excludes(&self, other: &Bound) -> bool {
        let apart = self.number > other.number || self.number == other.number && (self.strict || other.strict);
        self.below && !other.below && apart && equal(&self.form, &other.form)
    }
}

/// A form over numbers and the last draws; none where it needs something else.
fn said(form: &Linear, numbers: &[Linear], early: usize) -> Option<Linear> {
    let width = numbers.iter().chain([form]).map(|form| form.state.len()).max().unwrap_or(0);
    let joined = |form: &Linear| {
        let draws = form.draws.iter().take(early).cloned();
        let mut state = form.state.clone();
        state.resize(width, BigRational::zero());
        Linear { state: state.into_iter().chain(draws).collect(), ..Linear::default() }
    };
    let forms: Vec<Linear> = numbers.iter().map(joined).collect();
    let state = combination(&forms, &joined(form).state)?;
    let mut constant = form.constant.clone();
    state.iter().zip(numbers).for_each(|(factor, number)| add_product(&mut constant, &-factor, &number.constant));
    Some(Linear { state, draws: form.draws.iter().skip(early).cloned().collect(), constant })
}

/// A form over the state of a phase, said by the numbers of a cut and its draws; those of the round come behind.
fn behind(form: &Linear, image: &[Linear], cut: &Cut) -> Linear {
    let mut said = form.after(image);
    said.state.resize(cut.numbers.len(), BigRational::zero());
    add_draws(&mut said, &form.draws, cut.late.len());
    said
}

/// Adds draws that come behind so many others.
fn add_draws(form: &mut Linear, draws: &[BigRational], before: usize) {
    form.draws.resize(form.draws.len().max(before + draws.len()), BigRational::zero());
    form.draws[before..].iter_mut().zip(draws).for_each(|(sum, factor)| *sum += factor);
}

/// Whether two forms differ in zeros at the end at most.
fn equal(one: &Linear, other: &Linear) -> bool {
    let zero = BigRational::zero();
    let row = |one: &[BigRational], other: &[BigRational]| {
        (0..one.len().max(other.len()))
            .all(|place| one.get(place).unwrap_or(&zero) == other.get(place).unwrap_or(&zero))
    };
    one.constant == other.constant && row(&one.state, &other.state) && row(&one.draws, &other.draws)
}

/// Whether two moves are the same up to where they lead.
fn alike(one: &Move, other: &Move) -> bool {
    let stretch = |one: &Stretch, other: &Stretch| one.duration == other.duration && one.shown == other.shown;
    one.draws == other.draws
        && one.tests == other.tests
        && one.stretches.len() == other.stretches.len()
        && one.stretches.iter().zip(&other.stretches).all(|(one, other)| stretch(one, other))
}

/// The phases that are reached, in the order in which they are.
fn reached(initial: Vec<Move>, phases: Vec<Vec<Move>>) -> Chain {
    let mut order: Vec<usize> = Vec::new();
    let renumbered = |mut moves: Vec<Move>, order: &mut Vec<usize>| {
        for one in &mut moves {
            one.next = one.next.map(|next| match order.iter().position(|other| *other == next) {
                Some(place) => place,
                None => {
                    order.push(next);
                    order.len() - 1
                }
            });
        }
        moves
    };
    let initial = renumbered(initial, &mut order);
    let mut found: Vec<Vec<Move>> = Vec::new();
    while let Some(number) = order.get(found.len()).copied() {
        let moves = phases.get(number).cloned().unwrap_or_default();
        found.push(renumbered(moves, &mut order));
    }
    Chain { initial, phases: found, variables: Vec::new() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interval::Interval;
    use crate::probability::enclosed::enclosed;

    fn ratio(top: i64, bottom: i64) -> BigRational {
        BigRational::new(top.into(), bottom.into())
    }

    fn linear(state: &[BigRational], draws: &[BigRational], constant: BigRational) -> Linear {
        Linear { state: state.to_vec(), draws: draws.to_vec(), constant }
    }

    fn normal(spread: BigRational) -> Distribution {
        Distribution::Normal { mean: BigRational::zero(), variance: &spread * &spread }
    }

    /// A round ends with a look z at the position r: more than 1/10 from 10 on either side, or done.
    fn looks(draws: Vec<Distribution>, stretches: Vec<Stretch>, place: Linear) -> Vec<Move> {
        let mut look = place.clone();
        look.draws.resize(draws.len(), BigRational::zero());
        look.draws[draws.len() - 1] = ratio(1, 1);
        let side = |bound: BigRational, relation| {
            let form = Linear { constant: &look.constant - bound, ..look.clone() };
            Side::flat(form, relation)
        };
        let (low, high) = (ratio(99, 10), ratio(101, 10));
        let ways = [
            (vec![side(high.clone(), Relation::Gtr)], 0),
            (vec![side(low.clone(), Relation::Lss)], 0),
            (vec![side(low, Relation::Gte), side(high, Relation::Lte)], 1),
        ];
        let one = |(tests, next): (Vec<Side>, usize)| {
            let image = if next == 0 { vec![place.clone(), look.clone()] } else { Vec::new() };
            Move { draws: draws.clone(), tests, stretches: stretches.clone(), image, next: Some(next) }
        };
        ways.into_iter().map(one).collect()
    }

    /// r' = r + (10-z)/10 + e/5, looked at with noise, which is a state of one dimension, r - z/10, as it stands: cut
    /// before the look, it is r, and the chance is the same.
    #[test]
    fn a_chain_cut_elsewhere_has_the_same_chance() {
        let (zero, stretch) = (BigRational::zero, |duration, shown| Stretch { duration, shown, values: Vec::new() });
        let moved = linear(&[ratio(1, 1), ratio(-1, 10)], &[ratio(1, 5)], ratio(1, 1));
        let round = vec![stretch(Some(ratio(1, 5)), Vec::new())];
        let rounds = looks(vec![normal(ratio(1, 2)), normal(ratio(1, 10))], round, moved);
        let (draws, tests, image) = (Vec::new(), Vec::new(), Vec::new());
        let done = Move { draws, tests, stretches: vec![stretch(None, vec![Vec::new()])], image, next: None };
        let initial = looks(vec![normal(ratio(1, 10))], Vec::new(), linear(&[], &[], zero()));
        let chain = Chain { initial, phases: vec![rounds, vec![done]], variables: Vec::new() };
        let question = Question { first: true, time: ratio(49, 5), names: Vec::new() };
        let plain = enclosed(&chain, &question, 1e-8).map(|found| found.interval());
        let mut cuts = later_rounds(&chain, &question).map(|(cut, asked)| {
            assert_ne!(cut.phases.len(), 0);
            assert_eq!(asked.time, ratio(10, 1));
            enclosed(&cut, &asked, 1e-8).map(|found| found.interval())
        });
        // 0.9155277 by a dense quadrature.
        let near = |found: &Result<Interval, String>| {
            found.as_ref().is_ok_and(|found| found.width() < 1e-7 && (found.low - 0.915_527_73).abs() < 1e-7)
        };
        let cut = cuts.next().expect("a cut");
        assert!(near(&plain) && near(&cut), "{plain:?} {cut:?}");
    }

    /// Rounds that draw once more where the first look is near share no cut: they are told apart by a late draw.
    #[test]
    fn moves_that_a_late_draw_tells_apart_are_not_cut() {
        let stretches = || vec![Stretch { duration: Some(ratio(1, 1)), shown: Vec::new(), values: Vec::new() }];
        let side = |draws: &[BigRational], relation| Side::flat(linear(&[], draws, ratio(-1, 2)), relation);
        let (no, one) = (BigRational::zero(), ratio(1, 1));
        let image = |draws: &[BigRational]| {
            [&[], draws].map(|draws| linear(std::slice::from_ref(&one), draws, no.clone())).to_vec()
        };
        let far = Move {
            draws: vec![normal(one.clone())],
            tests: vec![side(std::slice::from_ref(&one), Relation::Gtr)],
            stretches: stretches(),
            image: image(std::slice::from_ref(&one)),
            next: Some(0),
        };
        let near = Move {
            draws: vec![normal(one.clone()), normal(one.clone())],
            tests: vec![side(std::slice::from_ref(&one), Relation::Lte)],
            stretches: stretches(),
            image: image(&[no.clone(), one.clone()]),
            next: Some(0),
        };
        let (draws, tests) = (Vec::new(), Vec::new());
        let start =
            Move { draws, tests, stretches: Vec::new(), image: vec![linear(&[], &[], no.clone()); 2], next: Some(0) };
        let chain = Chain { initial: vec![start], phases: vec![vec![far, near]], variables: Vec::new() };
        let question = Question { first: false, time: ratio(2, 1), names: Vec::new() };
        assert!(recut(&chain, &question, 1).is_none());
    }
}
