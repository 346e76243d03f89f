//! The kernel: re-derives every step of a proof from the laws and definitions, and is the only maker of [`Thm`].
//!
//! It knows neither the prover nor how a proof was found. Whatever it cannot derive is [`Rejected`].
//! One gate, [`Checker::gate`], looks at every conclusion before it may be used.

mod gate;
mod lemma;
mod meaning;
mod reason;
mod run;
mod turn;

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::rc::Rc;

use gate::{Needs, counts_are_settled, well_sorted};
use meaning::Meaning;
pub use reason::Reason;

use crate::assumption::Assumptions;
use crate::condition::exposes;
use crate::definition::Definitions;
use crate::fact::{Context, Facts};
use crate::law::{Condition, Connective, Laws};
use crate::name::Name;
use crate::proof::{Proof, Statement, Step, StepId, hole, successor};
use crate::scope::{
    bound_names, calls, condition_mentions, condition_parts, fill, reaches, read_names, subterms, written,
};
use crate::substitution::{Stuck, Substitution, instantiate, substitute_known};
use crate::term::room::levels;
use crate::term::{Node, Term, TermSet, in_some_order};
use crate::value::{Need, Relation, Value};

/// What a theorem may rest on: the assumptions on parameters, the definitions, the laws.
#[derive(Clone, Debug, Default)]
pub struct Theory {
    /// Facts about parameters.
    pub assumptions: Assumptions,
    /// Defined processes.
    pub definitions: Definitions,
    /// The laws in force.
    pub laws: Laws,
}

/// A theorem. Only [`check`] makes one.
#[derive(Clone, Debug)]
pub struct Thm {
    statement: Statement,
    laws: BTreeSet<Name>,
    lemmas: BTreeSet<Name>,
    trusted: BTreeSet<String>,
    /// What the values in it and in its proof need to have a meaning, as far as that does not follow from the assumptions.
    needs: BTreeSet<Need>,
    /// Of these, what was read where a network was run.
    reads: BTreeSet<Need>,
    /// Whether a network was run on the way, in which a metavariable stands for a value that no part binds.
    advanced: bool,
}

impl Thm {
    /// What was proved.
    pub fn statement(&self) -> &Statement {
        &self.statement
    }

    /// The laws used, by name.
    pub fn laws(&self) -> &BTreeSet<Name> {
        &self.laws
    }

    /// The lemmas used, by name; what they use in turn is among the laws.
    pub fn lemmas(&self) -> &BTreeSet<Name> {
        &self.lemmas
    }

    /// What a network needs that was run on the way, in guards and others that it has read, as far as that does not follow
    /// from the assumptions and hypotheses: where it does not hold the network has no meaning.
    pub fn reads(&self) -> &BTreeSet<Need> {
        &self.reads
    }

    /// What was taken on trust; empty for a full proof.
    pub fn trusted(&self) -> &BTreeSet<String> {
        &self.trusted
    }
}

/// Why a proof is no proof: the step and what is wrong with it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rejected {
    /// The number of the step, or of steps in all if the conclusion is at fault.
    pub step: StepId,
    /// What is wrong.
    pub reason: Reason,
}

/// The largest term that the kernel looks at, in operators.
pub const MAX_SIZE: usize = 1_000_000;
/// How deep a term in a proof may nest beyond the operators with one part that [`levels`] allows.
pub const MAX_DEPTH: usize = 400;

type Equation = (Term, Term);

/// What a step has established, inside the kernel.
#[derive(Clone)]
struct Derived {
    left: Term,
    connective: Connective,
    right: Term,
    supposed: BTreeSet<Equation>,
}

impl Derived {
    fn equal(left: Term, right: Term) -> Derived {
        Derived { left, connective: Connective::Equal, right, supposed: BTreeSet::new() }
    }
}

/// Checks a proof against a theory.
///
/// # Errors
/// The first step that does not follow.
pub fn check(theory: &Theory, proof: &Proof) -> Result<Thm, Rejected> {
    let mut proved: Vec<(Name, Thm)> = Vec::with_capacity(proof.lemmas.len());
    for lemma in &proof.lemmas {
        let theorem = derive(theory, &proved, &lemma.statement, &lemma.steps).map_err(|rejected| {
            let reason = Reason::Lemma(lemma.name.clone(), Box::new(rejected.reason));
            Rejected { reason, ..rejected }
        })?;
        proved.push((lemma.name.clone(), theorem));
    }
    derive(theory, &proved, &proof.statement, &proof.steps)
}

