use seatrial_core::{Real, Sample};

use super::*;
use crate::identification::{ReasonCode, ReasonKind, Subject};
use crate::record::RudderUnit;
use crate::stated_units::{ColumnUnit, Origin, StatedUnits};

const DEG: f64 = 180.0 / std::f64::consts::PI;

fn unit(per_si: f64, origin: Origin) -> ColumnUnit {
    ColumnUnit { per_si, origin, ..ColumnUnit::default() }
}

/// 30 s at 20 Hz of a turn to and fro through north by 35 deg either way, its rudder a sine of 15 deg.
fn record(units: StatedUnits) -> Record {
    let samples = (0..600).map(|k| {
        let time_s = f64::from(k) * 0.05;
        Sample {
            time_s,
            heading_rad: (0.6 * (0.5 * time_s).sin()).rem_euclid(std::f64::consts::TAU),
            yaw_rate_rad_s: Some(0.3 * (0.5 * time_s).cos()),
            rudder_rad: 0.26 * (0.5 * time_s).cos(),
            ..Sample::default()
        }
    });
    Record { units, ..samples.collect() }
}

fn stated_degrees() -> StatedUnits {
    StatedUnits {
        time: unit(1.0, Origin::Stated),
        heading: unit(DEG, Origin::Stated),
        rudder: unit(DEG, Origin::Stated),
        yaw_rate: unit(DEG, Origin::Stated),
        ..StatedUnits::default()
    }
}

fn without_rate(mut record: Record) -> Record {
    for sample in &mut record.samples {
        sample.yaw_rate_rad_s = None;
    }
    record
}

/// What a reader that believes the unit makes of numbers in another one.
fn scaled(mut record: Record, heading: f64, rudder: f64, time: f64) -> Record {
    for sample in &mut record.samples {
        sample.heading_rad *= heading;
        sample.rudder_rad *= rudder;
        sample.time_s *= time;
    }
    record
}

/// With the number of the row as its time.
fn counting_rows(mut record: Record) -> Record {
    for (row, sample) in record.samples.iter_mut().enumerate() {
        sample.time_s = row as f64;
    }
    record
}

fn codes(record: &Record) -> Vec<ReasonKind> {
    unit_doubts(record).iter().map(Doubt::kind).collect()
}

fn refusals(record: &Record) -> Vec<Doubt> {
    let doubts = unit_doubts(record).into_iter();
    doubts.filter(Doubt::refuses).collect()
}

#[test]
fn exact_sound_units_are_left_alone() {
    assert_eq!(codes(&record(StatedUnits::default())), []);
    assert_eq!(codes(&record(stated_degrees())), []);
    assert_eq!(codes(&without_rate(record(stated_degrees()))), []);
    let bare = StatedUnits {
        heading: unit(1.0, Origin::Assumed),
        rudder: unit(1.0, Origin::Assumed),
        ..StatedUnits::default()
    };
    assert!(refusals(&without_rate(record(bare))).is_empty());
}

/// A unit that nobody stated is settled by a turn through north, a date, a yaw rate or the user, and else told with the options.
#[test]
fn exact_an_assumed_scale_is_told_until_something_shows_it() {
    let assumed = |per_si| unit(per_si, Origin::Assumed);
    let mut units = stated_degrees();
    units.heading = assumed(DEG);
    units.time = assumed(1.0);
    // Turned away from north, where nothing wraps.
    let away = |units| {
        let mut record = record(units);
        for sample in &mut record.samples {
            sample.heading_rad = Real::wrapped(sample.heading_rad) + 1.0;
        }
        record
    };
    assert_eq!(codes(&away(units)), []);
    let mut bare = without_rate(away(units));
    let doubt = &unit_doubts(&bare)[0];
    assert!(!doubt.refuses() && doubt.reason().limits(), "{doubt:?}");
    assert!(doubt.text().ends_with("say --unit heading=deg --unit time=s"), "{}", doubt.text());
    // A speed makes no model doubtful by itself, and is settled with the others.
    let mut with_speed = bare.clone();
    with_speed.units.speed = assumed(3600.0 / 1852.0);
    let text = unit_doubts(&with_speed)[0].text();
    assert!(text.ends_with("--unit time=s --unit speed=kn"), "{text}");
    with_speed.units = stated_degrees();
    with_speed.units.speed = assumed(1.0);
    assert_eq!(codes(&with_speed), []);
    bare.units.time_is_a_date = true;
    bare.units.heading.origin = Origin::Given;
    assert_eq!(codes(&bare), []);
    let through_north =
        without_rate(record(StatedUnits { time: unit(1.0, Origin::Stated), ..units }));
    assert_eq!(codes(&through_north), []);
    let mut contradicted = scaled(away(units), 1.0, 1.0, 1000.0);
    contradicted.units.rudder.origin = Origin::Assumed;
    assert!(unit_doubts(&contradicted)[0].refuses());
}

