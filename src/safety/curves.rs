//! Candidates for invariants of a motion in the plane, or of a place with its speed: half planes in place of circles, along
//! the motion too, and the ellipses and strips that a linear map of two variables keeps.
//!
//! A map `z' = M*z + e` of the plane whose eigenvalues are complex multiplies the form `c*x^2 + (d-a)*x*y - b*y^2` by the
//! determinant of M = (a b; c d), about the point that stays; a left eigenvector w multiplies `w*z` by its eigenvalue.

use std::collections::BTreeSet;

use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use super::candidates::entries;
use super::later::{between, observed};
use crate::assumption::Assumptions;
use crate::invariant::Claim;
use crate::invariant::circle::{Planes, Round, root};
use crate::name::Name;
use crate::period::{Edge, Next, Period, Phase, Test};
use crate::simplest::simplest;
use crate::value::{Relation, Value};

/// Variables of a phase of which pairs are looked at.
const MOST_VARIABLES: usize = 8;
/// Rounds in which it is seen between which numbers a variable lies.
const OBSERVED: usize = 64;

/// What is looked for.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// The curves that the rounds of a phase keep.
    Kept,
    /// These, and between which numbers the variables lie in the first rounds.
    Seen,
    /// The curves, and half planes from which the claim follows.
    All,
}

impl Kind {
    /// All kinds, those that take little work first.
    pub(super) const EACH: [Kind; 3] = [Kind::Kept, Kind::Seen, Kind::All];
}

/// What may hold in each phase beside what is claimed and asked; none where there is nothing.
pub(super) fn curves(
    period: &Period,
    claim: &Claim,
    assumptions: &Assumptions,
    kind: Kind,
) -> Option<Vec<BTreeSet<Test>>> {
    let (mut all, mut round) = (Vec::new(), false);
    let seen = if kind == Kind::Seen { observed(period, assumptions, OBSERVED) } else { Vec::new() };
    let mut seen = seen.into_iter();
    for (number, phase) in period.phases.iter().enumerate() {
        let mut tests = BTreeSet::new();
        for segment in phase.edges.iter().filter_map(|edge| edge.segments.first()) {
            let duties = claim.duties(&segment.observed).ok()?;
            for test in duties.iter().filter(|duty| duty.premises.is_empty()).flat_map(|duty| &duty.tests) {
                let Some(claimed) = Round::of(test) else { continue };
                round = true;
                if kind == Kind::All {
                    tests.extend(claimed.planes().iter().flat_map(Planes::tests).cloned());
                    tests.extend(phase.edges.iter().filter_map(|edge| beside(&claimed, edge)).flatten());
                }
            }
        }
        tests.extend(kept(period, number, phase));
        tests.extend(seen.next().into_iter().flatten());
        tests.retain(|test| !test.left.variables().is_empty() || !test.right.variables().is_empty());
        all.push(tests);
    }
    let some = all.iter().any(|tests| !tests.is_empty());
    // Without a circle in the claim there are no half planes, and the curves alone were looked for before.
    if kind == Kind::All { round.then_some(all) } else { some.then_some(all) }
}

/// Half planes along a motion by the same step each time: what lies beside it stays there.
fn beside(round: &Round, edge: &Edge) -> Option<Vec<Test>> {
    let [one, other] = round.squares.as_slice() else { return None };
    let step = |form: &Value| form.substitute(&edge.map).ok()?.sub(form).ok();
    let (first, second) = (step(&one.form)?, step(&other.form)?);
    let factors = match (first.is_zero(), second.is_zero()) {
        (true, true) => return None,
        (true, false) => [BigRational::one(), BigRational::zero()],
        _ => [-second.div(&first).ok()?.as_rational()?, BigRational::one()],
    };
    let opposite: Vec<BigRational> = factors.iter().map(|factor| -factor).collect();
    Some([factors.as_slice(), &opposite].iter().filter_map(|factors| round.beyond(factors)).collect())
}

/// A linear map of two variables of a phase, `x' = a*x + b*y + e` and `y' = c*x + d*y + f`.
struct Map {
    variables: [Value; 2],
    rows: [[BigRational; 2]; 2],
    steps: [BigRational; 2],
}

