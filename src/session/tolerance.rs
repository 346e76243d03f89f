//! A tolerance for a phase that never ends since two values never come to be equal. It is tried on the mission, and
//! advised only where the claim is proved with it.

use std::collections::BTreeSet;

use num_rational::BigRational;

use super::claim::Found;
use super::reading::Run;
use crate::definition::Definition;
use crate::lower::{Environment, Property, System};
use crate::name::Name;
use crate::report::Verdict;
use crate::scope::subterms;
use crate::term::{Node, Term};
use crate::value::{Relation, Sort, Value};
use crate::verify::{self, Endless, Outcome};

/// Missions that are tried.
const MOST_TRIED: usize = 8;
/// The largest process that is changed, in operators.
const MOST_TERM: usize = 2_000;

/// An inequality of the mission: the process it stands in, with its sides.
struct Place<'e> {
    definition: &'e Definition,
    guard: Term,
}

impl Run<'_, '_> {
    /// Says what keeps a phase going for ever, and with which tolerance the claim is proved, if there is one.
    pub(super) fn tolerances(
        &mut self,
        system: &System,
        property: &Property,
        outcome: &Outcome,
        environment: &Environment,
        found: &mut Found,
    ) {
        let (Some(endless), Some(body)) = (&outcome.endless, &property.body) else { return };
        let (phase, kept) = (endless.phase + 1, &endless.kept);
        let never = format!("phase {phase} never ends, since no round comes to {} = {} exactly", kept.left, kept.right);
        let mut tried = 0;
        for place in places(system, environment) {
            for tolerance in candidates(endless) {
                let Some((guard, changed)) = place.with(&tolerance) else { continue };
                let mut varied = environment.clone();
                varied.definitions.insert(changed);
                let said = format!("{guard} in place of {} in {}", place.guard, place.definition.name);
                let near = nearby(body, &tolerance);
                let bodies = std::iter::once((body.clone(), String::new())).chain(near);
                for (body, asked) in bodies {
                    if tried == MOST_TRIED || self.surroundings.interrupted() {
                        break;
                    }
                    tried += 1;
                    let property = Property { body: Some(body), ..property.clone() };
                    if self.holds(system, &property, &varied) {
                        found.feedback.push(format!("{never}: with {said}{asked} it is proved"));
                        return;
                    }
                }
            }
        }
        found.trace.push(format!("note: {never}"));
    }

    /// Whether the claim is proved, as any claim is.
    fn holds(&mut self, system: &System, property: &Property, environment: &Environment) -> bool {
        let Some(body) = &property.body else { return false };
        let interrupted = || self.surroundings.interrupted();
        let (definitions, assumptions) = (&environment.definitions, &environment.assumptions);
        let asked = (&property.name, body);
        let outcome = verify::verify(&system.components, asked, definitions, assumptions, &interrupted);
        let mut found = Found::default();
        if matches!(outcome.verdict, verify::Verdict::Proved) {
            self.matched(system, &outcome, environment, &mut found);
        }
        found.verdict == Some(Verdict::Proved)
    }
}

/// The inequalities of numbers and of vectors in the processes that a system calls.
fn places<'e>(system: &System, environment: &'e Environment) -> Vec<Place<'e>> {
    let mut open: Vec<&Term> = system.components.iter().collect();
    let mut seen: BTreeSet<&Name> = BTreeSet::new();
    let mut found = Vec::new();
    while let Some(term) = open.pop() {
        for part in subterms(term) {
            let Node::Call(name, _) = part.node() else { continue };
            let Some(definition) = environment.definitions.get(name) else { continue };
            if !seen.insert(&definition.name) || definition.body.size() > MOST_TERM {
                continue;
            }
            let guards = subterms(&definition.body);
            let guards = guards.filter(|part| matches!(part.node(), Node::Guard(Relation::Neq, ..)));
            let guards: BTreeSet<Term> = guards.cloned().collect();
            found.extend(guards.into_iter().map(|guard| Place { definition, guard }));
            open.push(&definition.body);
        }
    }
    found
}

impl Place<'_> {
    /// The comparison with a tolerance, and the definition with it.
    fn with(&self, tolerance: &BigRational) -> Option<(Term, Definition)> {
        let Node::Guard(_, left, right) = self.guard.node() else { return None };
        let gap = left.sub(right).ok()?;
        let distance = if matches!(gap.sort(), Sort::Vector(_)) { gap.norm() } else { gap.abs() }.ok()?;
        let guard = Term::new(Node::Guard(Relation::Gtr, distance, Value::rational(tolerance.clone())));
        let body = replaced(&self.definition.body, &self.guard, &guard);
        Some((guard, Definition { body, ..self.definition.clone() }))
    }
}

/// A term of bounded size with one part in place of another.
fn replaced(term: &Term, from: &Term, to: &Term) -> Term {
    if term == from {
        return to.clone();
    }
    let parts = term.children();
    if parts.is_empty() {
        return term.clone();
    }
    term.with_children(parts.into_iter().map(|part| replaced(part, from, to)).collect())
}

/// Tolerances to try: a tenth, and as close as the run comes, where that is closer than it begins.
fn candidates(endless: &Endless) -> Vec<BigRational> {
    let tenth = BigRational::new(1.into(), 10.into());
    let mut all = vec![tenth];
    if let (Some(closest), Some(first)) = (&endless.closest, &endless.first)
        && closest < first
        && !all.contains(closest)
    {
        all.push(closest.clone());
    }
    all
}

/// A property that asks for what is near in place of what is shown, with how it is said.
fn nearby(body: &Term, tolerance: &BigRational) -> Option<(Term, String)> {
    if body.size() > MOST_TERM {
        return None;
    }
    if let Node::Loop(body) = body.node() {
        let (body, said) = nearby(body, tolerance)?;
        return Some((Term::new(Node::Loop(body)), said));
    }
    let Node::Seq(parts) = body.node() else { return None };
    let taken: BTreeSet<Name> = subterms(body).flat_map(Term::values).flat_map(Value::variables).collect();
    let mut fresh = (0usize..)
        .map(|number| Name::new(&if number == 0 { "?x".to_string() } else { format!("?x{number}") }))
        .filter(|name| !taken.contains(name));
    let (mut all, mut said) = (Vec::new(), Vec::new());
    for part in parts {
        let observer = subterms(part)
            .into_iter()
            .find(|part| matches!(part.node(), Node::Observe(_, values) if values.len() == 1));
        let (Some(observer), Node::Disable(_)) = (observer, part.node()) else {
            all.push(part.clone());
            continue;
        };
        let Node::Observe(name, values) = observer.node() else { continue };
        let (wanted, unknown) = (values.first()?, Value::variable(&fresh.next()?));
        if wanted.variables().iter().any(Name::is_meta) || matches!(wanted.sort(), Sort::Vector(_)) {
            all.push(part.clone());
            continue;
        }
        let near = Term::new(Node::Observe(name.clone(), vec![unknown.clone()]));
        let distance = unknown.sub(wanted).ok()?.abs().ok()?;
        let test = Term::new(Node::Guard(Relation::Lte, distance, Value::rational(tolerance.clone())));
        let segment = replaced(part, observer, &near);
        said.push(format!("{segment} ; {test} in place of {part}"));
        all.extend([segment, test]);
    }
    let said = said.iter().map(|one| format!(", and {one}")).collect();
    (all.len() > parts.len()).then(|| (Term::seq(all), said))
}
