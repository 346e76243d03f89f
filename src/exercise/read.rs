//! The exercises of a file.

use crate::admission::admit;
use crate::diagnostic::Source;
use crate::library::{self, Failure, Reader};
use crate::lower::{Environment, Exercise, Lowered};

/// The exercises of a file and of what it imports, in order, each with what was declared before it. A law of the file is
/// in force only if it stands up to the judge.
///
/// # Errors
/// What is wrong in it.
pub fn read(
    source: &Source,
    find: impl FnMut(&str, &str) -> Result<Source, String>,
    interrupted: &dyn Fn() -> bool,
) -> Result<Vec<(Exercise, Environment)>, Vec<Failure>> {
    let mut find = find;
    let mut environment = library::standard()?;
    let mut laws = environment.laws.clone();
    let mut exercises = Vec::new();
    let mut refused: Vec<Failure> = Vec::new();
    let mut reader = Reader::new(move |importer: &str, path: &str| match library::embedded(path) {
        // In force already.
        Some(source) => Ok(Source::new(source.name, "")),
        None => find(importer, path),
    });
    let mut failures = reader.read(&mut environment, source, &mut |environment, source, item, lowered| match lowered {
        Lowered::Exercise(exercise) => exercises.push((exercise, environment.clone())),
        Lowered::Law(law) => match admit(&laws, &law, item.span, interrupted) {
            Ok(_) => laws = environment.laws.clone(),
            Err(diagnostic) => {
                environment.laws = laws.clone();
                refused.push(Failure { source: source.clone(), diagnostics: vec![*diagnostic] });
            }
        },
        _ => {}
    });
    failures.extend(refused);
    if failures.is_empty() { Ok(exercises) } else { Err(failures) }
}
