//! Forged proofs, written as their files are: each would prove something false, and is turned away.

use std::collections::{BTreeMap, BTreeSet};

use pars::kernel::{Reason, Theory, Thm, check};
use pars::law::Connective;
use pars::lower::Environment;
use pars::name::Name;
use pars::proof::{Lemma, Moving, Proof, Statement, Step};
use pars::substitution::Substitution;
use pars::term::Term;
use pars::value::Value;

mod texts;

/// Declarations, in which texts are read.
struct Texts(Environment);

fn under(declarations: &str) -> Texts {
    Texts(texts::declared(declarations))
}

impl Texts {
    fn term(&self, text: &str) -> Term {
        texts::term(&self.0, text)
    }

    fn value(&self, text: &str) -> Value {
        texts::value(&self.0, text)
    }

    fn claim(&self, left: &str, right: &str, when: &[&str]) -> Statement {
        let hypotheses = when.iter().map(|text| texts::condition(&self.0, text));
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

const MOVING: &str = "param k, m >= 0, c > 0, c < 1\nobserver See(x)\n\
    proc A_x = (Delay_1 # See_x) ; A_{x/2+1}\nproc N_x = (Delay_1 # See_1) ; N_{x+1}\n\
    proc Z_x = Delay_x ; Z_{x/2}\nproc D_x = (Delay_1 # See_{1/(x-1)}) ; D_{x/2}\nproc B = In_a<y> ; B\n";

/// `A(x) ~~ P(x) ; A(f(x))` for every x that is supposed so, and turns from it.
struct Turns<'t> {
    process: &'t str,
    turn: &'t str,
    when: &'t [&'t str],
    connective: Connective,
    moving: Vec<(&'t str, &'t str, &'t str, &'t str)>,
}

impl Turns<'_> {
    /// What is then said of the process as it starts.
    fn check(&self, start: &str, run: &str) -> Result<Thm, Reason> {
        let texts = under(MOVING);
        let mut map = BTreeMap::new();
        let moving: Vec<Moving> = self
            .moving
            .iter()
            .map(|(variable, name, start, next)| {
                let (variable, name) = (Name::new(variable), Name::new(name));
                map.insert(variable.clone(), texts.value(next));
                Moving { variable, name, start: texts.value(start), next: texts.value(next) }
            })
            .collect();
        let (left, turn) = (texts.term(self.process), texts.term(self.turn));
        let next = pars::substitution::substitute_values(&left, &map).expect("a turn later");
        let right = Term::seq([turn.clone(), next]);
        let mut one = texts.claim("Stop", "Stop", self.when);
        one = Statement { left: left.clone(), connective: self.connective, right: right.clone(), ..one };
        let trust = Step::Trust(left, self.connective, right, "for the test".into());
        let connective = self.connective.join(Connective::Weak);
        let claim = Statement { connective, ..texts.claim(start, run, &[]) };
        texts.check(vec![(one, vec![trust])], claim, vec![Step::Turns { lemma: 0, turn, moving }])
    }
}

#[test]
fn turns_move_on_within_what_is_supposed_of_them() {
    let within = ["?n >= 0", "?n <= 2"];
    let mut turns = Turns {
        process: "A_?n",
        turn: "Delay_1 # See_?n",
        when: &within,
        connective: Connective::Weak,
        moving: vec![("?n", "w", "0", "?n/2+1")],
    };
    let run = "Set_0<w> ; loop((Delay_1 # See_w) ; Set_{w/2+1}<w>)";
    assert!(turns.check("A_0", run).is_ok(), "{:?}", turns.check("A_0", run));
    assert!(turns.check("A_0", "loop(Delay_1 # See_0)").is_err());
    assert!(turns.check("A_1", run).is_err());
    // It must hold of the start, and go on to hold.
    turns.moving = vec![("?n", "w", "3", "?n/2+1")];
    assert!(matches!(turns.check("A_3", run), Err(Reason::Condition(_))));
    turns.moving = vec![("?n", "w", "k", "?n/2+1")];
    assert!(matches!(turns.check("A_k", run), Err(Reason::Condition(_))));
    turns.moving = vec![("?n", "w", "0", "?n/2+2")];
    assert!(matches!(turns.check("A_0", run), Err(Reason::Condition(_))), "it leaves the interval");
    let never = ["?n >= 1", "?n <= 0"];
    turns.moving = vec![("?n", "w", "0", "?n/2+1")];
    turns.when = &never;
    assert!(matches!(turns.check("A_0", run), Err(Reason::Condition(_))), "of no value at all");
    turns.when = &within;
    // A refinement stays one.
    turns.connective = Connective::WeaklyRefines;
    assert!(turns.check("A_0", run).is_ok());
    // What is said of the process is another thing than what is claimed to follow.
    turns.turn = "Delay_1";
    assert!(turns.check("A_0", "loop(Delay_1)").is_ok());
    assert!(turns.check("A_0", "loop(Delay_2)").is_err());
}

