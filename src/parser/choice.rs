//! Values that are chosen by comparisons, which `and` and `or` may join.

use super::{Parse, Parser, Role};
use crate::ast::{Comparison, Either, ValueKind};
use crate::diagnostic::{Diagnostic, Span};
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

    /// Comparisons, joined by `and` and `or`, of which `and` binds closer, with brackets and `not`.
    pub(super) fn either(&mut self) -> Parse<Either> {
        let mut all = self.together()?;
        while self.at_spelling("or") {
            self.advance();
            all.extend(self.together()?);
        }
        self.few_enough(&all)?;
        Ok(Either(all))
    }

    fn few_enough(&mut self, all: &[Vec<Comparison>]) -> Parse<()> {
        let count = all.iter().map(Vec::len).sum::<usize>();
        if count <= MOST_COMPARISONS {
            return Ok(());
        }
        let Some(span) = all.iter().flatten().map(|one| one.span).reduce(Span::to) else { return Ok(()) };
        self.fail(
            Diagnostic::error("P0201", format!("a condition of more than {MOST_COMPARISONS} comparisons"))
                .label(span, "this is more, as `or` of what `and` joins")
                .help("choose step by step: `if a < b then (if c < d then x else y) else z`"),
        )
    }

    fn together(&mut self) -> Parse<Vec<Vec<Comparison>>> {
        let mut all = self.operand()?;
        while self.at_spelling("and") {
            self.advance();
            all = both(&all, &self.operand()?);
            self.few_enough(&all)?;
        }
        Ok(all)
    }

    /// What `and` joins: comparisons in a row, a condition in brackets, or `not` with one of these.
    fn operand(&mut self) -> Parse<Vec<Vec<Comparison>>> {
        if self.at_spelling("not") && sign(self.ahead(1).kind).is_none() {
            self.advance();
            let all = self.nested(Parser::operand)?;
            let opposite =
                all.iter().map(|together| together.iter().map(|one| vec![opposite(one)]).collect::<Vec<_>>());
            let mut denied = vec![Vec::new()];
            for one in opposite {
                denied = both(&denied, &one);
                self.few_enough(&denied)?;
            }
            return Ok(denied);
        }
        if self.encloses_a_comparison() {
            self.advance();
            let Either(all) = self.nested(Parser::either)?;
            self.require(Kind::CloseRound, "`and`, `or` or `)`")?;
            let reckons = matches!(self.kind(), Kind::Plus | Kind::Minus | Kind::Star | Kind::Slash | Kind::Caret);
            if reckons || sign(self.kind()).is_some() {
                let advice = "a condition in brackets is no value: choose one, `(if a > b then 1 else 0)`";
                let wrong = self.wrong("`and` or `or`").help(advice);
                return self.fail(wrong);
            }
            return Ok(all);
        }
        Ok(vec![self.in_a_row()?])
    }

    /// Whether a bracket begins here that has a condition in it, and no value.
    fn encloses_a_comparison(&self) -> bool {
        let (mut round, mut curly, mut choices) = (0_usize, 0_usize, 0_usize);
        for token in self.tokens.get(self.position..).unwrap_or(&[]) {
            match token.kind {
                Kind::OpenRound => round += 1,
                Kind::CloseRound => round = round.saturating_sub(1),
                Kind::OpenCurly => curly += 1,
                Kind::CloseCurly => curly = curly.saturating_sub(1),
                Kind::Word(Keyword::If) if curly == 0 => choices += 1,
                Kind::Word(Keyword::Then) if curly == 0 => choices = choices.saturating_sub(1),
                Kind::Word(keyword) if keyword.begins_item() => return false,
                kind if sign(kind).is_some() && round > 0 && curly == 0 && choices == 0 => return true,
                _ => {}
            }
            if round == 0 {
                return false;
            }
        }
        false
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
                let (one, two) = (other.symbol(), relation.symbol());
                return self.fail(
                    Diagnostic::error("P0201", format!("`{two}` behind `{one}` in one comparison"))
                        .label(sign, "the signs of one comparison point one way")
                        .help(format!("join two comparisons by `and`: `a {one} b and b {two} c`")),
                );
            }
            let right = self.value()?;
            all.push(Comparison { span: left.span.to(right.span), relation, left, right: right.clone() });
            left = right;
        }
    }

    /// Takes a comparison sign, if one follows.
    pub(super) fn relation(&mut self) -> Option<Relation> {
        let relation = sign(self.kind())?;
        self.advance();
        Some(relation)
    }

    pub(super) fn at_spelling(&self, word: &str) -> bool {
        self.at(Kind::Lower) && self.spelling() == word
    }
}

/// The comparison that a sign stands for.
fn sign(kind: Kind) -> Option<Relation> {
    Some(match kind {
        Kind::Equal => Relation::Eq,
        Kind::NotEqual => Relation::Neq,
        Kind::Greater => Relation::Gtr,
        Kind::GreaterEqual => Relation::Gte,
        Kind::Less => Relation::Lss,
        Kind::LessEqual => Relation::Lte,
        _ => return None,
    })
}

/// What holds where both hold, each as `or` of what `and` joins.
fn both(one: &[Vec<Comparison>], other: &[Vec<Comparison>]) -> Vec<Vec<Comparison>> {
    one.iter().flat_map(|left| other.iter().map(move |right| [left.as_slice(), right].concat())).collect()
}

fn opposite(comparison: &Comparison) -> Comparison {
    Comparison { relation: comparison.relation.negated(), ..comparison.clone() }
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
