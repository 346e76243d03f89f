//! A proof as a chain that people read: the whole term on each line, and why it equals the one before.

mod counterexample;

use std::collections::BTreeMap;
use std::fmt;

use crate::advance::Instant;
use crate::advance::draw::Draws;
use crate::fact::Context;
use crate::kernel::Theory;
use crate::law::{Condition, Connective};
use crate::name::Name;
use crate::proof::{Proof, Statement, Step, StepId, carried_on, hole};
use crate::scope::fill;
use crate::substitution::{Substitution, instantiate, substitute_values};
use crate::term::Term;
use crate::value::Value;

pub use counterexample::{claim_lines, instance, run_lines};

/// A chain longer than this is cut.
pub const MOST_LINES: usize = 2_000;
/// Steps nested deeper than this are not opened.
const DEEPEST: usize = 200;

/// Why a line follows from the one before.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Why {
    /// By this law.
    Law(Name),
    /// By computing with values.
    Arithmetic,
    /// By the definition of this process.
    Definition(Name),
    /// Because a guarded recursive equation has one solution only.
    Unique(Name),
    /// Because the loop of this process is the only solution.
    UniqueLoop,
    /// Because the network runs so.
    Advance,
    /// Because the network draws so.
    Draw,
    /// A comparison, and that it holds or does not.
    Cases(Condition),
    /// What is supposed cannot be.
    Excluded,
    /// By the hypothesis of the induction around.
    Hypothesis,
    /// By induction on this number.
    Induction(Name),
    /// On trust, for this reason.
    Trust(String),
    /// By steps that are not shown.
    Steps(usize),
}

/// One line of a chain.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Line {
    /// Equality or refinement with the line before.
    pub connective: Connective,
    /// Why.
    pub why: Why,
    /// Whether the reason is used from right to left.
    pub backwards: bool,
    /// The whole term.
    pub term: Term,
}

/// A chain: where it starts, and its lines.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Chain {
    /// The left side of the claim.
    pub start: Term,
    /// The lines; the last has the right side of the claim.
    pub lines: Vec<Line>,
    /// Whether lines were left out because there are too many.
    pub cut: bool,
}

impl fmt::Display for Why {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Why::Law(name) => write!(f, "{name}"),
            Why::Arithmetic => write!(f, "arithmetic"),
            Why::Definition(name) => write!(f, "definition of {name}"),
            Why::Unique(name) => write!(f, "the only solution: {name}"),
            Why::UniqueLoop => write!(f, "the only solution: a loop"),
            Why::Advance => write!(f, "the network runs on"),
            Why::Draw => write!(f, "the network draws"),
            Why::Excluded => write!(f, "what is supposed excludes itself"),
            Why::Cases(when) => write!(f, "where {when}, and where not"),
            Why::Hypothesis => write!(f, "induction hypothesis"),
            Why::Induction(name) => write!(f, "induction on {name}"),
            Why::Trust(reason) => write!(f, "on trust: {reason}"),
            Why::Steps(count) => write!(f, "{count} steps"),
        }
    }
}

/// The chain of a proof that the kernel has accepted in this theory.
pub fn chain(theory: &Theory, proof: &Proof) -> Chain {
    let context = Context::new(&theory.assumptions, &theory.definitions, &proof.statement.hypotheses);
    let mut ends: Vec<Ends> = Vec::with_capacity(proof.steps.len());
    for step in &proof.steps {
        let next = step_ends(proof, step, &ends, theory, &context);
        ends.push(next);
    }
    let mut opener = Opener { proof, ends: &ends, lines: Vec::new(), cut: false };
    if let Some(last) = proof.steps.len().checked_sub(1) {
        opener.open(last, &[], false, 0);
    }
    let (mut lines, cut) = (opener.lines, opener.cut);
    shorten(&proof.statement.left, &mut lines);
    Chain { start: proof.statement.left.clone(), lines, cut }
}

