//! The part of a system that a question is about: components without a common port, directly or through others, do not
//! matter to each other as long as time passes in all of them, and all their values have a meaning.

use std::collections::BTreeSet;

use num_traits::Signed;

use crate::definition::Definitions;
use crate::distribution::Distribution;
use crate::lower::{Environment, System};
use crate::name::Name;
use crate::period::{self, Edge, End, Next, Segment, ports};
use crate::term::{Node, Term};
use crate::value::{Need, Relation, Value};

/// What is taken on trust where a part of a system stands for it.
pub(super) const BESIDE: &str = "that components without a common port do not matter to each other";

/// The components that may show these, with all that they are connected with; none where these are all components, or
/// time might stop in the others.
pub(super) fn relevant(system: &System, shown: &[Term], environment: &Environment) -> Option<System> {
    let definitions = &environment.definitions;
    let wanted: BTreeSet<&Name> = shown.iter().flat_map(observers).collect();
    let components = ports::flatten(&system.components, definitions);
    let groups = ports::System::of(&components, definitions).groups();
    let shows = |component: &usize| shows(&components[*component], definitions, &wanted);
    let (own, others): (Vec<_>, Vec<_>) = groups.into_iter().partition(|group| group.iter().any(shows));
    let of = |groups: &[Vec<usize>]| -> Vec<Term> {
        let kept: BTreeSet<usize> = groups.iter().flatten().copied().collect();
        kept.into_iter().map(|place| components[place].clone()).collect()
    };
    if own.is_empty() || others.is_empty() {
        return None;
    }
    let passes = |group: &Vec<usize>| {
        let components = of(std::slice::from_ref(group));
        means_something(&components, environment) && time_passes(&components, environment)
    };
    others.iter().all(passes).then(|| System { name: system.name.clone(), components: of(&own) })
}

fn observers(term: &Term) -> Vec<&Name> {
    let own = match term.node() {
        Node::Observe(name, _) => Some(name),
        _ => None,
    };
    own.into_iter().chain(term.children().flat_map(observers)).collect()
}

/// Whether one of these may be shown.
fn shows(term: &Term, definitions: &Definitions, wanted: &BTreeSet<&Name>) -> bool {
    let mut called = BTreeSet::new();
    let mut rest = vec![term];
    while let Some(term) = rest.pop() {
        match term.node() {
            Node::Observe(name, _) if wanted.contains(name) => return true,
            Node::Call(name, _) if called.insert(name.clone()) => {
                rest.extend(definitions.get(name).map(|definition| &definition.body));
            }
            _ => {}
        }
        rest.extend(term.children());
    }
    false
}

/// Whether all values of these components surely have a meaning, whatever the names in them stand for: a run ends where one
/// has none.
fn means_something(components: &[Term], environment: &Environment) -> bool {
    let definitions = &environment.definitions;
    let (mut called, mut bound, mut drawn) = (BTreeSet::new(), BTreeSet::new(), BTreeSet::new());
    let (mut rest, mut terms) = (components.to_vec(), Vec::new());
    while let Some(term) = rest.pop() {
        match term.node() {
            Node::Call(name, _) if called.insert(name.clone()) => {
                let Some(definition) = definitions.get(name) else { return false };
                bound.extend(definition.parameters.iter().cloned());
                rest.push(definition.body.clone());
            }
            Node::In(_, name) | Node::Set(_, name) | Node::Power(_, _, Some(name)) => {
                bound.insert(name.clone());
            }
            Node::Ran(_, name) => {
                drawn.insert(name.clone());
            }
            _ => {}
        }
        rest.extend(term.children().cloned());
        terms.push(term);
    }
    let fixed = |value: &Value| !value.variables().iter().any(|name| bound.contains(name) || drawn.contains(name));
    let granted = |need: &Need| fixed(need.value()) && environment.assumptions.grants(need) == Some(true);
    let lasts = |time: &Value| {
        // What is drawn below 0 takes no time.
        let own = time.as_variable().is_some_and(|name| drawn.contains(name) && !bound.contains(name));
        let zero = Value::zero();
        own || fixed(time) && environment.assumptions.decide(Relation::Gte, time, &zero) == Some(true)
    };
    terms.iter().all(|term| {
        let own = match term.node() {
            Node::Delay(time) => lasts(time),
            Node::Ran(distribution, _) => fixed(distribution) && Distribution::of(distribution).is_ok(),
            _ => true,
        };
        own && term.values().flat_map(Value::needs).all(|need| granted(&need))
    })
}

