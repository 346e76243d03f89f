//! Every law in `rules/` is judged by the executable meaning.

use std::path::{Path, PathBuf};

use pars::lower::Environment;
use pars::parser::parse;
use pars::refute::{Limits, Refutation, judge};

#[test]
fn every_law_in_the_rules_stands() {
    let folder = std::env::var_os("PARS_RULES").map(PathBuf::from);
    let folder = folder.unwrap_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("rules"));
    let mut files: Vec<_> = std::fs::read_dir(folder).expect("rules").flatten().map(|entry| entry.path()).collect();
    files.retain(|path| path.extension().is_some_and(|extension| extension == "rules"));
    files.sort();
    let instances = std::env::var("PARS_INSTANCES").ok().and_then(|text| text.parse().ok()).unwrap_or(3_000);
    let limits = Limits { instances, choices: 100 * instances, ..Limits::default() };
    let (mut failed, mut judged) = (Vec::new(), 0);
    for file in files {
        let text = std::fs::read_to_string(&file).expect("a rule file");
        let parsed = parse(&text);
        let mut environment = Environment::new();
        let prelude = "observer At(r)\n";
        environment.declare(&parse(prelude).items, prelude);
        let lowered = environment.declare(&parsed.items, &text);
        for problem in lowered.into_iter().filter_map(Result::err) {
            failed.push(format!("{}: {problem:?}", file.display()));
        }
        for law in environment.laws.iter() {
            judged += 1;
            match judge(law, &limits) {
                Refutation::Refuted(found) => failed.push(format!("{}: {found:?}", law.name)),
                Refutation::None { cost, instances, meaningless, open, .. } => {
                    println!("{}: {instances} up to {cost}, {meaningless} meaningless, {open} open", law.name);
                    if instances == meaningless {
                        failed.push(format!("{}: nothing tried", law.name));
                    }
                }
            }
        }
    }
    assert!(failed.is_empty(), "{} of {judged}:\n{}", failed.len(), failed.join("\n\n"));
    assert!(judged > 0);
}
