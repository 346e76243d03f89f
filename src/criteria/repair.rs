//! What would repair a criterion: one parameter, to which value, or two; each tried by judging again.

mod sensitivity;

use std::collections::{BTreeMap, BTreeSet};

use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use super::nearby::{Formula, nearby};
use super::simplest::simplest;
use super::{Chances, Finding, Judge, Judged, Measure, Standing};
use crate::lower::{Ask, Criteria, Environment, Likelihood};
use crate::name::Name;
use crate::value::{Relation, Value};

pub use sensitivity::Sensitivity;

/// Numbers with a larger denominator are not simple.
const MOST_DENOMINATOR: i64 = 10_000;
/// Halvings of an interval in which the least change lies.
const HALVINGS: usize = 20;
/// Parameters that are tried, at most.
pub const MOST_PARAMETERS: usize = 10;
/// Pairs of parameters that are tried, at most.
const MOST_PAIRS: usize = 15;

/// Other values for some parameters.
pub type Point = Vec<(Name, BigRational)>;

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
    /// By how little the change may not be less.
    pub least: Option<BigRational>,
    /// A value that is only just not enough.
    pub not_at: Option<BigRational>,
    /// The margin as a formula of the parameter near its present value, where the value was solved from it.
    pub formula: Option<Value>,
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
        if !judged.run.stretches.is_empty() {
            for (name, value) in parameters.iter().take_while(|_| !(judge.interrupted)()) {
                let sides = [true, false].map(|up| nearby(value, up, &|there| workshop.margins(name, there)));
                workshop.formulas.insert(name.clone(), sides);
            }
        }
        workshop
    }

    /// The margins that are exact when one parameter has another value, by criterion.
    fn margins(&self, parameter: &Name, value: &BigRational) -> Option<BTreeMap<Name, BigRational>> {
        let (criteria, environment) = self.elsewhere(&[(parameter.clone(), value.clone())])?;
        let never = |_: &Likelihood, _: &Environment, _: (Relation, &BigRational)| Err(Vec::new());
        let findings = Judge { chances: &never, ..self.judge }.judge(&criteria, &environment).findings;
        let exact = |finding: Finding| Some((finding.name.clone(), finding.exact_margin()?.as_rational()?));
        Some(findings.into_iter().filter_map(exact).collect())
    }

    /// The criteria with other values; none where the declarations do not allow them.
    pub fn elsewhere(&self, point: &[(Name, BigRational)]) -> Option<(Criteria, Environment)> {
        let instead: BTreeMap<Name, Option<Value>> =
            point.iter().map(|(name, value)| (name.clone(), Some(Value::rational(value.clone())))).collect();
        let environment = self.environment.varied(&instead).ok()?;
        let criteria = environment.criteria(&self.criteria.written).ok()?;
        Some((criteria, environment))
    }

    fn met(&self, name: &Name, point: &[(Name, BigRational)]) -> bool {
        self.standing(name, point) == Some(Standing::Met)
    }

    fn standing(&self, name: &Name, point: &[(Name, BigRational)]) -> Option<Standing> {
        let (criteria, environment) = self.elsewhere(point)?;
        let found = Judge { chances: self.roughly, ..self.judge }.one(&criteria, &environment, name);
        found.map(|finding| finding.standing)
    }

    /// Judges everything with a change: a repair if the criterion is met then.
    fn repair(&self, name: &Name, point: &[(Name, BigRational)]) -> Option<Repair> {
        let (criteria, environment) = self.elsewhere(point)?;
        let judged = self.judge.judge(&criteria, &environment);
        let after = judged.findings.iter().find(|finding| finding.name == *name)?.clone();
        if after.standing != Standing::Met {
            return None;
        }
        let met_before =
            |name: &Name| self.judged.findings.iter().any(|one| one.name == *name && one.standing == Standing::Met);
        let breaks = judged.findings.iter().filter(|one| one.standing != Standing::Met && met_before(&one.name));
        let open = breaks.clone().filter(|one| one.standing != Standing::NotMet).map(|one| one.name.clone()).collect();
        let breaks = breaks.map(|one| one.name.clone()).collect();
        let present = |name: &Name| self.parameters.iter().find(|(other, _)| other == name).map(|(_, value)| value);
        let changes =
            point.iter().filter_map(|(name, value)| Some((name.clone(), present(name)?.clone(), value.clone())));
        Some(Repair { changes: changes.collect(), after, breaks, open, least: None, not_at: None, formula: None })
    }

    /// A repair that breaks nothing.
    fn harmless(&self, name: &Name, point: &[(Name, BigRational)]) -> Option<Repair> {
        let repair = if self.met(name, point) { self.repair(name, point) } else { None };
        repair.filter(|repair| repair.breaks.is_empty())
    }

    /// What to do about a criterion that is not met.
    pub fn feedback(&self, finding: &Finding, blame: Vec<String>) -> Feedback {
        let mut single = Vec::new();
        for (name, value) in self.parameters {
            if (self.judge.interrupted)() {
                break;
            }
            for up in [true, false] {
                let solved = self.solved(&finding.name, name, value, up);
                single.extend(solved.or_else(|| self.searched(&finding.name, name, value, up)));
            }
        }
        single.sort_by(|one, other| {
            one.breaks.len().cmp(&other.breaks.len()).then_with(|| change(one).cmp(&change(other)))
        });
        let mut pairs = Vec::new();
        if !single.iter().any(|repair| repair.breaks.is_empty()) {
            pairs = self.pairs(&finding.name, &single);
            // One half of what helps may be enough, at a place that was not tried.
            let halves = self.halves(&finding.name, &pairs);
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
        if !self.plausible(&root, value) || self.met(name, &[(parameter.clone(), nearer.clone())]) {
            return None;
        }
        let mut repair = self.repair(name, &[(parameter.clone(), root)])?;
        repair.least = repair.changes.first().map(|(.., after)| (after - nearer).abs());
        repair.formula = formula.value(parameter);
        Some(repair)
    }

    fn plausible(&self, value: &BigRational, present: &BigRational) -> bool {
        present.is_zero() || value.is_positive() == present.is_positive()
    }

    /// By trying: outward from the present value, then halving, then the simplest number there is.
    fn searched(&self, name: &Name, parameter: &Name, value: &BigRational, up: bool) -> Option<Repair> {
        let at = |value: &BigRational| vec![(parameter.clone(), value.clone())];
        let mut fails = value.clone();
        let mut found = None;
        for factor in factors() {
            if (self.judge.interrupted)() {
                return None;
            }
            let next = moved(value, &factor, up);
            if self.met(name, &at(&next)) {
                found = Some(next);
                break;
            }
            fails = next;
        }
        let mut works = found?;
        let met = |value: &BigRational| self.met(name, &at(value));
        for round in 0..2 {
            for _ in 0..HALVINGS / 2 {
                let middle = (&fails + &works) / BigRational::from_integer(2.into());
                if met(&middle) { works = middle } else { fails = middle }
            }
            // A simple number may be just the place: met there, and not a little before.
            let simple = simplest(&fails, &works);
            let before = &simple + (value - &simple) * small();
            if round == 0 && simple != fails && met(&simple) && !met(&before) {
                (fails, works) = (before, simple);
                break;
            }
        }
        let simple = simplest(&fails, &works);
        if simple != fails && met(&simple) {
            works = simple.clone();
        }
        // Where it is open it may be met after all.
        let not_met = |value: &BigRational| self.standing(name, &at(value)) == Some(Standing::NotMet);
        let mut repair = None;
        if simple.denom() < &MOST_DENOMINATOR.into() && simple != works {
            // The place itself does not count: a little further then.
            let further = self.further(name, parameter, value, &works);
            repair = further.or_else(|| self.repair(name, &at(&works)));
            if let Some(repair) = repair.as_mut().filter(|_| not_met(&simple)) {
                repair.not_at = Some(simple);
            }
        } else if works.denom() < &MOST_DENOMINATOR.into() {
            repair = self.repair(name, &at(&works));
            if let Some(repair) = repair.as_mut().filter(|_| not_met(&fails)) {
                repair.least = Some((&works - &fails).abs());
            }
        }
        repair.or_else(|| self.further(name, parameter, value, &works)).or_else(|| self.repair(name, &at(&works)))
    }

    /// The simplest number at which the criterion is met, a hundredth further from the present value at most.
    fn further(&self, name: &Name, parameter: &Name, present: &BigRational, works: &BigRational) -> Option<Repair> {
        let further = works + (works - present) * BigRational::new(1.into(), 100.into());
        self.repair(name, &[(parameter.clone(), simplest(works, &further))])
    }

    /// Two parameters: what one repairs and breaks mended by another, or both moved together.
    fn pairs(&self, name: &Name, single: &[Repair]) -> Vec<Repair> {
        let mut found: Vec<Repair> = Vec::new();
        for repair in single.iter().take(4) {
            let Some((first, _, value)) = repair.changes.first() else { continue };
            for (second, present) in self.parameters.iter().filter(|(other, _)| other != first) {
                let sides = [true, false];
                found.extend(
                    sides.into_iter().filter_map(|up| self.mended(name, (first, value), (second, present), up)),
                );
            }
        }
        if single.is_empty() {
            let all = self.parameters;
            let pairs = (0..all.len()).flat_map(|one| (one + 1..all.len()).map(move |other| (one, other)));
            for (one, other) in pairs.take(MOST_PAIRS) {
                if (self.judge.interrupted)() {
                    break;
                }
                found.extend(self.together(name, &all[one], &all[other]));
            }
        }
        found.sort_by_key(change);
        found.truncate(4);
        found
    }

    /// The changes of one parameter among those of two that break nothing by themselves, the least of each parameter.
    fn halves(&self, name: &Name, pairs: &[Repair]) -> Vec<Repair> {
        let mut found: Vec<Repair> = Vec::new();
        for (parameter, _, value) in pairs.iter().flat_map(|pair| &pair.changes) {
            found.extend(self.harmless(name, &[(parameter.clone(), value.clone())]));
        }
        found.sort_by_key(change);
        let mut seen = BTreeSet::new();
        found.retain(|one| one.changes.iter().all(|(parameter, ..)| seen.insert(parameter.clone())));
        found
    }

    /// A value of the second parameter with which the first repairs the criterion and nothing breaks.
    fn mended(
        &self,
        name: &Name,
        (first, value): (&Name, &BigRational),
        (second, present): (&Name, &BigRational),
        up: bool,
    ) -> Option<Repair> {
        let point = |other: &BigRational| vec![(first.clone(), value.clone()), (second.clone(), other.clone())];
        let fine = |other: &BigRational| self.harmless(name, &point(other));
        let mut fails = present.clone();
        let mut works = None;
        for factor in factors() {
            let next = moved(present, &factor, up);
            if fine(&next).is_some() {
                works = Some(next);
                break;
            }
            fails = next;
        }
        let mut works = works?;
        for _ in 0..HALVINGS / 2 {
            let middle = (&fails + &works) / BigRational::from_integer(2.into());
            if fine(&middle).is_some() { works = middle } else { fails = middle }
        }
        fine(&simplest(&fails, &works)).or_else(|| fine(&works))
    }

    /// Both parameters changed by one factor each, up or down.
    fn together(&self, name: &Name, one: &(Name, BigRational), other: &(Name, BigRational)) -> Option<Repair> {
        let mut best: Option<Repair> = None;
        for (up, also_up) in [(true, true), (true, false), (false, true), (false, false)] {
            let point = |factor: &BigRational| {
                vec![(one.0.clone(), moved(&one.1, factor, up)), (other.0.clone(), moved(&other.1, factor, also_up))]
            };
            let fine = |factor: &BigRational| self.harmless(name, &point(factor));
            let mut fails = BigRational::one();
            let mut works = None;
            for factor in [(5, 4), (2, 1), (8, 1)] {
                if (self.judge.interrupted)() {
                    return best;
                }
                let factor = BigRational::new(factor.0.into(), factor.1.into());
                if fine(&factor).is_some() {
                    works = Some(factor);
                    break;
                }
                fails = factor;
            }
            let Some(mut works) = works else { continue };
            for _ in 0..HALVINGS / 2 {
                let middle = (&fails + &works) / BigRational::from_integer(2.into());
                if fine(&middle).is_some() { works = middle } else { fails = middle }
            }
            let repair = fine(&simplest(&fails, &works)).or_else(|| fine(&works));
            if let Some(repair) = repair
                && best.as_ref().is_none_or(|best| change(&repair) < change(best))
            {
                best = Some(repair);
            }
        }
        best
    }

    /// The limit at which the criterion would be met as everything is.
    fn limit(&self, finding: &Finding) -> Option<String> {
        let criterion = self.criteria.all.iter().find(|one| one.name == finding.name)?;
        let Some(Measure::Exact(value)) = &finding.value else { return None };
        Some(match &criterion.kind {
            Ask::Radius(_) => format!("a radius of {value}"),
            Ask::Leg { .. } => format!("a leg within {value}"),
            Ask::Round { .. } => format!("a round within {value}"),
            Ask::Clearance { .. } if value.is_zero() => return None,
            Ask::Clearance { strict: true, .. } => format!("a clearance of less than {value}"),
            Ask::Clearance { .. } => format!("a clearance of {value}"),
            Ask::Battery { start, keep, .. } => {
                let more = Value::rational(keep - value.as_rational()? + start);
                format!("a battery of {more}, or keeping {value}")
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
    let factors = [(9, 8), (3, 2), (2, 1), (4, 1), (16, 1), (256, 1)];
    factors
        .into_iter()
        .map(|(numerator, denominator): (i64, i64)| BigRational::new(numerator.into(), denominator.into()))
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
