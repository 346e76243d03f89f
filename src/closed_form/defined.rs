//! Where a value is defined: what its denominators must not be.

use std::cell::OnceCell;
use std::collections::{BTreeMap, BTreeSet};

use num_bigint::BigInt;
use num_traits::{One, Signed, ToPrimitive, Zero};

use super::apart::{Case, in_cases};
use super::{Comparison, Recurrence, Unchecked, layer};
use crate::assumption::Assumptions;
use crate::exponential_polynomial::tail::throughout;
use crate::exponential_polynomial::{ExponentialPolynomial, exponentials};
use crate::name::Name;
use crate::polynomial::Polynomial;
use crate::univariate::Univariate;
use crate::value::{Atom, Need, Relation, Value};

/// The most coefficients of a polynomial whose roots are looked for.
const MOST_COEFFICIENTS: usize = 65;

/// The least integer from a number on at which a polynomial in the index, with rational coefficients, is 0; the inner
/// option is none when there is no such integer, the outer one when the value is no such polynomial.
pub fn first_zero(value: &Value, index: &Name, from: i64) -> Option<Option<BigInt>> {
    let polynomial = polynomial_in(value, index)?;
    let from = BigInt::from(from);
    let linear = polynomial.factors().into_iter().filter(|(factor, _)| factor.degree() == 1);
    let roots = linear.map(|(factor, _)| -factor.coefficient(0)).filter(|root| root.is_integer());
    Some(roots.map(|root| root.to_integer()).filter(|root| *root >= from).min())
}

/// A value as a polynomial in the index with rational coefficients.
fn polynomial_in(value: &Value, index: &Name) -> Option<Univariate> {
    let parts = exponentials(value, index)?;
    match parts.into_iter().collect::<Vec<_>>().as_slice() {
        [] => Some(Univariate::zero()),
        [(base, coefficients)]
            if coefficients.len() <= MOST_COEFFICIENTS && base.as_rational().is_some_and(|base| base.is_one()) =>
        {
            coefficients.iter().map(Value::as_rational).collect::<Option<Vec<_>>>().map(Univariate::new)
        }
        _ => None,
    }
}

/// The most indices that are passed over since a case cannot be there.
const MOST_IMPOSSIBLE: i64 = 64;

/// The layers that may stand in a value: how many there are, and which of them are known not to be 0.
#[derive(Clone, Copy)]
pub(super) struct Layers<'v> {
    pub count: usize,
    pub fine: &'v [Value],
}

/// What is being collected: the assumptions, and the conditions that had to be added to them.
pub(super) struct Defined<'a> {
    pub(super) index: &'a Name,
    from: i64,
    outer: &'a Assumptions,
    /// The assumptions with the conditions and what is known of the index; most checks do without.
    general: OnceCell<Assumptions>,
    pub(super) conditions: Vec<Comparison>,
}

