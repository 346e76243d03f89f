//! What came of criteria, as lines for a person and as data for a program.

use num_rational::BigRational;
use num_traits::{Signed, Zero};
use serde_json::{Value as Json, json};

use crate::criteria::repair::{Advice, Feedback, Repair, Sensitivity, is_short};
use crate::criteria::{Finding, Measure, Standing};
use crate::lower::Criteria;
use crate::name::Name;
use crate::timeline::Timeline;
use crate::value::Value;

/// The longest number, in characters, of which somebody may want to know that it is not enough.
const LONGEST: usize = 8;

/// What came of criteria.
#[derive(Clone, Debug)]
pub struct Assessment {
    /// The criteria.
    pub criteria: Criteria,
    /// What came of each, in order.
    pub findings: Vec<Finding>,
    /// The run that they were judged on.
    pub run: Timeline,
    /// What to do about those that are not met.
    pub advice: Advice,
    /// How each margin moves with each parameter.
    pub sensitivities: Vec<Sensitivity>,
}

impl Assessment {
    /// What stands in the way: all criteria that are not met; where there are none, those that are open.
    pub fn limiting(&self) -> impl Iterator<Item = &Finding> {
        let worst = self.findings.iter().map(|finding| finding.standing).min();
        self.findings.iter().filter(move |one| Some(one.standing) == worst && one.standing != Standing::Met)
    }

    /// One line a criterion: its standing, what was asked, what was measured, the margin.
    pub fn lines(&self) -> Vec<String> {
        let mut lines = Vec::new();
        for finding in &self.findings {
            let mut line = format!("{:<8}{}", finding.standing.spelling(), finding.text);
            if let Some(value) = &finding.value {
                line.push_str(&format!(": {} = {}", finding.name, value.readable()));
            }
            if let Some(margin) = &finding.margin {
                let word = if is_short(margin) { "short by" } else { "margin" };
                let shown = if is_short(margin) { opposite(margin) } else { margin.clone() };
                line.push_str(&format!(", {word} {}", shown.readable()));
            }
            lines.push(line);
            lines.extend(finding.notes.iter().map(|note| format!("        {note}")));
            if let Some(feedback) = self.advice.feedback.iter().find(|feedback| feedback.name == finding.name) {
                lines.extend(feedback.blame.iter().map(|line| format!("        {line}")));
            }
        }
        lines.extend(self.sensitivities.iter().filter_map(sensitivity));
        let still = self.sensitivities.iter().filter(|one| is_still(one));
        let still: Vec<String> = still.map(|one| format!("{} by {}", one.name, one.parameter)).collect();
        if !still.is_empty() {
            lines.push(format!("margins that such a change does not move: {}", still.join(", ")));
        }
        lines.extend(self.unknown_sensitivities());
        lines
    }

    /// Of which margins it is not known how they move, and why.
    fn unknown_sensitivities(&self) -> Vec<String> {
        let (mut bounds, mut others) = (Vec::new(), Vec::new());
        for one in self.sensitivities.iter().filter(|one| !one.is_known()) {
            let margin = self.findings.iter().find(|finding| finding.name == one.name);
            let margin = margin.and_then(|finding| finding.margin.as_ref());
            let list = if margin.is_some_and(Measure::is_bound) { &mut bounds } else { &mut others };
            list.push(format!("{} by {}", one.name, one.parameter));
        }
        let line = |(list, why): (Vec<String>, &str)| {
            (!list.is_empty())
                .then(|| format!("margins of which it is not known how they move, {why}: {}", list.join(", ")))
        };
        let told = [
            (bounds, "as of them only bounds are known here"),
            (others, "as they are not known here, or not with such a change"),
        ];
        told.into_iter().filter_map(line).collect()
    }

    /// What could be changed.
    pub fn advice(&self) -> Vec<String> {
        let mut all: Vec<String> =
            self.advice.all.iter().map(|repair| format!("all: {} meets every criterion", changes(repair))).collect();
        if let ([one, _, ..], true) = (self.advice.feedback.as_slice(), all.is_empty())
            && !one.tried.is_empty()
        {
            let tried = names(&one.tried);
            all.push(format!("all: no change of one or two of {tried} was found that meets every criterion"));
        }
        all.into_iter().chain(self.advice.feedback.iter().flat_map(advice)).collect()
    }

