//! Logs as people's recorders write them: the same run in every container and encoding gives the same samples.

use std::path::Path;

use seatrial_core::Sample;
use seatrial_dev::data;
use seatrial_logs::{ChannelChoice, Fault, Format, LogReader, Quantity, Unit, open};

use crate::seeds::captures::imc;
use crate::seeds::{ROWS, lsf};

fn samples(path: &Path, choice: &ChannelChoice) -> (Vec<Sample<f64>>, LogReader) {
    let mut reader = open(path, choice).unwrap();
    let samples = reader.by_ref().collect::<Result<Vec<_>, _>>().unwrap();
    (samples, reader)
}

fn of_text(text: &str, choice: &ChannelChoice) -> Result<(Vec<Sample<f64>>, LogReader), Fault> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log");
    std::fs::write(&path, text).unwrap();
    let mut reader = open(&path, choice).map_err(|error| error.fault)?;
    let samples: Result<Vec<_>, _> = reader.by_ref().collect();
    Ok((samples.map_err(|error| error.fault)?, reader))
}

fn unit(reader: &LogReader, quantity: Quantity) -> Unit {
    let mut channels = reader.description().channels.iter();
    channels.find(|channel| channel.quantity == quantity).unwrap().unit
}

/// Do two records hold the same run, with times, headings and rudders within these, s and rad?
fn assert_same(
    one: &[Sample<f64>],
    other: &[Sample<f64>],
    time_s: f64,
    angle_rad: f64,
    what: &str,
) {
    let start_s = [one, other].map(|samples| samples[0].time_s);
    for (k, (a, b)) in one.iter().zip(other).enumerate() {
        let late_s = (a.time_s - start_s[0]) - (b.time_s - start_s[1]);
        assert!(late_s.abs() < time_s, "{what} {k}: {a:?} {b:?}");
        let turned = (a.heading_rad - b.heading_rad).sin();
        assert!(turned.abs() < angle_rad, "{what} {k}: {a:?} {b:?}");
        // A rudder that is stamped 1 ms late moves 1 % of an interval of 0.1 s late.
        assert!((a.rudder_rad - b.rudder_rad).abs() < 0.01, "{what} {k}: {a:?} {b:?}");
    }
}

#[test]
fn io_one_run_of_many_recorders_is_one_record() {
    let Some(cases) = data("cases") else { return };
    let read = |name: &str| samples(&cases.join(name), &ChannelChoice::default()).0;
    let run = read("11_ros_secs_nsecs.csv");
    assert_eq!(run.len(), 1401);
    // Times: of days with six decimals, 0.09 s. Angles: of whole 1e-4 rad, or hundredths of a degree.
    for (name, time_s, angle_rad) in [
        ("01_time_100ns_ticks.csv", 1e-6, 1e-9),
        ("10_ydwg.raw", 1e-6, 2e-4),
        ("10c_ikonvert.log", 1.1e-2, 2e-4),
        ("14_expedition_sparse.csv", 0.1, 2e-4),
        ("18_grafana_long.csv", 1e-6, 2e-4),
        ("21_hhmmss_number.csv", 1e-6, 1e-9),
    ] {
        let found = read(name);
        // A rudder a moment behind the first heading leaves that one out.
        let missing = run.len() - found.len();
        assert!(missing <= 1, "{name}: {missing}");
        assert_same(&found, &run[missing..], time_s, angle_rad, name);
    }
}

#[test]
fn io_sentences_keep_their_own_times_or_are_spread_between_those_of_others() {
    let Some(cases) = data("cases") else { return };
    for (name, count) in [
        ("08_opencpn_vdr.csv", 1500),
        ("09_nmea_10hz_rmc_1hz.nmea", 2201),
        ("19_two_talkers.log", 1510),
    ] {
        let (found, reader) = samples(&cases.join(name), &ChannelChoice::default());
        assert_eq!(found.len(), count, "{name}");
        let steps = found.windows(2).map(|pair| pair[1].time_s - pair[0].time_s);
        let uneven = steps.filter(|step| (step - 0.1).abs() > 1e-3).count();
        assert!(uneven <= count / 100, "{name}: {uneven}");
        let doubts = &reader.description().warnings;
        let says_two = doubts.iter().any(|text| text.contains("2 instruments send HDG"));
        assert_eq!(says_two, name.starts_with("19"), "{doubts:?}");
    }
}

