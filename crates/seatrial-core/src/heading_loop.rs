//! The closed heading loop: poles, damping, overshoot, gain, phase and delay margins.

use crate::model::{Discretisation, YawState};
use crate::no_gain::NoGain;
use crate::{Real, YawModel};

/// The closed heading loop psi/psi_d = K_p b2 / (s^2 - a22 s + K_p b2), with the rudder inside its limit.
///
/// The paper prints (55) upside down. Stable for a22 < 0 and K_p b2 > 0, the only loops that can be made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeadingLoop<T> {
    a22_per_s: T,
    /// K_p b2
    stiffness_per_s2: T,
}

/// The two poles of a second-order loop, 1/s.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Poles<T> {
    /// `real` plus and minus i `imaginary`.
    Complex {
        /// Real part, 1/s.
        real: T,
        /// Imaginary part, positive, rad/s.
        imaginary: T,
    },
    /// Two real poles, the faster first.
    Real([T; 2]),
}

/// What the loop waits for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LoopTiming<T> {
    /// Dead time of compass, computer and rudder together, s.
    pub delay_s: T,
    /// Interval over which the rudder is held constant, s. `None` is a continuous controller.
    pub sample_interval_s: Option<T>,
}

impl<T: Real> LoopTiming<T> {
    fn check(&self) -> Result<(), NoGain> {
        let interval_is_valid = self.sample_interval_s.is_none_or(|h| h.is_finite() && h > T::ZERO);
        if interval_is_valid && self.delay_s.is_finite() && self.delay_s >= T::ZERO {
            Ok(())
        } else {
            Err(NoGain::Timing)
        }
    }
}

/// How far a loop is from instability.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Margins<T> {
    /// Factor by which the gain may grow; below 1 the loop is unstable. `None` is infinite: a
    /// continuous loop without delay stays stable at every gain.
    pub gain_margin: Option<T>,
    /// Phase left at the crossover, rad; negative where the loop is unstable. `None` where the open
    /// loop is above 1 up to the Nyquist frequency.
    pub phase_margin_rad: Option<T>,
    /// Further dead time that the loop bears, s; negative where the loop is unstable.
    pub delay_margin_s: Option<T>,
    /// Frequency at which the open loop is 1, rad/s.
    pub crossover_rad_s: Option<T>,
}

impl<T: Real> HeadingLoop<T> {
    /// The loop of a model and a gain.
    ///
    /// ```
    /// use seatrial_core::{HeadingLoop, NoGain, YawModel};
    ///
    /// let model = YawModel::from_theta([-1.0, 2.0, 0.0]);
    /// // A negative gain turns away from the heading that is wanted.
    /// assert_eq!(HeadingLoop::new(&model, -0.5), Err(NoGain::WrongSign));
    /// ```
    pub fn new(model: &YawModel<T>, proportional_gain: T) -> Result<Self, NoGain> {
        let stiffness = proportional_gain * model.b2_per_s2;
        if !model.a22_per_s.is_finite() || !stiffness.is_finite() {
            return Err(NoGain::NonFinite);
        }
        if model.a22_per_s >= T::ZERO {
            return Err(NoGain::CourseUnstable);
        }
        if stiffness <= T::ZERO {
            return Err(NoGain::WrongSign);
        }
        Ok(Self { a22_per_s: model.a22_per_s, stiffness_per_s2: stiffness })
    }

    /// The closed-loop poles, (56).
    ///
    /// ```
    /// use seatrial_core::heading_loop::Poles;
    /// use seatrial_core::{HeadingLoop, YawModel};
    ///
    /// let model = YawModel::from_theta([-3.0_f64, 2.0, 0.0]);
    /// // s^2 + 3 s + 2 = (s + 2)(s + 1)
    /// let Poles::Real([fast, slow]) = HeadingLoop::new(&model, 1.0)?.poles() else {
    ///     panic!("overdamped");
    /// };
    /// assert!((fast + 2.0).abs() < 1e-12 && (slow + 1.0).abs() < 1e-12);
    /// # Ok::<(), seatrial_core::NoGain>(())
    /// ```
    pub fn poles(&self) -> Poles<T> {
        let half = self.a22_per_s / T::of(2.0);
        let discriminant = half * half - self.stiffness_per_s2;
        if discriminant < T::ZERO {
            return Poles::Complex { real: half, imaginary: (-discriminant).sqrt() };
        }
        let fast = half - discriminant.sqrt();
        // The product of the poles is K_p b2; half + sqrt would cancel.
        Poles::Real([fast, self.stiffness_per_s2 / fast])
    }

