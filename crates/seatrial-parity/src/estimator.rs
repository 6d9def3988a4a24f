//! The guarded estimator, called directly on the samples of a rehearsed trial.

use core::fmt;

use seatrial_core::{Estimator, EstimatorSettings, Intake, Stage};

use crate::row::{Bits, Row};
use crate::trial::{plan, rehearse};

const HEADER: &str = "call,time_s,heading_rad,rudder_rad,intake,a22_per_s,b2_per_s2,c0_rad_per_s2,\
least_squares_a22_per_s,least_squares_b2_per_s2,least_squares_c0_rad_per_s2,p11,p12,p13,p22,p23,p33,\
step_norm,converged_s\n";

pub fn write<T: Bits>(out: &mut impl fmt::Write) -> fmt::Result {
    out.write_str(HEADER)?;
    let training = plan::<T>().training;
    let mut estimator =
        Estimator::new(EstimatorSettings::<T>::default()).map_err(|_| fmt::Error)?;
    let mut stage = None;
    let mut start_s = 0.0;
    let mut excitation_is_over = false;
    rehearse::<T>(|sample, trial| {
        let action = trial.step(sample);
        let now = trial.status().stage;
        if now != stage && now == Some(Stage::Settle) {
            estimator.restart();
            row(out, &estimator, "restart", None, None)?;
        }
        if now != stage && now == Some(Stage::Train) {
            start_s = sample.time_s;
            excitation_is_over = false;
        }
        stage = now;
        let (time_s, heading_rad, rudder_rad) =
            (sample.time_s, sample.heading_rad, sample.rudder_rad);
        let (call, intake) = if now == Some(Stage::Train) {
            if !excitation_is_over && time_s >= start_s + training.excitation_end_s() {
                excitation_is_over = true;
                estimator.excitation_ended();
                row(out, &estimator, "excitation_ended", None, None)?;
            }
            let intake = estimator.update(time_s, heading_rad, rudder_rad);
            ("update", intake)
        } else {
            ("warm", estimator.warm(time_s, heading_rad, rudder_rad))
        };
        let input = Some((time_s, [heading_rad, rudder_rad]));
        row(out, &estimator, call, input, Some(intake))?;
        Ok(action)
    })
}

fn row<T: Bits>(
    out: &mut impl fmt::Write,
    estimator: &Estimator<T>,
    call: &str,
    input: Option<(f64, [T; 2])>,
    intake: Option<Intake>,
) -> fmt::Result {
    let mut row = Row::new(out);
    row.text(call)?;
    row.optional(input.map(|(time_s, _)| time_s))?;
    row.optional(input.map(|(_, [heading_rad, _])| heading_rad))?;
    row.optional(input.map(|(_, [_, rudder_rad])| rudder_rad))?;
    row.text(match intake {
        None => "",
        Some(Intake::Used) => "used",
        Some(Intake::Warming) => "warming",
        Some(Intake::Rejected(_)) => "rejected",
    })?;
    row.model(&estimator.model())?;
    row.model(&estimator.least_squares_model())?;
    row.upper_triangle(&estimator.covariance())?;
    row.number(estimator.step_norm())?;
    row.optional(estimator.converged_s())?;
    row.end()
}
