//! The prompt without a terminal: what is typed, and what is answered.

use std::cell::Cell;
use std::rc::Rc;

use pars::diagnostic::Source;
use pars::repl::Prompt;
use pars::script::read_file;
use pars::session::Surroundings;

#[derive(Default)]
struct World {
    stop: Cell<bool>,
}

impl Surroundings for World {
    fn find(&self, _importer: &str, path: &str) -> Result<Source, String> {
        read_file(std::path::Path::new(path)).map_err(|trouble| trouble.1.message)
    }

    fn interrupted(&self) -> bool {
        self.stop.get()
    }
}

fn prompt() -> Prompt {
    Prompt::new(Rc::new(World::default()), false).expect("the prelude").quiet()
}

/// Types lines one after the other; gives what the last is answered.
fn answer(prompt: &mut Prompt, lines: &[&str]) -> String {
    lines.iter().map(|line| prompt.answer(line).text).last().unwrap_or_default()
}

#[test]
fn a_process_alone_is_simplified_and_it_is_the_result() {
    let mut prompt = prompt();
    let text = answer(&mut prompt, &["Delay_1 ; Delay_5"]);
    assert!(text.starts_with("Delay_1 ; Delay_5\n    = Delay_6\n"), "{text}");
    assert!(answer(&mut prompt, &["it ; Delay_1"]).contains("= Delay_7"));
    assert!(answer(&mut prompt, &["prove it = Delay_7"]).starts_with("proved"));
}

#[test]
fn why_shows_each_line_with_its_law() {
    let mut prompt = prompt();
    assert!(answer(&mut prompt, &[":why"]).contains("nothing was claimed"));
    let text = answer(&mut prompt, &["prove one: Stop ; Delay_1 ; Stop = Delay_1", ":why"]);
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[0], "    Stop ; Delay_1 ; Stop");
    assert!(lines[1].starts_with("= {seq-"), "{text}");
    assert_eq!(lines.last().copied(), Some("    ⟦Delay_1⟧"));
    assert_eq!(answer(&mut prompt, &["prove Stop = Stop", ":why one"]), text);
    assert_eq!(answer(&mut prompt, &[":why 1"]), text);
    assert!(answer(&mut prompt, &["prove Stop = Abort", ":why"]).contains("no proof"));
    assert!(answer(&mut prompt, &[":why two"]).contains("there is no claim"));
}

#[test]
fn why_shows_the_induction_behind_a_form() {
    let mut prompt = prompt();
    let text = answer(&mut prompt, &["solve r(n+1) = r(n)/2 + 3, r(0) = 1", ":why"]);
    let lines: Vec<&str> = text.lines().map(str::trim).collect();
    let wanted = [
        "r(n) = 6-5*(1/2)^n",
        "start: the form gives r(0) = 1, as is given",
        "step: suppose r(n) = 6-5*(1/2)^n",
        "r(n+1) = 1/2*r(n)+3",
        "= 6-5/2*(1/2)^n",
        "which is the form at n+1",
    ];
    assert_eq!(lines, wanted);
    let text = answer(&mut prompt, &["solve r(n+1) = min(r(n)+2,10), r(0) = 0", ":why"]);
    assert!(text.contains("step for 0 <= n < 4: suppose r(n) = 2*n"), "{text}");
    assert!(text.contains("from the last index before 5 it comes to r(5) = 10"), "{text}");
    assert!(answer(&mut prompt, &["solve r(n+1) = r(n)^2+1, r(0) = 1", ":why"]).contains("no induction"));
    // A claim that comes after it is what is asked of then.
    assert!(answer(&mut prompt, &["prove Stop ; Delay_1 = Delay_1", ":why"]).contains("seq-"));
}

#[test]
fn the_chain_of_a_proof_is_a_calculation_that_can_be_proved() {
    let mut prompt = prompt();
    answer(&mut prompt, &["observer A(x)", "prove (Delay_1 ; A(1)) # Delay_3 = Delay_1 ; (A(1) # Delay_2)"]);
    let record = prompt.session().record("").expect("the claim").clone();
    let chain = record.evidence.expect("a proof").chain();
    assert!(!chain.lines.is_empty() && !chain.cut);
    let mut before = chain.start;
    for line in chain.lines {
        let step = format!("prove {before} {} {}", line.connective, line.term);
        assert!(answer(&mut prompt, &[&step]).starts_with("proved"), "{step}");
        before = line.term;
    }
}

