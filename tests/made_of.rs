//! Signs by what a form is made of (hidden squares, roots beside what they are compared with, integer parts), against
//! plain computation.

mod common;

use proptest::prelude::*;

use pars::assumption::Assumptions;
use pars::name::Name;
use pars::value::{Relation, Value};

fn named(name: &str) -> Value {
    Value::variable(&Name::new(name))
}

fn int(number: i64) -> Value {
    Value::integer(number)
}

/// `a*x^2 + b*x*y + c*y^2 + d*x + e*y + f`
fn quadratic(factors: &[i64], x: &Value, y: &Value) -> Value {
    let monomials = [x.mul(x), x.mul(y), y.mul(y), Ok(x.clone()), Ok(y.clone()), Ok(Value::one())]
        .map(|part| part.expect("a product"));
    let terms = factors.iter().zip(&monomials).map(|(factor, part)| int(*factor).mul(part).expect("a term"));
    terms.fold(Value::zero(), |sum, term| sum.add(&term).expect("a sum"))
}

fn at(value: &Value, x: i64, y: i64) -> Option<Value> {
    let half = |number: i64| Value::fraction(number, 2).expect("a fraction");
    value.with(&Name::new("x"), &half(x)).and_then(|value| value.with(&Name::new("y"), &half(y))).ok()
}

/// Whether what is decided of a value under x > low and y > low is so at points.
fn holds_at_points(value: &Value, low: i64) -> Result<(), TestCaseError> {
    let mut known = Assumptions::default();
    known.assume(Relation::Gtr, &named("x"), &int(low));
    known.assume(Relation::Gtr, &named("y"), &int(low));
    for relation in [Relation::Gtr, Relation::Gte, Relation::Eq] {
        let Some(decided) = known.decide(relation, value, &Value::zero()) else { continue };
        for (x, y) in (0..36).map(|place| (2 * low + 1 + place % 6 * 3, 2 * low + 1 + place / 6 * 2)) {
            let Some(here) = at(value, x, y) else { continue };
            let Some(own) = Assumptions::default().decide(relation, &here, &Value::zero()) else { continue };
            prop_assert_eq!(own, decided, "{} {} 0 at x = {}/2, y = {}/2", value, relation.symbol(), x, y);
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(common::seeded(ProptestConfig { cases: 200, ..ProptestConfig::default() }))]

    #[test]
    fn a_quadratic(factors in proptest::collection::vec(-3i64..5, 6), low in -2i64..3) {
        holds_at_points(&quadratic(&factors, &named("x"), &named("y")), low)?;
    }

    #[test]
    fn a_root_beside_another_value(under in proptest::collection::vec(0i64..5, 6), beside in proptest::collection::vec(-3i64..4, 3), times in 1i64..4, low in 0i64..3) {
        let (x, y) = (named("x"), named("y"));
        let root = quadratic(&under, &x, &y).sqrt().expect("a root");
        let line = quadratic(&[0, 0, 0, beside[0], beside[1], beside[2]], &x, &y);
        holds_at_points(&int(times).mul(&root).and_then(|root| root.add(&line)).expect("a sum"), low)?;
        holds_at_points(&line.sub(&root).expect("a difference"), low)?;
    }

    #[test]
    fn an_integer_part(line in proptest::collection::vec(-3i64..4, 3), bound in -5i64..6, low in -2i64..3) {
        let (x, y) = (named("x"), named("y"));
        let line = quadratic(&[0, 0, 0, line[0], line[1], line[2]], &x, &y);
        let floor = line.floor().expect("an integer part");
        holds_at_points(&floor.sub(&int(bound)).expect("a difference"), low)?;
        holds_at_points(&int(bound).sub(&floor).expect("a difference"), low)?;
    }
}

#[test]
fn they_tell_what_nothing_else_does() {
    let (v, w) = (named("v"), named("w"));
    let mut known = Assumptions::default();
    known.assume(Relation::Gtr, &w, &Value::zero());
    // (2*v-w)^2 + 800*w
    let apart = int(2).mul(&v).and_then(|twice| twice.sub(&w)).expect("a line");
    let square = apart.mul(&apart).and_then(|square| square.add(&int(800).mul(&w)?)).expect("a sum");
    assert_eq!(known.decide(Relation::Gtr, &square, &Value::zero()), Some(true));
    let over = square.sqrt().and_then(|root| root.sub(&apart)).expect("a difference");
    assert_eq!(known.decide(Relation::Gtr, &over, &Value::zero()), Some(true));
    let up = over.neg().and_then(|less| less.floor()).and_then(|floor| floor.neg()).expect("rounded up");
    assert_eq!(known.decide(Relation::Gte, &up, &Value::one()), Some(true));
    // A distance from a place off the axes.
    let mut known = Assumptions::default();
    known.assume(Relation::Gtr, &named("x"), &int(4));
    let way = Value::vector(vec![named("x").sub(&int(1)).expect("a part"), named("y").add(&int(2)).expect("a part")]);
    let length = way.and_then(|way| way.norm()).expect("a length");
    assert_eq!(known.decide(Relation::Gtr, &length, &Value::zero()), Some(true));
    // Integers that no fraction is.
    let mut known = Assumptions::default();
    known.assume_natural(&Name::new("i"));
    let none = int(3).mul(&named("i")).and_then(|three| three.sub(&int(17))).expect("a difference");
    assert_eq!(known.decide(Relation::Eq, &none, &Value::zero()), Some(false));
    let sixth = int(3).mul(&named("i")).and_then(|three| three.sub(&int(18))).expect("a difference");
    assert_eq!(known.decide(Relation::Eq, &sixth, &Value::zero()), None);
}
