//! Calls and loops as they begin, and those that never get anywhere.

use std::collections::BTreeSet;

use super::Failure;
use super::run::{Called, Env, Halt, Kind, Path, Run, Settler, fresh};
use crate::name::Name;
use crate::term::Term;
use crate::value::Value;

impl Settler<'_> {
    /// Settles what a call or a loop begins with. It never ends if it comes to the same call, with the same values,
    /// before anything has been waited for or drawn.
    pub(super) fn once(
        &self,
        what: Term,
        env: Env,
        run: Run,
        wanted: &BTreeSet<Name>,
        path: &mut Path,
        depth: usize,
    ) -> Result<Run, Halt> {
        let opened = (what, env, path.draws.len());
        if path.open.contains(&opened) {
            let cycle = path.unfolded.last().map(|last| cycle_of(&path.unfolded, last)).unwrap_or_default();
            let when = path.tests.iter().map(|asked| asked.test.clone()).collect();
            return Err(Failure::Livelock { cycle, changes: Vec::new(), when }.into());
        }
        path.open.push(opened);
        let settled = self.settle(run, wanted, path, depth + 1);
        path.open.pop();
        settled
    }

    pub(super) fn unfold(&self, name: &Name, arguments: Vec<Value>, path: &mut Path) -> Result<Run, Halt> {
        let Some(definition) = self.definitions.get(name) else {
            return Halt::because(format!("{name} is not defined"));
        };
        if definition.parameters.len() != arguments.len() {
            return Halt::because(format!("{name} is called with {} values", arguments.len()));
        }
        let bits: u64 = arguments.iter().map(Value::bits).sum();
        path.lengths = path.lengths.saturating_add(usize::try_from(bits / 16).unwrap_or(usize::MAX));
        let inner: Env = definition.parameters.iter().cloned().zip(arguments).collect();
        path.unfolded.push(name.clone());
        let body = fresh(&definition.body, &inner);
        if definition.recursive {
            let called = Kind::Loop(Called(Some(name.clone())));
            return Ok(Run::Else(Box::new(body), Term::stop(), Env::new(), called));
        }
        Ok(body)
    }
}

/// The calls since the last one of the same process.
pub(super) fn cycle_of(unfolded: &[Name], last: &Name) -> Vec<Name> {
    let mut cycle = vec![last.clone()];
    for name in unfolded.iter().rev().skip(1) {
        if name == last {
            break;
        }
        cycle.push(name.clone());
    }
    cycle.reverse();
    cycle
}
