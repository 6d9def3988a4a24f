//! The diving plane of the vehicles of six degrees of freedom.

use std::convert::Infallible;

use nalgebra::{Matrix3, Quaternion, Vector3};
use seatrial::Window;
use seatrial::pitch::{NoPitchModel, PitchPlan, PitchTrial, fit, identify, trial};
use seatrial_core::{Diving, DivingSample, DivingVehicle, PitchModel};
use seatrial_sim::six_dof::dynamics::{Inputs, State};
use seatrial_sim::six_dof::fins::Deflections;
use seatrial_sim::six_dof::{remus100, starfish};
use seatrial_sim::{SixDofConfig, SixDofVehicle};

fn made(config: SixDofConfig, seed: u64) -> PitchTrial {
    let mut vehicle = SixDofVehicle::new(config, seed).unwrap();
    let made = trial(&mut vehicle, PitchPlan::default());
    assert_eq!(made.aborted, None);
    assert_eq!(made.runs.len(), 5);
    made
}

/// With noise, the pitch of validation data is predicted at every thrust while depth is held, and the intervals hold what the same manoeuvre
/// gives without noise.
#[test]
fn recover_pitch_predicts_fresh_pitch() {
    let (mut inside, mut all) = (0, 0);
    for config in [starfish::config(), remus100::config()] {
        let quiet = made(config.clone().noise_free(), 1);
        for seed in 1..4 {
            for (run, quiet) in made(config.clone(), seed).runs.iter().zip(&quiet.runs) {
                let found = run.identification.as_ref().unwrap();
                let r2 = found.validation.unwrap().r2_pitch;
                // Pitch noise of 0.3 degrees is all that is left at low thrust, where the doublet pitches by 2 degrees.
                assert!(r2 > 0.65, "{} {} {seed}: {r2}", config.name, run.thrust);
                assert!(
                    found.accepted && run.depth_excursion_m.unwrap() < 0.7,
                    "{run:?}"
                );
                let exact = quiet.identification.as_ref().unwrap().refined.model;
                for ([low, high], exact) in found.refined.interval_95.iter().zip(exact.theta()) {
                    all += 1;
                    inside += u32::from((*low..=*high).contains(&exact));
                }
            }
        }
    }
    println!("{inside} of {all}");
    // 95 % were right for a vehicle that is of this form; heave biases these by about a standard deviation.
    assert!(
        f64::from(inside) > 0.85 * f64::from(all),
        "{inside} of {all}"
    );
}

/// The 3-state linearisation of a vehicle under way: w, q and theta, and the elevator's column.
fn linearised(vehicle: &SixDofVehicle) -> (Matrix3<f64>, Vector3<f64>) {
    let body = vehicle.body();
    let trimmed = body.state;
    let after = |state: &State, elevator_rad: f64| {
        let inputs = Inputs {
            deflections: Deflections {
                rudder_rad: 0.0,
                elevator_rad: body.elevator.fin_rad + elevator_rad,
            },
            shaft_rev_s: body.shaft_rev_s,
            yaw_disturbance_rad_s2: 0.0,
            time_s: 0.0,
        };
        const INTERVAL_S: f64 = 1e-4;
        let next = body.dynamics().step(state, &[inputs; 3], INTERVAL_S);
        let change = |s: &State| Vector3::new(s.velocity[2], s.velocity[4], s.euler_rad()[1]);
        (change(&next) - change(state)) / INTERVAL_S
    };
    let step = 1e-4;
    let moved = |axis: usize, by: f64| {
        let mut state = trimmed;
        match axis {
            0 => state.velocity[2] += by,
            1 => state.velocity[4] += by,
            _ => state.attitude *= Quaternion::new((0.5 * by).cos(), 0.0, (0.5 * by).sin(), 0.0),
        }
        state
    };
    let columns = [0, 1, 2].map(|axis| {
        (after(&moved(axis, step), 0.0) - after(&moved(axis, -step), 0.0)) / (2.0 * step)
    });
    let elevator = (after(&trimmed, step) - after(&trimmed, -step)) / (2.0 * step);
    (Matrix3::from_columns(&columns), elevator)
}

/// What is found is what the simulator's linearisation has, seen without heave: the same fit to the linearised vehicle under
/// the same elevator gives the same model, and leaving heave out is all that parts it from a, m and b themselves.
#[test]
fn val_pitch_against_the_linearised_simulator() {
    for config in [starfish::config(), remus100::config()] {
        let mut config = config.noise_free();
        config.helm.initial_thrust = 0.8;
        // Fins that follow at once, so that the record's elevator is the fin's.
        config.elevator.servo.time_constant_s = 1e-3;
        config.elevator.servo.rate_limit_rad_s = None;
        config.elevator.dead_band_rad = 0.0;
        config.elevator.backlash_rad = 0.0;
        let mut vehicle = SixDofVehicle::new(config.clone(), 1).unwrap();
        let (matrix, elevator) = linearised(&vehicle);
        let plan = PitchPlan {
            thrusts: vec![0.8],
            // Small, so that cross-flow drag is, too.
            training_rad: 0.03,
            validation_rad: 0.03,
            ..PitchPlan::default()
        };
        let made = trial(&mut vehicle, plan);
        let found = made.runs[0].identification.as_ref().unwrap();
        let samples: Vec<DivingSample<f64>> = made
            .samples
            .iter()
            .filter(|s| found.training.contains(s.time_s))
            .copied()
            .collect();
        let linear = fit(&played(&matrix, &elevator, &samples), &found.online).unwrap();
        let (nonlinear, linear) = (found.refined.model, linear.model);
        println!(
            "{}: direct a {:.3} m {:.3} b {:.3}, heave couples by {:.3}",
            config.name,
            matrix[(1, 1)],
            matrix[(1, 2)],
            elevator[1],
            matrix[(1, 0)]
        );
        println!(
            "  linearised, four parameters {:.3?}; identified {:.3?}",
            linear.theta(),
            nonlinear.theta()
        );
        let [a, m, b, _] = nonlinear.theta();
        let [a_linear, m_linear, b_linear, _] = linear.theta();
        // Cross-flow drag and depth that changes are left: 10 % of each, m of the authority.
        assert!((a / a_linear - 1.0).abs() < 0.15, "{a} {a_linear}");
        assert!((b / b_linear - 1.0).abs() < 0.15, "{b} {b_linear}");
        assert!((m - m_linear).abs() < 0.15 * b, "{m} {m_linear}");
    }
}

