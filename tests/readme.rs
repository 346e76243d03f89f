//! What the README shows is what the program prints.

use std::path::Path;
use std::process::Command;

#[test]
fn the_session_in_the_readme_is_real() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let readme = std::fs::read_to_string(root.join("README.md")).expect("README.md");
    let block = |kind: &str| {
        let start = readme.find(&format!("```{kind}\n")).expect("a block") + kind.len() + 4;
        let end = readme[start..].find("```").expect("its end") + start;
        readme[start..end].to_string()
    };
    let script = std::fs::read_to_string(root.join("examples/first.pars")).expect("the script");
    assert_eq!(block("pars"), script);
    let run = Command::new(env!("CARGO_BIN_EXE_pars"))
        .args(["run", "examples/first.pars"])
        .current_dir(root)
        .output()
        .expect("pars runs");
    assert_eq!(block("text"), String::from_utf8_lossy(&run.stdout));
    assert!(run.status.success());
}

#[test]
fn the_main_job_proves_the_mission_of_the_paper() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let run = Command::new(env!("CARGO_BIN_EXE_pars"))
        .args(["run", "examples/back_and_forth.pars"])
        .current_dir(root)
        .output()
        .expect("pars runs");
    let text = String::from_utf8_lossy(&run.stdout);
    assert!(run.status.success(), "{text}");
    for part in ["proved: Sys satisfies Goal", "?t1 = t, ?t2 = t, ?t3 = 0", "by forget"] {
        assert!(text.contains(part), "{part} is missing in {text}");
    }
    assert!(!text.contains("on trust:"), "{text}");
}
