//! Overlaps: processes that two laws rewrite differently, where simplification does not bring the results together.
//!
//! Critical pairs of laws written `=>`. Sides are unified part by part: sequences of one length, or where a metavariable at
//! an end takes the rest; parts of `|` and `#` in every order, up to three. Overlaps of other kinds are not looked for.

use std::collections::BTreeSet;

use super::warning;
use crate::diagnostic::{Diagnostic, Span};
use crate::fact::Context;
use crate::kernel::Theory;
use crate::law::{Condition, Connective, Law};
use crate::lower::Environment;
use crate::name::Name;
use crate::proof::{Statement, hole};
use crate::prove::{Answer, By, prove};
use crate::refute::{Limits, Refutation, refute};
use crate::remedy::places;
use crate::rewrite;
use crate::scope::{condition_metavariables, fill, metavariables};
use crate::simplify::Simplifier;
use crate::substitution::Substitution;
use crate::term::{Node, Term};
use crate::value::Value;

/// The most findings for one law.
const MOST: usize = 2;
/// The most ways in which two sides are unified.
const MOST_WAYS: usize = 8;
/// The most pairs of results of one law that are looked at beyond simplification.
const MOST_PAIRS: usize = 12;
/// The most law applications to bring two results together.
const FUEL: usize = 300;
/// The most steps of one unification.
const MOST_STEPS: usize = 2_000;

/// A process that two laws rewrite, and what they make of it.
struct Peak {
    term: Term,
    first: Term,
    second: Term,
}

/// The overlaps of a law with those that simplification uses, itself among them.
pub(super) fn findings(
    law: &Law,
    span: Span,
    theory: &Theory,
    environment: &Environment,
    interrupted: &dyn Fn() -> bool,
) -> Vec<Diagnostic> {
    let mut all = Vec::new();
    let mut left = MOST_PAIRS;
    if !law.oriented || law.connective != Connective::Equal {
        return all;
    }
    for other in theory.laws.iter().filter(|other| other.oriented && other.connective == Connective::Equal) {
        if all.len() >= MOST || left == 0 || interrupted() {
            break;
        }
        let apart = renamed(other, &metavariables(&law.left));
        let peaks = peaks(law, &apart, other.name == law.name).into_iter().map(|peak| (peak, false));
        let back = if other.name == law.name { Vec::new() } else { self::peaks(&apart, law, false) };
        let back = back.into_iter().map(|peak| (peak, true));
        for ((way, peak), turned) in peaks.chain(back) {
            let (first, second) = if turned { (&peak.second, &peak.first) } else { (&peak.first, &peak.second) };
            let conditions: Vec<&Condition> = law.conditions.iter().chain(&apart.conditions).collect();
            let found =
                parted(&way, &conditions, (&peak.term, first, second), theory, environment, &mut left, interrupted);
            if let Some((hypotheses, forms, equal)) = found {
                let pair = Pair { law, other, term: &peak.term, hypotheses, forms, equal };
                all.push(pair.finding(&way, theory, span));
                break;
            }
        }
    }
    all
}

struct Pair<'a> {
    law: &'a Law,
    other: &'a Law,
    term: &'a Term,
    hypotheses: Vec<Condition>,
    forms: (Term, Term),
    equal: bool,
}

impl Pair<'_> {
    fn finding(&self, way: &Substitution, theory: &Theory, span: Span) -> Diagnostic {
        let context = Context::new(&theory.assumptions, &theory.definitions, &[]);
        let term = resolved(way, self.term, &context).unwrap_or_else(|| self.term.clone());
        let (law, other) = (&self.law.name, &self.other.name);
        let message = match law == other {
            true => {
                format!("the law `{law}` rewrites one process in two ways that simplification does not bring together")
            }
            false => format!(
                "the laws `{law}` and `{other}` overlap, and simplification does not bring their results together"
            ),
        };
        let mut finding = warning("P0923", message, span).note(format!("both fit {term}"));
        if !self.hypotheses.is_empty() {
            let when: Vec<String> = self.hypotheses.iter().map(ToString::to_string).collect();
            finding = finding.note(format!("when {}", when.join(", ")));
        }
        finding = finding.note(format!("by `{law}` it becomes {}", self.forms.0));
        finding = finding.note(format!("by `{other}` it becomes {}", self.forms.1));
        finding.help(if self.equal {
            "the two are equal, but only a search finds it: a law that turns one into the other would help"
        } else {
            "no proof was found that the two are equal: a law may be missing"
        })
    }
}

