//! Names, units and times as loggers write them.

use std::f64::consts::PI;

use seatrial_core::RudderUnit;
use seatrial_core::Sample;
use seatrial_logs::{
    ChannelChoice, Counts, Fault, LogDescription, Quantity, ReadError, Unit, UnitSource, open,
};

struct Read {
    samples: Vec<Sample<f64>>,
    description: LogDescription,
    counts: Counts,
    warnings: Vec<String>,
}

fn read_with(text: impl AsRef<[u8]>, choice: &ChannelChoice) -> Result<Read, ReadError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.csv");
    std::fs::write(&path, text).unwrap();
    let mut reader = open(&path, choice)?;
    let samples = reader.by_ref().collect::<Result<_, _>>()?;
    Ok(Read {
        samples,
        description: reader.description().clone(),
        counts: reader.counts(),
        warnings: [reader.description().warnings.clone(), reader.warnings()].concat(),
    })
}

fn read(text: impl AsRef<[u8]>) -> Read {
    read_with(text, &ChannelChoice::default()).unwrap()
}

fn fault(text: impl AsRef<[u8]>) -> Fault {
    match read_with(text, &ChannelChoice::default()) {
        Ok(_) => panic!("was read"),
        Err(error) => error.fault,
    }
}

fn unit(read: &Read, quantity: Quantity) -> (Unit, UnitSource) {
    let channel = read.description.channels.iter().find(|c| c.quantity == quantity);
    channel.map(|c| (c.unit, c.unit_source)).unwrap()
}

fn times(read: &Read) -> Vec<f64> {
    read.samples.iter().map(|s| s.time_s).collect()
}

/// One conversion in double precision.
fn assert_close(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-12, "{found} is not {expected}");
}

#[test]
fn io_delimiters_comments_quotes_and_line_ends_do_not_matter() {
    for text in [
        "t,yaw,rudder\n0,0.5,0.25\n0.5,0.75,-0.25\n",
        "\u{feff}t,yaw,rudder\r\n0,0.5,0.25\r\n0.5,0.75,-0.25\r\n",
        "t;yaw;rudder\n0;0,5;0,25\n0,5;0,75;-0,25\n",
        "t\tyaw\trudder\n0\t0.5\t0.25\n\n0.5\t0.75\t-0.25",
        "# made by a logger\n t   yaw  rudder\n 0   5e-1 0.25\n# pause\n 0.5 .75\t-0.25\n",
        "# t yaw rudder\n0 0.5 0.25\n0.5 0.75 -0.25\n",
        "\"t\",\"yaw\",\"rudder\",\n\"0\",\"0.5\",\"0.25\",\n0.5, 0.75 ,-0.25,\n",
    ] {
        let samples = read(text).samples;
        let expected = [(0.0, 0.5, 0.25), (0.5, 0.75, -0.25)];
        let found: Vec<_> =
            samples.iter().map(|s| (s.time_s, s.heading_rad, s.rudder_rad)).collect();
        assert_eq!(found, expected, "{text:?}");
    }
}

#[test]
fn io_stated_units_are_converted() {
    let read = read(
        "time [ms],Heading (\u{b0}),rudder_pct,speed [kn],gyro_z [deg/s],depth_ft\n\
         1000,180,50,10,90,10\n1050,181,-50,10,90,10\n",
    );
    let sample = read.samples[0];
    assert_eq!(times(&read), [1.0, 1.05]);
    assert_close(sample.heading_rad, PI);
    assert_close(sample.rudder_rad, 0.5);
    assert_close(sample.surge_speed_m_s.unwrap(), 10.0 * 1852.0 / 3600.0);
    assert_close(sample.yaw_rate_rad_s.unwrap(), PI / 2.0);
    assert_close(sample.depth_m.unwrap(), 3.048);
    // Percent of an angle that nobody gave.
    assert!(read.warnings.iter().any(|w| w.contains("--rudder-range-deg")));
}

#[test]
fn io_a_date_states_its_unit() {
    let read = read(
        "UTC,heading_deg,rudder_deg\n2026-09-14T08:00:00Z,180,10\n2026-09-14T08:00:01Z,181,10\n",
    );
    assert_eq!(times(&read), [0.0, 1.0]);
    assert_eq!(unit(&read, Quantity::Time), (Unit::Second, UnitSource::Stated));
}

