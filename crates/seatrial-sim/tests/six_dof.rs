//! The physics of the vehicles of six degrees of freedom, and whole trials with them.

use std::time::Instant;

use nalgebra::{UnitQuaternion, Vector3, Vector6};
use seatrial_core::{
    AbortReason, Action, Event, Outcome, Plan, RunResult, Sample, Steering, Trial, Vehicle,
};
use seatrial_sim::six_dof::dynamics::{Dynamics, Inputs, State};
use seatrial_sim::six_dof::fins::Deflections;
use seatrial_sim::six_dof::rigid_body::{join, split};
use seatrial_sim::six_dof::sea::{Bottom, CurrentPoint};
use seatrial_sim::six_dof::{remus100, starfish};
use seatrial_sim::{SixDofConfig, SixDofVehicle};

const STEP_S: f64 = 0.01;

/// A vehicle that the water accelerates but does not brake.
fn frictionless(mut config: SixDofConfig) -> SixDofConfig {
    config.fins.clear();
    config.hull.munk_moment = true;
    config.hull.frontal_drag = 0.0;
    config.hull.cross_flow_drag = 0.0;
    config.hull.planform_area_m2 = 1e-12;
    config.hull.linear_damping = [0.0; 6];
    config.rigid_body.centre_of_gravity_m = [0.05, 0.01, 0.02];
    config
}

fn tumbling() -> State {
    State {
        velocity: Vector6::new(1.5, -0.3, 0.2, 0.6, -0.3, 0.4),
        // So deep that nothing reaches the surface.
        ..State::level(1.0, 200.0, 0.0)
    }
}

fn vehicles() -> [SixDofConfig; 2] {
    [remus100::config(), starfish::config()]
}

/// Tumbles for 20 s with this many steps to the usual one.
fn tumbled(dynamics: &Dynamics, finer: u32) -> State {
    let step_s = STEP_S / f64::from(finer);
    (0..2000 * finer)
        .fold(tumbling(), |state, _| dynamics.step(&state, &[Inputs::default(); 3], step_s))
}

#[test]
fn exact_energy_is_conserved_without_friction() {
    for config in vehicles().map(frictionless) {
        let dynamics = Dynamics::new(&config).unwrap();
        let before = dynamics.energy_j(&tumbling());
        let kinetic = before - config.rigid_body.potential_energy_j(200.0, &Vector3::z());
        let change = |finer| (dynamics.energy_j(&tumbled(&dynamics, finer)) - before) / kinetic;
        let (usual, finer) = (change(1), change(4));
        // What there is is the error of a method of fourth order: a 256th, or less, with a quarter of the step.
        assert!(usual.abs() < 1e-5, "{}: {usual:e}", config.name);
        assert!(finer.abs() < usual.abs() / 200.0, "{}: {usual:e} {finer:e}", config.name);
    }
}

#[test]
fn exact_momentum_is_conserved_without_friction_and_weight() {
    for mut config in vehicles().map(frictionless) {
        config.rigid_body.buoyancy_n = config.rigid_body.weight_n();
        config.rigid_body.centre_of_buoyancy_m = config.rigid_body.centre_of_gravity_m;
        let dynamics = Dynamics::new(&config).unwrap();
        let mass = config.rigid_body.mass_matrix() + config.hull.added_mass_matrix();
        let momenta = |state: &State| {
            let rotation = UnitQuaternion::new_normalize(state.attitude);
            let (linear, angular) = split(&(mass * state.velocity));
            let linear = rotation * linear;
            let about_origin = rotation * angular + state.position_m.cross(&linear);
            (linear, about_origin)
        };
        let before = momenta(&tumbling());
        let change = |finer| {
            let after = momenta(&tumbled(&dynamics, finer));
            let linear = (after.0 - before.0).norm() / before.0.norm();
            // About a point that it is within 30 m of.
            let angular = (after.1 - before.1).norm() / (30.0 * before.0.norm());
            f64::max(linear, angular)
        };
        let (usual, finer) = (change(1), change(4));
        // As for energy, but for rounding.
        assert!(usual < 1e-5, "{}: {usual:e}", config.name);
        assert!(finer < usual / 100.0, "{}: {usual:e} {finer:e}", config.name);
    }
}

