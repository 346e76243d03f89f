//! Properties as they are declared; those that say what holds of all that is shown, `(A_p | B_{p+q}) ; G where q > 1`.

use std::collections::BTreeSet;

use super::process::guard;
use super::scope::{Lowerer, Metas};
use super::{Entity, Environment, Pattern, Property};
use crate::ast::{Comparison, Either, Ident, Restriction, Term as Written, TermKind, Value as Number, ValueKind};
use crate::diagnostic::{Diagnostic, Span};
use crate::name::Name;
use crate::term::{Node, Term};
use crate::value::{Relation, Value};

/// What the names of a network stand for, over what is shown.
type Solved = Vec<(Name, Value)>;

impl Environment {
    /// A property; all processes are defined by now.
    pub(super) fn network(
        &self,
        name: &Ident,
        body: &Written,
        restriction: Option<&Restriction>,
    ) -> Result<Property, Vec<Diagnostic>> {
        let mut lowerer = Lowerer::new(self, Metas::Values);
        lowerer.own = Some(name.name.clone());
        let within = match restriction {
            Some(Restriction::Always(conditions)) => {
                let property = lowerer.always_shown(name, body, conditions);
                return lowerer.finish(property);
            }
            Some(Restriction::Within(within)) => Some(within),
            None => None,
        };
        lowerer.vectors_shown(body);
        let lowered = lowerer.whole(&[body]).and_then(|mut terms| terms.pop());
        lowerer.check_tails(body, &|called| *called == name.name);
        if let Some(within) = within {
            lowerer.drawn(&within.name, body);
        }
        if lowered.is_some() {
            lowerer.past_deadlines(body);
        }
        let latest = within.map(|within| lowerer.within(within));
        let lowered = if latest == Some(None) { None } else { lowered };
        let body = lowerer.finish(lowered)?;
        Ok(Property { name: name.name.clone(), body: Some(body), within: latest.flatten(), always: None })
    }
}