#[test]
fn io_columns_of_different_rates_are_joined_by_time() {
    let Some(cases) = data("cases") else { return };
    let (found, _) =
        samples(&cases.join("12_outer_merge_empty_cells.csv"), &ChannelChoice::default());
    assert!(found.len() >= 1599);
    let steps = found.windows(2).map(|pair| pair[1].time_s - pair[0].time_s);
    assert!(steps.into_iter().all(|step| (step - 0.1).abs() < 0.05));
}

#[test]
fn io_what_a_column_says_of_its_clock_and_rate_is_understood() {
    let Some(cases) = data("cases") else { return };
    let name = "13_utc_in_brackets_rot_degmin.csv";
    let (found, reader) = samples(&cases.join(name), &ChannelChoice::default());
    assert_eq!(found.len(), 721);
    assert_eq!(unit(&reader, Quantity::YawRate), Unit::DegreePerMinute);
    assert_eq!(reader.description().start_utc.as_deref(), Some("2015-09-21T13:13:21.8Z"));
    let refused = open(&cases.join("02_heading_tenths.csv"), &ChannelChoice::default());
    let error = refused.err().unwrap().to_string();
    assert!(error.contains("--unit heading=UNIT") && error.contains("ddeg"), "{error}");
}

#[test]
fn io_positions_are_read_wherever_they_are() {
    let Some(cases) = data("cases") else { return };
    let read = |name: &str| samples(&cases.join(name), &ChannelChoice::default()).0;
    let truth = read("04_truth_positions_shifted.csv");
    for name in ["04_turning_circle_latlon.csv", "04b_turning_circle_minus999.csv"] {
        let found = read(name);
        assert_eq!(found.len(), truth.len());
        for (one, other) in found.iter().zip(&truth) {
            let moved = [
                one.north_m.unwrap()
                    - found[0].north_m.unwrap()
                    - (other.north_m.unwrap() - truth[0].north_m.unwrap()),
                one.east_m.unwrap()
                    - found[0].east_m.unwrap()
                    - (other.east_m.unwrap() - truth[0].east_m.unwrap()),
            ];
            // A minute of latitude is 1852 m to 0.3 %, of 4 km.
            assert!(moved.iter().all(|m| m.abs() < 12.0), "{name}: {moved:?}");
        }
    }
}

/// A heading through north and a rudder, written by a row of time in s, heading in turns and rudder in degrees.
fn log(header: &str, row: impl Fn(f64, f64, f64) -> String) -> String {
    let rows = (0..400).map(|k| {
        let time_s = 0.1 * f64::from(k);
        let turns = (0.93 + 0.15 * (0.2 * time_s).sin()).rem_euclid(1.0);
        row(time_s, turns, 10.0 * (0.2 * time_s).cos())
    });
    rows.fold(format!("{header}\n"), |log, row| log + &row + "\n")
}

#[test]
fn io_a_heading_says_its_unit_where_it_wraps() {
    for (turn, decimals, expected) in [
        (360.0, 1, Unit::Degree),
        (std::f64::consts::TAU, 4, Unit::Radian),
        (1.0, 5, Unit::Turn),
        (3600.0, 0, Unit::Decidegree),
        (36_000.0, 0, Unit::Centidegree),
        (6400.0, 0, Unit::Mil),
        (6283.185, 0, Unit::Milliradian),
        (62_831.85, 0, Unit::TenthMilliradian),
        (65_536.0, 0, Unit::Count16),
        (256.0, 0, Unit::Count8),
        (4096.0, 0, Unit::Count12),
    ] {
        let text = log("time_s,heading,rudder_deg", |time_s, turns, rudder| {
            format!("{time_s:.1},{:.decimals$},{rudder:.1}", (turns * turn) % turn)
        });
        let (_, reader) = of_text(&text, &ChannelChoice::default()).unwrap();
        assert_eq!(unit(&reader, Quantity::Heading), expected, "{turn}");
    }
    // By its name it is in degrees, and no degree wraps there.
    let text = log("time_s,heading_deg,rudder_deg", |time_s, turns, rudder| {
        format!("{time_s:.1},{:.0},{rudder:.1}", 3600.0 * turns)
    });
    let refused = of_text(&text, &ChannelChoice::default());
    assert!(matches!(refused, Err(Fault::ImplausibleValues { .. })));
}

