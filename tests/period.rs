//! Periods of random networks against plain execution: the analysis says what the executable meaning does.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use num_rational::BigRational;
use num_traits::Zero;
use pars::assumption::Assumptions;
use pars::model::{Action, Model, Patience, State};
use pars::name::Name;
use pars::period::{self, Edge, End, Failure, Next, Period};
use pars::term::{Node, Term};
use pars::value::Value;

mod common;

mod dice;
mod model_orders;
use dice::Dice;
use model_orders::order_matters;

mod woven;
use woven::{Made, Network, component, random_network};

/// What passes, and when.
type Passed = (Name, Value);

/// What passes at each time.
type Log = BTreeMap<BigRational, Vec<Passed>>;

/// What a run does.
#[derive(Debug, PartialEq, Eq)]
enum Ran {
    /// Comes back to where it was: after this time, for the first time after that, with what passes in one round.
    Round { start: BigRational, length: BigRational, passed: Vec<Passed> },
    /// Nothing changes any more, from this time on.
    Silent { at: BigRational },
    /// Time stops.
    Livelock,
}

/// The system, with all ports private to it.
fn whole(network: &Network) -> Term {
    let mut ports = BTreeSet::new();
    let mut stack: Vec<Term> = network.components.clone();
    stack.extend(network.definitions.iter().map(|definition| definition.body.clone()));
    while let Some(term) = stack.pop() {
        if let Node::In(port, _) | Node::Out(port, _) = term.node() {
            ports.insert(port.clone());
        }
        stack.extend(term.children().cloned());
    }
    let parts = Term::par(network.components.iter().cloned());
    ports.into_iter().fold(parts, |body, port| Term::new(Node::New(port, body)))
}

/// Runs the system in its executable meaning, the first internal step each time.
fn plainly(network: &Network) -> (Ran, Log) {
    let model = Model::new(&network.definitions);
    let mut state = model.state(&whole(network)).expect("a meaning");
    let mut seen: HashMap<State, (BigRational, usize)> = HashMap::new();
    let (mut now, mut passed) = (BigRational::zero(), Vec::new());
    let mut log = Log::new();
    let (mut steps, mut instant) = (0, HashSet::new());
    for _ in 0..100_000 {
        let moves = state.moves().expect("moves");
        if let Some(step) = moves.iter().find(|step| matches!(step.action, Action::Tau(..))) {
            let Action::Tau(port, value) = &step.action else { unreachable!() };
            passed.push((port.clone(), value.clone()));
            log.entry(now.clone()).or_default().push((port.clone(), value.clone()));
            state = model.state(&step.next).expect("a meaning");
            steps += 1;
            if steps > 300 && !instant.insert(state.clone()) {
                return (Ran::Livelock, log);
            }
            continue;
        }
        if let Some((start, before)) = seen.get(&state) {
            let mut passed: Vec<Passed> = passed[*before..].to_vec();
            passed.sort();
            log.values_mut().for_each(|passed| passed.sort());
            return (Ran::Round { length: &now - start, start: start.clone(), passed }, log);
        }
        seen.insert(state.clone(), (now.clone(), passed.len()));
        let Patience::Until(time) = state.patience(&moves) else { return (Ran::Silent { at: now }, log) };
        state = model.wait_state(&state, &time).expect("a meaning").expect("time passes");
        now += time;
        steps = 0;
        instant.clear();
    }
    panic!("no end in sight");
}

fn length(edges: &[&Edge]) -> BigRational {
    edges.iter().map(|edge| edge.duration().expect("a sum").as_rational().expect("a number")).sum()
}

/// The run that the phases describe: one way through each, since nothing is tested.
fn followed(period: &Period) -> Ran {
    let mut edges: Vec<&Edge> = Vec::new();
    let mut entered: BTreeMap<usize, usize> = BTreeMap::new();
    let mut ways = period.initial.as_slice();
    loop {
        let [edge] = ways else { panic!("{} ways", ways.len()) };
        edges.push(edge);
        match &edge.next {
            Next::Phase(phase) => {
                if let Some(before) = entered.get(phase) {
                    let mut passed: Vec<Passed> =
                        edges[*before..].iter().flat_map(|edge| edge.communications.iter().cloned()).collect();
                    passed.sort();
                    return Ran::Round { start: length(&edges[..*before]), length: length(&edges[*before..]), passed };
                }
                entered.insert(*phase, edges.len());
                ways = &period.phases[*phase].edges;
            }
            Next::End(End::Silent { .. }) => return Ran::Silent { at: length(&edges) },
            Next::End(End::Livelock { .. }) => return Ran::Livelock,
            Next::End(other) => panic!("{other:?}"),
        }
    }
}

