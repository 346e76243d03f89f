//! Simplification: the laws written `=>`, from left to right, until none applies; every answer with its proof.

use std::sync::Arc;

use crate::fact::Context;
use crate::kernel::Theory;
use crate::law::{Condition, Connective, Fact, Law, Laws};
use crate::matching::{Match, first_match, matches};
use crate::name::Name;
use crate::proof::{Script, Step, StepId, hole};
use crate::scope::changed;
use crate::substitution::Substitution;
use crate::term::{Node, Term, TermMap};

/// A term with the step that proves the original equal to it.
#[derive(Clone, Debug)]
pub struct Simplified {
    /// The simplest form found.
    pub term: Term,
    /// Proves `original = term`.
    pub step: StepId,
}

/// The simplifier: laws, context, and the proof under construction.
pub struct Simplifier<'a> {
    theory: &'a Theory,
    context: &'a Context<'a>,
    /// The steps so far.
    pub script: Script,
    memo: TermMap<Simplified>,
    oriented: Vec<Oriented>,
    /// The laws about units, and what [`Simplifier::cleaned`] has found with them; while it looks, they stand in the
    /// places of `oriented` and `memo`.
    units: Vec<Oriented>,
    cleaned: TermMap<Simplified>,
    cleaning: bool,
    fuel: usize,
    interrupted: &'a dyn Fn() -> bool,
}

/// The most law applications of one simplification.
pub const FUEL: usize = 200_000;

