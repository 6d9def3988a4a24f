//! A commission: gains into an autopilot, tried by heading steps, kept or put back.

use serde::{Deserialize, Serialize};

use super::{Change, Check};

/// Asks for a commission, or for what it would do.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct CommissionOrder {
    /// A name out of `/vehicles` whose `has_gains` is true.
    pub vehicle: String,
    /// Number of the campaign whose models give the gains.
    pub campaign: i64,
    /// Speed whose model is taken, m/s; the autopilot's own where it is left out.
    #[serde(default)]
    #[cfg_attr(feature = "openapi", schema(exclusive_minimum = 0.0))]
    pub at_speed_m_s: Option<f64>,
    /// Size of the steps, rad, 0.09 to 1.57 [default: 0.52].
    #[serde(default)]
    #[cfg_attr(feature = "openapi", schema(exclusive_minimum = 0.0))]
    pub step_rad: Option<f64>,
    /// Uses models of a rehearsal on a simulator as well.
    #[serde(default)]
    pub rehearsal: bool,
    /// What a preview calls its proposal. Where the autopilot or the campaign gives another one now, nothing is started.
    #[serde(default)]
    pub proposal: Option<String>,
    /// The vehicle moves and its gains are changed: true agrees to it.
    #[serde(default)]
    pub agreed: bool,
}

/// What a commission would do. Nothing is changed yet.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct CommissionPreview {
    /// Every check passed, and there are gains to propose.
    pub ready: bool,
    /// Each check.
    pub checks: Vec<Check>,
    /// What is changed on the vehicle until it is handed back, beside the gains.
    pub changes: Vec<Change>,
    /// Why no gains are proposed; null where they are.
    pub refused: Option<String>,
    /// The gains that are proposed.
    pub proposed: Option<ProposedGains>,
}

/// Gains beside those that an autopilot has.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct ProposedGains {
    /// What to send back with the order.
    pub proposal: String,
    /// Parameters that change: now, proposed, why.
    pub parameters: Vec<Change>,
    /// Speed of the model, m/s.
    pub surge_speed_m_s: Option<f64>,
    /// Size of the steps, rad.
    pub step_rad: f64,
    /// How long the steps take at most, s.
    pub duration_s: f64,
    /// Water that is needed ahead at most, m.
    pub distance_m: Option<f64>,
    /// What the present gains are expected to do.
    pub old_expected: ExpectedSteps,
    /// What the proposed ones are.
    pub new_expected: ExpectedSteps,
}

/// What steps are expected to be, each as 95 % bounds.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct ExpectedSteps {
    /// Overshoot as a fraction of the step.
    pub overshoot: [f64; 2],
    /// Time until the heading stays within 5 % of the step, s.
    pub settling_s: [f64; 2],
    /// Travel of the rudder, full deflections per second.
    pub rudder_per_s: [f64; 2],
}

/// What steps were.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct MeasuredSteps {
    /// Overshoot as a fraction of the step.
    pub overshoot: f64,
    /// Time until the heading stayed within 5 % of the step, s; null where it did not.
    pub settling_s: Option<f64>,
    /// Heading error at the end, rad.
    pub steady_error_rad: f64,
    /// Travel of the rudder, full deflections per second.
    pub rudder_per_s: f64,
}

/// How a commission ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum CommissionEnd {
    /// The new gains are proven and stay.
    Kept,
    /// The old gains are back: the new ones did worse than they may, or an operator has undone the commission.
    PutBack,
    /// Nothing was written: the model does not tell what the boat did.
    Refused,
    /// It was stopped, and the old gains are back.
    Aborted,
}

/// A commission that runs, or the last one since the server began.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct CommissionState {
    /// Does it run?
    pub running: bool,
    /// The vehicle by name.
    pub vehicle: String,
    /// Number of the campaign whose model gives the gains.
    pub campaign: i64,
    /// When it began, UTC.
    pub started: String,
    /// The gains.
    pub proposed: ProposedGains,
    /// What was reported as it went, in words.
    pub stages: Vec<String>,
    /// Steps with the old gains.
    pub old: Option<MeasuredSteps>,
    /// Steps with the new gains.
    pub new: Option<MeasuredSteps>,
    /// How it ended; null while it runs.
    pub ended: Option<CommissionEnd>,
    /// Which gains are in, why, and how to undo it.
    pub line: Option<String>,
    /// The command that puts the old gains back, where the new ones stayed.
    pub undo: Option<String>,
    /// Is something left that has to be put back by hand?
    pub needs_restoring: bool,
}

/// A sample of the steps.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct CommissionSample {
    /// The vehicle's clock, s.
    pub time_s: f64,
    /// Heading, rad; null where it is no number.
    pub heading_rad: Option<f64>,
    /// The heading that is asked for, rad.
    pub wanted_rad: Option<f64>,
    /// Rudder as a fraction of full.
    pub rudder: Option<f64>,
}

/// A commission and its newest samples.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct CommissionShown {
    /// The commission; null where there was none.
    pub commission: Option<CommissionState>,
    /// Samples from number `after` on, at most 5000.
    pub samples: Vec<CommissionSample>,
    /// What to ask for next: the number of the first sample that is not here.
    pub next: u64,
}

/// Asks for the parameters that a trial or a commission has changed to be put back.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct UndoOrder {
    /// A name out of `/vehicles` whose `has_gains` is true.
    pub vehicle: String,
    /// What a preview calls it. Where the file or the autopilot's values are others now, nothing is written.
    #[serde(default)]
    pub undo: Option<String>,
    /// The parameters are written: true agrees to it.
    #[serde(default)]
    pub agreed: bool,
}

/// A parameter that can be put back, or was.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct ParameterBack {
    /// Its name.
    pub name: String,
    /// What it is before; null where the autopilot did not say.
    pub from: Option<f64>,
    /// What it is after.
    pub to: f64,
}

/// What would be put back. Nothing is written yet.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct UndoPreview {
    /// What to send back with the order.
    pub undo: String,
    /// The name of the file that keeps the old values.
    pub file: String,
    /// Each parameter as it is and as it was.
    pub parameters: Vec<ParameterBack>,
    /// Is the mode put back, too, unless somebody has chosen another since?
    pub has_mode: bool,
}

/// What was put back.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Undone {
    /// Is everything as it was, read back?
    pub complete: bool,
    /// In words.
    pub line: String,
    /// Each parameter before and now.
    pub parameters: Vec<ParameterBack>,
}
