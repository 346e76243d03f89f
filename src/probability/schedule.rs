//! One process that draws how long its parts last, as the paper's generators of obstacles and of terrain do: an exponential
//! start, a normal length. What it shows when follows from the distributions of sums of durations.
//!
//! A duration that is drawn below 0 counts as 0. Durations are multiples of what is drawn, and sums of these.

use std::collections::BTreeMap;

use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use super::sums::Sum;
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
    /// Multiples of what is drawn, by their places, and what is added; none of them is negative but a multiple that stands
    /// alone, which then counts as 0.
    Sum(Vec<(usize, BigRational)>, BigRational),
    ForEver,
}

/// A part, and what it shows.
struct Span {
    length: Length,
    shown: Vec<Term>,
}

/// What is left to read.
enum Work {
    Part(Term),
    /// The end of a definition that was opened, with what names stood for before it.
    Closed(BTreeMap<Name, Option<usize>>),
}

struct Reader<'a> {
    definitions: &'a Definitions,
    draws: Vec<Distribution>,
    /// The place of what a name stands for; none where that is not clear.
    names: BTreeMap<Name, Option<usize>>,
    spans: Vec<Span>,
    steps: usize,
}

/// Why nothing is said here of most systems.
pub const SEVERAL: &str = "durations that are drawn are added up in one component alone, and there are several";

/// A chance, and whether it may be wider than rounding makes it.
pub struct Found {
    /// The chance.
    pub chance: Enclosed,
    /// Whether a bound on what was left out is part of it.
    pub wide: bool,
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
) -> Result<Found, String> {
    let [component] = components else {
        return Err(SEVERAL.to_string());
    };
    let mut reader = Reader { definitions, draws: Vec::new(), names: BTreeMap::new(), spans: Vec::new(), steps: 0 };
    reader.read(component)?;
    let mut shown = Vec::new();
    for (place, span) in reader.spans.iter().enumerate() {
        if shows(event, &span.shown)? {
            shown.push(place);
        }
    }
    let never = || Enclosed::known(BigRational::zero());
    let place = match shown.as_slice() {
        [] => return Ok(Found { chance: never(), wide: false }),
        [place] => *place,
        _ => return Err("what is asked for is shown several times".to_string()),
    };
    let lengths: Vec<&Length> = reader.spans.iter().map(|span| &span.length).collect();
    let begun = reader.ended(&lengths[..place], &question.time)?;
    let (chance, wide) = match (lengths[place], question.first) {
        (Length::ForEver, _) => (begun.chance, begun.wide),
        // It lasts some time, whatever came before it.
        (Length::Sum(_, time), true) if time.is_positive() => (begun.chance, begun.wide),
        (Length::Sum(drawn, _), true) if drawn.is_empty() => (never(), false),
        (length @ Length::Sum(drawn, _), true) => {
            let none = reader.ended(&[length], &BigRational::zero())?;
            let certain = none.chance.number().is_some_and(Zero::is_zero);
            if !certain && reader.spans[..place].iter().any(|span| drawn.iter().any(|(at, _)| span.length.has(*at))) {
                return Err("what is shown lasts as long as something before it".to_string());
            }
            let some = Enclosed::known(BigRational::one()).less(&none.chance);
            (begun.chance.and(&some), begun.wide)
        }
        (_, false) => {
            let ended = reader.ended(&lengths[..=place], &question.time)?;
            (begun.chance.less(&ended.chance), begun.wide || ended.wide)
        }
    };
    Ok(Found { chance, wide })
}

