//! Forms with indefinite sums and products: the terms of recurrences that come apart into factors of first order.
//!
//! A layer is a sum or product over the index, in which earlier layers may stand. Its value at the next index follows from
//! its value at this one, which is all that the induction needs.

use std::collections::BTreeMap;

use super::check::{Induction, failed};
use super::defined::Layers;
use super::{Form, Unchecked, error, product};
use crate::name::Name;
use crate::value::{Value, ValueError};

/// The most summands and factors that are computed for one term.
const MOST_STEPS: i64 = 20_000;

/// The first terms, and for all later ones a value in the index and in layers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Nested {
    /// The first terms; the layers begin with the index after them.
    pub early: Vec<Value>,
    /// The sums and products.
    pub layers: Vec<Layer>,
    /// A value in the index and in the variables [`layer`].
    pub value: Value,
}

/// An indefinite sum or product.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Layer {
    /// The product of this up to the index before; never 0.
    Product(Value),
    /// The sum of this up to the index before.
    Sum(Value),
}

/// The variable that stands for a layer in what is built on it.
pub fn layer(place: usize) -> Name {
    Name::new(&format!("[layer {place}]"))
}

impl Layer {
    /// The factor or summand.
    pub fn inner(&self) -> &Value {
        match self {
            Layer::Product(inner) | Layer::Sum(inner) => inner,
        }
    }

    /// The empty product or sum.
    pub fn first(&self) -> Value {
        match self {
            Layer::Product(_) => Value::one(),
            Layer::Sum(_) => Value::zero(),
        }
    }

    /// The same over another factor or summand.
    fn over(&self, inner: Value) -> Layer {
        match self {
            Layer::Product(_) => Layer::Product(inner),
            Layer::Sum(_) => Layer::Sum(inner),
        }
    }

    /// Its place among others, which it joins where it is new.
    pub(crate) fn among(self, layers: &mut Vec<Layer>) -> usize {
        layers.iter().position(|one| *one == self).unwrap_or_else(|| {
            layers.push(self);
            layers.len() - 1
        })
    }

    /// What follows a value of it, from a factor or summand.
    fn following(&self, now: &Value, inner: &Value) -> Result<Value, ValueError> {
        match self {
            Layer::Product(_) => now.mul(inner),
            Layer::Sum(_) => now.add(inner),
        }
    }
}

impl Nested {
    /// A value in the index and the layers, at the next index.
    ///
    /// # Errors
    /// When the result is too large.
    pub fn next(&self, value: &Value, index: &Name) -> Result<Value, ValueError> {
        let mut images = BTreeMap::from([(index.clone(), Value::variable(index).add(&Value::one())?)]);
        for (place, one) in self.layers.iter().enumerate() {
            images.insert(layer(place), one.following(&Value::variable(&layer(place)), one.inner())?);
        }
        value.substitute(&images)
    }

    /// The term of this index, of a sequence whose layers begin with the index `since`.
    pub(crate) fn at(&self, index: &Name, since: i64, at: i64) -> Result<Value, ValueError> {
        if at.saturating_sub(since) > MOST_STEPS {
            return Err(error("this term is too large to compute"));
        }
        let mut images: BTreeMap<Name, Value> =
            self.layers.iter().enumerate().map(|(place, one)| (layer(place), one.first())).collect();
        for step in since..at {
            images.insert(index.clone(), Value::integer(step));
            let mut following = BTreeMap::new();
            for (place, one) in self.layers.iter().enumerate() {
                let name = layer(place);
                following.insert(name.clone(), one.following(&images[&name], &one.inner().substitute(&images)?)?);
            }
            images = following;
        }
        images.insert(index.clone(), Value::integer(at));
        self.value.substitute(&images)
    }

    /// The same, counted from an index that lies so far before.
    ///
    /// # Errors
    /// When the result is too large.
    pub fn with_index(&self, index: &Name, image: &Value) -> Result<Nested, ValueError> {
        let moved = |one: &Layer| Ok::<_, ValueError>(one.over(one.inner().with(index, image)?));
        Ok(Nested {
            early: self.early.clone(),
            layers: self.layers.iter().map(moved).collect::<Result<_, _>>()?,
            value: self.value.with(index, image)?,
        })
    }

    /// The same with the value so many places before, over what the layers are now: a product without its last factor, a sum
    /// without its last summand.
    ///
    /// # Errors
    /// When the result is too large.
    pub(crate) fn delayed(mut self, index: &Name, places: usize) -> Result<Nested, ValueError> {
        let mut images = BTreeMap::from([(index.clone(), Value::variable(index).sub(&Value::one())?)]);
        for (place, one) in self.layers.iter().enumerate() {
            let (now, last) = (Value::variable(&layer(place)), one.inner().substitute(&images)?);
            let before = match one {
                Layer::Product(_) => now.div(&last)?,
                Layer::Sum(_) => now.sub(&last)?,
            };
            images.insert(layer(place), before);
        }
        for _ in 0..places {
            self.value = self.value.substitute(&images)?;
        }
        Ok(self)
    }

