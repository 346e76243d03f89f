//! Phase graphs: pictures in which nothing covers anything else, the flow for print, and work that is interrupted.

mod common;
mod followers;

use std::cell::Cell;
use std::collections::BTreeMap;
use std::fmt::Write as _;

use common::ran;
use followers::followers;
use pars::flow::flows;
use pars::latex;
use pars::lower::Environment;
use pars::name::Name;
use pars::parser::parse;
use pars::period::{Edge, Failure, Period, analyse, analyse_until, graph};
use pars::transition_system::svg;
use pars::value::Value;

fn declared(text: &str) -> Environment {
    let parsed = parse(text);
    assert!(parsed.diagnostics.is_empty(), "{:?}", parsed.diagnostics.first());
    let mut environment = Environment::new();
    environment.declare(&parsed.items, text);
    environment
}

fn period(text: &str) -> (Environment, Period) {
    let environment = declared(text);
    let system = environment.system(&Name::new("Sys")).expect("a system");
    let period = analyse(&system.components, &environment.definitions, &environment.assumptions).expect("a period");
    (environment, period)
}

/// A mission of so many states, each with a place of its own.
fn mission(states: usize) -> String {
    let mut text = String::from(
        "observer Here(r)\nparam t > 0, p0\nfn s(d)\nproc World_r = (Delay_t # Odo_r # Here_r) ; In_v<u> ; World_{r+u*t}\n\
         proc Odo_r = Out_{p,r} ; Odo_r\nproc Go_g = In_p<r> ; Neq_{r,g} ; Out_{v,s(g-r)} ; Go_g\n",
    );
    for state in 0..states {
        let _ = writeln!(text, "proc State{state} = Go_{{{}}} ; State{}", state * 2 + 1, (state + 1) % states);
    }
    text + "system Sys = World_{p0} | State0\n"
}

/// The number behind a name in a tag.
fn number(tag: &str, name: &str) -> f64 {
    let (_, rest) = tag.split_once(&format!(" {name}=\"")).expect(name);
    rest.split('"').next().and_then(|text| text.parse().ok()).expect(name)
}

#[test]
fn a_picture_of_a_hundred_phases_is_readable() {
    let (_, period) = period(&mission(100));
    assert_eq!(period.phases.len(), 100);
    let picture = svg(&graph::system(&period)).expect("a picture");
    let head = picture.lines().next().expect("a head");
    let (width, height) = (number(head, "width"), number(head, "height"));
    assert!(height < 2.0 * width && width < 3.0 * height, "{width} by {height}");
    // What is written beside a state covers no other text: six units a letter, twelve a line.
    let mut boxes: Vec<([f64; 4], &str)> = Vec::new();
    for line in picture.lines().filter(|line| line.starts_with("<text")) {
        let (tag, rest) = line.split_once('>').expect("a tag");
        let (text, _) = rest.split_once("</text>").expect("its end");
        let letters = text.replace("&lt;", "<").replace("&gt;", ">").chars().count() as f64 * 6.0;
        let (x, y) = (number(tag, "x"), number(tag, "y"));
        let left = match tag {
            tag if tag.contains("\"middle\"") => x - letters / 2.0,
            tag if tag.contains("\"end\"") => x - letters,
            _ => x,
        };
        boxes.push(([left, y - 10.0, left + letters, y], text));
    }
    let covers = |one: &[f64; 4], other: &[f64; 4]| {
        one[0] < other[2] && other[0] < one[2] && one[1] < other[3] && other[1] < one[3]
    };
    for (place, (one, text)) in boxes.iter().enumerate() {
        for (other, covered) in &boxes[place + 1..] {
            assert!(!covers(one, other), "{text} covers {covered}");
        }
    }
}

#[test]
fn the_flow_for_print_has_indices_and_ways_on() {
    let (environment, period) = period(
        "proc World_r = (Delay_1 # Odo_r) ; In_v<u> ; World_{r+u}\nproc Odo_r = Out_{p,r} ; Odo_r\n\
         proc Go_g = In_p<r> ; Lss_{r,g} ; Out_{v,1} ; Go_g\nproc Trip = Go_9 ; Back_0 ; Trip\n\
         proc Back_g = In_p<r> ; Gtr_{r,g} ; Out_{v,-1} ; Back_g\nsystem Sys = World_0 | Trip\n",
    );
    let text = latex::phases(&flows(&period, &environment), &environment.assumptions);
    for part in [
        "\\text{again} &= \\quad \\text{while } r < 9\\ \\text{after the round}",
        "r_{n+1} &= r_{n}+1",
        "r_{n} &= n+r_{0}",
        "\\text{then} &= \\text{phase 2} \\quad \\text{if } r+1 \\ge 9",
    ] {
        assert!(text.contains(part), "{part} is not in\n{text}");
    }
}

