//! `sweep k in 0 .. 1 step 1/10 { … }`: what is asked, asked at each point, on all cores.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc;
use std::time::Duration;

use super::likely::chances;
use super::reading::expected_text;
use super::reading::{Run, Waiting};
use super::roughly::closely;
use super::{State, Surroundings};
use crate::admission::admit;
use crate::ast::SweepQuestion;
use crate::criteria::{Judge, SOME_STRETCHES, near};
use crate::diagnostic::Source;
use crate::law::Laws;
use crate::library::{self, Failure, Reader};
use crate::lower::{Environment, Expectation, Lowered, Sweep};
use crate::report::{Answer, Expected};
use crate::sweep::{Cell, Column, FEASIBLE, FORMAT, Head, Kind, Row, counts, readable, region, summary};
use crate::term::room;
use crate::value::Value;

/// The stack of a worker, as large as that of the program.
const STACK: usize = 256 << 20;

/// A sweep with all that it is asked in.
pub struct Plan {
    sweep: Sweep,
    environment: Environment,
    own: Laws,
    columns: Vec<Column>,
    expected: Vec<(Expectation, String)>,
}

/// What a point answers to one question.
struct Part {
    verdict: Option<&'static str>,
    cells: Vec<Cell>,
}

impl Plan {
    /// A plan.
    pub fn new(sweep: &Sweep, environment: &Environment, own: &Laws) -> Plan {
        let mut plan = Plan {
            sweep: sweep.clone(),
            environment: environment.clone(),
            own: own.clone(),
            columns: Vec::new(),
            expected: Vec::new(),
        };
        plan.columns = plan.headings();
        plan
    }

    /// What the sweep is, for a part of it; `input` is the hash of all that it depends on.
    pub fn head(&self, input: String, shard: (usize, usize)) -> Head {
        let text = |values: &Vec<num_rational::BigRational>| {
            values.iter().map(|value| Value::rational(value.clone()).to_string()).collect()
        };
        let axes = self.sweep.axes.iter().map(|(name, values)| (name.to_string(), text(values))).collect();
        let format = FORMAT.to_string();
        Head { format, input, points: self.sweep.points(), shard, axes, columns: self.columns.clone() }
    }

    /// What came of the expectations that stand behind it, once all points are answered.
    pub fn expectations(&self, head: &Head, rows: &[Row]) -> Vec<Expected> {
        expectations(&self.expected, head, rows)
    }

    fn headings(&self) -> Vec<Column> {
        let column = |name: String, kind: Kind| Column { name, kind };
        let mut all = Vec::new();
        for (name, _) in &self.sweep.axes {
            all.push(column(name.to_string(), Kind::Axis));
            all.push(column(format!("{name}_rounded"), Kind::Number));
        }
        all.push(column(FEASIBLE.to_string(), Kind::Verdict));
        for (number, question) in self.sweep.written.questions.iter().enumerate() {
            let number = number + 1;
            match question {
                SweepQuestion::Criteria(name) => {
                    all.push(column(name.name.to_string(), Kind::Verdict));
                    let written = self.environment.criteria_of(&name.name);
                    let criteria = written.and_then(|written| self.environment.criteria(written).ok());
                    for criterion in criteria.iter().flat_map(|criteria| &criteria.all) {
                        for what in ["", "_margin"] {
                            let name = format!("{}_{}{what}", name.name, criterion.name);
                            all.push(column(name.clone(), Kind::Text));
                            all.push(column(format!("{name}_rounded"), Kind::Number));
                        }
                    }
                }
                SweepQuestion::Item(item) => match &item.kind {
                    crate::ast::ItemKind::Prove(claim) => {
                        let name = claim.name.as_ref().map_or(format!("claim{number}"), |name| name.name.to_string());
                        all.push(column(name.clone(), Kind::Verdict));
                        all.extend(["low", "high"].map(|end| column(format!("{name}_{end}_rounded"), Kind::Number)));
                    }
                    _ => {
                        let ends = ["low", "high"];
                        all.extend(ends.map(|end| column(format!("probability{number}_{end}_rounded"), Kind::Number)));
                        all.push(column(format!("probability{number}_method"), Kind::Text));
                    }
                },
            }
        }
        all
    }

