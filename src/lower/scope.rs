//! What is known while one item is lowered.

mod hidden;

use std::collections::{BTreeMap, BTreeSet};

use super::value::{Needed, Requirement};
use super::{Class, Environment};
use crate::ast::{Ident, Term, TermKind, ValueKind};
use crate::closed_form::Comparison;
use crate::diagnostic::{Diagnostic, Span, nearest};
use crate::lexer::MOST_ERRORS;
use crate::name::Name;
use crate::value::{Sort, Value};

/// Which `?x` may be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Metas {
    /// None.
    Forbidden,
    /// Values to be found, in a property.
    Values,
    /// Values and processes, in a law or a claim.
    Law,
    /// None, in what is said of what is shown: names of it stand for the values.
    Shown,
}

/// Lowers one item; collects what is wrong with it.
pub(super) struct Lowerer<'e> {
    pub(super) environment: &'e Environment,
    pub(super) metas: Metas,
    /// The parameters of the process or function, and the index of a power around.
    pub(super) locals: BTreeMap<Name, Span>,
    /// Every name that is bound somewhere in the item.
    pub(super) results: BTreeMap<Name, Span>,
    /// Results that are also declared for the whole text, with the names they are kept apart by.
    pub(super) apart: BTreeMap<Name, Name>,
    /// Parameters with the calls of processes that bind a result of the same name.
    pub(super) clashes: Vec<(Name, Ident)>,
    /// Parameters of this process that nobody reads where such a result could be meant: they are kept under another name.
    pub(super) hidden: BTreeSet<Name>,
    /// Every name that is used as a port somewhere in the item.
    pub(super) ports: BTreeMap<Name, Span>,
    /// What names must be, with the place that says so.
    pub(super) classes: BTreeMap<Name, (Class, Span)>,
    /// Arguments of processes, to be compared with what their parameters must be.
    pub(super) calls: Vec<(Name, usize, Class, Span)>,
    /// What those arguments are that are no bare names.
    pub(super) given: Vec<(Name, usize, Sort, Span)>,
    /// The property that is being declared.
    pub(super) own: Option<Name>,
    /// Whether the processes of the text have all been defined by now.
    pub(super) settled: bool,
    /// Whether projections may name observers that are declared later: in a rule file.
    pub(super) lenient: bool,
    /// Whether any name of a value may be read: in a part of a process, away from what binds it.
    pub(super) free: bool,
    /// Names that are vectors, with the number of components.
    pub(super) shapes: BTreeMap<Name, usize>,
    /// What the parameters of a function stand for, while its body is read anew.
    pub(super) images: BTreeMap<Name, Value>,
    /// What values need that have been read, and where, while that is kept.
    pub(super) needed: Option<Vec<Needed>>,
    /// In which ways the conditions around what is read come to hold; none where that is too many.
    pub(super) guards: Option<Vec<Vec<Comparison>>>,
    /// The parameters in the exponents of the equations read.
    pub(super) exponents: BTreeSet<Name>,
    /// Whether the terms that are called `factorial` are factorials.
    pub(super) factorials: bool,
    /// What must hold of parameters for the equations read to mean something.
    pub(super) conditions: Vec<Requirement>,
    /// How often bodies of functions may still be read anew, and how deep in others this one is.
    pub(super) readings: usize,
    pub(super) depth: usize,
    pub(super) errors: Vec<Diagnostic>,
}

impl Environment {
    /// The name that keeps a result of this name apart from what is declared for the whole text: with primes; none when
    /// nothing is declared under it.
    pub(super) fn apart(&self, name: &Name) -> Option<Name> {
        self.quantity(name)?;
        let mut apart = format!("{name}'");
        while self.quantities.contains_key(&Name::new(&apart)) {
            apart.push('\'');
        }
        Some(Name::new(&apart))
    }
}

