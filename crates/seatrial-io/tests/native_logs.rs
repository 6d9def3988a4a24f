//! Logs as vehicles write them: every number as the formats' own Python libraries read it, every channel found.

use std::collections::BTreeMap;
use std::path::PathBuf;

use seatrial_core::Sample;
use seatrial_io::{ChannelChoice, Fault, LogReader, Quantity, Unit, open};

/// The file, where the shared data is there.
fn native(name: &str) -> Option<PathBuf> {
    let data = std::env::var_os("SEATRIAL_DATA").map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")),
        PathBuf::from,
    );
    let path = data.join("native").join(name);
    if path.exists() {
        return Some(path);
    }
    eprintln!("skipped: no {} (set SEATRIAL_DATA)", path.display());
    None
}

fn samples(reader: &mut LogReader) -> Vec<Sample<f64>> {
    reader.collect::<Result<_, _>>().unwrap()
}

/// A field of every message, through the channel of the heading: `unit=rad` leaves numbers as they are.
fn values(path: &std::path::Path, column: &str) -> Vec<f64> {
    let of_both = |to: &str| {
        BTreeMap::from([Quantity::Heading, Quantity::Rudder].map(|q| (q, to.to_string())))
    };
    let units = BTreeMap::from([Quantity::Heading, Quantity::Rudder].map(|q| (q, Unit::Radian)));
    let choice = ChannelChoice {
        columns: of_both(column),
        units,
        ..ChannelChoice::default()
    };
    let mut reader = open(path, &choice).unwrap();
    samples(&mut reader)
        .iter()
        .map(|sample| {
            assert_eq!(sample.rudder_rad, sample.heading_rad);
            sample.heading_rad
        })
        .collect()
}

/// Count, sum and sum of k / count value_k of a field.
type Sums = (&'static str, &'static str, usize, f64, f64);

