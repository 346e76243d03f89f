//! `criteria Name for Sys { … }` and `sweep k in 0 .. 1 step 1/10 { … }`.

use super::{Parse, Parser, Role};
use crate::ast::{AxisKind, Clause, ClauseKind, Criteria, Ident, Item, ItemKind, Sweep, SweepQuestion, Term, Value};
use crate::lexer::{Keyword, Kind};

/// What begins a line of criteria.
const CLAUSES: &str = "`goals`, `radius`, `leg`, `round`, `every`, `clearance`, `battery`, `probability` or `}`";

impl Parser<'_> {
    pub(super) fn criteria(&mut self) -> Parse<Criteria> {
        let name = self.capital("a name for the criteria, as in `criteria Trip for Sys { … }`")?;
        self.word("for")?;
        let system = self.capital("the name of a system")?;
        self.opening_curly("`{` and the criteria")?;
        let mut clauses = Vec::new();
        while !self.closes() {
            let start = self.token().span.start;
            let kind = self.clause(&system)?;
            clauses.push(Clause { span: self.since(start), kind });
        }
        Ok(Criteria { name, system, clauses })
    }

    fn opening_curly(&mut self, what: &str) -> Parse<()> {
        if !self.at(Kind::OpenCurly) {
            return self.unexpected(what);
        }
        self.take(Role::Spaced);
        Ok(())
    }

    fn closes(&mut self) -> bool {
        let closes = self.at(Kind::CloseCurly);
        if closes {
            self.take(Role::Spaced);
        }
        closes
    }

    fn clause(&mut self, system: &Ident) -> Parse<ClauseKind> {
        if self.at_word(Keyword::Probability) {
            self.take(Role::Line);
            let (likelihood, relation, bound) = self.likely_enough(Some(system.clone()))?;
            return Ok(ClauseKind::Probability(likelihood, relation, bound));
        }
        let word = self.spelling();
        let known = ["goals", "radius", "leg", "round", "every", "clearance", "battery"];
        if !known.contains(&word) {
            let near = crate::diagnostic::nearest(word, known);
            let span = self.token().span;
            let diagnostic = self.wrong(CLAUSES);
            return self.fail(match near {
                Some(near) => diagnostic.edit(format!("did you mean `{near}`?"), span, near),
                None => diagnostic,
            });
        }
        self.take(Role::Line);
        match word {
            "goals" => Ok(ClauseKind::Goals(self.patterns()?)),
            "radius" => Ok(ClauseKind::Radius(self.value()?)),
            "every" if self.spelling() == "round" => self.round(true),
            "every" if self.spelling() == "leg" => self.leg(true),
            "every" => self.unexpected("`leg` or `round`"),
            "clearance" => self.clearance(),
            "battery" => self.battery(),
            "leg" => self.leg_after(false),
            _ => self.round_after(false),
        }
    }

    fn round(&mut self, every: bool) -> Parse<ClauseKind> {
        self.advance();
        self.round_after(every)
    }

    fn leg(&mut self, every: bool) -> Parse<ClauseKind> {
        self.advance();
        self.leg_after(every)
    }

    fn round_after(&mut self, every: bool) -> Parse<ClauseKind> {
        self.word("within")?;
        Ok(ClauseKind::Round { every, limit: self.value()? })
    }

    fn leg_after(&mut self, every: bool) -> Parse<ClauseKind> {
        let to: Option<Term> =
            if self.accept(Kind::Word(Keyword::To)) { self.patterns()?.into_iter().next() } else { None };
        self.word("within")?;
        Ok(ClauseKind::Leg { every, to, limit: self.value()? })
    }

    fn clearance(&mut self) -> Parse<ClauseKind> {
        let strict = self.accept(Kind::Greater);
        if !strict {
            self.accept(Kind::GreaterEqual);
        }
        let limit = self.value()?;
        self.word("between")?;
        let first = self.capital("the name of an observer")?;
        self.require(Kind::Comma, "`,` and another observer, as in `between At, Rock`")?;
        let second = self.capital("the name of an observer")?;
        Ok(ClauseKind::Clearance { strict, limit, between: [first, second] })
    }

    fn battery(&mut self) -> Parse<ClauseKind> {
        let start = self.value()?;
        let mut rates = Vec::new();
        loop {
            self.word("rate")?;
            let rate = self.value()?;
            let shown = if self.spelling() == "while" {
                self.advance();
                Some(self.capital("the name of an observer")?)
            } else {
                None
            };
            rates.push((rate, shown));
            if !self.accept(Kind::Comma) {
                break;
            }
        }
        let mut time = self.time_of_battery()?;
        self.word("keep")?;
        let keep = self.value()?;
        if time.is_none() {
            time = self.time_of_battery()?;
        }
        Ok(ClauseKind::Battery { start, rates, keep, time })
    }

    /// How long a battery must last, said before or behind what it must keep.
    fn time_of_battery(&mut self) -> Parse<Option<Value>> {
        if self.spelling() != "for" {
            return Ok(None);
        }
        self.advance();
        self.value().map(Some)
    }

    pub(super) fn sweep(&mut self) -> Parse<Sweep> {
        let mut axes = vec![self.axis()?];
        while self.accept(Kind::Comma) {
            axes.push(self.axis()?);
        }
        self.opening_curly("`,` and another parameter, or `{` and what is asked")?;
        let mut questions = Vec::new();
        while !self.closes() {
            questions.push(self.sweep_question()?);
        }
        Ok(Sweep { axes, questions })
    }

    fn axis(&mut self) -> Parse<(Ident, AxisKind)> {
        let name = match self.kind() {
            // As `param T` is.
            Kind::Upper => self.ident(),
            _ => self.small("the name of a parameter, as in `sweep k in 0 .. 1 step 1/10 { … }`")?,
        };
        self.word("in")?;
        if self.at(Kind::OpenSquare) {
            self.advance();
            let values = self.list(Kind::CloseSquare, "`,` or `]`", Parser::value)?;
            return Ok((name, AxisKind::List(values)));
        }
        let low = self.value()?;
        self.require(Kind::Dots, "`..` and the last value, or a list such as `[1, 2]`")?;
        let high = self.value()?;
        self.word("step")?;
        Ok((name, AxisKind::Range(Box::new([low, high, self.value()?]))))
    }

    fn sweep_question(&mut self) -> Parse<SweepQuestion> {
        let start = self.token().span.start;
        let kind = match self.kind() {
            Kind::Upper => {
                self.mark_line();
                return Ok(SweepQuestion::Criteria(self.ident()));
            }
            Kind::Word(Keyword::Prove) => {
                self.take(Role::Line);
                ItemKind::Prove(self.claim()?)
            }
            Kind::Word(Keyword::Probability) => {
                self.take(Role::Line);
                ItemKind::Probability(self.likelihood(None)?)
            }
            _ => return self.unexpected("`prove …`, `probability …`, the name of criteria, or `}`"),
        };
        Ok(SweepQuestion::Item(Box::new(Item { span: self.since(start), kind })))
    }

    fn mark_line(&mut self) {
        if let Some(role) = self.roles.get_mut(self.position) {
            *role = Role::Line;
        }
    }
}
