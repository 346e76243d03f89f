//! Criteria of an operator, each judged on the exact run of the system, or by what always holds of it, or by a
//! probability: met or not, by what margin, and what decides it.

pub mod blame;
mod measure;
mod nearby;
pub mod repair;
mod visit;

use std::collections::BTreeMap;

use num_rational::BigRational;
use num_traits::{ToPrimitive, Zero};

use crate::lower::{Ask, Criteria, Criterion, Environment, Likelihood, System};
use crate::name::Name;
use crate::timeline::{Follower, Timeline};
use crate::value::{Relation, Value};

pub use visit::{Leg, Visits, visits};

/// Stretches of a run that are followed to judge criteria.
pub const MOST_STRETCHES: usize = 20_000;
/// The same while other values of parameters are tried.
pub const FEW_STRETCHES: usize = 600;
/// The same at each point of a sweep.
pub const SOME_STRETCHES: usize = 3_000;

/// Whether a criterion is met.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Standing {
    /// It is not: the run shows it, or the whole interval of the probability lies on the wrong side.
    NotMet,
    /// That was not found out.
    Open,
    /// It is.
    Met,
}

impl Standing {
    /// `met`, `not met`, `open`
    pub fn spelling(self) -> &'static str {
        match self {
            Standing::Met => "met",
            Standing::NotMet => "not met",
            Standing::Open => "open",
        }
    }
}

/// What was measured, or how much room there is.
#[derive(Clone, Debug, PartialEq)]
pub enum Measure {
    /// Exactly this.
    Exact(Value),
    /// At least this.
    AtLeast(Value),
    /// At most this.
    AtMost(Value),
    /// Between these, which are rounded outward.
    Between(f64, f64),
}

impl Measure {
    /// As a number of the machine, for pictures and tables: the exact number rounded, or the middle.
    pub fn near(&self) -> Option<f64> {
        match self {
            Measure::Exact(value) | Measure::AtLeast(value) | Measure::AtMost(value) => near(value),
            Measure::Between(low, high) => Some(f64::midpoint(*low, *high)),
        }
    }

    /// Whether it is no more than a bound.
    pub fn is_bound(&self) -> bool {
        matches!(self, Measure::AtLeast(_) | Measure::AtMost(_))
    }

    /// To be read: a long number rounded, and said to be.
    pub fn readable(&self) -> String {
        let (word, value) = match self {
            Measure::Exact(value) => ("", value),
            Measure::AtLeast(value) => ("at least ", value),
            Measure::AtMost(value) => ("at most ", value),
            Measure::Between(..) => return self.to_string(),
        };
        if value.to_string().len() <= LONGEST {
            return self.to_string();
        }
        match value.components() {
            Some(parts) => rounded_vector(&parts).map(|vector| format!("{word}{vector} (rounded)")),
            None => rounded(value).map(|number| format!("{word}{number} (rounded)")),
        }
        .unwrap_or_else(|| self.to_string())
    }
}

fn rounded(value: &Value) -> Option<String> {
    let near = near(value)?;
    // Of what is nearly 0 the first digits, so that it is not taken for 0.
    Some(if near != 0.0 && near.abs() < 1e-4 { format!("{near:.3e}") } else { format!("{near:.6}") })
}

fn rounded_vector(parts: &[Value]) -> Option<String> {
    let parts = parts.iter().map(rounded).collect::<Option<Vec<_>>>()?;
    Some(format!("({})", parts.join(",")))
}

/// The longest exact number that is read as it is, in letters.
const LONGEST: usize = 60;

/// A value rounded to a number of the machine; none of what is no number, or has roots of roots.
pub fn near(value: &Value) -> Option<f64> {
    let middle = || value.enclosure().map(|(low, high)| (low + high) / BigRational::from_integer(2.into()));
    value.as_rational().or_else(middle)?.to_f64()
}

/// A number of the machine, exactly; with a power of ten where it has many zeros.
pub(crate) fn digits(number: f64) -> String {
    let size = number.abs();
    if size != 0.0 && !(1e-6..1e15).contains(&size) { format!("{number:e}") } else { number.to_string() }
}

impl std::fmt::Display for Measure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Measure::Exact(value) => write!(f, "{value}"),
            Measure::AtLeast(value) => write!(f, "at least {value}"),
            Measure::AtMost(value) => write!(f, "at most {value}"),
            Measure::Between(low, high) if low == high => write!(f, "{} (rounded)", digits(*low)),
            Measure::Between(low, high) => write!(f, "between {} and {}", digits(*low), digits(*high)),
        }
    }
}