/// Pitch of the linearised vehicle under the elevator of a record, about the means of the record.
fn played(
    matrix: &Matrix3<f64>,
    elevator: &Vector3<f64>,
    samples: &[DivingSample<f64>],
) -> Vec<DivingSample<f64>> {
    const STEPS: u32 = 20;
    let trim_rad = samples[0].elevator_rad;
    let mut state = Vector3::zeros();
    let mut played = Vec::new();
    for pair in samples.windows(2) {
        played.push(DivingSample {
            pitch_rad: state[2],
            ..pair[0]
        });
        let h = (pair[1].time_s - pair[0].time_s) / f64::from(STEPS);
        let input = elevator * (pair[0].elevator_rad - trim_rad);
        for _ in 0..STEPS {
            let k1 = matrix * state + input;
            let k2 = matrix * (state + k1 * (0.5 * h)) + input;
            state += k2 * h;
        }
    }
    played
}

/// A vehicle that answers its elevator by this model, with depth beside the point, and dives away if asked to.
struct Answering {
    model: PitchModel<f64>,
    time_s: f64,
    pitch: seatrial_core::PitchState<f64>,
    elevator_rad: f64,
    diving: Diving<f64>,
    sinks_m_s: f64,
}

impl DivingVehicle<f64> for Answering {
    type Error = Infallible;

    fn next_diving_sample(&mut self) -> Result<Option<DivingSample<f64>>, Infallible> {
        self.pitch = self.model.advance(self.pitch, self.elevator_rad, 0.05);
        self.time_s += 0.05;
        self.elevator_rad = match self.diving {
            Diving::HoldDepth => -self.pitch.pitch_rad,
            Diving::Elevator(elevator_rad) => elevator_rad,
        };
        Ok(Some(DivingSample {
            time_s: self.time_s,
            pitch_rad: self.pitch.pitch_rad,
            elevator_rad: self.elevator_rad,
            depth_m: Some(2.0 + self.sinks_m_s * self.time_s),
            surge_speed_m_s: Some(1.5),
        }))
    }

    fn dive(&mut self, diving: Diving<f64>, _thrust: f64) -> Result<(), Infallible> {
        self.diving = diving;
        Ok(())
    }
}

fn answering(sinks_m_s: f64) -> Answering {
    Answering {
        model: PitchModel::from_theta([-1.4, -0.3, 1.1, -0.02]),
        time_s: 0.0,
        pitch: Default::default(),
        elevator_rad: 0.0,
        diving: Diving::HoldDepth,
        sinks_m_s,
    }
}

#[test]
fn exact_a_vehicle_of_this_form_is_found() {
    let mut vehicle = answering(0.0);
    let truth = vehicle.model.theta();
    let made = trial(&mut vehicle, PitchPlan::default());
    for run in &made.runs {
        let found = run.identification.as_ref().unwrap();
        for (found, truth) in found.refined.model.theta().iter().zip(truth) {
            // The search ends where the sum of squares falls by less than 1e-10 of itself.
            assert!(
                (found - truth).abs() < 1e-4 * truth.abs(),
                "{found} {truth}"
            );
        }
        for (found, truth) in found.online.theta().iter().zip(truth) {
            // Pitch is not straight between samples.
            assert!(
                (found - truth).abs() < 0.02 * truth.abs(),
                "{found} {truth}"
            );
        }
        assert!(found.validation.unwrap().r2_pitch > 1.0 - 1e-6);
    }
}

#[test]
fn recover_a_trial_that_leaves_its_depth_is_aborted() {
    let mut vehicle = answering(0.05);
    let made = trial(&mut vehicle, PitchPlan::default());
    // 1 m at 0.05 m/s.
    assert!(made.runs.is_empty() && vehicle.time_s < 20.2);
    assert!(made.aborted.unwrap().contains("depth changed"));
    assert_eq!(vehicle.diving, Diving::HoldDepth);
}

#[test]
fn io_what_cannot_be_identified_is_refused() {
    let sample = |k: u32| DivingSample {
        time_s: f64::from(k) * 0.05,
        pitch_rad: 0.001 * f64::from(k % 7),
        ..DivingSample::default()
    };
    let still: Vec<_> = (0..400).map(sample).collect();
    let refused = identify(&still, Window::ALL, None);
    assert_eq!(refused, Err(NoPitchModel::NotExcited { moved_rad: 0.0 }));
    let few = identify(&still[..10], Window::ALL, None);
    assert!(matches!(few, Err(NoPitchModel::TooFew { found: 10, .. })));
}
