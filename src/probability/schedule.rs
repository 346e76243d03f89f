//! One process that draws how long its parts last, as the paper's generators of obstacles and of terrain do: an exponential
//! start, a normal length. What it shows when follows from the distributions of sums of durations.
//!
//! A duration that is drawn below 0 counts as 0.

use std::collections::BTreeMap;

use num_rational::BigRational;
use num_traits::{Signed, Zero};

use super::{Enclosed, Question};
use crate::definition::Definitions;
use crate::distribution::{Distribution, standard};
use crate::interval::{Interval, normal_between};
use crate::invariant::Claim;
use crate::name::Name;
use crate::substitution::substitute_values;
use crate::term::{Node, Term};
use crate::value::Value;

/// Definitions that are opened one in another, and parts of a sequence.
const MOST_PARTS: usize = 10_000;

/// How long a part lasts.
#[derive(Clone, Debug)]
enum Length {
    Known(BigRational),
    Drawn(Name),
    ForEver,
}

/// A part, and what it shows.
struct Span {
    length: Length,
    shown: Vec<Term>,
}

struct Reader<'a> {
    definitions: &'a Definitions,
    draws: BTreeMap<Name, Distribution>,
    spans: Vec<Span>,
    steps: usize,
}

/// The chance, if the system is one process that goes through its parts in a line.
///
/// # Errors
/// Where it is not, or the durations add up to something else than is known here.
pub fn schedule(
    components: &[Term],
    definitions: &Definitions,
    event: &Claim,
    question: &Question,
) -> Result<Enclosed, String> {
    let [component] = components else { return Err("several components last as long as is drawn".to_string()) };
    let mut reader = Reader { definitions, draws: BTreeMap::new(), spans: Vec::new(), steps: 0 };
    reader.read(component)?;
    let mut shown = Vec::new();
    for (place, span) in reader.spans.iter().enumerate() {
        if shows(event, &span.shown)? {
            shown.push(place);
        }
    }
    let place = match shown.as_slice() {
        [] => return Ok(Enclosed(Interval::exactly(0.0))),
        [place] => *place,
        _ => return Err("what is asked for is shown several times".to_string()),
    };
    let lengths: Vec<&Length> = reader.spans.iter().map(|span| &span.length).collect();
    let begun = reader.ended(&lengths[..place], &question.time)?;
    let chance = match (lengths[place], question.first) {
        (Length::ForEver, _) => begun,
        // It lasts some time, whatever came before it.
        (Length::Known(time), true) if time.is_positive() => begun,
        (Length::Known(_), true) => Interval::exactly(0.0),
        (Length::Drawn(name), true) => begun.times(reader.draw(name)?.more_than(&BigRational::zero())),
        (_, false) => begun.minus(reader.ended(&lengths[..=place], &question.time)?),
    };
    Ok(Enclosed(chance.probability()))
}

fn shows(event: &Claim, shown: &[Term]) -> Result<bool, String> {
    let duties = event.duties(shown).map_err(|error| error.0)?;
    for duty in &duties {
        for test in duty.premises.iter().chain(&duty.tests) {
            let difference = test.left.sub(&test.right).map_err(|error| error.0)?;
            let number = difference.as_rational();
            let number = number.ok_or_else(|| format!("{difference} is not a number where durations are drawn"))?;
            if !test.relation.holds(number.cmp(&BigRational::zero())) {
                return Ok(false);
            }
        }
    }
    Ok(!duties.is_empty())
}

