//! A record that is looked through once for several windows.

use std::f64::consts::TAU;
use std::time::{Duration, Instant};

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use seatrial::identify::{
    IdentifySettings, RecordSurvey, ValidationData, identify, identify_joined,
};
use seatrial::{Record, Window};
use seatrial_core::Sample;

const INTERVAL_S: f64 = 0.05;
/// Rest, a doublet of 2 s a side, and its response.
const MANOEUVRE_S: f64 = 20.0;
const WINDOWS: [Window; 3] = [window(0.0), window(1.0), window(2.0)];

const fn window(turn: f64) -> Window {
    Window { from_s: turn * MANOEUVRE_S, to_s: (turn + 1.0) * MANOEUVRE_S }
}

/// Three doublets of a vehicle with a22 = -0.9 and b2 = 2, followed by rest up to so many rows; compass noise of 0.1 deg.
fn record(rows: usize) -> Record {
    let (mut heading_rad, mut rate) = (0.5_f64, 0.0);
    let decay = (-0.9 * INTERVAL_S).exp();
    let mut random = Pcg64::seed_from_u64(1);
    let mut noise = || -> f64 { StandardNormal.sample(&mut random) };
    (0..rows)
        .map(|row| {
            let time_s = row as f64 * INTERVAL_S;
            let rudder_rad = match time_s % MANOEUVRE_S {
                _ if time_s >= 3.0 * MANOEUVRE_S => 0.0,
                t if (6.0..8.0).contains(&t) => 0.2,
                t if (8.0..10.0).contains(&t) => -0.2,
                _ => 0.0,
            };
            let sample = Sample {
                time_s,
                heading_rad: (heading_rad + 0.1_f64.to_radians() * noise()).rem_euclid(TAU),
                rudder_rad,
                ..Sample::default()
            };
            // Exact over an interval in which the rudder stands still.
            let steady = 2.0 / 0.9 * rudder_rad;
            heading_rad += steady * INTERVAL_S + (rate - steady) * (1.0 - decay) / 0.9;
            rate = steady + (rate - steady) * decay;
            sample
        })
        .collect()
}

fn least_time(mut work: impl FnMut()) -> Duration {
    let timed = (0..5).map(|_| {
        let began = Instant::now();
        work();
        began.elapsed()
    });
    // The least: what else the machine does only adds.
    timed.min().unwrap()
}

#[test]
fn parity_the_answers_of_an_examined_record() {
    let record = record(2_000);
    let settings = IdentifySettings::default();
    let held_out = Some(ValidationData { record: &record, window: WINDOWS[2] });
    let examined = RecordSurvey::of(&record);
    assert_eq!(
        examined.identify(WINDOWS[0], held_out, &settings).unwrap(),
        identify(&record, WINDOWS[0], held_out, &settings).unwrap()
    );
    assert_eq!(
        examined.identify_joined(&WINDOWS[..2], held_out, &settings).unwrap(),
        identify_joined(&record, &WINDOWS[..2], held_out, &settings).unwrap()
    );
}

/// What a window costs does not grow with the record that it lies in. Looking through these rows at each call took ten times as long as the
/// estimates.
#[test]
fn prop_the_time_of_a_window_does_not_grow_with_the_record() {
    let [short, long] = [record(2_000), record(400_000)];
    let settings = IdentifySettings::default();
    let [short_s, long_s] = [&short, &long].map(|record| {
        let examined = RecordSurvey::of(record);
        let held_out = Some(ValidationData { record, window: WINDOWS[2] });
        least_time(|| {
            examined.identify_joined(&WINDOWS[..2], held_out, &settings).unwrap();
        })
        .as_secs_f64()
    });
    println!("{short_s:.4} s in a record of 2,000 rows, {long_s:.4} s in one of 400,000");
    // Twice for what a busy machine does to the least of five.
    assert!(long_s < 2.0 * short_s, "{short_s} {long_s}");
}
