//! The envelope: limits within which a trial may go on.

use crate::setting::{InvalidSetting, is_positive, require};
use crate::{AbortReason, List, Real, Sample};

/// Most corners of the area.
pub const AREA_CORNERS: usize = 16;

/// Time constant of the smoothing of the speed that is watched for drift, s.
const SPEED_SMOOTHING_S: f64 = 1.0;

/// A heading that stays the same number while the gyro turns by this, rad, in about [`TURN_S`] is frozen: further than a
/// step of any compass of use, and faster than a gyro's bias.
const FROZEN_TURN_RAD: f64 = 0.1;
const TURN_S: f64 = 2.0;

/// Without a sound heading for this long, s, or for one and a half samples the rudder is neutral.
const BLIND_AFTER_S: f64 = 0.5;
const BLIND_AFTER_SAMPLES: f64 = 1.5;

/// Which way the vehicle is expected to turn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum RudderSense {
    /// b2 is positive: positive rudder increases the heading.
    #[default]
    Positive,
    /// b2 is negative: positive rudder decreases the heading.
    Negative,
    /// Not known: the trial finds it out, nothing is checked.
    Unknown,
}

/// Limits within which a trial may go on.
///
/// What a vehicle does not measure is not checked; what it once measured must not fall silent for
/// longer than `stale_after_s`, except the altitude: the bottom may be out of reach. A heading that stays the same number
/// for so long while the gyro turns is silent too. A limit is switched off by a number that no vehicle reaches.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(default, deny_unknown_fields, bound(deserialize = "T: Real + serde::Deserialize<'de>"))
)]
pub struct Envelope<T> {
    /// Shallowest depth, m.
    pub depth_min_m: T,
    /// Greatest depth, m.
    pub depth_max_m: T,
    /// Greatest change of depth since the start of the stage, m; `None`: any.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub depth_change_max_m: Option<T>,
    /// Least height above the bottom, m.
    pub altitude_min_m: T,
    /// Greatest roll to either side, rad.
    pub roll_max_rad: T,
    /// Greatest pitch up or down, rad.
    pub pitch_max_rad: T,
    /// Fastest turn either way, rad/s.
    pub yaw_rate_max_rad_s: T,
    /// Farthest heading from the heading of the run, rad, below pi.
    pub heading_excursion_max_rad: T,
    /// Greatest change of speed during a manoeuvre, as a fraction of the speed before it.
    pub speed_drift_max: T,
    /// Corners [north, east] of the area in which the vehicle must stay, m; none: anywhere.
    pub area: List<[T; 2], AREA_CORNERS>,
    /// Longest silence, s.
    pub stale_after_s: f64,
    /// Longest stage, s.
    pub stage_time_limit_s: f64,
    /// Which way the vehicle is expected to turn.
    pub rudder_sense: RudderSense,
}

impl<T: Real> Default for Envelope<T> {
    fn default() -> Self {
        Self {
            depth_min_m: T::of(-1.0),
            depth_max_m: T::of(10.0),
            depth_change_max_m: None,
            altitude_min_m: T::ONE,
            roll_max_rad: T::of(0.8),
            pitch_max_rad: T::of(0.6),
            yaw_rate_max_rad_s: T::ONE,
            heading_excursion_max_rad: T::of(1.6),
            speed_drift_max: T::of(0.3),
            area: List::default(),
            stale_after_s: 2.0,
            stage_time_limit_s: 60.0,
            rudder_sense: RudderSense::default(),
        }
    }
}