/// The conditions under which a peak is there, and its two forms, if simplification leaves them apart; and whether a
/// search proves them equal.
#[allow(clippy::type_complexity, clippy::too_many_arguments)]
fn parted(
    way: &Substitution,
    conditions: &[&Condition],
    (term, first, second): (&Term, &Term, &Term),
    theory: &Theory,
    environment: &Environment,
    left: &mut usize,
    interrupted: &dyn Fn() -> bool,
) -> Option<(Vec<Condition>, (Term, Term), bool)> {
    let plain = Context::new(&theory.assumptions, &theory.definitions, &[]);
    let image = |term: &Term| resolved(way, term, &plain);
    let (whole, first, second) = (image(term)?, image(first)?, image(second)?);
    if first == second || whole == first || whole == second {
        return None;
    }
    let mut hypotheses = Vec::new();
    for condition in conditions {
        let mut condition = (*condition).clone();
        for _ in 0..10 {
            condition = way.condition(&condition, &plain).ok()?;
        }
        if plain.holds(&condition) {
            continue;
        }
        if condition_metavariables(&condition).is_empty() {
            return None;
        }
        if !hypotheses.contains(&condition) {
            hypotheses.push(condition);
        }
    }
    let context = Context::new(&theory.assumptions, &theory.definitions, &hypotheses);
    let mut simplifier = Simplifier::new(theory, &context, interrupted).with_fuel(FUEL);
    let forms = (simplifier.simplify(&first).term, simplifier.simplify(&second).term);
    if forms.0 == forms.1 || simplifier.exhausted() || *left == 0 {
        return None;
    }
    *left -= 1;
    // Conditions that nothing meets make a peak that is not there.
    let limits = Limits { instances: 100, choices: 5_000, cost: 6, ..Limits::default() };
    let (definitions, assumptions) = (&environment.definitions, &environment.assumptions);
    let tried = refute(&first, &second, Connective::Equal, &hypotheses, definitions, assumptions, &limits);
    if matches!(tried, Refutation::None { instances, meaningless, .. } if instances == meaningless) {
        return None;
    }
    let (one, two) = forms.clone();
    let statement = Statement { hypotheses: hypotheses.clone(), left: one, connective: Connective::Equal, right: two };
    let limits = rewrite::Limits { rounds: 2, nodes: 500, ..rewrite::Limits::default() };
    let equal = matches!(prove(theory, &statement, &By::Search, limits, interrupted), Answer::Proved(..));
    Some((hypotheses, forms, equal))
}

/// The law with metavariables that are not among these.
fn renamed(law: &Law, taken: &BTreeSet<Name>) -> Law {
    let mut own = metavariables(&law.left);
    own.extend(law.conditions.iter().flat_map(condition_metavariables));
    let mut renaming = Substitution::default();
    for name in &own {
        let mut fresh = Name::new(&format!("{name}1"));
        while taken.contains(&fresh) || own.contains(&fresh) {
            fresh = Name::new(&format!("{fresh}1"));
        }
        renaming.processes.insert(name.clone(), Term::meta(&fresh));
        renaming.values.insert(name.clone(), Value::variable(&fresh));
        renaming.names.insert(name.clone(), fresh.clone());
        renaming.sets.insert(name.clone(), [fresh].into());
    }
    let (assumptions, definitions) = Default::default();
    let context = Context::new(&assumptions, &definitions, &[]);
    let image = |term: &Term| renaming.apply(term, &context).unwrap_or_else(|_| term.clone());
    let conditions =
        law.conditions.iter().map(|one| renaming.condition(one, &context).unwrap_or_else(|_| one.clone())).collect();
    Law { left: image(&law.left), right: image(&law.right), conditions, ..law.clone() }
}

