//! Equality saturation: the only module that knows egg. It finds; the kernel decides.
//!
//! `|`, `#` and `;` are n-ary e-nodes. No associativity or commutativity rule ever runs: terms are flattened and
//! sorted when they are made, and a term that differs from an e-node's reading by this alone is united with it
//! under the reason `ac`, which costs the kernel nothing. Values are leaves in normal form. Each union made by a
//! law has a number for a reason; an explanation is read back as kernel steps through the table of these numbers.

mod readings;
mod unroll;

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use egg::{Analysis, DidMerge, EGraph, FlatTerm, Id, Language, RecExpr, Symbol};

use crate::fact::Context;
use crate::kernel::Theory;
use crate::law::{Connective, Law};
use crate::matching::matches;
use crate::name::Name;
use crate::proof::{Script, Step, StepId, hole};
use crate::simplify::{Simplifier, surround};
use crate::substitution::Substitution;
use crate::term::{Node, Term, TermSet};

/// How far a search goes. There is no time limit: the same search ends the same way on every machine.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Rounds of rewriting.
    pub rounds: usize,
    /// E-nodes in all.
    pub nodes: usize,
    /// The largest term that is added, in operators beyond those of the claim.
    pub growth: usize,
}

impl Default for Limits {
    fn default() -> Limits {
        Limits { rounds: 6, nodes: 4_000, growth: 8 }
    }
}

/// The most readings that one round looks at, the smallest first.
const READINGS: usize = 250;

/// E-nodes may have so many parts each in the mean: long lists fill the memory, not the number of e-nodes.
const PLACES: usize = 100;

/// The most law applications of one simplification in a search.
const FUEL: usize = 2_000;

/// Why a search ended without a proof.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// No law gives anything new.
    Saturated,
    /// A limit was reached.
    Limit,
    /// The user asked it to stop.
    Interrupted,
}

/// An operator with its parts as e-classes; the term gives the operator, its own parts are ignored.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
struct Operator {
    shape: Term,
    parts: Vec<Id>,
}

impl Language for Operator {
    type Discriminant = Term;

    fn discriminant(&self) -> Term {
        self.shape.clone()
    }

    fn matches(&self, other: &Operator) -> bool {
        self.shape == other.shape && self.parts.len() == other.parts.len()
    }

    fn children(&self) -> &[Id] {
        &self.parts
    }

    fn children_mut(&mut self) -> &mut [Id] {
        &mut self.parts
    }
}

/// The operator alone: a term of the same kind over `Stop`.
fn shape(term: &Term) -> Term {
    match term.node() {
        Node::Seq(_) => Term::seq([Term::abort(), Term::abort()]),
        Node::Par(_) => Term::par([Term::stop(), Term::stop()]),
        Node::Disable(_) => Term::disable([Term::stop(), Term::stop()]),
        _ => term.with_children(term.children().map(|_| Term::stop()).collect()),
    }
}

fn rebuild(shape: &Term, parts: Vec<Term>) -> Term {
    if parts.is_empty() { shape.clone() } else { shape.with_children(parts) }
}

/// Each e-class knows its smallest reading.
#[derive(Default)]
struct Smallest;

impl Analysis<Operator> for Smallest {
    type Data = Term;

    fn make(egraph: &mut EGraph<Operator, Smallest>, enode: &Operator, _: Id) -> Term {
        rebuild(&enode.shape, enode.parts.iter().map(|id| egraph[*id].data.clone()).collect())
    }

    fn merge(&mut self, mine: &mut Term, other: Term) -> DidMerge {
        let (old, new) = ((mine.size(), mine.clone()), (other.size(), other));
        match old.cmp(&new) {
            std::cmp::Ordering::Greater => {
                *mine = new.1;
                DidMerge(true, false)
            }
            std::cmp::Ordering::Equal => DidMerge(false, false),
            std::cmp::Ordering::Less => DidMerge(false, true),
        }
    }
}

