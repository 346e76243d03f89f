//! A system that takes the same ways again and again though its values go on, as some of these are only looked at modulo a
//! number: of a counter that runs on, and is read by `mod(k,3)`, all that matters is what is left of k by 3.
//!
//! A state is followed with what is left of such values. What is dropped is a multiple of the modulus, and the ways, the times
//! and what the other values become are the same whatever multiple that is.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use num_bigint::BigInt;
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{One, Signed};

use super::course::{Course, MOST_SIZE, steering_of, way};
use super::{Edge, Next, Period, open_name};
use crate::assumption::Assumptions;
use crate::name::Name;
use crate::polynomial::{Monomial, Polynomial};
use crate::value::{Atom, Sort, Value, ValueError};

/// Rounds that are followed.
const MOST_ROUNDS: usize = 10_000;
/// The greatest modulus.
const MOST_MODULUS: u32 = 5_000;

/// Which values of which phases are looked at modulo a number.
struct Residues {
    modulus: BigInt,
    /// By phase.
    names: Vec<BTreeSet<Name>>,
    /// By phase, those that something needs to be natural, as it has them for an exponent, say: what is dropped of these is
    /// not less than 0.
    natural: Vec<BTreeSet<Name>>,
    /// Whether the others are integers: more comes to the same then, as `mod(k*k,3)` does.
    integers: bool,
}

/// A way that was taken, how long it took, and the state that it left: only what is kept, modulo.
struct Taken<'a> {
    edge: &'a Edge,
    lasting: Value,
    time: Value,
    phase: usize,
    state: BTreeMap<Name, Value>,
}

impl Taken<'_> {
    /// Whether the same happens from the same values, but for those that go on.
    fn is_as(&self, other: &Taken<'_>, beside: &BTreeSet<Name>) -> bool {
        let same = |(name, value): (&Name, &Value)| beside.contains(name) || other.state.get(name) == Some(value);
        std::ptr::eq(self.edge, other.edge) && self.lasting == other.lasting && self.state.iter().all(same)
    }
}

impl Period {
    /// Where the same ways come again as what goes on beside is only looked at modulo a number: after that time it is again
    /// as it was, but for these values. None where that is not found.
    pub fn congruent(&self, assumptions: &Assumptions, interrupted: &dyn Fn() -> bool) -> Option<Course> {
        let ways: Vec<&[Edge]> = self.phases.iter().map(|phase| phase.edges.as_slice()).collect();
        let all: Vec<BTreeSet<Name>> =
            self.phases.iter().map(|phase| phase.variables.iter().cloned().collect()).collect();
        let course = |kept: &[BTreeSet<Name>]| {
            let follow = |residues: Residues| residues.follow(self, kept, assumptions, interrupted);
            [true, false].into_iter().find_map(|integers| follow(Residues::of(&ways, kept, integers, interrupted)?))
        };
        let steered = course(&steering_of(&ways))?;
        // What is looked at no more makes no state another, as long as it is no other in the end.
        match (course(&all), &steered) {
            (Some(Course::Repeats { lasting, beside, .. }), Course::Repeats { lasting: same, beside: also, .. })
                if lasting == *same && beside == *also =>
            {
                Some(steered)
            }
            (whole, _) => whole.or(Some(steered)),
        }
    }
}

impl Residues {
    /// The most values that may be taken modulo what they are divided by; none where these are none.
    fn of(
        ways: &[&[Edge]],
        kept: &[BTreeSet<Name>],
        integers: bool,
        interrupted: &dyn Fn() -> bool,
    ) -> Option<Residues> {
        let every = ways.iter().copied().flatten();
        let values = every.flat_map(|edge| looked_at(edge).into_iter().chain(edge.map.values().cloned()));
        let modulus = values.flat_map(|value| divisors(&value)).fold(BigInt::one(), |all, one| all.lcm(&one));
        if modulus.is_one() || modulus > BigInt::from(MOST_MODULUS) {
            return None;
        }
        let mut residues = Residues { modulus, names: kept.to_vec(), natural: natural(ways), integers };
        loop {
            if interrupted() {
                return None;
            }
            let mut fewer = residues.names.clone();
            for (phase, edges) in ways.iter().enumerate() {
                let allows = |name: &&Name| edges.iter().all(|edge| residues.allows((phase, edge), name, kept));
                *fewer.get_mut(phase)? = residues.names.get(phase)?.iter().filter(allows).cloned().collect();
            }
            if fewer == residues.names {
                return residues.names.iter().any(|names| !names.is_empty()).then_some(residues);
            }
            residues.names = fewer;
        }
    }