fn plain_meta(term: &Term) -> Option<&Name> {
    match term.node() {
        Node::Meta(name, arguments) if arguments.is_empty() => Some(name),
        _ => None,
    }
}

/// The peaks at which `law` is used on the whole and `other` on a part, and those at which they share parts of a list.
fn peaks(law: &Law, other: &Law, same: bool) -> Vec<(Substitution, Peak)> {
    let mut all = Vec::new();
    for (part, around) in places(&law.left) {
        if matches!(part.node(), Node::Meta(..)) || (same && part == law.left) {
            continue;
        }
        let second = fill(&around, &[(hole(1), other.right.clone())].into());
        for way in unify(vec![Goal::Terms(part.clone(), other.left.clone())]) {
            let (term, first) = (law.left.clone(), law.right.clone());
            all.push((way, Peak { term, first, second: second.clone() }));
        }
    }
    match (law.left.node(), other.left.node()) {
        (Node::Seq(one), Node::Seq(two)) => chained(law, other, one, two, &mut all),
        (Node::Par(one), Node::Par(two)) => sharing(law, other, one, two, Term::par, &mut all),
        (Node::Disable(one), Node::Disable(two)) => sharing(law, other, one, two, Term::disable, &mut all),
        _ => {}
    }
    all
}

/// `A ; B ; C`, where one law fits `A ; B` and the other `B ; C`.
fn chained(law: &Law, other: &Law, one: &[Term], two: &[Term], all: &mut Vec<(Substitution, Peak)>) {
    for shared in 1..one.len().min(two.len()) {
        let (before, tail) = one.split_at(one.len() - shared);
        let (head, after) = two.split_at(shared);
        let solid = tail.iter().zip(head).any(|(a, b)| plain_meta(a).is_none() && plain_meta(b).is_none());
        if !solid {
            continue;
        }
        let goals = tail.iter().zip(head).map(|(a, b)| Goal::Terms(a.clone(), b.clone())).collect();
        for way in unify(goals) {
            let term = Term::seq(one.iter().chain(after).cloned());
            let first = Term::seq([law.right.clone()].into_iter().chain(after.iter().cloned()));
            let second = Term::seq(before.iter().cloned().chain([other.right.clone()]));
            all.push((way, Peak { term, first, second }));
        }
    }
}

/// Two uses beside each other that share one part.
fn sharing(
    law: &Law,
    other: &Law,
    one: &[Term],
    two: &[Term],
    join: fn(Vec<Term>) -> Term,
    all: &mut Vec<(Substitution, Peak)>,
) {
    for (here, a) in one.iter().enumerate() {
        for (there, b) in two.iter().enumerate() {
            if plain_meta(a).is_some() || plain_meta(b).is_some() {
                continue;
            }
            let rest = |parts: &[Term], place: usize| {
                parts
                    .iter()
                    .enumerate()
                    .filter(move |(at, _)| *at != place)
                    .map(|(_, part)| part.clone())
                    .collect::<Vec<_>>()
            };
            for way in unify(vec![Goal::Terms(a.clone(), b.clone())]) {
                let term = join(one.iter().cloned().chain(rest(two, there)).collect());
                let first = join([law.right.clone()].into_iter().chain(rest(two, there)).collect());
                let second = join([other.right.clone()].into_iter().chain(rest(one, here)).collect());
                all.push((way, Peak { term, first, second }));
            }
        }
    }
}

