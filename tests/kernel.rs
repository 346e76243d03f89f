//! Forged proofs: each is turned away, for the reason that it is wrong.

use std::collections::BTreeMap;

use pars::assumption::Assumptions;
use pars::definition::Definition;
use pars::kernel::{Reason, Rejected, Theory, Thm, check};
use pars::law::{Condition, Connective, Fact, Law};
use pars::name::Name;
use pars::proof::{Lemma, Proof, Statement, Step};
use pars::substitution::Substitution;
use pars::term::{Node, Term};
use pars::value::{Relation, Value};

const WEAKER: Reason = Reason::Weaker(Connective::Refines, Connective::Equal);

fn name(text: &str) -> Name {
    Name::new(text)
}

fn p() -> Term {
    Term::meta(&name("?P"))
}

fn delay(time: i64) -> Term {
    Term::delay(Value::integer(time))
}

fn law(text: &str, left: Term, right: Term, conditions: Vec<Condition>) -> Law {
    Law {
        name: name(text),
        title: String::new(),
        source: String::new(),
        connective: Connective::Equal,
        oriented: false,
        conditions,
        left,
        right,
        examples: Vec::new(),
    }
}

/// Three true laws: `Stop ; P = P`, `P | Stop = P` if P never aborts, `P # O <= P`.
fn theory() -> Theory {
    let mut theory = Theory::default();
    theory.laws.push(law("stop-first", Term::seq([Term::stop(), p()]), p(), vec![]));
    let safe = Condition::Is(Fact::NeverAborts, p());
    theory.laws.push(law("stop-beside", Term::par([Term::stop(), p()]), p(), vec![safe]));
    let observer = Term::meta(&name("?O"));
    let mut forget =
        law("forget", Term::disable([p(), observer.clone()]), p(), vec![Condition::Is(Fact::Observer, observer)]);
    forget.connective = Connective::Refines;
    theory.laws.push(forget);
    theory
}

fn with(process: &str, term: Term) -> Substitution {
    Substitution { processes: BTreeMap::from([(name(process), term)]), ..Substitution::default() }
}

fn claim(left: Term, right: Term) -> Statement {
    Statement { hypotheses: vec![], left, connective: Connective::Equal, right }
}

fn run(theory: &Theory, statement: Statement, steps: Vec<Step>) -> Result<Thm, Rejected> {
    check(theory, &Proof::new(statement, steps))
}

fn reason(theory: &Theory, statement: Statement, steps: Vec<Step>) -> Reason {
    run(theory, statement, steps).expect_err("a forged proof was accepted").reason
}

#[test]
fn a_true_instance_is_a_theorem_and_names_its_law() {
    let steps = vec![Step::Law(name("stop-first"), with("?P", delay(1)))];
    let theorem = run(&theory(), claim(Term::seq([Term::stop(), delay(1)]), delay(1)), steps).unwrap();
    assert_eq!(theorem.laws().iter().map(Name::as_str).collect::<Vec<_>>(), ["stop-first"]);
    assert!(theorem.trusted().is_empty());
}

#[test]
fn false_condition() {
    let steps = vec![Step::Law(name("stop-beside"), with("?P", Term::abort()))];
    let found = reason(&theory(), claim(Term::par([Term::stop(), Term::abort()]), Term::abort()), steps);
    assert!(matches!(found, Reason::Condition(_)), "{found:?}");
}

#[test]
fn undecided_condition() {
    let steps = vec![Step::Law(name("stop-beside"), with("?P", p()))];
    let found = reason(&theory(), claim(Term::par([Term::stop(), p()]), p()), steps);
    assert!(matches!(found, Reason::Condition(_)), "{found:?}");
}

#[test]
fn unknown_law() {
    let found = reason(&theory(), claim(p(), p()), vec![Step::Law(name("miracle"), with("?P", p()))]);
    assert_eq!(found, Reason::UnknownLaw(name("miracle")));
}

