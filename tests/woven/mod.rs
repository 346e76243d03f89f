//! Random networks whose components go round for ever.

use std::collections::BTreeMap;

use pars::definition::{Definition, Definitions};
use pars::name::Name;
use pars::term::{Node, Term};
use pars::value::{Relation, Value};

use crate::common::*;
use crate::dice::Dice;

/// Components that loop round straight sequences.
pub struct Network {
    pub components: Vec<Term>,
    pub definitions: Definitions,
    /// Who writes and who reads each port that has one writer and one reader.
    pub pairs: BTreeMap<Name, (usize, usize)>,
    /// How often each component uses such a port in one round.
    pub uses: BTreeMap<(usize, Name), usize>,
    pub text: String,
}

pub fn component(index: usize) -> String {
    format!("T{}", (b'A' + index as u8) as char)
}

/// What a component does, with as many reads and writes in each round as before, written in other ways.
fn shaped(dice: &mut Dice, own: &str, body: Vec<Term>, definitions: &mut Definitions) -> Term {
    let mut parts: Vec<Term> = Vec::new();
    for (place, part) in body.into_iter().enumerate() {
        // Parts side by side bind different names.
        let part = match part.node() {
            Node::In(port, _) => input(port.as_str(), &format!("w{place}")),
            _ => part,
        };
        let same = |dice: &mut Dice, part: &Term| {
            let other = match part.node() {
                Node::Out(port, _) => Term::new(Node::Out(port.clone(), int(9))),
                _ => part.clone(),
            };
            let (left, right) = (int(dice.place(3) as i64), int(1));
            let [yes, no] = [Relation::Eq, Relation::Neq].map(|one| guard(one, left.clone(), right.clone()));
            (seq([yes, part.clone()]), seq([no, other.clone()]), other)
        };
        parts.push(match (part.node(), dice.place(8)) {
            (Node::Delay(_), 0..4) => dis([part, observer("At", vec![int(dice.place(2) as i64)])]),
            (Node::Delay(_), _) => part,
            (Node::In(..) | Node::Out(..), 0) => Term::new(Node::Power(part, int(1), None)),
            (Node::In(..) | Node::Out(..), 1) => dis([part, observer("At", vec![int(3)])]),
            (Node::In(..) | Node::Out(..), 2) => {
                let (one, other, _) = same(dice, &part);
                par([one, other])
            }
            (Node::In(..) | Node::Out(..), 3) => {
                let (one, _, other) = same(dice, &part);
                Term::new(Node::Else(one, other))
            }
            _ => part,
        });
    }
    // A read or write of a port once and again; parts side by side; parts under a name.
    let mut place = 0;
    while place + 1 < parts.len() {
        let port = |part: &Term| match part.node() {
            Node::In(port, _) => Some(port.clone()),
            _ => None,
        };
        let read_twice = port(&parts[place]).is_some() && port(&parts[place]) == port(&parts[place + 1]);
        if parts[place] == parts[place + 1] || read_twice {
            let part = parts.remove(place);
            parts[place] = Term::new(Node::Power(part, int(2), None));
        } else if dice.place(6) == 0 {
            let part = parts.remove(place);
            parts[place] = par([part, parts[place].clone()]);
        } else if dice.place(6) == 0 {
            let part = parts.remove(place);
            let name = format!("{own}Part{place}");
            define(definitions, &name, &[], seq([part, parts[place].clone()]));
            parts[place] = call(&name, vec![]);
        }
        place += 1;
    }
    if parts.len() > 1 && dice.place(4) == 0 {
        let rest = parts.split_off(parts.len() / 2);
        let next = format!("{own}Next");
        let body = Term::seq(rest.into_iter().chain([call(own, vec![])]));
        definitions.insert(Definition { name: name(&next), parameters: vec![], body, recursive: true });
        return Term::seq(parts.into_iter().chain([call(&next, vec![])]));
    }
    Term::seq(parts.into_iter().chain([call(own, vec![])]))
}

/// How a network is made.
#[derive(Clone, Copy, Default)]
pub struct Made {
    /// The counts solve the balance equations.
    pub exact: bool,
    /// A looping writer serves any number of readers.
    pub fan: bool,
    /// The components are no straight lines.
    pub shaped: bool,
    /// A delay may end the waiting for a read or a write.
    pub timed: bool,
}

