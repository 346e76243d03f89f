//! Numbers that only look random, the same on every machine.
#![allow(dead_code)]

pub struct Dice(pub u64);

impl Dice {
    pub fn roll(&mut self, sides: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % sides
    }

    pub fn place(&mut self, places: usize) -> usize {
        self.roll(places as u64) as usize
    }

    pub fn one_of(&mut self, all: &[&str]) -> String {
        all[self.place(all.len())].to_string()
    }
}