/// The theorem that these steps prove, with the help of theorems proved before.
fn derive(theory: &Theory, proved: &[(Name, Thm)], statement: &Statement, steps: &[Step]) -> Result<Thm, Rejected> {
    let context = Context::new(&theory.assumptions, &theory.definitions, &statement.hypotheses);
    let fixed = spoken_of(&context);
    // What is assumed of a name holds wherever it is read, so no definition may give it another value.
    let names = Rc::clone(&context.defined.names);
    if let Some(name) = fixed.iter().find(|name| names.bound.contains(*name)) {
        return Err(Rejected { step: 0, reason: Reason::Name(name.clone()) });
    }
    let (laws, lemmas, trusted) = (BTreeSet::new(), BTreeSet::new(), BTreeSet::new());
    let mut checker = Checker {
        theory,
        context,
        fixed,
        proved,
        derived: Vec::new(),
        laws,
        lemmas,
        trusted,
        reads: BTreeSet::new(),
        advanced: false,
        sorted: TermSet::default(),
        counts: BTreeSet::new(),
        needs: HashMap::new(),
        meaning: Meaning::of(statement, steps, theory, (&names.read, names.partial)),
    };
    for (number, step) in steps.iter().enumerate() {
        let found = checker.step(step).and_then(|derived| checker.gate(derived));
        let derived = found.map_err(|reason| Rejected { step: number, reason })?;
        checker.derived.push(derived);
    }
    let reject = |reason| Rejected { step: steps.len(), reason };
    let last = checker.derived.last().ok_or_else(|| reject(Reason::Empty))?;
    if let Some((left, right)) = last.supposed.iter().next() {
        return Err(reject(Reason::Hypothesis(Box::new(left.clone()), Box::new(right.clone()))));
    }
    same(&last.left, &statement.left).and_then(|()| same(&last.right, &statement.right)).map_err(reject)?;
    let plain = |side: &Term| checker.meaning.closed(side, &checker.context.assumptions);
    plain(&statement.left).and_then(|()| plain(&statement.right)).map_err(reject)?;
    if !last.connective.gives(statement.connective) {
        return Err(reject(Reason::Weaker(last.connective, statement.connective)));
    }
    let Checker { laws, lemmas, trusted, reads, advanced, meaning, .. } = checker;
    let needs = meaning.needed_by();
    Ok(Thm { statement: statement.clone(), laws, lemmas, trusted, needs, reads, advanced })
}

/// The names of which something is assumed or supposed, by itself or of a process that reads them.
fn spoken_of(context: &Context<'_>) -> BTreeSet<Name> {
    let mut names = context.assumptions.variables();
    for hypothesis in context.hypotheses {
        let (terms, values, _) = condition_parts(hypothesis);
        names.extend(values.into_iter().flat_map(Value::variables));
        names.extend(terms.into_iter().flat_map(|term| Facts::of(term, context).reads.names.clone()));
    }
    names
}

fn same(found: &Term, wanted: &Term) -> Result<(), Reason> {
    if found == wanted { Ok(()) } else { Err(Reason::Differ(Box::new(found.clone()), Box::new(wanted.clone()))) }
}

struct Checker<'a> {
    theory: &'a Theory,
    context: Context<'a>,
    fixed: BTreeSet<Name>,
    proved: &'a [(Name, Thm)],
    derived: Vec<Derived>,
    laws: BTreeSet<Name>,
    lemmas: BTreeSet<Name>,
    trusted: BTreeSet<String>,
    reads: BTreeSet<Need>,
    advanced: bool,
    /// Terms that have passed [`well_sorted`], with all their parts.
    sorted: TermSet,
    /// Names that numbers of rounds in them read.
    counts: BTreeSet<Name>,
    /// Of each law used, what its instances must meet.
    needs: HashMap<Name, Needs>,
    /// What the values of all steps need to have a meaning.
    meaning: Meaning<'a>,
}

