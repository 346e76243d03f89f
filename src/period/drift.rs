//! Parts that never come back together: rounds whose durations have no rational ratio.

use std::collections::BTreeMap;

use num_bigint::BigInt;

use super::run::Run;
use super::step::inspect;
use super::{Edge, Failure, Next, Phase, Test};
use crate::assumption::Assumptions;
use crate::name::Name;
use crate::value::{Atom, Relation, Value, View};

impl Failure {
    /// Whether it says no more than that something is not known: there may be a period all the same.
    pub fn is_open(&self) -> bool {
        match self {
            Failure::Order { .. } | Failure::NoPeriod { .. } | Failure::Interrupted => true,
            Failure::Drift { one, other, .. } => rational_ratio(&one.1, &other.1).is_none(),
            _ => false,
        }
    }

    /// The same, and why none was found with variables for durations either.
    pub(super) fn with_variables(self, other: Failure) -> Failure {
        match (self, other) {
            (Failure::NoPeriod { reason }, Failure::NoPeriod { reason: why }) => {
                Failure::not_found(format!("{reason}; with variables for the durations: {why}"))
            }
            (own, _) => own,
        }
    }

    /// That none was found, and why.
    pub(super) fn not_found(reason: impl Into<String>) -> Failure {
        Failure::NoPeriod { reason: reason.into() }
    }
}

/// The ratio of two durations, if it is one number: whether it is rational.
pub(super) fn rational_ratio(one: &Value, other: &Value) -> Option<bool> {
    let ratio = one.div(other).ok()?;
    if ratio.as_rational().is_some() {
        return Some(true);
    }
    ratio.variables().is_empty().then_some(false)
}

/// Longer numbers are told by their size.
const MOST_DIGITS: usize = 40;
/// Pairs that are looked at before two durations are said to have no known ratio.
const MOST_PAIRS: usize = 100;

/// Whether two durations have a rational ratio, by themselves or by equations that are assumed.
fn commensurable(one: &Value, other: &Value, known: &Assumptions) -> bool {
    let equations: Vec<Value> =
        known.iter().filter(|(relation, _)| *relation == Relation::Eq).map(|(_, zero)| zero).collect();
    let mut pairs = vec![(one.clone(), other.clone())];
    let mut place = 0;
    while let Some((one, other)) = pairs.get(place).cloned() {
        if rational_ratio(&one, &other) == Some(true) {
            return true;
        }
        place += 1;
        for zero in &equations {
            for name in one.variables().union(&other.variables()) {
                let image = zero.linear_in(name).and_then(|(factor, rest)| rest.neg().ok()?.div(&factor).ok());
                let both = image.and_then(|image| Some((one.with(name, &image).ok()?, other.with(name, &image).ok()?)));
                if let Some(both) = both.filter(|both| pairs.len() < MOST_PAIRS && !pairs.contains(both)) {
                    pairs.push(both);
                }
            }
        }
    }
    false
}

/// Whether some of these durations have no rational ratio.
pub(super) fn apart<'a>(delays: impl Iterator<Item = &'a Value>, known: &Assumptions) -> bool {
    let mut delays = delays;
    let Some(first) = delays.next() else { return false };
    delays.any(|delay| !commensurable(first, delay, known))
}

/// The most rounds that are gone through with their values.
const MOST_ROUNDS: usize = 500;

/// How long one round takes, where these phases are gone through in one way only and take the same time for ever.
pub(super) fn round(initial: &[Edge], phases: &[Phase]) -> Option<Value> {
    let mut ways: &[Edge] = initial;
    let mut entered: Vec<Option<Value>> = vec![None; phases.len()];
    let mut time = Value::zero();
    loop {
        let [edge] = ways else { return None };
        time = time.add(&edge.duration().ok()?).ok()?;
        let Next::Phase(number) = edge.next else { return None };
        let phase = phases.get(number)?;
        let mut segments = phase.edges.iter().flat_map(|edge| &edge.segments);
        if segments.any(|segment| phase.variables.iter().any(|name| segment.duration.mentions(name))) {
            return None;
        }
        if let Some(before) = &entered[number] {
            return time.sub(before).ok();
        }
        entered[number] = Some(time.clone());
        ways = &phase.edges;
    }
}

