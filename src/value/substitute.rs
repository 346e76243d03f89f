//! Simultaneous substitution, and distributions.

use std::collections::BTreeMap;

use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use super::squares::over_length;
use super::{Atom, Content, Outcome, Real, Sort, Value, ValueError};
use crate::name::Name;
use crate::polynomial::Polynomial;
use crate::rational;

impl Value {
    /// It with values for variables, all at once.
    ///
    /// # Errors
    /// When the result is not defined (division by 0, wrong sorts) or too large.
    pub fn substitute(&self, images: &BTreeMap<Name, Value>) -> Result<Value, ValueError> {
        self.replace(&mut |atom| images.get(atom.name()?).cloned())
    }

    /// It with a value for one variable.
    ///
    /// # Errors
    /// As [`Value::substitute`].
    pub fn with(&self, name: &Name, image: &Value) -> Result<Value, ValueError> {
        if !self.mentions(name) {
            return Ok(self.clone());
        }
        self.replace(&mut |atom| (atom.name() == Some(name)).then(|| image.clone()))
    }

    /// It with a value for one atom, where that atom stands in no other.
    pub(crate) fn with_atom(&self, atom: &Atom, image: &Value) -> Outcome {
        let (numerator, denominator) = self.real()?;
        let images = BTreeMap::from([(atom, Some(image.clone()))]);
        evaluate(numerator, &images)?.div(&evaluate(denominator, &images)?)
    }

    /// It with values for atoms at any depth, an outer one before those in it.
    ///
    /// # Errors
    /// As [`Value::substitute`].
    pub(crate) fn replace(&self, images: &mut dyn FnMut(&Atom) -> Option<Value>) -> Outcome {
        match &self.0.content {
            Content::Vector(parts) => Value::vector(replace_all(parts, images)?),
            Content::Distribution(kind, parts) => Value::distribution(kind, replace_all(parts, images)?),
            Content::Real(numerator, denominator) => {
                let mut done = BTreeMap::new();
                let (mut touched, mut failed) = (false, None);
                for atom in numerator.atoms().into_iter().chain(denominator.atoms()) {
                    if !done.contains_key(atom) {
                        match replace_atom(atom, images) {
                            Ok(image) => {
                                touched |= image.is_some();
                                done.insert(atom, image);
                            }
                            Err(error) => failed = failed.or(Some(error)),
                        }
                    }
                }
                if let Some(error) = failed {
                    return self.replace_conditions_first((numerator, denominator), &done, images, error);
                }
                if !touched {
                    return Ok(self.clone());
                }
                if denominator.is_one() {
                    return evaluate(numerator, &done)?.div(&Value::one());
                }
                if let Some(value) = evaluate_over_length((numerator, denominator), &done)? {
                    return Ok(value);
                }
                let bottom = evaluate(denominator, &done)?;
                if !bottom.is_zero() {
                    return evaluate(numerator, &done)?.div(&bottom);
                }
                let error = ValueError::new("division by zero");
                self.replace_conditions_first((numerator, denominator), &done, images, error)
            }
        }
    }

    /// Where the denominator becomes 0, or a root has no value, a condition that is decided may remove it:
    /// `if x = 0 then 0 else 1/x`, `if x > 2 then sqrt(x-2) else 0`. Else this is the error.
    fn replace_conditions_first(
        &self,
        (numerator, denominator): (&Real, &Real),
        done: &BTreeMap<&Atom, Option<Value>>,
        images: &mut dyn FnMut(&Atom) -> Option<Value>,
        error: ValueError,
    ) -> Outcome {
        let decided: BTreeMap<&Atom, Option<Value>> = done
            .iter()
            .map(|(atom, image)| {
                let fixed = image.clone().filter(|image| atom.is_binary() && image.as_rational().is_some());
                (*atom, fixed)
            })
            .collect();
        let simpler = evaluate(numerator, &decided)?.div(&evaluate(denominator, &decided)?)?;
        if simpler == *self {
            return Err(error);
        }
        simpler.replace(images)
    }

