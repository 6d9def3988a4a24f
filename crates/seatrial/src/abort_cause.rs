//! What the record of a trial shows of the cause for which the trial was aborted.

use seatrial_core::model::YawState;
use seatrial_core::{AbortReason, Real, Sample, Stage, YawModel};

use crate::campaign::{Campaign, Run, abort_action};
use crate::figures::{degrees, with_decimals};
use crate::identification::{Reason, ReasonCode};
use crate::identify::heading_jump;

/// The end of the record that shows which measurement stopped, s.
const LAST_S: f64 = 1.0;
/// The end of the settling that shows where heading and rudder stood, s.
const BEFORE_S: f64 = 2.0;
/// The turn over the one that an earlier model foresees, of a rudder that works the other way round.
const OTHER_WAY: [f64; 2] = [-2.0, -0.5];

/// The reason of a trial that was aborted: what the record shows, else what the limit by itself says.
pub(crate) fn reason(campaign: &Campaign, aborted: AbortReason) -> Reason {
    let last = campaign.runs.last();
    let shown = last.and_then(|run| match aborted {
        AbortReason::StaleSamples => heading_stopped(run),
        AbortReason::ReversedRudder => jumped(run).or_else(|| works_the_other_way(campaign, run)),
        AbortReason::HeadingExcursion | AbortReason::YawRate => jumped(run),
        _ => None,
    });
    let (cause, action) = shown.unwrap_or((aborted.to_string(), abort_action(aborted)));
    Reason {
        action: action.into(),
        ..Reason::new(
            ReasonCode::Aborted,
            format!("the trial was aborted: {cause}"),
        )
    }
}

/// Cause and action.
type Shown = (String, &'static str);

/// The heading was missing at last while other measurements came.
fn heading_stopped(run: &Run) -> Option<Shown> {
    let samples = &run.record.samples;
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

fn jumped(run: &Run) -> Option<Shown> {
    let jump = heading_jump(&run.record.samples)?;
    Some((
        format!(
            "at {} s the compass jumped by {} deg, or was disturbed",
            with_decimals(jump.time_s, 1),
            degrees(jump.size_rad)
        ),
        "Look at the compass: no vehicle turns so fast. Then start again, away from iron and electric currents.",
    ))
}

/// The vehicle turned as an accepted run of the trial foresees, but to the other side.
fn works_the_other_way(campaign: &Campaign, run: &Run) -> Option<Shown> {
    let accepted = campaign.accepted_runs();
    let away = |other: &&Run| (other.thrust - run.thrust).abs();
    let earlier = accepted
        .into_iter()
        .min_by(|a, b| away(a).total_cmp(&away(b)))?;
    let turned = turn_over_foreseen(run, earlier)?;
    (OTHER_WAY[0]..OTHER_WAY[1]).contains(&turned).then(|| {
        (
            format!(
                "the rudder turned the vehicle the other way than at {:.0} % thrust",
                100.0 * earlier.thrust
            ),
            "Look at the rudder, its linkage and the sign of its output: something was changed or came loose. Compass and water do not look like this.",
        )
    })
}

/// Least squares slope of the turn in training over the one that the model of another run foresees.
fn turn_over_foreseen(run: &Run, other: &Run) -> Option<f64> {
    let without_offset = YawModel {
        c0_rad_per_s2: 0.0,
        ..other.identification.as_ref()?.model()
    };
    let from_s = run.stage(Stage::Train)?.from_s;
    let near = |s: &&Sample<f64>| s.heading_rad.is_finite() && s.time_s >= from_s - BEFORE_S;
    let samples: Vec<Sample<f64>> = run.record.samples.iter().filter(near).copied().collect();
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
