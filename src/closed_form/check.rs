//! The induction: the forms give the starting values, and from every index on to the next what the recurrence says.

use std::cell::OnceCell;
use std::collections::BTreeMap;

use num_traits::ToPrimitive;

use super::apart::{apart, has_meaning, hidden_needs, images_of, products_are_never_zero};
use super::defined::Defined;
use super::names::names;
use super::pieces::divides_by;
use super::signs::Signs;
use super::turned::{only_numbers, turned};
use super::whole_parts::with_known_parts;
use super::{Comparison, Form, Nested, Recurrence, Solved, Unchecked, in_class, product};
use crate::assumption::Assumptions;
use crate::exponential_polynomial::{ExponentialPolynomial, exponentials};
use crate::name::Name;
use crate::value::{Atom, Relation, Value};

/// The most turns of a periodic form, and the most first terms.
const MOST_TURNS: usize = 400;

impl Solved {
    /// The forms with the recurrence, if they can be shown to solve it under the assumptions and conditions. A
    /// divisor that is free of the index and not known to differ from 0 becomes a condition.
    ///
    /// # Errors
    /// Where the induction fails.
    pub fn check(
        recurrence: Recurrence,
        forms: Vec<Form>,
        conditions: Vec<Comparison>,
        known: &Assumptions,
    ) -> Result<Solved, Unchecked> {
        if forms.len() != recurrence.sequences.len() || forms.is_empty() {
            return Err(failed("the forms are not as many as the sequences"));
        }
        names(&recurrence, &forms, &conditions)?;
        let index = recurrence.index.clone();
        // The index is bound here: what is assumed of a parameter of this name says nothing about it.
        let known = &known.without_name(&index);
        let together = || {
            let defined = Defined::new(&index, recurrence.from, known, conditions.clone());
            let alike = turned(&forms, &recurrence)?;
            let mut induction = Induction { recurrence: &recurrence, forms: &alike, defined };
            induction.run().map(|()| induction.defined.conditions)
        };
        let conditions = match together() {
            Ok(conditions) => conditions,
            Err(reason) => apart(&recurrence, &forms, &conditions, known).map_err(|_| reason)?,
        };
        let mut known = known.clone();
        conditions.iter().for_each(|(relation, left, right)| known.assume(*relation, left, right));
        Ok(Solved { recurrence, forms, conditions, known, as_far: None })
    }
}

pub(super) struct Induction<'a> {
    pub(super) recurrence: &'a Recurrence,
    pub(super) forms: &'a [Form],
    pub(super) defined: Defined<'a>,
}

/// A form that holds from some index on, at an index that lies so many places further.
struct Moved<'a> {
    form: &'a Form,
    by: usize,
    /// It as an exponential polynomial, if it is one: found once for all equations that it stands in.
    sum: OnceCell<Option<ExponentialPolynomial>>,
}

