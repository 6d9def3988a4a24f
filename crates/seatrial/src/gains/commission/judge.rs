//! Keep the new gains, or put the old ones back.

use std::fmt;

use serde::Serialize;

use super::StepInstant;
use super::foresee::Foreseen;
use super::response::{Response, WITHIN, scatter_rad};

/// What new gains may not exceed whatever the old ones did: overshoot and oscillation, fractions of the step; steady error,
/// rad; rudder activity, full deflections per second.
const MOST_OVERSHOOT: f64 = 0.12;
const MOST_OSCILLATION: f64 = 0.08;
const MOST_STEADY_ERROR_RAD: f64 = 0.035;
const MOST_ACTIVITY_PER_S: f64 = 0.5;
/// A small step is measured less well: its overshoot and oscillation may be that much more, rad.
const SMALL_STEP_RAD: f64 = 0.0175;
/// New gains are no worse than old ones within these: overshoot, a fraction of the step; settling, s.
const OVERSHOOT_ALIKE: f64 = 0.04;
const SETTLING_ALIKE_S: f64 = 0.1;
/// Beyond what was foreseen: overshoot, a fraction of the step; settling and activity, shares.
const BEYOND_OVERSHOOT: f64 = 0.06;
const BEYOND_SETTLING: f64 = 1.6;
const BEYOND_ACTIVITY: f64 = 2.0;
/// Activity that needs no comparison, full deflections per second.
const LITTLE_ACTIVITY_PER_S: f64 = 0.1;

/// Steps of a commission that are repeated at most.
pub const MOST_REPEATS: usize = 2;

/// Which step is judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// The first small one.
    Small,
    /// The full one, which is compared with the old gains, too.
    Full,
}

/// What speaks against the new gains.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "code")]
pub enum Against {
    /// The heading does not settle.
    NotSettled,
    /// It goes too far.
    Overshoot {
        /// Found, a fraction of the step.
        found: f64,
        /// The most.
        most: f64,
    },
    /// It swings.
    Oscillation {
        /// Found, a fraction of the step.
        found: f64,
        /// The most.
        most: f64,
    },
    /// It settles too late.
    SettlesLate {
        /// Found, s.
        found_s: f64,
        /// The most, s.
        most_s: f64,
    },
    /// It stays beside the wanted heading.
    SteadyError {
        /// Found, rad.
        found_rad: f64,
        /// The most, rad.
        most_rad: f64,
    },
    /// The rudder works too much.
    Activity {
        /// Found, full deflections per second.
        found_per_s: f64,
        /// The most, full deflections per second.
        most_per_s: f64,
    },
}

impl fmt::Display for Against {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let percent = |value: &f64| 100.0 * value;
        match self {
            Self::NotSettled => write!(f, "the heading does not settle"),
            Self::Overshoot { found, most } => write!(
                f,
                "it overshoots by {:.0} %, at most {:.0} % would do",
                percent(found),
                percent(most)
            ),
            Self::Oscillation { found, most } => write!(
                f,
                "it swings by {:.0} % of the step, at most {:.0} % would do",
                percent(found),
                percent(most)
            ),
            Self::SettlesLate { found_s, most_s } => {
                write!(f, "it settles after {found_s:.1} s, at most {most_s:.1} s would do")
            }
            Self::SteadyError { found_rad, most_rad } => write!(
                f,
                "it stays {:.1} degrees beside the wanted heading, at most {:.1} would do",
                found_rad.to_degrees(),
                most_rad.to_degrees()
            ),
            Self::Activity { found_per_s, most_per_s } => write!(
                f,
                "the rudder works by {:.0} % of full a second, at most {:.0} % would do",
                percent(found_per_s),
                percent(most_per_s)
            ),
        }
    }
}

/// What becomes of the new gains.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Judgement {
    /// Do they stay?
    pub keep: bool,
    /// What speaks against them.
    pub against: Vec<Against>,
}

impl Judgement {
    /// May a wave have done it, so that the step is worth repeating? A heading that swings is left alone.
    ///
    /// ```
    /// use seatrial::gains::commission::{Against, Judgement};
    ///
    /// let against = |against| Judgement { keep: false, against: vec![against] };
    /// // A wave may carry the heading too far once; it does not make it swing.
    /// assert!(against(Against::Overshoot { found: 0.3, most: 0.1 }).is_worth_repeating());
    /// assert!(!against(Against::Oscillation { found: 0.3, most: 0.1 }).is_worth_repeating());
    /// ```
    pub fn is_worth_repeating(&self) -> bool {
        let swings = |against: &Against| matches!(against, Against::Oscillation { .. });
        !self.keep && !self.against.iter().any(swings)
    }
}