#[test]
fn exact_angles_in_the_other_unit_are_found() {
    let radians_as_degrees = 1.0 / DEG;
    let lying = scaled(without_rate(record(stated_degrees())), radians_as_degrees, 1.0, 1.0);
    let doubts = unit_doubts(&lying);
    assert!(doubts[0].text().contains("wraps at 2 pi"), "{doubts:?}");
    assert!(doubts[0].refuses());
    // Away from north nothing wraps, but the heading turns by a degree under 15 deg of rudder.
    let mut away = lying.clone();
    for sample in &mut away.samples {
        sample.heading_rad =
            (sample.heading_rad * DEG + 1.5).rem_euclid(std::f64::consts::TAU) / DEG;
    }
    assert_eq!(codes(&away), [ReasonCode::UnitDoubtful.of(Subject::Heading)]);
    away.units.heading.origin = Origin::Given;
    assert_eq!(codes(&away), [ReasonCode::UnitDoubtful.of(Subject::Heading)]);
    assert!(!unit_doubts(&away)[0].refuses());
    // Degrees that somebody says are radians: nobody begins a log 14 turns from north, unless a gyro says the same.
    let mut turned = record(stated_degrees());
    for sample in &mut turned.samples {
        sample.heading_rad = 90.0 + Real::wrapped(sample.heading_rad) * DEG;
    }
    turned.units.heading = unit(1.0, Origin::Given);
    let found = codes(&without_rate(turned.clone()));
    assert!(found.contains(&ReasonCode::UnitDoubtful.of(Subject::Heading)), "{found:?}");
    assert!(!codes(&turned).contains(&ReasonCode::UnitDoubtful.of(Subject::Heading)));
    // Degrees that somebody says are radians: no rudder stands at 15 rad.
    let mut chosen = scaled(record(stated_degrees()), 1.0, DEG, 1.0);
    chosen.units.rudder = unit(1.0, Origin::Given);
    assert_eq!(codes(&chosen), [ReasonCode::UnitDoubtful.of(Subject::Rudder)]);
    let rudder = scaled(record(stated_degrees()), 1.0, radians_as_degrees, 1.0);
    assert_eq!(codes(&rudder), [ReasonCode::UnitDoubtful.of(Subject::Rudder)]);
}

/// A unit that was chosen is doubted where no vessel could turn so.
#[test]
fn exact_a_chosen_time_by_which_no_vessel_turns_is_refused() {
    let by = |factor: f64| {
        let mut record = record(StatedUnits::default());
        for sample in &mut record.samples {
            sample.time_s *= factor;
        }
        unit_doubts(&without_rate(record))
    };
    assert_eq!(by(1.0), []);
    // 17 deg/s by a clock that runs ten times too slowly.
    assert_eq!(by(0.1), []);
    let doubts = by(0.02);
    assert!(matches!(doubts[..], [Doubt::TurnsTooFast { .. }]), "{doubts:?}");
    assert!(doubts[0].reason().text.contains("which no vessel does"));
    assert!(matches!(by(0.001)[..], [Doubt::TimeUnit { .. }]));
}

/// A heading without a unit by which no vessel turns is cured by the unit of the heading, not of the time.
#[test]
fn exact_a_heading_that_turns_too_fast_asks_for_its_own_unit() {
    let doubt = |is_of_heading| Doubt::TurnsTooFast { yaw_rate_rad_s: 20.0, is_of_heading };
    let [heading, time] = [true, false].map(|is_of_heading| doubt(is_of_heading).reason());
    assert_eq!(heading.kind(), ReasonCode::UnitDoubtful.of(Subject::Heading));
    assert!(heading.action.contains("--unit heading=ddeg"), "{heading:?}");
    assert_eq!(time.kind(), ReasonCode::UnitDoubtful.of(Subject::Time));
    assert!(time.action.contains("--unit time="), "{time:?}");
}