#[test]
fn the_flow_for_print_says_what_passes_on_ways_out_and_what_parameters_become() {
    let (environment, flow) = period(
        "observer At(r)\nproc W_r = (Delay_1 # At_r) ; ((Gtr_{r,3} ; (Delay_2 # At_{0-r}) ; V_{r*2}) | (Lte_{r,3} ; W_{r+1}))\n\
         proc V_s = (Delay_5 # At_s) ; ((Gtr_{s,0} ; V_{s-1}) | (Lte_{s,0} ; W_{s+1}))\nsystem Sys = W_0\n",
    );
    let text = latex::phases(&flows(&flow, &environment), &environment.assumptions);
    let shown =
        |time: &str, place: &str| format!("(\\mathsf{{Delay}}_{{{time}}}\\mathbin{{\\#}}\\mathsf{{At}}_{{{place}}})");
    let passes = format!("{}\\mathbin{{;}}{}", shown("1", "r"), shown("2", "-r"));
    let leaves =
        format!("\\text{{phase 2}}\\text{{ after }}{passes}\\text{{, lasting }}3\\text{{ with }}s = 2\\cdot r");
    assert!(text.contains(&leaves), "{leaves} is not in\n{text}");
    assert!(text.contains("\\text{phase 1}\\text{ with }r = s+1"), "{text}");
    let (environment, flow) = period(
        "observer At(r)\nparam t > 0\nproc World_r = (Delay_t # Odo_r # At_r) ; In_v<u> ; World_{r+u*t}\n\
         proc Odo_r = Out_{p,r} ; Odo_r\nproc Drive = In_p<r> ; Out_{v,1} ; Drive\nproc Once = Delay_t ; Stop\n\
         system Sys = World_0 | Drive | Once\n",
    );
    let text = latex::phases(&flows(&flow, &environment), &environment.assumptions);
    assert!(text.contains("\\text{flow} &= r\\text{ from }0\\text{ to }t"), "{text}");
}

#[test]
fn the_flow_for_print_has_cases_ports_and_draws() {
    let (environment, flow) = period(
        "observer At(r)\nparam t > 0\nproc W_r = (Delay_t # O_r # At_r) ; In_v<u> ; W_{r+u*t}\nproc O_r = Out_{p,r} ; O_r\n\
         proc G_g = In_p<r> ; Neq_{r,g} ; Out_{v,clamp(g-r,-1,1)/t} ; G_g\nproc M = G_3 ; G_0 ; M\nsystem Sys = W_0 | M\n",
    );
    let text = latex::phases(&flows(&flow, &environment), &environment.assumptions);
    for part in [
        "r_{n} &= n+r_{0} \\quad (n < 3-\\lfloor r_{0}\\rfloor ) \\quad \\text{if } r_{0} < 3",
        "r_{n} &= r_{0} \\quad \\text{if } r_{0} = 3",
        "\\text{port }v &= \\operatorname{clamp}(3-r,-1,1)/t",
    ] {
        assert!(text.contains(part), "{part} is not in\n{text}");
    }
    let (environment, flow) = period(
        "observer At(r)\nparam k, s > 0\nproc N_r = (Delay_1 # O_r # At_r) ; (Ran_{Normal(0, sd: s)}<e> | In_v<u>) ; N_{r+u+e}\n\
         proc O_r = Out_{p,r} ; O_r\nproc G = In_p<r> ; Out_{v,sqrt(2)*(k-r)} ; G\nsystem Sys = N_0 | G\n",
    );
    let text = latex::phases(&flows(&flow, &environment), &environment.assumptions);
    for part in ["e^{(1)} &\\sim \\mathsf{Normal}(0,", "\\sqrt{2}", "r_{n+1} &= "] {
        assert!(text.contains(part), "{part} is not in\n{text}");
    }
    let rows = text.lines().filter(|line| line.contains("&="));
    assert!(rows.clone().count() > 3 && rows.into_iter().all(|line| !line.contains("\\texttt")), "{text}");
}

#[test]
fn work_that_is_interrupted_says_so() {
    let environment = declared(&mission(100));
    let system = environment.system(&Name::new("Sys")).expect("a system");
    let asked = Cell::new(0);
    let soon = || {
        asked.set(asked.get() + 1);
        asked.get() > 10
    };
    let found = analyse_until(&system.components, &environment.definitions, &environment.assumptions, &soon);
    assert_eq!(found.err(), Some(vec![Failure::Interrupted]));
    assert!(asked.get() < 20, "the wish to stop is heard at once");
}

