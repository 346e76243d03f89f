//! What items come to, what is refused and in which words, and that print and parse are inverse.

mod common;

use proptest::prelude::*;

use pars::diagnostic::{Source, render_all};
use pars::law::Condition;
use pars::library::{Reader, embedded, standard};
use pars::lower::{By, ClaimKind, Environment, Lowered};
use pars::name::Name;
use pars::parser::{parse, parse_input, parse_term, parse_value};
use pars::term::{Node, Term};
use pars::value::{Relation, Value};

/// What each item comes to; a text of errors for those that are refused.
fn declare(environment: &mut Environment, text: &str) -> Vec<Result<Lowered, String>> {
    let source = Source::new("test.pars", text);
    let parsed = parse_input(text);
    assert!(parsed.diagnostics.is_empty(), "{}", render_all(&parsed.diagnostics, &source, false));
    let shown = |errors: Vec<_>| render_all(&errors, &source, false);
    environment.declare(&parsed.items, text).into_iter().map(|outcome| outcome.map_err(shown)).collect()
}

/// The prelude.
fn start() -> Environment {
    match standard() {
        Ok(environment) => environment,
        Err(failures) => {
            let shown = |failure: &pars::library::Failure| render_all(&failure.diagnostics, &failure.source, false);
            panic!("{}", failures.iter().map(shown).collect::<String>())
        }
    }
}

fn accept(environment: &mut Environment, text: &str) {
    for outcome in declare(environment, text) {
        if let Err(errors) = outcome {
            panic!("{errors}");
        }
    }
}

/// The error of the last item.
fn refuse(text: &str) -> String {
    declare(&mut start(), text).pop().unwrap().unwrap_err()
}

#[test]
fn a_file_that_imports_itself_is_refused() {
    let text = |name: &str| Source::new(name, if name == "a" { "import \"b\"" } else { "import \"a\"" });
    let mut reader = Reader::new(|_, name| Ok(text(name)));
    let failures = reader.read(&mut Environment::new(), &text("a"), &mut |_, _, _, _| {});
    assert_eq!(failures.len(), 1);
    assert_eq!(failures[0].diagnostics[0].message, "`a` imports itself");
    assert_eq!(failures[0].diagnostics[0].notes, ["a imports b imports a"]);
}

#[test]
fn the_paper_system_lowers() {
    let mut environment = start();
    accept(&mut environment, include_str!("../examples/back_and_forth.pars"));
    let recursive: Vec<_> =
        environment.definitions.iter().filter(|one| one.recursive).map(|one| one.name.as_str()).collect();
    assert_eq!(recursive, ["BF", "DEnv", "MoveTo", "Odo"]);
    let system = environment.system(&Name::new("Sys")).unwrap();
    let text = system.term(&environment.definitions).to_string();
    assert_eq!(text, "new p. (new v. (BF_{a,b} | DEnv_p0))");
    let property = environment.property(&Name::new("Goal")).unwrap();
    assert_eq!(property.body.as_ref().unwrap().to_string(), "Delay_?t1 ; (Delay_?t2 # At_a) ; Delay_?t3 ; Goal");
}

