//! What was written, with its places, before names are looked up.

mod criteria;

use std::sync::Arc;

use num_rational::BigRational;

use crate::diagnostic::Span;
use crate::law::{Connective, Fact};
use crate::name::Name;
use crate::preorder::Preorder;
use crate::value::Relation;

pub use criteria::{AxisKind, Clause, ClauseKind, Criteria, Sweep, SweepQuestion};

/// A name where it stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ident {
    /// The name.
    pub name: Name,
    /// Its place.
    pub span: Span,
}

/// One item of a file, or one input at the prompt.
#[derive(Clone, Debug)]
pub struct Item {
    /// From its keyword to its end.
    pub span: Span,
    /// What it is.
    pub kind: ItemKind,
}

/// The items of the language.
#[derive(Clone, Debug)]
pub enum ItemKind {
    /// `param t > 0, p0, n : natural`
    Param(Vec<Parameter>),
    /// `fn s(d) = d / t`; without a body the function is left open
    Function(Header, Option<Value>),
    /// `proc BF_{a,b} = P`
    Process(Header, Term),
    /// `observer At(r)`, or several with commas between
    Observer(Vec<Header>),
    /// `system Sys = P | Q`
    System(Ident, Term),
    /// `property Goal = P`, `property G = P where q > 1`
    Property(Ident, Term, Option<Restriction>),
    /// `prove …`
    Prove(Claim),
    /// `simplify P`, or a term alone at the prompt
    Simplify(Term),
    /// `period Sys`
    Period(Ident),
    /// `flow Sys`
    Flow(Ident),
    /// `solve r(n+1) = 2*r(n), r(0) = 1`
    Solve(Box<Solve>),
    /// `project P to {At}`
    Project(Term, Vec<Ident>),
    /// `lts P`
    Lts(Term, Limits),
    /// `minimise P`
    Minimise(Term, Limits),
    /// `compare P ~ Q weak`
    Alike(Term, Term, Preorder, Limits),
    /// `expect …`
    Expect(Expect),
    /// `import "file"`
    Import(String),
    /// `probability of …`
    Probability(Likelihood),
    /// `law name "title" …`
    Law(Box<LawItem>),
    /// `exercise name "title" …`
    Exercise(Box<ExerciseItem>),
    /// `criteria Name for Sys { … }`
    Criteria(Arc<Criteria>),
    /// `sweep k in 0 .. 1 step 1/10 { … }`
    Sweep(Arc<Sweep>),
}

/// `bound 1000 memory 64`: how much may be built.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Limits {
    /// The most states.
    pub states: Option<usize>,
    /// The most memory, in MiB.
    pub memory: Option<usize>,
}

/// One entry of `param`.
#[derive(Clone, Debug)]
pub enum Parameter {
    /// `p0`
    Plain(Ident),
    /// `n : natural`
    Sorted(Ident, Ident),
    /// `t > 0`
    Assumed(Relation, Value, Value),
}

/// `BF_{a,b}<x>`: a name that is being declared.
#[derive(Clone, Debug)]
pub struct Header {
    /// The name.
    pub name: Ident,
    /// Its parameters.
    pub parameters: Vec<Ident>,
    /// Its results; none when they are not written.
    pub results: Vec<Ident>,
}

/// A claim to be proved.
#[derive(Clone, Debug)]
pub struct Claim {
    /// `name:`
    pub name: Option<Ident>,
    /// What is claimed.
    pub kind: ClaimKind,
}

/// What is claimed.
#[derive(Clone, Debug)]
pub enum ClaimKind {
    /// `P = Q when … by …`, `P <= Q …`
    Compare {
        /// Before the connective.
        left: Term,
        /// `=` or `<=`.
        connective: Connective,
        /// After the connective.
        right: Term,
        /// The hypotheses.
        when: Vec<Condition>,
        /// How to prove it.
        by: By,
    },
    /// `Sys satisfies Goal`
    Satisfies(Ident, Ident),
    /// `Sys always abs(p-o) > 1 when At_p, Rock_o`
    Always {
        /// The system.
        system: Ident,
        /// What must hold.
        conditions: Vec<Comparison>,
        /// Whenever all of these are shown.
        shown: Vec<Term>,
    },
    /// `probability of … >= q`, `Sys satisfies Goal with probability >= q`
    Likely(Likelihood, Relation, Value),
}

/// `a <= b`
#[derive(Clone, Debug)]
pub struct Comparison {
    /// Its place.
    pub span: Span,
    /// How they are compared.
    pub relation: Relation,
    /// The left value.
    pub left: Value,
    /// The right value.
    pub right: Value,
}

/// `a <= b and c < d or e = f`: of which one holds, all of each together.
#[derive(Clone, Debug)]
pub struct Either(pub Vec<Vec<Comparison>>);

impl Either {
    /// All that it compares.
    pub fn comparisons(&self) -> impl Iterator<Item = &Comparison> {
        self.0.iter().flatten()
    }
}

