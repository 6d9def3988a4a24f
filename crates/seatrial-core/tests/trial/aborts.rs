//! Every abort, and what the vehicle is handed back with.

use seatrial_core::{
    AbortReason, Action, Event, List, NotSettled, Outcome, Plan, RudderSense, Sample, Stage,
    Steering, Trial,
};

use super::scripted::{INTERVAL_S, Log, Scripted, one_speed, run};

/// Spoils every sample from 5 s into training on, in the middle of the doublet.
fn in_training(spoil: Spoil) -> impl FnMut(&mut Trial<f64>, &mut Sample<f64>) {
    move |trial, sample| {
        let status = trial.status();
        if status.outcome.is_some()
            || (status.stage == Some(Stage::Train) && status.elapsed_s > 5.0)
        {
            spoil(sample);
        }
    }
}

fn assert_handed_back(name: &str, log: &Log, reason: AbortReason) {
    let ended = |event: &Event<f64>| match event {
        Event::Ended { outcome, .. } => Some(*outcome),
        _ => None,
    };
    assert_eq!(
        log.events.iter().filter_map(ended).collect::<Vec<_>>(),
        [Outcome::Aborted(reason)],
        "{name}"
    );
    let [before, neutral, held @ ..] = &log.actions[log.actions.len() - 5..] else {
        unreachable!()
    };
    assert_eq!(before.thrust, Some(0.8), "{name}");
    assert_eq!(
        *neutral,
        Action { steering: Steering::Rudder(0.0), thrust: None, outcome: None },
        "{name}"
    );
    for action in held {
        assert_eq!(
            (action.thrust, action.outcome),
            (None, Some(Outcome::Aborted(reason))),
            "{name}"
        );
        assert!(matches!(action.steering, Steering::HoldHeading(_)), "{name}");
        assert_eq!(action, &held[0], "{name}");
    }
}