impl Checker<'_> {
    /// Nothing passes that is too large, or that binds a name about which something is assumed: such a name means
    /// the same everywhere, which is what makes an equation under assumptions usable in every context.
    fn gate(&mut self, derived: Derived) -> Result<Derived, Reason> {
        for side in [&derived.left, &derived.right] {
            well_sorted(side, &self.fixed, &mut self.sorted, &mut self.counts)?;
            if !self.counts.is_empty() {
                counts_are_settled(side, self.context.definitions)?;
            }
            if side.size() > MAX_SIZE || side.depth() > levels() + MAX_DEPTH {
                return Err(Reason::TooLarge);
            }
            self.meaning.look(side, &self.context.assumptions)?;
            let mut counted = self.meaning.counted().peekable();
            if counted.peek().is_some() {
                let written = written(side, self.context.definitions);
                if let Some(name) = counted.find(|name| written.contains(name)) {
                    return Err(Reason::Name(name));
                }
            }
        }
        Ok(derived)
    }

    fn earlier(&self, step: StepId) -> Result<&Derived, Reason> {
        self.derived.get(step).ok_or(Reason::NotEarlier(step))
    }

    fn equation(&self, step: StepId) -> Result<&Derived, Reason> {
        let derived = self.earlier(step)?;
        match derived.connective {
            Connective::Equal => Ok(derived),
            weaker => Err(Reason::Weaker(weaker, Connective::Equal)),
        }
    }

    fn step(&mut self, step: &Step) -> Result<Derived, Reason> {
        match step {
            Step::Reflexive(term) => Ok(Derived::equal(term.clone(), term.clone())),
            Step::Symmetric(of) => {
                let of = self.earlier(*of)?.clone();
                if !of.connective.is_symmetric() {
                    return Err(Reason::Weaker(of.connective, Connective::Equal));
                }
                Ok(Derived { left: of.right, right: of.left, ..of })
            }
            Step::Transitive(steps) => self.transitive(steps),
            Step::Congruence(shape, steps) => self.congruence(shape, steps),
            Step::Law(name, substitution) => self.law(name, substitution),
            Step::Arithmetic(left, right) => {
                self.arithmetic(left, right)?;
                Ok(Derived::equal(left.clone(), right.clone()))
            }
            Step::Unfold(call) => self.unfold(call),
            Step::Unique { name, candidate, equation } => self.unique(name, candidate, *equation),
            Step::UniqueLoop { body, equation } => self.unique_loop(body, *equation),
            Step::Suppose(left, right) => {
                let supposed = BTreeSet::from([(left.clone(), right.clone())]);
                Ok(Derived { supposed, ..Derived::equal(left.clone(), right.clone()) })
            }
            Step::Induction { variable, left, right, base, step } => {
                self.induction(variable, left, right, *base, *step)
            }
            Step::Instance(of, substitution) => self.instance(*of, substitution),
            Step::Lemma(of, substitution) => self.lemma(*of, substitution),
            Step::Excluded(..) if !self.context.assumptions.contradictory() => Err(Reason::Possible),
            Step::Excluded(left, right) => Ok(Derived::equal(left.clone(), right.clone())),
            Step::Cases { when, holds, fails } => self.cases(when, [*holds, *fails]),
            Step::Advance(network, time) => self.advance(network, time.as_ref()),
            Step::Draw(network, names) => self.draw(network, names),
            Step::Rounds { lemma, variable, round, index, count } => {
                self.rounds(*lemma, variable, round, (index, count))
            }
            Step::Turns { lemma, turn, moving } => self.turns(*lemma, turn, moving),
            // What is taken on trust is shown: it must be there to be read, and not move what stands around it.
            Step::Trust(_, _, _, why)
                if !why.chars().any(char::is_alphanumeric) || why.chars().any(char::is_control) =>
            {
                Err(Reason::Empty)
            }
            Step::Trust(left, connective, right, why) => {
                self.trusted.insert(why.clone());
                let (left, right) = (left.clone(), right.clone());
                Ok(Derived { left, connective: *connective, right, supposed: BTreeSet::new() })
            }
        }
    }

    fn transitive(&self, steps: &[StepId]) -> Result<Derived, Reason> {
        let (first, rest) = steps.split_first().ok_or(Reason::Empty)?;
        let mut chain = self.earlier(*first)?.clone();
        for step in rest {
            let next = self.earlier(*step)?;
            same(&chain.right, &next.left)?;
            chain.right = next.right.clone();
            chain.connective = chain.connective.join(next.connective);
            chain.supposed.extend(next.supposed.iter().cloned());
        }
        Ok(chain)
    }

    fn congruence(&self, shape: &Term, steps: &[StepId]) -> Result<Derived, Reason> {
        let mut left = BTreeMap::new();
        let mut right = BTreeMap::new();
        let mut connective = Connective::Equal;
        let mut supposed = BTreeSet::new();
        for (position, step) in steps.iter().enumerate() {
            let derived = self.earlier(*step)?;
            left.insert(hole(position + 1), derived.left.clone());
            right.insert(hole(position + 1), derived.right.clone());
            connective = connective.join(derived.connective);
            supposed.extend(derived.supposed.iter().cloned());
        }
        let largest = left.values().chain(right.values()).map(Term::size).max().unwrap_or(1);
        let holes = subterms(shape).filter(|part| matches!(part.node(), Node::Meta(..))).count();
        if shape.size().saturating_add(holes.saturating_mul(largest)) > MAX_SIZE {
            return Err(Reason::TooLarge);
        }
        Ok(Derived { left: fill(shape, &left), connective, right: fill(shape, &right), supposed })
    }

    fn law(&mut self, name: &Name, substitution: &Substitution) -> Result<Derived, Reason> {
        let law = self.theory.laws.get(name).ok_or_else(|| Reason::UnknownLaw(name.clone()))?.clone();
        self.needs.entry(name.clone()).or_insert_with(|| Needs::of(&law)).are_met_by(substitution)?;
        let known = &self.context.assumptions;
        self.meaning.put_in(substitution, known)?;
        let own = [&law.left, &law.right].into_iter().flat_map(subterms).flat_map(Term::values).flat_map(Value::needs);
        self.meaning.instance(&own.collect(), &substitution.read(), known)?;
        let stuck = |stuck: Stuck| Reason::Stuck(stuck.0);
        for condition in &law.conditions {
            let instance = substitution.condition(condition, &self.context).map_err(stuck)?;
            if !self.context.holds(&instance) {
                return Err(Reason::Condition(Box::new(instance)));
            }
        }
        let left = substitution.apply(&law.left, &self.context).map_err(stuck)?;
        let right = substitution.apply(&law.right, &self.context).map_err(stuck)?;
        self.laws.insert(name.clone());
        Ok(Derived { left, connective: law.connective, right, supposed: BTreeSet::new() })
    }

    /// Same shape, and values that are equal under the assumptions wherever they stand.
    fn arithmetic(&self, left: &Term, right: &Term) -> Result<(), Reason> {
        let differ = || Reason::Differ(Box::new(left.clone()), Box::new(right.clone()));
        let (ours, theirs) = (left.values(), right.values());
        let blank = |term: &Term| term.map_values(&mut |_| Ok::<_, ()>(Value::zero())).ok();
        let parts = (left.children(), right.children());
        let counts = (ours.len(), parts.0.len()) == (theirs.len(), parts.1.len());
        if !counts || (parts.0.is_empty() && blank(left) != blank(right)) {
            return Err(differ());
        }
        if !parts.0.is_empty() {
            let bare = |term: &Term| {
                let plain = term.children().map(|_| Term::stop()).collect();
                blank(&term.with_children(plain))
            };
            if std::mem::discriminant(left.node()) != std::mem::discriminant(right.node()) || bare(left) != bare(right)
            {
                return Err(differ());
            }
        }
        for (mine, other) in ours.into_iter().zip(theirs) {
            let equal = mine == other
                || self.context.assumptions.decide(Relation::Eq, mine, other) == Some(true)
                || self.context.simplify(mine) == self.context.simplify(other);
            if !equal {
                return Err(differ());
            }
        }
        let straight = parts.0.zip(parts.1).try_for_each(|(mine, other)| self.arithmetic(mine, other));
        // What stands side by side is laid out by its values, which may be written in other ways here and there.
        straight.or_else(|differ| match (left.node(), right.node()) {
            (Node::Par(ours), Node::Par(theirs)) | (Node::Disable(ours), Node::Disable(theirs)) => {
                let same = |one: &Term, other: &Term| self.arithmetic(one, other).is_ok();
                in_some_order(ours, theirs, &same).then_some(()).ok_or(differ)
            }
            _ => Err(differ),
        })
    }

    fn unfold(&self, call: &Term) -> Result<Derived, Reason> {
        let Node::Call(name, arguments) = call.node() else {
            return Err(Reason::NotDefined(Box::new(call.clone())));
        };
        let definition = self.theory.definitions.get(name).filter(|d| d.parameters.len() == arguments.len());
        let definition = definition.ok_or_else(|| Reason::NotDefined(Box::new(call.clone())))?;
        let body = instantiate(&definition.body, &definition.parameters, arguments, &self.context)
            .map_err(|stuck| Reason::Stuck(stuck.0))?;
        let body = if definition.recursive { Term::attempt(body) } else { body };
        Ok(Derived::equal(call.clone(), body))
    }

    fn unique(&self, name: &Name, candidate: &Term, equation: StepId) -> Result<Derived, Reason> {
        let derived = self.equation(equation)?;
        let definition = self.theory.definitions.get(name).filter(|definition| definition.recursive);
        let definition = definition.ok_or_else(|| Reason::NotDefined(Box::new(candidate.clone())))?;
        no_supposition(derived)?;
        // The equation is for all values of the parameters, so nothing may be assumed of them.
        if let Some(parameter) = definition.parameters.iter().find(|parameter| self.fixed.contains(*parameter)) {
            return Err(Reason::Name(parameter.clone()));
        }
        // For all: so none may be left out as one without a meaning.
        let left_out = |need: &&Need| definition.parameters.iter().any(|parameter| need.value().mentions(parameter));
        if let Some(need) = self.meaning.met().iter().find(left_out) {
            return Err(Reason::Undefined(Box::new(need.clone())));
        }
        let indirect = calls(&definition.body)
            .into_iter()
            .any(|called| called != *name && reaches(&self.theory.definitions, &called, name));
        if indirect {
            return Err(Reason::NotDefined(Box::new(candidate.clone())));
        }
        if exposes(&definition.body, name, &self.context) {
            return Err(Reason::Unguarded(Box::new(definition.body.clone())));
        }
        same(&derived.left, candidate)?;
        let folded = self.with_candidate(&definition.body, definition.parameters.as_slice(), name, candidate)?;
        same(&derived.right, &Term::attempt(folded))?;
        let own = definition.parameters.iter().map(Value::variable).collect();
        Ok(Derived::equal(candidate.clone(), Term::new(Node::Call(name.clone(), own))))
    }

    /// The definition's body with each call `T_e` replaced by the candidate at e.
    fn with_candidate(&self, body: &Term, own: &[Name], name: &Name, candidate: &Term) -> Result<Term, Reason> {
        if let Node::Call(called, arguments) = body.node()
            && called == name
        {
            return instantiate(candidate, own, arguments, &self.context).map_err(|stuck| Reason::Stuck(stuck.0));
        }
        if body.children().is_empty() {
            return Ok(body.clone());
        }
        let parts: Result<Vec<Term>, Reason> =
            body.children().map(|part| self.with_candidate(part, own, name, candidate)).collect();
        Ok(body.with_children(parts?))
    }

    fn induction(
        &self,
        variable: &Name,
        left: &Term,
        right: &Term,
        base: StepId,
        step: StepId,
    ) -> Result<Derived, Reason> {
        let natural = self.context.assumptions.is_natural(&Value::variable(variable)) == Some(true);
        let own = Condition::Natural(Value::variable(variable));
        let free = self.theory.assumptions.iter().all(|(_, value)| !value.mentions(variable))
            && self.context.hypotheses.iter().all(|other| *other == own || !condition_mentions(other, variable))
            && self.theory.definitions.iter().all(|definition| !read_names(&definition.body).contains(variable));
        let partial = self.meaning.met().iter().any(|need| need.value().mentions(variable));
        if !natural || !free || partial || bound_names(left).contains(variable) || bound_names(right).contains(variable)
        {
            return Err(Reason::NotNatural(variable.clone()));
        }
        let at = |term: &Term, value: Value| {
            substitute_known(term, &BTreeMap::from([(variable.clone(), value)]), &self.context.assumptions)
                .map_err(|stuck| Reason::Stuck(stuck.0))
        };
        let zero = self.equation(base)?;
        no_supposition(zero)?;
        same(&zero.left, &at(left, Value::integer(0))?)?;
        same(&zero.right, &at(right, Value::integer(0))?)?;
        let next = successor(&Value::variable(variable)).ok_or(Reason::TooLarge)?;
        let successor = self.equation(step)?;
        same(&successor.left, &at(left, next.clone())?)?;
        same(&successor.right, &at(right, next)?)?;
        let mut supposed = successor.supposed.clone();
        supposed.remove(&(left.clone(), right.clone()));
        if let Some((l, r)) = supposed.iter().next() {
            return Err(Reason::Hypothesis(Box::new(l.clone()), Box::new(r.clone())));
        }
        Ok(Derived::equal(left.clone(), right.clone()))
    }
}

fn no_supposition(derived: &Derived) -> Result<(), Reason> {
    match derived.supposed.iter().next() {
        Some((l, r)) => Err(Reason::Hypothesis(Box::new(l.clone()), Box::new(r.clone()))),
        None => Ok(()),
    }
}
