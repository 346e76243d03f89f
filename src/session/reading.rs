//! Item after item: what is declared is noted, what is asked waits for the expectations behind it.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::{Emit, Record, State, Surroundings, at};
use crate::admission::admit;
use crate::ast::{Item, Limits};
use crate::diagnostic::{Diagnostic, Source, Span};
use crate::law::{Law, Laws};
use crate::lexer::{Kind, lex};
use crate::library::Failure;
use crate::lower::{By, Claim, ClaimKind, Environment, Exercise, Expectation, Likelihood, Lowered, Subject};
use crate::name::Name;
use crate::preorder::Preorder;
use crate::report::{Expected, Output};
use crate::simplify::alone;
use crate::value::Value;

/// A question.
pub(super) enum Question {
    /// `prove …`
    Claim(Claim),
    /// `simplify P`
    Simplify(crate::term::Term),
    /// `period Sys`
    Period(Name),
    /// `flow Sys`
    Flow(Name),
    /// `solve …`
    Solve(Box<crate::lower::Question>),
    /// `probability of …`
    Probability(Likelihood),
    /// `criteria …`
    Criteria(Box<crate::lower::Criteria>),
    /// `sweep …`
    Sweep(Box<crate::lower::Sweep>),
    /// `project P to {…}`
    Project(Subject, BTreeSet<Name>),
    /// `lts P`
    Lts(Subject, Limits),
    /// `minimise P`
    Minimise(Subject, Limits),
    /// `compare P ~ Q`
    Alike(Subject, Subject, Preorder, Limits),
}

impl Question {
    /// Whether it is answered by a transition system.
    fn is_about_systems(&self) -> bool {
        matches!(self, Question::Lts(..) | Question::Minimise(..) | Question::Alike(..))
    }
}

/// A question that waits for what is expected of it.
pub(super) struct Waiting {
    pub(super) question: Question,
    pub(super) environment: Environment,
    pub(super) source: Source,
    pub(super) span: Span,
    pub(super) file: String,
    pub(super) line: usize,
    pub(super) text: String,
    pub(super) expected: Vec<(Expectation, String)>,
}

/// What is expected, as it is written behind the word.
pub(super) fn expected_text(source: &Source, span: Span) -> String {
    span.of(&source.text).trim().trim_start_matches("expect").trim().to_string()
}

/// Values that are expected together as values by themselves, each as it is written.
fn each_by_itself(expectation: Expectation, text: String) -> Vec<(Expectation, String)> {
    let Expectation::Values(values) = &expectation else { return vec![(expectation, text)] };
    let (mut depth, mut parts) = (0i32, vec![String::new()]);
    for letter in text.chars() {
        match letter {
            '(' | '{' | '[' => depth += 1,
            ')' | '}' | ']' => depth -= 1,
            _ => {}
        }
        match parts.last_mut() {
            _ if letter == ',' && depth == 0 => parts.push(String::new()),
            Some(part) => part.push(letter),
            None => {}
        }
    }
    if parts.len() != values.len() {
        return vec![(expectation, text)];
    }
    let single =
        |(value, part): (&(Name, Value), String)| (Expectation::Values(vec![value.clone()]), part.trim().to_string());
    values.iter().zip(parts).map(single).collect()
}

/// One text, or one input, being run.
pub(super) struct Run<'r, 'e> {
    pub(super) state: &'r mut State,
    pub(super) own: &'r Laws,
    pub(super) surroundings: &'r dyn Surroundings,
    emit: &'r mut Emit<'e>,
    waiting: Option<Waiting>,
    laws: Laws,
    place: (String, usize, usize),
    stopped: bool,
    /// How much was wrong so far.
    wrong: usize,
    /// What is wrong, while it is kept to be shown in the order of the text.
    kept: Option<Vec<Failure>>,
}

/// The most of what is wrong in one text that is shown.
const MOST_WRONG: usize = 100;

