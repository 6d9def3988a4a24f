//! Commands a vehicle and keeps what it measured.

use seatrial_core::{Action, Real, Sample, Steering, Vehicle};

use super::FieldError;

pub(super) struct Pilot<'v, V> {
    vehicle: &'v mut V,
    last: Sample<f64>,
}

impl<'v, V: Vehicle<f64>> Pilot<'v, V> {
    pub fn new(vehicle: &'v mut V) -> Self {
        Self { vehicle, last: Sample::default() }
    }

    /// Steers by every sample for so many seconds, or until `steer` has no answer; the samples in order.
    pub fn steer(
        &mut self,
        seconds: f64,
        thrust: f64,
        mut steer: impl FnMut(&Sample<f64>) -> Option<Steering<f64>>,
    ) -> Result<Vec<Sample<f64>>, FieldError> {
        let mut samples: Vec<Sample<f64>> = Vec::new();
        loop {
            let sample = match self.vehicle.next_sample() {
                Ok(Some(sample)) => sample,
                Ok(None) | Err(_) => return Err(FieldError::LinkLost),
            };
            self.last = sample;
            samples.push(sample);
            let elapsed_s = sample.time_s - samples[0].time_s;
            let steering = match steer(&sample) {
                Some(steering) if elapsed_s < seconds => steering,
                _ => return Ok(samples),
            };
            let action = Action { steering, thrust: Some(thrust), outcome: None };
            self.vehicle.act(&action).map_err(|_| FieldError::LinkLost)?;
        }
    }

    /// Holds the heading that it has, by the vehicle's own controller.
    pub fn hold(&mut self, seconds: f64, thrust: f64) -> Result<Vec<Sample<f64>>, FieldError> {
        let heading_rad = self.last.heading_rad;
        self.steer(seconds, thrust, |_| Some(Steering::HoldHeading(heading_rad)))
    }
}

/// Headings without jumps at the wrap, as change since the first sample, rad.
pub(super) fn turned_rad(samples: &[Sample<f64>]) -> Vec<f64> {
    let mut total_rad = 0.0;
    let mut last_rad = samples.first().map_or(0.0, |s| s.heading_rad);
    let turned = samples.iter().map(|sample| {
        total_rad += (sample.heading_rad - last_rad).wrapped();
        last_rad = sample.heading_rad;
        total_rad
    });
    turned.collect()
}

/// The mean of a channel. An error where a sample is without it.
pub(super) fn mean(
    samples: &[Sample<f64>],
    name: &'static str,
    channel: impl Fn(&Sample<f64>) -> Option<f64>,
) -> Result<f64, FieldError> {
    let values: Option<Vec<f64>> = samples.iter().map(channel).collect();
    let values = values.filter(|values| !values.is_empty());
    let values = values.ok_or(FieldError::Missing(name))?;
    Ok(values.iter().sum::<f64>() / values.len() as f64)
}
