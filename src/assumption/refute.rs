//! Refutation: that a value has a certain sign is assumed, and a contradiction looked for.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};

use num_rational::BigRational;
use num_traits::One;

use super::atoms::root_of_number;
use super::linear::{Bound, Constraint, contradictory};
use super::sign::Signs;
use super::{Assumptions, Relation};
use crate::polynomial::{Budget, Monomial, Polynomial};
use crate::value::fixed::coarse_order;
use crate::value::{Atom, Value};

/// How deep cases are split.
const MOST_SPLITS: usize = 4;
/// How many systems of constraints one question may look at.
pub(super) const MOST_SYSTEMS: usize = 60;
/// How many constraints one system may have before products are added.
pub(super) const MOST_CONSTRAINTS: usize = 60;
/// How many constraints are multiplied with each other.
const MOST_FACTORS: usize = 9;
/// For so many unknowns the constraints are gone through one by one.
const FEW: usize = 3;
/// The work that may go into one division of polynomials.
pub(super) const DIVISION_BUDGET: u64 = 5_000;

pub(super) type Form = Polynomial<Atom>;

impl Assumptions {
    /// Whether some assumption is refuted by the others.
    pub(super) fn inconsistent(&self) -> bool {
        let mut systems = MOST_SYSTEMS;
        let mut refuted =
            |form: &Form, signs: &[Signs]| signs.iter().all(|sign| self.refutes_form(form, *sign, 1, &mut systems));
        self.signs.values().any(|signs| signs.is_empty())
            || self.constraints.iter().any(|constraint| match constraint.bound {
                Bound::Zero => refuted(&constraint.form, &[Signs::ZERO]),
                Bound::Positive => refuted(&constraint.form, &[Signs::POSITIVE]),
                Bound::Nonnegative => refuted(&constraint.form, &[Signs::POSITIVE, Signs::ZERO]),
            })
            || self.nonzero.iter().any(|form| refuted(form, &[Signs::POSITIVE, Signs::NEGATIVE]))
    }

    /// What is stated of just this value, or of its opposite: that counts where it divides by what may be 0 as well.
    pub(super) fn as_stated(&self, relation: Relation, value: &Value) -> Option<bool> {
        let opposite = value.neg().ok()?;
        let same = |stated: &Value| *stated == *value || *stated == opposite;
        let (own, stated) = self.stated.iter().find(|(_, stated)| same(stated))?;
        let own = if stated == value { Signs::of(*own) } else { Signs::of(*own).flipped() };
        if own.within(Signs::of(relation)) {
            return Some(true);
        }
        own.within(Signs::of(relation.negated())).then_some(false)
    }

    /// The signs that the value may have; the search stops when they are all `wanted` or none is, `depth` factors deep
    /// and after so many systems.
    pub(super) fn signs_of_value(&self, value: &Value, wanted: Signs, depth: usize, systems: &mut usize) -> Signs {
        let value = self.with_solved(value);
        let Some((numerator, denominator)) = value.polynomials() else {
            return Signs::ANY;
        };
        let mut below = Signs::POSITIVE;
        if !denominator.is_one() {
            below = self.signs_of_form(denominator, Signs::ZERO, depth, systems);
            if !below.within(Signs::NONZERO) {
                return self.signs_by_condition(&value, wanted, depth, systems);
            }
        }
        let asked = if below.within(Signs::NEGATIVE) { wanted.flipped() } else { wanted };
        let signs = self.signs_of_form(numerator, asked, depth, systems).times(below);
        // `(-1)^n/(k-1)^n` has the sign of `(-1)^n*(k-1)^n`, which is that of `1-k`.
        let signed = |form: &Form| form.atoms().into_iter().any(Atom::is_sign);
        let decided = signs.within(wanted) || signs.and(wanted).is_empty();
        match numerator.times(denominator) {
            Some(both) if !decided && !denominator.is_one() && (signed(numerator) || signed(denominator)) => {
                signs.and(self.signs_of_form(&both, wanted, depth, systems))
            }
            _ => signs,
        }
    }

