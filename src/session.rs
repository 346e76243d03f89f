//! A session: numbered environments that never change, one input after the other, an answer to each.
//!
//! It reads no file and prints nothing: what surrounds it finds imports, says when to stop, and takes the answers.

mod abreast;
mod alike;
mod always;
pub(crate) mod beside;
mod cases;
mod claim;
mod compare;
mod contradiction;
pub(crate) mod course;
mod criteria;
pub(crate) mod delays;
mod digits;
mod drawn;
mod entered;
mod flow;
mod illustrate;
mod instances;
mod likely;
mod matched;
mod orders;
pub(crate) mod parts;
pub(crate) mod phases;
pub(crate) mod print;
mod question;
mod reading;
mod roughly;
mod rounds;
mod satisfies;
mod solve;
mod supposing;
mod sweep;
mod tolerance;

use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;
use std::sync::Arc;

use crate::assumption::Assumptions;
use crate::ast::ItemKind;
use crate::diagnostic::{Diagnostic, Source, Span};
use crate::explain::{Chain, chain};
use crate::kernel::{Theory, Thm};
use crate::law::Laws;
use crate::lexer::{Kind, lex};
use crate::library::{self, Failure, Reader, Unasked, segments};
use crate::lower::{self, Environment, Exercise};
use crate::name::Name;
use crate::parser::parse_input;
use crate::proof::Proof;
use crate::proof_file;
use crate::prove::{By, Earlier};
use crate::recurrence;
use crate::report::{Output, Report, Verdict};
use crate::stepper::Apart;
use crate::term::Term;

pub use alike::evidence_lines;
pub use sweep::{Plan, Plans, cores, plans};

use reading::Run;

/// What a session asks of the world around it.
pub trait Surroundings {
    /// The text that `importer` imports by this path.
    ///
    /// # Errors
    /// Why there is none.
    fn find(&self, importer: &str, path: &str) -> Result<Source, String>;

    /// Whether the user wants the current search to stop.
    fn interrupted(&self) -> bool;

    /// Whether claims are to come with pictures.
    fn pictures(&self) -> bool {
        false
    }

    /// Work on this begins.
    fn begins(&self, _what: &str) {}

    /// It has ended.
    fn ends(&self) {}
}

/// A session by itself: there are no other texts, and nobody stops it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Alone;

impl Surroundings for Alone {
    fn find(&self, _importer: &str, path: &str) -> Result<Source, String> {
        Err(format!("there is no file `{path}`"))
    }

    fn interrupted(&self) -> bool {
        false
    }
}

/// A proof with the theory in which the kernel accepted it.
#[derive(Clone)]
pub struct Evidence {
    /// What the proof stands on.
    pub theory: Theory,
    /// The declarations in force.
    pub environment: Environment,
    /// What was proved.
    pub theorem: Thm,
    /// How.
    pub proof: Proof,
}

impl Evidence {
    /// The chain of whole terms from one side of the claim to the other.
    pub fn chain(&self) -> Chain {
        chain(&self.theory, &self.proof)
    }
}

/// A claim that was made, for as long as the session lasts.
#[derive(Clone)]
pub struct Record {
    /// What came of it.
    pub report: Report,
    /// Its proof, if it was proved.
    pub evidence: Option<Arc<Evidence>>,
    /// Every name on which it depends.
    pub uses: BTreeSet<Name>,
    /// The name whose later definition made the verdict stale.
    pub stale: Option<Name>,
}

/// Everything that an input can change.
#[derive(Clone, Default)]
struct State {
    environment: Environment,
    records: Vec<Arc<Record>>,
    /// For each declared name, the names in its declarations; those of one item share them.
    uses: Arc<BTreeMap<Name, Vec<Arc<BTreeSet<Name>>>>>,
    it: Option<Term>,
    exercises: Arc<Vec<(Exercise, Environment)>>,
    /// What refuted the last claim that was refuted, or showed the last `no`.
    apart: Option<Arc<Apart>>,
    /// The last recurrence that was to be solved, with the number of claims before it.
    asked: Option<(usize, Arc<Asked>)>,
}

/// A recurrence with what was assumed.
struct Asked {
    question: lower::Question,
    known: Assumptions,
}

/// Takes each answer, with the record of the claim if it is one.
pub type Emit<'e> = dyn FnMut(&Output, Option<&Record>) + 'e;

/// A session.
pub struct Session {
    own: Laws,
    state: State,
    earlier: Vec<State>,
    surroundings: Rc<dyn Surroundings>,
}

impl Session {
    /// A session after the prelude.
    ///
    /// # Errors
    /// What is wrong with the texts that are part of the program; a test holds that nothing is.
    pub fn new(surroundings: Rc<dyn Surroundings>) -> Result<Session, Vec<Failure>> {
        let mut environment = library::standard()?;
        environment.keep_history();
        let own = environment.laws.clone();
        Ok(Session { own, state: State { environment, ..State::default() }, earlier: Vec::new(), surroundings })
    }

