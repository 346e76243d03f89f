//! Claims, calculations, laws and conditions.

use super::{Parse, Parser, Role};
use crate::ast::{By, CalcStep, Claim, ClaimKind, Condition, ConditionKind, Ident, LawItem, Term, TermKind};
use crate::diagnostic::{Diagnostic, Span};
use crate::law::{Connective, Fact};
use crate::lexer::{Keyword, Kind};
use crate::name::Name;

/// What stands before the equation of a law.
struct LawHead {
    name: Ident,
    title: String,
    source: String,
    conditions: Vec<Condition>,
}

impl Parser<'_> {
    /// `[name:] P = Q [when …] [by …]`, `P <= Q …`, `Sys satisfies Goal`
    pub(super) fn claim(&mut self) -> Parse<Claim> {
        let name = self.claim_name();
        if self.at_word(Keyword::Probability) {
            self.advance();
            return Ok(Claim { name, kind: self.likely()? });
        }
        let left = self.term()?;
        if self.at_word(Keyword::Satisfies) || self.at_word(Keyword::Always) {
            let always = self.at_word(Keyword::Always);
            let word = self.advance().span;
            let does = if always { "always meet a condition" } else { "satisfy a property" };
            let TermKind::Apply { name: system, arguments, results } = left.kind else {
                return self.unnamed_system(left.span, word, does);
            };
            if !arguments.is_empty() || !results.is_empty() {
                return self.unnamed_system(left.span, word, does);
            }
            let kind = if always { self.always(system)? } else { self.satisfies(system)? };
            return Ok(Claim { name, kind });
        }
        let connective = self.connective("`=`, `<=`, `~~`, `satisfies` or `always`")?;
        let right = self.term()?;
        let when = if self.accept(Kind::Word(Keyword::When)) { self.conditions()? } else { Vec::new() };
        let by = if self.accept(Kind::Word(Keyword::By)) { self.by()? } else { By::Search };
        Ok(Claim { name, kind: ClaimKind::Compare { left, connective, right, when, by } })
    }

    fn unnamed_system<T>(&mut self, span: Span, word: Span, does: &str) -> Parse<T> {
        self.fail(
            Diagnostic::error("P0208", format!("only a system with a name can {does}"))
                .label(span, "this is a process")
                .label(word, "")
                .help("name it first: `system Sys = P | Q`, then `prove Sys satisfies Goal`"),
        )
    }

    /// `name:` if it stands here.
    fn claim_name(&mut self) -> Option<Ident> {
        let mut count = 1;
        let word = |kind: Kind| matches!(kind, Kind::Lower | Kind::Upper | Kind::Number | Kind::Word(_));
        if !word(self.kind()) {
            return None;
        }
        while self.ahead(count).kind == Kind::Minus && word(self.ahead(count + 1).kind) {
            count += 2;
        }
        if self.ahead(count).kind != Kind::Colon {
            return None;
        }
        let name = self.dashed();
        self.take(Role::Closing);
        Some(name)
    }

    /// A name of words with dashes between; the next token is its first word.
    pub(super) fn dashed(&mut self) -> Ident {
        let start = self.advance().span;
        let mut end = start;
        while self.at(Kind::Minus) && self.token().span.start == end.end {
            let next = self.ahead(1);
            let word = matches!(next.kind, Kind::Lower | Kind::Upper | Kind::Number | Kind::Word(_));
            if !word || next.span.start != self.token().span.end {
                break;
            }
            self.take(Role::Joining);
            end = self.advance().span;
        }
        let span = start.to(end);
        Ident { name: Name::new(span.of(self.text)), span }
    }

    pub(super) fn law_name(&mut self) -> Parse<Ident> {
        if matches!(self.kind(), Kind::Lower | Kind::Upper | Kind::Word(_)) && !self.at_item() {
            return Ok(self.dashed());
        }
        self.unexpected("the name of a law, such as `delay-sum`")
    }

    pub(super) fn connective(&mut self, what: &str) -> Parse<Connective> {
        match self.kind() {
            Kind::Equal => {
                self.advance();
                Ok(Connective::Equal)
            }
            Kind::LessEqual => {
                self.advance();
                Ok(Connective::Refines)
            }
            Kind::Weak => {
                self.advance();
                Ok(Connective::Weak)
            }
            Kind::LessWeak => {
                self.advance();
                Ok(Connective::WeaklyRefines)
            }
            Kind::Arrow => {
                let span = self.token().span;
                let diagnostic = self.wrong(what).note("only a law is oriented");
                self.fail(diagnostic.edit("in a claim write `=`", span, "="))
            }
            _ => {
                let word = self.spelling();
                let known = [Keyword::Satisfies, Keyword::Always].map(Keyword::spelling);
                // `satisfy` has too many letters of its own to be near.
                let close = crate::diagnostic::nearest(word, known);
                match close.or_else(|| word.starts_with("satisf").then_some("satisfies")) {
                    Some(near) => {
                        let span = self.token().span;
                        let diagnostic = self.wrong(what).edit(format!("did you mean `{near}`?"), span, near);
                        self.fail(diagnostic)
                    }
                    None => self.unexpected(what),
                }
            }
        }
    }

    fn by(&mut self) -> Parse<By> {
        if self.at(Kind::OpenCurly) {
            self.take(Role::Spaced);
        } else {
            let mut laws = vec![self.law_name()?];
            while self.accept(Kind::Comma) {
                laws.push(self.law_name()?);
            }
            return Ok(By::Laws(laws));
        }
        let first = self.term()?;
        let mut steps = Vec::new();
        while !self.at(Kind::CloseCurly) {
            let start = self.token().span.start;
            let connective = self.connective("`= {law} P`, or `}` to end the calculation")?;
            self.require(Kind::OpenCurly, "`{` and the laws of this step")?;
            let laws = self.list(Kind::CloseCurly, "`,` or `}`", Parser::law_name)?;
            let term = self.term()?;
            steps.push(CalcStep { span: self.since(start), connective, laws, term });
        }
        self.take(Role::Spaced);
        Ok(By::Calc(first, steps))
    }

    /// `law name "title"`, then its source, conditions, equation and examples; or `law name: equation when conditions`.
    pub(super) fn law(&mut self) -> Parse<LawItem> {
        if let Some(name) = self.claim_name() {
            let title = name.name.to_string();
            return self.equation(LawHead { name, title, source: "ours".to_string(), conditions: Vec::new() }, true);
        }
        let name = self.law_name()?;
        let title = self
            .require(Kind::Text, "the title of the law in quotes")?
            .span
            .of(self.text)
            .trim_matches('"')
            .to_string();
        let source = if self.at(Kind::Origin) {
            let line = self.take(Role::Line).span.of(self.text).trim();
            line.chars().filter(|letter| !letter.is_control()).collect()
        } else {
            String::new()
        };
        let mut conditions = Vec::new();
        if self.at_word(Keyword::When) {
            self.take(Role::Line);
            conditions = self.conditions()?;
        }
        if let Some(role) = self.roles.get_mut(self.position) {
            *role = Role::Line;
        }
        self.equation(LawHead { name, title, source, conditions }, false)
    }

    /// The equation of a law and its examples; if `short`, its conditions behind the equation.
    fn equation(&mut self, head: LawHead, short: bool) -> Parse<LawItem> {
        let LawHead { name, title, source, mut conditions } = head;
        let left = self.term()?;
        let oriented = self.at(Kind::Arrow);
        let connective = if oriented {
            self.advance();
            Connective::Equal
        } else {
            self.connective("`=`, `=>`, `<=` or `~~`")?
        };
        let right = self.term()?;
        if short && self.accept(Kind::Word(Keyword::When)) {
            conditions = self.conditions()?;
        }
        let examples = self.examples()?;
        Ok(LawItem { name, title, source, conditions, left, connective, oriented, right, examples })
    }

    fn examples(&mut self) -> Parse<Vec<(Term, Term)>> {
        let mut examples = Vec::new();
        while self.at_word(Keyword::Try) {
            self.take(Role::Line);
            let left = self.term()?;
            if !matches!(self.kind(), Kind::Equal | Kind::LessEqual | Kind::Weak | Kind::Arrow) {
                return self.unexpected("`=` and what the example gives");
            }
            self.advance();
            examples.push((left, self.term()?));
        }
        Ok(examples)
    }

    fn conditions(&mut self) -> Parse<Vec<Condition>> {
        let mut all = vec![self.condition()?];
        while self.accept(Kind::Comma) {
            all.push(self.condition()?);
        }
        Ok(all)
    }

    pub(super) fn condition(&mut self) -> Parse<Condition> {
        let start = self.token().span.start;
        let word = self.spelling();
        let called = self.ahead(1).kind == Kind::OpenRound;
        let kind = match Predicate::of(word) {
            Some(predicate) if called => {
                self.advance();
                self.take(Role::Joining);
                let kind = self.predicate(predicate)?;
                self.require(Kind::CloseRound, "an operator or `)`")?;
                kind
            }
            _ => self.comparison(word, called)?,
        };
        Ok(Condition { span: self.since(start), kind })
    }

    fn comparison(&mut self, word: &str, called: bool) -> Parse<ConditionKind> {
        let span = self.token().span;
        let words = || Predicate::words().chain(["abs", "min", "max", "norm", "clamp", "floor", "ceil", "sqrt"]);
        let unknown = called && self.at(Kind::Lower) && !words().any(|known| known == word);
        let errors = self.diagnostics.len();
        let close = crate::diagnostic::nearest(word, Predicate::words());
        let left = match self.value() {
            Ok(left) => left,
            // A process inside: a misspelt condition, better reported as such.
            Err(failed) if !unknown => return Err(failed),
            Err(failed) => {
                if self.incomplete {
                    return Err(failed);
                }
                self.diagnostics.truncate(errors);
                return self.unknown_condition(word, span, close);
            }
        };
        let Some(relation) = self.relation() else {
            return if unknown {
                self.unknown_condition(word, span, close)
            } else {
                self.unexpected("a comparison such as `>= 0`")
            };
        };
        Ok(ConditionKind::Compare(relation, left, self.value()?))
    }

    fn unknown_condition<T>(&mut self, word: &str, span: crate::diagnostic::Span, close: Option<&str>) -> Parse<T> {
        let all: Vec<&str> = Predicate::words().collect();
        let diagnostic = Diagnostic::error("P0209", format!("there is no condition `{word}`"))
            .label(span, "this condition")
            .note(format!("the conditions are comparisons such as `a <= b`, and {}", all.join(", ")));
        match close {
            Some(close) => self.fail(diagnostic.edit(format!("did you mean `{close}`?"), span, close)),
            None => self.fail(diagnostic),
        }
    }

    /// `{At, Odo}`, or `?S` for any set.
    fn observer_set(&mut self) -> Parse<Vec<Ident>> {
        if self.at(Kind::Meta) { Ok(vec![self.ident()]) } else { self.shown() }
    }

    fn predicate(&mut self, predicate: Predicate) -> Parse<ConditionKind> {
        if predicate == Predicate::Natural {
            return Ok(ConditionKind::Natural(self.value()?));
        }
        let process = self.term()?;
        if let Predicate::Is(fact) = predicate {
            return Ok(ConditionKind::Is(fact, process));
        }
        self.require(Kind::Comma, "an operator or `,`")?;
        Ok(match predicate {
            Predicate::Lasts => ConditionKind::Lasts(process, self.value()?),
            Predicate::Complementary => ConditionKind::Complementary(process, self.term()?),
            Predicate::NoPort => ConditionKind::NoPort(process, self.small("the name of a port")?),
            Predicate::Unread => ConditionKind::Unread(process, self.small("the name of a result")?),
            Predicate::ShowsOnly => ConditionKind::ShowsOnly(process, self.observer_set()?),
            Predicate::ShowsNone => ConditionKind::ShowsNone(process, self.observer_set()?),
            _ => ConditionKind::Apart(process, self.term()?),
        })
    }
}

/// What a condition in words begins with.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Predicate {
    Natural,
    Is(Fact),
    Lasts,
    Complementary,
    NoPort,
    Unread,
    Apart,
    ShowsOnly,
    ShowsNone,
}

const PREDICATES: [(Predicate, &str); 8] = [
    (Predicate::Natural, "natural"),
    (Predicate::Lasts, "lasts"),
    (Predicate::Complementary, "complementary"),
    (Predicate::NoPort, "no_port"),
    (Predicate::Unread, "unread"),
    (Predicate::Apart, "apart"),
    (Predicate::ShowsOnly, "shows_only"),
    (Predicate::ShowsNone, "shows_none"),
];

impl Predicate {
    fn of(word: &str) -> Option<Predicate> {
        let fact = Fact::ALL.iter().find(|(_, spelling)| *spelling == word).map(|(fact, _)| Predicate::Is(*fact));
        fact.or_else(|| PREDICATES.iter().find(|(_, spelling)| *spelling == word).map(|(predicate, _)| *predicate))
    }

    fn words() -> impl Iterator<Item = &'static str> {
        Fact::ALL.iter().map(|(_, word)| *word).chain(PREDICATES.iter().map(|(_, word)| *word))
    }
}
