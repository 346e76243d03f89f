//! When powers with symbols come to a bound: a logarithm, which no value here is.

use super::Entry;
use crate::closed_form::bracketed;
use crate::name::Name;
use crate::recurrence::{Formula, Reach, Unknown};
use crate::value::{Relation, Value};

/// What a reason ends on where the first index is known, but not as a value.
pub(crate) const NO_VALUE: &str = "logarithms are no values here";

/// How far the exponents of a power that is written as a number are looked for.
const MOST_EXPONENT: i64 = 64;
/// The same of a base with symbols, and the factors of a symbol in an exponent that are looked for.
const MOST_FACTOR: i64 = 4;

impl Entry<'_> {
    /// Where `limit + factor*ratio^n` is to be `limit + factor*ratio^N`: at N, as powers of a number between 0 and 1, or above
    /// 1, are all different.
    pub(super) fn same_power(&self, limit: &Value, factor: &Value, ratio: &Value) -> Result<Option<Reach>, Unknown> {
        let (known, zero, one) = (self.known, Value::zero(), Value::one());
        let surely = |relation, left: &Value, right: &Value| known.decide(relation, left, right) == Some(true);
        let (Some((wanted, _)), true) = (self.interval.bound(true), self.interval.is_point()) else { return Ok(None) };
        let other = surely(Relation::Lss, ratio, &one) || surely(Relation::Gtr, ratio, &one);
        let moves = surely(Relation::Gtr, ratio, &zero) && other;
        if !moves || !surely(Relation::Neq, factor, &zero) {
            return Ok(None);
        }
        let power = known.simplify(&wanted.sub(limit)?.div(factor)?);
        let Some(at) = exponent(&power, ratio) else { return Ok(None) };
        Ok(Some(match known.decide(Relation::Gte, &at, self.from) {
            Some(true) if known.is_natural(&at) == Some(true) => self.before_end(at, Vec::new())?,
            Some(false) => Reach::Never(format!("n would be {at}, which is before n = {}", self.from)),
            _ => return Ok(None),
        }))
    }

    /// What `limit + factor*ratio^n` is away from its limit where it begins.
    pub(super) fn away_at_start(&self, factor: &Value, ratio: &Value) -> Result<Value, Unknown> {
        Ok(self.known.simplify(&factor.mul(&ratio.power(self.from)?)?))
    }

    /// By how much the bound that is met in time is away from the limit, and whether it is excluded.
    fn away_from(
        &self,
        limit: &Value,
        falls: bool,
        (above, below): (bool, bool),
    ) -> Result<Option<(Value, bool)>, Unknown> {
        Ok(Some(match (&self.interval.low, &self.interval.high) {
            (Some((low, strict)), Some((high, other)))
                if falls && strict == other && limit.sub(low)? == high.sub(limit)? =>
            {
                (high.sub(limit)?, *strict)
            }
            (None, Some((high, strict))) if falls && above => (high.sub(limit)?, *strict),
            (Some((low, strict)), None) if falls && below => (limit.sub(low)?, *strict),
            (Some((low, strict)), None) if !falls && above => (low.sub(limit)?, *strict),
            (None, Some((high, strict))) if !falls && below => (limit.sub(high)?, *strict),
            _ => return Ok(None),
        }))
    }

    /// The least index at which `limit + factor*ratio^n` is in the interval, where it surely is from some index on: a value
    /// where the bound is a power itself, else in words.
    pub(super) fn logarithm(&self, limit: &Value, factor: &Value, ratio: &Value) -> Result<Option<Reach>, Unknown> {
        let zero = Value::zero();
        let surely = |relation, one: &Value, other: &Value| self.known.decide(relation, one, other) == Some(true);
        let falls = surely(Relation::Gtr, ratio, &zero) && surely(Relation::Lss, ratio, &Value::one());
        if self.until.is_some() || !(falls || surely(Relation::Gtr, ratio, &Value::one())) {
            return Ok(None);
        }
        let begins = self.away_at_start(factor, ratio)?;
        let (above, below) = (surely(Relation::Gtr, &begins, &zero), surely(Relation::Lss, &begins, &zero));
        let Some((far, strict)) = self.away_from(limit, falls, (above, below))? else { return Ok(None) };
        match self.known.decide(Relation::Gtr, &far, &zero) {
            Some(true) => {}
            Some(false) => return Ok(None),
            // Beyond its limit it never comes: which side that is tells the rest.
            None => return Ok(Some(Reach::undecided(Relation::Gtr, &self.known.simplify(&far), &zero))),
        }
        let (size, index) = (self.known.simplify(&begins.abs()?), self.index);
        let at = exponent(&self.known.simplify(&far.div(&size)?), ratio)
            .filter(|at| self.known.is_natural(at) == Some(true));
        if let Some(at) = at {
            let at = if strict { at.add(&Value::one())? } else { at };
            return Ok(Some(Reach::At(self.from.add(&at)?, Vec::new())));
        }
        let since = Value::variable(index).sub(self.from)?;
        let exponent = if self.from.is_zero() { since.to_string() } else { format!("({since})") };
        let power = power_text(&size, ratio, &exponent);
        let least = format!("log({})/log({ratio})", quotient(&far, &size, &self.known.simplify(&far.div(&size)?)));
        let (least, from) = match strict {
            true => (format!("floor({least})"), self.from.add(&Value::one())?),
            false => (format!("ceil({least})"), self.from.clone()),
        };
        let test = match (falls, strict) {
            (true, false) => Relation::Lte,
            (true, true) => Relation::Lss,
            (false, false) => Relation::Gte,
            (false, true) => Relation::Gtr,
        };
        let relation = test.symbol();
        let early = match self.known.decide(test, &size, &far) {
            Some(false) => String::new(),
            Some(true) if !self.from.is_zero() => return Ok(Some(Reach::At(self.from.clone(), Vec::new()))),
            _ if self.from.is_zero() => format!("if {size} {relation} {far} then 0 else "),
            // Where a later form begins is a value, and a case of its own.
            _ => return Ok(Some(Reach::undecided(test, &size, &far))),
        };
        let least = match self.from.is_zero() {
            true if strict => format!("{least}+1"),
            true => least,
            false => from.add(&Value::variable(&Name::new(&least)))?.to_string(),
        };
        let formula = Formula {
            index: format!("{early}{least}"),
            test: format!("{power} {relation} {far}"),
            power: ratio.power(&since)?.mul(&size)?,
            relation: test,
            bound: far,
        };
        let why = Unknown::because(format!("its first {index} is a logarithm, and {NO_VALUE}"));
        Ok(Some(Reach::Unknown(Unknown { formula: Some(Box::new(formula)), ..why })))
    }
}

