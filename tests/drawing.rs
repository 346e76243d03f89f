//! Networks that draw, followed by the kernel: forged steps are turned away, and what is concluded agrees with the weak
//! bisimilarity of the transition systems.

use pars::advance::Instant;
use pars::advance::draw::Draws;
use pars::fact::Context;
use pars::kernel::{Reason, check};
use pars::law::Connective;
use pars::name::Name;
use pars::parser::parse_value;
use pars::proof::{Lemma, Proof, Statement, Step, hole};
use pars::substitution::Substitution;
use pars::term::{Node, Term};
use pars::value::Value;

mod dice;
mod steps;
mod texts;

use dice::Dice;
use steps::{DECLARED, accepted, atom, compared, concluded, differs, judged, names, refused};
use texts::{condition, declared, term, theory};

#[test]
fn what_is_due_is_drawn_first_each_under_a_name_of_its_own() {
    accepted(
        "new c. (Ran_{Normal(0, var: 1)}<x> ; (Delay_1 # See_x) ; Idle | Idle)",
        &["e"],
        "Ran_{Normal(0, var: 1)}<e> ; new c. (Set_e<x> ; (Delay_1 # See_x) ; Idle | Idle)",
    );
    // Two draws are two, however alike.
    let two = "Ran_{Exp(rate: 2)}<x> ; (Delay_1 # See_x) ; Idle | Ran_{Exp(rate: 2)}<y> ; (Delay_1 # See_y) ; Idle";
    let after = |one: &str, other: &str| {
        format!(
            "Ran_{{Exp(rate: 2)}}<e> ; Ran_{{Exp(rate: 2)}}<f> ; \
            (Set_{one}<x> ; (Delay_1 # See_x) ; Idle | Set_{other}<y> ; (Delay_1 # See_y) ; Idle)"
        )
    };
    accepted(two, &["e", "f"], &after("e", "f"));
    differs(two, &["e", "f"], &after("e", "e"));
    differs(two, &["e", "f"], &after("f", "f"));
    // A parameter that was communicated before: that it was, is told.
    let late = "new c. (In_c<y> ; Ran_{Normal(y, var: 1)}<x> ; (Delay_1 # See_x) ; Idle | Out_{c,2} ; Idle)";
    let then = "Ran_{Normal(2, var: 1)}<e> ; new c. (Set_e<x> ; (Delay_1 # See_x) ; Idle | Idle)";
    accepted(late, &["e"], &format!("new c. (In_c<e> ; Abort | Out_{{c,0}}) ; {then}"));
    differs(late, &["e"], then);
    // What ends at once does so before anything is drawn.
    refused("Ran_{Exp(rate: 1)}<x> # Stop", &["e"], "the network has ended");
    refused("(Ran_{Exp(rate: 1)}<x> # Abort) | Idle", &["e"], "nothing is drawn");
}

#[test]
fn a_name_for_what_is_drawn_stands_nowhere_else() {
    let one = "Ran_{Normal(k, var: 1)}<x> ; (Delay_1 # See_x) ; Ran_{Exp(rate: 1)}<y> ; (Delay_1 # See_{x+y}) ; Idle";
    for taken in ["x", "y", "k", "t", "?e", "w", "u", "r", "v"] {
        refused(one, &[taken], "stands for something else");
    }
    refused(one, &[], "0 names for 1 draws");
    refused(one, &["e", "f"], "2 names for 1 draws");
    let two = "Ran_{Exp(rate: 2)}<x> ; See_x | Ran_{Exp(rate: 2)}<y> ; See_y";
    refused(two, &["e", "e"], "stands for something else");
    refused(two, &["e"], "1 names for 2 draws");
    // Drawn before, and still read.
    refused("Ran_{Exp(rate: 1)}<y> ; See_{y+e}", &["e"], "stands for something else");
    // Not even where only something is supposed of it.
    let environment = declared(DECLARED);
    let left = term(&environment, "Ran_{Exp(rate: 1)}<y> ; See_y");
    let right = term(&environment, "Ran_{Exp(rate: 1)}<e> ; Set_e<y> ; See_y");
    let steps = vec![Step::Draw(left.clone(), names(&["e"]))];
    assert!(judged(&environment, &[], (&left, &right), steps.clone()).is_ok());
    for when in ["e >= 1", "never_aborts(Out_{c,e})", "no_port(Idle, e)"] {
        let found = judged(&environment, &[when], (&left, &right), steps.clone());
        assert!(matches!(found, Err(Reason::Advance(_) | Reason::Name(_))), "{when}: {found:?}");
    }
}

