//! Does the test of health keep its false alarm rate, and does it see what it should? On the simulator.

use seatrial::health::{
    Cause, Change, Finding, HealthSettings, Reference, SpeedModel, Watch, WatchReport, compare,
};
use seatrial::identify::{IdentifySettings, identify};
use seatrial::{Record, Window};
use seatrial_core::{Action, Sample, Steering, Vehicle};
use seatrial_sim::{FirstOrderVehicle, VehicleConfig};

/// What the sea does to a record.
#[derive(Clone, Copy, Debug)]
struct Sea {
    compass_noise_deg: f64,
    disturbance_rad_s2: f64,
    disturbance_s: f64,
}

const CALM: Sea = Sea { compass_noise_deg: 0.5, disturbance_rad_s2: 0.0, disturbance_s: 2.0 };

const ROUGH: Sea = Sea { disturbance_rad_s2: 0.005, ..CALM };

/// The paper's vehicle at 80 % thrust with a22, b2 and C0 multiplied by these.
fn vehicle(factors: [f64; 3], sea: Sea) -> VehicleConfig {
    let mut config = VehicleConfig::starfish();
    config.initial_thrust = 0.8;
    config.sensors.compass.noise_rad = sea.compass_noise_deg.to_radians();
    config.disturbance.standard_deviation_rad_s2 = sea.disturbance_rad_s2;
    config.disturbance.correlation_time_s = sea.disturbance_s;
    for point in &mut config.speeds {
        point.a22_per_s *= factors[0];
        point.b2_per_s2 *= factors[1];
        point.c0_rad_per_s2 *= factors[2];
    }
    config
}

/// Drives a vehicle; `steering` says what it does at a time.
fn drive(
    config: &VehicleConfig,
    seed: u64,
    duration_s: f64,
    steering: impl Fn(f64) -> Steering<f64>,
) -> Record {
    let mut vehicle = FirstOrderVehicle::new(config.clone(), seed).unwrap();
    let mut samples: Vec<Sample<f64>> = Vec::new();
    loop {
        let sample = vehicle.next_sample().unwrap().unwrap();
        samples.push(sample);
        if sample.time_s > duration_s {
            return samples.into_iter().collect();
        }
        let action = Action { steering: steering(sample.time_s), thrust: Some(0.8), outcome: None };
        vehicle.act(&action).unwrap();
    }
}

/// The paper's doublet of this amplitude from second 7 to 11, heading hold before and after.
fn doublet(amplitude_rad: f64) -> impl Fn(f64) -> Steering<f64> {
    move |time_s| match time_s {
        t if (7.0..9.0).contains(&t) => Steering::Rudder(amplitude_rad),
        t if (9.0..11.0).contains(&t) => Steering::Rudder(-amplitude_rad),
        _ => Steering::HoldHeading(0.0),
    }
}

/// One trial run: 16.5 s of training after 5 s of settling.
fn trial(config: &VehicleConfig, seed: u64) -> SpeedModel {
    let record = drive(config, seed, 21.5, doublet(0.26));
    let training = Window { from_s: 5.0, to_s: 21.5 };
    let found = identify(&record, training, None, &IdentifySettings::default()).unwrap();
    SpeedModel::of(&found, Some(0.8), Some(1.63)).unwrap()
}

fn settings() -> HealthSettings {
    HealthSettings::new(0.05, 0.0, true).unwrap()
}

fn change(reference: SpeedModel, now: SpeedModel) -> Change {
    let reference = Reference::new(vec![reference]).unwrap();
    compare(&reference, &[now], &settings())
}

/// The share of pairs of runs that are called changed.
fn changed_share(
    runs: u64,
    reference: &VehicleConfig,
    now: &VehicleConfig,
    check: impl Fn(&Change),
) -> f64 {
    let changed = (0..runs)
        .filter(|seed| {
            let change = change(trial(reference, 2 * seed), trial(now, 2 * seed + 1));
            check(&change);
            change.finding == Finding::Changed
        })
        .count();
    changed as f64 / runs as f64
}

/// The share of pairs of successive runs of one vehicle that are called changed.
fn false_alarm_rate(runs: u64, sea: Sea) -> f64 {
    let config = vehicle([1.0; 3], sea);
    let models: Vec<SpeedModel> = (0..=runs).map(|seed| trial(&config, seed)).collect();
    let alarms = models
        .windows(2)
        .filter(|pair| change(pair[0], pair[1]).finding == Finding::Changed)
        .count();
    alarms as f64 / runs as f64
}

