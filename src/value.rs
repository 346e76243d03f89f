//! Values: exact, immutable, always in normal form.
//!
//! A real value is a reduced fraction of polynomials over [`Atom`]s: what is not built by the four operations
//! (`max`, `if`, roots, symbolic powers, calls) is an atom with its own normal form. Two values that have the same
//! normal form are equal wherever both are defined. A symbolic exponent stands for a natural number, and an
//! equation between values says nothing where a denominator in it is 0: whoever needs that asks for it.

mod arithmetic;
mod denominator;
pub(crate) mod fixed;
mod identity;
mod line;
mod need;
pub(crate) mod number;
mod order;
mod power;
mod relation;
pub(crate) mod root;
pub(crate) mod squares;
mod substitute;
mod text;

use std::collections::BTreeSet;
use std::fmt;
use std::hash::Hash;
use std::sync::atomic::AtomicU64;
use std::sync::{Arc, LazyLock};

use num_rational::BigRational;
use num_traits::{One, ToPrimitive, Zero};

pub use denominator::{keeps_divisors, taken_for_granted};
pub use need::Need;
pub use relation::Relation;

use crate::name::Name;
use crate::polynomial::Polynomial;

/// The unknowns of the polynomials.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Atom {
    /// `x`, `?x`
    Variable(Name),
    /// `b^n`: a base that has no simpler power, and an exponent without integer multiples or sums
    Power(Value, Value),
    /// `max(0, d1, d2, …)`: at least one more element than 0, sorted
    Maximum(Arc<[Value]>),
    /// 1 if p > 0, else 0
    Positive(Value),
    /// `floor(x)`
    Floor(Value),
    /// `sqrt(x)`
    Root(Value),
    /// `f(x, …)` of a function that nothing is known about
    Apply(Name, Arc<[Value]>),
}

/// The exponent of an atom in a monomial, at least 1.
pub type Exponent = u32;

/// A sum: each term a coefficient and a product of powers of atoms.
pub type Sum = Vec<(BigRational, Vec<(Atom, Exponent)>)>;

/// A value taken apart, for printers and engines.
#[derive(Clone, Debug, PartialEq)]
pub enum View {
    /// A real: numerator and denominator.
    Real(Sum, Sum),
    /// A vector: its components.
    Vector(Vec<Value>),
    /// A distribution: its kind and arguments.
    Distribution(String, Vec<Value>),
}

/// What kind of thing a value is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Sort {
    /// A real number.
    Real,
    /// A vector of so many real components.
    Vector(usize),
    /// A probability distribution.
    Distribution,
}

/// Why there is no such value: division by zero, wrong sort, too large.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ValueError(pub String);

impl ValueError {
    pub(crate) fn new(text: impl Into<String>) -> ValueError {
        ValueError(text.into())
    }

    pub(crate) fn too_large() -> ValueError {
        ValueError::new("this value is too large to compute with")
    }
}

impl fmt::Display for ValueError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for ValueError {}

type Outcome = Result<Value, ValueError>;
type Real = Polynomial<Atom>;

/// An exact value in normal form; shared, cheap to copy.
#[derive(Clone)]
pub struct Value(Arc<Shared>);

struct Shared {
    content: Content,
    /// Found when it is first asked for, as most values are never looked up; 0 before.
    hash: AtomicU64,
    size: usize,
    depth: usize,
}

#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
enum Content {
    /// Coprime numerator and denominator; the denominator's leading coefficient is 1.
    Real(Real, Real),
    Vector(Vec<Value>),
    Distribution(String, Vec<Value>),
}

/// The deepest nesting of atoms; every walk over a value recurses no deeper.
const MOST_DEPTH: usize = 64;
/// The most nodes of a value written out as a tree; every walk over a value visits no more.
const MOST_SIZE: usize = 400_000;

impl Atom {
    /// The values in it.
    pub(crate) fn parts(&self) -> Vec<&Value> {
        match self {
            Atom::Variable(_) => Vec::new(),
            Atom::Power(base, exponent) => vec![base, exponent],
            Atom::Maximum(parts) | Atom::Apply(_, parts) => parts.iter().collect(),
            Atom::Positive(part) | Atom::Floor(part) | Atom::Root(part) => vec![part],
        }
    }

