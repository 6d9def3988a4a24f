//! What Foxglove gets of an ArduPilot log that is made here.

use foxglove_data_loader::{
    BackfillArgs, DataLoader, MessageIterator, MessageIteratorArgs, loader,
};
use seatrial_foxglove_loader::{Loader, Log};

const ROWS: u32 = 200;
const INTERVAL_US: u64 = 20_000;
const START_US: u64 = 1_000_000;

fn message(number: u8, body: &[&[u8]]) -> Vec<u8> {
    [&[0xa3, 0x95, number], &body.concat()[..]].concat()
}

fn padded(text: &str, width: usize) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    bytes.resize(width, 0);
    bytes
}

fn format(number: u8, body: u8, name: &str, codes: &str, labels: &str) -> Vec<u8> {
    let texts = [padded(name, 4), padded(codes, 16), padded(labels, 64)].concat();
    message(128, &[&[number, body + 3], &texts])
}

/// Degrees of the heading at a row: a whole number of hundredths.
fn heading_deg(row: u32) -> f64 {
    57.3 + 0.05 * f64::from(row)
}

fn fraction(row: u32) -> f64 {
    if row % 40 < 20 { 0.5 } else { -0.5 }
}

/// A DataFlash log of a boat that turns while its rudder goes from side to side.
fn dataflash() -> Vec<u8> {
    let mut log = [
        format(128, 86, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns"),
        format(2, 28, "PARM", "QNf", "TimeUS,Name,Value"),
        format(3, 72, "MSG", "QZ", "TimeUS,Message"),
        format(4, 14, "ATT", "QccC", "TimeUS,Roll,Pitch,Yaw"),
        format(5, 12, "RCOU", "QHH", "TimeUS,C1,C2"),
    ]
    .concat();
    let start = 0_u64.to_le_bytes();
    for (name, value) in [("SERVO1_FUNCTION", 26.0_f32), ("SERVO1_TRIM", 1500.0)] {
        log.extend(message(
            2,
            &[&start, &padded(name, 16), &value.to_le_bytes()],
        ));
    }
    log.extend(message(3, &[&start, &padded("ArduRover V4.5", 64)]));
    for row in 0..ROWS {
        let time = (START_US + INTERVAL_US * u64::from(row)).to_le_bytes();
        let pulse = (1500.0 + 400.0 * fraction(row)) as u16;
        let outputs: [&[u8]; 3] = [&time, &pulse.to_le_bytes(), &1500_u16.to_le_bytes()];
        log.extend(message(5, &outputs));
        let yaw = (100.0 * heading_deg(row)).round() as u16;
        log.extend(message(4, &[&time, &[0; 4], &yaw.to_le_bytes()]));
    }
    log
}

fn value(message: &loader::Message) -> f64 {
    assert_eq!(message.data[..4], [0, 1, 0, 0]);
    f64::from_le_bytes(message.data[4..].try_into().unwrap())
}

#[test]
fn io_foxglove_gets_heading_and_rudder_of_an_ardupilot_log() {
    let log = Log::read("boat.bin", dataflash()).unwrap();
    let names: Vec<&str> = log.topics.iter().map(|topic| topic.name).collect();
    assert!(
        names.starts_with(&["/heading_rad", "/rudder_fraction"]),
        "{names:?}"
    );
    let mut loader = Loader::of(log);
    let found: loader::Initialization = loader.initialize().unwrap().into();
    assert_eq!(found.time_range.start_time, 1000 * START_US);
    assert_eq!(found.schemas.len(), 1);
    assert_eq!(found.schemas[0].name, "std_msgs/msg/Float64");
    for channel in &found.channels {
        assert_eq!(channel.message_encoding, "cdr");
        assert_eq!(channel.schema_id, Some(found.schemas[0].id));
    }

    let all = |start_time, end_time| MessageIteratorArgs {
        start_time,
        end_time,
        channels: vec![0, 1],
    };
    let mut messages = loader.create_iter(all(None, None)).unwrap();
    let mut rows = [0; 2];
    let mut last_ns = 0;
    while let Some(message) = messages.next() {
        let message = message.unwrap();
        assert!(message.log_time >= last_ns);
        last_ns = message.log_time;
        let row = ((message.log_time / 1000 - START_US) / INTERVAL_US) as u32;
        let expected = match message.channel_id {
            0 => heading_deg(row).to_radians(),
            _ => fraction(row),
        };
        // Hundredths of a degree and single microseconds of a pulse are exact in the log.
        assert!(
            (value(&message) - expected).abs() < 1e-9,
            "{row}: {message:?}"
        );
        rows[usize::from(message.channel_id)] += 1;
    }
    assert_eq!(rows[0], rows[1]);
    assert!(rows[0] > ROWS - 3, "{rows:?}");
    assert_eq!(found.channels[0].message_count, Some(u64::from(rows[0])));

    // A second in the middle, and what was last before it.
    let (from, to) = (2_000_000_000, 3_000_000_000);
    let mut messages = loader.create_iter(all(Some(from), Some(to))).unwrap();
    let mut count = 0;
    while let Some(message) = messages.next() {
        assert!((from..=to).contains(&message.unwrap().log_time));
        count += 1;
    }
    assert_eq!(count, 2 * 51);
    let time = from + 1;
    let before = loader
        .get_backfill(BackfillArgs {
            time,
            channels: vec![0, 1],
        })
        .unwrap();
    assert_eq!(before.len(), 2);
    assert!(before.iter().all(|message| message.log_time == from));
}

#[test]
fn io_what_is_no_log_is_refused_in_words() {
    let refused = Log::read("boat.bin", vec![7; 1000])
        .err()
        .unwrap()
        .to_string();
    assert!(refused.contains("boat.bin"), "{refused}");
}