#[test]
fn prop_unforced_motion_never_gains_energy() {
    for config in vehicles() {
        let dynamics = Dynamics::new(&config).unwrap();
        for k in 0..20 {
            let inputs = Inputs {
                deflections: Deflections {
                    rudder_rad: 0.3 * libm::sin(f64::from(k)),
                    elevator_rad: 0.3 * libm::cos(1.7 * f64::from(k)),
                },
                ..Inputs::default()
            };
            let mut state = tumbling();
            state.velocity *= 2.0 * libm::sin(0.5 + f64::from(k));
            let mut energy = dynamics.energy_j(&state);
            for _ in 0..2000 {
                state = dynamics.step(&state, &[inputs; 3], STEP_S);
                let after = dynamics.energy_j(&state);
                // Rounding of 1e3 J.
                assert!(after <= energy + 1e-9, "{}: {energy} {after}", config.name);
                energy = after;
            }
        }
    }
}

/// In a uniform current everything is as in still water, but for the drift.
#[test]
fn exact_uniform_current_only_carries_the_vehicle_along() {
    for still in vehicles() {
        let mut flowing = still.clone();
        flowing.sea.current = vec![CurrentPoint { depth_m: 0.0, north_m_s: 0.4, east_m_s: -0.3 }];
        let current = Vector3::new(0.4, -0.3, 0.0);
        let inputs = Inputs {
            deflections: Deflections { rudder_rad: 0.2, elevator_rad: 0.02 },
            shaft_rev_s: 20.0,
            yaw_disturbance_rad_s2: 0.0,
            time_s: 0.0,
        };
        let [in_still, in_flow] = [still, flowing].map(|config| {
            let dynamics = Dynamics::new(&config).unwrap();
            let mut state = State::level(0.5, 2.0, 1.5);
            if !config.sea.current.is_empty() {
                let rotation = UnitQuaternion::new_normalize(state.attitude);
                let carried = rotation.inverse_transform_vector(&current);
                state.velocity += join(carried, Vector3::zeros());
            }
            for _ in 0..3000 {
                state = dynamics.step(&state, &[inputs; 3], STEP_S);
            }
            (state, dynamics.velocity_through_water(&state, 0.0))
        });
        let drifted = in_flow.0.position_m - in_still.0.position_m - current * 30.0;
        // The error of the integration, which is not the same in both frames.
        assert!(drifted.norm() < 1e-5, "{drifted}");
        assert!((in_flow.1 - in_still.1).norm() < 1e-5);
    }
}

/// Runs a vehicle with a constant rudder.
fn turn(vehicle: &mut SixDofVehicle, rudder_rad: f64, seconds: f64) {
    let end_s = vehicle.next_sample().unwrap().unwrap().time_s + seconds;
    loop {
        let Ok(()) = vehicle.act(&Action {
            steering: Steering::Rudder(rudder_rad),
            thrust: Some(0.8),
            outcome: None,
        });
        let Ok(sample) = vehicle.next_sample();
        if sample.unwrap().time_s >= end_s {
            return;
        }
    }
}

