//! The part of a system that a question is about: components without a common port, directly or through others, do not
//! matter to each other as long as time passes in all of them, and all their values have a meaning.

use std::collections::BTreeSet;

use num_traits::Signed;

use crate::assumption::Assumptions;
use crate::definition::Definitions;
use crate::distribution::Distribution;
use crate::lower::{Environment, Pattern, System};
use crate::name::Name;
use crate::period::{self, Edge, End, Next, Period, Phase, Test, ports};
use crate::sample::reached;
use crate::scope::subterms;
use crate::term::{Node, Term};
use crate::value::{Need, Relation, Value};

/// What is taken on trust where a part of a system stands for it.
pub(crate) const BESIDE: &str = "that components without a common port do not matter to each other";

/// What is taken on trust where what reads alone is left out as well.
pub(super) const READERS: &str = "that components without a common port do not matter to each other, nor to others what only reads what is \
                                  written again and again";

/// What leaves some components of a system out.
pub(super) type Leaving = fn(&System, &[Term], &Environment) -> Option<System>;

/// The components that may show these, with all that they are connected with; none where these are all components, or
/// time might stop in the others.
pub(super) fn relevant(system: &System, shown: &[Term], environment: &Environment) -> Option<System> {
    let components = ports::flatten(&system.components, &environment.definitions);
    let groups = ports::System::of(&components, &environment.definitions).groups();
    let own = showing(&components, groups, shown, environment)?;
    Some(System { name: system.name.clone(), components: own })
}

/// The same without those that only read, from ports on which a process writes the same again and again to whoever comes: a
/// camera beside a robot that reads where it is. None where there are none such.
pub(super) fn without_readers(system: &System, shown: &[Term], environment: &Environment) -> Option<System> {
    let definitions = &environment.definitions;
    let components = ports::flatten(&system.components, definitions);
    let closed = ports::System::of(&components, definitions);
    let wanted: BTreeSet<&Name> = shown.iter().flat_map(observers).collect();
    let reads_alone = |place: usize| {
        let shows = parts(&components[place], definitions).flat_map(observers).any(|name| wanted.contains(name));
        let endless = |port: &Name| components.iter().all(|one| writes_endlessly(one, port, definitions));
        let reads = &closed.reads[place];
        !shows && closed.writes[place].is_empty() && !reads.is_empty() && reads.iter().all(endless)
    };
    let (readers, others): (Vec<usize>, Vec<usize>) = (0..components.len()).partition(|place| reads_alone(*place));
    let of = |places: &[usize]| -> Vec<Term> { places.iter().map(|place| components[*place].clone()).collect() };
    // What it reads comes at once, so that only its own delays let time pass.
    let waits = |place: &usize| loops_wait(&components[*place], environment);
    if readers.is_empty() || !readers.iter().all(waits) || !means_something(&of(&readers), environment) {
        return None;
    }
    let rest = of(&others);
    let groups = ports::System::of(&rest, definitions).groups();
    let own = showing(&rest, groups, shown, environment).unwrap_or(rest);
    Some(System { name: system.name.clone(), components: own })
}

/// Whether all that a component writes on a port stands in a process that writes it and is then the same again.
fn writes_endlessly(component: &Term, port: &Name, definitions: &Definitions) -> bool {
    let writes = |term: &Term| matches!(term.node(), Node::Out(own, _) if own == port);
    let endless = |name: &Name| {
        let Some(definition) = definitions.get(name) else { return false };
        let Node::Seq(steps) = definition.body.node() else { return false };
        let steps: Vec<&Term> = steps.iter().collect();
        let [out, again] = steps.as_slice() else { return false };
        let Node::Call(called, arguments) = again.node() else { return false };
        let same = definition.parameters.iter().eq(arguments.iter().filter_map(Value::as_variable));
        writes(out) && called == name && same && arguments.len() == definition.parameters.len()
    };
    let bodies = reached(component, definitions);
    let mut elsewhere = bodies.iter().filter(|name| !endless(name)).filter_map(|name| definitions.get(name));
    !subterms(component).any(writes) && !elsewhere.any(|definition| subterms(&definition.body).any(writes))
}

