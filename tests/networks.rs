//! What the kernel concludes of random networks agrees with the model: several readers and writers, results that pass
//! through `|`, `#` and `else`, tests of parameters, delays of no time, copies by a count, vectors, ports named twice.

use pars::advance::Instant;
use pars::fact::Context;
use pars::law::Connective;
use pars::library;
use pars::lower::Environment;
use pars::parser::{parse, parse_term};
use pars::refute::{Limits, Refutation, refute};
use pars::term::Term;
use pars::value::{Relation, Value};

mod dice;
use dice::Dice;

const PROCESSES: &str = "observer See(x)\nparam t > 1, k >= 1, k <= 2, none : natural, none <= 0, some : natural, some >= 2, some < 3\n\
    proc Gone_x = In_a<z> ; Neq_{z,x} ; Out_{b,z} ; Gone_x\nproc Up_x = Delay_1 ; Lss_{x,2} ; Up_{x+1}\n\
    proc Both_x = In_a<z> ; (Delay_x # At_z) ; (Eq_{z,x} ; Set_1<w> | Neq_{z,x} ; Set_x<w>) ; Out_{b,w} ; Both_w\n\
    proc Serve_x = Out_{a,x} ; Serve_x\nproc Wait_x = (Delay_x # Serve_x # At_x) ; Wait_x\n\
    proc Ask_x = In_a<z> ; (Gtr_{z,x} ; Delay_1 ; Ask_z | Lte_{z,x} ; Ask_{x-1})\n";

/// What binds w, of which nothing else is known.
fn binder(dice: &mut Dice) -> String {
    let port = dice.one_of(&["a", "b"]);
    dice.one_of(&[
        "(Eq_{y,k} ; Set_1<w> | Neq_{y,k} ; Set_2<w>)",
        "(Eq_{y,1} ; In_a<w> | Neq_{y,1} ; Set_y<w>)",
        "(In_a<w> # (In_b<v> ; Abort))",
        "(Set_1<w> | Delay_1)",
        "((Delay_x ; Set_y<w>) # See_1 # loop(In_PORT<v>))",
        "((In_b<w> ; Eq_{w,1}) else Set_2<w>)",
        "((Set_1<w> ; Lss_{y,2}) else (Set_3<w> ; Delay_1))",
        "Set_3<w> ; (Set_{w+1}<w>)^some",
        "(Set_1<w> # Idle)",
        "(In_PORT<w> | Delay_1)",
    ])
    .replace("PORT", &port)
}

/// One thing that a component may do; y has been bound before.
fn atom(dice: &mut Dice, depth: usize) -> String {
    let port = dice.one_of(&["a", "a", "b", "c"]);
    let value = dice.one_of(&["1", "2", "y", "x", "k"]);
    let plain = match dice.place(16) {
        0 | 1 => format!("In_{port}<y>"),
        2 | 3 => format!("Out_{{{port},{value}}}"),
        4 => format!("Delay_{}", dice.one_of(&["0", "1", "x", "k", "{y-y}", "{max(y-1,0)}", "t"])),
        5 => format!("(Delay_{} # At_y # See_{value})", dice.one_of(&["0", "1", "2", "k"])),
        6 => format!("(Delay_1 # loop(Out_{{{port},{value}}}) # See_y)"),
        7 => format!("{} ; Out_{{{port},w}}", binder(dice)),
        8 => format!("{} ; (Delay_1 # See_w)", binder(dice)),
        9 => format!(
            "({})^{{i<{}}}",
            dice.one_of(&["Delay_1 # At_i", "In_a<y>", "Out_{a,i}"]),
            dice.one_of(&["none", "some", "2"])
        ),
        10 => format!("{}_{{y,{value}}}", dice.one_of(&["Eq", "Neq", "Lte", "Gtr"])),
        11 => dice.one_of(&["Gone_1", "Gone_y", "Up_0", "Up_y", "Ask_1"]),
        12 => "In_d<v> ; (Delay_1 # See_v)".to_string(),
        13 => format!("Out_{{d,{}}}", dice.one_of(&["(1,2)", "(y,1)", "(x,y)"])),
        14 => "In_d<v> ; (Eq_{v,(1,2)} ; Delay_1 | Neq_{v,(1,2)} ; (Delay_1 # See_v))".to_string(),
        _ => format!("(Delay_1)^{}", dice.one_of(&["none", "some", "0"])),
    };
    if depth == 0 || dice.place(3) > 0 {
        return plain;
    }
    let part = |dice: &mut Dice| format!("({} ; {})", atom(dice, depth - 1), atom(dice, depth - 1));
    match dice.place(7) {
        0 => format!("({} # {})", part(dice), part(dice)),
        1 => format!("({} # See_1 # Delay_{})", part(dice), dice.one_of(&["0", "1", "2", "k"])),
        2 => format!("try({})", part(dice)),
        3 => format!("(Gtr_{{k,y}} ; {} | Lte_{{k,y}} ; {})", part(dice), part(dice)),
        4 => format!("({} else {})", part(dice), part(dice)),
        5 => format!("({} | {})", part(dice), part(dice)),
        _ => format!("({} ; {})", part(dice), plain),
    }
}