/// The text of `size*ratio^exponent`.
fn power_text(size: &Value, ratio: &Value, exponent: &str) -> String {
    let plain = ratio.as_variable().is_some() || ratio.as_rational().is_some_and(|ratio| ratio.is_integer());
    let power = if plain { format!("{ratio}^{exponent}") } else { format!("({ratio})^{exponent}") };
    if *size == Value::one() { power } else { format!("{}*{power}", bracketed(size.to_string())) }
}

/// The text of a quotient, where it is no longer as it is made of both, and no sign stands before what is positive.
fn quotient(above: &Value, below: &Value, both: &Value) -> String {
    let sides = [above, below].map(|side| bracketed(side.to_string()));
    let (plain, apart) = (both.to_string(), sides.join("/"));
    let simple = below.variables().is_empty() || apart.len() >= plain.len() && !plain.starts_with("(-");
    if simple { plain } else { apart }
}

/// The exponent of a power of a base, where it is one: N+3 of `8*2^N`, `-2*N` of `1/4^N`.
fn exponent(power: &Value, base: &Value) -> Option<Value> {
    let (one, raised) = (Value::one(), |by: i64| base.power(&Value::integer(by)).ok());
    let Some(name) = power.variables().into_iter().find(|name| !base.mentions(name)) else {
        // A power of a sum of symbols is long when it is written out.
        let most = if base.as_rational().is_some() { MOST_EXPONENT } else { MOST_FACTOR };
        return (-most..=most).find(|by| raised(*by).as_ref() == Some(power)).map(Value::integer);
    };
    // With each step of a name in the exponent it is multiplied by the same power of the base.
    let own = Value::variable(&name);
    let step = power.with(&name, &own.add(&one).ok()?).ok()?.div(power).ok()?;
    let by = (-MOST_FACTOR..=MOST_FACTOR).find(|by| *by != 0 && raised(*by).as_ref() == Some(&step))?;
    let rest = power.with(&name, &Value::zero()).ok()?;
    exponent(&rest, base)?.add(&own.mul(&Value::integer(by)).ok()?).ok()
}
