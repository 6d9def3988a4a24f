//! One trial with a fault, and whether it ended as it must.

use std::collections::HashMap;
use std::fmt;
use std::sync::Mutex;

use seatrial::campaign::{Campaign, Run, Stage};
use seatrial::identification::{Identification, Reason, ReasonCode, ReasonKind, Subject};
use seatrial_core::{AbortReason, Envelope, Outcome, Plan, YawModel};
use seatrial_sim::faults::{Fault, Kind, Moment, Onset, Upset};
use seatrial_sim::sensors::Chance;
use seatrial_sim::{FaultyVehicle, Scenario, SimulatedConfig};
use serde::Serialize;

use crate::observer::{Instant, Observer};
use seatrial_app::trials::order::rehearse;

/// Time from the condition of an abort to neutral rudder and heading hold, s.
const HANDED_BACK_WITHIN_S: f64 = 0.5;
/// Half widths of its 95 % intervals within which an accepted model must be of the truth.
pub const HALF_WIDTHS: f64 = 3.0;
/// The parameters of a model in the order of their distances from the truth.
pub const PARAMETERS: [&str; 3] = ["a22", "b2", "C0"];
/// The fault begins within this of the start of its moment, s.
const BEGINS_WITHIN_S: [f64; Moment::ALL.len()] = [10.0, 4.0, 10.0, 8.0, 10.0];

/// How a trial with a fault ended.
#[derive(Clone, Debug, Serialize)]
pub struct Ending {
    /// The seed of fault, vehicle and noise.
    pub seed: u64,
    /// The fault's numbers.
    pub values: [f64; 2],
    /// How long it lasted, s; for ever where null.
    pub for_s: Option<f64>,
    /// When it began, on the vehicle's clock, s.
    pub began_s: Option<f64>,
    /// What became of the trial.
    pub result: Result,
    /// Why it was aborted, or the first reason of the last run that was rejected.
    pub reason: Option<Why>,
    /// The largest distance of an accepted model from the truth, in half widths of its 95 % interval.
    pub farthest: Option<f64>,
    /// From the condition of the abort to neutral rudder and heading hold, s.
    pub handed_back_after_s: Option<f64>,
    /// What is not as it must be.
    pub faults: Vec<String>,
}

/// Why a trial gave no model: the code of an abort or of a verdict.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(untagged)]
pub enum Why {
    /// The trial was aborted.
    Aborted(AbortReason),
    /// A run was rejected.
    Rejected(String),
}

impl fmt::Display for Why {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Aborted(reason) => reason.serialize(f),
            Self::Rejected(code) => code.fmt(f),
        }
    }
}

/// What became of a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Result {
    /// A model at every speed.
    Models,
    /// A speed without an accepted model.
    Rejected,
    /// Aborted.
    Aborted,
}

/// The vehicle, its plan, and what is known of its truth.
pub struct Rehearsal {
    /// What the vehicle is made from.
    pub config: SimulatedConfig,
    /// The plan of every trial.
    pub plan: Plan<f64>,
    /// Truths of damaged vehicles of six degrees of freedom by what is wrong with them.
    truths: Mutex<HashMap<String, Option<YawModel<f64>>>>,
}

impl Rehearsal {
    /// A run of this plan on this vehicle.
    pub fn new(config: SimulatedConfig, plan: Plan<f64>) -> Self {
        Self { config, plan, truths: Mutex::default() }
    }

    /// A trial with a fault of usual size at a chance instant of a moment; `None` where the vehicle cannot play it.
    pub fn play(&self, kind: Kind, moment: Moment, seed: u64) -> Option<Ending> {
        let [mut chance] = Chance::sources(!seed);
        let onset = Onset::Stage {
            stage: moment,
            run: 1,
            after_s: BEGINS_WITHIN_S[moment as usize] * chance.uniform(),
        };
        let fault = Fault::drawn(kind, onset, &mut chance);
        let vehicle = self.config.vehicle(seed).ok()?;
        let vehicle = FaultyVehicle::new(vehicle, &Scenario::of(fault), seed).ok()?;
        let mut observer = Observer::new(vehicle, u64::MAX, true);
        let campaign = rehearse(&mut observer, "", seed, self.plan).ok()?.campaign;
        Some(self.judge(fault, seed, &campaign, &observer))
    }

