//! A plan before its trial: preview and preflight.

use seatrial_app::TrialPlan;
pub use seatrial_app::trials::order::{Change, Check};
use serde::{Deserialize, Serialize};

use super::{Figure, Outcome};

/// A vehicle and a plan.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct PlanOrder {
    /// A name out of `/vehicles`.
    pub vehicle: String,
    /// The plan, in the form that `/plans/default` gives; the default plan where it is left out.
    #[serde(default)]
    #[cfg_attr(feature = "openapi", schema(value_type = Option<Object>))]
    pub plan: Option<TrialPlan>,
}

/// What a plan will do on the vehicle expected.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct PlanPreview {
    /// The plan as it would be run.
    #[cfg_attr(feature = "openapi", schema(value_type = Object))]
    pub plan: TrialPlan,
    /// How it ends on a noise-free vehicle: aborted where it does not fit its envelope.
    pub outcome: Option<Outcome>,
    /// Time from the first sample to the last, without repeats, s.
    pub duration_s: f64,
    /// Longest time that the plan can take without repeats, s: the vehicle does not settle before the time for it is up.
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
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
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
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
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

/// The checklist before a trial.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Preflight {
    /// Every check passed.
    pub ready: bool,
    /// Each check.
    pub checks: Vec<Check>,
    /// What would be changed on the vehicle until it is handed back.
    pub changes: Vec<Change>,
}
