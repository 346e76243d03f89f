//! Stepping by hand: undo, redo, traces that replay, why a move is not there; from inside and through the program.

mod common;

use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use common::*;
use pars::definition::Definitions;
use pars::mark::marked;
use pars::model::State;
use pars::parser::parse;
use pars::stepper::{Choice, LoadError, Stepper};
use pars::term::Term;
use pars::walk::{Origin, Walk};

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
    assert_eq!(run.save(), "wait 1/2\nwait 3/2\n1 = 7 : read 7 from c\n1 : write 7 to d\n");
    let (end, text) = (run.state().clone(), run.save());
    assert!(run.undo() && run.undo() && run.redo() == Ok(true));
    assert!(run.step(Choice::Take(3, None)).is_err());
    let mut again = Stepper::new(&body, &definitions).expect("a meaning");
    again.load(&text).expect("a trace");
    assert_eq!(*again.state(), end);
    assert!(matches!(again.load("wait 2\n\nwait 5/0\n"), Err(LoadError::Unreadable(3, _))));
    assert!(matches!(again.load("// nothing\n9\n"), Err(LoadError::Impossible(2, _))));
    let other = again.load("wait 2\n1 = 7 : read 8 from c\n");
    assert!(matches!(&other, Err(LoadError::Impossible(2, why)) if why.contains("read 7 from c")), "{other:?}");
    assert_eq!(again.trace().len(), 1, "the run stays before the line");
}

#[test]
fn values_are_numbers_or_vectors_and_nothing_else() {
    let definitions = Definitions::default();
    let mut run = Stepper::new(&seq([input("c", "y"), wait(1)]), &definitions).expect("a meaning");
    assert!(run.step(Choice::Take(0, None)).is_err());
    assert!(run.step(Choice::Take(0, Some(var("x")))).is_err());
    assert!(run.load("1 = (1, 2)\n").is_ok());
    assert!(run.load("1 = Exp(rate: 1)\n").is_err());
    assert!(run.load("wait -1\n").is_err());
}

#[test]
fn only_what_changed_is_marked() {
    let change = |before: &Term, after: &Term| marked(before, after).with("[", "]");
    let long = seq([wait(1), wait(2), wait(3)]);
    assert_eq!(change(&long, &seq([wait(1), wait(5), wait(3)])), "Delay_1 ; [Delay_5] ; Delay_3");
    assert_eq!(change(&long, &seq([wait(3), wait(3)])), "[Delay_3] ; Delay_3");
    assert_eq!(change(&long, &long), "Delay_1 ; Delay_2 ; Delay_3");
    let side = |second: Term| par([wait(9), seq([second, wait(4)])]);
    assert_eq!(change(&side(wait(1)), &side(wait(2))), "Delay_9 | [Delay_2] ; Delay_4");
    let inside = |time| private("c", again(seq([wait(time), input("c", "y")])));
    assert_eq!(change(&inside(1), &inside(2)), "new c. loop([Delay_2] ; In_c<y>)");
    assert_eq!(change(&attempt(wait(1)), &Term::stop()), "[Stop]");
    // A part that is gone: what follows has moved up.
    assert_eq!(change(&seq([Term::stop(), wait(1)]), &wait(1)), "[Delay_1]");
    let deep = (0..100_000).fold(wait(1), |term, _| Term::attempt(term));
    let other = (0..100_000).fold(wait(2), |term, _| Term::attempt(term));
    assert_eq!(marked(&deep, &other).places.len(), 1);
    std::mem::forget((deep, other));
}

/// A walk over a text's declarations.
fn walk(declarations: &str, subject: &str) -> Result<Walk, String> {
    let mut environment = pars::library::standard().expect("the prelude");
    for result in environment.declare(&parse(declarations).items, declarations) {
        assert!(result.is_ok(), "{result:?}");
    }
    Walk::new(&environment, subject, Origin::Prompt, false)
}

/// What the last of these lines is answered.
fn answers(walk: &mut Walk, lines: &[&str]) -> String {
    lines.iter().map(|line| walk.answer(line).text).last().unwrap_or_default()
}

