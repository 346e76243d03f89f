//! The phases of a system as linear moves: what happens in a round, as a linear function of the state and the draws.

mod plain;

use std::collections::BTreeSet;

use num_rational::BigRational;
use num_traits::Zero;

use self::plain::plain;
use super::Question;
use super::disc::{Disc, round};
use crate::assumption::Assumptions;
use crate::distribution::Distribution;
use crate::invariant::Claim;
use crate::invariant::cases::{Case, disjoint};
use crate::name::Name;
use crate::period::{Edge, End, Next, Period, Test};
use crate::rational;
use crate::term::Term;
use crate::value::{Atom, Relation, Value, ValueError};

/// A linear form over the state and the draws of a move.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub struct Linear {
    /// The factor of each state variable.
    pub state: Vec<BigRational>,
    /// The factor of each draw.
    pub draws: Vec<BigRational>,
    /// What is added.
    pub constant: BigRational,
}

/// `form REL 0`, or with a disc `disc + form REL 0`; only a [`curved`] chain has discs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Side {
    /// The form; a number where there is a disc.
    pub form: Linear,
    /// How it compares with 0.
    pub relation: Relation,
    /// A sum of squares.
    pub disc: Option<Box<Disc>>,
}

impl Chain {
    /// Whether distances are compared.
    pub fn is_curved(&self) -> bool {
        let moves = || self.initial.iter().chain(self.phases.iter().flatten());
        let shown = moves().flat_map(|one| one.stretches.iter().flat_map(|stretch| stretch.shown.iter().flatten()));
        moves().flat_map(|one| &one.tests).chain(shown).any(|side| side.disc.is_some())
    }
}

impl Side {
    /// Without a disc.
    pub fn flat(form: Linear, relation: Relation) -> Side {
        Side { form, relation, disc: None }
    }

    /// The linear forms that are compared.
    pub fn forms(&self) -> impl Iterator<Item = &Linear> {
        let squares = self.disc.iter().flat_map(|disc| disc.squares.iter().map(|(_, form)| form));
        squares.chain(self.disc.is_none().then_some(&self.form))
    }

    /// The same over another state, of which this state is the image.
    pub fn after(&self, image: &[Linear]) -> Side {
        self.with(|form| form.after(image))
    }

    /// The same with other forms.
    pub(super) fn with(&self, change: impl Fn(&Linear) -> Linear) -> Side {
        let disc = self.disc.as_ref().map(|disc| Box::new(disc.with(&change)));
        Side { form: change(&self.form), relation: self.relation, disc }
    }
}

/// Alternatives, of which each is a conjunction and no two hold at once.
pub type Region = Vec<Vec<Side>>;

/// A stretch of time in a move.
#[derive(Clone, Debug)]
pub struct Stretch {
    /// How long; none: for ever.
    pub duration: Option<BigRational>,
    /// When what is asked for is shown in it.
    pub shown: Region,
    /// What the names of the event stand for in it, where they are linear.
    pub values: Vec<Linear>,
}

/// One way through a round, in which everything is linear.
#[derive(Clone, Debug)]
pub struct Move {
    /// What is drawn, independently.
    pub draws: Vec<Distribution>,
    /// When it is taken.
    pub tests: Vec<Side>,
    /// What passes.
    pub stretches: Vec<Stretch>,
    /// The variables of the next phase.
    pub image: Vec<Linear>,
    /// The next phase; none at the end.
    pub next: Option<usize>,
}

/// The moves of a system, for one event.
#[derive(Clone, Debug)]
pub struct Chain {
    /// At the start, where there are no variables.
    pub initial: Vec<Move>,
    /// From each phase.
    pub phases: Vec<Vec<Move>>,
    /// The names of the variables of each phase, where they are kept.
    pub variables: Vec<Vec<Name>>,
}

