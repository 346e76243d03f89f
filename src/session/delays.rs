//! Two delays of which it is not known which ends first: what can be said is said in each order of them.

use std::collections::BTreeSet;

use super::claim::Found;
use crate::closed_form::{Comparison, compared};
use crate::lower::{Environment, Quantity, System};
use crate::name::Name;
use crate::period::Failure;
use crate::report::Verdict;
use crate::scope::{calls, subterms};
use crate::term::{Node, Term};
use crate::value::{Relation, Sort, Value};
use crate::verify::side;

/// Orders that are looked at inside one another, and of a claim.
pub(crate) const MOST_ORDERS: usize = 3;
pub(super) const MOST_CLAIMED: usize = 3;

/// So many orders inside one another are looked at in a system whose time in the end is known: of more delays that are
/// symbols, which they would not settle, one alone.
pub(crate) fn orders_beside(system: &System, environment: &Environment, in_the_end: impl Fn() -> bool) -> usize {
    let (mut seen, mut delays) = (BTreeSet::new(), BTreeSet::new());
    let mut open: Vec<Term> = system.components.clone();
    let symbol = |quantity: &Quantity| matches!(quantity, Quantity::Parameter { constant: None, .. });
    if environment.quantities().filter(|(_, quantity)| symbol(quantity)).count() <= MOST_ORDERS {
        return MOST_ORDERS;
    }
    while let Some(term) = open.pop() {
        for part in subterms(&term) {
            if let Node::Delay(time) = part.node()
                && time.as_rational().is_none()
            {
                delays.insert(time.clone());
            }
        }
        let called = calls(&term).into_iter().filter(|name| seen.insert(name.clone())).collect::<Vec<_>>();
        open.extend(called.iter().filter_map(|name| Some(environment.definitions.get(name)?.body.clone())));
    }
    if delays.len() > MOST_ORDERS && in_the_end() { 1 } else { MOST_ORDERS }
}

/// What is assumed in one order.
pub(crate) struct Order {
    /// How the two compare.
    when: Comparison,
    /// The same in words: `if a < b`.
    pub(crate) title: String,
    /// What was declared, with that.
    pub(crate) environment: Environment,
}

impl Order {
    /// What was declared, with this.
    fn of(when: Comparison, mut environment: Environment) -> Order {
        let (relation, left, right) = &when;
        environment.assumptions.assume(*relation, left, right);
        Order { title: format!("if {}", compared(&when)), when, environment }
    }
}

/// The orders of two delays, where no period was found for not knowing which ends first; none where that is not the reason,
/// or what remains of them depends on more than parameters.
fn orders(failures: &[Failure], environment: &Environment) -> Vec<Order> {
    let [Failure::Order { one, other }] = failures else { return Vec::new() };
    let (one, other) = (&one.1, &other.1);
    let declared = |value: &Value| value.variables().iter().all(|name| environment.quantity(name).is_some());
    if !declared(one) || !declared(other) {
        return Vec::new();
    }
    let may_be = |order: &Relation| environment.assumptions.decide(*order, one, other) != Some(false);
    let orders = [Relation::Lss, Relation::Eq, Relation::Gtr].into_iter().filter(may_be);
    let with = |order: Relation| Order::of((order, one.clone(), other.clone()), environment.clone());
    orders.map(with).collect()
}

/// The cases of a comparison of parameters that would have to be known, and of its opposite.
pub(super) fn either_case(open: &[Comparison], environment: &Environment) -> Vec<Order> {
    let known = &environment.assumptions;
    let declared = |name: &Name| environment.quantity(name).is_some();
    let Some((relation, left, right)) = open.iter().find_map(|asked| side(asked, known, &declared)) else {
        return Vec::new();
    };
    let with = |relation: Relation| Order::of((relation, left.clone(), right.clone()), environment.clone());
    vec![with(relation), with(relation.negated())]
}

/// What comes of each order, where it is asked at all; `most`: so many orders inside one another.
pub(crate) fn in_orders<T>(
    failures: &[Failure],
    environment: &Environment,
    most: usize,
    each: impl FnMut(&Order) -> T,
) -> (Vec<Order>, Vec<T>) {
    let orders = if most > 0 { orders(failures, environment) } else { Vec::new() };
    let found = orders.iter().map(each).collect();
    (orders, found)
}

/// What is said in one order.
pub(crate) fn told(title: &str, lines: Vec<String>) -> impl Iterator<Item = String> {
    let lines = lines.into_iter().map(|line| format!("  {line}"));
    std::iter::once(format!("{title}:")).chain(lines)
}

