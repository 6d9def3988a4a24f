//! Experiments that must not end in an accepted model, and sound ones beside them.

use std::convert::Infallible;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use seatrial::campaign::Campaign;
use seatrial::identification::Verdict;
use seatrial::identify::{
    IdentifySettings, ValidationData, identify, validation, validation_estimate,
};
use seatrial::verdict::judge_validation;
use seatrial::{Record, Window};
use seatrial_app::conduct::{NoWatch, conduct};
use seatrial_core::{Action, List, Plan, Sample, Stage, Steering, Vehicle, YawModel};
use seatrial_sim::{FirstOrderVehicle, VehicleConfig};

/// What is wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Nothing: a whole run of a trial.
    SoundRun,
    /// Nothing: the true model on validation data.
    TrueModel,
    /// The vehicle only holds its heading.
    Unexcited,
    /// The rudder works the other way round.
    Reversed,
    /// The rudder stops at 40 to 70 % of the training's amplitude, and nobody measures it.
    Saturated,
    /// a22 or b2 of the model is 30 % too large or too small.
    ThirtyPercentWrong,
}

/// Compass noise, deg, and disturbance, rad/s^2 and s.
#[derive(Clone, Copy, Debug)]
pub struct Sea {
    pub noise_deg: f64,
    pub disturbance: (f64, f64),
}

/// The verdict on a model; `None` where there is none to judge.
pub fn verdict(kind: Kind, sea: Sea, seed: u64) -> Option<Verdict> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut config = VehicleConfig::starfish();
    config.sensors.compass.noise_rad = sea.noise_deg.to_radians();
    config.disturbance.standard_deviation_rad_s2 = sea.disturbance.0;
    config.disturbance.correlation_time_s = sea.disturbance.1;
    let thrust = *[0.6, 0.7, 0.8, 0.9, 1.0].get(random.random_range(0..5_usize)).unwrap();
    let plan =
        Plan { thrusts: List::from_slice(&[thrust]).unwrap(), max_repeats: 0, ..Plan::paper() };
    if kind == Kind::Reversed {
        config.heading_hold.gain = -config.heading_hold.gain;
        for point in &mut config.speeds {
            point.b2_per_s2 = -point.b2_per_s2;
        }
    }
    let truth = FirstOrderVehicle::new(config.clone(), seed).unwrap().truth(thrust).model.theta();
    match kind {
        Kind::SoundRun | Kind::Reversed => trial_verdict(config, plan, f64::INFINITY, seed),
        Kind::Saturated => trial_verdict(config, plan, 0.26 * random.random_range(0.4..0.7), seed),
        Kind::Unexcited => heading_keeping(config, thrust, seed),
        Kind::TrueModel => validated_verdict(config, plan, truth, seed),
        Kind::ThirtyPercentWrong => {
            let mut wrong = truth;
            wrong[random.random_range(0..2_usize)] *= if random.random() { 0.7 } else { 1.3 };
            validated_verdict(config, plan, wrong, seed)
        }
    }
}

/// A vehicle whose rudder stops at an angle but is logged as commanded.
struct StopsAt {
    vehicle: FirstOrderVehicle,
    limit_rad: f64,
    commanded_rad: Option<f64>,
}

impl Vehicle<f64> for StopsAt {
    type Error = Infallible;

    fn next_sample(&mut self) -> Result<Option<Sample<f64>>, Infallible> {
        let sample = self.vehicle.next_sample()?;
        Ok(sample.map(|sample| Sample {
            rudder_rad: self.commanded_rad.unwrap_or(sample.rudder_rad),
            ..sample
        }))
    }

    fn act(&mut self, action: &Action<f64>) -> Result<(), Infallible> {
        let mut reached = *action;
        self.commanded_rad = None;
        if let Steering::Rudder(rudder_rad) = &mut reached.steering {
            self.commanded_rad = Some(*rudder_rad);
            *rudder_rad = rudder_rad.clamp(-self.limit_rad, self.limit_rad);
        }
        self.vehicle.act(&reached)
    }
}

fn trial(config: VehicleConfig, plan: Plan<f64>, limit_rad: f64, seed: u64) -> Campaign {
    let mut vehicle = StopsAt {
        vehicle: FirstOrderVehicle::new(config, seed).unwrap(),
        limit_rad,
        commanded_rad: None,
    };
    let about = Campaign { seed: Some(seed), ..Campaign::of("sim", &plan) };
    conduct(&mut vehicle, plan, about, &mut NoWatch).unwrap().campaign
}

/// The verdict on the run, where the trial took it.
fn trial_verdict(
    config: VehicleConfig,
    plan: Plan<f64>,
    limit_rad: f64,
    seed: u64,
) -> Option<Verdict> {
    let campaign = trial(config, plan, limit_rad, seed);
    let accepted = campaign.accepted_runs().into_iter().next()?;
    Some(accepted.identification.as_ref()?.verdict.clone())
}

/// A given model on the training stage of a trial.
fn validated_verdict(
    config: VehicleConfig,
    plan: Plan<f64>,
    theta: [f64; 3],
    seed: u64,
) -> Option<Verdict> {
    let campaign = trial(config, plan, f64::INFINITY, seed);
    let run = campaign.runs.first()?;
    let window = run.stage(Stage::Train)?;
    let model = YawModel::from_theta(theta);
    let validation = validation::validate(model, &run.record, window).unwrap();
    let own = validation_estimate(&run.record.usable(window));
    Some(judge_validation(&model, validation, own.as_ref(), Vec::new()))
}

fn heading_keeping(config: VehicleConfig, thrust: f64, seed: u64) -> Option<Verdict> {
    let mut vehicle = FirstOrderVehicle::new(config, seed).unwrap();
    let hold = Action { steering: Steering::HoldHeading(0.0), thrust: Some(thrust), outcome: None };
    let mut record = Record::default();
    while record.samples.last().is_none_or(|last| last.time_s < 43.0) {
        let Ok(sample) = vehicle.next_sample();
        record.samples.push(sample.unwrap());
        let Ok(()) = vehicle.act(&hold);
    }
    let window = |from_s, to_s| Window { from_s, to_s };
    let held_out = ValidationData { record: &record, window: window(26.5, 43.0) };
    identify(&record, window(10.0, 26.5), Some(held_out), &IdentifySettings::default())
        .ok()
        .map(|found| found.verdict)
}
