//! The facts of a composition from those of its parts, one function an operator.

use std::collections::BTreeSet;

use super::{Context, Facts};
use crate::name::Name;
use crate::value::{Relation, Value};

impl Facts {
    fn never_ends(&self) -> bool {
        !self.may_stop && !self.may_abort
    }

    fn joined(parts: &[Facts]) -> Facts {
        let mut all = Facts::default();
        for part in parts {
            all.communicates |= part.communicates;
            all.draws |= part.draws;
            all.early |= part.early;
            all.ports.extend(&part.ports);
            all.binds.extend(&part.binds);
            all.reads.extend(&part.reads);
            all.shows = all.shows.zip(part.shows.clone()).map(|(mine, other)| mine.union(&other).cloned().collect());
        }
        all
    }

    pub(super) fn then(self, next: Facts) -> Facts {
        if !self.may_stop {
            return Facts { guard: false, observer: false, ..self };
        }
        let mut both = Facts::joined(&[self.clone(), next.clone()]);
        both.reads = next.reads;
        for name in &self.surely_binds {
            both.reads.names.remove(name);
        }
        both.reads.extend(&self.reads);
        both.may_stop = next.may_stop;
        both.may_abort = self.may_abort || next.may_abort;
        both.starts_running = self.starts_running || (self.starts_stopped && next.starts_running);
        both.starts_stopped = self.starts_stopped && next.starts_stopped;
        both.starts_aborted = self.starts_aborted || (self.starts_stopped && next.starts_aborted);
        both.instant_stop = self.instant_stop && next.instant_stop;
        both.instant_abort = self.instant_abort || (self.instant_stop && next.instant_abort);
        both.early = self.early || (self.instant_stop && next.early);
        both.surely_binds = self.surely_binds.union(&next.surely_binds).cloned().collect();
        both.duration = match (&self.duration, &next.duration) {
            (Some(first), Some(second)) => first.add(second).ok(),
            _ => None,
        };
        both
    }

    pub(super) fn otherwise(first: Facts, second: Facts) -> Facts {
        if !first.may_abort {
            return Facts { guard: false, observer: false, ..first };
        }
        let mut both = Facts::joined(&[first.clone(), second.clone()]);
        both.may_stop = first.may_stop || second.may_stop;
        both.may_abort = second.may_abort;
        both.starts_running = first.starts_running || (first.starts_aborted && second.starts_running);
        both.starts_stopped = first.starts_stopped || (first.starts_aborted && second.starts_stopped);
        both.starts_aborted = first.starts_aborted && second.starts_aborted;
        both.instant_stop = first.instant_stop || (first.instant_abort && second.instant_stop);
        both.instant_abort = first.instant_abort && second.instant_abort;
        both.early = first.early || (first.instant_abort && second.early);
        both.surely_binds = first.surely_binds.intersection(&second.surely_binds).cloned().collect();
        if !first.may_stop && first.starts_aborted && !first.starts_running {
            both.duration = second.duration;
        }
        both
    }

    pub(super) fn attempt(body: Facts) -> Facts {
        Facts::otherwise(body, Facts::ended(true, false, Some(Value::integer(0))))
    }

    pub(super) fn parallel(parts: &[Facts]) -> Facts {
        let mut all = Facts::joined(parts);
        let endless = parts.iter().any(Facts::never_ends);
        all.may_stop = !endless && parts.iter().any(|part| part.may_stop);
        all.may_abort = !endless && parts.iter().all(|part| part.may_abort);
        all.starts_running = parts.iter().any(|part| part.starts_running);
        let ended = |part: &Facts| part.starts_stopped || part.starts_aborted;
        all.starts_stopped = parts.iter().all(ended) && parts.iter().any(|part| part.starts_stopped);
        all.starts_aborted = parts.iter().all(|part| part.starts_aborted);
        let instant = |part: &Facts| part.instant_stop || part.instant_abort;
        all.instant_stop = parts.iter().all(instant) && parts.iter().any(|part| part.instant_stop);
        all.instant_abort = parts.iter().all(|part| part.instant_abort);
        all.observer = parts.iter().all(|part| part.observer);
        all.surely_binds = Facts::bound_by_all(parts);
        for part in parts.iter().filter(|part| !part.may_abort) {
            all.surely_binds.extend(part.surely_binds.iter().cloned());
        }
        all.duration = Facts::durations(parts, |times| Value::maximum(times).ok(), false);
        all
    }

    pub(super) fn disabling(parts: &[Facts]) -> Facts {
        let mut all = Facts::joined(parts);
        let stopped = parts.iter().any(|part| !part.starts_running && !part.starts_aborted);
        let ended = parts.iter().any(|part| !part.starts_running);
        all.early &= !ended;
        all.may_stop = parts.iter().any(|part| part.may_stop);
        all.may_abort = !stopped && parts.iter().any(|part| part.may_abort);
        all.starts_running = parts.iter().all(|part| part.starts_running);
        all.starts_stopped = parts.iter().any(|part| part.starts_stopped);
        all.starts_aborted = !stopped && parts.iter().any(|part| part.starts_aborted);
        all.instant_stop = parts.iter().any(|part| part.instant_stop);
        all.instant_abort = !stopped && parts.iter().any(|part| part.instant_abort);
        all.observer = parts.iter().all(|part| part.observer);
        let stopping: Vec<Facts> = parts.iter().filter(|part| part.may_stop).cloned().collect();
        all.surely_binds = Facts::bound_by_all(&stopping);
        all.duration = Facts::durations(parts, |times| Value::minimum(times).ok(), true);
        all
    }

    fn bound_by_all(parts: &[Facts]) -> BTreeSet<Name> {
        let mut sets = parts.iter().map(|part| part.surely_binds.clone());
        let first = sets.next().unwrap_or_default();
        sets.fold(first, |common, set| common.intersection(&set).cloned().collect())
    }

    fn durations(
        parts: &[Facts],
        combine: impl Fn(&[Value]) -> Option<Value>,
        beside_observers: bool,
    ) -> Option<Value> {
        let mut times = Vec::new();
        for part in parts {
            match &part.duration {
                Some(time) => times.push(time.clone()),
                None if beside_observers && part.observer => {}
                None => return None,
            }
        }
        if times.is_empty() { None } else { combine(&times) }
    }

    pub(super) fn power(body: Facts, count: &Value, index: &Option<Name>, context: &Context<'_>) -> Facts {
        let zero = Value::integer(0);
        let never_none = context.assumptions.decide(Relation::Gtr, count, &zero) == Some(true);
        let duration = match (&body.duration, index) {
            (Some(time), Some(index)) if time.mentions(index) => None,
            (Some(time), _) if context.assumptions.is_natural(count) == Some(true) => time.mul(count).ok(),
            _ => None,
        };
        let mut facts = Facts { guard: false, observer: false, duration, ..body };
        facts.surely_binds.clear();
        if !never_none {
            (facts.may_stop, facts.starts_stopped, facts.instant_stop) = (true, true, true);
        }
        facts
    }

    pub(super) fn repeated(body: Facts) -> Facts {
        Facts {
            may_stop: body.may_abort,
            may_abort: false,
            starts_running: body.starts_running || body.starts_stopped,
            starts_stopped: body.starts_aborted,
            starts_aborted: false,
            instant_stop: body.instant_abort,
            instant_abort: false,
            surely_binds: BTreeSet::new(),
            duration: None,
            guard: false,
            observer: false,
            ..body
        }
    }
}
