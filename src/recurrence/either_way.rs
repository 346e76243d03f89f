//! What depends on something that is not known of parameters: it is asked in either case of what would have to be known,
//! and in each of them in the same way again.

use std::collections::BTreeSet;

use super::Unknown;
use crate::assumption::Assumptions;
use crate::closed_form::{Comparison, Recurrence, compared, simpler};
use crate::name::Name;
use crate::value::{Need, Relation, Value};

/// The most cases, and the most comparisons that one may depend on where nothing else is said.
const MOST_CASES: usize = 12;
const MOST_ASKED: usize = 4;
/// The most that may follow from the rest beside them.
const MOST_BESIDE: usize = 2;

/// One case: what is assumed in it, what is known then, and what was found.
#[derive(Clone, Debug)]
pub struct InCase<T> {
    /// What is assumed, beyond what is known in all cases.
    pub assumed: Vec<Comparison>,
    /// All that is known here.
    pub known: Assumptions,
    /// What was found.
    pub found: T,
}

impl<T> InCase<T> {
    /// `r0 < 3 and g > 2*a`
    pub fn title(&self) -> String {
        let mut told: Vec<String> = Vec::new();
        for comparison in self.assumed.iter().map(compared) {
            if !told.contains(&comparison) {
                told.push(comparison);
            }
        }
        told.join(" and ")
    }
}

/// Where something is not known: what stands in the way, and what is left to tell where that is not settled.
pub(crate) type Unsettled<T> = (Unknown, Option<Box<T>>);

/// What is found in every case, given why it is not known without; nothing where there is nothing to tell in a case, or it
/// depends on the index.
pub(crate) fn either_way<T>(
    recurrence: &Recurrence,
    known: &Assumptions,
    unknown: &Unknown,
    ask: &dyn Fn(&Assumptions) -> Result<T, Unsettled<T>>,
    stop: &dyn Fn() -> bool,
) -> Option<Vec<InCase<T>>> {
    let terms = recurrence.terms();
    let free = |name: &Name| *name != recurrence.index && !terms.iter().any(|(term, ..)| term == name);
    in_each_case((&free, MOST_ASKED), known, unknown, ask, stop)
}

/// The same, where what stands in the way must be of names that are `free` alone, with so many comparisons for one case at most.
pub(crate) fn in_each_case<T>(
    (free, most): (&dyn Fn(&Name) -> bool, usize),
    known: &Assumptions,
    unknown: &Unknown,
    ask: &dyn Fn(&Assumptions) -> Result<T, Unsettled<T>>,
    stop: &dyn Fn() -> bool,
) -> Option<Vec<InCase<T>>> {
    let mut split = Split { free, most, known, ask, assumed: Vec::new(), cases: Vec::new(), stop };
    let (relation, left, right) = split.askable(unknown)?;
    split.cases_of((relation, left, right))?;
    Some(split.cases).filter(|cases| !cases.is_empty())
}

struct Split<'a, T> {
    free: &'a dyn Fn(&Name) -> bool,
    /// The most that is assumed beyond that.
    most: usize,
    /// What is known in every case.
    known: &'a Assumptions,
    ask: &'a dyn Fn(&Assumptions) -> Result<T, Unsettled<T>>,
    /// What is assumed beyond that where the work is now.
    assumed: Vec<Comparison>,
    cases: Vec<InCase<T>>,
    stop: &'a dyn Fn() -> bool,
}

/// What these divide by.
fn divisors(sides: [&Value; 2]) -> impl Iterator<Item = Value> {
    let needs = sides.into_iter().flat_map(Value::needs);
    needs.filter_map(|need| if let Need::Nonzero(divisor) = need { Some(divisor) } else { None })
}

