//! Values: names resolved, functions inlined, everything in normal form.

mod cases;
mod guards;

pub(super) use cases::chosen;
pub(super) use guards::{Kept, Needed, Requirement, Ways, behind_guards, both, neither};

use std::collections::BTreeMap;

use super::distribution::{DISTRIBUTIONS, example};
use super::scope::{Lowerer, Metas, words};
use super::{Class, Quantity};
use num_traits::{One, Signed};

use crate::ast::{Argument, FACTORIAL, Ident, Value as Written, ValueKind};
use crate::diagnostic::{Diagnostic, Span, nearest, product};
use crate::name::Name;
use crate::value::{Need, Sort, Value, ValueError, keeps_divisors, taken_for_granted};

/// The functions of the language, with how many arguments they take; none: any number but zero.
pub(super) const FUNCTIONS: [(&str, Option<usize>); 11] = [
    ("abs", Some(1)),
    ("min", None),
    ("max", None),
    ("norm", Some(1)),
    ("unit", Some(1)),
    ("clamp", Some(3)),
    ("floor", Some(1)),
    ("ceil", Some(1)),
    ("mod", Some(2)),
    ("sqrt", Some(1)),
    ("part", Some(2)),
];

type Step = fn(&Value, &Value) -> Result<Value, ValueError>;

/// How a claim speaks of what is shown.
const SHOWN: &str = "give each value that is shown a name, and speak of it by that: `always p <= 6 when At_p`";

