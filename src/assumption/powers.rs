//! Signs of sums of powers with coefficients, `200*p + 3^n*(b - 200*p)`.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use super::refute::Form;
use super::sign::Signs;
use super::{Assumptions, Relation};
use crate::polynomial::{Monomial, Polynomial};
use crate::value::{Atom, Value};

/// How often a base may stand in a power whose size is compared.
const MOST_COUNT: u32 = 64;

impl Assumptions {
    /// The signs of a sum of powers with coefficients, `200*p + 3^n*(b - 200*p)`, from those of the coefficients.
    pub(super) fn signs_by_powers(&self, form: &Form, depth: usize, systems: &mut usize) -> Option<Signs> {
        let mut groups: BTreeMap<Monomial<Atom>, Form> = BTreeMap::new();
        for (monomial, number) in form.terms() {
            let is_power = |(atom, _): &&(Atom, u32)| matches!(atom, Atom::Power(..));
            let powers = Monomial::of(monomial.factors().iter().filter(is_power).cloned())?;
            let rest = monomial.over(&powers)?;
            let coefficient = groups.entry(powers).or_insert_with(Form::zero);
            *coefficient = coefficient.plus(&Polynomial::term(rest, number.clone()));
        }
        let of_sums = groups.values().any(|coefficient| coefficient.terms().len() > 1);
        if groups.len() < 2 || !of_sums {
            return None;
        }
        if let Some(signs) = self.signs_of_two(&groups, depth, systems).filter(|signs| *signs != Signs::ANY) {
            return Some(signs);
        }
        let mut sum = Signs::ZERO;
        for (powers, coefficient) in &groups {
            let own = self.monomial_signs(powers);
            sum = sum.plus(own.times(self.signs_of_form(coefficient, Signs::ZERO, depth - 1, systems)));
            if sum == Signs::ANY {
                return None;
            }
        }
        Some(sum)
    }

    /// Of `a*M + b*m` with powers `0 < m <= M`: it is `(a + b*q)*M` with q above 0 and at most 1, and what stands in the brackets
    /// lies between a and a+b, at the latter perhaps.
    fn signs_of_two(
        &self,
        groups: &BTreeMap<Monomial<Atom>, Form>,
        depth: usize,
        systems: &mut usize,
    ) -> Option<Signs> {
        let [(one, first), (other, second)] = groups.iter().collect::<Vec<_>>().try_into().ok()?;
        let (most, least) = match self.order_of_powers(one, other)? {
            Ordering::Less => (second, first),
            _ => (first, second),
        };
        let end = self.signs_of_form(&most.plus(least), Signs::ZERO, depth - 1, systems);
        let limit = self.signs_of_form(most, Signs::ZERO, depth - 1, systems);
        Some(end.plus(limit.times(Signs::NONNEGATIVE)))
    }

    /// How two products of powers of what is positive, with one natural exponent, compare, whatever that is: less, or not
    /// more, is `Less`.
    fn order_of_powers(&self, one: &Monomial<Atom>, other: &Monomial<Atom>) -> Option<Ordering> {
        let (one, exponent) = base_of(one)?;
        let (other, same) = base_of(other)?;
        if exponent.is_some() && same.is_some() && exponent != same {
            return None;
        }
        if !self.quick(exponent.or(same)?).within(Signs::NONNEGATIVE) {
            return None;
        }
        let signs = |value: &Value| match value.polynomials() {
            Some((form, below)) if self.quick_signs(below).within(Signs::POSITIVE) => self.assumed(form),
            _ => Signs::ANY,
        };
        if !signs(&one).within(Signs::POSITIVE) || !signs(&other).within(Signs::POSITIVE) {
            return None;
        }
        let difference = signs(&one.sub(&other).ok()?);
        if difference.within(Signs::of(Relation::Lte)) {
            Some(Ordering::Less)
        } else {
            difference.within(Signs::NONNEGATIVE).then_some(Ordering::Greater)
        }
    }
}

/// The product of the bases of powers with one exponent, and that; none of the empty product.
fn base_of(powers: &Monomial<Atom>) -> Option<(Value, Option<&Value>)> {
    let mut common: Option<&Value> = None;
    let mut product = Value::one();
    for (atom, count) in powers.factors() {
        let Atom::Power(base, exponent) = atom else { return None };
        if *common.get_or_insert(exponent) != exponent || *count > MOST_COUNT {
            return None;
        }
        product = product.mul(&base.power(&Value::integer(i64::from(*count))).ok()?).ok()?;
    }
    Some((product, common))
}
