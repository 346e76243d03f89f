//! Recurrences: equations between terms of sequences, and their first values.

use std::collections::BTreeMap;

use num_traits::ToPrimitive;

use super::scope::Lowerer;
use super::value::{DISTRIBUTIONS, FUNCTIONS};
use crate::ast::{self, Argument, Comparison, Ident, Value as Written, ValueKind};
use crate::closed_form::{Recurrence, Sequence, term};
use crate::diagnostic::{Diagnostic, Span};
use crate::name::Name;
use crate::value::{Relation, Value};

/// The most first values of one sequence.
const MOST_ORDER: usize = 60;

/// The most equations, first values among them.
const MOST_EQUATIONS: usize = 400;

/// `solve … find …`
#[derive(Clone, Debug)]
pub struct Question {
    /// What is to be solved.
    pub recurrence: Recurrence,
    /// A comparison of expressions in the terms [`Recurrence::term`] of offset 0, whose first index is looked for.
    pub find: Option<(Relation, Value, Value)>,
}

/// The equations, sorted.
#[derive(Default)]
struct Equations<'a> {
    index: Option<Ident>,
    /// For each name the offset on the left, and the right side.
    steps: Vec<(Ident, i64, &'a Written)>,
    /// For each name its first values by index.
    starts: BTreeMap<Name, BTreeMap<i64, &'a Written>>,
}

/// The largest index of a term, and the largest step ahead.
const MOST_INDEX: i64 = 1_000;

