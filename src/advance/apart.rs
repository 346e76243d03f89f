//! Draws that become due at several moments of one instant: parts of a network that each communicate and then draw, and
//! know nothing of each other before all have drawn.
//!
//! The network `N` is then weakly equal to `(Tau ; Ran_D1<e1> | … | Tau ; Ran_Dm<em>) ; N'`: here each branch is one
//! *moment*, with all that is drawn at it, and `N'` is the network when all have drawn.
//!
//! Why: all orders of the communications are followed, with a name for each value that is drawn, which stands for any
//! number. In each state of the network some moments have been and others are to come. What is found of all states: each
//! communication leads to a state at which nothing more is drawn, or draws just what belongs to one moment to come, the
//! same parts from the same distributions whatever the order; from a state with moments to come each of these can be
//! next, by communications at which nothing is drawn; no state goes on for ever; and when all have drawn, all orders
//! lead to one state. So a state of the network and that state of the branches at which the same moments have been
//! simulate each other: a communication without a draw is matched by none, one that leads to a moment by the `Tau` of its
//! branch, and that `Tau` by the communications that lead there. Both communicate, so neither lets time pass before all
//! have drawn. Then the network is a state that leads to the one last state, or that state itself.
//!
//! Parts may draw at several moments, one after the other, before others have drawn at all: then a branch is
//! `Tau ; Ran_D1<e1> ; Tau ; Ran_D2<e2> ; …`, its moments have one order in all orders of the communications, and the
//! next of each branch, and no other, can be next. In this case all that is drawn in the instant is in the branches.
//!
//! Where a part draws in several branches of its own, of which each waits for what is read of it, these may be told from
//! each other by the ports and calls that follow the draw. That is a name alone: what is drawn is another thing than all
//! that was drawn before under it, and the orders must agree as they must for parts. A branch that draws only when another
//! has drawn comes later, as a part does.
//!
//! A part may depend on what it has drawn in a way that is not decided for all values. It stays as it is, *open*: what it
//! may do in this instant, for any values whatever, is on ports that no other part may use in it, with no partner inside
//! and no draw. So for each value it is some state that changes nothing of the above.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use super::draw::{Due, nth};
use super::instantly::Reach;
use super::settle::Runner;
use super::{MOST_STATES, ORDER, is_drawing, leaf::Leaf, leaves, open_port, rebuilt, stuck};
use crate::name::Name;
use crate::scope::{read_names, subterms};
use crate::substitution::{Stuck, substitute_values};
use crate::term::{Node, Term};
use crate::value::Value;

/// The order matters, and why.
fn matters<T>(why: &str) -> Result<T, Stuck> {
    stuck(format!("{ORDER}: {why}"))
}

/// The parts of a network in one order of what happens in the instant.
#[derive(Clone, PartialEq, Eq, Hash)]
struct State {
    parts: Vec<Term>,
    /// The parts that are not decided.
    open: BTreeSet<usize>,
    /// The moments that have been.
    drawn: BTreeSet<usize>,
}

/// The parts after a communication, and those that are then open.
type Reached = (Vec<Term>, BTreeSet<usize>);

/// Who draws: a part, or those branches of it which go on with these ports and calls.
type Drawer = (usize, BTreeSet<Name>);

/// What is drawn at one moment: by whom, under which name of its own, the name that it gives, and from what.
type Moment = Vec<(Drawer, Name, Name, Value)>;

struct Search<'s, 'c, 'd> {
    runner: &'s Runner<'c, 'd>,
    ports: &'s [Name],
    /// The names that the network binds.
    bound: &'s BTreeSet<Name>,
    /// Those who may draw before any has drawn.
    drawing: BTreeSet<Drawer>,
    moments: Vec<Moment>,
    /// Whether the branches of a part are told from each other.
    by_branches: bool,
    /// Whether parts draw at several moments, until nothing is drawn any more in the instant.
    again: bool,
    states: Vec<State>,
    known: HashMap<State, usize>,
    /// From each state: where a communication leads, and what moment it leads to.
    ways: Vec<Vec<(usize, Option<usize>)>>,
}

