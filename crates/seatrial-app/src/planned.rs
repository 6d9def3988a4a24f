//! A plan, and what it will do on the vehicle that is expected, before anything moves.

use std::path::PathBuf;

use seatrial::figures::three_figures;
use seatrial::preview::{
    Comparison, Preview, Prior, Recommendation, Target, compare_designs, preview, recommend,
};
use seatrial::servo::Servo;
use seatrial_core::plan::times_slower;
use seatrial_core::{Axis, Excitation, List, Outcome, Plan};
use serde::Serialize;

use crate::Error;
use crate::expected::Stated;
use crate::models::Models;
use crate::{TrialPlan, load_plan, simulated};

/// The vehicle that is expected where nobody names one.
pub const DEFAULT_VEHICLE: &str = "sim:starfish";

/// A plan by its differences from a file's or from the paper's.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Changes {
    /// Begin with this plan instead of the paper's.
    pub file: Option<PathBuf>,
    /// Begin with the paper's plan in the time of a vehicle with this time constant, s.
    pub time_constant_s: Option<f64>,
    /// Interval of the vehicle's samples, s.
    pub sample_interval_s: Option<f64>,
    /// Thrusts as fractions of full; empty: those of the plan.
    pub thrusts: Vec<f64>,
    /// Amplitude of the training doublet, rad.
    pub amplitude_rad: Option<f64>,
    /// Amplitude of the validation doublet, rad.
    pub validation_amplitude_rad: Option<f64>,
    /// Period of both doublets, s.
    pub period_s: Option<f64>,
    /// Largest rudder angle, rad.
    pub rudder_limit_rad: Option<f64>,
    /// Dead time and time constant of the rudder behind its command, s.
    pub servo_s: [Option<f64>; 2],
    /// Training ends when the intervals are this narrow.
    pub stop_when: Option<Target>,
    /// Times a run below R^2 0.60 is repeated.
    pub max_repeats: Option<u32>,
}

impl Changes {
    /// The plan that results, checked.
    pub fn plan(&self) -> Result<TrialPlan, Error> {
        let setting = |message: String| Error::Setting(message);
        if self.file.is_some() && self.time_constant_s.is_some() {
            return Err(setting(
                "a plan file and a time constant: give one of them".into(),
            ));
        }
        let mut plan = load_plan(self.file.as_deref(), Some(Axis::Yaw))?;
        let sample_interval_s = self.sample_interval_s.unwrap_or(plan.sample_interval_s);
        if let Some(time_constant_s) = self.time_constant_s {
            plan = Plan::for_time_constant(time_constant_s, sample_interval_s).into();
        }
        plan.sample_interval_s = sample_interval_s;
        plan.rudder_limit_rad = self.rudder_limit_rad.unwrap_or(plan.rudder_limit_rad);
        if !self.thrusts.is_empty() {
            plan.thrusts = List::from_slice(&self.thrusts)
                .ok_or_else(|| setting("thrusts: more speeds than a trial has".into()))?;
        }
        self.change_doublets(&mut plan.plan)?;
        plan.stop_when = self.stop_when.or(plan.stop_when);
        let [delay_s, lag_s] = self.servo_s;
        let (delay_s, lag_s) = (
            delay_s.unwrap_or(plan.rudder_delay_s),
            lag_s.unwrap_or(plan.rudder_lag_s),
        );
        Servo::new(delay_s, lag_s).map_err(|invalid| setting(format!("rudder {invalid}")))?;
        (plan.rudder_delay_s, plan.rudder_lag_s) = (delay_s, lag_s);
        plan.max_repeats = self.max_repeats.unwrap_or(plan.max_repeats);
        checked(plan)
    }

    fn change_doublets(&self, plan: &mut Plan<f64>) -> Result<(), Error> {
        for (manoeuvre, amplitude) in [
            (&mut plan.training, self.amplitude_rad),
            (&mut plan.validation, self.validation_amplitude_rad),
        ] {
            if amplitude.is_none() && self.period_s.is_none() {
                continue;
            }
            let Excitation::Doublet {
                amplitude_rad,
                period_s,
            } = &mut manoeuvre.excitation
            else {
                return Err(Error::Setting(
                    "amplitudes and periods are set for doublets only; edit the plan file".into(),
                ));
            };
            *amplitude_rad = amplitude.unwrap_or(*amplitude_rad);
            *period_s = self.period_s.unwrap_or(*period_s);
        }
        Ok(())
    }
}

fn checked(plan: TrialPlan) -> Result<TrialPlan, Error> {
    plan.check()
        .map(|()| plan)
        .map_err(|error| Error::Setting(format!("the plan: {error}")))
}

