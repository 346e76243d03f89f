//! What was written into what it means: names are looked up, sorts and bindings checked, functions inlined.
//!
//! The items of one file see each other's processes, whatever their order; assumptions and claims take
//! effect in order. At the prompt a name may be defined again, which is reported.

mod assume;
mod check;
mod claim;
mod criteria;
mod declare;
mod define;
mod direction;
mod distribution;
mod exclusive;
mod exercise;
mod flow;
mod function;
mod graph;
mod iterate;
mod leading;
mod marking;
mod network;
mod process;
mod property;
mod scope;
mod shape;
mod solve;
mod terms;
mod sweep;
mod value;
mod vary;
mod vectors;
mod verdict;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use crate::assumption::Assumptions;
use crate::ast;
use crate::definition::Definitions;
use crate::diagnostic::{Diagnostic, Span};
use crate::law::{Condition, Connective, Law, Laws};
use crate::name::Name;
use crate::preorder::Preorder;
use crate::term::Term;
use crate::value::{Relation, Value};

pub use criteria::{Ask, Criteria, Criterion, Goal};
pub use declare::Batch;
pub use flow::Flow;
pub use network::{Property, System};
pub use solve::Question;
pub use sweep::{MOST_POINTS, Sweep};

/// Everything that has been declared; cheap to copy, so that any earlier one can be kept.
#[derive(Clone, Default)]
pub struct Environment {
    /// What is assumed of the parameters.
    pub assumptions: Assumptions,
    /// The processes.
    pub definitions: Definitions,
    /// The laws.
    pub laws: Laws,
    entities: Arc<BTreeMap<Name, Entity>>,
    /// Names of values and functions.
    quantities: Arc<BTreeMap<Name, Quantity>>,
    /// Names of the claims about processes so far: `by` may name them.
    claims: Arc<BTreeSet<Name>>,
    /// Functions as written, for arguments that are vectors.
    templates: Arc<BTreeMap<Name, Template>>,
    criteria: Arc<BTreeMap<Name, Arc<ast::Criteria>>>,
    history: vary::History,
}

/// A function as written, with what the names in it meant.
#[derive(Clone)]
struct Template {
    parameters: Vec<Name>,
    body: Arc<ast::Value>,
    quantities: Arc<BTreeMap<Name, Quantity>>,
    templates: Arc<BTreeMap<Name, Template>>,
    /// Whether it has no value for numbers.
    of_vectors: bool,
}

/// What a name with a capital stands for.
#[derive(Clone, Debug)]
pub enum Entity {
    /// `proc`
    Process(Signature),
    /// `observer`, with its number of parameters
    Observer(usize),
    /// `system`
    System(System),
    /// `property`
    Property(Property),
}

/// How a process may be used.
#[derive(Clone, Debug, Default)]
pub struct Signature {
    /// Its parameters.
    pub parameters: Vec<Name>,
    /// What each parameter must be, as far as its body tells.
    pub classes: Vec<Option<Class>>,
    /// How many components each has that is a vector.
    pub lengths: Vec<Option<usize>>,
    /// How it can end, and what it binds.
    pub flow: Flow,
}

/// What a value must be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// A number or a vector of numbers.
    Number,
    /// A distribution.
    Distribution,
}

/// What a name of a value stands for.
#[derive(Clone, Debug)]
pub enum Quantity {
    /// `param x`, `param x = 3`, `param D : distribution`
    Parameter {
        /// A number or a distribution.
        class: Class,
        /// Its value, when it was given one; it then never appears in terms.
        constant: Option<Value>,
    },
    /// `fn s(d) = d / t`
    Function {
        /// Its parameters.
        parameters: Vec<Name>,
        /// What it gives; open when it was declared without.
        body: Option<Value>,
    },
}

/// What an item comes to.
#[derive(Clone, Debug)]
pub enum Lowered {
    /// Something was declared.
    Declared {
        /// What.
        names: Vec<Name>,
        /// Those that were declared before, in another input: what was proved with them is stale.
        redefined: Vec<Name>,
        /// What is to be said of it: parameters that are vectors, because of where they stand.
        notes: Vec<String>,
    },
    /// `prove …`
    Claim(Claim),
    /// `simplify P`
    Simplify(Term),
    /// `period Sys`
    Period(Name),
    /// `flow Sys`
    Flow(Name),
    /// `solve …`
    Solve(Box<Question>),
    /// `probability of …`
    Probability(Likelihood),
    /// `project P to {…}`: without `Delay`, which always stays
    Project(Subject, BTreeSet<Name>),
    /// `lts P`
    Lts(Subject, ast::Limits),
    /// `minimise P`
    Minimise(Subject, ast::Limits),
    /// `compare P ~ Q`
    Alike(Subject, Subject, Preorder, ast::Limits),
    /// `expect …`
    Expect(Expectation),
    /// `import "file"`
    Import(String),
    /// `law …`: it is in force already
    Law(Law),
    /// `exercise …`
    Exercise(Exercise),
    /// `criteria …`
    Criteria(Box<Criteria>),
    /// `sweep …`
    Sweep(Box<Sweep>),
}