    /// As data.
    pub fn json(&self) -> Json {
        let own = |name: &Name| {
            let all = self.sensitivities.iter().filter(|one| one.name == *name);
            all.map(sensitivity_json).collect::<Vec<_>>()
        };
        let findings = self.findings.iter().map(|finding| {
            let feedback = self.advice.feedback.iter().find(|feedback| feedback.name == finding.name);
            json!({
                "name": finding.name.as_str(),
                "criterion": finding.text,
                "verdict": finding.standing.spelling(),
                "value": finding.value.as_ref().map(ToString::to_string),
                "margin": finding.margin.as_ref().map(ToString::to_string),
                "notes": finding.notes,
                "sensitivities": own(&finding.name),
                "blame": feedback.map(|feedback| feedback.blame.clone()),
                "repairs": feedback.map(|feedback| {
                    feedback.single.iter().chain(&feedback.pairs).map(repair_json).collect::<Vec<_>>()
                }),
            })
        });
        findings.collect()
    }
}

fn repair_json(repair: &Repair) -> Json {
    let changes = repair
        .changes
        .iter()
        .map(|(name, before, after)| json!({ "parameter": name.as_str(), "from": text(before), "to": text(after) }));
    json!({
        "changes": changes.collect::<Vec<_>>(),
        "margin": repair.after.margin.as_ref().map(ToString::to_string),
        "breaks": repair.breaks.iter().map(ToString::to_string).collect::<Vec<_>>(),
        "jumps": repair.jumps.iter().map(ToString::to_string).collect::<Vec<_>>(),
    })
}

fn sensitivity_json(one: &Sensitivity) -> Json {
    let [up, down] = [&one.up, &one.down].map(|measure| measure.as_ref().map(ToString::to_string));
    let [lost_up, lost_down] = one.lost.map(|standing| standing.map(Standing::spelling));
    let [slope_up, slope_down] = one.slopes.each_ref().map(|slope| slope.as_ref().map(text));
    json!({
        "parameter": one.parameter.as_str(),
        "step": one.step.as_ref().map_or_else(|| "1 %".to_string(), text),
        "up": up,
        "down": down,
        "lost_up": lost_up,
        "lost_down": lost_down,
        "slope_up": slope_up,
        "slope_down": slope_down,
    })
}

fn text(number: &BigRational) -> String {
    Value::rational(number.clone()).to_string()
}

/// A number as it is, with a decimal beside it where it is long.
fn readable(number: &BigRational) -> String {
    let exact = text(number);
    if exact.len() <= 12 && *number.denom() <= 1_000.into() {
        return exact;
    }
    let near = num_traits::ToPrimitive::to_f64(number).unwrap_or(f64::NAN);
    format!("{exact} (rounded: {near:.6})")
}

fn opposite(measure: &Measure) -> Measure {
    let minus = |value: &Value| value.neg().unwrap_or_else(|_| value.clone());
    match measure {
        Measure::Exact(value) => Measure::Exact(minus(value)),
        Measure::AtLeast(value) => Measure::AtMost(minus(value)),
        Measure::AtMost(value) => Measure::AtLeast(minus(value)),
        Measure::Between(low, high) => Measure::Between(-high, -low),
    }
}

/// A change to be read: exactly where that is short, else about how much it is.
fn brief(measure: &Measure) -> String {
    let exact = measure.to_string();
    if exact.len() <= LONGEST_CHANGE {
        return exact;
    }
    let digits = |number: f64| match number.abs() {
        size if size != 0.0 && size < 1e-3 => format!("{number:.3e}"),
        _ => format!("{number:.6}"),
    };
    match measure {
        Measure::Between(low, high) if digits(*low) != digits(*high) => {
            format!("between {} and {} (rounded)", digits(*low), digits(*high))
        }
        _ => measure.near().map_or(exact, |near| format!("{} (rounded)", digits(near))),
    }
}

/// The longest change that is read as it is, in letters.
const LONGEST_CHANGE: usize = 24;

fn moves(measure: &Option<Measure>) -> bool {
    match measure {
        Some(Measure::Exact(value)) => !value.is_zero(),
        Some(Measure::Between(low, high)) => *low > 0.0 || *high < 0.0,
        _ => false,
    }
}

/// Whether a margin is known to stay as it is.
fn is_still(one: &Sensitivity) -> bool {
    let zero = |measure: &Option<Measure>| matches!(measure, Some(Measure::Exact(value)) if value.is_zero());
    zero(&one.up) && zero(&one.down) && sensitivity(one).is_none()
}

