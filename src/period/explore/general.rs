//! A phase that is visited with other values is one with variables for them.

use super::super::held::{absorbed, name_variables, places};
use super::{Explorer, MOST_EXPLORATIONS};
use crate::value::Value;

impl Explorer<'_> {
    /// Makes a phase general enough for another visit; true if it had to change.
    pub(super) fn absorb(&mut self, number: usize, entries: &[Value]) -> bool {
        let varying: Vec<bool> = entries.iter().map(|entry| self.clock.settler.varies(entry)).collect();
        let alike = self.spots[number].explorations > MOST_EXPLORATIONS;
        let spot = &mut self.spots[number];
        let alike = alike.then(|| places(&spot.control.runs, &spot.delays, &spot.hints));
        let held = absorbed(&spot.held, (entries, &spot.axes), &varying, alike.as_deref());
        let held = spot.together.of((&spot.held, held), spot.explorations, (entries, &varying));
        let changed = held != spot.held;
        spot.held = held;
        self.general |= changed;
        spot.variables = name_variables(&spot.held, &spot.hints, self.clock.settler.reserved);
        changed
    }
}
