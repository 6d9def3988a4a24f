//! A trial: order, preview, preflight, progress, runs.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

use super::{EnvelopeUse, Review};

/// The stages of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// Waiting for steady heading, rate and depth.
    Settle,
    /// Estimating during the training manoeuvre.
    Train,
    /// Recording the validation manoeuvre.
    Validate,
}

/// A value and how sure it is.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, ToSchema)]
pub struct Figure {
    /// The value.
    pub value: f64,
    /// Its 95 % interval, low and high.
    pub interval_95: Option<[f64; 2]>,
}

/// A vehicle and a plan.
#[derive(Clone, Debug, Deserialize, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PlanOrder {
    /// A name out of `/vehicles`.
    pub vehicle: String,
    /// The plan, in the form that `/plans/default` gives; the default plan where it is left out.
    #[serde(default)]
    #[schema(value_type = Option<Object>)]
    pub plan: Option<Value>,
}

/// Starts a trial.
#[derive(Clone, Debug, Deserialize, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct TrialOrder {
    /// A name out of `/vehicles`.
    pub vehicle: String,
    /// The plan, in the form that `/plans/default` gives; the default plan where it is left out.
    #[serde(default)]
    #[schema(value_type = Option<Object>)]
    pub plan: Option<Value>,
    /// Seed of a simulated vehicle [default: 1].
    #[serde(default)]
    pub seed: Option<u64>,
    /// How many times faster than real time a simulated vehicle runs; null is as fast as it can.
    #[serde(default)]
    #[schema(exclusive_minimum = 0.0)]
    pub realtime_factor: Option<f64>,
    /// Name of the vehicle's configuration, its payload [default: default].
    #[serde(default)]
    #[schema(max_length = 200)]
    pub configuration: Option<String>,
    /// Notes on the configuration.
    #[serde(default)]
    #[schema(max_length = 4000)]
    pub note: Option<String>,
    /// A vehicle that is not simulated moves and has its parameters changed: true agrees to it.
    #[serde(default)]
    pub agreed: bool,
}

/// Runs one speed of a campaign again, as a campaign of its own with the same vehicle, plan and configuration.
#[derive(Clone, Debug, Deserialize, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct RepeatOrder {
    /// Number of the campaign.
    pub campaign: i64,
    /// The speed, as thrust in fractions of full.
    pub thrust: f64,
    /// Seed of a simulated vehicle [default: the campaign's plus one].
    #[serde(default)]
    pub seed: Option<u64>,
    /// As of a trial.
    #[serde(default)]
    #[schema(exclusive_minimum = 0.0)]
    pub realtime_factor: Option<f64>,
    /// As of a trial.
    #[serde(default)]
    pub agreed: bool,
}

/// Goes on with a campaign that ended early, as a campaign of its own with the speeds that are left.
#[derive(Clone, Debug, Deserialize, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct GoOnOrder {
    /// Number of the campaign.
    pub campaign: i64,
    /// Seed of a simulated vehicle [default: the campaign's plus one].
    #[serde(default)]
    pub seed: Option<u64>,
    /// As of a trial.
    #[serde(default)]
    #[schema(exclusive_minimum = 0.0)]
    pub realtime_factor: Option<f64>,
    /// As of a trial.
    #[serde(default)]
    pub agreed: bool,
}

/// What a plan will do on the vehicle expected.
#[derive(Clone, Debug, Deserialize, Serialize, ToSchema)]
pub struct PlanPreview {
    /// The plan as it would be run.
    #[schema(value_type = Object)]
    pub plan: Value,
    /// How it ends on a noise-free vehicle: aborted where it does not fit its envelope.
    pub outcome: Option<Outcome>,
    /// Time from the first sample to the last, without repeats, s.
    pub duration_s: f64,
    /// The same where the vehicle never settles before its time is up, s.
    pub longest_s: f64,
    /// Southernmost, northernmost, westernmost and easternmost point from the start, m; margin included.
    pub track_box_m: Option<[f64; 4]>,
    /// The margin, m.
    pub track_margin_m: Option<f64>,
    /// The speeds in the order of the plan.
    pub speeds: Vec<SpeedPreview>,
    /// Would every speed tell enough for its model to be accepted?
    pub is_enough: bool,
}

/// One speed of a preview.
#[derive(Clone, Debug, Deserialize, Serialize, ToSchema)]
pub struct SpeedPreview {
    /// Thrust as a fraction of full.
    pub thrust: f64,
    /// Forward speed, m/s.
    pub surge_speed_m_s: Option<f64>,
    /// Lengths of the stages settle, train and validate, s.
    pub stages_s: [f64; 3],
    /// Farthest heading from the heading held, rad.
    pub heading_excursion_rad: f64,
    /// The intervals to expect at best; null where the stage tells nothing.
    pub expected: Option<ExpectedIntervals>,
}

