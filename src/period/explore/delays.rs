//! Which of the delays that run ends first: as it is known, or in every order that there may be.

use super::super::run::{Env, Path, RawTest, Run};
use super::super::step::inspect;
use super::super::{Failure, Test};
use super::{Explorer, Kept, MOST_WAYS};
use crate::assumption::Assumptions;
use crate::name::Name;
use crate::value::{Relation, Value};

/// What is assumed of the delays, and the one that ends first then.
pub(super) struct First {
    pub(super) path: Path,
    pub(super) least: Value,
}

/// Two delays of which it is not known which ends first.
type Unknown<'d> = (&'d Value, &'d Value);

/// The least of some delays; nothing where there are none.
fn least<'d>(delays: &'d [Value], known: &Assumptions) -> Result<Option<&'d Value>, Unknown<'d>> {
    let mut least: Option<&Value> = None;
    for delay in delays {
        least = match least {
            None => Some(delay),
            Some(other) => match known.decide(Relation::Lte, other, delay) {
                Some(true) => Some(other),
                Some(false) => Some(delay),
                None if known.decide(Relation::Lte, delay, other) == Some(true) => Some(delay),
                None => return Err((other, delay)),
            },
        };
    }
    Ok(least)
}

impl Explorer<'_> {
    /// Which delay ends first. Where what remains of them is a variable of its phase, in every order; such a phase may ask
    /// of its variables what never comes, so this is left to those who follow it.
    pub(super) fn first(
        &mut self,
        state: &[Run],
        delays: &[Value],
        assumptions: Assumptions,
    ) -> Result<Vec<First>, Failure> {
        let mut open = vec![(assumptions, Vec::new())];
        let mut found = Vec::new();
        while let Some((known, tests)) = open.pop() {
            let (one, other) = match least(delays, &known) {
                Ok(Some(least)) => {
                    let path = Path { assumptions: known.into(), tests, ..Path::default() };
                    found.push(First { path, least: least.clone() });
                    continue;
                }
                Ok(None) => return Err(Failure::not_found("nothing waits")),
                Err((one, other)) if self.kept == Kept::Nothing || self.visit.is_some() => (one, other),
                Err((one, other)) => return Err(self.undecided(state, one, other)),
            };
            if open.len() + found.len() > MOST_WAYS {
                return Err(Failure::not_found("too many orders of the delays that remain"));
            }
            for relation in self.orders(one, other)? {
                let (mut known, mut tests) = (known.clone(), tests.clone());
                known.assume(relation, one, other);
                if !known.contradictory_by_last() {
                    tests.push(asked(Test { relation, left: one.clone(), right: other.clone() }));
                    open.push((known, tests));
                }
            }
        }
        Ok(found)
    }

    /// How two delays may stand to each other: in any way, or along a run as they do.
    fn orders(&self, one: &Value, other: &Value) -> Result<Vec<Relation>, Failure> {
        let all = [Relation::Gtr, Relation::Eq, Relation::Lss];
        let Some(visit) = &self.visit else { return Ok(all.to_vec()) };
        let here = |value: &Value| value.substitute(visit).map_err(super::unreduced);
        let (left, right) = (here(one)?, here(other)?);
        let holds = |relation: &Relation| self.assumptions.decide(*relation, &left, &right) == Some(true);
        let found = all.into_iter().find(holds).map(|relation| vec![relation]);
        found.ok_or_else(|| Failure::not_found(format!("it must be known whether {left} <= {right}")))
    }

    /// That it is not known which of two delays ends first. No assumption tells of what varies from round to round.
    fn undecided(&mut self, state: &[Run], one: &Value, other: &Value) -> Failure {
        let varying: Vec<Name> = [one, other]
            .iter()
            .flat_map(|delay| delay.variables())
            .filter(|name| self.clock.settler.varies_by(name))
            .collect();
        let (one, other) = (self.whose(state, one), self.whose(state, other));
        let Some(name) = varying.first() else { return Failure::Order { one, other } };
        self.counted = true;
        Failure::not_found(format!(
            "it must be known whether {} <= {}, what remains of the delays of {} and {}, where {name} is another from round to round",
            one.1, other.1, one.0, other.0
        ))
    }

    /// The component that a delay runs in.
    fn whose(&self, state: &[Run], delay: &Value) -> (String, Value) {
        let holds = |run: &Run| {
            let (mut found, mut shown) = (Vec::new(), Vec::new());
            inspect(run, &mut found, &mut shown).is_ok() && found.contains(delay)
        };
        let name = state.iter().position(holds).and_then(|place| self.clock.names.get(place));
        (name.cloned().unwrap_or_default(), delay.clone())
    }
}

/// A test of the variables of a phase as they are.
fn asked(test: Test) -> RawTest {
    let mut env = Env::new();
    for name in test.left.variables().union(&test.right.variables()) {
        env.insert(name.clone(), Value::variable(name));
    }
    RawTest { raw: test.clone(), test, env, surely: false }
}
