//! Before the vehicle is taken: what must be so, what is changed.

use serde::Serialize;

use super::heard::Heard;
use super::profile::Rudder;
use super::{Autopilot, Profile};
use crate::link::Wire;

/// Longest wait for a vehicle, s.
const CONNECT_S: f64 = 10.0;
/// Longest wait for all parameters, s.
const PARAMETERS_S: f64 = 15.0;
/// Longest wait for parameters that not every firmware has, s.
const OPTIONAL_S: f64 = 3.0;
/// Parameters asked for at a time.
const ASKED_AT_ONCE: usize = 16;
/// Time over which rates are measured, s of the vehicle.
const RATES_S: f64 = 3.0;
/// Outputs per second that are asked for at most.
const OUTPUT_RATE_HZ: f64 = 50.0;
/// ArduPilot denies messages that are to come more often than in this share of its loops.
const SHARE_OF_LOOPS: f64 = 0.8;
/// Samples may come this much slower than asked for.
const SLOWER: f64 = 1.5;
/// A round trip so long, s, is no link to steer through.
const LONGEST_ROUND_TRIP_S: f64 = 1.5;
/// After this long without us the autopilot must have let go, s.
pub(super) const LONGEST_OVERRIDE_S: f64 = 1.0;
/// What an override is set to last, s.
const OVERRIDE_S: f64 = 0.8;
/// Flags of EKF_STATUS_REPORT: attitude known; not started.
const EKF_ATTITUDE: u16 = 1;
const EKF_UNINITIALISED: u16 = 1024;
/// Above this an estimator's check of its compass fails.
const HIGHEST_VARIANCE: f32 = 1.0;
/// GPS_FIX_TYPE_3D_FIX.
const FIX_3D: u8 = 3;

/// One thing that must be so.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Check {
    /// In a word or two.
    pub name: &'static str,
    /// Is it so?
    pub passed: bool,
    /// What was found, and where it is not so what to do.
    pub text: String,
}

/// A parameter that is changed for the trial.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Change {
    /// The parameter.
    pub name: String,
    /// What it is.
    pub from: f64,
    /// What it will be until the hand-back.
    pub to: f64,
    /// Why.
    pub why: &'static str,
}

/// What a look at the vehicle has found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Preflight {
    /// What it is.
    pub vehicle: String,
    /// What must be so.
    pub checks: Vec<Check>,
    /// Parameters that a trial changes and puts back.
    pub changes: Vec<Change>,
}

impl Preflight {
    /// Is everything as it must be?
    pub fn is_passed(&self) -> bool {
        self.checks.iter().all(|check| check.passed)
    }

    pub(super) fn check(&mut self, name: &'static str, passed: bool, text: impl Into<String>) {
        let text = text.into();
        self.checks.push(Check { name, passed, text });
    }
}

impl<W: Wire> Autopilot<W> {
    /// Looks at the vehicle without touching its controls. It is asked for messages more often.
    pub fn inspect(&mut self) -> Preflight {
        let mut found = Preflight {
            vehicle: "no vehicle".into(),
            checks: Vec::new(),
            changes: Vec::new(),
        };
        let is_there = self.wait(CONNECT_S, |autopilot| autopilot.heard.heartbeat.is_some());
        let damage = self.damage();
        if !is_there {
            let refused = match damage.refused_frames {
                0 => String::new(),
                count => format!("; {count} frames were refused for their signature"),
            };
            found.check(
                "heartbeat",
                false,
                format!("no autopilot was heard for {CONNECT_S} s{refused}: check the address, the cable and the key"),
            );
            return found;
        }
        found.vehicle = format!("{}, system {}", self.profile().name(), self.system());
        found.check("heartbeat", true, found.vehicle.clone());
        let missing = self.read_parameters();
        if !missing.is_empty() && self.damage().unchecked_frames > 0 {
            found.check(
                "signature",
                false,
                "it signs its frames and does not answer ours, which are not signed: give its key with --signing-key",
            );
            return found;
        }
        found.check(
            "parameters",
            missing.is_empty(),
            match missing.is_empty() {
                true => "read".into(),
                false => format!("no answer for {}", missing.join(", ")),
            },
        );
        self.find_rudder(&mut found);
        self.check_rates(&mut found);
        self.check_gain(&mut found);
        self.wait(CONNECT_S, |autopilot| autopilot.heard.heartbeats > 1);
        self.check_pilot(&mut found);
        check_health(&self.heard, self.profile(), &self.settings, &mut found);
        self.check_failsafes(&mut found);
        self.check_station(&mut found);
        self.check_takeover(&mut found);
        match &self.settings.envelope {
            Some(limits) => found.check("envelope", true, limits.clone()),
            None => found.check(
                "envelope",
                false,
                "no plan was given: its envelope must be this vehicle's (--plan FILE)",
            ),
        }
        found
    }

