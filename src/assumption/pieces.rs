//! Questions about one variable in values that are made of maxima and conditions of lines: every point where something
//! changes is found, so what holds at these points and between them holds everywhere.

use std::cell::RefCell;
use std::cmp::Ordering;
use std::collections::HashMap;
use std::rc::Rc;

use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use super::Assumptions;
use super::sign::Signs;
use crate::name::Name;
use crate::polynomial::Polynomial;
use crate::value::{Atom, Relation, Value};

/// The most points where something changes.
const MOST_BREAKS: usize = 200;

/// How often one factor may stand in a product.
const MOST_FACTORS: u32 = 8;

/// How many functions are remembered.
const MOST_KNOWN: usize = 5_000;

/// What values are of a variable, where they are of this kind.
type Known = HashMap<(Value, Name), Option<Rc<Pieces>>>;

thread_local! {
    static KNOWN: RefCell<Known> = RefCell::new(HashMap::new());
}

/// A function of one number that is a line between these points, and anything at them.
#[derive(Clone, Debug)]
struct Pieces {
    /// In ascending order.
    breaks: Vec<BigRational>,
    /// Its values there.
    at: Vec<BigRational>,
    /// The line before the first point, between each and the next, and behind the last.
    lines: Vec<Line>,
}

/// Slope and constant.
#[derive(Clone, PartialEq, Eq, Debug)]
struct Line(BigRational, BigRational);

impl Line {
    fn constant(value: BigRational) -> Line {
        Line(BigRational::zero(), value)
    }

    fn at(&self, point: &BigRational) -> BigRational {
        &self.0 * point + &self.1
    }

    /// Where it is 0, if at one point only.
    fn zero(&self) -> Option<BigRational> {
        (!self.0.is_zero()).then(|| -&self.1 / &self.0)
    }

    fn minus(&self, other: &Line) -> Line {
        Line(&self.0 - &other.0, &self.1 - &other.1)
    }

    /// The product, where it is a line.
    fn times(&self, other: &Line) -> Option<Line> {
        let (factor, line) = match (self.0.is_zero(), other.0.is_zero()) {
            (true, _) => (&self.1, other),
            (_, true) => (&other.1, self),
            _ => return None,
        };
        Some(Line(factor * &line.0, factor * &line.1))
    }
}

/// A point of each stretch between these.
fn between(breaks: &[BigRational]) -> Vec<BigRational> {
    let one = BigRational::one();
    let (Some(first), Some(last)) = (breaks.first(), breaks.last()) else { return vec![BigRational::zero()] };
    let middles = breaks.windows(2).map(|pair| (&pair[0] + &pair[1]) / (&one + &one));
    std::iter::once(first - &one).chain(middles).chain([last + &one]).collect()
}

impl Pieces {
    fn line(line: Line) -> Pieces {
        Pieces { breaks: Vec::new(), at: Vec::new(), lines: vec![line] }
    }

    /// The function that a value is of this variable, if it is of this kind: the same are asked for again and again.
    fn of(value: &Value, name: &Name) -> Option<Rc<Pieces>> {
        let question = (value.clone(), name.clone());
        if let Some(known) = KNOWN.with_borrow(|known| known.get(&question).cloned()) {
            return known;
        }
        let found = Pieces::found(value, name).map(Rc::new);
        KNOWN.with_borrow_mut(|known| {
            if known.len() >= MOST_KNOWN {
                known.clear();
            }
            known.insert(question, found.clone());
        });
        found
    }

    fn found(value: &Value, name: &Name) -> Option<Pieces> {
        let (numerator, denominator) = value.polynomials()?;
        let below = denominator.as_constant().filter(|below| !below.is_zero())?;
        let mut sum = Pieces::line(Line::constant(BigRational::zero()));
        for (monomial, coefficient) in numerator.terms() {
            let mut term = Pieces::line(Line::constant(coefficient / &below));
            for (atom, exponent) in monomial.factors() {
                let factor = Pieces::of_atom(atom, name).filter(|_| *exponent <= MOST_FACTORS)?;
                for _ in 0..*exponent {
                    term = term.with(&factor, Line::times, |one, other| one * other)?;
                }
            }
            sum = sum.with(
                &term,
                |one, other| Some(Line(&one.0 + &other.0, &one.1 + &other.1)),
                |one, other| one + other,
            )?;
        }
        Some(sum)
    }

