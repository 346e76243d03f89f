//! Equations that never hold because they do not hold modulo some number: there the terms come round, so that all of them
//! are looked at.

use std::collections::HashMap;

use num_bigint::BigInt;
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{Signed, ToPrimitive, Zero};

use super::first::Wanted;
use super::{Recurrence, Sequence};
use crate::assumption::Assumptions;
use crate::name::Name;
use crate::value::{Atom, Relation, Value};

/// The moduli, and the steps after which the terms must have come round.
const MODULI: std::ops::RangeInclusive<u64> = 2..=101;
const MOST_STEPS: usize = 6_000;
/// The values that may have to be 0, at most.
const MOST_NEEDED: usize = 8;
const MOST_OPEN: usize = 32;
/// The highest power that first terms are multiplied by.
const MOST_POWER: u32 = 1_100;

/// That two sides are never equal from an index on: modulo a number they differ there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Differ {
    /// The number.
    pub modulus: u64,
    /// A number of which both sides are multiplied by the power with the index as exponent, to have whole terms.
    pub times: BigInt,
    /// The index.
    pub from: i64,
    /// After how many steps the terms come round.
    pub length: usize,
}

/// From which index on a comparison never holds, where it needs something to be 0 and a modulus shows that it is not: all terms
/// are looked at modulo that number until they come round.
pub fn differ(recurrence: &Recurrence, wanted: Wanted<'_>) -> Option<Differ> {
    needed(wanted, &Assumptions::default())?.iter().find_map(|difference| {
        let plain = || shown(recurrence, &whole(difference)?, BigInt::from(1));
        let with_powers = || {
            let (recurrence, difference, times) = whole_terms(recurrence, difference)?;
            shown(&recurrence, &whole(&difference)?, times)
        };
        plain().or_else(with_powers)
    })
}

/// Values that are 0 wherever the comparison holds: the difference of two sides that are to be equal, and x and y of
/// `abs(x)+abs(y) <= 0`.
pub(super) fn needed((relation, left, right): Wanted<'_>, known: &Assumptions) -> Option<Vec<Value>> {
    let difference = left.sub(right).ok()?;
    if let Some(parts) = difference.components().filter(|_| relation == Relation::Eq) {
        return Some(parts);
    }
    let mut all: Vec<Value> = Vec::new();
    let mut open = vec![difference.clone()];
    while let Some(value) = open.pop().filter(|_| all.len() < MOST_NEEDED && open.len() < MOST_OPEN) {
        let bent = value.atoms().into_iter().find(|atom| matches!(atom, Atom::Maximum(_) | Atom::Root(_)));
        match bent {
            Some(atom) => open.extend(straight(&value, &atom).unwrap_or_default()),
            None if all.contains(&value) || value.neg().is_ok_and(|other| all.contains(&other)) => {}
            None => all.push(value),
        }
    }
    let excluded = |value: &Value| {
        [Relation::Gtr, Relation::Lss].into_iter().all(|side| {
            let mut there = known.clone();
            there.assume(side, value, &Value::zero());
            there.decide(relation, left, right) == Some(false)
        })
    };
    all.retain(excluded);
    let plain = (relation == Relation::Eq).then_some(difference);
    Some(plain.into_iter().chain(all).collect())
}

/// What a value is where each of several is the greatest of them, and the parts of a vector whose length stands in it.
fn straight(value: &Value, atom: &Atom) -> Option<Vec<Value>> {
    match atom {
        Atom::Maximum(elements) => {
            let zero = Value::zero();
            [&zero].into_iter().chain(elements.iter()).map(|one| value.with_atom(atom, one).ok()).collect()
        }
        Atom::Root(inner) => inner.squares(),
        _ => None,
    }
}

/// The same of a difference with whole coefficients.
fn shown(recurrence: &Recurrence, difference: &Value, times: BigInt) -> Option<Differ> {
    let (next, slots) = read(recurrence, difference)?;
    MODULI.into_iter().find_map(|modulus| {
        let (from, length) = Round::of(recurrence, &next, &slots, modulus)?.never()?;
        Some(Differ { modulus, times: times.clone(), from: from.max(recurrence.from), length })
    })
}

