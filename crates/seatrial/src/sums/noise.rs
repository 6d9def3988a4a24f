//! Normal random numbers that are a function of where they are used.

use pulp::bytemuck::{self, AnyBitPattern};
use pulp::{Arch, Simd, WithSimd};

use super::lanes::Lanes;

/// Numbers that one block of the generator gives.
pub(super) const BLOCK: usize = 4;

/// Blocks that are drawn at a time.
pub(super) const COUNTERS: usize = 16;

/// Rounds of Philox; from seven on it passes every test of its authors.
const ROUNDS: u32 = 7;

const LOW: u64 = 0xffff_ffff;

/// Philox-4x32 (J. K. Salmon et al., Parallel random numbers: as easy as 1, 2, 3, SC 2011) of the counters
/// `[block, 0, run, run >> 32]`, in every lane: words of 32 bits.
#[inline(always)]
fn philox<const N: usize>(seed: u64, run: &[u64; N], block: &[u64; N]) -> [[u64; N]; BLOCK] {
    const MULTIPLIERS: [u64; 2] = [0xd251_1f53, 0xcd9e_8d57];
    const KEY_STEPS: [u64; 2] = [0x9e37_79b9, 0xbb67_ae85];
    let mut words = [[0; N]; BLOCK];
    for j in 0..N {
        let mut counter = [block[j] & LOW, block[j] >> 32, run[j] & LOW, run[j] >> 32];
        let mut key = [seed & LOW, seed >> 32];
        for _ in 0..ROUNDS {
            let first = MULTIPLIERS[0] * (counter[0] & LOW);
            let second = MULTIPLIERS[1] * (counter[2] & LOW);
            counter = [
                (second >> 32) ^ counter[1] ^ key[0],
                second & LOW,
                (first >> 32) ^ counter[3] ^ key[1],
                first & LOW,
            ];
            key = [(key[0] + KEY_STEPS[0]) & LOW, (key[1] + KEY_STEPS[1]) & LOW];
        }
        for (words, word) in words.iter_mut().zip(counter) {
            words[j] = word;
        }
    }
    words
}

/// Four standard normal numbers for each counter: Box and Muller's transformation of pairs of words.
#[inline(always)]
pub(super) fn normals<S: Simd>(
    simd: S,
    seed: u64,
    run: &[u64; COUNTERS],
    block: &[u64; COUNTERS],
) -> [[f64; COUNTERS]; BLOCK] {
    let words = philox(seed, run, block);
    let mut normals = [[0.0; COUNTERS]; BLOCK];
    for (words, normals) in words.as_chunks().0.iter().zip(normals.as_chunks_mut().0) {
        let [of_radius, of_direction]: &[[u64; COUNTERS]; 2] = words;
        let [cosines, sines]: &mut [[f64; COUNTERS]; 2] = normals;
        for at in (0..COUNTERS).step_by(S::F64_LANES) {
            let here = at..at + S::F64_LANES;
            let radius = radius(simd, load(&of_radius[here.clone()]));
            let [x, y] = direction(simd, load(&of_direction[here.clone()]));
            cosines[here.clone()].copy_from_slice((radius * x).numbers());
            sines[here].copy_from_slice((radius * y).numbers());
        }
    }
    normals
}

/// A register full of words.
#[inline(always)]
fn load<R: AnyBitPattern>(words: &[u64]) -> R {
    bytemuck::pod_read_unaligned(bytemuck::cast_slice(words))
}

/// Integers below 2^52 as numbers: their bits stand behind those of 2^52.
#[inline(always)]
fn numbers<S: Simd>(simd: S, integers: S::u64s) -> Lanes<S, f64> {
    const OFFSET: f64 = (1_u64 << 52) as f64;
    let bits = simd.or_u64s(simd.splat_u64s(OFFSET.to_bits()), integers);
    let register = simd.transmute_f64s_u64s(bits);
    Lanes { simd, register } - Lanes::splat(simd, OFFSET)
}

