//! Between the trial and whoever is told of it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use seatrial::Step;
use seatrial::campaign::{Campaign, Run, Stage};
use seatrial::identification::Refined;
use seatrial_app::conduct::{Pace, Watch};
use seatrial_core::{AbortReason, Outcome, Plan, Trial};
use seatrial_dash::{Server, Tap};
use seatrial_logbook::{CampaignId, Keeper, Recorder};
use seatrial_logs::{Estimate, Row, RowWriter};

use super::Args;
use super::text::run_line;
use crate::live::{Live, Parameter, Picture};
use crate::output::{Failure, say};
use crate::record::Recording;

/// The trial on the dashboard.
pub(super) struct Shown {
    server: Server,
    tap: Tap,
}

impl Shown {
    pub(super) fn begin(
        server: Server,
        number: CampaignId,
        about: &Campaign,
        plan: &Plan<f64>,
        stop: &Arc<AtomicBool>,
    ) -> Result<Self, Failure> {
        let tap = server.attach(number, about, plan, Arc::clone(stop));
        let tap =
            tap.ok_or_else(|| Failure::aborted("the dashboard was used to start another trial"))?;
        say(format_args!("the dashboard is at {}", server.url()));
        Ok(Self { server, tap })
    }

    fn end(self, outcome: Option<Outcome>, unsaved: &[String]) {
        self.server.detach(&self.tap, outcome, unsaved.to_vec());
        self.server.stop();
    }
}

/// The logbook, the recording, the live views, the clock, the operator.
pub(super) struct Bridge {
    keeper: Keeper,
    recording: Option<Recording>,
    viewers: Vec<Box<dyn RowWriter>>,
    shown: Option<Shown>,
    unsaved: Vec<String>,
    live: Live,
    vehicle: String,
    intervals: Option<[[f64; 2]; 3]>,
    pace: Option<Pace>,
    stop: Arc<AtomicBool>,
}

impl Bridge {
    pub(super) fn new(
        args: &Args,
        is_live: bool,
        recorder: Recorder,
        recording: Option<Recording>,
        viewers: Vec<Box<dyn RowWriter>>,
        shown: Option<Shown>,
        stop: Arc<AtomicBool>,
    ) -> Self {
        Self {
            keeper: Keeper::new(recorder, is_live),
            recording,
            viewers,
            shown,
            unsaved: Vec::new(),
            live: Live::start(),
            vehicle: args.vehicle.clone(),
            intervals: None,
            pace: args.realtime.then(|| Pace::new(1.0)),
            stop,
        }
    }

    /// Says it beside the live view.
    pub(super) fn tell(&mut self, line: &str) {
        self.live.line(line);
    }

    /// Records something; what cannot be recorded does not stop the trial.
    fn record(&mut self, record: impl FnOnce(&mut Recording) -> Result<(), Failure>) {
        if let Some(recording) = &mut self.recording
            && let Err(failure) = record(recording)
        {
            self.note(failure.to_string());
        }
    }

    /// Notes what could not be kept.
    fn note(&mut self, unsaved: String) {
        if !self.unsaved.contains(&unsaved) {
            self.unsaved.push(unsaved);
        }
    }

    /// What could not be kept.
    pub(super) fn end(mut self, campaign: &mut Campaign) -> Vec<String> {
        self.live.end();
        if let Some(recording) = self.recording.take()
            && let Err(failure) = recording.finish()
        {
            self.note(failure.to_string());
        }
        let kept = self.keeper.end(campaign.outcome);
        let mut unsaved = kept.put_back(&mut campaign.runs);
        unsaved.extend(self.unsaved);
        if let Some(shown) = self.shown {
            shown.end(campaign.outcome, &unsaved);
        }
        unsaved
    }

    fn row(&self, step: &Step, trial: &Trial<f64>) -> Row {
        let half_width = |[low, high]: [f64; 2]| 0.5 * (high - low);
        Row {
            sample: step.sample,
            stage: step.stage,
            estimate: step.estimate.map(|model| Estimate {
                model,
                half_widths: self.intervals.map(|intervals| intervals.map(half_width)),
                step_norm: trial.estimator().step_norm(),
            }),
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

impl Watch for Bridge {
    fn run_started(&mut self, number: u32, thrust: f64, attempt: u32) {
        self.keeper.run_started(number, thrust, attempt);
        if let Some(shown) = &mut self.shown {
            shown.tap.run_started(number, thrust, attempt);
        }
    }

    fn step(&mut self, step: &Step, trial: &Trial<f64>) {
        self.keeper.step(step, trial);
        if let Some(shown) = &mut self.shown {
            shown.tap.step(step, trial);
        }
        if step.stage == Some(Stage::Settle) {
            self.intervals = None;
        }
        let row = self.row(step, trial);
        self.record(|recording| recording.take(row));
        for viewer in &mut self.viewers {
            // A row without a time cannot be shown; the logbook has it.
            let _ = viewer.write(&row);
        }
        if self.live.due() {
            let picture = self.picture(trial);
            self.live.draw(&picture);
        }
        if let Some(pace) = &mut self.pace {
            pace.wait(step.sample.time_s);
        }
    }

    fn wants_intervals(&self) -> bool {
        self.live.is_terminal()
            || self.recording.is_some()
            || !self.viewers.is_empty()
            || self.shown.is_some()
    }

    fn interval(&mut self, refined: &Refined) {
        if let Some(shown) = &mut self.shown {
            shown.tap.interval(refined);
        }
        let interval = refined.interval_95;
        self.intervals = Some([
            interval.a22_per_s,
            interval.b2_per_s2,
            interval.c0_rad_per_s2,
        ]);
    }

    fn run_ended(&mut self, run: &mut Run) {
        self.keeper.run_ended(run);
        if let Some(shown) = &mut self.shown {
            shown.tap.run_ended(run);
        }
        self.keeper.release(run);
        self.record(Recording::run_ended);
        self.live.line(&run_line(run));
    }

    fn wants_abort(&mut self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}
