//! What is a whole number, and integers in linear arithmetic: what may be no integer is given up for the sums of the facts
//! that bound it (Fourier and Motzkin), and what then speaks of integers alone is as sharp as integers are. With
//! `n = 4*floor(n/4+1/2) - 1` it follows that `floor(n/4) = floor(n/4+1/2) - 1`.

use std::collections::{BTreeMap, BTreeSet};

use num_bigint::BigInt;
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{One, Signed, ToPrimitive, Zero};

use super::linear::{Bound, Constraint};
use super::refute::{Form, MOST_CONSTRAINTS};
use super::sign::Signs;
use super::{Assumptions, Relation};
use crate::polynomial::{Monomial, Polynomial};
use crate::value::{Atom, Sort, Value};

/// The most terms of a sum, and its longest numbers in bits: longer ones bound no integer that is of use.
const MOST_TERMS: usize = 12;
const MOST_BITS: u64 = 64;
/// The greatest divisor of which each rest is looked at.
const MOST_DIVISOR: i64 = 12;

/// The unknowns of a form: its monomials besides 1.
fn unknowns(form: &Form) -> impl Iterator<Item = &(Monomial<Atom>, BigRational)> {
    form.terms().iter().filter(|(monomial, _)| !monomial.factors().is_empty())
}

fn factor_of(form: &Form, unknown: &Monomial<Atom>) -> Option<BigRational> {
    unknowns(form).find(|(own, _)| own == unknown).map(|(_, factor)| factor.clone())
}

impl Assumptions {
    /// Whether a value is 0, 1, 2, …
    pub fn is_natural(&self, value: &Value) -> Option<bool> {
        if value.sort() != Sort::Real {
            return Some(false);
        }
        if let Some(number) = value.as_rational() {
            return Some(number.is_integer() && !number.is_negative());
        }
        if let Some(fraction) = self.fraction_part(value) {
            if !fraction.is_zero() {
                return Some(false);
            }
            return self.decide(Relation::Gte, value, &Value::zero());
        }
        if self.is_stated_whole(value) {
            return self.decide(Relation::Gte, value, &Value::zero());
        }
        if self.decide(Relation::Gte, value, &Value::zero()) == Some(false) { Some(false) } else { None }
    }

    /// Whether it is assumed of just this value that it is its integer part.
    fn is_stated_whole(&self, value: &Value) -> bool {
        let whole = |zero: &Value| zero.atoms().iter().any(|atom| matches!(atom, Atom::Floor(_)));
        let any = self.stated.iter().any(|(relation, zero)| *relation == Relation::Eq && whole(zero));
        let rest = || value.floor().and_then(|floor| floor.sub(value)).ok();
        any && rest().is_some_and(|rest| self.as_stated(Relation::Eq, &rest) == Some(true))
    }

    /// The constant by which a value differs from an integer, at least 0 and less than 1; `None` when unknown.
    pub(super) fn fraction_part(&self, value: &Value) -> Option<BigRational> {
        let value = self.with_solved(value);
        let (numerator, denominator) = value.polynomials()?;
        if !denominator.is_one() {
            return None;
        }
        let integral = numerator.terms().iter().all(|(monomial, number)| {
            monomial.factors().is_empty() || (number.is_integer() && self.all_integral(monomial))
        });
        let constant = numerator.constant_term();
        integral.then(|| &constant - constant.floor())
    }

    /// Whether every term of a polynomial is an integer, by what its variables are themselves.
    pub(super) fn all_terms_integral(&self, value: &Value) -> bool {
        value.polynomials().is_some_and(|(numerator, denominator)| {
            let integral =
                |(monomial, number): &(Monomial<Atom>, BigRational)| number.is_integer() && self.all_integral(monomial);
            denominator.is_one() && numerator.terms().iter().all(integral)
        })
    }

    /// The small number above 1 of which a value is an integer divided by it; none where it is not known to be that.
    pub(super) fn divisor_of_integers(&self, value: &Value) -> Option<i64> {
        let (numerator, denominator) = value.polynomials()?;
        let integral = numerator.terms().iter().all(|(monomial, _)| self.all_integral(monomial));
        let divisor = numerator.terms().iter().fold(BigInt::one(), |all, (_, number)| all.lcm(number.denom()));
        divisor.to_i64().filter(|divisor| denominator.is_one() && integral && (2..=MOST_DIVISOR).contains(divisor))
    }

    /// Whether all factors of a monomial are integers.
    pub(super) fn all_integral(&self, monomial: &Monomial<Atom>) -> bool {
        monomial.factors().iter().all(|(atom, _)| match atom {
            Atom::Variable(name) => self.naturals.contains(name),
            // An index that begins below 0 is not known to be natural.
            Atom::Power(base, exponent) => {
                exponent.variables().is_subset(&self.naturals)
                    && exponent.is_whole()
                    && self.quick(exponent).within(Signs::NONNEGATIVE)
                    && (atom.is_integral() || self.fraction_part(base).is_some_and(|fraction| fraction.is_zero()))
            }
            other => other.is_integral(),
        })
    }