impl<'a> Simplifier<'a> {
    /// A simplifier over a theory. `interrupted` is asked at every step; once true, nothing more is rewritten.
    pub fn new(theory: &'a Theory, context: &'a Context<'a>, interrupted: &'a dyn Fn() -> bool) -> Simplifier<'a> {
        let wanted = |law: &&Arc<Law>| law.oriented && law.connective == Connective::Equal;
        let oriented = theory.laws.iter().filter(wanted).map(Oriented::of).collect();
        let units = theory.laws.iter().filter(|law| is_unit(law)).map(Oriented::of).collect();
        Simplifier {
            theory,
            context,
            script: Script::default(),
            memo: TermMap::default(),
            oriented,
            units,
            cleaned: TermMap::default(),
            cleaning: false,
            fuel: FUEL,
            interrupted,
        }
    }

    /// Uses these laws alone, besides those about units.
    pub fn only(mut self, laws: &[Name]) -> Simplifier<'a> {
        let named = |law: &Law| laws.contains(&law.name) || is_unit(law);
        let wanted = |law: &&Arc<Law>| named(law) && law.connective == Connective::Equal;
        self.oriented = self.theory.laws.iter().filter(wanted).map(Oriented::of).collect();
        self
    }

    /// Uses the laws of weak equality as well, from left to right; what it proves is `original ~~ term`.
    pub fn weakly(mut self, only: Option<&[Name]>) -> Simplifier<'a> {
        let named = |law: &Law| only.is_none_or(|names| names.contains(&law.name));
        let weak = self.theory.laws.iter().filter(|law| law.connective == Connective::Weak && named(law));
        self.oriented.extend(weak.map(Oriented::of));
        self
    }

    /// With at most this many law applications.
    pub fn with_fuel(mut self, fuel: usize) -> Simplifier<'a> {
        self.fuel = fuel;
        self
    }

    /// Allows this many law applications from here on.
    pub fn refuel(&mut self, fuel: usize) {
        self.fuel = fuel;
    }

    /// Where it looks for facts.
    pub fn context(&self) -> &'a Context<'a> {
        self.context
    }

    /// Whether it ended for want of fuel or by interruption rather than because nothing applied.
    pub fn exhausted(&self) -> bool {
        self.fuel == 0 || (self.interrupted)()
    }

    /// The simplest form of a term.
    pub fn simplify(&mut self, term: &Term) -> Simplified {
        if let Some(known) = self.memo.get(term) {
            return known.clone();
        }
        let start = self.script.push(Step::Reflexive(term.clone()));
        let mut chain = vec![start];
        let mut current = term.clone();
        loop {
            if let Some(next) = self.parts(&current) {
                chain.push(next.step);
                current = next.term;
            }
            let Some(next) = self.at_root(&current) else { break };
            chain.push(next.step);
            current = next.term;
            if let Some(known) = self.memo.get(&current) {
                chain.push(known.step);
                current = known.term.clone();
                break;
            }
        }
        let step = self.script.chain(chain);
        let found = Simplified { term: current.clone(), step };
        self.memo.insert(term.clone(), found.clone());
        if current != *term {
            let same = self.script.push(Step::Reflexive(current.clone()));
            self.memo.insert(current.clone(), Simplified { term: current, step: same });
        }
        found
    }

    /// Values under the assumptions, then each part; nothing if nothing changed.
    fn parts(&mut self, term: &Term) -> Option<Simplified> {
        if let Some(halves) = halves(term) {
            return self.two(term, &halves);
        }
        let valued = self.values(term);
        let term = valued.as_ref().map_or(term, |valued| &valued.term).clone();
        let mut shape = Vec::new();
        let mut steps = Vec::new();
        for part in term.children() {
            let simple = self.simplify(part);
            if simple.term == *part {
                shape.push(part.clone());
            } else {
                steps.push(simple.step);
                shape.push(Term::meta(&hole(steps.len())));
            }
        }
        if steps.is_empty() {
            return valued;
        }
        let parts: Vec<Term> = term
            .children()
            .map(|part| self.memo.get(part).map_or_else(|| part.clone(), |known| known.term.clone()))
            .collect();
        let result = term.with_children(parts);
        let step = self.script.push(Step::Congruence(term.with_children(shape), steps));
        let step = match valued {
            Some(valued) => self.script.chain(vec![valued.step, step]),
            None => step,
        };
        Some(Simplified { term: result, step })
    }

    /// A long sequence half by half: what collapses does so without the whole being built again for each law.
    fn two(&mut self, term: &Term, halves: &[Term; 2]) -> Option<Simplified> {
        let simple = [self.simplify(&halves[0]), self.simplify(&halves[1])];
        if simple[0].term == halves[0] && simple[1].term == halves[1] {
            return None;
        }
        let join = |one: Term, two: Term| match term.node() {
            Node::Par(_) => Term::par([one, two]),
            Node::Disable(_) => Term::disable([one, two]),
            _ => Term::seq([one, two]),
        };
        let shape = join(Term::meta(&hole(1)), Term::meta(&hole(2)));
        let step = self.script.push(Step::Congruence(shape, vec![simple[0].step, simple[1].step]));
        let [one, two] = simple;
        Some(Simplified { term: join(one.term, two.term), step })
    }

    fn values(&mut self, term: &Term) -> Option<Simplified> {
        let mut changed = false;
        let simple = term
            .map_values(&mut |value| {
                let known = &self.context.assumptions;
                let simple = known.simplify(&known.with_equations(value.clone()));
                changed |= simple != *value;
                Ok::<_, ()>(simple)
            })
            .ok()?;
        if !changed {
            return None;
        }
        let step = self.script.push(Step::Arithmetic(term.clone(), simple.clone()));
        Some(Simplified { term: simple, step })
    }

    /// One law at the root; nothing if none applies.
    fn at_root(&mut self, term: &Term) -> Option<Simplified> {
        if self.exhausted() {
            return None;
        }
        let kinds = kinds(term.children());
        for index in 0..self.oriented.len() {
            let Oriented { law, needs } = &self.oriented[index];
            if needs & !kinds != 0 || !may_apply(&law.left, term) {
                continue;
            }
            let law = law.clone();
            if let Some(found) = self.apply(&law, term) {
                self.fuel = self.fuel.saturating_sub(1);
                return Some(found);
            }
        }
        None
    }

    fn apply(&mut self, law: &Law, term: &Term) -> Option<Simplified> {
        let changes = |found: &Match| {
            let instance = found.substitution.apply(&law.right, self.context).ok()?;
            let result = surround(&found.surrounding, &instance);
            (result != *term && clean(&result) != *term).then_some(())
        };
        let mut found = first_match(law, &law.left, term, self.context)?;
        if changes(&found).is_none() {
            // Of several parts of a `|` another may be meant.
            let several = matches!(law.left.node(), Node::Seq(parts) if parts.iter().any(|part| matches!(part.node(), Node::Par(_))));
            let others = if several { matches(law, &law.left, term, self.context) } else { Vec::new() };
            found = others.into_iter().find(|found| changes(found).is_some())?;
        }
        self.instance(term, law, true, &found.substitution, &found.surrounding)
    }

    /// One law applied in a surrounding, forwards or backwards, with the proof. The term may differ from the
    /// instance by units.
    pub fn instance(
        &mut self,
        term: &Term,
        law: &Law,
        forward: bool,
        substitution: &Substitution,
        surrounding: &Term,
    ) -> Option<Simplified> {
        let left = substitution.apply(&law.left, self.context).ok()?;
        let right = substitution.apply(&law.right, self.context).ok()?;
        let (from, to) = if forward { (left, right) } else { (right, left) };
        let whole = surround(surrounding, &from);
        let mut chain = Vec::new();
        if whole != *term {
            let (there, back) = (self.cleaned(term), self.cleaned(&whole));
            if there.term != back.term {
                return None;
            }
            chain.push(there.step);
            chain.push(self.script.push(Step::Symmetric(back.step)));
        }
        let mut step = self.script.push(Step::Law(law.name.clone(), substitution.clone()));
        if !forward {
            step = self.script.push(Step::Symmetric(step));
        }
        if *surrounding != Term::meta(&hole(1)) {
            step = self.script.push(Step::Congruence(surrounding.clone(), vec![step]));
        }
        chain.push(step);
        let step = self.script.chain(chain);
        Some(Simplified { term: surround(surrounding, &to), step })
    }

    /// The term without units, proved by the laws that say so.
    pub fn cleaned(&mut self, term: &Term) -> Simplified {
        if self.cleaning {
            return self.simplify(term);
        }
        let fuel = std::mem::replace(&mut self.fuel, FUEL);
        self.turn_over();
        let found = self.simplify(term);
        self.turn_over();
        self.fuel = fuel;
        found
    }

    /// Goes over to the laws about units alone, or back.
    fn turn_over(&mut self) {
        std::mem::swap(&mut self.oriented, &mut self.units);
        std::mem::swap(&mut self.memo, &mut self.cleaned);
        self.cleaning = !self.cleaning;
    }
}