    /// What one point answers.
    fn row(&self, point: usize, stop: &AtomicBool) -> Row {
        let values = self.sweep.point(point);
        let mut cells = Vec::new();
        let instead: BTreeMap<_, _> =
            values.iter().map(|(name, value)| (name.clone(), Some(Value::rational(value.clone())))).collect();
        for (_, value) in &values {
            let value = Value::rational(value.clone());
            cells.push(Cell::Text(value.to_string()));
            cells.push(near(&value).map_or(Cell::Nothing(()), Cell::Number));
        }
        let parts = self.environment.varied(&instead).ok().and_then(|environment| self.parts(&environment, stop));
        let Some(parts) = parts else {
            cells.push(Cell::Text("invalid".to_string()));
            cells.resize(self.columns.len(), Cell::Nothing(()));
            return Row { point, cells };
        };
        let verdicts = || parts.iter().filter_map(|part| part.verdict);
        let feasible = if verdicts().next().is_none() {
            None
        } else if verdicts().any(|word| matches!(word, "refuted" | "not met")) {
            Some("no")
        } else if verdicts().all(|word| matches!(word, "proved" | "met")) {
            Some("yes")
        } else {
            Some("open")
        };
        cells.push(feasible.map_or(Cell::Nothing(()), |word| Cell::Text(word.to_string())));
        cells.extend(parts.into_iter().flat_map(|part| part.cells));
        cells.resize(self.columns.len(), Cell::Nothing(()));
        Row { point, cells }
    }

    /// The answers in an environment; none where a question cannot be asked in it.
    fn parts(&self, environment: &Environment, stop: &AtomicBool) -> Option<Vec<Part>> {
        let mut parts = Vec::new();
        for question in &self.sweep.written.questions {
            parts.push(match question {
                SweepQuestion::Criteria(name) => criteria(environment, environment.criteria_of(&name.name)?, stop)?,
                SweepQuestion::Item(item) => match environment.question(item, &self.sweep.text).ok()? {
                    Lowered::Claim(claim) => self.claim(environment, &claim, item.span, stop),
                    Lowered::Probability(likelihood) => match chances(&likelihood, environment) {
                        Ok(likely) => Part {
                            verdict: None,
                            cells: vec![
                                Cell::Number(likely.low),
                                Cell::Number(likely.high),
                                Cell::Text(likely.method.to_string()),
                            ],
                        },
                        Err(_) => Part { verdict: None, cells: vec![Cell::Nothing(()); 3] },
                    },
                    _ => return None,
                },
            });
        }
        Some(parts)
    }

    fn claim(
        &self,
        environment: &Environment,
        claim: &crate::lower::Claim,
        span: crate::diagnostic::Span,
        stop: &AtomicBool,
    ) -> Part {
        let mut state = State { environment: environment.clone(), ..State::default() };
        let surroundings = Quiet(stop);
        let mut emit = |_: &crate::report::Output, _: Option<&super::Record>| {};
        let source = Source::new("sweep", self.sweep.text.as_str());
        let mut run = Run::new(&mut state, &self.own, &surroundings, environment, &mut emit);
        let waiting = Waiting {
            question: super::reading::Question::Claim(claim.clone()),
            environment: environment.clone(),
            source,
            span,
            file: String::new(),
            line: 0,
            text: claim.text.clone(),
            expected: Vec::new(),
        };
        let report = run.claim(claim, &waiting).report;
        let word = report.verdict.spelling();
        let ends = report.chance.map_or([Cell::Nothing(()), Cell::Nothing(())], |chance| {
            [Cell::Number(chance.low), Cell::Number(chance.high)]
        });
        let [low, high] = ends;
        Part { verdict: Some(word), cells: vec![Cell::Text(word.to_string()), low, high] }
    }

