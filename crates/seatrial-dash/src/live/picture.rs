//! The picture of a trial, and the messages that are made of it.

use std::collections::VecDeque;
use std::time::Instant;

use seatrial_core::model::YawState;
use seatrial_core::progress::Status;
use seatrial_core::{Real, Sample, YawModel};
use tokio::sync::broadcast;

use super::decimator::Decimator;
use super::tap::{Moment, Report, Start};
use super::{HEARTBEAT_EVERY, Message, SAMPLES_EVERY, text};
use crate::api::{
    CommissionState, Control, Envelope, EnvelopeUse, EstimateNow, Figure, Health, LiveEvent,
    LiveMessage, LiveSample, Progress, Snapshot, Stage, StreamSettings, TrialState,
};
use crate::convert::{name_of, now, run_summary, validation_of};

/// Messages that a viewer may lie behind.
const MOST_BEHIND: usize = 256;
/// Messages that are kept for who comes back, bytes: of a trial in real time those of some minutes.
const KEPT_BYTES: usize = 4 << 20;
/// Intervals between samples that their mean is taken of.
const INTERVALS: usize = 64;

/// Everything that a viewer needs to draw.
#[derive(Debug)]
pub struct Picture {
    stream: String,
    sequence: u64,
    sender: broadcast::Sender<Message>,
    recent: VecDeque<Message>,
    recent_bytes: usize,
    control: Control,
    trial: Option<TrialState>,
    commission: Option<CommissionState>,
    envelope: Option<Envelope>,
    threshold: f64,
    intervals: Option<[[f64; 2]; 3]>,
    simulation: Option<Simulation>,
    unsent: Vec<LiveSample>,
    samples: Decimator<LiveSample>,
    estimates: Decimator<EstimateNow>,
    track_m: Decimator<[f64; 2]>,
    health: Health,
    last: Option<(Sample<f64>, Instant)>,
    first: Option<(f64, Instant)>,
    intervals_s: VecDeque<f64>,
}

/// The validation stage as the model just trained sees it.
#[derive(Clone, Copy, Debug)]
struct Simulation {
    model: YawModel<f64>,
    state: YawState<f64>,
    last: Sample<f64>,
}

impl Picture {
    pub fn new(stream: String) -> Self {
        Self {
            stream,
            sequence: 0,
            sender: broadcast::channel(MOST_BEHIND).0,
            recent: VecDeque::new(),
            recent_bytes: 0,
            control: Control { holder: None, since: None, silent_for_s: None, is_you: false },
            trial: None,
            commission: None,
            envelope: None,
            threshold: 0.0,
            intervals: None,
            simulation: None,
            unsent: Vec::new(),
            samples: Decimator::default(),
            estimates: Decimator::default(),
            track_m: Decimator::default(),
            health: Health::default(),
            last: None,
            first: None,
            intervals_s: VecDeque::new(),
        }
    }

    fn publish(&mut self, event: LiveEvent) {
        self.sequence += 1;
        let sequence = self.sequence;
        let message = (sequence, text(&LiveMessage { sequence, event }));
        self.recent_bytes += message.1.len();
        self.recent.push_back(message.clone());
        while self.recent_bytes > KEPT_BYTES
            && let Some((_, oldest)) = self.recent.pop_front()
        {
            self.recent_bytes -= oldest.len();
        }
        // Nobody watches.
        let _ = self.sender.send(message);
    }

    /// The trial that runs, or the last one.
    pub fn trial(&self) -> Option<&TrialState> {
        self.trial.as_ref()
    }

    /// The number of the newest message.
    pub fn sequence(&self) -> u64 {
        self.sequence
    }

    /// What comes from now on.
    pub fn subscribe(&self) -> broadcast::Receiver<Message> {
        self.sender.subscribe()
    }

    /// The messages of this stream after that of a number, where all of them are kept.
    pub fn missed(&self, stream: &str, after: u64) -> Option<Vec<Message>> {
        let oldest = self.sequence + 1 - self.recent.len() as u64;
        let is_kept =
            stream == self.stream && after <= self.sequence && after.saturating_add(1) >= oldest;
        let missed = self.recent.iter().filter(|(sequence, _)| *sequence > after);
        is_kept.then(|| missed.cloned().collect())
    }

    pub fn snapshot(&self) -> Message {
        let snapshot = Snapshot {
            stream: self.stream.clone(),
            now: now(),
            control: self.control.clone(),
            trial: self.trial.clone(),
            commission: self.commission.clone(),
            samples: self.samples.kept.clone(),
            estimates: self.estimates.kept.clone(),
            track_m: self.track_m.kept.clone(),
            envelope: self.envelope.clone(),
            health: self.health_now(),
            settings: StreamSettings {
                samples_every_s: SAMPLES_EVERY.as_secs_f64(),
                heartbeat_every_s: HEARTBEAT_EVERY.as_secs_f64(),
            },
        };
        let sequence = self.sequence;
        let event = LiveEvent::Snapshot(Box::new(snapshot));
        (sequence, text(&LiveMessage { sequence, event }))
    }