    /// The same from a later index on, where its layers begin with `begin`: each is what it was there, times or plus what
    /// comes from there on.
    ///
    /// # Errors
    /// When the result is too large.
    pub(crate) fn beginning(&self, index: &Name, begin: i64, since: i64) -> Result<Nested, ValueError> {
        let (mut images, mut layers) = (BTreeMap::new(), Vec::new());
        for (place, one) in self.layers.iter().enumerate() {
            let name = Value::variable(&layer(place));
            let there = Nested { value: name.clone(), ..self.clone() }.at(index, begin, since)?;
            layers.push(one.over(one.inner().substitute(&images)?));
            images.insert(layer(place), one.following(&there, &name)?);
        }
        Ok(Nested { early: self.early.clone(), layers, value: self.value.substitute(&images)? })
    }

    /// A form of a sequence that begins at `from` as a value over these layers, which begin with the index `since`, and
    /// which its own join; none of one that is no such value from there on.
    ///
    /// # Errors
    /// When a value becomes too large.
    pub(crate) fn holding(
        &mut self,
        form: &Form,
        index: &Name,
        (from, since): (i64, i64),
    ) -> Result<Option<Value>, ValueError> {
        let own = match form {
            Form::Product(ratio, value) => {
                let value = value.with(&product(), &Value::variable(&layer(0)))?;
                Nested { early: Vec::new(), layers: vec![Layer::Product(ratio.clone())], value }
            }
            Form::Nested(nested) => nested.clone(),
            Form::Value(early, value) => {
                return Ok((later(from, early) <= since).then(|| value.clone()));
            }
            other => return Ok(other.value(index)),
        };
        if later(from, &own.early) > since {
            return Ok(None);
        }
        let Nested { layers, value, .. } = own.beginning(index, later(from, &own.early), since)?;
        let mut images = BTreeMap::new();
        for (place, one) in layers.iter().enumerate() {
            let shared = one.over(one.inner().substitute(&images)?).among(&mut self.layers);
            images.insert(layer(place), Value::variable(&layer(shared)));
        }
        value.substitute(&images).map(Some)
    }

    /// Every value in it that may depend on the index, with the number of layers that may stand in it.
    pub(super) fn values(&self) -> impl Iterator<Item = (usize, &Value)> {
        let inner = self.layers.iter().map(Layer::inner).enumerate();
        inner.chain([(self.layers.len(), &self.value)])
    }
}

/// The index after the first terms.
fn later(from: i64, early: &[Value]) -> i64 {
    from.saturating_add_unsigned(early.len() as u64)
}

impl Induction<'_> {
    /// Everything that is divided by is not 0: of layers, products alone are known to be so, where no factor is 0.
    pub(super) fn nested_divisors(&mut self, nested: &Nested, from: i64) -> Result<(), Unchecked> {
        let since = from.saturating_add_unsigned(nested.early.len() as u64);
        let (count, mut products) = (nested.layers.len(), Vec::new());
        for (place, one) in nested.layers.iter().enumerate() {
            self.defined.in_layers(one.inner(), since, Layers { count, fine: &products })?;
            if let Layer::Product(ratio) = one {
                self.defined.never_zero(ratio, since, Layers { count, fine: &products })?;
                products.push(Value::variable(&layer(place)));
            }
        }
        self.defined.in_layers(&nested.value, since, Layers { count, fine: &products })
    }

    /// The step of several sequences over sums and products that they share, from the index on after so many first terms.
    pub(super) fn layered(&self, early: usize) -> Result<(), Unchecked> {
        let (index, recurrence) = (&self.recurrence.index, self.recurrence);
        let since = recurrence.from.saturating_add_unsigned(early as u64);
        let mut whole = Nested { early: Vec::new(), layers: Vec::new(), value: Value::zero() };
        let mut values = Vec::new();
        for form in self.forms {
            let value = whole.holding(form, index, (recurrence.from, since))?;
            values.push(value.ok_or_else(|| self.unlike())?);
        }
        let mut images = BTreeMap::new();
        for (sequence, value) in recurrence.sequences.iter().zip(&mut values) {
            for offset in 0..sequence.start.len() {
                let following = whole.next(value, index)?;
                images.insert(recurrence.term(&sequence.name, offset), std::mem::replace(value, following));
            }
        }
        for (sequence, left) in recurrence.sequences.iter().zip(&values) {
            let next = self.since(sequence.next.clone(), since);
            if !self.same(left, &next.substitute(&images)?) {
                return Err(failed("the step of the sums differs"));
            }
        }
        Ok(())
    }

    /// From as many terms as the order to the next, for all indices at which the layers are there.
    pub(super) fn nested_step(&self, nested: &Nested, next: &Value) -> Result<(), Unchecked> {
        let (index, recurrence) = (&self.recurrence.index, self.recurrence);
        let sequence = recurrence.sequences.first().ok_or_else(|| failed("there is no sequence"))?;
        let (mut images, mut moved) = (BTreeMap::new(), nested.value.clone());
        // In turns the next term is that of the next round, and reads the first alone.
        let rounds = matches!(self.forms, [super::Form::Turns(_)]);
        let order = if rounds { 1 } else { sequence.start.len() };
        let from = if rounds { 0 } else { recurrence.from };
        let next = self.since(next.clone(), from.saturating_add_unsigned(nested.early.len() as u64));
        for offset in 0..order {
            images.insert(recurrence.term(&sequence.name, offset), moved.clone());
            moved = nested.next(&moved, index)?;
        }
        let right = next.substitute(&images)?;
        if self.same(&moved, &right) { Ok(()) } else { Err(failed("the step of the sums differs")) }
    }
}
