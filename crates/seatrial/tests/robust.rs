//! The estimate from a whole record on real firmware, real hulls and simulated plants.

use std::path::Path;

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use seatrial::identification::{ReasonCode, Subject};
use seatrial::identify::whole_record::robust_estimate;
use seatrial::identify::{IdentifySettings, ValidationData, identify};
use seatrial::{Record, Window};
use seatrial_core::Sample;
use seatrial_core::YawModel;
use seatrial_core::model::YawState;
use seatrial_dev::data;

fn read(path: &Path) -> Record {
    let mut log = seatrial_logs::open(path, &Default::default()).unwrap();
    std::iter::from_fn(|| log.next()).map(Result::unwrap).collect()
}

fn window(ends: &serde_json::Value) -> Window {
    Window { from_s: ends[0].as_f64().unwrap(), to_s: ends[1].as_f64().unwrap() }
}

/// Is the truth within the interval, and by how many half widths is it off?
fn off([low, high]: [f64; 2], truth: f64) -> f64 {
    (truth - 0.5 * (low + high)).abs() / (0.5 * (high - low))
}

/// What became of the trials on ArduRover firmware over plants of first order.
#[derive(Default)]
struct Firmware {
    records: usize,
    accepted: usize,
    /// Accepted, with a22 and b2 within their intervals.
    held: usize,
}

impl Firmware {
    /// Identifies a trial by the windows of `run`. No accepted model is beyond two half widths, no a22 is off by more than `most_off`.
    fn count(
        &mut self,
        name: &str,
        record: &Record,
        [truth, run]: [&serde_json::Value; 2],
        most_off: f64,
    ) {
        let validation = ValidationData { record, window: window(&run["validate"]) };
        let found =
            identify(record, window(&run["train"]), Some(validation), &IdentifySettings::default())
                .unwrap();
        let refined = found.refined.unwrap();
        let [a22, b2] = ["a22_per_s", "b2_per_s2"].map(|name| truth[name].as_f64().unwrap());
        let away =
            off(refined.interval_95.a22_per_s, a22).max(off(refined.interval_95.b2_per_s2, b2));
        let a22_off = refined.model.a22_per_s / a22 - 1.0;
        let codes: Vec<_> = found.verdict.reasons.iter().map(|r| r.kind()).collect();
        println!(
            "{name}: a22 {:+.1} %, b2 {:+.1} %, {away:.2} half widths, accepted {} {codes:?}",
            100.0 * a22_off,
            100.0 * (refined.model.b2_per_s2 / b2 - 1.0),
            found.verdict.accepted,
        );
        self.records += 1;
        if found.verdict.accepted {
            self.accepted += 1;
            self.held += usize::from(away < 1.0);
            assert!(away < 2.0, "{name} {away}");
            assert!(a22_off.abs() < most_off, "{name}");
        }
    }
}

fn truths_of(folder: &Path) -> Vec<serde_json::Value> {
    let truths = std::fs::read_to_string(folder.join("truth.json")).unwrap();
    serde_json::from_str(&truths).unwrap()
}

/// Identifies each trial after a change of its record.
fn firmware_trials(change: impl Fn(&mut Record)) -> Option<Firmware> {
    let folder = data("firmware")?;
    let mut trials = Firmware::default();
    for truth in &truths_of(&folder) {
        let name = truth["file"].as_str().unwrap();
        let mut record = read(&folder.join(name));
        change(&mut record);
        trials.count(name, &record, [truth, truth], 0.12);
    }
    Some(trials)
}

/// In a sea of 0.02 rad/s^2 every attempt is accepted and holds a22 and b2.
#[test]
fn val_firmware_trials_in_a_sea_hold_the_plant() {
    let Some(folder) = data("firmware_sea") else {
        return;
    };
    let mut trials = Firmware::default();
    let in_a_sea = |truth: &serde_json::Value| truth["disturbance_rad_s2"].as_f64() > Some(0.0);
    for truth in truths_of(&folder).iter().filter(|truth| in_a_sea(truth)) {
        let name = truth["file"].as_str().unwrap();
        let record = read(&folder.join(name));
        for run in truth["runs"].as_array().unwrap() {
            trials.count(name, &record, [truth, run], 0.12);
        }
    }
    assert_eq!([trials.records, trials.accepted, trials.held], [5, 5, 5]);
}

