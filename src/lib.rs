//! PARS: a language, an algebra and a prover for robot programs and the world around them.
//!
//! The modules stand in the order in which each builds on the others: a module imports only what stands above it.

// Outside tests no answer is given up by a panic that is written down, nor by a letter cut in two.
#![cfg_attr(
    not(test),
    deny(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::unreachable,
        clippy::todo,
        clippy::unimplemented,
        clippy::string_slice
    )
)]

pub mod digest;
pub mod name;
mod rational;
pub mod polynomial;
pub mod value;
pub mod assumption;
pub mod term;
pub mod definition;
pub mod law;
pub mod scope;
pub mod fact;
pub mod condition;
pub mod substitution;
pub mod advance;
pub mod proof;
pub mod kernel;
// ── the line: above it a theorem can be made, below it one can only be asked for ──
mod elimination;
pub mod univariate;
pub mod exponential_polynomial;
pub mod closed_form;
pub mod diagnostic;
pub mod preorder;
pub mod lexer;
pub mod ast;
pub mod parser;
pub mod lower;
pub mod printer;
pub mod mark;
pub mod library;
pub mod proof_file;
// ── engine: every answer comes with its proof ──
pub mod simplest;
pub mod interval;
pub mod distribution;
pub mod model;
pub mod bisimulation;
pub mod transition_system;
pub mod equivalence;
pub mod refute;
pub mod stepper;
pub mod absence;
pub mod sample;
pub mod replay;
pub mod matching;
pub mod simplify;
pub mod rewrite;
pub mod refine;
pub mod prove;
pub mod remedy;
pub mod recurrence;
pub mod period;
pub mod flow;
pub mod verify;
pub mod lasso;
pub mod connectivity;
pub mod invariant;
pub mod safety;
pub mod probability;
pub mod timeline;
pub mod criteria;
pub mod picture;
pub mod sweep;
// ── surface: what people see ──
pub mod explain;
pub mod latex;
pub mod report;
pub mod page;
pub mod admission;
pub mod session;
pub mod codes;
pub mod progress;
pub mod script;
pub mod exercise;
pub mod lint;
pub mod walk;
pub mod repl;
pub mod cli;
