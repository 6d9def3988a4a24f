//! The online estimator: guard, filters, recursion and convergence joined.

use core::fmt;

use crate::convergence::{Convergence, ConvergenceSettings};
use crate::guard::{Admission, Cause, Guard, GuardSettings, RejectedCounts};
use crate::instrument::RecursiveInstrument;
use crate::least_squares::{Forgetting, RecursiveLeastSquares};
use crate::state_variable_filter::{FilterStart, FilterStep, Hold, StateVariableFilter};
use crate::{Real, YawModel};

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

/// A setting outside its range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InvalidSetting {
    /// The field, by its name.
    pub field: &'static str,
    /// What it has to be.
    pub requirement: &'static str,
}

impl fmt::Display for InvalidSetting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} must be {}", self.field, self.requirement)
    }
}

impl core::error::Error for InvalidSetting {}

/// How the estimator works. Immutable once the estimator is made.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct EstimatorSettings<T> {
    /// lambda, the filters' double pole, rad/s.
    pub lambda_rad_s: T,
    /// How the heading runs between samples; the rudder is always held.
    pub heading_hold: Hold,
    /// Where the filters start at their first sample.
    pub filter_start: FilterStart,
    /// P0 = this times I.
    pub initial_covariance: T,
    /// Weight of a sample against the next, in (0, 1].
    pub forgetting_factor: T,
    /// Least squares, or the instrumental variable after the excitation.
    pub method: Method,
    /// When the estimate counts as converged.
    pub convergence: ConvergenceSettings<T>,
    /// Which samples are used.
    pub guard: GuardSettings<T>,
}

impl<T: Real> EstimatorSettings<T> {
    /// What the paper does: zero filter state, heading held constant between samples, P0 = 100 I, lambda 1 rad/s,
    /// least squares throughout, every sample used whose numbers and time are sound.
    pub fn paper() -> Self {
        Self {
            lambda_rad_s: T::ONE,
            heading_hold: Hold::ZeroOrder,
            filter_start: FilterStart::Zero,
            initial_covariance: T::of(100.0),
            forgetting_factor: T::ONE,
            method: Method::LeastSquares,
            convergence: ConvergenceSettings {
                threshold: T::of(0.001),
                consecutive: 10,
            },
            guard: GuardSettings {
                gap_time_constants: None,
                warm_time_constants: T::ZERO,
                heading_jump_rad: None,
                max_yaw_rate_rad_s: T::of(3.0),
                refused_in_a_row: 5,
            },
        }
    }

    /// The improved settings for a vehicle whose yaw rate follows the rudder with this time constant
    /// T = -1/a22, s.
    pub fn for_time_scale(time_constant_s: T) -> Self {
        Self {
            lambda_rad_s: T::of(LAMBDA_TIMES_TIME_CONSTANT) / time_constant_s,
            heading_hold: Hold::FirstOrder,
            filter_start: FilterStart::Equilibrium,
            initial_covariance: T::of(1e6),
            method: Method::InstrumentalVariable,
            guard: GuardSettings {
                gap_time_constants: Some(T::ONE),
                warm_time_constants: T::of(8.0),
                heading_jump_rad: Some(T::of(0.2)),
                ..Self::paper().guard
            },
            ..Self::paper()
        }
    }

    fn validate(&self) -> Result<(), InvalidSetting> {
        let positive = |value: T| value > T::ZERO && value.is_finite();
        let rules = [
            (
                positive(self.lambda_rad_s),
                "lambda_rad_s",
                "a positive number",
            ),
            (
                positive(self.initial_covariance),
                "initial_covariance",
                "a positive number",
            ),
            (
                self.forgetting_factor > T::ZERO && self.forgetting_factor <= T::ONE,
                "forgetting_factor",
                "above 0 and at most 1",
            ),
            (
                positive(self.convergence.threshold),
                "convergence.threshold",
                "a positive number",
            ),
            (
                self.convergence.consecutive > 0,
                "convergence.consecutive",
                "at least 1",
            ),
            (
                self.guard.gap_time_constants.is_none_or(positive),
                "guard.gap_time_constants",
                "a positive number or absent",
            ),
            (
                self.guard.warm_time_constants >= T::ZERO
                    && self.guard.warm_time_constants.is_finite(),
                "guard.warm_time_constants",
                "a number not below 0",
            ),
            (
                self.guard.heading_jump_rad.is_none_or(positive),
                "guard.heading_jump_rad",
                "a positive number or absent",
            ),
            (
                positive(self.guard.max_yaw_rate_rad_s),
                "guard.max_yaw_rate_rad_s",
                "a positive number",
            ),
            (
                self.guard.refused_in_a_row > 0,
                "guard.refused_in_a_row",
                "at least 1",
            ),
        ];
        match rules.iter().find(|(holds, ..)| !holds) {
            Some(&(_, field, requirement)) => Err(InvalidSetting { field, requirement }),
            None => Ok(()),
        }
    }
}