/// Intervals that no unbiased estimate can beat.
#[derive(Clone, Debug, Deserialize, Serialize, ToSchema)]
pub struct ExpectedIntervals {
    /// a22, 1/s.
    pub a22_per_s: Figure,
    /// b2, 1/s^2.
    pub b2_per_s2: Figure,
    /// C0, rad/s^2.
    pub c0_rad_per_s2: Figure,
    /// K_p for a damping ratio of 0.7071.
    pub proportional_gain: Option<Figure>,
    /// Radius of the steady circle under full rudder to starboard and to port, m.
    pub steady_turning_radius_m: [Option<Figure>; 2],
    /// Narrow enough for the model to be accepted?
    pub is_enough: bool,
}

/// One look before a trial.
#[derive(Clone, Debug, Deserialize, Serialize, ToSchema)]
pub struct Check {
    /// Short and stable.
    pub name: String,
    /// Does it allow a trial?
    pub passed: bool,
    /// What was found; where it does not pass, also what to do.
    pub text: String,
}

/// A parameter of the autopilot that is other during the trial.
#[derive(Clone, Debug, Deserialize, Serialize, ToSchema)]
pub struct Change {
    /// The parameter.
    pub name: String,
    /// Its value now.
    pub from: f64,
    /// Its value during the trial.
    pub to: f64,
    /// Why.
    pub why: String,
}

/// The checklist before a trial.
#[derive(Clone, Debug, Deserialize, Serialize, ToSchema)]
pub struct Preflight {
    /// Every check passed.
    pub ready: bool,
    /// Each check.
    pub checks: Vec<Check>,
    /// What would be changed on the vehicle until it is handed back.
    pub changes: Vec<Change>,
}

/// Where a trial is.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, ToSchema)]
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
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, ToSchema)]
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

/// How a trial ended.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, ToSchema)]
pub struct Outcome {
    /// Every speed was run.
    pub finished: bool,
    /// Why it was aborted: `operator`, `depth`, `area`, ...
    pub reason: Option<String>,
    /// In words.
    pub text: String,
}

/// One reason of a verdict.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, ToSchema)]
pub struct Reason {
    /// Short and stable.
    pub code: String,
    /// What was measured and what to do.
    pub text: String,
}

/// A stage of a run and its time, half open.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, ToSchema)]
pub struct StageSpan {
    /// Which.
    pub stage: Stage,
    /// First sample, s of the vehicle's clock.
    pub from_s: f64,
    /// The end; null where it has none.
    pub to_s: Option<f64>,
}

/// The model of one speed: psi' = r, r' = a22 r + b2 delta + C0.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, ToSchema)]
pub struct Model {
    /// a22, 1/s.
    pub a22_per_s: Figure,
    /// b2, 1/s^2.
    pub b2_per_s2: Figure,
    /// C0, rad/s^2.
    pub c0_rad_per_s2: Figure,
    /// delta0 = C0/b2, rad.
    pub delta0_rad: Option<Figure>,
    /// Nomoto T, s.
    pub nomoto_t_s: Option<f64>,
    /// Nomoto K, 1/s.
    pub nomoto_k_per_s: Option<f64>,
    /// R^2 of heading on fresh data.
    pub r2_heading: Option<f64>,
    /// The same with the offset estimated again.
    pub r2_heading_offset_refit: Option<f64>,
    /// R^2 of yaw rate on fresh data.
    pub r2_yaw_rate: Option<f64>,
    /// Seconds into training at which the online estimate converged.
    pub converged_s: Option<f64>,
    /// The method that the model comes from.
    pub method: String,
}

/// A run.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, ToSchema)]
pub struct RunSummary {
    /// 1 for the first run of the campaign.
    pub number: u32,
    /// Thrust as a fraction of full.
    pub thrust: f64,
    /// 1 for the first try at this thrust.
    pub attempt: u32,
    /// Mean forward speed over the training stage, m/s.
    pub surge_speed_m_s: Option<f64>,
    /// Its stages.
    pub stages: Vec<StageSpan>,
    /// May it be used? The operator's word goes before the program's.
    pub accepted: bool,
    /// Why.
    pub reasons: Vec<Reason>,
    /// The model, where training was finished.
    pub model: Option<Model>,
    /// The operator's word.
    pub review: Option<Review>,
}

/// Measured and simulated over the validation stage.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, ToSchema)]
pub struct ValidationOverlay {
    /// Run.
    pub run: u32,
    /// Vehicle time, s.
    pub time_s: Vec<f64>,
    /// Measured, from the first one, unwrapped, rad.
    pub measured_heading_rad: Vec<f64>,
    /// Free running simulation with the model, rad.
    pub simulated_heading_rad: Vec<f64>,
}

/// A trial that runs or ran since the server began.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, ToSchema)]
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
    #[schema(value_type = Object)]
    pub plan: Value,
    /// Where it is.
    pub progress: Option<Progress>,
    /// The estimate, from the training stage on.
    pub estimate: Option<EstimateNow>,
    /// How much of each limit is used.
    pub envelope: Vec<EnvelopeUse>,
    /// The runs that are over.
    pub runs: Vec<RunSummary>,
    /// The newest validation.
    pub validation: Option<ValidationOverlay>,
    /// How it ended.
    pub outcome: Option<Outcome>,
    /// What could not be saved, or why the vehicle was given back.
    pub warnings: Vec<String>,
}

/// The link to the vehicle and its clock.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize, ToSchema)]
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
