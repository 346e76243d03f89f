//! One process that draws how long its parts last, as the paper's generators of obstacles and of terrain do: an exponential
//! start, a normal length. What it shows when follows from the distributions of sums of durations.
//!
//! A duration that is drawn below 0 counts as 0. Durations are multiples of what is drawn, and sums of these.

use std::collections::BTreeMap;

use num_rational::BigRational;
use num_traits::{One, Signed, ToPrimitive, Zero};

use super::durations::{common_rate, erlang, later, never_negative, start};
use super::sums::Sum;
use super::{Enclosed, Question};
use crate::definition::Definitions;
use crate::distribution::Distribution;
use crate::interval::Interval;
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
    /// The end of a definition that was opened, with what names stood for before it, and whether a part that aborts in it
    /// ends it: so it is of a loop, and where the definition calls itself.
    Closed(BTreeMap<Name, Option<usize>>, bool),
}

struct Reader<'a> {
    definitions: &'a Definitions,
    draws: Vec<Distribution>,
    /// The place of what a name stands for; none where that is not clear.
    names: BTreeMap<Name, Option<usize>>,
    spans: Vec<Span>,
    steps: usize,
    /// How many rounds of loops are still to be opened, and whether there were more.
    rounds: usize,
    cut: bool,
}

const SEVERAL_TIMES: &str = "what is asked for is shown several times, and may last no time";

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
    for (number, rounds) in (1..).zip(ROUNDS) {
        let mut reader = Reader::new(definitions, rounds);
        reader.read(component)?;
        let later = match reader.cut {
            true => reader.ended(&reader.lengths(), &question.time)?.chance.high,
            false => 0.0,
        };
        if later <= LATER || question.first && !reader.shown(event)?.is_empty() {
            return reader.found(event, question, later);
        }
        // Sums of many draws are only known where all are exponential, with one rate.
        if number >= FEW && !reader.lengths().iter().all(|length| reader.rate(length).is_some()) {
            break;
        }
    }
    Err("it goes round, and draws how long it lasts, more often than is followed".to_string())
}

/// The rounds of a loop that are opened, until hardly any run comes behind them in time.
const ROUNDS: [usize; 5] = [3, 8, 30, 100, 300];
const FEW: usize = 2;
const LATER: f64 = 1e-9;
/// The chance of lasting no time that leaves what follows open.
const HARDLY: f64 = 1e-3;

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
            let number =
                number.ok_or_else(|| "what is asked compares what is drawn otherwise than as a time".to_string())?;
            if !test.relation.holds(number.cmp(&BigRational::zero())) {
                return Ok(false);
            }
        }
    }
    Ok(!duties.is_empty())
}

