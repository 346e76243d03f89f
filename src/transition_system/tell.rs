//! A small system in words, state by state; and a minimal one with its time put together again.

use super::{Builder, Ending, Label, Mark, TransitionSystem};

/// The most states that are told one by one.
const MOST_TOLD: usize = 24;

/// Each state with its steps; of a large system, where to see them. `name` says what a state is.
pub fn told(system: &TransitionSystem, name: &dyn Fn(u32) -> String) -> Vec<String> {
    if system.states() > MOST_TOLD {
        return vec![format!(
            "more than {MOST_TOLD} states: `pars lts` writes them all with `--format aut`, or draws them"
        )];
    }
    let mut lines = Vec::new();
    for state in 0..system.states() as u32 {
        lines.push(format!("{state}  {}", name(state)));
        for (label, to) in system.steps(state) {
            lines.push(format!("     {} -> {to}", system.label(*label)));
        }
        if system.is_open(state) {
            lines.push("     not looked into".to_string());
        }
    }
    lines
}

impl TransitionSystem {
    /// The system in which time passes from one event to the next, where it passed in ticks: a state in which nothing
    /// can happen but time, and nothing is seen to change, is passed through, and time that changes nothing is left
    /// out. What cannot be reached any more goes.
    pub fn with_time_together(&self) -> TransitionSystem {
        let passive = |state: u32| match self.steps(state) {
            [(label, to)] => match self.label(*label) {
                Label::Wait(time) => Some((time, *to)),
                _ => None,
            },
            _ => None,
        };
        let mut builder = Builder::new();
        let mut number = vec![u32::MAX; self.states()];
        let mut open = vec![self.initial()];
        number[self.initial() as usize] = builder.state(self.mark(self.initial()).clone());
        let mut next = 0;
        while next < open.len() {
            let state = open[next];
            next += 1;
            if self.is_open(state) {
                builder.leave_open(number[state as usize]);
            }
            for (label, to) in self.steps(state) {
                let (mut label, mut to) = (self.label(*label).clone(), *to);
                if let Label::Wait(time) = &mut label {
                    let mut passed = 0;
                    while passive(state).is_some() && self.same_look(state, to) && passed <= self.states() {
                        let Some((more, after)) = passive(to) else { break };
                        *time += more;
                        to = after;
                        passed += 1;
                    }
                    // Round and round, and nothing to be seen: time passes for ever.
                    if to == state || passed > self.states() {
                        continue;
                    }
                }
                if number[to as usize] == u32::MAX {
                    number[to as usize] = builder.state(self.mark(to).clone());
                    open.push(to);
                }
                let label = builder.label(label);
                builder.transition(number[state as usize], label, number[to as usize]);
            }
        }
        builder.finish(0, self.cut)
    }

    /// The system without the states that cannot be reached.
    pub fn reachable(&self) -> TransitionSystem {
        let mut number = vec![u32::MAX; self.states()];
        let mut builder = Builder::new();
        let labels: Vec<u32> = self.labels().iter().map(|label| builder.label(label.clone())).collect();
        number[self.initial() as usize] = builder.state(self.mark(self.initial()).clone());
        let mut open = vec![self.initial()];
        let mut next = 0;
        while next < open.len() {
            let state = open[next];
            next += 1;
            if self.is_open(state) {
                builder.leave_open(number[state as usize]);
            }
            for (label, to) in self.steps(state) {
                if number[*to as usize] == u32::MAX {
                    number[*to as usize] = builder.state(self.mark(*to).clone());
                    open.push(*to);
                }
                builder.transition(number[state as usize], labels[*label as usize], number[*to as usize]);
            }
        }
        builder.finish(0, self.cut)
    }

    fn same_look(&self, one: u32, two: u32) -> bool {
        self.mark_number(one) == self.mark_number(two)
    }
}

/// What a state is called by what is seen of it.
pub fn look(mark: &Mark) -> String {
    match (&mark.ending, mark.shown.is_empty()) {
        (Ending::Running, true) => "runs".to_string(),
        (Ending::Running, false) => {
            format!("shows {}", mark.shown.iter().map(String::as_str).collect::<Vec<_>>().join(", "))
        }
        (ending, _) => ending.to_string(),
    }
}
