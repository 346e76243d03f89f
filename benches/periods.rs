//! Periods of large networks; each line is a measurement of this run on this machine: the time that the processor spent,
//! where the system tells it, so that other work does not count.

use std::fmt::Write as _;
use std::rc::Rc;
use std::time::{Duration, Instant};

use pars::diagnostic::Source;
use pars::lower::Environment;
use pars::name::Name;
use pars::parser::parse;
use pars::period::{Period, analyse};
use pars::report::Output;
use pars::session::{Alone, Session};

#[path = "../tests/followers/mod.rs"]
mod followers;
use followers::followers;

/// The program's own.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// The program's own stack.
const STACK: usize = 1 << 30;
/// Runs of each measurement; the best counts.
const RUNS: usize = 3;
/// How long one measurement takes at least, and how many runs may go into it.
const LEAST: Duration = Duration::from_millis(60);
const MOST_TIMES: u32 = 1 << 14;

fn load(text: &str) -> Environment {
    let parsed = parse(text);
    assert!(parsed.diagnostics.is_empty(), "{:?}", parsed.diagnostics.first());
    let mut environment = Environment::default();
    let mut batch = environment.open(&parsed.items, text);
    for (index, item) in parsed.items.iter().enumerate() {
        if let Err(errors) = environment.step(&mut batch, index, item) {
            panic!("{:?}", errors.first());
        }
    }
    environment
}

/// The time that the processor has spent on this thread.
fn spent(since: Instant) -> Duration {
    let told = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let spent = told.and_then(|text| text.split(' ').next()?.parse().ok());
    spent.map_or_else(|| since.elapsed(), Duration::from_nanos)
}

fn timed(text: &str) -> (Duration, Period) {
    let environment = load(text);
    let system = environment.system(&Name::new("Sys")).expect("a system");
    let run = || analyse(&system.components, &environment.definitions, &environment.assumptions).expect("a period");
    let measured = |times: u32| {
        let start = Instant::now();
        let before = spent(start);
        (0..times).for_each(|_| drop(run()));
        spent(start).saturating_sub(before)
    };
    // The processor's clock goes by ticks: so often that many of them pass.
    let mut times = 1;
    while times < MOST_TIMES && measured(times) < LEAST {
        times *= 2;
    }
    let best = (0..RUNS).map(|_| measured(times)).min().unwrap_or_default();
    (best / times, run())
}

/// Two components that talk in a straight line, time passing after each communication or after all of them.
fn line(operations: usize, slowly: bool) -> String {
    let (mut writer, mut reader) = (String::new(), String::new());
    for number in 0..operations / 2 {
        let wait = if slowly { "Delay_1 ; " } else { "" };
        let _ = write!(writer, "Out_{{c,{}}} ; {wait}", number % 7);
        reader.push_str("In_c<x> ; ");
    }
    format!("proc Writer = {writer}Delay_1 ; Writer\nproc Reader = {reader}Reader\nsystem Sys = Writer | Reader\n")
}

/// A ring of components, each with two operations a round.
fn ring(components: usize) -> String {
    let mut text = String::new();
    let mut all = Vec::new();
    for number in 0..components {
        let (own, next) = (format!("c{number}"), format!("c{}", (number + 1) % components));
        let body = if number == 0 {
            format!("Delay_1 ; Out_{{{next},1}} ; In_{own}<x>")
        } else {
            format!("In_{own}<x> ; Out_{{{next},1}}")
        };
        let _ = writeln!(text, "proc Part{number} = {body} ; Part{number}");
        all.push(format!("Part{number}"));
    }
    format!("{text}system Sys = {}\n", all.join(" | "))
}

/// A mission of so many states: each goes to a place of its own, then the next begins.
fn mission(states: usize) -> String {
    let mut text = String::from(
        "observer At(r)\nparam t > 0, p0\nfn s(d)\nproc World_r = (Delay_t # Odo_r # At_r) ; In_v<u> ; World_{r+u*t}\n\
         proc Odo_r = Out_{p,r} ; Odo_r\nproc Go_g = In_p<r> ; Neq_{r,g} ; Out_{v,s(g-r)} ; Go_g\n",
    );
    for state in 0..states {
        let _ = writeln!(text, "proc State{state} = Go_{{{}}} ; State{}", state * 2 + 1, (state + 1) % states);
    }
    format!("{text}system Sys = World_{{p0}} | State0\n")
}

