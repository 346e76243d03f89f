//! How often a component uses each port in one round, where its form tells: the numbers of the balance equations.

use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;

use num_traits::ToPrimitive;

use crate::definition::Definitions;
use crate::name::Name;
use crate::scope::subterms;
use crate::term::{Node, Term};

/// Operators and calls that are looked into within one another.
const DEEPEST: usize = 200;

/// A port, and whether it is read there.
type Use<'a> = (&'a Name, bool);

/// What is known of a process that ends.
#[derive(Clone, Default)]
pub(super) struct Tally<'a> {
    /// How often it has used each port when it stops; none where that is not known, or not the same each time.
    pub(super) uses: BTreeMap<Use<'a>, Option<usize>>,
    /// Whether it may abort.
    aborts: bool,
    /// Whether it may stop.
    stops: bool,
    /// Whether a part of it may go round and round, also while it waits.
    pub(super) busy: bool,
}

impl<'a> Tally<'a> {
    fn stops() -> Tally<'a> {
        Tally { stops: true, ..Tally::default() }
    }

    fn one(port: &'a Name, reads: bool) -> Tally<'a> {
        Tally { uses: BTreeMap::from([((port, reads), Some(1))]), ..Tally::stops() }
    }

    fn ends(&self) -> bool {
        self.aborts || self.stops
    }

    fn add(&mut self, other: &Tally<'a>) {
        for (port, count) in &other.uses {
            let before = self.uses.entry(*port).or_insert(Some(0));
            *before = before.and_then(|before| before.checked_add((*count)?));
        }
        self.busy |= other.busy;
    }

    /// With each of its numbers changed.
    fn each(mut self, change: impl Fn(usize) -> Option<usize>) -> Tally<'a> {
        self.uses.values_mut().for_each(|count| *count = count.and_then(&change));
        self
    }

    /// Of one or the other, whichever takes place.
    fn either(mut self, other: &Tally<'a>) -> Tally<'a> {
        for (port, count) in &mut self.uses {
            let same = *count == other.uses.get(port).copied().unwrap_or(Some(0));
            *count = count.filter(|_| same);
        }
        for (port, count) in &other.uses {
            self.uses.entry(*port).or_insert(count.filter(|count| *count == 0));
        }
        self.aborts |= other.aborts;
        self.stops |= other.stops;
        self.busy |= other.busy;
        self
    }
}

/// Counts the uses of ports in the components of one system.
pub(super) struct Counter<'a> {
    definitions: &'a Definitions,
    /// What was found of processes that are called.
    known: HashMap<&'a Name, Option<Rc<Tally<'a>>>>,
    depth: usize,
}

