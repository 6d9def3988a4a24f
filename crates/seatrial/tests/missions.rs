//! Models from ordinary steering under an autopilot.

use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use seatrial::identification::{EstimateMethod, ReasonCode};
use seatrial::identify::mission::is_ordinary_steering;
use seatrial::identify::{IdentifySettings, identify};
use seatrial::likelihood::Parameter;
use seatrial::{GainAllowance, Identification, Record, Sample, Window};

const A22_PER_S: f64 = -0.8;
const B2_PER_S2: f64 = 0.7;
const INTERVAL_S: f64 = 0.1;
const STEP_S: f64 = 0.002;

/// Damping that grows with the turn, 1/rad, yaw moment per sway, 1/s^2, and time constant of sway, s.
#[derive(Clone, Copy)]
struct Hull {
    quadratic_per_rad: f64,
    coupling_per_s2: f64,
    sway_s: f64,
}

const FIRST_ORDER: Hull = Hull { quadratic_per_rad: 0.0, coupling_per_s2: 0.0, sway_s: 1.0 };

/// Six minutes with a new course every 20 s, under a rudder that lags and in a sea; 10 Hz, compass 0.3 deg, gyro 0.2 deg/s.
fn mission(seed: u64, lag_s: f64, sea_rad_s2: f64) -> Record {
    mission_of(FIRST_ORDER, seed, lag_s, sea_rad_s2)
}

fn mission_of(hull: Hull, seed: u64, lag_s: f64, sea_rad_s2: f64) -> Record {
    let mut sway = 0.0;
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let mut normal = move || -> f64 { StandardNormal.sample(&mut rng) };
    let mut courses = Pcg64Mcg::seed_from_u64(seed + 1);
    let (mut heading, mut rate, mut act, mut sea, mut course) = (0.0, 0.0, 0.0, 0.0, 0.0);
    let mut record = Record::default();
    for k in 0..3600 {
        if k % 200 == 100 {
            course += courses.random_range(-1.5..1.5);
        }
        let seen = heading + 0.3_f64.to_radians() * normal();
        let gyro = rate + 0.2_f64.to_radians() * normal();
        let rudder = (1.2 * (course - seen) - 1.0 * gyro).clamp(-0.5, 0.5);
        record.samples.push(Sample {
            time_s: INTERVAL_S * f64::from(k),
            heading_rad: seen,
            rudder_rad: rudder,
            yaw_rate_rad_s: Some(gyro),
            ..Sample::default()
        });
        for _ in 0..50 {
            let share = if lag_s > 0.0 { 1.0 - (-STEP_S / lag_s).exp() } else { 1.0 };
            act += share * (rudder - act);
            sea += -0.5 * sea * STEP_S + sea_rad_s2 * STEP_S.sqrt() * normal();
            let of_hull = hull.coupling_per_s2 * sway - hull.quadratic_per_rad * rate * rate.abs();
            sway += STEP_S * (rate - sway / hull.sway_s);
            rate += STEP_S * (A22_PER_S * rate + of_hull + B2_PER_S2 * (act + 0.02) + sea);
            heading += STEP_S * rate;
        }
    }
    record
}

fn identified(record: &Record) -> Identification {
    identify(record, Window::ALL, None, &IdentifySettings::default()).unwrap()
}

/// How far the truth lies from the middle of an interval, in half widths.
fn half_widths([low, high]: [f64; 2], truth: f64) -> f64 {
    ((2.0 * truth - low - high) / (high - low)).abs()
}

fn distances(found: &Identification) -> [f64; 2] {
    let intervals = found.refined.as_ref().unwrap().interval_95;
    [half_widths(intervals.a22_per_s, A22_PER_S), half_widths(intervals.b2_per_s2, B2_PER_S2)]
}

/// Of 16 intervals of 95 % one or two may miss the truth by chance, by little.
#[test]
fn recover_a_model_from_ordinary_steering() {
    let mut hold = 0;
    for seed in 1..=8 {
        let lag_s = if seed % 2 == 0 { 0.2 } else { 0.0 };
        let record = mission(seed, lag_s, if seed % 4 < 2 { 0.0 } else { 0.02 });
        assert!(is_ordinary_steering(&record.samples));
        let found = identified(&record);
        assert!(found.verdict.accepted, "{seed} {:?}", found.verdict);
        let distances = distances(&found);
        assert!(distances.iter().all(|d| *d < 2.0), "{seed} {distances:?}");
        hold += distances.iter().filter(|d| **d < 1.0).count();
        if lag_s > 0.0 {
            assert_eq!(*found.method(), EstimateMethod::RudderLag, "{seed}");
            let delay_s = found.lagging().unwrap().rudder_lag_s;
            assert!((delay_s - lag_s).abs() < 0.05, "{seed} {delay_s}");
        }
    }
    assert!(hold >= 14, "{hold}");
}

