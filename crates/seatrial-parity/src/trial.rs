//! The whole trial executive on the rehearsal's vehicle.

use core::fmt;

use seatrial_core::{Action, List, Outcome, Plan, Real, Sample, Stage, Steering, Trial};

use crate::row::{Bits, Row};
use crate::vehicle::Vehicle;

const HEADER: &str = "time_s,heading_rad,rudder_rad,surge_speed_m_s,depth_m,altitude_m,roll_rad,pitch_rad,\
yaw_rate_rad_s,stage,steering,steering_rad,thrust,outcome,a22_per_s,b2_per_s2,c0_rad_per_s2,\
least_squares_a22_per_s,least_squares_b2_per_s2,least_squares_c0_rad_per_s2,step_norm\n";

/// More samples than the plan can take; the rehearsal ends long before.
const MOST_SAMPLES: u32 = 5000;

/// The paper's plan at two of its speeds.
pub fn plan<T: Real>() -> Plan<T> {
    Plan {
        thrusts: List::from_slice(&[T::of(0.7), T::of(0.9)]).unwrap_or_default(),
        ..Plan::paper()
    }
}

/// A trial and its vehicle, one sample at a time.
pub fn rehearse<T: Real>(
    mut each: impl FnMut(&Sample<T>, &mut Trial<T>) -> Result<Action<T>, fmt::Error>,
) -> fmt::Result {
    let mut trial = Trial::new(plan()).map_err(|_| fmt::Error)?;
    let mut vehicle = Vehicle::new();
    for _ in 0..MOST_SAMPLES {
        let sample = vehicle.sample();
        let action = each(&sample, &mut trial)?;
        vehicle.carry_out(&action);
        while trial.take_event().is_some() {}
        if action.outcome.is_some() {
            return Ok(());
        }
    }
    Err(fmt::Error)
}

pub fn write<T: Bits>(out: &mut impl fmt::Write) -> fmt::Result {
    out.write_str(HEADER)?;
    rehearse::<T>(|sample, trial| {
        let action = trial.step(sample);
        let mut row = Row::new(out);
        row.number(sample.time_s)?;
        row.number(sample.heading_rad)?;
        row.number(sample.rudder_rad)?;
        for optional in [
            sample.surge_speed_m_s,
            sample.depth_m,
            sample.altitude_m,
            sample.roll_rad,
            sample.pitch_rad,
            sample.yaw_rate_rad_s,
        ] {
            row.optional(optional)?;
        }
        row.text(match trial.status().stage {
            Some(Stage::Settle) => "settle",
            Some(Stage::Train) => "train",
            Some(Stage::Validate) => "validate",
            None => "",
        })?;
        let (steering, angle_rad) = match action.steering {
            Steering::Rudder(rudder_rad) => ("rudder", rudder_rad),
            Steering::HoldHeading(heading_rad) => ("hold_heading", heading_rad),
        };
        row.text(steering)?;
        row.number(angle_rad)?;
        row.optional(action.thrust)?;
        row.text(match action.outcome {
            None => "",
            Some(Outcome::Finished) => "finished",
            Some(Outcome::Aborted(_)) => "aborted",
        })?;
        let estimator = trial.estimator();
        row.model(&estimator.model())?;
        row.model(&estimator.least_squares_model())?;
        row.number(estimator.step_norm())?;
        row.end()?;
        Ok(action)
    })
}