#[test]
fn law_without_a_meaning_for_its_metavariable() {
    let found = reason(&theory(), claim(p(), p()), vec![Step::Law(name("stop-first"), Substitution::default())]);
    assert_eq!(found, Reason::Unbound(name("?P")));
}

#[test]
fn broken_chain() {
    let steps = vec![Step::Reflexive(delay(1)), Step::Reflexive(delay(2)), Step::Transitive(vec![0, 1])];
    assert!(matches!(reason(&theory(), claim(delay(1), delay(2)), steps), Reason::Differ(..)));
}

#[test]
fn wrong_conclusion() {
    let steps = vec![Step::Reflexive(delay(1))];
    assert!(matches!(reason(&theory(), claim(delay(1), delay(2)), steps), Reason::Differ(..)));
}

#[test]
fn wrong_head() {
    let law = Step::Law(name("stop-first"), with("?P", delay(1)));
    let shape = Term::par([Term::meta(&name("?1")), delay(7)]);
    let statement = claim(Term::seq([Term::stop(), delay(1), delay(7)]), Term::seq([delay(1), delay(7)]));
    assert!(matches!(reason(&theory(), statement, vec![law, Step::Congruence(shape, vec![0])]), Reason::Differ(..)));
}

#[test]
fn steps_that_come_later_or_never() {
    assert_eq!(reason(&theory(), claim(p(), p()), vec![Step::Symmetric(0)]), Reason::NotEarlier(0));
    assert_eq!(reason(&theory(), claim(p(), p()), vec![Step::Transitive(vec![99])]), Reason::NotEarlier(99));
    assert_eq!(reason(&theory(), claim(p(), p()), vec![]), Reason::Empty);
}

#[test]
fn a_refinement_is_no_equality() {
    let shown = Term::disable([delay(1), Term::new(Node::Observe(name("A"), vec![]))]);
    let mut substitution = with("?P", delay(1));
    substitution.processes.insert(name("?O"), Term::new(Node::Observe(name("A"), vec![])));
    let step = Step::Law(name("forget"), substitution);
    assert_eq!(reason(&theory(), claim(shown.clone(), delay(1)), vec![step.clone()]), WEAKER);
    assert_eq!(reason(&theory(), claim(delay(1), shown), vec![step, Step::Symmetric(0)]), WEAKER);
}

#[test]
fn wrong_sort() {
    let vector = Value::vector(vec![Value::integer(1), Value::integer(2)]).unwrap();
    let term = Term::delay(vector);
    assert!(matches!(
        reason(&theory(), claim(term.clone(), term.clone()), vec![Step::Reflexive(term)]),
        Reason::Sort(_)
    ));
    let half = Value::integer(1).div(&Value::integer(2)).unwrap();
    let power = Term::new(Node::Power(delay(1), half, None));
    assert!(matches!(
        reason(&theory(), claim(power.clone(), power.clone()), vec![Step::Reflexive(power)]),
        Reason::Sort(_)
    ));
}

#[test]
fn arithmetic_on_distributions() {
    let normal = Value::distribution("Normal", vec![Value::integer(0), Value::integer(1)]).unwrap();
    assert!(normal.sub(&normal).is_err());
    let time = Term::delay(normal);
    assert!(run(&theory(), claim(time.clone(), time.clone()), vec![Step::Arithmetic(time.clone(), time)]).is_err());
}

#[test]
fn arithmetic_changes_values_only() {
    let steps = vec![Step::Arithmetic(delay(1), Term::stop())];
    assert!(matches!(reason(&theory(), claim(delay(1), Term::stop()), steps), Reason::Differ(..)));
    let steps = vec![Step::Arithmetic(Term::par([delay(1), delay(2)]), Term::disable([delay(1), delay(2)]))];
    let statement = claim(Term::par([delay(1), delay(2)]), Term::disable([delay(1), delay(2)]));
    assert!(matches!(reason(&theory(), statement, steps), Reason::Differ(..)));
}

