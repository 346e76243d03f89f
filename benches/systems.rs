//! Rates and sizes of transition systems; each line is a measurement of this run on this machine.

use std::process::Command;
use std::time::{Duration, Instant};

use pars::definition::Definitions;
use pars::equivalence::strong_partition;
use pars::library::standard;
use pars::refute::{Limits, Refutation, judge};
use pars::term::{Node, Term};
use pars::transition_system::{Bounds, Builder, Clock, Inputs, Label, Mark, Process, TransitionSystem, generate};
use pars::value::Value;

fn timed<T>(work: impl FnOnce() -> T) -> (Duration, T) {
    let start = Instant::now();
    let result = work();
    (start.elapsed(), result)
}

/// The most memory that this process has held, in bytes, where the system tells.
fn peak() -> Option<usize> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    line.split_whitespace().nth(1)?.parse::<usize>().ok().map(|kilobytes| kilobytes << 10)
}

/// A random graph of about this many transitions in which only one state can do `b`, unfolded twice: what tells two
/// states apart is far away, and half of the states are left.
fn system(transitions: u32) -> TransitionSystem {
    let half = (transitions / 4).max(2);
    let mut builder = Builder::new();
    let labels = ["a", "b"].map(|label| builder.label(Label::Act(label.to_string())));
    (0..2 * half).for_each(|_| {
        builder.state(Mark::plain());
    });
    let mut seed = 88_172_645_463_325_252u64;
    let mut random = |sides: u32| {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        (seed % u64::from(sides)) as u32
    };
    for state in 0..half {
        for _ in 0..2 {
            let to = random(half);
            for copy in 0..2 {
                builder.transition(state + copy * half, labels[0], to + random(2) * half);
            }
        }
    }
    (0..2).for_each(|copy| builder.transition(copy * half, labels[1], half));
    builder.finish(0, None)
}

/// A chain, in which only distance tells states apart: as many rounds as states for a naive refinement.
fn chain(transitions: u32) -> TransitionSystem {
    let mut builder = Builder::new();
    let label = builder.label(Label::Act("a".to_string()));
    (0..=transitions).for_each(|_| {
        builder.state(Mark::plain());
    });
    (0..transitions).for_each(|state| builder.transition(state, label, state + 1));
    builder.finish(0, None)
}

fn minimised(name: &str, make: fn(u32) -> TransitionSystem) {
    let mut before: Option<f64> = None;
    for transitions in [10_000, 100_000, 1_000_000] {
        let system = make(transitions);
        let (time, blocks) = timed(|| {
            let partition = strong_partition(&system);
            system.quotient(&partition, false).states()
        });
        let most = peak().map_or(0, |bytes| bytes / system.states());
        let seconds = time.as_secs_f64();
        let growth =
            before.map_or(String::new(), |before| format!(", {:.1} times the time of a tenth", seconds / before));
        println!(
            "minimise {name}: {} states, {} transitions to {blocks} states in {seconds:.3} s, {:.0} states/s, {} bytes a \
             state in the arrays, {most} a state in the whole program at its peak, which is the making of the \
             system{growth}",
            system.states(),
            system.transitions(),
            system.states() as f64 / seconds,
            system.bytes() / system.states(),
        );
        before = Some(seconds);
    }
}

/// `loop(Delay_a ; Out_{c,0}) | loop(Delay_b ; Out_{d,0}) | …`: k timed loops side by side, the next event first.
fn loops(count: usize) -> Term {
    let part = |index: usize| {
        let delay = Term::delay(Value::integer(index as i64 % 3 + 1));
        let out = Term::new(Node::Out(format!("c{index}").as_str().into(), Value::integer(0)));
        Term::new(Node::Loop(Term::seq([delay, out])))
    };
    Term::par((0..count).map(part))
}

