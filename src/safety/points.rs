//! Instances of a claim that is made for all values of its parameters: they guide the search for conditions.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

use super::Asked;
use super::condition::Clause;
use crate::assumption::Assumptions;
use crate::name::Name;
use crate::period::Test;
use crate::value::Value;

/// Tests of a guess.
const MOST_TESTS: usize = 6;

/// Numbers for parameters.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Instance {
    /// The numbers.
    pub values: BTreeMap<Name, Value>,
    /// Whether the claim holds with them, as far as the run was followed.
    pub holds: bool,
    /// How many states its run has, where it was followed to the end; else 0.
    pub states: usize,
}

/// Whether a test holds of these numbers.
pub fn meets(values: &BTreeMap<Name, Value>, test: &Test) -> bool {
    test.substitute(values).ok().and_then(|test| test.decide(&Assumptions::default())) == Some(true)
}

/// For each instance, whether a test holds in it.
type Truth = Rc<Vec<bool>>;

/// The instances of what is asked, once they are needed.
pub(super) struct Points<'a> {
    asked: Asked<'a>,
    known: RefCell<Option<Rc<Vec<Instance>>>>,
    truth: RefCell<BTreeMap<Test, Truth>>,
    /// What instances were asked for already.
    sampled: RefCell<BTreeSet<Vec<Test>>>,
}

impl<'a> Points<'a> {
    pub(super) fn new(asked: Asked<'a>) -> Points<'a> {
        Points { asked, known: RefCell::default(), truth: RefCell::default(), sampled: RefCell::default() }
    }

    fn of(asked: Asked<'a>, all: Vec<Instance>) -> Points<'a> {
        Points { known: RefCell::new(Some(Rc::new(all))), ..Points::new(asked) }
    }

    /// Those that meet these tests, for what is asked under them.
    pub(super) fn within<'b>(&self, asked: Asked<'b>, tests: &[Test]) -> Points<'b> {
        let inside = self.meeting(tests);
        let all = self.all();
        Points::of(
            asked,
            all.iter().zip(inside).filter(|(_, inside)| *inside).map(|(point, _)| point.clone()).collect(),
        )
    }

    pub(super) fn all(&self) -> Rc<Vec<Instance>> {
        Rc::clone(self.known.borrow_mut().get_or_insert_with(|| Rc::new((self.asked.instances)(&[]))))
    }

    /// Asks for instances that meet these tests; whether there were new ones.
    pub(super) fn sample(&self, tests: &[Test]) -> bool {
        if !self.sampled.borrow_mut().insert(tests.to_vec()) {
            return false;
        }
        let mut all = self.all().to_vec();
        let before = all.len();
        for instance in (self.asked.instances)(tests) {
            if !all.contains(&instance) {
                all.push(instance);
            }
        }
        let more = all.len() > before;
        *self.known.borrow_mut() = Some(Rc::new(all));
        more
    }

    /// In which the claim holds.
    pub(super) fn holding(&self) -> Vec<bool> {
        self.all().iter().map(|point| point.holds).collect()
    }

    /// Whether one of them breaks the claim.
    pub(super) fn break_it(&self) -> bool {
        self.all().iter().any(|point| !point.holds)
    }

    /// Whether none that meets these tests breaks the claim.
    pub(super) fn allow(&self, tests: &[Test]) -> bool {
        self.only(tests, &self.holding())
    }

    fn truth(&self, test: &Test) -> Truth {
        let all = self.all();
        let known = self.truth.borrow().get(test).cloned();
        match known {
            Some(known) if known.len() == all.len() => known,
            known => {
                let mut longer = known.map_or_else(Vec::new, |known| known.to_vec());
                longer.extend(all[longer.len()..].iter().map(|point| meets(&point.values, test)));
                let longer = Rc::new(longer);
                self.truth.borrow_mut().insert(test.clone(), Rc::clone(&longer));
                longer
            }
        }
    }

    /// Which of them meet all these tests.
    pub(super) fn meeting(&self, tests: &[Test]) -> Vec<bool> {
        let mut all = vec![true; self.all().len()];
        for test in tests {
            let truth = self.truth(test);
            all.iter_mut().zip(truth.iter()).for_each(|(all, own)| *all &= own);
        }
        all
    }

    /// Which of them meet one test at least.
    fn meeting_any(&self, clause: &Clause) -> Vec<bool> {
        let mut any = vec![false; self.all().len()];
        for test in clause {
            let truth = self.truth(test);
            any.iter_mut().zip(truth.iter()).for_each(|(any, own)| *any |= own);
        }
        any
    }

    /// Whether one of them meets no test of a clause.
    pub(super) fn beyond(&self, clause: &Clause) -> bool {
        self.meeting_any(clause).contains(&false)
    }

    /// Which of them meet all clauses.
    pub(super) fn within_all(&self, clauses: &[Clause]) -> Vec<bool> {
        let mut all = vec![true; self.all().len()];
        for clause in clauses {
            all.iter_mut().zip(self.meeting_any(clause)).for_each(|(all, own)| *all &= own);
        }
        all
    }

    /// Whether all that meet the tests are among these.
    pub(super) fn only(&self, tests: &[Test], these: &[bool]) -> bool {
        self.meeting(tests).iter().zip(these).all(|(meets, this)| *this || !meets)
    }

    /// Tests that some of the first meet, and none of the second. Greedily: of the tests that lose the fewest of the first,
    /// the one that leaves out most of the second; of equals the first.
    pub(super) fn cover(&self, pool: &[Test], first: &[bool], second: &[bool]) -> Option<Vec<Test>> {
        let truths: Vec<(&Test, Truth)> = pool.iter().map(|test| (test, self.truth(test))).collect();
        let (mut keep, mut leave) = (places(first), places(second));
        let mut guess: Vec<Test> = Vec::new();
        while !leave.is_empty() {
            if keep.is_empty() || guess.len() == MOST_TESTS {
                return None;
            }
            let worth = |truth: &Truth| {
                let lost = keep.iter().filter(|place| !truth[**place]).count();
                let left = leave.iter().filter(|place| !truth[**place]).count();
                // As a share of each; one that is lost is as bad as three that are not left out.
                (left > 0).then(|| (left * keep.len()) as i64 - (3 * lost * leave.len()) as i64)
            };
            let scored = truths.iter().rev().filter_map(|(test, truth)| Some((worth(truth)?, test, truth)));
            let (_, test, truth) = scored.max_by_key(|(worth, ..)| *worth)?;
            keep.retain(|place| truth[*place]);
            leave.retain(|place| truth[*place]);
            guess.push((*test).clone());
        }
        (!keep.is_empty()).then(|| self.without_idle(guess, second))
    }

    /// Leaves out tests without which none of these comes in.
    fn without_idle(&self, mut tests: Vec<Test>, these: &[bool]) -> Vec<Test> {
        let out = |tests: &[Test]| !self.meeting(tests).iter().zip(these).any(|(meets, this)| *meets && *this);
        for place in (0..tests.len()).rev() {
            let mut others = tests.clone();
            others.remove(place);
            if out(&others) {
                tests = others;
            }
        }
        tests.sort();
        tests
    }
}

fn places(these: &[bool]) -> Vec<usize> {
    (0..these.len()).filter(|place| these[*place]).collect()
}
