//! Proof files: a proof with the theory it stands on, as one JSON file that another process can check.
//!
//! `docs/proof.md` describes the format. [`check_file`] treats a file as hostile, and uses the parser, the program's
//! own laws and the kernel, nothing of the prover.

mod read;
mod text;
mod write;

use std::fmt;

use crate::diagnostic::Diagnostic;
use crate::kernel::{Theory, Thm, check};
use crate::law::Law;
use crate::library;
use crate::name::Name;

pub use write::write;

/// The first word of every proof file.
pub const FORMAT: &str = "pars-proof-1";
/// The largest proof file that is read, in bytes.
pub const MOST_BYTES: usize = 64 << 20;
/// The most steps of a proof file.
pub const MOST_STEPS: usize = 1_000_000;
/// The longest text of one term in a proof file, in bytes.
pub const MOST_TEXT: usize = 1 << 20;

/// A proof file that the kernel has accepted.
#[derive(Clone, Debug)]
pub struct Checked {
    /// What was proved.
    pub theorem: Thm,
    /// The theory in which it was proved.
    pub theory: Theory,
    /// The laws used that the file brought along; they are not the program's own.
    pub foreign: Vec<Law>,
    /// The number of steps.
    pub steps: usize,
}

impl fmt::Display for Checked {
    /// The theorem with all it rests on: definitions, assumptions, laws, and what was taken on trust.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_theorem(f, &self.theorem, &self.theory)?;
        for law in &self.foreign {
            write!(f, "\n  by a law that the file brings along:\n    {}", law.to_string().replace('\n', "\n    "))?;
        }
        Ok(())
    }
}

fn write_theorem(f: &mut fmt::Formatter<'_>, theorem: &Thm, theory: &Theory) -> fmt::Result {
    let statement = theorem.statement();
    write!(f, "{} {} {}", statement.left, statement.connective, statement.right)?;
    if !statement.hypotheses.is_empty() {
        let hypotheses: Vec<String> = statement.hypotheses.iter().map(ToString::to_string).collect();
        write!(f, " when {}", hypotheses.join(", "))?;
    }
    let assumed = assumptions(theory);
    if !assumed.is_empty() {
        write!(f, "\n  assuming {}", assumed.join(", "))?;
    }
    for definition in theory.definitions.iter() {
        write!(f, "\n  where {definition}")?;
    }
    let laws: Vec<&str> = theorem.laws().iter().map(Name::as_str).collect();
    if !laws.is_empty() {
        write!(f, "\n  by {}", laws.join(", "))?;
    }
    for reason in theorem.trusted() {
        write!(f, "\n  on trust: {reason}")?;
    }
    Ok(())
}

/// What a theory assumes of its parameters, as text.
pub fn assumptions(theory: &Theory) -> Vec<String> {
    let natural = theory.assumptions.naturals().iter().map(|name| format!("{name} natural"));
    let compared = theory.assumptions.iter().map(|(relation, value)| format!("{value} {} 0", relation.symbol()));
    natural.chain(compared).collect()
}

/// Why a proof file was turned away.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rejection {
    /// The step at fault, if it is one.
    pub step: Option<usize>,
    /// What is wrong.
    pub reason: String,
}

impl Rejection {
    fn new(reason: impl Into<String>) -> Rejection {
        Rejection { step: None, reason: reason.into() }
    }

    fn at(step: usize, reason: impl Into<String>) -> Rejection {
        Rejection { step: Some(step), reason: reason.into() }
    }

    /// The first of several errors in a text of the file.
    fn within(what: &str, text: &str, diagnostics: &[Diagnostic]) -> Rejection {
        let message = diagnostics.first().map_or("it cannot be read", |diagnostic| &diagnostic.message);
        let shown: String = text.chars().take(80).collect();
        Rejection::new(format!("{what} `{shown}`: {message}"))
    }
}

impl fmt::Display for Rejection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.step {
            Some(step) => write!(f, "step {step}: {}", self.reason),
            None => f.write_str(&self.reason),
        }
    }
}

/// Reads a proof file and has the kernel check it.
///
/// # Errors
/// Why it was turned away.
pub fn check_file(bytes: &[u8]) -> Result<Checked, Rejection> {
    // What is no proof file at all is turned away before anything is made ready.
    let file = read::open(bytes)?;
    let base =
        library::standard().map_err(|_| Rejection::new("the laws that are part of this program cannot be read"))?;
    let known = base.laws.clone();
    let (theory, proof) = read::read(base, &file)?;
    let theorem = check(&theory, &proof).map_err(|rejected| {
        let step = (rejected.step < proof.steps.len()).then_some(rejected.step);
        Rejection { step, reason: rejected.reason.to_string() }
    })?;
    let foreign = theorem.laws().iter().filter(|name| known.get(name).is_none());
    let foreign = foreign.filter_map(|name| theory.laws.get(name)).map(|law| (**law).clone()).collect();
    Ok(Checked { theorem, theory, foreign, steps: proof.steps.len() })
}

/// A number that changes when any one byte of the text does (FNV-1a, 64 bits).
fn seal(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |seal, byte| (seal ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3))
}

/// The last line of a file whose other bytes are these.
fn last_line(bytes: &[u8]) -> String {
    format!("\"seal\":\"{:016x}\"}}\n", seal(bytes))
}

/// A proof file with its last line computed anew, for those who write one by hand.
///
/// Everything from the last `"seal"` on is replaced.
pub fn sealed(bytes: &[u8]) -> Vec<u8> {
    let mut file = body(bytes).unwrap_or(bytes).to_vec();
    let line = last_line(&file);
    file.extend_from_slice(line.as_bytes());
    file
}

/// What stands before the last `"seal"`.
fn body(bytes: &[u8]) -> Option<&[u8]> {
    let word = b"\"seal\"";
    let place = bytes.windows(word.len()).rposition(|window| window == word)?;
    bytes.get(..place)
}
