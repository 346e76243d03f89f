//! The parser: the paper's own equations, errors with their places, and hostile input.

use pars::parser::{parse, parse_input, parse_term};

#[test]
fn paper_equations_parse() {
    let text = include_str!("cases/syntax/paper.pars");
    let parsed = parse(text);
    let source = pars::diagnostic::Source::new("paper.pars", text);
    let shown = pars::diagnostic::render_all(&parsed.diagnostics, &source, false);
    assert!(parsed.diagnostics.is_empty(), "{shown}");
    assert_eq!(parsed.items.len(), 23);
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
        let source = pars::diagnostic::Source::new("x.pars", text);
        println!("{}{}", pars::diagnostic::render_all(&parsed.diagnostics, &source, false), parsed.incomplete);
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
