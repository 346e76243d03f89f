//! Closed forms as text.

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Signed, ToPrimitive};

use super::readable::readable;
use super::{AsFar, Comparison, Form, Layer, Nested, Solved, layer, product};
use crate::exponential_polynomial::exponentials;
use crate::name::Name;
use crate::univariate::Univariate;
use crate::value::{Relation, Value, ValueError};

impl Solved {
    /// One line for each form of each sequence, and one for each condition.
    pub fn lines(&self) -> Vec<String> {
        self.lines_where(|_| true)
    }

    /// The same of these sequences alone.
    pub fn lines_of(&self, names: &[Name]) -> Vec<String> {
        self.lines_where(|name| names.contains(name))
    }

    fn lines_where(&self, shown: impl Fn(&Name) -> bool) -> Vec<String> {
        let recurrence = &self.recurrence;
        let mut lines = Vec::new();
        let all = recurrence.sequences.iter().zip(&self.forms);
        for (sequence, form) in all.filter(|(sequence, _)| shown(&sequence.name)) {
            lines.extend(form_lines(form, &sequence.name, &recurrence.index, recurrence.from));
            if let (Some(as_far), Some(last)) = (self.as_far(), lines.last_mut()) {
                end_with(last, (&sequence.name, &recurrence.index), &as_far.last);
            }
        }
        if let Some(AsFar { last, reason, .. }) = self.as_far() {
            lines.push(format!("after {} = {last} no form is known: {reason}", recurrence.index));
        }
        for line in self.conditions.iter().map(needed) {
            if !lines.contains(&line) {
                lines.push(line);
            }
        }
        lines
    }
}

/// The last line of a form that is known up to an index.
fn end_with(line: &mut String, (name, index): (&Name, &Name), last: &Value) {
    let (alone, open) = (format!(" for {last} <= {index}"), format!(" <= {index}"));
    *line = match line.strip_suffix(&alone) {
        Some(form) => match form.strip_prefix(&format!("{name}({index}) = ")) {
            Some(term) if last.as_rational().is_some() => format!("{name}({last}) = {term}"),
            _ => format!("{form} for {index} = {last}"),
        },
        None if line.ends_with(&open) => format!("{line} <= {last}"),
        None => format!("{line} for {index} <= {last}"),
    };
}

fn form_lines(form: &Form, name: &Name, index: &Name, from: i64) -> Vec<String> {
    let first = |early: &[Value]| {
        let terms = early.iter().enumerate();
        terms.map(|(place, value)| format!("{name}({}) = {value}", from + place as i64)).collect::<Vec<_>>()
    };
    let (mut lines, value) = match form {
        Form::Value(early, value) => {
            let since = Value::integer(from.saturating_add_unsigned(early.len() as u64));
            (first(early), Ok(readable(value, index, &since)))
        }
        Form::Sum(early, sum) => (first(early), sum.text(index)),
        Form::Product(ratio, value) => (Vec::new(), product_text(ratio, value, index, from)),
        Form::Nested(nested) => {
            let since = from.saturating_add_unsigned(nested.early.len() as u64);
            (first(&nested.early), nested_text(nested, index, since))
        }
        Form::Turns(forms) => return turns(forms, name, index, from),
        Form::Pieces(pieces) => {
            let line = |piece: &super::Piece| {
                // Indices are counted from 0 where nothing is said.
                let range = match (&piece.until, from == 0 && piece.from.is_zero()) {
                    (None, true) => String::new(),
                    (None, false) => format!(" for {} <= {index}", piece.from),
                    (Some(until), true) => format!(" for {index} < {until}"),
                    (Some(until), false) => format!(" for {} <= {index} < {until}", piece.from),
                };
                let alone = piece.from.add(&Value::one()).ok().filter(|_| piece.from.as_rational().is_some());
                match piece.form.with(index, &piece.from) {
                    Ok(term) if alone.is_some() && piece.until == alone => format!("{name}({}) = {term}", piece.from),
                    _ => format!("{name}({index}) = {}{range}", readable(&piece.form, index, &piece.from)),
                }
            };
            return pieces.iter().map(line).collect();
        }
    };
    let text = value.unwrap_or_else(|error| error.to_string());
    let range = if lines.is_empty() { String::new() } else { format!(" for {} <= {index}", from + lines.len() as i64) };
    lines.push(format!("{name}({index}) = {text}{range}"));
    lines
}

