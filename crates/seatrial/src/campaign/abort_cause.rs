//! What the record of a trial shows of the cause for which the trial was aborted.

use seatrial_core::model::YawState;
use seatrial_core::{AbortReason, Real, Sample, YawModel};

use crate::figures::{degrees, with_decimals};
use crate::identification::{Reason, ReasonCode};
use crate::identify::heading_jump;

/// The end of the record that shows which measurement stopped, s.
const LAST_S: f64 = 1.0;
/// The end of the settling that shows where heading and rudder stood, s.
const BEFORE_S: f64 = 2.0;
/// The turn over the one that an earlier model foresees, of a rudder that works the other way round.
const OTHER_WAY: [f64; 2] = [-2.0, -0.25];

/// What to do after an operator stopped a trial that has models.
const KEPT: &str =
    "Nothing need be wrong: start again when ready; the runs recorded so far stay valid.";

/// What may tell why a trial was aborted.
pub(crate) struct Evidence<'a> {
    /// The run in which it was.
    pub samples: &'a [Sample<f64>],
    /// When its training began.
    pub training_from_s: Option<f64>,
    /// Thrust and model of the earlier run nearest to it.
    pub earlier: Option<(f64, YawModel<f64>)>,
    /// Was a run accepted?
    pub has_models: bool,
}

/// The reason of a trial that was aborted: what the record shows, else what the limit by itself says.
pub(crate) fn reason(aborted: AbortReason, evidence: Option<&Evidence>) -> Reason {
    let shown = evidence.and_then(|found| {
        compass_failed(aborted, found.samples).or_else(|| match aborted {
            AbortReason::ReversedRudder => works_the_other_way(found),
            AbortReason::StaleSamples => outputs_failed(found.samples),
            _ => None,
        })
    });
    let has_models = evidence.is_some_and(|found| found.has_models);
    let (cause, action) = shown.unwrap_or_else(|| match (aborted, has_models) {
        (AbortReason::Operator, true) => (aborted.to_string(), KEPT),
        _ => (aborted.to_string(), action(aborted)),
    });
    Reason {
        action: action.into(),
        ..Reason::new(ReasonCode::Aborted, format!("the trial was aborted: {cause}"))
    }
}

/// Does the record show that it was the compass?
pub(crate) fn is_compass(aborted: AbortReason, found: &Evidence) -> bool {
    compass_failed(aborted, found.samples).is_some()
}

/// What the compass did that looks like this reason.
fn compass_failed(aborted: AbortReason, samples: &[Sample<f64>]) -> Option<CauseWords> {
    match aborted {
        AbortReason::StaleSamples => heading_stopped(samples),
        AbortReason::ReversedRudder | AbortReason::HeadingExcursion | AbortReason::YawRate => {
            jumped(samples)
        }
        _ => None,
    }
}