#[test]
fn exact_a_course_in_place_of_the_heading_limits_the_model() {
    let course = StatedUnits { heading_is_course: true, ..stated_degrees() };
    let doubts = unit_doubts(&record(course));
    assert_eq!(doubts, [Doubt::HeadingIsCourse]);
    assert!(!doubts[0].refuses() && doubts[0].reason().limits());
}

#[test]
fn exact_a_rudder_without_scale_is_found() {
    let bare = |heading, per_si, largest: f64| {
        let units = StatedUnits {
            heading,
            rudder: unit(per_si, Origin::Assumed),
            ..StatedUnits::default()
        };
        let record = scaled(without_rate(record(units)), 1.0, largest / 0.26, 1.0);
        let refusals = refusals(&record);
        refusals.iter().map(Doubt::kind).collect::<Vec<_>>()
    };
    let stated = unit(1.0, Origin::Stated);
    let assumed = unit(1.0, Origin::Assumed);
    assert_eq!(bare(stated, 1.0, 0.5), [ReasonCode::UnitUnknown.of(Subject::Rudder)]);
    assert_eq!(bare(assumed, 1.0, 0.9), [ReasonCode::UnitUnknown.of(Subject::Rudder)]);
    assert_eq!(
        bare(unit(DEG, Origin::Assumed), 1.0, 0.5),
        [ReasonCode::UnitUnknown.of(Subject::Rudder)]
    );
    assert_eq!(
        bare(unit(DEG, Origin::Assumed), DEG, 60.0 / DEG),
        [ReasonCode::UnitUnknown.of(Subject::Rudder)]
    );
    assert_eq!(bare(unit(DEG, Origin::Assumed), DEG, 30.0 / DEG), []);
    let of_full_rudder = |per_si| {
        let mut record = without_rate(record(stated_degrees()));
        record.rudder_unit = RudderUnit::FullRudder;
        record.units.rudder = unit(per_si, Origin::Assumed);
        record
    };
    let pulses = of_full_rudder(400.0);
    assert_eq!(codes(&pulses), []);
    // Shares of two motors are used, and their unit is said to be assumed.
    let shares = of_full_rudder(1.0);
    assert_eq!(codes(&shares), [ReasonCode::UnitUnknown.of(Subject::Rudder)]);
    assert_eq!(refusals(&shares), []);
    assert_eq!(refusals(&of_full_rudder(100.0)).len(), 1);
}

/// One motor's throttle stays on one side; one that stops at neutral, and an angle, do not show it.
#[test]
fn exact_a_throttle_is_no_rudder() {
    let of = |from: f64, unit: RudderUnit| {
        let mut record = record(stated_degrees());
        record.rudder_unit = unit;
        record.units.rudder = ColumnUnit::default();
        for sample in &mut record.samples {
            sample.rudder_rad += 0.26 + from;
        }
        record
    };
    let refused = refusals(&of(0.1, RudderUnit::FullRudder));
    assert!(matches!(refused[..], [Doubt::RudderOfOneSide { .. }]), "{refused:?}");
    assert!(refused[0].text().contains("half the difference"));
    for record in [of(-0.01, RudderUnit::FullRudder), of(0.1, RudderUnit::Rad)] {
        assert_eq!(refusals(&record), []);
    }
}

#[test]
fn exact_a_yaw_rate_finds_the_unit_of_time() {
    let text = |time: f64| {
        let doubts = unit_doubts(&scaled(record(stated_degrees()), 1.0, 1.0, time));
        doubts.iter().map(Doubt::text).collect::<Vec<_>>().join("\n")
    };
    assert!(text(1000.0).contains("milliseconds"));
    assert!(text(1.0 / 60.0).contains("minutes"));
    let index = unit_doubts(&counting_rows(record(stated_degrees())));
    let index = index[0].text();
    assert!(index.contains("counts rows, each of some 0.05"), "{index}");
    let mut reversed = record(stated_degrees());
    for sample in &mut reversed.samples {
        sample.yaw_rate_rad_s = sample.yaw_rate_rad_s.map(|rate| -rate);
    }
    let doubts = unit_doubts(&reversed);
    assert_eq!(doubts[0].kind(), ReasonCode::SignReversed.of(Subject::YawRate));
    assert!(!doubts[0].refuses());
    leave_out_unsound(&mut reversed);
    assert!(reversed.samples.iter().all(|s| s.yaw_rate_rad_s.is_none()));
    assert_eq!(unit_doubts(&reversed)[0].kind(), ReasonCode::SignReversed.of(Subject::YawRate));
    let mut sound = record(stated_degrees());
    leave_out_unsound(&mut sound);
    assert!(sound.samples.iter().all(|s| s.yaw_rate_rad_s.is_some()));
}

