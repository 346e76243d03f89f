//! The noisy waypoint in one dimension and in the plane, enclosed, against dense quadrature and Monte Carlo in numpy and
//! against Storm, where they are installed (`PYTHON` names a python that has them; `benches/probability.py` is what it
//! runs); questions at a fixed time; growth with the horizon and with legs; simulated steps a second. Each line is a
//! measurement of this run on this machine.

use std::process::Command;
use std::time::{Duration, Instant};

use pars::invariant::Claim;
use pars::lower::{ClaimKind, Environment, Event, Lowered};
use pars::parser::parse;
use pars::period::{Test, analyse};
use pars::probability::chain::{Chain, chain};
use pars::probability::{Question, enclosed, estimated, linear};

/// The program's own.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

const LINE: &str = "observer At(r), Done
proc Env_r = (Delay_{1/5} # Odo_r # At_r) ; (Ran_{Normal(0, sd: 1/2)}<e> | In_v<u>) ; Env_{r+(u+e)/5}
proc Odo_r = Ran_{Normal(0, sd: 1/10)}<w> ; Out_{p,r+w} ; Odo_r
proc Go_g  = In_p<m> ; Gtr_{|m-g|,1/10} ; Out_{v,(g-m)/2} ; Go_g
";

const PLANE: &str = "observer Done
proc EnvX_r = (Delay_{1/5} # OdoX_r) ; (Ran_{Normal(0, sd: 1/2)}<e> | In_v<u>) ; EnvX_{r+(u+e)/5}
proc OdoX_r = Ran_{Normal(0, sd: 1/10)}<w> ; Out_{p,r+w} ; OdoX_r
proc EnvY_r = (Delay_{1/5} # OdoY_r) ; (Ran_{Normal(0, sd: 1/2)}<e> | In_z<u>) ; EnvY_{r+(u+e)/5}
proc OdoY_r = Ran_{Normal(0, sd: 1/10)}<w> ; Out_{q,r+w} ; OdoY_r
proc Go_{g,h} = (In_p<m> | In_q<n>) ; (Gtr_{|m-g|,1/10} | Gtr_{|n-h|,1/10}) ; (Out_{v,(g-m)/2} | Out_{z,(h-n)/2}) ; Go_{g,h}
system Sys = EnvX_0 | EnvY_0 | (Go_{10,10} ; Done)
";

const FREE: &str = "observer At(r)
proc Env_r = (Delay_{1/5} # Odo_r # At_r) ; (Ran_{Normal(0, sd: 1/2)}<e> | In_v<u>) ; Env_{r+(u+e)/5}
proc Odo_r = Ran_{Normal(0, sd: 1/10)}<w> ; Out_{p,r+w} ; Odo_r
proc Go = In_p<m> ; Out_{v,(10-m)/2} ; Go
system Sys = Env_0 | Go
";

/// The system, and what is asked of it.
fn load(mission: &str, asked: &str) -> Option<(Chain, Question)> {
    let text = format!("{mission}prove probability of Sys {asked} >= 1/2");
    let parsed = parse(&text);
    let mut environment = Environment::default();
    let lowered = environment.declare(&parsed.items, &text);
    let claim = lowered.into_iter().flatten().find_map(|item| match item {
        Lowered::Claim(claim) => Some(claim.kind),
        _ => None,
    });
    let ClaimKind::Likely { likelihood, .. } = claim? else { return None };
    let Event::Shown { first, pattern, time } = likelihood.event else { return None };
    let components = environment.system(&likelihood.system)?.components.clone();
    let period = analyse(&components, &environment.definitions, &environment.assumptions).ok()?;
    let test = |(relation, left, right)| Test { relation, left, right };
    let tests = pattern.conditions.into_iter().map(test).collect();
    let names = pattern.variables.iter().cloned().collect();
    let event = Claim { shown: pattern.terms, variables: pattern.variables, tests };
    let chain = chain(&period, &event, &environment.assumptions).ok()?;
    Some((chain, Question { first, time: time.as_rational()?, names }))
}

/// The waypoint after so many looks, the first of which is at 0; `legs` goals, there and back.
fn line(looks: u32, legs: usize) -> Option<(Chain, Question)> {
    let goals: Vec<&str> = ["Go_10", "Go_8"].into_iter().cycle().take(legs).collect();
    load(&format!("{LINE}system Sys = Env_0 | ({} ; Done)\n", goals.join(" ; ")), &within(looks))
}

fn within(looks: u32) -> String {
    format!("reaching Done within {}/5", looks - 1)
}

/// The least time that it takes, in seconds.
fn best(times: u32, mut work: impl FnMut()) -> f64 {
    let mut once = || {
        let start = Instant::now();
        work();
        start.elapsed()
    };
    (0..times).map(|_| once()).min().unwrap_or(Duration::ZERO).as_secs_f64()
}

/// Seconds, value, and for Storm the seconds of the checking alone; prints why where there are none.
fn peer(what: &str, size: u32, looks: u32, times: u32) -> Option<(f64, f64, f64)> {
    let python = std::env::var("PYTHON").unwrap_or_else(|_| "python3".to_string());
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/probability.py");
    let arguments = [size, looks, times].map(|number| number.to_string());
    let output = Command::new(python).arg(script).arg(what).args(arguments).output();
    let text = output.ok().and_then(|output| String::from_utf8(output.stdout).ok()).unwrap_or_default();
    let numbers: Vec<f64> = text.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    match numbers.as_slice() {
        [seconds, value, check] => Some((*seconds, *value, *check)),
        _ => {
            println!("  {what}: skipped, {}", if text.is_empty() { "there is no python for it" } else { text.trim() });
            None
        }
    }
}

/// The most memory that this process has held, in megabytes, where the system tells.
fn memory() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM"))?;
    Some(line.split_whitespace().nth(1)?.parse::<f64>().ok()? / 1024.0)
}

/// Encloses to this width, prints it, and gives the middle and the seconds.
fn ours(title: &str, asked: &(Chain, Question), width: f64, times: u32) -> Option<(f64, f64)> {
    let (chain, question) = asked;
    let found = *enclosed::enclosed(chain, question, width).ok()?;
    let seconds = best(times, || {
        std::hint::black_box(enclosed::enclosed(chain, question, width).ok());
    });
    let middle = f64::midpoint(found.low, found.high);
    let memory = memory().map_or(String::new(), |most| format!(", {most:.0} MB at most so far"));
    println!(
        "{title}, asked for {width:.0e}: {middle:.10}, width {:.1e}, {:.3} ms{memory}",
        found.width(),
        seconds * 1e3
    );
    Some((middle, seconds))
}

/// Compares with the others: what they do, how large, how often.
fn against(found: Option<(f64, f64)>, looks: u32, peers: &[(&str, u32, u32)]) {
    let Some((middle, own)) = found else { return println!("  could not be enclosed") };
    for (what, size, times) in peers {
        let Some((seconds, value, check)) = peer(what, *size, looks, *times) else { continue };
        let alone = if check > 0.0 { format!(" ({:.0} times without building)", check / own) } else { String::new() };
        println!(
            "  {what} {size}: {:.2} ms, off by {:.1e}; enclosing is {:.1} times faster{alone}",
            seconds * 1e3,
            (value - middle).abs(),
            seconds / own
        );
    }
}

fn main() {
    let all = std::env::args().any(|argument| argument == "all");
    // The plane first, so that its memory is its own.
    if let Some(asked) = load(PLANE, &within(75)) {
        let found = ours("plane, 75 looks", &asked, 1e-6, 3);
        against(found, 75, &[("plane", 160, 2), ("plane", 200, 2), ("plane", 250, 2), ("runs2", 100_000, 1)]);
    }
    if let Some(asked) = line(50, 1) {
        ours("line, 50 looks", &asked, 1e-8, 20);
        let found = ours("line, 50 looks", &asked, 1e-6, 20);
        let mut peers = vec![("line", 160, 5), ("line", 200, 5), ("line", 300, 5), ("runs1", 100_000, 1)];
        peers.extend([("storm", 401, 1), ("storm", 1601, 1)]);
        // Near 1e-6, where Storm takes its time.
        peers.extend(all.then_some(("storm", 6401, 1)));
        against(found, 50, &peers);
    }
    for looks in [50, 100, 200, 400, 800] {
        if let Some(asked) = line(looks, 1) {
            ours(&format!("line, {looks} looks"), &asked, 1e-6, 3);
        }
    }
    for legs in [1, 2, 4, 8] {
        if let Some(asked) = line(200, legs) {
            ours(&format!("line, 200 looks, {legs} legs"), &asked, 1e-6, 3);
        }
    }
    fixed();
    simulated();
}

/// Linear questions at a fixed time.
fn fixed() {
    for rounds in [10u32, 1_000, 1_000_000] {
        let asked = format!("showing At_p where |p-10| <= 1/10 at {}", f64::from(rounds) / 5.0);
        let Some((chain, question)) = load(FREE, &asked) else { continue };
        let Ok(moments) = linear::moments(&chain, &question) else { continue };
        let again = best(1_000, || {
            std::hint::black_box(moments.chance().ok());
        });
        let whole = best(100, || {
            std::hint::black_box(linear::moments(&chain, &question).and_then(|moments| moments.chance()).ok());
        });
        println!("at round {rounds}: {:.1} us, {:.1} us with the moments", again * 1e6, whole * 1e6);
    }
}

fn simulated() {
    let Some((chain, question)) = load(FREE, "showing At_p where |p-10| <= 1/10 at 20") else { return };
    let threads = std::thread::available_parallelism().map_or(1, std::num::NonZeroUsize::get) as f64;
    let start = Instant::now();
    let share = estimated::estimated(&chain, &question, 1_000_000, 1).map_or(f64::NAN, |found| found.share);
    let rate = 1e8 / start.elapsed().as_secs_f64() / threads;
    println!("simulation: 10^8 steps, share {share}, {:.1} million steps a second and core", rate / 1e6);
    if let Some((seconds, value, _)) = peer("steps", 100_000, 100, 1) {
        let other = 1e7 / seconds;
        println!("  numpy: share {value}, {:.1} million; ours are {:.1} times as many", other / 1e6, rate / other);
    }
}
