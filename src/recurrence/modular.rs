//! Equations that never hold because they do not hold modulo some number: there the terms come round, so that all of them
//! are looked at.

use std::collections::HashMap;

use num_bigint::BigInt;
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::ToPrimitive;

use super::reach::Wanted;
use crate::closed_form::Recurrence;
use crate::exponential_polynomial::tail::Tail;
use crate::name::Name;
use crate::value::{Atom, Relation, Value};

/// The moduli, and the steps after which the terms must have come round.
const MODULI: std::ops::RangeInclusive<u64> = 2..=101;
const MOST_STEPS: usize = 6_000;

/// From which index on two sides are never equal, where a modulus shows that.
pub(super) fn modular(recurrence: &Recurrence, (relation, left, right): Wanted<'_>) -> Option<Tail> {
    if relation != Relation::Eq {
        return None;
    }
    let difference = whole(&left.sub(right).ok()?)?;
    let (next, slots) = read(recurrence, &difference)?;
    MODULI.into_iter().find_map(|modulus| {
        let (until, length) = Round::of(recurrence, &next, &slots, modulus)?.never()?;
        let from = until.max(recurrence.from).to_u64().unwrap_or(0);
        let index = &recurrence.index;
        let why = format!(
            "modulo {modulus} the sides differ from {index} = {from} on, where the terms come round after {length} steps"
        );
        Some(Tail::Never(from, why))
    })
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
