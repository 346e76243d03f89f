//! Questions about transition systems: `lts P`, `minimise P`, `compare P ~ Q weak bound 1000`.

use super::{Parse, Parser};
use crate::ast::{ItemKind, Limits};
use crate::diagnostic::{Diagnostic, nearest};
use crate::lexer::Kind;
use crate::preorder::Preorder;

impl Parser<'_> {
    /// `P ~ Q [relation] [bound n] [memory n]`
    pub(super) fn alike(&mut self) -> Parse<ItemKind> {
        let left = self.term()?;
        self.require(Kind::Tilde, "`~` and the process to compare with")?;
        let right = self.term()?;
        let relation = if self.at(Kind::Lower) && !self.at_limit() { self.relation_name()? } else { Preorder::Strong };
        Ok(ItemKind::Alike(left, right, relation, self.limits()?))
    }

    fn relation_name(&mut self) -> Parse<Preorder> {
        let found = self.dashed();
        if let Some(relation) = Preorder::of(found.name.as_str()) {
            return Ok(relation);
        }
        let names: Vec<&str> = Preorder::ALL.iter().map(|(_, name)| *name).collect();
        let diagnostic = Diagnostic::error("P0220", format!("there is no relation `{}`", found.name))
            .label(found.span, "this relation")
            .note(format!("the relations are {}", names.join(", ")));
        match nearest(found.name.as_str(), names) {
            Some(near) => self.fail(diagnostic.edit(format!("did you mean `{near}`?"), found.span, near)),
            None => self.fail(diagnostic),
        }
    }

    fn at_limit(&self) -> bool {
        matches!(self.spelling(), "bound" | "memory")
    }

    /// `bound n`, `memory n`, in any order.
    pub(super) fn limits(&mut self) -> Parse<Limits> {
        let mut limits = Limits::default();
        while self.at(Kind::Lower) && self.at_limit() {
            let states = self.spelling() == "bound";
            self.advance();
            let what = if states { "a number of states" } else { "a number of MiB" };
            let number = self.spelling().parse::<usize>().ok().filter(|number| *number > 0);
            let Some(number) = number.filter(|_| self.at(Kind::Number)) else { return self.unexpected(what) };
            self.advance();
            let slot = if states { &mut limits.states } else { &mut limits.memory };
            *slot = Some(number);
        }
        Ok(limits)
    }
}