/// What stands behind a property.
#[derive(Clone, Debug)]
pub enum Restriction {
    /// `where P(x <= d) >= q`
    Within(Within),
    /// `where q > 1`: what holds of all that is shown
    Always(Vec<Comparison>),
}

/// `where P(x <= d) >= q` behind a property.
#[derive(Clone, Debug)]
pub struct Within {
    /// Where it stands.
    pub span: Span,
    /// The name of the time.
    pub name: Ident,
    /// The latest time.
    pub time: Value,
    /// How likely it must be.
    pub threshold: (Relation, Value),
}

/// `Sys reaching At_p where abs(p-a) <= e within 10*t by enclosed`
#[derive(Clone, Debug)]
pub struct Likelihood {
    /// Its place.
    pub span: Span,
    /// The system.
    pub system: Ident,
    /// What is asked of it.
    pub event: Event,
    /// The method, where one is named.
    pub method: Option<How>,
}

/// `estimated with 1000000 runs seed 7`
#[derive(Clone, Debug)]
pub struct How {
    /// The name of the method.
    pub name: Ident,
    /// How many runs, where that is said.
    pub runs: Option<Value>,
    /// The seed of their draws, where that is said.
    pub seed: Option<Value>,
}

/// What may happen.
#[derive(Clone, Debug)]
pub enum Event {
    /// `reaching At_p where … within d`, `showing At_p where … at d`
    Shown {
        /// Whether any time up to the given one counts.
        first: bool,
        /// What is shown.
        shown: Vec<Term>,
        /// What must hold of it.
        conditions: Vec<Comparison>,
        /// When.
        time: Value,
    },
    /// `satisfies Goal`
    Satisfies(Ident),
}

/// How a claim is to be proved.
#[derive(Clone, Debug)]
pub enum By {
    /// Nothing was said: search.
    Search,
    /// `by law, law`
    Laws(Vec<Ident>),
    /// `by { P = {law} R = {law} Q }`
    Calc(Term, Vec<CalcStep>),
}

/// `= {law, law} R`
#[derive(Clone, Debug)]
pub struct CalcStep {
    /// The whole step.
    pub span: Span,
    /// `=` or `<=`.
    pub connective: Connective,
    /// The laws to use; all when none is named.
    pub laws: Vec<Ident>,
    /// What is reached.
    pub term: Term,
}

/// What a claim or a simplification is expected to give.
#[derive(Clone, Debug)]
pub enum Expect {
    /// `expect proved`, `refuted`, `open`, `yes`, `no`, `unknown`, `met`, `not met`
    Verdict(Ident),
    /// `expect = P`
    Term(Term),
    /// `expect t1 = 10, n = 100`
    Values(Vec<(Ident, Value)>),
}

/// A recurrence to be solved.
#[derive(Clone, Debug)]
pub struct Solve {
    /// `r(n+1) = 2*r(n)` and `r(0) = 1`, in any order.
    pub equations: Vec<(Value, Value)>,
    /// What is looked for.
    pub find: Option<Find>,
}

/// `find n with r(n) >= 10`
#[derive(Clone, Debug)]
pub struct Find {
    /// The index.
    pub index: Ident,
    /// What is to hold there.
    pub either: Either,
}

/// A law as written in a rule file.
#[derive(Clone, Debug)]
pub struct LawItem {
    /// Its name.
    pub name: Ident,
    /// Its title.
    pub title: String,
    /// `paper …` or `ours …`; empty when it is missing.
    pub source: String,
    /// `when …`
    pub conditions: Vec<Condition>,
    /// The left side.
    pub left: Term,
    /// `=` or `<=`; `=>` is `=` with `oriented`.
    pub connective: Connective,
    /// Whether it was written `=>`.
    pub oriented: bool,
    /// The right side.
    pub right: Term,
    /// `try P = Q` lines.
    pub examples: Vec<(Term, Term)>,
}

/// An exercise: a claim to be shown step by step.
#[derive(Clone, Debug)]
pub struct ExerciseItem {
    /// Its name.
    pub name: Ident,
    /// Its title.
    pub title: String,
    /// What is to be shown.
    pub claim: Claim,
    /// The laws that may be used; all when none is named.
    pub laws: Vec<Ident>,
    /// The steps from the left side of the claim, with their gaps.
    pub steps: Vec<GapStep>,
    /// Hints, to be given one at a time.
    pub hints: Vec<String>,
}

/// `= {law} R`, of which parts are to be filled in.
#[derive(Clone, Debug)]
pub struct GapStep {
    /// The whole step.
    pub span: Span,
    /// `=` or `<=`.
    pub connective: Connective,
    /// The laws; none when they are to be found.
    pub laws: Option<Vec<Ident>>,
    /// What is reached; none when it is to be found.
    pub term: Option<Term>,
}

