//! Values that are chosen by comparisons, which `and` and `or` may join.

use super::{Parse, Parser, Role};
use crate::ast::{Comparison, Either, ValueKind};
use crate::diagnostic::Diagnostic;
use crate::lexer::{Keyword, Kind};
use crate::value::Relation;

/// The most comparisons of one condition.
const MOST_COMPARISONS: usize = 12;

impl Parser<'_> {
    /// `if a < b then x else y`, `if a <= b < c and d > e or f = g then x else y`
    pub(super) fn choice(&mut self) -> Parse<ValueKind> {
        self.advance();
        let mut either = self.either()?;
        self.require(Kind::Word(Keyword::Then), "`and`, `or` or `then`")?;
        let then = self.value()?;
        self.require(Kind::Word(Keyword::Else), "`else`")?;
        let other = self.value()?;
        if let [together] = either.0.as_mut_slice()
            && together.len() == 1
            && let Some(Comparison { relation, left, right, .. }) = together.pop()
        {
            return Ok(ValueKind::If(relation, Box::new([left, right, then, other])));
        }
        Ok(ValueKind::Cases(vec![(then, Some(either)), (other, None)]))
    }

    /// `{x if a < b; y if a >= b}`, `{x if a < b; y otherwise}`
    pub(super) fn cases(&mut self) -> Parse<ValueKind> {
        self.take(Role::Opening);
        let mut all = Vec::new();
        loop {
            let value = self.nested(Parser::sum)?;
            if self.at_spelling("otherwise") {
                self.advance();
                all.push((value, None));
                break;
            }
            self.require(Kind::Word(Keyword::If), "`if` and a comparison, or `otherwise`")?;
            all.push((value, Some(self.either()?)));
            if !self.at(Kind::Semicolon) {
                break;
            }
            self.take(Role::Closing);
        }
        self.require(Kind::CloseCurly, "`;` and the next case, or `}`")?;
        Ok(ValueKind::Cases(all))
    }

    /// Comparisons, joined by `and` and `or`, of which `and` binds closer.
    pub(super) fn either(&mut self) -> Parse<Either> {
        let start = self.token().span.start;
        let mut all = vec![self.together()?];
        while self.at_spelling("or") {
            self.advance();
            all.push(self.together()?);
        }
        let count = all.iter().map(Vec::len).sum::<usize>();
        if count > MOST_COMPARISONS {
            let span = self.since(start);
            return self.fail(
                Diagnostic::error("P0201", format!("a condition of more than {MOST_COMPARISONS} comparisons"))
                    .label(span, format!("{count} comparisons"))
                    .help("choose step by step: `if a < b then (if c < d then x else y) else z`"),
            );
        }
        Ok(Either(all))
    }

    fn together(&mut self) -> Parse<Vec<Comparison>> {
        let mut all = self.in_a_row()?;
        while self.at_spelling("and") {
            self.advance();
            all.extend(self.in_a_row()?);
        }
        Ok(all)
    }

    /// `a <= b < c`: as many comparisons as signs, which all point the same way.
    fn in_a_row(&mut self) -> Parse<Vec<Comparison>> {
        let mut left = self.value()?;
        let mut all: Vec<Comparison> = Vec::new();
        loop {
            let sign = self.token().span;
            let Some(relation) = self.relation() else {
                return if all.is_empty() { self.unexpected("a comparison such as `<` or `=`") } else { Ok(all) };
            };
            if let Some(other) = all.iter().map(|one| one.relation).find(|other| !alike(*other, relation)) {
                let text = format!("`{}` behind `{}` in one comparison", relation.symbol(), other.symbol());
                return self.fail(
                    Diagnostic::error("P0201", text)
                        .label(sign, "this sign points another way")
                        .help("join two comparisons by `and`: `a < b and b > c`"),
                );
            }
            let right = self.value()?;
            all.push(Comparison { span: left.span.to(right.span), relation, left, right: right.clone() });
            left = right;
        }
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

    pub(super) fn at_spelling(&self, word: &str) -> bool {
        self.at(Kind::Lower) && self.spelling() == word
    }
}

/// Whether two signs may stand in one chain of comparisons.
fn alike(one: Relation, other: Relation) -> bool {
    let side = |relation| match relation {
        Relation::Lss | Relation::Lte => Some(false),
        Relation::Gtr | Relation::Gte => Some(true),
        Relation::Eq | Relation::Neq => None,
    };
    let equal = |relation| relation == Relation::Eq;
    match (side(one), side(other)) {
        (Some(one), Some(other)) => one == other,
        _ => (equal(one) || side(one).is_some()) && (equal(other) || side(other).is_some()),
    }
}
