//! Forged proofs, written as their files are: each would prove something false, and is turned away.

use std::collections::{BTreeMap, BTreeSet};

use pars::kernel::{Reason, Theory, Thm, check};
use pars::law::Connective;
use pars::library;
use pars::lower::Environment;
use pars::name::Name;
use pars::parser::{parse, parse_condition, parse_term, parse_value};
use pars::proof::{Lemma, Proof, Statement, Step};
use pars::substitution::Substitution;
use pars::term::Term;
use pars::value::Value;

/// Declarations, in which texts are read.
struct Texts(Environment);

fn under(declarations: &str) -> Texts {
    let mut environment = library::standard().expect("the library");
    let parsed = parse(declarations);
    assert!(parsed.diagnostics.is_empty(), "{declarations}\n{:?}", parsed.diagnostics);
    for outcome in environment.declare(&parsed.items, declarations) {
        outcome.unwrap_or_else(|wrong| panic!("{declarations}\n{wrong:?}"));
    }
    Texts(environment)
}

impl Texts {
    fn term(&self, text: &str) -> Term {
        let written = parse_term(text).unwrap_or_else(|wrong| panic!("{text}: {wrong:?}"));
        self.0.part(&written).unwrap_or_else(|wrong| panic!("{text}: {wrong:?}"))
    }

    fn value(&self, text: &str) -> Value {
        self.0.value(&parse_value(text).expect("a value")).unwrap_or_else(|wrong| panic!("{text}: {wrong:?}"))
    }

    fn claim(&self, left: &str, right: &str, when: &[&str]) -> Statement {
        let hypotheses = when.iter().map(|text| {
            let written = parse_condition(text).unwrap_or_else(|wrong| panic!("{text}: {wrong:?}"));
            self.0.condition(&written).unwrap_or_else(|wrong| panic!("{text}: {wrong:?}"))
        });
        Statement {
            hypotheses: hypotheses.collect(),
            left: self.term(left),
            connective: Connective::Equal,
            right: self.term(right),
        }
    }

    /// `?P: term`, `?x = value`, `?y <name>`
    fn with(&self, parts: &[&str]) -> Substitution {
        let mut found = Substitution::default();
        for part in parts {
            if let Some((meta, term)) = part.split_once(": ") {
                found.processes.insert(Name::new(meta), self.term(term));
            } else if let Some((meta, value)) = part.split_once(" = ") {
                found.values.insert(Name::new(meta), self.value(value));
            } else if let Some((meta, name)) = part.split_once(' ') {
                found.names.insert(Name::new(meta), Name::new(name.trim_matches(['<', '>'])));
            }
        }
        found
    }

    fn law(&self, name: &str, parts: &[&str]) -> Step {
        Step::Law(Name::new(name), self.with(parts))
    }

    fn equal(&self, left: &str, right: &str) -> Step {
        Step::Arithmetic(self.term(left), self.term(right))
    }

    fn check(&self, lemmas: Vec<(Statement, Vec<Step>)>, claim: Statement, steps: Vec<Step>) -> Result<Thm, Reason> {
        let theory = Theory {
            assumptions: self.0.assumptions.clone(),
            definitions: self.0.definitions.clone(),
            laws: self.0.laws.clone(),
        };
        let named = |(number, (statement, steps)): (usize, (Statement, Vec<Step>))| Lemma {
            name: Name::new(&format!("lemma{number}")),
            statement,
            steps,
        };
        let lemmas = lemmas.into_iter().enumerate().map(named).collect();
        check(&theory, &Proof { lemmas, statement: claim, steps }).map_err(|rejected| rejected.reason)
    }
}

/// A step used in a context.
fn around(texts: &Texts, context: &str, step: usize) -> Step {
    let holes = BTreeMap::from([(Name::new("?X"), Term::meta(&pars::proof::hole(1)))]);
    Step::Congruence(pars::scope::fill(&texts.term(context), &holes), vec![step])
}

