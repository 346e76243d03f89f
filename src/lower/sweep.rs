//! Parameters that run through values.

use std::collections::BTreeSet;
use std::sync::Arc;

use num_rational::BigRational;
use num_traits::Signed;

use super::scope::Lowerer;
use crate::ast::{self, AxisKind, SweepQuestion};
use crate::diagnostic::{Diagnostic, Span};
use crate::name::Name;

/// The points of one axis of a sweep, at most.
pub const MOST_POINTS: usize = 100_000;

/// Parameters that run through values.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// Each parameter with its values, in order.
    pub axes: Vec<(Name, Vec<BigRational>)>,
    /// As written: what is asked at each point.
    pub written: Arc<ast::Sweep>,
    /// The text in which it is written.
    pub text: String,
}

impl Sweep {
    /// How many points there are.
    pub fn points(&self) -> usize {
        self.axes.iter().map(|(_, values)| values.len()).product()
    }

    /// The values at one point; the last axis runs fastest.
    pub fn point(&self, index: usize) -> Vec<(Name, BigRational)> {
        let mut rest = index;
        let mut point = Vec::new();
        for (name, values) in self.axes.iter().rev() {
            if let Some(value) = values.get(rest % values.len().max(1)) {
                point.push((name.clone(), value.clone()));
            }
            rest /= values.len().max(1);
        }
        point.reverse();
        point
    }
}

impl Lowerer<'_> {
    pub(super) fn sweep(&mut self, written: &Arc<ast::Sweep>, text: &str) -> Option<Sweep> {
        let axes = self.axes(written)?;
        let count = axes.iter().try_fold(1usize, |count, (_, values)| count.checked_mul(values.len()));
        if count.is_none_or(|count| count > MOST_POINTS) {
            let span = written.axes.first().map_or(Span::new(0, 0), |(ident, _)| ident.span);
            return self.fail(
                Diagnostic::error("P0415", format!("more than {MOST_POINTS} points")).label(span, "in this sweep"),
            );
        }
        if written.questions.is_empty() {
            let span = written.axes.first().map_or(Span::new(0, 0), |(ident, _)| ident.span);
            return self.fail(
                Diagnostic::error("P0415", "this sweep asks nothing")
                    .label(span, "what is to be asked at each point?")
                    .help("name criteria, or write `prove …` or `probability …` between the braces"),
            );
        }
        self.questions(written, text)?;
        Some(Sweep { axes, written: written.clone(), text: text.to_string() })
    }

    fn axis(&mut self, kind: &AxisKind, place: Span) -> Option<Vec<BigRational>> {
        let mut exact = |value: &ast::Value| -> Option<BigRational> {
            let lowered = self.number(value)?;
            match lowered.as_rational() {
                Some(number) => Some(number),
                None => self.no_number(value.span, &lowered),
            }
        };
        let values = match kind {
            AxisKind::List(values) => {
                let all = values.iter().map(&mut exact).collect::<Option<Vec<_>>>()?;
                // A value that is written twice is one point.
                let mut seen = BTreeSet::new();
                all.into_iter().filter(|value| seen.insert(value.clone())).collect()
            }
            AxisKind::Range(parts) => {
                let [low, high, step] = parts.as_ref();
                let (first, last, by) = (exact(low)?, exact(high)?, exact(step)?);
                if !by.is_positive() {
                    return self.fail(
                        Diagnostic::error("P0415", "a step of a sweep is more than 0").label(step.span, "this step"),
                    );
                }
                let count = ((&last - &first) / &by).floor();
                if count > BigRational::from_integer(MOST_POINTS.into()) {
                    return self.fail(
                        Diagnostic::error("P0415", format!("more than {MOST_POINTS} points"))
                            .label(low.span.to(step.span), "in this range"),
                    );
                }
                if last < first {
                    let text = format!("{} comes after {}: a range goes from the less to the greater", first, last);
                    return self.fail(Diagnostic::error("P0415", text).label(low.span.to(high.span), "in this range"));
                }
                let mut values = Vec::new();
                let mut value = first;
                while value <= last {
                    values.push(value.clone());
                    value += &by;
                }
                values
            }
        };
        if values.is_empty() {
            return self.fail(Diagnostic::error("P0415", "there is no value here").label(place, "in this range"));
        }
        Some(values)
    }

    fn axes(&mut self, written: &ast::Sweep) -> Option<Vec<(Name, Vec<BigRational>)>> {
        let mut axes: Vec<(Name, Vec<BigRational>)> = Vec::new();
        for (ident, kind) in &written.axes {
            if axes.iter().any(|(name, _)| *name == ident.name) {
                return self.fail(
                    Diagnostic::error("P0319", format!("`{}` is swept twice", ident.name))
                        .label(ident.span, "again here"),
                );
            }
            match self.environment.quantity(&ident.name) {
                Some(super::Quantity::Parameter { class: super::Class::Number, constant: Some(_) }) => {}
                Some(super::Quantity::Parameter { .. }) => {
                    return self.fail(
                        Diagnostic::error("P0414", format!("`{}` has no value that could be varied", ident.name))
                            .label(ident.span, "this parameter")
                            .help(format!("give it one: `param {} = 1`", ident.name)),
                    );
                }
                _ => {
                    let known = self.environment.quantities().filter_map(|(name, quantity)| {
                        matches!(quantity, super::Quantity::Parameter { .. }).then_some(name.as_str())
                    });
                    let known: Vec<&str> = known.collect();
                    let advice = format!("declare it: `param {} = 1`", ident.name);
                    self.unknown("P0414", "parameter", ident, known.into_iter(), &advice);
                    return None;
                }
            }
            axes.push((ident.name.clone(), self.axis(kind, ident.span)?));
        }
        Some(axes)
    }

    fn questions(&mut self, written: &ast::Sweep, text: &str) -> Option<()> {
        for question in &written.questions {
            match question {
                SweepQuestion::Criteria(ident) if self.environment.criteria_of(&ident.name).is_none() => {
                    let known: Vec<&str> = self.environment.criteria_names().map(Name::as_str).collect();
                    self.unknown(
                        "P0318",
                        "criteria",
                        ident,
                        known.into_iter(),
                        "declare them: `criteria C for Sys { … }`",
                    );
                    return None;
                }
                SweepQuestion::Criteria(_) => {}
                SweepQuestion::Item(item) => match self.environment.lower_item(item, text) {
                    Ok(_) => {}
                    Err(errors) => {
                        self.errors.extend(errors);
                        return None;
                    }
                },
            }
        }
        Some(())
    }
}
