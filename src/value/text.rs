//! Values as text in the surface syntax: what is printed parses back to the same normal form.

use std::collections::BTreeMap;
use std::fmt;

use num_rational::BigRational;
use num_traits::{One, Signed, ToPrimitive, Zero};

use super::denominator::hides_a_sign;
use super::{Atom, Content, Real, Sort, Value};
use crate::polynomial::{Budget, Monomial, Polynomial};

/// Atoms with their exponents, negative below the bar.
type Product = Vec<(Atom, i64)>;

mod length;
mod order;
mod remainder;

impl fmt::Display for Sort {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Sort::Real => f.write_str("a number"),
            Sort::Vector(length) => write!(f, "a vector of {length}"),
            Sort::Distribution => f.write_str("a distribution"),
        }
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&Printer { expansions: 48 }.value(self).0)
    }
}

impl Value {
    /// The comparison of this with 0 as text, with what is subtracted on the other side: `x > 2*a` of `x-2*a` and `>`.
    pub(crate) fn compared(&self, symbol: &str) -> String {
        Printer { expansions: 48 }.condition(self, symbol)
    }
}

/// How tightly the outermost operator of a text binds.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Level {
    Choice,
    Sum,
    Product,
    Power,
    Atom,
}

type Text = (String, Level);

/// Knows how many more times a condition or maximum may be written out in a longer, more readable form.
struct Printer {
    expansions: usize,
}

fn wrap((text, level): Text, least: Level) -> String {
    if level < least { format!("({text})") } else { text }
}

fn number(value: &BigRational) -> Text {
    let level = match (value.is_negative(), value.is_integer()) {
        (true, _) => Level::Sum,
        (false, true) => Level::Atom,
        (false, false) => Level::Product,
    };
    (value.to_string(), level)
}

impl Printer {
    fn value(&mut self, value: &Value) -> Text {
        match &value.0.content {
            Content::Vector(parts) => self.vector(parts),
            Content::Distribution(kind, parts) => (self.distribution(kind, parts), Level::Atom),
            Content::Real(numerator, denominator) => match self.remainder(value) {
                Some(shorter) => self.value(&shorter),
                None => self.fraction(numerator, denominator),
            },
        }
    }

    fn vector(&mut self, parts: &[Value]) -> Text {
        self.choice_of_vectors(parts).unwrap_or_else(|| (format!("({})", self.list(parts)), Level::Atom))
    }

    fn list(&mut self, parts: &[Value]) -> String {
        parts.iter().map(|part| self.value(part).0).collect::<Vec<_>>().join(",")
    }

    fn distribution(&mut self, kind: &str, parts: &[Value]) -> String {
        let texts: Vec<String> = parts.iter().map(|part| self.value(part).0).collect();
        match (kind, parts) {
            ("Normal", [_, _]) => format!("Normal({}, var: {})", texts[0], texts[1]),
            ("Exp" | "Poisson", [_]) => format!("{kind}(rate: {})", texts[0]),
            ("Mix", _) => {
                let pairs = parts.chunks(2).zip(texts.chunks(2));
                let weighted = pairs.map(|(_, pair)| pair.join(": "));
                format!("Mix({})", weighted.collect::<Vec<_>>().join(", "))
            }
            _ => format!("{kind}({})", texts.join(",")),
        }
    }

    fn fraction(&mut self, numerator: &Real, denominator: &Real) -> Text {
        if let Some(text) = self.choice(numerator, denominator) {
            return text;
        }
        if let [(monomial, _)] = denominator.terms() {
            if !monomial.factors().is_empty() && self.folds(numerator) {
                let (top, bottom) = (self.sum(numerator, &Monomial::one()), self.sum(denominator, &Monomial::one()));
                return (format!("{}/{}", wrap(top, Level::Product), wrap(bottom, Level::Power)), Level::Product);
            }
            return self.sum(numerator, monomial);
        }
        let scale = denominator.content().recip();
        let (numerator, denominator) = (numerator.scale(&scale), denominator.scale(&scale));
        if let Some(text) = self.over_root(&numerator, &denominator) {
            return text;
        }
        let mut top = self.sum(&numerator, &Monomial::one());
        let mut bottom = self.sum(&denominator, &Monomial::one());
        // `g/(b-a)`, not `(-g)/(a-b)`.
        let both = numerator.terms().iter().all(|(_, number)| number.is_negative())
            && denominator.terms().iter().any(|(_, number)| number.is_negative());
        if bottom.0.starts_with('-') || both {
            top = self.sum(&numerator.negated(), &Monomial::one());
            bottom = self.sum(&denominator.negated(), &Monomial::one());
        }
        // Read as a quotient it would be a sign.
        if hides_a_sign(&numerator, &denominator) {
            return (format!("{}*(1/{})", wrap(top, Level::Product), wrap(bottom, Level::Power)), Level::Product);
        }
        (format!("{}/{}", wrap(top, Level::Product), wrap(bottom, Level::Power)), Level::Product)
    }