/// Whether time never stops in these components: they have a period, or each of their loops waits.
fn time_passes(components: &[Term], environment: &Environment) -> bool {
    let definitions = &environment.definitions;
    let stops = |next: &Next| matches!(next, Next::End(End::Livelock { .. }));
    let lasts = |edge: &Edge| {
        let long = |segment: &Segment| segment.duration.as_rational().is_some_and(|time| time.is_positive());
        edge.segments.iter().any(long)
    };
    let found = period::analyse(components, definitions, &environment.assumptions);
    // Of finitely many phases each takes a time that is a number, so that these add up beyond all bounds.
    let known = found.is_ok_and(|period| {
        let mut rounds = period.phases.iter().flat_map(|phase| &phase.edges);
        let passes = rounds.all(|edge| !stops(&edge.next) && (lasts(edge) || matches!(edge.next, Next::End(_))));
        passes && !period.initial.iter().any(|edge| stops(&edge.next))
    });
    known || components.iter().all(|component| loops_wait(component, definitions))
}

/// Whether each definition that is called on the way, if it may come back, waits for more than no time in each round.
fn loops_wait(component: &Term, definitions: &Definitions) -> bool {
    let mut called = BTreeSet::new();
    let mut rest = vec![component.clone()];
    while let Some(term) = rest.pop() {
        match term.node() {
            // How often these go round is not looked at here.
            Node::Loop(_) | Node::Power(..) => return false,
            Node::Call(name, _) if called.insert(name.clone()) => {
                let Some(definition) = definitions.get(name) else { return false };
                if comes_back(&definition.body, name, definitions) && !waits(&definition.body) {
                    return false;
                }
                rest.push(definition.body.clone());
            }
            _ => {}
        }
        rest.extend(term.children().cloned());
    }
    true
}

fn comes_back(body: &Term, wanted: &Name, definitions: &Definitions) -> bool {
    let mut called = BTreeSet::new();
    let mut rest = vec![body];
    while let Some(term) = rest.pop() {
        if let Node::Call(name, _) = term.node() {
            if name == wanted {
                return true;
            }
            if called.insert(name.clone()) {
                rest.extend(definitions.get(name).map(|definition| &definition.body));
            }
        }
        rest.extend(term.children());
    }
    false
}

/// Whether a sequence surely takes time before its last part: it waits for a number, or for one that is drawn and is surely
/// more than 0.
fn waits(body: &Term) -> bool {
    let Node::Seq(parts) = body.node() else { return false };
    let Some((_, before)) = parts.split_last() else { return false };
    // A draw counts for the delay right behind it, so that nothing else can have its name.
    let rising = |part: &Term, name: &Name| match part.node() {
        Node::Ran(value, drawn) => {
            let rising = |found: Distribution| match found {
                Distribution::Exponential { start, rising, .. } => rising && !start.is_negative(),
                Distribution::Uniform { low, .. } => low.is_positive(),
                _ => false,
            };
            drawn == name && Distribution::of(value).is_ok_and(rising)
        }
        _ => false,
    };
    let number = |part: &Term| match part.node() {
        Node::Delay(time) => time.as_rational().is_some_and(|time| time.is_positive()),
        _ => false,
    };
    let behind = |draw: &Term, part: &Term| match part.node() {
        Node::Delay(time) => time.as_variable().is_some_and(|name| rising(draw, name)),
        _ => false,
    };
    let shown = |branch: &Term| matches!(branch.node(), Node::Observe(..) | Node::Idle);
    let branches = |part: &Term, lasts: &dyn Fn(&Term) -> bool| match part.node() {
        Node::Disable(all) => all.iter().any(lasts) && all.iter().all(|branch| lasts(branch) || shown(branch)),
        _ => lasts(part),
    };
    before.iter().any(|part| branches(part, &number))
        || before.windows(2).any(|pair| matches!(pair, [draw, part] if branches(part, &|part| behind(draw, part))))
}
