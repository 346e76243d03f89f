//! Values as text that parses back to them.

use std::fmt;

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use super::{Atom, Exponent, Sum, Value, View};

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.view() {
            View::Vector(parts) => list(f, &parts),
            View::Distribution(kind, parts) => distribution(f, &kind, &parts),
            View::Real(above, below) => fraction(f, &above, &below),
        }
    }
}

fn list(f: &mut fmt::Formatter<'_>, parts: &[Value]) -> fmt::Result {
    f.write_str("(")?;
    for (place, part) in parts.iter().enumerate() {
        write!(f, "{}{part}", if place == 0 { "" } else { ", " })?;
    }
    f.write_str(")")
}

fn distribution(f: &mut fmt::Formatter<'_>, kind: &str, parts: &[Value]) -> fmt::Result {
    match (kind, parts) {
        ("Normal", [mean, variance]) => write!(f, "Normal({mean}, var: {variance})"),
        ("Exp", [rate]) => write!(f, "Exp(rate: {rate})"),
        ("Mix", parts) => {
            f.write_str("Mix(")?;
            for (place, pair) in parts.chunks(2).enumerate() {
                if let [weight, part] = pair {
                    write!(f, "{}{weight}: {part}", if place == 0 { "" } else { ", " })?;
                }
            }
            f.write_str(")")
        }
        (kind, parts) => {
            f.write_str(kind)?;
            list(f, parts)
        }
    }
}

fn fraction(f: &mut fmt::Formatter<'_>, above: &Sum, below: &Sum) -> fmt::Result {
    let one = matches!(below.as_slice(), [(number, factors)] if number.is_one() && factors.is_empty());
    if one {
        return sum(f, above);
    }
    if above.len() == 1 {
        sum(f, above)?
    } else {
        bracketed(f, above)?
    }
    f.write_str("/")?;
    match below.as_slice() {
        [(number, factors)] if number.is_one() && factors.len() == 1 => product(f, factors),
        _ => bracketed(f, below),
    }
}

fn bracketed(f: &mut fmt::Formatter<'_>, terms: &Sum) -> fmt::Result {
    f.write_str("(")?;
    sum(f, terms)?;
    f.write_str(")")
}

/// Constants last, so that `p0 + 1` reads as people write it.
fn sum(f: &mut fmt::Formatter<'_>, terms: &Sum) -> fmt::Result {
    if terms.is_empty() {
        return f.write_str("0");
    }
    let (constant, mut ordered): (Vec<_>, Vec<_>) = terms.iter().partition(|(_, factors)| factors.is_empty());
    ordered.sort_by_key(|(number, _)| number.is_negative());
    ordered.extend(constant);
    for (place, (number, factors)) in ordered.into_iter().enumerate() {
        match (place, number.is_negative()) {
            (0, true) => f.write_str("-")?,
            (0, false) => {}
            (_, true) => f.write_str(" - ")?,
            (_, false) => f.write_str(" + ")?,
        }
        term(f, &number.abs(), factors)?;
    }
    Ok(())
}

fn term(f: &mut fmt::Formatter<'_>, number: &BigRational, factors: &[(Atom, Exponent)]) -> fmt::Result {
    if factors.is_empty() {
        return write!(f, "{number}");
    }
    if number.is_one() {
        return product(f, factors);
    }
    if *number.numer() != BigInt::one() {
        write!(f, "{}*", number.numer())?;
    }
    product(f, factors)?;
    if number.denom().is_one() { Ok(()) } else { write!(f, "/{}", number.denom()) }
}

fn product(f: &mut fmt::Formatter<'_>, factors: &[(Atom, Exponent)]) -> fmt::Result {
    for (place, (atom, exponent)) in factors.iter().enumerate() {
        if place > 0 {
            f.write_str("*")?;
        }
        power(f, atom, *exponent)?;
    }
    Ok(())
}

fn power(f: &mut fmt::Formatter<'_>, atom: &Atom, exponent: Exponent) -> fmt::Result {
    if let Atom::Power(base, symbolic) = atom {
        primary(f, base)?;
        f.write_str("^")?;
        return if exponent == 1 { primary(f, symbolic) } else { write!(f, "({exponent}*({symbolic}))") };
    }
    match atom {
        Atom::Variable(name) => write!(f, "{name}")?,
        Atom::Maximum(parts) => {
            f.write_str("max(0")?;
            parts.iter().try_for_each(|part| write!(f, ", {part}"))?;
            f.write_str(")")?;
        }
        Atom::Positive(of) => write!(f, "(if {of} > 0 then 1 else 0)")?,
        Atom::Floor(of) => write!(f, "floor({of})")?,
        Atom::Root(of) => write!(f, "sqrt({of})")?,
        Atom::Apply(function, arguments) => {
            write!(f, "{function}")?;
            list(f, arguments)?;
        }
        Atom::Power(..) => {}
    }
    if exponent == 1 { Ok(()) } else { write!(f, "^{exponent}") }
}

/// With brackets unless it is a name or a natural number.
fn primary(f: &mut fmt::Formatter<'_>, value: &Value) -> fmt::Result {
    let natural = value.as_rational().is_some_and(|number| number.is_integer() && number >= BigRational::zero());
    if natural || value.as_variable().is_some() { write!(f, "{value}") } else { write!(f, "({value})") }
}
