//! Linear recurrences whose coefficients depend on the index, by factors of first order: where a hypergeometric solution
//! is found, what is left has one order less, and the solution is a product times a sum over that. A sum that telescopes is
//! written as what it is; one that does not (R. W. Gosper decides which) stays a sum, as the harmonic numbers do.

use num_rational::BigRational;
use num_traits::{One, ToPrimitive};

use super::Unknown;
use super::hypergeometric::ratio;
use super::multiplied::{Multiplied, raised};
use super::product::{quotient, value_of};
use super::rational::solution;
use crate::closed_form::{Form, Layer, Nested, Recurrence, layer};
use crate::exponential_polynomial::exponentials;
use crate::name::Name;
use crate::univariate::Univariate;
use crate::value::{Value, ValueError};

/// The highest order.
const MOST_ORDER: usize = 6;
/// The latest index at which a coefficient may be 0 or not defined.
const MOST_EARLY: i64 = 60;

/// The form of one sequence that begins at 0; nothing if it is not linear, or has no factor of first order.
///
/// # Errors
/// When a value becomes too large.
pub(super) fn nested(recurrence: &Recurrence) -> Result<Option<Form>, Unknown> {
    over(recurrence, Vec::new())
}

/// The same of one whose equation speaks of layers that are there already, and begin at 0.
fn over(recurrence: &Recurrence, layers: Vec<Layer>) -> Result<Option<Form>, Unknown> {
    let [sequence] = recurrence.sequences.as_slice() else { return Ok(None) };
    let Some((coefficients, input)) = linear(recurrence) else { return Ok(None) };
    let index = &recurrence.index;
    let varies = |one: &Value| (0..layers.len()).any(|place| one.mentions(&layer(place)));
    if coefficients.len() > MOST_ORDER || (coefficients.len() > 1 && coefficients.iter().any(varies)) {
        return Ok(None);
    }
    // Terms that are not read delay a recurrence of lower order.
    let delay = coefficients.iter().take_while(|one| one.is_zero()).count();
    if delay == coefficients.len() && layers.is_empty() {
        return Ok(None);
    }
    let Some(ratios) = factors(&coefficients[delay..], index)? else { return Ok(None) };
    // u(n+d) = c(n)*u(n+j) + … is u(n+d-j) = c(n-j)*u(n) + …
    let delayed = i64::try_from(delay).unwrap_or(MOST_EARLY);
    let back = Value::variable(index).sub(&Value::integer(delayed))?;
    let ratios = ratios.iter().map(|one| one.with(index, &back)).collect::<Result<Vec<_>, _>>()?;
    let Some(since) = since(&ratios, index).map(|since| since.max(delayed)) else { return Ok(None) };
    let start = usize::try_from(since).unwrap_or(0);
    let whole = Nested { early: Vec::new(), layers, value: sequence.next.clone() };
    let terms = terms(recurrence, &whole, start + coefficients.len())?;
    let input = Nested { value: input, ..whole }.delayed(index, delay)?.beginning(index, 0, since)?;
    let mut work = Work { index, since, layers: input.layers };
    let value = match ratios.is_empty() {
        true => input.value,
        false => work.solve(&ratios, &input.value, &terms[start..])?,
    };
    let early = terms[..start].to_vec();
    let plain = !(0..work.layers.len()).any(|place| value.mentions(&layer(place)));
    Ok(Some(if plain { Form::Value(early, value) } else { Form::Nested(Nested { early, layers: work.layers, value }) }))
}

/// The first terms of one sequence, whose next one, over layers that begin at 0, is the value of these.
fn terms(recurrence: &Recurrence, next: &Nested, count: usize) -> Result<Vec<Value>, Unknown> {
    let [sequence] = recurrence.sequences.as_slice() else { return Ok(Vec::new()) };
    if next.layers.is_empty() {
        return Ok(recurrence.iterate(count)?.swap_remove(0));
    }
    let mut terms = sequence.start.clone();
    for at in 0..count.saturating_sub(terms.len()) {
        let mut value = next.at(&recurrence.index, 0, i64::try_from(at).unwrap_or(MOST_EARLY))?;
        for offset in 0..sequence.start.len() {
            value = value.with(&recurrence.term(&sequence.name, offset), &terms[at + offset])?;
        }
        terms.push(value);
    }
    Ok(terms)
}

