//! The steps, the gains, the decision.

use std::sync::atomic::{AtomicBool, Ordering};

use seatrial::gains::commission::{
    Evidence, Foreseen, JudgedSteps, Judgement, MOST_REPEATS, ModelCheck, Response, Stage,
    StepInstant, StepTest, check_model, foresee, judge_repeats,
};
use seatrial_core::{AbortReason, Envelope};

use super::step_run::{Patience, StepRecord, StepRun};
use super::{
    CommissionResult, ControlLoss, Ending, GainsLease, Proposal, check_text, response_text,
};

/// The first step with new gains, rad.
const SMALL_STEP_RAD: f64 = 0.14;

/// What is to be done.
pub struct Order<'a> {
    /// The settings, and what they rest on.
    pub proposal: &'a Proposal,
    /// Limits within which the vehicle must stay.
    pub envelope: Envelope<f64>,
    /// Set when the operator wants the vehicle back.
    pub stop: &'a AtomicBool,
}

/// Called with a sentence about each step of a commission.
pub type Progress<'a> = &'a mut dyn FnMut(&str);

/// Tries the old settings, writes the new ones, tries them, keeps them or puts the old ones back; then hands the vehicle back,
/// whatever happened.
pub fn conduct(
    vehicle: &mut dyn GainsLease,
    order: &Order,
    progress: Progress,
) -> CommissionResult {
    let mut found = CommissionResult {
        ending: Ending::Refused,
        not_put_back: None,
        model_check: None,
        old: None,
        old_foreseen: Some(order.proposal.old_foreseen),
        small: None,
        new: None,
        new_foreseen: None,
    };
    let mut commission = Commission { vehicle, order, progress, base_rad: None };
    found.ending = commission
        .run(&mut found)
        .unwrap_or_else(|lost| Ending::Aborted { reason: lost.reason, why: lost.why });
    found.not_put_back = commission.vehicle.hand_back();
    found
}

struct Commission<'a> {
    vehicle: &'a mut dyn GainsLease,
    order: &'a Order<'a>,
    progress: Progress<'a>,
    /// The heading from which the steps go, rad.
    base_rad: Option<f64>,
}

