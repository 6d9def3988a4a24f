//! A campaign: every run of one trial with one configuration of the vehicle.

mod abort_cause;
pub mod speeds;

use std::borrow::Cow;

pub use seatrial_core::Stage;
use seatrial_core::{Axis, Outcome, Plan, YawModel};
use serde::{Deserialize, Serialize};

use crate::identification::{EstimateMethod, Identification, Reason, ReasonCode, Verdict};
use crate::record::{Record, Window};
use crate::servo::Servo;
use abort_cause::Evidence;
use speeds::{Part, SpeedResult, contradictions, load_change, missing, whole};

/// In what the speeds of a campaign are told.
const UNIT: &str = "% thrust";

/// Every run of one trial.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Campaign {
    /// The version of seatrial that ran it.
    pub software_version: String,
    /// The name of the vehicle, as `--vehicle` takes it: `sim:starfish`.
    pub vehicle: String,
    /// The motion that was identified. On the axis of pitch the heading of the samples is the pitch and the rudder the
    /// elevator.
    #[serde(default, skip_serializing_if = "Axis::is_yaw")]
    pub axis: Axis,
    /// Name of the configuration (payload).
    pub configuration: String,
    /// Seed of a simulated vehicle; a campaign with a seed is a rehearsal.
    pub seed: Option<u64>,
    /// Largest rudder angle, rad.
    pub rudder_limit_rad: f64,
    /// The vehicle's rudder at full steering, where it is known.
    #[serde(default)]
    pub full_rudder: Option<FullRudder>,
    /// The file of the faults that a simulated vehicle met.
    #[serde(default)]
    pub scenario: Option<String>,
    /// The runs in the order in which they were made; repeats are runs of their own.
    pub runs: Vec<Run>,
    /// How the trial ended, `None` while it runs.
    pub outcome: Option<Outcome>,
}

/// The rudder at full steering: how a command from -1 to 1 and an angle belong together.
///
/// It belongs to the vehicle; a trial may keep its rudder within a smaller angle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FullRudder {
    /// The angle, rad.
    pub angle_rad: f64,
    /// The angle is not known: models in rad carry its error, models of steering from -1 to 1 do not.
    pub is_assumed: bool,
}

/// One run: settle, train and validate at one thrust.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// 1 for the first run of the campaign.
    pub number: u32,
    /// Thrust as a fraction of full.
    pub thrust: f64,
    /// 1 for the first try at this thrust.
    pub attempt: u32,
    /// Mean forward speed over the training stage, m/s.
    pub surge_speed_m_s: Option<f64>,
    /// Each stage and its time.
    pub stages: Vec<StageSpan>,
    /// Every sample of the run.
    #[serde(skip)]
    pub record: Record,
    /// The model, where training was finished.
    pub identification: Option<Identification>,
    /// May this run be used? Also set where a run was stopped before it had a model.
    pub verdict: Verdict,
}

/// A stage of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StageSpan {
    /// Which stage.
    pub stage: Stage,
    /// When, half open.
    #[serde(flatten)]
    pub window: Window,
}

impl Campaign {
    /// A campaign of a vehicle by its name under this plan, before its first run: of the configuration `default`, on no
    /// simulator, with a rudder whose angle at full steering is not known.
    ///
    /// ```
    /// use seatrial::{Campaign, FullRudder};
    /// use seatrial_core::Plan;
    ///
    /// let about = Campaign {
    ///     configuration: "with side scan".into(),
    ///     full_rudder: Some(FullRudder { angle_rad: 0.6, is_assumed: false }),
    ///     ..Campaign::of("my boat", &Plan::paper())
    /// };
    /// assert!(!about.is_rehearsal());
    /// ```
    pub fn of(vehicle: &str, plan: &Plan<f64>) -> Self {
        Self {
            software_version: env!("CARGO_PKG_VERSION").into(),
            vehicle: vehicle.into(),
            axis: plan.axis,
            configuration: "default".into(),
            seed: None,
            rudder_limit_rad: plan.rudder_limit_rad,
            full_rudder: None,
            scenario: None,
            runs: Vec::new(),
            outcome: None,
        }
    }