#[test]
fn a_guard_that_is_no_guard() {
    // X = (Stop ; X) else Stop holds of X = Stop; it must not prove Stop = loop(Stop), let alone of any other X.
    let equation =
        Step::Trust(delay(1), Connective::Equal, Term::attempt(Term::seq([Term::stop(), delay(1)])), "forged".into());
    let steps = vec![equation, Step::UniqueLoop { body: Term::stop(), equation: 0 }];
    let statement = claim(delay(1), Term::new(Node::Loop(Term::stop())));
    assert!(matches!(reason(&theory(), statement, steps), Reason::Unguarded(_)));
}

#[test]
fn unique_solution_of_another_equation() {
    let body = delay(1);
    let forever = Term::new(Node::Loop(delay(1)));
    let equation = Step::Trust(forever.clone(), Connective::Equal, Term::seq([body, forever.clone()]), "forged".into());
    let steps = vec![equation, Step::UniqueLoop { body: delay(2), equation: 0 }];
    let statement = claim(forever, Term::new(Node::Loop(delay(2))));
    assert!(matches!(reason(&theory(), statement, steps), Reason::Differ(..)));
}

#[test]
fn unfolding_what_is_not_defined() {
    let call = Term::new(Node::Call(name("T"), vec![]));
    let found = reason(&theory(), claim(call.clone(), Term::stop()), vec![Step::Unfold(call)]);
    assert!(matches!(found, Reason::NotDefined(_)));
}

#[test]
fn stale_definition() {
    let call = Term::new(Node::Call(name("T"), vec![]));
    let mut theory = theory();
    let define = |body: Term| Definition { name: name("T"), parameters: vec![], body, recursive: false };
    theory.definitions.insert(define(delay(1)));
    let proof = Proof::new(claim(call.clone(), delay(1)), vec![Step::Unfold(call)]);
    assert!(check(&theory, &proof).is_ok());
    theory.definitions.insert(define(delay(2)));
    assert!(check(&theory, &proof).is_err());
}

fn counted(count: Value) -> Term {
    Term::new(Node::Power(delay(1), count, None))
}

fn induction(theory: &Theory, hypotheses: Vec<Condition>, variable: &str) -> Reason {
    let n = Value::variable(&name(variable));
    let left = counted(n.clone());
    let right = Term::delay(n.clone());
    let next = n.add(&Value::integer(1)).unwrap();
    let trust = |l: Term, r: Term| Step::Trust(l, Connective::Equal, r, "forged".into());
    let steps = vec![
        trust(counted(Value::integer(0)), delay(0)),
        trust(counted(next.clone()), Term::delay(next)),
        Step::Induction { variable: name(variable), left: left.clone(), right: right.clone(), base: 0, step: 1 },
    ];
    reason(theory, Statement { hypotheses, ..claim(left, right) }, steps)
}

#[test]
fn induction_away_from_naturals() {
    assert_eq!(induction(&theory(), vec![], "?n"), Reason::NotNatural(name("?n")));
    let bounded = vec![
        Condition::Natural(Value::variable(&name("?n"))),
        Condition::Compare(Relation::Lte, Value::variable(&name("?n")), Value::integer(3)),
    ];
    assert_eq!(induction(&theory(), bounded, "?n"), Reason::NotNatural(name("?n")));
}

#[test]
fn an_induction_hypothesis_stays_inside() {
    let steps = vec![Step::Suppose(delay(1), delay(2))];
    assert!(matches!(reason(&theory(), claim(delay(1), delay(2)), steps), Reason::Hypothesis(..)));
}

#[test]
fn trust_is_shown() {
    let steps = vec![Step::Trust(delay(1), Connective::Equal, delay(2), "somebody said so".into())];
    let theorem = run(&theory(), claim(delay(1), delay(2)), steps).unwrap();
    assert_eq!(theorem.trusted().iter().map(String::as_str).collect::<Vec<_>>(), ["somebody said so"]);
}