/// Of groups of components those that may show these; none where all do or none does, or time might stop in the others.
fn showing(
    components: &[Term],
    groups: Vec<Vec<usize>>,
    shown: &[Term],
    environment: &Environment,
) -> Option<Vec<Term>> {
    let definitions = &environment.definitions;
    let wanted: BTreeSet<&Name> = shown.iter().flat_map(observers).collect();
    let shows = |component: &usize| {
        parts(&components[*component], definitions).flat_map(observers).any(|name| wanted.contains(name))
    };
    let (own, others): (Vec<_>, Vec<_>) = groups.into_iter().partition(|group| group.iter().any(shows));
    let of = |groups: &[Vec<usize>]| -> Vec<Term> {
        let kept: BTreeSet<usize> = groups.iter().flatten().copied().collect();
        kept.into_iter().map(|place| components[place].clone()).collect()
    };
    if own.is_empty() || others.is_empty() {
        return None;
    }
    others.iter().all(|group| passes(&of(std::slice::from_ref(group)), environment)).then(|| of(&own))
}

/// Whether time passes in these components, and all their values have a meaning.
fn passes(components: &[Term], environment: &Environment) -> bool {
    let anyhow = means_something(components, environment) && time_passes(components, environment);
    anyhow || goes_round_for_ever(components, environment)
}

/// What is asked for as what each of several parts shows, which are components without a common port; none where it is
/// not clear which part shows what, or a condition compares what two of them show.
pub(super) fn apart(system: &System, pattern: &Pattern, environment: &Environment) -> Option<Vec<Pattern>> {
    let definitions = &environment.definitions;
    let components = ports::flatten(&system.components, definitions);
    let groups = ports::System::of(&components, definitions).groups();
    let shows = |group: &Vec<usize>, wanted: &Name| {
        let mut all = group.iter().flat_map(|place| parts(&components[*place], definitions)).flat_map(observers);
        all.any(|name| name == wanted)
    };
    let none = Pattern { terms: Vec::new(), variables: BTreeSet::new(), conditions: Vec::new() };
    let mut found = vec![none; groups.len()];
    for term in &pattern.terms {
        let Node::Observe(name, values) = term.node() else { return None };
        let mut places = (0..groups.len()).filter(|place| shows(&groups[*place], name));
        let (Some(place), None) = (places.next(), places.next()) else { return None };
        let read = values.iter().flat_map(Value::variables).filter(|name| pattern.variables.contains(name));
        found[place].variables.extend(read);
        found[place].terms.push(term.clone());
    }
    found.retain(|part| !part.terms.is_empty());
    // A name that two parts show stands for one value, so that they would be compared.
    let shared = |(place, part): (usize, &Pattern)| {
        found[..place].iter().any(|other| !other.variables.is_disjoint(&part.variables))
    };
    if found.iter().enumerate().any(shared) {
        return None;
    }
    for (relation, left, right) in &pattern.conditions {
        let mut read = left.variables();
        read.extend(right.variables());
        read.retain(|name| pattern.variables.contains(name));
        let mut places = found.iter_mut().filter(|part| !part.variables.is_disjoint(&read));
        let (Some(part), None) = (places.next(), places.next()) else { return None };
        part.conditions.push((*relation, left.clone(), right.clone()));
    }
    (found.len() > 1).then_some(found)
}

fn observers(term: &Term) -> impl Iterator<Item = &Name> {
    subterms(term).filter_map(|part| match part.node() {
        Node::Observe(name, _) => Some(name),
        _ => None,
    })
}

/// All that a component is made of: its own parts, and those of what it calls, directly or through others.
fn parts<'a>(component: &'a Term, definitions: &'a Definitions) -> impl Iterator<Item = &'a Term> {
    let bodies = reached(component, definitions).into_iter().filter_map(|name| definitions.get(&name));
    std::iter::once(component).chain(bodies.map(|definition| &definition.body)).flat_map(subterms)
}

