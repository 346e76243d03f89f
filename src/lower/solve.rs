//! Recurrences: equations between terms of sequences, and their first values.

mod factorial;
mod find;
mod vectors;

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};

use num_traits::ToPrimitive;

use super::scope::Lowerer;
use super::terms::components;
use super::value::Requirement;
use crate::ast::{self, Argument, Ident, Value as Written, ValueKind};
use crate::closed_form::{Comparison, Recurrence, Sequence, as_it_stands};
use crate::diagnostic::{Diagnostic, Span};
use crate::name::Name;
use crate::value::{Relation, Sort, Value};

/// The most first values of one sequence.
const MOST_ORDER: usize = 64;

/// The most equations, first values among them.
const MOST_EQUATIONS: usize = 400;

/// For each sequence how many components its terms have; 1 for numbers.
pub(super) type Lengths = BTreeMap<Name, usize>;

/// `solve … find …`
#[derive(Clone, Debug)]
pub struct Question {
    /// What is to be solved.
    pub recurrence: Recurrence,
    /// A comparison of expressions in the terms [`Recurrence::term`] of offset 0, whose first index is looked for: of
    /// numbers, or `=` and `!=` of vectors of the same length.
    pub find: Option<(Relation, Value, Value)>,
    /// Where one of several is to hold, each of these by itself.
    pub either: Vec<(Relation, Value, Value)>,
    /// Where several are to hold together, each of these by itself.
    pub together: Vec<(Relation, Value, Value)>,
    /// Where it is to hold from a number on, that number, and what is to hold there.
    pub since: Option<(i64, (Relation, Value, Value))>,
    /// The same as it was asked, where several comparisons have become one.
    pub asked: Option<String>,
    /// What must hold of parameters for the equations to mean something: `v != 0` of `r(n)/v*v`.
    pub conditions: Vec<Requirement>,
    /// Those of them that are known to be required, and are said.
    pub required: Vec<Comparison>,
    /// What is to be said of the equations.
    pub notes: Vec<String>,
}

impl Question {
    /// What is looked for, as text: as it was asked, or this.
    pub fn goal(&self, (relation, left, right): (Relation, &Value, &Value)) -> String {
        self.asked.clone().unwrap_or_else(|| as_it_stands(&(relation, left.clone(), right.clone())))
    }
}

/// The equations, sorted.
#[derive(Default)]
struct Equations<'a> {
    index: Option<Ident>,
    /// For each name the offset on the left, and the right side.
    steps: Vec<(Ident, i64, Cow<'a, Written>)>,
    /// For each name its first values by index.
    starts: BTreeMap<Name, BTreeMap<i64, &'a Written>>,
}

/// The largest index of a term, and the largest step ahead.
const MOST_INDEX: i64 = 1_000;

