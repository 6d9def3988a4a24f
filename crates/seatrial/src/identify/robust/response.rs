//! The heading of a first-order vehicle whose rudder lags behind its record.

/// A vehicle of first order behind a rudder of first order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dynamics {
    /// a22, 1/s.
    pub a22_per_s: f64,
    /// T_l, time constant of the rudder, s.
    pub lag_s: f64,
    /// tau, how late the rudder's record acts, s; negative where it acts before its time.
    pub shift_s: f64,
}

impl Dynamics {
    /// Equal poles have no partial fractions: the lag moves by this share of itself.
    const LEAST_POLE_DISTANCE: f64 = 1e-4;

    /// A lag that is no pole of its own, s.
    fn separate_lag_s(&self) -> f64 {
        let distance = self.a22_per_s * self.lag_s + 1.0;
        if distance.abs() < Self::LEAST_POLE_DISTANCE {
            self.lag_s * (1.0 + Self::LEAST_POLE_DISTANCE)
        } else {
            self.lag_s
        }
    }
}

/// What one length of time does to `[rudder - input, yaw rate, heading]` under a constant input.
#[derive(Clone, Copy, Debug)]
pub(super) struct Propagation {
    /// exp(-t / T_l).
    pub(super) rudder_decay: f64,
    /// exp(a22 t).
    pub(super) rate_decay: f64,
    /// (exp(a22 t) - 1) / a22, s.
    pub(super) rate_gain_s: f64,
    /// The integral of the gain, s^2.
    pub(super) heading_gain_s2: f64,
    /// From the rudder's distance to its input into the yaw rate, s.
    pub(super) lag_to_rate_s: f64,
    /// From the rudder's distance to its input into the heading, s^2.
    pub(super) lag_to_heading_s2: f64,
}

impl Propagation {
    /// Over `t` s.
    pub(super) fn over(dynamics: &Dynamics, t: f64) -> Self {
        let a = dynamics.a22_per_s;
        let (rate_gain_s, heading_gain_s2) = gains(a, t);
        let rate_decay = libm::exp(a * t);
        let lag_s = dynamics.separate_lag_s();
        let (rudder_decay, lag_to_rate_s, lag_to_heading_s2) = if lag_s > 0.0 {
            let decay = libm::exp(-t / lag_s);
            let pole = a + 1.0 / lag_s;
            let rate = (rate_decay - decay) / pole;
            let heading = (rate_gain_s - lag_s * (1.0 - decay)) / pole;
            (decay, rate, heading)
        } else {
            (0.0, 0.0, 0.0)
        };
        Self {
            rudder_decay,
            rate_decay,
            rate_gain_s,
            heading_gain_s2,
            lag_to_rate_s,
            lag_to_heading_s2,
        }
    }
}

/// A length of time and what it does, from which that of a length near it is told without an exponential.
struct Near {
    length_s: f64,
    here: Propagation,
}

impl Near {
    /// Arguments of exponentials up to this size go by the series, to rounding.
    const LARGEST: f64 = 0.02;

    fn none(dynamics: &Dynamics) -> Self {
        Self { length_s: f64::NAN, here: Propagation::over(dynamics, 0.0) }
    }

    /// `None` where `t` is too far away.
    #[inline(always)]
    fn over(&self, rates: &Rates, t: f64) -> Option<Propagation> {
        let more_s = t - self.length_s;
        if more_s.is_nan() || more_s.abs() > rates.reach_s {
            return None;
        }
        let more = small_exponential(rates.damping_per_s, more_s);
        let rate_decay = self.here.rate_decay * more.decay;
        let rate_gain_s = self.here.rate_gain_s + self.here.rate_decay * more.gain_s;
        let of_lag = small_exponential(-rates.of_lag_per_s, more_s);
        let rudder_decay = self.here.rudder_decay * of_lag.decay;
        Some(Propagation {
            rudder_decay,
            rate_decay,
            rate_gain_s,
            heading_gain_s2: self.here.heading_gain_s2
                + self.here.rate_gain_s * more_s
                + self.here.rate_decay * more.integral_s2,
            lag_to_rate_s: (rate_decay - rudder_decay) * rates.of_pole_s,
            lag_to_heading_s2: (rate_gain_s - rates.lag_s * (1.0 - rudder_decay)) * rates.of_pole_s,
        })
    }
}

/// What [`Near`] needs of the dynamics.
struct Rates {
    damping_per_s: f64,
    of_lag_per_s: f64,
    lag_s: f64,
    /// 1/(a22 + 1/T_l); 0 of a rudder that does not lag.
    of_pole_s: f64,
    reach_s: f64,
}

impl Rates {
    fn of(dynamics: &Dynamics) -> Self {
        let lag_s = dynamics.separate_lag_s();
        let (of_lag_per_s, of_pole_s) = match lag_s > 0.0 {
            true => (1.0 / lag_s, 1.0 / (dynamics.a22_per_s + 1.0 / lag_s)),
            false => (0.0, 0.0),
        };
        Self {
            damping_per_s: dynamics.a22_per_s,
            of_lag_per_s,
            lag_s,
            of_pole_s,
            reach_s: Near::LARGEST / dynamics.a22_per_s.abs().max(of_lag_per_s),
        }
    }
}

