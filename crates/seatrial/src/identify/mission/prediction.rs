//! How well a model of an ordinary log predicts what it was not fitted to.
//!
//! A log of an hour wanders from any simulation. Here the filter follows the log, and from many instants on the model runs free for a horizon.

use super::columns::Run;
use super::fit::Fit;
use super::record::Legs;

/// The least horizon, s, and the horizon in time constants.
pub(in crate::identify) const LEAST_HORIZON_S: f64 = 30.0;
const TIME_CONSTANTS: f64 = 3.0;

/// The horizon is at most this part of the longest leg.
const PART: f64 = 0.25;

/// Free runs of a model over legs that it was not fitted to.
#[derive(Clone, Copy, Debug, Default)]
pub struct Prediction {
    /// Sums of squares: headings less their mean over the horizon, error of the model, error of a vehicle that keeps turning as it does now.
    heading_rad2: [f64; 3],
    /// Yaw rates less their mean over the horizon, error of the model.
    yaw_rate: [f64; 2],
    /// Comparisons.
    pub samples: usize,
    /// How far the model runs free, s.
    pub horizon_s: f64,
}

impl Prediction {
    /// Over these legs.
    pub fn of(fit: &Fit, legs: &Legs, yaw_rate_rad_s: f64) -> Self {
        let wanted_s = LEAST_HORIZON_S.max(TIME_CONSTANTS / fit.point.vehicle.damping_per_s);
        let horizon_s = wanted_s.min(PART * legs.longest_s());
        let horizon = ((horizon_s / legs.interval_s) as usize).max(2);
        let mut prediction = Self { horizon_s, ..Self::default() };
        for leg in &legs.legs {
            let mut run = Run::<6>::new(leg, &fit.point, legs.interval_s, yaw_rate_rad_s);
            for i in 0..leg.len() {
                run.measure(i, |_, _| {});
                // The filter has settled after a horizon.
                let begins =
                    i >= horizon && i % (horizon / 2).max(1) == 0 && i + horizon < leg.len();
                if begins {
                    let free = run.free(i, i + horizon, &fit.linear);
                    let rates = (!leg.yaw_rate_rad_s.is_empty())
                        .then(|| &leg.yaw_rate_rad_s[i..=i + horizon]);
                    prediction.take(
                        &free,
                        &leg.time_s[i..=i + horizon],
                        &leg.heading_rad[i..=i + horizon],
                        rates,
                        fit.linear[2],
                    );
                }
                run.advance(i);
            }
        }
        prediction
    }

    fn take(
        &mut self,
        free: &[[f64; 2]],
        time_s: &[f64],
        heading_rad: &[f64],
        rates: Option<&[f64]>,
        bias_rad_s: f64,
    ) {
        let count = free.len() as f64;
        let mean = heading_rad.iter().sum::<f64>() / count;
        for (k, [psi, _]) in free.iter().enumerate() {
            let on = free[0][0] + free[0][1] * (time_s[k] - time_s[0]);
            self.heading_rad2[0] += (heading_rad[k] - mean).powi(2);
            self.heading_rad2[1] += (heading_rad[k] - psi).powi(2);
            self.heading_rad2[2] += (heading_rad[k] - on).powi(2);
        }
        if let Some(rates) = rates {
            let mean = rates.iter().sum::<f64>() / count;
            for ([_, r], rate) in free.iter().zip(rates) {
                self.yaw_rate[0] += (rate - mean).powi(2);
                self.yaw_rate[1] += (rate - bias_rad_s - r).powi(2);
            }
        }
        self.samples += free.len();
    }

    /// R^2 of the heading over the horizon. `None` where nothing was predicted.
    pub fn r2_heading(&self) -> Option<f64> {
        let [all, left, _] = self.heading_rad2;
        (all > 0.0).then(|| 1.0 - left / all)
    }

    /// R^2 of the yaw rate, where one is measured.
    pub fn r2_yaw_rate(&self) -> Option<f64> {
        let [all, left] = self.yaw_rate;
        (all > 0.0).then(|| 1.0 - left / all)
    }

    /// Share of the error of "keeps turning as now" that the model leaves.
    pub fn share_of_persistence(&self) -> f64 {
        let [_, left, persistence] = self.heading_rad2;
        left / persistence
    }
}
