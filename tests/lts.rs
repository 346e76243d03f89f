//! `pars lts` and `pars compare`: formats, exit codes, and files that nobody should have to read.

use std::io::Write as _;
use std::process::{Command, Output, Stdio};

use serde_json::Value as Json;

fn pars(arguments: &[&str], input: &[u8]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pars"));
    command.args(arguments).args(["--color", "never"]).current_dir(env!("CARGO_MANIFEST_DIR"));
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("pars starts");
    // It may refuse before it has read everything.
    let _ = child.stdin.take().expect("an input").write_all(input);
    child.wait_with_output().expect("pars ends")
}

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn file(name: &str) -> String {
    format!("tests/cases/systems/{name}.aut")
}

#[test]
fn files_are_compared_with_an_exit_code() {
    let run = |left: &str, right: &str, relation: &str| {
        pars(&["compare", &file(left), &file(right), "--as", relation], b"").status.code()
    };
    assert_eq!(run("a-tau-b", "a-b", "weak"), Some(0));
    assert_eq!(run("a-tau-b", "a-b", "strong"), Some(1));
    assert_eq!(run("a-tau-b", "a-b", "nonsense"), Some(2));
    assert_eq!(run("a-tau-b", "no-such-file", "weak"), Some(3));
    let output = pars(&["compare", &file("choice-late"), &file("choice-early"), "--json"], b"");
    let json: Json = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!((json["verdict"].as_str(), json["run"].as_array().map(Vec::len)), (Some("no"), Some(1)));
    assert!(json["formula"].as_str().is_some_and(|formula| formula.starts_with("[a] <")));
}

#[test]
fn a_process_is_written_in_every_format_and_read_back() {
    let script = "examples/back_and_forth.pars";
    let source = "param t = 1\nproc P = loop(Delay_t ; (Out_{c,1} # At_0))\nsystem S = P | In_d<y>\n";
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("p.pars");
    std::fs::write(&path, source).expect("a script");
    let path = path.to_str().expect("a name");
    let aut = text(&pars(&["lts", path, "--format", "aut"], b""));
    assert!(aut.starts_with("des (0, "), "{aut}");
    let written = folder.path().join("p.aut");
    std::fs::write(&written, &aut).expect("a file");
    let written = written.to_str().expect("a name");
    let again = text(&pars(&["lts", written, "--format", "aut"], b""));
    assert_eq!((again.lines().count(), again.lines().next()), (aut.lines().count(), aut.lines().next()));
    assert_eq!(pars(&["compare", written, "-"], aut.as_bytes()).status.code(), Some(0));
    let json: Json = serde_json::from_str(&text(&pars(&["lts", path, "P", "--format", "json"], b""))).expect("JSON");
    assert!(json["states"].as_array().is_some_and(|states| states.len() == 2), "{json}");
    let dot = text(&pars(&["lts", path, "P", "--format", "dot"], b""));
    assert!(dot.starts_with("digraph") && dot.contains("wait 1") && dot.trim_end().ends_with('}'), "{dot}");
    let svg = text(&pars(&["lts", path, "P ; Abort", "--format", "svg"], b""));
    assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>") && svg.contains("At_0"), "{svg}");
    let small = text(&pars(&["lts", path, "(P | P | P) to {At}", "--minimise"], b""));
    assert!(small.contains("states,"), "{small}");
    // Parameters without a value get one, which is said; a misspelt process has no transition system.
    let sampled = pars(&["lts", script], b"");
    assert_eq!(sampled.status.code(), Some(0));
    assert!(sampled.stderr.starts_with(b"take a = "), "{sampled:?}");
    assert_eq!(pars(&["lts", path, "Q"], b"").status.code(), Some(3));
    assert_eq!(pars(&["lts", path, "P ;"], b"").status.code(), Some(3));
    let cut = pars(&["lts", path, "P | P", "--bound", "2"], b"");
    assert_eq!(cut.status.code(), Some(4));
    assert!(text(&cut).contains("the bound of 2 states was hit"), "{}", text(&cut));
}

