//! What is written is read back exactly.
#![cfg(all(feature = "parquet", feature = "mcap"))]

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;
use std::process::Command;

use proptest::prelude::*;
use seatrial_core::{Sample, Stage, YawModel};
use seatrial_dev::python_with;
use seatrial_logs::{
    ChannelChoice, CsvWriter, Estimate, Format, McapWriter, Quantity, Row, RowWriter, Unit,
    UnitSource, open, write_csv, write_mcap, write_parquet,
};

fn optional() -> impl Strategy<Value = Option<f64>> {
    prop::option::of(prop::num::f64::NORMAL | prop::num::f64::ZERO)
}

prop_compose! {
    fn sample()(
        heading_rad in -1e3..1e3_f64,
        rudder_rad in -2.0..2.0_f64,
        surge_speed_m_s in optional(),
        depth_m in optional(),
        altitude_m in optional(),
        roll_rad in optional(),
        pitch_rad in optional(),
        yaw_rate_rad_s in optional(),
        north_m in optional(),
        east_m in optional(),
        thrust in optional(),
    ) -> Sample<f64> {
        Sample {
            time_s: 0.0,
            heading_rad, rudder_rad, surge_speed_m_s, depth_m, altitude_m, roll_rad, pitch_rad,
            yaw_rate_rad_s, north_m, east_m, thrust,
        }
    }
}

fn samples() -> impl Strategy<Value = Vec<Sample<f64>>> {
    let steps = prop::collection::vec((sample(), 1e-3..10.0_f64), 1..40);
    (steps, -1e6..1e6_f64).prop_map(|(steps, start_s)| {
        let mut time_s = start_s;
        steps
            .into_iter()
            .map(|(sample, step_s)| {
                time_s += step_s;
                Sample { time_s, ..sample }
            })
            .collect()
    })
}

/// What `open` makes of rows in a format.
fn read_back(rows: &[Row], format: Format) -> Vec<Sample<f64>> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log");
    let file = File::create(&path).map(BufWriter::new).unwrap();
    match format {
        Format::Csv => write_csv(file, rows),
        Format::Parquet => write_parquet(file, rows),
        _ => write_mcap(file, rows),
    }
    .unwrap();
    let mut reader = open(&path, &ChannelChoice::default()).unwrap();
    let description = reader.description();
    assert_eq!(description.format, format);
    let channels = &description.channels;
    assert!(channels.iter().all(|c| c.unit_source == UnitSource::Stated));
    let samples = reader.by_ref().collect::<Result<_, _>>().unwrap();
    assert_eq!(reader.warnings(), [""; 0]);
    samples
}

fn rows_of(samples: &[Sample<f64>]) -> Vec<Row> {
    samples.iter().copied().map(Row::from).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn io_samples_come_back_bit_for_bit(samples in samples()) {
        for format in [Format::Csv, Format::Parquet] {
            prop_assert_eq!(&read_back(&rows_of(&samples), format), &samples);
        }
    }

    /// MCAP counts whole nanoseconds from 1970.
    #[test]
    fn io_samples_at_whole_nanoseconds_come_back_from_mcap_bit_for_bit(samples in samples()) {
        let samples: Vec<_> = samples
            .into_iter()
            .map(|sample| Sample {
                time_s: ((sample.time_s + 1e6) * 1e9).round() / 1e9,
                ..sample
            })
            .collect();
        prop_assert_eq!(&read_back(&rows_of(&samples), Format::Mcap), &samples);
    }
}

/// A run of a trial with gaps in its depth and an estimate while it trains.
fn trial(count: u32) -> Vec<Row> {
    (0..count)
        .map(|k| Row {
            sample: Sample {
                time_s: f64::from(k) * 0.05,
                heading_rad: f64::from(k % 700) * 0.004,
                rudder_rad: if k % 80 < 40 { 0.2 } else { -0.2 },
                depth_m: (k % 5 == 0).then_some(2.0),
                ..Sample::default()
            },
            stage: [None, Some(Stage::Settle), Some(Stage::Train)][(k * 3 / count) as usize],
            estimate: (k * 3 / count == 2).then(|| Estimate {
                model: YawModel::from_theta([-1.0, f64::from(k), 0.01]),
                half_widths: (k % 20 == 0).then_some([0.1, 0.2, 0.003]),
                step_norm: 1e-3,
            }),
        })
        .collect()
}

#[test]
fn io_long_trials_come_back_from_every_format() {
    let rows = trial(150_000);
    let samples: Vec<_> = rows.iter().map(|row| row.sample).collect();
    for format in [Format::Csv, Format::Parquet] {
        assert_eq!(read_back(&rows, format), samples);
    }
    for (read, sample) in read_back(&rows, Format::Mcap).iter().zip(&samples) {
        // Half a nanosecond.
        assert!((read.time_s - sample.time_s).abs() <= 0.51e-9);
        assert_eq!(Sample { time_s: sample.time_s, ..*read }, *sample);
    }
}

/// Killed: nothing was written after the last flush.
#[test]
fn io_what_was_flushed_survives() {
    let folder = tempfile::tempdir().unwrap();
    let rows = trial(1000);
    for name in ["log.csv", "log.mcap"] {
        let path = folder.path().join(name);
        let file = File::create(&path).map(BufWriter::new).unwrap();
        let mut writer: Box<dyn RowWriter> = match name {
            "log.csv" => Box::new(CsvWriter::new(file).unwrap()),
            _ => Box::new(McapWriter::new(file).unwrap()),
        };
        for second in rows.chunks(20) {
            second.iter().for_each(|row| writer.write(row).unwrap());
            writer.flush().unwrap();
        }
        let killed = folder.path().join("killed");
        std::fs::copy(&path, &killed).unwrap();
        let read = |path: &Path| {
            let mut reader = open(path, &ChannelChoice::default()).unwrap();
            let samples: Vec<_> = reader.by_ref().map(Result::unwrap).collect();
            (samples, reader.warnings().join("\n"))
        };
        let (samples, warnings) = read(&killed);
        assert_eq!(samples.len(), 1000, "{name}");
        // A CSV file has no end that could be missing.
        assert_eq!(warnings.contains("cut off"), name == "log.mcap", "{warnings}");
        writer.finish().unwrap();
        assert_eq!(read(&path), (samples, String::new()));
    }
}

