//! Random numbers for one run, or for many side by side: counted, uniform, exponential and normal.
//!
//! Nothing here branches, so that a compiler can make several at a time, and nothing calls a library of the machine, so that
//! a number is the same on every one, whether it is made alone or among others.

/// Below it lie what one half of a word of 64 bits can be.
const HALF: u64 = 0xFFFF_FFFF;
/// Powers of two that bring a whole number into the last digits of a machine number.
const WHOLE: f64 = 4_503_599_627_370_496.0;
const ROUND: f64 = 1.5 * WHOLE;

/// How many are made at a time.
const WIDE: usize = 8;

/// Four words of 32 bits, for several runs.
type Words<const LANES: usize> = [[u64; LANES]; 4];

/// A round of the generator Philox 4x32 (Salmon and others, 2011).
#[inline(always)]
fn mixed<const LANES: usize>([a, b, c, d]: Words<LANES>, (key, other): (u32, u32), round: u32) -> Words<LANES> {
    let key = u64::from(key.wrapping_add(round.wrapping_mul(0x9E37_79B9)));
    let other = u64::from(other.wrapping_add(round.wrapping_mul(0xBB67_AE85)));
    let mut words = [[0; LANES]; 4];
    for lane in 0..LANES {
        let first = a[lane] * 0xD251_1F53;
        let second = c[lane] * 0xCD9E_8D57;
        words[0][lane] = (second >> 32) ^ b[lane] ^ key;
        words[1][lane] = second & HALF;
        words[2][lane] = (first >> 32) ^ d[lane] ^ other;
        words[3][lane] = first & HALF;
    }
    words
}

/// The words for a place, after ten rounds. These are written out: so a compiler sees that no word is longer than 32 bits,
/// which makes its products short.
#[inline(always)]
fn words<const LANES: usize>(key: (u32, u32), runs: [u64; LANES], round: u64, place: u64) -> Words<LANES> {
    let (low, high) = (runs.map(|run| run & HALF), runs.map(|run| run >> 32));
    let words = [low, high, [round & HALF; LANES], [place & HALF; LANES]];
    let words = mixed(mixed(words, key, 0), key, 1);
    let words = mixed(mixed(words, key, 2), key, 3);
    let words = mixed(mixed(words, key, 4), key, 5);
    let words = mixed(mixed(words, key, 6), key, 7);
    mixed(mixed(words, key, 8), key, 9)
}

/// A number between 0 and 1, neither included: 52 bits of two words, and half of the last of them; no digit is lost.
#[inline(always)]
fn unit(high: u64, low: u64) -> f64 {
    f64::from_bits(0x3FF0_0000_0000_0000 | ((high << 32 | low) >> 12)) - (1.0 - f64::EPSILON / 2.0)
}

/// Two numbers between 0 and 1, neither included.
pub(super) fn uniform(key: (u32, u32), run: u64, round: u64, place: u64) -> (f64, f64) {
    let [[a], [b], [c], [d]] = words(key, [run], round, place);
    (unit(a, b), unit(c, d))
}

/// The natural logarithm of a positive number that is neither tiny nor infinite, off by about a unit in the last place: the
/// series and the constants of FreeBSD's `e_log.c` (Sun Microsystems, 1993).
#[inline(always)]
pub(super) fn logarithm(number: f64) -> f64 {
    // The root of one half: the number is 2^k times one from there up to the root of two.
    const LEAST: u64 = 0x3FE6_A09E_667F_3BCD;
    let bits = number.to_bits() + (0x3FF0_0000_0000_0000 - LEAST);
    let power = f64::from_bits(WHOLE.to_bits() | (bits >> 52)) - (WHOLE + 1023.0);
    let rest = f64::from_bits((bits & 0x000F_FFFF_FFFF_FFFF) + LEAST) - 1.0;
    let share = rest / (2.0 + rest);
    let square = share * share;
    let fourth = square * square;
    let even =
        fourth * (0.399_999_999_994_094_2 + fourth * (0.222_221_984_321_497_84 + fourth * 0.153_138_376_992_093_73));
    let odd = square
        * (0.666_666_666_666_673_5
            + fourth
                * (0.285_714_287_436_623_9 + fourth * (0.181_835_721_616_180_5 + fourth * 0.147_981_986_051_165_86)));
    let half = 0.5 * rest * rest;
    let low = share * (half + even + odd) + power * 1.908_214_929_270_587_7e-10;
    power * 0.693_147_180_369_123_8 - ((half - low) - rest)
}