impl<T: Real> Envelope<T> {
    /// Names the first limit that is out of its range, as `envelope.roll_max_rad`.
    ///
    /// ```
    /// use seatrial_core::{Envelope, List};
    ///
    /// let line = List::from_slice(&[[0.0, 0.0], [100.0, 0.0]]).unwrap_or_default();
    /// let error = Envelope { area: line, ..Envelope::<f64>::default() }.check();
    /// assert_eq!(error.map_err(|error| error.field), Err("envelope.area"));
    /// ```
    pub fn check(&self) -> Result<(), InvalidSetting> {
        require(
            is_positive(self.depth_max_m - self.depth_min_m),
            "envelope.depth_max_m",
            "above envelope.depth_min_m",
        )?;
        require(
            self.depth_change_max_m.is_none_or(is_positive),
            "envelope.depth_change_max_m",
            "a positive number",
        )?;
        require(
            self.altitude_min_m >= T::ZERO && self.altitude_min_m.is_finite(),
            "envelope.altitude_min_m",
            "a number not below 0",
        )?;
        let positive = [
            (self.roll_max_rad, "envelope.roll_max_rad"),
            (self.pitch_max_rad, "envelope.pitch_max_rad"),
            (self.yaw_rate_max_rad_s, "envelope.yaw_rate_max_rad_s"),
            (self.speed_drift_max, "envelope.speed_drift_max"),
        ];
        for (limit, field) in positive {
            require(is_positive(limit), field, "a positive number")?;
        }
        require(
            is_positive(self.heading_excursion_max_rad) && self.heading_excursion_max_rad < T::PI,
            "envelope.heading_excursion_max_rad",
            "a positive angle below pi rad",
        )?;
        let corners = self.area.len();
        let is_area = corners >= 3 && self.area.iter().flatten().all(|m| m.is_finite());
        require(
            corners == 0 || is_area,
            "envelope.area",
            "empty, or at least 3 corners [north, east] in m",
        )
    }
}

/// How much of each limit is used: 0 is far from it, 1 is at it. `None` where nothing is measured.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct EnvelopeUse<T> {
    /// Depth, from the middle of its range; its change since the start of the stage where that is nearer to its limit.
    pub depth: Option<T>,
    /// Least height above the bottom by height.
    pub altitude: Option<T>,
    /// Roll.
    pub roll: Option<T>,
    /// Pitch.
    pub pitch: Option<T>,
    /// Yaw rate.
    pub yaw_rate: Option<T>,
    /// Heading from the heading of the run.
    pub heading_excursion: Option<T>,
    /// Nearness to the edge of the area; 0 where it is as far as from the mean of the corners.
    pub area: Option<T>,
    /// Change of speed.
    pub speed_drift: Option<T>,
    /// Silence.
    pub silence: Option<T>,
    /// Time in the stage.
    pub stage_time: Option<T>,
}

impl<T: Real> EnvelopeUse<T> {
    /// Each limit by the reason for which its excess aborts a trial, most pressing first.
    ///
    /// ```
    /// use seatrial_core::{AbortReason, EnvelopeUse};
    ///
    /// let [(most_pressing, used), ..] =
    ///     EnvelopeUse { altitude: Some(0.5), ..EnvelopeUse::default() }.limits();
    /// assert_eq!((most_pressing, used), (AbortReason::Altitude, Some(0.5)));
    /// ```
    pub fn limits(&self) -> [(AbortReason, Option<T>); 10] {
        [
            (AbortReason::Altitude, self.altitude),
            (AbortReason::Depth, self.depth),
            (AbortReason::Pitch, self.pitch),
            (AbortReason::Roll, self.roll),
            (AbortReason::Area, self.area),
            (AbortReason::YawRate, self.yaw_rate),
            (AbortReason::HeadingExcursion, self.heading_excursion),
            (AbortReason::SpeedDrift, self.speed_drift),
            (AbortReason::StaleSamples, self.silence),
            (AbortReason::StageTimeLimit, self.stage_time),
        ]
    }

    /// The first limit that is exceeded.
    ///
    /// ```
    /// use seatrial_core::{AbortReason, EnvelopeUse};
    ///
    /// let usage = EnvelopeUse {
    ///     depth: Some(1.2),
    ///     roll: Some(1.5),
    ///     yaw_rate: Some(0.9),
    ///     ..EnvelopeUse::default()
    /// };
    /// assert_eq!(usage.exceeded(), Some(AbortReason::Depth));
    /// assert_eq!(EnvelopeUse::<f64>::default().exceeded(), None);
    /// ```
    pub fn exceeded(&self) -> Option<AbortReason> {
        self.limits()
            .into_iter()
            .find(|(_, used)| used.is_some_and(|used| used > T::ONE))
            .map(|(reason, _)| reason)
    }
}

/// Watches the samples of a trial.
#[derive(Clone, Copy, Debug)]
pub struct EnvelopeWatch<T> {
    limits: Envelope<T>,
    usage: EnvelopeUse<T>,
    /// When each measurement that must not fall silent was last a number.
    seen_s: [Option<f64>; 5],
    speed: Option<SpeedWatch<T>>,
    heading: Option<StillHeading<T>>,
    /// Depth at the start of the stage, m.
    stage_depth_m: Option<T>,
}

