//! Functions as they are declared: `fn s(d) = d / t`.

use std::sync::Arc;

use super::declare::{Opening, taken};
use super::flow::{functions, names};
use super::scope::{Lowerer, Metas};
use super::{Environment, Quantity, Template};
use crate::ast::{self, Header, Ident};
use crate::diagnostic::Diagnostic;
use crate::name::Name;
use crate::value::Value;

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
        let mut lowerer = Lowerer::new(self, Metas::Forbidden);
        lowerer.parameters(&header.parameters);
        let lowered = match body {
            Some(body) => lowerer.number(body).map(Some),
            None => Some(None),
        };
        let parameters: Vec<Name> = header.parameters.iter().map(|parameter| parameter.name.clone()).collect();
        let written = body.map(|body| self.template(&parameters, body));
        match lowerer.finish(lowered) {
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
        }
    }
}
