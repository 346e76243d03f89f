//! Stepping by hand: undo, redo, and traces that replay.

mod common;

use common::*;
use pars::definition::Definitions;
use pars::model::State;
use pars::stepper::{Choice, Stepper};

#[test]
fn a_trace_replays_and_a_step_can_be_taken_back() {
    let body = Term::seq([wait(2), input("c", "y"), output("d", var("y"))]);
    let definitions = Definitions::default();
    let mut run = Stepper::new(&body, &definitions).expect("a meaning");
    let half = number(1).div(&number(2)).expect("a half").as_rational().expect("a number");
    let rest = number(3).div(&number(2)).expect("a value").as_rational().expect("a number");
    for choice in [Choice::Wait(half), Choice::Wait(rest), Choice::Take(0, Some(number(7))), Choice::Take(0, None)] {
        run.step(choice).expect("a step");
    }
    assert_eq!(*run.state(), State::Stopped([(name("y"), number(7))].into()));
    assert_eq!(run.save(), "wait 1/2\nwait 3/2\ntake 0 = 7\ntake 0\n");
    let (end, text) = (run.state().clone(), run.save());
    assert!(run.undo() && run.undo() && run.redo() == Ok(true));
    assert!(run.step(Choice::Take(3, None)).is_err());
    let mut again = Stepper::new(&body, &definitions).expect("a meaning");
    again.load(&text).expect("a trace");
    assert_eq!(*again.state(), end);
    assert!(again.load("wait 5/0\n").is_err() && again.load("take 9\n").is_err());
}

use pars::term::Term;
