//! The first index at which terms of sequences compare as wanted.
//!
//! A sequence that is linear or geometric is asked exactly, symbols included. Of any other the terms are computed and
//! compared one by one; that none of the later ones is the first follows from the closed form, where one of its
//! parts outgrows all others (`tail`).

use std::collections::BTreeMap;

use num_traits::ToPrimitive;

use super::absorbed::first_of_all;
use super::barrier::barred;
use super::behind::behind;
use super::classes::Classes;
use super::comes_round::{comes_again, comes_round};

use super::descent::descends;
use super::exact::{by_roots, exactly};
use super::far::far;
use super::jointly::jointly;
use super::kept::kept;
use super::late::{late, rising};
use super::maxima::{first_of_parts, late_parts};
use super::meeting::by_one_part;
use super::modular::modular;
use super::near::near;
use super::needed::needed;
use super::numeric::Numeric;
use super::ratio::in_ratio;
use super::scaled::scaled;
use super::sequences::solve_until;
use super::sides::{each_part, furthest, squared};
use super::squares::late_products;
use super::terms::put_in;
use super::{Reach, Unknown};
use crate::assumption::Assumptions;
use crate::closed_form::{Comparison, Recurrence, Solved};
use crate::exponential_polynomial::tail::Tail;
use crate::name::Name;
use crate::value::{Relation, Value};

/// The terms that are compared one by one, at most, and the bits that they may have together.
const MOST_TERMS: u64 = 20_000;
/// Those that are compared before anything is known of later ones.
const FEW_TERMS: u64 = 100;
/// Those that are compared before the forms are looked at.
const VERY_FEW_TERMS: u64 = 32;
const MOST_BITS: u64 = 1 << 26;
/// The bits that they may have together where nothing is known of later ones.
const FEW_BITS: u64 = 1 << 22;
/// The bits of the longest of them.
const LONGEST: u64 = 1 << 16;
/// The bits for which each part of a term with symbols counts, and the most parts.
const SYMBOLIC: u64 = 1 << 10;
const MOST_SIZE: usize = 2_000;
/// How many times that each part of a comparison with symbols counts.
const DECIDED: u64 = 2;
/// The same where nothing is known of later ones.
const SHORTEST: u64 = 1 << 12;

/// A comparison of expressions in the terms of offset 0.
pub(super) type Wanted<'a> = (Relation, &'a Value, &'a Value);

/// The least index at which a comparison of terms holds; of vectors, `=` or `!=`. The search ends when `stop` says so.
pub(super) fn reach(
    recurrence: &Recurrence,
    solved: Option<&Solved>,
    (relation, left, right): Wanted<'_>,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Reach {
    let needed = needed(recurrence, solved, [left, right], known, stop);
    let (recurrence, solved) = match &needed {
        Some(solved) => (solved.recurrence(), Some(solved)),
        None => (recurrence, solved),
    };
    if let Some(found) = behind(recurrence, (relation, left, right), known, stop) {
        return found;
    }
    match furthest(left, right) {
        Ok(Some(distance)) => of_vectors((recurrence, solved), (relation, left, right), &distance, known, stop),
        Ok(None) => {
            let found = |(relation, left, right): Wanted<'_>| {
                of_numbers(recurrence, solved, (relation, left, right), known, stop)
            };
            let squares = squared((left, right), known);
            let by_squares = squares.as_ref().map(|[left, right]| found((relation, left, right)));
            match by_squares {
                Some(told @ (Reach::At(..) | Reach::Never(_))) => told,
                other => match (found((relation, left, right)), other) {
                    (Reach::Unknown(one), Some(told @ Reach::Unknown(Unknown { open: Some(_), .. })))
                        if one.open.is_none() =>
                    {
                        told
                    }
                    (found, _) => found,
                },
            }
        }
        Err(error) => Reach::unknown(error.to_string()),
    }
}

