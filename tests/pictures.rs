//! What a report draws.

/// The page of a report on a script.
fn page(script: &str) -> String {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("mission.pars"), script).expect("written");
    let mut program = std::process::Command::new(env!("CARGO_BIN_EXE_pars"));
    let ran = program.args(["report", "--terminal", "mission.pars"]).current_dir(folder.path()).output();
    String::from_utf8_lossy(&ran.expect("it runs").stdout).into_owned()
}

#[test]
fn a_report_draws_runs_where_no_law_is_drawn() {
    let script = "observer Done\nproc Job = Ran_{N(10, sd: 2)}<d> ; Delay_d ; (Delay_100 # Done)\n\
        proc Watch = Ran_{Exp(rate: 1/30)}<f> ; Delay_f\nsystem Race = Job # Watch\n\
        probability of Race reaching Done within 15\n";
    let page = page(script);
    assert!(page.contains("Share of 1000 runs of Race that are there by a time, seed 1"), "{page}");
}

/// A property with a probability is a first passage or a question at a time, and drawn as one.
#[test]
fn a_report_draws_how_the_probability_of_a_property_grows() {
    let script = "param D : distribution, t = 1\nobserver Done\n\
        proc Walk_r = (Delay_t # At_r) ; Ran_{N(1, sd: 1/2)}<e> ; Goes_{r+e}\n\
        proc Goes_r = Lss_{r,3} ; Walk_r | Gte_{r,3} ; Done\nsystem Steps = Walk_0\n\
        property Goal = Ran_D<x> ; Delay_x ; Done where P(x <= 6*t) >= 9/10\n\
        property Far = Delay_2 ; At_{?a} ; Gtr_{?a,2}\nprove Steps satisfies Goal\n\
        prove Steps satisfies Far with probability >= 4/10\n";
    let page = page(script);
    assert!(page.contains("Probability of being there by a time, Steps"), "{page}");
    assert!(page.contains("Share of 1000 runs of Steps in which ?a is at most so much at 2, seed 1"), "{page}");
}
