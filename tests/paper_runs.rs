//! The paper's systems run step by step, and its slips seen in runs (the numbers are those of the list of slips).

mod common;

use std::path::Path;

use common::number;
use pars::diagnostic::Source;
use pars::model::{Patience, State};
use pars::value::Value;
use pars::walk::{Origin, Walk, declarations};

/// A walk in a file under `examples/stepping`.
fn example(name: &str, subject: &str) -> Walk {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/stepping").join(name);
    text(&std::fs::read_to_string(path).expect("an example"), subject)
}

fn text(text: &str, subject: &str) -> Walk {
    let source = Source::new("run.pars", text);
    let environment = declarations(&source, |_, _| Err("nothing to import".to_string())).expect("declarations");
    Walk::new(&environment, subject, Origin::Prompt, false).expect("a meaning")
}

/// Takes the first move again and again, time being the last, and notes what `At` shows whenever time passes; ends after
/// so many passages of time, or where nothing moves.
fn positions(walk: &mut Walk, count: usize) -> Vec<Value> {
    let mut seen = Vec::new();
    while seen.len() < count {
        let moves = walk.run().moves().expect("moves");
        if moves.is_empty() {
            if !matches!(walk.run().patience(), Ok(Patience::Until(_))) {
                break;
            }
            let shown = walk.run().state().observations();
            let mut at = shown.iter().filter(|(name, _)| name.as_str() == "At");
            seen.extend(at.next().map(|(_, values)| values[0].clone()));
        }
        let answer = walk.answer("1");
        assert!(!answer.failed, "{}", answer.text);
    }
    seen
}

fn why(walk: &mut Walk, question: &str) -> String {
    let answer = walk.answer(&format!("why not {question}"));
    assert!(!answer.failed, "{}", answer.text);
    answer.text
}

fn numbers<const N: usize>(numbers: [i64; N]) -> Vec<Value> {
    numbers.map(number).to_vec()
}

#[test]
fn back_and_forth_step_by_step() {
    let mut walk = example("back_and_forth.pars", "Sys");
    let first = ["pass 0 over p", "wait 1", "pass 1 over v", "pass 1 over p", "wait 1", "pass 1 over v"];
    for expected in first {
        assert!(walk.answer("1").text.starts_with(&format!("{expected}\n")), "{expected}");
    }
    assert!(walk.answer("initial").text.contains("shows At_0"));
    assert_eq!(positions(&mut walk, 13), numbers([0, 1, 2, 3, 2, 1, 0, -1, 0, 1, 2, 3, 2]));
}

#[test]
fn the_environment_with_an_obstacle_step_by_step() {
    // At 2 stands the obstacle: the robot is thrown from it by e, here back to where it came from.
    let mut walk = example("obstacle.pars", "Sys with e = -1");
    assert_eq!(positions(&mut walk, 5), numbers([0, 1, 1, 1, 1]));
    // Thrown forwards it is past the obstacle; at its goal it rests, and the environment waits for a command.
    let mut walk = example("obstacle.pars", "Sys with e = 1");
    assert_eq!(positions(&mut walk, 5), numbers([0, 1, 3, 4]));
    let text = why(&mut walk, "v!");
    assert!(text.contains("`Neq_{r,4}` aborted: 4 != 4 is false") && text.contains("MoveTo_4` behind it"), "{text}");
}

#[test]
fn slip_2_a_leg_without_the_loops_exit_aborts_and_the_next_never_starts() {
    let legs = "proc Leg_g = In_p<r> ; Neq_{r,g} ; Out_{v,g-r}\nproc Two = Leg_3 ; Leg_0";
    let mut walk = text(legs, "Two");
    walk.answer("1 3");
    assert_eq!(*walk.run().state(), State::Aborted);
    let reason = why(&mut walk, "p?");
    assert!(reason.contains("3 != 3 is false; so `Out_{v,3-r} ; Leg_0` behind it never starts"), "{reason}");
    // As the paper needs it, a loop whose round aborts stops, and the second leg reads p.
    let legs = "proc Leg_g = In_p<r> ; Neq_{r,g} ; Out_{v,g-r} ; Leg_g\nproc Two = Leg_3 ; Leg_0";
    let mut walk = text(legs, "Two");
    let shown = walk.answer("1 3").text;
    assert!(shown.contains("1. read from p"), "{shown}");
    let shown = walk.answer("1 3").text;
    assert!(shown.contains("1. write -3 to v"), "{shown}");
}

