//! A drift watch over mission logs: since when is a re-trial due?

use std::collections::BTreeMap;

use seatrial_core::Sample;
use seatrial_core::refine::Disturbance;
use serde::Serialize;

use super::cause::{self, Explanation};
use super::change::mean_delta0_rad;
use super::estimate::{accepted_estimate, missions, steady_speed_m_s};
use super::not_compared::NotCompared;
use super::pool::{Deviation, PooledChange, ReferenceError};
use super::{
    Detectable, Effects, Finding, HealthError, HealthSettings, Reference, SpeedModel,
    degrees_of_freedom,
};
use crate::identification::Refined;
use crate::identify::misfit::{disturbance_share, is_large_share};
use crate::identify::whole_record::robust_estimate_behind;
use crate::manoeuvre::Manoeuvre;
use crate::record::{Record, Window, median};
use crate::record_series::RecordSeries;

/// A window lasts so many time constants of the vehicle, about as long as a trial's training stage.
const WINDOW_TIME_CONSTANTS: f64 = 16.0;

/// Windows start on a grid of so many to a window's length.
const STARTS_PER_WINDOW: usize = 4;

/// A window with fewer samples shows nothing.
const LEAST_SAMPLES: usize = 30;

/// Half the 95 % interval of b2 from one window, over what is expected: a wider one is not excited.
const WIDEST_RUDDER_INTERVAL: f64 = 0.5;

/// Half the 95 % interval that a window has to promise: white noise, which it assumes, promises too much by a factor
/// of some five.
const WIDEST_PROMISE: f64 = 0.1;

/// A longer gap than this share of a window breaks it.
const LARGEST_GAP: f64 = 0.1;

/// Reads mission logs in the order of time and tests whether the vehicle is still that of the reference.
///
/// ```text
/// at window n, over the last m = 1, 2, 4, ... windows:   p(n, m) of one common change
/// alarm at n:   p(n, m) < rate / (number of all tests)   for some m
/// onset k:      the largest likelihood ratio of a change from window k to the last alarm
/// ```
///
/// A generalised likelihood ratio test on windows in which the rudder excites the vehicle: a short span finds a large
/// change at once, a long one a small change in time. Dividing the rate by the number of tests (Bonferroni) bounds
/// the probability of any false alarm in all that was read, whatever the correlation of the tests through the
/// reference they share. A mission of ordinary steering is one window, identified as a whole; others are cut into windows of a manoeuvre's length.
/// Each is identified by itself, so wind, current and the heading noise of the day
/// are estimated with it. Where the reference is behind a lag of the rudder, so are the windows: what is not known of the lag is the
/// reference's error, and no change.
#[derive(Clone, Debug)]
pub struct Watch {
    reference: Reference,
    settings: HealthSettings,
    windows: Vec<(WatchedWindow, Deviation)>,
    skipped: BTreeMap<String, f64>,
    read_s: f64,
}

/// A window that excited the vehicle.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WatchedWindow {
    /// The log, as named to [`Watch::read`].
    pub log: String,
    /// When, in the log's own seconds.
    pub window: Window,
    /// Mean forward speed, m/s.
    pub surge_speed_m_s: Option<f64>,
    /// How this window alone differs from the reference.
    pub effects: Effects,
    /// The least p of the spans that end here. `None` before [`Watch::report`].
    pub p_value: Option<f64>,
    /// Is it under the level?
    pub alarm: bool,
}

/// Time that could not be watched.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SkippedTime {
    /// Why the mission gives no answer.
    pub because: String,
    /// How long altogether, s.
    pub duration_s: f64,
}

/// What the logs say.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WatchReport {
    /// How it was tested.
    pub settings: HealthSettings,
    /// What was found.
    pub finding: Finding,
    /// Time read, s.
    pub read_s: f64,
    /// Every window that excited the vehicle, in order.
    pub windows: Vec<WatchedWindow>,
    /// The p under which a span raises the alarm.
    pub level: Option<f64>,
    /// Time that could not be watched, and why, longest first.
    pub skipped: Vec<SkippedTime>,
    /// The first window after the change, counted from 0.
    pub since: Option<usize>,
    /// What has changed by how much: since the change, or over all where there is none.
    pub effects: Option<Effects>,
    /// The one cause that explains the change within the noise.
    pub explanation: Option<Explanation>,
    /// What would have been found.
    pub detectable: Option<Detectable>,
    /// Why, in words.
    pub because: String,
}