/// The same system in Maude: each loop holds what is left of its delay; time passes to the next event.
fn maude(count: usize) -> String {
    let mut text = String::from(
        "mod LOOPS is protecting NAT .\nsorts Loop Loops . subsort Loop < Loops .\nop [_,_,_] : Nat Nat Nat -> Loop .\n\
         op __ : Loops Loops -> Loops [assoc comm] .\nop {_} : Loops -> Loops .\nop least : Loops -> NatMax .\n\
         sort NatMax . subsort Nat < NatMax .\nop none : -> NatMax .\nop pass : Loops Nat -> Loops .\n\
         op lesser : NatMax NatMax -> NatMax .\nvars I T R D : Nat . vars L M : Loops .\n\
         eq lesser(none, none) = none .\neq lesser(none, T) = T .\neq lesser(T, none) = T .\n\
         eq lesser(T, R) = if T < R then T else R fi .\n\
         eq least([I, T, 0]) = none .\neq least([I, T, s R]) = s R .\neq least(L M) = lesser(least(L), least(M)) .\n\
         eq pass([I, T, 0], D) = [I, T, 0] .\neq pass([I, T, s R], D) = [I, T, sd(s R, D)] .\n\
         eq pass(L M, D) = pass(L, D) pass(M, D) .\nrl [out] : { [I, T, 0] L } => { [I, T, T] L } .\n\
         rl [alone] : { [I, T, 0] } => { [I, T, T] } .\ncrl [time] : { L } => { pass(L, D) } if D := least(L) .\nendm\n",
    );
    let parts: Vec<String> = (0..count).map(|index| format!("[{index}, {0}, {0}]", index % 3 + 1)).collect();
    text.push_str(&format!("set show timing on .\nsearch {{ {} }} =>* {{ [99, 0, 0] }} .\nquit\n", parts.join(" ")));
    text
}

/// States and seconds of Maude's search; none where it is not installed or did not answer.
fn searched(count: usize) -> Option<(f64, f64)> {
    let file = std::env::temp_dir().join(format!("pars-loops-{}-{count}.maude", std::process::id()));
    std::fs::write(&file, maude(count)).ok()?;
    let output = Command::new("maude").args(["-no-banner", "-no-advise"]).arg(&file).output();
    let _ = std::fs::remove_file(&file);
    let text = String::from_utf8(output.ok()?.stdout).ok()?;
    // `states: 27  rewrites: 1234 in 1ms cpu (2ms real) …`
    let line = text.lines().find(|line| line.starts_with("states:"))?;
    let states = line.split_whitespace().nth(1)?.parse().ok()?;
    let real = line.split('(').nth(1)?.split("ms").next()?.trim().parse::<f64>().ok()?;
    Some((states, real / 1e3))
}

fn generated() {
    let definitions = Definitions::default();
    let mut said = false;
    for count in 2..=8 {
        let process = Process::new(loops(count), &definitions, Clock::Events, Inputs::default());
        let bounds = Bounds { states: 2_000_000, bytes: 8 << 30 };
        let (time, made) = timed(|| generate(&process, &bounds, &|| false));
        let Ok(made) = made else { return println!("generate: the loops have no meaning") };
        let states = made.system.states() as f64;
        let rate = states / time.as_secs_f64();
        let peer = match searched(count) {
            Some((other, seconds)) if seconds > 0.0 => {
                let ratio = rate / (other / seconds);
                format!("; Maude's search: {other} states in {seconds:.3} s, {ratio:.2} times its rate")
            }
            Some((other, _)) => format!("; Maude's search: {other} states in less than it measures"),
            None if said => String::new(),
            None => "; Maude is not installed: skipped".to_string(),
        };
        said = true;
        println!(
            "generate {count} timed loops: {states} states, {} transitions in {:.3} s, {rate:.0} states/s{peer}",
            made.system.transitions(),
            time.as_secs_f64(),
        );
    }
}

/// The instances on which each law is judged, as many as the test of the rules takes.
const INSTANCES: usize = 3_000;

/// Every law of the rules on two threads, each with its own copy: laws, and instances with a meaning.
fn judged() {
    let half = |half: usize| {
        let Ok(environment) = standard() else { return (0, 0, 0) };
        let limits = Limits { instances: INSTANCES, choices: 100 * INSTANCES, ..Limits::default() };
        let mut found = (0, 0, 0);
        for law in environment.laws.iter().skip(half).step_by(2) {
            found.0 += 1;
            match judge(law, &limits) {
                Refutation::None { instances, meaningless, .. } => found.1 += instances - meaningless,
                Refutation::Refuted(_) => found.2 += 1,
            }
        }
        found
    };
    let (time, halves) = timed(|| {
        let thread = |number: usize| std::thread::Builder::new().stack_size(256 << 20).spawn(move || half(number));
        let threads = [thread(0), thread(1)];
        threads.map(|thread| thread.ok().and_then(|thread| thread.join().ok()).unwrap_or((0, 0, 0)))
    });
    let [one, two] = halves;
    println!(
        "judge: {} laws on {} instances in {:.1} s on two threads, {} refuted",
        one.0 + two.0,
        one.1 + two.1,
        time.as_secs_f64(),
        one.2 + two.2
    );
}

fn main() {
    judged();
    minimised("random", system);
    minimised("chain", chain);
    let work = std::thread::Builder::new().stack_size(1 << 30).spawn(generated);
    if work.map(|thread| thread.join().is_err()).unwrap_or(true) {
        std::process::exit(1);
    }
}
