//! Exercises: the answers, other roads, and what wrong steps are told.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use pars::diagnostic::Source;
use pars::exercise::{Attempt, read};

fn never() -> bool {
    false
}

/// The exercise of this name in a text.
fn attempt(text: &str, name: &str) -> Attempt {
    let none = |_: &str, _: &str| Err("nothing to import".to_string());
    let all = read(&Source::new("exercises.pars", text), none, &never).expect("exercises");
    let (exercise, environment) = all.iter().find(|(one, _)| one.name.as_str() == name).expect("the exercise");
    Attempt::new(exercise, environment, false)
}

fn example(file: &str, name: &str) -> Attempt {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/exercises").join(file);
    attempt(&std::fs::read_to_string(path).expect("an example"), name)
}

/// What each of these lines but the last is answered must not solve it; the last must.
fn solves(attempt: &mut Attempt, lines: &[&str]) -> String {
    let mut text = String::new();
    for (place, line) in lines.iter().enumerate() {
        let answer = attempt.answer(line, &never);
        assert_eq!(answer.solved, place + 1 == lines.len(), "{line}: {}", answer.text);
        text = answer.text;
    }
    assert!(text.contains("checked by the kernel"), "{text}");
    text
}

fn refused(attempt: &mut Attempt, line: &str) -> String {
    let before = attempt.show();
    let answer = attempt.answer(line, &never);
    assert!(!answer.solved && attempt.show() == before, "{}", answer.text);
    answer.text
}

#[test]
fn every_exercise_has_its_answer() {
    // The search needs more room than a test's thread has; the program gives it a gigabyte.
    std::thread::Builder::new().stack_size(256 << 20).spawn(all_answers).expect("a thread").join().expect("an end");
}

fn all_answers() {
    let text = solves(
        &mut example("sequence.pars", "sum"),
        &["Delay_1 ; Delay_2 ; Delay_3", "delay-sum", "= {delay-sum} Delay_6"],
    );
    assert!(text.contains("solved in 3 steps; checked"), "{text}");
    solves(&mut example("sequence.pars", "dead"), &["seq-dead", "par-abort"]);
    solves(&mut example("parallel.pars", "longer"), &["= {delay-max} Delay_3 ; Delay_2", "= {delay-sum} Delay_5"]);
    solves(&mut example("parallel.pars", "rescue"), &["= {par-stop} try(?P) ; ?Q", "= {else-first} ?P ; ?Q"]);
    solves(&mut example("parallel.pars", "choice"), &["= {seq-stop-right} (?G ; ?P) | (?H ; ?Q)"]);
    solves(&mut example("observe.pars", "watch"), &["Delay_3 # A(0)"]);
    solves(&mut example("observe.pars", "hide"), &["Delay_3 # A(0)", "forget"]);
    solves(
        &mut example("loop.pars", "unroll"),
        &["= {loop-unroll} try(Delay_1 ; ?P ; loop(Delay_1 ; ?P))", "= {else-first} Delay_1 ; ?P ; loop(Delay_1 ; ?P)"],
    );
    solves(&mut example("loop.pars", "copies"), &["= {power-delay} Delay_{2*?t}"]);
}

#[test]
fn another_road_is_accepted_and_said_to_be_one() {
    let text = solves(&mut example("sequence.pars", "sum"), &["= {delay-sum, seq-stop-left} Delay_6"]);
    assert!(text.contains("solved in 1 step, by a road of your own"), "{text}");
    let longer = ["= {guard-twice} Delay_1 ; Delay_2 ; Delay_3", "= Delay_1 ; Delay_5", "Delay_6"];
    let mut attempt = example("sequence.pars", "sum");
    assert!(refused(&mut attempt, longer[0]).contains("not among the laws"));
    let text = solves(&mut attempt, &["Delay_1 ; Delay_2 ; Delay_3", longer[1], longer[2]]);
    assert!(text.contains("by a road of your own"), "{text}");
    let choice = ["= ?G ; ?P ; Stop | ?H ; ?Q ; Stop", "= (?G ; ?P) | (?H ; ?Q)"];
    solves(&mut example("parallel.pars", "choice"), &choice);
}

