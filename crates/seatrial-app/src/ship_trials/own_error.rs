//! What a model lacks, as the record that it was identified from shows it.
//!
//! ```text
//! e_k = recorded overshoot / overshoot of the model in the same zig-zag - 1          k = 1 to n
//! m = mean of e,  s^2 = sum of (e - m)^2/(n - 1)
//! [low (1 + m - h), high (1 + m + h)],  h = t s sqrt(1 + 1/n)
//! ```
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | low, high | interval of an overshoot from the covariance of the model; both the value where there is none | deg |
//! | t | 97.5 % point of Student's distribution with n - 1 degrees of freedom | 1 |
//!
//! Source: the interval for one more observation, G. Hahn, W. Meeker, Statistical Intervals, 1991, 4.7. Valid where the hull departs from the
//! model in another zig-zag as it does in its own: of the same kind and about as wide. With two or three overshoots t is large, and the
//! interval wide.

use seatrial::sea_trials::ship_manoeuvres::{Index, Kind, RecordedManoeuvre, recorded};
use seatrial_core::Sample;
use seatrial_sim::IdentifiedVehicle;

use super::manoeuvres::same_zig_zag;
use crate::Error;

/// 97.5 % points of Student's distribution, of 1 degree of freedom on.
const STUDENT_97_5: [f64; 4] = [12.706_2, 4.302_65, 3.182_45, 2.776_45];

/// The error of a model in the overshoots of its own record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OwnError {
    /// m.
    pub mean: f64,
    /// h.
    pub half_width: f64,
    /// n.
    pub overshoots: usize,
}

impl OwnError {
    /// That of a vehicle at a thrust, on the record that its model was identified from.
    pub fn of(
        vehicle: &IdentifiedVehicle,
        thrust: Option<f64>,
        name: &str,
        samples: &[Sample<f64>],
    ) -> Result<Self, Error> {
        let refused = |why: &str| Error::Rejected(format!("{name}: {why}"));
        let found = recorded(samples, Some(Kind::ZigZag))
            .map_err(|why| refused(&format!("the record of the model: {why}")))?;
        let Some(RecordedManoeuvre::ZigZag(own)) = found.first() else {
            return Err(refused("no zig-zag"));
        };
        let thrust = thrust.unwrap_or(vehicle.fastest_thrust());
        let model = same_zig_zag(vehicle, thrust, own)
            .ok_or_else(|| refused("the model does not make the zig-zag of its own record"))?;
        let pairs = own.overshoots_rad.iter().zip(&model.overshoots_rad);
        let errors: Vec<f64> = pairs.map(|(own, model)| own / model - 1.0).collect();
        let degrees = errors.len().checked_sub(2).ok_or_else(|| {
            refused("the zig-zag has one overshoot, whose error has no spread; log two at least")
        })?;
        let count = errors.len() as f64;
        let mean = errors.iter().sum::<f64>() / count;
        let squares: f64 = errors.iter().map(|e| (e - mean).powi(2)).sum();
        let student = STUDENT_97_5[degrees.min(STUDENT_97_5.len() - 1)];
        Ok(Self {
            mean,
            half_width: student * (squares / (count - 1.0) * (1.0 + 1.0 / count)).sqrt(),
            overshoots: errors.len(),
        })
    }

    /// Widens the intervals of overshoots.
    pub(super) fn widen(&self, indices: &mut [Index]) {
        let overshoots = indices.iter_mut().filter(|index| index.name.ends_with("overshoot angle"));
        for index in overshoots {
            let [low, high] = index.interval_95.unwrap_or([index.value; 2]);
            let factor = |side: f64| (1.0 + self.mean + side * self.half_width).max(0.0);
            index.interval_95 = Some([low * factor(-1.0), high * factor(1.0)]);
        }
    }

    pub(super) fn sentence(&self) -> String {
        format!(
            "Intervals of overshoots carry what the model lacks on its own record: its {} overshoots there are {:+.0} % of the model's off on the mean, and another \
             within {:.0} % of that.",
            self.overshoots,
            100.0 * self.mean,
            100.0 * self.half_width
        )
    }
}
