//! The verdict in plain words, and what to do next.

use seatrial_core::{AbortReason, Outcome};

use super::log_model::{LogModel, promises};
use super::number::{decimals, percent, sentence, significant};
use super::speed_figures::Speed;
use seatrial::campaign::Campaign;
use seatrial::identification::{Outcome as ModelOutcome, ReasonCode, Verdict};

/// How good the news is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Tone {
    Good,
    #[default]
    Partly,
    Bad,
}

impl From<ModelOutcome> for Tone {
    fn from(outcome: ModelOutcome) -> Self {
        match outcome {
            ModelOutcome::Use => Self::Good,
            ModelOutcome::UseWithCare | ModelOutcome::NotValidated => Self::Partly,
            ModelOutcome::DoNotUse => Self::Bad,
        }
    }
}

impl Tone {
    /// CSS class.
    pub fn class(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Partly => "partly",
            Self::Bad => "bad",
        }
    }

    /// A sign beside the colour, for those who do not see it.
    pub fn sign(self) -> &'static str {
        match self {
            Self::Good => "✓",
            Self::Partly => "!",
            Self::Bad => "✕",
        }
    }
}

/// The first thing that a reader sees.
#[derive(Default)]
pub(super) struct Headline {
    pub tone: Tone,
    pub verdict: String,
    /// What was found, one sentence each.
    pub findings: Vec<String>,
    /// What to do now, one sentence each.
    pub next: Vec<String>,
    /// What to type next; empty where there is nothing.
    pub command: String,
}

/// The outcome as the first word of a sentence: `Use with care.`
pub(super) fn outcome_text(outcome: ModelOutcome) -> String {
    sentence(outcome.name())
}

/// The cause of an outcome, and how many more there are.
fn cause(verdict: &Verdict) -> Vec<String> {
    let mut cause: Vec<String> = verdict.cause().map(|r| sentence(&r.text)).into_iter().collect();
    cause.extend(verdict.more_remarks().map(|remarks| {
        let verb = if verdict.other_causes() == 1 { "is" } else { "are" };
        format!("{remarks} {verb} given with the figures.")
    }));
    cause
}

/// What to do about the cause of an outcome.
fn action(verdict: &Verdict) -> Option<String> {
    let action = &verdict.cause()?.action;
    (!action.is_empty()).then(|| action.clone())
}

/// Thrusts in order, each once.
fn thrusts(campaign: &Campaign) -> Vec<f64> {
    let mut thrusts: Vec<f64> = campaign.runs.iter().map(|run| run.thrust).collect();
    thrusts.sort_by(f64::total_cmp);
    thrusts.dedup();
    thrusts
}

/// The verdict of a campaign.
pub(super) fn of_campaign(campaign: &Campaign, speeds: &[Speed], command: &str) -> Headline {
    let tried = thrusts(campaign);
    let judged = campaign.verdict();
    let count = match judged.accepted || speeds.is_empty() {
        true => usable_models(speeds.len(), tried.len()),
        false => "The models of the speeds are not to be used".to_owned(),
    };
    let word = outcome_text(judged.outcome());
    let verdict = match campaign.outcome {
        Some(Outcome::Finished) => format!("{word} {count}."),
        Some(Outcome::Aborted(reason)) => {
            format!("{word} The trial was stopped: {}. {count}.", abort_cause(reason))
        }
        None => format!("{word} The trial was not finished. {count} so far."),
    };
    // That every speed has a model is said already.
    let mut findings = match judged.outcome() {
        ModelOutcome::Use => Vec::new(),
        // What is no run's own stands with no figure.
        _ => judged.causes().map(|reason| sentence(&reason.text)).collect(),
    };
    if campaign.axis.is_yaw()
        && judged.accepted
        && let (Some(slow), Some(fast)) = (speeds.first(), speeds.last())
    {
        findings.extend(promises_of(campaign, speeds));
        findings.extend(how_it_steers(slow, fast));
    }
    let mut next: Vec<String> = action(&judged).into_iter().collect();
    next.extend(next_of_trial(campaign, speeds, &tried, &judged));
    // The cause may be that the trial was stopped.
    next.dedup();
    Headline {
        tone: judged.outcome().into(),
        verdict,
        findings,
        next,
        command: match campaign.outcome {
            Some(Outcome::Aborted(_)) => String::new(),
            // The next step of a rehearsal is the trial on a vehicle.
            _ if campaign.seed.is_some() => String::new(),
            _ => command_of(judged.outcome(), command),
        },
    }
}

/// What goes on from a model that is not to be used is this page.
fn command_of(outcome: ModelOutcome, command: &str) -> String {
    match outcome {
        ModelOutcome::DoNotUse => String::new(),
        _ => command.to_owned(),
    }
}

/// What the gains of a trial promise.
fn promises_of(campaign: &Campaign, speeds: &[Speed]) -> Vec<String> {
    let models =
        (speeds.iter()).map(|speed| LogModel::of_run(campaign, speed.run, &speed.run.verdict));
    promises(&models.collect::<Vec<_>>())
}

/// How many of the speeds that were tried have a usable model.
fn usable_models(usable: usize, tried: usize) -> String {
    match (usable, tried) {
        (_, 0) => "No run was recorded".to_owned(),
        (0, _) => "No usable model".to_owned(),
        (1, 1) => "A usable model at the one speed tried".to_owned(),
        (good, all) if good == all => format!("Usable models at all {all} speeds"),
        (good, all) => format!("Usable models at {good} of {all} speeds"),
    }
}