/// Linear sequences whose equations have fractions, all multiplied by `q*d^n` so that the terms are whole numbers without a
/// common divisor, with the difference times the same, and d.
fn whole_terms(recurrence: &Recurrence, difference: &Value) -> Option<(Recurrence, Value, BigInt)> {
    let (terms, index) = (recurrence.terms(), Value::variable(&recurrence.index));
    let term = |name: &Name| terms.iter().find(|(own, ..)| own == name).map(|(_, _, offset)| *offset);
    // Of a sum of multiples of terms: each with its offset; nothing of another.
    let multiples = |value: &Value| -> Option<Vec<(Name, usize, BigRational)>> {
        let (above, below) = value.polynomials()?;
        let scale = below.as_constant()?.recip();
        let parts = above.terms().iter().map(|(monomial, number)| match monomial.factors() {
            [(Atom::Variable(name), 1)] => Some((name.clone(), term(name)?, number * &scale)),
            _ => None,
        });
        parts.collect()
    };
    let steps = recurrence.sequences.iter().map(|one| multiples(&one.next)).collect::<Option<Vec<_>>>()?;
    let denominators = steps.iter().flatten().map(|(.., number)| number.denom().clone());
    let times = denominators.fold(BigInt::from(1), |all, one| all.lcm(&one));
    let from = u32::try_from(recurrence.from).ok().filter(|from| *from < MOST_POWER)?;
    let mut sequences = Vec::new();
    for (sequence, step) in recurrence.sequences.iter().zip(steps) {
        let order = sequence.start.len();
        let mut next = Value::zero();
        for (name, offset, number) in step {
            let factor = number * scaled_by(&times, order.checked_sub(offset)?)?;
            next = next.add(&Value::variable(&name).scale(&factor).ok()?).ok()?;
        }
        let start = sequence
            .start
            .iter()
            .enumerate()
            .map(|(offset, value)| value.scale(&scaled_by(&times, offset + from as usize)?).ok());
        sequences.push(Sequence { name: sequence.name.clone(), start: start.collect::<Option<_>>()?, next });
    }
    let numbers = sequences.iter().flat_map(|one| &one.start).map(Value::as_rational).collect::<Option<Vec<_>>>()?;
    let common = numbers.iter().filter(|number| !number.is_zero()).fold(None, |all: Option<BigRational>, one| {
        Some(match all {
            None => one.abs(),
            Some(all) => BigRational::new(all.numer().gcd(one.numer()), all.denom().lcm(one.denom())),
        })
    });
    let by = common?.recip();
    for value in sequences.iter_mut().flat_map(|one| one.start.iter_mut()) {
        *value = value.scale(&by).ok()?;
    }
    let none = terms.iter().map(|(name, ..)| (name.clone(), Value::zero())).collect();
    let alone = difference.substitute(&none).ok()?;
    multiples(&difference.sub(&alone).ok()?).filter(|all| all.iter().all(|(_, offset, _)| *offset == 0))?;
    let power = Value::rational(BigRational::from_integer(times.clone())).power(&index).ok()?.scale(&by).ok()?;
    let difference = difference.sub(&alone).and_then(|moving| moving.add(&alone.mul(&power)?)).ok()?;
    Some((Recurrence { sequences, ..recurrence.clone() }, difference, times))
}

/// A power of a number as one to multiply by.
fn scaled_by(times: &BigInt, power: usize) -> Option<BigRational> {
    let power = u32::try_from(power).ok().filter(|power| *power < MOST_POWER)?;
    Some(BigRational::from_integer(times.pow(power)))
}

/// A multiple of a value with whole coefficients: it is 0 where the value is.
fn whole(value: &Value) -> Option<Value> {
    let (above, below) = value.polynomials()?;
    let scale = below.as_constant()?.recip();
    let denominators = above.terms().iter().map(|(_, number)| (number * &scale).denom().clone());
    let multiple = denominators.fold(BigInt::from(1), |all, one| all.lcm(&one));
    value.scale(&BigRational::from_integer(multiple)).ok()
}

/// What a step reads: terms and the index, and powers of numbers with the index as exponent.
enum Slot {
    Variable(Name),
    Power(BigRational),
    /// An integer part, of which nothing is known but that it is whole: multiples of the modulus are left out.
    Whole(Value),
}

/// A sum of multiples of products of powers of slots.
type Terms<T> = Vec<(T, Vec<(usize, u32)>)>;
type Sum = Terms<BigRational>;

/// The next terms, in the order of the sequences, and the difference, as polynomials in the slots.
fn read(recurrence: &Recurrence, difference: &Value) -> Option<(Vec<Sum>, Vec<Slot>)> {
    let mut slots: Vec<Slot> = recurrence.terms().into_iter().map(|(name, ..)| Slot::Variable(name)).collect();
    slots.push(Slot::Variable(recurrence.index.clone()));
    let mut sums = Vec::new();
    for value in recurrence.sequences.iter().map(|sequence| &sequence.next).chain([difference]) {
        let (above, below) = value.polynomials()?;
        let scale = below.as_constant()?.recip();
        let mut sum = Vec::new();
        for (monomial, number) in above.terms() {
            let factors =
                monomial.factors().iter().map(|(atom, count)| Some((slot(atom, recurrence, &mut slots)?, *count)));
            sum.push((number * &scale, factors.collect::<Option<Vec<_>>>()?));
        }
        sums.push(sum);
    }
    Some((sums, slots))
}

