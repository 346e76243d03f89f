//! Where a run is, and what it can do, as text.

use std::fmt::Write as _;

use num_traits::Zero;

use super::Walk;
use crate::absence::blocked;
use crate::mark::{kept, marked_in_order};
use crate::model::{Action, Move, Patience, State};
use crate::printer::Order;
use crate::report::abbreviated;
use crate::stepper::{Choice, did};
use crate::term::{Node, Term};
use crate::value::Value;

impl Walk {
    /// The state with its numbered moves, each with its rule and the whole next term.
    pub(super) fn show(&mut self) -> String {
        let mut out = String::new();
        self.put_in_order();
        let state = self.stepper.state();
        let term = state.term();
        let _ = writeln!(out, "step {}, time {}", self.stepper.trace().len(), self.stepper.time());
        let _ = writeln!(out, "    {}", abbreviated(&marked_in_order(&term, &term, self.order()).text));
        let shown: Vec<String> = state
            .observations()
            .into_iter()
            .map(|(name, values)| Term::new(Node::Observe(name, values)).to_string())
            .collect();
        if !shown.is_empty() {
            let _ = writeln!(out, "  shows {}", shown.join(", "));
        }
        match state {
            State::Stopped(results) if results.is_empty() => out.push_str("  it has stopped\n"),
            State::Stopped(results) => {
                let results: Vec<String> = results.iter().map(|(name, value)| format!("{name} = {value}")).collect();
                let _ = writeln!(out, "  it has stopped with {}", results.join(", "));
            }
            State::Aborted => out.push_str("  it has aborted\n"),
            State::Running(_) => self.show_moves(&term, &mut out),
        }
        out
    }

    fn show_moves(&self, term: &Term, out: &mut String) {
        let moves = match self.stepper.moves() {
            Ok(moves) => moves,
            Err(error) => {
                let _ = writeln!(out, "  it cannot go on: {error}");
                return;
            }
        };
        for (place, step) in moves.iter().enumerate() {
            let _ = writeln!(out, "  {}. {}   [{}]", place + 1, did(&step.action, None), rule(step));
            let _ = writeln!(out, "       {}", self.after(term, step));
        }
        let mut number = moves.len();
        match self.stepper.state().patience(&moves) {
            Patience::None => {}
            Patience::Until(time) => {
                number += 1;
                let _ = writeln!(out, "  {number}. wait {time}   [time passes, up to the next event]");
                let next = match self.stepper.after_time(&time) {
                    Ok(Some(next)) => self.marked(term, &next.term()),
                    Ok(None) => "no time can pass".to_string(),
                    Err(error) => format!("then it has no meaning: {error}"),
                };
                let _ = writeln!(out, "       {next}");
            }
            Patience::Unbounded if moves.is_empty() => {
                out.push_str("  nothing can happen any more but that time passes (`wait 1`)\n");
            }
            Patience::Unbounded => out.push_str("  time may pass too, and changes nothing (`wait 1`)\n"),
        }
        for (place, (_, what)) in blocked(&self.stepper).unwrap_or_default().iter().enumerate() {
            let number = number + place + 1;
            let _ = writeln!(out, "  not possible: {number}. {what}   (`why not {number}`)");
        }
    }

    fn after(&self, term: &Term, step: &Move) -> String {
        if step.needs_value() {
            let open = step.with(&Value::variable(&crate::name::Name::new("value")));
            return self.marked(term, &open);
        }
        match self.stepper.after(step) {
            Ok(next) => self.marked(term, &next.term()),
            Err(error) => format!("then it has no meaning: {error}"),
        }
    }

    /// What a step makes of a term, with what is new marked; the parts of `|` and `#` stay where they stand.
    fn marked(&self, term: &Term, next: &Term) -> String {
        let order = kept(term, self.order(), next);
        marked_in_order(term, next, &order).shown(self.colour)
    }

    /// The order in which the present state is written.
    fn order(&self) -> &Order {
        static SORTED: Order = Order::new();
        self.orders.last().map_or(&SORTED, |(_, order)| order)
    }

    /// Finds the order for each state so far that has none yet.
    fn put_in_order(&mut self) {
        let before = self.stepper.trace().iter().map(|taken| taken.before.term());
        let states: Vec<Term> = before.chain([self.stepper.state().term()]).collect();
        let same = self.orders.iter().zip(&states).take_while(|((known, _), state)| known == *state).count();
        self.orders.truncate(same);
        for state in states.into_iter().skip(same) {
            let order = self.orders.last().map_or_else(Order::new, |(last, order)| kept(last, order, &state));
            self.orders.push((state, order));
        }
    }

    /// The steps so far, each with its time and what was seen before it.
    pub(super) fn steps(&self) -> String {
        let mut out = String::new();
        let mut time = num_rational::BigRational::zero();
        for (place, taken) in self.stepper.trace().iter().enumerate() {
            let _ = writeln!(out, "{:>4}. at {time}: {}", place + 1, taken.did);
            if let Choice::Wait(passed) = &taken.choice {
                time += passed;
            }
        }
        if out.is_empty() { "no step was taken\n".to_string() } else { out }
    }
}

/// The rule that allows a move.
fn rule(step: &Move) -> String {
    match &step.action {
        Action::In(port) => format!("{}: In takes what the surroundings write to {port}", step.rule),
        Action::Out(port, _) => format!("{}: Out gives to the surroundings that read {port}", step.rule),
        Action::Tau(port, _) => format!("{}: a write to {port} meets a read from it", step.rule),
        Action::Draw(..) => format!("{}: a draw is made as soon as it is reached", step.rule),
    }
}
