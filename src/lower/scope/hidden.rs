//! A parameter called like a result of a process that is called: `proc Go_g = (Delay_t # At_g) ; Wait`, where Wait reads
//! a new g. Where nobody reads the name after the call, each read means the parameter, which is then kept under a name of
//! its own: so it is no matter what the results are called. A read after the call could mean either, and is refused.

use std::collections::BTreeSet;

use super::super::flow::names;
use super::Lowerer;
use crate::ast::{Ident, Term as Written, TermKind, Value as WrittenValue};
use crate::diagnostic::{Diagnostic, Span};
use crate::name::Name;
use crate::scope::{bound_names, read_names};
use crate::substitution::substitute_values;
use crate::term::Term;
use crate::value::Value;

impl Lowerer<'_> {
    /// Reports each call that binds a parameter which is read after it.
    pub(super) fn check_clashes(&mut self, terms: &[&Written]) {
        for (bound, call) in std::mem::take(&mut self.clashes) {
            let reader = terms.iter().find_map(|term| match after(term, &bound, call.span, None) {
                Found::Call(reader) => Some(reader),
                Found::Nothing => None,
            });
            let Some(place) = self.locals.get(&bound).copied() else { continue };
            let clash = || {
                Diagnostic::error("P0503", format!("`{}` binds `{bound}`, which is a parameter here", call.name))
                    .label(call.span, format!("binds `{bound}`"))
                    .label(place, "the parameter")
                    .help(format!("rename the parameter, for example to `{bound}0`, or the result where it is bound"))
            };
            match reader.flatten() {
                Some(reader) => self.report(clash().label(reader, "which of the two?")),
                None if self.settled => self.report(clash()),
                None => drop(self.hidden.insert(bound)),
            }
        }
    }

    /// Reports results that are passed on and called like such a parameter.
    pub(in crate::lower) fn check_passed_on(&mut self, results: &[Ident]) {
        for result in results {
            if let Some(place) = self.locals.get(&result.name).copied().filter(|_| self.hidden.contains(&result.name)) {
                let name = &result.name;
                self.report(
                    Diagnostic::error(
                        "P0503",
                        format!("`{name}` is a parameter here, so no result can have this name"),
                    )
                    .label(result.span, "passed on as a result here")
                    .label(place, "the parameter")
                    .help(format!("rename the parameter, for example to `{name}0`")),
                );
            }
        }
    }

    /// The parameters and the body, with new names for those that are called like a result of a process in it.
    pub(in crate::lower) fn kept_apart(&mut self, parameters: Vec<Name>, body: Term) -> (Vec<Name>, Term) {
        if self.hidden.is_empty() {
            return (parameters, body);
        }
        let mut taken: BTreeSet<Name> = bound_names(&body).union(&read_names(&body)).cloned().collect();
        taken.extend(parameters.iter().chain(self.results.keys()).cloned());
        let (mut renamed, mut map) = (Vec::new(), std::collections::BTreeMap::new());
        for parameter in parameters {
            let mut apart = parameter.to_string();
            if self.hidden.contains(&parameter) {
                let free = |name: &Name| !taken.contains(name) && self.environment.quantity(name).is_none();
                while !free(&Name::new(&apart)) {
                    apart.push('\'');
                }
                map.insert(parameter, Value::variable(&Name::new(&apart)));
            }
            let apart = Name::new(&apart);
            taken.insert(apart.clone());
            renamed.push(apart);
        }
        match substitute_values(&body, &map) {
            Ok(body) => (renamed, body),
            Err(why) => {
                let place = map.keys().find_map(|name| self.locals.get(name).copied()).unwrap_or_default();
                let text = format!("this parameter is called like a result of a process here: {}", why.0);
                self.report(Diagnostic::error("P0503", text).label(place, "rename it"));
                (renamed, body)
            }
        }
    }
}

/// What comes of looking for a call.
enum Found {
    /// It is not here.
    Nothing,
    /// It is, and this reads the name after it.
    Call(Option<Span>),
}

/// Looks for the call at a place; `later` reads the name after this term.
fn after(term: &Written, name: &Name, call: Span, later: Option<Span>) -> Found {
    let all = |parts: &[Written]| {
        let found = parts.iter().map(|part| after(part, name, call, later));
        found.into_iter().find(|found| matches!(found, Found::Call(_))).unwrap_or(Found::Nothing)
    };
    match &term.kind {
        TermKind::Apply { name: called, .. } if called.span == call => Found::Call(later),
        TermKind::Apply { .. } | TermKind::Meta(..) => Found::Nothing,
        TermKind::Seq(parts) => {
            let mut later = later;
            for part in parts.iter().rev() {
                if let found @ Found::Call(_) = after(part, name, call, later) {
                    return found;
                }
                later = read_in(part, name).or(later);
            }
            Found::Nothing
        }
        // Parts side by side do not see what others bind, and what aborts has bound nothing.
        TermKind::Par(parts) | TermKind::Disable(parts) => all(parts),
        TermKind::Else(first, second) => match after(first, name, call, later) {
            Found::Nothing => after(second, name, call, later),
            found => found,
        },
        TermKind::Try(body) | TermKind::New(_, body) | TermKind::Project(body, _) => after(body, name, call, later),
        // Later rounds and replacements read what was bound before.
        TermKind::Power(body, ..) | TermKind::Loop(body) => after(body, name, call, read_in(body, name).or(later)),
        TermKind::Replace(body, ..) => after(body, name, call, read_in(term, name).or(later)),
    }
}

/// Where a name is read in a term.
fn read_in(term: &Written, name: &Name) -> Option<Span> {
    let in_value = |value: &WrittenValue| {
        let mut idents = Vec::new();
        names(value, &mut idents);
        idents.into_iter().find(|ident| ident.name == *name).map(|ident| ident.span)
    };
    term.all().into_iter().find_map(|part| match &part.kind {
        TermKind::Apply { name: called, arguments, .. } => {
            let ports = usize::from(matches!(called.name.as_str(), "In" | "Out"));
            arguments.iter().skip(ports).find_map(in_value)
        }
        TermKind::Meta(_, arguments) => arguments.iter().find_map(in_value),
        TermKind::Power(_, value, _) | TermKind::Replace(_, _, value) => in_value(value),
        _ => None,
    })
}
