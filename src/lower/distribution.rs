//! Distributions: their kinds, and what each must be given.

use super::Class;
use super::scope::Lowerer;
use crate::ast::{Argument, Ident, Value as Written, ValueKind};
use crate::diagnostic::{Diagnostic, Span};
use crate::name::Name;
use crate::value::{Relation, Value, ValueError};

pub(super) const DISTRIBUTIONS: [&str; 6] = ["Normal", "Exp", "Poisson", "Uniform", "Mix", "Point"];

impl Lowerer<'_> {
    /// The distribution that is written here.
    pub(super) fn distribution(&mut self, written: &Written) -> Option<Value> {
        match &written.kind {
            ValueKind::Name(name) => self.name(name, Class::Distribution),
            ValueKind::Call(name, arguments) if name.name.as_str() == "N" => {
                if arguments.get(1).is_none_or(|spread| spread.label.is_none()) {
                    return self.which_spread(name, arguments.len());
                }
                let parts = self.normal(arguments, written.span)?;
                self.valid(Value::distribution("Normal", parts), written.span)
            }
            ValueKind::Call(name, arguments) if DISTRIBUTIONS.contains(&name.name.as_str()) => {
                let parts = match name.name.as_str() {
                    "Normal" => self.normal(arguments, written.span),
                    "Mix" => self.mix(arguments, written.span),
                    kind @ ("Exp" | "Poisson") => self.exact(arguments, &["rate"], kind, written.span),
                    "Uniform" => self.exact(arguments, &["", ""], "Uniform", written.span),
                    _ => self.exact(arguments, &[""], "Point", written.span),
                }?;
                self.valid(Value::distribution(name.name.as_str(), parts), written.span)
            }
            _ => self.fail(
                Diagnostic::error("P0401", "a distribution is needed here")
                    .label(written.span, "this is no distribution")
                    .help("write `Normal(0, sd: s)`, `Exp(rate: l)`, `Poisson(rate: l)`, `Uniform(a, b)`, `Mix(1/2: D, 1/2: E)` or `Point(x)`"),
            ),
        }
    }

    fn which_spread(&mut self, name: &Ident, count: usize) -> Option<Value> {
        let diagnostic = Diagnostic::error(
            "P0308",
            "`N` does not say which spread it means: the standard deviation or the variance",
        )
        .label(name.span, "which of the two?");
        let advice =
            if count == 2 { "write `Normal(m, sd: s)` or `Normal(m, var: v)`" } else { "write `Normal(0, sd: s)`" };
        self.fail(diagnostic.help(advice))
    }

    fn wrong_arguments<T>(&mut self, kind: &str, span: Span) -> Option<T> {
        self.fail(
            Diagnostic::error("P0309", format!("these are not the arguments of `{kind}`"))
                .label(span, "here")
                .help(example(kind)),
        )
    }

    fn normal(&mut self, arguments: &[Argument], span: Span) -> Option<Vec<Value>> {
        let [mean, spread] = arguments else {
            return self.wrong_arguments("Normal", span);
        };
        if mean.label.is_some() {
            return self.wrong_arguments("Normal", span);
        }
        let label = spread.label.as_ref().and_then(labelled);
        let mean = self.number(&mean.value);
        let value = self.number(&spread.value)?;
        match label {
            Some("sd") if self.negative(&value) => self.fail(
                Diagnostic::error("P0407", format!("a standard deviation cannot be {value}"))
                    .label(spread.value.span, "this is negative")
                    .help("a spread is 0 or more"),
            ),
            Some("sd") => {
                let variance = self.variance(&value);
                Some(vec![mean?, self.valid(variance, spread.value.span)?])
            }
            Some("var") => Some(vec![mean?, value]),
            _ => self.fail(
                Diagnostic::error("P0308", "a normal distribution must say which spread it means")
                    .label(spread.value.span, "the standard deviation or the variance?")
                    .help("write `Normal(0, sd: s)` or `Normal(0, var: v)`"),
            ),
        }
    }

    /// The square of a standard deviation. One that may change its sign as the process runs is not made positive by it:
    /// `s*abs(s)` is negative where s is, and then there is no such distribution.
    fn variance(&self, spread: &Value) -> Result<Value, ValueError> {
        let changes = |name: &Name| {
            let own = self.locals.contains_key(name) || self.results.contains_key(name);
            own || self.apart.values().any(|renamed| renamed == name)
        };
        let sign = self.environment.assumptions.decide(Relation::Gte, spread, &Value::zero());
        if sign != Some(true) && spread.variables().iter().any(changes) {
            return spread.mul(&spread.abs()?);
        }
        spread.mul(spread)
    }

    fn negative(&self, value: &Value) -> bool {
        self.environment.assumptions.decide(Relation::Lss, value, &Value::zero()) == Some(true)
    }

    fn exact(&mut self, arguments: &[Argument], labels: &[&str], kind: &str, span: Span) -> Option<Vec<Value>> {
        let fits = |argument: &Argument, label: &str| argument.label.as_ref().map_or(Some(""), labelled) == Some(label);
        if arguments.len() != labels.len()
            || !arguments.iter().zip(labels).all(|(argument, label)| fits(argument, label))
        {
            return self.wrong_arguments(kind, span);
        }
        let values: Vec<_> = arguments.iter().map(|argument| self.number(&argument.value)).collect();
        values.into_iter().collect()
    }

    fn mix(&mut self, arguments: &[Argument], span: Span) -> Option<Vec<Value>> {
        let mut parts = Vec::new();
        for argument in arguments {
            let Some(weight) = &argument.label else {
                return self.wrong_arguments("Mix", span);
            };
            let weight = self.number(weight);
            let part = self.distribution(&argument.value)?;
            parts.extend([weight?, part]);
        }
        if parts.is_empty() { self.wrong_arguments("Mix", span) } else { Some(parts) }
    }
}

fn labelled(label: &Written) -> Option<&str> {
    match &label.kind {
        ValueKind::Name(name) => Some(name.name.as_str()),
        _ => None,
    }
}

pub(super) fn example(kind: &str) -> &'static str {
    match kind {
        "Normal" => "write `Normal(0, sd: s)` or `Normal(0, var: v)`",
        "Exp" => "write `Exp(rate: l)`",
        "Poisson" => "write `Poisson(rate: l)`, the arrivals expected at each draw",
        "Uniform" => "write `Uniform(a, b)`",
        "Mix" => "write `Mix(1/3: D, 2/3: E)`, the weights before the colons",
        _ => "write `Point(x)`",
    }
}