#[test]
fn each_absence_has_its_reason() {
    // Termination comes first, and kills what stands beside it.
    let mut run = walk("", "(Delay_1 # Out_{c,0}) ; Delay_1").expect("a meaning");
    assert!(answers(&mut run, &["why not c!"]).contains("it is there: move 1"));
    let text = answers(&mut run, &["wait 1", "why not c!"]);
    assert!(text.contains("at step 1 (wait 1) `Out_{c,0}` was killed by `#`"), "{text}");
    let text = answers(&mut run, &["wait 1", "why not c"]);
    assert!(text.contains("the process has stopped: ending comes before every move"), "{text}");
    // Maximal progress.
    let mut run = walk("", "new c. (In_c<y> | Out_{c,3}) | Delay_2").expect("a meaning");
    let text = answers(&mut run, &["why not wait"]);
    assert!(text.contains("maximal progress") && text.contains("pass 3 over c"), "{text}");
    // A private port without a partner, which comes later.
    let mut run = walk("", "new c. (In_c<y> | Delay_2 ; Out_{c,3})").expect("a meaning");
    let text = answers(&mut run, &["why not c?"]);
    assert!(text.contains("c is private") && text.contains("comes after `Delay_2`, which still waits for 2"), "{text}");
    let text = answers(&mut run, &["why not wait 3"]);
    assert!(text.contains("only 2 of time can pass") && text.contains("maximal progress"), "{text}");
    // A guard that is false, with its values.
    let mut run = walk("", "In_c<y> ; Gtr_{y,5} ; Out_{d,y} else Delay_1").expect("a meaning");
    let text = answers(&mut run, &["1 2", "why not d!"]);
    assert!(text.contains("at step 1 (read 2 from c)") && text.contains("2 > 5 is false"), "{text}");
    // No partner, and no use at all.
    assert!(answers(&mut run, &["why not e?"]).contains("nothing in this process reads from e"));
    // An observer that is hidden, and one that is not reached.
    let mut run = walk("observer B(x)", "(At_1 | Delay_1 ; B_2) to {B}").expect("a meaning");
    assert!(answers(&mut run, &["why not At"]).contains("hides it"));
    assert!(answers(&mut run, &["why not B"]).contains("comes after `Delay_1`"));
    // A draw that is due.
    let mut run = walk("", "Ran_{Mix(1/2: Point(0), 1/2: Point(1))}<x> | Out_{c,0}").expect("a meaning");
    assert!(answers(&mut run, &["why not c!"]).contains("a draw is due"));
    assert!(answers(&mut run, &["why not wait"]).contains("while a draw is due"));
}

#[test]
fn what_is_not_possible_has_a_number_too() {
    let mut run = walk("", "new c. (Out_{c,1} ; Delay_1) # Delay_3").expect("a meaning");
    let text = answers(&mut run, &["moves"]);
    assert!(text.contains("1. wait 3") && text.contains("not possible: 2. write 1 to c"), "{text}");
    assert!(answers(&mut run, &["why not 2"]).contains("there is none"));
    assert!(answers(&mut run, &["why not 1"]).contains("move 1 is there"));
    assert!(run.answer("2").failed && run.answer("77").failed && run.answer("x").failed && run.answer("wait 4").failed);
    assert!(!run.answer("1").failed);
    assert!(answers(&mut run, &["moves"]).contains("it has stopped"));
}

#[test]
fn a_read_asks_for_its_value() {
    let mut run = walk("", "In_c<y> ; Out_{d,2*y}").expect("a meaning");
    assert!(answers(&mut run, &["1"]).contains("which value?"));
    assert!(answers(&mut run, &["5/2"]).contains("1. write 5 to d"));
    assert!(answers(&mut run, &["undo", "1 4"]).contains("write 8 to d"));
    assert!(answers(&mut run, &["initial", "redo"]).contains("write 8 to d"));
    assert!(answers(&mut run, &["trace"]).contains("read 4 from c"));
    assert!(run.answer("undo").text.contains("read from c") && run.answer("undo").failed);
    assert!(run.answer("1 y").failed && run.answer("1 5/0").failed && run.answer("wait x").failed);
}

