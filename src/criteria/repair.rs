//! What would repair a criterion: one parameter, to which value, or two; each tried by judging again.

mod deadline;
mod hits;
mod narrow;
mod pairs;
mod sensitivity;
mod wider;

use std::collections::BTreeMap;

use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use super::nearby::{Formula, nearby};
use super::{Chances, Finding, Judge, Judged, Measure, Standing};
use crate::lower::{Ask, Criteria, Environment, Likelihood};
use crate::name::Name;
use crate::value::{Relation, Value};

pub use sensitivity::Sensitivity;
use wider::points;

/// Numbers with a larger denominator are not simple.
const MOST_DENOMINATOR: i64 = 10_000;
/// Halvings of an interval in which the least change lies.
const HALVINGS: usize = 20;
/// Parameters that are tried, at most.
pub const MOST_PARAMETERS: usize = 10;
/// The parts of a change in which a smaller one is looked for.
const PARTS: i64 = 12;
/// Stretches of a run that are followed while a change is looked for that is proved in the end.
const MOST_SEARCHED: usize = 200;
/// Pairs of parameters that are tried, at most.
const MOST_PAIRS: usize = 15;

/// Other values for some parameters.
pub type Point = Vec<(Name, BigRational)>;

/// What a change is to meet: one criterion, or all of them.
type Goal<'g> = Option<&'g Name>;

/// A change that repairs a criterion; it was judged again with it.
#[derive(Clone, Debug)]
pub struct Repair {
    /// Each parameter with its present value and the one that repairs it.
    pub changes: Vec<(Name, BigRational, BigRational)>,
    /// What comes of the criterion then.
    pub after: Finding,
    /// Other criteria that were met, and are not known to be any more.
    pub breaks: Vec<Name>,
    /// Those of them that are open.
    pub open: Vec<Name>,
    /// Those of them that are met by a jump between two looks alone.
    pub jumps: Vec<Name>,
    /// By how little the change may not be less.
    pub least: Option<BigRational>,
    /// A value that is only just not enough.
    pub not_at: Option<BigRational>,
    /// The margin as a formula of the parameter near its present value, where the value was solved from it.
    pub formula: Option<Value>,
}

impl Repair {
    /// Whether it leaves all criteria met that are met now.
    pub fn is_harmless(&self) -> bool {
        self.breaks.is_empty()
    }
}

/// What to do about the criteria that are not met.
#[derive(Clone, Debug, Default)]
pub struct Advice {
    /// About each.
    pub feedback: Vec<Feedback>,
    /// Changes with which every criterion is met, where several are not.
    pub all: Vec<Repair>,
}

/// What to do about one criterion.
#[derive(Clone, Debug)]
pub struct Feedback {
    /// The criterion.
    pub name: Name,
    /// What decides it.
    pub blame: Vec<String>,
    /// The limit at which it would be met, as a line to write.
    pub limit: Option<String>,
    /// Changes of one parameter.
    pub single: Vec<Repair>,
    /// Changes of two, where one is not enough.
    pub pairs: Vec<Repair>,
    /// The parameters that were tried.
    pub tried: Vec<Name>,
}

/// A criterion and all that is needed to try other values.
pub struct Workshop<'a> {
    /// Judges.
    pub judge: Judge<'a>,
    /// Finds probabilities no more closely than is needed to tell whether a criterion is met.
    pub roughly: &'a Chances<'a>,
    /// The criteria.
    pub criteria: &'a Criteria,
    /// The declarations as they are.
    pub environment: &'a Environment,
    /// What came of the criteria as they are.
    pub judged: &'a Judged,
    /// The parameters that may be changed, with their values.
    pub parameters: &'a [(Name, BigRational)],
    /// For each parameter, the margins upward and downward of its present value.
    formulas: BTreeMap<Name, [BTreeMap<Name, Formula>; 2]>,
}