    /// omega_n = sqrt(K_p b2), rad/s.
    ///
    /// ```
    /// use seatrial_core::{HeadingLoop, YawModel};
    ///
    /// let heading_loop = HeadingLoop::new(&YawModel::from_theta([-1.0, 2.0, 0.0]), 2.0)?;
    /// assert_eq!(heading_loop.natural_frequency_rad_s(), 2.0);
    /// # Ok::<(), seatrial_core::NoGain>(())
    /// ```
    pub fn natural_frequency_rad_s(&self) -> T {
        self.stiffness_per_s2.sqrt()
    }

    /// zeta = -a22 / (2 omega_n).
    ///
    /// ```
    /// use seatrial_core::{HeadingGain, HeadingLoop, YawModel};
    ///
    /// let model = YawModel::from_theta([-1.07_f64, 1.08, 0.012]);
    /// let gain = HeadingGain::design(&model, 0.7)?;
    /// let damping_ratio = HeadingLoop::new(&model, gain.proportional_gain)?.damping_ratio();
    /// assert!((damping_ratio - 0.7).abs() < 1e-12);
    /// # Ok::<(), seatrial_core::NoGain>(())
    /// ```
    pub fn damping_ratio(&self) -> T {
        -self.a22_per_s / (T::of(2.0) * self.natural_frequency_rad_s())
    }

    /// Overshoot of a step as a fraction of it, e^{-pi zeta/sqrt(1 - zeta^2)}; 0 from zeta = 1 on.
    ///
    /// ```
    /// use seatrial_core::{HeadingLoop, YawModel};
    ///
    /// let model = YawModel::from_theta([-1.0_f64, 1.0, 0.0]);
    /// // zeta = 1/sqrt(2) and 1: 4.3 % and nothing.
    /// assert!((HeadingLoop::new(&model, 0.5)?.overshoot() - 0.0432).abs() < 1e-4);
    /// assert_eq!(HeadingLoop::new(&model, 0.25)?.overshoot(), 0.0);
    /// # Ok::<(), seatrial_core::NoGain>(())
    /// ```
    pub fn overshoot(&self) -> T {
        let zeta = self.damping_ratio();
        if zeta >= T::ONE {
            return T::ZERO;
        }
        (-T::PI * zeta / ((T::ONE - zeta) * (T::ONE + zeta)).sqrt()).exp()
    }

    /// Margins of the open loop L(s) = K_p b2 e^{-s tau} / (s (s - a22)), or of its exact
    /// zero-order-hold equivalent where the controller is sampled.
    ///
    /// Crossovers are closed forms or bisected to rounding. Only a phase crossover within 0.001 rad
    /// (at one sample) of the Nyquist frequency is taken to be there, which changes the gain margin
    /// by less than 1e-6 of itself. With sampling, the delay margin is exact in whole intervals.
    ///
    /// ```
    /// use seatrial_core::heading_loop::LoopTiming;
    /// use seatrial_core::{HeadingLoop, YawModel};
    ///
    /// let heading_loop = HeadingLoop::new(&YawModel::from_theta([-1.0_f64, 1.0, 0.0]), 0.5)?;
    /// let prompt = heading_loop.margins(LoopTiming::default())?;
    /// assert_eq!(prompt.gain_margin, None);
    /// // What dead time takes, the delay margin no longer has.
    /// let late = heading_loop.margins(LoopTiming { delay_s: 0.5, sample_interval_s: None })?;
    /// let lost_s = prompt.delay_margin_s.zip(late.delay_margin_s).map(|(before, after)| before - after);
    /// assert!(lost_s.is_some_and(|lost_s| (lost_s - 0.5).abs() < 1e-9));
    /// # Ok::<(), seatrial_core::NoGain>(())
    /// ```
    pub fn margins(&self, timing: LoopTiming<T>) -> Result<Margins<T>, NoGain> {
        timing.check()?;
        Ok(match timing.sample_interval_s {
            None => self.continuous_margins(timing.delay_s),
            Some(h) => SampledLoop::new(self, timing.delay_s, h).margins(),
        })
    }

