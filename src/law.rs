//! Laws: equations and refinements between processes, as data. None is written in Rust; all come from `rules/`.

use std::collections::BTreeSet;
use std::sync::Arc;

use crate::name::Name;
use crate::term::Term;
use crate::value::{Relation, Value};

/// What a statement says of its two sides.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Connective {
    /// `P = Q`: strong timed bisimulation over outcomes, results, observations, actions and time.
    Equal,
    /// `P <= Q`: Q does the same and shows no observation that P does not show at that moment.
    Refines,
    /// `P ~~ Q`: weak timed bisimulation that compares outcomes exactly: internal steps do not count, and what is
    /// shown counts only while time passes.
    Weak,
    /// `P <~ Q`: weakly, Q does the same and shows no observation that P does not show meanwhile.
    WeaklyRefines,
}

impl Connective {
    /// What holds of the ends of a chain of two such statements.
    pub fn join(self, other: Connective) -> Connective {
        match (self, other) {
            (Connective::Equal, one) | (one, Connective::Equal) => one,
            (one, two) if one == two => one,
            _ => Connective::WeaklyRefines,
        }
    }

    /// Whether a statement made with this one gives the same statement made with the other.
    pub fn gives(self, other: Connective) -> bool {
        self.join(other) == other
    }

    /// Whether the sides may be exchanged.
    pub fn is_symmetric(self) -> bool {
        matches!(self, Connective::Equal | Connective::Weak)
    }

    /// Whether internal steps are passed over.
    pub fn is_weak(self) -> bool {
        matches!(self, Connective::Weak | Connective::WeaklyRefines)
    }

    /// Whether the right side may show less.
    pub fn refines(self) -> bool {
        matches!(self, Connective::Refines | Connective::WeaklyRefines)
    }
}

/// What may be asked of one process. Each name is written in laws as here, in small letters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Fact {
    /// `never_aborts(P)`
    NeverAborts,
    /// `never_stops(P)`
    NeverStops,
    /// `silent(P)`: no In and no Out, not even inside `new`
    Silent,
    /// `draws_nothing(P)`: no random draw
    DrawsNothing,
    /// `binds_nothing(P)`: carries no result when it stops
    BindsNothing,
    /// `observer(P)`: never ends, does nothing, shows the same for ever
    Observer,
    /// `guard(P)`: ends at once by a comparison
    Guard,
    /// `not_stopped(P)`: has not stopped already at its start
    NotStopped,
    /// `running(P)`: has not ended already at its start
    Running,
    /// `guarded(P)`: cannot stop having neither waited nor communicated
    Guarded,
    /// `immediate(P)`: has stopped already at its start
    Immediate,
    /// `still(P)`: offers no communication and makes no internal step before it has waited
    Still,
}

impl Fact {
    /// All of them with their spelling.
    pub const ALL: [(Fact, &'static str); 12] = [
        (Fact::NeverAborts, "never_aborts"),
        (Fact::NeverStops, "never_stops"),
        (Fact::Silent, "silent"),
        (Fact::DrawsNothing, "draws_nothing"),
        (Fact::BindsNothing, "binds_nothing"),
        (Fact::Observer, "observer"),
        (Fact::Guard, "guard"),
        (Fact::NotStopped, "not_stopped"),
        (Fact::Running, "running"),
        (Fact::Guarded, "guarded"),
        (Fact::Immediate, "immediate"),
        (Fact::Still, "still"),
    ];

    /// Its spelling in laws.
    pub fn spelling(self) -> &'static str {
        Fact::ALL.iter().find(|(fact, _)| *fact == self).map_or("", |(_, spelling)| spelling)
    }
}

/// A condition of a law, or a hypothesis of a claim.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Condition {
    /// `a <= b` and the other comparisons
    Compare(Relation, Value, Value),
    /// `natural(n)`: n is 0, 1, 2, …
    Natural(Value),
    /// `never_aborts(P)` and the others of [`Fact`]
    Is(Fact, Term),
    /// `lasts(P, t)`: silent, binds nothing, and always stops, after exactly t
    Lasts(Term, Value),
    /// `complementary(G, H)`: guards, of which exactly one stops
    Complementary(Term, Term),
    /// `no_port(P, c)`: P does not use port c
    NoPort(Term, Name),
    /// `unread(P, y)`: P does not read y
    Unread(Term, Name),
    /// `apart(P, Q)`: no name that P binds is bound or read by Q
    Apart(Term, Term),
    /// `shows_only(P, S)`: every observer in P is named in S
    ShowsOnly(Term, BTreeSet<Name>),
    /// `shows_none(P, S)`: no observer in P is named in S
    ShowsNone(Term, BTreeSet<Name>),
}

/// A law: its two sides are equal (or refine) for all values of its metavariables that meet the conditions.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Law {
    /// Unique, in small letters and dashes: `delay-sum`.
    pub name: Name,
    /// One sentence.
    pub title: String,
    /// `paper §…`, or `ours` with a reason.
    pub source: String,
    /// Equality or refinement.
    pub connective: Connective,
    /// Whether simplification uses it, from left to right (written `=>`).
    pub oriented: bool,
    /// All must hold of the instance.
    pub conditions: Vec<Condition>,
    /// The left side.
    pub left: Term,
    /// The right side; binds no metavariable that the left does not.
    pub right: Term,
    /// `try` lines: instances that must be provable by this law.
    pub examples: Vec<(Term, Term)>,
}

/// The laws in force, in order; cheap to copy.
#[derive(Clone, Debug, Default)]
pub struct Laws(Arc<Vec<Arc<Law>>>);

impl Laws {
    /// The law of this name.
    pub fn get(&self, name: &Name) -> Option<&Arc<Law>> {
        self.0.iter().find(|law| law.name == *name)
    }

    /// Appends one; the caller has seen to it that the name is new.
    pub fn push(&mut self, law: Law) {
        Arc::make_mut(&mut self.0).push(Arc::new(law));
    }

    /// All, in the order of loading.
    pub fn iter(&self) -> impl Iterator<Item = &Arc<Law>> {
        self.0.iter()
    }
}