#[test]
fn io_coordinates_and_degrees_a_minute_are_understood() {
    let names = "DATE/TIME(UTC),Latitude,Longitude,Heading,Rudder,Rate of Turn";
    let text = log(names, |t, turns, rudder| {
        // The heading turns by 0.15 * 0.2 * cos(0.2 t) turns a second, 60 times that a minute.
        let rate = 648.0 * (0.2 * t).cos();
        let (latitude, longitude) = (50.0 + 1e-5 * t, -20.0 + 2e-5 * t);
        let heading = 360.0 * turns;
        format!(
            "2026-03-04 00:00:{t:04.1},{latitude:.7},{longitude:.7},{heading:.2},{rudder:.2},{rate:.3}"
        )
    });
    let (samples, reader) = of_text(&text, &ChannelChoice::default()).unwrap();
    assert_eq!(unit(&reader, Quantity::YawRate), Unit::DegreePerMinute);
    let last = samples[399];
    // 39.9 s of a hundred-thousandth of a degree; the cosine of 50 deg is 0.6428.
    assert!((last.north_m.unwrap() - 39.9 * 1.1112).abs() < 0.02, "{last:?}");
    assert!((last.east_m.unwrap() - 39.9 * 2.2224 * 0.6428).abs() < 0.02, "{last:?}");
}

/// How a recorder writes a time in s.
type Written = Box<dyn Fn(f64) -> String>;

#[test]
fn io_times_are_read_in_every_way_that_recorders_write_them() {
    // 2026-03-04T10:29:58Z
    let start_s = 1_772_620_198_f64;
    let clock = |time_s: f64| {
        let of_day_s = 37_798.0 + time_s;
        let (hours, rest) = ((of_day_s / 3600.0).floor(), of_day_s % 3600.0);
        (hours, (rest / 60.0).floor(), rest % 60.0)
    };
    let of_clock = move |time_s: f64, write: fn(f64, f64, f64) -> String| {
        let (hours, minutes, seconds) = clock((time_s * 10.0).round() / 10.0 + 1e-9);
        write(hours, minutes, seconds)
    };
    let ways: [(&str, Written); 13] = [
        ("time_s", Box::new(|t| format!("{t:.1}"))),
        ("stamp", Box::new(move |t| format!("{:.1}", start_s + t))),
        ("stamp", Box::new(move |t| format!("{:.0}", 1e3 * (start_s + t)))),
        ("stamp", Box::new(move |t| format!("{:.0}", 1e6 * (start_s + t)))),
        (
            "stamp",
            Box::new(move |t| format!("{:.0}", 1e7 * (start_s + 11_644_473_600.0) + 1e7 * t)),
        ),
        (
            "stamp",
            Box::new(move |t| format!("{:.0}", 1e7 * (start_s + 62_135_596_800.0) + 1e7 * t)),
        ),
        (
            "secs,nsecs",
            Box::new(move |t| format!("{start_s:.0},{:.0}", 1e9 * t).replace("nan", "")),
        ),
        (
            "year,month,day,hour,minute,second",
            Box::new(move |t| of_clock(t, |h, m, s| format!("2026,3,4,{h},{m},{s:.1}"))),
        ),
        ("utc", Box::new(move |t| of_clock(t, |h, m, s| format!("{h:02}{m:02}{s:04.1}")))),
        ("utc", Box::new(move |t| of_clock(t, |h, m, s| format!("20260304{h:02}{m:02}{s:04.1}")))),
        (
            "Time (UTC)",
            Box::new(move |t| of_clock(t, |h, m, s| format!("4-Mar-2026 {h:02}:{m:02}:{s:04.1}"))),
        ),
        (
            "DATE/TIME(UTC)",
            Box::new(move |t| {
                of_clock(t, |h, m, s| format!("Mar 4 2026 {h}:{m:02}:{s:04.1} a.m."))
            }),
        ),
        (
            "date,time",
            Box::new(move |t| of_clock(t, |h, m, s| format!("2026-03-04,{h:02}:{m:02}:{s:04.1}"))),
        ),
    ];
    for (number, (names, time)) in ways.iter().enumerate() {
        let text = log(&format!("{names},heading_deg,rudder_deg"), |time_s, turns, rudder| {
            format!("{},{:.3},{rudder:.2}", time(time_s), 360.0 * turns)
        });
        let found = of_text(&text, &ChannelChoice::default());
        let (samples, _) = found.unwrap_or_else(|fault| panic!("{number} {names}: {fault}"));
        assert_eq!(samples.len(), 400, "{number} {names}");
        let (first, last) = (samples[0], samples[399]);
        // A date and time in digits is a number of 14 digits, which is a double to 4 ms.
        assert!((last.time_s - first.time_s - 39.9).abs() < 5e-3, "{number} {names}: {last:?}");
    }
}

