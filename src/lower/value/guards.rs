//! Under which conditions what a value needs is needed: `if n > 5 then 1/(n-5) else 0` divides by n-5 where n > 5.

use std::collections::{BTreeMap, BTreeSet};

use num_traits::{Signed, Zero};

use super::super::scope::Lowerer;
use crate::assumption::Assumptions;
use crate::ast::Value as Written;
use crate::closed_form::{Case, Comparison, in_cases};
use crate::diagnostic::Span;
use crate::name::Name;
use crate::value::{Atom, Need, Relation, Value, ValueError};

/// The most ways in which conditions around a value come to hold that are told apart.
const MOST_WAYS: usize = 16;

/// Comparisons of which one row holds, all of each row together.
pub type Ways = Vec<Vec<Comparison>>;

/// What a value needs as it is written.
#[derive(Clone, Debug)]
pub(in crate::lower) struct Needed {
    pub(in crate::lower) need: Need,
    /// Where that is written.
    pub(in crate::lower) span: Span,
    /// The ways in which the conditions around it come to hold; none where they are not told apart.
    pub(in crate::lower) guards: Option<Ways>,
}

/// What must hold of parameters for a part of the equations to mean something.
#[derive(Clone, Debug)]
pub struct Requirement {
    /// What must hold.
    pub comparison: Comparison,
    /// The ways in which that part comes to be asked for, what they say of parameters; none where it may always be.
    pub ways: Option<Ways>,
}

impl Lowerer<'_> {
    /// `if a < b then x else y`
    pub(super) fn choice(&mut self, relation: Relation, parts: &[Written; 4]) -> Option<Result<Value, ValueError>> {
        let [left, right, then, other] = parts;
        let sides = (self.number(left), self.number(right));
        let guard = |relation: Relation| match &sides {
            (Some(left), Some(right)) => Some(vec![vec![(relation, left.clone(), right.clone())]]),
            _ => None,
        };
        let then = self.where_holds(guard(relation), |lowerer| lowerer.number(then));
        let other = self.where_holds(guard(relation.negated()), |lowerer| lowerer.number(other));
        let (left, right) = (sides.0?, sides.1?);
        Some(Value::choose(relation, &left, &right, &then?, &other?))
    }

    /// Keeps what a power needs: that its exponent counts, and that its base is not 0 where that may be negative.
    pub(super) fn needs_of_power(&mut self, base: &Value, exponent: &Value, span: Span) {
        let number = exponent.as_rational();
        if number.is_none() {
            self.needs(Need::Natural(exponent.clone()), span);
        }
        let divides = number.is_some_and(|number| number.is_negative()) || exponent.may_be_negative();
        if divides && base.as_rational().is_none_or(|base| base.is_zero()) {
            self.needs(Need::Nonzero(base.clone()), span);
        }
    }

    /// Keeps what the body of a function needs with these arguments, where its own conditions ask for it.
    pub(super) fn needs_of_body(&mut self, body: &Value, images: &BTreeMap<Name, Value>, span: Span) {
        let Some(needed) = &mut self.needed else { return };
        let around = self.guards.as_ref();
        let mut keep = |needs: BTreeSet<Need>, assumed: Option<Vec<Comparison>>| {
            let guards = around.zip(assumed).and_then(|(around, assumed)| both(around, &vec![assumed]));
            let needs = needs.into_iter().filter_map(|need| need.substitute(images).ok());
            needed.extend(needs.map(|need| Needed { need, span, guards: guards.clone() }));
        };
        let Ok(cases) = in_cases(body, images, &self.environment.assumptions) else { return keep(body.needs(), None) };
        for Case { assumed, value, asked, .. } in cases {
            for asked in asked {
                keep(BTreeSet::from([asked.need]), Some(asked.assumed));
            }
            let chosen = value.atoms().iter().any(|atom| matches!(atom, Atom::Positive(_)));
            keep(value.needs(), Some(assumed).filter(|_| !chosen));
        }
    }

    /// Reads what is asked for only where one of these holds.
    pub(super) fn where_holds<T>(&mut self, ways: Option<Ways>, read: impl FnOnce(&mut Self) -> T) -> T {
        if self.needed.is_none() { read(self) } else { self.guarded(ways, read) }
    }

    /// The same where what values need is kept within `read` alone, as of each side of what is looked for.
    pub(in crate::lower) fn guarded<T>(&mut self, ways: Option<Ways>, read: impl FnOnce(&mut Self) -> T) -> T {
        let around = self.guards.clone();
        self.guards = around.as_ref().zip(ways).and_then(|(around, ways)| both(around, &ways));
        let result = read(self);
        self.guards = around;
        result
    }
}