#[test]
fn recover_false_alarms_stay_within_the_stated_rate() {
    // 160 pairs at a rate of 5 %: up to 8 % is within two standard deviations. Without disturbance the refined
    // intervals are too wide (the disturbance might have been there), and the rate is lower than stated.
    for sea in [CALM, ROUGH] {
        let rate = false_alarm_rate(160, sea);
        println!("{sea:?}: {:.1} %", 100.0 * rate);
        assert!(rate <= 0.08, "{sea:?}: {rate}");
    }
}

#[test]
fn recover_one_trial_shows_a_weaker_rudder_and_a_payload() {
    let sound = vehicle([1.0; 3], ROUGH);
    for (factors, cause, size) in [
        ([1.0, 0.8, 1.0], Cause::Rudder, -0.2),
        // A fifth more inertia.
        ([1.0 / 1.2, 1.0 / 1.2, 1.0 / 1.2], Cause::Inertia, -1.0 / 6.0),
    ] {
        let named = std::cell::Cell::new(0);
        let power = changed_share(30, &sound, &vehicle(factors, ROUGH), |change| {
            let Some(explanation) = &change.explanation else {
                return;
            };
            let is_named = explanation.cause == cause || explanation.also_possible.contains(&cause);
            let [low, high] = explanation.size.interval_95;
            if is_named && (explanation.cause != cause || (low..high).contains(&size)) {
                named.set(named.get() + 1);
            }
        });
        println!("{cause:?}: found {power}, named {} of 30", named.get());
        assert!(power > 0.9, "{cause:?}: {power}");
        // 95 % intervals and a cause kept at 5 %, less four standard deviations of 30 cases.
        assert!(named.get() >= 22, "{cause:?}: {}", named.get());
    }
}

/// A mission: legs of 40 s with a turn of 40 degrees between them, by the vehicle's own controller.
fn mission(config: &VehicleConfig, seed: u64) -> Record {
    drive(config, seed, 160.0, |time_s| {
        let leg = (time_s / 40.0).floor();
        Steering::HoldHeading((leg % 2.0) * 0.7)
    })
}

fn watch(reference: &[SpeedModel], missions: &[(VehicleConfig, u64)]) -> WatchReport {
    let settings = HealthSettings::new(0.05, 0.0, false).unwrap();
    let reference = Reference::new(reference.to_vec()).unwrap();
    let mut watch = Watch::new(reference, settings).unwrap();
    for (number, (config, seed)) in missions.iter().enumerate() {
        watch.read(&format!("mission {}", number + 1), &mission(config, *seed));
    }
    watch.report()
}

/// Of `cases` watches over five missions of an unchanged vehicle, how many raise an alarm and how many cannot tell.
fn watch_alarms(cases: u64, sea: Sea) -> [usize; 2] {
    let sound = vehicle([1.0; 3], sea);
    watch_findings(cases, &sound, &sound)
}

/// Of `cases` watches over five missions of a vehicle, how many find a change from a trial before and how many cannot tell.
fn watch_findings(cases: u64, before: &VehicleConfig, now: &VehicleConfig) -> [usize; 2] {
    let findings: Vec<Finding> = (0..cases)
        .map(|case| {
            let reference = trial(before, 1000 + case);
            let missions: Vec<(VehicleConfig, u64)> =
                (0..5).map(|k| (now.clone(), 100 * case + k)).collect();
            watch(&[reference], &missions).finding
        })
        .collect();
    [Finding::Changed, Finding::CannotTell]
        .map(|finding| findings.iter().filter(|found| **found == finding).count())
}

#[test]
fn recover_the_watch_is_quiet_over_a_sound_vehicle() {
    let [alarms, cannot_tell] = watch_alarms(6, ROUGH);
    println!("{alarms} alarms in 6 watches");
    // At a rate of 5 % more than 2 alarms happen once in 400 times.
    assert!(alarms <= 2, "{alarms}");
    assert_eq!(cannot_tell, 0);
}

/// The model of a trial is the one behind the rudder's lag; the windows of a mission are identified behind it, too.
#[test]
fn recover_the_watch_is_quiet_over_a_rudder_that_lags() {
    for lag_s in [0.1, 0.2] {
        let mut sound = vehicle([1.0; 3], CALM);
        sound.servo.time_constant_s = lag_s;
        let mut weaker = vehicle([1.0, 0.8, 1.0], CALM);
        weaker.servo.time_constant_s = lag_s;
        let [alarms, _] = watch_findings(6, &sound, &sound);
        let [seen, _] = watch_findings(3, &sound, &weaker);
        println!("{lag_s} s: {alarms} alarms in 6 watches, {seen} of 3 weaker rudders seen");
        // At a rate of 5 % more than 2 alarms happen once in 400 times.
        assert!(alarms <= 2, "{lag_s} s: {alarms}");
        assert_eq!(seen, 3, "{lag_s} s");
    }
}

