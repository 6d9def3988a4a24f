//! Normal random numbers that are a function of where they are used.

use pulp::{Arch, Simd, WithSimd};

/// Numbers that one block of the generator gives.
pub(crate) const BLOCK: usize = 4;

/// Blocks that are drawn at a time.
pub(crate) const COUNTERS: usize = 16;

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

/// Four standard normal numbers for each counter: Box and Muller's transformation of pairs of words, to 24 bits. `FUSED`: a
/// multiply-add is as fast as a multiplication.
#[inline(always)]
pub(crate) fn normals<const FUSED: bool>(
    seed: u64,
    run: &[u64; COUNTERS],
    block: &[u64; COUNTERS],
) -> [[f64; COUNTERS]; BLOCK] {
    let words = philox(seed, run, block);
    let mut normals = [[0.0; COUNTERS]; BLOCK];
    for (words, normals) in words.as_chunks().0.iter().zip(normals.as_chunks_mut().0) {
        let [of_radius, of_direction]: &[[u64; COUNTERS]; 2] = words;
        let [cosines, sines]: &mut [[f64; COUNTERS]; 2] = normals;
        for j in 0..COUNTERS {
            let radius = (-2.0 * ln_of_share::<FUSED>(of_radius[j] as u32)).sqrt();
            let [x, y] = direction::<FUSED>(of_direction[j] as u32);
            cosines[j] = f64::from(radius * x);
            sines[j] = f64::from(radius * y);
        }
    }
    normals
}

/// a b + c
#[inline(always)]
fn multiply_add<const FUSED: bool>(a: f32, b: f32, c: f32) -> f32 {
    if FUSED { a.mul_add(b, c) } else { a * b + c }
}

/// ln((word + 1/2)/2^32): 2 artanh(s) of the significand m, s = (m - 1)/(m + 1), |s| < 0.18, to s^9.
#[inline(always)]
fn ln_of_share<const FUSED: bool>(word: u32) -> f32 {
    const SIGNIFICAND: u32 = (1 << 23) - 1;
    let bits = (word as f32 + 0.5).to_bits();
    let exponent = (bits >> 23) as f32 - (127.0 + 32.0);
    let significand = f32::from_bits((bits & SIGNIFICAND) | 1_f32.to_bits());
    let is_large = significand > core::f32::consts::SQRT_2;
    let m = if is_large {
        0.5 * significand
    } else {
        significand
    };
    let exponent = if is_large { exponent + 1.0 } else { exponent };
    let s = (m - 1.0) / (m + 1.0);
    let artanh = series::<5, FUSED>(s * s, [1.0 / 9.0, 1.0 / 7.0, 1.0 / 5.0, 1.0 / 3.0, 1.0]);
    multiply_add::<FUSED>(exponent, core::f32::consts::LN_2, 2.0 * s * artanh)
}

/// A direction of the circle: an angle between -pi/2 and pi/2 from 31 bits, the opposite one where the last bit says so. The
/// series err by less than 1e-7.
#[inline(always)]
fn direction<const FUSED: bool>(word: u32) -> [f32; 2] {
    use core::f32::consts::{FRAC_PI_2, PI};
    let angle = multiply_add::<FUSED>((word >> 1) as f32 + 0.5, PI / 2_147_483_648.0, -FRAC_PI_2);
    let square = angle * angle;
    let sine = series::<6, FUSED>(square, const { of_factorials(3) });
    let cosine = series::<7, FUSED>(square, const { of_factorials(2) });
    let sign = f32::from_bits(1_f32.to_bits() | (word << 31));
    [sign * cosine, sign * (angle * sine)]
}

/// c_0 x^(N-1) + ... + c_(N-1).
#[inline(always)]
fn series<const N: usize, const FUSED: bool>(x: f32, c: [f32; N]) -> f32 {
    let mut sum = c[0];
    for c in &c[1..] {
        sum = multiply_add::<FUSED>(sum, x, *c);
    }
    sum
}

