//! What a session answers, as data; as text for a person, and as JSON for a program, one object a line.

mod assessment;

use std::fmt::Write as _;
use std::sync::Arc;

use serde_json::{Map, Value as Json, json};

use crate::diagnostic::{Diagnostic, Severity, Source, render_all};
use crate::name::Name;
use crate::picture::Picture;
use crate::sample::reached;
use crate::stepper::{Apart, Route};
use crate::value::Value;

pub use assessment::Assessment;

/// The name of what is typed at the prompt; its place needs no mention.
pub const PROMPT: &str = "<prompt>";

/// What came of a claim.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Verdict {
    /// Proved, and checked by the kernel.
    Proved,
    /// Refuted: a run shows it.
    Refuted,
    /// Every criterion is met.
    Met,
    /// One criterion is not met.
    NotMet,
    /// Neither.
    #[default]
    Open,
}

impl Verdict {
    /// `proved`, `refuted`, `open`
    pub fn spelling(self) -> &'static str {
        match self {
            Verdict::Proved => "proved",
            Verdict::Refuted => "refuted",
            Verdict::Met => "met",
            Verdict::NotMet => "not met",
            Verdict::Open => "open",
        }
    }
}

/// Something that was expected, and whether it came so.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Expected {
    /// As written: `refuted`, `t1 = 10`.
    pub text: String,
    /// Whether it came so.
    pub met: bool,
}

/// A probability, with how it was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Chance {
    /// Its lower bound.
    pub low: f64,
    /// Its upper bound.
    pub high: f64,
    /// `exact`, `enclosed` or `estimated`
    pub method: &'static str,
    /// How sure the bounds are, where they come from a simulation.
    pub confidence: Option<f64>,
    /// How many runs were simulated.
    pub runs: Option<u64>,
}

impl Chance {
    fn json(&self) -> Json {
        let mut object = Map::new();
        object.insert("low".to_string(), json!(self.low));
        object.insert("high".to_string(), json!(self.high));
        object.insert("method".to_string(), json!(self.method));
        if let Some(confidence) = self.confidence {
            object.insert("confidence".to_string(), json!(confidence));
        }
        Json::Object(object)
    }
}

/// What came of one claim, or of one question that has an expectation.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// The number of the claim in its session, from 1.
    pub number: usize,
    /// Its name, if it has one.
    pub name: Option<Name>,
    /// The file in which it stands.
    pub file: String,
    /// The line in which it begins.
    pub line: usize,
    /// As written.
    pub claim: String,
    /// `equality`, `refinement`, `satisfies`
    pub kind: &'static str,
    /// What came of it.
    pub verdict: Verdict,
    /// What was expected; empty: that it is proved.
    pub expected: Vec<Expected>,
    /// Values found, in the first round.
    pub values: Vec<(Name, Value)>,
    /// Values in later rounds, where they differ.
    pub steady: Vec<(Name, Value)>,
    /// The laws used.
    pub laws: Vec<Name>,
    /// What was taken on trust.
    pub trusted: Vec<String>,
    /// The probability, where one is asked for.
    pub chance: Option<Chance>,
    /// What was asked of the probability, and by what margin that is met.
    pub asked: Option<String>,
    /// The run that refutes it, or the period and what follows from it.
    pub trace: Vec<String>,
    /// What could be changed.
    pub feedback: Vec<String>,
    /// What remains, and what was tried.
    pub remains: Vec<String>,
    /// What is wrong or may go wrong.
    pub diagnostics: Vec<(Source, Diagnostic)>,
    /// Whether the user stopped the search.
    pub interrupted: bool,
    /// What came of each criterion, where it is about criteria.
    pub assessment: Option<Arc<Assessment>>,
    /// Pictures, where the surroundings want them.
    pub pictures: Vec<Picture>,
    /// Who reads what from whom, as SVG, where the surroundings want pictures.
    pub links: Option<String>,
    /// What was assumed of parameters.
    pub assumed: Vec<String>,
    /// The sides of what refutes it, for the stepper.
    pub apart: Option<Arc<Apart>>,
}

