//! A step away and a step back, sample by sample, without input and output.

use seatrial::gains::commission::{StepInstant, StepTest, learning_s};
use seatrial_core::envelope::EnvelopeWatch;
use seatrial_core::{AbortReason, CascadeSettings, Envelope, Real, Sample};

/// The vehicle has settled on its heading within this share of the step, and of its speed. What it is off by and still moves
/// counts as overshoot.
const NEAR_SHARE: f64 = 0.05;
const NEAR_SPEED: f64 = 0.05;
/// Smaller steps need no better than those of this size, rad.
const SMALLEST_RAD: f64 = 0.2;
/// Nothing is settled sooner, nor for a shorter time, s.
const LEAST_WAIT_S: f64 = 5.0;
const LEAST_STEADY_S: f64 = 3.0;
/// It is waited for at most so long, s, or as long as a step is held: gains that do not settle are measured all the same.
const LONGEST_WAIT_S: f64 = 30.0;

/// How long it is waited for a vehicle to settle before its first step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patience {
    /// The heading is averaged over so long, s, as where a response is measured.
    pub smoothing_s: f64,
    /// It has settled when it has been near for so long, s.
    pub steady_s: f64,
    /// The longest wait, s.
    pub longest_s: f64,
}

impl Patience {
    /// For a vehicle that has steered with its settings for a while.
    pub fn with_known(test: &StepTest, smoothing_s: f64) -> Self {
        Self { smoothing_s, steady_s: LEAST_STEADY_S, longest_s: LONGEST_WAIT_S.max(test.hold_s) }
    }

    /// For settings that have just been written, with an empty integral: until it has learnt, and near for as long as they take
    /// to leave the heading that the old ones have held.
    pub fn with_new(test: &StepTest, smoothing_s: f64, settings: &CascadeSettings<f64>) -> Self {
        let known = Self::with_known(test, smoothing_s);
        Self {
            steady_s: known.steady_s.max(1.0 / settings.angle_gain_per_s),
            longest_s: known.longest_s.max(learning_s(settings)),
            ..known
        }
    }
}

/// What is wanted of the vehicle until the next sample.
#[derive(Clone, Debug, PartialEq)]
pub struct StepDemand {
    /// The heading, rad.
    pub heading_rad: f64,
    /// The end, where this was the last sample.
    pub ended: Option<Result<StepRecord, AbortReason>>,
}

/// Both steps as they were.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StepRecord {
    /// The step away and the step back.
    pub legs: [Vec<StepInstant>; 2],
    /// Mean speed over them, m/s, where it is measured.
    pub surge_speed_m_s: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    /// Since when it is waited for, s, the mean heading error, rad, and since when the vehicle is near, s.
    Settling { since_s: f64, error_rad: f64, near_s: Option<f64> },
    /// The leg, 0 or 1, and when and at which heading it began.
    Leg { leg: usize, since_s: f64, from_rad: f64 },
}

/// The vehicle holds its heading until it has settled, is asked to turn by a step and back again, inside an envelope.
#[derive(Clone, Debug)]
pub struct StepRun {
    test: StepTest,
    patience: Patience,
    speed_m_s: Option<f64>,
    output_scale: f64,
    watch: EnvelopeWatch<f64>,
    base_rad: f64,
    phase: Option<Phase>,
    last_s: f64,
    record: StepRecord,
    speeds: (f64, f64),
}

impl StepRun {
    /// From this heading, at this speed where it is known.
    pub fn new(
        test: StepTest,
        patience: Patience,
        base_rad: f64,
        speed_m_s: Option<f64>,
        output_scale: f64,
        envelope: Envelope<f64>,
    ) -> Self {
        Self {
            test,
            patience,
            speed_m_s,
            output_scale,
            watch: EnvelopeWatch::new(envelope),
            base_rad,
            phase: None,
            last_s: f64::NEG_INFINITY,
            record: StepRecord::default(),
            speeds: (0.0, 0.0),
        }
    }

    /// Takes a sample, its rudder in fractions of full.
    pub fn step(&mut self, sample: &Sample<f64>) -> StepDemand {
        let is_sound = sample.time_s > self.last_s && sample.heading_rad.is_finite();
        let silence_s = (sample.time_s - self.last_s).max(0.0);
        if self.last_s.is_finite() {
            self.watch.listen(silence_s, sample.time_s);
        }
        if is_sound {
            self.last_s = sample.time_s;
            self.watch.look(sample, sample.time_s);
            self.watch.heading((sample.heading_rad - self.base_rad).wrapped());
        }
        if let Some(reason) = self.watch.usage().exceeded() {
            return self.wanted(Some(Err(reason)));
        }
        if !is_sound {
            return self.wanted(None);
        }
        let is_over = match self.phase {
            None => {
                self.phase = Some(Phase::Settling {
                    since_s: sample.time_s,
                    error_rad: (sample.heading_rad - self.base_rad).wrapped(),
                    near_s: None,
                });
                false
            }
            Some(Phase::Settling { since_s, error_rad, near_s }) => {
                self.settle(sample, silence_s, since_s, error_rad, near_s);
                false
            }
            Some(Phase::Leg { leg, since_s, from_rad }) => {
                self.turn(sample, leg, since_s, from_rad)
            }
        };
        let ended = is_over.then(|| {
            let (sum, count) = self.speeds;
            self.record.surge_speed_m_s = (count > 0.0).then_some(sum / count);
            Ok(std::mem::take(&mut self.record))
        });
        self.wanted(ended)
    }