impl<'a> Reader<'a> {
    fn new(definitions: &'a Definitions, rounds: usize) -> Reader<'a> {
        Reader {
            definitions,
            draws: Vec::new(),
            names: BTreeMap::new(),
            spans: Vec::new(),
            steps: 0,
            rounds,
            cut: false,
        }
    }

    fn lengths(&self) -> Vec<&Length> {
        self.spans.iter().map(|span| &span.length).collect()
    }

    /// The places of what is asked for, each with the one behind the last that shows it without a break.
    fn shown(&self, event: &Claim) -> Result<Vec<(usize, usize)>, String> {
        let mut runs: Vec<(usize, usize)> = Vec::new();
        for (place, span) in self.spans.iter().enumerate() {
            if shows(event, &span.shown)? {
                match runs.last_mut().filter(|(_, end)| *end == place) {
                    Some((_, end)) => *end += 1,
                    None => runs.push((place, place + 1)),
                }
            }
        }
        Ok(runs)
    }

    /// The chance of what is asked for, where with this one a run comes behind what was read in time.
    fn found(&self, event: &Claim, question: &Question, later: f64) -> Result<Found, String> {
        let (lengths, mut sum, mut wide) = (self.lengths(), Enclosed::known(BigRational::zero()), later > 0.0);
        let shown = self.shown(event)?;
        if question.first {
            let Some((place, _)) = shown.first() else {
                let chance = if later > 0.0 { Enclosed::within(Interval::between(0.0, later)) } else { sum };
                return Ok(Found { chance, wide });
            };
            let begun = self.ended(&lengths[..*place], &question.time)?;
            let some = self.some(*place, &shown)?;
            return Ok(Found { chance: begun.chance.and(&some), wide: begun.wide || some.width() > LATER });
        }
        for (place, end) in shown {
            let begun = self.ended(&lengths[..place], &question.time)?;
            let ended = self.ended(&lengths[..end], &question.time)?;
            // A run behind all that was read may show anything.
            let ended =
                if self.cut && end == lengths.len() { Enclosed::known(BigRational::zero()) } else { ended.chance };
            sum = sum.or(&begun.chance.less(&ended));
            wide |= begun.wide;
        }
        if later > 0.0 {
            sum = Enclosed::within(sum.interval().plus(Interval::between(-later, later)).probability());
        }
        Ok(Found { chance: sum, wide })
    }

    /// The chance that the first place at which it is shown lasts some time; where it might not, there must be no other.
    fn some(&self, place: usize, shown: &[(usize, usize)]) -> Result<Enclosed, String> {
        let one = || Enclosed::known(BigRational::one());
        match &self.spans[place].length {
            Length::ForEver => Ok(one()),
            Length::Sum(_, time) if time.is_positive() => Ok(one()),
            Length::Sum(drawn, _) if drawn.is_empty() && self.cut => Err(SEVERAL_TIMES.to_string()),
            Length::Sum(drawn, _) if drawn.is_empty() && shown == [(place, place + 1)] => {
                Ok(Enclosed::known(BigRational::zero()))
            }
            length @ Length::Sum(drawn, _) => {
                let none = self.ended(&[length], &BigRational::zero())?;
                let certain = none.chance.number().is_some_and(Zero::is_zero);
                let before = &self.spans[..place];
                if !certain && before.iter().any(|span| drawn.iter().any(|(at, _)| span.length.has(*at))) {
                    return Err("what is shown lasts as long as something before it".to_string());
                }
                if !certain && (self.cut || shown != [(place, place + 1)]) {
                    // Where it lasts no time it may still be shown later, or not.
                    let most = none.chance.high;
                    let either =
                        Enclosed::within(Interval::exactly(1.0).minus(Interval::between(0.0, most)).probability());
                    return if most <= HARDLY { Ok(either) } else { Err(SEVERAL_TIMES.to_string()) };
                }
                Ok(one().less(&none.chance))
            }
        }
    }

    fn read(&mut self, term: &Term) -> Result<(), String> {
        let mut work = vec![Work::Part(term.clone())];
        while let Some(next) = work.pop() {
            self.steps += 1;
            if self.steps > MOST_PARTS {
                return Err("the process goes on for too long".to_string());
            }
            if self.cut || matches!(self.spans.last(), Some(Span { length: Length::ForEver, .. })) {
                return Ok(());
            }
            let term = match next {
                Work::Part(term) => term,
                Work::Closed(before, _) => {
                    self.close(before);
                    continue;
                }
            };
            match term.node() {
                Node::Seq(parts) => work.extend(parts.iter().rev().cloned().map(Work::Part)),
                Node::Power(body, count, index) => work.extend(copies(body, count, index.as_ref())?),
                Node::Loop(body) => {
                    self.round();
                    work.push(Work::Closed(self.names.clone(), true));
                    work.push(Work::Part(term.clone()));
                    work.push(Work::Part(body.clone()));
                }
                Node::Call(name, arguments) => {
                    let body = self.open(name, arguments)?;
                    let recursive = self.definitions.get(name).is_some_and(|definition| definition.recursive);
                    work.push(Work::Closed(self.names.clone(), recursive));
                    work.push(Work::Part(body));
                }
                Node::Ran(..) | Node::Set(..) => self.bound(&term)?,
                Node::Guard(..) if self.begins(&term) == Some(true) => {}
                Node::Guard(..) if self.begins(&term) == Some(false) => self.abort(&mut work),
                Node::Par(parts) if parts.iter().any(|part| self.begins(part) == Some(false)) => {
                    // A branch that aborts at once adds nothing to those that go on.
                    let on = parts.iter().filter(|part| self.begins(part) != Some(false)).cloned();
                    work.push(Work::Part(Term::par(on)));
                }
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

    /// Whether a part that begins with a guard on numbers goes on behind it; none of any other.
    fn begins(&self, part: &Term) -> Option<bool> {
        match part.node() {
            Node::Seq(parts) => self.begins(parts.first()?),
            Node::Guard(relation, left, right) => {
                let difference = self.resolved(left).ok()?.sub(&self.resolved(right).ok()?).ok()?;
                Some(relation.holds(difference.as_rational()?.cmp(&BigRational::zero())))
            }
            _ => None,
        }
    }

    /// Leaves what a part ends that aborts; where that is all, nothing is shown any more.
    fn abort(&mut self, work: &mut Vec<Work>) {
        while let Some(next) = work.pop() {
            if let Work::Closed(before, recursive) = next {
                self.close(before);
                if recursive {
                    return;
                }
            }
        }
        self.spans.push(Span { length: Length::ForEver, shown: Vec::new() });
    }

    /// One more round of a loop, which nothing ends: whatever might is not read here.
    fn round(&mut self) {
        self.cut |= self.rounds == 0;
        self.rounds = self.rounds.saturating_sub(1);
    }

    /// The body of a definition.
    fn open(&mut self, name: &Name, arguments: &[Value]) -> Result<Term, String> {
        let definition = self.definitions.get(name).ok_or_else(|| format!("{name} is not defined"))?;
        if definition.recursive {
            self.round();
        }
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

    /// The rate of a duration that is one exponential draw, or none at all.
    fn rate(&self, length: &Length) -> Option<Option<BigRational>> {
        match length {
            Length::Sum(drawn, _) if drawn.is_empty() => Some(None),
            Length::Sum(drawn, _) => {
                let [(place, factor)] = drawn.as_slice() else { return None };
                let one = self.draws[*place].affine(factor, &BigRational::zero())?;
                common_rate(&[one]).map(Some)
            }
            Length::ForEver => Some(None),
        }
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
            // Sums of few are known closer.
            all if all.len() > 8 && common_rate(all).is_some() => {
                let rate = common_rate(all).unwrap_or_else(BigRational::one);
                let starts = all.iter().filter_map(start).sum::<BigRational>();
                erlang(all.len(), &(rate * (&left - starts)))
            }
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

/// The rounds of a power, from the last to the first.
fn copies(body: &Term, count: &Value, index: Option<&Name>) -> Result<Vec<Work>, String> {
    let number =
        count.as_rational().filter(|number| number.is_integer()).and_then(|number| number.to_integer().to_usize());
    let number = number.filter(|number| *number <= MOST_PARTS).ok_or("how many rounds there are is no number")?;
    let copy = |place: usize| match index {
        Some(name) => {
            let map = BTreeMap::from([(name.clone(), Value::integer(place as i64))]);
            substitute_values(body, &map).map(Work::Part).map_err(|_| "a round cannot be opened".to_string())
        }
        None => Ok(Work::Part(body.clone())),
    };
    (0..number).rev().map(copy).collect()
}

/// The name of what is drawn at a place; no source text can spell it.
fn draw_name(place: usize) -> Name {
    Name::new(&format!("(draw {place})"))
}
