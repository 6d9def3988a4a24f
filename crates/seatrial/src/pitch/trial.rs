//! The pitch trial: settle, elevator doublet to train on, a smaller one to validate on, at each thrust.

use std::convert::Infallible;
use std::iter::Copied;
use std::slice::Iter;

use seatrial_core::{Diving, DivingSample, DivingVehicle};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::{NoPitchModel, PitchIdentification, identify};
use crate::record::Window;

/// What a pitch trial does.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PitchPlan {
    /// The speeds, as thrust in fractions of full.
    pub thrusts: Vec<f64>,
    /// Time on a steady depth before training, s.
    pub settle_s: f64,
    /// Time from the start of a stage to its doublet, s.
    pub lead_in_s: f64,
    /// Length of the whole doublet, s.
    pub doublet_s: f64,
    /// Time from the end of the doublet to the end of the stage, s.
    pub observe_s: f64,
    /// Amplitude of the training doublet, rad.
    pub training_rad: f64,
    /// Amplitude of the validation doublet, rad.
    pub validation_rad: f64,
    /// Largest change of depth, m: beyond it the trial is aborted and the depth held.
    pub depth_band_m: f64,
    /// Largest pitch, rad: beyond it the trial is aborted and the depth held.
    pub pitch_limit_rad: f64,
}

/// No stage is longer, s.
const LONGEST_S: f64 = 600.0;
/// No change of depth beyond this is allowed, m.
const WIDEST_BAND_M: f64 = 100.0;

impl Default for PitchPlan {
    /// The paper's for yaw, with a doublet of half its length and two thirds of its size: pitch changes depth.
    fn default() -> Self {
        Self {
            thrusts: vec![0.6, 0.7, 0.8, 0.9, 1.0],
            settle_s: 40.0,
            lead_in_s: 2.0,
            doublet_s: 2.0,
            observe_s: 12.5,
            training_rad: 0.18,
            validation_rad: 0.12,
            depth_band_m: 1.0,
            pitch_limit_rad: 0.5,
        }
    }
}

impl PitchPlan {
    /// Names the first field that is out of range, and what it has to be.
    pub fn check(&self) -> Result<(), (&'static str, &'static str)> {
        let a_while = |x: f64| x > 0.0 && x <= LONGEST_S;
        let thrusts_are_fractions = self.thrusts.iter().all(|x| *x > 0.0 && *x <= 1.0);
        let angle = |x: f64| x > 0.0 && x < core::f64::consts::FRAC_PI_2;
        let (a_time, an_angle) = (
            "a time above 0 and at most 600 s",
            "an angle above 0 and below pi/2",
        );
        let checks = [
            (
                "thrusts",
                !self.thrusts.is_empty() && thrusts_are_fractions,
                "at least one fraction of full thrust",
            ),
            ("settle_s", a_while(self.settle_s), a_time),
            ("lead_in_s", a_while(self.lead_in_s), a_time),
            ("doublet_s", a_while(self.doublet_s), a_time),
            ("observe_s", a_while(self.observe_s), a_time),
            ("training_rad", angle(self.training_rad), an_angle),
            ("validation_rad", angle(self.validation_rad), an_angle),
            (
                "depth_band_m",
                self.depth_band_m > 0.0 && self.depth_band_m <= WIDEST_BAND_M,
                "a depth above 0 and at most 100 m",
            ),
            ("pitch_limit_rad", angle(self.pitch_limit_rad), an_angle),
        ];
        match checks.into_iter().find(|(_, holds, _)| !holds) {
            Some((field, _, requirement)) => Err((field, requirement)),
            None => Ok(()),
        }
    }
}

/// What became of a pitch trial.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PitchTrial {
    /// The plan.
    pub plan: PitchPlan,
    /// One entry a thrust.
    pub runs: Vec<PitchRun>,
    /// Why it ended early, where it did; the vehicle then holds its depth.
    pub aborted: Option<String>,
    /// Every sample.
    #[serde(skip)]
    pub samples: Vec<DivingSample<f64>>,
}

/// One thrust of a pitch trial.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PitchRun {
    /// Thrust as a fraction of full.
    pub thrust: f64,
    /// Mean forward speed over the training stage, m/s.
    pub surge_speed_m_s: Option<f64>,
    /// Greatest deviation from the depth at the start of training, m.
    pub depth_excursion_m: Option<f64>,
    /// The model; `None` where there is none.
    pub identification: Option<PitchIdentification>,
    /// Why there is none.
    pub refused: Option<String>,
}

impl PitchRun {
    /// Does it have a model that is accepted?
    pub fn is_accepted(&self) -> bool {
        self.identification.as_ref().is_some_and(|i| i.accepted)
    }
}

/// Why a pitch trial ends early.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
enum Abort {
    #[error("pitch of {:.0} degrees, the limit is {:.0}", pitch_rad.to_degrees(), limit_rad.to_degrees())]
    Pitch { pitch_rad: f64, limit_rad: f64 },
    #[error("depth changed from {start_m:.2} to {depth_m:.2} m, the limit is {limit_m:.2} m")]
    Depth {
        start_m: f64,
        depth_m: f64,
        limit_m: f64,
    },
    #[error("the vehicle takes no more commands")]
    NoMoreCommands,
    #[error("the vehicle sends no more samples")]
    NoMoreSamples,
}

