//! What is assumed of variables (`t > 0`, `a != b`, n natural), and what follows from it.
//!
//! Every answer is sound: `Some` only where it follows, for all values of the variables that meet the assumptions and
//! for which both sides are defined; else `None`. The procedure: signs of the parts, then linear arithmetic over
//! monomials with products of assumptions, then the same after splitting on maxima, conditions and `!=`.

mod alone;
mod atoms;
mod eliminate;
mod enclosed;
mod hidden;
mod integral;
mod linear;
mod pieces;
mod powers;
mod product;
mod refute;
mod remembered;
mod sampled;
mod sign;
mod simplex;
mod simplify;
mod triangle;
mod vectors;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use num_rational::BigRational;
use num_traits::{Signed, Zero};

use crate::name::Name;
use crate::polynomial::Polynomial;
use crate::value::{Atom, Need, Relation, Sort, Value, ValueError};
use linear::{Bound, Constraint};
pub(crate) use pieces::with_fewest_corners;
use sign::Signs;
use vectors::of_condition;

/// Facts about variables; cheap enough to copy.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Assumptions {
    /// As assumed: each value stands in the relation to 0; only `=`, `!=`, `>` and `>=` occur.
    stated: Vec<(Relation, Value)>,
    /// The variables that they mention.
    mentioned: Arc<BTreeSet<Name>>,
    naturals: BTreeSet<Name>,
    /// Variables that an equation gives, in the order in which they were solved.
    solved: Vec<(Name, Value)>,
    /// The stated facts with the solved variables put in and without denominators.
    constraints: Vec<Constraint>,
    /// Polynomials that are not 0.
    nonzero: Vec<Polynomial<Atom>>,
    /// The signs that single atoms may have.
    signs: BTreeMap<Atom, Signs>,
}

impl Assumptions {
    /// Assumes that the relation holds. What says nothing about numbers is left out, which is always sound.
    pub fn assume(&mut self, relation: Relation, left: &Value, right: &Value) {
        let Ok(difference) = left.sub(right) else { return };
        match (relation, difference.sort()) {
            (_, Sort::Real) => {}
            (_, Sort::Vector(_)) => return self.assume_of_vector(relation, &difference),
            _ => return,
        }
        let (relation, value) = match relation {
            Relation::Lss | Relation::Lte => match difference.neg() {
                Ok(opposite) => (relation.mirrored(), opposite),
                Err(_) => return,
            },
            other => (other, difference),
        };
        if let (Relation::Gtr | Relation::Neq, Some((condition, rest))) = (relation, of_condition(&value)) {
            self.assume(Relation::Gtr, &condition, &Value::zero());
            return self.assume(relation, &rest, &Value::zero());
        }
        let news: BTreeSet<Name> =
            value.variables().into_iter().filter(|name| !self.mentioned.contains(name)).collect();
        if news.is_empty() && self.stated.iter().any(|(other, known)| *other == relation && *known == value) {
            return;
        }
        // Where a root is not 0, neither is what it is the root of: a length divides by that.
        if let (Relation::Gtr | Relation::Neq, Some(Atom::Root(inner))) = (relation, value.as_atom()) {
            self.assume(Relation::Gtr, inner, &Value::zero());
        }
        self.stated.push((relation, value.clone()));
        if !news.is_empty() {
            Arc::make_mut(&mut self.mentioned).extend(news.iter().cloned());
        }
        if !self.extended(relation, &value, &news) {
            self.prepare();
        }
    }

    /// Adds what the last fact stated says to what was derived from the others; false if that may change as well: if
    /// it gives a variable a value, or an atom that they mention a sign. `news` are the variables that they do not mention.
    fn extended(&mut self, relation: Relation, value: &Value, news: &BTreeSet<Name>) -> bool {
        if relation == Relation::Eq || self.solved.iter().any(|(solved, _)| value.mentions(solved)) {
            return false;
        }
        if let Some(atom) = self.note_sign(relation, value) {
            let Atom::Variable(name) = atom else { return false };
            if !news.contains(&name) {
                return false;
            }
        }
        let before = self.constraints.len();
        self.note_constraint(relation, value);
        if self.constraints.len() > before
            && let Some(added) = self.constraints.pop()
            && let Err(place) = self.constraints.binary_search(&added)
        {
            self.constraints.insert(place, added);
        }
        true
    }

    /// Assumes that a variable is 0, 1, 2, …
    pub fn assume_natural(&mut self, name: &Name) {
        if self.naturals.insert(name.clone()) {
            let mentioned = self.mentioned.contains(name);
            self.assume(Relation::Gte, &Value::variable(name), &Value::zero());
            // Of a name that stood nowhere nothing was derived that is sharper now.
            if mentioned {
                self.prepare();
            }
        }
    }

