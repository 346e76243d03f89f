//! The recurrences of `tests/recurrences/sixty.txt`, and the rates of other solvers on the same set where they are
//! installed; a form counts only if its first twenty terms are right. Each line is a measurement of this run.

use std::collections::BTreeMap;
use std::io::Write;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use pars::assumption::Assumptions;
use pars::closed_form::{Recurrence, Sequence, Solved, term};
use pars::lower::{Environment, Lowered, Question};
use pars::name::Name;
use pars::parser::{parse, parse_value};
use pars::recurrence::solve_all;
use pars::value::{Relation, Value};

const SIXTY: &str = include_str!("../tests/recurrences/sixty.txt");
/// What runs the other solvers: reads the set, answers with one line for each recurrence.
const OTHERS: &str = include_str!("recurrences.py");
const ROUNDS: u32 = 20;

struct Case {
    kind: String,
    question: Question,
    assumptions: Assumptions,
    terms: Vec<(Name, Vec<Value>)>,
}

fn cases() -> Vec<Case> {
    let stanzas = SIXTY.split("\n\n").filter(|stanza| stanza.contains("solve "));
    stanzas.filter_map(case).collect()
}

fn case(stanza: &str) -> Option<Case> {
    let source = stanza.lines().filter(|line| line.starts_with("param ") || line.starts_with("solve "));
    let source = source.collect::<Vec<_>>().join("\n");
    let mut environment = Environment::new();
    let lowered = environment.declare(&parse(&source).items, &source);
    let question = lowered.into_iter().flatten().find_map(|one| match one {
        Lowered::Solve(solve) => Some(*solve),
        _ => None,
    })?;
    let value = |text: &str| Environment::new().value(&parse_value(text).ok()?).ok();
    let mut terms = Vec::new();
    for (name, row) in stanza.lines().filter_map(|line| line.strip_prefix("terms ")?.split_once(": ")) {
        terms.push((Name::new(name), row.split(", ").map(value).collect::<Option<Vec<_>>>()?));
    }
    let kind = stanza.lines().find_map(|line| line.strip_prefix("kind "))?.to_string();
    Some(Case { kind, question, assumptions: environment.assumptions.clone(), terms })
}

fn is_right(case: &Case, solved: &Solved) -> bool {
    let from = solved.recurrence().from;
    case.terms.iter().all(|(name, terms)| {
        terms.iter().zip(from..).all(|(wanted, at)| {
            let found = solved.at(name, at);
            found.is_ok_and(|found| solved.known().decide(Relation::Eq, &found, wanted) == Some(true))
        })
    })
}

fn median(times: &mut [Duration]) -> Duration {
    times.sort();
    times.get(times.len() / 2).copied().unwrap_or_default()
}

fn main() {
    let cases = cases();
    let mut own = Vec::new();
    let mut right = 0;
    let mut slowest = (Duration::ZERO, String::new());
    for case in &cases {
        let start = Instant::now();
        for _ in 1..ROUNDS {
            let _ = solve_all(case.question.recurrence.clone(), &case.assumptions);
        }
        let solved = solve_all(case.question.recurrence.clone(), &case.assumptions);
        let time = start.elapsed() / ROUNDS;
        if solved.is_ok_and(|solved| is_right(case, &solved)) {
            right += 1;
        }
        if time > slowest.0 {
            slowest = (time, case.kind.clone());
        }
        own.push(time);
    }
    let mut kinds: BTreeMap<&str, Vec<Duration>> = BTreeMap::new();
    for (case, time) in cases.iter().zip(&own) {
        kinds.entry(&case.kind).or_default().push(*time);
    }
    for (kind, mut times) in kinds {
        println!("  {kind}: median {:?}", median(&mut times));
    }
    let total: Duration = own.iter().sum();
    let middle = median(&mut own.clone());
    println!("pars: {right}/{} right with the proof, median {middle:?}, total {total:?}", cases.len());
    println!("pars: slowest {:?} ({})", slowest.0, slowest.1);
    others(&own, &cases);
    far_term();
}

/// Runs the other solvers, if there is a Python to run them.
fn others(own: &[Duration], cases: &[Case]) {
    let script = OTHERS.replace("@SET@", concat!(env!("CARGO_MANIFEST_DIR"), "/tests/recurrences/sixty.txt"));
    let child = Command::new("python3").arg("-").stdin(Stdio::piped()).stdout(Stdio::piped()).spawn();
    let Ok(mut child) = child else {
        println!("others: no python3 to run them");
        return;
    };
    if let Some(mut input) = child.stdin.take() {
        let _ = input.write_all(script.as_bytes());
    }
    let Ok(output) = child.wait_with_output() else { return };
    let mut solvers: BTreeMap<String, Vec<(usize, bool, Duration)>> = BTreeMap::new();
    for line in String::from_utf8_lossy(&output.stdout).lines() {
        let parts: Vec<&str> = line.split_whitespace().collect();
        match parts.as_slice() {
            [solver, place, right, seconds] => {
                let (Ok(place), Ok(seconds)) = (place.parse::<usize>(), seconds.parse::<f64>()) else { continue };
                let time = Duration::from_secs_f64(seconds);
                solvers.entry((*solver).to_string()).or_default().push((place, *right == "right", time));
            }
            _ => println!("{line}"),
        }
    }
    for (solver, found) in solvers {
        let right = found.iter().filter(|(_, right, _)| *right).count();
        let both: Vec<&(usize, bool, Duration)> = found.iter().filter(|(_, right, _)| *right).collect();
        let mut times: Vec<Duration> = both.iter().map(|(.., time)| *time).collect();
        let mut ratios: Vec<f64> = both
            .iter()
            .filter_map(|(place, _, time)| Some(time.as_secs_f64() / own.get(*place)?.as_secs_f64()))
            .collect();
        ratios.sort_by(f64::total_cmp);
        let ratio = ratios.get(ratios.len() / 2).copied().unwrap_or(0.0);
        println!(
            "{solver}: {right}/{} right, median {:?}; on those it solves pars is {ratio:.0} times as fast (median)",
            cases.len(),
            median(&mut times)
        );
    }
}

/// The term of index a million of a system of six with rational coefficients.
fn far_term() {
    let index = Name::new("n");
    let names: Vec<Name> = (0..6).map(|place| Name::new(&format!("x{place}"))).collect();
    let sequences = (0..6i64).map(|row| {
        let mut next = Value::zero();
        for (column, name) in names.iter().enumerate() {
            let number = (row * 5 + column as i64 * 3) % 7 - 3;
            let factor = Value::fraction(number, 2).unwrap_or_else(|_| Value::zero());
            let summand = Value::variable(&term(name, &index, 0)).mul(&factor);
            next = summand.and_then(|summand| next.add(&summand)).unwrap_or_else(|_| Value::zero());
        }
        Sequence { name: names[row as usize].clone(), start: vec![Value::integer(row + 1)], next }
    });
    let recurrence = Recurrence { index: index.clone(), from: 0, sequences: sequences.collect() };
    let start = Instant::now();
    match solve_all(recurrence, &Assumptions::default()) {
        Ok(solved) => {
            println!("six by six: solved in {:?}", start.elapsed());
            for at in [10_000, 100_000, 1_000_000] {
                let start = Instant::now();
                let value = solved.at(&names[0], at);
                let bits = value.ok().and_then(|value| value.as_rational()).map_or(0, |value| value.numer().bits());
                println!("six by six: the term {at}, of {bits} bits, in {:?}", start.elapsed());
            }
        }
        Err(reason) => println!("six by six: {}", reason.0),
    }
}
