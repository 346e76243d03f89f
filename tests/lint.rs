//! What is found in the laws of a file, each with its evidence; and that every known trap is one.

use std::cell::Cell;
use std::process::Command;

use pars::diagnostic::{Diagnostic, Source};
use pars::lint::{Lint, lint, traps};
use pars::refute::{Limits, judge};

fn look(text: &str) -> Lint {
    let none = |_: &str, _: &str| Err("nothing to import".to_string());
    lint(&Source::new("mine.rules", text), none, &|| false).expect("laws")
}

/// The only finding.
fn only(text: &str) -> Diagnostic {
    let found = look(text).findings;
    assert_eq!(found.len(), 1, "{found:?}");
    found.into_iter().next().expect("one")
}

fn notes(diagnostic: &Diagnostic) -> String {
    diagnostic.render(&Source::new("mine.rules", ""), false)
}

#[test]
fn every_trap_is_refuted_and_is_recognised() {
    let limits = Limits { instances: 4_000, choices: 200_000, ..Limits::default() };
    let mut seen = 0;
    for trap in traps().iter() {
        seen += 1;
        let found = judge(trap, &limits);
        assert!(found.counterexample().is_some(), "{trap}: {found:?}");
        assert!(!trap.title.is_empty());
    }
    assert_eq!(seen, include_str!("../rules/traps.pars").matches("\nlaw ").count(), "one cannot be read");
}

#[test]
fn a_trap_is_named_with_its_run_and_what_it_needs() {
    let found = look("law mine \"Mine.\"\n  ours\n  ?Q ; Abort = Abort\n").findings;
    let codes: Vec<&str> = found.iter().map(|one| one.code).collect();
    assert_eq!(codes, ["P0906", "P0921"]);
    assert!(notes(&found[0]).contains("the left side still runs, the right side has aborted"), "{found:?}");
    assert!(notes(&found[0]).contains("`when "), "what would mend it: {found:?}");
    assert!(notes(&found[1]).contains("is seen"), "{found:?}");
    // An instance of a trap, turned round, is one too.
    let found = look("law mine \"Mine.\"\n  ours\n  Delay_1 ; (?P | ?Q) = (Delay_1 ; ?P) | (Delay_1 ; ?Q)\n").findings;
    assert!(!found.iter().any(|one| one.code == "P0921"), "it holds, for a delay does not communicate: {found:?}");
    let found = look("law mine \"Mine.\"\n  ours\n  ?P ; loop(?P) = loop(?P)\n").findings;
    assert!(found.iter().any(|one| one.code == "P0921"), "{found:?}");
}

#[test]
fn a_law_that_loops_shows_where_it_goes() {
    let found = only("law grow \"Grows.\"\n  ours\n  Delay_?a # Idle # Idle => Delay_?a # Idle # Idle # Idle\n");
    assert_eq!(found.code, "P0707");
    // Two laws of which each undoes the other.
    let text = "law half \"Half.\"\n  ours\n  when ?a > 0\n  Delay_?a => Delay_{?a/2} ; Delay_{?a/2}\n";
    let found = look(text).findings;
    let loops = found.iter().find(|one| one.code == "P0903").expect("it undoes delay-sum");
    assert!(notes(loops).contains("it goes from") && notes(loops).contains("to "), "{found:?}");
}

#[test]
fn an_instance_of_another_law_is_named_with_what_stands_for_what() {
    let all = look("law twice \"Twice.\"\n  ours\n  when ?a >= 1\n  Delay_?a ; Delay_?a => Delay_{2*?a}\n").findings;
    // What it overlaps with, the other does too.
    let codes: Vec<&str> = all.iter().map(|one| one.code).collect();
    assert_eq!(codes, ["P0922"], "{all:?}");
    let found = &all[0];
    assert!(notes(found).contains("`delay-sum`") && notes(found).contains("?b = ?a"), "{}", notes(found));
    // Of two that say the same the later is named, once.
    let law = |name: &str| {
        format!("law {name} \"One.\"\n  ours\n  when ?a > 1\n  Delay_?a ; At_?a = Delay_1 ; Delay_{{?a-1}} ; At_?a\n")
    };
    let found = look(&(law("one") + &law("two"))).findings;
    let later: Vec<&Diagnostic> = found.iter().filter(|one| one.message.contains("`two` follows")).collect();
    assert!(later.len() == 1 && !found.iter().any(|one| one.message.contains("`one` follows from `two`")), "{found:?}");
}