    /// Whether no integers make a polynomial 0, as `3*n-17`: its terms are multiples of a number of which the constant is
    /// none.
    pub(super) fn has_no_whole_zero(&self, form: &Form) -> bool {
        let constant = form.constant_term();
        if constant.is_zero() || !unknowns(form).all(|(unknown, _)| self.all_integral(unknown)) {
            return false;
        }
        let rest = form.minus(&Polynomial::constant(constant.clone()));
        !rest.is_zero() && !(constant / rest.content()).is_integer()
    }

    /// What the facts of a system say of its integers alone; empty where no integer part stands in it.
    pub(super) fn of_integers(&self, system: &[Constraint]) -> Vec<Constraint> {
        let parts = |one: &Constraint| one.form.atoms().into_iter().any(|atom| matches!(atom, Atom::Floor(_)));
        if !system.iter().any(parts) {
            return Vec::new();
        }
        // What is so of integers times something is of no integers alone, and is lost when that is given up.
        let mut sharper: BTreeSet<Constraint> = BTreeSet::new();
        let mut sharpened = |row: Constraint| {
            let found = self.sharpened(row.clone());
            if found != row && !found.form.monomial_content().factors().is_empty() {
                sharper.insert(found.clone());
            }
            found
        };
        let mut rows: BTreeSet<Constraint> = system.iter().cloned().map(&mut sharpened).collect();
        self.equate(&mut rows);
        while let Some(unknown) = self.cheapest(&rows) {
            let (with, without): (Vec<Constraint>, Vec<Constraint>) =
                rows.into_iter().partition(|row| factor_of(&row.form, &unknown).is_some());
            let mut rest = BTreeSet::from_iter(without);
            rest.extend(sums_without(&with, &unknown).into_iter().map(&mut sharpened));
            if rest.len() > MOST_CONSTRAINTS {
                rows = BTreeSet::new();
                break;
            }
            rows = rest;
            self.equate(&mut rows);
        }
        rows.extend(sharper);
        rows.into_iter().filter(|row| !system.contains(row)).collect()
    }

    /// Of the unknowns that may be no integers the one that leaves the fewest sums; last those of which integers are
    /// multiples, as `t*v` beside `t*v*floor(d/(t*v))`. Then integers that an equation gives as sums of multiples of others.
    fn cheapest(&self, rows: &BTreeSet<Constraint>) -> Option<Monomial<Atom>> {
        let mut bounds: BTreeMap<&Monomial<Atom>, (bool, usize, usize)> = BTreeMap::new();
        for row in rows {
            for (unknown, factor) in unknowns(&row.form) {
                let entry = bounds.entry(unknown).or_default();
                entry.0 |= row.bound == Bound::Zero;
                if factor.is_positive() { entry.1 += 1 } else { entry.2 += 1 }
            }
        }
        let counting =
            |unknown: &Monomial<Atom>| unknown.factors().iter().any(|(atom, _)| matches!(atom, Atom::Floor(_)));
        let all: Vec<&Monomial<Atom>> = bounds.keys().copied().filter(|unknown| counting(unknown)).collect();
        let multiplied = |unknown: &Monomial<Atom>| all.iter().any(|other| other.over(unknown).is_some());
        let cost = |(equated, lower, upper): (bool, usize, usize)| if equated { 0 } else { lower * upper };
        let real: Vec<_> = bounds.iter().filter(|(unknown, _)| !self.all_integral(unknown)).collect();
        let least = real.into_iter().min_by_key(|(unknown, counts)| (multiplied(unknown), cost(**counts)));
        least.map(|(unknown, _)| (*unknown).clone()).or_else(|| rows.iter().find_map(|row| self.given(row)))
    }

    /// What is at least 0 and at most 0, of integers, is 0.
    fn equate(&self, rows: &mut BTreeSet<Constraint>) {
        let least = |row: &&Constraint| row.bound == Bound::Nonnegative;
        let whole = |row: &Constraint| unknowns(&row.form).all(|(unknown, _)| self.all_integral(unknown));
        let opposite = |row: &Constraint| Constraint { form: row.form.negated(), ..row.clone() };
        let both = rows.iter().filter(least).filter(|row| rows.contains(&opposite(row)) && whole(row));
        let both: Vec<Constraint> = both.cloned().collect();
        for row in both {
            let other = opposite(&row);
            if rows.remove(&other) && rows.remove(&row) {
                rows.insert(Constraint { bound: Bound::Zero, ..row });
            }
        }
    }

    /// The integer that an equation between integers gives as a sum of multiples of the others.
    fn given(&self, row: &Constraint) -> Option<Monomial<Atom>> {
        let whole = unknowns(&row.form).all(|(unknown, _)| self.all_integral(unknown));
        let content = (row.bound == Bound::Zero && whole).then(|| row.form.content())?;
        let alone = |(_, factor): &&(Monomial<Atom>, BigRational)| factor.abs() == content;
        unknowns(&row.form).find(alone).map(|(unknown, _)| unknown.clone())
    }