impl Lowerer<'_> {
    /// A sum of durations to be found, `Lte_{?s+?x,d}`, is a time, and none is before 0. Of guards that must hold alone: one
    /// of several ways may be there not to be taken; and of deadlines that are written as numbers: another may be varied.
    fn past_deadlines(&mut self, body: &Written) {
        let TermKind::Seq(parts) = &body.kind else { return };
        let durations: BTreeSet<Name> = parts.iter().filter_map(duration_to_be_found).collect();
        for term in parts {
            let TermKind::Apply { name, arguments, .. } = &term.kind else { continue };
            let bounds = guard(name.name.as_str()).zip(<&[Number; 2]>::try_from(arguments.as_slice()).ok());
            let Some((relation, [left, right])) = bounds else { continue };
            let (time, deadline) = match relation {
                Relation::Lss | Relation::Lte | Relation::Eq => (left, right),
                Relation::Gtr | Relation::Gte => (right, left),
                Relation::Neq => continue,
            };
            let mut named = false;
            names_in(deadline, &mut |_| named = true);
            if !named {
                self.past_deadline(&durations, time, deadline);
            }
        }
    }

    fn past_deadline(&mut self, durations: &BTreeSet<Name>, time: &Number, deadline: &Number) {
        let Some((time, latest)) = self.number(time).zip(self.number(deadline)) else { return };
        let mut known = self.environment.assumptions.clone();
        durations.iter().for_each(|name| known.assume(Relation::Gte, &Value::variable(name), &Value::zero()));
        let names = time.variables();
        let is_time = !names.is_empty() && names.is_subset(durations) && latest.variables().is_disjoint(durations);
        let zero = Value::zero();
        if is_time
            && known.decide(Relation::Gte, &time, &zero) == Some(true)
            && known.decide(Relation::Lss, &latest, &zero) == Some(true)
        {
            self.past::<()>(&latest, deadline.span);
        }
    }

    /// `P(x <= d)` speaks of a time that the property draws.
    fn drawn(&mut self, name: &Ident, body: &Written) {
        let draws = body.all().into_iter().filter_map(|term| match &term.kind {
            TermKind::Apply { name, results, .. } if name.name.as_str() == "Ran" => results.first(),
            _ => None,
        });
        let names: Vec<String> = draws.map(|result| format!("`{}`", result.name)).collect();
        if names.is_empty() || names.contains(&format!("`{}`", name.name)) {
            return;
        }
        self.report(
            Diagnostic::error("P0304", format!("nothing in the property draws `{}`", name.name))
                .label(name.span, "not drawn")
                .help(format!("the time that is drawn is called {}", names.join(" or "))),
        );
    }

    /// `(A_p | B_{p+q}) ; G where q > 1`: whenever A and B are both shown, q > 1 of what they show.
    fn always_shown(&mut self, own: &Ident, body: &Written, conditions: &[Comparison]) -> Option<Property> {
        let shown = match &body.kind {
            TermKind::Seq(parts) => match parts.as_slice() {
                [shown, again] if is_call(again, &own.name) => shown,
                _ => return self.no_network(body.span),
            },
            _ => return self.no_network(body.span),
        };
        let parts = match &shown.kind {
            TermKind::Par(parts) | TermKind::Disable(parts) => parts.as_slice(),
            _ => std::slice::from_ref(shown),
        };
        let (mut terms, mut variables, mut solved) = (Vec::new(), BTreeSet::new(), Solved::new());
        // What tells the fewest names comes first, so that those of `Rock_{p+q}` are told wherever `At_p` stands.
        let mut order: Vec<(usize, &Written)> = parts.iter().enumerate().collect();
        order.sort_by_key(|(_, part)| self.names_new_in(part));
        let mut placed = Vec::new();
        for (place, part) in order {
            if let TermKind::Apply { name, .. } = &part.kind {
                self.once(name, &terms, part.span)?;
            }
            let term = self.shown_part(part, &mut variables, &mut solved)?;
            terms.push(term.clone());
            placed.push((place, term));
        }
        placed.sort_by_key(|(place, _)| *place);
        let terms: Vec<Term> = placed.into_iter().map(|(_, term)| term).collect();
        let mut lowered = Vec::new();
        for ((relation, left, right), written) in self.compared(&terms, conditions)?.into_iter().zip(conditions) {
            let span = written.span;
            lowered.push((relation, self.put(left, &solved, span)?, self.put(right, &solved, span)?));
        }
        let call = Term::new(Node::Call(own.name.clone(), Vec::new()));
        let body = Term::seq([Term::par(terms.iter().cloned()), call]);
        let always = Some(Pattern { terms, variables, conditions: lowered });
        Some(Property { name: own.name.clone(), body: Some(body), within: None, always })
    }

    /// How many names stand in the values of an observer that nothing is known of so far.
    fn names_new_in(&self, part: &Written) -> usize {
        let TermKind::Apply { arguments, .. } = &part.kind else { return 0 };
        let new = arguments.iter().flat_map(|argument| self.new_names(argument));
        new.map(|(name, _)| name).collect::<BTreeSet<Name>>().len()
    }

    /// The names in a value that nothing is known of so far, each wherever it stands.
    fn new_names(&self, value: &Number) -> BTreeSet<(Name, Span)> {
        let mut new = BTreeSet::new();
        let known = |name: &Name| self.environment.quantity(name).is_some() || self.locals.contains_key(name);
        names_in(value, &mut |name| {
            if !name.name.is_meta() && !known(&name.name) {
                new.insert((name.name.clone(), name.span));
            }
        });
        new
    }

    fn no_network<T>(&mut self, span: Span) -> Option<T> {
        self.fail(
            Diagnostic::error("P0420", "`where` with comparisons stands behind what is shown again and again")
                .label(span, "this has another form")
                .help(
                    "write `property G = (At_p | Rock_{p+q}) ; G where q > 1`, or ask for `prove Sys always C when …`",
                ),
        )
    }

    /// One observer, or process whose instances show that they run, with a name for each value it shows.
    fn shown_part(&mut self, part: &Written, variables: &mut BTreeSet<Name>, solved: &mut Solved) -> Option<Term> {
        let TermKind::Apply { name, arguments, results } = &part.kind else { return self.no_network(part.span) };
        let arity = match self.environment.entity(&name.name) {
            Some(Entity::Observer(arity)) => *arity,
            Some(Entity::Process(signature)) => {
                if !self.environment.can_show(&name.name) {
                    return self.fail(
                        Diagnostic::error(
                            "P0421",
                            format!("it cannot be said when an instance of `{}` runs", name.name),
                        )
                        .label(name.span, "this process")
                        .help("show what it stands for by an observer: `observer Rock(q)`"),
                    );
                }
                signature.parameters.len()
            }
            _ => {
                self.named(name, "observer")?;
                return None;
            }
        };
        self.shows(name, arity, arguments.len(), results.is_empty(), part.span)?;
        let lengths = self.environment.lengths(&name.name, None);
        let mut values = Vec::new();
        for (place, argument) in arguments.iter().enumerate() {
            let length = lengths.get(place).copied().flatten();
            values.push(self.shown_value(&name.name, argument, length, variables, solved)?);
        }
        Some(Term::new(Node::Observe(name.name.clone(), values)))
    }

    /// What stands for a value that is shown: a name by itself, a value that must be shown, or a form with one new name,
    /// for which it is solved.
    fn shown_value(
        &mut self,
        shower: &Name,
        argument: &Number,
        length: Option<usize>,
        variables: &mut BTreeSet<Name>,
        solved: &mut Solved,
    ) -> Option<Value> {
        let new = self.new_names(argument);
        let fresh: BTreeSet<&Name> = new.iter().map(|(name, _)| name).collect();
        let Some(unknown) = fresh.first().map(|name| (*name).clone()) else {
            let value = self.number(argument)?;
            return self.put(value, solved, argument.span);
        };
        if fresh.len() > 1 {
            return self.fail(
                Diagnostic::error("P0422", "two names are new here, and one value tells only one of them")
                    .label(argument.span, "this value"),
            );
        }
        self.locals.extend(new.iter().cloned());
        if let Some(length) = length {
            self.shapes.insert(unknown.clone(), length);
        }
        if matches!(argument.kind, ValueKind::Name(_)) {
            variables.insert(unknown.clone());
            return Some(Value::variable(&unknown));
        }
        let written = self.number(argument)?;
        let value = self.put(written, solved, argument.span)?;
        let stands = self.unused(shower);
        variables.insert(stands.clone());
        let shown = Value::variable(&stands);
        let read = match length {
            Some(length) => self.components_of(&stands, length)?,
            None => shown.clone(),
        };
        let solution = match (value.components(), read.components()) {
            (None, None) => solved_for(&value, &unknown, &read),
            (Some(_), Some(read)) => solved_for_vector(&value, &unknown, &read),
            _ => None,
        };
        let Some(solution) = solution else {
            return self.fail(
                Diagnostic::error("P0422", format!("this cannot be solved for `{unknown}`"))
                    .label(argument.span, "this value")
                    .help("write a name by itself, or a name with a number before it and something added"),
            );
        };
        solved.push((unknown, solution));
        Some(shown)
    }

    /// A name for what something shows.
    fn unused(&mut self, shower: &Name) -> Name {
        let base = shower.as_str().to_lowercase();
        let mut name = Name::new(&base);
        let mut count = 1;
        while self.locals.contains_key(&name) || self.environment.quantity(&name).is_some() {
            count += 1;
            name = Name::new(&format!("{base}{count}"));
        }
        self.locals.insert(name.clone(), Span::default());
        name
    }

    /// A value with what has been solved for put in.
    fn put(&mut self, value: Value, solved: &Solved, span: Span) -> Option<Value> {
        let mut value = value;
        for (name, image) in solved {
            match value.with(name, image) {
                Ok(put) => value = put,
                Err(error) => return self.fail(Diagnostic::error("P0402", error.0).label(span, "in this value")),
            }
        }
        Some(value)
    }
}