#[test]
fn a_definition_that_changes_marks_what_was_proved_with_it() {
    let mut prompt = prompt();
    let text = answer(
        &mut prompt,
        &[
            "param t > 0\nfn s(x) = x",
            "proc A = Delay_{s(t)}",
            "proc B = A ; Stop",
            "prove mine: B = A",
            "prove other: Stop ; Stop = Stop",
            "proc A = Delay_2",
        ],
    );
    assert!(text.contains("claim mine is stale"), "{text}");
    assert!(answer(&mut prompt, &[":why mine"]).starts_with("stale"));
    assert!(!answer(&mut prompt, &[":why other"]).contains("stale"));
    assert!(!answer(&mut prompt, &[":undo", ":why mine"]).contains("stale"), "undone");
    let text = answer(&mut prompt, &["fn s(x) = 2*x"]);
    assert!(text.contains("claim mine is stale") && text.contains("A still has the earlier s"), "{text}");
}

#[test]
fn undo_goes_back_to_before_the_last_input() {
    let mut prompt = prompt();
    answer(&mut prompt, &["proc A = Delay_1", "proc A = Delay_2", "prove = nothing", ":undo"]);
    assert_eq!(answer(&mut prompt, &[":show A"]), "proc A = Delay_1\n");
    assert!(answer(&mut prompt, &[":undo", ":show A"]).contains("nothing is named `A`"));
    assert!(answer(&mut prompt, &[":undo"]).contains("nothing to undo"));
    answer(&mut prompt, &["proc A = Delay_1", "proc A = Delay_2", "proc A = Delay_3"]);
    assert!(answer(&mut prompt, &[":back 9"]).contains("from 0 to 3"));
    assert!(answer(&mut prompt, &[":back 1", ":show A"]).contains("Delay_1"));
    assert!(answer(&mut prompt, &[":back 0", ":show A"]).contains("nothing is named `A`"));
}

#[test]
fn what_was_typed_can_be_saved_and_loaded() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("saved.pars").display().to_string();
    let mut first = prompt();
    answer(
        &mut first,
        &["proc A = Delay_1", "A ; Stop", "nonsense", "prove a: A ; A = Delay_2", &format!(":save {path}")],
    );
    let saved = std::fs::read_to_string(&path).expect("a file");
    assert_eq!(saved, "proc A = Delay_1\nsimplify A ; Stop\nprove a: A ; A = Delay_2\n");
    let mut second = prompt();
    let text = answer(&mut second, &[&format!(":load {path}")]);
    assert!(text.contains("proved: a: A ; A = Delay_2"), "{text}");
    assert!(answer(&mut second, &[":show A"]).contains("Delay_1"));
    let proof = folder.path().join("proof.json");
    assert!(answer(&mut second, &[&format!(":proof {} a", proof.display())]).contains("written"));
    assert!(pars::proof_file::check_file(&std::fs::read(proof).expect("a file")).is_ok());
}

#[test]
fn the_shortest_prefix_will_do_and_slips_are_named() {
    let mut prompt = prompt();
    assert!(answer(&mut prompt, &[":h"]).contains(":why [claim]"));
    assert!(answer(&mut prompt, &[":s"]).contains(":show, :save"));
    assert!(answer(&mut prompt, &[":hlep"]).contains("did you mean `:help`?"));
    assert!(answer(&mut prompt, &[":laws delay-sum"]).contains("Delays add"));
    assert!(answer(&mut prompt, &[":law delay-sum"]).starts_with("law delay-sum"));
    assert!(answer(&mut prompt, &[":law delay-smu"]).contains("did you mean `delay-sum`?"));
    assert!(answer(&mut prompt, &[":help P0203"]).contains("brackets"));
    assert!(prompt.answer(":q").quit);
    assert!(!prompt.answer("").quit);
}

#[test]
fn an_expectation_may_come_later() {
    let mut prompt = prompt();
    assert!(!answer(&mut prompt, &["prove Stop = Abort", "expect refuted"]).contains("but expected"));
    assert!(answer(&mut prompt, &["expect proved"]).contains("but expected proved"));
}

#[test]
fn a_search_that_is_stopped_says_so() {
    let world = Rc::new(World::default());
    let mut prompt = Prompt::new(world.clone(), false).expect("the prelude").quiet();
    world.stop.set(true);
    let text = prompt.answer("prove loop(?P) | ?Q = loop(?P) | ?Q | loop(?P) when silent(?P), lasts(?P, 1)").text;
    assert!(text.starts_with("interrupted, could not prove"), "{text}");
}

