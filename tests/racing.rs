//! Whether the communications of one instant may come in another order and lead elsewhere is told whatever the order in which
//! the components are written: no period is printed where it matters.

use std::collections::BTreeMap;

use pars::lower::{Entity, Environment};
use pars::name::Name;
use pars::parser::parse;
use pars::period::{Failure, analyse};

mod dice;
mod model_orders;
use dice::Dice;
use model_orders::order_matters;

/// A world that is sensed while it is moved, and whoever senses it, moves it, or is stopped and starts again.
fn parts(dice: &mut Dice) -> (String, Vec<String>) {
    let mut text = "observer At(r), Look(q), Seen(q), Mons(q)\n".to_string();
    let time = |dice: &mut Dice| dice.one_of(&["1", "1", "2", "1/2", "3/2"]);
    let world = dice.one_of(&[
        "(Delay_1 # Odo_r # At_r) ; (In_v<u> # Odo_r # At_r) ; World_{r+u}",
        "(Delay_1 # Odo_r # At_r) ; In_v<u> ; World_{r+u}",
        "(Delay_1 # Odo_r # At_r) ; (In_v<u> # Odo_r) ; World_{r+u}",
        "((In_v<u> ; Delay_1) # Odo_r # At_r) ; World_{r+u}",
        "(In_v<u> # Odo_r) ; (Delay_1 # At_r # Odo_r) ; World_{r+u}",
    ]);
    text += &format!("proc World_r = {world}\nproc Odo_r = Out_{{p,r}} ; Odo_r\n");
    let (one, other) = (time(dice), time(dice));
    let program = match dice.place(6) {
        0 => "Out_{v,1} ; Out_{v,-1} ; Prog".to_string(),
        1 => format!("Delay_{{{one}}} ; Out_{{v,1}} ; Delay_{{{other}}} ; Out_{{v,-1}} ; Prog"),
        2 => "In_p<x> ; ((Lss_{x,2} ; Out_{v,1}) | (Gte_{x,2} ; Out_{v,-2})) ; Prog".to_string(),
        3 => "Out_{v,1} ; In_p<z> ; Out_{v,-z} ; Prog".to_string(),
        4 => "Out_{v,0} ; Prog".to_string(),
        _ => "In_p<x> ; Out_{v,2-x} ; Prog".to_string(),
    };
    text += &format!("proc Prog = {program}\n");
    let mut names = vec!["World_0".to_string(), "Prog".to_string()];
    if dice.place(3) > 0 {
        let time = time(dice);
        text += &format!("proc Cam_q = (Delay_{{{time}}} # Look_q) ; In_p<w> ; Cam_w\n");
        names.push("Cam_0".to_string());
    }
    if dice.place(3) == 0 {
        let time = time(dice);
        text += &format!("proc Log_y = (Delay_{{{time}}} # Seen_y) ; In_p<w> ; Log_w\n");
        names.push("Log_0".to_string());
    }
    if dice.place(4) == 0 {
        let (short, long) = (time(dice), dice.one_of(&["2", "3", "5/2"]));
        text += &format!(
            "proc Mon = (In_stop<s> # Feed) ; Mon\nproc Feed = In_p<m> ; (Mons_m # In_p<k>) ; (Delay_{{{short}}} # Mons_k) ; Feed\n\
             proc Btn = Delay_{{{long}}} ; Out_{{stop,1}} ; Btn\n"
        );
        names.extend(["Mon".to_string(), "Btn".to_string()]);
    }
    (text, names)
}

#[test]
fn a_race_is_told_whatever_the_order_of_the_components() {
    let mut dice = Dice(2_026);
    let mut counts: BTreeMap<&'static str, usize> = BTreeMap::new();
    for _ in 0..400 {
        let (text, mut names) = parts(&mut dice);
        let mut told = Vec::new();
        for _ in 0..3 {
            for place in (1..names.len()).rev() {
                names.swap(place, dice.place(place + 1));
            }
            let text = format!("{text}system Sys = {}\n", names.join(" | "));
            let parsed = parse(&text);
            let mut environment = Environment::default();
            let mut batch = environment.open(&parsed.items, &text);
            for (index, item) in parsed.items.iter().enumerate() {
                environment.step(&mut batch, index, item).expect("an item");
            }
            let Some(Entity::System(system)) = environment.entity(&Name::new("Sys")) else { panic!("no system") };
            let found = analyse(&system.components, &environment.definitions, &environment.assumptions);
            let whole = system.alone(&environment.definitions);
            let matters = order_matters(&whole, &environment.definitions, 40);
            let race = |failure: &Failure| matches!(failure, Failure::KillRace { .. } | Failure::Contention { .. });
            let verdict = match &found {
                Ok(_) => "period",
                Err(failures) if failures.iter().any(race) => "race",
                Err(_) => "none",
            };
            assert_ne!((verdict, matters), ("period", true), "{text}");
            // One that is stopped and starts again may come to the same, and yet more or less has passed.
            assert!(verdict != "race" || matters || text.contains("Mon"), "{text}");
            told.push(verdict);
            *counts.entry(verdict).or_default() += 1;
        }
        assert!(told.iter().all(|one| *one == told[0]), "{text}{told:?}");
    }
    println!("{counts:?}");
    assert!(
        ["period", "race"].iter().all(|verdict| counts.get(verdict).is_some_and(|count| *count > 100)),
        "{counts:?}"
    );
}