impl<'e> Lowerer<'e> {
    pub(super) fn new(environment: &'e Environment, metas: Metas) -> Lowerer<'e> {
        Lowerer {
            environment,
            metas,
            locals: BTreeMap::new(),
            results: BTreeMap::new(),
            apart: BTreeMap::new(),
            clashes: Vec::new(),
            hidden: BTreeSet::new(),
            ports: BTreeMap::new(),
            classes: BTreeMap::new(),
            calls: Vec::new(),
            given: Vec::new(),
            own: None,
            settled: true,
            lenient: false,
            free: false,
            shapes: BTreeMap::new(),
            images: BTreeMap::new(),
            needed: None,
            guards: Some(vec![Vec::new()]),
            exponents: BTreeSet::new(),
            factorials: false,
            conditions: Vec::new(),
            readings: 10_000,
            depth: 0,
            errors: Vec::new(),
        }
    }

    pub(super) fn report(&mut self, diagnostic: Diagnostic) {
        if self.errors.len() < MOST_ERRORS {
            self.errors.push(diagnostic);
        }
    }

    /// Reports, and has no answer.
    pub(super) fn fail<T>(&mut self, diagnostic: Diagnostic) -> Option<T> {
        self.report(diagnostic);
        None
    }

    pub(super) fn finish<T>(self, result: Option<T>) -> Result<T, Vec<Diagnostic>> {
        match result {
            Some(result) if self.errors.is_empty() => Ok(result),
            _ => Err(self.errors),
        }
    }

    /// Takes the parameters of a declaration into scope.
    pub(super) fn parameters(&mut self, parameters: &[Ident]) {
        for parameter in parameters {
            if let Some(first) = self.locals.insert(parameter.name.clone(), parameter.span) {
                self.report(
                    Diagnostic::error("P0501", format!("two parameters are named `{}`", parameter.name))
                        .label(parameter.span, "again here")
                        .label(first, "first here"),
                );
            }
        }
    }

    /// Notes every name that these terms bind, and every port they use.
    pub(super) fn bind(&mut self, terms: &[&Term]) {
        self.bind_all(terms);
        self.check_clashes(terms);
    }

    fn bind_all(&mut self, terms: &[&Term]) {
        let mut rest: Vec<&Term> = terms.to_vec();
        let mut written = BTreeMap::new();
        while let Some(term) = rest.pop() {
            match &term.kind {
                TermKind::Apply { name, arguments, results } => {
                    for result in results {
                        written.entry(result.name.clone()).or_insert(result.span);
                        self.bind_one(result);
                    }
                    self.bind_called(name);
                    let port = arguments.first().map(|argument| &argument.kind);
                    if let (true, Some(ValueKind::Name(port))) = (matches!(name.name.as_str(), "In" | "Out"), port) {
                        self.ports.entry(port.name.clone()).or_insert(port.span);
                    }
                }
                TermKind::Seq(parts) | TermKind::Par(parts) | TermKind::Disable(parts) => {
                    rest.extend(parts.iter().rev())
                }
                TermKind::Else(first, second) => rest.extend([&**second, &**first]),
                TermKind::New(port, body) => {
                    self.ports.entry(port.name.clone()).or_insert(port.span);
                    rest.push(body);
                }
                TermKind::Power(body, ..)
                | TermKind::Try(body)
                | TermKind::Loop(body)
                | TermKind::Project(body, _)
                | TermKind::Replace(body, ..) => rest.push(body),
                TermKind::Meta(..) => {}
            }
        }
        self.check_apart(&written);
    }

    fn bind_one(&mut self, result: &Ident) {
        let name = &result.name;
        if let Some(place) = self.locals.get(name).copied() {
            self.report(
                Diagnostic::error("P0503", format!("`{name}` is a parameter here, so no result can have this name"))
                    .label(result.span, "bound as a result here")
                    .label(place, "the parameter")
                    .help(format!("give the result another name, such as `{name}1`")),
            );
        } else if let Some(apart) = self.environment.apart(name) {
            self.results.entry(apart.clone()).or_insert(result.span);
            self.apart.insert(name.clone(), apart);
            return;
        }
        self.results.entry(name.clone()).or_insert(result.span);
    }

    /// The name under which a result is known: a result called like a value of the whole text is kept apart from it.
    pub(super) fn result_name<'n>(&'n self, name: &'n Name) -> &'n Name {
        self.apart.get(name).unwrap_or(name)
    }

    /// Reports results that would have one name once those are kept apart that are declared for the whole text.
    fn check_apart(&mut self, written: &BTreeMap<Name, Span>) {
        for (name, apart) in self.apart.clone() {
            if let (Some(one), Some(other)) = (written.get(&name).copied(), written.get(&apart).copied()) {
                self.report(
                    Diagnostic::error("P0503", format!("`{name}` and `{apart}` cannot both be results here"))
                        .label(other, "bound as a result here")
                        .label(
                            one,
                            format!("this result is kept as `{apart}`, since `{name}` is declared for the whole text"),
                        )
                        .help(format!("give one of them another name, such as `{name}1`")),
                );
            }
        }
    }

    /// A call binds what the process it calls binds.
    fn bind_called(&mut self, name: &Ident) {
        let Some(super::Entity::Process(signature)) = self.environment.entity(&name.name) else {
            return;
        };
        for bound in &signature.flow.binds {
            if self.locals.contains_key(bound) {
                self.clashes.push((bound.clone(), name.clone()));
            }
            self.results.entry(bound.clone()).or_insert(name.span);
        }
    }

    /// The error that a name is unknown, with the nearest known one.
    pub(super) fn unknown<'n>(
        &mut self,
        code: &'static str,
        what: &str,
        ident: &Ident,
        known: impl Iterator<Item = &'n str>,
        otherwise: &str,
    ) {
        let wrong = ident.name.as_str();
        // Criteria are several, also where one name stands for all.
        let is = if what == "criteria" { "are" } else { "is" };
        let diagnostic =
            Diagnostic::error(code, format!("there {is} no {what} `{wrong}`")).label(ident.span, "not declared");
        let known: Vec<&str> = known.collect();
        let meant = elsewhere(wrong).filter(|name| known.contains(name));
        self.report(match meant.or_else(|| nearest(wrong, known.iter().copied())) {
            Some(name) => diagnostic.edit(format!("did you mean `{name}`?"), ident.span, name),
            None => diagnostic.help(otherwise),
        });
    }

