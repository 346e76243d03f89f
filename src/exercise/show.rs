//! An exercise as text: its goal, the steps so far, and its gaps.

use std::fmt::Write as _;

use super::Attempt;
use crate::mark::marked;
use crate::name::Name;

/// What stands for something to be found.
const GAP: &str = "____";

impl Attempt {
    /// The goal, the steps so far, and what is to be found.
    pub fn show(&self) -> String {
        let exercise = &self.exercise;
        let mut out = format!("exercise {}: {}\n", exercise.name, exercise.title);
        let _ = writeln!(out, "  show that {} {} {}", exercise.left, exercise.connective, exercise.right);
        let when: Vec<String> = exercise.when.iter().map(ToString::to_string).collect();
        if !when.is_empty() {
            let _ = writeln!(out, "  when {}", when.join(", "));
        }
        if !exercise.laws.is_empty() {
            let laws: Vec<&str> = exercise.laws.iter().map(Name::as_str).collect();
            let _ = writeln!(out, "  using {}", laws.join(", "));
        }
        out.push_str(&self.calculation());
        if self.solved {
            out.push_str("solved\n");
            return out;
        }
        match self.gap() {
            Some(_) => {
                for gap in exercise.steps.iter().skip(self.done.len()) {
                    let laws = gap
                        .laws
                        .as_ref()
                        .map_or(GAP.to_string(), |laws| laws.iter().map(Name::as_str).collect::<Vec<_>>().join(", "));
                    let term = gap.term.as_ref().map_or(GAP.to_string(), ToString::to_string);
                    let _ = writeln!(out, "{} {{{laws}}}\n    {term}", gap.connective);
                }
            }
            None => {
                let _ = writeln!(out, "{} {{{GAP}}}\n    … {}", exercise.connective, exercise.right);
            }
        }
        out
    }

    /// The steps so far, in each of which only what changed is marked.
    pub(super) fn calculation(&self) -> String {
        let mut out = format!("    {}\n", self.exercise.left);
        let mut before = &self.exercise.left;
        for done in &self.done {
            let laws: Vec<&str> = done.used.iter().map(Name::as_str).collect();
            let term = marked(before, &done.term).shown(self.colour);
            let _ = writeln!(out, "{} {{{}}}\n    {term}", done.connective, laws.join(", "));
            before = &done.term;
        }
        out
    }

    /// The laws that may be used.
    pub(super) fn laws(&self) -> String {
        if self.exercise.laws.is_empty() {
            return "all laws may be used; at the prompt, `:laws` lists them\n".to_string();
        }
        let laws = self.exercise.laws.iter().filter_map(|name| self.theory.laws.get(name));
        laws.map(|law| format!("{law}\n")).collect()
    }
}
