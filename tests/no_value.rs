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

/// What stands in a state, and not only what is shown: in a branch, a parameter that nobody reads, a result, a communication.
#[test]
fn what_stands_in_a_phase_must_have_a_value_wherever_it_is_entered() {
    let shown = "observer At(p)\n";
    let ask = "system S = C_3 | D\nprove S always p <= 5 when At_p\nproperty G = Delay_1 ; G\nprove S satisfies G\n";
    for (process, other) in [
        ("C_x = Delay_1 ; ((Gtr_{1/x,0} | Lte_{1/x,0}) ; (Delay_1 # At_x)) ; C_{x-1}", "D = Delay_1 ; D"),
        ("C_x = B_{x,0}\nproc B_{x,y} = (Delay_1 # At_x) ; B_{x-1,1/(x-1)}", "D = Delay_1 ; D"),
        ("C_x = (Delay_1 # At_x) ; Set_{sqrt(x)}<y> ; C_{x-1}", "D = Delay_1 ; D"),
        ("C_x = (Delay_1 # At_x) ; Out_{c,sqrt(x)} ; C_{x-1}", "D = In_c<y> ; D"),
    ] {
        let text = told(&format!("{shown}proc {process}\nproc {other}\n{ask}"));
        assert!(!text.contains(": proved: ") && text.contains("may come to what has no value"), "{process}: {text}");
    }
    // Behind a guard it is asked for where the guard holds.
    let guarded = "proc C_r = Delay_1 ; ((Gtr_{r,3} ; (Delay_1 # At_{1/(r-3)})) | (Lte_{r,3} ; Delay_1)) ; C_{r-1}\n\
        system S = C_6\nprove S always p >= 0 when At_p\n";
    let text = told(&format!("{shown}{guarded}"));
    assert!(text.contains(": proved: ") && text.contains("checked every way of the phases"), "{text}");
    let drawn = "proc C = Ran_{Uniform(-1,1)}<e> ; (Delay_1 # At_{sqrt(e)}) ; C\nsystem S = C\nprove S always p >= 0 when At_p\n";
    let text = told(&format!("{shown}{drawn}"));
    assert!(!text.contains(": proved: ") && text.contains("no value"), "{text}");
    let rock = "observer Rock(q)\nproc W_r = (Delay_1 # At_r # Rock_7) ; Delay_1 ; ((Gtr_{sqrt(r+100000),-1} ; W_{r-1}) | \
        (Lte_{sqrt(r+100000),-1} ; W_{r-1}))\nsystem S = W_3\ncriteria K for S { clearance > 1 between At, Rock }\n";
    let text = told(&format!("{shown}{rock}"));
    assert!(text.contains("open: criteria K") && text.contains("no value"), "{text}");
}

/// A sequence that is asked for behind a term that has no value.
#[test]
fn no_form_and_no_index_goes_past_a_term_without_a_value() {
    for (equations, question) in [
        ("r(n+1) = r(n)+(if sqrt(10-n) > 5 then 1 else 2), r(0) = 0", "r(n) >= 200"),
        ("r(n+1) = r(n)+max(sqrt(10-n),100), r(0) = 0", "r(n) >= 2000"),
        ("r(n+1) = r(n)-1, q(n+1) = max(q(n)+1,-sqrt(r(n))), r(0) = 6, q(0) = 0", "q(n) >= 20"),
        ("r(n+1) = r(n)+(if norm((sqrt(5-n),1)) >= 1 then 1 else 2), r(0) = 0", "r(n) >= 20"),
    ] {
        let text = told(&format!("solve {equations} find n with {question}\n"));
        assert!(text.contains("no square root") && !text.contains("is the first"), "{text}");
    }
    // Where it has one everywhere, nothing is lost.
    let text =
        told("solve r(n+1) = r(n)+1, q(n+1) = max(q(n)+1,-sqrt(r(n))), r(0) = 6, q(0) = 0 find n with q(n) >= 20\n");
    assert!(text.contains("n = 20 is the first"), "{text}");
}

/// An equation that divides by the square of a number goes towards nothing, and its own condition says what comes at the pole.
#[test]
fn a_pole_is_no_goal() {
    for (next, start, answer) in [
        ("if abs(r(n)) > 0 then 1/r(n)^2-1 else 7", 1, "n = 2 is the first with r(n) = 7"),
        ("if r(n) = 2 then 7 else 1/(r(n)-2)^2+1", 1, "n = 2 is the first with r(n) = 7"),
        ("1/r(n)^2-1", 1, "division by zero"),
    ] {
        let text = told(&format!("solve r(n+1) = {next}, r(0) = {start} find n with r(n) = 7\n"));
        assert!(text.contains(answer) && !text.contains("is taken to stay"), "{next}: {text}");
    }
}

/// A direction towards a place where one may be already: what comes of it there is said by a condition, and is not lost where
/// the length it is divided by is the root of a condition.
#[test]
fn a_direction_that_may_be_none_keeps_what_a_condition_says_of_it() {
    let text = told(
        "observer At(p)\nparam x\nfn st(d) = if norm(d) > 1 then unit(d) else d\n\
         proc B_{r,q} = (Delay_1 # At_{part(st((6,8)-(r,q)),1)})\n\
         proc C_y = B_{if y > 0 then 1 else 6, if y > 0 then 2 else 8} ; C_y\nsystem S = C_x\n\
         prove S always p > 0 when At_p\n",
    );
    assert!(!text.contains(": proved: "), "at x = 0 it shows At_0: {text}");
}

