//! How an answer is laid out: the forms, what they need, how they were checked, and what follows in each case.

use crate::closed_form::{Comparison, Recurrence, Solved, needed};
use crate::value::Value;

/// With this the line begins that tells the proof of the forms.
const CHECKED: &str = "checked by induction";

/// The longest right side that is written out once more.
const WIDEST: usize = 1_000;

/// The lines of each case below its title. What each of them begins with stands once, before all: the forms, which take
/// up so many lines of the first, or all up to how they were checked.
pub(in crate::session) fn in_layout(mut told: Vec<(String, Vec<String>)>, forms: Option<usize>) -> Vec<String> {
    let first = told.first().map_or_else(Vec::new, |(_, own)| own.clone());
    let checked = || first.iter().position(|line| line.starts_with(CHECKED)).map_or(0, |place| place + 1);
    let forms = &first[..forms.unwrap_or_else(checked).min(first.len())];
    let shared = !forms.iter().any(|line| is_title(line)) && told.iter().all(|(_, own)| own.starts_with(forms));
    let before = if shared { forms } else { &[] };
    let mut lines = before.to_vec();
    for (title, own) in &mut told {
        lines.push(std::mem::take(title));
        lines.extend(own.drain(..).skip(before.len()).map(|line| format!("  {line}")));
    }
    lines
}

/// Whether a case follows.
pub(in crate::session) fn is_title(line: &str) -> bool {
    line.ends_with(':')
}

/// The same with what the equations need, below the forms and above the first case, unless it is there.
pub(super) fn with_needs(mut lines: Vec<String>, needs: &[Comparison]) -> Vec<String> {
    let proof = lines.iter().position(|line| line.starts_with(CHECKED) || is_title(line)).unwrap_or(lines.len());
    for line in needs.iter().map(needed) {
        if !lines.contains(&line) {
            lines.insert(proof, line);
        }
    }
    lines
}

/// How the forms were checked.
pub(super) fn proof(recurrence: &Recurrence) -> String {
    proof_up_to(recurrence, None)
}

/// The same of forms that may be known as far as an index.
pub(in crate::session) fn proof_of(solved: &Solved) -> String {
    match solved.as_far() {
        Some(as_far) => proof_up_to(&as_far.whole, Some(&as_far.last)),
        None => proof(solved.recurrence()),
    }
}

fn proof_up_to(recurrence: &Recurrence, as_far: Option<&Value>) -> String {
    let index = &recurrence.index;
    let starts = recurrence.sequences.iter().flat_map(|sequence| {
        let terms = sequence.start.iter().enumerate();
        terms.map(|(place, value)| format!("{}({}) = {value}", sequence.name, recurrence.from + place as i64))
    });
    let steps = recurrence.sequences.iter().map(|sequence| {
        let (term, next) = (recurrence.term(&sequence.name, sequence.start.len()), sequence.next.to_string());
        if next.len() > WIDEST { format!("{term} as its equation says") } else { format!("{term} = {next}") }
    });
    let last = as_far.map_or_else(String::new, |last| format!(" with {index} < {last}"));
    let (starts, steps) = (starts.collect::<Vec<_>>().join(", "), steps.collect::<Vec<_>>().join(", "));
    format!("{CHECKED} on {index}: {starts}; for every {index} >= {}{last}, {steps}", recurrence.from)
}
