//! The normal form of values, and their text.

mod common;

use std::collections::BTreeMap;

use pars::name::Name;
use pars::value::{Relation, Sort, Value};

use common::*;

#[test]
fn text() {
    let (x, y, t, n) = (var("x"), var("y"), var("t"), var("n"));
    let cases = [
        (mul(&frac(1, 2), &x), "1/2*x"),
        (mul(&x, &x), "x^2"),
        (sub(&x, &int(1)), "x-1"),
        (sub(&int(1), &x), "1-x"),
        (x.neg().unwrap(), "-x"),
        (frac(-1, 2), "-1/2"),
        (add(&var("p0"), &mul(&frac(1, 10), &mul(&var("v"), &t))), "p0+1/10*t*v"),
        (frac(1, 2).power(&n).unwrap(), "(1/2)^n"),
        (int(-1).power(&n).unwrap(), "(-1)^n"),
        (int(4).power(&n).unwrap(), "4^n"),
        (frac(3, 2).power(&mul(&n, &t)).unwrap(), "(3/2)^(n*t)"),
        (x.power(&mul(&int(2), &n)).unwrap(), "x^(2*n)"),
        (add(&x, &y).power(&n).unwrap(), "(x+y)^n"),
        (x.abs().unwrap(), "abs(x)"),
        (mul(&int(3), &sub(&x, &y).abs().unwrap()), "3*abs(x-y)"),
        (Value::maximum(&[x.clone(), y.clone()]).unwrap(), "max(y,x)"),
        (Value::minimum(&[x.clone(), y.clone()]).unwrap(), "min(x,y)"),
        (Value::maximum(&[x.clone(), int(0)]).unwrap(), "max(0,x)"),
        (Value::clamp(&x, &int(-1), &int(1)).unwrap(), "clamp(x,-1,1)"),
        (Value::clamp(&sub(&int(10), &x), &t.neg().unwrap(), &t).unwrap(), "clamp(10-x,-t,t)"),
        (Value::clamp(&x.neg().unwrap(), &t.neg().unwrap(), &t).unwrap(), "clamp(-x,-t,t)"),
        (
            add(&x, &Value::clamp(&mul(&frac(1, 2), &sub(&int(10), &x)), &t.neg().unwrap(), &t).unwrap()),
            "1/2*clamp(10-x,-2*t,2*t)+x",
        ),
        (mul(&t, &Value::clamp(&mul(&int(2), &x), &int(-1), &int(1)).unwrap()), "t*clamp(2*x,-1,1)"),
        (Value::choose(Relation::Gtr, &x, &y, &int(1), &t).unwrap(), "if x > y then 1 else t"),
        (Value::choose(Relation::Eq, &x, &y, &int(1), &t).unwrap(), "if x = y then 1 else t"),
        (Value::choose(Relation::Lss, &x, &int(0), &t, &x).unwrap(), "if x < 0 then t else x"),
        (x.floor().unwrap(), "floor(x)"),
        (int(6).sqrt().unwrap(), "sqrt(6)"),
        (int(12).sqrt().unwrap(), "2*sqrt(3)"),
        (div(&x, &add(&y, &int(1))), "x/(y+1)"),
        (div(&add(&x, &int(1)), &add(&y, &frac(1, 2))), "(2*x+2)/(2*y+1)"),
        (div(&int(1), &mul(&int(2), &t)), "1/(2*t)"),
        (div(&sub(&var("a"), &x), &t), "(a-x)/t"),
        (Value::apply(&Name::new("f"), &[x.clone(), int(2)]).unwrap(), "f(x,2)"),
        (Value::vector(vec![x.clone(), int(0)]).unwrap(), "(x,0)"),
        (Value::vector(vec![x.clone(), y.clone()]).unwrap().norm().unwrap(), "norm((x,y))"),
        (Value::vector(vec![x.clone(), y.clone()]).unwrap().unit().unwrap().component(0).unwrap(), "x/norm((x,y))"),
        (Value::distribution("Normal", vec![x.clone(), int(4)]).unwrap(), "Normal(x, var: 4)"),
        (Value::distribution("Exp", vec![int(4)]).unwrap(), "Exp(rate: 4)"),
        (Value::distribution("Uniform", vec![int(0), int(4)]).unwrap(), "Uniform(0,4)"),
        (int(0), "0"),
        (mul(&frac(1, 2), &frac(1, 2).power(&n).unwrap()), "1/2*(1/2)^n"),
        (add(&var("g"), &mul(&frac(1, 2).power(&n).unwrap(), &sub(&var("p0"), &var("g")))), "g+(1/2)^n*(p0-g)"),
    ];
    for (value, text) in cases {
        assert_eq!(value.to_string(), text);
    }
}