#[test]
fn a_wrong_step_is_answered_with_a_run_and_with_what_it_needs() {
    let mut attempt = attempt("exercise tries \"Once is enough\" prove (?P | Stop) | Stop = ?P | Stop", "tries");
    let text = refused(&mut attempt, "= ?P");
    assert!(text.contains("take ?P = Abort") && text.contains("the left side has stopped"), "{text}");
    assert!(text.contains("it needs ?P never to abort (then it is proved)"), "{text}");
    // The condition that helps may be one on values.
    let mut attempt = self::attempt(
        "exercise late \"Longer\" prove Delay_?a | Delay_?b = Delay_{max(?a,?b)} when ?a >= 0, ?b >= 0",
        "late",
    );
    let text = refused(&mut attempt, "= Delay_?b");
    assert!(text.contains("it needs ?a <= ?b (then it is proved)"), "{text}");
    // A law that would give the step, were its condition met.
    let mut attempt = self::attempt("exercise dead \"Dead\" prove Abort | Stop = Stop", "dead");
    let text = refused(&mut attempt, "= {else-first} Abort");
    assert!(text.contains("the left side has stopped, the right side has aborted"), "{text}");
    let mut attempt = self::attempt("exercise dead \"Dead\" prove try(Abort) = Stop", "dead");
    let text = refused(&mut attempt, "= {else-first} Abort");
    assert!(text.contains("the law else-first would give it, but needs Abort never to abort"), "{text}");
}

#[test]
fn the_remedies_hold_up_to_the_judge() {
    use pars::kernel::Theory;
    use pars::lower::Environment;
    use pars::parser::{parse_condition, parse_term};
    use pars::proof::Statement;
    use pars::remedy::{in_words, remedies};
    let environment = pars::library::standard().expect("the prelude");
    let theory = Theory { laws: environment.laws.clone(), ..Theory::default() };
    let term = |text: &str| Environment::new().part(&parse_term(text).expect("a term")).expect("a meaning");
    let statement = |left: &str, right: &str| Statement {
        hypotheses: Vec::new(),
        left: term(left),
        connective: pars::law::Connective::Equal,
        right: term(right),
    };
    // From the table of what does not hold: each with a condition that is known to mend it.
    let known = [
        ("?P | Stop", "?P", "never_aborts(?P)"),
        ("?P # Stop", "Stop", "binds_nothing(?P)"),
        ("?P # Abort", "Abort", "not_stopped(?P)"),
        ("?P ; Abort", "?P", "never_stops(?P)"),
        ("loop(?P)", "?P ; loop(?P)", "never_aborts(?P)"),
    ];
    for (left, right, condition) in known {
        let found = remedies(&theory, &statement(left, right), &never);
        let wanted = Environment::new().condition(&parse_condition(condition).expect("a condition")).expect("one");
        let all: Vec<String> = found.iter().flat_map(|one| one.conditions.iter().map(in_words)).collect();
        assert!(all.contains(&in_words(&wanted)), "{left} = {right}: {all:?}");
    }
    // Nothing in the list mends what is false of everything.
    assert!(remedies(&theory, &statement("Delay_1 ; ?P", "Abort ; ?P"), &never).is_empty());
}

#[test]
fn hints_come_one_at_a_time_and_other_lines_are_answered() {
    let mut attempt = example("sequence.pars", "dead");
    assert!(attempt.answer("hint", &never).text.starts_with("hint 1 of 2"));
    assert!(attempt.answer("hint", &never).text.starts_with("hint 2 of 2"));
    assert!(attempt.answer("hint", &never).text.contains("no more hints"));
    assert!(attempt.answer("laws", &never).text.starts_with("law seq-dead"));
    assert!(refused(&mut attempt, "= {seq-daed} Abort | Delay_2").contains("did you mean `seq-dead`?"));
    assert!(refused(&mut attempt, "= {delay-sum} Abort | Delay_2").contains("not among the laws"));
    assert!(refused(&mut attempt, "<= {seq-dead} Abort | Delay_2").contains("no step may be `<=`"));
    assert!(refused(&mut attempt, "(Abort ; Delay_1) | Delay_2").contains("you have already"));
    assert!(refused(&mut attempt, "Nowhere").contains("Nowhere"));
    assert!(refused(&mut attempt, "= {seq-dead").contains("<answer>"));
    assert!(refused(&mut attempt, "what now").contains("<answer>"));
    assert!(refused(&mut attempt, "undo").contains("no step to take back"));
    // True, but not by the laws named, or by none that are allowed.
    assert!(refused(&mut attempt, "= {par-abort} Abort | Delay_2").contains("but not by par-abort alone"));
    let text = refused(&mut attempt, "= (Abort ; Delay_1) | (Delay_1 ; Delay_1)");
    assert!(text.contains("which this exercise does not allow"), "{text}");
    assert!(!attempt.answer("seq-dead", &never).solved);
    assert!(attempt.answer("undo", &never).text.contains("____"));
    assert!(attempt.answer("quit", &never).quit);
}