    fn read_parameters(&mut self) -> Vec<String> {
        let profile = self.profile();
        let mut names: Vec<String> = profile.parameters().iter().map(|n| (*n).into()).collect();
        let missing = |autopilot: &Self, names: &[String]| -> Vec<String> {
            let is_missing = |name: &&String| autopilot.parameters.get(name).is_none();
            names.iter().filter(is_missing).cloned().collect()
        };
        if profile.is_ardupilot() {
            names.extend((1..=16).map(|n| format!("SERVO{n}_FUNCTION")));
        }
        let read = |autopilot: &mut Self, names: &[String], longest_s: f64| {
            let mut round = 0;
            autopilot.insist(
                longest_s,
                |autopilot| {
                    let missing = missing(autopilot, names);
                    let start = round * ASKED_AT_ONCE % missing.len().max(1);
                    round += 1;
                    for name in missing
                        .iter()
                        .cycle()
                        .skip(start)
                        .take(ASKED_AT_ONCE.min(missing.len()))
                    {
                        autopilot.ask_parameter(name);
                    }
                },
                |autopilot| missing(autopilot, names).is_empty(),
            );
        };
        read(self, &names, PARAMETERS_S);
        if profile.is_ardupilot() {
            let used = |function: f64| {
                matches!(function as u32, 21 | 26 | 33..=36 | 70 | 73 | 74 | 79 | 80)
            };
            let mut more = Vec::new();
            for number in 1..=16 {
                let function = self.parameters.get(&format!("SERVO{number}_FUNCTION"));
                if function.is_some_and(used) {
                    more.extend(
                        ["MIN", "TRIM", "MAX", "REVERSED"].map(|w| format!("SERVO{number}_{w}")),
                    );
                }
            }
            if profile == Profile::Sub {
                more.extend((1..=4).map(|n| format!("MOT_{n}_DIRECTION")));
            }
            read(self, &more, PARAMETERS_S);
            names.extend(more);
            if profile == Profile::Sub {
                let optional = ["JS_GAIN_DEFAULT", "FS_PILOT_TIMEOUT"].map(String::from);
                read(self, &optional, OPTIONAL_S);
            }
            // One of them, by the age of the firmware.
            let station = ["MAV_GCS_SYSID", "SYSID_MYGCS"];
            self.insist(
                PARAMETERS_S,
                |autopilot| {
                    station
                        .iter()
                        .for_each(|name| autopilot.ask_parameter(name))
                },
                |autopilot| {
                    station
                        .iter()
                        .any(|name| autopilot.parameters.get(name).is_some())
                },
            );
        }
        missing(self, &names)
    }

    fn find_rudder(&mut self, found: &mut Preflight) {
        let profile = self.profile();
        self.rudder = Rudder::find(profile, &self.parameters, self.settings.outputs.as_ref());
        match &self.rudder {
            Some(rudder) => found.check("rudder", true, rudder.text()),
            None => found.check(
                "rudder",
                false,
                format!(
                    "no output is known to steer ({}); say which with --steering-outputs",
                    self.parameters.functions()
                ),
            ),
        }
        if profile == Profile::Rover {
            let dead_us = self.parameters.get("RC1_DZ").unwrap_or(f64::NAN);
            let known = dead_us.is_finite();
            found.check(
                "dead zone",
                known,
                format!("RC1_DZ is {dead_us:.0} us; commands step over it"),
            );
        }
    }

    /// The messages that are asked for, by number, and their intervals, s.
    pub(super) fn wanted_messages(&self) -> Vec<(u32, f64)> {
        let sample_s = self.settings.sample_interval_s;
        let mut wanted = vec![
            (30, attitude_interval_s(self.loop_s(), sample_s)),
            (36, self.output_interval_s()),
        ];
        let estimator: &[u32] = match self.profile() {
            Profile::Rover | Profile::Sub => &[193],
            Profile::Px4 => &[230],
            Profile::Generic => &[193, 230],
        };
        wanted.extend([1, 24].iter().chain(estimator).map(|id| (*id, 1.0)));
        wanted.extend([32, 33, 65, 74].map(|id| (id, 0.2_f64.max(sample_s))));
        wanted
    }

