//! A phase of which it is not known when it ends, or whether: what would follow if it does. Its rounds are counted by a
//! symbol, the first number of rounds after which its test fails, and the values that have no closed form are written as
//! sequences of their own. Nothing is proved so: it says what remains to be shown, and what it would give.

use super::count::Count;
use super::property::{Wanted, judge};
use super::round::is_known;
use super::trajectory::{Trajectory, Values, Walker, walk_from};
use super::{Outcome, Verdict};
use crate::assumption::Assumptions;
use crate::definition::Definitions;
use crate::name::Name;
use crate::period::{Edge, Period, Test};
use crate::recurrence::{Closed, Piece, solve_apart};
use crate::term::Term;
use crate::value::{Atom, Relation, Sort, Value};

/// Phases that are supposed to end, before the run must have repeated.
const MOST: usize = 12;

/// A number of rounds that is supposed to exist.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Supposed {
    /// What it is called.
    pub count: Name,
    /// What holds after so many rounds for the first time, of the sequences at this index.
    pub when: Test,
    /// The index of the sequences.
    pub index: Name,
    /// The sequences that have no closed form: what each is called, its first value and the next, of those at the index.
    pub sequences: Vec<(Name, Value, Value)>,
    /// What is not equal after any round but the last, one after that at the index.
    apart: Vec<(Value, Value)>,
}

/// What would follow if every phase of the run ended.
#[derive(Clone, Debug)]
pub struct Supposing {
    /// The numbers of rounds that are supposed to exist.
    pub supposed: Vec<Supposed>,
    /// What is assumed with them.
    pub known: Assumptions,
    /// What was found with them.
    pub outcome: Outcome,
}

impl Supposed {
    /// What is supposed, in words.
    pub fn line(&self) -> String {
        let Supposed { count, when, index, sequences, .. } = self;
        let said =
            |(name, start, next): &(Name, Value, Value)| format!("{name}(0) = {start}, {name}({index}+1) = {next}");
        let sequences: Vec<String> = sequences.iter().map(said).collect();
        let of = if sequences.is_empty() { String::new() } else { format!(", where {}", sequences.join(", ")) };
        format!("{count} is the least {index} >= 1 with {when}{of}")
    }
}

/// The run if every phase ended that is not known to; nothing if none is such, or if even then it is not known.
pub(crate) fn walk_supposing(
    period: &Period,
    known: (&Definitions, &Assumptions),
    property: &Term,
    interrupted: &dyn Fn() -> bool,
) -> Option<Trajectory> {
    let run = walk_from(period, known, property, Some(Vec::new()), interrupted);
    (run.open.is_empty() && !run.supposed.is_empty()).then_some(run)
}

/// What the property would give if every phase of the run ended that is not known to; nothing if none is such, or if even
/// then it is not known.
pub(super) fn supposing(
    period: &Period,
    (definitions, assumptions): (&Definitions, &Assumptions),
    (wanted, property): (&Wanted, &Term),
    interrupted: &dyn Fn() -> bool,
) -> Option<Supposing> {
    let run = walk_supposing(period, (definitions, assumptions), property, interrupted)?;
    // That numbers of rounds exist is all that the match needs: what is assumed of single rounds is not true of every index.
    let (supposed, mut known) = (run.supposed.clone(), assumptions.clone());
    for one in &supposed {
        known.assume_natural(&one.count);
        known.assume(Relation::Gte, &Value::variable(&one.count), &Value::one());
    }
    // Where it is asked in which round something is shown, and nowhere else: it is not so of the last round.
    let mut run = run;
    for (left, right) in supposed.iter().flat_map(|one| &one.apart) {
        run.assumptions.assume(Relation::Neq, left, right);
    }
    let outcome = judge(wanted, run);
    matches!(outcome.verdict, Verdict::Proved).then_some(Supposing { supposed, known, outcome })
}

