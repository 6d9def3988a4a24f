//! Logs as vehicles write them: every number as the formats' own Python libraries read it, every channel found.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use seatrial_core::Sample;
use seatrial_dev::data;
use seatrial_logs::{ChannelChoice, Fault, LogReader, Quantity, Unit, open};

fn samples(reader: &mut LogReader) -> Vec<Sample<f64>> {
    reader.collect::<Result<_, _>>().unwrap()
}

/// A field of every message, through the channel of the heading: `unit=rad` leaves numbers as they are.
fn values(path: &Path, column: &str) -> Vec<f64> {
    let of_both = |to: &str| {
        BTreeMap::from([Quantity::Heading, Quantity::Rudder].map(|q| (q, to.to_string())))
    };
    let units = BTreeMap::from([Quantity::Heading, Quantity::Rudder].map(|q| (q, Unit::Radian)));
    let mut choice = ChannelChoice::default();
    choice.columns = of_both(column);
    choice.units = units;
    let mut reader = open(path, &choice).unwrap();
    samples(&mut reader)
        .iter()
        .map(|sample| {
            assert_eq!(sample.rudder_rad, sample.heading_rad);
            sample.heading_rad
        })
        .collect()
}

/// Count, sum and sum of k / count value_k of a column, by pymavlink, pyulog, nmea2000 and dbdreader. That every
/// number of every message is theirs is `val_every_number_is_that_of_the_python_libraries`; here they come
/// all the way through the table.
#[test]
fn val_columns_carry_the_numbers_of_the_libraries() {
    for (file, column, count, sum, weighted) in [
        ("ardupilot/ardusub_small.BIN", "ATT.Yaw", 237, 50693.98000000012, 25453.141561181426),
        ("ardupilot/ardusub_small.BIN", "IMU.GyrZ", 594, 1.028530366736959, 0.5168973232638646),
        (
            "ardupilot/rover_json_physics.tlog",
            "ATTITUDE.yaw",
            7569,
            6651.431646175886,
            5218.477962474379,
        ),
        (
            "ardupilot/rover_json_physics.tlog",
            "SERVO_OUTPUT_RAW.servo1_raw",
            7569,
            11362500.0,
            5677739.199365835,
        ),
        (
            "px4/quad_sample.ulg",
            "vehicle_attitude.q[3]",
            6461,
            -1948.7574253082275,
            -979.9792356768419,
        ),
        ("px4/quad_v4pro_appended.ulg", "actuator_outputs.1.output[0]", 96, 144000.0, 72750.0),
        (
            "nmea2000/ac42-commissioning.raw",
            "vessel_heading.52.heading_rad",
            5888,
            23881.55839999999,
            11956.776424252748,
        ),
        (
            "nmea2000/triton-engine-setup.all",
            "speed.35.speed_water_m_s",
            130,
            430.2300000000001,
            224.92853846153847,
        ),
        (
            "slocum/amadeus-2014-204-05-000.dbd",
            "m_heading",
            898,
            1165.8607430364937,
            544.3060990429877,
        ),
        ("slocum/amadeus-2014-204-05-000.dbd", "m_fin", 898, 60.48156842030585, 29.625606833387778),
    ] {
        let Some(path) = data(&format!("native/{file}")) else {
            return;
        };
        let values = values(&path, column);
        assert_eq!(values.len(), count, "{file} {column}");
        // Sums of up to 10^4 doubles of one size differ by rounding alone, in whatever order.
        let tolerance = 1e-12 * values.iter().map(|value| value.abs()).sum::<f64>();
        let found: f64 = values.iter().sum();
        assert!((found - sum).abs() <= tolerance, "{file} {column}: {found}");
        let ranks = (1..=count).map(|k| k as f64 / count as f64);
        let found: f64 = values.iter().zip(ranks).map(|(v, rank)| v * rank).sum();
        assert!((found - weighted).abs() <= tolerance, "{file} {column}: weighted {found}");
    }
}