impl Lowerer<'_> {
    pub(super) fn solve(&mut self, solve: &ast::Solve) -> Option<Question> {
        let names: Vec<Name> = solve.equations.iter().filter_map(|(left, _)| called(left)).collect();
        let mut equations = Equations::default();
        if let Some((left, _)) = solve.equations.get(MOST_EQUATIONS) {
            return self.wrong(left.span, format!("there are more than {MOST_EQUATIONS} equations"));
        }
        for (left, right) in &solve.equations {
            self.equation(left, right, &mut equations)?;
        }
        let Some(index) = equations.index.clone() else {
            return self.without_step(solve);
        };
        self.locals.insert(index.name.clone(), index.span);
        let from = self.first_index(&equations)?;
        let mut sequences = Vec::new();
        for (name, offset, right) in &equations.steps {
            let values = equations.starts.get(&name.name);
            let start: Option<Vec<Value>> =
                values.into_iter().flat_map(BTreeMap::values).map(|one| self.number(one)).collect();
            let start = start?;
            if start.len() > MOST_ORDER {
                return self.wrong(name.span, format!("`{}` has more than {MOST_ORDER} first values", name.name));
            }
            if start.iter().any(|value| value.mentions(&index.name)) {
                let text =
                    format!("a first value of `{}` depends on `{}`, which counts the terms", name.name, index.name);
                return self.wrong(name.span, text);
            }
            let shift = i64::try_from(start.len()).ok()? - offset;
            let next = self.right_side(right, &names, &index.name, shift)?;
            sequences.push(Sequence { name: name.name.clone(), start, next });
        }
        let mut recurrence = Recurrence { index: index.name.clone(), from, sequences };
        self.known_terms(&mut recurrence, &equations)?;
        let find = match &solve.find {
            Some(find) => Some(self.find(find, &names, &recurrence)?),
            None => None,
        };
        Some(Question { recurrence, find })
    }

    fn wrong<T>(&mut self, span: Span, text: impl Into<String>) -> Option<T> {
        self.fail(
            Diagnostic::error("P0325", text)
                .label(span, "here")
                .help("write the next term and the first values: `solve r(n+1) = 2*r(n) + 3, r(0) = 1`"),
        )
    }

    fn without_step<T>(&mut self, solve: &ast::Solve) -> Option<T> {
        let span = solve.equations.first().map_or(Span::new(0, 0), |(left, _)| left.span);
        self.wrong(span, "no equation says what the next term is")
    }

    /// Sorts one equation: a step, or a first value.
    fn equation<'a>(&mut self, left: &Written, right: &'a Written, found: &mut Equations<'a>) -> Option<()> {
        let call = match &left.kind {
            ValueKind::Name(name) => subscripted(name).map(|(call, _)| call),
            _ => None,
        };
        let ValueKind::Call(name, arguments) = &call.as_ref().unwrap_or(left).kind else {
            return self.wrong(left.span, "the left side of an equation is a term such as `r(n+1)` or `r(0)`");
        };
        let [Argument { label: None, value: place }] = arguments.as_slice() else {
            return self.wrong(left.span, "a term of a sequence has one index");
        };
        let (variable, offset) = self.place(place)?;
        match variable {
            None => {
                if found.starts.entry(name.name.clone()).or_default().insert(offset, right).is_some() {
                    return self.wrong(left.span, format!("`{}({offset})` is given twice", name.name));
                }
            }
            Some(variable) => {
                if let Some(index) = &found.index
                    && index.name != variable.name
                {
                    let text = format!("the index is `{}` here and `{}` before", variable.name, index.name);
                    return self.wrong(variable.span, text);
                }
                if found.steps.iter().any(|(other, ..)| other.name == name.name) {
                    return self.wrong(left.span, format!("two equations say what the next `{}` is", name.name));
                }
                found.index = Some(variable);
                found.steps.push((name.clone(), offset, right));
            }
        }
        Some(())
    }

    /// An index as a variable and an offset.
    fn place(&mut self, written: &Written) -> Option<(Option<Ident>, i64)> {
        let failed = |lowerer: &mut Self| {
            lowerer.wrong(written.span, "an index is a whole number, or a name and a whole number: `n`, `n+1`, `n-2`")
        };
        let mut variable = None;
        let mut offset = 0i64;
        let mut parts = vec![(false, written)];
        while let Some((negative, part)) = parts.pop() {
            match &part.kind {
                ValueKind::Sum(inner) => parts.extend(inner.iter().map(|(minus, part)| (negative ^ minus, part))),
                ValueKind::Negative(inner) => parts.push((!negative, inner)),
                ValueKind::Number(number) => {
                    if !number.is_integer() {
                        return failed(self);
                    }
                    let Some(number) = number.to_i64().filter(|number| *number <= MOST_INDEX) else {
                        let text =
                            format!("an index is {MOST_INDEX} at most: count from a first index that is nearer to 0");
                        return self.wrong(part.span, text);
                    };
                    offset += if negative { -number } else { number };
                }
                ValueKind::Name(name) if variable.is_none() && !negative && !name.name.is_meta() => {
                    variable = Some(name.clone());
                }
                _ => return failed(self),
            }
        }
        Some((variable, offset))
    }

    /// The index of the first values; each sequence has its own without a gap.
    fn first_index(&mut self, equations: &Equations) -> Option<i64> {
        let mut from = None;
        for (name, ..) in &equations.steps {
            let Some(values) = equations.starts.get(&name.name) else {
                let text = format!("no first value of `{0}` is given: add one, such as `{0}(0) = 1`", name.name);
                return self.wrong(name.span, text);
            };
            let first = *values.keys().next()?;
            if values.keys().zip(first..).any(|(index, wanted)| *index != wanted) {
                return self.wrong(name.span, format!("the first values of `{}` have gaps", name.name));
            }
            if *from.get_or_insert(first) != first {
                return self.wrong(name.span, "all sequences must begin with the same index");
            }
        }
        for (name, values) in &equations.starts {
            if !equations.steps.iter().any(|(other, ..)| other.name == *name) {
                let span = values.values().next()?.span;
                return self.wrong(span, format!("no equation says what the next `{name}` is"));
            }
        }
        from
    }

    /// The right side of an equation, so many steps later; its terms as variables.
    fn right_side(&mut self, right: &Written, names: &[Name], index: &Name, shift: i64) -> Option<Value> {
        let mut terms = BTreeMap::new();
        let renamed = self.with_terms(right, names, index, &mut terms)?;
        for (name, span) in terms.keys().map(|(name, offset)| (raw(name, *offset), right.span)) {
            self.locals.insert(name, span);
        }
        let value = self.number(&renamed)?;
        let mut images: BTreeMap<Name, Value> = BTreeMap::new();
        for (name, offset) in terms.keys() {
            let Some(place) = offset.checked_add(shift).and_then(|place| usize::try_from(place).ok()) else {
                let text = format!(
                    "`{}` needs a term before the first: give more first values",
                    term_text(name, index, *offset)
                );
                return self.wrong(terms[&(name.clone(), *offset)], text);
            };
            images.insert(raw(name, *offset), Value::variable(&term(name, index, place)));
        }
        let later = Value::variable(index).add(&Value::integer(shift));
        let later = self.checked(later, right.span)?;
        images.insert(index.clone(), later);
        let value = value.substitute(&images);
        self.checked(value, right.span)
    }

    fn checked(&mut self, value: Result<Value, crate::value::ValueError>, span: Span) -> Option<Value> {
        match value {
            Ok(value) => Some(value),
            Err(error) => self.fail(Diagnostic::error("P0402", error.0).label(span, "in this value")),
        }
    }

    /// The value with the terms of sequences replaced by names that cannot be written.
    fn with_terms(
        &mut self,
        written: &Written,
        names: &[Name],
        index: &Name,
        found: &mut BTreeMap<(Name, i64), Span>,
    ) -> Option<Written> {
        let mut each = |parts: &[(bool, Written)]| -> Option<Vec<(bool, Written)>> {
            parts.iter().map(|(sign, part)| Some((*sign, self.with_terms(part, names, index, found)?))).collect()
        };
        let kind = match &written.kind {
            ValueKind::Sum(parts) => ValueKind::Sum(each(parts)?),
            ValueKind::Product(parts) => ValueKind::Product(each(parts)?),
            ValueKind::Power(base, exponent) => {
                let base = self.with_terms(base, names, index, found)?;
                ValueKind::Power(Box::new(base), Box::new(self.with_terms(exponent, names, index, found)?))
            }
            ValueKind::Negative(inner) => ValueKind::Negative(Box::new(self.with_terms(inner, names, index, found)?)),
            ValueKind::Absolute(inner) => ValueKind::Absolute(Box::new(self.with_terms(inner, names, index, found)?)),
            ValueKind::If(relation, parts) => {
                let parts: Option<Vec<_>> =
                    parts.iter().map(|part| self.with_terms(part, names, index, found)).collect();
                ValueKind::If(*relation, Box::new(<[Written; 4]>::try_from(parts?).ok()?))
            }
            ValueKind::Vector(parts) => {
                let parts: Option<Vec<_>> =
                    parts.iter().map(|part| self.with_terms(part, names, index, found)).collect();
                ValueKind::Vector(parts?)
            }
            ValueKind::Call(name, arguments) if names.contains(&name.name) => {
                return self.one_term(written, name, arguments, index, found);
            }
            ValueKind::Call(name, arguments) => {
                if self.reads_like_a_term(&name.name, arguments, index) {
                    return self.without_equation(name, index);
                }
                let mut images = Vec::new();
                for argument in arguments {
                    let value = self.with_terms(&argument.value, names, index, found)?;
                    images.push(Argument { label: argument.label.clone(), value });
                }
                ValueKind::Call(name.clone(), images)
            }
            ValueKind::Iterate(chain, arguments) => {
                let mut images = Vec::new();
                for argument in arguments {
                    let value = self.with_terms(&argument.value, names, index, found)?;
                    images.push(Argument { label: argument.label.clone(), value });
                }
                ValueKind::Iterate(chain.clone(), images)
            }
            ValueKind::Cases(cases) => {
                let mut images = Vec::new();
                for (value, condition) in cases {
                    let value = self.with_terms(value, names, index, found)?;
                    let condition = match condition {
                        Some(one) => Some(Comparison {
                            left: self.with_terms(&one.left, names, index, found)?,
                            right: self.with_terms(&one.right, names, index, found)?,
                            ..*one
                        }),
                        None => None,
                    };
                    images.push((value, condition));
                }
                ValueKind::Cases(images)
            }
            ValueKind::Name(name) => match subscripted(name).filter(|(_, suffix)| *suffix == index.as_str()) {
                Some((call, _)) => return self.with_terms(&call, names, index, found),
                None => written.kind.clone(),
            },
            ValueKind::Number(_) => written.kind.clone(),
        };
        Some(Written { span: written.span, kind })
    }

    /// Whether `y(n)` or `y(n+1)` stands where y is neither a sequence nor a function.
    fn reads_like_a_term(&self, name: &Name, arguments: &[Argument], index: &Name) -> bool {
        let [Argument { label: None, value }] = arguments else { return false };
        let is_index = |one: &Written| matches!(&one.kind, ValueKind::Name(own) if own.name == *index);
        let is_number = |one: &Written| matches!(one.kind, ValueKind::Number(_));
        let place = match &value.kind {
            ValueKind::Sum(parts) => {
                parts.iter().any(|(minus, part)| !minus && is_index(part))
                    && parts.iter().all(|(_, part)| is_index(part) || is_number(part))
            }
            _ => is_index(value),
        };
        let known =
            FUNCTIONS.iter().any(|(known, _)| *known == name.as_str()) || DISTRIBUTIONS.contains(&name.as_str());
        place && !known && self.environment.quantity(name).is_none() && !self.locals.contains_key(name)
    }

    fn without_equation<T>(&mut self, name: &Ident, index: &Name) -> Option<T> {
        let advice = format!(
            "a sequence needs its next term and its first value, `{0}({index}+1) = …, {0}(0) = …`; a function is declared with `fn {0}(x) = …`",
            name.name
        );
        self.unknown("P0307", "sequence or function", name, FUNCTIONS.iter().map(|(known, _)| *known), &advice);
        None
    }

    fn one_term(
        &mut self,
        written: &Written,
        name: &Ident,
        arguments: &[Argument],
        index: &Name,
        found: &mut BTreeMap<(Name, i64), Span>,
    ) -> Option<Written> {
        let [Argument { label: None, value: place }] = arguments else {
            return self.wrong(written.span, "a term of a sequence has one index");
        };
        let (variable, offset) = self.place(place)?;
        match variable {
            Some(variable) if variable.name == *index => {}
            _ => {
                return self
                    .wrong(place.span, format!("the index of a term here is `{index}`, with a number or without"));
            }
        }
        found.insert((name.name.clone(), offset), written.span);
        let ident = Ident { name: raw(&name.name, offset), span: written.span };
        Some(Written { span: written.span, kind: ValueKind::Name(ident) })
    }

    /// Terms of the same step are replaced by what they are; no term may be later than that.
    fn known_terms(&mut self, recurrence: &mut Recurrence, equations: &Equations) -> Option<()> {
        let next: Vec<(Name, Value)> = recurrence
            .sequences
            .iter()
            .map(|sequence| (recurrence.term(&sequence.name, sequence.start.len()), sequence.next.clone()))
            .collect();
        let earlier: Vec<Name> = recurrence.terms().into_iter().map(|(name, ..)| name).collect();
        for (place, (name, _, right)) in equations.steps.iter().enumerate() {
            for _ in 0..next.len() {
                let used = |(term, _): &&(Name, Value)| recurrence.sequences[place].next.mentions(term);
                let mentioned: Vec<(Name, Value)> = next.iter().filter(used).cloned().collect();
                if mentioned.is_empty() {
                    break;
                }
                for (term, image) in &mentioned {
                    let value = recurrence.sequences[place].next.with(term, image);
                    recurrence.sequences[place].next = self.checked(value, right.span)?;
                }
            }
            let known = |variable: &Name| {
                earlier.contains(variable) || *variable == recurrence.index || !variable.as_str().contains('(')
            };
            let value = &recurrence.sequences[place].next;
            if let Some(other) = value.variables().into_iter().find(|variable| !known(variable)) {
                let text = format!("the next `{}` depends on `{other}`, which is not known before it", name.name);
                return self.wrong(right.span, text);
            }
            if value.sort() != crate::value::Sort::Real {
                return self
                    .wrong(right.span, "the terms of a sequence are numbers; write one equation for each component");
            }
        }
        Some(())
    }

    fn find(&mut self, find: &ast::Find, names: &[Name], recurrence: &Recurrence) -> Option<(Relation, Value, Value)> {
        let index = &recurrence.index;
        if find.index.name != *index {
            return self.wrong(find.index.span, format!("the index is `{index}`"));
        }
        let mut side = |written: &Written| {
            let value = self.right_side(written, names, index, 0)?;
            let known: Vec<Name> =
                recurrence.sequences.iter().map(|sequence| recurrence.term(&sequence.name, 0)).collect();
            let wrong = value.variables().into_iter().find(|name| name.as_str().contains('(') && !known.contains(name));
            match wrong {
                Some(name) => {
                    self.wrong(written.span, format!("`find` looks at the terms of index `{index}`, not at `{name}`"))
                }
                None => Some(value),
            }
        };
        let left = side(&find.left)?;
        Some((find.relation, left, side(&find.right)?))
    }
}