/// One answer of a session.
#[derive(Clone, Debug)]
pub enum Output {
    /// To a claim.
    Claim(Box<Report>),
    /// To a question such as `simplify P` or `period Sys`.
    Answer(Box<Answer>),
    /// Something was declared.
    Declared(Vec<Name>),
    /// Something worth knowing.
    Note(String),
    /// An input that could not be taken.
    Trouble(Source, Vec<Diagnostic>),
}

/// The answer to a question.
#[derive(Clone, Debug)]
pub struct Answer {
    /// The file in which the question stands.
    pub file: String,
    /// The line in which it begins.
    pub line: usize,
    /// `simplify`, `period`, `flow`, `solve`, `project`
    pub kind: &'static str,
    /// As written.
    pub question: String,
    /// The answer.
    pub lines: Vec<String>,
    /// A table for a page, its headings first; empty where there is none.
    pub table: Vec<Vec<String>>,
    /// What was expected of it.
    pub expected: Vec<Expected>,
    /// `yes`, `no` or `unknown`, where the question asks for that.
    pub verdict: Option<&'static str>,
    /// The probability, where one is asked for.
    pub chance: Option<Chance>,
    /// The sides of what shows a `no`, for the stepper.
    pub apart: Option<Arc<Apart>>,
    /// Pictures, where the surroundings want them.
    pub pictures: Vec<Picture>,
}

impl Report {
    /// Whether everything came as expected; a claim without expectations is expected to be proved.
    pub fn as_expected(&self) -> bool {
        let verdict = self.expected.iter().any(|expected| is_verdict(&expected.text));
        self.expected.iter().all(|expected| expected.met)
            && (verdict || matches!(self.verdict, Verdict::Proved | Verdict::Met))
    }

    /// The exit code that it asks for: 0 as expected, 1 refuted or otherwise than expected, 4 open.
    pub fn exit_code(&self) -> u8 {
        match (self.as_expected(), self.verdict) {
            (true, _) => 0,
            (false, Verdict::Open) => 4,
            (false, _) => 1,
        }
    }
}

/// Whether an expectation names a verdict.
pub fn is_verdict(text: &str) -> bool {
    matches!(text, "proved" | "refuted" | "open" | "met" | "not met")
}

impl Output {
    /// The exit code that it asks for.
    pub fn exit_code(&self) -> u8 {
        match self {
            Output::Claim(report) => report.exit_code(),
            Output::Answer(answer) => answer.exit_code(),
            Output::Trouble(_, diagnostics) => {
                let wrong = diagnostics.iter().any(|diagnostic| diagnostic.severity == Severity::Error);
                if wrong { 3 } else { 0 }
            }
            Output::Declared(_) | Output::Note(_) => 0,
        }
    }

    /// The two sides of a counterexample, where it is one.
    pub fn apart(&self) -> Option<&Arc<Apart>> {
        match self {
            Output::Claim(report) => report.apart.as_ref(),
            Output::Answer(answer) => answer.apart.as_ref(),
            _ => None,
        }
    }

    /// For a person.
    pub fn text(&self, colour: bool) -> String {
        match self {
            Output::Claim(report) => report.text(Paint(colour)),
            Output::Answer(answer) => answer.text(Paint(colour)),
            Output::Declared(names) => format!("{} declared\n", list(names)),
            Output::Note(text) => format!("{} {text}\n", Paint(colour).bold("note:")),
            Output::Trouble(source, diagnostics) => render_all(diagnostics, source, colour),
        }
    }

    /// For a program: at most one line.
    pub fn json(&self) -> Option<Json> {
        match self {
            Output::Claim(report) => Some(report.json()),
            Output::Answer(answer) => Some(answer.json()),
            Output::Trouble(source, diagnostics) => {
                let diagnostics: Vec<Json> = diagnostics.iter().map(|one| one.to_json(source)).collect();
                Some(json!({ "file": source.name, "diagnostics": diagnostics }))
            }
            Output::Declared(_) | Output::Note(_) => None,
        }
    }
}

/// The worse of two exit codes: bad input before refuted before open.
pub fn worse(one: u8, other: u8) -> u8 {
    let rank = |code: u8| match code {
        0 => 0,
        4 => 1,
        1 => 2,
        _ => 3,
    };
    if rank(other) > rank(one) { other } else { one }
}

