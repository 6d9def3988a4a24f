//! What a plan will do, and how much it will determine, before anything moves.

mod budget;
mod design;
mod expected_vehicle;
mod information;
mod recommendation;
mod surge_step;

use seatrial_core::InvalidSetting;
use seatrial_core::{Outcome, Plan, Real, Sample, Stage, Trial, Vehicle, YawModel};
use serde::Serialize;

pub use budget::Budget;
pub use design::{Comparison, Design, DesignAtSpeed, compare_designs};
pub use information::{ExpectedAccuracy, PredictedQuantity};
pub use recommendation::{InvalidTarget, Recommendation, Target, parse_target, recommend};
pub use surge_step::{AddedRun, SurgeStep, surge_step};

use expected_vehicle::ExpectedVehicle;

use crate::identify::cramer_rao::Noise;

/// The heading that the trial holds is one compass reading; its error is taken to stay within this many
/// standard deviations.
const TRACK_DEVIATIONS: f64 = 3.0;

/// What is believed of a vehicle before its trial.
#[derive(Clone, Debug, PartialEq)]
pub struct Prior {
    /// One for each thrust of the plan.
    pub speeds: Vec<PriorSpeed>,
    /// Forward speed before the trial, m/s.
    pub speed_before_m_s: Option<f64>,
    /// Time constant of the speed after a change of thrust, s; 0 is at once.
    pub surge_time_constant_s: f64,
    /// Heading before the trial, rad.
    pub heading_rad: f64,
    /// Constant depth, m.
    pub depth_m: Option<f64>,
    /// Largest rudder of the vehicle, rad.
    pub rudder_limit_rad: f64,
    /// Largest rudder of its own heading controller, rad.
    pub hold_limit_rad: f64,
    /// Time between samples, s.
    pub sample_interval_s: f64,
}

impl Prior {
    /// A vehicle that does all the same in `times` the time: rates are divided by `times`, accelerations by its square; angles,
    /// gains from heading to rudder and speeds stay.
    ///
    /// ```
    /// use seatrial::identify::cramer_rao::Noise;
    /// use seatrial::preview::{Prior, PriorSpeed};
    /// use seatrial_core::YawModel;
    ///
    /// # let speed = PriorSpeed {
    /// #     thrust: 0.8,
    /// #     surge_speed_m_s: Some(1.6),
    /// #     model: YawModel::from_theta([-1.0, 1.0, 0.01]),
    /// #     hold_gain: 0.5,
    /// #     noise: Noise { heading_rad: 0.005, disturbance_rad_s2: 0.0, disturbance_time_s: 1.0 },
    /// # };
    /// # let prior = Prior {
    /// #     speeds: vec![speed],
    /// #     speed_before_m_s: Some(1.6),
    /// #     surge_time_constant_s: 0.0,
    /// #     heading_rad: 0.0,
    /// #     depth_m: None,
    /// #     rudder_limit_rad: 0.26,
    /// #     hold_limit_rad: 0.26,
    /// #     sample_interval_s: 0.05,
    /// # };
    /// // a22 = -1 1/s and b2 = 1 1/s^2 of a vehicle ten times slower.
    /// let [a22, b2, _] = prior.slowed(10.0).speeds[0].model.theta();
    /// assert!((a22 + 0.1).abs() < 1e-12 && (b2 - 0.01).abs() < 1e-12);
    /// ```
    pub fn slowed(mut self, times: f64) -> Self {
        self.surge_time_constant_s *= times;
        for speed in &mut self.speeds {
            let (model, noise) = (&mut speed.model, &mut speed.noise);
            model.a22_per_s /= times;
            model.b2_per_s2 /= times * times;
            model.c0_rad_per_s2 /= times * times;
            noise.disturbance_rad_s2 /= times * times;
            noise.disturbance_time_s *= times;
        }
        self
    }
}

/// What is believed of the vehicle at one thrust.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PriorSpeed {
    /// Thrust as a fraction of full.
    pub thrust: f64,
    /// Forward speed, m/s.
    pub surge_speed_m_s: Option<f64>,
    /// How it steers.
    #[serde(flatten)]
    pub model: YawModel<f64>,
    /// The vehicle's own heading controller, rudder per heading error.
    pub hold_gain: f64,
    /// The noise to expect on a record.
    pub noise: Noise,
}

/// What a plan will do on the vehicle believed in.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Preview {
    /// How the plan ends: aborted where it does not fit its envelope.
    pub outcome: Option<Outcome>,
    /// Time from the first sample to the last, s, without repeats.
    pub duration_s: f64,
    /// Duration where the vehicle never settles before its time is up, s.
    pub longest_s: f64,
    /// Southernmost, northernmost, westernmost and easternmost point from the start, m, without repeats.
    pub track_box_m: Option<[f64; 4]>,
    /// How far the box is wider than the noise-free track on each side, m.
    pub track_margin_m: Option<f64>,
    /// The speeds reached, in the order of the plan.
    pub speeds: Vec<SpeedPreview>,
}

