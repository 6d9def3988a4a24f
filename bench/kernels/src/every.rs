//! Theta after every sample of a long record.

use pulp::{Arch, Simd, WithSimd};
use seatrial_core::InvalidSetting;
use seatrial_core::fixed_rate::FixedRateSettings;

use crate::lanes::{Coefficients, Filter, Lanes, MOST_LANES, Products, Scales, State};

/// Samples that are filtered before their instants are solved.
const BLOCK: usize = 32;

/// Theta_k = [a22, b2, C0] of the recursion after every sample: what
/// [`FixedRateEstimator`](seatrial_core::FixedRateEstimator) gives from the sums so far, a register full of instants at a time.
/// Until the vehicle is excited it is what the ridge 1/P0 makes of it, as in the recursion, and rounding has its say.
///
/// They take the place of what `thetas` holds: a vector that is used again takes two thirds of the time of a new one, whose memory
/// the machine has to clear.
pub fn every_theta(
    settings: &FixedRateSettings<f64>,
    heading_rad: &[f64],
    rudder_rad: &[f64],
    thetas: &mut Vec<[f64; 3]>,
) -> Result<(), InvalidSetting> {
    settings.check()?;
    let count = heading_rad.len().min(rudder_rad.len());
    thetas.resize(count, [0.0; 3]);
    Arch::new().dispatch(Every {
        filter: Filter::new(settings),
        ridge: 1.0 / settings.initial_covariance,
        heading_rad: &heading_rad[..count],
        rudder_rad: &rudder_rad[..count],
        thetas,
    });
    Ok(())
}

struct Every<'a> {
    filter: Filter<f64>,
    ridge: f64,
    heading_rad: &'a [f64],
    rudder_rad: &'a [f64],
    thetas: &'a mut [[f64; 3]],
}

impl WithSimd for Every<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self {
            filter,
            ridge,
            heading_rad: [first_heading, heading @ ..],
            rudder_rad: [first_rudder, rudder @ ..],
            thetas: [first_theta, thetas @ ..],
        } = self
        else {
            return;
        };
        let all = |number| Lanes::splat(simd, number);
        let mut running = Running {
            state: filter.started(simd, all(*first_heading), all(*first_rudder)),
            coefficients: filter.coefficients(simd),
        };
        let mut sums = Sums::of_ridge(simd, ridge, &filter.scales);
        let ridge = Ridge::new(simd, ridge, &filter.scales);
        sums.add(running.state.outputs(&running.coefficients));
        let solved = ridge.solve(&sums, all(1.0) + ridge.one);
        for (theta, solved) in first_theta.iter_mut().zip(solved) {
            *theta = solved.numbers()[0];
        }

        let mut before = sums.first_lane();
        let mut samples = 1;
        let mut filtered = Filtered([[0.0; BLOCK]; 3]);
        let (headings, rest_of_heading) = heading.as_chunks();
        let (rudders, rest_of_rudder) = rudder.as_chunks();
        let (blocks, rest) = thetas.as_chunks_mut();
        let [mut last_heading, mut last_rudder] = [[0.0; BLOCK]; 2];
        last_heading[..rest.len()].copy_from_slice(rest_of_heading);
        last_rudder[..rest.len()].copy_from_slice(rest_of_rudder);
        let mut last = [[0.0; 3]; BLOCK];
        let headings = headings.iter().chain([&last_heading]);
        let rudders = rudders.iter().chain([&last_rudder]);
        let blocks = blocks.iter_mut().chain([&mut last]);
        for ((heading, rudder), thetas) in headings.zip(rudders).zip(blocks) {
            running.filter(simd, heading, rudder, &mut filtered);
            ridge.solve_block(
                simd,
                &running.coefficients,
                &filtered,
                &mut before,
                samples,
                thetas,
            );
            samples += BLOCK;
        }
        rest.copy_from_slice(&last[..rest.len()]);
    }
}

/// The filters of one record, the same in every lane.
struct Running<V> {
    state: State<V>,
    coefficients: Coefficients<V>,
}

/// u, v and p after each sample of a block, one behind the other.
#[repr(align(64))]
struct Filtered([[f64; BLOCK]; 3]);

