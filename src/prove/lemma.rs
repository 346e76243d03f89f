//! Earlier theorems as laws: the search uses them by their names, and the proof carries their proofs along.

use std::collections::BTreeSet;

use super::{Answer, By, find, judged};
use crate::kernel::Theory;
use crate::law::Law;
use crate::name::Name;
use crate::proof::{Lemma, Proof, Statement, Step};
use crate::rewrite::Limits;
use crate::scope::metavariables;

/// A theorem that a claim may use by its name.
#[derive(Clone, Debug)]
pub struct Earlier {
    /// The name of the claim.
    pub name: Name,
    /// Its proof.
    pub proof: Proof,
}

impl Earlier {
    /// Which way it may be used: as it stands, or turned round, since a law's right side brings in nothing new.
    /// A refinement helps where the claim is one.
    ///
    /// # Errors
    /// Why it is of no use.
    fn law(&self, refines: bool) -> Result<Law, String> {
        let statement = &self.proof.statement;
        let (left, right) = (metavariables(&statement.left), metavariables(&statement.right));
        if !right.is_subset(&left) {
            let new: Vec<&str> = right.difference(&left).map(Name::as_str).collect();
            return Err(format!("{} stands on its right side alone: claim it the other way round", new.join(", ")));
        }
        if statement.connective.refines() && !refines {
            return Err(format!("it is a refinement (`{}`), which proves no equation", statement.connective));
        }
        Ok(Law {
            name: self.name.clone(),
            title: String::new(),
            source: String::new(),
            connective: statement.connective,
            oriented: false,
            conditions: statement.hypotheses.clone(),
            left: statement.left.clone(),
            right: statement.right.clone(),
            examples: Vec::new(),
        })
    }
}

/// Proves a statement as [`super::prove`] does, by laws and by earlier theorems.
///
/// # Errors
/// The name of a theorem that cannot be used so, and why.
pub fn prove_from(
    theory: &Theory,
    earlier: &[Earlier],
    statement: &Statement,
    by: &By<'_>,
    limits: Limits,
    interrupted: &dyn Fn() -> bool,
) -> Result<Answer, (Name, String)> {
    let mut wider = theory.clone();
    let refines = statement.connective.refines();
    for theorem in earlier {
        wider.laws.push(theorem.law(refines).map_err(|why| (theorem.name.clone(), why))?);
    }
    Ok(match find(&wider, statement, by, limits, interrupted) {
        Err(gap) => Answer::Open(gap),
        Ok(proof) => judged(theory, with_lemmas(proof, earlier)),
    })
}

/// The proof with the earlier theorems it uses as its lemmas, each after those that it uses itself.
fn with_lemmas(mut proof: Proof, earlier: &[Earlier]) -> Proof {
    let named = |step: &Step| if let Step::Law(name, _) = step { Some(name.clone()) } else { None };
    let used: BTreeSet<Name> = proof.steps.iter().filter_map(named).collect();
    let mut lemmas: Vec<Lemma> = Vec::new();
    for theorem in earlier.iter().filter(|theorem| used.contains(&theorem.name)) {
        let Proof { lemmas: own, statement, steps } = theorem.proof.clone();
        let mut places = Vec::with_capacity(own.len());
        for lemma in own.into_iter().chain([Lemma { name: theorem.name.clone(), statement, steps }]) {
            places.push(placed(&mut lemmas, lemma, &places));
        }
        let Some(place) = places.pop() else { continue };
        for step in &mut proof.steps {
            if let Step::Law(name, with) = step
                && *name == theorem.name
            {
                *step = Step::Lemma(place, std::mem::take(with));
            }
        }
    }
    Proof { lemmas, ..proof }
}

/// The place of a lemma among those of the whole proof; the lemmas that it uses have their places already.
fn placed(lemmas: &mut Vec<Lemma>, mut lemma: Lemma, places: &[usize]) -> usize {
    lemma.steps.iter_mut().for_each(|step| step.renumber(&|of| places.get(of).copied().unwrap_or(of)));
    lemmas.iter().position(|known| *known == lemma).unwrap_or_else(|| {
        lemmas.push(lemma);
        lemmas.len() - 1
    })
}