/// The moment that decides a criterion.
#[derive(Clone, Debug, PartialEq)]
pub struct Moment {
    /// The stretch of the run.
    pub stretch: usize,
    /// From when on.
    pub from: Value,
    /// Until when, where it is a span of time.
    pub to: Option<Value>,
    /// The leg, from 0, where it is about one.
    pub leg: Option<usize>,
}

/// What came of one criterion.
#[derive(Clone, Debug)]
pub struct Finding {
    /// What its value is called.
    pub name: Name,
    /// What was asked.
    pub text: String,
    /// Whether it is met.
    pub standing: Standing,
    /// What was measured.
    pub value: Option<Measure>,
    /// How much room there is; less than 0 where it is not met.
    pub margin: Option<Measure>,
    /// The moment that decides it.
    pub moment: Option<Moment>,
    /// By what method, where that is a choice; and what else there is to say.
    pub notes: Vec<String>,
    /// What was taken on trust.
    pub trusted: Vec<String>,
    /// Where two things come too near between two looks, if each goes straight from one place to the next.
    pub passing: Option<Passing>,
    /// Whether it is met for want of anything shown that it speaks of.
    pub vacuous: bool,
}

/// Two looks at which two things are far enough apart, and the least distance on the straight way between them.
#[derive(Clone, Debug, PartialEq)]
pub struct Passing {
    /// When the second look is.
    pub next: Value,
    /// About how near they come.
    pub near: f64,
}

impl Passing {
    /// That what is shown says nothing of what is between.
    fn note(&self) -> String {
        let (next, near) = (&self.next, digits(self.near));
        format!(
            "going straight from what is shown before {next} to what is shown then comes as near as {near}: only what is \
             shown counts"
        )
    }
}

impl Finding {
    fn new(criterion: &Criterion) -> Finding {
        Finding {
            name: criterion.name.clone(),
            text: criterion.text.clone(),
            standing: Standing::Open,
            value: None,
            margin: None,
            moment: None,
            notes: Vec::new(),
            trusted: Vec::new(),
            passing: None,
            vacuous: false,
        }
    }

    /// Notes that nothing is shown of what it speaks of.
    fn shows_nothing(&mut self) {
        self.vacuous = true;
        self.notes.push("the two are never shown together".to_string());
    }

    /// The margin, less than which nothing is known.
    pub fn exact_margin(&self) -> Option<&Value> {
        match &self.margin {
            Some(Measure::Exact(value)) => Some(value),
            _ => None,
        }
    }
}

/// A probability with how it was found.
#[derive(Clone, Debug)]
pub struct Likely {
    /// Its lower bound.
    pub low: f64,
    /// Its upper bound.
    pub high: f64,
    /// The probability itself, where it is known to be this rational.
    pub number: Option<BigRational>,
    /// Whether the bounds are proved.
    pub sure: bool,
    /// `exact`, `enclosed`, `estimated`
    pub method: &'static str,
    /// What was taken on trust.
    pub trusted: Vec<String>,
}

/// Finds a probability, as closely as is needed to compare it so; gives the reasons where there is none.
pub type Chances<'a> =
    dyn Fn(&Likelihood, &Environment, (Relation, &BigRational)) -> Result<Likely, Vec<String>> + Sync + 'a;

/// What judging needs beside the criteria.
#[derive(Clone, Copy)]
pub struct Judge<'a> {
    /// Finds probabilities.
    pub chances: &'a Chances<'a>,
    /// Whether the user wants it to stop.
    pub interrupted: &'a dyn Fn() -> bool,
    /// Stretches of a run that are followed.
    pub stretches: usize,
    /// Whether an invariant is looked for where the run does not decide.
    pub invariants: bool,
}

/// Criteria judged, with the run that they were judged on.
#[derive(Clone, Debug)]
pub struct Judged {
    /// What came of each, in order.
    pub findings: Vec<Finding>,
    /// The run, as far as it was followed.
    pub run: Timeline,
    /// Where it comes by.
    pub visits: Visits,
}

impl Judged {
    /// The worst of all.
    pub fn standing(&self) -> Standing {
        self.findings.iter().map(|finding| finding.standing).min().unwrap_or(Standing::Open)
    }
}

