//! What is typed, answered: an item of the language, a term, or a command that begins with `:`.

use std::rc::Rc;

use super::command;
use super::waiting::{Turn, Waiting};
use crate::diagnostic::{Severity, Source};
use crate::exercise::Attempt;
use crate::report::{Output, PROMPT, worse};
use crate::script::{Printer, complain};
use crate::session::{Session, Surroundings};
use crate::stepper::Apart;
use crate::walk::{Origin, Walk};

/// What came of an input.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Reply {
    /// What was printed.
    pub text: String,
    /// Whether the user wants to leave.
    pub quit: bool,
}

/// A session at the prompt.
pub struct Prompt {
    session: Session,
    colour: bool,
    printer: Printer,
    /// The inputs that changed the session, in step with its numbers.
    inputs: Vec<String>,
    shown: String,
    /// The process that is stepped, while one is.
    walk: Option<Walk>,
    /// The exercise that is being done, while one is.
    attempt: Option<Attempt>,
    /// Declarations that mention what is not declared yet.
    waiting: Waiting,
}

impl Prompt {
    /// A prompt with a new session.
    ///
    /// # Errors
    /// What is wrong with the texts that are part of the program.
    pub fn new(surroundings: Rc<dyn Surroundings>, colour: bool) -> Result<Prompt, String> {
        let session = Session::new(surroundings).map_err(|failures| {
            let texts: Vec<String> = failures
                .iter()
                .map(|one| Output::Trouble(one.source.clone(), one.diagnostics.clone()).text(colour))
                .collect();
            texts.concat()
        })?;
        Ok(Prompt {
            session,
            colour,
            printer: Printer::default(),
            inputs: Vec::new(),
            shown: String::new(),
            walk: None,
            attempt: None,
            waiting: Waiting::default(),
        })
    }

    /// The same prompt, but what it answers is in the replies alone.
    pub fn quiet(self) -> Prompt {
        Prompt { printer: Printer::closed(), ..self }
    }

    /// The session.
    pub fn session(&self) -> &Session {
        &self.session
    }

    pub(super) fn inputs(&self) -> &[String] {
        &self.inputs
    }

    pub(super) fn colour(&self) -> bool {
        self.colour
    }

    /// Prints a text.
    pub fn print(&mut self, text: &str) {
        self.shown.push_str(text);
        self.printer.print(text);
    }

    /// Answers one input; what is printed is also in the reply.
    pub fn answer(&mut self, line: &str) -> Reply {
        self.shown.clear();
        let text = line.trim();
        let mut quit = false;
        if let Some(walk) = &mut self.walk {
            let answer = walk.answer(text);
            if answer.quit {
                self.walk = None;
            }
            self.print(&answer.text);
        } else if let Some(attempt) = &mut self.attempt {
            let session = &self.session;
            let answer = attempt.answer(text, &|| session.interrupted());
            if answer.quit || answer.solved {
                self.attempt = None;
            }
            self.print(&answer.text);
        } else if let Some(path) = text.strip_prefix("lint ") {
            let text = command::lint(self, path.trim());
            self.print(&text);
        } else if let Some(subject) = text.strip_prefix("step").filter(|rest| rest.is_empty() || rest.starts_with(' '))
        {
            self.walk(subject);
        } else if let Some(command) = text.strip_prefix(':') {
            quit = command::run(self, command);
        } else if !text.is_empty() {
            self.input(line);
        }
        Reply { text: std::mem::take(&mut self.shown), quit }
    }

    /// An input of the language: it may wait for what it mentions, or be what others waited for.
    fn input(&mut self, line: &str) {
        match self.waiting.take(self.session.environment(), line) {
            Turn::Wait(text) => self.print(&text),
            Turn::Run(text) => {
                let before = self.session.number();
                self.run(&text, |session, emit| session.input(PROMPT, &text, emit));
                if self.session.number() == before {
                    let lines = self.waiting();
                    self.print(&lines);
                }
            }
        }
    }

    /// Who still waits for whom, a line each.
    pub(super) fn waiting(&self) -> String {
        self.waiting.lines(self.session.environment()).into_iter().map(|line| line + "\n").collect()
    }