#[test]
fn what_draws_in_no_certain_way_is_left_alone() {
    // It may stop, and would carry what was drawn.
    refused("Ran_{Exp(rate: 1)}<x> ; Delay_1", &["e"], "may stop");
    refused("Ran_{Exp(rate: 1)}<x> ; Delay_1 | Delay_1 ; Set_1<y>", &["e"], "may stop");
    // No numbers.
    refused("Ran_{Point((1,2))}<x> ; See_x", &["e"], "no distribution of numbers");
    refused("Ran_{Mix(1/2: Point(1), 1/2: Point((1,2)))}<x> ; See_x", &["e"], "no distribution of numbers");
    refused(
        "new c. (In_c<y> ; Ran_{Normal(y, var: 1)}<x> ; See_x | Out_{c,1} ; Idle | Out_{c,2} ; Idle)",
        &["e"],
        "the order in which parts communicate in one instant matters",
    );
    refused("In_c<y> ; Ran_{Exp(rate: 1)}<x> ; See_x | Idle", &["e"], "the port c is open");
    refused("new c. (Idle | Delay_1)", &["e"], "nothing is drawn");
    // A draw is no communication, and does not pass with time.
    let environment = declared(DECLARED);
    let value = |text: &str| environment.value(&parse_value(text).expect("a value")).expect("a value");
    for network in
        ["Ran_{Exp(rate: 1)}<x> ; See_x", "new c. (In_c<y> ; Ran_{Exp(rate: 1)}<x> ; See_x | Out_{c,1} ; Idle)"]
    {
        let left = term(&environment, network);
        for time in [None, Some(value("0")), Some(value("1"))] {
            let found = judged(&environment, &[], (&left, &left), vec![Step::Advance(left.clone(), time)]);
            assert!(matches!(&found, Err(Reason::Advance(why)) if why == "a random draw"), "{network}: {found:?}");
        }
    }
}

#[test]
fn nothing_is_known_of_what_was_drawn() {
    let environment = declared(DECLARED);
    let value = |text: &str| environment.value(&parse_value(text).expect("a value")).expect("a value");
    let refused = |network: &str, time: Option<Value>| {
        let left = term(&environment, network);
        let found = judged(&environment, &[], (&left, &left), vec![Step::Advance(left.clone(), time)]);
        assert!(matches!(found, Err(Reason::Advance(_))), "{network}: {found:?}");
    };
    // Guards, delays that may be negative, and counts of a value e that was drawn; two that are as likely are not equal.
    let zero = || Some(Value::zero());
    refused("Set_e<x> ; (Gtr_{x,0} ; See_1 | Lte_{x,0} ; See_2)", zero());
    refused("Set_e<x> ; Set_f<y> ; (Eq_{x,y} ; See_1 | Neq_{x,y} ; See_2)", zero());
    refused("Set_e<x> ; Delay_x ; See_1", zero());
    refused("Set_e<x> ; Delay_{x^2} ; See_1", zero());
    refused("Set_e<x> ; (Delay_1 # See_2)^e ; See_1", zero());
    refused("(Delay_1 # See_e) ; Idle | Delay_e ; Idle", Some(value("1")));
    refused("(Delay_2 # See_e) ; Idle", Some(value("e")));
    // A count that a draw writes.
    let left = term(&environment, "(Delay_1)^k ; Idle");
    let context = Term::seq([term(&environment, "Ran_{Poisson(rate: 1)}<k>"), Term::meta(&hole(1))]);
    let both = Term::seq([term(&environment, "Ran_{Poisson(rate: 1)}<k>"), left.clone()]);
    let steps = vec![Step::Reflexive(left), Step::Congruence(context, vec![0])];
    assert!(matches!(judged(&environment, &[], (&both, &both), steps), Err(Reason::Name(_) | Reason::Sort(_))));
}