impl Found {
    /// What came of a claim in each order, if it was settled in one of them: refuted where it is in one, for that is a run of
    /// what was declared. `together`: proved where it is proved in each; else where its names stand for values that are, as
    /// they are written for all orders, equal to those in each.
    pub(super) fn in_each(orders: &[Order], cases: Vec<Found>, together: bool) -> Option<Found> {
        // Of no order nothing would be said, and so anything of each.
        if orders.is_empty() || cases.len() != orders.len() {
            return None;
        }
        let all = |verdict: Verdict| cases.iter().all(|case| case.verdict == Some(verdict));
        let some = |verdict: Verdict| cases.iter().any(|case| case.verdict == Some(verdict));
        let of = |chosen: fn(&Found) -> &Values| in_all(orders, &cases.iter().map(chosen).collect::<Vec<_>>());
        let same = || of(|case| &case.values).zip(of(|case| &case.steady));
        let named = if together || !all(Verdict::Proved) { None } else { same() };
        let verdict = match () {
            () if some(Verdict::Refuted) => Some(Verdict::Refuted),
            () if (together || named.is_some()) && all(Verdict::Proved) => Some(Verdict::Proved),
            () if some(Verdict::Proved) => None,
            () => return None,
        };
        let trusted =
            named.iter().map(|_| "that one of these orders holds, whatever the delays are".to_string()).collect();
        let (values, steady) = named.unwrap_or_default();
        let mut found = Found { verdict, values, steady, trusted, ..Found::default() };
        if verdict.is_none() && all(Verdict::Proved) {
            found.remains = vec![
                "it is proved in each case, but with other durations in each, so that no one theorem says it"
                    .to_string(),
            ];
        }
        // Of a refutation one order is enough.
        let refuted = verdict == Some(Verdict::Refuted);
        let told = orders.iter().zip(cases).filter(|(_, case)| !refuted || case.verdict == verdict);
        for (order, case) in told.take(if refuted { 1 } else { orders.len() }) {
            let title = &order.title;
            let verdict = match case.verdict {
                Some(Verdict::Proved) => "proved",
                Some(Verdict::Refuted) => "refuted",
                _ => {
                    found.remains.extend(case.remains.iter().map(|line| format!("{title}: {line}")));
                    "could not prove"
                }
            };
            let values = case.values.iter().map(|(name, value)| format!("{name} = {value}")).collect::<Vec<_>>();
            let with = if values.is_empty() { String::new() } else { format!(", with {}", values.join(", ")) };
            let lines = case.trace.into_iter().chain(case.feedback);
            found.trace.extend(self::told(&format!("{title}, {verdict}{with}"), lines.collect()));
            let kernel = case.evidence.iter().flat_map(|evidence| evidence.theorem.trusted().iter().cloned());
            let trusted = kernel.chain(case.trusted).filter(|line| !found.trusted.contains(line)).collect::<Vec<_>>();
            found.trusted.extend(trusted);
        }
        Some(found)
    }
}

/// What names stand for.
type Values = Vec<(Name, Value)>;

/// What names stand for in all orders: of each a value that is in every order what it is there. Where one of two delays ends
/// first that is often the greater or the lesser of two.
fn in_all(orders: &[Order], cases: &[&Values]) -> Option<Values> {
    let first = cases.first()?;
    if cases.iter().any(|case| case.len() != first.len()) {
        return None;
    }
    let all = |name: &Name| {
        let own = |case: &&Values| case.iter().find(|(other, _)| other == name).map(|(_, value)| value.clone());
        let own: Vec<Value> = cases.iter().map(own).collect::<Option<_>>()?;
        let fits = |value: &Value| {
            let equal = |(order, here): (&Order, &Value)| {
                order.environment.assumptions.decide(Relation::Eq, value, here) == Some(true)
            };
            orders.iter().zip(&own).all(equal)
        };
        // Where both are equal one may be written as neither is elsewhere.
        let pairs = own.iter().enumerate().flat_map(|(place, one)| own[..place].iter().map(move |other| [one, other]));
        let ends =
            pairs.flat_map(|pair| [greatest(&pair), least(&pair)]).chain([greatest(&own.iter().collect::<Vec<_>>())]);
        own.iter().cloned().chain(ends.flatten()).chain(chosen(orders, &own)).find(fits)
    };
    first.iter().map(|(name, _)| Some((name.clone(), all(name)?))).collect()
}

/// What a name stands for by the order: `if w >= 2 then 2*w-2 else w+1`; of one condition where that is enough.
fn chosen(orders: &[Order], own: &[Value]) -> Vec<Value> {
    let either = |one: usize, relation: Relation, other: usize| {
        let (_, left, right) = &orders.first()?.when;
        Value::choose(relation, left, right, own.get(one)?, own.get(other)?).ok()
    };
    let whole = || {
        let (last, before) = own.split_last()?;
        before.iter().zip(orders).rev().try_fold(last.clone(), |other, (value, order)| {
            let (relation, left, right) = &order.when;
            Value::choose(*relation, left, right, value, &other).ok()
        })
    };
    let last = own.len().saturating_sub(1);
    let Some((relation, ..)) = orders.first().map(|order| &order.when) else { return Vec::new() };
    let wider = if *relation == Relation::Lss { Relation::Lte } else { *relation };
    [either(0, *relation, last), either(0, wider, last), whole()].into_iter().flatten().collect()
}

fn greatest(values: &[&Value]) -> Option<Value> {
    let real = values.iter().all(|value| value.sort() == Sort::Real);
    let values: Vec<Value> = values.iter().map(|value| (*value).clone()).collect();
    Value::maximum(&values).ok().filter(|_| real)
}

fn least(values: &[&Value]) -> Option<Value> {
    let negative: Option<Vec<Value>> = values.iter().map(|value| value.neg().ok()).collect();
    greatest(&negative?.iter().collect::<Vec<_>>())?.neg().ok()
}
