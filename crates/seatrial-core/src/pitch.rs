//! Pitch under the elevator: the model, its estimator and the vehicle that dives.

use crate::state_variable_filter::{FilterStart, FilterStep, Hold, StateVariableFilter};
use crate::{Forgetting, Real, RecursiveInstrument, RecursiveLeastSquares};

/// Most that a step of the integration is of the fastest time constant.
const LARGEST_STEP: f64 = 0.1;
/// Most steps in an interval.
const MOST_STEPS: f64 = 1000.0;
/// Time after the first sample before anything is learnt, in time constants of the filter: 0.3 % of a wrong
/// start is left.
const WARM_TIME_CONSTANTS: f64 = 8.0;

/// Pitch with a restoring moment.
///
/// ```text
/// theta' = q
/// q'     = a q + m theta + b delta_e + c
/// ```
///
/// | symbol | identifier | unit | positive sense |
/// |---|---|---|---|
/// | theta, q | `pitch_rad`, `pitch_rate_rad_s` | rad, rad/s | bow up |
/// | delta_e | `elevator_rad` | rad | pitches the bow up where b is positive |
/// | a | `damping_per_s` | 1/s | negative for a damped vehicle |
/// | m | `restoring_per_s2` | 1/s^2 | negative where weight below buoyancy rights it |
/// | b | `authority_per_s2` | 1/s^2 | |
/// | c | `offset_rad_per_s2` | rad/s^2 | pitch acceleration level at neutral elevator |
///
/// Source: the yaw model (5)-(7) of the paper carried to the diving plane with the restoring moment
/// of Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, section 4.1. q is theta' at small
/// roll. Heave is to it what sway is to yaw: left out.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PitchModel<T> {
    /// a, 1/s.
    pub damping_per_s: T,
    /// m, 1/s^2.
    pub restoring_per_s2: T,
    /// b, 1/s^2.
    pub authority_per_s2: T,
    /// c, rad/s^2.
    pub offset_rad_per_s2: T,
}

/// Pitch and pitch rate at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PitchState<T> {
    /// Pitch, rad.
    pub pitch_rad: T,
    /// Pitch rate, rad/s.
    pub pitch_rate_rad_s: T,
}

impl<T: Real> PitchModel<T> {
    /// The model of a parameter vector [a, m, b, c].
    pub fn from_theta([a, m, b, c]: [T; 4]) -> Self {
        Self {
            damping_per_s: a,
            restoring_per_s2: m,
            authority_per_s2: b,
            offset_rad_per_s2: c,
        }
    }

    /// The parameter vector [a, m, b, c].
    pub fn theta(&self) -> [T; 4] {
        [
            self.damping_per_s,
            self.restoring_per_s2,
            self.authority_per_s2,
            self.offset_rad_per_s2,
        ]
    }

    /// Damped and not overturned by the flow: a < 0 and m < 0.
    pub fn is_stable(&self) -> bool {
        self.damping_per_s < T::ZERO && self.restoring_per_s2 < T::ZERO
    }

    /// The state `interval_s` later with the elevator held, by the fourth-order Runge-Kutta method in steps of a tenth
    /// of the fastest time constant: 1e-7 of a step's change.
    pub fn advance(&self, state: PitchState<T>, elevator_rad: T, interval_s: T) -> PitchState<T> {
        let fastest_per_s = self.damping_per_s.abs() + self.restoring_per_s2.abs().sqrt();
        let wanted = interval_s * fastest_per_s / T::of(LARGEST_STEP);
        let steps = (wanted + T::of(0.5))
            .round()
            .max(T::ONE)
            .min(T::of(MOST_STEPS));
        if !steps.is_finite() {
            return state;
        }
        let h = interval_s / steps;
        let input = self.authority_per_s2 * elevator_rad + self.offset_rad_per_s2;
        let rate = |s: PitchState<T>| PitchState {
            pitch_rad: s.pitch_rate_rad_s,
            pitch_rate_rad_s: self.damping_per_s * s.pitch_rate_rad_s
                + self.restoring_per_s2 * s.pitch_rad
                + input,
        };
        let plus = |s: PitchState<T>, k: PitchState<T>, h: T| PitchState {
            pitch_rad: s.pitch_rad + h * k.pitch_rad,
            pitch_rate_rad_s: s.pitch_rate_rad_s + h * k.pitch_rate_rad_s,
        };
        let (half, two, sixth) = (T::of(0.5) * h, T::of(2.0), h / T::of(6.0));
        let mut now = state;
        let mut left = steps;
        while left > T::of(0.5) {
            let k1 = rate(now);
            let k2 = rate(plus(now, k1, half));
            let k3 = rate(plus(now, k2, half));
            let k4 = rate(plus(now, k3, h));
            now = plus(plus(now, k1, sixth), k4, sixth);
            now = plus(plus(now, k2, two * sixth), k3, two * sixth);
            left -= T::ONE;
        }
        now
    }
}

