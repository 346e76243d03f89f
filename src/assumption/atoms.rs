//! What holds of an atom by its meaning, and which facts speak of what stands inside one.

use std::collections::BTreeSet;

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Signed};

use super::Assumptions;
use super::linear::{Bound, Constraint};
use super::refute::{Form, MOST_CONSTRAINTS};
use super::sign::Signs;
use crate::name::Name;
use crate::polynomial::{Monomial, Polynomial};
use crate::value::{Atom, Relation, Value};

/// The parts of 1 to which roots of numbers are bounded.
const ROOT_PARTS: i64 = 1 << 24;

/// Numbers that the root of a number lies between, close to each other; both are the root where that is one of them.
pub(super) fn root_between(square: &BigRational) -> Option<(BigRational, BigRational)> {
    if square.is_negative() {
        return None;
    }
    let scale = BigInt::from(ROOT_PARTS);
    let parts = (square * BigRational::from_integer(&scale * &scale)).floor().to_integer().sqrt();
    let of = |parts: BigInt| BigRational::new(parts, scale.clone());
    let (low, high) = (of(parts.clone()), of(parts + 1));
    if &low * &low == *square {
        return Some((low.clone(), low));
    }
    (&low * &low <= *square && *square <= &high * &high).then_some((low, high))
}

/// Numbers that a product of several roots of numbers, `sqrt(2)*sqrt(5)`, lies between.
pub(super) fn root_of_number(monomial: &Monomial<Atom>) -> Option<[Constraint; 2]> {
    let square = |(atom, exponent): &(Atom, u32)| match atom {
        Atom::Root(inner) if *exponent == 1 => inner.as_rational(),
        _ => None,
    };
    let squares: Vec<BigRational> = monomial.factors().iter().map(square).collect::<Option<_>>()?;
    let (low, high) = root_between(&squares.iter().product()).filter(|_| squares.len() > 1)?;
    let own = Polynomial::term(monomial.clone(), BigRational::one());
    let least = |form: Form| Constraint { form, bound: Bound::Nonnegative };
    Some([least(own.minus(&Polynomial::constant(low))), least(Polynomial::constant(high).minus(&own))])
}

/// Whether an atom is a condition, or has one in it.
fn has_condition(atom: &Atom) -> bool {
    atom.is_binary() || atom.parts().into_iter().any(|part| part.atoms().iter().any(has_condition))
}

