//! A rudder that lags without the log saying so: is there a sign of it, and what would it do to the model?

use seatrial_core::Sample;
use seatrial_core::refine::{DISTURBANCE_TIME_CONSTANTS, Disturbance, Peak};

use super::excited_segment::most_excited;
use super::record_series::{RecordSeries, RecordSpan};
use crate::identification::{LagEffect, Refined};
use crate::servo::Servo;
use crate::sway_yaw::ResidualTests;

/// The lag whose effect is reported, s: that of an ordinary servo.
const ORDINARY_LAG_S: f64 = 0.1;

/// Lags looked for, in time constants of the vehicle.
const LAGS: [f64; 3] = [0.05, 0.15, 0.4];

/// What a record says of a lag of the rudder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LagTest {
    /// Twice the log likelihood of the likeliest lag looked for, less that of none.
    pub likelihood_ratio: f64,
    /// Schwarz's price of a parameter, log n.
    pub price: f64,
    /// a22 and b2 by output error of a rudder that acts at once.
    prompt: [f64; 2],
    /// Tests of the prediction errors with a rudder that acts at once.
    pub residual: Option<ResidualTests>,
}

impl LagTest {
    /// Holds the record of a training against a rudder that lags.
    ///
    /// ```text
    /// LR = 2 max over T_d, D of l(a22_hat; D, T_d) - 2 max over D of l(a22_hat; D, 0)
    /// ```
    ///
    /// with l the restricted log likelihood of [`RecordSeries::fit`](RecordSeries::fit), T_d the lag of a
    /// [`Servo`] and D a disturbance: none, or one of the strength that the refined estimate found, because a lag that is
    /// taken for a disturbance needs none. `None` where there is no peak.
    pub fn of(samples: &[Sample<f64>], refined: &Refined) -> Option<Self> {
        let samples = most_excited(samples);
        let span = RecordSpan::of(samples).ok()?;
        let start_per_s = refined.model.a22_per_s;
        let scale = span.rate_scale(start_per_s);
        let behind = |lag_s| behind(&span, samples, lag_s, start_per_s);
        let peak = |record: &RecordSeries, disturbance: Disturbance| {
            Peak::find(&record.series(), disturbance, start_per_s, scale)
        };
        let likelier = |a: Option<Peak>, b: Option<Peak>| {
            a.into_iter()
                .chain(b)
                .max_by(|a, b| a.fit.log_likelihood.total_cmp(&b.fit.log_likelihood))
        };
        let record = behind(0.0)?;
        let prompt = peak(&record, Disturbance::NONE)?;
        let relative = refined.disturbance_rad_s2 / refined.heading_noise_rad;
        let none = DISTURBANCE_TIME_CONSTANTS
            .map(|ratio| Disturbance {
                relative,
                time_constant_s: ratio / scale,
            })
            .iter()
            .map(|disturbance| peak(&record, *disturbance))
            .fold(Some(prompt), likelier)?;
        let lagging = LAGS
            .iter()
            .filter_map(|lag| {
                let record = behind(lag / scale)?;
                let calm = peak(&record, Disturbance::NONE);
                likelier(peak(&record, none.disturbance), calm)
            })
            .map(|peak| peak.fit.log_likelihood)
            .fold(f64::NEG_INFINITY, f64::max);
        Some(Self {
            likelihood_ratio: 2.0 * (lagging - none.fit.log_likelihood),
            price: (record.blocks() as f64).ln(),
            prompt: [prompt.a22_per_s, prompt.fit.linear[0]],
            residual: ResidualTests::of(
                &record.innovations(none.a22_per_s, none.disturbance, &none.fit),
                &record.mean_rudder_rad(),
            ),
        })
    }

    /// What a lag of 0.1 s would do to the model, by output error, which fits the whole manoeuvre.
    pub fn effect_of_an_ordinary_lag(
        &self,
        samples: &[Sample<f64>],
        refined: &Refined,
    ) -> Option<LagEffect> {
        let samples = most_excited(samples);
        let span = RecordSpan::of(samples).ok()?;
        let start_per_s = refined.model.a22_per_s;
        let record = behind(&span, samples, ORDINARY_LAG_S, start_per_s)?;
        let scale = span.rate_scale(start_per_s);
        let lagging = Peak::find(&record.series(), Disturbance::NONE, start_per_s, scale)?;
        let [a22_per_s, b2_per_s2] = self.prompt;
        Some(LagEffect {
            lag_s: ORDINARY_LAG_S,
            a22_per_s: refined.model.a22_per_s + lagging.a22_per_s - a22_per_s,
            b2_per_s2: refined.model.b2_per_s2 + lagging.fit.linear[0] - b2_per_s2,
        })
    }

    /// Is a lag worth looking for with the models of a higher order?
    pub fn is_suspicious(&self) -> bool {
        self.likelihood_ratio > self.price
    }
}

/// The record of a rudder that lags by so much, s.
fn behind(
    span: &RecordSpan,
    samples: &[Sample<f64>],
    lag_s: f64,
    a22_per_s: f64,
) -> Option<RecordSeries> {
    let acting = Servo::new(0.0, lag_s).ok()?.acting(samples);
    span.prepare(&acting, a22_per_s).ok()
}