/// Runs a pitch trial. The vehicle holds its own depth before, between and after the doublets, and its
/// heading throughout.
pub fn trial<V: DivingVehicle<f64>>(vehicle: &mut V, plan: PitchPlan) -> PitchTrial {
    let mut trial = PitchTrial {
        plan,
        runs: Vec::new(),
        aborted: None,
        samples: Vec::new(),
    };
    for thrust in trial.plan.thrusts.clone() {
        match trial.run(vehicle, thrust) {
            Ok(run) => trial.runs.push(run),
            Err(reason) => {
                // Whatever the vehicle answers, there is nothing else to hand it.
                let _ = vehicle.dive(Diving::HoldDepth, thrust);
                trial.aborted = Some(reason.to_string());
                break;
            }
        }
    }
    trial
}

/// A vehicle that only says what it said before.
struct Recorded<'a>(Copied<Iter<'a, DivingSample<f64>>>);

impl DivingVehicle<f64> for Recorded<'_> {
    type Error = Infallible;

    fn next_diving_sample(&mut self) -> Result<Option<DivingSample<f64>>, Infallible> {
        Ok(self.0.next())
    }

    fn dive(&mut self, _: Diving<f64>, _: f64) -> Result<(), Infallible> {
        Ok(())
    }
}

impl PitchTrial {
    /// The trial once more on the samples that it took: equal, bit for bit, if nothing was changed.
    pub fn again(&self) -> Self {
        trial(
            &mut Recorded(self.samples.iter().copied()),
            self.plan.clone(),
        )
    }

    fn run<V: DivingVehicle<f64>>(
        &mut self,
        vehicle: &mut V,
        thrust: f64,
    ) -> Result<PitchRun, Abort> {
        let begun = self.samples.len();
        self.stage(vehicle, thrust, self.plan.settle_s, 0.0)?;
        let stage_s = self.plan.lead_in_s + self.plan.doublet_s + self.plan.observe_s;
        let training = self.stage(vehicle, thrust, stage_s, self.plan.training_rad)?;
        let validation = self.stage(vehicle, thrust, stage_s, self.plan.validation_rad)?;
        let samples = &self.samples[begun..];
        let trained = || samples.iter().filter(|s| training.contains(s.time_s));
        let speeds: Option<Vec<f64>> = trained().map(|s| s.surge_speed_m_s).collect();
        let start_m = trained().next().and_then(|s| s.depth_m);
        let excursions = start_m.map(|start_m| {
            let depths = samples.iter().filter(|s| s.time_s >= training.from_s);
            let away = depths.filter_map(|s| Some((s.depth_m? - start_m).abs()));
            away.fold(0.0, f64::max)
        });
        let found: Result<PitchIdentification, NoPitchModel> =
            identify(samples, training, Some(validation));
        Ok(PitchRun {
            thrust,
            surge_speed_m_s: speeds.map(|v| v.iter().sum::<f64>() / v.len() as f64),
            depth_excursion_m: excursions,
            refused: found.as_ref().err().map(ToString::to_string),
            identification: found.ok(),
        })
    }

    /// One stage, with a doublet after the lead-in where the amplitude is not 0; its window.
    fn stage<V: DivingVehicle<f64>>(
        &mut self,
        vehicle: &mut V,
        thrust: f64,
        seconds: f64,
        amplitude_rad: f64,
    ) -> Result<Window, Abort> {
        let first = self.next(vehicle)?;
        let mut sample = first;
        loop {
            let elapsed_s = sample.time_s - first.time_s;
            self.check(&first, &sample)?;
            if elapsed_s + 1e-6 >= seconds {
                return Ok(Window {
                    from_s: first.time_s,
                    to_s: sample.time_s,
                });
            }
            let into_s = elapsed_s - self.plan.lead_in_s;
            let diving = if amplitude_rad == 0.0 || !(0.0..self.plan.doublet_s).contains(&into_s) {
                Diving::HoldDepth
            } else if into_s < 0.5 * self.plan.doublet_s {
                Diving::Elevator(amplitude_rad)
            } else {
                Diving::Elevator(-amplitude_rad)
            };
            vehicle
                .dive(diving, thrust)
                .map_err(|_| Abort::NoMoreCommands)?;
            sample = self.next(vehicle)?;
        }
    }

    fn next<V: DivingVehicle<f64>>(&mut self, vehicle: &mut V) -> Result<DivingSample<f64>, Abort> {
        match vehicle.next_diving_sample() {
            Ok(Some(sample)) => {
                self.samples.push(sample);
                Ok(sample)
            }
            Ok(None) | Err(_) => Err(Abort::NoMoreSamples),
        }
    }

    fn check(&self, first: &DivingSample<f64>, now: &DivingSample<f64>) -> Result<(), Abort> {
        if now.pitch_rad.abs() > self.plan.pitch_limit_rad {
            return Err(Abort::Pitch {
                pitch_rad: now.pitch_rad,
                limit_rad: self.plan.pitch_limit_rad,
            });
        }
        match first.depth_m.zip(now.depth_m) {
            Some((start_m, depth_m)) if (depth_m - start_m).abs() > self.plan.depth_band_m => {
                Err(Abort::Depth {
                    start_m,
                    depth_m,
                    limit_m: self.plan.depth_band_m,
                })
            }
            _ => Ok(()),
        }
    }
}
