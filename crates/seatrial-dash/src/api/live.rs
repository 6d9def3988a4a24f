//! The live stream, `/api/v1/live`: text frames with one JSON document each.
//!
//! The client says [`Hello`] first, within 10 s. The server answers with a [`Snapshot`], or, where it still has everything
//! after the number that the client saw last, with what was missed. Then each message bears the next number.

use serde::{Deserialize, Serialize};

use super::{
    CommissionState, Control, EnvelopeUse, EstimateNow, Health, Outcome, Progress, RunSummary,
    Stage, TrialState, ValidationOverlay, Verdict,
};

/// The client's first message.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct Hello {
    /// The token, where one is needed and the request had no bearer header.
    #[serde(default)]
    pub token: Option<String>,
    /// The lease of control: the stream keeps it alive.
    #[serde(default)]
    pub lease: Option<String>,
    /// The stream that was seen before, out of its snapshot.
    #[serde(default)]
    pub stream: Option<String>,
    /// The number of the last message seen.
    #[serde(default)]
    pub after: Option<u64>,
}

/// What the server says.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct LiveMessage {
    /// Rises by one from message to message; that of a snapshot, a heartbeat or a notice of loss is the number of the last
    /// event before it.
    pub sequence: u64,
    /// The event.
    #[serde(flatten)]
    pub event: LiveEvent,
}

/// What happened.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum LiveEvent {
    /// Everything as it is: replaces what the client knows.
    Snapshot(Box<Snapshot>),
    /// A trial begins.
    TrialStarted {
        /// It.
        trial: Box<TrialState>,
    },
    /// A run begins: charts of a run start anew.
    RunStarted {
        /// 1 for the first run of the campaign.
        run: u32,
        /// Thrust as a fraction of full.
        thrust: f64,
        /// 1 for the first try at this thrust.
        attempt: u32,
    },
    /// A stage begins.
    StageStarted {
        /// Run.
        run: u32,
        /// The stage.
        stage: Stage,
        /// Time of its first sample, s.
        time_s: f64,
        /// Longest that it may take, s.
        at_most_s: f64,
    },
    /// Samples since the last such message, which come at most 20 times a second.
    Samples {
        /// In order.
        samples: Vec<LiveSample>,
        /// Where the trial is after the last one.
        progress: Progress,
        /// The estimate after the last one.
        estimate: Option<EstimateNow>,
        /// How much of each limit is used.
        envelope: Vec<EnvelopeUse>,
    },
    /// A run is over.
    RunEnded {
        /// With its model, intervals and verdict.
        run: Box<RunSummary>,
        /// Its validation, measured and simulated.
        validation: Option<ValidationOverlay>,
    },
    /// The trial is over and the vehicle handed back.
    TrialEnded {
        /// How; null where it ended by a fault.
        outcome: Option<Outcome>,
        /// That of the campaign; null where a fault of the program ended it.
        verdict: Option<Verdict>,
        /// Its runs, each judged within the campaign.
        runs: Vec<RunSummary>,
        /// What could not be saved, or why the vehicle was given back.
        warnings: Vec<String>,
    },
    /// Somebody took or gave back control; `is_you` is false here whoever reads.
    Control {
        /// Who has it now.
        control: Control,
    },
    /// A commission begins, reports or ends.
    Commission {
        /// It.
        commission: Box<CommissionState>,
    },
    /// Once a second while a trial runs.
    Health {
        /// Link and clock.
        health: Health,
    },
    /// Every 5 s: the server is there.
    Heartbeat {
        /// The server's clock, UTC.
        now: String,
    },
    /// You read too slowly; a snapshot follows.
    Lagged {
        /// Messages that you were not sent.
        missed: u64,
    },
    /// The server ends the stream.
    Goodbye {
        /// Short and stable: `token_needed`, `too_many_requests`, `hello_expected`, `shutting_down`.
        code: String,
        /// For people.
        message: String,
    },
}

/// Everything that a viewer needs to draw.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Snapshot {
    /// Name of the stream: another one after the server was started again.
    pub stream: String,
    /// The server's clock, UTC.
    pub now: String,
    /// Who commands.
    pub control: Control,
    /// The trial that runs, or the last one.
    pub trial: Option<TrialState>,
    /// The commission that runs, or the last one.
    #[serde(default)]
    pub commission: Option<CommissionState>,
    /// Samples of the present run; of a long one every n-th.
    pub samples: Vec<LiveSample>,
    /// Estimates of the present run; of a long one every n-th.
    pub estimates: Vec<EstimateNow>,
    /// The track of the trial, [north, east], m; of a long one every n-th point.
    pub track_m: Vec<[f64; 2]>,
    /// The limits of the trial.
    pub envelope: Option<Envelope>,
    /// Link and clock.
    pub health: Option<Health>,
    /// How the stream behaves.
    pub settings: StreamSettings,
}

/// How the stream behaves.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct StreamSettings {
    /// Shortest time between two messages with samples, s.
    pub samples_every_s: f64,
    /// Time between two heartbeats, s.
    pub heartbeat_every_s: f64,
}

/// A sample as it is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct LiveSample {
    /// The vehicle's clock, s.
    pub time_s: f64,
    /// Stage.
    pub stage: Option<Stage>,
    /// Heading, rad; null where it is no number.
    pub heading_rad: Option<f64>,
    /// Rudder, rad.
    pub rudder_rad: Option<f64>,
    /// Yaw rate, rad/s: measured, or else from the headings.
    pub yaw_rate_rad_s: Option<f64>,
    /// Forward speed, m/s.
    pub surge_speed_m_s: Option<f64>,
    /// Depth, m.
    pub depth_m: Option<f64>,
    /// Position north, m.
    pub north_m: Option<f64>,
    /// Position east, m.
    pub east_m: Option<f64>,
    /// In the validation stage: heading simulated with the model just trained, rad.
    pub simulated_heading_rad: Option<f64>,
}

/// The limits of a trial that are drawn.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Envelope {
    /// Corners [north, east], m; empty is anywhere.
    pub area_m: Vec<[f64; 2]>,
    /// Shallowest depth, m.
    pub depth_min_m: f64,
    /// Greatest depth, m.
    pub depth_max_m: f64,
    /// Farthest heading from that of the run, rad.
    pub heading_excursion_max_rad: f64,
    /// Largest yaw rate, rad/s.
    pub yaw_rate_max_rad_s: f64,
    /// Largest rudder that the trial commands, rad.
    pub rudder_limit_rad: f64,
}
