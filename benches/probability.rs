//! The noisy waypoint of one dimension, enclosed, against a plain dense quadrature in numpy where there is one; and
//! simulated steps a second. Each line is a measurement of this run on this machine.

use std::process::Command;
use std::time::{Duration, Instant};

use pars::invariant::Claim;
use pars::lower::{ClaimKind, Environment, Event, Lowered};
use pars::parser::parse;
use pars::period::{Test, analyse};
use pars::probability::chain::{Chain, chain};
use pars::probability::{Question, enclosed, estimated};

const WAYPOINT: &str = "observer At(r), Done
proc Env_r = (Delay_{1/5} # Odo_r # At_r) ; (Ran_{Normal(0, sd: 1/2)}<e> | In_v<u>) ; Env_{r+(u+e)/5}
proc Odo_r = Ran_{Normal(0, sd: 1/10)}<w> ; Out_{p,r+w} ; Odo_r
proc Go_g  = In_p<m> ; Gtr_{|m-g|,1/10} ; Out_{v,(g-m)/2} ; Go_g
system Sys = Env_0 | (Go_10 ; Done)
prove probability of Sys reaching Done within ";

/// The quadrature: Gauss points on one interval, the guard's chance computed only where it is neither 0 nor 1.
const NUMPY: &str = "
import time, math, sys
import numpy as np
from numpy.polynomial.legendre import leggauss
try:
    from scipy.special import erf
except ImportError:
    erf = np.vectorize(math.erf, otypes=[float])
def phi_cdf(x):
    return 0.5*(1+erf(x/math.sqrt(2)))
def run(n, rounds):
    low, high = -1.0, 12.0
    x, w = leggauss(n); x = (high-low)/2*x+(high+low)/2; w = w*(high-low)/2
    s = math.sqrt(.0101); k = -.001/.0101; tau = math.sqrt(.01-.001**2/.0101)
    def row(r):
        d = x[None,:]-(.9*r[:,None]+1)
        near = np.exp(-d*d/(2*s*s))/(s*math.sqrt(2*math.pi))
        mean = r[:,None]+k*d
        stop = np.zeros_like(mean)
        at = np.abs(mean-10) < 1.1
        stop[at] = phi_cdf((10.1-mean[at])/tau)-phi_cdf((9.9-mean[at])/tau)
        return near*(1-stop)*w[None,:]
    kernel = row(x); done = phi_cdf((10.1-x)/.1)-phi_cdf((9.9-x)/.1)
    v = np.zeros(n)
    for _ in range(rounds-1): v = done+kernel@v
    return float((row(np.zeros(1))@v)[0])
best = 1e9
for _ in range(5):
    start = time.perf_counter(); value = run(int(sys.argv[1]), 50); best = min(best, time.perf_counter()-start)
print(best, value)
";

fn load(rounds: u32) -> Option<(Chain, Question)> {
    // The looks are at 0, 1/5, …: one more than the rounds that pass.
    let text = format!("{WAYPOINT}{}/5 >= 1/2", rounds - 1);
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
    let event = Claim { shown: pattern.terms, variables: pattern.variables, tests };
    let chain = chain(&period, &event, &environment.assumptions).ok()?;
    Some((chain, Question { first, time: time.as_rational()?, names: Vec::new() }))
}

fn best(times: u32, mut work: impl FnMut()) -> Duration {
    let once = |work: &mut dyn FnMut()| {
        let start = Instant::now();
        work();
        start.elapsed()
    };
    (0..times).map(|_| once(&mut work)).min().unwrap_or_default()
}

fn python(points: u32) -> Option<(f64, f64)> {
    let python = std::env::var("PYTHON").unwrap_or_else(|_| "python3".to_string());
    let output = Command::new(python).args(["-c", NUMPY, &points.to_string()]).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    let mut words = text.split_whitespace().map(str::parse::<f64>);
    Some((words.next()?.ok()?, words.next()?.ok()?))
}

fn main() {
    let Some((chain, question)) = load(50) else { return println!("the waypoint could not be loaded") };
    let mut found = None;
    let first = best(1, || found = enclosed::enclosed(&chain, &question, 1e-8).ok());
    let again = best(20, || found = enclosed::enclosed(&chain, &question, 1e-8).ok());
    let Some(found) = found else { return println!("the waypoint could not be enclosed") };
    println!("waypoint, 50 rounds: [{}, {}], width {:.1e}", found.low, found.high, found.width());
    println!(
        "  enclosed in {:.2} ms the first time, {:.2} ms after",
        first.as_secs_f64() * 1e3,
        again.as_secs_f64() * 1e3
    );
    for rounds in [100, 200, 400, 800] {
        if let Some((chain, question)) = load(rounds) {
            let time = best(5, || found_again(&chain, &question));
            println!("  {rounds} rounds in {:.2} ms", time.as_secs_f64() * 1e3);
        }
    }
    for points in [200, 250, 300, 400] {
        match python(points) {
            Some((seconds, value)) => println!(
                "  numpy, {points} points: {:.2} ms, off by {:.1e} and no bound; enclosing takes 1/{:.1} of it",
                seconds * 1e3,
                (value - f64::midpoint(found.low, found.high)).abs(),
                seconds / again.as_secs_f64()
            ),
            None => println!("  no numpy to compare with: set PYTHON to a python that has it"),
        }
    }
    let runs = 200_000;
    let mut share = 0.0;
    let time = best(1, || share = estimated::estimated(&chain, &question, runs, 1).map_or(f64::NAN, |one| one.share));
    let threads = std::thread::available_parallelism().map_or(1, std::num::NonZeroUsize::get) as f64;
    println!(
        "simulation: share {share}, {:.0} runs a second and core",
        f64::from(runs as u32) / time.as_secs_f64() / threads
    );
}

fn found_again(chain: &Chain, question: &Question) {
    let found = enclosed::enclosed(chain, question, 1e-8).ok();
    std::hint::black_box(found);
}
