//! When two values are the same: when their normal forms are. The hash only tells quickly that they are not.

use std::cmp::Ordering;
use std::hash::{Hash, Hasher};
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;

use super::Value;
use crate::digest::Digest;

impl Value {
    fn digest(&self) -> u64 {
        let known = self.0.hash.load(Relaxed);
        if known != 0 {
            return known;
        }
        let mut hasher = Digest::default();
        self.0.content.hash(&mut hasher);
        let hash = hasher.finish().max(1);
        self.0.hash.store(hash, Relaxed);
        hash
    }
}

impl PartialEq for Value {
    fn eq(&self, other: &Value) -> bool {
        let (one, two) = (self.0.hash.load(Relaxed), other.0.hash.load(Relaxed));
        let differ = one != two && one != 0 && two != 0;
        Arc::ptr_eq(&self.0, &other.0) || (!differ && self.0.content == other.0.content)
    }
}

impl Eq for Value {}

impl Hash for Value {
    fn hash<H: Hasher>(&self, state: &mut H) {
        state.write_u64(self.digest());
    }
}

impl PartialOrd for Value {
    fn partial_cmp(&self, other: &Value) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Value {
    fn cmp(&self, other: &Value) -> Ordering {
        if Arc::ptr_eq(&self.0, &other.0) { Ordering::Equal } else { self.0.content.cmp(&other.0.content) }
    }
}
