//! PARS: a language, an algebra and a prover for robot programs and the world around them.
//!
//! The modules stand in the order in which each builds on the others: a module imports only what stands above it.

pub mod name;
pub mod polynomial;
pub mod value;
pub mod assumption;
pub mod term;
pub mod definition;
pub mod law;