/// A condition of a law or a hypothesis of a claim.
#[derive(Clone, Debug)]
pub struct Condition {
    /// Its place.
    pub span: Span,
    /// What it says.
    pub kind: ConditionKind,
}

/// The conditions, as in [`crate::law::Condition`].
#[derive(Clone, Debug)]
pub enum ConditionKind {
    /// `a <= b`
    Compare(Relation, Value, Value),
    /// `natural(n)`
    Natural(Value),
    /// `never_aborts(P)` and its like
    Is(Fact, Term),
    /// `lasts(P, t)`
    Lasts(Term, Value),
    /// `complementary(G, H)`
    Complementary(Term, Term),
    /// `no_port(P, c)`
    NoPort(Term, Ident),
    /// `unread(P, y)`
    Unread(Term, Ident),
    /// `apart(P, Q)`
    Apart(Term, Term),
    /// `shows_only(P, {At})`
    ShowsOnly(Term, Vec<Ident>),
    /// `shows_none(P, {At})`
    ShowsNone(Term, Vec<Ident>),
}

/// A process as written.
#[derive(Clone, Debug)]
pub struct Term {
    /// Its place, brackets included.
    pub span: Span,
    /// What it is.
    pub kind: TermKind,
}

impl Term {
    /// This process and all that stand in it.
    pub fn all(&self) -> Vec<&Term> {
        let (mut all, mut rest) = (Vec::new(), vec![self]);
        while let Some(term) = rest.pop() {
            all.push(term);
            match &term.kind {
                TermKind::Seq(parts) | TermKind::Par(parts) | TermKind::Disable(parts) => rest.extend(parts),
                TermKind::Else(first, second) => rest.extend([&**first, &**second]),
                TermKind::Power(body, ..)
                | TermKind::Try(body)
                | TermKind::Loop(body)
                | TermKind::New(_, body)
                | TermKind::Project(body, _)
                | TermKind::Replace(body, ..) => rest.push(body),
                TermKind::Apply { .. } | TermKind::Meta(..) => {}
            }
        }
        all
    }
}

/// The forms of a process.
#[derive(Clone, Debug)]
pub enum TermKind {
    /// `Name_{x,y}<r>`: basic, observed or defined
    Apply {
        /// The name.
        name: Ident,
        /// Its parameters.
        arguments: Vec<Value>,
        /// Its results.
        results: Vec<Ident>,
    },
    /// `?P_{u}`
    Meta(Ident, Vec<Value>),
    /// `P ; Q ; …`
    Seq(Vec<Term>),
    /// `P else Q`
    Else(Box<Term>, Box<Term>),
    /// `P | Q | …`
    Par(Vec<Term>),
    /// `P # Q # …`
    Disable(Vec<Term>),
    /// `P^n`, `P^{i<n}`
    Power(Box<Term>, Value, Option<Ident>),
    /// `try(P)`
    Try(Box<Term>),
    /// `loop(P)`
    Loop(Box<Term>),
    /// `new c. P`
    New(Ident, Box<Term>),
    /// `P to {At}`
    Project(Box<Term>, Vec<Ident>),
    /// `P[y := x]`
    Replace(Box<Term>, Ident, Value),
}

/// A value as written.
#[derive(Clone, Debug)]
pub struct Value {
    /// Its place, brackets included.
    pub span: Span,
    /// What it is.
    pub kind: ValueKind,
}

/// The forms of a value.
#[derive(Clone, Debug)]
pub enum ValueKind {
    /// `0.1`, which is 1/10
    Number(BigRational),
    /// `x`, `?x`, `D`
    Name(Ident),
    /// `a + b - c`: each with whether it is subtracted
    Sum(Vec<(bool, Value)>),
    /// `a * b / c`: each with whether it divides
    Product(Vec<(bool, Value)>),
    /// `a ^ n`
    Power(Box<Value>, Box<Value>),
    /// `-a`
    Negative(Box<Value>),
    /// `|a|`
    Absolute(Box<Value>),
    /// `if a < b then x else y`
    If(Relation, Box<[Value; 4]>),
    /// `(x, y)`
    Vector(Vec<Value>),
    /// `s(x)`, `Normal(0, sd: 1)`
    Call(Ident, Vec<Argument>),
    /// `f^n(p)`, `f^m o f^n(p)`: functions with how often each is applied, the last one first
    Iterate(Vec<(Ident, Option<Value>)>, Vec<Argument>),
    /// `{x if a < b; y if a >= b}`: each value with when it counts; no condition for `otherwise`. `if a < b and c < d then x
    /// else y` is the same with `otherwise`.
    Cases(Vec<(Value, Option<Either>)>),
}

/// How `n!` is called.
pub const FACTORIAL: &str = "factorial";

/// `x`, or `sd: x`, or `1/2: Normal(…)`
#[derive(Clone, Debug)]
pub struct Argument {
    /// What stands before the colon.
    pub label: Option<Value>,
    /// The argument.
    pub value: Value,
}
