//! Calls in no time: what is accepted never goes round for ever at once, whatever the values; what would is refused.

mod common;

use std::collections::BTreeSet;

use proptest::prelude::*;

use common::{call, int, seeded};
use pars::lower::Environment;
use pars::model::Model;
use pars::parser::parse;

/// The codes of what is refused in a text, with its environment.
fn declared(text: &str) -> (Environment, BTreeSet<String>) {
    let parsed = parse(text);
    assert!(parsed.diagnostics.is_empty(), "{text}: {:?}", parsed.diagnostics.first());
    let mut environment = Environment::new();
    let outcomes = environment.declare(&parsed.items, text);
    let codes = outcomes.into_iter().filter_map(Result::err).flatten().map(|error| error.code.to_string());
    let codes = codes.collect();
    (environment, codes)
}

/// An expression over the parameters.
fn expression() -> impl Strategy<Value = String> {
    prop::sample::select(vec!["x", "y", "x-1", "y-1", "x+1", "x+y", "2*x", "0", "2", "3"]).prop_map(str::to_string)
}

/// What stands before a call: nothing, something that takes no time, or a delay.
fn before() -> impl Strategy<Value = String> {
    let guard = (prop::sample::select(vec!["Gtr", "Lte", "Eq", "Neq"]), expression(), expression());
    let guard = guard.prop_map(|(relation, left, right)| format!("{relation}_{{{left},{right}}} ; "));
    prop_oneof![
        3 => Just(String::new()),
        3 => Just("Delay_1 ; ".to_string()),
        2 => guard,
        1 => expression().prop_map(|value| format!("try(Gtr_{{{value},1}}) ; ")),
        1 => expression().prop_map(|value| format!("(Eq_{{{value},1}} | Gtr_{{{value},0}}) ; ")),
        1 => Just("Bind_x<z> ; Gtr_{z,0} ; ".to_string()),
    ]
}

/// Two branches that exclude each other, each with what it does before it calls a process.
fn body() -> impl Strategy<Value = String> {
    let tail = || {
        let to = prop::sample::select(vec!["A", "B", "C"]);
        (before(), to, expression(), expression())
            .prop_map(|(before, to, one, other)| format!("{before}{to}_{{{one},{other}}}"))
    };
    (expression(), 0..3, tail(), tail()).prop_map(|(value, bound, some, others)| {
        format!("(Gtr_{{{value},{bound}}} ; {some}) | (Lte_{{{value},{bound}}} ; {others})")
    })
}

proptest! {
    #![proptest_config(seeded(ProptestConfig { max_global_rejects: 10_000, ..ProptestConfig::with_cases(500) }))]

    #[test]
    fn what_is_accepted_does_not_go_round_in_no_time(a in body(), b in body(), c in body()) {
        let text = format!(
            "proc Bind_x<z> = Set_{{x-1}}<z>\nproc A_{{x,y}} = {a}\nproc B_{{x,y}} = {b}\nproc C_{{x,y}} = {c}\n"
        );
        let (environment, codes) = declared(&text);
        prop_assume!(codes.is_empty());
        let model = Model::new(&environment.definitions);
        for (x, y) in (-3..6).flat_map(|x| (-3..6).map(move |y| (x, y))) {
            for name in ["A", "B", "C"] {
                if let Err(wrong) = model.state(&call(name, vec![int(x), int(y)])) {
                    prop_assert!(false, "{name} at {x}, {y}: {wrong:?}\n{text}");
                }
            }
        }
    }
}

/// Each with whether it comes to an end in no time.
const COUNTERS: [(&str, bool); 11] = [
    ("proc A_n = Gtr_{n,0} ; B_{n,3}\nproc B_{n,m} = (Gtr_{m,0} ; Delay_1 ; B_{n,m-1}) | (Eq_{m,0} ; A_{n-1})", true),
    ("proc A_n = Gtr_{n,0} ; B_{n,0}\nproc B_{n,m} = (Gtr_{m,0} ; Delay_1 ; B_{n,m-1}) | (Eq_{m,0} ; A_{n-1})", false),
    // It does come to an end, but not after a number of calls that is the same for all values.
    ("proc A_n = Gtr_{n,0} ; A_{n-1}", false),
    ("proc A_n = Gtr_{n,0} ; Lss_{n,5} ; A_{n+1}", true),
    ("proc A_n = Gtr_{n,0} ; Lss_{n,5} ; A_{n+1/100}", false),
    ("param k > 0\nproc A_n = Gtr_{n,0} ; B_{n,k}\nproc B_{n,m} = Lte_{m,0} ; A_{n-1}", true),
    ("param k\nproc A_n = Gtr_{n,0} ; B_{n,k}\nproc B_{n,m} = Lte_{m,0} ; A_{n-1}", false),
    ("proc A_n = Set_{n+1}<m> ; Lss_{m,3} ; Gtr_{n,0} ; A_m", true),
    // Rounds of which there is one at least let time pass.
    ("proc A_k = (Lss_{k,2} ; (Delay_1)^2 ; Set_{k+1}<j> | Gte_{k,2} ; Delay_1 ; Set_0<j>) ; A_j", true),
    // What was known of m before it is bound anew counts no more.
    ("proc A_n = Set_1<c> ; Set_n<c> ; B_c\nproc B_m = Neq_{m,1} ; A_m", false),
    ("proc A_n = try(Eq_{n,1}) ; B_n\nproc B_n = Neq_{n,1} ; A_n", false),
];

#[test]
fn counters_end_or_are_refused() {
    for (text, ends) in COUNTERS {
        let (_, codes) = declared(text);
        assert_eq!(codes, BTreeSet::from_iter((!ends).then(|| "P0603".to_string())), "{text}");
    }
}

/// A text of many processes that call each other in no time is answered, by a bounded search.
#[test]
fn many_calls_in_no_time_are_refused_soon() {
    let count = 2_000;
    let line = |place: usize| {
        let (next, other) = ((place + 1) % count, (place + 7) % count);
        format!("proc P{place}_x = (Gtr_{{x,{place}}} ; P{next}_{{x-1}}) | (Lte_{{x,{place}}} ; P{other}_{{x+1}})\n")
    };
    let (_, codes) = declared(&(0..count).map(line).collect::<String>());
    assert_eq!(codes, BTreeSet::from(["P0603".to_string()]));
}