/// What is drawn, moment by moment: by each part once, and if that has no answer until nothing is drawn any more; then by
/// each branch of a part.
pub(super) fn due(runner: &Runner<'_, '_>, start: &Term, ports: &[Name], bound: &BTreeSet<Name>) -> Result<Due, Stuck> {
    let Node::Par(parts) = start.node() else { return stuck(ORDER) };
    let first = State { parts: parts.clone(), open: BTreeSet::new(), drawn: BTreeSet::new() };
    let search = |again, by_branches| -> Result<Due, Stuck> {
        let mut search = Search {
            runner,
            ports,
            bound,
            drawing: BTreeSet::new(),
            moments: Vec::new(),
            by_branches,
            again,
            states: Vec::new(),
            known: HashMap::new(),
            ways: Vec::new(),
        };
        search.find_drawing(&first)?;
        if search.drawing.is_empty() {
            return stuck(ORDER);
        }
        search.follow(first.clone())?;
        let last = search.last()?;
        search.due(last)
    };
    let found = search(false, false);
    found.or_else(|why| search(true, false).or_else(|_| search(false, true)).map_err(|_| why))
}

/// The name, in this search, of what is drawn; no source text can spell it.
fn own((part, branch): &Drawer, number: usize) -> Name {
    let branch: String = branch.iter().map(|name| format!("!{name}")).collect();
    Name::new(&format!("!{part}.{number}{branch}"))
}

/// Who draws at a moment.
fn drawers(moment: &Moment) -> BTreeSet<Drawer> {
    moment.iter().map(|(drawer, ..)| drawer.clone()).collect()
}

/// The ports and calls of what follows in the innermost sequence.
fn goes_on(leaf: &Leaf<'_>) -> BTreeSet<Name> {
    let follows = leaf.followed_by().last();
    let named = |term: &Term| match term.node() {
        Node::In(port, _) | Node::Out(port, _) => Some(port.clone()),
        Node::Call(name, _) => Some(name.clone()),
        _ => None,
    };
    follows.iter().flat_map(|term| subterms(term).filter_map(named).collect::<Vec<_>>()).collect()
}

fn drawn_in(part: &Term) -> bool {
    leaves(part).iter().any(|leaf| is_drawing(leaf.term))
}

