//! Forms that one induction cannot show together, since some of them are products, by pieces or in turns: sequences that
//! depend on each other are shown by themselves, where what they read of others has values that were shown before.

use std::collections::{BTreeMap, BTreeSet};

use super::check::{failed, whole};
use super::defined::{Defined, Layers};
use super::pieces::reads;
use super::{Comparison, Form, Recurrence, Solved, Unchecked, product};
use crate::assumption::Assumptions;
use crate::name::Name;
use crate::value::{Atom, Need, Relation, Value, ValueError};

/// What must hold for all forms to be right.
pub(super) fn apart(
    recurrence: &Recurrence,
    forms: &[Form],
    conditions: &[Comparison],
    known: &Assumptions,
) -> Result<Vec<Comparison>, Unchecked> {
    let groups = groups(recurrence);
    if groups.len() < 2 {
        return Err(failed("the sequences all depend on each other"));
    }
    let mut images: BTreeMap<Name, Value> = BTreeMap::new();
    let mut defined = Defined::new(&recurrence.index, recurrence.from, known, conditions.to_vec());
    let mut all: Vec<Comparison> = Vec::new();
    for group in groups {
        let mut own = recurrence.only(&group);
        for sequence in &mut own.sequences {
            // What was shown to be a value at every index may stand in place of the term.
            has_meaning(&sequence.next, &images, recurrence.from, &mut defined)?;
            sequence.next = sequence.next.substitute(&images)?;
        }
        let own_forms = group.iter().map(|place| forms[*place].clone()).collect();
        let solved = Solved::check(own, own_forms, conditions.to_vec(), known)?;
        images.extend(images_of(&solved.recurrence, &solved.forms)?);
        all.extend(solved.conditions);
    }
    all.extend(defined.conditions);
    let mut once = BTreeSet::new();
    all.retain(|condition| once.insert(condition.clone()));
    Ok(all)
}

/// The terms that are values at every index, by their forms.
pub(super) fn images_of(recurrence: &Recurrence, forms: &[Form]) -> Result<BTreeMap<Name, Value>, Unchecked> {
    let (index, mut images) = (&recurrence.index, BTreeMap::new());
    for (name, place, offset) in recurrence.terms() {
        if let Some(value) = forms[place].value(index) {
            let later = Value::variable(index).add(&Value::integer(whole(offset)?))?;
            images.insert(name, value.with(index, &later)?);
        }
    }
    Ok(images)
}

/// Makes sure that an equation means something with these values at every index, before anything in it cancels.
pub(super) fn has_meaning(
    next: &Value,
    images: &BTreeMap<Name, Value>,
    from: i64,
    defined: &mut Defined<'_>,
) -> Result<(), Unchecked> {
    for need in next.needs().into_iter().filter(|need| images.keys().any(|name| need.value().mentions(name))) {
        match need.substitute(images)? {
            Need::Nonzero(value) => divides(&value.numerator().unwrap_or(value), from, defined)?,
            other if defined.known().grants(&other) == Some(true) => {}
            other => return Err(Unchecked(other.to_string())),
        }
    }
    Ok(())
}

