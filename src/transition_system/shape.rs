//! What can be read off a system: cycles of internal steps, states in which nothing happens, distances.

use super::{Analysis, Ending, Label, TransitionSystem};

impl TransitionSystem {
    /// What is to be known of it at a glance.
    pub fn analysis(&self) -> Analysis {
        let mut found = Analysis {
            states: self.states(),
            transitions: self.transitions(),
            stopped: 0,
            aborted: 0,
            deadlocks: Vec::new(),
            livelocks: Vec::new(),
            time_stops: Vec::new(),
        };
        for state in 0..self.states() as u32 {
            let mark = self.mark(state);
            match mark.ending {
                Ending::Stopped(_) => found.stopped += 1,
                Ending::Aborted => found.aborted += 1,
                Ending::Running if !self.steps(state).is_empty() || self.is_open(state) => {}
                Ending::Running if mark.waits => found.deadlocks.push(state),
                Ending::Running => found.time_stops.push(state),
            }
        }
        let components = self.components();
        let mut size = vec![0u32; components.count as usize];
        components.of.iter().for_each(|component| size[*component as usize] += 1);
        let circles = |state: &u32| {
            let loops = || self.internal(*state).any(|to| to == *state);
            size[components.of[*state as usize] as usize] > 1 || loops()
        };
        found.livelocks = (0..self.states() as u32).filter(circles).collect();
        found
    }

    /// The targets of a state's internal steps.
    pub fn internal(&self, state: u32) -> impl Iterator<Item = u32> + '_ {
        self.steps(state).iter().filter(|(label, _)| *self.label(*label) == Label::Tau).map(|(_, to)| *to)
    }

    /// The states that internal steps lead round to one another, by Tarjan's algorithm: components are numbered so
    /// that internal steps lead to smaller numbers, or stay.
    pub(crate) fn components(&self) -> Components {
        const OPEN: u32 = u32::MAX;
        let states = self.states();
        let tau = self.label_number(&Label::Tau);
        let mut found = Components { of: vec![OPEN; states], count: 0 };
        let Some(tau) = tau else {
            found.of = (0..states as u32).collect();
            found.count = states as u32;
            return found;
        };
        let (mut number, mut low) = (vec![OPEN; states], vec![0u32; states]);
        let (mut open, mut next) = (Vec::new(), 0u32);
        let mut path: Vec<(u32, usize)> = Vec::new();
        for root in 0..states as u32 {
            if number[root as usize] != OPEN {
                continue;
            }
            path.push((root, 0));
            while let Some((state, tried)) = path.pop() {
                let place = state as usize;
                if tried == 0 {
                    (number[place], low[place]) = (next, next);
                    next += 1;
                    open.push(state);
                }
                match self.after(state, tau).get(tried).map(|(_, to)| *to) {
                    Some(to) => {
                        path.push((state, tried + 1));
                        if number[to as usize] == OPEN {
                            path.push((to, 0));
                        } else if found.of[to as usize] == OPEN {
                            low[place] = low[place].min(number[to as usize]);
                        }
                    }
                    None => {
                        if low[place] == number[place] {
                            while let Some(member) = open.pop() {
                                found.of[member as usize] = found.count;
                                if member == state {
                                    break;
                                }
                            }
                            found.count += 1;
                        }
                        if let Some((parent, _)) = path.last() {
                            let parent = *parent as usize;
                            low[parent] = low[parent].min(low[place]);
                        }
                    }
                }
            }
        }
        found
    }

    /// For each state the least number of steps from the beginning; none where it is not reached.
    pub fn distances(&self) -> Vec<Option<u32>> {
        let mut distance = vec![None; self.states()];
        distance[self.initial() as usize] = Some(0);
        let mut level = vec![self.initial()];
        let mut far = 0;
        while !level.is_empty() {
            far += 1;
            let mut next = Vec::new();
            for state in level {
                for (_, to) in self.steps(state) {
                    if distance[*to as usize].is_none() {
                        distance[*to as usize] = Some(far);
                        next.push(*to);
                    }
                }
            }
            level = next;
        }
        distance
    }
}

/// The states grouped by cycles of internal steps.
pub(crate) struct Components {
    /// For each state its group.
    pub(crate) of: Vec<u32>,
    /// The number of groups.
    pub(crate) count: u32,
}
