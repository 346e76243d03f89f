//! Where two things come nearest to each other.

use num_rational::BigRational;
use num_traits::ToPrimitive;

use super::super::visit::{Distance, values_of};
use super::super::{Finding, Measure, Moment, Passing, Standing};
use super::{Scene, exact};
use crate::invariant::Claim;
use crate::name::Name;
use crate::period::Test;
use crate::replay::replays;
use crate::safety::drawn::broken;
use crate::term::{Node, Term};
use crate::timeline::Stretch;
use crate::value::{Relation, Sort, Value, ValueError};

impl Scene<'_> {
    /// Of what sorts the values are that an observer shows.
    pub(super) fn sorts(&self, observer: &Name, arity: usize) -> Vec<Sort> {
        let shown = self.run.stretches.iter().find_map(|stretch| values_of(&stretch.shown, observer).next());
        shown.map_or_else(|| vec![Sort::Real; arity], |values| values.iter().map(Value::sort).collect())
    }

    /// The least distance of two things in the run.
    pub(super) fn least_distance(
        &self,
        between: &[(Name, usize); 2],
        limit: &BigRational,
        strict: bool,
        finding: &mut Finding,
    ) {
        let (limit, relation) = (exact(limit), if strict { Relation::Gtr } else { Relation::Gte });
        let far = |distance: &Distance| distance.compares(self.run, relation, &limit);
        let (mut least, mut unknown): (Option<(Distance, Value, usize)>, bool) = (None, false);
        for (place, stretch) in self.run.stretches.iter().enumerate() {
            for one in values_of(&stretch.shown, &between[0].0) {
                for other in values_of(&stretch.shown, &between[1].0) {
                    let Some(distance) = Distance::between(one, other) else {
                        unknown = true;
                        continue;
                    };
                    let nearer = match &least {
                        None => Some(true),
                        // Of a run that goes on only a bound is known: which of two is nearer by a hair says nothing.
                        Some((before, ..)) if !self.run.closed() && alike(&distance, before) => {
                            Some(far(&distance) != far(before) && distance.is_less(before, self.run) == Some(true))
                        }
                        Some((before, ..)) => distance.is_less(before, self.run),
                    };
                    match nearer {
                        Some(true) => least = Some((distance, stretch.start.clone(), place)),
                        Some(false) => {}
                        None => unknown = true,
                    }
                }
            }
        }
        if unknown {
            finding.notes.push("it could not be found out where the two are nearest".to_string());
        }
        let closed = self.run.closed() && !unknown;
        let Some((distance, time, stretch)) = least else {
            if closed {
                finding.standing = Standing::Met;
                finding.shows_nothing();
            }
            return;
        };
        let far = far(&distance);
        let Some(distance) = distance.length() else { return };
        let margin = self.room(&limit, &distance);
        finding.standing = match (far, closed) {
            (Some(false), _) => Standing::NotMet,
            (Some(true), true) => Standing::Met,
            (Some(true), false) | (None, _) => Standing::Open,
        };
        finding.value = Some(if closed { Measure::Exact(distance) } else { Measure::AtMost(distance) });
        finding.margin = margin.map(|margin| if closed { Measure::Exact(margin) } else { Measure::AtMost(margin) });
        finding.moment = Some(Moment { stretch, from: time, to: None, leg: None });
        finding.passing = self.passing(between, &limit);
        if finding.standing != Standing::NotMet {
            finding.notes.extend(finding.passing.as_ref().map(Passing::note));
        }
    }

    /// Where two looks after each other are far enough from another thing and the straight way between them is not.
    fn passing(&self, between: &[(Name, usize); 2], limit: &Value) -> Option<Passing> {
        let least = limit.as_rational()?.to_f64()?;
        let alone = |stretch: &Stretch| {
            let mut all = between.iter().map(|(name, _)| {
                let mut values = values_of(&stretch.shown, name);
                values.next().filter(|_| values.next().is_none())
            });
            Distance::between(all.next()??, all.next()??)
        };
        let looks: Vec<(&Stretch, Distance)> =
            self.run.stretches.iter().filter_map(|stretch| Some((stretch, alone(stretch)?))).collect();
        let near = |pair: &[(&Stretch, Distance)]| {
            let [(_, here), (next, there)] = pair else { return None };
            let apart = [here, there].iter().all(|one| one.compares(self.run, Relation::Gte, limit) == Some(true));
            let near = here.between_looks(there).filter(|near| apart && *near < least * (1.0 - 1e-9))?;
            Some(Passing { next: next.start.clone(), near })
        };
        looks.windows(2).filter_map(near).min_by(|one, other| one.near.total_cmp(&other.near))
    }

    /// Notes a run that comes too near by what it draws, if trying values finds one that replays.
    pub(super) fn broken_by_draws(&self, claim: &Claim, limit: &BigRational, finding: &mut Finding) -> bool {
        let (definitions, assumptions) = (&self.environment.definitions, &self.environment.assumptions);
        let term = self.system.term(definitions);
        let Some(run) = broken(&term, definitions, assumptions, claim, self.judge.interrupted) else { return false };
        let Some((time, shown)) = run.shown.last() else { return false };
        if !replays(&term, definitions, &run.shown, &run.drawn) {
            return false;
        }
        let duties = claim.duties(shown).unwrap_or_default();
        let near = duties.iter().flat_map(|duty| &duty.tests).find(|test| test.decide(assumptions) == Some(false));
        let Some(near) = near.map(|test| test.left.clone()) else { return false };
        let shown: Vec<String> = shown.iter().map(ToString::to_string).collect();
        finding.standing = Standing::NotMet;
        finding.margin = near.sub(&exact(limit)).ok().map(Measure::AtMost);
        finding.value = Some(Measure::AtMost(near));
        finding.moment = None;
        finding.notes = vec![format!("a run comes so near at {time}: {}", shown.join(", "))];
        finding.notes.extend(run.draws());
        true
    }
}

