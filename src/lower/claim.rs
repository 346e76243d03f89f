//! Claims, laws and expectations.

use std::collections::BTreeSet;

use super::property::names_in;
use super::scope::{Lowerer, Metas};
use super::{By, CalcStep, Claim, ClaimKind, Entity, Environment, Event, Expectation, Likelihood, Subject};
use crate::ast::{self, ConditionKind, Ident, Item, LawItem, Term as Written, TermKind};
use crate::diagnostic::{Diagnostic, Span};
use crate::fact::Context;
use crate::law::{Condition, Law};
use crate::name::Name;
use crate::scope::{changed, condition_metavariables, metavariables};
use crate::substitution::replace;
use crate::term::{Node, Term};

impl Lowerer<'_> {
    /// A process that stands alone: bound, lowered and checked.
    pub(super) fn whole(&mut self, terms: &[&Written]) -> Option<Vec<Term>> {
        self.bind(terms);
        let lowered: Vec<_> = terms.iter().map(|term| self.process(term)).collect();
        if self.errors.is_empty() {
            terms.iter().for_each(|term| {
                self.check_flow(term, None);
            });
        }
        lowered.into_iter().collect()
    }

    pub(super) fn claim(&mut self, claim: &ast::Claim, span: Span, text: &str) -> Option<Claim> {
        let kind = match &claim.kind {
            ast::ClaimKind::Satisfies(system, property) => {
                let system = self.named(system, "system");
                let property = self.named(property, "property")?;
                let (system, asked) = (system?, self.environment.property(&property));
                let always = asked.and_then(|one| one.always.clone());
                match (asked.and_then(|one| one.within.clone()), always) {
                    (None, None) => ClaimKind::Satisfies { system, property },
                    (None, Some(pattern)) => ClaimKind::Always { system, pattern, property: Some(property) },
                    (Some((_, relation, threshold)), _) => {
                        let event = Event::Satisfies(property);
                        let likelihood = Likelihood { system, event, method: None, runs: None, seed: None };
                        ClaimKind::Likely { likelihood, relation, threshold }
                    }
                }
            }
            ast::ClaimKind::Always { system, conditions, shown } => self.always(system, conditions, shown)?,
            ast::ClaimKind::Likely(likelihood, relation, bound) => self.likely(likelihood, *relation, bound)?,
            ast::ClaimKind::Compare { left, connective, right, when, by } => {
                let mut terms = vec![left, right];
                if let ast::By::Calc(first, steps) = by {
                    terms.push(first);
                    terms.extend(steps.iter().map(|step| &step.term));
                }
                terms.extend(when.iter().flat_map(processes));
                let mut lowered = self.whole(&terms)?.into_iter();
                let (first, second) = (self.put_in(lowered.next()?), self.put_in(lowered.next()?));
                let when = self.conditions(when)?;
                let by = self.by(by, &first, &second, *connective)?;
                ClaimKind::Compare { left: first, right: second, connective: *connective, when, by }
            }
        };
        let name = claim.name.as_ref().map(|name| name.name.clone());
        Some(Claim { name, span, text: without_comments(span.of(text)), kind })
    }

    /// The process with each `P[y := x]` in it carried out, where it is known what P is.
    pub(super) fn put_in(&self, term: Term) -> Term {
        let context = Context::new(&self.environment.assumptions, &self.environment.definitions, &[]);
        carried_out(&term, &context).unwrap_or(term)
    }

    /// The name of a system or a property.
    pub(super) fn named(&mut self, ident: &Ident, word: &'static str) -> Option<Name> {
        let environment = self.environment;
        match environment.entity(&ident.name) {
            Some(entity) if entity.word() == word && entity.is_broken() => {
                self.refused(ident);
                None
            }
            Some(entity) if entity.word() == word => Some(ident.name.clone()),
            Some(entity) => {
                let with_article = |word: &str| format!("{} {word}", if word == "observer" { "an" } else { "a" });
                let found = with_article(entity.word());
                let other = match word {
                    "system" => "system Sys = P | Q",
                    "observer" => "observer Rock(q)",
                    _ => "property Goal = P",
                };
                self.fail(
                    Diagnostic::error(
                        "P0313",
                        format!("`{}` is {found}, but {} is needed here", ident.name, with_article(word)),
                    )
                    .label(ident.span, found)
                    .help(format!("declare one: `{other}`")),
                )
            }
            None => {
                let known = environment.entities().filter(|(_, entity)| entity.word() == word);
                self.unknown(
                    "P0318",
                    word,
                    ident,
                    known.map(|(name, _)| name.as_str()),
                    &match word {
                        "observer" => format!("declare it with `observer {}(q)`", ident.name),
                        _ => format!("declare it with `{word} {} = …`", ident.name),
                    },
                );
                None
            }
        }
    }

    fn by(&mut self, by: &ast::By, left: &Term, right: &Term, claimed: crate::law::Connective) -> Option<By> {
        Some(match by {
            ast::By::Search => By::Search,
            ast::By::Laws(laws) => By::Laws(self.laws(laws)?),
            ast::By::Calc(first, steps) => {
                let start = self.process(first)?;
                let start = self.put_in(start);
                if start != *left {
                    self.wrong_end(first.span, "the calculation must begin with the left side of the claim");
                }
                let mut lowered = Vec::new();
                for step in steps {
                    let laws = self.laws(&step.laws);
                    let term = self.process(&step.term)?;
                    let term = self.put_in(term);
                    if !step.connective.gives(claimed) {
                        let why =
                            format!("the claim is made with `{claimed}`, so no step may be `{}`", step.connective);
                        self.wrong_end(step.span, &why);
                    }
                    lowered.push(CalcStep { connective: step.connective, laws: laws?, term, span: step.span });
                }
                if lowered.last().map_or(&start, |step| &step.term) != right {
                    let span = steps.last().map_or(first.span, |step| step.term.span);
                    self.wrong_end(span, "the calculation must end with the right side of the claim");
                }
                By::Calc(lowered)
            }
        })
    }

    pub(super) fn wrong_end(&mut self, span: Span, text: &str) {
        self.report(Diagnostic::error("P0701", text).label(span, "here"));
    }

    pub(super) fn laws(&mut self, idents: &[Ident]) -> Option<Vec<Name>> {
        let environment = self.environment;
        let mut names = Vec::new();
        for ident in idents {
            if environment.laws.get(&ident.name).is_some() || environment.claims.contains(&ident.name) {
                names.push(ident.name.clone());
            } else {
                let known = environment.laws.iter().map(|law| law.name.as_str());
                let known = known.chain(environment.claims.iter().map(Name::as_str));
                let help = "`:laws` lists the laws in force; an earlier claim may be named as well";
                self.unknown("P0702", "law", ident, known, help);
            }
        }
        (names.len() == idents.len()).then_some(names)
    }

    fn conditions(&mut self, conditions: &[ast::Condition]) -> Option<Vec<Condition>> {
        let lowered: Vec<_> = conditions.iter().map(|condition| self.condition(condition)).collect();
        lowered.into_iter().collect()
    }

    pub(super) fn condition(&mut self, condition: &ast::Condition) -> Option<Condition> {
        Some(match &condition.kind {
            ConditionKind::Compare(relation, left, right) => {
                let left = self.number(left);
                let right = self.number(right)?;
                Condition::Compare(*relation, left?, right)
            }
            ConditionKind::Natural(value) => Condition::Natural(self.number(value)?),
            ConditionKind::Is(fact, process) => Condition::Is(*fact, self.process(process)?),
            ConditionKind::Lasts(process, time) => {
                let process = self.process(process);
                let time = self.number(time)?;
                Condition::Lasts(process?, time)
            }
            ConditionKind::Complementary(left, right) => {
                let left = self.process(left);
                let right = self.process(right)?;
                Condition::Complementary(left?, right)
            }
            ConditionKind::NoPort(process, port) => {
                self.port_name(port)?;
                Condition::NoPort(self.process(process)?, port.name.clone())
            }
            ConditionKind::Unread(process, name) => {
                let process = self.process(process)?;
                Condition::Unread(process, self.result_name(&name.name).clone())
            }
            ConditionKind::ShowsOnly(process, shown) => {
                let process = self.process(process);
                Condition::ShowsOnly(process?, self.shown(shown)?)
            }
            ConditionKind::ShowsNone(process, shown) => {
                let process = self.process(process);
                Condition::ShowsNone(process?, self.shown(shown)?)
            }
            ConditionKind::Apart(left, right) => {
                let left = self.process(left);
                let right = self.process(right)?;
                Condition::Apart(left?, right)
            }
        })
    }

    pub(super) fn law(&mut self, item: &LawItem) -> Option<Law> {
        self.lenient = true;
        self.law_header(item);
        let mut terms = vec![&item.left, &item.right];
        terms.extend(item.conditions.iter().flat_map(processes));
        terms.extend(item.examples.iter().flat_map(|(left, right)| [left, right]));
        let mut lowered = self.whole(&terms)?.into_iter();
        let (left, right) = (lowered.next()?, lowered.next()?);
        let conditions = self.conditions(&item.conditions)?;
        let examples = item.examples.iter().map(|(left, right)| Some((self.process(left)?, self.process(right)?)));
        let examples = examples.collect::<Option<Vec<_>>>()?;
        let mut bound = metavariables(&left);
        let unbound = metavariables(&right).into_iter().chain(written(&item.right));
        let unbound = unbound.into_iter().find(|name| !bound.contains(name));
        if unbound.is_none() {
            self.law_direction(item, &left, &right);
        }
        if let Some(name) = unbound {
            self.report(unbound_in(item, "the right side", &name, item.right.span));
        }
        // `lasts(P, t)` finds t.
        bound.extend(conditions.iter().flat_map(|condition| match condition {
            Condition::Lasts(_, time) => time.variables(),
            _ => BTreeSet::new(),
        }));
        for (condition, written) in conditions.iter().zip(&item.conditions) {
            if let Some(name) = condition_metavariables(condition).into_iter().find(|name| !bound.contains(name)) {
                self.report(unbound_in(item, "a condition", &name, written.span));
            }
        }
        Some(Law {
            name: item.name.name.clone(),
            title: item.title.clone(),
            source: item.source.clone(),
            connective: item.connective,
            oriented: item.oriented,
            conditions,
            left,
            right,
            examples,
        })
    }

    fn law_header(&mut self, item: &LawItem) {
        let name = &item.name;
        let fine = |letter: char| letter.is_ascii_alphanumeric() || letter == '-';
        if !name.name.as_str().chars().all(fine) {
            self.report(
                Diagnostic::error("P0704", format!("a law cannot be named `{}`", name.name))
                    .label(name.span, "its name")
                    .help("the name of a law has letters, digits and dashes only: `delay-sum`"),
            );
        }
        if self.environment.laws.get(&name.name).is_some() {
            self.report(
                Diagnostic::error("P0705", format!("there is a law `{}` already", name.name))
                    .label(name.span, "the name is taken"),
            );
        }
        if item.source.is_empty() {
            self.report(
                Diagnostic::error("P0706", format!("the law `{}` does not say where it comes from", name.name))
                    .label(name.span, "this law")
                    .help("write a line `paper §…`, or `ours` with a reason, below its title"),
            );
        }
    }

    /// Reports an oriented law whose result can be rewritten by it again and again.
    fn law_direction(&mut self, item: &LawItem, left: &Term, right: &Term) {
        if !item.oriented {
            return;
        }
        let bare = matches!(left.node(), Node::Meta(..));
        // Conditions may stop it: then only a run can tell.
        let inside = item.conditions.is_empty() && super::direction::goes_on(left, right);
        if bare || inside {
            let why = if bare { "fits every process" } else { "fits the right side again" };
            self.report(
                Diagnostic::error("P0707", format!("the law `{}` would simplify for ever", item.name.name))
                    .label(item.left.span, format!("this side {why}"))
                    .help("write `=` in place of `=>`: then it is used in proofs, but not to simplify"),
            );
        }
    }

    pub(super) fn expectation(&mut self, expect: &ast::Expect) -> Option<Expectation> {
        Some(match expect {
            ast::Expect::Verdict(word) => match word.name.as_str() {
                "proved" => Expectation::Proved,
                "refuted" => Expectation::Refuted,
                "yes" | "no" | "unknown" => Expectation::Answer(word.name.clone()),
                "never" => Expectation::Never,
                "met" => Expectation::Met,
                "not met" => Expectation::NotMet,
                _ => Expectation::Open,
            },
            ast::Expect::Term(term) => Expectation::Term(self.whole(&[term])?.pop()?),
            ast::Expect::Values(values) => {
                let lowered = values.iter().map(|(name, value)| Some((name.name.clone(), self.number(value)?)));
                Expectation::Values(lowered.collect::<Option<Vec<_>>>()?)
            }
        })
    }

    pub(super) fn subject(&mut self, term: &Written) -> Option<Subject> {
        if let TermKind::Apply { name, arguments, results } = &term.kind {
            let bare = arguments.is_empty() && results.is_empty();
            if bare && matches!(self.environment.entity(&name.name), Some(Entity::System(_))) {
                self.named(name, "system")?;
                return Some(Subject::System(name.name.clone()));
            }
        }
        Some(Subject::Term(self.whole(&[term])?.pop()?))
    }
}

