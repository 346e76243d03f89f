//! What the kernel says to networks that draw, and what such networks are made of.
#![allow(dead_code)]

use pars::advance::draw::Draws;
use pars::fact::Context;
use pars::kernel::{Reason, Thm, check};
use pars::law::Connective;
use pars::lower::Environment;
use pars::name::Name;
use pars::proof::{Proof, Statement, Step};
use pars::term::Term;

use super::dice::Dice;
use super::texts::{condition, declared, term, theory};

pub const DECLARED: &str = "param t > 0, k\nobserver See(x)\nproc World_r = (Delay_t # At_r) ; (Ran_{Normal(0, var: 1)}<w> | In_v<u>) ; World_{r+u+w}\n\
    proc Push = Out_{v,1} ; Push\nproc Late_r = (Delay_1 # At_r) ; In_v<u> ; Ran_{Normal(u, var: 1)}<w> ; Late_{r+w}\n";

pub fn names(all: &[&str]) -> Vec<Name> {
    all.iter().map(|name| Name::new(name)).collect()
}

pub fn judged(
    environment: &Environment,
    when: &[&str],
    (left, right): (&Term, &Term),
    steps: Vec<Step>,
) -> Result<Thm, Reason> {
    let hypotheses = when.iter().map(|text| condition(environment, text)).collect();
    let statement = Statement { hypotheses, left: left.clone(), connective: Connective::Weak, right: right.clone() };
    check(&theory(environment), &Proof::new(statement, steps)).map_err(|rejected| rejected.reason)
}

/// What the kernel says to a network that draws under these names; the claim is `left ~~ right`.
pub fn drawn(network: &str, under: &[&str], right: &str) -> Result<Thm, Reason> {
    let environment = declared(DECLARED);
    let (left, right) = (term(&environment, network), term(&environment, right));
    judged(&environment, &[], (&left, &right), vec![Step::Draw(left.clone(), names(under))])
}

#[track_caller]
pub fn accepted(network: &str, under: &[&str], right: &str) {
    if let Err(reason) = drawn(network, under, right) {
        panic!("{network}: {reason} {reason:?}");
    }
}

#[track_caller]
pub fn refused(network: &str, under: &[&str], because: &str) {
    match drawn(network, under, "Idle") {
        Err(Reason::Advance(why)) => assert!(why.contains(because), "{network}: {why}"),
        other => panic!("{network}: {other:?}"),
    }
}

#[track_caller]
pub fn differs(network: &str, under: &[&str], right: &str) {
    match drawn(network, under, right) {
        Err(Reason::Differ(..)) => {}
        other => panic!("{network}: {other:?}"),
    }
}

/// What a network that draws is weakly equal to, with names of our own for what is drawn; the kernel says so too.
#[track_caller]
pub fn concluded(environment: &Environment, left: &Term, (draws, context): (&Draws, &Context<'_>)) -> Term {
    let under: Vec<Name> = (0..draws.due().len()).map(|number| Name::new(&format!("e{number}"))).collect();
    let right = draws.made(&under, context).expect("the draws are made");
    let found = judged(environment, &[], (left, &right), vec![Step::Draw(left.clone(), under)]);
    assert!(found.is_ok(), "{left}: {found:?}");
    right
}

/// What `pars run` says to these lines of `compare … weak`, and how many it answers with yes; none with no.
pub fn compared(text: &str) -> (String, usize) {
    let folder = tempfile::tempdir().expect("a folder");
    let script = folder.path().join("drawn.pars");
    std::fs::write(&script, text).expect("written");
    let ran = std::process::Command::new(env!("CARGO_BIN_EXE_pars")).arg("run").arg(&script).output().expect("it runs");
    let told = String::from_utf8_lossy(&ran.stdout).into_owned();
    let yes = told.lines().filter(|line| line.trim_start().starts_with("yes:")).count();
    assert!(!told.contains(" no: "), "{told}");
    (told, yes)
}

/// One thing that a component does; y has been bound before.
pub fn atom(dice: &mut Dice, number: usize) -> String {
    let port = dice.one_of(&["a", "b", "c"]);
    let coin = dice.one_of(&["Mix(1/2: Point(1), 1/2: Point(2))", "Mix(1/3: Point(y), 2/3: Point(3))", "Point(1)"]);
    match dice.place(9) {
        0 | 1 => format!("Ran_{{{coin}}}<y>"),
        2 | 3 => format!("In_{port}<y>"),
        4 | 5 => format!("Out_{{{port},{}}}", dice.one_of(&["1", "y", "2"])),
        6 => "(Delay_1 # See_y)".to_string(),
        7 => format!("(Ran_{{{coin}}}<y> | In_{port}<z>)"),
        _ => format!("((Ran_{{{coin}}}<w> ; Idle) # Delay_1 # See_{number})"),
    }
}