#[test]
fn what_is_supposed_of_some_values_is_not_said_of_all_that_are_drawn() {
    let environment = declared(DECLARED);
    let network =
        |text: &str| term(&environment, &format!("Set_{text}<x> ; (Gtr_{{x,0}} ; See_1 | Lte_{{x,0}} ; See_2)"));
    let lemma = Lemma {
        name: Name::new("above"),
        statement: Statement {
            hypotheses: vec![condition(&environment, "?e > 0")],
            left: network("?e"),
            connective: Connective::Weak,
            right: term(&environment, "See_1"),
        },
        steps: vec![Step::Advance(network("?e"), Some(Value::zero()))],
    };
    let whole = |rest: Term| Term::seq([term(&environment, "Ran_{Uniform(-1,1)}<e>"), rest]);
    let with = |text: &str| Substitution {
        values: [(Name::new("?e"), environment.value(&parse_value(text).expect("a value")).expect("a value"))].into(),
        ..Substitution::default()
    };
    let statement =
        |left: Term, right: Term| Statement { hypotheses: vec![], left, connective: Connective::Weak, right };
    let see = term(&environment, "See_1");
    let steps = vec![Step::Lemma(0, with("e")), Step::Congruence(whole(Term::meta(&hole(1))), vec![0])];
    let claim = statement(whole(network("e")), whole(see.clone()));
    let proof = Proof { lemmas: vec![lemma.clone()], statement: claim, steps };
    let found = check(&theory(&environment), &proof).map_err(|rejected| rejected.reason);
    assert!(matches!(found, Err(Reason::Condition(_))), "{found:?}");
    // Of a number above 0 it is so.
    let proof =
        Proof { lemmas: vec![lemma], statement: statement(network("2"), see), steps: vec![Step::Lemma(0, with("2"))] };
    assert!(check(&theory(&environment), &proof).is_ok());
}

#[test]
fn a_round_with_a_draw_is_a_theorem() {
    let environment = declared(DECLARED);
    for (start, next, before) in [
        (
            "new v. (World_0 | Push)",
            "(Delay_t # At_0) ; Ran_{Normal(0, var: 1)}<e> ; new v. ((Delay_t # At_{1+e}) ; \
            (Ran_{Normal(0, var: 1)}<w> | In_v<u>) ; World_{1+e+u+w} | Out_{v,1} ; Push)",
            1,
        ),
        (
            "new v. (Late_0 | Push)",
            "(Delay_1 # At_0) ; new v. (In_v<e> ; Abort | Out_{v,0}) ; Ran_{Normal(1, var: 1)}<e> ; \
            new v. ((Delay_1 # At_e) ; In_v<u> ; Ran_{Normal(u, var: 1)}<w> ; Late_{e+w} | Out_{v,1} ; Push)",
            2,
        ),
    ] {
        let (start, next) = (term(&environment, start), term(&environment, next));
        let context = Context::new(&environment.assumptions, &environment.definitions, &[]);
        let instant = Instant::of(&start, &context).expect("it runs");
        let time = instant.delays()[0].clone();
        let state = instant.after(&time, &context).expect("it runs on");
        let draws = Draws::of(&state, &context).expect("it draws").made(&names(&["e"]), &context).expect("one draw");
        let Node::Seq(parts) = draws.node() else { panic!("{draws}") };
        let last = parts[parts.len() - 1].clone();
        let behind = |count: usize, parts: &[Term]| {
            let shown = pars::advance::stretch(&time, &instant.shown());
            Term::seq([shown].into_iter().chain(parts[..count].iter().cloned()).chain([Term::meta(&hole(1))]))
        };
        let steps = vec![
            Step::Advance(start.clone(), Some(Value::zero())),
            Step::Advance(instant.network(), Some(time.clone())),
            Step::Draw(state, names(&["e"])),
            Step::Congruence(behind(0, &[]), vec![2]),
            Step::Advance(last, Some(Value::zero())),
            Step::Congruence(behind(before, parts), vec![4]),
            Step::Transitive(vec![0, 1, 3, 5]),
        ];
        if let Err(reason) = judged(&environment, &[], (&start, &next), steps) {
            panic!("{start}: {reason:?}");
        }
    }
}