/// exp(a t), its integral and the integral of that.
pub(super) struct SmallExponential {
    pub(super) decay: f64,
    pub(super) gain_s: f64,
    pub(super) integral_s2: f64,
}

/// By its series, to rounding where a t is no more than 0.02.
#[inline(always)]
pub(super) fn small_exponential(a: f64, t: f64) -> SmallExponential {
    let x = a * t;
    let of_integral = 1.0 + x * 0.25 * (1.0 + x * 0.2 * (1.0 + x * (1.0 / 6.0)));
    let integral_s2 = t * t * (0.5 + x * (1.0 / 6.0) * of_integral);
    let gain_s = t * (1.0 + x * 0.5 * (1.0 + x * (1.0 / 3.0) * of_integral));
    SmallExponential { decay: 1.0 + a * gain_s, gain_s, integral_s2 }
}

/// (exp(a t) - 1) / a and its integral, exact at a = 0 too.
pub fn gains(a: f64, t: f64) -> (f64, f64) {
    let x = a * t;
    if x.abs() < 1e-3 {
        let first = t * (1.0 + x / 2.0 * (1.0 + x / 3.0 * (1.0 + x / 4.0)));
        let second = t * t * (0.5 + x / 6.0 * (1.0 + x / 4.0 * (1.0 + x / 5.0)));
        (first, second)
    } else {
        let first = libm::expm1(x) / a;
        (first, (first - t) / a)
    }
}

/// Responses of the heading to b2, C0, psi0, r0 and b2 times the first rudder's distance from its record, at each sample.
///
/// ```text
/// T_l delta_a' = delta(t - tau) - delta_a,  r' = a22 r + b2 delta_a + C0,  psi' = r
/// ```
///
/// The recorded rudder is held from each sample to the next and acts tau later, the first value before its time, too; a step over
/// each piece of constant input is exact.
pub fn responses(time_s: &[f64], rudder_rad: &[f64], dynamics: &Dynamics) -> Vec<[f64; 5]> {
    let mut rows = Vec::with_capacity(time_s.len());
    let (Some(first_s), Some(first_rad)) = (time_s.first(), rudder_rad.first()) else {
        return rows;
    };
    let mut steps = Steps::new(dynamics);
    let mut state = State {
        rudder: [*first_rad, 0.0, 0.0],
        offset: [0.0; 2],
        rate: [1.0, 0.0],
        first: [1.0, 0.0, 0.0],
    };
    let mut now_s = *first_s;
    let mut piece = 0;
    for until_s in time_s {
        while now_s < *until_s {
            while time_s
                .get(piece + 1)
                .is_some_and(|next_s| next_s + dynamics.shift_s <= now_s + SAME_S)
            {
                piece += 1;
            }
            let ends_s = match time_s.get(piece + 1) {
                Some(next_s) if next_s + dynamics.shift_s < *until_s - SAME_S => {
                    next_s + dynamics.shift_s
                }
                _ => *until_s,
            };
            state.advance(&steps.over(ends_s - now_s), rudder_rad[piece]);
            now_s = ends_s;
        }
        rows.push([state.rudder[2], state.offset[1], 1.0, state.rate[1], state.first[2]]);
    }
    rows
}

/// Times that differ by less are the same, s: rounding of a clock that counts from 1970.
const SAME_S: f64 = 1e-9;

/// Rudder, yaw rate and heading of each response, so far as they are not 0.
struct State {
    rudder: [f64; 3],
    offset: [f64; 2],
    rate: [f64; 2],
    first: [f64; 3],
}

impl State {
    #[inline(always)]
    fn advance(&mut self, step: &Propagation, input: f64) {
        let [rudder, rate, heading] = self.rudder;
        let away = rudder - input;
        self.rudder = [
            input + step.rudder_decay * away,
            step.rate_decay * rate + step.rate_gain_s * input + step.lag_to_rate_s * away,
            heading
                + step.rate_gain_s * rate
                + step.heading_gain_s2 * input
                + step.lag_to_heading_s2 * away,
        ];
        let [rate, heading] = self.offset;
        self.offset = [
            step.rate_decay * rate + step.rate_gain_s,
            heading + step.rate_gain_s * rate + step.heading_gain_s2,
        ];
        let [rate, heading] = self.rate;
        self.rate = [step.rate_decay * rate, heading + step.rate_gain_s * rate];
        let [away, rate, heading] = self.first;
        self.first = [
            step.rudder_decay * away,
            step.rate_decay * rate + step.lag_to_rate_s * away,
            heading + step.rate_gain_s * rate + step.lag_to_heading_s2 * away,
        ];
    }
}

/// The last two lengths of time that were not near each other, and what they do: an even clock has no more.
struct Steps<'a> {
    dynamics: &'a Dynamics,
    rates: Rates,
    known: [Near; 2],
    oldest: usize,
}