    pub fn take(&mut self, report: Report) {
        match report {
            Report::Step(moment) => self.step(&moment),
            Report::Started(start) => self.start(*start),
            Report::RunStarted { run, thrust, attempt } => {
                self.flush();
                self.begin_run();
                self.publish(LiveEvent::RunStarted { run, thrust, attempt });
            }
            Report::Interval(intervals) => self.intervals = Some(intervals),
            Report::RunEnded(run) => self.run_ended(&run),
            Report::Ended { outcome, verdict, runs, warnings } => {
                self.flush();
                if let Some(trial) = &mut self.trial {
                    trial.running = false;
                    trial.outcome.clone_from(&outcome);
                    trial.verdict.clone_from(&verdict);
                    if !runs.is_empty() {
                        trial.runs.clone_from(&runs);
                    }
                    trial.warnings.clone_from(&warnings);
                }
                self.publish(LiveEvent::TrialEnded { outcome, verdict, runs, warnings });
            }
            Report::Commission(commission) => {
                self.commission = Some((*commission).clone());
                self.publish(LiveEvent::Commission { commission });
            }
            Report::Control(control) => {
                self.control = control.clone();
                self.publish(LiveEvent::Control { control });
            }
        }
    }

    fn run_ended(&mut self, run: &seatrial::Run) {
        self.flush();
        let summary = run_summary(run, None, None);
        let validation = validation_of(run);
        if let Some(trial) = &mut self.trial {
            trial.runs.push(summary.clone());
            trial.validation.clone_from(&validation);
        }
        self.publish(LiveEvent::RunEnded { run: Box::new(summary), validation });
    }

    fn start(&mut self, Start { trial, plan, shown }: Start) {
        self.flush();
        let limits = plan.envelope;
        self.envelope = Some(Envelope {
            area_m: limits.area.to_vec(),
            depth_min_m: limits.depth_min_m,
            depth_max_m: limits.depth_max_m,
            heading_excursion_max_rad: limits.heading_excursion_max_rad,
            yaw_rate_max_rad_s: limits.yaw_rate_max_rad_s,
            rudder_limit_rad: plan.rudder_limit_rad,
        });
        self.threshold = plan.estimator_settings().convergence.threshold;
        self.track_m = Decimator::default();
        self.health = Health { expected_interval_s: plan.sample_interval_s, ..Health::default() };
        self.last = None;
        self.first = None;
        self.intervals_s.clear();
        self.begin_run();
        self.trial = Some(trial.clone());
        self.publish(LiveEvent::TrialStarted { trial: Box::new(trial) });
        // The waiting trial goes on; it sees the picture once this has let go of it.
        let _ = shown.send(());
    }

    fn begin_run(&mut self) {
        self.samples = Decimator::default();
        self.estimates = Decimator::default();
        self.intervals = None;
        self.simulation = None;
    }

    fn step(&mut self, moment: &Moment) {
        let Moment { sample, status, .. } = moment;
        self.clock(sample);
        let stage = status.stage.map(Stage::from);
        let stage_before = self.trial.as_ref().and_then(|t| t.progress.as_ref()?.stage);
        if stage != stage_before {
            self.flush();
            self.enter(stage, moment);
        }
        let simulated = self.simulation.as_mut().map(|simulation| simulation.advance(sample));
        let drawn = self.drawn(sample, stage, simulated);
        self.unsent.push(drawn);
        self.samples.push(drawn);
        if let (Some(north), Some(east)) = (drawn.north_m, drawn.east_m) {
            self.track_m.push([north, east]);
        }
        let estimate = moment.estimate.map(|model| {
            let theta = model.theta();
            let figure = |i: usize| Figure {
                value: theta[i],
                interval_95: self.intervals.map(|intervals| intervals[i]),
            };
            EstimateNow {
                time_s: sample.time_s,
                a22_per_s: figure(0),
                b2_per_s2: figure(1),
                c0_rad_per_s2: figure(2),
                step_norm: status.step_norm,
                threshold: self.threshold,
                converged_s: moment.converged_s,
            }
        });
        if let Some(estimate) = &estimate {
            self.estimates.push(estimate.clone());
        }
        if let Some(trial) = &mut self.trial {
            trial.progress = Some(progress(status));
            trial.estimate =
                estimate.or(trial.estimate.take().filter(|_| stage != Some(Stage::Settle)));
            trial.envelope = envelope_use(status);
        }
        self.last = Some((*sample, Instant::now()));
    }