#[test]
fn a_turn_lasts_as_long_as_every_other_and_does_nothing_else() {
    let turn = |turn, process, next| Turns {
        process,
        turn,
        when: &["?n >= 0"],
        connective: Connective::Weak,
        moving: vec![("?n", "w", "1", next)],
    };
    // Ever shorter turns would end within a time.
    let found = turn("Delay_?n", "Z_?n", "?n/2").check("Z_1", "Set_1<w> ; loop(Delay_w ; Set_{w/2}<w>)");
    assert!(matches!(found, Err(Reason::Untimed(_))), "{found:?}");
    let more = turn("Delay_{?n+1}", "Z_?n", "?n/2").check("Z_1", "Set_1<w> ; loop(Delay_{w+1} ; Set_{w/2}<w>)");
    assert!(matches!(more, Err(Reason::Untimed(_))), "{more:?}");
    for bad in ["Stop", "Delay_0", "Delay_m", "Delay_1 ; Abort", "Delay_1 ; In_a<y>", "Delay_1 ; Set_1<y>", "Idle"] {
        let found = turn(bad, "N_?n", "?n+1").check("N_1", &format!("loop({bad})"));
        assert!(matches!(found, Err(Reason::Untimed(_))), "{bad}: {found:?}");
    }
    for bad in ["Gte_{?n,0} ; Delay_1 ; Neq_{?n,3}", "Ran_{Normal(0, sd: 1)}<y> ; Delay_1", "Delay_1 ; new a. B"] {
        let found = turn(bad, "N_?n", "?n+1").check("N_1", &format!("loop({bad})"));
        assert!(matches!(found, Err(Reason::Untimed(_))), "{bad}: {found:?}");
    }
}

#[test]
fn what_moves_on_has_a_name_of_its_own_and_a_value() {
    let turns = |name, start, next| {
        let moving = vec![("?n", name, start, next)];
        let (process, turn) = ("N_?n", "Delay_1 # See_{?n+k}");
        let turns = Turns { process, turn, when: &["?n >= 0"], connective: Connective::Weak, moving };
        turns.check(
            &format!("N_{{{start}}}"),
            &format!(
                "Set_{{{start}}}<{name}> ; loop((Delay_1 # See_{{{name}+k}}) ; Set_{{{}}}<{name}>)",
                next.replace("?n", name)
            ),
        )
    };
    assert!(turns("w", "1", "?n+1").is_ok(), "{:?}", turns("w", "1", "?n+1"));
    assert!(turns("w", "c", "?n+c").is_ok());
    // The turn reads it, something is assumed of it, a definition reads or binds it.
    for name in ["k", "m", "c", "x", "y"] {
        let found = turns(name, "1", "?n+1");
        assert!(matches!(found, Err(Reason::Name(_))), "{name}: {found:?}");
    }
    assert!(matches!(turns("w", "1", "?n+w*w"), Err(Reason::Name(_) | Reason::Condition(_))));
    assert!(matches!(turns("w", "1", "?n+1/k^2"), Err(Reason::Undefined(_) | Reason::Condition(_))));
    assert!(matches!(turns("w", "abs(1/k)", "?n+1"), Err(Reason::Undefined(_) | Reason::Condition(_))));
    // Where a turn divides by what moves on, that must never be 0.
    let divides = Turns {
        process: "D_?n",
        turn: "Delay_1 # See_{1/(?n-1)}",
        when: &["?n >= 0"],
        connective: Connective::Weak,
        moving: vec![("?n", "w", "2", "?n/2")],
    };
    undefined(divides.check("D_2", "Set_2<w> ; loop((Delay_1 # See_{1/(w-1)}) ; Set_{w/2}<w>)"));
    // Two that move at once, and two that are one.
    let two = |names: [&str; 2], variables: [&str; 2], next: &str| {
        let turns = Turns {
            process: "N_?n | N_?nn",
            turn: "Delay_1 # See_?n # See_{2*?nn}",
            when: &["?n >= 0", "?nn >= 0"],
            connective: Connective::Weak,
            moving: vec![(variables[0], names[0], "1", next), (variables[1], names[1], "2", "?n+?nn")],
        };
        let run = "Set_1<v> ; Set_2<w> ; loop((Delay_1 # See_v # See_{2*w}) ; Set_w<v1> ; Set_{v+w}<w1> ; Set_v1<v> ; Set_w1<w>)";
        turns.check("N_1 | N_2", run)
    };
    assert!(two(["v", "w"], ["?n", "?nn"], "?nn").is_ok(), "{:?}", two(["v", "w"], ["?n", "?nn"], "?nn"));
    assert!(two(["v", "w"], ["?n", "?nn"], "?n").is_err());
    assert!(matches!(two(["v", "v"], ["?n", "?nn"], "?nn"), Err(Reason::Name(_))));
    assert!(matches!(two(["v", "v1"], ["?n", "?nn"], "?nn"), Err(Reason::Name(_))));
    assert!(two(["v", "w"], ["?n", "?n"], "?nn").is_err());
}

