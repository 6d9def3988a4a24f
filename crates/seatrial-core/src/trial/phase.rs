//! Where a trial is.

use crate::progress::RunResult;
use crate::rudder_sense::RudderSenseWatch;
use crate::settle::SettleGate;
use crate::validation::Validation;
use crate::{AbortReason, Outcome};

/// What is done with samples.
#[derive(Clone, Copy, Debug)]
pub(super) enum Phase<T> {
    Waiting,
    Settle(SettleGate<T>),
    Train(Option<RudderSenseWatch<T>>),
    Validate(Validation<T>),
    Over(Outcome),
}

/// The phase that a sample belongs to.
pub(super) enum Due<T> {
    Same,
    Settle,
    Train { settled: bool },
    Validate,
    NextRun(RunResult<T>),
    Abort(AbortReason),
}
