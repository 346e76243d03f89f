//! Values that are given to a process and make no sense there: `N_{-1}` where N draws from `Normal(0, sd: s)`.

use std::collections::{BTreeMap, BTreeSet};

use crate::assumption::Assumptions;
use crate::definition::Definitions;
use crate::name::Name;
use crate::term::{Node, Term};
use crate::value::{Sort, Value};

/// Calls that are followed, and those of one process with other values.
const MOST_CALLS: usize = 10_000;
const MOST_VALUES: usize = 8;
/// Terms that stand in one another.
const DEEPEST: usize = 500;

/// A draw from what is no distribution, or a delay that is negative, which a process comes to whatever it reads.
#[derive(Debug)]
pub(crate) struct Impossible {
    /// The code of the error.
    pub(crate) code: &'static str,
    /// What is wrong, and in which process.
    pub(crate) text: String,
}

/// Where a component comes to such a draw or delay, if nothing before it but reads, writes, delays, draws and guards that hold
/// is to end first: whether a process ends, or aborts, is not asked here.
pub(crate) fn impossible(component: &Term, definitions: &Definitions, known: &Assumptions) -> Option<Impossible> {
    let start = Visit { within: Vec::new(), body: component.clone(), values: Values::new(), at_once: false };
    let (calls, within, seen) = (vec![start], Vec::new(), BTreeMap::new());
    let mut walk = Walk { definitions, known, calls, within, at_once: false, seen };
    for _ in 0..MOST_CALLS {
        let Visit { within, body, mut values, at_once } = walk.calls.pop()?;
        (walk.within, walk.at_once) = (within, at_once);
        if let Err(Stop::Found(mut found)) = walk.through(&body, &mut values, 0) {
            if let Some(name) = walk.within.last() {
                found.text = format!("in {name}: {}", found.text);
            }
            return Some(found);
        }
    }
    None
}

/// What is known of names: a number, or that the name stands for something else than outside.
type Values = BTreeMap<Name, Value>;

/// Why a walk through a term ends before its end.
enum Stop {
    Found(Impossible),
    /// What follows may not be come to.
    Guard,
}

/// The body of a process, with what is known of its parameters.
struct Visit {
    /// The processes called, one in the other; the last is this one.
    within: Vec<Name>,
    body: Term,
    values: Values,
    /// Whether it stands in a `#`.
    at_once: bool,
}

struct Walk<'a> {
    definitions: &'a Definitions,
    known: &'a Assumptions,
    /// What is still to be looked at.
    calls: Vec<Visit>,
    /// Where the walk is, and whether that is in a `#`.
    within: Vec<Name>,
    at_once: bool,
    seen: BTreeMap<Name, BTreeSet<Vec<Option<Value>>>>,
}

/// A value of which nothing is known here.
fn unknown(name: &Name) -> Value {
    Value::variable(&Name::new(&format!("[{name}]")))
}

impl Walk<'_> {
    fn value(&self, value: &Value, values: &Values) -> Result<Value, String> {
        Ok(self.known.simplify(&value.substitute(values).map_err(|error| error.0)?))
    }

    fn through(&mut self, term: &Term, values: &mut Values, depth: usize) -> Result<(), Stop> {
        if depth > DEEPEST {
            return Err(Stop::Guard);
        }
        match term.node() {
            Node::Delay(time) => self.delay(time, values),
            Node::Ran(from, name) => {
                if let Err(why) = self.value(from, values) {
                    return found("P0407", format!("what is drawn for {name} is no distribution: {why}"));
                }
                values.insert(name.clone(), unknown(name));
                Ok(())
            }
            Node::Guard(relation, left, right) => {
                let sides = [left, right].map(|side| self.value(side, values).ok());
                let holds = |[left, right]: [Option<Value>; 2]| self.known.decide(*relation, &left?, &right?);
                if holds(sides) == Some(true) { Ok(()) } else { Err(Stop::Guard) }
            }
            Node::Set(value, name) => {
                let number = self.value(value, values).ok().filter(|value| value.as_rational().is_some());
                values.insert(name.clone(), number.unwrap_or_else(|| unknown(name)));
                Ok(())
            }
            Node::In(_, name) => {
                values.insert(name.clone(), unknown(name));
                Ok(())
            }
            Node::Out(..) | Node::Stop => Ok(()),
            Node::Seq(parts) => {
                for part in parts {
                    self.through(part, values, depth + 1)?;
                    // Where something else may end it first, what waits may never be come to.
                    if self.at_once && matches!(part.node(), Node::In(..) | Node::Out(..) | Node::Delay(_)) {
                        return Err(Stop::Guard);
                    }
                }
                Ok(())
            }
            Node::Call(name, arguments) => {
                self.call(name, arguments, values);
                Err(Stop::Guard)
            }
            Node::Disable(parts) => {
                let before = std::mem::replace(&mut self.at_once, true);
                let found = parts.iter().try_for_each(|part| self.inside(part, values, depth));
                self.at_once = before;
                found.and(Err(Stop::Guard))
            }
            Node::Par(parts) => {
                parts.iter().try_for_each(|part| self.inside(part, values, depth))?;
                Err(Stop::Guard)
            }
            Node::Else(body, _) | Node::New(_, body) | Node::Project(body, _) | Node::Loop(body) => {
                self.inside(body, values, depth)?;
                Err(Stop::Guard)
            }
            // It may abort, never end, bind anything, or not be gone through at all.
            _ => Err(Stop::Guard),
        }
    }

    /// What is found in a part behind which nothing is looked at.
    fn inside(&mut self, part: &Term, values: &Values, depth: usize) -> Result<(), Stop> {
        match self.through(part, &mut values.clone(), depth + 1) {
            Err(Stop::Guard) | Ok(()) => Ok(()),
            found => found,
        }
    }

    fn delay(&self, time: &Value, values: &Values) -> Result<(), Stop> {
        let Ok(time) = self.value(time, values) else { return Ok(()) };
        let negative =
            time.sort() == Sort::Real && time.as_rational().is_some_and(|time| time < num_traits::Zero::zero());
        if negative { found("P0423", format!("a delay cannot last {time}")) } else { Ok(()) }
    }

    /// Puts a call with these values among what is to be looked at; a process that calls itself, round by round with other
    /// values, only once.
    fn call(&mut self, name: &Name, arguments: &[Value], values: &Values) {
        let Some(definition) = self.definitions.get(name).filter(|_| !self.within.contains(name)) else { return };
        let number = |argument| self.value(argument, values).ok().filter(|value| value.as_rational().is_some());
        let arguments: Vec<Option<Value>> = arguments.iter().map(number).collect();
        let seen = self.seen.entry(name.clone()).or_default();
        if seen.len() >= MOST_VALUES || !seen.insert(arguments.clone()) {
            return;
        }
        let own = definition.parameters.iter().zip(arguments);
        let own = own.map(|(name, value)| (name.clone(), value.unwrap_or_else(|| unknown(name)))).collect();
        let within = self.within.iter().chain([name]).cloned().collect();
        self.calls.push(Visit { within, body: definition.body.clone(), values: own, at_once: self.at_once });
    }
}

fn found(code: &'static str, text: String) -> Result<(), Stop> {
    Err(Stop::Found(Impossible { code, text }))
}
