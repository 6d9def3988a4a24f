//! The drift recipe of docs/fleet.md on an unchanged vehicle: how often are two halves of its manoeuvres called different?

use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_pcg::Pcg64;
use seatrial::identify::{IdentifySettings, identify};
use seatrial::{Record, Window};
use seatrial_core::{Action, Sample, Steering, Vehicle};
use seatrial_sim::{FirstOrderVehicle, Truth, VehicleConfig};

/// Thrusts of the paper's plan.
const THRUSTS: [f64; 5] = [0.6, 0.7, 0.8, 0.9, 1.0];
/// Manoeuvres at each thrust.
const MANOEUVRES: u64 = 12;
/// Random halves.
const HALVES: usize = 400;

/// A row of the recipe.
#[derive(Clone, Copy, Debug)]
struct Row {
    class: usize,
    surge_speed_m_s: f64,
    b2_per_s2: f64,
    half_width: f64,
}

/// A doublet of the paper's vehicle with its noise, 21 s at a thrust, and what is true of it there.
pub fn doublet(thrust: f64, seed: u64) -> (Record, Truth) {
    let mut config = VehicleConfig::starfish();
    config.initial_thrust = thrust;
    let mut vehicle = FirstOrderVehicle::new(config, seed).unwrap();
    let truth = vehicle.truth(thrust);
    let mut samples: Vec<Sample<f64>> = Vec::new();
    while samples.len() < 420 {
        let sample = vehicle.next_sample().unwrap().unwrap();
        samples.push(sample);
        let steering = match sample.time_s {
            t if (7.0..9.0).contains(&t) => Steering::Rudder(0.26),
            t if (9.0..11.0).contains(&t) => Steering::Rudder(-0.26),
            _ => Steering::HoldHeading(0.0),
        };
        let action = Action { steering, thrust: Some(thrust), outcome: None };
        vehicle.act(&action).unwrap();
    }
    (samples.into_iter().collect(), truth)
}

fn row(class: usize, seed: u64) -> Option<Row> {
    let (record, Truth { surge_speed_m_s, .. }) = doublet(THRUSTS[class], seed);
    let training = Window { from_s: 5.0, to_s: 21.0 };
    let found = identify(&record, training, None, &IdentifySettings::default()).ok()?;
    let refined = found.refined?;
    let [low, high] = refined.interval_95.b2_per_s2;
    Some(Row {
        class,
        surge_speed_m_s,
        b2_per_s2: refined.model.b2_per_s2,
        half_width: 0.5 * (high - low),
    })
}

/// Weighted mean, and the half width of its 95 % interval.
fn mean(values: impl Iterator<Item = (f64, f64)>) -> (f64, f64) {
    let (mut sum, mut weights) = (0.0, 0.0);
    for (value, weight) in values {
        sum += value * weight;
        weights += weight;
    }
    (sum / weights, weights.powf(-0.5))
}

fn weight(row: &Row) -> f64 {
    (row.b2_per_s2 / row.half_width).powi(2)
}

fn per_square(row: &Row) -> f64 {
    row.b2_per_s2 / row.surge_speed_m_s.powi(2)
}

/// The share of random halves whose authorities differ by more than both half widths together.
fn false_alarms(rows: &[Row], authority: impl Fn(&Row) -> f64) -> f64 {
    let mut chance = Pcg64::seed_from_u64(1);
    let mut shuffled = rows.to_vec();
    let alarms = (0..HALVES).filter(|_| {
        shuffled.shuffle(&mut chance);
        let (one, other) = shuffled.split_at(rows.len() / 2);
        let of = |half: &[Row]| mean(half.iter().map(|row| (authority(row), weight(row))));
        let ((one, width), (other, other_width)) = (of(one), of(other));
        (one - other).abs() > width.hypot(other_width)
    });
    alarms.count() as f64 / HALVES as f64
}

#[test]
fn recover_the_drift_recipe_keeps_its_false_alarm_rate() {
    let rows: Vec<Row> = (0..THRUSTS.len())
        .flat_map(|class| {
            (0..MANOEUVRES).filter_map(move |k| row(class, 1 + 100 * k + class as u64))
        })
        .collect();
    assert!(rows.len() >= 55, "{}", rows.len());
    let of_class = |class: usize| {
        let same = rows.iter().filter(move |row| row.class == class);
        mean(same.map(|row| (per_square(row), weight(row)))).0
    };
    let means: Vec<f64> = (0..THRUSTS.len()).map(of_class).collect();
    let rate = false_alarms(&rows, |row| per_square(row) / means[row.class]);
    // Stated: 5 %. Sixty rows know their own scatter to 10 %, which is 2 % of the rate, and the intervals are not too
    // narrow; halves of the same rows are no new chance.
    assert!(rate < 0.09, "{rate}");
}
