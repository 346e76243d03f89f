//! What always holds: refuted with a run, proved by an invariant or by the whole run, the condition where it is missing.

use pars::connectivity::connectivity;
use pars::invariant::{Claim, Duty, check, check_states};
use pars::lower::{ClaimKind, Environment, Lowered};
use pars::name::Name;
use pars::parser::{parse, parse_value};
use pars::period::Test;
use pars::replay::{Drawn, replays};
use pars::safety::{Asked, Outcome, Verdict, always, orbit};
use pars::value::{Relation, Value};

const ROBOT: &str = "
observer At(r), Rock(q)
proc Env_r        = (Delay_t # Odo_r # Obs_d # At_r # Rock_d) ; In_v<u> ; Env_{r+u*t}
proc Odo_r        = Out_{p,r} ; Odo_r
proc Obs_q        = Out_{b,q} ; Obs_q
proc Sensor_c     = (In_b<q> | In_p<r>) ; ((Lte_{|r-q|,c} ; Out_{n,q}) | (Gtr_{|r-q|,c} ; Out_{n,r+2*c})) ; Sensor_c
proc MoveTo_{g,h} = (In_p<r> | In_n<q>) ; Neq_{r,g}
                  ; ((Gtr_{|r-q|,h} ; Out_{v,s(g-r)}) | (Lte_{|r-q|,h} ; Out_{v,s(r-q)})) ; MoveTo_{g,h}
";

/// The declarations, and the last claim with its system.
fn load(text: &str) -> (Environment, Name, Claim) {
    let parsed = parse(text);
    assert!(parsed.diagnostics.is_empty(), "{:?}", parsed.diagnostics);
    let mut environment = Environment::default();
    let mut batch = environment.open(&parsed.items, text);
    let mut last = None;
    for (index, item) in parsed.items.iter().enumerate() {
        match environment.step(&mut batch, index, item) {
            Ok(Lowered::Claim(claim)) => last = Some(claim.kind),
            Ok(_) => {}
            Err(errors) => panic!("{errors:?}"),
        }
    }
    let Some(ClaimKind::Always { system, pattern, .. }) = last else { panic!("no claim") };
    let test = |(relation, left, right): (Relation, Value, Value)| Test { relation, left, right };
    let tests = pattern.conditions.into_iter().map(test).collect();
    (environment, system, Claim { shown: pattern.terms, variables: pattern.variables, tests })
}

fn judged(text: &str) -> Outcome {
    let (environment, name, claim) = load(text);
    let system = environment.system(&name).expect("a system");
    let term = system.term(&environment.definitions);
    let (definitions, assumptions) = (&environment.definitions, &environment.assumptions);
    let components = &system.components;
    always(
        &term,
        Asked {
            components,
            claim: &claim,
            definitions,
            assumptions,
            instances: &|_| Vec::new(),
            interrupted: &|| false,
        },
    )
}

/// The paper's set-up with numbers: from 0 towards 10 by half steps, an obstacle at 5.
fn with_margin(margin: &str, claim: &str) -> String {
    format!(
        "param d = 5, t = 1/2\nfn s(e) = if e > 0 then 1 else -1\n{ROBOT}
system Sys = Env_0 | Sensor_3 | MoveTo_{{10,{margin}}}
prove Sys always {claim} when At_p, Rock_o"
    )
}

#[test]
fn a_margin_of_more_than_one_is_not_enough() {
    let Verdict::Refuted(run) = judged(&with_margin("6/5", "|p-o| > 1")).verdict else { panic!("not refuted") };
    let last: Vec<String> = run.shown.iter().rev().take(2).map(|(time, shown)| format!("{time} {shown:?}")).collect();
    assert!(last[1].contains("At, [7/2]") && last[0].starts_with("4 ") && last[0].contains("At, [4]"), "{last:?}");
}

#[test]
fn a_run_replays_with_its_own_draws_alone() {
    let text = |draw: &str| {
        format!(
            "observer At(r)
proc Env_r = (Delay_1 # At_r) ; (Ran_{{{draw}}}<e> | In_v<u>) ; Env_{{r+u+e}}
proc Still = Out_{{v,0}} ; Still
system Sys = Env_0 | Still
prove Sys always p <= 3 when At_p"
        )
    };
    for draw in
        ["Normal(1, sd: 2)", "Uniform(0,2)", "Exp(rate: 1)", "Poisson(rate: 1)", "Mix(1/2: Point(1), 1/2: Point(-1))"]
    {
        let (environment, name, _) = load(&text(draw));
        let system = environment.system(&name).expect("a system").term(&environment.definitions);
        let Verdict::Refuted(run) = judged(&text(draw)).verdict else { panic!("{draw} is not refuted") };
        let again = |drawn: &[Drawn]| replays(&system, &environment.definitions, &run.shown, drawn);
        assert!(again(&run.drawn), "{draw}: {run:?}");
        assert!(!again(&run.drawn[1..]) && !again(&[]), "{draw}");
        // Another value leads elsewhere, and what is never drawn nowhere.
        for (top, bottom) in [(1, 3), (-7, 1), (5, 2)] {
            let mut forged = run.drawn.clone();
            forged[0].values = vec![Value::rational(num_rational::BigRational::new(top.into(), bottom.into()))];
            assert!(!again(&forged), "{draw} {top}/{bottom}");
        }
    }
    // Never more than 3/2 in all, as the noise shrinks: nothing is refuted by what is not drawn.
    let shrinking = "observer At(r)
proc Env_{r,s} = (Delay_1 # At_r) ; (Ran_{Uniform(0,1)}<e> | In_v<u>) ; Env_{r+u+e*s,s/2}
proc Still = Out_{v,0} ; Still
system Sys = Env_{0,1} | Still
prove Sys always p < 2 when At_p";
    assert!(!matches!(judged(shrinking).verdict, Verdict::Refuted(_)));
}

#[test]
fn the_least_distance_is_found_and_is_exact() {
    let outcome = judged(&with_margin("3/2", "|p-o| >= 3/2"));
    assert!(matches!(&outcome.verdict, Verdict::Proved(safe) if safe.trusted().is_empty()), "{:?}", outcome.verdict);
    assert_eq!(outcome.extreme.as_deref(), Some("the least abs(o-p) in the whole run is 3/2"));
    assert!(matches!(judged(&with_margin("3/2", "|p-o| > 3/2")).verdict, Verdict::Refuted(_)));
}

fn symbolic(assumed: &str) -> String {
    format!(
        "param t > 0, v > 0, d, h > 0, c >= h + v*t, r0, r0 < d - 1, g, g > d{assumed}
fn s(e) = if e > 0 then v else -v\n{ROBOT}
system Sys = Env_r0 | Sensor_c | MoveTo_{{g,h}}
prove Sys always |p-o| > 1 when At_p, Rock_o"
    )
}

#[test]
fn the_weakest_condition_is_one_plus_a_step() {
    let outcome = judged(&symbolic(""));
    assert!(matches!(outcome.verdict, Verdict::Open));
    let conditions: Vec<String> =
        outcome.conditions.iter().map(|tests| tests.iter().map(Test::to_string).collect::<String>()).collect();
    assert_eq!(conditions, ["h >= t*v+1"]);
}

#[test]
fn with_the_condition_an_invariant_is_checked() {
    let text = symbolic(", h >= 1 + v*t");
    let outcome = judged(&text);
    assert!(matches!(&outcome.verdict, Verdict::Proved(safe) if safe.inequalities() > 10 && safe.trusted().len() == 1));
    // The same invariant is turned away where it is weakened, strengthened, or one phase is missing.
    let (environment, _, claim) = load(&text);
    let period = outcome.period.expect("a period");
    let again = |invariant: &[Vec<Test>]| check(&period, &environment.assumptions, &claim, invariant);
    assert!(again(&outcome.invariant).is_ok());
    assert!(again(&outcome.invariant[1..]).is_err());
    let nothing = vec![Vec::new(); period.phases.len()];
    assert!(again(&nothing).is_err());
    let mut stronger = outcome.invariant.clone();
    let variable = Value::variable(&period.phases[0].variables[0]);
    stronger[0].push(Test { relation: Relation::Lss, left: variable, right: Value::variable(&Name::new("r0")) });
    assert!(again(&stronger).is_err());
}

#[test]
fn a_set_of_states_that_is_not_closed_is_turned_away() {
    let (environment, name, claim) = load(&with_margin("3/2", "|p-o| > 1"));
    let system = environment.system(&name).expect("a system").term(&environment.definitions);
    let limits = orbit::Limits { states: 1_000, bits: orbit::MOST_BITS, interrupted: &|| false };
    let orbit::Orbit::Closed(states) =
        orbit::follow(&system, &environment.definitions, &environment.assumptions, &claim, &limits)
    else {
        panic!("not closed")
    };
    let again =
        |states: &[_]| check_states(&system, &environment.definitions, &environment.assumptions, &claim, states);
    assert_eq!(again(&states).expect("closed").states(), states.len());
    for missing in [0, 1, states.len() / 2, states.len() - 1] {
        let mut fewer = states.clone();
        fewer.remove(missing);
        assert!(again(&fewer).is_err(), "without state {missing}");
    }
}

#[test]
fn a_run_that_never_repeats_needs_an_invariant() {
    // r approaches 10 for ever and never comes within 1/2 of 11.
    let text = "observer At(r)
proc Env_r = (Delay_1 # Odo_r # At_r) ; In_v<u> ; Env_{r+u}
proc Odo_r = Out_{p,r} ; Odo_r
proc Go    = In_p<r> ; Out_{v,(10-r)/2} ; Go
system Sys = Env_0 | Go
prove Sys always |p-11| > 1/2 when At_p";
    assert!(matches!(&judged(text).verdict, Verdict::Proved(safe) if safe.inequalities() > 0 && safe.states() == 0));
}

#[test]
fn bounded_noise_is_allowed_for() {
    let text = |bound: &str| {
        format!(
            "observer At(r)
proc Env_r = (Delay_1 # Odo_r # At_r) ; (In_v<u> | Ran_{{Uniform(-1/4,1/4)}}<e>) ; Env_{{r+u+e}}
proc Odo_r = Out_{{p,r}} ; Odo_r
proc Stay  = In_p<r> ; Out_{{v,-r/2}} ; Stay
system Sys = Env_0 | Stay
prove Sys always |p| <= {bound} when At_p"
        )
    };
    // |r| <= b gives |r/2 + e| <= b/2 + 1/4, which is at most b from 1/2 on.
    assert!(matches!(judged(&text("1/2")).verdict, Verdict::Proved(_)));
    // Noise that pushes one way again and again comes as near to 1/2 as is wanted.
    let Verdict::Refuted(run) = judged(&text("2/5")).verdict else { panic!("not refuted") };
    assert!(!run.drawn.is_empty() && !run.shown.is_empty());
}

#[test]
fn only_a_path_through_the_program_counts() {
    let text = |system: &str| {
        format!(
            "param d = 5, t = 1/2\nfn s(e) = if e > 0 then 1 else -1\n{ROBOT}
proc Blind_g = In_p<r> ; Neq_{{r,g}} ; Out_{{v,s(g-r)}} ; Blind_g
proc Look = In_b<q> ; Look
system Sys = {system}
prove Sys always |p-o| > 1 when At_p, Rock_o"
        )
    };
    let connected = |system: &str| {
        let (environment, name, _) = load(&text(system));
        let components = &environment.system(&name).expect("a system").components;
        connectivity(components, &[Name::new("At"), Name::new("Rock")], &environment.definitions)
    };
    let whole = connected("Env_0 | Sensor_3 | MoveTo_{10,2}");
    assert!(whole.connected());
    assert_eq!(whole.paths, ["Rock (Env) -b-> Sensor -n-> MoveTo -v-> At (Env)"]);
    // The paper's wording finds the rock and the odometry connected, through the environment.
    assert!(!connected("Env_0 | Blind_10").connected());
    assert!(!connected("Env_0 | Blind_10 | Look").connected());
    assert!(connected("Env_0 | Blind_10 | Look").dot().contains("\"Env\" -> \"Blind\" [label=\"p\"]"));
    assert!(matches!(judged(&text("Env_0 | Blind_10")).verdict, Verdict::Refuted(_)));
    // In the picture there is a box for each component, and an arrow with its ports for each two that share some.
    let drawn = whole.svg().expect("a picture");
    assert_eq!((drawn.matches("<rect").count(), drawn.matches("marker-end").count()), (3, 4));
    assert!([">Env<", ">Sensor<", ">MoveTo<", ">b, p<", ">n<"].iter().all(|text| drawn.contains(text)), "{drawn}");
    assert_eq!(connected("Env_0").svg(), None);
}

#[test]
fn a_length_is_bounded_by_half_planes_that_bound_it() {
    use pars::assumption::Assumptions;
    use pars::invariant::follows;
    let mut environment = Environment::default();
    let names = "param x, y";
    assert!(environment.declare(&parse(names).items, names).iter().all(Result::is_ok));
    let value = |text: &str| environment.value(&parse_value(text).expect("a value")).expect("a number");
    let test = |relation: Relation, left: &str, right: &str| Test { relation, left: value(left), right: value(right) };
    let nothing = Assumptions::default();
    let length = "sqrt((x-1)^2+(y+2)^2)";
    let farther = |bound: &str| test(Relation::Gtr, length, bound);
    // Along (3/5, 4/5), and less along a direction between two of those that are tried.
    let side = test(Relation::Gtr, "3*x/5+4*y/5+1", "7");
    assert!(follows(&nothing, std::slice::from_ref(&side), &farther("7")));
    assert!(!follows(&nothing, std::slice::from_ref(&side), &farther("71/10")));
    // A square of half the side 2 lies within the circle of 2*sqrt(2) = 2.83, and its corners are outside that of 2.8.
    let square = [
        test(Relation::Lte, "x-1", "2"),
        test(Relation::Gte, "x-1", "-2"),
        test(Relation::Lte, "y+2", "2"),
        test(Relation::Gte, "y+2", "-2"),
    ];
    assert!(follows(&nothing, &square, &test(Relation::Lte, length, "29/10")));
    assert!(!follows(&nothing, &square, &test(Relation::Lte, length, "28/10")));
    assert!(!follows(&nothing, &square[..3], &test(Relation::Lte, length, "29/10")));
    // A length is at least 0, which no half plane says.
    assert!(!follows(&nothing, &[], &farther("0")));
}

#[test]
fn a_name_that_stands_twice_must_be_shown_alike() {
    let (_, _, claim) = load(
        "observer At(r), Rock(q)\nproc P = Delay_1 # At_1 # Rock_2\nsystem Sys = P\nprove Sys always x < 1 when At_x, Rock_x",
    );
    let at = |observer: &str, value: &Value| {
        pars::term::Term::new(pars::term::Node::Observe(Name::new(observer), vec![value.clone()]))
    };
    // The values shown may be called like the names of the claim.
    let shown = Value::variable(&Name::new("x")).add(&Value::one()).expect("a value");
    let duties: Vec<Duty> =
        claim.duties(&[at("At", &shown), at("Rock", &Value::variable(&Name::new("x")))]).expect("duties");
    let [duty] = duties.as_slice() else { panic!("{duties:?}") };
    assert_eq!(duty.premises[0].to_string(), "x+1 = x");
    assert_eq!(duty.tests[0].to_string(), "x+1 < 1");
}

#[test]
fn a_claim_about_what_is_never_shown_says_so() {
    let text = |shown: &str, claim: &str| {
        format!(
            "observer At(r), Rock(q)\nproc Go_r = {shown} ; Go_{{r+1}}\nproc Back_r = {shown} ; Back_{{-r}}
system On = Go_0 | Delay_1\nsystem Turn = Back_1 | Delay_1\nprove {claim}"
        )
    };
    let together = "(Delay_1 # At_r # Rock_{r+9})";
    let apart = "(Delay_1 # At_r) ; (Delay_1 # Rock_r)";
    for (system, shown, speaks) in [
        ("On", "(Delay_1 # At_r)", Some(false)),
        ("On", apart, Some(false)),
        ("On", together, None),
        ("Turn", "(Delay_1 # At_r)", Some(false)),
        ("Turn", apart, Some(false)),
        ("Turn", together, Some(true)),
    ] {
        let outcome = judged(&text(shown, &format!("{system} always o - p >= 9 when At_p, Rock_o")));
        assert_eq!(outcome.speaks, speaks, "{system}: {shown}");
        assert!(matches!(outcome.verdict, Verdict::Proved(_)), "{system}: {shown}");
    }
}

/// `b < a` would prove anything of a number between a and b.
#[test]
fn a_condition_under_which_nothing_can_be_drawn_is_none() {
    let outcome = judged(
        "param a, b\nobserver Seen(x)
proc Flat = Ran_{Uniform(a,b)}<x> ; (Delay_1 # Seen_x) ; In_c<y> ; Flat
proc Tick = Out_{c,0} ; Tick
system Sys = Flat | Tick
prove Sys always x <= b-1 when Seen_x",
    );
    assert!(matches!(outcome.verdict, Verdict::Open), "{:?}", outcome.verdict);
    assert_eq!(outcome.conditions, Vec::<Vec<Test>>::new());
}