#[test]
fn a_false_law_of_the_file_is_not_in_force() {
    let text =
        "law easy \"Easy.\"\n  ours a trap\n  ?P ; Abort = Abort\nexercise x \"X\" prove Delay_1 ; Abort = Abort";
    let none = |_: &str, _: &str| Err("nothing to import".to_string());
    let failures = read(&Source::new("x.pars", text), none, &never).err().expect("refused");
    assert_eq!(failures[0].diagnostics[0].code, "P0906");
}

fn program(arguments: &[&str], input: &str) -> (Option<i32>, String) {
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
    let output = child.wait_with_output().expect("an end");
    let all = [output.stdout, output.stderr].concat();
    (output.status.code(), String::from_utf8_lossy(&all).to_string())
}

#[test]
fn the_program_takes_answers_from_standard_input() {
    let file = "examples/exercises/sequence.pars";
    let (code, text) = program(
        &["exercise", file],
        "Delay_1 ; Delay_2 ; Delay_3\n// so far\ndelay-sum\nDelay_6\nseq-dead\npar-abort\n",
    );
    assert_eq!(code, Some(0), "{text}");
    assert_eq!(program(&["exercise", file, "dead"], "seq-dead\npar-abort\n").0, Some(0));
    assert_eq!(program(&["exercise", file, "dead"], "seq-dead\n").0, Some(1));
    assert_eq!(program(&["exercise", file, "dead"], "quit\n").0, Some(1));
    let (code, text) = program(&["exercise", file, "daed"], "");
    assert!(code == Some(3) && text.contains("did you mean `dead`?"), "{text}");
    assert_eq!(program(&["exercise", "examples/first.pars"], "").0, Some(3));
    assert_eq!(program(&["exercise", "no/such.pars"], "").0, Some(3));
    assert_eq!(program(&["exercise"], "").0, Some(2));
}

#[test]
fn the_laws_alone_may_stand_in_braces() {
    let text = "exercise sum \"Two delays are one\"\n  prove Stop ; Delay_1 ; Delay_2 = Delay_3\n  steps {\n    \
                = {_} Delay_1 ; Delay_2\n    = {_} Delay_3\n  }\n";
    let answer = solves(&mut attempt(text, "sum"), &["{seq-stop-left}", "delay-sum"]);
    assert!(answer.contains("solved in 2 steps"), "{answer}");
}

#[test]
fn a_step_is_by_the_laws_named_and_units_are_free() {
    let text = "exercise e \"x\"\n  prove Abort | (Stop ; Delay_1) = Delay_1\n  using par-stop\n";
    let mut attempt = self::attempt(text, "e");
    let answer = refused(&mut attempt, "= {par-stop} Delay_1");
    assert!(answer.contains("the step holds, but not by par-stop: by par-abort, seq-stop-left"), "{answer}");
    let answer = solves(&mut attempt, &["= {par-abort, seq-stop-left} Delay_1"]);
    assert!(answer.contains("= {par-abort, seq-stop-left}"), "{answer}");
    // Beside a law that is named they are used without a word, and the calculation says which were.
    let text = "exercise e \"x\"\n  prove Stop ; Delay_1 ; Delay_2 = Delay_3\n  using delay-sum\n";
    let answer = solves(&mut self::attempt(text, "e"), &["= {delay-sum} Delay_3"]);
    assert!(answer.contains("= {delay-sum, ") && answer.contains("seq-stop-left}"), "{answer}");
}

#[test]
fn an_answer_may_begin_with_any_process() {
    let mut rescue = example("parallel.pars", "rescue");
    solves(&mut rescue, &["try(?P) ; ?Q", "?P ; ?Q"]);
    let text = "exercise e \"x\"\n  prove Stop ; loop(Delay_1) = loop(Delay_1)";
    solves(&mut attempt(text, "e"), &["loop(Delay_1)"]);
    let text = "exercise e \"x\"\n  prove Stop ; new c. In_c<x> = new c. In_c<x>";
    solves(&mut attempt(text, "e"), &["new c. In_c<x>"]);
}