/// The same of vectors, by their greatest difference, by the length of it, or part by part.
fn of_vectors(
    (recurrence, solved): (&Recurrence, Option<&Solved>),
    (relation, left, right): Wanted<'_>,
    distance: &Value,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Reach {
    let zero = Value::zero();
    let by = |distance: &Value| of_numbers(recurrence, solved, (relation, distance, &zero), known, stop);
    let found = by(distance);
    // Along a line with symbols the length of what is left is one number, and its parts are several.
    let found = match (&found, left.sub(right).and_then(|left| left.norm())) {
        (Reach::Unknown(_), Ok(length)) => match by(&length) {
            Reach::Unknown(_) => found,
            told => told,
        },
        _ => found,
    };
    let Reach::Unknown(unknown) = &found else { return found };
    let Some(parts) = each_part(left, right).filter(|_| relation == Relation::Eq) else { return found };
    let of_part = |part: Wanted<'_>| of_numbers(recurrence, solved, part, known, stop);
    let told = match first_of_all(recurrence, &parts, known, &of_part) {
        None | Some(Reach::Unknown(_))
            if let Some(told) = solved.and_then(|solved| by_one_part(solved, &parts, known, &of_part)) =>
        {
            Some(told)
        }
        told => told,
    };
    match told {
        Some(Reach::Unknown(other)) if unknown.open.is_some() || other.open.is_none() => found,
        Some(told) => told,
        None => found,
    }
}

fn of_numbers(
    recurrence: &Recurrence,
    solved: Option<&Solved>,
    wanted: Wanted<'_>,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Reach {
    let (tail, reason) = match without_terms((recurrence, solved), wanted, known, stop) {
        Ok(found) => return found,
        Err(open) => open,
    };
    let known = &solved.map_or(known, Solved::known).without_name(&recurrence.index);
    let at_one = |recurrence: Recurrence, part: Wanted<'_>| {
        let solved = solve_until(recurrence.clone(), known, stop).ok();
        reach(&recurrence, solved.as_ref(), part, known, stop)
    };
    if symbolic(recurrence, wanted)
        && let Some(found) = solved.and_then(|solved| scaled(solved, wanted, known, &at_one))
    {
        return found;
    }
    let why = match by_terms((recurrence, solved), wanted, &tail, known, stop) {
        Reach::Unknown(why) => why,
        found => return found,
    };
    if symbolic(recurrence, wanted) {
        let of_part = |part: Wanted<'_>| of_numbers(recurrence, solved, part, known, stop);
        return first_of_parts(recurrence, wanted, known, &of_part).unwrap_or(Reach::Unknown(reason.unwrap_or(why)));
    }
    far((recurrence, solved), wanted, &tail, stop).unwrap_or_else(|count| {
        let (Tail::Unknown(late) | Tail::Never(_, late)) = &tail;
        let later = recurrence.from.checked_add_unsigned(count).filter(|_| count > MOST_TERMS);
        Reach::Unknown(
            later.map_or(why, |at| Unknown::because(format!("not before {} = {at}; {late}", recurrence.index))),
        )
    })
}

/// The first index where it is found before the terms are computed one after the other; otherwise what is known of late
/// terms, and why it is not found.
fn without_terms(
    (recurrence, solved): (&Recurrence, Option<&Solved>),
    wanted: Wanted<'_>,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Result<Reach, (Tail, Option<Unknown>)> {
    let known = &solved.map_or(known, Solved::known).without_name(&recurrence.index);
    let mut reason = None;
    if let Some(found) = plainly(recurrence, wanted, stop) {
        return Ok(found);
    }
    let from_0 = solved.filter(|_| recurrence.from >= 0);
    if let Some(solved) = from_0 {
        match exactly(solved, wanted, known) {
            Some(Reach::Unknown(why)) => reason = Some(why),
            Some(found) => return Ok(found),
            None => {}
        }
        let first = |part: Wanted<'_>| reach(recurrence, Some(solved), part, known, stop);
        if let Some(found) = by_roots(solved, wanted, known).or_else(|| jointly(solved, wanted, known, &first)) {
            return Ok(found);
        }
    }
    let classes = from_0.and_then(|solved| Classes::of(solved, wanted));
    let apart = classes.is_none().then(|| Classes::by_remainders(from_0?, wanted)).flatten();
    let apart = classes.as_ref().or(apart.as_ref());
    if let Some(found) = apart.and_then(|classes| classes.first(known)) {
        return Ok(found);
    }
    // Where something of parameters alone is asked already that is asked first.
    let asks = |why: &Unknown| asks_of_parameters(why, &recurrence.index);
    reason = reason.clone().filter(asks).or_else(|| apart?.open(known)).or(reason);
    if reason.as_ref().is_some_and(|why| !asks(why))
        && let Some(found) = solved.and_then(|solved| Classes::even_and_odd(solved, wanted)?.first(known))
    {
        match found {
            Reach::Unknown(why) if why.open.is_some() => reason = Some(why),
            Reach::Unknown(_) => {}
            found => return Ok(found),
        }
    }
    // Most first indices are early ones, and to find these nothing need be known of later terms.
    if let early @ Reach::At(..) = tried(recurrence, wanted, &Tail::Unknown(String::new()), known, stop, FEW_TERMS) {
        return Ok(early);
    }
    if let Some(found) = comes_round(recurrence, wanted, stop).or_else(|| in_ratio(recurrence, wanted, known, stop)) {
        return Ok(found);
    }
    let tail = match (classes, solved) {
        (Some(classes), _) => classes.tail(),
        (None, Some(solved)) => late(solved, wanted),
        (None, None) => Tail::Unknown("no bound of its later terms is known".to_string()),
    };
    match tail {
        Tail::Never(..) => Err((tail, reason)),
        Tail::Unknown(why) => late_otherwise((recurrence, solved), wanted, known, stop)
            .map(|tail| (tail.unwrap_or(Tail::Unknown(why)), reason))
            .map_or_else(Ok, Err),
    }
}