impl Environment {
    pub(super) fn lower_item(&self, item: &Item, text: &str) -> Result<super::Lowered, Vec<Diagnostic>> {
        use super::Lowered;
        if let ast::ItemKind::Solve(solve) = &item.kind
            && let Some((environment, notes)) = self.with_vectors(solve)
        {
            // Where that does not help either, the question is wrong as it is written.
            if let Ok(mut lowered) = environment.lower_as_written(item, text) {
                if let Lowered::Solve(question) = &mut lowered {
                    question.notes.splice(0..0, notes);
                }
                return Ok(lowered);
            }
        }
        self.lower_as_written(item, text)
    }

    /// The same with each parameter as it was declared.
    fn lower_as_written(&self, item: &Item, text: &str) -> Result<super::Lowered, Vec<Diagnostic>> {
        use super::Lowered;
        let mut lowerer = Lowerer::new(self, Metas::Law);
        let lowered = match &item.kind {
            ast::ItemKind::Prove(claim) => lowerer.claim(claim, item.span, text).map(Lowered::Claim),
            ast::ItemKind::Simplify(term) => {
                lowerer.whole(&[term]).and_then(|mut terms| terms.pop()).map(Lowered::Simplify)
            }
            ast::ItemKind::Period(name) => lowerer.named(name, "system").map(Lowered::Period),
            ast::ItemKind::Flow(name) => lowerer.named(name, "system").map(Lowered::Flow),
            ast::ItemKind::Solve(solve) => lowerer.solve(solve).map(|mut question| {
                question.asked = goal_as_typed(solve, item.span, text).or(question.asked);
                Lowered::Solve(Box::new(question))
            }),
            ast::ItemKind::Probability(likelihood) => lowerer.likelihood(likelihood).map(Lowered::Probability),
            ast::ItemKind::Project(term, shown) => {
                let subject = lowerer.subject(term);
                let shown = lowerer.shown(shown);
                subject.and_then(|subject| Some(Lowered::Project(subject, shown?)))
            }
            ast::ItemKind::Lts(term, limits) => lowerer.subject(term).map(|term| Lowered::Lts(term, *limits)),
            ast::ItemKind::Minimise(term, limits) => lowerer.subject(term).map(|term| Lowered::Minimise(term, *limits)),
            ast::ItemKind::Alike(left, right, relation, limits) => {
                let (left, right) = (lowerer.subject(left), lowerer.subject(right));
                left.and_then(|left| Some(Lowered::Alike(left, right?, *relation, *limits)))
            }
            ast::ItemKind::Expect(expect) => {
                lowerer.free = true;
                lowerer.expectation(expect).map(Lowered::Expect)
            }
            ast::ItemKind::Import(path) => Some(Lowered::Import(path.clone())),
            ast::ItemKind::Law(law) => lowerer.law(law).map(Lowered::Law),
            ast::ItemKind::Criteria(criteria) => {
                lowerer.criteria(criteria).map(|criteria| Lowered::Criteria(Box::new(criteria)))
            }
            ast::ItemKind::Sweep(sweep) => lowerer.sweep(sweep, text).map(|sweep| Lowered::Sweep(Box::new(sweep))),
            ast::ItemKind::Exercise(exercise) => lowerer.exercise(exercise, item.span, text).map(Lowered::Exercise),
            _ => None,
        };
        lowerer.finish(lowered)
    }
}