#[test]
fn what_is_concluded_of_random_networks_is_weakly_bisimilar() {
    let mut dice = Dice(20_121_121);
    let environment = declared("observer See(x)\n");
    let context = Context::new(&environment.assumptions, &environment.definitions, &[]);
    let mut text = String::from("observer See(x)\n");
    let (mut asked, mut later) = (0, 0);
    for round in 0..200 {
        let parts: Vec<String> = (0..2 + dice.place(2))
            .map(|number| {
                let atoms: Vec<String> = (0..1 + dice.place(3)).map(|_| atom(&mut dice, number)).collect();
                // In half of them something is communicated first.
                let first = ["In_a<y> ; ", "Out_{a,2} ; "].get(number).filter(|_| round % 2 == 0).unwrap_or(&"");
                let own = format!("Set_1<y> ; {first}{} ; See_y", atoms.join(" ; "));
                let own = own.replace("<y>", &format!("<y{number}>")).replace("y}", &format!("y{number}}}"));
                let own =
                    own.replace("See_y", &format!("See_y{number}")).replace("Point(y)", &format!("Point(y{number})"));
                own.replace("<z>", &format!("<z{number}>")).replace("<w>", &format!("<w{number}>"))
            })
            .collect();
        let network = format!("new a. new b. new c. ({})", parts.join(" | "));
        let left = term(&environment, &network);
        let Ok(draws) = Draws::of(&left, &context) else { continue };
        let right = concluded(&environment, &left, (&draws, &context));
        later += usize::from(right.to_string().contains("Abort"));
        asked += 1;
        text.push_str(&format!("compare {left} ~ {right} weak\n"));
    }
    let (told, yes) = compared(&text);
    println!("{asked} networks, {later} that communicate before they draw, {yes} found alike");
    assert!(asked > 40 && later > 15 && yes * 10 > asked * 8, "{asked} {later} {yes}\n{told}");
}