/// Leaves out what changes nothing, and what is undone at once.
fn shorten(start: &Term, lines: &mut Vec<Line>) {
    let mut kept: Vec<Line> = Vec::with_capacity(lines.len());
    for line in lines.drain(..) {
        let before = kept.last().map_or(start, |line| &line.term);
        if *before == line.term && line.connective == Connective::Equal {
            continue;
        }
        let earlier = if kept.len() >= 2 { kept.get(kept.len() - 2).map(|line| &line.term) } else { Some(start) };
        let equal = kept.last().is_some_and(|last| last.connective == Connective::Equal);
        if equal && line.connective == Connective::Equal && earlier == Some(&line.term) {
            kept.pop();
            continue;
        }
        kept.push(line);
    }
    *lines = kept;
}

/// The two sides that a step proves equal.
#[derive(Clone)]
struct Ends {
    left: Term,
    connective: Connective,
    right: Term,
}

fn step_ends(proof: &Proof, step: &Step, ends: &[Ends], theory: &Theory, context: &Context<'_>) -> Ends {
    let equal = |left: Term, right: Term| Ends { left, connective: Connective::Equal, right };
    let at = |step: &StepId| ends.get(*step).cloned().unwrap_or_else(|| equal(Term::stop(), Term::stop()));
    match step {
        Step::Reflexive(term) => equal(term.clone(), term.clone()),
        Step::Symmetric(of) => {
            let of = at(of);
            Ends { left: of.right, right: of.left, ..of }
        }
        Step::Transitive(steps) => {
            let (first, last) = (steps.first().map(at), steps.last().map(at));
            let connective = joined(steps.iter().map(|step| at(step).connective));
            let stop = || equal(Term::stop(), Term::stop());
            Ends { left: first.unwrap_or_else(stop).left, connective, right: last.unwrap_or_else(stop).right }
        }
        Step::Congruence(shape, steps) => {
            let parts: Vec<Ends> = steps.iter().map(at).collect();
            let connective = joined(parts.iter().map(|part| part.connective));
            let side = |side: fn(&Ends) -> &Term| filled(shape, parts.iter().map(side));
            Ends { left: side(|ends| &ends.left), connective, right: side(|ends| &ends.right) }
        }
        Step::Law(name, with) => law_ends(name, with, theory, context),
        Step::Lemma(of, with) => {
            lemma_ends(proof, *of, &|term| with.apply(term, context).unwrap_or_else(|_| term.clone()))
        }
        Step::Cases { holds, .. } => lemma_ends(proof, *holds, &Term::clone),
        Step::Instance(of, with) => {
            let of = at(of);
            let image = |term: &Term| with.apply(term, context).unwrap_or_else(|_| term.clone());
            Ends { left: image(&of.left), connective: of.connective, right: image(&of.right) }
        }
        Step::Arithmetic(left, right) | Step::Suppose(left, right) | Step::Excluded(left, right) => {
            equal(left.clone(), right.clone())
        }
        Step::Induction { left, right, .. } => equal(left.clone(), right.clone()),
        Step::Trust(left, connective, right, _) => {
            Ends { left: left.clone(), connective: *connective, right: right.clone() }
        }
        Step::Unfold(call) => equal(call.clone(), unfolded(call, theory, context)),
        Step::Unique { name, candidate, .. } => {
            let call = theory.definitions.get(name).map_or_else(Term::stop, |definition| {
                let own = definition.parameters.iter().map(crate::value::Value::variable).collect();
                Term::new(crate::term::Node::Call(name.clone(), own))
            });
            equal(candidate.clone(), call)
        }
        Step::UniqueLoop { body, equation } => {
            let connective = at(equation).connective;
            Ends { connective, ..equal(at(equation).left, Term::new(crate::term::Node::Loop(body.clone()))) }
        }
        Step::Advance(..) | Step::Draw(..) | Step::Rounds { .. } | Step::Turns { .. } => run_ends(proof, step, context),
    }
}

