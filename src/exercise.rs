//! An exercise being done: a step at a time, each proved by the laws allowed, or answered with a run that contradicts it
//! and with what would make it right.

mod judge;
mod read;
mod show;

use crate::diagnostic::{Source, nearest, render_all};
use crate::kernel::Theory;
use crate::law::Connective;
use crate::lower::{Environment, Exercise};
use crate::name::Name;
use crate::parser::parse_step;
use crate::proof::Statement;
use crate::prove::{Answer as Proved, By, prove};
use crate::rewrite::Limits;
use crate::simplify::{alone, is_unit};
use crate::term::Term;

pub use read::read;

/// What can be typed.
pub const HELP: &str =
    "= {law} P      the next step: P, which follows by the law (`<= {law} P` where something is hidden)
P              the same, by the law that the exercise gives, or else by any that it allows
law, law       the laws of the next step, where the exercise gives the process
hint           the next hint
laws           the laws that may be used, in full
show           the goal, and the steps so far
undo           take the last step back
quit           leave
";

/// A step that was accepted.
#[derive(Clone, Debug)]
struct Done {
    connective: Connective,
    /// As named by the learner, or by the exercise.
    laws: Vec<Name>,
    /// Those by which it was proved.
    used: Vec<Name>,
    term: Term,
}

/// What came of a line.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Answer {
    /// For the person who typed it.
    pub text: String,
    /// Whether that person wants to leave.
    pub quit: bool,
    /// Whether the exercise is solved.
    pub solved: bool,
}

fn said(text: impl Into<String>) -> Answer {
    Answer { text: text.into(), ..Answer::default() }
}

/// An exercise being done.
pub struct Attempt {
    exercise: Exercise,
    environment: Environment,
    theory: Theory,
    done: Vec<Done>,
    hints: usize,
    solved: bool,
    colour: bool,
}

impl Attempt {
    /// At the beginning of an exercise, with what was declared before it.
    pub fn new(exercise: &Exercise, environment: &Environment, colour: bool) -> Attempt {
        let theory = Theory {
            assumptions: environment.assumptions.clone(),
            definitions: environment.definitions.clone(),
            laws: environment.laws.clone(),
        };
        let (exercise, environment) = (exercise.clone(), environment.clone());
        Attempt { exercise, environment, theory, done: Vec::new(), hints: 0, solved: false, colour }
    }

    /// Answers one line; `interrupted` is asked during long work.
    pub fn answer(&mut self, line: &str, interrupted: &dyn Fn() -> bool) -> Answer {
        let line = line.trim();
        let solved = self.solved;
        let mut answer = match line.trim_start_matches(':') {
            "" | "show" => said(self.show()),
            "help" | "?" => said(HELP),
            "quit" | "q" | "exit" => Answer { quit: true, ..Answer::default() },
            "hint" => said(self.hint()),
            "laws" => said(self.laws()),
            "undo" => match self.done.pop() {
                Some(_) => {
                    self.solved = false;
                    return said(self.show());
                }
                None => said("there is no step to take back\n"),
            },
            _ if solved => said("it is solved; `undo` takes the last step back, `quit` leaves\n"),
            _ => match self.read_step(line) {
                Ok(step) => self.take(step, interrupted),
                Err(why) => said(why),
            },
        };
        answer.solved = self.solved;
        answer
    }

    /// Where the calculation stands.
    fn current(&self) -> &Term {
        self.done.last().map_or(&self.exercise.left, |done| &done.term)
    }

    /// The gap that is next, as long as the steps so far reach what the exercise gives.
    fn gap(&self) -> Option<&crate::lower::Gap> {
        let mut given = self.done.iter().zip(&self.exercise.steps);
        let along = given.all(|(done, gap)| gap.term.as_ref().is_none_or(|term| *term == done.term));
        self.exercise.steps.get(self.done.len()).filter(|_| along)
    }

    fn hint(&mut self) -> String {
        match self.exercise.hints.get(self.hints) {
            Some(hint) => {
                self.hints += 1;
                format!("hint {} of {}: {hint}\n", self.hints, self.exercise.hints.len())
            }
            None if self.hints == 0 => "there are no hints for this exercise\n".to_string(),
            None => "there are no more hints\n".to_string(),
        }
    }