/// What the rounds of a phase keep, from where it is entered: of each pair of variables that depend on no other.
fn kept(period: &Period, number: usize, phase: &Phase) -> Vec<Test> {
    let mut found = Vec::new();
    let Some(edge) = phase.edges.iter().find(|edge| edge.next == Next::Phase(number)) else { return found };
    let names: Vec<&Name> = phase.variables.iter().take(MOST_VARIABLES).collect();
    for (place, one) in names.iter().enumerate() {
        found.extend(alone(period, number, edge, one).unwrap_or_default());
        for other in &names[place + 1..] {
            let Some(map) = Map::of(edge, one, other) else { continue };
            let starts: Vec<[BigRational; 2]> = entries(period, number)
                .filter_map(|edge| Some([edge.map.get(*one)?.as_rational()?, edge.map.get(*other)?.as_rational()?]))
                .collect();
            found.extend(map.kept(&starts).unwrap_or_default());
        }
    }
    found
}

/// Bounds of a variable: where its rounds go on from itself alone, between what these keep it; else from its first values.
fn alone(period: &Period, number: usize, edge: &Edge, name: &Name) -> Option<Vec<Test>> {
    let starts: Vec<BigRational> =
        entries(period, number).filter_map(|edge| edge.map.get(name)?.as_rational()).collect();
    let own = edge.map.get(name).and_then(|image| image.linear_in(name));
    let own = own.and_then(|(factor, step)| Some((factor.as_rational()?, step.as_rational()?)));
    match own {
        Some((factor, step)) => strips(&Value::variable(name), &factor, &step, &starts),
        None => Some(between(&Value::variable(name), starts.iter().min()?, starts.iter().max()?).to_vec()),
    }
}

impl Map {
    fn of(edge: &Edge, one: &Name, other: &Name) -> Option<Map> {
        let row = |name: &Name| {
            let (first, rest) = edge.map.get(name)?.linear_in(one)?;
            let (second, step) = rest.linear_in(other)?;
            Some(([first.as_rational()?, second.as_rational()?], step.as_rational()?))
        };
        let ((first, step), (second, other_step)) = (row(one)?, row(other)?);
        let variables = [Value::variable(one), Value::variable(other)];
        Some(Map { variables, rows: [first, second], steps: [step, other_step] })
    }

    fn kept(&self, starts: &[[BigRational; 2]]) -> Option<Vec<Test>> {
        let [[a, b], [c, d]] = &self.rows;
        // Where neither depends on the other, each is looked at by itself elsewhere.
        if starts.is_empty() || b.is_zero() && c.is_zero() {
            return None;
        }
        let (trace, determinant) = (a + d, a * d - b * c);
        let four = BigRational::from_integer(4.into());
        let apart = &trace * &trace - &four * &determinant;
        if apart.is_negative() {
            let form = [c.clone(), d - a, -b];
            return self.ellipses(&form, &determinant, starts);
        }
        let two = BigRational::from_integer(2.into());
        let (least, most) = root(&apart);
        // Nearly an eigenvector is enough where all comes nearer: the simplest number will do.
        let part = BigRational::new(1.into(), 1_000.into());
        let width = if least == most {
            least
        } else {
            simplest(&(&least * (BigRational::one() - &part)), &(most * (BigRational::one() + part)))
        };
        let values = [(&trace + &width) / &two, (&trace - &width) / &two];
        let vectors =
            values.clone().map(|value| if c.is_zero() { [&value - d, b.clone()] } else { [c.clone(), value - a] });
        let exact = &width * &width == apart;
        let mut tests = Vec::new();
        for (value, vector) in values.iter().zip(&vectors).filter(|_| exact) {
            tests.extend(self.along(value, vector, starts).into_iter().flatten());
        }
        if !exact && values.iter().all(|value| value.abs() < BigRational::one()) {
            let [[p, q], [r, s]] = &vectors;
            let form = [p * p + r * r, &two * (p * q + r * s), q * q + s * s];
            tests.extend(self.ellipses(&form, &determinant, starts).into_iter().flatten());
        }
        Some(tests)
    }

