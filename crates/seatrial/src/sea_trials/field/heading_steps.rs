//! The heading steps of Figs. 17 and 18 on the vehicle itself.

use seatrial_core::heading_control::GainSchedule;
use seatrial_core::heading_loop::LoopTiming;
use seatrial_core::schedule::Beyond;
use seatrial_core::{
    HeadingController, HeadingGain, Real, Sample, SchedulePoint, SpeedSchedule, Steering, Vehicle,
};
use serde::Serialize;

use super::FieldError;
use super::heading_step::{Control, HeadingStepSample, HeadingSteps, NoExperiment, StepMeasure};
use super::pilot::{Pilot, turned_rad};

/// Half of the window of the mean that takes the compass noise off the heading, in samples.
const HALF_WINDOW: usize = 4;
/// Deviation from the command that counts as a swing, as a fraction of the step.
const SWING: f64 = 0.05;

/// A step away and back on the vehicle with one controller.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SteeredSteps {
    /// Which controller.
    pub control: Control,
    /// The point of the schedule.
    pub point: SchedulePoint<f64>,
    /// The gain used.
    pub gain: HeadingGain<f64>,
    /// The step away and the step back.
    pub measures: [StepMeasure; 2],
    /// Times that the heading leaves 5 % of the step around the command after it was reached, to one side and
    /// the other in turn.
    pub swings: [u32; 2],
    /// One entry for each sample.
    #[serde(skip)]
    pub series: Vec<HeadingStepSample>,
}

/// K_p (57) between the ends of the schedule from the two end points alone (Fig. 18).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct GainFromEnds {
    /// Thrust as a fraction of full.
    pub thrust: f64,
    /// Designed from the model identified there.
    pub designed: f64,
    /// On the straight line between the gains of the end points, as in the paper.
    pub on_the_line: f64,
    /// Designed from the model between those of the end points: a22 linear, b2 linear in the speed squared.
    pub of_the_model_between: f64,
}

impl GainFromEnds {
    pub(super) fn of(
        schedule: &SpeedSchedule<f64>,
        damping_ratio: f64,
    ) -> Result<Vec<Self>, FieldError> {
        let [first, inner @ .., last] = schedule.points() else {
            return Ok(Vec::new());
        };
        let (from, to) = (thrust_of(first)?, thrust_of(last)?);
        let ends = ends_of(schedule)?;
        let gain = |point: &SchedulePoint<f64>| {
            HeadingGain::design(&point.model, damping_ratio)
                .map(|gain| gain.proportional_gain)
                .map_err(NoExperiment::NoGain)
        };
        let (slow, fast) = (gain(first)?, gain(last)?);
        let at = |point: &SchedulePoint<f64>| {
            let thrust = thrust_of(point)?;
            Ok(Self {
                thrust,
                designed: gain(point)?,
                on_the_line: slow + (thrust - from) / (to - from) * (fast - slow),
                of_the_model_between: gain(ends.lookup(thrust, Beyond::Refuse)?.value())?,
            })
        };
        inner.iter().map(at).collect()
    }
}

/// The gains of a schedule and those that its first and last point alone give.
pub(super) struct Gains {
    scheduled: GainSchedule<f64>,
    from_ends: GainSchedule<f64>,
}

impl Gains {
    pub(super) fn design(
        models: SpeedSchedule<f64>,
        damping_ratio: f64,
        timing: LoopTiming<f64>,
    ) -> Result<Self, FieldError> {
        let design = |models| {
            GainSchedule::design(models, damping_ratio, timing).map_err(NoExperiment::NoGainAt)
        };
        Ok(Self { scheduled: design(models)?, from_ends: design(ends_of(&models)?)? })
    }

    /// The scheduled gain, and between the ends the one that these alone give.
    fn at(&self, thrust: f64) -> Result<Vec<(Control, HeadingGain<f64>)>, FieldError> {
        let gain = |gains: &GainSchedule<f64>| {
            Ok::<_, FieldError>(*gains.lookup(thrust, Beyond::Refuse)?.value())
        };
        let mut controllers = vec![(Control::Scheduled, gain(&self.scheduled)?)];
        let ends = self.from_ends.models().points();
        if ends.iter().all(|end| end.thrust != Some(thrust)) {
            controllers.push((Control::Interpolated, gain(&self.from_ends)?));
        }
        Ok(controllers)
    }
}

/// The first and the last point alone.
fn ends_of(schedule: &SpeedSchedule<f64>) -> Result<SpeedSchedule<f64>, FieldError> {
    let points = schedule.points();
    let ends = [points[0], points[points.len() - 1]];
    Ok(SpeedSchedule::new(schedule.key(), &ends)?)
}

fn thrust_of(point: &SchedulePoint<f64>) -> Result<f64, FieldError> {
    point.thrust.ok_or(FieldError::Missing("thrust"))
}