/// A copy's times: 23,795 messages in 57 ms are more than the bus carries.
#[test]
fn io_a_capture_with_collapsed_times_is_refused() {
    let Some(path) = data("native/nmea2000/raymarine-ev1.raw") else {
        return;
    };
    let refused = open(&path, &ChannelChoice::default());
    let fault = refused.err().unwrap().fault;
    assert!(matches!(fault, Fault::TimeCollapsed { messages: 23_795, .. }), "{fault}");
}

/// Without its list of sensors a glider's log says which file is missing.
#[test]
fn io_a_glider_log_without_its_cache_file_names_it() {
    let Some(path) = data("native/slocum/amadeus-2014-204-05-000.dbd") else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let alone = folder.path().join("log");
    std::fs::copy(path, &alone).unwrap();
    let refused = open(&alone, &ChannelChoice::default());
    let message = refused.err().unwrap().to_string();
    assert!(message.contains("468fd1be.cac"), "{message}");
}

/// The list of sensors may stand in the log itself, those that are not logged among them.
#[test]
fn io_a_glider_log_with_its_own_list_of_sensors_reads_alike() {
    let Some(path) = data("native/slocum/amadeus-2014-204-05-000.dbd") else {
        return;
    };
    let read = |path: &Path| samples(&mut open(path, &ChannelChoice::default()).unwrap());
    let log = std::fs::read(&path).unwrap();
    let list = std::fs::read_to_string(path.with_file_name("cac").join("468fd1be.cac")).unwrap();
    let head = log.windows(4).position(|bytes| bytes == *b"sa\x124");
    let (head, cycles) = log.split_at(head.unwrap());
    let head = String::from_utf8(head.to_vec()).unwrap();
    let mut whole = head.replace("sensor_list_factored:    1", "sensor_list_factored:    0");
    whole += &list;
    whole += "s: F 2027 -1 4 c_not_logged nodim\n";
    let mut whole = whole.into_bytes();
    whole.extend(cycles);
    let folder = tempfile::tempdir().unwrap();
    let alone = folder.path().join("log.dbd");
    std::fs::write(&alone, whole).unwrap();
    assert_eq!(read(&alone), read(&path));
}

fn column(reader: &LogReader, quantity: Quantity) -> Option<(&str, Unit)> {
    let channels = &reader.description().channels;
    channels
        .iter()
        .find(|channel| channel.quantity == quantity)
        .map(|channel| (channel.column.as_str(), channel.unit))
}

#[test]
fn io_the_steering_output_is_found() {
    let servo = "SERVO_OUTPUT_RAW.steering_fraction";
    let pilot = "RC_CHANNELS.steering_fraction";
    let controls = "actuator_controls_0.control[2]";
    for (file, expected) in [
        ("ardupilot/arduplane_pixhawk_64k.BIN", "RCOU.steering_fraction"),
        ("ardupilot/arducopter_pixhawk4_80k.BIN", "RATE.YOut"),
        ("ardupilot/ardusub_small.BIN", "RATE.YOut"),
        ("ardupilot/ardusub_small.tlog", pilot),
        ("ardupilot/ardusub_2023-04-18.tlog", pilot),
        ("ardupilot/sub_manual.tlog", pilot),
        ("ardupilot/rover_json_physics.tlog", servo),
        ("ardupilot/rover_motorboat_50hz_loop.tlog", servo),
        ("px4/fixedwing_fmuv6c.ulg", "vehicle_torque_setpoint.xyz[2]"),
        ("px4/quad_sample.ulg", controls),
        ("px4/quad_v4pro_appended.ulg", controls),
        ("px4/vtol_cubeorange.ulg", controls),
    ] {
        let Some(path) = data(&format!("native/{file}")) else {
            return;
        };
        let mut reader = open(&path, &ChannelChoice::default()).unwrap();
        let found = column(&reader, Quantity::Rudder);
        assert_eq!(found, Some((expected, Unit::Fraction)), "{file}");
        let samples = samples(&mut reader);
        assert!(samples.iter().all(|s| s.rudder_rad.abs() <= 1.0), "{file}");
        assert!(samples.iter().any(|s| s.yaw_rate_rad_s.is_some()), "{file}");
    }
}