#[test]
fn slip_3_of_two_complementary_branches_one_aborts_and_the_whole_stops() {
    let mut walk = example("obstacle.pars", "Sys with e = -1");
    // Up to the first time that the environment has both the command and the obstacle.
    let both =
        |walk: &Walk| ["pass 1 over v", "pass 2 over b"].map(|did| walk.run().trace().iter().any(|one| one.did == did));
    while both(&walk) != [true, true] {
        assert!(!walk.answer("1").failed && walk.run().trace().len() < 20);
    }
    assert!(walk.answer("moves").text.contains("shows At_1"), "it stopped with a value, and goes round with it");
    let events = &walk.run().trace().last().expect("a step").events;
    let guards: Vec<bool> = events
        .iter()
        .filter_map(|event| match event {
            pars::model::Event::Guard(_, left, right, holds) if [left, right].contains(&&number(1)) => Some(*holds),
            _ => None,
        })
        .collect();
    assert_eq!(guards.len(), 2, "both guards were evaluated: {events:?}");
    assert!(guards.contains(&true) && guards.contains(&false));
}

#[test]
fn slip_5_an_exact_goal_test_is_never_met() {
    let mission = |speed: &str, goal: &str| {
        format!(
            "fn s(d) = {speed}\nproc MoveTo_g = In_p<r> ; Neq_{{r,g}} ; Out_{{v,s(g-r)}} ; MoveTo_g\n\
             proc DEnv_r = (Delay_1 # Odo_r # At_r) ; In_v<u> ; DEnv_{{r+u}}\nproc Odo_r = Out_{{p,r}} ; Odo_r\n\
             system Sys = DEnv_0 | MoveTo_{goal}"
        )
    };
    // Half the way each time: nearer and nearer, and after 40 steps still not there.
    let seen = positions(&mut text(&mission("d / 2", "10"), "Sys"), 41);
    assert_eq!(seen[..4], [number(0), number(5), fraction(15, 2), fraction(35, 4)]);
    assert!(seen.len() == 41 && !seen.contains(&number(10)));
    // At constant speed past the goal and back, in a state that comes again: for ever.
    let mut walk = text(&mission("if d > 0 then 1 else -1", "{5/2}"), "Sys");
    assert_eq!(positions(&mut walk, 5), numbers([0, 1, 2, 3, 2]));
    let before = walk.run().state().clone();
    assert_eq!(positions(&mut walk, 2), numbers([3, 2]));
    assert_eq!(*walk.run().state(), before);
}

fn fraction(top: i64, bottom: i64) -> Value {
    Value::fraction(top, bottom).expect("a fraction")
}

#[test]
fn slip_7_one_step_jumps_the_margin() {
    let distances = |h: &str| -> Vec<Value> {
        let seen = positions(&mut example("margin.pars", &format!("Sys with h = {h}")), 30);
        assert_eq!(seen.len(), 30);
        seen.iter().map(|place| number(5).sub(place).expect("a distance")).collect()
    };
    let least = |distances: &[Value]| {
        distances.iter().filter_map(Value::as_rational).min().map(Value::rational).expect("a distance")
    };
    // h = 6/5 is more than 1, and still the robot comes to 1, by …, 3.5, 4.0.
    let jumped = distances("6/5");
    assert_eq!(jumped[6..10], [number(2), fraction(3, 2), number(1), fraction(3, 2)]);
    assert_eq!(least(&jumped), number(1));
    assert_eq!(least(&distances("3/2")), fraction(3, 2));
    assert!(!jumped.contains(&number(-5)), "the goal at 10 is never reached");
}

#[test]
fn slip_8_the_printed_sensor_ends_when_something_comes_near() {
    let mut walk = example("sensor.pars", "Sensor_2");
    let far = ["1 9", "1 0", "1"];
    for step in far {
        assert!(!walk.answer(step).failed);
    }
    assert_eq!(walk.run().trace().last().expect("a step").did, "write 9 to sp", "far away, and still it reports");
    for step in ["1 9", "1 8"] {
        assert!(!walk.answer(step).failed);
    }
    assert!(matches!(walk.run().state(), State::Stopped(_)), "near, and it ends for good");
    let reason = why(&mut walk, "sp!");
    assert!(reason.contains("1 > 2 is false"), "{reason}");
}

#[test]
fn slip_9_a_silent_sensor_blocks_the_robot_for_ever() {
    let mut walk = example("sensor.pars", "Sys with c = 2, h = 1");
    let seen = positions(&mut walk, 50);
    assert!(seen.len() < 20, "{seen:?}");
    assert_eq!(walk.run().moves().expect("moves"), []);
    assert_eq!(walk.run().patience(), Ok(Patience::Unbounded), "nothing happens any more");
    assert!(matches!(walk.run().state(), State::Running(_)), "and nothing has ended");
    let reason = why(&mut walk, "v!");
    assert!(reason.contains("waits for a value from sp"), "{reason}");
    let reason = why(&mut walk, "sp?");
    assert!(reason.contains("`In_sp<q>` is ready, but sp is private"), "{reason}");
    assert!(reason.contains("2 > 2 is false; so `Out_{sp,q} ; Sensor_2` behind it never starts"), "{reason}");
}
