//! A plan, and what it will do on the vehicle that is expected, before anything moves.

use std::path::PathBuf;

use seatrial::preview::{
    Budget, Comparison, Preview, Prior, Recommendation, SurgeStep, Target, compare_designs,
    preview, recommend,
};
use seatrial::words::three_figures;
use seatrial_core::plan::times_slower;
use seatrial_core::{Axis, Excitation, List, Outcome, Plan};
use serde::Serialize;

use crate::Error;
use crate::models::Models;
use crate::trials::expectation::PriorOverrides;
use crate::trials::simulator;
use crate::trials::surge_step::{SurgeOverrides, add_surge_step};
use crate::{CheckedPlan, TrialPlan, load_plan};

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
    pub fn plan(&self) -> Result<CheckedPlan, Error> {
        let setting = |message: String| Error::Setting(message);
        if self.file.is_some() && self.time_constant_s.is_some() {
            return Err(setting("a plan file and a time constant: give one of them".into()));
        }
        let mut plan = *load_plan(self.file.as_deref(), Some(Axis::Yaw))?;
        let sample_interval_s = self.sample_interval_s.unwrap_or(plan.sample_interval_s);
        if let Some(time_constant_s) = self.time_constant_s {
            plan = TrialPlan::for_time_constant(time_constant_s, sample_interval_s);
        }
        plan.plan.sample_interval_s = sample_interval_s;
        plan.plan.rudder_limit_rad = self.rudder_limit_rad.unwrap_or(plan.rudder_limit_rad);
        if !self.thrusts.is_empty() {
            plan.plan.thrusts = List::from_slice(&self.thrusts)
                .ok_or_else(|| setting("thrusts: more speeds than a trial has".into()))?;
        }
        self.change_doublets(&mut plan.plan)?;
        plan.stop_when = self.stop_when.or(plan.stop_when);
        let [delay_s, lag_s] = self.servo_s;
        let mut plan = plan.behind_servo(delay_s, lag_s)?;
        plan.plan.max_repeats = self.max_repeats.unwrap_or(plan.max_repeats);
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
            let Excitation::Doublet { amplitude_rad, period_s } = &mut manoeuvre.excitation else {
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

fn checked(plan: TrialPlan) -> Result<CheckedPlan, Error> {
    plan.checked().map_err(|error| Error::Setting(format!("the plan: {error}")))
}

/// What vehicle is expected: models, else a simulated vehicle by name, else [`DEFAULT_VEHICLE`].
#[derive(Clone, Debug, Default)]
pub struct ExpectedVehicle {
    /// A simulated vehicle.
    pub vehicle: Option<String>,
    /// Models that are known of it.
    pub models: Option<Models>,
    /// What is said of it besides.
    pub stated: PriorOverrides,
}

/// What is believed of a vehicle, where that comes from, and what to know about it.
struct Belief {
    origin: String,
    prior: Prior,
    warnings: Vec<String>,
}

impl Belief {
    fn of_simulator(name: &str, plan: &Plan<f64>) -> Result<Self, Error> {
        Ok(Self {
            origin: name.into(),
            prior: simulator::prior(name, plan, &Budget::of(Budget::OWN_SAMPLES))?,
            warnings: Vec::new(),
        })
    }
}

impl ExpectedVehicle {
    /// The default vehicle has the time constant that the plan was made for, s.
    fn belief(&self, plan: &Plan<f64>, time_constant_s: Option<f64>) -> Result<Belief, Error> {
        let name = self.vehicle.as_deref().unwrap_or(DEFAULT_VEHICLE);
        let mut belief = match &self.models {
            Some(models) => {
                let (prior, warnings) = self.stated.of_models(models, plan)?;
                Belief { origin: models.origin.clone(), prior, warnings }
            }
            None => Belief::of_simulator(name, plan)?,
        };
        if let (None, None, Some(time_constant_s)) = (&self.models, &self.vehicle, time_constant_s)
        {
            let time_constant = three_figures(time_constant_s);
            belief.origin = format!("{name} with a time constant of {time_constant} s");
            belief.prior = belief.prior.slowed(times_slower(time_constant_s));
        }
        self.stated.apply(&mut belief.prior)?;
        Ok(belief)
    }
}

impl ExpectedVehicle {
    /// Adds the run to the plan that makes the surge identifiable, where it takes one.
    fn with_surge(
        &self,
        plan: &mut TrialPlan,
        prior: &mut Prior,
        stated: &SurgeOverrides,
        time_constant_s: Option<f64>,
    ) -> Result<SurgeStep, Error> {
        let name = self.vehicle.as_deref().unwrap_or(DEFAULT_VEHICLE);
        let simulator = self.models.is_none().then_some(name);
        let planned = plan.plan;
        let speed_at = |thrust: f64| {
            let alone = Plan { thrusts: List::from_slice(&[thrust])?, ..planned };
            let belief = self.belief(&alone, time_constant_s).ok()?;
            belief.prior.speeds.first().copied()
        };
        add_surge_step(plan, prior, stated, simulator, &speed_at)
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
    /// What the plan tells of the surge, and the run that was added for it, where this is asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub surge: Option<SurgeStep>,
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
pub struct PreviewRequest {
    /// Recommend doublets whose 95 % intervals are this narrow.
    pub target: Option<Target>,
    /// Compare manoeuvres of the training's amplitude and duration.
    pub comparison: bool,
    /// Train with this manoeuvre instead of the plan's.
    pub adopt: Option<Adopt>,
    /// Add the cheapest run that makes the surge identifiable, where the plan does not.
    pub surge: Option<SurgeOverrides>,
}

/// A manoeuvre that a plan may take over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Adopt {
    /// The doublet recommended for the target, for all speeds.
    Recommended,
    /// The 3-2-1-1 of the comparison.
    ThreeTwoOneOne,
    /// The manoeuvre designed within the envelope.
    Designed,
    /// The manoeuvre designed within the heading excursion of the doublet.
    DesignedCalm,
}

impl Adopt {
    /// The manoeuvre, where there is one.
    fn excitation(
        self,
        comparison: Option<&Comparison>,
        recommendation: Option<&Recommendations>,
    ) -> Option<Excitation<f64>> {
        let design = |name: &str| {
            let mut designs = comparison?.designs.iter();
            designs.find(|d| d.name == name).map(|d| d.excitation)
        };
        match self {
            Self::Recommended => recommendation?.doublet_of_all(),
            Self::ThreeTwoOneOne => design("3-2-1-1"),
            Self::Designed => design("designed"),
            Self::DesignedCalm => design("designed_calm"),
        }
    }

    fn none_fits(self) -> Error {
        Error::Rejected(match self {
            Self::Recommended => "--adopt recommended: no doublet within the rudder limit and the envelope reaches the target at every speed; without --adopt the preview says what comes nearest",
            _ => "--adopt: no manoeuvre of this amplitude and duration fits the envelope; lower --amplitude-deg or --period-s",
        }.into())
    }
}

impl Recommendations {
    /// The doublet for all speeds, where it reaches the target.
    fn doublet_of_all(&self) -> Option<Excitation<f64>> {
        let doublet = self.doublets.last().filter(|doublet| doublet.reachable)?;
        Some(Excitation::Doublet {
            amplitude_rad: doublet.amplitude_rad,
            period_s: doublet.period_s,
        })
    }
}

/// A plan and what to expect of it.
///
/// # Errors
/// A plan or a setting out of its range, a vehicle that is not known, a vehicle file that cannot be read, or a manoeuvre to adopt
/// that there is not.
pub fn plan_trial(
    changes: &Changes,
    expected: &ExpectedVehicle,
    wanted: PreviewRequest,
) -> Result<PlannedTrial, Error> {
    if wanted.adopt == Some(Adopt::Recommended) && wanted.target.is_none() {
        return Err(Error::Setting(
            "--adopt recommended: name the widths to reach, as in --target a22:10%,b2:5%".into(),
        ));
    }
    let mut plan = changes.plan()?;
    let Belief { origin, mut prior, warnings } = expected.belief(&plan, changes.time_constant_s)?;
    Budget::of(Budget::OWN_SAMPLES)
        .check(&plan, &prior)
        .map_err(|error| Error::Setting(error.to_string()))?;
    let recommendation = wanted
        .target
        .map(|target| Recommendations { target, doublets: recommend(&plan, &prior, target) });
    let wants_design = wanted.adopt.is_some_and(|adopt| adopt != Adopt::Recommended);
    let comparison = (wanted.comparison || wants_design).then(|| compare_designs(&plan, &prior));
    if let Some(adopt) = wanted.adopt {
        let mut adopting = *plan;
        adopting.plan.training.excitation = adopt
            .excitation(comparison.as_ref(), recommendation.as_ref())
            .ok_or_else(|| adopt.none_fits())?;
        plan = checked(adopting)?;
    }
    let mut plan = *plan;
    let surge = wanted
        .surge
        .map(|stated| expected.with_surge(&mut plan, &mut prior, &stated, changes.time_constant_s))
        .transpose()?;
    let preview =
        preview(&plan, &prior).map_err(|error| Error::Setting(format!("the plan: {error}")))?;
    Ok(PlannedTrial {
        schema: "seatrial.plan.v1",
        plan,
        preview: ExpectedTrial { vehicle: origin, preview },
        comparison,
        recommendation,
        surge,
        warnings,
    })
}

impl PlannedTrial {
    /// Does the plan stay within its envelope, tell enough at every speed for a model to be accepted, is the target, where
    /// there is one, within reach, and is the surge, where it is asked for, identifiable?
    pub fn will_do(&self) -> bool {
        let preview = &self.preview.preview;
        let is_reported = |speed: &seatrial::preview::SpeedPreview| {
            speed.expected.is_some_and(|expected| expected.is_enough())
        };
        let is_reached = |found: &Recommendations| {
            !found.doublets.is_empty() && found.doublets.iter().all(|doublet| doublet.reachable)
        };
        preview.outcome == Some(Outcome::Finished)
            && preview.speeds.iter().all(is_reported)
            && self.recommendation.as_ref().is_none_or(is_reached)
            && self.surge.as_ref().is_none_or(SurgeStep::is_identified)
    }
}