#[test]
fn parameters_are_given_or_chosen_as_assumed() {
    let declarations = "param t > 0, a, b, a != b, n : natural, b > 2*a\nproc P = Delay_t ; (Delay_n)^n ; Out_{c,b-a}";
    let text = walk(declarations, "P with t = 1/2, n = 2").expect("a meaning").opening();
    assert!(text.contains("t = 1/2\n") && text.contains("n = 2\n") && text.contains("b = ") && text.contains("chosen"));
    let wrong = |subject: &str| walk(declarations, subject).err().expect("refused");
    assert!(wrong("P with t = 0").contains("break what is assumed"));
    assert!(wrong("P with n = 1/2").contains("natural"));
    assert!(wrong("P with a = 1, b = 1").contains("break what is assumed"));
    assert!(wrong("P with q = 1").contains("no parameter `q`"));
    assert!(wrong("P with t").contains("="));
    assert!(wrong("Q").contains("there is no process or system `Q`"));
    assert!(wrong("?P ; P").contains("stands for anything"));
    assert!(wrong("P ;").contains("<step>"));
    assert!(walk("fn s(d)", "Delay_{s(1)}").err().expect("refused").contains("s(1)"));
}

fn program(arguments: &[&str], input: &str) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_pars"))
        .args(arguments)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("pars runs");
    // A program that ends early need not read it all.
    let _ = child.stdin.take().expect("a pipe").write_all(input.as_bytes());
    child.wait_with_output().expect("an end")
}

#[test]
fn a_saved_trace_replays_until_the_mission_changes() {
    let folder = tempfile::tempdir().expect("a folder");
    let (mission, trace) = (folder.path().join("mission.pars"), folder.path().join("run.trace"));
    let text = "param t > 0\nproc Ask = Delay_t ; In_c<y> ; Gtr_{y,2} ; Out_{d,y}\n";
    std::fs::write(&mission, text).expect("written");
    let steps = format!("wait 1\n1 5\n1\nsave {}\n", trace.display());
    let mission = mission.display().to_string();
    let output = program(&["step", &mission, "Ask", "--with", "t = 1"], &steps);
    let said = String::from_utf8_lossy(&output.stdout).to_string();
    assert_eq!(output.status.code(), Some(0), "{said}{}", String::from_utf8_lossy(&output.stderr));
    assert!(said.contains("> 1 5\nread 5 from c\n") && said.contains("it has stopped with y = 5"), "{said}");
    let replay = || program(&["step", "--replay", &trace.display().to_string()], "");
    let output = replay();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    std::fs::write(&mission, text.replace("y,2", "y,7")).expect("written");
    let output = replay();
    assert_eq!(output.status.code(), Some(1));
    let why = String::from_utf8_lossy(&output.stderr).to_string();
    assert!(why.contains("run.trace:6: no longer possible after 2 steps"), "{why}");
    std::fs::write(&mission, "proc Ask = ").expect("written");
    assert_eq!(replay().status.code(), Some(3));
}

#[test]
fn the_program_refuses_what_it_cannot_step() {
    let code = |arguments: &[&str], input: &str| program(arguments, input).status.code();
    assert_eq!(code(&["step"], ""), Some(2));
    assert_eq!(code(&["step", "no/such.pars"], ""), Some(3));
    assert_eq!(code(&["step", "examples/first.pars"], ""), Some(3), "no process there");
    assert_eq!(code(&["step", "examples/back_and_forth.pars", "Nowhere"], ""), Some(3));
    assert_eq!(code(&["step", "examples/back_and_forth.pars"], "1\nfly\n"), Some(1));
    assert_eq!(code(&["step", "examples/back_and_forth.pars"], "1\nwait\n// so far\nquit\n9\n"), Some(0));
    assert_eq!(code(&["step", "--replay", "examples/first.pars"], ""), Some(3), "no trace");
}

#[test]
fn every_example_with_a_system_can_be_stepped() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let mut seen = 0;
    for entry in std::fs::read_dir(folder).expect("examples").flatten() {
        let text = std::fs::read_to_string(entry.path()).unwrap_or_default();
        if text.lines().filter(|line| line.starts_with("system ")).count() == 1 {
            seen += 1;
            let path = entry.path().display().to_string();
            let output = program(&["step", &path], "1\n1\n1\n");
            assert_eq!(output.status.code(), Some(0), "{path}: {}", String::from_utf8_lossy(&output.stderr));
        }
    }
    assert!(seen > 2);
}

