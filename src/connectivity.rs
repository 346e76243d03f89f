//! Whether what a program does can depend on what it must keep clear of: a directed path from the thing sensed,
//! through the program, to what moves (§V.B; as worded there, a system without a sensor passes).

mod drawing;

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::fmt::Write;

use num_rational::BigRational;

use crate::definition::Definitions;
use crate::name::Name;
use crate::period::ports;
use crate::polynomial::Monomial;
use crate::scope::subterms;
use crate::substitution::substitute_values;
use crate::term::{Node, Term};
use crate::value::{Atom, Value};

/// A component, as far as values go through it.
#[derive(Clone, Debug, Default)]
struct Part {
    name: String,
    /// Ports read whose value is used.
    reads: BTreeSet<Name>,
    writes: Vec<(Name, Value)>,
    shows: Vec<(Name, Vec<Value>)>,
    /// The ports on which results are read.
    sources: BTreeMap<Name, BTreeSet<Name>>,
    /// What parameters and results are made of, and what the tests ask of by which they become one thing or another.
    depends: BTreeMap<Name, BTreeSet<Name>>,
}

impl Part {
    /// The ports read of which what this observer shows may depend.
    fn moved_by(&self, observer: &Name) -> BTreeSet<&Name> {
        let shown = self.shows.iter().filter(|(name, _)| name == observer).flat_map(|(_, values)| values);
        let mut known: BTreeSet<Name> = shown.flat_map(Value::variables).collect();
        let mut work: Vec<Name> = known.iter().cloned().collect();
        while let Some(name) = work.pop() {
            let more = self.depends.get(&name).into_iter().flatten().filter(|more| known.insert((*more).clone()));
            work.extend(more.cloned());
        }
        known.iter().filter_map(|name| self.sources.get(name)).flatten().collect()
    }
}

/// Who reads what from whom, and whether what must be sensed reaches what moves.
#[derive(Clone, Debug, Default)]
pub struct Connectivity {
    /// From a component, over a port, to a component.
    pub links: Vec<(String, Name, String)>,
    /// The paths found, one for each thing that must be sensed.
    pub paths: Vec<String>,
    /// What is missing, in words.
    pub missing: Vec<String>,
}

/// The connectivity of a system for a claim about what these observers show.
pub fn connectivity(components: &[Term], observers: &[Name], definitions: &Definitions) -> Connectivity {
    let components = ports::flatten(components, definitions);
    let names = ports::System::of(&components, definitions).names;
    let parts: Vec<Part> =
        components.iter().zip(names).map(|(component, name)| part(component, name, definitions)).collect();
    let mut found = Connectivity::default();
    for from in &parts {
        let ports: BTreeSet<&Name> = from.writes.iter().map(|(port, _)| port).collect();
        for port in ports {
            for to in parts.iter().filter(|to| to.reads.contains(port)) {
                found.links.push((from.name.clone(), port.clone(), to.name.clone()));
            }
        }
    }
    let worlds: BTreeSet<usize> =
        (0..parts.len()).filter(|place| parts[*place].shows.iter().any(|(name, _)| observers.contains(name))).collect();
    let moved: Vec<(&Name, &Part)> = observers
        .iter()
        .flat_map(|observer| parts.iter().map(move |part| (observer, part)))
        .filter(|(observer, part)| {
            part.shows.iter().any(|(name, _)| name == *observer) && !part.moved_by(observer).is_empty()
        })
        .collect();
    let still: Vec<&Name> = observers.iter().filter(|name| !moved.iter().any(|(other, _)| other == name)).collect();
    if moved.is_empty() {
        found.missing.push("nothing that is shown moves by what it reads: there is no actuator".to_string());
        return found;
    }
    // What stands still must be sensed; where all moves, each must be sensed for one of the others, or for itself.
    let sensed: Vec<&Name> = if still.is_empty() { observers.iter().collect() } else { still };
    for thing in sensed {
        let targets: Vec<&(&Name, &Part)> =
            moved.iter().filter(|(other, _)| moved.len() == 1 || *other != thing).collect();
        match path(&parts, &worlds, thing, &targets) {
            Ok(path) => found.paths.push(path),
            Err(reason) => found.missing.push(reason),
        }
    }
    found
}