#[track_caller]
fn name_refused(found: Result<Thm, Reason>, name: &str) {
    match found {
        Err(Reason::Name(caught)) if caught == Name::new(name) => {}
        Err(Reason::Lemma(_, inner)) if *inner == Reason::Name(Name::new(name)) => {}
        other => panic!("{other:?}"),
    }
}

#[track_caller]
fn undefined(found: Result<Thm, Reason>) {
    let reason = found.expect_err("a forged proof was accepted");
    let inner = if let Reason::Lemma(_, inner) = &reason { inner } else { &reason };
    assert!(matches!(inner, Reason::Undefined(_) | Reason::Stuck(_)), "{reason:?}");
}

#[test]
fn a_value_that_comes_in_is_caught_by_no_binding() {
    // T at z writes z as it was; the body at ?x, with z for ?x, would write what is read.
    let texts = under("proc T_a = In_c<z> ; Out_{d,a}\n");
    let unfold = Step::Unfold(texts.term("T_?x"));
    let body = |value: &str| format!("In_c<z> ; Out_{{d,{value}}}");
    let steps = |value: &str| vec![unfold.clone(), Step::Instance(0, texts.with(&[&format!("?x = {value}")]))];
    assert!(texts.check(vec![], texts.claim("T_{w+1}", &body("w+1"), &[]), steps("w+1")).is_ok());
    name_refused(texts.check(vec![], texts.claim("T_z", &body("z"), &[]), steps("z")), "z");
    let lemma = (texts.claim("T_?x", &body("?x"), &[]), vec![unfold.clone()]);
    let with = |value: &str| vec![Step::Lemma(0, texts.with(&[&format!("?x = {value}")]))];
    assert!(texts.check(vec![lemma.clone()], texts.claim("T_2", &body("2"), &[]), with("2")).is_ok());
    name_refused(texts.check(vec![lemma], texts.claim("T_z", &body("z"), &[]), with("z")), "z");
    // A process that is put in binds as well.
    let steps = vec![
        Step::Reflexive(texts.term("?P ; Out_{c,?x}")),
        Step::Instance(0, texts.with(&["?P: Set_1<z>", "?x = z"])),
    ];
    let same = "Set_1<z> ; Out_{c,z}";
    name_refused(texts.check(vec![], texts.claim(same, same, &[]), steps), "z");
}

#[test]
fn names_that_come_in_are_no_others() {
    let texts = under("");
    let sides = |name: &str, read: &str| format!("Set_1<{name}> ; Out_{{c,{read}}} ; Set_2<z>");
    let steps = |name: &str| {
        vec![
            texts.law("set-forward", &["?P: Out_{c,?y} ; Set_2<z>", "?x = 1", "?y ?y"]),
            Step::Instance(0, texts.with(&[&format!("?y {name}")])),
        ]
    };
    assert!(texts.check(vec![], texts.claim(&sides("w", "w"), &sides("w", "1"), &[]), steps("w")).is_ok());
    name_refused(texts.check(vec![], texts.claim(&sides("z", "z"), &sides("z", "1"), &[]), steps("z")), "z");
    let two =
        vec![Step::Reflexive(texts.term("Set_1<?y> ; Set_2<?z>")), Step::Instance(0, texts.with(&["?y w", "?z w"]))];
    let same = "Set_1<w> ; Set_2<w>";
    name_refused(texts.check(vec![], texts.claim(same, same, &[]), two), "w");
}

#[test]
fn a_metavariable_may_be_the_name_that_is_bound_next() {
    let texts = under("");
    for (first, second) in [("?y", "z"), ("z", "?y")] {
        let process = format!("?P: Set_2<{second}> ; Out_{{c,{first}}}");
        let steps = vec![texts.law("set-forward", &[&process, "?x = 1", &format!("?y {first}")])];
        let side = |read: &str| format!("Set_1<{first}> ; Set_2<{second}> ; Out_{{c,{read}}}");
        let found = texts.check(vec![], texts.claim(&side(first), &side("1"), &[]), steps);
        assert!(matches!(found, Err(Reason::Stuck(_))), "{found:?}");
    }
}