#[test]
fn a_parameter_with_assumptions_is_never_bound() {
    let mut assumptions = Assumptions::default();
    assumptions.assume(Relation::Gtr, &Value::variable(&name("t")), &Value::integer(0));
    let theory = Theory { assumptions, ..theory() };
    let term = Term::new(Node::In(name("c"), name("t")));
    let found = reason(&theory, claim(term.clone(), term.clone()), vec![Step::Reflexive(term)]);
    assert_eq!(found, Reason::Name(name("t")));
}

#[test]
fn an_instance_keeps_the_hypotheses() {
    let safe = Condition::Is(Fact::NeverAborts, p());
    let law = Step::Law(name("stop-beside"), with("?P", p()));
    let steps = vec![law, Step::Instance(0, with("?P", Term::abort()))];
    let statement =
        Statement { hypotheses: vec![safe], ..claim(Term::par([Term::stop(), Term::abort()]), Term::abort()) };
    assert_eq!(reason(&theory(), statement, steps), Reason::Name(name("?P")));
}

#[test]
fn an_instance_brings_in_no_index() {
    // `(Delay_?x)^{i<3} = Delay_{3*?x}` for all values; a value that reads i is another in each round.
    let value = |text: &str| Value::variable(&name(text));
    let rounds = |time: &Value| Term::new(Node::Power(Term::delay(time.clone()), Value::integer(3), Some(name("i"))));
    let all = |time: &Value| Term::delay(time.mul(&Value::integer(3)).unwrap());
    let mut theory = theory();
    theory.laws.push(law("thrice", rounds(&value("?x")), all(&value("?x")), vec![]));
    let of = |text: &str| Substitution { values: [(name("?x"), value(text))].into(), ..Substitution::default() };
    let steps = |text: &str| vec![Step::Law(name("thrice"), of("?x")), Step::Instance(0, of(text))];
    assert!(run(&theory, claim(rounds(&value("j")), all(&value("j"))), steps("j")).is_ok());
    let found = reason(&theory, claim(rounds(&value("i")), all(&value("i"))), steps("i"));
    assert_eq!(found, Reason::Name(name("i")));
}

fn lemma(statement: Statement, steps: Vec<Step>) -> Lemma {
    Lemma { name: name("first"), statement, steps }
}

#[test]
fn a_lemma_holds_under_its_own_conditions_alone() {
    let safe = Condition::Is(Fact::NeverAborts, p());
    let beside = |term: Term| Term::par([Term::stop(), term]);
    let statement = Statement { hypotheses: vec![safe.clone()], ..claim(beside(p()), p()) };
    let first = lemma(statement, vec![Step::Law(name("stop-beside"), with("?P", p()))]);
    let use_at = |term: Term| Proof {
        lemmas: vec![first.clone()],
        statement: claim(beside(term.clone()), term.clone()),
        steps: vec![Step::Lemma(0, with("?P", term))],
    };
    let theorem = check(&theory(), &use_at(delay(1))).expect("a delay never aborts");
    assert!(theorem.lemmas().contains(&name("first")) && theorem.laws().contains(&name("stop-beside")));
    let found = check(&theory(), &use_at(Term::abort())).expect_err("Abort aborts").reason;
    assert_eq!(found, Reason::Condition(Box::new(Condition::Is(Fact::NeverAborts, Term::abort()))));
}

