//! The paper's systems run as the notes on its slips say.

mod common;

use common::*;
use pars::bisimulation::{Comparison, Difference, Reach, compare, replay};
use pars::definition::Definitions;
use pars::law::Connective;
use pars::model::explore::{Bounds, Graph};
use pars::model::{Action, Model, Patience, State};
use pars::term::{Node, Term};
use pars::value::{Relation, Value};

/// `BF_{a,b} | DEnv_p` with unit steps of this time and `s(d) = clamp(d, -1, 1)`.
fn back_and_forth(a: i64, b: i64, start: i64, time: Value) -> (Term, Definitions) {
    let mut all = Definitions::default();
    let speed = var("g").sub(&var("r")).and_then(|way| Value::clamp(&way, &number(-1), &number(1))).expect("a speed");
    let body = Term::seq([
        input("p", "r"),
        guard(Relation::Neq, var("r"), var("g")),
        output("v", speed),
        call("MoveTo", vec![var("g")]),
    ]);
    define(&mut all, "MoveTo", &["g"], body);
    let legs = [call("MoveTo", vec![var("a")]), call("MoveTo", vec![var("b")])];
    let body = Term::seq(legs.into_iter().chain([call("BF", vec![var("a"), var("b")])]));
    define(&mut all, "BF", &["a", "b"], body);
    define(&mut all, "Odo", &["r"], Term::seq([output("p", var("r")), call("Odo", vec![var("r")])]));
    let place = var("u").mul(&time).and_then(|way| var("r").add(&way)).expect("a place");
    let watched = dis([Term::delay(time), call("Odo", vec![var("r")]), observer("At", vec![var("r")])]);
    let body = Term::seq([watched, input("v", "u"), call("DEnv", vec![place])]);
    define(&mut all, "DEnv", &["r"], body);
    let system = par([call("BF", vec![number(a), number(b)]), call("DEnv", vec![number(start)])]);
    (private("p", private("v", system)), all)
}

/// Where the system is while time passes, for so many delays; the internal steps in between are all taken.
fn places(system: &Term, definitions: &Definitions, count: usize) -> Vec<Value> {
    let model = Model::new(definitions);
    let mut state = model.state(system).expect("a meaning");
    let mut seen = Vec::new();
    for _ in 0..count * 20 {
        let moves = state.moves().expect("moves");
        if let Some(step) = moves.iter().find(|step| matches!(step.action, Action::Tau(..))) {
            state = model.state(&step.next).expect("a meaning");
            continue;
        }
        let Patience::Until(time) = state.patience(&moves) else { break };
        seen.extend(state.observations().into_iter().filter_map(|(_, values)| values.first().cloned()));
        state = model.wait_state(&state, &time).expect("a meaning").expect("time passes");
        if seen.len() == count {
            break;
        }
    }
    seen
}

fn bounds() -> Bounds {
    Bounds { states: 2_000, inputs: vec![number(0), number(1)] }
}

#[test]
fn back_and_forth_shows_one_position_a_unit_of_time() {
    let (system, definitions) = back_and_forth(3, -1, 0, number(1));
    let expected: Vec<Value> = [0, 1, 2, 3, 2, 1, 0, -1, 0, 1, 2, 3, 2].map(number).to_vec();
    assert_eq!(places(&system, &definitions, expected.len()), expected);
    let graph = Graph::of(&system, &definitions, &bounds()).expect("a meaning");
    assert!(graph.complete && graph.deadlocks.is_empty() && graph.livelock.is_none());
}

#[test]
fn half_steps_approach_the_goal_and_never_arrive() {
    let half = Value::fraction(1, 2).expect("a half");
    let (system, definitions) = back_and_forth(3, -1, 0, half);
    let expected = [(0, 1), (1, 2), (1, 1), (3, 2), (2, 1), (5, 2), (11, 4), (23, 8)];
    let expected: Vec<Value> = expected.iter().map(|(n, d)| Value::fraction(*n, *d).expect("a fraction")).collect();
    assert_eq!(places(&system, &definitions, expected.len()), expected);
    assert!(!places(&system, &definitions, 30).contains(&number(3)));
}