    /// Answers points on all cores, each handed on as soon as it is known, until `stop` is set. `poll` is asked now and
    /// then whether to set it.
    ///
    /// # Errors
    /// What `done` answers; no further points are begun then.
    pub fn run(
        &self,
        points: &[usize],
        jobs: usize,
        poll: &mut dyn FnMut(usize) -> bool,
        done: &mut dyn FnMut(Row) -> Result<(), String>,
    ) -> Result<(), String> {
        let (stop, next) = (AtomicBool::new(false), AtomicUsize::new(0));
        let (sender, receiver) = mpsc::channel();
        let mut result = Ok(());
        std::thread::scope(|scope| {
            for _ in 0..jobs.clamp(1, points.len().max(1)) {
                let (sender, stop, next) = (sender.clone(), &stop, &next);
                let work = move || {
                    room::tell(STACK);
                    while !stop.load(Ordering::Relaxed)
                        && let Some(point) = points.get(next.fetch_add(1, Ordering::Relaxed))
                    {
                        let row = self.row(*point, stop);
                        // What was cut short is not an answer.
                        if stop.load(Ordering::Relaxed) || sender.send(row).is_err() {
                            break;
                        }
                    }
                };
                if let Err(error) = std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, work) {
                    result = Err(format!("no thread can be started: {error}"));
                }
            }
            drop(sender);
            let mut count = 0;
            loop {
                match receiver.recv_timeout(Duration::from_millis(50)) {
                    Ok(row) => {
                        count += 1;
                        if let Err(error) = done(row) {
                            result = Err(error);
                            stop.store(true, Ordering::Relaxed);
                        }
                    }
                    Err(mpsc::RecvTimeoutError::Timeout) => {}
                    Err(mpsc::RecvTimeoutError::Disconnected) => break,
                }
                if poll(count) {
                    stop.store(true, Ordering::Relaxed);
                }
            }
        });
        result
    }
}

/// The world around a worker: nothing but the wish to stop.
struct Quiet<'a>(&'a AtomicBool);

impl Surroundings for Quiet<'_> {
    fn find(&self, _: &str, path: &str) -> Result<Source, String> {
        Err(format!("`{path}` is not looked for within a sweep"))
    }

    fn interrupted(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

fn criteria(
    environment: &Environment,
    written: &std::sync::Arc<crate::ast::Criteria>,
    stop: &AtomicBool,
) -> Option<Part> {
    let criteria = environment.criteria(written).ok()?;
    let interrupted = || stop.load(Ordering::Relaxed);
    let judge = Judge { chances: &closely, interrupted: &interrupted, stretches: SOME_STRETCHES, invariants: true };
    let judged = judge.judge(&criteria, environment);
    let word = judged.standing().spelling();
    let mut cells = vec![Cell::Text(word.to_string())];
    for finding in &judged.findings {
        for measure in [&finding.value, &finding.margin] {
            cells.push(measure.as_ref().map_or(Cell::Nothing(()), |one| Cell::Text(one.to_string())));
            let near = measure.as_ref().and_then(crate::criteria::Measure::near);
            cells.push(near.map_or(Cell::Nothing(()), Cell::Number));
        }
    }
    Some(Part { verdict: Some(word), cells })
}

/// `expect feasible = 5, infeasible = 3, open = 0`
fn expectations(expected: &[(Expectation, String)], head: &Head, rows: &[Row]) -> Vec<Expected> {
    let (yes, no, open) = counts(head, rows);
    let met = |expectation: &Expectation| match expectation {
        Expectation::Values(values) if head.judges() => values.iter().all(|(name, value)| {
            let found = match name.as_str() {
                "feasible" => yes,
                "infeasible" => no,
                "open" => open,
                _ => return false,
            };
            *value == Value::integer(i64::try_from(found).unwrap_or(i64::MAX))
        }),
        _ => false,
    };
    expected.iter().map(|(expectation, text)| Expected { text: text.clone(), met: met(expectation) }).collect()
}

/// How many points are answered at a time.
pub fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, std::num::NonZero::get)
}