    /// `(y*s+x*sqrt(s))/s` as `y+x/sqrt(s)`.
    fn over_root(&mut self, numerator: &Real, denominator: &Real) -> Option<Text> {
        let times = |atom: &Atom| match atom {
            Atom::Root(inner) => inner.parts()?.0.divide(denominator, &mut Budget::new(2_000))?.as_constant(),
            _ => None,
        };
        let (root, times) = numerator.atoms().into_iter().find_map(|atom| Some((atom.clone(), times(atom)?)))?;
        let mut parts = numerator.coefficients_in(&root);
        let (whole, top) = (parts.remove(&0).unwrap_or_else(Polynomial::zero), parts.remove(&1)?.scale(&times));
        let whole = whole.divide(denominator, &mut Budget::new(2_000)).filter(|_| parts.is_empty())?;
        let over = |top: Text, bottom: Text| format!("{}/{}", wrap(top, Level::Product), wrap(bottom, Level::Power));
        let bottom = self.atom(&root);
        let negative = !whole.is_zero() && top.leading().is_negative();
        let top = if negative { top.negated() } else { top };
        let text = over(self.sum(&top, &Monomial::one()), bottom);
        if whole.is_zero() {
            return Some((text, Level::Product));
        }
        let whole = wrap(self.sum(&whole, &Monomial::one()), Level::Sum);
        Some((format!("{whole}{}{text}", if negative { '-' } else { '+' }), Level::Sum))
    }

    /// A sum of terms over one monomial.
    fn sum(&mut self, numerator: &Real, divisor: &Monomial<Atom>) -> Text {
        if !divisor.factors().is_empty() {
            return self.joined(Vec::new(), numerator, divisor);
        }
        match self.maxima(numerator) {
            Ok(text) => text,
            Err((pieces, rest)) => self.joined(pieces, &rest, divisor),
        }
    }

    /// The sum of these pieces and of the terms of a sum over one monomial.
    fn joined(&mut self, mut pieces: Vec<Piece>, rest: &Real, divisor: &Monomial<Atom>) -> Text {
        let mut groups: BTreeMap<Product, Vec<(BigRational, Product)>> = BTreeMap::new();
        for (monomial, coefficient) in rest.terms() {
            let (powers, others) = signed_factors(monomial, divisor).into_iter().partition(is_shared);
            groups.entry(powers).or_default().push((coefficient.clone(), others));
        }
        for (powers, terms) in groups {
            self.group(&powers, terms, &mut pieces);
        }
        pieces.sort_by_key(|piece| piece.degree);
        join(pieces)
    }

    /// The terms that share their symbolic powers and divisors: more than one are put in brackets.
    fn group(&mut self, powers: &[(Atom, i64)], terms: Vec<(BigRational, Vec<(Atom, i64)>)>, pieces: &mut Vec<Piece>) {
        let mut inner = Vec::new();
        let together = !powers.is_empty() && terms.len() > 1;
        let content = if together { content(&terms) } else { BigRational::one() };
        for (coefficient, factors) in terms {
            let mut all = factors.clone();
            if !together {
                all.extend(powers.iter().cloned());
            }
            let degree = if all.is_empty() && powers.is_empty() {
                u64::MAX
            } else {
                all.iter().map(|(_, exponent)| exponent.unsigned_abs()).sum()
            };
            let size = coefficient.abs() / &content;
            let ceiling = if coefficient.is_negative() { self.ceiling(&size, &all) } else { None };
            let negative = coefficient.is_negative() && ceiling.is_none();
            let text = match ceiling {
                Some(text) => text,
                None => self.term(&size, &all),
            };
            inner.push(Piece { negative, text, degree });
        }
        if !together {
            pieces.append(&mut inner);
            return;
        }
        inner.sort_by_key(|piece| if piece.degree == 0 { u64::MAX } else { piece.degree });
        let bracket = wrap(join(inner), Level::Power);
        let (tops, bottoms) = self.factors(powers);
        let text = quotient(content, tops.into_iter().chain([bracket]).collect(), bottoms);
        pieces.push(Piece { negative: false, text, degree: 1000 });
    }