const MISSIONS: &str = "observer At(r), See(x)\nparam a, b, s > 0\nproc Tick = Out_{c,0} ; Tick\nproc Tock = Out_{d,0} ; Tock\n\
    proc Gate_r = (Delay_1 # At_r) ; (Ran_{Normal(a, sd: s)}<e> | In_c<u>) ; (Gtr_{e,0} ; Set_1<z> | Lte_{e,0} ; Set_{-1}<z>) ; Gate_{r+z}\n\
    proc Walk_r = (Delay_1 # At_r) ; (Ran_{Normal(0, sd: 1)}<e> | In_c<u>) ; Walk_{r+e}\n\
    proc Most_r = (Delay_1 # At_r) ; In_c<u> ; (Ran_{Exp(rate: 1)}<e> | Ran_{Exp(rate: 1)}<f>) ; (Gtr_{e,f} ; Set_1<z> | Lte_{e,f} ; Set_{-1}<z>) ; Most_{r+z}\n\
    proc Fork_r = (Delay_1 # At_r) ; (Ran_{Uniform(0,1)}<e> | In_c<u>) ; (Gtr_{e,1/2} ; Ran_{Uniform(0,1)}<f> | Lte_{e,1/2} ; Ran_{Exp(rate: 1)}<f>) ; Fork_{r+f}\n\
    proc Wait_r = ((Ran_{Uniform(1,2)}<e> ; Delay_e ; Set_e<z>) # At_r) ; In_c<y> ; Wait_{r+z}\n\
    proc Stay = Ran_{Mix(1/2: Point(1), 1/2: Uniform(1,2))}<e> ; Delay_e ; Gtr_{e,1} ; Stay\nproc Again_r = Stay ; (Delay_1 # At_r) ; In_c<y> ; Again_{r+1}\n\
    proc Sure_r = (Delay_1 # At_r) ; (Ran_{Mix(1/2: Point(2), 1/2: Point(2))}<e> | In_c<u>) ; (Eq_{e,2} ; Set_1<z> | Neq_{e,2} ; Set_{-1}<z>) ; Sure_{r+z}\n\
    proc Then_r = (Delay_1 # At_r) ; In_c<u> ; Ran_{Normal(0, sd: 1)}<e> ; Ran_{Normal(e, sd: 1)}<f> ; Then_{r+f}\n\
    proc Also_r = (Delay_1 # See_r) ; In_d<u> ; Ran_{Normal(0, sd: 1)}<g> ; Also_{r+g}\n\
    proc Twice_r = (Delay_1 # At_r) ; In_c<u> ; Ran_{Normal(0, sd: 1)}<e> ; In_c<u> ; Ran_{Normal(e, sd: 1)}<f> ; Twice_{r+f}\n\
    proc Gives_r = (Delay_1 # At_r) ; In_c<u> ; Ran_{Normal(0, sd: 1)}<e> ; In_c<u> ; Ran_{Normal(e, sd: 1)}<f> ; Out_{g,f} ; Gives_{r+f}\n\
    proc Takes_r = (Delay_1 # See_r) ; In_d<u> ; Ran_{Normal(0, sd: 1)}<h> ; In_g<y> ; Ran_{Normal(y, sd: 1)}<k> ; Takes_{r+k}\n\
    proc Ends = (Delay_1 # See_0) ; Ran_{Uniform(1,2)}<e> ; Delay_e ; Set_e<z>\n";

/// What is said of the ways of a system of these.
fn ways(system: &str, more: &str) -> String {
    let folder = tempfile::tempdir().expect("a folder");
    let script = folder.path().join("drawn.pars");
    let text = format!("{}system Sys = {system}\nperiod Sys\n{more}\n", MISSIONS);
    std::fs::write(&script, text).expect("written");
    let ran = std::process::Command::new(env!("CARGO_BIN_EXE_pars")).arg("run").arg(&script).output().expect("it runs");
    format!("{}{}", String::from_utf8_lossy(&ran.stdout), String::from_utf8_lossy(&ran.stderr))
}

#[test]
fn the_ways_of_phases_that_draw_are_theorems() {
    for (system, count) in [
        ("Gate_0 | Tick", 3),
        ("Walk_0 | Walk_1 | Tick", 2),
        ("Most_0 | Tick", 3),
        ("Fork_0 | Tick", 3),
        ("Wait_0 | Tick", 2),
        ("Again_0 | Tick", 7),
        ("Sure_0 | Tick", 3),
        ("Then_0 | Tick", 2),
        ("Then_0 | Also_0 | Tick | Tock", 2),
        ("Twice_0 | Also_0 | Tick | Tock", 2),
        ("Most_0 | Also_0 | Tick | Tock", 3),
    ] {
        let told = ways(system, "");
        assert!(told.contains(&format!("by the kernel: all {count} ways")), "{system}: {told}");
    }
    // One draws again before the other has drawn, and what that draws next waits for it.
    let told = ways("Gives_0 | Takes_0 | Tick | Tock", "");
    assert!(
        told.contains("by the kernel: 1 of 2 ways") && told.contains("the order in which parts communicate"),
        "{told}"
    );
    let told = ways("Ends", "");
    assert!(told.contains("it draws, and may stop") || told.contains("a random draw"), "{told}");
}