impl Length {
    /// Whether it depends on a draw.
    fn has(&self, draw: usize) -> bool {
        matches!(self, Length::Sum(drawn, _) if drawn.iter().any(|(place, _)| *place == draw))
    }
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
        let mut work = vec![Work::Part(term.clone())];
        while let Some(next) = work.pop() {
            self.steps += 1;
            if self.steps > MOST_PARTS {
                return Err("the process goes on for too long".to_string());
            }
            if matches!(self.spans.last(), Some(Span { length: Length::ForEver, .. })) {
                return Ok(());
            }
            let term = match next {
                Work::Part(term) => term,
                Work::Closed(before) => {
                    self.close(before);
                    continue;
                }
            };
            match term.node() {
                Node::Seq(parts) => work.extend(parts.iter().rev().cloned().map(Work::Part)),
                Node::Call(name, arguments) => {
                    let body = self.open(name, arguments)?;
                    work.push(Work::Closed(self.names.clone()));
                    work.push(Work::Part(body));
                }
                Node::Ran(..) | Node::Set(..) => self.bound(&term)?,
                Node::Par(parts) if parts.iter().all(|part| matches!(part.node(), Node::Ran(..) | Node::Set(..))) => {
                    parts.iter().try_for_each(|part| self.bound(part))?;
                }
                _ => {
                    let span = self.span(&term)?;
                    self.spans.push(span);
                }
            }
        }
        Ok(())
    }

    /// The body of a definition that does not go round.
    fn open(&self, name: &Name, arguments: &[Value]) -> Result<Term, String> {
        let definition = self.definitions.get(name).filter(|definition| !definition.recursive);
        let definition = definition.ok_or_else(|| format!("{name} goes round and draws how long it lasts"))?;
        let known = arguments.iter().map(|argument| self.resolved(argument)).collect::<Result<Vec<_>, _>>()?;
        let map = definition.parameters.iter().cloned().zip(known).collect();
        substitute_values(&definition.body, &map).map_err(|_| format!("{name} cannot be opened"))
    }

    /// What a definition has drawn under a name that was in use before it is not looked for behind it.
    fn close(&mut self, before: BTreeMap<Name, Option<usize>>) {
        for (name, place) in before {
            if self.names.get(&name) != Some(&place) {
                self.names.insert(name, None);
            }
        }
    }

    /// A draw, or a value that is set: drawn from a point.
    fn bound(&mut self, term: &Term) -> Result<(), String> {
        match term.node() {
            Node::Ran(distribution, name) => self.drawn(distribution, name),
            Node::Set(value, name) => {
                let value = self.resolved(value)?;
                let point = Value::distribution("Point", vec![value]).map_err(|error| error.0)?;
                self.drawn(&point, name)
            }
            _ => Ok(()),
        }
    }

    fn drawn(&mut self, distribution: &Value, name: &Name) -> Result<(), String> {
        self.draws.push(Distribution::of(distribution)?);
        self.names.insert(name.clone(), Some(self.draws.len() - 1));
        Ok(())
    }

    /// A value over what is drawn, by its places, in place of the names.
    fn resolved(&self, value: &Value) -> Result<Value, String> {
        let mut map = BTreeMap::new();
        for name in value.variables() {
            match self.names.get(&name) {
                Some(Some(place)) => {
                    map.insert(name, Value::variable(&draw_name(*place)));
                }
                Some(None) => return Err(format!("it is not clear which draw {name} is")),
                None => {}
            }
        }
        value.substitute(&map).map_err(|error| error.0)
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
        let mut rest = self.resolved(time)?;
        let unknown = || format!("the duration {time} is neither a number nor a sum of draws");
        let mut drawn = Vec::new();
        for name in rest.variables() {
            let place = (0..self.draws.len()).find(|place| draw_name(*place) == name).ok_or_else(unknown)?;
            let (factor, other) = rest.linear_in(&name).ok_or_else(unknown)?;
            drawn.push((place, factor.as_rational().ok_or_else(unknown)?));
            rest = other;
        }
        let number = rest.as_rational().ok_or_else(unknown)?;
        if number.is_negative() && drawn.is_empty() {
            return Err(format!("the duration {time} is negative"));
        }
        let alone = drawn.len() == 1 && number.is_zero();
        let positive = |(place, _): &(usize, BigRational)| alone || never_negative(&self.draws[*place]);
        if number.is_negative() || drawn.iter().any(|one| !one.1.is_positive() || !positive(one)) {
            return Err(format!("the duration {time} may be negative"));
        }
        Ok(Length::Sum(drawn, number))
    }

    /// The chance that all these have ended by a time.
    fn ended(&self, lengths: &[&Length], time: &BigRational) -> Result<Found, String> {
        let (mut left, mut factors) = (time.clone(), BTreeMap::<usize, BigRational>::new());
        let known = |holds: bool| {
            let number = if holds { BigRational::one() } else { BigRational::zero() };
            Ok(Found { chance: Enclosed::known(number), wide: false })
        };
        for length in lengths {
            let Length::Sum(drawn, number) = length else { return known(false) };
            left -= number;
            for (place, factor) in drawn {
                *factors.entry(*place).or_insert_with(BigRational::zero) += factor;
            }
        }
        if left.is_negative() || factors.is_empty() {
            return known(!left.is_negative());
        }
        let mut drawn = Vec::new();
        for (place, factor) in &factors {
            let scaled = self.draws[*place].affine(factor, &BigRational::zero());
            drawn.push(scaled.ok_or("a multiple of what is drawn is not known here")?);
        }
        let chance = match drawn.as_slice() {
            [one @ (Distribution::Normal { .. } | Distribution::Poisson { .. })] => {
                Enclosed::within(one.at_most(&left))
            }
            [Distribution::Exponential { rate, start, .. }, Distribution::Normal { mean, variance }]
            | [Distribution::Normal { mean, variance }, Distribution::Exponential { rate, start, .. }]
                if variance.is_positive() && start.is_zero() =>
            {
                let late = later(rate, mean, variance, &left);
                Enclosed::within(Interval::exactly(1.0).minus(late).probability())
            }
            _ => {
                let mut sum = Sum::new(true);
                drawn.iter().try_for_each(|one| sum.add(one))?;
                return Ok(Found { chance: sum.at_most(&left)?, wide: sum.is_wide() });
            }
        };
        Ok(Found { chance, wide: false })
    }
}

/// The name of what is drawn at a place; no source text can spell it.
fn draw_name(place: usize) -> Name {
    Name::new(&format!("(draw {place})"))
}

/// Whether a number of this distribution is never below 0.
fn never_negative(distribution: &Distribution) -> bool {
    match distribution {
        Distribution::Point(at) => !at.is_negative(),
        Distribution::Normal { mean, variance } => variance.is_zero() && !mean.is_negative(),
        Distribution::Uniform { low, .. } => !low.is_negative(),
        Distribution::Exponential { start, rising, .. } => *rising && !start.is_negative(),
        Distribution::Poisson { .. } => true,
        Distribution::Mixture(parts) => parts.iter().all(|(_, part)| never_negative(part)),
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
