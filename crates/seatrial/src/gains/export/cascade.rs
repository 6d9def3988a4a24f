//! Gains of the cascade that autopilots steer with: heading error to yaw rate, yaw rate to steering.

/// How much slower the integral is than the heading loop.
const INTEGRAL_RATIO: f64 = 0.2;

/// A vehicle that turns by r' = -alpha r + B s, with its steering s from -1 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Steering {
    /// alpha = -a22, 1/s, positive.
    pub damping_per_s: f64,
    /// B, yaw acceleration under the whole steering, rad/s^2, positive.
    pub authority_rad_s2: f64,
}

/// Gains of the cascade.
///
/// ```text
/// r_d = A (psi_d - psi)
/// s   = F r_d + P (r_d - r) + I integral of (r_d - r) dt
/// ```
///
/// | symbol | identifier | unit |
/// |---|---|---|
/// | A | `angle_gain_per_s` | 1/s |
/// | F | `feed_forward_s` | s/rad |
/// | P | `rate_gain_s` | s/rad |
/// | I | `rate_integral_gain` | 1/rad |
///
/// Both designs keep the poles that K_p gives the heading, s^2 + alpha s + alpha^2/(4 zeta^2), and add an
/// integral that takes out the offset C0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cascade {
    /// A, 1/s.
    pub angle_gain_per_s: f64,
    /// F, s/rad.
    pub feed_forward_s: f64,
    /// P, s/rad.
    pub rate_gain_s: f64,
    /// I, 1/rad.
    pub rate_integral_gain: f64,
}

impl Cascade {
    /// Steering mostly by feed-forward, with little feedback of the rate.
    ///
    /// ```text
    /// F = alpha/B
    /// (s + p)(s^2 + alpha s + w^2) = s^3 + (alpha + B P) s^2 + (B I + A (alpha + B P)) s + A B I
    /// w = alpha/(2 zeta),  a = w^2/alpha,  p = a/5
    /// P = p/B
    /// I = a (0.6 alpha - 0.4 sqrt(alpha^2 - alpha a/4))/B
    /// A = p w^2/(B I)
    /// ```
    ///
    /// a would be the angle gain without an integral; p, the pole that the integral adds, is five times slower.
    /// `None` under a damping ratio of 1/4, where no real gains place these poles.
    ///
    /// ```
    /// use seatrial::gains::export::cascade::{Cascade, Steering};
    ///
    /// let steering = Steering { damping_per_s: 1.0, authority_rad_s2: 0.5 };
    /// // A steady turn of 0.1 rad/s takes alpha/B = 2 times as much steering.
    /// let cascade = Cascade::with_feed_forward(steering, 0.7).ok_or("real gains")?;
    /// assert_eq!(cascade.feed_forward_s, 2.0);
    /// assert_eq!(Cascade::with_feed_forward(steering, 0.2), None);
    /// # Ok::<(), &str>(())
    /// ```
    pub fn with_feed_forward(steering: Steering, damping_ratio: f64) -> Option<Self> {
        let Steering { damping_per_s: alpha, authority_rad_s2: authority } = steering;
        let frequency_squared = alpha * alpha / (4.0 * damping_ratio * damping_ratio);
        let slow = frequency_squared / alpha;
        let integral_pole = INTEGRAL_RATIO * slow;
        // B I is the smaller root of x^2 - (w^2 + p alpha) x + p w^2 (alpha + p).
        let half_sum = 0.5 * (frequency_squared + integral_pole * alpha);
        let product = integral_pole * frequency_squared * (alpha + integral_pole);
        let root = half_sum - (half_sum * half_sum - product).sqrt();
        (root > 0.0).then_some(Self {
            angle_gain_per_s: integral_pole * frequency_squared / root,
            feed_forward_s: alpha / authority,
            rate_gain_s: integral_pole / authority,
            rate_integral_gain: root / authority,
        })
    }

