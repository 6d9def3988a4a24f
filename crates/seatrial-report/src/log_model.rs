//! A model of one speed as it is shown.

use seatrial::CourseChange;
use seatrial::campaign::{Campaign, Run};
use seatrial::gains::{DAMPING_RATIO, GainAllowance, SpeedGain, falls};
use seatrial::identification::{Identification, Outcome, Verdict};
use seatrial_core::{HeadingGain, NoGain};

/// A model of one speed of a log or of a trial.
#[derive(Clone, Copy, Debug)]
pub struct LogModel<'a> {
    /// A fraction of full.
    pub thrust: Option<f64>,
    /// Mean forward speed, m/s.
    pub surge_speed_m_s: Option<f64>,
    /// The model, where there is one.
    pub identification: Option<&'a Identification>,
    /// May it be used?
    pub outcome: Outcome,
    /// What a course change will do with the gain of an accepted model.
    pub course_change: Option<CourseChange>,
}

impl<'a> LogModel<'a> {
    /// Of a speed, at this thrust and forward speed, m/s. `rudder_limit` is the full rudder in the unit of the record, where it is known.
    pub fn new(
        [thrust, surge_speed_m_s]: [Option<f64>; 2],
        identification: Option<&'a Identification>,
        verdict: &Verdict,
        rudder_limit: Option<f64>,
    ) -> Self {
        let accepted = identification.filter(|_| verdict.accepted);
        Self {
            thrust,
            surge_speed_m_s,
            identification,
            outcome: verdict.outcome(),
            course_change: accepted.and_then(|found| CourseChange::of(found, rudder_limit)),
        }
    }

    /// Of a run of a trial, judged by `verdict`.
    pub fn of_run(campaign: &Campaign, run: &'a Run, verdict: &Verdict) -> Self {
        Self::new(
            [Some(run.thrust), run.surge_speed_m_s],
            run.identification.as_ref(),
            verdict,
            Some(campaign.rudder_limit_rad),
        )
    }

    /// Is its model accepted?
    pub fn is_accepted(&self) -> bool {
        matches!(self.outcome, Outcome::Use | Outcome::UseWithCare)
    }

    /// K_p of an accepted model of yaw, for a damping ratio of 0.71.
    pub fn gain(&self) -> Option<f64> {
        let gain = self.design()?.ok()?;
        Some(gain.proportional_gain)
    }

    /// The gain of an accepted model of yaw, or why it has none.
    fn design(&self) -> Option<Result<HeadingGain<f64>, NoGain>> {
        let is_steered = |found: &&Identification| self.is_accepted() && found.restoring.is_none();
        let identification = self.identification.filter(is_steered)?;
        let allowance = GainAllowance::of(identification);
        Some(allowance.design(&identification.model(), DAMPING_RATIO))
    }

    /// `80 % thrust` or `1.63 m/s`.
    fn name(&self) -> String {
        match (self.thrust, self.surge_speed_m_s) {
            (Some(thrust), _) => format!("{:.0} % thrust", 100.0 * thrust),
            (None, Some(speed)) => format!("{speed:.2} m/s"),
            (None, None) => "the one speed".into(),
        }
    }
}

/// What the gains of all speeds promise, which of them has fallen below the others, and where there is none: one sentence each, for every
/// edge.
pub fn promises(models: &[LogModel]) -> Vec<String> {
    let changes = models.iter().filter_map(|model| model.course_change);
    let promised = CourseChange::of_all(changes).map(|change| change.sentence());
    let named: Vec<(String, f64, &Identification)> = models
        .iter()
        .filter_map(|model| Some((model.name(), model.gain()?, model.identification?)))
        .collect();
    let gains: Vec<SpeedGain> = named
        .iter()
        .map(|(name, gain, identification)| SpeedGain { name, gain: *gain, identification })
        .collect();
    let fallen = falls(&gains, DAMPING_RATIO);
    let none = no_gain(models);
    promised.into_iter().chain(fallen).chain(none).collect()
}

/// At which speeds an accepted model has no gain, because the vehicle may be course unstable.
fn no_gain(models: &[LogModel]) -> Option<String> {
    let unstable =
        models.iter().filter(|model| matches!(model.design(), Some(Err(NoGain::CourseUnstable))));
    let names: Vec<String> = unstable.map(LogModel::name).collect();
    (!names.is_empty()).then(|| {
        format!(
            "No K_p at {}: the vehicle may be course unstable. Its controller must feed back the turn rate as well.",
            names.join(", ")
        )
    })
}