/// Where the phases lead, followed from the start: the times are symbols, what the guards look at are numbers.
#[test]
fn a_mission_is_followed_to_its_end() {
    use pars::period::course::Course;
    use pars::value::Value;

    let counting = |k: &str| {
        format!(
            "observer At(r)\nparam t > 0, k\nproc Go_k = Gtr_{{k,0}} ; Out_{{v,1}} ; Delay_t ; Go_{{k-1}}\n\
             proc World_r = (Delay_t # At_r) ; In_v<u> ; World_{{r+u}}\nsystem Sys = Go_{{{k}}} | World_0\n"
        )
    };
    let course = |k: &str| {
        let (environment, period) = period(&counting(k));
        period.course(&environment.assumptions, &|| false)
    };
    let after = |rounds: i64| Value::integer(rounds).mul(&Value::variable(&Name::new("t"))).expect("a product");
    for rounds in [1, 2, 6, 40] {
        let Some(Course::Ends(_, time)) = course(&rounds.to_string()) else { panic!("{rounds} rounds come to an end") };
        // Nothing is to be read any more when the last place has been shown for its time.
        assert_eq!(time, after(rounds + 1));
    }
    assert_eq!(course("k"), None, "how often it goes round is not known");
    let (environment, period) = period(&counting("1000000"));
    let asked = Cell::new(0);
    let interrupted = || {
        asked.set(asked.get() + 1);
        asked.get() > 3
    };
    assert_eq!(period.course(&environment.assumptions, &interrupted), None);
    assert_eq!(asked.get(), 4, "it stops when it is asked to");
}

/// What grows beside a mission does not keep it from coming again, but where a time or a meaning depends on it.
#[test]
fn what_nothing_asks_for_is_beside() {
    use pars::period::course::Course;
    use pars::value::Value;

    let course = |world: &str, start: &str| {
        let (environment, period) = period(&format!(
            "observer At(r)\nparam t > 0\n\
             proc On_k = (Gtr_{{k,0}} ; Out_{{v,1}} ; Delay_t ; On_{{k-1}}) | (Eq_{{k,0}} ; Delay_{{2*t}} ; On_5)\n\
             proc World_r = {world}\nsystem Sys = On_5 | World_{{{start}}}\n"
        ));
        period.course(&environment.assumptions, &|| false)
    };
    let turns = |count: i64| Value::integer(7 * count).mul(&Value::variable(&Name::new("t"))).expect("a product");
    let round = |found: Option<Course>| match found {
        Some(Course::Repeats { lasting, beside, .. }) => Some((lasting, beside.len())),
        _ => None,
    };
    // A turn is five steps of t and a rest of 2t.
    assert_eq!(round(course("In_v<u> ; World_{r+u}", "0")), Some((turns(1), 1)));
    // Five changes of sign in a turn: all is as it was after two.
    assert_eq!(round(course("In_v<u> ; World_{-r}", "1")), Some((turns(2), 0)));
    // What is shown is not asked for, but it may lose its meaning.
    assert_eq!(round(course("In_v<u> ; (Delay_t # At_{r+u}) ; World_{r+u}", "0")), Some((turns(1), 1)));
    assert_eq!(course("In_v<u> ; (Delay_t # At_{1/(r-77)}) ; World_{r+u}", "1/2"), None);
    assert_eq!(course("In_v<u> ; World_{1/(r+u)}", "1"), None);
    let (environment, slower) = period(
        "param t > 0\n\
         proc On_k = (Gtr_{k,0} ; In_p<y> ; Out_{v,1} ; Delay_{t+y^2*t} ; On_{k-1}) | (Eq_{k,0} ; Delay_{2*t} ; On_5)\n\
         proc World_r = Out_{p,r} ; In_v<u> ; World_{r+u}\nsystem Sys = On_5 | World_0\n",
    );
    assert_eq!(slower.course(&environment.assumptions, &|| false), None, "it takes longer each time");
}

#[test]
fn long_sequences_are_theorems_too() {
    let writer: String = (0..3_000).map(|number| format!("Out_{{c,{}}} ; ", number % 7)).collect();
    let text = format!(
        "observer See(x)\nproc Writer = {writer}Delay_1 ; Writer\nproc Sum_s = In_c<x> ; In_c<y> ; Sum_{{s+x*y}}\n\
         proc Reader = In_c<z> ; Reader\nsystem Alone = Writer | Reader\nperiod Alone\n\
         system Both = Writer | Sum_0\nperiod Both\n"
    );
    let output = ran(&text);
    let told = String::from_utf8_lossy(&output.stdout);
    let told: Vec<&str> = told.lines().filter(|line| line.contains("by the kernel")).collect();
    assert_eq!(told, ["    by the kernel: all 2 ways from start and phases, with their flow functions"; 2]);
}

