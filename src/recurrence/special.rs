//! What a closed form leaves out: where it needs `a != b`, the recurrence is solved once more with b in place of a.

use crate::assumption::Assumptions;
use crate::closed_form::{Comparison, Recurrence, Solved};
use crate::name::Name;
use crate::value::{Relation, Value};

use super::solve_until;

/// The most cases, and the most equations that one may need.
const MOST_CASES: usize = 6;
const MOST_EQUATIONS: usize = 2;

/// A recurrence with values in place of parameters, and its forms.
#[derive(Clone, Debug)]
pub struct Special {
    /// What is equal here.
    pub equations: Vec<(Value, Value)>,
    /// The recurrence in which it has been put in, with its forms.
    pub solved: Solved,
}

/// The cases that are left out by conditions of forms, as far as they have forms of their own.
pub fn special_cases(solved: &Solved, known: &Assumptions, stop: &dyn Fn() -> bool) -> Vec<Special> {
    let mut found: Vec<Special> = Vec::new();
    let mut open = vec![(Vec::new(), solved.clone(), known.clone())];
    while let Some((equations, general, known)) = open.pop() {
        if equations.len() >= MOST_EQUATIONS {
            continue;
        }
        for (relation, left, right) in general.conditions() {
            if !matches!(relation, Relation::Neq | Relation::Gtr) || found.len() >= MOST_CASES {
                continue;
            }
            let Some((name, image)) = parameter(left, right, general.recurrence()) else { continue };
            let mut known = known.clone();
            known.assume(Relation::Eq, &Value::variable(&name), &image);
            let mut equations = equations.clone();
            equations.push((Value::variable(&name), image.clone()));
            let Some(special) = with(general.recurrence(), &name, &image) else { continue };
            if found.iter().any(|other| other.solved.recurrence() == &special) {
                continue;
            }
            if let Ok(solved) = solve_until(special, &known, stop) {
                open.push((equations.clone(), solved.clone(), known));
                found.push(Special { equations, solved });
            }
        }
    }
    found.sort_by_key(|special| special.equations.len());
    found
}

/// The parameter that an equation gives, and its value.
fn parameter(left: &Value, right: &Value, recurrence: &Recurrence) -> Option<(Name, Value)> {
    let difference = left.sub(right).ok()?;
    let terms = recurrence.terms();
    let free = |name: &Name| *name != recurrence.index && terms.iter().all(|(term, ..)| term != name);
    let solved = |name: &Name| {
        let (factor, rest) = difference.linear_in(name)?;
        factor.as_rational()?;
        Some((name.clone(), rest.neg().ok()?.div(&factor).ok()?))
    };
    difference.variables().iter().filter(|name| free(name)).find_map(solved)
}

/// A recurrence with a value in place of a parameter.
fn with(recurrence: &Recurrence, name: &Name, image: &Value) -> Option<Recurrence> {
    let mut special = recurrence.clone();
    for sequence in &mut special.sequences {
        sequence.next = sequence.next.with(name, image).ok()?;
        for value in &mut sequence.start {
            *value = value.with(name, image).ok()?;
        }
    }
    Some(special)
}

impl Special {
    /// `a = b, c = 1`
    pub fn title(&self) -> String {
        let each = |(left, right): &(Value, Value)| format!("{left} = {right}");
        self.equations.iter().map(each).collect::<Vec<_>>().join(", ")
    }

    /// What must hold beyond that.
    pub fn conditions(&self) -> &[Comparison] {
        self.solved.conditions()
    }
}
