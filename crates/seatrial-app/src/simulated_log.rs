//! The log of a trial on a simulated vehicle, and the truth behind it.

use seatrial::Window;
use seatrial_core::{Event, InvalidSetting, Outcome, Plan, Sample, Stage, Trial, Vehicle};
use seatrial_sim::{ConfigError, SimulatedConfig, SimulatedVehicle, Truth};
use serde::Serialize;

/// One run of the trial and where its stages lie in the log.
#[derive(Clone, Debug, Serialize)]
pub struct PlayedRun {
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
pub struct Played {
    /// Every sample.
    pub samples: Vec<Sample<f64>>,
    /// Its runs.
    pub runs: Vec<PlayedRun>,
    /// How it ended.
    pub outcome: Option<Outcome>,
}

impl SimulatedTruth {
    /// What the runs on a vehicle of this configuration should find.
    pub fn of(
        vehicle: SimulatedConfig,
        seed: u64,
        runs: &[PlayedRun],
    ) -> Result<Self, ConfigError> {
        let true_run = |run: &PlayedRun| {
            Ok(TrueRun {
                attempt: run.attempt,
                truth: vehicle.truth(run.thrust)?,
            })
        };
        Ok(Self {
            schema: "seatrial.truth.v1",
            seed,
            runs: runs
                .iter()
                .map(true_run)
                .collect::<Result<_, ConfigError>>()?,
            vehicle,
        })
    }
}

/// Plays a trial on a vehicle.
pub fn play(vehicle: &mut SimulatedVehicle, plan: Plan<f64>) -> Result<Played, InvalidSetting> {
    let mut trial = Trial::new(plan)?;
    let mut played = Played::default();
    while let Ok(Some(sample)) = vehicle.next_sample() {
        played.samples.push(sample);
        let action = trial.step(&sample);
        while let Some(event) = trial.take_event() {
            played.note(event);
        }
        let Ok(()) = vehicle.act(&action);
        if action.outcome.is_some() {
            break;
        }
    }
    played.outcome = trial.outcome();
    Ok(played)
}

impl Played {
    fn note(&mut self, event: Event<f64>) {
        if let Event::RunStarted {
            thrust, attempt, ..
        } = event
        {
            self.runs.push(PlayedRun {
                thrust,
                attempt,
                train: None,
                validate: None,
            });
        }
        let Some(run) = self.runs.last_mut() else {
            return;
        };
        match event {
            Event::StageStarted {
                stage: Stage::Train,
                time_s,
            } => run.train = Some(open_from(time_s)),
            Event::StageStarted {
                stage: Stage::Validate,
                time_s,
            } => {
                run.close_stage(time_s);
                run.validate = Some(open_from(time_s));
            }
            Event::RunFinished { time_s, .. } | Event::Ended { time_s, .. } => {
                run.close_stage(time_s);
            }
            _ => {}
        }
    }
}

fn open_from(from_s: f64) -> Window {
    Window {
        from_s,
        to_s: f64::INFINITY,
    }
}

impl PlayedRun {
    fn close_stage(&mut self, time_s: f64) {
        for window in [&mut self.train, &mut self.validate].into_iter().flatten() {
            window.to_s = window.to_s.min(time_s);
        }
    }
}