impl Reader<'_> {
    fn read(&mut self, term: &Term) -> Result<(), String> {
        let mut work = vec![term.clone()];
        while let Some(term) = work.pop() {
            self.steps += 1;
            if self.steps > MOST_PARTS {
                return Err("the process goes on for too long".to_string());
            }
            if matches!(self.spans.last(), Some(Span { length: Length::ForEver, .. })) {
                return Ok(());
            }
            match term.node() {
                Node::Seq(parts) => work.extend(parts.iter().rev().cloned()),
                Node::Call(name, arguments) => {
                    let definition = self.definitions.get(name).filter(|definition| !definition.recursive);
                    let definition =
                        definition.ok_or_else(|| format!("{name} goes round and draws how long it lasts"))?;
                    let map = definition.parameters.iter().cloned().zip(arguments.iter().cloned()).collect();
                    let body = substitute_values(&definition.body, &map);
                    work.push(body.map_err(|_| format!("{name} cannot be opened"))?);
                }
                Node::Ran(distribution, name) => self.drawn(distribution, name)?,
                Node::Par(parts) if parts.iter().all(|part| matches!(part.node(), Node::Ran(..))) => {
                    for part in parts {
                        if let Node::Ran(distribution, name) = part.node() {
                            self.drawn(distribution, name)?;
                        }
                    }
                }
                _ => {
                    let span = self.span(&term)?;
                    self.spans.push(span);
                }
            }
        }
        Ok(())
    }

    fn drawn(&mut self, distribution: &Value, name: &Name) -> Result<(), String> {
        match self.draws.insert(name.clone(), Distribution::of(distribution)?) {
            Some(_) => Err(format!("{name} is drawn twice")),
            None => Ok(()),
        }
    }

    /// A delay, an observer, or several of them side by side.
    fn span(&self, term: &Term) -> Result<Span, String> {
        let parts = match term.node() {
            Node::Disable(parts) => parts.clone(),
            _ => vec![term.clone()],
        };
        let mut span = Span { length: Length::ForEver, shown: Vec::new() };
        for part in &parts {
            match part.node() {
                Node::Observe(..) => span.shown.push(part.clone()),
                Node::Idle => {}
                Node::Delay(time) if matches!(span.length, Length::ForEver) => span.length = self.length(time)?,
                _ => return Err("a part does more than to wait and to show".to_string()),
            }
        }
        Ok(span)
    }

    fn length(&self, time: &Value) -> Result<Length, String> {
        if let Some(number) = time.as_rational() {
            return if number.is_negative() {
                Err(format!("the duration {time} is negative"))
            } else {
                Ok(Length::Known(number))
            };
        }
        let name = time.as_variable().filter(|name| self.draws.contains_key(*name));
        Ok(Length::Drawn(name.ok_or_else(|| format!("the duration {time} is neither a number nor a draw"))?.clone()))
    }

    fn draw(&self, name: &Name) -> Result<&Distribution, String> {
        self.draws.get(name).ok_or_else(|| format!("{name} is not drawn"))
    }

    /// The chance that all these have ended by a time.
    fn ended(&self, lengths: &[&Length], time: &BigRational) -> Result<Interval, String> {
        let (mut left, mut names) = (time.clone(), Vec::new());
        for length in lengths {
            match length {
                Length::Known(known) => left -= known,
                Length::Drawn(name) if names.contains(&name) => return Err(format!("two parts last for {name}")),
                Length::Drawn(name) => names.push(name),
                Length::ForEver => return Ok(Interval::exactly(0.0)),
            }
        }
        if left.is_negative() {
            return Ok(Interval::exactly(0.0));
        }
        let drawn = names.into_iter().map(|name| self.draw(name)).collect::<Result<Vec<_>, _>>()?;
        match drawn.as_slice() {
            [] => Ok(Interval::exactly(1.0)),
            [one] => Ok(one.at_most(&left)),
            [Distribution::Exponential { rate, .. }, Distribution::Normal { mean, variance }]
            | [Distribution::Normal { mean, variance }, Distribution::Exponential { rate, .. }]
                if variance.is_positive() =>
            {
                Ok(Interval::exactly(1.0).minus(later(rate, mean, variance, &left)).probability())
            }
            _ => Err("these durations add up to no distribution that is known here".to_string()),
        }
    }
}

/// The chance that an exponential number and a normal one, which counts as 0 below that, add up to more than a number t
/// from 0 on: `P(N <= 0) e^(-lt) + ∫ from 0 to t of the density of N at y times e^(-l(t-y)) dy + P(N > t)`. The integral is
/// that of a normal density with the mean moved by `l var`, times `e^(l mean + l² var/2 - lt)`.
fn later(rate: &BigRational, mean: &BigRational, variance: &BigRational, time: &BigRational) -> Interval {
    let zero = BigRational::zero();
    let two = BigRational::from_integer(2.into());
    let moved = mean + rate * variance;
    let power = rate * mean + rate * rate * variance / two - rate * time;
    let inside = normal_between(standard(&zero, &moved, variance), standard(time, &moved, variance));
    let none = standard(&zero, mean, variance).normal().times(Interval::of(&(-rate * time)).exponential());
    let middle = inside.times(Interval::of(&power).exponential());
    none.plus(middle).plus(standard(time, mean, variance).opposite().normal())
}
