//! How often a round comes back to its phase: the recurrence of its variables, and the first test that fails.

use std::collections::BTreeSet;

use super::trajectory::{Values, Walker};
use super::undecided::Unsure;
use crate::assumption::Assumptions;
use crate::closed_form::{cells, cells_or_none};
use crate::name::Name;
use crate::period::{Edge, Test};
use crate::recurrence::{Closed, Goal, Piece, Reach, first, solve_together};
use crate::value::{Relation, Sort, Value, ValueError};

/// The most tests of a round of which it is asked whether one follows from another.
const MOST_COMPARED: usize = 12;

/// A count of rounds with the closed forms.
pub(super) struct Count {
    /// Rounds that come back to the phase; none when all do.
    pub(super) stays: Option<Value>,
    /// Why, when all do.
    pub(super) reason: String,
    /// The variables that change.
    pub(super) closed: Vec<(Name, Closed)>,
    /// What it rests on.
    pub(super) conditions: Vec<Test>,
    /// What holds at the end because the last test failed.
    pub(super) learned: Option<Test>,
    /// The forms by which what is shown is written, where they are others.
    pub(super) shown: Option<Vec<(Name, Closed)>>,
}

/// The variables of a round that change, with the closed forms of their values.
pub(super) struct Forms {
    /// Variables that keep their values.
    pub(super) constant: Values,
    /// The maps of the others.
    pub(super) maps: Values,
    /// Their closed forms.
    pub(super) closed: Vec<(Name, Closed)>,
}

