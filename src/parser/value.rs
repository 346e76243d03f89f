//! Values: `p0 + s(g - r) * t`, `|r - q|`, `(x, y)`, `if a < b then x else y`, `Normal(0, sd: s)`.

use num_bigint::BigInt;
use num_rational::BigRational;

use super::{Failed, Parse, Parser, Role};
use crate::ast::{Argument, FACTORIAL, Ident, Value, ValueKind};
use crate::diagnostic::{Diagnostic, Span};
use crate::lexer::{Keyword, Kind, MOST_DIGITS};
use crate::name::Name;

impl Parser<'_> {
    /// A value: a sum.
    pub(super) fn value(&mut self) -> Parse<Value> {
        self.nested(Parser::sum)
    }

    pub(super) fn sum(&mut self) -> Parse<Value> {
        let first = self.product()?;
        if !matches!(self.kind(), Kind::Plus | Kind::Minus) {
            return Ok(first);
        }
        let start = first.span.start;
        let mut parts = vec![(false, first)];
        while matches!(self.kind(), Kind::Plus | Kind::Minus) {
            let minus = self.advance().kind == Kind::Minus;
            parts.push((minus, self.product()?));
        }
        Ok(Value { span: self.since(start), kind: ValueKind::Sum(parts) })
    }

    fn product(&mut self) -> Parse<Value> {
        let first = self.signed()?;
        if !matches!(self.kind(), Kind::Star | Kind::Slash) {
            return Ok(first);
        }
        let start = first.span.start;
        let mut parts = vec![(false, first)];
        while matches!(self.kind(), Kind::Star | Kind::Slash) {
            let divides = self.advance().kind == Kind::Slash;
            if !divides {
                parts.push((false, self.signed()?));
                continue;
            }
            let part = self.signed_by(Parser::simple_power)?;
            if self.at_factor() {
                return self.two_readings(part.span);
            }
            parts.push((true, part));
        }
        Ok(Value { span: self.since(start), kind: ValueKind::Product(parts) })
    }

    /// `a / 10t`: reported.
    fn two_readings<T>(&mut self, divisor: Span) -> Parse<T> {
        let first = divisor.of(self.text);
        let after = self.power()?.span;
        let rest = after.of(self.text);
        self.fail(
            Diagnostic::error("P0201", format!("`/ {}` can be read in two ways", divisor.to(after).of(self.text)))
                .label(divisor.to(after), format!("divided by `{first}`, or by the product?"))
                .help(format!("write `/ {first} * {rest}` or `/ ({first} * {rest})`")),
        )
    }

    /// A power with any number of signs before it.
    fn signed(&mut self) -> Parse<Value> {
        self.signed_by(Parser::power)
    }

    fn signed_by(&mut self, read: fn(&mut Self) -> Parse<Value>) -> Parse<Value> {
        let start = self.token().span.start;
        let mut negative = false;
        while matches!(self.kind(), Kind::Minus | Kind::Plus) {
            negative ^= self.at(Kind::Minus);
            self.take(Role::Opening);
        }
        let value = read(self)?;
        if !negative {
            return Ok(value);
        }
        Ok(Value { span: self.since(start), kind: ValueKind::Negative(Box::new(value)) })
    }

    /// A power, `x^2`; `10t`, `s(d)t` and `(a+b)(c+d)` are products.
    fn power(&mut self) -> Parse<Value> {
        let whole = self.simple_power()?;
        if !self.at_factor() {
            return Ok(whole);
        }
        let bracket = self.at(Kind::OpenRound);
        if let Some(role) = self.roles.get_mut(self.position) {
            *role = if bracket { Role::Joining } else { Role::Closing };
        }
        let rest = self.nested(Parser::power)?;
        let span = whole.span.to(rest.span);
        Ok(Value { span, kind: ValueKind::Product(vec![(false, whole), (false, rest)]) })
    }

    fn simple_power(&mut self) -> Parse<Value> {
        let bare = self.at(Kind::Lower) && self.ahead(1).kind != Kind::OpenRound;
        let mut base = self.primary()?;
        while self.at(Kind::Factorial) {
            let sign = self.take(Role::Closing).span;
            let name = Ident { name: Name::new(FACTORIAL), span: sign };
            let span = base.span.to(sign);
            base = Value { span, kind: ValueKind::Call(name, vec![Argument { label: None, value: base }]) };
        }
        match base.kind {
            ValueKind::Name(name) if bare => self.raised(name),
            _ if self.at(Kind::Caret) => {
                self.take(Role::Joining);
                let exponent = self.exponent()?;
                let span = base.span.to(exponent.span);
                Ok(Value { span, kind: ValueKind::Power(Box::new(base), Box::new(exponent)) })
            }
            _ => Ok(base),
        }
    }

    /// Whether a factor stands close behind what was read: a name behind a number or a bracket, or a bracket.
    fn at_factor(&self) -> bool {
        let Some(before) = self.position.checked_sub(1).and_then(|index| self.tokens.get(index)) else { return false };
        let close = before.span.end == self.token().span.start;
        close
            && match before.kind {
                Kind::Number | Kind::CloseRound | Kind::CloseCurly => {
                    matches!(self.kind(), Kind::Lower | Kind::OpenRound)
                }
                _ => false,
            }
    }

    /// What follows `^`: `2`, `-n`, `{n-1}`.
    fn exponent(&mut self) -> Parse<Value> {
        if !self.accept(Kind::OpenCurly) {
            return self.nested(Parser::signed);
        }
        let value = self.value()?;
        self.require(Kind::CloseCurly, "an operator or `}`")?;
        Ok(value)
    }

    /// A name with what may follow it: `x`, `x^2`, and functions that are applied again and again: `f^n(p)`,
    /// `f^m o f^n(p)`.
    fn raised(&mut self, name: Ident) -> Parse<Value> {
        let start = name.span.start;
        let mut count = self.how_often()?;
        let mut chain: Vec<(Ident, Option<Value>)> = Vec::new();
        let mut name = name;
        while self.composes(0) {
            self.advance();
            chain.push((name, count));
            name = self.small("the name of a function")?;
            count = self.how_often()?;
        }
        let close = self.at(Kind::OpenRound) && self.token().span.start == self.end();
        if chain.is_empty() && !(close && count.is_some()) {
            let value = Value { span: name.span, kind: ValueKind::Name(name) };
            let Some(exponent) = count else { return Ok(value) };
            return Ok(Value { span: self.since(start), kind: ValueKind::Power(Box::new(value), Box::new(exponent)) });
        }
        chain.push((name, count));
        if !close {
            return self.unexpected("`(` and what the functions are applied to");
        }
        self.take(Role::Joining);
        let arguments =
            self.list(Kind::CloseRound, "`,` or `)`", |parser| Ok(Argument { label: None, value: parser.value()? }))?;
        Ok(Value { span: self.since(start), kind: ValueKind::Iterate(chain, arguments) })
    }

    /// Whether so many tokens ahead `o` or `∘` stands before a function.
    fn composes(&self, ahead: usize) -> bool {
        let sign = self.ahead(ahead);
        let function = self.ahead(ahead + 1).kind == Kind::Lower;
        sign.kind == Kind::Lower && matches!(sign.span.of(self.text), "o" | "∘") && function
    }

    /// An exponent behind a name, if one follows; alone, `n` and `3` do not take the bracket behind them.
    fn how_often(&mut self) -> Parse<Option<Value>> {
        if !self.at(Kind::Caret) {
            return Ok(None);
        }
        self.take(Role::Joining);
        let next = self.ahead(1);
        let close = next.kind == Kind::OpenRound && next.span.start == self.token().span.end;
        if (close || self.composes(1)) && matches!(self.kind(), Kind::Lower | Kind::Number) {
            return Ok(Some(self.single()?));
        }
        Ok(Some(self.exponent()?))
    }

    pub(super) fn primary(&mut self) -> Parse<Value> {
        let start = self.token().span.start;
        let kind = match self.kind() {
            Kind::Number => {
                let number = self.number();
                let percent = self.at(Kind::Percent);
                if percent {
                    self.take(Role::Closing);
                }
                ValueKind::Number(if percent { number / BigRational::from_integer(BigInt::from(100)) } else { number })
            }
            Kind::Lower | Kind::Upper => self.named()?,
            Kind::Meta => ValueKind::Name(self.meta_value()?),
            Kind::OpenRound => return self.bracketed(),
            Kind::Bar => {
                self.take(Role::Opening);
                let inner = self.value()?;
                if !self.at(Kind::Bar) {
                    return self.unexpected("`|`, the end of the absolute value");
                }
                self.take(Role::Closing);
                ValueKind::Absolute(Box::new(inner))
            }
            Kind::Word(Keyword::If) => self.choice()?,
            Kind::OpenCurly => self.cases()?,
            Kind::Word(keyword) => {
                let word = keyword.spelling();
                let diagnostic = self
                    .wrong("a value")
                    .note(format!("`{word}` is a word of the language, so no value can have this name"));
                return self.fail(diagnostic);
            }
            _ => return self.unexpected("a value"),
        };
        Ok(Value { span: self.since(start), kind })
    }

    /// The exact number that is the next token; 0 where it was refused for its length.
    fn number(&mut self) -> BigRational {
        let text = self.spelling();
        self.advance();
        let zero = BigRational::from_integer(BigInt::from(0));
        if text.len() > MOST_DIGITS + 1 {
            return zero;
        }
        let (whole, fraction) = text.split_once('.').unwrap_or((text, ""));
        let digits: BigInt = format!("{whole}{fraction}").parse().unwrap_or_default();
        let scale =
            u32::try_from(fraction.len()).map_or_else(|_| BigInt::from(1), |places| BigInt::from(10).pow(places));
        BigRational::new(digits, scale)
    }

    fn meta_value(&mut self) -> Parse<Ident> {
        let text = self.spelling();
        if text.chars().nth(1).is_some_and(char::is_uppercase) {
            let span = self.token().span;
            return self.fail(
                Diagnostic::error("P0206", format!("`{text}` stands for a process, but a value is needed here"))
                    .label(span, "a value is needed here")
                    .help(format!("write `{}` for a value", text.to_lowercase())),
            );
        }
        Ok(self.ident())
    }

    fn named(&mut self) -> Parse<ValueKind> {
        let name = self.ident();
        if self.at(Kind::Underscore) && self.ahead(1).kind == Kind::OpenCurly {
            // `r_{n+1}`, a term of a sequence
            self.take(Role::Joining);
            self.take(Role::Joining);
            let plain = |parser: &mut Self| Ok(Argument { label: None, value: parser.value()? });
            let arguments = self.list(Kind::CloseCurly, "an operator, `,` or `}`", plain)?;
            return Ok(ValueKind::Call(name, arguments));
        }
        if !self.at(Kind::OpenRound) {
            return Ok(ValueKind::Name(name));
        }
        self.take(Role::Joining);
        let arguments = self.list(Kind::CloseRound, "`,` or `)`", |parser| {
            let value = parser.value()?;
            if !parser.at(Kind::Colon) {
                if let ValueKind::Name(label) = &value.kind
                    && ["sd", "var", "rate"].contains(&label.name.as_str())
                    && !parser.at(Kind::Comma)
                    && !parser.at(Kind::CloseRound)
                {
                    let wrong =
                        parser.wrong("`:`").help(format!("write `{0}: ` and its value, as in `{0}: 1/10`", label.name));
                    return parser.fail(wrong);
                }
                return Ok(Argument { label: None, value });
            }
            parser.take(Role::Closing);
            Ok(Argument { label: Some(value), value: parser.value()? })
        })?;
        Ok(ValueKind::Call(name, arguments))
    }

    /// `(a)`, or the vector `(a, b)`.
    fn bracketed(&mut self) -> Parse<Value> {
        let start = self.advance().span.start;
        let mut parts = vec![self.value()?];
        while self.accept(Kind::Comma) {
            parts.push(self.value()?);
        }
        self.require(Kind::CloseRound, if parts.len() == 1 { "an operator or `)`" } else { "`,` or `)`" })?;
        let span = self.since(start);
        match parts.pop() {
            Some(only) if parts.is_empty() => Ok(Value { span, ..only }),
            Some(last) => {
                parts.push(last);
                Ok(Value { span, kind: ValueKind::Vector(parts) })
            }
            None => Err(Failed),
        }
    }
}