/// The sum of c_k x^k, the highest first.
#[inline(always)]
fn polynomial<S: Simd, const N: usize>(x: Lanes<S, f64>, coefficients: [f64; N]) -> Lanes<S, f64> {
    let splat = |c| Lanes::splat(x.simd, c);
    let mut sum = splat(coefficients[0]);
    for c in &coefficients[1..] {
        sum = sum.fused(x, splat(*c));
    }
    sum
}

/// sqrt(-2 ln((word + 1/2)/2^32)).
#[inline(always)]
fn radius<S: Simd>(simd: S, word: S::u64s) -> Lanes<S, f64> {
    let square = Lanes::splat(simd, -2.0) * ln_of_share(simd, word);
    let register = simd.sqrt_f64s(square.register);
    Lanes { simd, register }
}

/// ln((word + 1/2)/2^32), to 1e-11: 2 artanh(s) of the significand m, s = (m - 1)/(m + 1), |s| < 0.18.
#[inline(always)]
fn ln_of_share<S: Simd>(simd: S, word: S::u64s) -> Lanes<S, f64> {
    const SIGNIFICAND: u64 = (1 << 52) - 1;
    /// The exponent, moved down by as much as moving in halves of 32 bits can.
    const EXPONENT: u64 = 0x7ff << 32;
    let lanes = |number| Lanes::<S, f64>::splat(simd, number);
    let one = lanes(1.0);
    let share = numbers(simd, word) + lanes(0.5);
    let bits = simd.transmute_u64s_f64s(share.register);
    let halves = bytemuck::cast(bits);
    let moved = simd.wrapping_dyn_shr_u32s(halves, simd.splat_u32s(20));
    let exponent = simd.and_u64s(bytemuck::cast(moved), simd.splat_u64s(EXPONENT));
    let exponent = numbers(simd, exponent).fused(lanes(1.0 / 4_294_967_296.0), lanes(-1055.0));
    let significand = simd.or_u64s(
        simd.and_u64s(bits, simd.splat_u64s(SIGNIFICAND)),
        simd.splat_u64s(1_f64.to_bits()),
    );
    let significand = Lanes {
        simd,
        register: simd.transmute_f64s_u64s(significand),
    };
    let limit = simd.splat_f64s(core::f64::consts::SQRT_2);
    let is_large = simd.greater_than_f64s(significand.register, limit);
    let choose = |large: Lanes<S, f64>, small: Lanes<S, f64>| Lanes {
        simd,
        register: simd.select_f64s(is_large, large.register, small.register),
    };
    let m = choose(significand * lanes(0.5), significand);
    let exponent = choose(exponent + one, exponent);
    let s = (m - one) * (m + one).inverse();
    let series = polynomial(
        s * s,
        [1.0 / 11.0, 1.0 / 9.0, 1.0 / 7.0, 1.0 / 5.0, 1.0 / 3.0, 1.0],
    );
    exponent.fused(lanes(core::f64::consts::LN_2), (s + s) * series)
}

/// A direction of the circle: an angle between -pi/2 and pi/2 from 31 bits, the opposite one where the last bit says so. The
/// series err by less than 1e-9.
#[inline(always)]
fn direction<S: Simd>(simd: S, word: S::u64s) -> [Lanes<S, f64>; 2] {
    use core::f64::consts::PI;
    let lanes = |number| Lanes::<S, f64>::splat(simd, number);
    let halved = simd.wrapping_dyn_shr_u32s(bytemuck::cast(word), simd.splat_u32s(1));
    let last_bit = numbers(simd, simd.and_u64s(word, simd.splat_u64s(1)));
    let angle = (numbers(simd, bytemuck::cast(halved)) + lanes(0.5))
        .fused(lanes(PI / 2_147_483_648.0), lanes(-0.5 * PI));
    let square = angle * angle;
    let sine = polynomial(square, const { of_factorials::<7>(3) });
    let cosine = polynomial(square, const { of_factorials::<8>(2) });
    let sign = last_bit.fused(lanes(-2.0), lanes(1.0));
    [sign * cosine, sign * (angle * sine)]
}