    fn of_atom(atom: &Atom, name: &Name) -> Option<Pieces> {
        match atom {
            Atom::Variable(own) if own == name => Some(Pieces::line(Line(BigRational::one(), BigRational::zero()))),
            Atom::Maximum(parts) => {
                let zero = Pieces::line(Line::constant(BigRational::zero()));
                parts.iter().try_fold(zero, |most, part| most.or_more(&*Pieces::of(part, name)?))
            }
            Atom::Positive(part) => Pieces::of(part, name)?.is_positive(),
            _ => None,
        }
    }

    /// The same function with more points.
    fn refined(&self, points: &[BigRational]) -> Option<Pieces> {
        let mut breaks: Vec<BigRational> = self.breaks.iter().chain(points).cloned().collect();
        breaks.sort();
        breaks.dedup();
        if breaks.len() > MOST_BREAKS {
            return None;
        }
        let at = breaks.iter().map(|point| self.value(point)).collect();
        let lines = between(&breaks).iter().map(|point| self.around(point).clone()).collect();
        Some(Pieces { breaks, at, lines })
    }

    /// The line that it is around a point that is none of its own.
    fn around(&self, point: &BigRational) -> &Line {
        &self.lines[self.breaks.partition_point(|own| own < point)]
    }

    fn value(&self, point: &BigRational) -> BigRational {
        match self.breaks.binary_search(point) {
            Ok(place) => self.at[place].clone(),
            Err(_) => self.around(point).at(point),
        }
    }

    /// Two functions put together, line by line and point by point.
    fn with(
        &self,
        other: &Pieces,
        lines: impl Fn(&Line, &Line) -> Option<Line>,
        values: impl Fn(&BigRational, &BigRational) -> BigRational,
    ) -> Option<Pieces> {
        let (one, other) = (self.refined(&other.breaks)?, other.refined(&self.breaks)?);
        let at = one.at.iter().zip(&other.at).map(|(one, other)| values(one, other)).collect();
        let lines = one.lines.iter().zip(&other.lines).map(|(one, other)| lines(one, other)).collect::<Option<_>>()?;
        Some(Pieces { breaks: one.breaks, at, lines }.plain())
    }

    /// Without points at which nothing changes.
    fn plain(self) -> Pieces {
        let mut plain = Pieces { breaks: Vec::new(), at: Vec::new(), lines: self.lines[..1].to_vec() };
        for ((point, at), line) in self.breaks.into_iter().zip(self.at).zip(&self.lines[1..]) {
            if plain.lines.last() == Some(line) && line.at(&point) == at {
                continue;
            }
            plain.breaks.push(point);
            plain.at.push(at);
            plain.lines.push(line.clone());
        }
        plain
    }

    /// Where it may change its sign: its own points, and where its lines are 0.
    fn turns(&self) -> Vec<BigRational> {
        self.breaks.iter().cloned().chain(self.lines.iter().filter_map(Line::zero)).collect()
    }

    /// The larger of two functions.
    fn or_more(&self, other: &Pieces) -> Option<Pieces> {
        let minus = |one: &Line, other: &Line| Some(one.minus(other));
        let turns = self.with(other, minus, |one, other| one - other)?.turns();
        let (one, other) =
            (self.refined(&turns)?.refined(&other.breaks)?, other.refined(&turns)?.refined(&self.breaks)?);
        let at = one.at.iter().zip(&other.at).map(|(one, other)| one.max(other).clone()).collect();
        let sides = between(&one.breaks).into_iter().zip(one.lines.iter().zip(&other.lines));
        let larger = |(point, (one, other)): (BigRational, (&Line, &Line))| {
            if one.at(&point) >= other.at(&point) { one.clone() } else { other.clone() }
        };
        let lines = sides.map(larger).collect();
        Some(Pieces { breaks: one.breaks, at, lines }.plain())
    }

    /// 1 where it is more than 0, and 0 elsewhere.
    fn is_positive(&self) -> Option<Pieces> {
        let own = self.refined(&self.turns())?;
        let truth = |value: BigRational| if value.is_positive() { BigRational::one() } else { BigRational::zero() };
        let sides = between(&own.breaks).into_iter().zip(&own.lines);
        let lines = sides.map(|(point, line)| Line::constant(truth(line.at(&point)))).collect();
        let at = own.at.into_iter().map(truth).collect();
        Some(Pieces { breaks: own.breaks, at, lines }.plain())
    }
}

