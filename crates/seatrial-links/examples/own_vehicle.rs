//! A vehicle of one's own behind the `Vehicle` trait, and a whole trial on it.
//!
//! `cargo run -p seatrial-links --example own_vehicle`

use std::convert::Infallible;
use std::error::Error;

use seatrial_core::model::YawState;
use seatrial_core::{
    Action, Event, Outcome, Plan, RunResult, Sample, Steering, Trial, Vehicle, YawModel,
};

/// A boat of which we know the heading and the rudder. Put your own link here: `next_sample` waits for the next measurement,
/// `act` sends the command.
struct Boat {
    yaw: YawModel<f64>,
    state: YawState<f64>,
    time_s: f64,
    interval_s: f64,
    rudder_rad: f64,
    commanded_rad: f64,
    thrust: f64,
}

impl Vehicle<f64> for Boat {
    type Error = Infallible;

    fn next_sample(&mut self) -> Result<Option<Sample<f64>>, Infallible> {
        self.state = self.yaw.advance(self.state, self.rudder_rad, self.interval_s);
        self.time_s += self.interval_s;
        // A sample's rudder is the one that acts from its time until the next sample. One sample of delay that is not
        // reported would shift a22 by about a tenth.
        self.rudder_rad = self.commanded_rad;
        Ok(Some(Sample {
            time_s: self.time_s,
            heading_rad: self.state.heading_rad,
            rudder_rad: self.rudder_rad,
            surge_speed_m_s: Some(2.0 * self.thrust),
            ..Sample::default()
        }))
    }

    fn act(&mut self, action: &Action<f64>) -> Result<(), Infallible> {
        self.commanded_rad = match action.steering {
            Steering::Rudder(rudder_rad) => rudder_rad,
            // Your autopilot's own heading controller; here a plain one.
            Steering::HoldHeading(heading_rad) => {
                let error_rad = self.state.heading_rad - heading_rad;
                (-0.5 * error_rad - 0.5 * self.state.yaw_rate_rad_s).clamp(-0.2, 0.2)
            }
        };
        self.thrust = action.thrust.unwrap_or(0.5);
        Ok(())
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let runs = trial()?;
    for run in &runs {
        println!(
            "thrust {}: a22 {:.3} 1/s, b2 {:.3} 1/s^2",
            run.thrust, run.model.a22_per_s, run.model.b2_per_s2
        );
    }
    Ok(())
}

/// Runs the paper's trial on the boat.
pub fn trial() -> Result<Vec<RunResult<f64>>, Box<dyn Error>> {
    let plan = Plan::<f64>::paper();
    let mut boat = Boat {
        yaw: YawModel::from_theta([-1.07, 1.08, 0.012]),
        state: YawState::default(),
        time_s: 0.0,
        interval_s: plan.sample_interval_s,
        rudder_rad: 0.0,
        commanded_rad: 0.0,
        thrust: 0.5,
    };
    let mut trial = Trial::new(plan)?;
    let mut runs = Vec::new();
    while trial.outcome().is_none() {
        let Some(sample) = boat.next_sample()? else {
            break;
        };
        let action = trial.step(&sample);
        boat.act(&action)?;
        while let Some(event) = trial.take_event() {
            if let Event::RunFinished { result, .. } = event {
                runs.push(result);
            }
        }
    }
    match trial.outcome() {
        Some(Outcome::Finished) => Ok(runs),
        ended => Err(format!("the trial ended early: {ended:?}").into()),
    }
}
