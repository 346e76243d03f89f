//! `flow Sys`: the table of each phase, with what is expected of its flow functions, durations and closed forms.

use std::cell::RefCell;
use std::collections::BTreeMap;

use super::reading::{Run, Waiting};
use super::satisfies::{ALONG, closed_lines, examined, recurrence_lines};
use crate::assumption::Assumptions;
use crate::closed_form::term;
use crate::flow::{Exit, PhaseFlow, flows};
use crate::lower::Expectation;
use crate::name::Name;
use crate::period::{Next, Test};
use crate::report::Expected;
use crate::value::{Relation, Value};

/// What is expected of a flow, by how it is named.
enum Wanted {
    /// `f(r) = r+1`, `f2(r,k) = (r+1,k)`: the images of these variables in each round of a phase, the only one with rounds
    /// where it has no number; of a phase without rounds on each way to another.
    Images(Option<usize>, Vec<Name>),
    /// `lasting2 = 3`: how long each way through a phase takes.
    Lasting(usize),
    /// `r = r0+n` or `r(n) = r0+n`, with the index in which the table has it: the closed form of a variable of the only phase
    /// with rounds; or `r(10) = r0+10`, one of its values.
    Form(Name, Option<Name>),
    /// Of the period: `lasting = 3`, `phases = 2`.
    Period,
}

impl Wanted {
    fn of(name: &Name) -> Wanted {
        let text = name.as_str();
        let numbered = |word: &str, text: &str| -> Option<Option<usize>> {
            let digits = text.strip_prefix(word)?;
            if digits.is_empty() { Some(None) } else { digits.parse().ok().map(Some) }
        };
        if let Some((head, list)) = text.split_once('(') {
            let names = || list.trim_end_matches(')').split(',').map(Name::new).collect();
            return match numbered("f", head) {
                Some(phase) => Wanted::Images(phase, names()),
                None => Wanted::Form(Name::new(head), Some(Name::new(list.trim_end_matches(')')))),
            };
        }
        match numbered("lasting", text) {
            Some(Some(phase)) => Wanted::Lasting(phase),
            _ if matches!(text, "lasting" | "phases") => Wanted::Period,
            _ => Wanted::Form(name.clone(), None),
        }
    }
}

/// The values that are expected: those of the flow, and those of the period.
fn apart(expectation: &Expectation) -> (Vec<(Wanted, Value)>, Option<Expectation>) {
    let Expectation::Values(values) = expectation else { return (Vec::new(), Some(expectation.clone())) };
    let (mut own, mut of_period) = (Vec::new(), Vec::new());
    for (name, value) in values {
        match Wanted::of(name) {
            Wanted::Period => of_period.push((name.clone(), value.clone())),
            wanted => own.push((wanted, value.clone())),
        }
    }
    let of_period = (!of_period.is_empty()).then_some(Expectation::Values(of_period));
    (own, of_period)
}

impl Run<'_, '_> {
    pub(super) fn flow(&mut self, system: &Name, waiting: &Waiting) -> (Vec<String>, Vec<Expected>) {
        let (surroundings, environment) = (self.surroundings, &waiting.environment);
        let Some(found) = environment.system(system) else {
            return (vec![format!("there is no system {system}")], Run::unmet(&waiting.expected));
        };
        let wanted: Vec<_> = waiting.expected.iter().map(|(expectation, _)| apart(expectation)).collect();
        let stop = || surroundings.interrupted();
        // In each order of delays, what is expected of each flow.
        let met: RefCell<Vec<Vec<bool>>> = RefCell::default();
        let (lines, _, every) = examined(
            found,
            environment,
            &|_, period, environment| {
                let all = flows(period, environment);
                let known = &environment.assumptions;
                let is_met =
                    |(wanted, value): &(Wanted, Value)| is_met(wanted, value, &all, known, &stop) == Some(true);
                met.borrow_mut().push(wanted.iter().map(|(own, _)| own.iter().all(is_met)).collect());
                let mut lines: Vec<String> = all.iter().flat_map(|flow| told(flow, known, &stop)).collect();
                lines.extend(period.along_the_run.then(|| ALONG.to_string()));
                lines
            },
            super::delays::MOST_ORDERS,
            &stop,
        );
        let of_period: Vec<(Expectation, String)> =
            wanted.iter().filter_map(|(_, rest)| Some((rest.clone()?, String::new()))).collect();
        let mut of_period =
            if of_period.is_empty() { Vec::new() } else { self.period_of(found, environment, &of_period).1 }
                .into_iter();
        let met = met.into_inner();
        // Where an order has no period nothing holds in it.
        let holds = |place: usize| every && met.iter().all(|order| order.get(place) == Some(&true));
        let expected = waiting.expected.iter().zip(&wanted).enumerate().map(|(place, ((_, text), (own, rest)))| {
            let also = rest.is_none() || of_period.next().is_some_and(|one| one.met);
            Expected { text: text.clone(), met: also && (own.is_empty() || holds(place)) }
        });
        (lines, expected.collect())
    }
}

/// The table of a phase, as a recurrence too, with its closed forms and means.
fn told(flow: &PhaseFlow, known: &Assumptions, stop: &dyn Fn() -> bool) -> Vec<String> {
    let (mut lines, n) = (flow.lines(), flow.index());
    let next = |(name, next): &(Name, Value)| format!("  next      {} = {next}", term(name, &n, 1));
    lines.extend(flow.steps(&n).iter().map(next));
    lines.extend(recurrence_lines(flow, &n, known, stop));
    let means = flow.means(&n, known, stop);
    let means = means.iter().flat_map(|(name, closed)| closed_lines(name, closed, &n));
    lines.extend(means.map(|line| line.replacen("closed", "mean  ", 1)));
    lines
}