    fn modulo(&self, phase: usize, name: &Name) -> bool {
        self.names.get(phase).is_some_and(|names| names.contains(name))
    }

    fn is_natural(&self, phase: usize, name: &Name) -> bool {
        self.natural.get(phase).is_some_and(|names| names.contains(name))
    }

    /// Whether a way leads to the same whatever multiple of the modulus is added to this value of the phase that it leaves.
    fn allows(&self, (phase, edge): (usize, &Edge), name: &Name, kept: &[BTreeSet<Name>]) -> bool {
        let meant = |value: &Value| !value.mentions(name) || self.has_meaning(value, phase);
        let same = looked_at(edge).iter().all(|value| self.is_periodic(value, name, phase))
            && edge.shown_and_passed().chain(edge.map.values()).all(meant);
        let Next::Phase(next) = edge.next else { return same };
        let matters = |name: &Name| kept.get(next).is_some_and(|names| names.contains(name));
        same && edge.map.iter().all(|(image, value)| match self.modulo(next, image) {
            true => self.is_congruent(value, name, phase, self.is_natural(next, image)),
            false => !matters(image) || self.is_periodic(value, name, phase),
        })
    }

    /// What is added to a value if the modulus is added to one that it depends on. For each integer that is taken modulo an
    /// integer part stands, but for what may be an exponent.
    fn difference(&self, value: &Value, name: &Name, phase: usize) -> Option<Value> {
        if value.sort() == Sort::Distribution {
            return None;
        }
        let integer = |name: &Name| match self.integers && !self.is_natural(phase, name) {
            true => Value::variable(&open_name(name)).floor().ok(),
            false => Some(Value::variable(name)),
        };
        let images = self.names.get(phase)?.iter().map(|name| Some((name.clone(), integer(name)?)));
        let mut images = images.collect::<Option<BTreeMap<Name, Value>>>()?;
        let before = apart(&value.substitute(&images).ok()?).ok()?;
        images.insert(name.clone(), integer(name)?.add(&self.modulus()).ok()?);
        apart(&value.substitute(&images).ok()?).ok()?.sub(&before).ok()
    }

    fn modulus(&self) -> Value {
        Value::rational(BigRational::from_integer(self.modulus.clone()))
    }

    /// Whether a value has a meaning, and is the same if the modulus is added to one that it depends on.
    fn is_periodic(&self, value: &Value, name: &Name, phase: usize) -> bool {
        let same = || self.difference(value, name, phase).is_some_and(|difference| difference.is_zero());
        !value.mentions(name) || self.has_meaning(value, phase) && same()
    }

    /// Whether a value changes by a multiple of the modulus if the modulus is added to one that it depends on, by one from 0 on
    /// if it is to be natural. That it is an integer itself is seen where it is come to.
    fn is_congruent(&self, value: &Value, name: &Name, phase: usize, natural: bool) -> bool {
        if self.is_periodic(value, name, phase) {
            return true;
        }
        let times = self.difference(value, name, phase).and_then(|difference| difference.div(&self.modulus()).ok());
        let grows = |times: &Value| times.as_rational().is_some_and(|times| !times.is_negative());
        times.is_some_and(|times| {
            times.floor().is_ok_and(|floor| floor == times)
                && self.has_meaning(value, phase)
                && (!natural || self.is_natural(phase, name) && grows(&times))
        })
    }

    /// Whether a value has a meaning whatever the integers of this phase are.
    fn has_meaning(&self, value: &Value, phase: usize) -> bool {
        let needs = value.needs();
        if needs.is_empty() {
            return true;
        }
        let mut known = Assumptions::default();
        for name in self.names.get(phase).into_iter().flatten().filter(|name| self.is_natural(phase, name)) {
            known.assume_natural(name);
        }
        needs.iter().all(|need| known.grants(need) == Some(true))
    }

    /// What is left of a value that may be taken modulo; none of one that may not be.
    fn left_of(&self, value: &Value, natural: bool) -> Option<Value> {
        let number = value.as_rational()?;
        if (natural || self.integers) && !number.is_integer() || natural && number.is_negative() {
            return None;
        }
        let modulus = BigRational::from_integer(self.modulus.clone());
        Some(Value::rational(&number - (&number / &modulus).floor() * modulus))
    }