    /// A distribution: `Normal` (mean, variance), `Exp` (rate), `Poisson` (rate), `Uniform` (low, high), `Point` (value) or
    /// `Mix` (weight, distribution, weight, distribution, …).
    ///
    /// # Errors
    /// On an unknown kind, a wrong number or sort of arguments, or numbers that make no distribution.
    pub fn distribution(kind: &str, arguments: Vec<Value>) -> Result<Value, ValueError> {
        let wrong = |text: &str| Err(ValueError(format!("{kind} {text}")));
        let known = arguments.iter().map(Value::as_rational).collect::<Vec<_>>();
        let number = |place: usize| known.get(place).cloned().flatten();
        match (kind, arguments.len()) {
            ("Mix", count) if count >= 2 && count % 2 == 0 => return Value::mixture(arguments),
            ("Mix", _) => return wrong("needs weights and distributions in turn: Mix(w1: D1, w2: D2)"),
            ("Normal", 2) if number(1).is_some_and(|variance| variance.is_negative()) => {
                return wrong("needs a spread that is not negative");
            }
            ("Exp" | "Poisson", 1) if number(0).is_some_and(|rate| !rate.is_positive()) => {
                return wrong("needs a rate greater than 0");
            }
            ("Uniform", 2) if number(0).zip(number(1)).is_some_and(|(low, high)| low > high) => {
                return wrong("needs its lower bound first");
            }
            ("Normal" | "Uniform", 2) | ("Exp" | "Poisson" | "Point", 1) => {}
            ("Normal", _) => return wrong("needs a mean and a variance"),
            ("Uniform", _) => return wrong("needs a lower and an upper bound"),
            ("Exp" | "Poisson", _) => return wrong("needs a rate"),
            ("Point", _) => return wrong("needs one value"),
            _ => return wrong("is not a distribution; known are Normal, Exp, Poisson, Uniform, Point and Mix"),
        }
        if arguments.iter().any(|argument| argument.sort() == Sort::Distribution) {
            return wrong("takes numbers, not distributions");
        }
        // Without any spread it is a point.
        match (kind, number(0), number(1)) {
            ("Normal", _, Some(variance)) if variance.is_zero() => Value::point(arguments),
            ("Uniform", Some(low), Some(high)) if low == high => Value::point(arguments),
            _ => Value::new(Content::Distribution(kind.to_string(), arguments)),
        }
    }

    fn point(arguments: Vec<Value>) -> Outcome {
        Value::new(Content::Distribution("Point".to_string(), arguments.into_iter().take(1).collect()))
    }

    /// The number that is drawn from a distribution that has one value only.
    pub(crate) fn certain(&self) -> Option<Value> {
        match &self.0.content {
            Content::Distribution(kind, parts) if kind == "Point" => {
                parts.first().filter(|value| value.sort() == Sort::Real).cloned()
            }
            _ => None,
        }
    }

    fn mixture(arguments: Vec<Value>) -> Outcome {
        let mut total = Some(BigRational::zero());
        for pair in arguments.chunks(2) {
            let [weight, part] = pair else { continue };
            weight.real()?;
            if part.sort() != Sort::Distribution {
                return Err(ValueError(format!("Mix mixes distributions, and `{part}` is {}", part.sort())));
            }
            let number = weight.as_rational();
            if number.as_ref().is_some_and(Signed::is_negative) {
                return Err(ValueError::new("Mix needs weights that are not negative"));
            }
            total = total.zip(number).map(|(total, number)| total + number);
        }
        if let Some(total) = total.filter(|total| !total.is_one()) {
            return Err(ValueError(format!("the weights of Mix must add up to 1, and these add up to {total}")));
        }
        Value::new(Content::Distribution("Mix".to_string(), arguments))
    }
}

fn replace_all(parts: &[Value], images: &mut dyn FnMut(&Atom) -> Option<Value>) -> Result<Vec<Value>, ValueError> {
    parts.iter().map(|part| part.replace(images)).collect()
}