    /// The variables that the assumptions mention.
    pub fn variables(&self) -> BTreeSet<Name> {
        // What is natural is stated to be at least 0.
        (*self.mentioned).clone()
    }

    /// Whether the assumptions mention this variable.
    pub fn mentions(&self, name: &Name) -> bool {
        self.mentioned.contains(name)
    }

    /// The variables that are assumed natural.
    pub fn naturals(&self) -> &BTreeSet<Name> {
        &self.naturals
    }

    /// Without everything that mentions one of these names.
    pub fn without(&self, names: &BTreeSet<Name>) -> Assumptions {
        self.kept(|variables| variables.is_disjoint(names))
    }

    /// Without everything that mentions a name besides these.
    pub fn within(&self, names: &BTreeSet<Name>) -> Assumptions {
        self.kept(|variables| variables.is_subset(names))
    }

    /// What mentions variables that are to be kept.
    fn kept(&self, keep: impl Fn(&BTreeSet<Name>) -> bool) -> Assumptions {
        let mut rest = Assumptions::default();
        let mut mentioned = BTreeSet::new();
        for (relation, value) in &self.stated {
            let variables = value.variables();
            if keep(&variables) {
                rest.stated.push((*relation, value.clone()));
                mentioned.extend(variables);
            }
        }
        rest.mentioned = Arc::new(mentioned);
        rest.naturals = self.naturals.iter().filter(|name| keep(&BTreeSet::from([(*name).clone()]))).cloned().collect();
        rest.prepare();
        rest
    }

    /// Without everything that mentions this name.
    pub fn without_name(&self, name: &Name) -> Assumptions {
        if self.naturals.contains(name) || self.mentions(name) {
            return self.without(&BTreeSet::from([name.clone()]));
        }
        self.clone()
    }