/// Course changes do not last until a turn is steady: in the long run a first-order model of them turns too slowly here by more than a twentieth.
#[test]
fn recover_the_steady_turn_of_a_hull_beyond_first_order() {
    const RUDDER_RAD: f64 = 0.3;
    let growing = Hull { quadratic_per_rad: 3.0, ..FIRST_ORDER };
    let swaying = Hull { coupling_per_s2: 0.15, sway_s: 2.5, ..FIRST_ORDER };
    let push = B2_PER_S2 * RUDDER_RAD;
    let root = (A22_PER_S * A22_PER_S + 4.0 * 3.0 * push).sqrt();
    for (hull, steady_rad_s) in
        [(growing, (root + A22_PER_S) / (2.0 * 3.0)), (swaying, push / (-A22_PER_S - 0.15 * 2.5))]
    {
        let found = identified(&mission_of(hull, 3, 0.0, 0.005));
        assert!(found.verdict.accepted, "{:?}", found.verdict);
        let [log_gain, variance] = found.steady_turn().unwrap().log_gain_at(RUDDER_RAD);
        let away = (steady_rad_s / RUDDER_RAD).ln() - log_gain;
        assert!(away.abs() < 1.96 * variance.sqrt(), "{away} {variance}");
        let own = found.model();
        let of_first_order = (-own.b2_per_s2 / own.a22_per_s).ln();
        let missed = (steady_rad_s / RUDDER_RAD).ln() - of_first_order;
        assert!(missed.abs() > 0.05, "{missed}");
        let structure = found.higher_order.unwrap().structure;
        assert_eq!(structure.has(Parameter::Coupling), hull.coupling_per_s2 > 0.0);
        assert_eq!(structure.has(Parameter::Quadratic), hull.quadratic_per_rad > 0.0);
    }
    // A boat of first order has no other turn.
    let found = identified(&mission(3, 0.0, 0.005));
    assert!(found.steady_turn().is_none(), "{found:?}");
}

/// An autopilot with a rate gain holds a course-unstable boat; the proportional gain that is handed out would not.
#[test]
fn recover_that_no_gain_holds_a_course_unstable_boat() {
    let unstable = Hull { quadratic_per_rad: 1.0, coupling_per_s2: 0.4, sway_s: 2.5 };
    let found = identified(&mission_of(unstable, 4, 0.0, 0.005));
    let gain = GainAllowance::of(&found).design(&found.model(), 0.7);
    assert!(gain.is_err(), "{gain:?} {:?}", found.verdict);
    assert!(found.verdict.has(&ReasonCode::Unstable));
    let stable = identified(&mission(4, 0.0, 0.005));
    let gain = GainAllowance::of(&stable).design(&stable.model(), 0.7);
    assert!(gain.is_ok(), "{:?}", stable.verdict);
}

#[test]
fn prop_a_transit_without_turns_is_refused_with_what_is_missing() {
    let mut record = mission(5, 0.0, 0.0);
    let mut rng = Pcg64Mcg::seed_from_u64(9);
    for sample in &mut record.samples {
        let noise: f64 = StandardNormal.sample(&mut rng);
        sample.heading_rad = 0.005 * noise;
        sample.yaw_rate_rad_s = None;
        sample.rudder_rad = -1.2 * sample.heading_rad;
    }
    let found = identified(&record);
    assert!(!found.verdict.accepted, "{:?}", found.verdict);
}

#[test]
fn prop_a_stop_and_a_gap_are_cut_out() {
    let mut record = mission(6, 0.0, 0.0);
    for sample in &mut record.samples {
        sample.surge_speed_m_s = Some(1.5);
    }
    // At anchor the heading swings without the rudder; then the recorder fails for half a minute.
    for (k, sample) in record.samples[1000..1600].iter_mut().enumerate() {
        sample.surge_speed_m_s = Some(0.02);
        sample.heading_rad += (0.01 * k as f64).sin();
    }
    record.samples.drain(2000..2300);
    let found = identified(&record);
    assert!(found.verdict.accepted, "{:?}", found.verdict);
    assert!(distances(&found).iter().all(|d| *d < 2.0), "{found:?}");
    let reasons = &found.verdict.reasons;
    let used = reasons.iter().find(|reason| reason.code == ReasonCode::Ok).unwrap();
    assert!(used.measured().contains("of the log was used"), "{}", used.measured());
}

#[test]
fn exact_a_zig_zag_is_no_ordinary_steering() {
    let samples: Vec<Sample<f64>> = (0..2000)
        .map(|k| Sample {
            time_s: 0.1 * f64::from(k),
            rudder_rad: if (k / 100) % 2 == 0 { 0.2 } else { -0.2 },
            ..Sample::default()
        })
        .collect();
    assert!(!is_ordinary_steering(&samples));
}

/// Autopilots of course-unstable boats go from stop to stop: two of sixty such missions were taken for a manoeuvre and got a gain that swings.
#[test]
fn regress_an_autopilot_that_goes_from_stop_to_stop_makes_no_manoeuvre() {
    let steered = |strokes: usize| -> Vec<Sample<f64>> {
        let turn = core::f64::consts::PI / 40.0;
        (0..40 * strokes)
            .map(|k| Sample {
                time_s: 0.1 * k as f64,
                rudder_rad: (2.0 * (turn * k as f64).sin()).clamp(-0.5, 0.5),
                ..Sample::default()
            })
            .collect()
    };
    assert!(is_ordinary_steering(&steered(60)));
    assert!(!is_ordinary_steering(&steered(12)));
}