/// The ways in which both hold; none where they are too many.
pub(in crate::lower) fn both(one: &Ways, other: &Ways) -> Option<Ways> {
    if one.len().saturating_mul(other.len()) > MOST_WAYS {
        return None;
    }
    Some(one.iter().flat_map(|left| other.iter().map(|right| [left.as_slice(), right].concat())).collect())
}

/// The ways in which none of these holds; none where they are too many.
pub(in crate::lower) fn neither(either: &Ways) -> Option<Ways> {
    let contrary = |one: &Comparison| vec![(one.0.negated(), one.1.clone(), one.2.clone())];
    either.iter().try_fold(vec![Vec::new()], |ways, together| both(&ways, &together.iter().map(contrary).collect()))
}

/// Whether what is needed holds wherever the conditions around it do.
pub(in crate::lower) fn behind_guards(need: &Need, guards: Option<&Ways>, known: &Assumptions) -> bool {
    guards.is_some_and(|ways| ways.iter().all(|way| granted(need, way, known, &BTreeSet::new())))
}

/// The same in one way, and where other needs hold.
fn granted(need: &Need, way: &[Comparison], known: &Assumptions, needs: &BTreeSet<Need>) -> bool {
    if need.follows_from(needs) {
        return true;
    }
    let mut known = known.clone();
    way.iter().for_each(|(relation, left, right)| known.assume(*relation, left, right));
    if known.contradictory() || known.grants(need) == Some(true) {
        return true;
    }
    // The length of a choice is that of what is chosen here: `norm(if k = 0 then a else b)`.
    let simple = match need {
        Need::Nonzero(value) => Need::Nonzero(known.simplify(value)),
        Need::Nonnegative(value) => Need::Nonnegative(known.simplify(value)),
        Need::Natural(_) => return false,
    };
    simple != *need && (simple.follows_from(needs) || known.grants(&simple) == Some(true))
}

/// What a value needs in each of its cases.
pub(in crate::lower) struct Kept {
    /// What it needs in some case.
    all: BTreeSet<Need>,
    /// Of each component, what is known in a case, and what is needed there.
    components: Vec<Vec<(Assumptions, BTreeSet<Need>)>>,
}

impl Kept {
    pub(in crate::lower) fn of(value: &Value, known: &Assumptions) -> Kept {
        let components = value.components().unwrap_or_else(|| vec![value.clone()]);
        let in_each_case = |value: &Value| match in_cases(value, &BTreeMap::new(), known) {
            Ok(cases) => cases
                .into_iter()
                .map(|case| {
                    let asked = case.asked.into_iter().map(|asked| asked.need);
                    (case.known, case.value.needs().into_iter().chain(asked).collect())
                })
                .collect(),
            Err(_) => vec![(known.clone(), value.needs())],
        };
        Kept { all: value.needs(), components: components.iter().map(in_each_case).collect() }
    }

    /// The same of a choice, `norm(if k = 0 then a else b)`: of each that may be chosen.
    fn has_in_cases(&self, need: &Need) -> bool {
        let Need::Nonzero(value) = need else { return false };
        let kept = |value: Value| {
            let own = Need::Nonzero(value);
            own.follows_from(&self.all) || Assumptions::default().grants(&own) == Some(true)
        };
        value.choices().is_some_and(|choices| choices.len() > 1 && choices.into_iter().all(kept))
    }

    /// Whether it has no value wherever the conditions around a part hold, and what that needs does not.
    pub(in crate::lower) fn has(&self, need: &Need, guards: Option<&Ways>) -> bool {
        let Some(ways) = guards else { return need.follows_from(&self.all) || self.has_in_cases(need) };
        self.components
            .iter()
            .any(|cases| cases.iter().all(|(known, needs)| ways.iter().all(|way| granted(need, way, known, needs))))
    }
}
