//! Values: `p0 + s(g - r) * t`, `|r - q|`, `(x, y)`, `if a < b then x else y`, `Normal(0, sd: s)`.

use num_bigint::BigInt;
use num_rational::BigRational;

use super::{Failed, Parse, Parser, Role};
use crate::ast::{Argument, Value, ValueKind};
use crate::diagnostic::Diagnostic;
use crate::lexer::{Keyword, Kind, MOST_DIGITS};
use crate::value::Relation;

impl Parser<'_> {
    /// A value: a sum.
    pub(super) fn value(&mut self) -> Parse<Value> {
        self.nested(Parser::sum)
    }

    fn sum(&mut self) -> Parse<Value> {
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
            if divides && self.at_multiple() {
                let span = self.token().span.to(self.ahead(1).span);
                let (number, name) = (self.spelling(), self.ahead(1).span.of(self.text));
                return self.fail(
                    Diagnostic::error("P0201", format!("`/ {number}{name}` can be read in two ways"))
                        .label(span, "divided by the number, or by the product?")
                        .help(format!("write `/ {number} * {name}` or `/ ({number} * {name})`")),
                );
            }
            parts.push((divides, self.signed()?));
        }
        Ok(Value { span: self.since(start), kind: ValueKind::Product(parts) })
    }

    /// A power with any number of signs before it.
    fn signed(&mut self) -> Parse<Value> {
        let start = self.token().span.start;
        let mut negative = false;
        while matches!(self.kind(), Kind::Minus | Kind::Plus) {
            negative ^= self.at(Kind::Minus);
            self.take(Role::Opening);
        }
        let value = self.power()?;
        if !negative {
            return Ok(value);
        }
        Ok(Value { span: self.since(start), kind: ValueKind::Negative(Box::new(value)) })
    }

    /// Whether a number follows with a name close behind it: `10t`.
    fn at_multiple(&self) -> bool {
        let next = self.ahead(1);
        self.at(Kind::Number) && next.kind == Kind::Lower && next.span.start == self.token().span.end
    }

    /// A power; `10t` is a product.
    fn power(&mut self) -> Parse<Value> {
        let multiple = self.at_multiple();
        let base = self.primary()?;
        if multiple {
            if let Some(role) = self.roles.get_mut(self.position) {
                *role = Role::Closing;
            }
            let rest = self.nested(Parser::power)?;
            let span = base.span.to(rest.span);
            return Ok(Value { span, kind: ValueKind::Product(vec![(false, base), (false, rest)]) });
        }
        if !self.at(Kind::Caret) {
            return Ok(base);
        }
        self.take(Role::Joining);
        let exponent = self.nested(Parser::signed)?;
        let span = base.span.to(exponent.span);
        Ok(Value { span, kind: ValueKind::Power(Box::new(base), Box::new(exponent)) })
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

    fn meta_value(&mut self) -> Parse<crate::ast::Ident> {
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
        if !self.at(Kind::OpenRound) {
            return Ok(ValueKind::Name(name));
        }
        self.take(Role::Joining);
        let arguments = self.list(Kind::CloseRound, "`,` or `)`", |parser| {
            let value = parser.value()?;
            if !parser.at(Kind::Colon) {
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

    fn choice(&mut self) -> Parse<ValueKind> {
        self.advance();
        let left = self.value()?;
        let Some(relation) = self.relation() else {
            return self.unexpected("a comparison such as `<` or `=`");
        };
        let right = self.value()?;
        self.require(Kind::Word(Keyword::Then), "`then`")?;
        let then = self.value()?;
        self.require(Kind::Word(Keyword::Else), "`else`")?;
        let other = self.value()?;
        Ok(ValueKind::If(relation, Box::new([left, right, then, other])))
    }

    /// Takes a comparison sign, if one follows.
    pub(super) fn relation(&mut self) -> Option<Relation> {
        let relation = match self.kind() {
            Kind::Equal => Relation::Eq,
            Kind::NotEqual => Relation::Neq,
            Kind::Greater => Relation::Gtr,
            Kind::GreaterEqual => Relation::Gte,
            Kind::Less => Relation::Lss,
            Kind::LessEqual => Relation::Lte,
            _ => return None,
        };
        self.advance();
        Some(relation)
    }
}
