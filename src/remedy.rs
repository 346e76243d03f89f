//! What would make a false claim true: conditions from the closed list of those that laws may have, tried one after the
//! other, and judged by the executable meaning.

use std::collections::BTreeSet;

use crate::fact::Context;
use crate::kernel::Theory;
use crate::law::{Condition, Fact, Law};
use crate::matching::matches;
use crate::name::Name;
use crate::proof::{Statement, hole};
use crate::prove::{Answer, By, prove};
use crate::refute::{Limits, Refutation, refute};
use crate::rewrite;
use crate::scope::{fill, metavariables};
use crate::simplify::{Simplifier, surround};
use crate::term::{Node, Term};
use crate::value::{Relation, Value};

/// A condition under which no counterexample is left.
#[derive(Clone, Debug)]
pub struct Remedy {
    /// The conditions, all of which are needed.
    pub conditions: Vec<Condition>,
    /// Whether the claim was then proved, and the proof checked by the kernel.
    pub proved: bool,
    /// The instances that meet the condition and were tried.
    pub instances: usize,
}

/// A condition that leaves fewer instances than this says too little.
const FEWEST: usize = 10;
/// The most remedies given.
const MOST: usize = 3;
/// The most pairs of conditions tried.
const MOST_PAIRS: usize = 150;

/// How hard to look for a counterexample, first quickly.
const TRIALS: [usize; 2] = [150, 1_500];

/// Conditions that make a refuted statement true as far as its small instances tell, the weakest first, at most three.
/// Those under which it is proved come before the others.
pub fn remedies(theory: &Theory, statement: &Statement, interrupted: &dyn Fn() -> bool) -> Vec<Remedy> {
    let candidates = candidates(statement);
    let mut found: Vec<(usize, Remedy)> = Vec::new();
    let mut consider = |conditions: Vec<Condition>| {
        if interrupted() {
            return;
        }
        if let Some((cost, instances)) = stands(theory, statement, &conditions) {
            found.push((cost, Remedy { conditions, proved: false, instances }));
        }
    };
    candidates.iter().for_each(|condition| consider(vec![condition.clone()]));
    if found.is_empty() {
        let pairs = candidates
            .iter()
            .enumerate()
            .flat_map(|(place, one)| candidates.iter().skip(place + 1).map(move |two| vec![one.clone(), two.clone()]));
        let mut left = MOST_PAIRS;
        for pair in pairs {
            left = left.saturating_sub(1);
            if left == 0 || found.len() >= MOST {
                break;
            }
            if interrupted() {
                break;
            }
            if let Some((cost, instances)) = stands(theory, statement, &pair) {
                found.push((cost, Remedy { conditions: pair, proved: false, instances }));
            }
        }
    }
    let single: Vec<Condition> = found.iter().filter_map(|(_, one)| only(&one.conditions).cloned()).collect();
    found.retain(|(_, one)| only(&one.conditions).is_none_or(|own| !single.iter().any(|other| implies(own, other))));
    // A weak condition lets more instances through, so that the search ends at a lower cost.
    found.sort_by_key(|(cost, remedy)| (*cost, std::cmp::Reverse(remedy.instances)));
    let mut all: Vec<Remedy> = found.into_iter().map(|(_, remedy)| remedy).take(2 * MOST).collect();
    for remedy in &mut all {
        remedy.proved = provable(theory, statement, &remedy.conditions, interrupted);
    }
    all.sort_by_key(|remedy| !remedy.proved);
    all.truncate(MOST);
    all
}

fn only(conditions: &[Condition]) -> Option<&Condition> {
    if let [one] = conditions { Some(one) } else { None }
}

/// Whether the first condition asks for more than the second, which it then adds nothing to.
fn implies(strong: &Condition, weak: &Condition) -> bool {
    match (strong, weak) {
        (Condition::Is(strong, one), Condition::Is(weak, two)) if one == two => match strong {
            Fact::Observer => !matches!(weak, Fact::Observer | Fact::Guard | Fact::Immediate),
            Fact::Guard => matches!(weak, Fact::Silent | Fact::DrawsNothing | Fact::BindsNothing | Fact::Still),
            Fact::Immediate => matches!(weak, Fact::NeverAborts | Fact::Still),
            Fact::Running => matches!(weak, Fact::NotStopped | Fact::Guarded),
            Fact::NeverStops => matches!(weak, Fact::NotStopped | Fact::Guarded | Fact::BindsNothing),
            _ => false,
        },
        (Condition::Lasts(one, _), Condition::Is(fact, two)) if one == two => {
            matches!(fact, Fact::NeverAborts | Fact::Silent | Fact::BindsNothing)
        }
        (Condition::Compare(strong, a, b), Condition::Compare(weak, c, d)) if (a, b) == (c, d) => {
            matches!(
                (strong, weak),
                (Relation::Eq, Relation::Lte | Relation::Gte)
                    | (Relation::Lss, Relation::Lte | Relation::Neq)
                    | (Relation::Gtr, Relation::Gte | Relation::Neq)
            )
        }
        _ => false,
    }
}

