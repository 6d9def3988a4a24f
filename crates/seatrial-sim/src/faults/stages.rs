//! Where a trial is, from what it asks of the vehicle.

use seatrial_core::{Action, Steering};
use serde::{Deserialize, Serialize};

/// Where a trial is, as far as its vehicle can tell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Moment {
    /// From the start to the first doublet.
    Settle,
    /// The training doublet.
    Training,
    /// Heading hold after the training doublet, up to the validation doublet.
    Decay,
    /// From the validation doublet on; settling for a repeat at the same thrust counts as this.
    Validation,
    /// From a change of thrust to the next doublet.
    Between,
}

impl Moment {
    /// Every moment.
    pub const ALL: [Self; 5] =
        [Self::Settle, Self::Training, Self::Decay, Self::Validation, Self::Between];

    /// Its name in a file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Settle => "settle",
            Self::Training => "training",
            Self::Decay => "decay",
            Self::Validation => "validation",
            Self::Between => "between",
        }
    }
}

/// Follows a trial from moment to moment.
#[derive(Clone, Debug, Default)]
pub(super) struct Stages {
    /// The present moment and when it began, s.
    pub now: Option<(Moment, f64)>,
    times: [u32; Moment::ALL.len()],
    steers: bool,
    thrust: Option<f64>,
}

impl Stages {
    /// Notes what is asked of the vehicle at a time.
    pub fn note(&mut self, action: &Action<f64>, time_s: f64) {
        let steers = matches!(action.steering, Steering::Rudder(_));
        let (starts, ends) = (steers && !self.steers, self.steers && !steers);
        let present = self.now.map(|(moment, _)| moment);
        let other_thrust =
            matches!((self.thrust, action.thrust), (Some(before), Some(now)) if before != now);
        let next = match present {
            _ if action.thrust.is_none() => None,
            Some(_) if other_thrust => Some(Moment::Between),
            None => Some(Moment::Settle),
            Some(Moment::Decay) if starts => Some(Moment::Validation),
            Some(_) if starts => Some(Moment::Training),
            Some(Moment::Training) if ends => Some(Moment::Decay),
            same => same,
        };
        (self.steers, self.thrust) = (steers, action.thrust);
        if next != present || (starts && next == Some(Moment::Training)) {
            self.now = next.map(|moment| (moment, time_s));
            if let Some(moment) = next {
                self.times[moment as usize] += 1;
            }
        }
    }

    /// How often a moment was entered.
    pub fn times(&self, moment: Moment) -> u32 {
        self.times[moment as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_two_speeds_and_a_repeat() {
        let hold = Steering::HoldHeading(0.0);
        let rudder = Steering::Rudder(0.1);
        let mut stages = Stages::default();
        let mut seen = Vec::new();
        for (k, (steering, thrust)) in [
            (hold, Some(0.6)),
            (rudder, Some(0.6)),
            (hold, Some(0.6)),
            (rudder, Some(0.6)),
            (hold, Some(0.6)),
            // A repeat.
            (rudder, Some(0.6)),
            (hold, Some(0.6)),
            (rudder, Some(0.6)),
            (hold, Some(0.8)),
            (rudder, Some(0.8)),
            (hold, None),
        ]
        .into_iter()
        .enumerate()
        {
            let action = Action { steering, thrust, outcome: None };
            stages.note(&action, k as f64);
            seen.push(stages.now.map(|(moment, _)| moment));
        }
        let expected = [
            Moment::Settle,
            Moment::Training,
            Moment::Decay,
            Moment::Validation,
            Moment::Validation,
            Moment::Training,
            Moment::Decay,
            Moment::Validation,
            Moment::Between,
            Moment::Training,
        ];
        let expected: Vec<_> = expected.into_iter().map(Some).chain([None]).collect();
        assert_eq!(seen, expected);
        assert_eq!(stages.times(Moment::Training), 3);
    }
}