impl<S: Simd> Running<Lanes<S, f64>> {
    #[inline(always)]
    fn filter(
        &mut self,
        simd: S,
        heading: &[f64; BLOCK],
        rudder: &[f64; BLOCK],
        Filtered([deviations, lags, rudders]): &mut Filtered,
    ) {
        let mut state = self.state;
        for four in (0..BLOCK).step_by(4) {
            for k in four..four + 4 {
                state.turn(Lanes::splat(simd, heading[k]), &self.coefficients);
                state.lay(Lanes::splat(simd, rudder[k]), &self.coefficients);
                deviations[k] = state.deviation.numbers()[0];
                lags[k] = state.lag.numbers()[0];
                rudders[k] = state.rudder_twice.numbers()[0];
            }
        }
        self.state = state;
    }
}

/// Sums of v and u', of p and v^2, then of v p, p^2, v u' and p u'.
type Fours<T> = [[T; 4]; 2];

/// The sums in every lane.
#[derive(Clone, Copy)]
struct Sums<V> {
    /// Of v and u'.
    turned: [V; 2],
    products: Products<V>,
}

impl<S: Simd> Sums<Lanes<S, f64>> {
    #[inline(always)]
    fn new([[v, u, p, vv], [vp, pp, vu, pu]]: Fours<Lanes<S, f64>>) -> Self {
        Self {
            turned: [v, u],
            products: Products([p, vv, vp, pp, vu, pu]),
        }
    }

    /// Before the first sample.
    #[inline(always)]
    fn of_ridge(simd: S, ridge: f64, scales: &Scales) -> Self {
        let lanes = |number| Lanes::splat(simd, number);
        let zero = lanes(0.0);
        let of_rate = lanes(ridge / (scales.rate * scales.rate));
        let of_rudder = lanes(ridge / (scales.rudder * scales.rudder));
        Self::new([[zero, zero, zero, of_rate], [zero, of_rudder, zero, zero]])
    }

    #[inline(always)]
    fn fours(&self) -> Fours<Lanes<S, f64>> {
        let ([v, u], [p, vv, vp, pp, vu, pu]) = (self.turned, self.products.0);
        [[v, u, p, vv], [vp, pp, vu, pu]]
    }

    #[inline(always)]
    fn first_lane(&self) -> Fours<f64> {
        let mut first = [[0.0; 4]; 2];
        for (first, sums) in first.iter_mut().zip(self.fours()) {
            for (first, sum) in first.iter_mut().zip(sums) {
                *first = sum.numbers()[0];
            }
        }
        first
    }

    /// Adds what the filters of every lane give now.
    #[inline(always)]
    fn add(&mut self, outputs: [Lanes<S, f64>; 3]) {
        let [v, _, u] = outputs;
        let [sum_v, sum_u] = self.turned;
        self.turned = [sum_v + v, sum_u + u];
        self.products.add(outputs);
    }

    /// From the sums of each row, one a lane, and those before the first row, which become those after the last: those before
    /// each row.
    #[inline(always)]
    fn before(&self, simd: S, [first, second]: &mut Fours<f64>) -> Self {
        let [first_sums, second_sums] = self.fours();
        Self::new([
            four_before(simd, first_sums, first),
            four_before(simd, second_sums, second),
        ])
    }
}

/// Four of the sums of [`Sums::before`].
#[inline(always)]
fn four_before<S: Simd>(
    simd: S,
    sums: [Lanes<S, f64>; 4],
    before: &mut [f64; 4],
) -> [Lanes<S, f64>; 4] {
    let mut rows = [[0.0; 4]; MOST_LANES];
    Lanes::rows(sums, |row, four| {
        rows[row] = *before;
        for (before, sum) in before.iter_mut().zip(four) {
            *before += sum;
        }
    });
    Lanes::columns(simd, |row| &rows[row])
}

/// The ridge regression from scaled sums.
struct Ridge<V> {
    one: V,
    /// What takes scaled parameters to those of the model.
    theta: [V; 3],
}

impl<S: Simd> Ridge<Lanes<S, f64>> {
    #[inline(always)]
    fn new(simd: S, ridge: f64, scales: &Scales) -> Self {
        let lanes = |number| Lanes::splat(simd, number);
        Self {
            one: lanes(ridge),
            theta: [
                lanes(scales.acceleration / scales.rate),
                lanes(scales.acceleration / scales.rudder),
                lanes(scales.acceleration),
            ],
        }
    }

