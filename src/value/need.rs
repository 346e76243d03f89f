//! What must hold for a value to be one: that it divides by nothing that is 0, and the like.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use super::squares::over_length;
use super::{Atom, Content, Real, Value, ValueError};
use crate::name::Name;
use crate::polynomial::{Budget, Monomial};

/// The work that may go into one division of polynomials.
const DIVISION_BUDGET: u64 = 50_000;

/// One thing that must hold for a value to have a meaning.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Need {
    /// It is divided by, so it is not 0.
    Nonzero(Value),
    /// It stands under a root, so it is not negative.
    Nonnegative(Value),
    /// It is an exponent, so it is 0, 1, 2, …
    Natural(Value),
}

impl Need {
    /// What it is about.
    pub fn value(&self) -> &Value {
        match self {
            Need::Nonzero(value) | Need::Nonnegative(value) | Need::Natural(value) => value,
        }
    }

    /// The same of this value with others put in.
    ///
    /// # Errors
    /// When that has no meaning.
    pub fn substitute(&self, images: &BTreeMap<Name, Value>) -> Result<Need, ValueError> {
        let image = self.value().substitute(images)?;
        Ok(match self {
            Need::Nonzero(_) => Need::Nonzero(image),
            Need::Nonnegative(_) => Need::Nonnegative(image),
            Need::Natural(_) => Need::Natural(image),
        })
    }

    /// The needs that it comes to: a product is not 0 where no factor is.
    pub fn apart(&self) -> Vec<Need> {
        let factors = || {
            let Need::Nonzero(Value(own)) = self else { return None };
            let Content::Real(own, _) = &own.content else { return None };
            let [(monomial, _)] = own.terms() else { return None };
            monomial.factors().iter().map(|(atom, _)| atom.value().ok().map(Need::Nonzero)).collect()
        };
        factors().unwrap_or_else(|| vec![self.clone()])
    }

    /// Whether it holds wherever one of these does.
    pub fn follows_from(&self, others: &BTreeSet<Need>) -> bool {
        if others.contains(self) {
            return true;
        }
        // Where the root has a value, its square is what it is taken of: `x^2*y` where `abs(x)*sqrt(y)` has one.
        if let Need::Nonnegative(value) = self {
            return value.sqrt().is_ok_and(|root| root.needs().is_subset(others));
        }
        let Need::Nonzero(Value(own)) = self else { return false };
        let Content::Real(own, _) = &own.content else { return false };
        // A root is 0 just where what it is taken of is.
        let symbolic = |(atom, _): &&(Atom, u32)| !atom.is_root_of_number();
        if let [(monomial, _)] = own.terms()
            && let [(Atom::Root(inner), 1)] = monomial.factors().iter().filter(symbolic).collect::<Vec<_>>().as_slice()
            && let Some(inner) = inner.numerator()
            && Need::Nonzero(inner).follows_from(others)
        {
            return true;
        }
        others.iter().any(|other| {
            let Need::Nonzero(Value(other)) = other else { return false };
            let Content::Real(other, _) = &other.content else { return false };
            let divides = |whole: &Real| whole.divide(own, &mut Budget::new(DIVISION_BUDGET)).is_some();
            let under_root = |atom: &Atom| match atom {
                Atom::Root(inner) => inner.parts().is_some_and(|(inner, _)| divides(inner)),
                _ => false,
            };
            // What stands under a root that is not 0 is not 0 either.
            let root = |(atom, _): &(Atom, u32)| under_root(atom);
            divides(other) || matches!(other.terms(), [(monomial, _)] if monomial.factors().iter().any(root))
        })
    }
}

impl fmt::Display for Need {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Need::Nonzero(value) => write!(f, "{value}, by which it divides, may be 0"),
            Need::Nonnegative(value) => write!(f, "{value}, of which it takes the root, may be negative"),
            Need::Natural(value) => write!(f, "{value}, an exponent, need not be a natural number"),
        }
    }
}