impl Run<'_, '_> {
    /// A sweep within a script: all points, and where it is feasible.
    pub(super) fn sweep(&mut self, sweep: &Sweep, waiting: &Waiting) -> Answer {
        let plan = Plan::new(sweep, &waiting.environment, self.own);
        let head = plan.head(String::new(), (1, 1));
        let points: Vec<usize> = (0..head.points).collect();
        let mut rows = Vec::new();
        let surroundings = self.surroundings;
        let ran = plan.run(&points, cores(), &mut |_| surroundings.interrupted(), &mut |row| {
            rows.push(row);
            Ok(())
        });
        rows.sort_by_key(|row| row.point);
        let mut lines = vec![summary(&head, &rows)];
        lines.extend(region::lines(&head, &rows));
        if let Err(error) = ran {
            lines.push(error);
        }
        if rows.len() < head.points {
            lines.push(format!("interrupted: {} points were not asked", head.points - rows.len()));
        }
        let expected = expectations(&waiting.expected, &head, &rows);
        let (file, line, question) = (waiting.file.clone(), waiting.line, waiting.text.clone());
        Answer {
            file,
            line,
            kind: "sweep",
            question,
            lines,
            table: readable(&head, &rows),
            expected,
            verdict: None,
            chance: None,
            apart: None,
            pictures: Vec::new(),
        }
    }
}

/// The sweeps of a text.
#[derive(Default)]
pub struct Plans {
    /// The sweeps, in order.
    pub plans: Vec<Plan>,
    /// What is wrong in the text.
    pub failures: Vec<Failure>,
    /// The texts that it is made of.
    pub texts: Vec<String>,
}

/// Finds the sweeps of a text. Nothing else is asked or run.
///
/// # Errors
/// What is wrong with the texts that are part of the program.
pub fn plans(source: &Source, surroundings: &dyn Surroundings) -> Result<Plans, Vec<Failure>> {
    let mut environment = library::standard()?;
    environment.keep_history();
    let own = environment.laws.clone();
    let mut laws = own.clone();
    let texts = RefCell::new(vec![source.text.to_string()]);
    let mut reader = Reader::new(|importer: &str, path: &str| match library::embedded(path) {
        Some(source) => Ok(Source::new(source.name, "")),
        None => surroundings.find(importer, path).inspect(|found| texts.borrow_mut().push(found.text.to_string())),
    });
    let (mut plans, mut refused, mut behind) = (Vec::<Plan>::new(), Vec::new(), false);
    let mut failures = reader.read(&mut environment, source, &mut |environment, source, item, lowered| {
        let follows = std::mem::replace(&mut behind, matches!(lowered, Lowered::Sweep(_)));
        match lowered {
            Lowered::Sweep(sweep) => plans.push(Plan::new(&sweep, environment, &own)),
            Lowered::Expect(expectation) if follows => {
                behind = true;
                let text = expected_text(source, item.span);
                plans.last_mut().into_iter().for_each(|plan| plan.expected.push((expectation.clone(), text.clone())));
            }
            Lowered::Law(law) => match admit(&laws, &law, item.span, &|| surroundings.interrupted()) {
                Ok(_) => laws = environment.laws.clone(),
                Err(diagnostic) => {
                    environment.laws = laws.clone();
                    refused.push(Failure { source: source.clone(), diagnostics: vec![*diagnostic] });
                }
            },
            _ => {}
        }
    });
    drop(reader);
    failures.extend(refused);
    Ok(Plans { plans, failures, texts: texts.into_inner() })
}
