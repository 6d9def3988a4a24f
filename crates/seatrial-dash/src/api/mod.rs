//! What goes over the wire.
//!
//! All quantities are SI, angles radians; a missing thing is null. A name ends in its unit.

mod access;
mod commission;
mod history;
mod live;
mod log;
mod models;
mod plan;
mod run;
mod status;
mod trial;

pub use seatrial_app::models::Estimate as Figure;
pub use seatrial_logbook::CommandEntry as AuditEntry;

pub use access::{
    Control, ErrorBody, Lease, Role, ScenarioForm, TakeControl, VehicleForm, Vehicles,
};
pub use commission::{
    CommissionEnd, CommissionOrder, CommissionPreview, CommissionSample, CommissionShown,
    CommissionState, ExpectedSteps, MeasuredSteps, ParameterBack, ProposedGains, UndoOrder,
    UndoPreview, Undone,
};
pub use history::{
    CampaignDetail, CampaignSummary, Comparison, Difference, OperatingPoint, ReviewOrder, Schedule,
    SchedulePoint, State, ThrustComparison, WhatChanged,
};
pub use live::{Envelope, Hello, LiveEvent, LiveMessage, LiveSample, Snapshot, StreamSettings};
pub use log::{IdentifiedLog, InspectedLog, LogColumns};
pub use models::ModelOrder;
pub use plan::{Change, Check, ExpectedIntervals, PlanOrder, PlanPreview, Preflight, SpeedPreview};
pub use run::{
    Model, Outcome, Reason, Review, RunSummary, Stage, StageSpan, ValidationOverlay, Verdict,
    VerdictOutcome,
};
pub use status::Status;
pub use trial::{
    EnvelopeUse, EstimateNow, GoOnOrder, Health, Progress, RepeatOrder, TrialOrder, TrialState,
};
