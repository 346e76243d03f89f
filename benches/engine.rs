//! Rates and ratios of the engine; each line is a measurement of this run on this machine.

use std::io::Write;
use std::time::{Duration, Instant};

use pars::assumption::Assumptions;
use pars::definition::Definitions;
use pars::kernel::{Theory, check};
use pars::law::Connective;
use pars::library;
use pars::lower::{ClaimKind, Environment, Lowered};
use pars::name::Name;
use pars::proof::Statement;
use pars::prove::{Answer, By, equation, prove};
use pars::rewrite::Limits;
use pars::term::{Node, Term};
use pars::value::{Relation, Value};

fn theory(environment: &Environment) -> Theory {
    Theory {
        assumptions: environment.assumptions.clone(),
        definitions: environment.definitions.clone(),
        laws: environment.laws.clone(),
    }
}

fn timed<T>(work: impl FnOnce() -> T) -> (Duration, T) {
    let start = Instant::now();
    let result = work();
    (start.elapsed(), result)
}

fn proved(theory: &Theory, statement: &Statement) -> (Duration, Option<Duration>) {
    let (finding, answer) = timed(|| prove(theory, statement, &By::Search, Limits::default(), &|| false));
    match answer {
        Answer::Proved(_, proof) => {
            let (checking, verdict) = timed(|| check(theory, &proof));
            (finding, verdict.ok().map(|_| checking))
        }
        Answer::Open(_) => (finding, None),
    }
}

fn laws(environment: &mut Environment) {
    let text = include_str!("../tests/cases/laws/hold.pars");
    let items = pars::parser::parse(text).items;
    let lowered = environment.declare(&items, text);
    let theory = theory(environment);
    let (mut finding, mut checking, mut count) = (Duration::ZERO, Duration::ZERO, 0u32);
    for claim in lowered.into_iter().flatten() {
        if let Lowered::Claim(claim) = claim
            && let ClaimKind::Compare { left, right, connective, when, .. } = claim.kind
            && let (found, Some(checked)) = proved(&theory, &Statement { hypotheses: when, left, connective, right })
        {
            finding += found;
            checking += checked;
            count += 1;
        }
    }
    println!("law table: {count} claims, {:.0} claims a second", f64::from(count) / finding.as_secs_f64());
    println!("kernel: checking takes 1/{:.0} of finding", finding.as_secs_f64() / checking.as_secs_f64());
}

/// An equation family: the claim of each size in our terms, and in Maude's.
struct Family {
    title: &'static str,
    claim: fn(i64) -> (Term, Term),
    maude: fn(i64) -> (String, String),
}

fn observer(number: i64) -> Term {
    Term::new(Node::Observe(Name::new("At"), vec![Value::integer(number)]))
}

fn part(number: i64) -> Term {
    Term::seq([Term::delay(Value::integer(1)), observer(number)])
}

fn out(number: i64) -> Term {
    Term::new(Node::Out(Name::new("c"), Value::integer(number)))
}

fn joined(numbers: impl Iterator<Item = i64>, sign: &str, what: &str) -> String {
    numbers.map(|number| format!("{what}({number})")).collect::<Vec<_>>().join(sign)
}

fn choice(then: Term, otherwise: Term) -> Term {
    let (x, none) = (Value::variable(&Name::new("x")), Value::integer(0));
    let guard = |relation| Term::new(Node::Guard(relation, x.clone(), none.clone()));
    Term::par([Term::seq([guard(Relation::Gtr), then]), Term::seq([guard(Relation::Lte), otherwise])])
}

fn looped(body: Term) -> Term {
    Term::new(Node::Loop(body))
}

fn rounds(count: i64) -> Term {
    let round = out(0);
    let mut parts: Vec<Term> = (0..count).map(|_| round.clone()).collect();
    parts.push(looped(round));
    Term::seq(parts)
}

fn all_families() -> [Family; 4] {
    [
        Family {
            title: "permuted |",
            claim: |n| (Term::par((0..n).map(part)), Term::par((0..n).rev().map(part))),
            maude: |n| (joined(0..n, " | ", "a"), joined((0..n).rev(), " | ", "a")),
        },
        Family {
            title: "guards distributed over n steps",
            claim: |n| {
                let rest = || Term::seq((0..n).map(out));
                let left = Term::seq([choice(out(-1), out(-2)), rest()]);
                (left, choice(Term::seq([out(-1), rest()]), Term::seq([out(-2), rest()])))
            },
            maude: |n| {
                let rest = joined(0..n, " ; ", "a");
                (format!("(g ; p | h ; q) ; {rest}"), format!("g ; p ; {rest} | h ; q ; {rest}"))
            },
        },
        Family {
            title: "a loop unrolled n and 2n times",
            claim: |n| (rounds(n), rounds(2 * n)),
            maude: |n| {
                let rounds = |n: i64| format!("{} ; t", vec!["p"; n as usize].join(" ; "));
                (rounds(n), rounds(2 * n))
            },
        },
        Family {
            title: "a network of n components",
            claim: |n| {
                let own = |number: i64| Term::disable([Term::delay(Value::integer(1)), observer(number)]);
                (Term::par((0..n).map(|k| looped(own(k)))), looped(Term::par((0..n).map(own))))
            },
            maude: |n| (joined(0..n, " | ", "l"), format!("loop({})", joined(0..n, " | ", "a"))),
        },
    ]
}