/// The sides of a lemma, each as an image of itself.
fn lemma_ends(proof: &Proof, lemma: usize, image: &dyn Fn(&Term) -> Term) -> Ends {
    let statement = proof.lemmas.get(lemma).map(|lemma| &lemma.statement);
    let connective = statement.map_or(Connective::Equal, |statement| statement.connective);
    let side = |side: fn(&Statement) -> &Term| statement.map_or_else(Term::stop, |all| image(side(all)));
    Ends { left: side(|all| &all.left), connective, right: side(|all| &all.right) }
}

/// The sides of a step that says how a network runs; of any other, nothing.
fn run_ends(proof: &Proof, step: &Step, context: &Context<'_>) -> Ends {
    let nothing = || Ends { left: Term::stop(), connective: Connective::Equal, right: Term::stop() };
    let stated = |lemma: usize| proof.lemmas.get(lemma).map(|lemma| &lemma.statement);
    let weak = |network: &Term, right: Option<Term>| Ends {
        left: network.clone(),
        connective: Connective::Weak,
        right: right.unwrap_or_else(|| network.clone()),
    };
    match step {
        Step::Advance(network, time) => {
            let instant = Instant::of(network, context);
            weak(network, instant.and_then(|instant| instant.onward(time.as_ref(), context)).ok())
        }
        Step::Draw(network, names) => {
            weak(network, Draws::of(network, context).and_then(|draws| draws.made(names, context)).ok())
        }
        Step::Rounds { lemma, variable, round, index, count } => {
            let Some(statement) = stated(*lemma) else { return nothing() };
            let put = |term: &Term, value: Value| {
                let map = BTreeMap::from([(variable.clone(), value)]);
                substitute_values(term, &map).unwrap_or_else(|_| term.clone())
            };
            let body = put(round, Value::variable(index));
            let rounds = Term::new(crate::term::Node::Power(body, count.clone(), Some(index.clone())));
            let right = Term::seq([rounds, put(&statement.left, count.clone())]);
            Ends { left: put(&statement.left, Value::zero()), connective: statement.connective, right }
        }
        Step::Turns { lemma, turn, moving } => {
            let Some(statement) = stated(*lemma) else { return nothing() };
            let starts = moving.iter().map(|one| (one.variable.clone(), one.start.clone())).collect();
            let left = substitute_values(&statement.left, &starts).unwrap_or_else(|_| statement.left.clone());
            let right = carried_on(turn, moving).unwrap_or_else(|_| turn.clone());
            Ends { left, connective: statement.connective.join(Connective::Weak), right }
        }
        _ => nothing(),
    }
}

fn joined(connectives: impl Iterator<Item = Connective>) -> Connective {
    connectives.fold(Connective::Equal, Connective::join)
}

fn law_ends(name: &Name, with: &Substitution, theory: &Theory, context: &Context<'_>) -> Ends {
    let Some(law) = theory.laws.get(name) else {
        return Ends { left: Term::stop(), connective: Connective::Equal, right: Term::stop() };
    };
    let image = |term: &Term| with.apply(term, context).unwrap_or_else(|_| term.clone());
    Ends { left: image(&law.left), connective: law.connective, right: image(&law.right) }
}

fn unfolded(call: &Term, theory: &Theory, context: &Context<'_>) -> Term {
    let crate::term::Node::Call(name, arguments) = call.node() else { return call.clone() };
    let Some(definition) = theory.definitions.get(name) else { return call.clone() };
    match instantiate(&definition.body, &definition.parameters, arguments, context) {
        Ok(body) if definition.recursive => Term::attempt(body),
        Ok(body) => body,
        Err(_) => call.clone(),
    }
}

fn filled<'t>(shape: &Term, parts: impl Iterator<Item = &'t Term>) -> Term {
    let parts: BTreeMap<Name, Term> = parts.enumerate().map(|(index, part)| (hole(index + 1), part.clone())).collect();
    fill(shape, &parts)
}

