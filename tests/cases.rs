//! Every `.pars` file under `examples/` and `tests/cases/` is a test: its expectations must hold.

use std::path::{Path, PathBuf};
use std::process::Command;

use libtest_mimic::{Arguments, Failed, Trial};

fn scripts(folder: &Path, found: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    paths.sort();
    for path in paths {
        if path.is_dir() && path.file_name().is_some_and(|name| name != "error") {
            scripts(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "pars") {
            found.push(path);
        }
    }
}

fn holds(path: &Path) -> Result<(), Failed> {
    let run = Command::new(env!("CARGO_BIN_EXE_pars")).arg("run").arg(path).output()?;
    if run.status.success() {
        return Ok(());
    }
    let (out, err) = (String::from_utf8_lossy(&run.stdout), String::from_utf8_lossy(&run.stderr));
    Err(Failed::from(format!("{}\n{out}\n{err}", run.status)))
}

fn main() {
    let arguments = Arguments::from_args();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut found = Vec::new();
    scripts(&root.join("examples"), &mut found);
    scripts(&root.join("tests/cases"), &mut found);
    assert!(found.len() > 5, "the scripts are not where they should be");
    let trials = found
        .into_iter()
        .map(|path| {
            let name = path.strip_prefix(root).unwrap_or(&path).display().to_string();
            Trial::test(name, move || holds(&path))
        })
        .collect();
    libtest_mimic::run(&arguments, trials).exit();
}
