//! Does the vehicle turn the way the rudder points?

use crate::envelope::RudderSense;
use crate::model::YawState;
use crate::{Excitation, Real, YawModel};

/// Part of the first deflection to wait before judging.
const JUDGED_FROM: f64 = 0.3;
/// Time constant of the expected turn, as a part of the first deflection.
const TIME_CONSTANT: f64 = 0.5;
/// Standard deviations by which the turn must differ from none.
const SIGNIFICANCE: f64 = 5.0;
/// Times the wander of the heading before the manoeuvre that the turn must exceed.
const WANDER_FACTOR: f64 = 3.0;
/// Smallest turn that counts, rad.
const SMALLEST_TURN_RAD: f64 = 0.02;

/// Watches a manoeuvre for a vehicle that turns against its rudder.
///
/// ```text
/// psi(t) = alpha + beta t + gamma s(t)
/// s'' = -s'/T + (delta - mean delta of the lead-in),   s = 0 in the lead-in
/// ```
///
/// fitted by least squares over the lead-in and the manoeuvre so far: gamma is a rough b2, and the
/// drift beta of the lead-in is taken out. T is half the first deflection, since a manoeuvre is chosen to
/// suit its vehicle; the sign of gamma does not hang on it. The rudder is reversed where gamma
/// has the wrong sign and the turn gamma s is beyond what the scatter about the line can cause (5
/// standard deviations), larger than 0.02 rad and larger than 3 times the wander of the heading in the
/// lead-in: waves push a vehicle with a weak rudder either way.
#[derive(Clone, Copy, Debug)]
pub struct RudderSenseWatch<T> {
    /// +1 where b2 is expected to be positive.
    sign: T,
    judged_from_s: f64,
    judged_to_s: f64,
    /// The vehicle that s belongs to.
    expected: YawModel<T>,
    response: YawState<T>,
    /// Largest |s| so far.
    largest: T,
    /// Time and rudder of the sample before.
    last: Option<(f64, T)>,
    /// Gram matrix of [1, t, s, psi].
    gram: [[T; 4]; 4],
    lead_in: LeadIn<T>,
}

/// Mean and scatter of the heading, and mean rudder, before the manoeuvre.
#[derive(Clone, Copy, Debug, Default)]
struct LeadIn<T> {
    samples: u32,
    mean_rad: T,
    sum_of_squares: T,
    mean_rudder_rad: T,
}

impl<T: Real> RudderSenseWatch<T> {
    /// A watch on a manoeuvre. `None` where no sense is expected.
    ///
    /// ```
    /// use seatrial_core::rudder_sense::RudderSenseWatch;
    /// use seatrial_core::{Excitation, RudderSense};
    ///
    /// let doublet = Excitation::Doublet { amplitude_rad: 0.26, period_s: 4.0 };
    /// assert!(RudderSenseWatch::new(RudderSense::Unknown, &doublet).is_none());
    /// ```
    pub fn new(sense: RudderSense, excitation: &Excitation<T>) -> Option<Self> {
        let sign = match sense {
            RudderSense::Positive => T::ONE,
            RudderSense::Negative => -T::ONE,
            RudderSense::Unknown => return None,
        };
        let deflection_s = excitation.longest_deflection_s();
        let a22_per_s = -T::ONE / T::of(TIME_CONSTANT * deflection_s);
        Some(Self {
            sign,
            judged_from_s: JUDGED_FROM * deflection_s,
            judged_to_s: excitation.duration_s(),
            expected: YawModel::from_theta([a22_per_s, T::ONE, T::ZERO]),
            response: YawState::default(),
            largest: T::ZERO,
            last: None,
            gram: [[T::ZERO; 4]; 4],
            lead_in: LeadIn::default(),
        })
    }

