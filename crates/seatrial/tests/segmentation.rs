//! Manoeuvres in simulated missions, and the models that come of them.

use rand::RngExt;
use rand_distr::{Distribution, Normal};
use rand_pcg::Pcg64;
use seatrial::Record;
use seatrial::identification::Outcome;
use seatrial::identify::identify_joined;
use seatrial::identify::propose;
use seatrial::identify::{IdentifySettings, ValidationData};
use seatrial::log::segmentation::{Kind, Segment, find};
use seatrial_core::{Action, Sample, Steering, Vehicle};
use seatrial_sim::{FirstOrderVehicle, VehicleConfig};

/// What the vehicle is told at an instant: steering and thrust.
type Orders = (Steering<f64>, f64);

/// The STARFISH with 0.5 deg of compass noise under orders, from second 0 on.
fn mission(duration_s: f64, seed: u64, mut orders: impl FnMut(f64) -> Orders) -> Record {
    let mut vehicle = FirstOrderVehicle::new(VehicleConfig::starfish(), seed).unwrap();
    let mut samples = Vec::new();
    let mut thrust = vehicle.config().initial_thrust;
    loop {
        let Ok(next) = vehicle.next_sample();
        let Some(sample) = next.filter(|sample| sample.time_s < duration_s) else {
            return samples.into_iter().collect();
        };
        samples.push(Sample { thrust: Some(thrust), ..sample });
        let (steering, wanted) = orders(sample.time_s);
        thrust = wanted;
        let action = Action { steering, thrust: Some(thrust), outcome: None };
        let Ok(()) = vehicle.act(&action);
    }
}

/// Strokes of a rudder angle from side to side.
struct Strokes {
    from_s: f64,
    thrust: f64,
    angle_rad: f64,
    lengths_s: &'static [f64],
    kind: Kind,
}

impl Strokes {
    fn to_s(&self) -> f64 {
        self.from_s + self.lengths_s.iter().sum::<f64>()
    }

    fn rudder_rad(&self, time_s: f64) -> Option<f64> {
        let mut end_s = self.from_s;
        self.lengths_s.iter().zip(0..).find_map(|(length_s, k)| {
            let begins_s = end_s;
            end_s += length_s;
            let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
            (begins_s..end_s).contains(&time_s).then_some(sign * self.angle_rad)
        })
    }
}

const DOUBLET: &[f64] = &[2.0, 2.0];

/// Five doublets, a zig-zag, a 3-2-1-1, a turning circle and a step, with transits on changing courses between them.
fn plan() -> Vec<Strokes> {
    let strokes = |from_s, thrust, angle_rad, lengths_s, kind| Strokes {
        from_s,
        thrust,
        angle_rad,
        lengths_s,
        kind,
    };
    vec![
        strokes(120.0, 0.6, 0.26, DOUBLET, Kind::Doublet),
        strokes(160.0, 0.6, 0.15, DOUBLET, Kind::Doublet),
        strokes(400.0, 0.8, 0.26, DOUBLET, Kind::Doublet),
        strokes(440.0, 0.8, 0.2, DOUBLET, Kind::Doublet),
        strokes(480.0, 0.8, -0.22, DOUBLET, Kind::Doublet),
        strokes(520.0, 0.8, 0.2, &[1.5, 3.0, 3.0, 3.0, 3.0], Kind::ZigZag),
        strokes(700.0, 0.8, 0.26, &[60.0], Kind::TurningCircle),
        strokes(900.0, 1.0, 0.15, &[3.0, 2.0, 1.0, 1.0], Kind::Multistep),
        strokes(940.0, 1.0, 0.2, &[2.0], Kind::Step),
    ]
}

fn long_mission(seed: u64) -> Record {
    let plan = plan();
    mission(1200.0, seed, |time_s| {
        let thrust = plan
            .iter()
            .rev()
            .find(|strokes| time_s >= strokes.from_s - 60.0)
            .map_or(0.6, |strokes| strokes.thrust);
        let rudder = plan.iter().find_map(|strokes| strokes.rudder_rad(time_s));
        // A new course every five minutes.
        let course_rad = 0.4 * ((time_s + 100.0) / 300.0).floor();
        // Then the controller does not take over at once.
        let is_after = |s: &Strokes| (s.to_s()..s.to_s() + 6.0).contains(&time_s);
        let rudder =
            rudder.or(plan.iter().any(|s| s.kind != Kind::Doublet && is_after(s)).then_some(0.0));
        (rudder.map_or(Steering::HoldHeading(course_rad), Steering::Rudder), thrust)
    })
}

