//! The lean estimator for a loop of fixed rate.

use crate::estimator::EstimatorSettings;
use crate::setting::{InvalidSetting, is_positive, require};
use crate::state_variable_filter::{FilterStart, FilterStep, Hold, StateVariableFilter};
use crate::{Real, YawModel};

/// Filtered signals are less together (in 1/s^2, 1/s and 1, root of the sum of squares) on any vehicle; with larger ones `f32` would
/// overflow.
const LARGEST_SIGNAL: f64 = 1e6;
/// With a larger P0 it would, too.
const LARGEST_INITIAL_COVARIANCE: f64 = 1e9;

/// How a [`FixedRateEstimator`] works.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FixedRateSettings<T> {
    /// h, time between samples, s.
    pub sample_interval_s: T,
    /// lambda, the filters' double pole, rad/s.
    pub lambda_rad_s: T,
    /// How the heading runs between samples; the rudder is always held.
    pub heading_hold: Hold,
    /// Where the filters start at their first sample.
    pub filter_start: FilterStart,
    /// p, P0 = p I.
    pub initial_covariance: T,
}

impl<T: Real> FixedRateSettings<T> {
    /// What the paper does, P0 = 100 I, at this sampling interval.
    pub fn paper(sample_interval_s: T) -> Self {
        let paper = EstimatorSettings::<T>::paper();
        Self {
            sample_interval_s,
            lambda_rad_s: paper.lambda_rad_s,
            heading_hold: paper.heading_hold,
            filter_start: paper.filter_start,
            initial_covariance: paper.initial_covariance,
        }
    }

    /// Heading on straight lines between samples, filters in equilibrium at the first sample, P0 = 100 I.
    ///
    /// ```
    /// use seatrial_core::{FixedRateSettings, Hold};
    ///
    /// let settings = FixedRateSettings::<f32>::for_lambda(1.5, 0.05);
    /// assert_eq!((settings.heading_hold, settings.initial_covariance), (Hold::FirstOrder, 100.0));
    /// ```
    pub fn for_lambda(lambda_rad_s: T, sample_interval_s: T) -> Self {
        Self {
            lambda_rad_s,
            heading_hold: Hold::FirstOrder,
            filter_start: FilterStart::Equilibrium,
            ..Self::paper(sample_interval_s)
        }
    }

    /// Names the first setting that is out of its range.
    ///
    /// ```
    /// use seatrial_core::FixedRateSettings;
    ///
    /// let settings = FixedRateSettings::<f32>::paper(0.0);
    /// assert_eq!(settings.check().map_err(|error| error.field), Err("sample_interval_s"));
    /// ```
    pub fn check(&self) -> Result<(), InvalidSetting> {
        let positive = "a positive number";
        require(is_positive(self.sample_interval_s), "sample_interval_s", positive)?;
        require(is_positive(self.lambda_rad_s), "lambda_rad_s", positive)?;
        require(
            is_positive(self.initial_covariance)
                && self.initial_covariance <= T::of(LARGEST_INITIAL_COVARIANCE),
            "initial_covariance",
            "a positive number, at most 1e9",
        )
    }
}

/// Least squares of the yaw model from samples at fixed intervals, with the least state and work.
///
/// ```text
/// y = psi''_f,  Phi = [psi'_f, delta_f, 1]^T          filtered as StateVariableFilter does
/// g = P Phi
/// d = 1 + Phi^T P Phi
/// e = y - Phi^T Theta
/// Theta <- Theta + k e,  k = g/d
/// P <- P - k g^T,  P0 = p I
/// ```
///
/// | symbol | identifier | unit |
/// |---|---|---|
/// | psi | `heading_rad` | rad |
/// | delta | `rudder_rad` | rad |
/// | Theta | [`model`](Self::model) | 1/s, 1/s^2, rad/s^2 |
/// | P | [`covariance`](Self::covariance) | parameter^2 per observation^2 |
/// | e | innovation | rad/s^2 |
/// | p | [`FixedRateSettings::initial_covariance`] | |
///
/// Source: equations (16)-(31) and the paper's recursion as corrected in [`RecursiveLeastSquares`](crate::RecursiveLeastSquares),
/// without forgetting. P is symmetric by construction, six numbers; there is one division a sample.
///
/// Takes headings unwrapped or wrapped, and a turn of less than pi between samples. A sample that is not finite, or
/// too large to compute with, changes nothing, as if its instant had not been. Where P has lost its sign to rounding
/// (d < 1) nothing is learnt; in `f32` that is why p stays at the paper's 100, while `f64` bears 1e6.
///
/// Cost on a Cortex-M4F in `f32`: 127 instructions, 96 bytes of state, 64 of stack, 0.5 kB of code;
/// `cargo xtask embedded` counts them.
///
/// Use this one where every sample arrives, on time, and processor time or memory is scarce. Use
/// [`Estimator`](crate::Estimator) for everything else: it carries the filters over lost and late samples, refuses
/// spikes, is free of the bias by compass noise, and tells convergence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FixedRateEstimator<T> {
    step: FilterStep<T>,
    heading_hold: Hold,
    last_heading_rad: T,
    heading: StateVariableFilter<T>,
    rudder: StateVariableFilter<T>,
    initial_covariance: T,
    theta: [T; 3],
    /// P row by row from the diagonal on.
    covariance: [T; 6],
}

