//! Closed forms of recurrences, as theorems by induction.
//!
//! Only [`Solved::check`] makes a [`Solved`], and [`Solved::instance`] one of another. The check believes nothing of whoever
//! found the forms: it derives anew, by exact normal forms, that they give the starting values and that each next term is
//! what the recurrence says, for every n. An instance is the same theorem for one value of a parameter.

mod apart;
mod as_far;
mod behind;
mod cells;
mod check;
mod comparing;
mod defined;
mod divisors;
mod first;
mod induction;
mod instance;
mod names;
mod nested;
mod never;
mod one_by_one;
mod pieces;
mod readable;
mod remainders;
mod rooted;
mod rounds;
mod signs;
mod since;
mod simpler;
mod stretches;
mod summed;
mod text;
mod turned;
mod units;
mod whole_parts;

use std::collections::BTreeSet;

use crate::assumption::Assumptions;
use crate::exponential_polynomial::ExponentialPolynomial;
use crate::name::Name;
use crate::value::{Atom, Relation, Value, ValueError};

pub(crate) use apart::{Case, closures, in_cases, needs_in_cases};
pub use as_far::AsFar;
pub(crate) use behind::behind;
pub(crate) use cells::{Cell, NotKnown, cells, cells_or_none};
pub use defined::first_zero;
pub use first::{Earlier, Wanted, first, holds_there};
pub use nested::{Layer, Nested, layer};
pub use never::{Never, never};
pub(crate) use pieces::for_all_signs;
pub use remainders::{Differ, differ};
pub(crate) use rounds::{by_place, first_lap, first_round, with_first_round};
pub(crate) use signs::settled_by;
pub(crate) use simpler::simpler;
pub(crate) use stretches::remainders;
pub(crate) use summed::sum_of;
pub(crate) use text::{as_it_stands, bracketed, compared, needed};
pub(crate) use whole_parts::with_known_parts;

/// A comparison that must hold for a result to be right.
pub type Comparison = (Relation, Value, Value);

/// Sequences, each with as many starting values as its order; the equations hold for every index from `from` on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Recurrence {
    /// The index, `n`.
    pub index: Name,
    /// The index of the first starting values.
    pub from: i64,
    /// The sequences.
    pub sequences: Vec<Sequence>,
}

/// `f(n+2) = f(n+1) + f(n), f(0) = 0, f(1) = 1`
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sequence {
    /// Its name.
    pub name: Name,
    /// Its first values; their number is the order.
    pub start: Vec<Value>,
    /// The next value: an expression in the index and in the variables [`Recurrence::term`].
    pub next: Value,
}

impl Recurrence {
    /// The variable that stands for a term: `f(n+1)` for the offset 1.
    pub fn term(&self, name: &Name, offset: usize) -> Name {
        term(name, &self.index, offset)
    }

    /// The sequence of this name, with its place.
    pub fn sequence(&self, name: &Name) -> Option<(usize, &Sequence)> {
        self.sequences.iter().enumerate().find(|(_, sequence)| sequence.name == *name)
    }

    /// Every variable that stands for a term, with the place of its sequence and its offset.
    pub fn terms(&self) -> Vec<(Name, usize, usize)> {
        let all = self.sequences.iter().enumerate();
        all.flat_map(|(place, sequence)| {
            (0..sequence.start.len()).map(move |offset| (self.term(&sequence.name, offset), place, offset))
        })
        .collect()
    }

    /// Whether the equation of one sequence reads a term of another.
    pub(crate) fn reads(&self) -> impl Fn(usize, usize) -> bool {
        let terms = self.terms();
        move |one, other| {
            let next = &self.sequences[one].next;
            terms.iter().any(|(name, place, _)| *place == other && next.mentions(name))
        }
    }

    /// These sequences alone.
    pub(crate) fn only(&self, places: &BTreeSet<usize>) -> Recurrence {
        let sequences = places.iter().map(|place| self.sequences[*place].clone()).collect();
        Recurrence { index: self.index.clone(), from: self.from, sequences }
    }

