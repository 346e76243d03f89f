//! The signs of products, of which each factor is asked by itself, and of powers that are written out.

use num_traits::Signed;

use super::Assumptions;
use super::sign::{Signs, turned};
use crate::polynomial::{Monomial, Polynomial};
use crate::value::Atom;

impl Assumptions {
    /// The signs of a written out power of a sum.
    pub(super) fn signs_of_power(&self, form: &Polynomial<Atom>, wanted: Signs, systems: &mut usize) -> Signs {
        let Some((sum, power, number)) = form.as_power_of_sum() else { return Signs::ANY };
        let asked = match (power % 2, number.is_negative()) {
            (0, _) => Signs::ZERO,
            (_, true) => wanted.flipped(),
            (_, false) => wanted,
        };
        Signs::of_number(&number).times(self.signs_of_form(&sum, asked, 0, systems).power(power))
    }

    /// The signs of a product of atoms, each asked by itself.
    pub(super) fn signs_of_product(&self, product: &Monomial<Atom>, depth: usize, systems: &mut usize) -> Signs {
        let mut known = Signs::POSITIVE;
        let turned = turned(product);
        for (atom, exponent) in turned.as_deref().unwrap_or(product.factors()) {
            let factor = Polynomial::atom(atom.clone());
            let mut own = self.signs_of_form(&factor, Signs::ZERO, 0, systems);
            if !own.within(Signs::NONZERO) {
                own = own.and(self.signs_by_form(&factor, depth));
            }
            if let Atom::Power(base, _) = atom
                && let Some((base, below)) = base.polynomials()
                && below.is_one()
                && !own.within(Signs::POSITIVE)
            {
                let base = self.signs_of_form(base, Signs::POSITIVE, 0, systems);
                let signs = [Signs::POSITIVE, Signs::NONZERO].into_iter().find(|signs| base.within(*signs));
                own = own.and(signs.unwrap_or(Signs::ANY));
            }
            known = known.times(own.power(*exponent));
        }
        known
    }
}
