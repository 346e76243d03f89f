//! What a property that has a probability asks for.

use std::borrow::Cow;

use crate::lower::{Environment, Event, Likelihood, Pattern, Property};
use crate::term::{Node, Term};
use crate::value::{Relation, Value};

/// What is to be shown, whether any time up to the given one counts, and that time.
pub(super) fn shown(likelihood: &Likelihood, environment: &Environment) -> Result<(Pattern, bool, Value), Vec<String>> {
    match &likelihood.event {
        Event::Shown { first, pattern, time } => Ok((pattern.clone(), *first, time.clone())),
        Event::Satisfies(property) => read(environment.property(property)).ok_or_else(|| {
            vec![
                format!("the probability of {property} is understood for `Delay_d ; At_a`,"),
                "and for `Ran_D<x> ; Delay_x ; At_a where P(x <= d) >= q` with a distribution D that is a parameter;"
                    .to_string(),
                "and for `Delay_{?x} ; At_a ; Lte_{?x,d}`, that it is shown by d, with one such bound;".to_string(),
                "all may end with comparisons of what is shown, as `At_{?a} ; Lte_{|?a-b|,e}`;".to_string(),
                "ask for `probability of Sys reaching At_a within d`, or `showing At_a at d`".to_string(),
            ]
        }),
    }
}

/// The same question with what a property asks for in place of its name, where that is understood.
pub(in crate::session) fn as_shown<'l>(likelihood: &'l Likelihood, environment: &Environment) -> Cow<'l, Likelihood> {
    match (&likelihood.event, shown(likelihood, environment)) {
        (Event::Satisfies(_), Ok((pattern, first, time))) => {
            Cow::Owned(Likelihood { event: Event::Shown { first, pattern, time }, ..likelihood.clone() })
        }
        _ => Cow::Borrowed(likelihood),
    }
}

/// What a property asks for, whether any time up to the given one counts, and that time. `Delay_d ; At_a` asks what is shown
/// at d, and `Delay_d ; At_{?a} ; Lte_{|?a-b|,e}` with which values. `Ran_D<x> ; Delay_x ; At_a where P(x <= d) >= q` with
/// an unknown D says that there is a distribution of the time of arrival of which this holds, so it asks for the first
/// passage, as does `Delay_{?x} ; At_a ; Lte_{?x,d}`.
fn read(property: Option<&Property>) -> Option<(Pattern, bool, Value)> {
    let Property { body, within, .. } = property?;
    let Node::Seq(parts) = body.as_ref()?.node() else { return None };
    let place = parts.iter().position(|part| matches!(part.node(), Node::Observe(..)))?;
    let (before, rest) = parts.split_at_checked(place)?;
    let (shown, guards) = rest.split_first()?;
    let (drawn, delay) = match before {
        [delay] => (None, delay),
        [drawn, delay] => (Some(drawn), delay),
        _ => return None,
    };
    let Node::Delay(time) = delay.node() else { return None };
    let condition = |guard: &Term| match guard.node() {
        Node::Guard(relation, left, right) => Some((*relation, left.clone(), right.clone())),
        _ => None,
    };
    let mut conditions = guards.iter().map(condition).collect::<Option<Vec<_>>>()?;
    let free = !shown.values().any(|value| time.as_variable().is_some_and(|name| value.mentions(name)));
    let latest = if free { latest(&mut conditions, time) } else { None };
    let names = shown.values().flat_map(Value::variables).filter(|name| name.as_str().starts_with('?'));
    let pattern = Pattern { terms: vec![shown.clone()], variables: names.collect(), conditions };
    match (drawn.map(Term::node), within) {
        (None, None) => match latest {
            Some(latest) => Some((pattern, true, latest)),
            None => Some((pattern, false, time.clone())),
        },
        (Some(Node::Ran(distribution, name)), Some((latest, ..))) => {
            let arrival = time.as_variable() == Some(name) && distribution.as_variable().is_some();
            arrival.then(|| (pattern, true, latest.clone()))
        }
        _ => None,
    }
}

/// The latest time at which something may be shown after a time that is to be found: taken out of what is asked, if that
/// time is not asked about otherwise.
fn latest(conditions: &mut Vec<(Relation, Value, Value)>, time: &Value) -> Option<Value> {
    let name = time.as_variable().filter(|name| name.as_str().starts_with('?'))?;
    let asked = |(_, left, right): &(Relation, Value, Value)| left.mentions(name) || right.mentions(name);
    let place = conditions.iter().position(asked)?;
    let latest = match &conditions[place] {
        (Relation::Lte, left, latest) if left == time => latest.clone(),
        (Relation::Gte, latest, right) if right == time => latest.clone(),
        _ => return None,
    };
    let again = conditions.iter().skip(place + 1).any(asked);
    if again || latest.mentions(name) {
        return None;
    }
    conditions.remove(place);
    Some(latest)
}