/// What steps with new gains, and those with the old ones, are found to be in one sea, and what becomes of the new gains.
#[derive(Clone, Debug, PartialEq)]
pub struct JudgedSteps {
    /// Steps with the new gains, all repeats.
    pub new: Response,
    /// Those with the old ones.
    pub old: Response,
    /// What becomes of the new gains.
    pub judgement: Judgement,
}

/// Judges repeated steps of this size with the new gains beside those of the old ones, which had a size of their own. The heading is averaged over
/// `smoothing_s`. What the calmer of the old steps and the last new ones leave is sea and compass. `None` where a leg has too few samples.
pub fn judge_repeats(
    (stage, step_rad): (Stage, f64),
    new: &[[Vec<StepInstant>; 2]],
    (old, old_step_rad): (&[Vec<StepInstant>; 2], f64),
    foreseen: &Foreseen,
    smoothing_s: f64,
) -> Option<JudgedSteps> {
    let scatter_rad = scatter_rad(old, smoothing_s)?.min(scatter_rad(new.last()?, smoothing_s)?);
    let new = Response::of_repeats(new, step_rad, smoothing_s, scatter_rad)?;
    let old = Response::measure(old, old_step_rad, smoothing_s, scatter_rad)?;
    let judgement = judge(stage, step_rad, &new, Some(&old), foreseen, scatter_rad);
    Some(JudgedSteps { new, old, judgement })
}

/// Judges the new gains by a step of this size. The old ones count where they did better; where they did not settle, the
/// limits that hold for every boat still do. `scatter_rad` is what sea and compass move a heading by that is held.
///
/// Gains that overshoot less than the old ones by a share of the step may take that share longer to settle, and what the scatter makes of both times.
fn judge(
    stage: Stage,
    step_rad: f64,
    new: &Response,
    old: Option<&Response>,
    foreseen: &Foreseen,
    scatter_rad: f64,
) -> Judgement {
    let small_rad = match stage {
        Stage::Small => SMALL_STEP_RAD,
        Stage::Full => 0.0,
    };
    let spare = [1.0, WITHIN].map(|times| (small_rad + times * scatter_rad) / step_rad);
    let old = old.filter(|_| stage == Stage::Full);
    let mut against = Vec::new();
    let Some(found_s) = new.settling_s else {
        against.push(Against::NotSettled);
        against.extend(excess(new, old, foreseen, spare));
        return Judgement { keep: false, against };
    };
    let alike_s = old.and_then(|old| {
        let less = (old.overshoot - new.overshoot).max(0.0);
        let error_s = libm::hypot(old.settling_error_s, new.settling_error_s);
        Some((1.0 + less) * old.settling_s? + SETTLING_ALIKE_S + error_s)
    });
    let foreseen_s = BEYOND_SETTLING * foreseen.settling_s.high + SETTLING_ALIKE_S;
    let most_s = alike_s.map_or(foreseen_s, |alike_s| alike_s.min(foreseen_s));
    if found_s > most_s {
        against.push(Against::SettlesLate { found_s, most_s });
    }
    against.extend(excess(new, old, foreseen, spare));
    Judgement { keep: against.is_empty(), against }
}

/// What exceeds the limits of a boat that has settled or has not.
fn excess(
    new: &Response,
    old: Option<&Response>,
    foreseen: &Foreseen,
    [spare_overshoot, spare_oscillation]: [f64; 2],
) -> impl Iterator<Item = Against> {
    let foreseen_overshoot = foreseen.overshoot.high + BEYOND_OVERSHOOT;
    let alike = old
        .map_or(f64::INFINITY, |old| (old.overshoot + OVERSHOOT_ALIKE).max(2.0 * OVERSHOOT_ALIKE));
    let overshoot = MOST_OVERSHOOT.min(foreseen_overshoot).min(alike) + spare_overshoot;
    let oscillation = MOST_OSCILLATION + spare_oscillation;
    let foreseen_activity = BEYOND_ACTIVITY * foreseen.activity_per_s.high;
    let activity = MOST_ACTIVITY_PER_S.min(foreseen_activity.max(LITTLE_ACTIVITY_PER_S));
    let found = [
        (new.overshoot > overshoot)
            .then_some(Against::Overshoot { found: new.overshoot, most: overshoot }),
        (new.oscillation > oscillation)
            .then_some(Against::Oscillation { found: new.oscillation, most: oscillation }),
        (new.steady_error_rad > MOST_STEADY_ERROR_RAD).then_some(Against::SteadyError {
            found_rad: new.steady_error_rad,
            most_rad: MOST_STEADY_ERROR_RAD,
        }),
        (new.activity_per_s > activity)
            .then_some(Against::Activity { found_per_s: new.activity_per_s, most_per_s: activity }),
    ];
    found.into_iter().flatten()
}

