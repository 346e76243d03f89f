//! What is assumed of variables, and the decision of comparisons under it: exact, sound, incomplete.
//!
//! A comparison is brought to `d REL 0` and refuted or confirmed by linear reasoning over monomials
//! (Fourier–Motzkin elimination with exact rationals), with the signs of monomials and products of pairs of
//! assumptions as further facts. When this does not settle it, the answer is `None`.

mod linear;

use std::collections::BTreeSet;

use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use crate::name::Name;
use crate::value::{Atom, Exponent, Relation, Value, View};
use linear::{Inequality, infeasible};

/// Facts about variables: comparisons with 0, and which are natural numbers. Cheap enough to copy.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Assumptions {
    facts: Vec<(Relation, Value)>,
    naturals: BTreeSet<Name>,
}

/// How deep decisions about parts of a value go.
const DEPTH: usize = 4;

impl Assumptions {
    /// Assumes a comparison. One between values that cannot be compared is ignored.
    pub fn assume(&mut self, relation: Relation, left: &Value, right: &Value) {
        let (relation, difference) = match relation {
            Relation::Lss | Relation::Lte => (relation.mirrored(), right.sub(left)),
            _ => (relation, left.sub(right)),
        };
        if let Ok(difference) = difference
            && !self.facts.contains(&(relation, difference.clone()))
        {
            self.facts.push((relation, difference));
        }
    }

    /// Assumes that a variable is 0, 1, 2, ….
    pub fn assume_natural(&mut self, name: &Name) {
        self.naturals.insert(name.clone());
    }

    /// All variables about which something is assumed.
    pub fn variables(&self) -> BTreeSet<Name> {
        let mut all = self.naturals.clone();
        all.extend(self.facts.iter().flat_map(|(_, value)| value.variables()));
        all
    }