/// Cause and action.
type CauseWords = (String, &'static str);

/// The heading was missing at last while other measurements came.
fn heading_stopped(samples: &[Sample<f64>]) -> Option<CauseWords> {
    let end_s = samples.last()?.time_s;
    let heard = samples.iter().rposition(|s| s.heading_rad.is_finite())?;
    let silent_s = end_s - samples[heard].time_s;
    (silent_s >= LAST_S).then(|| {
        (
            format!(
                "the compass gave no heading for {} s while the other measurements came",
                with_decimals(silent_s, 1)
            ),
            "Look at the compass, its supply and its connection before the next trial.",
        )
    })
}

/// The heading came and moved to the end, and the rudder was not known, or nothing else was missing.
fn outputs_failed(samples: &[Sample<f64>]) -> Option<CauseWords> {
    let end_s = samples.last()?.time_s;
    let last = &samples[samples.partition_point(|s| s.time_s < end_s - LAST_S)..];
    let first_rad = last.first()?.heading_rad;
    let is_measured = last.iter().all(|s| s.heading_rad.is_finite());
    let moves = last.iter().any(|s| s.heading_rad != first_rad);
    let is_even = last
        .windows(2)
        .all(|pair| (0.0..0.5 * LAST_S).contains(&(pair[1].time_s - pair[0].time_s)));
    if !(is_measured && moves && is_even) {
        return None;
    }
    let unknown = last.iter().filter(|s| !s.rudder_rad.is_finite()).count();
    let what = match (2 * unknown > last.len(), others_stopped(samples, last)) {
        (true, _) => "came too late, or not at all",
        (false, false) => "came too rarely to tell when the rudder moved",
        (false, true) => return None,
    };
    Some((
        format!("the outputs that tell the rudder {what}, while the heading came"),
        "Look at the link, and at how often the autopilot sends its servo outputs (SERVO_OUTPUT_RAW).",
    ))
}

/// Did a measurement besides heading and rudder come before, and not at the end?
fn others_stopped(samples: &[Sample<f64>], last: &[Sample<f64>]) -> bool {
    let others =
        |s: &Sample<f64>| [s.depth_m, s.altitude_m, s.roll_rad, s.pitch_rad, s.surge_speed_m_s];
    let came = |part: &[Sample<f64>], k: usize| {
        part.iter().filter_map(|s| others(s)[k]).any(f64::is_finite)
    };
    (0..5).any(|k| came(samples, k) && !came(last, k))
}

fn jumped(samples: &[Sample<f64>]) -> Option<CauseWords> {
    let jump = heading_jump(samples)?;
    Some((
        format!(
            "at {} s the compass jumped by {} deg, or was disturbed",
            with_decimals(jump.time_s, 1),
            degrees(jump.size_rad)
        ),
        "Look at the compass: no vehicle turns so fast. Then start again, away from iron and electric currents.",
    ))
}

/// The vehicle turned as an earlier run of the trial foresees, but to the other side.
fn works_the_other_way(found: &Evidence) -> Option<CauseWords> {
    let (thrust, model) = found.earlier?;
    let turned = turn_over_foreseen(found, model)?;
    (OTHER_WAY[0]..OTHER_WAY[1]).contains(&turned).then(|| {
        (
            format!(
                "the rudder turned the vehicle the other way than at {:.0} % thrust",
                100.0 * thrust
            ),
            "Look at the rudder, its linkage and the sign of its output: something was changed or came loose. Compass and water do not look like this.",
        )
    })
}

/// Least squares slope of the turn in training over the one that the model of another run foresees.
fn turn_over_foreseen(found: &Evidence, model: YawModel<f64>) -> Option<f64> {
    let without_offset = YawModel { c0_rad_per_s2: 0.0, ..model };
    let from_s = found.training_from_s?;
    let near = |s: &&Sample<f64>| s.heading_rad.is_finite() && s.time_s >= from_s - BEFORE_S;
    let samples: Vec<Sample<f64>> = found.samples.iter().filter(near).copied().collect();
    let (before, training) = samples.split_at(samples.partition_point(|s| s.time_s < from_s));
    let [heading_rad, rudder_rad] = stood(before)?;
    let mut foreseen = YawState::default();
    let (mut squares, mut products) = (0.0, 0.0);
    for pair in training.windows(2) {
        let deflection_rad = pair[0].rudder_rad - rudder_rad;
        let interval_s = pair[1].time_s - pair[0].time_s;
        foreseen = without_offset.advance(foreseen, deflection_rad, interval_s);
        let turned_rad = Real::wrapped(pair[1].heading_rad - heading_rad);
        squares += foreseen.heading_rad * foreseen.heading_rad;
        products += foreseen.heading_rad * turned_rad;
    }
    (squares > 0.0).then(|| products / squares)
}

/// Mean heading and mean rudder, rad.
fn stood(samples: &[Sample<f64>]) -> Option<[f64; 2]> {
    let first_rad = samples.first()?.heading_rad;
    let mean = |of: &dyn Fn(&Sample<f64>) -> f64| {
        samples.iter().map(of).sum::<f64>() / samples.len() as f64
    };
    let away_rad = mean(&|s| Real::wrapped(s.heading_rad - first_rad));
    Some([first_rad + away_rad, mean(&|s| s.rudder_rad)])
}

/// What to do after the trial stopped.
fn action(reason: AbortReason) -> &'static str {
    match reason {
        AbortReason::Operator => "Nothing need be wrong: start again when ready.",
        AbortReason::Depth => {
            "Check ballast and depth control, or widen the depth limits of the plan if the water allows it."
        }
        AbortReason::Altitude => "Choose deeper water or a shallower run.",
        AbortReason::Roll => "Check trim and ballast, or lower the rudder amplitude of the plan.",
        AbortReason::Pitch => "Check trim and depth control before the next try.",
        AbortReason::YawRate => {
            "Lower the rudder amplitude of the plan, or raise the limit if the vehicle bears it."
        }
        AbortReason::HeadingExcursion => {
            "See first whether the rudder jammed or the compass jumped: the report shows both. If not, lower the rudder amplitude or shorten the doublet in the plan."
        }
        AbortReason::Area => {
            "Start farther from the edge or with a heading along the longer side; “seatrial plan” shows the room that a trial needs."
        }
        AbortReason::SpeedDrift => {
            "Allow more time to settle at each thrust, and check the propulsion and the current."
        }
        AbortReason::StaleSamples => {
            "Check the compass, the link, and how often and how late the outputs of the servos come: the report shows where the samples stopped."
        }
        AbortReason::StageTimeLimit => {
            "Check the clock of the vehicle and the time limits of the plan."
        }
        AbortReason::ReversedRudder => {
            "Look at the report: a compass that jumped or a current from the side looks like this, too. If neither, check the sign of the rudder and of the heading: with this sign the heading controller is unstable."
        }
        AbortReason::NoAnswer => {
            "Look whether the compass hangs, and whether the rudder is connected and strong enough to turn the vehicle. A vehicle slower than the plan is for needs its own plan: “seatrial plan --time-constant 30” of 30 s."
        }
        AbortReason::NotSettled => {
            "Look at the heading in the report: if it swings, lower the gain of the initial heading controller; if it drifts, check trim and current."
        }
        AbortReason::LinkLost => {
            "Restore the link and start again; check that the vehicle did what it must on a lost link."
        }
        AbortReason::ModeChanged | AbortReason::StickMoved | AbortReason::Disarmed => {
            "Start again when the pilot agrees; the trial takes nothing back by itself."
        }
        AbortReason::LowBattery => "Bring the vehicle home; charge it before the next trial.",
        AbortReason::Failsafe => {
            "Look into the autopilot's own log for what it acted upon before starting again."
        }
        AbortReason::Restarted => {
            "Look into its supply of power; what it measured before and after is not one record."
        }
        AbortReason::SecondStation => {
            "Stop the other ground station, or give one of both another system id."
        }
        AbortReason::RudderNotFollowed => {
            "Look at the rudder and its servo, and at who else may command it: mode, mixer, limits of the outputs."
        }
        AbortReason::NotAttended => {
            "Look at the load of its computer and at the disk that keeps the logbook."
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(rudder_rad: f64, depth_m: Option<f64>) -> Vec<Sample<f64>> {
        let sample = |k: u32| Sample {
            time_s: 0.05 * f64::from(k),
            heading_rad: 0.01 * f64::from(k % 7),
            rudder_rad: if k < 40 { 0.1 } else { rudder_rad },
            depth_m: if k < 40 { Some(1.0) } else { depth_m },
            ..Sample::default()
        };
        (0..100).map(sample).collect()
    }

    #[test]
    fn exact_outputs_that_are_late_or_rare_are_not_the_compass() {
        let cause = |samples: &[Sample<f64>]| {
            let evidence =
                Evidence { samples, training_from_s: None, earlier: None, has_models: false };
            reason(AbortReason::StaleSamples, Some(&evidence)).text
        };
        assert!(cause(&record(f64::NAN, Some(1.0))).contains("too late"));
        assert!(cause(&record(0.1, Some(1.0))).contains("too rarely"));
        // Another measurement stopped, or the heading is always the same.
        assert!(cause(&record(0.1, None)).contains("no usable sample"));
        let mut frozen = record(0.1, Some(1.0));
        frozen.iter_mut().for_each(|s| s.heading_rad = 0.2);
        assert!(cause(&frozen).contains("no usable sample"));
    }
}
