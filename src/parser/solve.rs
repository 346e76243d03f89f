//! `solve r(n+1) = 2*r(n) + 3, r(0) = 1 find n with r(n) >= 100`

use super::{Parse, Parser, Role, UNEXPECTED};
use crate::ast::{Find, Ident, Solve};
use crate::diagnostic::Diagnostic;
use crate::lexer::Kind;
use crate::name::Name;

impl Parser<'_> {
    pub(super) fn solve(&mut self) -> Parse<Solve> {
        let mut equations = Vec::new();
        let mut comma = None;
        loop {
            let asks = self.at_spelling("find");
            let left = self.value()?;
            if let (Some(span), true, true) = (comma, asks, self.at(Kind::Lower)) {
                let wrong = Diagnostic::error(UNEXPECTED, "no comma stands before `find`");
                return self.fail(wrong.label(span, "unexpected").edit("leave it out", span, ""));
            }
            self.require(Kind::Equal, "`=` and the next term or the first value")?;
            equations.push((left, self.value()?));
            comma = Some(self.token().span);
            if !self.accept(Kind::Comma) {
                break;
            }
        }
        let find = if self.at_spelling("find") { Some(self.find()?) } else { None };
        Ok(Solve { equations, find })
    }

    fn find(&mut self) -> Parse<Find> {
        self.advance();
        let index = self.small("the name of the index, as in `find n with r(n) = 10`")?;
        if !self.at_spelling("with") {
            return self.unexpected("`with` and a comparison, as in `find n with r(n) = 10`");
        }
        self.advance();
        let either = self.either()?;
        if self.at(Kind::Comma) {
            let wrong = self.wrong("`and`, `or` or the next item");
            return self.fail(wrong.help("join comparisons by `and`: `find n with x(n) >= 3 and y(n) < 5`"));
        }
        Ok(Find { index, either })
    }

    /// `r(10)`, a term of a sequence, as a name; or `r(n)`, all of them; or `f(r,k)`, a flow function.
    pub(super) fn term_of(&mut self, name: Ident) -> Parse<Ident> {
        self.take(Role::Joining);
        if self.at(Kind::Lower) {
            self.advance();
            while self.accept(Kind::Comma) {
                self.small("a variable of the phase")?;
            }
        } else {
            if self.at(Kind::Minus) {
                self.take(Role::Opening);
            }
            self.require(Kind::Number, "the index of a term, a whole number or the index of the equations")?;
        }
        self.require(Kind::CloseRound, "`)`")?;
        let span = self.since(name.span.start);
        let text: String = span.of(self.text).chars().filter(|letter| !letter.is_whitespace()).collect();
        Ok(Ident { name: Name::new(&text), span })
    }
}
