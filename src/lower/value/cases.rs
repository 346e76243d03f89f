//! Values that are chosen by comparisons: `{x if a <= b < c; y otherwise}`.

use super::super::scope::Lowerer;
use crate::assumption::Assumptions;
use crate::ast::{Either, Value as Written};
use crate::closed_form::Comparison;
use crate::diagnostic::{Diagnostic, Span};
use crate::value::{Value, ValueError};

/// The most ways in which earlier cases may fail that are looked at.
const MOST_WAYS: usize = 64;

/// Comparisons of which one holds, all of each together.
type Lowered = Vec<Vec<Comparison>>;

impl Lowerer<'_> {
    /// The first case that holds; the last one must be sure where the others fail.
    pub(super) fn cases(&mut self, cases: &[(Written, Option<Either>)], span: Span) -> Option<Value> {
        let mut lowered = Vec::new();
        for (value, either) in cases {
            let value = self.number(value);
            let either = match either {
                Some(either) => Some(self.either(either)?),
                None => None,
            };
            lowered.push((value?, either));
        }
        let (last, either) = lowered.pop()?;
        let known = self.environment.assumptions.without(&self.locals.keys().cloned().collect());
        if let Some(either) = either
            && !is_sure(&either, &lowered, known)
        {
            return self.fail(
                Diagnostic::error("P0402", "it is not known that one of these cases always holds")
                    .label(span, "no value where none of them holds")
                    .help("end the last case with `otherwise` in place of its condition"),
            );
        }
        let mut whole = last;
        for (value, either) in lowered.into_iter().rev() {
            match chosen(&either?, &value, whole) {
                Ok(next) => whole = next,
                Err(ValueError(text)) => {
                    return self.fail(Diagnostic::error("P0402", text).label(span, "in this value"));
                }
            }
        }
        Some(whole)
    }

    fn either(&mut self, either: &Either) -> Option<Lowered> {
        let mut all = Vec::new();
        for together in &either.0 {
            let mut lowered = Vec::new();
            for one in together {
                lowered.push((one.relation, self.number(&one.left)?, self.number(&one.right)?));
            }
            all.push(lowered);
        }
        Some(all)
    }
}

/// The value where one of these holds, and another where none does.
fn chosen(either: &Lowered, value: &Value, otherwise: Value) -> Result<Value, ValueError> {
    let mut whole = otherwise;
    for together in either.iter().rev() {
        let mut inner = value.clone();
        for (relation, left, right) in together.iter().rev() {
            inner = Value::choose(*relation, left, right, &inner, &whole)?;
        }
        whole = inner;
    }
    Ok(whole)
}

/// Whether one of these holds in each way in which all earlier cases fail.
fn is_sure(last: &Lowered, earlier: &[(Value, Option<Lowered>)], known: Assumptions) -> bool {
    let mut ways = vec![known];
    for together in earlier.iter().filter_map(|(_, either)| either.as_ref()).flatten() {
        let mut next = Vec::new();
        for way in &ways {
            for (relation, left, right) in together {
                let mut way = way.clone();
                way.assume(relation.negated(), left, right);
                if !way.contradictory() {
                    next.push(way);
                }
            }
        }
        if next.len() > MOST_WAYS {
            return false;
        }
        ways = next;
    }
    ways.iter().all(|way| {
        let holds = |(relation, left, right): &Comparison| way.decide(*relation, left, right) == Some(true);
        last.iter().any(|together| together.iter().all(holds))
    })
}