#[test]
fn io_header_in_latin_1_is_understood() {
    let read = read(b"t,Heading (\xb0),rudder_deg\n0,180,10\n1,181,10\n");
    assert_close(read.samples[0].heading_rad, PI);
}

#[test]
fn io_degrees_without_a_unit_are_seen_and_said() {
    let read = read("t,heading,rudder\n0,350,15\n1,359,-15\n2,4,-15\n");
    assert_eq!(unit(&read, Quantity::Heading), (Unit::Degree, UnitSource::Assumed));
    assert_eq!(unit(&read, Quantity::Rudder), (Unit::Degree, UnitSource::Assumed));
    assert_close(read.samples[0].rudder_rad, PI / 12.0);
    assert_eq!(read.warnings.len(), 2, "{:?}", read.warnings);
    // Small headings in degrees: the rudder vouches for them.
    let read = self::read("t,heading,rudder\n0,0,15\n1,2,-15\n2,4,-15\n");
    assert_eq!(unit(&read, Quantity::Heading).0, Unit::Degree);
}

#[test]
fn io_degrees_given_as_radians_are_warned_of() {
    let read = read("time_s,heading_rad,rudder_rad\n0,350,15\n1,10,-15\n2,14,-15\n");
    assert_eq!(unit(&read, Quantity::Heading), (Unit::Radian, UnitSource::Stated));
    assert!(read.warnings.iter().any(|w| w.contains("--unit heading=deg")), "{:?}", read.warnings);
    assert!(read.warnings.iter().any(|w| w.contains("--unit rudder=deg")), "{:?}", read.warnings);
}

#[test]
fn io_degrees_that_come_after_the_look_ahead_are_refused() {
    let mut text = String::from("t,yaw,rudder\n");
    for k in 0..20_500 {
        let rudder = if k < 20_400 { 0.0 } else { 20.0 };
        text += &format!("{},0.1,{rudder}\n", f64::from(k) * 0.05);
    }
    match fault(&text) {
        Fault::UnitContradicted { found, .. } => assert_eq!(found, 20.0),
        other => panic!("{other}"),
    }
}

#[test]
fn io_yaw_rate_has_the_unit_that_integrates_to_the_heading() {
    for (scale, expected) in
        [(1.0, Unit::RadianPerSecond), (1_f64.to_degrees(), Unit::DegreePerSecond)]
    {
        let mut text = String::from("t,yaw,rudder,r\n");
        for k in 0..400 {
            let t = f64::from(k) * 0.05;
            let rate = 0.1 * (0.5 * t).cos() * scale;
            text += &format!("{t},{},{},{rate}\n", 0.2 * (0.5 * t).sin(), 0.2 * (0.5 * t).cos());
        }
        assert_eq!(unit(&read(text), Quantity::YawRate).0, expected);
    }
}

/// One motor of two by itself gives a model of half the steering.
#[test]
fn io_half_the_difference_of_two_motors_is_the_rudder_where_nothing_else_is() {
    let rows = "0,0.1,1400,1600\n1,0.2,1300,1700\n";
    for names in ["right_motor_pwm,left_motor_pwm", "starboard_pwm,port_pwm"] {
        let read = read(format!("t,yaw,{names}\n{rows}"));
        let (unit, _) = unit(&read, Quantity::Rudder);
        assert_eq!(unit, Unit::PulseWidth);
        assert_close(read.samples[0].rudder_rad, 100.0 / 400.0);
    }
    let shares = read("t,yaw,thruster_left,thruster_right\n0,0.1,0.5,0.1\n1,0.2,0.1,0.5\n");
    assert_eq!(unit(&shares, Quantity::Rudder).0, Unit::Fraction);
    assert_close(shares.samples[0].rudder_rad, 0.2);
}

/// Fins may turn with each other, and of two pairs of motors nobody knows which steers.
#[test]
fn io_two_columns_that_may_not_turn_against_each_other_are_not_taken_together() {
    let told = "--rudder 'left_fin_pwm,right_fin_pwm'";
    for (names, says) in [
        ("left_fin_pwm,right_fin_pwm", told),
        ("left_motor,right_motor,left_prop", "no column for rudder"),
    ] {
        let text = format!("t,yaw,{names}\n0,0.1,1600,1400,1500\n1,0.2,1700,1300,1500\n");
        let fault = read_with(&text, &ChannelChoice::default());
        let text = fault.err().unwrap().to_string();
        assert!(text.contains(says), "{text}");
    }
}