/// Why two terms were united.
#[derive(Clone)]
enum Why {
    Law { law: Arc<Law>, forward: bool, substitution: Substitution, surrounding: Term, from: Term },
    Simplified { from: Term },
    Unfolded { call: Term },
    Supposed(StepId),
}

/// A search for an equality.
pub struct Saturation<'a> {
    theory: &'a Theory,
    context: &'a Context<'a>,
    interrupted: &'a dyn Fn() -> bool,
    egraph: EGraph<Operator, Smallest>,
    reasons: Vec<Why>,
    seen: HashSet<(Term, Term)>,
    done: TermSet,
    limits: Limits,
    largest: usize,
    /// The parts of all e-nodes.
    places: usize,
    laws: Vec<Way>,
    /// Finds the simplest forms of what is added; the proofs are made anew for those that are used.
    simple: Simplifier<'a>,
    only: Option<&'a [Name]>,
    weak: bool,
    unfolds: bool,
    supposed: Option<(Term, Term, StepId)>,
}

impl<'a> Saturation<'a> {
    /// A search with all laws, or those named alone.
    pub fn new(
        theory: &'a Theory,
        context: &'a Context<'a>,
        only: Option<&'a [Name]>,
        limits: Limits,
        interrupted: &'a dyn Fn() -> bool,
    ) -> Saturation<'a> {
        let wanted =
            |law: &Law| law.connective == Connective::Equal && only.is_none_or(|names| names.contains(&law.name));
        let laws = theory.laws.iter().filter(|law| wanted(law)).flat_map(Way::both).collect();
        let egraph = EGraph::new(Smallest).with_explanations_enabled();
        Saturation {
            theory,
            context,
            interrupted,
            egraph,
            reasons: Vec::new(),
            seen: HashSet::new(),
            done: TermSet::default(),
            limits,
            largest: 0,
            places: 0,
            laws,
            simple: simplifier(theory, context, only, false, interrupted),
            only,
            weak: false,
            unfolds: true,
            supposed: None,
        }
    }

    /// Uses the laws of weak equality as well; what it then proves is `left ~~ right`.
    pub fn weakly(mut self) -> Saturation<'a> {
        let wanted =
            |law: &Law| law.connective == Connective::Weak && self.only.is_none_or(|names| names.contains(&law.name));
        self.weak = true;
        self.laws.extend(self.theory.laws.iter().filter(|law| wanted(law)).flat_map(Way::both));
        self.simple = simplifier(self.theory, self.context, self.only, true, self.interrupted);
        self
    }

    /// Takes an equation that a step of the proof supposes.
    pub fn suppose(&mut self, left: &Term, right: &Term, step: StepId) {
        self.unite(left, right, Why::Supposed(step));
        self.supposed = Some((left.clone(), right.clone(), step));
    }

    /// Searches for `left = right`, both given with forms already known equal to them; on success the step that
    /// proves it.
    ///
    /// # Errors
    /// How the search ended.
    pub fn search(&mut self, left: &Term, right: &Term, script: &mut Script) -> Result<StepId, Ended> {
        self.largest = left.size().max(right.size()) + self.limits.growth;
        let goal = (self.add(left), self.add(right));
        for term in [left, right] {
            self.simplified(term);
            self.unroll(term, 2 * self.largest);
        }
        self.egraph.rebuild();
        for _ in 0..self.limits.rounds {
            if self.egraph.find(goal.0) == self.egraph.find(goal.1) {
                return self.explain(left, right, script).ok_or(Ended::Limit);
            }
            if self.round(goal)? == 0 {
                return Err(Ended::Saturated);
            }
        }
        if self.egraph.find(goal.0) == self.egraph.find(goal.1) {
            return self.explain(left, right, script).ok_or(Ended::Limit);
        }
        Err(Ended::Limit)
    }

    /// The numbers of e-classes and e-nodes so far.
    pub fn size(&self) -> (usize, usize) {
        (self.egraph.number_of_classes(), self.egraph.total_number_of_nodes())
    }

    /// Whether the e-graph may not grow further.
    fn is_full(&self) -> bool {
        self.egraph.total_number_of_nodes() > self.limits.nodes || self.places > PLACES * self.limits.nodes
    }

    fn add(&mut self, term: &Term) -> Id {
        let parts: Vec<Id> = term.children().map(|part| self.add(part)).collect();
        let (before, places) = (self.egraph.total_size(), parts.len());
        let id = self.egraph.add_uncanonical(Operator { shape: shape(term), parts });
        if self.egraph.total_size() > before {
            self.places += places;
        }
        id
    }

    fn expression(term: &Term, out: &mut RecExpr<Operator>) -> Id {
        let parts = term.children().map(|part| Self::expression(part, out)).collect();
        out.add(Operator { shape: shape(term), parts })
    }

    fn unite(&mut self, from: &Term, to: &Term, why: Why) -> bool {
        if !self.seen.insert((from.clone(), to.clone())) {
            return false;
        }
        let (one, two) = (self.add(from), self.add(to));
        self.reasons.push(why);
        self.egraph.union_trusted(one, two, Symbol::from((self.reasons.len() - 1).to_string()))
    }

    fn simplifier(&self) -> Simplifier<'a> {
        simplifier(self.theory, self.context, self.only, self.weak, self.interrupted)
    }

    fn simplified(&mut self, term: &Term) -> Term {
        self.simple.refuel(FUEL);
        let simple = self.simple.simplify(term).term;
        self.simple.script.steps.clear();
        if self.simple.exhausted() {
            // What it remembers now may not be simplest, and a proof made anew would go further.
            self.simple = self.simplifier();
            return term.clone();
        }
        if simple != *term {
            self.unite(term, &simple, Why::Simplified { from: term.clone() });
        }
        simple
    }

    /// One round: every law, both ways, on every reading of every e-node. Gives the number of unions.
    fn round(&mut self, goal: (Id, Id)) -> Result<usize, Ended> {
        let mut changes = 0;
        let mut looked = 0;
        for term in self.readings() {
            if looked == READINGS || self.egraph.find(goal.0) == self.egraph.find(goal.1) {
                break;
            }
            if !self.done.insert(term.clone()) {
                continue;
            }
            looked += 1;
            if (self.interrupted)() {
                return Err(Ended::Interrupted);
            }
            if self.is_full() {
                break;
            }
            changes += self.rewrite(&term);
            self.egraph.rebuild();
        }
        if self.is_full() && changes == 0 {
            return Err(Ended::Limit);
        }
        Ok(changes)
    }

    fn rewrite(&mut self, term: &Term) -> usize {
        let mut changes = 0;
        if self.unfolds
            && let Node::Call(name, arguments) = term.node()
            && let Some(body) = self.unfolding(name, arguments)
        {
            changes += usize::from(self.unite(term, &body, Why::Unfolded { call: term.clone() }));
        }
        for index in 0..self.laws.len() {
            let Way { law, forward } = self.laws[index].clone();
            let (pattern, other) = if forward { (&law.left, &law.right) } else { (&law.right, &law.left) };
            for found in matches(&law, pattern, term, self.context) {
                let Ok(instance) = found.substitution.apply(other, self.context) else { continue };
                let result = surround(&found.surrounding, &instance);
                if result == *term || result.size() > self.largest {
                    continue;
                }
                let (substitution, surrounding) = (found.substitution, found.surrounding);
                let why = Why::Law { law: law.clone(), forward, substitution, surrounding, from: term.clone() };
                if self.unite(term, &result, why) {
                    changes += 1;
                }
                self.simplified(&result);
            }
        }
        changes
    }

    fn unfolding(&self, name: &Name, arguments: &[crate::value::Value]) -> Option<Term> {
        let definition = self.theory.definitions.get(name)?;
        let body = crate::substitution::instantiate(&definition.body, &definition.parameters, arguments, self.context);
        let body = body.ok()?;
        Some(if definition.recursive { Term::attempt(body) } else { body })
    }

    fn explain(&mut self, left: &Term, right: &Term, script: &mut Script) -> Option<StepId> {
        let mut expressions = (RecExpr::default(), RecExpr::default());
        Self::expression(left, &mut expressions.0);
        Self::expression(right, &mut expressions.1);
        let mut explanation = self.egraph.explain_equivalence(&expressions.0, &expressions.1);
        let flat = explanation.make_flat_explanation().clone();
        let mut chain = vec![script.push(Step::Reflexive(left.clone()))];
        let mut proved: HashMap<usize, StepId> = HashMap::new();
        for line in &flat {
            if let Some((number, backward, context)) = rewritten(line) {
                let inner = self.prove(number, script, &mut proved)?;
                let inner = if backward { script.push(Step::Symmetric(inner)) } else { inner };
                chain.push(script.push(Step::Congruence(context, vec![inner])));
            }
        }
        Some(script.chain(chain))
    }

    /// The kernel steps of one numbered union.
    fn prove(&self, number: usize, script: &mut Script, proved: &mut HashMap<usize, StepId>) -> Option<StepId> {
        if let Some(step) = proved.get(&number) {
            return Some(*step);
        }
        let mut simplifier = self.simplifier();
        simplifier.script = std::mem::take(script);
        let step = match &self.reasons[number] {
            Why::Simplified { from } => Some(simplifier.simplify(from).step),
            Why::Supposed(step) => Some(*step),
            Why::Unfolded { call } => Some(simplifier.script.push(Step::Unfold(call.clone()))),
            Why::Law { law, forward, substitution, surrounding, from } => {
                simplifier.instance(from, law, *forward, substitution, surrounding).map(|found| found.step)
            }
        };
        *script = simplifier.script;
        proved.insert(number, step?);
        step
    }
}