/// On a steady circle the radius is speed over yaw rate, and a larger rudder turns tighter.
#[test]
fn prop_steady_turn_is_a_circle() {
    for config in vehicles() {
        let mut before = f64::INFINITY;
        for rudder_rad in [0.1, 0.15, 0.2, 0.25] {
            let mut vehicle = SixDofVehicle::new(config.clone().noise_free(), 1).unwrap();
            turn(&mut vehicle, rudder_rad, 90.0);
            let state = vehicle.body().state;
            let (linear, angular) = split(&state.velocity);
            let over_ground = UnitQuaternion::new_normalize(state.attitude) * linear;
            let radius = over_ground.xy().norm() / angular.z;
            assert!(angular.z > 0.0 && radius < before, "{rudder_rad}: {radius} {before}");
            before = radius;
            // Half a turn later it is across the circle.
            turn(&mut vehicle, rudder_rad, core::f64::consts::PI / angular.z - STEP_S);
            let across = (vehicle.body().state.position_m - state.position_m).xy().norm();
            // Half a turn ends within a sample, 0.02 rad; heave and roll oscillate by as much.
            assert!((across / (2.0 * radius) - 1.0).abs() < 0.02, "{across} {radius}");
        }
    }
}

/// Without the torque of its screw a vehicle turns to port as it turns to starboard.
#[test]
fn prop_port_and_starboard_are_alike_without_propeller_torque() {
    for mut config in vehicles() {
        config.propeller.torque_on_hull = 0.0;
        let [starboard, port] = [0.2, -0.2].map(|rudder_rad| {
            let mut vehicle = SixDofVehicle::new(config.clone().noise_free(), 1).unwrap();
            turn(&mut vehicle, rudder_rad, 40.0);
            vehicle.body().state
        });
        for (axis, sign) in [1.0, -1.0, 1.0, -1.0, 1.0, -1.0].into_iter().enumerate() {
            let difference = starboard.velocity[axis] - sign * port.velocity[axis];
            // Rounding.
            assert!(difference.abs() < 1e-9, "{axis}: {difference:e}");
        }
    }
}

/// Runs a trial to its end, and the deepest and shallowest it was.
fn run(config: SixDofConfig, plan: Plan<f64>, seed: u64) -> (Vec<RunResult<f64>>, [f64; 2]) {
    let mut vehicle = SixDofVehicle::new(config, seed).unwrap();
    let mut trial = Trial::new(plan).unwrap();
    let mut results = Vec::new();
    let mut depths_m = [f64::INFINITY, 0.0];
    loop {
        let Ok(sample) = vehicle.next_sample();
        let action = trial.step(&sample.unwrap());
        let Ok(()) = vehicle.act(&action);
        let depth_m = vehicle.body().state.position_m.z;
        depths_m = [depths_m[0].min(depth_m), depths_m[1].max(depth_m)];
        while let Some(event) = trial.take_event() {
            if let Event::RunFinished { result, .. } = event {
                results.push(result);
            }
        }
        if let Some(outcome) = action.outcome {
            assert_eq!(outcome, Outcome::Finished);
            return (results, depths_m);
        }
    }
}

/// Whatever the seed, the trial goes through with depth held, and finds a usable model at every speed.
#[test]
fn recover_starfish_trials_converge_and_validate() {
    let mut converged_s = vec![Vec::new(); 5];
    let mut r2 = vec![Vec::new(); 5];
    for seed in 0..11 {
        let (results, [shallowest_m, deepest_m]) = run(starfish::config(), Plan::paper(), seed);
        // 7 N of buoyancy, a fifth of what fins and hull can hold down at 60 % thrust: 2 m is held within 0.3 m.
        assert!(shallowest_m > 1.7 && deepest_m < 2.3, "{seed}: {shallowest_m} {deepest_m}");
        for (k, thrust) in [0.6, 0.7, 0.8, 0.9, 1.0].into_iter().enumerate() {
            let result = results.iter().rfind(|result| result.thrust == thrust).unwrap();
            assert!(result.accepted && result.settled, "{seed}: {result:?}");
            converged_s[k].push(result.converged_s.unwrap());
            r2[k].push(result.validation.r2_heading.unwrap());
        }
    }
    for (converged_s, r2) in converged_s.iter_mut().zip(&mut r2) {
        converged_s.sort_by(f64::total_cmp);
        r2.sort_by(f64::total_cmp);
        // The paper's own: converged at 12 s of training, R^2 of 0.78 to 0.92. 11.85 s is the latest measured.
        assert!(converged_s[10] <= 12.0, "{converged_s:?}");
        assert!(r2[5] >= 0.78, "{r2:?}");
    }
}