fn supposing(statement: &Statement, conditions: &[Condition]) -> Statement {
    let mut statement = statement.clone();
    statement.hypotheses.extend(conditions.iter().cloned());
    statement
}

/// The cost up to which all instances were tried, and their number, if none is a counterexample and enough were tried.
fn stands(theory: &Theory, statement: &Statement, conditions: &[Condition]) -> Option<(usize, usize)> {
    let statement = supposing(statement, conditions);
    let mut last = None;
    for instances in TRIALS {
        let limits = Limits { instances, choices: 40 * instances, ..Limits::default() };
        let judged = refute(
            &statement.left,
            &statement.right,
            statement.connective,
            &statement.hypotheses,
            &theory.definitions,
            &theory.assumptions,
            &limits,
        );
        match judged {
            Refutation::Refuted(_) => return None,
            Refutation::None { cost, instances, meaningless, open, .. } => {
                let tried = instances.saturating_sub(meaningless + open);
                if tried < FEWEST {
                    return None;
                }
                last = Some((cost, tried));
            }
        }
    }
    last
}

fn provable(theory: &Theory, statement: &Statement, conditions: &[Condition], interrupted: &dyn Fn() -> bool) -> bool {
    let limits = rewrite::Limits { rounds: 4, nodes: 1_500, ..rewrite::Limits::default() };
    matches!(prove(theory, &supposing(statement, conditions), &By::Search, limits, interrupted), Answer::Proved(..))
}

/// Every condition on what varies in the statement, of the kinds that laws have, which it does not suppose already.
fn candidates(statement: &Statement) -> Vec<Condition> {
    let mut names: BTreeSet<Name> = metavariables(&statement.left);
    names.extend(metavariables(&statement.right));
    let mut values = read(&statement.left);
    values.extend(read(&statement.right));
    let (mut ports, mut results) = (BTreeSet::new(), BTreeSet::new());
    for term in [&statement.left, &statement.right] {
        for part in crate::scope::subterms(term) {
            match part.node() {
                Node::In(port, result) => {
                    ports.insert(port.clone());
                    results.insert(result.clone());
                }
                Node::Out(port, _) | Node::New(port, _) => {
                    ports.insert(port.clone());
                }
                Node::Set(_, result) | Node::Ran(_, result) => {
                    results.insert(result.clone());
                }
                _ => {}
            }
        }
    }
    let process = |name: &&Name| name.as_str().chars().nth(1).is_some_and(char::is_uppercase);
    let processes: Vec<Term> = names.iter().filter(process).map(Term::meta).collect();
    let mut all = Vec::new();
    for term in &processes {
        all.extend(Fact::ALL.iter().map(|(fact, _)| Condition::Is(*fact, term.clone())));
        all.extend(ports.iter().map(|port| Condition::NoPort(term.clone(), port.clone())));
        all.extend(results.iter().map(|name| Condition::Unread(term.clone(), name.clone())));
    }
    values.retain(|name| !results.contains(name) && !ports.contains(name));
    let values: Vec<Value> = values.iter().map(Value::variable).collect();
    let zero = Value::zero();
    for value in &values {
        for relation in [Relation::Gte, Relation::Gtr, Relation::Lte, Relation::Eq] {
            all.push(Condition::Compare(relation, value.clone(), zero.clone()));
        }
        all.push(Condition::Natural(value.clone()));
        for other in values.iter().filter(|other| *other != value) {
            all.push(Condition::Compare(Relation::Lte, value.clone(), other.clone()));
            all.push(Condition::Compare(Relation::Lss, value.clone(), other.clone()));
            if value < other {
                all.push(Condition::Compare(Relation::Eq, value.clone(), other.clone()));
                all.push(Condition::Compare(Relation::Neq, value.clone(), other.clone()));
            }
        }
        all.extend(processes.iter().map(|term| Condition::Lasts(term.clone(), value.clone())));
    }
    for one in &processes {
        for two in processes.iter().filter(|two| *two != one) {
            all.push(Condition::Apart(one.clone(), two.clone()));
            if one < two {
                all.push(Condition::Complementary(one.clone(), two.clone()));
            }
        }
    }
    all.retain(|condition| !statement.hypotheses.contains(condition));
    all
}