/// How a margin moves, where it does.
fn sensitivity(one: &Sensitivity) -> Option<String> {
    let slopes = one.slopes.each_ref().map(|slope| slope.as_ref().filter(|slope| !slope.is_zero()));
    let lost = one.lost != [None, None];
    if !moves(&one.up) && !moves(&one.down) && !lost && slopes.iter().all(Option::is_none) {
        return None;
    }
    let mut parts = Vec::new();
    let step = one.step.as_ref().map_or_else(|| "1 %".to_string(), text);
    for ((sign, measure), lost) in [("+", &one.up), ("-", &one.down)].into_iter().zip(&one.lost) {
        match (measure, lost) {
            (_, Some(standing)) => {
                parts.push(format!("with {sign}{step} it is {}", standing.spelling()));
            }
            (Some(measure), None) => parts.push(format!("{sign}{step} changes it by {}", brief(measure))),
            (None, None) => {}
        }
    }
    match slopes {
        [Some(up), Some(down)] if up == down => {
            parts.push(format!("slope {} while the run takes the same ways", text(up)));
        }
        [up, down] => {
            parts.extend(up.map(|slope| format!("slope {} upward", text(slope))));
            parts.extend(down.map(|slope| format!("slope {} downward", text(slope))));
        }
    }
    Some(format!("margin of {} by {}: {}", one.name, one.parameter, parts.join(", ")))
}

fn names(names: &[Name]) -> String {
    names.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}

/// What is changed, as in `v = 2 in place of 1 and t = 1/2 in place of 1`.
fn changes(repair: &Repair) -> String {
    let changes = repair.changes.iter();
    let changes =
        changes.map(|(name, before, after)| format!("{name} = {} in place of {}", readable(after), readable(before)));
    changes.collect::<Vec<_>>().join(" and ")
}

fn advice(feedback: &Feedback) -> Vec<String> {
    let mut lines = Vec::new();
    for repair in feedback.single.iter().chain(&feedback.pairs) {
        let mut line = format!("{}: {}", feedback.name, changes(repair));
        if let Some(value) = &repair.after.value {
            line.push_str(&format!(" gives {} = {}", feedback.name, value.readable()));
        }
        if let Some(margin) = &repair.after.margin {
            line.push_str(&format!(", margin {}", margin.readable()));
        }
        if let Some(formula) = &repair.formula {
            line.push_str(&format!("; solved from the margin {formula}"));
        }
        if let Some(least) = &repair.least {
            line.push_str(&format!("; with a change that is smaller by {} it is not met", little(least)));
        }
        // Of a long number it tells nothing that anybody would try.
        if let Some(place) = repair.not_at.as_ref().map(text).filter(|place| place.len() <= LONGEST) {
            line.push_str(&format!("; {place} itself is not enough"));
        }
        let (jumps, others): (Vec<_>, Vec<_>) = repair.breaks.iter().partition(|name| repair.jumps.contains(name));
        let (open, broken): (Vec<_>, Vec<_>) = others.into_iter().partition(|name| repair.open.contains(name));
        for (word, names) in [("not met", broken), ("open", open), ("met by a jump between two looks only", jumps)] {
            if !names.is_empty() {
                let names: Vec<String> = names.into_iter().map(ToString::to_string).collect();
                line.push_str(&format!("; but then {word}: {}", names.join(", ")));
            }
        }
        lines.push(line);
    }
    if feedback.single.is_empty() {
        let tried = names(&feedback.tried);
        lines.push(match (tried.is_empty(), feedback.pairs.is_empty()) {
            (true, _) => format!("{}: no parameter that matters here has a value that could be changed", feedback.name),
            (false, true) if feedback.tried.len() == 1 => {
                format!("{}: no change of {tried} was found with which it is met", feedback.name)
            }
            (false, true) => format!("{}: no change found of one or two of {tried}", feedback.name),
            (false, false) => format!("{}: no change of one of {tried} alone was found", feedback.name),
        });
    }
    if let Some(limit) = &feedback.limit {
        lines.push(format!("{}: or ask for {limit}", feedback.name));
    }
    lines
}

/// A small number, or a round one that it is less than.
fn little(least: &BigRational) -> String {
    let (mut bound, tenth) = (BigRational::from_integer(1.into()), BigRational::new(1.into(), 10.into()));
    let plain = text(least);
    if *least >= bound || plain.len() <= LONGEST && *least >= BigRational::new(1.into(), 1_000_000.into()) {
        return plain;
    }
    while least.is_positive() && *least < &bound * &tenth && bound.denom().bits() < 400 {
        bound *= &tenth;
    }
    format!("less than {}", Value::rational(bound))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_numbers_have_a_decimal_beside_them() {
        let read = |top: i64, below: i64| readable(&BigRational::new(top.into(), below.into()));
        assert_eq!(read(29, 4), "29/4");
        assert_eq!(read(1781, 4826), "1781/4826 (rounded: 0.369043)");
        assert_eq!(read(1_000_000_000_001, 1), "1000000000001 (rounded: 1000000000001.000000)");
    }
}
