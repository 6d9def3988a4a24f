//! Theta after every sample of a long record.

use seatrial_core::estimator::InvalidSetting;
use seatrial_core::fixed_rate::FixedRateSettings;

use super::lanes::{Filter, Lane, Products, Scales, State, Work, multiply_add, transpose};
use super::long::{STRETCH, Stretches, side_by_side};

/// Theta_k = [a22, b2, C0] of the recursion after every sample: what
/// [`FixedRateEstimator`](seatrial_core::FixedRateEstimator) gives from the sums so far, eight instants at a time. Until the vehicle is excited it
/// is what the ridge 1/P0 makes of it, as in the recursion, and rounding has its say.
pub fn every_theta(
    settings: &FixedRateSettings<f64>,
    heading_rad: &[f64],
    rudder_rad: &[f64],
) -> Result<Vec<[f64; 3]>, InvalidSetting> {
    settings.validate()?;
    Ok(f64::dispatch(Every {
        filter: Filter::new(settings),
        ridge: 1.0 / settings.initial_covariance,
        heading_rad,
        rudder_rad,
    }))
}

struct Every<'a> {
    filter: Filter<f64>,
    ridge: f64,
    heading_rad: &'a [f64],
    rudder_rad: &'a [f64],
}

impl Work<f64> for Every<'_> {
    type Output = Vec<[f64; 3]>;

    #[inline(always)]
    fn run<const N: usize, const FUSED: bool>(self) -> Vec<[f64; 3]> {
        let count = self.heading_rad.len().min(self.rudder_rad.len());
        let (heading, rudder) = (&self.heading_rad[..count], &self.rudder_rad[..count]);
        let mut thetas = vec![[0.0; 3]; count];
        let (Some(&first_heading), Some(&first_rudder)) = (heading.first(), rudder.first()) else {
            return thetas;
        };
        let c = &self.filter.coefficients;
        let ridge = Ridge::new(self.ridge, &self.filter.scales);
        let stretches = Stretches::new(&self.filter);
        let mut now = self.filter.started(&[first_heading], &[first_rudder]);
        let mut sums = Products::<f64, 1>::ZERO;
        sums.add::<FUSED>(&now, c);
        let solved = ridge.solve::<1, FUSED>(&sums, &[1.0]);
        thetas[0] = solved.map(|lane| lane[0]);

        let mut at = 0;
        while at + N * STRETCH < count {
            let tile = at..at + N * STRETCH + 1;
            let (heading, rudder) = (&heading[tile.clone()], &rudder[tile.clone()]);
            let start = stretches.states::<N, FUSED>(&now, heading, rudder);
            let (end, whole) = side_by_side::<f64, N, FUSED>(start, heading, rudder, &self.filter);
            let before = sums_before(&sums, &whole);
            for (sum, lanes) in sums.0.iter_mut().zip(&whole.0) {
                sum[0] += lanes.iter().sum::<f64>();
            }
            ridge.stretches::<N, FUSED>(
                Begin {
                    state: start,
                    sums: before,
                    samples: std::array::from_fn(|j| (at + 1 + j * STRETCH) as f64),
                },
                (heading, rudder),
                c,
                &mut thetas[tile][1..],
            );
            now = end.last();
            at += N * STRETCH;
        }
        for k in at + 1..count {
            now.advance::<FUSED>(&[heading[k]], &[rudder[k]], c);
            sums.add::<FUSED>(&now, c);
            let solved = ridge.solve::<1, FUSED>(&sums, &[(k + 1) as f64]);
            thetas[k] = solved.map(|lane| lane[0]);
        }
        thetas
    }
}

/// The sums before each stretch from those before the tile and those of each stretch.
#[inline(always)]
fn sums_before<const N: usize>(
    before: &Products<f64, 1>,
    whole: &Products<f64, N>,
) -> Products<f64, N> {
    let mut sums = Products::ZERO;
    for ((sums, before), whole) in sums.0.iter_mut().zip(&before.0).zip(&whole.0) {
        let mut sum = before[0];
        for (lane, whole) in sums.iter_mut().zip(whole) {
            *lane = sum;
            sum += whole;
        }
    }
    sums
}