/// A heading that stays the same number: since when, and how far the gyro has turned since, lately.
#[derive(Clone, Copy, Debug)]
struct StillHeading<T> {
    heading_rad: T,
    since_s: f64,
    time_s: f64,
    turned_rad: T,
}

/// The speed before a manoeuvre and the smoothed speed now, m/s.
#[derive(Clone, Copy, Debug)]
struct SpeedWatch<T> {
    time_s: f64,
    samples: u32,
    before_m_s: T,
    now_m_s: T,
}

impl<T: Real> EnvelopeWatch<T> {
    /// A watch that has seen nothing.
    pub fn new(limits: Envelope<T>) -> Self {
        Self {
            limits,
            usage: EnvelopeUse::default(),
            seen_s: [None; 5],
            speed: None,
            heading: None,
            stage_depth_m: None,
        }
    }

    /// How much of each limit is used.
    pub fn usage(&self) -> &EnvelopeUse<T> {
        &self.usage
    }

    /// Forgets speed and depth of the stage before.
    pub fn stage_started(&mut self) {
        self.stage_depth_m = None;
        self.speed = None;
        self.usage.speed_drift = None;
    }

    /// Looks at what a sample measures. `time_s` goes on, by the sample interval, where the sample's own time is not sound.
    ///
    /// ```
    /// use seatrial_core::envelope::EnvelopeWatch;
    /// use seatrial_core::{AbortReason, Envelope, Sample};
    ///
    /// let mut watch = EnvelopeWatch::new(Envelope { roll_max_rad: 0.5, ..Envelope::default() });
    /// let sample = Sample { roll_rad: Some(-0.25), ..Sample::default() };
    /// watch.look(&sample, sample.time_s);
    /// // Half of the limit, to port as to starboard.
    /// assert_eq!(watch.usage().roll, Some(0.5));
    /// watch.look(&Sample { roll_rad: Some(0.6), ..sample }, 0.1);
    /// assert_eq!(watch.usage().exceeded(), Some(AbortReason::Roll));
    /// ```
    pub fn look(&mut self, sample: &Sample<T>, time_s: f64) {
        let limits = &self.limits;
        let half_range = (limits.depth_max_m - limits.depth_min_m) / T::of(2.0);
        let middle = limits.depth_min_m + half_range;
        let position = match (number(sample.north_m), number(sample.east_m)) {
            (Some(north), Some(east)) => Some([north, east]),
            _ => None,
        };
        let usage = &mut self.usage;
        usage.depth = number(sample.depth_m).map(|depth| {
            let start_m = *self.stage_depth_m.get_or_insert(depth);
            let change = limits
                .depth_change_max_m
                .map_or(T::ZERO, |limit_m| (depth - start_m).abs() / limit_m);
            change.max((depth - middle).abs() / half_range)
        });
        usage.altitude = number(sample.altitude_m)
            .map(|altitude| limits.altitude_min_m / altitude.max(T::EPSILON));
        usage.roll = number(sample.roll_rad).map(|roll| roll.abs() / limits.roll_max_rad);
        usage.pitch = number(sample.pitch_rad).map(|pitch| pitch.abs() / limits.pitch_max_rad);
        usage.yaw_rate =
            number(sample.yaw_rate_rad_s).map(|rate| rate.abs() / limits.yaw_rate_max_rad_s);
        usage.area = position.and_then(|position| area_used(&limits.area, position));
        let measured = [usage.depth, usage.roll, usage.pitch, usage.yaw_rate, usage.area];
        for (seen_s, measured) in self.seen_s.iter_mut().zip(measured) {
            if measured.is_some() {
                *seen_s = Some(time_s);
            }
        }
        self.look_at_heading(sample, time_s);
    }

    fn look_at_heading(&mut self, sample: &Sample<T>, time_s: f64) {
        match &mut self.heading {
            Some(still) if still.heading_rad == sample.heading_rad => {
                let interval_s = time_s - still.time_s;
                let rate_rad_s = number(sample.yaw_rate_rad_s).unwrap_or(T::ZERO);
                still.turned_rad = still.turned_rad * T::of(-interval_s / TURN_S).exp()
                    + rate_rad_s * T::of(interval_s);
                still.time_s = time_s;
            }
            heading => {
                *heading = Some(StillHeading {
                    heading_rad: sample.heading_rad,
                    since_s: time_s,
                    time_s,
                    turned_rad: T::ZERO,
                });
            }
        }
    }

