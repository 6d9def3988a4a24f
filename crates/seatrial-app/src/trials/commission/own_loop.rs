//! A vehicle whose heading loop is ours: the constant gain of the slowest speed against the scheduled one.
//!
//! ```text
//! delta = K_p (psi_d - psi) - delta0
//! ```
//!
//! In the words of the cascade: A = 1, F = K_p by the rudder at full steering, and a rudder that is counted from -delta0, where
//! C0 is 0. So the same steps, the same check of the model and the same judgement hold as for an autopilot.

use std::sync::atomic::AtomicBool;

use seatrial::gains::commission::{Evidence, NoProposal, StepTest, foresee};
use seatrial::gains::{DAMPING_RATIO, least_damped_schedule};
use seatrial_core::schedule::{Beyond, ScheduleKey};
use seatrial_core::{
    AbortReason, Action, CascadeSettings, Envelope, GainSchedule, HeadingGain, Outcome, Real,
    Sample, SchedulePoint, Steering, YawModel,
};
use serde::Serialize;

use super::conduct::{Order, Progress, conduct};
use super::proposal::{evidence, held_steps};
use super::{CommissionResult, Control, ControlLoss, GainsLease, Proposal};
use crate::Error;
use crate::models::{ModelPoint, Models};
use crate::trials::order::VehicleLease;

/// How a vehicle is steered by us.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OwnLoop {
    /// Size of the steps, rad.
    pub step_rad: f64,
    /// The largest rudder, rad.
    pub rudder_limit_rad: f64,
    /// Between two samples, s.
    pub sample_interval_s: f64,
}

/// The gains of one speed.
#[derive(Clone, Debug)]
pub struct OwnProposal {
    /// Thrust as a fraction of full.
    pub thrust: f64,
    /// The gain of the slowest speed, without feed-forward.
    pub constant: HeadingGain<f64>,
    /// The gain of this speed.
    pub scheduled: HeadingGain<f64>,
    proposal: Proposal,
}

/// What became of the gains of one speed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OwnSpeed {
    /// Thrust as a fraction of full.
    pub thrust: f64,
    /// Speed of the model, m/s.
    pub surge_speed_m_s: Option<f64>,
    /// The gain of the slowest speed, without feed-forward.
    pub constant: HeadingGain<f64>,
    /// The gain of this speed.
    pub scheduled: HeadingGain<f64>,
    /// The steps: `old` is the constant gain, `new` the scheduled one.
    #[serde(flatten)]
    pub found: CommissionResult,
}

/// The gains of every speed, slowest first.
pub fn propose_own(models: &Models, own: &OwnLoop) -> Result<Vec<OwnProposal>, Error> {
    let refused =
        |why: &dyn std::fmt::Display| Error::Rejected(format!("{}: {why}", models.origin));
    let points = models.points.iter().map(|p| (p.point, p.allowance));
    let (cautious, timing) =
        least_damped_schedule(ScheduleKey::Thrust, points).map_err(|error| refused(&error))?;
    let gains = GainSchedule::design(cautious, DAMPING_RATIO, timing);
    let gains = gains.map_err(|error| refused(&error))?;
    let mut points: Vec<(f64, &ModelPoint)> =
        models.points.iter().filter_map(|point| Some((point.point.thrust?, point))).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut constant = None;
    let mut proposals = Vec::new();
    for (thrust, point) in points {
        let scheduled = gains.lookup(thrust, Beyond::Refuse);
        let scheduled = *scheduled.map_err(|error| refused(&error))?.value();
        let constant = *constant.get_or_insert(scheduled.without_feed_forward());
        let proposal = proposal(point, &constant, &scheduled, own);
        proposals.push(OwnProposal {
            thrust,
            constant,
            scheduled,
            proposal: proposal.map_err(|error| refused(&error))?,
        });
    }
    Ok(proposals)
}

/// A heading gain as the cascade has it.
fn settings(gain: &HeadingGain<f64>, own: &OwnLoop) -> CascadeSettings<f64> {
    CascadeSettings {
        angle_gain_per_s: 1.0,
        feed_forward_s: gain.proportional_gain / own.rudder_limit_rad,
        ..CascadeSettings::default()
    }
}