#[test]
fn a_damaged_or_foreign_trace_is_refused_with_its_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).display().to_string();
    std::fs::write(path("mission.pars"), "param t > 0\nproc Ask = Delay_t ; In_c<y> ; Out_{d,y}\n").expect("written");
    let steps = format!("wait\n1 5\nsave {}\n", path("good.trace"));
    assert_eq!(program(&["step", &path("mission.pars"), "Ask", "--with", "t = 2"], &steps).status.code(), Some(0));
    let good = std::fs::read_to_string(path("good.trace")).expect("saved");
    let replay = |text: &str| {
        std::fs::write(path("one.trace"), text).expect("written");
        let output = program(&["step", "--replay", &path("one.trace")], "");
        (output.status.code(), String::from_utf8_lossy(&output.stderr).to_string())
    };
    assert_eq!(replay(&good).0, Some(0));
    // Line ends of another system change nothing.
    assert_eq!(replay(&good.replace('\n', "\r\n")).0, Some(0));
    let cases = [
        (good.replace("wait 2", "wait 1"), 1, "one.trace:5: no longer possible after 1 step"),
        (good.replace("read 5", "read 6"), 1, "the trace says `read 6 from c`, but this is `read 5 from c`"),
        (good.replace("wait 2", "wait -2"), 1, "one.trace:4"),
        (good.clone() + "jump\n", 3, "one.trace:6: unreadable after 2 steps: line 6: `jump` is no step"),
        (good.replace("start Ask", "start Nobody"), 3, "there is no process or system `Nobody`"),
        (good.replace("t = 2", "t = 0"), 3, "t > 0"),
        (good.replace("mission.pars", "gone.pars"), 3, "gone.pars"),
        (good.lines().take(2).collect::<Vec<_>>().join("\n"), 3, "no line begins with `start`"),
        ("des (0, 1, 2)\n(0, \"a\", 1)\n".to_string(), 3, "no line begins with `start`"),
        (String::new(), 3, "no line begins with `start`"),
    ];
    for (text, code, said) in cases {
        let (found, why) = replay(&text);
        assert!(found == Some(code) && why.contains(said), "{text}\ngives {found:?}: {why}\nnot {code}: {said}");
    }
}

#[test]
fn several_steps_stand_on_one_line() {
    let mut run = walk("", "Out_{c,0} ; Delay_2 ; In_c<y>").expect("a meaning");
    let text = answers(&mut run, &["1, wait 2, 1 (1,2)"]);
    assert!(text.starts_with("write 0 to c\nwait 2\nread (1,2) from c\nstep 3, time 2\n"), "{text}");
    assert!(answers(&mut run, &["undo, undo"]).contains("step 1, time 0"));
    let text = answers(&mut run, &["wait 1, 7, wait 1"]);
    assert!(text.starts_with("wait 1\nthere is no move 7") && text.contains("step 2, time 1"), "{text}");
    let text = answers(&mut run, &["initial, 1, 1 , , quit"]);
    assert!(text.contains("step 2, time 2"), "{text}");
}

#[test]
fn what_stands_beside_stays_where_it_stood() {
    let mut run = walk("", "(Delay_9 ; Out_{d,0}) | Out_{c,0} ; Delay_20 ; Delay_3 | In_e<y>").expect("a meaning");
    let place = |text: &str, what: &str| text.lines().nth(1).and_then(|line| line.find(what)).expect("a part");
    let text = answers(&mut run, &[""]);
    assert!(place(&text, "Delay_9") < place(&text, "Out_{c,0}") || place(&text, "In_e") < place(&text, "Out_{c,0}"));
    let order = |text: &str, parts: [&str; 3]| {
        let mut places = parts.map(|part| (place(text, part), part));
        places.sort_unstable();
        places.map(|(_, part)| parts.iter().position(|one| *one == part))
    };
    let before = order(&text, ["Delay_9", "Out_{c,0}", "In_e"]);
    let moves = answers(&mut run, &[""]);
    let number = moves.lines().find(|line| line.contains("write 0 to c")).expect("a move").trim_start();
    let text = answers(&mut run, &[&number[..1]]);
    let state = text.split_once('\n').expect("lines").1;
    assert_eq!(order(state, ["Delay_9", "Delay_20", "In_e"]), before, "{text}");
    // Back and on again, and after another step, it is the same.
    let again = answers(&mut run, &["undo", "redo"]);
    assert!(state.starts_with(&again) || again.contains(state.lines().nth(1).expect("a state")), "{again}");
}

#[test]
fn what_has_stopped_does_not_still_run() {
    let mut run = walk("", "Set_{(1,2)}<x> | Delay_1").expect("a meaning");
    let text = answers(&mut run, &["why not abort"]);
    assert!(text.contains("`Set_{(1,2)}<x>` has stopped") && text.contains("`Delay_1` still waits"), "{text}");
}