/// A name, a plan, the sign of b2, how the samples are spoiled and the reason that must come of it.
type Case =
    (&'static str, Plan<f64>, f64, Box<dyn FnMut(&mut Trial<f64>, &mut Sample<f64>)>, AbortReason);

/// Changes a good sample into a bad one.
type Spoil = fn(&mut Sample<f64>);

/// Samples of the paper's vehicle that are spoiled in the middle of the doublet.
fn spoiled_samples() -> impl Iterator<Item = Case> {
    use AbortReason as Reason;
    let spoils: [(&str, Spoil, Reason); 17] = [
        ("deep", |s| s.depth_m = Some(11.0), Reason::Depth),
        ("flying", |s| s.depth_m = Some(-2.0), Reason::Depth),
        (
            "depth of a sample without heading",
            |s| (s.heading_rad, s.depth_m) = (f64::NAN, Some(11.0)),
            Reason::Depth,
        ),
        ("bottom", |s| s.altitude_m = Some(0.9), Reason::Altitude),
        ("below bottom", |s| s.altitude_m = Some(-1.0), Reason::Altitude),
        ("roll", |s| s.roll_rad = Some(-0.9), Reason::Roll),
        ("pitch", |s| s.pitch_rad = Some(0.7), Reason::Pitch),
        ("spin", |s| s.yaw_rate_rad_s = Some(-1.1), Reason::YawRate),
        ("slow", |s| s.surge_speed_m_s = Some(0.8), Reason::SpeedDrift),
        ("no heading", |s| s.heading_rad = f64::NAN, Reason::StaleSamples),
        ("no time", |s| s.time_s = f64::NAN, Reason::StaleSamples),
        ("clock stands", |s| s.time_s = 117.0, Reason::StaleSamples),
        ("clock back", |s| s.time_s -= 90.0, Reason::StaleSamples),
        ("clock forward", |s| s.time_s += 3.0, Reason::StaleSamples),
        ("depth lost", |s| s.depth_m = None, Reason::StaleSamples),
        ("far east", |s| s.east_m = Some(-10.1), Reason::Area),
        ("far north", |s| s.north_m = Some(10.1), Reason::Area),
    ];
    let mut plan = one_speed();
    plan.envelope.area =
        List::from_slice(&[[-10.0, -10.0], [-10.0, 10.0], [10.0, 10.0], [10.0, -10.0]]).unwrap();
    spoils.into_iter().map(move |(name, spoil, reason)| -> Case {
        (name, plan, 1.08, Box::new(in_training(spoil)), reason)
    })
}

/// Aborts that are asked for in the middle of validation.
fn asked_for() -> impl Iterator<Item = Case> {
    [("operator", AbortReason::Operator), ("link", AbortReason::LinkLost)].into_iter().map(
        |(name, reason)| -> Case {
            let ask = move |trial: &mut Trial<f64>, _: &mut Sample<f64>| {
                let status = trial.status();
                if status.stage == Some(Stage::Validate) && status.elapsed_s > 3.0 {
                    trial.abort(reason);
                }
            };
            (name, one_speed(), 1.08, Box::new(ask), reason)
        },
    )
}

/// Limits of the plan that the vehicle reaches by itself.
fn limits_reached() -> [Case; 5] {
    let plan = one_speed();
    let mut narrow = plan;
    narrow.envelope.heading_excursion_max_rad = 0.3;
    let mut hurried = plan;
    hurried.envelope.stage_time_limit_s = 20.0;
    let mut strict = plan;
    strict.settle.not_settled = NotSettled::Abort;
    let mut other_sense = plan;
    other_sense.envelope.rudder_sense = RudderSense::Negative;
    let sinking = |_: &mut Trial<f64>, sample: &mut Sample<f64>| {
        sample.depth_m = Some((sample.time_s - 100.0) * 0.2 % 8.0);
    };
    let as_they_are = |_: &mut Trial<f64>, _: &mut Sample<f64>| {};
    use AbortReason as Reason;
    let case = |name, plan, b2, script, reason| -> Case { (name, plan, b2, script, reason) };
    [
        case("excursion", narrow, 1.08, Box::new(as_they_are), Reason::HeadingExcursion),
        case("time limit", hurried, 1.08, Box::new(sinking), Reason::StageTimeLimit),
        case("not settled", strict, 1.08, Box::new(sinking), Reason::NotSettled),
        case("reversed", plan, -1.08, Box::new(as_they_are), Reason::ReversedRudder),
        case(
            "not the sense expected",
            other_sense,
            1.08,
            Box::new(as_they_are),
            Reason::ReversedRudder,
        ),
    ]
}

#[test]
fn exact_every_abort_hands_the_vehicle_back() {
    for (name, plan, b2_per_s2, script, reason) in
        spoiled_samples().chain(asked_for()).chain(limits_reached())
    {
        let log = run(plan, Scripted::new(b2_per_s2), script);
        assert_handed_back(name, &log, reason);
    }
}

#[test]
fn exact_an_abort_holds_the_last_good_heading() {
    let log = run(one_speed(), Scripted::new(1.08), in_training(|s| s.heading_rad = f64::NAN));
    assert_eq!(
        log.actions.last().unwrap().steering,
        Steering::HoldHeading(log.last_good_heading_rad)
    );
}

#[test]
fn exact_a_reversed_rudder_is_found_within_the_first_second() {
    let log = run(one_speed(), Scripted::new(-1.08), |_, _| {});
    let doublet = log
        .actions
        .iter()
        .filter(|action| matches!(action.steering, Steering::Rudder(r) if r != 0.0))
        .count();
    assert!(doublet <= 20, "{doublet} samples of 0.05 s");
}

#[test]
fn exact_limits_come_before_the_end_of_a_stage() {
    let mut validated = false;
    let log = run(one_speed(), Scripted::new(1.08), |trial, sample| {
        let status = trial.status();
        validated |= status.stage == Some(Stage::Validate);
        // The very sample with which the run would end.
        if validated && status.remaining_s < 1.5 * INTERVAL_S {
            sample.depth_m = Some(50.0);
        }
    });
    assert_handed_back("last sample", &log, AbortReason::Depth);
    assert_eq!(log.results(), []);
}
