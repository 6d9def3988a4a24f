//! What is written is read back exactly.
#![cfg(feature = "parquet")]

use proptest::prelude::*;
use seatrial_core::Sample;
use seatrial_io::{ChannelChoice, Format, UnitSource, open, write_csv, write_parquet};

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

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn io_samples_come_back_bit_for_bit(samples in samples()) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log");
        for format in [Format::Csv, Format::Parquet] {
            let file = std::fs::File::create(&path).unwrap();
            if format == Format::Csv {
                write_csv(file, &samples).unwrap();
            } else {
                write_parquet(file, &samples).unwrap();
            }
            let mut reader = open(&path, &ChannelChoice::default()).unwrap();
            let description = reader.description();
            prop_assert_eq!(description.format, format);
            prop_assert!(description.channels.iter().all(|c| c.unit_source == UnitSource::Stated));
            let read: Vec<_> = reader.by_ref().collect::<Result<_, _>>().unwrap();
            prop_assert_eq!(&read, &samples);
        }
    }
}

#[test]
fn io_parquet_of_several_row_groups_comes_back() {
    let samples: Vec<Sample<f64>> = (0..150_000)
        .map(|k| Sample {
            time_s: f64::from(k) * 0.05,
            heading_rad: f64::from(k % 700) * 0.004,
            rudder_rad: if k % 80 < 40 { 0.2 } else { -0.2 },
            depth_m: (k % 5 == 0).then_some(2.0),
            ..Sample::default()
        })
        .collect();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log");
    write_parquet(std::fs::File::create(&path).unwrap(), &samples).unwrap();
    let reader = open(&path, &ChannelChoice::default()).unwrap();
    let read: Vec<_> = reader.collect::<Result<_, _>>().unwrap();
    assert_eq!(read, samples);
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
