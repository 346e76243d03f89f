//! What can be wrong with a proof.

use std::fmt;

use crate::law::{Condition, Connective};
use crate::name::Name;
use crate::proof::StepId;
use crate::term::Term;
use crate::value::{Need, Value};

/// What can be wrong with a step. Each carries the terms at fault.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reason {
    /// A step that does not come before this one.
    NotEarlier(StepId),
    /// No law of this name is in force.
    UnknownLaw(Name),
    /// A condition that does not hold, or cannot be decided.
    Condition(Box<Condition>),
    /// Two terms that should be the same.
    Differ(Box<Term>, Box<Term>),
    /// The process called is not defined, or not with so many parameters.
    NotDefined(Box<Term>),
    /// A loop whose body may stop having neither waited nor communicated.
    Unguarded(Box<Term>),
    /// A refinement or a weak equality where more is needed.
    Weaker(Connective, Connective),
    /// A name that has a fixed meaning is bound, or one name is used for two things.
    Name(Name),
    /// A metavariable of a law is left without a meaning.
    Unbound(Name),
    /// A substitution that cannot be carried out.
    Stuck(String),
    /// A hypothesis that is used outside its induction, or one that was never discharged.
    Hypothesis(Box<Term>, Box<Term>),
    /// A value of the wrong sort, or a count that is no natural number.
    Sort(Box<Value>),
    /// Not a natural number variable that the induction may use.
    NotNatural(Name),
    /// The proof or a term is larger than the kernel's limits.
    TooLarge,
    /// A proof without steps, or something taken on trust without a reason.
    Empty,
    /// What is supposed is not known to exclude itself.
    Possible,
    /// A network that cannot be run on, and why.
    Advance(String),
    /// A round that may communicate, or that need not always stop after a time that is more than 0.
    Untimed(Box<Term>),
    /// A value that may have no meaning where those of the claim have.
    Undefined(Box<Need>),
    /// Cases are told apart by a name that nothing gives a meaning here.
    Unspoken(Name),
    /// What is wrong with the lemma of this name.
    Lemma(Name, Box<Reason>),
}

impl Reason {
    /// Whether the proof is turned down since something in it may have no value; that an exponent is an index of rounds, which
    /// is natural, is not seen everywhere.
    pub fn is_undefined(&self) -> bool {
        match self {
            Reason::Undefined(need) => !matches!(**need, Need::Natural(_)),
            Reason::Lemma(_, reason) => reason.is_undefined(),
            _ => false,
        }
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Reason::NotEarlier(step) => write!(f, "it uses step {step}, which does not come before it"),
            Reason::UnknownLaw(name) => write!(f, "there is no law named {name}"),
            Reason::Condition(_) => write!(f, "a condition of the law does not follow from what is assumed"),
            Reason::Differ(..) => write!(f, "two terms that should be the same differ"),
            Reason::NotDefined(_) => write!(f, "it unfolds a process that is not defined so"),
            Reason::Unguarded(_) => write!(f, "the loop may go round without waiting or communicating"),
            Reason::Weaker(given, needed) => write!(f, "it needs `{needed}` and has `{given}`"),
            Reason::Name(name) => write!(f, "{name} has a fixed meaning here and may not be bound"),
            Reason::Unspoken(name) => write!(f, "cases are told apart by {name}, of which nothing is said here"),
            Reason::Unbound(name) => write!(f, "the metavariable {name} is left without a meaning"),
            Reason::Stuck(why) => write!(f, "a substitution cannot be carried out: {why}"),
            Reason::Hypothesis(..) => write!(f, "an induction hypothesis is used outside its induction"),
            Reason::Sort(value) => write!(f, "{value} is not of the sort that is needed where it stands"),
            Reason::NotNatural(name) => write!(f, "induction on {name}, which need not be a natural number"),
            Reason::TooLarge => write!(f, "a term is larger than the kernel accepts"),
            Reason::Possible => write!(f, "what is supposed is not known to exclude itself"),
            Reason::Advance(why) => write!(f, "the network cannot be run on: {why}"),
            Reason::Untimed(_) => write!(f, "a round need not be silent and stop after a time that is more than 0"),
            Reason::Undefined(need) => write!(f, "{need}, and the claim does not need that"),
            Reason::Empty => write!(f, "it has no steps, or trusts for no reason"),
            Reason::Lemma(name, reason) => write!(f, "in the lemma {name}: {reason}"),
        }
    }
}
