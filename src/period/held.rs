//! What the places of a phase hold: a value, or a variable where it differs from visit to visit.

use std::collections::{BTreeMap, BTreeSet};
use std::convert::Infallible;

use super::run::Run;
use super::step::{Slot, map_values};
use crate::name::Name;
use crate::value::Value;

/// What a place of a phase holds.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(super) enum Held {
    Constant(Value),
    Class(usize),
}

/// The variables of a phase, each with what it is told from the others by. Of one vector no two components are one variable,
/// though they may be equal for a while: how far a robot has come is no simpler on a diagonal than elsewhere.
struct Classes<K>(BTreeMap<K, Vec<(Option<usize>, usize)>>, usize);

impl<K: Ord> Classes<K> {
    fn new() -> Self {
        Classes(BTreeMap::new(), 0)
    }

    /// The variable of such a place, which is the component of a vector that has this number, if it is one.
    fn of(&mut self, key: K, axis: Option<usize>) -> usize {
        let same = self.0.entry(key).or_default();
        let fits = |(own, _): &&(Option<usize>, usize)| axis.is_none() || own.is_none() || *own == axis;
        if let Some((_, class)) = same.iter().find(fits) {
            return *class;
        }
        let next = self.1;
        self.1 += 1;
        same.push((axis, next));
        next
    }
}

/// What the places of a phase hold at the first visit, of which some are components of vectors.
pub(super) fn first_held(entries: &[Value], axes: &[Option<usize>], varies: impl Fn(&Value) -> bool) -> Vec<Held> {
    let mut classes: Classes<&Value> = Classes::new();
    let each = |(place, entry)| match varies(entry) {
        true => Held::Class(classes.of(entry, axes.get(place).copied().flatten())),
        false => Held::Constant(entry.clone()),
    };
    entries.iter().enumerate().map(each).collect()
}

/// Where the values of a phase stand: what each is called, and the how manyth it is of how many in its component.
pub(super) fn places(runs: &[Run], delays: &[Option<Value>], hints: &[Name]) -> Vec<(Name, usize, usize)> {
    let mut found: Vec<(Name, usize, usize)> = Vec::with_capacity(hints.len());
    let mut delays = delays.iter();
    for run in runs {
        let mut own = 0;
        let mut count = |slot: Slot<'_>, value: &Value| -> Result<Value, Infallible> {
            // A delay that is fixed is no value of the phase.
            if !(matches!(slot, Slot::Delay) && matches!(delays.next(), Some(Some(_)))) {
                own += value.components().map_or(1, |parts| parts.len());
            }
            Ok(value.clone())
        };
        let Ok(_) = map_values(run, &mut count);
        let hints = hints.iter().skip(found.len()).take(own).enumerate();
        let new: Vec<_> = hints.map(|(place, hint)| (hint.clone(), place, own)).collect();
        found.extend(new);
    }
    found
}

/// What the places hold when these entries have come as well, of which some vary. Where it is told which places are
/// `alike`, a place that holds a variable now makes variables of those.
pub(super) fn absorbed(
    before: &[Held],
    (entries, axes): (&[Value], &[Option<usize>]),
    varying: &[bool],
    alike: Option<&[(Name, usize, usize)]>,
) -> Vec<Held> {
    let stays = |place: usize| {
        let (Some(held), Some(entry), Some(varies)) = (before.get(place), entries.get(place), varying.get(place))
        else {
            return true;
        };
        matches!(held, Held::Constant(value) if value == entry && !varies)
    };
    let open: BTreeSet<_> =
        alike.into_iter().flatten().enumerate().filter(|(place, _)| !stays(*place)).map(|(_, key)| key).collect();
    let follows = |place: usize| alike.and_then(|alike| alike.get(place)).is_some_and(|key| open.contains(key));
    let mut classes: Classes<(Held, Value, Option<usize>)> = Classes::new();
    let mut held = Vec::with_capacity(before.len());
    for (place, (old, entry)) in before.iter().zip(entries).enumerate() {
        if stays(place) && !follows(place) {
            held.push(old.clone());
            continue;
        }
        // What only follows is a variable of its own.
        let own = stays(place).then_some(place);
        let axis = axes.get(place).copied().flatten();
        held.push(Held::Class(classes.of((old.clone(), entry.clone(), own), axis)));
    }
    held
}

/// Explorations of one phase, after which places that hold the same by chance are taken apart at once: where each follows
/// another in a ring, one after the other would differ.
const FEW_EXPLORATIONS: usize = 8;

/// Which places of a phase hold the same.
pub(super) enum Together {
    /// Those that have held the same so far.
    SoFar,
    /// Each holds a variable of its own; before that, these held the same.
    Apart(Vec<Held>),
    /// Those that come to hold the same whatever each of them held before.
    Surely,
}

impl Together {
    /// What places hold, of which it was found what they hold by what came so far, when these entries have come, of which
    /// some vary.
    pub(super) fn of(
        &mut self,
        (before, found): (&[Held], Vec<Held>),
        explorations: usize,
        (entries, varying): (&[Value], &[bool]),
    ) -> Vec<Held> {
        match self {
            Together::SoFar if explorations > FEW_EXPLORATIONS && found != before => {
                let held = taken_apart(&found);
                *self = Together::Apart(found);
                held
            }
            Together::Apart(earlier) => {
                let held = put_together(earlier, before, entries, varying);
                *self = Together::Surely;
                held
            }
            Together::SoFar | Together::Surely => found,
        }
    }
}

/// Each place that holds a variable with one of its own.
fn taken_apart(held: &[Held]) -> Vec<Held> {
    let mut own = 0..;
    let each = |held: &Held| match held {
        Held::Constant(_) => held.clone(),
        Held::Class(class) => Held::Class(own.next().unwrap_or(*class)),
    };
    held.iter().map(each).collect()
}

/// Places that were taken apart, together again where they were so `earlier` and these entries, which tell them apart, are
/// the same: what they come to hold then is the same whatever they held.
fn put_together(earlier: &[Held], apart: &[Held], entries: &[Value], varying: &[bool]) -> Vec<Held> {
    let mut classes: BTreeMap<(&Held, &Value), usize> = BTreeMap::new();
    let mut held = Vec::with_capacity(apart.len());
    for ((earlier, apart), (entry, varies)) in earlier.iter().zip(apart).zip(entries.iter().zip(varying)) {
        held.push(match apart {
            Held::Constant(value) if value == entry && !varies => apart.clone(),
            _ => {
                let next = classes.len();
                Held::Class(*classes.entry((earlier, entry)).or_insert(next))
            }
        });
    }
    held
}

/// Variables are called after the first place they stand in, with a number where that is taken.
pub(super) fn name_variables(held: &[Held], hints: &[Name], reserved: &BTreeSet<Name>) -> Vec<Name> {
    let mut names: Vec<Name> = Vec::new();
    let mut taken: BTreeSet<Name> = BTreeSet::new();
    let mut numbers: BTreeMap<&Name, usize> = BTreeMap::new();
    for (held, hint) in held.iter().zip(hints) {
        if *held != Held::Class(names.len()) {
            continue;
        }
        let number = numbers.entry(hint).or_insert(0);
        let mut name = hint.clone();
        loop {
            *number += 1;
            if *number > 1 {
                name = Name::new(&format!("{hint}{number}"));
            }
            if !reserved.contains(&name) && taken.insert(name.clone()) {
                break;
            }
        }
        names.push(name);
    }
    names
}