/// The same laws for Maude, as directed equations over its own matching.
const MAUDE: &str = "
fmod LAWS is
  protecting NAT .
  sort P .
  ops g h p q t : -> P .
  ops a l : Nat -> P .
  op loop : P -> P .
  op _;_ : P P -> P [assoc prec 20] .
  op _|_ : P P -> P [assoc comm prec 30] .
  vars X Y Z : P . var N : Nat .
  eq (g ; X | h ; Y) ; Z = g ; X ; Z | h ; Y ; Z .
  eq p ; t = t .
  eq l(N) = loop(a(N)) .
  eq loop(X) | loop(Y) = loop(X | Y) .
endfm
";

/// Maude's own measure of one reduction, in milliseconds; nothing where it is not installed.
fn maude(left: &str, right: &str) -> Option<f64> {
    let mut file = tempfile::Builder::new().suffix(".maude").tempfile().ok()?;
    write!(file, "{MAUDE}\nred {left} == {right} .\nquit\n").ok()?;
    let output = std::process::Command::new("maude").arg("-no-banner").arg(file.path()).output().ok()?;
    let text = String::from_utf8_lossy(&output.stdout).replace('\n', " ");
    if !text.contains("Bool: true") {
        println!("  maude did not reduce it to true: {}", text.chars().take(300).collect::<String>());
        return None;
    }
    let after = text.split("rewrites: ").nth(1)?;
    after.split("ms cpu (").nth(1)?.split("ms real").next()?.trim().parse().ok()
}

fn families(theory: &Theory) {
    let installed = std::process::Command::new("maude").arg("--version").output().is_ok();
    if !installed {
        println!("maude is not on the PATH: no ratios to it");
    }
    for family in all_families() {
        for size in [16, 64, 256, 1024] {
            let (left, right) = (family.claim)(size);
            let (time, checked) = proved(theory, &equation(left, right));
            let verdict = if checked.is_some() { "proved" } else { "open" };
            print!("{}, n = {size}: {verdict} in {:.2} ms", family.title, time.as_secs_f64() * 1e3);
            let (left, right) = (family.maude)(size);
            match installed.then(|| maude(&left, &right)).flatten() {
                Some(theirs) => println!(", maude {theirs} ms"),
                None => println!(),
            }
            if time > Duration::from_secs(3) {
                println!("  larger ones are left out");
                break;
            }
        }
    }
    let power = |body: Term, count: i64| Term::new(Node::Power(body, Value::integer(count), None));
    for count in [10, 1_000, 1_000_000] {
        let round = out(0);
        let claim = (looped(round.clone()), Term::seq([power(round.clone(), count), looped(round)]));
        let (time, checked) = proved(theory, &equation(claim.0, claim.1));
        let verdict = if checked.is_some() { "proved" } else { "open" };
        println!("T = P^n ; T, n = {count}: {verdict} in {:.2} ms", time.as_secs_f64() * 1e3);
    }
}

/// A false claim is refuted by the model before anything is searched for.
fn false_control() {
    let p = Term::meta(&Name::new("?P"));
    let (left, right) = (Term::seq([p.clone(), p.clone()]), p);
    let none = (Definitions::default(), Assumptions::default());
    let limits = pars::refute::Limits::default();
    let (time, found) =
        timed(|| pars::refute::refute(&left, &right, Connective::Equal, &[], &none.0, &none.1, &limits));
    let verdict = if found.counterexample().is_some() { "refuted" } else { "open" };
    println!("a false control: {verdict} in {:.2} ms", time.as_secs_f64() * 1e3);
}

fn parsing() {
    let line = "prove (Delay_1 # At_0) ; (Delay_2 # At_0) = Delay_3 # At_0\n";
    let text = line.repeat(20_000);
    let (time, parsed) = timed(|| pars::parser::parse(&text));
    let megabytes = text.len() as f64 / 1e6;
    println!("parsing: {:.1} MB a second ({} items)", megabytes / time.as_secs_f64(), parsed.items.len());
}

fn run() {
    let Ok(mut environment) = library::standard() else { return println!("the rules do not load") };
    families(&theory(&environment));
    false_control();
    laws(&mut environment);
    parsing();
}

fn main() {
    let work = std::thread::Builder::new().stack_size(1 << 30).spawn(run);
    if work.map(|thread| thread.join().is_err()).unwrap_or(true) {
        std::process::exit(1);
    }
}
