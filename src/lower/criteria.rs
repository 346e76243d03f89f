//! What an operator asks of a mission, and parameters that run through values.

use std::sync::Arc;

use num_rational::BigRational;
use num_traits::{Signed, Zero};

use super::scope::{Lowerer, Metas};
use super::{ClaimKind, Environment, Lowered, Pattern};
use crate::ast::{self, Clause, ClauseKind};
use crate::diagnostic::{Diagnostic, Span};
use crate::name::Name;
use crate::term::{Node, Term};
use crate::value::{Relation, Value};

/// What an operator asks of a mission.
#[derive(Clone, Debug)]
pub struct Criteria {
    /// Their name.
    pub name: Name,
    /// The system.
    pub system: Name,
    /// Where the robot must come by, in order.
    pub goals: Vec<Goal>,
    /// How near a goal counts as there; 0 where it is not said.
    pub radius: BigRational,
    /// What is asked, one by one.
    pub all: Vec<Criterion>,
    /// As written, for other values of the parameters.
    pub written: Arc<ast::Criteria>,
}

/// A place to come by: an observer and the values to show.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Goal {
    /// The observer.
    pub observer: Name,
    /// What it must show, or show something near of.
    pub values: Vec<Value>,
}

impl std::fmt::Display for Goal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", Term::new(Node::Observe(self.observer.clone(), self.values.clone())))
    }
}

/// One thing that is asked.
#[derive(Clone, Debug)]
pub struct Criterion {
    /// What its value is called: `round`, `leg1`, `clearance`.
    pub name: Name,
    /// In words.
    pub text: String,
    /// What it asks.
    pub kind: Ask,
}

/// The kinds of criteria.
#[derive(Clone, Debug)]
pub enum Ask {
    /// The goal of this number is approached to within the radius.
    Radius(usize),
    /// The leg to the goal of this number takes no longer.
    Leg {
        /// The number of the goal, from 0.
        goal: usize,
        /// In every round, not the first alone.
        every: bool,
        /// The longest time.
        limit: BigRational,
    },
    /// From the start, or the last goal, to the last goal.
    Round {
        /// In every round, not the first alone.
        every: bool,
        /// The longest time.
        limit: BigRational,
    },
    /// Two things stay apart.
    Clearance {
        /// Whether they must stay farther apart than that.
        strict: bool,
        /// How far.
        limit: BigRational,
        /// What shows where they are; each with as many values.
        between: [(Name, usize); 2],
    },
    /// A resource lasts.
    Battery {
        /// What there is at the start, and at most.
        start: BigRational,
        /// What is used in a unit of time, always or while something is shown.
        rates: Vec<(BigRational, Option<Name>)>,
        /// What must be left.
        keep: BigRational,
        /// For how long; for the first round where it is not said.
        time: Option<BigRational>,
    },
    /// Something is likely enough.
    Probability {
        /// What.
        likelihood: super::Likelihood,
        /// How it compares.
        relation: Relation,
        /// With what.
        threshold: BigRational,
    },
}

impl Environment {
    /// Criteria as they are with these declarations.
    ///
    /// # Errors
    /// What is wrong with them.
    pub fn criteria(&self, written: &Arc<ast::Criteria>) -> Result<Criteria, Vec<Diagnostic>> {
        let mut lowerer = Lowerer::new(self, Metas::Law);
        let lowered = lowerer.criteria(written);
        lowerer.finish(lowered)
    }

    /// Lowers a question within a sweep.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn question(&self, item: &ast::Item, text: &str) -> Result<Lowered, Vec<Diagnostic>> {
        self.lower_item(item, text)
    }
}

/// What the clauses come to, on the way.
#[derive(Default)]
struct Clauses {
    goals: Vec<Goal>,
    radius: Option<BigRational>,
    all: Vec<Criterion>,
    /// Whether goals were given, right or wrong.
    named_goals: bool,
}