#[test]
fn damaged_files_are_refused_or_read_but_never_break_it() {
    let good = "des (0, 4, 3)\n(0, \"a\", 1)\n(1, tau, 2)\n(2, \"b \\\" c\", 0)\n(0, send(1,2), 2)\n".as_bytes();
    let mut seed = 4_711u64;
    for round in 0..20_000 {
        let mut bytes = good.to_vec();
        for _ in 0..=round % 4 {
            if bytes.is_empty() {
                break;
            }
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let (place, byte) = ((seed >> 33) as usize % bytes.len(), (seed >> 20) as u8);
            match seed >> 62 {
                0 => bytes[place] = byte,
                1 => drop(bytes.remove(place)),
                2 => bytes.insert(place, byte),
                _ => bytes.truncate(place.max(1)),
            }
        }
        let text = String::from_utf8_lossy(&bytes);
        match pars::transition_system::aut::read(&text) {
            Ok(system) => {
                let again = pars::transition_system::aut::write(&system);
                assert!(pars::transition_system::aut::read(&again).is_ok(), "{text:?}");
            }
            Err(wrong) => assert!(wrong.line > 0 && wrong.column > 0 && wrong.offset <= text.len(), "{text:?}"),
        }
    }
    for input in [&b"\xff\xfe"[..], b"", b"des (0, 1, 2)", b"\0\0\0"] {
        let output = pars(&["lts", "-"], input);
        assert_eq!(output.status.code(), Some(3), "{input:?}");
    }
}

#[test]
fn parameters_without_a_value_are_given_one_or_get_a_small_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("p.pars");
    std::fs::write(&path, "param t > 1, n < t\nproc P = Delay_t ; Out_{c,n}\n").expect("a file");
    let path = path.to_str().expect("a path");
    let given = pars(&["lts", path, "P", "--with", "t = 7, n = 5", "--format", "aut"], b"");
    assert!(text(&given).contains("\"c!5\"") && given.stderr.is_empty(), "{given:?}");
    let chosen = pars(&["lts", path, "P"], b"");
    let said = String::from_utf8_lossy(&chosen.stderr).into_owned();
    assert!(chosen.status.success() && said.starts_with("take n = ") && said.contains("t = 2"), "{said}");
    let wrong = pars(&["lts", path, "P", "--with", "t = 1"], b"");
    assert_eq!(wrong.status.code(), Some(3));
    assert!(String::from_utf8_lossy(&wrong.stderr).contains("break what is assumed"), "{wrong:?}");
}

#[test]
fn a_text_with_many_errors_shows_the_first_hundred() {
    let source = "prove Foo = Stop\n".repeat(3_000);
    let output = pars(&["run", "-"], source.as_bytes());
    let errors = String::from_utf8_lossy(&output.stderr).matches("error[P0314]").count();
    assert_eq!((output.status.code(), errors), (Some(3), 100));
    assert!(text(&output).contains("2900 more are not shown"), "{}", text(&output));
    // An error that stands behind many warnings is shown.
    let source = "proc P = Delay_1 ; Abort ; Stop\n".repeat(200) + "prove Foo = Stop\n";
    assert_eq!(pars(&["run", "-"], source.as_bytes()).status.code(), Some(3));
}

#[test]
fn memory_that_is_not_enough_is_an_answer() {
    let folder = tempfile::tempdir().expect("a folder");
    let chain = |name: &str, states: usize| {
        let steps: String = (1..states).map(|state| format!("({}, \"a\", {state})\n", state - 1)).collect();
        let path = folder.path().join(name);
        std::fs::write(&path, format!("des (0, {}, {states})\n{steps}", states - 1)).expect("a file");
        path.display().to_string()
    };
    let (long, longer) = (chain("long.aut", 20_000), chain("longer.aut", 20_001));
    // The file alone, then its partition, then the pair, then the evidence.
    for (arguments, word) in [
        (&["lts", &long, "--memory", "0"][..], "are not enough for `"),
        (&["lts", &long, "--memory", "2", "--minimise"], "to minimise 20000 states"),
        (&["compare", &long, &long, "--memory", "0"], "unknown: 0 MiB"),
        (&["compare", &long, &long, "--memory", "4"], "unknown: 4 MiB of memory are not enough for 40000 states"),
        (&["compare", &long, &long, "--memory", "12", "--as", "branching"], "unknown: 12 MiB of memory"),
        (&["compare", &long, &longer, "--memory", "15"], "a difference was found, but no run that shows it in 15 MiB"),
    ] {
        let output = pars(arguments, b"");
        let all = text(&output) + &String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(4) && all.contains(word), "{arguments:?}: {all}");
    }
    let output = pars(&["compare", &long, &longer, "--memory", "1", "--json"], b"");
    let json: Json = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!((json["verdict"].as_str(), output.status.code()), (Some("unknown"), Some(4)));
    assert_eq!(pars(&["compare", &long, &long, "--memory", "10"], b"").status.code(), Some(0));
    assert_eq!(pars(&["compare", &long, &longer, "--memory", "40"], b"").status.code(), Some(1));
    assert_eq!(pars(&["lts", &long, "--memory", "10", "--minimise"], b"").status.code(), Some(0));
}
