//! Substitution: of metavariables in laws, of values for names in processes, of a process for a call.

use std::collections::{BTreeMap, BTreeSet};

use crate::assumption::Assumptions;
use crate::fact::{Context, Facts};
use crate::law::Condition;
use crate::name::Name;
use crate::scope::{bound_names, subterms, written};
use crate::term::{Node, Term};
use crate::value::{Relation, Sort, Value, ValueError};

/// Why a substitution has no result.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stuck(pub String);

impl From<ValueError> for Stuck {
    fn from(error: ValueError) -> Stuck {
        Stuck(error.0)
    }
}

/// What a law's metavariables stand for: processes, values, names of ports, results and indices, sets of observers.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Substitution {
    /// `?P`
    pub processes: BTreeMap<Name, Term>,
    /// `?x` in value position
    pub values: BTreeMap<Name, Value>,
    /// `?c` and `?y` in port, result and index position
    pub names: BTreeMap<Name, Name>,
    /// `?S` in `P to {?S}`
    pub sets: BTreeMap<Name, BTreeSet<Name>>,
}

impl Substitution {
    /// The instance of a law's side. A `P[y := x]` in it is carried out.
    ///
    /// # Errors
    /// When a value has no normal form, or a replacement cannot be carried out (see [`replace`]).
    pub fn apply(&self, pattern: &Term, context: &Context<'_>) -> Result<Term, Stuck> {
        if let Node::Meta(meta, arguments) = pattern.node()
            && arguments.is_empty()
        {
            return Ok(self.processes.get(meta).unwrap_or(pattern).clone());
        }
        let children = pattern.children();
        if children.is_empty() {
            return self.apply_shallow(pattern, context);
        }
        let parts: Result<Vec<Term>, Stuck> = children.into_iter().map(|part| self.apply(part, context)).collect();
        let shape = pattern.with_children(parts?);
        match pattern.node() {
            Node::Seq(_) | Node::Par(_) | Node::Disable(_) | Node::Else(..) | Node::Loop(_) => Ok(shape),
            _ => self.apply_shallow(&shape, context),
        }
    }

    fn apply_shallow(&self, shape: &Term, context: &Context<'_>) -> Result<Term, Stuck> {
        let name = |name: &Name| self.names.get(name).cloned().unwrap_or_else(|| name.clone());
        let shape = shape.map_values(&mut |value| self.value(value, context))?;
        Ok(Term::new(match shape.node().clone() {
            Node::Meta(meta, arguments) if arguments.is_empty() => match self.processes.get(&meta) {
                Some(process) => return Ok(process.clone()),
                None => Node::Meta(meta, arguments),
            },
            Node::In(port, result) => Node::In(name(&port), name(&result)),
            Node::Out(port, value) => Node::Out(name(&port), value),
            Node::Set(value, result) => Node::Set(value, name(&result)),
            Node::Ran(value, result) => Node::Ran(value, name(&result)),
            Node::New(port, body) => Node::New(name(&port), body),
            Node::Power(body, count, index) => Node::Power(body, count, index.as_ref().map(name)),
            Node::Project(body, shown) => Node::Project(body, self.set(&shown)),
            Node::Replace(body, result, value) => return replace(&body, &name(&result), &value, context),
            node => node,
        }))
    }

    /// The instance of a value. A name that stands for a port, result or index may be read as a value too.
    ///
    /// # Errors
    /// When the instance has no normal form.
    pub fn value(&self, value: &Value, context: &Context<'_>) -> Result<Value, Stuck> {
        if let Some(name) = value.as_variable() {
            let known = self.values.get(name).cloned().or_else(|| self.names.get(name).map(Value::variable));
            return Ok(known.unwrap_or_else(|| value.clone()));
        }
        if value.as_rational().is_some() {
            return Ok(value.clone());
        }
        Ok(context.assumptions.put_in_powers(value, &self.read())?)
    }