    /// Time between two of the autopilot's loops, s; 0 where it does not say.
    fn loop_s(&self) -> f64 {
        let rate_hz = self.parameters.get("SCHED_LOOP_RATE");
        rate_hz
            .filter(|rate| *rate >= 1.0)
            .map_or(0.0, |rate| 1.0 / rate)
    }

    fn output_interval_s(&self) -> f64 {
        output_interval_s(self.loop_s(), self.settings.sample_interval_s)
    }

    fn check_rates(&mut self, found: &mut Preflight) {
        // An output changes half of what lies between two messages before the one that shows it.
        self.earlier_s = 0.5 * (self.output_interval_s() - self.loop_s()).max(0.0);
        let wanted = self.wanted_messages();
        let mut times_s: Vec<f64> = Vec::new();
        self.sampler.skip();
        let mut asked = 0;
        let end_s = self.wire.now_s() + 3.0 * RATES_S;
        let mut start_s = f64::NAN;
        // Requests get lost: three times in all.
        while self.wire.now_s() < end_s
            && times_s
                .last()
                .is_none_or(|last| start_s.is_nan() || last - start_s <= RATES_S)
        {
            if asked < 3 && times_s.len() >= 10 * asked {
                asked += 1;
                wanted
                    .iter()
                    .for_each(|(id, interval_s)| self.set_interval(*id, *interval_s));
            }
            let now_s = self.wire.now_s();
            self.pump(now_s + 0.02);
            while let Some(sample) = self.sampler.take() {
                if asked == 3 && start_s.is_nan() {
                    start_s = sample.time_s;
                }
                times_s.push(sample.time_s);
            }
        }
        times_s.retain(|time_s| *time_s >= start_s);
        let mut intervals_s: Vec<f64> = times_s.windows(2).map(|w| w[1] - w[0]).collect();
        intervals_s.sort_by(f64::total_cmp);
        let wanted_s = self.settings.sample_interval_s;
        let denied = self.heard.denied;
        match intervals_s.get(intervals_s.len() / 2) {
            Some(median_s) => found.check(
                "rates",
                *median_s <= SLOWER * wanted_s,
                format!(
                    "ATTITUDE and SERVO_OUTPUT_RAW every {:.0} ms, {:.0} ms asked for{}",
                    1e3 * median_s,
                    1e3 * wanted_s,
                    if denied > 0 {
                        "; the autopilot denied some rates"
                    } else {
                        ""
                    }
                ),
            ),
            None => found.check(
                "rates",
                false,
                "no ATTITUDE together with SERVO_OUTPUT_RAW comes; the autopilot must send both",
            ),
        }
        self.wait(3.0, |autopilot| autopilot.heard.clock.is_some());
        match self.heard.clock {
            Some((round_trip_s, ahead_s)) => found.check(
                "clock",
                round_trip_s <= LONGEST_ROUND_TRIP_S,
                format!(
                    "its clock is {ahead_s:.3} s ahead of this trial's, round trip {:.0} ms",
                    1e3 * round_trip_s
                ),
            ),
            None => found.check("clock", false, "TIMESYNC is not answered"),
        }
    }

    /// ArduSub makes less of a stick than its full, by a gain that the pilot's buttons change.
    fn check_gain(&mut self, found: &mut Preflight) {
        if self.profile() != Profile::Sub {
            return;
        }
        let told = self.heard.pilot_gain.map(|gain| ("PilotGain", gain));
        let set = self.parameters.get("JS_GAIN_DEFAULT");
        let Some((name, gain)) = told.or(set.map(|gain| ("JS_GAIN_DEFAULT", gain))) else {
            return;
        };
        let is_gain = gain > 0.0 && gain <= 1.0;
        if is_gain {
            self.stick_gain = gain;
        }
        let most_asked = self.settings.most_asked;
        // Each horizontal thruster does both.
        let fits = gain * most_asked <= 1.0 || self.settings.outputs.is_some();
        found.check(
            "stick gain",
            is_gain && fits,
            format!(
                "{name} is {gain:.2}: full steering and full thrust are that much of the thrusters'{}",
                match fits {
                    true => String::new(),
                    false => format!(
                        ", too much for the {most_asked:.2} that the plan asks for together: {:.2} would do",
                        1.0 / most_asked
                    ),
                }
            ),
        );
    }