    fn wanted(&self, ended: Option<Result<StepRecord, AbortReason>>) -> StepDemand {
        let away_rad = match self.phase {
            Some(Phase::Leg { leg: 0, .. }) => self.test.step_rad,
            _ => 0.0,
        };
        StepDemand { heading_rad: (self.base_rad + away_rad).wrapped(), ended }
    }

    fn settle(
        &mut self,
        sample: &Sample<f64>,
        interval_s: f64,
        since_s: f64,
        error_rad: f64,
        near_s: Option<f64>,
    ) {
        let found_rad = (sample.heading_rad - self.base_rad).wrapped();
        let weight = interval_s / (interval_s + self.patience.smoothing_s);
        let error_rad = error_rad + weight * (found_rad - error_rad);
        let is_near = error_rad.abs() < NEAR_SHARE * self.test.step_rad.max(SMALLEST_RAD);
        let is_fast = self
            .speed_m_s
            .zip(sample.surge_speed_m_s)
            .is_none_or(|(wanted, found)| (found / wanted - 1.0).abs() < NEAR_SPEED);
        let near_s = near_s.or(Some(sample.time_s)).filter(|_| is_near && is_fast);
        let is_settled = near_s.is_some_and(|at_s| sample.time_s - at_s >= self.patience.steady_s);
        let elapsed_s = sample.time_s - since_s;
        let is_over =
            is_settled && elapsed_s >= LEAST_WAIT_S || elapsed_s > self.patience.longest_s;
        self.phase = Some(match is_over {
            true => Phase::Leg { leg: 0, since_s: sample.time_s, from_rad: 0.0 },
            false => Phase::Settling { since_s, error_rad, near_s },
        });
    }

    /// `true`: both legs are over.
    fn turn(&mut self, sample: &Sample<f64>, leg: usize, since_s: f64, from_rad: f64) -> bool {
        let way = if leg == 0 { 1.0 } else { -1.0 };
        let off_rad = (sample.heading_rad - self.base_rad).wrapped();
        self.record.legs[leg].push(StepInstant {
            time_s: sample.time_s - since_s,
            turned_rad: way * (off_rad - from_rad),
            steering: way * sample.rudder_rad / self.output_scale,
            yaw_rate_rad_s: way * sample.yaw_rate_rad_s.unwrap_or(0.0),
        });
        if let Some(speed_m_s) = sample.surge_speed_m_s.filter(|speed| speed.is_finite()) {
            self.speeds.0 += speed_m_s;
            self.speeds.1 += 1.0;
        }
        if sample.time_s - since_s < self.test.hold_s {
            return false;
        }
        if leg == 0 {
            self.phase =
                Some(Phase::Leg { leg: 1, since_s: sample.time_s, from_rad: self.test.step_rad });
        }
        leg == 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEST: StepTest = StepTest {
        step_rad: 0.5,
        settle_s: 0.0,
        hold_s: 5.0,
        sample_interval_s: 0.1,
        loop_interval_s: 0.1,
    };

    fn run(heading: impl Fn(f64, f64) -> f64) -> Result<StepRecord, AbortReason> {
        let patience = Patience::with_known(&TEST, 0.2);
        let mut run = StepRun::new(TEST, patience, 3.0, None, 1.0, Envelope::default());
        let mut wanted_rad = 3.0;
        for k in 0..1000 {
            let time_s = 0.1 * f64::from(k);
            let wanted = run.step(&Sample {
                time_s,
                heading_rad: heading(time_s, wanted_rad),
                ..Sample::default()
            });
            wanted_rad = wanted.heading_rad;
            if let Some(ended) = wanted.ended {
                return ended;
            }
        }
        panic!("it does not end");
    }

    /// A vehicle that is at once where it is asked to be, across the cut of the compass.
    #[test]
    fn exact_a_run_is_a_step_away_and_a_step_back() {
        let record = run(|_, wanted_rad| wanted_rad).unwrap();
        for leg in &record.legs {
            assert!((50..=52).contains(&leg.len()), "{}", leg.len());
            let last = leg.last().unwrap();
            assert!((last.turned_rad - 0.5).abs() < 1e-9, "{last:?}");
        }
    }

    /// 3 (F + P)/I, at most 300 s; no integral, no longer than with known settings.
    #[test]
    fn exact_the_integral_is_waited_for() {
        let longest_s = |rate_integral_gain| {
            let settings = CascadeSettings {
                angle_gain_per_s: 0.1,
                feed_forward_s: 10.0,
                rate_gain_s: 2.0,
                rate_integral_gain,
                ..CascadeSettings::default()
            };
            let patience = Patience::with_new(&TEST, 0.2, &settings);
            assert_eq!(patience.steady_s, 10.0);
            patience.longest_s
        };
        for (integral, expected_s) in [(0.24, 150.0), (0.01, 300.0), (2.0, 30.0), (0.0, 30.0)] {
            assert!((longest_s(integral) - expected_s).abs() < 1e-9);
        }
    }

    #[test]
    fn exact_the_envelope_ends_it() {
        let drifting = |time_s: f64, _| 3.0 - 0.3 * time_s;
        assert_eq!(run(drifting), Err(AbortReason::HeadingExcursion));
    }
}
