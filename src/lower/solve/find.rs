//! `find n with …`: what is to hold at the index that is looked for, as one comparison.

use super::super::scope::Lowerer;
use super::super::value::{both, chosen, neither};
use super::Lengths;
use crate::assumption::Assumptions;
use crate::ast::{self, Comparison};
use crate::closed_form::{Recurrence, as_it_stands};
use crate::diagnostic::{Diagnostic, Span};
use crate::name::Name;
use crate::value::{Need, Relation, Sort, Value, ValueError};

/// A comparison of two values.
type Sides = (Relation, Value, Value);

/// What is looked for, and how it was asked where it is another comparison.
pub(super) type Found = (Sides, Option<String>);

impl Lowerer<'_> {
    pub(super) fn find(&mut self, find: &ast::Find, names: &Lengths, recurrence: &Recurrence) -> Option<Found> {
        let index = &recurrence.index;
        if find.index.name != *index {
            let other = &find.index.name;
            return self.fail(
                Diagnostic::error(
                    "P0325",
                    format!("`find` asks for `{other}`, but the index of the sequence is `{index}`"),
                )
                .label(find.index.span, "not the index")
                .help(format!("write `find {index} with …`")),
            );
        }
        let mut all = Vec::new();
        for together in &find.either.0 {
            // It is looked at where none before it holds, and each comparison where all before it hold.
            let fail = neither(&all);
            let mut lowered: Vec<Sides> = Vec::new();
            for one in together {
                let before = fail.as_ref().and_then(|fail| both(fail, &vec![lowered.clone()]));
                lowered.push(self.guarded(before, |lowerer| lowerer.sought(one, names, recurrence))?);
            }
            all.push(lowered);
        }
        if let [together] = all.as_mut_slice()
            && together.len() == 1
        {
            return together.pop().map(|only| (only, None));
        }
        let span = find.either.comparisons().map(|one| one.span).reduce(Span::to)?;
        let text = |together: &Vec<Sides>| together.iter().map(as_it_stands).collect::<Vec<_>>().join(" and ");
        let asked = all.iter().map(text).collect::<Vec<_>>().join(" or ");
        let mut known = self.environment.assumptions.without_name(index);
        self.conditions.iter().for_each(|(relation, left, right)| known.assume(*relation, left, right));
        match as_one(&all, &known) {
            Ok(sought) => Some((sought, Some(asked))),
            Err(error) => self.fail(Diagnostic::error("P0402", error.0).label(span, "in this condition")),
        }
    }

    fn sought(&mut self, one: &Comparison, names: &Lengths, recurrence: &Recurrence) -> Option<Sides> {
        let index = &recurrence.index;
        let mut side = |written: &ast::Value| {
            let value = self.right_side(written, names, (index, recurrence.from), 0)?;
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
        let left = side(&one.left)?;
        let right = side(&one.right)?;
        let ordered = !matches!(one.relation, Relation::Eq | Relation::Neq);
        if left.sort() != right.sort() || (ordered && left.sort() != Sort::Real) {
            let text = match left.sort() == right.sort() {
                true => format!("`{}` does not compare vectors", one.relation.symbol()),
                false => format!("{} is not compared with {}", left.sort(), right.sort()),
            };
            return self.fail(
                Diagnostic::error("P0402", text)
                    .label(one.right.span, format!("{}, and on the left {}", right.sort(), left.sort()))
                    .help("compare vectors of one length by `=` and `!=`, and their lengths by `norm(…) <= …`"),
            );
        }
        Some((one.relation, left, right))
    }
}

/// What is above 0, or at least 0, just where a comparison holds, of vectors by their distance; whether it must be above.
fn excess((relation, left, right): &Sides) -> Result<(Value, bool), ValueError> {
    Ok(match relation {
        Relation::Gtr => (left.sub(right)?, true),
        Relation::Gte => (left.sub(right)?, false),
        Relation::Lss => (right.sub(left)?, true),
        Relation::Lte => (right.sub(left)?, false),
        Relation::Eq => (left.sub(right)?.norm()?.neg()?, false),
        Relation::Neq => (left.sub(right)?.norm()?, true),
    })
}

/// Whether a comparison may have no value at some index, or for some parameters.
fn may_be_undefined((_, left, right): &Sides, known: &Assumptions) -> bool {
    let needs = [left, right].into_iter().flat_map(Value::needs);
    needs.filter(|need| !matches!(need, Need::Natural(_))).any(|need| known.grants(&need) != Some(true))
}

/// How many of these stand before what may be undefined, or one where that is the first of several.
fn before_undefined(undefined: impl Fn(usize) -> bool, count: usize) -> Option<usize> {
    (0..count).find(|place| undefined(*place)).map(|place| place.max(1)).filter(|place| *place < count)
}

/// The same of comparisons that are to hold together: the least excess, and where some must be above 0 and some need not,
/// that of the latter where the former are, and -1 where not. What may be undefined is looked at where those before it
/// hold, and those behind it where it does.
fn together(all: &[Sides], known: &Assumptions) -> Result<(Value, bool), ValueError> {
    if let Some(place) = before_undefined(|place| may_be_undefined(&all[place], known), all.len()) {
        let (rest, strict) = together(&all[place..], known)?;
        return Ok((chosen(&vec![all[..place].to_vec()], &rest, Value::integer(-1))?, strict));
    }
    let each = all.iter().map(excess).collect::<Result<Vec<_>, _>>()?;
    let of = |strict: bool| each.iter().filter(|one| one.1 == strict).map(|one| one.0.clone()).collect::<Vec<_>>();
    let (above, others) = (of(true), of(false));
    if others.is_empty() {
        return Ok((Value::minimum(&above)?, true));
    }
    let mut whole = Value::minimum(&others)?;
    for one in above.iter().rev() {
        whole = Value::choose(Relation::Gtr, one, &Value::zero(), &whole, &Value::integer(-1))?;
    }
    Ok((whole, false))
}

/// Comparisons, of which one is to hold, all of each together, as one comparison. What may be undefined is looked at where
/// none before it holds, and those behind it where it does not.
fn as_one(either: &[Vec<Sides>], known: &Assumptions) -> Result<Sides, ValueError> {
    let undefined = |place: usize| either[place].iter().any(|one| may_be_undefined(one, known));
    if let Some(place) = before_undefined(undefined, either.len()) {
        let (relation, rest, zero) = as_one(&either[place..], known)?;
        return Ok((relation, chosen(&either[..place].to_vec(), &Value::one(), rest)?, zero));
    }
    let each = either.iter().map(|all| together(all, known)).collect::<Result<Vec<_>, _>>()?;
    let strict = each.iter().all(|one| one.1);
    let mut all = Vec::new();
    for (value, above) in each {
        all.push(match above && !strict {
            true => Value::choose(Relation::Gtr, &value, &Value::zero(), &Value::zero(), &Value::integer(-1))?,
            false => value,
        });
    }
    let relation = if strict { Relation::Gtr } else { Relation::Gte };
    Ok((relation, Value::maximum(&all)?, Value::zero()))
}