/// A compass that jumped is left out by the option, and the gyro is no witness of itself.
#[test]
fn io_a_yaw_rate_that_is_chosen_for_the_heading_is_integrated() {
    let text = "t,heading_deg,rudder_deg,yaw_rate_deg_s\n0,10,0,2\n1,12,1,2\n2,90,2,4\n";
    let mut choice = ChannelChoice::default();
    choice.columns.insert(Quantity::Heading, "yaw_rate_deg_s".into());
    let read = read_with(text, &choice).unwrap();
    assert_eq!(unit(&read, Quantity::Heading).0, Unit::DegreePerSecond);
    let headings = read.samples.iter().map(|s| s.heading_rad.to_degrees());
    for (found, expected) in headings.zip([0.0, 2.0, 5.0]) {
        assert_close(found, expected);
    }
    assert!(read.samples.iter().all(|s| s.yaw_rate_rad_s.is_none()));
}

#[test]
fn io_pwm_is_centred_and_scaled_to_the_angle_given() {
    let text = "t,yaw,servo\n0,0.1,1500\n1,0.2,1900\n2,0.3,1100\n";
    let mut choice = ChannelChoice::default();
    choice.full_rudder_rad = Some(0.5);
    choice.rudder_trim = Some(1480.0);
    let read = read_with(text, &choice).unwrap();
    assert_eq!(unit(&read, Quantity::Rudder), (Unit::PulseWidth, UnitSource::Assumed));
    assert_close(read.samples[1].rudder_rad, 0.5 * 420.0 / 400.0);
}

#[test]
fn io_times_become_seconds() {
    let log = |times: [&str; 3], name: &str| {
        let rows: String = times.iter().map(|t| format!("{t},0.1,0.2\n")).collect();
        read(format!("{name},yaw,rudder\n{rows}"))
    };
    for (name, row, start) in [
        ("t", ["10", "10.05", "10.1"], None),
        ("time_ms", ["10000", "10050", "10100"], None),
        ("TimeUS", ["10000000", "10050000", "10100000"], None),
        ("t", ["10000", "10050", "10100"], None),
        ("t", ["10000000", "10050000", "10100000"], None),
    ] {
        let read = log(row, name);
        assert_eq!(times(&read), [10.0, 10.05, 10.1], "{name}");
        assert_eq!(read.description.start_utc, start);
    }
    for (name, row) in [
        ("timestamp", ["1700000000.00", "1700000000.25", "1700000000.50"]),
        ("timestamp", ["1700000000000", "1700000000250", "1700000000500"]),
        ("stamp_ns", ["1700000000000000000", "1700000000250000000", "1700000000500000000"]),
        ("utc", ["2023-11-14T22:13:20Z", "2023-11-14T22:13:20.25Z", "2023-11-14T23:13:20.5+01:00"]),
        ("time", ["2023-11-14 22:13:20", "2023-11-14 22:13:20.25", "2023-11-14 22:13:20.5"]),
    ] {
        let read = log(row, name);
        for (found, expected) in times(&read).iter().zip([0.0, 0.25, 0.5]) {
            // An epoch in nanoseconds is a multiple of 256 in double precision.
            assert!((found - expected).abs() < 2.56e-7, "{name}: {found}");
        }
        let start = read.description.start_utc.unwrap();
        assert_eq!(start, "2023-11-14T22:13:20Z");
    }
}