    /// The first terms of every sequence, by plain iteration.
    ///
    /// # Errors
    /// When a term is not defined or too large.
    pub fn iterate(&self, count: usize) -> Result<Vec<Vec<Value>>, ValueError> {
        let mut all: Vec<Vec<Value>> = self.sequences.iter().map(|sequence| sequence.start.clone()).collect();
        let variables = self.terms();
        for step in 0..count {
            if all.iter().all(|terms| terms.len() >= count) {
                break;
            }
            let index = Value::integer(self.from.saturating_add(i64::try_from(step).unwrap_or(i64::MAX)));
            let mut images: std::collections::BTreeMap<Name, Value> = variables
                .iter()
                .map(|(name, place, offset)| (name.clone(), all[*place][step + offset].clone()))
                .collect();
            images.insert(self.index.clone(), index);
            for (terms, sequence) in all.iter_mut().zip(&self.sequences) {
                terms.push(sequence.next.substitute(&images)?);
            }
        }
        all.iter_mut().for_each(|terms| terms.truncate(count));
        Ok(all)
    }
}

/// The variable that stands for a term of a sequence.
pub fn term(name: &Name, index: &Name, offset: usize) -> Name {
    let (name, index) = (name.as_str(), index.as_str());
    match offset {
        0 => Name::new(&[name, "(", index, ")"].concat()),
        _ => Name::new(&[name, "(", index, "+", &offset.to_string(), ")"].concat()),
    }
}

/// One piece of a form by pieces.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Piece {
    /// The first index.
    pub from: Value,
    /// The index after the last; none for the last piece.
    pub until: Option<Value>,
    /// The value at an index, counted from the start of the recurrence.
    pub form: Value,
}

/// A closed form in the index.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Form {
    /// The first terms, and a value for all later ones.
    Value(Vec<Value>, Value),
    /// The first terms, and a sum over roots for all later ones.
    Sum(Vec<Value>, ExponentialPolynomial),
    /// With `[k] = ratio(from) * … * ratio(n-1)` as a new variable, [`product`]: the ratio in the index, and the value.
    Product(Value, Value),
    /// The first terms, and a value in sums and products for all later ones.
    Nested(Nested),
    /// One form after the other, in turn: the form at `place % count`, with `place / count` for the index, where
    /// the place is counted from the first index.
    Turns(Vec<Form>),
    /// By pieces whose ends may be symbolic.
    Pieces(Vec<Piece>),
}

/// The variable that stands for the product in a [`Form::Product`].
pub fn product() -> Name {
    Name::new("[product]")
}

/// A recurrence with its closed forms, checked.
#[derive(Clone, Debug)]
pub struct Solved {
    recurrence: Recurrence,
    forms: Vec<Form>,
    conditions: Vec<Comparison>,
    known: Assumptions,
    as_far: Option<AsFar>,
}

/// The forms could not be shown to be right, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unchecked(pub String);

impl From<ValueError> for Unchecked {
    fn from(error: ValueError) -> Unchecked {
        Unchecked(error.0)
    }
}

/// The most factors that are multiplied for one term.
const MOST_FACTORS: i64 = 200_000;

impl Form {
    /// The term of this index, of a recurrence that begins with the index `from`.
    ///
    /// # Errors
    /// When it is not known which piece holds, or the term is too large.
    pub fn at(&self, index: &Name, from: i64, at: i64, known: &Assumptions) -> Result<Value, ValueError> {
        self.at_knowing(index, from, at, &|| known)
    }