/// The names of values in a term that it does not bind itself.
fn read(term: &Term) -> BTreeSet<Name> {
    let bound = crate::scope::bound_names(term);
    crate::scope::read_names(term).into_iter().filter(|name| !bound.contains(name)).collect()
}

/// A law that would take one process to the other, were it not for these conditions.
#[derive(Clone, Debug)]
pub struct NearMiss {
    /// The law.
    pub law: Name,
    /// The conditions that the place does not meet.
    pub unmet: Vec<Condition>,
}

/// Laws of which one use, at any place of `from` and in either direction, gives `to`, but whose conditions are not met.
pub fn near_misses(theory: &Theory, context: &Context<'_>, laws: &[Name], from: &Term, to: &Term) -> Vec<NearMiss> {
    let never = || false;
    let wanted = Simplifier::new(theory, context, &never).cleaned(to).term;
    let mut found: Vec<NearMiss> = Vec::new();
    for law in theory.laws.iter().filter(|law| laws.is_empty() || laws.contains(&law.name)) {
        if law.conditions.is_empty() || found.iter().any(|miss| miss.law == law.name) {
            continue;
        }
        let free = Law { conditions: Vec::new(), ..(**law).clone() };
        for forward in [true, false] {
            let Some(unmet) = use_of(theory, context, law, &free, forward, from, &wanted) else { continue };
            found.push(NearMiss { law: law.name.clone(), unmet });
            break;
        }
        if found.len() >= MOST {
            break;
        }
    }
    found
}

fn use_of(
    theory: &Theory,
    context: &Context<'_>,
    law: &Law,
    free: &Law,
    forward: bool,
    from: &Term,
    wanted: &Term,
) -> Option<Vec<Condition>> {
    let never = || false;
    let (pattern, other) = if forward { (&free.left, &free.right) } else { (&free.right, &free.left) };
    for (place, around) in places(from) {
        for found in matches(free, pattern, &place, context) {
            let Ok(image) = found.substitution.apply(other, context) else { continue };
            let inner = surround(&found.surrounding, &image);
            let whole = fill(&around, &[(hole(1), inner)].into());
            if Simplifier::new(theory, context, &never).cleaned(&whole).term != *wanted {
                continue;
            }
            let instances = law.conditions.iter().filter_map(|one| found.substitution.condition(one, context).ok());
            let unmet: Vec<Condition> = instances.filter(|condition| !context.holds(condition)).collect();
            if !unmet.is_empty() {
                return Some(unmet);
            }
        }
    }
    None
}

/// The most places of a process that are looked at.
const MOST_PLACES: usize = 200;

/// Every part of a process with the rest around it, as a shape with the hole `?1`.
pub fn places(term: &Term) -> Vec<(Term, Term)> {
    let mut all = Vec::new();
    let mut open = vec![(term.clone(), Term::meta(&hole(1)))];
    while let Some((part, around)) = open.pop() {
        if all.len() >= MOST_PLACES {
            break;
        }
        let children: Vec<Term> = part.children().cloned().collect();
        for place in 0..children.len() {
            let mut shape = children.clone();
            shape[place] = Term::meta(&hole(1));
            let inner = fill(&around, &[(hole(1), part.with_children(shape))].into());
            open.push((children[place].clone(), inner));
        }
        all.push((part, around));
    }
    all
}

/// A condition in words: `?P never to abort`.
pub fn in_words(condition: &Condition) -> String {
    match condition {
        Condition::Is(fact, term) => {
            let what = match fact {
                Fact::NeverAborts => "never to abort",
                Fact::NeverStops => "never to stop",
                Fact::Silent => "not to communicate",
                Fact::DrawsNothing => "to draw nothing at random",
                Fact::BindsNothing => "to bind no result",
                Fact::Observer => "to be an observer",
                Fact::Guard => "to be a guard",
                Fact::NotStopped => "not to have stopped already",
                Fact::Running => "not to have ended already",
                Fact::Guarded => "not to stop at once",
                Fact::Immediate => "to stop at once",
                Fact::Still => "to do nothing before it has waited",
            };
            format!("{term} {what}")
        }
        Condition::Compare(relation, left, right) => format!("{left} {} {right}", relation.symbol()),
        Condition::Natural(value) => format!("{value} to be a natural number"),
        Condition::Lasts(term, time) => format!("{term} to take exactly {time}, in silence"),
        Condition::Complementary(one, two) => format!("exactly one of the guards {one} and {two} to hold"),
        Condition::NoPort(term, port) => format!("{term} not to use the port {port}"),
        Condition::Unread(term, name) => format!("{term} not to read {name}"),
        Condition::Apart(one, two) => format!("{one} to bind nothing that {two} uses"),
        Condition::ShowsOnly(..) | Condition::ShowsNone(..) => condition.to_string(),
    }
}