/// One speed of a preview.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SpeedPreview {
    /// What it was made from.
    #[serde(flatten)]
    pub prior: PriorSpeed,
    /// Length of the settling stage, s.
    pub settle_s: f64,
    /// Length of the training stage, s.
    pub train_s: f64,
    /// Length of the validation stage, s.
    pub validate_s: f64,
    /// Farthest heading from the heading held, rad.
    pub heading_excursion_rad: f64,
    /// What the training stage, as far as the trial comes in it, will determine. `None` where it determines nothing.
    pub expected: Option<ExpectedAccuracy>,
}

/// Plays the plan, with the trial's own state machine, on a noise-free vehicle of the kind believed in, and says
/// what the record of each training stage can determine.
///
/// The intervals are those of the Cramer-Rao bound with the noise of the prior; an estimate does not beat them.
/// The track box is that of the noise-free track, widened on all sides by
///
/// ```text
/// 3 sqrt( (sigma L)^2 + sum V^2 t S ),   S = h sigma^2 + 2 tau (q / (b2 K))^2
/// ```
///
/// | symbol | meaning | unit |
/// |---|---|---|
/// | sigma | standard deviation of the compass: the heading to hold is one reading of it | rad |
/// | L | length of the track | m |
/// | V, t | forward speed and time spent at it | m/s, s |
/// | S | spectral density at zero frequency of the heading under the heading controller | rad^2 s |
/// | h | sampling interval | s |
/// | q, tau | standard deviation and time constant of the disturbance | rad/s^2, s |
/// | K | gain of the heading controller | 1 |
///
/// Currents move the track as a whole; they are not in it.
///
/// # Errors
/// A plan out of its range, or one whose samples are more than [`Budget::OWN_SAMPLES`].
///
/// ```
/// use seatrial::identify::cramer_rao::Noise;
/// use seatrial::preview::{Prior, PriorSpeed, preview};
/// use seatrial_core::{List, Outcome, Plan, YawModel};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let plan = Plan { thrusts: List::from_slice(&[0.8]).unwrap_or_default(), ..Plan::paper() };
/// let speed = PriorSpeed {
///     thrust: 0.8,
///     surge_speed_m_s: Some(1.6),
///     model: YawModel::from_theta([-1.07, 1.08, 0.012]),
///     hold_gain: 0.5,
///     noise: Noise { heading_rad: 0.005, disturbance_rad_s2: 0.0, disturbance_time_s: 1.0 },
/// };
/// let prior = Prior {
///     speeds: vec![speed],
///     speed_before_m_s: Some(1.6),
///     surge_time_constant_s: 0.0,
///     heading_rad: 0.0,
///     depth_m: None,
///     rudder_limit_rad: 0.26,
///     hold_limit_rad: 0.26,
///     sample_interval_s: 0.05,
/// };
/// let foreseen = preview(&plan, &prior)?;
/// assert_eq!(foreseen.outcome, Some(Outcome::Finished));
/// assert!(foreseen.speeds[0].expected.as_ref().is_some_and(|expected| expected.is_enough()));
/// # Ok(())
/// # }
/// ```
pub fn preview(plan: &Plan<f64>, prior: &Prior) -> Result<Preview, InvalidSetting> {
    preview_within(plan, prior, &Budget::of(Budget::OWN_SAMPLES))
}

/// Plays the plan as [`preview`] does, within a budget.
pub fn preview_within(
    plan: &Plan<f64>,
    prior: &Prior,
    budget: &Budget,
) -> Result<Preview, InvalidSetting> {
    let (outcome, played) = play(plan, prior, budget)?;
    let margin_m = track_margin_m(prior, &played);
    let samples = || played.iter().flat_map(|run| &run.samples);
    Ok(Preview {
        outcome,
        duration_s: duration_s(&played),
        longest_s: plan.longest_s(),
        track_box_m: margin_m.and_then(|margin_m| {
            let [south, north] = range(samples().map(|s| s.north_m))?;
            let [west, east] = range(samples().map(|s| s.east_m))?;
            let wider = [south - margin_m, north + margin_m];
            Some([wider[0], wider[1], west - margin_m, east + margin_m])
        }),
        track_margin_m: margin_m,
        speeds: prior
            .speeds
            .iter()
            .zip(&played)
            .map(|(speed, run)| run.preview(speed, plan, prior.heading_rad))
            .collect(),
    })
}

