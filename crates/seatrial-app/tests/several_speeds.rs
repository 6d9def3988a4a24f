//! A log of several speeds is judged as a whole.

use std::fmt::Write as _;
use std::path::Path;

use seatrial::identification::{Intervals, Outcome, ReasonCode, Subject};
use seatrial::identify::{IdentifySettings, ValidationData, identify_joined};
use seatrial_app::identify_log::{IdentifiedLog, Options, identify_log};
use seatrial_app::models::Models;
use seatrial_app::simulated_log::play;
use seatrial_app::trials::order::rehearse;
use seatrial_core::excitation::Excitation;
use seatrial_core::{List, Plan, Sample};
use seatrial_sim::{FaultyVehicle, FirstOrderVehicle, Scenario, SimulatedVehicle, VehicleConfig};

/// A log with the trials of both vehicles at their thrusts, one after the other.
fn identified(trials: [(f64, VehicleConfig); 2], folder: &Path) -> IdentifiedLog {
    of_plans(trials.map(|(thrust, config)| (at(thrust), config)), folder)
}

/// The paper's plan at one thrust.
fn at(thrust: f64) -> Plan<f64> {
    Plan { thrusts: List::from_slice(&[thrust]).unwrap(), ..Plan::paper() }
}

/// A log with the trials of vehicles by their plans, one after the other.
fn of_plans(
    trials: impl IntoIterator<Item = (Plan<f64>, VehicleConfig)>,
    folder: &Path,
) -> IdentifiedLog {
    let mut text = String::from("time_s,heading_rad,rudder_rad,surge_speed_m_s\n");
    let mut start_s = 0.0;
    for (seed, (plan, config)) in (1..).zip(trials) {
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
        assert_eq!(verdict.reasons[0].kind(), ReasonCode::SpeedsDiffer.of(Subject::Rudder));
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
        let held_out = windows.validation.map(|window| ValidationData { record, window });
        let settings = IdentifySettings::default();
        let (alone, joined) =
            identify_joined(record, &windows.training, held_out, &settings).unwrap();
        assert_eq!(model.joined, joined);
        assert_eq!(model.identification.as_ref(), Some(&alone));
    }
}

/// Of five speeds three have half the rudder: they are nearly as well known as with all of it, and gains come from what is shared.
#[test]
fn recover_speeds_with_little_excitation_borrow_from_the_others() {
    let folder = tempfile::tempdir().unwrap();
    let mut config = VehicleConfig::starfish();
    for point in &mut config.speeds {
        let speed_m_s = point.surge_speed_m_s;
        point.a22_per_s = -(0.3 + 0.5 * speed_m_s);
        point.b2_per_s2 = 0.4 * speed_m_s * speed_m_s;
    }
    let thrusts = [0.6, 0.7, 0.8, 0.9, 1.0];
    let log = |share: f64| {
        let weaker = thrusts.into_iter().zip([share, 1.0].into_iter().cycle());
        let plans = weaker.map(|(thrust, share)| {
            let mut plan = at(thrust);
            for manoeuvre in [&mut plan.training, &mut plan.validation] {
                manoeuvre.excitation = Excitation::Doublet {
                    amplitude_rad: share * manoeuvre.excitation.amplitude_rad(),
                    period_s: 4.0,
                };
            }
            (plan, config.clone())
        });
        of_plans(plans, folder.path())
    };
    let (full, weak) = (log(1.0), log(0.5));
    let law = weak.law.unwrap();
    for (coefficient, truth) in [(law.d0_per_s, 0.3), (law.d1_per_m, 0.5)] {
        let [low, high] = coefficient.interval_95;
        assert!((low..=high).contains(&truth), "{law:?}");
    }
    let models = |log: &IdentifiedLog| log.models.clone().unwrap();
    let width = |[low, high]: [f64; 2]| high - low;
    let mut ratios = Vec::new();
    for (weak, full) in models(&weak).iter().zip(&models(&full)).step_by(2) {
        let own = &full.own.as_ref().unwrap().interval_95;
        let alone = &weak.own.as_ref().unwrap().interval_95;
        let refined = weak.identification.as_ref().unwrap().refined.clone().unwrap();
        let speed_m_s = weak.surge_speed_m_s.unwrap();
        let found = &refined.interval_95;
        for of in [|i: &Intervals| i.a22_per_s, |i: &Intervals| i.b2_per_s2] {
            assert!(width(of(found)) < 0.8 * width(of(alone)), "{found:?}");
            ratios.push(width(of(found)) / width(of(own)));
        }
        let truth = -(0.3 + 0.5 * speed_m_s);
        let [low, high] = found.a22_per_s;
        assert!((low..=high).contains(&truth), "{truth}: {found:?}");
    }
    let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
    assert!(mean < 1.2, "{ratios:?}");
    let handed_over = Models::of_log(&weak, None).unwrap();
    for (point, model) in handed_over.points.iter().zip(models(&weak)) {
        let refined = model.identification.unwrap().refined.unwrap();
        assert_eq!(point.point.model, refined.model);
    }
}

/// Each model holds on its own validation data, and no pair of speeds parts far enough.
#[test]
fn recover_another_load_in_mid_campaign() {
    let loads_changed = |scenario: &Scenario| {
        let of_seed = |seed| {
            let vehicle = FirstOrderVehicle::new(VehicleConfig::starfish(), seed).unwrap();
            let mut vehicle = FaultyVehicle::new(vehicle, scenario, seed).unwrap();
            let campaign = rehearse(&mut vehicle, "", seed, Plan::paper()).unwrap().campaign;
            let verdict = campaign.verdict();
            verdict.has(ReasonCode::SpeedsDiffer.of(Subject::Damping))
                && verdict.outcome() != Outcome::Use
        };
        (1..=20).filter(|seed| of_seed(*seed)).count()
    };
    let swapped = Scenario::load(Path::new("payload_swap")).unwrap();
    assert!(loads_changed(&swapped) >= 19);
    assert_eq!(loads_changed(&Scenario::default()), 0);
}
