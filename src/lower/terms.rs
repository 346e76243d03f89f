//! Terms of sequences in values: `r(n+1)` becomes a variable, and of a sequence of vectors one for each component.

use std::cell::OnceCell;
use std::collections::BTreeMap;

use num_rational::BigRational;

use super::distribution::DISTRIBUTIONS;
use super::scope::Lowerer;
use super::solve::{Lengths, subscripted};
use super::value::{FUNCTIONS, Kept, Needed, Requirement, Ways, behind_guards};
use crate::ast::{Argument, FACTORIAL, Ident, Value as Written, ValueKind};
use crate::closed_form::{Comparison, first_zero, term};
use crate::diagnostic::{Diagnostic, Span};
use crate::name::Name;
use crate::value::{Atom, Need, Relation, Sort, Value};

impl Lowerer<'_> {
    /// The right side of an equation, so many steps later; its terms as variables. The index begins at `from`.
    pub(super) fn right_side(
        &mut self,
        right: &Written,
        names: &Lengths,
        (index, from): (&Name, i64),
        shift: i64,
    ) -> Option<Value> {
        let mut terms = BTreeMap::new();
        let renamed = self.with_terms(right, names, index, &mut terms)?;
        for (name, offset) in terms.keys() {
            let own: Vec<Name> = components(name, names).iter().map(|part| raw(part, index, *offset)).collect();
            self.locals.extend(own.iter().map(|part| (part.clone(), right.span)));
            if own.len() > 1 {
                let vector = Value::vector(own.iter().map(Value::variable).collect());
                let vector = self.checked(vector, right.span)?;
                self.images.insert(raw(name, index, *offset), vector);
            }
        }
        self.needed = Some(Vec::new());
        let value = self.number(&renamed);
        let needed = self.needed.take().unwrap_or_default();
        let value = value?;
        let mut own: Vec<Name> = Vec::new();
        for (name, offset) in terms.keys() {
            own.extend(components(name, names).iter().map(|part| raw(part, index, *offset)));
        }
        self.kept(needed, &value, &own, (index, from))?;
        self.whole_powers(&renamed, &value, (index, from.saturating_add(shift)))?;
        let mut images: BTreeMap<Name, Value> = BTreeMap::new();
        for (name, offset) in terms.keys() {
            let Some(place) = offset.checked_add(shift).and_then(|place| usize::try_from(place).ok()) else {
                let text = format!(
                    "`{}` needs a term before the first: give more first values",
                    term_text(name, index, *offset)
                );
                return self.wrong(terms[&(name.clone(), *offset)], text);
            };
            for part in components(name, names) {
                images.insert(raw(&part, index, *offset), Value::variable(&term(&part, index, place)));
            }
        }
        let later = Value::variable(index).add(&Value::integer(shift));
        let later = self.checked(later, right.span)?;
        images.insert(index.clone(), later);
        let value = value.substitute(&images);
        self.checked(value, right.span)
    }

    /// A power with the index as exponent counts as a whole number under `floor` and `mod`, as exponents are natural. Where
    /// the index begins below 0 it must make no difference when it is counted from there.
    fn whole_powers(&mut self, written: &Written, value: &Value, (index, first): (&Name, i64)) -> Option<()> {
        if first >= 0 {
            return Some(());
        }
        let counted = Value::variable(index).add(&Value::integer(first));
        let counted = self.checked(counted, written.span)?;
        let before = self.images.insert(index.clone(), counted.clone());
        let apart = self.number(written);
        match before {
            Some(image) => self.images.insert(index.clone(), image),
            None => self.images.remove(index),
        };
        let (apart, together) = (apart?, self.checked(value.with(index, &counted), written.span)?);
        let counts = |need: &Need| matches!(need, Need::Natural(exponent) if exponent.mentions(index));
        if apart == together || !apart.needs().iter().any(counts) {
            return Some(());
        }
        self.fail(
            Diagnostic::error(
                "P0402",
                format!("`{index}` begins at {first} here, and an exponent below 0 gives a fraction"),
            )
            .label(written.span, "this rounds a power that is no whole number then")
            .help("count from an index at which no exponent is below 0"),
        )
    }

    /// What an equation divides by, or takes a root of, must not cancel where it may be 0, or negative, for a term or an
    /// index: the equation would have a value there that it does not have as it is written. Of parameters alone that is kept
    /// as a condition, whether it cancels or not.
    pub(super) fn kept(
        &mut self,
        needed: Vec<Needed>,
        value: &Value,
        terms: &[Name],
        (index, from): (&Name, i64),
    ) -> Option<()> {
        let mut known = self.environment.assumptions.without_name(index);
        if from >= 0 {
            known.assume_natural(index);
        }
        known.assume(Relation::Gte, &Value::variable(index), &Value::integer(from));
        let factorial = raw(&Name::new(FACTORIAL), index, 0);
        if self.factorials && terms.contains(&factorial) {
            known.assume(Relation::Gtr, &Value::variable(&factorial), &Value::zero());
        }
        let reads = |value: &Value| value.mentions(index) || terms.iter().any(|name| value.mentions(name));
        let cases = OnceCell::new();
        for Needed { need, span, guards } in needed {
            if need.value().sort() != Sort::Real {
                continue;
            }
            if let Need::Natural(exponent) = &need {
                if !exponent.is_whole() && known.is_natural(exponent) != Some(true) {
                    return self.fail(no_exponent(exponent, span));
                }
                let names = exponent.variables().into_iter();
                self.exponents.extend(names.filter(|name| name != index && !terms.contains(name)));
                continue;
            }
            let divides = matches!(need, Need::Nonzero(_));
            let part = if divides { need.value().numerator()? } else { need.value().clone() };
            let need = if divides { Need::Nonzero(part.clone()) } else { need };
            let varies = reads(&part);
            let never = || divides && varies && first_zero(&part, index, from) == Some(None);
            if known.grants(&need) == Some(true) || never() {
                continue;
            }
            if varies || known.grants(&need) == Some(false) {
                let cases = cases.get_or_init(|| Kept::of(value, &known));
                if cases.has(&need, guards.as_ref()) {
                    continue;
                }
            }
            let behind = behind_guards(&need, guards.as_ref(), &known);
            if !behind && known.grants(&need).is_none() && !varies {
                let of_parameters = |value: &Value| !reads(value);
                self.needs_of_parameters(&need, guards.and_then(|ways| chosen_by(ways, &of_parameters)));
            } else if !behind {
                return self.fail(lost(divides, value, span));
            }
        }
        Some(())
    }

    /// Keeps as a condition what is needed of parameters, in some ways or always.
    fn needs_of_parameters(&mut self, need: &Need, ways: Option<Ways>) {
        let relation = if matches!(need, Need::Nonzero(_)) { Relation::Neq } else { Relation::Gte };
        for factor in need.apart() {
            let comparison = (relation, factor.value().clone(), Value::zero());
            match self.conditions.iter_mut().find(|one| one.comparison == comparison) {
                Some(known) => {
                    let both = known.ways.take().zip(ways.clone());
                    known.ways = both.map(|(one, other)| [one, other].concat());
                }
                None => self.conditions.push(Requirement { comparison, ways: ways.clone() }),
            }
        }
    }

    /// As of one value, of each.
    fn all_with_terms<'w>(
        &mut self,
        written: impl IntoIterator<Item = &'w Written>,
        names: &Lengths,
        index: &Name,
        found: &mut BTreeMap<(Name, i64), Span>,
    ) -> Option<Vec<Written>> {
        written.into_iter().map(|part| self.with_terms(part, names, index, found)).collect()
    }

    /// The value with the terms of sequences replaced by names that cannot be written.
    fn with_terms(
        &mut self,
        written: &Written,
        names: &Lengths,
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
                let parts = self.all_with_terms(parts.as_ref(), names, index, found)?;
                ValueKind::If(*relation, Box::new(<[Written; 4]>::try_from(parts).ok()?))
            }
            ValueKind::Vector(parts) => ValueKind::Vector(self.all_with_terms(parts, names, index, found)?),
            ValueKind::Call(name, arguments) if names.contains_key(&name.name) => {
                return self.one_term(written, name, arguments, index, found);
            }
            ValueKind::Call(name, arguments) => {
                if self.reads_like_a_term(&name.name, arguments, index) {
                    if let Some((whole, place)) = part_of(&name.name, names) {
                        let whole = Ident { name: whole, span: name.span };
                        return self.part_term(written, &whole, place, arguments, index, found);
                    }
                    return self.without_equation(name, index);
                }
                let values = self.all_with_terms(values(arguments), names, index, found)?;
                ValueKind::Call(name.clone(), relabelled(arguments, values))
            }
            ValueKind::Iterate(chain, arguments) => {
                let values = self.all_with_terms(values(arguments), names, index, found)?;
                ValueKind::Iterate(chain.clone(), relabelled(arguments, values))
            }
            ValueKind::Cases(cases) => {
                let mut images = Vec::new();
                for (value, condition) in cases {
                    let value = self.with_terms(value, names, index, found)?;
                    let mut either = condition.clone();
                    for one in either.iter_mut().flat_map(|either| either.0.iter_mut().flatten()) {
                        one.left = self.with_terms(&one.left, names, index, found)?;
                        one.right = self.with_terms(&one.right, names, index, found)?;
                    }
                    images.push((value, either));
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
        let ident = Ident { name: raw(&name.name, index, offset), span: written.span };
        Some(Written { span: written.span, kind: ValueKind::Name(ident) })
    }
}