/// Whether two distances are nearly the same.
fn alike(one: &Distance, other: &Distance) -> bool {
    let (Some(one), Some(other)) = (one.about(), other.about()) else { return false };
    one.high.max(other.high) - one.low.min(other.low) <= 1e-9 * one.high
}

/// `|p - o| > c` whenever both are shown; vectors are written out by their places.
pub(super) fn claim(between: &[(&Name, Vec<Sort>); 2], strict: bool, limit: &BigRational) -> Result<Claim, ValueError> {
    let mut terms = Vec::new();
    let mut variables = std::collections::BTreeSet::new();
    let mut places: Vec<Vec<Value>> = Vec::new();
    for (side, (observer, sorts)) in between.iter().enumerate() {
        let (mut shown, mut own) = (Vec::new(), Vec::new());
        for (number, sort) in sorts.iter().enumerate() {
            let name = Name::new(&format!("{observer}~{side}~{number}"));
            let variable = Value::variable(&name);
            match sort {
                Sort::Vector(length) => {
                    for place in 1..=*length {
                        let place = Value::integer(i64::try_from(place).unwrap_or(i64::MAX));
                        own.push(Value::apply(&Name::new("part"), &[variable.clone(), place])?);
                    }
                }
                _ => own.push(variable.clone()),
            }
            variables.insert(name);
            shown.push(variable);
        }
        terms.push(Term::new(Node::Observe((*observer).clone(), shown)));
        places.push(own);
    }
    let mut parts = Vec::new();
    if let [one, other] = places.as_slice() {
        if one.len() != other.len() {
            return Err(ValueError("the two are no places of one space".to_string()));
        }
        for (one, other) in one.iter().zip(other) {
            parts.push(one.sub(other)?);
        }
    }
    let left = match parts.as_slice() {
        [only] => only.abs()?,
        _ => Value::vector(parts)?.norm()?,
    };
    let relation = if strict { Relation::Gtr } else { Relation::Gte };
    Ok(Claim { shown: terms, variables, tests: vec![Test { relation, left, right: exact(limit) }] })
}