impl<'a> Counter<'a> {
    pub(super) fn new(definitions: &'a Definitions) -> Counter<'a> {
        Counter { definitions, known: HashMap::new(), depth: 0 }
    }

    /// What one round of a component does that goes round for ever, and comes to an end of each round if nothing blocks
    /// it for ever; what it does before the first is left out. None where it may end, or goes round in several ways.
    pub(super) fn round(&mut self, component: &'a Term) -> Option<Tally<'a>> {
        let mut passed: Vec<(&Name, Tally<'a>)> = Vec::new();
        let (mut here, mut busy) = (component, false);
        loop {
            match here.node() {
                Node::Loop(body) => {
                    let round = self.within(body, None).filter(goes_on)?;
                    return Some(Tally { busy: busy || round.busy, ..round });
                }
                Node::Seq(parts) => {
                    let (last, before) = parts.split_last()?;
                    for part in before {
                        busy |= self.within(part, None).filter(goes_on)?.busy;
                    }
                    here = last;
                }
                Node::Call(name, _) => {
                    if let Some(start) = passed.iter().position(|(before, _)| *before == name) {
                        let mut round = Tally::stops();
                        passed[start..].iter().for_each(|(_, part)| round.add(part));
                        return Some(Tally { busy: busy || round.busy, ..round });
                    }
                    let body = &self.definitions.get(name)?.body;
                    let Some(next) = last_call(body, 0) else {
                        here = body;
                        continue;
                    };
                    let Node::Call(called, _) = next.node() else { return None };
                    let part = self.within(body, Some(called)).filter(goes_on)?;
                    busy |= part.busy;
                    passed.push((name, part));
                    here = next;
                }
                _ => return None,
            }
            if passed.len() > DEEPEST {
                return None;
            }
        }
    }

    /// What a process does; a call of `last` at its end is left out.
    fn within(&mut self, term: &'a Term, last: Option<&'a Name>) -> Option<Tally<'a>> {
        if self.depth >= DEEPEST {
            return None;
        }
        self.depth += 1;
        let found = self.tally(term, last);
        self.depth -= 1;
        found
    }

    fn tally(&mut self, term: &'a Term, last: Option<&'a Name>) -> Option<Tally<'a>> {
        match term.node() {
            Node::Stop | Node::Delay(_) | Node::Set(..) | Node::Ran(..) => Some(Tally::stops()),
            Node::Abort => Some(Tally { aborts: true, ..Tally::default() }),
            Node::Idle | Node::Observe(..) => Some(Tally::default()),
            Node::Guard(..) => Some(Tally { aborts: true, ..Tally::stops() }),
            Node::In(port, _) => Some(Tally::one(port, true)),
            Node::Out(port, _) => Some(Tally::one(port, false)),
            Node::Call(name, _) if Some(name) == last => Some(Tally::stops()),
            Node::Call(name, _) => self.called(name, term),
            Node::Seq(parts) => self.sequence(parts, last),
            Node::Par(parts) => self.parallel(parts, last),
            Node::Else(first, second) => self.alternative((first, second), last),
            Node::Disable(parts) => self.disabling(parts),
            Node::Power(body, count, _) => {
                let count = count.as_rational().filter(|count| count.is_integer());
                let count = count.and_then(|count| count.to_integer().to_usize());
                let times = |each: usize| if each == 0 { Some(0) } else { each.checked_mul(count?) };
                // A count that may be 0 also stops where the body never does.
                let none = count.is_none_or(|count| count == 0);
                self.within(body, None).map(|body| Tally { stops: body.stops || none, ..body }.each(times))
            }
            Node::Loop(body) => {
                let aborts = self.within(body, None)?.aborts;
                Some(Tally { stops: aborts, aborts: false, ..self.unknown(term) })
            }
            Node::New(port, body) => {
                let mut body = self.within(body, None)?;
                // It is another port than the one of this name outside.
                for (_, count) in body.uses.iter_mut().filter(|((used, _), _)| *used == port) {
                    *count = None;
                }
                Some(body)
            }
            Node::Project(body, _) => self.within(body, None),
            Node::Meta(..) | Node::Replace(..) => None,
        }
    }

    fn sequence(&mut self, parts: &'a [Term], last: Option<&'a Name>) -> Option<Tally<'a>> {
        let mut whole = Tally::stops();
        for (place, part) in parts.iter().enumerate() {
            let next = self.within(part, last.filter(|_| place + 1 == parts.len()))?;
            whole.add(&next);
            whole.aborts |= next.aborts;
            whole.stops &= next.stops;
        }
        Some(whole)
    }

