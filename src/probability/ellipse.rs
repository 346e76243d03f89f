//! Distances by which a round is decided: a place in the plane of which the two numbers have noise of their own.

use num_rational::BigRational;
use num_traits::Zero;

use super::axes::AXES;
use super::disc::Disc;
use super::draft::{Draft, Owners};
use super::form::Said;
use super::plan::{DECIDERS, DISCS, PLACES, Round};
use super::region::{Set, half};
use crate::rational::{difference, product, quotient};
use crate::value::Relation;

/// `a*(x-c)² + b*(y-d)²`, of a number on each axis, in the making; a is 1.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Ellipse {
    /// By axis: which base it is, or later its place in a patch; the factor; the middle.
    sides: [(usize, BigRational, BigRational); AXES],
}

/// What a comparison says of a patch.
pub(super) enum Compared {
    Always,
    Never,
    /// What lies at a place of the patch.
    Within(usize, Set),
}

const ALONE: &str = "a distance is compared whose parts have no noise of their own";

impl Draft<'_> {
    /// Where the numbers must lie for a comparison of a distance to hold.
    pub(super) fn disc(
        &self,
        disc: &Disc,
        bound: &BigRational,
        relation: Relation,
        owners: &mut Owners,
    ) -> Result<Compared, String> {
        let mut forms = Vec::new();
        for (factor, linear) in &disc.squares {
            forms.push((factor, self.form(linear)?));
        }
        let noisy = |form: &super::form::Form| form.draws.iter().any(|factor| !factor.is_zero());
        let known = |form: &super::form::Form| !noisy(form) && form.factors.iter().all(Zero::is_zero);
        if forms.iter().all(|(_, form)| known(form)) {
            let square = |(factor, form): &(&BigRational, super::form::Form)| *factor * &form.offset * &form.offset;
            let sum = forms.iter().map(square).sum::<BigRational>() - bound;
            return Ok(if relation.holds(sum.cmp(&BigRational::zero())) { Compared::Always } else { Compared::Never });
        }
        if !forms.iter().all(|(_, form)| noisy(form)) {
            return Err(ALONE.to_string());
        }
        match relation {
            Relation::Eq => return Ok(Compared::Never),
            Relation::Neq => return Ok(Compared::Always),
            _ => {}
        }
        let mut sides: [Option<(usize, BigRational, BigRational)>; AXES] = [None, None];
        for (factor, form) in forms {
            let draw = form.draws.iter().position(|factor| !factor.is_zero()).ok_or(ALONE)?;
            let axis = owners.draws[draw].ok_or("a guard is lost")?;
            let (number, ratio, constant) = form.said(&mut owners.bases[axis], DECIDERS)?;
            let middle = -quotient(&constant, &ratio);
            if sides[axis].replace((number, product(factor, &product(&ratio, &ratio)), middle)).is_some() {
                return Err("the parts of a distance share their noise".to_string());
            }
        }
        let [Some(one), Some(other)] = sides else { return Err(ALONE.to_string()) };
        let over = one.1.clone();
        let ellipse =
            Ellipse { sides: [one, other].map(|(number, factor, middle)| (number, quotient(&factor, &over), middle)) };
        let place = match owners.discs.iter().position(|known| *known == ellipse) {
            Some(place) => place,
            None if owners.discs.len() == DISCS => return Err(format!("more than {DISCS} distances decide a round")),
            None => {
                owners.discs.push(ellipse);
                owners.discs.len() - 1
            }
        };
        let set = half(relation, &over, &-bound);
        Ok(Compared::Within(AXES * PLACES + place, set))
    }
}

impl Ellipse {
    /// Over the places of a patch on an axis, of which it is known what they stand for.
    pub(super) fn settle(&mut self, axis: usize, order: &[Vec<Said>; PLACES]) -> Result<(), String> {
        let (number, factor, middle) = &mut self.sides[axis];
        let said = order.iter().enumerate().find_map(|(place, said)| {
            let one = said.iter().find(|(base, ..)| base == number)?;
            Some((place, one))
        });
        let Some((place, (_, ratio, constant))) = said else { return Err("a distance is lost".to_string()) };
        *number = place;
        *factor = product(factor, &product(ratio, ratio));
        *middle = quotient(&difference(middle, constant), ratio);
        Ok(())
    }

    pub(super) fn round(self) -> Round {
        Round { sides: self.sides }
    }
}
