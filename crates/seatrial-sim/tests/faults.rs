//! Faults on simulated vehicles.

use std::collections::HashSet;
use std::path::Path;

use seatrial_core::{Action, List, Outcome, Plan, Sample, Steering, Trial, Vehicle};
use seatrial_sim::faults::{Fault, Kind, Onset, Rehearsable};
use seatrial_sim::six_dof::starfish;
use seatrial_sim::{FaultyVehicle, FirstOrderVehicle, Scenario, SixDofVehicle, VehicleConfig};

fn first_order(seed: u64) -> FirstOrderVehicle {
    FirstOrderVehicle::new(VehicleConfig::starfish(), seed).unwrap()
}

fn at(kind: Kind, values: [f64; 2], at_s: f64, for_s: Option<f64>) -> Scenario {
    Scenario::of(Fault { kind, values, onset: Onset::Time(at_s), for_s })
}

/// Samples of a vehicle with its rudder held.
fn taken<V: Rehearsable>(vehicle: V, scenario: &Scenario, count: usize) -> Vec<Sample<f64>> {
    let mut vehicle = FaultyVehicle::new(vehicle, scenario, 1).unwrap();
    std::iter::from_fn(|| {
        let sample = vehicle.next_sample().ok()??;
        let action = Action { steering: Steering::Rudder(0.1), thrust: Some(0.8), outcome: None };
        vehicle.act(&action).unwrap();
        Some(sample)
    })
    .take(count)
    .collect()
}

/// 20 s of the exact vehicle, with and without a fault from 5 s to 10 s.
fn pair(kind: Kind, values: [f64; 2]) -> [Vec<Sample<f64>>; 2] {
    let config = VehicleConfig::starfish().noise_free();
    let exact = || FirstOrderVehicle::new(config.clone(), 1).unwrap();
    [Scenario::default(), at(kind, values, 5.0, Some(5.0))]
        .map(|scenario| taken(exact(), &scenario, 400))
}

#[test]
fn prop_without_faults_the_samples_are_the_vehicles_own() {
    let mut plain = first_order(3);
    let mut faulty = FaultyVehicle::new(first_order(3), &Scenario::default(), 3).unwrap();
    for _ in 0..500 {
        let Ok(expected) = plain.next_sample();
        assert_eq!(faulty.next_sample().unwrap(), expected);
    }
}

#[test]
fn exact_the_compass() {
    let [sound, frozen] = pair(Kind::CompassFreeze, [0.0; 2]);
    assert_eq!(frozen[..=100], sound[..=100]);
    assert!(frozen[101..=200].iter().all(|s| s.heading_rad == sound[100].heading_rad));
    assert_eq!(frozen[201..], sound[201..]);

    let [sound, lost] = pair(Kind::CompassDropout, [0.0; 2]);
    assert!(lost[101..=200].iter().all(|s| s.heading_rad.is_nan()));
    assert_eq!(lost[201..], sound[201..]);

    // 1e-12: the rounding of some headings of a few radians.
    let off = |sound: &[Sample<f64>], faulty: &[Sample<f64>], k: usize, expected: f64| {
        let error = seatrial_core::Real::wrapped(faulty[k].heading_rad - sound[k].heading_rad);
        assert!((error - expected).abs() < 1e-12, "{k}: {error}");
    };
    let [sound, stepped] = pair(Kind::CompassStep, [0.3, 0.0]);
    let [_, drifting] = pair(Kind::CompassDrift, [0.02, 0.0]);
    let [_, spiky] = pair(Kind::CompassSpike, [0.5, 1.0]);
    for k in [101, 150, 200] {
        off(&sound, &stepped, k, 0.3);
        off(&sound, &drifting, k, 0.02 * 0.05 * (k - 101) as f64);
    }
    let spikes: Vec<usize> =
        (0..400).filter(|&k| sound[k].heading_rad != spiky[k].heading_rad).collect();
    assert_eq!(spikes, [101, 121, 141, 161, 181]);
    off(&sound, &spiky, 121, 0.5);
}

