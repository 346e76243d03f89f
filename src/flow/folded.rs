//! Vectors for people: `g-z` and `norm(g-z)` in place of their components and of the root of a sum of squares.

use crate::name::Name;
use crate::term::Term;
use crate::value::{Atom, Sort, Value};

/// A process whose vectors are written as one value each where every component says the same.
pub fn folded(term: &Term) -> Term {
    let shape = term.map_values(&mut |value| Ok::<Value, ()>(value_folded(value))).unwrap_or_else(|()| term.clone());
    shape.with_children(shape.children().map(folded).collect())
}

/// The same of a value.
pub fn value_folded(value: &Value) -> Value {
    let lengths = value.replace(&mut |atom| match atom {
        Atom::Root(radicand) => length(radicand),
        _ => None,
    });
    let value = lengths.unwrap_or_else(|_| value.clone());
    let Sort::Vector(count) = value.sort() else { return value };
    let parts: Option<Vec<Value>> = (0..count).map(|place| value.component(place)).collect();
    parts.and_then(|parts| alike(&parts)).unwrap_or(value)
}

/// `norm(a-b)`, where this is the sum of the squares of the components of a-b.
fn length(radicand: &Value) -> Option<Value> {
    let inside = alike(&radicand.squares()?)?;
    Value::apply(&Name::new("norm"), &[inside]).ok()
}

/// The value over vectors of which these are the components: each is the same over the components in its place of the
/// vectors that it speaks of.
fn alike(parts: &[Value]) -> Option<Value> {
    let mut whole: Option<Value> = None;
    for (place, part) in parts.iter().enumerate() {
        let (mut inside, mut other) = (false, false);
        let image = part.replace(&mut |atom| {
            let Atom::Apply(function, arguments) = atom else { return None };
            let [vector, number] = &arguments[..] else { return None };
            if function.as_str() != "part" {
                return None;
            }
            inside = true;
            other |= *number != Value::integer(place as i64 + 1);
            Some(vector.clone())
        });
        let image = image.ok().filter(|_| inside && !other)?;
        if whole.get_or_insert_with(|| image.clone()) != &image {
            return None;
        }
    }
    whole
}