    /// What is put in where a value reads a metavariable: a value, or another name.
    pub fn read(&self) -> BTreeMap<Name, Value> {
        let mut map = self.values.clone();
        for (meta, name) in &self.names {
            map.entry(meta.clone()).or_insert_with(|| Value::variable(name));
        }
        map
    }

    fn set(&self, names: &BTreeSet<Name>) -> BTreeSet<Name> {
        names
            .iter()
            .flat_map(|name| self.sets.get(name).cloned().unwrap_or_else(|| BTreeSet::from([name.clone()])))
            .collect()
    }

    /// The instance of a condition.
    ///
    /// # Errors
    /// As for [`Substitution::apply`].
    pub fn condition(&self, condition: &Condition, context: &Context<'_>) -> Result<Condition, Stuck> {
        let name = |name: &Name| self.names.get(name).cloned().unwrap_or_else(|| name.clone());
        let term = |term: &Term| self.apply(term, context);
        Ok(match condition {
            Condition::Compare(relation, left, right) => {
                Condition::Compare(*relation, self.value(left, context)?, self.value(right, context)?)
            }
            Condition::Natural(value) => Condition::Natural(self.value(value, context)?),
            Condition::Is(fact, subject) => Condition::Is(*fact, term(subject)?),
            Condition::Lasts(subject, time) => Condition::Lasts(term(subject)?, self.value(time, context)?),
            Condition::Complementary(first, second) => Condition::Complementary(term(first)?, term(second)?),
            Condition::NoPort(subject, port) => Condition::NoPort(term(subject)?, name(port)),
            Condition::Unread(subject, result) => Condition::Unread(term(subject)?, name(result)),
            Condition::Apart(first, second) => Condition::Apart(term(first)?, term(second)?),
            Condition::ShowsOnly(subject, shown) => Condition::ShowsOnly(term(subject)?, self.set(shown)),
            Condition::ShowsNone(subject, shown) => Condition::ShowsNone(term(subject)?, self.set(shown)),
        })
    }
}

/// `P[y := x]`: the reads of y that P makes before it binds y see x instead.
///
/// # Errors
/// When some read of y may or may not see a new binding (a part that binds y in some runs only, a loop that binds y
/// later than it reads it), or when a bound name of P would capture a name of x. Of two names one of which is a
/// metavariable it is not known whether they are the same.
pub fn replace(term: &Term, name: &Name, value: &Value, context: &Context<'_>) -> Result<Term, Stuck> {
    let facts = Facts::of(term, context);
    if !facts.reads.names.contains(name) && facts.reads.processes.is_empty() {
        return Ok(term.clone());
    }
    let map = BTreeMap::from([(name.clone(), value.clone())]);
    match term.node() {
        Node::Replace(_, same, old) if same == name && !old.mentions(name) => Ok(term.clone()),
        Node::Seq(parts) => replace_in_sequence(parts, name, value, context),
        Node::Meta(..) | Node::Replace(..) => Ok(Term::new(Node::Replace(term.clone(), name.clone(), value.clone()))),
        Node::Power(body, _, index) => {
            captures(term, value, context)?;
            if may_bind(&Facts::of(body, context), name) {
                return Err(Stuck(format!("a later round would read another {name}")));
            }
            let shape = term.map_values(&mut |old| context.assumptions.put_in(old, &map))?;
            if index.as_ref() == Some(name) {
                return Ok(shape);
            }
            Ok(shape.with_children(vec![replace(body, name, value, context)?]))
        }
        Node::Loop(body) => {
            captures(term, value, context)?;
            if may_bind(&Facts::of(body, context), name) {
                return Err(Stuck(format!("a later round would read another {name}")));
            }
            Ok(term.with_children(vec![replace(body, name, value, context)?]))
        }
        _ => {
            captures(term, value, context)?;
            let shape = term.map_values(&mut |old| context.assumptions.put_in(old, &map))?;
            let parts: Result<Vec<Term>, Stuck> =
                term.children().map(|part| replace(part, name, value, context)).collect();
            Ok(if term.children().is_empty() { shape } else { shape.with_children(parts?) })
        }
    }
}