impl<'a> Workshop<'a> {
    /// A workshop for criteria that were judged.
    pub fn new(
        judge: Judge<'a>,
        roughly: &'a Chances<'a>,
        criteria: &'a Criteria,
        environment: &'a Environment,
        judged: &'a Judged,
        parameters: &'a [(Name, BigRational)],
    ) -> Workshop<'a> {
        let mut workshop =
            Workshop { judge, roughly, criteria, environment, judged, parameters, formulas: BTreeMap::new() };
        // Only a margin that is known exactly may be a formula of a parameter.
        let exact = judged.findings.iter().any(|finding| finding.exact_margin().is_some())
            || judged.visits.closest.iter().any(Option::is_some);
        if exact && !judged.run.stretches.is_empty() {
            for (name, value) in parameters.iter().take_while(|_| !(judge.interrupted)()) {
                let sides = [true, false].map(|up| nearby(value, up, &|there| workshop.margins(name, there)));
                workshop.formulas.insert(name.clone(), sides);
            }
        }
        workshop
    }

    /// The margins that are exact when one parameter has another value, by criterion; and by which the run comes within
    /// the radius of each goal, under names that no source text can spell.
    fn margins(&self, parameter: &Name, value: &BigRational) -> Option<BTreeMap<Name, BigRational>> {
        let (criteria, environment) = self.elsewhere(&[(parameter.clone(), value.clone())])?;
        let never = |_: &Likelihood, _: &Environment, _: (Relation, &BigRational)| Err(Vec::new());
        let judged = Judge { chances: &never, ..self.judge }.judge(&criteria, &environment);
        let exact = |finding: &Finding| Some((finding.name.clone(), finding.exact_margin()?.as_rational()?));
        let nearest = judged.visits.closest.iter().enumerate().filter_map(|(goal, closest)| {
            let near = closest.as_ref()?.0.length()?.as_rational()?;
            Some((Name::new(&format!("!nearest{goal}")), &criteria.radius - near))
        });
        Some(judged.findings.iter().filter_map(exact).chain(nearest).collect())
    }

    /// The criteria with other values; none where the declarations do not allow them.
    pub fn elsewhere(&self, point: &[(Name, BigRational)]) -> Option<(Criteria, Environment)> {
        let instead: BTreeMap<Name, Option<Value>> =
            point.iter().map(|(name, value)| (name.clone(), Some(Value::rational(value.clone())))).collect();
        let environment = self.environment.varied(&instead).ok()?;
        let criteria = environment.criteria(&self.criteria.written).ok()?;
        Some((criteria, environment))
    }

    /// Whether the goal is met, or may be: a clearance that a run keeps which only goes on is proved once, at the end.
    fn met(&self, goal: Goal<'_>, point: &[(Name, BigRational)]) -> bool {
        match self.standing(goal, point) {
            Some(Standing::Met) => true,
            Some(Standing::Open) => self.goes_on(goal),
            _ => false,
        }
    }

    fn goes_on(&self, goal: Goal<'_>) -> bool {
        let clearance = |name: &Name| {
            let kind = self.criteria.all.iter().find(|one| one.name == *name).map(|one| &one.kind);
            matches!(kind, Some(Ask::Clearance { .. }))
        };
        goal.is_some_and(clearance)
    }

    fn standing(&self, goal: Goal<'_>, point: &[(Name, BigRational)]) -> Option<Standing> {
        let (criteria, environment) = self.elsewhere(point)?;
        let mut judge = Judge { chances: self.roughly, ..self.judge };
        if self.goes_on(goal) {
            judge.stretches = judge.stretches.min(MOST_SEARCHED);
        }
        match goal {
            Some(name) => {
                let finding = judge.one(&criteria, &environment, name)?;
                let none = finding.passing.is_some() || self.hides(&finding);
                Some(if none { Standing::NotMet } else { finding.standing })
            }
            None => {
                // A clearance of a run that only goes on is proved once, at the end.
                let later = |finding: &Finding| finding.standing == Standing::Open && self.goes_on(Some(&finding.name));
                let standing = |finding: &Finding| match later(finding) {
                    _ if self.jumps(finding) || self.hides(finding) => Standing::NotMet,
                    true => Standing::Met,
                    false => finding.standing,
                };
                judge.judge(&criteria, &environment).findings.iter().map(standing).min()
            }
        }
    }

    /// Whether a change lets something jump over what it is to be kept away from, which is no repair.
    fn jumps(&self, finding: &Finding) -> bool {
        let before = self.judged.findings.iter().find(|one| one.name == finding.name);
        finding.passing.is_some() && before.is_none_or(|before| before.passing.is_none())
    }

    /// Whether a change leaves nothing to be seen of what a criterion speaks of, which is no repair either.
    fn hides(&self, finding: &Finding) -> bool {
        let before = self.judged.findings.iter().find(|one| one.name == finding.name);
        finding.vacuous && !before.is_some_and(|before| before.vacuous)
    }

    /// Judges everything with a change: a repair if the goal is met then.
    fn repair(&self, goal: Goal<'_>, point: &[(Name, BigRational)]) -> Option<Repair> {
        let (criteria, environment) = self.elsewhere(point)?;
        let judged = Judge { invariants: true, ..self.judge }.judge(&criteria, &environment);
        let after = match goal {
            Some(name) => judged.findings.iter().find(|finding| finding.name == *name)?,
            None => judged.findings.iter().min_by_key(|finding| finding.standing)?,
        };
        let hidden = judged.findings.iter().any(|finding| self.hides(finding));
        if hidden || after.standing != Standing::Met || (goal.is_some() && after.passing.is_some()) {
            return None;
        }
        let before = |name: &Name| self.judged.findings.iter().find(|one| one.name == *name);
        let met_before = |name: &Name| before(name).is_some_and(|one| one.standing == Standing::Met);
        let broken = |one: &&Finding| self.jumps(one) || (one.standing != Standing::Met && met_before(&one.name));
        let breaks = judged.findings.iter().filter(broken);
        let open = breaks.clone().filter(|one| one.standing == Standing::Open).map(|one| one.name.clone()).collect();
        let jumps = breaks.clone().filter(|one| one.standing == Standing::Met).map(|one| one.name.clone()).collect();
        let breaks = breaks.map(|one| one.name.clone()).collect();
        let present = |name: &Name| self.parameters.iter().find(|(other, _)| other == name).map(|(_, value)| value);
        let changes =
            point.iter().filter_map(|(name, value)| Some((name.clone(), present(name)?.clone(), value.clone())));
        let (changes, after) = (changes.collect(), after.clone());
        Some(Repair { changes, after, breaks, open, jumps, least: None, not_at: None, formula: None })
    }

    /// A repair that breaks nothing.
    fn harmless(&self, goal: Goal<'_>, point: &[(Name, BigRational)]) -> Option<Repair> {
        let repair = if self.met(goal, point) { self.repair(goal, point) } else { None };
        repair.filter(Repair::is_harmless)
    }

    /// What to do about criteria that are not met, each with what decides it.
    pub fn advice(&self, failing: Vec<(&Finding, Vec<String>)>) -> Advice {
        let hits = self.hits(failing.iter().any(|(finding, _)| self.is_arrival(finding)));
        let mut singles: Vec<Vec<Repair>> = failing.iter().map(|(finding, _)| self.single(finding, &hits)).collect();
        let points = points(&singles);
        for ((finding, _), single) in failing.iter().zip(&mut singles) {
            self.repaired_by_others(&finding.name, &points, single);
            if !single.iter().any(Repair::is_harmless) {
                let wider = self.wider(Some(&finding.name), single);
                single.extend(wider);
            }
        }
        let several = failing.len() > 1;
        let mut feedback: Vec<Feedback> = failing
            .into_iter()
            .zip(singles)
            .map(|((finding, blame), single)| self.feedback(finding, blame, single))
            .collect();
        let all = if several { self.all_at_once(&feedback) } else { Vec::new() };
        self.brought_nearer(&mut feedback, &all);
        Advice { feedback, all }
    }

    /// Changes of one parameter that are found by itself.
    fn single(&self, finding: &Finding, hits: &[[Vec<BigRational>; 2]]) -> Vec<Repair> {
        let mut single = Vec::new();
        for ((name, value), hits) in self.parameters.iter().zip(hits) {
            if (self.judge.interrupted)() {
                break;
            }
            for (up, hits) in [true, false].into_iter().zip(hits) {
                let solved = self.solved(&finding.name, name, value, up);
                let found = solved.or_else(|| self.searched(Some(&finding.name), name, value, up));
                single.extend(self.hit(finding, (name, value), hits, found));
            }
        }
        single
    }

    fn feedback(&self, finding: &Finding, blame: Vec<String>, mut single: Vec<Repair>) -> Feedback {
        single.sort_by(|one, other| {
            one.breaks.len().cmp(&other.breaks.len()).then_with(|| change(one).cmp(&change(other)))
        });
        let mut pairs = Vec::new();
        if !single.iter().any(Repair::is_harmless) {
            pairs = self.pairs(Some(&finding.name), &single);
            // One half of what helps may be enough, at a place that was not tried.
            let halves = self.halves(Some(&finding.name), &pairs);
            if !halves.is_empty() {
                (single, pairs) = ([halves, single].concat(), Vec::new());
            }
        }
        let tried = self.parameters.iter().map(|(name, _)| name.clone()).collect();
        Feedback { name: finding.name.clone(), blame, limit: self.limit(finding), single, pairs, tried }
    }

    /// From the margin as a formula of the parameter: where it is 0.
    fn solved(&self, name: &Name, parameter: &Name, value: &BigRational, up: bool) -> Option<Repair> {
        let formula = self.formulas.get(parameter)?[usize::from(!up)].get(name)?;
        let root = formula.root().filter(|root| (root > value) == up && root != value)?;
        let nearer = &root + (value - &root) * small();
        if !self.plausible(&root, value) || self.met(Some(name), &[(parameter.clone(), nearer.clone())]) {
            return None;
        }
        let mut repair = self.repair(Some(name), &[(parameter.clone(), root)])?;
        if self.standing(Some(name), &[(parameter.clone(), nearer.clone())]) == Some(Standing::NotMet) {
            repair.least = repair.changes.first().map(|(.., after)| (after - nearer).abs());
        }
        repair.formula = formula.value(parameter);
        Some(repair)
    }

    fn plausible(&self, value: &BigRational, present: &BigRational) -> bool {
        present.is_zero() || value.is_positive() == present.is_positive()
    }

    /// By trying: outward from the present value, then halving, then the simplest number there is.
    fn searched(&self, goal: Goal<'_>, parameter: &Name, value: &BigRational, up: bool) -> Option<Repair> {
        let at = |value: &BigRational| vec![(parameter.clone(), value.clone())];
        let mut fails = value.clone();
        let mut found = None;
        for next in places(value, up) {
            if (self.judge.interrupted)() {
                return None;
            }
            if self.met(goal, &at(&next)) {
                found = Some(next);
                break;
            }
            fails = next;
        }
        self.narrowed(goal, parameter, value, (fails, found?))
    }

    /// The limit at which the criterion would be met as everything is.
    fn limit(&self, finding: &Finding) -> Option<String> {
        let criterion = self.criteria.all.iter().find(|one| one.name == finding.name)?;
        if let Some(deadline) = self.deadline(criterion) {
            return Some(format!("a deadline of {deadline}"));
        }
        let Some(Measure::Exact(value)) = &finding.value else { return None };
        Some(match &criterion.kind {
            Ask::Radius(_) => format!("a radius of {value}"),
            Ask::Leg { .. } => format!("a leg within {value}"),
            Ask::Round { .. } => format!("a round within {value}"),
            Ask::Clearance { .. } if value.is_zero() => return None,
            Ask::Clearance { strict: true, .. } => format!("a clearance of less than {value}"),
            Ask::Clearance { .. } => format!("a clearance of {value}"),
            Ask::Battery { start, keep, .. } => {
                let left = value.as_rational()?;
                let keeping = if left.is_negative() { String::new() } else { format!(", or keeping {value}") };
                format!("a battery of {}{keeping}", Value::rational(keep - left + start))
            }
            Ask::Probability { .. } => return None,
        })
    }
}

