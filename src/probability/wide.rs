//! Sums over machine numbers with the widest vectors that the machine has.

use pulp::{Arch, Simd, WithSimd};

/// Numbers that are summed at a time; rows of a matrix are filled up to a multiple of them.
pub(super) const CHUNK: usize = 8;

/// What is done with vectors.
pub(super) trait Loop {
    /// Has to be inlined, with all that it calls.
    fn run<S: Simd>(self, simd: S);
}

/// For the library, which compiles it once for each kind of machine.
struct Wide<L>(L);

impl<L: Loop> WithSimd for Wide<L> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.0.run(simd);
    }
}

/// Runs a loop with the widest vectors.
pub(super) fn widest(one: impl Loop) {
    Arch::new().dispatch(Wide(one));
}

/// The sum of the products of chunks of numbers, as many as there are of both, in some order; each is rounded once or twice.
#[inline(always)]
pub(super) fn product<S: Simd>(simd: S, one: &[[f64; CHUNK]], other: &[[f64; CHUNK]]) -> f64 {
    let mut sums = [simd.splat_f64s(0.0); 2];
    for (one, other) in one.iter().zip(other) {
        let ((one, _), (other, _)) = (S::as_simd_f64s(one), S::as_simd_f64s(other));
        for (place, (one, other)) in one.iter().zip(other).enumerate() {
            sums[place % 2] = simd.mul_add_e_f64s(*one, *other, sums[place % 2]);
        }
    }
    simd.reduce_sum_f64s(simd.add_f64s(sums[0], sums[1]))
}
