//! Functions as they are declared: `fn s(d) = d / t`.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::declare::{Opening, taken};
use super::flow::{functions, names};
use super::scope::{Lowerer, Metas};
use super::{Environment, Quantity, Template};
use crate::ast::{self, Header, Ident};
use crate::diagnostic::{Diagnostic, Span};
use crate::name::Name;
use crate::value::Value;

/// The most parameters of a function of which some are tried as vectors.
const MOST_VECTORS: usize = 5;
/// The longest vector that is tried for a parameter.
const LONGEST: usize = 6;

impl Lowerer<'_> {
    /// What a name stands for in the whole text, where no name in it is bound to something else here.
    pub(super) fn constant(&mut self, ident: &Ident, value: Value) -> Option<Value> {
        let Some(other) = value.variables().into_iter().find(|name| self.locals.contains_key(name)) else {
            return Some(value);
        };
        self.fail(
            Diagnostic::error(
                "P0507",
                format!("`{}` stands for {value}, and `{other}` is another thing here", ident.name),
            )
            .label(ident.span, format!("would be read as what `{other}` is here"))
            .help(format!("give the `{other}` of this definition another name")),
        )
    }

    /// Reports that a function of vectors is given none.
    pub(super) fn not_of_numbers(&mut self, name: &Ident, span: Span) -> Option<Value> {
        self.fail(
            Diagnostic::error("P0402", format!("`{}` has no value for numbers", name.name))
                .label(span, "no vector is given")
                .help(format!("give it a vector: `{}((x,y))`", name.name)),
        )
    }
}

impl Environment {
    /// Takes in a function; what is wrong with it is noted.
    pub(super) fn declare_function(
        &mut self,
        opening: &mut Opening<'_>,
        index: usize,
        header: &Header,
        body: Option<&ast::Value>,
    ) {
        if opening.is_twice(index) {
            return;
        }
        if matches!(self.quantity(&header.name.name), Some(Quantity::Parameter { .. })) {
            opening.report(index, [taken(&header.name, "a parameter")]);
            return;
        }
        let parameters: Vec<Name> = header.parameters.iter().map(|parameter| parameter.name.clone()).collect();
        let mut lowered = self.body(header, body, &BTreeMap::new());
        // No other error goes away with vectors.
        let sorts = |errors: &[Diagnostic]| errors.iter().all(|error| error.code == "P0402");
        let of_vectors =
            lowered.as_ref().is_err_and(|errors| sorts(errors)).then(|| self.of_vectors(header, body)).flatten();
        let written =
            body.map(|body| Template { of_vectors: of_vectors.is_some(), ..self.template(&parameters, body) });
        if let Some(body) = of_vectors {
            lowered = Ok(Some(body));
        }
        match lowered {
            Ok(body) => {
                let templates = Arc::make_mut(&mut self.templates);
                match written {
                    Some(written) => templates.insert(header.name.name.clone(), written),
                    None => templates.remove(&header.name.name),
                };
                Arc::make_mut(&mut self.quantities)
                    .insert(header.name.name.clone(), Quantity::Function { parameters, body });
            }
            Err(errors) => opening.report(index, errors),
        }
    }

    /// What a function gives, in normal form, where these parameters are vectors of so many components.
    ///
    /// # Errors
    /// What is wrong with it then.
    fn body(
        &self,
        header: &Header,
        body: Option<&ast::Value>,
        vectors: &BTreeMap<Name, usize>,
    ) -> Result<Option<Value>, Vec<Diagnostic>> {
        let mut lowerer = Lowerer::new(self, Metas::Forbidden);
        lowerer.parameters(&header.parameters);
        for (name, length) in vectors {
            if let Some(vector) = lowerer.components_of(name, *length) {
                lowerer.images.insert(name.clone(), vector);
            }
        }
        let lowered = match body {
            Some(body) => lowerer.number(body).map(Some),
            None => Some(None),
        };
        lowerer.finish(lowered)
    }

    /// The body of a function that has no value for numbers, `r + (1,0)`, with as few of its parameters vectors as give it
    /// one.
    fn of_vectors(&self, header: &Header, body: Option<&ast::Value>) -> Option<Value> {
        let count = header.parameters.len();
        if count > MOST_VECTORS {
            return None;
        }
        let mut choices: Vec<usize> = (1..1 << count).collect();
        choices.sort_by_key(|choice: &usize| choice.count_ones());
        let lengths = choices.into_iter().flat_map(|choice| (2..=LONGEST).map(move |length| (choice, length)));
        lengths.into_iter().find_map(|(choice, length)| {
            let chosen = header.parameters.iter().enumerate().filter(|(place, _)| choice >> place & 1 == 1);
            let vectors = chosen.map(|(_, parameter)| (parameter.name.clone(), length)).collect();
            self.body(header, body, &vectors).ok().flatten()
        })
    }

    /// A function as written, with what those names mean now that stand in it.
    fn template(&self, parameters: &[Name], body: &ast::Value) -> Template {
        let mut written = Vec::new();
        names(body, &mut written);
        functions(body, &mut written);
        let known = |ident: &&Ident| Some((ident.name.clone(), self.quantity(&ident.name)?.clone()));
        let called = |ident: &&Ident| Some((ident.name.clone(), self.templates.get(&ident.name)?.clone()));
        Template {
            parameters: parameters.to_vec(),
            body: Arc::new(body.clone()),
            quantities: Arc::new(written.iter().filter_map(known).collect()),
            templates: Arc::new(written.iter().filter_map(called).collect()),
            of_vectors: false,
        }
    }
}
