//! What the logbook holds.

use serde::{Deserialize, Serialize};

use super::{Figure, Model, Outcome, Reason, RunSummary, Verdict, VerdictOutcome};

/// How far a campaign came.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum State {
    /// It runs.
    Running,
    /// Every speed was run.
    Finished,
    /// It was aborted.
    Aborted,
    /// The program was killed: finished runs and samples are kept.
    Interrupted,
}

/// A campaign in a list.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct CampaignSummary {
    /// Its number.
    pub id: i64,
    /// Name of the configuration (payload).
    pub configuration: String,
    /// Notes on the configuration.
    pub notes: Option<String>,
    /// When it began, UTC.
    pub started: String,
    /// The version of seatrial that ran it.
    pub software_version: String,
    /// The vehicle by name.
    pub vehicle: String,
    /// Seed of a simulated vehicle.
    pub seed: Option<u64>,
    /// Largest rudder, rad.
    pub rudder_limit_rad: f64,
    /// How far it came.
    pub state: State,
    /// How it ended.
    pub outcome: Option<Outcome>,
    /// May its models be used, as a whole? Null while it runs, and where it cannot be read.
    pub verdict: Option<VerdictOutcome>,
    /// Runs begun.
    pub runs: u32,
    /// Runs accepted, each by itself.
    pub runs_accepted: u32,
    /// SHA-256 of the plan.
    pub plan_sha256: String,
    /// The newest link of its hash chain.
    pub head_sha256: String,
}

/// A campaign with its runs.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct CampaignDetail {
    /// The campaign.
    pub campaign: CampaignSummary,
    /// The plan, TOML.
    pub plan: String,
    /// May its models be used, as a whole?
    pub verdict: Verdict,
    /// Why, and what else is said of it as a whole.
    pub reasons: Vec<Reason>,
    /// Every run in order.
    pub runs: Vec<RunSummary>,
    /// Numbers of the runs that count: the last accepted one of each thrust, in order of thrust.
    pub counting_runs: Vec<u32>,
}

/// Accepts or rejects a run.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct ReviewOrder {
    /// May it be used? A run without a model cannot be accepted.
    pub accepted: bool,
    /// Why, 1 to 4000 characters.
    #[cfg_attr(feature = "openapi", schema(min_length = 1, max_length = 4000))]
    pub note: String,
}

/// Two campaigns side by side.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Comparison {
    /// The first.
    pub a: CampaignSummary,
    /// The second.
    pub b: CampaignSummary,
    /// Thrusts at which both have an accepted run.
    pub thrusts: Vec<ThrustComparison>,
    /// Thrusts at which only the first has one.
    pub only_in_a: Vec<f64>,
    /// Thrusts at which only the second has one.
    pub only_in_b: Vec<f64>,
    /// The statistical test; null where there is nothing to compare.
    pub what_changed: Option<WhatChanged>,
}

/// Both models at one thrust, and what follows from them.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct ThrustComparison {
    /// Thrust as a fraction of full.
    pub thrust: f64,
    /// Forward speeds, m/s.
    pub surge_speed_m_s: [Option<f64>; 2],
    /// a22, b2, C0, delta0, K_p, steady turning radius to starboard and to port, as far as both have them.
    pub differences: Vec<Difference>,
}

/// One quantity of two models.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Difference {
    /// `a22_per_s`, `b2_per_s2`, `c0_rad_per_s2`, `delta0_rad`, `proportional_gain`,
    /// `steady_turning_radius_starboard_m`, `steady_turning_radius_port_m`.
    pub quantity: String,
    /// Value of the first campaign.
    pub a: Figure,
    /// Value of the second campaign.
    pub b: Figure,
    /// B - A.
    pub difference: f64,
    /// The difference in units of the combined interval; beyond 1 once in twenty times by chance.
    pub ratio: Option<f64>,
}

/// Has the vehicle changed?
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct WhatChanged {
    /// Null where the data cannot tell.
    pub changed: Option<bool>,
    /// In words: what changed by how much, and the one cause that explains it.
    pub reasons: Vec<Reason>,
}

/// The models of a campaign over speed.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Schedule {
    /// The campaign.
    pub campaign: i64,
    /// Damping ratio of the gains.
    pub damping_ratio: f64,
    /// Largest rudder, rad.
    pub rudder_limit_rad: f64,
    /// Slowest and fastest identified speed, m/s; null where a speed is unknown.
    pub speed_range_m_s: Option<[f64; 2]>,
    /// Each identified speed, slowest first.
    pub points: Vec<SchedulePoint>,
    /// At the speed asked for.
    pub at: Option<OperatingPoint>,
}

/// An identified speed.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct SchedulePoint {
    /// Number of the run.
    pub run: u32,
    /// Thrust as a fraction of full.
    pub thrust: f64,
    /// The model.
    pub model: Model,
    /// What follows from it.
    pub point: OperatingPoint,
}

/// Gains, margins and turning limits at one speed. Intervals are null between identified speeds.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct OperatingPoint {
    /// Forward speed, m/s.
    pub surge_speed_m_s: Option<f64>,
    /// Beyond the identified speeds.
    pub extrapolated: bool,
    /// a22, 1/s.
    pub a22_per_s: f64,
    /// b2, 1/s^2.
    pub b2_per_s2: f64,
    /// C0, rad/s^2.
    pub c0_rad_per_s2: f64,
    /// Why there is no gain.
    pub no_gain: Option<String>,
    /// K_p.
    pub proportional_gain: Option<Figure>,
    /// The rudder that holds a heading, rad.
    pub feed_forward_rudder_rad: Option<f64>,
    /// Natural frequency of the closed loop, rad/s.
    pub natural_frequency_rad_s: Option<f64>,
    /// Overshoot of a heading step, a fraction.
    pub overshoot: Option<f64>,
    /// A factor; null is infinite.
    pub gain_margin: Option<f64>,
    /// rad.
    pub phase_margin_rad: Option<f64>,
    /// s.
    pub delay_margin_s: Option<f64>,
    /// Steady yaw rate under full rudder to starboard and to port, rad/s.
    pub yaw_rate_limit_rad_s: [Option<Figure>; 2],
    /// Radius of the steady circle under full rudder to starboard and to port, m.
    pub steady_turning_radius_m: [Option<Figure>; 2],
    /// Time of a turn through 180 degrees to starboard and to port, s.
    pub u_turn_time_s: [Option<f64>; 2],
}
