//! Factors that the normal form of a polynomial hides, and signs by what it is made of: squares, roots, integer parts.

use std::collections::BTreeSet;

use num_rational::BigRational;
use num_traits::{One, Signed};

use super::Assumptions;
use super::atoms::root_between;
use super::linear::Bound;
use super::refute::{DIVISION_BUDGET, Form};
use super::sign::Signs;
use crate::polynomial::{Budget, Monomial, Polynomial};
use crate::value::squares::square_of;
use crate::value::{Atom, Value};

/// Systems that are refuted on behalf of one form.
const FEW_SYSTEMS: usize = 12;
/// What is assumed of which multiples are looked for in a form, and the most terms of that.
const MOST_BOUNDS: usize = 8;
const MOST_BENT: usize = 40;

impl Assumptions {
    /// A factor that the normal form hides, with its exponent and the other: `(x-1)^2` of `x^2-2*x+1`, and of `v*s-a^2-b^2`
    /// the root `s = norm((a,b))`, as `s*s` is written `a^2+b^2`.
    fn hidden_factor(&self, form: &Form) -> Option<(Form, u32, Form)> {
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

    /// The signs of a form by those of a factor that its normal form hides, and of the other.
    pub(super) fn signs_by_hidden_factor(
        &self,
        form: &Form,
        wanted: Signs,
        depth: usize,
        systems: &mut usize,
    ) -> Option<Signs> {
        let (root, exponent, rest) = self.hidden_factor(form)?;
        // The root of a number is one of many, and what is left is often as long: that may not use up what there is.
        let number = root.atoms().into_iter().all(Atom::is_root_of_number);
        let mut few = FEW_SYSTEMS.min(*systems);
        let systems = if number { &mut few } else { systems };
        let known = self.signs_of_form(&root, Signs::ZERO, depth - 1, systems).power(exponent);
        Some(known.times(self.signs_of_form(&rest, wanted.beside(known), depth - 1, systems)))
    }

    /// The signs that a form has by what it is made of, where what is known does not tell them.
    pub(super) fn signs_by_form(&self, form: &Form, depth: usize) -> Signs {
        let mut systems = FEW_SYSTEMS;
        self.signs_by_square(form, depth, &mut systems)
            .or_else(|| self.signs_of_root(form, depth, &mut systems))
            .or_else(|| self.signs_by_conjugate(form, depth, &mut systems))
            .or_else(|| self.signs_by_floor(form, depth, &mut systems))
            .or_else(|| self.signs_by_bound(form))
            .or_else(|| self.signs_beyond_root(form, depth))
            .unwrap_or(Signs::ANY)
    }

    /// The signs of `a*x^2 + b*x + c` with a number a, by the square that is hidden in it: it is `a*(x + b/(2*a))^2` with what
    /// is left, `c - b^2/(4*a)`.
    fn signs_by_square(&self, form: &Form, depth: usize, systems: &mut usize) -> Option<Signs> {
        form.atoms().into_iter().filter(|atom| form.degree_in(atom) == 2).find_map(|atom| {
            let mut parts = form.coefficients_in(atom);
            let (first, mixed) = (parts.remove(&2)?.as_constant()?, parts.remove(&1)?);
            let fourth = (&first * BigRational::from_integer(4.into())).recip();
            let rest = parts.remove(&0).unwrap_or_else(Form::zero).minus(&mixed.times(&mixed)?.scale(&fourth));
            let twice = Polynomial::atom(atom.clone()).scale(&(&first + &first)).plus(&mixed);
            let apart = self.signs_of_form(&twice, Signs::NONZERO, depth - 1, systems).within(Signs::NONZERO);
            let square = if apart { Signs::POSITIVE } else { Signs::NONNEGATIVE };
            let square = if first.is_positive() { square } else { square.flipped() };
            let squares = |rest: &Form| Value::from_polynomials(rest.clone(), Form::one()).ok()?.squares();
            let nowhere_negative = if squares(&rest).is_some() { Signs::NONNEGATIVE } else { Signs::ANY };
            let rest = self.signs_of_form(&rest, Signs::ZERO, depth - 1, systems).and(nowhere_negative);
            let signs = square.plus(rest);
            (signs != Signs::ANY).then_some(signs)
        })
    }

    /// The signs of `a*(x + b)^2 - c` with numbers a and c of one sign, by how x+b lies to the root of c/a, or to numbers near it.
    fn signs_beyond_root(&self, form: &Form, depth: usize) -> Option<Signs> {
        let mut systems = FEW_SYSTEMS;
        form.atoms().into_iter().filter(|atom| form.degree_in(atom) == 2).find_map(|atom| {
            let mut parts = form.coefficients_in(atom);
            let (first, mixed) = (parts.remove(&2)?.as_constant()?, parts.remove(&1)?);
            let half = mixed.scale(&(&first + &first).recip());
            let square = half.times(&half)?.scale(&first);
            let rest = parts.remove(&0).unwrap_or_else(Form::zero).minus(&square).as_constant()?;
            let (low, high) = root_between(&-(rest / &first)).filter(|(_, high)| high.is_positive())?;
            let middle = Polynomial::atom(atom.clone()).plus(&half);
            // The root itself is no number that is near it.
            let exact = low == high;
            let mut over = |side: &Form, bound: &BigRational| {
                let over = side.minus(&Polynomial::constant(bound.clone()));
                let wanted = if exact { Signs::POSITIVE } else { Signs::NONNEGATIVE };
                let signs = self.signs_of_form(&over, wanted, depth - 1, &mut systems);
                if !exact && signs.within(Signs::NONNEGATIVE) { Signs::POSITIVE } else { signs }
            };
            let sides = [middle.clone(), middle.negated()];
            let outside = sides.iter().map(|side| over(side, &high)).find(|signs| signs.within(Signs::NONNEGATIVE));
            let mut inside = || {
                let under = sides.clone().map(|side| over(&side.negated(), &-&low));
                let within = |most: Signs| under.iter().all(|signs| signs.within(most));
                let strictly = within(Signs::POSITIVE);
                let both = strictly || within(Signs::NONNEGATIVE);
                both.then_some(if strictly { Signs::NEGATIVE } else { Signs::NONNEGATIVE.flipped() })
            };
            let signs = outside.or_else(&mut inside)?;
            Some(if first.is_positive() { signs } else { signs.flipped() })
        })
    }

    /// The signs of a root: it is 0 just where what it is taken of is.
    fn signs_of_root(&self, form: &Form, depth: usize, systems: &mut usize) -> Option<Signs> {
        let [(monomial, factor)] = form.terms() else { return None };
        let [(Atom::Root(inner), 1)] = monomial.factors() else { return None };
        // What moves with an index is asked where it is 0.
        let of_names =
            inner.atoms().iter().all(|atom| matches!(atom, Atom::Variable(name) if !self.naturals.contains(name)));
        of_names.then_some(())?;
        let under = self.signs_of_value(inner, Signs::POSITIVE, depth - 1, systems);
        let signs = if under.within(Signs::NONZERO) { Signs::POSITIVE } else { Signs::NONNEGATIVE };
        Some(if factor.is_positive() { signs } else { signs.flipped() })
    }

    /// The signs of `a*s + r` with a root s, by those of `(a*s)^2 - r^2`, which tell which of both is farther from 0.
    fn signs_by_conjugate(&self, form: &Form, depth: usize, systems: &mut usize) -> Option<Signs> {
        form.atoms().into_iter().find_map(|atom| {
            let Atom::Root(inner) = atom else { return None };
            let (radicand, below) = inner.polynomials()?;
            let mut parts = form.coefficients_in(atom);
            let (factor, rest) = (parts.remove(&1)?, parts.remove(&0)?);
            if !below.is_one() || !parts.is_empty() || !self.has_root(inner, std::iter::once(form)) {
                return None;
            }
            // As values: a square of the root of a number is one.
            let square = |form: &Form| {
                let value = Value::from_polynomials(form.clone(), Form::one()).ok()?;
                let (square, below) =
                    value.mul(&value).ok()?.polynomials().map(|(top, below)| (top.clone(), below.is_one()))?;
                below.then_some(square)
            };
            let squares = square(&factor)?.times(radicand)?.minus(&square(&rest)?);
            let farther = self.signs_of_form(&squares, Signs::ZERO, depth - 1, systems);
            let mut of = |part: &Form| self.signs_of_form(part, Signs::ZERO, depth - 1, systems);
            if farther.within(Signs::POSITIVE) {
                Some(of(&factor)).filter(|signs| signs.within(Signs::NONZERO))
            } else if farther.within(Signs::NONNEGATIVE) {
                Some(of(&factor).or(Signs::ZERO))
            } else if farther.within(Signs::NEGATIVE) {
                Some(of(&rest))
            } else {
                None
            }
        })
    }

    /// The signs of an integer part beside a whole number: `floor(y) - m` is below 0 just where y is below m, and above 0
    /// where y is not below m+1.
    fn signs_by_floor(&self, form: &Form, depth: usize, systems: &mut usize) -> Option<Signs> {
        let mut atoms = form.atoms().into_iter();
        let (Some(atom @ Atom::Floor(inner)), None) = (atoms.next(), atoms.next()) else { return None };
        let mut parts = form.coefficients_in(atom);
        let factor = parts.remove(&1)?.as_constant()?;
        let bound = -(parts.remove(&0).unwrap_or_else(Form::zero).as_constant()? / &factor);
        if !bound.is_integer() || !parts.is_empty() {
            return None;
        }
        let mut beyond = |bound: BigRational| {
            let over = inner.sub(&Value::rational(bound)).ok()?;
            Some(self.signs_of_value(&over, Signs::NONNEGATIVE, depth - 1, systems))
        };
        let (own, next) = (beyond(bound.clone())?, beyond(bound + BigRational::one())?);
        // Each says something of one side: below m, from m on, below m+1, from m+1 on.
        let told = [
            (own.within(Signs::NEGATIVE), Signs::NEGATIVE),
            (own.within(Signs::NONNEGATIVE), Signs::NONNEGATIVE),
            (next.within(Signs::NEGATIVE), Signs::NONNEGATIVE.flipped()),
            (next.within(Signs::NONNEGATIVE), Signs::POSITIVE),
        ];
        let signs = told.into_iter().filter(|(so, _)| *so).fold(Signs::ANY, |signs, (_, own)| signs.and(own));
        Some(if factor.is_positive() { signs } else { signs.flipped() }).filter(|signs| *signs != Signs::ANY)
    }
}

impl Assumptions {
    /// The signs of what is a multiple of something assumed with squares added to it, or taken from it: `(w^2+1)*25 - (p-a*w)^2`
    /// is `(w^2+1)*(25-a^2-p^2) + (a+p*w)^2`.
    fn signs_by_bound(&self, form: &Form) -> Option<Signs> {
        let bent = |form: &Form| form.terms().iter().any(|(monomial, _)| monomial.degree() > 1);
        if !bent(form) || form.terms().len() > MOST_BENT {
            return None;
        }
        let assumed = self.constraints.iter().filter(|one| one.bound != Bound::Zero && bent(&one.form));
        assumed.take(MOST_BOUNDS).find_map(|one| {
            let own = if one.bound == Bound::Positive { Signs::POSITIVE } else { Signs::NONNEGATIVE };
            let multiples: BTreeSet<Form> = one
                .form
                .terms()
                .iter()
                .filter_map(|(monomial, number)| multiple(form, &one.form, monomial, number))
                .collect();
            multiples.into_iter().find_map(|multiple| {
                let rest = form.minus(&multiple.times(&one.form)?);
                let squares = |form: Form| {
                    Value::from_polynomials(form, Form::one()).is_ok_and(|value| value.is_sum_of_squares())
                };
                let signs = match self.quick_signs(&multiple) {
                    Signs::ANY if squares(multiple.clone()) => Signs::NONNEGATIVE,
                    Signs::ANY if squares(multiple.negated()) => Signs::NONNEGATIVE.flipped(),
                    signs => signs,
                };
                let signs = signs.times(own);
                let side =
                    [Signs::NONNEGATIVE, Signs::NONNEGATIVE.flipped()].into_iter().find(|side| signs.within(*side))?;
                let rest = if side == Signs::NONNEGATIVE { rest } else { rest.negated() };
                (rest.as_constant().is_none() && squares(rest)).then(|| signs.plus(side))
            })
        })
    }
}

/// The polynomial by which one is multiplied where a term of it stands in a form, in names that it does not have itself.
fn multiple(form: &Form, one: &Form, monomial: &Monomial<Atom>, number: &BigRational) -> Option<Form> {
    let own = one.atoms();
    let over = |(term, factor): &(Monomial<Atom>, BigRational)| {
        let rest = term.over(monomial)?;
        let apart = rest.factors().iter().all(|(atom, _)| !own.contains(&atom));
        apart.then(|| (rest, factor / number))
    };
    let multiple = Form::of(form.terms().iter().filter_map(over));
    (!multiple.is_zero()).then_some(multiple)
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
