//! Results of the other crates as the documents of the programming interface.

use std::borrow::Cow;
use std::time::SystemTime;

use jiff::{Timestamp, Unit};
use seatrial::campaign::{Campaign, Run};
use seatrial::identification::{self, Identification, Reader};
use seatrial::preview::{PredictedQuantity, Preview};
use seatrial_app::trials::order;
use seatrial_app::{TrialPlan, advice};
use seatrial_core as core;

use seatrial_logbook::{CampaignEntry, State as LogbookState};
use seatrial_report::{LogModel, overlay, promises};

use crate::api::{
    CampaignSummary, Check, ExpectedIntervals, Figure, Model, Outcome, PlanPreview, Preflight,
    Reason, Review, RunSummary, SpeedPreview, Stage, StageSpan, State, ValidationOverlay, Verdict,
    VerdictOutcome,
};

/// The server's clock, UTC, RFC 3339.
pub fn now() -> String {
    utc(SystemTime::now())
}

/// A time, UTC, RFC 3339.
pub fn utc(time: SystemTime) -> String {
    let time = Timestamp::try_from(time).unwrap_or_default();
    time.round(Unit::Millisecond).unwrap_or(time).to_string()
}

/// The snake_case name that serde gives a value without fields.
pub fn name_of(value: impl serde::Serialize) -> String {
    let quoted = serde_json::to_string(&value).unwrap_or_default();
    quoted.trim_matches('"').to_owned()
}

impl From<core::Stage> for Stage {
    fn from(stage: core::Stage) -> Self {
        match stage {
            core::Stage::Settle => Self::Settle,
            core::Stage::Train => Self::Train,
            core::Stage::Validate => Self::Validate,
        }
    }
}

impl From<core::Outcome> for Outcome {
    fn from(outcome: core::Outcome) -> Self {
        match outcome {
            core::Outcome::Finished => {
                Self { finished: true, reason: None, text: "every speed was run".into() }
            }
            core::Outcome::Aborted(reason) => {
                Self { finished: false, reason: Some(name_of(reason)), text: reason.to_string() }
            }
        }
    }
}

impl From<seatrial::identification::Reason> for Reason {
    fn from(reason: seatrial::identification::Reason) -> Self {
        let reason = advice::reason(&reason, Reader::Dashboard);
        Self {
            code: reason.code.to_string(),
            of: reason.of.map(|subject| subject.to_string()),
            action: reason.action,
            text: reason.text,
        }
    }
}

impl From<identification::Outcome> for VerdictOutcome {
    fn from(outcome: identification::Outcome) -> Self {
        match outcome {
            identification::Outcome::Use => Self::Use,
            identification::Outcome::UseWithCare => Self::UseWithCare,
            identification::Outcome::NotValidated => Self::NotValidated,
            identification::Outcome::DoNotUse => Self::DoNotUse,
        }
    }
}

impl From<&identification::Verdict> for Verdict {
    fn from(verdict: &identification::Verdict) -> Self {
        Self {
            outcome: verdict.outcome().into(),
            cause: verdict.cause().cloned().map(Reason::from),
            other_causes: verdict.other_causes(),
            promises: Vec::new(),
        }
    }
}

/// The verdict on a whole campaign, `whole`, with what the gains of its accepted models promise where they may be used.
pub fn verdict_with_promises(campaign: &Campaign, whole: &identification::Verdict) -> Verdict {
    let runs = match whole.outcome() {
        identification::Outcome::DoNotUse => Vec::new(),
        _ => campaign.accepted_runs(),
    };
    let models = (runs.iter()).map(|run| LogModel::of_run(campaign, run, &run.verdict));
    Verdict { promises: promises(&models.collect::<Vec<_>>()), ..whole.into() }
}

impl From<seatrial_logbook::Review> for Review {
    fn from(review: seatrial_logbook::Review) -> Self {
        Self {
            accepted: review.accepted,
            note: review.note,
            by: review.reviewer,
            time: review.time,
        }
    }
}

impl From<&Identification> for Model {
    fn from(identification: &Identification) -> Self {
        let model = identification.model();
        let refined = identification.refined.as_ref();
        let intervals = refined.map(|refined| refined.interval_95);
        let figure = |value, interval_95| Figure { value, interval_95 };
        let validation = identification.validation;
        Self {
            a22_per_s: figure(model.a22_per_s, intervals.map(|i| i.a22_per_s)),
            b2_per_s2: figure(model.b2_per_s2, intervals.map(|i| i.b2_per_s2)),
            c0_rad_per_s2: figure(model.c0_rad_per_s2, intervals.map(|i| i.c0_rad_per_s2)),
            delta0_rad: model
                .delta0_rad()
                .map(|value| figure(value, intervals.and_then(|i| i.delta0_rad))),
            nomoto_t_s: identification.nomoto.map(|nomoto| nomoto.t_s),
            nomoto_k_per_s: identification.nomoto.map(|nomoto| nomoto.k_per_s),
            r2_heading: validation.and_then(|v| v.r2_heading),
            r2_heading_offset_refit: validation.and_then(|v| v.r2_heading_offset_refit),
            r2_yaw_rate: validation.and_then(|v| v.r2_yaw_rate),
            converged_s: identification.online.convergence.detected_s,
            method: identification.method().to_string(),
        }
    }
}