impl Lowerer<'_> {
    /// `rx(n)` of a sequence of vectors r, as answers name it: `part(r(n),1)`.
    fn part_term(
        &mut self,
        written: &Written,
        whole: &Ident,
        place: usize,
        arguments: &[Argument],
        index: &Name,
        found: &mut BTreeMap<(Name, i64), Span>,
    ) -> Option<Written> {
        let value = self.one_term(written, whole, arguments, index, found)?;
        let place = Written { span: written.span, kind: ValueKind::Number(BigRational::from_integer(place.into())) };
        let part = Ident { name: Name::new("part"), span: whole.span };
        let arguments = [value, place].map(|value| Argument { label: None, value });
        Some(Written { span: written.span, kind: ValueKind::Call(part, arguments.to_vec()) })
    }
}

/// What these ways say of parameters; none where one of them says nothing of them.
fn chosen_by(ways: Ways, of_parameters: &dyn Fn(&Value) -> bool) -> Option<Ways> {
    let told = |way: Vec<Comparison>| {
        let own: Vec<Comparison> =
            way.into_iter().filter(|(_, left, right)| of_parameters(left) && of_parameters(right)).collect();
        (!own.is_empty()).then_some(own)
    };
    ways.into_iter().map(told).collect()
}

/// The error that what an equation needs has cancelled.
fn lost(divides: bool, value: &Value, span: Span) -> Diagnostic {
    let [what, where_it_is, advice] = match divides {
        true => {
            ["what this divides by cancels, and may be 0", "where this is 0", "write the quotient in its lowest terms"]
        }
        false => [
            "this root cancels, and may be one of a negative number",
            "where this is negative",
            "write it without the root",
        ],
    };
    let chosen = value.atoms().iter().any(|atom| matches!(atom, Atom::Positive(_)));
    let help = match chosen {
        true => "ask before it for what excludes that: `if a > 0 then 1/a else 0`, `if a > 0 and 1/a < b`".to_string(),
        false => format!("{advice}, if that is what is meant"),
    };
    Diagnostic::error("P0402", what).label(span, format!("{where_it_is} the equation has no value")).help(help)
}

