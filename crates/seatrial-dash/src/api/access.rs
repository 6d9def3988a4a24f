//! Who may command, who does, and what was commanded; the vehicles to command.

use serde::{Deserialize, Serialize};

/// Why a request was refused.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct ErrorBody {
    /// Short and stable, for programs: `control_taken`, `token_needed`, `not_found`, ...
    pub code: String,
    /// For people: what was found, what was expected and what to do.
    pub message: String,
}

/// What the bearer of a token may do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// Look.
    Viewer,
    /// Look and command.
    Operator,
}

/// Who commands. Control lapses a minute after its holder was last heard.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Control {
    /// The name that its holder gave; null where nobody has control.
    pub holder: Option<String>,
    /// Since when, UTC.
    pub since: Option<String>,
    /// Time since its holder was last heard, s; after 60 s control lapses.
    pub silent_for_s: Option<f64>,
    /// Is it you, by the lease of your request?
    pub is_you: bool,
}

/// Asks for control.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct TakeControl {
    /// Your name, which others see: 1 to 64 characters.
    #[cfg_attr(feature = "openapi", schema(min_length = 1, max_length = 64))]
    pub name: String,
}

/// Control: commands bear it in the header `seatrial-lease`.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Lease {
    /// The secret that proves it.
    pub lease: String,
    /// Seconds without a sign of life after which it lapses. Requests with the header and a live stream that was
    /// opened with the lease are signs of life.
    pub lapses_after_s: f64,
}

/// What the server can be asked to run on.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Vehicles {
    /// Names for `vehicle` of a trial.
    pub vehicles: Vec<VehicleForm>,
    /// Names for `scenario` of a trial on a simulator.
    pub scenarios: Vec<ScenarioForm>,
}

/// Faults that a simulator can play, by name.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct ScenarioForm {
    /// `bad_compass`.
    pub name: String,
    /// For people.
    pub description: String,
}

/// A vehicle by name.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct VehicleForm {
    /// `sim:starfish`, `mavlink:udp:0.0.0.0:14550`.
    pub name: String,
    /// For people.
    pub description: String,
    /// A simulator; anything else moves.
    pub is_simulated: bool,
    /// Has an autopilot whose gains a commission can try.
    pub has_gains: bool,
}