    /// `-t*floor(x)` as `t*ceil(-x)`, where that is no longer.
    fn ceiling(&mut self, size: &BigRational, factors: &[(Atom, i64)]) -> Option<Text> {
        let place = factors.iter().position(|factor| matches!(factor, (Atom::Floor(_), 1)))?;
        let (Atom::Floor(part), _) = &factors[place] else { return None };
        self.expansions = self.expansions.checked_sub(1)?;
        let (floor, ceiling) = (self.value(part).0, self.value(&part.neg().ok()?).0);
        let others = [&factors[..place], &factors[place + 1..]].concat();
        let (mut tops, bottoms) = self.factors(&others);
        tops.push(format!("ceil({ceiling})"));
        (ceiling.len() <= floor.len()).then(|| quotient(size.clone(), tops, bottoms))
    }

    fn term(&mut self, coefficient: &BigRational, factors: &[(Atom, i64)]) -> Text {
        let (tops, bottoms) = self.factors(factors);
        quotient(coefficient.clone(), tops, bottoms)
    }

    /// The texts of factors above and below the line.
    fn factors(&mut self, factors: &[(Atom, i64)]) -> (Vec<String>, Vec<String>) {
        let (mut tops, mut bottoms) = (Vec::new(), Vec::new());
        let mut bases: BTreeMap<&Value, BigRational> = BTreeMap::new();
        let mut root = BigRational::one();
        let turned = turned(factors);
        for (atom, exponent) in turned.as_deref().unwrap_or(factors) {
            if let Some((power, exponent)) = rational_power(atom, *exponent) {
                *bases.entry(exponent).or_insert_with(BigRational::one) *= power;
                continue;
            }
            if let (Atom::Root(inner), 1) = (atom, exponent)
                && let Some(inner) = inner.as_rational()
            {
                root *= inner;
                continue;
            }
            let text = self.power(atom, exponent.unsigned_abs());
            if *exponent > 0 { tops.push(text) } else { bottoms.push(text) }
        }
        for (exponent, base) in bases {
            let base = wrap(number(&base), Level::Atom);
            tops.insert(0, format!("{base}^{}", wrap(self.value(exponent), Level::Atom)));
        }
        if !root.is_one() {
            tops.push(format!("sqrt({root})"));
        }
        (tops, bottoms)
    }

    /// An atom to a power of at least 1, fit to stand in a product.
    fn power(&mut self, atom: &Atom, exponent: u64) -> String {
        if let Atom::Power(base, inner) = atom {
            let base = wrap(self.value(base), Level::Atom);
            let count = BigRational::from_integer(exponent.into());
            let inner = inner.scale(&count).map(|inner| wrap(self.value(&inner), Level::Atom));
            return inner.map(|inner| format!("{base}^{inner}")).unwrap_or_default();
        }
        let text = self.atom(atom);
        if exponent == 1 { wrap(text, Level::Power) } else { format!("{}^{exponent}", wrap(text, Level::Atom)) }
    }

    fn atom(&mut self, atom: &Atom) -> Text {
        let text = match atom {
            Atom::Variable(name) => name.to_string(),
            Atom::Power(..) => return (self.power(atom, 1), Level::Power),
            Atom::Maximum(parts) => format!("max(0,{})", self.list(parts)),
            Atom::Positive(part) => {
                let condition = self.condition(part, ">");
                return (format!("if {condition} then 1 else 0"), Level::Choice);
            }
            Atom::Floor(part) => format!("floor({})", self.value(part).0),
            Atom::Root(part) => match self.length(part) {
                Some(text) => text,
                None => format!("sqrt({})", self.value(part).0),
            },
            Atom::Apply(function, parts) => format!("{function}({})", self.list(parts)),
        };
        (text, Level::Atom)
    }
}

/// A summand, with what it is sorted by.
struct Piece {
    negative: bool,
    text: Text,
    degree: u64,
}

