//! What the kernel concludes of random networks agrees with the model: several readers and writers, results that pass
//! through `|`, `#` and `else`, tests of parameters, delays of no time, copies by a count, vectors, ports named twice.

use pars::advance::{Instant, stretch};
use pars::fact::Context;
use pars::kernel::{Theory, check};
use pars::law::Connective;
use pars::library;
use pars::lower::Environment;
use pars::parser::{parse, parse_term};
use pars::proof::{Proof, Statement, Step, carried_on};
use pars::prove::run::runs;
use pars::refute::{Limits, Refutation, refute};
use pars::substitution::substitute_values;
use pars::term::{Node, Term};
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

/// A text in which this component has result names of its own.
fn with_own_names(text: &str, number: usize) -> String {
    let letters: Vec<char> = text.chars().collect();
    let beside = |place: Option<usize>| place.and_then(|at| letters.get(at)).is_some_and(|one| one.is_alphanumeric());
    let mut renamed = String::new();
    for (place, letter) in letters.iter().enumerate() {
        renamed.push(*letter);
        if "yvw".contains(*letter) && !beside(place.checked_sub(1)) && !beside(Some(place + 1)) {
            renamed.push_str(&number.to_string());
        }
    }
    renamed
}

/// A network of components that may all end, each with what it has bound.
fn ending_network(dice: &mut Dice) -> Option<(String, Environment, Term)> {
    let mut text = PROCESSES.to_string();
    let mut parts = Vec::new();
    for number in 0..1 + dice.place(3) {
        let atoms: Vec<String> = (0..1 + dice.place(4)).map(|_| atom(dice, 1)).collect();
        let last = dice.one_of(&["(Delay_1 # See_1)", "Delay_2 ; Set_y<v>", "Delay_1 ; Lte_{y,1}", "Up_0 ; Set_2<w>"]);
        let body = with_own_names(&format!("Set_1<y> ; {} ; {last}", atoms.join(" ; ")), number);
        text.push_str(&format!("proc C{number}_x = {body}\n"));
        let call = format!("C{number}_{}", dice.one_of(&["1", "2", "k"]));
        parts.push(match dice.place(4) {
            0 => format!("({call} # Delay_{})", dice.one_of(&["1", "2", "3"])),
            1 => format!("({call} else Set_3<z{number}>)"),
            _ => call,
        });
    }
    let mut environment = library::standard().ok()?;
    let parsed = parse(&text);
    if !parsed.diagnostics.is_empty() || environment.declare(&parsed.items, &text).iter().any(Result::is_err) {
        return None;
    }
    let written = parse_term(&format!("new a. new b. new c. new d. ({})", parts.join(" | "))).ok()?;
    let term = environment.part(&written).ok()?;
    Some((text, environment, term))
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
    /// How many came to an end.
    ended: usize,
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
        let limits = Limits { instances: 2, choices: 200, cost: 12, pairs: 1_500, ..Limits::default() };
        let (definitions, assumptions) = (&environment.definitions, &environment.assumptions);
        match refute(&network, &right, Connective::Weak, &[], definitions, assumptions, &limits) {
            Refutation::None { instances, meaningless, open, .. } if instances > meaningless + open => count.same += 1,
            Refutation::None { .. } => count.unknown += 1,
            Refutation::Refuted(found) => {
                panic!("{text}{network}\n  ~~ {right}\n{:?} with {:?}", found.run, found.values)
            }
        }
        network = match time.and_then(|time| instant.after(&time, &context).ok()) {
            Some(next) if matches!(next.node(), Node::New(..)) => next,
            Some(_) => {
                count.ended += 1;
                return;
            }
            None => return,
        };
    }
}

#[test]
fn what_is_concluded_of_random_networks_holds_in_the_model() {
    let number = |name: &str, usual: u64| std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(usual);
    let mut dice = Dice(number("PARS_SEED", 20_121_014));
    let mut count = Count { same: 0, unknown: 0, refused: 0, unread: 0, ended: 0 };
    for _ in 0..number("PARS_ROUNDS", 500) {
        match network(&mut dice) {
            Some((text, environment, start)) => follow(&text, &environment, start, &mut dice, &mut count),
            None => count.unread += 1,
        }
    }
    let Count { same, unknown, refused, unread, .. } = count;
    println!("{same} hold, {unknown} were not decided, {refused} refused, {unread} not read");
    assert!(same > 100 && unknown < same, "{same} {unknown} {refused} {unread}");
}

#[test]
fn what_is_concluded_of_random_networks_that_end_holds_in_the_model() {
    let mut dice = Dice(20_121_015);
    let mut count = Count { same: 0, unknown: 0, refused: 0, unread: 0, ended: 0 };
    for _ in 0..500 {
        match ending_network(&mut dice) {
            Some((text, environment, start)) => follow(&text, &environment, start, &mut dice, &mut count),
            None => count.unread += 1,
        }
    }
    let Count { same, unknown, refused, unread, ended } = count;
    println!("{same} hold, {unknown} were not decided, {refused} refused, {unread} not read; {ended} ended");
    assert!(same > 100 && unknown < same && ended > 20, "{same} {unknown} {refused} {unread} {ended}");
}