fn replace_in_sequence(parts: &[Term], name: &Name, value: &Value, context: &Context<'_>) -> Result<Term, Stuck> {
    let mut out = Vec::with_capacity(parts.len());
    let mut active = true;
    for (position, part) in parts.iter().enumerate() {
        if !active {
            out.push(part.clone());
            continue;
        }
        match replace(part, name, value, context) {
            Ok(part) => out.push(part),
            Err(why) => return failed(out, context).ok_or(why),
        }
        let facts = Facts::of(part, context);
        if facts.surely_binds.contains(name) {
            active = false;
        } else {
            let rest = Term::seq(parts[position + 1..].iter().cloned());
            let facts_of_rest = Facts::of(&rest, context);
            let reads = &facts_of_rest.reads;
            let later = position + 1 < parts.len() && (reads.names.contains(name) || !reads.processes.is_empty());
            if later && may_bind(&facts, name) {
                return Err(Stuck(format!("{name} may be bound anew in some runs only")));
            }
            let written = &facts.binds.names;
            if later && value.variables().iter().any(|read| catches(written, read)) {
                return Err(Stuck(format!("a name in {value} is bound before {name} is read")));
            }
        }
    }
    Ok(Term::seq(out))
}

/// `Set_x<y> ; P`, of which the reads of y are made, as a process in which x is bound as late as it may be: as
/// [`replace`], but a part of a sequence that binds y in some runs only binds x in the others (see [`bound_at_last`]).
///
/// # Errors
/// As for [`replace`], where there is no such part.
pub fn carried_on(term: &Term, name: &Name, value: &Value, context: &Context<'_>) -> Result<Term, Stuck> {
    let stuck = match replace(term, name, value, context) {
        Ok(term) => return Ok(term),
        Err(why) => why,
    };
    let Node::Seq(parts) = term.node() else { return Err(stuck) };
    let Some(place) = parts.iter().position(|part| may_bind(&Facts::of(part, context), name)) else {
        return Err(stuck);
    };
    let written: BTreeSet<Name> =
        parts[..place].iter().flat_map(|part| Facts::of(part, context).binds.names.clone()).collect();
    if value.variables().iter().any(|read| catches(&written, read)) {
        return Err(stuck);
    }
    let before = parts[..=place].iter().map(|part| replace(part, name, value, context));
    let mut parts_now = before.collect::<Result<Vec<Term>, Stuck>>()?;
    let last = parts_now.pop().and_then(|part| bound_at_last(&part, name, value)).ok_or(stuck)?;
    Ok(Term::seq(parts_now.into_iter().chain([last]).chain(parts[place + 1..].iter().cloned())))
}

/// For a time-out, `(In_c<z> ; Set_1<y>) # Delay_t`, which binds y in some runs only: the same that binds it to this
/// value in the others, `(In_c<z> ; Set_1<y>) # (Delay_t ; Set_x<y>)`. None of anything else.
///
/// What ends it carries what it binds. Each part either binds y whenever it stops, and stops only as it has communicated;
/// or it lets time pass and nothing else, and stops as time has passed or where it begins. So no two of different kinds stop
/// at once, and where it stops y is bound to what it was bound to by the last of the two before.
pub(crate) fn bound_at_last(term: &Term, name: &Name, value: &Value) -> Option<Term> {
    let Node::Disable(parts) = term.node() else { return None };
    let bound = |part: &Term| {
        if matches!(part.node(), Node::Idle | Node::Observe(..)) {
            return Some(part.clone());
        }
        if waits_only(part) {
            return Some(Term::seq([part.clone(), Term::new(Node::Set(value.clone(), name.clone()))]));
        }
        binds_behind_a_communication(part, name).then(|| part.clone())
    };
    Some(Term::disable(parts.iter().map(bound).collect::<Option<Vec<_>>>()?))
}

/// Whether it binds nothing, communicates nothing and tests nothing.
fn waits_only(term: &Term) -> bool {
    match term.node() {
        Node::Delay(_) | Node::Idle | Node::Observe(..) => true,
        Node::Seq(_) | Node::Par(_) | Node::Disable(_) => term.children().all(waits_only),
        _ => false,
    }
}