/// A law in one direction.
#[derive(Clone)]
struct Way {
    law: Arc<Law>,
    forward: bool,
}

impl Way {
    /// The directions in which a law may be used.
    fn both(law: &Arc<Law>) -> Vec<Way> {
        let forward = usable(&law.left, &law.right, true).then(|| Way { law: law.clone(), forward: true });
        let backward = usable(&law.right, &law.left, false).then(|| Way { law: law.clone(), forward: false });
        forward.into_iter().chain(backward).collect()
    }
}

fn simplifier<'a>(
    theory: &'a Theory,
    context: &'a Context<'a>,
    only: Option<&'a [Name]>,
    weak: bool,
    interrupted: &'a dyn Fn() -> bool,
) -> Simplifier<'a> {
    let simplifier = Simplifier::new(theory, context, interrupted);
    let simplifier = match only {
        Some(laws) => simplifier.only(laws),
        None => simplifier,
    };
    if weak { simplifier.weakly(only) } else { simplifier }
}

/// Whether a side of a law may be used as a pattern for the other: it is no bare metavariable (any term would
/// match), and it names all that the other needs.
fn usable(pattern: &Term, other: &Term, forward: bool) -> bool {
    let bare = matches!(pattern.node(), Node::Meta(..));
    let known = crate::scope::metavariables(pattern);
    let replaces = crate::scope::subterms(pattern).any(|part| matches!(part.node(), Node::Replace(..)));
    (forward || (!bare && !replaces)) && crate::scope::metavariables(other).is_subset(&known)
}

fn flat_term(line: &FlatTerm<Operator>) -> Term {
    rebuild(&line.node.shape, line.children.iter().map(flat_term).collect())
}

/// The number of the rewrite in a line of an explanation, whether it runs backwards, and the context around it.
fn rewritten(line: &FlatTerm<Operator>) -> Option<(usize, bool, Term)> {
    let here = line.forward_rule.map(|rule| (rule, false)).or(line.backward_rule.map(|rule| (rule, true)));
    if let Some((rule, backward)) = here {
        return rule.as_str().parse().ok().map(|number| (number, backward, Term::meta(&hole(1))));
    }
    let position = line.children.iter().position(|child| rewritten(child).is_some())?;
    let (number, backward, inner) = rewritten(&line.children[position])?;
    let mut parts: Vec<Term> = line.children.iter().map(flat_term).collect();
    parts[position] = inner;
    Some((number, backward, rebuild(&line.node.shape, parts)))
}