#[test]
fn a_lemma_is_proved_and_comes_before_its_use() {
    let steps = vec![Step::Lemma(0, Substitution::default())];
    let statement = claim(delay(1), delay(2));
    let wrong = lemma(statement.clone(), vec![Step::Reflexive(delay(1))]);
    let proof = Proof { lemmas: vec![wrong], statement: statement.clone(), steps: steps.clone() };
    let found = check(&theory(), &proof).expect_err("the lemma is not proved").reason;
    assert!(matches!(found, Reason::Lemma(ref which, _) if *which == name("first")), "{found}");
    let itself = lemma(statement.clone(), steps.clone());
    let proof = Proof { lemmas: vec![itself], statement: statement.clone(), steps: steps.clone() };
    let found = check(&theory(), &proof).expect_err("a lemma may not rest on itself").reason;
    assert_eq!(found, Reason::Lemma(name("first"), Box::new(Reason::NotEarlier(0))));
    assert_eq!(reason(&theory(), statement, steps), Reason::NotEarlier(0));
}

#[test]
fn what_a_definition_writes_is_not_assumed_of() {
    let read = Term::new(Node::In(name("c"), name("t")));
    let body = Term::seq([read, Term::delay(Value::variable(&name("t")))]);
    let mut theory = theory();
    theory.definitions.insert(Definition { name: name("T"), parameters: vec![], body, recursive: false });
    let positive = Condition::Compare(Relation::Gtr, Value::variable(&name("t")), Value::integer(0));
    let statement = Statement { hypotheses: vec![positive], ..claim(delay(1), delay(1)) };
    assert_eq!(reason(&theory, statement, vec![Step::Reflexive(delay(1))]), Reason::Name(name("t")));
}

#[test]
fn an_argument_is_not_read_after_a_call_that_writes_its_name() {
    let define =
        |text: &str, parameters: Vec<Name>, body| Definition { name: name(text), parameters, body, recursive: false };
    let call = |text: &str, arguments| Term::new(Node::Call(name(text), arguments));
    let (y, u) = (Value::variable(&name("y")), Value::variable(&name("u")));
    let mut theory = theory();
    theory.definitions.insert(define("W", vec![], Term::new(Node::Set(Value::integer(60), name("y")))));
    theory.definitions.insert(define("V", vec![name("u")], Term::seq([call("W", vec![]), Term::delay(u)])));
    let right = Term::seq([call("W", vec![]), Term::delay(y.clone())]);
    let left = call("V", vec![y]);
    let found = reason(&theory, claim(left.clone(), right), vec![Step::Unfold(left)]);
    assert!(matches!(found, Reason::Stuck(_)), "{found}");
}

#[test]
fn a_number_of_rounds_is_not_read_from_what_they_write() {
    let z = Value::variable(&name("z"));
    let round = Term::seq([delay(1), Term::new(Node::Set(Value::integer(0), name("z")))]);
    let rounds = Term::new(Node::Power(round, z, None));
    let found = reason(&theory(), claim(rounds.clone(), rounds.clone()), vec![Step::Reflexive(rounds)]);
    assert_eq!(found, Reason::Name(name("z")));
}

#[test]
fn nothing_is_trusted_without_a_reason() {
    // Nothing to be read, and what would hide itself at a terminal.
    for why in [" ", "\u{200b}", "-", "so it is\u{1b}[2K", "so it is\nby seq-stop-right"] {
        let steps = vec![Step::Trust(delay(1), Connective::Equal, delay(2), why.into())];
        assert_eq!(reason(&theory(), claim(delay(1), delay(2)), steps), Reason::Empty, "{why:?}");
    }
}

#[test]
fn deep_proofs_and_huge_terms() {
    let on_a_large_stack = std::thread::Builder::new().stack_size(256 << 20).spawn(|| {
        let mut steps = vec![Step::Reflexive(delay(1))];
        let shape = Term::new(Node::Loop(Term::meta(&name("?1"))));
        for step in 0..2_000 {
            steps.push(Step::Congruence(shape.clone(), vec![step]));
        }
        assert_eq!(reason(&theory(), claim(delay(1), delay(1)), steps), Reason::TooLarge);
        let mut steps = vec![Step::Reflexive(delay(1))];
        let twice = Term::par([Term::meta(&name("?1")), Term::meta(&name("?1"))]);
        for step in 0..64 {
            steps.push(Step::Congruence(twice.clone(), vec![step]));
        }
        assert_eq!(reason(&theory(), claim(delay(1), delay(1)), steps), Reason::TooLarge);
        let long =
            (0..200_000).map(|step| if step == 0 { Step::Reflexive(delay(1)) } else { Step::Symmetric(step - 1) });
        assert!(run(&theory(), claim(delay(1), delay(1)), long.collect()).is_ok());
    });
    on_a_large_stack.unwrap().join().unwrap();
}