/// SERVO4 of the plane: FUNCTION 21, MIN 1100, TRIM 1200, MAX 1900, REVERSED 1; its first pulse is 1506 us.
#[test]
fn exact_pulses_are_normalised_by_the_parameters_of_their_output() {
    let Some(path) = data("native/ardupilot/arduplane_pixhawk_64k.BIN") else {
        return;
    };
    let fractions = values(&path, "RCOU.steering_fraction");
    assert_eq!(fractions[0], -(1506.0 - 1200.0) / (1900.0 - 1200.0));
}

/// The doublet of `fit_1680`: 1723 us from 87.603047 s on, 1277 us from 89.603047 s, 1500 us from 91.603047 s.
#[test]
fn exact_the_rudder_of_a_sample_acts_from_its_time_until_the_next() {
    let Some(path) = data("native/ardupilot/rover_json_physics.tlog") else {
        return;
    };
    let mut reader = open(&path, &ChannelChoice::default()).unwrap();
    let samples = samples(&mut reader);
    let at = |time_s: f64| {
        let index = samples.partition_point(|s| s.time_s < time_s - 1e-6);
        assert!((samples[index].time_s - time_s).abs() < 1e-6);
        samples[index].rudder_rad
    };
    // RC_CHANNELS_SCALED says 0.4466 of full; whole pulses make it uncertain by 1 in 159.
    let laid = at(87.623);
    assert!((laid - 0.4466).abs() < 0.4466 / 159.0);
    // The boot clock of ATTITUDE is cut to whole ms: for 0.047 ms of 20 the rudder was still where it was.
    let before = 0.047 / 20.0;
    for (time_s, expected) in [
        (87.583, 0.0),
        (87.603, laid * (1.0 - before)),
        (89.603, laid * (2.0 * before - 1.0)),
        (89.623, -laid),
        (91.603, laid * -before),
        (91.623, 0.0),
    ] {
        // Times are doubles of some 100 s.
        assert!((at(time_s) - expected).abs() < 1e-9, "{time_s}: {}", at(time_s));
    }
}

/// Boot clock and arrival are kept apart: both can be the time, and the ground station's jitters.
#[test]
fn io_arrival_is_a_time_of_its_own() {
    let Some(path) = data("native/ardupilot/rover_json_physics.tlog") else {
        return;
    };
    let intervals = |choice: &ChannelChoice| -> Vec<f64> {
        let samples = samples(&mut open(&path, choice).unwrap());
        samples.windows(2).map(|p| p[1].time_s - p[0].time_s).collect()
    };
    let boot = intervals(&ChannelChoice::default());
    let mut by_arrival = ChannelChoice::default();
    by_arrival.columns = BTreeMap::from([(Quantity::Time, "ATTITUDE.arrival_us".to_string())]);
    by_arrival.units = BTreeMap::from([(Quantity::Time, Unit::Microsecond)]);
    let arrival = intervals(&by_arrival);
    let regular = |all: &[f64]| all.iter().filter(|dt| (**dt - 0.02).abs() < 1e-6).count();
    assert!(regular(&boot) > boot.len() * 99 / 100);
    assert!(regular(&arrival) < arrival.len() / 100);
}

/// Logs in all folders of the shared data, but for the lists of sensors.
fn all_native() -> Vec<PathBuf> {
    let folders = ["ardupilot", "px4", "nmea2000", "slocum"];
    let files = folders.iter().filter_map(|folder| data(&format!("native/{folder}")));
    let files = files.flat_map(|folder| std::fs::read_dir(folder).unwrap());
    let mut files: Vec<PathBuf> = files.map(|entry| entry.unwrap().path()).collect();
    files.retain(|path| path.is_file() && path.extension().is_none_or(|suffix| suffix != "csv"));
    files.sort();
    files
}

/// Without its path.
fn refusal(error: &seatrial_logs::ReadError) -> String {
    error.fault.to_string()
}

