//! How often a round comes back to its phase: the recurrence of its variables, and the first test that fails.

use super::trajectory::{Unsure, Values, Walker};
use crate::name::Name;
use crate::period::{Edge, Test};
use crate::recurrence::{Closed, Goal, Piece, Reach, first, solve_together};
use crate::value::{Relation, Sort, Value};

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
            return Err(Unsure(vec!["the rounds draw at random".to_string()]));
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
        let closed = solve_together(&maps, values, &self.index, &self.assumptions)?;
        Ok(Forms { constant, maps, closed })
    }

    /// How often a round comes back to its phase from these values, exactly.
    pub(super) fn count(&self, round: &Edge, values: &Values) -> Result<Count, Unsure> {
        let forms = self.forms(round, values)?;
        let mut count = Count {
            stays: None,
            reason: "every round is followed by another".to_string(),
            conditions: conditions_of(&forms.closed),
            closed: forms.closed.clone(),
            learned: None,
        };
        for (test, after) in round.tests.iter().zip(&round.after) {
            self.limit(&mut count, test, after.as_ref(), (&forms, values))?;
        }
        Ok(count)
    }

    /// Lowers the count to the first round after which a test fails.
    fn limit(
        &self,
        count: &mut Count,
        test: &Test,
        after: Option<&Test>,
        (forms, values): (&Forms, &Values),
    ) -> Result<(), Unsure> {
        // A test of the values after a round is a test of the sequence one later.
        let (said, later) = after.map_or((test, false), |after| (after, true));
        let said = said.substitute(&forms.constant)?;
        let reads = |name: &&Name| said.left.mentions(name) || said.right.mentions(name);
        let reach = match forms.maps.keys().filter(reads).collect::<Vec<_>>().as_slice() {
            [] => return self.settled(count, &said),
            [name] => self.first_of_one(&said, name, later, (forms, values))?,
            many => self.first_of_many(&said, many, later, forms)?,
        };
        match reach {
            Reach::Never(reason) => {
                if count.stays.is_none() {
                    count.reason = reason;
                }
                Ok(())
            }
            Reach::Unknown(reason) => Err(Unsure(vec![reason])),
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
                    None => Err(Unsure(vec![format!("which test fails first, {said} or another")])),
                }
            }
        }
    }

    /// When a test of one variable fails first.
    fn first_of_one(
        &self,
        said: &Test,
        name: &Name,
        later: bool,
        (forms, values): (&Forms, &Values),
    ) -> Result<Reach, Unsure> {
        let image =
            |(name, map): (&Name, &Value)| Ok((name.clone(), self.assumptions.simplify(&map.substitute(values)?)));
        let own = |closed: &[(Name, Closed)]| closed.iter().find(|(other, _)| other == name).map(|one| one.1.clone());
        let (start, closed) = if later {
            let starts: Values = forms.maps.iter().map(image).collect::<Result<_, Unsure>>()?;
            let closed = solve_together(&forms.maps, &starts, &self.index, &self.assumptions)?;
            (starts.get(name).cloned(), own(&closed))
        } else {
            (values.get(name).cloned(), own(&forms.closed))
        };
        let (Some(map), Some(start), Some(closed)) = (forms.maps.get(name), start, closed) else {
            return Err(Unsure(vec![format!("when {said} fails first")]));
        };
        let Some(goal) = goal_of(&said.negated(), name) else {
            return Err(Unsure(vec![format!("when {said} fails first")]));
        };
        Ok(match &goal {
            Goal::Equals(wanted) if self.is_never_entered(map, name, &start, wanted) => Reach::Never(format!(
                "{name} = {wanted} is reached for no n, since only {wanted} itself is followed by {wanted}"
            )),
            goal => first(&closed, &self.index, goal, &self.assumptions),
        })
    }

    /// When a test of several variables fails first, each of which has one form for all rounds.
    fn first_of_many(&self, said: &Test, names: &[&Name], later: bool, forms: &Forms) -> Result<Reach, Unsure> {
        let unsure = || Unsure(vec![format!("{said} compares two things that change")]);
        let mut at = Value::variable(&self.index);
        if later {
            at = at.add(&Value::one())?;
        }
        let mut images = Values::new();
        for name in names {
            let closed = forms.closed.iter().find(|(other, _)| other == *name).ok_or_else(unsure)?;
            let [only] = closed.1.pieces.as_slice() else { return Err(unsure()) };
            images.insert((*name).clone(), only.form.with(&self.index, &at)?);
        }
        let failed = said.negated();
        let form = failed.left.sub(&failed.right)?.substitute(&images)?;
        if form.sort() != Sort::Real {
            return Err(unsure());
        }
        let variable = Name::new("[difference]");
        let piece = Piece { from: Value::zero(), until: None, form };
        let closed = Closed { variable: variable.clone(), pieces: vec![piece], conditions: Vec::new() };
        let goal = Goal::Holds(failed.relation, Value::variable(&variable), Value::zero());
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
            None => Err(Unsure(vec![format!("whether {said}")])),
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