impl Walker<'_> {
    /// The closed forms of the variables that a round changes, from these values.
    pub(super) fn forms(&self, round: &Edge, values: &Values) -> Result<Forms, Unsure> {
        if !round.draws.is_empty() {
            return Err(Unsure::because("the rounds draw at random".to_string()));
        }
        let mut constant = Values::new();
        let mut changing = Vec::new();
        for (name, image) in &round.map {
            match values.get(name) {
                Some(value) if *image == Value::variable(name) => {
                    constant.insert(name.clone(), value.clone());
                }
                _ => changing.push(name.clone()),
            }
        }
        let mut maps = Values::new();
        for name in &changing {
            if let (Some(image), true) = (round.map.get(name), values.contains_key(name)) {
                maps.insert(name.clone(), self.assumptions.simplify(&image.substitute(&constant)?));
            }
        }
        let closed = solve_together(&maps, values, &self.index, &self.assumptions, self.interrupted)?;
        Ok(Forms { constant, maps, closed })
    }

    /// How often a round comes back to its phase from these values, exactly.
    pub(super) fn count(&self, round: &Edge, values: &Values) -> Result<Count, Unsure> {
        let forms = self.forms(round, values)?;
        let mut count = Count {
            stays: None,
            reason: "every round is followed by another".to_string(),
            conditions: self.still_open(conditions_of(&forms.closed)),
            closed: forms.closed.clone(),
            learned: None,
            shown: None,
        };
        let tells = self.telling(round);
        for (place, (test, after)) in round.tests.iter().zip(&round.after).enumerate() {
            if tells.contains(&place) {
                self.limit(&mut count, test, after.as_ref(), &forms)?;
            }
        }
        Ok(count)
    }

    /// The tests of a round that may be the first to fail: not those that hold wherever another of these does.
    fn telling(&self, round: &Edge) -> BTreeSet<usize> {
        let tests = &round.tests;
        let mut tells: BTreeSet<usize> = (0..tests.len()).collect();
        if tests.len() > MOST_COMPARED {
            return tells;
        }
        let names =
            |test: &Test| test.left.variables().into_iter().chain(test.right.variables()).collect::<BTreeSet<_>>();
        let follows = |test: &Test, from: &Test| {
            // What may have no value does not hold there.
            names(test) == names(from) && [&test.left, &test.right].iter().all(|side| side.needs().is_empty()) && {
                let mut known = self.assumptions.clone();
                known.assume(from.relation, &from.left, &from.right);
                test.decide(&known) == Some(true)
            }
        };
        for (place, test) in tests.iter().enumerate() {
            // Only by what is still looked at: of tests that say the same one is left.
            let implied = tests
                .iter()
                .enumerate()
                .any(|(other, from)| other != place && tells.contains(&other) && follows(test, from));
            if implied {
                tells.remove(&place);
            }
        }
        tells
    }

    /// The conditions of which it is not known that they hold.
    fn still_open(&self, mut conditions: Vec<Test>) -> Vec<Test> {
        conditions.retain(|test| test.decide(&self.assumptions) != Some(true));
        conditions
    }

    /// Lowers the count to the first round after which a test fails.
    fn limit(&self, count: &mut Count, test: &Test, after: Option<&Test>, forms: &Forms) -> Result<(), Unsure> {
        // A test of the values after a round is a test of the sequence one later.
        let (said, later) = after.map_or((test, false), |after| (after, true));
        let said = of_one_component(said.substitute(&forms.constant)?, &self.assumptions)?;
        let reads = |name: &&Name| said.left.mentions(name) || said.right.mentions(name);
        let reach = match forms.maps.keys().filter(reads).collect::<Vec<_>>().as_slice() {
            [] => return self.settled(count, &said),
            [name] if said.left.sort() == Sort::Real => self.first_of_one(&said, name, later, forms)?,
            many => self.first_of_many(&said, many, later, forms)?,
        };
        match reach {
            Reach::Never(reason) => {
                if count.stays.is_none() {
                    count.reason = reason;
                }
                Ok(())
            }
            Reach::Unknown(unknown) => Err(unknown.into()),
            Reach::At(number, conditions) => {
                let sooner = match &count.stays {
                    None => Some(true),
                    Some(other) => self.assumptions.decide(Relation::Lss, &number, other),
                };
                match sooner {
                    Some(true) => {
                        count.stays = Some(number);
                        count.learned = later.then(|| said.negated());
                        count.conditions.extend(tests_of(&conditions));
                        Ok(())
                    }
                    Some(false) => Ok(()),
                    None => Err(Unsure::because(format!("which test fails first, {said} or another"))),
                }
            }
        }
    }

    /// When a test of one variable fails first.
    fn first_of_one(&self, said: &Test, name: &Name, later: bool, forms: &Forms) -> Result<Reach, Unsure> {
        let unsure = || Unsure::because(format!("when {said} fails first"));
        let map = forms.maps.get(name).ok_or_else(unsure)?;
        let own = forms.closed.iter().find(|(other, _)| other == name).map(|(_, closed)| closed);
        let mut closed = own.ok_or_else(unsure)?.clone();
        if later {
            closed = self.one_later(&closed)?;
        }
        let goal = goal_of(&said.negated(), name).ok_or_else(unsure)?;
        let start = closed.at(&self.index, &Value::zero(), &self.assumptions);
        Ok(match &goal {
            Goal::Equals(wanted) if start.is_some_and(|start| self.is_never_entered(map, name, &start, wanted)) => {
                Reach::Never(format!(
                    "{name} = {wanted} is reached for no n, since only {wanted} itself is followed by {wanted}"
                ))
            }
            goal => first(&closed, &self.index, goal, &self.assumptions),
        })
    }

    /// The sequence from its second value on.
    fn one_later(&self, closed: &Closed) -> Result<Closed, Unsure> {
        let (one, zero) = (Value::one(), Value::zero());
        let next = Value::variable(&self.index).add(&one)?;
        let mut later = Closed { pieces: Vec::new(), ..closed.clone() };
        for piece in &closed.pieces {
            let until = piece.until.as_ref().map(|until| until.sub(&one)).transpose()?;
            if until.as_ref().is_some_and(|until| self.assumptions.decide(Relation::Lte, until, &zero) == Some(true)) {
                continue;
            }
            let from = if later.pieces.is_empty() { zero.clone() } else { piece.from.sub(&one)? };
            later.pieces.push(Piece { from, until, form: piece.form.with(&self.index, &next)? });
        }
        Ok(later)
    }

    /// When a test of several variables fails first.
    fn first_of_many(&self, said: &Test, names: &[&Name], later: bool, forms: &Forms) -> Result<Reach, Unsure> {
        let unsure = || Unsure::because(format!("{said} compares two things that change"));
        let mut all = Vec::new();
        for name in names {
            let (_, closed) = forms.closed.iter().find(|(other, _)| other == *name).ok_or_else(unsure)?;
            all.push(if later { self.one_later(closed)? } else { closed.clone() });
        }
        let all: Vec<Vec<Piece>> = all.into_iter().map(|closed| closed.pieces).collect();
        let told = |measure: Measure| self.first_of_differences(&said.negated(), names, &all, measure);
        let vector = matches!(said.left.sort(), Sort::Vector(_)) && said.relation == Relation::Neq;
        let tells = |found: &Result<Reach, Unsure>| matches!(found, Ok(Reach::At(..) | Reach::Never(_)));
        let by_components = told(&one_difference);
        let mut found = by_components;
        if vector && !tells(&found) {
            let by_parts = || self.last_of_parts(said, names, &all).map(Ok);
            found = Some(told(&distance)).filter(tells).or_else(by_parts).unwrap_or(found);
        }
        let found = found?;
        Ok(match found {
            Reach::Never(reason) => Reach::Never(format!("of {}-({}), {reason}", said.left, said.right)),
            found => found,
        })
    }

    /// The first index at which two vectors are equal of which each component, once it is equal, stays so: the last of
    /// the first ones of the components, each of which reads one variable.
    fn last_of_parts(&self, said: &Test, names: &[&Name], all: &[Vec<Piece>]) -> Option<Reach> {
        let known = &self.assumptions;
        let (mut indices, mut needed) = (Vec::new(), Vec::new());
        for part in said.left.sub(&said.right).ok()?.components()? {
            let mut read = names.iter().zip(all).filter(|(name, _)| part.mentions(name));
            let (Some((name, own)), None) = (read.next(), read.next()) else { return None };
            let difference = |piece: &Piece| {
                let form = known.simplify(&part.with(name, &piece.form).ok()?);
                Some(Piece { form, ..piece.clone() })
            };
            let pieces = own.iter().map(difference).collect::<Option<Vec<_>>>()?;
            let last = pieces.last().filter(|last| last.until.is_none() && last.form.is_zero())?.from.clone();
            let closed = Closed { variable: (*name).clone(), pieces, conditions: Vec::new() };
            let Reach::At(at, conditions) = first(&closed, &self.index, &Goal::Equals(Value::zero()), known) else {
                return None;
            };
            if known.decide(Relation::Gte, &at, &last) != Some(true) {
                return None;
            }
            indices.push(at);
            needed.extend(conditions);
        }
        Some(Reach::At(known.simplify(&Value::maximum(&indices).ok()?), needed))
    }

    /// The first index at which a test holds of what several variables are, by one number that tells in each piece of them.
    fn first_of_differences(
        &self,
        test: &Test,
        names: &[&Name],
        all: &[Vec<Piece>],
        measure: Measure,
    ) -> Result<Reach, Unsure> {
        let unsure = || Unsure::because(format!("{} compares two things that change", test.negated()));
        let mut pieces = Vec::new();
        // Where two pieces may end together, one between their ends may be of no index.
        let ordered = cells(all, Value::zero(), &self.assumptions);
        let ordered = ordered.or_else(|reason| {
            cells_or_none(all, Value::zero(), &self.assumptions).map_err(|_| Unsure::because(reason))
        })?;
        for cell in ordered {
            let images: Values =
                names.iter().zip(&cell.forms).map(|(name, form)| ((*name).clone(), (*form).clone())).collect();
            let piece = Piece { from: cell.from.clone(), until: cell.until.clone(), form: Value::zero() };
            let difference = test.left.sub(&test.right)?.substitute(&images)?;
            let mut known = self.assumptions.clone();
            let index = Value::variable(&self.index);
            known.assume_natural(&self.index);
            known.assume(Relation::Gte, &index, &piece.from);
            if let Some(until) = &piece.until {
                known.assume(Relation::Lss, &index, until);
            }
            let form = measure(&difference, &self.index, &known).ok_or_else(unsure)?;
            pieces.push(Piece { form: known.simplify(&form), ..piece.clone() });
        }
        let variable = Name::new("[difference]");
        let goal = match test.relation {
            Relation::Eq => Goal::Equals(Value::zero()),
            relation => Goal::Holds(relation, Value::variable(&variable), Value::zero()),
        };
        let closed = Closed { variable, pieces, conditions: Vec::new() };
        Ok(first(&closed, &self.index, &goal, &self.assumptions))
    }

    /// A test that does not change from round to round.
    fn settled(&self, count: &mut Count, said: &Test) -> Result<(), Unsure> {
        match said.decide(&self.assumptions) {
            Some(true) => Ok(()),
            Some(false) => {
                count.stays = Some(Value::zero());
                count.learned = None;
                Ok(())
            }
            None => Err(Unsure::whether(said.relation, &said.left, &said.right)),
        }
    }

    /// Whether a value stays where it is, and nothing else ever gets there: the map is affine and one to one.
    fn is_never_entered(&self, map: &Value, name: &Name, start: &Value, wanted: &Value) -> bool {
        let Some((factor, _)) = map.linear_in(name) else { return false };
        let stays = map.with(name, wanted).ok();
        let differ = |one: &Value, other: &Value| self.assumptions.decide(Relation::Eq, one, other) == Some(false);
        stays.is_some_and(|stays| self.assumptions.decide(Relation::Eq, &stays, wanted) == Some(true))
            && differ(&factor, &Value::zero())
            && differ(start, wanted)
    }
}