/// Watches over a rudder that lags, sound and weaker by a fifth:
/// `cargo test --release -p seatrial --test suite -- health:: --ignored --nocapture`.
#[test]
#[ignore = "a study of several minutes"]
fn recover_watches_over_rudders_that_lag() {
    for sea in [CALM, ROUGH] {
        for lag_s in [0.0, 0.05, 0.1, 0.15, 0.2, 0.3] {
            let mut sound = vehicle([1.0; 3], sea);
            sound.servo.time_constant_s = lag_s;
            let mut weaker = vehicle([1.0, 0.8, 1.0], sea);
            weaker.servo.time_constant_s = lag_s;
            let begun = std::time::Instant::now();
            let [alarms, cannot_tell] = watch_findings(40, &sound, &sound);
            let took_s = begun.elapsed().as_secs_f64();
            let [seen, _] = watch_findings(20, &sound, &weaker);
            println!(
                "{} rad/s^2, {lag_s} s: {alarms}/40 alarms, {cannot_tell}/40 cannot tell, {seen}/20 weaker seen, {took_s:.1} s",
                sea.disturbance_rad_s2
            );
            assert!(alarms <= 5, "{sea:?} {lag_s}: {alarms}");
        }
    }
}

#[test]
fn recover_the_watch_finds_when_the_rudder_became_weaker() {
    let (sound, damaged) = (vehicle([1.0; 3], ROUGH), vehicle([1.0, 0.75, 1.0], ROUGH));
    for case in 0..2 {
        let missions: Vec<(VehicleConfig, u64)> = (0..6)
            .map(|k| (if k < 3 { sound.clone() } else { damaged.clone() }, 50 + 10 * case + k))
            .collect();
        let report = watch(&[trial(&sound, case)], &missions);
        assert_eq!(report.finding, Finding::Changed, "{}", report.because);
        let since = &report.windows[report.since.unwrap()];
        println!("{}", report.because);
        // The last window before and the first after may each err.
        assert!(
            ["mission 3", "mission 4", "mission 5"].contains(&since.log.as_str()),
            "{}",
            since.log
        );
        // A 95 % interval, and an onset that may be a window early: no further off than its own width.
        let [low, high] = report.effects.unwrap().rudder.interval_95;
        let slack = high - low;
        assert!((low - slack..high + slack).contains(&-0.25), "{low} {high}");
    }
}

#[test]
fn recover_an_unexcited_mission_cannot_tell() {
    let config = vehicle([1.0; 3], CALM);
    let reference = Reference::new(vec![trial(&config, 1)]).unwrap();
    let mut watch = Watch::new(reference, settings()).unwrap();
    for still in [
        drive(&config, 2, 120.0, |_| Steering::Rudder(0.0)),
        drive(&config, 3, 120.0, |_| Steering::HoldHeading(0.0)),
        Record::default(),
    ] {
        watch.read("still", &still);
    }
    let report = watch.report();
    assert_eq!(report.finding, Finding::CannotTell, "{}", report.because);
    assert!(report.skipped[0].because.contains("rudder"), "{report:?}");
    // Both logs, whole.
    let skipped: f64 = report.skipped.iter().map(|s| s.duration_s).sum();
    assert!((skipped - report.read_s).abs() < 1e-6, "{skipped}");
}

#[test]
fn prop_a_clock_that_jumps_by_thirty_years_is_read_to_its_end() {
    let config = vehicle([1.0; 3], CALM);
    let mut watch =
        Watch::new(Reference::new(vec![trial(&config, 1)]).unwrap(), settings()).unwrap();
    let mut jumping = mission(&config, 5);
    let half = jumping.samples.len() / 2;
    jumping.samples[half..].iter_mut().for_each(|s| s.time_s += 1e9);
    watch.read("jumping", &jumping);
    let report = watch.report();
    assert!(report.windows.iter().any(|w| w.window.from_s > 1e9), "{report:?}");
    assert!(report.skipped[0].duration_s > 0.9e9);
}