#[test]
fn recover_remus_trial_finishes_with_every_speed_accepted() {
    let (results, [shallowest_m, deepest_m]) = run(remus100::config(), Plan::paper(), 1);
    assert_eq!(results.iter().filter(|result| result.accepted).count(), 5);
    assert!(shallowest_m > 1.8 && deepest_m < 2.2, "{shallowest_m} {deepest_m}");
}

/// Northward over a rising bottom: the trial ends before the vehicle is nearer to it than the plan allows.
#[test]
fn exact_shoal_water_aborts_the_trial() {
    let mut config = starfish::config();
    config.sea.bottom = Some(Bottom { depth_m: 8.0, slope_north: -0.1, slope_east: 0.0 });
    let mut vehicle = SixDofVehicle::new(config, 1).unwrap();
    let mut trial = Trial::new(Plan::paper()).unwrap();
    let (mut last, mut outcome): (Option<Sample<f64>>, _) = (None, None);
    while outcome.is_none() {
        let Ok(sample) = vehicle.next_sample();
        let action = trial.step(&sample.unwrap());
        let Ok(()) = vehicle.act(&action);
        (last, outcome) = (sample, action.outcome);
    }
    assert_eq!(outcome, Some(Outcome::Aborted(AbortReason::Altitude)));
    let altitude_m = last.unwrap().altitude_m.unwrap();
    // The limit is 1 m; in a sample of 0.05 s the bottom rises by up to 0.011 m at 2.2 m/s.
    assert!(altitude_m < 1.0 && altitude_m > 0.98, "{altitude_m}");
    assert!(!vehicle.body().is_aground);
}

#[test]
fn prop_same_seed_same_samples() {
    let samples = |seed| -> Vec<_> {
        let mut vehicle = SixDofVehicle::new(starfish::config(), seed).unwrap();
        (0..200).map(|_| vehicle.next_sample().unwrap()).collect()
    };
    assert_eq!(samples(7), samples(7));
    assert_ne!(samples(7), samples(8));
}

#[test]
fn regress_a_second_costs_less_than_a_millisecond() {
    let mut vehicle = SixDofVehicle::new(starfish::config(), 1).unwrap();
    // The quickest of short runs: on a busy machine others run in between.
    let per_second_ms = (0..40)
        .map(|_| {
            let start = Instant::now();
            for _ in 0..20 * 5 {
                let Ok(_) = vehicle.next_sample();
            }
            start.elapsed().as_secs_f64() * 1e3 / 5.0
        })
        .fold(f64::INFINITY, f64::min);
    println!("{per_second_ms:.3} ms");
    // 0.15 ms measured; the rest is for a slow machine.
    assert!(per_second_ms < 1.0, "{per_second_ms} ms");
}

#[test]
fn io_faults_name_the_field() {
    let check = |change: fn(&mut SixDofConfig), field: &str| {
        let mut config = starfish::config();
        change(&mut config);
        let message = SixDofVehicle::new(config, 1).unwrap_err().to_string();
        assert!(message.starts_with(field), "{message}");
    };
    check(|c| c.rigid_body.mass_kg = 0.0, "rigid_body.mass_kg must be");
    check(|c| c.hull.added_mass[5] = -1e3, "rigid_body and hull.added_mass must be");
    check(|c| c.propeller.dead_band = 1.0, "propeller.dead_band must be");
    check(|c| c.helm.timing.jitter_s = 1.0, "timing.jitter_s must be");
    check(
        |c| {
            let point = |depth_m| CurrentPoint { depth_m, north_m_s: 0.1, east_m_s: 0.0 };
            c.sea.current = vec![point(2.0), point(1.0)];
        },
        "sea.current must be",
    );
}
