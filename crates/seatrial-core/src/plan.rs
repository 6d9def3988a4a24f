//! The plan of a trial.

use crate::envelope::Envelope;
use crate::estimator::EstimatorSettings;
use crate::setting::{InvalidSetting, is_positive, require};
use crate::settle::Settle;
use crate::{Axis, Excitation, List, Real, RudderSense};

/// Most speeds of a trial.
pub const SPEEDS: usize = 16;

/// lambda P of the default filter: 1.5 rad/s for the paper's doublet of 4 s.
const LAMBDA_TIMES_PERIOD: f64 = 6.0;

/// More repeats never end.
const MOST_REPEATS: u32 = 100;

/// The paper's vehicle at its middle speed: T = 1/1.07 s (Table II).
const PAPER_TIME_CONSTANT_S: f64 = 1.0 / 1.07;

/// How many times slower than the paper's vehicle one is whose yaw rate follows the rudder with this time constant T = -1/a22, s.
///
/// ```
/// use seatrial_core::plan::times_slower;
///
/// // A ship with T = 28 s beside the paper's vehicle with 0.93 s.
/// assert!((times_slower(28.0) - 30.0).abs() < 0.1);
/// ```
pub fn times_slower(time_constant_s: f64) -> f64 {
    time_constant_s / PAPER_TIME_CONSTANT_S
}

/// However slow the vehicle, its gyro's noise may not end the trial, rad/s.
const LOWEST_YAW_RATE_LIMIT_RAD_S: f64 = 0.05;

/// A stage with a manoeuvre: steady, manoeuvre, observe.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Manoeuvre<T> {
    /// Heading hold before the manoeuvre, s.
    pub lead_in_s: f64,
    /// The manoeuvre.
    pub excitation: Excitation<T>,
    /// Heading hold after the manoeuvre, s.
    pub observe_s: f64,
}

impl<T: Real> Manoeuvre<T> {
    /// From the first sample of the stage to its end, s.
    ///
    /// ```
    /// use seatrial_core::{Excitation, Manoeuvre};
    ///
    /// let excitation = Excitation::Doublet { amplitude_rad: 0.26, period_s: 4.0 };
    /// let training = Manoeuvre { lead_in_s: 2.0, excitation, observe_s: 10.0 };
    /// assert_eq!((training.excitation_end_s(), training.duration_s()), (6.0, 16.0));
    /// ```
    pub fn duration_s(&self) -> f64 {
        self.excitation_end_s() + self.observe_s
    }

    /// From the first sample of the stage to the end of the excitation, s.
    pub fn excitation_end_s(&self) -> f64 {
        self.lead_in_s + self.excitation.duration_s()
    }
}

/// What the settings of a manoeuvre are called where it stands.
struct ManoeuvreFields {
    lead_in_s: &'static str,
    excitation: &'static str,
    observe_s: &'static str,
}

const TRAINING: ManoeuvreFields = ManoeuvreFields {
    lead_in_s: "training.lead_in_s",
    excitation: "training.excitation",
    observe_s: "training.observe_s",
};

const VALIDATION: ManoeuvreFields = ManoeuvreFields {
    lead_in_s: "validation.lead_in_s",
    excitation: "validation.excitation",
    observe_s: "validation.observe_s",
};

/// What an excitation has to be.
const EXCITATION: &str = "a manoeuvre of positive duration and an amplitude within rudder_limit_rad; a multisine has 1 to 16 tones";

impl<T: Real> Manoeuvre<T> {
    fn check(&self, fields: &ManoeuvreFields) -> Result<(), InvalidSetting> {
        let positive = "a positive number";
        require(is_positive(self.lead_in_s), fields.lead_in_s, positive)?;
        let moves = self.excitation.is_valid() && self.excitation.amplitude_rad() != T::ZERO;
        require(moves, fields.excitation, EXCITATION)?;
        require(is_positive(self.observe_s), fields.observe_s, positive)
    }
}

/// The plan of a trial. [`Default`] is the paper's, Section IV-B.
///
/// [`Trial::new`](crate::Trial::new) checks it; a trial never changes its plan.
///
/// ```
/// use seatrial_core::{Plan, Trial};
///
/// let plan = Plan { rudder_limit_rad: 0.2, ..Plan::<f64>::paper() };
/// // Its training doublet asks for 0.26 rad.
/// assert_eq!(Trial::new(plan).map_err(|error| error.field).err(), Some("training.excitation"));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(default, deny_unknown_fields, bound(deserialize = "T: Real + serde::Deserialize<'de>"))
)]
pub struct Plan<T> {
    /// The motion that is identified. [`Plan::pitch`] is a plan of pitch; fields that a file leaves out are those of yaw.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Axis::is_yaw"))]
    pub axis: Axis,
    /// The speeds, as thrust in fractions of full, in the order of the runs.
    pub thrusts: List<T, SPEEDS>,
    /// Largest rudder that the trial commands, rad.
    pub rudder_limit_rad: T,
    /// Time between samples that the vehicle is expected to keep, s.
    pub sample_interval_s: f64,
    /// End training when the estimate has converged; otherwise the whole stage is recorded, which
    /// the estimate from the whole record needs.
    pub stop_on_convergence: bool,
    /// A run is accepted from this R^2 of heading on, see [`GoodnessOfFit::reaches`](crate::GoodnessOfFit::reaches).
    pub accept_from_r2: T,
    /// Times a run that is not accepted is repeated, at most 100.
    pub max_repeats: u32,
    /// When training may begin.
    pub settle: Settle<T>,
    /// Stage 2.
    pub training: Manoeuvre<T>,
    /// Stage 3.
    pub validation: Manoeuvre<T>,
    /// The estimator; derived from the training manoeuvre where absent.
    pub estimator: Option<EstimatorSettings<T>>,
    /// Limits within which the trial may go on.
    pub envelope: Envelope<T>,
}