    /// The same of other values, as many as [`Atom::parts`] gives.
    ///
    /// # Errors
    /// Where that has no value.
    pub(crate) fn with_parts(&self, parts: Vec<Value>) -> Result<Value, ValueError> {
        match (self, parts.as_slice()) {
            (Atom::Power(..), [base, exponent]) => base.power(exponent),
            (Atom::Maximum(_), parts) => Value::maximum(&[parts, &[Value::zero()]].concat()),
            (Atom::Apply(function, _), parts) => Value::apply(function, parts),
            (Atom::Positive(_), [part]) => Value::truth(Relation::Gtr, part, &Value::zero()),
            (Atom::Floor(_), [part]) => part.floor(),
            (Atom::Root(_), [part]) => part.sqrt(),
            _ => self.value(),
        }
    }

    /// The name of a variable.
    fn name(&self) -> Option<&Name> {
        if let Atom::Variable(name) = self { Some(name) } else { None }
    }

    /// Whether a variable occurs in it.
    pub fn mentions(&self, name: &Name) -> bool {
        match self {
            Atom::Variable(other) => other == name,
            other => other.parts().into_iter().any(|part| part.mentions(name)),
        }
    }

    /// The value that is this atom alone.
    ///
    /// # Errors
    /// When the nesting is too deep.
    pub fn value(&self) -> Result<Value, ValueError> {
        Value::whole(Polynomial::atom(self.clone()))
    }
}

impl Value {
    fn new(content: Content) -> Outcome {
        let (mut size, mut depth) = (1usize, 0usize);
        let mut include = |part: &Value| {
            size = size.saturating_add(part.0.size);
            depth = depth.max(part.0.depth);
        };
        let mut terms = 0;
        match &content {
            Content::Real(numerator, denominator) => {
                for (monomial, _) in numerator.terms().iter().chain(denominator.terms()) {
                    terms += 1 + monomial.factors().len();
                    monomial.factors().iter().for_each(|(atom, _)| atom.parts().into_iter().for_each(&mut include));
                }
            }
            Content::Vector(parts) | Content::Distribution(_, parts) => parts.iter().for_each(include),
        }
        let (size, depth) = (size.saturating_add(terms), depth + 1);
        if size > MOST_SIZE || depth > MOST_DEPTH {
            return Err(ValueError::too_large());
        }
        Ok(Value::sealed(content, size, depth))
    }

    fn sealed(content: Content, size: usize, depth: usize) -> Value {
        Value(Arc::new(Shared { hash: AtomicU64::new(0), content, size, depth }))
    }

    /// A polynomial as a value; its relations are reduced already.
    fn whole(numerator: Real) -> Outcome {
        if !numerator.is_modest() {
            return Err(ValueError::too_large());
        }
        Value::new(Content::Real(numerator, Polynomial::one()))
    }

    /// An integer.
    pub fn integer(number: i64) -> Value {
        match number {
            0 => Value::zero(),
            1 => Value::one(),
            _ => Value::rational(BigRational::from_integer(number.into())),
        }
    }

    /// An exact rational number.
    pub fn rational(number: BigRational) -> Value {
        Value::sealed(Content::Real(Polynomial::constant(number), Polynomial::one()), 2, 1)
    }

    /// `numerator / denominator`.
    ///
    /// # Errors
    /// When the denominator is 0.
    pub fn fraction(numerator: i64, denominator: i64) -> Result<Value, ValueError> {
        Value::integer(numerator).div(&Value::integer(denominator))
    }

    /// 0
    pub fn zero() -> Value {
        static ZERO: LazyLock<Value> = LazyLock::new(|| Value::rational(BigRational::zero()));
        ZERO.clone()
    }

    /// 1
    pub fn one() -> Value {
        static ONE: LazyLock<Value> = LazyLock::new(|| Value::rational(BigRational::one()));
        ONE.clone()
    }

    /// A variable or metavariable.
    pub fn variable(name: &Name) -> Value {
        Value::sealed(Content::Real(Polynomial::atom(Atom::Variable(name.clone())), Polynomial::one()), 3, 1)
    }