#[test]
fn a_process_is_stepped_at_the_prompt() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.trace").display().to_string();
    let mut prompt = prompt();
    assert!(answer(&mut prompt, &["step Nowhere"]).contains("there is no process"));
    assert!(!prompt.stepping());
    let text =
        answer(&mut prompt, &["param t > 0", "observer B(x)", "proc A_u = (Delay_t # B_u) ; A_{u+1}", "step A_3"]);
    assert!(text.contains("t = 1 (chosen here") && text.contains("shows B_3") && prompt.stepping(), "{text}");
    assert!(answer(&mut prompt, &["1", "wait 1/2"]).contains("step 2, time 3/2"));
    assert!(answer(&mut prompt, &[&format!("save {path}")]).contains("2 steps"));
    assert!(answer(&mut prompt, &["initial"]).contains("step 0"));
    assert!(answer(&mut prompt, &[&format!("load {path}")]).contains("shows B_4"));
    assert!(answer(&mut prompt, &["load no/such"]).contains("there is no file"));
    assert!(!prompt.answer("quit").quit && !prompt.stepping(), "back at the prompt");
    assert!(answer(&mut prompt, &["Delay_1"]).contains("= Delay_1"));
    // What was saved at the prompt stands by itself.
    let saved = std::fs::read_to_string(path).expect("a trace");
    let trace = pars::walk::saved(&saved);
    assert!(pars::parser::parse(&trace.head).diagnostics.is_empty(), "{saved}");
    let head = Source::new("run.trace", trace.head.clone());
    let environment = pars::walk::declarations(&head, |_, _| Err("none".to_string())).expect("declarations");
    let start = trace.start.clone().expect("a start");
    let mut walk = pars::walk::Walk::new(&environment, &start, pars::walk::Origin::Prompt, false).expect("a meaning");
    walk.replay(&trace).expect("all steps");
    assert!(walk.answer("moves").text.contains("shows B_4"));
}

#[test]
fn a_proof_is_written_for_print() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("proof.tex").display().to_string();
    let mut prompt = prompt();
    assert!(answer(&mut prompt, &[":latex"]).contains("there is no claim"));
    let text = answer(&mut prompt, &["prove one: Stop ; Delay_1 = Delay_1", "prove Stop = Abort", ":latex one"]);
    assert!(text.starts_with("\\begin{align*}\n  & \\mathsf{Stop}\\mathbin{;}"), "{text}");
    assert!(text.contains("\\text{\\small seq-stop-left: "), "{text}");
    assert!(answer(&mut prompt, &[":latex"]).contains("no proof to write"));
    assert!(answer(&mut prompt, &[&format!(":latex {path} one")]).contains("written"));
    let document = std::fs::read_to_string(path).expect("a document");
    assert!(document.contains(&text) && document.starts_with("\\documentclass"), "{document}");
    assert!(answer(&mut prompt, &[":latex no/such/folder/x.tex one"]).contains("cannot be written"));
    assert!(answer(&mut prompt, &[":latex x.tex two"]).contains("there is no claim `two`"));
}

#[test]
fn an_exercise_is_done_at_the_prompt() {
    let mut prompt = prompt();
    assert!(answer(&mut prompt, &[":exercise"]).contains("there are no exercises here"));
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/exercises/sequence.pars");
    let text = answer(&mut prompt, &[&format!(":load {}", folder.display()), ":exercise"]);
    assert!(text.contains("sum ") && text.contains("After Abort nothing starts"), "{text}");
    assert!(answer(&mut prompt, &[":exercise none"]).contains("there is no exercise `none`"));
    assert!(answer(&mut prompt, &[":exercise dead"]).contains("show that"));
    assert_eq!(prompt.sign(), "exercise> ");
    assert!(answer(&mut prompt, &["seq-dead", "par-abort"]).contains("solved in 2 steps"));
    assert_eq!(prompt.sign(), "pars> ");
    assert!(answer(&mut prompt, &[":exercise dead", "quit", "Delay_1"]).contains("= Delay_1"));
}

#[test]
fn a_system_can_be_typed_in_the_order_of_the_paper() {
    let mut prompt = prompt();
    answer(&mut prompt, &["param t > 0, p0, a, b, a != b, p0 != a"]);
    let text = answer(&mut prompt, &["proc BF_{a,b} = MoveTo_a ; MoveTo_b ; BF_{a,b}"]);
    assert_eq!(text, "BF waits for MoveTo, and is declared with it\n");
    assert!(answer(&mut prompt, &[":show"]).contains("BF waits for MoveTo"));
    let text = answer(&mut prompt, &["system Sys = DEnv_{p0} | BF_{a,b}"]);
    assert_eq!(text, "Sys waits for DEnv, and is declared with it\n");
    let text = answer(&mut prompt, &["proc MoveTo_g = In_p<r> ; Neq_{r,g} ; Out_{v,(g-r)/t} ; MoveTo_g"]);
    assert_eq!(text, "BF declared\nMoveTo declared\n");
    let text = answer(&mut prompt, &["property Goal = Delay_{?t1} ; (Delay_{?t2} # At_a) ; Delay_{?t3} ; Goal"]);
    assert_eq!(text, "Goal declared\n");
    let text = answer(&mut prompt, &["prove Sys satisfies Goal"]);
    assert!(text.contains("there is no system `Sys`") && text.contains("Sys waits for DEnv"), "{text}");
    answer(&mut prompt, &["proc DEnv_r = (Delay_t # Odo_r # At_r) ; In_v<u> ; DEnv_{r+u*t}"]);
    let text = answer(&mut prompt, &["proc Odo_r = Out_{p,r} ; Odo_r"]);
    let declared: std::collections::BTreeSet<&str> = text.lines().collect();
    assert_eq!(declared, ["DEnv declared", "Odo declared", "Sys declared"].into());
    let text = answer(&mut prompt, &["prove Sys satisfies Goal"]);
    assert!(text.starts_with("proved") && text.contains("?t1 = t, ?t2 = t, ?t3 = 0"), "{text}");
}