    /// Takes in the heading relative to the heading of the run and the rudder, `elapsed_s` after
    /// the start of the manoeuvre, negative before it. `true`: the vehicle turns against its rudder.
    ///
    /// ```
    /// use seatrial_core::rudder_sense::RudderSenseWatch;
    /// use seatrial_core::{Excitation, RudderSense};
    ///
    /// let doublet = Excitation::Doublet { amplitude_rad: 0.26, period_s: 4.0 };
    /// let told_s = |turn: f64| {
    ///     let mut watch = RudderSenseWatch::new(RudderSense::Positive, &doublet)?;
    ///     let at_s = |k: i32| 0.05 * f64::from(k);
    ///     (-40..40).map(at_s).find(|s| {
    ///         watch.is_reversed(*s, turn * s.max(0.0).powi(2), if *s < 0.0 { 0.0 } else { 0.26 })
    ///     })
    /// };
    /// // Starboard rudder: a vehicle that turns to port is told within a second and a half.
    /// assert!(told_s(-0.1).is_some_and(|s| s < 1.5));
    /// assert_eq!(told_s(0.1), None);
    /// ```
    pub fn is_reversed(&mut self, elapsed_s: f64, heading_rad: T, rudder_rad: T) -> bool {
        if elapsed_s >= self.judged_to_s {
            return false;
        }
        if elapsed_s < 0.0 {
            self.lead_in.add(heading_rad, rudder_rad);
        } else if let Some((last_s, last_rudder_rad)) = self.last {
            let deflection_rad = last_rudder_rad - self.lead_in.mean_rudder_rad;
            let interval_s = T::of(elapsed_s - last_s);
            self.response = self.expected.advance(self.response, deflection_rad, interval_s);
        }
        self.last = Some((elapsed_s, rudder_rad));
        let s = self.response.heading_rad;
        self.largest = self.largest.max(s.abs());
        let terms = [T::ONE, T::of(elapsed_s), s, heading_rad];
        for (row, left) in self.gram.iter_mut().zip(terms) {
            for (entry, right) in row.iter_mut().zip(terms) {
                *entry += left * right;
            }
        }
        elapsed_s >= self.judged_from_s && self.turns_against()
    }

    fn turns_against(&self) -> bool {
        let Some((gamma, variance)) = self.last_coefficient() else {
            return false;
        };
        let against = -gamma * self.sign;
        let least = T::of(SMALLEST_TURN_RAD).max(T::of(WANDER_FACTOR) * self.lead_in.deviation());
        against > T::of(SIGNIFICANCE) * variance.sqrt() && against * self.largest > least
    }

    /// gamma and its variance, by elimination of alpha and beta from the normal equations.
    fn last_coefficient(&self) -> Option<(T, T)> {
        let [[n, t, s, y], [_, tt, ts, ty], [_, _, ss, sy], [_, _, _, yy]] = self.gram;
        // Sums about the means.
        let (tt, ts, ty) = (tt - t * t / n, ts - t * s / n, ty - t * y / n);
        let (ss, sy, yy) = (ss - s * s / n, sy - s * y / n, yy - y * y / n);
        // What the drift does not explain.
        let (ss, sy, yy) = (ss - ts * ts / tt, sy - ts * ty / tt, yy - ty * ty / tt);
        let gamma = sy / ss;
        let variance = (yy - gamma * sy).max(T::ZERO) / ((n - T::of(3.0)) * ss);
        (gamma.is_finite() && variance.is_finite()).then_some((gamma, variance))
    }
}

impl<T: Real> LeadIn<T> {
    fn add(&mut self, heading_rad: T, rudder_rad: T) {
        self.samples = self.samples.saturating_add(1);
        let count = T::of(f64::from(self.samples));
        let deviation = heading_rad - self.mean_rad;
        self.mean_rad += deviation / count;
        self.sum_of_squares += deviation * (heading_rad - self.mean_rad);
        self.mean_rudder_rad += (rudder_rad - self.mean_rudder_rad) / count;
    }

    fn deviation(&self) -> T {
        (self.sum_of_squares / T::of(f64::from(self.samples.max(1)))).sqrt()
    }
}
