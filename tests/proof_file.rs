//! Proof files: written, read back, changed in every byte, and forged.

use std::rc::Rc;

use pars::diagnostic::Source;
use pars::proof_file::{Checked, check_file, sealed};
use pars::session::{Alone, Session};

/// The proof files of all claims that a script proves.
fn proofs(text: &str) -> Vec<String> {
    let mut session = Session::new(Rc::new(Alone)).expect("the prelude");
    session.run(&Source::new("test.pars", text), &mut |_, _| {});
    let evidence: Vec<_> = session.records().iter().filter_map(|record| record.evidence.clone()).collect();
    assert_eq!(evidence.len(), session.records().len(), "a claim of the test is not proved");
    evidence.iter().map(|evidence| session.proof_file(evidence).expect("JSON")).collect()
}

fn one(text: &str) -> String {
    proofs(text).pop().expect("a proof")
}

fn checked(file: &str) -> Checked {
    match check_file(file.as_bytes()) {
        Ok(checked) => checked,
        Err(rejection) => panic!("{rejection}\n{file}"),
    }
}

/// What was proved, without what it was proved from.
fn statement(checked: &Checked) -> String {
    checked.to_string().lines().next().unwrap_or_default().to_string()
}

const SMALL: &str = "prove Delay_1 ; Stop = Delay_1";