/// What is projected.
#[derive(Clone, Debug)]
pub enum Subject {
    /// A system.
    System(Name),
    /// A process.
    Term(Term),
}

/// What is expected of the item before.
#[derive(Clone, Debug)]
pub enum Expectation {
    /// The claim is proved.
    Proved,
    /// The claim is refuted.
    Refuted,
    /// The claim is left open.
    Open,
    /// The criteria are met.
    Met,
    /// They are not.
    NotMet,
    /// The answer is `yes`, `no` or `unknown`.
    Answer(Name),
    /// What is looked for is never met.
    Never,
    /// The simplification gives this.
    Term(Term),
    /// These values are found.
    Values(Vec<(Name, Value)>),
}

/// A claim to be proved.
#[derive(Clone, Debug)]
pub struct Claim {
    /// `name:`
    pub name: Option<Name>,
    /// Where it stands.
    pub span: Span,
    /// As written.
    pub text: String,
    /// What it claims.
    pub kind: ClaimKind,
}

/// What a claim claims.
#[derive(Clone, Debug)]
pub enum ClaimKind {
    /// `P = Q`, `P <= Q`
    Compare {
        /// Before the connective.
        left: Term,
        /// After it.
        right: Term,
        /// `=` or `<=`.
        connective: Connective,
        /// The hypotheses.
        when: Vec<Condition>,
        /// How to prove it.
        by: By,
    },
    /// `Sys satisfies Goal`
    Satisfies {
        /// The system.
        system: Name,
        /// The property.
        property: Name,
    },
    /// `Sys always abs(p-o) > 1 when At_p, Rock_o`
    Always {
        /// The system.
        system: Name,
        /// What must hold of what is shown.
        pattern: Pattern,
        /// The property that says so.
        property: Option<Name>,
    },
    /// `probability of … >= q`
    Likely {
        /// What of.
        likelihood: Likelihood,
        /// How its probability compares.
        relation: Relation,
        /// With what: a number from 0 to 1.
        threshold: Value,
    },
}

/// Observers with names for the values that they show, and conditions on those values.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pattern {
    /// The observers.
    pub terms: Vec<Term>,
    /// The names that stand for what is shown.
    pub variables: BTreeSet<Name>,
    /// The conditions.
    pub conditions: Vec<(Relation, Value, Value)>,
}

/// Something that a system does with some probability.
#[derive(Clone, Debug)]
pub struct Likelihood {
    /// The system.
    pub system: Name,
    /// What it may do.
    pub event: Event,
    /// How to find the probability, where that is said.
    pub method: Option<Method>,
    /// How many runs a simulation has, where that is said, and the seed of its draws.
    pub runs: Option<u64>,
    /// The seed.
    pub seed: Option<u64>,
}

/// What a system may do.
#[derive(Clone, Debug)]
pub enum Event {
    /// Shows something that meets a pattern.
    Shown {
        /// Whether any time up to the given one counts: first passage.
        first: bool,
        /// What is shown.
        pattern: Pattern,
        /// When.
        time: Value,
    },
    /// Does what a property says.
    Satisfies(Name),
}

/// How a probability is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// From the algebra of normal distributions, in closed form.
    Exact,
    /// Numerically, with a bound that is proved.
    Enclosed,
    /// By simulation, with a confidence interval.
    Estimated,
}

/// How a claim is to be proved.
#[derive(Clone, Debug)]
pub enum By {
    /// By search over all laws.
    Search,
    /// By search over these laws.
    Laws(Vec<Name>),
    /// Line by line; the first term is the left side and the last the right side of the claim.
    Calc(Vec<CalcStep>),
}

/// `= {law} P`; the first step of a calculation starts at the left side of the claim.
#[derive(Clone, Debug)]
pub struct CalcStep {
    /// `=` or `<=`.
    pub connective: Connective,
    /// The laws to use; all when none is named.
    pub laws: Vec<Name>,
    /// What is reached.
    pub term: Term,
    /// Where it stands.
    pub span: Span,
}

