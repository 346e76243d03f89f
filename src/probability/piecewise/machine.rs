//! The chain in machine numbers: round by round from the end.

use num_rational::BigRational;
use num_traits::{Signed, Zero};

use super::super::Enclosed;
use super::super::broken::{Broken, Expected, Kernel};
use super::super::chain::Region;
use super::super::kernel::near;
use super::super::noise::Noise;
use super::super::region::Set;
use super::{LEAST_CELLS, Target, Way, ends, holds, lies_in};
use crate::interval::Interval;

/// The chain in machine numbers.
pub(super) struct Machine {
    /// Whether what is asked for may be shown in any round.
    pub first: bool,
    pub phases: Vec<Vec<Way>>,
    /// By phase, where what is asked for is shown.
    pub shown: Vec<Set>,
    pub regions: Vec<Region>,
    pub nodes: Vec<Vec<f64>>,
}

/// A kernel, its noise, and the places that it ends at.
struct Stage {
    kernel: Kernel,
    noise: Noise,
    places: Vec<f64>,
}

/// The value at both ends of a cell, and what lies between errs by.
type Cell = (f64, f64, f64);

impl Machine {
    /// The chance from the start: known states are followed exactly until noise sets in.
    pub fn chance(&self, initial: &[Way], rounds: u64) -> Result<Enclosed, String> {
        let sure = |holds: bool| Ok(Enclosed::within(Interval::exactly(f64::from(u8::from(holds)))));
        let (mut ways, mut place, mut left) = (initial, BigRational::zero(), rounds);
        let mut phase = None;
        loop {
            let open: Vec<&Way> = ways.iter().filter(|way| way.open_at(&place)).collect();
            let below = left.checked_sub(u64::from(phase.is_some()));
            let Some(below) = below else { return sure(false) };
            let ([only], true) = (open.as_slice(), open.iter().all(|way| way.noises.is_empty())) else {
                return self.chance_from(&open, &place, below);
            };
            let Target::Phase(next) = only.target else {
                return sure(holds(&only.region, &place));
            };
            place = only.image(&place);
            (phase, left, ways) = (Some(next), below, self.phases[next].as_slice());
            let shown = holds(&self.regions[next], &place);
            if (self.first && shown) || left == 0 {
                return sure(shown);
            }
        }
    }

    /// The chance from a known state by ways that draw, with so many rounds left behind them.
    fn chance_from(&self, open: &[&Way], place: &BigRational, rounds: u64) -> Result<Enclosed, String> {
        let mut values: Vec<Broken> = (0..self.phases.len()).map(|phase| self.last(phase)).collect();
        let stages: Vec<Vec<Vec<Stage>>> = (0..self.phases.len())
            .map(|phase| self.phases[phase].iter().map(|way| self.stages(way, &self.nodes[phase])).collect())
            .collect();
        for _ in 0..rounds {
            values = (0..self.phases.len()).map(|phase| self.before(phase, &stages[phase], &values)).collect();
        }
        let (mut sum, mut error) = (0.0, 0.0);
        for way in open {
            let at = near(&way.image(place));
            let stages = self.stages_to(way, vec![at]);
            let (value, _, wrong) = self.cells(way, &stages, &values, &[at])[0];
            (sum, error) = (sum + value, error + wrong);
        }
        Ok(Enclosed::within(Interval::between(sum - error, sum + error).probability()))
    }

    /// What is asked for at once.
    fn last(&self, phase: usize) -> Broken {
        let nodes = &self.nodes[phase];
        let value = |place: f64| f64::from(u8::from(lies_in(&self.shown[phase], place)));
        Broken::flat(nodes, &value)
    }

    /// The chances from a phase, from those with a round less.
    fn before(&self, phase: usize, stages: &[Vec<Stage>], values: &[Broken]) -> Broken {
        let nodes = &self.nodes[phase];
        let mut found = Broken::flat(nodes, &|_| 0.0);
        found.outside = [(0.0, 1.0); 2];
        let single = nodes.is_empty();
        if single {
            found.outside = [(0.0, 0.0); 2];
        }
        for (way, stages) in self.phases[phase].iter().zip(stages) {
            let cells = self.cells(way, stages, values, &way.places(nodes));
            if single {
                found
                    .outside
                    .iter_mut()
                    .for_each(|(value, error)| (*value, *error) = (*value + cells[0].0, *error + cells[0].2));
                continue;
            }
            for (place, ends) in nodes.windows(2).enumerate() {
                if lies_in(&way.states, (ends[0] + ends[1]) / 2.0) {
                    let (left, right, error) = cells[place.min(cells.len() - 1)];
                    found.cells[place].0 += left;
                    found.cells[place].1 += right;
                    found.errors[place] += error;
                }
            }
        }
        if self.first && !single {
            found.put(&|place| lies_in(&self.shown[phase], place).then_some(1.0));
        }
        found
    }

