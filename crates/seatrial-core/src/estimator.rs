//! The online estimator: guard, filters, recursion and convergence joined.

use crate::convergence::{Convergence, Pace, ThetaStep};
use crate::guard::{Admission, Cause, Guard, RejectedCounts};
use crate::instrument::{AuxiliaryModel, RecursiveInstrument};
use crate::least_squares::{Forgetting, RecursiveLeastSquares};
use crate::lost_rudder::UnseenRudder;
use crate::setting::InvalidSetting;
use crate::state_variable_filter::{FilterStart, FilterStep, Hold, StateVariableFilter};
use crate::{PitchModel, Real, YawModel};

pub use crate::estimator_settings::{EstimatorSettings, Method};

/// What became of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
pub enum Intake {
    /// The estimate learnt from it.
    Used,
    /// The sample only moved the filters, or the instrument could not learn from it.
    Warming,
    /// The sample was refused.
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
    /// Theta = [beta, a22, b2, C0], beta of the unseen rudder; [m, a22, b2, C0] where there is a restoring moment.
    least_squares: RecursiveLeastSquares<T, 4>,
    /// Runs from the first training sample on.
    auxiliary: Option<AuxiliaryModel<T>>,
    instrument: Option<RecursiveInstrument<T, 4>>,
    convergence: Convergence<T>,
    theta_step: ThetaStep<T>,
    training_start_s: Option<f64>,
}