/// Two things to be made equal.
#[derive(Clone)]
enum Goal {
    Terms(Term, Term),
    Values(Value, Value),
    Names(Name, Name),
}

/// Substitutions that make all goals equal, to be applied again and again; at most [`MOST_WAYS`].
fn unify(goals: Vec<Goal>) -> Vec<Substitution> {
    let mut ways = Vec::new();
    let mut open = vec![(goals, Substitution::default())];
    for _ in 0..MOST_STEPS {
        let Some((mut goals, way)) = open.pop() else { break };
        let Some(goal) = goals.pop() else {
            ways.push(way);
            if ways.len() >= MOST_WAYS {
                break;
            }
            continue;
        };
        let next = match goal {
            Goal::Terms(one, two) => terms(&one, &two, way),
            Goal::Values(one, two) => values(&one, &two, way).into_iter().map(|way| (Vec::new(), way)).collect(),
            Goal::Names(one, two) => names(&one, &two, way).into_iter().map(|way| (Vec::new(), way)).collect(),
        };
        for (more, way) in next {
            open.push((goals.iter().cloned().chain(more).collect(), way));
        }
    }
    ways
}

type Branches = Vec<(Vec<Goal>, Substitution)>;

fn terms(one: &Term, two: &Term, way: Substitution) -> Branches {
    let (one, two) = (followed(one, &way), followed(two, &way));
    if one == two {
        return vec![(Vec::new(), way)];
    }
    for (meta, image) in [(&one, &two), (&two, &one)] {
        if let Some(name) = plain_meta(meta) {
            let (assumptions, definitions) = Default::default();
            let context = Context::new(&assumptions, &definitions, &[]);
            let Some(image) = resolved(&way, image, &context) else { return Vec::new() };
            if metavariables(&image).contains(name) {
                return Vec::new();
            }
            let mut way = way;
            way.processes.insert(name.clone(), image);
            return vec![(Vec::new(), way)];
        }
    }
    let pairs = |one: &[Term], two: &[Term]| -> Vec<Goal> {
        one.iter().zip(two).map(|(a, b)| Goal::Terms(a.clone(), b.clone())).collect()
    };
    match (one.node(), two.node()) {
        (Node::Seq(a), Node::Seq(b)) => sequences(a, b).into_iter().map(|goals| (goals, way.clone())).collect(),
        (Node::Par(a), Node::Par(b)) | (Node::Disable(a), Node::Disable(b)) if a.len() == b.len() && a.len() <= 3 => {
            orders(b).iter().map(|b| (pairs(a, b), way.clone())).collect()
        }
        _ => match heads(&one, &two) {
            Some(goals) => vec![(goals, way)],
            None => Vec::new(),
        },
    }
}

/// What a bound metavariable stands for.
fn followed(term: &Term, way: &Substitution) -> Term {
    let mut term = term.clone();
    while let Some(image) = plain_meta(&term).and_then(|name| way.processes.get(name)) {
        term = image.clone();
    }
    term
}

fn sequences(one: &[Term], two: &[Term]) -> Vec<Vec<Goal>> {
    let pairs = |one: &[Term], two: &[Term]| -> Vec<Goal> {
        one.iter().zip(two).map(|(a, b)| Goal::Terms(a.clone(), b.clone())).collect()
    };
    if one.len() == two.len() {
        return vec![pairs(one, two)];
    }
    let (short, long) = if one.len() < two.len() { (one, two) } else { (two, one) };
    let mut all = Vec::new();
    let more = long.len() - short.len();
    if let Some((last, start)) = short.split_last()
        && plain_meta(last).is_some()
    {
        let mut goals = pairs(start, long);
        goals.push(Goal::Terms(last.clone(), Term::seq(long.iter().skip(start.len()).cloned())));
        all.push(goals);
    }
    if let Some((first, rest)) = short.split_first()
        && plain_meta(first).is_some()
    {
        let (head, tail) = long.split_at(more + 1);
        let mut goals = pairs(rest, tail);
        goals.push(Goal::Terms(first.clone(), Term::seq(head.iter().cloned())));
        all.push(goals);
    }
    all
}