/// Makes sure that an equation has a value at every index, as far as that is not told by what it divides by as a whole: what
/// stands under its roots is not negative, and nothing is 0 by which it divides inside of its roots, maxima and integer
/// parts. Of parameters alone that becomes a condition. Roots of terms must be so where the forms have lost them, in `all`
/// of them: `max(sqrt(x(n)),100)` is 100 up to some x(n), and nothing then. A form in which such a root still stands says
/// so itself.
pub(super) fn hidden_needs(
    next: &Value,
    (recurrence, forms): (&Recurrence, &[Form]),
    all: bool,
    defined: &mut Defined<'_>,
) -> Result<(), Unchecked> {
    let terms = recurrence.terms();
    let of_terms = |need: &Need| terms.iter().any(|(name, ..)| need.value().mentions(name));
    let atoms = next.atoms();
    let inside: BTreeSet<Need> = atoms.iter().flat_map(Atom::parts).flat_map(Value::needs).collect();
    let asked = |need: &Need| match need {
        Need::Nonnegative(_) => all || !of_terms(need),
        Need::Nonzero(_) => !of_terms(need) && inside.contains(need),
        Need::Natural(_) => false,
    };
    if !next.needs().iter().any(asked) {
        return Ok(());
    }
    let images = images_of(recurrence, forms)?;
    let shown: BTreeSet<Need> =
        forms.iter().filter_map(|form| form.value(&recurrence.index)).flat_map(|form| form.needs()).collect();
    let known = defined.known().clone();
    for (known, need) in needs_in_cases(next, &images, &known)?.into_iter().filter(|(_, need)| asked(need)) {
        if known.grants(&need) == Some(true) {
            continue;
        }
        if !of_terms(&need) {
            let from = defined.first_possible(&known, recurrence.from);
            defined.always(&need, from)?;
            continue;
        }
        let under = need.substitute(&images)?;
        if shown.contains(&need) || shown.contains(&under) || known.grants(&under) == Some(true) {
            continue;
        }
        if reads(under.value(), recurrence) || known.grants(&under) == Some(false) {
            return Err(Unchecked(need.to_string()));
        }
        defined.not_negative(under.value());
    }
    Ok(())
}

/// Conditions of an equation that are looked at in either case.
const MOST_CASES: usize = 4;

/// What an equation needs where these are put in for names: where its conditions hold and where they do not, with what is
/// known there; maxima stay.
pub(crate) fn needs_in_cases(
    next: &Value,
    images: &BTreeMap<Name, Value>,
    known: &Assumptions,
) -> Result<Vec<(Assumptions, Need)>, ValueError> {
    let mut found = Vec::new();
    for Case { known, value, asked, .. } in in_cases(next, images, known)? {
        found.extend(asked.into_iter().map(|asked| (asked.known, asked.need)));
        found.extend(value.needs().into_iter().map(|need| (known.clone(), need)));
    }
    Ok(found)
}

/// A value where its conditions hold, or do not.
pub(crate) struct Case {
    /// The conditions, as they hold or do not.
    pub assumed: Vec<Comparison>,
    /// What is known there.
    pub known: Assumptions,
    /// What the value is there; maxima stay, and the conditions beyond [`MOST_CASES`] of them.
    pub value: Value,
    /// What the conditions need that decide it.
    pub asked: Vec<Asked>,
}

/// What a condition needs, with what is assumed and known where it is looked at.
#[derive(Clone)]
pub(crate) struct Asked {
    pub assumed: Vec<Comparison>,
    pub known: Assumptions,
    pub need: Need,
}

/// A value in each of its cases, where these are put in for names in its conditions.
pub(crate) fn in_cases(
    value: &Value,
    images: &BTreeMap<Name, Value>,
    known: &Assumptions,
) -> Result<Vec<Case>, ValueError> {
    let whole = Case { assumed: Vec::new(), known: known.clone(), value: value.clone(), asked: Vec::new() };
    let mut found = Vec::new();
    split(whole, images, MOST_CASES, &mut found)?;
    Ok(found)
}

fn split(case: Case, images: &BTreeMap<Name, Value>, more: usize, found: &mut Vec<Case>) -> Result<(), ValueError> {
    let conditions: Vec<Atom> =
        case.value.atoms().into_iter().filter(|atom| matches!(atom, Atom::Positive(_))).collect();
    // What has a value there is looked at first: it may be what the others are asked behind.
    let has_value = |atom: &&Atom| {
        let needs = atom.parts().into_iter().flat_map(Value::needs);
        needs.filter(|need| !matches!(need, Need::Natural(_))).all(|need| case.known.grants(&need) == Some(true))
    };
    let condition = conditions.iter().find(has_value).or(conditions.first()).cloned();
    let Some(atom @ Atom::Positive(inner)) = condition.as_ref().filter(|_| more > 0) else {
        found.push(case);
        return Ok(());
    };
    let (image, zero) = (inner.substitute(images)?, Value::zero());
    let mut asked = case.asked.clone();
    let needs = inner.needs().into_iter();
    asked.extend(needs.map(|need| Asked { assumed: case.assumed.clone(), known: case.known.clone(), need }));
    let before = found.len();
    for (holds, relation) in [(1, Relation::Gtr), (0, Relation::Lte)] {
        let mut known = case.known.clone();
        known.assume(relation, &image, &zero);
        if !known.contradictory() {
            let value = case.value.with_atom(atom, &Value::integer(holds))?;
            let mut assumed = case.assumed.clone();
            assumed.push((relation, image.clone(), zero.clone()));
            split(Case { assumed, known, value, asked: asked.clone() }, images, more - 1, found)?;
        }
    }
    // A condition that neither holds nor does not has no value.
    if found.len() == before {
        found.push(Case { asked, ..case });
    }
    Ok(())
}

