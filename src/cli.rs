//! The command line.

mod exercise;
mod lint;
mod period;
mod page;
mod step;
mod sweep;
mod system;

use std::io::IsTerminal;
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use std::time::Duration;

use clap::{Parser, Subcommand, ValueEnum};

use crate::codes;
use crate::preorder::Preorder;
use crate::printer::format;
use crate::progress::Watch;
use crate::proof_file::check_file;
use crate::repl;
use crate::script::{Options, Printer, Script, complain, opened, read_input};

/// A prover for robot programs and the world around them.
///
/// Without a command: the prompt, or, when standard input is not a terminal, a script from there.
#[derive(Parser)]
#[command(version, name = "pars")]
struct Line {
    #[command(subcommand)]
    command: Option<Command>,
    /// When to use colours.
    #[arg(long, value_enum, default_value_t = Colour::Auto, global = true)]
    color: Colour,
}

#[derive(Subcommand)]
enum Command {
    /// Run scripts. Exit code: 0 all claims as expected, 1 one refuted, 2 usage, 3 bad input, 4 one left open.
    Run {
        /// The scripts; `-` is standard input.
        #[arg(required = true)]
        files: Vec<PathBuf>,
        /// One JSON object a claim, a line each.
        #[arg(long)]
        json: bool,
        /// Write a proof file for each proved claim into this folder.
        #[arg(long, value_name = "DIR")]
        proofs: Option<PathBuf>,
        /// Write a LaTeX document with its derivation for each proved claim into this folder.
        #[arg(long, value_name = "DIR")]
        latex: Option<PathBuf>,
    },
    /// Check proof files with the kernel alone. Exit code 3 when one is rejected.
    Check {
        /// The proof files.
        #[arg(required = true)]
        proofs: Vec<PathBuf>,
    },
    /// Lay files out in the canonical way.
    Fmt {
        /// Change nothing; exit code 1 when a file is laid out otherwise.
        #[arg(long)]
        check: bool,
        /// The files.
        #[arg(required = true)]
        files: Vec<PathBuf>,
    },
    /// Step a process by hand. Exit code: 0 every step was possible, 1 one was not, 2 usage, 3 bad input.
    ///
    /// On a terminal it asks for one step after the other; otherwise it takes them from standard input, a line each.
    Step {
        /// The file that declares the process.
        #[arg(required_unless_present = "replay")]
        file: Option<PathBuf>,
        /// The process: a system, or any process in quotes; left out, the only one.
        name: Option<String>,
        /// Values for parameters: `t = 1, a = 3`.
        #[arg(long, value_name = "VALUES")]
        with: Option<String>,
        /// Take the steps of a saved trace again.
        #[arg(long, value_name = "TRACE", conflicts_with_all = ["file", "name", "with"])]
        replay: Option<PathBuf>,
    },
    /// Do exercises: a step at a time, each judged. Exit code: 0 all solved, 1 not all, 2 usage, 3 bad input.
    Exercise {
        /// The file that holds them.
        file: PathBuf,
        /// The name of one; left out, all of them in order.
        name: Option<String>,
    },
    /// Look for what is wrong with the laws of rule files, or unwise. Exit code: 0 nothing found, 1 something, 3 bad input.
    Lint {
        /// The rule files.
        #[arg(required = true)]
        files: Vec<PathBuf>,
    },
    /// The transition system of a process or a file: what it can do, or the system itself. Exit code 4 when a bound is
    /// hit.
    Lts {
        /// An `.aut` file, or a `.pars` file that declares the process.
        file: PathBuf,
        /// The system or process of a `.pars` file; the only system in it when it is left out.
        process: Option<String>,
        /// Values for parameters that have none: "t = 1, a = 3"; the others get small ones.
        #[arg(long, value_name = "VALUES")]
        with: Option<String>,
        /// How to write it.
        #[arg(long, value_enum, default_value = "text")]
        format: system::Format,
        /// The smallest system that is strongly bisimilar to it.
        #[arg(long)]
        minimise: bool,
        /// The most states.
        #[arg(long, value_name = "N")]
        bound: Option<usize>,
        /// The most memory, in MiB.
        #[arg(long, value_name = "MIB")]
        memory: Option<usize>,
        /// Where to write it.
        #[arg(long, short, value_name = "FILE")]
        output: Option<PathBuf>,
    },
    /// The phases of a system: what repeats, and when one behaviour follows another. Exit code 1 when it has no period.
    Period {
        /// A `.pars` file that declares the system.
        file: PathBuf,
        /// The system; the only one in the file when it is left out.
        system: Option<String>,
        /// How to write the phases.
        #[arg(long, value_enum, default_value = "text")]
        format: period::Format,
        /// Where to write them.
        #[arg(long, short, value_name = "FILE")]
        output: Option<PathBuf>,
    },
    /// Compare two `.aut` files. Exit code: 0 yes, 1 no, 2 usage, 3 bad input, 4 unknown.
    Compare {
        /// The left system.
        left: PathBuf,
        /// The right system.
        right: PathBuf,
        /// strong, weak, branching, trace, weak-trace, simulation, simulation-equivalence or refinement.
        #[arg(long = "as", value_name = "RELATION", value_parser = system::relation, default_value = "strong")]
        relation: Preorder,
        /// The most memory, in MiB.
        #[arg(long, value_name = "MIB")]
        memory: Option<usize>,
        /// One JSON object.
        #[arg(long)]
        json: bool,
    },
    /// Write what came of a script as one page, FILE.html and FILE.md: verdicts and margins first, then what limits them,
    /// pictures, the model and what it rests on. Exit codes as with `run`.
    Report {
        /// The script.
        file: PathBuf,
        /// Where to write, without an extension; by default named as the script.
        #[arg(long, short, value_name = "FILE")]
        output: Option<PathBuf>,
        /// Print it instead, with pictures in signs.
        #[arg(long)]
        terminal: bool,
    },
    /// Run the sweeps of a script, point by point on all cores. What was done is kept: the same command goes on where it
    /// was interrupted. Exit code: 0 all points done, 2 usage, 3 bad input, 4 interrupted.
    Sweep {
        /// The script; with `--merge`, the `.points.jsonl` files of all parts.
        #[arg(required = true)]
        files: Vec<PathBuf>,
        /// Where to write: FILE.points.jsonl, FILE.csv, FILE.parquet, FILE.svg; by default named as the script.
        #[arg(long, short, value_name = "FILE")]
        output: Option<PathBuf>,
        /// One part of several: `2/8`. Each part writes its own file of points.
        #[arg(long, value_name = "PART/PARTS", value_parser = sweep::shard, default_value = "1/1")]
        shard: (usize, usize),
        /// How many points at a time; by default as many as there are cores.
        #[arg(long, value_name = "N")]
        jobs: Option<usize>,
        /// Put the parts of one sweep together.
        #[arg(long)]
        merge: bool,
    },
    /// Explain the code of an error, such as P0204.
    Explain {
        /// The code; all codes when it is left out.
        code: Option<String>,
    },
}