/// That an exponent may be no whole number.
fn no_exponent(exponent: &Value, span: Span) -> Diagnostic {
    Diagnostic::error("P0402", format!("an exponent must be a whole number, and `{exponent}` need not be one"))
        .label(span, "in this value")
        .help("half a power is a root: `sqrt(2)^n`; a part of an index is rounded: `2^floor(n/2)`")
}

/// The sequence of vectors of which this names a component, and the place of that from 1.
fn part_of(name: &Name, lengths: &Lengths) -> Option<(Name, usize)> {
    lengths.iter().find_map(|(whole, length)| {
        let place = components(whole, lengths).iter().position(|part| part == name)?;
        (*length > 1).then(|| (whole.clone(), place + 1))
    })
}

/// The sequences of numbers that a sequence consists of.
pub(super) fn components(name: &Name, lengths: &Lengths) -> Vec<Name> {
    match lengths.get(name) {
        Some(length) if *length > 1 => (0..*length).map(|place| name.component(place, *length)).collect(),
        _ => vec![name.clone()],
    }
}

/// A name for a term that cannot be written as a name, and that says which it is.
fn raw(name: &Name, index: &Name, offset: i64) -> Name {
    Name::new(&term_text(name, index, offset))
}

fn term_text(name: &Name, index: &Name, offset: i64) -> String {
    match offset {
        0 => format!("{name}({index})"),
        _ if offset > 0 => format!("{name}({index}+{offset})"),
        _ => format!("{name}({index}{offset})"),
    }
}

fn values(arguments: &[Argument]) -> impl Iterator<Item = &Written> {
    arguments.iter().map(|argument| &argument.value)
}

/// These values as arguments, with the labels of those.
fn relabelled(arguments: &[Argument], values: Vec<Written>) -> Vec<Argument> {
    let labelled = |(argument, value): (&Argument, Written)| Argument { label: argument.label.clone(), value };
    arguments.iter().zip(values).map(labelled).collect()
}