#[test]
fn overlaps_that_simplification_leaves_apart_are_shown() {
    let text = "law pair \"Pair.\"\n  ours\n  Delay_?a ; Delay_?a ; Stop => Delay_{2*?a}\n";
    let found = look(text).findings;
    let overlap = found.iter().find(|one| one.code == "P0923").expect("an overlap");
    let text = notes(overlap);
    assert!(
        text.contains("both fit") && text.contains("by `pair` it becomes") && text.contains("by `seq-stop-"),
        "{text}"
    );
}

#[test]
fn a_law_that_says_nothing_is_found() {
    let found = only("law same \"Same.\"\n  ours\n  Delay_?a ; ?P = Delay_?a ; ?P\n");
    assert_eq!(found.code, "P0924");
    assert!(notes(&found).contains("both are Delay_?a ; ?P"), "{}", notes(&found));
    let found = look("law never \"Never.\"\n  ours\n  Delay_{-1} = Delay_{-2}\n").findings;
    let nothing = found.iter().find(|one| one.code == "P0924").expect("no instance has a meaning");
    assert!(notes(nothing).contains("its only small instance has no meaning"), "{}", notes(nothing));
}

#[test]
fn lists_overlap_in_any_order_with_what_else_stands_in_them() {
    let text = "law one \"One.\"\n  ours\n  At_?a | Delay_?b | Delay_?b | Delay_?b => At_?a | Delay_?b\n\
                law two \"Two.\"\n  ours\n  Delay_?c | Delay_{?c+1} | At_?d => At_?d | Delay_{?c+1}\n";
    let found = look(text).findings;
    let all: Vec<String> = found.iter().filter(|one| one.code == "P0923").map(notes).collect();
    // A law on two parts of a list of three, with a part that is not in the law.
    let stop = all.iter().find(|text| text.contains("`one` and `par-stop`")).expect("an overlap");
    assert!(stop.contains("both fit Stop | Delay_?b | Delay_?b | Delay_?b | At_?a"), "{stop}");
    // What a metavariable takes may be shared by what another takes.
    let same = all.iter().find(|text| text.contains("`one` and `par-same`")).expect("an overlap");
    assert!(same.contains("?Z1 | ?Z1") && same.contains("by `par-same` it becomes"), "{same}");
    // A law on some parts of a longer sequence.
    let text = "law pair \"Pair.\"\n  ours\n  Delay_?a ; Delay_?a ; Stop => Delay_{2*?a}\n";
    let all: Vec<String> = look(text).findings.iter().map(notes).collect();
    assert!(all.iter().any(|text| text.contains("both fit ?O1 # (Delay_?a ; Delay_?a ; Stop)")), "{all:?}");
    assert!(all.iter().any(|text| text.contains("`seq-stop-left`") && text.contains("Stop ; ?P1")), "{all:?}");
}

#[test]
fn a_loop_in_no_time_is_a_trap() {
    let found = only("law none \"None.\"\n  ours\n  loop(Stop) = Delay_1\n");
    assert_eq!(found.code, "P0602");
    assert!(notes(&found).contains("proves anything"));
}