impl Walker<'_> {
    /// The rounds of a phase counted by a symbol, if it ends by one test alone and such counts are asked for.
    pub(super) fn suppose(&mut self, round: &Edge, values: &Values) -> Option<Count> {
        let number = self.supposed.as_ref().map(Vec::len).filter(|number| *number < MOST)? + 1;
        if !round.draws.is_empty() || (self.interrupted)() {
            return None;
        }
        let constant: Values = values.iter().filter(|(name, _)| kept(round, name)).map(owned).collect();
        let maps: Option<Values> = values
            .keys()
            .filter(|name| !kept(round, name))
            .map(|name| {
                Some((name.clone(), self.assumptions.simplify(&round.map.get(name)?.substitute(&constant).ok()?)))
            })
            .collect();
        let maps = maps?;
        let said = self.only_test(round, &constant, &maps)?;
        let found = solve_apart(&maps, values, &self.index, &self.assumptions, self.interrupted);
        if found.closed.iter().any(|(_, closed)| !closed.conditions.is_empty() || closed.pieces.len() != 1) {
            return None;
        }
        let index = Value::variable(&self.index);
        let mut images: Values =
            found.closed.iter().map(|(name, closed)| (name.clone(), closed.pieces[0].form.clone())).collect();
        let mut called = Vec::new();
        for name in found.missing.iter().flat_map(|(names, _)| names) {
            let start = values.get(name).filter(|start| start.sort() == Sort::Real)?;
            let own = self.own_name(name, number);
            images.insert(name.clone(), Value::apply(&own, std::slice::from_ref(&index)).ok()?);
            called.push((name.clone(), own, start.clone()));
        }
        let next = |(name, own, start): &(Name, Name, Value)| {
            Some((own.clone(), start.clone(), self.assumptions.simplify(&maps.get(name)?.substitute(&images).ok()?)))
        };
        // What has a form, or is made of numbers alone, is followed as far as it can be.
        let names: Vec<&Name> = maps.keys().collect();
        let of_numbers = |map: &Value| map.variables().iter().all(|name| names.contains(&name)) && !applies(map);
        if called.is_empty() || values.values().all(is_known) && maps.values().all(of_numbers) {
            return None;
        }
        let sequences = called.iter().map(next).collect::<Option<Vec<_>>>()?;
        let when = said.negated().substitute(&images).ok()?;
        let count = self.own_name(&Name::new("n"), number);
        let whole = |form: &Value| Piece { from: Value::zero(), until: None, form: form.clone() };
        let closed = |(name, image): (&Name, &Value)| {
            (name.clone(), Closed { variable: name.clone(), pieces: vec![whole(image)], conditions: Vec::new() })
        };
        let closed: Vec<(Name, Closed)> = images.iter().map(closed).collect();
        // The first values are known; they are looked at apart.
        let shown = closed.iter().map(|(name, form)| {
            let start = called.iter().find(|(other, ..)| other == name).map(|(_, _, start)| start.clone());
            (name.clone(), start.map_or_else(|| form.clone(), |start| after_the_first(form, start)))
        });
        let shown = Some(shown.collect());
        let apart = said.substitute(values).is_ok_and(|first| first.decide(&self.assumptions) == Some(true));
        let apart = self.assume_counted((&count, &when), &called, &maps, apart)?;
        let stays = Value::variable(&count).sub(&Value::one()).ok()?;
        let supposed = Supposed { count, when, index: self.index.clone(), sequences, apart };
        self.supposed.as_mut()?.push(supposed);
        let reason = "it is supposed to end".to_string();
        let (conditions, learned) = (Vec::new(), Some(said.negated()));
        Some(Count { stays: Some(stays), reason, closed, conditions, learned, shown })
    }

    /// The one test of the values after a round that is not known to hold always.
    fn only_test(&self, round: &Edge, constant: &Values, maps: &Values) -> Option<Test> {
        let mut open = None;
        for (test, after) in round.tests.iter().zip(&round.after) {
            let said = after.as_ref().unwrap_or(test).substitute(constant).ok()?;
            let changes = maps.keys().any(|name| said.left.mentions(name) || said.right.mentions(name));
            match (changes, after) {
                (false, _) if said.decide(&self.assumptions) == Some(true) => {}
                (true, Some(_)) if open.is_none() && said.left.sort() == Sort::Real => open = Some(said),
                _ => return None,
            }
        }
        open
    }

    /// Assumes that there is at least one round. What is not equal after any round but the last: what the test tells apart,
    /// and, of a value which alone tells what follows, that and its first, for then the rounds would go on for ever. `apart`:
    /// the first keeps to the test, so that the last is another.
    fn assume_counted(
        &mut self,
        (count, when): (&Name, &Test),
        called: &[(Name, Name, Value)],
        maps: &Values,
        apart: bool,
    ) -> Option<Vec<(Value, Value)>> {
        self.assumptions.assume_natural(count);
        self.assumptions.assume(Relation::Gte, &Value::variable(count), &Value::one());
        let later = Value::variable(&self.index).add(&Value::one()).ok()?;
        let at = |value: &Value| value.with(&self.index, &later).ok();
        let kept = when.negated();
        let mut all = Vec::new();
        if matches!(kept.relation, Relation::Neq | Relation::Lss | Relation::Gtr) {
            all.push((at(&kept.left)?, at(&kept.right)?));
        }
        if let ([(_, own, start)], 1, true) = (called, maps.len(), apart) {
            all.push((Value::apply(own, std::slice::from_ref(&later)).ok()?, start.clone()));
            // Nor is it the first after one round, where the last is another than the first.
            let one = Value::apply(own, &[Value::one()]).ok()?;
            self.assumptions.assume(Relation::Neq, &one, start);
        }
        // Of what has a form more would follow: that is asked by itself.
        let own = |value: &Value| called.iter().any(|(_, own, _)| mentions(value, own));
        all.retain(|(left, right)| own(left) || own(right));
        Some(all)
    }

    fn own_name(&mut self, base: &Name, number: usize) -> Name {
        let mut names = (number..).map(|number| Name::new(&format!("{base}{number}")));
        let name = names.find(|name| !self.taken.contains(name)).unwrap_or_else(|| base.clone());
        self.taken.insert(name.clone());
        name
    }
}

/// Whether a function of which nothing is known stands in a value.
fn applies(value: &Value) -> bool {
    value.atoms().iter().any(|atom| matches!(atom, Atom::Apply(..)) || atom.parts().into_iter().any(applies))
}

/// Whether one of the sequences stands in a value.
fn mentions(value: &Value, sequence: &Name) -> bool {
    value.atoms().iter().any(|atom| {
        matches!(atom, Atom::Apply(name, _) if name == sequence)
            || atom.parts().into_iter().any(|part| mentions(part, sequence))
    })
}

fn kept(round: &Edge, name: &Name) -> bool {
    round.map.get(name).is_some_and(|image| *image == Value::variable(name))
}

/// A form from the second value on, before which there is a value that is known.
fn after_the_first(closed: &Closed, start: Value) -> Closed {
    let first = Piece { from: Value::zero(), until: Some(Value::one()), form: start };
    let later = closed.pieces.iter().map(|piece| Piece { from: Value::one(), ..piece.clone() });
    Closed { pieces: std::iter::once(first).chain(later).collect(), ..closed.clone() }
}

fn owned((name, value): (&Name, &Value)) -> (Name, Value) {
    (name.clone(), value.clone())
}