#[derive(Clone, Copy, ValueEnum)]
enum Colour {
    Auto,
    Always,
    Never,
}

impl Colour {
    fn on(self, terminal: bool) -> bool {
        match self {
            Colour::Always => true,
            Colour::Never => false,
            Colour::Auto => terminal && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty()),
        }
    }
}

/// Runs standard input, which may hold commands of the prompt; gives the exit code.
fn standard_input(watch: Rc<Watch>, colour: bool) -> u8 {
    match read_input() {
        Ok(source) if repl::has_commands(&source.text) => repl::piped(&source, watch, colour),
        read => Script::new(&Options { colour, ..Options::default() }, watch).given(read),
    }
}

/// Does what the command line says; gives the exit code.
pub fn run() -> u8 {
    let line = match Line::try_parse() {
        Ok(line) => line,
        Err(error) => {
            let _ = error.print();
            return u8::try_from(error.exit_code()).unwrap_or(2);
        }
    };
    let prompt = line.command.is_none() && std::io::stdin().is_terminal();
    let runs = matches!(line.command, Some(Command::Run { .. }));
    let watch = Rc::new(Watch::new(listen(prompt, runs)));
    let colour = line.color.on(std::io::stdout().is_terminal());
    match line.command {
        None if std::io::stdin().is_terminal() => repl::run(watch, colour),
        None => standard_input(watch, colour),
        Some(Command::Run { files, json, proofs, latex }) => {
            Script::new(&Options { json, colour, proofs, latex }, watch).files(&files)
        }
        Some(Command::Check { proofs }) => check(&proofs),
        Some(Command::Fmt { check, files }) => lay_out(&files, check, colour),
        Some(Command::Lint { files }) => lint::files(&files, watch, colour),
        Some(Command::Exercise { file, name }) => exercise::exercise(&file, name.as_deref(), watch, colour),
        Some(Command::Step { replay: Some(trace), .. }) => step::replay(&trace, watch, colour),
        Some(Command::Step { file, name, with, .. }) => {
            step::step(file.as_deref(), name.as_deref(), with.as_deref(), watch, colour)
        }
        Some(Command::Lts { file, process, with, format, minimise, bound, memory, output }) => {
            let request = system::Request { file, term: process, with, format, minimise, bound, memory, output };
            system::lts(&request, &watch, colour)
        }
        Some(Command::Period { file, system, format, output }) => {
            period::period(&period::Request { file, system, format, output }, &watch, colour)
        }
        Some(Command::Compare { left, right, relation, memory, json }) => {
            system::compare_files([&left, &right], relation, memory, json, &watch, colour)
        }
        Some(Command::Report { file, output, terminal }) => {
            page::report(&file, output.as_deref(), terminal, watch, colour)
        }
        Some(Command::Sweep { files, output, merge: true, .. }) => sweep::merge(&files, output.as_deref()),
        Some(Command::Sweep { files, output, shard, jobs, .. }) => match files.as_slice() {
            [file] => sweep::sweep(file, &sweep::Request { output, shard, jobs }, watch, colour),
            _ => {
                complain("one script at a time; `--merge` puts the parts of a sweep together\n");
                2
            }
        },
        Some(Command::Explain { code }) => explain(code.as_deref()),
    }
}

