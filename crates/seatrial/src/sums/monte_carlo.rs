//! Many noisy runs of one manoeuvre, drawn, filtered and summed without being stored.

use seatrial_core::estimator::InvalidSetting;
use seatrial_core::fixed_rate::FixedRateSettings;

use super::Sums;
use super::lanes::{Filter, Lane, Products, State, Work, multiply_add};
use super::noise::{self, normals};

/// A manoeuvre whose heading is seen with white noise.
#[derive(Clone, Copy, Debug)]
pub struct NoisyRuns<'a> {
    /// The heading without noise, rad, unwrapped.
    pub heading_rad: &'a [f64],
    /// The rudder, rad.
    pub rudder_rad: &'a [f64],
    /// Standard deviation of the noise, rad.
    pub heading_noise_rad: f64,
    /// Which noise: run k of a seed has the same in every study, whatever the number of runs.
    pub seed: u64,
    /// How many.
    pub runs: u64,
}

/// The sums of every run: `sums.model(p)` is what least squares makes of it.
pub fn monte_carlo(
    settings: &FixedRateSettings<f64>,
    runs: &NoisyRuns,
) -> Result<Vec<Sums>, InvalidSetting> {
    settings.validate()?;
    let samples = runs.heading_rad.len().min(runs.rudder_rad.len());
    Ok(f64::dispatch(Study {
        filter: Filter::new(settings),
        heading_rad: &runs.heading_rad[..samples],
        rudder_rad: &runs.rudder_rad[..samples],
        runs,
    }))
}

struct Study<'a> {
    filter: Filter<f64>,
    heading_rad: &'a [f64],
    rudder_rad: &'a [f64],
    runs: &'a NoisyRuns<'a>,
}

impl Work<f64> for Study<'_> {
    type Output = Vec<Sums>;

    #[inline(always)]
    fn run<const N: usize, const FUSED: bool>(self) -> Vec<Sums> {
        let samples = self.heading_rad.len();
        let c = &self.filter.coefficients;
        let mut all = Vec::new();
        for first_run in (0..self.runs.runs).step_by(N) {
            let run = core::array::from_fn(|j| first_run + j as u64);
            let mut products = Products::<f64, N>::ZERO;
            let mut state: Option<State<f64, N>> = None;
            let blocks = (self.heading_rad.chunks(noise::BLOCK))
                .zip(self.rudder_rad.chunks(noise::BLOCK))
                .enumerate();
            for (block, (headings, rudders)) in blocks {
                let drawn = normals::<N, FUSED>(self.runs.seed, &run, &[block as u64; N]);
                for ((drawn, heading), rudder) in drawn.iter().zip(headings).zip(rudders) {
                    let heading = drawn.map(|z| {
                        multiply_add::<f64, FUSED>(z, self.runs.heading_noise_rad, *heading)
                    });
                    let rudder = [*rudder; N];
                    let now = state.insert(match state {
                        None => self.filter.started(&heading, &rudder),
                        Some(mut now) => {
                            now.advance::<FUSED>(&heading, &rudder, c);
                            now
                        }
                    });
                    products.add::<FUSED>(now, c);
                }
            }
            let here = (self.runs.runs - first_run).min(N as u64) as usize;
            all.extend((0..here).map(|j| {
                let lane = products.0.map(|sums| sums[j]);
                Sums::scaled(lane, samples, &self.filter.scales)
            }));
        }
        all
    }
}
