//! Ways that the kernel has not checked for all values, as the run takes them: with the values that it then has.

use super::{Layer, Lost, Named, Rounds, any_values, supposed, ways, with_rounds};
use crate::law::Condition;
use crate::lower::{Environment, System};
use crate::period::course::Taken;
use crate::period::{Period, open_name};
use crate::substitution::substitute_values;
use crate::term::Term;
use crate::value::Value;

/// Rounds of the run that are looked at.
const MOST_ROUNDS: usize = 400;

/// That the kernel has checked each round of the run, until it comes round or ends, that is on a way without a proof; nothing
/// where it has not, or the run is not known.
pub(super) fn others(
    period: &Period,
    (system, environment): (&System, &Environment),
    layers: &[Option<Vec<Layer>>],
    interrupted: &dyn Fn() -> bool,
) -> Option<String> {
    let run = period.taken(&environment.assumptions, interrupted)?;
    let unproved: Vec<_> = ways(period)
        .into_iter()
        .enumerate()
        .filter(|(place, _)| layers.get(*place).is_none_or(Option::is_none))
        .map(|(_, (_, edge))| edge)
        .collect();
    let on_them = |taken: &&Taken<'_>| unproved.iter().any(|edge| std::ptr::eq(*edge, taken.edge));
    let rounds: Vec<&Taken<'_>> = run.iter().filter(on_them).collect();
    if rounds.len() > MOST_ROUNDS {
        return None;
    }
    let all = with_rounds(period, (system, environment), |all, whole| {
        rounds.iter().all(|taken| !interrupted() && all.as_taken(taken, whole).is_ok())
    });
    let told = match rounds.len() {
        0 => "the run takes no other".to_string(),
        1 => "and of the others the one round that the run takes".to_string(),
        count => format!("and of the others the {count} rounds that the run takes"),
    };
    all.then_some(told)
}

impl Rounds<'_> {
    /// Has the kernel check one round of a run, with what is kept of its values.
    fn as_taken(&self, taken: &Taken<'_>, whole: &Term) -> Result<(), Lost> {
        let phase = taken.phase.and_then(|number| self.period.phases.get(number));
        let mut named = phase.map_or_else(Named::new, any_values);
        named.extend(taken.values.iter().map(|(name, value)| (name.clone(), value.clone())));
        let open: Named = taken.values.iter().map(|(name, value)| (open_name(name), value.clone())).collect();
        let put_in = |term: &Term| substitute_values(term, &open).map_err(|stuck| Lost(stuck.0));
        let state =
            phase.map_or(&[][..], |phase| &phase.state).iter().map(put_in).collect::<Result<Vec<Term>, Lost>>()?;
        let left = phase.map_or(Ok(whole.clone()), |_| self.network(&state, &Named::new()))?;
        let mut hypotheses = supposed(taken.edge, &named)?;
        hypotheses.extend(self.entered(&state));
        hypotheses.retain(|condition| match condition {
            Condition::Compare(_, left, right) => [left, right].into_iter().any(is_open),
            _ => true,
        });
        self.leads(taken.edge, (&left, &taken.edge.segments), &named, &hypotheses)
    }
}

/// Whether a value is open, or depends on parameters.
fn is_open(value: &Value) -> bool {
    !value.variables().is_empty()
}
