//! Factors that the normal form of a polynomial hides.

use super::Assumptions;
use super::refute::{DIVISION_BUDGET, Form};
use crate::polynomial::{Budget, Polynomial};
use crate::value::Atom;
use crate::value::squares::square_of;

impl Assumptions {
    /// A factor that the normal form hides, with its exponent and the other: `(x-1)^2` of `x^2-2*x+1`, and of `v*s-a^2-b^2`
    /// the root `s = norm((a,b))`, as `s*s` is written `a^2+b^2`.
    pub(super) fn hidden_factor(&self, form: &Form) -> Option<(Form, u32, Form)> {
        if let Some((factor, root)) = square_of(form) {
            return Some((root, 2, Polynomial::constant(factor)));
        }
        let granted = |atom: &&Atom| match atom {
            Atom::Root(inner) => self.has_root(inner, std::iter::once(form)),
            _ => false,
        };
        let (root, mut rest) = form
            .atoms()
            .into_iter()
            .filter(granted)
            .find_map(|atom| Some((atom.clone(), without_root(form, atom)?)))?;
        let mut factor = Polynomial::atom(root.clone());
        // The root of a number is written as those of its prime factors.
        let beside = |atom: &&Atom| atom.is_root_of_number() && root.is_root_of_number() && **atom != root;
        for other in form.atoms().into_iter().filter(beside).cloned() {
            if let Some((less, product)) = without_root(&rest, &other).zip(factor.times(&Polynomial::atom(other))) {
                (rest, factor) = (less, product);
            }
        }
        Some((factor, 1, rest))
    }
}

/// What is left of a polynomial without a root that is a factor of it, as a square of it is written without the root.
fn without_root(form: &Form, atom: &Atom) -> Option<Form> {
    let Atom::Root(inner) = atom else { return None };
    let (radicand, below) = inner.polynomials()?;
    let mut coefficients = form.coefficients_in(atom);
    let (rest, mixed) = (coefficients.remove(&0)?, coefficients.remove(&1)?);
    if !below.is_one() || !coefficients.is_empty() {
        return None;
    }
    let quotient = rest.divide(radicand, &mut Budget::new(DIVISION_BUDGET))?;
    Some(quotient.times(&Polynomial::atom(atom.clone()))?.plus(&mixed))
}
