//! The program from outside: exit codes, pipes, hostile input.

use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

fn pars() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pars"));
    command.env_remove("NO_COLOR");
    command
}

fn run(arguments: &[&str]) -> Output {
    pars().args(arguments).output().expect("pars runs")
}

fn code(output: &Output) -> i32 {
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(!errors.contains("panicked"), "{errors}");
    output.status.code().expect("an exit code")
}

fn out(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn errors(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A folder with one file of this text.
fn file(name: &str, text: impl AsRef<[u8]>) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join(name);
    std::fs::write(&path, text).expect("a file");
    (folder, path)
}

fn script(text: impl AsRef<[u8]>) -> Output {
    let (_folder, path) = file("script.pars", text);
    pars().arg("run").arg(&path).output().expect("pars runs")
}

/// What standard input is answered.
fn piped(arguments: &[&str], text: &[u8]) -> Output {
    let mut child = pars()
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("pars runs");
    child.stdin.take().expect("a pipe").write_all(text).expect("written");
    child.wait_with_output().expect("an end")
}

const PROVED: &str = "prove Delay_1 ; Delay_2 = Delay_3\n";
const REFUTED: &str = "prove Stop = Abort\n";
const OPEN: &str = "observer A\nprove (Delay_?a # A)^?n = Delay_{?a*?n} # A\n";

#[test]
fn exit_codes_say_how_the_claims_came_out() {
    assert_eq!(code(&script(PROVED)), 0);
    assert_eq!(code(&script("")), 0);
    assert_eq!(code(&script(REFUTED)), 1);
    assert_eq!(code(&script(format!("{REFUTED}expect refuted"))), 0);
    assert_eq!(code(&script(format!("{PROVED}expect refuted"))), 1);
    assert_eq!(code(&script(format!("{REFUTED}expect open"))), 1);
    assert_eq!(code(&script("prove Stop = Nowhere")), 3);
    assert_eq!(code(&script(format!("{REFUTED}prove Stop = Nowhere"))), 3);
    assert_eq!(code(&run(&["run", "no/such/file.pars"])), 3);
    assert_eq!(code(&run(&["run"])), 2);
    assert_eq!(code(&run(&["fly"])), 2);
    assert_eq!(code(&run(&["--help"])), 0);
    assert_eq!(code(&run(&["--version"])), 0);
}

#[test]
fn what_does_not_repeat_has_no_period() {
    let of = |text: &str| {
        let (_folder, path) = file("system.pars", text);
        let output = run(&["period", path.to_str().expect("a path")]);
        (code(&output), out(&output))
    };
    let halts = "proc A = In_a<x> ; Out_{b,1} ; A\nproc B = In_b<y> ; Out_{a,1} ; B\nsystem Sys = A | B\n";
    let (exit, said) = of(halts);
    assert!(exit == 1 && said.contains("\nno period: no phase comes back\n"), "{exit}: {said}");
    let (exit, said) = of("proc A = Delay_1 ; Out_{c,1}\nproc B = In_c<x>\nsystem Sys = A | B\n");
    assert!(exit == 1 && said.contains("\nno period: the run ends\n"), "{exit}: {said}");
    let (exit, said) = of("proc A = Delay_1 ; Out_{c,1} ; A\nproc B = In_c<x> ; B\nsystem Sys = A | B\n");
    assert!(exit == 0 && !said.contains("no period"), "{exit}: {said}");
    // A script says the same.
    let output = script(format!("{halts}period Sys\nexpect no\n"));
    assert!(code(&output) == 0 && out(&output).contains("no period: no phase comes back"), "{}", out(&output));
}

#[test]
fn an_open_claim_says_what_remains_and_never_that_it_is_false() {
    let output = script(OPEN);
    assert_eq!(code(&output), 4, "{}", out(&output));
    let text = out(&output);
    assert!(text.contains("could not prove") && text.contains("what remains"), "{text}");
    assert!(text.contains("tried: all laws"), "{text}");
    assert_eq!(code(&script(format!("{OPEN}expect open"))), 0);
}

#[test]
fn standard_input_is_a_script() {
    let output = piped(&[], PROVED.as_bytes());
    assert_eq!(code(&output), 0);
    assert!(out(&output).starts_with("<input>:1: proved:"), "{}", out(&output));
    assert_eq!(code(&piped(&[], b"prove Stop = Abort")), 1);
    assert_eq!(code(&piped(&["run", "-"], b"prove Stop = (Abort")), 3);
}

#[test]
fn what_is_expected_of_a_question_is_compared() {
    assert_eq!(code(&script("simplify Delay_1 ; Delay_2\nexpect = Delay_3")), 0);
    assert_eq!(code(&script("simplify Delay_1 ; Delay_2\nexpect = Delay_4")), 1);
}

#[test]
fn json_is_one_object_a_claim() {
    let text = format!(
        "param t > 0\n{PROVED}\n{REFUTED}expect refuted\nprove <= Q\nprove n: Delay_t # A(1) <= Delay_t\nobserver A(x)"
    );
    let (_folder, path) = file("script.pars", text);
    let output = pars().args(["run", "--json"]).arg(&path).output().expect("pars runs");
    assert_eq!(code(&output), 3);
    assert_eq!(errors(&output), "");
    let text = out(&output);
    let objects: Vec<serde_json::Value> = text.lines().map(|line| serde_json::from_str(line).expect(line)).collect();
    let claims: Vec<_> = objects.iter().filter(|object| object.get("verdict").is_some()).collect();
    assert_eq!(claims.len(), 3, "{text}");
    assert_eq!(claims[0]["verdict"], "proved");
    assert_eq!(claims[0]["kind"], "equality");
    assert_eq!(claims[0]["line"], 2);
    assert_eq!(claims[0]["file"], path.display().to_string());
    assert!(claims[0]["laws"].as_array().is_some_and(|laws| laws.iter().any(|law| law == "delay-sum")));
    assert_eq!(claims[1]["verdict"], "refuted");
    assert_eq!(claims[1]["expected"], "refuted");
    assert!(claims[1]["trace"].as_array().is_some_and(|trace| !trace.is_empty()));
    assert_eq!(claims[2]["kind"], "refinement");
    let broken = objects.iter().find(|object| object.get("verdict").is_none()).expect("the error");
    assert_eq!(broken["diagnostics"][0]["severity"], "error");
    assert_eq!(broken["diagnostics"][0]["line"], 6);
}

#[test]
fn proofs_travel() {
    let folder = tempfile::tempdir().expect("a folder");
    let proofs = folder.path().join("proofs");
    let (_folder, path) = file("script.pars", format!("{PROVED}prove name: Stop ; Stop = Stop\nprove Stop = Abort"));
    let output = pars().arg("run").arg(&path).arg("--proofs").arg(&proofs).output().expect("pars runs");
    assert_eq!(code(&output), 1);
    let mut names: Vec<PathBuf> = std::fs::read_dir(&proofs).expect("proofs").flatten().map(|one| one.path()).collect();
    names.sort();
    assert_eq!(names, [proofs.join("script-1.json"), proofs.join("script-name.json")]);
    let output = pars().arg("check").args(&names).output().expect("pars runs");
    assert_eq!(code(&output), 0);
    assert!(out(&output).contains("Delay_1 ; Delay_2 = Delay_3"), "{}", out(&output));
    let changed = std::fs::read_to_string(&names[0]).expect("a proof").replace("Delay_3", "Delay_4");
    std::fs::write(&names[0], changed).expect("written");
    let output = pars().arg("check").args(&names).output().expect("pars runs");
    assert_eq!(code(&output), 3);
    assert!(errors(&output).contains("rejected"), "{}", errors(&output));
    assert!(out(&output).contains("checked"), "the other is still checked");
}

#[test]
fn a_closed_pipe_is_no_panic_and_changes_no_exit_code() {
    let text = PROVED.repeat(200) + REFUTED;
    let (_folder, path) = file("script.pars", text);
    let mut child =
        pars().arg("run").arg(&path).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("pars runs");
    drop(child.stdout.take());
    let mut said = String::new();
    child.stderr.take().expect("a pipe").read_to_string(&mut said).expect("text");
    assert_eq!(said, "");
    assert_eq!(child.wait().expect("an end").code(), Some(1));
}

#[test]
fn an_import_is_looked_up_beside_its_file() {
    let (folder, path) = file("main.pars", "import \"parts/part.pars\"\nprove A = Delay_3\n");
    std::fs::create_dir(folder.path().join("parts")).expect("a folder");
    let part = |name: &str, text: &str| std::fs::write(folder.path().join("parts").join(name), text).expect("a file");
    part("part.pars", "import \"more.pars\"\nproc A = B ; Delay_2\n");
    part("more.pars", "import \"../parts/./more2.pars\"\nproc B = C\n");
    part("more2.pars", "proc C = Delay_1\n");
    let output = pars().arg("run").arg(&path).output().expect("pars runs");
    assert_eq!(code(&output), 0, "{}{}", out(&output), errors(&output));
}

#[test]
fn files_that_import_each_other_are_refused() {
    let (folder, path) = file("a.pars", "import \"b.pars\"\n");
    std::fs::write(folder.path().join("b.pars"), "import \"./a.pars\"\n").expect("a file");
    let output = pars().arg("run").arg(&path).output().expect("pars runs");
    assert_eq!(code(&output), 3);
    assert!(errors(&output).contains("imports itself"), "{}", errors(&output));
}

#[test]
fn what_is_no_text_is_refused_with_its_place() {
    let output = script(b"prove Stop = Stop\n\xff\xfe");
    assert_eq!(code(&output), 3);
    assert!(errors(&output).contains("not UTF-8") && errors(&output).contains(":2:1"), "{}", errors(&output));
    assert_eq!(code(&piped(&[], b"\x80")), 3);
    assert_eq!(code(&run(&["run", env!("CARGO_MANIFEST_DIR")])), 3);
}

#[test]
fn brackets_and_sequences_without_end_are_answered() {
    let brackets = format!("simplify {}Stop{}", "(".repeat(100_000), ")".repeat(100_000));
    assert_eq!(code(&script(brackets)), 3);
    assert_eq!(code(&script("simplify ".to_string() + &"(".repeat(100_000))), 3);
    let digits = format!("prove Delay_{0} = Delay_{0}", "9".repeat(200_000));
    assert_eq!(code(&script(digits)), 3);
    let sequence = format!("prove {0}Stop = {0}Stop", "Delay_1 ; ".repeat(100_000));
    let output = script(sequence);
    assert!([0, 3, 4].contains(&code(&output)), "{}", errors(&output));
}

#[test]
fn ten_megabytes_are_answered() {
    let comments = "// nothing to see here, go on reading the next line\n".repeat(200_000);
    assert_eq!(code(&script(comments + PROVED)), 0);
    let junk = "@ ".repeat(5_000_000);
    assert_eq!(code(&script(junk)), 3);
}

#[test]
fn a_law_that_loops_is_refused_with_its_place() {
    let (_folder, rules) = file("loop.rules", "law round \"Round.\"\n  ours for a test\n  ?P ; ?Q => ?P ; Stop ; ?Q\n");
    let output = pars().arg("run").arg(&rules).output().expect("pars runs");
    assert_eq!(code(&output), 3);
    assert!(errors(&output).contains("`round`") && errors(&output).contains("loop.rules:"), "{}", errors(&output));
}

#[test]
fn files_are_laid_out_and_checked() {
    let (_folder, path) = file("script.pars", "prove   Delay_1;Stop  =  Delay_1\n");
    let checked = |path: &Path| pars().args(["fmt", "--check"]).arg(path).output().expect("pars runs");
    assert_eq!(code(&checked(&path)), 1);
    assert_eq!(code(&pars().arg("fmt").arg(&path).output().expect("pars runs")), 0);
    assert_eq!(std::fs::read_to_string(&path).expect("a file"), "prove Delay_1 ; Stop = Delay_1\n");
    assert_eq!(code(&checked(&path)), 0);
    let (_folder, broken) = file("broken.pars", "prove (");
    assert_eq!(code(&checked(&broken)), 3);
}

#[test]
fn every_error_code_is_explained() {
    let mut codes = std::collections::BTreeSet::new();
    collect(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &mut codes);
    assert!(codes.len() > 30, "{codes:?}");
    let unexplained: Vec<&String> = codes.iter().filter(|code| pars::codes::explain(code).is_none()).collect();
    assert!(unexplained.is_empty(), "docs/errors.md says nothing about {unexplained:?}");
    let output = run(&["explain", "p0203"]);
    assert_eq!(code(&output), 0);
    assert!(out(&output).contains("brackets"));
    assert_eq!(code(&run(&["explain", "P9999"])), 2);
    assert_eq!(code(&run(&["explain"])), 0);
}

fn collect(folder: &Path, codes: &mut std::collections::BTreeSet<String>) {
    for entry in std::fs::read_dir(folder).expect("a folder").flatten() {
        let path = entry.path();
        if path.is_dir() {
            collect(&path, codes);
            continue;
        }
        let text = std::fs::read_to_string(&path).expect("a source");
        for piece in text.split("\"P0").skip(1) {
            let digits: String = piece.chars().take(3).collect();
            if digits.chars().all(|digit| digit.is_ascii_digit()) && piece.chars().nth(3) == Some('"') {
                codes.insert(format!("P0{digits}"));
            }
        }
    }
}

#[test]
fn a_report_needs_nothing_beside_it_and_begins_with_the_verdict() {
    let text = "proc Env_r = (Delay_1 # At_r) ; (Ran_{Normal(0, sd: 0.02)}<e> | In_v<u>) ; Env_{r+u+e}
proc Unit = Out_{v,1} ; Unit\nsystem Steps = Env_0 | Unit
prove probability of Steps showing At_p where |p-10| <= 0.1 at 10 >= 0.886\n";
    let (folder, path) = file("noisy.pars", text);
    let page = folder.path().join("page.html");
    let output = pars().arg("report").arg(&path).arg("-o").arg(&page).output().expect("pars runs");
    assert_eq!(code(&output), 0, "{}", errors(&output));
    let html = std::fs::read_to_string(&page).expect("a page of the name that was asked for");
    let place = |what: &str| html.find(what).unwrap_or_else(|| panic!("no {what}"));
    assert!(place("proved") < place("asked for &gt;= 443/500: margin "));
    assert!(place("asked for") < place("<svg") && place("<svg") < place("Taken on trust"));
    assert!(!html.contains("src=") && !html.contains("<script") && !html.contains("<link") && !html.contains("url("));
    // What is asked for is filled in under the curve.
    assert!(html.contains("<polygon"), "nothing is filled");
}

#[test]
fn criteria_that_no_mission_can_meet_are_refused() {
    let mission = "proc Go = (Delay_1 # At_0) ; Stop\nsystem Sys = Go | Delay_1\n";
    for (criteria, said) in [
        ("goals At_0 battery 5 rate 1 keep 6", "a battery of 5 is less than the 6 to keep"),
        ("goals At_0 radius 1 radius 2", "there are two radii here"),
    ] {
        let output = script(format!("{mission}criteria C for Sys {{ {criteria} }}\n"));
        assert_eq!(code(&output), 3, "{criteria}");
        assert!(errors(&output).contains(said), "{criteria}: {}", errors(&output));
    }
    // A goal that is wrong is one error, not one for each clause about goals.
    let output = script(format!("{mission}criteria C for Sys {{ goals Att_0 round within 3 }}\n"));
    assert!(errors(&output).contains("did you mean `At`") && !errors(&output).contains("none is given"));
}

/// A shuttle over three stops, of which a simulation by hand gave the least changes: with a speed of 18/7 a round takes
/// 12, with a millionth less 49/4; with b = 12 it takes 12, with a millionth more 25/2.
#[test]
fn what_is_said_to_repair_a_criterion_is_the_least_that_does() {
    let output = script(
        "param speed = 2, b = 15, drain = 3/2
fn s(d) = clamp(4 * d, -speed, speed)
proc Tour_{x,y} = MoveTo_x ; MoveTo_y ; MoveTo_0 ; Tour_{x,y}
proc MoveTo_g = In_p<r> ; Neq_{r,g} ; Out_{v,s(g-r)} ; MoveTo_g
proc Env_r = (Delay_{1/4} # Odo_r # At_r) ; In_v<u> ; Env_{r+u/4}
proc Odo_r = Out_{p,r} ; Odo_r
system Sys = Env_0 | Tour_{6,b}
criteria Trip for Sys {
  goals At_6, At_b, At_0
  radius 1/10
  every round within 12
  battery 30 rate drain keep 10
}\n",
    );
    assert_eq!(code(&output), 1);
    let text = out(&output);
    for line in [
        "round: speed = 18/7 in place of 2 gives round = 12, margin 0; with a change that is smaller by",
        "round: b = 12 in place of 15 gives round = 12, margin 0; with a change that is smaller by",
        "battery: drain = 4/3 in place of 3/2 gives battery = 10, margin 0; solved from the margin 20-15*drain",
        "margin of battery by drain: +1 % changes it by -9/40, -1 % changes it by 9/40, slope -15 while",
    ] {
        assert!(text.contains(line), "{line}\n{text}");
    }
}

#[test]
fn a_pair_is_said_where_no_one_parameter_repairs() {
    let output = script(
        "param speed = 1, limit = 1
fn s(d) = clamp(d, -min(speed, limit), min(speed, limit))
proc Go_g = In_p<r> ; Neq_{r,g} ; Out_{v,s(g-r)} ; Go_g
proc Env_r = (Delay_1 # Odo_r # At_r) ; In_v<u> ; Env_{r+u}
proc Odo_r = Out_{p,r} ; Odo_r
system Sys = Env_0 | Go_12
criteria Fast for Sys { goals At_12 round within 6 }
criteria Never for Sys { goals At_13 round within 60 }\n",
    );
    let text = out(&output);
    assert!(text.contains("round: limit = 2 in place of 1 and speed = 2 in place of 1 gives round = 6"), "{text}");
    assert!(text.contains("no change of one of limit, speed alone"), "{text}");
    assert!(text.contains("round: no change found of one or two of limit, speed"), "{text}");
}

#[test]
fn the_longest_leg_is_that_of_the_round_that_takes_too_long() {
    let output = script(
        "proc A_{x,k} = (Delay_1 # At_x) ; (Delay_k # At_10) ; A_{0,min(k+1,5)}
system Sys = A_{0,1} | Delay_1
criteria C for Sys { goals At_10, At_0 every round within 4 }\n",
    );
    assert!(out(&output).contains("from 14 to 20, longest the leg to At_0: 5"), "{}", out(&output));
}

#[test]
fn nothing_is_said_of_a_number_that_is_not_read() {
    let long = "9".repeat(10_001);
    for claim in [format!("prove Delay_{long} = Stop"), format!("prove Out_{{c,0.{long}}} = Out_{{c,1}}")] {
        let output = script(format!("{claim}\n{PROVED}"));
        assert_eq!(code(&output), 3);
        assert!(errors(&output).contains("digits; at most"), "{}", errors(&output));
        assert_eq!(out(&output).matches("proved").count(), 1, "only the other claim is judged: {}", out(&output));
        assert!(!out(&output).contains("refuted"), "{}", out(&output));
    }
}

#[test]
fn a_place_in_a_long_line_has_its_own_column() {
    let text = format!("prove {}) = Stop\n", "Delay_1 ; ".repeat(100));
    let output = script(&text);
    assert_eq!(code(&output), 3);
    assert!(errors(&output).contains(".pars:1:1007\n"), "{}", errors(&output));
}

#[test]
fn commands_in_standard_input_are_answered_in_their_place() {
    let text = format!("{PROVED}:why\n\nprove two: Stop ; Stop = Stop\n:why two\nprove )\n");
    let output = piped(&[], text.as_bytes());
    assert_eq!(code(&output), 3);
    let answers = out(&output);
    let places: Vec<usize> = ["proved: Delay_1", "= {delay-sum}", "proved: two", "= {seq-stop"]
        .map(|word| answers.find(word).expect(word))
        .into();
    assert!(places.is_sorted(), "{answers}");
    assert!(errors(&output).contains("<input>:6:7"), "{}", errors(&output));
    assert_eq!(code(&piped(&[], format!("{PROVED}:why\n").as_bytes())), 0);
    assert_eq!(code(&piped(&[], format!("{REFUTED}:why\n").as_bytes())), 1);
    assert_eq!(code(&piped(&[], format!("{PROVED}:quit\n{REFUTED}").as_bytes())), 0);
    let wrong = piped(&[], format!("{PROVED}:wyh\n").as_bytes());
    assert!(code(&wrong) == 3 && out(&wrong).contains("did you mean `:why`"), "{}", out(&wrong));
    // A file is no prompt.
    let output = script(format!("{PROVED}:why\n"));
    assert!(code(&output) == 3 && errors(&output).contains("at the prompt"), "{}", errors(&output));
}

#[test]
fn what_is_wrong_comes_in_the_order_of_the_text_and_a_refuted_claim_has_its_run() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.pars");
    let text =
        "param t\nprove Nowhere = Stop\nlts Ran_{Normal(t, sd: 1)}<y> ; Delay_y\nprove Stop = Nothing\nstep Stop\n";
    std::fs::write(&path, text).expect("a file");
    let output = run(&["run", path.to_str().expect("a path")]);
    let lines: Vec<String> =
        errors(&output).lines().filter(|line| line.contains("a.pars:")).map(str::to_string).collect();
    let number = |line: &String| line.rsplit(':').nth(1).and_then(|number| number.trim().parse::<usize>().ok());
    let places: Vec<usize> = lines.iter().filter_map(number).collect();
    assert!(places == [2, 3, 5], "{}", errors(&output));
    assert!(errors(&output).contains("`:step` is a command"), "{}", errors(&output));
    std::fs::write(&path, "prove Delay_1 ; Out_{c,0} = Delay_1 ; Out_{c,1}").expect("a file");
    let output = run(&["run", "--json", path.to_str().expect("a path")]);
    let claim: serde_json::Value = serde_json::from_str(out(&output).lines().next().expect("a line")).expect("JSON");
    assert_eq!(claim["run"]["left"]["process"], "Delay_1 ; Out_{c,0}");
    assert_eq!(claim["run"]["right"]["steps"], serde_json::json!(["wait 1"]));
}

#[test]
fn one_answer_for_every_order_has_a_value_in_each() {
    // A quotient by abs(g-p0) would say nothing where the start is the goal.
    let text = "param w > 0, g, p0\n\
                solve r(n+1) = if r(n) < g then r(n)+w else r(n), r(0) = p0 find n with r(n) >= g\n";
    let said = out(&script(text));
    assert!(said.contains("if p0 >= g:") && !said.contains("in every order"), "{said}");
    // What is added in every step may have either sign.
    let text = "param v > 0, c > 0, D > 0\nsolve e(n+1) = e(n) - v + c, e(0) = D find n with e(n) <= 0\n";
    let said = out(&script(text));
    assert!(said.contains("if c < v:") && said.contains("n = ceil(D/(v-c)) is the first"), "{said}");
    // Where it stays and where it grows the same is said, once.
    assert!(said.contains("if c >= v:") && said.matches("never e(n) <= 0").count() == 1, "{said}");
}

#[test]
fn what_is_said_of_later_rounds_is_true_of_all_of_them() {
    // The second round waits for 2, all later ones for 0.
    let text = "observer One(r)\nproc World_r = (Delay_1 # One_r) ; (In_v<u> # One_r) ; World_u\n\
                proc Rob = Out_{v,1} ; Out_{v,0} ; Out_{v,0} ; Out_{v,1}\nsystem Sys = World_0 | Rob\n\
                property G = Delay_{?t1} ; (Delay_{?t2} # One_1) ; Delay_{?t3} ; G\nprove Sys satisfies G\n";
    let said = out(&script(text));
    assert!(said.contains("in later rounds ?t2 = 2, ?t3 = 0"), "{said}");
}

#[test]
fn a_word_that_is_nearly_one_of_a_claim_is_understood() {
    for (word, meant) in [("satisfy", "satisfies"), ("satisfied", "satisfies"), ("alway", "always")] {
        let output = script(format!("system Sys = Delay_1\nproperty G = Delay_1\nprove Sys {word} G\n"));
        assert!(errors(&output).contains(&format!("did you mean `{meant}`?")), "{word}: {}", errors(&output));
    }
}

/// Of a system with a part missing a period would say what is not so.
#[test]
fn what_calls_a_process_with_errors_is_refused_with_it() {
    let world = "proc W_r = (Delay_1 # Odo_r # At_r) ; In_v<u> ; W_{r+u}\nproc Odo_r = Out_{p,r} ; Odo_r\n";
    let tour = "proc Tour = Leg ; Tour\nproc Leg = Mv_5 ; Mv_0\nsystem Sys = W_0 | Tour\nperiod Sys\n";
    let wrong = "proc Mv_g = In_p<r> ; Neq_{r,g} ; Out_{v,clamp(g-r,-1,1)} ; Mv_g ; Stop\n";
    let output = script(format!("{world}{wrong}{tour}"));
    assert_eq!(code(&output), 3);
    assert_eq!(out(&output), "", "nothing is said of the system");
    assert_eq!(errors(&output).matches("error[").count(), 1, "{}", errors(&output));
    let right = wrong.replace(" ; Stop", "");
    assert!(out(&script(format!("{world}{right}{tour}"))).contains("phase 1"));
}

#[test]
fn json_tells_what_was_expected_and_is_not_so_and_what_is_only_asked_for() {
    let text = "solve r(n+1) = 2*r(n), r(0) = 1\nexpect r(5) = 7\nexpect r(1) = 2\n\
                proc E_r = (Delay_1 # At_r) ; Ran_{Normal(0, sd: 1)}<e> ; E_{r+e}\nsystem S = E_0\n\
                probability of S showing At_p where p <= 0 at 4\n";
    let (_folder, path) = file("asked.pars", text);
    let output = pars().args(["run", "--json"]).arg(&path).output().expect("pars runs");
    assert_eq!(code(&output), 1);
    let said = out(&output);
    let objects: Vec<serde_json::Value> = said.lines().map(|line| serde_json::from_str(line).expect(line)).collect();
    assert_eq!(objects[0]["unmet"], serde_json::json!(["r(5) = 7"]), "{said}");
    assert_eq!(objects[1]["probability"]["low"], 0.5, "{said}");
    assert_eq!(objects[1]["probability"]["method"], "exact", "{said}");
}
