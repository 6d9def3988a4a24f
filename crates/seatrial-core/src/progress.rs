//! What a trial tells: events, results of runs, and where it is.

use crate::envelope::EnvelopeUse;
use crate::guard::RejectedCounts;
use crate::validation::GoodnessOfFit;
use crate::{Outcome, YawModel};

/// The stages of a run, section IV-B.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Stage {
    /// Waiting for steady heading, rate and depth.
    Settle,
    /// Estimating during the training doublet.
    Train,
    /// Recording the validation doublet.
    Validate,
}

/// A run at one thrust with its result.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RunResult<T> {
    /// 1 for the first run of the trial.
    pub number: u32,
    /// Thrust as a fraction of full.
    pub thrust: T,
    /// 1 for the first try at this thrust.
    pub attempt: u32,
    /// Was the vehicle steady before training?
    pub settled: bool,
    /// The estimate.
    pub model: YawModel<T>,
    /// m of the restoring moment, 1/s^2, on the axis of pitch.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub restoring_per_s2: Option<T>,
    /// The estimate of plain least squares on the same samples.
    pub least_squares_model: YawModel<T>,
    /// P of plain least squares.
    pub covariance: [[T; 3]; 3],
    /// Seconds from the start of training to convergence (39).
    pub converged_s: Option<f64>,
    /// Simulation of the validation stage.
    pub validation: GoodnessOfFit<T>,
    /// Mean forward speed over the training stage, m/s.
    pub surge_speed_m_s: Option<T>,
    /// Samples of the training stage that the estimate learnt from.
    pub samples_used: u32,
    /// Samples refused during the run, by cause.
    pub rejected: RejectedCounts,
    /// Is R^2 of the heading high enough?
    pub accepted: bool,
}

/// What happened, for whoever watches or records.
///
/// ```
/// use seatrial_core::{AbortReason, Event, Outcome, Plan, Sample, Trial};
///
/// let mut trial = Trial::new(Plan::<f64>::paper())?;
/// let _ = trial.step(&Sample::default());
/// assert!(matches!(trial.take_event(), Some(Event::RunStarted { number: 1, .. })));
/// trial.abort(AbortReason::Operator);
/// // First neutral rudder, then the last action; both give the thrust back to the vehicle.
/// let actions = [0.05, 0.10].map(|time_s| trial.step(&Sample { time_s, ..Sample::default() }));
/// assert_eq!(actions.map(|action| action.thrust), [None, None]);
/// assert_eq!(actions[1].outcome, Some(Outcome::Aborted(AbortReason::Operator)));
/// # Ok::<(), seatrial_core::InvalidSetting>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Event<T> {
    /// A run begins; its settling stage with it.
    RunStarted {
        /// 1 for the first run of the trial.
        number: u32,
        /// Thrust as a fraction of full.
        thrust: T,
        /// 1 for the first try at this thrust.
        attempt: u32,
    },
    /// A stage begins with the sample of this time, which is its first.
    StageStarted {
        /// Which stage.
        stage: Stage,
        /// Time of its first sample, s.
        time_s: f64,
    },
    /// The estimate stopped moving (39).
    Converged {
        /// Seconds since the start of training.
        elapsed_s: f64,
    },
    /// A run is over. The sample of this time is no longer part of it.
    RunFinished {
        /// Time of the first sample after the run, s.
        time_s: f64,
        /// Its result.
        result: RunResult<T>,
    },
    /// The trial is over.
    Ended {
        /// Time of the latest sample, s.
        time_s: f64,
        /// How it ended.
        outcome: Outcome,
    },
}

/// Where the trial is, for a live view.
///
/// ```
/// use seatrial_core::progress::Stage;
/// use seatrial_core::{Plan, Sample, Trial};
///
/// let mut trial = Trial::new(Plan::<f64>::paper())?;
/// assert_eq!(trial.status().stage, None);
/// let _ = trial.step(&Sample::default());
/// let status = trial.status();
/// assert_eq!((status.run, status.speed, status.stage), (1, 1, Some(Stage::Settle)));
/// # Ok::<(), seatrial_core::InvalidSetting>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Status<T> {
    /// 1 for the first run, 0 before it.
    pub run: u32,
    /// 1 for the first speed.
    pub speed: usize,
    /// Speeds of the plan.
    pub speeds: usize,
    /// Thrust of the run as a fraction of full.
    pub thrust: T,
    /// 1 for the first try at this thrust.
    pub attempt: u32,
    /// The stage; `None` before the first sample and after the end.
    pub stage: Option<Stage>,
    /// Time in the stage, s.
    pub elapsed_s: f64,
    /// Time until the stage ends at the latest, s.
    pub remaining_s: f64,
    /// The estimate; all 0 before there is one.
    pub model: YawModel<T>,
    /// Length of the latest step of the estimate (39).
    pub step_norm: T,
    /// How much of each limit is used.
    pub envelope: EnvelopeUse<T>,
    /// How the trial ended.
    pub outcome: Option<Outcome>,
}