#[test]
fn exact_the_rudder_says_what_was_commanded() {
    for (kind, values, fin_rad) in
        [(Kind::RudderOffset, [0.05, 0.0], 0.15), (Kind::RudderReversed, [0.0; 2], -0.1)]
    {
        let [sound, faulty] = pair(kind, values);
        assert_eq!(sound[150].rudder_rad, faulty[150].rudder_rad);
        // b2 at 60 % and 80 %: within 5 s the speed is 7 % short of the latter's.
        let accelerated = |samples: &[Sample<f64>]| {
            (samples[101].yaw_rate_rad_s.unwrap() - samples[100].yaw_rate_rad_s.unwrap()) / 0.05
        };
        let per_rad = (accelerated(&faulty) - accelerated(&sound)) / (fin_rad - 0.1);
        assert!((0.9..1.08).contains(&per_rad), "{kind:?} {per_rad}");
    }
    // Jammed at the angle it has, whatever is commanded after.
    let config = VehicleConfig::starfish().noise_free();
    let vehicle = FirstOrderVehicle::new(config, 1).unwrap();
    let scenario = at(Kind::RudderJam, [0.0; 2], 0.0, None);
    let jammed = taken(vehicle, &scenario, 100);
    assert_eq!(jammed[50].rudder_rad, 0.1);
    // It ran straight with the rudder that holds it so.
    assert!(jammed.iter().all(|s| s.yaw_rate_rad_s.unwrap().abs() < 0.01));
}

#[test]
fn exact_body_and_thrust() {
    let config = VehicleConfig::starfish();
    let truth = first_order(1).truth(0.6).model;
    let damaged = |kind, values| {
        let vehicle = FirstOrderVehicle::new(config.clone(), 1).unwrap();
        let mut vehicle = FaultyVehicle::new(vehicle, &at(kind, values, 0.0, None), 1).unwrap();
        vehicle.next_sample().unwrap();
        vehicle.apparent_yaw_model().unwrap()
    };
    let lost = damaged(Kind::LostFin, [0.25, 0.0]);
    assert!((lost.b2_per_s2 - 0.75 * truth.b2_per_s2).abs() < 1e-12);
    assert_eq!(lost.a22_per_s, truth.a22_per_s);
    let heavy = damaged(Kind::PayloadChange, [1.25, 0.0]);
    for (heavy, truth) in heavy.theta().iter().zip(truth.theta()) {
        assert!((heavy * 1.25 - truth).abs() < 1e-12);
    }
    let offset = damaged(Kind::RudderOffset, [0.1, 0.0]);
    let expected = truth.c0_rad_per_s2 + 0.1 * truth.b2_per_s2;
    assert!((offset.c0_rad_per_s2 - expected).abs() < 1e-12);
    let [_, weak] = pair(Kind::ThrustLoss, [0.25, 0.0]);
    let speed = |k: usize| weak[k].surge_speed_m_s.unwrap();
    // 60 % of thrust is 1.07 m/s; exp(-5/2) of the difference is left.
    assert!(speed(200) < speed(100) && (speed(200) - 1.07).abs() < 0.09);
}

#[test]
fn exact_the_link() {
    let [sound, jumped] = pair(Kind::ClockJump, [-0.7, 0.0]);
    assert!((jumped[150].time_s - sound[150].time_s + 0.7).abs() < 1e-12);
    assert_eq!(jumped[250], sound[250]);

    let [_, twice] = pair(Kind::DuplicatedSamples, [4.0, 0.0]);
    let repeats = twice.windows(2).filter(|w| w[0] == w[1]).count();
    assert_eq!(repeats, 25);

    let [sound, mixed] = pair(Kind::ReorderedSamples, [4.0, 0.0]);
    let backwards = mixed.windows(2).filter(|w| w[1].time_s < w[0].time_s).count();
    assert_eq!(backwards, 25);
    assert_eq!(mixed[250], sound[250]);

    let [_, gap] = pair(Kind::LinkLoss, [0.0; 2]);
    let longest = gap.windows(2).map(|w| w[1].time_s - w[0].time_s).fold(0.0, f64::max);
    assert!((longest - 5.05).abs() < 1e-9, "{longest}");
    let cut = taken(first_order(1), &at(Kind::LinkLoss, [0.0; 2], 5.0, None), 400);
    assert_eq!(cut.len(), 101);

    let [_, blind] = pair(Kind::DepthLoss, [0.0; 2]);
    assert_eq!(blind.iter().filter(|s| s.depth_m.is_none()).count(), 100);
}