/// One instant of a vehicle in the diving plane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DivingSample<T> {
    /// The vehicle's own clock, s.
    pub time_s: f64,
    /// Pitch, rad.
    pub pitch_rad: T,
    /// Elevator that acts from this instant on, rad.
    pub elevator_rad: T,
    /// Depth, m.
    pub depth_m: Option<T>,
    /// Forward speed, m/s.
    pub surge_speed_m_s: Option<T>,
}

/// What the elevator is to do until the next command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Diving<T> {
    /// The vehicle's own controller holds its depth.
    HoldDepth,
    /// Hold this elevator angle, rad.
    Elevator(T),
}

/// A vehicle whose elevator can be commanded. Its heading it holds itself.
pub trait DivingVehicle<T> {
    /// Why it cannot.
    type Error;
    /// The next sample; `None` where there are no more.
    fn next_diving_sample(&mut self) -> Result<Option<DivingSample<T>>, Self::Error>;
    /// Elevator and thrust from the next sample on.
    fn dive(&mut self, diving: Diving<T>, thrust: T) -> Result<(), Self::Error>;
}

/// Estimates the pitch model while the vehicle manoeuvres: the state variable filter, least squares
/// in four parameters and, after the excitation, the instrumental variable.
///
/// ```text
/// theta''_f = a theta'_f + m theta_f + b delta_f + c
/// ```
///
/// | symbol | meaning |
/// |---|---|
/// | _f | through the state variable filter (16), first-order hold on pitch, zero-order on the elevator |
///
/// The instrument is the model's own theta'_f and theta_f, driven by delta_f. As for yaw, it takes over from
/// least squares when the excitation is over. Samples that are not finite or do not increase in time are
/// ignored.
#[derive(Clone, Copy, Debug)]
pub struct PitchEstimator<T> {
    step: FilterStep<T>,
    filters: Option<(f64, StateVariableFilter<T>, StateVariableFilter<T>)>,
    filtered_for_s: T,
    least_squares: RecursiveLeastSquares<T, 4>,
    instrument: Option<RecursiveInstrument<T, 4>>,
    auxiliary: Option<PitchState<T>>,
    used: u32,
}

impl<T: Real> PitchEstimator<T> {
    /// P0, as for yaw.
    const INITIAL_COVARIANCE: f64 = 1e6;

    /// An estimator with its filter's pole at `-lambda_rad_s`.
    pub fn new(lambda_rad_s: T) -> Self {
        Self {
            step: FilterStep::new(lambda_rad_s),
            filters: None,
            filtered_for_s: T::ZERO,
            least_squares: RecursiveLeastSquares::new(T::of(Self::INITIAL_COVARIANCE)),
            instrument: None,
            auxiliary: None,
            used: 0,
        }
    }

    /// Takes in a sample of the settling phase: moves the filters, learns nothing.
    pub fn warm(&mut self, sample: &DivingSample<T>) {
        self.filter(sample);
    }

    /// Takes in a sample of the training phase. The elevator acts from this instant on.
    pub fn update(&mut self, sample: &DivingSample<T>) {
        let before_s = self.filtered_for_s;
        if !self.filter(sample) {
            return;
        }
        let Some((_, pitch, elevator)) = &self.filters else {
            return;
        };
        let (angle, rate, acceleration) = (
            pitch.smoothed(),
            pitch.first_derivative(&self.step),
            pitch.second_derivative(&self.step),
        );
        let elevator = elevator.smoothed();
        let model = self.model();
        let auxiliary = match self.auxiliary {
            Some(state) => model.advance(state, elevator, self.filtered_for_s - before_s),
            None => PitchState {
                pitch_rad: angle,
                pitch_rate_rad_s: rate,
            },
        };
        self.auxiliary = Some(auxiliary);
        if self.filtered_for_s * self.step.lambda_rad_s() < T::of(WARM_TIME_CONSTANTS) {
            return;
        }
        let regressor = [rate, angle, elevator, T::ONE];
        let forgetting = Forgetting {
            factor: T::ONE,
            trace_limit: T::of(4.0 * Self::INITIAL_COVARIANCE),
        };
        if self
            .least_squares
            .update(regressor, acceleration, forgetting)
        {
            self.used = self.used.saturating_add(1);
        }
        if let Some(recursion) = &mut self.instrument {
            let instrument = [
                auxiliary.pitch_rate_rad_s,
                auxiliary.pitch_rad,
                elevator,
                T::ONE,
            ];
            recursion.update(regressor, instrument, acceleration);
        }
    }