    /// ArduSub without a remote control is in a failsafe whenever nobody steers it.
    fn check_pilot(&mut self, found: &mut Preflight) {
        let is_alone = self.profile() == Profile::Sub && !self.heard.has_sticks();
        let action = self.parameters.get("FS_PILOT_INPUT").filter(|_| is_alone);
        if action == Some(2.0) && !self.heard.is_armed() {
            let text = "FS_PILOT_INPUT is 2, which disarms it when nobody steers: 1 makes its controls neutral and leaves it armed";
            found.check("pilot", false, text);
        }
        let failsafe = self.heard.failsafe.clone();
        if failsafe.is_none() && self.heard.is_critical() && action == Some(1.0) {
            let text = "its state is critical, as FS_PILOT_INPUT makes it while nobody steers; it must be over when we do";
            found.check("state", true, text);
        } else if failsafe.is_some() || self.heard.is_critical() {
            let text = failsafe.unwrap_or("its state is critical".into());
            found.check("state", false, text);
        }
    }

    fn check_failsafes(&mut self, found: &mut Preflight) {
        let profile = self.profile();
        let change = |name: &str, to: f64, why: &'static str| {
            let from = self.parameters.get(name)?;
            Some(Change {
                name: name.into(),
                from,
                to,
                why,
            })
        };
        if profile.is_ardupilot() {
            let seconds = self.parameters.get("RC_OVERRIDE_TIME").unwrap_or(f64::NAN);
            if !(seconds > 0.0 && seconds <= LONGEST_OVERRIDE_S) {
                let why = "the autopilot lets go of the rudder this long after our last command";
                found
                    .changes
                    .extend(change("RC_OVERRIDE_TIME", OVERRIDE_S, why));
            }
        }
        if profile == Profile::Rover {
            if self.parameters.get("FS_GCS_ENABLE") == Some(0.0) {
                let why = "the autopilot acts when this program is gone";
                found.changes.extend(change("FS_GCS_ENABLE", 1.0, why));
            }
            if self.parameters.get("FS_ACTION") == Some(0.0) {
                found
                    .changes
                    .extend(change("FS_ACTION", 2.0, "a failsafe holds the vehicle"));
            }
        }
        if profile == Profile::Sub {
            // Without a remote control it is not the override's end that makes the sticks neutral.
            let has_sticks = self.heard.has_sticks();
            let seconds = self.parameters.get("FS_PILOT_TIMEOUT");
            if !has_sticks && seconds.is_some_and(|seconds| seconds > LONGEST_OVERRIDE_S) {
                let why = "without a remote control it is this that lets go of the rudder";
                found
                    .changes
                    .extend(change("FS_PILOT_TIMEOUT", OVERRIDE_S, why));
            }
            if !has_sticks && self.parameters.get("FS_PILOT_INPUT") != Some(1.0) {
                let why = "1 makes the controls neutral after FS_PILOT_TIMEOUT and does not disarm";
                found.changes.extend(change("FS_PILOT_INPUT", 1.0, why));
            }
            let action = self.parameters.get("FS_GCS_ENABLE").unwrap_or(0.0);
            found.check(
                "failsafe",
                action >= 2.0,
                format!("FS_GCS_ENABLE is {action}; 2 and above does something when this program is gone, and what is yours to say"),
            );
        }
        if profile == Profile::Px4 {
            let seconds = self.parameters.get("COM_RC_LOSS_T").unwrap_or(f64::NAN);
            if !(seconds > 0.0 && seconds <= LONGEST_OVERRIDE_S) {
                let why = "the autopilot lets go of the rudder this long after our last command";
                found
                    .changes
                    .extend(change("COM_RC_LOSS_T", OVERRIDE_S, why));
            }
        }
    }

    fn check_station(&mut self, found: &mut Preflight) {
        let ours = self.settings.system_id;
        if self.profile().is_ardupilot() {
            let obeyed = ["MAV_GCS_SYSID", "SYSID_MYGCS"]
                .iter()
                .find_map(|name| Some((name, self.parameters.get(name)?)));
            match obeyed {
                Some((name, id)) => found.check(
                    "system id",
                    id == f64::from(ours),
                    format!("{name} is {id}, ours is {ours}; commands of any other are ignored without a word"),
                ),
                None => found.check("system id", false, "neither MAV_GCS_SYSID nor SYSID_MYGCS is there"),
            }
        }
        found.check(
            "one station",
            !self.heard.has_double,
            match self.heard.has_double {
                true => format!("another ground station has our system id {ours}: stop it, or give one of both another id"),
                false => format!("nobody else has our system id {ours}"),
            },
        );
    }

    fn check_takeover(&mut self, found: &mut Preflight) {
        let channels = self
            .heard
            .remote_control
            .map_or(0, |channels| channels.count);
        let (passed, text) = match (channels, self.settings.without_remote_control) {
            (_, true) => (true, "a change of mode from a ground station; no remote control".into()),
            (0, false) => (
                false,
                "no remote control is heard; if a change of mode from a ground station shall do, say --without-rc".into(),
            ),
            (count, false) => (
                true,
                format!("a change of mode, or any of {count} channels of the remote control that is not ours"),
            ),
        };
        found.check("takeover", passed, text);
    }
}

