//! Items: declarations, commands, expectations, imports.

use std::sync::Arc;

use super::{Parse, Parser, Role};
use crate::ast::{Expect, Header, Ident, Item, ItemKind, Parameter, Term};
use crate::diagnostic::{Diagnostic, Span};
use crate::lexer::{Keyword, Kind};
use crate::name::Name;

fn as_command(diagnostic: Diagnostic, text: &str, span: Span) -> Diagnostic {
    diagnostic.edit(format!("at the prompt and on standard input `:{text}` is a command"), span, format!(":{text}"))
}

/// Commands of the prompt that may be typed where an item is expected.
const COMMANDS: [&str; 9] = ["step", "why", "show", "undo", "load", "save", "help", "quit", "lint"];

/// The word that begins an item and is spelled nearly so.
fn begins_item_like(text: &str) -> Option<&'static str> {
    let words = Keyword::ALL.iter().map(|(_, word)| *word);
    crate::diagnostic::nearest(text, words.filter(|word| Keyword::of(word).is_some_and(Keyword::begins_item)))
}

impl Parser<'_> {
    /// The next item, up to where another one begins.
    pub(super) fn item(&mut self) -> Parse<Item> {
        let start = self.token().span.start;
        let kind = match self.kind() {
            Kind::Word(keyword) if self.at_item() => {
                self.take(Role::Item);
                self.item_kind(keyword)?
            }
            _ if self.prompt && self.begins_term() => ItemKind::Simplify(self.alone()?),
            _ => return self.no_item(),
        };
        if !self.at(Kind::End) && !self.at_item() {
            let over = self.left_over(&kind);
            // What is declared is known, whatever stands behind it.
            return if matches!(kind, ItemKind::Param(_)) { self.kept(start, kind) } else { over };
        }
        Ok(Item { span: self.since(start), kind })
    }

    /// An item that was complete, without what follows it up to the next.
    fn kept(&mut self, start: usize, kind: ItemKind) -> Parse<Item> {
        let span = self.since(start);
        self.recover(self.position);
        Ok(Item { span, kind })
    }

    fn item_kind(&mut self, keyword: Keyword) -> Parse<ItemKind> {
        Ok(match keyword {
            Keyword::Param => ItemKind::Param(self.parameters()?),
            Keyword::Fn => self.function()?,
            Keyword::Proc => {
                let header = self.header("the name of a process")?;
                self.require(Kind::Equal, "`=` and a process")?;
                ItemKind::Process(header, self.term()?)
            }
            Keyword::Observer => ItemKind::Observer(self.observers()?),
            Keyword::System => {
                let (name, body) = self.named_term("the name of a system")?;
                ItemKind::System(name, body)
            }
            Keyword::Property => {
                let (name, body) = self.named_term("the name of a property")?;
                ItemKind::Property(name, body, self.restriction()?)
            }
            Keyword::Prove => ItemKind::Prove(self.claim()?),
            Keyword::Simplify => ItemKind::Simplify(self.term()?),
            Keyword::Period => ItemKind::Period(self.capital("the name of a system")?),
            Keyword::Flow => ItemKind::Flow(self.capital("the name of a system")?),
            Keyword::Solve => ItemKind::Solve(Box::new(self.solve()?)),
            Keyword::Project => {
                let term = self.chain()?;
                self.require(Kind::Word(Keyword::To), "`to` and the observers to keep, as in `project Sys to {At}`")?;
                ItemKind::Project(term, self.shown()?)
            }
            Keyword::Lts => {
                let term = self.term()?;
                ItemKind::Lts(term, self.limits()?)
            }
            Keyword::Minimise => {
                let term = self.term()?;
                ItemKind::Minimise(term, self.limits()?)
            }
            Keyword::Compare => self.alike()?,
            Keyword::Expect => ItemKind::Expect(self.expectation()?),
            Keyword::Import => {
                let text = self.require(Kind::Text, "the name of a file in quotes")?.span.of(self.text);
                ItemKind::Import(text.trim_matches('"').to_string())
            }
            Keyword::Law => ItemKind::Law(Box::new(self.law()?)),
            Keyword::Exercise => ItemKind::Exercise(Box::new(self.exercise()?)),
            Keyword::Probability => ItemKind::Probability(self.likelihood(None)?),
            Keyword::Criteria => ItemKind::Criteria(Arc::new(self.criteria()?)),
            Keyword::Sweep => ItemKind::Sweep(Arc::new(self.sweep()?)),
            _ => return self.no_item(),
        })
    }

    pub(super) fn begins_term(&self) -> bool {
        matches!(
            self.kind(),
            Kind::Upper | Kind::Meta | Kind::OpenRound | Kind::Word(Keyword::Try | Keyword::Loop | Keyword::New)
        )
    }

    /// A term alone at the prompt.
    fn alone(&mut self) -> Parse<Term> {
        let start = self.token().span.start;
        self.mark_item();
        let term = self.term()?;
        if matches!(self.kind(), Kind::Equal | Kind::LessEqual | Kind::Weak | Kind::LessWeak) {
            let diagnostic = self.wrong("an operator or the end").note("a term alone asks to simplify it");
            return self.fail(diagnostic.edit(
                "to claim that both sides are equal, begin with `prove`",
                Span::new(start, start),
                "prove ",
            ));
        }
        Ok(term)
    }

    fn mark_item(&mut self) {
        if let Some(role) = self.roles.get_mut(self.position) {
            *role = Role::Item;
        }
    }

    fn no_item<T>(&mut self) -> Parse<T> {
        let text = self.spelling().to_string();
        let near = begins_item_like(&text);
        let span = self.token().span;
        let diagnostic = self.wrong("an item");
        let diagnostic = match near {
            _ if COMMANDS.contains(&text.as_str()) => as_command(diagnostic, &text, span),
            Some(word) => diagnostic.edit(format!("did you mean `{word}`?"), span, word),
            None if self.begins_term() => {
                diagnostic.help("to simplify a process write `simplify P`; to define one, `proc Name = P`")
            }
            None => diagnostic
                .help("an item begins with a word such as `param`, `fn`, `proc`, `system`, `property` or `prove`"),
        };
        self.fail(diagnostic)
    }

    /// Reports what follows an item that was complete.
    fn left_over<T>(&mut self, kind: &ItemKind) -> Parse<T> {
        let diagnostic = self.wrong("an operator or the next item");
        let text = self.spelling();
        let diagnostic = match self.kind() {
            _ if COMMANDS.contains(&text) => as_command(diagnostic, text, self.token().span),
            Kind::CloseRound | Kind::CloseCurly | Kind::CloseSquare => {
                diagnostic.note("no bracket of this kind is open here")
            }
            Kind::Comma if !matches!(kind, ItemKind::Param(_)) => {
                diagnostic.help("several parameters after `_` need braces: `Out_{v,s(g-r)}`")
            }
            Kind::Less => diagnostic.note("`<` gives names to results, directly behind a process: `In_p<r>`"),
            Kind::Upper | Kind::Meta | Kind::OpenRound => {
                diagnostic.help("two processes need an operator between them: `P ; Q`, `P | Q` or `P # Q`")
            }
            Kind::Colon => diagnostic.note(
                "commands such as `:why` are answered at the prompt, and in what `pars` reads from standard input",
            ),
            Kind::Lower if self.defines() => {
                let span = Span::new(self.token().span.start, self.token().span.start);
                diagnostic.edit("to define a function begin with `fn`", span, "fn ")
            }
            Kind::Word(Keyword::When) => diagnostic.note("`when` belongs behind both sides of a claim"),
            Kind::Lower if text == "where" && matches!(kind, ItemKind::Probability(_)) => {
                diagnostic.help("`where` stands before the time: `reaching At_p where p > 2 within 5`")
            }
            Kind::Lower if text == "where" => diagnostic.note(
                "`where` belongs to a property or a law; what is known of parameters is declared before: `param v = 1, t > 0`",
            ),
            Kind::Lower if ["assume", "given", "let", "const"].contains(&text) => {
                diagnostic.edit("what is known of parameters is declared", self.token().span, "param")
            }
            Kind::Lower => match begins_item_like(text) {
                Some(word) => diagnostic.edit(format!("did you mean `{word}`?"), self.token().span, word),
                None => diagnostic,
            },
            _ => diagnostic,
        };
        self.fail(diagnostic)
    }

    /// Whether `s(d) =` stands here, or `s(d, e) =`.
    fn defines(&self) -> bool {
        let mut place = 2;
        while matches!(self.ahead(place).kind, Kind::Lower | Kind::Comma) {
            place += 1;
        }
        let brackets = self.ahead(1).kind == Kind::OpenRound && self.ahead(place).kind == Kind::CloseRound;
        brackets && self.ahead(place + 1).kind == Kind::Equal
    }

    pub(super) fn capital(&mut self, what: &str) -> Parse<Ident> {
        match self.kind() {
            Kind::Upper => Ok(self.ident()),
            Kind::Lower => {
                let text = self.spelling().to_string();
                let span = self.token().span;
                let diagnostic = self
                    .wrong(what)
                    .note("names of processes, observers, systems and properties begin with a capital letter");
                let first: String = text.chars().next().map_or(String::new(), |letter| letter.to_uppercase().collect());
                let rest: String = text.chars().skip(1).filter(|letter| *letter != '_').collect();
                self.fail(diagnostic.edit("with a capital", span, format!("{first}{rest}")))
            }
            _ => self.unexpected(what),
        }
    }

    /// `BF_{a,b}<x>`, `At(r)`, `MoveTo_g`
    fn header(&mut self, what: &str) -> Parse<Header> {
        let name = self.capital(what)?;
        let parameters = self.header_parameters()?;
        let results = self.results()?;
        Ok(Header { name, parameters, results })
    }

    fn observers(&mut self) -> Parse<Vec<Header>> {
        let mut all = vec![self.header("the name of an observer")?];
        while self.accept(Kind::Comma) {
            all.push(self.header("the name of an observer")?);
        }
        Ok(all)
    }

    fn header_parameters(&mut self) -> Parse<Vec<Ident>> {
        let parameter = |parser: &mut Self| {
            if parser.at(Kind::Upper) { Ok(parser.ident()) } else { parser.small("the name of a parameter") }
        };
        if self.at(Kind::OpenRound) {
            self.take(Role::Joining);
            return self.list(Kind::CloseRound, "`,` or `)`", parameter);
        }
        if !self.at(Kind::Underscore) {
            return Ok(Vec::new());
        }
        self.take(Role::Joining);
        if self.at(Kind::OpenCurly) {
            self.take(Role::Joining);
            return self.list(Kind::CloseCurly, "`,` or `}`", parameter);
        }
        Ok(vec![parameter(self)?])
    }

    fn function(&mut self) -> Parse<ItemKind> {
        let name = self.small("the name of a function")?;
        let parameters = self.header_parameters()?;
        let header = Header { name, parameters, results: Vec::new() };
        let body = if self.accept(Kind::Equal) { Some(self.value()?) } else { None };
        Ok(ItemKind::Function(header, body))
    }

    fn named_term(&mut self, what: &str) -> Parse<(Ident, Term)> {
        let name = self.capital(what)?;
        self.require(Kind::Equal, "`=` and a process")?;
        Ok((name, self.term()?))
    }

    pub(super) fn parameters(&mut self) -> Parse<Vec<Parameter>> {
        let mut all = vec![self.parameter()?];
        while self.accept(Kind::Comma) {
            all.push(self.parameter()?);
        }
        Ok(all)
    }

    fn parameter(&mut self) -> Parse<Parameter> {
        let next = self.ahead(1).kind;
        if let Some(word) = ["and", "or", "not"].into_iter().find(|word| self.at_spelling(word)) {
            let text = format!("`{word}` cannot be the name of a parameter");
            let wrong = Diagnostic::error("P0201", text).label(self.token().span, "a word of conditions");
            return self.fail(wrong.help("give it another name: in a condition it would be read as that word"));
        }
        if matches!(self.kind(), Kind::Lower | Kind::Upper) {
            if next == Kind::Colon {
                let name = self.ident();
                self.advance();
                if !self.at(Kind::Lower) {
                    return self.unexpected("a sort: `natural`, `real`, `vector` or `distribution`");
                }
                return Ok(Parameter::Sorted(name, self.ident()));
            }
            let sorted = next == Kind::Lower && self.spelling() == "natural";
            if sorted {
                let name = self.ahead(1).span.of(self.text).to_string();
                let span = self.token().span.to(self.ahead(1).span);
                let diagnostic =
                    Diagnostic::error("P0201", "the sort of a parameter stands behind it").label(span, "here");
                return self.fail(diagnostic.edit("write it so", span, format!("{name} : natural")));
            }
            if next == Kind::Comma || next == Kind::End || !continues_value(next) {
                return Ok(Parameter::Plain(self.ident()));
            }
        }
        let left = self.value()?;
        let Some(relation) = self.relation() else {
            return self.unexpected("a comparison such as `> 0`, or `,`");
        };
        let right = self.value()?;
        if matches!(self.kind(), Kind::Less | Kind::LessEqual | Kind::Greater | Kind::GreaterEqual) {
            let diagnostic = self.wrong("`,` or the next item").help("write two comparisons: `0 <= a, a <= b`");
            return self.fail(diagnostic);
        }
        Ok(Parameter::Assumed(relation, left, right))
    }

    fn expectation(&mut self) -> Parse<Expect> {
        if self.accept(Kind::Equal) {
            return Ok(Expect::Term(self.term()?));
        }
        let verdict =
            matches!(self.spelling(), "proved" | "refuted" | "open" | "yes" | "no" | "unknown" | "never" | "met")
                && self.ahead(1).kind != Kind::Equal;
        if verdict {
            return Ok(Expect::Verdict(self.ident()));
        }
        if self.spelling() == "not" && self.ahead(1).span.of(self.text) == "met" {
            let span = self.advance().span.to(self.advance().span);
            return Ok(Expect::Verdict(Ident { name: Name::new("not met"), span }));
        }
        let mut values = Vec::new();
        loop {
            // Sequences of `solve` may begin with a capital.
            let capital = self.at(Kind::Upper) && matches!(self.ahead(1).kind, Kind::OpenRound | Kind::Equal);
            let name = if capital {
                Ok(self.ident())
            } else {
                self.small(
                "`proved`, `refuted`, `open`, `met`, `not met`, `yes`, `no`, `unknown`, `never`, `= P`, or a value such as `t1 = 10`",
            )
            }?;
            let name = if self.at(Kind::OpenRound) { self.term_of(name)? } else { name };
            self.require(Kind::Equal, "`=` and a value")?;
            values.push((name, self.value()?));
            if !self.accept(Kind::Comma) {
                return Ok(Expect::Values(values));
            }
        }
    }
}

/// Whether a value that began with a name may go on with this token.
fn continues_value(kind: Kind) -> bool {
    let operator = matches!(kind, Kind::Plus | Kind::Minus | Kind::Star | Kind::Slash | Kind::Caret | Kind::OpenRound);
    operator
        || matches!(
            kind,
            Kind::Less | Kind::LessEqual | Kind::Greater | Kind::GreaterEqual | Kind::Equal | Kind::NotEqual
        )
}
