//! An instant in which communications compete, or one ends what another waits for, and which comes to the same all the
//! same: all orders are followed. The same must pass in each of them, and the same be left.

use std::collections::BTreeMap;

use super::{Clock, Moment, communicate};
use crate::digest::Quick;
use crate::name::Name;
use crate::period::run::Run;
use crate::period::step::written;
use crate::period::{End, Failure};
use crate::value::Value;

/// States within one instant that are looked at.
const MOST_STATES: usize = 2_000;

impl Clock<'_> {
    /// The same failure, or where an instant leads that begins so, if every order of its communications leads there under
    /// what is known. Nothing may be drawn, and nothing may be left to be asked.
    pub(in crate::period) fn whatever_order(
        &self,
        start: Moment,
        failure: Failure,
    ) -> Result<(Moment, Option<End>), Failure> {
        let races = matches!(failure, Failure::Contention { .. } | Failure::KillRace { .. });
        if !races || !start.path.draws.is_empty() {
            return Err(failure);
        }
        self.every_order(start).ok_or(failure)
    }

    fn every_order(&self, mut start: Moment) -> Option<(Moment, Option<End>)> {
        start.path.exits = 0;
        let mut numbers: Quick<Vec<Run>, usize> = Quick::default();
        // What passes on the way to each state: whatever the order, the same.
        let mut passed: Vec<Vec<(Name, Value)>> = Vec::new();
        // For each state those that it leads to.
        let mut onward: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        let mut last: Option<Moment> = None;
        let mut moved = start.moved.clone();
        let mut open = vec![(None, start)];
        while let Some((from, mut moment)) = open.pop() {
            if (self.interrupted)() || numbers.len() > MOST_STATES {
                return None;
            }
            if self.settle(&mut moment).ok()?.is_some() || !moment.path.draws.is_empty() {
                return None;
            }
            let next = numbers.len();
            let number = *numbers.entry(moment.state.clone()).or_insert(next);
            onward.entry(from.unwrap_or(number)).or_default().extend(from.map(|_| number));
            moved.extend(&moment.moved);
            let mut own = moment.communications.clone();
            own.sort();
            match passed.get(number) {
                Some(before) if *before == own => continue,
                Some(_) => return None,
                None => passed.push(own),
            }
            let pairs = moment.board.pairs();
            for (writer, reader) in &pairs {
                let mut after = moment.clone();
                let value = communicate(&mut after.state, writer, reader);
                after.communications.push((written(&writer.port), value));
                for component in [writer.place.component, reader.place.component] {
                    after.dirty.insert(component);
                    after.moved.insert(component);
                }
                open.push((Some(number), after));
            }
            if pairs.is_empty() && last.replace(moment).is_some() {
                return None;
            }
        }
        let mut last = last.filter(|_| comes_to_an_end(onward))?;
        last.moved = moved;
        let end = self.ending(&last).ok()?;
        Some((last, end))
    }
}

/// Whether no way along these goes on for ever.
fn comes_to_an_end(mut onward: BTreeMap<usize, Vec<usize>>) -> bool {
    loop {
        let known: Vec<usize> = onward.keys().copied().collect();
        let done = |all: &Vec<usize>| all.iter().all(|one| known.binary_search(one).is_err());
        let before = onward.len();
        onward.retain(|_, all| !done(all));
        if onward.is_empty() || onward.len() == before {
            return onward.is_empty();
        }
    }
}