    /// Reports an argument of the wrong class.
    pub(super) fn wrong_class(&mut self, callee: &Name, index: usize, class: Class, span: Span) {
        let needed = if class == Class::Number { Class::Distribution } else { Class::Number };
        let parameter = match self.environment.entity(callee) {
            Some(super::Entity::Process(signature)) => signature.parameters.get(index).map_or("", Name::as_str),
            _ => "",
        };
        let (given, needed) = (words(class), words(needed));
        self.report(
            Diagnostic::error(
                "P0401",
                format!("`{callee}` uses its parameter `{parameter}` as {needed}, but {given} is given"),
            )
            .label(span, format!("{given} here")),
        );
    }

    /// Notes that a name must be of this class here; an error when it had to be another one before.
    pub(super) fn must_be(&mut self, name: &Name, class: Class, span: Span) {
        match self.classes.get(name).copied() {
            Some((before, place)) if before != class => {
                self.report(
                    Diagnostic::error("P0401", format!("`{name}` is used both as a number and as a distribution"))
                        .label(span, format!("as {} here", words(class)))
                        .label(place, format!("as {} here", words(before))),
                );
            }
            Some(_) => {}
            None => {
                self.classes.insert(name.clone(), (class, span));
            }
        }
    }
}

/// `a number`, `a distribution`
pub(super) fn words(class: Class) -> &'static str {
    match class {
        Class::Number => "a number",
        Class::Distribution => "a distribution",
    }
}

/// The basic process that goes by this name in other languages.
fn elsewhere(name: &str) -> Option<&'static str> {
    Some(match name {
        "Leq" | "Le" | "LessEqual" => "Lte",
        "Geq" | "Ge" | "GreaterEqual" => "Gte",
        "Lt" | "Less" => "Lss",
        "Gt" | "Greater" => "Gtr",
        "Ne" | "NotEqual" => "Neq",
        "Equal" => "Eq",
        "Wait" | "Sleep" => "Delay",
        "Skip" => "Stop",
        "Send" | "Write" => "Out",
        "Receive" | "Read" => "In",
        _ => return None,
    })
}
