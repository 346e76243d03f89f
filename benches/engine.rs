//! Rates and ratios of the engine; each line is a measurement of this run on this machine.

use std::time::{Duration, Instant};

use pars::kernel::{Theory, check};
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

fn observer(number: i64) -> Term {
    Term::new(Node::Observe(Name::new("At"), vec![Value::integer(number)]))
}

fn family(theory: &Theory, title: &str, sizes: &[i64], claim: impl Fn(i64) -> (Term, Term)) {
    for size in sizes {
        let (left, right) = claim(*size);
        let (time, checked) = proved(theory, &equation(left, right));
        let verdict = if checked.is_some() { "proved" } else { "open" };
        println!("{title}, n = {size}: {verdict} in {:.2} ms", time.as_secs_f64() * 1e3);
    }
}

fn families(theory: &Theory) {
    let part = |number: i64| Term::seq([Term::delay(Value::integer(1)), observer(number)]);
    let sizes = [16, 64, 256, 1024];
    family(theory, "permuted |", &sizes, |n| (Term::par((0..n).map(part)), Term::par((0..n).rev().map(part))));
    let guarded =
        |n: i64| Term::seq((0..n).map(|k| Term::new(Node::Guard(Relation::Eq, Value::integer(k), Value::integer(k)))));
    family(theory, "guards in a row", &sizes, |n| (guarded(n), Term::stop()));
    family(theory, "delays in a row", &sizes, |n| {
        (Term::seq((0..n).map(|_| Term::delay(Value::integer(1)))), Term::delay(Value::integer(n)))
    });
    let power = |body: Term, count: i64| Term::new(Node::Power(body, Value::integer(count), None));
    let endless = Term::new(Node::Loop(part(1)));
    family(theory, "loop(P^n) = loop(P)", &[10, 1_000, 1_000_000], |n| {
        let round = Term::delay(Value::integer(1));
        (Term::new(Node::Loop(power(round.clone(), n))), Term::new(Node::Loop(round)))
    });
    family(theory, "a false control", &[1], |_| (endless.clone(), Term::stop()));
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
    laws(&mut environment);
    parsing();
}

fn main() {
    let work = std::thread::Builder::new().stack_size(1 << 30).spawn(run);
    if work.map(|thread| thread.join().is_err()).unwrap_or(true) {
        std::process::exit(1);
    }
}
