//! The parser: the paper's own equations, errors with their places, and hostile input.

use std::path::{Path, PathBuf};

use pars::diagnostic::{Source, render_all};
use pars::lexer::lex;
use pars::lower::{Environment, Lowered};
use pars::parser::{parse, parse_input};
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
    let text = include_str!("cases/paper/equations.pars");
    let parsed = parse(text);
    let source = Source::new("equations.pars", text);
    let shown = render_all(&parsed.diagnostics, &source, false);
    assert!(parsed.diagnostics.is_empty(), "{shown}");
    assert!(parsed.items.len() > 40);
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
    let cases = ["operator", "probability", "missions", "paper"].map(|folder| format!("tests/cases/{folder}"));
    let folders = [("rules", "rules"), ("examples", "pars"), ("tests/syntax", "pars"), (".", "pars")];
    let folders = folders.into_iter().chain(cases.iter().map(|folder| (folder.as_str(), "pars")));
    let kinds = |text: &str| lex(text).tokens.iter().map(|token| token.kind).collect::<Vec<_>>();
    for path in folders.flat_map(|(folder, extension)| files(folder, extension)) {
        let text = std::fs::read_to_string(&path).unwrap();
        let once = format(&text).unwrap();
        assert!(parse(&once).diagnostics.is_empty(), "{}", path.display());
        assert_eq!(kinds(&text), kinds(&once), "{}", path.display());
        assert_eq!(once, format(&once).unwrap(), "{}", path.display());
    }
}

/// The message of the first error.
fn first_error(text: &str) -> String {
    parse(text).diagnostics.first().map_or(String::new(), |diagnostic| diagnostic.message.clone())
}

#[test]
fn errors_say_what_was_expected() {
    for (text, expected) in [
        ("proc A = Delay_1 # Idle ; Stop", "`#` and `;` stand side by side without brackets"),
        ("proc a_x = Stop", "expected the name of a process, found `a_x`"),
        ("param natural n", "the sort of a parameter stands behind it"),
        ("simplify Delay_1/10", "expected the end of the parameter, found `/`"),
        ("simplify Delay_{1", "the text ends where an operator, `,` or `}` should follow"),
        ("simplify (Stop", "the text ends where an operator or `)` should follow"),
        ("prov A = A", "expected an item, found `prov`"),
        ("simplify Stop ≅ Idle", "the language does not use the sign `≅`"),
        ("simplify Stop)", "expected an operator or the next item, found `)`"),
        ("simplify Delay_{?P}", "`?P` stands for a process, but a value is needed here"),
        ("prove ?P = ?P when never_abort(?P)", "there is no condition `never_abort`"),
        ("prove A | B satisfies G", "only a system with a name can satisfy a property"),
        ("import \"x", "this text in quotes does not end on its line"),
        ("param 0 < a < 1", "expected `,` or the next item, found `<`"),
    ] {
        assert_eq!(first_error(text), expected, "{text}");
    }
}

#[test]
fn every_item_with_an_error_is_reported() {
    let parsed = parse("proc A = \nproc B = Stop\nproc C = ; Stop\nparam t >\nsimplify B");
    assert_eq!((parsed.items.len(), parsed.diagnostics.len()), (2, 3));
}

#[test]
fn what_may_still_be_completed_is_told_from_what_is_wrong() {
    for text in
        ["proc A =", "Stop ;", "(Stop | ", "proc A_{a,", "prove A = B by {", "prove A", "Delay_{|x", "law a \"b\""]
    {
        assert!(parse_input(text).incomplete, "{text}");
    }
    for text in ["", "Stop", "Stop )", "proc A = = ", "prove A = A by x", "(Stop ; ] "] {
        assert!(!parse_input(text).incomplete, "{text}");
    }
}