    /// Steering by feedback of the rate alone.
    ///
    /// ```text
    /// P = alpha/B,  I = alpha P,  F = 0,  A = alpha/(4 zeta^2)
    /// ```
    ///
    /// I/P cancels the vehicle's own pole, so that r = alpha/(s + alpha) r_d as with feed-forward.
    ///
    /// ```
    /// use seatrial::gains::export::cascade::{Cascade, Steering};
    ///
    /// let steering = Steering { damping_per_s: 1.0, authority_rad_s2: 0.5 };
    /// let cascade = Cascade::without_feed_forward(steering, 0.5);
    /// // P = alpha/B, A = alpha/(4 zeta^2), and I/P cancels the pole of the vehicle.
    /// assert_eq!((cascade.rate_gain_s, cascade.angle_gain_per_s), (2.0, 1.0));
    /// assert_eq!(cascade.rate_integral_gain / cascade.rate_gain_s, 1.0);
    /// ```
    pub fn without_feed_forward(steering: Steering, damping_ratio: f64) -> Self {
        let Steering { damping_per_s: alpha, authority_rad_s2: authority } = steering;
        Self {
            angle_gain_per_s: alpha / (4.0 * damping_ratio * damping_ratio),
            feed_forward_s: 0.0,
            rate_gain_s: alpha / authority,
            rate_integral_gain: alpha * alpha / authority,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEERING: Steering = Steering { damping_per_s: 1.70, authority_rad_s2: 1.41 * 0.26 };

    /// s^3 + c2 s^2 + c1 s + c0 of the closed loop.
    fn characteristic(cascade: Cascade) -> [f64; 3] {
        let Steering { damping_per_s: alpha, authority_rad_s2: authority } = STEERING;
        let of_rate = authority * (cascade.feed_forward_s + cascade.rate_gain_s);
        let of_integral = authority * cascade.rate_integral_gain;
        let angle = cascade.angle_gain_per_s;
        [
            alpha + authority * cascade.rate_gain_s,
            of_integral + angle * of_rate,
            angle * of_integral,
        ]
    }

    fn assert_close(found: [f64; 3], expected: [f64; 3]) {
        for (found, expected) in found.iter().zip(expected) {
            // A few roundings, and the cancellation in the smaller root.
            assert!(
                (found - expected).abs() < 1e-13 * (1.0 + expected.abs()),
                "{found} {expected}"
            );
        }
    }

    #[test]
    fn exact_both_designs_keep_the_poles_of_57() {
        let alpha = STEERING.damping_per_s;
        for zeta in [0.3, core::f64::consts::FRAC_1_SQRT_2, 1.0, 2.0] {
            let frequency_squared = alpha * alpha / (4.0 * zeta * zeta);
            // (s + p)(s^2 + alpha s + w^2)
            let with = |p: f64| [alpha + p, frequency_squared + p * alpha, p * frequency_squared];
            let light = Cascade::with_feed_forward(STEERING, zeta).unwrap();
            assert_close(characteristic(light), with(frequency_squared / alpha / 5.0));
            let full = Cascade::without_feed_forward(STEERING, zeta);
            assert_close(characteristic(full), with(alpha));
        }
        assert_eq!(Cascade::with_feed_forward(STEERING, 0.24), None);
    }

    /// alpha = 1, B = 1, zeta = 1/sqrt 2: w^2 = 1/2, p = 1/10, x^2 - 0.6 x + 0.055 = 0.
    #[test]
    fn exact_gains_by_hand() {
        let unit = Steering { damping_per_s: 1.0, authority_rad_s2: 1.0 };
        let found = Cascade::with_feed_forward(unit, core::f64::consts::FRAC_1_SQRT_2).unwrap();
        let root = 0.3 - 0.035_f64.sqrt();
        for (found, expected) in [
            (found.feed_forward_s, 1.0),
            (found.rate_gain_s, 0.1),
            (found.rate_integral_gain, root),
            (found.angle_gain_per_s, 0.05 / root),
        ] {
            // A few roundings.
            assert!((found - expected).abs() < 1e-14, "{found} {expected}");
        }
        let found = Cascade::without_feed_forward(unit, 0.5);
        assert_eq!(found.angle_gain_per_s, 1.0);
        assert_eq!((found.rate_gain_s, found.rate_integral_gain), (1.0, 1.0));
    }

    /// A heading step with an offset, integrated in small steps: the heading arrives, and overshoots little.
    #[test]
    fn recover_a_step_arrives_in_spite_of_an_offset() {
        let zeta = core::f64::consts::FRAC_1_SQRT_2;
        for cascade in [
            Cascade::with_feed_forward(STEERING, zeta).unwrap(),
            Cascade::without_feed_forward(STEERING, zeta),
        ] {
            let respond = |desired: f64, offset: f64| {
                let (mut heading, mut rate, mut integral, mut highest) = (0.0, 0.0, 0.0, 0.0_f64);
                for _ in 0..100_000 {
                    let wanted = cascade.angle_gain_per_s * (desired - heading);
                    integral += cascade.rate_integral_gain * (wanted - rate) * 1e-3;
                    let steering = cascade.feed_forward_s * wanted
                        + cascade.rate_gain_s * (wanted - rate)
                        + integral;
                    let acceleration = STEERING.authority_rad_s2 * steering
                        - STEERING.damping_per_s * rate
                        + offset;
                    rate += acceleration * 1e-3;
                    heading += rate * 1e-3;
                    highest = highest.max(heading);
                }
                (heading, highest)
            };
            // After 100 s the slowest mode, at 0.17 1/s, has decayed to e^-17.
            assert!((respond(0.1, 0.03).0 - 0.1).abs() < 1e-7);
            // (57) itself overshoots by 4.32 %; neither integral adds to it.
            let (_, highest) = respond(0.1, 0.0);
            assert!((0.102..0.1044).contains(&highest), "{highest}");
        }
    }
}