impl Induction<'_> {
    fn run(&mut self) -> Result<(), Unchecked> {
        self.divisors()?;
        match self.forms {
            [Form::Product(ratio, value)] => {
                self.base(0)?;
                self.product(ratio, value)
            }
            [Form::Nested(nested)] => {
                self.base(nested.early.len())?;
                match self.recurrence.sequences.as_slice() {
                    [sequence] => self.nested_step(nested, &sequence.next),
                    _ => Err(failed("a form with sums is of one sequence")),
                }
            }
            forms if forms.iter().any(|form| matches!(form, Form::Pieces(_))) => self.pieces(),
            forms
                if forms.iter().any(|form| matches!(form, Form::Product(..) | Form::Nested(_))) && forms.len() > 1 =>
            {
                let early = self.forms.iter().map(|form| match form {
                    Form::Nested(Nested { early, .. }) | Form::Value(early, _) => early.len(),
                    _ => 0,
                });
                let early = early.max().unwrap_or(0);
                self.base(early)?;
                self.layered(early)
            }
            [Form::Turns(forms)] if forms.iter().any(|form| matches!(form, Form::Product(..) | Form::Nested(_))) => {
                self.in_turn(forms)
            }
            [Form::Turns(first), ..] => self.turns(first.len()),
            _ => {
                let early = early(self.forms).ok_or_else(|| self.unlike())?;
                self.base(early)?;
                self.step(1, 0, self.recurrence.from.saturating_add_unsigned(early as u64))
            }
        }
    }

    /// Everything that is used must be defined.
    fn divisors(&mut self) -> Result<(), Unchecked> {
        let from = self.recurrence.from;
        let terms = self.recurrence.terms();
        // Where all terms are numbers, each step is made with them, and one that divides by 0 is no step.
        let plain = only_numbers(self.recurrence, self.forms);
        let by_pieces = self.forms.iter().any(|form| matches!(form, Form::Pieces(_)));
        for sequence in self.recurrence.sequences.iter().filter(|_| !plain) {
            match terms.iter().find(|(name, ..)| divides_by(&sequence.next, name)) {
                None => self.defined.in_each_case(&sequence.next, from)?,
                // Asked in each piece, where it is known what the terms are.
                Some(_) if by_pieces => {}
                Some(_) => {
                    let images = images_of(self.recurrence, self.forms)?;
                    if images.len() < terms.len() {
                        let all = (self.recurrence, self.forms);
                        products_are_never_zero(&sequence.next, all, &mut self.defined)?;
                    } else {
                        has_meaning(&sequence.next, &images, from, &mut self.defined)?;
                    }
                }
            }
            for value in &sequence.start {
                self.defined.value(value, from)?;
            }
            let summed = self.forms.iter().any(|form| matches!(form, Form::Nested(_)));
            hidden_needs(&sequence.next, (self.recurrence, self.forms), !by_pieces && !summed, &mut self.defined)?;
        }
        if matches!(self.forms, [Form::Turns(_), ..]) {
            self.defined.count_rounds();
        }
        for form in self.forms {
            self.form_divisors(form, from)?;
        }
        Ok(())
    }

    fn form_divisors(&mut self, form: &Form, from: i64) -> Result<(), Unchecked> {
        match form {
            Form::Value(early, value) => {
                self.defined.in_each_case(value, from.saturating_add_unsigned(early.len() as u64))?;
                self.defined.roots(value, self.recurrence)
            }
            Form::Sum(_, sum) => self.defined.sum(sum, from),
            Form::Product(ratio, value) => {
                self.defined.value(ratio, from)?;
                self.defined.value(value, from)
            }
            Form::Nested(nested) => self.nested_divisors(nested, from),
            Form::Turns(forms) => forms.iter().try_for_each(|form| self.form_divisors(form, 0)),
            Form::Pieces(pieces) => pieces.iter().try_for_each(|piece| {
                let first = piece.from.as_rational().and_then(|first| first.to_integer().to_i64());
                self.defined.in_each_case(&piece.form, first.map_or(from, |first| first.max(from)))?;
                self.defined.roots(&piece.form, self.recurrence)
            }),
        }
    }

    pub(super) fn same(&self, left: &Value, right: &Value) -> bool {
        if left == right {
            return true;
        }
        let known = self.defined.known();
        known.decide(Relation::Eq, left, right) == Some(true)
            || left.sub(right).is_ok_and(|difference| {
                // Powers of one number in several forms meet in its base: `(1+sqrt(5))^(2*n)` and `(6+2*sqrt(5))^n`.
                known.simplify(&difference).is_zero()
                    || exponentials(&difference, &self.recurrence.index).is_some_and(|powers| powers.is_empty())
                    || with_known_parts(&difference, known)
                        .map(|rest| known.simplify(&rest))
                        .is_some_and(|rest| known.decide(Relation::Eq, &rest, &Value::zero()) == Some(true))
            })
    }

    /// The first terms, by the recurrence itself: the starting values and so many steps.
    fn base(&self, steps: usize) -> Result<(), Unchecked> {
        let recurrence = self.recurrence;
        if steps > MOST_TURNS {
            return Err(failed("there are too many first terms"));
        }
        let longest = recurrence.sequences.iter().map(|sequence| sequence.start.len()).max().unwrap_or(0);
        let count = longest + steps;
        for (form, wanted) in self.forms.iter().zip(recurrence.iterate(count)?) {
            for (place, value) in wanted.iter().enumerate() {
                let at = recurrence.from.saturating_add_unsigned(place as u64);
                let found = form.at_knowing(&recurrence.index, recurrence.from, at, &|| self.defined.known())?;
                if !self.same(&found, value) {
                    return Err(Unchecked(format!("the form gives {found} at {at}, and it is {value}")));
                }
            }
        }
        Ok(())
    }

    /// The step from `count*n + turn` on, for all n from `since` on, where the forms hold.
    fn step(&self, count: usize, turn: usize, since: i64) -> Result<(), Unchecked> {
        let recurrence = self.recurrence;
        let from = if count == 1 { 0 } else { recurrence.from };
        let (many, offset) = (whole(count)?, from.saturating_add_unsigned(turn as u64));
        let images = recurrence
            .terms()
            .into_iter()
            .map(|(name, place, offset)| Ok((name, self.moved(place, count, turn + offset)?)))
            .collect::<Result<Vec<_>, Unchecked>>()?;
        for (place, sequence) in recurrence.sequences.iter().enumerate() {
            let next = if count == 1 {
                sequence.next.clone()
            } else {
                in_class(&sequence.next, &recurrence.index, many, offset)?
            };
            let next = self.since(next, since);
            let left = self.moved(place, count, turn + sequence.start.len())?;
            self.equation(&left, &next, &images, since).map_err(|Unchecked(reason)| {
                Unchecked(format!("the step of {} could not be checked: {reason}", sequence.name))
            })?;
        }
        Ok(())
    }

    /// An expression for all indices from one on: without the conditions on the index that are decided there, and `0^n`.
    pub(super) fn since(&self, value: Value, since: i64) -> Value {
        let conditional = |atom: &Atom| match atom {
            Atom::Positive(_) | Atom::Maximum(_) => true,
            Atom::Power(base, _) => base.is_zero(),
            _ => false,
        };
        if !value.atoms().iter().any(|atom| conditional(atom) && atom.mentions(&self.recurrence.index)) {
            return value;
        }
        let mut known = self.defined.known().clone();
        known.assume(Relation::Gte, &Value::variable(&self.recurrence.index), &Value::integer(since));
        known.simplify(&value)
    }

    fn moved(&self, place: usize, count: usize, offset: usize) -> Result<Moved<'_>, Unchecked> {
        match &self.forms[place] {
            Form::Turns(forms) if forms.len() == count => {
                Ok(Moved { form: &forms[offset % count], by: offset / count, sum: OnceCell::new() })
            }
            form @ (Form::Value(..) | Form::Sum(..)) if count == 1 => {
                Ok(Moved { form, by: offset, sum: OnceCell::new() })
            }
            _ => Err(self.unlike()),
        }
    }

    /// The forms are of kinds that no induction here is over together.
    pub(super) fn unlike(&self) -> Unchecked {
        let kind = |form: &Form| match form {
            Form::Value(..) | Form::Sum(..) => "one value",
            Form::Product(..) => "a product",
            Form::Nested(_) => "sums and products",
            Form::Turns(_) => "values in turn",
            Form::Pieces(_) => "values by pieces",
        };
        let all = self.recurrence.sequences.iter().zip(self.forms);
        let all: Vec<String> = all.map(|(one, form)| format!("of {} {}", one.name, kind(form))).collect();
        Unchecked(format!("what was found, {}, could not be checked together", all.join(", ")))
    }

    /// Whether a form is what an expression gives for the forms of the terms in it, from an index on.
    fn equation(
        &self,
        left: &Moved<'_>,
        next: &Value,
        images: &[(Name, Moved<'_>)],
        since: i64,
    ) -> Result<(), Unchecked> {
        if let Some(difference) = self.difference(left, next, images)? {
            if difference.is_plainly_zero() || difference.is_zero(self.defined.known()) {
                return Ok(());
            }
            return Err(failed("the sides differ"));
        }
        let index = &self.recurrence.index;
        let settled = self.settled(next, images, since)?;
        if settled != *next
            && let Some(difference) = self.difference(left, &settled, images)?
            && difference.is_plainly_zero()
        {
            return Ok(());
        }
        let mut substitution = BTreeMap::new();
        for (name, moved) in images {
            substitution.insert(name.clone(), moved.value(index)?);
        }
        let (left, right) = (left.value(index)?, settled.substitute(&substitution)?);
        if self.same(&left, &right) || self.same_since(&left, &right, since)? {
            return Ok(());
        }
        Err(Unchecked(format!("{left} is not known to be {right}")))
    }

    /// An equation with what its maxima and conditions are from an index on, where they are signs of exponential polynomials.
    fn settled(&self, next: &Value, images: &[(Name, Moved<'_>)], since: i64) -> Result<Value, Unchecked> {
        let Ok(from) = u64::try_from(since) else { return Ok(next.clone()) };
        let sum = |value: &Value| self.joined(ExponentialPolynomial::zero(), 1, value, images).ok().flatten();
        Ok(Signs { sum: &sum, from, until: None }.settled(next)?)
    }

    /// The difference of both sides as an exponential polynomial; `None` if it is none.
    fn difference(
        &self,
        left: &Moved<'_>,
        next: &Value,
        images: &[(Name, Moved<'_>)],
    ) -> Result<Option<ExponentialPolynomial>, Unchecked> {
        match left.sum(&self.recurrence.index)? {
            Some(left) => self.joined(left.clone(), -1, next, images),
            None => Ok(None),
        }
    }

    /// A sum with what is linear in the terms added to it, so many times; `None` if that is no exponential polynomial.
    fn joined(
        &self,
        mut whole: ExponentialPolynomial,
        times: i64,
        value: &Value,
        images: &[(Name, Moved<'_>)],
    ) -> Result<Option<ExponentialPolynomial>, Unchecked> {
        let (index, times) = (&self.recurrence.index, Value::integer(times));
        let mut rest = value.clone();
        for (name, moved) in images {
            if !rest.mentions(name) {
                continue;
            }
            let Some((factor, constant)) = rest.linear_in(name) else { return Ok(None) };
            if factor.mentions(index) || images.iter().any(|(other, _)| factor.mentions(other)) {
                return Ok(None);
            }
            let Some(sum) = moved.sum(index)? else { return Ok(None) };
            whole = whole.joined(sum.scale(&factor.mul(&times)?)?)?;
            rest = constant;
        }
        let Some(constant) = ExponentialPolynomial::of(&rest, index) else { return Ok(None) };
        Ok(Some(whole.joined(constant.scale(&times)?)?))
    }

    fn product(&self, ratio: &Value, value: &Value) -> Result<(), Unchecked> {
        match self.recurrence.sequences.as_slice() {
            [sequence] if sequence.start.len() == 1 => self.product_step(ratio, value, &sequence.next),
            _ => Err(failed("a form with a product is of one sequence")),
        }
    }

    /// From a form with a product to that at the next index, by an equation in the first term that it reads.
    fn product_step(&self, ratio: &Value, value: &Value, next: &Value) -> Result<(), Unchecked> {
        let (index, recurrence, whole) = (&self.recurrence.index, self.recurrence, product());
        let sequence = recurrence.sequences.first().ok_or_else(|| failed("there is no sequence"))?;
        // What divides by the product would say nothing where it is 0.
        let divides = value.denominator().is_none_or(|denominator| denominator.mentions(&whole));
        if divides || ratio.mentions(&whole) {
            return Err(failed("the form divides by its product"));
        }
        let later = Value::variable(index).add(&Value::one())?;
        let grown = Value::variable(&whole).mul(ratio)?;
        let left = value.with(index, &later)?.with(&whole, &grown)?;
        let right = next.with(&recurrence.term(&sequence.name, 0), value)?;
        if self.same(&left, &right) { Ok(()) } else { Err(failed("the step of the product differs")) }
    }

    /// Turns with products in them, of one sequence whose next term depends on that of one round before alone: each turn
    /// is a sequence of its own.
    fn in_turn(&mut self, forms: &[Form]) -> Result<(), Unchecked> {
        let recurrence = self.recurrence;
        let [sequence] = recurrence.sequences.as_slice() else {
            return Err(failed("forms with products in turn are of one sequence"));
        };
        let count = sequence.start.len();
        let other = |offset: usize| sequence.next.mentions(&recurrence.term(&sequence.name, offset));
        if forms.len() != count || !(2..=MOST_TURNS).contains(&count) || (1..count).any(other) {
            return Err(failed("the turns do not fit"));
        }
        let early = forms.iter().map(|form| if let Form::Nested(nested) = form { nested.early.len() } else { 0 });
        self.base(count * early.max().unwrap_or(0))?;
        for (turn, form) in forms.iter().enumerate() {
            let offset = recurrence.from.saturating_add_unsigned(turn as u64);
            let next = in_class(&sequence.next, &recurrence.index, whole(count)?, offset)?;
            match form {
                Form::Product(ratio, value) => self.product_step(ratio, value, &next)?,
                Form::Nested(nested) => self.nested_step(nested, &next)?,
                Form::Value(early, value) if early.is_empty() && !value.mentions(&product()) => {
                    self.product_step(&Value::one(), value, &next)?;
                }
                _ => return Err(self.unlike()),
            }
        }
        Ok(())
    }

    fn turns(&mut self, count: usize) -> Result<(), Unchecked> {
        let all: Option<Vec<&Vec<Form>>> =
            self.forms.iter().map(|form| if let Form::Turns(forms) = form { Some(forms) } else { None }).collect();
        let all = all.ok_or_else(|| self.unlike())?;
        if !(2..=MOST_TURNS).contains(&count) || all.iter().any(|forms| forms.len() != count) {
            return Err(failed("the turns do not fit"));
        }
        let mut first = 0;
        for forms in &all {
            first = first.max(early(forms).ok_or_else(|| self.unlike())?);
        }
        self.base(count * (first + 1))?;
        self.defined.count_rounds();
        (0..count).try_for_each(|turn| self.step(count, turn, whole(first)?))
    }
}

impl Moved<'_> {
    fn sum(&self, index: &Name) -> Result<Option<&ExponentialPolynomial>, Unchecked> {
        if let Some(known) = self.sum.get() {
            return Ok(known.as_ref());
        }
        let sum = match self.form {
            Form::Sum(_, sum) => Some(sum.clone()),
            Form::Value(_, value) => ExponentialPolynomial::of(value, index),
            _ => None,
        };
        let sum = sum.map(|sum| (0..self.by).try_fold(sum, |sum, _| sum.next())).transpose()?;
        Ok(self.sum.get_or_init(|| sum).as_ref())
    }

    fn value(&self, index: &Name) -> Result<Value, Unchecked> {
        let value = match self.form {
            Form::Value(_, value) => Some(value.clone()),
            Form::Sum(_, sum) => sum.value(index),
            _ => None,
        };
        let value = value.ok_or_else(|| failed("it is a sum over roots, and the equation is not linear"))?;
        Ok(value.with(index, &Value::variable(index).add(&Value::integer(whole(self.by)?))?)?)
    }
}

/// The most first terms of any of the forms; none where one of them is not simple.
fn early(forms: &[Form]) -> Option<usize> {
    let mut most = 0;
    for form in forms {
        match form {
            Form::Value(early, _) | Form::Sum(early, _) => most = most.max(early.len()),
            _ => return None,
        }
    }
    Some(most)
}

pub(super) fn whole(number: usize) -> Result<i64, Unchecked> {
    i64::try_from(number).map_err(|_| failed("too many turns"))
}

pub(super) fn failed(text: &str) -> Unchecked {
    Unchecked(text.to_string())
}