impl Search<'_, '_, '_> {
    /// Who draws at once in a part, in the order of its leaves.
    fn drawing_in(&self, part: usize, term: &Term) -> Vec<Drawer> {
        let branch = |leaf: &Leaf<'_>| if self.by_branches { goes_on(leaf) } else { BTreeSet::new() };
        leaves(term).iter().filter(|leaf| is_drawing(leaf.term)).map(|leaf| (part, branch(leaf))).collect()
    }

    /// Who draws after communications alone.
    fn find_drawing(&mut self, first: &State) -> Result<(), Stuck> {
        let mut seen = BTreeSet::from([first.parts.clone()]);
        let mut work = vec![first.parts.clone()];
        while let Some(parts) = work.pop() {
            let due: BTreeSet<usize> = (0..parts.len()).filter(|part| drawn_in(&parts[*part])).collect();
            for (next, _) in self.communications(&parts, &due)? {
                if seen.insert(next.clone()) {
                    work.push(next);
                }
            }
            let drawing = due.iter().flat_map(|part| self.drawing_in(*part, &parts[*part])).collect::<Vec<_>>();
            self.drawing.extend(drawing);
            if seen.len() > MOST_STATES {
                return stuck("too much may happen in one instant");
            }
        }
        Ok(())
    }

    /// The parts after each communication between parts that are not among these, with those that are then open.
    fn communications(&self, parts: &[Term], but: &BTreeSet<usize>) -> Result<Vec<Reached>, Stuck> {
        // A port of a part's own is called by the part and its `new`.
        type Port = (Name, Option<(usize, usize)>);
        let mut readers: Vec<(usize, usize, Port, Name)> = Vec::new();
        let mut writers: BTreeMap<Port, Vec<(usize, usize, Value)>> = BTreeMap::new();
        for (part, term) in parts.iter().enumerate().filter(|(part, _)| !but.contains(part)) {
            for (number, leaf) in leaves(term).into_iter().enumerate() {
                let binder = leaf.binder.map(|binder| (part, binder));
                match leaf.term.node() {
                    Node::In(port, _) | Node::Out(port, _) if binder.is_none() && !self.ports.contains(port) => {
                        return stuck(open_port(port));
                    }
                    Node::In(port, name) => readers.push((part, number, (port.clone(), binder), name.clone())),
                    Node::Out(port, value) => {
                        let port = (port.clone(), binder);
                        writers.entry(port).or_default().push((part, number, value.clone()));
                    }
                    _ => {}
                }
            }
        }
        let mut all = Vec::new();
        for (reader, read, port, name) in &readers {
            for (writer, written, value) in writers.get(port).into_iter().flatten() {
                let mut next = parts.to_vec();
                for part in BTreeSet::from([*reader, *writer]) {
                    next[part] = rebuilt(&next[part], &mut 0, &mut |number, _| {
                        if (part, number) == (*reader, *read) {
                            return Some(Term::new(Node::Set(value.clone(), name.clone())));
                        }
                        ((part, number) == (*writer, *written)).then(Term::stop)
                    });
                }
                let mut open = BTreeSet::new();
                for part in BTreeSet::from([*reader, *writer]) {
                    self.settle(&mut next, part, &mut open)?;
                }
                all.push((next, open));
            }
        }
        Ok(all)
    }

    /// Ends all that ends at once in a part, which stays as it is where that is not decided for all that was drawn.
    fn settle(&self, parts: &mut [Term], part: usize, open: &mut BTreeSet<usize>) -> Result<(), Stuck> {
        match self.runner.part(&parts[part]) {
            Ok(settled) => parts[part] = settled,
            Err(why) => {
                let hangs = read_names(&parts[part]).iter().any(|name| name.as_str().starts_with('!'));
                if !(hangs && why.0.starts_with("whether ")) {
                    return Err(why);
                }
                open.insert(part);
            }
        }
        Ok(())
    }

    /// All states that may come, from the first on, with the ways between them.
    fn follow(&mut self, first: State) -> Result<(), Stuck> {
        self.number(first);
        let mut place = 0;
        while let Some(state) = self.states.get(place).cloned() {
            let mut ways = Vec::new();
            if self.again || !(self.is_complete(&state) && state.parts.iter().any(drawn_in)) {
                for (parts, open) in self.communications(&state.parts, &state.open)? {
                    let open = state.open.union(&open).copied().collect();
                    let mut next = State { parts, open, drawn: state.drawn.clone() };
                    let done = !self.again && self.is_complete(&next);
                    let moment = if done { None } else { self.draw(&mut next)? };
                    self.open_parts_do_nothing(&next)?;
                    ways.push((self.number(next), moment));
                }
            }
            self.ways.push(ways);
            place += 1;
            if self.states.len() > MOST_STATES {
                return stuck("too much may happen in one instant");
            }
        }
        Ok(())
    }

    fn number(&mut self, state: State) -> usize {
        if let Some(known) = self.known.get(&state) {
            return *known;
        }
        self.states.push(state.clone());
        self.known.insert(state, self.states.len() - 1);
        self.states.len() - 1
    }

    /// Whether all have drawn that draw, or all moments that were found have been.
    fn is_complete(&self, state: &State) -> bool {
        if self.again {
            return state.drawn.len() == self.moments.len();
        }
        let drawn: BTreeSet<Drawer> = state.drawn.iter().flat_map(|moment| drawers(&self.moments[*moment])).collect();
        self.drawing.is_subset(&drawn)
    }

    /// Makes all draws that are due, and those that are due at once when they have been made.
    fn draw(&mut self, state: &mut State) -> Result<Option<usize>, Stuck> {
        let mut made = Moment::new();
        loop {
            let due: Vec<usize> = (0..state.parts.len())
                .filter(|part| !state.open.contains(part) && drawn_in(&state.parts[*part]))
                .collect();
            if due.is_empty() {
                break;
            }
            for part in due {
                let mut drawing = self.drawing_in(part, &state.parts[part]).into_iter();
                state.parts[part] = rebuilt(&state.parts[part], &mut 0, &mut |_, leaf| {
                    let Node::Ran(from, name) = leaf.node() else { return None };
                    let drawer = drawing.next()?;
                    let earlier = state.drawn.iter().flat_map(|moment| &self.moments[*moment]);
                    let number = earlier.chain(&made).filter(|(other, ..)| *other == drawer).count();
                    let own = own(&drawer, number);
                    made.push((drawer, own.clone(), name.clone(), from.clone()));
                    Some(Term::new(Node::Set(Value::variable(&own), name.clone())))
                });
                self.settle(&mut state.parts, part, &mut state.open)?;
                if made.len() > MOST_STATES {
                    return stuck("too much may happen in one instant");
                }
            }
        }
        if made.is_empty() {
            return Ok(None);
        }
        let number = self.numbered(made, &state.drawn)?;
        state.drawn.insert(number);
        Ok(Some(number))
    }

    /// The number of a moment, which comes after all others of its branch that have been found or is one of them.
    fn numbered(&mut self, made: Moment, drawn: &BTreeSet<usize>) -> Result<usize, Stuck> {
        let drawing = drawers(&made);
        let known = self.moments.iter().position(|moment| *moment == made);
        let meets = |moment: &Moment| !drawers(moment).is_disjoint(&drawing);
        let met: Vec<usize> = (0..self.moments.len()).filter(|other| meets(&self.moments[*other])).collect();
        let mut before = met.iter().filter(|other| known.is_none_or(|known| **other < known));
        // As many as have been: no moment of the branch has been that comes after it.
        let in_turn = before.clone().count() == met.iter().filter(|other| drawn.contains(other)).count();
        if !in_turn
            || !before.all(|other| drawn.contains(other) && self.again && drawers(&self.moments[*other]) == drawing)
        {
            return matters("what is drawn at one moment depends on it");
        }
        match known {
            Some(number) => Ok(number),
            None if self.again || drawing.is_subset(&self.drawing) => {
                self.moments.push(made);
                Ok(self.moments.len() - 1)
            }
            None => matters("what is drawn at one moment depends on it"),
        }
    }

    /// The moments that come next if these have been: in each branch the first that has not.
    fn next(&self, drawn: &BTreeSet<usize>) -> BTreeSet<usize> {
        self.branches()
            .iter()
            .filter_map(|branch| branch.iter().find(|moment| !drawn.contains(moment)).copied())
            .collect()
    }

    /// The moments of each branch, one after the other.
    fn branches(&self) -> Vec<Vec<usize>> {
        let mut branches: Vec<Vec<usize>> = Vec::new();
        for number in 0..self.moments.len() {
            let own = drawers(&self.moments[number]);
            match branches.iter_mut().find(|branch| drawers(&self.moments[branch[0]]) == own) {
                Some(branch) => branch.push(number),
                None => branches.push(vec![number]),
            }
        }
        branches
    }

    /// What the parts that are not decided may do in this instant is nothing that others, or they, could answer.
    fn open_parts_do_nothing(&self, state: &State) -> Result<(), Stuck> {
        if state.open.is_empty() {
            return Ok(());
        }
        let reach = |part: &Term| Reach::of(part, self.bound, self.runner.context);
        let all: Vec<Reach> = state.parts.iter().map(reach).collect::<Result<_, Stuck>>()?;
        for own in state.open.iter().map(|part| &all[*part]) {
            let shared = |port: &Name| all.iter().filter(|other| other.uses(port)).count() > 1;
            if own.draws {
                return matters("a part may draw again, as a value that was drawn is");
            }
            if let Some(port) = own.ports().find(|port| !self.ports.contains(port)) {
                return stuck(open_port(port));
            }
            if let Some(port) = own.ports().find(|port| shared(port) || own.answers(port)) {
                return matters(&format!("a part may use port {port}, as a value that was drawn is"));
            }
        }
        Ok(())
    }

    /// The state of the network when all have drawn, if all orders agree on it.
    fn last(&self) -> Result<usize, Stuck> {
        let mut left: Vec<usize> = self.ways.iter().map(Vec::len).collect();
        let mut before: Vec<Vec<(usize, Option<usize>)>> = vec![Vec::new(); self.states.len()];
        for (from, ways) in self.ways.iter().enumerate() {
            ways.iter().for_each(|(to, moment)| before[*to].push((from, *moment)));
        }
        let ends: Vec<usize> = (0..left.len()).filter(|state| left[*state] == 0).collect();
        let mut can: Vec<BTreeSet<usize>> = vec![BTreeSet::new(); self.states.len()];
        let (mut work, mut met) = (ends.clone(), 0);
        while let Some(state) = work.pop() {
            met += 1;
            for (from, moment) in &before[state] {
                let more: Vec<usize> = moment.map_or_else(|| can[state].iter().copied().collect(), |one| vec![one]);
                can[*from].extend(more);
                left[*from] -= 1;
                if left[*from] == 0 {
                    work.push(*from);
                }
            }
        }
        if met < self.states.len() {
            return stuck("it communicates for ever in no time");
        }
        for (state, can) in self.states.iter().zip(&can) {
            if *can != self.next(&state.drawn) {
                return matters("a draw waits for another, or prevents it");
            }
        }
        match ends.as_slice() {
            [last] if self.is_complete(&self.states[*last]) => self.entered(*last),
            _ => stuck(ORDER),
        }
    }

    /// The state to which the moments lead, given the one to which all orders lead.
    fn entered(&self, last: usize) -> Result<usize, Stuck> {
        let end = &self.states[last];
        let first =
            self.ways.iter().flatten().filter(|(to, moment)| moment.is_some() && self.is_complete(&self.states[*to]));
        let first: BTreeSet<usize> = first.map(|(to, _)| *to).collect();
        if first.iter().all(|state| *state == last) {
            return Ok(last);
        }
        let runs =
            |part: usize| !end.open.contains(&part) && !matches!(end.parts[part].node(), Node::Stop | Node::Abort);
        if !(0..end.parts.len()).any(runs) {
            return stuck("the network has ended");
        }
        // A draw that is due at once is another thing than one that is due when more has been communicated.
        match first.first() {
            Some(one) if end.parts.iter().any(drawn_in) => {
                if first.contains(&last) {
                    matters("a draw may be due at once or later")
                } else {
                    Ok(*one)
                }
            }
            _ => Ok(last),
        }
    }

    /// What is drawn, branch by branch and in each in the order of the moments, and the network in this state.
    fn due(&self, last: usize) -> Result<Due, Stuck> {
        let mut names: BTreeMap<Name, Value> = BTreeMap::new();
        let (mut drawn, mut branches) = (Vec::new(), Vec::new());
        for branch in self.branches() {
            let (mut own, mut moments) = (BTreeSet::new(), Vec::new());
            for (_, name, given, from) in branch.iter().flat_map(|moment| &self.moments[*moment]) {
                if from.variables().iter().any(|read| read.as_str().starts_with('!') && !own.contains(read)) {
                    return matters("what one part draws from is drawn by another");
                }
                drawn.push((given.clone(), from.substitute(&names)?));
                names.insert(name.clone(), Value::variable(&nth(names.len())));
                own.insert(name.clone());
            }
            let mut from = drawn.len() - own.len();
            for moment in &branch {
                moments.push(from..from + self.moments[*moment].len());
                from += self.moments[*moment].len();
            }
            branches.push(moments);
        }
        let after = substitute_values(&Term::par(self.states[last].parts.iter().cloned()), &names)?;
        Ok(Due { drawn, branches, later: true, after })
    }
}