/// Whether the name is bound wherever it stops, and it stops only as it has communicated.
fn binds_behind_a_communication(term: &Term, name: &Name) -> bool {
    let alone = std::slice::from_ref(term);
    let parts = match term.node() {
        Node::Seq(parts) => &parts[..],
        _ => alone,
    };
    let binds = |part: &Term| matches!(part.node(), Node::In(_, bound) | Node::Set(_, bound) if bound == name);
    let last = parts.iter().rfind(|part| !matches!(part.node(), Node::Set(..) | Node::Guard(..)));
    parts.iter().any(binds) && last.is_some_and(|last| matches!(last.node(), Node::In(..) | Node::Out(..)))
}

/// A sequence of which these are the first parts and no other has a value, if one of them is a comparison that fails:
/// what is behind it is never begun, so `Abort` stands for it.
fn failed(mut first: Vec<Term>, context: &Context<'_>) -> Option<Term> {
    let fails = |part: &Term| {
        let Node::Guard(relation, left, right) = part.node() else { return false };
        let real = left.sort() == Sort::Real && right.sort() == Sort::Real;
        (real || matches!(relation, Relation::Eq | Relation::Neq))
            && context.assumptions.decide(*relation, left, right) == Some(false)
    };
    let place = first.iter().position(fails)?;
    first.truncate(place);
    first.push(Term::abort());
    Some(Term::seq(first))
}

/// Whether a process may bind this name, or one that may turn out the same.
fn may_bind(facts: &Facts, name: &Name) -> bool {
    let binds = &facts.binds;
    catches(&binds.names, name) || (name.is_meta() && !binds.names.is_empty()) || !binds.processes.is_empty()
}

/// Whether one of these names is this one, or a metavariable that may turn out to be. A metavariable that is read
/// stands for a value that none of them binds; the kernel sees to that wherever it is replaced.
fn catches(bound: &BTreeSet<Name>, read: &Name) -> bool {
    bound.contains(read) || bound.iter().any(Name::is_meta)
}

/// Refuses a replacement under a binder or a write of a name that the value reads.
fn captures(term: &Term, value: &Value, context: &Context<'_>) -> Result<(), Stuck> {
    let reads = value.variables();
    let caught = match term.node() {
        Node::Power(body, _, index) => {
            let index: BTreeSet<Name> = index.iter().cloned().collect();
            reads.iter().any(|read| catches(&index, read)) || may_write(body, &reads, context)
        }
        Node::Loop(body) => may_write(body, &reads, context),
        _ => false,
    };
    if caught { Err(Stuck(format!("a name in {value} would change its meaning"))) } else { Ok(()) }
}

/// Whether the process, or one that stands for a metavariable of it, may write one of these names.
fn may_write(body: &Term, reads: &BTreeSet<Name>, context: &Context<'_>) -> bool {
    let binds = &Facts::of(body, context).binds;
    reads.iter().any(|read| catches(&binds.names, read)) || (!reads.is_empty() && !binds.processes.is_empty())
}

/// A definition's body with arguments for parameters, at once.
///
/// # Errors
/// When an argument reads a name that the body, or a process that it calls, binds before the argument is read.
pub fn instantiate(
    body: &Term,
    parameters: &[Name],
    arguments: &[Value],
    context: &Context<'_>,
) -> Result<Term, Stuck> {
    let bound = binds(body, context);
    let map: BTreeMap<Name, Value> = parameters.iter().cloned().zip(arguments.iter().cloned()).collect();
    if let Some(parameter) = parameters.iter().find(|parameter| bound.contains(*parameter)) {
        return Err(Stuck(format!("{parameter} is a parameter and is bound in the body")));
    }
    let open = bound.iter().any(Name::is_meta) || subterms(body).any(|part| matches!(part.node(), Node::Meta(..)));
    if open && let Some(read) = map.values().find_map(|argument| argument.variables().into_iter().next()) {
        return Err(Stuck(format!("{read} may be bound in the body, which is not known")));
    }
    for argument in map.values() {
        if let Some(caught) = argument.variables().into_iter().find(|read| bound.contains(read)) {
            // Reads come before writes in a round, so only a read after the write is at risk; refused when in doubt.
            if reads_after_write(body, &caught, parameters, &map, context) {
                return Err(Stuck(format!("{caught} is bound again in the body before an argument is read")));
            }
        }
    }
    arguments_put(body, &map, context)
}