    /// The signs of a value that divides by what may be 0, if a condition in it tells when that is so: those that it has
    /// where the condition holds, and those that it has where it fails.
    fn signs_by_condition(&self, value: &Value, wanted: Signs, depth: usize, systems: &mut usize) -> Signs {
        let condition = value.atoms().into_iter().find(|atom| matches!(atom, Atom::Positive(_)));
        let mut both = || -> Option<Signs> {
            let atom = condition.clone()?;
            let Atom::Positive(inner) = &atom else { return None };
            let (zero, one) = (Value::zero(), Value::one());
            let opposite = Atom::Positive(inner.neg().ok()?);
            let (holds, _) = self.case(&[(Relation::Gtr, inner.clone())])?.fixed(&atom, &Form::one(), &Form::zero())?;
            let (holds, _) = holds.fixed(&opposite, &Form::zero(), &Form::zero())?;
            let there = value.with_atom(&atom, &one).and_then(|value| value.with_atom(&opposite, &zero)).ok()?;
            let signs = holds.signs_of_value(&there, wanted, depth - 1, systems);
            let (fails, _) =
                self.case(&[(Relation::Gte, inner.neg().ok()?)])?.fixed(&atom, &Form::zero(), &Form::zero())?;
            let elsewhere = value.with_atom(&atom, &zero).ok()?;
            Some(signs.or(fails.signs_of_value(&elsewhere, wanted, depth - 1, systems)))
        };
        if depth == 0 { Signs::ANY } else { both().unwrap_or(Signs::ANY) }
    }

    /// The signs of a polynomial: of its factors where some are known, else by refuting the others.
    pub(super) fn signs_of_form(&self, form: &Form, wanted: Signs, depth: usize, systems: &mut usize) -> Signs {
        let decided = |signs: Signs| signs.within(wanted) || signs.and(wanted).is_empty();
        let mut signs = self.quick_signs(form);
        if form.as_constant().is_some() || decided(signs) {
            return signs;
        }
        if let Some(order) = coarse_order(form) {
            return if order == Ordering::Greater { Signs::POSITIVE } else { Signs::NEGATIVE };
        }
        signs = signs.and(self.signs_of_power(form, wanted, systems));
        if decided(signs) {
            return signs;
        }
        let shared = form.monomial_content();
        if depth > 0 && !shared.factors().is_empty() {
            let known = self.signs_of_product(&shared, depth, systems);
            let mut rest = self.signs_of_form(&form.without(&shared), wanted.beside(known), depth - 1, systems);
            // What can have no value stands beside a condition that does not hold.
            if rest.is_empty() && shared.factors().iter().any(|(atom, _)| atom.is_binary()) {
                rest = Signs::ZERO;
            }
            signs = signs.and(known.times(rest));
            if decided(signs) || signs.within(Signs::NONZERO) && wanted == Signs::ZERO {
                return signs;
            }
        }
        if depth > 0
            && let Some(own) = self.signs_by_hidden_factor(form, wanted, depth, systems)
        {
            signs = signs.and(own);
            if decided(signs) {
                return signs;
            }
        }
        if depth > 0
            && let Some((known, quotient)) = self.known_factor(form)
        {
            signs = signs.and(known.times(self.signs_of_form(&quotient, wanted.beside(known), depth - 1, systems)));
        }
        if depth > 0
            && let Some(sum) = self.signs_by_powers(form, depth, systems)
        {
            signs = signs.and(sum);
        }
        for sign in Signs::each() {
            if !decided(signs) && sign.within(signs) && self.refutes_form(form, sign, MOST_SPLITS, systems) {
                signs = signs.without(sign);
            }
        }
        if depth > 0 && !decided(signs) {
            signs = signs.and(self.signs_by_form(form, depth));
        }
        signs
    }

    /// An assumed polynomial that divides this one, with its signs, and the quotient.
    fn known_factor(&self, form: &Form) -> Option<(Signs, Form)> {
        let assumed = self.constraints.iter().map(|constraint| {
            let signs = match constraint.bound {
                Bound::Zero => Signs::ZERO,
                Bound::Nonnegative => Signs::NONNEGATIVE,
                Bound::Positive => Signs::POSITIVE,
            };
            (&constraint.form, signs)
        });
        let nonzero = self.nonzero.iter().map(|form| (form, Signs::NONZERO));
        assumed.chain(nonzero).filter(|(factor, _)| factor.as_constant().is_none()).find_map(|(factor, signs)| {
            let quotient = form.divide(factor, &mut Budget::new(DIVISION_BUDGET))?;
            Some((signs, quotient))
        })
    }

