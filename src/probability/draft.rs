//! One way through a round in the making: the random numbers that decide it, and which of them share their noise.

use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use super::axes::{AXES, ratio, shown, stateless};
use super::chain::{Linear, Move, Region, Side, add_product};
use super::ellipse::{Compared, Ellipse};
use super::form::{Drawn, Form, Said, inner};
use super::plan::{DECIDERS, Decider, Gate, Motion, PLACES, Reducer, WIDTH, Way};
use super::region::{Patch, Range, Set, common, half, meet, merged, outside, whole};
use crate::rational::{difference, product, quotient, sum};
use crate::value::Relation;

/// A way in the making: a move with the means and variances of what it draws.
pub(super) struct Draft<'a> {
    pub reducer: &'a Reducer<'a>,
    pub one: &'a Move,
    pub phase: Option<usize>,
    pub point: Option<&'a [BigRational]>,
    pub drawn: &'a Drawn,
}

/// What is known of a way before its noise is taken apart.
struct Parts {
    /// The phase in which it goes on.
    target: Option<usize>,
    next: [Option<Form>; AXES],
    bases: [Vec<Form>; AXES],
    discs: Vec<Ellipse>,
    taken: Patch,
    asked: Vec<Patch>,
}

/// Whether guards share noise, and the variances of the parts of what they may share.
type Shared = (bool, Option<Vec<BigRational>>);

const SHARED: &str = "the guards of a round share noise in different ways";

/// Which axis a draw belongs to, and the random numbers that decide on each axis.
pub(super) struct Owners {
    pub draws: Vec<Option<usize>>,
    pub bases: [Vec<Form>; AXES],
    pub discs: Vec<Ellipse>,
}

/// The axis of a form, if it is known, and the draws on which it depends.
type Reach = (Option<usize>, Vec<usize>);

impl Owners {
    /// Gives each form the axis of the draws it depends on, and all its draws that axis, until nothing changes.
    fn spread(&mut self, forms: &mut [Reach]) -> Result<(), String> {
        for _ in 0..=forms.len() {
            for (axis, draws) in forms.iter_mut() {
                *axis = axis.or(draws.iter().find_map(|draw| self.draws[*draw]));
                let Some(axis) = *axis else { continue };
                for draw in draws {
                    if self.draws[*draw].replace(axis).is_some_and(|other| other != axis) {
                        return Err("two dimensions of the state share their noise".to_string());
                    }
                }
            }
        }
        Ok(())
    }
}