/// The image of an atom; `None` when it stays what it is.
fn replace_atom(atom: &Atom, images: &mut dyn FnMut(&Atom) -> Option<Value>) -> Result<Option<Value>, ValueError> {
    if let Some(image) = images(atom) {
        return Ok(Some(image));
    }
    let old = atom.parts();
    let new = old.iter().map(|part| part.replace(images)).collect::<Result<Vec<_>, _>>()?;
    if old.iter().zip(&new).all(|(old, new)| *old == new) {
        return Ok(None);
    }
    let image = match (atom, new.as_slice()) {
        (Atom::Power(..), [base, exponent]) => base.power(exponent)?,
        (Atom::Maximum(_), _) => {
            let mut elements = new;
            elements.push(Value::zero());
            Value::maximum(&elements)?
        }
        (Atom::Positive(_), [part]) => Value::truth(super::Relation::Gtr, part, &Value::zero())?,
        (Atom::Floor(_), [part]) => part.floor()?,
        (Atom::Root(_), [part]) => part.sqrt()?,
        (Atom::Apply(function, _), arguments) => Value::apply(function, arguments)?,
        _ => return Ok(None),
    };
    Ok(Some(image))
}

/// A fraction over a length with values for its atoms: what is put in for the length may be short where its square, written
/// out, is long. None where it is no such fraction, the length stays, or becomes 0.
fn evaluate_over_length(
    (numerator, denominator): (&Real, &Real),
    images: &BTreeMap<&Atom, Option<Value>>,
) -> Result<Option<Value>, ValueError> {
    let Some(over) = over_length(numerator, denominator) else { return Ok(None) };
    let Some(Some(length)) = images.get(&over.root) else { return Ok(None) };
    let below = evaluate(&over.below, images)?;
    if length.is_zero() || below.is_zero() {
        return Ok(None);
    }
    let beside = evaluate(&over.beside, images)?.div(length)?;
    evaluate(&over.plain, images)?.add(&beside)?.div(&below).map(Some)
}

/// A polynomial with values for its atoms.
fn evaluate(polynomial: &Real, images: &BTreeMap<&Atom, Option<Value>>) -> Outcome {
    let mut kept = Vec::new();
    let mut sum: Option<Value> = None;
    // Numbers are summed by themselves: beside a long sum each would be looked for its place.
    let mut numbers: Option<BigRational> = None;
    for (monomial, number) in polynomial.terms() {
        let image = |(atom, _): &(Atom, _)| images.get(atom).and_then(Option::as_ref);
        let mut found = monomial.factors().iter().filter_map(image);
        if found.clone().any(Value::is_zero) && found.all(|image| image.sort() == Sort::Real) {
            numbers.get_or_insert_with(BigRational::zero);
            continue;
        }
        let mut stay = Vec::new();
        let mut product: Option<Value> = None;
        for (atom, exponent) in monomial.factors() {
            let Some(Some(image)) = images.get(atom) else {
                stay.push((atom.clone(), *exponent));
                continue;
            };
            let power = if *exponent == 1 { image.clone() } else { image.integer_power(&(*exponent).into())? };
            product = Some(match product {
                None => power,
                Some(product) => product.mul(&power)?,
            });
        }
        let Some(product) = product else {
            kept.push((monomial.clone(), number.clone()));
            continue;
        };
        if stay.is_empty()
            && let Some(factor) = product.as_rational()
        {
            let term = rational::product(&factor, number);
            numbers = Some(numbers.map_or_else(|| term.clone(), |so_far| rational::sum(&so_far, &term)));
            continue;
        }
        let rest = crate::polynomial::Monomial::of(stay).ok_or_else(ValueError::too_large)?;
        let rest = Polynomial::term(rest, number.clone());
        let term = if rest.is_one() { product } else { product.mul(&Value::whole(rest)?)? };
        sum = Some(match sum {
            None => term,
            Some(sum) => sum.add(&term)?,
        });
    }
    let sum = match (sum, numbers.map(Value::rational)) {
        (Some(sum), Some(number)) => Some(sum.add(&number)?),
        (sum, number) => sum.or(number),
    };
    match (kept.is_empty(), sum) {
        (true, Some(sum)) => Ok(sum),
        (_, None) => Value::whole(Polynomial::sorted(kept)),
        (false, Some(sum)) => sum.add(&Value::whole(Polynomial::sorted(kept))?),
    }
}