impl Connectivity {
    /// Whether nothing is missing.
    pub fn connected(&self) -> bool {
        self.missing.is_empty()
    }

    /// The links as a graph for `dot`.
    pub fn dot(&self) -> String {
        let mut text = String::from("digraph {");
        for (from, port, to) in &self.links {
            let _ = write!(text, " \"{from}\" -> \"{to}\" [label=\"{port}\"];");
        }
        text.push_str(" }");
        text
    }

    /// The same in words.
    pub fn lines(&self) -> Vec<String> {
        let mut lines: Vec<String> = self.paths.iter().map(|path| format!("connected: {path}")).collect();
        lines.extend(self.missing.iter().map(|reason| format!("not connected: {reason}")));
        if !self.connected() && !self.links.is_empty() {
            lines.push(format!("the links: {}", self.dot()));
        }
        lines
    }
}

/// Whether something is measured from a fixed place, or compared with something: from 9 in `9-x`, `(x-9)/2` and
/// `abs(x-9)`, from `(1,2)` in `(x-1,y-2)`. Of a condition, as in `if 9-x < 3 then 1 else 0`, the place cannot be told, so it
/// may be any.
fn is_measured_from(place: &Value, written: &Value) -> bool {
    if let (Some(places), Some(parts)) = (place.components(), written.components()) {
        return places.len() == parts.len()
            && places.iter().zip(&parts).all(|(place, part)| is_measured_from(place, part));
    }
    let Some(number) = place.as_rational() else { return false };
    let Some((sum, divisor)) = written.polynomials() else { return false };
    let constant = sum.constant_term();
    let from = |(monomial, factor): &(Monomial<Atom>, BigRational)| match monomial.factors() {
        // `x` by itself is a place, and no distance from 0.
        [(Atom::Variable(_), 1)] => constant != BigRational::default() && -&constant / factor == number,
        _ => false,
    };
    let inside = |atom: &Atom| match atom {
        Atom::Positive(inner) => !inner.variables().is_empty(),
        Atom::Maximum(elements) => elements.iter().any(|element| is_measured_from(place, element)),
        Atom::Floor(inner) => is_measured_from(place, inner),
        _ => false,
    };
    (divisor.is_one() && sum.terms().iter().any(from)) || written.atoms().iter().any(inside)
}