    fn parallel(&mut self, parts: &'a [Term], last: Option<&'a Name>) -> Option<Tally<'a>> {
        if let [one, other] = parts
            && exclusive(one, other)
        {
            let one = self.chosen(one, last)?;
            return Some(one.either(&self.chosen(other, last)?));
        }
        let mut whole = Tally { aborts: true, ..Tally::stops() };
        for part in parts {
            let part = self.within(part, None)?;
            let (aborts, ends) = (part.aborts, part.ends());
            // What a part has done that aborts beside one that stops is not known.
            whole.add(&if aborts { part.each(|count| (count == 0).then_some(0)) } else { part });
            whole.aborts &= aborts;
            whole.stops &= ends;
        }
        Some(whole)
    }

    /// What a process does that begins with a guard, where that guard passes.
    fn chosen(&mut self, term: &'a Term, last: Option<&'a Name>) -> Option<Tally<'a>> {
        match term.node() {
            Node::Seq(parts) => self.sequence(parts.split_first()?.1, last),
            _ => Some(Tally::stops()),
        }
    }

    fn alternative(&mut self, (first, second): (&'a Term, &'a Term), last: Option<&'a Name>) -> Option<Tally<'a>> {
        let one = self.within(first, last)?;
        if !one.aborts {
            return Some(one);
        }
        let other = self.within(second, last)?;
        let (aborts, stops) = (other.aborts, one.stops || other.stops);
        let guarded = match first.node() {
            Node::Seq(parts) if is_guard(&parts[0]) => self.sequence(parts.split_first()?.1, last)?,
            _ => one.clone(),
        };
        // What a part has done that aborts later than at its first guard is not known.
        let both = if guarded.aborts && !one.uses.is_empty() {
            let mut both = one;
            both.add(&other);
            both.each(|count| (count == 0).then_some(0))
        } else {
            guarded.either(&other)
        };
        Some(Tally { aborts, stops, ..both })
    }

    /// It ends with the first part that does; where several may, it is not known how far the others are.
    fn disabling(&mut self, parts: &'a [Term]) -> Option<Tally<'a>> {
        let parts: Vec<Tally<'a>> = parts.iter().map(|part| self.within(part, None)).collect::<Option<_>>()?;
        let several = parts.iter().filter(|part| part.ends()).count() > 1;
        let mut whole = Tally::default();
        for part in parts {
            let (aborts, stops) = (part.aborts, part.stops);
            let known = part.ends() && !several;
            whole.add(&if known { part } else { part.each(|count| (count == 0).then_some(0)) });
            whole.aborts |= aborts;
            whole.stops |= stops;
        }
        Some(whole)
    }

    fn called(&mut self, name: &'a Name, call: &'a Term) -> Option<Tally<'a>> {
        if let Some(known) = self.known.get(name) {
            return known.as_deref().cloned();
        }
        // Nothing is known of it while it is looked at.
        self.known.insert(name, None);
        let definition = self.definitions.get(name)?;
        let found = if definition.recursive {
            // A loop stops when its body aborts.
            let stops = self.round(call).is_none();
            Some(Tally { stops, aborts: false, ..self.unknown(call) })
        } else {
            self.within(&definition.body, None)
        };
        self.known.insert(name, found.clone().map(Rc::new));
        found
    }

    /// What goes round: the ports that it uses, itself and by what it calls, an unknown number of times.
    fn unknown(&self, term: &'a Term) -> Tally<'a> {
        let mut whole = Tally { busy: true, ..Tally::default() };
        let mut seen: Vec<&Name> = Vec::new();
        let mut stack = vec![term];
        while let Some(term) = stack.pop() {
            for part in subterms(term) {
                match part.node() {
                    Node::In(port, _) => drop(whole.uses.insert((port, true), None)),
                    Node::Out(port, _) => drop(whole.uses.insert((port, false), None)),
                    Node::Call(name, _) if !seen.contains(&name) => {
                        seen.push(name);
                        stack.extend(self.definitions.get(name).map(|definition| &definition.body));
                    }
                    _ => {}
                }
            }
        }
        whole
    }
}

/// Whether another round follows.
fn goes_on(tally: &Tally<'_>) -> bool {
    tally.stops && !tally.aborts
}

/// The call that a process ends with, whichever way it goes; it stands for all of them.
fn last_call(term: &Term, depth: usize) -> Option<&Term> {
    if depth >= DEEPEST {
        return None;
    }
    let alike = |one: &'_ Term, other: &'_ Term| match (one.node(), other.node()) {
        (Node::Call(name, _), Node::Call(called, _)) => name == called,
        _ => false,
    };
    match term.node() {
        Node::Call(..) => Some(term),
        Node::Seq(parts) => last_call(parts.last()?, depth + 1),
        Node::Par(parts) => match parts.as_slice() {
            [one, other] if exclusive(one, other) => {
                let (one, other) = (last_call(one, depth + 1)?, last_call(other, depth + 1)?);
                alike(one, other).then_some(one)
            }
            _ => None,
        },
        Node::Else(first, second) => {
            let (one, other) = (last_call(first, depth + 1)?, last_call(second, depth + 1)?);
            alike(one, other).then_some(one)
        }
        _ => None,
    }
}

fn is_guard(term: &Term) -> bool {
    matches!(term.node(), Node::Guard(..))
}

/// Whether both begin with guards of which exactly one passes.
fn exclusive(one: &Term, other: &Term) -> bool {
    let first = |term: &'_ Term| match term.node() {
        Node::Seq(parts) => parts.first().cloned(),
        _ => Some(term.clone()),
    };
    let (Some(one), Some(other)) = (first(one), first(other)) else { return false };
    let (Node::Guard(relation, a, b), Node::Guard(against, c, d)) = (one.node(), other.node()) else { return false };
    (relation.negated() == *against && (a, b) == (c, d))
        || (relation.negated().mirrored() == *against && (a, b) == (d, c))
}