impl Draft<'_> {
    /// None where it is never taken.
    pub(super) fn way(&self, weight: BigRational) -> Result<Option<Way>, String> {
        let Some(Parts { target, next, bases, mut discs, taken, asked }) = self.parts()? else { return Ok(None) };
        let rest = asked.iter().fold(vec![taken.clone()], outside);
        let (success, last, onward) = match (target, self.reducer.question.first) {
            (None, _) => (asked.clone(), asked, Vec::new()),
            (Some(_), true) => (asked.clone(), asked, rest),
            (Some(_), false) => (Vec::new(), asked, vec![taken]),
        };
        let mut patches = [success, last, onward];
        let mut motions = Vec::new();
        for axis in 0..AXES {
            let leads = |phase: Option<usize>| phase.and_then(|phase| self.reducer.leads[phase][axis].as_ref());
            let forms: Vec<&Form> = bases[axis].iter().chain(&next[axis]).collect();
            let mut shared = Vec::new();
            if let Some(own) = leads(self.phase.filter(|_| self.point.is_none())) {
                // The state before that noise is no longer known.
                if patches.iter().flatten().any(|patch| patch[axis * PLACES] != whole()) {
                    return Err(SHARED.to_string());
                }
                shared = self.shared(&forms, own)?;
            }
            let lead = leads(target).into_iter().flatten().fold(BigRational::zero(), |all, part| sum(&all, part));
            let (motion, order) = self.motion(&next[axis], &bases[axis], &shared, &lead)?;
            for patch in patches.iter_mut().flatten() {
                let first = axis * PLACES;
                let sets: Vec<Set> = patch[first..first + PLACES].to_vec();
                patch[first + 1..first + PLACES].iter_mut().for_each(|set| *set = whole());
                for (place, said) in order.iter().enumerate() {
                    for (number, ratio, constant) in said {
                        let set = moved(&sets[1 + number], ratio, constant);
                        patch[first + place] = meet(&patch[first + place], &set);
                    }
                }
            }
            discs.iter_mut().try_for_each(|disc| disc.settle(axis, &order))?;
            motions.push(motion);
        }
        for patches in &mut patches {
            patches.retain(|patch| patch.iter().all(|set| !set.is_empty()));
        }
        let [success, last, onward] = patches.map(merged);
        let motions: [Motion; AXES] = motions.try_into().map_err(|_| "an axis is missing".to_string())?;
        let rounds = discs.into_iter().map(Ellipse::round).collect();
        Ok(Some(Way { weight, motions, rounds, success, last, onward, next: target.unwrap_or_default() }))
    }

    /// Where the move leads, what decides it, where it is taken, and where that is what is asked for.
    fn parts(&self) -> Result<Option<Parts>, String> {
        let axes = self.reducer.axes;
        let target = self.one.next.map(|next| axes.settled.get(next).copied().flatten().ok_or(next));
        let mut next: [Option<Form>; AXES] = [None, None];
        let mut region = Region::new();
        match target {
            Some(Err(phase)) => {
                for (axis, direction) in axes.directions[phase].iter().enumerate() {
                    let Some(direction) = direction else { continue };
                    let linear = Linear { state: direction.clone(), ..Linear::default() };
                    next[axis] = Some(self.form(&linear.after(&self.one.image))?);
                }
                region = shown(self.reducer.chain, phase)?;
                region.iter_mut().flatten().for_each(|side| *side = side.after(&self.one.image));
            }
            Some(Ok(true)) => region = vec![Vec::new()],
            Some(Ok(false)) => {}
            None => {
                let rest = self.one.stretches.iter().find(|stretch| stretch.duration.is_none());
                region = rest.map(|stretch| stretch.shown.clone()).unwrap_or_default();
            }
        }
        let mut owners = self.owners(&next, &region)?;
        let Some(taken) = self.patch(&self.one.tests, &mut owners)? else { return Ok(None) };
        let mut asked = Vec::new();
        for sides in &region {
            let patch = self.patch(sides, &mut owners)?.and_then(|patch| common(&taken, &patch));
            // What is shown in two ways counts once.
            asked.extend(asked.iter().fold(patch.into_iter().collect(), outside));
        }
        let target = if let Some(Err(phase)) = target { Some(phase) } else { None };
        Ok(Some(Parts { target, next, bases: owners.bases, discs: owners.discs, taken, asked }))
    }

    /// What decides on an axis, and how it moves; for each place of a patch, which base it is and how its values are
    /// said.
    fn motion(
        &self,
        next: &Option<Form>,
        bases: &[Form],
        shared: &[usize],
        lead: &BigRational,
    ) -> Result<(Motion, [Vec<Said>; PLACES]), String> {
        let (zero, one) = (BigRational::zero, BigRational::one);
        let rest: Vec<Form> = bases.iter().map(|base| base.except(shared)).collect();
        let next = next.as_ref().map(|next| (axis_factor(next), next.except(shared)));
        let follows = |base: &Form| next.as_ref().is_some_and(|(_, next)| !self.inner(base, next).is_zero());
        let mut order: [Vec<Said>; PLACES] = Default::default();
        let (mut decider, mut gates, mut main) = (Decider::Nothing, Vec::new(), None);
        for (number, base) in rest.iter().enumerate() {
            let (factor, variance) = (axis_factor(&bases[number]), self.inner(base, base));
            if rest[..number].iter().any(|other| !self.inner(other, base).is_zero()) {
                return Err(SHARED.to_string());
            }
            if variance.is_zero() {
                // Known once the state is.
                order[0].push((number, factor, base.offset.clone()));
                continue;
            }
            if !follows(base) {
                order[2 + gates.len()].push((number, one(), zero()));
                gates.push(Gate { factor, offset: base.offset.clone(), variance });
                continue;
            }
            if main.replace(number).is_some() {
                return Err(SHARED.to_string());
            }
            let exact = next
                .as_ref()
                .filter(|_| lead.is_zero())
                .and_then(|(slope, next)| next.along(slope).multiple(&base.along(&factor)));
            decider = if let Some((ratio, constant)) = exact {
                order[1].push((number, ratio, constant));
                Decider::Next
            } else {
                order[1].push((number, one(), zero()));
                let covariance = next.as_ref().map_or_else(zero, |(_, next)| self.inner(next, base));
                Decider::Noisy { factor, offset: base.offset.clone(), variance, covariance }
            };
        }
        let Some((slope, next)) = next else {
            return Ok((Motion { slope: zero(), shift: zero(), variance: zero(), decider, gates }, order));
        };
        let variance = sum(&self.inner(&next, &next), lead);
        Ok((Motion { slope, shift: next.offset, variance, decider, gates }, order))
    }

    /// The draws that reach all these forms just as the state does, noise that set in before anything was looked at, with
    /// what they add to the variance of the state; none where the state does not matter.
    fn early(&self, forms: &[&Form]) -> Option<Vec<(usize, BigRational)>> {
        let first = forms.iter().find(|form| !axis_factor(form).is_zero())?;
        let factor = axis_factor(first);
        let mut draws = Vec::new();
        for (draw, (_, variance)) in self.drawn.iter().enumerate() {
            let share = quotient(&first.draws[draw], &factor);
            if !share.is_zero() && forms.iter().all(|form| form.draws[draw] == product(&axis_factor(form), &share)) {
                draws.push((draw, product(&product(&share, &share), variance)));
            }
        }
        Some(draws)
    }

    /// For each axis, whether guards share noise, and what early noise adds to the variance of the state.
    pub(super) fn leads(&self) -> Result<[Shared; AXES], String> {
        let Some(Parts { next, bases, .. }) = self.parts()? else { return Ok(Default::default()) };
        let lead = |axis: usize| {
            let forms: Vec<&Form> = bases[axis].iter().chain(&next[axis]).collect();
            let alone = self.motion(&next[axis], &bases[axis], &[], &BigRational::zero());
            let parts = self.early(&forms).map(|all| all.into_iter().map(|(_, part)| part).collect());
            (alone.is_err(), parts)
        };
        Ok([lead(0), lead(1)])
    }

    /// The draws that set in before the state of the phase, on an axis.
    fn shared(&self, forms: &[&Form], lead: &[BigRational]) -> Result<Vec<usize>, String> {
        let Some(mut early) = self.early(forms) else { return Ok(Vec::new()) };
        let mut draws = Vec::new();
        for wanted in lead {
            let found = early.iter().position(|(_, part)| part == wanted).ok_or(SHARED)?;
            draws.push(early.swap_remove(found).0);
        }
        Ok(draws)
    }

    pub(super) fn form(&self, linear: &Linear) -> Result<Form, String> {
        let mut form = Form::of(linear, self.drawn);
        if stateless(linear) {
            return Ok(form);
        }
        let directions = self.phase.and_then(|phase| self.reducer.axes.directions.get(phase));
        let mut along = directions.into_iter().flatten().enumerate();
        let found = along.find_map(|(axis, direction)| Some((axis, ratio(direction.as_ref()?, &linear.state)?)));
        let (axis, factor) = found.ok_or("a round depends on a combination of the state that is not followed")?;
        match self.point {
            Some(point) => add_product(&mut form.offset, &factor, point.get(axis).ok_or("a state is missing")?),
            None => form.factors[axis] = factor,
        }
        Ok(form)
    }

    /// The covariance of two forms, for a given state.
    fn inner(&self, left: &Form, right: &Form) -> BigRational {
        inner(&left.draws, &right.draws, self.drawn)
    }

    /// The draws on which a form depends.
    fn drawn(&self, form: &Form) -> Vec<usize> {
        (0..self.drawn.len()).filter(|place| !form.draws[*place].is_zero()).collect()
    }

    /// Which axis each draw belongs to; the axes must be independent.
    fn owners(&self, next: &[Option<Form>; AXES], region: &Region) -> Result<Owners, String> {
        let mut owners =
            Owners { draws: vec![None; self.drawn.len()], bases: [Vec::new(), Vec::new()], discs: Vec::new() };
        let mut forms: Vec<Reach> = Vec::new();
        for form in self.one.tests.iter().chain(region.iter().flatten()).flat_map(Side::forms) {
            let form = self.form(form)?;
            forms.push((form.factors.iter().position(|factor| !factor.is_zero()), self.drawn(&form)));
        }
        let guarded = |axis: usize| usize::from(forms.iter().any(|(own, _)| *own == Some(axis)));
        let mut load: [usize; AXES] = std::array::from_fn(guarded);
        for (axis, form) in next.iter().enumerate() {
            forms.extend(form.as_ref().map(|form| (Some(axis), self.drawn(form))));
        }
        owners.spread(&mut forms)?;
        // What the state has no part in may be looked at on either axis, but with all that shares its noise.
        while let Some((own, _)) = forms.iter_mut().find(|(own, draws)| own.is_none() && !draws.is_empty()) {
            let axis = (0..AXES).min_by_key(|axis| load[*axis]).unwrap_or_default();
            *own = Some(axis);
            load[axis] += 1;
            owners.spread(&mut forms)?;
        }
        Ok(owners)
    }

    /// Where the states and the random numbers must lie for all of these to hold; none if one of them never does.
    fn patch(&self, sides: &[Side], owners: &mut Owners) -> Result<Option<Patch>, String> {
        let mut patch: Patch = vec![whole(); WIDTH];
        for side in sides {
            if let Some(disc) = &side.disc {
                match self.disc(disc, &-side.form.constant.clone(), side.relation, owners)? {
                    Compared::Always => continue,
                    Compared::Never => return Ok(None),
                    Compared::Within(place, set) => patch[place] = meet(&patch[place], &set),
                }
                if patch.contains(&Set::new()) {
                    return Ok(None);
                }
                continue;
            }
            let form = self.form(&side.form)?;
            let along = form.factors.iter().position(|factor| !factor.is_zero());
            let drawn = self.drawn(&form);
            let (place, set) = match (side.relation, along, drawn.first()) {
                (relation, None, None) if relation.holds(form.offset.cmp(&BigRational::zero())) => continue,
                (_, None, None) | (Relation::Eq, _, _) => return Ok(None),
                (Relation::Neq, _, _) => continue,
                (relation, Some(axis), None) => (PLACES * axis, half(relation, &form.factors[axis], &form.offset)),
                (relation, _, Some(draw)) => {
                    let axis = owners.draws[*draw].ok_or("a guard is lost")?;
                    let bases = &mut owners.bases[axis];
                    let (number, ratio, constant) = form.said(bases, DECIDERS)?;
                    (PLACES * axis + 1 + number, half(relation, &ratio, &constant))
                }
            };
            patch[place] = meet(&patch[place], &set);
            if patch[place].is_empty() {
                return Ok(None);
            }
        }
        Ok(Some(patch))
    }
}

fn axis_factor(form: &Form) -> BigRational {
    form.factors.iter().find(|factor| !factor.is_zero()).cloned().unwrap_or_default()
}

impl Form {
    /// The other draws, and what is added.
    fn except(&self, draws: &[usize]) -> Form {
        let mut part = Form { factors: [BigRational::zero(), BigRational::zero()], ..self.clone() };
        draws.iter().for_each(|place| part.draws[*place] = BigRational::zero());
        part
    }

    /// With this factor of the state.
    fn along(&self, factor: &BigRational) -> Form {
        Form { factors: [factor.clone(), BigRational::zero()], ..self.clone() }
    }
}

/// Ranges of `ratio * x + constant` as ranges of x.
pub(super) fn moved(set: &Set, ratio: &BigRational, constant: &BigRational) -> Set {
    let place = |bound: &Option<BigRational>| bound.as_ref().map(|bound| quotient(&difference(bound, constant), ratio));
    let range = |(low, high): &Range| {
        if ratio.is_negative() { (place(high), place(low)) } else { (place(low), place(high)) }
    };
    let mut ranges: Set = set.iter().map(range).collect();
    ranges.sort_by(|one, other| one.0.cmp(&other.0));
    ranges
}
