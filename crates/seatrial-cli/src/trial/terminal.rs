//! A trial as a terminal shows it.

use std::collections::VecDeque;

use seatrial::campaign::{Run, Stage};
use seatrial::identification::Refined;
use seatrial::{Campaign, Step};
use seatrial_app::conduct::Watch;
use seatrial_app::trials::order::{CampaignStart, View};
use seatrial_core::{AbortReason, Sample, Trial};

use super::text::run_line;
use crate::live::{Live, Parameter, Picture, Strip};

/// Samples that the strips show: about a run of the paper's plan.
const SHOWN: usize = 900;

/// The live view of a trial, or its lines where standard error is no terminal.
pub(super) struct Terminal {
    live: Live,
    vehicle: String,
    intervals: Option<[[f64; 2]; 3]>,
    samples: VecDeque<Sample<f64>>,
}

impl Terminal {
    pub(super) fn new(vehicle: &str) -> Self {
        Self { live: Live::LOG, vehicle: vehicle.into(), intervals: None, samples: VecDeque::new() }
    }

    fn picture(&self, trial: &Trial<f64>) -> Picture {
        let status = trial.status();
        let parameter = |index: usize, name, unit| Parameter {
            name,
            value: status.model.theta()[index],
            interval: self.intervals.map(|intervals| intervals[index]),
            unit,
        };
        Picture {
            title: format!(
                "{}   run {}, speed {} of {}, {:.0} % thrust, try {}",
                self.vehicle,
                status.run,
                status.speed,
                status.speeds,
                100.0 * status.thrust,
                status.attempt
            ),
            stage: status.stage,
            elapsed_s: status.elapsed_s,
            remaining_s: status.remaining_s,
            left_s: left_s(trial),
            strips: self.strips(),
            parameters: [
                parameter(0, "a22", "1/s"),
                parameter(1, "b2", "1/s^2"),
                parameter(2, "C0", "rad/s^2"),
            ],
            step_norm: status.step_norm,
            threshold: trial.estimator().settings().convergence.threshold,
            converged_s: trial.estimator().converged_s(),
            envelope: status
                .envelope
                .limits()
                .into_iter()
                .filter_map(|(limit, used)| Some((short(limit), used?)))
                .collect(),
        }
    }
}

impl Terminal {
    fn strips(&self) -> Vec<Strip> {
        let strip = |name, unit, decimals, least_span, value: fn(&Sample<f64>) -> Option<f64>| {
            let known = self.samples.iter().filter_map(|sample| {
                let value = value(sample).filter(|value| value.is_finite())?;
                Some((sample.time_s, value))
            });
            Strip { name, unit, decimals, least_span, points: known.collect() }
        };
        let mut strips = vec![
            strip("heading", "deg", 1, 5.0, |s| Some(s.heading_rad.to_degrees())),
            strip("rudder", "deg", 1, 5.0, |s| Some(s.rudder_rad.to_degrees())),
            strip("speed", "m/s", 2, 0.2, |s| s.surge_speed_m_s),
            strip("depth", "m", 2, 0.5, |s| s.depth_m),
        ];
        strips[0].points = unwrapped(std::mem::take(&mut strips[0].points));
        strips
    }
}

/// Headings in degrees without jumps, the last one from 0 to 360.
fn unwrapped(mut points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    let mut after: Option<f64> = None;
    for (_, heading) in points.iter_mut().rev() {
        *heading = match after {
            None => heading.rem_euclid(360.0),
            Some(after) => after + (*heading - after + 180.0).rem_euclid(360.0) - 180.0,
        };
        after = Some(*heading);
    }
    points
}

/// Time until the trial ends without repeats, s: settling takes the shortest time that the plan allows.
fn left_s(trial: &Trial<f64>) -> f64 {
    let (plan, status) = (trial.plan(), trial.status());
    let [settle_s, train_s, validate_s] =
        [plan.settle.at_least_s, plan.training.duration_s(), plan.validation.duration_s()];
    let of_this_speed_s = match status.stage {
        Some(Stage::Settle) => (settle_s - status.elapsed_s).max(0.0) + train_s + validate_s,
        Some(Stage::Train) => status.remaining_s + validate_s,
        Some(Stage::Validate) => status.remaining_s,
        None => 0.0,
    };
    let speeds_after = status.speeds.saturating_sub(status.speed);
    of_this_speed_s + speeds_after as f64 * (settle_s + train_s + validate_s)
}

/// The limit that a reason is about, in a word.
fn short(limit: AbortReason) -> &'static str {
    match limit {
        AbortReason::Depth => "depth",
        AbortReason::Altitude => "altitude",
        AbortReason::Roll => "roll",
        AbortReason::Pitch => "pitch",
        AbortReason::YawRate => "rate",
        AbortReason::HeadingExcursion => "heading",
        AbortReason::Area => "area",
        AbortReason::SpeedDrift => "speed",
        AbortReason::StaleSamples => "silence",
        AbortReason::StageTimeLimit => "time",
        _ => "other",
    }
}

impl View for Terminal {
    /// Not before: until then the operator may be asked to agree.
    fn begun(&mut self, _: &CampaignStart) {
        self.live = Live::start();
    }

    fn faulted(&mut self, why: &str) {
        self.live.line(why);
    }

    fn ended(&mut self, _: &Campaign, _: &[String]) {
        self.live.end();
    }
}

impl Watch for Terminal {
    fn step(&mut self, step: &Step, trial: &Trial<f64>) {
        if step.stage == Some(Stage::Settle) {
            self.intervals = None;
        }
        if self.live.is_watched() {
            self.samples.push_back(step.sample);
            while self.samples.len() > SHOWN {
                self.samples.pop_front();
            }
        }
        if self.live.due() {
            let picture = self.picture(trial);
            self.live.draw(picture);
        }
    }

    fn wants_intervals(&self) -> bool {
        self.live.is_watched()
    }

    fn interval(&mut self, refined: &Refined) {
        let interval = refined.interval_95;
        self.intervals = Some([interval.a22_per_s, interval.b2_per_s2, interval.c0_rad_per_s2]);
    }

    fn run_ended(&mut self, run: &mut Run) {
        self.live.line(&run_line(run));
    }
}
