//! Does the vehicle turn the way the rudder points?

use crate::Real;
use crate::envelope::RudderSense;

/// Part of the first deflection to wait before judging.
const JUDGED_FROM: f64 = 0.3;
/// Standard deviations by which the turn must differ from none.
const SIGNIFICANCE: f64 = 5.0;
/// Times the wander of the heading before the manoeuvre that the turn must exceed.
const WANDER_FACTOR: f64 = 3.0;
/// Smallest turn that counts, rad.
const SMALLEST_TURN_RAD: f64 = 0.02;

/// Watches the first deflection of a manoeuvre for a vehicle that turns against its rudder.
///
/// ```text
/// psi(t) = alpha + beta t + gamma s(t),   s(t) = 0 before the deflection, t^2/2 after it
/// ```
///
/// fitted by least squares over the lead-in and the deflection so far. gamma is the yaw
/// acceleration that the deflection caused; the drift beta of the lead-in is taken out. The
/// rudder is reversed where gamma has the wrong sign and is both beyond what the scatter about the
/// line can cause (5 standard deviations) and a turn larger than 0.02 rad and than 3 times the
/// wander of the heading in the lead-in: waves push a vehicle with a weak rudder either way.
#[derive(Clone, Copy, Debug)]
pub struct RudderSenseWatch<T> {
    /// +1 where b2 is expected to be positive.
    sign: T,
    deflection_s: f64,
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
    /// A watch on a manoeuvre whose first deflection lasts `deflection_s`. `None` where no sense is expected.
    pub fn new(sense: RudderSense, deflection_s: f64) -> Option<Self> {
        let sign = match sense {
            RudderSense::Positive => T::ONE,
            RudderSense::Negative => -T::ONE,
            RudderSense::Unknown => return None,
        };
        Some(Self {
            sign,
            deflection_s,
            gram: [[T::ZERO; 4]; 4],
            lead_in: LeadIn::default(),
        })
    }

    /// Takes in the heading relative to the heading of the run and the rudder, `elapsed_s` after
    /// the start of the manoeuvre, negative before it. `true`: the vehicle turns against its rudder.
    pub fn is_reversed(&mut self, elapsed_s: f64, heading_rad: T, rudder_rad: T) -> bool {
        if elapsed_s >= self.deflection_s {
            return false;
        }
        let t = T::of(elapsed_s);
        let after = t.max(T::ZERO);
        let s = after * after / T::of(2.0);
        let terms = [T::ONE, t, s, heading_rad];
        for (row, left) in self.gram.iter_mut().zip(terms) {
            for (entry, right) in row.iter_mut().zip(terms) {
                *entry += left * right;
            }
        }
        if elapsed_s < 0.0 {
            self.lead_in.add(heading_rad, rudder_rad);
            return false;
        }
        elapsed_s >= JUDGED_FROM * self.deflection_s
            && self.turns_against(s, rudder_rad - self.lead_in.mean_rudder_rad)
    }

    fn turns_against(&self, s: T, deflection_rad: T) -> bool {
        let Some((gamma, variance)) = self.last_coefficient() else {
            return false;
        };
        let against = -gamma
            * self.sign
            * if deflection_rad < T::ZERO {
                -T::ONE
            } else {
                T::ONE
            };
        let least = T::of(SMALLEST_TURN_RAD).max(T::of(WANDER_FACTOR) * self.lead_in.deviation());
        against > T::of(SIGNIFICANCE) * variance.sqrt() && against * s > least
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