#[test]
fn exact_hundredths_of_a_degree_are_no_radians() {
    for origin in [Origin::Given, Origin::Assumed, Origin::Stated] {
        let units = StatedUnits { heading: unit(100.0 * DEG, origin), ..stated_degrees() };
        assert_eq!(codes(&record(units)), [], "{origin:?}");
    }
}

#[test]
fn exact_dates_a_second_apart_count_no_rows() {
    let of = |time_is_a_date| {
        let units =
            StatedUnits { time: unit(1.0, Origin::Assumed), time_is_a_date, ..stated_degrees() };
        codes(&counting_rows(without_rate(record(units))))
    };
    assert_eq!(of(false), [ReasonCode::UnitDoubtful.of(Subject::Time)]);
    assert_eq!(of(true), []);
}

#[test]
fn exact_time_without_a_yaw_rate() {
    let at = |time: f64| codes(&scaled(without_rate(record(stated_degrees())), 1.0, 1.0, time));
    assert_eq!(at(1000.0), [ReasonCode::UnitDoubtful.of(Subject::Time)]);
    let mut index = counting_rows(without_rate(record(stated_degrees())));
    // Who says how long a row takes is believed; the name of a column is, with care.
    index.units.time.origin = Origin::Given;
    assert_eq!(codes(&index), []);
    index.units.time.origin = Origin::Stated;
    assert_eq!(codes(&index), [ReasonCode::Unchecked.of(Subject::Time)]);
    assert_eq!(refusals(&index), []);
    index.units.time.origin = Origin::Assumed;
    assert_eq!(refusals(&index), [Doubt::TimeIsIndex { is_stated: false }]);
}

/// A yaw rate of the other sense shows how long a row takes as well as one of the same.
#[test]
fn exact_a_reversed_yaw_rate_shows_the_time() {
    let mut units = stated_degrees();
    units.time.origin = Origin::Assumed;
    let mut log = record(units);
    for (row, sample) in log.samples.iter_mut().enumerate() {
        let time_s = row as f64;
        sample.heading_rad = 0.6 * (0.05 * time_s).sin();
        sample.yaw_rate_rad_s = Some(-0.03 * (0.05 * time_s).cos());
        sample.time_s = time_s;
    }
    leave_out_unsound(&mut log);
    assert!(log.units.yaw_rate_is_reversed);
    assert_eq!(refusals(&log), []);
}

/// Of time and heading the one is blamed whose unit nobody stated.
#[test]
fn exact_a_turn_too_fast_blames_the_unit_that_nobody_stated() {
    let mut units = stated_degrees();
    units.heading.origin = Origin::Assumed;
    let mils = |units| {
        let mut log = without_rate(record(units));
        for (row, sample) in log.samples.iter_mut().enumerate() {
            sample.heading_rad = (1.5 * 0.05 * row as f64 * 6400.0 / 360.0).rem_euclid(6.0);
        }
        unit_doubts(&log)[0].kind()
    };
    assert_eq!(mils(units), ReasonCode::UnitDoubtful.of(Subject::Heading));
    assert_eq!(mils(stated_degrees()), ReasonCode::UnitDoubtful.of(Subject::Time));
}

/// A column that a program made of the heading proves neither time nor heading.
#[test]
fn exact_a_yaw_rate_computed_from_the_heading_proves_nothing() {
    let noise = |row: usize| 0.002 * (977.0 * row as f64).sin();
    let mut computed = counting_rows(record(stated_degrees()));
    for (row, sample) in computed.samples.iter_mut().enumerate() {
        sample.heading_rad += noise(row);
    }
    let headings: Vec<f64> = computed.samples.iter().map(|s| s.heading_rad).collect();
    let last = headings.len() - 1;
    for (row, sample) in computed.samples.iter_mut().enumerate() {
        let (before, after) = (row.saturating_sub(1), (row + 1).min(last));
        let slope = (headings[after] - headings[before]) / (after - before) as f64;
        sample.yaw_rate_rad_s = Some(slope);
    }
    let mut gyro = computed.clone();
    leave_out_unsound(&mut computed);
    assert!(computed.units.yaw_rate_is_derived);
    assert!(computed.samples.iter().all(|s| s.yaw_rate_rad_s.is_none()));
    assert!(unit_doubts(&computed)[0].refuses());
    for (row, sample) in gyro.samples.iter_mut().enumerate() {
        sample.yaw_rate_rad_s = sample.yaw_rate_rad_s.map(|rate| rate + noise(3 * row + 1));
    }
    leave_out_unsound(&mut gyro);
    assert!(!gyro.units.yaw_rate_is_derived);
}