/// The first index among the first few terms, where all are numbers: they cost less than any reasoning about them; or that
/// there is none, whatever the terms are.
fn plainly(recurrence: &Recurrence, wanted: Wanted<'_>, stop: &dyn Fn() -> bool) -> Option<Reach> {
    let quickly = Numeric::of(recurrence, wanted)
        .and_then(|mut numbers| counted(&mut numbers, recurrence, &Tail::Unknown(String::new()), stop, VERY_FEW_TERMS));
    if let Some(Reach::At(..)) = quickly {
        return quickly;
    }
    // Of the terms nothing is known here but that they are numbers.
    let false_of_all = Assumptions::default().decide(wanted.0, wanted.1, wanted.2) == Some(false);
    false_of_all.then(|| Reach::Never("it is false whatever the terms are".to_string()))
}

/// Whether what would have to be known says nothing of an index.
pub(super) fn asks_of_parameters(why: &Unknown, index: &Name) -> bool {
    let of_parameters = |(_, left, right): &Comparison| ![left, right].iter().any(|side| side.mentions(index));
    why.open.as_deref().is_some_and(of_parameters)
}

/// The same where the forms as they are say nothing of late terms.
fn late_otherwise(
    (recurrence, solved): (&Recurrence, Option<&Solved>),
    wanted: Wanted<'_>,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Result<Option<Tail>, Reach> {
    let tail = modular(recurrence, wanted)
        .or_else(|| barred(recurrence, wanted, known))
        .or_else(|| near(recurrence, wanted, known))
        .or_else(|| late_products(recurrence, wanted, known, stop));
    let open = tail.as_ref().is_none_or(|tail| matches!(tail, Tail::Unknown(_)));
    if !open {
        return Ok(tail);
    }
    if let Some(found) = descends(recurrence, wanted, known, stop) {
        return Err(found);
    }
    if let Some(tail) = kept(recurrence, wanted, known, stop) {
        return Ok(Some(tail));
    }
    let of_part = |part: Wanted<'_>| match without_terms((recurrence, solved), part, known, stop) {
        Ok(Reach::Never(why)) => Tail::Never(recurrence.from.to_u64().unwrap_or(0), why),
        Ok(_) => Tail::Unknown(String::new()),
        Err((tail, _)) => tail,
    };
    Ok(late_parts(recurrence, solved, wanted, known, &of_part).or(tail))
}

