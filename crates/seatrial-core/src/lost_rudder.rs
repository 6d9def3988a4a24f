//! What the rudder did while samples were lost.

use crate::Real;
use crate::state_variable_filter::{FilterStart, FilterStep, Hold, StateVariableFilter};

/// Usual intervals from which on one is taken for two; the jitter of a clock does not reach it.
const TWO_ABOVE: f64 = 1.75;
/// Usual intervals from which on one may hide a rudder movement.
const UNSEEN_ABOVE: f64 = 1.25;
/// A rudder movement that matters where it is hidden, rad. Smaller ones, of a heading controller, are smooth.
const EDGE_RAD: f64 = 0.05;
/// Most steps that the rudder is given in one interval, so that the work per sample stays bounded.
const MOST_STEPS: u32 = 32;

/// How the rudder ran while samples were lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum LostRudder {
    /// The rudder waited: right where it only ever moves when a sample arrives.
    Held,
    /// It moved in equal steps at the usual sampling instants, and when it moved far, at an instant that the heading
    /// has to tell: right for a log with rows missing and for a vehicle that steers on while its telemetry is lost.
    Interpolated,
}

impl LostRudder {
    /// In how many equal steps the rudder went through an interval.
    ///
    /// ```
    /// use seatrial_core::LostRudder;
    ///
    /// // Three rows of 0.05 s are missing.
    /// assert_eq!(LostRudder::Interpolated.steps(0.2, 0.05), 4);
    /// assert_eq!(LostRudder::Held.steps(0.2, 0.05), 1);
    /// ```
    #[inline]
    pub fn steps<T: Real>(self, interval_s: T, usual_interval_s: T) -> u32 {
        if self == Self::Held || interval_s < T::of(TWO_ABOVE) * usual_interval_s {
            return 1;
        }
        let intervals = (interval_s / usual_interval_s + T::of(1.5 - TWO_ABOVE)).round();
        (intervals.to_f64() as u32).clamp(1, MOST_STEPS)
    }

    /// Whether the rudder moved far in this interval and nobody saw when.
    ///
    /// ```
    /// use seatrial_core::LostRudder;
    ///
    /// // 0.26 rad among missing rows, and 0.01 rad.
    /// assert!(LostRudder::Interpolated.hides_edge(0.2, 0.05, 0.26));
    /// assert!(!LostRudder::Interpolated.hides_edge(0.2, 0.05, 0.01));
    /// ```
    #[inline]
    pub fn hides_edge<T: Real>(self, interval_s: T, usual_interval_s: T, moved_rad: T) -> bool {
        self == Self::Interpolated
            && interval_s > T::of(UNSEEN_ABOVE) * usual_interval_s
            && moved_rad.abs() > T::of(EDGE_RAD)
    }
}

/// The rudder that nobody saw, in the regression.
///
/// ```text
/// psi''_f - s_f = beta p_f + a22 psi'_f + b2 delta_f + C0
/// ```
///
/// | symbol | identifier | unit |
/// |---|---|---|
/// | p | a pulse of the rudder's movement over the unseen time | rad |
/// | p_f | [`pulse_rad`](Self::pulse_rad), filtered as the rudder is | rad |
/// | beta | b2 times the share of the pulse that was not as assumed; the regression's first parameter | 1/s^2 |
/// | s_f | [`settled_rad_s2`](Self::settled_rad_s2), what earlier pulses still do, with the beta found for them | rad/s^2 |
///
/// A doublet's edge that falls between two samples, at an unknown instant, gives the yaw rate a kick of
/// unknown size. Left alone, a single one shifts b2 by 2 % and C0 by more than that; as a regressor with a
/// parameter of its own it takes itself out. No source; `exact_missing_rows` measures what it achieves.
/// Edges within 1/lambda of the first cannot be told apart and share its beta.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnseenRudder<T> {
    pulse: StateVariableFilter<T>,
    settled: StateVariableFilter<T>,
    /// Since the first movement of the present pulse.
    age_s: Option<T>,
}

impl<T: Real> UnseenRudder<T> {
    /// Nothing unseen so far.
    pub fn none() -> Self {
        let still = StateVariableFilter::new(T::ZERO, FilterStart::Equilibrium);
        Self { pulse: still, settled: still, age_s: None }
    }

    /// p_f, rad.
    pub fn pulse_rad(&self) -> T {
        self.pulse.smoothed()
    }

    /// s_f, rad/s^2.
    pub fn settled_rad_s2(&self) -> T {
        self.settled.smoothed()
    }

    /// Lets an interval pass.
    #[inline]
    pub fn advance(&mut self, interval_s: T, step: &mut FilterStep<T>) {
        step.set_interval(interval_s);
        self.settled.advance_by(T::ZERO, Hold::ZeroOrder, step);
        if let Some(age_s) = &mut self.age_s {
            self.pulse.advance_by(T::ZERO, Hold::ZeroOrder, step);
            *age_s += interval_s;
        }
    }

    /// Whether there is a present pulse; without one p_f is 0.
    #[inline]
    pub fn has_pulse(&self) -> bool {
        self.age_s.is_some()
    }

    /// Whether the present beta is known well enough to begin another.
    pub fn is_learnt(&self, lambda_rad_s: T) -> bool {
        self.age_s.is_none_or(|age_s| age_s * lambda_rad_s > T::ONE)
    }

    /// Leaves the present pulse with this beta.
    pub fn settle(&mut self, beta: T) {
        self.settled.add_scaled(&self.pulse, beta);
        self.pulse = StateVariableFilter::new(T::ZERO, FilterStart::Equilibrium);
        self.age_s = None;
    }

    /// Adds a movement of the rudder that nobody saw during the last `unseen_s`.
    ///
    /// ```
    /// use seatrial_core::{FilterStep, UnseenRudder};
    ///
    /// let (mut unseen, mut step) = (UnseenRudder::none(), FilterStep::new(1.5));
    /// // The rudder moved by 0.26 rad at an unknown instant of the last 0.15 s.
    /// unseen.add(0.26, 0.15, &mut step);
    /// assert!(unseen.has_pulse() && !unseen.is_learnt(1.5));
    /// // After 1/lambda another movement may have a parameter of its own.
    /// unseen.advance(0.7, &mut step);
    /// assert!(unseen.is_learnt(1.5) && unseen.pulse_rad() > 0.0);
    /// ```
    pub fn add(&mut self, moved_rad: T, unseen_s: T, step: &mut FilterStep<T>) {
        step.set_interval(unseen_s);
        let mut pulse = StateVariableFilter::new(moved_rad, FilterStart::Zero);
        pulse.advance(T::ZERO, Hold::ZeroOrder, step);
        self.pulse.add_scaled(&pulse, T::ONE);
        self.age_s.get_or_insert(T::ZERO);
    }
}