/// A test of vectors that differ in one component at most, by that component.
pub(super) fn of_one_component(said: Test, known: &Assumptions) -> Result<Test, ValueError> {
    let Some(parts) = said.left.sub(&said.right)?.components() else { return Ok(said) };
    let equal = |part: &&Value| known.decide(Relation::Eq, part, &Value::zero()) == Some(true);
    let mut rest: Vec<&Value> = parts.iter().filter(|part| !equal(part)).collect();
    Ok(match (rest.pop(), rest.as_slice()) {
        (Some(only), []) => Test { relation: said.relation, left: only.clone(), right: Value::zero() },
        _ => said,
    })
}

/// One number that is 0 just where the difference of two values is.
pub(super) type Measure<'a> = &'a dyn Fn(&Value, &Name, &Assumptions) -> Option<Value>;

/// How long the difference of two places is.
pub(super) fn distance(difference: &Value, _: &Name, known: &Assumptions) -> Option<Value> {
    difference.norm().ok().map(|length| known.simplify(&length))
}

/// A number that is 0 where a difference is; of a vector, a component that all others are multiples of.
pub(super) fn one_difference(difference: &Value, index: &Name, known: &Assumptions) -> Option<Value> {
    let Sort::Vector(length) = difference.sort() else { return Some(difference.clone()) };
    let parts: Vec<Value> = (0..length).filter_map(|place| difference.component(place)).collect();
    let zero = |part: &Value| known.decide(Relation::Eq, part, &Value::zero());
    if let Some(apart) = parts.iter().find(|part| !part.mentions(index) && zero(part) == Some(false)) {
        return Some(apart.clone());
    }
    let rest: Vec<&Value> = parts.iter().filter(|part| zero(part) != Some(true)).collect();
    let Some(main) = rest.first() else { return Some(Value::zero()) };
    // Two that grow by fixed numbers are both 0 at one index at most, and only if they are multiples.
    let apart = |part: &&Value| {
        let (Some((a, b)), Some((c, d))) = (main.linear_in(index), part.linear_in(index)) else { return false };
        let cross = a.mul(&d).and_then(|product| product.sub(&b.mul(&c)?));
        cross.is_ok_and(|cross| known.decide(Relation::Neq, &cross, &Value::zero()) == Some(true))
    };
    if rest.iter().any(apart) {
        return Some(Value::one());
    }
    let multiple = |part: &&&Value| part.div(main).is_ok_and(|ratio| !known.simplify(&ratio).mentions(index));
    (rest.iter().filter(multiple).count() == rest.len()).then(|| (*main).clone())
}