/// The estimate is there as numbers of its own columns, and nothing takes it for a measurement.
#[test]
fn io_estimates_are_columns() {
    let rows = trial(300);
    let mut csv = Vec::new();
    write_csv(&mut csv, &rows).unwrap();
    let text = String::from_utf8(csv).unwrap();
    let line = |number: usize| text.lines().nth(number).unwrap();
    assert_eq!(
        line(0),
        "time_s,heading_rad,rudder_rad,depth_m,stage,estimate_a22_per_s,estimate_b2_per_s2,\
         estimate_c0_rad_per_s2,half_width_a22_per_s,half_width_b2_per_s2,half_width_c0_rad_per_s2,\
         estimate_step_norm"
    );
    assert_eq!(line(1), "0,0,0.2,2,,,,,,,,");
    assert_eq!(line(221), "11,0.88,-0.2,2,2,-1,220,0.01,0.1,0.2,0.003,0.001");
    assert_eq!(line(222), "11.05,0.884,-0.2,,2,-1,221,0.01,,,,0.001");
    for format in [Format::Csv, Format::Parquet, Format::Mcap] {
        let column =
            ["estimate_b2_per_s2", "estimate_b2_per_s2.data"][usize::from(format == Format::Mcap)];
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log");
        let file = File::create(&path).unwrap();
        match format {
            Format::Csv => write_csv(file, &rows),
            Format::Parquet => write_parquet(file, &rows),
            _ => write_mcap(file, &rows),
        }
        .unwrap();
        let mut as_depth = ChannelChoice::default();
        as_depth.columns = BTreeMap::from([(Quantity::Depth, column.to_string())]);
        as_depth.units = BTreeMap::from([(Quantity::Depth, Unit::Metre)]);
        let read = open(&path, &as_depth).unwrap().map(Result::unwrap);
        let depths: Vec<_> = read.map(|sample| sample.depth_m).collect();
        let expected: Vec<_> = rows.iter().map(|row| Some(row.estimate?.model.b2_per_s2)).collect();
        assert_eq!(depths, expected, "{format:?}");
    }
}

/// The Python library of the format and that of ROS 2 messages.
#[test]
fn val_mcap_ros2_support_reads_the_same_numbers() {
    const PROGRAM: &str = "
import sys
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
reader = make_reader(open(sys.argv[1], 'rb'), decoder_factories=[DecoderFactory()])
for schema, channel, message, decoded in reader.iter_decoded_messages():
    print(channel.topic, schema.name, message.log_time, repr(decoded.data))
";
    let Some(python) = python_with("mcap_ros2") else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.mcap");
    let rows = trial(300);
    write_mcap(File::create(&path).unwrap(), &rows).unwrap();
    let output =
        Command::new(python).args(["-c", PROGRAM, path.to_str().unwrap()]).output().unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    let mut found = BTreeMap::new();
    for line in String::from_utf8(output.stdout).unwrap().lines() {
        let fields: Vec<&str> = line.split(' ').collect();
        let [topic, type_name, time_ns, value] = fields[..] else {
            panic!("{line}");
        };
        assert_eq!(type_name, "std_msgs/msg/Float64");
        let message: (u64, f64) = (time_ns.parse().unwrap(), value.parse().unwrap());
        found.entry(topic.to_string()).or_insert_with(Vec::new).push(message);
    }
    let expected = |value: fn(&Row) -> Option<f64>| -> Vec<(u64, f64)> {
        rows.iter()
            .enumerate()
            .filter_map(|(k, row)| Some((50_000_000 * k as u64, value(row)?)))
            .collect()
    };
    assert_eq!(found["/heading_rad"], expected(|r| Some(r.sample.heading_rad)));
    assert_eq!(found["/rudder_rad"], expected(|r| Some(r.sample.rudder_rad)));
    let b2 = expected(|r| Some(r.estimate?.model.b2_per_s2));
    assert_eq!(found["/estimate_b2_per_s2"], b2);
    // A depth every fifth row, followed by one that says there is none.
    let depths = &found["/depth_m"];
    assert_eq!(depths.len(), 120);
    for (k, (time_ns, depth)) in depths.iter().enumerate() {
        assert_eq!(*time_ns, 50_000_000 * (5 * (k as u64 / 2) + k as u64 % 2));
        assert!(if k % 2 == 0 { *depth == 2.0 } else { depth.is_nan() });
    }
}

#[test]
fn io_a_time_before_1970_is_refused_by_mcap() {
    let row = Row::from(Sample { time_s: -1.0, ..Sample::default() });
    let error = write_mcap(Vec::new(), &[row]).unwrap_err();
    assert!(error.to_string().contains("1970"), "{error}");
}

#[test]
fn io_sha256_is_of_the_whole_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log");
    std::fs::write(&path, "t,yaw,rudder\n0,0,0.1\n").unwrap();
    let mut reader = open(&path, &ChannelChoice::default()).unwrap();
    assert_eq!(reader.by_ref().count(), 1);
    // From sha256sum.
    assert_eq!(
        reader.sha256().unwrap(),
        "4b3e8f824ea56a930a22213249ae3493dfe291454182db5f154a5060ded08f1e"
    );
}