    /// Was it a rehearsal on a simulator?
    ///
    /// ```
    /// use seatrial::Campaign;
    /// use seatrial_core::Plan;
    ///
    /// let at_sea = Campaign::of("my boat", &Plan::paper());
    /// assert!(Campaign { seed: Some(7), ..at_sea.clone() }.is_rehearsal() && !at_sea.is_rehearsal());
    /// ```
    pub fn is_rehearsal(&self) -> bool {
        self.seed.is_some()
    }

    /// The accepted run of each thrust, in order of thrust: the last one where several were accepted.
    pub fn accepted_runs(&self) -> Vec<&Run> {
        last_of_each_thrust(self.runs.iter().filter(|run| run.verdict.accepted))
    }

    /// May the models of the campaign be used, as a whole? Not where they contradict each other, where the vehicle at last did
    /// not do what any of them says, or where there is none; with care
    /// where a speed that was tried has none, or where a model is limited.
    ///
    /// ```
    /// use seatrial::Campaign;
    /// use seatrial_core::Plan;
    ///
    /// // Before its first run there is no model.
    /// let campaign = Campaign::of("my boat", &Plan::paper());
    /// assert!(!campaign.verdict().accepted && campaign.accepted_runs().is_empty());
    /// ```
    pub fn verdict(&self) -> Verdict {
        let accepted = self.accepted_runs();
        let contradictions = self.contradictions();
        let mut reasons = self.unfinished().into_iter().collect::<Vec<_>>();
        reasons.extend(self.faults_of_repeated_runs());
        reasons.extend(self.speeds_without_a_model());
        if contradictions.is_empty() && self.axis == Axis::Yaw {
            reasons.extend(load_change(&self.speed_results()));
        }
        let is_contradicted = !contradictions.is_empty()
            || self.compass_failed_again()
            || matches!(self.outcome, Some(Outcome::Aborted(reason)) if reason.contradicts_the_models());
        if accepted.is_empty() || is_contradicted {
            return Verdict { accepted: false, reasons: [contradictions, reasons].concat() };
        }
        let mut verdicts: Vec<Verdict> = accepted.iter().map(|run| run.verdict.clone()).collect();
        if accepted.iter().any(|run| run.rules_a_lag_out()) {
            verdicts.iter_mut().for_each(Verdict::lag_is_known);
        }
        let names: Vec<String> = accepted.iter().map(|run| percent_of(run.thrust)).collect();
        let parts: Vec<Part> =
            verdicts.iter().zip(&names).map(|(verdict, name)| Part { name, verdict }).collect();
        whole(&parts, UNIT, reasons)
    }

    /// Why runs are not judged in the campaign as by themselves: `whole`, the verdict of the campaign, refuses them, or knows the lag of the
    /// rudder. `None` where each is judged as by itself.
    pub fn changed_by_the_whole(&self, whole: &Verdict) -> Option<String> {
        let accepted = self.accepted_runs();
        if whole.accepted {
            let cleared = accepted.iter().filter(|run| run.is_cleared_of_a_lag(whole));
            let cleared: Vec<String> = cleared.map(|run| run.number.to_string()).collect();
            return (!cleared.is_empty()).then(|| {
                format!(
                    "Run {} by itself does not show whether the rudder lags; another speed shows that it does not.",
                    cleared.join(", ")
                )
            });
        }
        if accepted.is_empty() {
            return None;
        }
        let each: Vec<String> = accepted
            .iter()
            .map(|run| format!("run {} {}", run.number, run.verdict.outcome().name()))
            .collect();
        Some(format!(
            "By itself {}. Together they are not to be used, for the cause below.",
            each.join(", ")
        ))
    }

