//! Draws as steps: finitely many outcomes with their chances; a value from a continuous distribution as a symbol.
//!
//! A draw with one outcome, or whose value is forgotten at once, is no step. A symbol is carried along as long as nothing
//! asks for its value; its name stands in the step that draws it, so that two processes with one and the same steps
//! hold the same symbols.

use std::cell::Cell;
use std::collections::BTreeMap;

use num_rational::BigRational;
use num_traits::One;

use super::generate::Trouble;
use crate::model::{Action, Meaningless, Model, Move, State};
use crate::value::Value;

/// The most draws of one instant.
const MOST_DRAWS: usize = 2_000;

/// What is known of the draws of a process.
#[derive(Default)]
pub(crate) struct Draws {
    /// Whether a value was drawn that is not known.
    met: Cell<bool>,
    /// Whether a state was looked into that draws such a value, or holds one.
    touched: Cell<bool>,
}

impl Draws {
    /// Forgets that such a state was looked into.
    pub(crate) fn forget(&self) {
        self.touched.set(false);
    }

    /// Whether such a state was looked into.
    pub(crate) fn touched(&self) -> bool {
        self.touched.get()
    }

    /// The moves of a state.
    pub(super) fn look(&self, state: &State) -> Result<Vec<Move>, Trouble> {
        let moves = self.sure(state, state.moves())?;
        if matches!(moves.first(), Some(Move { action: Action::Draw(_, None), .. })) || self.holds(state) {
            self.touched.set(true);
        }
        Ok(moves)
    }

    fn holds(&self, state: &State) -> bool {
        self.met.get() && state.holds_drawn()
    }

    /// What comes after a state; where there is nothing, and the state holds a symbol, that is why.
    pub(super) fn sure<T>(&self, from: &State, after: Result<T, Meaningless>) -> Result<T, Trouble> {
        after.map_err(|why| if self.holds(from) { Trouble::Draws } else { Trouble::Meaningless(why) })
    }

    /// The state after a draw from a continuous distribution, with the symbol for its value.
    pub(super) fn symbolic(&self, model: &Model, state: &State, step: &Move) -> Result<(Value, State), Trouble> {
        self.met.set(true);
        let Action::Draw(from, _) = &step.action else { return Err(Trouble::Draws) };
        let symbol = state.next_drawn(from.first().ok_or(Trouble::Draws)?);
        let after = model.state(&step.with(&symbol)).map_err(|_| Trouble::Draws)?;
        Ok((symbol, after))
    }

    /// The state, with what is drawn and forgotten at once passed over, and draws that come out in one way made.
    pub(super) fn arrive(&self, model: &Model, mut state: State) -> Result<State, Trouble> {
        for _ in 0..MOST_DRAWS {
            let moves = self.sure(&state, state.moves())?;
            state = match moves.first() {
                Some(step @ Move { action: Action::Draw(_, None), .. }) => {
                    let (symbol, after) = self.symbolic(model, &state, step)?;
                    if after.mentions(&symbol) {
                        return Ok(state);
                    }
                    after
                }
                Some(Move { action: Action::Draw(_, Some(_)), .. }) => {
                    let mut outcomes = self.outcomes(model, &state)?.into_iter();
                    match (outcomes.next(), outcomes.next()) {
                        (Some((only, _)), None) => only,
                        _ => return Ok(state),
                    }
                }
                _ => return Ok(state),
            };
        }
        Err(for_ever())
    }

    /// What the draws that are due come to, with the chances; what is drawn then is drawn too.
    pub(super) fn outcomes(&self, model: &Model, state: &State) -> Result<BTreeMap<State, BigRational>, Trouble> {
        let mut found: BTreeMap<State, BigRational> = BTreeMap::new();
        let mut open = vec![(state.clone(), BigRational::one())];
        let mut made = 0;
        while let Some((state, chance)) = open.pop() {
            made += 1;
            if made > MOST_DRAWS {
                return Err(for_ever());
            }
            let moves = self.sure(&state, state.moves())?;
            let mut further = Vec::new();
            for step in &moves {
                if let Action::Draw(_, Some((_, part))) = &step.action {
                    further.push((self.sure(&state, model.state(&step.next))?, &chance * part));
                }
            }
            if !further.is_empty() {
                open.extend(further);
                continue;
            }
            let after = match moves.first() {
                Some(Move { action: Action::Draw(..), .. }) => self.forgotten(model, &state, &moves[0])?,
                _ => None,
            };
            match after {
                Some(after) => open.push((after, chance)),
                None => *found.entry(state).or_default() += chance,
            }
        }
        Ok(found)
    }

    /// The state after a draw from a continuous distribution whose value is forgotten at once.
    fn forgotten(&self, model: &Model, state: &State, step: &Move) -> Result<Option<State>, Trouble> {
        let (symbol, after) = self.symbolic(model, state, step)?;
        Ok((!after.mentions(&symbol)).then_some(after))
    }
}

fn for_ever() -> Trouble {
    Trouble::Meaningless(Meaningless { why: "it draws too often in no time".into() })
}