    /// What has been declared.
    pub fn environment(&self) -> &Environment {
        &self.state.environment
    }

    /// The laws that are part of the program.
    pub fn own_laws(&self) -> &Laws {
        &self.own
    }

    /// The claims made, in order.
    pub fn records(&self) -> &[Arc<Record>] {
        &self.state.records
    }

    /// Whether the user wants the current work to stop.
    pub fn interrupted(&self) -> bool {
        self.surroundings.interrupted()
    }

    /// The world around it.
    pub fn surroundings(&self) -> &dyn Surroundings {
        &*self.surroundings
    }

    /// The exercises, in order, each with what was declared before it.
    pub fn exercises(&self) -> &[(Exercise, Environment)] {
        &self.state.exercises
    }

    /// The two sides of the last counterexample, with the run that tells them apart.
    pub fn apart(&self) -> Option<&Apart> {
        self.state.apart.as_deref()
    }

    /// The induction behind the last `solve`, if no claim was made since; why there is none, where the forms are not known.
    pub fn induction(&self) -> Option<Vec<String>> {
        let (count, asked) = self.state.asked.as_ref()?;
        if *count != self.state.records.len() {
            return None;
        }
        let recurrence = asked.question.recurrence.clone();
        Some(match recurrence::solve_until(recurrence, &asked.known, &|| self.interrupted()) {
            Ok(solved) => solved.lines().into_iter().chain(solved.induction()).collect(),
            Err(reason) => vec![format!("there is no induction to show for all of it at once: {reason}")],
        })
    }

    /// The last process that was simplified or found.
    pub fn it(&self) -> Option<&Term> {
        self.state.it.as_ref()
    }

    /// The number of the current environment: of inputs that changed something.
    pub fn number(&self) -> usize {
        self.earlier.len()
    }

    /// Goes back to before the last input; false if there is none.
    pub fn undo(&mut self) -> bool {
        match self.earlier.pop() {
            Some(state) => {
                self.state = state;
                true
            }
            None => false,
        }
    }

    /// The proof file of a claim that was proved.
    ///
    /// # Errors
    /// Why it cannot be written.
    pub fn proof_file(&self, evidence: &Evidence) -> Result<String, String> {
        let written = proof_file::write(&evidence.environment, &evidence.theory, &self.own, &evidence.proof);
        let text = written.map_err(|error| error.to_string())?;
        // A file has limits that a proof in memory has not: of what is written all can be checked.
        match proof_file::check_file(text.as_bytes()) {
            Ok(_) => Ok(text),
            Err(rejection) => Err(format!("a proof is not written, since `pars check` would reject it: {rejection}")),
        }
    }

    /// Runs a whole text with all that it imports.
    pub fn run(&mut self, source: &Source, emit: &mut Emit<'_>) {
        self.earlier.push(self.state.clone());
        self.read(source, emit);
    }

    fn read(&mut self, source: &Source, emit: &mut Emit<'_>) {
        let mut environment = std::mem::take(&mut self.state.environment);
        let surroundings = self.surroundings.clone();
        let finder = surroundings.clone();
        let reader = Reader::new(move |importer: &str, path: &str| match library::embedded(path) {
            // In force since the session began.
            Some(source) => Ok(Source::new(source.name, "")),
            None => finder.find(importer, path),
        });
        let watching = self.surroundings.clone();
        let mut reader = reader.until(move || watching.interrupted());
        surroundings.begins(&format!("reading {}", source.name));
        let mut run = Run::new(&mut self.state, &self.own, &*surroundings, &environment, emit);
        run.keep();
        let failures = reader.read(&mut environment, source, &mut |environment, source, item, lowered| {
            run.visit(environment, source, item, lowered);
        });
        surroundings.ends();
        run.stop(reader.stopped());
        run.finish();
        run.show_kept(failures);
        self.state.environment = environment;
    }

    /// Runs one input at the prompt: items, or one term alone. `it` is the last result.
    pub fn input(&mut self, name: &str, text: &str, emit: &mut Emit<'_>) {
        let text = self.with_it(text);
        let source = Source::new(name, text);
        let parsed = parse_input(&source.text);
        self.earlier.push(self.state.clone());
        if !parsed.diagnostics.is_empty() {
            emit(&Output::Trouble(source, parsed.diagnostics), None);
            self.earlier.pop();
            return;
        }
        for segment in segments(&parsed.items) {
            if let [crate::ast::Item { kind: ItemKind::Import(_), span }] = segment {
                let import = Source::new(name, span.of(&source.text));
                self.read(&import, emit);
                continue;
            }
            self.segment(&source, segment, emit);
        }
    }