/// The one variable of a value.
fn one_variable(value: &Value) -> Option<Name> {
    let mut names = value.variables().into_iter();
    names.next().filter(|_| names.next().is_none())
}

/// Whether a maximum or a condition stands in a value.
fn is_folded(value: &Value) -> bool {
    let folded = |form: &Polynomial<Atom>| {
        form.terms()
            .iter()
            .flat_map(|(monomial, _)| monomial.factors())
            .any(|(atom, _)| matches!(atom, Atom::Maximum(_) | Atom::Positive(_)))
    };
    value.polynomials().is_some_and(|(numerator, _)| folded(numerator))
}

/// The corners that the maxima in a value are written with.
fn corners(value: &Value) -> usize {
    let of = |atom: Atom| {
        let own = if let Atom::Maximum(parts) = &atom { parts.len() } else { 0 };
        own + atom.parts().into_iter().map(corners).sum::<usize>()
    };
    value.atoms().into_iter().map(of).sum()
}

/// The same value, written with one maximum for each corner that its line has, where it is written with more: a step of
/// limited length after another is one of twice that length, and after eight of them has two corners, not 256.
pub(crate) fn with_fewest_corners(value: &Value) -> Value {
    let written = corners(value);
    let fewer = || {
        let name = one_variable(value).filter(|_| written > 2)?;
        let pieces = Pieces::of(value, &name)?;
        let ends = pieces.breaks.iter().zip(&pieces.at).zip(pieces.lines.windows(2));
        let whole = ends.clone().all(|((point, at), sides)| sides.iter().all(|side| side.at(point) == *at));
        if !whole || pieces.breaks.len() >= written {
            return None;
        }
        let (x, Line(slope, constant)) = (Value::variable(&name), pieces.lines.first()?);
        let mut sum = x.scale(slope).and_then(|way| way.add(&Value::rational(constant.clone()))).ok()?;
        for ((point, _), sides) in ends {
            let [before, after] = sides else { return None };
            let beyond = Value::maximum(&[Value::zero(), x.sub(&Value::rational(point.clone())).ok()?]).ok()?;
            sum = beyond.scale(&(&after.0 - &before.0)).and_then(|bend| sum.add(&bend)).ok()?;
        }
        Some(sum)
    };
    fewer().unwrap_or_else(|| value.clone())
}

impl Assumptions {
    /// The signs that a value of one variable may have where all hold that is stated of this variable alone, and whether
    /// nothing else is stated of it; nothing where it is not of this kind, or no number meets what is stated.
    pub(super) fn signs_in_pieces(&self, value: &Value) -> Option<(Signs, bool)> {
        let name = one_variable(value)?;
        let stated = || self.stated.iter().filter(|(_, fact)| fact.variables().iter().eq([&name]));
        if !is_folded(value) && !stated().any(|(_, fact)| is_folded(fact)) {
            return None;
        }
        let own = Pieces::of(value, &name)?;
        let facts: Vec<(Relation, Rc<Pieces>)> =
            stated().filter_map(|(relation, fact)| Some((*relation, Pieces::of(fact, &name)?))).collect();
        let mut points: Vec<BigRational> = own.turns();
        points.extend(facts.iter().flat_map(|(_, fact)| fact.turns()));
        points.sort();
        points.dedup();
        if points.len() > MOST_BREAKS {
            return None;
        }
        points.extend(between(&points));
        let met = |point: &&BigRational| {
            let holds = |(relation, fact): &(Relation, Rc<Pieces>)| relation.holds(sign(&fact.value(point)));
            facts.iter().all(holds)
        };
        let signs = points.iter().filter(met).map(|point| Signs::of_number(&own.value(point))).reduce(Signs::or)?;
        let all = self.stated.iter().filter(|(_, fact)| fact.mentions(&name)).count() == facts.len();
        Some((signs, all && !self.naturals.contains(&name)))
    }
}