impl Watch {
    /// A watch that has read nothing.
    pub fn new(reference: Reference, settings: HealthSettings) -> Result<Self, HealthError> {
        if reference.points().iter().any(|point| point.model.a22_per_s >= 0.0) {
            return Err(HealthError::Reference(
                "a model with a22 at or above 0 has no time constant to choose windows by".into(),
            ));
        }
        Ok(Self { reference, settings, windows: Vec::new(), skipped: BTreeMap::new(), read_s: 0.0 })
    }

    /// Reads the next log: every window that excites the vehicle is kept, the rest counted.
    pub fn read(&mut self, name: &str, record: &Record) {
        let usable = Record {
            samples: record.usable(Window::ALL),
            rudder_unit: record.rudder_unit,
            units: record.units,
        };
        let record = match self.reference.servo() {
            Some(servo) => servo.behind(&usable),
            None => usable,
        };
        let (Some(first), Some(last)) = (record.samples.first(), record.samples.last()) else {
            return;
        };
        self.read_s += last.time_s - first.time_s;
        let length_s = WINDOW_TIME_CONSTANTS * self.time_constant_s();
        let missions = missions(&record, length_s);
        for (window, speed, refined) in &missions {
            match self.compare(name, *window, *speed, refined) {
                Ok(kept) => self.windows.push(kept),
                Err(why) => self.skip(why, window.to_s - window.from_s),
            }
        }
        if !missions.is_empty() {
            return;
        }
        let step_s = length_s / STARTS_PER_WINDOW as f64;
        let mut window = Window { from_s: first.time_s, to_s: first.time_s + length_s };
        while window.from_s < last.time_s {
            let looked = match self.promise(&record, window) {
                Ok(_) => {
                    let best = self.best_start(&record, window, step_s);
                    self.skip(NotCompared::NotExcited, best.from_s - window.from_s);
                    window = best;
                    self.look(name, &record, window)
                }
                Err(why) => Err(why),
            };
            let next_s = match looked {
                Ok(kept) => {
                    self.windows.push(kept);
                    window.to_s
                }
                Err(why) => {
                    let next_s = next_sample_s(&record, window.from_s + step_s);
                    self.skip(why, next_s.unwrap_or(last.time_s) - window.from_s);
                    next_s.unwrap_or(f64::INFINITY)
                }
            };
            window = Window { from_s: next_s, to_s: next_s + length_s };
        }
    }

    fn skip(&mut self, because: NotCompared, duration_s: f64) {
        if duration_s > 0.0 {
            *self.skipped.entry(because.to_string()).or_default() += duration_s;
        }
    }

    /// The median of the reference, s.
    fn time_constant_s(&self) -> f64 {
        let points = self.reference.points().iter();
        let all = points.map(|point| -1.0 / point.model.a22_per_s);
        median(all.collect()).unwrap_or(f64::INFINITY)
    }

    /// The start within a window that promises most, so that a manoeuvre is not cut in two.
    fn best_start(&self, record: &Record, window: Window, step_s: f64) -> Window {
        (0..STARTS_PER_WINDOW)
            .map(|k| Window {
                from_s: window.from_s + k as f64 * step_s,
                to_s: window.to_s + k as f64 * step_s,
            })
            .filter_map(|later| Some((self.promise(record, later).ok()?, later)))
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map_or(window, |(_, best)| best)
    }

    /// Half the 95 % interval of b2 that a window promises, over what is expected, were all that the reference leaves
    /// of it white noise.
    fn promise(&self, record: &Record, window: Window) -> Result<f64, NotCompared> {
        let samples = record.window(window);
        if samples.len() < LEAST_SAMPLES {
            return Err(NotCompared::TooFewSamples);
        }
        if let Some(gap) = largest_gap_s(samples)
            && gap > LARGEST_GAP * (window.to_s - window.from_s)
        {
            return Err(NotCompared::SamplesMissing);
        }
        let moves = samples.iter().any(|s| s.rudder_rad != samples[0].rudder_rad);
        if !moves {
            return Err(NotCompared::NotExcited);
        }
        let expected = self.reference.at_speed(steady_speed_m_s(samples)?)?;
        let fit = RecordSeries::new(samples, 1)
            .fit(expected.model.a22_per_s, Disturbance::NONE)
            .ok_or(NotCompared::NotExcited)?;
        let deviation = (fit.noise_variance_rad2 * fit.scaled_covariance[0][0]).sqrt();
        let promise = 2.0 * deviation / expected.model.b2_per_s2.abs();
        if promise < WIDEST_PROMISE { Ok(promise) } else { Err(NotCompared::NotExcited) }
    }