#[test]
fn unicode_is_read_as_ascii() {
    let mut environment = with_laws();
    let both = "param a ≤ 1, b ≥ 2, a ≠ b, τ > 0
        simplify (Delay_{2·τ−1} ∥ In_p⟨r⟩) ↓{At}
        simplify (Delay_{2*τ-1} | In_p<r>) to {At}";
    let lowered = take(&mut environment, "unicode", both);
    let [_, Lowered::Simplify(one), Lowered::Simplify(other)] = lowered.as_slice() else { panic!() };
    assert_eq!(one, other);
    let laid_out = format(both).unwrap();
    assert!(laid_out.contains("a <= 1, b >= 2, a != b") && laid_out.contains("Delay_{2*τ-1} | In_p<r>) to {At}"));
}

#[test]
fn products_percentages_and_assumptions_are_read_as_the_paper_prints_them() {
    let mut environment = with_laws();
    let text = "param t > 0\nsimplify Delay_{10t+2t^2}\nsimplify Delay_{10*t+2*t^2}\nsimplify Delay_{90 %}";
    let lowered = take(&mut environment, "printed", text);
    let [_, Lowered::Simplify(one), Lowered::Simplify(other), Lowered::Simplify(part)] = lowered.as_slice() else {
        panic!()
    };
    assert_eq!((one, part.to_string()), (other, "Delay_{9/10}".to_string()));
    assert!(format(text).unwrap().contains("Delay_{10t+2t^2}"));
    assert!(first_error("param t\nsimplify Delay_{1/2t}").contains("can be read in two ways"));
    let text = "property G = (Odo_p | Obs_{p+q}) ; G where q > 1\n";
    assert_eq!(format(text).unwrap(), text);
}

#[test]
fn hostile_input_is_answered() {
    let deep = |open: &str, inside: &str, close: &str| {
        format!("simplify {}{inside}{}", open.repeat(100_000), close.repeat(100_000))
    };
    assert!(first_error(&deep("(", "Stop", ")")).contains("nested deeper than 200"));
    assert!(first_error(&deep("try(", "Stop", ")")).contains("nested deeper than 200"));
    assert!(first_error(&deep("new c. ", "Stop", "")).contains("nested deeper than 200"));
    assert!(first_error(&deep("Stop else ", "Stop", "")).contains("nested deeper than 200"));
    assert!(first_error(&format!("simplify Stop{}", "^2".repeat(100_000))).contains("nested deeper than 200"));
    assert!(first_error(&format!("simplify Delay_{{{}", "(".repeat(100_000))).contains("nested deeper than 200"));
    assert!(first_error(&format!("simplify Delay_{{1{}", "^1".repeat(100_000))).contains("nested deeper than 200"));
    assert!(first_error(&format!("simplify Delay_{}", "7".repeat(200_000))).contains("200000 digits"));
    let many = parse(&"proc = ".repeat(100_000));
    assert!(many.diagnostics.len() <= 100);
    assert!(first_error(&format!("simplify Delay_{{{}1}}", "-".repeat(100_001))).is_empty());
    let mut environment = with_laws();
    let long = format!("simplify Stop{}", " ; Delay_1".repeat(100_000));
    assert!(
        matches!(take(&mut environment, "long", &long).as_slice(), [Lowered::Simplify(term)] if term.size() == 100_002)
    );
    let wide = format!("simplify Delay_{{0{}}}", " + 1".repeat(100_000));
    assert!(
        matches!(take(&mut environment, "wide", &wide).as_slice(), [Lowered::Simplify(term)] if term.to_string() == "Delay_100000")
    );
}

#[test]
fn ten_megabytes_are_read_in_one_go() {
    let text = "proc MoveTo_g = In_p<r> ; Neq_{r,g} ; Out_{v,(g-r)/2} ; MoveTo_g // as in the paper\n".repeat(120_000);
    let start = std::time::Instant::now();
    let parsed = parse(&text);
    assert_eq!(parsed.items.len(), 120_000);
    println!("{:.1} MB/s", text.len() as f64 / 1e6 / start.elapsed().as_secs_f64());
    assert!(start.elapsed().as_secs() < 30);
}

#[test]
fn bytes_that_are_no_text_are_refused_with_their_place() {
    let error = Source::from_bytes("bad.pars", b"param t\nproc \xff".to_vec()).unwrap_err();
    assert!(error.1.message.contains("byte 13 (0xff)"));
    assert!(error.1.render(&error.0, false).contains("bad.pars:2:6"));
}
