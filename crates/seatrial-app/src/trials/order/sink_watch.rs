//! Who watches a trial: the logbook, the recording, the views, the clock, the operator.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use seatrial::campaign::{Run, Stage};
use seatrial::identification::{ReasonCode, Refined};
use seatrial::{Campaign, Step};
use seatrial_core::Trial;
use seatrial_logbook::{CampaignId, Keeper, Recorder};
use seatrial_logs::{Estimate, Row, RowWriter};

use super::recording_thread::RecordingThread;
use super::{OrderResult, View};
use crate::conduct::{Pace, Watch};
use crate::trials::recording::Recording;

impl Watch for Keeper {
    fn run_started(&mut self, number: u32, thrust: f64, attempt: u32) {
        self.begin_run(number, thrust, attempt);
    }

    fn step(&mut self, step: &Step, _trial: &Trial<f64>) {
        self.keep(step);
    }

    fn run_ended(&mut self, run: &mut Run) {
        self.end_run(run);
    }
}

/// Every sink of a trial.
pub(super) struct SinkWatch {
    keeper: Keeper,
    recording: Option<RecordingThread>,
    rows: Vec<Box<dyn RowWriter>>,
    views: Vec<Box<dyn View>>,
    half_widths: Option<[f64; 3]>,
    pace: Option<Pace>,
    stop: Arc<AtomicBool>,
}

impl SinkWatch {
    pub(super) fn new(
        recorder: Recorder,
        is_live: bool,
        recording: Option<Recording>,
        rows: Vec<Box<dyn RowWriter>>,
        views: Vec<Box<dyn View>>,
    ) -> Self {
        Self {
            keeper: Keeper::new(recorder, is_live),
            recording: recording.map(|recording| RecordingThread::start(recording, is_live)),
            rows,
            views,
            half_widths: None,
            pace: None,
            stop: Arc::default(),
        }
    }

    pub(super) fn paced(self, pace: Option<Pace>) -> Self {
        Self { pace, ..self }
    }

    pub(super) fn stopped_by(self, stop: Arc<AtomicBool>) -> Self {
        Self { stop, ..self }
    }

    pub(super) fn faulted(&mut self, why: &str) {
        self.views.iter_mut().for_each(|view| view.faulted(why));
    }

    /// Waits until all is kept, as long as the operator has not asked for the end, and shows how the trial ended.
    pub(super) fn end(
        mut self,
        number: CampaignId,
        mut campaign: Campaign,
        fault: Option<String>,
        not_put_back: Option<String>,
    ) -> OrderResult {
        let is_asked_to_end = || self.stop.load(Ordering::Relaxed);
        let recorded = self.recording.take();
        let not_recorded = recorded.map(|recorded| recorded.finish(is_asked_to_end));
        let kept = self.keeper.end(campaign.outcome, is_asked_to_end);
        let is_kept = kept.unsaved.is_empty();
        let mut unsaved: Vec<String> = not_put_back.into_iter().collect();
        unsaved.extend(kept.put_back(&mut campaign.runs));
        unsaved.extend(not_recorded.into_iter().flatten());
        let warnings: Vec<String> = fault.iter().chain(&unsaved).cloned().collect();
        for view in &mut self.views {
            view.ended(&campaign, &warnings);
        }
        OrderResult { number, campaign, fault, is_kept, unsaved }
    }
}

impl Watch for SinkWatch {
    fn run_started(&mut self, number: u32, thrust: f64, attempt: u32) {
        self.keeper.run_started(number, thrust, attempt);
        for view in &mut self.views {
            view.run_started(number, thrust, attempt);
        }
    }

    fn step(&mut self, step: &Step, trial: &Trial<f64>) {
        self.keeper.step(step, trial);
        self.views.iter_mut().for_each(|view| view.step(step, trial));
        if step.stage == Some(Stage::Settle) {
            self.half_widths = None;
        }
        let row = Row {
            sample: step.sample,
            stage: step.stage,
            estimate: step.estimate.map(|model| Estimate {
                model,
                half_widths: self.half_widths,
                step_norm: trial.estimator().step_norm(),
            }),
        };
        if let Some(recording) = &mut self.recording {
            recording.take(row);
        }
        for rows in &mut self.rows {
            // A row without a time cannot be shown; the logbook has it.
            let _ = rows.write(&row);
        }
        if let Some(pace) = &mut self.pace {
            pace.wait(step.sample.time_s);
        }
    }

    fn wants_intervals(&self) -> bool {
        self.recording.is_some()
            || !self.rows.is_empty()
            || self.views.iter().any(|view| view.wants_intervals())
    }

    fn interval(&mut self, refined: &Refined) {
        self.views.iter_mut().for_each(|view| view.interval(refined));
        let interval = refined.interval_95;
        let intervals = [interval.a22_per_s, interval.b2_per_s2, interval.c0_rad_per_s2];
        self.half_widths = Some(intervals.map(|[low, high]| 0.5 * (high - low)));
    }

    fn run_ended(&mut self, run: &mut Run) {
        self.keeper.run_ended(run);
        if let Some(recording) = &mut self.recording {
            recording.run_ended();
        }
        self.views.iter_mut().for_each(|view| view.run_ended(run));
        // The record of a run that was aborted shows why.
        if !run.verdict.has(&ReasonCode::Aborted) {
            self.keeper.release(run);
        }
    }

    fn wants_abort(&mut self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}