    /// Whether it contradicts the assumptions that the polynomial has this sign.
    pub(super) fn refutes_form(&self, form: &Form, sign: Signs, splits: usize, systems: &mut usize) -> bool {
        let divides = |other: &Form| other.divide(form, &mut Budget::new(DIVISION_BUDGET)).is_some();
        if sign == Signs::ZERO && (self.has_no_whole_zero(form) || self.nonzero.iter().any(divides)) {
            return true;
        }
        let goal = match sign {
            Signs::ZERO => Constraint { form: form.clone(), bound: Bound::Zero },
            Signs::POSITIVE => Constraint { form: form.clone(), bound: Bound::Positive },
            _ => Constraint { form: Polynomial::zero().minus(form), bound: Bound::Positive },
        };
        let mut system = self.system(self.tightened(goal));
        if self.contradicts(&mut system, systems) {
            return true;
        }
        if splits > 0 {
            system.extend(self.within_maxima(&system));
        }
        splits > 0 && self.refutes_cases(form, sign, &system, splits - 1, systems)
    }

    /// Whether a system has no solution: as it is, or with what is known of numbers of rounds, or with products.
    fn contradicts(&self, system: &mut Vec<Constraint>, systems: &mut usize) -> bool {
        if !spend(systems) {
            return false;
        }
        if contradictory(system) {
            return true;
        }
        let counted = self.counted(system);
        if !counted.is_empty() && spend(systems) && contradictory(&[system.as_slice(), counted.as_slice()].concat()) {
            return true;
        }
        let integers = self.of_integers(system);
        if !integers.is_empty() && contradictory(&[system.as_slice(), integers.as_slice()].concat()) {
            return true;
        }
        let nonlinear = system.iter().any(|one| one.form.terms().iter().any(|(monomial, _)| monomial.degree() > 1));
        if !nonlinear || !spend(systems) {
            return false;
        }
        self.add_products(system);
        let counted = self.counted(system);
        contradictory(system)
            || !counted.is_empty() && spend(systems) && contradictory(&[system.as_slice(), counted.as_slice()].concat())
    }

    /// Whether one of the last facts, from this place on, contradicts the others.
    fn excluded(&self, from: usize, systems: &mut usize) -> bool {
        let facts = self.constraints.get(from..).unwrap_or_default();
        facts.iter().any(|fact| self.contradicts(&mut self.system(fact.clone()), systems))
    }

    /// The goal with all that may bear on it.
    fn system(&self, goal: Constraint) -> Vec<Constraint> {
        let mut known: BTreeSet<Atom> = BTreeSet::new();
        let mut fresh: Vec<Atom> = goal.form.atoms().into_iter().cloned().collect();
        let mut system = vec![goal];
        let mut used = vec![false; self.constraints.len()];
        let mut places: Option<BTreeMap<&Atom, Vec<usize>>> = None;
        while let Some(atom) = fresh.pop() {
            if system.len() > MOST_CONSTRAINTS {
                break;
            }
            if !known.insert(atom.clone()) {
                continue;
            }
            let mut more = self.facts_of_atom(&atom, system.iter().map(|one| &one.form));
            let mut note = |place: usize| {
                if !std::mem::replace(&mut used[place], true) {
                    more.push(self.constraints[place].clone());
                }
            };
            // An index pays once several unknowns are looked up.
            if known.len() <= FEW {
                let mentions = |place: &usize| self.constraints[*place].form.degree_in(&atom) > 0;
                (0..self.constraints.len()).filter(mentions).for_each(&mut note);
            } else {
                let places = places.get_or_insert_with(|| self.places());
                places.get(&atom).into_iter().flatten().copied().for_each(&mut note);
            }
            for constraint in more {
                fresh.extend(constraint.form.atoms().into_iter().filter(|atom| !known.contains(atom)).cloned());
                system.push(constraint);
            }
        }
        self.add_monomial_signs(&mut system);
        system
    }

    /// The constraints in which each atom stands.
    fn places(&self) -> BTreeMap<&Atom, Vec<usize>> {
        let mut places: BTreeMap<&Atom, Vec<usize>> = BTreeMap::new();
        for (place, constraint) in self.constraints.iter().enumerate() {
            for atom in constraint.form.atoms() {
                places.entry(atom).or_default().push(place);
            }
        }
        places
    }