/// Whether all values of these components surely have a meaning, whatever the names in them stand for: a run ends where one
/// has none.
pub(super) fn means_something(components: &[Term], environment: &Environment) -> bool {
    let definitions = &environment.definitions;
    let terms: Vec<&Term> = components.iter().flat_map(|component| parts(component, definitions)).collect();
    let Some((bound, drawn)) = names(&terms, definitions) else { return false };
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

/// The names that stand for values which processes hold, and those that are drawn; nothing where a process is not defined.
fn names<'t>(terms: &[&'t Term], definitions: &'t Definitions) -> Option<(BTreeSet<&'t Name>, BTreeSet<&'t Name>)> {
    let (mut bound, mut drawn) = (BTreeSet::new(), BTreeSet::new());
    for term in terms {
        match term.node() {
            Node::Call(name, _) => match definitions.get(name) {
                Some(definition) => bound.extend(&definition.parameters),
                None => return None,
            },
            Node::In(_, name) | Node::Set(_, name) | Node::Power(_, _, Some(name)) => {
                bound.insert(name);
            }
            Node::Ran(_, name) => {
                drawn.insert(name);
            }
            _ => {}
        }
    }
    Some((bound, drawn))
}

/// What a value of these components needs of parameters alone, and which is not known.
pub(super) fn open_need(components: &[Term], environment: &Environment) -> Option<Need> {
    let definitions = &environment.definitions;
    let terms: Vec<&Term> = components.iter().flat_map(|component| parts(component, definitions)).collect();
    let (bound, drawn) = names(&terms, definitions)?;
    let fixed = |need: &Need| !need.value().variables().iter().any(|name| bound.contains(name) || drawn.contains(name));
    let needs = terms.iter().flat_map(|term| term.values()).flat_map(Value::needs);
    let open = |need: &Need| !matches!(need, Need::Natural(_)) && environment.assumptions.grants(need) != Some(true);
    needs.into_iter().find(|need| fixed(need) && open(need))
}

/// The same of a period: whether all that is compared, passed, shown, waited for and carried on surely has a meaning on each of
/// its ways, where what is tested there holds, and what was tested on every way to the phase that it leaves.
pub(super) fn each_way_means_something(period: &Period, environment: &Environment) -> bool {
    // What is offered and never taken passes on no way.
    let offered = |place: usize, phase: &Phase| {
        let known = known_at(place, period, environment);
        let mut values = phase.control.iter().flat_map(subterms).flat_map(Term::values);
        values.all(|value| known.gives_meaning(value))
    };
    if !period.phases.iter().enumerate().all(|(place, phase)| offered(place, phase)) {
        return false;
    }
    let from_start = period.initial.iter().map(|way| (way, environment.assumptions.clone()));
    let from_phases = period.phases.iter().enumerate().flat_map(|(place, phase)| {
        let known = known_at(place, period, environment);
        phase.edges.iter().map(move |way| (way, known.clone()))
    });
    from_start.chain(from_phases).all(|(way, mut known)| {
        let tested = way.tests.iter().all(|test| {
            let meant = known.gives_meaning(&test.left) && known.gives_meaning(&test.right);
            known.assume(test.relation, &test.left, &test.right);
            meant
        });
        let shown = way.segments.iter().flat_map(|segment| &segment.observed).flat_map(Term::values);
        let passed = way.communications.iter().map(|(_, value)| value);
        let mut times = way.segments.iter().map(|segment| &segment.duration);
        let zero = Value::zero();
        tested
            && way.draws.is_empty()
            && times.all(|time| known.gives_meaning(time) && known.decide(Relation::Gte, time, &zero) == Some(true))
            && shown.chain(passed).chain(way.map.values()).all(|value| known.gives_meaning(value))
    })
}

/// Whether these components have a period, each way of which leads on, takes time, and has a meaning.
fn goes_round_for_ever(components: &[Term], environment: &Environment) -> bool {
    let found = period::analyse(components, &environment.definitions, &environment.assumptions);
    found.is_ok_and(|period| {
        period.ways().all(|way| matches!(way.next, Next::Phase(_)))
            && each_way_means_something(&period, environment)
            && time_passes_in(components, Some(&period), environment)
    })
}

