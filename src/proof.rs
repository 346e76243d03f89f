//! Proofs as data: a numbered list of steps, each of which may use the ones before it. Anyone may write one;
//! only the kernel makes theorems of them. `docs/proof.md` describes each step.

use crate::law::{Condition, Connective};
use crate::name::Name;
use crate::scope::read_names;
use crate::substitution::{Stuck, Substitution, substitute_values};
use crate::term::{Node, Term};
use crate::value::Value;

/// The number of an earlier step.
pub type StepId = usize;

/// What is claimed: under the hypotheses, for all values of the metavariables, `left` connective `right`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Statement {
    /// What is supposed of the metavariables.
    pub hypotheses: Vec<Condition>,
    /// The left side.
    pub left: Term,
    /// Equality or refinement.
    pub connective: Connective,
    /// The right side.
    pub right: Term,
}

/// One step of a proof.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Step {
    /// `P = P`. Terms are flattened and sorted, so this also proves equal multisets under `|` and `#`.
    Reflexive(Term),
    /// From `P = Q`: `Q = P`.
    Symmetric(StepId),
    /// From `P = Q` and `Q = R` and …: `P = R`; a refinement if one of them is.
    Transitive(Vec<StepId>),
    /// From `P1 = Q1`, …: `C[P1, …] = C[Q1, …]`; the holes of C are the metavariables `?1`, `?2`, ….
    Congruence(Term, Vec<StepId>),
    /// An instance of a law whose conditions hold.
    Law(Name, Substitution),
    /// The two sides have equal values in equal places, under the assumptions.
    Arithmetic(Term, Term),
    /// A call equals its definition's body (`body else Stop` if recursive).
    Unfold(Term),
    /// From `X = B[X] `: X is the loop, if B is guarded. See [`crate::kernel`].
    Unique {
        /// The defined process, called with its own parameters.
        name: Name,
        /// X, in terms of the parameters.
        candidate: Term,
        /// Proves `X = body[calls of the definition replaced by X] else Stop`.
        equation: StepId,
    },
    /// From `X = (P ; X) else Stop`: `X = loop(P)`, if P is guarded. From `X ~~ P ; X`: `X ~~ loop(P)`, if P is silent
    /// and always stops, after a time that is more than 0.
    UniqueLoop {
        /// P
        body: Term,
        /// Proves the equation.
        equation: StepId,
    },
    /// A hypothesis of an induction, in force until the induction that discharges it.
    Suppose(Term, Term),
    /// Induction on a natural number: from `L(0) = R(0)` and, supposing `L(n) = R(n)`, `L(n+1) = R(n+1)`.
    Induction {
        /// n, a metavariable or a declared natural that no other assumption mentions.
        variable: Name,
        /// L(n) and R(n).
        left: Term,
        /// R(n)
        right: Term,
        /// Proves `L(0) = R(0)`.
        base: StepId,
        /// Proves `L(n+1) = R(n+1)`, supposing `L(n) = R(n)`.
        step: StepId,
    },
    /// An instance of an earlier step.
    Instance(StepId, Substitution),
    /// An instance of the lemma of this number; the conditions that it is proved under hold of the instance.
    Lemma(usize, Substitution),
    /// A closed network runs through this instant; then this much time passes, or nothing happens any more. See
    /// [`crate::advance`].
    Advance(Term, Option<Value>),
    /// A closed network draws all that it draws at once in this instant, each value under one of these names. See
    /// [`crate::advance::draw`].
    Draw(Term, Vec<Name>),
    /// From two lemmas of the same, one where a comparison of numbers holds and one where it does not: it holds in any case.
    Cases {
        /// The comparison.
        when: Condition,
        /// The number of the lemma where it holds.
        holds: usize,
        /// The number of the lemma where it does not.
        fails: usize,
    },
    /// Two terms where what is supposed excludes itself: there any two are equal.
    Excluded(Term, Term),
    /// From a lemma `A(n) = P(n) ; A(n+1)`, for every n of the rounds: `A(0) = P^{i<N} ; A(N)`.
    Rounds {
        /// The number of the lemma.
        lemma: usize,
        /// n, a metavariable.
        variable: Name,
        /// P(n)
        round: Term,
        /// i
        index: Name,
        /// N
        count: Value,
    },
    /// From a lemma `A(x) ~~ P(x) ; A(f(x))` for every x that meets its hypotheses, which f never leaves:
    /// `A(s) ~~ Set_s<y> ; loop(P(y) ; Set_{f(y)}<y>)`; a refinement if the lemma is one. See [`carried_on`].
    Turns {
        /// The number of the lemma.
        lemma: usize,
        /// P(x): silent, and always stops, after a time more than 0 that is the same in all turns.
        turn: Term,
        /// The values that move on.
        moving: Vec<Moving>,
    },
    /// Taken on trust, with the reason, which the theorem shows.
    Trust(Term, Connective, Term, String),
}

impl Step {
    /// The same with other numbers for the lemmas that it uses.
    pub fn renumber(&mut self, place: &dyn Fn(usize) -> usize) {
        match self {
            Step::Lemma(lemma, _) | Step::Rounds { lemma, .. } | Step::Turns { lemma, .. } => *lemma = place(*lemma),
            Step::Cases { holds, fails, .. } => (*holds, *fails) = (place(*holds), place(*fails)),
            _ => {}
        }
    }
}

/// A value that moves on from turn to turn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Moving {
    /// The metavariable that stands for it in a lemma about one turn.
    pub variable: Name,
    /// Under which name the loop carries it on.
    pub name: Name,
    /// Its value in the first turn.
    pub start: Value,
    /// Its value in the turn after, in the metavariables.
    pub next: Value,
}