impl<T> Split<'_, T> {
    /// What is open, if it is of parameters alone and there is room for its cases.
    fn askable(&self, unknown: &Unknown) -> Option<Comparison> {
        let open = unknown.open.as_deref()?;
        // Of values that it may be equal to there may be more: a turn of five has as many.
        let apart = |one: &Comparison| one.0 == Relation::Neq;
        let kept = self.assumed.iter().zip(self.kept()).filter(|(one, kept)| *kept && !apart(one)).count();
        let all = self.assumed.iter().filter(|one| !apart(one)).count();
        let many = kept >= self.most || all >= self.most + MOST_BESIDE || self.assumed.len() >= 2 * self.most;
        let full = many || self.cases.len() >= MOST_CASES || (self.stop)();
        let free = open.1.variables().iter().chain(&open.2.variables()).all(|name| (self.free)(name));
        let settled = || {
            let known = self.assuming(|_| true);
            let zero = |divisor: Value| known.decide(Relation::Eq, &divisor, &Value::zero()) == Some(true);
            known.decide(open.0, &open.1, &open.2).is_some() || divisors([&open.1, &open.2]).any(zero)
        };
        (free && !full && !settled()).then(|| open.clone())
    }

    /// Adds the cases of what is open here, and those in which something is 0 that it divides by, where these are told.
    fn cases_of(&mut self, (relation, left, right): Comparison) -> Option<()> {
        let known = self.assuming(|_| true);
        let open = |divisor: &Value| known.decide(Relation::Eq, divisor, &Value::zero()).is_none();
        let divisors: BTreeSet<Value> = divisors([&left, &right]).filter(open).collect();
        for relation in [relation, relation.negated()] {
            self.case((relation, left.clone(), right.clone()))?;
        }
        for divisor in divisors {
            let (cases, assumed) = (self.cases.len(), self.assumed.len());
            if assumed >= self.most || self.case((Relation::Eq, divisor, Value::zero())).is_none() {
                self.cases.truncate(cases);
                self.assumed.truncate(assumed);
            }
        }
        Some(())
    }

    /// Adds what is found where this holds as well.
    fn case(&mut self, comparison: Comparison) -> Option<()> {
        self.assumed.push(comparison.clone());
        let (_, left, right) = comparison;
        // A quotient that is at least and at most 0 is 0, and so is what is divided.
        let quotient = left.sub(&right).ok().and_then(|difference| difference.denominator());
        let equal = quotient.is_some_and(|below| below.as_rational().is_none())
            && self.assuming(|_| true).decide(Relation::Eq, &left, &right) == Some(true);
        let relation = if equal { Relation::Eq } else { comparison.0 };
        self.assumed.pop();
        let comparison = simpler(&(relation, left, right), &self.assuming(|_| true));
        self.assumed.push(comparison);
        if !self.assuming(|_| true).contradictory() {
            // What follows from the rest is no help, and there is more to look through with it.
            let kept = self.kept();
            let known = self.assuming(|place| kept[place]);
            match (self.ask)(&known) {
                Ok(found) => self.cases.push(InCase { assumed: self.needed(&kept), known, found }),
                Err((unknown, rest)) => match (self.askable(&unknown), rest) {
                    (Some(open), _) => self.cases_of(open)?,
                    (None, Some(found)) => {
                        self.cases.push(InCase { assumed: self.needed(&kept), known, found: *found });
                    }
                    (None, None) => return None,
                },
            }
        }
        self.assumed.pop();
        Some(())
    }

    /// What is known with some of what is assumed, which has a value where it holds: `1/a > 0` is of an a that is not 0.
    fn assuming(&self, chosen: impl Fn(usize) -> bool) -> Assumptions {
        let mut known = self.known.clone();
        for (_, (relation, left, right)) in self.assumed.iter().enumerate().filter(|(place, _)| chosen(*place)) {
            for divisor in divisors([left, right]) {
                if known.decide(Relation::Neq, &divisor, &Value::zero()) != Some(true) {
                    known.assume(Relation::Neq, &divisor, &Value::zero());
                }
            }
            known.assume(*relation, left, right);
        }
        known
    }

    /// Which of what is assumed does not follow from the rest.
    fn kept(&self) -> Vec<bool> {
        let mut kept = vec![true; self.assumed.len()];
        for (place, (relation, left, right)) in self.assumed.iter().enumerate() {
            let others = self.assuming(|other| other != place && kept[other]);
            kept[place] = others.decide(*relation, left, right) != Some(true);
        }
        kept
    }

    /// What of it is kept, each as strong as all of it makes it.
    fn needed(&self, kept: &[bool]) -> Vec<Comparison> {
        let all = self.assuming(|_| true);
        let mut needed: Vec<Comparison> = Vec::new();
        for ((relation, left, right), _) in self.assumed.iter().zip(kept).filter(|(_, kept)| **kept) {
            // `a >= 0` with `a <= 0` is `a = 0`, and with `a != 0` it is `a > 0`.
            let stronger = [Relation::Eq, Relation::Lss, Relation::Gtr].into_iter();
            let stronger = stronger.filter(|_| matches!(relation, Relation::Gte | Relation::Lte | Relation::Neq));
            let mut stronger = stronger.filter(|one| all.decide(*one, left, right) == Some(true));
            let relation = stronger.next().unwrap_or(*relation);
            let same = |(other, one, two): &Comparison| {
                let (Ok(here), Ok(there)) = (left.sub(right), one.sub(two)) else { return false };
                (here == there && *other == relation)
                    || (here.neg().is_ok_and(|here| here == there) && *other == relation.mirrored())
            };
            if !needed.iter().any(same) {
                needed.push((relation, left.clone(), right.clone()));
            }
        }
        self.simplest(needed)
    }

    /// The same, each of them without what the others know.
    fn simplest(&self, mut needed: Vec<Comparison>) -> Vec<Comparison> {
        for place in 0..needed.len() {
            let mut known = self.known.clone();
            let others = needed.iter().enumerate().filter(|(other, _)| *other != place);
            others.for_each(|(_, (relation, left, right))| known.assume(*relation, left, right));
            needed[place] = simpler(&needed[place], &known);
        }
        let always =
            |(relation, left, right): &Comparison| Assumptions::default().decide(*relation, left, right) == Some(true);
        needed.retain(|comparison| !always(comparison));
        needed
    }
}