impl<T: Real> Estimator<T> {
    /// An estimator that has seen nothing.
    ///
    /// ```
    /// use seatrial_core::{Estimator, EstimatorSettings};
    ///
    /// let settings = EstimatorSettings { lambda_rad_s: -1.5, ..EstimatorSettings::default() };
    /// let error = Estimator::<f64>::new(settings).expect_err("the pole would be unstable");
    /// assert_eq!(error.to_string(), "lambda_rad_s must be a positive number");
    /// ```
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
            theta_step: ThetaStep::none(),
            training_start_s: None,
        })
    }

    /// Takes in a sample of the settling phase: moves the filters, learns nothing. Call it before the training, too, so that the
    /// filters have settled. Answers what became of the sample; [`rejected`](Self::rejected) counts those that were refused.
    ///
    /// ```
    /// use seatrial_core::{Estimator, EstimatorSettings, Intake};
    ///
    /// let mut estimator = Estimator::new(EstimatorSettings::<f64>::default())?;
    /// assert_eq!(estimator.warm(0.0, 0.3, 0.0), Intake::Warming);
    /// // Nothing is learnt from settling data.
    /// assert_eq!(estimator.model().theta(), [0.0; 3]);
    /// # Ok::<(), seatrial_core::InvalidSetting>(())
    /// ```
    pub fn warm(&mut self, time_s: f64, heading_rad: T, rudder_rad: T) -> Intake {
        match self.filter(time_s, heading_rad, rudder_rad) {
            Filtering::Rejected(cause) => Intake::Rejected(cause),
            Filtering::Started | Filtering::Moved { .. } => Intake::Warming,
        }
    }

    /// Takes in a sample of the training phase. The rudder, rad, acts from this instant until the next sample. Answers what
    /// became of the sample; [`rejected`](Self::rejected) counts those that were refused.
    ///
    /// ```
    /// use seatrial_core::{Cause, Estimator, EstimatorSettings, Intake};
    ///
    /// let mut estimator = Estimator::new(EstimatorSettings::<f64>::default())?;
    /// estimator.update(0.00, 0.0, 0.1);
    /// // The same time again, and a heading that is no number.
    /// assert_eq!(estimator.update(0.00, 0.0, 0.1), Intake::Rejected(Cause::RepeatedTime));
    /// assert_eq!(estimator.update(0.05, f64::NAN, 0.1), Intake::Rejected(Cause::NonFinite));
    /// assert_eq!(estimator.rejected().samples(), 2);
    /// # Ok::<(), seatrial_core::InvalidSetting>(())
    /// ```
    pub fn update(&mut self, time_s: f64, heading_rad: T, rudder_rad: T) -> Intake {
        let filtering = self.filter(time_s, heading_rad, rudder_rad);
        let now = self.filtered();
        let before = self.model();
        let (heading_rad, restoring_per_s2) =
            (self.filtered_heading_rad(), self.restoring_per_s2());
        let lambda_rad_s = self.settings.lambda_rad_s;
        let mut passed_s = T::ZERO;
        match (filtering, &mut self.auxiliary) {
            (Filtering::Rejected(cause), _) => return Intake::Rejected(cause),
            (Filtering::Moved { interval_s }, Some(auxiliary)) => {
                passed_s = interval_s;
                match (self.settings.method, restoring_per_s2) {
                    (Method::LeastSquares, _) => {}
                    (Method::InstrumentalVariable, Some(m)) => {
                        let model = PitchModel::righted(&before, m);
                        auxiliary.advance_righted(&model, now.rudder_rad, interval_s);
                    }
                    (Method::InstrumentalVariable, None) => {
                        auxiliary.advance(&before, now.rudder_rad, interval_s, lambda_rad_s);
                    }
                }
            }
            (_, auxiliary) => {
                *auxiliary = Some(match restoring_per_s2 {
                    Some(_) => {
                        AuxiliaryModel::from(heading_rad, now.yaw_rate_rad_s, now.rudder_rad)
                    }
                    None => AuxiliaryModel::new(now.rudder_rad),
                });
            }
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
        self.theta_step = pace.step(before.theta(), self.model().theta());
        if self.convergence.is_open() {
            let step_norm = self.theta_step.norm();
            self.convergence.observe(step_norm, &pace, time_s - start_s, settings);
        }
        Intake::Used
    }

    /// The doublet is over: convergence counts from now on, and the instrument takes over, unless the
    /// estimate is unstable (a22 >= 0, or a moment that overturns) and its auxiliary model would be, too.
    ///
    /// ```
    /// use seatrial_core::model::YawState;
    /// use seatrial_core::{Estimator, EstimatorSettings, YawModel};
    ///
    /// let vehicle = YawModel::from_theta([-1.07, 1.08, 0.012]);
    /// let (mut state, mut estimator) =
    ///     (YawState::default(), Estimator::new(EstimatorSettings::<f64>::default())?);
    /// for k in 0..320 {
    ///     if k == 120 {
    ///         estimator.excitation_ended();
    ///     }
    ///     let rudder_rad = match k {
    ///         40..80 => 0.26,
    ///         80..120 => -0.26,
    ///         _ => 0.0,
    ///     };
    ///     estimator.update(0.05 * f64::from(k), state.heading_rad, rudder_rad);
    ///     state = vehicle.advance(state, rudder_rad, 0.05);
    /// }
    /// assert!((estimator.model().a22_per_s + 1.07).abs() < 0.01);
    /// // Seconds since the first sample; without the doublet's end there is no convergence.
    /// assert!(estimator.converged_s().is_some_and(|converged_s| converged_s > 6.0));
    /// # Ok::<(), seatrial_core::InvalidSetting>(())
    /// ```
    pub fn excitation_ended(&mut self) {
        self.convergence.arm();
        let is_due =
            self.settings.method == Method::InstrumentalVariable && self.instrument.is_none();
        if is_due && self.is_stable(&self.least_squares.theta()) {
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
        self.theta_step = ThetaStep::none();
        self.training_start_s = None;
    }

    /// The estimate.
    pub fn model(&self) -> YawModel<T> {
        yaw_model(self.theta())
    }

    /// m of the restoring moment, 1/s^2, negative where it rights the vehicle. `None` where the settings have none.
    pub fn restoring_per_s2(&self) -> Option<T> {
        let [m, ..] = self.theta();
        self.settings.has_restoring_moment.then_some(m)
    }

    /// The parameters of the instrument once it has taken over; with a restoring moment, only while they are stable.
    #[inline]
    fn theta(&self) -> [T; 4] {
        let instrument = self.instrument.as_ref().map(RecursiveInstrument::theta);
        instrument
            .filter(|theta| !self.settings.has_restoring_moment || self.is_stable(theta))
            .unwrap_or(self.least_squares.theta())
    }

    fn is_stable(&self, theta: &[T; 4]) -> bool {
        let [m, a22, ..] = *theta;
        a22 < T::ZERO && (!self.settings.has_restoring_moment || m < T::ZERO)
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
        self.theta_step.norm()
    }

    /// Seconds from the first training sample to the detection of convergence.
    pub fn converged_s(&self) -> Option<f64> {
        self.convergence.detected_s()
    }

    /// Samples refused so far, by cause.
    ///
    /// ```
    /// use seatrial_core::{Estimator, EstimatorSettings};
    ///
    /// let mut estimator = Estimator::new(EstimatorSettings::<f64>::default())?;
    /// for k in 0..20 {
    ///     // One heading of 3 rad among zeros.
    ///     estimator.update(0.05 * f64::from(k), if k == 10 { 3.0 } else { 0.0 }, 0.0);
    /// }
    /// assert_eq!(estimator.rejected().spike, 1);
    /// # Ok::<(), seatrial_core::InvalidSetting>(())
    /// ```
    pub fn rejected(&self) -> RejectedCounts {
        self.guard.rejected()
    }

    /// The filtered signals at the latest sample taken in.
    ///
    /// ```
    /// use seatrial_core::{Estimator, EstimatorSettings};
    ///
    /// let mut estimator = Estimator::new(EstimatorSettings::<f64>::default())?;
    /// // 12 s of a turn of 0.2 rad/s, wherever it begins.
    /// for k in 0..240 {
    ///     estimator.update(0.05 * f64::from(k), 3.0 + 0.01 * f64::from(k), 0.1);
    /// }
    /// assert!((estimator.filtered().yaw_rate_rad_s - 0.2).abs() < 1e-5);
    /// # Ok::<(), seatrial_core::InvalidSetting>(())
    /// ```
    #[inline]
    pub fn filtered(&self) -> FilteredSignals<T> {
        let Some((heading, rudder)) = &self.filters else { return FilteredSignals::default() };
        FilteredSignals {
            yaw_acceleration_rad_s2: heading.second_derivative(&self.step),
            yaw_rate_rad_s: heading.first_derivative(&self.step),
            rudder_rad: rudder.smoothed(),
        }
    }

    /// The angle at the latest sample taken in, filtered, rad, unwrapped.
    fn filtered_heading_rad(&self) -> T {
        let heading = self.filters.as_ref().map(|(heading, _)| heading.smoothed());
        heading.unwrap_or(T::ZERO)
    }

    /// The settings it was made with.
    pub fn settings(&self) -> &EstimatorSettings<T> {
        &self.settings
    }

    #[inline]
    fn filter(&mut self, time_s: f64, heading_rad: T, rudder_rad: T) -> Filtering<T> {
        let yaw_rate_rad_s = self.filtered().yaw_rate_rad_s;
        let admission = self.guard.admit(time_s, heading_rad, rudder_rad, yaw_rate_rad_s);
        match (admission, &mut self.filters) {
            (Admission::Rejected(cause), _) => Filtering::Rejected(cause),
            (
                Admission::Next { interval_s, heading_increment_rad, usual_interval_s },
                Some((heading, rudder)),
            ) => {
                let lost = self.settings.lost_rudder;
                let moved_rad = rudder_rad - rudder.signal();
                let mut advance = |interval_s, turned_rad, moved_rad, steps| {
                    self.step.set_interval(interval_s);
                    for _ in 0..steps {
                        heading.advance_by(turned_rad, self.settings.heading_hold, &self.step);
                        rudder.advance_by(moved_rad, Hold::ZeroOrder, &self.step);
                    }
                };
                match lost.steps(interval_s, usual_interval_s) {
                    1 => advance(interval_s, heading_increment_rad, moved_rad, 1),
                    steps => {
                        let share = T::ONE / T::of(f64::from(steps));
                        let [interval_s, turned_rad, moved_rad] =
                            [interval_s, heading_increment_rad, moved_rad].map(|all| all * share);
                        advance(interval_s, turned_rad, moved_rad, steps);
                    }
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
        if self.settings.has_restoring_moment {
            return;
        }
        if self.unseen.is_learnt(self.settings.lambda_rad_s) {
            self.unseen.settle(self.beta());
            self.reset_beta(self.settings.initial_covariance);
        }
        self.unseen.add(moved_rad, unseen_s, &mut self.step);
    }

    fn beta(&self) -> T {
        let [beta, ..] = self.theta();
        match self.settings.has_restoring_moment {
            true => T::ZERO,
            false => beta,
        }
    }

    fn reset_beta(&mut self, variance: T) {
        if self.settings.has_restoring_moment {
            return;
        }
        self.least_squares.reset_first(variance);
        if let Some(instrument) = &mut self.instrument {
            instrument.reset_first(variance);
        }
    }

    #[inline]
    fn learn(&mut self, now: &FilteredSignals<T>) -> Intake {
        let forgetting = Forgetting {
            factor: self.settings.forgetting_factor,
            trace_limit: T::of(4.0) * self.settings.initial_covariance,
        };
        let has_restoring_moment = self.settings.has_restoring_moment;
        let first_rad = match has_restoring_moment {
            true => self.filtered_heading_rad(),
            false => self.unseen.pulse_rad(),
        };
        let regressor = [first_rad, now.yaw_rate_rad_s, now.rudder_rad, T::ONE];
        let observation = now.yaw_acceleration_rad_s2 - self.unseen.settled_rad_s2();
        let has_first = has_restoring_moment || self.unseen.has_pulse();
        let learnt = match has_first {
            true => self.least_squares.update(regressor, observation, forgetting),
            false => self.least_squares.update_without_first(&regressor, observation, forgetting),
        };
        if !learnt {
            self.guard.count(Cause::NonFinite);
            return Intake::Rejected(Cause::NonFinite);
        }
        if let (Some(recursion), Some(auxiliary)) = (&mut self.instrument, &self.auxiliary) {
            let rate_rad_s = auxiliary.yaw_rate_rad_s();
            let first_rad = match has_restoring_moment {
                true => auxiliary.heading_rad(),
                false => first_rad,
            };
            let instrument = [first_rad, rate_rad_s, now.rudder_rad, T::ONE];
            let learnt = match has_first {
                true => recursion.update(regressor, instrument, observation),
                false => recursion.update_without_first(&regressor, &instrument, observation),
            };
            if !learnt {
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
    (StateVariableFilter::new(heading_rad, start), StateVariableFilter::new(rudder_rad, start))
}

/// Least squares before the first sample, which knows nothing but that no rudder edge is unseen.
fn without_samples<T: Real>(settings: &EstimatorSettings<T>) -> RecursiveLeastSquares<T, 4> {
    let mut least_squares = RecursiveLeastSquares::new(settings.initial_covariance);
    if !settings.has_restoring_moment {
        least_squares.reset_first(T::ZERO);
    }
    least_squares
}

fn yaw_model<T: Real>([_, a22_per_s, b2_per_s2, c0_rad_per_s2]: [T; 4]) -> YawModel<T> {
    YawModel::from_theta([a22_per_s, b2_per_s2, c0_rad_per_s2])
}

fn yaw_block<T: Real>([_, a22, b2, c0]: [[T; 4]; 4]) -> [[T; 3]; 3] {
    [a22, b2, c0].map(|[_, a22, b2, c0]| [a22, b2, c0])
}