/// Makes sure that nothing is 0 by which an equation divides, where products are among the terms: one is never 0 if none of
/// its factors is.
pub(super) fn products_are_never_zero(
    next: &Value,
    (recurrence, forms): (&Recurrence, &[Form]),
    defined: &mut Defined<'_>,
) -> Result<(), Unchecked> {
    let (terms, from) = (recurrence.terms(), recurrence.from);
    let images = images_of(recurrence, forms)?;
    for need in next.needs() {
        let mut rest = need.value().clone();
        let read: Vec<&(Name, usize, usize)> = terms.iter().filter(|(name, ..)| rest.mentions(name)).collect();
        if !read.is_empty() && !matches!(need, Need::Nonzero(_)) {
            return Err(Unchecked(need.to_string()));
        }
        for (name, place, _) in read.into_iter().filter(|(name, ..)| !images.contains_key(name)) {
            let unlike = || Unchecked(format!("it divides by {rest}, and whether that is ever 0 is not known"));
            let Some(Form::Product(ratio, value)) = forms.get(*place) else { return Err(unlike()) };
            let parts = rest.linear_in(name).zip(value.linear_in(&product()));
            let Some(((factor, other), (start, more))) = parts else { return Err(unlike()) };
            if !other.is_zero() || !more.is_zero() {
                return Err(unlike());
            }
            for part in [ratio, &start] {
                defined.never_zero(part, from, PLAIN)?;
            }
            rest = factor;
        }
        if matches!(need, Need::Nonzero(_)) {
            divides(&rest.substitute(&images)?, from, defined)?;
        }
    }
    Ok(())
}

/// What does not stand in sums and products.
const PLAIN: Layers<'_> = Layers { count: 0, fine: &[] };

/// Makes sure that what is divided by is defined and never 0.
fn divides(value: &Value, from: i64, defined: &mut Defined<'_>) -> Result<(), Unchecked> {
    if value.is_zero() {
        return Err(Unchecked("it divides by what is 0".to_string()));
    }
    defined.never_zero(value, from, PLAIN)
}

/// The sets of sequences that all depend on each other, each after those that it reads.
fn groups(recurrence: &Recurrence) -> Vec<BTreeSet<usize>> {
    let count = recurrence.sequences.len();
    let closures = closures(count, recurrence.reads());
    let mut order: Vec<usize> = (0..count).collect();
    // What a sequence depends on, but does not depend on it, depends on fewer.
    order.sort_by_key(|place| closures[*place].len());
    let mut groups: Vec<BTreeSet<usize>> = Vec::new();
    for place in order {
        if groups.iter().all(|group| !group.contains(&place)) {
            let both = |other: &usize| closures[*other].contains(&place);
            groups.push(closures[place].iter().copied().filter(both).collect());
        }
    }
    groups
}

/// For each of so many places those that it depends on, itself among them, by what it reads.
pub(crate) fn closures(count: usize, reads: impl Fn(usize, usize) -> bool) -> Vec<BTreeSet<usize>> {
    let direct: Vec<Vec<usize>> =
        (0..count).map(|one| (0..count).filter(|other| reads(one, *other)).collect()).collect();
    let closure = |place: usize| {
        let (mut all, mut work) = (BTreeSet::from([place]), vec![place]);
        while let Some(one) = work.pop() {
            work.extend(direct[one].iter().filter(|other| all.insert(**other)));
        }
        all
    };
    (0..count).map(closure).collect()
}
