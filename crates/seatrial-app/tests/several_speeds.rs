//! A log of several speeds is judged as a whole.

use std::fmt::Write as _;
use std::path::Path;

use seatrial::identification::{Outcome, ReasonCode};
use seatrial::identify::{IdentifySettings, ValidationData, identify_joined};
use seatrial_app::identify_log::{IdentifiedLog, Options, identify_log};
use seatrial_app::simulated_log::play;
use seatrial_core::{List, Plan, Sample};
use seatrial_sim::{FirstOrderVehicle, SimulatedVehicle, VehicleConfig};

/// A log with the trials of both vehicles at their thrusts, one after the other.
fn identified(trials: [(f64, VehicleConfig); 2], folder: &Path) -> IdentifiedLog {
    let mut text = String::from("time_s,heading_rad,rudder_rad,surge_speed_m_s\n");
    let mut start_s = 0.0;
    for (seed, (thrust, config)) in (1..).zip(trials) {
        let plan = Plan {
            thrusts: List::from_slice(&[thrust]).unwrap(),
            ..Plan::paper()
        };
        let vehicle = FirstOrderVehicle::new(config, seed).unwrap();
        let mut vehicle = SimulatedVehicle::FirstOrder(Box::new(vehicle));
        let samples: Vec<Sample<f64>> = play(&mut vehicle, plan).unwrap().samples;
        for sample in &samples {
            let speed_m_s = sample.surge_speed_m_s.unwrap();
            let time_s = start_s + sample.time_s;
            let (heading_rad, rudder_rad) = (sample.heading_rad, sample.rudder_rad);
            writeln!(text, "{time_s},{heading_rad},{rudder_rad},{speed_m_s}").unwrap();
        }
        start_s += samples.last().unwrap().time_s + 0.05;
    }
    let path = folder.join("two_speeds.csv");
    std::fs::write(&path, text).unwrap();
    identify_log(&path, &Options::default()).unwrap()
}

/// A fin that broke between two speeds leaves each model sound by itself.
#[test]
fn recover_a_fin_that_broke_between_two_speeds_of_a_log() {
    let folder = tempfile::tempdir().unwrap();
    let sound = VehicleConfig::starfish();
    let mut broken = sound.clone();
    for point in &mut broken.speeds {
        point.b2_per_s2 *= 0.25;
    }

    let log = identified([(0.6, sound.clone()), (1.0, sound.clone())], folder.path());
    assert_eq!(log.models.as_ref().map(Vec::len), Some(2));
    assert!(log.verdict().accepted, "{:?}", log.verdict());

    let log = identified([(0.6, sound), (1.0, broken)], folder.path());
    let models = log.models.as_deref().unwrap();
    assert_eq!(models.len(), 2);
    for verdict in models.iter().map(|m| &m.verdict).chain([log.verdict()]) {
        assert_eq!(verdict.outcome(), Outcome::DoNotUse);
        assert_eq!(verdict.reasons[0].code, ReasonCode::AuthorityChanged);
    }
}

/// Speeds are identified on all cores, of a record that is looked through once: each model is the one that its windows give alone.
#[test]
fn parity_speeds_identified_together_and_alone() {
    let folder = tempfile::tempdir().unwrap();
    let sound = VehicleConfig::starfish();
    let log = identified([(0.6, sound.clone()), (1.0, sound)], folder.path());
    let record = &log.logs.log.record;
    let models = log.models.as_deref().unwrap();
    assert_eq!(models.len(), 2);
    // Slowest first, as they are proposed.
    assert!(models[0].surge_speed_m_s < models[1].surge_speed_m_s);
    for model in models {
        let windows = &model.windows;
        let held_out = windows
            .validation
            .map(|window| ValidationData { record, window });
        let settings = IdentifySettings::default();
        let (alone, joined) =
            identify_joined(record, &windows.training, held_out, &settings).unwrap();
        assert_eq!(model.joined, joined);
        assert_eq!(model.identification.as_ref(), Some(&alone));
    }
}