fn assert_sums(folder: &str, all: &[Sums]) {
    for &(file, column, count, sum, weighted) in all {
        let Some(path) = native(&format!("{folder}/{file}")) else {
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
        assert!(
            (found - weighted).abs() <= tolerance,
            "{file} {column}: weighted {found}"
        );
    }
}

/// Sums made with pymavlink 2.4.50, instance 0 of each kind.
#[test]
fn val_pymavlink_reads_the_same_numbers() {
    assert_sums(
        "ardupilot",
        &[
            (
                "ardusub_small.BIN",
                "ATT.Yaw",
                237,
                50693.98000000012,
                25453.141561181426,
            ),
            (
                "ardusub_small.BIN",
                "ATT.TimeUS",
                237,
                65776618058.0,
                33495142405.19409,
            ),
            ("ardusub_small.BIN", "ATT.AEKF", 237, 711.0, 357.0),
            ("ardusub_small.BIN", "RCOU.C13", 237, 260700.0, 130900.0),
            (
                "ardusub_small.BIN",
                "RATE.YOut",
                237,
                -4.147500017657876,
                -2.082500008866191,
            ),
            (
                "ardusub_small.BIN",
                "IMU.GyrZ",
                594,
                1.028530366736959,
                0.5168973232638646,
            ),
            (
                "ardusub_small.BIN",
                "XKF1.GX",
                237,
                -104.80000000000005,
                -52.70616033755275,
            ),
            (
                "ardusub_small.BIN",
                "BARO.Press",
                237,
                23651776.7109375,
                11876019.938554853,
            ),
            ("ardusub_small.BIN", "PM.Mem", 2, 524288.0, 393216.0),
            (
                "ardusub_small.BIN",
                "MAV.txp",
                23,
                738476.0,
                390405.60869565216,
            ),
            (
                "arduplane_pixhawk_64k.BIN",
                "ATT.Yaw",
                24,
                8089.94,
                4213.524166666667,
            ),
            (
                "arduplane_pixhawk_64k.BIN",
                "RCOU.C4",
                23,
                34635.0,
                18070.434782608696,
            ),
            (
                "arduplane_pixhawk_64k.BIN",
                "GPS.Lat",
                5,
                -176.8131373,
                -106.08788218,
            ),
            (
                "arduplane_pixhawk_64k.BIN",
                "GPS.Spd",
                5,
                0.6447613723576069,
                0.324948251247406,
            ),
            (
                "arduplane_pixhawk_64k.BIN",
                "CTUN.RdrOut",
                23,
                -45321.0,
                -23645.739130434784,
            ),
            (
                "arducopter_pixhawk4_80k.BIN",
                "ATT.Yaw",
                5,
                495.9585418701172,
                297.5871887207031,
            ),
            ("arducopter_pixhawk4_80k.BIN", "RCOU.C1", 4, 4480.0, 2800.0),
            (
                "arducopter_pixhawk4_80k.BIN",
                "RATE.Y",
                5,
                0.098818295635283,
                0.07794145895168185,
            ),
            (
                "arducopter_pixhawk4_80k.BIN",
                "XKF4.SV",
                5,
                0.09000000000000001,
                0.05800000000000001,
            ),
            (
                "rover_json_physics.tlog",
                "ATTITUDE.yaw",
                7569,
                6651.431646175886,
                5218.477962474379,
            ),
            (
                "rover_json_physics.tlog",
                "ATTITUDE.time_boot_ms",
                7569,
                605386088.0,
                398218454.83102125,
            ),
            (
                "rover_json_physics.tlog",
                "SERVO_OUTPUT_RAW.servo1_raw",
                7569,
                11362500.0,
                5677739.199365835,
            ),
            (
                "rover_json_physics.tlog",
                "SERVO_OUTPUT_RAW.time_usec",
                7569,
                605387195873.0,
                398218705595.09924,
            ),
            (
                "rover_json_physics.tlog",
                "VFR_HUD.groundspeed",
                3029,
                8301.967544607818,
                5836.607624917067,
            ),
            (
                "rover_json_physics.tlog",
                "GLOBAL_POSITION_INT.lon",
                3028,
                4364448072550.0,
                2256462193366.687,
            ),
            (
                "rover_json_physics.tlog",
                "RC_CHANNELS_SCALED.chan1_scaled",
                154,
                3615.0,
                177.9935064935065,
            ),
            (
                "ardusub_small.tlog",
                "ATTITUDE.yaw",
                5245,
                -12559.888679265976,
                -6536.5545529526,
            ),
            (
                "ardusub_small.tlog",
                "RC_CHANNELS.chan4_raw",
                528,
                790869.0,
                395752.1003787879,
            ),
            (
                "ardusub_small.tlog",
                "SERVO_OUTPUT_RAW.servo16_raw",
                528,
                792000.0,
                396750.0,
            ),
            (
                "ardusub_small.tlog",
                "LOCAL_POSITION_NED.vz",
                792,
                -0.6640522962438808,
                -0.3588080384195936,
            ),
            (
                "sub_manual.tlog",
                "ATTITUDE.yaw",
                1990,
                -1326.5412368053053,
                -1045.8160565223366,
            ),
            (
                "sub_manual.tlog",
                "SERVO_OUTPUT_RAW.servo8_raw",
                1990,
                2983500.0,
                1493249.2462311557,
            ),
        ],
    );
}

/// Sums made with pyulog 1.3.0.
#[test]
fn val_pyulog_reads_the_same_numbers() {
    assert_sums(
        "px4",
        &[
            (
                "fixedwing_fmuv6c.ulg",
                "vehicle_attitude.q[0]",
                131,
                114.10048562288284,
                63.1031509089561,
            ),
            (
                "fixedwing_fmuv6c.ulg",
                "vehicle_attitude.quat_reset_counter",
                131,
                262.0,
                132.0,
            ),
            (
                "fixedwing_fmuv6c.ulg",
                "vehicle_torque_setpoint.xyz[2]",
                326,
                -2.492310821065985,
                -0.3074514105301185,
            ),
            (
                "fixedwing_fmuv6c.ulg",
                "actuator_servos.control[1]",
                66,
                5.713459620019421,
                0.1257477613187144,
            ),
            (
                "fixedwing_fmuv6c.ulg",
                "sensor_gyro.1.x",
                6,
                -0.38137438148260117,
                -0.4776778543988863,
            ),
            (
                "fixedwing_fmuv6c.ulg",
                "vehicle_local_position.ref_lat",
                66,
                2400.3648438000005,
                1218.3670040499999,
            ),
            (
                "fixedwing_fmuv6c.ulg",
                "battery_status.remaining",
                34,
                33.998641073703766,
                17.49912483201307,
            ),
            (
                "fixedwing_fmuv6c.ulg",
                "vehicle_status.nav_state_timestamp",
                13,
                340591810.0,
                183395590.0,
            ),
            (
                "quad_sample.ulg",
                "vehicle_attitude.q[3]",
                6461,
                -1948.7574253082275,
                -979.9792356768419,
            ),
            (
                "quad_sample.ulg",
                "vehicle_attitude.yawspeed",
                6461,
                -20.43587268819101,
                -1.0452342400636068,
            ),
            (
                "quad_sample.ulg",
                "actuator_controls_0.control[2]",
                3269,
                -82.1058396056178,
                -37.45995652727844,
            ),
            (
                "quad_sample.ulg",
                "actuator_outputs.output[3]",
                1311,
                1179900.0,
                590399.9999999999,
            ),
            (
                "quad_sample.ulg",
                "sensor_combined.timestamp",
                17070,
                2509845601128.0,
                1352962132732.9517,
            ),
            (
                "quad_v4pro_appended.ulg",
                "vehicle_attitude.q[3]",
                306,
                197.5557166337967,
                99.0987945004227,
            ),
            (
                "quad_v4pro_appended.ulg",
                "actuator_controls_0.control[2]",
                95,
                -66.28419786691666,
                -33.49689021549727,
            ),
            (
                "quad_v4pro_appended.ulg",
                "actuator_outputs.1.output[0]",
                96,
                144000.0,
                72750.0,
            ),
            (
                "vtol_cubeorange.ulg",
                "vehicle_attitude.q[3]",
                1298,
                64.3549771104008,
                22.24143867168681,
            ),
            (
                "vtol_cubeorange.ulg",
                "actuator_controls_0.control[2]",
                1812,
                64.12618154659867,
                30.705210034234426,
            ),
            (
                "vtol_cubeorange.ulg",
                "actuator_outputs.1.output[0]",
                65,
                65000.0,
                33000.0,
            ),
            (
                "vtol_cubeorange.ulg",
                "vehicle_angular_velocity.xyz[2]",
                1812,
                -119.69658583030105,
                -56.12942817903828,
            ),
        ],
    );
}

/// Sums made with nmea2000 2026.10.3, which uses canboat's database.
#[test]
fn val_canboats_database_gives_the_same_numbers() {
    assert_sums(
        "nmea2000",
        &[
            (
                "ac42-commissioning.raw",
                "vessel_heading.52.heading_rad",
                5888,
                23881.55839999999,
                11956.776424252748,
            ),
            (
                "ac42-commissioning.raw",
                "rate_of_turn.52.rate_rad_s",
                5888,
                1.1780937500000006,
                0.450738703082541,
            ),
            (
                "ac42-commissioning.raw",
                "cog_sog.52.sog_m_s",
                2355,
                111.33999999999982,
                56.26681528662422,
            ),
            (
                "ac42-commissioning.raw",
                "rudder.13.255.position_rad",
                2701,
                527.5760000000254,
                75.1036707145498,
            ),
            (
                "triton-engine-setup.all",
                "attitude.52.roll_rad",
                261,
                -7.964499999999992,
                -3.3263260536398462,
            ),
            (
                "triton-engine-setup.all",
                "speed.35.speed_water_m_s",
                130,
                430.2300000000001,
                224.92853846153847,
            ),
            (
                "triton-engine-setup.all",
                "water_depth.35.depth_m",
                3,
                29.349999999999998,
                18.18,
            ),
        ],
    );
}

/// Sums made with dbdreader 0.6.3, the first cycle included.
#[test]
fn val_dbdreader_reads_the_same_numbers() {
    assert_sums(
        "slocum",
        &[
            (
                "amadeus-2014-204-05-000.dbd",
                "m_heading",
                898,
                1165.8607430364937,
                544.3060990429877,
            ),
            (
                "amadeus-2014-204-05-000.dbd",
                "m_fin",
                898,
                60.48156842030585,
                29.625606833387778,
            ),
            (
                "amadeus-2014-204-05-000.dbd",
                "c_fin",
                890,
                60.92951181263197,
                29.265854562668448,
            ),
            (
                "amadeus-2014-204-05-000.dbd",
                "m_depth",
                898,
                16343.663833378,
                7582.5524029044955,
            ),
            (
                "amadeus-2014-204-05-000.dbd",
                "m_pitch",
                898,
                -114.80601357016712,
                -43.1139922380521,
            ),
            (
                "amadeus-2014-204-05-000.dbd",
                "m_present_time",
                898,
                1262788687523.4995,
                632097762301.9923,
            ),
        ],
    );
}

/// A copy's times: 23,795 messages in 57 ms are more than the bus carries.
#[test]
fn io_a_capture_with_collapsed_times_is_refused() {
    let Some(path) = native("nmea2000/raymarine-ev1.raw") else {
        return;
    };
    let refused = open(&path, &ChannelChoice::default());
    let fault = refused.err().unwrap().fault;
    assert!(
        matches!(
            fault,
            Fault::TimeCollapsed {
                messages: 23_795,
                ..
            }
        ),
        "{fault}"
    );
}

/// Without its list of sensors a glider's log says which file is missing.
#[test]
fn io_a_glider_log_without_its_cache_file_names_it() {
    let Some(path) = native("slocum/amadeus-2014-204-05-000.dbd") else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let alone = folder.path().join("log");
    std::fs::copy(path, &alone).unwrap();
    let refused = open(&alone, &ChannelChoice::default());
    let message = refused.err().unwrap().to_string();
    assert!(message.contains("468fd1be.cac"), "{message}");
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
        (
            "ardupilot/arduplane_pixhawk_64k.BIN",
            "RCOU.steering_fraction",
        ),
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
        let Some(path) = native(file) else {
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
    let Some(path) = native("ardupilot/arduplane_pixhawk_64k.BIN") else {
        return;
    };
    let fractions = values(&path, "RCOU.steering_fraction");
    assert_eq!(fractions[0], -(1506.0 - 1200.0) / (1900.0 - 1200.0));
}

/// The doublet of `fit_1680`: 1723 us from 87.603047 s on, 1277 us from 89.603047 s, 1500 us from 91.603047 s.
#[test]
fn exact_the_rudder_of_a_sample_acts_from_its_time_until_the_next() {
    let Some(path) = native("ardupilot/rover_json_physics.tlog") else {
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
        assert!(
            (at(time_s) - expected).abs() < 1e-9,
            "{time_s}: {}",
            at(time_s)
        );
    }
}

/// Boot clock and arrival are kept apart: both can be the time, and the ground station's jitters.
#[test]
fn io_arrival_is_a_time_of_its_own() {
    let Some(path) = native("ardupilot/rover_json_physics.tlog") else {
        return;
    };
    let intervals = |choice: &ChannelChoice| -> Vec<f64> {
        let samples = samples(&mut open(&path, choice).unwrap());
        samples
            .windows(2)
            .map(|p| p[1].time_s - p[0].time_s)
            .collect()
    };
    let boot = intervals(&ChannelChoice::default());
    let arrival = intervals(&ChannelChoice {
        columns: BTreeMap::from([(Quantity::Time, "ATTITUDE.arrival_us".to_string())]),
        units: BTreeMap::from([(Quantity::Time, Unit::Microsecond)]),
        ..ChannelChoice::default()
    });
    let regular = |all: &[f64]| all.iter().filter(|dt| (**dt - 0.02).abs() < 1e-6).count();
    assert!(regular(&boot) > boot.len() * 99 / 100);
    assert!(regular(&arrival) < arrival.len() / 100);
}

/// Logs in all folders of the shared data, but for the lists of sensors.
fn all_native() -> Vec<PathBuf> {
    let folders = ["ardupilot", "px4", "nmea2000", "slocum"];
    let files = folders.iter().filter_map(|folder| native(folder));
    let files = files.flat_map(|folder| std::fs::read_dir(folder).unwrap());
    let mut files: Vec<PathBuf> = files.map(|entry| entry.unwrap().path()).collect();
    files.retain(|path| path.is_file() && path.extension().is_none_or(|suffix| suffix != "csv"));
    files.sort();
    files
}

/// Without its path.
fn refusal(error: &seatrial_io::ReadError) -> String {
    error.fault.to_string()
}

/// Times and headings, or why there are none.
fn headings(path: &std::path::Path) -> Result<(Vec<[f64; 2]>, Vec<String>), String> {
    let heading_alone = |column: &str| ChannelChoice {
        columns: BTreeMap::from([Quantity::Heading, Quantity::Rudder].map(|q| (q, column.into()))),
        units: BTreeMap::from([Quantity::Heading, Quantity::Rudder].map(|q| (q, Unit::Radian))),
        drop_invalid: true,
        ..ChannelChoice::default()
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
        assert!(
            refused.is_none() || is_a_copy || has_no_rudder,
            "{name}: {refused:?}"
        );
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
            assert!(
                before + 20 >= whole.len() * 9 / 10,
                "{name}: {before} of {}",
                whole.len()
            );
        }
    }
}

#[test]
fn io_a_cut_file_gives_everything_before_the_cut_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    for file in [
        "ardupilot/ardusub_small.BIN",
        "ardupilot/rover_json_physics.tlog",
        "px4/quad_sample.ulg",
    ] {
        let Some(path) = native(file) else {
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
        assert!(
            warnings.iter().any(|w| w.contains("cut off")),
            "{warnings:?}"
        );
    }
}
