//! The axis of pitch: the same trial, runs and verdicts as yaw, on the vehicles of six degrees of freedom.

use std::convert::Infallible;

use nalgebra::{Matrix3, Quaternion, Vector3};
use seatrial::identification::{Outcome as ModelOutcome, ReasonCode, Subject};
use seatrial::identify::{IdentifyError, ValidationData};
use seatrial::motions::pitch::{fit, identify};
use seatrial::{Campaign, Identification, Record, Run, Window};
use seatrial_app::trials::order::rehearse;
use seatrial_core::progress::Stage;
use seatrial_core::{
    AbortReason, Action, Axis, Excitation, List, Outcome, PitchModel, PitchState, Plan, Sample,
    Steering, Vehicle,
};
use seatrial_sim::six_dof::dynamics::{Inputs, State};
use seatrial_sim::six_dof::fins::Deflections;
use seatrial_sim::six_dof::{remus100, starfish};
use seatrial_sim::{SixDofConfig, SixDofVehicle};

fn conducted(vehicle: &mut impl Vehicle<f64, Error = Infallible>, plan: Plan<f64>) -> Campaign {
    rehearse(vehicle, "sim", 1, plan).unwrap().campaign
}

fn made(config: SixDofConfig, seed: u64) -> Campaign {
    let mut vehicle = SixDofVehicle::new(config, seed).unwrap().on_axis(Axis::Pitch);
    let made = conducted(&mut vehicle, Plan::pitch());
    assert_eq!(made.outcome, Some(Outcome::Finished));
    made
}

fn found(run: &Run) -> &Identification {
    run.identification.as_ref().unwrap()
}

/// a, m, b, c as they were refined.
fn refined(found: &Identification) -> PitchModel<f64> {
    PitchModel::righted(&found.model(), found.restoring.unwrap().refined_per_s2)
}

fn intervals(found: &Identification) -> [[f64; 2]; 4] {
    let interval = found.refined.as_ref().unwrap().interval_95;
    let m = found.restoring.unwrap().interval_95_per_s2;
    [interval.a22_per_s, m, interval.b2_per_s2, interval.c0_rad_per_s2]
}

/// Greatest deviation from the depth at the start of the training, m.
fn depth_excursion_m(run: &Run) -> f64 {
    let start_s = run.stage(Stage::Train).unwrap().from_s;
    let samples = || run.record.samples.iter().filter(|s| s.time_s >= start_s);
    let start_m = samples().next().unwrap().depth_m.unwrap();
    samples().map(|s| (s.depth_m.unwrap() - start_m).abs()).fold(0.0, f64::max)
}

