//! Scripts: files and standard input run from top to end, with an exit code that says how the claims came out.

use std::collections::BTreeSet;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::rc::Rc;

use crate::diagnostic::{Diagnostic, Source};
use crate::latex;
use crate::name::Name;
use crate::progress::Watch;
use crate::report::{Output, worse};
use crate::session::{Record, Session, Surroundings};

/// Files larger than this are refused.
pub const MOST_BYTES: u64 = 64 << 20;

/// How a script shows what it finds.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// One JSON object a claim, a line each.
    pub json: bool,
    /// Whether text has colours.
    pub colour: bool,
    /// Where to write one proof file for each proved claim.
    pub proofs: Option<PathBuf>,
    /// Where to write one LaTeX document for each proved claim.
    pub latex: Option<PathBuf>,
}

/// The world around a script: files on disk, and a watch.
pub struct World {
    watch: Rc<Watch>,
}

impl World {
    /// The world with this watch.
    pub fn new(watch: Rc<Watch>) -> World {
        World { watch }
    }
}

impl Surroundings for World {
    fn find(&self, importer: &str, path: &str) -> Result<Source, String> {
        let beside = Path::new(importer).parent().unwrap_or(Path::new("")).join(path);
        read_file(&beside).map_err(|trouble| trouble.1.message)
    }

    fn interrupted(&self) -> bool {
        self.watch.interrupted()
    }

    fn begins(&self, what: &str) {
        self.watch.begins(what);
    }

    fn ends(&self) {
        self.watch.ends();
    }
}

/// What is wrong with a text, and as much of it as can be read.
pub type Trouble = Box<(Source, Diagnostic)>;

/// The name of a file that tells it from all others: without `.` and `..` where they can be resolved.
fn name_of(path: &Path) -> String {
    let mut parts: Vec<&std::ffi::OsStr> = Vec::new();
    let mut rooted = false;
    for part in path.components() {
        match part {
            std::path::Component::CurDir => {}
            std::path::Component::ParentDir if parts.last().is_some_and(|last| *last != "..") => {
                parts.pop();
            }
            std::path::Component::RootDir => rooted = true,
            part => parts.push(part.as_os_str()),
        }
    }
    let joined: PathBuf = parts.into_iter().collect();
    let shown = joined.display().to_string();
    match (rooted, shown.is_empty()) {
        (true, _) => format!("/{shown}"),
        (false, true) => ".".to_string(),
        (false, false) => shown,
    }
}

/// Reads a file as text.
///
/// # Errors
/// What is wrong with it, with as much of it as can be read.
pub fn read_file(path: &Path) -> Result<Source, Trouble> {
    let name = name_of(path);
    let refuse = |why: String| Box::new((Source::new(name.as_str(), ""), Diagnostic::error("P0804", why)));
    let file = std::fs::File::open(path).map_err(|error| match error.kind() {
        io::ErrorKind::NotFound => refuse(format!("there is no file `{name}`")),
        _ => refuse(format!("`{name}` cannot be read: {error}")),
    })?;
    let directory = file.metadata().is_ok_and(|data| data.is_dir());
    if directory {
        return Err(refuse(format!("`{name}` is a folder, not a file")));
    }
    text_of(&name, file)
}

/// What stands in this file, `-` for standard input; what is wrong with it is said on standard error.
pub fn opened(path: &Path, colour: bool) -> Option<Source> {
    let read = if path.as_os_str() == "-" { read_input() } else { read_file(path) };
    read.map_err(|trouble| complain(&format!("{}\n", trouble.1.render(&trouble.0, colour)))).ok()
}

/// Reads all of standard input as text.
///
/// # Errors
/// What is wrong with it.
pub fn read_input() -> Result<Source, Trouble> {
    text_of("<input>", io::stdin().lock())
}

fn text_of(name: &str, from: impl Read) -> Result<Source, Trouble> {
    let refuse = |why: String| Box::new((Source::new(name, ""), Diagnostic::error("P0804", why)));
    let mut bytes = Vec::new();
    let read = from.take(MOST_BYTES + 1).read_to_end(&mut bytes);
    read.map_err(|error| refuse(format!("`{name}` cannot be read: {error}")))?;
    if bytes.len() as u64 > MOST_BYTES {
        return Err(refuse(format!("`{name}` has more than {} MiB", MOST_BYTES >> 20)));
    }
    Source::from_bytes(name, bytes)
}

/// Writes to standard output. Once nobody reads any more, it is silent, and the work goes on to its exit code.
pub struct Printer {
    open: bool,
}

impl Default for Printer {
    fn default() -> Printer {
        Printer { open: true }
    }
}

impl Printer {
    /// One that prints nothing.
    pub fn closed() -> Printer {
        Printer { open: false }
    }

    /// Writes a text.
    pub fn print(&mut self, text: &str) {
        if self.open {
            let mut out = io::stdout().lock();
            self.open = out.write_all(text.as_bytes()).and_then(|()| out.flush()).is_ok();
        }
    }
}

