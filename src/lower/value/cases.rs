//! Values that are chosen by comparisons: `{x if a <= b < c; y otherwise}`.

use super::super::scope::Lowerer;
use super::guards::{Ways, both, neither};
use crate::assumption::Assumptions;
use crate::ast::{Either, Value as Written};
use crate::closed_form::Comparison;
use crate::diagnostic::{Diagnostic, Span};
use crate::value::{Value, ValueError};

/// The most ways in which earlier cases may fail that are looked at.
const MOST_WAYS: usize = 64;

impl Lowerer<'_> {
    /// The first case that holds; the last one must be sure where the others fail.
    pub(super) fn cases(&mut self, cases: &[(Written, Option<Either>)], span: Span) -> Option<Value> {
        let mut lowered = Vec::new();
        // The ways in which the cases before fail.
        let mut rest = Some(vec![Vec::new()]);
        for (value, either) in cases {
            let either = match either {
                Some(either) => Some(self.where_holds(rest.clone(), |lowerer| lowerer.either(either))?),
                None => None,
            };
            let here = either.as_ref().map_or(rest.clone(), |either| rest.as_ref().and_then(|rest| both(rest, either)));
            let value = self.where_holds(here, |lowerer| lowerer.number(value));
            rest = rest.zip(either.as_ref().and_then(neither)).and_then(|(rest, fails)| both(&rest, &fails));
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

    fn either(&mut self, either: &Either) -> Option<Ways> {
        let mut all = Vec::new();
        for together in &either.0 {
            // It is looked at where none before it holds, and each comparison where all before it hold.
            let fail = neither(&all);
            let mut lowered = Vec::new();
            for one in together {
                let before = fail.as_ref().and_then(|fail| both(fail, &vec![lowered.clone()]));
                let sides = |lowerer: &mut Self| Some((lowerer.number(&one.left)?, lowerer.number(&one.right)?));
                let (left, right) = self.where_holds(before, sides)?;
                lowered.push((one.relation, left, right));
            }
            all.push(lowered);
        }
        Some(all)
    }
}

/// The value where one of these holds, and another where none does.
pub(in crate::lower) fn chosen(either: &Ways, value: &Value, otherwise: Value) -> Result<Value, ValueError> {
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
fn is_sure(last: &Ways, earlier: &[(Value, Option<Ways>)], known: Assumptions) -> bool {
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