    /// The same, where what is known is asked for by pieces alone.
    pub(crate) fn at_knowing<'k>(
        &self,
        index: &Name,
        from: i64,
        at: i64,
        known: &dyn Fn() -> &'k Assumptions,
    ) -> Result<Value, ValueError> {
        let place = usize::try_from(at.saturating_sub(from)).map_err(|_| error("there is no such term"))?;
        match self {
            Form::Value(early, _) | Form::Sum(early, _) if place < early.len() => Ok(early[place].clone()),
            Form::Value(_, value) => value.with(index, &Value::integer(at)),
            Form::Sum(_, sum) => match u64::try_from(at) {
                Ok(at) => sum.at(at),
                Err(_) => {
                    let back = (0..at.unsigned_abs()).try_fold(sum.clone(), |sum, _| sum.previous())?;
                    back.at(0)
                }
            },
            Form::Product(ratio, value) => {
                if at.saturating_sub(from) > MOST_FACTORS {
                    return Err(error("this term is too large to compute"));
                }
                let factors = (from..at).map(|at| ratio.with(index, &Value::integer(at)));
                let whole = multiplied(&factors.collect::<Result<Vec<_>, _>>()?)?;
                value.with(index, &Value::integer(at))?.with(&product(), &whole)
            }
            Form::Nested(nested) => match nested.early.get(place) {
                Some(term) => Ok(term.clone()),
                None => nested.at(index, from.saturating_add_unsigned(nested.early.len() as u64), at),
            },
            Form::Turns(forms) => {
                let count = forms.len().max(1);
                let round = i64::try_from(place / count).map_err(|_| error("there is no such term"))?;
                let form = forms.get(place % count).ok_or_else(|| error("there is no such term"))?;
                form.at_knowing(index, 0, round, known)
            }
            Form::Pieces(pieces) => {
                let at = Value::integer(at);
                for piece in pieces {
                    let here = match &piece.until {
                        None => Some(true),
                        Some(until) => known().decide(Relation::Lss, &at, until),
                    };
                    match here {
                        Some(true) => return piece.form.with(index, &at),
                        Some(false) => {}
                        None => return Err(error("it is not known in which piece the term lies")),
                    }
                }
                Err(error("there is no such term"))
            }
        }
    }

    /// By pieces, of a recurrence that begins with the index `from`: its first terms one by one; `None` where it is none.
    pub(crate) fn by_pieces(&self, index: &Name, from: i64) -> Option<Vec<Piece>> {
        let (early, value) = match self {
            Form::Pieces(pieces) => return Some(pieces.clone()),
            Form::Value(early, value) => (early, value.clone()),
            Form::Sum(early, sum) => (early, sum.value(index)?),
            _ => return None,
        };
        let mut all = Vec::new();
        let mut place = from;
        for term in early {
            let next = place.checked_add(1)?;
            all.push(Piece { from: Value::integer(place), until: Some(Value::integer(next)), form: term.clone() });
            place = next;
        }
        all.push(Piece { from: Value::integer(place), until: None, form: value });
        Some(all)
    }

    /// As one value in the index, for all terms; `None` when it is none.
    pub fn value(&self, index: &Name) -> Option<Value> {
        match self {
            Form::Value(early, value) if early.is_empty() => Some(value.clone()),
            Form::Sum(early, sum) if early.is_empty() => sum.value(index),
            Form::Pieces(pieces) => match pieces.as_slice() {
                [only] => Some(only.form.clone()),
                _ => None,
            },
            _ => None,
        }
    }

    /// Whether it is one value, with a power of a negative number.
    pub(crate) fn alternates(&self, index: &Name) -> bool {
        let turning = |atom: &Atom| atom.is_sign() && atom.mentions(index);
        self.value(index).is_some_and(|value| value.atoms().iter().any(turning))
    }
}

/// The product, by halves: it stays balanced.
fn multiplied(factors: &[Value]) -> Result<Value, ValueError> {
    match factors {
        [] => Ok(Value::one()),
        [only] => Ok(only.clone()),
        many => {
            let (left, right) = many.split_at(many.len() / 2);
            multiplied(left)?.mul(&multiplied(right)?)
        }
    }
}

fn error(text: &str) -> ValueError {
    ValueError(text.to_string())
}

impl Solved {
    /// What was solved.
    pub fn recurrence(&self) -> &Recurrence {
        &self.recurrence
    }