impl<'a> Defined<'a> {
    pub(super) fn new(index: &'a Name, from: i64, outer: &'a Assumptions, conditions: Vec<Comparison>) -> Defined<'a> {
        Defined { index, from, outer, general: OnceCell::new(), conditions }
    }

    /// What is known, of the index too.
    pub(super) fn known(&self) -> &Assumptions {
        self.general.get_or_init(|| {
            let mut general = self.outer.clone();
            self.conditions.iter().for_each(|(relation, left, right)| general.assume(*relation, left, right));
            if self.from >= 0 {
                general.assume_natural(self.index);
            }
            if self.from != 0 {
                general.assume(Relation::Gte, &Value::variable(self.index), &Value::integer(self.from));
            }
            general
        })
    }

    /// From here on the index counts something else, from 0.
    pub(super) fn count_rounds(&mut self) {
        self.from = 0;
        self.general = OnceCell::new();
    }

    /// Makes sure that a value is defined for every index from this one on: adds conditions on what is free of the
    /// index.
    pub(super) fn value(&mut self, value: &Value, from: i64) -> Result<(), Unchecked> {
        self.in_layers(value, from, Layers { count: 0, fine: &[] })
    }

    /// The same where a value has conditions: what is divided by in one case only must not be 0 in that.
    pub(super) fn in_each_case(&mut self, value: &Value, from: i64) -> Result<(), Unchecked> {
        if !value.atoms().iter().any(|atom| matches!(atom, Atom::Positive(_))) {
            return self.value(value, from);
        }
        for Case { known, value, asked, .. } in in_cases(value, &BTreeMap::new(), self.known())? {
            let mut below = Vec::new();
            if let Some((_, denominator)) = value.polynomials() {
                below = factors(denominator)?;
                self.inverted(&value, from, &mut below)?;
            }
            below.retain(|part| !self.never_zero_where(&known, part, from));
            self.none_zero(below, from, Layers { count: 0, fine: &[] })?;
            for asked in asked {
                if let Need::Nonzero(part) = &asked.need
                    && !self.never_zero_where(&asked.known, part, from)
                {
                    self.always(&asked.need, from)?;
                }
            }
        }
        Ok(())
    }

    /// An index, from this one on, before which this cannot be.
    pub(super) fn first_possible(&self, known: &Assumptions, from: i64) -> i64 {
        let possible = |at: &i64| {
            let mut here = known.clone();
            here.assume(Relation::Eq, &Value::variable(self.index), &Value::integer(*at));
            !here.contradictory()
        };
        let all = from..from.saturating_add(MOST_IMPOSSIBLE);
        all.clone().find(possible).unwrap_or(all.end)
    }

    /// Whether a value is not 0 at any index from this one on at which this can be.
    fn never_zero_where(&self, known: &Assumptions, value: &Value, mut from: i64) -> bool {
        if known.grants(&Need::Nonzero(value.clone())) == Some(true) {
            return true;
        }
        for _ in 0..MOST_COEFFICIENTS {
            let Some(zero) = first_zero(value, self.index, from) else { return false };
            let Some(zero) = zero else { return true };
            let (Some(zero), mut here) = (zero.to_i64(), known.clone()) else { return false };
            here.assume(Relation::Eq, &Value::variable(self.index), &Value::integer(zero));
            let Some(next) = zero.checked_add(1).filter(|_| here.contradictory()) else { return false };
            from = next;
        }
        false
    }

    /// The same for a value in layers.
    pub(super) fn in_layers(&mut self, value: &Value, from: i64, layers: Layers<'_>) -> Result<(), Unchecked> {
        let Some((_, denominator)) = value.polynomials() else { return Ok(()) };
        let mut below = factors(denominator)?;
        self.inverted(value, from, &mut below)?;
        self.none_zero(below, from, layers)
    }

    /// The bases of powers whose exponent may be negative from this index on: `c^n`, where n begins at -1.
    fn inverted(&self, value: &Value, from: i64, found: &mut Vec<Value>) -> Result<(), Unchecked> {
        for atom in value.atoms().into_iter().filter(|atom| atom.mentions(self.index)) {
            let inner = match &atom {
                Atom::Power(base, exponent) => {
                    if base.as_rational().is_none_or(|base| base.is_zero()) && !self.natural(exponent, from)? {
                        found.push(base.clone());
                    }
                    vec![base.clone()]
                }
                Atom::Maximum(elements) => elements.to_vec(),
                Atom::Positive(inner) | Atom::Floor(inner) | Atom::Root(inner) => vec![inner.clone()],
                Atom::Apply(..) | Atom::Variable(_) => continue,
            };
            inner.iter().try_for_each(|part| self.inverted(part, from, found))?;
        }
        Ok(())
    }

    /// Whether an exponent is surely not negative from this index on.
    fn natural(&self, exponent: &Value, from: i64) -> Result<bool, Unchecked> {
        let first = exponent.with(self.index, &Value::integer(from))?;
        let rises = exponent.linear_in(self.index).and_then(|(slope, _)| slope.as_rational());
        Ok(rises.is_some_and(|slope| !slope.is_negative())
            && self.known().decide(Relation::Gte, &first, &Value::zero()) == Some(true))
    }

    fn none_zero(&mut self, factors: Vec<Value>, from: i64, layers: Layers<'_>) -> Result<(), Unchecked> {
        let Layers { count, fine } = layers;
        for part in factors.into_iter().filter(|part| !fine.contains(part)) {
            if (0..count).any(|place| part.mentions(&layer(place))) {
                return Err(Unchecked(format!("it divides by {part}, which may be 0")));
            }
            self.not_zero(&part, from)?;
        }
        Ok(())
    }

    /// Makes sure that a quotient is defined and not 0 for every index from this one on.
    pub(super) fn never_zero(&mut self, value: &Value, from: i64, layers: Layers<'_>) -> Result<(), Unchecked> {
        if value.is_zero() {
            return Err(Unchecked("it multiplies by 0".to_string()));
        }
        self.in_layers(value, from, layers)?;
        // Not by 1/value: that of `if n = 3 then 0 else 1` is 1 wherever it is defined.
        let Some((numerator, _)) = value.polynomials() else { return Err(Unchecked(format!("{value} is no number"))) };
        self.none_zero(factors(numerator)?, from, layers)
    }

    pub(super) fn sum(&mut self, sum: &ExponentialPolynomial, from: i64) -> Result<(), Unchecked> {
        for (_, rows) in sum.parts() {
            rows.iter().flatten().try_for_each(|value| self.in_each_case(value, from))?;
        }
        Ok(())
    }

    /// Makes sure that what stands under a root of a value, and not of the recurrence, is not negative: adds conditions
    /// on what is free of the index.
    pub(super) fn roots(&mut self, value: &Value, recurrence: &Recurrence) -> Result<(), Unchecked> {
        let inner = |need: Need| if let Need::Nonnegative(inner) = need { Some(inner) } else { None };
        let mut rest: BTreeSet<Value> = value.needs().into_iter().filter_map(inner).collect();
        if rest.is_empty() {
            return Ok(());
        }
        for given in recurrence.sequences.iter().flat_map(|sequence| sequence.start.iter().chain([&sequence.next])) {
            let given: BTreeSet<Value> = given.needs().into_iter().filter_map(inner).collect();
            rest.retain(|inner| !given.contains(inner));
        }
        rest.iter().try_for_each(|inner| self.never_negative(inner, self.from))
    }

    /// Makes sure that what is free of terms is as it must be at every index from this one on: adds conditions on what is
    /// free of the index.
    pub(super) fn always(&mut self, need: &Need, from: i64) -> Result<(), Unchecked> {
        match need {
            Need::Nonzero(value) => {
                let Some((numerator, _)) = value.polynomials() else { return Err(Unchecked(need.to_string())) };
                factors(numerator)?.iter().try_for_each(|factor| self.not_zero(factor, from))
            }
            Need::Nonnegative(value) => self.never_negative(value, from),
            Need::Natural(_) => Ok(()),
        }
    }

    /// Makes sure that a value is not negative at any index from this one on: where it rises, if it is not at the first.
    fn never_negative(&mut self, value: &Value, from: i64) -> Result<(), Unchecked> {
        let (index, first) = (self.index, value.with(self.index, &Value::integer(from))?);
        let negative = |value: &Value| Unchecked(format!("it takes the root of {value}, which is negative"));
        match self.known().grants(&Need::Nonnegative(first.clone())) {
            Some(false) if !value.mentions(index) => return Err(negative(value)),
            Some(false) => return Err(Unchecked(format!("it takes the root of {first} at {index} = {from}"))),
            _ if self.known().grants(&Need::Nonnegative(value.clone())) == Some(true) => return Ok(()),
            _ => {}
        }
        if let (Some(sum), Ok(from)) = (ExponentialPolynomial::of(value, index), u64::try_from(from))
            && throughout(&sum, Relation::Gte, from, None)
        {
            return Ok(());
        }
        let rises = match value.linear_in(index) {
            _ if !value.mentions(index) => Some(true),
            Some((slope, _)) if !slope.mentions(index) => self.known().decide(Relation::Gte, &slope, &Value::zero()),
            _ => None,
        };
        match rises {
            Some(true) => {
                if self.known().grants(&Need::Nonnegative(first.clone())) != Some(true) {
                    self.not_negative(&first);
                }
                Ok(())
            }
            Some(false) => {
                Err(Unchecked(format!("it takes the root of {value}, which is negative from some {index} on")))
            }
            None => Err(Unchecked(format!("it must be known whether {value} is ever negative"))),
        }
    }

    /// Adds the condition that a value which is free of the index is not negative.
    pub(super) fn not_negative(&mut self, value: &Value) {
        let condition = (Relation::Gte, value.clone(), Value::zero());
        if !self.conditions.contains(&condition) {
            self.conditions.push(condition);
            self.general = OnceCell::new();
        }
    }

    fn not_zero(&mut self, value: &Value, from: i64) -> Result<(), Unchecked> {
        let zero = Value::zero();
        match self.known().grants(&Need::Nonzero(value.clone())) {
            Some(true) => return Ok(()),
            Some(false) => return Err(Unchecked("it divides by 0".to_string())),
            None => {}
        }
        if !value.mentions(self.index) {
            self.conditions.push((Relation::Neq, value.clone(), zero));
            self.general = OnceCell::new();
            return Ok(());
        }
        if let (Some(sum), Ok(from)) = (ExponentialPolynomial::of(value, self.index), u64::try_from(from))
            && [Relation::Gtr, Relation::Lss].into_iter().any(|side| throughout(&sum, side, from, None))
        {
            return Ok(());
        }
        if self.keeps_its_sign(value, from)? {
            return Ok(());
        }
        match first_zero(value, self.index, from) {
            Some(None) => Ok(()),
            Some(Some(root)) => Err(Unchecked(format!("it divides by 0 at {} = {root}", self.index))),
            None => Err(Unchecked(format!("it must be known whether {value} is ever 0"))),
        }
    }
}

