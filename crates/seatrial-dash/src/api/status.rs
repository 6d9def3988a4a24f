//! The server at a glance.

use serde::{Deserialize, Serialize};

use super::{Control, Health, Role, TrialState};

/// The server, and who has control.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Status {
    /// The version of seatrial.
    pub version: String,
    /// The server's clock, UTC, RFC 3339. Yours may differ.
    pub now: String,
    /// What you may do.
    pub role: Role,
    /// Is a token needed here?
    pub token_needed: bool,
    /// The file that keeps everything.
    pub logbook: String,
    /// Who commands.
    pub control: Control,
    /// The trial that runs, or the last one since the server began.
    pub trial: Option<TrialState>,
    /// The link to the vehicle and its clock, while a trial runs.
    pub health: Option<Health>,
    /// Viewers of the live stream.
    pub viewers: u32,
}
