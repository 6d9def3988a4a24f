//! A trial as a terminal shows it.

use seatrial::Step;
use seatrial::campaign::{Run, Stage};
use seatrial::identification::Refined;
use seatrial_app::conduct::Watch;
use seatrial_app::trial_run::{Begun, View};
use seatrial_core::{AbortReason, Outcome, Trial};

use super::text::run_line;
use crate::live::{Live, Parameter, Picture};

/// The live view of a trial, or its lines where standard error is no terminal.
pub(super) struct Terminal {
    live: Live,
    vehicle: String,
    intervals: Option<[[f64; 2]; 3]>,
}

impl Terminal {
    pub(super) fn new(vehicle: &str) -> Self {
        Self {
            live: Live::Log,
            vehicle: vehicle.into(),
            intervals: None,
        }
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
    fn begun(&mut self, _: &Begun) {
        self.live = Live::start();
    }

    fn faulted(&mut self, why: &str) {
        self.live.line(why);
    }

    fn ended(&mut self, _: Option<Outcome>, _: &[String]) {
        self.live.end();
    }
}

impl Watch for Terminal {
    fn step(&mut self, step: &Step, trial: &Trial<f64>) {
        if step.stage == Some(Stage::Settle) {
            self.intervals = None;
        }
        if self.live.due() {
            let picture = self.picture(trial);
            self.live.draw(&picture);
        }
    }

    fn wants_intervals(&self) -> bool {
        self.live.is_terminal()
    }

    fn interval(&mut self, refined: &Refined) {
        let interval = refined.interval_95;
        self.intervals = Some([
            interval.a22_per_s,
            interval.b2_per_s2,
            interval.c0_rad_per_s2,
        ]);
    }

    fn run_ended(&mut self, run: &mut Run) {
        self.live.line(&run_line(run));
    }
}