/// Times and headings, or why there are none.
fn headings(path: &Path) -> Result<(Vec<[f64; 2]>, Vec<String>), String> {
    let heading_alone = |column: &str| {
        let both = [Quantity::Heading, Quantity::Rudder];
        let mut choice = ChannelChoice::default();
        choice.columns = BTreeMap::from(both.map(|q| (q, column.into())));
        choice.units = BTreeMap::from(both.map(|q| (q, Unit::Radian)));
        choice.drop_invalid = true;
        choice
    };
    // Whatever a cut leaves of the parameters: the heading is always there.
    let mut found = Err(String::new());
    for column in [
        "ATT.Yaw",
        "ATTITUDE.yaw",
        "vehicle_attitude.yaw",
        "vessel_heading.52.heading_rad",
        "attitude.52.yaw_rad",
        "m_heading",
    ] {
        match open(path, &heading_alone(column)) {
            Ok(mut reader) => {
                let samples = reader.by_ref().map_while(Result::ok);
                let samples = samples.map(|s| [s.time_s, s.heading_rad]).collect();
                return Ok((samples, reader.warnings()));
            }
            Err(error) if found.is_ok() || !matches!(error.fault, Fault::NoSuchColumn { .. }) => {
                return Err(refusal(&error));
            }
            Err(error) => found = Err(refusal(&error)),
        }
    }
    found
}

/// Every log is read or refused with a reason; cut, it gives the same up to there and says so.
#[test]
fn io_every_native_log_cut_anywhere_gives_what_is_before_the_cut() {
    let folder = tempfile::tempdir().unwrap();
    for path in all_native() {
        let name = path.display();
        let whole = headings(&path);
        let refused = open(&path, &ChannelChoice::default()).err();
        let is_a_copy =
            matches!(&refused, Some(e) if matches!(e.fault, Fault::TimeCollapsed { .. }));
        let has_no_rudder =
            matches!(&refused, Some(e) if matches!(e.fault, Fault::NotLogged { .. }));
        assert!(refused.is_none() || is_a_copy || has_no_rudder, "{name}: {refused:?}");
        let bytes = std::fs::read(&path).unwrap();
        let mut before = 0;
        for share in [0.3, 0.5, 0.7, 0.9, 0.999] {
            let length = (bytes.len() as f64 * share) as usize;
            let cut = folder.path().join("log");
            std::fs::write(&cut, &bytes[..length]).unwrap();
            let cache = path.with_file_name("cac/468fd1be.cac");
            let _ = std::fs::copy(cache, folder.path().join("468fd1be.cac"));
            match (&whole, headings(&cut)) {
                (Ok((whole, _)), Ok((read, warnings))) => {
                    assert_eq!(read[..], whole[..read.len()], "{name} {share}");
                    assert!(read.len() >= before, "{name} {share}");
                    before = read.len();
                    let says_so = warnings.iter().any(|w| w.contains("cut off"));
                    assert!(says_so, "{name} {share}: {warnings:?}");
                }
                (Err(whole), Err(cut)) => assert!(!whole.is_empty() && !cut.is_empty()),
                (_, Err(why)) => panic!("{name} {share}: {why}"),
                (Err(why), Ok(_)) => panic!("{name} {share}: whole it is refused: {why}"),
            }
        }
        // Up to the last cut all but a thousandth is there.
        if let Ok((whole, _)) = &whole {
            assert!(before + 20 >= whole.len() * 9 / 10, "{name}: {before} of {}", whole.len());
        }
    }
}

#[test]
fn io_a_cut_file_gives_everything_before_the_cut_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    for file in
        ["ardupilot/ardusub_small.BIN", "ardupilot/rover_json_physics.tlog", "px4/quad_sample.ulg"]
    {
        let Some(path) = data(&format!("native/{file}")) else {
            return;
        };
        let whole = samples(&mut open(&path, &ChannelChoice::default()).unwrap());
        let mut bytes = std::fs::read(&path).unwrap();
        bytes.truncate(bytes.len() * 4 / 5 + 3);
        let cut = folder.path().join("log");
        std::fs::write(&cut, &bytes).unwrap();
        let mut reader = open(&cut, &ChannelChoice::default()).unwrap();
        let read = samples(&mut reader);
        assert!(read.len() > whole.len() / 2, "{file}: {}", read.len());
        // The rudder of the last sample was not known to its end.
        let certain = read.len() - 1;
        assert_eq!(read[..certain], whole[..certain], "{file}");
        let warnings = reader.warnings();
        assert!(warnings.iter().any(|w| w.contains("cut off")), "{warnings:?}");
    }
}