impl Chain {
    /// The same chain where what is shown last before a run ends is shown for ever: of what is to be shown by a time it does
    /// not matter for how long, and of what is to be shown at a time it does not where it lasts until then.
    pub fn with_lasting_ends(mut self, question: &Question) -> Chain {
        let ends = self.initial.iter_mut().chain(self.phases.iter_mut().flatten()).filter(|one| one.next.is_none());
        for one in ends.filter(|one| one.stretches.len() > 1) {
            let last = one.stretches.last_mut();
            let stays = |time: &BigRational| question.first || *time >= question.time;
            if let Some(last) = last.filter(|last| last.duration.as_ref().is_some_and(stays)) {
                last.duration = None;
            }
        }
        self
    }
}

/// The system as a chain, asked for what the claim describes.
///
/// # Errors
/// What is not linear, or not a number.
pub fn chain(period: &Period, event: &Claim, assumptions: &Assumptions) -> Result<Chain, String> {
    made(period, event, assumptions, false)
}

/// The same where distances in the plane may be compared, too: its tests may have discs.
///
/// # Errors
/// What is not linear, no distance, or not a number.
pub fn curved(period: &Period, event: &Claim, assumptions: &Assumptions) -> Result<Chain, String> {
    made(period, event, assumptions, true)
}

fn made(period: &Period, event: &Claim, assumptions: &Assumptions, curved: bool) -> Result<Chain, String> {
    let sizes: Vec<&[Name]> = period.phases.iter().map(|phase| phase.variables.as_slice()).collect();
    let all = |edges: &[Edge], variables: &[Name]| -> Result<Vec<Move>, String> {
        let mut moves = Vec::new();
        for edge in edges.iter().flat_map(|edge| plain(edge, variables)) {
            moves.extend(moves_of(&edge, (variables, curved), &sizes, event, assumptions)?);
        }
        Ok(moves)
    };
    Ok(Chain {
        initial: all(&period.initial, &[])?,
        phases: period.phases.iter().map(|phase| all(&phase.edges, &phase.variables)).collect::<Result<_, _>>()?,
        variables: period.phases.iter().map(|phase| phase.variables.clone()).collect(),
    })
}

/// What can be done about a duration that is no number.
fn lasting(duration: &Value) -> String {
    format!(
        "a round waits for {duration}, which is no number: chances of rounds are enclosed where each waits for a fixed time \
         (`Delay_{{1/5}}`); durations that are drawn are known for a process in a line, without a loop \
         (`Ran_D<x> ; Delay_x ; …`)"
    )
}

/// The names over which a move is linear.
pub(super) struct Names<'a> {
    pub state: &'a [Name],
    pub draws: Vec<Name>,
    /// Whether distances may be compared.
    curved: bool,
}

fn moves_of(
    edge: &Edge,
    (variables, curved): (&[Name], bool),
    sizes: &[&[Name]],
    event: &Claim,
    assumptions: &Assumptions,
) -> Result<Vec<Move>, String> {
    let names = Names { state: variables, draws: edge.draws.iter().map(|(name, _)| name.clone()).collect(), curved };
    let mut draws = Vec::new();
    for (_, distribution) in &edge.draws {
        draws.push(Distribution::of(distribution)?);
    }
    let mut tests = edge.tests.clone();
    let (next, images) = match &edge.next {
        Next::Phase(number) => {
            let wanted = sizes.get(*number).copied().unwrap_or_default();
            (Some(*number), wanted.iter().map(|name| edge.map.get(name)).collect::<Option<Vec<_>>>())
        }
        Next::End(_) => (None, Some(Vec::new())),
    };
    let images = images.ok_or("a phase has a variable without a value")?;
    // What a piece of the image is becomes a test where it has maxima and conditions, which split into cases too.
    let place = |place: usize| Name::new(&format!("image~{place}"));
    let in_cases = |image: &&Value| image.atoms().iter().any(|atom| !matches!(atom, Atom::Variable(_)));
    for (number, image) in images.iter().enumerate().filter(|(_, image)| in_cases(image)) {
        let left = Value::variable(&place(number));
        tests.push(Test { relation: Relation::Eq, left, right: (*image).clone() });
    }
    let mut moves = Vec::new();
    for case in by_state(assumptions, &tests, &names.draws).map_err(|error| error.0)? {
        let plain = |image: &&Value| if in_cases(image) { Ok(Linear::default()) } else { names.linear(image) };
        let mut image = images.iter().map(plain).collect::<Result<Vec<_>, _>>()?;
        let mut sides = Vec::new();
        for test in &case.tests {
            match (0..images.len()).find(|number| test.left.as_variable() == Some(&place(*number))) {
                Some(number) => image[number] = names.linear(&test.right)?,
                None => sides.push(names.side(test)?),
            }
        }
        let mut stretches = Vec::new();
        for segment in &edge.segments {
            let duration = segment.duration.as_rational();
            let duration = duration.ok_or_else(|| lasting(&segment.duration))?;
            let shown = names.region(event, &segment.observed, assumptions)?;
            stretches.push(Stretch { duration: Some(duration), shown, values: names.values(event, &segment.observed) });
        }
        if let Next::End(End::Silent { observed, .. }) = &edge.next {
            let shown = names.region(event, observed, assumptions)?;
            stretches.push(Stretch { duration: None, shown, values: names.values(event, observed) });
        }
        moves.push(Move { draws: draws.clone(), tests: sides, stretches, image, next });
    }
    Ok(moves)
}