    /// The signs of a polynomial, as its terms or an assumption about itself show.
    pub(super) fn assumed(&self, form: &Form) -> Signs {
        let (scaled, opposite) = (form.primitive(), Polynomial::zero().minus(&form.primitive()));
        let positive = form.leading() > BigRational::from_integer(0.into());
        let mut signs = self.quick_signs(form);
        for constraint in &self.constraints {
            let known = match constraint.bound {
                Bound::Zero => Signs::ZERO,
                Bound::Nonnegative => Signs::NONNEGATIVE,
                Bound::Positive => Signs::POSITIVE,
            };
            if constraint.form == scaled {
                signs = signs.and(if positive { known } else { known.flipped() });
            } else if constraint.form == opposite {
                signs = signs.and(if positive { known.flipped() } else { known });
            }
        }
        signs
    }

    /// Adds, for each product of unknowns in the system, what its factors say of its sign.
    fn add_monomial_signs(&self, system: &mut Vec<Constraint>) {
        let mut monomials: BTreeSet<&Monomial<Atom>> = BTreeSet::new();
        for constraint in system.iter() {
            monomials.extend(constraint.form.terms().iter().map(|(monomial, _)| monomial));
        }
        let mut found = Vec::new();
        for monomial in monomials.into_iter().filter(|monomial| !monomial.factors().is_empty()) {
            found.extend(root_of_number(monomial).into_iter().flatten());
            let signs = self.monomial_signs(monomial);
            let (sign, known) = if signs.within(Signs::NONNEGATIVE) {
                (BigRational::one(), signs)
            } else if signs.within(Signs::of(Relation::Lte)) {
                (-BigRational::one(), signs.flipped())
            } else {
                continue;
            };
            let bound = if known.within(Signs::POSITIVE) { Bound::Positive } else { Bound::Nonnegative };
            found.push(Constraint { form: Polynomial::term(monomial.clone(), sign), bound });
        }
        system.extend(found);
    }

    /// Adds the products of the inequalities of the system, and squares of what is not 0.
    fn add_products(&self, system: &mut Vec<Constraint>) {
        let usable = |one: &&Constraint| one.bound != Bound::Zero && one.form.terms().len() <= 12;
        let mut factors: Vec<Constraint> = system.iter().filter(usable).cloned().collect();
        factors.dedup();
        // Products help where they make monomials that are there and no numbers: of what stands in some, before all else.
        let monomials = system.iter().flat_map(|one| one.form.terms()).map(|(monomial, _)| monomial);
        let number = |(atom, _): &(Atom, u32)| atom.is_root_of_number();
        let multiplied: BTreeSet<&Atom> = monomials
            .filter(|monomial| monomial.degree() > 1 && !monomial.factors().iter().all(number))
            .flat_map(|monomial| monomial.factors().iter().map(|(atom, _)| atom))
            .collect();
        factors.sort_by_key(|factor| !factor.form.atoms().iter().any(|atom| multiplied.contains(atom)));
        factors.truncate(MOST_FACTORS);
        let mut found = Vec::new();
        for (place, first) in factors.iter().enumerate() {
            for second in &factors[place..] {
                let both = first.bound == Bound::Positive && second.bound == Bound::Positive;
                let bound = if both { Bound::Positive } else { Bound::Nonnegative };
                found.extend(first.form.times(&second.form).map(|form| Constraint { form, bound }));
            }
        }
        // What is supposed to be 0 is so in any product.
        if let Some(zero) = system.first().filter(|goal| goal.bound == Bound::Zero && goal.form.terms().len() <= 4) {
            let products = factors.iter().filter_map(|factor| zero.form.times(&factor.form));
            found.extend(products.map(|form| Constraint { form, bound: Bound::Zero }));
        }
        let squares = self.nonzero.iter().filter(|form| form.terms().len() <= 4).take(4);
        found.extend(squares.filter_map(|form| Some(Constraint { form: form.power(2)?, bound: Bound::Positive })));
        system.extend(found);
        self.add_monomial_signs(system);
    }