impl<T: Real> Default for EstimatorSettings<T> {
    /// For the paper's vehicle: lambda 1.5 rad/s.
    fn default() -> Self {
        Self {
            lambda_rad_s: T::of(1.5),
            ..Self::for_time_scale(T::ONE)
        }
    }
}

/// What became of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
pub enum Intake {
    /// The estimate learnt from it.
    Used,
    /// It only moved the filters.
    Warming,
    /// It was refused.
    Rejected(Cause),
}

/// The filtered signals that enter the regression psi''_f = a22 psi'_f + b2 delta_f + C0 (14), (15).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FilteredSignals<T> {
    /// psi''_f, rad/s^2.
    pub yaw_acceleration_rad_s2: T,
    /// psi'_f, rad/s.
    pub yaw_rate_rad_s: T,
    /// delta_f, rad.
    pub rudder_rad: T,
}

/// Estimates the yaw model while the vehicle manoeuvres.
///
/// Give it the settling data with [`warm`](Self::warm), the training data with [`update`](Self::update), and call
/// [`excitation_ended`](Self::excitation_ended) when the doublet is over; [`restart`](Self::restart) before the next speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimator<T> {
    settings: EstimatorSettings<T>,
    guard: Guard<T>,
    step: FilterStep<T>,
    /// Heading filter and rudder filter, from the first sample on.
    filters: Option<(StateVariableFilter<T>, StateVariableFilter<T>)>,
    /// Filter time to pass before anything is learnt, s.
    unsettled_s: T,
    interval_s: T,
    least_squares: RecursiveLeastSquares<T, 3>,
    instrument: Option<RecursiveInstrument<T>>,
    convergence: Convergence,
    step_norm: T,
    training_start_s: Option<f64>,
}

impl<T: Real> Estimator<T> {
    /// An estimator that has seen nothing.
    pub fn new(settings: EstimatorSettings<T>) -> Result<Self, InvalidSetting> {
        settings.validate()?;
        Ok(Self {
            settings,
            guard: Guard::new(settings.guard, settings.lambda_rad_s),
            step: FilterStep::new(settings.lambda_rad_s),
            filters: None,
            unsettled_s: T::ZERO,
            interval_s: T::ZERO,
            least_squares: RecursiveLeastSquares::new(settings.initial_covariance),
            instrument: None,
            convergence: Convergence::default(),
            step_norm: T::ZERO,
            training_start_s: None,
        })
    }

    /// Takes in a sample of the settling phase: moves the filters, learns nothing.
    pub fn warm(&mut self, time_s: f64, heading_rad: T, rudder_rad: T) -> Intake {
        match self.filter(time_s, heading_rad, rudder_rad) {
            Intake::Used => Intake::Warming,
            other => other,
        }
    }

    /// Takes in a sample of the training phase. The rudder acts from this instant on.
    pub fn update(&mut self, time_s: f64, heading_rad: T, rudder_rad: T) -> Intake {
        let intake = self.filter(time_s, heading_rad, rudder_rad);
        let start_s = match intake {
            Intake::Rejected(_) => return intake,
            _ => *self.training_start_s.get_or_insert(time_s),
        };
        if intake == Intake::Warming {
            return intake;
        }
        let before = self.model().theta();
        if !self.learn() {
            self.guard.count(Cause::NonFinite);
            return Intake::Rejected(Cause::NonFinite);
        }
        let after = self.model().theta();
        self.step_norm = distance(before, after);
        self.convergence
            .observe(self.step_norm, time_s - start_s, &self.settings.convergence);
        Intake::Used
    }

    /// The doublet is over: convergence counts from now on, and the instrument takes over.
    pub fn excitation_ended(&mut self) {
        self.convergence.arm();
        if self.settings.method == Method::InstrumentalVariable && self.instrument.is_none() {
            let now = self.filtered();
            self.instrument =
                RecursiveInstrument::start(&self.least_squares, now.yaw_rate_rad_s, now.rudder_rad);
        }
    }

    /// Forgets the estimate for the next speed; filters and guard run on.
    pub fn restart(&mut self) {
        self.least_squares = RecursiveLeastSquares::new(self.settings.initial_covariance);
        self.instrument = None;
        self.convergence = Convergence::default();
        self.step_norm = T::ZERO;
        self.training_start_s = None;
    }

    /// The estimate.
    pub fn model(&self) -> YawModel<T> {
        match &self.instrument {
            Some(instrument) => YawModel::from_theta(instrument.theta()),
            None => self.least_squares_model(),
        }
    }

