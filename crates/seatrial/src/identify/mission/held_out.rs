//! A part of ordinary steering that a model was not fitted to.

use nalgebra::Matrix4;

use super::Estimate;
use super::fit::{Fit, Hypothesis, Problem};
use super::prediction::Prediction;
use super::record::Legs;
use crate::identify::robust::estimate::MODEL_ERROR;
use crate::propagation::NORMAL_95;
use crate::record::Window;

/// Share of the legs that is fitted where the rest validates.
const FITTED: f64 = 0.6;

/// A part of the log tells by itself whether the model is right where its intervals are within this share of it.
const TELLING: f64 = 0.6;

/// A part of the steering that the model was not fitted to, or other data.
pub struct HeldOut {
    /// Free runs of the model over it.
    pub prediction: Prediction,
    /// When it was.
    pub window: Window,
    /// Squared distance of its own [d, b] from the model's, over the covariance of both; `None` where it gives none by itself.
    pub apart: Option<f64>,
    /// Does it tell by itself whether the model is right?
    pub is_telling: bool,
}

impl HeldOut {
    /// Of other data, or of the last part of the legs with the heaviest hypothesis fitted to the first part.
    pub(super) fn of(
        legs: &Legs,
        estimate: &Estimate,
        other: Option<(Legs, Window)>,
    ) -> Option<Self> {
        let hypothesis = estimate.heaviest.hypothesis;
        let yaw_rate_rad_s = legs.yaw_rate_deviation_rad_s();
        if let Some((other, window)) = other {
            let rest = other.over_speed_of(legs);
            let model = (estimate.heaviest.clone(), estimate.covariance);
            return Some(Self::between(&model, &rest, hypothesis, window, yaw_rate_rad_s));
        }
        let [first, rest] = legs.split(FITTED);
        let (from, to) = (rest.legs.first()?, rest.legs.last()?);
        let window = Window { from_s: *from.time_s.first()?, to_s: *to.time_s.last()? };
        let model = fitted(&first, hypothesis)?;
        Some(Self::between(&model, &rest, hypothesis, window, yaw_rate_rad_s))
    }

    fn between(
        (fit, covariance): &(Fit, Matrix4<f64>),
        rest: &Legs,
        hypothesis: Hypothesis,
        window: Window,
        yaw_rate_rad_s: f64,
    ) -> Self {
        let own = fitted(rest, hypothesis);
        let values = fit.values();
        let apart = own.as_ref().and_then(|(other, of_other)| {
            let away = (other.values() - values).xy();
            let mut both = (covariance + of_other).fixed_view::<2, 2>(0, 0).into_owned();
            for (i, share) in MODEL_ERROR.iter().enumerate() {
                both[(i, i)] += 2.0 * (share * values[i]).powi(2);
            }
            Some(away.dot(&both.cholesky()?.solve(&away)))
        });
        let is_telling = own.is_some_and(|(other, covariance)| {
            (0..2)
                .all(|i| NORMAL_95 * covariance[(i, i)].sqrt() < TELLING * other.values()[i].abs())
        });
        Self { prediction: Prediction::of(fit, rest, yaw_rate_rad_s), window, apart, is_telling }
    }
}

/// One hypothesis fitted to legs, and its covariance.
fn fitted(legs: &Legs, hypothesis: Hypothesis) -> Option<(Fit, Matrix4<f64>)> {
    let (problem, look) = Problem::first_look(legs)?;
    let simple = problem.fit(look.hypothesis, &look.x)?;
    let fit = problem.extended(&simple, hypothesis)?;
    let covariance = problem.uncertainty(&fit)?.covariance;
    Some((fit, covariance))
}