#[test]
fn io_one_vehicle_of_two_an_attitude_and_a_rate_alone_are_read() {
    let text = log("BOAT,time_s,heading_deg,rudder_deg", |time_s, turns, rudder| {
        let of =
            |boat: u8, turns: f64| format!("{boat},{time_s:.1},{:.2},{rudder:.1}", 360.0 * turns);
        format!("{}\n{}", of(1, turns), of(2, 0.5 * turns))
    });
    let mut choice = ChannelChoice::default();
    choice.rows_where = vec![("BOAT".into(), "2".into())];
    let (samples, _) = of_text(&text, &choice).unwrap();
    assert_eq!(samples.len(), 400);
    assert!((samples[0].heading_rad.to_degrees() - 167.4).abs() < 0.01);

    let names = "time_s,orientation.x,orientation.y,orientation.z,orientation.w,rudder_deg";
    let text = log(names, |time_s, turns, rudder| {
        let yaw = std::f64::consts::TAU * (0.25 - turns);
        format!("{time_s:.1},0,0,{:.6},{:.6},{rudder:.1}", (0.5 * yaw).sin(), (0.5 * yaw).cos())
    });
    let (samples, _) = of_text(&text, &ChannelChoice::default()).unwrap();
    let north = samples[0].heading_rad - 0.93 * std::f64::consts::TAU;
    assert!(north.sin().abs() < 1e-4);

    let text = log("time_s,yaw_rate (deg/s),rudder_deg", |time_s, _, rudder| {
        format!("{time_s:.1},{:.6},{rudder:.1}", 3.0 * (0.2 * time_s).cos())
    });
    let (samples, _) = of_text(&text, &ChannelChoice::default()).unwrap();
    let turned = samples[399].heading_rad.to_degrees() - 15.0 * (0.2_f64 * 39.9).sin();
    assert!(turned.abs() < 0.01, "{turned}");
    assert!(samples.iter().all(|sample| sample.yaw_rate_rad_s.is_none()));
}

#[test]
fn io_one_value_a_row_of_a_database_is_read() {
    let rows = log(
        "#group,false,false\n,result,table,_time,_value,_field,_measurement",
        |t, turns, rudder| {
            let of = |value: f64, name: &str| {
                format!(",,0,2026-03-04T00:00:{t:04.1}Z,{value:.5},value,{name}")
            };
            let heading = of(std::f64::consts::TAU * turns, "navigation.headingTrue");
            format!("{heading}\n{}", of(rudder.to_radians(), "steering.rudderAngle"))
        },
    );
    let (samples, reader) = of_text(&rows, &ChannelChoice::default()).unwrap();
    assert!(samples.len() >= 399);
    assert_eq!(unit(&reader, Quantity::Heading), Unit::Radian);
    assert!((samples[0].rudder_rad.to_degrees() - 10.0).abs() < 0.1);
}

