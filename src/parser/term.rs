//! Processes: `^` and `new c.` bind tightest, then `;`, then `else`, then `|`; `#` stands alone; `to` is weakest.

use super::{Parse, Parser, Role};
use crate::ast::{Ident, Term, TermKind, Value, ValueKind};
use crate::diagnostic::{Diagnostic, Span};
use crate::lexer::{Keyword, Kind};

impl Parser<'_> {
    /// A process, with the projections behind it.
    pub(super) fn term(&mut self) -> Parse<Term> {
        let before = self.depth;
        let mut term = self.chain()?;
        while self.at_word(Keyword::To) {
            self.deeper(1)?;
            self.advance();
            let shown = self.shown()?;
            let span = self.since(term.span.start);
            term = Term { span, kind: TermKind::Project(Box::new(term), shown) };
        }
        self.depth = before;
        Ok(term)
    }

    /// `{Delay, At}`: the observers that stay.
    pub(super) fn shown(&mut self) -> Parse<Vec<Ident>> {
        self.require(Kind::OpenCurly, "`{`, and the names of the observers to keep")?;
        self.list(Kind::CloseCurly, "`,` or `}`", |parser| {
            let named = matches!(parser.kind(), Kind::Upper | Kind::Meta);
            if named { Ok(parser.ident()) } else { parser.unexpected("the name of an observer") }
        })
    }

    fn at_operator(&self) -> bool {
        matches!(self.kind(), Kind::Semicolon | Kind::Bar | Kind::Hash | Kind::Word(Keyword::Else))
    }

    /// Processes joined by operators.
    pub(super) fn chain(&mut self) -> Parse<Term> {
        let first = self.postfix()?;
        if !self.at_operator() {
            return Ok(first);
        }
        let mut operands = vec![first];
        let mut operators: Vec<(Kind, Span)> = Vec::new();
        loop {
            let kind = self.kind();
            if !self.at_operator() {
                break;
            }
            let span = self.advance().span;
            if operators.last().is_some_and(|(last, _)| (*last == Kind::Hash) != (kind == Kind::Hash)) {
                // Needed for the error: the second reading takes in the operand that follows.
                operands.push(self.postfix()?);
                return self.mixed(&operands, &operators, (kind, span));
            }
            operators.push((kind, span));
            operands.push(self.postfix()?);
        }
        self.grouped(operands, &operators)
    }

    /// Reports `#` next to another operator without brackets, with both readings.
    fn mixed(&mut self, operands: &[Term], operators: &[(Kind, Span)], second: (Kind, Span)) -> Parse<Term> {
        let text = self.text;
        let show = |term: Option<&Term>| term.map_or(String::new(), |term| super::excerpt(term.span.of(text)));
        let count = operands.len();
        let one = show(count.checked_sub(3).and_then(|index| operands.get(index)));
        let two = show(count.checked_sub(2).and_then(|index| operands.get(index)));
        let three = show(operands.last());
        let first = operators.last().map_or(second.1, |(_, span)| *span);
        let (left, right) = (first.of(text), second.1.of(text));
        self.fail(
            Diagnostic::error("P0203", format!("`{left}` and `{right}` stand side by side without brackets"))
                .label(second.1, format!("`{right}` here"))
                .label(first, format!("`{left}` here"))
                .note("`#` never mixes with `;`, `|` or `else`: the two readings differ")
                .help(format!(
                    "write `({one} {left} {two}) {right} {three}` or `{one} {left} ({two} {right} {three})`"
                )),
        )
    }

    /// The operands under their operators, by precedence.
    fn grouped(&mut self, operands: Vec<Term>, operators: &[(Kind, Span)]) -> Parse<Term> {
        if operators.first().is_some_and(|(kind, _)| *kind == Kind::Hash) {
            return Ok(many(operands, TermKind::Disable));
        }
        let mut branches = Vec::new();
        let mut arms: Vec<Term> = Vec::new();
        let mut steps: Vec<Term> = Vec::new();
        let mut kinds = operators.iter().map(|(kind, _)| *kind);
        for operand in operands {
            steps.push(operand);
            let kind = kinds.next().unwrap_or(Kind::Bar);
            if kind != Kind::Semicolon {
                arms.push(many(std::mem::take(&mut steps), TermKind::Seq));
            }
            if kind == Kind::Bar {
                branches.push(self.alternatives(std::mem::take(&mut arms))?);
            }
        }
        Ok(many(branches, TermKind::Par))
    }

    /// `P else Q else R`, which is `P else (Q else R)`.
    fn alternatives(&mut self, mut arms: Vec<Term>) -> Parse<Term> {
        let before = self.depth;
        self.deep_arms(&arms)?;
        self.depth = before;
        let last = arms.pop();
        let whole = arms.into_iter().rev().fold(last, |rest, arm| match rest {
            Some(rest) => {
                let span = arm.span.to(rest.span);
                Some(Term { span, kind: TermKind::Else(Box::new(arm), Box::new(rest)) })
            }
            None => Some(arm),
        });
        match whole {
            Some(term) => Ok(term),
            None => self.unexpected("a process"),
        }
    }

    /// Reports arms that nest too deep, at the first that does.
    fn deep_arms(&mut self, arms: &[Term]) -> Parse<()> {
        let room = super::DEEPEST.saturating_sub(self.depth);
        match arms.get(room + 1) {
            Some(arm) => self.too_deep(arm.span),
            None => self.deeper(arms.len().saturating_sub(1)),
        }
    }

    /// A process with the powers and replacements behind it.
    fn postfix(&mut self) -> Parse<Term> {
        let before = self.depth;
        let mut term = self.atom()?;
        loop {
            let start = term.span.start;
            if self.at(Kind::Caret) {
                self.deeper(1)?;
                self.take(Role::Joining);
                let (count, index) = self.count()?;
                term = Term { span: self.since(start), kind: TermKind::Power(Box::new(term), count, index) };
            } else if self.at(Kind::OpenSquare) {
                self.deeper(1)?;
                self.take(Role::Joining);
                let name = self.small("the name to be replaced")?;
                self.require(Kind::Assign, "`:=`")?;
                let value = self.value()?;
                self.require(Kind::CloseSquare, "`]`")?;
                term = Term { span: self.since(start), kind: TermKind::Replace(Box::new(term), name, value) };
            } else {
                break;
            }
        }
        self.depth = before;
        Ok(term)
    }

    /// What follows `^`: `3`, `n`, `?n`, `(n+1)`, `{n+1}`, `{i<n}`.
    fn count(&mut self) -> Parse<(Value, Option<Ident>)> {
        match self.kind() {
            Kind::OpenCurly => {
                self.advance();
                let indexed = matches!(self.kind(), Kind::Lower | Kind::Meta) && self.ahead(1).kind == Kind::Less;
                let index = if indexed { Some(self.ident()) } else { None };
                if indexed {
                    self.advance();
                }
                let value = self.value()?;
                self.require(Kind::CloseCurly, "an operator or `}`")?;
                Ok((value, index))
            }
            Kind::OpenRound => Ok((self.primary()?, None)),
            Kind::Number | Kind::Lower | Kind::Upper | Kind::Meta => Ok((self.single()?, None)),
            _ => self.unexpected("a number of rounds, such as `3`, `n` or `{n+1}`"),
        }
    }

    /// One name or number, without anything behind it.
    pub(super) fn single(&mut self) -> Parse<Value> {
        if self.at(Kind::Number) || self.at(Kind::Meta) {
            return self.primary();
        }
        let name = self.ident();
        Ok(Value { span: name.span, kind: ValueKind::Name(name) })
    }

    /// A name that begins small, or a metavariable for one.
    pub(super) fn small(&mut self, what: &str) -> Parse<Ident> {
        match self.kind() {
            Kind::Lower => Ok(self.ident()),
            Kind::Meta if !self.spelling().chars().nth(1).is_some_and(char::is_uppercase) => Ok(self.ident()),
            Kind::Upper => {
                let text = self.spelling().to_string();
                let span = self.token().span;
                let diagnostic = self.wrong(what).note("names of values, ports and results begin small");
                let (first, rest) = text.split_at(text.chars().next().map_or(0, char::len_utf8));
                self.fail(diagnostic.edit("write it small", span, format!("{}{rest}", first.to_lowercase())))
            }
            Kind::Word(keyword) => {
                let word = keyword.spelling();
                let diagnostic = self.wrong(what);
                self.fail(diagnostic.note(format!("`{word}` is a word of the language, so nothing can have this name")))
            }
            _ => self.unexpected(what),
        }
    }

    pub(super) fn atom(&mut self) -> Parse<Term> {
        let start = self.token().span.start;
        match self.kind() {
            Kind::OpenRound => {
                self.advance();
                let inner = self.nested(Parser::term)?;
                self.require(Kind::CloseRound, "an operator or `)`")?;
                Ok(Term { span: self.since(start), ..inner })
            }
            Kind::Word(Keyword::Try) => self.wrapped(TermKind::Try),
            Kind::Word(Keyword::Loop) => self.wrapped(TermKind::Loop),
            Kind::Word(Keyword::New) => {
                self.advance();
                let port = self.small("the name of a port")?;
                if !self.at(Kind::Dot) {
                    return self.unexpected("`.` and a process, as in `new c. P`");
                }
                self.take(Role::Closing);
                let body = self.nested(Parser::postfix)?;
                Ok(Term { span: self.since(start), kind: TermKind::New(port, Box::new(body)) })
            }
            Kind::Upper => self.application(),
            Kind::Meta if self.spelling().chars().nth(1).is_some_and(char::is_uppercase) => {
                let name = self.ident();
                let arguments = self.arguments()?;
                Ok(Term { span: self.since(start), kind: TermKind::Meta(name, arguments) })
            }
            Kind::Meta | Kind::Lower => self.not_a_process(),
            _ => self.unexpected("a process"),
        }
    }

    /// `try(P)`, `loop(P)`
    fn wrapped(&mut self, kind: fn(Box<Term>) -> TermKind) -> Parse<Term> {
        let word = self.spelling();
        let start = self.advance().span.start;
        if !self.at(Kind::OpenRound) {
            let diagnostic = self.wrong("`(`").help(format!("put the process in brackets: `{word}(P)`"));
            return self.fail(diagnostic);
        }
        self.take(Role::Joining);
        let inner = self.nested(Parser::term)?;
        self.require(Kind::CloseRound, "an operator or `)`")?;
        Ok(Term { span: self.since(start), kind: kind(Box::new(inner)) })
    }

    fn not_a_process(&mut self) -> Parse<Term> {
        let text = self.spelling().to_string();
        let span = self.token().span;
        let skip = if text.starts_with('?') { 1 } else { 0 };
        let first = text.chars().nth(skip).map_or(String::new(), |letter| letter.to_uppercase().collect());
        let rest: String = text.chars().skip(skip + 1).collect();
        let capital = format!("{}{first}{rest}", if skip == 1 { "?" } else { "" });
        let diagnostic =
            self.wrong("a process").note("names of processes begin with a capital letter, names of values begin small");
        let guard = match self.ahead(1).kind {
            Kind::Equal => Some("Eq"),
            Kind::NotEqual => Some("Neq"),
            Kind::Greater => Some("Gtr"),
            Kind::GreaterEqual => Some("Gte"),
            Kind::LessEqual => Some("Lte"),
            Kind::Less if self.ahead(3).kind != Kind::Greater => Some("Lss"),
            _ => None,
        };
        if let Some(guard) = guard {
            return self.fail(diagnostic.help(format!("a comparison that decides is a guard: `{guard}_{{{text},…}}`")));
        }
        if self.ahead(1).kind == Kind::OpenRound && matches!(text.as_str(), "while" | "repeat" | "for" | "if") {
            return self.fail(diagnostic.help(
                "what goes on for ever is `loop(P)`, so many times `P^n`; a choice is `(Gtr_{x,y} ; P | Lte_{x,y} ; Q)`",
            ));
        }
        self.fail(diagnostic.edit("with a capital", span, capital))
    }

    /// `Name`, `Name_x`, `Name_{x,y}`, `Name(x,y)`, each with or without `<r>`
    fn application(&mut self) -> Parse<Term> {
        let start = self.token().span.start;
        let name = self.ident();
        let arguments = self.arguments()?;
        let results = self.results()?;
        Ok(Term { span: self.since(start), kind: TermKind::Apply { name, arguments, results } })
    }

    fn arguments(&mut self) -> Parse<Vec<Value>> {
        if self.at(Kind::OpenRound) {
            self.take(Role::Joining);
            return self.list(Kind::CloseRound, "an operator, `,` or `)`", Parser::value);
        }
        if !self.at(Kind::Underscore) {
            return Ok(Vec::new());
        }
        let start = self.take(Role::Joining).span.start;
        match self.kind() {
            Kind::OpenCurly => {
                self.take(Role::Joining);
                self.list(Kind::CloseCurly, "an operator, `,` or `}`", Parser::value)
            }
            Kind::Lower | Kind::Upper | Kind::Number | Kind::Meta => {
                let value = self.single()?;
                let longer = matches!(
                    self.kind(),
                    Kind::Plus | Kind::Minus | Kind::Star | Kind::Slash | Kind::OpenRound | Kind::Underscore
                );
                if longer {
                    let diagnostic = self
                        .wrong("the end of the parameter")
                        .label(self.since(start), "only this belongs to the name before it");
                    let called = self.at(Kind::OpenRound) && matches!(value.kind, ValueKind::Name(_));
                    return self.fail(diagnostic.help(if called {
                        "a port stands behind `_`, and what is read or written is said so: `In_c<x>`, `Out_{c,x}`; \
                         a parameter longer than one name or number needs braces: `Delay_{2*t}`"
                    } else {
                        "after `_`, anything longer than one name or number needs braces: `Delay_{2*t}`"
                    }));
                }
                Ok(vec![value])
            }
            _ => {
                let diagnostic = self
                    .wrong("a parameter")
                    .help("write one name or number, as in `At_a`, or braces, as in `Out_{c,x+1}`");
                self.fail(diagnostic)
            }
        }
    }

    /// `<x, y>`, if it follows.
    pub(super) fn results(&mut self) -> Parse<Vec<Ident>> {
        if !self.at(Kind::Less) {
            return Ok(Vec::new());
        }
        self.take(Role::Joining);
        let mut names = vec![self.small("the name of a result")?];
        while self.accept(Kind::Comma) {
            names.push(self.small("the name of a result")?);
        }
        if !self.at(Kind::Greater) {
            return self.unexpected("`,` or `>`");
        }
        self.take(Role::Closing);
        Ok(names)
    }
}

/// The parts under an operator; of one part, that part.
fn many(mut parts: Vec<Term>, kind: fn(Vec<Term>) -> TermKind) -> Term {
    match parts.pop() {
        Some(only) if parts.is_empty() => only,
        last => {
            parts.extend(last);
            parts.shrink_to_fit();
            let span = parts.iter().map(|part| part.span).reduce(Span::to).unwrap_or_default();
            Term { span, kind: kind(parts) }
        }
    }
}