/// A process with values that move on from turn to turn, in a network of its own.
fn moving_network(dice: &mut Dice) -> Option<(String, Environment, Term)> {
    let mut text = "observer See(x)\nproc Serve_x = Out_{a,x} ; Serve_x\n".to_string();
    let mut parts = Vec::new();
    for number in 0..1 + dice.place(2) {
        let atoms: Vec<String> = (0..1 + dice.place(3))
            .map(|_| {
                dice.one_of(&[
                    "(Delay_1 # See_x)",
                    "(Delay_2 # At_{2-x} # See_1)",
                    "Delay_1",
                    "(Delay_1 # At_3)",
                    "In_a<y> ; (Delay_1 # At_y)",
                    "(Gtr_{x,-5} ; Delay_1 | Lte_{x,-5} ; (Delay_2 # At_x))",
                    "(Delay_1 # loop(Out_{b,x}))",
                    "(Delay_{1+x-x} # See_{x+1})",
                ])
            })
            .collect();
        let next = dice.one_of(&["x/2+1", "x+1", "1-x/2", "x-2", "2*x+1", "x", "-x", "x/2", "x+x*x"]);
        text.push_str(&format!("proc C{number}_x = {} ; (Delay_1 # At_x) ; C{number}_{{{next}}}\n", atoms.join(" ; ")));
        parts.push(format!("C{number}_{}", dice.one_of(&["0", "1", "2", "3/2"])));
    }
    let mut environment = library::standard().ok()?;
    let parsed = parse(&text);
    if !parsed.diagnostics.is_empty() || environment.declare(&parsed.items, &text).iter().any(Result::is_err) {
        return None;
    }
    let written = parse_term(&format!("new a. new b. ({} | Serve_1 | Idle)", parts.join(" | "))).ok()?;
    let term = environment.part(&written).ok()?;
    Some((text, environment, term))
}

/// A process with one value that moves on, and the run that carries it on by name.
fn carried_network(dice: &mut Dice) -> Option<(String, Environment, Term, Term)> {
    let atoms: Vec<String> = (0..1 + dice.place(3))
        .map(|_| {
            dice.one_of(&["(Delay_1 # See_X)", "(Delay_2 # At_{2-X} # See_1)", "Delay_1", "(Delay_1 # At_{i+X})^{i<2}"])
        })
        .collect();
    let next = dice.one_of(&["X/2+1", "1-X/2", "X/3-1", "2*X+1", "-X/2"]);
    let start = dice.one_of(&["0", "1", "5/2"]);
    let round = format!("{} ; (Delay_1 # At_X)", atoms.join(" ; "));
    let text = format!("observer See(x)\nproc C_x = {round} ; C_{{{next}}}\n").replace('X', "x");
    let run = format!("Set_{start}<w> ; loop({round} ; Set_{{{next}}}<w>)").replace('X', "w");
    let mut environment = library::standard().ok()?;
    let parsed = parse(&text);
    if !parsed.diagnostics.is_empty() || environment.declare(&parsed.items, &text).iter().any(Result::is_err) {
        return None;
    }
    let network = environment.part(&parse_term(&format!("(C_{{{start}}} | Idle)")).ok()?).ok()?;
    let run = environment.part(&parse_term(&run).ok()?).ok()?;
    Some((text, environment, network, run))
}

/// The shape of a term: it with 0 for all values.
fn shape(term: &Term) -> Term {
    let bare = term.map_values(&mut |_| Ok::<_, ()>(Value::zero())).unwrap_or_else(|()| term.clone());
    if term.children().is_empty() { bare } else { bare.with_children(term.children().map(shape).collect()) }
}

/// The run up to where states of one shape come again twice, and from there a loop that shows what is the same in both.
fn run_with_a_loop(network: &Term, context: &Context<'_>) -> Option<Term> {
    let mut stretches: Vec<(Value, Vec<Term>)> = Vec::new();
    let mut states = Vec::new();
    let mut now = network.clone();
    for _ in 0..40 {
        let instant = Instant::of(&now, context).ok()?;
        let time = least(&instant, context)?;
        states.push(shape(&instant.network()));
        now = instant.after(&time, context).ok()?;
        stretches.push((time, instant.shown()));
    }
    let again = |from: usize, turn: usize| {
        (from..from + 2 * turn).all(|at| states[at] == states[at + turn] && stretches[at].0 == stretches[at + turn].0)
    };
    let (from, turn) =
        (0..12).flat_map(|from| (1..9).map(move |turn| (from, turn))).find(|(from, turn)| again(*from, *turn))?;
    let body = (from..from + turn).map(|at| {
        let kept = stretches[at].1.iter().filter(|one| stretches[at + turn].1.contains(one));
        stretch(&stretches[at].0, &kept.cloned().collect::<Vec<_>>())
    });
    let prefix = stretches[..from].iter().map(|(time, shown)| stretch(time, shown));
    Some(Term::seq(prefix.chain([Term::new(Node::Loop(Term::seq(body)))])))
}