/// The sums and products of sequences that are solved, for those that read them.
pub(super) struct Layers(Nested);

impl Layers {
    /// None yet.
    pub(super) fn none() -> Layers {
        Layers(Nested { early: Vec::new(), layers: Vec::new(), value: Value::zero() })
    }

    /// The form of a sequence whose equation speaks of these; none where it speaks of none of them.
    ///
    /// # Errors
    /// When none is found, or a value becomes too large.
    pub(super) fn above(&self, single: &Recurrence) -> Result<Option<Form>, Unknown> {
        if !self.are_read(single) {
            return Ok(None);
        }
        over(single, self.0.layers.clone())?.map(Some).ok_or_else(|| Layers::no_form(single))
    }

    /// Whether an equation speaks of these.
    pub(super) fn are_read(&self, recurrence: &Recurrence) -> bool {
        let reads = |place: usize| recurrence.sequences.iter().any(|sequence| sequence.next.mentions(&layer(place)));
        (0..self.0.layers.len()).any(reads)
    }

    /// Why sequences that read these have no form.
    pub(super) fn no_form(recurrence: &Recurrence) -> Unknown {
        let names: Vec<&str> = recurrence.sequences.iter().map(|sequence| sequence.name.as_str()).collect();
        let reads = if names.len() == 1 { "reads" } else { "read" };
        Unknown::because(format!("{} {reads} a sum or product, and no form over that is known", names.join(", ")))
    }

    /// The term of a form so many places on, over these, which its own sums and products join; none of one that is no
    /// value over such, or begins later.
    ///
    /// # Errors
    /// When a value becomes too large.
    pub(super) fn value(&mut self, form: &Form, index: &Name, offset: usize) -> Result<Option<Value>, ValueError> {
        let Some(mut value) = self.0.holding(form, index, (0, 0))? else { return Ok(None) };
        for _ in 0..offset {
            value = self.0.next(&value, index)?;
        }
        Ok(Some(value))
    }
}

/// The coefficients of the terms, from that of the first on, and what is left.
fn linear(recurrence: &Recurrence) -> Option<(Vec<Value>, Value)> {
    let mut rest = recurrence.sequences.first()?.next.clone();
    let mut coefficients = Vec::new();
    let terms = recurrence.terms();
    for (name, ..) in &terms {
        let (factor, constant) = rest.linear_in(name)?;
        if terms.iter().any(|(other, ..)| factor.mentions(other)) {
            return None;
        }
        coefficients.push(factor);
        rest = constant;
    }
    Some((coefficients, rest))
}

/// Ratios r with `(S - r_1) … (S - r_d)`, the last one applied first, for the operator of a recurrence, S the step.
fn factors(coefficients: &[Value], index: &Name) -> Result<Option<Vec<Value>>, Unknown> {
    let mut rest = coefficients.to_vec();
    let mut ratios = Vec::new();
    while rest.len() > 1 {
        let Some(operator) = operator(&rest, index)? else { return Ok(None) };
        let Some([above, below]) = ratio(&operator) else { return Ok(None) };
        let n = Value::variable(index);
        let found = value_of(&above, &n)?.div(&value_of(&below, &n)?)?;
        // With p(i+1) = q(i) - q(i+1)*r(n+i+1), q is what is left.
        let order = rest.len();
        let mut quotients = vec![Value::one()];
        for place in (0..order - 1).rev() {
            let later = found.with(index, &n.add(&Value::integer(i64::try_from(place + 1).unwrap_or(0)))?)?;
            let next = quotients[quotients.len() - 1].mul(&later)?.sub(&rest[place + 1])?;
            quotients.push(next);
        }
        rest = quotients[1..].iter().rev().map(Value::neg).collect::<Result<_, _>>()?;
        ratios.push(found);
    }
    ratios.extend(rest);
    Ok(Some(ratios))
}

