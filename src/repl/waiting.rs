//! Declarations that are typed before what they mention: they wait, and are declared together with it.
//!
//! In a script the processes see each other whatever their order; at the prompt the paper's systems can be typed in the
//! order in which the paper has them.

use std::collections::BTreeSet;

use crate::ast::{Item, ItemKind, Term, TermKind};
use crate::diagnostic::nearest;
use crate::lower::{BASIC, Environment};
use crate::name::Name;
use crate::parser::parse_input;

/// The declarations that wait, in the order in which they were typed.
#[derive(Clone, Debug, Default)]
pub struct Waiting(Vec<Declaration>);

#[derive(Clone, Debug)]
struct Declaration {
    text: String,
    declares: BTreeSet<Name>,
    mentions: BTreeSet<Name>,
}

/// What is to be done with an input.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Turn {
    /// It is run, with all that waited for it.
    Run(String),
    /// It waits; what is said of that.
    Wait(String),
}

impl Waiting {
    /// Takes an input: what can be declared by now leaves the list.
    pub fn take(&mut self, environment: &Environment, line: &str) -> Turn {
        let Some(new) = Declaration::of(line) else { return Turn::Run(line.to_string()) };
        let known: BTreeSet<&str> = environment.entities().map(|(name, _)| name.as_str()).chain(BASIC).collect();
        // Typed anew, it takes the place of what waits under the same name.
        let others: Vec<Declaration> =
            self.0.iter().filter(|one| one.declares.is_disjoint(&new.declares)).cloned().collect();
        let (ready, rest) = ready(others, &new, &known);
        if let Some(ready) = ready {
            let texts: Vec<&str> = ready.iter().chain([&new]).map(|one| one.text.trim()).collect();
            self.0 = rest;
            return Turn::Run(texts.join("\n"));
        }
        // What is most likely a slip of the pen is an error at once.
        let coming: BTreeSet<&Name> = rest.iter().chain([&new]).flat_map(|one| &one.declares).collect();
        let is_known = |name: &Name| known.contains(name.as_str()) || coming.contains(name);
        let slip = |name: &Name| !is_known(name) && nearest(name.as_str(), known.iter().copied()).is_some();
        if new.mentions.iter().any(slip) {
            return Turn::Run(line.to_string());
        }
        self.0 = rest;
        self.0.push(new);
        let list = self.lines(environment);
        Turn::Wait(list.last().map(|line| format!("{line}\n")).unwrap_or_default())
    }

    /// Who waits for whom, a line each.
    pub fn lines(&self, environment: &Environment) -> Vec<String> {
        let waits: BTreeSet<&Name> = self.0.iter().flat_map(|one| &one.declares).collect();
        let line = |one: &Declaration| {
            let unknown = |name: &&Name| environment.entity(name).is_none() && !BASIC.contains(&name.as_str());
            let missing: Vec<&Name> =
                one.mentions.iter().filter(unknown).filter(|name| !one.declares.contains(*name)).collect();
            let new: Vec<&str> =
                missing.iter().filter(|name| !waits.contains(**name)).map(|name| name.as_str()).collect();
            let names: Vec<&str> =
                if new.is_empty() { missing.iter().map(|name| name.as_str()).collect() } else { new };
            let own: Vec<&str> = one.declares.iter().map(Name::as_str).collect();
            let (waits, are) = if own.len() == 1 { ("waits", "is") } else { ("wait", "are") };
            format!("{} {waits} for {}, and {are} declared with it", own.join(", "), names.join(", "))
        };
        self.0.iter().map(line).collect()
    }

    /// Forgets the last; false if there is none.
    pub fn forget(&mut self) -> bool {
        self.0.pop().is_some()
    }
}

/// Those of the others that can be declared together with the new one, if it can be itself; and those that cannot.
fn ready(
    others: Vec<Declaration>,
    new: &Declaration,
    known: &BTreeSet<&str>,
) -> (Option<Vec<Declaration>>, Vec<Declaration>) {
    let (mut ready, mut rest) = (others, Vec::new());
    loop {
        let declared: BTreeSet<Name> = ready.iter().chain([new]).flat_map(|one| one.declares.iter().cloned()).collect();
        let fits = |one: &Declaration| {
            one.mentions.iter().all(|name| known.contains(name.as_str()) || declared.contains(name))
        };
        let (fit, unfit): (Vec<Declaration>, Vec<Declaration>) = ready.into_iter().partition(fits);
        if unfit.is_empty() {
            return if fits(new) { (Some(fit), rest) } else { (None, fit.into_iter().chain(rest).collect()) };
        }
        rest.extend(unfit);
        ready = fit;
    }
}

impl Declaration {
    /// An input of nothing but declarations of processes and networks, read without an error.
    fn of(text: &str) -> Option<Declaration> {
        let parsed = parse_input(text);
        if !parsed.diagnostics.is_empty() || parsed.items.is_empty() {
            return None;
        }
        let (mut declares, mut mentions) = (BTreeSet::new(), BTreeSet::new());
        for Item { kind, .. } in &parsed.items {
            let (name, body) = match kind {
                ItemKind::Process(header, body) => (&header.name, body),
                ItemKind::System(name, body) | ItemKind::Property(name, body, _) => (name, body),
                _ => return None,
            };
            declares.insert(name.name.clone());
            mentions.extend(mentioned(body));
        }
        Some(Declaration { text: text.to_string(), declares, mentions })
    }
}

/// The names with a capital in a process.
fn mentioned(term: &Term) -> impl Iterator<Item = Name> + '_ {
    term.all().into_iter().filter_map(|part| match &part.kind {
        TermKind::Apply { name, .. } => Some(name.name.clone()),
        _ => None,
    })
}