impl Clauses {
    /// Each goal is to be reached, whatever else is asked: where no radius, leg or round asks for it, it is asked for by itself.
    fn ask_for_goals(&mut self) {
        let asked = |place: usize| {
            self.all.iter().any(|one| match &one.kind {
                Ask::Radius(goal) | Ask::Leg { goal, .. } => *goal == place,
                Ask::Round { .. } => true,
                _ => false,
            })
        };
        let missing: Vec<usize> = (0..self.goals.len()).filter(|place| !asked(*place)).collect();
        for place in missing {
            let text = format!("{} is reached", self.goals[place]);
            self.push("goal", text, Ask::Radius(place));
        }
    }

    /// A name that is not taken: `clearance`, `clearance2`.
    fn push(&mut self, word: &str, text: String, kind: Ask) {
        let taken = |name: &str| self.all.iter().any(|one| one.name.as_str() == name);
        let mut name = word.to_string();
        let mut number = 1;
        while taken(&name) {
            number += 1;
            name = format!("{word}{number}");
        }
        self.all.push(Criterion { name: Name::new(&name), text, kind });
    }
}

impl Lowerer<'_> {
    pub(super) fn criteria(&mut self, written: &Arc<ast::Criteria>) -> Option<Criteria> {
        let system = self.named(&written.system, "system");
        let mut found = Clauses::default();
        for clause in &written.clauses {
            if let ClauseKind::Goals(terms) = &clause.kind {
                found.named_goals = true;
                found.goals.extend(terms.iter().filter_map(|term| self.goal(term)));
            }
        }
        for clause in &written.clauses {
            self.locals.clear();
            self.clause(clause, &mut found);
        }
        if self.errors.is_empty() {
            found.ask_for_goals();
        }
        if found.all.is_empty() && self.errors.is_empty() {
            return self.fail(
                Diagnostic::error("P0410", "these criteria ask for nothing")
                    .label(written.name.span, "nothing is asked")
                    .help("add what is asked: `goals At_10`, `radius 1/10`, `round within 20`"),
            );
        }
        let radius = found.radius.unwrap_or_else(BigRational::zero);
        let name = written.name.name.clone();
        Some(Criteria { name, system: system?, goals: found.goals, radius, all: found.all, written: written.clone() })
    }

    fn goal(&mut self, term: &ast::Term) -> Option<Goal> {
        let Pattern { terms, variables, .. } = self.pattern(None, std::slice::from_ref(term), &[])?;
        if let Some(name) = variables.iter().next() {
            let known = self.environment.quantities().map(|(name, _)| name.as_str()).collect::<Vec<_>>();
            let ident = ast::Ident { name: name.clone(), span: term.span };
            self.unknown("P0304", "value", &ident, known.into_iter(), "a goal is a place with its values: `At_10`");
            return None;
        }
        let Node::Observe(observer, values) = terms.first()?.node() else { return None };
        if let Some(value) = values.iter().find(|value| !value.variables().is_empty()) {
            return self.no_number(term.span, value);
        }
        Some(Goal { observer: observer.clone(), values: values.clone() })
    }

    pub(super) fn no_number<T>(&mut self, span: Span, value: &Value) -> Option<T> {
        let names: Vec<String> = value.variables().iter().map(ToString::to_string).collect();
        let text = format!("{value} is no number, and criteria are about numbers");
        let diagnostic = Diagnostic::error("P0409", text).label(span, "must be a number");
        self.fail(match names.first() {
            Some(name) => diagnostic.help(format!("give it a value: `param {name} = 1`")),
            None => diagnostic,
        })
    }

    /// A number, at least 0; positive if asked for.
    fn limit(&mut self, value: &ast::Value, what: &str, positive: bool) -> Option<BigRational> {
        let lowered = self.number(value)?;
        let Some(number) = lowered.as_rational() else { return self.no_number(value.span, &lowered) };
        let past = if positive { !number.is_positive() } else { number.is_negative() };
        if past {
            let least = if positive { "more than 0" } else { "0 or more" };
            let text = format!("{what} of {lowered} cannot be met");
            return self.fail(Diagnostic::error("P0408", text).label(value.span, format!("must be {least}")).help(
                if positive { "times count from the start, which is 0" } else { "a distance or a charge is 0 or more" },
            ));
        }
        Some(number)
    }

    fn clause(&mut self, clause: &Clause, found: &mut Clauses) -> Option<()> {
        let needs_goals = match &clause.kind {
            ClauseKind::Radius(_) | ClauseKind::Leg { .. } | ClauseKind::Round { .. } => true,
            ClauseKind::Battery { time, .. } => time.is_none(),
            _ => false,
        };
        if needs_goals && found.goals.is_empty() {
            // A goal that is wrong has been reported.
            if found.named_goals {
                return None;
            }
            return self.fail(
                Diagnostic::error("P0411", "this is about goals, and none is given")
                    .label(clause.span, "which goals?")
                    .help(match &clause.kind {
                        ClauseKind::Battery { .. } => {
                            "say how long it must last, `for 30`, or where the robot must come by: `goals At_10, At_0`"
                        }
                        _ => "say where the robot must come by, in order: `goals At_10, At_0`",
                    }),
            );
        }
        match &clause.kind {
            ClauseKind::Goals(_) => {}
            ClauseKind::Radius(value) => {
                let radius = self.limit(value, "a radius", false)?;
                if found.radius.is_some() {
                    return self.fail(
                        Diagnostic::error("P0413", "there are two radii here")
                            .label(value.span, "the second radius")
                            .help("one radius says when a goal is reached: leave one, or write criteria for each"),
                    );
                }
                for place in 0..found.goals.len() {
                    let text = format!("radius {} at {}", number(&radius), found.goals[place]);
                    found.push("radius", text, Ask::Radius(place));
                }
                found.radius = Some(radius);
            }
            ClauseKind::Leg { every, to, limit } => self.legs(*every, to.as_ref(), limit, found)?,
            ClauseKind::Round { every, limit } => {
                let limit = self.limit(limit, "a deadline", true)?;
                let word = if *every { "every round" } else { "round" };
                let text = format!("{word} within {}", number(&limit));
                found.push("round", text, Ask::Round { every: *every, limit });
            }
            ClauseKind::Clearance { strict, limit, between } => self.clearance(*strict, limit, between, found)?,
            ClauseKind::Battery { start, rates, keep, time } => {
                self.battery(start, rates, keep, time.as_ref(), found)?;
            }
            ClauseKind::Probability(likelihood, relation, threshold) => {
                let lowered = self.likely(likelihood, *relation, threshold)?;
                let ClaimKind::Likely { likelihood, relation, threshold } = lowered else { return None };
                let text = format!("probability {} {} {threshold}", event(&likelihood.event), relation.symbol());
                let threshold = threshold.as_rational()?;
                found.push("probability", text, Ask::Probability { likelihood, relation, threshold });
            }
        }
        Some(())
    }

    fn legs(&mut self, every: bool, to: Option<&ast::Term>, limit: &ast::Value, found: &mut Clauses) -> Option<()> {
        let limit = self.limit(limit, "a deadline", true)?;
        let wanted = match to {
            None => None,
            Some(term) => {
                let goal = self.goal(term)?;
                if !found.goals.contains(&goal) {
                    let known: Vec<String> = found.goals.iter().map(ToString::to_string).collect();
                    return self.fail(
                        Diagnostic::error("P0412", format!("`{goal}` is not one of the goals"))
                            .label(term.span, "no leg leads there")
                            .help(format!("the goals are {}", known.join(", "))),
                    );
                }
                Some(goal)
            }
        };
        for place in 0..found.goals.len() {
            let goal = &found.goals[place];
            if wanted.as_ref().is_some_and(|wanted| wanted != goal) {
                continue;
            }
            let word = if every { "every leg" } else { "leg" };
            let text = format!("{word} to {goal} within {}", number(&limit));
            found.push(&format!("leg{}", place + 1), text, Ask::Leg { goal: place, every, limit: limit.clone() });
        }
        Some(())
    }

    fn clearance(
        &mut self,
        strict: bool,
        limit: &ast::Value,
        between: &[ast::Ident; 2],
        found: &mut Clauses,
    ) -> Option<()> {
        let limit = self.limit(limit, "a clearance", false);
        let [one, other] = between;
        let (first, second) = (self.named(one, "observer"), self.named(other, "observer"));
        let (first, second) = (first?, second?);
        let arity = |name: &Name| match self.environment.entity(name) {
            Some(super::Entity::Observer(arity)) => *arity,
            _ => 0,
        };
        let (many, others) = (arity(&first), arity(&second));
        if many != others || many == 0 || first == second {
            let text = format!("`{first}` shows {many} values and `{second}` shows {others}");
            let text = if first == second { format!("`{first}` stands here twice") } else { text };
            return self.fail(
                Diagnostic::error("P0413", text)
                    .label(one.span.to(other.span), "there is no distance between these")
                    .help("a distance is between two observers that show a place each: `between At, Rock`"),
            );
        }
        let limit = limit?;
        let sign = if strict { ">" } else { ">=" };
        let text = format!("clearance {sign} {} between {first}, {second}", number(&limit));
        found.push("clearance", text, Ask::Clearance { strict, limit, between: [(first, many), (second, many)] });
        Some(())
    }

    fn battery(
        &mut self,
        start: &ast::Value,
        rates: &[(ast::Value, Option<ast::Ident>)],
        keep: &ast::Value,
        time: Option<&ast::Value>,
        found: &mut Clauses,
    ) -> Option<()> {
        let keep_span = keep.span;
        // With parameters it is a question, and a change of them may be the answer.
        let plain = [start, keep].iter().all(|value| matches!(value.kind, ast::ValueKind::Number(_)));
        let start = self.limit(start, "a charge", false);
        let keep = self.limit(keep, "a charge", false);
        let mut lowered = Vec::new();
        for (rate, shown) in rates {
            let value = self.number(rate)?;
            let Some(rate) = value.as_rational() else { return self.no_number(rate.span, &value) };
            let shown = match shown {
                Some(observer) => Some(self.named(observer, "observer")?),
                None => None,
            };
            lowered.push((rate, shown));
        }
        let time = match time {
            Some(time) => Some(self.limit(time, "a time", true)?),
            None => None,
        };
        let (start, keep) = (start?, keep?);
        if plain && start < keep {
            let text = format!("a battery of {} is less than the {} to keep", number(&start), number(&keep));
            return self.fail(
                Diagnostic::error("P0408", text)
                    .label(keep_span, "more than there is at the start")
                    .help("it cannot be met by any mission: keep less, or begin with more"),
            );
        }
        let text = format!("battery {} keeps {}", number(&start), number(&keep));
        found.push("battery", text, Ask::Battery { start, rates: lowered, keep, time });
        Some(())
    }
}

/// What is to be likely, as it is written.
fn event(event: &super::Event) -> String {
    let super::Event::Shown { first, pattern, time } = event else { return String::new() };
    let (word, at) = if *first { ("reaching", "within") } else { ("showing", "at") };
    let shown: Vec<String> = pattern.terms.iter().map(ToString::to_string).collect();
    let compared = |(relation, left, right): &(Relation, Value, Value)| format!("{left} {} {right}", relation.symbol());
    let conditions: Vec<String> = pattern.conditions.iter().map(compared).collect();
    let conditions = if conditions.is_empty() { String::new() } else { format!(" where {}", conditions.join(", ")) };
    format!("of {word} {}{conditions} {at} {time}", shown.join(", "))
}

/// A number as it is written.
fn number(value: &BigRational) -> Value {
    Value::rational(value.clone())
}