/// `p_0, …, p_d`, polynomials without common denominator; nothing if they are none.
fn operator(coefficients: &[Value], index: &Name) -> Result<Option<Vec<Univariate>>, Unknown> {
    let mut parts = Vec::new();
    for one in coefficients {
        let zero = one.is_zero().then(|| [Univariate::zero(), Univariate::one()]);
        let Some(part) = zero.or_else(|| quotient(one, index)) else { return Ok(None) };
        parts.push(part);
    }
    let mut below = Univariate::one();
    for [_, own] in &parts {
        let common = below.common_divisor(own);
        below = below.times(&own.divide(&common).map_or_else(Univariate::one, |(rest, _)| rest));
    }
    let mut all = Vec::new();
    for [above, own] in &parts {
        let Some((factor, _)) = below.divide(own) else { return Ok(None) };
        all.push(above.times(&factor).scale(&-BigRational::one()));
    }
    all.push(below);
    Ok(Some(all))
}

/// The index after the last one at which a ratio with rational roots is 0 or not defined.
fn since(ratios: &[Value], index: &Name) -> Option<i64> {
    let mut since = 0;
    for ratio in ratios.iter().filter(|ratio| ratio.mentions(index)) {
        for part in [ratio.numerator()?, ratio.denominator()?] {
            // Of others it is for the induction to show that they are never 0.
            let Some(part) = without_powers(&part, index) else { continue };
            for (factor, _) in part.factors() {
                let root = -factor.coefficient(0);
                if factor.degree() == 1 && root.is_integer() {
                    since = since.max(root.to_integer().to_i64()?.checked_add(1)?);
                }
            }
        }
    }
    (since <= MOST_EARLY).then_some(since)
}

/// The polynomial p of `c*p(n)*b^n`, with leading coefficient 1.
fn without_powers(value: &Value, index: &Name) -> Option<Univariate> {
    let parts: Vec<_> = exponentials(value, index)?.into_iter().collect();
    let [(_, coefficients)] = parts.as_slice() else { return None };
    let lead = coefficients.iter().rev().find(|one| !one.is_zero())?;
    let all = coefficients.iter().map(|one| one.div(lead).ok()?.as_rational()).collect::<Option<Vec<_>>>()?;
    Some(Univariate::new(all))
}

/// A symbolic c and the quotient of polynomials whose multiple a ratio is.
fn scaled(ratio: &Value, index: &Name) -> Option<(Value, [Univariate; 2])> {
    if let Some(own) = quotient(ratio, index) {
        return Some((Value::one(), own));
    }
    let lead = |part: Value| {
        let parts: Vec<_> = exponentials(&part, index)?.into_iter().collect();
        let [(_, coefficients)] = parts.as_slice() else { return None };
        coefficients.iter().rev().find(|one| !one.is_zero()).cloned()
    };
    let scale = lead(ratio.numerator()?)?.div(&lead(ratio.denominator()?)?).ok()?;
    let own = quotient(&ratio.div(&scale).ok()?, index)?;
    Some((scale, own))
}

/// A form in the making.
struct Work<'a> {
    index: &'a Name,
    since: i64,
    layers: Vec<Layer>,
}

/// `coefficient * (numerator/denominator)(n) * base^n * layers`, where the ratio of the layers is another quotient.
struct Part {
    coefficient: Value,
    numerator: Univariate,
    denominator: Univariate,
    base: Value,
    layers: Value,
    ratio: [Univariate; 2],
}