/// Nine in ten are accepted, of those nine in ten hold a22 and b2.
#[test]
fn val_firmware_trials_hold_the_plant() {
    if let Some(trials) = firmware_trials(|_| ()) {
        assert!(10 * trials.accepted >= 9 * trials.records);
        assert!(10 * trials.held >= 9 * trials.accepted);
    }
}

/// A rudder that is logged at 10 or 5 Hz beside the heading: when it moved between two of its rows is unknown and widens the interval.
#[test]
fn val_firmware_trials_with_a_slowly_logged_rudder_hold_the_plant() {
    let (mut accepted, mut held) = (0, 0);
    for (renewed_s, phase_s) in [(0.1, 0.0), (0.1, 0.05), (0.2, 0.0), (0.2, 0.1)] {
        let count = |time_s: f64| ((time_s + phase_s) / renewed_s + 1e-6).floor();
        let trials = firmware_trials(|record| {
            for k in 1..record.samples.len() {
                let [last, sample] = [record.samples[k - 1], record.samples[k]];
                if count(sample.time_s) == count(last.time_s) {
                    record.samples[k].rudder_rad = last.rudder_rad;
                }
            }
        });
        let trials = trials.unwrap_or_default();
        accepted += trials.accepted;
        held += trials.held;
    }
    assert!(20 * held >= 19 * accepted, "{held} of {accepted}");
}

/// A real boat on a zig-zag: windows of 105 and 120 s and the whole agree, at the damping that every simulation of it has.
#[test]
fn val_fuzhou_windows_agree() {
    let Some(folder) = data("real") else {
        return;
    };
    let record = read(&folder.join("fuzhou_zz.csv"));
    for to_s in [105.0, 120.0, f64::INFINITY] {
        let samples = record.window(Window { from_s: 0.0, to_s });
        let found = robust_estimate(samples).unwrap();
        // Batch least squares, instrumental variable and output error: -0.22 to -0.24.
        let a22 = found.refined.model.a22_per_s;
        assert!((-0.26..-0.20).contains(&a22), "{to_s} s: {a22}");
    }
}

/// Ships on zig-zags have no mode that is faster than their simulation: output error gives -0.17, -0.07, -0.06 1/s for the Esso Osaka,
/// -0.02 to -0.12 for the KVLCC2. A lag at its bound of 0 does not make their intervals wide.
#[test]
fn val_ships_show_no_false_fast_mode() {
    let Some(folder) = data("real") else {
        return;
    };
    for (name, slowest, fastest) in [
        ("esso_zigzag_a", -0.12, -0.22),
        ("esso_zigzag_b", -0.05, -0.10),
        ("esso_zigzag_c", -0.04, -0.09),
        ("kvlcc2hsva_Z_10_10_S", -0.015, -0.03),
        ("kvlcc2hsva_Z_20_10_P", -0.06, -0.10),
        ("kvlcc2hsva_Z_20_10_S", -0.06, -0.10),
        ("kvlcc2hsva_Z_25_05", -0.08, -0.12),
        ("kvlcc2hsva_Z_30_05", -0.08, -0.14),
    ] {
        let record = read(&folder.join(format!("{name}.csv")));
        let found = robust_estimate(record.window(Window::ALL)).unwrap();
        let a22 = found.refined.model.a22_per_s;
        println!("{name}: {a22} {:?}", found.refined.interval_95.a22_per_s);
        assert!((fastest..slowest).contains(&a22), "{name}: {a22}");
        let [low, high] = found.refined.interval_95.a22_per_s;
        // The legs of a zig-zag tell a22 to a half.
        assert!(high - low < 1.2 * a22.abs(), "{name}: {low} to {high}");
    }
}