impl Moving {
    /// The name of what it is next, where several move at once.
    pub fn image(&self) -> Name {
        Name::new(&format!("{}1", self.name))
    }
}

/// The process that takes one turn after the other, and the values that move on with it, by their names: the turn and what
/// is next speak of the names. A turn that speaks of none of them is a plain loop.
pub fn going_round(turn: &Term, moving: &[Moving]) -> Term {
    let read = read_names(turn);
    if !moving.iter().any(|one| read.contains(&one.name)) {
        return Term::new(Node::Loop(turn.clone()));
    }
    let set = |value: &Value, name: &Name| Term::new(Node::Set(value.clone(), name.clone()));
    let mut parts = vec![turn.clone()];
    match moving {
        [only] => parts.push(set(&only.next, &only.name)),
        many => {
            // All at once: the images first, then each under its own name.
            parts.extend(many.iter().map(|one| set(&one.next, &one.image())));
            parts.extend(many.iter().map(|one| set(&Value::variable(&one.image()), &one.name)));
        }
    }
    let starts = moving.iter().map(|one| set(&one.start, &one.name));
    Term::seq(starts.chain([Term::new(Node::Loop(Term::seq(parts)))]))
}

/// The same for a turn and values in the metavariables that stand for what moves.
///
/// # Errors
/// Where a name would be captured.
pub fn carried_on(turn: &Term, moving: &[Moving]) -> Result<Term, Stuck> {
    let names = moving.iter().map(|one| (one.variable.clone(), Value::variable(&one.name))).collect();
    let mut moving = moving.to_vec();
    for one in &mut moving {
        one.next = one.next.substitute(&names)?;
    }
    Ok(going_round(&substitute_values(turn, &names)?, &moving))
}

/// A statement with its steps; the last step proves it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Proof {
    /// The theorems that the steps use, in order.
    pub lemmas: Vec<Lemma>,
    /// What is proved.
    pub statement: Statement,
    /// The steps, in order.
    pub steps: Vec<Step>,
}

/// A theorem that later ones use, with its own proof.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lemma {
    /// Under which it is known.
    pub name: Name,
    /// What is proved.
    pub statement: Statement,
    /// The steps, in order; they may use lemmas that come before this one.
    pub steps: Vec<Step>,
}

impl Proof {
    /// A proof by these steps alone.
    pub fn new(statement: Statement, steps: Vec<Step>) -> Proof {
        Proof { lemmas: Vec::new(), statement, steps }
    }

    /// The statements and steps of the lemmas in order, and last its own.
    pub fn parts(&self) -> impl Iterator<Item = (&Statement, &[Step])> {
        let lemmas = self.lemmas.iter().map(|lemma| (&lemma.statement, lemma.steps.as_slice()));
        lemmas.chain(std::iter::once((&self.statement, self.steps.as_slice())))
    }
}

/// A list of steps under construction: adds a step and gives its number.
#[derive(Clone, Debug, Default)]
pub struct Script {
    /// The steps so far.
    pub steps: Vec<Step>,
}

impl Script {
    /// Appends a step.
    pub fn push(&mut self, step: Step) -> StepId {
        self.steps.push(step);
        self.steps.len() - 1
    }

    /// Appends the chain of several steps; of one, that one. Steps that say that a term equals itself add nothing.
    pub fn chain(&mut self, steps: Vec<StepId>) -> StepId {
        let says = |step: &&StepId| !matches!(self.steps.get(**step), Some(Step::Reflexive(_)));
        let telling: Vec<StepId> = steps.iter().filter(says).copied().collect();
        match (telling.as_slice(), steps.as_slice()) {
            ([one], _) | ([], [one, ..]) => *one,
            _ => self.push(Step::Transitive(telling)),
        }
    }

    /// The proof of a statement by these steps.
    pub fn finish(self, statement: Statement) -> Proof {
        Proof::new(statement, self.steps)
    }
}

/// The name of the `number`-th hole of a congruence's context, from 1.
pub fn hole(number: usize) -> Name {
    Name::new(&format!("?{number}"))
}

/// What a reader may ask of a step: the steps that it uses.
impl Step {
    /// The earlier steps that this one uses.
    pub fn uses(&self) -> Vec<StepId> {
        match self {
            Step::Symmetric(of) | Step::Instance(of, _) => vec![*of],
            Step::Transitive(steps) | Step::Congruence(_, steps) => steps.clone(),
            Step::Unique { equation, .. } | Step::UniqueLoop { equation, .. } => vec![*equation],
            Step::Induction { base, step, .. } => vec![*base, *step],
            _ => Vec::new(),
        }
    }

    /// The same step with the steps that it uses under their new numbers.
    pub fn renumbered(&self, numbers: &[StepId]) -> Step {
        let new = |step: &StepId| numbers.get(*step).copied().unwrap_or(*step);
        let mut step = self.clone();
        match &mut step {
            Step::Symmetric(of) | Step::Instance(of, _) => *of = new(of),
            Step::Transitive(steps) | Step::Congruence(_, steps) => steps.iter_mut().for_each(|step| *step = new(step)),
            Step::Unique { equation, .. } | Step::UniqueLoop { equation, .. } => *equation = new(equation),
            Step::Induction { base, step, .. } => (*base, *step) = (new(base), new(step)),
            _ => {}
        }
        step
    }
}

/// Proofs compare counts symbolically; this is `n + 1`, or nothing when it has no normal form.
pub fn successor(count: &Value) -> Option<Value> {
    count.add(&Value::integer(1)).ok()
}