    fn follow(
        &self,
        period: &Period,
        kept: &[BTreeSet<Name>],
        assumptions: &Assumptions,
        interrupted: &dyn Fn() -> bool,
    ) -> Option<Course> {
        let (mut edges, mut state, mut time) = (period.initial.as_slice(), BTreeMap::new(), Value::zero());
        let mut seen: HashMap<(usize, BTreeMap<Name, Value>), usize> = HashMap::new();
        let mut taken: Vec<Taken<'_>> = Vec::new();
        // The values of which something was dropped, from the start on.
        let mut cut: BTreeSet<(usize, Name)> = BTreeSet::new();
        let mut phase = None;
        while taken.len() < MOST_ROUNDS && !interrupted() {
            let edge = way(edges, &state, assumptions)?;
            let Next::Phase(number) = edge.next else { return None };
            let lasting = edge.duration().ok()?.substitute(&state).ok()?;
            let later = time.add(&lasting).ok()?;
            let held = edge.map.iter().filter(|(name, _)| kept.get(number).is_some_and(|all| all.contains(*name)));
            let next = held.map(|(name, value)| {
                let value = assumptions.with_equations(value.substitute(&state).ok()?);
                let left = if self.modulo(number, name) {
                    self.left_of(&value, self.is_natural(number, name))?
                } else {
                    value.clone()
                };
                if left != value {
                    cut.insert((number, name.clone()));
                }
                let value = left;
                (value.size() <= MOST_SIZE && value.bits() <= u64::from(MOST_MODULUS)).then(|| (name.clone(), value))
            });
            let next: BTreeMap<Name, Value> = next.collect::<Option<_>>()?;
            if let Some(phase) = phase {
                taken.push(Taken { edge, lasting, time, phase, state });
            }
            (edges, phase, state, time) = (&period.phases.get(number)?.edges, Some(number), next, later);
            if let Some(first) = seen.insert((number, state.clone()), taken.len()) {
                return self.again(period, (&taken, first), &cut);
            }
        }
        None
    }

