//! Exercises: a goal, the laws allowed, a calculation with gaps, hints.

use super::{Parse, Parser, Role};
use crate::ast::{By, ClaimKind, ExerciseItem, GapStep};
use crate::diagnostic::Diagnostic;
use crate::law::Connective;
use crate::lexer::{Keyword, Kind};

/// Reads one step of a calculation, as a learner writes it: `= {law} P`, or `= P`.
///
/// # Errors
/// What is wrong with it.
pub fn parse_step(text: &str) -> Result<GapStep, Vec<Diagnostic>> {
    Parser::new(text, false).alone_in_text(Parser::learner_step)
}

impl Parser<'_> {
    /// `name "title" prove P = Q [using law, law] [steps { = {law} _ … }] hint "…" …`
    pub(super) fn exercise(&mut self) -> Parse<ExerciseItem> {
        if !matches!(self.kind(), Kind::Lower | Kind::Word(_)) || self.at_item() {
            return self.unexpected("the name of the exercise, in small letters");
        }
        let name = self.dashed();
        let title = self.quoted("the title of the exercise in quotes")?;
        let prove = self.token().span;
        if !self.at_word(Keyword::Prove) {
            return self.unexpected("`prove` and what is to be shown");
        }
        self.take(Role::Line);
        let claim = self.claim()?;
        if !matches!(&claim.kind, ClaimKind::Compare { by: By::Search, .. }) {
            let diagnostic = Diagnostic::error("P0210", "an exercise shows `P = Q` or `P <= Q`, step by step")
                .label(prove.to(self.since(prove.start)), "this is something else")
                .help("the laws that may be used stand behind `using`, the steps with their gaps behind `steps`");
            return self.fail(diagnostic);
        }
        let mut laws = Vec::new();
        if self.at_small("using") {
            self.take(Role::Line);
            laws.push(self.law_name()?);
            while self.accept(Kind::Comma) {
                laws.push(self.law_name()?);
            }
        }
        let mut steps = Vec::new();
        if self.at_small("steps") {
            self.take(Role::Line);
            self.require(Kind::OpenCurly, "`{` and the steps")?;
            while !self.at(Kind::CloseCurly) {
                steps.push(self.gap_step()?);
            }
            self.take(Role::Line);
        }
        let mut hints = Vec::new();
        while self.at_small("hint") {
            self.take(Role::Line);
            hints.push(self.quoted("a hint in quotes")?);
        }
        Ok(ExerciseItem { name, title, claim, laws, steps, hints })
    }

    fn at_small(&self, word: &str) -> bool {
        self.at(Kind::Lower) && self.spelling() == word
    }

    fn quoted(&mut self, what: &str) -> Parse<String> {
        Ok(self.require(Kind::Text, what)?.span.of(self.text).trim_matches('"').to_string())
    }

    /// `= {law} P`, with `_` for what is to be filled in.
    fn gap_step(&mut self) -> Parse<GapStep> {
        let start = self.token().span.start;
        let connective = self.connective("`= {law} P`, with `_` for a gap, or `}`")?;
        self.require(Kind::OpenCurly, "`{` and the laws of this step (`{_}` where they are to be found)")?;
        let laws = if self.accept(Kind::Underscore) {
            self.require(Kind::CloseCurly, "`}`")?;
            None
        } else {
            Some(self.list(Kind::CloseCurly, "`,` or `}`", Parser::law_name)?)
        };
        let term = if self.accept(Kind::Underscore) { None } else { Some(self.term()?) };
        Ok(GapStep { span: self.since(start), connective, laws, term })
    }

    fn learner_step(&mut self) -> Parse<GapStep> {
        let start = self.token().span.start;
        let connective = if self.begins_term() { Connective::Equal } else { self.connective("`= {law} P`")? };
        let laws = if self.accept(Kind::OpenCurly) {
            Some(self.list(Kind::CloseCurly, "`,` or `}`", Parser::law_name)?)
        } else {
            None
        };
        let term = Some(self.term()?);
        Ok(GapStep { span: self.since(start), connective, laws, term })
    }
}