#[test]
fn a_good_law_has_no_finding_and_the_search_can_be_stopped() {
    let good = "law rest \"To rest twice.\"\n  ours\n  when never_aborts(?P)\n  try(?P) ; Idle = ?P ; Idle\n";
    let found = look(good);
    assert!(found.laws == 1 && found.findings.iter().all(|one| one.code == "P0922"), "{:?}", found.findings);
    let asked = Cell::new(0);
    let stop = || {
        asked.set(asked.get() + 1);
        true
    };
    let none = |_: &str, _: &str| Err("nothing to import".to_string());
    let bad = "law mine \"Mine.\"\n  ours\n  ?Q ; Abort = Abort\n";
    assert!(lint(&Source::new("mine.rules", bad), none, &stop).expect("laws").findings.is_empty());
    assert!(asked.get() > 0);
}

#[test]
fn the_program_says_what_it_found() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).expect("written");
        let output = Command::new(env!("CARGO_BIN_EXE_pars")).arg("lint").arg(&path).output().expect("pars runs");
        let text = [output.stdout, output.stderr].concat();
        (output.status.code(), String::from_utf8_lossy(&text).to_string())
    };
    let (code, text) = run("bad.rules", "law mine \"Mine.\"\n  ours\n  ?P | Stop = ?P\n");
    assert_eq!(code, Some(1), "{text}");
    assert!(
        text.contains("bad.rules:1:1") && text.contains("1 law, 2 findings") && text.contains("never_aborts"),
        "{text}"
    );
    let (code, text) = run("none.rules", "// no law\n");
    assert_eq!(code, Some(0), "{text}");
    assert!(text.contains("0 laws, nothing found"), "{text}");
    assert_eq!(run("broken.rules", "law \"x\"").0, Some(3));
    assert_eq!(run("unbound.rules", "law x \"X.\"\n  ours\n  Stop = ?P\n").0, Some(3));
    let missing = Command::new(env!("CARGO_BIN_EXE_pars")).args(["lint", "no/such.rules"]).output().expect("pars runs");
    assert_eq!(missing.status.code(), Some(3));
}

fn codes(text: &str) -> Vec<&'static str> {
    look(text).findings.iter().map(|one| one.code).collect()
}

#[test]
fn a_law_that_follows_from_another_is_found_once() {
    assert_eq!(codes("law copy \"Copy.\"\n  ours\n  Idle # ?P => ?P\n"), ["P0922"]);
}

#[test]
fn no_overlap_has_conditions_that_cannot_hold_or_a_value_for_the_name_of_a_result() {
    let text = "law longer \"Longer.\"\n  ours\n  when 0 <= ?a, ?a <= ?b\n  Delay_?a | Delay_?b => Delay_?b\n";
    let all: Vec<String> = look(text).findings.iter().map(notes).collect();
    assert!(!all.iter().any(|one| one.contains("complementary(Delay")), "{all:?}");
    let text = "law put \"Put.\"\n  ours\n  Set_?x<?y> ; Delay_?y => Set_?x<?y> ; Delay_?x\n\
                law none \"None.\"\n  ours\n  Set_?x<?y> ; Delay_0 => Set_?x<?y>\n";
    let all: Vec<String> = look(text).findings.iter().filter(|one| one.code == "P0923").map(notes).collect();
    assert!(!all.iter().any(|one| one.contains("both fit Set_?x<?y> ; Delay_0")), "{all:?}");
}

#[test]
fn a_copy_of_a_file_of_the_program_stands_in_its_place() {
    let text = include_str!("../rules/delay.rules");
    let found = look(text);
    assert_eq!(found.laws, text.matches("\nlaw ").count() + usize::from(text.starts_with("law ")));
    assert!(!found.findings.iter().any(|one| one.code == "P0906" || one.code == "P0922"), "{:?}", found.findings);
    // One law of the name of another is no such copy.
    let text = "law delay-sum \"Mine.\"\n  ours\n  Delay_?a ; Delay_?a = Delay_{2*?a}\n";
    let none = |_: &str, _: &str| Err("nothing to import".to_string());
    let refused = lint(&Source::new("mine.rules", text), none, &|| false).expect_err("refused");
    assert_eq!(refused[0].diagnostics[0].code, "P0705");
}