fn turns(forms: &[Form], name: &Name, index: &Name, from: i64) -> Vec<String> {
    let mut lines = Vec::new();
    for (turn, form) in forms.iter().enumerate() {
        let offset = from + turn as i64;
        let place = match offset {
            0 => format!("{}*{index}", forms.len()),
            _ if offset > 0 => format!("{}*{index}+{offset}", forms.len()),
            _ => format!("{}*{index}{offset}", forms.len()),
        };
        let (early, text) = match form {
            Form::Value(early, value) => (early.as_slice(), Ok(value.to_string())),
            Form::Sum(early, sum) => (early.as_slice(), sum.text(index)),
            Form::Product(ratio, value) => ([].as_slice(), product_text(ratio, value, index, 0)),
            Form::Nested(nested) => (nested.early.as_slice(), nested_text(nested, index, nested.early.len() as i64)),
            _ => continue,
        };
        let text = text.unwrap_or_else(|error| error.to_string());
        lines.extend(
            early
                .iter()
                .enumerate()
                .map(|(round, value)| format!("{name}({}) = {value}", offset + (round * forms.len()) as i64)),
        );
        let range = if early.is_empty() { String::new() } else { format!(" for {} <= {index}", early.len()) };
        lines.push(format!("{name}({place}) = {text}{range}"));
    }
    lines
}

/// A value in sums and products, which are written out.
fn nested_text(nested: &Nested, index: &Name, since: i64) -> Result<String, ValueError> {
    Written { nested, index, since }.written(&nested.value, &mut Vec::new())
}

/// What is written out: its layers, and from where on its index counts.
struct Written<'a> {
    nested: &'a Nested,
    index: &'a Name,
    since: i64,
}

impl Written<'_> {
    /// A value layer by layer, inside of sums that count by `outer`; sums and products are written apart from the rest.
    fn written(&self, value: &Value, outer: &mut Vec<Name>) -> Result<String, ValueError> {
        for (place, one) in self.nested.layers.iter().enumerate().rev() {
            let name = layer(place);
            if !value.mentions(&name) {
                continue;
            }
            let word = match one {
                Layer::Product(ratio) => match factorials(ratio, self.index, self.since) {
                    Some(whole) => {
                        let (value, whole) = &shortest(value, (&name, ratio), (self.index, self.since), whole)?;
                        if let Some((above, below)) = over_product(value, &name) {
                            let above = self.written(&above, outer)?;
                            let below = self.factors(&below, outer)?;
                            return Ok(format!("{}/({below}*{})", bracketed(above), bracketed(whole.to_string())));
                        }
                        return self.written(&value.with(&name, whole)?, outer);
                    }
                    None => "prod",
                },
                Layer::Sum(_) => "sum",
            };
            let image = self.big(word, one, outer)?;
            if let Some((factor, rest)) = value.linear_in(&name) {
                let product = if factor == Value::one() {
                    image
                } else if factor == Value::integer(-1) {
                    format!("-{image}")
                } else {
                    format!("{}*{image}", bracketed(self.written(&factor, outer)?))
                };
                if rest.is_zero() {
                    return Ok(product);
                }
                let rest = chosen(self.written(&rest, outer)?);
                return Ok(match product.strip_prefix('-') {
                    Some(product) => format!("{rest} - {product}"),
                    None => format!("{rest} + {product}"),
                });
            }
            let below = value.denominator().and_then(|below| below.linear_in(&name));
            if let (Some((factor, rest)), Some(above)) = (below, value.numerator())
                && rest.is_zero()
                && !above.mentions(&name)
            {
                let above = self.written(&above.div(&factor)?, outer)?;
                return Ok(format!("{}/{image}", bracketed(above)));
            }
            let value = value.with(&name, &Value::variable(&Name::new(&image)))?;
            return self.written(&value, outer);
        }
        Ok(value.to_string())
    }

    /// A product of a value without layers and of some of the layers.
    fn factors(&self, value: &Value, outer: &mut Vec<Name>) -> Result<String, ValueError> {
        let (mut rest, mut told) = (value.clone(), Vec::new());
        for name in (0..self.nested.layers.len()).map(layer) {
            while let Some((factor, _)) =
                rest.linear_in(&name).filter(|(factor, rest)| rest.is_zero() && !factor.is_zero())
            {
                told.push(bracketed(self.written(&Value::variable(&name), outer)?));
                rest = factor;
            }
        }
        if told.is_empty() || rest != Value::one() {
            told.insert(0, bracketed(self.written(&rest, outer)?));
        }
        Ok(told.join("*"))
    }

    /// `sum(k=0..n-1, …)`, where the name that counts is used for nothing else.
    fn big(&self, word: &str, one: &Layer, outer: &mut Vec<Name>) -> Result<String, ValueError> {
        let Written { nested, index, since } = *self;
        let used: Vec<Name> = nested.layers.iter().flat_map(|one| one.inner().variables()).collect();
        let count = counter(|name| name == index || used.contains(name) || outer.contains(name));
        outer.push(index.clone());
        let image = Value::variable(&count);
        let moved = nested.with_index(index, &image)?;
        let inside = Written { nested: &moved, index: &count, since };
        let text = inside.written(&one.inner().with(index, &image)?, outer)?;
        outer.pop();
        Ok(format!("{word}({count}={since}..{index}-1, {text})"))
    }
}