impl Lowerer<'_> {
    pub(super) fn solve(&mut self, solve: &ast::Solve) -> Option<Question> {
        let with_factorials = self.with_factorials(solve)?;
        self.factorials = with_factorials.is_some();
        let solve = with_factorials.as_ref().unwrap_or(solve);
        let mut equations = Equations::default();
        if let Some((left, _)) = solve.equations.get(MOST_EQUATIONS) {
            return self.wrong(left.span, format!("there are more than {MOST_EQUATIONS} equations"));
        }
        let names: BTreeSet<Name> = solve.equations.iter().filter_map(|(left, _)| begun(left)).collect();
        for (left, right) in &solve.equations {
            let (left, led) = self.led(left, right, &names)?;
            self.equation(&left, (right, led), &mut equations)?;
        }
        let Some(index) = equations.index.clone() else {
            return self.without_step(solve);
        };
        self.locals.insert(index.name.clone(), index.span);
        let from = self.first_index(&equations)?;
        let starts = self.starts(&equations, &index.name)?;
        let lengths = self.lengths(&equations, &starts)?;
        let (mut sequences, mut spans) = (Vec::new(), Vec::new());
        for ((name, offset, right), start) in equations.steps.iter().zip(&starts) {
            let shift = i64::try_from(start.len()).ok()? - offset;
            let next = self.right_side(right, &lengths, (&index.name, from), shift)?;
            let length = lengths.get(&name.name).copied().unwrap_or(1);
            if sort(length) != next.sort() {
                let text =
                    format!("the first value of `{}` is {}, and the next {}", name.name, sort(length), next.sort());
                return self.wrong(right.span, text);
            }
            let parts = |value: &Value| value.components().unwrap_or_else(|| vec![value.clone()]);
            for (place, (name, next)) in components(&name.name, &lengths).into_iter().zip(parts(&next)).enumerate() {
                let start = start.iter().filter_map(|value| parts(value).into_iter().nth(place)).collect();
                sequences.push(Sequence { name, start, next });
                spans.push(right.span);
            }
        }
        let mut recurrence = Recurrence { index: index.name.clone(), from, sequences };
        let mut notes = self.given_instead(&equations, &recurrence, &lengths);
        self.known_terms(&mut recurrence, &spans)?;
        let (find, (either, together), since, asked) = match &solve.find {
            Some(find) => {
                let find::Found { sought, either, together, since, asked } = self.find(find, &lengths, &recurrence)?;
                (Some(sought), (either, together), since, asked)
            }
            None => (None, Default::default(), None, None),
        };
        notes.extend(self.counted(&recurrence));
        let (conditions, required) = (std::mem::take(&mut self.conditions), Vec::new());
        Some(Question { recurrence, find, either, together, since, asked, conditions, required, notes })
    }

    /// Exponents with parameters in them that are not known to be natural.
    fn counted(&self, recurrence: &Recurrence) -> Vec<String> {
        let known = &self.environment.assumptions;
        let terms = recurrence.terms();
        let open = |name: &&Name| {
            let term = **name == recurrence.index || terms.iter().any(|(term, ..)| term == *name);
            !term && known.is_natural(&Value::variable(name)) != Some(true)
        };
        let names = self.exponents.iter().filter(open);
        names.map(|name| format!("{name} is taken to be a natural number: it is an exponent")).collect()
    }

    /// First values that are given although the equation would make them, and not what it would make them.
    fn given_instead(&self, equations: &Equations, recurrence: &Recurrence, lengths: &Lengths) -> Vec<String> {
        let mut notes = Vec::new();
        for (name, offset, _) in &equations.steps {
            for part in components(&name.name, lengths) {
                let Some(own) = recurrence.sequences.iter().find(|own| own.name == part) else { continue };
                let given = own.start.len() as i64;
                for place in (*offset).max(0)..given {
                    let at = recurrence.from + place;
                    let Some(made) = earlier(&own.next, recurrence, given - place) else { continue };
                    let Some(value) = usize::try_from(place).ok().and_then(|place| own.start.get(place)) else {
                        continue;
                    };
                    if self.environment.assumptions.decide(Relation::Eq, &made, value) != Some(true) {
                        notes.push(format!(
                            "{part}({at}) = {value} is given, where the equation makes it {made}: it is taken to hold from \
                             {part}({}) on",
                            recurrence.from + given
                        ));
                    }
                }
            }
        }
        notes
    }

    /// The first values of each sequence, in the order of the steps.
    fn starts(&mut self, equations: &Equations, index: &Name) -> Option<Vec<Vec<Value>>> {
        let mut all = Vec::new();
        for (name, ..) in &equations.steps {
            let values = equations.starts.get(&name.name);
            let written = values.into_iter().flat_map(BTreeMap::values);
            let start: Option<Vec<Value>> = written.map(|one| self.first_value(one, index)).collect();
            let start = start?;
            if start.len() > MOST_ORDER {
                return self.wrong(name.span, format!("`{}` has more than {MOST_ORDER} first values", name.name));
            }
            if start.iter().any(|value| value.mentions(index)) {
                let text = format!("a first value of `{}` depends on `{index}`, which counts the terms", name.name);
                return self.wrong(name.span, text);
            }
            if let [first, others @ ..] = start.as_slice()
                && let Some(other) = others.iter().find(|other| other.sort() != first.sort())
            {
                let text = format!("the first values of `{}` are {} and {}", name.name, first.sort(), other.sort());
                return self.wrong(name.span, text);
            }
            all.push(start);
        }
        Some(all)
    }

    fn first_value(&mut self, written: &Written, index: &Name) -> Option<Value> {
        self.needed = Some(Vec::new());
        let value = self.number(written);
        let needed = self.needed.take().unwrap_or_default();
        let value = value?;
        self.kept(needed, &value, &[], (index, 0))?;
        Some(value)
    }

    /// The components of each sequence, as its first values have them.
    fn lengths(&mut self, equations: &Equations, starts: &[Vec<Value>]) -> Option<Lengths> {
        let mut lengths = Lengths::new();
        for ((name, ..), start) in equations.steps.iter().zip(starts) {
            let length = match start.first().map(Value::sort) {
                Some(Sort::Vector(length)) => length,
                _ => 1,
            };
            lengths.insert(name.name.clone(), length);
        }
        let names: Vec<Name> = lengths.keys().flat_map(|name| components(name, &lengths)).collect();
        let twice = |name: &&Name| names.iter().filter(|other| other == name).count() > 1;
        match names.iter().find(twice) {
            None => Some(lengths),
            Some(name) => {
                let span = equations.steps.first()?.0.span;
                self.wrong(span, format!("`{name}` is the name of a sequence and of a component of another"))
            }
        }
    }

    pub(super) fn wrong<T>(&mut self, span: Span, text: impl Into<String>) -> Option<T> {
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
    fn equation<'a>(
        &mut self,
        left: &Written,
        (start, right): (&'a Written, Cow<'a, Written>),
        found: &mut Equations<'a>,
    ) -> Option<()> {
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
                if found.starts.entry(name.name.clone()).or_default().insert(offset, start).is_some() {
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
    pub(super) fn place(&mut self, written: &Written) -> Option<(Option<Ident>, i64)> {
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
            if let Some((_, missing)) = values.keys().zip(first..).find(|(index, wanted)| **index != *wanted) {
                let name = &name.name;
                let text = format!("the first values of `{name}` have gaps: `{name}({missing})` is not given");
                return self.wrong(values.values().next()?.span, text);
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

    pub(super) fn checked(&mut self, value: Result<Value, crate::value::ValueError>, span: Span) -> Option<Value> {
        match value {
            Ok(value) => Some(value),
            Err(error) => self.fail(Diagnostic::error("P0402", error.0).label(span, "in this value")),
        }
    }

    /// Terms of the same step are replaced by what they are; no term may be later than that.
    fn known_terms(&mut self, recurrence: &mut Recurrence, spans: &[Span]) -> Option<()> {
        let next: Vec<(Name, Value)> = recurrence
            .sequences
            .iter()
            .map(|sequence| (recurrence.term(&sequence.name, sequence.start.len()), sequence.next.clone()))
            .collect();
        let earlier: Vec<Name> = recurrence.terms().into_iter().map(|(name, ..)| name).collect();
        for (place, span) in spans.iter().enumerate() {
            for _ in 0..next.len() {
                let used = |(term, _): &&(Name, Value)| recurrence.sequences[place].next.mentions(term);
                let mentioned: Vec<(Name, Value)> = next.iter().filter(used).cloned().collect();
                if mentioned.is_empty() {
                    break;
                }
                for (term, image) in &mentioned {
                    let value = recurrence.sequences[place].next.with(term, image);
                    recurrence.sequences[place].next = self.checked(value, *span)?;
                }
            }
            let known = |variable: &Name| {
                earlier.contains(variable) || *variable == recurrence.index || !variable.as_str().contains('(')
            };
            let Sequence { name, next: value, .. } = &recurrence.sequences[place];
            if let Some(other) = value.variables().into_iter().find(|variable| !known(variable)) {
                let text = format!("the next `{name}` depends on `{other}`, which is not known before it");
                return self.wrong(*span, text);
            }
        }
        Some(())
    }
}

/// What an equation gives so many indices before the first one, from first values alone.
fn earlier(next: &Value, recurrence: &Recurrence, by: i64) -> Option<Value> {
    let mut images = BTreeMap::from([(recurrence.index.clone(), Value::integer(recurrence.from - by))]);
    for sequence in &recurrence.sequences {
        for offset in 0..sequence.start.len().saturating_add(usize::try_from(by).ok()?) {
            let name = recurrence.term(&sequence.name, offset);
            if next.mentions(&name) {
                let place = usize::try_from(i64::try_from(offset).ok()? - by).ok()?;
                images.insert(name, sequence.start.get(place)?.clone());
            }
        }
    }
    let made = next.substitute(&images).ok()?;
    made.variables().iter().all(|name| !name.as_str().contains('(')).then_some(made)
}

/// What values of so many components are.
fn sort(length: usize) -> Sort {
    if length > 1 { Sort::Vector(length) } else { Sort::Real }
}

/// `r_n` and `r_0`, which the paper writes for `r(n)` and `r(0)`, with what stands behind the `_`.
pub(super) fn subscripted(ident: &Ident) -> Option<(Written, &str)> {
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

/// The sequence of which an equation gives a first value: `r` of `r(0)`.
fn begun(left: &Written) -> Option<Name> {
    let call = match &left.kind {
        ValueKind::Name(name) => subscripted(name).map(|(call, _)| call),
        _ => None,
    };
    let ValueKind::Call(name, arguments) = &call.as_ref().unwrap_or(left).kind else { return None };
    let [Argument { label: None, value: Written { kind, .. } }] = arguments.as_slice() else { return None };
    let number = |kind: &ValueKind| matches!(kind, ValueKind::Number(_));
    let first = number(kind) || matches!(kind, ValueKind::Negative(inner) if number(&inner.kind));
    first.then(|| name.name.clone())
}