impl<T: Real> Default for Plan<T> {
    fn default() -> Self {
        Self::paper()
    }
}

impl<T: Real> Plan<T> {
    /// The paper's plan: thrust 60 to 100 %, doublets of 0.26 and 0.15 rad and 4 s.
    ///
    /// ```
    /// use seatrial_core::{Excitation, Plan};
    ///
    /// let plan = Plan::<f64>::paper();
    /// assert_eq!(plan.training.excitation, Excitation::Doublet { amplitude_rad: 0.26, period_s: 4.0 });
    /// assert_eq!((plan.accept_from_r2, plan.thrusts.first().copied()), (0.6, Some(0.6)));
    /// ```
    pub fn paper() -> Self {
        Self::paced(1.0, 0.05)
    }

    /// The paper's plan in the time of a vehicle whose yaw rate follows the rudder with this time constant T = -1/a22, s:
    /// every time is T / 0.93 s of the paper's, every rate the inverse; angles, thrusts and depths stay.
    ///
    /// ```
    /// use seatrial_core::{Plan, Trial};
    ///
    /// // A ship thirty times slower, sampled once a second.
    /// let plan = Plan::<f64>::for_time_constant(28.0, 1.0);
    /// assert!((plan.training.excitation.duration_s() - 120.0).abs() < 0.5);
    /// assert!(Trial::new(plan).is_ok());
    /// ```
    pub fn for_time_constant(time_constant_s: f64, sample_interval_s: f64) -> Self {
        Self::paced(times_slower(time_constant_s), sample_interval_s)
    }

    /// The plan of a trial of pitch: the paper's thrusts, with elevator doublets of half the length and two thirds of the size,
    /// because pitch changes depth. The vehicle holds its depth for 40 s before each training.
    ///
    /// ```
    /// use seatrial_core::{Axis, Plan};
    ///
    /// let plan = Plan::<f64>::pitch();
    /// assert_eq!(plan.axis, Axis::Pitch);
    /// assert!(
    ///     plan.training.excitation.amplitude_rad() < Plan::paper().training.excitation.amplitude_rad()
    /// );
    /// ```
    pub fn pitch() -> Self {
        let manoeuvre = |amplitude_rad| Manoeuvre {
            lead_in_s: 2.0,
            excitation: Excitation::Doublet { amplitude_rad: T::of(amplitude_rad), period_s: 2.0 },
            observe_s: 12.5,
        };
        let yaw = Self::paper();
        Self {
            axis: Axis::Pitch,
            rudder_limit_rad: T::of(0.18),
            settle: Settle {
                // Trim differs from speed to speed: what is held is the depth.
                heading_tolerance_rad: T::of(0.5),
                at_least_s: 40.0,
                at_most_s: 40.0,
                ..yaw.settle
            },
            training: manoeuvre(0.18),
            validation: manoeuvre(0.12),
            envelope: Envelope {
                pitch_max_rad: T::of(0.5),
                depth_change_max_m: Some(T::ONE),
                depth_min_m: T::of(-1.0),
                depth_max_m: T::of(1000.0),
                rudder_sense: RudderSense::Unknown,
                ..yaw.envelope
            },
            ..yaw
        }
    }

