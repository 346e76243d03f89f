//! The six comparisons.

use std::cmp::Ordering;

/// A comparison of two values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Relation {
    /// `=`
    Eq,
    /// `!=`
    Neq,
    /// `>`
    Gtr,
    /// `>=`
    Gte,
    /// `<`
    Lss,
    /// `<=`
    Lte,
}

impl Relation {
    /// All six.
    pub const ALL: [Relation; 6] =
        [Relation::Eq, Relation::Neq, Relation::Gtr, Relation::Gte, Relation::Lss, Relation::Lte];

    /// The comparison that holds exactly when this one does not.
    pub fn negated(self) -> Relation {
        match self {
            Relation::Eq => Relation::Neq,
            Relation::Neq => Relation::Eq,
            Relation::Gtr => Relation::Lte,
            Relation::Gte => Relation::Lss,
            Relation::Lss => Relation::Gte,
            Relation::Lte => Relation::Gtr,
        }
    }

    /// The comparison with its sides exchanged: `a < b` is `b > a`.
    pub fn mirrored(self) -> Relation {
        match self {
            Relation::Gtr => Relation::Lss,
            Relation::Gte => Relation::Lte,
            Relation::Lss => Relation::Gtr,
            Relation::Lte => Relation::Gte,
            same => same,
        }
    }

    /// Its name as a process: `Eq`, `Neq`, …
    pub fn spelling(self) -> &'static str {
        match self {
            Relation::Eq => "Eq",
            Relation::Neq => "Neq",
            Relation::Gtr => "Gtr",
            Relation::Gte => "Gte",
            Relation::Lss => "Lss",
            Relation::Lte => "Lte",
        }
    }

    /// Its symbol: `=`, `!=`, …
    pub fn symbol(self) -> &'static str {
        match self {
            Relation::Eq => "=",
            Relation::Neq => "!=",
            Relation::Gtr => ">",
            Relation::Gte => ">=",
            Relation::Lss => "<",
            Relation::Lte => "<=",
        }
    }

    /// Whether two things that compare like this stand in the relation.
    pub fn holds(self, order: Ordering) -> bool {
        match self {
            Relation::Eq => order == Ordering::Equal,
            Relation::Neq => order != Ordering::Equal,
            Relation::Gtr => order == Ordering::Greater,
            Relation::Gte => order != Ordering::Less,
            Relation::Lss => order == Ordering::Less,
            Relation::Lte => order != Ordering::Greater,
        }
    }
}
