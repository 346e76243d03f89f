//! Rounds as stretches of a run, by the closed forms of their values.

use super::trajectory::{Values, Walker};
use super::undecided::Unsure;
use super::unit::{Unit, repeat};
use crate::name::Name;
use crate::period::{Edge, End, Next, Segment};
use crate::recurrence::Closed;
use crate::substitution::substitute_values;
use crate::term::Term;
use crate::value::{Relation, Value, ValueError};

impl Walker<'_> {
    pub(super) fn units_once(&self, edge: &Edge, values: &Values) -> Result<Vec<Unit>, Unsure> {
        edge.segments.iter().map(|segment| Ok(Unit::Single(self.segment(segment, values)?))).collect()
    }

    /// Where a round leads that begins with these values: what is shown at the end of a run is of them.
    pub(super) fn onward(&self, edge: &Edge, values: &Values) -> Result<Next, Unsure> {
        let Next::End(End::Silent { blocked, observed }) = &edge.next else { return Ok(edge.next.clone()) };
        let end = Segment { duration: Value::zero(), observed: observed.clone() };
        let observed = self.segment(&end, values)?.observed;
        Ok(Next::End(End::Silent { blocked: blocked.clone(), observed }))
    }

    pub(super) fn segment(&self, segment: &Segment, values: &Values) -> Result<Segment, Unsure> {
        let observed: Result<Vec<Term>, _> =
            segment.observed.iter().map(|term| substitute_values(term, values)).collect();
        let mut observed = observed.map_err(|stuck| Unsure::because(stuck.0))?;
        for term in &mut observed {
            *term = term.map_values(&mut |value| Ok::<_, ValueError>(self.assumptions.simplify(value)))?;
        }
        observed.sort();
        observed.dedup();
        let duration = self.assumptions.simplify(&segment.duration.substitute(values)?);
        Ok(Segment { duration, observed })
    }

    /// So many rounds as stretches, one for each piece of the closed forms.
    pub(super) fn units(
        &self,
        segments: &[Segment],
        values: &Values,
        closed: &[(Name, Closed)],
        total: Option<&Value>,
    ) -> Result<Vec<Unit>, Unsure> {
        let mut units = Vec::new();
        let mut from = Value::zero();
        while total != Some(&from) {
            let mut here = values.clone();
            let mut until: Option<Value> = total.cloned();
            let shifted = Value::variable(&self.index).add(&from)?;
            for (name, closed) in closed {
                let (form, end) = self.piece_at(closed, &from)?;
                here.insert(name.clone(), form.with(&self.index, &shifted)?);
                until = self.sooner(until, end)?;
            }
            let round: Vec<Segment> =
                segments.iter().map(|segment| self.segment(segment, &here)).collect::<Result<_, Unsure>>()?;
            let count = until.as_ref().map(|until| until.sub(&from)).transpose()?;
            units.extend(repeat(count, &self.index, round)?);
            match until {
                Some(until) => from = until,
                None => break,
            }
        }
        Ok(units)
    }

    fn sooner(&self, one: Option<Value>, other: Option<Value>) -> Result<Option<Value>, Unsure> {
        let (Some(one), Some(other)) = (&one, &other) else {
            return Ok(one.or(other));
        };
        match self.assumptions.decide(Relation::Lte, one, other) {
            Some(true) => Ok(Some(one.clone())),
            Some(false) => Ok(Some(other.clone())),
            None if self.assumptions.decide(Relation::Lte, other, one) == Some(true) => Ok(Some(other.clone())),
            None => Err(Unsure::whether(Relation::Lte, one, other)),
        }
    }

    /// The form that holds at an index, and where it ends.
    fn piece_at(&self, closed: &Closed, at: &Value) -> Result<(Value, Option<Value>), Unsure> {
        for piece in &closed.pieces {
            match &piece.until {
                None => return Ok((piece.form.clone(), None)),
                Some(until) => match self.assumptions.decide(Relation::Lss, at, until) {
                    Some(true) => return Ok((piece.form.clone(), Some(until.clone()))),
                    Some(false) => {}
                    None => return Err(Unsure::whether(Relation::Lss, at, until)),
                },
            }
        }
        Err(Unsure::because("a closed form ends too early".to_string()))
    }

    pub(super) fn values_at(&self, values: &Values, closed: &[(Name, Closed)], at: &Value) -> Result<Values, Unsure> {
        let mut here = values.clone();
        for (name, closed) in closed {
            let (form, _) = self.piece_at(closed, at)?;
            here.insert(name.clone(), self.assumptions.simplify(&form.with(&self.index, at)?));
        }
        Ok(here)
    }

    /// Rounds as stretches: where every variable changes by the same step, in one.
    pub(super) fn compressed(&self, rounds: &[(&Edge, Values)]) -> Result<Vec<Unit>, Unsure> {
        let mut units = Vec::new();
        let mut from = 0usize;
        while let Some((edge, start)) = rounds.get(from) {
            let steps = match rounds.get(from + 1) {
                Some((_, second)) => differences(start, second)?,
                None => Values::new(),
            };
            let mut until = from + 1;
            while let (Some((_, one)), Some((other, two))) = (rounds.get(until - 1), rounds.get(until)) {
                if other.segments != edge.segments || differences(one, two)? != steps {
                    break;
                }
                until += 1;
            }
            if until - from < 3 {
                units.extend(self.units_once(edge, start)?);
                from += 1;
                continue;
            }
            let mut here = start.clone();
            for (name, step) in &steps {
                if let Some(value) = here.get_mut(name) {
                    *value = step.mul(&Value::variable(&self.index))?.add(value)?;
                }
            }
            let round: Vec<Segment> =
                edge.segments.iter().map(|segment| self.segment(segment, &here)).collect::<Result<_, Unsure>>()?;
            units.extend(repeat(Some(Value::integer((until - from) as i64)), &self.index, round)?);
            from = until;
        }
        Ok(units)
    }
}

fn differences(one: &Values, other: &Values) -> Result<Values, ValueError> {
    let change = |(name, value): (&Name, &Value)| {
        let after = other.get(name).unwrap_or(value);
        Ok((name.clone(), after.sub(value)?))
    };
    one.iter().map(change).collect()
}
