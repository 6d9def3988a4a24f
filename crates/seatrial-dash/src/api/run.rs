//! A run: its stages, its model, its verdict, and the operator's decision.

use seatrial_app::models::Estimate as Figure;
use serde::{Deserialize, Serialize};

/// The stages of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// Waiting for steady heading, rate and depth.
    Settle,
    /// Estimating during the training manoeuvre.
    Train,
    /// Recording the validation manoeuvre.
    Validate,
}

/// How a trial ended.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Outcome {
    /// Every speed was run.
    pub finished: bool,
    /// Why it was aborted: `operator`, `depth`, `area`, ...
    pub reason: Option<String>,
    /// In words.
    pub text: String,
}

/// One reason of a verdict.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Reason {
    /// Short and stable.
    pub code: String,
    /// The channel or the part that it is about, where the code has several.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub of: Option<String>,
    /// The cause, in a sentence.
    pub text: String,
    /// What to do about it; empty where nothing is to be done.
    pub action: String,
}

/// What a person may do with a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum VerdictOutcome {
    /// Use it.
    Use,
    /// Use it inside the stated range; the cause names what limits it.
    UseWithCare,
    /// It fits its training record, and nothing was held out to check it.
    NotValidated,
    /// Do not use it.
    DoNotUse,
}

/// An outcome and what decides it.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Verdict {
    /// What a person may do with the model.
    pub outcome: VerdictOutcome,
    /// What decides it.
    pub cause: Option<Reason>,
    /// How many reasons beside the cause reject the model or limit its use.
    pub other_causes: usize,
    /// What the gains of a whole campaign or log promise, in sentences; empty for one run.
    #[serde(default)]
    pub promises: Vec<String>,
}

/// A stage of a run and its time, half open.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct StageSpan {
    /// Which.
    pub stage: Stage,
    /// First sample, s of the vehicle's clock.
    pub from_s: f64,
    /// The end; null where it has none.
    pub to_s: Option<f64>,
}

/// The model of one speed: psi' = r, r' = a22 r + b2 delta + C0.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
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
    /// R^2 of heading on validation data.
    pub r2_heading: Option<f64>,
    /// R^2 of heading on validation data with the offset C0 estimated again on them.
    pub r2_heading_offset_refit: Option<f64>,
    /// R^2 of yaw rate on validation data.
    pub r2_yaw_rate: Option<f64>,
    /// Seconds into training at which the online estimate converged.
    pub converged_s: Option<f64>,
    /// The method that the model comes from.
    pub method: String,
}

/// An operator's decision on a run.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Review {
    /// May it be used?
    pub accepted: bool,
    /// Why.
    pub note: String,
    /// Name of the operator.
    pub by: String,
    /// When, UTC.
    pub time: String,
}

/// A run.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
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
    /// May it be used? The operator's decision goes before the program's verdict.
    pub accepted: bool,
    /// Whether it may be used, in the four words that every part of seatrial uses, and what decides it.
    pub verdict: Verdict,
    /// Why.
    pub reasons: Vec<Reason>,
    /// The model, where training was finished.
    pub model: Option<Model>,
    /// The operator's decision.
    pub review: Option<Review>,
}

/// Measured and simulated over the validation stage.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
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
