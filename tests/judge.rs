//! Every law in `rules/` is judged by the executable meaning.

use std::path::{Path, PathBuf};

use pars::law::Law;
use pars::library;
use pars::lower::{ClaimKind, Environment, Lowered};
use pars::name::Name;
use pars::parser::parse;
use pars::refute::{Limits, Refutation, judge, refute};
use pars::term::{Node, Term};
use pars::value::Value;

#[test]
fn every_law_in_the_rules_stands() {
    let folder = std::env::var_os("PARS_RULES").map(PathBuf::from);
    let folder = folder.unwrap_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("rules"));
    let mut files: Vec<_> = std::fs::read_dir(folder).expect("rules").flatten().map(|entry| entry.path()).collect();
    files.retain(|path| path.extension().is_some_and(|extension| extension == "rules"));
    files.sort();
    let instances = std::env::var("PARS_INSTANCES").ok().and_then(|text| text.parse().ok()).unwrap_or(3_000);
    let limits = Limits { instances, choices: 100 * instances, ..Limits::default() };
    let (mut failed, mut judged) = (Vec::new(), 0);
    for file in files {
        let text = std::fs::read_to_string(&file).expect("a rule file");
        let parsed = parse(&text);
        let mut environment = Environment::new();
        let prelude = "observer At(r)\n";
        environment.declare(&parse(prelude).items, prelude);
        let lowered = environment.declare(&parsed.items, &text);
        for problem in lowered.into_iter().filter_map(Result::err) {
            failed.push(format!("{}: {problem:?}", file.display()));
        }
        for law in environment.laws.iter() {
            judged += 1;
            match judge(law, &limits) {
                Refutation::Refuted(found) => failed.push(format!("{}: {found:?}", law.name)),
                Refutation::None { cost, instances, meaningless, open, .. } => {
                    println!("{}: {instances} up to {cost}, {meaningless} meaningless, {open} open", law.name);
                    if instances == meaningless {
                        failed.push(format!("{}: nothing tried", law.name));
                    }
                }
            }
        }
    }
    assert!(failed.is_empty(), "{} of {judged}:\n{}", failed.len(), failed.join("\n\n"));
    assert!(judged > 0);
}

/// A context with its hole filled.
type Context = (&'static str, fn(Term) -> Term);

fn contexts() -> Vec<Context> {
    vec![
        ("[] ; (Delay_1 # Seen(7)) ; Abort", |hole| {
            Term::seq([hole, Term::disable([Term::delay(Value::integer(1)), seen(7)]), Term::abort()])
        }),
        ("[] ; Out_{k,7}", |hole| Term::seq([hole, out(Value::integer(7))])),
        ("[] ; Out_{k,y}", |hole| Term::seq([hole, out(Value::variable(&"y".into()))])),
        ("Set_5<y> ; []", |hole| Term::seq([Term::new(Node::Set(Value::integer(5), "y".into())), hole])),
        ("Delay_1 ; []", |hole| Term::seq([Term::delay(Value::integer(1)), hole])),
        ("[] | Delay_1", |hole| Term::par([hole, Term::delay(Value::integer(1))])),
        ("[] | (Out_{k,7} ; Delay_1 ; Abort)", |hole| {
            Term::par([hole, Term::seq([out(Value::integer(7)), Term::delay(Value::integer(1)), Term::abort()])])
        }),
        ("[] # Delay_1", |hole| Term::disable([hole, Term::delay(Value::integer(1))])),
        ("[] # (Delay_1 ; Abort)", |hole| {
            Term::disable([hole, Term::seq([Term::delay(Value::integer(1)), Term::abort()])])
        }),
        ("[] else Delay_1", |hole| Term::otherwise(hole, Term::delay(Value::integer(1)))),
        ("Abort else []", |hole| Term::otherwise(Term::abort(), hole)),
        ("loop(Delay_1 ; [])", |hole| Term::new(Node::Loop(Term::seq([Term::delay(Value::integer(1)), hole])))),
        ("new c. []", |hole| Term::new(Node::New("c".into(), hole))),
        ("[]^2", |hole| Term::new(Node::Power(hole, Value::integer(2), None))),
        ("[] to {A}", |hole| Term::new(Node::Project(hole, [Name::new("A")].into()))),
    ]
}

fn seen(number: i64) -> Term {
    Term::new(Node::Observe("Seen".into(), vec![Value::integer(number)]))
}

fn out(value: Value) -> Term {
    Term::new(Node::Out("k".into(), value))
}

#[test]
fn every_law_stands_in_every_context() {
    let environment = library::standard().expect("the standard laws");
    let limits = Limits { instances: 60, choices: 6_000, ..Limits::default() };
    let (mut wrong, mut compared) = (Vec::new(), 0);
    for law in environment.laws.iter() {
        let mut own = 0;
        for (name, context) in contexts() {
            let inside = Law { left: context(law.left.clone()), right: context(law.right.clone()), ..(**law).clone() };
            match judge(&inside, &limits) {
                Refutation::Refuted(found) => {
                    wrong.push(format!("{} in {name}: {} and {}", law.name, found.left, found.right))
                }
                Refutation::None { instances, meaningless, .. } => own += instances - meaningless,
            }
        }
        assert!(own > 0, "{} was tried in no context", law.name);
        compared += own;
    }
    println!("{compared} instances in contexts");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_law_of_the_table_stands() {
    let mut environment = library::standard().expect("the standard laws");
    let text = include_str!("cases/laws/hold.pars");
    let lowered = environment.declare(&parse(text).items, text);
    let limits = Limits { instances: 600, choices: 60_000, ..Limits::default() };
    let (mut wrong, mut judged) = (Vec::new(), 0);
    for claim in lowered.into_iter().flatten() {
        let Lowered::Claim(claim) = claim else { continue };
        let ClaimKind::Compare { left, right, connective, when, .. } = &claim.kind else { continue };
        judged += 1;
        let (definitions, assumptions) = (&environment.definitions, &environment.assumptions);
        match refute(left, right, *connective, when, definitions, assumptions, &limits) {
            Refutation::Refuted(found) => wrong.push(format!("{}: {} and {}", claim.text, found.left, found.right)),
            Refutation::None { instances, meaningless, .. } if instances == meaningless => {
                wrong.push(format!("{}: tried on nothing", claim.text));
            }
            Refutation::None { .. } => {}
        }
    }
    assert!(judged > 100, "only {judged} laws in the table");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
