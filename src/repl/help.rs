//! What `:help` says.

use super::command::COMMANDS;
use crate::diagnostic::nearest;

const TOPICS: [(&str, &str); 11] = [
    (
        "processes",
        "Stop  Abort  Idle            end well, end badly, wait for ever
Delay_t                      wait for t
In_c<y>  Out_{c,x}           read y from port c, write x to it
Eq_{x,y} Neq Gtr Gte Lss Lte a guard: stop if true, abort if false, at once
Set_x<y>  Ran_D<y>           y is x; y is drawn from D
At_r                         an observer: shows where the robot is while it runs
P ; Q                        Q when P has stopped
P else Q                     Q when P has aborted
P | Q                        both, until both have ended
P # Q                        both, until one of them ends
P^n   loop(P)   try(P)       n rounds; until a round aborts; P else Stop
new c. P                     port c is private to P
P to {At}                    only what At shows
proc T_u = P_u ; T_{u+1}     a definition; one that calls itself is a loop\n",
    ),
    (
        "values",
        "1/10  0.1  x  ?x  (x, y)  + - * / ^  abs min max clamp norm floor ceil sqrt mod
if x > 0 then x else 0
param t > 0, n : natural     a parameter with what is assumed of it
fn s(d) = d / t              a function; without `= …` it is left open
Normal(0, sd: s)  Normal(0, var: v)  Exp(rate: l)  Poisson(rate: l)  Uniform(a, b)  Mix(1/2: D, 1/2: E)  Point(x)\n",
    ),
    (
        "claims",
        "prove P = Q                  they behave the same
prove P <= Q                 Q does the same and shows no more
prove name: P = Q            the claim has a name: `:why name`
prove P = Q when t > 0, never_aborts(?P)
prove P = Q by law, name     by these laws alone, and by earlier claims of these names
prove P = Q by { P = {law} R = {law} Q }
prove Sys satisfies Goal
prove Sys always |p-o| > 1 when At_p, Rock_o     whenever both are shown
prove probability of Sys reaching At_p where |p-9| <= 1 within 10 >= 9/10
expect proved | refuted | open | t1 = 10     behind the claim\n",
    ),
    (
        "systems",
        "system Sys = P | Q           the ports that they share are private to them
property Goal = Delay_{?t1} ; (Delay_{?t2} # At_a) ; Goal
period Sys                   what repeats, and the phases: expect yes | no | lasting = 2*t | phases = 3
flow Sys                     how a round changes the variables: expect f(r) = r+u | f2(r) = r | lasting2 = t
project P to {At}            what is seen of P
probability of Sys showing At_p where |p-9| <= 1 at 10     `by exact`, `enclosed`, `estimated`
prove Sys satisfies Goal\n",
    ),
    (
        "criteria",
        "criteria Trip for Sys {      what an operator asks, each with its margin
  goals At_10, At_0          where it must come by, in this order
  radius 1/10                nearer than this is there
  leg within 12              `leg to At_10 within 5`, `every leg within 12`
  round within 20            `every round within 20`
  clearance > 1 between At, Rock
  battery 100 rate 2, rate 1 while Rough keep 20
  probability of reaching At_p where |p-10| <= 1 within 10 >= 9/10
}
expect met | not met | open | round = 20
sweep k in 0 .. 1 step 1/10, n in [1, 2] { Trip }     the same at each point
pars sweep FILE   pars report FILE                    tables and pictures, a page\n",
    ),
    ("stepping", crate::walk::HELP),
    ("exercises", crate::exercise::HELP),
    (
        "comparing",
        "lts P                        what P can do: states, steps, deadlocks, livelocks
lts P bound 1000 memory 64   up to so many states and MiB
minimise P                   the smallest system that is strongly bisimilar
compare P ~ Q                strongly bisimilar? yes, no with a formula and a run, or unknown
compare P ~ Q weak           or branching, trace, weak-trace, simulation, simulation-equivalence, refinement
expect yes | no | unknown    behind the question
`pars lts` and `pars compare` do the same with .aut files, and draw\n",
    ),
    (
        "recurrences",
        "solve r(n+1) = 2*r(n) + 3, r(0) = 1       the closed form, checked by induction
solve f(n+2) = f(n+1) + f(n), f(0) = 0, f(1) = 1 find n with f(n) >= 1000
solve x(n+1) = x(n) + v*t, y(n+1) = y(n)/2, x(0) = 0, y(0) = 1
expect r = 4*2^n - 3, r(10) = 4093, n = 17 | never | open     behind it\n",
    ),
    (
        "laws",
        "`:laws` lists the laws, `:laws word` those that mention a word, `:law name` shows one.
import \"mine.rules\"          takes in laws of your own, in the form that `:law` shows\n",
    ),
    (
        "editing",
        "Tab completes names, laws, commands, and \\phi to φ. An unfinished input goes on in the next line.
`it` is the last result. Ctrl-C stops a search or the reading of a long file, Ctrl-D leaves. Arrow up brings back what was typed.\n",
    ),
];

/// The names of the topics.
pub(super) fn topics() -> impl Iterator<Item = &'static str> {
    TOPICS.iter().map(|(name, _)| *name)
}

/// What to say about a topic; about everything in short when none is given.
pub(super) fn help(topic: &str) -> String {
    if topic.is_empty() {
        let mut text =
            "Type a process to simplify it, or an item of the language: `prove Delay_1 ; Delay_2 = Delay_3`.\n"
                .to_string();
        for (name, arguments, says) in COMMANDS {
            text.push_str(&format!("  {:<22} {says}\n", format!(":{name} {arguments}")));
        }
        let topics: Vec<&str> = topics().collect();
        text.push_str(&format!("topics: {}\n", topics.join(", ")));
        return text;
    }
    let topic = topic.trim_start_matches(':');
    if let Some((_, text)) = TOPICS.iter().find(|(name, _)| name.starts_with(topic)) {
        return (*text).to_string();
    }
    if let Some((name, arguments, says)) = COMMANDS.iter().find(|(name, ..)| name.starts_with(topic)) {
        return format!(":{name} {arguments}\n  {says}\n");
    }
    if let Some(text) = crate::codes::explain(topic) {
        return text.to_string();
    }
    match nearest(topic, topics()) {
        Some(other) => format!("there is no topic `{topic}`; did you mean `{other}`?\n"),
        None => format!("there is no topic `{topic}`; the topics are {}\n", topics().collect::<Vec<_>>().join(", ")),
    }
}