#[test]
fn dead_beat() {
    // r + (a-r)/t*t = a
    let (r, a, t) = (var("r"), var("a"), var("t"));
    assert_eq!(add(&r, &mul(&div(&sub(&a, &r), &t), &t)), a);
}

#[test]
fn substitution_removes_what_a_condition_excludes() {
    let x = var("x");
    let value = Value::choose(Relation::Eq, &x, &int(0), &int(7), &div(&int(1), &x)).unwrap();
    let images: BTreeMap<Name, Value> = [(Name::new("x"), int(0))].into();
    assert_eq!(value.substitute(&images).unwrap(), int(7));
    let images: BTreeMap<Name, Value> = [(Name::new("x"), int(4))].into();
    assert_eq!(value.substitute(&images).unwrap(), frac(1, 4));
}

#[test]
fn substitution_is_simultaneous() {
    let (x, y) = (var("x"), var("y"));
    let images: BTreeMap<Name, Value> = [(Name::new("x"), y.clone()), (Name::new("y"), x.clone())].into();
    assert_eq!(sub(&x, &mul(&int(2), &y)).substitute(&images).unwrap(), sub(&y, &mul(&int(2), &x)));
}

#[test]
fn sorts_are_kept_apart() {
    let normal = Value::distribution("Normal", vec![int(0), int(1)]).unwrap();
    let vector = Value::vector(vec![int(1), int(2)]).unwrap();
    assert!(normal.sub(&normal).is_err() && normal.add(&int(1)).is_err() && normal.neg().is_err());
    assert!(vector.add(&int(1)).is_err() && vector.mul(&vector).is_err() && int(1).div(&vector).is_err());
    assert_eq!(vector.sort(), Sort::Vector(2));
    assert_eq!(add(&vector, &vector), mul(&int(2), &vector));
    assert!(Value::distribution("Exp", vec![int(0)]).is_err());
    assert!(Value::distribution("Cauchy", vec![int(0)]).is_err());
}

#[test]
fn blow_up_is_refused() {
    let mut nested = var("x");
    let outcome = (0..1000).try_for_each(|place| {
        nested = nested.add(&frac(1, place + 3))?.floor()?.mul(&frac(1, 2))?;
        Ok::<(), pars::value::ValueError>(())
    });
    assert!(outcome.is_err());
    let mut tower = int(2);
    let outcome = (0..100).try_for_each(|_| {
        tower = tower.mul(&tower)?;
        Ok::<(), pars::value::ValueError>(())
    });
    assert!(outcome.is_err());
    let sum = (0..40).fold(int(1), |sum, place| add(&sum, &var(&format!("x{place}"))));
    assert!(sum.power(&int(1000)).is_err());
}

#[test]
fn linear_parts() {
    let (r, a, t) = (var("r"), var("a"), var("t"));
    let value = add(&r, &div(&mul(&t, &sub(&a, &r)), &int(2)));
    let (factor, rest) = value.linear_in(&Name::new("r")).unwrap();
    assert_eq!(factor, sub(&int(1), &mul(&frac(1, 2), &t)));
    assert_eq!(rest, mul(&frac(1, 2), &mul(&t, &a)));
    assert!(r.abs().unwrap().linear_in(&Name::new("r")).is_none());
}

#[test]
fn a_denominator_that_is_a_condition_is_where_it_holds() {
    let (n, none) = (var("n"), int(0));
    let holds = Value::choose(Relation::Gtr, &n, &none, &int(1), &none).unwrap();
    let sum = int(1).div(&holds).unwrap().add(&int(6).div(&n.mul(&holds).unwrap()).unwrap()).unwrap();
    assert_eq!(sum, n.add(&int(6)).unwrap().div(&n.mul(&holds).unwrap()).unwrap());
    assert_eq!(sum, int(1).add(&int(6).div(&n).unwrap()).unwrap());
    let fails = int(1).sub(&holds).unwrap();
    assert_eq!(holds.div(&fails).unwrap(), none);
}

#[test]
fn large_polynomials_multiply_and_too_large_ones_are_refused() {
    let factor = add(&var("x"), &int(1));
    let product = (0..200).fold(int(1), |all, _| mul(&all, &factor));
    assert_eq!(product, factor.power(&int(200)).unwrap());
    assert!(factor.power(&int(100_000)).is_err());
    let half = add(&var("x"), &frac(1, 2));
    let product = (0..20).fold(int(1), |all, _| mul(&all, &half));
    assert_eq!(product, half.power(&int(20)).unwrap());
}
