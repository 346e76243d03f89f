//! What waits for ever, in words.

use std::fmt;

use crate::name::Name;

/// A read or a write that waits for ever.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub struct Blocked {
    /// Who waits.
    pub component: String,
    /// On which port.
    pub port: Name,
    /// True of a read.
    pub reads: bool,
    /// Who else uses the port the other way.
    pub partners: Vec<String>,
    /// Whether they came to it before.
    pub before: Before,
}

/// Whether something passed through a port in a run before a place is reached.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Default)]
pub enum Before {
    /// In none.
    #[default]
    Never,
    /// In some, as far as is known.
    Perhaps,
    /// In every one.
    Always,
}

impl Blocked {
    /// That nobody else comes to the port.
    pub(super) fn unanswered(&self) -> String {
        let (does, other) = if self.reads { ("reads", "writes") } else { ("writes", "reads") };
        format!("{} {does} port {}, which nobody {other}", self.component, self.port)
    }
}

impl fmt::Display for Blocked {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (does, other) = if self.reads { ("reads", "writes") } else { ("writes", "reads") };
        write!(f, "{} {does} port {} and waits for ever: ", self.component, self.port)?;
        match self.partners.as_slice() {
            [] => write!(f, "nobody {other} it"),
            partners => {
                let comes = match self.before {
                    Before::Never => "never comes to it",
                    Before::Perhaps => "does not come to it from there on",
                    Before::Always => "never comes to it again",
                };
                write!(f, "{}, who {other} it, {comes}", partners.join(" or "))
            }
        }
    }
}
