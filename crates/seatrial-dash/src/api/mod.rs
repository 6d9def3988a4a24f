//! The contract: what goes over the wire, and its OpenAPI document.
//!
//! All quantities are SI, angles radians; a missing thing is null. A name ends in its unit.

mod access;
mod history;
mod live;
mod log;
mod trial;

pub use access::{
    AuditEntry, Control, ErrorBody, Lease, Role, Status, TakeControl, VehicleForm, Vehicles,
};
pub use history::{
    CampaignDetail, CampaignSummary, Comparison, Difference, OperatingPoint, Review, ReviewOrder,
    Schedule, SchedulePoint, State, ThrustComparison, WhatChanged,
};
pub use live::{
    Envelope, EnvelopeUse, Hello, LiveEvent, LiveMessage, LiveSample, Snapshot, StreamSettings,
};
pub use log::{IdentifiedLog, InspectedLog, LogReading, LogSeries};
pub use trial::{
    Change, Check, EstimateNow, ExpectedIntervals, Figure, GoOnOrder, Health, Model, Outcome,
    PlanOrder, PlanPreview, Preflight, Progress, Reason, RepeatOrder, RunSummary, SpeedPreview,
    Stage, StageSpan, TrialOrder, TrialState, ValidationOverlay,
};

use utoipa::OpenApi;

/// The OpenAPI document of the server, pretty JSON.
pub fn openapi_json() -> String {
    crate::routes::Api::openapi()
        .to_pretty_json()
        .expect("the document is made of plain data")
        + "\n"
}