    /// An uninterpreted function of numbers or vectors; the result is a number.
    ///
    /// # Errors
    /// When an argument is a distribution, or the nesting is too deep.
    pub fn apply(function: &Name, arguments: &[Value]) -> Result<Value, ValueError> {
        if arguments.iter().any(|argument| argument.sort() == Sort::Distribution) {
            return Err(ValueError::new(format!("{function} is applied to a distribution; it takes numbers")));
        }
        if let ("part", [whole, place]) = (function.as_str(), arguments) {
            return whole.part(place);
        }
        Value::whole(Polynomial::atom(Atom::Apply(function.clone(), arguments.into())))
    }

    /// `part(r, 2)`: the component at this place, counted from 1. Of a variable it is kept until that has a value.
    fn part(&self, place: &Value) -> Outcome {
        let number =
            place.as_rational().filter(|place| place.is_integer()).and_then(|place| place.to_integer().to_usize());
        match (number, &self.0.content) {
            (None | Some(0), _) => Err(ValueError::new(format!("{place} is the place of no component: 1, 2, …"))),
            (Some(place), Content::Vector(parts)) => parts
                .get(place - 1)
                .cloned()
                .ok_or_else(|| ValueError::new(format!("a vector of {} has no component {place}", parts.len()))),
            _ if self.as_variable().is_some() => {
                Value::whole(Polynomial::atom(Atom::Apply(Name::new("part"), [self.clone(), place.clone()].into())))
            }
            _ => Err(ValueError::new("a vector is needed here, and this is a number")),
        }
    }

    /// A vector of numbers.
    ///
    /// # Errors
    /// When a component is not a number, or there are fewer than two.
    pub fn vector(components: Vec<Value>) -> Result<Value, ValueError> {
        if components.len() < 2 {
            return Err(ValueError::new("a vector has at least two components"));
        }
        match components.iter().find(|component| component.sort() != Sort::Real) {
            Some(other) => Err(ValueError::new(format!("a component of a vector is {}, not a number", other.sort()))),
            None => Value::new(Content::Vector(components)),
        }
    }

    /// The component at this place, counted from 0.
    pub fn component(&self, place: usize) -> Option<Value> {
        match &self.0.content {
            Content::Vector(parts) => parts.get(place).cloned(),
            _ => None,
        }
    }

    /// All components; none where it is no vector.
    pub fn components(&self) -> Option<Vec<Value>> {
        match &self.0.content {
            Content::Vector(parts) => Some(parts.clone()),
            _ => None,
        }
    }

    fn parts(&self) -> Option<(&Real, &Real)> {
        match &self.0.content {
            Content::Real(numerator, denominator) => Some((numerator, denominator)),
            _ => None,
        }
    }

    fn real(&self) -> Result<(&Real, &Real), ValueError> {
        self.parts().ok_or_else(|| ValueError::new(format!("a number is needed here, and this is {}", self.sort())))
    }

    /// Its numerator, when it is real.
    pub fn numerator(&self) -> Option<Value> {
        Value::whole(self.parts()?.0.clone()).ok()
    }

    /// Its denominator, when it is real.
    pub fn denominator(&self) -> Option<Value> {
        Value::whole(self.parts()?.1.clone()).ok()
    }

    pub(crate) fn polynomials(&self) -> Option<(&Polynomial<Atom>, &Polynomial<Atom>)> {
        self.parts()
    }

    /// The bits of the longest coefficient; 0 of distributions.
    pub(crate) fn bits(&self) -> u64 {
        match &self.0.content {
            Content::Vector(parts) => parts.iter().map(Value::bits).max().unwrap_or(0),
            Content::Real(numerator, denominator) => numerator.bits().max(denominator.bits()),
            Content::Distribution(..) => 0,
        }
    }

    pub(crate) fn from_polynomials(numerator: Polynomial<Atom>, denominator: Polynomial<Atom>) -> Outcome {
        Value::quotient(numerator, denominator)
    }

    /// Its value, when it is a rational number.
    pub fn as_rational(&self) -> Option<BigRational> {
        let (numerator, denominator) = self.parts()?;
        if denominator.is_one() { numerator.as_constant() } else { None }
    }

    /// The variable that it is.
    pub fn as_variable(&self) -> Option<&Name> {
        match self.as_atom()? {
            Atom::Variable(name) => Some(name),
            _ => None,
        }
    }