fn check_health(
    heard: &Heard,
    profile: Profile,
    settings: &super::Settings,
    found: &mut Preflight,
) {
    found.check(
        "armed",
        heard.is_armed(),
        match heard.is_armed() {
            true => "armed",
            false => "disarmed: arm it; the trial never does",
        },
    );
    let (is_healthy, compass, text) = match (heard.ekf, heard.estimator) {
        (Some(ekf), _) => {
            let flags = ekf.flags;
            let is_known = flags & EKF_ATTITUDE != 0 && flags & EKF_UNINITIALISED == 0;
            (is_known, ekf.compass_variance, format!("flags {flags:#x}"))
        }
        (None, Some(status)) => {
            let is_known = status.flags & EKF_ATTITUDE != 0;
            (
                is_known,
                status.compass_ratio,
                format!("flags {:#x}", status.flags),
            )
        }
        (None, None) => (
            false,
            f32::NAN,
            "no report of the estimator has come".into(),
        ),
    };
    found.check("estimator", is_healthy, text);
    found.check(
        "heading source",
        compass <= HIGHEST_VARIANCE,
        format!("compass against estimator: {compass:.2} of what it may differ"),
    );
    if profile.is_boat() {
        let fix = heard.gps.map_or(0, |gps| gps.fix_type);
        let text = format!("fix type {fix}; a boat needs {FIX_3D}, a fix in three dimensions");
        found.check("satellites", fix >= FIX_3D, text);
    }
    match heard.battery_percent() {
        Some(percent) => found.check(
            "battery",
            percent >= settings.lowest_battery_percent,
            format!(
                "{percent} %, at least {} %",
                settings.lowest_battery_percent
            ),
        ),
        None => found.check(
            "battery",
            true,
            "not measured; the autopilot's own failsafe is all there is",
        ),
    }
}

/// Between two attitudes, s, of an autopilot with this time between its loops: whole loops, or they would come unevenly.
fn attitude_interval_s(loop_s: f64, sample_s: f64) -> f64 {
    // 0.05 s may be a last bit less than five times 0.01 s.
    let loops = (sample_s / loop_s + 1e-6).floor();
    let even_s = if loops.is_finite() && loops >= 1.0 {
        loops * loop_s
    } else {
        sample_s
    };
    even_s.max(loop_s / SHARE_OF_LOOPS)
}

/// Between two messages with outputs, s, of an autopilot with this time between its loops.
fn output_interval_s(loop_s: f64, sample_s: f64) -> f64 {
    (1.0 / OUTPUT_RATE_HZ)
        .max(loop_s / SHARE_OF_LOOPS)
        .min(sample_s)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At 50 loops a second samples of 20 Hz came 40 and 60 ms apart in turn, which looks like samples lost.
    #[test]
    fn regress_attitudes_come_evenly() {
        for (loop_s, interval_s) in [(0.02, 0.04), (0.01, 0.05), (0.0025, 0.05), (0.0, 0.05)] {
            let found_s = attitude_interval_s(loop_s, 0.05);
            // The last bit of a product.
            assert!((found_s - interval_s).abs() < 1e-15, "{found_s}");
        }
    }

    /// ArduPilot's Rover has 50 loops a second as it comes; its outputs then came at 1 Hz, the rate from before we asked.
    #[test]
    fn regress_no_more_outputs_are_asked_for_than_are_given() {
        for (loop_hz, interval_s) in [(50.0, 0.025), (100.0, 0.02), (400.0, 0.02), (20.0, 0.05)] {
            let found_s = output_interval_s(1.0 / loop_hz, 0.05);
            // The last bit of a quotient.
            assert!((found_s - interval_s).abs() < 1e-15, "{found_s}");
        }
    }
}
