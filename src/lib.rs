//! PARS: a symbolic engine and prover for the Process Algebra for Robot Schemas.
//!
//! The modules stand in the order in which a mission flows through them, and each imports only what stands above it.
//! Above the line stands what a theorem rests on.

#![forbid(unsafe_code)]
#![deny(missing_docs)]

pub mod assumption;
pub mod condition;
pub mod definition;
pub mod fact;
pub mod kernel;
pub mod law;
pub mod name;
pub mod polynomial;
pub mod proof;
pub mod scope;
pub mod substitution;
pub mod term;
pub mod value;
// ── the line: above it a theorem can be made, below it one can only be asked for ──
pub mod ast;
pub mod diagnostic;
pub mod lexer;
pub mod lower;
pub mod matching;
pub mod parser;
pub mod printer;
pub mod library;
pub mod prove;
pub mod refine;
pub mod rewrite;
pub mod simplify;
