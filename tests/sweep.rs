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

#[test]
fn a_report_has_a_table_of_the_points_and_all_that_stands_in_the_way() {
    let folder = tempfile::tempdir().expect("a folder");
    let more = "criteria Both for Sys { goals At_1 round within 1/2 leg to At_1 within 1/3 }\n";
    std::fs::write(folder.path().join("mission.pars"), script(more, "")).expect("written");
    assert_eq!(pars(folder.path(), &["report", "mission.pars"]).status.code(), Some(1));
    let page = std::fs::read_to_string(folder.path().join("mission.md")).expect("a page");
    let lines: Vec<&str> = page.lines().collect();
    // A round of k: `Fast` is met up to 3.
    for (k, verdict) in [(1, "yes"), (2, "yes"), (3, "yes"), (4, "no"), (5, "no"), (7, "no")] {
        let row = lines.iter().find(|line| line.starts_with(&format!("| {k} | ")));
        assert!(row.is_some_and(|row| row.contains(&format!("| {verdict} |"))), "k = {k}: {page}");
    }
    let limits = page.split("### What limits it").nth(1).and_then(|rest| rest.split("###").next()).expect("limits");
    for criterion in ["round within 1/2", "leg to At_1 within 1/3"] {
        assert!(limits.contains(criterion), "{criterion}: {limits}");
    }
    let html = std::fs::read_to_string(folder.path().join("mission.html")).expect("a page");
    assert_eq!(html.matches("<tr>").count(), html.matches("</tr>").count());
    assert!(html.contains("<td>7</td>"), "{html}");
}