#[test]
fn a_replacement_binds() {
    let texts = under("param y > 0\n");
    let steps = vec![texts.law("gtr-true", &["?x = y", "?y = 0"]), around(&texts, "?X[y := 0-1]", 0)];
    let claim = texts.claim("Gtr_{y,0}[y := 0-1]", "Stop[y := 0-1]", &[]);
    name_refused(texts.check(vec![], claim, steps), "y");
}

#[test]
fn what_is_supposed_of_a_process_is_supposed_where_its_names_mean_what_they_do() {
    let texts = under("");
    let steps = vec![texts.law("disable-abort", &["?P: Delay_{x*x}"]), around(&texts, "Set_0<x> ; ?X", 0)];
    let sides = ("Set_0<x> ; (Delay_{x*x} # Abort)", "Set_0<x> ; Abort");
    name_refused(texts.check(vec![], texts.claim(sides.0, sides.1, &["not_stopped(Delay_{x*x})"]), steps), "x");
    let parts = ["?P: ?P", "?Q: ?Q", "?R: Delay_{x*x}", "?S: ?S", "?t = x*x"];
    let steps = vec![texts.law("par-step", &parts), around(&texts, "Set_2<x> ; ?X", 0)];
    let left = "Set_2<x> ; ((?P ; ?Q) | (Delay_{x*x} ; ?S))";
    let claim = texts.claim(left, "Set_2<x> ; (?P | Delay_{x*x}) ; (?Q | ?S)", &["lasts(?P, x*x)"]);
    name_refused(texts.check(vec![], claim, steps), "x");
}

#[test]
fn what_a_called_process_reads_is_no_index_and_no_parameter() {
    let texts = under("param k\nproc A = Out_{c,k}\nproc T_k = A ; Out_{c,k}\n");
    for process in ["A^{k<2}", "T_5", "A"] {
        let steps = vec![texts.law("set-late", &[&format!("?P: {process}"), "?x = 0", "?y k"])];
        let claim = texts.claim(&format!("Set_0<k> ; {process}"), &format!("{process} ; Set_0<k>"), &[]);
        let found = texts.check(vec![], claim, steps);
        assert!(matches!(found, Err(Reason::Condition(_))), "{process}: {found:?}");
    }
}