#[test]
fn an_index_does_not_escape() {
    let mut theory = theory();
    let meta = |text: &str| Value::variable(&name(text));
    let rounds = Term::new(Node::Power(Term::delay(meta("?t")), meta("?n"), Some(name("?i"))));
    let all = Term::delay(meta("?t").mul(&meta("?n")).unwrap());
    theory.laws.push(law("alike", rounds, all, vec![]));
    let i = Value::variable(&name("i"));
    let substitution = Substitution {
        values: BTreeMap::from([(name("?t"), i.clone()), (name("?n"), Value::integer(3))]),
        names: BTreeMap::from([(name("?i"), name("i"))]),
        ..Substitution::default()
    };
    let left = Term::new(Node::Power(Term::delay(i.clone()), Value::integer(3), Some(name("i"))));
    let right = Term::delay(i.mul(&Value::integer(3)).unwrap());
    let found = reason(&theory, claim(left, right), vec![Step::Law(name("alike"), substitution)]);
    assert_eq!(found, Reason::Name(name("i")));
}

#[test]
fn a_weak_equality_is_no_equality() {
    let weak = |connective| Step::Trust(delay(1), connective, Term::idle(), "for the test".into());
    let stated = |connective| Statement { connective, ..claim(delay(1), Term::idle()) };
    let given = |given, wanted| run(&theory(), stated(wanted), vec![weak(given)]).is_ok();
    use Connective::{Equal, Refines, Weak, WeaklyRefines};
    for (first, second) in [(Weak, Equal), (Weak, Refines), (Refines, Weak), (WeaklyRefines, Weak)] {
        assert!(!given(first, second), "{first} was taken for {second}");
    }
    for (first, second) in [(Equal, Weak), (Weak, WeaklyRefines), (Refines, WeaklyRefines)] {
        assert!(given(first, second), "{first} gives {second}");
    }
    let turned = |connective| vec![weak(connective), Step::Symmetric(0)];
    let back = |connective| Statement { connective, ..claim(Term::idle(), delay(1)) };
    assert!(run(&theory(), back(Weak), turned(Weak)).is_ok());
    assert!(run(&theory(), back(WeaklyRefines), turned(WeaklyRefines)).is_err());
    let both = vec![
        weak(Weak),
        Step::Trust(Term::idle(), Refines, Term::stop(), "for the test".into()),
        Step::Transitive(vec![0, 1]),
    ];
    let ends = |connective| Statement { connective, ..claim(delay(1), Term::stop()) };
    assert!(run(&theory(), ends(Weak), both.clone()).is_err());
    assert!(run(&theory(), ends(WeaklyRefines), both).is_ok());
}

#[test]
fn a_weak_equality_does_not_make_a_solution_unique() {
    // Every livelock solves X ~~ Tau ; X; it must not prove one of them.
    let forever = Term::new(Node::Loop(delay(1)));
    let round = Term::attempt(Term::seq([delay(1), Term::idle()]));
    let steps = vec![
        Step::Trust(Term::idle(), Connective::Weak, round, "forged".into()),
        Step::UniqueLoop { body: delay(1), equation: 0 },
    ];
    let found = reason(&theory(), claim(Term::idle(), forever), steps);
    assert_eq!(found, Reason::Weaker(Connective::Weak, Connective::Equal));
}