    /// The frequency at which a loop of the same vehicle with these delays has the phase margin that this loop has
    /// without, rad/s. A hold counts as a delay of half an interval.
    pub(crate) fn crossover_delayed_rad_s(&self, timing: LoopTiming<T>) -> Result<T, NoGain> {
        timing.check()?;
        let delay_s = timing.delay_s + timing.sample_interval_s.unwrap_or(T::ZERO) / T::of(2.0);
        let prompt = self.prompt_crossover_rad_s();
        let phase = |omega: T| (-self.a22_per_s).atan2(omega);
        let margin = phase(prompt);
        Ok(bisect(T::ZERO, prompt, |omega| phase(omega) - omega * delay_s - margin))
    }

    /// The positive root of omega^4 + a^2 omega^2 - g^2, without cancellation.
    fn prompt_crossover_rad_s(&self) -> T {
        let (a, g) = (self.a22_per_s, self.stiffness_per_s2);
        (T::of(2.0) * g * g / (a * a + (a * a * a * a + T::of(4.0) * g * g).sqrt())).sqrt()
    }

    /// |L| = g/(omega sqrt(omega^2 + a^2)), arg L = -pi/2 - atan(omega/-a) - omega tau.
    fn continuous_margins(&self, delay_s: T) -> Margins<T> {
        let (a, g) = (self.a22_per_s, self.stiffness_per_s2);
        let two = T::of(2.0);
        let crossover = self.prompt_crossover_rad_s();
        let phase_above_minus_pi = |omega: T| (-a).atan2(omega) - omega * delay_s;
        let gain_margin = (delay_s > T::ZERO).then(|| {
            let omega = bisect(T::ZERO, T::PI / (two * delay_s), phase_above_minus_pi);
            omega * (omega * omega + a * a).sqrt() / g
        });
        let phase_margin = phase_above_minus_pi(crossover);
        Margins {
            gain_margin: gain_margin.filter(|m| m.is_finite()),
            phase_margin_rad: Some(phase_margin),
            delay_margin_s: Some(phase_margin / crossover),
            crossover_rad_s: Some(crossover),
        }
    }
}

/// The open loop behind a zero-order hold of interval h and a dead time (m + f) h:
///
/// ```text
/// L(z) = g z^-m (c2 z + c1 + c0/z) / ((z - 1)(z - p)),   p = e^{a22 h}
/// ```
///
/// From x+ = Phi(h) x + Gamma0 u_{k-m} + Gamma1 u_{k-m-1}, Gamma0 = Gamma(h - fh),
/// Gamma1 = Phi(h - fh) Gamma(fh). All coefficients are positive or 0, and |L| falls with frequency.
struct SampledLoop<T> {
    stiffness: T,
    interval_s: T,
    /// m
    whole_intervals: T,
    /// c2, c1, c0, s^2
    numerator: [T; 3],
    /// 1 - p
    one_minus_pole: T,
}

