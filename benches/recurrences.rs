//! The recurrences of `tests/recurrences/sixty.txt` and the questions of arrival there and in `arrivals.txt`, next to other
//! solvers on the same set where they are installed, a line for each. A form counts only if its first twenty terms are
//! right, an arrival only if it is the expected one. Every time is a measurement of this run: the median of several
//! rounds of our own, and what the others measure of themselves, without their start.

use std::collections::BTreeMap;
use std::io::Write;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use pars::assumption::Assumptions;
use pars::closed_form::{Recurrence, Sequence, Solved, term};
use pars::lower::{Environment, Lowered, Question};
use pars::name::Name;
use pars::parser::{parse, parse_value};
use pars::recurrence::{Reach, reach, solve_all};
use pars::value::{Relation, Value};

/// The program's own.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

const SIXTY: &str = include_str!("../tests/recurrences/sixty.txt");
const ARRIVALS: &str = include_str!("../tests/recurrences/arrivals.txt");
/// What runs the other solvers: reads the set, answers with one line for each recurrence.
const OTHERS: &str = include_str!("recurrences.py");
const ROUNDS: usize = 21;

struct Case {
    kind: String,
    question: Question,
    assumptions: Assumptions,
    terms: Vec<(Name, Vec<Value>)>,
    /// What is expected of an arrival.
    arrival: Option<String>,
}

/// The forms, then the arrivals: the order in which the other solvers count them too.
fn cases() -> Vec<Case> {
    let stanzas = || SIXTY.split("\n\n").chain(ARRIVALS.split("\n\n")).filter(|stanza| stanza.contains("solve "));
    let forms = stanzas().filter(|stanza| stanza.contains("terms ")).filter_map(|stanza| case(stanza, false));
    let arrivals = stanzas().filter(|stanza| stanza.contains("find ")).filter_map(|stanza| case(stanza, true));
    forms.chain(arrivals).collect()
}

fn case(stanza: &str, arrives: bool) -> Option<Case> {
    let source = stanza.lines().filter(|line| line.starts_with("param ") || line.starts_with("solve "));
    let mut source = source.collect::<Vec<_>>().join("\n");
    let mut arrival = None;
    if arrives {
        let (goal, expected) = stanza.lines().find_map(|line| line.strip_prefix("find ")?.split_once(" -> "))?;
        source = format!("{source} find n with {goal}");
        arrival = Some(expected.to_string());
    }
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
    let kind = if arrives { format!("arrival: {kind}") } else { kind };
    Some(Case { kind, question, assumptions: environment.assumptions.clone(), terms, arrival })
}

impl Case {
    /// Whether a run of it is right.
    fn run(&self) -> bool {
        let (recurrence, known) = (&self.question.recurrence, &self.assumptions);
        let solved = solve_all(recurrence.clone(), known);
        let (Some(expected), Some((relation, left, right))) = (&self.arrival, &self.question.find) else {
            return solved.is_ok();
        };
        match reach(recurrence, solved.ok().as_ref(), (*relation, left, right), known, &|| false) {
            Reach::At(at, _) => *expected == format!("n = {at}"),
            Reach::Never(_) => expected == "never",
            Reach::Unknown(_) => false,
        }
    }

    /// Whether it is right, the terms of the form included, and the median time of a run.
    fn measured(&self) -> (bool, Duration) {
        let mut times = Vec::new();
        let mut right = true;
        for _ in 0..ROUNDS {
            let start = Instant::now();
            right &= self.run();
            times.push(start.elapsed());
        }
        if self.arrival.is_none() {
            let solved = solve_all(self.question.recurrence.clone(), &self.assumptions);
            right &= solved.is_ok_and(|solved| is_right(self, &solved));
        }
        (right, median(&mut times))
    }
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
    let own: Vec<(bool, Duration)> = cases.iter().map(Case::measured).collect();
    let others = others();
    for (place, (case, (right, time))) in cases.iter().zip(&own).enumerate() {
        let mut line = format!("{place:3} {:40} pars {}", case.kind, shown(*right, *time));
        for (solver, found) in &others {
            let theirs = found.get(&place).map_or_else(|| format!("{:>10}", "-"), |(right, time)| shown(*right, *time));
            line.push_str(&format!("  {solver} {theirs}"));
        }
        println!("{line}");
    }
    for arrivals in [false, true] {
        let places: Vec<usize> = (0..cases.len()).filter(|place| cases[*place].arrival.is_some() == arrivals).collect();
        println!("{}", if arrivals { "arrivals:" } else { "forms:" });
        summary(&places, &own, &others);
    }
    far_term();
}

fn shown(right: bool, time: Duration) -> String {
    if right { format!("{:>10}", format!("{time:.1?}")) } else { format!("{:>10}", "no") }
}

/// How many are right, the median time of these, and how many times as fast our own are on the same.
fn summary(places: &[usize], own: &[(bool, Duration)], others: &Others) {
    let mut times: Vec<Duration> = places.iter().filter(|place| own[**place].0).map(|place| own[*place].1).collect();
    let (right, slowest) = (times.len(), times.iter().max().copied().unwrap_or_default());
    println!("  pars: {right}/{} right, median {:.1?}, slowest {slowest:.1?}", places.len(), median(&mut times));
    for (solver, found) in others {
        let both = places.iter().filter_map(|place| {
            let (_, time) = found.get(place).filter(|(right, _)| *right && own[*place].0)?;
            Some((*time, time.as_secs_f64() / own[*place].1.as_secs_f64()))
        });
        let (mut times, mut ratios): (Vec<Duration>, Vec<f64>) = both.unzip();
        ratios.sort_by(f64::total_cmp);
        let ratio = ratios.get(ratios.len() / 2).copied().unwrap_or(0.0);
        let count = times.len();
        println!(
            "  {solver}: {count}/{} right, median {:.1?}; on these pars is {ratio:.1} times as fast in the median",
            places.len(),
            median(&mut times)
        );
    }
}

/// By solver and place: whether it is right, and the time.
type Others = BTreeMap<String, BTreeMap<usize, (bool, Duration)>>;

/// Runs the other solvers, if there is a Python to run them.
fn others() -> Others {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/recurrences/");
    let script = OTHERS.replace("@FOLDER@", folder);
    let mut solvers = Others::new();
    let child = Command::new("python3").arg("-").stdin(Stdio::piped()).stdout(Stdio::piped()).spawn();
    let Ok(mut child) = child else {
        println!("others: no python3 to run them");
        return solvers;
    };
    if let Some(mut input) = child.stdin.take() {
        let _ = input.write_all(script.as_bytes());
    }
    let Ok(output) = child.wait_with_output() else { return solvers };
    for line in String::from_utf8_lossy(&output.stdout).lines() {
        let parts: Vec<&str> = line.split_whitespace().collect();
        match parts.as_slice() {
            [solver, place, right @ ("right" | "wrong"), seconds] => {
                let (Ok(place), Ok(seconds)) = (place.parse::<usize>(), seconds.parse::<f64>()) else { continue };
                let found = (*right == "right", Duration::from_secs_f64(seconds));
                solvers.entry((*solver).to_string()).or_default().insert(place, found);
            }
            _ => println!("{line}"),
        }
    }
    solvers
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
        Err(reason) => println!("six by six: {}", reason.reason),
    }
}