    fn enter(&mut self, stage: Option<Stage>, moment: &Moment) {
        let Moment { sample, status, .. } = moment;
        self.simulation = (stage == Some(Stage::Validate)).then(|| Simulation {
            model: status.model,
            state: YawState {
                heading_rad: sample.heading_rad,
                yaw_rate_rad_s: sample.yaw_rate_rad_s.unwrap_or(0.0),
            },
            last: *sample,
        });
        if let Some(stage) = stage {
            self.publish(LiveEvent::StageStarted {
                run: status.run,
                stage,
                time_s: sample.time_s,
                at_most_s: status.elapsed_s + status.remaining_s,
            });
        }
    }

    fn drawn(
        &self,
        sample: &Sample<f64>,
        stage: Option<Stage>,
        simulated: Option<f64>,
    ) -> LiveSample {
        let finite = |value: f64| Some(value).filter(|value| value.is_finite());
        let turned = self.last.as_ref().and_then(|(last, _)| {
            finite(
                (sample.heading_rad - last.heading_rad).wrapped() / (sample.time_s - last.time_s),
            )
        });
        LiveSample {
            time_s: sample.time_s,
            stage,
            heading_rad: finite(sample.heading_rad),
            rudder_rad: finite(sample.rudder_rad),
            yaw_rate_rad_s: sample.yaw_rate_rad_s.and_then(finite).or(turned),
            surge_speed_m_s: sample.surge_speed_m_s.and_then(finite),
            depth_m: sample.depth_m.and_then(finite),
            north_m: sample.north_m.and_then(finite),
            east_m: sample.east_m.and_then(finite),
            simulated_heading_rad: simulated.and_then(finite),
        }
    }

    /// The link as of a sample.
    fn clock(&mut self, sample: &Sample<f64>) {
        let now = Instant::now();
        if let Some((last, _)) = self.last {
            let interval_s = sample.time_s - last.time_s;
            if interval_s.is_finite() {
                self.intervals_s.push_back(interval_s);
                if self.intervals_s.len() > INTERVALS {
                    self.intervals_s.pop_front();
                }
                let longest =
                    self.health.longest_interval_s.map_or(interval_s, |l| l.max(interval_s));
                self.health.longest_interval_s = Some(longest);
            }
        }
        let (first_s, first) = *self.first.get_or_insert((sample.time_s, now));
        let wall_s = now.duration_since(first).as_secs_f64();
        if wall_s >= 1.0 {
            self.health.clock_rate =
                Some((sample.time_s - first_s) / wall_s).filter(|r| r.is_finite());
        }
        self.health.samples += 1;
    }

    pub fn health_now(&self) -> Option<Health> {
        self.trial.as_ref()?;
        let count = self.intervals_s.len() as f64;
        Some(Health {
            interval_s: (count > 0.0).then(|| self.intervals_s.iter().sum::<f64>() / count),
            silent_for_s: self.last.map(|(_, at)| at.elapsed().as_secs_f64()),
            ..self.health.clone()
        })
    }

    /// Steps that were not shown.
    pub fn not_shown(&mut self, steps: u64) {
        self.health.not_shown = steps;
    }

    /// Tells of the link.
    pub fn publish_health(&mut self) {
        let runs = self.trial.as_ref().is_some_and(|trial| trial.running);
        if let Some(health) = self.health_now().filter(|_| runs) {
            self.publish(LiveEvent::Health { health });
        }
    }

    pub fn flush(&mut self) {
        let samples = std::mem::take(&mut self.unsent);
        let state = self.trial.as_ref().filter(|_| !samples.is_empty());
        let Some((trial, progress)) = state.and_then(|t| Some((t, t.progress.clone()?))) else {
            return;
        };
        let event = LiveEvent::Samples {
            samples,
            progress,
            estimate: trial.estimate.clone(),
            envelope: trial.envelope.clone(),
        };
        self.publish(event);
    }
}

impl Simulation {
    /// The simulated heading at a sample, rad.
    fn advance(&mut self, sample: &Sample<f64>) -> f64 {
        let interval_s = sample.time_s - self.last.time_s;
        if interval_s > 0.0 && self.last.rudder_rad.is_finite() {
            self.state = self.model.advance(self.state, self.last.rudder_rad, interval_s);
        }
        self.last = *sample;
        self.state.heading_rad
    }
}

fn progress(status: &Status<f64>) -> Progress {
    Progress {
        run: status.run,
        speed: status.speed as u32,
        speeds: status.speeds as u32,
        thrust: status.thrust,
        attempt: status.attempt,
        stage: status.stage.map(Stage::from),
        elapsed_s: status.elapsed_s,
        remaining_s: status.remaining_s,
    }
}

fn envelope_use(status: &Status<f64>) -> Vec<EnvelopeUse> {
    status
        .envelope
        .limits()
        .into_iter()
        .filter_map(|(limit, used)| Some(EnvelopeUse { limit: name_of(limit), used: used? }))
        .collect()
}