impl<T: Real> SampledLoop<T> {
    fn new(closed: &HeadingLoop<T>, delay_s: T, interval_s: T) -> Self {
        let a = closed.a22_per_s;
        let nearest = (delay_s / interval_s).round();
        let whole_intervals =
            if nearest * interval_s > delay_s { nearest - T::ONE } else { nearest };
        let late = (delay_s - whole_intervals * interval_s).max(T::ZERO);
        let step = Discretisation::new(a, interval_s);
        let driven = |time: T| Discretisation::new(a, time).advance(YawState::default(), T::ONE);
        let first = driven(interval_s - late);
        let second = Discretisation::new(a, interval_s - late).advance(driven(late), T::ZERO);
        // psi(z) = (psi_G z + h phi1 r_G - p psi_G) / ((z - 1)(z - p)) for x+ = Phi x + G u.
        let constant = |input: YawState<T>| {
            step.rate_gain_s * input.yaw_rate_rad_s - step.decay * input.heading_rad
        };
        Self {
            stiffness: closed.stiffness_per_s2,
            interval_s,
            whole_intervals,
            numerator: [
                first.heading_rad,
                constant(first) + second.heading_rad,
                constant(second).max(T::ZERO),
            ],
            one_minus_pole: -(a * interval_s).exp_m1(),
        }
    }

    /// cos theta - p, free of cancellation at small angles.
    fn real_from_pole(&self, theta: T) -> T {
        let half = (theta / T::of(2.0)).sin();
        self.one_minus_pole - T::of(2.0) * half * half
    }

    fn magnitude(&self, theta: T) -> T {
        let [c2, c1, c0] = self.numerator;
        let (sin, cos) = (theta.sin(), theta.cos());
        let numerator = hypotenuse(c1 + (c2 + c0) * cos, (c2 - c0) * sin);
        let from_one = T::of(2.0) * (theta / T::of(2.0)).sin();
        self.stiffness * numerator / (from_one * hypotenuse(self.real_from_pole(theta), sin))
    }

    fn phase_above_minus_pi(&self, theta: T) -> T {
        let [c2, c1, c0] = self.numerator;
        let (sin, cos) = (theta.sin(), theta.cos());
        let half = T::of(0.5);
        ((c2 - c0) * sin).atan2(c1 + (c2 + c0) * cos) + half * (T::PI - theta)
            - sin.atan2(self.real_from_pole(theta))
            - self.whole_intervals * theta
    }

    fn margins(&self) -> Margins<T> {
        let nyquist = T::PI;
        let crossover = (self.magnitude(nyquist) < T::ONE)
            .then(|| bisect(T::ZERO, nyquist, |theta| self.magnitude(theta) - T::ONE));
        let phase_margin = crossover.map(|theta| self.phase_above_minus_pi(theta));
        Margins {
            gain_margin: Some(T::ONE / self.magnitude(self.phase_crossover())),
            phase_margin_rad: phase_margin,
            delay_margin_s: crossover
                .zip(phase_margin)
                .map(|(theta, margin)| margin * self.interval_s / theta),
            crossover_rad_s: crossover.map(|theta| theta / self.interval_s),
        }
    }

    /// The first angle at which the phase is -pi. It is also -pi at the Nyquist frequency without
    /// a delay, so the search goes by steps that end just below it.
    fn phase_crossover(&self) -> T {
        const STEPS: u32 = 256;
        let last = T::PI - T::of(1e-3);
        let angle = |step: u32| last * T::of(f64::from(step)) / T::of(f64::from(STEPS));
        let above = |theta: T| self.phase_above_minus_pi(theta);
        let first = (1..=STEPS).find(|&step| above(angle(step)) < T::ZERO);
        first.map_or(T::PI, |step| bisect(angle(step - 1), angle(step), above))
    }
}

fn hypotenuse<T: Real>(x: T, y: T) -> T {
    (x * x + y * y).sqrt()
}