/// Bags of ROS 1, workbooks and MATLAB's arrays hold the run that their seeds were made of.
#[cfg(all(feature = "containers", feature = "parquet", feature = "mcap", feature = "rosbag2"))]
#[test]
fn io_bags_workbooks_and_arrays_are_read() {
    for format in ["rosbag1", "xlsx", "mat"] {
        for (number, bytes) in crate::seeds::of(format).into_iter().enumerate() {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("log");
            std::fs::write(&path, bytes).unwrap();
            let (samples, mut reader) = samples(&path, &ChannelChoice::default());
            let what = format!("{format} {number}");
            assert_eq!(reader.description().format.to_string(), format);
            // The rudder of a bag comes a moment after the first attitude, at one time.
            assert_eq!(samples.len(), 6, "{what}");
            for (k, sample) in samples.iter().enumerate() {
                let after_s = sample.time_s - samples[0].time_s;
                assert!((after_s - 0.1 * k as f64).abs() < 1e-6, "{what}: {sample:?}");
                let turned = sample.heading_rad - (1.0 + 0.01 * k as f64);
                assert!(turned.sin().abs() < 1e-6, "{what}: {sample:?}");
                let rudder = sample.rudder_rad.to_degrees() - (5.0 - k as f64);
                assert!(rudder.abs() < 1e-6, "{what}: {sample:?}");
            }
            assert_eq!(reader.sha256().unwrap().len(), 64);
        }
    }
}

/// Text of Japanese and of Excel's encodings is the text in UTF-8.
#[cfg(feature = "containers")]
#[test]
fn io_text_in_other_encodings_is_read() {
    let text = log("時刻 (s),船首方位 (deg),舵角 (deg)", |t, turns, rudder| {
        format!("{t:.1},{:.2},{rudder:.2}", 360.0 * turns)
    });
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.csv");
    std::fs::write(&path, &text).unwrap();
    let (plain, _) = samples(&path, &ChannelChoice::default());
    let (japanese, _, _) = encoding_rs::SHIFT_JIS.encode(&text);
    let wide: Vec<u8> =
        "\u{feff}".encode_utf16().chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    for (name, bytes) in [("Shift_JIS", &japanese[..]), ("UTF-16LE", &wide)] {
        std::fs::write(&path, bytes).unwrap();
        let (found, reader) = samples(&path, &ChannelChoice::default());
        assert_eq!(found, plain, "{name}");
        let warnings = reader.warnings();
        assert!(warnings.iter().any(|text| text.contains(name)), "{warnings:?}");
    }
}

/// Deltas of Signal K: paths are columns, of two sources two.
#[test]
fn io_deltas_of_signal_k_are_read() {
    let delta = |t: f64, source: &str, path: &str, value: f64| {
        format!(
            r#"{{"updates":[{{"timestamp":"2026-03-04T00:00:{t:06.3}Z","$source":"{source}","values":[{{"path":"{path}","value":{value:.5}}}]}}]}}"#
        )
    };
    let deltas = |sources: &[&str]| {
        let rows = log("", |t, turns, rudder| {
            let rudder = delta(t, "n2k.26", "steering.rudderAngle", rudder.to_radians());
            let heading = std::f64::consts::TAU * turns;
            let headings = sources
                .iter()
                .map(|source| delta(t, source, "navigation.headingMagnetic", heading));
            std::iter::once(rudder).chain(headings).collect::<Vec<_>>().join("\n")
        });
        rows.trim_start().to_owned()
    };
    let (samples, reader) = of_text(&deltas(&["n2k.15"]), &ChannelChoice::default()).unwrap();
    assert_eq!(samples.len(), 400);
    assert_eq!(unit(&reader, Quantity::Heading), Unit::Radian);
    assert!((samples[0].rudder_rad.to_degrees() - 10.0).abs() < 0.01);
    let two = deltas(&["n2k.15", "n2k.22"]);
    let mut choice = ChannelChoice::default();
    let second = "n2k.22: navigation.headingMagnetic";
    choice.columns.insert(Quantity::Heading, second.into());
    assert_eq!(of_text(&two, &choice).unwrap().0.len(), 400);
}