/// Sine and cosine of so many turns, which are from 0 to 1: the series of FreeBSD's `k_sin.c` and `k_cos.c` (Sun
/// Microsystems, 1993) for the angle to the nearest quarter.
#[inline(always)]
fn sine_and_cosine(turns: f64) -> (f64, f64) {
    let quarters = 4.0 * turns;
    let shifted = quarters + ROUND;
    let angle = (quarters - (shifted - ROUND)) * std::f64::consts::FRAC_PI_2;
    let quarter = shifted.to_bits();
    let square = angle * angle;
    let sine = -1.666_666_666_666_663_2e-1
        + square
            * (8.333_333_333_322_49e-3
                + square
                    * (-1.984_126_982_985_795e-4
                        + square
                            * (2.755_731_370_707_006_8e-6
                                + square * (-2.505_076_025_340_686_3e-8 + square * 1.589_690_995_211_55e-10))));
    let sine = (angle + angle * square * sine).to_bits();
    let cosine = 4.166_666_666_666_66e-2
        + square
            * (-1.388_888_888_887_411e-3
                + square
                    * (2.480_158_728_947_673e-5
                        + square
                            * (-2.755_731_435_139_066_3e-7
                                + square * (2.087_572_321_298_175e-9 - square * 1.135_964_755_778_819_5e-11))));
    let cosine = (1.0 - 0.5 * square + square * square * cosine).to_bits();
    // In every other quarter they change places; each has its own two quarters in which it is negative.
    let swap = (quarter & 1).wrapping_neg();
    let (one, other) = ((sine & !swap) | (cosine & swap), (cosine & !swap) | (sine & swap));
    let sign = |quarter: u64| (quarter & 2) << 62;
    (f64::from_bits(one ^ sign(quarter)), f64::from_bits(other ^ sign(quarter.wrapping_add(1))))
}

/// Two standard normal numbers of two uniform ones, by the method of Box and Muller (1958).
#[inline(always)]
pub(super) fn gauss((one, other): (f64, f64)) -> (f64, f64) {
    let radius = (-2.0 * logarithm(one)).sqrt();
    let (sine, cosine) = sine_and_cosine(other);
    (radius * cosine, radius * sine)
}

/// Two columns of uniform numbers, for these runs.
pub(super) fn uniforms(key: (u32, u32), runs: &[u64], round: u64, place: u64) -> [Vec<f64>; 2] {
    let (mut one, mut other) = (vec![0.0; runs.len()], vec![0.0; runs.len()]);
    let (some, rest) = runs.as_chunks::<WIDE>();
    let (ones, last) = one.as_chunks_mut::<WIDE>();
    let (others, lasts) = other.as_chunks_mut::<WIDE>();
    for ((runs, one), other) in some.iter().zip(ones).zip(others) {
        let [a, b, c, d] = words(key, *runs, round, place);
        *one = std::array::from_fn(|lane| unit(a[lane], b[lane]));
        *other = std::array::from_fn(|lane| unit(c[lane], d[lane]));
    }
    for ((run, one), other) in rest.iter().zip(last).zip(lasts) {
        (*one, *other) = uniform(key, *run, round, place);
    }
    [one, other]
}

/// Two columns of standard normal numbers, of two of uniform ones.
pub(super) fn normals(mut columns: [Vec<f64>; 2]) -> [Vec<f64>; 2] {
    let [one, other] = &mut columns;
    for (one, other) in one.iter_mut().zip(other) {
        (*one, *other) = gauss((*one, *other));
    }
    columns
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers between 0 and 1 of all sizes.
    fn places() -> impl Iterator<Item = f64> {
        let near = (1..53).flat_map(|power| [2f64.powi(-power), 1.0 - 2f64.powi(-power)]);
        near.chain((1..20_000).map(|number| f64::from(number) / 20_000.0))
    }

    #[test]
    fn the_generator_is_the_published_one() {
        // The vectors of Random123: ones in all places, and the digits of pi.
        let all = words((u32::MAX, u32::MAX), [u64::MAX], HALF, HALF);
        assert_eq!(all.concat(), [0x408f_276d, 0x41c8_3b0e, 0xa20b_c7c6, 0x6d54_51fd]);
        let pi = words((0xa409_3822, 0x299f_31d0), [0x85a3_08d3_243f_6a88], 0x1319_8a2e, 0x0370_7344);
        assert_eq!(pi.concat(), [0xd16c_fe09, 0x94fd_cceb, 0x5001_e420, 0x2412_6ea1]);
    }

    #[test]
    fn functions_are_those_of_the_library_but_for_rounding() {
        for place in places() {
            let (own, known) = (logarithm(place), place.ln());
            assert!((own - known).abs() <= 4.0 * f64::EPSILON * known.abs(), "{place}: {own} {known}");
            let (sine, cosine) = sine_and_cosine(place);
            // Whole quarters come out exactly, where the library has the angle rounded.
            let (first, second) = (std::f64::consts::TAU * place).sin_cos();
            assert!((sine - first).abs() < 1e-15 && (cosine - second).abs() < 1e-15, "{place}: {sine} {cosine}");
        }
    }

    #[test]
    fn side_by_side_they_are_the_same() {
        let runs: Vec<u64> = (0..1_001).map(|run| run * 77_777_777_777).collect();
        let [one, other] = normals(uniforms((5, 6), &runs, 7, 8));
        for (place, run) in runs.iter().enumerate() {
            assert_eq!((one[place], other[place]), gauss(uniform((5, 6), *run, 7, 8)));
        }
    }
}