impl From<order::Preflight> for Preflight {
    fn from(found: order::Preflight) -> Self {
        Self {
            ready: found.is_passed(),
            checks: found
                .checks
                .into_iter()
                .map(|check| Check {
                    text: advice::addressed(&check.text, Reader::Dashboard),
                    ..check
                })
                .collect(),
            changes: found.changes,
        }
    }
}

/// A run, judged within `whole`, the verdict of its campaign, once there is one, with the operator's decision on it where there is one.
pub fn run_summary(
    run: &Run,
    whole: Option<&identification::Verdict>,
    review: Option<Review>,
) -> RunSummary {
    let verdict = whole.map_or(Cow::Borrowed(&run.verdict), |w| run.verdict_within(w));
    let reasons = match whole.filter(|whole| whole.accepted) {
        Some(whole) => run.reasons_within(whole),
        None => run.verdict.reasons.clone(),
    };
    RunSummary {
        number: run.number,
        thrust: run.thrust,
        attempt: run.attempt,
        surge_speed_m_s: run.surge_speed_m_s,
        stages: run
            .stages
            .iter()
            .map(|span| StageSpan {
                stage: span.stage.into(),
                from_s: span.window.from_s,
                to_s: Some(span.window.to_s).filter(|to_s| to_s.is_finite()),
            })
            .collect(),
        accepted: run.verdict.accepted,
        verdict: verdict.as_ref().into(),
        reasons: reasons.into_iter().map(Reason::from).collect(),
        model: run.identification.as_ref().map(Model::from),
        review,
    }
}

/// The validation of a run, measured and simulated.
pub fn validation_of(run: &Run) -> Option<ValidationOverlay> {
    let model = run.identification.as_ref()?;
    let drawn = overlay(&run.acting_record(), run.stage(core::Stage::Validate)?, model);
    Some(ValidationOverlay {
        run: run.number,
        time_s: drawn.iter().map(|at| at.time_s).collect(),
        measured_heading_rad: drawn.iter().map(|at| at.measured_rad).collect(),
        simulated_heading_rad: drawn.iter().map(|at| at.simulated_rad).collect(),
    })
}

impl CampaignSummary {
    /// An entry of the logbook; `running` is the campaign that this server is at, `whole` the verdict on this one.
    pub(crate) fn of(
        entry: CampaignEntry,
        running: Option<i64>,
        whole: Option<&identification::Verdict>,
    ) -> Self {
        let (state, outcome) = match entry.state {
            LogbookState::Ended { outcome } => {
                let outcome = Outcome::from(outcome);
                let state = if outcome.finished { State::Finished } else { State::Aborted };
                (state, Some(outcome))
            }
            _ if running == Some(entry.id.0) => (State::Running, None),
            LogbookState::Unfinished | LogbookState::Interrupted => (State::Interrupted, None),
        };
        Self {
            id: entry.id.0,
            configuration: entry.configuration,
            notes: entry.notes,
            started: entry.started,
            software_version: entry.software_version,
            vehicle: entry.vehicle,
            seed: entry.seed,
            rudder_limit_rad: entry.rudder_limit_rad,
            state,
            outcome,
            verdict: (whole.filter(|_| running != Some(entry.id.0)))
                .map(|whole| whole.outcome().into()),
            runs: entry.runs,
            runs_accepted: entry.runs_accepted,
            plan_sha256: entry.plan_sha256,
            head_sha256: entry.head_sha256,
        }
    }
}

impl PlanPreview {
    /// A preview of a plan.
    pub(crate) fn of(plan: &TrialPlan, preview: &Preview) -> Self {
        let around = |value: f64, half_width: f64| Figure {
            value,
            interval_95: Some([value - half_width, value + half_width]),
        };
        let predicted = |p: PredictedQuantity| around(p.value, p.half_width_95);
        let speeds: Vec<SpeedPreview> = preview
            .speeds
            .iter()
            .map(|speed| SpeedPreview {
                thrust: speed.prior.thrust,
                surge_speed_m_s: speed.prior.surge_speed_m_s,
                stages_s: [speed.settle_s, speed.train_s, speed.validate_s],
                heading_excursion_rad: speed.heading_excursion_rad,
                expected: speed.expected.map(|expected| {
                    let theta = speed.prior.model.theta();
                    let [a22_per_s, b2_per_s2, c0_rad_per_s2] =
                        std::array::from_fn(|i| around(theta[i], expected.half_width_95[i]));
                    ExpectedIntervals {
                        a22_per_s,
                        b2_per_s2,
                        c0_rad_per_s2,
                        proportional_gain: expected.proportional_gain.map(predicted),
                        steady_turning_radius_m: expected
                            .steady_turning_radius_m
                            .map(|radius| radius.map(predicted)),
                        is_enough: expected.is_enough(),
                    }
                }),
            })
            .collect();
        Self {
            plan: *plan,
            outcome: preview.outcome.map(Outcome::from),
            duration_s: preview.duration_s,
            longest_s: preview.longest_s,
            track_box_m: preview.track_box_m,
            track_margin_m: preview.track_margin_m,
            is_enough: speeds.len() == plan.thrusts.len()
                && speeds.iter().all(|s| s.expected.as_ref().is_some_and(|e| e.is_enough)),
            speeds,
        }
    }
}
