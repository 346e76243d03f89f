//! What is asked of a system beside its property: what always holds, and how likely something is.

use std::collections::BTreeSet;

use num_traits::ToPrimitive;

use super::scope::{Lowerer, Metas};
use super::value::count_of;
use super::{ClaimKind, Entity, Event, Likelihood, Method, Pattern};
use crate::ast::{self, Comparison, Ident, TermKind, ValueKind};
use crate::diagnostic::{Diagnostic, Span};
use crate::name::Name;
use crate::scope::metavariables;
use crate::term::{Node, Term};
use crate::value::{Relation, Sort, Value};

/// Runs of a simulation, at least and at most.
const LEAST_RUNS: u64 = 100;
const MOST_RUNS: u64 = 1_000_000_000;

impl Lowerer<'_> {
    pub(super) fn always(
        &mut self,
        system: &ast::Ident,
        conditions: &[Comparison],
        shown: &[ast::Term],
    ) -> Option<ClaimKind> {
        let written = &system.name;
        let system = self.named(system, "system");
        let before = self.errors.len();
        let pattern = self.pattern(system.as_ref(), shown, conditions);
        if shown.is_empty() {
            let unknown = self.errors.iter_mut().skip(before).filter(|error| error.code == "P0304");
            for error in unknown {
                error.notes.push(format!(
                    "what an observer shows is named behind `when`: `prove {written} always p < 10 when At_p`"
                ));
            }
        }
        let pattern = pattern?;
        Some(ClaimKind::Always { system: system?, pattern, property: None })
    }

    /// That no part before shows by the same name.
    pub(super) fn once(&mut self, name: &Ident, before: &[Term], span: Span) -> Option<()> {
        let same = |other: &Term| matches!(other.node(), Node::Observe(known, _) if *known == name.name);
        if !before.iter().any(same) {
            return Some(());
        }
        self.fail(
            Diagnostic::error("P0324", format!("`{}` stands here twice", name.name))
                .label(span, "again here")
                .note("two things that one observer shows cannot be told apart")
                .help("declare one observer for each: `observer First(r), Second(r)`"),
        )
    }

    /// Observers whose parameters are names for what is shown in a system, or values that must be shown, and what is said
    /// of them.
    pub(super) fn pattern(
        &mut self,
        system: Option<&Name>,
        shown: &[ast::Term],
        conditions: &[Comparison],
    ) -> Option<Pattern> {
        let mut variables = BTreeSet::new();
        let mut terms = Vec::new();
        for term in shown {
            let TermKind::Apply { name, arguments, results } = &term.kind else { continue };
            self.once(name, &terms, term.span)?;
            let arity = match self.environment.entity(&name.name) {
                Some(Entity::Observer(arity)) => *arity,
                _ => {
                    self.named(name, "observer")?;
                    return None;
                }
            };
            self.shows(name, arity, arguments.len(), results.is_empty(), term.span)?;
            let lengths = self.environment.lengths(&name.name, system);
            let mut values = Vec::new();
            for (place, argument) in arguments.iter().enumerate() {
                if let ValueKind::Name(ident) = &argument.kind
                    && !ident.name.is_meta()
                    && self.environment.quantity(&ident.name).is_none()
                {
                    variables.insert(ident.name.clone());
                    self.locals.insert(ident.name.clone(), ident.span);
                    if let Some(Some(length)) = lengths.get(place) {
                        self.shapes.insert(ident.name.clone(), *length);
                        values.push(Value::variable(&ident.name));
                        continue;
                    }
                }
                values.push(self.number(argument)?);
            }
            terms.push(Term::new(Node::Observe(name.name.clone(), values)));
        }
        let lowered = self.compared(&terms, conditions)?;
        Some(Pattern { terms, variables, conditions: lowered })
    }

    /// Comparisons of numbers that are shown.
    pub(super) fn compared(
        &mut self,
        shown: &[Term],
        conditions: &[Comparison],
    ) -> Option<Vec<(Relation, Value, Value)>> {
        // What is shown may have names with `?`, too.
        let named = shown.iter().any(|term| !metavariables(term).is_empty());
        let inside = if named { self.metas } else { Metas::Shown };
        let outside = std::mem::replace(&mut self.metas, inside);
        let lowered = self.comparisons(conditions);
        self.metas = outside;
        lowered
    }

    fn comparisons(&mut self, conditions: &[Comparison]) -> Option<Vec<(Relation, Value, Value)>> {
        let mut lowered = Vec::new();
        for Comparison { relation, left, right, .. } in conditions {
            let sides = (self.number(left), self.number(right)?);
            let (first, second) = (sides.0?, sides.1);
            for (value, written) in [(&first, left), (&second, right)] {
                if value.sort() != Sort::Real {
                    return self.fail(
                        Diagnostic::error("P0401", format!("a number is needed here, but this is {}", value.sort()))
                            .label(written.span, "this is compared")
                            .help("compare its length or a component: `norm(p) > 1`, `part(p, 1) > 1`"),
                    );
                }
            }
            lowered.push((*relation, first, second));
        }
        Some(lowered)
    }

    /// Reports a number of values that does not fit.
    pub(super) fn shows(
        &mut self,
        name: &ast::Ident,
        arity: usize,
        given: usize,
        bare: bool,
        span: Span,
    ) -> Option<()> {
        if arity == given && bare {
            return Some(());
        }
        self.fail(
            Diagnostic::error(
                "P0315",
                format!("`{}` shows {}, and {given} stand here", name.name, count_of(arity, "value")),
            )
            .label(span, "this observer"),
        )
    }

    pub(super) fn likelihood(&mut self, likelihood: &ast::Likelihood) -> Option<Likelihood> {
        let system = self.named(&likelihood.system, "system");
        let event = match &likelihood.event {
            ast::Event::Satisfies(property) => Event::Satisfies(self.named(property, "property")?),
            ast::Event::Shown { first, shown, conditions, time } => {
                let deadline = self.number(time);
                let pattern = self.pattern(system.as_ref(), shown, conditions)?;
                let deadline = deadline?;
                let past = self.environment.assumptions.decide(Relation::Lss, &deadline, &Value::zero());
                if past == Some(true) {
                    return self.past(&deadline, time.span);
                }
                Event::Shown { first: *first, pattern, time: deadline }
            }
        };
        let how = likelihood.method.as_ref();
        let method = how.map(|how| match how.name.name.as_str() {
            "exact" => Method::Exact,
            "enclosed" => Method::Enclosed,
            _ => Method::Estimated,
        });
        let mut natural = |value: Option<&ast::Value>, least: u64, most: u64| match value {
            Some(value) => self.natural(value, least, most).map(Some),
            None => Some(None),
        };
        let runs = natural(how.and_then(|how| how.runs.as_ref()), LEAST_RUNS, MOST_RUNS);
        let seed = natural(how.and_then(|how| how.seed.as_ref()), 0, u64::MAX);
        Some(Likelihood { system: system?, event, method, runs: runs?, seed: seed? })
    }

    /// `where P(x <= d) >= q`: the latest time, and how likely it must be.
    pub(super) fn within(&mut self, within: &ast::Within) -> Option<(Value, Relation, Value)> {
        let time = self.number(&within.time);
        let threshold = self.chance(&within.threshold.1);
        let time = time?;
        if self.environment.assumptions.decide(Relation::Lss, &time, &Value::zero()) == Some(true) {
            return self.past(&time, within.time.span);
        }
        Some((time, within.threshold.0, threshold?))
    }

    /// A natural number in these bounds.
    fn natural(&mut self, written: &ast::Value, least: u64, most: u64) -> Option<u64> {
        let number = self.number(written)?;
        let natural = number.as_rational().filter(num_rational::BigRational::is_integer);
        let natural = natural.and_then(|number| number.to_integer().to_u64());
        if let Some(natural) = natural.filter(|natural| (least..=most).contains(natural)) {
            return Some(natural);
        }
        self.fail(
            Diagnostic::error("P0416", format!("{number} is no number of runs, and no seed"))
                .label(written.span, "this number")
                .help(format!("runs are {LEAST_RUNS} to {MOST_RUNS}; a seed is a natural number of up to 64 bits")),
        )
    }

    pub(super) fn past<T>(&mut self, time: &Value, span: Span) -> Option<T> {
        self.fail(
            Diagnostic::error("P0405", format!("the time {time} lies before the start"))
                .label(span, "this time")
                .help("times count from the start of the system, which is 0"),
        )
    }

    /// A number from 0 to 1.
    fn chance(&mut self, bound: &ast::Value) -> Option<Value> {
        let threshold = self.number(bound)?;
        let integer = |number: i64| num_rational::BigRational::from_integer(number.into());
        if threshold.as_rational().is_some_and(|number| number >= integer(0) && number <= integer(1)) {
            return Some(threshold);
        }
        self.fail(
            Diagnostic::error("P0406", format!("{threshold} is no probability"))
                .label(bound.span, "this threshold")
                .help("a probability is a number from 0 to 1, such as 9/10"),
        )
    }

    pub(super) fn likely(
        &mut self,
        likelihood: &ast::Likelihood,
        relation: Relation,
        bound: &ast::Value,
    ) -> Option<ClaimKind> {
        let lowered = self.likelihood(likelihood);
        let threshold = self.chance(bound)?;
        Some(ClaimKind::Likely { likelihood: lowered?, relation, threshold })
    }
}

impl Pattern {
    /// The names of the observers.
    pub fn observers(&self) -> BTreeSet<Name> {
        let name = |term: &Term| match term.node() {
            Node::Observe(name, _) => Some(name.clone()),
            _ => None,
        };
        self.terms.iter().filter_map(name).collect()
    }
}