/// The zero of a function that is positive at `low` and not positive at `high`, to rounding.
fn bisect<T: Real>(mut low: T, mut high: T, function: impl Fn(T) -> T) -> T {
    loop {
        let middle = low + (high - low) / T::of(2.0);
        if middle <= low || middle >= high {
            return middle;
        }
        if function(middle) > T::ZERO {
            low = middle;
        } else {
            high = middle;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_real_poles_of_a_slow_loop() {
        let closed = HeadingLoop::new(&YawModel::from_theta([-1.0, 1.0, 0.0]), 1e-9).unwrap();
        let Poles::Real([fast, slow]) = closed.poles() else {
            panic!("complex poles");
        };
        assert!((fast + 1.0).abs() < 1e-8);
        // s (1 + s) = -1e-9: s = -1e-9 (1 + 1e-9 + ...).
        assert!((slow / -1e-9 - (1.0 + 1e-9)).abs() < 1e-15);
        assert_eq!(closed.overshoot(), 0.0);
    }

    fn loop_of(a22: f64, stiffness: f64) -> HeadingLoop<f64> {
        HeadingLoop::new(&YawModel::from_theta([a22, 1.0, 0.0]), stiffness).unwrap()
    }

    /// Without delay the gain margin is infinite; with the delay margin as dead time it is 1.
    #[test]
    fn exact_delay_margin_is_the_delay_that_spends_the_margins() {
        let closed = loop_of(-1.07, 0.57);
        let margins = closed.margins(LoopTiming::default()).unwrap();
        assert_eq!(margins.gain_margin, None);
        // zeta = 0.709: a phase margin of 65.6 degrees for a second-order loop.
        assert!((margins.phase_margin_rad.unwrap().to_degrees() - 65.6).abs() < 0.1);
        let critical = closed
            .margins(LoopTiming {
                delay_s: margins.delay_margin_s.unwrap(),
                sample_interval_s: None,
            })
            .unwrap();
        assert!((critical.gain_margin.unwrap() - 1.0).abs() < 1e-13);
        assert!(critical.phase_margin_rad.unwrap().abs() < 1e-13);
    }

    /// A loop whose gain is multiplied by its gain margin is on the edge: a simulation just below
    /// decays, just above grows.
    #[test]
    fn exact_sampled_gain_margin_is_the_edge_of_stability() {
        for (a22, stiffness, h, delay_s) in [
            (-1.07, 0.57, 0.05, 0.0),
            (-1.07, 0.57, 0.05, 0.1),
            (-1.07, 0.57, 0.05, 0.13),
            (-1.07, 0.57, 0.5, 0.2),
            (-4.0, 8.0, 1.0, 0.0),
            (-4.0, 8.0, 2.0, 0.0),
            (-4.0, 8.0, 0.3, 0.9),
            (-0.1, 0.005, 1.0, 2.5),
        ] {
            let timing = LoopTiming { delay_s, sample_interval_s: Some(h) };
            let margins = loop_of(a22, stiffness).margins(timing).unwrap();
            let edge = stiffness * margins.gain_margin.unwrap();
            for (factor, grows) in [(0.99, false), (1.01, true)] {
                let growth = growth_per_interval(a22, edge * factor, h, delay_s);
                assert_eq!(growth > 1.0, grows, "{a22} {h} {delay_s}: {growth}");
            }
            let stable = growth_per_interval(a22, stiffness, h, delay_s) < 1.0;
            assert_eq!(margins.gain_margin.unwrap() > 1.0, stable);
            assert_eq!(margins.phase_margin_rad.is_some_and(|m| m > 0.0), stable);
        }
    }

    /// Jury's conditions for z^2 + (g c2 - 1 - p) z + (p + g c1): a complex pair leaves the unit circle
    /// at g = (1 - p)/c1, a real pole leaves it at -1 at g = 2 (1 + p)/(c2 - c1).
    #[test]
    fn exact_sampled_gain_margin_meets_jury_conditions() {
        for h in [0.01, 0.05, 0.5, 1.0, 2.0, 3.0, 3.2, 3.3, 4.0, 20.0] {
            let (a22, stiffness): (f64, f64) = (-1.07, 0.57);
            let (phi1, phi2) = crate::model::phi(a22 * h);
            let p = (a22 * h).exp();
            let (c2, c1) = (h * h * phi2, h * h * (phi1 * phi1 - p * phi2));
            let pair = (1.0 - p) / c1;
            let at_minus_one = 2.0 * (1.0 + p) / (c2 - c1);
            let edge = if at_minus_one > 0.0 { pair.min(at_minus_one) } else { pair };
            let margins = loop_of(a22, stiffness)
                .margins(LoopTiming { delay_s: 0.0, sample_interval_s: Some(h) })
                .unwrap();
            let found = margins.gain_margin.unwrap() * stiffness;
            // The tolerance that the method states.
            assert!((found / edge - 1.0).abs() < 1e-6, "{h}: {found} {edge}");
        }
    }

    /// Mean growth of the state over the second half of 40,000 intervals of a sampled, delayed loop.
    fn growth_per_interval(a22: f64, stiffness: f64, h: f64, delay_s: f64) -> f64 {
        let model = YawModel::from_theta([a22, 1.0, 0.0]);
        let whole = (delay_s / h + 1e-9).floor();
        let late = (delay_s - whole * h).max(0.0);
        let mut commands = [0.0; 8];
        let mut state = YawState { heading_rad: 1.0, yaw_rate_rad_s: 0.0 };
        let mut log_size = 0.0;
        for k in 0..40_000 {
            commands.rotate_right(1);
            commands[0] = -stiffness * state.heading_rad;
            state = model.advance(state, commands[whole as usize + 1], late);
            state = model.advance(state, commands[whole as usize], h - late);
            let size = (state.heading_rad.powi(2) + state.yaw_rate_rad_s.powi(2)).sqrt();
            if k >= 20_000 {
                log_size += size.ln();
            }
            state.heading_rad /= size;
            state.yaw_rate_rad_s /= size;
            commands = commands.map(|c| c / size);
        }
        (log_size / 20_000.0).exp()
    }

    /// A short sample interval is a delay of half of it.
    #[test]
    fn prop_sampling_tends_to_half_an_interval_of_delay() {
        let closed = loop_of(-1.07, 0.57);
        for delay_s in [0.0, 0.0104, 0.2] {
            let margins = |delay_s, sample_interval_s| {
                closed.margins(LoopTiming { delay_s, sample_interval_s }).unwrap()
            };
            let sampled = margins(delay_s, Some(1e-3));
            let continuous = margins(delay_s + 5e-4, None);
            let difference =
                sampled.phase_margin_rad.unwrap() - continuous.phase_margin_rad.unwrap();
            // The hold's gain moves the crossover by (omega h)^2/24 = 1e-8 of itself.
            assert!(difference.abs() < 2e-8, "{difference}");
        }
    }

    #[test]
    fn parity_f32_margins() {
        for sample_interval_s in [None, Some(0.05)] {
            let double = loop_of(-1.07, 0.57)
                .margins(LoopTiming { delay_s: 0.12, sample_interval_s })
                .unwrap();
            let single = HeadingLoop::new(&YawModel::from_theta([-1.07_f32, 1.0, 0.0]), 0.57)
                .unwrap()
                .margins(LoopTiming {
                    delay_s: 0.12,
                    sample_interval_s: sample_interval_s.map(|h| h as f32),
                })
                .unwrap();
            // Rounding of f32 through a dozen operations and a bisection.
            let near = |a: Option<f32>, b: Option<f64>| {
                (f64::from(a.unwrap()) / b.unwrap() - 1.0).abs() < 1e-4
            };
            assert!(near(single.gain_margin, double.gain_margin));
            assert!(near(single.phase_margin_rad, double.phase_margin_rad));
            assert!(near(single.delay_margin_s, double.delay_margin_s));
        }
    }

    #[test]
    fn exact_bad_timing_is_refused() {
        for (delay_s, sample_interval_s) in
            [(-0.1, None), (f64::NAN, None), (0.0, Some(0.0)), (0.0, Some(f64::INFINITY))]
        {
            let timing = LoopTiming { delay_s, sample_interval_s };
            assert_eq!(loop_of(-1.0, 1.0).margins(timing), Err(NoGain::Timing));
        }
    }
}