    /// Estimates one window and compares it with the reference.
    fn look(
        &self,
        name: &str,
        record: &Record,
        window: Window,
    ) -> Result<(WatchedWindow, Deviation), NotCompared> {
        let samples = record.window(window);
        let speed = steady_speed_m_s(samples)?;
        let expected = self.reference.at_speed(speed)?;
        let refined = robust_estimate_behind(samples, Some(0.0))
            .map_err(|_| NotCompared::NotExcited)?
            .refined;
        let rudder_amplitude_rad =
            Manoeuvre::find(samples).ok_or(NotCompared::NotExcited)?.amplitude_rad;
        // A share of what the rudder does if the vehicle is sound: one that is lost must not hide itself.
        let as_expected = Refined { model: expected.model, ..refined.clone() };
        let refined = if is_large_share(disturbance_share(&as_expected, rudder_amplitude_rad)) {
            accepted_estimate(record, window, &refined)?
        } else {
            refined
        };
        self.compare(name, window, speed, &refined)
    }

    /// Compares the estimate of a window with the reference.
    fn compare(
        &self,
        name: &str,
        window: Window,
        speed: Option<f64>,
        refined: &Refined,
    ) -> Result<(WatchedWindow, Deviation), NotCompared> {
        let expected = self.reference.at_speed(speed)?;
        let now = SpeedModel {
            thrust: None,
            surge_speed_m_s: speed,
            model: refined.model,
            covariance: refined.covariance,
            degrees_of_freedom: degrees_of_freedom(&expected.model, window.to_s - window.from_s),
            rudder_lag_s: 0.0,
        };
        let deviation = Deviation::between(&expected, &now).ok_or(NotCompared::NotFinite)?;
        if deviation.rudder_half_width() > WIDEST_RUDDER_INTERVAL {
            return Err(NotCompared::NotExcited);
        }
        let errors = self.reference.errors();
        let alone = std::slice::from_ref(&deviation);
        let effects = PooledChange::of(alone, &errors, self.settings.parameters())
            .ok_or(NotCompared::NotFinite)?
            .effects(alone, &errors);
        let watched = WatchedWindow {
            log: name.into(),
            window,
            surge_speed_m_s: speed,
            effects,
            p_value: None,
            alarm: false,
        };
        Ok((watched, deviation))
    }

    /// What all that was read says.
    pub fn report(&self) -> WatchReport {
        let settings = self.settings;
        let errors = self.reference.errors();
        let (unmarked, deviations): (Vec<WatchedWindow>, Vec<Deviation>) =
            self.windows.iter().cloned().unzip();
        let tests: usize = (1..=unmarked.len()).map(|n| spans(n).count()).sum();
        let level = settings.false_alarm_rate / tests.max(1) as f64;
        let pool = |of: &[Deviation]| PooledChange::of(of, &errors, settings.parameters());
        let windows = marked(unmarked, level, |n, span| {
            let pooled = pool(&deviations[n + 1 - span..=n])?;
            Some(pooled.p_value(&settings))
        });
        let alarms = || windows.iter().enumerate().filter(|(_, w)| w.alarm);
        let span = alarms().map(|(n, _)| n).next().zip(alarms().map(|(n, _)| n).next_back());
        let since =
            span.and_then(|(first, last)| onset(&deviations, &errors, &settings, first, last));
        let reported =
            &deviations[since.unwrap_or(0)..span.map_or(windows.len(), |(_, last)| last + 1)];
        let pooled = (!reported.is_empty()).then(|| pool(reported)).flatten();
        let effects = pooled.as_ref().map(|pooled| pooled.effects(reported, &errors));
        let detectable = pooled.as_ref().and_then(|pooled| pooled.detectable(level, &settings));
        let speed_is_known = windows.iter().all(|w| w.surge_speed_m_s.is_some());
        let explanation = pooled
            .as_ref()
            .filter(|_| since.is_some())
            .and_then(|p| Explanation::of(p, mean_delta0_rad(&self.reference), speed_is_known));
        let changed = since.map(|first| &windows[first]).zip(effects.as_ref());
        let (finding, because) = answer(changed, explanation.as_ref(), detectable.as_ref());
        WatchReport {
            settings,
            finding,
            read_s: self.read_s,
            windows,
            level: (tests > 0).then_some(level),
            skipped: self.skipped_longest_first(),
            since,
            effects,
            explanation,
            detectable,
            because,
        }
    }