/// Whether what the phases say is what the plain run does. A state of the plain run also holds the results that nobody
/// reads any more, so it may come back later, though not in another round.
fn agrees(ran: &Ran, plain: &Ran, log: &Log) -> bool {
    let (Ran::Round { start, length, passed }, Ran::Round { start: later, length: round, passed: wanted }) =
        (ran, plain)
    else {
        return ran == plain;
    };
    let (end, nothing) = (later + round, Vec::new());
    let at = |time: &BigRational| log.get(time).unwrap_or(&nothing);
    length == round
        && passed == wanted
        && start <= later
        && log.keys().filter(|time| *time > start && *time + length <= end).all(|time| at(time) == at(&(time + length)))
        && log.keys().filter(|time| *time - length > *start).all(|time| at(time) == at(&(time - length)))
}

/// Who waits for ever in some run, by the warnings.
fn waiting(period: &Period) -> BTreeSet<String> {
    let blocked = |failure: &Failure| match failure {
        Failure::Unmatched(blocked) | Failure::MayWait { blocked, .. } => Some(blocked.component.clone()),
        _ => None,
    };
    period.warnings.iter().filter_map(blocked).collect()
}

/// Components with reads or writes of which none takes place in the round.
fn stuck(network: &Network, ran: &Ran) -> BTreeSet<String> {
    let busy: BTreeSet<&Name> = match ran {
        Ran::Round { passed, .. } => passed.iter().map(|(port, _)| port).collect(),
        _ => BTreeSet::new(),
    };
    let mut found = BTreeSet::new();
    for index in 0..network.components.len() {
        let mut own = network.pairs.iter().filter(|(_, (one, other))| *one == index || *other == index).peekable();
        if own.peek().is_some() && own.all(|(port, _)| !busy.contains(port)) {
            found.insert(component(index));
        }
    }
    found
}

#[test]
fn straight_networks_do_what_the_analysis_says() {
    let mut dice = Dice(2_012);
    let mut counts: BTreeMap<&'static str, usize> = BTreeMap::new();
    for round in 0..5_000 {
        let exact = dice.place(2) == 0;
        let network = random_network(&mut dice, Made { exact, ..Made::default() });
        let (plain, log) = plainly(&network);
        let about = || format!("network {round}:\n{}plainly {plain:?}", network.text);
        let found = period::analyse(&network.components, &network.definitions, &Assumptions::default());
        let verdict = match &found {
            Ok(period) => {
                let ran = followed(period);
                assert!(agrees(&ran, &plain, &log), "{}\n{ran:?}", about());
                let wanted = if plain == Ran::Livelock { waiting(period) } else { stuck(&network, &plain) };
                assert_eq!(waiting(period), wanted, "{}\n{:?}", about(), period.warnings);
                match &ran {
                    Ran::Round { start, .. } if start.is_zero() => "period",
                    Ran::Round { .. } => "period after a prologue",
                    Ran::Silent { .. } => "blocked",
                    Ran::Livelock => "livelock",
                }
            }
            Err(failures) => match failures.first() {
                Some(Failure::RateMismatch { writer, reader, .. }) => {
                    let stuck = stuck(&network, &plain);
                    assert!(stuck.contains(&writer.0) && stuck.contains(&reader.0), "{}\n{failures:?}", about());
                    assert!(!matches!(plain, Ran::Round { .. }), "{}\n{failures:?}", about());
                    "rate mismatch"
                }
                Some(Failure::NoCommunication { .. }) => {
                    let ends = |failure: &Failure| match plain {
                        Ran::Silent { .. } => matches!(failure, Failure::Unmatched(_) | Failure::MayWait { .. }),
                        Ran::Livelock => matches!(failure, Failure::Livelock { .. }),
                        Ran::Round { .. } => false,
                    };
                    assert!(failures.iter().any(ends), "{}\n{failures:?}", about());
                    "no communication, and no period"
                }
                Some(Failure::Livelock { .. }) => {
                    assert_eq!(plain, Ran::Livelock, "{}\n{failures:?}", about());
                    "livelock"
                }
                other => panic!("{other:?}\n{}", about()),
            },
        };
        *counts.entry(verdict).or_default() += 1;
    }
    println!("{counts:?}");
    let wanted = ["period", "period after a prologue", "blocked", "rate mismatch"];
    assert!(wanted.iter().all(|verdict| counts.get(verdict).is_some_and(|count| *count > 200)), "{counts:?}");
}