fn slot(atom: &Atom, recurrence: &Recurrence, slots: &mut Vec<Slot>) -> Option<usize> {
    match atom {
        Atom::Variable(name) => slots.iter().position(|slot| matches!(slot, Slot::Variable(other) if other == name)),
        Atom::Power(base, exponent) if exponent.as_variable() == Some(&recurrence.index) => {
            let base = base.as_rational()?;
            let found = slots.iter().position(|slot| matches!(slot, Slot::Power(other) if *other == base));
            Some(found.unwrap_or_else(|| {
                slots.push(Slot::Power(base));
                slots.len() - 1
            }))
        }
        Atom::Floor(inner) => {
            let found = slots.iter().position(|slot| matches!(slot, Slot::Whole(other) if other == inner));
            Some(found.unwrap_or_else(|| {
                slots.push(Slot::Whole(inner.clone()));
                slots.len() - 1
            }))
        }
        _ => None,
    }
}

/// A recurrence modulo a number.
struct Round {
    modulus: u64,
    sums: Vec<Terms<u64>>,
    /// The offsets of each sequence's terms.
    orders: Vec<usize>,
    /// By what a slot of a power is multiplied in a step.
    ratios: Vec<u64>,
    state: Vec<u64>,
    from: i64,
}

impl Round {
    /// None where a denominator has a factor in common with the modulus.
    fn of(recurrence: &Recurrence, sums: &[Sum], slots: &[Slot], modulus: u64) -> Option<Round> {
        let number = |number: &BigRational| residue(number, modulus);
        let unknown = |slot: usize| matches!(slots.get(slot), Some(Slot::Whole(_)));
        // Factors are whole modulo this number, so that a multiple of it stays one.
        let reduced = |sum: &Sum| -> Option<Terms<u64>> {
            let mut reduced = Vec::new();
            for (scale, factors) in sum {
                let scale = number(scale)?;
                match (scale, factors.iter().any(|(slot, _)| unknown(*slot))) {
                    (0, true) => {}
                    (_, true) => return None,
                    (scale, false) => reduced.push((scale, factors.clone())),
                }
            }
            Some(reduced)
        };
        let mut state = Vec::new();
        for value in recurrence.sequences.iter().flat_map(|sequence| &sequence.start) {
            state.push(number(&value.as_rational()?)?);
        }
        state.push(number(&BigRational::from_integer(recurrence.from.into()))?);
        let mut ratios = Vec::new();
        for slot in &slots[state.len()..] {
            if let Slot::Whole(_) = slot {
                ratios.push(0);
                state.push(0);
                continue;
            }
            let Slot::Power(base) = slot else { return None };
            ratios.push(number(base)?);
            let first = base.pow(i32::try_from(recurrence.from).ok().filter(|from| *from >= 0)?);
            state.push(number(&first)?);
        }
        Some(Round {
            modulus,
            sums: sums.iter().map(reduced).collect::<Option<_>>()?,
            orders: recurrence.sequences.iter().map(|sequence| sequence.start.len()).collect(),
            ratios,
            state,
            from: recurrence.from,
        })
    }

    fn value(&self, sum: &[(u64, Vec<(usize, u32)>)]) -> u64 {
        sum.iter().fold(0, |total, (scale, factors)| {
            let product = factors.iter().fold(*scale, |product, (slot, count)| {
                (0..*count).fold(product, |product, _| product * self.state[*slot] % self.modulus)
            });
            (total + product) % self.modulus
        })
    }

    /// From which index on the difference is never 0, and after how many steps the terms come round.
    fn never(mut self) -> Option<(i64, usize)> {
        let mut seen: HashMap<Vec<u64>, usize> = HashMap::new();
        let mut last = None;
        for step in 0..MOST_STEPS {
            if let Some(earlier) = seen.insert(self.state.clone(), step) {
                let after = last.map_or(0, |last: usize| last + 1);
                let until = self.from.checked_add(i64::try_from(after).ok()?)?;
                return (after <= earlier).then_some((until, step - earlier));
            }
            if self.sums.last().is_none_or(|difference| self.value(difference) == 0) {
                last = Some(step);
            }
            self.step();
        }
        None
    }

    fn step(&mut self) {
        let next: Vec<u64> = self.sums.iter().map(|sum| self.value(sum)).collect();
        let mut place = 0;
        for (order, value) in self.orders.iter().zip(next) {
            self.state.copy_within(place + 1..place + order, place);
            place += order;
            self.state[place - 1] = value;
        }
        self.state[place] = (self.state[place] + 1) % self.modulus;
        for (own, ratio) in self.state[place + 1..].iter_mut().zip(&self.ratios) {
            *own = *own * ratio % self.modulus;
        }
    }
}

/// A number modulo another; none where the denominator has no inverse.
fn residue(number: &BigRational, modulus: u64) -> Option<u64> {
    let whole = BigInt::from(modulus);
    let found = number.denom().mod_floor(&whole).extended_gcd(&whole);
    let unit = found.gcd == BigInt::from(1);
    unit.then(|| (number.numer() * found.x).mod_floor(&whole).to_u64()).flatten()
}
