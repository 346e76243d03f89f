//! Derivations in LaTeX: well formed, with the laws and with only what changed underlined.

use std::process::Command;

use pars::latex::{escaped, process};
use pars::lower::Environment;
use pars::parser::{parse, parse_term};

/// A process as it is written, in mathematics.
fn set(text: &str) -> String {
    let declarations = "observer At(r)\nproc T_u = Delay_1 ; T_u\nparam D : distribution, g, φ1";
    let mut environment = Environment::new();
    environment.declare(&parse(declarations).items, declarations);
    process(&environment.part(&parse_term(text).expect("a term")).expect("a meaning"))
}

#[test]
fn each_operator_has_its_form() {
    assert_eq!(set("Delay_{1/2} ; Stop"), "\\mathsf{Delay}_{1/2}\\mathbin{;}\\mathsf{Stop}");
    assert_eq!(
        set("In_c<y> | Out_{c,y*2}"),
        "\\mathsf{In}_{c}\\langle y\\rangle \\parallel \\mathsf{Out}_{c,2\\cdot y}"
    );
    assert_eq!(set("Idle # At_g"), "\\mathsf{Idle}\\mathbin{\\#}\\mathsf{At}_{g}");
    assert_eq!(set("loop(Delay_1)"), "\\mathsf{loop}(\\mathsf{Delay}_{1})");
    assert_eq!(set("?P^{i<?n}"), "P^{i<n}");
    assert_eq!(set("(Delay_1)^2"), "\\mathsf{Delay}_{1}^{2}");
    assert_eq!(set("Delay_{x^-2}"), "\\mathsf{Delay}_{1/x^{2}}");
    assert_eq!(set("new c. Stop"), "\\mathsf{new}\\,c.\\,\\mathsf{Stop}");
    assert_eq!(set("At_g to {At}"), "\\mathsf{At}_{g}\\mathbin{\\mathsf{to}}\\{\\mathsf{At}\\}");
    assert_eq!(set("Delay_φ1"), "\\mathsf{Delay}_{\\mathit{\\varphi 1}}");
    assert_eq!(set("Abort else Stop"), "\\mathsf{try}(\\mathsf{Abort})");
    assert_eq!(set("?P[y := 1]"), "P[y\\mathrel{:=}1]");
}

#[test]
fn letters_that_mean_something_to_tex_are_escaped() {
    assert_eq!(
        escaped("a_b # {50%} & $ ~ ^ \\ <α>"),
        "a\\_b \\# \\{50\\%\\} \\& \\$ \\textasciitilde{} \\textasciicircum{} \\textbackslash{} \\textless{}$\\alpha$\\textgreater{}"
    );
}

/// Every bracket that is opened is closed, `\{` and `\}` aside.
fn balanced(text: &str) -> bool {
    let plain = text.replace("\\{", "").replace("\\}", "");
    let mut depth = 0i64;
    for letter in plain.chars() {
        depth += i64::from(letter == '{') - i64::from(letter == '}');
        if depth < 0 {
            return false;
        }
    }
    depth == 0
}

#[test]
fn every_proof_is_written_as_a_document() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = Command::new(env!("CARGO_BIN_EXE_pars"))
        .args(["run", "tests/cases/laws/hold.pars", "examples/first.pars", "--latex"])
        .arg(folder.path())
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("pars runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let mut seen = 0;
    for entry in std::fs::read_dir(folder.path()).expect("documents").flatten() {
        let text = std::fs::read_to_string(entry.path()).expect("a document");
        let path = entry.path().display().to_string();
        let (_, rest) = text.split_once("\\begin{align*}\n").expect("a derivation");
        let (lines, _) = rest.split_once("\n\\end{align*}").expect("its end");
        for line in lines.split(" \\\\\n").skip(1) {
            seen += 1;
            assert!(balanced(line), "{path}: {line}");
            assert!(line.starts_with("  ={} & ") || line.starts_with("  \\le{} & "), "{path}: {line}");
            assert!(line.contains(" && \\text{\\small "), "{path}: {line}");
            assert!(line.contains("\\underline{"), "{path}: nothing is marked in {line}");
            assert!(!line.contains("\\texttt"), "{path}: {line}");
        }
        assert!(text.ends_with("\\end{document}\n"), "{path}");
    }
    assert!(seen > 200, "{seen}");
}