/// What is known of the variables of a phase: what was tested on one of the ways to it, and holds on all.
fn known_at(place: usize, period: &Period, environment: &Environment) -> Assumptions {
    let ways: Vec<&Edge> = period.ways().filter(|way| way.next == Next::Phase(place)).collect();
    let holds = |way: &Edge, test: &Test| {
        let mut known = environment.assumptions.clone();
        way.tests.iter().for_each(|test| known.assume(test.relation, &test.left, &test.right));
        let sides = [&test.left, &test.right].map(|side| side.substitute(&way.map).ok());
        let [Some(left), Some(right)] = sides else { return false };
        known.gives_meaning(&left)
            && known.gives_meaning(&right)
            && known.decide(test.relation, &left, &right) == Some(true)
    };
    let mut known = environment.assumptions.clone();
    for test in ways.iter().flat_map(|way| &way.after).flatten() {
        let on_all = |way: &&Edge| way.after.iter().flatten().any(|own| own == test) || holds(way, test);
        if ways.iter().all(on_all) {
            known.assume(test.relation, &test.left, &test.right);
        }
    }
    known
}

/// Whether time never stops in these components: they have a period, or each of their loops waits.
pub(super) fn time_passes(components: &[Term], environment: &Environment) -> bool {
    let found = period::analyse(components, &environment.definitions, &environment.assumptions).ok();
    time_passes_in(components, found.as_ref(), environment)
}

/// The same of components whose period was found, or not, before.
pub(super) fn time_passes_in(components: &[Term], found: Option<&Period>, environment: &Environment) -> bool {
    let stops = |next: &Next| matches!(next, Next::End(End::Livelock { .. }));
    let lasts = |edge: &Edge| {
        let fixed = |time: &Value| time.variables().iter().all(|name| environment.quantity(name).is_some());
        edge.segments.iter().any(|segment| fixed(&segment.duration) && is_positive(&segment.duration, environment))
    };
    // Of finitely many phases each takes a time that is one number, so that these add up beyond all bounds.
    let known = found.is_some_and(|period| {
        let mut rounds = period.phases.iter().flat_map(|phase| &phase.edges);
        let passes = rounds.all(|edge| !stops(&edge.next) && (lasts(edge) || matches!(edge.next, Next::End(_))));
        passes && !period.initial.iter().any(|edge| stops(&edge.next))
    });
    known || components.iter().all(|component| loops_wait(component, environment))
}

/// Whether a time is known to be more than 0.
fn is_positive(time: &Value, environment: &Environment) -> bool {
    environment.assumptions.decide(Relation::Gtr, time, &Value::zero()) == Some(true)
}

/// Whether each definition that is called on the way, if it may come back, waits for more than no time in each round.
fn loops_wait(component: &Term, environment: &Environment) -> bool {
    let definitions = &environment.definitions;
    let terms: Vec<&Term> = parts(component, definitions).collect();
    let Some((bound, drawn)) = names(&terms, definitions) else { return false };
    // What is the same in each round.
    let fixed = |time: &Value| !time.variables().iter().any(|name| bound.contains(name) || drawn.contains(name));
    let lasts = |time: &Value| fixed(time) && is_positive(time, environment);
    // How often these go round is not looked at here.
    let goes_round = |part: &Term| matches!(part.node(), Node::Loop(_) | Node::Power(..));
    let waiting = |name: &Name| {
        definitions.get(name).is_some_and(|definition| {
            !reached(&definition.body, definitions).contains(name) || waits(&definition.body, &lasts)
        })
    };
    !parts(component, definitions).any(goes_round) && reached(component, definitions).iter().all(waiting)
}

/// Whether a sequence surely takes time before its last part: it waits for what `lasts` the same time in each round, or for
/// one that is drawn and is surely more than 0.
fn waits(body: &Term, lasts: &dyn Fn(&Value) -> bool) -> bool {
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
        Node::Delay(time) => lasts(time),
        _ => false,
    };
    let behind = |draw: &Term, part: &Term| match part.node() {
        Node::Delay(time) => time.as_variable().is_some_and(|name| rising(draw, name)),
        _ => false,
    };
    let shown = |branch: &Term| matches!(branch.node(), Node::Observe(..) | Node::Idle);
    let branches = |part: &Term, long: &dyn Fn(&Term) -> bool| match part.node() {
        Node::Disable(all) => all.iter().any(long) && all.iter().all(|branch| long(branch) || shown(branch)),
        _ => long(part),
    };
    before.iter().any(|part| branches(part, &number))
        || before.windows(2).any(|pair| matches!(pair, [draw, part] if branches(part, &|part| behind(draw, part))))
}
