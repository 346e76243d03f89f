//! The parser: the paper's own equations, errors with their places, and hostile input.

use std::path::{Path, PathBuf};

use pars::diagnostic::{Source, render_all};
use pars::lower::{Environment, Lowered};
use pars::parser::{parse, parse_input, parse_term};
use pars::printer::format;

/// What a text comes to in an environment; panics with the rendered errors.
fn take(environment: &mut Environment, name: &str, text: &str) -> Vec<Lowered> {
    let source = Source::new(name, text);
    let parsed = parse(text);
    assert!(parsed.diagnostics.is_empty(), "{}", render_all(&parsed.diagnostics, &source, false));
    let outcomes = environment.declare(&parsed.items, text);
    let each = outcomes.into_iter().map(|outcome| match outcome {
        Ok(lowered) => lowered,
        Err(errors) => panic!("{}", render_all(&errors, &source, false)),
    });
    each.collect()
}

fn with_laws() -> Environment {
    let mut environment = Environment::new();
    for path in files("rules", "rules") {
        take(&mut environment, &path.display().to_string(), &std::fs::read_to_string(&path).unwrap());
    }
    take(&mut environment, "prelude", "observer At(r)");
    environment
}

fn files(folder: &str, extension: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut paths: Vec<_> = entries.filter(|path| path.extension().is_some_and(|found| found == extension)).collect();
    paths.sort();
    paths
}

#[test]
fn paper_equations_parse() {
    let text = include_str!("cases/syntax/paper.pars");
    let parsed = parse(text);
    let source = Source::new("paper.pars", text);
    let shown = render_all(&parsed.diagnostics, &source, false);
    assert!(parsed.diagnostics.is_empty(), "{shown}");
    assert_eq!(parsed.items.len(), 23);
}

#[test]
fn examples_are_well_formed() {
    for path in files("examples", "pars") {
        let text = std::fs::read_to_string(&path).unwrap();
        take(&mut with_laws(), &path.display().to_string(), &text);
    }
}

#[test]
fn laws_print_and_parse_back() {
    let environment = with_laws();
    assert!(environment.laws.iter().count() > 50);
    for law in environment.laws.iter() {
        let mut again = Environment::new();
        let lowered = take(&mut again, law.name.as_str(), &law.to_string());
        assert!(matches!(lowered.as_slice(), [Lowered::Law(back)] if *back == **law), "{law}");
    }
}

#[test]
fn layout_is_stable() {
    let folders = [("rules", "rules"), ("examples", "pars"), ("tests/cases/syntax", "pars"), (".", "pars")];
    for path in folders.into_iter().flat_map(|(folder, extension)| files(folder, extension)) {
        let text = std::fs::read_to_string(&path).unwrap();
        let once = format(&text).unwrap();
        assert_eq!(once, format(&once).unwrap(), "{}", path.display());
        println!("{once}");
    }
}

#[test]
fn show_errors() {
    for text in [
        "proc A = Delay_1 # Idle ; Stop\nproc b_x = Stop\nparam t > 0, natural n\nprove A = A by sum-two, x {",
        "simplify Delay_1/10",
        "proc A = (Delay_1 ; ",
        "proc A = Out_v,s(x)\nlaw a-b \"X\"\n paper foo ; bar\n when never_abort(?P), ?a >= 0\n ?P = ?P",
        "prov A = A",
        "simplify ∥ ≈ \"x",
        "proc A_a<x>= Set_a<x> ; Stop)",
        "simplify Delay_{?P} param x",
    ] {
        let parsed = parse(text);
        let source = Source::new("x.pars", text);
        println!("{}{}", render_all(&parsed.diagnostics, &source, false), parsed.incomplete);
    }
}

#[test]
fn hostile() {
    let deep = format!("simplify {}", "(".repeat(100_000));
    let parsed = parse(&deep);
    assert!(parsed.diagnostics[0].message.contains("deeper than 200"));
    let long = format!("simplify Stop{}", " ; Stop".repeat(100_000));
    assert!(parse(&long).diagnostics.is_empty());
    let number = format!("simplify Delay_{}", "7".repeat(200_000));
    assert!(parse(&number).diagnostics[0].message.contains("200000 digits"));
    assert!(parse_input("Stop ;").incomplete && parse_term("Stop").is_ok());
}