impl Defined<'_> {
    /// Whether `e(n) = a*p^n + b*q^n`, where nothing else has the index, is never 0 from this index on if its first
    /// value is not, which then is known or becomes a condition: with p and q above 0, `e(n+1) = p*e(n) + b*(q-p)*q^n`
    /// has the sign of `e(n)` where `b*(q-p)` has that of the first value, or is 0.
    fn keeps_its_sign(&mut self, value: &Value, from: i64) -> Result<bool, Unchecked> {
        let parts: Vec<(Value, Vec<Value>)> = exponentials(value, self.index).into_iter().flatten().collect();
        let [(one, first), (other, second)] = parts.as_slice() else { return Ok(false) };
        let ([first], [second]) = (first.as_slice(), second.as_slice()) else { return Ok(false) };
        let (start, zero) = (value.with(self.index, &Value::integer(from))?, Value::zero());
        let above = |value: &Value| self.known().decide(Relation::Gtr, value, &zero) == Some(true);
        if !above(one) || !above(other) {
            return Ok(false);
        }
        for (p, q, b) in [(one, other, second), (other, one, first)] {
            // Where p is q, it is `(a+b)*p^n`: not 0 if its first value is not.
            let change = q.sub(p)?;
            let Ok(ratio) = start.div(&change) else { continue };
            if self.known().decide(Relation::Gte, &ratio.mul(b)?, &zero) != Some(true) {
                continue;
            }
            let nonzero = |value: &Value| self.known().decide(Relation::Neq, value, &zero) == Some(true);
            if !nonzero(&start) {
                let needed = if nonzero(&ratio) { change } else { start };
                let Some((numerator, _)) = needed.polynomials() else { return Ok(false) };
                factors(numerator)?.iter().try_for_each(|factor| self.not_zero(factor, from))?;
            }
            return Ok(true);
        }
        Ok(false)
    }
}

/// The factors of a polynomial that may be 0; powers by their bases.
fn factors(polynomial: &Polynomial<Atom>) -> Result<Vec<Value>, Unchecked> {
    let content = polynomial.monomial_content();
    let rest = polynomial.without(&content);
    let mut all = Vec::new();
    if rest.as_constant().is_none_or(|number| number.is_zero()) {
        all.push(Value::from_polynomials(rest, Polynomial::one())?);
    }
    for (atom, _) in content.factors() {
        match atom {
            Atom::Power(base, _) if base.as_rational().is_some_and(|base| !base.is_zero()) => {}
            Atom::Power(base, _) => all.push(base.clone()),
            other => all.push(other.value()?),
        }
    }
    Ok(all)
}