/// The cases of tests, first by what the state alone decides: what a maximum over draws is compared with is less then.
fn by_state(assumptions: &Assumptions, tests: &[Test], draws: &[Name]) -> Result<Vec<Case>, ValueError> {
    if draws.is_empty() {
        return disjoint(assumptions, tests);
    }
    let mut decided = BTreeSet::new();
    let mut open: Vec<Value> = tests.iter().flat_map(|test| [test.left.clone(), test.right.clone()]).collect();
    while let Some(value) = open.pop() {
        for atom in value.atoms() {
            let plain = !draws.iter().any(|draw| atom.mentions(draw));
            match &atom {
                Atom::Maximum(_) | Atom::Positive(_) if plain => {
                    decided.insert(atom.value()?);
                }
                Atom::Maximum(parts) => open.extend(parts.iter().cloned()),
                Atom::Positive(part) => open.push(part.clone()),
                _ => {}
            }
        }
    }
    if decided.is_empty() {
        return disjoint(assumptions, tests);
    }
    let named = decided.into_iter().enumerate();
    let wanted = named.map(|(place, right)| Test {
        relation: Relation::Eq,
        left: Value::variable(&Name::new(&format!("decided~{place}"))),
        right,
    });
    let mut cases = Vec::new();
    for case in disjoint(assumptions, &wanted.collect::<Vec<Test>>())? {
        // What decides is said again, as tests of its own.
        let mut known = assumptions.clone();
        let own = |test: &&Test| !test.left.as_variable().is_some_and(|name| name.as_str().starts_with("decided~"));
        let own: Vec<Test> = case.tests.iter().filter(own).cloned().collect();
        own.iter().for_each(|test| known.assume(test.relation, &test.left, &test.right));
        let simple = tests.iter().map(|test| {
            let [left, right] = [&test.left, &test.right].map(|side| known.simplify(side));
            Test { relation: test.relation, left, right }
        });
        let all: Vec<Test> = own.iter().cloned().chain(simple).collect();
        cases.extend(disjoint(assumptions, &all)?);
    }
    Ok(cases)
}