    /// Runs something in the session, prints what it answers, and keeps the input if something came of it.
    pub(super) fn run(&mut self, input: &str, work: impl FnOnce(&mut Session, &mut crate::session::Emit<'_>)) {
        let before = self.session.number();
        let (colour, printer, shown) = (self.colour, &mut self.printer, &mut self.shown);
        let mut useful = false;
        work(&mut self.session, &mut |output, _| {
            let wrong = |one: &crate::diagnostic::Diagnostic| one.severity == Severity::Error;
            useful |= !matches!(output, Output::Trouble(_, diagnostics) if diagnostics.iter().any(wrong));
            let mut text = output.text(colour);
            if output.apart().is_some() {
                text.push_str("    `:step` takes this run into the stepper\n");
            }
            shown.push_str(&text);
            printer.print(&text);
        });
        if self.session.number() > before {
            if useful {
                self.inputs.truncate(before);
                self.inputs.push(input.trim().to_string());
            } else {
                self.session.undo();
            }
        }
    }

    /// Runs a script, with its answers where those of a script go; gives its exit code.
    pub(super) fn script(&mut self, source: &Source) -> u8 {
        if source.text.trim().is_empty() {
            return 0;
        }
        let (colour, printer, mut code) = (self.colour, &mut self.printer, 0);
        self.session.run(source, &mut |output, _| {
            code = worse(code, output.exit_code());
            match output {
                Output::Declared(_) => {}
                Output::Trouble(..) => complain(&output.text(colour)),
                _ => printer.print(&output.text(colour)),
            }
        });
        self.inputs.truncate(self.session.number().saturating_sub(1));
        self.inputs.push(source.text.trim().to_string());
        code
    }

    /// Whether a process is being stepped, or an exercise done: then a line is a step.
    pub fn stepping(&self) -> bool {
        self.walk.is_some() || self.attempt.is_some()
    }

    /// What asks for the next line.
    pub fn sign(&self) -> &'static str {
        match (&self.walk, &self.attempt) {
            (Some(_), _) => "step> ",
            (None, Some(_)) => "exercise> ",
            (None, None) => "pars> ",
        }
    }

    /// Begins an exercise; lists them when none is named.
    pub(super) fn exercise(&mut self, name: &str) {
        let exercises = self.session.exercises();
        let found = exercises.iter().rev().find(|(exercise, _)| exercise.name.as_str() == name);
        let text = match found {
            Some((exercise, environment)) => {
                let attempt = Attempt::new(exercise, environment, self.colour);
                let text = attempt.show() + "`help` lists what can be typed, `quit` leaves the exercise\n";
                self.attempt = Some(attempt);
                text
            }
            None if exercises.is_empty() => "there are no exercises here; `:load FILE` reads some\n".to_string(),
            None => {
                let known = exercises.iter().map(|(one, _)| format!("{:<18} {}\n", one.name.as_str(), one.title));
                let list: String = known.collect();
                if name.is_empty() { list } else { format!("there is no exercise `{name}`:\n{list}") }
            }
        };
        self.print(&text);
    }

    /// Begins to step a process: one that is named or written, or a side of the last counterexample, along its run.
    pub(super) fn walk(&mut self, subject: &str) {
        let subject = subject.trim();
        if let "" | "left" | "right" = subject {
            let text = match self.session.apart().cloned() {
                Some(apart) => self.walk_along(&apart, subject),
                None => "say what to step: a process, or the name of a system; when a claim was refuted, or a \
                         comparison answered with `no`, `:step` takes its run into the stepper\n"
                    .to_string(),
            };
            return self.print(&text);
        }
        let text = match Walk::new(self.session.environment(), subject, Origin::Prompt, self.colour) {
            Ok(mut walk) => {
                let text = walk.opening();
                self.walk = Some(walk);
                text + "`help` lists what can be typed, `quit` leaves the run\n"
            }
            Err(why) => why,
        };
        self.print(&text);
    }

    fn walk_along(&mut self, apart: &Apart, side: &str) -> String {
        let right = side == "right" || (side.is_empty() && apart.right_first);
        let (route, side, other) = if right { (&apart.right, "right", "left") } else { (&apart.left, "left", "right") };
        match Walk::along(self.session.environment(), route, self.colour) {
            Ok(mut walk) => {
                let head =
                    format!("the {side} side of the last counterexample, along its run (`:step {other}`: the other)\n");
                let text = head + &walk.opening() + "`help` lists what can be typed, `quit` leaves the run\n";
                self.walk = Some(walk);
                text
            }
            Err(why) => why,
        }
    }

    /// Forgets the last input, first of those that wait; false if there is none.
    pub(super) fn undo(&mut self) -> bool {
        if self.waiting.forget() {
            return true;
        }
        self.inputs.pop();
        self.session.undo()
    }
}