/// What is looked for, as it was typed.
fn goal_as_typed(solve: &ast::Solve, whole: Span, text: &str) -> Option<String> {
    let behind = text.get(solve.find.as_ref()?.index.span.end..whole.end)?;
    let goal = behind.trim_start().strip_prefix("with")?;
    let words: Vec<&str> = goal.split_whitespace().collect();
    (!goal.contains("//") && !words.is_empty()).then(|| words.join(" "))
}

/// The processes that a condition mentions.
fn processes(condition: &ast::Condition) -> Vec<&Written> {
    match &condition.kind {
        ConditionKind::Compare(..) | ConditionKind::Natural(_) => Vec::new(),
        ConditionKind::Is(_, process)
        | ConditionKind::ShowsOnly(process, _)
        | ConditionKind::ShowsNone(process, _)
        | ConditionKind::Lasts(process, _)
        | ConditionKind::NoPort(process, _)
        | ConditionKind::Unread(process, _) => vec![process],
        ConditionKind::Complementary(left, right) | ConditionKind::Apart(left, right) => vec![left, right],
    }
}

/// What was written, line by line, without the comments behind it.
fn without_comments(text: &str) -> String {
    let lines = text.lines().map(|line| line.split("//").next().unwrap_or("").trim_end());
    lines.filter(|line| !line.is_empty()).collect::<Vec<_>>().join("\n")
}