impl Names<'_> {
    fn linear(&self, value: &Value) -> Result<Linear, String> {
        let mut rest = value.clone();
        let mut take = |name: &Name| -> Result<BigRational, String> {
            if !rest.mentions(name) {
                return Ok(BigRational::zero());
            }
            let parts = rest.linear_in(name);
            let (factor, other) = parts.ok_or_else(|| format!("{value} is not linear in {name}"))?;
            rest = other;
            factor.as_rational().ok_or_else(|| format!("{factor}, the factor of {name}, is not a number"))
        };
        let state = self.state.iter().map(&mut take).collect::<Result<_, _>>()?;
        let draws = self.draws.iter().map(&mut take).collect::<Result<_, _>>()?;
        let constant = rest.as_rational().ok_or_else(|| format!("{rest} is not a number"))?;
        Ok(Linear { state, draws, constant })
    }

    fn side(&self, test: &Test) -> Result<Side, String> {
        let difference = test.left.sub(&test.right).map_err(|error| error.0)?;
        let flat = self.linear(&difference).map(|form| Side::flat(form, test.relation));
        flat.or_else(|reason| {
            let disc = if self.curved { round(self, &difference, test.relation) } else { None };
            disc.ok_or(reason)
        })
    }

    /// What the names of an event stand for, in their order.
    fn values(&self, event: &Claim, observed: &[Term]) -> Vec<Linear> {
        let zero = |name: &Name| Test { relation: Relation::Eq, left: Value::variable(name), right: Value::zero() };
        let asked = Claim { tests: event.variables.iter().map(zero).collect(), ..event.clone() };
        let duties = asked.duties(observed).unwrap_or_default();
        let tests = duties.first().map(|duty| duty.tests.as_slice()).unwrap_or_default();
        tests.iter().filter_map(|test| self.linear(&test.left).ok()).collect()
    }

    /// When an event is shown.
    fn region(&self, event: &Claim, observed: &[Term], assumptions: &Assumptions) -> Result<Region, String> {
        let mut region = Region::new();
        let duties = event.duties(observed).map_err(|error| error.0)?;
        if duties.len() > 1 {
            return Err("what is asked for is shown twice at one time".to_string());
        }
        for duty in duties {
            let tests = [duty.premises, duty.tests].concat();
            for case in disjoint(assumptions, &tests).map_err(|error| error.0)? {
                region.push(case.tests.iter().map(|test| self.side(test)).collect::<Result<_, _>>()?);
            }
        }
        Ok(region)
    }
}

impl Linear {
    /// The state part and the constant over another state, of which this state is the image.
    pub fn after(&self, image: &[Linear]) -> Linear {
        let parts = || self.state.iter().zip(image);
        let zeros = |length: Option<usize>| vec![BigRational::zero(); length.unwrap_or(0)];
        let mut result = Linear {
            state: zeros(parts().map(|(_, part)| part.state.len()).max()),
            draws: zeros(parts().map(|(_, part)| part.draws.len()).max()),
            constant: self.constant.clone(),
        };
        for (factor, part) in parts().filter(|(factor, _)| !factor.is_zero()) {
            let into = |sums: &mut Vec<BigRational>, numbers: &[BigRational]| {
                sums.iter_mut().zip(numbers).for_each(|(sum, number)| add_product(sum, factor, number));
            };
            into(&mut result.state, &part.state);
            into(&mut result.draws, &part.draws);
            add_product(&mut result.constant, factor, &part.constant);
        }
        result
    }

    /// A multiple.
    pub fn scaled(&self, factor: &BigRational) -> Linear {
        let scale = |number: &BigRational| {
            if number.is_zero() { BigRational::zero() } else { rational::product(number, factor) }
        };
        let all = |numbers: &[BigRational]| numbers.iter().map(scale).collect();
        Linear { state: all(&self.state), draws: all(&self.draws), constant: scale(&self.constant) }
    }

    /// The sum.
    pub fn plus(&self, other: &Linear) -> Linear {
        Linear {
            state: sum(&self.state, &other.state),
            draws: sum(&self.draws, &other.draws),
            constant: &self.constant + &other.constant,
        }
    }
}

/// Adds a product to a sum; most of them are 0.
pub(super) fn add_product(sum: &mut BigRational, one: &BigRational, other: &BigRational) {
    if !one.is_zero() && !other.is_zero() {
        let product = rational::product(one, other);
        *sum = if sum.is_zero() { product } else { rational::sum(sum, &product) };
    }
}

fn sum(one: &[BigRational], other: &[BigRational]) -> Vec<BigRational> {
    let zero = BigRational::zero();
    let places = 0..one.len().max(other.len());
    places.map(|place| rational::sum(one.get(place).unwrap_or(&zero), other.get(place).unwrap_or(&zero))).collect()
}