/// The unknown of `Delay_{?x}`, or of `Delay_{?x} # …`.
fn duration_to_be_found(term: &Written) -> Option<Name> {
    match &term.kind {
        TermKind::Disable(parts) => parts.iter().find_map(duration_to_be_found),
        TermKind::Apply { name, arguments, .. } if name.name.as_str() == "Delay" => match arguments.as_slice() {
            [Number { kind: ValueKind::Name(name), .. }] if name.name.is_meta() => Some(name.name.clone()),
            _ => None,
        },
        _ => None,
    }
}

fn is_call(term: &Written, own: &Name) -> bool {
    matches!(&term.kind, TermKind::Apply { name, arguments, results }
        if name.name == *own && arguments.is_empty() && results.is_empty())
}

/// Every name of a value that stands in another.
pub(super) fn names_in(value: &Number, found: &mut impl FnMut(&Ident)) {
    let mut rest = vec![value];
    while let Some(value) = rest.pop() {
        match &value.kind {
            ValueKind::Number(_) => {}
            ValueKind::Name(name) => found(name),
            ValueKind::Sum(parts) | ValueKind::Product(parts) => rest.extend(parts.iter().map(|(_, part)| part)),
            ValueKind::Power(base, exponent) => rest.extend([&**base, &**exponent]),
            ValueKind::Negative(inner) | ValueKind::Absolute(inner) => rest.push(inner),
            ValueKind::If(_, parts) => rest.extend(parts.iter()),
            ValueKind::Vector(parts) => rest.extend(parts),
            ValueKind::Call(_, arguments) => rest.extend(arguments.iter().map(|argument| &argument.value)),
            ValueKind::Iterate(chain, arguments) => {
                rest.extend(chain.iter().filter_map(|(_, count)| count.as_ref()));
                rest.extend(arguments.iter().map(|argument| &argument.value));
            }
            ValueKind::Cases(cases) => {
                rest.extend(cases.iter().map(|(value, _)| value));
                let compared = cases.iter().flat_map(|(_, one)| one).flat_map(Either::comparisons);
                rest.extend(compared.flat_map(|one| [&one.left, &one.right]));
            }
        }
    }
}

/// What a name is where a form in which it has a number as factor is equal to what is shown.
fn solved_for(value: &Value, unknown: &Name, shown: &Value) -> Option<Value> {
    let (factor, rest) = value.linear_in(unknown)?;
    factor.as_rational()?;
    shown.sub(&rest).and_then(|left| left.div(&factor)).ok()
}

/// The same of a vector, component by component.
fn solved_for_vector(value: &Value, unknown: &Name, shown: &[Value]) -> Option<Value> {
    let names: Vec<Name> = (1..=shown.len()).map(|place| Name::new(&format!("[{unknown} {place}]"))).collect();
    let spread = Value::vector(names.iter().map(Value::variable).collect()).ok()?;
    let parts = value.with(unknown, &spread).ok()?.components()?;
    let each = parts.iter().zip(&names).zip(shown).map(|((part, name), shown)| {
        let other = |other: &Name| other != name && part.mentions(other);
        if names.iter().any(other) { None } else { solved_for(part, name, shown) }
    });
    let solution = Value::vector(each.collect::<Option<Vec<_>>>()?).ok()?;
    (parts.len() == shown.len()).then_some(solution)
}