/// The series 1 - x/(n (n-1)) + ..., the highest first: of the sine over its angle with n = 3, of the cosine with n = 2.
const fn of_factorials<const N: usize>(first: u32) -> [f64; N] {
    let mut series = [1.0; N];
    let mut k = N - 1;
    while k > 0 {
        let n = (2 * (N - 1 - k) as u32 + first) as f64;
        series[k - 1] = -series[k] / (n * (n - 1.0));
        k -= 1;
    }
    series
}

/// The first `count` standard normal numbers of a run: those that [`monte_carlo`](super::monte_carlo) adds, scaled, to its headings.
pub fn normals_of_run(seed: u64, run: u64, count: usize) -> Vec<f64> {
    Arch::new().dispatch(Drawing { seed, run, count })
}

struct Drawing {
    seed: u64,
    run: u64,
    count: usize,
}

impl WithSimd for Drawing {
    type Output = Vec<f64>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Vec<f64> {
        let mut drawn = Vec::with_capacity(self.count.next_multiple_of(BLOCK * COUNTERS));
        let mut block = 0;
        while drawn.len() < self.count {
            let blocks = core::array::from_fn(|j| block + j as u64);
            let numbers = normals(simd, self.seed, &[self.run; COUNTERS], &blocks);
            drawn.extend((0..COUNTERS).flat_map(|j| numbers.map(|of_word| of_word[j])));
            block += COUNTERS as u64;
        }
        drawn.truncate(self.count);
        drawn
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pulp::Scalar;

    /// The authors' known answers for seven rounds (kat_vectors of Random123).
    #[test]
    fn val_philox_gives_its_authors_numbers() {
        let zero = philox(0, &[0], &[0]).map(|word| word[0]);
        assert_eq!(zero, [0x5f6f_b709, 0x0d89_3f64, 0x4f12_1f81, 0x4f73_0a48]);
        let ones = philox(u64::MAX, &[u64::MAX], &[u64::MAX]).map(|word| word[0]);
        assert_eq!(ones, [0x5207_ddc2, 0x4516_5e59, 0x4d8e_e751, 0x8c52_f662]);
    }

    #[test]
    fn exact_logarithm_and_direction() {
        for word in [0, 1, 2, 77, 0x7fff_ffff, 0x8000_0001, 0xb504_f333, LOW] {
            let share = (word as f64 + 0.5) / 4_294_967_296.0;
            // The first term of the series that is left out, 2 s^13/13.
            assert!(
                (ln_of_share(Scalar, word).register - share.ln()).abs() < 2e-11,
                "{word}"
            );
            let angle = core::f64::consts::PI
                * (((word >> 1) as f64 + 0.5) / 2_147_483_648.0 - 0.5 + (word & 1) as f64);
            let [x, y] = direction(Scalar, word).map(|lane| lane.register);
            // Likewise, (pi/2)^15/15!.
            assert!(
                (x - angle.cos()).abs() < 1e-9 && (y - angle.sin()).abs() < 1e-9,
                "{word}"
            );
        }
    }

    #[test]
    fn prop_normal_numbers_have_their_moments() {
        let count = 1_000_000;
        let drawn = normals_of_run(3, 5, count);
        let moment = |power: i32| drawn.iter().map(|z| z.powi(power)).sum::<f64>() / count as f64;
        // Five standard deviations of each mean: sqrt(Var z^n / 1e6).
        for (power, expected, deviation) in
            [(1, 0.0, 1.0), (2, 1.0, 2.0), (3, 0.0, 15.0), (4, 3.0, 96.0)]
        {
            let found: f64 = moment(power);
            assert!(
                (found - expected).abs() < 5e-3 * f64::sqrt(deviation),
                "{power}: {found}"
            );
        }
        let neighbours = drawn.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>();
        assert!(neighbours.abs() < 5.0 * f64::sqrt(count as f64));
        let beyond = drawn.iter().filter(|z| z.abs() > 3.0).count() as f64;
        // 0.27 % of a million, and five times its root.
        assert!((beyond - 2700.0).abs() < 260.0, "{beyond}");
    }
}