    /// The atom that it is.
    pub fn as_atom(&self) -> Option<&Atom> {
        let (numerator, denominator) = self.parts()?;
        match numerator.terms() {
            [(monomial, number)] if number.is_one() && denominator.is_one() => match monomial.factors() {
                [(atom, 1)] => Some(atom),
                _ => None,
            },
            _ => None,
        }
    }

    /// True of the number 0.
    pub fn is_zero(&self) -> bool {
        self.parts().is_some_and(|(numerator, _)| numerator.is_zero())
    }

    /// Its sort.
    pub fn sort(&self) -> Sort {
        match &self.0.content {
            Content::Real(..) => Sort::Real,
            Content::Vector(parts) => Sort::Vector(parts.len()),
            Content::Distribution(..) => Sort::Distribution,
        }
    }

    /// The number of nodes of it, written out as a tree.
    pub fn size(&self) -> usize {
        self.0.size
    }

    /// The atoms of it that stand in no other atom.
    pub fn atoms(&self) -> BTreeSet<Atom> {
        match &self.0.content {
            Content::Real(numerator, denominator) => {
                numerator.atoms().into_iter().chain(denominator.atoms()).cloned().collect()
            }
            Content::Vector(parts) | Content::Distribution(_, parts) => parts.iter().flat_map(Value::atoms).collect(),
        }
    }

    /// The values inside its atoms, or its components.
    fn direct_parts(&self) -> Vec<Value> {
        match &self.0.content {
            Content::Real(..) => self.atoms().iter().flat_map(Atom::parts).cloned().collect(),
            Content::Vector(parts) | Content::Distribution(_, parts) => parts.clone(),
        }
    }

    /// The variables in it.
    pub fn variables(&self) -> BTreeSet<Name> {
        let mut found = BTreeSet::new();
        self.collect_variables(&mut found);
        found
    }

    fn collect_variables(&self, found: &mut BTreeSet<Name>) {
        let mut visit = |atom: &Atom| match atom {
            Atom::Variable(name) => {
                found.insert(name.clone());
            }
            other => other.parts().into_iter().for_each(|part| part.collect_variables(found)),
        };
        match &self.0.content {
            Content::Real(numerator, denominator) => {
                numerator.atoms().into_iter().chain(denominator.atoms()).for_each(&mut visit);
            }
            Content::Vector(parts) | Content::Distribution(_, parts) => {
                parts.iter().for_each(|part| part.collect_variables(found));
            }
        }
    }

    /// Whether a variable occurs in it.
    pub fn mentions(&self, name: &Name) -> bool {
        match &self.0.content {
            Content::Real(numerator, denominator) => {
                let mut factors = numerator.terms().iter().chain(denominator.terms());
                factors.any(|(monomial, _)| monomial.factors().iter().any(|(atom, _)| atom.mentions(name)))
            }
            Content::Vector(parts) | Content::Distribution(_, parts) => parts.iter().any(|part| part.mentions(name)),
        }
    }

    /// `(c, d)` with the value equal to `c*x + d`, and x in neither.
    pub fn linear_in(&self, name: &Name) -> Option<(Value, Value)> {
        let (numerator, denominator) = self.parts()?;
        let mut parts = numerator.coefficients_in(&Atom::Variable(name.clone()));
        let (constant, factor) = (parts.remove(&0).unwrap_or_else(Polynomial::zero), parts.remove(&1));
        if !parts.is_empty() {
            return None;
        }
        let over = |part: Real| Value::quotient(part, denominator.clone()).ok().filter(|value| !value.mentions(name));
        let free = denominator
            .terms()
            .iter()
            .all(|(monomial, _)| monomial.factors().iter().all(|(atom, _)| !atom.mentions(name)));
        if free { Some((over(factor.unwrap_or_else(Polynomial::zero))?, over(constant)?)) } else { None }
    }

    /// It taken apart.
    pub fn view(&self) -> View {
        let sum = |polynomial: &Real| {
            let terms = polynomial.terms().iter();
            terms.map(|(monomial, number)| (number.clone(), monomial.factors().to_vec())).collect()
        };
        match &self.0.content {
            Content::Real(numerator, denominator) => View::Real(sum(numerator), sum(denominator)),
            Content::Vector(parts) => View::Vector(parts.clone()),
            Content::Distribution(kind, parts) => View::Distribution(kind.clone(), parts.clone()),
        }
    }
}

impl fmt::Debug for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}