/// How long it takes until all values come again, where they decide each branch: rounds may differ by these.
pub(super) fn round_of_values(initial: &[Edge], phases: &[Phase], known: &Assumptions) -> Option<Value> {
    let mut ways: &[Edge] = initial;
    let mut values: BTreeMap<Name, Value> = BTreeMap::new();
    let mut entered: Vec<(usize, BTreeMap<Name, Value>, Value)> = Vec::new();
    let mut time = Value::zero();
    while entered.len() <= MOST_ROUNDS {
        let holds = |test: &Test| test.substitute(&values).ok().and_then(|test| test.decide(known));
        let mut taken = None;
        for edge in ways {
            let decided: Option<Vec<bool>> = edge.tests.iter().map(holds).collect();
            if decided?.into_iter().all(|holds| holds) && taken.replace(edge).is_some() {
                return None;
            }
        }
        let edge = taken.filter(|edge| edge.draws.is_empty())?;
        let Next::Phase(number) = edge.next else { return None };
        time = time.add(&edge.duration().ok()?.substitute(&values).ok()?).ok()?;
        let next = edge.map.iter().map(|(name, value)| Some((name.clone(), value.substitute(&values).ok()?)));
        values = next.collect::<Option<_>>()?;
        if let Some((.., before)) = entered.iter().find(|(phase, then, _)| *phase == number && *then == values) {
            return time.sub(before).ok();
        }
        entered.push((number, values.clone(), time.clone()));
        ways = &phases.get(number)?.edges;
    }
    None
}

/// Why parts that do not communicate drift, if they do: their names with the durations of their rounds.
pub fn drifting(rounds: &[(String, Value)], known: &Assumptions) -> Option<Failure> {
    // Two with an irrational ratio settle it, whatever is not known of the others.
    let never = rounds.iter().enumerate().find_map(|(place, one)| {
        let other = rounds[..place].iter().find(|other| rational_ratio(&other.1, &one.1) == Some(false))?;
        Some((other, one))
    });
    let (first, others) = rounds.split_first()?;
    // What has a common multiple with the first has one with all that have.
    let open = || others.iter().find(|other| !commensurable(&first.1, &other.1, known)).map(|other| (first, other));
    let (one, other) = never.or_else(open)?;
    let rational = one.1.div(&other.1).ok().and_then(|ratio| rational_for_each(&ratio, known));
    Some(Failure::Drift { one: one.clone(), other: other.clone(), rational })
}

/// A natural number for each value of which a ratio is rational, if it depends on such numbers alone.
fn rational_for_each(ratio: &Value, known: &Assumptions) -> Option<Name> {
    let natural = |name: &Name| known.naturals().contains(name);
    let View::Real(above, below) = ratio.view() else { return None };
    let factors = above.iter().chain(&below).flat_map(|(_, factors)| factors);
    let mut natural = factors.map(|(atom, _)| match atom {
        Atom::Variable(name) if natural(name) => Some(name.clone()),
        _ => None,
    });
    let first = natural.next()??;
    natural.all(|name| name.is_some()).then_some(first)
}

/// Whether how often some of these durations go into the first depends on a natural number.
pub(super) fn counted<'a>(delays: impl Iterator<Item = &'a Value>, known: &Assumptions) -> bool {
    let mut delays = delays;
    let Some(first) = delays.next() else { return false };
    delays.any(|delay| delay.div(first).is_ok_and(|ratio| rational_for_each(&ratio, known).is_some()))
}

/// That a ratio is rational for each value of a natural number.
pub(super) fn rational_told(one: &Value, other: &Value, name: &Name) -> String {
    format!(
        ": the ratio of {one} and {other} is rational for each {name}, but how often each goes round depends on it; a period \
         is found where {name} is a number, such as `param {name} = 2`"
    )
}