/// `(-1)^(2*p)` is 1 for natural numbers p, and -1 for 1/2: neither an instance of a lemma nor rounds may lose it. One of
/// these proves `Stop = Abort`.
#[test]
fn no_power_of_minus_one_is_lost() {
    for text in [include_str!("proofs/power_of_minus_one.json"), include_str!("proofs/power_in_rounds.json")] {
        let rejected = pars::proof_file::check_file(text.as_bytes()).expect_err("a falsehood");
        assert!(rejected.to_string().contains("2*"), "{rejected}");
        assert!(rejected.to_string().contains("need not be a natural number"), "{rejected}");
    }
}

/// A result called like a declared value would be read by a process that reads the declared one: scripts keep the two
/// apart, so a proof file that does not says something else than it seems to.
#[test]
fn no_result_is_called_like_a_declared_value() {
    let text = include_str!("proofs/declared_and_bound.json");
    let rejected = pars::proof_file::check_file(text.as_bytes()).expect_err("a falsehood, as read");
    assert!(rejected.to_string().contains("binds e, which is declared as a value"), "{rejected}");
}

#[test]
fn two_cases_are_all_there_are() {
    let texts = under("param k, m, k >= m\nparam a >= 0\n");
    let when = |text: &str| texts::condition(&texts.0, text);
    let by_cases = |condition: &str| vec![Step::Cases { when: when(condition), holds: 0, fails: 1 }];
    let lemma = |left: &str, right: &str, condition: &str| {
        (texts.claim(left, right, &[condition]), vec![texts.equal(left, right)])
    };
    let sum = "Out_{c,max(k,0)+min(k,0)}";
    let lemmas = vec![lemma(sum, "Out_{c,k}", "k > 0"), lemma(sum, "Out_{c,k}", "k <= 0")];
    assert!(texts.check(lemmas.clone(), texts.claim(sum, "Out_{c,k}", &[]), by_cases("k > 0")).is_ok());
    assert!(texts.check(lemmas, texts.claim(sum, "Out_{c,k}", &[]), by_cases("k > m")).is_err(), "another condition");
    // At 0 it is false, and of 0 neither lemma speaks.
    let odd = "Out_{c,if k = 0 then 5 else 7}";
    let both = |one: &str, other: &str| vec![lemma(odd, "Out_{c,7}", one), lemma(odd, "Out_{c,7}", other)];
    let claim = || texts.claim(odd, "Out_{c,7}", &[]);
    let unmet = |found: Result<Thm, Reason>| assert!(matches!(found, Err(Reason::Condition(_))), "{found:?}");
    unmet(texts.check(both("k > 0", "k < 0"), claim(), by_cases("k > 0")));
    unmet(texts.check(both("k > 0", "k < 0"), claim(), by_cases("k >= 0")));
    unmet(texts.check(both("k > 0", "k > 0"), claim(), by_cases("k > 0")));
    unmet(texts.check(both("k < 0", "k > 0"), claim(), by_cases("k > 0")));
    // The lemmas must say the same.
    let apart = vec![lemma(odd, "Out_{c,7}", "k > 0"), lemma("Out_{c,k}", "Out_{c,k}", "k <= 0")];
    assert!(matches!(texts.check(apart, claim(), by_cases("k > 0")), Err(Reason::Differ(..))));
    // What is compared has a value, is a number, and means the same everywhere.
    let same = |condition: &str| {
        let step = Step::Reflexive(texts.term("Out_{c,1}"));
        (texts.claim("Out_{c,1}", "Out_{c,1}", &[condition]), vec![step])
    };
    let plain = || texts.claim("Out_{c,1}", "Out_{c,1}", &[]);
    let whole = |one: &str, other: &str| texts.check(vec![same(one), same(other)], plain(), by_cases(one));
    assert!(whole("a > 2", "a <= 2").is_ok());
    undefined(whole("1/a > 2", "1/a <= 2"));
    assert!(matches!(whole("x > 2", "x <= 2"), Err(Reason::Unspoken(name)) if name == Name::new("x")));
    let one = texts.check(vec![same("a > 2")], plain(), by_cases("a > 2"));
    assert!(matches!(one, Err(Reason::NotEarlier(1))), "{one:?}");
}

#[test]
fn anything_follows_only_where_what_is_supposed_excludes_itself() {
    let texts = under("param k, m\n");
    let excluded = |conditions: &[&str]| {
        let step = Step::Excluded(texts.term("Out_{c,1}"), texts.term("Abort"));
        texts.check(Vec::new(), texts.claim("Out_{c,1}", "Abort", conditions), vec![step])
    };
    assert!(excluded(&["k > 0", "k < 0"]).is_ok() && excluded(&["min(k,3) = 3", "k < 2"]).is_ok());
    for possible in [&[][..], &["k > 0"], &["k >= 0", "k <= 0"], &["k > 0", "m < 0"], &["min(k,3) = 3", "k < 4"]] {
        let found = excluded(possible);
        assert!(matches!(found, Err(Reason::Possible)), "{possible:?}: {found:?}");
    }
}