/// How the plan ends on the vehicle believed in, and the samples of each speed.
fn play(
    plan: &Plan<f64>,
    prior: &Prior,
    budget: &Budget,
) -> Result<(Option<Outcome>, Vec<SpeedRun>), InvalidSetting> {
    let mut trial = Trial::new(*plan)?;
    budget.check(plan, prior)?;
    let thrusts = prior.speeds.iter().map(|speed| speed.thrust);
    let vehicle = ExpectedVehicle::new(prior).filter(|_| thrusts.eq(plan.thrusts.iter().copied()));
    let mut vehicle = vehicle.ok_or(InvalidSetting {
        field: "prior.speeds",
        requirement: "one for each thrust of the plan, in its order",
    })?;
    let mut played: Vec<SpeedRun> = Vec::new();
    while trial.outcome().is_none() {
        let Ok(Some(sample)) = vehicle.next_sample() else {
            break;
        };
        budget.take()?;
        let action = trial.step(&sample);
        let status = trial.status();
        let speed = status.speed - 1;
        if let Some(last) = played.last_mut() {
            last.end_s = sample.time_s;
        }
        if status.stage.is_some() && played.len() <= speed {
            played.push(SpeedRun::default());
        }
        if let Some(last) = played.last_mut() {
            last.take(sample, status.stage);
        }
        let Ok(()) = vehicle.act(&action);
    }
    Ok((trial.outcome(), played))
}

/// From the first sample of a trial to its last, s.
fn duration_s(played: &[SpeedRun]) -> f64 {
    let first_s = played.first().map_or(0.0, |p| p.begin_s(Stage::Settle));
    played.last().map_or(0.0, |p| p.end_s) - first_s
}

/// The samples of one speed with the instants at which its stages began.
#[derive(Default)]
struct SpeedRun {
    samples: Vec<Sample<f64>>,
    /// Settle, train, validate.
    began_s: [Option<f64>; 3],
    /// When the next speed began, or the trial ended.
    end_s: f64,
}

impl SpeedRun {
    fn take(&mut self, sample: Sample<f64>, stage: Option<Stage>) {
        if let Some(stage) = stage {
            self.began_s[place(stage)].get_or_insert(sample.time_s);
        }
        self.end_s = sample.time_s;
        self.samples.push(sample);
    }

    /// When a stage began; the end where it did not.
    fn begin_s(&self, stage: Stage) -> f64 {
        self.began_s[place(stage)].unwrap_or(self.end_s)
    }

    fn preview(&self, speed: &PriorSpeed, plan: &Plan<f64>, heading_rad: f64) -> SpeedPreview {
        let [settle_s, train_s, validate_s] =
            [Stage::Settle, Stage::Train, Stage::Validate].map(|stage| self.begin_s(stage));
        let training: Vec<Sample<f64>> = self
            .samples
            .iter()
            .filter(|s| s.time_s >= train_s && s.time_s < validate_s)
            .copied()
            .collect();
        SpeedPreview {
            prior: *speed,
            settle_s: train_s - settle_s,
            train_s: validate_s - train_s,
            validate_s: self.end_s - validate_s,
            heading_excursion_rad: excursion_rad(&self.samples, heading_rad),
            expected: ExpectedAccuracy::of(&training, speed, plan.rudder_limit_rad),
        }
    }
}

fn place(stage: Stage) -> usize {
    match stage {
        Stage::Settle => 0,
        Stage::Train => 1,
        Stage::Validate => 2,
    }
}

/// Farthest heading from the heading held, rad.
fn excursion_rad(samples: &[Sample<f64>], heading_rad: f64) -> f64 {
    samples.iter().map(|s| (s.heading_rad - heading_rad).wrapped().abs()).fold(0.0, f64::max)
}

fn track_margin_m(prior: &Prior, played: &[SpeedRun]) -> Option<f64> {
    let mut length_m = 0.0;
    let mut wander_m2 = 0.0;
    let mut compass_rad = 0.0;
    for (speed, run) in prior.speeds.iter().zip(played) {
        let speed_m_s = speed.surge_speed_m_s?;
        let duration_s = run.end_s - run.begin_s(Stage::Settle);
        let noise = speed.noise;
        let held_rad = noise.disturbance_rad_s2 / (speed.model.b2_per_s2 * speed.hold_gain);
        let density = prior.sample_interval_s * noise.heading_rad.powi(2)
            + 2.0 * noise.disturbance_time_s * held_rad.powi(2);
        length_m += speed_m_s * duration_s;
        wander_m2 += speed_m_s.powi(2) * duration_s * density;
        compass_rad = f64::max(compass_rad, noise.heading_rad);
    }
    let margin_m = TRACK_DEVIATIONS * ((compass_rad * length_m).powi(2) + wander_m2).sqrt();
    margin_m.is_finite().then_some(margin_m)
}

/// Least and greatest. `None` where a value is missing.
fn range(mut values: impl Iterator<Item = Option<f64>>) -> Option<[f64; 2]> {
    values.try_fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
        value.map(|value| [low.min(value), high.max(value)])
    })
}