/// Writes to standard error; what cannot be written is dropped.
pub fn complain(text: &str) {
    let mut out = io::stderr().lock();
    let _ = out.write_all(text.as_bytes()).and_then(|()| out.flush());
}

/// A script being run: one session for each file.
pub struct Script<'o> {
    options: &'o Options,
    watch: Rc<Watch>,
    printer: Printer,
    code: u8,
    proofs: BTreeSet<PathBuf>,
    /// Whether it was interrupted: then no further file is run.
    stopped: bool,
}

impl<'o> Script<'o> {
    /// A script with these options.
    pub fn new(options: &'o Options, watch: Rc<Watch>) -> Script<'o> {
        Script { options, watch, printer: Printer::default(), code: 0, proofs: BTreeSet::new(), stopped: false }
    }

    /// Runs each file in a session of its own; gives the exit code.
    pub fn files(mut self, paths: &[PathBuf]) -> u8 {
        for folder in [&self.options.proofs, &self.options.latex].into_iter().flatten() {
            if let Err(error) = std::fs::create_dir_all(folder) {
                complain(&format!("the folder `{}` cannot be made: {error}\n", folder.display()));
                return 2;
            }
        }
        for (number, path) in paths.iter().enumerate() {
            if self.stopped {
                break;
            }
            let read = if path.as_os_str() == "-" { read_input() } else { read_file(path) };
            self.text(read, number + 1 == paths.len());
        }
        self.code
    }

    /// Runs what was read; gives the exit code.
    pub fn given(mut self, read: Result<Source, Trouble>) -> u8 {
        self.text(read, true);
        self.code
    }

    /// Runs one text. After the last the process ends: what the session holds need not be taken apart before.
    fn text(&mut self, read: Result<Source, Trouble>, last: bool) {
        let source = match read {
            Ok(source) => source,
            Err(trouble) => {
                let (source, diagnostic) = *trouble;
                self.show(&Output::Trouble(source, vec![diagnostic]));
                return;
            }
        };
        let mut session = match Session::new(Rc::new(World::new(self.watch.clone()))) {
            Ok(session) => session,
            Err(failures) => {
                for failure in failures {
                    self.show(&Output::Trouble(failure.source, failure.diagnostics));
                }
                return;
            }
        };
        let mut proved: Vec<Record> = Vec::new();
        session.run(&source, &mut |output, record| {
            self.show(output);
            if self.options.proofs.is_some() || self.options.latex.is_some() {
                proved.extend(record.filter(|record| record.evidence.is_some()).cloned());
            }
        });
        self.stopped = self.watch.interrupted();
        if self.stopped {
            // It was heard; what was proved is still kept.
            self.watch.reset();
        }
        for record in proved {
            self.save(&session, &source.name, &record);
        }
        if self.stopped {
            complain("interrupted\n");
            self.code = worse(self.code, 4);
        }
        if last {
            std::mem::forget(session);
        }
    }

    fn show(&mut self, output: &Output) {
        self.code = worse(self.code, output.exit_code());
        if self.options.json {
            if let Some(json) = output.json() {
                self.printer.print(&format!("{json}\n"));
            }
            return;
        }
        match output {
            Output::Declared(_) => {}
            Output::Trouble(..) => complain(&output.text(self.options.colour)),
            _ => self.printer.print(&output.text(self.options.colour)),
        }
    }

    /// Writes the files of a claim that was proved: its proof, and its derivation for print.
    fn save(&mut self, session: &Session, file: &str, record: &Record) {
        let Some(evidence) = &record.evidence else { return };
        if let Some(folder) = self.options.proofs.clone() {
            let path = self.free_path(&folder, file, record, "json");
            self.write(&path, session.proof_file(evidence));
        }
        if let Some(folder) = self.options.latex.clone() {
            let path = self.free_path(&folder, file, record, "tex");
            let text = latex::document(&record.report.claim, &evidence.chain(), &evidence.theory.laws);
            self.write(&path, Ok(text));
        }
    }

    /// `<file>-<name or number>.json`, with one more number where that is taken.
    fn free_path(&mut self, folder: &Path, file: &str, record: &Record, extension: &str) -> PathBuf {
        let stem = Path::new(file).file_stem().map_or("input".into(), |stem| stem.to_string_lossy().into_owned());
        let which = record.report.name.as_ref().map_or(record.report.number.to_string(), Name::to_string);
        let mut path = folder.join(format!("{stem}-{which}.{extension}"));
        let mut again = 1;
        while !self.proofs.insert(path.clone()) {
            again += 1;
            path = folder.join(format!("{stem}-{which}-{again}.{extension}"));
        }
        path
    }

    fn write(&mut self, path: &Path, text: Result<String, String>) {
        let written = text.and_then(|text| {
            std::fs::write(path, text).map_err(|error| format!("`{}` cannot be written: {error}", path.display()))
        });
        if let Err(why) = written {
            complain(&format!("{why}\n"));
            self.code = worse(self.code, 2);
        }
    }
}
