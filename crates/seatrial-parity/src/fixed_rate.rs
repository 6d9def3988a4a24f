//! The lean estimator, called on the samples of a rehearsed trial.

use core::fmt;

use seatrial_core::{FixedRateEstimator, FixedRateSettings, Stage};

use crate::row::{Bits, Row};
use crate::trial::rehearse;
use crate::vehicle::INTERVAL_S;

const HEADER: &str = "call,heading_rad,rudder_rad,intake,a22_per_s,b2_per_s2,c0_rad_per_s2,\
p11,p12,p13,p22,p23,p33\n";

pub fn write<T: Bits>(out: &mut impl fmt::Write) -> fmt::Result {
    out.write_str(HEADER)?;
    let settings = FixedRateSettings::for_lambda(T::of(1.5), T::of(INTERVAL_S));
    let mut estimator: Option<FixedRateEstimator<T>> = None;
    let mut stage = None;
    rehearse::<T>(|sample, trial| {
        let action = trial.step(sample);
        let input = [sample.heading_rad, sample.rudder_rad];
        let [heading_rad, rudder_rad] = input;
        let before = stage;
        stage = trial.status().stage;
        let Some(lean) = &mut estimator else {
            let lean = FixedRateEstimator::new(&settings, heading_rad, rudder_rad)
                .map_err(|_| fmt::Error)?;
            row(out, &lean, "new", Some(input), "")?;
            estimator = Some(lean);
            return Ok(action);
        };
        if stage != before && stage == Some(Stage::Settle) {
            lean.restart();
            row(out, lean, "restart", None, "")?;
        }
        let (call, taken, word) = if stage == Some(Stage::Train) {
            ("update", lean.update(heading_rad, rudder_rad), "used")
        } else {
            ("settle", lean.settle(heading_rad, rudder_rad), "warming")
        };
        let intake = if taken { word } else { "rejected" };
        row(out, lean, call, Some(input), intake)?;
        Ok(action)
    })
}

fn row<T: Bits>(
    out: &mut impl fmt::Write,
    estimator: &FixedRateEstimator<T>,
    call: &str,
    input: Option<[T; 2]>,
    intake: &str,
) -> fmt::Result {
    let mut row = Row::new(out);
    row.text(call)?;
    row.optional(input.map(|[heading_rad, _]| heading_rad))?;
    row.optional(input.map(|[_, rudder_rad]| rudder_rad))?;
    row.text(intake)?;
    row.model(&estimator.model())?;
    row.upper_triangle(&estimator.covariance())?;
    row.end()
}