/// A law with the kinds of parts without which it cannot apply, as a set of bits.
struct Oriented {
    law: Arc<Law>,
    needs: u64,
}

/// Marks the kinds of what stands in a part that is a `;` or `#`, or is the part.
const INSIDE: u32 = 32;

/// Marks a part that begins as a guard may.
const GUARD: u32 = 31;

impl Oriented {
    fn of(law: &Arc<Law>) -> Oriented {
        let needs = match law.left.node() {
            Node::Seq(_) | Node::Par(_) | Node::Disable(_) => {
                law.left.children().fold(0, |all, part| all | needed(part, law))
            }
            _ => 0,
        };
        Oriented { law: law.clone(), needs }
    }
}

/// The kinds without which a part of a pattern fits nothing.
fn needed(pattern: &Term, law: &Law) -> u64 {
    let mut inner = match pattern.node() {
        Node::Seq(_) | Node::Disable(_) => pattern.children(),
        Node::Meta(..) => return if wants_guard(law, pattern) { 1 << GUARD } else { 0 },
        _ => return 1 << kind(pattern),
    };
    let solid = inner.clone().filter(|part| !matches!(part.node(), Node::Meta(..) | Node::Seq(_) | Node::Disable(_)));
    let needs = solid.fold(0, |all, part| all | 1 << (INSIDE + kind(part)));
    let first = matches!(pattern.node(), Node::Seq(_)).then(|| inner.next()).flatten();
    if first.is_some_and(|first| wants_guard(law, first)) { needs | 1 << GUARD } else { needs }
}

fn wants_guard(law: &Law, meta: &Term) -> bool {
    law.conditions.iter().any(|condition| names_guard(condition, meta))
}

fn names_guard(condition: &Condition, meta: &Term) -> bool {
    match condition {
        Condition::Complementary(one, two) => one == meta || two == meta,
        Condition::Is(Fact::Guard, one) => one == meta,
        _ => false,
    }
}

/// The kinds of these parts of a term.
fn kinds<'t>(parts: impl IntoIterator<Item = &'t Term>) -> u64 {
    let begins = |part: &Term| u64::from(matches!(part.node(), Node::Guard(..) | Node::Meta(..) | Node::Replace(..)));
    parts.into_iter().fold(0, |all, part| {
        let own = 1 << kind(part) | 1 << (INSIDE + kind(part)) | begins(part) << GUARD;
        let inner: u64 = match part.node() {
            Node::Seq(inner) => inner.first().map_or(0, begins) << GUARD | insides(inner),
            Node::Disable(inner) => insides(inner),
            _ => 0,
        };
        all | own | inner
    })
}