fn sign(number: &BigRational) -> Ordering {
    number.cmp(&BigRational::zero())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn x() -> Value {
        Value::variable(&Name::new("x"))
    }

    fn ratio(above: i64, below: i64) -> Value {
        Value::rational(BigRational::new(above.into(), below.into()))
    }

    /// Numbers below a count, in an order of their own.
    fn numbers(mut seed: u64) -> impl FnMut(usize) -> usize {
        move |count: usize| {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 33) as usize % count
        }
    }

    /// A value of x at a number.
    fn at(value: &Value, point: &Value) -> BigRational {
        value.with(&Name::new("x"), point).ok().and_then(|value| value.as_rational()).expect("a number")
    }

    /// Sums, maxima and choices of x and small numbers, so deep.
    fn any(next: &mut dyn FnMut(usize) -> usize, depth: usize) -> Value {
        let number = |next: &mut dyn FnMut(usize) -> usize| {
            ratio(i64::try_from(next(9)).unwrap() - 4, 1 + i64::try_from(next(3)).unwrap())
        };
        if depth == 0 {
            return if next(2) == 0 { x() } else { number(next) };
        }
        let (one, other) = (any(next, depth - 1), any(next, depth - 1));
        match next(5) {
            0 => one.add(&other),
            1 => one.sub(&other),
            2 => Value::maximum(&[one, other]),
            3 => one.mul(&number(next)),
            _ => {
                let holds = Value::truth(Relation::Gtr, &one, &other).expect("a truth");
                Ok(holds.mul(&number(next)).and_then(|part| part.add(&other)).expect("a choice"))
            }
        }
        .expect("a value")
    }

    #[test]
    fn what_holds_at_some_number_is_found_and_nothing_else() {
        let mut next = numbers(11);
        let (mut found, mut decided) = (0, 0);
        for _ in 0..400 {
            let (asked, first, second) = (any(&mut next, 4), any(&mut next, 3), any(&mut next, 2));
            let mut known = Assumptions::default();
            known.assume(Relation::Gte, &first, &Value::zero());
            known.assume([Relation::Neq, Relation::Gtr, Relation::Eq][next(3)], &second, &Value::zero());
            let Some((signs, _)) = known.signs_in_pieces(&asked) else { continue };
            found += 1;
            decided += usize::from(signs != Signs::ANY);
            for place in -240..=240 {
                let point = ratio(place, 12);
                let met = known.stated.iter().all(|(relation, fact)| relation.holds(sign(&at(fact, &point))));
                let own = Signs::of_number(&at(&asked, &point));
                assert!(!met || own.within(signs), "{asked} at {point}, where {:?}", known.stated);
            }
        }
        assert!(found > 150 && decided > 50, "{found} {decided}");
    }

    #[test]
    fn a_value_with_fewer_corners_is_the_same_at_every_number() {
        let mut next = numbers(5);
        let mut shorter = 0;
        for _ in 0..400 {
            let value = any(&mut next, 4);
            let short = with_fewest_corners(&value);
            shorter += usize::from(short != value);
            for place in -240..=240 {
                let point = ratio(place, 12);
                assert_eq!(at(&value, &point), at(&short, &point), "{value} and {short} at {point}");
            }
        }
        assert!(shorter > 20, "{shorter}");
    }

    #[test]
    fn a_clamped_step_after_another_is_known() {
        let step = |r: &Value| {
            let limit = Value::maximum(&[Value::integer(-1), r.neg().expect("a step")]).expect("a limit");
            let limit = limit.neg().and_then(|limit| Value::maximum(&[Value::integer(-1), limit])).expect("a limit");
            r.sub(&limit).expect("a place")
        };
        let mut known = Assumptions::default();
        let third = step(&step(&step(&x())));
        let eighth = (0..5).fold(third.clone(), |place, _| with_fewest_corners(&step(&place)));
        assert_eq!(corners(&eighth), 2, "{eighth}");
        known.assume(Relation::Neq, &third, &Value::zero());
        known.assume(Relation::Gte, &x(), &Value::zero());
        assert_eq!(known.decide(Relation::Gtr, &x(), &Value::integer(3)), Some(true), "{third}");
        assert_eq!(known.decide(Relation::Gtr, &step(&third), &Value::zero()), None);
        assert_eq!(known.decide(Relation::Gte, &step(&third), &Value::zero()), Some(true));
    }
}