impl Judge<'_> {
    /// Judges all criteria.
    pub fn judge(&self, criteria: &Criteria, environment: &Environment) -> Judged {
        self.judge_some(criteria, environment, None)
    }

    /// Judges one criterion, by its name, and follows the run no further than its standing needs.
    pub fn one(&self, criteria: &Criteria, environment: &Environment, name: &Name) -> Option<Finding> {
        self.judge_some(criteria, environment, Some(name)).findings.into_iter().next()
    }

    fn judge_some(&self, criteria: &Criteria, environment: &Environment, only: Option<&Name>) -> Judged {
        let wanted = |criterion: &&Criterion| only.is_none_or(|name| criterion.name == *name);
        let chosen: Vec<&Criterion> = criteria.all.iter().filter(wanted).collect();
        let nothing = Timeline {
            stretches: Vec::new(),
            ending: crate::timeline::Ending::Unknown("it was not followed".to_string()),
            at: BTreeMap::new(),
            known: crate::assumption::Assumptions::default(),
        };
        let Some(system) = environment.system(&criteria.system) else {
            return Judged { findings: Vec::new(), run: nothing, visits: Visits::default() };
        };
        let (run, visits, proved) = if chosen.iter().all(|one| matches!(one.kind, Ask::Probability { .. })) {
            (nothing, Visits::default(), Vec::new())
        } else {
            self.followed(criteria, system, environment, &chosen, only.is_some())
        };
        let scene = measure::Scene { judge: self, criteria, environment, system, run: &run, visits: &visits };
        let before = |criterion: &Criterion| proved.iter().find(|one| one.name == criterion.name).cloned();
        let findings = chosen.iter().map(|criterion| before(criterion).unwrap_or_else(|| scene.finding(criterion)));
        Judged { findings: findings.collect(), run, visits }
    }

    /// The run as far as the criteria need it, with what was proved of all that is to come.
    fn followed(
        &self,
        criteria: &Criteria,
        system: &System,
        environment: &Environment,
        chosen: &[&Criterion],
        quick: bool,
    ) -> (Timeline, Visits, Vec<Finding>) {
        let term = system.term(&environment.definitions);
        let mut follower = Follower::new(&term, &environment.definitions);
        let all = chosen.iter().any(|criterion| {
            matches!(
                criterion.kind,
                Ask::Clearance { .. } | Ask::Leg { every: true, .. } | Ask::Round { every: true, .. }
            )
        });
        let horizon = chosen.iter().filter_map(|criterion| match &criterion.kind {
            Ask::Battery { time: Some(time), .. } => Some(time.clone()),
            _ => None,
        });
        let horizon = horizon.max().unwrap_or_else(BigRational::zero);
        let (mut most, mut asked, mut proved) = (64, false, Vec::new());
        loop {
            follower.follow(most.min(self.stretches), self.interrupted);
            let found = visits(follower.run(), &criteria.goals, &Value::rational(criteria.radius.clone()));
            let late = follower.run().known_until().and_then(|time| time.as_rational());
            let enough = !all && found.first_round_is_over() && late.is_some_and(|time| time >= horizon);
            let scene =
                measure::Scene { judge: self, criteria, environment, system, run: follower.run(), visits: &found };
            let decided = |one: &&&Criterion| scene.on_the_run(one).is_some_and(|one| one.standing != Standing::Open);
            let enough = enough || ((quick || most >= FEW_STRETCHES) && chosen.iter().all(|one| decided(&one)));
            let over = follower.over() || most >= self.stretches;
            // Where nothing else is open a proof is sooner found than more of a run that only goes on.
            if !enough && (over || most >= FEW_STRETCHES) && !asked {
                asked = true;
                let open: Vec<&Criterion> = chosen.iter().filter(|one| !decided(one)).copied().collect();
                proved = scene.by_turns(&open);
                if self.invariants && !over {
                    let rest = open.iter().filter(|one| proved.iter().all(|found| found.name != one.name));
                    let rest: Option<Vec<Finding>> = rest.map(|one| scene.by_invariant(one)).collect();
                    if let Some(rest) = rest {
                        proved.extend(rest);
                        return (follower.run().clone(), found, proved);
                    }
                }
            }
            if over || enough {
                return (follower.run().clone(), found, proved);
            }
            most *= 2;
        }
    }
}
