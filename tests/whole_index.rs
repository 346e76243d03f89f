//! What is said of one round of many, on the way of a proof, is said of a natural number: `1/(3*i-17)` has a value in each
//! round, though not for each i.

use std::collections::BTreeMap;

use pars::kernel::{Reason, Thm, check};
use pars::law::Connective;
use pars::lower::Environment;
use pars::name::Name;
use pars::proof::{Lemma, Proof, Statement, Step};
use pars::substitution::Substitution;

mod texts;

fn declared() -> Environment {
    texts::declared("param i, k\nobserver A(x), B(x)")
}

/// A claim that says of a process that it is itself, after these steps.
fn claimed(environment: &Environment, claim: &str, mut steps: Vec<Step>) -> Result<Thm, Reason> {
    let side = texts::term(environment, claim);
    let statement =
        Statement { hypotheses: Vec::new(), left: side.clone(), connective: Connective::Equal, right: side.clone() };
    steps.push(Step::Reflexive(side));
    check(&texts::theory(environment), &Proof { lemmas: Vec::new(), statement, steps })
        .map_err(|rejected| rejected.reason)
}

fn itself(environment: &Environment, text: &str) -> Step {
    Step::Reflexive(texts::term(environment, text))
}

#[test]
fn an_index_that_the_claim_does_not_read_is_natural() {
    let environment = declared();
    let one = || vec![itself(&environment, "A_{1/(3*i-17)}")];
    for claim in ["A_1", "(B_i)^{i<6}"] {
        assert!(claimed(&environment, claim, one()).is_ok(), "{claim}");
    }
    for claim in ["A_i", "A_i ; (B_i)^{i<6}", "(B_i)^{k<i}"] {
        let found = claimed(&environment, claim, one());
        assert!(matches!(found, Err(Reason::Undefined(_))), "{claim}: {found:?}");
    }
    // For i = 6 it has none.
    let sixth = vec![itself(&environment, "A_{1/(3*i-18)}")];
    assert!(matches!(claimed(&environment, "A_1", sixth), Err(Reason::Undefined(_))));
}

#[test]
fn nothing_else_binds_it_or_is_put_in_for_it() {
    let environment = declared();
    let steps = vec![itself(&environment, "A_{1/(3*i-17)}"), itself(&environment, "In_p<i> ; A_i")];
    assert!(matches!(claimed(&environment, "A_1", steps), Err(Reason::Name(name)) if name == Name::new("i")));

    let at = |text: &str| {
        let values = BTreeMap::from([(Name::new("?i"), texts::value(&environment, text))]);
        Step::Instance(0, Substitution { values, ..Substitution::default() })
    };
    let meta = || itself(&environment, "A_{1/(3*?i-17)}");
    assert!(claimed(&environment, "A_1", vec![meta(), at("5")]).is_ok());
    for other in ["1/2", "k", "17/3"] {
        let found = claimed(&environment, "A_1", vec![meta(), at(other)]);
        assert!(matches!(found, Err(Reason::Undefined(_))), "{other}: {found:?}");
    }
}

/// Of m nothing is assumed, but the claim reads it; a result that a definition binds means another thing there.
#[test]
fn cases_are_told_apart_by_what_the_claim_reads() {
    let environment = texts::declared("param m\nproc B_w = In_p<y> ; Out_{c,y+w}");
    let of = |name: &str, read: &str| {
        let term = |text: &str| texts::term(&environment, text);
        let side = format!("Out_{{c,max({name},0)+min({name},0)}}");
        let claim = |order: Option<&str>| Statement {
            hypotheses: order
                .map(|order| texts::condition(&environment, &format!("{name} {order}")))
                .into_iter()
                .collect(),
            left: term(&side),
            connective: Connective::Equal,
            right: term(&format!("Out_{{c,{name}}}")),
        };
        let lemma = |order: &str| Lemma {
            name: Name::new(if order == "> 0" { "above" } else { "below" }),
            statement: claim(Some(order)),
            steps: vec![Step::Arithmetic(term(&side), term(&format!("Out_{{c,{name}}}")))],
        };
        let when = texts::condition(&environment, &format!("{read} > 0"));
        let steps = vec![Step::Cases { when, holds: 0, fails: 1 }];
        let proof = Proof { lemmas: ["> 0", "<= 0"].map(lemma).to_vec(), statement: claim(None), steps };
        check(&texts::theory(&environment), &proof).map_err(|rejected| rejected.reason)
    };
    assert!(of("m", "m").is_ok());
    assert!(matches!(of("m", "k"), Err(Reason::Unspoken(name)) if name == Name::new("k")));
    match of("y", "y") {
        Err(Reason::Lemma(_, reason)) => assert_eq!(*reason, Reason::Name(Name::new("y"))),
        other => panic!("{other:?}"),
    }
}

/// What was shown of a metavariable that is natural, or not negative, is not shown of a name that is put in for it: one of
/// these proves `Out_{c,k} = Out_{c,max(k,0)}`.
#[test]
fn another_name_needs_what_the_first_needed() {
    for (text, why) in [
        (include_str!("proofs/renamed_index.json"), "k, an exponent, need not be a natural number"),
        (include_str!("proofs/renamed_root.json"), "k, of which it takes the root, may be negative"),
    ] {
        let rejected = pars::proof_file::check_file(text.as_bytes()).expect_err("a falsehood");
        assert!(rejected.to_string().contains(why), "{rejected}");
    }
}