/// A network of components that go round, helpers beside them, and a world that never ends.
fn network(dice: &mut Dice) -> Option<(String, Environment, Term)> {
    let mut text = PROCESSES.to_string();
    let mut parts = Vec::new();
    for number in 0..1 + dice.place(3) {
        let atoms: Vec<String> = (0..1 + dice.place(4)).map(|_| atom(dice, 1)).collect();
        let again = dice.one_of(&["1", "2", "y", "k"]);
        let start = dice.one_of(&["1", "2", "k", "x"]);
        text.push_str(&format!("proc C{number}_x = Set_{start}<y> ; {} ; C{number}_{{{again}}}\n", atoms.join(" ; ")));
        parts.push(format!("C{number}_{}", dice.one_of(&["1", "2", "k"])));
    }
    for _ in 0..dice.place(3) {
        parts.push(dice.one_of(&["Both_1", "Both_k", "Wait_1", "Wait_2", "Serve_1", "Ask_2", "Gone_2 ; Idle"]));
    }
    let mut environment = library::standard().ok()?;
    let parsed = parse(&text);
    if !parsed.diagnostics.is_empty() || environment.declare(&parsed.items, &text).iter().any(Result::is_err) {
        return None;
    }
    // A port named twice is the inner one.
    let ports = dice.one_of(&["new a. new b. new c. new d.", "new a. new d. new c. new b. new a."]);
    let written = parse_term(&format!("{ports} ({} | Idle)", parts.join(" | "))).ok()?;
    let term = environment.part(&written).ok()?;
    Some((text, environment, term))
}

/// The time until the first delay runs out, if that is known.
fn least(instant: &Instant, context: &Context<'_>) -> Option<Value> {
    let below = |one: &Value, other: &Value| context.assumptions.decide(Relation::Lss, one, other) == Some(true);
    instant.delays().into_iter().reduce(|least, left| if below(&left, &least) { left } else { least })
}

struct Count {
    same: usize,
    unknown: usize,
    refused: usize,
    unread: usize,
}

fn follow(text: &str, environment: &Environment, start: Term, dice: &mut Dice, count: &mut Count) {
    let context = Context::new(&environment.assumptions, &environment.definitions, &[]);
    let mut network = start;
    for _ in 0..4 {
        let Ok(instant) = Instant::of(&network, &context) else {
            count.refused += 1;
            return;
        };
        let least = least(&instant, &context);
        let half = least.as_ref().and_then(|time| time.div(&Value::integer(2)).ok());
        let time = match dice.place(8) {
            0 => Some(Value::zero()),
            1 => half,
            _ => least,
        };
        let Ok(right) = instant.onward(time.as_ref(), &context) else { return };
        let limits = Limits { instances: 2, choices: 200, cost: 12, pairs: 1_500 };
        let (definitions, assumptions) = (&environment.definitions, &environment.assumptions);
        match refute(&network, &right, Connective::Weak, &[], definitions, assumptions, &limits) {
            Refutation::None { instances, meaningless, open, .. } if instances > meaningless + open => count.same += 1,
            Refutation::None { .. } => count.unknown += 1,
            Refutation::Refuted(found) => {
                panic!("{text}{network}\n  ~~ {right}\n{:?} with {:?}", found.run, found.values)
            }
        }
        network = match time.and_then(|time| instant.after(&time, &context).ok()) {
            Some(next) => next,
            None => return,
        };
    }
}

#[test]
fn what_is_concluded_of_random_networks_holds_in_the_model() {
    let number = |name: &str, usual: u64| std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(usual);
    let mut dice = Dice(number("PARS_SEED", 20_121_014));
    let mut count = Count { same: 0, unknown: 0, refused: 0, unread: 0 };
    for _ in 0..number("PARS_ROUNDS", 500) {
        match network(&mut dice) {
            Some((text, environment, start)) => follow(&text, &environment, start, &mut dice, &mut count),
            None => count.unread += 1,
        }
    }
    let Count { same, unknown, refused, unread } = count;
    println!("{same} hold, {unknown} were not decided, {refused} refused, {unread} not read");
    assert!(same > 100 && unknown < same, "{same} {unknown} {refused} {unread}");
}

#[test]
fn a_variable_of_a_phase_may_be_called_like_a_name_that_is_bound() {
    let folder = tempfile::tempdir().expect("a folder");
    let script = folder.path().join("called_alike.pars");
    let text = "proc Odo_r = Out_{p,r} ; Odo_r\n\
        proc Env_r = (Delay_{1/2} # At_r # Odo_r) ; In_v<u> ; Env_{r+u/2}\n\
        proc Go = In_p<r> ; (Gtr_{abs(r-5),1.2} ; Set_1<u> | Lte_{abs(r-5),1.2} ; Set_{-1}<u>) ; Out_{v,u} ; Go\n\
        system Sys = Env_0 | Go\nperiod Sys\n";
    std::fs::write(&script, text).expect("written");
    let ran = std::process::Command::new(env!("CARGO_BIN_EXE_pars")).arg("run").arg(&script).output().expect("it runs");
    let told = String::from_utf8_lossy(&ran.stdout);
    assert!(told.contains("by the kernel: all 3 ways"), "{told}");
}
