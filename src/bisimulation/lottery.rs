//! Draws with finitely many branches: the chances of what comes after them, and when those of two sides differ.

use std::collections::BTreeMap;

use num_rational::BigRational;
use num_traits::One;

use super::draw::distinct;
use super::game::{Game, MOST_DRAWS};
use crate::model::Meaningless;

impl Game<'_> {
    /// The chances of the states after all draws that are due, equal states together.
    pub(super) fn spread(
        &mut self,
        branches: Vec<(BigRational, usize)>,
    ) -> Result<Vec<(BigRational, usize)>, Meaningless> {
        let mut all: BTreeMap<usize, BigRational> = BTreeMap::new();
        for (chance, place) in branches {
            // A draw may follow a draw, but a round of a loop must also wait or communicate.
            self.drawing += 1;
            if self.drawing > MOST_DRAWS {
                return Err(Meaningless { why: "it draws for ever in no time".into() });
            }
            let further = self.seen(place)?.chances.clone();
            self.drawing -= 1;
            if further.is_empty() {
                *all.entry(place).or_default() += chance;
            } else {
                for (more, place) in further {
                    *all.entry(place).or_default() += &chance * more;
                }
            }
        }
        Ok(all.into_iter().map(|(place, chance)| (chance, place)).collect())
    }

    /// Whether the branches that are still alike, taken together, have different chances on the two sides.
    pub(super) fn unbalanced(&self, place: usize, pairs: &[usize]) -> bool {
        let chance = |place: usize, other: &[usize]| other.iter().position(|known| *known == place);
        let rows = distinct(pairs.iter().map(|pair| self.pairs[*pair].0.0));
        let columns = distinct(pairs.iter().map(|pair| self.pairs[*pair].0.1));
        // Groups by flooding: a row's group is the least row it is linked to.
        let mut group: Vec<usize> = (0..rows.len() + columns.len()).collect();
        for pair in pairs.iter().filter(|pair| self.marks[**pair].is_none()) {
            let (row, column) = self.pairs[*pair].0;
            if let (Some(row), Some(column)) = (chance(row, &rows), chance(column, &columns)) {
                let (from, to) = (group[rows.len() + column], group[row]);
                group.iter_mut().filter(|member| **member == from).for_each(|member| *member = to);
            }
        }
        let (left, right) = self.pairs[place].0;
        let mut balance: BTreeMap<usize, BigRational> = BTreeMap::new();
        for (chance_of, place) in self.chances(left) {
            if let Some(row) = chance(place, &rows) {
                *balance.entry(group[row]).or_default() += chance_of;
            }
        }
        for (chance_of, place) in self.chances(right) {
            if let Some(column) = chance(place, &columns) {
                *balance.entry(group[rows.len() + column]).or_default() -= chance_of;
            }
        }
        balance.values().any(|left| *left != BigRational::default())
    }

    pub(super) fn chances(&self, place: usize) -> Vec<(BigRational, usize)> {
        match &self.seen[place] {
            Some(seen) if !seen.chances.is_empty() => seen.chances.clone(),
            _ => vec![(BigRational::one(), place)],
        }
    }
}