    /// The facts, each a value and its relation to 0: one of `=`, `!=`, `>`, `>=`.
    pub fn iter(&self) -> impl Iterator<Item = (Relation, Value)> + '_ {
        self.stated.iter().cloned()
    }

    /// How many facts there are.
    pub fn count(&self) -> usize {
        self.stated.len()
    }

    /// Without the last facts: the first of this number alone, and these names natural.
    pub fn truncated(&self, count: usize, naturals: &BTreeSet<Name>) -> Assumptions {
        let mut rest = Assumptions {
            stated: self.stated.iter().take(count).cloned().collect(),
            naturals: naturals.clone(),
            ..Assumptions::default()
        };
        rest.mentioned = Arc::new(rest.stated.iter().flat_map(|(_, value)| value.variables()).collect());
        rest.prepare();
        rest
    }

    /// Whether the assumptions are known to exclude each other, so that anything follows from them.
    pub fn contradictory(&self) -> bool {
        self.inconsistent()
    }

    /// Whether linear arithmetic over monomials, without products of facts, shows that they exclude each other.
    pub fn plainly_contradictory(&self) -> bool {
        self.signs.values().any(|signs| signs.is_empty()) || linear::contradictory(&self.constraints)
    }

    /// Whether the relation holds: `None` where neither it nor its opposite follows.
    pub fn decide(&self, relation: Relation, left: &Value, right: &Value) -> Option<bool> {
        if left == right && left.sort() == Sort::Real {
            return Some(matches!(relation, Relation::Eq | Relation::Gte | Relation::Lte));
        }
        if left.sort() != Sort::Real || right.sort() != Sort::Real {
            return self.decide_wholes(relation, left, right);
        }
        if let (Some(left), Some(right)) = (left.as_rational(), right.as_rational()) {
            return Some(relation.holds(left.cmp(&right)));
        }
        self.decide_unless_contradictory(relation, &left.sub(right).ok()?)
    }

    /// Compares a value with 0.
    fn decide_unless_contradictory(&self, relation: Relation, value: &Value) -> Option<bool> {
        if let Some(order) = value.order_of_roots() {
            return Some(relation.holds(order));
        }
        let possible = self.possible_signs(value, Signs::of(relation));
        match possible {
            _ if possible.is_empty() => None,
            _ if possible.within(Signs::of(relation)) => Some(true),
            _ if possible.within(Signs::of(relation.negated())) => Some(false),
            _ => self
                .as_stated(relation, value)
                .or_else(|| self.decided_by_equations(relation, value))
                .or_else(|| self.decided_without_maxima(relation, value)),
        }
    }

    /// Whether what a value needs to have a meaning is so.
    pub fn grants(&self, need: &Need) -> Option<bool> {
        match need {
            Need::Nonzero(value) => self.is_nonzero(value),
            Need::Nonnegative(value) if value.is_sum_of_squares() => Some(true),
            Need::Nonnegative(value) => self.decide(Relation::Gte, value, &Value::zero()),
            // Term by term: what is said of a sum alone says nothing of the powers that a normal form makes of it.
            Need::Natural(value) if self.all_terms_integral(value) => self.is_natural(value),
            Need::Natural(_) => None,
        }
    }

    /// Whether all that a value needs to have a meaning is known to be so.
    pub fn gives_meaning(&self, value: &Value) -> bool {
        value.needs().iter().all(|need| self.grants(need) == Some(true))
    }

    /// A value with others put in for names, undefined wherever one of them is, or it was itself, unless they are known
    /// to be defined: `y*k` with `1/k` for y is not 1, as k may be 0.
    ///
    /// # Errors
    /// When the result is not defined, or may be where what it was made of is not.
    pub fn put_in(&self, value: &Value, images: &BTreeMap<Name, Value>) -> Result<Value, ValueError> {
        let image = value.substitute(images)?;
        let needs = value.needs_with(images)?;
        if needs.is_empty() {
            return Ok(image);
        }
        let shown = image.needs();
        let lost = |need: &&Need| {
            // Where it divides by 0 and yet has a value, a condition has excluded the division.
            !need.value().is_zero() && !need.follows_from(&shown) && self.grants(need) != Some(true)
        };
        match needs.iter().find(lost) {
            Some(need) => Err(ValueError::new(need.to_string())),
            None => Ok(image),
        }
    }

    /// A value with others put in for names, where no exponent is lost of which it is not known that it counts: with 2*p
    /// for q, `(-1)^q` is 1 for natural numbers p, and -1 for 1/2.
    ///
    /// # Errors
    /// When the result is not defined, or may be another.
    pub fn put_in_powers(&self, value: &Value, images: &BTreeMap<Name, Value>) -> Result<Value, ValueError> {
        let image = value.substitute(images)?;
        let powers: Vec<Need> = value.needs().into_iter().filter(|need| matches!(need, Need::Natural(_))).collect();
        if powers.is_empty() || !images.keys().any(|name| value.mentions(name)) {
            return Ok(image);
        }
        let shown = image.needs();
        let mut known = self.clone();
        for need in &shown {
            if let (Need::Natural(_), Some(name)) = (need, need.value().as_variable()) {
                known.assume_natural(name);
            }
        }
        for need in powers {
            let need = need.substitute(images)?;
            if !need.follows_from(&shown) && !known.all_terms_integral(need.value()) {
                return Err(ValueError::new(need.to_string()));
            }
        }
        Ok(image)
    }

    /// Derives what the decisions use from what was stated.
    fn prepare(&mut self) {
        self.solve_equations();
        self.constraints.clear();
        self.nonzero.clear();
        self.signs.clear();
        let stated = self.stated.clone();
        for (relation, value) in &stated {
            self.note_sign(*relation, &self.with_solved(value));
        }
        for (relation, value) in &stated {
            self.note_constraint(*relation, &self.with_solved(value));
        }
        self.constraints.sort();
        self.constraints.dedup();
    }

    /// Each equation that is linear in a variable, with a number as its factor, gives that variable.
    fn solve_equations(&mut self) {
        self.solved.clear();
        for (relation, value) in self.stated.clone() {
            if relation != Relation::Eq {
                continue;
            }
            // A quotient is 0 where what stands above is.
            let value = self.with_solved(&value);
            let value = self.without_stated_factors(value.numerator().unwrap_or(value));
            let solution = value.variables().into_iter().find_map(|name| {
                let (factor, rest) = value.linear_in(&name)?;
                let factor = factor.as_rational().filter(|factor| !factor.is_zero())?;
                let image = rest.scale(&-factor.recip()).ok()?;
                // A natural is kept unless it is given: that it is natural says more than the equation.
                let natural = |number: BigRational| number.is_integer() && !number.is_negative();
                let replaceable = !self.naturals.contains(&name) || image.as_rational().is_some_and(natural);
                replaceable.then_some((name, image))
            });
            self.solved.extend(solution);
        }
    }

    /// What is 0 where this is: without the variables in all its terms that are stated not to be 0.
    fn without_stated_factors(&self, value: Value) -> Value {
        let Some((form, _)) = value.polynomials().filter(|(form, below)| below.is_one() && form.terms().len() > 1)
        else {
            return value;
        };
        let stated = |atom: &Atom| {
            let mut own = self.stated.iter().filter(|(relation, _)| matches!(relation, Relation::Gtr | Relation::Neq));
            own.any(|(_, stated)| stated.as_atom() == Some(atom))
        };
        let shared = form.monomial_content();
        let factors = shared.factors().iter().filter(|(atom, _)| stated(atom)).cloned();
        let rest = crate::polynomial::Monomial::of(factors).map(|factors| form.without(&factors));
        rest.and_then(|rest| Value::from_polynomials(rest, Polynomial::one()).ok()).unwrap_or(value)
    }

    /// Remembers the sign of an atom that a fact compares with a number; gives the atom if that is news of it.
    fn note_sign(&mut self, relation: Relation, value: &Value) -> Option<Atom> {
        let (numerator, denominator) = value.polynomials()?;
        let constant = numerator.constant_term();
        let rest = numerator.minus(&Polynomial::constant(constant.clone()));
        let [(monomial, number)] = rest.terms() else { return None };
        let ([(atom, 1)], true) = (monomial.factors(), denominator.is_one()) else { return None };
        // number * atom + constant REL 0, so atom REL bound, mirrored for a negative number.
        let bound = -constant / number;
        let relation = if number.is_negative() { relation.mirrored() } else { relation };
        let known = Signs::beyond(relation, &bound);
        let entry = self.signs.entry(atom.clone()).or_insert(Signs::ANY);
        let before = *entry;
        *entry = before.and(known);
        (*entry != before).then(|| atom.clone())
    }

    fn note_constraint(&mut self, relation: Relation, value: &Value) {
        let Some((numerator, denominator)) = value.polynomials() else { return };
        // N/D compares with 0 as N*D does, and is 0 if N is, where D is not 0. It has no value where D is, but for a
        // condition in it that excludes the division: there N is 0 as well, whatever the value.
        let divides = denominator.is_one()
            || !value.atoms().iter().any(Atom::is_binary)
            || self.quick_signs(denominator).within(Signs::NONZERO);
        let relation = match relation {
            Relation::Neq if !divides => return,
            Relation::Gtr if !divides => Relation::Gte,
            relation => relation,
        };
        let form = match relation {
            Relation::Eq | Relation::Neq => numerator.clone(),
            _ => match numerator.times(denominator) {
                Some(form) => form,
                None => return,
            },
        };
        let form = self.without_known_factors(&form);
        let bound = match relation {
            Relation::Eq => Bound::Zero,
            Relation::Gtr => Bound::Positive,
            Relation::Gte => Bound::Nonnegative,
            _ => {
                let quick = self.quick_signs(&form);
                if !quick.within(Signs::NONNEGATIVE) {
                    self.note_nonzero(&form);
                    return;
                }
                Bound::Positive
            }
        };
        // What is not 0 and not below it is above it.
        let apart = |other: &Polynomial<Atom>| is_multiple(other, &form.primitive());
        let bound = if bound == Bound::Nonnegative && self.nonzero.iter().any(apart) { Bound::Positive } else { bound };
        if bound == Bound::Positive {
            self.nonzero.push(form.primitive());
        }
        self.constraints.push(self.tightened(Constraint { form, bound }));
    }

    /// Notes that it is not 0; what it is on one side of it is on that side strictly.
    fn note_nonzero(&mut self, form: &Polynomial<Atom>) {
        let form = form.primitive();
        let same = |one: &Constraint| one.bound == Bound::Nonnegative && is_multiple(&one.form.primitive(), &form);
        if let Some(place) = self.constraints.iter().position(same) {
            let strict = Constraint { bound: Bound::Positive, form: self.constraints[place].form.clone() };
            self.constraints[place] = self.tightened(strict);
        }
        self.nonzero.push(form);
    }

    /// A sum without the factors of its terms that are certainly positive.
    fn without_known_factors(&self, form: &Polynomial<Atom>) -> Polynomial<Atom> {
        if form.terms().len() == 1 {
            return form.clone();
        }
        let shared = form.monomial_content();
        let positive = shared.factors().iter().filter_map(|(atom, exponent)| {
            let signs = self.atom_signs(atom);
            if signs.within(Signs::POSITIVE) {
                Some((atom.clone(), *exponent))
            } else if signs.within(Signs::NONZERO) {
                Some((atom.clone(), exponent - exponent % 2))
            } else {
                None
            }
        });
        crate::polynomial::Monomial::of(positive).map_or_else(|| form.clone(), |known| form.without(&known))
    }
}

/// Whether a primitive polynomial is another one, or its opposite.
fn is_multiple(one: &Polynomial<Atom>, other: &Polynomial<Atom>) -> bool {
    one == other || *one == other.negated()
}