    /// The estimate of plain least squares, which runs on beside the instrument.
    pub fn least_squares_model(&self) -> YawModel<T> {
        YawModel::from_theta(self.least_squares.theta())
    }

    /// P of plain least squares.
    pub fn covariance(&self) -> [[T; 3]; 3] {
        self.least_squares.covariance()
    }

    /// The instrument, once it has taken over.
    pub fn instrument(&self) -> Option<&RecursiveInstrument<T>> {
        self.instrument.as_ref()
    }

    /// |Theta(t_k) - Theta(t_k-1)| of the latest sample learnt from (39).
    pub fn step_norm(&self) -> T {
        self.step_norm
    }

    /// Seconds from the first training sample to the detection of convergence.
    pub fn converged_s(&self) -> Option<f64> {
        self.convergence.detected_s()
    }

    /// Samples refused so far, by cause.
    pub fn rejected(&self) -> RejectedCounts {
        self.guard.rejected()
    }

    /// The filtered signals at the latest sample taken in.
    pub fn filtered(&self) -> FilteredSignals<T> {
        match &self.filters {
            Some((heading, rudder)) => FilteredSignals {
                yaw_acceleration_rad_s2: heading.second_derivative(&self.step),
                yaw_rate_rad_s: heading.first_derivative(&self.step),
                rudder_rad: rudder.smoothed(),
            },
            None => FilteredSignals::default(),
        }
    }

    /// The settings it was made with.
    pub fn settings(&self) -> &EstimatorSettings<T> {
        &self.settings
    }

    /// Moves the filters; `Used` means that they may be learnt from.
    fn filter(&mut self, time_s: f64, heading_rad: T, rudder_rad: T) -> Intake {
        let yaw_rate_rad_s = self.filtered().yaw_rate_rad_s;
        let admission = self
            .guard
            .admit(time_s, heading_rad, rudder_rad, yaw_rate_rad_s);
        match (admission, &mut self.filters) {
            (Admission::Rejected(cause), _) => return Intake::Rejected(cause),
            (
                Admission::Next {
                    interval_s,
                    heading_increment_rad,
                },
                Some((heading, rudder)),
            ) => {
                self.step.set_interval(interval_s);
                heading.advance_by(
                    heading_increment_rad,
                    self.settings.heading_hold,
                    &self.step,
                );
                rudder.advance(rudder_rad, Hold::ZeroOrder, &self.step);
                self.interval_s = interval_s;
                self.unsettled_s = (self.unsettled_s - interval_s).max(T::ZERO);
            }
            (Admission::Restart, filters) => {
                *filters = Some(started(FilterStart::Equilibrium, heading_rad, rudder_rad));
                self.interval_s = T::ZERO;
                self.unsettled_s =
                    self.settings.guard.warm_time_constants / self.settings.lambda_rad_s;
            }
            (Admission::First | Admission::Next { .. }, filters) => {
                *filters = Some(started(self.settings.filter_start, heading_rad, rudder_rad));
            }
        }
        if let Some(instrument) = &mut self.instrument {
            let rudder_rad = self
                .filters
                .as_ref()
                .map_or(T::ZERO, |(_, rudder)| rudder.smoothed());
            instrument.advance(rudder_rad, self.interval_s);
        }
        if self.unsettled_s > T::ZERO {
            Intake::Warming
        } else {
            Intake::Used
        }
    }

    fn learn(&mut self) -> bool {
        let now = self.filtered();
        let forgetting = Forgetting {
            factor: self.settings.forgetting_factor,
            trace_limit: T::of(3.0) * self.settings.initial_covariance,
        };
        let regressor = [now.yaw_rate_rad_s, now.rudder_rad, T::ONE];
        let learnt = self
            .least_squares
            .update(regressor, now.yaw_acceleration_rad_s2, forgetting);
        match &mut self.instrument {
            Some(instrument) => {
                instrument.update(
                    now.yaw_rate_rad_s,
                    now.rudder_rad,
                    now.yaw_acceleration_rad_s2,
                ) && learnt
            }
            None => learnt,
        }
    }
}

fn started<T: Real>(
    start: FilterStart,
    heading_rad: T,
    rudder_rad: T,
) -> (StateVariableFilter<T>, StateVariableFilter<T>) {
    (
        StateVariableFilter::new(heading_rad, start),
        StateVariableFilter::new(rudder_rad, start),
    )
}

fn distance<T: Real>(a: [T; 3], b: [T; 3]) -> T {
    let squares: T = a.iter().zip(&b).map(|(a, b)| (*a - *b) * (*a - *b)).sum();
    squares.sqrt()
}