/// Whether a value is what is expected.
fn is_met(
    wanted: &Wanted,
    value: &Value,
    all: &[PhaseFlow],
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Option<bool> {
    let only = || {
        let mut with_rounds = all.iter().filter(|flow| !flow.maps.is_empty());
        with_rounds.next().filter(|_| with_rounds.next().is_none())
    };
    let numbered = |number: usize| all.get(number.checked_sub(1)?);
    match wanted {
        Wanted::Images(number, names) => {
            let flow = number.map_or_else(only, numbered)?;
            has_images(&ways(flow, all), names, &with_draws(value, flow)?, known)
        }
        Wanted::Lasting(number) => {
            let flow = numbered(*number)?;
            let lasts = |duration: Option<Value>, tests: &[Test]| {
                duration
                    .is_some_and(|duration| under(tests, known).decide(Relation::Eq, &duration, value) == Some(true))
            };
            let of_exits = flow.exits.iter().filter_map(|exit| Some((exit.passing()?.1, &exit.tests)));
            let mut ways = flow.ways.iter().map(|way| (way.duration(), &way.tests)).chain(of_exits).peekable();
            Some(ways.peek().is_some() && ways.all(|(duration, tests)| lasts(duration, tests)))
        }
        Wanted::Form(name, at) => has_form(only()?, (name, at.as_ref()), value, known, stop),
        Wanted::Period => None,
    }
}

/// Whether the closed form of a variable is this, or its value at an index.
fn has_form(
    flow: &PhaseFlow,
    (name, at): (&Name, Option<&Name>),
    value: &Value,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Option<bool> {
    let index = flow.index();
    let found = flow.recurrences(&index, known, stop);
    let (_, closed) = found.closed.iter().find(|(own, _)| own == name)?;
    let [piece] = closed.pieces.as_slice() else { return None };
    let mut known = known.clone();
    known.assume_natural(&index);
    for (relation, left, right) in &closed.conditions {
        known.assume(*relation, left, right);
    }
    let form = match at {
        Some(at) if *at != index => {
            let at = at.as_str().parse::<i64>().ok().filter(|at| *at >= 0)?;
            piece.form.with(&index, &Value::integer(at)).ok()?
        }
        _ => piece.form.clone(),
    };
    known.decide(Relation::Eq, &form, value)
}

/// What is known where these tests are met.
fn under(tests: &[Test], known: &Assumptions) -> Assumptions {
    let mut known = known.clone();
    tests.iter().for_each(|test| known.assume(test.relation, &test.left, &test.right));
    known
}

/// A way through a phase: its tests, and what the variables are behind it, as far as they are told.
type Images<'f> = (&'f [Test], BTreeMap<Name, Value>);

/// The rounds of a phase; where none comes back, what the parameters of its processes become, or its ways to other phases.
fn ways<'f>(flow: &'f PhaseFlow, all: &[PhaseFlow]) -> Vec<Images<'f>> {
    if !flow.maps.is_empty() {
        return flow.maps.iter().map(|(tests, map)| (tests.as_slice(), map.clone())).collect();
    }
    let behind = |exit: &'f Exit| {
        let Next::Phase(next) = exit.next else { return None };
        let kept = all.get(next)?.variables.iter().filter(|name| flow.variables.contains(name));
        let mut images: BTreeMap<Name, Value> = kept.map(|name| (name.clone(), Value::variable(name))).collect();
        images.extend(exit.map.iter().cloned());
        Some((exit.tests.as_slice(), images))
    };
    let carried = flow.carried.iter().filter_map(|one| {
        let own = one.before.variables().into_iter().find(|name| Value::variable(name) == one.before)?;
        Some((own, one.after.clone()))
    });
    let carried: BTreeMap<Name, Value> = carried.collect();
    if carried.is_empty() { flow.exits.iter().filter_map(behind).collect() } else { vec![(&[], carried)] }
}

/// Whether each way takes these variables to this where its tests are met, if it leads to where they are variables.
fn has_images(ways: &[Images<'_>], names: &[Name], value: &Value, known: &Assumptions) -> Option<bool> {
    let parts = if names.len() == 1 { vec![value.clone()] } else { value.components()? };
    let is_image = |(name, part): (&Name, &Value)| {
        let mut images = ways.iter().filter_map(|(tests, map)| Some((tests, map.get(name)?))).peekable();
        images.peek().is_some()
            && images.all(|(tests, image)| under(tests, known).decide(Relation::Eq, image, part) == Some(true))
    };
    Some(parts.len() == names.len() && names.iter().zip(&parts).all(is_image))
}

/// A value in what a phase draws: `w` for the only draw into w, which the table calls `w~1`.
fn with_draws(value: &Value, flow: &PhaseFlow) -> Option<Value> {
    let base = |drawn: &Name| drawn.as_str().split('~').next().map(Name::new);
    let named = |name: &Name| {
        let mut all = flow.draws.iter().map(|(drawn, _)| drawn).filter(|drawn| base(drawn).as_ref() == Some(name));
        let only = all.next().filter(|_| all.next().is_none() && !flow.variables.contains(name))?;
        Some((name.clone(), Value::variable(only)))
    };
    value.substitute(&value.variables().iter().filter_map(named).collect()).ok()
}