/// The filtered signals [psi''_f, psi'_f, delta_f].
type Signals<T> = [T; 3];

impl<T: Real> FixedRateEstimator<T> {
    /// Starts the filters at a first sample; [`learn`](Self::learn) at once to learn from it, too, as the paper does.
    ///
    /// ```
    /// use seatrial_core::model::YawState;
    /// use seatrial_core::{FixedRateEstimator, FixedRateSettings, YawModel};
    ///
    /// let vehicle = YawModel::from_theta([-1.07, 1.08, 0.012]);
    /// let (mut state, mut rudder_rad) = (YawState::default(), 0.0);
    /// // In f64; the 100 of f32 would hold a22 and b2 nearer to 0 by 4 %.
    /// let settings =
    ///     FixedRateSettings { initial_covariance: 1e6, ..FixedRateSettings::for_lambda(1.5, 0.05) };
    /// let mut estimator = FixedRateEstimator::new(&settings, 0.0, 0.0)?;
    /// for k in 1..320 {
    ///     state = vehicle.advance(state, rudder_rad, 0.05);
    ///     rudder_rad = match k {
    ///         40..80 => 0.26,
    ///         80..120 => -0.26,
    ///         _ => 0.0,
    ///     };
    ///     estimator.update(state.heading_rad, rudder_rad);
    /// }
    /// assert!((estimator.model().b2_per_s2 - 1.08_f64).abs() < 0.01);
    /// # Ok::<(), seatrial_core::InvalidSetting>(())
    /// ```
    pub fn new(
        settings: &FixedRateSettings<T>,
        heading_rad: T,
        rudder_rad: T,
    ) -> Result<Self, InvalidSetting> {
        settings.check()?;
        if !(heading_rad.is_finite() && rudder_rad.is_finite()) {
            return Err(InvalidSetting {
                field: "heading_rad and rudder_rad",
                requirement: "finite",
            });
        }
        let mut step = FilterStep::new(settings.lambda_rad_s);
        step.set_interval(settings.sample_interval_s);
        let mut estimator = Self {
            step,
            heading_hold: settings.heading_hold,
            last_heading_rad: heading_rad,
            heading: StateVariableFilter::new(heading_rad, settings.filter_start),
            rudder: StateVariableFilter::new(rudder_rad, settings.filter_start),
            initial_covariance: settings.initial_covariance,
            theta: [T::ZERO; 3],
            covariance: [T::ZERO; 6],
        };
        estimator.restart();
        Ok(estimator)
    }

    /// Forgets the estimate for the next speed; the filters run on.
    ///
    /// ```
    /// use seatrial_core::{FixedRateEstimator, FixedRateSettings};
    ///
    /// let mut estimator = FixedRateEstimator::<f64>::new(&FixedRateSettings::paper(0.05), 0.0, 0.2)?;
    /// estimator.update(0.01, 0.2);
    /// estimator.restart();
    /// assert_eq!((estimator.model().theta(), estimator.covariance()[0][0]), ([0.0; 3], 100.0));
    /// # Ok::<(), seatrial_core::InvalidSetting>(())
    /// ```
    pub fn restart(&mut self) {
        let (p, zero) = (self.initial_covariance, T::ZERO);
        self.theta = [zero; 3];
        self.covariance = [p, zero, zero, p, zero, p];
    }

    /// Makes the next samples follow at another interval, s, positive and below 0.5/lambda. `false`: refused.
    ///
    /// ```
    /// use seatrial_core::{FixedRateEstimator, FixedRateSettings};
    ///
    /// let mut estimator = FixedRateEstimator::<f32>::new(&FixedRateSettings::paper(0.05), 0.0, 0.0)?;
    /// assert!(estimator.set_interval(0.1));
    /// // Half of 1/lambda is too long.
    /// assert!(!estimator.set_interval(0.5));
    /// # Ok::<(), seatrial_core::InvalidSetting>(())
    /// ```
    #[inline]
    pub fn set_interval(&mut self, interval_s: T) -> bool {
        self.step.set_short_interval(interval_s)
    }

    /// Takes in a sample of the settling phase: moves the filters, learns nothing. `false`: refused.
    ///
    /// ```
    /// use seatrial_core::{FixedRateEstimator, FixedRateSettings};
    ///
    /// let mut estimator = FixedRateEstimator::<f64>::new(&FixedRateSettings::paper(0.05), 0.0, 0.0)?;
    /// assert!(estimator.settle(0.01, 0.1));
    /// // The filters moved, and nothing was learnt.
    /// assert_eq!(estimator.model().theta(), [0.0; 3]);
    /// assert!(!estimator.settle(f64::INFINITY, 0.1));
    /// # Ok::<(), seatrial_core::InvalidSetting>(())
    /// ```
    pub fn settle(&mut self, heading_rad: T, rudder_rad: T) -> bool {
        self.filter(heading_rad, rudder_rad).is_some()
    }