const SCRIPT: &str = "
param t > 0, n : natural, D : distribution, a != t
observer A(x), B
fn g(x)
proc Go_x = Delay_x ; Out_{c,g(x)} ; Go_{x+1}
proc Once = Delay_t ; Set_1<y>
prove (Delay_t # A(1)) ; (Delay_t # A(1)) = Delay_{2*t} # A(1)
prove Go_1 ; Stop = Go_1
prove Once ; Stop = Once
prove (?P ; Stop) | (Stop ; ?Q) = ?Q | ?P
prove ?P | Stop = ?P when never_aborts(?P)
prove ?P^n ; ?P = ?P^(n+1)
prove (Delay_1 # A(0)) ; (Delay_2 # B) <= Delay_3
prove Ran_D<y> ; Stop = Ran_D<y>
prove Out_{c,max(0,t)} ; Stop = Out_{c,t}
prove Out_{c,(1, t/2)} ; Stop = Out_{c,(1, t/2)}
prove ((Delay_1 ; Abort) to {A}) ; Stop = Delay_1 ; Abort
prove Stop ; (new k. Out_{k,1}) = new k. Out_{k,1}
prove Delay_1 ; Stop = Delay_1 by { Delay_1 ; Stop = {seq-stop-right} Delay_1 }
";

#[test]
fn what_is_written_is_read_back() {
    for file in proofs(SCRIPT) {
        let found = checked(&file);
        assert!(found.foreign.is_empty());
        assert!(found.theorem.trusted().is_empty());
    }
}

#[test]
fn a_law_of_the_user_travels_and_is_named() {
    let file = one("law mine \"Thrice.\"\n  ours for a test\n  when ?a >= 0\n  \
                    Delay_?a ; Delay_?a ; Delay_?a = Delay_{3*?a}\n\
                    prove Delay_2 ; Delay_2 ; Delay_2 = Delay_6 by mine");
    let found = checked(&file);
    assert_eq!(found.foreign.len(), 1);
    assert!(found.to_string().contains("law mine"));
}

#[test]
fn a_number_of_rounds_with_a_capital_is_read_back() {
    for count in ["{L}", "L", "{L+1}"] {
        let files = proofs(&format!("param L : natural, L >= 1\nprove (Delay_1)^{count} ; Stop = (Delay_1)^{count}\n"));
        assert!(files.iter().all(|file| !checked(file).to_string().is_empty()), "{count}");
    }
    let mission = "param L : natural, L >= 1\nobserver At(r)\nproc W_r = (Delay_1 # O_r # At_r) ; In_v<u> ; W_{r+u}\n\
        proc O_r = Out_{p,r} ; O_r\nproc G_g = In_p<r> ; Neq_{r,g} ; Out_{v,clamp(g-r,-1,1)} ; G_g\n\
        proc P = G_L ; G_0 ; P\nsystem S = W_0 | P\n\
        property PG = Delay_{?t1} ; (Delay_{?t2} # At_L) ; Delay_{?t3} ; PG\nprove S satisfies PG\n";
    checked(&one(mission));
}

#[test]
fn one_changed_byte_is_rejected() {
    let file = one(SMALL).into_bytes();
    assert!(check_file(&file).is_ok());
    for place in 0..file.len() {
        for bit in 0..8 {
            let mut changed = file.clone();
            changed[place] ^= 1 << bit;
            assert!(check_file(&changed).is_err(), "byte {place}, bit {bit}");
        }
    }
}

/// Behind the seal stands the kernel: with the seal made anew, a change is rejected or proves the same.
#[test]
fn one_changed_byte_under_a_new_seal_proves_nothing_else() {
    let file = one(SMALL).into_bytes();
    let proved = statement(&check_file(&file).expect("a proof"));
    let mut accepted = 0;
    for place in 0..file.len() {
        for bit in [0, 1, 3, 5] {
            let mut changed = file.clone();
            changed[place] ^= 1 << bit;
            if let Ok(found) = check_file(&sealed(&changed)) {
                assert_eq!(statement(&found), proved, "byte {place}, bit {bit}");
                accepted += 1;
            }
        }
    }
    assert!(accepted < file.len() / 2, "{accepted} changes were accepted");
}

#[test]
fn a_file_that_is_cut_off_is_rejected() {
    let file = one(SMALL);
    for length in 0..file.len() {
        assert!(check_file(&file.as_bytes()[..length]).is_err(), "{length} bytes");
    }
    assert!(check_file(format!("{file}\n").as_bytes()).is_err());
}

/// A file in the format with these steps, sealed.
fn forged(declarations: &str, rules: &str, left: &str, right: &str, steps: &str) -> Vec<u8> {
    let text = |text: &str| serde_json::to_string(text).expect("a string");
    let file = format!(
        "{{\"format\":\"pars-proof-1\",\n\"theory\":{{\"declarations\":{},\"rules\":{}}},\n\
         \"claim\":{{\"left\":{},\"connective\":\"=\",\"right\":{}}},\n\"steps\":[{steps}],\n",
        text(declarations),
        text(rules),
        text(left),
        text(right)
    );
    sealed(file.as_bytes())
}

fn reason(file: &[u8]) -> String {
    match check_file(file) {
        Ok(checked) => panic!("accepted: {checked}"),
        Err(rejection) => rejection.to_string(),
    }
}

#[test]
fn an_honest_file_by_hand_is_accepted() {
    let steps = r#"{"step":"law","law":"seq-stop-left","with":{"processes":{"?P":"Delay_1"}}}"#;
    let found = check_file(&forged("", "", "Stop ; Delay_1", "Delay_1", steps));
    assert!(found.is_ok(), "{}", found.err().map(|rejection| rejection.to_string()).unwrap_or_default());
}

#[test]
fn forged_steps_are_rejected_with_their_number() {
    let law = |law: &str, with: &str| format!(r#"{{"step":"law","law":"{law}","with":{with}}}"#);
    let unknown = law("no-such-law", "{}");
    assert!(reason(&forged("", "", "Stop", "Abort", &unknown)).starts_with("step 0: there is no law"));
    let unbound = law("seq-stop-left", "{}");
    assert!(reason(&forged("", "", "Stop", "Abort", &unbound)).starts_with("step 0"));
    let later = r#"{"step":"symmetric","of":3}"#;
    assert!(reason(&forged("", "", "Stop", "Abort", later)).starts_with("step 0: it uses step 3"));
    let own = r#"{"step":"transitive","of":[0]}"#;
    assert!(reason(&forged("", "", "Stop", "Abort", own)).starts_with("step 0"));
    let other = r#"{"step":"reflexive","term":"Stop"}"#;
    assert!(reason(&forged("", "", "Stop", "Abort", other)).contains("differ"));
    let wrong = r#"{"step":"arithmetic","left":"Delay_1","right":"Delay_2"}"#;
    assert!(reason(&forged("", "", "Delay_1", "Delay_2", wrong)).starts_with("step 0"));
    let suppose = r#"{"step":"suppose","left":"Stop","right":"Abort"}"#;
    assert!(reason(&forged("", "", "Stop", "Abort", suppose)).contains("hypothesis"));
    assert!(reason(&forged("", "", "Stop", "Stop", "")).contains("no steps"));
    let twice = r#"{"step":"reflexive","term":"Stop"},{"step":"congruence","context":"?H ; ?H","holes":["?H","?H"],"of":[0,0]}"#;
    assert!(reason(&forged("", "", "Stop ; Stop", "Stop ; Stop", twice)).starts_with("step 1"));
}

#[test]
fn a_file_that_says_more_than_it_may_is_rejected() {
    let step = r#"{"step":"reflexive","term":"Stop"}"#;
    let with = |declarations: &str, rules: &str| reason(&forged(declarations, rules, "Stop", "Stop", step));
    assert!(with("prove Stop = Abort", "").contains("more than declarations"));
    assert!(with("import \"other.pars\"", "").contains("more than declarations"));
    assert!(with("observer At(r, s)", "").contains("again"));
    assert!(with("", "law seq-stop-left \"T\"\n  ours t\n  ?P ; Stop = ?P").contains("already"));
    assert!(!with("param t > 0, t < 0", "").is_empty());
    assert!(!with("proc A = B", "").is_empty());
    let field = r#"{"step":"reflexive","term":"Stop","more":1}"#;
    assert!(!reason(&forged("", "", "Stop", "Stop", field)).is_empty());
    assert!(!reason(&forged("", "", "Stop", "Stop = Stop", step)).is_empty());
    assert!(!reason(&forged("", "", "Stop", "Stop", r#"{"step":"trust"}"#)).is_empty());
}

#[test]
fn trust_is_shown() {
    let step = r#"{"step":"trust","left":"Stop","connective":"=","right":"Abort","reason":"because"}"#;
    let found = check_file(&forged("", "", "Stop", "Abort", step)).expect("trust is allowed, and shown");
    assert!(found.to_string().contains("on trust: because"));
}

#[test]
fn hostile_files_are_answered() {
    let brackets = format!(r#"{{"step":"reflexive","term":"{}Stop{}"}}"#, "(".repeat(50_000), ")".repeat(50_000));
    reason(&forged("", "", "Stop", "Stop", &brackets));
    let long = format!(r#"{{"step":"reflexive","term":"{}Stop"}}"#, "Stop ; ".repeat(100_000));
    reason(&forged("", "", "Stop", "Stop", &long));
    let digits = format!(r#"{{"step":"reflexive","term":"Delay_{}"}}"#, "9".repeat(200_000));
    reason(&forged("", "", "Stop", "Stop", &digits));
    let power = r#"{"step":"reflexive","term":"Delay_{2^(2^(2^(2^(2^2))))}"}"#;
    reason(&forged("", "", "Stop", "Stop", power));
    reason(&sealed("[".repeat(100_000).as_bytes()));
    reason(&sealed(b"{}"));
    reason(&[0xff; 100]);
    reason(b"");
}