    fn segment(&mut self, source: &Source, segment: &[crate::ast::Item], emit: &mut Emit<'_>) {
        let mut environment = std::mem::take(&mut self.state.environment);
        let surroundings = self.surroundings.clone();
        let mut run = Run::new(&mut self.state, &self.own, &*surroundings, &environment, emit);
        let watching = || surroundings.interrupted();
        surroundings.begins("declarations");
        let before = environment.clone();
        let batch = environment.open_until(segment, &source.text, &watching);
        let mut stopped = batch.is_none();
        let mut batch = batch.unwrap_or_default();
        let mut unasked = Unasked::default();
        for (index, item) in segment.iter().enumerate() {
            stopped |= index > 0 && watching();
            if stopped {
                break;
            }
            let lowered = environment.step_until(&mut batch, index, item, &watching);
            if unasked.passes_over(item, lowered.is_ok()) {
                continue;
            }
            match lowered {
                Ok(lowered) => run.visit(&mut environment, source, item, lowered),
                Err(diagnostics) => run.trouble(source, diagnostics),
            }
        }
        surroundings.ends();
        let undone = run.stop(stopped);
        run.finish();
        self.state.environment = if undone { before } else { environment };
    }

    /// The text with the last result for `it`, unless something is declared by that name.
    fn with_it(&self, text: &str) -> String {
        let (Some(it), None) = (&self.state.it, self.state.environment.quantity(&Name::new("it"))) else {
            return text.to_string();
        };
        let lexed = lex(text);
        let mut out = String::with_capacity(text.len());
        let mut end = 0;
        for token in lexed.tokens.iter().filter(|token| token.kind == Kind::Lower && token.span.of(text) == "it") {
            out.push_str(Span::new(end, token.span.start).of(text));
            out.push_str(&format!("({it})"));
            end = token.span.end;
        }
        out.push_str(Span::new(end, text.len()).of(text));
        out
    }

    /// The claim of this number, or of this name; the last one when nothing is said.
    pub fn record(&self, which: &str) -> Option<&Record> {
        let records = &self.state.records;
        let found = if which.is_empty() {
            records.last()
        } else if let Ok(number) = which.parse::<usize>() {
            number.checked_sub(1).and_then(|index| records.get(index))
        } else {
            let named = |record: &&Arc<Record>| record.report.name.as_ref().is_some_and(|name| name.as_str() == which);
            records.iter().rev().find(named)
        };
        found.map(Arc::as_ref)
    }
}

impl State {
    /// Every name on which the names depend, through declarations.
    fn closure(&self, names: BTreeSet<Name>) -> BTreeSet<Name> {
        let mut found = BTreeSet::new();
        let mut seen = BTreeSet::new();
        let mut rest: Vec<Name> = names.into_iter().collect();
        while let Some(name) = rest.pop() {
            if let Some(uses) = self.uses.get(&name).filter(|_| !found.contains(&name)) {
                let new = uses.iter().filter(|uses| seen.insert(Arc::as_ptr(uses)));
                rest.extend(new.flat_map(|uses| uses.iter().cloned()));
            }
            found.insert(name);
        }
        found
    }

    /// The theorems that a claim names as if they were laws.
    ///
    /// # Errors
    /// The first that is no theorem, and why.
    fn earlier(&self, by: &By<'_>, theory: &Theory) -> Result<Vec<Earlier>, (Name, String)> {
        let named: BTreeSet<&Name> = match by {
            By::Search => BTreeSet::new(),
            By::Laws(names) => names.iter().collect(),
            By::Calculation(lines) => lines.iter().flat_map(|(_, names, _)| names).collect(),
        };
        let mut found = Vec::new();
        for name in named.into_iter().filter(|name| theory.laws.get(name).is_none()) {
            let refuse = |why: &str| Err((name.clone(), why.to_string()));
            let record = self.records.iter().rev().find(|record| record.report.name.as_ref() == Some(name));
            let Some(record) = record else { return refuse("there is no such claim") };
            match &record.evidence {
                Some(_) if record.stale.is_some() => return refuse("it is stale: what it speaks of was defined anew"),
                Some(evidence) => found.push(Earlier { name: name.clone(), proof: evidence.proof.clone() }),
                None => return refuse("it is not proved"),
            }
        }
        Ok(found)
    }

    /// Marks what depends on a name that was defined anew; gives the claims that are stale now.
    fn mark_stale(&mut self, name: &Name) -> Vec<String> {
        let mut stale = Vec::new();
        for record in &mut self.records {
            if record.stale.is_none() && record.report.verdict != Verdict::Open && record.uses.contains(name) {
                Arc::make_mut(record).stale = Some(name.clone());
                stale.push(match &record.report.name {
                    Some(own) => own.to_string(),
                    None => record.report.number.to_string(),
                });
            }
        }
        stale
    }
}

/// A diagnostic at a place of a text.
fn at(code: &'static str, message: impl Into<String>, span: Span, text: &str) -> Diagnostic {
    Diagnostic::error(code, message).label(span, text)
}
