//! Where numbers must lie: unions of ranges, and products of these. Ends have no chance, so they belong to both sides.

use num_rational::BigRational;

use crate::rational::quotient;
use crate::value::Relation;

/// A range of reals; none stands for no bound.
pub type Range = (Option<BigRational>, Option<BigRational>);

/// Ranges in their order, of which no two touch.
pub type Set = Vec<Range>;

/// All numbers.
pub fn whole() -> Set {
    vec![(None, None)]
}

/// Where `ratio * x + constant REL 0`, for a ratio that is not 0 and an order.
pub fn half(relation: Relation, ratio: &BigRational, constant: &BigRational) -> Set {
    let bound = Some(-quotient(constant, ratio));
    let negative = num_traits::Signed::is_negative(ratio);
    if matches!(relation, Relation::Gtr | Relation::Gte) == negative {
        vec![(None, bound)]
    } else {
        vec![(bound, None)]
    }
}

/// What lies in both.
pub fn meet(one: &Set, other: &Set) -> Set {
    let mut both = Set::new();
    for (low, high) in one {
        for (low2, high2) in other {
            let low = match (low, low2) {
                (Some(a), Some(b)) => Some(a.max(b)),
                (a, b) => a.as_ref().or(b.as_ref()),
            };
            let high = match (high, high2) {
                (Some(a), Some(b)) => Some(a.min(b)),
                (a, b) => a.as_ref().or(b.as_ref()),
            };
            if low.zip(high).is_none_or(|(low, high)| low < high) {
                both.push((low.cloned(), high.cloned()));
            }
        }
    }
    ordered(both)
}

/// What lies in the first and not in the other.
pub fn without(one: &Set, other: &Set) -> Set {
    let mut outside = Set::new();
    let mut from: Option<Option<BigRational>> = Some(None);
    for (low, high) in other {
        if let (Some(start), Some(low)) = (from, low) {
            outside.push((start, Some(low.clone())));
        }
        from = high.clone().map(Some);
    }
    if let Some(start) = from {
        outside.push((start, None));
    }
    meet(one, &outside)
}

/// What lies in one of them.
pub fn join(one: &Set, other: &Set) -> Set {
    let mut all = Set::new();
    for (low, high) in ordered([one.as_slice(), other.as_slice()].concat()) {
        match all.last_mut() {
            Some((_, end)) if end.as_ref().zip(low.as_ref()).is_none_or(|(end, low)| low <= end) => {
                if end.as_ref().zip(high.as_ref()).is_none_or(|(end, high)| high > end) {
                    *end = if end.is_none() { None } else { high };
                }
            }
            _ => all.push((low, high)),
        }
    }
    all
}

fn ordered(mut set: Set) -> Set {
    set.sort_by(|one, other| one.0.cmp(&other.0));
    set
}

/// A product of sets, one for each coordinate.
pub type Patch = Vec<Set>;

/// What lies in both; none where that is nothing.
pub fn common(one: &Patch, other: &Patch) -> Option<Patch> {
    let both: Patch = one.iter().zip(other).map(|(one, other)| meet(one, other)).collect();
    both.iter().all(|set| !set.is_empty()).then_some(both)
}

/// What lies in these and not in the other, as products that do not overlap.
pub fn outside(patches: Vec<Patch>, other: &Patch) -> Vec<Patch> {
    let mut left = Vec::new();
    for patch in patches {
        let mut now = patch;
        for place in 0..now.len() {
            let apart = without(&now[place], &other[place]);
            if !apart.is_empty() {
                let mut piece = now.clone();
                piece[place] = apart;
                left.push(piece);
            }
            now[place] = meet(&now[place], &other[place]);
            if now[place].is_empty() {
                break;
            }
        }
    }
    left
}

/// The same as fewer products, where two differ in one coordinate alone.
pub fn merged(mut patches: Vec<Patch>) -> Vec<Patch> {
    let joinable = |one: &Patch, other: &Patch| {
        let mut differing = (0..one.len()).filter(|place| one[*place] != other[*place]);
        match (differing.next(), differing.next()) {
            (place, None) => Some(place.unwrap_or(0)),
            _ => None,
        }
    };
    let coordinates = patches.first().map_or(0, Vec::len);
    // One coordinate at a time: what is alike in all others is joined before the next is looked at.
    for wanted in (0..coordinates).chain(0..coordinates) {
        let mut place = 0;
        while place < patches.len() {
            let found =
                (place + 1..patches.len()).find(|other| joinable(&patches[place], &patches[*other]) == Some(wanted));
            match found {
                Some(other) => {
                    let other = patches.swap_remove(other);
                    patches[place][wanted] = join(&patches[place][wanted], &other[wanted]);
                }
                None => place += 1,
            }
        }
    }
    patches
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(ends: &[(i32, i32)]) -> Set {
        let end = |number: i32| (number.abs() < 100).then(|| BigRational::from_integer(number.into()));
        ends.iter().map(|(low, high)| (end(*low), end(*high))).collect()
    }

    #[test]
    fn sets_are_cut_and_joined() {
        let middle = set(&[(-1, 1)]);
        assert_eq!(without(&whole(), &middle), set(&[(-100, -1), (1, 100)]));
        assert_eq!(without(&whole(), &Set::new()), whole());
        assert_eq!(without(&middle, &whole()), Set::new());
        assert_eq!(join(&set(&[(-100, -1)]), &set(&[(-1, 1), (1, 100)])), whole());
        assert_eq!(join(&set(&[(0, 5)]), &set(&[(1, 2), (7, 100)])), set(&[(0, 5), (7, 100)]));
        assert_eq!(meet(&set(&[(-100, 0), (2, 9)]), &set(&[(-3, 4)])), set(&[(-3, 0), (2, 4)]));
    }

    #[test]
    fn the_outside_of_a_square_is_two_products() {
        let square = vec![set(&[(-1, 1)]), set(&[(-1, 1)])];
        let mut pieces = Vec::new();
        let sides = [set(&[(-100, -1)]), set(&[(-1, 1)]), set(&[(1, 100)])];
        for one in &sides {
            for other in &sides {
                let piece = vec![one.clone(), other.clone()];
                if piece != square {
                    pieces.push(piece);
                }
            }
        }
        assert_eq!(merged(pieces.clone()).len(), 2);
        assert_eq!(merged(outside(vec![vec![whole(), whole()]], &square)).len(), 2);
        pieces.push(square);
        assert_eq!(merged(pieces), vec![vec![whole(), whole()]]);
    }
}