#[test]
fn io_faults_name_place_column_and_value() {
    let numbers = |fault: Fault| fault.to_string();
    assert!(matches!(fault(""), Fault::Empty));
    assert!(matches!(fault("# only a comment\n\n"), Fault::Empty));
    assert!(matches!(fault("t,yaw,rudder\n"), Fault::HeaderOnly));
    assert!(matches!(fault("0,1,2\n1,1,2\n"), Fault::NoHeader { line: 1, .. }));
    assert!(matches!(fault([0_u8, 1, 2, 3]), Fault::NotText { offset: 0, .. }));
    for (text, expected) in [
        (
            "t,yaw,rudder\n0,0,0.1\n1,abc,0\n",
            "line 3, column `yaw`: found \"abc\", expected a number",
        ),
        ("t,yaw,rudder\r\n0,0,0.1\r\n1,0,inf\r\n", "line 3, column `rudder`: found inf"),
        (
            "t,yaw,rudder\n# x\n\n1,0,0.1\n0.5,0,0\n",
            "line 5, column `t`: time goes back from 1 s to 0.5 s",
        ),
        ("t,yaw,rudder\n0,0,0.1,9\n", "line 2: found 4 cells, expected 3"),
        ("t,yaw,ruddle\n0,0,0.1\n", "did you mean `ruddle`?"),
        ("t,yaw,heading,rudder\n0,0,0,0.1\n", "`yaw`, `heading`; say which with --heading NAME"),
        (
            "t,yaw [furlong],rudder\n0,0,0.1\n",
            "`furlong` does not fit heading; expected one of rad, deg",
        ),
        ("t,yaw,rudder\n0,0,5000\n", "reaches 5000"),
        ("t,yaw,rudder\n,0,1\n,0,1\n", "no usable sample"),
    ] {
        let found = numbers(fault(text));
        assert!(found.contains(expected), "{found}");
    }
}

#[test]
fn io_invalid_rows_are_left_out_when_asked_and_counted() {
    let text = "t,yaw,rudder,depth\n0,0,0.1,\n1,abc,0,2\n2,NaN,0,2\n3,0,,2\n4,0,0.1,nan\n4,0,0.1,2\n\
                3,0,0.1,2\n5,0\n6,0,0.1,2\n7,0";
    let mut choice = ChannelChoice::default();
    choice.drop_invalid = true;
    let read = read_with(text, &choice).unwrap();
    assert_eq!(times(&read), [0.0, 4.0, 6.0]);
    let depths: Vec<_> = read.samples.iter().map(|s| s.depth_m).collect();
    assert_eq!(depths, [None, None, Some(2.0)]);
    let expected = Counts {
        rows: 9,
        samples: 3,
        missing: 1,
        invalid: 3,
        repeated_time: 1,
        differing_at_a_time: 0,
        reversed_time: 1,
        is_damaged: false,
    };
    assert_eq!(read.counts, expected);
    // One for each cause and one for the last line, which is cut off.
    assert_eq!(read.warnings.len(), 5, "{:?}", read.warnings);
}

#[test]
fn io_choices_override_names() {
    let text =
        "t,yaw,heading,rudder,fin_cmd,speed,roll\n0,0.5,90,0.1,10,fast,1\n1,0.5,91,0.1,20,fast,1\n";
    let mut choice = ChannelChoice::default();
    choice.columns = [
        (Quantity::Heading, "HEADING".to_string()),
        (Quantity::Rudder, "fin_cmd".to_string()),
        (Quantity::Roll, "none".to_string()),
    ]
    .into();
    choice.units = [(Quantity::Heading, Unit::Degree), (Quantity::Rudder, Unit::Degree)].into();
    let read = read_with(text, &choice).unwrap();
    assert_close(read.samples[0].heading_rad, PI / 2.0);
    assert_close(read.samples[1].rudder_rad, PI / 9.0);
    assert_eq!(read.samples[0].roll_rad, None);
    // The speed is text: said, and left out.
    assert_eq!(read.samples[0].surge_speed_m_s, None);
    assert!(read.warnings.iter().any(|w| w.contains("`speed` is text")), "{:?}", read.warnings);
    assert_eq!(unit(&read, Quantity::Heading), (Unit::Degree, UnitSource::Chosen));
}

#[test]
fn io_the_description_says_what_the_rudder_is_measured_in() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.csv");
    let mut full = ChannelChoice::default();
    full.full_rudder_rad = Some(0.5);
    for (column, choice, expected, rudder) in [
        ("rudder_deg", ChannelChoice::default(), RudderUnit::Rad, 20_f64.to_radians()),
        ("rudder_pct", ChannelChoice::default(), RudderUnit::FullRudder, 0.2),
        ("rudder_pct", full, RudderUnit::Rad, 0.1),
    ] {
        std::fs::write(&path, format!("t,heading_deg,{column}\n0,180,20\n1,181,-20\n")).unwrap();
        let mut log = open(&path, &choice).unwrap();
        assert_eq!(log.description().rudder_unit, expected, "{column}");
        assert_close(log.next().unwrap().unwrap().rudder_rad, rudder);
    }
}
