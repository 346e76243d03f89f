//! How long rounds take in the end, by the greatest cycle of waits, is what the phases of the same network come to, where its
//! delays are numbers: loops at any rates, beside each other within a component, with a start of their own.

use pars::library;
use pars::lower::Environment;
use pars::parser::parse;
use pars::period::{Period, analyse, greatest_cycle};
use pars::value::Value;

mod dice;
use dice::Dice;

/// A use of a port: which one, and whether it is written.
type Use = (usize, bool);

/// One component as it is written: each of these uses so many times, in some order, with delays between.
fn written(dice: &mut Dice, number: usize, uses: &[(Use, usize)]) -> String {
    let mut steps: Vec<String> = Vec::new();
    for ((port, writes), times) in uses {
        for _ in 0..*times {
            let what = if *writes { format!("Out_{{p{port},k}}") } else { format!("In_p{port}<u{}>", steps.len()) };
            steps.insert(dice.place(steps.len() + 1), what);
        }
    }
    for _ in 0..dice.place(3) {
        let place = dice.place(steps.len() + 1);
        steps.insert(place, format!("Delay_{{{}}}", dice.one_of(&["1", "2", "3", "1/2", "5", "d"])));
    }
    // Two neighbours stand side by side, if they use different ports.
    let port = |step: &str| step.split(['p', ',', '<']).nth(1).map(str::to_string);
    if steps.len() > 1 && dice.place(2) == 0 {
        let place = dice.place(steps.len() - 1);
        if port(&steps[place]) != port(&steps[place + 1]) || steps[place].starts_with("Delay") {
            let second = steps.remove(place + 1);
            steps[place] = format!("({} | {second})", steps[place]);
        }
    }
    let start = match dice.place(3) {
        0 => format!("proc Start{number} = Delay_{{{}}} ; P{number}_{{2,0}}", dice.one_of(&["1", "7", "3/2"])),
        1 => {
            let before = steps[..dice.place(steps.len().min(3) + 1)].join(" ; ").replace(['k', 'd'], "2");
            let before = if before.is_empty() { "Delay_1".to_string() } else { before };
            format!("proc Start{number} = {before} ; P{number}_{{1,0}}")
        }
        _ => format!("proc Start{number} = P{number}_{{3,0}}"),
    };
    format!("proc P{number}_{{d,k}} = {} ; P{number}_{{d,k+1}}\n{start}\n", steps.join(" ; "))
}

/// Components in a row or a ring, each of which writes to the next one at rates that agree.
fn network(dice: &mut Dice) -> String {
    let (many, ring) = (2 + dice.place(3), dice.place(2) == 0);
    let times: Vec<usize> = (0..many).map(|_| 1 + dice.place(2)).collect();
    let mut uses: Vec<Vec<(Use, usize)>> = vec![Vec::new(); many];
    let mut link = |port: usize, writer: usize, reader: usize| {
        let common = if times[writer] == times[reader] { 1 } else { 2 };
        uses[writer].push(((port, true), common / times[writer].min(common)));
        uses[reader].push(((port, false), common / times[reader].min(common)));
    };
    for writer in 0..many - 1 {
        link(writer, writer, writer + 1);
    }
    if ring {
        link(many, if many == 2 { 0 } else { many - 1 }, if many == 2 { 1 } else { 0 });
    }
    let text: String = uses.iter().enumerate().map(|(number, uses)| written(dice, number, uses)).collect();
    let names: Vec<String> = (0..many).map(|number| format!("Start{number}")).collect();
    format!("{text}system S = {}\n", names.join(" | "))
}

/// The rounds of each component in one period.
type Rounds = Vec<(String, u64)>;

/// How long a period takes, and how often each component goes round in it.
fn by_phases(period: &Period, environment: &Environment) -> Option<(Value, Rounds)> {
    let rounds = period.repetitions(&environment.definitions, &environment.assumptions, &|| false)?;
    Some((period.lasting()?, rounds))
}

#[test]
fn rounds_take_the_time_of_their_greatest_cycle() {
    let mut dice = Dice(7_301);
    let (mut told, mut several) = (0, 0);
    for _ in 0..1_000 {
        let text = network(&mut dice);
        let mut environment = library::standard().unwrap();
        let parsed = parse(&text);
        assert!(parsed.diagnostics.is_empty(), "{text}{:?}", parsed.diagnostics);
        for declared in environment.declare(&parsed.items, &text) {
            declared.unwrap();
        }
        let system = environment.system(&"S".into()).unwrap();
        let (definitions, known) = (&environment.definitions, &environment.assumptions);
        let period = analyse(&system.components, definitions, known);
        let Some(found) = greatest_cycle(&system.components, definitions, known) else { continue };
        let period = period.unwrap_or_else(|failures| panic!("{text}{failures:?}"));
        assert!(period.repeats(), "{text}");
        let Some((lasting, rounds)) = by_phases(&period, &environment) else { continue };
        let times = |rounds: &Rounds| Value::integer(i64::try_from(rounds[0].1).unwrap());
        let ratio = (lasting.mul(&times(&found.rounds)).unwrap(), found.time.mul(&times(&rounds)).unwrap());
        assert_eq!(ratio.0, ratio.1, "{text}{lasting} for {rounds:?}, {found:?}");
        // Where it spans several rounds, they may come back before.
        assert_eq!(found.rounds[0].1 % rounds[0].1, 0, "{text}{rounds:?}, {found:?}");
        told += 1;
        several += usize::from(found.rounds.iter().any(|(_, times)| *times > 2));
    }
    assert!(told > 500 && several > 100, "{told} {several}");
}