#[test]
fn what_is_drawn_anew_in_each_round_has_a_mean_and_no_closed_form() {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/cases/periods/draws.pars");
    let ran = std::process::Command::new(env!("CARGO_BIN_EXE_pars")).arg("run").arg(script).output().expect("it runs");
    let told = String::from_utf8_lossy(&ran.stdout).into_owned();
    for line in told.lines().filter(|line| line.contains(" closed ") || line.contains(" mean ")) {
        let form = line.split_once(" = ").map_or(line, |(_, form)| form);
        assert!(!form.contains('~'), "{line}: one value for all rounds");
    }
    // Of r' = r/2+(1+e)*t with E(e) = 1/8+3/4*(k+1)/2 and k = k0+n, by hand.
    let mean = "mean      r = 3/2*t+3/4*k0*t+3/4*n*t+1/4*(1/2)^n*(4*r0-6*t-3*k0*t) from n = 0";
    assert!(told.contains(mean) && told.contains("closed    k = k0+n from n = 0"), "{told}");
    let means = |system: &str| {
        let (_, told) = told.split_once(&format!(": flow {system}\n")).unwrap_or_else(|| panic!("{system}: {told}"));
        told.split(": flow ").next().unwrap_or(told).contains(" mean ")
    };
    assert!(means("Chains") && means("Drifts"), "{told}");
    assert!(!means("Ends") && !means("Grows") && !means("Coins"), "{told}");
}

#[test]
fn what_always_holds_of_draws_need_not_trust_the_phases() {
    for (system, claim) in [("Sure_0 | Tick", "r >= 0"), ("Fork_0 | Tick", "r >= 0")] {
        let told = ways(system, &format!("prove Sys always {claim} when At_r"));
        assert!(told.contains("proved: Sys always") && !told.contains("on trust"), "{system}: {told}");
    }
    // Where the kernel does not follow, the trust stays.
    let told = ways("Sure_0 | Gives_0 | Takes_0 | Tick | Tock", "prove Sys always r >= r when At_r");
    assert!(!told.contains("proved: Sys always") || told.contains("on trust: that the phases"), "{told}");
}

#[test]
fn a_draw_is_written_in_a_proof_file_and_read_back() {
    let file = |names: &str, right: &str| {
        let network = "new c. (In_c<y> ; Ran_{Normal(y, var: 1)}<x> ; (Delay_1 # See_x) ; Idle | Out_{c,2} ; Idle)";
        let text = format!(
            "{{\"format\":\"pars-proof-1\",\n\"theory\":{{\"declarations\":\"observer See(x)\\n\",\"rules\":\"\"}},\n\
            \"claim\":{{\"left\":\"{network}\",\"connective\":\"~~\",\"right\":\"{right}\"}},\n\
            \"steps\":[{{\"step\":\"draw\",\"network\":\"{network}\",\"names\":[{names}]}}],\n"
        );
        pars::proof_file::check_file(&pars::proof_file::sealed(text.as_bytes()))
    };
    let then = "Ran_{Normal(2, var: 1)}<e> ; new c. (Set_e<x> ; (Delay_1 # See_x) ; Idle | Idle)";
    let whole = format!("new c. (In_c<e> ; Abort | Out_{{c,0}}) ; {then}");
    let found = file("\"e\"", &whole).unwrap_or_else(|wrong| panic!("{wrong}"));
    assert!(found.to_string().contains(" ~~ ") && !found.to_string().contains("on trust"), "{found}");
    assert!(file("\"e\"", then).is_err() && file("", &whole).is_err() && file("\"e\",\"f\"", &whole).is_err());
    assert!(file("\"e~1\"", &whole).is_err() && file("\"?e\"", &whole).is_err() && file("\"y\"", &whole).is_err());
}