/// All orders of up to three parts.
fn orders(parts: &[Term]) -> Vec<Vec<Term>> {
    match parts {
        [a, b] => vec![vec![a.clone(), b.clone()], vec![b.clone(), a.clone()]],
        [a, b, c] => [[a, b, c], [a, c, b], [b, a, c], [b, c, a], [c, a, b], [c, b, a]]
            .map(|order| order.into_iter().cloned().collect())
            .to_vec(),
        _ => vec![parts.to_vec()],
    }
}

/// What must be equal for two operators of one kind to be; none where they are of different kinds.
fn heads(one: &Term, two: &Term) -> Option<Vec<Goal>> {
    let mut goals = Vec::new();
    let mut name = |a: &Name, b: &Name| goals.push(Goal::Names(a.clone(), b.clone()));
    match (one.node(), two.node()) {
        (Node::In(a, b), Node::In(c, d)) => {
            name(a, c);
            name(b, d);
        }
        (Node::Out(a, _), Node::Out(b, _)) | (Node::New(a, _), Node::New(b, _)) => name(a, b),
        (Node::Set(_, a), Node::Set(_, b)) | (Node::Ran(_, a), Node::Ran(_, b)) => name(a, b),
        (Node::Guard(a, ..), Node::Guard(b, ..)) if a != b => return None,
        (Node::Observe(a, _), Node::Observe(b, _)) | (Node::Call(a, _), Node::Call(b, _)) if a != b => return None,
        (Node::Power(_, _, None), Node::Power(_, _, None)) => {}
        (Node::Power(..) | Node::Project(..) | Node::Replace(..) | Node::Meta(..), _) => return None,
        (a, b) if std::mem::discriminant(a) != std::mem::discriminant(b) => return None,
        _ => {}
    }
    let (a, b) = (one.values(), two.values());
    let (c, d) = (one.children(), two.children());
    if a.len() != b.len() || c.len() != d.len() {
        return None;
    }
    goals.extend(a.into_iter().zip(b).map(|(a, b)| Goal::Values(a.clone(), b.clone())));
    goals.extend(c.into_iter().zip(d).map(|(c, d)| Goal::Terms(c.clone(), d.clone())));
    Some(goals)
}

fn values(one: &Value, two: &Value, mut way: Substitution) -> Option<Substitution> {
    let (mut one, mut two) = (one.clone(), two.clone());
    for _ in 0..10 {
        (one, two) = (way.value(&one).ok()?, way.value(&two).ok()?);
    }
    if one == two {
        return Some(way);
    }
    for (meta, image) in [(&one, &two), (&two, &one)] {
        if let Some(name) = meta.as_variable().filter(|name| name.is_meta() && !image.mentions(name)) {
            way.values.insert(name.clone(), image.clone());
            return Some(way);
        }
    }
    None
}

fn names(one: &Name, two: &Name, mut way: Substitution) -> Option<Substitution> {
    let follow = |name: &Name| {
        let mut name = name.clone();
        while let Some(image) = way.names.get(&name) {
            name = image.clone();
        }
        name
    };
    let (one, two) = (follow(one), follow(two));
    if one == two {
        return Some(way);
    }
    let (meta, image) = if one.is_meta() { (one, two) } else { (two, one) };
    meta.is_meta().then(|| {
        way.names.insert(meta, image);
        way
    })
}

/// The image of a term when the substitution has been applied until nothing changes.
fn resolved(way: &Substitution, term: &Term, context: &Context<'_>) -> Option<Term> {
    let mut term = term.clone();
    for _ in 0..20 {
        let next = way.apply(&term, context).ok()?;
        if next == term {
            return Some(next);
        }
        term = next;
    }
    None
}