    /// The forms, in the order of the sequences.
    pub fn forms(&self) -> &[Form] {
        &self.forms
    }

    /// What must hold for them to be right, beyond what was assumed.
    pub fn conditions(&self) -> &[Comparison] {
        &self.conditions
    }

    /// What was assumed, with the conditions.
    pub fn known(&self) -> &Assumptions {
        &self.known
    }

    /// The form of this sequence.
    pub fn form(&self, name: &Name) -> Option<&Form> {
        self.recurrence.sequence(name).map(|(place, _)| &self.forms[place])
    }

    /// The term of a sequence at this index, exactly.
    ///
    /// # Errors
    /// When there is no such sequence or term, or it is too large.
    pub fn at(&self, name: &Name, at: i64) -> Result<Value, ValueError> {
        let form = self.form(name).ok_or_else(|| error("there is no such sequence"))?;
        let value = form.at(&self.recurrence.index, self.recurrence.from, at, &self.known)?;
        // Squares of roots become what they are under the conditions.
        Ok(self.known.simplify(&value))
    }
}

/// A value with `count*n + offset` in place of n, where integer parts and signs that depend on n have become what they
/// are: `floor(n/2)` with `2*n + 1` is n.
///
/// # Errors
/// When the result is too large.
pub fn in_class(value: &Value, index: &Name, count: i64, offset: i64) -> Result<Value, ValueError> {
    let image = Value::variable(index).mul(&Value::integer(count))?.add(&Value::integer(offset))?;
    whole_parts(&value.with(index, &image)?, index)
}

/// The pieces of a form at the indices `count*n + offset`, where n counts the turns: `count*n + offset` is at least f where n is
/// at least `(f-offset)/count`. A piece may be of no index.
///
/// # Errors
/// When a result is too large.
pub(crate) fn pieces_in_class(
    pieces: &[Piece],
    index: &Name,
    count: i64,
    offset: i64,
) -> Result<Vec<Piece>, ValueError> {
    let turn = |at: &Value| at.sub(&Value::integer(offset))?.div(&Value::integer(count))?.ceiling();
    let mut from = Value::zero();
    let mut all = Vec::new();
    for piece in pieces {
        let until = piece.until.as_ref().map(turn).transpose()?;
        // A piece that ends where it begins is surely of none.
        if until.as_ref() == Some(&from) {
            continue;
        }
        let next = until.clone().unwrap_or_else(Value::zero);
        let form = in_class(&piece.form, index, count, offset)?;
        all.push(Piece { from: std::mem::replace(&mut from, next), until, form });
    }
    Ok(all)
}

/// Takes integer multiples of the index out of integer parts.
fn whole_parts(value: &Value, index: &Name) -> Result<Value, ValueError> {
    let mut result = value.clone();
    for atom in value.atoms().into_iter().filter(|atom| atom.mentions(index)) {
        let image = match &atom {
            Atom::Floor(inner) => {
                let inner = whole_parts(inner, index)?;
                match inner.linear_in(index) {
                    Some((factor, rest)) if factor.as_rational().is_some_and(|factor| factor.is_integer()) => {
                        Value::variable(index).mul(&factor)?.add(&rest.floor()?)?
                    }
                    _ => inner.floor()?,
                }
            }
            Atom::Positive(inner) => Value::truth(Relation::Gtr, &whole_parts(inner, index)?, &Value::zero())?,
            Atom::Maximum(elements) => {
                let mut all = vec![Value::zero()];
                for element in elements.iter() {
                    all.push(whole_parts(element, index)?);
                }
                Value::maximum(&all)?
            }
            Atom::Power(base, exponent) => whole_parts(base, index)?.power(&whole_parts(exponent, index)?)?,
            Atom::Root(inner) => whole_parts(inner, index)?.sqrt()?,
            Atom::Apply(..) | Atom::Variable(_) => continue,
        };
        result = result.with_atom(&atom, &image)?;
    }
    Ok(result)
}
