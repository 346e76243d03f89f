//! Maxima and conditions in the form in which people write them: `abs(x)`, `min(a,b)`, `if x > y then … else …`.

use std::sync::Arc;

use num_rational::BigRational;
use num_traits::Signed;

use super::super::line::{Place, decided, placed};
use super::{Atom, Level, Monomial, Piece, Polynomial, Printer, Real, Text, Value, wrap};

/// A term `coefficient * cofactor * max(0, elements)`.
struct Hinge {
    coefficient: BigRational,
    cofactor: Monomial<Atom>,
    elements: Arc<[Value]>,
}

/// A fraction by the sign of a value: the comparison that tells its ways apart, and what it is where that holds and where
/// not; or of three ways where the value is more than 0, less, and equal to it.
struct Split {
    condition: Value,
    symbol: Option<&'static str>,
    ways: Vec<Value>,
}

/// Values side by side where a comparison with 0 holds and where it does not.
struct Ways {
    condition: Value,
    symbol: &'static str,
    then: Vec<Value>,
    other: Vec<Value>,
}

impl Ways {
    /// Whether the comparison has a value always; else it stands behind what gives it one.
    fn always_asked(&self) -> bool {
        self.condition.needs().is_empty()
    }

    /// Where one way is this, the comparison for the other way, and that.
    fn beside(&self, way: &[Value]) -> Option<(&'static str, Vec<Value>)> {
        if self.other == way {
            Some((self.symbol, self.then.clone()))
        } else {
            (self.then == way).then(|| (contrary(self.symbol), self.other.clone()))
        }
    }
}

/// The comparison that holds where this one does not.
fn contrary(symbol: &str) -> &'static str {
    match symbol {
        "=" => "!=",
        "!=" => "=",
        "<" => ">=",
        ">=" => "<",
        ">" => "<=",
        _ => ">",
    }
}

/// The most conditions that are joined in one text.
const MOST_JOINED: usize = 4;

impl Printer {
    /// `if p > 0 then … else …` for a fraction with conditions in its numerator.
    pub(super) fn choice(&mut self, numerator: &Real, denominator: &Real) -> Option<Text> {
        let Split { condition, symbol, ways } = self.split(numerator, denominator)?;
        let (Some(symbol), [then, other]) = (symbol, ways.as_slice()) else {
            let (first, second) = (self.condition(&condition, ">"), self.condition(&condition, "<"));
            let texts: Vec<_> = ways.iter().map(|part| wrap(self.value(part), Level::Sum)).collect();
            let text = format!("if {first} then {} else if {second} then {} else {}", texts[0], texts[1], texts[2]);
            return Some((text, Level::Choice));
        };
        let ways = Ways { condition, symbol, then: vec![then.clone()], other: vec![other.clone()] };
        Some((self.two_ways(ways), Level::Choice))
    }

    /// `if c then (a,b) else (d,e)` for a vector in which every component asks the same first.
    pub(super) fn choice_of_vectors(&mut self, parts: &[Value]) -> Option<Text> {
        let ways = self.asked_first(parts)?;
        Some((self.two_ways(ways), Level::Choice))
    }

    /// The choice as text; what is the same beside another condition is told once: `if a and b then … else …`.
    fn two_ways(&mut self, ways: Ways) -> String {
        let mut condition = self.condition(&ways.condition, ways.symbol);
        let (mut then, mut other) = (ways.then, ways.other);
        let mut word = None;
        for _ in 1..MOST_JOINED {
            let before = self.expansions;
            if word != Some("or")
                && let Some(inner) = self.asked_first(&then).filter(Ways::always_asked)
                && let Some((symbol, rest)) = inner.beside(&other)
            {
                condition = format!("{condition} and {}", self.condition(&inner.condition, symbol));
                (then, word) = (rest, Some("and"));
                continue;
            }
            self.expansions = before;
            if word != Some("and")
                && let Some(inner) = self.asked_first(&other).filter(Ways::always_asked)
                && let Some((symbol, rest)) = inner.beside(&then)
            {
                condition = format!("{condition} or {}", self.condition(&inner.condition, contrary(symbol)));
                (other, word) = (rest, Some("or"));
                continue;
            }
            self.expansions = before;
            break;
        }
        let then = match then.as_slice() {
            [then] => wrap(self.value(then), Level::Sum),
            then => self.vector(then).0,
        };
        let other = match other.as_slice() {
            [other] => self.value(other).0,
            other => self.vector(other).0,
        };
        format!("if {condition} then {then} else {other}")
    }