/// The value `a/(b*p)` as a and b, where b is a sum: written out, p would stand in each of its summands.
fn over_product(value: &Value, product: &Name) -> Option<(Value, Value)> {
    let (above, (below, rest)) = (value.numerator()?, value.denominator()?.linear_in(product)?);
    let sum = below.polynomials().is_some_and(|(above, _)| above.terms().len() > 1);
    (rest.is_zero() && sum && !above.mentions(product)).then_some((above, below))
}

/// What must hold for a result to be right, as a line.
pub(crate) fn needed(comparison: &Comparison) -> String {
    let zero = comparison.2.is_zero();
    format!("if {}", if zero { compared(comparison) } else { as_it_stands(comparison) })
}

/// A comparison with its sides as they are.
pub(crate) fn as_it_stands((relation, left, right): &Comparison) -> String {
    let [left, right] = [left, right].map(|side| chosen(side.to_string()));
    format!("{left} {} {right}", relation.symbol())
}

/// A comparison of parameters, each term on the side where it is added.
pub(crate) fn compared(comparison: &Comparison) -> String {
    let (relation, left, right) = comparison;
    // A choice would take in what stands behind it.
    let choice = [left, right].iter().any(|side| side.to_string().contains("if "));
    let Some(difference) = left.sub(right).ok().filter(|_| !choice) else { return as_it_stands(comparison) };
    // `2/(1-v) > 0` is `1-v > 0`, and never 0.
    let parts = (difference.numerator(), difference.denominator());
    if let (Some(above), Some(below)) = parts
        && !matches!(relation, Relation::Eq | Relation::Neq)
        && let Some(above) = above.as_rational()
        && !below.variables().is_empty()
    {
        let relation = match relation {
            Relation::Gte => Relation::Gtr,
            Relation::Lte => Relation::Lss,
            other => *other,
        };
        let relation = if above.is_negative() { relation.mirrored() } else { relation };
        return below.compared(relation.symbol());
    }
    difference.compared(relation.symbol())
}

/// In brackets where it is a choice, to which all that follows would belong.
fn chosen(text: String) -> String {
    if text.starts_with("if ") { format!("({text})") } else { text }
}

/// In brackets where it is a sum, a negative or a choice.
pub(crate) fn bracketed(text: String) -> String {
    if text.starts_with("if ") {
        return chosen(text);
    }
    let mut depth = 0;
    let sum = text.chars().any(|character| {
        depth += match character {
            '(' => 1,
            ')' => -1,
            _ => 0,
        };
        depth == 0 && matches!(character, '+' | '-')
    });
    if sum { format!("({text})") } else { text }
}

/// A name that counts, and is not taken.
fn counter(taken: impl Fn(&Name) -> bool) -> Name {
    let names = ["k", "j", "i", "l", "m", "h"].into_iter().map(str::to_string);
    let mut names = names.chain((1..).map(|number| format!("k{number}"))).map(|name| Name::new(&name));
    names.find(|name| !taken(name)).unwrap_or_else(|| Name::new("k"))
}

/// How many places before or behind a product one is looked for over which a value is shorter.
const MOST_PLACES: i64 = 6;