/// A time of whole numbers from 0 may count anything; one that begins elsewhere may be a time of day.
#[test]
fn exact_whole_times_from_0_without_a_unit_may_be_counts() {
    let at = |from_s: f64, origin| {
        let mut record = counting_rows(without_rate(record(stated_degrees())));
        record.units.time.origin = origin;
        for sample in &mut record.samples {
            sample.time_s = from_s + 2.0 * sample.time_s;
        }
        refusals(&record)
    };
    assert_eq!(at(0.0, Origin::Assumed).len(), 1);
    assert_eq!(at(0.0, Origin::Stated), []);
    assert_eq!(at(43_200.0, Origin::Assumed), []);
}

/// Whole numbers are degrees or counts; a unit, a yaw rate or a wrap at 360 tells.
#[test]
fn exact_whole_headings_without_a_unit_may_be_counts() {
    let whole = |from_deg: f64, origin| {
        let mut units = stated_degrees();
        units.heading.origin = origin;
        let mut record = without_rate(record(units));
        for sample in &mut record.samples {
            let turned = Real::wrapped(sample.heading_rad).to_degrees();
            sample.heading_rad = (turned + from_deg).round().rem_euclid(360.0).to_radians();
        }
        record
    };
    let doubtful = [ReasonCode::UnitDoubtful.of(Subject::Heading)];
    assert_eq!(codes(&whole(100.0, Origin::Assumed)), doubtful);
    assert!(unit_doubts(&whole(100.0, Origin::Assumed))[0].refuses());
    assert_eq!(codes(&whole(100.0, Origin::Stated)), []);
    assert_eq!(codes(&whole(0.0, Origin::Assumed)), []);
    assert_eq!(codes(&whole(280.0, Origin::Assumed)), doubtful);
}

/// Counts without a unit are no milliseconds because they look like it.
#[test]
fn exact_an_assumed_unit_of_time_is_refused_without_a_witness() {
    let mut units = stated_degrees();
    units.time = unit(1000.0, Origin::Assumed);
    let bare = without_rate(record(units));
    assert_eq!(codes(&bare), [ReasonCode::UnitDoubtful.of(Subject::Time)]);
    assert!(unit_doubts(&bare)[0].refuses());
    assert_eq!(codes(&record(units)), []);
    // Ten a tenth of a second: hundredths come first.
    let advice = unit_doubts(&bare)[0].reason().action;
    let first = advice.find("--unit time=");
    assert!(first.is_some_and(|at| advice[at..].starts_with("--unit time=ms")), "{advice}");
    let mut hundredths = bare;
    for sample in &mut hundredths.samples {
        sample.time_s /= 5.0;
    }
    let advice = unit_doubts(&hundredths)[0].reason().action;
    assert!(advice.starts_with("Say --unit time=cs"), "{advice}");
    // A gyro in a unit that is stated shows them.
    let mut units_of_gyro = units;
    units_of_gyro.yaw_rate.origin = Origin::Stated;
    let mut with_gyro = record(units_of_gyro);
    for sample in &mut with_gyro.samples {
        sample.time_s /= 10.0;
    }
    let advice = unit_doubts(&with_gyro)[0].reason().action;
    assert!(advice.contains("--unit time=cs") && !advice.contains("heading"), "{advice}");
    // A yaw rate whose unit was chosen because it is the nearest of three is no witness of a wrong time.
    units.yaw_rate.origin = Origin::Assumed;
    let mut scaled = record(units);
    for sample in &mut scaled.samples {
        sample.yaw_rate_rad_s = sample.yaw_rate_rad_s.map(|rate| rate / 0.6);
    }
    assert!(!refusals(&scaled).is_empty());
}

/// More than all of the rudder, and a unit of another kind than the name of the column says.
#[test]
fn exact_a_chosen_unit_of_the_rudder_is_doubted() {
    let mut shares = record(stated_degrees());
    shares.rudder_unit = RudderUnit::FullRudder;
    shares.units.rudder = unit(1.0, Origin::Given);
    assert_eq!(codes(&shares), []);
    for sample in &mut shares.samples {
        sample.rudder_rad *= 100.0;
    }
    assert_eq!(codes(&shares), [ReasonCode::UnitDoubtful.of(Subject::Rudder)]);
    assert!(unit_doubts(&shares)[0].refuses());
    let mut named = record(stated_degrees());
    named.units.rudder.is_against_name = true;
    assert_eq!(codes(&named), [ReasonCode::UnitDoubtful.of(Subject::Rudder)]);
    assert!(!unit_doubts(&named)[0].refuses());
}