    /// What all of these values ask first, where that tells two ways apart.
    fn asked_first(&mut self, parts: &[Value]) -> Option<Ways> {
        let before = self.expansions;
        let splits = parts.iter().map(|part| part.parts().and_then(|(top, below)| self.split(top, below)));
        let splits: Option<Vec<Split>> = splits.collect();
        let ways = || {
            let splits = splits.as_ref()?;
            let first = splits.first()?;
            let alike = |split: &Split| split.condition == first.condition && split.symbol == first.symbol;
            let symbol = first.symbol.filter(|_| splits.iter().all(alike))?;
            let [then, other] = [0, 1].map(|way| splits.iter().map(|split| split.ways[way].clone()).collect());
            Some(Ways { condition: first.condition.clone(), symbol, then, other })
        };
        let ways = ways();
        if ways.is_none() {
            self.expansions = before;
        }
        ways
    }

    /// What a fraction is where a condition in its numerator holds, where it does not, and on the line between.
    fn split(&mut self, numerator: &Real, denominator: &Real) -> Option<Split> {
        let conditions = || {
            numerator.atoms().into_iter().filter_map(|atom| match atom {
                Atom::Positive(condition) => Some((atom.clone(), condition.clone())),
                _ => None,
            })
        };
        let leads = |value: &Value| value.parts().is_some_and(|(top, _)| top.leading().is_positive());
        // What may have no value is asked behind the others.
        let last = |(_, condition): &(Atom, Value)| (!condition.needs().is_empty(), !leads(condition));
        let first = conditions().min_by_key(last)?;
        // Along one line in the order of the numbers: `if k = 0 … else if k = 1 … else if k = 2 …`.
        let alike = |found: &(Atom, Value)| last(found) == last(&first) && first.0.passes(&found.0).is_some();
        let (atom, condition) = conditions()
            .filter(alike)
            .min_by(|one, other| one.0.passes(&other.0).unwrap_or(std::cmp::Ordering::Equal))?;
        if self.expansions < 3 || denominator.degree_in(&atom) > 0 {
            return None;
        }
        self.expansions -= 3;
        let opposite = Atom::Positive(condition.neg().ok()?);
        let both = [atom.clone(), opposite.clone()];
        let part = |polynomial: Real| Value::quotient(polynomial, denominator.clone()).ok();
        let plain = |holds: Option<&Atom>| part(fixed(numerator, &both, holds));
        let (more, less, equal) = (plain(Some(&atom))?, plain(Some(&opposite))?, plain(None)?);
        let at = |atom: &Atom, place: Place| part(placed(numerator, atom, place));
        let (symbol, ways) = if more == less {
            (Some("="), vec![at(&atom, Place::On)?, more])
        } else if equal == more {
            (Some("<"), vec![at(&opposite, Place::Holds)?, at(&opposite, Place::Fails)?])
        } else if equal == less {
            (Some(">"), vec![at(&atom, Place::Holds)?, at(&atom, Place::Fails)?])
        } else {
            (None, vec![at(&atom, Place::Holds)?, at(&opposite, Place::Holds)?, at(&atom, Place::On)?])
        };
        Some(Split { condition, symbol, ways })
    }

