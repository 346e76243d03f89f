//! Traces as files: what the run is of, and its steps.
//!
//! A trace is a text of the language up to a line that begins with `start`; behind it stands a step a line.

use std::fmt::Write as _;
use std::path::{Component, Path, PathBuf};

use super::{Origin, Walk};
use crate::lower::Entity;

/// A trace as it was saved.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Saved {
    /// The declarations.
    pub head: String,
    /// What the run starts with, with its values; none if the text has steps alone.
    pub start: Option<String>,
    /// The steps, a line each.
    pub steps: String,
    /// The number of lines before the steps.
    pub line: usize,
}

/// Takes a saved trace apart; a text without `start` is steps alone.
pub fn saved(text: &str) -> Saved {
    let mut offset = 0;
    for (number, line) in text.split_inclusive('\n').enumerate() {
        offset += line.len();
        if let Some(start) = line.trim_end().strip_prefix("start ") {
            let head = text.get(..offset - line.len()).unwrap_or("").to_string();
            let steps = text.get(offset..).unwrap_or("").to_string();
            return Saved { head, start: Some(start.trim().to_string()), steps, line: number + 1 };
        }
    }
    Saved { steps: text.to_string(), ..Saved::default() }
}

impl Walk {
    /// The run so far as the text of a file at this path.
    pub(super) fn trace_file(&self, path: &Path) -> String {
        let mut out = "// A run. `pars step --replay` with this file takes its steps again.\n".to_string();
        match &self.origin {
            Origin::File(script) => {
                let folder = path.parent().unwrap_or(Path::new(""));
                let _ = writeln!(out, "import \"{}\"", relative(script, folder).display());
                let values: Vec<String> =
                    self.values.iter().map(|(name, value, _)| format!("{name} = {value}")).collect();
                let with = if values.is_empty() { String::new() } else { format!(" with {}", values.join(", ")) };
                let subject = self.subject.split_whitespace().collect::<Vec<_>>().join(" ");
                let _ = writeln!(out, "start {subject}{with}");
            }
            Origin::Prompt => {
                for (name, entity) in self.environment.entities() {
                    match entity {
                        Entity::Observer(0) => {
                            let _ = writeln!(out, "observer {name}");
                        }
                        Entity::Observer(count) if name.as_str() != "At" => {
                            let names: Vec<String> = (1..=*count).map(|number| format!("x{number}")).collect();
                            let _ = writeln!(out, "observer {name}({})", names.join(", "));
                        }
                        _ => {}
                    }
                }
                for definition in self.stepper.definitions().iter() {
                    let _ = writeln!(out, "{definition}");
                }
                let _ = writeln!(out, "start {}", self.term);
            }
        }
        out + &self.stepper.save()
    }
}

/// The way from a folder to a file; the whole way where there is none.
fn relative(file: &Path, folder: &Path) -> PathBuf {
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let (Ok(file), Ok(folder)) = (file.canonicalize(), here.canonicalize()) else { return file.to_path_buf() };
    let (to, from): (Vec<Component>, Vec<Component>) = (file.components().collect(), folder.components().collect());
    let common = to.iter().zip(&from).take_while(|(one, two)| one == two).count();
    if common == 0 {
        return file;
    }
    let up = from.iter().skip(common).map(|_| Component::ParentDir);
    up.chain(to.iter().skip(common).copied()).collect()
}
