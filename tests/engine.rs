//! From a network to a verdict: the missions of the paper, and others.

use pars::lower::{Entity, Environment};
use pars::name::Name;
use pars::parser::parse;
use pars::period::{self, Failure, Period};
use pars::value::Value;
use pars::verify::{self, Outcome, Rounds, Verdict};

fn load(text: &str) -> Environment {
    let text = format!("observer At(r)\n{text}");
    let parsed = parse(&text);
    assert!(parsed.diagnostics.is_empty(), "{:?}", parsed.diagnostics);
    let mut environment = Environment::default();
    let mut batch = environment.open(&parsed.items, &text);
    for (index, item) in parsed.items.iter().enumerate() {
        if let Err(errors) = environment.step(&mut batch, index, item) {
            panic!("{errors:?}");
        }
    }
    environment
}

fn period_of(text: &str) -> Result<Period, Vec<Failure>> {
    let environment = load(text);
    let Some(Entity::System(system)) = environment.entity(&Name::new("Sys")) else { panic!("no system") };
    period::analyse(&system.components, &environment.definitions, &environment.assumptions)
}

const ROBOT: &str = "
proc BF_{a,b}  = MoveTo_a ; MoveTo_b ; BF_{a,b}
proc MoveTo_g  = In_p<r> ; Neq_{r,g} ; Out_{v,s(g-r)} ; MoveTo_g
proc DEnv_r    = (Delay_t # Odo_r # At_r) ; In_v<u> ; DEnv_{r+u*t}
proc Odo_r     = Out_{p,r} ; Odo_r
";

fn outcome_of(text: &str) -> Outcome {
    let environment = load(text);
    let system = environment.system(&Name::new("Sys")).expect("no system").clone();
    let goal = Name::new("Goal");
    let property = environment.property(&goal).expect("no property").clone();
    let outcome = verify::verify(
        &system.components,
        (&goal, property.body.as_ref().unwrap()),
        &environment.definitions,
        &environment.assumptions,
        &|| false,
    );
    println!("{:?}\nfirst {:?}\nsteady {:?}", outcome.verdict, outcome.values, outcome.steady);
    for leg in &outcome.legs {
        println!("  phase {} {:?} from {:?} {:?} {:?}", leg.phase, leg.rounds, leg.start, leg.closed, leg.conditions);
    }
    if let (Some(run), Some(property)) = (&outcome.trajectory_term, &outcome.property_term) {
        println!("{run}\n  <= {property}");
    }
    println!("{:?} {:?}", outcome.endless, outcome.diagnostics);
    outcome
}

fn values(outcome: &Outcome) -> String {
    let text = |map: &std::collections::BTreeMap<Name, Value>| {
        map.iter().map(|(name, value)| format!("{name}={value}")).collect::<Vec<_>>().join(" ")
    };
    format!("{} / {}", text(&outcome.values), text(&outcome.steady))
}

fn proved(outcome: &Outcome) -> bool {
    matches!(outcome.verdict, Verdict::Proved)
}

fn refuted(outcome: &Outcome) -> String {
    match &outcome.verdict {
        Verdict::Refuted { reason, .. } => reason.clone(),
        other => panic!("{other:?}"),
    }
}

fn open(outcome: &Outcome) -> String {
    match &outcome.verdict {
        Verdict::Open { remaining } => remaining.join("; "),
        other => panic!("{other:?}"),
    }
}

const GOAL: &str = "property Goal = Delay_{?t1} ; (Delay_{?t2} # At_a) ; Delay_{?t3} ; Goal\n";

fn rounds(outcome: &Outcome) -> Vec<String> {
    outcome
        .legs
        .iter()
        .map(|leg| match &leg.rounds {
            Rounds::Count(count) => count.to_string(),
            Rounds::Forever(_) => "for ever".to_string(),
        })
        .collect()
}

#[test]
fn dead_beat() {
    let outcome = outcome_of(&format!(
        "param t > 0, p0, a, b, a != b, p0 != a\nfn s(d) = d / t\n{ROBOT}\nsystem Sys = DEnv_{{p0}} | BF_{{a,b}}\n{GOAL}"
    ));
    assert!(proved(&outcome));
    assert_eq!(values(&outcome), "?t1=t ?t2=t ?t3=0 / ?t1=t ?t2=t ?t3=0");
}

#[test]
fn same_goals() {
    let outcome = outcome_of(&format!(
        "param t > 0, p0, a, b, p0 != a\nfn s(d) = d / t\n{ROBOT}\nsystem Sys = DEnv_{{p0}} | BF_{{a,b}}\n{GOAL}"
    ));
    assert!(open(&outcome).contains("in no time"), "{}", open(&outcome));
}

fn numbers(t: &str, s: &str, a: &str, b: &str) -> String {
    format!("param t = {t}, a = {a}, b = {b}\nfn s(d) = {s}\n{ROBOT}\nsystem Sys = DEnv_0 | BF_{{a,b}}\n{GOAL}")
}

#[test]
fn constant_speed() {
    let outcome = outcome_of(&numbers("1/10", "clamp(d/t,-1,1)", "10", "0"));
    assert!(proved(&outcome));
    assert_eq!(values(&outcome), "?t1=10 ?t2=1/10 ?t3=99/10 / ?t1=10 ?t2=1/10 ?t3=99/10");
}

#[test]
fn never_exactly() {
    let outcome = outcome_of(&numbers("1", "d/2", "10", "0"));
    assert!(refuted(&outcome).contains("(1/2)^i") && refuted(&outcome).contains("for no n"), "{}", refuted(&outcome));
    let endless = outcome.endless.expect("nothing keeps the phase going");
    assert!(endless.closest < endless.first, "{endless:?}");
}

#[test]
fn within_a_tolerance() {
    for (k, n) in [("1/2", "7"), ("1/10", "44"), ("1", "1")] {
        let text = numbers("1", &format!("{k}*d"), "10", "0").replace("Neq_{r,g}", "Gtr_{abs(r-g),1/10}");
        let outcome = outcome_of(&text);
        assert_eq!(rounds(&outcome)[0], n);
    }
}

#[test]
fn three_waypoints() {
    let text = numbers("1", "clamp(d,-1,1)", "3", "-1").replace("MoveTo_b ;", "MoveTo_b ; MoveTo_1 ;");
    let outcome = outcome_of(&text);
    assert!(proved(&outcome));
    assert_eq!(rounds(&outcome)[..4], ["3", "4", "2", "2"]);
    assert_eq!(values(&outcome), "?t1=3 ?t2=1 ?t3=5 / ?t1=2 ?t2=1 ?t3=5");
}

#[test]
fn a_mission_that_ends() {
    let text = numbers("1", "clamp(d,-1,1)", "3", "-1").replace("MoveTo_b ; BF_{a,b}", "MoveTo_b");
    let again = outcome_of(&text);
    assert!(refuted(&again).contains("DEnv reads port v"), "{}", refuted(&again));
    let once = outcome_of(&text.replace("Delay_{?t3} ; Goal", "Delay_{?t3}"));
    assert!(proved(&once));
    assert_eq!(values(&once), "?t1=3 ?t2=1 ?t3=0 / ");
    let stays = text.replace("MoveTo_a ; MoveTo_b", "MoveTo_a").replace("In_v<u> ;", "(In_v<u> # At_r) ;");
    let stays = stays.replace("(Delay_{?t2} # At_a) ; Delay_{?t3} ; Goal", "At_a");
    let outcome = outcome_of(&stays);
    assert!(proved(&outcome));
    assert_eq!(values(&outcome), "?t1=3 / ");
}

#[test]
fn a_robot_that_dithers() {
    let outcome = outcome_of(&numbers("1", "if d > 0 then 2 else -2", "3", "-1"));
    assert!(!proved(&outcome));
    println!("{:?}", outcome.verdict);
    assert!(matches!(outcome.verdict, Verdict::Refuted { .. }));
}

#[test]
fn unit_steps_from_the_paper() {
    let outcome = outcome_of(&numbers("1", "clamp(d,-1,1)", "3", "-1"));
    assert!(proved(&outcome));
    assert_eq!(values(&outcome), "?t1=3 ?t2=1 ?t3=3 / ?t1=4 ?t2=1 ?t3=3");
}

#[test]
fn the_three_failures() {
    let apart = period_of(
        "proc A = Delay_1 ; Out_{x,1} ; In_x<y> ; A\nproc B = Delay_1 ; Out_{z,1} ; In_z<y> ; B\nsystem Sys = A | B",
    );
    assert!(matches!(&apart.unwrap_err()[0], Failure::NoCommunication { groups } if groups.len() == 2));
    let silent = period_of("proc A = Delay_1 ; Out_{x,1} ; In_q<y> ; A\nproc B = In_x<y> ; B\nsystem Sys = A | B");
    assert!(silent.unwrap_err()[0].to_string().contains("A reads port q"));
    let unread = period_of("proc A = Delay_1 ; Out_{x,1} ; Out_{q,1} ; A\nproc B = In_x<y> ; B\nsystem Sys = A | B");
    assert!(unread.unwrap_err()[0].to_string().contains("A writes port q"));
    let rates = period_of(
        "proc A = Delay_1 ; Out_{x,1} ; Out_{y,1} ; A\nproc B = In_x<u> ; In_y<w> ; In_y<z> ; B\nsystem Sys = A | B",
    );
    assert!(matches!(&rates.unwrap_err()[0], Failure::RateMismatch { .. }));
    let grows = period_of(
        "param d > 0, e > 0\nproc A = Delay_d ; Out_{x,1} ; A\nproc B = In_x<u> ; B\nproc C = Delay_e ; Out_{y,1} ; C\nproc D = In_y<w> ; D2\nproc D2 = In_x<u> ; D\nsystem Sys = A | B | C | D",
    );
    println!("{:?}", grows.unwrap_err());
}

#[test]
fn balanced_rates() {
    let text = "proc A = Delay_1 ; Out_{x,1} ; A\nproc B = In_x<u> ; In_x<w> ; Delay_1 ; B\nsystem Sys = A | B";
    let (environment, period) = (load(text), period_of(text).unwrap());
    let rounds = period.repetitions(&environment.definitions, &environment.assumptions, &|| false);
    assert_eq!(rounds, Some(vec![("A".to_string(), 2), ("B".to_string(), 1)]));
}

#[test]
fn a_goal_not_met() {
    let outcome = outcome_of(&numbers("1", "clamp(d,-1,1)", "3", "-1").replace("At_a", "At_17"));
    assert!(refuted(&outcome).contains("At_17"));
}

#[test]
fn printed_as_in_the_paper() {
    let text =
        format!("param t > 0, p0, a, b, a != b, p0 != a\nfn s(d)\n{ROBOT}\nsystem Sys = DEnv_{{p0}} | BF_{{a,b}}");
    let period = period_of(&text).unwrap();
    let flows = pars::flow::flows(&period, &load(&text));
    for flow in &flows {
        println!("{}", flow.lines().join("\n"));
    }
    let components = pars::flow::component_periods(&period.components, &load(&text).definitions);
    let lines: Vec<String> = components.iter().flat_map(|one| one.lines()).collect();
    println!("{}", lines.join("\n"));
    assert_eq!(flows.len(), 2);
    assert_eq!(flows[0].guard.iter().flatten().map(|test| test.to_string()).collect::<Vec<_>>(), ["r != a"]);
    assert!(lines.iter().any(|line| line.starts_with("f_DEnv(r) = ")), "{lines:?}");
}

#[test]
fn a_mission_that_waits_first() {
    let text = "param a = 3, b = -1
proc BF_{a,b}  = MoveTo_a ; MoveTo_b ; BF_{a,b}
proc MoveTo_g  = In_p<q> ; Neq_{q,g} ; Out_{v,clamp(g-q,-1,1)} ; MoveTo_g
proc World_x   = (In_v<u> # Odo_x # At_x) ; (Delay_1 # At_x # Log_{x+1}) ; World_{x+u}
proc Odo_x     = Out_{p,x} ; Odo_x
proc Late      = Delay_5 ; BF_{a,b}
system Sys     = World_0 | Late
property Goal  = Delay_{?t1} ; (Delay_{?t2} # At_a # Log_{a+1}) ; Delay_{?t3} ; Goal";
    let text = format!("observer Log(r)\n{text}");
    let outcome = outcome_of(&text);
    assert!(proved(&outcome));
    assert_eq!(values(&outcome), "?t1=8 ?t2=1 ?t3=3 / ?t1=4 ?t2=1 ?t3=3");
}

#[test]
fn a_property_that_is_asked_once_and_has_lengths() {
    let text = numbers("1/2", "clamp(d/t,-1,1)", "3", "-1")
        .replace("(Delay_{?t2} # At_a) ; Delay_{?t3} ; Goal", "(Delay_{1/2} # At_a) ; Delay_{1/4}");
    let outcome = outcome_of(&text);
    assert!(proved(&outcome));
    assert_eq!(values(&outcome), "?t1=3 / ");
    let long = outcome_of(&text.replace("(Delay_{1/2} # At_a)", "(Delay_3 # At_a)"));
    refuted(&long);
}

#[test]
fn a_kill_race() {
    let period = period_of(
        "proc A = (In_x<y> # (Out_{z,1} ; Idle)) ; Delay_1 ; A
proc B = (Out_{x,1} | In_z<u>) ; Delay_1 ; B
system Sys = A | B",
    );
    println!("{period:?}");
    assert!(matches!(&period.unwrap_err()[0], Failure::KillRace { .. }));
}

#[test]
fn two_readers_of_one_write() {
    // Whoever reads, the instant comes to the same, and neither waits for ever.
    let writer = "proc A = Delay_1 ; Out_{x,1} ; A\nproc B = In_x<u> ; B\n";
    let period = period_of(&format!("{writer}proc C = In_x<u> ; C\nsystem Sys = A | B | C"));
    assert!(period.is_ok_and(|period| period.warnings.is_empty()));
    // Of two of which one waits after it has read, the other reads in the meantime, or it does not.
    let period = period_of(&format!("{writer}proc C = In_x<u> ; Delay_{{1/2}} ; C\nsystem Sys = A | B | C"));
    assert!(matches!(&period.unwrap_err()[0], Failure::Contention { .. }));
}

#[test]
fn a_mission_of_states() {
    let text = numbers("1", "clamp(d,-1,1)", "3", "-1")
        .replace(
            "proc BF_{a,b}  = MoveTo_a ; MoveTo_b ; BF_{a,b}",
            "proc There = MoveTo_a ; Back\nproc Back = MoveTo_b ; There",
        )
        .replace("BF_{a,b}", "There");
    let outcome = outcome_of(&text);
    assert!(proved(&outcome));
    assert_eq!(values(&outcome), "?t1=3 ?t2=1 ?t3=3 / ?t1=4 ?t2=1 ?t3=3");
}

#[test]
fn a_goal_that_is_a_parameter() {
    let text = numbers("1", "clamp(d,-1,1)", "3", "-3")
        .replace("proc BF_{a,b}  = MoveTo_a ; MoveTo_b ; BF_{a,b}", "proc Turn_g = MoveTo_g ; Turn_{-g}")
        .replace("BF_{a,b}", "Turn_a");
    let outcome = outcome_of(&text);
    assert!(proved(&outcome));
}

const PROGRAM: &str = "
proc Odo_r = Out_{p,r} ; Odo_r
proc Go_g = In_p<r> ; Neq_{r,g} ; Out_{v,clamp(g-r,-2,2)} ; Go_g
proc Trip = Go_3 ; Go_{-1} ; Trip
property Goal = Delay_{?t1} ; (Delay_{?t2} # At_3) ; Delay_{?t3} ; Goal
";

/// When `At` shows what, up to a time.
fn at_times(stretches: impl Iterator<Item = (Value, Vec<pars::term::Term>)>, until: i64) -> Vec<String> {
    let mut time = Value::zero();
    let mut seen: Vec<String> = Vec::new();
    for (duration, shown) in stretches {
        let shown: Vec<String> = shown.iter().map(ToString::to_string).filter(|text| text.starts_with("At")).collect();
        let line = format!("{time}: {}", shown.join(" "));
        let same = |last: &String| last.split_once(": ").map(|(_, shown)| shown) == Some(shown.join(" ").as_str());
        if !seen.last().is_some_and(same) {
            seen.push(line);
        }
        time = time.add(&duration).unwrap();
        if time.as_rational().unwrap() >= num_rational::BigRational::from_integer(until.into()) {
            break;
        }
    }
    seen
}

#[test]
fn what_a_property_does_not_read_is_left_out_and_the_run_is_still_that_of_the_model() {
    for world in [
        "World_{r,e} = (Delay_1 # Odo_r # At_r # Bat_e) ; In_v<u> ; World_{r+u,e-1}",
        "World_{r,e} = (Delay_1 # Odo_r # At_r # Bat_e) ; In_v<u> ; World_{r+u,e-|u|/3}",
        "World_{r,e} = (Delay_1/2 # Odo_r # At_r) ; (Delay_1/2 # Odo_r # At_r # Bat_e) ; In_v<u> ; World_{r+u,2*e-r}",
    ] {
        let world = world.replace("Delay_1/2", "Delay_{1/2}");
        let text = format!("observer Bat(e)\nproc {world}\n{PROGRAM}\nsystem Sys = World_{{1/2,50}} | Trip");
        let outcome = outcome_of(&text);
        assert!(proved(&outcome), "{world}");
        let environment = load(&text);
        let term = environment.system(&Name::new("Sys")).unwrap().term(&environment.definitions);
        let mut follower = pars::timeline::Follower::new(&term, &environment.definitions);
        follower.follow(120, &|| false);
        let model = follower.run().stretches.iter();
        let model = at_times(model.map(|one| (one.duration.clone().unwrap(), one.shown.clone())), 40);
        let legs = &outcome.legs;
        assert!(outcome.period_term.is_some() && legs.len() < 10, "{world}");
        let mut round = Vec::new();
        for unit in outcome.opening.iter().chain(legs.iter().flat_map(|leg| &leg.units)) {
            let count = match unit {
                verify::Unit::Repeat { count: Some(count), .. } => count.to_string().parse().unwrap(),
                _ => 1i64,
            };
            for number in 0..count {
                round.extend(unit.round(&Value::integer(number)).unwrap());
            }
        }
        let found = at_times(round.iter().map(|one| (one.duration.clone(), one.observed.clone())), 40);
        assert!(found.len() > 4 && model.starts_with(&found), "{world}\n{found:?}\n{model:?}");
    }
}

#[test]
fn what_the_property_reads_is_kept() {
    // Here the program looks at the battery, through what it does to the place.
    let text = format!(
        "observer Bat(e)\nproc World_{{r,e}} = (Delay_1 # Odo_r # At_r # Bat_e) ; In_v<u> ; World_{{r+u+e,e-1}}\n{PROGRAM}\n\
         system Sys = World_{{1/2,50}} | Trip"
    );
    assert!(!proved(&outcome_of(&text)));
}

#[test]
fn reasons_speak_of_what_is_shown() {
    let text = "proc BF_{a,b} = MoveTo_a ; BF_{b,a}\nproc MoveTo_g = In_p<r> ; Neq_{r,g} ; Out_{v,g-r} ; MoveTo_g\n\
        proc Env_r = (Delay_1 # Odo_r # At_r) ; In_v<u> ; Env_{r+u}\nproc Odo_r = Out_{p,r} ; Odo_r\n\
        system Sys = Env_0 | BF_{4,7}\nproperty Goal = Delay_{?t1} ; (Delay_{?t2} # At_5)";
    let outcome = outcome_of(text);
    assert!(refuted(&outcome).ends_with("it is 4 and 7 in turn for ever"), "{}", refuted(&outcome));
    // Equality would stop time here, not end the phase.
    assert_eq!(outcome.endless, None);
}

#[test]
fn who_waits_is_told_of_the_run_and_not_of_a_phase_it_never_comes_to() {
    let mission = |step: &str| {
        format!(
            "proc World_r = (Delay_1 # Odo_r # At_r) ; In_v<u> ; World_{{r+u}}\nproc Odo_r = Out_{{p,r}} ; Odo_r\n\
             proc Go_g = In_p<r> ; Neq_{{r,g}} ; Out_{{v,if r < g then {step} else -{step}}} ; Go_g\n\
             system Sys = World_0 | Go_5\nproperty Goal = Delay_{{?t1}} ; (Delay_{{?t2}} # At_5)"
        )
    };
    let over = outcome_of(&mission("2"));
    assert_eq!(over.diagnostics, Vec::new());
    let endless = over.endless.expect("phase 1 goes on for ever");
    let number = |number: i64| Some(num_rational::BigRational::from_integer(number.into()));
    assert_eq!((endless.closest, endless.first), (number(1), number(5)));
    let there = outcome_of(&mission("1"));
    assert!(matches!(there.diagnostics.as_slice(), [Failure::Unmatched(_)]), "{:?}", there.diagnostics);
    let Ok(period) = period_of(&mission("2")) else { panic!("no period") };
    assert!(matches!(period.warnings.as_slice(), [Failure::MayWait { phases, .. }] if phases == &[1]));
}