fn insides(parts: &[Term]) -> u64 {
    parts.iter().fold(0, |all, part| all | 1 << (INSIDE + kind(part)))
}

fn kind(term: &Term) -> u32 {
    match term.node() {
        Node::Stop => 0,
        Node::Abort => 1,
        Node::Idle => 2,
        Node::Delay(_) => 3,
        Node::In(..) => 4,
        Node::Out(..) => 5,
        Node::Guard(..) => 6,
        Node::Set(..) => 7,
        Node::Ran(..) => 8,
        Node::Observe(..) => 9,
        Node::Call(..) => 10,
        Node::Meta(..) => 11,
        Node::Seq(_) => 12,
        Node::Else(..) => 13,
        Node::Par(_) => 14,
        Node::Disable(_) => 15,
        Node::Power(..) => 16,
        Node::Loop(_) => 17,
        Node::New(..) => 18,
        Node::Project(..) => 19,
        Node::Replace(..) => 20,
    }
}

/// The two halves of a long list of parts; nothing for a short one.
fn halves(term: &Term) -> Option<[Term; 2]> {
    type Join = fn(Vec<Term>) -> Term;
    let (parts, join): (&[Term], Join) = match term.node() {
        Node::Seq(parts) => (parts, Term::seq),
        Node::Par(parts) => (parts, Term::par),
        Node::Disable(parts) => (parts, Term::disable),
        _ => return None,
    };
    (parts.len() > LONG).then(|| {
        let (one, two) = parts.split_at(parts.len() / 2);
        [join(one.to_vec()), join(two.to_vec())]
    })
}

/// From this many parts on a list is simplified half by half.
const LONG: usize = 8;

/// A law `P op unit = P`: `P ; Stop`, `Stop ; P`, `P # Idle`, `P | Abort`.
pub fn is_unit(law: &Law) -> bool {
    let two = || {
        let mut both = law.left.children();
        both.len() == 2
            && both.clone().any(|part| *part == law.right)
            && both.any(|part| matches!(part.node(), Node::Stop | Node::Idle | Node::Abort))
    };
    let plain = matches!(law.right.node(), Node::Meta(_, arguments) if arguments.is_empty());
    let shape = match law.left.node() {
        Node::Seq(_) | Node::Par(_) | Node::Disable(_) => two(),
        _ => false,
    };
    plain && shape && law.conditions.is_empty() && law.connective == Connective::Equal
}

/// These laws alone, besides those about units; all when none is named.
pub fn alone(laws: &Laws, names: &[Name]) -> Laws {
    let mut kept = Laws::default();
    for law in laws.iter().filter(|law| names.is_empty() || names.contains(&law.name) || is_unit(law)) {
        kept.push((**law).clone());
    }
    kept
}

/// The term without units.
pub fn clean(term: &Term) -> Term {
    cleaner(term).unwrap_or_else(|| term.clone())
}

/// The term without units; nothing if it has none.
fn cleaner(term: &Term) -> Option<Term> {
    let new = changed(term, &mut cleaner);
    let current = new.as_ref().unwrap_or(term);
    let is_unit = |part: &Term| {
        let pair = (current.node(), part.node());
        matches!(pair, (Node::Seq(_), Node::Stop) | (Node::Par(_), Node::Abort) | (Node::Disable(_), Node::Idle))
    };
    if !current.children().into_iter().any(is_unit) {
        return new;
    }
    let kept = current.children().filter(|part| !is_unit(part)).cloned();
    Some(match current.node() {
        Node::Seq(_) => Term::seq(kept),
        Node::Par(_) => Term::par(kept),
        _ => Term::disable(kept),
    })
}

/// A surrounding with its hole filled.
pub fn surround(surrounding: &Term, inner: &Term) -> Term {
    let holes = std::collections::BTreeMap::from([(hole(1), inner.clone())]);
    crate::scope::fill(surrounding, &holes)
}

/// A quick look at the outermost operators, before the parts are looked at.
fn may_apply(pattern: &Term, term: &Term) -> bool {
    match (pattern.node(), term.node()) {
        (Node::Meta(..), _) => true,
        (Node::Seq(_), _) => matches!(term.node(), Node::Seq(_)),
        (wanted, given) => std::mem::discriminant(wanted) == std::mem::discriminant(given),
    }
}