    /// Splits on a maximum, a condition or a `!=`, and refutes each case.
    fn refutes_cases(
        &self,
        form: &Form,
        sign: Signs,
        system: &[Constraint],
        splits: usize,
        systems: &mut usize,
    ) -> bool {
        let relevant: BTreeSet<&Atom> = system.iter().flat_map(|one| one.form.atoms()).collect();
        let own = form.atoms();
        let candidates = own.iter().chain(relevant.iter().filter(|atom| !own.contains(*atom)));
        for atom in candidates {
            if let Some(cases) = self.cases(atom, form) {
                // Where nothing is left to refute in a case, it may be none.
                let none = |case: &Assumptions, form: &Form, systems: &mut usize| {
                    form.as_constant().is_some() && case.excluded(self.constraints.len(), systems)
                };
                return cases
                    .iter()
                    .all(|(case, form)| case.refutes_form(form, sign, splits, systems) || none(case, form, systems));
            }
        }
        let apart = self.nonzero.iter().position(|other| {
            other.atoms().iter().any(|atom| relevant.contains(atom))
                && !self.assumed(other).within(Signs::POSITIVE)
                && !self.assumed(other).within(Signs::NEGATIVE)
        });
        let Some(place) = apart else { return false };
        let mut above = self.clone();
        let split = above.nonzero.remove(place);
        let mut below = above.clone();
        above.constraints.push(above.tightened(Constraint { form: split.clone(), bound: Bound::Positive }));
        let opposite = Polynomial::zero().minus(&split);
        below.constraints.push(below.tightened(Constraint { form: opposite, bound: Bound::Positive }));
        [above, below].iter().all(|case| case.refutes_form(form, sign, splits, systems))
    }

    /// The cases of a maximum or condition, each with the polynomial as it is there.
    fn cases(&self, atom: &Atom, form: &Form) -> Option<Vec<(Assumptions, Form)>> {
        match atom {
            Atom::Positive(condition) => {
                let opposite = Atom::Positive(condition.neg().ok()?);
                let holds = self.case(&[(Relation::Gtr, condition.clone())])?;
                let holds = holds.fixed(atom, &Polynomial::one(), form)?;
                let (case, inner) = holds.0.fixed(&opposite, &Polynomial::zero(), &holds.1)?;
                let fails = self.case(&[(Relation::Gte, condition.neg().ok()?)])?;
                Some(vec![(case, inner), fails.fixed(atom, &Polynomial::zero(), form)?])
            }
            Atom::Maximum(elements) => {
                let mut all = vec![Value::zero()];
                all.extend(elements.iter().cloned());
                let mut cases = Vec::new();
                for greatest in &all {
                    let (top, below) = greatest.polynomials()?;
                    if !self.quick_signs(below).within(Signs::POSITIVE) {
                        return None;
                    }
                    let mut facts = Vec::new();
                    for other in all.iter().filter(|other| *other != greatest) {
                        facts.push((Relation::Gte, greatest.sub(other).ok()?));
                    }
                    cases.push(self.case(&facts)?.fixed_at(atom, (top, below), form)?);
                }
                Some(cases)
            }
            _ => None,
        }
    }

    fn case(&self, facts: &[(Relation, Value)]) -> Option<Assumptions> {
        let mut case = self.clone();
        for (relation, value) in facts {
            let value = self.with_solved(value);
            case.note_sign(*relation, &value);
            case.note_constraint(*relation, &value);
        }
        Some(case)
    }

    /// The assumptions and a polynomial with an atom replaced by what it is in this case.
    fn fixed(self, atom: &Atom, image: &Form, form: &Form) -> Option<(Assumptions, Form)> {
        self.fixed_at(atom, (image, &Form::one()), form)
    }

    /// The same where it is a quotient by what is greater than 0.
    fn fixed_at(mut self, atom: &Atom, image: (&Form, &Form), form: &Form) -> Option<(Assumptions, Form)> {
        for constraint in &mut self.constraints {
            constraint.form = replaced(&constraint.form, atom, image)?;
        }
        for other in &mut self.nonzero {
            *other = replaced(other, atom, image)?;
        }
        self.signs.remove(atom);
        let form = replaced(form, atom, image)?;
        Some((self, form))
    }
}

/// A polynomial of the sign of this one with a quotient, by what is greater than 0, for one of its atoms.
fn replaced(form: &Form, atom: &Atom, (top, below): (&Form, &Form)) -> Option<Form> {
    let degree = form.degree_in(atom);
    if degree == 0 {
        return Some(form.clone());
    }
    let mut sum = Polynomial::zero();
    for (exponent, part) in form.coefficients_in(atom) {
        let scale = below.power(degree.checked_sub(exponent)?)?;
        sum = sum.plus(&part.times(&top.power(exponent)?)?.times(&scale)?);
    }
    Some(sum)
}

fn spend(systems: &mut usize) -> bool {
    let left = *systems > 0;
    *systems = systems.saturating_sub(1);
    left
}