/// The series 1 - x/(n (n-1)) + x^2/((n+2) (n+1) n (n-1)) - ..., the highest power first: of the sine over its angle with n = 3, of the cosine with
/// n = 2, x the square of the angle.
const fn of_factorials<const N: usize>(n: u32) -> [f32; N] {
    let mut series = [1.0; N];
    let mut power = 1;
    while power < N {
        let n = (n + 2 * (power as u32 - 1)) as f32;
        series[N - 1 - power] = -series[N - power] / (n * (n - 1.0));
        power += 1;
    }
    series
}

/// The first `count` standard normal numbers of a run: those that [`monte_carlo`](crate::monte_carlo) adds, scaled, to its headings.
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
    fn with_simd<S: Simd>(self, _simd: S) -> Vec<f64> {
        let mut drawn = Vec::with_capacity(self.count.next_multiple_of(BLOCK * COUNTERS));
        let mut block = 0;
        while drawn.len() < self.count {
            let blocks = core::array::from_fn(|j| block + j as u64);
            let run = [self.run; COUNTERS];
            let numbers = if S::IS_SCALAR {
                normals::<false>(self.seed, &run, &blocks)
            } else {
                normals::<true>(self.seed, &run, &blocks)
            };
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
    use statrs::distribution::{ContinuousCDF, Normal};

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
        for word in [0, 1, 2, 77, 0x7fff_ffff, 0x8000_0001, 0xb504_f333, u32::MAX] {
            let share = (f64::from(word) + 0.5) / 4_294_967_296.0;
            for found in [ln_of_share::<true>(word), ln_of_share::<false>(word)] {
                // Of the share, which is rounded to 24 bits, and three roundings of the logarithm.
                let tolerance = 6e-8 + 2e-7 * share.ln().abs();
                let apart = (f64::from(found) - share.ln()).abs();
                assert!(apart < tolerance, "{word}: {apart:e}");
            }
            let angle = core::f64::consts::PI
                * ((f64::from(word >> 1) + 0.5) / 2_147_483_648.0 - 0.5 + f64::from(word & 1));
            let [x, y] = direction::<false>(word).map(f64::from);
            // The angle, rounded to 24 bits of half a turn, and some roundings.
            assert!(
                (x - angle.cos()).abs() < 4e-7 && (y - angle.sin()).abs() < 4e-7,
                "{word}: {x} {y}"
            );
        }
    }

    /// Kolmogorov and Smirnov's distance from the normal distribution, of a million numbers of one run and of a million
    /// runs' first numbers.
    #[test]
    fn val_normal_numbers_are_normally_distributed() {
        let count = 1_000_000;
        let of_one_run = normals_of_run(3, 5, count);
        let of_many_runs = (0..count as u64 / 4).flat_map(|run| normals_of_run(8, run, 4));
        for mut drawn in [of_one_run, of_many_runs.collect()] {
            drawn.sort_by(f64::total_cmp);
            let normal = Normal::standard();
            let distance = (drawn.iter().enumerate())
                .map(|(k, z)| ((k as f64 + 0.5) / count as f64 - normal.cdf(*z)).abs())
                .fold(0.0, f64::max);
            // Exceeded once in ten thousand samples: 2 exp(-2 n D^2) = 1e-4.
            assert!(distance < 2.23e-3, "{distance}");
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
        // So many of a million, and five times the root.
        for (limit, expected) in [
            (1.0, 317_311.0),
            (2.0, 45_500.0),
            (3.0, 2700.0),
            (4.0, 63.3),
        ] {
            let beyond = drawn.iter().filter(|z| z.abs() > limit).count() as f64;
            let deviation = f64::sqrt(expected);
            assert!(
                (beyond - expected).abs() < 5.0 * deviation,
                "{limit}: {beyond}"
            );
        }
    }
}