fn list(names: &[Name]) -> String {
    names.iter().map(Name::as_str).collect::<Vec<_>>().join(", ")
}

/// Colours, or none.
#[derive(Clone, Copy)]
struct Paint(bool);

impl Paint {
    fn with(self, code: &str, text: &str) -> String {
        if self.0 { format!("\u{1b}[{code}m{text}\u{1b}[0m") } else { text.to_string() }
    }

    fn bold(self, text: &str) -> String {
        self.with("1", text)
    }

    fn dim(self, text: &str) -> String {
        self.with("2", text)
    }

    fn place(self, file: &str, line: usize) -> String {
        if file == PROMPT { String::new() } else { self.dim(&format!("{file}:{line}:")) + " " }
    }

    fn good(self, good: bool, text: &str) -> String {
        self.with(if good { "1;32" } else { "1;31" }, text)
    }
}

/// The longest text of a value or term on one line.
const WIDEST: usize = 2_000;

/// A text cut to what can be read, saying so.
pub fn abbreviated(text: &str) -> String {
    let letters = text.chars().count();
    if letters <= WIDEST {
        return text.to_string();
    }
    let head: String = text.chars().take(WIDEST).collect();
    format!("{head}… ({} letters more)", letters - WIDEST)
}

/// `t1` for `?t1`
fn plain(name: &Name) -> &str {
    name.as_str().trim_start_matches('?')
}

fn values(values: &[(Name, Value)]) -> String {
    values
        .iter()
        .map(|(name, value)| format!("{name} = {}", abbreviated(&value.to_string())))
        .collect::<Vec<_>>()
        .join(", ")
}

impl Report {
    fn text(&self, paint: Paint) -> String {
        let mut out = String::new();
        let fine = self.as_expected();
        let word = match (self.verdict, self.interrupted) {
            (Verdict::Proved, _) => "proved",
            (Verdict::Refuted, _) => "refuted",
            (Verdict::Met, _) => "met",
            (Verdict::NotMet, _) => "not met",
            (Verdict::Open, _) if self.kind == "criteria" => "open",
            (Verdict::Open, false) => "could not prove",
            (Verdict::Open, true) => "interrupted, could not prove",
        };
        let claim = self.claim.split_whitespace().collect::<Vec<_>>().join(" ");
        let claim = claim.strip_prefix("prove ").unwrap_or(&claim);
        let place = paint.place(&self.file, self.line);
        let _ = writeln!(out, "{place}{} {}", paint.good(fine, &format!("{word}:")), abbreviated(claim));
        if !self.values.is_empty() {
            let _ = writeln!(out, "    with {}", values(&self.values));
        }
        if !self.steady.is_empty() {
            let _ = writeln!(out, "    in later rounds {}", values(&self.steady));
        }
        for line in self.trace.iter().chain(&self.remains) {
            let _ = writeln!(out, "    {}", abbreviated(line));
        }
        for line in &self.feedback {
            let _ = writeln!(out, "    try: {line}");
        }
        if !self.laws.is_empty() {
            let _ = writeln!(out, "    {}", paint.dim(&format!("by {}", list(&self.laws))));
        }
        for line in &self.trusted {
            let _ = writeln!(out, "    on trust: {line}");
        }
        for expected in self.expected.iter().filter(|expected| !expected.met) {
            let _ = writeln!(out, "    {} {}", paint.good(false, "but expected"), expected.text);
        }
        for (source, diagnostic) in &self.diagnostics {
            let _ = writeln!(out, "{}", diagnostic.render(source, paint.0));
        }
        out
    }

