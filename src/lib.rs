//! PARS: the process algebra for robot schemas.

pub mod ast;
pub mod definition;
pub mod diagnostic;
pub mod law;
pub mod lexer;
pub mod name;
pub mod parser;
pub mod term;
pub mod value;