impl Work<'_> {
    /// The sequence that these factors and this input give, from its terms at `since` on.
    fn solve(&mut self, ratios: &[Value], input: &Value, terms: &[Value]) -> Result<Value, Unknown> {
        let (Some((ratio, rest)), Some(start)) = (ratios.split_first(), terms.first()) else {
            return Ok(Value::zero());
        };
        if rest.is_empty() {
            return self.first_order(ratio, input, start);
        }
        // v(n) = u(n+1) - r(n)*u(n) has one order less.
        let mut inner = Vec::new();
        for (at, pair) in (self.since..).zip(terms.windows(2)).take(rest.len()) {
            let here = ratio.with(self.index, &Value::integer(at))?;
            inner.push(pair[1].sub(&here.mul(&pair[0])?)?);
        }
        let input = self.solve(rest, input, &inner)?;
        self.first_order(ratio, &input, start)
    }

    /// `u(n+1) = ratio*u(n) + input`, where the ratio is never 0.
    fn first_order(&mut self, ratio: &Value, input: &Value, start: &Value) -> Result<Value, Unknown> {
        let (mut particular, mut left) = (Value::zero(), Value::zero());
        let own = quotient(ratio, self.index);
        for part in self.parts(input)? {
            let closed = match (&own, &part) {
                (Some(own), Ok(part)) => self.telescoped(own, part, Some(self.since))?,
                (Some(own), Err(value)) => self.telescoped_from_elsewhere(own, value)?,
                _ => None,
            };
            match (closed, part) {
                (Some(closed), _) => particular = particular.add(&closed)?,
                (None, Ok(part)) => left = left.add(&self.part_value(&part)?)?,
                (None, Err(value)) => left = left.add(&value)?,
            }
        }
        let rest = start.sub(&self.initial(&particular)?)?;
        if rest.is_zero() && left.is_zero() {
            return Ok(particular);
        }
        let product = self.product(ratio)?;
        let mut sum = rest.div(&self.initial(&product)?)?;
        if !left.is_zero() {
            let summand = left.div(&product.mul(ratio)?)?;
            self.layers.push(Layer::Sum(summand));
            sum = sum.add(&Value::variable(&layer(self.layers.len() - 1)))?;
        }
        Ok(particular.add(&product.mul(&sum)?)?)
    }

    /// The value at `since`.
    fn initial(&self, value: &Value) -> Result<Value, ValueError> {
        let mut value = value.with(self.index, &Value::integer(self.since))?;
        for (place, one) in self.layers.iter().enumerate() {
            value = value.with(&layer(place), &one.first())?;
        }
        Ok(value)
    }

    /// A multiple of the product of a ratio: factors that meet again further on leave a quotient of polynomials, and what is
    /// left may be a power of a product that is there already.
    fn product(&mut self, ratio: &Value) -> Result<Value, Unknown> {
        let count = Value::variable(self.index);
        let plain = !(0..self.layers.len()).any(|place| ratio.mentions(&layer(place)));
        if plain && !ratio.mentions(self.index) {
            return Ok(ratio.power(&count)?);
        }
        let Some((scale, ratio)) = scaled(ratio, self.index).filter(|_| plain) else {
            return Ok(self.layered(ratio.clone()));
        };
        let met = Multiplied::of(&ratio, &count)?;
        let scale = scale.power(&count)?;
        if met.ratio.iter().all(|rest| rest.degree() == 0) {
            return Ok(scale.mul(&met.base.power(&count)?)?.mul(&met.value)?);
        }
        for (place, one) in self.layers.iter().enumerate() {
            let Layer::Product(inner) = one else { continue };
            let Some(own) = quotient(inner, self.index) else { continue };
            for power in [1, -1, 2, -2] {
                let [above, below] = raised(&own, -power);
                let met = Multiplied::of(&[ratio[0].times(&above), ratio[1].times(&below)], &count)?;
                if met.ratio.iter().all(|rest| rest.degree() == 0) {
                    let known = Value::variable(&layer(place)).power(&Value::integer(power))?;
                    return Ok(scale.mul(&met.base.power(&count)?)?.mul(&met.value)?.mul(&known)?);
                }
            }
        }
        let rest = value_of(&met.ratio[0], &count)?.div(&value_of(&met.ratio[1], &count)?)?;
        let known = self.layered(rest);
        Ok(scale.mul(&met.base.power(&count)?)?.mul(&met.value)?.mul(&known)?)
    }

    /// The product of a ratio as a layer; the same one for the same ratio.
    fn layered(&mut self, ratio: Value) -> Value {
        Value::variable(&layer(Layer::Product(ratio).among(&mut self.layers)))
    }

    /// A value in the index and layers, part by part; a part that is not hypergeometric is left as a value.
    fn parts(&self, value: &Value) -> Result<Vec<Result<Part, Value>>, Unknown> {
        // First by sums, then by products: each part has one monomial in the layers.
        let mut pieces = vec![(value.clone(), Value::one(), [Univariate::one(), Univariate::one()], true)];
        for (place, one) in self.layers.iter().enumerate().rev() {
            let name = layer(place);
            let own = match one {
                Layer::Product(inner) => quotient(inner, self.index),
                Layer::Sum(_) => None,
            };
            let mut next = Vec::new();
            for (rest, layers, ratio, simple) in pieces {
                let Some(powers) = powers(&rest, &name) else {
                    next.push((rest, layers, ratio, false));
                    continue;
                };
                for (power, factor) in powers {
                    let grown = layers.mul(&Value::variable(&name).power(&Value::integer(power))?)?;
                    let [above, below] = own.as_ref().map_or_else(|| raised(&ratio, 0), |own| raised(own, power));
                    let simple = simple && (power == 0 || own.is_some());
                    next.push((factor, grown, [ratio[0].times(&above), ratio[1].times(&below)], simple));
                }
            }
            pieces = next;
        }
        let mut all = Vec::new();
        for (rest, layers, ratio, simple) in pieces {
            match self.split(&rest, &layers, &ratio).filter(|_| simple) {
                Some(parts) => all.extend(parts.into_iter().map(Ok)),
                None => all.push(Err(rest.mul(&layers)?)),
            }
        }
        Ok(all)
    }

    /// A value in the index, by powers, and by its coefficients where these are symbolic.
    fn split(&self, value: &Value, layers: &Value, ratio: &[Univariate; 2]) -> Option<Vec<Part>> {
        let (top, bottom) = (value.numerator()?, value.denominator()?);
        let bottoms: Vec<_> = exponentials(&bottom, self.index)?.into_iter().collect();
        let [(under, coefficients)] = bottoms.as_slice() else { return None };
        let scale = coefficients.iter().rev().find(|one| !one.is_zero())?.clone();
        let rational = |all: &[Value], scale: &Value| {
            let all = all.iter().map(|one| one.div(scale).ok()?.as_rational()).collect::<Option<Vec<_>>>()?;
            Some(Univariate::new(all))
        };
        let denominator = rational(coefficients, &scale)?;
        let mut parts = Vec::new();
        for (base, coefficients) in exponentials(&top, self.index)? {
            let base = base.div(under).ok()?;
            let part = |coefficient: &Value, numerator: Univariate| {
                Some(Part {
                    coefficient: coefficient.div(&scale).ok()?,
                    numerator,
                    denominator: denominator.clone(),
                    base: base.clone(),
                    layers: layers.clone(),
                    ratio: ratio.clone(),
                })
            };
            let lead = coefficients.iter().rev().find(|one| !one.is_zero())?;
            if let Some(numerator) = rational(&coefficients, lead) {
                parts.push(part(lead, numerator)?);
                continue;
            }
            for (power, coefficient) in coefficients.iter().enumerate().filter(|(_, one)| !one.is_zero()) {
                let mut monomial = Univariate::one();
                for _ in 0..power {
                    monomial =
                        monomial.times(&Univariate::new(vec![BigRational::from_integer(0.into()), BigRational::one()]));
                }
                parts.push(part(coefficient, monomial)?);
            }
        }
        Some(parts)
    }

    fn part_value(&self, part: &Part) -> Result<Value, Unknown> {
        let count = Value::variable(self.index);
        let quotient = value_of(&part.numerator, &count)?.div(&value_of(&part.denominator, &count)?)?;
        Ok(part.coefficient.mul(&quotient)?.mul(&part.base.power(&count)?)?.mul(&part.layers)?)
    }

    /// A rational multiple of the part that solves the equation with it for input.
    fn telescoped(&self, own: &[Univariate; 2], part: &Part, since: Option<i64>) -> Result<Option<Value>, Unknown> {
        let Some(base) = part.base.as_rational() else { return Ok(None) };
        // y = R*base^n*layers: base*ratio(n)*R(n+1) - own(n)*R(n) = numerator/denominator.
        let a = part.ratio[0].times(&own[1]).times(&part.denominator).scale(&base);
        let b = own[0].times(&part.ratio[1]).times(&part.denominator);
        let c = part.numerator.times(&own[1]).times(&part.ratio[1]);
        let Some([above, below]) = solution(&a, &b, &c) else { return Ok(None) };
        // What is not defined from `since` on is no solution there.
        let bad = |(factor, _): &(Univariate, usize)| {
            let root = -factor.coefficient(0);
            let late = since.is_some_and(|since| root >= BigRational::from_integer(since.into()));
            factor.degree() == 1 && root.is_integer() && late
        };
        if below.factors().iter().any(bad) {
            return Ok(None);
        }
        let count = Value::variable(self.index);
        let quotient = value_of(&above, &count)?.div(&value_of(&below, &count)?)?;
        Ok(Some(part.coefficient.mul(&quotient)?.mul(&part.base.power(&count)?)?.mul(&part.layers)?))
    }
}