/// A value over a product of factorials, and these: `(n+1)!` for `(n+1)*n!`, if the value is shorter over those.
fn shortest(
    value: &Value,
    (name, ratio): (&Name, &Value),
    (index, from): (&Name, i64),
    whole: Value,
) -> Result<(Value, Value), ValueError> {
    let (count, product) = (Value::variable(index), Value::variable(name));
    let later = |places: i64| {
        let moved = ratio.with(index, &count.add(&Value::integer(places)).ok()?).ok()?;
        let whole = factorials(&moved, index, from)?;
        // The product so many places on has these factors more, and those that it does not begin with.
        let (mut now, mut first) = (Value::one(), Value::one());
        for place in places.min(0)..places.max(0) {
            let factor = |here: &Value| ratio.with(index, &here.add(&Value::integer(place)).ok()?).ok();
            now = now.mul(&factor(&count)?).ok()?;
            first = first.mul(&factor(&Value::integer(from))?).ok()?;
        }
        // So many places back it lacks the one, and begins with the other.
        let (product, whole) = match places < 0 {
            true => (product.mul(&now).ok()?, whole.div(&first).ok()?),
            false => (product.div(&now).ok()?, whole.mul(&first).ok()?),
        };
        Some((value.with(name, &product).ok()?, whole))
    };
    let length = |value: &Value| value.to_string().chars().count();
    let mut best = (value.clone(), whole);
    for found in (1..=MOST_PLACES).flat_map(|places| [places, -places]).filter_map(later) {
        if length(&found.0) < length(&best.0) {
            best = found;
        }
    }
    Ok(best)
}

/// The product in factorials where its factors are `n + a` with whole numbers a.
fn product_text(ratio: &Value, value: &Value, index: &Name, from: i64) -> Result<String, ValueError> {
    let whole = match factorials(ratio, index, from) {
        Some(whole) => whole,
        None => {
            let count = counter(|name| name == index || ratio.mentions(name) || value.mentions(name));
            let under = format!("prod({count}={from}..{index}-1, ");
            Value::variable(&Name::new(&format!("{under}{})", ratio.with(index, &Value::variable(&count))?)))
        }
    };
    Ok(value.with(&product(), &whole)?.to_string())
}

/// `ratio(from) * … * ratio(n-1)` in factorials and powers.
fn factorials(ratio: &Value, index: &Name, from: i64) -> Option<Value> {
    let count = Value::variable(index).sub(&Value::integer(from)).ok()?;
    let mut whole = Value::one();
    for (part, below) in [(ratio.numerator()?, false), (ratio.denominator()?, true)] {
        // A power c^n in the ratio is c^(0 + 1 + … ) in the product.
        let parts: Vec<_> = exponentials(&part, index)?.into_iter().collect();
        let [(base, coefficients)] = parts.as_slice() else { return None };
        let base = base.as_rational()?;
        let coefficients: Vec<BigRational> = coefficients.iter().map(Value::as_rational).collect::<Option<_>>()?;
        let polynomial = Univariate::new(coefficients);
        if polynomial.degree() > 40 {
            return None;
        }
        let lead = Value::rational(polynomial.coefficient(polynomial.degree()));
        let mut factor = lead.power(&count).ok()?;
        if !base.is_one() {
            let n = Value::variable(index);
            let twice = n.mul(&n).ok()?.sub(&n).ok()?.sub(&Value::integer(from * (from - 1))).ok()?;
            let sum = twice.mul(&Value::fraction(1, 2).ok()?).ok()?;
            factor = factor.mul(&Value::rational(base).power(&sum).ok()?).ok()?;
        }
        for (linear, times) in polynomial.factors() {
            let shift = (linear.degree() == 1).then(|| linear.coefficient(0))?;
            let first = &shift + BigRational::from_integer(BigInt::from(from));
            if !first.is_integer() || !first.is_positive() || first.to_i64()? > 20 {
                return None;
            }
            let top = Value::variable(index).add(&Value::rational(shift - BigRational::one())).ok()?;
            let bottom = (1..first.to_i64()?).product::<i64>();
            let name = if top.as_variable().is_some() { format!("{top}!") } else { format!("({top})!") };
            let quotient = Value::variable(&Name::new(&name)).div(&Value::integer(bottom)).ok()?;
            factor = factor.mul(&quotient.power(&Value::integer(i64::try_from(times).ok()?)).ok()?).ok()?;
        }
        whole = if below { whole.div(&factor).ok()? } else { whole.mul(&factor).ok()? };
    }
    Some(whole)
}