    /// A comparison of a value with 0, its negative terms on the other side.
    pub(super) fn condition(&mut self, value: &Value, symbol: &str) -> String {
        if let Some(shorter) = self.remainder(value) {
            return self.condition(&shorter, symbol);
        }
        if let Some(parts) = value.components() {
            let open = parts.iter().filter(|part| !part.is_zero());
            return match symbol {
                "=" => open.map(|part| self.condition(part, symbol)).collect::<Vec<_>>().join(" and "),
                _ => format!("{} {symbol} ({})", self.value(value).0, vec!["0"; parts.len()].join(",")),
            };
        }
        let Some((numerator, _)) = value.parts().filter(|(_, denominator)| denominator.is_one()) else {
            return format!("{} {symbol} 0", wrap(self.value(value), Level::Sum));
        };
        let (pieces, rest) = match self.maxima(numerator) {
            Err(found) => found,
            Ok(_) => (Vec::new(), numerator.clone()),
        };
        // `floor(-x)` is read as what is subtracted, `ceil(x)`.
        let added =
            |(factors, number): &(Monomial<Atom>, BigRational)| number.is_positive() != self.is_ceiling(factors);
        let (more, less): (Vec<_>, Vec<_>) = rest.terms().iter().cloned().partition(added);
        let (less_pieces, more_pieces): (Vec<Piece>, Vec<Piece>) = pieces.into_iter().partition(|piece| piece.negative);
        let is_number = |(factors, _): &(Monomial<Atom>, BigRational)| factors.factors().is_empty();
        let bare = more_pieces.is_empty() && more.iter().all(is_number);
        // A number beside what is added alone stands on the right, `k > -1` and not `k+1 > 0`.
        let (apart, more): (Vec<_>, Vec<_>) = match less.is_empty() && less_pieces.is_empty() && !bare {
            true => more.into_iter().partition(is_number),
            false => (Vec::new(), more),
        };
        let less = if apart.is_empty() { less } else { apart };
        let left = self.joined(more_pieces, &Polynomial::of(more), &Monomial::one());
        let less_pieces = less_pieces.into_iter().map(|piece| Piece { negative: false, ..piece }).collect();
        let right = self.joined(less_pieces, &Polynomial::of(less).negated(), &Monomial::one());
        // A bare number stands on the right, `b < 7` and not `7 > b`.
        match left.0 == "0" || (bare && right.0 != "0") {
            true => format!("{} {} {}", wrap(right, Level::Sum), mirrored(symbol), wrap(left, Level::Sum)),
            false => format!("{} {symbol} {}", wrap(left, Level::Sum), wrap(right, Level::Sum)),
        }
    }

    /// Whether the negative of this is written with one integer part that is shorter for it, `ceil(x)` for `-floor(-x)`.
    fn is_ceiling(&self, factors: &Monomial<Atom>) -> bool {
        let mut floors = factors.factors().iter().filter_map(|(atom, power)| match atom {
            Atom::Floor(part) if *power == 1 => Some(part),
            _ => None,
        });
        let (Some(part), None) = (floors.next(), floors.next()) else { return false };
        let shorter = |opposite: Value| opposite.to_string().len() < part.to_string().len();
        part.neg().is_ok_and(shorter)
    }

    /// The maxima among the terms of a sum: the whole as one text, or pieces and what is left of the sum.
    pub(super) fn maxima(&mut self, sum: &Real) -> Result<Text, (Vec<Piece>, Real)> {
        let mut hinges = hinges(sum);
        if hinges.is_empty() || self.expansions == 0 {
            return Err((Vec::new(), sum.clone()));
        }
        self.expansions -= 1;
        let mut rest = hinges.iter().fold(sum.clone(), |rest, hinge| rest.minus(&hinge.polynomial()));
        let mut pieces = Vec::new();
        let mut place = 0;
        while place < hinges.len() {
            let found = self.absolute(&hinges[place], &mut rest).map(|piece| (piece, None));
            let found = found.or_else(|| self.clamped(&hinges, place, &mut rest));
            let found = found.or_else(|| self.clamped_by_symbol(&hinges, place, &mut rest));
            match found {
                Some((piece, partner)) => {
                    pieces.push(piece);
                    let partner = partner.unwrap_or(place);
                    hinges.swap_remove(place.max(partner));
                    if partner != place {
                        hinges.swap_remove(place.min(partner));
                    }
                    place = 0;
                }
                None => place += 1,
            }
        }
        if let ([hinge], true) = (hinges.as_slice(), pieces.is_empty())
            && let Some(text) = self.extremum(hinge, &rest)
        {
            return Ok(text);
        }
        Err((pieces, hinges.iter().fold(rest, |rest, hinge| rest.plus(&hinge.polynomial()))))
    }

    /// Whether maxima among the terms of a sum are written in a shorter form.
    pub(super) fn folds(&mut self, sum: &Real) -> bool {
        match self.maxima(sum) {
            Ok(_) => true,
            Err((pieces, _)) => !pieces.is_empty(),
        }
    }

    /// `2*max(0,x) - x` is `abs(x)`.
    fn absolute(&mut self, hinge: &Hinge, rest: &mut Real) -> Option<Piece> {
        let [inner] = &hinge.elements[..] else { return None };
        let (numerator, denominator) = inner.parts()?;
        let half = &hinge.coefficient / BigRational::from_integer(2.into());
        let wanted = numerator.times_term(&hinge.cofactor, &-half.clone())?;
        let there = |(monomial, number): &(Monomial<Atom>, BigRational)| {
            let same = |(other, factor): &(Monomial<Atom>, BigRational)| other == monomial && factor == number;
            rest.terms().iter().any(same)
        };
        if !denominator.is_one() || !wanted.terms().iter().all(there) {
            return None;
        }
        *rest = rest.minus(&wanted);
        let inner = format!("abs({})", self.value(inner).0);
        Some(self.piece(&half, &hinge.cofactor, inner))
    }

