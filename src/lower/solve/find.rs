//! `find n with …`: what is to hold at the index that is looked for, as one comparison.

use std::collections::{BTreeMap, BTreeSet};

use num_traits::ToPrimitive;

use super::super::scope::Lowerer;
use super::super::value::{both, chosen, neither};
use super::Lengths;
use crate::assumption::Assumptions;
use crate::ast::{self, Comparison};
use crate::closed_form::{Recurrence, Sequence, as_it_stands};
use crate::diagnostic::{Diagnostic, Span};
use crate::name::Name;
use crate::value::{Need, Relation, Sort, Value, ValueError};

/// A comparison of two values.
type Sides = (Relation, Value, Value);

/// What is looked for.
pub(super) struct Found {
    pub(super) sought: Sides,
    /// Where one of several is to hold, each of these by itself.
    pub(super) either: Vec<Sides>,
    /// Where several are to hold together, each of these by itself.
    pub(super) together: Vec<Sides>,
    /// Where it is to hold from a number on, that number, and what is to hold there.
    pub(super) since: Option<(i64, Sides)>,
    /// How it was asked, where it is another comparison.
    pub(super) asked: Option<String>,
}

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
            let (either, together) = (Vec::new(), std::mem::take(together));
            let sought = together.first()?.clone();
            return Some(Found { sought, either, together: Vec::new(), since: None, asked: None });
        }
        let span = find.either.comparisons().map(|one| one.span).reduce(Span::to)?;
        let text = |together: &Vec<Sides>| together.iter().map(as_it_stands).collect::<Vec<_>>().join(" and ");
        let asked = all.iter().map(text).collect::<Vec<_>>().join(" or ");
        let mut known = self.environment.assumptions.without_name(index);
        let always = self.conditions.iter().filter(|one| one.ways.is_none()).map(|one| &one.comparison);
        always.for_each(|(relation, left, right)| known.assume(*relation, left, right));
        let open = recurrence.terms().into_iter().map(|(name, ..)| name).chain([index.clone()]).collect();
        let told = Told { known, open };
        let each = |together: &Vec<Sides>| match together.as_slice() {
            [only] => Ok(only.clone()),
            _ => as_one(std::slice::from_ref(together), &told),
        };
        let either = if all.len() > 1 { all.iter().map(each).collect() } else { Ok(Vec::new()) };
        match as_one(&all, &told).and_then(|sought| Ok((sought, either?))) {
            Ok((sought, either)) => {
                let since = since(&all, index, &told);
                // Each has a value by itself.
                let plain = |all: &&[Vec<Sides>]| !all.iter().flatten().any(|one| told.may_be_undefined(one));
                let together = match Some(all.as_slice()).filter(plain) {
                    Some([together]) => together.clone(),
                    _ => Vec::new(),
                };
                Some(Found { sought, either, together, since, asked: Some(asked) })
            }
            Err(error) => self.fail(Diagnostic::error("P0402", error.0).label(span, "in this condition")),
        }
    }

    fn sought(&mut self, one: &Comparison, names: &Lengths, recurrence: &Recurrence) -> Option<Sides> {
        let index = &recurrence.index;
        let mut side = |written: &ast::Value| {
            let value = self.right_side(written, names, (index, recurrence.from), 0)?;
            let value = in_terms_at_hand(&value, recurrence);
            let value = self.checked(value, written.span)?;
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

/// A value with the terms that the equations make, `x(n+1)` of `x(n+1) = x(n)/2+1`, as they make them.
fn in_terms_at_hand(value: &Value, recurrence: &Recurrence) -> Result<Value, ValueError> {
    let mut value = value.clone();
    for _ in 0..MOST_AHEAD {
        let made = |sequence: &&Sequence| {
            let order = sequence.start.len();
            (order..order + MOST_AHEAD).rev().find(|offset| value.mentions(&recurrence.term(&sequence.name, *offset)))
        };
        let latest = recurrence
            .sequences
            .iter()
            .filter_map(|sequence| Some((made(&sequence)? - sequence.start.len(), sequence)));
        let Some((ahead, sequence)) = latest.max_by_key(|(ahead, _)| *ahead) else { break };
        let mut images = BTreeMap::new();
        for (name, place, offset) in recurrence.terms() {
            images.insert(name, Value::variable(&recurrence.term(&recurrence.sequences[place].name, offset + ahead)));
        }
        let index = Value::variable(&recurrence.index);
        images.insert(recurrence.index.clone(), index.add(&Value::integer(i64::try_from(ahead).unwrap_or(i64::MAX)))?);
        let next = sequence.next.substitute(&images)?;
        value = value.with(&recurrence.term(&sequence.name, sequence.start.len() + ahead), &next)?;
    }
    Ok(value)
}

/// The most steps ahead that a goal may look, and that are put in.
const MOST_AHEAD: usize = 64;

/// Of one comparison that is to hold from a number on, that number: `r(n) = 0 and n > 2`. What may be undefined is looked
/// at where what stands before it holds, and so from the first index on where nothing does.
fn since(all: &[Vec<Sides>], index: &Name, told: &Told) -> Option<(i64, Sides)> {
    let [together] = all else { return None };
    let least = |(relation, left, right): &Sides| {
        let bound = right.as_rational().filter(|_| *left == Value::variable(index))?;
        let bound = match relation {
            Relation::Gtr => bound.floor().to_integer() + 1,
            Relation::Gte => bound.ceil().to_integer(),
            _ => return None,
        };
        bound.to_i64().filter(|bound| (1..=MOST_SINCE).contains(bound))
    };
    let (mut first, mut others) = (None, Vec::new());
    for one in together {
        match least(one) {
            Some(bound) => first = first.max(Some(bound)),
            None if first.is_none() && told.may_be_undefined(one) => return None,
            None => others.push(one),
        }
    }
    let [only] = others.as_slice() else { return None };
    Some((first?, (*only).clone()))
}

/// The latest number from which something is to hold.
const MOST_SINCE: i64 = 1_000;

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

/// The most comparisons of parameters alone that are conditions of their own.
const MOST_CONDITIONS: usize = 3;

/// What is known of the parameters, and the names that are none: the index and the terms.
struct Told {
    known: Assumptions,
    open: BTreeSet<Name>,
}

impl Told {
    /// Whether a comparison may have no value at some index, or for some parameters.
    fn may_be_undefined(&self, (_, left, right): &Sides) -> bool {
        let needs = [left, right].into_iter().flat_map(Value::needs);
        needs.filter(|need| !matches!(need, Need::Natural(_))).any(|need| self.known.grants(&need) != Some(true))
    }

    /// Whether it holds at every index or at none.
    fn of_parameters(&self, (_, left, right): &Sides) -> bool {
        let real = left.sort() == Sort::Real && right.sort() == Sort::Real;
        real && [left, right].iter().all(|side| side.variables().is_disjoint(&self.open))
    }
}

/// How many of these stand before what may be undefined, or one where that is the first of several.
fn before_undefined(undefined: impl Fn(usize) -> bool, count: usize) -> Option<usize> {
    (0..count).find(|place| undefined(*place)).map(|place| place.max(1)).filter(|place| *place < count)
}

/// The same of comparisons that are to hold together: the least excess, and where some must be above 0 and some need not,
/// that of the latter where the former are, and -1 where not. What may be undefined is looked at where those before it
/// hold, and those behind it where it does; those of parameters alone are conditions, of which each case is told.
fn together(all: &[Sides], told: &Told) -> Result<(Value, bool), ValueError> {
    if let Some(place) = before_undefined(|place| told.may_be_undefined(&all[place]), all.len()) {
        let (rest, strict) = together(&all[place..], told)?;
        return Ok((chosen(&vec![all[..place].to_vec()], &rest, Value::integer(-1))?, strict));
    }
    let (conditions, others): (Vec<_>, Vec<_>) = all.iter().cloned().partition(|one| told.of_parameters(one));
    if !conditions.is_empty() && conditions.len() <= MOST_CONDITIONS {
        let (rest, strict) = if others.is_empty() { (Value::one(), true) } else { least(&others)? };
        return Ok((chosen(&vec![conditions], &rest, Value::integer(-1))?, strict));
    }
    least(all)
}

/// The same where each of them has a value.
fn least(all: &[Sides]) -> Result<(Value, bool), ValueError> {
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
fn as_one(either: &[Vec<Sides>], told: &Told) -> Result<Sides, ValueError> {
    let undefined = |place: usize| either[place].iter().any(|one| told.may_be_undefined(one));
    if let Some(place) = before_undefined(undefined, either.len()) {
        let (relation, rest, zero) = as_one(&either[place..], told)?;
        return Ok((relation, chosen(&either[..place].to_vec(), &Value::one(), rest)?, zero));
    }
    let each = either.iter().map(|all| together(all, told)).collect::<Result<Vec<_>, _>>()?;
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