/// Steps at every point of a schedule with every controller that it has there.
///
/// The constant gain is (57) for the slowest speed, which stands for the paper's tuning by hand.
pub(super) fn make<V: Vehicle<f64>>(
    pilot: &mut Pilot<V>,
    schedule: &SpeedSchedule<f64>,
    gains: &Gains,
    steps: &HeadingSteps,
    settle_s: f64,
) -> Result<Vec<SteeredSteps>, FieldError> {
    let constant = HeadingGain::design(&schedule.points()[0].model, steps.damping_ratio)
        .map_err(NoExperiment::NoGain)?
        .without_feed_forward();
    let mut runs = Vec::new();
    for point in schedule.points() {
        let mut controllers = vec![(Control::Constant, constant)];
        controllers.extend(gains.at(thrust_of(point)?)?);
        for (control, gain) in controllers {
            let controller = HeadingController::new(gain, steps.rudder_limit_rad)
                .map_err(NoExperiment::NoGain)?;
            let (series, measures, swings) =
                step_and_back(pilot, &controller, point, steps, settle_s)?;
            runs.push(SteeredSteps { control, point: *point, gain, measures, swings, series });
        }
    }
    Ok(runs)
}

type StepAndBack = (Vec<HeadingStepSample>, [StepMeasure; 2], [u32; 2]);

fn step_and_back<V: Vehicle<f64>>(
    pilot: &mut Pilot<V>,
    controller: &HeadingController<f64>,
    point: &SchedulePoint<f64>,
    steps: &HeadingSteps,
    settle_s: f64,
) -> Result<StepAndBack, FieldError> {
    let thrust = thrust_of(point)?;
    let course = pilot.hold(settle_s, thrust)?;
    let base_rad = course.last().map_or(0.0, |s| s.heading_rad);
    let mut held = |command_rad: f64, seconds: f64| {
        pilot.steer(seconds, thrust, |sample: &Sample<f64>| {
            let error_rad = (base_rad + command_rad - sample.heading_rad).wrapped();
            Some(Steering::Rudder(controller.step(error_rad)))
        })
    };
    held(0.0, settle_s)?;
    let mut series: Vec<HeadingStepSample> = Vec::new();
    let mut measures = Vec::new();
    for (command_rad, direction) in [(steps.step_rad, 1.0), (0.0, -1.0)] {
        let samples = held(command_rad, steps.hold_s)?;
        let start_rad = (samples[0].heading_rad - base_rad).wrapped();
        let smooth = smoothed(&turned_rad(&samples));
        let begun = series.len() as f64 * steps.sample_interval_s;
        let part: Vec<HeadingStepSample> = samples
            .iter()
            .zip(smooth)
            .map(|(sample, turned)| HeadingStepSample {
                time_s: begun + sample.time_s - samples[0].time_s,
                command_rad,
                heading_rad: start_rad + turned,
                rudder_rad: sample.rudder_rad,
            })
            .collect();
        measures.push((steps.measure(&part, direction), swings(&part, SWING * steps.step_rad)));
        series.extend(part);
    }
    let [(away, swings_away), (back, swings_back)] = measures[..] else {
        return Err(FieldError::Missing("heading"));
    };
    Ok((series, [away, back], [swings_away, swings_back]))
}

/// The mean over a short window around each value.
fn smoothed(values: &[f64]) -> Vec<f64> {
    let around = |k: usize| {
        let reach = HALF_WINDOW.min(k).min(values.len() - 1 - k);
        let window = &values[k - reach..=k + reach];
        window.iter().sum::<f64>() / window.len() as f64
    };
    (0..values.len()).map(around).collect()
}

/// Excursions beyond a band around the command, to either side in turn, after the command was first reached.
fn swings(series: &[HeadingStepSample], band_rad: f64) -> u32 {
    let error = |s: &HeadingStepSample| s.heading_rad - s.command_rad;
    let Some(start) = series.first().map(error) else {
        return 0;
    };
    let mut side = start.signum();
    let mut count = 0;
    for sample in series {
        let error = error(sample);
        if error * side < 0.0 && error.abs() > band_rad {
            side = -side;
            count += 1;
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(headings_rad: &[f64]) -> Vec<HeadingStepSample> {
        let samples = headings_rad.iter().map(|heading_rad| HeadingStepSample {
            time_s: 0.0,
            command_rad: 1.0,
            heading_rad: *heading_rad,
            rudder_rad: 0.0,
        });
        samples.collect()
    }

    #[test]
    fn exact_swings_count_each_side_once() {
        assert_eq!(swings(&series(&[0.0, 0.5, 0.97, 1.0, 1.04]), 0.05), 0);
        assert_eq!(swings(&series(&[0.0, 1.2, 1.3, 1.0, 1.1, 1.0]), 0.05), 1);
        assert_eq!(swings(&series(&[0.0, 1.2, 0.9, 1.06, 0.96]), 0.05), 3);
        assert_eq!(swings(&[], 0.05), 0);
    }

    #[test]
    fn exact_the_mean_keeps_a_straight_line() {
        let line: Vec<f64> = (0..20).map(f64::from).collect();
        let smooth = smoothed(&line);
        assert!(smooth.iter().zip(&line).all(|(a, b)| (a - b).abs() < 1e-12));
    }
}