impl Work<'_> {
    /// The same for a sum of what depends on `n + r` alone, with a symbol r: it is one of numbers, from another index on. Where
    /// it is defined is asked where the form is checked.
    fn telescoped_from_elsewhere(&mut self, own: &[Univariate; 2], value: &Value) -> Result<Option<Value>, Unknown> {
        let count = Value::variable(self.index);
        if own.iter().any(|one| *one != Univariate::one()) {
            return Ok(None);
        }
        for symbol in value.variables().into_iter().filter(|name| name != self.index) {
            let away = Value::variable(&symbol);
            let moved = value.with(self.index, &count.sub(&away)?)?;
            let plain =
                !moved.mentions(&symbol) && self.layers.iter().enumerate().all(|(at, _)| !moved.mentions(&layer(at)));
            let parts = if plain { self.parts(&moved)? } else { Vec::new() };
            if let [Ok(part)] = parts.as_slice()
                && let Some(closed) = self.telescoped(own, part, None)?
            {
                return Ok(Some(closed.with(self.index, &count.add(&away)?)?));
            }
        }
        Ok(None)
    }
}

/// The powers of a name in a value, with their factors; none where it is no sum of such.
fn powers(value: &Value, name: &Name) -> Option<Vec<(i64, Value)>> {
    let alone = |value: &Value| {
        let all = exponentials(value, name)?;
        match all.into_iter().collect::<Vec<_>>().as_slice() {
            [(base, coefficients)] if *base == Value::one() => Some(coefficients.clone()),
            [] => Some(Vec::new()),
            _ => None,
        }
    };
    let below = alone(&value.denominator()?)?;
    let place = below.iter().position(|one| !one.is_zero())?;
    if below.iter().skip(place + 1).any(|one| !one.is_zero()) {
        return None;
    }
    let mut all = Vec::new();
    for (power, factor) in alone(&value.numerator()?)?.iter().enumerate().filter(|(_, one)| !one.is_zero()) {
        let power = i64::try_from(power).ok()?.checked_sub(i64::try_from(place).ok()?)?;
        all.push((power, factor.div(&below[place]).ok()?));
    }
    Some(all)
}
