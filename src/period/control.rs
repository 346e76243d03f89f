//! Control points: what a system is about to do, apart from the values.

use std::hash::{Hash, Hasher};
use std::rc::Rc;

use super::run::Run;
use crate::digest::Digest;

/// A control point: what runs, with 0 for every value and delay, and the hash of that.
#[derive(Clone)]
pub(super) struct Control {
    hash: u64,
    pub(super) runs: Rc<Vec<Run>>,
}

impl Control {
    pub(super) fn of(runs: Vec<Run>) -> Control {
        let mut hasher = Digest::default();
        runs.hash(&mut hasher);
        Control { hash: hasher.finish(), runs: Rc::new(runs) }
    }
}

impl PartialEq for Control {
    fn eq(&self, other: &Control) -> bool {
        self.hash == other.hash && self.runs == other.runs
    }
}

impl Eq for Control {}

impl Hash for Control {
    fn hash<H: Hasher>(&self, state: &mut H) {
        state.write_u64(self.hash);
    }
}