/// A name for a term that cannot be written.
fn raw(name: &Name, offset: i64) -> Name {
    Name::new(&format!("({name} at {offset})"))
}

fn term_text(name: &Name, index: &Name, offset: i64) -> String {
    match offset {
        0 => format!("{name}({index})"),
        _ if offset > 0 => format!("{name}({index}+{offset})"),
        _ => format!("{name}({index}{offset})"),
    }
}

/// The name of a call.
fn called(written: &Written) -> Option<Name> {
    match &written.kind {
        ValueKind::Call(name, _) => Some(name.name.clone()),
        ValueKind::Name(name) => called(&subscripted(name)?.0),
        _ => None,
    }
}

/// `r_n` and `r_0`, which the paper writes for `r(n)` and `r(0)`, with what stands behind the `_`.
fn subscripted(ident: &Ident) -> Option<(Written, &str)> {
    let (base, suffix) = ident.name.as_str().rsplit_once('_')?;
    let span = ident.span;
    let kind = match suffix.parse::<u32>() {
        Ok(number) => ValueKind::Number(num_rational::BigRational::from_integer(number.into())),
        Err(_) => ValueKind::Name(Ident { name: Name::new(suffix), span }),
    };
    let place = Argument { label: None, value: Written { span, kind } };
    let name = Ident { name: Name::new(base), span };
    Some((Written { span, kind: ValueKind::Call(name, vec![place]) }, suffix))
}