    fn judge(&self, fault: Fault, seed: u64, campaign: &Campaign, seen: &Observer) -> Ending {
        let began_s = seen.vehicle().first_fault_s();
        let aborted = match campaign.outcome {
            Some(Outcome::Aborted(reason)) => Some(reason),
            _ => None,
        };
        let rejected: Vec<&Run> = campaign
            .runs
            .iter()
            .filter(|run| !run.verdict.accepted && run.identification.is_some())
            .collect();
        let handed_back_after_s = aborted.and_then(|reason| handed_back_after_s(seen, reason));
        let mut faults = unexpected(&fault, aborted, &rejected, began_s.is_some());
        if aborted.is_some()
            && !handed_back_after_s.is_some_and(|after_s| after_s <= HANDED_BACK_WITHIN_S)
        {
            faults.push(format!("handed back after {handed_back_after_s:?} s"));
        }
        let farthest = self.farthest(campaign, seen, &mut faults);
        let result = if aborted.is_some() {
            Result::Aborted
        } else if campaign.accepted_runs().len() == self.plan.thrusts.len() {
            Result::Models
        } else {
            Result::Rejected
        };
        let rejection = rejected.last().and_then(|run| run.verdict.reasons.first());
        Ending {
            seed,
            values: fault.values,
            for_s: fault.for_s,
            began_s,
            result,
            reason: aborted
                .map(Why::Aborted)
                .or_else(|| rejection.map(|reason| Why::Rejected(reason.kind().to_string()))),
            farthest,
            handed_back_after_s,
            faults,
        }
    }

    /// The largest distance of an accepted model from the truth; each that is too far is a fault.
    fn farthest(
        &self,
        campaign: &Campaign,
        seen: &Observer,
        faults: &mut Vec<String>,
    ) -> Option<f64> {
        let mut farthest: Option<f64> = None;
        for run in campaign.runs.iter().filter(|run| run.verdict.accepted) {
            let Some(identification) = &run.identification else {
                continue;
            };
            let (parameter, distance) = self.distance(run, identification, &seen.instants);
            farthest = Some(farthest.map_or(distance, |other| other.max(distance)));
            if distance > HALF_WIDTHS {
                faults.push(format!(
                    "run {} accepted with {parameter} {distance:.1} half widths from the truth",
                    run.number
                ));
            }
        }
        farthest
    }

    /// The parameter that is farthest from what was true during the training, and how far, in half widths of its interval.
    fn distance(
        &self,
        run: &Run,
        found: &Identification,
        instants: &[Instant],
    ) -> (&'static str, f64) {
        let Some(off) = self.distances(run, found, instants) else {
            return ("every parameter", f64::INFINITY);
        };
        let all = PARAMETERS.into_iter().zip(off);
        let farther = |a: (_, f64), b: (_, f64)| if b.1 > a.1 { b } else { a };
        all.fold(("a22", 0.0), farther)
    }

    /// How far a22, b2 and C0 are from what was true during the training, in half widths of their 95 % intervals; `None` without
    /// a refined estimate.
    ///
    /// A truth that changed in that time is every value in between.
    pub fn distances(
        &self,
        run: &Run,
        found: &Identification,
        instants: &[Instant],
    ) -> Option<[f64; 3]> {
        let training = run.stage(Stage::Train)?;
        let refined = found.refined.as_ref()?;
        let mut least = [f64::INFINITY; 3];
        let mut greatest = [f64::NEG_INFINITY; 3];
        let mut last: Option<(Upset, Option<YawModel<f64>>)> = None;
        for instant in instants.iter().filter(|i| training.contains(i.time_s)) {
            if instant.upset.rudder_jammed {
                continue;
            }
            let truth = match last {
                // Six degrees of freedom: the same as long as the same is wrong.
                Some((upset, truth)) if instant.model.is_none() && upset == instant.upset => truth,
                _ => instant.model.or_else(|| self.truth(run.thrust, &instant.upset)),
            };
            last = Some((instant.upset, truth));
            for (k, value) in truth.iter().flat_map(|truth| truth.theta().into_iter().enumerate()) {
                least[k] = least[k].min(value);
                greatest[k] = greatest[k].max(value);
            }
        }
        let intervals = [
            refined.interval_95.a22_per_s,
            refined.interval_95.b2_per_s2,
            refined.interval_95.c0_rad_per_s2,
        ];
        let [a22, b2, c0] = intervals;
        let off = |k: usize, [low, high]: [f64; 2]| {
            let value = refined.model.theta()[k];
            let outside = (least[k] - value).max(value - greatest[k]).max(0.0);
            outside / (0.5 * (high - low))
        };
        Some([off(0, a22), off(1, b2), off(2, c0)])
    }

    /// The truth of a damaged vehicle of six degrees of freedom as its samples show it.
    fn truth(&self, thrust: f64, upset: &Upset) -> Option<YawModel<f64>> {
        let left = thrust * upset.thrust_left;
        let offset_rad = upset.rudder_offset_rad;
        let key = format!("{left} {offset_rad} {:?}", upset.damage);
        let known = self.truths.lock().ok()?.get(&key).copied();
        let model = known.unwrap_or_else(|| {
            let damaged = self.config.damaged(&upset.damage);
            let truth = damaged.truth_with_rudder_offset(left, offset_rad);
            truth.ok().flatten()
        });
        let besides = Upset { rudder_offset_rad: 0.0, ..*upset };
        self.truths.lock().ok()?.insert(key, model);
        model.map(|body| besides.apparent(body))
    }
}