/// Robots in a ring, of which several start at the same place: each comes to a variable of its own, which its odometer shares,
/// and what the phase says of them is what they do.
#[test]
fn places_that_start_alike_come_apart() {
    let count = 24usize;
    let (_, period) = period(&followers(count));
    assert_eq!((period.phases.len(), period.phases[0].variables.len()), (1, count));
    let shown = |edge: &Edge, values: &BTreeMap<Name, Value>| -> BTreeMap<Value, Value> {
        let observed = edge.segments.iter().flat_map(|segment| &segment.observed);
        let places =
            observed.map(|term| term.values().map(|value| value.substitute(values).expect("a value")).collect());
        places.map(|place: Vec<Value>| (place[0].clone(), place[1].clone())).collect()
    };
    let mut plain: Vec<Value> = (0..count).map(|number| Value::integer((number * number % 7) as i64)).collect();
    let mut values = period.initial[0].map.clone();
    for _ in 0..30 {
        let edge = &period.phases[0].edges[0];
        let wanted = plain.iter().enumerate().map(|(number, place)| (Value::integer(number as i64), place.clone()));
        assert_eq!(shown(edge, &values), wanted.collect());
        let image = |value: &Value| value.substitute(&values).expect("a value");
        values = edge.map.iter().map(|(name, value)| (name.clone(), image(value))).collect();
        let third = Value::fraction(1, 3).expect("a number");
        let step = |number: usize| plain[(number + 1) % count].sub(&plain[number]).and_then(|gap| gap.mul(&third));
        plain =
            (0..count).map(|number| step(number).and_then(|step| plain[number].add(&step)).expect("a place")).collect();
    }
}

/// The command says of each order of two delays what the script says.
#[test]
fn each_order_of_two_delays_is_told_by_the_command() {
    let text = "observer S(x)\nparam t > 0, w > 0\nproc Left_k = Out_{a,k} ; (Delay_w # S_k) ; Left_{k+1}\n\
        proc Right = In_a<x> ; Delay_t ; Right\nsystem Sys = Left_0 | Right\n";
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("orders.pars");
    std::fs::write(&path, text).expect("a file");
    let path = path.to_str().expect("a path");
    let told = |more: &[&str]| {
        let output = std::process::Command::new(env!("CARGO_BIN_EXE_pars"))
            .args(["period", path, "--color", "never"])
            .args(more)
            .output()
            .expect("pars runs");
        let text = [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned()).concat();
        (text, output.status.code().unwrap_or(-1))
    };
    let (each, code) = told(&[]);
    assert_eq!(code, 0, "{each}");
    for line in ["if w < t:", "if w = t:", "if w > t:", "  rounds: Left 1, Right 1", "  lasting: t"] {
        assert!(each.lines().any(|one| one == line), "{line}: {each}");
    }
    let script = String::from_utf8_lossy(&ran(&format!("{text}period Sys\n")).stdout).into_owned();
    let same: Vec<&str> = script.lines().skip(1).map(|line| line.strip_prefix("    ").unwrap_or(line)).collect();
    assert_eq!(each.lines().collect::<Vec<_>>(), same);
    let (picture, code) = told(&["--format", "svg"]);
    let inner = picture.matches("<g transform").count();
    assert!(code == 0 && inner == 3 && picture.contains(">if w &lt; t</text>"), "{picture}");
    let (graphs, _) = told(&["--format", "dot"]);
    assert_eq!(graphs.matches("digraph").count(), 3, "{graphs}");
    assert!(graphs.contains("digraph \"if w < t\" {\n  label=\"if w < t\";"), "{graphs}");
    let (print, code) = told(&["--format", "latex"]);
    assert!(code == 0 && print.matches("\\paragraph{if w ").count() == 3, "{print}");
    assert_eq!(print.matches("f(k) &= k+1").count(), 3, "{print}");
    // What ends has no period, however it is written.
    let ends = text.replace("Left_{k+1}", "Stop");
    std::fs::write(path, ends).expect("a file");
    assert_eq!((told(&[]).1, told(&["--format", "latex"]).1), (1, 1));
}