impl<'r, 'e> Run<'r, 'e> {
    pub(super) fn new(
        state: &'r mut State,
        own: &'r Laws,
        surroundings: &'r dyn Surroundings,
        environment: &Environment,
        emit: &'r mut Emit<'e>,
    ) -> Run<'r, 'e> {
        let laws = environment.laws.clone();
        let place = (String::new(), 0, 1);
        Run { state, own, surroundings, emit, waiting: None, laws, place, stopped: false, wrong: 0, kept: None }
    }

    pub(super) fn emit(&mut self, output: &Output, record: Option<&Record>) {
        (self.emit)(output, record);
    }

    /// Takes in a law, or leaves it out where it does not hold.
    fn admitted(&mut self, environment: &mut Environment, source: &Source, law: &Law, span: Span) {
        let interrupted = || self.surroundings.interrupted();
        match admit(&self.laws, law, span, &interrupted) {
            Ok(warning) => {
                self.laws = environment.laws.clone();
                self.trouble(source, warning.into_iter().collect());
            }
            Err(diagnostic) => {
                environment.laws = self.laws.clone();
                self.trouble(source, vec![*diagnostic]);
            }
        }
    }

    /// Takes one item.
    pub(super) fn visit(&mut self, environment: &mut Environment, source: &Source, item: &Item, lowered: Lowered) {
        if self.stopped {
            return;
        }
        if let Lowered::Expect(expectation) = lowered {
            self.expect(environment, source, item.span, expectation);
            return;
        }
        self.finish();
        let allowed = if let Lowered::Exercise(exercise) = &lowered { Some(exercise.laws.clone()) } else { None };
        let question = match lowered {
            Lowered::Claim(claim) => Question::Claim(claim),
            Lowered::Simplify(term) => Question::Simplify(term),
            Lowered::Period(name) => Question::Period(name),
            Lowered::Flow(name) => Question::Flow(name),
            Lowered::Solve(solve) => Question::Solve(solve),
            Lowered::Probability(likelihood) => Question::Probability(likelihood),
            Lowered::Criteria(criteria) => Question::Criteria(criteria),
            Lowered::Sweep(sweep) => Question::Sweep(sweep),
            Lowered::Project(subject, shown) => Question::Project(subject, shown),
            Lowered::Exercise(exercise) => Question::Claim(self.exercise(environment, exercise, item.span)),
            Lowered::Lts(subject, limits) => Question::Lts(subject, limits),
            Lowered::Minimise(subject, limits) => Question::Minimise(subject, limits),
            Lowered::Alike(left, right, relation, limits) => Question::Alike(left, right, relation, limits),
            Lowered::Declared { names, redefined, notes } => {
                self.declared(source, item.span, names, &redefined);
                return notes.into_iter().for_each(|note| self.emit(&Output::Note(note), None));
            }
            Lowered::Law(law) => return self.admitted(environment, source, &law, item.span),
            Lowered::Expect(_) | Lowered::Import(_) => return,
        };
        let text = match &question {
            Question::Claim(claim) => claim.text.trim().to_string(),
            _ => item.span.of(&source.text).trim().to_string(),
        };
        let line = self.line(source, item.span.start);
        let mut environment = environment.clone();
        if let Some(laws) = allowed {
            environment.laws = alone(&environment.laws, &laws);
        }
        if let Question::Claim(Claim { kind: ClaimKind::Satisfies { property, .. }, .. }) = &question {
            environment.show_named(property);
        }
        if let Question::Claim(Claim { kind: ClaimKind::Always { pattern, .. }, .. }) = &question {
            environment.show_instances(&pattern.observers());
        }
        // The places of a calculation's steps are looked up in the whole text.
        let calculated = match &question {
            Question::Claim(claim) => by_lines(claim),
            question => question.is_about_systems(),
        };
        let shown = if calculated { source.clone() } else { Source::default() };
        let file = source.name.clone();
        let (expected, span) = (Vec::new(), item.span);
        self.waiting = Some(Waiting { question, environment, source: shown, span, file, line, text, expected });
    }