/// The rudder is the mean of the two vertical fins, which roll control turns against each other.
#[test]
fn io_logs_of_dune_are_read_and_what_is_damaged_is_passed_over() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("Data.lsf");
    let read = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        samples(&path, &ChannelChoice::default())
    };
    let log = lsf();
    let (whole, reader) = read(&log);
    assert_eq!(whole.len(), ROWS as usize);
    assert!(reader.warnings().is_empty(), "{:?}", reader.warnings());
    for (k, sample) in whole.iter().enumerate() {
        let heading_rad = f64::from(1.0 + 0.01 * k as f32);
        assert_eq!(sample.heading_rad, heading_rad);
        // Angles of servos are single.
        assert!((sample.rudder_rad - 0.1).abs() < 1e-7, "{sample:?}");
        assert_eq!(sample.roll_rad, Some(0.02));
        assert_eq!(sample.pitch_rad, Some(-0.05));
    }
    // A heading of another value, and a size that reaches over all the rest: that sample is missing, those behind it are not.
    let size = log.len() / ROWS as usize;
    for (at, byte) in [(2 * size - 10, 1), (2 * size - 57, 0xff)] {
        let mut damaged = log.clone();
        damaged[at] ^= byte;
        let (rest, reader) = read(&damaged);
        assert_eq!((rest[0], &rest[1..]), (whole[0], &whole[2..]), "{at}");
        let warnings = reader.warnings().join("; ");
        assert!(warnings.contains("62 bytes in 1 places"), "{warnings}");
    }
}