#[test]
fn the_other_systems_of_the_paper_lower() {
    for text in [
        "param t > 0, s1, s2
         proc NEnv_{r,q} = (Delay_t # NOdo_q # At_r) ; (Ran_{Normal(0, sd: s1)}<e> | In_v<u>) ; NEnv_{r+(u+e)*t, q+u*t}
         proc NOdo_q = Ran_{Normal(0, sd: s2)}<e> ; Out_{p,q+e} ; NOdo_q",
        "param t > 0, e
         proc Odo_r = Out_{p,r} ; Odo_r
         proc OEnv_r = (Delay_t # Odo_r # At_r) ; (In_v<u> | In_b<q>) ;
             (Neq_{q,r+u*t} ; Set_{r+u*t}<nq> | Eq_{q,r+u*t} ; Set_{q+e}<nq>) ; OEnv_{nq}",
        "param D : distribution, E : distribution
         observer Obj, Rough
         proc ObsGen = Ran_D<x> ; Delay_x ; Obj
         proc TerGen = (Ran_D<t> | Ran_E<d>) ; Delay_t ; (Delay_d # Rough)",
        "param h, fn0
         fn s(d)
         proc Sensor_c = (In_b<q> | In_p<r>) ; Gtr_{|r-q|,c} ; Out_{sp,q} ; Sensor_c
         proc MoveTo_g = (In_p<r> | In_sp<q>) ; Neq_{r,g} ;
             (Gtr_{|r-q|,h} ; Out_{v,s(g-r)} | Lte_{|r-q|,h} ; Out_{v,s(r-q)}) ; MoveTo_g",
        "param p, q > 1
         proc Odo_r = Out_{p,r} ; Odo_r
         proc Obs_r = Out_{b,r} ; Obs_r
         property G = (Odo_p | Obs_{p+q}) ; G",
    ] {
        accept(&mut start(), text);
    }
}

#[test]
fn forward_and_mutual_calls_are_loops() {
    let mut environment = start();
    accept(&mut environment, "proc Even = Delay_1 ; Odd\nproc Odd = Delay_1 ; Even\nproc Once = Even");
    let flags: Vec<_> = environment.definitions.iter().map(|one| (one.name.as_str(), one.recursive)).collect();
    assert_eq!(flags, [("Even", true), ("Odd", true), ("Once", false)]);
}

#[test]
fn a_new_definition_is_reported() {
    let mut environment = start();
    accept(&mut environment, "proc A = Delay_1");
    let again = declare(&mut environment, "proc A = Delay_2").pop().unwrap().unwrap();
    assert!(matches!(again, Lowered::Declared { redefined, .. } if redefined == [Name::new("A")]));
    // A definition with errors leaves the one before in force.
    assert!(declare(&mut environment, "proc A = Delay_y").pop().unwrap().is_err());
    assert_eq!(environment.definitions.get(&Name::new("A")).unwrap().to_string(), "proc A = Delay_2");
}

#[test]
fn constants_are_values_and_assumptions_hold_from_their_line_on() {
    let mut environment = start();
    let parsed = parse("param v = 2, w = v + 1\nparam a, b\nsimplify Delay_{v*w}\nparam a != b");
    let mut batch = environment.open(&parsed.items, "");
    let (a, b) = (Value::variable(&Name::new("a")), Value::variable(&Name::new("b")));
    for (index, item) in parsed.items.iter().enumerate() {
        let before = environment.assumptions.decide(Relation::Neq, &a, &b);
        assert_eq!(before, None);
        let lowered = environment.step(&mut batch, index, item).unwrap();
        if let Lowered::Simplify(term) = lowered {
            assert_eq!(term.to_string(), "Delay_6");
        }
    }
    assert_eq!(environment.assumptions.decide(Relation::Neq, &a, &b), Some(true));
}

#[test]
fn claims_keep_their_parts() {
    let mut environment = start();
    let text = "prove two-steps: ?P ; Delay_1 ; Delay_2 <= ?P ; Delay_3 when never_aborts(?P), ?x >= 0 by delay-sum";
    let Lowered::Claim(claim) = declare(&mut environment, text).pop().unwrap().unwrap() else { panic!() };
    assert_eq!(claim.name, Some(Name::new("two-steps")));
    let ClaimKind::Compare { when, by: By::Laws(laws), .. } = claim.kind else { panic!() };
    assert_eq!(when.iter().map(Condition::to_string).collect::<Vec<_>>(), ["never_aborts(?P)", "?x >= 0"]);
    assert_eq!(laws, [Name::new("delay-sum")]);
    let text = "prove Delay_1 ; Delay_2 ; Stop = Delay_3 by { Delay_1 ; Delay_2 ; Stop = {seq-stop} Delay_1 ; Delay_2 = {} Delay_3 }";
    let outcome = declare(&mut environment, &text.replace("seq-stop", "delay-sum")).pop().unwrap().unwrap();
    let Lowered::Claim(claim) = outcome else { panic!() };
    assert!(matches!(claim.kind, ClaimKind::Compare { by: By::Calc(steps), .. } if steps.len() == 2));
}

#[test]
fn laws_are_judged_when_they_load() {
    let law = |rest: &str| refuse(&format!("law my-law \"Mine.\"\n{rest}"));
    assert!(law("?P = ?P").contains("does not say where it comes from"));
    assert!(law("  ours so\n  ?P ; Stop = ?Q").contains("has `?Q`, which the left side does not bind"));
    assert!(law("  ours so\n  when ?x > 0\n  ?P ; Stop = ?P").contains("a condition of the law `my-law` has `?x`"));
    assert!(law("  ours so\n  ?P ; Stop => ?P ; Stop ; Stop").contains("for ever"));
    assert!(law("  ours so\n  ?P => ?P ; Stop").contains("for ever"));
    assert!(law("  ours so\n  ?P ; ?Q => ?Q ; ?P").contains("for ever"));
    assert!(law("  ours so\n  Out_{?c,?c} = Stop").contains("`?c` is a port, but a value is needed"));
    assert!(refuse("law delay-sum \"Again.\"\n  ours so\n  ?P = ?P").contains("there is a law `delay-sum` already"));
}

#[test]
fn errors_name_the_place_and_a_way_out() {
    let cases = [
        ("simplify Dealy_1", "did you mean `Delay`?"),
        ("simplify Delay", "`Delay` takes 1 parameter, and none was given"),
        ("simplify At_{1,2}", "write `At_x1`"),
        ("simplify Delay_q", "there is no value `q`"),
        ("proc A_p = In_p<x>", "`p` is a value, but a port is needed here"),
        ("proc A = In_c<x> ; Delay_c", "`c` is a port, but a value is needed here"),
        ("proc A = Delay_1 ; A ; Stop", "not as the last thing it does"),
        ("proc A = A else Delay_1", "if it aborted, what follows `else` would have to run"),
        ("proc A = Eq_{1,1} ; A", "can go round without waiting or communicating"),
        ("proc A = In_c<x> | In_d<x>", "`x` is bound on both sides of `|`"),
        ("proc A = (In_c<x> # In_d<y>) ; Delay_x", "`x` is not bound whenever control gets here"),
        ("proc A = (Eq_{1,1} ; Set_1<x> | Set_2<y>) ; Delay_x", "`x` is not bound whenever control gets here"),
        ("proc A_x = Set_1<x>", "`x` is a parameter here, so no result can have this name"),
        ("proc A = ?P", "`?P` stands for any process, which has no place here"),
        ("proc A = Ran_{N(0,1)}<x>", "`N` does not say which spread it means"),
        ("param x > 1, x < 0", "this contradicts what is assumed already"),
        ("simplify Delay_{1/0}", "division by zero"),
        ("period Sys", "there is no system `Sys`"),
        ("prove Stop = Stop by delay-summ", "did you mean `delay-sum`?"),
        ("simplify (Delay_1)^{1/2}", "a process cannot be repeated 1/2 times"),
    ];
    for (text, expected) in cases {
        let shown = refuse(text);
        assert!(shown.contains(expected), "{text}\n{shown}");
        assert!(shown.contains("test.pars:1:"), "{shown}");
    }
    // What looks alike and is fine.
    for text in [
        "proc A = (In_c<x> | In_d<y>) ; Delay_{x+y}",
        "proc A = (Eq_{1,2} ; Set_1<x> | Neq_{1,2} ; Set_2<x>) ; Delay_x",
        "proc A = In_c<c> ; Out_{c,c}",
        "proc A = Delay_1 else A",
        "proc A_x = In_c<y> ; (Gtr_{x,y} ; A_y | Lte_{x,y} ; B_x)\nproc B_x = Delay_1 ; A_x",
    ] {
        accept(&mut start(), text);
    }
}

fn values() -> impl Strategy<Value = Value> {
    let leaf = prop_oneof![
        (-9i64..9).prop_map(Value::integer),
        prop::sample::select(vec!["a", "b", "r", "nq", "?x"]).prop_map(|name| Value::variable(&Name::new(name))),
    ];
    leaf.prop_recursive(3, 8, 2, |inner| {
        let both = (inner.clone(), inner.clone(), 0..7);
        both.prop_map(|(one, other, which)| {
            let made = match which {
                0 => one.add(&other),
                1 => one.sub(&other),
                2 => one.mul(&other),
                3 => one.div(&other),
                4 => Value::maximum(&[one.clone(), other]),
                5 => one.sub(&other).and_then(|value| value.abs()),
                _ => Value::choose(Relation::Lss, &one, &other, &other, &one),
            };
            made.unwrap_or(one)
        })
    })
}

fn terms() -> impl Strategy<Value = Term> {
    let name = || prop::sample::select(vec!["r", "nq", "?y"]).prop_map(Name::new);
    let port = || prop::sample::select(vec!["c", "v", "?k"]).prop_map(Name::new);
    let leaf = prop_oneof![
        Just(Term::stop()),
        Just(Term::abort()),
        Just(Term::idle()),
        values().prop_map(Term::delay),
        (port(), name()).prop_map(|(port, name)| Term::new(Node::In(port, name))),
        (port(), values()).prop_map(|(port, value)| Term::new(Node::Out(port, value))),
        (values(), values()).prop_map(|(one, other)| Term::new(Node::Guard(Relation::Neq, one, other))),
        (values(), name()).prop_map(|(value, name)| Term::new(Node::Set(value, name))),
        values().prop_map(|value| Term::new(Node::Observe(Name::new("At"), vec![value]))),
        (values(), values()).prop_map(|(one, other)| Term::new(Node::Call(Name::new("Two"), vec![one, other]))),
        Just(Term::meta(&Name::new("?P"))),
        values().prop_map(|value| Term::new(Node::Meta(Name::new("?Q"), vec![value]))),
    ];
    leaf.prop_recursive(5, 40, 3, move |inner| {
        let several = || prop::collection::vec(inner.clone(), 2..4);
        prop_oneof![
            several().prop_map(Term::seq),
            several().prop_map(Term::par),
            several().prop_map(Term::disable),
            (inner.clone(), inner.clone()).prop_map(|(one, other)| Term::otherwise(one, other)),
            inner.clone().prop_map(Term::attempt),
            inner.clone().prop_map(|body| Term::new(Node::Loop(body))),
            (inner.clone(), 0i64..4).prop_map(|(body, count)| Term::new(Node::Power(
                body,
                Value::integer(count),
                None
            ))),
            (inner.clone(), name()).prop_map(|(body, index)| {
                Term::new(Node::Power(body, Value::variable(&Name::new("?n")), Some(index)))
            }),
            (inner.clone(), port()).prop_map(|(body, port)| Term::new(Node::New(port, body))),
            inner.clone().prop_map(|body| Term::new(Node::Project(body, [Name::new("At")].into()))),
            (inner.clone(), name(), values())
                .prop_map(|(body, name, value)| Term::new(Node::Replace(body, name, value))),
        ]
    })
}

fn for_terms() -> Environment {
    let mut environment = start();
    accept(&mut environment, "proc Two_{x,y} = Delay_{x+y}");
    environment
}

proptest! {
    #![proptest_config(common::seeded(ProptestConfig::with_cases(2000)))]

    #[test]
    fn values_print_and_parse_back(value in values()) {
        let text = value.to_string();
        let parsed = parse_value(&text).map_err(|errors| TestCaseError::fail(format!("{text}: {errors:?}")))?;
        prop_assert_eq!(for_values().value(&parsed).unwrap(), value, "{}", text);
    }

    #[test]
    fn random_tokens_never_panic(words in prop::collection::vec(prop::sample::select(words()), 0..40)) {
        let text = words.join(" ");
        let parsed = parse_input(&text);
        let _ = Environment::new().declare(&parsed.items, &text);
        let source = Source::new("x", text.clone());
        let _ = render_all(&parsed.diagnostics, &source, true);
        let _ = pars::printer::format(&text);
    }

    #[test]
    fn random_text_never_panics(text in "\\PC{0,60}") {
        let parsed = parse(&text);
        let _ = render_all(&parsed.diagnostics, &Source::new("x", text.clone()), false);
    }

    #[test]
    fn random_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..60)) {
        match Source::from_bytes("x", bytes) {
            Ok(source) => { let _ = parse_input(&source.text); }
            Err(both) => { let _ = both.1.render(&both.0, false); }
        }
    }
}

fn for_values() -> Environment {
    Environment::new()
}

#[test]
fn terms_print_and_parse_back() {
    let environment = for_terms();
    let mut runner = proptest::test_runner::TestRunner::new(common::seeded(ProptestConfig::with_cases(2000)));
    let outcome = runner.run(&terms(), |term| {
        let text = term.to_string();
        let parsed = parse_term(&text).map_err(|errors| TestCaseError::fail(format!("{text}: {errors:?}")))?;
        let back = environment.part(&parsed).map_err(|errors| TestCaseError::fail(format!("{text}: {errors:?}")))?;
        prop_assert_eq!(back, term, "{}", text);
        Ok(())
    });
    outcome.unwrap();
}

/// Pieces of text besides the keywords.
const PIECES: [&str; 42] = [
    "Stop", "Delay", "In", "A", "B", "a", "b", "?P", "?x", "?", "1", "0.5", "\"x", "\"t\"", "_", ",", ";", "|", "#",
    "^", "(", ")", "{", "}", "[", "]", "<", ">", "<=", "=", "=>", ":=", ":", ".", "+", "-", "*", "/", "~~", "<~", "~",
    "where",
];

fn words() -> Vec<&'static str> {
    pars::lexer::Keyword::ALL.iter().map(|(_, word)| *word).chain(PIECES).collect()
}

#[test]
fn the_embedded_files_are_those_of_the_repository() {
    for (name, text) in pars::library::FILES {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(name);
        assert_eq!(std::fs::read_to_string(path).unwrap(), text);
        assert!(embedded(name).is_some());
    }
    let rules = std::fs::read_dir(std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("rules")).unwrap();
    let count =
        rules.filter(|entry| entry.as_ref().unwrap().path().extension().is_some_and(|end| end == "rules")).count();
    assert_eq!(count + 1, pars::library::FILES.len());
}

#[test]
fn every_error_code_is_explained() {
    let mut used = std::collections::BTreeSet::new();
    let mut folders = vec![std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src")];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let text = std::fs::read_to_string(&path).unwrap();
            let codes = text.split('"').filter(|part| part.len() == 5 && part.starts_with('P'));
            used.extend(
                codes.filter(|code| code.bytes().skip(1).all(|byte| byte.is_ascii_digit())).map(str::to_string),
            );
        }
    }
    let explained: std::collections::BTreeSet<String> = pars::codes::all().map(|(code, _)| code.to_string()).collect();
    assert_eq!(used, explained);
}