/// `exercise name "title" prove P = Q …`
#[derive(Clone, Debug)]
pub struct Exercise {
    /// Its name.
    pub name: Name,
    /// Its title.
    pub title: String,
    /// Where the calculation begins.
    pub left: Term,
    /// `=` or `<=`.
    pub connective: Connective,
    /// Where it must end.
    pub right: Term,
    /// The hypotheses.
    pub when: Vec<Condition>,
    /// The laws that may be used; all when none is named.
    pub laws: Vec<Name>,
    /// The steps, with their gaps.
    pub steps: Vec<Gap>,
    /// Hints, to be given one at a time.
    pub hints: Vec<String>,
}

/// A step of an exercise; what is not given is to be found.
#[derive(Clone, Debug)]
pub struct Gap {
    /// `=` or `<=`.
    pub connective: Connective,
    /// The laws to use.
    pub laws: Option<Vec<Name>>,
    /// What is reached.
    pub term: Option<Term>,
}

impl Environment {
    /// Nothing but the basic processes.
    pub fn new() -> Environment {
        Environment::default()
    }

    /// Takes in the items of a text, all of them; an import is only named in the answer.
    pub fn declare(&mut self, items: &[ast::Item], text: &str) -> Vec<Result<Lowered, Vec<Diagnostic>>> {
        let mut batch = self.open(items, text);
        items.iter().enumerate().map(|(index, item)| self.step(&mut batch, index, item)).collect()
    }

    /// What a name with a capital stands for.
    pub fn entity(&self, name: &Name) -> Option<&Entity> {
        self.entities.get(name)
    }

    /// All names with a capital, in order.
    pub fn entities(&self) -> impl Iterator<Item = (&Name, &Entity)> {
        self.entities.iter()
    }

    /// What a name of a value or a function stands for.
    pub fn quantity(&self, name: &Name) -> Option<&Quantity> {
        self.quantities.get(name)
    }

    /// All names of values and functions, in order.
    pub fn quantities(&self) -> impl Iterator<Item = (&Name, &Quantity)> {
        self.quantities.iter()
    }

    /// The system of this name.
    pub fn system(&self, name: &Name) -> Option<&System> {
        match self.entity(name) {
            Some(Entity::System(system)) => Some(system),
            _ => None,
        }
    }

    /// The property of this name.
    pub fn property(&self, name: &Name) -> Option<&Property> {
        match self.entity(name) {
            Some(Entity::Property(property)) => Some(property),
            _ => None,
        }
    }

    /// Lowers a term that stands alone, such as an argument of a command at the prompt.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn term(&self, term: &ast::Term) -> Result<Term, Vec<Diagnostic>> {
        let mut lowerer = scope::Lowerer::new(self, scope::Metas::Law);
        let lowered = lowerer.whole(&[term]).and_then(|mut terms| terms.pop());
        lowerer.finish(lowered)
    }

    /// Lowers a part of a process, such as a step of a proof: names may be read that are bound elsewhere, and
    /// neither bindings nor loops are checked.
    ///
    /// # Errors
    /// What is wrong with it: unknown processes, wrong numbers of parameters, values that have no normal form.
    pub fn part(&self, term: &ast::Term) -> Result<Term, Vec<Diagnostic>> {
        let mut lowerer = scope::Lowerer::new(self, scope::Metas::Law);
        (lowerer.free, lowerer.lenient) = (true, true);
        let lowered = lowerer.process(term);
        lowerer.finish(lowered)
    }

    /// Lowers a condition that stands alone, read as [`Environment::part`] reads processes.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn condition(&self, condition: &ast::Condition) -> Result<Condition, Vec<Diagnostic>> {
        let mut lowerer = scope::Lowerer::new(self, scope::Metas::Law);
        (lowerer.free, lowerer.lenient) = (true, true);
        let lowered = lowerer.condition(condition);
        lowerer.finish(lowered)
    }

    /// Lowers a value that stands alone; its names need not be declared.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn value(&self, value: &ast::Value) -> Result<Value, Vec<Diagnostic>> {
        let mut lowerer = scope::Lowerer::new(self, scope::Metas::Law);
        lowerer.free = true;
        let lowered = match &value.kind {
            ast::ValueKind::Call(name, _) if name.name.as_str().starts_with(char::is_uppercase) => {
                lowerer.distribution(value)
            }
            _ => lowerer.number(value),
        };
        lowerer.finish(lowered)
    }
}

/// The names of the basic processes.
pub const BASIC: [&str; 14] =
    ["Stop", "Abort", "Idle", "Delay", "In", "Out", "Eq", "Neq", "Gtr", "Gte", "Lss", "Lte", "Set", "Ran"];
