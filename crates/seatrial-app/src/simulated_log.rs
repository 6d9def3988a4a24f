//! The log of a trial on a simulated vehicle, and the truth behind it.

use seatrial::campaign::{Run, Stage};
use seatrial::{Campaign, Step, Window};
use seatrial_core::{Excitation, InvalidSetting, List, Outcome, Plan, Sample, Trial};
use seatrial_sim::{ConfigError, SimulatedConfig, SimulatedVehicle, Truth};
use serde::{Deserialize, Serialize};

use crate::conduct::{Judging, Watch, conduct_judging};
use crate::{Error, TrialPlan};

/// One run of the trial and where its stages lie in the log.
#[derive(Clone, Debug, Serialize)]
pub struct SimulatedRun {
    /// Thrust as a fraction of full.
    pub thrust: f64,
    /// 1 for the first attempt at this thrust.
    pub attempt: u32,
    /// The training stage.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub train: Option<Window>,
    /// The validation stage.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub validate: Option<Window>,
}

/// The truth of a simulated log.
#[derive(Clone, Debug, Serialize)]
pub struct SimulatedTruth {
    schema: &'static str,
    seed: u64,
    runs: Vec<TrueRun>,
    vehicle: SimulatedConfig,
}

#[derive(Clone, Debug, Serialize)]
struct TrueRun {
    attempt: u32,
    /// What an identification should find, for six degrees of freedom what it finds without noise.
    #[serde(flatten)]
    truth: Option<Truth>,
}

/// A trial that was played to its end.
#[derive(Clone, Debug, Default)]
pub struct SimulatedTrial {
    /// Every sample.
    pub samples: Vec<Sample<f64>>,
    /// Its runs.
    pub runs: Vec<SimulatedRun>,
    /// How it ended.
    pub outcome: Option<Outcome>,
}

impl SimulatedTruth {
    /// What the runs on a vehicle of this configuration should find.
    pub fn of(
        vehicle: SimulatedConfig,
        seed: u64,
        runs: &[SimulatedRun],
    ) -> Result<Self, ConfigError> {
        let true_run = |run: &SimulatedRun| {
            Ok(TrueRun { attempt: run.attempt, truth: vehicle.truth(run.thrust)? })
        };
        Ok(Self {
            schema: "seatrial.truth.v1",
            seed,
            runs: runs.iter().map(true_run).collect::<Result<_, ConfigError>>()?,
            vehicle,
        })
    }
}

/// The paper's vehicle, as it is played.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum SeaVehicle {
    /// In six degrees of freedom, in water that moves.
    SixDegreesOfFreedom {
        /// Current towards east, across the course, m/s.
        current_m_s: f64,
    },
    /// As the first-order model of yaw that an identification looks for.
    FirstOrder {
        /// Time constant with which the rudder follows its command, s. The log has the command alone.
        rudder_lag_s: f64,
    },
}

/// One speed of a trial of the paper's vehicle.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SeaTrial {
    /// The vehicle.
    pub vehicle: SeaVehicle,
    /// Thrust as a fraction of full.
    pub thrust: f64,
    /// Standard deviation of the compass, rad.
    pub compass_noise_rad: f64,
    /// Rudder of the training doublet, rad; that for validation has three fifths of it.
    pub rudder_rad: f64,
    /// Seed of the noise; the same seed gives the same log.
    pub seed: u64,
}

impl SeaVehicle {
    /// Its name among the vehicles that need no file, and what of its file is not as usual.
    fn parts(&self) -> (&'static str, String) {
        match self {
            Self::SixDegreesOfFreedom { current_m_s } => (
                "starfish-6dof",
                format!(
                    "[[sea.current]]\ndepth_m = 0.0\nnorth_m_s = 0.0\neast_m_s = {current_m_s:?}\n"
                ),
            ),
            Self::FirstOrder { rudder_lag_s } => {
                ("starfish", format!("[servo]\ntime_constant_s = {rudder_lag_s:?}\n"))
            }
        }
    }
}

impl SeaTrial {
    /// Plays it: the log and what an identification should find in it.
    pub fn play(&self) -> Result<(SimulatedTrial, Option<Truth>), Error> {
        let setting = |error: &dyn std::fmt::Display| Error::Setting(error.to_string());
        let (name, fields) = self.vehicle.parts();
        let vehicle = SimulatedConfig::built_in(name)
            .ok_or_else(|| Error::Setting(format!("no vehicle {name}")))?;
        let fields =
            format!("{fields}\n[sensors.compass]\nnoise_rad = {:?}\n", self.compass_noise_rad);
        let fields = toml::from_str(&fields).map_err(|error| setting(&error))?;
        let vehicle = vehicle.with(fields).map_err(|error| setting(&error))?;
        let truth = vehicle.truth(self.thrust).map_err(|error| setting(&error))?;
        let mut simulated = vehicle.vehicle(self.seed).map_err(|error| setting(&error))?;
        let played = play(&mut simulated, self.plan()).map_err(|error| setting(&error))?;
        Ok((played, truth))
    }

    fn plan(&self) -> Plan<f64> {
        let mut plan = Plan::paper();
        plan.thrusts = List::from_slice(&[self.thrust]).unwrap_or(plan.thrusts);
        for (manoeuvre, share) in [(&mut plan.training, 1.0), (&mut plan.validation, 0.6)] {
            if let Excitation::Doublet { amplitude_rad, .. } = &mut manoeuvre.excitation {
                *amplitude_rad = share * self.rudder_rad;
            }
        }
        plan
    }
}

/// Plays a trial on a simulated vehicle without identifying anything: its samples, and where each stage of each run lies in them.
pub fn play(
    vehicle: &mut SimulatedVehicle,
    plan: Plan<f64>,
) -> Result<SimulatedTrial, InvalidSetting> {
    let mut samples = Samples::default();
    let about = Campaign::of("", &plan);
    let plan = TrialPlan::from(plan).checked()?;
    let played = conduct_judging(vehicle, &plan, about, &mut samples, Judging::ByTrial);
    let runs = played.campaign.runs.iter().map(|run: &Run| SimulatedRun {
        thrust: run.thrust,
        attempt: run.attempt,
        train: run.stage(Stage::Train),
        validate: run.stage(Stage::Validate),
    });
    Ok(SimulatedTrial {
        samples: samples.0,
        runs: runs.collect(),
        outcome: played.campaign.outcome,
    })
}

/// Every sample of a trial.
#[derive(Default)]
struct Samples(Vec<Sample<f64>>);

impl Watch for Samples {
    fn step(&mut self, step: &Step, _: &Trial<f64>) {
        self.0.push(step.sample);
    }
}
