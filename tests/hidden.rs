//! A parameter called like a result of a process that is called: the text means what it means with the parameter renamed.

use std::process::Command;

mod dice;
use dice::Dice;

fn pars(arguments: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pars"));
    let output = command.args(arguments).args(["--color", "never"]).output().expect("pars runs");
    let said = String::from_utf8_lossy(&output.stdout) + String::from_utf8_lossy(&output.stderr);
    (output.status.code(), said.into_owned())
}

/// What Go does at the end, where nobody reads its parameter X after the call that binds g.
fn ending(dice: &mut Dice) -> String {
    dice.one_of(&[
        "Wait",
        "Home_X",
        "(Lss_{X,2} ; Wait | Gte_{X,2} ; Home_{X-1})",
        "(Gtr_{X,1} else Out_{note,X}) ; Wait",
        "Once ; Delay_1 ; Wait",
        "(Once | (Delay_1 # At_{X+1})) ; Wait",
        "(Once # Delay_{X+1}) ; Wait",
        "((Once ; Out_{note,0}) else Delay_1) ; Home_2",
        "Out_{note,X} ; (Once ; Wait)",
        "Twice_{X} ; Wait",
        "Once^2 ; Wait",
    ])
}

/// A mission with this name for the parameters.
fn mission(dice: &mut Dice, parameter: &str) -> String {
    let (go, home) = (ending(dice), dice.one_of(&["Wait", "Out_{note,X} ; Wait", "(Once # Delay_1) ; Wait"]));
    let asked = dice.one_of(&["(Delay_1 # At_g)", "Out_{note,g}", "Set_{g+1}<w> ; Out_{note,w}"]);
    format!(
        "observer At(r)\nproc Wait = In_goal<g> ; Go_g\nproc Go_X = (Delay_1 # At_X) ; {go}\n\
         proc Home_X = (Delay_1 # At_{{-X}}) ; {home}\nproc Once = In_goal<g>\nproc Twice_X = Out_{{note,X}} ; Once\n\
         proc Boss_n = Out_{{goal,n}} ; Boss_{{mod(n+1,3)}}\nproc Note = In_note<x> ; Note\n\
         proc User = Delay_1 ; Twice_2 ; {asked} ; User\nsystem Sys = Wait | Boss_0 | Note\n\
         system Asks = User | Boss_1 | Note\n"
    )
    .replace('X', parameter)
}

#[test]
fn a_parameter_may_be_called_like_a_result_that_nobody_reads_after_the_call() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).to_str().expect("a name").to_string();
    let (mut same, mut periods) = (0, 0);
    for round in 0..80 {
        let mut dice = Dice(1_000 + round);
        let plain = mission(&mut dice, "k");
        let mut dice = Dice(1_000 + round);
        let called_alike = mission(&mut dice, "g");
        for (name, text) in [("plain.pars", &plain), ("alike.pars", &called_alike)] {
            std::fs::write(path(name), text).expect("a file");
        }
        for system in ["Sys", "Asks"] {
            let written = ["plain", "alike"].map(|name| {
                let (code, said) = pars(&["lts", &path(&format!("{name}.pars")), system, "--format", "aut"]);
                std::fs::write(path(&format!("{name}.aut")), &said).expect("a file");
                (code, said)
            });
            // Where a name is read that may be bound or not, both are refused.
            let about = || format!("{called_alike}{system}: {written:?}");
            assert_eq!(written[0].0, written[1].0, "{}", about());
            if written[0].0 != Some(0) {
                continue;
            }
            assert_eq!(pars(&["compare", &path("plain.aut"), &path("alike.aut")]).0, Some(0), "{}", about());
            same += 1;
            let told = ["plain", "alike"].map(|name| pars(&["period", &path(&format!("{name}.pars")), system]));
            assert_eq!(told[0].0, told[1].0, "{}", about());
            let lengths = |said: &str| said.matches("lasting").count();
            assert_eq!(lengths(&told[0].1), lengths(&told[1].1), "{}\n{told:?}", about());
            periods += usize::from(told[0].0 == Some(0));
        }
    }
    println!("{same} are the same, {periods} have a period");
    assert!(same > 80 && periods > 40, "{same} {periods}");
}