/// What is 0 just where this is, and shorter: e of `|e|`, before which any number may stand.
fn without_length(value: Value) -> Value {
    let inside = |atom: &Atom| {
        let Atom::Maximum(elements) = atom else { return None };
        let [inner] = elements.as_ref() else { return None };
        let times = value.div(&inner.abs().ok()?).ok()?.as_rational();
        times.map(|_| inner.clone())
    };
    value.atoms().iter().find_map(inside).unwrap_or(value)
}

impl Value {
    /// All that must hold for it to have a meaning with others put in for names, taken before they are: what cancels then is
    /// needed as well. Where a condition is decided by them, what is chosen counts alone.
    ///
    /// # Errors
    /// When that has no meaning.
    pub fn needs_with(&self, images: &BTreeMap<Name, Value>) -> Result<BTreeSet<Need>, ValueError> {
        let read = self.variables();
        let mut needs: BTreeSet<Need> =
            read.iter().filter_map(|name| images.get(name)).flat_map(Value::needs).collect();
        let mut chosen = self.clone();
        while let Some((condition, holds)) = chosen.decided_with(images) {
            for need in condition.value()?.needs() {
                needs.insert(need.substitute(images)?);
            }
            chosen = chosen.replace(&mut |atom| (*atom == condition).then(|| holds.clone()))?;
        }
        for need in chosen.needs() {
            needs.insert(need.substitute(images)?);
        }
        Ok(needs)
    }

    /// A condition in it of which it is known with these whether it holds, and that as a number.
    fn decided_with(&self, images: &BTreeMap<Name, Value>) -> Option<(Atom, Value)> {
        self.atoms().into_iter().filter(|atom| matches!(atom, Atom::Positive(_))).find_map(|atom| {
            let holds = atom.value().ok()?.substitute(images).ok()?;
            holds.as_rational().is_some().then_some((atom, holds))
        })
    }

    /// All that must hold for it to have a meaning, whatever its variables are.
    pub fn needs(&self) -> BTreeSet<Need> {
        let mut found = BTreeSet::new();
        self.collect_needs(&mut found);
        found
    }

    /// Whether it is a sum of multiples of integer parts, and so a whole number wherever it has a value.
    fn is_whole_by_form(&self) -> bool {
        let Content::Real(sum, denominator) = &self.0.content else { return false };
        let rounded =
            |monomial: &Monomial<Atom>| monomial.factors().iter().all(|(atom, _)| matches!(atom, Atom::Floor(_)));
        denominator.is_one() && sum.terms().iter().all(|(monomial, number)| number.is_integer() && rounded(monomial))
    }

    fn collect_needs(&self, found: &mut BTreeSet<Need>) {
        let (numerator, denominator) = match &self.0.content {
            Content::Real(numerator, denominator) => (numerator, denominator),
            Content::Vector(parts) | Content::Distribution(_, parts) => {
                return parts.iter().for_each(|part| part.collect_needs(found));
            }
        };
        // By the square of a length that stands above it, it divides as by the length.
        let divisors = match over_length(numerator, denominator) {
            Some(over) => vec![over.root.value(), Value::whole(over.below)],
            None => vec![Value::whole(denominator.clone())],
        };
        let divisors = divisors.into_iter().flatten().filter(|divisor| divisor.as_rational().is_none());
        found.extend(divisors.map(|divisor| Need::Nonzero(without_length(divisor))));
        for atom in numerator.atoms().into_iter().chain(denominator.atoms()) {
            match atom {
                // The square of one that is never negative is known.
                Atom::Root(inner) if inner.as_rational().is_none() && atom.square().is_none() => {
                    found.insert(Need::Nonnegative(inner.clone()));
                }
                // A power of -1 has a value for each whole number.
                Atom::Power(_, exponent) if !(atom.is_sign() && exponent.is_whole_by_form()) => {
                    found.insert(Need::Natural(exponent.clone()));
                }
                _ => {}
            }
            atom.parts().into_iter().for_each(|part| part.collect_needs(found));
        }
    }
}
