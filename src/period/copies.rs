//! `P^n`: all copies at once where n is a number, one after the other under a count where it is a symbol.

use std::collections::BTreeMap;

use num_traits::ToPrimitive;

use super::Test;
use super::run::{Env, Halt, Path, Run, Settler, evaluate, fresh};
use crate::name::Name;
use crate::scope::read_names;
use crate::substitution::{Stuck, substitute_values};
use crate::term::{Node, Term};
use crate::value::{Relation, Value};

/// Copies that `P^n` may have where n is a number.
const MOST_COPIES: usize = 10_000;
/// What the number of copies still to come is called, and the number of the copy that runs.
const LEFT: &str = "copies";
const RUNS: &str = "copy";

fn power(body: Term, count: Value, index: Option<&Name>) -> Term {
    Term::new(Node::Power(body, count, index.cloned()))
}

impl Settler<'_> {
    /// What `body^count` begins with.
    pub(super) fn copies(
        &self,
        body: &Term,
        count: &Value,
        index: Option<&Name>,
        env: &Env,
        path: &mut Path,
    ) -> Result<Run, Halt> {
        let number = evaluate(count, env)?;
        if number.as_rational().is_none() {
            return self.counted(body, count, index, env, path);
        }
        let whole = number.as_rational().filter(|number| number.is_integer()).and_then(|number| number.to_usize());
        let Some(whole) = whole.filter(|number| *number <= MOST_COPIES) else {
            return Halt::because(format!(
                "the number of copies, {number}, must be a whole number up to {MOST_COPIES}"
            ));
        };
        let at = |body: &Term, value: Value| match index {
            None => Ok(body.clone()),
            Some(index) => substitute_values(body, &BTreeMap::from([(index.clone(), value)])),
        };
        // As the kernel does it: what is left of the copies counts from 0 again, and one copy is that copy.
        let parts = match whole {
            0 => Ok(Vec::new()),
            1 => at(body, Value::zero()).map(|only| vec![only]),
            _ => at(body, Value::zero()).and_then(|first| {
                let next =
                    index.map_or_else(|| Ok(Value::zero()), |index| Value::variable(index).add(&Value::one()))?;
                let (others, left) = (at(body, next)?, Value::integer(whole as i64 - 1));
                let last = if whole == 2 { at(&others, Value::zero())? } else { power(others, left, index) };
                Ok(vec![first, last])
            }),
        };
        match parts {
            Ok(parts) => Ok(fresh(&Term::seq(parts), env)),
            Err(stuck) => Halt::because(stuck.0),
        }
    }

    /// One copy and then the others, if there is one: the number of those to come is a value like any other.
    fn counted(
        &self,
        body: &Term,
        count: &Value,
        index: Option<&Name>,
        env: &Env,
        path: &mut Path,
    ) -> Result<Run, Halt> {
        let (left, begun) = self.counter(body, count, index);
        if !begun && path.assumptions.is_natural(&evaluate(count, env)?) != Some(true) {
            return Halt::because(format!("it must be known that the number of copies, {count}, is natural"));
        }
        let raw = Test { relation: Relation::Gtr, left: count.clone(), right: Value::zero() };
        if !self.ask(raw, env, path)? {
            return Ok(Run::Done(Env::new()));
        }
        let mut inner = env.clone();
        let less = evaluate(count, env)?.sub(&Value::one());
        inner.insert(left.clone(), less.or_else(|error| Halt::because(error.0))?);
        let (first, others) = match index.filter(|index| read_names(body).contains(*index)) {
            None => (body.clone(), body.clone()),
            Some(index) => {
                let runs = Name::new(&left.as_str().replacen(LEFT, RUNS, 1));
                let before = env.get(&runs).filter(|_| begun).cloned();
                let now = before.map_or(Ok(Value::zero()), |before| before.add(&Value::one()));
                inner.insert(runs.clone(), now.or_else(|error| Halt::because(error.0))?);
                turned(body, index, &runs, begun).or_else(|stuck| Halt::because(stuck.0))?
            }
        };
        let others = power(others, Value::variable(&left), index);
        Ok(fresh(&Term::seq([first, others]), &inner))
    }

    /// The name of the count, and whether this is one already.
    fn counter(&self, body: &Term, count: &Value, index: Option<&Name>) -> (Name, bool) {
        let own = |name: &Name| name.as_str().starts_with(LEFT) && !self.reserved.contains(name);
        if let Some(name) = count.as_variable().filter(|name| own(name)) {
            return (name.clone(), true);
        }
        let read = read_names(body);
        let mut name = Name::new(LEFT);
        let mut number = 1;
        let mut runs = Name::new(RUNS);
        let taken = |name: &Name| self.reserved.contains(name) || read.contains(name) || index == Some(name);
        while taken(&name) || taken(&runs) {
            number += 1;
            (name, runs) = (Name::new(&format!("{LEFT}{number}")), Name::new(&format!("{RUNS}{number}")));
        }
        (name, false)
    }
}

/// Of copies that read their number i: the one that runs, which reads the variable r instead, and those after it, which count
/// from 0 again and so read `r+1+i`, as these do once the first of them has begun.
fn turned(body: &Term, index: &Name, runs: &Name, begun: bool) -> Result<(Term, Term), Stuck> {
    let with = |value: Value| substitute_values(body, &BTreeMap::from([(index.clone(), value)]));
    if begun {
        return Ok((with(Value::integer(-1))?, body.clone()));
    }
    let one = Value::variable(runs).add(&Value::one()).and_then(|next| next.add(&Value::variable(index)));
    Ok((with(Value::variable(runs))?, with(one.map_err(|error| Stuck(error.0))?)?))
}