    /// The comparisons, each `value REL 0`.
    pub fn iter(&self) -> impl Iterator<Item = (Relation, Value)> + '_ {
        self.facts.iter().cloned()
    }

    /// The variables assumed to be natural numbers.
    pub fn naturals(&self) -> &BTreeSet<Name> {
        &self.naturals
    }

    /// Without everything that mentions one of these names.
    pub fn without(&self, names: &BTreeSet<Name>) -> Assumptions {
        let free = |value: &Value| names.iter().all(|name| !value.mentions(name));
        Assumptions {
            facts: self.facts.iter().filter(|(_, value)| free(value)).cloned().collect(),
            naturals: self.naturals.difference(names).cloned().collect(),
        }
    }

    /// Whether the assumptions are found to exclude each other.
    pub fn contradictory(&self) -> bool {
        let zero = Value::zero();
        (0..self.facts.len()).any(|index| {
            let mut others = self.clone();
            let (relation, value) = others.facts.remove(index);
            others.decide(relation, &value, &zero) == Some(false)
        })
    }

    /// Decides `left REL right`: `None` when undecided.
    pub fn decide(&self, relation: Relation, left: &Value, right: &Value) -> Option<bool> {
        self.decided(relation, left, right, DEPTH)
    }

    fn decided(&self, relation: Relation, left: &Value, right: &Value, depth: usize) -> Option<bool> {
        if left == right {
            return Some(matches!(relation, Relation::Eq | Relation::Gte | Relation::Lte));
        }
        if let (View::Vector(ours), View::Vector(theirs)) = (left.view(), right.view()) {
            return self.decided_vectors(relation, &ours, &theirs, depth);
        }
        let difference = left.sub(right).ok()?;
        if let Some(number) = difference.as_rational() {
            return Some(relation.holds(number.cmp(&BigRational::zero())));
        }
        let flipped = || difference.neg().ok();
        match relation {
            Relation::Gtr => self.truth(|| self.positive(&difference, depth), || self.not_negative(&flipped()?, depth)),
            Relation::Gte => self.truth(|| self.not_negative(&difference, depth), || self.positive(&flipped()?, depth)),
            Relation::Lss => self.truth(|| self.positive(&flipped()?, depth), || self.not_negative(&difference, depth)),
            Relation::Lte => self.truth(|| self.not_negative(&flipped()?, depth), || self.positive(&difference, depth)),
            Relation::Eq => self.truth(|| self.null(&difference, depth), || self.nonzero(&difference, depth)),
            Relation::Neq => self.truth(|| self.nonzero(&difference, depth), || self.null(&difference, depth)),
        }
    }

    fn decided_vectors(&self, relation: Relation, ours: &[Value], theirs: &[Value], depth: usize) -> Option<bool> {
        let each: Vec<Option<bool>> =
            ours.iter().zip(theirs).map(|(a, b)| self.decided(Relation::Eq, a, b, depth)).collect();
        let equal = if ours.len() != theirs.len() || each.contains(&Some(false)) {
            Some(false)
        } else if each.iter().all(|one| *one == Some(true)) {
            Some(true)
        } else {
            None
        };
        match relation {
            Relation::Eq => equal,
            Relation::Neq => equal.map(|equal| !equal),
            _ => None,
        }
    }

    fn truth(&self, yes: impl Fn() -> Option<()>, no: impl Fn() -> Option<()>) -> Option<bool> {
        if yes().is_some() { Some(true) } else { no().map(|()| false) }
    }

    fn positive(&self, value: &Value, depth: usize) -> Option<()> {
        let numerator = self.numerator(value, depth)?;
        self.excludes(Inequality::of(&numerator, false).negative(), depth)
    }

    fn not_negative(&self, value: &Value, depth: usize) -> Option<()> {
        let numerator = self.numerator(value, depth)?;
        let mut opposite = Inequality::of(&numerator, true).negative();
        if self.integral(&numerator) {
            opposite = opposite.at_least_one();
        }
        self.excludes(opposite, depth)
    }

    fn null(&self, value: &Value, depth: usize) -> Option<()> {
        let numerator = value.numerator()?;
        self.not_negative(&numerator, depth)?;
        self.not_negative(&numerator.neg().ok()?, depth)
    }

    fn nonzero(&self, value: &Value, depth: usize) -> Option<()> {
        let numerator = value.numerator()?;
        if self.positive(&numerator, depth).is_some() || self.positive(&numerator.neg().ok()?, depth).is_some() {
            return Some(());
        }
        if depth == 0 {
            return None;
        }
        if let View::Real(sum, _) = numerator.view()
            && let [(_, factors)] = sum.as_slice()
            && !factors.is_empty()
        {
            return factors.iter().all(|(atom, _)| self.atom_nonzero(atom, depth - 1)).then_some(());
        }
        self.facts.iter().filter(|(relation, _)| *relation == Relation::Neq).find_map(|(_, fact)| {
            let quotient = numerator.div(fact).ok()?;
            let simpler = quotient.as_rational().is_some() || quotient.size() < numerator.size();
            if simpler && (quotient.as_rational().is_some() || self.nonzero(&quotient, depth - 1).is_some()) {
                Some(())
            } else {
                None
            }
        })
    }

    fn atom_nonzero(&self, atom: &Atom, depth: usize) -> bool {
        let known = |value: &Value| {
            self.facts.iter().any(|(relation, fact)| {
                *relation == Relation::Neq
                    && fact.div(value).ok().and_then(|quotient| quotient.as_rational()).is_some_and(|q| !q.is_zero())
            })
        };
        match (atom, atom.value()) {
            (Atom::Power(base, _), _) => {
                self.nonzero(base, depth).is_some() || base.as_rational().is_some_and(|b| !b.is_zero())
            }
            (_, Ok(value)) => {
                known(&value)
                    || self.positive(&value, depth).is_some()
                    || value.neg().is_ok_and(|value| self.positive(&value, depth).is_some())
            }
            _ => false,
        }
    }

    /// A polynomial with the sign of the value, if the denominator's sign is known.
    fn numerator(&self, value: &Value, depth: usize) -> Option<Value> {
        let denominator = value.denominator()?;
        if denominator.as_rational().is_some_and(|number| number.is_one()) {
            return value.numerator();
        }
        if depth == 0 {
            return None;
        }
        if self.positive(&denominator, depth - 1).is_some() {
            return value.numerator();
        }
        self.positive(&denominator.neg().ok()?, depth - 1)?;
        value.numerator()?.neg().ok()
    }

    /// Whether a value is a whole number wherever the assumptions hold.
    fn integral(&self, value: &Value) -> bool {
        let View::Real(sum, denominator) = value.view() else { return false };
        let whole = |atom: &Atom| match atom {
            Atom::Variable(name) => self.naturals.contains(name),
            Atom::Floor(_) | Atom::Positive(_) => true,
            Atom::Maximum(parts) => parts.iter().all(|part| self.integral(part)),
            _ => false,
        };
        let unit = matches!(denominator.as_slice(), [(number, factors)] if number.is_one() && factors.is_empty());
        unit && sum.iter().all(|(number, factors)| number.is_integer() && factors.iter().all(|(atom, _)| whole(atom)))
    }

    /// Whether a value is 0, 1, 2, …: `None` when undecided.
    pub fn is_natural(&self, value: &Value) -> Option<bool> {
        if let Some(number) = value.as_rational() {
            return Some(number.is_integer() && !number.is_negative());
        }
        let at_least_zero = self.decide(Relation::Gte, value, &Value::zero());
        match (self.integral(value), at_least_zero) {
            (_, Some(false)) => Some(false),
            (true, Some(true)) => Some(true),
            _ => None,
        }
    }

    /// Whether an inequality cannot hold together with what is assumed.
    fn excludes(&self, opposite: Inequality, depth: usize) -> Option<()> {
        let mut facts: Vec<Inequality> = Vec::new();
        for (relation, value) in &self.facts {
            self.add_fact(*relation, value, depth, &mut facts);
        }
        let own: Vec<Inequality> = facts.clone();
        if own.len() <= 10 {
            for (index, one) in own.iter().enumerate() {
                facts.extend(own[index..].iter().filter_map(|other| one.times(other)));
            }
        }
        let mut monomials = opposite.monomials();
        facts.iter().for_each(|fact| monomials.extend(fact.monomials()));
        for monomial in monomials {
            self.add_sign(&monomial, depth, &mut facts);
        }
        facts.push(opposite);
        infeasible(facts).then_some(())
    }

    fn add_fact(&self, relation: Relation, value: &Value, depth: usize, facts: &mut Vec<Inequality>) {
        let polynomial = match value.denominator().and_then(|denominator| denominator.as_rational()) {
            Some(_) => value.numerator(),
            None if depth > 0 => {
                let others = Assumptions {
                    facts: self.facts.iter().filter(|(_, other)| other != value).cloned().collect(),
                    naturals: self.naturals.clone(),
                };
                others.numerator(value, depth - 1)
            }
            None => None,
        };
        let Some(polynomial) = polynomial else { return };
        match relation {
            Relation::Gtr if self.integral(&polynomial) => facts.push(Inequality::of(&polynomial, true).at_least_one()),
            Relation::Gtr => facts.push(Inequality::of(&polynomial, true)),
            Relation::Gte => facts.push(Inequality::of(&polynomial, false)),
            Relation::Eq => {
                facts.push(Inequality::of(&polynomial, false));
                facts.push(Inequality::of(&polynomial, false).negative());
            }
            _ => {}
        }
    }

    /// What is known of a product whatever the assumptions: its sign, and the bounds of a single atom.
    fn add_sign(&self, monomial: &[(Atom, Exponent)], depth: usize, facts: &mut Vec<Inequality>) {
        if let [(atom, 1)] = monomial {
            self.add_bounds(atom, facts);
        }
        let mut strict = true;
        let mut negative = false;
        for (atom, exponent) in monomial {
            let Some((sign, nonzero)) = self.sign(atom, depth) else {
                if exponent % 2 == 0 {
                    strict = false;
                    continue;
                }
                return;
            };
            strict &= nonzero;
            negative ^= sign && exponent % 2 == 1;
        }
        let inequality = Inequality::monomial(monomial, strict);
        facts.push(if negative { inequality.negated_terms() } else { inequality });
    }

    /// Whether an atom is at most 0 (else at least 0), and whether it is surely not 0.
    fn sign(&self, atom: &Atom, depth: usize) -> Option<(bool, bool)> {
        match atom {
            Atom::Maximum(_) | Atom::Positive(_) | Atom::Root(_) => Some((false, false)),
            Atom::Power(base, _) => match base.as_rational() {
                Some(number) if number.is_positive() => Some((false, true)),
                Some(_) => None,
                None if depth > 0 => self.positive(base, depth - 1).map(|()| (false, true)),
                None => None,
            },
            Atom::Variable(name) => self.variable_sign(name),
            _ => None,
        }
    }

    fn variable_sign(&self, name: &Name) -> Option<(bool, bool)> {
        let mut found = self.naturals.contains(name).then_some((false, false));
        for (relation, fact) in &self.facts {
            let Some((factor, rest)) = fact.linear_in(name) else { continue };
            let (Some(factor), Some(rest)) = (factor.as_rational(), rest.as_rational()) else { continue };
            if factor.is_zero() {
                continue;
            }
            // factor * x + rest REL 0
            let bound = -rest / &factor;
            let (above, strict) = match relation {
                Relation::Gtr => (factor.is_positive(), true),
                Relation::Gte => (factor.is_positive(), false),
                _ => continue,
            };
            if above && !bound.is_negative() {
                found = Some((false, strict || bound.is_positive() || found == Some((false, true))));
            } else if !above && !bound.is_positive() {
                found = Some((true, strict || bound.is_negative() || found == Some((true, true))));
            }
        }
        let apart = self.facts.iter().any(|(relation, fact)| {
            *relation == Relation::Neq
                && fact.linear_in(name).is_some_and(|(factor, rest)| {
                    rest.is_zero() && factor.as_rational().is_some_and(|factor| !factor.is_zero())
                })
        });
        found.map(|(negative, strict)| (negative, strict || apart))
    }

    fn add_bounds(&self, atom: &Atom, facts: &mut Vec<Inequality>) {
        let Ok(value) = atom.value() else { return };
        let mut at_least = |difference: Result<Value, crate::value::ValueError>, strict: bool| {
            if let Ok(difference) = difference
                && difference.denominator().and_then(|d| d.as_rational()).is_some_and(|d| d.is_one())
            {
                facts.push(Inequality::of(&difference, strict));
            }
        };
        match atom {
            Atom::Maximum(parts) => parts.iter().for_each(|part| at_least(value.sub(part), false)),
            Atom::Positive(_) => at_least(Value::one().sub(&value), false),
            Atom::Floor(of) => {
                at_least(of.sub(&value), false);
                at_least(value.add(&Value::one()).and_then(|next| next.sub(of)), true);
            }
            _ => {}
        }
    }

    /// The value with each `min`, `max`, `abs` and `if` resolved that the assumptions decide.
    pub fn simplify(&self, value: &Value) -> Value {
        self.simplified(value, DEPTH).unwrap_or_else(|| value.clone())
    }

    fn simplified(&self, value: &Value, depth: usize) -> Option<Value> {
        match value.view() {
            View::Vector(parts) => Value::vector(parts.iter().map(|part| self.simplify(part)).collect()).ok(),
            View::Distribution(kind, parts) => {
                Value::distribution(&kind, parts.iter().map(|part| self.simplify(part)).collect()).ok()
            }
            View::Real(above, below) => {
                let known: Vec<(Atom, Value)> = value
                    .atoms()
                    .into_iter()
                    .filter_map(|atom| self.resolve(&atom, depth).map(|value| (atom, value)))
                    .collect();
                if known.is_empty() {
                    return None;
                }
                let (above, below) = (rebuild(&above, &known)?, rebuild(&below, &known)?);
                let result = above.div(&below).ok()?;
                if depth == 0 || result == *value {
                    Some(result)
                } else {
                    Some(self.simplified(&result, depth - 1).unwrap_or(result))
                }
            }
        }
    }

    fn resolve(&self, atom: &Atom, depth: usize) -> Option<Value> {
        let zero = Value::zero();
        match atom {
            Atom::Positive(of) => {
                let yes = self.decided(Relation::Gtr, of, &zero, depth)?;
                Some(if yes { Value::one() } else { zero })
            }
            Atom::Maximum(parts) => {
                let mut all: Vec<Value> = parts.to_vec();
                all.push(zero);
                let before = all.len();
                let mut index = 0;
                while index < all.len() {
                    let beaten = (0..all.len()).any(|other| {
                        other != index && self.decided(Relation::Gte, &all[other], &all[index], depth) == Some(true)
                    });
                    if beaten {
                        all.remove(index);
                    } else {
                        index += 1;
                    }
                }
                if all.len() == before { None } else { Value::maximum(&all).ok() }
            }
            _ => None,
        }
    }
}

fn rebuild(sum: &[(BigRational, Vec<(Atom, Exponent)>)], known: &[(Atom, Value)]) -> Option<Value> {
    let mut total = Value::zero();
    for (number, factors) in sum {
        let mut product = Value::rational(number.clone());
        for (atom, exponent) in factors {
            let factor = match known.iter().find(|(other, _)| other == atom) {
                Some((_, value)) => value.clone(),
                None => atom.value().ok()?,
            };
            product = product.mul(&factor.power(&Value::integer(i64::from(*exponent))).ok()?).ok()?;
        }
        total = total.add(&product).ok()?;
    }
    Some(total)
}