    /// The ellipses about the point that stays through what lies furthest out, and furthest in, where it begins.
    fn ellipses(
        &self,
        form: &[BigRational; 3],
        determinant: &BigRational,
        starts: &[[BigRational; 2]],
    ) -> Option<Vec<Test>> {
        let [[a, b], [c, d]] = &self.rows;
        let one = BigRational::one();
        let scale = (&one - a) * (&one - d) - b * c;
        if scale.is_zero() {
            return None;
        }
        let [e, f] = &self.steps;
        let centre = [((&one - d) * e + b * f) / &scale, (c * e + (&one - a) * f) / scale];
        let [x, y] = [0, 1].map(|place| self.variables[place].sub(&Value::rational(centre[place].clone())).ok());
        let (x, y) = (x?, y?);
        let [p, q, r] = form.clone().map(|factor| factor / &form[0]);
        let number = |factor: &BigRational| Value::rational(factor.clone());
        let square = x.mul(&x).ok()?.mul(&number(&p)).ok()?;
        let mixed = x.mul(&y).ok()?.mul(&number(&q)).ok()?;
        let left = square.add(&mixed).ok()?.add(&y.mul(&y).ok()?.mul(&number(&r)).ok()?).ok()?;
        let out = starts.iter().map(|start| {
            let (x, y) = (&start[0] - &centre[0], &start[1] - &centre[1]);
            &p * &x * &x + &q * &x * &y + &r * &y * &y
        });
        let out: Vec<BigRational> = out.collect();
        let bound =
            |relation: Relation, right: &BigRational| Test { relation, left: left.clone(), right: number(right) };
        let mut tests = Vec::new();
        if determinant.abs() <= one {
            tests.extend(out.iter().max().map(|most| bound(Relation::Lte, most)));
        }
        if determinant.abs() >= one {
            tests.extend(out.iter().min().map(|least| bound(Relation::Gte, least)));
        }
        Some(tests)
    }

    /// Between what bounds the product with a left eigenvector stays.
    fn along(&self, value: &BigRational, vector: &[BigRational; 2], starts: &[[BigRational; 2]]) -> Option<Vec<Test>> {
        let along = |point: &[BigRational; 2]| &vector[0] * &point[0] + &vector[1] * &point[1];
        let [x, y] = [0, 1].map(|place| self.variables[place].mul(&Value::rational(vector[place].clone())).ok());
        let starts: Vec<BigRational> = starts.iter().map(along).collect();
        strips(&x?.add(&y?).ok()?, value, &along(&self.steps), &starts)
    }
}

/// Between what bounds a number stays that is multiplied by a factor and gets a step, again and again, from these starts.
fn strips(left: &Value, factor: &BigRational, step: &BigRational, starts: &[BigRational]) -> Option<Vec<Test>> {
    let one = BigRational::one();
    let (least, most) = (starts.iter().min()?.clone(), starts.iter().max()?.clone());
    let bound =
        |relation: Relation, right: BigRational| Test { relation, left: left.clone(), right: Value::rational(right) };
    if factor.is_one() {
        let [above, below] = between(left, &least, &most);
        return Some(match (step.is_zero(), step.is_positive()) {
            (true, _) => vec![above, below],
            (_, true) => vec![above],
            _ => vec![below],
        });
    }
    let middle = step / (&one - factor);
    let (low, high) = (&least - &middle, &most - &middle);
    if factor.is_negative() {
        let wide = low.abs().max(high.abs());
        let both = between(left, &(&middle - &wide), &(&middle + &wide));
        return Some(if -factor <= one { both.to_vec() } else { Vec::new() });
    }
    let mut found = Vec::new();
    // What lies beside the middle never comes there, if it does not jump there at once.
    if low.is_positive() && factor.is_positive() {
        found.push(bound(Relation::Gtr, middle.clone()));
    }
    if high.is_negative() && factor.is_positive() {
        found.push(bound(Relation::Lss, middle.clone()));
    }
    if *factor <= one {
        let zero = BigRational::zero();
        found.extend(between(left, &(&middle + low.min(zero.clone())), &(&middle + high.max(zero))));
    } else {
        found.extend((!low.is_negative()).then(|| bound(Relation::Gte, least)));
        found.extend((!high.is_positive()).then(|| bound(Relation::Lte, most)));
    }
    Some(found)
}