fn proposal(
    point: &ModelPoint,
    constant: &HeadingGain<f64>,
    scheduled: &HeadingGain<f64>,
    own: &OwnLoop,
) -> Result<Proposal, NoProposal> {
    let control = Control {
        settings: settings(constant, own),
        loop_interval_s: own.sample_interval_s,
        sample_interval_s: own.sample_interval_s,
        output_scale: 1.0,
        steering_taken: 0.0,
        keeps_speed: false,
        rate_noise_rad_s: None,
    };
    let off_centre = evidence(point, own.rudder_limit_rad, &control);
    let trimmed =
        Evidence { model: YawModel { c0_rad_per_s2: 0.0, ..off_centre.model }, ..off_centre };
    trimmed.check()?;
    let new = settings(scheduled, own);
    // The loop follows within 2/-a22: zeta omega_n is -a22/2.
    let smoothing_s = 0.2 / -trimmed.model.a22_per_s;
    let (test, new_foreseen) = held_steps(&trimmed, &new, own.step_rad, &control, smoothing_s);
    Ok(Proposal {
        old_foreseen: foresee(&off_centre, &control.settings, &test, smoothing_s),
        new_foreseen,
        evidence: trimmed,
        control,
        settings: new,
        model: point.point,
        test,
        smoothing_s,
    })
}

impl OwnProposal {
    /// The steps that are made.
    pub fn test(&self) -> &StepTest {
        &self.proposal.test
    }

    /// Steps with the constant gain, then with the scheduled one, at this speed.
    pub fn conduct(
        &self,
        vehicle: &mut dyn VehicleLease,
        own: &OwnLoop,
        envelope: Envelope<f64>,
        stop: &AtomicBool,
        progress: Progress,
    ) -> OwnSpeed {
        let mut helm = Helm {
            vehicle,
            own: *own,
            thrust: self.thrust,
            gain: self.constant,
            scheduled: (self.proposal.settings, self.scheduled),
            constant: self.constant,
            delta0_rad: -self.scheduled.feed_forward_rudder_rad,
            last: Sample::default(),
        };
        let order = Order { proposal: &self.proposal, envelope, stop };
        OwnSpeed {
            thrust: self.thrust,
            surge_speed_m_s: self.proposal.model.surge_speed_m_s,
            constant: self.constant,
            scheduled: self.scheduled,
            found: conduct(&mut helm, &order, progress),
        }
    }
}

/// The heading controller at work on a vehicle.
struct Helm<'a> {
    vehicle: &'a mut dyn VehicleLease,
    own: OwnLoop,
    thrust: f64,
    gain: HeadingGain<f64>,
    constant: HeadingGain<f64>,
    scheduled: (CascadeSettings<f64>, HeadingGain<f64>),
    delta0_rad: f64,
    last: Sample<f64>,
}

impl Helm<'_> {
    fn lost(&self, why: String) -> ControlLoss {
        ControlLoss { reason: self.vehicle.ended_for().or(Some(AbortReason::LinkLost)), why }
    }

    fn act(&mut self, steering: Steering<f64>, outcome: Option<Outcome>) {
        // A vehicle that is gone says so with its next sample.
        let _ = self.vehicle.act(&Action { steering, thrust: Some(self.thrust), outcome });
    }
}

impl GainsLease for Helm<'_> {
    fn next_sample(&mut self) -> Result<Sample<f64>, ControlLoss> {
        if self.vehicle.is_taken_over() {
            return Err(ControlLoss {
                reason: Some(AbortReason::Operator),
                why: "the operator has taken the vehicle".into(),
            });
        }
        match self.vehicle.next_sample() {
            Ok(Some(sample)) => {
                self.last = sample;
                let from_trim_rad = sample.rudder_rad + self.delta0_rad;
                Ok(Sample { rudder_rad: from_trim_rad / self.own.rudder_limit_rad, ..sample })
            }
            Ok(None) => Err(self.lost("the vehicle sends no more samples".into())),
            Err(fault) => Err(self.lost(fault.to_string())),
        }
    }

    fn steer_to(&mut self, heading_rad: f64, _: &SchedulePoint<f64>) {
        let error_rad = (heading_rad - self.last.heading_rad).wrapped();
        let HeadingGain { proportional_gain, feed_forward_rudder_rad } = self.gain;
        let rudder_rad = proportional_gain * error_rad + feed_forward_rudder_rad;
        if rudder_rad.is_finite() {
            self.act(Steering::Rudder(rudder_rad.limited_to(self.own.rudder_limit_rad)), None);
        }
    }

    fn write(&mut self, settings: &CascadeSettings<f64>) -> Result<(), ControlLoss> {
        let (new, scheduled) = self.scheduled;
        self.gain = match *settings == new {
            true => scheduled,
            false => self.constant,
        };
        Ok(())
    }

    fn keep(&mut self) -> Result<String, ControlLoss> {
        Ok("steer with the constant gain again".into())
    }

    /// Holds its heading until the next speed, or until it is handed back.
    fn hand_back(&mut self) -> Option<String> {
        self.act(Steering::HoldHeading(self.last.heading_rad), None);
        None
    }
}
