//! PARS: the process algebra for robot schemas.

pub mod assumption;
pub mod ast;
pub mod definition;
pub mod diagnostic;
pub mod law;
pub mod lexer;
pub mod lower;
pub mod name;
pub mod parser;
pub mod printer;
pub mod term;
pub mod value;
