//! Plans of trials that go on from a campaign of the logbook.

use seatrial::campaign::Run;
use seatrial::identification::ReasonCode;
use seatrial_core::{List, Plan};
use seatrial_logbook::CampaignEntry;

use crate::TrialPlan;

/// Why a campaign gives no plan for another trial.
#[derive(Debug, thiserror::Error)]
pub enum RepeatError {
    /// Its plan cannot be read.
    #[error("the campaign's plan: {0}")]
    Plan(#[from] toml::de::Error),
    /// The campaign has no run at this thrust.
    #[error("campaign {campaign} has no speed of thrust {thrust}")]
    NoSuchThrust {
        /// Number of the campaign.
        campaign: i64,
        /// Thrust as a fraction of full.
        thrust: f64,
    },
    /// Every speed of its plan is done.
    #[error("campaign {campaign} has been at every speed of its plan; repeat one of them")]
    NothingLeft {
        /// Number of the campaign.
        campaign: i64,
    },
}

/// The plan of a campaign.
pub fn plan_of_campaign(entry: &CampaignEntry) -> Result<TrialPlan, RepeatError> {
    Ok(TrialPlan::parse(&entry.plan)?)
}

/// The plan that runs one speed of a campaign again.
pub fn plan_that_repeats(entry: &CampaignEntry, thrust: f64) -> Result<TrialPlan, RepeatError> {
    let mut plan = plan_of_campaign(entry)?;
    if !plan.thrusts.contains(&thrust) {
        return Err(RepeatError::NoSuchThrust { campaign: entry.id.0, thrust });
    }
    plan.plan.thrusts = List::from_slice(&[thrust]).unwrap_or_default();
    Ok(plan)
}

/// The plan that goes on with a campaign that ended early, at the first speed that is not done.
pub fn plan_to_go_on(entry: &CampaignEntry, runs: &[Run]) -> Result<TrialPlan, RepeatError> {
    let mut plan = plan_of_campaign(entry)?;
    plan.plan.thrusts = List::from_slice(speeds_left(&plan, runs)).unwrap_or_default();
    if plan.plan.thrusts.is_empty() {
        return Err(RepeatError::NothingLeft { campaign: entry.id.0 });
    }
    Ok(plan)
}

/// The speeds of a plan from the first that is not done. One is done when its last run was accepted or used up the
/// attempts; a run that was not judged yet when the next one began is neither.
fn speeds_left<'a>(plan: &'a Plan<f64>, runs: &[Run]) -> &'a [f64] {
    let is_done = |tries: &[Run]| {
        tries.last().is_some_and(|last| {
            let mut reasons = last.verdict.reasons.iter();
            let broke_off =
                reasons.any(|r| matches!(r.code, ReasonCode::Aborted | ReasonCode::Interrupted));
            last.verdict.accepted || (!broke_off && last.attempt > plan.max_repeats)
        })
    };
    let speeds = runs.chunk_by(|_, next| next.attempt > 1);
    let done = speeds.take_while(|tries| is_done(tries)).count();
    plan.thrusts.get(done..).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use seatrial::Record;
    use seatrial::identification::{Reason, Verdict};

    fn run(attempt: u32, accepted: bool, code: ReasonCode) -> Run {
        Run {
            number: 1,
            thrust: 0.6,
            attempt,
            surge_speed_m_s: None,
            stages: Vec::new(),
            record: Record::default(),
            identification: None,
            verdict: Verdict { accepted, reasons: vec![Reason::new(code, "")] },
        }
    }

    #[test]
    fn exact_a_campaign_goes_on_at_the_first_speed_that_is_not_done() {
        let plan = Plan {
            thrusts: List::from_slice(&[0.6, 0.7, 0.8]).unwrap(),
            max_repeats: 1,
            ..Plan::paper()
        };
        let good = || run(1, true, ReasonCode::Ok);
        let left = |runs: &[Run]| speeds_left(&plan, runs).to_vec();
        assert_eq!(left(&[]), [0.6, 0.7, 0.8]);
        assert_eq!(left(&[good()]), [0.7, 0.8]);
        assert_eq!(left(&[good(), run(1, false, ReasonCode::Interrupted)]), [0.7, 0.8]);
        assert_eq!(left(&[good(), run(1, false, ReasonCode::LowR2)]), [0.7, 0.8]);
        let twice = [good(), run(1, false, ReasonCode::LowR2), run(2, false, ReasonCode::LowR2)];
        assert_eq!(left(&twice), [0.8]);
        let aborted =
            [good(), run(1, false, ReasonCode::LowR2), run(2, false, ReasonCode::Aborted)];
        assert_eq!(left(&aborted), [0.7, 0.8]);
        let unjudged =
            [run(1, false, ReasonCode::Interrupted), run(1, false, ReasonCode::Interrupted)];
        assert_eq!(left(&unjudged), [0.6, 0.7, 0.8]);
        assert!(left(&[good(), good(), good()]).is_empty());
    }
}
