//! `n!`, `1/(n+1)!` and `factorial(n)` in recurrences: a sequence of its own, `factorial(n+1) = (n+1)*factorial(n)`.

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, ToPrimitive};

use super::subscripted;
use crate::ast::{self, Argument, FACTORIAL, Ident, Value as Written, ValueKind};
use crate::diagnostic::{Diagnostic, Span};
use crate::lower::scope::Lowerer;
use crate::name::Name;
use crate::value::Value;

/// The greatest number whose factorial is computed.
const MOST: i64 = 2_000;
/// The furthest factorial behind the index that is written out.
const MOST_OPENED: i64 = 20;

impl Lowerer<'_> {
    /// The question with the sequence of factorials, where it has some of its index and says nothing else of them.
    pub(super) fn with_factorials(&mut self, solve: &ast::Solve) -> Option<Option<ast::Solve>> {
        let own = |(left, _): &(Written, Written)| matches!(&left.kind, ValueKind::Call(name, _) if is_factorial(name));
        if solve.equations.iter().any(own) || self.environment.quantity(&Name::new(FACTORIAL)).is_some() {
            return Some(None);
        }
        let sides = solve.equations.iter().flat_map(|(left, right)| [left, right]);
        let asked = solve.find.iter().flat_map(|find| sides_of(&find.either));
        let Some(span) = sides.chain(asked).find_map(used) else { return Some(None) };
        let starts = solve.equations.iter().filter_map(|(left, _)| index_of(left));
        let (mut index, mut first) = (None, None);
        for place in starts {
            match place {
                Index::Number(at) => first = Some(first.map_or(at, |first: i64| first.min(at))),
                Index::Name(name) => index = index.or(Some(name)),
            }
        }
        let (Some(index), Some(first)) = (index, first) else { return Some(None) };
        let Some(start) = factorial(first) else {
            return self.fail(
                Diagnostic::error(
                    "P0402",
                    format!("a factorial is of a natural number, and `{}` begins at {first}", index.name),
                )
                .label(span, "here")
                .help("count from 0, or from a greater index"),
            );
        };
        let mut solve = solve.clone();
        for (left, right) in &mut solve.equations {
            opened(left);
            opened(right);
        }
        if let Some(find) = &mut solve.find {
            sides_in(&mut find.either).for_each(opened);
        }
        let [one, index] =
            [ValueKind::Number(BigRational::one()), ValueKind::Name(index)].map(|kind| Written { span, kind });
        let next = Written { span, kind: ValueKind::Sum(vec![(false, index.clone()), (false, one)]) };
        let number = |number: BigInt| Written { span, kind: ValueKind::Number(BigRational::from_integer(number)) };
        let grown = ValueKind::Product(vec![(false, next.clone()), (false, call(index, span))]);
        solve.equations.push((call(next, span), Written { span, kind: grown }));
        solve.equations.push((call(number(first.into()), span), number(start)));
        Some(Some(solve))
    }

    /// The factorial of a number; of anything else why it has none here.
    pub(in crate::lower) fn factorial(&mut self, of: &Value, span: Span) -> Option<Value> {
        let number = of.as_rational();
        let whole =
            number.as_ref().filter(|number| number.is_integer()).and_then(|number| number.to_integer().to_i64());
        if let Some(found) = whole.and_then(factorial) {
            return Some(Value::rational(BigRational::from_integer(found)));
        }
        let text = match number {
            Some(number) => {
                format!("the factorial of {number} is not computed: it is of a natural number, {MOST} at most")
            }
            None => format!("the factorial of `{of}` is not known here"),
        };
        let help = "in `solve` it may be of the index: `solve x(n+1) = x(n)+1/n!, x(0) = 0`";
        self.fail(Diagnostic::error("P0402", text).label(span, "in this value").help(help))
    }
}

fn factorial(number: i64) -> Option<BigInt> {
    (0..=MOST).contains(&number).then(|| (1..=number).map(BigInt::from).product())
}

fn is_factorial(name: &Ident) -> bool {
    name.name.as_str() == FACTORIAL
}

fn call(place: Written, span: Span) -> Written {
    let name = Ident { name: Name::new(FACTORIAL), span };
    Written { span, kind: ValueKind::Call(name, vec![Argument { label: None, value: place }]) }
}

/// What a term on the left side of an equation is counted by.
enum Index {
    Number(i64),
    Name(Ident),
}

fn index_of(left: &Written) -> Option<Index> {
    let call = match &left.kind {
        ValueKind::Name(name) => subscripted(name).map(|(call, _)| call),
        _ => None,
    };
    match &call.as_ref().unwrap_or(left).kind {
        ValueKind::Call(_, arguments) => match arguments.as_slice() {
            [Argument { label: None, value }] => place_of(value),
            _ => None,
        },
        ValueKind::Sum(parts) | ValueKind::Product(parts) => {
            let mut all = parts.iter().filter_map(|(_, part)| index_of(part));
            all.find(|index| matches!(index, Index::Name(_)))
        }
        ValueKind::Negative(inner) => index_of(inner),
        _ => None,
    }
}