    fn json(&self) -> Json {
        let mut object = Map::new();
        let mut put = |key: &str, value: Json| {
            let empty = match &value {
                Json::Array(items) => items.is_empty(),
                Json::Object(items) => items.is_empty(),
                Json::String(text) => text.is_empty(),
                _ => false,
            };
            if !empty {
                object.insert(key.to_string(), value);
            }
        };
        put("file", json!(self.file));
        put("line", json!(self.line));
        put("claim", json!(self.claim));
        put("kind", json!(self.kind));
        put("verdict", json!(self.verdict.spelling()));
        put("expected", json!(expected(&self.expected)));
        put("unmet", json!(unmet(&self.expected)));
        put("values", pairs(&self.values));
        put("steady", pairs(&self.steady));
        if let Some(chance) = &self.chance {
            put("probability", chance.json());
        }
        put("laws", json!(self.laws.iter().map(Name::as_str).collect::<Vec<_>>()));
        put("trusted", json!(self.trusted));
        put("trace", json!(self.trace.iter().chain(&self.remains).collect::<Vec<_>>()));
        put("feedback", json!(self.feedback));
        let diagnostics: Vec<Json> = self.diagnostics.iter().map(|(source, one)| one.to_json(source)).collect();
        put("diagnostics", json!(diagnostics));
        put("run", self.apart.as_ref().map_or_else(|| json!({}), |apart| run(apart)));
        put("criteria", self.assessment.as_ref().map_or_else(|| json!([]), |assessment| assessment.json()));
        Json::Object(object)
    }
}

fn expected(expected: &[Expected]) -> String {
    expected.iter().map(|expected| expected.text.as_str()).collect::<Vec<_>>().join(", ")
}

/// What was expected and is not so.
fn unmet(expected: &[Expected]) -> Vec<&str> {
    expected.iter().filter(|expected| !expected.met).map(|expected| expected.text.as_str()).collect()
}

/// Both sides of a run that tells them apart, each with what it refers to.
fn run(apart: &Apart) -> Json {
    let side = |route: &Route| {
        let steps: Vec<String> = route.choices.iter().map(ToString::to_string).collect();
        let mut object = json!({ "process": route.term.to_string(), "steps": steps });
        let called = reached(&route.term, &route.definitions);
        let definitions = called.iter().filter_map(|name| route.definitions.get(name));
        let definitions: Vec<String> = definitions.map(ToString::to_string).collect();
        if let (false, Some(map)) = (definitions.is_empty(), object.as_object_mut()) {
            map.insert("definitions".to_string(), json!(definitions));
        }
        object
    };
    json!({ "left": side(&apart.left), "right": side(&apart.right) })
}

fn pairs(values: &[(Name, Value)]) -> Json {
    values.iter().map(|(name, value)| (plain(name).to_string(), json!(value.to_string()))).collect::<Map<_, _>>().into()
}

impl Answer {
    /// The exit code that it asks for: 1 for what was not expected, 4 for `unknown`.
    pub fn exit_code(&self) -> u8 {
        let met = self.expected.iter().all(|expected| expected.met);
        match self.verdict {
            None | Some("yes") => u8::from(!met),
            Some(_) if met && !self.expected.is_empty() => 0,
            Some("unknown") => 4,
            Some(_) => 1,
        }
    }

    fn text(&self, paint: Paint) -> String {
        let mut out = String::new();
        let question = self.question.split_whitespace().collect::<Vec<_>>().join(" ");
        let place = paint.place(&self.file, self.line);
        let _ = writeln!(out, "{place}{}", abbreviated(&question));
        for line in &self.lines {
            let _ = writeln!(out, "    {}", abbreviated(line));
        }
        for expected in self.expected.iter().filter(|expected| !expected.met) {
            let _ = writeln!(out, "    {} {}", paint.good(false, "but expected"), expected.text);
        }
        out
    }

    fn json(&self) -> Json {
        let mut object = json!({
            "file": self.file, "line": self.line, "claim": self.question, "kind": self.kind, "trace": self.lines,
        });
        if let (false, Some(map)) = (self.expected.is_empty(), object.as_object_mut()) {
            map.insert("expected".to_string(), json!(expected(&self.expected)));
            if self.expected.iter().any(|expected| !expected.met) {
                map.insert("unmet".to_string(), json!(unmet(&self.expected)));
            }
        }
        if let (Some(chance), Some(map)) = (&self.chance, object.as_object_mut()) {
            map.insert("probability".to_string(), chance.json());
        }
        if let (Some(verdict), Some(map)) = (self.verdict, object.as_object_mut()) {
            map.insert("verdict".to_string(), json!(verdict));
        }
        if let (Some(apart), Some(map)) = (&self.apart, object.as_object_mut()) {
            map.insert("run".to_string(), run(apart));
        }
        object
    }
}