#[test]
fn nothing_is_chained_through_a_value_that_need_not_exist() {
    let texts = under("param k\nparam m >= 0\nproc T_x = Out_{c,k/x}\n");
    // k is not sqrt(k)*sqrt(k) where it is negative.
    let root = |of: &str| {
        let square = format!("sqrt({of})*sqrt({of})");
        let steps = vec![
            texts.equal(&format!("Gte_{{{of},0}}"), &format!("Gte_{{{square},0}}")),
            texts.law("gte-true", &[&format!("?x = {square}"), "?y = 0"]),
            Step::Transitive(vec![0, 1]),
        ];
        texts.check(vec![], texts.claim(&format!("Gte_{{{of},0}}"), "Stop", &[]), steps)
    };
    assert!(root("m").is_ok());
    undefined(root("k"));
    // ?x*k is 0 where k is, but not with 1/k for ?x.
    let claim = || texts.claim("Out_{c,1}", "Out_{c,0}", &["?k = 0"]);
    let steps = vec![texts.equal("Out_{c,?x*?k}", "Out_{c,0}"), Step::Instance(0, texts.with(&["?x = 1/?k"]))];
    undefined(texts.check(vec![], claim(), steps));
    // ?a/?b is 1 where they are equal and 0 where ?a is, but not where both are 0.
    let lemma = |value: &str, when: &str| {
        let of = format!("Out_{{c,{value}}}");
        (texts.claim("Out_{c,?k/?m}", &of, &[when]), vec![texts.equal("Out_{c,?k/?m}", &of)])
    };
    let with = texts.with(&["?k = ?a", "?m = ?b"]);
    let steps =
        vec![Step::Lemma(0, with.clone()), Step::Symmetric(0), Step::Lemma(1, with), Step::Transitive(vec![1, 2])];
    let both = texts.claim("Out_{c,1}", "Out_{c,0}", &["?a = 0", "?b = 0"]);
    undefined(texts.check(vec![lemma("1", "?k = ?m"), lemma("0", "?k = 0")], both, steps));
    // The same where a process hides the division.
    let hidden = (
        texts.claim("T_?x", "Out_{c,0}", &["k = 0"]),
        vec![Step::Unfold(texts.term("T_?x")), texts.equal("Out_{c,k/?x}", "Out_{c,0}"), Step::Transitive(vec![0, 1])],
    );
    let steps = vec![
        Step::Unfold(texts.term("T_k")),
        Step::Symmetric(0),
        Step::Lemma(0, texts.with(&["?x = k"])),
        Step::Transitive(vec![1, 2]),
    ];
    undefined(texts.check(vec![hidden.clone()], texts.claim("Out_{c,1}", "Out_{c,0}", &["k = 0"]), steps));
    let at_k = vec![Step::Lemma(0, texts.with(&["?x = k"]))];
    undefined(texts.check(vec![hidden.clone()], texts.claim("T_k", "Out_{c,0}", &["k = 0"]), at_k));
    let at_two = vec![Step::Lemma(0, texts.with(&["?x = 2"]))];
    assert!(texts.check(vec![hidden], texts.claim("T_2", "Out_{c,0}", &["k = 0"]), at_two).is_ok());
}

#[test]
fn an_exponent_is_a_natural_number() {
    let texts = under("param n : natural\n");
    let steps = |value: &str| {
        vec![
            texts.law("gte-true", &["?x = 2^?k", "?y = 1"]),
            Step::Instance(0, texts.with(&[&format!("?k = {value}")])),
        ]
    };
    undefined(texts.check(vec![], texts.claim("Gte_{1/2,1}", "Stop", &[]), steps("0-1")));
    let counted = "(Out_{c,2^i})^{i<1}";
    let steps = vec![
        texts.law("gte-true", &["?x = 2^i", "?y = 1"]),
        around(&texts, &format!("{counted} ; Set_{{0-1}}<i> ; ?X"), 0),
    ];
    let bound = format!("{counted} ; Set_{{0-1}}<i>");
    let claim = texts.claim(&format!("{bound} ; Gte_{{2^i,1}}"), &format!("{bound} ; Stop"), &[]);
    assert!(texts.check(vec![], claim, steps).is_err(), "an index of rounds is bound by something else");
    let power = vec![texts.law("gte-true", &["?x = 2^n", "?y = 1"])];
    assert!(texts.check(vec![], texts.claim("Gte_{2^n,1}", "Stop", &[]), power).is_ok());
}

#[test]
fn what_is_put_in_does_not_cancel_what_need_not_exist() {
    let texts = under("param k\nparam t > 0\n");
    let step = |value: &str| {
        let process = format!("?P: Out_{{c,y*{value}}}");
        texts.law("set-forward", &[&process, &format!("?x = 1/{value}"), "?y y"])
    };
    let sides = |value: &str| {
        (format!("Set_{{1/{value}}}<y> ; Out_{{c,y*{value}}}"), format!("Set_{{1/{value}}}<y> ; Out_{{c,1}}"))
    };
    let check = |value: &str| {
        let (left, right) = sides(value);
        texts.check(vec![], texts.claim(&left, &right, &[]), vec![step(value)])
    };
    assert!(check("t").is_ok());
    undefined(check("k"));
    let empty: BTreeSet<Name> = BTreeSet::new();
    assert_eq!(check("t").map(|theorem| theorem.lemmas().clone()), Ok(empty));
}