impl Lowerer<'_> {
    /// The number, or vector of numbers, that is written here.
    pub(super) fn number(&mut self, written: &Written) -> Option<Value> {
        let result = match &written.kind {
            ValueKind::Number(number) => return Some(Value::rational(number.clone())),
            ValueKind::Name(name) => return self.name(name, Class::Number),
            ValueKind::Sum(parts) => return self.fold(parts, written.span, (Value::add, Value::sub), false),
            ValueKind::Product(parts) => return self.fold(parts, written.span, (Value::mul, Value::over), true),
            ValueKind::Power(base, exponent) => {
                let (base, exponent) = (self.number(base), self.number(exponent)?);
                let base = base?;
                if base.has_sign() && !self.counts(&exponent) {
                    return self.no_count(&exponent, written.span);
                }
                if exponent.as_rational().is_some_and(|exponent| exponent.is_negative()) {
                    self.never_nothing(&base, written.span);
                }
                self.needs_of_power(&base, &exponent, written.span);
                base.power(&exponent)
            }
            ValueKind::Negative(inner) => self.number(inner)?.neg(),
            ValueKind::Absolute(inner) => self.number(inner)?.abs(),
            ValueKind::If(relation, parts) => self.choice(*relation, parts)?,
            ValueKind::Vector(parts) => {
                let values: Vec<_> = parts.iter().map(|part| self.number(part)).collect();
                Value::vector(values.into_iter().collect::<Option<Vec<_>>>()?)
            }
            ValueKind::Call(name, arguments) => return self.call(name, arguments, written.span),
            ValueKind::Iterate(chain, arguments) => return self.iterated(chain, arguments, written.span),
            ValueKind::Cases(cases) => return self.cases(cases, written.span),
        };
        self.valid(result, written.span)
    }

    /// Whether an exponent of a negative number is a number, a name that is counted up or down from a number, or made of
    /// natural numbers: `(-1)^(2*q)` is 1 for whole numbers q, and -1 for 1/2.
    pub(super) fn counts(&self, exponent: &Value) -> bool {
        let names = exponent.variables();
        let single = || {
            names.first().zip(exponent.numerator()).is_some_and(|(name, own)| {
                let steps = own.linear_in(name).and_then(|(factor, rest)| factor.as_rational().zip(rest.as_rational()));
                own == *exponent && steps.is_some_and(|(by, from)| (by.is_one() || (-by).is_one()) && from.is_integer())
            })
        };
        let natural = |name: &Name| self.environment.assumptions.is_natural(&Value::variable(name)) == Some(true);
        // What is left of the power says that it counts: of `(-1)^(2*q)` nothing is.
        let kept = || {
            let power = Value::integer(-1).power(exponent);
            exponent.is_whole() && power.is_ok_and(|power| power.needs().contains(&Need::Natural(exponent.clone())))
        };
        let one = names.len() == 1 && (single() || kept());
        names.is_empty() || one || exponent.is_always_whole() || names.iter().all(natural)
    }

    pub(super) fn no_count<T>(&mut self, exponent: &Value, span: Span) -> Option<T> {
        let name = exponent.variables().first().map(ToString::to_string).unwrap_or_default();
        self.fail(
            Diagnostic::error("P0402", format!("a negative number to the power `{exponent}` is not known to exist"))
                .label(span, "in this value")
                .help(format!("say that it counts: `param {name} : natural`; `(-1)^{name}` alone needs no more")),
        )
    }

    pub(super) fn valid(&mut self, result: Result<Value, ValueError>, span: Span) -> Option<Value> {
        match result {
            Ok(value) => Some(value),
            Err(ValueError(text)) => self.fail(Diagnostic::error("P0402", text).label(span, "in this value")),
        }
    }

    /// Reports a divisor that is 0 in one of its cases: the fraction would be taken for what it is in the others.
    fn never_nothing(&mut self, divisor: &Value, span: Span) {
        let known = &self.environment.assumptions;
        let Some((relation, inside)) = taken_for_granted(&known.simplify(divisor)) else { return };
        if known.decide(relation, &inside, &Value::zero()) == Some(true) {
            return;
        }
        let contrary = relation.negated().symbol();
        self.report(
            Diagnostic::error("P0402", format!("division by 0 where {inside} {contrary} 0"))
                .label(span, "0 in one of its cases")
                .help("choose between whole fractions: `if c < 3 then 0 else 1/2`"),
        );
    }

    /// Keeps what a value needs, where that is asked for.
    pub(super) fn needs(&mut self, need: Need, span: Span) {
        if let Some(needed) = &mut self.needed {
            needed.push(Needed { need, span, guards: self.guards.clone() });
        }
    }

    /// The same of a function of the language. Of a number `unit` is the sign.
    fn needs_of(&mut self, function: &str, values: &[Value], (span, last): (Span, Span)) {
        match (function, values) {
            ("mod", [_, by]) => {
                self.never_nothing(by, span);
                self.needs(Need::Nonzero(by.clone()), last);
            }
            ("sqrt", [inner]) => self.needs(Need::Nonnegative(inner.clone()), last),
            ("unit", [whole]) if matches!(whole.sort(), Sort::Vector(_)) => {
                if let Ok(length) = whole.norm() {
                    self.never_nothing(&length, span);
                    self.needs(Need::Nonzero(length), last);
                }
            }
            _ => {}
        }
    }

    fn fold(
        &mut self,
        parts: &[(bool, Written)],
        span: Span,
        (with, without): (Step, Step),
        divides: bool,
    ) -> Option<Value> {
        let mut whole: Option<Value> = None;
        for (index, (inverse, part)) in parts.iter().enumerate() {
            let value = self.number(part);
            if index == 0 {
                whole = value;
                continue;
            }
            // Goes on after an error, to find those of the later parts.
            if let (Some(so_far), Some(value)) = (whole.take(), value) {
                let (so_far, value) = (self.beside(&so_far, &value), self.beside(&value, &so_far));
                let step = if *inverse { without } else { with };
                if *inverse && divides {
                    self.never_nothing(&value, part.span);
                    self.needs(Need::Nonzero(value.clone()), part.span);
                }
                whole = self.valid(step(&so_far, &value), span);
            }
        }
        whole
    }

    /// What a name stands for, which must be of this class.
    pub(super) fn name(&mut self, ident: &Ident, class: Class) -> Option<Value> {
        let name = &ident.name;
        if name.is_meta() {
            if self.metas == Metas::Forbidden {
                return self.fail(
                    Diagnostic::error(
                        "P0301",
                        format!("`{name}` stands for a value to be found, which has no place here"),
                    )
                    .label(ident.span, "not in a definition")
                    .help(format!(
                        "leave out the `?` and make `{}` a parameter",
                        name.as_str().trim_start_matches('?')
                    )),
                );
            }
            if self.metas == Metas::Shown {
                return self.fail(
                    Diagnostic::error("P0301", format!("nothing shows `{name}`: no value of it would be looked for"))
                        .label(ident.span, "stands for no value that is shown")
                        .help(SHOWN),
                );
            }
            if let Some(place) = self.ports.get(name).copied() {
                return self.port_as_value(ident, place);
            }
            self.must_be(name, class, ident.span);
            return self.whole_or_components(name);
        }
        if let Some(image) = self.images.get(name) {
            return Some(image.clone());
        }
        let name = if self.locals.contains_key(name) { name } else { &self.result_name(name).clone() };
        if self.locals.contains_key(name) || self.results.contains_key(name) {
            self.must_be(name, class, ident.span);
            return self.whole_or_components(name);
        }
        match self.environment.quantity(name) {
            Some(Quantity::Parameter { class: declared, .. }) if *declared != class => {
                let (declared, needed) = (words(*declared), words(class));
                self.fail(
                    Diagnostic::error(
                        "P0401",
                        format!("`{name}` was declared as {declared}, but {needed} is needed here"),
                    )
                    .label(ident.span, format!("{needed} is needed")),
                )
            }
            Some(Quantity::Parameter { constant: Some(value), .. }) => self.constant(ident, value.clone()),
            Some(Quantity::Parameter { constant: None, .. }) => Some(Value::variable(name)),
            Some(Quantity::Function { parameters, .. }) => {
                let example = format!("{name}({})", spelt(parameters));
                self.fail(
                    Diagnostic::error("P0302", format!("`{name}` is a function and needs its arguments"))
                        .label(ident.span, "without arguments")
                        .help(format!("write `{example}`")),
                )
            }
            None if self.free => Some(Value::variable(name)),
            None => self.unknown_value(ident, class),
        }
    }

    fn unknown_value(&mut self, ident: &Ident, class: Class) -> Option<Value> {
        if let Some(place) = self.ports.get(&ident.name).copied() {
            return self.port_as_value(ident, place);
        }
        if DISTRIBUTIONS.contains(&ident.name.as_str()) {
            let name = &ident.name;
            return self.fail(
                Diagnostic::error("P0303", format!("the distribution `{name}` needs its arguments"))
                    .label(ident.span, "without arguments")
                    .help(example(name.as_str())),
            );
        }
        let names: Vec<Name> = self.locals.keys().chain(self.results.keys()).cloned().collect();
        let environment = self.environment;
        let number = |name: &str| {
            let declared = environment.quantity(&Name::new(name));
            names.iter().any(|known| known.as_str() == name)
                || matches!(declared, Some(Quantity::Parameter { class: Class::Number, .. }))
        };
        let product = product(ident.name.as_str(), number).filter(|_| class == Class::Number);
        let known = || names.iter().chain(environment.quantities.keys()).map(Name::as_str);
        // A longer name with a letter too many is rather misspelt.
        let short = |product: &String| product.split('*').all(|factor| factor.chars().count() <= 2);
        let misspelt = || nearest(ident.name.as_str(), known()).is_some();
        if let Some(product) = product.filter(|product| short(product) || !misspelt()) {
            return self.fail(
                Diagnostic::error("P0304", format!("there is no value `{}`", ident.name))
                    .label(ident.span, "not declared")
                    .help(format!("letters side by side are one name: to multiply write `{product}`")),
            );
        }
        let advice = if class == Class::Distribution {
            let name = &ident.name;
            format!("declare it with `param {name} : distribution`, or write one, such as `Normal(8, sd: 3/5)`")
        } else if self.metas == Metas::Law {
            // `?L` is any process.
            format!("declare it with `param {}`, or write `?{}` for any value", ident.name, small(&ident.name))
        } else if self.metas == Metas::Shown {
            format!("{SHOWN}; what is the same for the whole text is declared with `param {}`", ident.name)
        } else if self.metas == Metas::Values {
            let name = &ident.name;
            let unknown = small(name);
            format!(
                "declare it with `param {name}`, write `?{unknown}` for a value to be found, or say what is to hold of it \
                 wherever it is shown: `property … where {name} > 1`"
            )
        } else {
            format!(
                "declare it with `param {}`, make it a parameter, or bind it before with `In_c<{0}>` or `Set_x<{0}>`",
                ident.name
            )
        };
        self.unknown("P0304", "value", ident, known(), &advice);
        None
    }

    fn port_as_value(&mut self, ident: &Ident, place: Span) -> Option<Value> {
        let name = &ident.name;
        self.fail(
            Diagnostic::error("P0403", format!("`{name}` is a port, but a value is needed here"))
                .label(ident.span, "used as a value here")
                .label(place, "used as a port here")
                .help(format!("to use what comes through the port, read it first: `In_{name}<x>`")),
        )
    }

    fn call(&mut self, name: &Ident, arguments: &[Argument], span: Span) -> Option<Value> {
        let text = name.name.as_str();
        if DISTRIBUTIONS.contains(&text) || text == "N" {
            return self.fail(
                Diagnostic::error("P0401", "a number is needed here, but this is a distribution")
                    .label(span, "a distribution")
                    .help(format!("draw from it first: `Ran_{{{text}(…)}}<x>`, then use `x`")),
            );
        }
        if self.hides(name) {
            return None;
        }
        let values: Vec<_> = arguments.iter().map(|argument| self.plain(argument)).collect();
        let basic = FUNCTIONS.iter().find(|(known, _)| *known == text);
        let needed = match (self.environment.quantity(&name.name), basic) {
            (Some(Quantity::Function { parameters, .. }), _) => Some(parameters.len()),
            (_, Some((_, count))) => *count,
            (_, None)
                if text == FACTORIAL
                    && let [Some(of)] = values.as_slice() =>
            {
                return self.factorial(of, span);
            }
            (_, None) => return self.unknown_function(name),
        };
        if needed.map_or(values.is_empty(), |needed| needed != values.len()) {
            let wanted = needed.map_or("at least one argument".to_string(), |count| count_of(count, "argument"));
            return self.fail(
                Diagnostic::error("P0305", format!("`{text}` takes {wanted}, and {} given", were(values.len())))
                    .label(span, "in this call"),
            );
        }
        let last = arguments.last().map_or(span, |argument| argument.value.span);
        self.applied(name, values.into_iter().collect::<Option<Vec<_>>>()?, (span, last))
    }

    /// Whether a parameter or a result is called like the function that is applied here; which is reported.
    pub(super) fn hides(&mut self, name: &Ident) -> bool {
        let text = &name.name;
        let basic = FUNCTIONS.iter().any(|(known, _)| *known == text.as_str());
        let (what, place) = match (self.locals.get(text), self.results.get(self.result_name(text))) {
            (Some(place), _) => ("parameter", *place),
            (None, Some(place)) => ("result", *place),
            (None, None) => return false,
        };
        if basic || matches!(self.environment.quantity(text), Some(Quantity::Function { .. })) {
            self.report(
                Diagnostic::error(
                    "P0503",
                    format!("`{text}` is a {what} here, so the function `{text}` cannot be used"),
                )
                .label(name.span, "used as a function here")
                .label(place, format!("the {what}"))
                .help(format!("rename the {what}, for example to `{text}1`")),
            );
            return true;
        }
        false
    }

    /// What a function gives for these arguments, of which there are as many as it takes; the last of them stands there.
    pub(super) fn applied(&mut self, name: &Ident, values: Vec<Value>, (span, last): (Span, Span)) -> Option<Value> {
        let environment = self.environment;
        let function = match environment.quantity(&name.name) {
            Some(Quantity::Function { parameters, body }) => Some((parameters, body)),
            _ => None,
        };
        if let Some((parameters, Some(body))) = function {
            let reads = body.variables().into_iter().filter(|read| !parameters.contains(read));
            if let Some((read, place)) = reads.filter_map(|read| self.locals.get_key_value(&read)).next() {
                let (read, place, text) = (read.clone(), *place, &name.name);
                return self.fail(
                    Diagnostic::error(
                        "P0503",
                        format!("`{text}` reads the declared `{read}`, which is a parameter here"),
                    )
                    .label(span, format!("`{text}` is used here"))
                    .label(place, "the parameter")
                    .help(format!(
                        "rename the parameter, for example to `{read}1`, or give `{text}` another argument for it"
                    )),
                );
            }
        }
        let template = environment.templates.get(&name.name);
        let vectors = values.iter().any(|value| matches!(value.sort(), Sort::Vector(_)));
        if !vectors && template.is_some_and(|template| template.of_vectors) {
            return self.not_of_numbers(name, span);
        }
        if let (Some(template), true) = (template, vectors) {
            return self.read_anew(template, values);
        }
        let result = match function {
            Some((parameters, Some(body))) => {
                let images = parameters.iter().cloned().zip(values).collect::<BTreeMap<_, _>>();
                self.needs_of_body(body, &images, span);
                let known = &environment.assumptions;
                keeps_divisors(body, &images).and_then(|()| known.put_in_powers(body, &images))
            }
            Some((_, None)) => Value::apply(&name.name, &values),
            None => {
                self.needs_of(name.name.as_str(), &values, (span, last));
                basic_function(name.name.as_str(), &values)
            }
        };
        match result {
            Err(ValueError(text)) if function.is_none() && vectors => {
                let advice = "take a component, `part(d,1)`, or the length, `norm(d)`";
                self.fail(Diagnostic::error("P0402", text).label(span, "in this value").help(advice))
            }
            result => self.valid(result, span),
        }
    }

    fn plain(&mut self, argument: &Argument) -> Option<Value> {
        if let Some(label) = &argument.label {
            return self.fail(
                Diagnostic::error("P0306", "the arguments of a function have no labels")
                    .label(label.span, "leave this out, with its colon"),
            );
        }
        self.number(&argument.value)
    }

    pub(super) fn unknown_function(&mut self, name: &Ident) -> Option<Value> {
        let environment = self.environment;
        let functions = environment.quantities().filter(|(_, quantity)| matches!(quantity, Quantity::Function { .. }));
        let known = functions.map(|(known, _)| known.as_str()).chain(FUNCTIONS.iter().map(|(known, _)| *known));
        let advice = if self.locals.contains_key(&name.name) || environment.quantity(&name.name).is_some() {
            format!("`{0}` is a value; to multiply write `{0} * (…)`", name.name)
        } else {
            format!("declare it with `fn {0}(x) = …`, or `fn {0}(x)` to leave it open", name.name)
        };
        self.unknown("P0307", "function", name, known, &advice);
        None
    }
}

