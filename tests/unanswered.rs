//! What is said of reads and writes that nobody answers: no more than the run shows.

mod common;

fn told(script: &str) -> String {
    String::from_utf8_lossy(&common::ran(script).stdout).into_owned()
}

#[track_caller]
fn says(script: &str, said: &str, unsaid: &[&str]) {
    let told = told(script);
    assert!(told.lines().any(|line| line.trim().trim_start_matches("warning: ") == said), "not said: {said}\n{told}");
    for other in unsaid {
        assert!(!told.contains(other), "said: {other}\n{told}");
    }
}

const FOR_EVER: &str = "waits for ever";
const NOTHING: &str = "nothing waits for that";

#[test]
fn what_another_branch_ends_does_not_wait_for_ever() {
    let delays = "proc C = (Out_{q,1} # (Delay_1 ; Delay_2)) ; Delay_2 ; C\nsystem S = C\nperiod S\n";
    says(delays, "C writes port q, which nobody reads", &[FOR_EVER]);
    let read =
        "proc C = (In_q<x> # In_k<y>) ; Delay_1 ; C\nproc D = Delay_2 ; Out_{k,1} ; D\nsystem S = C | D\nperiod S\n";
    says(read, "C reads port q, which nobody writes", &[FOR_EVER]);
    let delay = "proc C = (Out_{q,1} # Delay_1) ; Delay_2 ; C\nsystem S = C\nperiod S\n";
    says(delay, "C writes port q, which nobody reads; nothing waits for that", &[FOR_EVER]);
}

#[test]
fn what_nothing_ends_waits_for_ever() {
    let both = "proc C = (In_q<x> # In_k<y>) ; Delay_1 ; C\nproc T = Delay_1 ; T\nsystem S = C | T\nperiod S\n";
    says(both, "unmatched communication: C reads port q and waits for ever: nobody writes it", &[NOTHING]);
}

/// The first `#` on p is ended, the second is not.
#[test]
fn a_wait_that_is_ended_once_may_be_for_ever_later() {
    let turn = "(In_p<u> # In_q<w>) ; (In_p<u> # In_r<w>)";
    let ticks = "proc B = Out_{q,1} ; T\nproc T = Delay_1 ; T\n";
    let on = format!("{ticks}proc A = (X | T) ; Delay_1\nproc X = {turn}\nsystem S = A | B\nperiod S\n");
    says(&on, "A reads port p, which nobody writes", &[NOTHING]);
    let held =
        format!("{ticks}proc A = {turn} ; A\nproc C = In_never<z> ; Out_{{r,1}} ; C\nsystem S = A | B | C\nperiod S\n");
    says(&held, "unmatched communication: A reads port p and waits for ever: nobody writes it", &[NOTHING]);
}

#[test]
fn a_race_and_a_run_that_is_given_up_are_the_reason() {
    let sends = "proc T = (Out_{r,1} # (Delay_1 ; Delay_1)) ; Delay_1 ; T\n";
    let race = "proc A = (In_q<x> | In_q<y>) ; Delay_3 ; A\nproc B = Out_{q,1} ; Delay_1 ; B\n";
    let script = format!("{sends}{race}system S = A | B | T\nperiod S\n");
    says(&script, "A and A compete for one communication on port q", &[FOR_EVER]);
    says(&script, "T writes port r, which nobody reads", &[FOR_EVER]);
}
