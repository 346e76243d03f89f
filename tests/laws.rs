//! The law table: each law that holds under a condition is not proved without it.

use pars::kernel::Theory;
use pars::library;
use pars::lower::{Claim, ClaimKind, Lowered};
use pars::parser::parse;
use pars::proof::Statement;
use pars::prove::{Answer, By, prove};
use pars::rewrite::Limits;

/// The claims that a text makes, with what they rest on.
fn claims(text: &str) -> (Theory, Vec<Claim>) {
    let mut environment = library::standard().unwrap_or_else(|errors| panic!("{} errors", errors.len()));
    let lowered = environment.declare(&parse(text).items, text);
    let claims = lowered.into_iter().flatten().filter_map(|lowered| match lowered {
        Lowered::Claim(claim) => Some(claim),
        _ => None,
    });
    let claims = claims.collect();
    let theory = Theory {
        assumptions: environment.assumptions.clone(),
        definitions: environment.definitions.clone(),
        laws: environment.laws.clone(),
    };
    (theory, claims)
}

fn proves(theory: &Theory, statement: &Statement) -> bool {
    let limits = Limits { rounds: 4, nodes: 2_000, ..Limits::default() };
    matches!(prove(theory, statement, &By::Search, limits, &|| false), Answer::Proved(..))
}

#[test]
fn no_law_is_proved_without_its_conditions() {
    let (theory, claims) = claims(include_str!("cases/laws/hold.pars"));
    let (mut tried, mut wrong) = (0, Vec::new());
    for claim in claims {
        let ClaimKind::Compare { left, right, connective, when, .. } = claim.kind else { continue };
        if when.is_empty() {
            continue;
        }
        tried += 1;
        let name = claim.name.map_or_else(String::new, |name| name.to_string());
        let with = |hypotheses| Statement { hypotheses, left: left.clone(), connective, right: right.clone() };
        if proves(&theory, &with(Vec::new())) {
            wrong.push(format!("{name}: {left} {connective} {right}"));
        }
        if std::env::var_os("PARS_EACH").is_some() {
            for place in 0..when.len() {
                let mut fewer = when.clone();
                let dropped = fewer.remove(place);
                if proves(&theory, &with(fewer)) {
                    println!("{name} is proved without {dropped}");
                }
            }
        }
    }
    assert!(tried > 60, "only {tried} conditional laws");
    assert!(wrong.is_empty(), "proved without their conditions:\n{}", wrong.join("\n"));
}
