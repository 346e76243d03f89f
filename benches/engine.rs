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
    let finding = finding.saturating_sub(checking);
    println!("kernel: checking takes 1/{:.0} of finding", finding.as_secs_f64() / checking.as_secs_f64());
}

/// An equation family: the two sides for each size, which read the same for us and for Maude but for the notation.
struct Family {
    title: &'static str,
    sides: fn(i64, &Notation) -> [String; 2],
}

/// How a process is written.
struct Notation {
    delay: fn(i64) -> String,
    out: fn(i64) -> String,
    guards: [&'static str; 2],
}

const OURS: Notation = Notation {
    delay: |time| format!("Delay_{time}"),
    out: |number| format!("Out_{{c,{number}}}"),
    guards: ["Gtr_{x,0}", "Lte_{x,0}"],
};

const THEIRS: Notation = Notation {
    delay: |time| format!("Delay({time})"),
    out: |number| format!("Out('c, {number})"),
    guards: ["Gtr('x, 0)", "Lte('x, 0)"],
};

/// Many parts are bracketed in groups: Maude reads a flat list of thousands in time that grows with its cube.
const GROUP: usize = 32;

fn joined(parts: impl IntoIterator<Item = String>, sign: &str) -> String {
    let mut parts: Vec<String> = parts.into_iter().collect();
    while parts.len() > GROUP {
        parts = parts.chunks(GROUP).map(|group| format!("({})", group.join(sign))).collect();
    }
    parts.join(sign)
}

fn all_families() -> [Family; 4] {
    [
        Family {
            title: "permuted |",
            sides: |n, notation| {
                let part = |number: i64| format!("({} ; At({number}))", (notation.delay)(1));
                [joined((0..n).map(part), " | "), joined((0..n).rev().map(part), " | ")]
            },
        },
        Family {
            title: "guards distributed over n steps",
            sides: |n, notation| {
                let rest = joined((0..n).map(notation.out), " ; ");
                let [yes, no] = notation.guards;
                let (one, two) = ((notation.out)(-1), (notation.out)(-2));
                [
                    format!("(({yes} ; {one}) | ({no} ; {two})) ; ({rest})"),
                    format!("({yes} ; {one} ; ({rest})) | ({no} ; {two} ; ({rest}))"),
                ]
            },
        },
        Family {
            title: "a loop unrolled n and 2n times",
            sides: |n, notation| {
                let round = (notation.out)(0);
                [n, 2 * n].map(|n| {
                    let rounds = (0..n).map(|_| round.clone());
                    joined(rounds.chain([format!("loop({round})")]), " ; ")
                })
            },
        },
        Family {
            title: "a network of n components",
            sides: |n, notation| {
                let own = |number: i64| format!("({} # At({number}))", (notation.delay)(1));
                let loops = joined((0..n).map(|number| format!("loop({})", own(number))), " | ");
                [loops, format!("loop({})", joined((0..n).map(own), " | "))]
            },
        },
    ]
}

/// The quickest of five runs of a process, which other work on the machine disturbed least, with what it printed.
fn quickest(command: &mut std::process::Command) -> Option<(Duration, std::process::Output)> {
    let runs = (0..5).map(|_| timed(|| command.output()));
    let (time, output) = runs.min_by_key(|(time, _)| *time)?;
    Some((time, output.ok()?))
}

/// What Maude takes, in milliseconds: to rewrite by its own clock, and as a process, which also reads its input.
struct Maude {
    rewriting: f64,
    process: f64,
}

/// Nothing where Maude is not installed, or does not prove it.
fn maude(left: &str, right: &str) -> Option<Maude> {
    let mut file = tempfile::Builder::new().suffix(".maude").tempfile().ok()?;
    write!(file, "{}\nred {left} == {right} .\nquit\n", include_str!("families.maude")).ok()?;
    let mut command = std::process::Command::new("maude");
    let (process, output) = quickest(command.arg("-no-banner").arg(file.path()))?;
    let text = String::from_utf8_lossy(&output.stdout).replace('\n', " ");
    if !text.contains("Bool: true") || !output.stderr.is_empty() {
        println!("  maude did not reduce it to true: {}", text.chars().take(300).collect::<String>());
        return None;
    }
    let after = text.split("rewrites: ").nth(1)?;
    let rewriting = after.split("ms cpu (").nth(1)?.split("ms real").next()?.trim().parse().ok()?;
    Some(Maude { rewriting, process: process.as_secs_f64() * 1e3 })
}

/// What we take, in milliseconds: to find a proof and have the kernel check it; the same with reading the text; and
/// as a process, `pars run`, which also reads the laws, looks for a counterexample first, and prints.
struct Pars {
    proving: f64,
    reading: f64,
    process: f64,
}

fn pars(environment: &Environment, left: &str, right: &str) -> Option<Pars> {
    let text = format!("prove {left} = {right}\n");
    let names = "observer At(r)\nparam x\n";
    let mut environment = environment.clone();
    environment.declare(&pars::parser::parse(names).items, names);
    let (reading, lowered) = timed(|| environment.declare(&pars::parser::parse(&text).items, &text));
    let Some(Ok(Lowered::Claim(claim))) = lowered.into_iter().next() else { return None };
    let ClaimKind::Compare { left, right, .. } = claim.kind else { return None };
    // A search has its proof checked before it answers.
    let (proving, checked) = proved(&theory(&environment), &equation(left, right));
    checked?;
    let mut file = tempfile::Builder::new().suffix(".pars").tempfile().ok()?;
    writeln!(file, "{names}{text}expect proved").ok()?;
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_pars"));
    let (process, output) = quickest(command.arg("run").arg(file.path()))?;
    let milliseconds = |time: Duration| time.as_secs_f64() * 1e3;
    output.status.success().then(|| Pars {
        proving: milliseconds(proving),
        reading: milliseconds(proving + reading),
        process: milliseconds(process),
    })
}

fn family(environment: &Environment, family: &Family, installed: bool) {
    for size in [16, 64, 256, 1024] {
        let [left, right] = (family.sides)(size, &OURS);
        let Some(ours) = pars(environment, &left, &right) else {
            println!("{}, n = {size}: open", family.title);
            return;
        };
        println!(
            "{}, n = {size}: proved and checked in {:.2} ms, {:.2} with reading, {:.0} as a process",
            family.title, ours.proving, ours.reading, ours.process
        );
        let [left, right] = (family.sides)(size, &THEIRS);
        if let Some(theirs) = installed.then(|| maude(&left, &right)).flatten() {
            let ratio = ours.process / theirs.process;
            let (rewriting, process) = (theirs.rewriting, theirs.process);
            println!("  maude: {rewriting} ms of rewriting, {process:.0} as a process; ours takes {ratio:.2} of that");
        }
    }
}

fn families(environment: &Environment, wanted: &dyn Fn(&str) -> bool) {
    let installed = std::process::Command::new("maude").arg("--version").output().is_ok();
    if !installed {
        println!("maude is not on the PATH: no ratios to it");
    }
    for one in all_families().iter().filter(|family| wanted(family.title)) {
        family(environment, one, installed);
    }
}

/// How long a proof that any number of rounds before a loop are rounds of it takes: no longer for more.
fn powers(theory: &Theory) {
    let round = || Term::new(Node::Out(Name::new("c"), Value::integer(0)));
    let looped = |body: Term| Term::new(Node::Loop(body));
    let power = |body: Term, count: i64| Term::new(Node::Power(body, Value::integer(count), None));
    for count in [10, 1_000, 1_000_000] {
        let claim = equation(looped(round()), Term::seq([power(round(), count), looped(round())]));
        let (time, checked) = proved(theory, &claim);
        let verdict = if checked.is_some() { "proved" } else { "open" };
        println!("T = P^n ; T, n = {count}: {verdict} in {:.2} ms", time.as_secs_f64() * 1e3);
    }
}

/// Decisions under few and under many assumptions, `0 < x0 < x1 < …` and a bound on each: `x1 < x3`, which rests on
/// two of them, and `x1 < 1`, which does not follow.
fn decisions() {
    let x = |number: usize| Value::variable(&Name::new(&format!("x{number}")));
    for count in [8, 400] {
        let (assuming, assumptions) = timed(|| {
            let mut assumptions = Assumptions::default();
            assumptions.assume(Relation::Gtr, &x(0), &Value::zero());
            for number in 1..count / 2 {
                assumptions.assume(Relation::Lss, &x(number - 1), &x(number));
                assumptions.assume(Relation::Lss, &x(number), &Value::integer(1_000));
            }
            assumptions
        });
        let (time, right) = timed(|| {
            let follows = assumptions.decide(Relation::Lss, &x(1), &x(3)) == Some(true);
            let open = assumptions.decide(Relation::Lss, &x(1), &Value::integer(1)).is_none();
            follows && open
        });
        let verdict = if right { "right" } else { "not decided" };
        let milliseconds = |time: Duration| time.as_secs_f64() * 1e3;
        println!(
            "decisions under {count} assumptions: {verdict}, {:.2} ms each; to assume them {:.2} ms",
            milliseconds(time) / 2.0,
            milliseconds(assuming)
        );
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

/// Runs what is named on the command line by a part of its title; everything when nothing is.
fn run() {
    let names: Vec<String> = std::env::args().skip(1).filter(|name| !name.starts_with('-')).collect();
    let wanted = |title: &str| names.is_empty() || names.iter().any(|name| title.contains(name.as_str()));
    let Ok(mut environment) = library::standard() else { return println!("the rules do not load") };
    families(&environment, &wanted);
    if wanted("T = P^n ; T") {
        powers(&theory(&environment));
    }
    if wanted("false control") {
        false_control();
    }
    if wanted("decisions") {
        decisions();
    }
    if wanted("law table") {
        laws(&mut environment);
    }
    if wanted("parsing") {
        parsing();
    }
}

fn main() {
    let work = std::thread::Builder::new().stack_size(1 << 30).spawn(run);
    if work.map(|thread| thread.join().is_err()).unwrap_or(true) {
        std::process::exit(1);
    }
}
