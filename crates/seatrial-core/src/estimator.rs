//! The online estimator: guard, filters, recursion and convergence joined.

use crate::convergence::{Convergence, ConvergenceSettings, Pace};
use crate::guard::{Admission, Cause, Guard, GuardSettings, RejectedCounts};
use crate::instrument::{AuxiliaryModel, RecursiveInstrument};
use crate::least_squares::{Forgetting, RecursiveLeastSquares};
use crate::lost_rudder::{LostRudder, UnseenRudder};
use crate::setting::{InvalidSetting, is_positive, require};
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

/// How the estimator works. Immutable once the estimator is made.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(
        default,
        deny_unknown_fields,
        bound(deserialize = "T: Real + serde::Deserialize<'de>")
    )
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
}

impl<T: Real> EstimatorSettings<T> {
    /// What the paper does: zero filter state, heading held constant between samples, P0 = 100 I, lambda 1 rad/s,
    /// least squares throughout, every sample used whose numbers and time are sound.
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
        }
    }

    /// The improved settings with filters of this lambda: those of the vehicle whose default it is.
    pub fn for_lambda(lambda_rad_s: T) -> Self {
        Self {
            lambda_rad_s,
            ..Self::for_time_scale(T::of(LAMBDA_TIMES_TIME_CONSTANT) / lambda_rad_s)
        }
    }

    /// The improved settings for a vehicle whose yaw rate follows the rudder with this time constant
    /// T = -1/a22, s. Instants, spans and rates follow T; what is relative to them is fixed: a silence above
    /// 1/lambda is a gap, after which the filters settle for 8/lambda (0.3 % of their wrong start is left).
    pub fn for_time_scale(time_constant_s: T) -> Self {
        Self {
            lambda_rad_s: T::of(LAMBDA_TIMES_TIME_CONSTANT) / time_constant_s,
            heading_hold: Hold::FirstOrder,
            lost_rudder: LostRudder::Interpolated,
            filter_start: FilterStart::Equilibrium,
            initial_covariance: T::of(1e6),
            method: Method::InstrumentalVariable,
            convergence: ConvergenceSettings {
                in_own_time: true,
                ..Self::paper().convergence
            },
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
    pub fn check(&self) -> Result<(), InvalidSetting> {
        let positive = "a positive number";
        require(is_positive(self.lambda_rad_s), "lambda_rad_s", positive)?;
        require(
            is_positive(self.initial_covariance),
            "initial_covariance",
            positive,
        )?;
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

/// What became of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
pub enum Intake {
    /// The estimate learnt from it.
    Used,
    /// It only moved the filters, or the instrument could not learn from it.
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
    unseen: UnseenRudder<T>,
    /// Theta = [beta, a22, b2, C0], beta of the unseen rudder.
    least_squares: RecursiveLeastSquares<T, 4>,
    /// Runs from the first training sample on.
    auxiliary: Option<AuxiliaryModel<T>>,
    instrument: Option<RecursiveInstrument<T, 4>>,
    convergence: Convergence<T>,
    step_norm: T,
    training_start_s: Option<f64>,
}

impl<T: Real> Estimator<T> {
    /// An estimator that has seen nothing.
    pub fn new(settings: EstimatorSettings<T>) -> Result<Self, InvalidSetting> {
        settings.check()?;
        Ok(Self {
            settings,
            guard: Guard::new(settings.guard, settings.lambda_rad_s),
            step: FilterStep::new(settings.lambda_rad_s),
            filters: None,
            unsettled_s: T::ZERO,
            unseen: UnseenRudder::none(),
            least_squares: without_samples(&settings),
            auxiliary: None,
            instrument: None,
            convergence: Convergence::default(),
            step_norm: T::ZERO,
            training_start_s: None,
        })
    }

    /// Takes in a sample of the settling phase: moves the filters, learns nothing. Call it before the training, too, so that the
    /// filters have settled. Answers what became of the sample; [`rejected`](Self::rejected) counts those that were refused.
    pub fn warm(&mut self, time_s: f64, heading_rad: T, rudder_rad: T) -> Intake {
        match self.filter(time_s, heading_rad, rudder_rad) {
            Filtering::Rejected(cause) => Intake::Rejected(cause),
            Filtering::Started | Filtering::Moved { .. } => Intake::Warming,
        }
    }

    /// Takes in a sample of the training phase. The rudder, rad, acts from this instant until the next sample. Answers what
    /// became of the sample; [`rejected`](Self::rejected) counts those that were refused.
    pub fn update(&mut self, time_s: f64, heading_rad: T, rudder_rad: T) -> Intake {
        let filtering = self.filter(time_s, heading_rad, rudder_rad);
        let now = self.filtered();
        let before = self.model();
        let lambda_rad_s = self.settings.lambda_rad_s;
        let mut passed_s = T::ZERO;
        match (filtering, &mut self.auxiliary) {
            (Filtering::Rejected(cause), _) => return Intake::Rejected(cause),
            (Filtering::Moved { interval_s }, Some(auxiliary)) => {
                passed_s = interval_s;
                auxiliary.advance(&before, now.rudder_rad, interval_s, lambda_rad_s);
            }
            (_, auxiliary) => *auxiliary = Some(AuxiliaryModel::new(now.rudder_rad)),
        }
        let start_s = *self.training_start_s.get_or_insert(time_s);
        if self.unsettled_s > T::ZERO {
            return Intake::Warming;
        }
        let learnt = self.learn(&now);
        if learnt != Intake::Used {
            return learnt;
        }
        let settings = &self.settings.convergence;
        let pace = Pace::new(settings, lambda_rad_s, passed_s);
        self.step_norm = pace.step_norm(before.theta(), self.model().theta());
        self.convergence
            .observe(self.step_norm, &pace, time_s - start_s, settings);
        Intake::Used
    }

    /// The doublet is over: convergence counts from now on, and the instrument takes over, unless the
    /// estimate is unstable (a22 >= 0) and its auxiliary model would be, too.
    pub fn excitation_ended(&mut self) {
        self.convergence.arm();
        let stable = self.least_squares_model().a22_per_s < T::ZERO;
        if self.settings.method == Method::InstrumentalVariable
            && self.instrument.is_none()
            && stable
        {
            self.instrument = Some(RecursiveInstrument::take_over(&self.least_squares));
        }
    }

    /// Forgets the estimate for the next speed; filters and guard run on.
    pub fn restart(&mut self) {
        self.unseen.settle(self.beta());
        self.least_squares = without_samples(&self.settings);
        self.auxiliary = None;
        self.instrument = None;
        self.convergence = Convergence::default();
        self.step_norm = T::ZERO;
        self.training_start_s = None;
    }

    /// The estimate.
    pub fn model(&self) -> YawModel<T> {
        match &self.instrument {
            Some(instrument) => yaw_model(instrument.theta()),
            None => self.least_squares_model(),
        }
    }

    /// The estimate of plain least squares, which runs on beside the instrument.
    pub fn least_squares_model(&self) -> YawModel<T> {
        yaw_model(self.least_squares.theta())
    }

    /// P of plain least squares.
    pub fn covariance(&self) -> [[T; 3]; 3] {
        yaw_block(self.least_squares.covariance())
    }

    /// The instrument, once it has taken over; its parameters are [beta, a22, b2, C0] with beta of
    /// [`UnseenRudder`].
    pub fn instrument(&self) -> Option<&RecursiveInstrument<T, 4>> {
        self.instrument.as_ref()
    }

    /// |Theta(t_k) - Theta(t_k-1)| of the latest sample learnt from (39), in the vehicle's own time where the
    /// settings say so.
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

    fn filter(&mut self, time_s: f64, heading_rad: T, rudder_rad: T) -> Filtering<T> {
        let yaw_rate_rad_s = self.filtered().yaw_rate_rad_s;
        let admission = self
            .guard
            .admit(time_s, heading_rad, rudder_rad, yaw_rate_rad_s);
        match (admission, &mut self.filters) {
            (Admission::Rejected(cause), _) => Filtering::Rejected(cause),
            (
                Admission::Next {
                    interval_s,
                    heading_increment_rad,
                    usual_interval_s,
                },
                Some((heading, rudder)),
            ) => {
                let lost = self.settings.lost_rudder;
                let moved_rad = rudder_rad - rudder.signal();
                let steps = lost.steps(interval_s, usual_interval_s);
                let share = T::ONE / T::of(f64::from(steps));
                self.step.set_interval(interval_s * share);
                for _ in 0..steps {
                    let turned_rad = heading_increment_rad * share;
                    heading.advance_by(turned_rad, self.settings.heading_hold, &self.step);
                    rudder.advance_by(moved_rad * share, Hold::ZeroOrder, &self.step);
                }
                self.unseen.advance(interval_s, &mut self.step);
                if lost.hides_edge(interval_s, usual_interval_s, moved_rad) {
                    self.add_unseen(moved_rad, interval_s - usual_interval_s);
                }
                self.unsettled_s = (self.unsettled_s - interval_s).max(T::ZERO);
                Filtering::Moved { interval_s }
            }
            (Admission::Restart, filters) => {
                *filters = Some(started(FilterStart::Equilibrium, heading_rad, rudder_rad));
                self.unseen = UnseenRudder::none();
                self.reset_beta(T::ZERO);
                self.unsettled_s =
                    self.settings.guard.warm_time_constants / self.settings.lambda_rad_s;
                Filtering::Started
            }
            (Admission::First | Admission::Next { .. }, filters) => {
                *filters = Some(started(self.settings.filter_start, heading_rad, rudder_rad));
                Filtering::Started
            }
        }
    }

    /// Gives a rudder movement that fell among lost samples a parameter of its own.
    fn add_unseen(&mut self, moved_rad: T, unseen_s: T) {
        if self.unseen.is_learnt(self.settings.lambda_rad_s) {
            self.unseen.settle(self.beta());
            self.reset_beta(self.settings.initial_covariance);
        }
        self.unseen.add(moved_rad, unseen_s, &mut self.step);
    }

    fn beta(&self) -> T {
        let [beta, ..] = match &self.instrument {
            Some(instrument) => instrument.theta(),
            None => self.least_squares.theta(),
        };
        beta
    }

    fn reset_beta(&mut self, variance: T) {
        self.least_squares.reset_first(variance);
        if let Some(instrument) = &mut self.instrument {
            instrument.reset_first(variance);
        }
    }

    fn learn(&mut self, now: &FilteredSignals<T>) -> Intake {
        let forgetting = Forgetting {
            factor: self.settings.forgetting_factor,
            trace_limit: T::of(4.0) * self.settings.initial_covariance,
        };
        let pulse_rad = self.unseen.pulse_rad();
        let regressor = [pulse_rad, now.yaw_rate_rad_s, now.rudder_rad, T::ONE];
        let observation = now.yaw_acceleration_rad_s2 - self.unseen.settled_rad_s2();
        if !self
            .least_squares
            .update(regressor, observation, forgetting)
        {
            self.guard.count(Cause::NonFinite);
            return Intake::Rejected(Cause::NonFinite);
        }
        if let (Some(recursion), Some(auxiliary)) = (&mut self.instrument, &self.auxiliary) {
            let rate_rad_s = auxiliary.yaw_rate_rad_s();
            let instrument = [pulse_rad, rate_rad_s, now.rudder_rad, T::ONE];
            if !recursion.update(regressor, instrument, observation) {
                return Intake::Warming;
            }
        }
        Intake::Used
    }
}

/// What became of the filters.
enum Filtering<T> {
    Rejected(Cause),
    Started,
    Moved { interval_s: T },
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

/// Nothing known but that nothing is unseen.
fn without_samples<T: Real>(settings: &EstimatorSettings<T>) -> RecursiveLeastSquares<T, 4> {
    let mut least_squares = RecursiveLeastSquares::new(settings.initial_covariance);
    least_squares.reset_first(T::ZERO);
    least_squares
}

fn yaw_model<T: Real>([_, a22_per_s, b2_per_s2, c0_rad_per_s2]: [T; 4]) -> YawModel<T> {
    YawModel::from_theta([a22_per_s, b2_per_s2, c0_rad_per_s2])
}

fn yaw_block<T: Real>([_, a22, b2, c0]: [[T; 4]; 4]) -> [[T; 3]; 3] {
    [a22, b2, c0].map(|[_, a22, b2, c0]| [a22, b2, c0])
}
