//! Draws as steps: finitely many outcomes with their chances; a value from a continuous distribution as a symbol.
//!
//! A draw with one outcome, or whose value is forgotten at once, is no step. A symbol is carried along as long as nothing
//! asks for its value; its name stands in the step that draws it, so that two processes with one and the same steps
//! hold the same symbols.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::rc::Rc;

use num_rational::BigRational;
use num_traits::{One, Zero};

use super::cut::Cuts;
use super::generate::Trouble;
use crate::model::{Action, Cells, Meaningless, Model, Move, State, mentions_drawn};
use crate::name::Name;
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
    /// Where values are cut into cells, if they are.
    cuts: Option<Cuts>,
    /// What the model knows of the values.
    cells: Rc<Cells>,
    /// The distribution of each symbol that stands for a value in a cell.
    from: RefCell<BTreeMap<Name, Value>>,
    /// Whether something that depends on such a value was seen.
    seen: Cell<bool>,
    /// How far the chances of one instant may be off together.
    slack: RefCell<BigRational>,
}

impl Draws {
    /// With symbols, or with cells.
    pub(super) fn new(cuts: Option<Cuts>) -> Draws {
        Draws { cuts, ..Draws::default() }
    }

    /// What the model is to know of the values.
    pub(super) fn cells(&self) -> Rc<Cells> {
        self.cells.clone()
    }

    /// How far the chances of one instant may be off together.
    pub(crate) fn slack(&self) -> BigRational {
        self.slack.borrow().clone()
    }

    /// Whether something was seen that depends on a value in a cell.
    pub(crate) fn seen(&self) -> bool {
        self.seen.get()
    }

    /// Whether the move is a draw that is made at once, and not a step.
    pub(super) fn is_made(&self, step: &Move) -> bool {
        match step.action {
            Action::Draw(_, Some(_)) => true,
            Action::Draw(_, None) => self.cuts.is_some(),
            _ => false,
        }
    }

    /// How a value is seen: itself, or between which probes it lies.
    ///
    /// # Errors
    /// [`Trouble::Cut`] and [`Trouble::Probe`] where smaller cells tell, [`Trouble::Draws`] where none do.
    pub(super) fn view(&self, value: &Value) -> Result<String, Trouble> {
        let Some(cuts) = self.cuts.as_ref().filter(|_| mentions_drawn(value)) else { return Ok(value.to_string()) };
        self.seen.set(true);
        let line = self.cells.line(value).ok_or(Trouble::Draws)?;
        let from = self.from.borrow().get(&line.0).cloned().ok_or(Trouble::Draws)?;
        if !cuts.knows(&from, &line.1, &line.2) {
            return Err(Trouble::Probe(Box::new((from, line.1, line.2))));
        }
        let probes: Vec<BigRational> = cuts.probes.iter().cloned().collect();
        let below = self.cells.between(&line, &probes).map_err(|(_, place)| Trouble::Cut(Box::new((from, place))))?;
        let end = |place: Option<&BigRational>, none: &str| place.map_or(none.to_string(), ToString::to_string);
        let low = end(below.checked_sub(1).and_then(|place| probes.get(place)), "-∞");
        Ok(format!("({low} .. {})", end(probes.get(below), "∞")))
    }

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
        let open = matches!(moves.first(), Some(Move { action: Action::Draw(_, None), .. })) || self.holds(state);
        if open && self.cuts.is_none() {
            self.touched.set(true);
        }
        Ok(moves)
    }

    fn holds(&self, state: &State) -> bool {
        self.met.get() && state.holds_drawn()
    }

    /// What comes after a state; where there is nothing, and the state holds a symbol, that is why.
    pub(super) fn sure<T>(&self, from: &State, after: Result<T, Meaningless>) -> Result<T, Trouble> {
        after.map_err(|why| match self.doubt() {
            Some(cut) => cut,
            None if self.holds(from) => Trouble::Draws,
            None => Trouble::Meaningless(why),
        })
    }

    /// The cut that leaves the last comparison in no doubt.
    fn doubt(&self) -> Option<Trouble> {
        let (symbol, place) = self.cells.take_doubt()?;
        let from = self.from.borrow().get(&symbol)?.clone();
        Some(Trouble::Cut(Box::new((from, place))))
    }

    /// The states after a draw from a continuous distribution, one for each cell, with the chances and how far they may
    /// be off together.
    fn by_cells(
        &self,
        model: &Model,
        state: &State,
        step: &Move,
    ) -> Result<(Vec<(State, BigRational)>, BigRational), Trouble> {
        let (Some(cuts), Action::Draw(from, _)) = (&self.cuts, &step.action) else { return Err(Trouble::Draws) };
        let from = from.first().ok_or(Trouble::Draws)?;
        let (cells, off) = cuts.cells(from).ok_or(Trouble::Draws)?;
        self.met.set(true);
        let mut all = Vec::new();
        for ((low, high), chance) in cells {
            let end =
                |end: &Option<BigRational>, none: &str| end.as_ref().map_or(none.to_string(), ToString::to_string);
            let text = format!("{from} within {} .. {}", end(&low, "-∞"), end(&high, "∞"));
            let symbol = state.next_drawn(&text);
            let name = symbol.as_variable().ok_or(Trouble::Draws)?.clone();
            self.cells.learn(&name, (low, high));
            self.from.borrow_mut().insert(name, from.clone());
            let after = model.state(&step.with(&symbol)).map_err(|_| self.doubt().unwrap_or(Trouble::Draws))?;
            all.push((after, chance));
        }
        Ok((all, off))
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
                Some(step) if self.is_made(step) => {
                    let mut outcomes = self.outcomes(model, &state)?.into_iter();
                    match (outcomes.next(), outcomes.next()) {
                        (Some((only, _)), None) => only,
                        _ => return Ok(state),
                    }
                }
                Some(step @ Move { action: Action::Draw(_, None), .. }) => {
                    let (symbol, after) = self.symbolic(model, &state, step)?;
                    if after.mentions(&symbol) {
                        return Ok(state);
                    }
                    after
                }
                _ => return Ok(state),
            };
        }
        Err(for_ever())
    }

    /// What the draws that are due come to, with the chances; what is drawn then is drawn too.
    pub(super) fn outcomes(&self, model: &Model, state: &State) -> Result<BTreeMap<State, BigRational>, Trouble> {
        let mut found: BTreeMap<State, BigRational> = BTreeMap::new();
        let mut open = vec![(state.clone(), BigRational::one(), BigRational::zero())];
        let mut made = 0;
        while let Some((state, chance, off)) = open.pop() {
            made += 1;
            if made > MOST_DRAWS {
                return Err(for_ever());
            }
            let moves = self.sure(&state, state.moves())?;
            let mut further = Vec::new();
            for step in &moves {
                if let Action::Draw(_, Some((_, part))) = &step.action {
                    further.push((self.sure(&state, model.state(&step.next))?, &chance * part, off.clone()));
                }
            }
            if let Some(step) = moves.first().filter(|step| further.is_empty() && self.is_made(step)) {
                let (cells, more) = self.by_cells(model, &state, step)?;
                further.extend(cells.into_iter().map(|(after, part)| (after, &chance * part, &off + &more)));
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
                Some(after) => open.push((after, chance, off)),
                None => {
                    let most = self.slack().max(off);
                    *self.slack.borrow_mut() = most;
                    *found.entry(state).or_default() += chance;
                }
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
