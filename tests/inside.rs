//! What a component may have inside: ports of its own, projections, copies; each as the kernel follows it.

use pars::advance::Instant;
use pars::fact::Context;

mod texts;

use texts::{declared, term, value};

const PROCESSES: &str = "param n : natural, n >= 2\nobserver See(x)\nproc Odo_r = Out_{p,r} ; Odo_r\n\
    proc Inverse_x = Neq_{x,0} ; Delay_{1/x}\nproc Reversed_x = Delay_{1/x} ; Neq_{x,0}\nparam m";

/// What a network is weakly equal to for so long, or for ever; or why that is not known.
fn onward(network: &str, time: Option<&str>) -> Result<String, String> {
    let environment = declared(PROCESSES);
    let context = Context::new(&environment.assumptions, &environment.definitions, &[]);
    let time = time.map(|time| value(&environment, time));
    let instant = Instant::of(&term(&environment, network), &context).map_err(|stuck| stuck.0)?;
    instant.onward(time.as_ref(), &context).map(|onward| onward.to_string()).map_err(|stuck| stuck.0)
}

#[track_caller]
fn goes_on(network: &str, time: Option<&str>, right: &str) {
    let right = term(&declared(PROCESSES), right).to_string();
    assert_eq!(onward(network, time), Ok(right), "{network}");
}

#[track_caller]
fn refused(network: &str, time: Option<&str>, because: &str) {
    let found = onward(network, time);
    assert!(found.as_ref().is_err_and(|why| why.contains(because)), "{network}: {found:?}");
}

#[test]
fn a_port_of_its_own_is_used_inside_alone() {
    let own =
        "new c. (new c. (In_c<x> ; (Delay_x # See_x) ; Idle | Out_{c,2}) | In_c<y> ; Abort | Delay_1 ; Out_{c,5})";
    refused(own, Some("2"), "2 <= 1");
    goes_on(own, Some("1"), "(Delay_1 # See_2) ; new c. (new c. ((Delay_1 # See_2) ; Idle))");
    goes_on("new c. (new c. In_c<x> | Out_{c,1})", None, "Idle");
    goes_on("new c. ((In_c<x> ; See_1) | new c. Out_{c,1})", None, "Idle");
    goes_on("new c. (new d. (In_c<x> ; See_x) | Out_{c,1})", None, "See_1");
    // What is called uses the port that is bound where it is called.
    goes_on("new p. (new p. (Odo_1 | In_p<x> ; See_x) | In_p<x> ; See_2)", None, "See_1");
    refused("new c. (new c. (In_c<x> ; See_1 | In_c<x> ; See_2 | Out_{c,1}))", None, "order");
    refused("new d. new c. In_e<x>", None, "open");
}

#[test]
fn many_components_with_ports_of_their_own_need_not_be_tried_in_every_order() {
    let one = "new c. new d. (Out_{c,1} ; In_d<x> ; Idle | In_c<y> ; Out_{d,y} ; (Delay_1 # See_y) ; Idle)";
    let all = vec![one; 30].join(" | ");
    assert!(onward(&all, Some("1")).is_ok_and(|right| right.starts_with("(Delay_1 # See_1) ; ")));
}

#[test]
fn a_projection_inside_hides_what_it_shows() {
    let hidden = "new c. ((((See_1 # Delay_1) ; Idle) to {At}) | Out_{c,1})";
    goes_on(hidden, Some("1"), "Delay_1 ; new c. ((Idle to {At}) | Out_{c,1})");
    goes_on("new c. ((See_1 to {See}) | (See_2 to {At}))", None, "See_1");
    goes_on("new c. ((See_1 to {See}) to {At})", None, "Idle");
    goes_on("((Set_1<y> ; (Delay_1 # See_y)) to {See}) ; See_y", Some("1"), "(Delay_1 # See_1) ; See_1");
}

#[test]
fn copies_are_followed_where_it_is_known_that_one_comes() {
    goes_on("(Delay_1)^n ; Idle", Some("1"), "Delay_1 ; Delay_1 ; (Delay_1)^{n-2} ; Idle");
    goes_on("(Delay_1 # See_i)^{i<2} ; Idle", Some("1"), "(Delay_1 # See_0) ; (Delay_1 # See_1) ; Idle");
    goes_on(
        "((Delay_1 # See_1) ; Lss_{0,0})^1 ; See_2",
        Some("1/2"),
        "(Delay_{1/2} # See_1) ; (Delay_{1/2} # See_1) ; Lss_{0,0} ; See_2",
    );
    goes_on("(Delay_1)^0 ; Delay_1 ; Idle", Some("1"), "Delay_1 ; Idle");
    refused("(Delay_1)^{n-2} ; Idle", Some("1"), "whether n-2 > 0");
    refused("(Delay_1)^{n/2} ; Idle", Some("1"), "copies");
}

#[test]
fn what_is_not_reached_needs_no_value() {
    goes_on(
        "Set_0<y> ; (Neq_{y,0} ; Delay_{1/y} ; Idle | (Delay_1 # See_2) ; Idle)",
        Some("1"),
        "(Delay_1 # See_2) ; Idle",
    );
    goes_on("Inverse_0 | Delay_1 ; Idle", Some("1"), "Delay_1 ; Idle");
    refused("Set_0<y> ; (Eq_{y,0} ; Delay_{1/y} ; Idle | Idle)", None, "division by zero");
    refused("Set_0<y> ; (Neq_{y,m} ; Delay_{1/y} ; Idle | Idle)", None, "division by zero");
    refused("Set_0<y> ; (Delay_{1/y} ; Neq_{y,0} ; Idle | Idle)", None, "division by zero");
    refused("Reversed_0 | Idle", None, "division by zero");
}

#[test]
fn nothing_of_what_components_have_inside_is_taken_on_trust() {
    for file in ["missions/inside.pars", "periods/components.pars"] {
        let ran = std::process::Command::new(env!("CARGO_BIN_EXE_pars"))
            .args(["run", &format!("{}/tests/cases/{file}", env!("CARGO_MANIFEST_DIR"))])
            .output()
            .expect("pars runs");
        let told = String::from_utf8_lossy(&ran.stdout);
        assert!(!told.contains("on trust") && !told.contains("not checked by the kernel"), "{told}");
        assert!(told.matches("by the kernel: all").count() > 1, "{told}");
    }
}