    /// The silence of the trial's own samples, s, and with it that of whatever was once measured.
    pub fn listen(&mut self, silence_s: f64, time_s: f64) {
        let frozen_since_s = self.frozen_since_s();
        let seen_s = self.seen_s.iter().flatten().chain(&frozen_since_s);
        let longest_s = seen_s.fold(silence_s, |longest, seen_s| longest.max(time_s - seen_s));
        self.usage.silence = Some(T::of(longest_s / self.limits.stale_after_s));
    }

    /// Has no sound heading come for too long to leave the rudder over? The samples are silent, or the heading does not follow the
    /// gyro.
    pub fn is_blind(&self, silence_s: f64, time_s: f64, sample_interval_s: f64) -> bool {
        let frozen_s = self.frozen_since_s();
        let blind_s = frozen_s.map_or(silence_s, |since_s| silence_s.max(time_s - since_s));
        blind_s > BLIND_AFTER_S.max(BLIND_AFTER_SAMPLES * sample_interval_s)
    }

    /// Since when the heading has not followed the gyro.
    fn frozen_since_s(&self) -> Option<f64> {
        self.heading
            .filter(|still| still.turned_rad.abs() > T::of(FROZEN_TURN_RAD))
            .map(|still| still.since_s)
    }

    /// Time in the stage, s.
    pub fn clock(&mut self, elapsed_s: f64) {
        self.usage.stage_time = Some(T::of(elapsed_s / self.limits.stage_time_limit_s));
    }

    /// Heading from the heading of the run, rad.
    pub fn heading(&mut self, error_rad: T) {
        self.usage.heading_excursion =
            Some(error_rad.abs() / self.limits.heading_excursion_max_rad);
    }

    /// The forward speed during a training or validation stage: averaged over its lead-in, then
    /// smoothed and held against the average.
    pub fn speed(&mut self, sample: &Sample<T>, is_lead_in: bool) {
        let Some(measured) = number(sample.surge_speed_m_s) else {
            return;
        };
        let speed = self.speed.get_or_insert(SpeedWatch {
            time_s: sample.time_s,
            samples: 0,
            before_m_s: measured,
            now_m_s: measured,
        });
        let interval_s = sample.time_s - speed.time_s;
        speed.time_s = sample.time_s;
        if is_lead_in {
            speed.samples = speed.samples.saturating_add(1);
            speed.before_m_s += (measured - speed.before_m_s) / T::of(f64::from(speed.samples));
            speed.now_m_s = speed.before_m_s;
        } else {
            let weight = -T::of(-interval_s / SPEED_SMOOTHING_S).exp_m1();
            speed.now_m_s += weight * (measured - speed.now_m_s);
            let drift = ((speed.now_m_s - speed.before_m_s) / speed.before_m_s).abs();
            // A vehicle that lay still before has no fraction to drift by.
            self.usage.speed_drift =
                drift.is_finite().then_some(drift / self.limits.speed_drift_max);
        }
    }
}

fn number<T: Real>(value: Option<T>) -> Option<T> {
    value.filter(|value| value.is_finite())
}

/// Above 1 outside the polygon, 1 on its edge; `None` without a polygon.
fn area_used<T: Real>(corners: &[[T; 2]], position: [T; 2]) -> Option<T> {
    let count = T::of(u16::try_from(corners.len()).ok().filter(|n| *n >= 3)?.into());
    let mean = |axis: fn(&[T; 2]) -> T| corners.iter().map(axis).sum::<T>() / count;
    let centre = [mean(|c| c[0]), mean(|c| c[1])];
    let depth = edge_distance(corners, position) / edge_distance(corners, centre);
    let used =
        if is_inside(corners, position) { (T::ONE - depth).max(T::ZERO) } else { T::ONE + depth };
    used.is_finite().then_some(used)
}

/// Pairs of neighbouring corners, the last with the first.
fn edges<T: Copy>(corners: &[[T; 2]]) -> impl Iterator<Item = ([T; 2], [T; 2])> {
    corners.iter().copied().zip(corners.iter().copied().cycle().skip(1))
}

/// Even-odd rule: a line from an inside point northwards crosses the edges an odd number of times.
fn is_inside<T: Real>(corners: &[[T; 2]], [north, east]: [T; 2]) -> bool {
    let is_crossed = |([n1, e1], [n2, e2]): &([T; 2], [T; 2])| {
        (*e1 > east) != (*e2 > east) && north < *n1 + (*n2 - *n1) * (east - *e1) / (*e2 - *e1)
    };
    edges(corners).filter(is_crossed).count() % 2 == 1
}