    fn paced(pace: f64, sample_interval_s: f64) -> Self {
        let manoeuvre = |amplitude_rad| Manoeuvre {
            lead_in_s: 2.0 * pace,
            excitation: Excitation::Doublet {
                amplitude_rad: T::of(amplitude_rad),
                period_s: 4.0 * pace,
            },
            observe_s: 10.5 * pace,
        };
        let (settle, envelope) = (Settle::<T>::default(), Envelope::<T>::default());
        let two_samples_s = 2.0 * sample_interval_s;
        Self {
            axis: Axis::Yaw,
            thrusts: List::from_slice(&[0.6, 0.7, 0.8, 0.9, 1.0].map(T::of)).unwrap_or_default(),
            rudder_limit_rad: T::of(0.26),
            sample_interval_s,
            stop_on_convergence: false,
            accept_from_r2: T::of(0.6),
            max_repeats: 2,
            settle: Settle {
                yaw_rate_tolerance_rad_s: settle.yaw_rate_tolerance_rad_s / T::of(pace),
                steady_for_s: (settle.steady_for_s * pace).max(two_samples_s),
                at_least_s: settle.at_least_s * pace,
                at_most_s: settle.at_most_s * pace,
                ..settle
            },
            training: manoeuvre(0.26),
            validation: manoeuvre(0.15),
            estimator: None,
            envelope: Envelope {
                yaw_rate_max_rad_s: (envelope.yaw_rate_max_rad_s / T::of(pace))
                    .max(T::of(LOWEST_YAW_RATE_LIMIT_RAD_S)),
                stage_time_limit_s: envelope.stage_time_limit_s * pace,
                stale_after_s: envelope.stale_after_s.max(two_samples_s),
                ..envelope
            },
        }
    }

    /// The settings of the estimator: those of the plan, or lambda = 6 / (twice the longest
    /// deflection), 1.5 rad/s for the paper's doublet.
    ///
    /// ```
    /// use seatrial_core::Plan;
    ///
    /// // 6 over the doublet's 4 s.
    /// assert!((Plan::<f64>::paper().estimator_settings().lambda_rad_s - 1.5).abs() < 1e-12);
    /// ```
    pub fn estimator_settings(&self) -> EstimatorSettings<T> {
        let settings = self.estimator.unwrap_or_else(|| {
            let period_s = 2.0 * self.training.excitation.longest_deflection_s();
            EstimatorSettings::for_lambda(T::of(LAMBDA_TIMES_PERIOD / period_s))
        });
        EstimatorSettings { has_restoring_moment: self.axis == Axis::Pitch, ..settings }
    }

    /// Longest that the trial can take without a repeat, s.
    ///
    /// ```
    /// use seatrial_core::{List, Plan};
    ///
    /// let plan = Plan::<f64>::paper();
    /// let one_speed = Plan { thrusts: List::from_slice(&[0.8]).unwrap_or_default(), ..plan };
    /// assert!((plan.longest_s() / one_speed.longest_s() - plan.thrusts.len() as f64).abs() < 1e-9);
    /// ```
    pub fn longest_s(&self) -> f64 {
        let run_s =
            self.settle.at_most_s + self.training.duration_s() + self.validation.duration_s();
        self.thrusts.iter().map(|_| run_s).sum()
    }

    /// Names the first setting that is out of its range. The estimator's own settings are checked by
    /// [`Estimator::new`](crate::Estimator::new).
    pub(crate) fn check(&self) -> Result<(), InvalidSetting> {
        require(
            !self.thrusts.is_empty() && self.thrusts.iter().all(|t| *t > T::ZERO && *t <= T::ONE),
            "thrusts",
            "a list of 1 to 16 fractions of full thrust, above 0 and at most 1",
        )?;
        require(self.max_repeats <= MOST_REPEATS, "max_repeats", "at most 100")?;
        require(
            is_positive(self.rudder_limit_rad) && self.rudder_limit_rad < T::PI / T::of(2.0),
            "rudder_limit_rad",
            "a positive angle below pi/2 rad",
        )?;
        require(
            (0.001..=1000.0).contains(&self.sample_interval_s),
            "sample_interval_s",
            "a time from 0.001 to 1000 s",
        )?;
        require(
            self.accept_from_r2 <= T::ONE && self.accept_from_r2 >= -T::ONE,
            "accept_from_r2",
            "a number from -1 to 1",
        )?;
        self.settle.check()?;
        self.training.check(&TRAINING)?;
        self.validation.check(&VALIDATION)?;
        self.envelope.check()?;
        self.check_together()
    }

    /// What one setting asks of another.
    fn check_together(&self) -> Result<(), InvalidSetting> {
        for (manoeuvre, fields) in [(&self.training, TRAINING), (&self.validation, VALIDATION)] {
            require(
                manoeuvre.excitation.amplitude_rad().abs() <= self.rudder_limit_rad,
                fields.excitation,
                EXCITATION,
            )?;
        }
        let two_samples_s = 2.0 * self.sample_interval_s;
        let two_samples = "at least two sample intervals";
        require(self.settle.steady_for_s >= two_samples_s, "settle.steady_for_s", two_samples)?;
        let envelope = &self.envelope;
        require(
            envelope.stale_after_s.is_finite() && envelope.stale_after_s >= two_samples_s,
            "envelope.stale_after_s",
            two_samples,
        )?;
        let longest_manoeuvre_s = self.training.duration_s().max(self.validation.duration_s());
        require(
            envelope.stage_time_limit_s.is_finite()
                && envelope.stage_time_limit_s > longest_manoeuvre_s,
            "envelope.stage_time_limit_s",
            "longer than the training and the validation stage",
        )
    }
}