/// How two delays that remain lie to each other: one may run once, so nothing follows from it for the rounds.
fn ratio_told(one: &Value, other: &Value, known: &Assumptions) -> String {
    match one.div(other) {
        Ok(ratio) if rational_ratio(one, other) == Some(false) => {
            format!(": {one} is {ratio} times {other}, which is irrational")
        }
        Ok(ratio) => match rational_for_each(&ratio, known) {
            Some(name) => rational_told(one, other, &name),
            None => what_would_do(one, other, "if"),
        },
        Err(_) => what_would_do(one, other, "if"),
    }
}

/// What would have to hold for two durations to have a common multiple; a period may follow from it, or there is one only then.
pub(super) fn what_would_do(one: &Value, other: &Value, when: &str) -> String {
    match rational_ratio(one, other) {
        Some(true) => return String::new(),
        Some(false) => {
            let ratio = one.div(other).map_or_else(|error| error.0, |ratio| ratio.to_string());
            return format!(": {one} is {ratio} times {other}, which is irrational, so no multiples of them are equal");
        }
        None => {}
    }
    let text = format!(": {one} and {other} have no known ratio; there is a period {when} it is rational");
    let (given, fixed) = match (other.as_variable(), one.as_variable()) {
        (Some(name), _) if !one.mentions(name) => (name, one),
        (_, Some(name)) if !other.mentions(name) => (name, other),
        _ => return text,
    };
    match Value::fraction(2, 3).and_then(|ratio| fixed.mul(&ratio)) {
        Ok(third) => format!("{text}, as with `param {given} = {third}`"),
        Err(_) => text,
    }
}

/// What would tell which of two durations is longer.
pub(super) fn what_tells(one: &Value, other: &Value) -> String {
    let Ok(less) = one.sub(other).map(|difference| difference.compared(Relation::Lss.symbol())) else {
        return String::new();
    };
    let (given, fixed) = match (other.as_variable(), one.as_variable()) {
        (Some(name), _) if !one.mentions(name) => (name, one),
        (_, Some(name)) if !other.mentions(name) => (name, other),
        _ => {
            return format!(
                "; `param {less}` tells this, and the same may be asked of later delays; a known ratio tells all"
            );
        }
    };
    match Value::fraction(2, 3).and_then(|ratio| fixed.mul(&ratio)) {
        Ok(third) => {
            let what = if third.as_rational().is_some() { "number" } else { "ratio" };
            format!(
                "; `param {less}` tells this, and the same may be asked of later delays; a {what} such as \
                 `param {given} = {third}` tells all of these two"
            )
        }
        Err(_) => String::new(),
    }
}

/// A number of many digits by its size.
fn in_short(delay: &Value) -> String {
    let text = delay.to_string();
    match delay.as_rational() {
        Some(number) if text.len() > MOST_DIGITS => {
            let digits = |number: &BigInt| number.to_string().len() as i64;
            let size = digits(number.numer()) - digits(number.denom());
            format!("of about 10^{}", if size < 0 { format!("({size})") } else { size.to_string() })
        }
        _ => text,
    }
}

/// That the same control points come again and again with other delays.
pub(super) fn growth(names: &[String], state: &[Run], phases: usize, known: &Assumptions) -> Failure {
    let mut left: Vec<(String, Value)> = Vec::new();
    for (name, run) in names.iter().zip(state) {
        let (mut delays, mut shown) = (Vec::new(), Vec::new());
        if inspect(run, &mut delays, &mut shown).is_ok() {
            left.extend(delays.into_iter().map(|delay| (name.clone(), delay)));
        }
    }
    let drifts = left.iter().enumerate().find_map(|(place, one)| {
        let other = left.get(place + 1..)?.iter().find(|other| rational_ratio(&one.1, &other.1) != Some(true))?;
        Some(ratio_told(&one.1, &other.1, known))
    });
    let drifts = drifts.unwrap_or_default();
    let left: Vec<String> = left.iter().map(|(name, delay)| format!("{name} {}", in_short(delay))).collect();
    let left = left.join(", ");
    Failure::not_found(format!("after {phases} phases the delays that remain ({left}) have not repeated{drifts}"))
}
