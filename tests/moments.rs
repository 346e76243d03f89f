//! Networks that draw at several moments of one instant: the order is accepted where it does not matter, and only there.

use pars::advance::draw::Draws;
use pars::fact::Context;
use pars::term::{Node, Term};

mod dice;
mod steps;
mod texts;

use dice::Dice;
use steps::{accepted, atom, compared, concluded, differs, refused};
use texts::{declared, term};

/// A communication that nobody sees, as it stands before a draw that is called so.
fn unseen(name: &str) -> String {
    format!("new c. (In_c<{name}> ; Abort | Out_{{c,0}})")
}

#[test]
fn parts_that_know_nothing_of_each_other_draw_in_any_order() {
    let writers = "Out_{c,1} ; Idle | Out_{d,1} ; Idle";
    let one = "Ran_{Exp(rate: 1)}";
    let (first, second) = (unseen("e"), unseen("f"));
    // Each after a communication of its own: neither before the other, and not both at once.
    let both =
        format!("new c. new d. (In_c<y> ; {one}<x> ; See_x | In_d<z> ; Ran_{{Exp(rate: 2)}}<w1> ; See_w1 | {writers})");
    let then = "new c. new d. (See_e | See_f | Idle | Idle)";
    accepted(&both, &["e", "f"], &format!("({first} ; {one}<e> | {second} ; Ran_{{Exp(rate: 2)}}<f>) ; {then}"));
    differs(&both, &["e", "f"], &format!("{first} ; {one}<e> ; {second} ; Ran_{{Exp(rate: 2)}}<f> ; {then}"));
    differs(&both, &["e", "f"], &format!("{first} ; {one}<e> ; Ran_{{Exp(rate: 2)}}<f> ; {then}"));
    differs(&both, &["e", "f"], &format!("({first} ; {one}<e> | {second} ; {one}<f>) ; {then}"));
    refused(&both, &["e", "e"], "stands for something else");
    refused(&both, &["e"], "1 names for 2 draws");
    // A communication beside the one draw.
    let beside = format!("new c. new d. (In_c<y> ; {one}<x> ; See_x | In_d<z> ; See_z | {writers})");
    accepted(&beside, &["e"], &format!("{first} ; {one}<e> ; new c. new d. (See_e | See_1 | Idle | Idle)"));
    // What is done with a value that was drawn may depend on it, where that is nothing to others.
    let guarded = format!(
        "new c. new d. (In_c<y> ; {one}<x> ; (Gtr_{{x,1}} ; See_x | Lte_{{x,1}} ; Delay_x ; Idle) \
        | In_d<z> ; Ran_{{Exp(rate: 2)}}<w1> ; See_w1 | {writers})"
    );
    let open = "Set_e<x> ; (Gtr_{x,1} ; See_x | Lte_{x,1} ; Delay_x ; Idle)";
    let after = format!("new c. new d. ({open} | See_f | Idle | Idle)");
    accepted(&guarded, &["e", "f"], &format!("({first} ; {one}<e> | {second} ; Ran_{{Exp(rate: 2)}}<f>) ; {after}"));
}

#[test]
fn where_the_order_of_draws_matters_it_is_said_so() {
    let others = "In_d<z> ; Ran_{Exp(rate: 2)}<w1> ; See_w1 | Out_{c,1} ; Idle | Out_{d,1} ; Idle";
    let order = "the order in which parts communicate in one instant matters";
    let refused = |part: &str, more: &str, because: &str| {
        let network = format!("new c. new d. new g. (In_c<y> ; Ran_{{Exp(rate: 1)}}<x> ; {part} | {others}{more})");
        refused(&network, &["e", "f"], order);
        refused(&network, &["e", "f"], because);
    };
    // What was drawn decides who communicates.
    refused("(Gtr_{x,1} ; In_d<q> ; Idle | Lte_{x,1} ; Idle)", "", "may use port d");
    refused("(Gtr_{x,1} ; Out_{g,1} ; Idle | Lte_{x,1} ; Idle)", " | In_g<q> ; Idle", "may use port g");
    refused("(Gtr_{x,1} ; (Out_{g,1} | In_g<q>) ; Idle | Lte_{x,1} ; Idle)", "", "may use port g");
    refused("Delay_{x-1} ; Out_{g,1} ; Idle", " | In_g<q> ; Idle", "may use port g");
    // Whether anything else is drawn.
    refused("(Gtr_{x,1} ; Ran_{Exp(rate: 1)}<q> ; See_q | Lte_{x,1} ; Idle)", "", "may draw again");
    // One prevents the other: two readers of one writer.
    refused("Idle", " | In_d<q> ; Idle", "");
    refused("In_d<q> ; Idle", "", "");
    // What one draws is what the other draws from.
    refused("Out_{g,x} ; Idle", " | In_g<q> ; Ran_{Normal(q, var: 1)}<q1> ; See_q1", "");
}