    /// Was a run refused for its compass, and did the compass then end the trial? What it said in between is not known to be right.
    fn compass_failed_again(&self) -> bool {
        let is_spoilt = |run: &Run| {
            let cause = run.verdict.cause();
            !run.verdict.accepted && cause.is_some_and(|c| c.code == ReasonCode::CompassError)
        };
        let Some(Outcome::Aborted(reason)) = self.outcome else {
            return false;
        };
        self.runs.iter().any(is_spoilt)
            && self
                .runs
                .last()
                .is_some_and(|run| abort_cause::is_compass(reason, &self.evidence(run)))
    }

    /// Why the campaign is not complete, if it is not.
    fn unfinished(&self) -> Option<Reason> {
        match self.outcome {
            Some(Outcome::Finished) => None,
            Some(Outcome::Aborted(reason)) => {
                let evidence = self.runs.last().map(|run| self.evidence(run));
                Some(abort_cause::reason(reason, evidence.as_ref()))
            }
            None => Some(Reason::new(ReasonCode::Interrupted, "the trial was not finished")),
        }
    }

    /// What may tell why the trial was aborted in this run.
    fn evidence<'a>(&self, run: &'a Run) -> Evidence<'a> {
        // A model too uncertain to be used still tells to which side the rudder turns.
        let sided = |other: &Run| {
            let refined = other.identification.as_ref()?.refined.as_ref()?;
            let [low, high] = refined.interval_95.b2_per_s2;
            (low * high > 0.0).then_some((other.thrust, refined.model))
        };
        let away = |other: &(f64, YawModel<f64>)| (other.0 - run.thrust).abs();
        let earlier = self.runs.iter().filter(|other| other.number < run.number);
        Evidence {
            samples: &run.record.samples,
            training_from_s: run.stage(Stage::Train).map(|window| window.from_s),
            has_models: self.runs.iter().any(|run| run.verdict.accepted),
            earlier: earlier.filter_map(sided).min_by(|a, b| away(a).total_cmp(&away(b))),
        }
    }

    /// A reason for each run that was refused for what the vehicle did and that was made again: what it was may come back.
    fn faults_of_repeated_runs(&self) -> Vec<Reason> {
        let deciding = self.deciding_runs();
        let is_repeated = |run: &&Run| deciding.iter().all(|other| other.number != run.number);
        let repeated = self.runs.iter().filter(is_repeated);
        repeated
            .filter(|run| !run.verdict.accepted)
            .filter_map(|run| {
                let cause = run.verdict.cause().filter(|cause| cause.is_of_the_vehicle())?;
                let measured = format!("run {} at {:.0} % thrust", run.number, 100.0 * run.thrust);
                Some(Reason {
                    text: format!(
                        "Run {} at {:.0} % thrust was refused and repeated: {}",
                        run.number,
                        100.0 * run.thrust,
                        cause.text
                    ),
                    ..Reason::new(ReasonCode::RunRepeated, measured)
                })
            })
            .collect()
    }

    /// A reason for each thrust that was tried and gave no model: that of its last run. That the trial was aborted in it is said by itself.
    fn speeds_without_a_model(&self) -> Vec<Reason> {
        let deciding = self.deciding_runs();
        let names: Vec<String> = deciding.iter().map(|run| percent_of(run.thrust)).collect();
        let ended = deciding.iter().zip(&names);
        let ended = ended.filter(|(run, _)| !run.verdict.has(&ReasonCode::Aborted));
        let parts: Vec<Part> =
            ended.map(|(run, name)| Part { name, verdict: &run.verdict }).collect();
        missing(&parts, UNIT)
    }

    /// The run that decides about each thrust, in order of thrust: the last accepted one, else the last one.
    pub fn deciding_runs(&self) -> Vec<&Run> {
        last_of_each_thrust(self.runs.iter().chain(self.accepted_runs()))
    }

    /// What speaks against one and the same vehicle having run the accepted runs of all speeds; empty where nothing does.
    /// Always empty for pitch, where it is not known how the parameters change over speed.
    pub fn contradictions(&self) -> Vec<Reason> {
        if self.axis == Axis::Pitch {
            return Vec::new();
        }
        contradictions(&self.speed_results())
    }

    fn speed_results(&self) -> Vec<SpeedResult<'_>> {
        self.accepted_runs()
            .into_iter()
            .filter_map(|run| {
                Some(SpeedResult {
                    thrust: Some(run.thrust),
                    surge_speed_m_s: run.surge_speed_m_s,
                    refined: run.identification.as_ref()?.refined.as_ref()?,
                })
            })
            .collect()
    }
}

