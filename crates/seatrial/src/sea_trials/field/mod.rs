//! The field experiments of section VI: U-turns, heading steps and repeated trials, on a vehicle after its trial.

mod circle_fit;
mod claims;
mod heading_step;
mod heading_steps;
mod pilot;
mod repeatability;
mod u_turn;

use seatrial_core::schedule::{ScheduleError, ScheduleKey};
use seatrial_core::turning::{NoTurn, Side};
use seatrial_core::{SchedulePoint, SpeedSchedule, Vehicle};
use serde::Serialize;

use crate::campaign::Campaign;
use crate::gain_allowance::{GainAllowance, least_damped_schedule};
use crate::identification::Identification;
use crate::motions::surge::SurgeModel;
use crate::savitzky_golay::NoDerivative;
pub use heading_step::{
    Control, HeadingStepRun, HeadingStepSample, HeadingSteps, NoExperiment, StepMeasure,
};

pub use circle_fit::{CircleFit, NoCircle};
pub use claims::Claim;
use heading_steps::Gains;
pub use heading_steps::{GainFromEnds, SteeredSteps};
use pilot::Pilot;
pub use repeatability::{Repeat, Repeatability, Spread, TrialsAtThrust};
pub use u_turn::{MeasuredTurn, PredictedTurn, UTurn, YawRateSample};

/// How the experiments are done.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct FieldSettings {
    /// Time on a steady course before each experiment, s.
    pub settle_s: f64,
    /// To which side the U-turns are.
    #[serde(rename = "hand")]
    pub side: Side,
    /// The heading steps; an ideal rudder and delay are not needed, the vehicle has its own.
    pub steps: HeadingSteps,
    /// Thrust of the repeated trials.
    pub repeated_thrust: f64,
}

impl Default for FieldSettings {
    fn default() -> Self {
        Self {
            settle_s: 40.0,
            side: Side::Port,
            steps: HeadingSteps::default(),
            repeated_thrust: 0.8,
        }
    }
}

/// Why an experiment could not be done.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FieldError {
    /// The trial gave too few models.
    #[error("the trial gave no schedule: {0}")]
    NoSchedule(#[from] ScheduleError),
    /// No controller.
    #[error("heading steps: {0}")]
    Steps(#[from] NoExperiment),
    /// The model does not turn.
    #[error("U-turn at {thrust}: {reason}")]
    NoTurn {
        /// Thrust.
        thrust: f64,
        /// The cause.
        reason: NoTurn,
    },
    /// The track is no circle.
    #[error("U-turn at {thrust}: {reason}")]
    NoCircle {
        /// Thrust.
        thrust: f64,
        /// The cause.
        reason: NoCircle,
    },
    /// The yaw rate cannot be derived.
    #[error("U-turn: {0}")]
    NoYawRate(#[from] NoDerivative),
    /// The vehicle did not come round.
    #[error("U-turn at {thrust}: turned by {} degrees in {seconds} s only", turned_rad.to_degrees().round())]
    NotRound {
        /// Thrust.
        thrust: f64,
        /// Heading change, rad.
        turned_rad: f64,
        /// Time given, s.
        seconds: f64,
    },
    /// A channel that an experiment needs.
    #[error("the vehicle does not say its {0}")]
    Missing(&'static str),
    /// The vehicle is gone.
    #[error("the vehicle sends no more samples")]
    LinkLost,
}

/// What the experiments gave.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Field {
    /// Largest rudder angle, rad.
    pub rudder_limit_rad: f64,
    /// How they were done.
    pub settings: FieldSettings,
    /// The identified speeds in order of thrust.
    pub points: Vec<SchedulePoint<f64>>,
    /// One U-turn a thrust (Fig. 15, Table IV).
    pub u_turns: Vec<UTurn>,
    /// Heading steps, every thrust with every controller (Figs. 17 and 18).
    pub heading_steps: Vec<SteeredSteps>,
    /// Gains between the lowest and the highest thrust from these two alone (Fig. 18).
    pub gains_from_ends: Vec<GainFromEnds>,
    /// The trials, every thrust.
    pub trials: Vec<TrialsAtThrust>,
    /// Speed over thrust, of the first trial.
    pub surge: Option<SurgeModel>,
    /// b2 = k V^2 + c over the first trial: the part of the variance of b2 that it explains.
    pub authority_r2: Option<f64>,
    /// The trials of one thrust beside each other.
    pub repeatability: Option<Repeatability>,
}

impl Field {
    /// Does the experiments on the vehicle of the first of `trials`. The others are repetitions with other seeds.
    ///
    /// There is no envelope around these manoeuvres: they are for a simulated vehicle.
    pub fn experiments<V: Vehicle<f64>>(
        vehicle: &mut V,
        trials: &[Campaign],
        settings: FieldSettings,
    ) -> Result<Self, FieldError> {
        let first = trials.first();
        let rudder_limit_rad = first.map_or(0.0, |campaign| campaign.rudder_limit_rad);
        let points = first.map_or(Vec::new(), schedule_points);
        let schedule = SpeedSchedule::new(ScheduleKey::Thrust, &points)?;
        let allowed = first.into_iter().flat_map(identified_points);
        let allowed = allowed.map(|(point, found)| (point, GainAllowance::of(found)));
        let (cautious, timing) = least_damped_schedule(ScheduleKey::Thrust, allowed)?;
        let points = schedule.points().to_vec();
        let mut pilot = Pilot::new(vehicle);
        let surge = first.and_then(SurgeModel::of);
        let mut u_turns = Vec::new();
        for point in &points {
            let turn = UTurn::make(&mut pilot, point, rudder_limit_rad, surge.as_ref(), &settings)?;
            u_turns.push(turn);
        }
        u_turn::transfer(&mut u_turns);
        let steps = HeadingSteps { rudder_limit_rad, ..settings.steps };
        let gains = Gains::design(cautious, steps.damping_ratio, timing)?;
        Ok(Self {
            rudder_limit_rad,
            settings,
            u_turns,
            heading_steps: heading_steps::make(
                &mut pilot,
                &schedule,
                &gains,
                &steps,
                settings.settle_s,
            )?,
            gains_from_ends: GainFromEnds::of(&schedule, steps.damping_ratio)?,
            trials: points
                .iter()
                .filter_map(|point| TrialsAtThrust::of(trials, point.thrust?))
                .collect(),
            surge,
            authority_r2: repeatability::authority_r2(&points),
            repeatability: Repeatability::of(
                trials,
                settings.repeated_thrust,
                rudder_limit_rad,
                settings.side,
                steps.damping_ratio,
            ),
            points,
        })
    }
}

fn schedule_points(campaign: &Campaign) -> Vec<SchedulePoint<f64>> {
    identified_points(campaign).map(|(point, _)| point).collect()
}

fn identified_points(
    campaign: &Campaign,
) -> impl Iterator<Item = (SchedulePoint<f64>, &Identification)> {
    campaign.accepted_runs().into_iter().filter_map(|run| {
        let identification = run.identification.as_ref()?;
        let point = SchedulePoint {
            thrust: Some(run.thrust),
            surge_speed_m_s: run.surge_speed_m_s,
            model: identification.model(),
        };
        Some((point, identification))
    })
}