/// By how much a margin changed; nothing where only bounds are known.
fn difference(there: &Measure, here: &Measure) -> Option<Measure> {
    match (there, here) {
        (Measure::Exact(there), Measure::Exact(here)) => there.sub(here).ok().map(Measure::Exact),
        (Measure::Between(low, high), Measure::Between(least, most)) => {
            Some(Measure::Between((low - most).next_down(), (high - least).next_up()))
        }
        _ => None,
    }
}

/// How far a repair goes, as the larger of its changes in proportion.
fn change(repair: &Repair) -> BigRational {
    let far = |(_, before, after): &(Name, BigRational, BigRational)| {
        let (before, after) = (before.abs(), after.abs());
        if before.is_zero() || after.is_zero() {
            return BigRational::from_integer(1000.into());
        }
        if after > before { after / before } else { before / after }
    };
    repair.changes.iter().map(far).max().unwrap_or_else(BigRational::zero)
}

/// The factors by which parameters are changed, one after the other.
fn factors() -> impl Iterator<Item = BigRational> {
    let factors = [(101, 100), (9, 8), (3, 2), (2, 1), (4, 1), (16, 1), (256, 1)];
    factors
        .into_iter()
        .map(|(numerator, denominator): (i64, i64)| BigRational::new(numerator.into(), denominator.into()))
}