    /// The excitation is over: the instrument takes over, unless the estimate is unstable.
    pub fn excitation_ended(&mut self) {
        let model = PitchModel::from_theta(self.least_squares.theta());
        if self.instrument.is_none() && model.is_stable() {
            self.instrument = Some(RecursiveInstrument::take_over(&self.least_squares));
        }
    }

    /// The estimate: of the instrument, unless it has left what is stable, and of least squares before.
    pub fn model(&self) -> PitchModel<T> {
        self.instrument
            .map(|instrument| PitchModel::from_theta(instrument.theta()))
            .filter(PitchModel::is_stable)
            .unwrap_or(PitchModel::from_theta(self.least_squares.theta()))
    }

    /// Samples learnt from.
    pub fn samples_used(&self) -> u32 {
        self.used
    }

    /// Moves the filters; `false` where the sample is ignored.
    fn filter(&mut self, sample: &DivingSample<T>) -> bool {
        let finite = sample.time_s.is_finite()
            && sample.pitch_rad.is_finite()
            && sample.elevator_rad.is_finite();
        if !finite {
            return false;
        }
        let Some((time_s, pitch, elevator)) = &mut self.filters else {
            let start = FilterStart::Equilibrium;
            self.filters = Some((
                sample.time_s,
                StateVariableFilter::new(sample.pitch_rad, start),
                StateVariableFilter::new(sample.elevator_rad, start),
            ));
            return true;
        };
        let interval_s = T::of(sample.time_s - *time_s);
        if interval_s <= T::ZERO {
            return false;
        }
        self.step.set_interval(interval_s);
        pitch.advance(sample.pitch_rad, Hold::FirstOrder, &self.step);
        // What the elevator had been set to over the interval is what its filter already has.
        elevator.advance(sample.elevator_rad, Hold::ZeroOrder, &self.step);
        *time_s = sample.time_s;
        self.filtered_for_s += interval_s;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MODEL: PitchModel<f64> = PitchModel {
        damping_per_s: -1.4,
        restoring_per_s2: -0.3,
        authority_per_s2: 1.1,
        offset_rad_per_s2: 0.01,
    };

    fn record(amplitude_rad: f64) -> impl Iterator<Item = DivingSample<f64>> {
        let mut state = PitchState {
            pitch_rad: 0.01 / 0.3,
            pitch_rate_rad_s: 0.0,
        };
        (0..530).map(move |k| {
            let elevator_rad = match k {
                240..260 => amplitude_rad,
                260..280 => -amplitude_rad,
                _ => 0.0,
            };
            let sample = DivingSample {
                time_s: f64::from(k) * 0.05,
                pitch_rad: state.pitch_rad,
                elevator_rad,
                ..DivingSample::default()
            };
            state = MODEL.advance(state, elevator_rad, 0.05);
            sample
        })
    }

    fn estimated(samples: impl Iterator<Item = DivingSample<f64>>) -> PitchModel<f64> {
        let mut estimator = PitchEstimator::new(3.0);
        for (k, sample) in samples.enumerate() {
            if k < 200 {
                estimator.warm(&sample);
            } else {
                if k == 280 {
                    estimator.excitation_ended();
                }
                estimator.update(&sample);
            }
        }
        estimator.model()
    }

    /// The closed form of the oscillation, here with m = -4: critically damped at a = -4.
    #[test]
    fn exact_advance_meets_the_closed_form() {
        let model = PitchModel::from_theta([-4.0, -4.0, 0.0, 0.0]);
        let start = PitchState {
            pitch_rad: 1.0,
            pitch_rate_rad_s: 0.0,
        };
        let after = model.advance(start, 0.0, 0.7);
        // (1 + 2t) e^-2t.
        let expected = 2.4 * (-1.4_f64).exp();
        assert!((after.pitch_rad - expected).abs() < 1e-6, "{after:?}");
    }

    #[test]
    fn exact_recovery_without_noise() {
        let found = estimated(record(0.1));
        for (found, truth) in found.theta().iter().zip(MODEL.theta()) {
            // Pitch is not straight between samples: (lambda h)^2/12 = 0.2 %.
            assert!(
                (found - truth).abs() < 0.01 * truth.abs(),
                "{found} {truth}"
            );
        }
    }

    /// Numbers that are none and time that stands still change nothing.
    #[test]
    fn prop_unsound_samples_are_ignored() {
        let unsound = record(0.1).flat_map(|sample| {
            let bad = DivingSample {
                pitch_rad: f64::NAN,
                ..sample
            };
            [sample, bad, sample]
        });
        let mut estimator = PitchEstimator::new(3.0);
        let mut reference = PitchEstimator::new(3.0);
        unsound.for_each(|sample| estimator.update(&sample));
        record(0.1).for_each(|sample| reference.update(&sample));
        assert_eq!(estimator.model(), reference.model());
    }
}