/// Distance to the nearest edge, m.
fn edge_distance<T: Real>(corners: &[[T; 2]], [north, east]: [T; 2]) -> T {
    edges(corners)
        .map(|([n1, e1], [n2, e2])| {
            let (along_n, along_e) = (n2 - n1, e2 - e1);
            let length2 = along_n * along_n + along_e * along_e;
            let share = ((north - n1) * along_n + (east - e1) * along_e) / length2.max(T::EPSILON);
            let share = share.max(T::ZERO).min(T::ONE);
            let (off_n, off_e) = (north - n1 - share * along_n, east - e1 - share * along_e);
            (off_n * off_n + off_e * off_e).sqrt()
        })
        .fold(T::MAX, Real::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_area_of_an_l() {
        // An L open to the north-east.
        let l: [[f64; 2]; 6] =
            [[0.0, 0.0], [100.0, 0.0], [100.0, 40.0], [40.0, 40.0], [40.0, 100.0], [0.0, 100.0]];
        for (position, inside) in [
            ([20.0, 20.0], true),
            ([90.0, 20.0], true),
            ([20.0, 90.0], true),
            ([70.0, 70.0], false),
            ([-1.0, 50.0], false),
            ([50.0, -1.0], false),
            ([120.0, 20.0], false),
        ] {
            assert_eq!(is_inside(&l, position), inside, "{position:?}");
            let used = area_used(&l, position).unwrap();
            assert_eq!(used < 1.0, inside, "{position:?}: {used}");
        }
        assert_eq!(edge_distance(&l, [70.0, 70.0]), 30.0);
        assert!((area_used(&l, [0.001, 20.0]).unwrap() - 1.0).abs() < 1e-3);
    }

    #[test]
    fn exact_no_area_is_anywhere() {
        assert_eq!(area_used::<f64>(&[], [1e9, 1e9]), None);
    }

    /// 20 Hz: heading and yaw rate as functions of time; when silence was found, s.
    fn silent_at_s(heading: fn(f64) -> f64, rate: fn(f64) -> f64) -> Option<f64> {
        let mut watch = EnvelopeWatch::new(Envelope::<f64>::default());
        (0..400).map(|k| f64::from(k) * 0.05).find(|&time_s| {
            let sample = Sample {
                heading_rad: heading(time_s),
                yaw_rate_rad_s: Some(rate(time_s)),
                ..Sample::default()
            };
            watch.look(&sample, time_s);
            watch.listen(0.0, time_s);
            watch.usage().exceeded() == Some(AbortReason::StaleSamples)
        })
    }

    #[test]
    fn exact_a_frozen_heading_is_silence() {
        // Still for 10 s, then the vehicle turns: 0.1 rad at 0.2 rad/s, leaking over 2 s, after 0.58 s.
        let turning = |t: f64| if t > 10.0 { 0.2 } else { 0.0 };
        let found_s = silent_at_s(|_| 1.0, turning).unwrap();
        assert!((found_s - 10.6).abs() < 0.051, "{found_s}");
        // A compass in steps of 3 degrees, and one that lies still beside a gyro with a bias of 2 deg/s.
        let steps = |t: f64| (0.2 * (t - 10.0).max(0.0) / 0.05).floor() * 0.05;
        assert_eq!(silent_at_s(steps, turning), None);
        assert_eq!(silent_at_s(|_| 1.0, |_| 0.035), None);
    }

    #[test]
    fn exact_what_was_measured_once_must_not_fall_silent() {
        let mut watch = EnvelopeWatch::new(Envelope::<f64>::default());
        let bottom = Sample { altitude_m: Some(5.0), ..Sample::default() };
        watch.look(&bottom, 0.0);
        watch.look(&Sample::default(), 9.0);
        watch.listen(0.0, 9.0);
        assert_eq!(watch.usage().exceeded(), None);
        let depth = Sample { depth_m: Some(2.0), ..Sample::default() };
        watch.look(&depth, 10.0);
        watch.look(&Sample::default(), 12.5);
        watch.listen(0.0, 12.5);
        assert_eq!(watch.usage().exceeded(), Some(AbortReason::StaleSamples));
    }
}