/// Of several values that are expected those are named that are not so, behind `flow`, `period` and `solve`.
#[test]
fn each_value_that_is_expected_is_right_or_wrong_by_itself() {
    let script = "proc A_k = Delay_1 ; A_{k+1}\nsystem S = A_0\nflow S\nexpect f(k) = k+1, lasting1 = 2, phases = 1\n\
        expect f(k) = k, f2(k) = k+1, f(z) = z+1, k(n) = k0+n\nperiod S\nexpect lasting = 1, phases = 2\n\
        solve T(n+1) = 2*T(n), T(0) = 1\nexpect T(n) = 2^n, T(5) = 31, T(4) = 16\n";
    let output = ran(script);
    let told = String::from_utf8_lossy(&output.stdout).into_owned();
    let unmet: Vec<&str> = told.lines().filter_map(|line| line.trim().strip_prefix("but expected ")).collect();
    assert_eq!(unmet, ["lasting1 = 2", "f(k) = k", "f2(k) = k+1", "f(z) = z+1", "phases = 2", "T(5) = 31"], "{told}");
    assert_eq!(output.status.code(), Some(1), "{told}");
}

/// What is expected of a flow is so in every order of delays, also in one without a period, and of the very index that is named.
#[test]
fn a_flow_is_as_expected_in_every_order_and_at_each_index() {
    let unmet = |script: &str| {
        let told = String::from_utf8_lossy(&ran(script).stdout).into_owned();
        let unmet = told.lines().filter_map(|line| line.trim().strip_prefix("but expected "));
        unmet.map(str::to_string).collect::<Vec<_>>()
    };
    let orders = "param a > 0, b > 0\nproc D_r = Delay_a ; In_c<x> ; Delay_b ; D_{r+x}\n\
        proc E_q = Delay_b ; In_c<y> ; Delay_a ; E_{q+y}\nproc W_k = Out_{c,k} ; W_{k+1}\nsystem S = D_0 | E_0 | W_0\n\
        flow S\nexpect f1(k) = k+2, lasting1 = a+b\n";
    assert_eq!(unmet(orders), ["f1(k) = k+2", "lasting1 = a+b"]);
    let script = "param r0, u > 0\nproc A_r = (Delay_u # At_r) ; A_{r+u}\nsystem S = A_{r0}\nflow S\n\
        expect r(n) = r0+n*u, r(10) = r0+10*u, r(10) = r0+n*u, r(k) = r0+k*u\n";
    assert_eq!(unmet(script), ["r(10) = r0+n*u", "r(k) = r0+k*u"]);
}

/// Two readers of a sensor that draws anew compete, and it is said what would do.
#[test]
fn who_competes_for_another_value_is_told_what_would_do() {
    let script = |write: &str, port: &str| {
        format!(
            "proc Noisy = Ran_{{Uniform(0,1)}}<w> ; {write} ; Noisy\nproc One = In_p<x> ; Delay_1 ; One\n\
             proc Two = In_{port}<x> ; Delay_1 ; Two\nsystem S = Noisy | One | Two\nperiod S\n"
        )
    };
    let told = |text: &str| String::from_utf8_lossy(&ran(text).stdout).into_owned();
    let races = told(&script("Out_{p,w}", "p"));
    assert!(races.contains("Noisy writes another value there each time"), "{races}");
    assert!(races.contains("`(Out_{p,…} | Out_{p2,…})`, on a port for each"), "{races}");
    let apart = told(&script("(Out_{p,w} | Out_{p2,w})", "p2"));
    assert!(apart.contains("lasting: 1") && apart.contains("by the kernel: all"), "{apart}");
}

/// Eight guards asked at one moment are 256 ways: the run takes two of them, and nobody in it waits for ever.
#[test]
fn very_many_ways_are_followed_along_the_run() {
    let guards: String = (0..8).map(|place| format!("try(Eq_{{a{place},{}}}) ; ", 2 * place)).collect();
    let names = (0..8).map(|place| format!("a{place}")).collect::<Vec<_>>().join(",");
    let next = (0..8).map(|place| format!("{}-a{place}", 4 * place + 1)).collect::<Vec<_>>().join(",");
    let start = (0..8).map(|place| (2 * place).to_string()).collect::<Vec<_>>().join(",");
    let text = format!(
        "proc Tick_d = Delay_1 ; Delay_{{abs(d)+1}} ; Out_{{t,1}} ; Tick_{{1-d}}\nproc R({names}) = In_t<y> ; {guards}R({next})\n\
         system Sys = Tick_0 | R({start})\nperiod Sys\nexpect lasting = 5\nflow Sys\n"
    );
    let output = ran(&text);
    let told = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success() && !told.contains("warning"), "{told}");
    assert!(
        told.contains("ways that the run takes") && told.contains("the ways are those that the run takes"),
        "{told}"
    );
}