/// Where a change of a parameter is tried, from the present value on: at some factors, at 1 on the way, which a gain that is
/// just right often is, and last, where it goes towards it, at 0.
fn places(value: &BigRational, up: bool) -> Vec<BigRational> {
    let mut places: Vec<BigRational> = factors().map(|factor| moved(value, &factor, up)).collect();
    places.extend((up == value.is_negative()).then(BigRational::zero).filter(|_| !value.is_zero()));
    let one = BigRational::one();
    let beyond = |place: &BigRational| if up { *place >= one } else { *place <= one };
    if value.is_positive()
        && !beyond(value)
        && let Some(first) = places.iter().position(beyond)
        && places[first] != one
    {
        places.insert(first, one);
    }
    places
}

/// A value changed by a factor, away from 0 or towards it; 0 itself is changed by a step.
fn moved(value: &BigRational, factor: &BigRational, up: bool) -> BigRational {
    if value.is_zero() {
        let step = factor - BigRational::one();
        return if up { step } else { -step };
    }
    if up == value.is_positive() { value * factor } else { value / factor }
}

fn small() -> BigRational {
    BigRational::new(1.into(), (1_i64 << 20).into())
}

/// Whether a value is less than 0, exactly.
pub fn is_short(margin: &Measure) -> bool {
    match margin {
        Measure::Exact(value) | Measure::AtMost(value) => {
            crate::assumption::Assumptions::default().decide(Relation::Lss, value, &Value::zero()) == Some(true)
        }
        Measure::AtLeast(_) => false,
        Measure::Between(_, high) => *high < 0.0,
    }
}
