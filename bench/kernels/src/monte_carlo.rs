//! Many noisy runs of one manoeuvre, drawn, filtered and summed without being stored.

use pulp::{Arch, Scalar, Simd, WithSimd};
use seatrial_core::InvalidSetting;
use seatrial_core::fixed_rate::FixedRateSettings;

use crate::Sums;
use crate::lanes::{Filter, Lanes, Products, Single, State};
use crate::noise::{BLOCK, COUNTERS, normals};

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
    settings.check()?;
    let samples = runs.heading_rad.len().min(runs.rudder_rad.len());
    Ok(Arch::new().dispatch(Study {
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

impl WithSimd for Study<'_> {
    type Output = Vec<Sums>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Vec<Sums> {
        let lanes = Lanes::<S, f64>::COUNT;
        let blocks_at_once = COUNTERS / lanes;
        let c = self.filter.coefficients(simd);
        let deviation = Lanes::splat(simd, self.runs.heading_noise_rad);
        let samples = self.rudder_filtered();
        let mut all = Vec::new();
        for first_run in (0..self.runs.runs).step_by(lanes) {
            let run = core::array::from_fn(|j| first_run + (j % lanes) as u64);
            let mut products = Products::zero(simd);
            let mut ends: Option<[State<Lanes<S, f64>>; 2]> = None;
            for (at, samples) in samples.chunks(blocks_at_once * BLOCK).enumerate() {
                let block = core::array::from_fn(|j| (at * blocks_at_once + j / lanes) as u64);
                let drawn = if S::IS_SCALAR {
                    normals::<false>(self.runs.seed, &run, &block)
                } else {
                    normals::<true>(self.runs.seed, &run, &block)
                };
                for (k, (heading, rudder_filtered)) in samples.iter().enumerate() {
                    let drawn = &drawn[k % BLOCK][k / BLOCK * lanes..];
                    let heading =
                        Lanes::first_of(simd, drawn).fused(deviation, Lanes::splat(simd, *heading));
                    let [_, now] = ends.get_or_insert_with(|| {
                        let rudder = Lanes::splat(simd, 0.0);
                        [self.filter.started(simd, heading, rudder); 2]
                    });
                    now.turn(heading, &c);
                    now.rudder_twice = Lanes::splat(simd, *rudder_filtered);
                    products.add(now.outputs(&c));
                }
            }
            let here = (self.runs.runs - first_run).min(lanes as u64) as usize;
            all.extend((0..here).map(|j| {
                let sums = products.0.map(|lanes| lanes.numbers()[j]);
                let turned = ends.map_or([0.0; 2], |ends| {
                    let [first, last] = ends.map(|state| state.turning(j));
                    self.filter.turned(first, last)
                });
                Sums::scaled(turned, sums, samples.len(), &self.filter.scales)
            }));
        }
        all
    }
}

impl Study<'_> {
    /// The heading without noise and the filtered rudder, which is that of every run, at each sample.
    fn rudder_filtered(&self) -> Vec<(f64, f64)> {
        let c = self.filter.coefficients(Scalar);
        let mut state: Option<Single<f64>> = None;
        (self.heading_rad.iter().zip(self.rudder_rad))
            .map(|(heading, rudder)| {
                let rudder = Lanes::splat(Scalar, *rudder);
                match &mut state {
                    Some(now) => now.lay(rudder, &c),
                    None => state = Some(self.filter.started(Scalar, rudder, rudder)),
                }
                let filtered = state.map_or(0.0, |now| now.rudder_twice.register);
                (*heading, filtered)
            })
            .collect()
    }
}