/// The record above with the heading of every n-th row until the next, and noise in heading and rudder.
fn held(heading_rows: usize, rudder_rows: usize) -> Vec<Sample<f64>> {
    let record = record(StatedUnits::default());
    let noise = |row: usize| 0.002 * (977.0 * row as f64).sin();
    (0..record.samples.len())
        .map(|row| {
            let (heading, rudder) =
                (row / heading_rows * heading_rows, row / rudder_rows * rudder_rows);
            Sample {
                heading_rad: (record.samples[heading].heading_rad + noise(heading)).wrapped(),
                rudder_rad: record.samples[rudder].rudder_rad + noise(rudder),
                ..record.samples[row]
            }
        })
        .collect()
}

#[test]
fn exact_slow_and_held_channels_are_found() {
    assert_eq!(timing_doubts(&held(1, 1), -1.0), []);
    assert_eq!(timing_doubts(&held(1, 1), 0.1), []);
    let [Doubt::HeadingHeld { refresh_s, effect }] = timing_doubts(&held(4, 1), -1.0)[..] else {
        panic!("{:?}", timing_doubts(&held(4, 1), -1.0));
    };
    // A reading in four that happens to equal the next is rare.
    assert!((refresh_s - 0.2).abs() < 0.01 && (effect - 0.15).abs() < 0.01);
    let [Doubt::RudderHeld { refresh_s, .. }] = timing_doubts(&held(1, 20), -1.0)[..] else {
        panic!("{:?}", timing_doubts(&held(1, 20), -1.0));
    };
    assert!((refresh_s - 1.0).abs() < 1e-9);
}

#[test]
fn exact_steps_of_a_coarse_compass_are_not_held() {
    let mut samples = held(1, 1);
    for sample in &mut samples {
        sample.heading_rad = (sample.heading_rad / 0.0087).round() * 0.0087;
    }
    assert_eq!(timing_doubts(&samples, -1.0), []);
}

#[test]
fn exact_a_clock_that_jumped_differs_from_lost_rows() {
    let codes = |samples: &[Sample<f64>]| -> Vec<ReasonKind> {
        let doubts = timing_doubts(samples, -1.0);
        doubts.iter().map(Doubt::kind).collect()
    };
    // At full yaw rate.
    let mut jumped = held(1, 1);
    for sample in jumped.iter_mut().skip(251) {
        sample.time_s += 1.0;
    }
    assert_eq!(codes(&jumped), [ReasonCode::ClockJumped.into()]);
    // Of no account to a ship whose time constant is 20 s.
    assert_eq!(timing_doubts(&jumped, -0.05), []);
    let mut lost = held(1, 1);
    lost.drain(251..271);
    assert_eq!(codes(&lost), []);
    // Where the vehicle does not turn a jump does not show.
    let mut at_rest = held(1, 1);
    for sample in at_rest.iter_mut().skip(63) {
        sample.time_s += 1.0;
    }
    assert_eq!(codes(&at_rest), []);
}

#[test]
fn exact_times_that_are_shared_matter_to_a_fast_vehicle() {
    let samples: Vec<Sample<f64>> = held(1, 1).into_iter().step_by(2).collect();
    let doubt = shared_times(&samples, -1.0).unwrap();
    assert_eq!(doubt.kind(), ReasonCode::SampledTooSeldom.of(Subject::Time));
    assert!(doubt.refuses());
    assert_eq!(shared_times(&samples, -0.1), None);
}

#[test]
fn exact_a_heading_of_half_a_turn_is_named() {
    let mut record = without_rate(record(stated_degrees()));
    for sample in &mut record.samples {
        let turned_deg = 3.0 * Real::wrapped(sample.heading_rad).to_degrees();
        sample.heading_rad = turned_deg.rem_euclid(180.0).to_radians();
    }
    assert_eq!(unit_doubts(&record)[0], Doubt::HeadingHalfTurn);
    assert!(unit_doubts(&record)[0].refuses());
    record.samples.truncate(40);
    record.samples[20].heading_rad = 175_f64.to_radians();
    assert!(!unit_doubts(&record).contains(&Doubt::HeadingHalfTurn));
}