    /// Keeps an exercise; what it asks to show must be provable by the laws that it allows.
    fn exercise(&mut self, environment: &Environment, exercise: Exercise, span: Span) -> Claim {
        let kind = ClaimKind::Compare {
            left: exercise.left.clone(),
            right: exercise.right.clone(),
            connective: exercise.connective,
            when: exercise.when.clone(),
            by: By::Search,
        };
        let text = format!("prove {}: {} {} {}", exercise.name, exercise.left, exercise.connective, exercise.right);
        let claim = Claim { name: Some(exercise.name.clone()), span, text, kind };
        Arc::make_mut(&mut self.state.exercises).push((exercise, environment.clone()));
        claim
    }

    /// The line of a place; places come in order, so that a long text is read once.
    fn line(&mut self, source: &Source, offset: usize) -> usize {
        let (name, before, line) = &mut self.place;
        if *name != source.name || offset < *before {
            (*name, *before, *line) = (source.name.clone(), 0, 1);
        }
        let between = source.text.as_bytes().get(*before..offset).unwrap_or(&[]);
        *line += between.iter().filter(|byte| **byte == b'\n').count();
        *before = offset;
        *line
    }

    fn expect(&mut self, environment: &Environment, source: &Source, span: Span, expectation: Expectation) {
        let text = expected_text(source, span);
        if let Some(waiting) = &mut self.waiting {
            match &waiting.question {
                // Each is right or wrong by itself.
                Question::Period(_) | Question::Flow(_) | Question::Solve(_) => {
                    waiting.expected.extend(each_by_itself(expectation, text));
                }
                _ => waiting.expected.push((expectation, text)),
            }
            return;
        }
        // At the prompt an expectation may come in an input of its own.
        let Some(last) = self.state.records.last().cloned() else {
            let diagnostic = at("P0901", "there is nothing here of which this could be expected", span, "here");
            self.trouble(source, vec![diagnostic.help("`expect` stands right behind a claim or a question")]);
            return;
        };
        let mut record = (*last).clone();
        record.report.expected = super::claim::expectations(&record.report, environment, &[(expectation, text)]);
        self.emit(&Output::Claim(Box::new(record.report.clone())), Some(&record));
    }

    fn declared(&mut self, source: &Source, span: Span, names: Vec<Name>, redefined: &[Name]) {
        let used = Arc::new(names_in(span.of(&source.text)));
        let uses = Arc::make_mut(&mut self.state.uses);
        for name in &names {
            // Parameters are declared again and again; what was known of them stays.
            let known = uses.entry(name.clone()).or_default();
            if !known.contains(&used) {
                known.push(used.clone());
            }
        }
        let own: BTreeSet<&Name> = names.iter().collect();
        for name in redefined {
            let stale = self.state.mark_stale(name);
            let keepers: Vec<&str> = self
                .state
                .uses
                .iter()
                .filter(|_| is_value(name))
                .filter(|(user, uses)| !own.contains(user) && uses.iter().any(|used| used.contains(name)))
                .map(|(user, _)| user.as_str())
                .collect();
            if !keepers.is_empty() {
                let text =
                    format!("{} still has the earlier {name}: define it again to change that", keepers.join(", "));
                self.emit(&Output::Note(text), None);
            }
            if !stale.is_empty() {
                let (which, are) = if stale.len() == 1 { ("claim", "is") } else { ("claims", "are") };
                let text =
                    format!("{which} {} {are} stale: settled with an earlier definition of {name}", stale.join(", "));
                self.emit(&Output::Note(text), None);
            }
        }
        self.emit(&Output::Declared(names), None);
    }

    /// Answers nothing more if the reading was interrupted, and says so, unless it was an answer that was; whether it did.
    pub(super) fn stop(&mut self, interrupted: bool) -> bool {
        let news = interrupted && !self.stopped;
        if news {
            self.stopped = true;
            self.emit(&Output::Note("interrupted: what was not read yet is not declared".to_string()), None);
        }
        news
    }