/// What vehicle is expected: models, else a simulated vehicle by name, else [`DEFAULT_VEHICLE`].
#[derive(Clone, Debug, Default)]
pub struct Expected {
    /// A simulated vehicle.
    pub vehicle: Option<String>,
    /// Models that are known of it.
    pub models: Option<Models>,
    /// What is said of it besides.
    pub stated: Stated,
}

/// What is believed of a vehicle, where that comes from, and what to know about it.
struct Belief {
    origin: String,
    prior: Prior,
    warnings: Vec<String>,
}

impl Expected {
    /// The default vehicle has the time constant that the plan was made for, s.
    fn belief(&self, plan: &Plan<f64>, time_constant_s: Option<f64>) -> Result<Belief, Error> {
        let of_simulator = |name: &str| {
            let prior = simulated::prior(name, plan);
            prior.map_err(|error| Error::Setting(error.to_string()))
        };
        let mut belief = match (&self.models, &self.vehicle, time_constant_s) {
            (Some(models), ..) => {
                let (prior, warnings) = self.stated.of_models(models, plan)?;
                Belief {
                    origin: models.origin.clone(),
                    prior,
                    warnings,
                }
            }
            (None, None, Some(time_constant_s)) => Belief {
                origin: format!(
                    "{DEFAULT_VEHICLE} with a time constant of {} s",
                    three_figures(time_constant_s)
                ),
                prior: of_simulator(DEFAULT_VEHICLE)?.slowed(times_slower(time_constant_s)),
                warnings: Vec::new(),
            },
            (None, vehicle, _) => {
                let name = vehicle.as_deref().unwrap_or(DEFAULT_VEHICLE);
                Belief {
                    origin: name.into(),
                    prior: of_simulator(name)?,
                    warnings: Vec::new(),
                }
            }
        };
        self.stated.apply(&mut belief.prior)?;
        Ok(belief)
    }
}

/// The document of `plan --json`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlannedTrial {
    /// `seatrial.plan.v1`
    pub schema: &'static str,
    /// The plan.
    pub plan: TrialPlan,
    /// What it does on the vehicle that is expected.
    pub preview: ExpectedTrial,
    /// Manoeuvres of the same amplitude and duration, where they are asked for.
    pub comparison: Option<Comparison>,
    /// Doublets for a target, where one is given.
    pub recommendation: Option<Recommendations>,
    /// What to know of the models that were believed in.
    #[serde(skip)]
    pub warnings: Vec<String>,
}

/// A preview, and of what vehicle.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ExpectedTrial {
    /// Where the models and the noise come from.
    pub vehicle: String,
    /// What the plan does.
    #[serde(flatten)]
    pub preview: Preview,
}

/// Doublets that reach a target.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Recommendations {
    /// The widths to reach.
    pub target: Target,
    /// One for each thrust, then one for all of them.
    pub doublets: Vec<Recommendation>,
}

/// What to see of a plan besides its preview.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wanted {
    /// Recommend doublets whose 95 % intervals are this narrow.
    pub target: Option<Target>,
    /// Compare manoeuvres of the training's amplitude and duration.
    pub comparison: bool,
}

/// A plan and what to expect of it.
pub fn plan_trial(
    changes: &Changes,
    expected: &Expected,
    wanted: Wanted,
) -> Result<PlannedTrial, Error> {
    let plan = changes.plan()?;
    let Belief {
        origin,
        prior,
        warnings,
    } = expected.belief(&plan, changes.time_constant_s)?;
    let preview =
        preview(&plan, &prior).map_err(|error| Error::Setting(format!("the plan: {error}")))?;
    Ok(PlannedTrial {
        schema: "seatrial.plan.v1",
        plan,
        preview: ExpectedTrial {
            vehicle: origin,
            preview,
        },
        comparison: wanted.comparison.then(|| compare_designs(&plan, &prior)),
        recommendation: wanted.target.map(|target| Recommendations {
            target,
            doublets: recommend(&plan, &prior, target),
        }),
        warnings,
    })
}

impl PlannedTrial {
    /// Does the plan stay within its envelope, tell enough at every speed for a model to be accepted, and is the target, where
    /// there is one, within reach?
    pub fn will_do(&self) -> bool {
        let preview = &self.preview.preview;
        let is_told = |speed: &seatrial::preview::SpeedPreview| {
            speed.expected.is_some_and(|expected| expected.is_enough())
        };
        let is_reached = |found: &Recommendations| {
            !found.doublets.is_empty() && found.doublets.iter().all(|doublet| doublet.reachable)
        };
        preview.outcome == Some(Outcome::Finished)
            && preview.speeds.iter().all(is_told)
            && self.recommendation.as_ref().is_none_or(is_reached)
    }
}