#[test]
fn a_looping_writer_serves_any_number_of_readers() {
    let mut dice = Dice(1_997);
    let mut counts: BTreeMap<&'static str, usize> = BTreeMap::new();
    for round in 0..1_000 {
        let exact = dice.place(2) == 0;
        let network = random_network(&mut dice, Made { exact, fan: true, ..Made::default() });
        let (plain, log) = plainly(&network);
        let about = || format!("network {round}:\n{}plainly {plain:?}", network.text);
        let verdict = match period::analyse(&network.components, &network.definitions, &Assumptions::default()) {
            Ok(period) => {
                let ran = followed(&period);
                assert!(agrees(&ran, &plain, &log), "{}\n{ran:?}", about());
                if matches!(ran, Ran::Round { .. }) { "period" } else { "blocked" }
            }
            Err(failures) => match failures.first() {
                Some(Failure::KillRace { .. } | Failure::Contention { .. }) => {
                    assert!(order_matters(&whole(&network), &network.definitions, 200), "{}\n{failures:?}", about());
                    "race"
                }
                Some(Failure::NoCommunication { .. }) => "no communication",
                Some(Failure::RateMismatch { .. }) => {
                    assert!(!matches!(plain, Ran::Round { .. }), "{}\n{failures:?}", about());
                    "rate mismatch"
                }
                Some(Failure::Livelock { .. }) => {
                    assert_eq!(plain, Ran::Livelock, "{}\n{failures:?}", about());
                    "livelock"
                }
                other => panic!("{other:?}\n{}", about()),
            },
        };
        *counts.entry(verdict).or_default() += 1;
    }
    println!("{counts:?}");
    let wanted = ["period", "blocked", "race"];
    assert!(wanted.iter().all(|verdict| counts.get(verdict).is_some_and(|count| *count > 10)), "{counts:?}");
}

/// Whether the number of rounds that is said of each component is what passes through its ports in one round of the whole.
fn rounds_agree(network: &Network, said: &[(String, u64)], plain: &Ran) -> bool {
    let Ran::Round { passed, .. } = plain else { return said.is_empty() };
    let fits = |(index, port): &(usize, Name), each: usize| {
        let all = passed.iter().filter(|(other, _)| other == port).count();
        said.iter().filter(|(own, _)| *own == component(*index)).all(|(_, rounds)| all == *rounds as usize * each)
    };
    network.uses.iter().all(|(place, each)| fits(place, *each))
}

#[test]
fn rounds_are_counted_in_networks_of_any_shape_and_rates_that_do_not_match_have_no_period() {
    let mut dice = Dice(1_978);
    let mut counts: BTreeMap<&'static str, usize> = BTreeMap::new();
    for round in 0..5_000 {
        let (exact, fan, timed) = (dice.place(2) == 0, dice.place(4) == 0, dice.place(4) == 0);
        let network = random_network(&mut dice, Made { exact, fan, shaped: true, timed });
        let (plain, log) = plainly(&network);
        let about = || format!("network {round}:\n{}plainly {plain:?}", network.text);
        let verdict = match period::analyse(&network.components, &network.definitions, &Assumptions::default()) {
            Ok(period) => {
                let ran = followed(&period);
                // What could communicate with itself for ever, or once with another, does what the order says.
                if ran == Ran::Livelock
                    && plain != Ran::Livelock
                    && order_matters(&whole(&network), &network.definitions, 200)
                {
                    continue;
                }
                assert!(agrees(&ran, &plain, &log), "{}\n{ran:?}", about());
                let rounds = period.repetitions(&network.definitions, &Assumptions::default(), &|| false);
                let said = rounds.unwrap_or_default();
                assert!(rounds_agree(&network, &said, &plain), "{}\n{said:?}", about());
                let mismatch = period.warnings.iter().any(|warning| matches!(warning, Failure::RateMismatch { .. }));
                match ran {
                    Ran::Round { .. } if mismatch => "period beside rates that do not match",
                    Ran::Round { .. } if said.is_empty() => "period without rounds",
                    Ran::Round { .. } => "period",
                    _ => "blocked",
                }
            }
            Err(failures) => match failures.first() {
                Some(Failure::RateMismatch { .. }) => {
                    assert!(!matches!(plain, Ran::Round { .. }), "{}\n{failures:?}", about());
                    "rate mismatch"
                }
                Some(Failure::KillRace { .. } | Failure::Contention { .. }) => "race",
                Some(Failure::NoCommunication { .. } | Failure::Unmatched(_)) => {
                    assert!(!matches!(plain, Ran::Round { .. }), "{}\n{failures:?}", about());
                    "no communication"
                }
                Some(Failure::Livelock { .. }) => {
                    assert_eq!(plain, Ran::Livelock, "{}\n{failures:?}", about());
                    "livelock"
                }
                other => panic!("{other:?}\n{}", about()),
            },
        };
        *counts.entry(verdict).or_default() += 1;
    }
    println!("{counts:?}");
    let wanted = ["period", "period without rounds", "blocked", "rate mismatch", "race"];
    assert!(wanted.iter().all(|verdict| counts.get(verdict).is_some_and(|count| *count > 20)), "{counts:?}");
}