    /// What comes again, if the ways from this one on do, with what is left of the values.
    fn again(
        &self,
        period: &Period,
        (taken, first): (&[Taken<'_>], usize),
        cut: &BTreeSet<(usize, Name)>,
    ) -> Option<Course> {
        let cycle = taken.get(first..)?;
        let beside = self.beside(taken, cut);
        // With a modulus that is greater than it need be the ways may come again earlier, and have come before.
        let length = cycle.len();
        let shifted =
            |by: usize| cycle.iter().zip(cycle.iter().cycle().skip(by)).all(|(one, other)| one.is_as(other, &beside));
        let least = (1..=length).find(|by| length.is_multiple_of(*by) && shifted(*by))?;
        let earlier = (0..first).rev().take_while(|place| {
            let (one, later) = (taken.get(*place), taken.get(*place + length));
            one.zip(later).is_some_and(|(one, later)| one.is_as(later, &beside))
        });
        let from = earlier.last().unwrap_or(first);
        let lasting = cycle.iter().take(least).try_fold(Value::zero(), |sum, one| sum.add(&one.lasting).ok())?;
        let beside = beside.into_iter().chain(self.dropped(period, cycle)).collect();
        (!lasting.is_zero()).then(|| Course::Repeats { lasting, from: taken[from].time.clone(), beside })
    }

    /// The values that may be others each time: those of which something was dropped at any time, also before the ways come
    /// again, and what is made of them. That what is left comes again says nothing of these: 2, 6, 18, … all leave 0 by 2.
    fn beside(&self, taken: &[Taken<'_>], cut: &BTreeSet<(usize, Name)>) -> BTreeSet<Name> {
        let mut found = cut.clone();
        loop {
            let mut more = found.clone();
            for one in taken {
                let Next::Phase(next) = one.edge.next else { continue };
                for (name, value) in one.edge.map.iter().filter(|(name, _)| self.modulo(next, name)) {
                    // What only depends on what is left is the same each time.
                    let goes_on = |from: &Name| {
                        found.contains(&(one.phase, from.clone())) && !self.is_periodic(value, from, one.phase)
                    };
                    if value.variables().iter().any(goes_on) {
                        more.insert((next, name.clone()));
                    }
                }
            }
            if more == found {
                return found.into_iter().map(|(_, name)| name).collect();
            }
            found = more;
        }
    }

    /// Values that no way depends on and that are not known to be the same each time: those are that are carried on as they
    /// are, or made of what is the same.
    fn dropped(&self, period: &Period, cycle: &[Taken<'_>]) -> BTreeSet<Name> {
        let phases: BTreeSet<usize> = cycle.iter().map(|one| one.phase).collect();
        let others = |phase: &usize| {
            let kept =
                cycle.iter().find(|one| one.phase == *phase).map(|one| one.state.keys().collect::<BTreeSet<_>>());
            let all = period.phases.get(*phase).map(|phase| phase.variables.clone()).unwrap_or_default();
            let others = all.into_iter().filter(|name| kept.as_ref().is_none_or(|kept| !kept.contains(name)));
            others.map(|name| (*phase, name)).collect::<Vec<_>>()
        };
        let mut open: BTreeSet<(usize, Name)> = phases.iter().flat_map(others).collect();
        loop {
            let same = |(phase, name): &(usize, Name)| {
                let mut into = cycle.iter().filter(|one| one.edge.next == Next::Phase(*phase));
                into.all(|one| {
                    let Some(value) = one.edge.map.get(name) else { return false };
                    value.as_variable() == Some(name)
                        || value.variables().iter().all(|from| {
                            !open.contains(&(one.phase, from.clone()))
                                && (!self.modulo(one.phase, from) || self.is_periodic(value, from, one.phase))
                        })
                })
            };
            let left: BTreeSet<(usize, Name)> = open.iter().filter(|one| !same(one)).cloned().collect();
            if left == open {
                return left.into_iter().map(|(_, name)| name).collect();
            }
            open = left;
        }
    }
}

/// What the course of a way depends on besides the values that it leads to.
fn looked_at(edge: &Edge) -> Vec<Value> {
    let tests = edge.tests.iter().flat_map(|test| [test.left.clone(), test.right.clone()]);
    tests.chain(edge.duration()).collect()
}

/// By phase, the values that must be natural so that something has a meaning, also by what they become.
fn natural(ways: &[&[Edge]]) -> Vec<BTreeSet<Name>> {
    let mut found: Vec<BTreeSet<Name>> = vec![BTreeSet::new(); ways.len()];
    loop {
        let before = found.clone();
        for (own, edge) in ways.iter().enumerate().flat_map(|(own, edges)| edges.iter().map(move |edge| (own, edge))) {
            let mut names = BTreeSet::new();
            for need in
                looked_at(edge).iter().chain(edge.shown_and_passed()).chain(edge.map.values()).flat_map(Value::needs)
            {
                names.extend(need.value().variables());
            }
            if let Next::Phase(next) = edge.next {
                let becomes =
                    edge.map.iter().filter(|(name, _)| before.get(next).is_some_and(|all| all.contains(*name)));
                names.extend(becomes.flat_map(|(_, value)| value.variables()));
            }
            found.get_mut(own).into_iter().for_each(|all| all.extend(names.iter().cloned()));
        }
        if found == before {
            return found;
        }
    }
}

/// A value whose integer parts hold no multiple of an integer: `floor(5*k/3)` of an integer k is `k + floor(2*k/3)`.
fn apart(value: &Value) -> Result<Value, ValueError> {
    value.replace(&mut |atom| {
        let Atom::Floor(inner) = atom else { return None };
        let inner = apart(inner).ok()?;
        let (above, below) = inner.polynomials()?;
        let integral = |monomial: &Monomial<Atom>| monomial.factors().iter().all(|(atom, _)| atom.is_integral());
        let terms = above.terms().iter().filter(|(monomial, _)| below.is_one() && integral(monomial));
        let wholes = terms.map(|(monomial, number)| (monomial.clone(), number.floor()));
        let wholes = Value::from_polynomials(Polynomial::of(wholes), Polynomial::one()).ok()?;
        inner.sub(&wholes).and_then(|rest| rest.floor()?.add(&wholes)).ok()
    })
}

/// What integer parts look at values modulo, and after how many the powers in them come again.
fn divisors(value: &Value) -> Vec<BigInt> {
    let mut found = Vec::new();
    for atom in value.atoms() {
        match &atom {
            Atom::Floor(inner) => {
                let numbers = inner.polynomials().into_iter().flat_map(|(above, _)| above.terms().iter());
                let divisor = numbers.fold(BigInt::one(), |all, (_, number)| all.lcm(number.denom()));
                found.extend(inner.atoms().iter().filter_map(|atom| match atom {
                    Atom::Power(base, _) => order(&base.as_rational()?, &divisor),
                    _ => None,
                }));
                found.push(divisor);
            }
            Atom::Power(base, _) if base.as_rational().is_some_and(|base| base == -BigRational::one()) => {
                found.push(BigInt::from(2));
            }
            _ => {}
        }
        found.extend(atom.parts().into_iter().flat_map(divisors));
    }
    found
}

/// After how many the powers of an integer leave the same by this divisor; none where they do not do so from the first on.
fn order(base: &BigRational, divisor: &BigInt) -> Option<BigInt> {
    let base = Some(base.to_integer()).filter(|_| base.is_integer() && *divisor <= BigInt::from(MOST_MODULUS))?;
    let mut power = BigInt::one();
    (1..=MOST_MODULUS).find_map(|count| {
        power = (&power * &base).mod_floor(divisor);
        (power == BigInt::one().mod_floor(divisor)).then(|| BigInt::from(count))
    })
}
