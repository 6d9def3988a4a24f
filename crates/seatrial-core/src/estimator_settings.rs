//! How the online estimator works.

use crate::Real;
use crate::convergence::ConvergenceSettings;
use crate::guard::GuardSettings;
use crate::lost_rudder::LostRudder;
use crate::setting::{InvalidSetting, is_positive, require};
use crate::state_variable_filter::{FilterStart, Hold};

/// lambda T of the default filter: 1.5 rad/s for the paper's vehicle, T = 1/1.07 s.
const LAMBDA_TIMES_TIME_CONSTANT: f64 = 1.5 / 1.07;

/// How the parameters are estimated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Method {
    /// Recursive least squares throughout.
    LeastSquares,
    /// Recursive least squares during the excitation, the recursive instrumental variable after it.
    InstrumentalVariable,
}

/// How the estimator works. Immutable once the estimator is made.
///
/// The default suits a vehicle like the paper's, whose yaw rate follows the rudder in about a second:
/// [`for_lambda`](Self::for_lambda) with 1.5 rad/s. For a slower or faster vehicle begin with
/// [`for_time_scale`](Self::for_time_scale); its time constant need be known to a factor of two only.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(default, deny_unknown_fields, bound(deserialize = "T: Real + serde::Deserialize<'de>"))
)]
pub struct EstimatorSettings<T> {
    /// lambda, the filters' double pole, rad/s.
    pub lambda_rad_s: T,
    /// How the heading runs between samples; the rudder is always held.
    pub heading_hold: Hold,
    /// How the rudder ran while samples were lost.
    pub lost_rudder: LostRudder,
    /// Where the filters start at their first sample.
    pub filter_start: FilterStart,
    /// P0 = this times I.
    pub initial_covariance: T,
    /// By which the weight of every sample is multiplied when the next one comes, in (0, 1]; 1 forgets nothing.
    pub forgetting_factor: T,
    /// Least squares, or the instrumental variable after the excitation.
    pub method: Method,
    /// When the estimate counts as converged.
    pub convergence: ConvergenceSettings<T>,
    /// Which samples are used.
    pub guard: GuardSettings<T>,
    /// Is there a moment m that rights the angle, as there is in pitch? Then psi'' = a22 psi' + m psi + b2 delta + C0 is estimated, and a
    /// rudder edge that lost samples hide has no parameter of its own.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "core::ops::Not::not"))]
    pub has_restoring_moment: bool,
}

impl<T: Real> EstimatorSettings<T> {
    /// What the paper does: zero filter state, heading held constant between samples, P0 = 100 I, lambda 1 rad/s,
    /// least squares throughout, every sample used whose numbers and time are sound.
    ///
    /// ```
    /// use seatrial_core::{EstimatorSettings, Method};
    ///
    /// let paper = EstimatorSettings::<f64>::paper();
    /// assert_eq!((paper.lambda_rad_s, paper.method), (1.0, Method::LeastSquares));
    /// // No silence is a gap and no heading a spike.
    /// assert_eq!((paper.guard.gap_time_constants, paper.guard.heading_jump_rad), (None, None));
    /// ```
    pub fn paper() -> Self {
        Self {
            lambda_rad_s: T::ONE,
            heading_hold: Hold::ZeroOrder,
            lost_rudder: LostRudder::Held,
            filter_start: FilterStart::Zero,
            initial_covariance: T::of(100.0),
            forgetting_factor: T::ONE,
            method: Method::LeastSquares,
            convergence: ConvergenceSettings {
                threshold: T::of(0.001),
                consecutive: 10,
                in_own_time: false,
            },
            guard: GuardSettings {
                gap_time_constants: None,
                warm_time_constants: T::ZERO,
                heading_jump_rad: None,
                max_yaw_rate_rad_s: T::of(3.0),
                refused_in_a_row: 5,
            },
            has_restoring_moment: false,
        }
    }

    /// The improved settings with filters of this lambda, rad/s: [`for_time_scale`](Self::for_time_scale) of the vehicle for
    /// which it is chosen.
    ///
    /// ```
    /// use seatrial_core::EstimatorSettings;
    ///
    /// assert_eq!(EstimatorSettings::<f64>::for_lambda(1.5), EstimatorSettings::default());
    /// ```
    pub fn for_lambda(lambda_rad_s: T) -> Self {
        Self {
            lambda_rad_s,
            ..Self::for_time_scale(T::of(LAMBDA_TIMES_TIME_CONSTANT) / lambda_rad_s)
        }
    }

    /// The improved settings for a vehicle whose yaw rate follows the rudder with this time constant
    /// T = -1/a22, s. Instants, spans and rates follow T; what is relative to them is fixed: a silence above
    /// 1/lambda is a gap, after which the filters settle for 8/lambda (0.3 % of their wrong start is left).
    ///
    /// ```
    /// use seatrial_core::EstimatorSettings;
    ///
    /// // A ship whose yaw rate follows the rudder in 30 s.
    /// let settings = EstimatorSettings::<f64>::for_time_scale(30.0);
    /// assert!((settings.lambda_rad_s - 0.0467).abs() < 1e-4);
    /// // What turns faster than 0.1 rad/s is no such ship.
    /// assert!((settings.guard.max_yaw_rate_rad_s - 0.1).abs() < 1e-12);
    /// ```
    pub fn for_time_scale(time_constant_s: T) -> Self {
        Self {
            lambda_rad_s: T::of(LAMBDA_TIMES_TIME_CONSTANT) / time_constant_s,
            heading_hold: Hold::FirstOrder,
            lost_rudder: LostRudder::Interpolated,
            filter_start: FilterStart::Equilibrium,
            initial_covariance: T::of(1e6),
            method: Method::InstrumentalVariable,
            convergence: ConvergenceSettings { in_own_time: true, ..Self::paper().convergence },
            guard: GuardSettings {
                gap_time_constants: Some(T::ONE),
                warm_time_constants: T::of(8.0),
                heading_jump_rad: Some(T::of(0.2)),
                max_yaw_rate_rad_s: T::of(3.0) / time_constant_s,
                ..Self::paper().guard
            },
            ..Self::paper()
        }
    }

    /// Names the first setting that is out of its range.
    ///
    /// ```
    /// use seatrial_core::EstimatorSettings;
    ///
    /// let settings = EstimatorSettings { forgetting_factor: 1.01, ..EstimatorSettings::<f64>::default() };
    /// assert_eq!(settings.check().map_err(|error| error.field), Err("forgetting_factor"));
    /// ```
    pub fn check(&self) -> Result<(), InvalidSetting> {
        let positive = "a positive number";
        require(is_positive(self.lambda_rad_s), "lambda_rad_s", positive)?;
        require(is_positive(self.initial_covariance), "initial_covariance", positive)?;
        require(
            self.forgetting_factor > T::ZERO && self.forgetting_factor <= T::ONE,
            "forgetting_factor",
            "above 0 and at most 1",
        )?;
        self.convergence.check()?;
        self.guard.check()
    }
}

impl<T: Real> Default for EstimatorSettings<T> {
    /// For the paper's vehicle: lambda 1.5 rad/s.
    fn default() -> Self {
        Self::for_lambda(T::of(1.5))
    }
}