/// What to do after the trial, and with its models where they may be used.
fn next_of_trial(
    campaign: &Campaign,
    speeds: &[Speed],
    tried: &[f64],
    judged: &Verdict,
) -> Vec<String> {
    let mut next = Vec::new();
    match campaign.outcome {
        Some(Outcome::Aborted(_)) => {
            let mut reasons = judged.reasons.iter();
            let abort = reasons.find(|reason| reason.code == ReasonCode::Aborted);
            next.extend(abort.map(|reason| reason.action.clone()));
        }
        None => next.push(
            "If the trial is no longer running, it was interrupted: every finished run is here; run the missing speeds again."
                .to_owned(),
        ),
        Some(Outcome::Finished) => next.extend(failed_speeds(campaign, speeds, tried)),
    }
    if !speeds.is_empty() && campaign.axis.is_yaw() && judged.accepted {
        next.push(what_to_do_with_models(campaign).to_owned());
    } else if campaign.runs.is_empty() {
        next.push(
            "Check that the vehicle sends samples and reaches a steady heading, then start the trial again."
                .to_owned(),
        );
    }
    next
}

/// Where the gains of a trial go: it depends on what it was made on.
fn what_to_do_with_models(campaign: &Campaign) -> &'static str {
    if campaign.seed.is_some() {
        "This was a rehearsal: the numbers are those of the simulated vehicle. Make the trial on your own vehicle, with seatrial trial --vehicle and its address."
    } else if campaign.vehicle.starts_with("mavlink:") {
        "Put the gains into the autopilot with the command below: it shows old and new gains, writes, tries heading steps, and puts the old \
         ones back where they do better. Or write the file of parameters with seatrial gains --export ardupilot."
    } else {
        "Write the gains for your controller with seatrial gains --export, then check one heading step at the lowest and one at the highest \
         speed against the figure of the heading step."
    }
}

/// What to do about the speeds that were tried and have no usable model. `None` where there are none.
fn failed_speeds(campaign: &Campaign, speeds: &[Speed], tried: &[f64]) -> Option<String> {
    let failed = tried
        .iter()
        .filter(|thrust| !speeds.iter().any(|speed| speed.run.thrust == **thrust))
        .filter_map(|thrust| campaign.runs.iter().rfind(|run| run.thrust == *thrust));
    let failed: Vec<String> = failed.map(|run| percent(run.thrust)).collect();
    (!failed.is_empty()).then(|| {
        format!(
            "Run {} again after removing the cause given above; until then do not use a gain at that thrust without a check at sea.",
            failed.join(", ")
        )
    })
}

/// One sentence on stability, one on authority.
fn how_it_steers(slow: &Speed, fast: &Speed) -> Vec<String> {
    let mut sentences = Vec::new();
    let stable = [slow, fast].iter().all(|speed| speed.point.model.a22_per_s < 0.0);
    let settle = |speed: &Speed| significant(4.0 / -speed.point.model.a22_per_s, 2);
    sentences.push(if stable {
        format!(
            "The vehicle is course stable: after a rudder change its turn settles within {} s.",
            from_slow_to_fast(settle(slow), settle(fast), " s")
        )
    } else {
        "At some speed the vehicle is course unstable: it does not stop turning by itself."
            .to_owned()
    });
    let straight = |speed: &Speed| {
        let offset = speed.point.model.delta0_rad()?;
        Some(decimals(-offset.to_degrees(), 1))
    };
    if let Some((slow, fast)) = straight(slow).zip(straight(fast)) {
        sentences.push(format!(
            "To go straight the rudder must stand at {}°.",
            from_slow_to_fast(slow, fast, "°")
        ));
    }
    sentences
}

/// One value, or the two with the speeds to which they belong.
fn from_slow_to_fast(slow: String, fast: String, unit: &str) -> String {
    if slow == fast {
        slow
    } else {
        format!("{slow}{unit} at the lowest thrust, at the highest {fast}")
    }
}

/// Why the trial stopped.
fn abort_cause(reason: AbortReason) -> &'static str {
    match reason {
        AbortReason::Operator => "the operator stopped it",
        AbortReason::Depth => "the depth left its limits",
        AbortReason::Altitude => "the bottom came too close",
        AbortReason::Roll => "the roll left its limits",
        AbortReason::Pitch => "the pitch left its limits",
        AbortReason::YawRate => "the vehicle turned faster than allowed",
        AbortReason::HeadingExcursion => "the heading went too far from that of the run",
        AbortReason::Area => "the vehicle reached the edge of its area",
        AbortReason::SpeedDrift => "the speed changed too much within a stage",
        AbortReason::StaleSamples => "no usable sample came for too long",
        AbortReason::StageTimeLimit => "a stage took longer than its limit",
        AbortReason::ReversedRudder => "the vehicle turned against the rudder",
        AbortReason::NotSettled => "the vehicle did not settle in the time allowed",
        AbortReason::LinkLost => "the link to the vehicle was lost",
        AbortReason::ModeChanged | AbortReason::StickMoved | AbortReason::Disarmed => {
            "the pilot took the vehicle over"
        }
        AbortReason::LowBattery => "the battery was low",
        AbortReason::Failsafe => "the autopilot reported a failsafe",
        AbortReason::Restarted => "the autopilot started again",
        AbortReason::SecondStation => "somebody else commanded the vehicle under our name",
        AbortReason::RudderNotFollowed => "the rudder did something else than asked for",
        AbortReason::NotAttended => "the program that conducts the trial was held up",
        AbortReason::NoAnswer => "the heading did not answer the rudder",
    }
}

/// The verdict on a log: the outcome, its cause, what to do about it and what to type next.
pub(super) fn of_log(verdict: &Verdict, models: &[LogModel], command: &str) -> Headline {
    Headline {
        tone: verdict.outcome().into(),
        verdict: outcome_text(verdict.outcome()),
        findings: [promises(models), cause(verdict)].concat(),
        next: action(verdict).into_iter().collect(),
        command: command_of(verdict.outcome(), command),
    }
}