    /// `max(0,x) - max(0,x-w)` is `min(w,max(0,x))`, and with `-w/2` beside it `clamp(x-w/2,-w/2,w/2)`.
    fn clamped(&mut self, hinges: &[Hinge], place: usize, rest: &mut Real) -> Option<(Piece, Option<usize>)> {
        let hinge = &hinges[place];
        let pair = Pair::of(hinges, place)?;
        let there = coefficient_of(rest, &hinge.cofactor);
        let all = (0..hinges.len()).filter(|place| hinges[*place].cofactor == hinge.cofactor);
        let all: BigRational = all.filter_map(|place| Pair::of(hinges, place)).map(|pair| pair.moved()).sum();
        let one = BigRational::from_integer(1.into());
        let Pair { other, inner, width, negative } = &pair;
        let moved = pair.moved();
        if there == moved || there == all {
            // Bounds that are each other's opposites are those that were written.
            *rest = rest.minus(&Polynomial::term(hinge.cofactor.clone(), moved.clone()));
            let half = moved.abs();
            let middle = inner.sub(&Value::rational(half.clone())).ok()?;
            let middle = if *negative { middle.neg().ok()? } else { middle };
            let text = format!("clamp({},-{half},{half})", self.value(&middle).0);
            return Some((self.piece(&one, &hinge.cofactor, text), Some(*other)));
        }
        // Without its constant term the middle reads best; the bounds move with it.
        let low = -inner.parts()?.0.constant_term();
        let high = &low + width;
        let sign = if *negative { -low.clone() } else { low.clone() };
        *rest = rest.minus(&Polynomial::term(hinge.cofactor.clone(), sign));
        let middle = inner.add(&Value::rational(low.clone())).ok()?;
        let text = format!("min({high},max({low},{}))", self.value(&middle).0);
        let one = if *negative { -one } else { one };
        Some((self.piece(&one, &hinge.cofactor, text), Some(*other)))
    }

    /// `w + max(0,w+x) - max(0,2*w,w+x)` is `clamp(x,-w,w)`, and so is `w + max(0,-x-w) - max(0,-x-w,w-x)`.
    fn clamped_by_symbol(&mut self, hinges: &[Hinge], place: usize, rest: &mut Real) -> Option<(Piece, Option<usize>)> {
        let hinge = &hinges[place];
        let [inner] = &hinge.elements[..] else { return None };
        for (other, partner) in hinges.iter().enumerate().filter(|(other, _)| *other != place) {
            let second = match &partner.elements[..] {
                [first, second] if first == inner => second,
                [first, second] if second == inner => first,
                _ => continue,
            };
            if partner.coefficient != -&hinge.coefficient || partner.cofactor != hinge.cofactor {
                continue;
            }
            let half = |width: &Value| width.scale(&BigRational::new(1.into(), 2.into())).ok();
            let upward = || half(second).and_then(|half| Some((inner.sub(&half).ok()?, half)));
            let downward = || half(&second.sub(inner).ok()?).and_then(|half| Some((half.sub(second).ok()?, half)));
            let found = [upward(), downward()].into_iter().flatten().find_map(|(middle, half)| {
                let (bound, _) = half.parts().filter(|(_, below)| below.is_one())?;
                let wanted = bound.times_term(&hinge.cofactor, &hinge.coefficient)?;
                let there = wanted.terms().iter().all(|(monomial, number)| coefficient_of(rest, monomial) == *number);
                there.then_some((middle, half, wanted))
            });
            let Some((middle, half, wanted)) = found else { continue };
            *rest = rest.minus(&wanted);
            let low = half.neg().ok()?;
            let texts = [&middle, &low, &half].map(|value| self.value(value).0);
            let text = format!("clamp({},{},{})", texts[0], texts[1], texts[2]);
            return Some((self.piece(&hinge.coefficient, &hinge.cofactor, text), Some(other)));
        }
        None
    }