/// The sum of the pieces; one that is not subtracted comes first, where there is one.
fn join(mut pieces: Vec<Piece>) -> Text {
    if let Some(first) = pieces.iter().position(|piece| !piece.negative) {
        let piece = pieces.remove(first);
        pieces.insert(0, piece);
    }
    let alone = pieces.len() == 1 && !pieces[0].negative;
    let mut whole = String::new();
    for (place, piece) in pieces.into_iter().enumerate() {
        if alone {
            return piece.text;
        }
        match (piece.negative, place) {
            (true, _) => whole.push('-'),
            (false, 0) => {}
            (false, _) => whole.push('+'),
        }
        whole.push_str(&wrap(piece.text, Level::Product));
    }
    if whole.is_empty() { ("0".to_string(), Level::Atom) } else { (whole, Level::Sum) }
}

/// `p*a*b/(q*c)`; without divisors `p/q*a*b`.
fn quotient(coefficient: BigRational, mut tops: Vec<String>, mut bottoms: Vec<String>) -> Text {
    let apart = bottoms.is_empty();
    let head = if apart { coefficient.clone() } else { BigRational::from_integer(coefficient.numer().clone()) };
    if !head.is_one() || tops.is_empty() {
        tops.insert(0, head.to_string());
    }
    let level = match tops.len() {
        1 if apart && head.is_one() && tops[0].contains('^') => Level::Power,
        1 if apart && (coefficient.is_integer() || !head.is_one()) => Level::Atom,
        _ => Level::Product,
    };
    let level = if tops.len() == 1 && apart && !coefficient.is_integer() { Level::Product } else { level };
    let top = tops.join("*");
    if apart {
        return (top, level);
    }
    if !coefficient.is_integer() {
        bottoms.insert(0, coefficient.denom().to_string());
    }
    let bottom = if bottoms.len() == 1 { bottoms.swap_remove(0) } else { format!("({})", bottoms.join("*")) };
    (format!("{top}/{bottom}"), Level::Product)
}

/// The greatest rational that leaves integer coefficients.
fn content(terms: &[(BigRational, Vec<(Atom, i64)>)]) -> BigRational {
    let atom = |place: usize| Atom::Variable(crate::name::Name::new(&place.to_string()));
    let apart = terms
        .iter()
        .enumerate()
        .filter_map(|(place, (number, _))| Some((Monomial::of([(atom(place), 1)])?, number.clone())));
    Polynomial::of(apart).content()
}

/// What is put outside the brackets: symbolic powers, divisors, maxima, and roots of what is no number.
fn is_shared((atom, exponent): &(Atom, i64)) -> bool {
    *exponent < 0
        || match atom {
            Atom::Power(..) | Atom::Maximum(_) => true,
            Atom::Root(inner) => inner.as_rational().is_none(),
            _ => false,
        }
}

/// `(-1)^n*(k-1)^n` as `(1-k)^n`.
fn turned(factors: &[(Atom, i64)]) -> Option<Vec<(Atom, i64)>> {
    let minus = Value::integer(-1);
    let sign = factors
        .iter()
        .position(|(atom, exponent)| *exponent == 1 && matches!(atom, Atom::Power(base, _) if *base == minus))?;
    let Atom::Power(_, count) = &factors[sign].0 else { return None };
    let (place, base) = factors.iter().enumerate().find_map(|(place, (atom, exponent))| match atom {
        Atom::Power(base, own) if *exponent == 1 && own == count && base.as_rational().is_none() => Some((place, base)),
        _ => None,
    })?;
    let mut turned = factors.to_vec();
    turned[place].0 = Atom::Power(base.neg().ok()?, count.clone());
    turned.remove(sign);
    Some(turned)
}

/// `b^n` with a rational base, to a small power: the base and the symbolic exponent.
fn rational_power(atom: &Atom, exponent: i64) -> Option<(BigRational, &Value)> {
    let Atom::Power(base, symbol) = atom else { return None };
    let base = base.as_rational()?;
    if exponent.unsigned_abs().saturating_mul(base.numer().bits()) > 256 || base.is_zero() && exponent < 0 {
        return None;
    }
    Some((base.pow(exponent.to_i32()?), symbol))
}

/// The factors of a monomial over another.
fn signed_factors(monomial: &Monomial<Atom>, divisor: &Monomial<Atom>) -> Vec<(Atom, i64)> {
    let mut exponents: BTreeMap<Atom, i64> = BTreeMap::new();
    for (atom, exponent) in monomial.factors() {
        *exponents.entry(atom.clone()).or_insert(0) += i64::from(*exponent);
    }
    for (atom, exponent) in divisor.factors() {
        *exponents.entry(atom.clone()).or_insert(0) -= i64::from(*exponent);
    }
    exponents.into_iter().filter(|(_, exponent)| *exponent != 0).collect()
}