/// Where the stretches of a tile begin.
struct Begin<const N: usize> {
    state: State<f64, N>,
    sums: Products<f64, N>,
    samples: [f64; N],
}

/// The ridge regression from scaled sums.
struct Ridge {
    rate: f64,
    rudder: f64,
    one: f64,
    theta: [f64; 3],
}

impl Ridge {
    fn new(ridge: f64, scales: &Scales) -> Self {
        Self {
            rate: ridge / (scales.rate * scales.rate),
            rudder: ridge / (scales.rudder * scales.rudder),
            one: ridge,
            theta: [
                scales.acceleration / scales.rate,
                scales.acceleration / scales.rudder,
                scales.acceleration,
            ],
        }
    }

    /// Goes through the stretches again, now with the sums before them.
    #[inline(always)]
    fn stretches<const N: usize, const FUSED: bool>(
        &self,
        begin: Begin<N>,
        (heading, rudder): (&[f64], &[f64]),
        c: &super::lanes::Coefficients<f64>,
        thetas: &mut [[f64; 3]],
    ) {
        let Begin {
            mut state,
            mut sums,
            mut samples,
        } = begin;
        let mut headings = [[0.0; N]; STRETCH];
        let mut rudders = [[0.0; N]; STRETCH];
        transpose(heading[1..].chunks_exact(STRETCH), &mut headings);
        transpose(rudder[1..].chunks_exact(STRETCH), &mut rudders);
        for (i, (heading, rudder)) in headings.iter().zip(&rudders).enumerate() {
            state.advance::<FUSED>(heading, rudder, c);
            sums.add::<FUSED>(&state, c);
            for n in &mut samples {
                *n += 1.0;
            }
            let [a22, b2, c0] = self.solve::<N, FUSED>(&sums, &samples);
            for j in 0..N {
                thetas[j * STRETCH + i] = [a22[j], b2[j], c0[j]];
            }
        }
    }

    /// The normal equations with the constant eliminated first, which centres the sums, and one division.
    #[inline(always)]
    fn solve<const N: usize, const FUSED: bool>(
        &self,
        sums: &Products<f64, N>,
        samples: &[f64; N],
    ) -> [[f64; N]; 3] {
        let [r, d, y, rr, rd, dd, ry, dy] = &sums.0;
        let mut theta = [[0.0; N]; 3];
        let [a22, b2, c0] = &mut theta;
        for j in 0..N {
            let n = samples[j] + self.one;
            let centred =
                |product: f64, a: f64, b: f64| multiply_add::<f64, FUSED>(n, product, -(a * b));
            let a = centred(rr[j] + self.rate, r[j], r[j]);
            let b = centred(rd[j], r[j], d[j]);
            let c = centred(dd[j] + self.rudder, d[j], d[j]);
            let p = centred(ry[j], r[j], y[j]);
            let q = centred(dy[j], d[j], y[j]);
            let determinant = multiply_add::<f64, FUSED>(a, c, -(b * b));
            let inverse = 1.0 / (determinant * n);
            let over_determinant = inverse * n;
            let of_rate = multiply_add::<f64, FUSED>(p, c, -(q * b)) * over_determinant;
            let of_rudder = multiply_add::<f64, FUSED>(q, a, -(p * b)) * over_determinant;
            let rest = multiply_add::<f64, FUSED>(-of_rate, r[j], y[j]);
            let rest = multiply_add::<f64, FUSED>(-of_rudder, d[j], rest);
            a22[j] = of_rate * self.theta[0];
            b2[j] = of_rudder * self.theta[1];
            c0[j] = rest * (inverse * determinant) * self.theta[2];
        }
        theta
    }
}