/// With noise, the pitch of validation data is predicted at every thrust while depth is held, and the intervals hold what the same manoeuvre
/// gives without noise.
#[test]
fn recover_pitch_predicts_validation_pitch() {
    let (mut inside, mut all) = (0, 0);
    for config in [starfish::config(), remus100::config()] {
        let quiet = made(config.clone().noise_free(), 1);
        for seed in 1..4 {
            let noisy = made(config.clone(), seed);
            assert_eq!(noisy.runs.len(), 5, "{} {seed}", config.name);
            for (run, quiet) in noisy.runs.iter().zip(&quiet.runs) {
                let identified = found(run);
                let r2 = identified.validation.unwrap().r2_heading_offset_refit.unwrap();
                // Pitch noise of 0.3 degrees is all that is left at low thrust, where the doublet pitches by 2 degrees.
                assert!(r2 > 0.65, "{} {} {seed}: {r2}", config.name, run.thrust);
                assert_eq!(run.verdict.outcome(), ModelOutcome::Use, "{:?}", run.verdict);
                assert!(depth_excursion_m(run) < 0.7, "{}", run.thrust);
                let exact = refined(found(quiet));
                for ([low, high], exact) in intervals(identified).iter().zip(exact.theta()) {
                    all += 1;
                    inside += u32::from((*low..=*high).contains(&exact));
                }
            }
        }
    }
    println!("{inside} of {all}");
    // 95 % were right for a vehicle that is of this form; heave biases these by about a standard deviation.
    assert!(f64::from(inside) > 0.85 * f64::from(all), "{inside} of {all}");
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
        let mut vehicle = SixDofVehicle::new(config.clone(), 1).unwrap().on_axis(Axis::Pitch);
        let (matrix, elevator) = linearised(&vehicle);
        let mut plan = Plan::pitch();
        plan.thrusts = List::from_slice(&[0.8]).unwrap();
        for manoeuvre in [&mut plan.training, &mut plan.validation] {
            // Small, so that cross-flow drag is, too.
            manoeuvre.excitation = Excitation::Doublet { amplitude_rad: 0.03, period_s: 2.0 };
        }
        let made = conducted(&mut vehicle, plan);
        let found = found(&made.runs[0]);
        let samples = made.runs[0].record.usable(found.training);
        let online_m = found.restoring.unwrap().online_per_s2;
        let online = PitchModel::righted(&found.online.model, online_m);
        let linear = fit(&played(&matrix, &elevator, &samples), &online).unwrap();
        let (nonlinear, linear) = (refined(found), linear.model);
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
    samples: &[Sample<f64>],
) -> Vec<Sample<f64>> {
    const STEPS: u32 = 20;
    let trim_rad = samples[0].rudder_rad;
    let mut state = Vector3::zeros();
    let mut played = Vec::new();
    for pair in samples.windows(2) {
        played.push(Sample { heading_rad: state[2], ..pair[0] });
        let h = (pair[1].time_s - pair[0].time_s) / f64::from(STEPS);
        let input = elevator * (pair[0].rudder_rad - trim_rad);
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
    pitch: PitchState<f64>,
    elevator_rad: f64,
    steering: Steering<f64>,
    sinks_m_s: f64,
}

impl Vehicle<f64> for Answering {
    type Error = Infallible;

    fn next_sample(&mut self) -> Result<Option<Sample<f64>>, Infallible> {
        self.pitch = self.model.advance(self.pitch, self.elevator_rad, 0.05);
        self.time_s += 0.05;
        self.elevator_rad = match self.steering {
            Steering::HoldHeading(_) => -self.pitch.pitch_rad,
            Steering::Rudder(elevator_rad) => elevator_rad,
        };
        Ok(Some(Sample {
            time_s: self.time_s,
            heading_rad: self.pitch.pitch_rad,
            rudder_rad: self.elevator_rad,
            pitch_rad: Some(self.pitch.pitch_rad),
            depth_m: Some(2.0 + self.sinks_m_s * self.time_s),
            surge_speed_m_s: Some(1.5),
            ..Sample::default()
        }))
    }

    fn act(&mut self, action: &Action<f64>) -> Result<(), Infallible> {
        self.steering = action.steering;
        Ok(())
    }
}

fn answering(sinks_m_s: f64) -> Answering {
    Answering {
        model: PitchModel::from_theta([-1.4, -0.3, 1.1, -0.02]),
        time_s: 0.0,
        pitch: Default::default(),
        elevator_rad: 0.0,
        steering: Steering::HoldHeading(0.0),
        sinks_m_s,
    }
}

#[test]
fn exact_a_vehicle_of_this_form_is_found() {
    let mut vehicle = answering(0.0);
    let truth = vehicle.model.theta();
    let made = conducted(&mut vehicle, Plan::pitch());
    assert_eq!((made.axis, made.runs.len()), (Axis::Pitch, 5));
    for run in &made.runs {
        let found = found(run);
        for (found, truth) in refined(found).theta().iter().zip(truth) {
            // The search ends where the sum of squares falls by less than 1e-10 of itself.
            assert!((found - truth).abs() < 1e-4 * truth.abs(), "{found} {truth}");
        }
        let online =
            PitchModel::righted(&found.online.model, found.restoring.unwrap().online_per_s2);
        for (found, truth) in online.theta().iter().zip(truth) {
            // Pitch is not straight between samples.
            assert!((found - truth).abs() < 0.02 * truth.abs(), "{found} {truth}");
        }
        let r2 = found.validation.unwrap().r2_heading_offset_refit.unwrap();
        assert!(r2 > 1.0 - 1e-6, "{r2}");
    }
}

#[test]
fn recover_a_trial_that_leaves_its_depth_is_aborted() {
    let mut vehicle = answering(0.05);
    let made = conducted(&mut vehicle, Plan::pitch());
    // 1 m at 0.05 m/s.
    assert!(vehicle.time_s < 20.3, "{}", vehicle.time_s);
    assert_eq!(made.outcome, Some(Outcome::Aborted(AbortReason::Depth)));
    assert!(made.accepted_runs().is_empty());
    assert!(matches!(vehicle.steering, Steering::HoldHeading(_)));
}

/// The four outcomes are those of yaw: without validation data a model is not validated, and so is not accepted.
#[test]
fn exact_a_model_that_nothing_validated_is_not_accepted() {
    let run = &conducted(&mut answering(0.0), Plan::pitch()).runs[0];
    let [training, validation] =
        [Stage::Train, Stage::Validate].map(|stage| run.stage(stage).unwrap());
    let data = ValidationData { record: &run.record, window: validation };
    let outcome = |data| identify(&run.record, training, data).unwrap().verdict.outcome();
    assert_eq!(outcome(Some(data)), ModelOutcome::Use);
    assert_eq!(outcome(None), ModelOutcome::NotValidated);
    // Validation data in which the elevator does something else.
    let mut turned = run.record.clone();
    for sample in &mut turned.samples {
        sample.rudder_rad = -sample.rudder_rad;
    }
    let data = ValidationData { record: &turned, window: validation };
    assert_eq!(outcome(Some(data)), ModelOutcome::DoNotUse);
}

#[test]
fn io_what_cannot_be_identified_is_refused() {
    let sample = |k: u32| Sample {
        time_s: f64::from(k) * 0.05,
        heading_rad: 0.001 * f64::from(k % 7),
        ..Sample::default()
    };
    let still: Record = (0..400).map(sample).collect();
    let few: Record = (0..10).map(sample).collect();
    for (record, code) in [
        (still, ReasonCode::Constant.of(Subject::Elevator)),
        (few, ReasonCode::TooFewSamples.into()),
    ] {
        match identify(&record, Window::ALL, None) {
            Err(IdentifyError::Refused(reason)) => assert_eq!(reason.kind(), code),
            other => panic!("{other:?}"),
        }
    }
}
