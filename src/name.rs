//! Names: of processes, values, ports and metavariables.

use std::fmt;
use std::sync::Arc;

/// A name as it was written; cheap to copy. A metavariable's name starts with `?`.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Name(Arc<str>);

impl Name {
    /// The name with this spelling.
    pub fn new(text: &str) -> Name {
        Name(Arc::from(text))
    }

    /// Its spelling.
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// True of `?x`: a variable to be found, or a law's metavariable.
    pub fn is_meta(&self) -> bool {
        self.0.starts_with('?')
    }

    /// The name of a component of a vector, at this place from 0: `rx`, `ry`, `rz`, and of longer vectors `r1`, `r2`, ….
    pub fn component(&self, place: usize, length: usize) -> Name {
        match ["x", "y", "z"].get(place).filter(|_| length <= 3) {
            Some(letter) => Name::new(&format!("{self}{letter}")),
            None => Name::new(&format!("{self}{}", place + 1)),
        }
    }
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl fmt::Debug for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl From<&str> for Name {
    fn from(text: &str) -> Name {
        Name::new(text)
    }
}