/// A root of parameters alone is asked for as a divisor is, whether the form still shows it or a maximum has left it out.
#[test]
fn roots_of_parameters_are_conditions_of_every_form() {
    for (next, first) in [
        ("max(x(n)+1,sqrt(3-a))", "n = 29 is the first"),
        ("x(n)+max(sqrt(3-a),2)", "n = 15 is the first"),
        ("max(x(n),sqrt(3-a))", "never x(n) > 33"),
    ] {
        let found = told(&format!("param a >= 2\nsolve x(n+1) = {next}, x(0) = 5 find n with x(n) > 33\n"));
        assert!(found.contains(first), "{found}");
        // Once for the form and for what is asked of it.
        assert_eq!(found.matches("if a <= 3").count(), 1, "{found}");
    }
    // Where it is granted, or a condition excludes it, nothing is asked; where it is excluded there is no form.
    for next in ["x(n)+sqrt(a-1)", "x(n)+(if a < 3 then sqrt(3-a) else 1)"] {
        let found = told(&format!("param a >= 2\nsolve x(n+1) = {next}, x(0) = 5\n"));
        assert!(found.contains("checked by induction") && !found.contains(">= 0\n"), "{found}");
    }
    let found = told("param a >= 4\nsolve x(n+1) = max(x(n)+1,sqrt(3-a)), x(0) = 5\n");
    assert!(!found.contains("checked by induction"), "{found}");
}

#[test]
fn a_power_of_a_parameter_that_divides_has_a_condition() {
    let steps = ["x(n)+p^n*p^(-n)", "x(n)+p^(3-n)*p^n", "x(n)+1/p^n", "x(n)/p^n", "x(n)+p^(-n)", "x(n)+p^(k-j)*p^j"];
    for step in steps {
        let script =
            format!("param p, k : natural, j : natural\nsolve x(n+1) = {step}, x(0) = 1 find n with x(n) > 3\n");
        let told = told(&script);
        // Of what is told in cases 0 is in none of them.
        let stated = if step == "x(n)+1/p^n" { "if p < 0:" } else { "if p != 0" };
        assert!(told.contains(stated), "{step}\n{told}");
        // 1/0^n is not 1, so nothing is told of p = 0.
        assert!(!told.contains("where p = 0") && !told.contains("if p = 0"), "{step}\n{told}");
    }
    let told = told("param p, q\nsolve x(n+1) = x(n)/(p-q)^n, x(0) = 1 find n with x(n) = 5\n");
    assert!(!told.contains("where p = q"), "{told}");
}

#[test]
fn an_exponent_of_which_it_is_not_known_that_it_counts_is_named() {
    let told = told("param p > 0, m : natural\nsolve x(n+1) = x(n)+mod(2^(m*p),1), x(0) = 0\n");
    assert!(told.contains("p is taken to be a natural number: it is an exponent"), "{told}");
}

#[test]
fn a_case_says_what_the_equation_needs_there() {
    for (script, case, need) in [
        ("param a, b, z\nsolve r(n+1) = b*r(n)+1/a, r(0) = z\n", "where b = 1:", "if a != 0"),
        ("param a, b, p\nsolve r(n+1) = (a/b)*r(n)+1, r(0) = p\n", "where a = b:", "if b != 0"),
    ] {
        let told = told(script);
        let lines: Vec<&str> = told.lines().map(str::trim).skip_while(|line| *line != case).collect();
        assert!(lines.contains(&need), "{told}");
    }
}

#[test]
fn what_is_open_of_delays_names_an_assumption() {
    let row = "proc A = Delay_a ; Out_{x,1} ; A\nproc B = In_x<u> ; Delay_b ; Out_{y,u} ; B\n\
        proc C = In_y<u> ; Delay_c ; C\nsystem Row = A | B | C\nperiod Row\n";
    let open = told(&format!("param a > 0, b > 0, c > 0, b < a, a < c\n{row}"));
    assert!(open.contains("`param b+4*c < 5*a` tells this, and the same may be asked of later delays"), "{open}");
    assert_eq!(open.matches("it must be known whether").count(), 1, "each question once: {open}");
}

/// What is decided without a part that has no value is read with it: `min(c,sqrt(x))` is below 0 for `c < 0` only where x has
/// a root.
#[test]
fn a_guard_that_is_decided_without_what_has_no_value_proves_nothing() {
    let run = |given: &str, bound: &str| {
        told(&format!(
            "observer One\nparam c < 0, {given}\nproc Q = ((Lss_{{d,{bound}}} ; (Delay_1 # One) ; Q) | (Gte_{{d,{bound}}} ; \
             (Delay_2 # One) ; Q))\nsystem S = Q\nproperty G = (Delay_{{?b}} # One) ; G\nprove S satisfies G\n"
        ))
    };
    for bound in ["min(c,sqrt(x))", "0-sqrt(x)"] {
        let text = run("d > 0, x", bound);
        assert!(text.contains("could not prove") && text.contains("may be negative"), "{text}");
        assert!(!run("d, x", bound).contains("proved:"), "in cases: {bound}");
        assert!(run("d > 0, x > 0", bound).contains("proved: S satisfies G"), "{bound}");
    }
}
