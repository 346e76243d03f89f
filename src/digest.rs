//! A quick hash of what a value or a term is made of. Nothing rests on it: what has the same hash is still compared.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

/// A map of which the order is nobody's concern: what is looked up takes the same time however much there is.
pub type Quick<K, V> = HashMap<K, V, BuildHasherDefault<Digest>>;

/// Takes in word after word: a rotation, an exclusive or and a product each, and mixes all bits at the end.
#[derive(Clone, Default, Debug)]
pub struct Digest(u64);

/// An odd number without pattern: 2^64 divided by the golden ratio.
const SPREAD: u64 = 0x9e37_79b9_7f4a_7c15;

impl Digest {
    fn take(&mut self, word: u64) {
        self.0 = (self.0.rotate_left(5) ^ word).wrapping_mul(SPREAD);
    }
}

impl Hasher for Digest {
    fn write(&mut self, bytes: &[u8]) {
        for chunk in bytes.chunks(8) {
            self.take(chunk.iter().rev().fold(0, |word, byte| word << 8 | u64::from(*byte)));
        }
    }

    fn write_u8(&mut self, number: u8) {
        self.take(u64::from(number));
    }

    fn write_u32(&mut self, number: u32) {
        self.take(u64::from(number));
    }

    fn write_u64(&mut self, number: u64) {
        self.take(number);
    }

    fn write_usize(&mut self, number: usize) {
        self.take(number as u64);
    }

    fn finish(&self) -> u64 {
        let mixed = (self.0 ^ (self.0 >> 32)).wrapping_mul(SPREAD);
        mixed ^ (mixed >> 29)
    }
}