    /// Keeps from now on what is wrong.
    pub(super) fn keep(&mut self) {
        self.kept = Some(Vec::new());
    }

    /// Shows what is wrong in a text that has been read and what was kept, file by file in the order of their lines.
    pub(super) fn show_kept(&mut self, failures: Vec<Failure>) {
        let mut files: Vec<Failure> = Vec::new();
        for one in failures.into_iter().chain(self.kept.take().unwrap_or_default()) {
            match files.iter_mut().find(|file| file.source.name == one.source.name) {
                Some(file) => file.diagnostics.extend(one.diagnostics),
                None => files.push(one),
            }
        }
        for mut file in files {
            file.diagnostics.sort_by_key(|one| one.labels.first().map_or(0, |label| label.span.start));
            self.trouble(&file.source, file.diagnostics);
        }
        self.unshown();
    }

    /// Shows what is wrong, errors before warnings where it is too much to show all.
    pub(super) fn trouble(&mut self, source: &Source, mut diagnostics: Vec<Diagnostic>) {
        if let Some(kept) = &mut self.kept {
            return kept.push(Failure { source: source.clone(), diagnostics });
        }
        let room = MOST_WRONG.saturating_sub(self.wrong);
        self.wrong += diagnostics.len();
        if diagnostics.len() > room {
            diagnostics.sort_by_key(|one| one.severity);
            diagnostics.truncate(room);
        }
        if !diagnostics.is_empty() {
            self.emit(&Output::Trouble(source.clone(), diagnostics), None);
        }
    }

    /// Says how much was wrong besides what was shown.
    pub(super) fn unshown(&mut self) {
        if let more @ 1.. = self.wrong.saturating_sub(MOST_WRONG) {
            self.emit(&Output::Note(format!("{more} more are not shown")), None);
        }
    }

    /// Answers the question that waits, if one does.
    pub(super) fn finish(&mut self) {
        let Some(waiting) = self.waiting.take() else { return };
        if self.stopped {
            return;
        }
        self.surroundings.begins(waiting.text.lines().next().unwrap_or(""));
        let (output, record) = match &waiting.question {
            Question::Claim(claim) => {
                let mut record = self.claim(claim, &waiting);
                self.illustrate(&mut record.report, &waiting);
                (Output::Claim(Box::new(record.report.clone())), Some(record))
            }
            Question::Criteria(criteria) => {
                let mut record = self.criteria(criteria, &waiting);
                self.illustrate(&mut record.report, &waiting);
                (Output::Claim(Box::new(record.report.clone())), Some(record))
            }
            Question::Sweep(sweep) => (Output::Answer(Box::new(self.sweep(sweep, &waiting))), None),
            _ => (self.question(&waiting), None),
        };
        self.surroundings.ends();
        self.stopped = self.surroundings.interrupted();
        if let Some(apart) = output.apart() {
            self.state.apart = Some(apart.clone());
        }
        match output {
            Output::Trouble(source, diagnostics) => self.trouble(&source, diagnostics),
            output => self.emit(&output, record.as_ref()),
        }
        if let Some(record) = record {
            self.state.records.push(Arc::new(record));
        }
    }

    /// The expectations of a question with a term for an answer.
    pub(super) fn unmet(expected: &[(Expectation, String)]) -> Vec<Expected> {
        expected.iter().map(|(_, text)| Expected { text: text.clone(), met: false }).collect()
    }
}

fn by_lines(claim: &Claim) -> bool {
    matches!(&claim.kind, ClaimKind::Compare { by: By::Calc(_), .. })
}

fn is_value(name: &Name) -> bool {
    !name.as_str().starts_with(char::is_uppercase)
}

/// Every name that is written in a text.
pub(super) fn names_in(text: &str) -> BTreeSet<Name> {
    let lexed = lex(text);
    let names = lexed.tokens.iter().filter(|token| matches!(token.kind, Kind::Upper | Kind::Lower));
    names.map(|token| Name::new(token.span.of(text))).collect()
}