/// A doublet of 0.26 rad between segments of heading hold, 330 samples at 20 Hz, of a rudder that lags.
fn stage(theta: [f64; 3], lag_s: f64, noise_rad: f64, seed: u64) -> Vec<Sample<f64>> {
    const PARTS: u32 = 50;
    let model = YawModel::from_theta(theta);
    let mut random = Pcg64::seed_from_u64(seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
    let neutral = -theta[2] / theta[1];
    let gain = 0.3 * theta[0] * theta[0] / theta[1];
    let part_s = 0.05 / f64::from(PARTS);
    let kept: f64 = if lag_s > 0.0 { (-part_s / lag_s).exp() } else { 0.0 };
    let mut acting = neutral;
    let mut state = YawState::<f64>::default();
    (0..330_u32)
        .map(|k| {
            let heading_rad: f64 = state.heading_rad + noise_rad * normal();
            let rudder_rad: f64 = match k {
                40..80 => 0.26,
                80..120 => -0.26,
                _ => (neutral - gain * heading_rad).clamp(-0.35, 0.35),
            };
            for _ in 0..PARTS {
                let next = rudder_rad + kept * (acting - rudder_rad);
                state = model.advance(
                    state,
                    if lag_s > 0.0 { 0.5 * (acting + next) } else { next },
                    part_s,
                );
                acting = next;
            }
            Sample { time_s: 0.05 * f64::from(k), heading_rad, rudder_rad, ..Sample::default() }
        })
        .collect()
}

#[test]
fn exact_plants_behind_a_lag_come_back() {
    for (a22, b2) in [(-0.2, 0.06), (-0.55, 0.42), (-1.7, 1.3), (-2.8, 3.6)] {
        for lag_s in [0.0, 0.05, 0.15] {
            let samples = stage([a22, b2, 0.02 * b2], lag_s, 0.0, 1);
            let found = robust_estimate(&samples).unwrap();
            let model = &found.refined.model;
            // The beliefs on lag and timing and the steps of the lag's simulation leave a little.
            assert!((model.a22_per_s / a22 - 1.0).abs() < 3e-3, "{a22} {lag_s} {model:?}");
            assert!((model.b2_per_s2 / b2 - 1.0).abs() < 3e-3, "{a22} {lag_s} {model:?}");
            let lag = found.robust.lag.map_or(0.0, |lag| lag.delay_s);
            assert!((lag - lag_s).abs() < 5e-3, "{a22} {lag_s} {lag}");
        }
    }
}

#[test]
fn recover_plants_behind_an_unknown_lag_are_within_their_intervals() {
    let (mut runs, mut held) = (0, 0);
    for (a22, b2) in [(-0.55, 0.42), (-1.7, 1.3)] {
        for lag_s in [0.0, 0.1, 0.2] {
            for noise_rad in [1e-3, 1e-2] {
                for seed in 1..=5 {
                    let samples = stage([a22, b2, 0.02 * b2], lag_s, noise_rad, seed);
                    let interval = robust_estimate(&samples).unwrap().refined.interval_95;
                    let away = off(interval.a22_per_s, a22).max(off(interval.b2_per_s2, b2));
                    assert!(away < 2.5, "{a22} {lag_s} {noise_rad} {seed}: {away}");
                    runs += 1;
                    held += usize::from(away < 1.0);
                }
            }
        }
    }
    // 95 % of 60 are 57; 52 or fewer come by chance twice in a hundred times.
    assert!(held > 52, "{held} of {runs}");
}

/// Where the heading is noise, no estimate is of a vehicle that is faster than its samples.
#[test]
fn prop_no_vehicle_is_faster_than_its_samples() {
    for seed in 1..=60 {
        let samples = stage([-1.0, 1e-3, 1e-5], 0.0, 0.03, seed);
        if let Ok(found) = robust_estimate(&samples) {
            let a22 = found.refined.model.a22_per_s;
            // 2.0, and what the bound of the lag moves the mean by.
            assert!(a22.abs() * 0.05 < 2.2, "{seed}: {a22}");
        }
    }
}

/// A zig-zag of a vehicle whose yaw rate overshoots, r = K (1 + T3 s) / ((1 + T1 s) (1 + T2 s)) rudder: no first order follows it, and
/// that is the cause, neither a slow log nor a stuck rudder.
#[test]
fn recover_a_yaw_rate_that_overshoots_is_refused_for_no_other_cause() {
    const STEP_S: f64 = 0.001;
    let zig_zag = |seed: u64| -> Record {
        let mut random = Pcg64::seed_from_u64(seed);
        let (mut fast, mut slow, mut heading, mut rudder) = (0.0, 0.0, 0.0, 0.17);
        let mut samples = Vec::new();
        for k in 0..60_000_u32 {
            if heading * rudder > 0.0 && f64::abs(heading) > 0.35 {
                rudder = -rudder;
            }
            if k % 100 == 0 {
                let noise: f64 = StandardNormal.sample(&mut random);
                samples.push(Sample {
                    time_s: f64::from(k) * STEP_S,
                    heading_rad: heading + 9e-3 * noise,
                    rudder_rad: rudder,
                    ..Sample::default()
                });
            }
            fast += STEP_S / 0.1 * (rudder - fast);
            slow += STEP_S / 1.5 * (rudder - slow);
            heading += STEP_S * 0.5 * (1.6 * fast - 0.6 * slow);
        }
        samples.into_iter().collect()
    };
    for seed in 1..=5 {
        let other = zig_zag(100 + seed);
        let validation = ValidationData { record: &other, window: Window::ALL };
        let settings = IdentifySettings::default();
        let found = identify(&zig_zag(seed), Window::ALL, Some(validation), &settings).unwrap();
        let verdict = &found.verdict;
        assert!(!verdict.accepted);
        assert!(!verdict.has(&ReasonCode::SampledTooSeldom), "{verdict:?}");
        assert!(!verdict.has(ReasonCode::RudderNotFollowed.of(Subject::Rudder)), "{verdict:?}");
    }
}

/// Five samples a second of a vehicle with a time constant of 0.77 s, whose rudder moves up to an interval after a sample: such a log was refused.
#[test]
fn recover_a_rudder_that_moves_between_the_samples_of_a_slow_log() {
    let theta = [-1.3, 1.3, 0.02];
    let (mut found, mut held) = (0, 0);
    for seed in 1..=6 {
        for first in 0..4 {
            let samples = stage(theta, 0.0, 4e-3, seed);
            let slow: Record = samples.into_iter().skip(first).step_by(4).collect();
            let result = identify(&slow, Window::ALL, None, &IdentifySettings::default()).unwrap();
            assert!(!result.verdict.has(&ReasonCode::SampledTooSeldom), "{result:?}");
            let interval_95 = result.refined.unwrap().interval_95;
            let off = [off(interval_95.a22_per_s, theta[0]), off(interval_95.b2_per_s2, theta[1])];
            assert!(off.iter().all(|off| *off < 2.0), "{seed} {first} {off:?}");
            found += 1;
            held += usize::from(off.iter().all(|off| *off <= 1.0));
        }
    }
    assert!(10 * held >= 9 * found, "{held} of {found}");
}

/// A vehicle with a time constant of 1 s in a log of 1 Hz: how the rudder moved in between is not in it.
#[test]
fn recover_a_slow_log_is_refused_with_the_rate_that_is_needed() {
    let samples = stage([-1.0, 1.0, 0.02], 0.0, 1e-3, 1);
    let slow: Record = samples.into_iter().step_by(20).collect();
    let found = identify(&slow, Window::ALL, None, &IdentifySettings::default());
    if let Ok(found) = found {
        assert!(!found.verdict.accepted);
        assert!(found.verdict.has(&ReasonCode::SampledTooSeldom));
    }
}