pub fn random_network(dice: &mut Dice, made: Made) -> Network {
    let Made { exact, fan, .. } = made;
    let count = 2 + dice.place(5);
    let rates: Vec<usize> = (0..count).map(|_| 1 + dice.place(3)).collect();
    let mut bodies: Vec<Vec<Term>> = vec![Vec::new(); count];
    let (mut pairs, mut uses) = (BTreeMap::new(), BTreeMap::new());
    // A tree of ports, seldom broken, and a few more.
    let mut links: Vec<(usize, usize)> = Vec::new();
    for to in 1..count {
        if dice.place(12) > 0 {
            links.push((dice.place(to), to));
        }
    }
    for _ in 0..dice.place(3) {
        let (one, other) = (dice.place(count), dice.place(count));
        if one != other {
            links.push((one, other));
        }
    }
    for (number, (one, other)) in links.iter().enumerate() {
        let (writer, reader) = if dice.place(2) == 0 { (*one, *other) } else { (*other, *one) };
        let port = format!("c{number}");
        let (written, read) = if exact {
            let whole = num_integer::lcm(rates[writer], rates[reader]);
            (whole / rates[writer], whole / rates[reader])
        } else {
            let most = if dice.place(3) == 0 { 2 } else { 1 };
            (1 + dice.place(most), 1 + dice.place(most))
        };
        for _ in 0..written {
            let place = dice.place(bodies[writer].len() + 1);
            bodies[writer].insert(place, output(&port, number_of(number)));
        }
        for _ in 0..read {
            let place = dice.place(bodies[reader].len() + 1);
            bodies[reader].insert(place, input(&port, &format!("y{number}")));
        }
        pairs.insert(name(&port), (writer, reader));
        uses.insert((writer, name(&port)), written);
        uses.insert((reader, name(&port)), read);
    }
    if fan {
        if !links.is_empty() && dice.place(4) == 0 {
            // A second reader of a port may compete with the first.
            bodies[dice.place(count)].push(input("c0", "z"));
            uses.retain(|(_, port), _| port.as_str() != "c0");
        }
        let writer = dice.place(count);
        let looping = again(output("o", number_of(7)));
        let shown = dis([wait(1 + dice.place(2) as i64), looping]);
        let place = dice.place(bodies[writer].len() + 1);
        bodies[writer].insert(place, shown);
        let mut served = false;
        for reader in (0..count).filter(|reader| *reader != writer) {
            for _ in 0..dice.place(3) {
                let place = dice.place(bodies[reader].len() + 1);
                bodies[reader].insert(place, input("o", "x"));
                served = true;
            }
        }
        if !served {
            bodies[(writer + 1) % count].push(input("o", "x"));
        }
    }
    for body in &mut bodies {
        for _ in 0..dice.place(3) + usize::from(body.is_empty()) {
            let place = dice.place(body.len() + 1);
            body.insert(place, Term::delay(frac(1 + dice.place(4) as i64, 1 + dice.place(2) as i64)));
        }
    }
    let mut definitions = Definitions::default();
    for (index, mut body) in bodies.into_iter().enumerate() {
        let own = component(index);
        if made.timed && dice.place(4) == 0 {
            let place = dice.place(body.len());
            if let Node::In(port, _) | Node::Out(port, _) = body[place].node() {
                uses.retain(|(_, used), _| used != port);
                body[place] = dis([body[place].clone(), wait(1)]);
            }
        }
        let body = if made.shaped {
            shaped(dice, &own, body, &mut definitions)
        } else {
            Term::seq(body.into_iter().chain([call(&own, vec![])]))
        };
        definitions.insert(Definition { name: name(&own), parameters: vec![], body, recursive: true });
    }
    let text = definitions.iter().map(|one| format!("proc {} = {}\n", one.name, one.body)).collect();
    let components = (0..count).map(|index| call(&component(index), vec![])).collect();
    Network { components, definitions, pairs, uses, text }
}

fn number_of(number: usize) -> Value {
    int(number as i64)
}