impl Assumptions {
    /// Whether what stands under a root that these polynomials speak of is surely not negative: known to be so, or needed
    /// for any of it to have a value. A root beside a condition may have none where the condition does not hold.
    pub(super) fn has_root<'f>(&self, inner: &Value, mut forms: impl Iterator<Item = &'f Form>) -> bool {
        let known = || {
            self.quick(inner).within(Signs::NONNEGATIVE)
                || inner.polynomials().is_some_and(|(top, below)| {
                    self.assumed(top).times(self.quick_signs(below)).within(Signs::NONNEGATIVE)
                        && self.quick_signs(below).within(Signs::NONZERO)
                })
        };
        !forms.any(|form| form.atoms().into_iter().any(has_condition)) || known()
    }

    /// What holds of an atom of these polynomials by its meaning.
    pub(super) fn facts_of_atom<'f>(
        &'f self,
        atom: &Atom,
        forms: impl Iterator<Item = &'f Form> + Clone,
    ) -> Vec<Constraint> {
        let own = Polynomial::atom(atom.clone());
        let one = Polynomial::one();
        let whole = |value: &Value| {
            value.polynomials().filter(|(_, below)| below.is_one()).map(|(numerator, _)| numerator.clone())
        };
        let least = |form: Form| Constraint { form, bound: Bound::Nonnegative };
        match atom {
            Atom::Variable(_) | Atom::Apply(..) => Vec::new(),
            Atom::Maximum(elements) => {
                // own >= N/D is own*D >= N for D > 0.
                let above = elements.iter().filter_map(|element| {
                    let (top, below) = element.polynomials()?;
                    if !self.quick_signs(below).within(Signs::POSITIVE) {
                        return None;
                    }
                    Some(least(own.times(below)?.minus(top)))
                });
                above.chain([least(own.clone())]).collect()
            }
            Atom::Positive(_) => vec![least(own.clone()), least(one.minus(&own))],
            Atom::Floor(inner) => self.facts_of_floor(&own, inner),
            Atom::Root(inner) => {
                let mut found = vec![least(own.clone())];
                found.extend(self.facts_of_lengths(atom, forms.clone()));
                if let (Some(radicand), Some(square)) = (whole(inner), own.power(2))
                    && self.has_root(inner, forms.chain(self.constraints.iter().map(|one| &one.form)))
                {
                    found.push(Constraint { form: square.minus(&radicand), bound: Bound::Zero });
                }
                if let Some((low, high)) = inner.as_rational().and_then(|square| root_between(&square)) {
                    found.push(least(own.minus(&Polynomial::constant(low))));
                    found.push(least(Polynomial::constant(high).minus(&own)));
                }
                found
            }
            Atom::Power(base, exponent) => self.facts_of_power(&own, base, exponent),
        }
    }

    /// `floor(x/d)*d <= x < floor(x/d)*d + d` for `d > 0`.
    fn facts_of_floor(&self, own: &Form, inner: &Value) -> Vec<Constraint> {
        let Some((top, below)) = inner.polynomials() else { return Vec::new() };
        let signs = self.assumed(below);
        let (top, below) = if signs.within(Signs::POSITIVE) {
            (top.clone(), below.clone())
        } else if signs.within(Signs::NEGATIVE) {
            (Polynomial::zero().minus(top), Polynomial::zero().minus(below))
        } else {
            return Vec::new();
        };
        let Some(floor) = own.times(&below) else { return Vec::new() };
        let rest = top.minus(&floor);
        let least = Constraint { form: rest.clone(), bound: Bound::Nonnegative };
        vec![least, Constraint { form: below.minus(&rest), bound: Bound::Positive }]
    }

    /// For n that is not negative `b^n >= 1` for `b >= 1`, `b^n >= b` then for `n >= 1`, and `b^n <= 1` for `0 <= b <= 1`;
    /// for n that is not positive the other way: `2^ceil(x)` is a power of 1/2 by `floor(-x)`.
    fn facts_of_power(&self, own: &Form, base: &Value, exponent: &Value) -> Vec<Constraint> {
        let one = Polynomial::one();
        let Some((base_form, true)) = base.polynomials().map(|(top, below)| (top, below.is_one())) else {
            return Vec::new();
        };
        let least = |form: Form| Constraint { form, bound: Bound::Nonnegative };
        let signs = self.quick(exponent);
        let (up, down) = (signs.within(Signs::NONNEGATIVE), signs.within(Signs::of(Relation::Lte)));
        if !up && !down {
            return Vec::new();
        }
        let (more, less) = (least(own.minus(&one)), least(one.minus(own)));
        if self.assumed(&base_form.minus(&one)).within(Signs::NONNEGATIVE) {
            if !up {
                return vec![less];
            }
            let whole = exponent.polynomials().is_some_and(|(top, below)| {
                below.is_one() && top.terms().iter().all(|(monomial, _)| self.all_integral(monomial))
            });
            let above = (whole && signs.within(Signs::POSITIVE)).then(|| least(own.minus(base_form)));
            return [Some(more), above].into_iter().flatten().collect();
        }
        // A power of 0 by what is below 0 is none.
        let sign = if up { Signs::NONNEGATIVE } else { Signs::POSITIVE };
        if self.assumed(&one.minus(base_form)).within(Signs::NONNEGATIVE) && self.quick(base).within(sign) {
            return vec![if up { less } else { more }];
        }
        Vec::new()
    }

    /// What is assumed of numbers of rounds, `floor(x/d)`, of which the system does not speak while it does of x: for
    /// d of a known sign also abs(d) times as much, which is comparable with x.
    pub(super) fn counted(&self, system: &[Constraint]) -> Vec<Constraint> {
        let known: BTreeSet<&Atom> = system.iter().flat_map(|one| one.form.atoms()).collect();
        let mut found = Vec::new();
        for constraint in &self.constraints {
            for atom in constraint.form.atoms() {
                let Atom::Floor(inner) = atom else { continue };
                let Some((top, below)) = inner.polynomials() else { continue };
                let mut parts = top.atoms().into_iter().chain(below.atoms());
                if known.contains(atom) || !parts.any(|atom| known.contains(atom)) {
                    continue;
                }
                found.extend(self.facts_of_floor(&Polynomial::atom(atom.clone()), inner));
                let size = match self.assumed(below) {
                    signs if signs.within(Signs::POSITIVE) => Some(below.clone()),
                    signs if signs.within(Signs::NEGATIVE) => Some(below.negated()),
                    _ => None,
                };
                if let Some(form) = size.and_then(|size| constraint.form.times(&size)) {
                    found.push(Constraint { form, bound: constraint.bound });
                }
                if found.len() > MOST_CONSTRAINTS {
                    return found;
                }
            }
        }
        found
    }

    /// What is assumed of maxima and conditions of which the system does not speak, while it does of what they are made
    /// of: `r = min(2,max(0,r))` bounds r, and says so only of each case.
    pub(super) fn within_maxima(&self, system: &[Constraint]) -> Vec<Constraint> {
        let known: BTreeSet<&Atom> = system.iter().flat_map(|one| one.form.atoms()).collect();
        let name = |atom: &Atom| if let Atom::Variable(name) = atom { Some(name.clone()) } else { None };
        let names: Vec<Name> = known.iter().copied().filter_map(name).collect();
        let hidden = |atom: &&Atom| {
            matches!(atom, Atom::Maximum(_) | Atom::Positive(_))
                && !known.contains(atom)
                && names.iter().any(|name| atom.mentions(name))
        };
        let mut found = Vec::new();
        for constraint in &self.constraints {
            let atoms = constraint.form.atoms();
            if atoms.iter().any(hidden) {
                found.push(constraint.clone());
                let fresh = atoms.into_iter().filter(|atom| !known.contains(atom));
                let forms = || system.iter().map(|one| &one.form);
                found.extend(fresh.flat_map(|atom| self.facts_of_atom(atom, forms())));
            }
            if found.len() > MOST_CONSTRAINTS {
                break;
            }
        }
        found
    }
}