#[cfg(test)]
mod tests {
    use super::super::foresee::Range;
    use super::*;

    fn foreseen() -> Foreseen {
        let range = |low, high| Range { middle: 0.5 * (low + high), low, high };
        Foreseen {
            overshoot: range(0.0, 0.05),
            settling_s: range(3.0, 5.0),
            activity_per_s: range(0.02, 0.1),
            oscillation: range(0.0, 0.02),
            settled: 1.0,
        }
    }

    fn good() -> Response {
        Response {
            overshoot: 0.03,
            settling_s: Some(4.0),
            settling_error_s: 0.0,
            steady_error_rad: 0.002,
            activity_per_s: 0.05,
            oscillation: 0.01,
        }
    }

    fn against(new: Response, old: Option<Response>) -> Vec<Against> {
        judge(Stage::Full, 0.5, &new, old.as_ref(), &foreseen(), 0.0).against
    }

    #[test]
    fn exact_good_gains_stay_and_each_fault_is_named() {
        assert_eq!(against(good(), Some(good())), []);
        type Names = fn(&Against) -> bool;
        let faults: [(Response, Names); 5] = [
            (Response { overshoot: 0.2, ..good() }, |a| matches!(a, Against::Overshoot { .. })),
            (Response { settling_s: None, ..good() }, |a| matches!(a, Against::NotSettled)),
            (Response { settling_s: Some(9.0), ..good() }, |a| {
                matches!(a, Against::SettlesLate { .. })
            }),
            (Response { steady_error_rad: 0.1, ..good() }, |a| {
                matches!(a, Against::SteadyError { .. })
            }),
            (Response { oscillation: 0.2, ..good() }, |a| matches!(a, Against::Oscillation { .. })),
        ];
        for (new, is_named) in faults {
            let found = against(new, Some(good()));
            assert!(found.len() == 1 && is_named(&found[0]), "{found:?}");
        }
    }

    /// Old gains that never settled are no excuse: the rudder's work is judged all the same.
    #[test]
    fn regress_the_rudder_is_judged_where_the_old_gains_did_not_settle() {
        let unsettled = Response { settling_s: None, activity_per_s: 3.0, ..good() };
        let busy = Response { activity_per_s: 1.5, ..good() };
        for old in [Some(unsettled), None] {
            let found = against(busy, old);
            assert!(matches!(found[..], [Against::Activity { .. }]), "{found:?}");
        }
    }

    /// 31 % and 5.9 s with the old gains, none and 6.3 s with the new ones.
    #[test]
    fn regress_half_a_second_is_no_reason_for_a_large_overshoot() {
        let old = Response { overshoot: 0.31, settling_s: Some(5.9), ..good() };
        let new = Response { overshoot: 0.0, settling_s: Some(6.3), ..good() };
        assert_eq!(against(new, Some(old)), []);
    }

    /// A time that the scatter moves by a second is no later by half a second.
    #[test]
    fn regress_times_are_compared_to_within_their_errors() {
        let within = |settling_error_s| Response { settling_error_s, ..good() };
        let later =
            |settling_error_s| Response { settling_s: Some(4.5), ..within(settling_error_s) };
        assert_eq!(against(later(0.5), Some(within(0.5))), []);
        assert!(!against(later(0.1), Some(within(0.1))).is_empty());
    }

    /// Old gains that settle sooner are the measure.
    #[test]
    fn exact_new_gains_that_are_slower_than_the_old_ones_go() {
        let quick = Response { settling_s: Some(2.0), ..good() };
        let found = against(good(), Some(quick));
        assert!(matches!(found[..], [Against::SettlesLate { .. }]), "{found:?}");
        let small = judge(Stage::Small, 0.14, &good(), Some(&quick), &foreseen(), 0.0);
        assert!(small.keep, "{small:?}");
    }
}