    /// A fact of integers as sharp as it is; an equation that no integers solve is one between numbers. The same of such a
    /// fact times what is more than 0: `t*v*n > 2*t*v` is `t*v*n >= 3*t*v`.
    fn sharpened(&self, constraint: Constraint) -> Constraint {
        if constraint.form.as_constant().is_some() {
            return constraint;
        }
        let factor = constraint.form.monomial_content();
        if !factor.factors().is_empty() && self.monomial_signs(&factor).within(Signs::POSITIVE) {
            let inner = self.sharpened(Constraint { form: constraint.form.without(&factor), ..constraint });
            return match inner.form.times_term(&factor, &BigRational::one()) {
                Some(form) => Constraint { form, ..inner },
                None => constraint,
            };
        }
        let Constraint { form, bound } = self.tightened(constraint);
        let unsolved = bound == Bound::Zero && self.has_no_whole_zero(&form);
        Constraint { form: if unsolved { Polynomial::one() } else { form }, bound }
    }
}

/// What facts say of the others without an unknown that stands in each: by an equation, if there is one, else by every two
/// that bound it from either side.
fn sums_without(with: &[Constraint], unknown: &Monomial<Atom>) -> Vec<Constraint> {
    let factor = |row: &Constraint| factor_of(&row.form, unknown).unwrap_or_else(BigRational::one);
    let equation = with.iter().filter(|row| row.bound == Bound::Zero).min_by_key(|row| row.form.terms().len());
    let sum = |one: &Constraint, times: &BigRational, other: &Constraint, bound: Bound| {
        let form = one.form.scale(times).plus(&other.form);
        let short = form.terms().len() <= MOST_TERMS && form.bits() <= MOST_BITS;
        let says = form.as_constant().is_none_or(|number| !bound.admits(&number));
        (short && says).then_some(Constraint { form, bound })
    };
    if let Some(equation) = equation {
        let others = with.iter().filter(|row| *row != equation);
        return others.filter_map(|row| sum(equation, &-(factor(row) / factor(equation)), row, row.bound)).collect();
    }
    let (lower, upper): (Vec<&Constraint>, Vec<&Constraint>) = with.iter().partition(|row| factor(row).is_positive());
    let pairs = lower.iter().flat_map(|low| upper.iter().map(move |high| (*low, *high)));
    pairs
        .filter_map(|(low, high)| sum(low, &(factor(high) / factor(low)).abs(), high, low.bound.max(high.bound)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::name::Name;

    #[test]
    fn integers_times_what_is_positive_are_as_sharp_as_integers() {
        let [d, t, v] = ["d", "t", "v"].map(|name| Value::variable(&Name::new(name)));
        let step = t.mul(&v).unwrap();
        let times = |number: i64, value: &Value| Value::integer(number).mul(value).unwrap();
        let rounds = d.div(&step).unwrap().ceiling().unwrap();
        let mut known = Assumptions::default();
        let bound = step.add(&step.mul(&rounds).unwrap()).unwrap();
        known.assume(Relation::Lte, &times(2, &d), &bound);
        let holds = |known: &Assumptions, less: i64, more: i64| {
            known.decide(Relation::Gte, &times(less, &step), &times(more, &d))
        };
        assert_eq!(holds(&known, 3, 2), None, "the signs are not known");
        for value in [&d, &t, &v] {
            known.assume(Relation::Gtr, value, &Value::zero());
        }
        // With x = d/(t*v) that is 2*x <= ceil(x)+1, so that x is at most 3/2.
        assert_eq!(holds(&known, 3, 2), Some(true));
        assert_eq!(holds(&known, 5, 4), None, "so for x = 1, not for 3/2");
        known.assume(Relation::Gtr, &times(4, &d), &times(5, &step));
        assert_eq!(known.decide(Relation::Eq, &rounds, &Value::integer(2)), Some(true));
    }

    #[test]
    fn an_equation_between_integers_tells_the_rest_of_a_fraction() {
        let m = Value::variable(&Name::new("m"));
        let half = |value: &Value| value.div(&Value::integer(2)).unwrap();
        let mut even = Assumptions::default();
        even.assume_natural(&Name::new("m"));
        let mut odd = even.clone();
        let twice = half(&m).ceiling().unwrap().mul(&Value::integer(2)).unwrap();
        let more = m.add(&Value::one()).unwrap();
        let less = half(&m.sub(&Value::one()).unwrap());
        assert_eq!(even.simplify(&twice), twice);
        even.assume(Relation::Lss, &twice, &more);
        odd.assume(Relation::Eq, &twice, &more);
        assert_eq!(even.simplify(&twice), m);
        assert_eq!(odd.simplify(&twice), more);
        assert_eq!(odd.decide(Relation::Eq, &less.ceiling().unwrap(), &less), Some(true));
        assert_eq!(odd.simplify(&less.ceiling().unwrap()), less);
        assert_eq!(even.simplify(&less.ceiling().unwrap()), half(&m));
    }
}