/// The command to a boat's rudder; of two compasses the one with more messages, of two orders of bytes each.
#[test]
fn io_logs_of_dune_tell_compasses_and_orders_of_bytes_apart() {
    let mut log = Vec::new();
    for k in 0..10 {
        let time_s = 1.7e9 + 0.1 * f64::from(k);
        let angles = |psi: f64| [0.0, 0.0, 0.0, psi, 0.0].map(f64::to_be_bytes);
        let rates = [0.0, 0.0, 0.0, 0.05].map(f64::to_be_bytes);
        log.extend(imc(false, 302, time_s, 3, &[&[0], &(-0.2_f32).to_be_bytes()]));
        log.extend(imc(false, 256, time_s, 12, &[rates.as_flattened()]));
        if k % 2 == 0 {
            log.extend(imc(false, 254, time_s, 7, &[angles(2.0).as_flattened()]));
        }
        log.extend(imc(false, 254, time_s, 12, &[angles(1.0).as_flattened()]));
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log");
    std::fs::write(&path, log).unwrap();
    let mut choice = ChannelChoice::default();
    let (read, _) = samples(&path, &choice);
    assert_eq!(read.len(), 10);
    assert!(read.iter().all(|sample| sample.heading_rad == 1.0));
    assert!(read.iter().all(|sample| sample.yaw_rate_rad_s == Some(0.05)));
    assert!(read.iter().all(|sample| (sample.rudder_rad + 0.2).abs() < 1e-7));
    choice.columns = [(Quantity::Heading, "EulerAngles.30.7.psi".into())].into();
    let (read, _) = samples(&path, &choice);
    assert_eq!(read.len(), 5);
    assert!(read.iter().all(|sample| sample.heading_rad == 2.0));
}

/// Positions of a track beside a log, by UTC.
#[cfg(feature = "containers")]
#[test]
fn io_positions_of_a_track_are_joined_by_time() {
    let folder = tempfile::tempdir().unwrap();
    let track = folder.path().join("track.gpx");
    let point = |s: u32| {
        format!(
            "<trkpt lat=\"{:.6}\" lon=\"8.0\"><time>2026-03-04T00:00:{s:02}Z</time></trkpt>",
            50.0 + 1e-5 * f64::from(s)
        )
    };
    let points: String = (5..50).map(point).collect();
    std::fs::write(&track, format!("<gpx><trk><trkseg>{points}</trkseg></trk></gpx>")).unwrap();
    let mut choice = ChannelChoice::default();
    choice.positions = Some(track.clone());
    let text = log("time,heading_deg,rudder_deg", |t, turns, rudder| {
        format!("2026-03-04T00:00:{t:04.1}Z,{:.2},{rudder:.2}", 360.0 * turns)
    });
    let (samples, _) = of_text(&text, &choice).unwrap();
    assert_eq!(samples[49].north_m, None);
    let north_m = samples[105].north_m.unwrap();
    // 5.5 s on, at a hundred-thousandth of a degree a second.
    assert!((north_m - 5.5 * 1.1112).abs() < 0.01, "{north_m}");
    let text = text.replace("2026", "2025");
    let (samples, reader) = of_text(&text, &choice).unwrap();
    assert!(samples.iter().all(|sample| sample.north_m.is_none()));
    let warnings = reader.warnings();
    assert!(warnings.iter().any(|text| text.contains("no sample is within")), "{warnings:?}");
    let text = log("time_s,heading_deg,rudder_deg", |t, turns, rudder| {
        format!("{t:.1},{:.2},{rudder:.2}", 360.0 * turns)
    });
    assert!(matches!(of_text(&text, &choice), Err(Fault::NoDate)));
}

#[test]
fn io_what_is_not_read_says_how_it_is_converted() {
    let refused = |bytes: &[u8]| {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log");
        std::fs::write(&path, bytes).unwrap();
        let error = open(&path, &ChannelChoice::default()).err().unwrap();
        error.to_string()
    };
    assert!(refused(b"LOGG\x90\0\0\0").contains("can.logconvert"));
    assert!(refused(b"\xed\xa1\xda\x01\0\0").contains("lcm.EventLog"));
    assert!(refused(b"FTP NEW 2\n").contains("HYPACK"));
    let echo = "header:\n  stamp:\n    sec: 1\nyaw: 0.1\n---\n".repeat(9);
    assert!(refused(echo.as_bytes()).contains("ros2 bag record"));
    let of_web = crate::seeds::pcap(1, std::iter::once((0.0, b"GET /".to_vec())));
    assert!(refused(&of_web).contains("NMEA 0183 sentences"));
    assert!(
        refused(b"1714564800,0,base,45.1,2.0\n1714564800,1,base,45.1,2.0\n")
            .contains("first line is numbers")
    );
    assert!(refused(b"MATLAB 7.3 MAT-file, Platform: GLNXA64").contains("'-v7'"));
    assert!(refused(b"#ROSBAG V1.2\n").contains("rosbag fix"));
    let empty = refused(b"#ROSBAG V2.0\nE\0\0\0");
    assert!(empty.contains("expected topics with messages"), "{empty}");
}

/// The page names every format that it reads; it reads no rosbag2.
#[test]
fn prop_the_page_names_every_format() {
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../../web/src/alone/own.ts");
    let text = std::fs::read_to_string(page).unwrap();
    let names = Format::NAMES.iter().map(|(_, name, _)| *name);
    let missing: Vec<&str> =
        names.filter(|name| *name != "rosbag2" && !text.contains(name)).collect();
    assert!(missing.is_empty(), "{page} does not name {missing:?}");
}

/// The table of formats is what `format_name.rs` says of each. `UPDATE_DOCS=1` writes it anew.
#[test]
fn prop_the_readme_names_every_format() {
    let source = include_str!("../src/format_name.rs");
    let row = |(format, _, endings): &(Format, &str, &[&str])| {
        let (before, _) = source.split_once(&format!("    {format:?},\n")).unwrap();
        let (_, says) = before.rsplit_once("/// ").unwrap();
        let says = says.lines().next().unwrap().trim_end_matches('.');
        let files: Vec<String> = endings.iter().map(|ending| format!("`.{ending}`")).collect();
        format!("| {says} | {} |\n", files.join(", "))
    };
    let table: String = Format::NAMES.iter().map(row).collect();
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/README.md");
    let kept = std::fs::read_to_string(path).unwrap();
    let (above, rest) = kept.split_once("|---|---|\n").unwrap();
    let (_, below) = rest.split_once("\n\n").unwrap();
    let page = format!("{above}|---|---|\n{table}\n{below}");
    if std::env::var_os("UPDATE_DOCS").is_some() {
        return std::fs::write(path, page).unwrap();
    }
    assert!(kept == page, "README.md does not name every format; write it anew with UPDATE_DOCS=1");
}