/// From the condition of an abort to heading hold after neutral rudder, s.
fn handed_back_after_s(seen: &Observer, reason: AbortReason) -> Option<f64> {
    let [neutral_s, hold_s] = [seen.neutral?, seen.hold?].map(|when| when.clock_s);
    let condition_s = match reason {
        AbortReason::Operator | AbortReason::LinkLost => seen.vehicle().first_fault_s()?,
        AbortReason::StaleSamples => {
            let stale_s = seen.whole().clock_s + Envelope::<f64>::default().stale_after_s;
            stale_s.min(neutral_s)
        }
        _ => seen.beyond_for(reason).map_or(neutral_s, |beyond| beyond.clock_s),
    };
    Some((hold_s - condition_s).max(0.0))
}

/// How a trial with a fault ended otherwise than it may, besides with models; a rejection counts once the fault has come about.
fn unexpected(
    fault: &Fault,
    aborted: Option<AbortReason>,
    rejected: &[&Run],
    began: bool,
) -> Vec<String> {
    let lasts = fault.for_s.is_none();
    let must_abort = match fault.kind {
        Kind::OperatorTakeover => true,
        Kind::CompassDropout | Kind::DepthLoss | Kind::LinkLoss => lasts,
        _ => false,
    };
    let mut faults = Vec::new();
    if let Some(reason) = aborted.filter(|reason| !aborts(fault.kind, lasts).contains(reason)) {
        faults.push(format!("aborted because {}", Why::Aborted(reason)));
    }
    if must_abort && began && aborted.is_none() {
        faults.push("not aborted".into());
    }
    for run in rejected.iter().filter(|_| began) {
        let code = run.verdict.reasons.first().map(Reason::kind);
        if !(code.as_ref()).is_some_and(|code| may_reject(fault.kind, code)) {
            let code = code.map_or_else(String::new, |code| code.to_string());
            faults.push(format!("run {} rejected because {code}", run.number));
        }
    }
    faults
}

/// Reasons for which a trial with this fault may be aborted.
fn aborts(kind: Kind, lasts: bool) -> &'static [AbortReason] {
    use AbortReason::*;
    match kind {
        Kind::CompassDropout | Kind::DepthLoss | Kind::ClockJump => &[StaleSamples],
        Kind::LinkLoss if lasts => &[LinkLost],
        Kind::LinkLoss => &[StaleSamples],
        Kind::OperatorTakeover => &[Operator],
        Kind::DuplicatedSamples | Kind::ReorderedSamples => &[],
        // A vehicle lighter than water cannot hold its depth without speed.
        Kind::ThrustLoss => &[SpeedDrift, Depth],
        Kind::CurrentStep => &[SpeedDrift, HeadingExcursion],
        Kind::CompassSpike | Kind::CompassStep | Kind::CompassDrift => {
            &[HeadingExcursion, ReversedRudder, StaleSamples]
        }
        Kind::CompassFreeze => &[StaleSamples, NoAnswer],
        Kind::RudderJam | Kind::RudderReversed => {
            &[HeadingExcursion, ReversedRudder, NoAnswer, SpeedDrift, YawRate, Roll]
        }
        Kind::RudderOffset | Kind::LostFin | Kind::PayloadChange => {
            &[HeadingExcursion, SpeedDrift, Roll]
        }
    }
}

/// May a run with this fault be rejected for this reason?
fn may_reject(kind: Kind, code: &ReasonKind) -> bool {
    use ReasonCode::*;
    let (code, of) = (&code.code, &code.of);
    let is_of_samples = matches!((code, of), (Damaged, Some(Subject::Samples)));
    let does_not_tell = is_of_samples
        || matches!(
            (code, of),
            (LowR2 | UnderExcited | DoesNotFit, _)
                | (NotIdentifiable, None)
                // What changed between training and validation data gives another model.
                | (Contradicted, _)
        );
    // Noise alone may make the trial repeat a run, or leave the validation data too uncertain.
    let is_noise = matches!((code, of), (LowR2, _) | (UnderExcited, Some(Subject::Validation)));
    match kind {
        Kind::OperatorTakeover | Kind::DepthLoss => is_noise,
        Kind::DuplicatedSamples | Kind::ReorderedSamples => is_noise || is_of_samples,
        Kind::CompassFreeze
        | Kind::CompassStep
        | Kind::CompassSpike
        | Kind::CompassDrift
        | Kind::ClockJump => {
            let is_of_compass = matches!(
                (code, of),
                (CompassError, _) | (YawRateContradicts | Late | Constant, Some(Subject::Heading))
            );
            is_of_compass || does_not_tell
        }
        _ => does_not_tell || matches!((code, of), (Unstable | RudderNotFollowed, None)),
    }
}
