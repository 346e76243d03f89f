//! Checks on whole definitions: calls in tail position, loops that take time, names bound before they are read.

use super::flow::{Bound, Flow, Flows, Walk};
use super::scope::Lowerer;
use crate::ast::{Ident, Term, TermKind};
use crate::diagnostic::Diagnostic;
use crate::name::Name;

const BESIDE: &str = "another process runs beside it under `|`, and no guards keep one of the two from running";

impl Lowerer<'_> {
    /// Checks the bindings and loops of a process; `flows` has those that are being defined.
    pub(super) fn check_flow(&mut self, term: &Term, flows: Option<&Flows>) -> Flow {
        let none = Flows::new();
        let mut walk = Walk { lowerer: self, flows: flows.unwrap_or(&none), report: true };
        walk.flow(term, &Bound::default())
    }

    /// The flow of a process, given those of the processes that are being defined; reports nothing.
    pub(super) fn quiet_flow(&mut self, term: &Term, flows: &Flows) -> Flow {
        Walk { lowerer: self, flows, report: false }.flow(term, &Bound::default())
    }

    /// Reports what a declaration says it binds and does not.
    pub(super) fn check_results(&mut self, results: &[Ident], flow: &Flow) {
        for result in results {
            if flow.stop.as_ref().is_some_and(|names| !names.contains(self.result_name(&result.name))) {
                self.report(
                    Diagnostic::error(
                        "P0506",
                        format!("the result `{}` is not bound whenever this process stops", result.name),
                    )
                    .label(result.span, "declared as a result here")
                    .help(format!("bind it on every way, for example by `Set_x<{}>`", result.name)),
                );
            }
        }
    }

    /// Reports a result behind a call that the process does not bind.
    pub(super) fn check_passed(&mut self, name: &Ident, results: &[Ident], flow: &Flow) {
        if let Some(wrong) = self.unbound(name, results, &flow.binds) {
            self.report(wrong);
        }
    }

    /// Reports calls of a process on the same loop that are not the last thing done.
    pub(super) fn check_tails(&mut self, term: &Term, on_loop: &dyn Fn(&Name) -> bool) {
        let mut rest: Vec<(&Term, Option<&'static str>)> = vec![(term, None)];
        while let Some((term, why)) = rest.pop() {
            match &term.kind {
                TermKind::Apply { name, .. } => {
                    if let (Some(why), true) = (why, on_loop(&name.name)) {
                        self.not_last(name, why);
                    }
                }
                TermKind::Meta(..) => {}
                TermKind::Seq(parts) => {
                    let last = parts.len().saturating_sub(1);
                    let inner = |index: usize| {
                        if index < last { why.or(Some("something follows it after `;`")) } else { why }
                    };
                    rest.extend(parts.iter().enumerate().map(|(index, part)| (part, inner(index))));
                }
                TermKind::Else(first, second) => {
                    rest.push((first, why.or(Some("if it aborted, what follows `else` would have to run"))));
                    rest.push((second, why));
                }
                TermKind::Par(parts) => {
                    let none = Flows::new();
                    let exclusive = Walk { lowerer: self, flows: &none, report: false }.all_exclusive(parts);
                    let inner = if exclusive { why } else { why.or(Some(BESIDE)) };
                    rest.extend(parts.iter().map(|part| (part, inner)));
                }
                TermKind::Disable(parts) => {
                    rest.extend(
                        parts.iter().map(|part| (part, why.or(Some("another process runs beside it under `#`")))),
                    );
                }
                TermKind::Power(body, ..) | TermKind::Loop(body) => rest.push((body, why.or(Some("it is repeated")))),
                TermKind::Try(body) => rest.push((body, why.or(Some("it stands inside `try`")))),
                TermKind::New(_, body) => rest.push((body, why.or(Some("it stands inside `new`")))),
                TermKind::Project(body, _) => rest.push((body, why.or(Some("it stands under a projection")))),
                TermKind::Replace(body, ..) => rest.push((body, why)),
            }
        }
    }

    fn not_last(&mut self, name: &Ident, why: &str) {
        let help = if why == BESIDE {
            "where only one of the two shall run, begin each with guards of which at most one passes: `(Lte_{x,3} ; P | Gtr_{x,3} ; Q)`".to_string()
        } else {
            format!("end the definition with it: `P ; {}`; to repeat a part use `loop(P)`", name.name)
        };
        self.report(
            Diagnostic::error("P0601", format!("`{}` calls itself here, but not as the last thing it does", name.name))
                .label(name.span, why.to_string())
                .note("a process that calls itself is a loop, so the call must come last")
                .help(help),
        );
    }
}
