//! Processes: names resolved, arities and results checked.

use std::collections::BTreeSet;

use super::scope::{Lowerer, Metas};
use super::value::{count_of, were};
use super::{BASIC, Class, Entity};
use crate::ast::{Ident, Term as Written, TermKind, Value as WrittenValue, ValueKind};
use crate::diagnostic::{Diagnostic, Span};
use crate::name::Name;
use crate::term::{Node, Term};
use crate::value::{Relation, Value};

/// The relation of a guard's name.
pub(super) fn guard(name: &str) -> Option<Relation> {
    Some(match name {
        "Eq" => Relation::Eq,
        "Neq" => Relation::Neq,
        "Gtr" => Relation::Gtr,
        "Gte" => Relation::Gte,
        "Lss" => Relation::Lss,
        "Lte" => Relation::Lte,
        _ => return None,
    })
}

impl Lowerer<'_> {
    /// The process that is written here.
    pub(super) fn process(&mut self, written: &Written) -> Option<Term> {
        Some(match &written.kind {
            TermKind::Apply { name, arguments, results } => return self.apply(name, arguments, results, written.span),
            TermKind::Meta(name, arguments) => return self.meta(name, arguments),
            TermKind::Seq(parts) => Term::seq(self.processes(parts)?),
            TermKind::Par(parts) => Term::par(self.processes(parts)?),
            TermKind::Disable(parts) => Term::disable(self.processes(parts)?),
            TermKind::Else(first, second) => {
                let first = self.process(first);
                let second = self.process(second)?;
                Term::otherwise(first?, second)
            }
            TermKind::Power(body, count, index) => return self.power(body, count, index.as_ref()),
            TermKind::Try(body) => Term::attempt(self.process(body)?),
            TermKind::Loop(body) => Term::new(Node::Loop(self.process(body)?)),
            TermKind::New(port, body) => {
                self.port_name(port)?;
                Term::new(Node::New(port.name.clone(), self.process(body)?))
            }
            TermKind::Project(body, shown) => {
                let body = self.process(body);
                let shown = self.shown(shown)?;
                Term::new(Node::Project(body?, shown))
            }
            TermKind::Replace(body, name, value) => {
                if self.metas != Metas::Law {
                    return self.fail(
                        Diagnostic::error("P0310", "a replacement `P[y := x]` can be written in laws and claims only")
                            .label(written.span, "here")
                            .help("use `Set_x<y> ; P`"),
                    );
                }
                let value = self.number(value);
                // A result that is kept apart is read under its own name in here as well.
                let body = match self.apart.contains_key(&name.name) {
                    true => self.process(body),
                    false => self.with_local(name, |lowerer| lowerer.process(body)),
                };
                Term::new(Node::Replace(body?, self.result_name(&name.name).clone(), value?))
            }
        })
    }

    /// Reads with this name in scope.
    fn with_local<T>(&mut self, name: &Ident, read: impl FnOnce(&mut Self) -> T) -> T {
        let before = self.locals.insert(name.name.clone(), name.span);
        let found = read(self);
        match before {
            Some(span) => self.locals.insert(name.name.clone(), span),
            None => self.locals.remove(&name.name),
        };
        found
    }

    fn processes(&mut self, parts: &[Written]) -> Option<Vec<Term>> {
        let lowered: Vec<_> = parts.iter().map(|part| self.process(part)).collect();
        lowered.into_iter().collect()
    }

    fn power(&mut self, body: &Written, count: &WrittenValue, index: Option<&Ident>) -> Option<Term> {
        let count = self.real(count);
        if let Some(value) = count.as_ref().and_then(Value::as_rational) {
            let natural = value.is_integer() && value >= num_rational::BigRational::from_integer(0.into());
            if !natural {
                return self.fail(
                    Diagnostic::error("P0404", format!("a process cannot be repeated {value} times"))
                        .label(body.span, "this process")
                        .help("the number behind `^` must be 0, 1, 2, …"),
                );
            }
        }
        let body = match index {
            Some(index) => self.with_local(index, |lowerer| lowerer.process(body)),
            None => self.process(body),
        };
        Some(Term::new(Node::Power(body?, count?, index.map(|index| index.name.clone()))))
    }

    fn meta(&mut self, name: &Ident, arguments: &[WrittenValue]) -> Option<Term> {
        if self.metas != Metas::Law {
            return self.fail(
                Diagnostic::error("P0301", format!("`{}` stands for any process, which has no place here", name.name))
                    .label(name.span, "only in laws and claims")
                    .help("name a process that is defined"),
            );
        }
        let values: Vec<_> = arguments.iter().map(|argument| self.number(argument)).collect();
        Some(Term::new(Node::Meta(name.name.clone(), values.into_iter().collect::<Option<Vec<_>>>()?)))
    }

    /// The observers to keep, without `Delay`, which always stays.
    pub(super) fn shown(&mut self, shown: &[Ident]) -> Option<BTreeSet<Name>> {
        let mut names = BTreeSet::new();
        let mut fine = true;
        for ident in shown {
            let name = &ident.name;
            if name.as_str() == "Delay" {
                continue;
            }
            let meta = name.is_meta() && self.metas == Metas::Law;
            let named = matches!(self.environment.entity(name), Some(Entity::Observer(_) | Entity::Process(_)));
            if !meta && !named && !self.lenient {
                let environment = self.environment;
                let known = environment
                    .entities()
                    .filter(|(_, entity)| matches!(entity, Entity::Observer(_) | Entity::Process(_)));
                self.unknown(
                    "P0311",
                    "observer",
                    ident,
                    known.map(|(name, _)| name.as_str()),
                    &format!("declare it with `observer {name}`"),
                );
                fine = false;
            }
            names.insert(name.clone());
        }
        fine.then_some(names)
    }

    fn apply(&mut self, name: &Ident, arguments: &[WrittenValue], results: &[Ident], span: Span) -> Option<Term> {
        if BASIC.contains(&name.name.as_str()) {
            return self.basic(name, arguments, results, span);
        }
        let environment = self.environment;
        let entity = environment.entity(&name.name);
        if self.own.as_ref() == Some(&name.name) {
            self.arity(name, arguments.len(), &[], span)?;
            return Some(Term::new(Node::Call(name.name.clone(), Vec::new())));
        }
        match entity {
            Some(Entity::Process(signature)) => {
                let fits = self.arity(name, arguments.len(), &signature.parameters, span);
                let values = self.call_arguments(name, arguments);
                fits?;
                self.called_results(name, results, signature)?;
                if self.settled && environment.definitions.get(&name.name).is_none() {
                    return self.refused(name);
                }
                Some(Term::new(Node::Call(name.name.clone(), values?)))
            }
            Some(Entity::Observer(count)) => {
                let letters: Vec<Name> = (0..*count).map(|index| Name::new(&format!("x{}", index + 1))).collect();
                let fits = self.arity(name, arguments.len(), &letters, span);
                self.no_results(name, results);
                let values: Vec<_> = arguments.iter().map(|argument| self.as_shown(argument)).collect();
                fits?;
                Some(Term::new(Node::Observe(name.name.clone(), values.into_iter().collect::<Option<Vec<_>>>()?)))
            }
            Some(entity) if self.settled && entity.is_broken() => self.refused(name),
            Some(Entity::System(system)) => {
                self.arity(name, arguments.len(), &[], span)?;
                if !self.settled {
                    return self.out_of_place(name, "system");
                }
                Some(system.term(&environment.definitions))
            }
            Some(Entity::Property(_)) => self.out_of_place(name, "property"),
            None => {
                self.unknown_process(name);
                None
            }
        }
    }

    pub(super) fn refused(&mut self, name: &Ident) -> Option<Term> {
        self.fail(cannot_be_used(&name.name, name.span))
    }

    fn out_of_place(&mut self, name: &Ident, word: &str) -> Option<Term> {
        self.fail(
            Diagnostic::error("P0313", format!("`{}` is a {word}, but a process is needed here", name.name))
                .label(name.span, format!("a {word}"))
                .note("a process is made of basic processes, observers and processes defined by `proc`"),
        )
    }

    pub(super) fn unknown_process(&mut self, name: &Ident) {
        let environment = self.environment;
        let known = environment.entities().map(|(name, _)| name.as_str()).chain(BASIC);
        let advice = format!(
            "define it with `proc {0} = …`, or declare `observer {0}` if it is something to be seen",
            name.name
        );
        self.unknown("P0314", "process", name, known, &advice);
    }

    /// Reports a wrong number of parameters.
    fn arity(&mut self, name: &Ident, given: usize, parameters: &[Name], span: Span) -> Option<()> {
        if given == parameters.len() {
            return Some(());
        }
        let text = &name.name;
        let names = parameters.iter().map(Name::as_str).collect::<Vec<_>>().join(",");
        let example = match parameters.len() {
            0 => text.to_string(),
            1 => format!("{text}_{names}"),
            _ => format!("{text}_{{{names}}}"),
        };
        let wanted = count_of(parameters.len(), "parameter");
        let help = match (parameters.len(), given) {
            (1, 2) => format!("write `{example}`; a vector has brackets of its own: `{text}_{{(a,b)}}`"),
            _ => format!("write `{example}`"),
        };
        self.fail(
            Diagnostic::error("P0315", format!("`{text}` takes {wanted}, and {} given", were(given)))
                .label(span, format!("{wanted} needed"))
                .help(help),
        )
    }

    fn call_arguments(&mut self, name: &Ident, arguments: &[WrittenValue]) -> Option<Vec<Value>> {
        let mut values = Vec::new();
        let mut fine = true;
        for (index, argument) in arguments.iter().enumerate() {
            let value = match self.class_of(argument, &name.name, index) {
                Class::Number => self.number(argument),
                Class::Distribution => self.distribution(argument),
            };
            fine &= value.is_some();
            if let Some(value) = &value {
                self.note_sort(name, index, value, argument);
            }
            values.extend(value);
        }
        fine.then_some(values)
    }

    /// Whether an argument of a process is a number or a distribution; noted, to be compared with the parameter.
    fn class_of(&mut self, argument: &WrittenValue, callee: &Name, index: usize) -> Class {
        let class = match &argument.kind {
            ValueKind::Name(name) => match self.environment.quantity(&name.name) {
                Some(super::Quantity::Parameter { class, .. }) if !self.locals.contains_key(&name.name) => *class,
                _ => self.classes.get(&name.name).map_or(Class::Number, |(class, _)| *class),
            },
            ValueKind::Call(name, _) if name.name.as_str().chars().next().is_some_and(char::is_uppercase) => {
                Class::Distribution
            }
            _ => Class::Number,
        };
        let needed = match self.environment.entity(callee) {
            Some(Entity::Process(signature)) => signature.classes.get(index).copied().flatten(),
            _ => None,
        };
        if self.settled && needed.is_some_and(|needed| needed != class) {
            self.wrong_class(callee, index, class, argument.span);
        }
        self.calls.push((callee.clone(), index, class, argument.span));
        class
    }

    fn called_results(&mut self, name: &Ident, results: &[Ident], signature: &super::Signature) -> Option<()> {
        if !self.settled {
            return Some(());
        }
        match self.unbound(name, results, &signature.flow.binds) {
            Some(diagnostic) => self.fail(diagnostic),
            None => Some(()),
        }
    }

    /// What is wrong with the results that stand behind a call, of a process that binds these.
    pub(super) fn unbound(&self, name: &Ident, results: &[Ident], binds: &BTreeSet<Name>) -> Option<Diagnostic> {
        let result = results.iter().find(|result| !binds.contains(self.result_name(&result.name)))?;
        let (text, wrong) = (&name.name, &result.name);
        let bound: Vec<&str> = binds.iter().map(Name::as_str).collect();
        let note =
            if bound.is_empty() { "it binds nothing".to_string() } else { format!("it binds {}", bound.join(", ")) };
        let diagnostic = Diagnostic::error("P0504", format!("`{text}` binds no result `{wrong}`"))
            .label(result.span, "this result")
            .note(note)
            .note("a process passes on its results under the names its definition gives them");
        Some(match bound.first() {
            Some(first) => diagnostic.help(format!(
                "to give `{first}` the name `{wrong}`, leave it out and write `; Set_{first}<{wrong}>` behind it"
            )),
            None => diagnostic.help("leave it out, with its brackets"),
        })
    }

    fn no_results(&mut self, name: &Ident, results: &[Ident]) {
        if let Some(result) = results.first() {
            self.report(
                Diagnostic::error("P0316", format!("`{}` has no result", name.name))
                    .label(result.span, "leave this out, with its brackets"),
            );
        }
    }

    fn one_result(&mut self, name: &Ident, results: &[Ident], span: Span, example: &str) -> Option<Name> {
        match results {
            [result] => Some(self.result_name(&result.name).clone()),
            _ => self.fail(
                Diagnostic::error(
                    "P0317",
                    format!("`{}` needs one name for its result, and {} given", name.name, were(results.len())),
                )
                .label(span, "here")
                .help(format!("write `{example}`")),
            ),
        }
    }

    fn basic(&mut self, name: &Ident, arguments: &[WrittenValue], results: &[Ident], span: Span) -> Option<Term> {
        let text = name.name.as_str();
        let letters: &[&str] = match text {
            "Stop" | "Abort" | "Idle" => &[],
            "Delay" => &["t"],
            "In" => &["c"],
            "Out" => &["c", "x"],
            "Set" => &["x"],
            "Ran" => &["D"],
            _ => &["x", "y"],
        };
        let letters: Vec<Name> = letters.iter().map(|letter| Name::new(letter)).collect();
        self.arity(name, arguments.len(), &letters, span)?;
        if !matches!(text, "In" | "Set" | "Ran") {
            self.no_results(name, results);
        }
        let mut arguments = arguments.iter();
        let (first, second) = (arguments.next(), arguments.next());
        Some(match (text, first, second) {
            ("Abort", ..) => Term::abort(),
            ("Idle", ..) => Term::idle(),
            ("Delay", Some(time), _) => Term::delay(self.real(time)?),
            ("In", Some(port), _) => {
                let result = self.one_result(name, results, span, "In_c<y>");
                Term::new(Node::In(self.port(port)?, result?))
            }
            ("Out", Some(port), Some(value)) => {
                let value = self.number(value);
                Term::new(Node::Out(self.port(port)?, value?))
            }
            ("Set", Some(value), _) => {
                let result = self.one_result(name, results, span, "Set_x<y>");
                Term::new(Node::Set(self.number(value)?, result?))
            }
            ("Ran", Some(distribution), _) => {
                let result = self.one_result(name, results, span, "Ran_D<y>");
                Term::new(Node::Ran(self.distribution(distribution)?, result?))
            }
            (text, Some(left), Some(right)) => {
                let relation = guard(text)?;
                let (left, right) = self.compared_sides(relation, left, right)?;
                Term::new(Node::Guard(relation, left, right))
            }
            _ => Term::stop(),
        })
    }

    fn port(&mut self, written: &WrittenValue) -> Option<Name> {
        match &written.kind {
            ValueKind::Name(name) => {
                self.port_name(name)?;
                Some(name.name.clone())
            }
            _ => self.fail(
                Diagnostic::error("P0403", "a port is a name, but a value stands here")
                    .label(written.span, "this is a value")
                    .help("the port comes first: `Out_{c,x}` sends x through port c"),
            ),
        }
    }

    /// Reports a port whose name is a parameter here.
    pub(super) fn port_name(&mut self, port: &Ident) -> Option<()> {
        let name = &port.name;
        let place = self.locals.get(name).copied();
        let meta_value = if name.is_meta() { self.classes.get(name).map(|(_, span)| *span) } else { None };
        if let Some(place) = place.or(meta_value) {
            return self.fail(
                Diagnostic::error("P0403", format!("`{name}` is a value, but a port is needed here"))
                    .label(port.span, "used as a port here")
                    .label(place, "a value since here")
                    .help("ports have fixed names; give the port or the value another name"),
            );
        }
        Some(())
    }
}

/// Of what has errors itself, where it is used.
pub(super) fn cannot_be_used(name: &Name, place: Span) -> Diagnostic {
    Diagnostic::error("P0312", format!("`{name}` cannot be used: its definition has errors")).label(place, "used here")
}
