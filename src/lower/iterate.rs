//! `f^n(p)`, `f^m o f^n(p)`, and `{x if a < b; y if a >= b}`.

use num_traits::ToPrimitive;

use super::Quantity;
use super::scope::Lowerer;
use crate::ast::{Argument, Ident, Value as Written, ValueKind};
use crate::diagnostic::{Diagnostic, Span};
use crate::name::Name;
use crate::value::{Relation, Value, ValueError};

/// A function is applied at most so often one by one.
const MOST_ROUNDS: u32 = 1_000;

impl Lowerer<'_> {
    /// Functions applied one after the other, the last of the chain first.
    pub(super) fn iterated(
        &mut self,
        chain: &[(Ident, Option<Written>)],
        arguments: &[Argument],
        span: Span,
    ) -> Option<Value> {
        if let ([(name, Some(count))], false) = (chain, chain.iter().all(|(name, _)| self.is_function(name))) {
            return self.power_of_call(name, count, arguments, span);
        }
        if chain.iter().any(|(name, _)| self.hides(name)) {
            return None;
        }
        let [argument] = arguments else {
            return self.fail(
                Diagnostic::error("P0305", "a function that is applied again and again takes 1 argument")
                    .label(span, "in this value"),
            );
        };
        let mut value = self.number(&argument.value);
        for (name, count) in chain.iter().rev() {
            let count = match count {
                Some(count) => self.number(count)?,
                None => Value::integer(1),
            };
            value = self.rounds(name, &count, value?, span);
        }
        value
    }

    fn is_function(&self, name: &Ident) -> bool {
        matches!(self.environment.quantity(&name.name), Some(Quantity::Function { .. }))
    }

    /// `x^2(a+b)` and `x^g(y)`, where x is a value.
    fn power_of_call(&mut self, name: &Ident, count: &Written, arguments: &[Argument], span: Span) -> Option<Value> {
        let written = |kind| Written { span, kind };
        let base = written(ValueKind::Name(name.clone()));
        match (&count.kind, arguments) {
            (ValueKind::Name(called), _) if self.is_function(called) => {
                let exponent = written(ValueKind::Call(called.clone(), arguments.to_vec()));
                self.number(&written(ValueKind::Power(Box::new(base), Box::new(exponent))))
            }
            (ValueKind::Number(_), [Argument { label: None, value }]) => {
                let power = written(ValueKind::Power(Box::new(base), Box::new(count.clone())));
                self.number(&written(ValueKind::Product(vec![(false, power), (false, value.clone())])))
            }
            _ => self.unknown_function(name),
        }
    }

    /// This function applied so often.
    fn rounds(&mut self, name: &Ident, count: &Value, start: Value, span: Span) -> Option<Value> {
        let number = count.as_rational();
        let whole =
            number.as_ref().filter(|number| number.is_integer()).and_then(|number| number.to_integer().to_u32());
        if let Some(times) = whole.filter(|times| *times <= MOST_ROUNDS) {
            return (0..times).try_fold(start, |value, _| self.applied(name, vec![value], (span, span)));
        }
        if number.is_some() && whole.is_none() {
            return self.fail(
                Diagnostic::error("P0404", format!("`{}` cannot be applied {count} times", name.name))
                    .label(span, "in this value")
                    .help("the number behind `^` must be 0, 1, 2, …"),
            );
        }
        match self.closed(&name.name, count, &start) {
            Some((factor, _)) if factor.has_sign() && !self.counts(count) => self.no_count(count, span),
            Some((_, Ok(value))) => Some(value),
            Some((_, Err(ValueError(text)))) => {
                self.fail(Diagnostic::error("P0402", text).label(span, "in this value"))
            }
            None => self.fail(
                Diagnostic::error("P0402", format!("no form is known for `{}` applied `{count}` times", name.name))
                    .label(span, "in this value")
                    .note("one is known where f(x) = k*x + c with numbers, or parameters of which it is known whether k is 0 or 1")
                    .help(format!("ask `solve x(n+1) = {}(x(n)), x(0) = …`, or write a number for `{count}`", name.name)),
            ),
        }
    }

    /// Of f(x) = k*x + c the factor k and the n-th round: `x + n*c` where k is 1, else `e + k^n*(x - e)` with the
    /// fixed point e.
    fn closed(&self, name: &Name, count: &Value, start: &Value) -> Option<(Value, Result<Value, ValueError>)> {
        let Some(Quantity::Function { parameters, body: Some(body) }) = self.environment.quantity(name) else {
            return None;
        };
        let [parameter] = parameters.as_slice() else { return None };
        let (factor, constant) = body.linear_in(parameter)?;
        if factor.mentions(parameter) || constant.mentions(parameter) {
            return None;
        }
        let (zero, one) = (Value::zero(), Value::integer(1));
        let known = self.environment.assumptions.without_name(parameter);
        let is = |value: &Value, what: &Value| known.decide(Relation::Eq, value, what);
        if is(&factor, &one)? {
            return Some((one, count.mul(&constant).and_then(|steps| start.add(&steps))));
        }
        if is(&factor, &zero)? {
            return Some((zero.clone(), Value::choose(Relation::Eq, count, &zero, start, &constant)));
        }
        let form = || {
            let fixed = constant.div(&one.sub(&factor)?)?;
            fixed.add(&factor.power(count)?.mul(&start.sub(&fixed)?)?)
        };
        let form = form();
        Some((factor, form))
    }
}