/// Robots in a ring; each moves half way towards its neighbour's place, all places symbols.
fn robots(count: usize) -> String {
    let places: Vec<String> = (0..count).map(|number| format!("p{number}")).collect();
    let mut text = format!("observer At(i, r)\nparam t > 0, {}\n", places.join(", "));
    let mut all = Vec::new();
    for number in 0..count {
        let before = (number + count - 1) % count;
        let _ = writeln!(
            text,
            "proc Robot{number}_r = (Delay_t # At_{{{number},r}}) ; (Out_{{c{number},r}} | In_c{before}<q>) ; \
             Robot{number}_{{r+(q-r)/2}}"
        );
        all.push(format!("Robot{number}_{{p{number}}}"));
    }
    format!("{text}system Sys = {}\n", all.join(" | "))
}

fn scaled(name: &str, sizes: &[usize], make: impl Fn(usize) -> String) {
    let mut before: Option<f64> = None;
    for size in sizes {
        let (time, period) = timed(&make(*size));
        let seconds = time.as_secs_f64();
        let growth = before
            .map_or(String::new(), |before| format!(", {:.1} times the time of the size before", seconds / before));
        let (phases, segments) = (
            period.phases.len(),
            period.phases.iter().flat_map(|phase| &phase.edges).map(|edge| edge.segments.len()).sum::<usize>(),
        );
        println!(
            "{name} {size}: {phases} phases, {segments} segments in {:.3} ms, {:.1} microseconds each{growth}",
            seconds * 1e3,
            seconds * 1e6 / *size as f64
        );
        before = Some(seconds);
    }
}

/// The question `period Sys` as a whole: read, analysed, each way checked by the kernel, and told.
fn whole(name: &str, sizes: &[usize], make: impl Fn(usize) -> String) {
    let mut before: Option<f64> = None;
    for size in sizes {
        let source = Source::new("bench", format!("{}period Sys\n", make(*size)));
        let run = || {
            let mut session = Session::new(Rc::new(Alone)).unwrap_or_else(|_| panic!("a session"));
            let mut checked = false;
            let start = Instant::now();
            session.run(&source, &mut |output, _| {
                if let Output::Answer(answer) = output {
                    checked |= answer.lines.iter().any(|line| line.contains("by the kernel: all"));
                }
            });
            (start.elapsed(), checked)
        };
        let runs: Vec<(Duration, bool)> = (0..RUNS).map(|_| run()).collect();
        let seconds = runs.iter().map(|(time, _)| *time).min().unwrap_or_default().as_secs_f64();
        let how = if runs.iter().all(|(_, checked)| *checked) { "checked by the kernel" } else { "not all checked" };
        let growth = before
            .map_or(String::new(), |before| format!(", {:.1} times the time of the size before", seconds / before));
        println!("{name} {size}, {how}: {:.1} ms{growth}", seconds * 1e3);
        before = Some(seconds);
    }
}

fn all() {
    let sizes = [10, 100, 1_000, 10_000];
    whole("the whole question, operations in one instant", &sizes, |size| line(size, false));
    whole("the whole question, operations in time", &sizes, |size| line(size, true));
    whole("the whole question, a ring", &sizes, |size| ring(size / 2));
    whole("the whole question, robots with worlds and controllers", &[4, 10, 100, 1_000], followers);
    scaled("port operations in one instant, two components", &sizes, |size| line(size, false));
    scaled("port operations one after another in time, two components", &sizes, |size| line(size, true));
    scaled("port operations in a ring of components", &sizes, |size| ring(size / 2));
    scaled("states of a mission", &[10, 100], mission);
    scaled("robots with real positions", &[4, 10, 100, 1_000], robots);
    scaled("robots with worlds and controllers", &[4, 10, 100, 1_000], followers);
}

fn main() {
    let work = std::thread::Builder::new().stack_size(STACK).spawn(|| {
        pars::term::room::tell(STACK);
        all();
    });
    if work.map(|thread| thread.join().is_err()).unwrap_or(true) {
        std::process::exit(1);
    }
}
