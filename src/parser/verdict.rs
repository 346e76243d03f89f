//! What is asked of a system beside its property: what always holds, and how likely something is.

use super::{Parse, Parser, Role};
use crate::ast::{ClaimKind, Comparison, Event, How, Ident, Likelihood, Restriction, Term, Within};
use crate::lexer::{Keyword, Kind, Token};
use crate::value::Relation;

/// The ways to find a chance.
const METHODS: [&str; 3] = ["exact", "enclosed", "estimated"];

impl Parser<'_> {
    /// Whether `probability` behind this token is no item of its own.
    pub(super) fn leads_to_probability(&self, before: Token) -> bool {
        before.kind == Kind::Word(Keyword::Prove) || before.kind == Kind::Colon || before.span.of(self.text) == "with"
    }

    /// `abs(p-o) > 1, p < 9 when At_p, Rock_o`
    pub(super) fn always(&mut self, system: Ident) -> Parse<ClaimKind> {
        let conditions = self.comparisons()?;
        let shown = if self.accept(Kind::Word(Keyword::When)) { self.patterns()? } else { Vec::new() };
        Ok(ClaimKind::Always { system, conditions, shown })
    }

    /// `Goal`, `Goal with probability >= q`
    pub(super) fn satisfies(&mut self, system: Ident) -> Parse<ClaimKind> {
        let property = self.capital("the name of a property")?;
        if self.spelling() != "with" {
            return Ok(ClaimKind::Satisfies(system, property));
        }
        self.advance();
        self.require(Kind::Word(Keyword::Probability), "`probability >= q`")?;
        let (relation, bound) = self.threshold()?;
        let method = self.method()?;
        let span = system.span.to(property.span);
        Ok(ClaimKind::Likely(Likelihood { span, system, event: Event::Satisfies(property), method }, relation, bound))
    }

    /// `of Sys reaching At_a within d >= q`
    pub(super) fn likely(&mut self) -> Parse<ClaimKind> {
        let (likelihood, relation, bound) = self.likely_enough(None)?;
        Ok(ClaimKind::Likely(likelihood, relation, bound))
    }

    /// `of Sys reaching At_a within d >= q`; without a system where one is given.
    pub(super) fn likely_enough(&mut self, system: Option<Ident>) -> Parse<(Likelihood, Relation, crate::ast::Value)> {
        let mut likelihood = self.likelihood(system)?;
        let (relation, bound) = self.threshold()?;
        if likelihood.method.is_none() {
            likelihood.method = self.method()?;
        }
        Ok((likelihood, relation, bound))
    }

    /// `where P(x <= d) >= q`, or `where q > 1`, if it stands here.
    pub(super) fn restriction(&mut self) -> Parse<Option<Restriction>> {
        if self.spelling() != "where" {
            return Ok(None);
        }
        let start = self.token().span.start;
        self.advance();
        if self.spelling() == "P" {
            return Ok(Some(Restriction::Within(self.within(start)?)));
        }
        if self.at(Kind::Upper) {
            return self.unexpected("`P(x <= 10) >= 9/10`, or comparisons of what is shown, such as `q > 1`");
        }
        Ok(Some(Restriction::Always(self.comparisons()?)))
    }

    /// `P(x <= d) >= q`
    fn within(&mut self, start: usize) -> Parse<Within> {
        self.advance();
        self.take(Role::Joining);
        if !self.at(Kind::Lower) {
            return self.unexpected("the name of the time that is drawn");
        }
        let name = self.ident();
        if !self.accept(Kind::LessEqual) {
            return self.unexpected("`<=` and the latest time");
        }
        let time = self.value()?;
        self.require(Kind::CloseRound, "`)`")?;
        let threshold = self.threshold()?;
        Ok(Within { span: self.since(start), name, time, threshold })
    }

    fn threshold(&mut self) -> Parse<(Relation, crate::ast::Value)> {
        let Some(relation) = self.relation().filter(|one| !matches!(one, Relation::Eq | Relation::Neq)) else {
            return self.unexpected("a threshold such as `>= 9/10`");
        };
        Ok((relation, self.value()?))
    }

    /// `of Sys reaching At_p where … within d by enclosed`
    pub(super) fn likelihood(&mut self, system: Option<Ident>) -> Parse<Likelihood> {
        let start = self.token().span.start;
        self.word("of")?;
        let system = match system {
            Some(system) => system,
            None => self.capital("the name of a system")?,
        };
        let first = match self.spelling() {
            "reaching" => true,
            "showing" => false,
            _ => {
                let what = "`reaching` (at some time up to then) or `showing` (at that time)";
                return self.unexpected_near(what, &["reaching", "showing"]);
            }
        };
        self.advance();
        let shown = self.patterns()?;
        let conditions = if self.spelling() == "where" {
            self.advance();
            self.comparisons()?
        } else {
            Vec::new()
        };
        let (word, other) = if first { ("within", "at") } else { ("at", "within") };
        if self.spelling() == other {
            let wrong = self.wrong(&format!("`{word}`"));
            return self.fail(wrong.help(
                "`reaching … within 10` asks for some time up to 10, and `showing … at 10` for that time alone",
            ));
        }
        self.word(word)?;
        let time = self.value()?;
        let method = self.method()?;
        let event = Event::Shown { first, shown, conditions, time };
        Ok(Likelihood { span: self.since(start), system, event, method })
    }

    /// `by exact`, `by enclosed`, `by estimated`, `by estimated with 1000000 runs seed 7`
    fn method(&mut self) -> Parse<Option<How>> {
        if !self.accept(Kind::Word(Keyword::By)) {
            return Ok(None);
        }
        if !METHODS.contains(&self.spelling()) {
            return self.unexpected_near("a method: `exact`, `enclosed` or `estimated`", &METHODS);
        }
        let simulated = self.spelling() == "estimated";
        let mut how = How { name: self.ident(), runs: None, seed: None };
        if simulated && self.spelling() == "with" {
            self.advance();
            how.runs = Some(self.value()?);
            self.word("runs")?;
        }
        if simulated && self.spelling() == "seed" {
            self.advance();
            how.seed = Some(self.value()?);
        }
        Ok(Some(how))
    }

    /// A word that has a meaning here alone.
    pub(super) fn word(&mut self, word: &str) -> Parse<()> {
        if self.spelling() != word {
            return self.unexpected_near(&format!("`{word}`"), &[word]);
        }
        self.advance();
        Ok(())
    }

    /// The error that `what` was expected, with the word of these that is spelled nearly as what stands there.
    fn unexpected_near<T>(&mut self, what: &str, words: &[&str]) -> Parse<T> {
        let near = crate::diagnostic::nearest(self.spelling(), words.iter().copied()).map(str::to_string);
        let span = self.token().span;
        let diagnostic = self.wrong(what);
        match near {
            Some(near) => {
                let said = format!("did you mean `{near}`?");
                self.fail(diagnostic.edit(said, span, near))
            }
            None => self.fail(diagnostic),
        }
    }

    fn comparisons(&mut self) -> Parse<Vec<Comparison>> {
        let mut all = vec![self.compared()?];
        while self.accept(Kind::Comma) {
            all.push(self.compared()?);
        }
        Ok(all)
    }

    fn compared(&mut self) -> Parse<Comparison> {
        let start = self.token().span.start;
        let left = self.value()?;
        let Some(relation) = self.relation() else {
            let wrong = self.wrong("a comparison such as `> 1`");
            let shown = self.kind() == Kind::Underscore;
            let help = "give what is shown a name, and compare that: `always p <= 3 when At_p`";
            return self.fail(if shown { wrong.help(help) } else { wrong });
        };
        let right = self.value()?;
        Ok(Comparison { span: self.since(start), relation, left, right })
    }

    pub(super) fn patterns(&mut self) -> Parse<Vec<Term>> {
        let mut all = vec![self.pattern()?];
        while self.accept(Kind::Comma) {
            all.push(self.pattern()?);
        }
        Ok(all)
    }

    /// `At_p`: an observer with names or values.
    fn pattern(&mut self) -> Parse<Term> {
        if !self.at(Kind::Upper) {
            return self.unexpected("an observer with its parameters, such as `At_p`");
        }
        self.atom()
    }
}
