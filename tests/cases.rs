//! Every `.pars` file under `examples` and `tests/cases` is a test: what it expects must come so.
//!
//! A file under `tests/cases/error` ends in lines that begin with `//|`: what it must be answered, on standard error.
//! `PARS_BLESS=1 cargo test --test cases` writes them anew; the review is the difference.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use libtest_mimic::{Arguments, Failed, Trial};

fn main() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = Vec::new();
    for folder in ["examples", "tests/cases"] {
        collect(&root.join(folder), &mut files);
    }
    files.sort();
    let trials = files.into_iter().map(|file| {
        let name = file.strip_prefix(root).unwrap_or(&file).display().to_string();
        let error = name.starts_with("tests/cases/error/");
        let run = move |name: &str| if error { refused(name) } else { runs(name) };
        Trial::test(name.clone(), move || run(&name))
    });
    libtest_mimic::run(&Arguments::from_args(), trials.collect()).exit();
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            collect(&path, files);
        } else if path.extension().is_some_and(|extension| extension == "pars") {
            files.push(path);
        }
    }
}

fn pars(file: &str) -> Result<Output, Failed> {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pars"));
    let output = command.args(["run", file, "--color", "never"]).current_dir(env!("CARGO_MANIFEST_DIR")).output();
    output.map_err(|error| error.to_string().into())
}

/// Every claim comes as the file expects.
fn runs(file: &str) -> Result<(), Failed> {
    let output = pars(file)?;
    if output.status.success() {
        return Ok(());
    }
    let (out, errors) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    Err(format!("{}\n{errors}\n{out}", output.status).into())
}

/// The file is answered with the errors that it holds.
fn refused(file: &str) -> Result<(), Failed> {
    let output = pars(file)?;
    let found = String::from_utf8_lossy(&output.stderr).trim_end().to_string();
    if output.status.code() != Some(3) {
        return Err(format!("{}, not exit code 3\n{found}", output.status).into());
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
    let text = std::fs::read_to_string(&path)?;
    let (input, wanted): (Vec<&str>, Vec<&str>) = text.lines().partition(|line| !line.starts_with("//|"));
    let wanted: Vec<&str> =
        wanted.into_iter().map(|line| line.strip_prefix("//| ").unwrap_or(&line["//|".len()..])).collect();
    let wanted = wanted.join("\n");
    if wanted == found {
        return Ok(());
    }
    if std::env::var_os("PARS_BLESS").is_some() {
        let lines = found.lines().map(|line| format!("//| {line}").trim_end().to_string());
        let all: Vec<String> = input.iter().map(|line| (*line).to_string()).chain(lines).collect();
        std::fs::write(&path, all.join("\n") + "\n")?;
        return Ok(());
    }
    Err(format!("expected:\n{wanted}\nfound:\n{found}").into())
}
