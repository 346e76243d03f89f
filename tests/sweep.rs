//! What is expected behind a sweep counts for `pars sweep` as it does for `pars run`.

use std::path::Path;
use std::process::{Command, Output};

fn pars(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_pars")).args(arguments).current_dir(folder).output().expect("it runs")
}

/// Two sweeps, with what is expected of each.
fn script(first: &str, second: &str) -> String {
    format!(
        "observer At(x)\nparam k = 1\nproc Go = (Delay_k # At_0) ; (Delay_1 # At_1)\nsystem Sys = Go | Delay_9\n\
         criteria Fast for Sys {{ goals At_1 round within 3 }}\n\
         sweep k in 1 .. 5 step 1 {{ Fast }}\n{first}\nsweep k in [1, 7] {{ Fast }}\n{second}\n"
    )
}

fn code(first: &str, second: &str) -> (Option<i32>, Option<i32>, String) {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("mission.pars"), script(first, second)).expect("written");
    let (swept, run) = (pars(folder.path(), &["sweep", "mission.pars"]), pars(folder.path(), &["run", "mission.pars"]));
    let told = String::from_utf8_lossy(&swept.stdout).into_owned();
    assert!(folder.path().join("mission-2.csv").exists(), "both are swept whatever is expected: {told}");
    (swept.status.code(), run.status.code(), told)
}

#[test]
fn an_expectation_behind_a_sweep_is_looked_at() {
    // The goal is reached after k: in time for k = 1, 2, 3.
    let right = "expect feasible = 3, infeasible = 2, open = 0";
    let (swept, run, told) = code(right, "expect feasible = 1");
    assert_eq!((swept, run), (Some(0), Some(0)), "{told}");
    assert!(!told.contains("but expected"), "{told}");
    for (first, second) in [("expect feasible = 4", ""), ("", "expect feasible = 2"), (right, "expect proved")] {
        let (swept, run, told) = code(first, second);
        assert_eq!((swept, run), (Some(1), Some(1)), "{told}");
        assert_eq!(told.matches("but expected").count(), 1, "{told}");
    }
    // Several may stand behind one.
    let (swept, _, told) = code("expect feasible = 3\nexpect open = 1", "");
    assert_eq!(swept, Some(1), "{told}");
    assert!(told.contains("but expected open = 1"), "{told}");
}