fn basic_function(name: &str, values: &[Value]) -> Result<Value, ValueError> {
    match (name, values) {
        ("min", values) => Value::minimum(values),
        ("max", values) => Value::maximum(values),
        ("abs", [x]) => x.abs(),
        ("norm", [x]) => x.norm(),
        ("unit", [x]) => x.unit(),
        ("floor", [x]) => x.floor(),
        ("ceil", [x]) => x.ceiling(),
        ("sqrt", [x]) => x.sqrt(),
        ("part", [x, place]) => Value::apply(&Name::new("part"), &[x.clone(), place.clone()]),
        ("mod", [x, y]) => x.sub(&y.mul(&x.div(y)?.floor()?)?),
        ("clamp", [x, low, high]) => Value::clamp(x, low, high),
        _ => Err(ValueError(format!("`{name}` cannot be computed"))),
    }
}

fn spelt(names: &[Name]) -> String {
    names.iter().map(Name::as_str).collect::<Vec<_>>().join(", ")
}

/// `no argument`, `1 argument`, `2 arguments`
pub(super) fn count_of(count: usize, what: &str) -> String {
    match count {
        0 => format!("no {what}"),
        1 => format!("1 {what}"),
        _ => format!("{count} {what}s"),
    }
}

/// `none was`, `1 was`, `2 were`
pub(super) fn were(count: usize) -> String {
    match count {
        0 => "none was".to_string(),
        1 => "1 was".to_string(),
        _ => format!("{count} were"),
    }
}

/// A name as it begins small: a metavariable with a capital stands for a process.
fn small(name: &Name) -> String {
    let mut letters = name.as_str().chars();
    letters.next().map(|first| first.to_lowercase().chain(letters).collect()).unwrap_or_default()
}
