//! Overlaps: processes that two laws rewrite differently, where simplification does not bring the results together.
//!
//! Critical pairs of laws written `=>`, where one law is used on a part of what the other is used on, or both on sequences
//! or lists of `|` and `#` that share some parts (`unify.rs` says what is made equal).

use std::collections::BTreeSet;

use super::unify::{Goal, lists, plain_meta, resolved, sequences, unify};
use super::warning;
use crate::diagnostic::{Diagnostic, Span};
use crate::fact::Context;
use crate::kernel::Theory;
use crate::law::{Condition, Connective, Fact, Law};
use crate::lower::Environment;
use crate::name::Name;
use crate::proof::{Statement, hole};
use crate::prove::{Answer, By, prove};
use crate::refute::{Limits, Refutation, refute};
use crate::remedy::places;
use crate::rewrite;
use crate::scope::{bound_names, condition_metavariables, fill, metavariables, subterms};
use crate::simplify::Simplifier;
use crate::substitution::Substitution;
use crate::term::{Node, Term};
use crate::value::Value;

/// The most findings for one law.
const MOST: usize = 12;
/// The most peaks of two laws that are looked at.
const MOST_PEAKS: usize = 60;
/// The most pairs of results of one law that are looked at beyond simplification.
const MOST_PAIRS: usize = 120;
/// The most law applications to bring two results together.
const FUEL: usize = 300;

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
        for ((way, peak), turned) in peaks.chain(back).take(MOST_PEAKS) {
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
        if condition_metavariables(&condition).is_empty() || hopeless(&condition, &plain) {
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

/// Whether a condition that does not hold of a process holds of no instance of it, as laws decide their conditions.
fn hopeless(condition: &Condition, context: &Context<'_>) -> bool {
    let meta = |term: &Term| matches!(term.node(), Node::Meta(..) | Node::Replace(..));
    match condition {
        Condition::Complementary(one, two) => {
            [one, two].into_iter().any(|term| !meta(term) && !matches!(term.node(), Node::Guard(..)))
        }
        Condition::Is(Fact::Guard | Fact::Observer | Fact::Silent | Fact::DrawsNothing | Fact::BindsNothing, term) => {
            !subterms(term).into_iter().any(meta)
        }
        Condition::Compare(relation, left, right) => context.assumptions.decide(*relation, left, right) == Some(false),
        _ => false,
    }
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

/// The peaks at which `law` is used on the whole and `other` on a part, and those at which they share parts of a list.
fn peaks(law: &Law, other: &Law, same: bool) -> Vec<(Substitution, Peak)> {
    let mut all = Vec::new();
    let results = results(law, other);
    for (part, around) in places(&law.left) {
        if matches!(part.node(), Node::Meta(..)) || (same && part == law.left) {
            continue;
        }
        let (term, first) = (&law.left, &law.right);
        let peak = |replaced: Term| {
            let second = fill(&around, &[(hole(1), replaced)].into());
            Peak { term: term.clone(), first: first.clone(), second }
        };
        for way in unify(vec![Goal::Terms(part.clone(), other.left.clone())], &results) {
            all.push((way, peak(other.right.clone())));
        }
        for (way, replaced) in inside(&part, other, &results) {
            all.push((way, peak(replaced)));
        }
    }
    match (law.left.node(), other.left.node()) {
        (Node::Seq(one), Node::Seq(two)) => chained(law, other, one, two, &results, &mut all),
        (Node::Par(_), Node::Par(_)) => sharing(law, other, Term::par, &results, &mut all),
        (Node::Disable(_), Node::Disable(_)) => sharing(law, other, Term::disable, &results, &mut all),
        _ => {}
    }
    all
}

/// What stands for the names of results in two laws.
fn results(law: &Law, other: &Law) -> BTreeSet<Name> {
    let sides = [&law.left, &law.right, &other.left, &other.right];
    sides.into_iter().flat_map(bound_names).filter(Name::is_meta).collect()
}

/// Uses of a law on some, not all, of the parts of a sequence or list, with what it becomes.
fn inside(part: &Term, law: &Law, results: &BTreeSet<Name>) -> Vec<(Substitution, Term)> {
    let mut all = Vec::new();
    match (part.node(), law.left.node()) {
        (Node::Seq(parts), Node::Seq(_)) => {
            for start in 0..parts.len() {
                for end in (start + 2..=parts.len()).filter(|end| end - start < parts.len()) {
                    let window = Term::seq(parts[start..end].iter().cloned());
                    let after = parts[end..].iter().cloned();
                    let replaced = parts[..start].iter().cloned().chain([law.right.clone()]).chain(after);
                    let replaced = Term::seq(replaced);
                    let ways = unify(vec![Goal::Terms(window, law.left.clone())], results).into_iter();
                    all.extend(ways.map(|way| (way, replaced.clone())));
                }
            }
        }
        (Node::Par(parts), Node::Par(_)) => within(parts, law, Term::par, results, &mut all),
        (Node::Disable(parts), Node::Disable(_)) => within(parts, law, Term::disable, results, &mut all),
        _ => {}
    }
    all
}

type Join = fn(Vec<Term>) -> Term;

fn within(parts: &[Term], law: &Law, join: Join, results: &BTreeSet<Name>, all: &mut Vec<(Substitution, Term)>) {
    let own: Vec<Term> = law.left.children().cloned().collect();
    let taken: BTreeSet<Name> = parts.iter().chain(&own).flat_map(metavariables).collect();
    let rest = fresh("?Y", &taken);
    let longer: Vec<Term> = own.iter().cloned().chain([rest.clone()]).collect();
    for goals in lists(parts, &longer, &taken, None, Some(own.len()), join) {
        let replaced = join(vec![law.right.clone(), rest.clone()]);
        all.extend(unify(goals, results).into_iter().map(|way| (way, replaced.clone())));
    }
}

/// A metavariable that is not among these.
fn fresh(text: &str, taken: &BTreeSet<Name>) -> Term {
    let mut name = Name::new(text);
    while taken.contains(&name) {
        name = Name::new(&format!("{name}1"));
    }
    Term::meta(&name)
}

/// `A ; B ; C`, where one law fits `A ; B` and the other `B ; C`.
fn chained(
    law: &Law,
    other: &Law,
    one: &[Term],
    two: &[Term],
    results: &BTreeSet<Name>,
    all: &mut Vec<(Substitution, Peak)>,
) {
    for (start, end) in (1..one.len()).flat_map(|start| (1..two.len()).map(move |end| (start, end))) {
        let ((before, tail), (head, after)) = (one.split_at(start), two.split_at(end));
        for goals in sequences(tail, head) {
            let solid = |goal: &Goal| matches!(goal, Goal::Terms(a, b) if plain_meta(a).or(plain_meta(b)).is_none());
            if !goals.iter().any(solid) {
                continue;
            }
            for way in unify(goals, results) {
                let term = Term::seq(one.iter().chain(after).cloned());
                let first = Term::seq([law.right.clone()].into_iter().chain(after.iter().cloned()));
                let second = Term::seq(before.iter().cloned().chain([other.right.clone()]));
                all.push((way, Peak { term, first, second }));
            }
        }
    }
}

/// Two uses beside each other in a list that share some of its parts, with whatever else stands there.
fn sharing(law: &Law, other: &Law, join: Join, results: &BTreeSet<Name>, all: &mut Vec<(Substitution, Peak)>) {
    let (one, two): (Vec<&Term>, Vec<&Term>) = (law.left.children().collect(), other.left.children().collect());
    let taken: BTreeSet<Name> = metavariables(&law.left).into_iter().chain(metavariables(&other.left)).collect();
    let (here, there) = (fresh("?X", &taken), fresh("?Y", &taken));
    let with =
        |parts: &[&Term], more: &Term| -> Vec<Term> { parts.iter().copied().cloned().chain([more.clone()]).collect() };
    let (a, b) = (with(&one, &here), with(&two, &there));
    for goals in lists(&a, &b, &taken, Some(one.len()), Some(two.len()), join) {
        for way in unify(goals, results) {
            let term = join(a.clone());
            let first = join(vec![law.right.clone(), here.clone()]);
            let second = join(vec![other.right.clone(), there.clone()]);
            all.push((way, Peak { term, first, second }));
        }
    }
}
