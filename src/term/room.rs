//! How far terms may nest, which depends on the stack of the thread that walks down them.

use std::cell::Cell;

/// The least stack that a thread has, in bytes, if nothing else is said.
const LEAST: usize = 2 << 20;
/// The stack that one level takes at most, in bytes, with all that may be on it.
const LEVEL: usize = 1_900;
/// The most levels, however large the stack.
const MOST: usize = 50_000;

thread_local! {
    static STACK: Cell<usize> = const { Cell::new(LEAST) };
}

/// Tells how much stack this thread has, in bytes: so much deeper may terms nest in it.
pub fn tell(stack: usize) {
    STACK.set(stack);
}

/// How much stack this thread has, in bytes, as far as it was told.
pub fn stack() -> usize {
    STACK.get()
}

/// The most operators that may stand around one another, each with one part, as `new p.` does.
pub fn levels() -> usize {
    (STACK.get() / LEVEL).min(MOST)
}