/// The values put in as [`substitute_values`] does it, where what is not reached needs not have one.
fn arguments_put(term: &Term, map: &BTreeMap<Name, Value>, context: &Context<'_>) -> Result<Term, Stuck> {
    index_kept(term, map)?;
    for value in term.values() {
        context.assumptions.put_in(value, map)?;
    }
    let shape = term.map_values(&mut |value| value.substitute(map))?;
    if term.children().is_empty() {
        return Ok(shape);
    }
    let mut parts = Vec::new();
    for part in term.children() {
        match arguments_put(part, map, context) {
            Ok(part) => parts.push(part),
            Err(why) if matches!(term.node(), Node::Seq(_)) => return failed(parts, context).ok_or(why),
            Err(why) => return Err(why),
        }
    }
    Ok(shape.with_children(parts))
}

/// All names that a process binds itself, or that a process it calls writes.
fn binds(term: &Term, context: &Context<'_>) -> BTreeSet<Name> {
    let mut names = bound_names(term);
    names.extend(written(term, context.definitions));
    names
}

fn reads_after_write(
    body: &Term,
    caught: &Name,
    parameters: &[Name],
    map: &BTreeMap<Name, Value>,
    context: &Context<'_>,
) -> bool {
    let risky: BTreeSet<&Name> = parameters
        .iter()
        .filter(|parameter| map.get(*parameter).is_some_and(|argument| argument.mentions(caught)))
        .collect();
    let Node::Seq(parts) = body.node() else {
        return true;
    };
    let Some(first) = parts.iter().position(|part| binds(part, context).contains(caught)) else {
        return false;
    };
    let inner = !matches!(parts[first].node(), Node::In(..) | Node::Set(..) | Node::Ran(..));
    let rest = &parts[if inner { first } else { first + 1 }..];
    rest.iter().any(|part| Facts::of(part, context).reads.names.iter().any(|read| risky.contains(read)))
}

/// Whether the index of copies means the same when these values are put in.
fn index_kept(term: &Term, map: &BTreeMap<Name, Value>) -> Result<(), Stuck> {
    match term.node() {
        Node::Power(_, _, Some(index))
            if map.contains_key(index) || map.values().any(|value| value.mentions(index)) =>
        {
            Err(Stuck(format!("the index {index} would change its meaning")))
        }
        _ => Ok(()),
    }
}

/// Every read of the names in `map` replaced, wherever it stands: right when nothing in the term binds them.
///
/// # Errors
/// When a value has no normal form or an index would capture a name.
pub fn substitute_values(term: &Term, map: &BTreeMap<Name, Value>) -> Result<Term, Stuck> {
    index_kept(term, map)?;
    let shape = term.map_values(&mut |value| value.substitute(map))?;
    if term.children().is_empty() {
        return Ok(shape);
    }
    let parts: Result<Vec<Term>, Stuck> = term.children().map(|part| substitute_values(part, map)).collect();
    Ok(shape.with_children(parts?))
}

/// The same where no exponent is lost of which it is not known that it counts: see [`Assumptions::put_in_powers`].
///
/// # Errors
/// As for [`substitute_values`], and where a power may come out as another.
pub fn substitute_known(term: &Term, map: &BTreeMap<Name, Value>, known: &Assumptions) -> Result<Term, Stuck> {
    for value in subterms(term).flat_map(Term::values) {
        known.put_in_powers(value, map)?;
    }
    substitute_values(term, map)
}