impl<'a> Steps<'a> {
    fn new(dynamics: &'a Dynamics) -> Self {
        Self {
            dynamics,
            rates: Rates::of(dynamics),
            known: [Near::none(dynamics), Near::none(dynamics)],
            oldest: 0,
        }
    }

    #[inline(always)]
    fn over(&mut self, t: f64) -> Propagation {
        let [first, second] = &self.known;
        for known in [first, second] {
            if (t - known.length_s).abs() < SAME_S {
                return known.here;
            }
        }
        let near = first.over(&self.rates, t);
        near.or_else(|| second.over(&self.rates, t)).unwrap_or_else(|| self.exactly_over(t))
    }

    #[cold]
    fn exactly_over(&mut self, t: f64) -> Propagation {
        let here = Propagation::over(self.dynamics, t);
        self.known[self.oldest] = Near { length_s: t, here };
        self.oldest = 1 - self.oldest;
        here
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TIMES: usize = 200;

    fn record() -> (Vec<f64>, Vec<f64>) {
        let time_s = (0..TIMES).map(|k| 0.05 * k as f64 + 0.01 * (k as f64).sin());
        let rudder_rad = (0..TIMES).map(|k| if k / 30 % 2 == 0 { 0.1 } else { -0.2 });
        (time_s.collect(), rudder_rad.collect())
    }

    /// Heading by steps of a thousandth of a second, from rest with the rudder at its first value.
    fn by_small_steps(time_s: &[f64], rudder_rad: &[f64], dynamics: &Dynamics) -> Vec<f64> {
        const STEP_S: f64 = 1e-4;
        let (mut acting, mut rate, mut heading) = (rudder_rad[0], 0.0, 0.0);
        let mut now_s = time_s[0];
        let mut headings = Vec::new();
        for until_s in time_s {
            while now_s < until_s - 0.5 * STEP_S {
                let middle_s = now_s + 0.5 * STEP_S - dynamics.shift_s;
                let row = time_s.partition_point(|t| *t <= middle_s).max(1) - 1;
                let kept = (-STEP_S / dynamics.lag_s).exp();
                acting = rudder_rad[row] + kept * (acting - rudder_rad[row]);
                heading += STEP_S * rate;
                rate += STEP_S * (dynamics.a22_per_s * rate + acting);
                now_s += STEP_S;
            }
            headings.push(heading);
        }
        headings
    }

    #[test]
    fn exact_a_lagging_and_shifted_rudder_acts_as_in_small_steps() {
        let (time_s, rudder_rad) = record();
        for (lag_s, shift_s) in [(0.15, 0.0), (0.15, 0.02), (0.3, -0.03), (1e-6, 0.08)] {
            let dynamics = Dynamics { a22_per_s: -0.9, lag_s, shift_s };
            let expected = by_small_steps(&time_s, &rudder_rad, &dynamics);
            for (row, expected) in responses(&time_s, &rudder_rad, &dynamics).iter().zip(expected) {
                // Euler's steps of 0.1 ms.
                assert!((row[0] - expected).abs() < 2e-4, "{} {expected}", row[0]);
            }
        }
    }

    #[test]
    fn exact_gains_agree_on_both_sides_of_the_series() {
        for t in [0.1, 1.0, 30.0] {
            let ((near, near2), (far, far2)) = (gains(0.999e-3 / t, t), gains(1.001e-3 / t, t));
            // The change of a itself.
            assert!((near / far - 1.0).abs() < 2e-6 && (near2 / far2 - 1.0).abs() < 2e-6);
        }
    }

    /// Lengths of time that jitter, against each by its own exponentials.
    #[test]
    fn exact_lengths_near_a_known_one() {
        for lag_s in [0.0, 0.003, 0.2] {
            let dynamics = Dynamics { a22_per_s: -0.9, lag_s, shift_s: 0.0 };
            let mut steps = Steps::new(&dynamics);
            for k in 0..200 {
                let t = 0.05 + 0.004 * f64::from(k).sin();
                let (found, expected) = (steps.over(t), Propagation::over(&dynamics, t));
                let pairs = [
                    (found.rudder_decay, expected.rudder_decay),
                    (found.rate_decay, expected.rate_decay),
                    (found.rate_gain_s, expected.rate_gain_s),
                    (found.heading_gain_s2, expected.heading_gain_s2),
                    (found.lag_to_rate_s, expected.lag_to_rate_s),
                    (found.lag_to_heading_s2, expected.lag_to_heading_s2),
                ];
                for (found, expected) in pairs {
                    // Rounding.
                    assert!((found - expected).abs() < 1e-14, "{t} {found} {expected}");
                }
            }
        }
    }

    #[test]
    fn exact_equal_poles_have_a_response() {
        let (time_s, rudder_rad) = record();
        let of = |lag_s: f64| {
            let dynamics = Dynamics { a22_per_s: -2.0, lag_s, shift_s: 0.0 };
            responses(&time_s, &rudder_rad, &dynamics)[TIMES - 1][0]
        };
        // A lag longer by a thousandth.
        assert!((of(0.5) / of(0.5005) - 1.0).abs() < 1e-3);
    }
}