    /// What a way gives for each cell of its phase, or for all of it.
    fn cells(&self, way: &Way, stages: &[Stage], values: &[Broken], places: &[f64]) -> Vec<Cell> {
        let mut function = self.integrand(way, values);
        let Some((last, first)) = stages.split_last() else { return function.pushed(places) };
        for stage in first {
            let expected = function.expected(&stage.kernel, &stage.noise);
            function = Broken::through(stage.places.clone(), &expected);
        }
        let Expected { mut values, errors, mut between } = function.expected(&last.kernel, &last.noise);
        if let ([value], [error]) = (values.as_slice(), errors.as_slice()) {
            return vec![(*value, *value, *error)];
        }
        if way.slope.is_negative() {
            values.reverse();
            between.reverse();
        }
        values.windows(2).zip(between).map(|(ends, error)| (ends[0], ends[1], error)).collect()
    }

    /// The chance behind a way, over its number.
    fn integrand(&self, way: &Way, values: &[Broken]) -> Broken {
        let nodes = self.nodes_behind(way);
        let taken = |place: f64| lies_in(&way.taken, place);
        match &way.target {
            Target::Shown(set) => {
                Broken::flat(&nodes, &|place| f64::from(u8::from(taken(place) && lies_in(set, place))))
            }
            Target::Phase(next) if self.nodes[*next].is_empty() => {
                let (value, error) = values[*next].outside[0];
                let mut found = Broken::flat(&nodes, &|place| if taken(place) { value } else { 0.0 });
                found.errors.fill(error);
                found.outside.iter_mut().for_each(|outside| outside.1 = error);
                found
            }
            Target::Phase(next) => {
                let mut found = values[*next].clone();
                found.put(&|place| (!taken(place)).then_some(0.0));
                found
            }
        }
    }

    /// The nodes over which the number of a way is summed.
    fn nodes_behind(&self, way: &Way) -> Vec<f64> {
        let mut nodes: Vec<f64> = match &way.target {
            Target::Phase(next) if !self.nodes[*next].is_empty() => return self.nodes[*next].clone(),
            Target::Phase(_) => ends(&way.taken).collect(),
            Target::Shown(set) => ends(&way.taken).chain(ends(set)).collect(),
        };
        nodes.sort_by(f64::total_cmp);
        nodes.dedup();
        nodes
    }

    fn stages(&self, way: &Way, nodes: &[f64]) -> Vec<Stage> {
        let mut places = way.places(nodes);
        if way.slope.is_negative() {
            places.reverse();
        }
        self.stages_to(way, places)
    }

    /// The kernels of the noises of a way, to these places in rising order.
    fn stages_to(&self, way: &Way, places: Vec<f64>) -> Vec<Stage> {
        let mut nodes = self.nodes_behind(way);
        if nodes.is_empty() {
            nodes.push(0.0);
        }
        let reaches: Vec<(f64, f64)> = way.noises.iter().map(Noise::reach).collect();
        let cells = nodes.len().max(places.len()).max(LEAST_CELLS as usize);
        let mut stages = Vec::new();
        for (number, noise) in way.noises.iter().enumerate() {
            let later = &reaches[number + 1..];
            let places = if later.is_empty() {
                places.clone()
            } else {
                let low = places[0] + later.iter().map(|reach| reach.0).sum::<f64>();
                let high = places[places.len() - 1] + later.iter().map(|reach| reach.1).sum::<f64>();
                (0..=cells).map(|place| low + (high - low) * place as f64 / cells as f64).collect()
            };
            let kernel = Kernel::new(&nodes, places.clone(), noise);
            nodes = places.clone();
            stages.push(Stage { kernel, noise: noise.clone(), places });
        }
        stages
    }
}
