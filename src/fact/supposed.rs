//! What a claim supposes of the processes that its metavariables stand for.

use super::{Context, Facts, NameSet};
use crate::law::{Condition, Fact};
use crate::name::Name;
use crate::term::Term;

impl Facts {
    /// Of a metavariable nothing is known but what is supposed.
    pub(super) fn metavariable(name: &Name, term: &Term, context: &Context<'_>) -> Facts {
        let mut facts = Facts::anything(name);
        for hypothesis in context.hypotheses {
            match hypothesis {
                Condition::Is(fact, subject) if subject == term => facts.suppose(*fact),
                Condition::Lasts(subject, time) if subject == term => {
                    let delay = Facts::delay(time, context);
                    facts = Facts { reads: facts.reads, shows: facts.shows, duration: Some(time.clone()), ..delay };
                }
                Condition::Complementary(first, second) if first == term || second == term => {
                    facts.suppose(Fact::Guard);
                }
                _ => {}
            }
        }
        facts
    }

    /// With what a claim supposes of it.
    fn suppose(&mut self, fact: Fact) {
        match fact {
            Fact::NeverAborts => (self.may_abort, self.starts_aborted, self.instant_abort) = (false, false, false),
            Fact::NeverStops => (self.may_stop, self.starts_stopped, self.instant_stop) = (false, false, false),
            Fact::Silent => (self.communicates, self.ports) = (false, NameSet::default()),
            Fact::DrawsNothing => self.draws = false,
            Fact::BindsNothing => self.binds = NameSet::default(),
            Fact::Observer => {
                let reads = std::mem::take(&mut self.reads);
                *self =
                    Facts { starts_running: true, observer: true, reads, shows: self.shows.take(), ..Facts::default() };
            }
            Fact::Guard => {
                let reads = std::mem::take(&mut self.reads);
                *self = Facts { guard: true, reads, ..Facts::ended(true, true, None) };
            }
            Fact::NotStopped => self.starts_stopped = false,
            Fact::Running => (self.starts_stopped, self.starts_aborted) = (false, false),
            Fact::Guarded => (self.instant_stop, self.starts_stopped) = (false, false),
            Fact::Immediate => {
                (self.starts_running, self.starts_aborted, self.may_abort, self.instant_abort) =
                    (false, false, false, false);
            }
            Fact::Still => self.early = false,
        }
    }
}