/// The process with its replacements carried out; none if nothing changes.
fn carried_out(term: &Term, context: &Context<'_>) -> Option<Term> {
    let inner = changed(term, &mut |part| carried_out(part, context));
    let Node::Replace(body, name, value) = inner.as_ref().unwrap_or(term).node() else { return inner };
    let process = |meta: &Name| meta.as_str().chars().nth(1).is_some_and(char::is_uppercase);
    if metavariables(body).iter().any(process) {
        return inner;
    }
    replace(body, name, value, context).ok().or(inner.clone())
}

/// The metavariables for values that are written in a process, those that cancel out included.
fn written(process: &ast::Term) -> BTreeSet<Name> {
    let mut found = BTreeSet::new();
    for part in process.all() {
        let values: Vec<&ast::Value> = match &part.kind {
            TermKind::Apply { arguments, .. } | TermKind::Meta(_, arguments) => arguments.iter().collect(),
            TermKind::Power(_, value, _) | TermKind::Replace(_, _, value) => vec![value],
            _ => Vec::new(),
        };
        for value in values {
            names_in(value, &mut |name| found.extend(name.name.is_meta().then(|| name.name.clone())));
        }
    }
    found
}

/// Of a name that stands in a part of a law, but not on its left side.
fn unbound_in(item: &LawItem, part: &str, name: &Name, place: Span) -> Diagnostic {
    let text = format!("{part} of the law `{}` has `{name}`, which the left side does not bind", item.name.name);
    let diagnostic = Diagnostic::error("P0703", text).label(place, format!("`{name}` here"));
    diagnostic.label(item.left.span, "not here")
}