    /// Rows of four samples side by side, one a lane; before the first there are `samples`, whose sums are `before`.
    #[inline(always)]
    fn solve_block(
        &self,
        simd: S,
        coefficients: &Coefficients<Lanes<S, f64>>,
        Filtered([deviations, lags, rudders]): &Filtered,
        before: &mut Fours<f64>,
        samples: usize,
        thetas: &mut [[f64; 3]; BLOCK],
    ) {
        let order = Lanes::<S, f64>::order(simd);
        let all = |number| Lanes::splat(simd, number);
        let mut n = Lanes::from_fn(simd, |lane| (samples + 4 * order[lane]) as f64) + self.one;
        let together = 4 * S::F64_LANES;
        for (at, thetas) in thetas.chunks_exact_mut(together).enumerate() {
            let from = |row: usize| at * together + 4 * row;
            let u = Lanes::columns(simd, |row| &deviations[from(row)..][..4]);
            let v = Lanes::columns(simd, |row| &lags[from(row)..][..4]);
            let p = Lanes::columns(simd, |row| &rudders[from(row)..][..4]);
            let mut outputs = [[all(0.0); 3]; 4];
            let mut rows = Sums::new([[all(0.0); 4]; 2]);
            for (k, outputs) in outputs.iter_mut().enumerate() {
                *outputs = [v[k], p[k], coefficients.accelerating(u[k], v[k])];
                rows.add(*outputs);
            }
            let mut sums = rows.before(simd, before);
            let mut now = n;
            let mut solved = [all(0.0); 12];
            for (outputs, solved) in outputs.into_iter().zip(solved.as_chunks_mut().0) {
                sums.add(outputs);
                now = now + all(1.0);
                *solved = self.solve(&sums, now);
            }
            let numbers = thetas.as_flattened_mut();
            for (i, four) in solved.as_chunks().0.iter().enumerate() {
                Lanes::rows(*four, |row, four| {
                    numbers[12 * row + 4 * i..][..4].copy_from_slice(four);
                });
            }
            n = n + all(together as f64);
        }
    }

    /// The normal equations with the constant eliminated first, which centres the sums.
    #[inline(always)]
    fn solve(&self, sums: &Sums<Lanes<S, f64>>, n: Lanes<S, f64>) -> [Lanes<S, f64>; 3] {
        let ([v, u], [p, vv, vp, pp, vu, pu]) = (sums.turned, sums.products.0);
        let over_n = n.inverse();
        let (rate, rudder, acceleration) = (v * over_n, p * over_n, u * over_n);
        let a = vv.less(rate, v);
        let b = vp.less(rate, p);
        let c = pp.less(rudder, p);
        let y = vu.less(rate, u);
        let z = pu.less(rudder, u);
        let over_determinant = (a * c).less(b, b).inverse();
        let of_rate = (y * c).less(z, b) * over_determinant;
        let of_rudder = (z * a).less(y, b) * over_determinant;
        let rest = acceleration.less(of_rate, rate).less(of_rudder, rudder);
        let [to_rate, to_rudder, to_one] = self.theta;
        [of_rate * to_rate, of_rudder * to_rudder, rest * to_one]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parity_a_machine_without_registers_for_several_numbers_finds_the_same() {
        let settings = FixedRateSettings::paper(0.05);
        let heading: Vec<f64> = (0..300).map(|k| (f64::from(k) / 31.0).sin()).collect();
        let rudder: Vec<f64> = (0..300).map(|k| (f64::from(k) / 17.0).cos()).collect();
        let mut expected = Vec::new();
        every_theta(&settings, &heading, &rudder, &mut expected).unwrap();
        let mut thetas = vec![[0.0; 3]; 300];
        let every = Every {
            filter: Filter::new(&settings),
            ridge: 1.0 / settings.initial_covariance,
            heading_rad: &heading,
            rudder_rad: &rudder,
            thetas: &mut thetas,
        };
        every.with_simd(pulp::Scalar);
        for (k, (found, expected)) in thetas.iter().zip(expected).enumerate().skip(60) {
            for (found, expected) in found.iter().zip(expected) {
                let apart = (found - expected).abs();
                assert!(apart < 1e-9, "{k}: {found} {expected}");
            }
        }
    }
}