struct Opener<'a> {
    proof: &'a Proof,
    ends: &'a [Ends],
    lines: Vec<Line>,
    cut: bool,
}

impl Opener<'_> {
    /// Appends the lines of a step inside the contexts around it, the innermost last.
    fn open(&mut self, number: StepId, around: &[Term], backwards: bool, depth: usize) {
        let (Some(step), Some(ends)) = (self.proof.steps.get(number), self.ends.get(number)) else { return };
        if self.lines.len() >= MOST_LINES {
            self.cut = true;
            return;
        }
        match step {
            Step::Reflexive(_) => {}
            Step::Symmetric(of) if depth < DEEPEST => self.open(*of, around, !backwards, depth + 1),
            Step::Transitive(steps) if depth < DEEPEST => {
                let each: Vec<StepId> = if backwards { steps.iter().rev().copied().collect() } else { steps.clone() };
                each.into_iter().for_each(|step| self.open(step, around, backwards, depth + 1));
            }
            Step::Congruence(shape, steps) if depth < DEEPEST => self.inside(shape, steps, around, backwards, depth),
            _ => {
                let term = if backwards { &ends.left } else { &ends.right };
                let term = around.iter().rev().fold(term.clone(), |term, shape| filled(shape, std::iter::once(&term)));
                self.lines.push(Line { connective: ends.connective, why: why(self.proof, step), backwards, term });
            }
        }
    }

    /// One hole after the other: those before have their new parts, those behind their old ones.
    fn inside(&mut self, shape: &Term, steps: &[StepId], around: &[Term], backwards: bool, depth: usize) {
        let mut parts: Vec<Term> = steps
            .iter()
            .filter_map(|step| self.ends.get(*step))
            .map(|ends| if backwards { ends.right.clone() } else { ends.left.clone() })
            .collect();
        if parts.len() != steps.len() {
            return;
        }
        for (index, step) in steps.iter().enumerate() {
            let mut holes = parts.clone();
            if let Some(part) = holes.get_mut(index) {
                *part = Term::meta(&hole(1));
            }
            let context = filled(shape, holes.iter());
            let mut around = around.to_vec();
            around.push(context);
            self.open(*step, &around, backwards, depth + 1);
            if let (Some(part), Some(ends)) = (parts.get_mut(index), self.ends.get(*step)) {
                *part = if backwards { ends.left.clone() } else { ends.right.clone() };
            }
        }
    }
}

fn why(proof: &Proof, step: &Step) -> Why {
    match step {
        Step::Law(name, _) => Why::Law(name.clone()),
        Step::Lemma(of, _) => proof.lemmas.get(*of).map_or(Why::Steps(1), |lemma| Why::Law(lemma.name.clone())),
        Step::Arithmetic(..) => Why::Arithmetic,
        Step::Unfold(call) => match call.node() {
            crate::term::Node::Call(name, _) => Why::Definition(name.clone()),
            _ => Why::Arithmetic,
        },
        Step::Unique { name, .. } => Why::Unique(name.clone()),
        Step::UniqueLoop { .. } | Step::Turns { .. } => Why::UniqueLoop,
        Step::Advance(..) => Why::Advance,
        Step::Draw(..) => Why::Draw,
        Step::Cases { when, .. } => Why::Cases(when.clone()),
        Step::Excluded(..) => Why::Excluded,
        Step::Rounds { variable, .. } => Why::Induction(variable.clone()),
        Step::Suppose(..) => Why::Hypothesis,
        Step::Induction { variable, .. } => Why::Induction(variable.clone()),
        Step::Trust(_, _, _, reason) => Why::Trust(reason.clone()),
        Step::Instance(..) => Why::Steps(1),
        Step::Reflexive(_) => Why::Steps(0),
        Step::Symmetric(_) => Why::Steps(1),
        Step::Transitive(steps) | Step::Congruence(_, steps) => Why::Steps(steps.len()),
    }
}