#[test]
fn equal_goals_are_a_livelock() {
    let (system, definitions) = back_and_forth(1, 1, 0, number(1));
    let graph = Graph::of(&system, &definitions, &bounds()).expect("a meaning");
    assert!(graph.complete && graph.livelock.is_some());
}

#[test]
fn a_leg_ends_by_stopping_so_the_next_begins() {
    // Slip 2: were the loop's exit an abort, the leg would end the mission.
    let (_, definitions) = back_and_forth(3, -1, 0, number(1));
    let leg = private("p", par([call("MoveTo", vec![number(3)]), output("p", number(3))]));
    let graph = Graph::of(&leg, &definitions, &bounds()).expect("a meaning");
    let (stopped, aborted) = graph.ended();
    assert!(stopped > 0 && aborted == 0);
}

#[test]
fn complementary_guards_side_by_side_choose() {
    // Slip 3: equation (4) needs that `|` stops if any part stopped.
    let branch = |relation, value| seq([guard(relation, number(1), number(1)), set(value)]);
    let choice = par([branch(Relation::Neq, 0), branch(Relation::Eq, 1)]);
    let definitions = Definitions::default();
    let state = Model::new(&definitions).state(&choice).expect("a meaning");
    assert_eq!(state, State::Stopped([(name("y"), number(1))].into()));
}

fn set(value: i64) -> Term {
    Term::new(Node::Set(number(value), name("y")))
}

#[test]
fn a_speed_that_does_not_divide_the_way_dithers() {
    // Slip 5: at constant speed 1 and steps of 1, a goal at 1/2 is passed back and forth for ever.
    let mut all = Definitions::default();
    let half = Value::fraction(1, 2).expect("a half");
    let speed = Value::choose(Relation::Gtr, &half, &var("r"), &number(1), &number(-1)).expect("a speed");
    let next = var("r").add(&speed).expect("a place");
    let shown = dis([wait(1), observer("At", vec![var("r")])]);
    let body = Term::seq([guard(Relation::Neq, var("r"), half), shown, call("Walk", vec![next])]);
    define(&mut all, "Walk", &["r"], body);
    let graph = Graph::of(&call("Walk", vec![number(0)]), &all, &bounds()).expect("a meaning");
    assert!(graph.complete && graph.ended() == (0, 0) && graph.states.len() == 2);
}

#[test]
fn a_silent_sensor_blocks_the_mission() {
    // Slip 9: the avoiding robot reads position and sensor before each step.
    let mut all = Definitions::default();
    let reads = par([input("p", "r"), input("sp", "q")]);
    define(&mut all, "Move", &[], Term::seq([reads, output("v", number(1)), call("Move", vec![])]));
    let world = seq([dis([wait(1), again(output("p", number(0)))]), input("v", "u")]);
    define(&mut all, "World", &[], Term::seq([world, call("World", vec![])]));
    let parts = par([call("Move", vec![]), call("World", vec![])]);
    let system = private("p", private("v", private("sp", parts)));
    let graph = Graph::of(&system, &all, &bounds()).expect("a meaning");
    assert!(graph.complete && !graph.deadlocks.is_empty());
}

#[test]
fn loops_in_no_time_have_no_meaning() {
    let mut all = Definitions::default();
    define(&mut all, "T", &[], Term::seq([Term::stop(), call("T", vec![])]));
    define(&mut all, "U", &["n"], Term::seq([set(0), call("U", vec![var("n").add(&number(1)).expect("a sum")])]));
    let model = Model::new(&all);
    assert!(model.state(&call("T", vec![])).is_err());
    assert!(model.state(&call("U", vec![number(0)])).is_err());
    assert!(model.state(&again(set(0))).is_err());
    assert!(model.state(&again(Term::abort())).is_ok());
    assert!(model.state(&output("c", var("unbound"))).is_err());
}

