//! The root of a sum of squares as the length of a vector: `norm((x-3,y+1))`.

use super::{Printer, Value};

impl Printer {
    /// `norm((a,b))` in place of `sqrt(a^2+b^2)`, where that is no longer.
    pub(super) fn length(&mut self, radicand: &Value) -> Option<String> {
        if self.expansions == 0 {
            return None;
        }
        let parts = radicand.squares().filter(|parts| parts.len() > 1)?;
        self.expansions -= 1;
        let (inside, plain) = (self.list(&parts), self.value(radicand).0);
        (inside.len() + 3 < plain.len()).then(|| format!("norm(({inside}))"))
    }
}