#[test]
fn what_waits_can_be_forgotten_typed_anew_and_is_no_slip_of_the_pen() {
    let mut prompt = prompt();
    assert!(answer(&mut prompt, &["proc P = Dellay_1"]).contains("did you mean `Delay`"));
    // Two that call each other are declared together.
    assert_eq!(answer(&mut prompt, &["proc Ping = Delay_1 ; Pong"]), "Ping waits for Pong, and is declared with it\n");
    assert_eq!(answer(&mut prompt, &["proc Ping = Delay_2 ; Pong"]), "Ping waits for Pong, and is declared with it\n");
    assert_eq!(answer(&mut prompt, &["proc Pong = Delay_3 ; Ping"]), "Ping declared\nPong declared\n");
    assert!(answer(&mut prompt, &[":show Ping"]).contains("Delay_2"));
    answer(&mut prompt, &["proc Left = Right"]);
    answer(&mut prompt, &[":undo"]);
    assert_eq!(answer(&mut prompt, &["proc Right = Delay_1"]), "Right declared\n");
    assert!(answer(&mut prompt, &["simplify Left"]).contains("there is no process `Left`"));
}

#[test]
fn a_counterexample_is_walked() {
    let mut prompt = prompt();
    assert!(answer(&mut prompt, &[":step"]).contains("say what to step") && !prompt.stepping());
    let text =
        answer(&mut prompt, &["param t > 0, g > t", "prove loop(Delay_t ; Out_{c,0}) = loop(Delay_t ; Out_{c,1})"]);
    assert!(text.contains("the left side writes 0 to c") && text.contains("`:step` takes this run"), "{text}");
    // A parameter that assumptions alone tie to the claim's is not spoken of.
    assert!(text.contains("take t = ") && !text.contains("g = "), "{text}");
    assert!(text.contains("for the stepper, left: wait "), "{text}");
    let text = answer(&mut prompt, &[":step"]);
    assert!(text.starts_with("the left side of the last counterexample") && text.contains("write 0 to c"), "{text}");
    assert!(text.contains("step 1, time "), "{text}");
    assert!(answer(&mut prompt, &["undo"]).contains("step 0, time 0"));
    assert!(answer(&mut prompt, &["redo", "quit", "step right"]).contains("write 1 to c"));
    assert!(answer(&mut prompt, &["undo", "undo"]).contains("nothing to undo"));
    answer(&mut prompt, &["quit"]);
    // An instance with an observer that was made up for it, kept as a trace that stands by itself.
    let text = answer(
        &mut prompt,
        &["prove ?P ; ?Q <= ?P when never_ends(?P)", "prove Delay_1 # ?P = Delay_1 when observer(?P)"],
    );
    assert!(text.contains("refuted"), "{text}");
    let text = answer(&mut prompt, &[":step left"]);
    assert!(text.contains("shows "), "{text}");
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.trace").display().to_string();
    answer(&mut prompt, &[&format!("save {path}"), "quit"]);
    let trace = pars::walk::saved(&std::fs::read_to_string(path).expect("a trace"));
    let head = Source::new("run.trace", trace.head.clone());
    let environment = pars::walk::declarations(&head, |_, _| Err("none".to_string())).expect("declarations");
    let start = trace.start.clone().expect("a start");
    let mut walk = pars::walk::Walk::new(&environment, &start, pars::walk::Origin::Prompt, false).expect("a meaning");
    walk.replay(&trace).expect("all steps");
    // A comparison leads there too.
    let text = answer(&mut prompt, &["compare In_c<x> ; Out_{d,x} ~ In_c<x> ; Out_{d,0}", ":step"]);
    assert!(text.contains("step 1, time 0") && text.contains("Out_{d,1}"), "{text}");
}

#[test]
fn only_what_matters_is_taken() {
    let mut prompt = prompt();
    let text = answer(&mut prompt, &["prove In_c<x> ; Out_{d,x} = In_c<x> ; Out_{d,0}"]);
    assert!(text.contains("refuted") && !text.contains("take x") && !text.contains(":= "), "{text}");
}
