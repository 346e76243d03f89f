//! What a component does in each round, apart from values: where it neither chooses nor decides, the values matter only as
//! far as they are delays, and as far as each of them has to exist.

use std::collections::{BTreeMap, BTreeSet};

use super::super::surroundings::parameters;
use crate::assumption::Assumptions;
use crate::definition::Definitions;
use crate::name::Name;
use crate::term::{Node, Term};
use crate::value::{Relation, Sort, Value};

/// Calls that are followed until a loop comes round.
const MOST_CALLS: usize = 200;

/// A step of a component.
#[derive(Clone)]
pub(super) enum Step {
    /// Time passes.
    Delay(Value),
    /// A communication on a port: whether it writes.
    Port(Name, bool),
    /// Parts side by side, which end together.
    Together(Vec<Vec<Step>>),
}

/// A component: what it does once, and then in each round.
pub(super) struct Loop {
    pub(super) before: Vec<Step>,
    pub(super) round: Vec<Step>,
}

/// The names in scope, each with the value that it has in every round, if it has one.
type Scope = BTreeMap<Name, Option<Value>>;

/// A definition that was entered: how many steps stand before it, and with what.
struct Opened {
    name: Name,
    from: usize,
    scope: Scope,
}

/// The loops of these components; none where one of them chooses, ends or reads no further, where a delay is not the same in
/// each round or may be negative, and where a delay, or a value that is written or handed on, may not exist.
pub(super) fn loops_of(components: &[Term], definitions: &Definitions, known: &Assumptions) -> Option<Vec<Loop>> {
    let fixed = parameters(components, definitions, known);
    let mut reader = Reader { definitions, known, fixed: &fixed, calls: 0, handed: Vec::new() };
    let loops = components.iter().map(|one| reader.loop_of(one)).collect::<Option<Vec<_>>>()?;
    reader.all_exist().then_some(loops)
}

struct Reader<'a> {
    definitions: &'a Definitions,
    known: &'a Assumptions,
    fixed: &'a BTreeSet<Name>,
    calls: usize,
    /// What is written or handed on, and whether it is another one in other rounds.
    handed: Vec<(Value, bool)>,
}

impl Reader<'_> {
    fn loop_of(&mut self, component: &Term) -> Option<Loop> {
        let (mut steps, mut opened): (Vec<Step>, Vec<Opened>) = (Vec::new(), Vec::new());
        let (mut body, mut scope) = (component.clone(), Scope::new());
        loop {
            let parts: Vec<Term> = match body.node() {
                Node::Seq(parts) => parts.iter().cloned().collect(),
                _ => vec![body.clone()],
            };
            let (last, before) = parts.split_last()?;
            for part in before {
                steps.extend(self.steps(part, &mut scope)?);
            }
            let Node::Call(name, arguments) = last.node() else { return None };
            scope = self.entered(name, arguments, &scope)?;
            if let Some(place) = opened.iter().position(|other| other.name == *name) {
                let before = &mut opened[place];
                let mut same = true;
                for (parameter, value) in &mut before.scope {
                    if value.is_some() && scope.get(parameter) != Some(value) {
                        (*value, same) = (None, false);
                    }
                }
                if same {
                    let round = steps.split_off(before.from);
                    return Some(Loop { before: steps, round });
                }
                // Once more from there, with what is not the same in each round.
                steps.truncate(before.from);
                scope = before.scope.clone();
                opened.truncate(place + 1);
            } else {
                opened.push(Opened { name: name.clone(), from: steps.len(), scope: scope.clone() });
            }
            body = self.definitions.get(name)?.body.clone();
        }
    }

    /// What is in scope within a definition that is called with these.
    fn entered(&mut self, name: &Name, arguments: &[Value], scope: &Scope) -> Option<Scope> {
        self.calls += 1;
        let definition = self.definitions.get(name).filter(|_| self.calls <= MOST_CALLS)?;
        if definition.parameters.len() != arguments.len() {
            return None;
        }
        let mut inside = Scope::new();
        for (parameter, argument) in definition.parameters.iter().zip(arguments) {
            inside.insert(parameter.clone(), self.hand(argument, scope)?);
        }
        Some(inside)
    }

    /// A value that is handed on, if it is the same in each round; none where it stands for nothing.
    fn hand(&mut self, value: &Value, scope: &Scope) -> Option<Option<Value>> {
        let found = self.same(value, scope)?;
        self.handed.push(found.clone().map_or_else(|| (value.clone(), true), |found| (found, false)));
        Some(found)
    }

    /// A value, if it is the same in each round.
    fn same(&self, value: &Value, scope: &Scope) -> Option<Option<Value>> {
        let mut images = BTreeMap::new();
        for name in value.variables() {
            match scope.get(&name) {
                Some(Some(own)) => {
                    images.insert(name, own.clone());
                }
                Some(None) => return Some(None),
                None if self.fixed.contains(&name) => {}
                None => return None,
            }
        }
        self.known.put_in(value, &images).ok().map(Some)
    }

    fn steps(&mut self, part: &Term, scope: &mut Scope) -> Option<Vec<Step>> {
        let steps = match part.node() {
            Node::Delay(time) => {
                let time = self.same(time, scope)??;
                let lasts = self.known.decide(Relation::Gte, &time, &Value::zero()) == Some(true);
                (lasts && self.known.gives_meaning(&time)).then(|| vec![Step::Delay(time)])?
            }
            Node::In(port, name) => {
                scope.insert(name.clone(), None);
                vec![Step::Port(port.clone(), false)]
            }
            Node::Out(port, value) => {
                self.hand(value, scope)?;
                vec![Step::Port(port.clone(), true)]
            }
            Node::Set(value, name) => {
                let value = self.hand(value, scope)?;
                scope.insert(name.clone(), value);
                Vec::new()
            }
            Node::Seq(parts) => {
                let mut all = Vec::new();
                for part in parts.iter() {
                    all.extend(self.steps(part, scope)?);
                }
                all
            }
            Node::Par(parts) => {
                let all = parts.iter().map(|part| self.steps(part, scope)).collect::<Option<_>>()?;
                vec![Step::Together(all)]
            }
            Node::Disable(parts) => self.shown_while(parts, scope)?,
            Node::Call(name, arguments) => {
                let mut inside = self.entered(name, arguments, scope)?;
                let definition = self.definitions.get(name).filter(|definition| !definition.recursive)?;
                let body = definition.body.clone();
                self.steps(&body, &mut inside)?
            }
            _ => return None,
        };
        Some(steps)
    }

    /// A delay, and what is shown as long as it lasts.
    fn shown_while(&mut self, parts: &[Term], scope: &mut Scope) -> Option<Vec<Step>> {
        let (delays, shown): (Vec<&Term>, Vec<&Term>) =
            parts.iter().partition(|part| matches!(part.node(), Node::Delay(_)));
        let [delay] = delays.as_slice() else { return None };
        for part in shown {
            match part.node() {
                Node::Observe(_, values) => {
                    for value in values {
                        self.hand(value, scope)?;
                    }
                }
                Node::Idle => {}
                _ => return None,
            }
        }
        self.steps(delay, scope)
    }

    /// Whether all that is handed on exists in every round. A name may stand for a vector where vectors are handed on: it can
    /// be handed on as well, and nothing be made of it.
    fn all_exist(&self) -> bool {
        let numbers = self.handed.iter().all(|(value, _)| value.sort() == Sort::Real);
        self.handed.iter().all(|(value, varies)| {
            if !varies {
                return self.known.gives_meaning(value);
            }
            (numbers || value.as_variable().is_some()) && value.needs().is_empty()
        })
    }
}
