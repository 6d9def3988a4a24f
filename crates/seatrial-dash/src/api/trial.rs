//! A trial: its order, where it is, how it ended, and the link to the vehicle.

use seatrial_app::TrialPlan;
use serde::{Deserialize, Serialize};

use super::{Figure, Outcome, RunSummary, Stage, ValidationOverlay, Verdict};

/// Starts a trial.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct TrialOrder {
    /// A name out of `/vehicles`.
    pub vehicle: String,
    /// The plan, in the form that `/plans/default` gives; the default plan where it is left out.
    #[serde(default)]
    #[cfg_attr(feature = "openapi", schema(value_type = Option<Object>))]
    pub plan: Option<TrialPlan>,
    /// Seed of a simulated vehicle [default: 1].
    #[serde(default)]
    pub seed: Option<u64>,
    /// How many times faster than real time a simulated vehicle runs; null is as fast as it can.
    #[serde(default)]
    #[cfg_attr(feature = "openapi", schema(exclusive_minimum = 0.0))]
    pub realtime_factor: Option<f64>,
    /// Faults that a simulated vehicle meets: a name out of `scenarios` of `/vehicles`.
    #[serde(default)]
    #[cfg_attr(feature = "openapi", schema(max_length = 64))]
    pub scenario: Option<String>,
    /// Name of the vehicle's configuration, its payload [default: default].
    #[serde(default)]
    #[cfg_attr(feature = "openapi", schema(max_length = 200))]
    pub configuration: Option<String>,
    /// Notes on the configuration.
    #[serde(default)]
    #[cfg_attr(feature = "openapi", schema(max_length = 4000))]
    pub note: Option<String>,
    /// A vehicle that is not simulated moves and has its parameters changed: true agrees to it.
    #[serde(default)]
    pub agreed: bool,
}

/// Runs one speed of a campaign again, as a campaign of its own with the same vehicle, plan and configuration.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct RepeatOrder {
    /// Number of the campaign.
    pub campaign: i64,
    /// The speed, as thrust in fractions of full.
    pub thrust: f64,
    /// Seed of a simulated vehicle [default: the campaign's plus one].
    #[serde(default)]
    pub seed: Option<u64>,
    /// How many times faster than real time a simulated vehicle runs; null is as fast as it can.
    #[serde(default)]
    #[cfg_attr(feature = "openapi", schema(exclusive_minimum = 0.0))]
    pub realtime_factor: Option<f64>,
    /// A vehicle that is not simulated moves and has its parameters changed: true agrees to it.
    #[serde(default)]
    pub agreed: bool,
}

/// Goes on with a campaign that ended early, as a campaign of its own with the speeds that are left.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct GoOnOrder {
    /// Number of the campaign.
    pub campaign: i64,
    /// Seed of a simulated vehicle [default: the campaign's plus one].
    #[serde(default)]
    pub seed: Option<u64>,
    /// How many times faster than real time a simulated vehicle runs; null is as fast as it can.
    #[serde(default)]
    #[cfg_attr(feature = "openapi", schema(exclusive_minimum = 0.0))]
    pub realtime_factor: Option<f64>,
    /// A vehicle that is not simulated moves and has its parameters changed: true agrees to it.
    #[serde(default)]
    pub agreed: bool,
}

/// Where a trial is.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Progress {
    /// 1 for the first run, 0 before it.
    pub run: u32,
    /// 1 for the first speed.
    pub speed: u32,
    /// Speeds of the plan.
    pub speeds: u32,
    /// Thrust as a fraction of full.
    pub thrust: f64,
    /// 1 for the first try at this thrust.
    pub attempt: u32,
    /// The stage; null before the first sample and after the end.
    pub stage: Option<Stage>,
    /// Time in the stage, s.
    pub elapsed_s: f64,
    /// Time until the stage ends at the latest, s.
    pub remaining_s: f64,
}

/// The estimate of the moment.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct EstimateNow {
    /// Vehicle time, s.
    pub time_s: f64,
    /// a22, 1/s.
    pub a22_per_s: Figure,
    /// b2, 1/s^2.
    pub b2_per_s2: Figure,
    /// C0, rad/s^2.
    pub c0_rad_per_s2: Figure,
    /// Step norm of the parameters (39).
    pub step_norm: f64,
    /// Under which it counts as converged.
    pub threshold: f64,
    /// Seconds into training at which it converged.
    pub converged_s: Option<f64>,
}

/// How much of a limit is used.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct EnvelopeUse {
    /// `depth`, `altitude`, `roll`, `pitch`, `yaw_rate`, `heading_excursion`, `area`, `speed_drift`, `stale_samples`,
    /// `stage_time_limit`.
    pub limit: String,
    /// 1 is at the limit.
    pub used: f64,
}

/// A trial that runs or ran since the server began.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct TrialState {
    /// Number of its campaign in the logbook.
    pub campaign: i64,
    /// Does it run?
    pub running: bool,
    /// The vehicle by name.
    pub vehicle: String,
    /// Name of the configuration.
    pub configuration: String,
    /// Seed of a simulated vehicle.
    pub seed: Option<u64>,
    /// As ordered.
    pub realtime_factor: Option<f64>,
    /// When it began, UTC.
    pub started: String,
    /// The plan.
    #[cfg_attr(feature = "openapi", schema(value_type = Object))]
    pub plan: TrialPlan,
    /// Where it is.
    pub progress: Option<Progress>,
    /// The estimate, from the training stage on.
    pub estimate: Option<EstimateNow>,
    /// How much of each limit is used.
    pub envelope: Vec<EnvelopeUse>,
    /// The runs that are over.
    pub runs: Vec<RunSummary>,
    /// That of the campaign; null while it runs and where a fault of the program ended it.
    pub verdict: Option<Verdict>,
    /// The newest validation.
    pub validation: Option<ValidationOverlay>,
    /// How it ended.
    pub outcome: Option<Outcome>,
    /// What could not be saved, or why the vehicle was given back.
    pub warnings: Vec<String>,
}

/// The link to the vehicle and its clock.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Health {
    /// Samples since the trial began.
    pub samples: u64,
    /// Mean time between the latest samples by the vehicle's clock, s.
    pub interval_s: Option<f64>,
    /// That of the plan, s.
    pub expected_interval_s: f64,
    /// Longest time between two samples by the vehicle's clock, s.
    pub longest_interval_s: Option<f64>,
    /// Since the last sample by the server's clock, s.
    pub silent_for_s: Option<f64>,
    /// Seconds of the vehicle's clock for each of the server's; 1 on a real vehicle with a sound clock.
    pub clock_rate: Option<f64>,
    /// Samples that were recorded but not shown, because the server was busy.
    pub not_shown: u64,
}