/// `T_u = body ; T_{1-u}`, called with 0, and what it is wrongly said to be.
fn differs(body: Term, claimed: impl Fn(Term) -> Term) -> (Comparison, bool) {
    let mut all = Definitions::default();
    let flipped = number(1).sub(&var("u")).expect("a difference");
    define(&mut all, "T", &["u"], Term::seq([body.clone(), call("T", vec![flipped])]));
    define(&mut all, "Body", &["u"], body);
    let (left, right) = (call("T", vec![number(0)]), claimed(call("T", vec![number(0)])));
    let reach = Reach::default();
    let judged = compare(&left, &right, Connective::Equal, &all, &reach).expect("a meaning");
    let replayed = match &judged {
        Comparison::Different(run) => replay(&left, &right, Connective::Equal, &all, &reach, run),
        _ => Ok(false),
    };
    (judged, replayed == Ok(true))
}

#[test]
fn the_papers_unfoldings_are_refuted() {
    // Equation (6) with the copies started one too late.
    let copies = |_| Term::seq([call("Body", vec![number(1)]), call("Body", vec![number(0)])]);
    let (judged, replayed) = differs(observer("A", vec![var("u")]), copies);
    let Comparison::Different(run) = judged else { panic!("{judged:?}") };
    assert!(replayed && run.steps.is_empty() && matches!(run.difference, Difference::Observations(..)));
    // Equation (7) where the next round aborts, but not at once.
    let body = Term::seq([wait(1), guard(Relation::Eq, var("u"), number(0))]);
    let (judged, replayed) = differs(body, |_| call("Body", vec![number(0)]));
    let Comparison::Different(run) = judged else { panic!("{judged:?}") };
    assert!(replayed && run.steps.len() == 1 && matches!(run.difference, Difference::Outcome(..)));
}

#[test]
fn the_server_law_fails_at_once_without_a_delay() {
    let server = dis([wait(0), again(output("k", number(0))), observer("A", vec![])]);
    let reader = seq([input("k", "y"), wait(1)]);
    let left = private("k", par([server, reader]));
    let definitions = Definitions::default();
    let graph = Graph::of(&left, &definitions, &bounds()).expect("a meaning");
    assert_eq!((graph.states.len(), graph.deadlocks.len()), (1, 1));
}

#[test]
fn time_steps_compose_across_the_end_of_a_delay() {
    let definitions = Definitions::default();
    let model = Model::new(&definitions);
    let term = seq([wait(1), wait(2), observer("A", vec![])]);
    let third = Value::fraction(5, 2).expect("a fraction").as_rational().expect("a number");
    let once = model.wait(&term, &third).expect("a meaning").expect("time passes");
    let half = Value::fraction(5, 4).expect("a fraction").as_rational().expect("a number");
    let first = model.wait(&term, &half).expect("a meaning").expect("time passes");
    let twice = model.wait(&first, &half).expect("a meaning").expect("time passes");
    assert_eq!(once, twice);
    // A delay offers what runs beside it before its end, not at its end; and time stops for an internal step.
    let offer = dis([wait(1), output("c", number(0))]);
    let one = number(1).as_rational().expect("a number");
    assert_eq!(model.moves(&offer).expect("a meaning").len(), 1);
    let after = model.wait(&offer, &one).expect("a meaning").expect("time passes");
    assert!(model.moves(&after).expect("a meaning").is_empty());
    assert_eq!(model.wait(&tau(), &one), Ok(None));
}

#[test]
fn draws_are_compared_by_their_chances() {
    let definitions = Definitions::default();
    let mix = |first: i64, low: i64, second: i64, high: i64| {
        let weight = |number| Value::fraction(number, 4).expect("a weight");
        let point = |number: i64| Value::distribution("Point", vec![Value::integer(number)]).expect("a point");
        let parts = vec![weight(first), point(low), weight(second), point(high)];
        Term::new(Node::Ran(Value::distribution("Mix", parts).expect("a mixture"), name("y")))
    };
    let judge = |left: &Term, right: &Term| {
        compare(left, right, Connective::Equal, &definitions, &Reach::default()).expect("a meaning")
    };
    assert_eq!(judge(&mix(1, 0, 3, 1), &mix(3, 1, 1, 0)), Comparison::Same);
    assert!(matches!(judge(&mix(1, 0, 3, 1), &mix(2, 0, 2, 1)), Comparison::Different(_)));
    assert_eq!(judge(&mix(1, 5, 3, 5), &set(5)), Comparison::Same);
}