#[test]
fn parts_that_draw_again_and_again_draw_in_the_order_of_their_own() {
    let exp = |rate: &str| format!("Ran_{{Exp(rate: {rate})}}");
    let chain = |(one, two): (&str, &str), names: [&str; 2], rates: (&str, &str), seen: &str| {
        let [first, second] = names;
        let (rate, other) = rates;
        format!("In_{one}<{first}> ; {}<{first}d> ; In_{two}<{second}> ; {}<{second}d> ; {seen}", exp(rate), exp(other))
    };
    let writers = "Out_{a,1} ; Out_{b,2} ; Idle | Out_{c,3} ; Out_{d,4} ; Idle";
    let left = chain(("a", "b"), ["x", "y"], ("1", "2"), "(See_{x+y} # See_{xd} # See_{yd})");
    let right = chain(("c", "d"), ["z", "w"], ("3", "4+z"), "(See_{z} # See_{zd-wd})");
    let both = format!("new c. new d. new a. new b. ({left} | {right} | {writers})");
    let [e, f, g, h] = ["e", "f", "g", "h"].map(|name| (unseen(name), name));
    let drawn = |(before, name): &(String, &str), rate: &str| format!("{before} ; {}<{name}>", exp(rate));
    let then = "new c. new d. new a. new b. ((See_3 # See_e # See_f) | (See_3 # See_{g-h}) | Idle | Idle)";
    let (one, two) = (drawn(&e, "1"), drawn(&f, "2"));
    let (three, four) = (drawn(&g, "3"), drawn(&h, "7"));
    accepted(&both, &["e", "f", "g", "h"], &format!("({one} ; {two} | {three} ; {four}) ; {then}"));
    differs(&both, &["e", "f", "g", "h"], &format!("({one} ; {three} | {two} ; {four}) ; {then}"));
    differs(&both, &["e", "f", "g", "h"], &format!("({two} ; {one} | {three} ; {four}) ; {then}"));
    differs(&both, &["e", "f", "g", "h"], &format!("({one} | {two} | {three} | {four}) ; {then}"));
    differs(&both, &["e", "f", "g", "h"], &format!("(({one} | {three}) ; ({two} | {four})) ; {then}"));
    // What is drawn first may be what is drawn from next.
    let own = "In_a<x> ; Ran_{Exp(rate: 1)}<xd> ; In_b<y> ; Ran_{Normal(xd, var: 1)}<yd> ; See_yd";
    let whole = format!("new c. new d. new a. new b. ({own} | {right} | {writers})");
    let normal = format!("{} ; Ran_{{Normal(e, var: 1)}}<f>", f.0);
    let then = "new c. new d. new a. new b. (See_f | (See_3 # See_{g-h}) | Idle | Idle)";
    accepted(&whole, &["e", "f", "g", "h"], &format!("({one} ; {normal} | {three} ; {four}) ; {then}"));
    // One may draw again before the other has drawn, and what that draws next waits for it.
    let waits = "In_a<x> ; Ran_{Exp(rate: 1)}<xd> ; In_g<y> ; Ran_{Exp(rate: 2)}<yd> ; See_yd";
    let gives = "In_c<z> ; Ran_{Exp(rate: 3)}<zd> ; In_d<q> ; Ran_{Exp(rate: 4)}<qd> ; Out_{g,1} ; See_qd";
    let whole = format!("new c. new d. new a. new b. new g. ({waits} | {gives} | {writers})");
    refused(&whole, &["e", "f", "e1", "f1"], "the order in which parts communicate in one instant matters");
}