fn manoeuvres(record: &Record) -> Vec<Segment> {
    find(&record.samples).into_iter().filter(|segment| segment.kind != Kind::Steady).collect()
}

#[test]
fn recover_every_manoeuvre_of_a_long_mission_and_no_other() {
    for seed in 1..=5 {
        let found = manoeuvres(&long_mission(seed));
        let plan = plan();
        let kinds: Vec<Kind> = found.iter().map(|segment| segment.kind).collect();
        let planned: Vec<Kind> = plan.iter().map(|strokes| strokes.kind).collect();
        assert_eq!(kinds, planned, "seed {seed}");
        for (segment, strokes) in found.iter().zip(&plan) {
            // An order acts one sample later, and ends are those of samples.
            assert!((segment.window.from_s - strokes.from_s).abs() < 0.16);
            assert!((segment.window.to_s - strokes.to_s()).abs() < 0.16);
            // The neutral angle is known within the rudder that holds a course against the offset.
            assert!((segment.amplitude_rad - strokes.angle_rad.abs()).abs() < 0.02);
            assert_eq!(segment.thrust, Some(strokes.thrust));
        }
    }
}

/// Both parameters at three thrusts in eight missions.
#[test]
fn recover_models_of_every_speed_with_the_truth_in_their_intervals() {
    let vehicle = FirstOrderVehicle::new(VehicleConfig::starfish(), 1).unwrap();
    let mut covered = 0;
    for seed in 1..=8 {
        let record = long_mission(seed);
        let proposals = propose(&record, &find(&record.samples));
        let thrusts: Vec<Option<f64>> = proposals.iter().map(|p| p.thrust).collect();
        assert_eq!(thrusts, [Some(0.6), Some(0.8), Some(1.0)]);
        for (proposal, joined_manoeuvres) in proposals.iter().zip([None, Some(3), None]) {
            let held_out =
                proposal.validation.map(|window| ValidationData { record: &record, window });
            let settings = IdentifySettings::default();
            let (identification, joined) =
                identify_joined(&record, &proposal.training, held_out, &settings).unwrap();
            let outcome = identification.verdict.outcome();
            let is_validated = proposal.validation.is_some();
            assert_eq!(identification.verdict.accepted, is_validated, "{proposal:?}");
            assert_ne!(outcome, Outcome::DoNotUse, "{proposal:?}");
            assert_eq!(joined.map(|j| j.manoeuvres.len()), joined_manoeuvres);
            let truth = vehicle.truth(proposal.thrust.unwrap()).model;
            let interval = identification.refined.unwrap().interval_95;
            for (value, [low, high]) in
                [(truth.a22_per_s, interval.a22_per_s), (truth.b2_per_s2, interval.b2_per_s2)]
            {
                covered += usize::from((low..=high).contains(&value));
            }
        }
    }
    // 95 % of 48 are 45.6, with a standard deviation of 1.5; a and b of one record go together, so 2.1.
    assert!(covered >= 40, "{covered} of 48");
}

/// Twenty minutes on changing courses by the vehicle's own controller.
#[test]
fn prop_a_quiet_mission_has_no_manoeuvres() {
    for seed in 1..=3 {
        let record = mission(1200.0, seed, |time_s| {
            (Steering::HoldHeading(0.4 * (time_s / 150.0).floor()), 0.8)
        });
        assert_eq!(manoeuvres(&record), [], "seed {seed}");
    }
}

/// Twenty minutes by a helmsman, who lays the rudder to another angle every 2 to 8 s, at 10 deg/s.
#[test]
fn prop_a_hand_steered_mission_has_no_manoeuvres_to_both_sides() {
    let angle = Normal::new(0.0, 5_f64.to_radians()).unwrap();
    for seed in 1..=10 {
        let mut chance = Pcg64::new(u128::from(seed), 0);
        let (mut wanted_rad, mut rudder_rad, mut until_s) = (0.0, 0.0, 0.0);
        let record = mission(1200.0, seed, |time_s| {
            if time_s >= until_s {
                until_s = time_s + chance.random_range(2.0..8.0);
                wanted_rad = angle.sample(&mut chance);
            }
            let step_rad = 10_f64.to_radians() * 0.05;
            rudder_rad += f64::clamp(wanted_rad - rudder_rad, -step_rad, step_rad);
            (Steering::Rudder(rudder_rad), 0.8)
        });
        let found = manoeuvres(&record);
        // Once in a while he keeps the rudder still for long before and after a large angle, which is a step.
        assert!(
            found.len() <= 1 && found.iter().all(|m| m.kind == Kind::Step),
            "seed {seed}: {found:?}"
        );
    }
}