/// The first index by the terms one after the other, or by halves where they rise.
fn by_terms(
    (recurrence, solved): (&Recurrence, Option<&Solved>),
    wanted: Wanted<'_>,
    tail: &Tail,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Reach {
    let by_halves = || solved.and_then(|solved| rising(solved, wanted, stop));
    let at_once = |at: u64| Reach::At(Value::rational(num_rational::BigRational::from_integer(at.into())), Vec::new());
    let all = || tried(recurrence, wanted, tail, known, stop, MOST_TERMS);
    // Where no late term is met the early ones say all.
    match tail {
        Tail::Never(..) => match all() {
            Reach::Unknown(why) => by_halves().map_or(Reach::Unknown(why), at_once),
            found => found,
        },
        Tail::Unknown(_) => by_halves().map_or_else(all, at_once),
    }
}

/// Whether there are parameters in it.
pub(super) fn symbolic(recurrence: &Recurrence, (_, left, right): Wanted<'_>) -> bool {
    let mut known: std::collections::BTreeSet<Name> = recurrence.terms().into_iter().map(|(name, ..)| name).collect();
    known.insert(recurrence.index.clone());
    let starts = recurrence.sequences.iter().flat_map(|sequence| sequence.start.iter().chain([&sequence.next]));
    starts.chain([left, right]).any(|value| value.variables().iter().any(|name| !known.contains(name)))
}

/// Term by term, as far as the tail needs it, and so many at most.
fn tried(
    recurrence: &Recurrence,
    (relation, left, right): Wanted<'_>,
    tail: &Tail,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
    most_terms: u64,
) -> Reach {
    if let Some(mut numbers) = Numeric::of(recurrence, (relation, left, right))
        && let Some(found) = counted(&mut numbers, recurrence, tail, stop, most_terms)
    {
        return found;
    }
    let variables = recurrence.terms();
    let mut state: Vec<Value> = recurrence.sequences.iter().flat_map(|sequence| sequence.start.clone()).collect();
    let (mut at, mut bits) = (recurrence.from, 0u64);
    let mut earlier = None;
    for count in 0..=most_terms {
        if let Some(ended) = ended(recurrence, at, count, tail, stop) {
            return ended;
        }
        if let Some(never) = comes_again(recurrence, [left, right], (at, count, &state), &mut earlier) {
            return never;
        }
        let mut images: BTreeMap<Name, Value> =
            variables.iter().map(|(name, ..)| name.clone()).zip(state.iter().cloned()).collect();
        images.insert(recurrence.index.clone(), Value::integer(at));
        let [Ok(one), Ok(other)] = [left, right].map(|side| side.substitute(&images)) else {
            return Reach::unknown(format!("it is not defined at {} = {at}", recurrence.index));
        };
        match known.decide(relation, &one, &other) {
            Some(true) => return Reach::At(Value::integer(at), Vec::new()),
            Some(false) => {}
            None => {
                return Reach::unknown(format!(
                    "it must be known whether {one} {} {other}, at {} = {at}",
                    relation.symbol(),
                    recurrence.index
                ));
            }
        }
        bits += state.iter().map(cost).sum::<u64>();
        // To decide it took far longer than to know the terms.
        bits += [&one, &other].into_iter().filter(|side| side.as_rational().is_none()).map(cost).sum::<u64>() * DECIDED;
        state = match following(recurrence, &state, &images, known) {
            Ok(next) => next,
            Err(error) => return Reach::unknown(format!("not up to {} = {at}; then {error}", recurrence.index)),
        };
        at += 1;
        let most = if matches!(tail, Tail::Never(..)) { MOST_BITS } else { FEW_BITS };
        let own = |value: &Value| match value.as_rational() {
            Some(number) => number.numer().bits().max(number.denom().bits()) > longest(most_terms),
            None => value.size() > MOST_SIZE,
        };
        if bits > most || state.iter().any(own) || count == most_terms {
            break;
        }
    }
    not_before(recurrence, at, tail)
}

/// What a term costs, in bits: one with symbols as much as a long number.
fn cost(value: &Value) -> u64 {
    match value.as_rational() {
        Some(number) => number.numer().bits() + number.denom().bits(),
        None => SYMBOLIC.saturating_mul(value.size() as u64),
    }
}

/// The same for numbers; nothing where one is not defined.
fn counted(
    numbers: &mut Numeric,
    recurrence: &Recurrence,
    tail: &Tail,
    stop: &dyn Fn() -> bool,
    most_terms: u64,
) -> Option<Reach> {
    let (mut at, mut bits) = (recurrence.from, 0u64);
    let most = if matches!(tail, Tail::Never(..)) { MOST_BITS } else { FEW_BITS };
    for count in 0..=most_terms {
        if let Some(ended) = ended(recurrence, at, count, tail, stop) {
            return Some(ended);
        }
        if numbers.holds()? {
            return Some(Reach::At(Value::integer(at), Vec::new()));
        }
        bits += numbers.bits().0;
        numbers.advance()?;
        at += 1;
        if bits > most || numbers.bits().1 > longest(most_terms) {
            break;
        }
    }
    Some(not_before(recurrence, at, tail))
}

/// What ends a search before it looks at a term: that it is to stop, or that no later term is met.
fn ended(recurrence: &Recurrence, at: i64, count: u64, tail: &Tail, stop: &dyn Fn() -> bool) -> Option<Reach> {
    if stop() {
        return Some(Reach::unknown(format!("not before {} = {at}; interrupted", recurrence.index)));
    }
    let Tail::Never(until, reason) = tail else { return None };
    at.to_u64().filter(|at| at >= until)?;
    Some(Reach::Never(match count {
        0 => reason.clone(),
        _ => format!("no term before {} = {at} is, and {reason}", recurrence.index),
    }))
}

/// The bits of the longest term of so many: the first look is a short one.
fn longest(most_terms: u64) -> u64 {
    if most_terms <= FEW_TERMS { SHORTEST } else { LONGEST }
}

fn not_before(recurrence: &Recurrence, at: i64, tail: &Tail) -> Reach {
    let why = match tail {
        Tail::Unknown(why) => why.clone(),
        Tail::Never(until, _) => format!("it can be met up to {} = {until} only", recurrence.index),
    };
    Reach::unknown(format!("not before {} = {at}; {why}", recurrence.index))
}

/// The terms that the recurrence reads next, from those that it reads now.
fn following(
    recurrence: &Recurrence,
    state: &[Value],
    images: &BTreeMap<Name, Value>,
    known: &Assumptions,
) -> Result<Vec<Value>, crate::value::ValueError> {
    let next = |(place, (_, own, offset)): (usize, (Name, usize, usize))| {
        let sequence = &recurrence.sequences[own];
        if offset + 1 < sequence.start.len() {
            return Ok(state[place + 1].clone());
        }
        put_in(&sequence.next, images, known)
    };
    recurrence.terms().into_iter().enumerate().map(next).collect()
}