fn tests_of(conditions: &[(Relation, Value, Value)]) -> Vec<Test> {
    let test = |(relation, left, right): &(Relation, Value, Value)| Test {
        relation: *relation,
        left: left.clone(),
        right: right.clone(),
    };
    conditions.iter().map(test).collect()
}

fn conditions_of(closed: &[(Name, Closed)]) -> Vec<Test> {
    closed.iter().flat_map(|(_, closed)| tests_of(&closed.conditions)).collect()
}

/// A test of one variable as a question to its sequence.
pub(super) fn goal_of(test: &Test, name: &Name) -> Option<Goal> {
    let (relation, left, right) = if test.left.mentions(name) {
        (test.relation, &test.left, &test.right)
    } else {
        (test.relation.mirrored(), &test.right, &test.left)
    };
    if right.mentions(name) {
        return None;
    }
    let variable = Value::variable(name);
    if *left == variable {
        return Some(match relation {
            Relation::Eq => Goal::Equals(right.clone()),
            _ => Goal::Holds(relation, left.clone(), right.clone()),
        });
    }
    // abs(x - c) <= e, however the distance is written.
    if relation == Relation::Lte {
        for centre in centres(left, name) {
            if variable.sub(&centre).and_then(|gap| gap.abs()).as_ref() == Ok(left) {
                return Some(Goal::Within(centre, right.clone()));
            }
        }
    }
    if relation == Relation::Eq
        && let Some((factor, rest)) = left.linear_in(name)
        && factor.as_rational().is_some()
    {
        return right.sub(&rest).and_then(|gap| gap.div(&factor)).ok().map(Goal::Equals);
    }
    Some(Goal::Holds(relation, left.clone(), right.clone()))
}

/// Where `abs(x - c)` vanishes: the square of the distance tells, since it is `(x - c)^2`.
fn centres(distance: &Value, name: &Name) -> Vec<Value> {
    let zero = distance.with(name, &Value::zero()).ok();
    let mut found = Vec::new();
    if let Some(size) = zero {
        found.extend(size.neg().ok());
        found.push(size.clone());
        for atom in size.variables() {
            let variable = Value::variable(&atom);
            found.extend(variable.neg().ok());
            found.push(variable);
        }
    }
    found
}