#[test]
fn exact_the_operator_keeps_the_vehicle() {
    let scenario = at(Kind::OperatorTakeover, [0.0; 2], 5.0, None);
    let mut vehicle = FaultyVehicle::new(first_order(1), &scenario, 1).unwrap();
    for k in 0..300 {
        let sample = vehicle.next_sample().unwrap().unwrap();
        assert_eq!(vehicle.is_taken_over(), k > 100);
        let action = Action { steering: Steering::Rudder(0.2), thrust: Some(1.0), outcome: None };
        vehicle.act(&action).unwrap();
        assert_eq!(sample.rudder_rad == 0.2, (1..=100).contains(&k), "{k}");
    }
    // Its own 60 %.
    let speed_m_s = vehicle.vehicle().plant().surge_speed_m_s;
    assert!((speed_m_s - 1.07).abs() < 0.02, "{speed_m_s}");
}

#[test]
fn exact_six_degrees_of_freedom_lose_fins_and_drift() {
    let speed_over_ground = |scenario: &Scenario| {
        let vehicle = SixDofVehicle::new(starfish::config().noise_free(), 1).unwrap();
        let mut vehicle = FaultyVehicle::new(vehicle, scenario, 1).unwrap();
        let mut last = Sample::default();
        for _ in 0..600 {
            last = vehicle.next_sample().unwrap().unwrap();
        }
        (last.north_m.unwrap() / last.time_s, vehicle)
    };
    let (still, _) = speed_over_ground(&Scenario::default());
    let (carried, _) = speed_over_ground(&at(Kind::CurrentStep, [0.3, 0.0], 0.0, None));
    // The surge of 65 kg takes some seconds of the 30 s to follow the water.
    assert!((0.2..0.3).contains(&(carried - still)), "{still} {carried}");
    let config = starfish::config();
    let damage = seatrial_sim::faults::Damage {
        lost_rudder_area: 0.75,
        yaw_inertia_factor: 1.5,
        ..Default::default()
    };
    let damaged = config.damaged(&damage);
    let areas = [0, 1, 2].map(|k| damaged.fins[k].foil.area_m2 / config.fins[k].foil.area_m2);
    assert_eq!([areas[0], areas[2]], [0.0, 1.0]);
    assert!((areas[1] - 0.5).abs() < 1e-12);
    let inertia =
        |c: &seatrial_sim::SixDofConfig| c.rigid_body.inertia_kg_m2[2] + c.hull.added_mass[5];
    assert!((inertia(&damaged) / inertia(&config) - 1.5).abs() < 1e-12);
}

#[test]
fn exact_what_cannot_be_played_is_refused_by_name() {
    let scenario = at(Kind::CurrentStep, [0.3; 2], 5.0, None);
    let message = FaultyVehicle::new(first_order(1), &scenario, 1).unwrap_err().to_string();
    assert!(message.starts_with("fault 1, current_step: this vehicle cannot play it"), "{message}");
}

/// Every scenario of the repository plays on the vehicle that it is for; together they have every kind.
#[test]
fn io_every_scenario_plays() {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios"));
    let mut kinds = HashSet::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let scenario = Scenario::load(&path).unwrap();
        kinds.extend(scenario.faults.iter().map(|fault| fault.kind));
        let conditions = || scenario.conditions.clone();
        let outcome = VehicleConfig::starfish()
            .with(conditions())
            .ok()
            .map(|config| FirstOrderVehicle::new(config, 1).unwrap())
            .and_then(|vehicle| FaultyVehicle::new(vehicle, &scenario, 1).ok())
            .map(|vehicle| play(vehicle, &scenario))
            .unwrap_or_else(|| {
                let config = starfish::config().with(conditions()).unwrap();
                let vehicle = SixDofVehicle::new(config, 1).unwrap();
                play(FaultyVehicle::new(vehicle, &scenario, 1).unwrap(), &scenario)
            });
        println!("{}: {outcome:?}", path.display());
    }
    assert_eq!(kinds.len(), Kind::ALL.len());
}

/// The outcome of a trial at three speeds, in which every fault with a time began; `None`: the link broke.
fn play<V: Rehearsable>(mut vehicle: FaultyVehicle<V>, scenario: &Scenario) -> Option<Outcome> {
    let plan = Plan { thrusts: List::from_slice(&[0.6, 0.8, 1.0]).unwrap(), ..Plan::paper() };
    let mut trial = Trial::new(plan).unwrap();
    while let Ok(Some(sample)) = vehicle.next_sample() {
        let action = trial.step(&sample);
        vehicle.act(&action).unwrap();
        if action.outcome.is_some() {
            break;
        }
    }
    let conditions_only = scenario.faults.is_empty() && scenario.random.is_none();
    assert!(vehicle.first_fault_s().is_some() || conditions_only);
    trial.outcome()
}