fn place_of(place: &Written) -> Option<Index> {
    match &place.kind {
        ValueKind::Number(number) if number.is_integer() => number.to_integer().to_i64().map(Index::Number),
        ValueKind::Negative(inner) => match place_of(inner)? {
            Index::Number(number) => Some(Index::Number(-number)),
            Index::Name(_) => None,
        },
        ValueKind::Name(name) => Some(Index::Name(name.clone())),
        ValueKind::Sum(parts) => {
            parts.iter().filter_map(|(_, part)| place_of(part)).find(|index| matches!(index, Index::Name(_)))
        }
        _ => None,
    }
}

fn sides_of(either: &ast::Either) -> impl Iterator<Item = &Written> {
    either.comparisons().flat_map(|one| [&one.left, &one.right])
}

fn sides_in(either: &mut ast::Either) -> impl Iterator<Item = &mut Written> {
    either.0.iter_mut().flatten().flat_map(|one| [&mut one.left, &mut one.right])
}

/// Writes `(n+2)!` as `(n+2)*(n+1)*n!`, wherever it stands.
fn opened(value: &mut Written) {
    let span = value.span;
    match &mut value.kind {
        ValueKind::Number(_) | ValueKind::Name(_) => {}
        ValueKind::Sum(parts) | ValueKind::Product(parts) => parts.iter_mut().for_each(|(_, part)| opened(part)),
        ValueKind::Power(base, exponent) => [base, exponent].into_iter().for_each(|part| opened(part)),
        ValueKind::Negative(inner) | ValueKind::Absolute(inner) => opened(inner),
        ValueKind::If(_, parts) => parts.iter_mut().for_each(opened),
        ValueKind::Vector(parts) => parts.iter_mut().for_each(opened),
        ValueKind::Iterate(_, arguments) => arguments.iter_mut().for_each(|argument| opened(&mut argument.value)),
        ValueKind::Cases(cases) => {
            for (value, when) in cases {
                opened(value);
                when.iter_mut().flat_map(sides_in).for_each(opened);
            }
        }
        ValueKind::Call(name, arguments) => match arguments.as_mut_slice() {
            [Argument { label: None, value: of }] if is_factorial(name) => {
                let Some((index, places)) = later(of) else { return };
                let written = |kind| Written { span, kind };
                let place = |place: i64| {
                    let number = written(ValueKind::Number(BigRational::from_integer(place.into())));
                    written(ValueKind::Sum(vec![(false, written(ValueKind::Name(index.clone()))), (false, number)]))
                };
                let factors = (1..=places).rev().map(|at| (false, place(at)));
                let rest = (false, call(written(ValueKind::Name(index.clone())), span));
                value.kind = ValueKind::Product(factors.chain([rest]).collect());
            }
            all => all.iter_mut().for_each(|argument| opened(&mut argument.value)),
        },
    }
}

/// The index and by how much it is greater, of `n+2`.
fn later(place: &Written) -> Option<(Ident, i64)> {
    let ValueKind::Sum(parts) = &place.kind else { return None };
    let (mut index, mut places) = (None, BigRational::from_integer(0.into()));
    for (negative, part) in parts {
        match &part.kind {
            ValueKind::Name(name) if !negative && index.is_none() => index = Some(name.clone()),
            ValueKind::Number(number) if *negative => places -= number,
            ValueKind::Number(number) => places += number,
            _ => return None,
        }
    }
    let places = Some(places).filter(BigRational::is_integer)?.to_integer().to_i64()?;
    Some((index?, places)).filter(|_| (1..=MOST_OPENED).contains(&places))
}

/// Where a factorial of an index stands.
fn used(value: &Written) -> Option<Span> {
    match &value.kind {
        ValueKind::Number(_) | ValueKind::Name(_) => None,
        ValueKind::Sum(parts) | ValueKind::Product(parts) => parts.iter().find_map(|(_, part)| used(part)),
        ValueKind::Power(base, exponent) => used(base).or_else(|| used(exponent)),
        ValueKind::Negative(inner) | ValueKind::Absolute(inner) => used(inner),
        ValueKind::If(_, parts) => parts.iter().find_map(used),
        ValueKind::Vector(parts) => parts.iter().find_map(used),
        ValueKind::Call(name, arguments) => {
            let of_index = |value: &Written| matches!(place_of(value), Some(Index::Name(_)));
            match arguments.as_slice() {
                [Argument { label: None, value: of }] if is_factorial(name) && of_index(of) => Some(value.span),
                all => all.iter().find_map(|argument| used(&argument.value)),
            }
        }
        ValueKind::Iterate(_, arguments) => arguments.iter().find_map(|argument| used(&argument.value)),
        ValueKind::Cases(cases) => {
            cases.iter().find_map(|(value, when)| used(value).or_else(|| when.iter().flat_map(sides_of).find_map(used)))
        }
    }
}