    /// What a line says the next step is.
    fn read_step(&self, line: &str) -> Result<Done, String> {
        let bare = line.strip_prefix('{').and_then(|rest| rest.strip_suffix('}')).unwrap_or(line);
        let words: Vec<Name> = bare.split(',').map(|word| Name::new(word.trim())).collect();
        let gap = self.gap();
        if words.iter().all(|word| self.theory.laws.get(word).is_some()) {
            let Some(term) = gap.and_then(|gap| gap.term.clone()) else {
                return Err(format!("the exercise does not give what comes next: write `= {{{bare}}} P`\n"));
            };
            let connective = gap.map_or(Connective::Equal, |gap| gap.connective);
            return self.allowed(Done { connective, laws: words, used: Vec::new(), term });
        }
        let render = |errors: &[_]| render_all(errors, &Source::new("<answer>", line), self.colour);
        let written = parse_step(line).map_err(|errors| render(&errors))?;
        let term = written.term.as_ref().ok_or_else(|| "a step needs a process\n".to_string())?;
        let term = self.environment.term(term).map_err(|errors| render(&errors))?;
        let laws = match &written.laws {
            Some(laws) => laws.iter().map(|law| law.name.clone()).collect(),
            None => gap.and_then(|gap| gap.laws.clone()).unwrap_or_default(),
        };
        let sign = line.starts_with(['=', '<', '≤']);
        let connective = gap.filter(|_| !sign).map_or(written.connective, |gap| gap.connective);
        self.allowed(Done { connective, laws, used: Vec::new(), term })
    }

    fn allowed(&self, step: Done) -> Result<Done, String> {
        for law in &step.laws {
            let Some(found) = self.theory.laws.get(law) else {
                let known = self.theory.laws.iter().map(|law| law.name.as_str());
                let near = nearest(law.as_str(), known).map(|name| format!("; did you mean `{name}`?"));
                return Err(format!("there is no law `{law}`{}\n", near.unwrap_or_default()));
            };
            if !self.exercise.laws.is_empty() && !self.exercise.laws.contains(law) && !is_unit(found) {
                return Err(format!("`{law}` is not among the laws of this exercise; `laws` shows them\n"));
            }
        }
        if !step.connective.gives(self.exercise.connective) {
            return Err("the goal is an equality, so no step may be `<=`\n".to_string());
        }
        if step.term == *self.current() {
            return Err("that is the process you have already (`;`, `|` and `#` need no brackets)\n".to_string());
        }
        Ok(step)
    }

    fn statement(&self, step: &Done) -> Statement {
        Statement {
            hypotheses: self.exercise.when.clone(),
            left: self.current().clone(),
            connective: step.connective,
            right: step.term.clone(),
        }
    }

    fn take(&mut self, step: Done, interrupted: &dyn Fn() -> bool) -> Answer {
        let laws = match self.judge(&step, interrupted) {
            Ok(laws) => laws,
            Err(why) => return said(why),
        };
        self.done.push(Done { used: laws.clone(), ..step });
        if self.current() != &self.exercise.right {
            let by: Vec<&str> = laws.iter().map(Name::as_str).collect();
            let by =
                if by.is_empty() { "by computing with values".to_string() } else { format!("by {}", by.join(", ")) };
            return said(format!("right, {by}\n{}", self.show()));
        }
        self.finish(interrupted)
    }

    /// The whole calculation, proved anew as one and checked by the kernel.
    fn finish(&mut self, interrupted: &dyn Fn() -> bool) -> Answer {
        let statement = Statement {
            hypotheses: self.exercise.when.clone(),
            left: self.exercise.left.clone(),
            connective: self.exercise.connective,
            right: self.exercise.right.clone(),
        };
        let lines: Vec<(Connective, Vec<Name>, Term)> =
            self.done.iter().map(|done| (done.connective, Vec::new(), done.term.clone())).collect();
        let theory = Theory { laws: alone(&self.theory.laws, &self.exercise.laws), ..self.theory.clone() };
        match prove(&theory, &statement, &By::Calculation(&lines), Limits::default(), interrupted) {
            Proved::Proved(theorem, _) => {
                self.solved = true;
                let laws: Vec<&str> = theorem.laws().iter().map(Name::as_str).collect();
                let steps = self.done.len();
                let count = if steps == 1 { "1 step".to_string() } else { format!("{steps} steps") };
                let road =
                    if self.exercise.steps.is_empty() || self.as_given() { "" } else { ", by a road of your own" };
                let by = if laws.is_empty() { String::new() } else { format!("\n  by {}", laws.join(", ")) };
                let trusted: String =
                    theorem.trusted().iter().map(|reason| format!("\n  on trust: {reason}")).collect();
                said(format!("{}solved in {count}{road}; checked by the kernel{by}{trusted}\n", self.calculation()))
            }
            Proved::Open(_) => {
                self.done.pop();
                said("each step was right, but the whole could not be proved; take this step in smaller ones\n")
            }
        }
    }

    /// Whether the steps are those that the exercise has, its gaps filled in.
    fn as_given(&self) -> bool {
        let same = |(done, gap): (&Done, &crate::lower::Gap)| {
            gap.term.as_ref().is_none_or(|term| *term == done.term)
                && gap.laws.as_ref().is_none_or(|laws| done.laws.is_empty() || *laws == done.laws)
        };
        self.done.len() == self.exercise.steps.len() && self.done.iter().zip(&self.exercise.steps).all(same)
    }
}
