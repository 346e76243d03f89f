//! The shapes of the JSON, with every term as text.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::law::Connective;

/// The whole file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct File {
    pub format: String,
    pub theory: Theory,
    #[serde(default)]
    pub lemmas: Vec<Lemma>,
    pub claim: Claim,
    pub steps: Vec<Step>,
    pub seal: String,
}

/// A theorem that later ones use.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Lemma {
    pub name: String,
    pub claim: Claim,
    pub steps: Vec<Step>,
}

/// What the proof stands on, besides the program's own laws.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Theory {
    /// Parameters, functions, observers, processes: the text of a `.pars` file.
    pub declarations: String,
    /// Laws that are not the program's own: the text of a `.rules` file.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub rules: String,
}

/// What is proved.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Claim {
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub when: Vec<String>,
    pub left: String,
    #[serde(with = "ConnectiveText")]
    pub connective: Connective,
    pub right: String,
}

/// How a connective is written: `=`, `<=`, `~~`, `<~`.
#[derive(Serialize, Deserialize)]
#[serde(remote = "Connective")]
enum ConnectiveText {
    #[serde(rename = "=")]
    Equal,
    #[serde(rename = "<=")]
    Refines,
    #[serde(rename = "~~")]
    Weak,
    #[serde(rename = "<~")]
    WeaklyRefines,
}

/// What the metavariables of a law or of an earlier step stand for.
#[derive(Serialize, Deserialize, Default)]
#[serde(default, deny_unknown_fields)]
pub(super) struct Substitution {
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub processes: BTreeMap<String, String>,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub values: BTreeMap<String, String>,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub names: BTreeMap<String, String>,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub sets: BTreeMap<String, Vec<String>>,
}

/// One step; see [`crate::proof::Step`].
#[derive(Serialize, Deserialize)]
#[serde(tag = "step", rename_all = "kebab-case", deny_unknown_fields)]
pub(super) enum Step {
    Reflexive {
        term: String,
    },
    Symmetric {
        of: usize,
    },
    Transitive {
        of: Vec<usize>,
    },
    Congruence {
        context: String,
        holes: Vec<String>,
        of: Vec<usize>,
    },
    Law {
        law: String,
        with: Substitution,
    },
    Arithmetic {
        left: String,
        right: String,
    },
    Unfold {
        call: String,
    },
    Unique {
        name: String,
        candidate: String,
        equation: usize,
    },
    UniqueLoop {
        body: String,
        equation: usize,
    },
    Suppose {
        left: String,
        right: String,
    },
    Induction {
        variable: String,
        left: String,
        right: String,
        base: usize,
        successor: usize,
    },
    Instance {
        of: usize,
        with: Substitution,
    },
    Lemma {
        of: usize,
        with: Substitution,
    },
    Advance {
        network: String,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        time: Option<String>,
    },
    Draw {
        network: String,
        names: Vec<String>,
    },
    Cases {
        when: String,
        holds: usize,
        fails: usize,
    },
    Excluded {
        left: String,
        right: String,
    },
    Rounds {
        lemma: usize,
        variable: String,
        round: String,
        index: String,
        count: String,
    },
    Turns {
        lemma: usize,
        turn: String,
        moving: Vec<Moving>,
    },
    Trust {
        left: String,
        #[serde(with = "ConnectiveText")]
        connective: Connective,
        right: String,
        reason: String,
    },
}

/// A value that moves on; see [`crate::proof::Moving`].
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Moving {
    pub variable: String,
    pub name: String,
    pub start: String,
    pub next: String,
}