    fn skipped_longest_first(&self) -> Vec<SkippedTime> {
        let mut skipped: Vec<SkippedTime> = self
            .skipped
            .iter()
            .map(|(because, duration_s)| SkippedTime {
                because: because.clone(),
                duration_s: *duration_s,
            })
            .collect();
        skipped.sort_by(|a, b| b.duration_s.total_cmp(&a.duration_s));
        skipped
    }
}

/// The windows with the least p of the spans that end in each, and the alarm where it is under the level.
fn marked(
    windows: Vec<WatchedWindow>,
    level: f64,
    p_value: impl Fn(usize, usize) -> Option<f64>,
) -> Vec<WatchedWindow> {
    let mark = |(n, window): (usize, WatchedWindow)| {
        let least = spans(n + 1).filter_map(|span| p_value(n, span)).fold(1.0, f64::min);
        WatchedWindow { p_value: Some(least), alarm: least < level, ..window }
    };
    windows.into_iter().enumerate().map(mark).collect()
}

/// What was found, in words. `changed`: the first window after a change, and how large it is.
fn answer(
    changed: Option<(&WatchedWindow, &Effects)>,
    explanation: Option<&Explanation>,
    detectable: Option<&Detectable>,
) -> (Finding, String) {
    match (changed, detectable) {
        (Some((first, effects)), _) => (
            Finding::Changed,
            format!(
                "a re-trial is due since {}, {:.0} s: {}",
                first.log,
                first.window.from_s,
                cause::words(explanation, effects)
            ),
        ),
        (None, Some(detectable)) if detectable.is_enough() => (
            Finding::Unchanged,
            format!(
                "no change found; nine times in ten this watch finds a change of {} that lasts through these windows",
                detectable.words()
            ),
        ),
        (None, Some(detectable)) => (
            Finding::CannotTell,
            format!(
                "reference and windows together show only a change of {}: use more rudder in the next mission or trial",
                detectable.words()
            ),
        ),
        (None, None) => (
            Finding::CannotTell,
            "in no window does the rudder excite the vehicle enough; steer a zig-zag of a few rudder strokes in the next mission".into(),
        ),
    }
}

/// 1, 2, 4, ... up to n.
fn spans(n: usize) -> impl Iterator<Item = usize> {
    std::iter::successors(Some(1), |span| Some(2 * span)).take_while(move |span| *span <= n)
}

/// The most likely first window of a change that was found from `first` to `last`.
fn onset(
    deviations: &[Deviation],
    errors: &[ReferenceError],
    settings: &HealthSettings,
    first: usize,
    last: usize,
) -> Option<usize> {
    (0..=first)
        .filter_map(|from| {
            let pooled = PooledChange::of(&deviations[from..=last], errors, settings.parameters())?;
            let information = pooled.information()?;
            let ratio = (pooled.change.transpose() * information * &pooled.change)[(0, 0)];
            Some((from, ratio))
        })
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(from, _)| from)
}

/// The time of the first sample at or after an instant.
fn next_sample_s(record: &Record, from_s: f64) -> Option<f64> {
    let next = record.samples.partition_point(|s| s.time_s < from_s);
    Some(record.samples.get(next)?.time_s)
}

fn largest_gap_s(samples: &[Sample<f64>]) -> Option<f64> {
    samples.windows(2).map(|pair| pair[1].time_s - pair[0].time_s).reduce(f64::max)
}
