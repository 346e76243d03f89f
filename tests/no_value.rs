//! What has no value proves nothing: roots beside conditions that do not hold, and guards that are read and then gone.

mod common;

use pars::assumption::Assumptions;
use pars::name::Name;
use pars::value::{Relation, Value};

fn told(script: &str) -> String {
    String::from_utf8_lossy(&common::ran(script).stdout).into_owned()
}

fn x() -> Value {
    Value::variable(&Name::new("x"))
}

/// `(if x > 2 then sqrt(x-2) else 0) + x - 2`, which has a value for every x.
fn beside_a_condition() -> Value {
    let over = x().sub(&Value::integer(2)).expect("a value");
    let holds = Value::truth(Relation::Gtr, &over, &Value::zero()).expect("a condition");
    let root = over.sqrt().expect("a root");
    holds.mul(&root).and_then(|root| root.add(&over)).expect("a value")
}

#[test]
fn a_root_beside_a_condition_says_nothing_where_it_does_not_hold() {
    let (value, zero) = (beside_a_condition(), Value::zero());
    assert_eq!(Assumptions::default().decide(Relation::Gte, &value, &zero), None, "at 1 it is -1");
    for (least, decided) in [(2, Some(true)), (3, Some(true)), (1, None)] {
        let mut known = Assumptions::default();
        known.assume(Relation::Gte, &x(), &Value::integer(least));
        assert_eq!(known.decide(Relation::Gte, &value, &zero), decided, "from {least} on");
    }
    let mut known = Assumptions::default();
    known.assume(Relation::Lss, &x(), &Value::integer(2));
    assert_eq!(known.decide(Relation::Lss, &value, &zero), Some(true));
    // Beside no condition it has a value only where the root has one.
    let plain = x().sqrt().expect("a root");
    let square = plain.mul(&plain).expect("a value");
    assert_eq!(Assumptions::default().decide(Relation::Gte, &square, &zero), Some(true));
}

#[test]
fn what_is_decided_beside_conditions_is_so_at_every_number() {
    let (value, zero) = (beside_a_condition(), Value::zero());
    for quarters in -40..40 {
        let at = Value::fraction(quarters, 4).expect("a number");
        let here = value.with(&Name::new("x"), &at).expect("it has a value everywhere");
        for relation in [Relation::Gte, Relation::Gtr, Relation::Eq, Relation::Neq, Relation::Lss, Relation::Lte] {
            let mut known = Assumptions::default();
            known.assume(Relation::Lte, &x(), &at);
            if let Some(holds) = known.decide(relation, &value, &zero) {
                assert_eq!(Assumptions::default().decide(relation, &here, &zero), Some(holds), "{at} {relation:?}");
            }
        }
    }
}

const BESIDE: &str = "(if r > 2 then sqrt(r-2) else 0) + r - 2";

fn counting_down(guard: &str, from: &str) -> String {
    format!(
        "observer Mark, Bad(r)\nparam x\nproc C_r = (Gte_{{{guard},0}} ; (Delay_1 # Mark) | Lss_{{{guard},0}} ; \
         (Delay_2 # Bad_r)) ; C_{{r-1}}\nsystem S = C_{{{from}}}\nproperty G = (Delay_1 # Mark) ; G\n\
         prove S satisfies G\nprove S always p <= 0-100 when Bad_p\n"
    )
}

#[test]
fn a_round_that_has_no_value_some_time_is_no_theorem() {
    for (guard, from) in [(BESIDE, "100000"), ("sqrt(r)", "2"), ("sqrt(r)", "100000"), ("sqrt(r)", "x")] {
        let text = told(&counting_down(guard, from));
        assert!(!text.contains(": proved: "), "{guard} from {from}: {text}");
    }
}

#[test]
fn what_is_shown_must_have_a_value_in_every_round() {
    let script = |root: &str, map: &str| {
        format!(
            "observer At(p)\nproc C_r = (Delay_1 # At_{{{root}}}) ; C_{{{map}}}\nsystem S = C_2\n\
             prove S always p >= 0 when At_p\nperiod S\n"
        )
    };
    let falls = told(&script("sqrt(r)", "r-1"));
    assert!(!falls.contains(": proved: ") && falls.contains("no value"), "{falls}");
    assert!(falls.contains("by the kernel: 1 of 2 ways"), "{falls}");
    // Where no round comes to what has none, nothing is lost.
    let stays = told(&script("sqrt(r^2+1)", "r-1"));
    assert!(stays.contains(": proved: ") && stays.contains("by the kernel: all 2 ways"), "{stays}");
}

#[test]
fn a_proof_that_could_not_be_read_back_is_not_written() {
    let parts = 400;
    let (relays, names) = common::relays(parts);
    let script = format!(
        "proc First = Out_{{c0,1}} ; Delay_1 ; First\n{relays}proc Last = In_c{parts}<x> ; Last\n\
         system S = First{names} | Last\nproperty G = Delay_1 ; G\nprove S satisfies G\n"
    );
    let folder = tempfile::tempdir().expect("a folder");
    let (file, proofs) = (folder.path().join("chain.pars"), folder.path().join("proofs"));
    std::fs::write(&file, script).expect("written");
    let mut pars = std::process::Command::new(env!("CARGO_BIN_EXE_pars"));
    let output = pars.arg("run").arg(&file).arg("--proofs").arg(&proofs).output().expect("pars runs");
    let said = String::from_utf8_lossy(&output.stderr);
    let written = std::fs::read_dir(&proofs).map_or(0, Iterator::count);
    assert!(written == 0 && said.contains("`pars check` would reject it"), "{said}");
}