/// Of runs the last one at each thrust, by thrust.
fn last_of_each_thrust<'a>(runs: impl Iterator<Item = &'a Run>) -> Vec<&'a Run> {
    let mut last: Vec<&Run> = Vec::new();
    for run in runs {
        last.retain(|other| other.thrust != run.thrust);
        last.push(run);
    }
    last.sort_by(|a, b| a.thrust.total_cmp(&b.thrust));
    last
}

fn percent_of(thrust: f64) -> String {
    format!("{:.0}", 100.0 * thrust)
}

impl Campaign {
    /// The campaign with the rudder that acted in its records: where a servo was given, the one behind it.
    pub fn with_acting_rudder(&self) -> Cow<'_, Self> {
        if self.runs.iter().all(|run| run.servo().is_none()) {
            return Cow::Borrowed(self);
        }
        let mut campaign = self.clone();
        campaign.runs.iter_mut().for_each(|run| run.record = run.acting_record().into_owned());
        Cow::Owned(campaign)
    }
}

impl Run {
    /// May its model be used? Not where `whole`, the verdict of its campaign, refuses it: speeds that contradict each other do. What another
    /// speed tells of the rudder's lag is known.
    pub fn verdict_within<'a>(&'a self, whole: &'a Verdict) -> Cow<'a, Verdict> {
        if self.verdict.accepted && !whole.accepted {
            return Cow::Borrowed(whole);
        }
        let mut verdict = Cow::Borrowed(&self.verdict);
        if self.is_cleared_of_a_lag(whole) {
            verdict.to_mut().lag_is_known();
        }
        verdict
    }

    /// The reasons of [`verdict_within`](Self::verdict_within): where the campaign refuses what the run by itself does not, the cause of
    /// the campaign before what limits the run.
    pub fn reasons_within(&self, whole: &Verdict) -> Vec<Reason> {
        if !self.verdict.accepted || whole.accepted {
            return self.verdict_within(whole).into_owned().reasons;
        }
        whole.cause().into_iter().chain(self.verdict.causes()).cloned().collect()
    }

    /// Does the record rule out that the rudder lags, which is that of every speed?
    fn rules_a_lag_out(&self) -> bool {
        self.identification.as_ref().is_some_and(|found| {
            *found.method() == EstimateMethod::AveragedRestrictedLikelihood
                && found.higher_order.is_none()
                && found.lag_effect.is_none()
        })
    }

    /// Does the campaign know the lag of the rudder, which the run by itself does not tell?
    fn is_cleared_of_a_lag(&self, whole: &Verdict) -> bool {
        let lag = &ReasonCode::LagUnknown;
        whole.accepted && self.verdict.accepted && self.verdict.has(lag) && !whole.has(lag)
    }

    fn servo(&self) -> Option<Servo> {
        self.identification.as_ref()?.settings.servo
    }

    /// The record with the rudder that acted: where a servo was given, the one behind it.
    pub fn acting_record(&self) -> Cow<'_, Record> {
        match self.servo() {
            Some(servo) => Cow::Owned(servo.behind(&self.record)),
            None => Cow::Borrowed(&self.record),
        }
    }

    /// The window of a stage.
    pub fn stage(&self, stage: Stage) -> Option<Window> {
        self.stages.iter().find(|span| span.stage == stage).map(|span| span.window)
    }
}