/// A path from where a thing is shown, over a port that carries what is shown, to a port that moves a target.
fn path(parts: &[Part], worlds: &BTreeSet<usize>, thing: &Name, targets: &[&(&Name, &Part)]) -> Result<String, String> {
    let mut carries: BTreeSet<(usize, Name)> = BTreeSet::new();
    for (place, part) in parts.iter().enumerate() {
        for values in part.shows.iter().filter(|(name, _)| name == thing).map(|(_, values)| values) {
            let related = |written: &Value| {
                values.iter().any(|value| {
                    let shared = value.variables().intersection(&written.variables()).next().is_some();
                    value == written || shared || is_measured_from(value, written)
                })
            };
            let written = part.writes.iter().filter(|(_, value)| related(value));
            carries.extend(written.map(|(port, _)| (place, port.clone())));
        }
    }
    if carries.is_empty() {
        return Err(format!("no port carries what {thing} shows, so nothing can sense it"));
    }
    let mut queue: VecDeque<(Name, String)> = VecDeque::new();
    let mut seen: BTreeSet<Name> = BTreeSet::new();
    for (place, port) in &carries {
        queue.push_back((port.clone(), format!("{thing} ({}) -{port}->", parts[*place].name)));
        seen.insert(port.clone());
    }
    while let Some((port, so_far)) = queue.pop_front() {
        for (_, part) in
            parts.iter().enumerate().filter(|(place, part)| !worlds.contains(place) && part.reads.contains(&port))
        {
            for (written, _) in &part.writes {
                let next = format!("{so_far} {} -{written}->", part.name);
                let moves = |(observer, target): &&&(&Name, &Part)| target.moved_by(observer).contains(written);
                if let Some((observer, target)) = targets.iter().find(moves) {
                    return Ok(format!("{next} {observer} ({})", target.name));
                }
                if seen.insert(written.clone()) {
                    queue.push_back((written.clone(), next));
                }
            }
        }
    }
    let ports = |names: BTreeSet<&Name>| names.into_iter().map(Name::as_str).collect::<Vec<_>>().join(", ");
    let actuators = ports(targets.iter().flat_map(|(observer, target)| target.moved_by(observer)).collect());
    if targets.is_empty() {
        return Err(format!("{thing} is sensed, and nothing else that is shown moves by what is read"));
    }
    Err(format!(
        "there is no path from {thing}, which is sensed on {}, through a program to {actuators}, which moves {}",
        ports(carries.iter().map(|(_, port)| port).collect()),
        targets.iter().map(|(observer, _)| observer.as_str()).collect::<Vec<_>>().join(", "),
    ))
}

/// A component with the definitions that it reaches, their parameters replaced by what they are called with.
fn part(component: &Term, name: String, definitions: &Definitions) -> Part {
    let mut part = Part { name, ..Part::default() };
    let mut bound: Vec<(Name, Name)> = Vec::new();
    let mut used: BTreeSet<Name> = BTreeSet::new();
    let (mut asked, mut changing): (BTreeSet<Name>, BTreeSet<Name>) = Default::default();
    let mut seen: BTreeSet<Name> = BTreeSet::new();
    let mut work = vec![(component.clone(), true)];
    while let Some((term, outermost)) = work.pop() {
        for inner in subterms(&term) {
            used.extend(inner.values().flat_map(Value::variables));
            match inner.node() {
                Node::In(port, result) => bound.push((port.clone(), result.clone())),
                Node::Out(port, value) => part.writes.push((port.clone(), value.clone())),
                Node::Observe(name, values) => part.shows.push((name.clone(), values.clone())),
                Node::Call(name, arguments) => {
                    let parameters = definitions.get(name).map(|definition| definition.parameters.clone());
                    for (parameter, argument) in parameters.iter().flatten().zip(arguments) {
                        if *argument != Value::variable(parameter) {
                            part.depends.entry(parameter.clone()).or_default().extend(argument.variables());
                            changing.insert(parameter.clone());
                        }
                    }
                    let Some(definition) = definitions.get(name).filter(|_| seen.insert(name.clone())) else {
                        continue;
                    };
                    let map: BTreeMap<Name, Value> =
                        definition.parameters.iter().cloned().zip(arguments.iter().cloned()).collect();
                    // At the start of a component its parameters have values that later rounds change.
                    let body = if outermost && definition.recursive {
                        None
                    } else {
                        substitute_values(&definition.body, &map).ok()
                    };
                    work.push((body.unwrap_or_else(|| definition.body.clone()), false));
                }
                Node::Set(value, result) => {
                    part.depends.entry(result.clone()).or_default().extend(value.variables());
                    changing.insert(result.clone());
                }
                Node::Guard(_, left, right) => asked.extend(left.variables().into_iter().chain(right.variables())),
                _ => {}
            }
        }
    }
    for name in changing {
        part.depends.entry(name).or_default().extend(asked.iter().cloned());
    }
    for (port, result) in bound {
        if used.contains(&result) {
            part.reads.insert(port.clone());
        }
        part.sources.entry(result).or_default().insert(port);
    }
    part
}
