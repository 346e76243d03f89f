//! The house rules that a machine can hold.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder").flatten() {
        let path = entry.path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

fn modules() -> Vec<String> {
    let text = fs::read_to_string(root().join("src/lib.rs")).expect("lib.rs");
    let line = |line: &str| line.strip_prefix("pub mod ")?.strip_suffix(';').map(str::to_string);
    text.lines().filter_map(line).collect()
}

/// The module that a file belongs to.
fn module_of(path: &Path) -> String {
    let inside = path.strip_prefix(root().join("src")).expect("inside src");
    let first = inside.components().next().expect("a name").as_os_str().to_string_lossy().to_string();
    first.trim_end_matches(".rs").to_string()
}

#[test]
fn a_module_imports_only_what_stands_above_it() {
    let order: BTreeMap<String, usize> = modules().into_iter().enumerate().map(|(place, name)| (name, place)).collect();
    let mut files = Vec::new();
    sources(&root().join("src"), &mut files);
    let mut wrong = Vec::new();
    for file in files {
        let own = module_of(&file);
        let Some(place) = order.get(&own) else { continue };
        let text = fs::read_to_string(&file).expect("a source");
        let code: String = text
            .split("#[cfg(test)]")
            .next()
            .unwrap_or_default()
            .lines()
            .filter(|line| !line.trim_start().starts_with("//"))
            .collect();
        for piece in code.split("crate::").skip(1) {
            let name: String = piece.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
            if order.get(&name).is_some_and(|other| other > place) {
                wrong.push(format!("{} imports {name}, which stands below it", file.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_file_stays_small_enough_to_read() {
    let mut files = Vec::new();
    sources(&root().join("src"), &mut files);
    sources(&root().join("tests"), &mut files);
    assert!(files.len() > 20);
    let long: Vec<String> = files
        .iter()
        .map(|file| (file, fs::read_to_string(file).expect("a source").lines().count()))
        .filter(|(_, lines)| *lines > 500)
        .map(|(file, lines)| format!("{}: {lines} lines", file.display()))
        .collect();
    assert!(long.is_empty(), "{}", long.join("\n"));
}

#[test]
fn only_one_module_knows_egg() {
    let mut files = Vec::new();
    sources(&root().join("src"), &mut files);
    for file in files {
        let text = fs::read_to_string(&file).expect("a source");
        let uses = text.lines().any(|line| line.trim_start().starts_with("use egg::"));
        assert!(!uses || module_of(&file) == "rewrite", "{} uses egg", file.display());
    }
}

#[test]
fn above_the_line_nothing_can_panic_or_reach_outside() {
    let all = modules();
    let trusted: Vec<&String> = all.iter().take_while(|name| *name != "diagnostic").collect();
    assert!(trusted.iter().any(|name| *name == "kernel"));
    let mut files = Vec::new();
    sources(&root().join("src"), &mut files);
    for file in files {
        if !trusted.iter().any(|name| **name == module_of(&file)) {
            continue;
        }
        let text = fs::read_to_string(&file).expect("a source");
        let code = text.split("#[cfg(test)]").next().unwrap_or_default();
        for banned in [".unwrap()", ".expect(", "panic!(", "f64", "std::fs", "std::io", "unsafe "] {
            let found = code.lines().any(|line| !line.trim_start().starts_with("//") && line.contains(banned));
            assert!(!found, "{} has `{banned}`", file.display());
        }
    }
}

#[test]
fn the_map_of_the_paper_points_at_files_that_exist() {
    let text = fs::read_to_string(root().join("docs/paper.md")).expect("docs/paper.md");
    let mut seen = 0;
    for piece in text.split('`').skip(1).step_by(2) {
        if piece.contains('/') && piece.contains('.') && !piece.contains(' ') {
            seen += 1;
            assert!(root().join(piece).exists(), "docs/paper.md names {piece}");
        }
    }
    assert!(seen > 15);
}