/// What is concluded of turns that are other than what was found: mostly nothing.
fn forged(proof: &Proof, dice: &mut Dice) -> Option<Proof> {
    let mut proof = proof.clone();
    let step = proof.steps.iter().find(|step| matches!(step, Step::Turns { .. }))?.clone();
    let Step::Turns { lemma, mut turn, mut moving } = step else { return None };
    let change = dice.one_of(&["1", "-1", "1/2", "0"]).parse::<num_rational::BigRational>().ok()?;
    let change = Value::rational(change);
    match (dice.place(4), moving.first_mut()) {
        (0, Some(one)) => one.start = one.start.add(&change).ok()?,
        (1, Some(one)) => one.next = one.next.add(&change).ok()?,
        (2, Some(one)) => one.next = one.next.mul(&change).ok()?,
        (3, Some(_)) => {
            moving.pop();
        }
        _ => turn = Term::seq([turn, Term::delay(Value::one())]),
    }
    let starts = moving.iter().map(|one| (one.variable.clone(), one.start.clone())).collect();
    let statement = proof.lemmas.get(lemma)?.statement.clone();
    let left = substitute_values(&statement.left, &starts).ok()?;
    let right = carried_on(&turn, &moving).ok()?;
    proof.statement = Statement { hypotheses: vec![], left, connective: Connective::WeaklyRefines, right };
    proof.steps = vec![Step::Turns { lemma, turn, moving }];
    Some(proof)
}

#[test]
fn turns_that_move_on_are_what_random_networks_do() {
    let mut dice = Dice(20_121_016);
    let (mut found, mut moved, mut held, mut turned_down) = (0, 0, 0, 0);
    for round in 0..150 {
        let carried = if round % 3 == 0 { carried_network(&mut dice) } else { None };
        let (text, environment, network, carried) = match carried {
            Some((text, environment, network, run)) => (text, environment, network, Some(run)),
            None => match moving_network(&mut dice) {
                Some((text, environment, network)) => (text, environment, network, None),
                None => continue,
            },
        };
        let theory = Theory {
            assumptions: environment.assumptions.clone(),
            definitions: environment.definitions.clone(),
            laws: environment.laws.clone(),
        };
        let context = Context::new(&theory.assumptions, &theory.definitions, &[]);
        let Some(run) = carried.or_else(|| run_with_a_loop(&network, &context)) else { continue };
        let Ok(proof) = runs(&theory, (&network, &run), &[]) else { continue };
        let mut judge = |statement: &Statement| {
            let limits = Limits { instances: 1, choices: 200, cost: 12, pairs: 400, ..Limits::default() };
            let (definitions, assumptions) = (&environment.definitions, &environment.assumptions);
            let (left, right) = (&statement.left, &statement.right);
            match refute(left, right, statement.connective, &[], definitions, assumptions, &limits) {
                Refutation::Refuted(found) => {
                    panic!("{text}{left}\n  {:?} {right}\n{:?}", statement.connective, found.run)
                }
                Refutation::None { .. } => held += 1,
            }
        };
        if let Err(wrong) = check(&theory, &proof) {
            panic!("{text}{network} and {run}: {:?}", wrong.reason);
        }
        found += 1;
        judge(&proof.statement);
        for _ in 0..3 {
            let Some(forged) = forged(&proof, &mut dice) else { break };
            moved += 1;
            match check(&theory, &forged) {
                Ok(_) => judge(&forged.statement),
                Err(_) => turned_down += 1,
            }
        }
    }
    println!("{found} runs found, {moved} forged, {turned_down} of them turned down; {held} hold");
    assert!(found > 40 && moved > 40 && turned_down * 4 > moved, "{found} {moved} {turned_down}");
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

#[test]
fn runs_that_end_and_turns_that_move_on_are_proved_with_nothing_on_trust() {
    for case in
        ["followed", "drained", "tolerance", "inside_turn", "coupled", "rounds", "unknowns", "ends", "branches", "line"]
    {
        let script = format!("{}/tests/cases/missions/{case}.pars", env!("CARGO_MANIFEST_DIR"));
        let ran =
            std::process::Command::new(env!("CARGO_BIN_EXE_pars")).arg("run").arg(script).output().expect("it runs");
        let told = String::from_utf8_lossy(&ran.stdout);
        assert!(
            told.contains("proved: ") && !told.contains("on trust: that the system runs as printed"),
            "{case}: {told}"
        );
        assert!(!told.contains("the kernel could not follow the run"), "{case}: {told}");
    }
}
