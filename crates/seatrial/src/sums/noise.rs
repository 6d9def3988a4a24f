//! Normal random numbers that are a function of where they are used.

use super::lanes::{Lane, Work, multiply_add};

/// Numbers that one block of the generator gives.
pub(super) const BLOCK: usize = 4;

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

/// Four standard normal numbers for each lane's run and block: Box and Muller's transformation of pairs of words.
#[inline(always)]
pub(super) fn normals<const N: usize, const FUSED: bool>(
    seed: u64,
    run: &[u64; N],
    block: &[u64; N],
) -> [[f64; N]; BLOCK] {
    let words = philox(seed, run, block);
    let mut normals = [[0.0; N]; BLOCK];
    for pair in 0..BLOCK / 2 {
        for j in 0..N {
            let radius = (-2.0 * ln_of_share::<FUSED>(words[2 * pair][j])).sqrt();
            let [x, y] = direction::<FUSED>(words[2 * pair + 1][j]);
            normals[2 * pair][j] = radius * x;
            normals[2 * pair + 1][j] = radius * y;
        }
    }
    normals
}

/// An integer below 2^52 as a number: its bits stand behind those of 2^52.
#[inline(always)]
fn number(integer: u64) -> f64 {
    const OFFSET: f64 = (1_u64 << 52) as f64;
    f64::from_bits(OFFSET.to_bits() | integer) - OFFSET
}

/// ln((word + 1/2)/2^32), to 1e-11: 2 artanh(s) of the significand m, s = (m - 1)/(m + 1), |s| < 0.18.
#[inline(always)]
fn ln_of_share<const FUSED: bool>(word: u64) -> f64 {
    const SIGNIFICAND: u64 = (1 << 52) - 1;
    let bits = (number(word) + 0.5).to_bits();
    let exponent = number(bits >> 52) - 1023.0 - 32.0;
    let significand = f64::from_bits((bits & SIGNIFICAND) | 1_f64.to_bits());
    let is_large = significand > core::f64::consts::SQRT_2;
    let m = if is_large {
        0.5 * significand
    } else {
        significand
    };
    let exponent = if is_large { exponent + 1.0 } else { exponent };
    let s = (m - 1.0) / (m + 1.0);
    let square = s * s;
    let mut series = 1.0 / 11.0;
    for odd in [9.0, 7.0, 5.0, 3.0, 1.0] {
        series = multiply_add::<f64, FUSED>(series, square, 1.0 / odd);
    }
    multiply_add::<f64, FUSED>(exponent, core::f64::consts::LN_2, 2.0 * s * series)
}

/// A direction of the circle: an angle between -pi/2 and pi/2 from 31 bits, the opposite one where the last bit says so. The
/// series err by less than 1e-9.
#[inline(always)]
fn direction<const FUSED: bool>(word: u64) -> [f64; 2] {
    use core::f64::consts::PI;
    let angle =
        multiply_add::<f64, FUSED>(number(word >> 1) + 0.5, PI / 2_147_483_648.0, -0.5 * PI);
    let square = angle * angle;
    let (mut sine, mut cosine) = (1.0, 1.0);
    for k in [6.0, 5.0, 4.0, 3.0, 2.0, 1.0] {
        sine = multiply_add::<f64, FUSED>(sine, -square / (2.0 * k * (2.0 * k + 1.0)), 1.0);
    }
    for k in [7.0, 6.0, 5.0, 4.0, 3.0, 2.0, 1.0] {
        cosine = multiply_add::<f64, FUSED>(cosine, -square / (2.0 * k * (2.0 * k - 1.0)), 1.0);
    }
    let sign = f64::from_bits(1_f64.to_bits() | (word << 63));
    [sign * cosine, sign * (angle * sine)]
}

/// The first `count` standard normal numbers of a run: those that [`monte_carlo`](super::monte_carlo) adds, scaled, to its headings.
pub fn normals_of_run(seed: u64, run: u64, count: usize) -> Vec<f64> {
    f64::dispatch(Drawing { seed, run, count })
}

struct Drawing {
    seed: u64,
    run: u64,
    count: usize,
}

impl Work<f64> for Drawing {
    type Output = Vec<f64>;

    #[inline(always)]
    fn run<const N: usize, const FUSED: bool>(self) -> Vec<f64> {
        let mut drawn = Vec::with_capacity(self.count.next_multiple_of(BLOCK * N));
        let mut block = 0;
        while drawn.len() < self.count {
            let blocks = core::array::from_fn(|j| block + j as u64);
            let lanes = normals::<N, FUSED>(self.seed, &[self.run; N], &blocks);
            drawn.extend((0..N).flat_map(|j| lanes.map(|lane| lane[j])));
            block += N as u64;
        }
        drawn.truncate(self.count);
        drawn
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
                (ln_of_share::<true>(word) - share.ln()).abs() < 2e-11,
                "{word}"
            );
            let angle = core::f64::consts::PI
                * (((word >> 1) as f64 + 0.5) / 2_147_483_648.0 - 0.5 + (word & 1) as f64);
            let [x, y] = direction::<false>(word);
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