impl Commission<'_> {
    fn run(&mut self, found: &mut CommissionResult) -> Result<Ending, ControlLoss> {
        let proposal = self.order.proposal;
        let old = self.steps(&proposal.test, proposal.old_patience(), "old gains")?;
        let (step_rad, smoothing_s) = (proposal.test.step_rad, proposal.smoothing_s);
        let response = Response::measure(&old.legs, step_rad, smoothing_s, 0.0);
        let response = response.ok_or_else(|| ended_for(AbortReason::StaleSamples))?;
        self.tell("old gains", &old, &response);
        found.old = Some(response);
        let check = check_model(&proposal.evidence.boat(), &old.legs);
        (self.progress)(&format!("model: {}", check_text(&check)));
        found.model_check = Some(check);
        if matches!(check, ModelCheck::Fails { .. }) {
            return Ok(Ending::Refused);
        }
        let evidence = with_noise_of(&proposal.evidence, &old.legs);
        let foreseen =
            |test: &StepTest| foresee(&evidence, &proposal.settings, test, proposal.smoothing_s);
        found.new_foreseen = Some(foreseen(&proposal.test));
        (self.progress)("writing the new gains");
        self.vehicle.write(&proposal.settings)?;
        let small_test =
            StepTest { step_rad: SMALL_STEP_RAD.min(proposal.test.step_rad), ..proposal.test };
        let mut repeats = MOST_REPEATS;
        for (stage, test) in [(Stage::Small, small_test), (Stage::Full, proposal.test)] {
            let judgement =
                self.judged(found, (stage, &test), &old, &foreseen(&test), &mut repeats)?;
            if !judgement.keep {
                (self.progress)("putting the old gains back");
                self.vehicle.write(&proposal.control.settings)?;
                return Ok(Ending::PutBack {
                    at_small_step: stage == Stage::Small,
                    against: judgement.against,
                });
            }
        }
        let undo = self.vehicle.keep()?;
        Ok(Ending::Kept { undo })
    }

    /// Steps with the new gains, repeated where a wave may have spoilt them, beside those with the old ones.
    fn judged(
        &mut self,
        found: &mut CommissionResult,
        (stage, test): (Stage, &StepTest),
        old: &StepRecord,
        foreseen: &Foreseen,
        repeats: &mut usize,
    ) -> Result<Judgement, ControlLoss> {
        let proposal = self.order.proposal;
        let name = match stage {
            Stage::Small => "new gains, small step",
            Stage::Full => "new gains",
        };
        let mut patience = proposal.new_patience();
        let of_old = (&old.legs, proposal.test.step_rad);
        let mut repeated = Vec::new();
        loop {
            let mut record = self.steps(test, patience, name)?;
            repeated.push(std::mem::take(&mut record.legs));
            let stage_and_size = (stage, test.step_rad);
            let judged =
                judge_repeats(stage_and_size, &repeated, of_old, foreseen, proposal.smoothing_s);
            let JudgedSteps { new, old, judgement } =
                judged.ok_or_else(|| ended_for(AbortReason::StaleSamples))?;
            self.tell(name, &record, &new);
            found.old = Some(old);
            match stage {
                Stage::Small => found.small = Some(new),
                Stage::Full => found.new = Some(new),
            }
            if *repeats == 0 || !judgement.is_worth_repeating() {
                return Ok(judgement);
            }
            *repeats -= 1;
            patience = proposal.old_patience();
            let against: Vec<String> = judgement.against.iter().map(ToString::to_string).collect();
            (self.progress)(&format!("{name}: {}: once more", against.join("; ")));
        }
    }

    fn steps(
        &mut self,
        test: &StepTest,
        patience: Patience,
        name: &str,
    ) -> Result<StepRecord, ControlLoss> {
        let proposal = self.order.proposal;
        (self.progress)(&format!(
            "{name}: steps of {:.0} degrees, {:.0} s each",
            test.step_rad.to_degrees(),
            test.hold_s
        ));
        let mut run: Option<StepRun> = None;
        loop {
            if self.order.stop.load(Ordering::Relaxed) {
                return Err(ended_for(AbortReason::Operator));
            }
            let sample = self.vehicle.next_sample()?;
            if run.is_none() && !sample.heading_rad.is_finite() {
                continue;
            }
            let base_rad = *self.base_rad.get_or_insert(sample.heading_rad);
            let run = run.get_or_insert_with(|| {
                StepRun::new(
                    *test,
                    patience,
                    base_rad,
                    proposal.model.surge_speed_m_s,
                    proposal.control.output_scale,
                    self.order.envelope,
                )
            });
            let wanted = run.step(&sample);
            match wanted.ended {
                None => self.vehicle.steer_to(wanted.heading_rad, &proposal.model),
                Some(Ok(record)) => return self.at_speed(record),
                Some(Err(reason)) => return Err(ended_for(reason)),
            }
        }
    }

    /// Refuses steps at another speed than the model's.
    fn at_speed(&self, record: StepRecord) -> Result<StepRecord, ControlLoss> {
        let proposal = self.order.proposal;
        let wanted = proposal.model.surge_speed_m_s;
        let Some((wanted, kept)) = wanted.zip(record.surge_speed_m_s) else {
            return Ok(record);
        };
        if (kept / wanted - 1.0).abs() <= self.order.envelope.speed_drift_max {
            return Ok(record);
        }
        let advice = match proposal.control.keeps_speed {
            true => {
                "tune its speed (CRUISE_SPEED, CRUISE_THROTTLE, ATC_SPEED_P), or take the model of another speed"
            }
            false => {
                "the same thrust goes at another speed now; run a trial on the vehicle as it is"
            }
        };
        Err(ControlLoss {
            reason: Some(AbortReason::SpeedDrift),
            why: format!(
                "the vehicle went at {kept:.2} m/s where the model is of {wanted:.2} m/s: {advice}"
            ),
        })
    }

    fn tell(&mut self, name: &str, record: &StepRecord, response: &Response) {
        let speed = record.surge_speed_m_s;
        let at = speed.map_or(String::new(), |speed| format!("at {speed:.2} m/s "));
        (self.progress)(&format!("{name}: {at}{}", response_text(response)));
    }
}

fn ended_for(reason: AbortReason) -> ControlLoss {
    ControlLoss { reason: Some(reason), why: reason.to_string() }
}

/// The noise of the yaw rate as the record has it: white noise is in second differences with variance 6.
fn with_noise_of(evidence: &Evidence, legs: &[Vec<StepInstant>]) -> Evidence {
    let (mut sum, mut count) = (0.0, 0.0);
    for leg in legs {
        for three in leg[leg.len() / 2..].windows(3) {
            let [a, b, c] = [0, 1, 2].map(|k| three[k].yaw_rate_rad_s);
            sum += (a - 2.0 * b + c).powi(2);
            count += 1.0;
        }
    }
    Evidence { rate_noise_rad_s: (sum / (6.0 * f64::max(count, 1.0))).sqrt(), ..*evidence }
}
