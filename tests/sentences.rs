//! What is said where something is not known, ends, or is too long to read.

use std::process::{Command, Output};

fn pars(command: &str, script: &str) -> Output {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("mission.pars"), script).expect("written");
    let program = env!("CARGO_BIN_EXE_pars");
    Command::new(program).args([command, "mission.pars"]).current_dir(folder.path()).output().expect("it runs")
}

fn told(script: &str) -> String {
    String::from_utf8_lossy(&pars("run", script).stdout).into_owned()
}

const WORLD: &str = "observer At(r), Done\nproc World_r = (Delay_1 # Look_r # At_r) ; In_w<u> ; World_{r+u}\n\
    proc Look_r = Out_{l,r} ; Look_r\nproc Go_g = In_l<r> ; Neq_{r,g} ; Out_{w,g-r} ; Go_g\n";

#[test]
fn an_assumption_that_is_named_tells() {
    let mission = "system Sys = World_0 | ((Go_2 ; Go_0)^k ; Done)\nproperty P = Delay_{?s} ; Done\n\
        prove Sys satisfies P\n";
    let open = told(&format!("{WORLD}param k : natural\n{mission}"));
    assert!(open.contains("could not prove") && open.contains("an assumption such as `param k > 0` tells"), "{open}");
    assert_eq!(open.matches("it must be known whether").count(), 1, "each question once: {open}");
    // And so it does.
    let proved = told(&format!("{WORLD}param k : natural, k > 0\n{mission}"));
    assert!(proved.contains("proved: Sys satisfies P") && proved.contains("with ?s = 2*k"), "{proved}");
    assert!(!proved.contains("on trust"), "{proved}");
}

#[test]
fn a_run_that_ends_has_no_period_at_the_shell_either() {
    let script = |goals: &str| format!("{WORLD}proc Mission = {goals}\nsystem Sys = World_0 | Mission\n");
    let count = "proc Count_n = Gtr_{n,0} ; Delay_1 ; Count_{n-1}\nsystem Sys = Count_3\n";
    let ended = pars("period", count);
    let text = String::from_utf8_lossy(&ended.stdout).into_owned();
    assert_eq!((ended.status.code(), text.contains("no period: the run ends")), (Some(1), true), "{text}");
    assert_eq!(pars("period", &script("Go_2 ; Go_0 ; Mission")).status.code(), Some(0));
    assert_eq!(pars("period", &script("Go_2 ; Go_0")).status.code(), Some(1));
}

#[test]
fn nothing_stands_between_commas_or_at_an_end() {
    let script = "observer T(x)\nproc Src = Out_{a,0} ; In_b<z> ; (Delay_1 # T_z) ; Src\n\
        proc N = In_a<x> ; (Delay_1 # T_x) ; Out_{b,x+7} ; N\nsystem S = Src | N\nprove S always x <= 7 when T_x\n";
    let told = told(script);
    assert!(told.contains("T is sensed, and nothing else that is shown moves by what is read"), "{told}");
    assert!(told.lines().all(|line| !line.ends_with("moves ")), "{told}");
}

#[test]
fn long_vectors_are_rounded_where_they_are_read() {
    let script = "observer At(r)\nproc World_r = (Delay_1 # Look_r # At_r) ; In_w<u> ; World_{r+u}\n\
        proc Look_r = Out_{l,r} ; Look_r\nproc Go_g = In_l<r> ; Gtr_{norm(g-r),1/10} ; Out_{w,(g-r)/20} ; Go_g\n\
        proc Tour = Go_{(10,2)} ; Go_{(0,0)} ; Tour\nsystem Sys = World_{(0,0)} | Tour\n\
        criteria C for Sys { goals At_{(10,2)}, At_{(0,0)} radius 1/5 round within 16 }\n";
    let told = told(script);
    let line = told.lines().find(|line| line.contains("commanded by Tour on port w")).expect("who commanded");
    assert!(line.contains("(rounded)") && line.len() < 120, "{line}");
}