#[test]
fn prop_other_speeds_are_scaled_or_left_out() {
    let sound = vehicle([1.0; 3], CALM);
    let at =
        |speed: f64| SpeedModel { thrust: None, surge_speed_m_s: Some(speed), ..trial(&sound, 1) };
    let reference = Reference::new(vec![at(1.63)]).unwrap();
    let far = compare(&reference, &[at(2.0)], &settings());
    assert_eq!(far.finding, Finding::CannotTell);
    assert!(far.because.contains("2.00 m/s"), "{far:?}");
    // The same model at a speed higher by 5 %: it should have been faster and stronger.
    let near = compare(&reference, &[at(1.63 * 1.05)], &settings());
    let effects = near.effects.unwrap();
    // (1/1.05, 1/1.05^2) by rounding.
    assert!((effects.damping.change - (1.0 / 1.05 - 1.0)).abs() < 1e-9);
    assert!((effects.rudder.change - (1.0 / 1.05_f64.powi(2) - 1.0)).abs() < 1e-9);
}

#[test]
fn prop_several_speeds_share_the_rate() {
    let sound = vehicle([1.0; 3], CALM);
    let at = |speed: f64, seed: u64, factor: f64| {
        let model = trial(&sound, seed);
        SpeedModel {
            thrust: None,
            surge_speed_m_s: Some(speed),
            model: seatrial_core::YawModel {
                b2_per_s2: model.model.b2_per_s2 * factor,
                ..model.model
            },
            ..model
        }
    };
    let reference = Reference::new(vec![at(1.0, 1, 1.0), at(2.0, 2, 1.0)]).unwrap();
    let same = compare(&reference, &[at(1.0, 3, 1.0), at(2.0, 4, 1.0)], &settings());
    assert_eq!(same.finding, Finding::Unchanged, "{}", same.because);
    assert_eq!(same.speeds[0].level, 0.0125);
    assert_eq!(same.together.unwrap().level, 0.025);
    // Weaker at one speed and stronger at the other: together nothing.
    let crossed = compare(&reference, &[at(1.0, 3, 0.75), at(2.0, 4, 1.25)], &settings());
    assert_eq!(crossed.finding, Finding::Changed);
}

/// Settings that are no rate, and models that are no reference.
#[test]
fn io_bad_settings_and_references_are_named() {
    for (rate, tolerated, named) in [
        (0.0, 0.0, "false alarm rate"),
        (f64::NAN, 0.0, "false alarm rate"),
        (0.05, -0.1, "tolerated change"),
    ] {
        let error = HealthSettings::new(rate, tolerated, true).unwrap_err();
        assert!(error.to_string().contains(named), "{error}");
    }
    let model = trial(&vehicle([1.0; 3], CALM), 1);
    assert!(Reference::new(Vec::new()).is_err());
    let twice = Reference::new(vec![model, model]).unwrap_err();
    assert!(twice.to_string().contains("two points"), "{twice}");
    let without_speed = |thrust| SpeedModel { thrust, surge_speed_m_s: None, ..model };
    let by_thrust = Reference::new(vec![without_speed(Some(0.6)), without_speed(Some(0.8))]);
    let same = compare(&by_thrust.unwrap(), &[without_speed(Some(0.8))], &settings());
    assert_eq!(same.finding, Finding::Unchanged);
    let unknown = Reference::new(vec![without_speed(None), without_speed(None)]).unwrap_err();
    assert!(unknown.to_string().contains("neither speed nor thrust"), "{unknown}");
}

/// The rates over noise and disturbance: `cargo test --release -p seatrial --test suite -- health:: --ignored --nocapture`.
#[test]
#[ignore = "a study of several minutes"]
fn recover_rates_over_noise_and_disturbance() {
    println!(
        "noise deg, disturbance rad/s^2, s: false alarms %, 20 % weaker rudder %, 20 % more inertia %, watches with an alarm, that cannot tell"
    );
    for compass_noise_deg in [0.2, 0.5, 1.0] {
        for (disturbance_rad_s2, disturbance_s) in
            [(0.0, 1.0), (0.003, 2.0), (0.005, 0.5), (0.01, 2.0)]
        {
            let sea = Sea { compass_noise_deg, disturbance_rad_s2, disturbance_s };
            let sound = vehicle([1.0; 3], sea);
            let alarms = false_alarm_rate(600, sea);
            let share = |factors| changed_share(50, &sound, &vehicle(factors, sea), |_| ());
            let (weaker, heavier) = (share([1.0, 0.8, 1.0]), share([1.0 / 1.2; 3]));
            let [watches, cannot_tell] = watch_alarms(60, sea);
            println!(
                "{compass_noise_deg} {disturbance_rad_s2} {disturbance_s}: {:.1} {:.1} {:.1} {watches}/60 {cannot_tell}/60",
                100.0 * alarms,
                100.0 * weaker,
                100.0 * heavier
            );
            assert!(alarms <= 0.08, "{sea:?}: {alarms}");
        }
    }
}