    /// Takes in a sample of the training phase. The rudder acts from this instant on. `false`: refused.
    ///
    /// ```
    /// use seatrial_core::{FixedRateEstimator, FixedRateSettings};
    ///
    /// let mut estimator = FixedRateEstimator::<f32>::new(&FixedRateSettings::paper(0.05), 0.0, 0.0)?;
    /// let before = estimator;
    /// assert!(!estimator.update(f32::NAN, 0.1));
    /// assert_eq!(estimator, before);
    /// # Ok::<(), seatrial_core::InvalidSetting>(())
    /// ```
    #[inline]
    pub fn update(&mut self, heading_rad: T, rudder_rad: T) -> bool {
        match self.filter(heading_rad, rudder_rad) {
            Some(signals) => self.learn_from(signals),
            None => false,
        }
    }

    /// Learns from where the filters stand; [`update`](Self::update) does so by itself.
    pub fn learn(&mut self) -> bool {
        self.learn_from(signals(&self.heading, &self.rudder, &self.step))
    }

    /// The estimate.
    pub fn model(&self) -> YawModel<T> {
        YawModel::from_theta(self.theta)
    }

    /// P.
    ///
    /// ```
    /// use seatrial_core::{FixedRateEstimator, FixedRateSettings};
    ///
    /// let mut estimator = FixedRateEstimator::new(&FixedRateSettings::paper(0.05), 0.0, 0.2)?;
    /// assert_eq!(estimator.covariance()[1][1], 100.0);
    /// for k in 1..40 {
    ///     estimator.update(0.001 * f64::from(k * k), 0.2);
    /// }
    /// // What is learnt makes P smaller.
    /// assert!(estimator.covariance()[1][1] < 100.0);
    /// # Ok::<(), seatrial_core::InvalidSetting>(())
    /// ```
    pub fn covariance(&self) -> [[T; 3]; 3] {
        let [p11, p12, p13, p22, p23, p33] = self.covariance;
        [[p11, p12, p13], [p12, p22, p23], [p13, p23, p33]]
    }

    #[inline]
    fn filter(&mut self, heading_rad: T, rudder_rad: T) -> Option<Signals<T>> {
        let (mut heading, mut rudder) = (self.heading, self.rudder);
        let turned_rad = less_than_half_a_turn(heading_rad - self.last_heading_rad);
        heading.advance_by(turned_rad, self.heading_hold, &self.step);
        rudder.advance(rudder_rad, Hold::ZeroOrder, &self.step);
        let [y, phi1, phi2] = signals(&heading, &rudder, &self.step);
        let usable = y * y + (phi1 * phi1 + phi2 * phi2) < T::of(LARGEST_SIGNAL * LARGEST_SIGNAL);
        if !usable {
            return None;
        }
        self.last_heading_rad = heading_rad;
        (self.heading, self.rudder) = (heading, rudder);
        Some([y, phi1, phi2])
    }

    #[inline(always)]
    fn learn_from(&mut self, [y, phi1, phi2]: Signals<T>) -> bool {
        let [a22, b2, c0] = self.theta;
        let e = y - phi1 * a22 - phi2 * b2 - c0;
        let [p11, p12, p13, p22, p23, p33] = self.covariance;
        // The next sample waits from P to P for a product, three sums, the division, a product and a sum: what can be
        // done beside that is.
        let across = p13 * phi1 + p23 * phi2;
        let d = (p11 * (phi1 * phi1) + p22 * (phi2 * phi2))
            + (p12 * ((phi1 + phi1) * phi2) + (p33 + T::ONE))
            + (across + across);
        let has_its_sign = d >= T::ONE;
        if !has_its_sign {
            return false;
        }
        let inverse = T::ONE / d;
        let g1 = p11 * phi1 + p12 * phi2 + p13;
        let g2 = p12 * phi1 + p22 * phi2 + p23;
        let g3 = across + p33;
        let step = e * inverse;
        self.theta = [a22 + g1 * step, b2 + g2 * step, c0 + g3 * step];
        self.covariance = [
            p11 - g1 * g1 * inverse,
            p12 - g1 * g2 * inverse,
            p13 - g1 * g3 * inverse,
            p22 - g2 * g2 * inverse,
            p23 - g2 * g3 * inverse,
            p33 - g3 * g3 * inverse,
        ];
        true
    }
}

#[inline]
fn signals<T: Real>(
    heading: &StateVariableFilter<T>,
    rudder: &StateVariableFilter<T>,
    step: &FilterStep<T>,
) -> Signals<T> {
    [heading.second_derivative(step), heading.first_derivative(step), rudder.smoothed()]
}

#[inline]
fn less_than_half_a_turn<T: Real>(turned_rad: T) -> T {
    let turn = T::PI + T::PI;
    if turned_rad > T::PI {
        turned_rad - turn
    } else if turned_rad < -T::PI {
        turned_rad + turn
    } else {
        turned_rad
    }
}