    /// `y + max(0,x-y)` is `max(y,x)`, and `y - max(0,y-x)` is `min(y,x)`, where that is shorter.
    fn extremum(&mut self, hinge: &Hinge, rest: &Real) -> Option<Text> {
        if !hinge.cofactor.factors().is_empty() || rest.is_zero() {
            return None;
        }
        let mut before = rest.terms().len();
        let mut after = before;
        let mut elements = vec![Value::whole(rest.clone()).ok()?];
        for element in &hinge.elements[..] {
            let scaled = element.scale(&hinge.coefficient).ok()?;
            let moved = elements[0].add(&scaled).ok()?;
            let (numerator, denominator) = moved.parts()?;
            before += element.parts()?.0.terms().len();
            after += numerator.terms().len();
            if denominator.terms().len() != 1 {
                return None;
            }
            elements.push(moved);
        }
        if after > before {
            return None;
        }
        let name = if hinge.coefficient.is_negative() { "min" } else { "max" };
        Some((format!("{name}({})", self.list(&elements)), Level::Atom))
    }

    fn piece(&mut self, coefficient: &BigRational, cofactor: &Monomial<Atom>, text: String) -> Piece {
        let factors: Vec<(Atom, i64)> =
            cofactor.factors().iter().map(|(atom, exponent)| (atom.clone(), i64::from(*exponent))).collect();
        let (mut tops, bottoms) = self.factors(&factors);
        tops.push(text);
        let text = super::quotient(coefficient.abs(), tops, bottoms);
        Piece { negative: coefficient.is_negative(), text, degree: cofactor.degree() + 1 }
    }
}

/// `max(0,inner) - max(0,inner-width)`, or its opposite.
struct Pair {
    other: usize,
    inner: Value,
    width: BigRational,
    negative: bool,
}

impl Pair {
    /// The pair of which this term is the greater maximum.
    fn of(hinges: &[Hinge], place: usize) -> Option<Pair> {
        let hinge = &hinges[place];
        let [inner] = &hinge.elements[..] else { return None };
        let inner = inner.scale(&hinge.coefficient.abs()).ok()?;
        let negative = hinge.coefficient.is_negative();
        let partners = hinges.iter().enumerate().filter(|(other, _)| *other != place);
        let opposite = |partner: &Hinge| partner.coefficient.is_negative() != negative;
        partners.filter(|(_, one)| opposite(one) && one.cofactor == hinge.cofactor).find_map(|(other, partner)| {
            let [upper] = &partner.elements[..] else { return None };
            let width = upper.scale(&partner.coefficient.abs()).and_then(|upper| inner.sub(&upper)).ok()?;
            let width = width.as_rational().filter(BigRational::is_positive)?;
            Some(Pair { other, inner: inner.clone(), width, negative })
        })
    }

    /// What stands beside it where its bounds are each other's opposites.
    fn moved(&self) -> BigRational {
        let half = &self.width / BigRational::from_integer(2.into());
        if self.negative { half } else { -half }
    }
}

impl Hinge {
    fn polynomial(&self) -> Real {
        let maximum = Polynomial::atom(Atom::Maximum(self.elements.clone()));
        maximum.times_term(&self.cofactor, &self.coefficient).unwrap_or_else(Polynomial::zero)
    }
}

/// The terms with exactly one maximum, to the first power, and no condition.
fn hinges(sum: &Real) -> Vec<Hinge> {
    let mut found = Vec::new();
    for (monomial, number) in sum.terms() {
        let mut maxima = monomial.factors().iter().filter(|(atom, _)| matches!(atom, Atom::Maximum(_)));
        if let (Some((Atom::Maximum(elements), 1)), None) = (maxima.next(), maxima.next()) {
            let cofactor = monomial.factors().iter().filter(|(atom, _)| !matches!(atom, Atom::Maximum(_))).cloned();
            if let Some(cofactor) = Monomial::of(cofactor) {
                found.push(Hinge { coefficient: number.clone(), cofactor, elements: elements.clone() });
            }
        }
    }
    found
}

/// A polynomial with 1 for one of two conditions and 0 for the others.
fn fixed(polynomial: &Real, conditions: &[Atom], holds: Option<&Atom>) -> Real {
    decided(polynomial, |atom| conditions.contains(atom).then(|| holds == Some(atom)))
}

/// The coefficient of a monomial in a sum.
fn coefficient_of(sum: &Real, monomial: &Monomial<Atom>) -> BigRational {
    let term = sum.terms().iter().find(|(own, _)| own == monomial);
    term.map_or_else(|| BigRational::from_integer(0.into()), |(_, number)| number.clone())
}

fn mirrored(symbol: &str) -> &str {
    match symbol {
        ">" => "<",
        "<" => ">",
        ">=" => "<=",
        "<=" => ">=",
        other => other,
    }
}
