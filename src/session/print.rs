//! The flow of a system for print, in each order of its delays, or part by part where nothing joins them.

use super::delays::{Order, in_orders};
use super::parts::separate;
use crate::flow::flows;
use crate::latex;
use crate::lower::{Environment, System};
use crate::period::{Failure, Period, analyse_until};

/// The tables of all phases in LaTeX, each order or part under its title, in at most so many orders inside one another.
///
/// # Errors
/// Why no period was found.
pub(crate) fn flow_for_print(
    system: &System,
    environment: &Environment,
    most: usize,
    interrupted: &dyn Fn() -> bool,
) -> Result<String, Vec<Failure>> {
    let of = |period: &Period| latex::phases(&flows(period, environment), &environment.assumptions);
    let (definitions, assumptions) = (&environment.definitions, &environment.assumptions);
    let failures = match analyse_until(&system.components, definitions, assumptions, interrupted) {
        Ok(period) => return Ok(of(&period)),
        Err(failures) => failures,
    };
    let each = |order: &Order| flow_for_print(system, &order.environment, most - 1, interrupted);
    let (orders, found) = in_orders(&failures, environment, most, each);
    if found.iter().any(Result::is_ok) {
        let each = orders.iter().zip(found).map(|(order, found)| {
            let said =
                |failures: Vec<Failure>| failures.iter().map(|failure| paragraph(&failure.to_string())).collect();
            paragraph(&order.title) + &found.unwrap_or_else(said)
        });
        return Ok(each.collect());
    }
    match separate(system, environment, interrupted) {
        Some((parts, _)) => Ok(parts.iter().map(|part| paragraph(&part.names()) + &of(&part.period)).collect()),
        None => Err(failures),
    }
}

/// A line of text between tables.
fn paragraph(text: &str) -> String {
    format!("\\paragraph{{{}}}\n", latex::escaped(text))
}