/// A network of parts that each communicate first, each with a writer of its own, and what then may happen.
fn several(dice: &mut Dice) -> String {
    let count = 2 + dice.place(2);
    let mut parts = Vec::new();
    for number in 0..count {
        let own = ["k", "l", "m"][number];
        let coin = dice.one_of(&["Mix(1/2: Point(1), 1/2: Point(2))", "Mix(1/3: Point(y), 2/3: Point(3))"]);
        let mut all: Vec<String> = Vec::new();
        if dice.place(4) > 0 {
            all.push(format!("Ran_{{{coin}}}<y>"));
        }
        if dice.place(3) == 0 {
            // Once more, with the same writer.
            let again = dice.one_of(&["", "Ran_{Exp(rate: 1)}<y> ; "]);
            all.push(format!("{again}In_{own}<x> ; Ran_{{{coin}}}<y>"));
        }
        for _ in 0..dice.place(3) {
            let port = dice.one_of(&["a", "b", "c"]);
            all.push(match dice.place(9) {
                0 => "(Gtr_{y,1} ; Set_4<x> | Lte_{y,1} ; Set_5<x>)".to_string(),
                1 => format!("(Gtr_{{y,1}} ; Out_{{{port},y}} | Lte_{{y,1}} ; Set_5<x>)"),
                2 => format!("(Eq_{{y,1}} ; In_{port}<x> | Neq_{{y,1}} ; Delay_1)"),
                3 => "Delay_{y-1}".to_string(),
                4 => format!("(Eq_{{y,3}} ; Ran_{{{coin}}}<x> | Neq_{{y,3}} ; Set_1<x>)"),
                5 => format!("(Delay_1 # In_{port}<x>)"),
                6 => "(Delay_1 # See_y)".to_string(),
                _ => atom(dice, number),
            });
        }
        let text = format!("Set_1<y> ; In_{own}<y> ; {} ; See_y ; Idle", all.join(" ; ")).replace(" ;  ; ", " ; ");
        let mut text = text;
        for name in ["x", "y", "z", "w"] {
            text = text.replace(&format!("<{name}>"), &format!("<{name}{number}>"));
        }
        for (old, new) in [("y}", "}"), ("_{y,", ","), ("_{y-", "-"), ("Point(y)", ")"), ("See_y", "")] {
            let fresh = match old {
                "y}" => format!("y{number}{new}"),
                "Point(y)" => format!("Point(y{number}{new}"),
                "See_y" => format!("See_y{number}"),
                _ => format!("_{{y{number}{new}"),
            };
            text = text.replace(old, &fresh);
        }
        parts.push(text);
        parts.push(format!("Out_{{{own},{}}} ; Out_{{{own},{}}} ; Idle", number + 1, number + 2));
    }
    if dice.place(2) == 0 {
        parts.push("Out_{a,7} ; Idle".to_string());
    }
    format!("new a. new b. new c. new k. new l. new m. ({})", parts.join(" | "))
}

#[test]
fn what_is_drawn_at_several_moments_of_random_networks_is_weakly_bisimilar() {
    let mut dice = Dice(8_121_101);
    let environment = declared("observer See(x)\n");
    let context = Context::new(&environment.assumptions, &environment.definitions, &[]);
    let mut text = String::from("observer See(x)\n");
    let (mut asked, mut apart, mut again, mut matters) = (0, 0, 0, 0);
    for _ in 0..60 {
        let network = several(&mut dice);
        let left = term(&environment, &network);
        let draws = match Draws::of(&left, &context) {
            Ok(draws) => draws,
            Err(why) => {
                matters += usize::from(why.0.contains("the order in which parts communicate"));
                continue;
            }
        };
        let right = concluded(&environment, &left, (&draws, &context));
        let first = if let Node::Seq(parts) = right.node() { parts.first() } else { None };
        apart += usize::from(first.is_some_and(|first| matches!(first.node(), Node::Par(_))));
        let moments = |branch: &Term| branch.children().filter(|part| matches!(part.node(), Node::New(..))).count();
        again += usize::from(first.is_some_and(|first| first.children().into_iter().any(|one| moments(one) > 1)));
        asked += 1;
        text.push_str(&format!("compare {left} ~ {right} weak\n"));
    }
    let (told, yes) = compared(&text);
    println!(
        "{asked} networks, {apart} that draw at several moments, {again} of them again and again, {matters} refused for the \
        order, {yes} found alike"
    );
    assert!(
        asked > 25 && apart > 15 && again > 3 && matters > 5 && yes * 10 > asked * 6,
        "{asked} {apart} {matters} {yes}\n{told}"
    );
}