/// How long the work may take to hear that it is to stop.
const HEARING: Duration = Duration::from_millis(900);

/// The wish to stop: Ctrl-C. A second time in vain ends the program; at the prompt, where more is at stake, a third time. A
/// run of scripts, which keeps nothing, is ended where it does not hear the first.
fn listen(prompt: bool, runs: bool) -> Arc<AtomicBool> {
    let stop = Arc::new(AtomicBool::new(false));
    let heard = stop.clone();
    let vain = AtomicU8::new(u8::from(!prompt));
    let set = ctrlc::set_handler(move || {
        if !heard.swap(true, Ordering::Relaxed) {
            vain.store(u8::from(!prompt), Ordering::Relaxed);
            let wish = heard.clone();
            let wait = move || {
                std::thread::sleep(HEARING);
                if wish.load(Ordering::Relaxed) {
                    complain("interrupted\n");
                    std::process::exit(130);
                }
            };
            // Without a thread to wait the second time ends it.
            let _ = runs.then(|| std::thread::Builder::new().spawn(wait));
        } else if vain.fetch_add(1, Ordering::Relaxed) > 0 {
            std::process::exit(130);
        }
    });
    if let Err(error) = set {
        complain(&format!("Ctrl-C will end the program at once: {error}\n"));
    }
    stop
}

fn check(proofs: &[PathBuf]) -> u8 {
    let mut printer = Printer::default();
    let mut code = 0;
    for path in proofs {
        let name = path.display();
        let read = std::fs::read(path).map_err(|error| format!("it cannot be read: {error}"));
        match read.and_then(|bytes| check_file(&bytes).map_err(|rejection| rejection.to_string())) {
            Ok(checked) => {
                let text = checked.to_string().replace('\n', "\n  ");
                printer.print(&format!("{name}: checked, {} steps\n  {text}\n", checked.steps));
            }
            Err(why) => {
                complain(&format!("{name}: rejected: {why}\n"));
                code = 3;
            }
        }
    }
    code
}

fn lay_out(files: &[PathBuf], check: bool, colour: bool) -> u8 {
    let mut code = 0;
    for path in files {
        let Some(source) = opened(path, colour) else {
            code = 3;
            continue;
        };
        match format(&source.text) {
            Err(diagnostics) => {
                complain(&crate::diagnostic::render_all(&diagnostics, &source, colour));
                code = 3;
            }
            Ok(text) if text == source.text => {}
            Ok(_) if check => {
                complain(&format!("{} is laid out otherwise\n", path.display()));
                code = code.max(1);
            }
            Ok(text) => {
                if let Err(error) = std::fs::write(path, text) {
                    complain(&format!("`{}` cannot be written: {error}\n", path.display()));
                    code = 3;
                }
            }
        }
    }
    code
}

fn explain(code: Option<&str>) -> u8 {
    let mut printer = Printer::default();
    match code {
        None => {
            for (code, title) in codes::all() {
                printer.print(&format!("{code}  {title}\n"));
            }
            0
        }
        Some(code) => match codes::explain(code) {
            Some(text) => {
                printer.print(text);
                0
            }
            None => {
                complain(&format!("there is no error code `{code}`; `pars explain` lists them\n"));
                2
            }
        },
    }
}
