//! MCAP and rosbag2 files with ROS 2 messages.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::Path;
use std::time::{Duration, Instant};

use mcap::records::MessageHeader;
use seatrial_core::{Real, Sample};
use seatrial_logs::{ChannelChoice, Fault, LogReader, Quantity, ReadError, Unit, open};

const IMU: &str = "std_msgs/Header header
geometry_msgs/Quaternion orientation
float64[9] orientation_covariance # row major about x, y, z
geometry_msgs/Vector3 angular_velocity
float64[9] angular_velocity_covariance
geometry_msgs/Vector3 linear_acceleration
float64[9] linear_acceleration_covariance
================================================================================
MSG: geometry_msgs/Quaternion
float64 x 0
float64 y 0
float64 z 0
float64 w 1
================================================================================
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id";

const JOINTS: &str = "std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
=====
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id";

const FLOAT64: &str = "uint8 UNUSED=3\nfloat64 data";

/// Imu and JointState as rosbags 0.11.9 writes them.
const IMU_OF_ROSBAGS: &str = "\
    000100000420266a80b2e60e04000000696d7500000000000000000000000000000000002beb78406b71c43f5956bb79d896\
    ef3f000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000\
    00000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000c0bf0000\
    0000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000\
    0000000000000000000000000000000000000000000000000000000000000000000000001f85eb51b89e2340000000000000\
    0000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000\
    00000000000000000000000000000000";
const JOINTS_OF_ROSBAGS: &str = "\
    000100000420266a80b2e60e0400000061626300020000000700000072756464657200000a000000626f7720706c616e6500\
    00000200000000000000000000000000d03f000000000000e0bf0300000000000000000000000000f03f0000000000000040\
    000000000000084000000000";

const START_NS: u64 = 1_780_883_460_000_000_000;

fn bytes(hexadecimal: &str) -> Vec<u8> {
    let digits = hexadecimal.as_bytes().chunks(2);
    digits.map(|pair| u8::from_str_radix(std::str::from_utf8(pair).unwrap(), 16).unwrap()).collect()
}

/// Topic, type, definition and messages with their times of recording, ns.
type Topic<'a> = (&'a str, &'a str, &'a str, Vec<(u64, Vec<u8>)>);

fn mcap_file(topics: &[Topic]) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    let mut writer = mcap::WriteOptions::new().chunk_size(Some(4096)).create(&mut file).unwrap();
    let mut messages = Vec::new();
    for (topic, type_name, definition, of_topic) in topics {
        let schema = writer.add_schema(type_name, "ros2msg", definition.as_bytes()).unwrap();
        let channel = writer.add_channel(schema, topic, "cdr", &BTreeMap::new()).unwrap();
        messages.extend(of_topic.iter().map(|(time, data)| (*time, channel, data)));
    }
    messages.sort_by_key(|(time, ..)| *time);
    for (log_time, channel_id, data) in messages {
        let header = MessageHeader { channel_id, sequence: 0, log_time, publish_time: log_time };
        writer.write_to_known_channel(&header, data).unwrap();
    }
    writer.finish().unwrap();
    drop(writer);
    file.into_inner()
}

fn bag_file(path: &Path, topics: &[Topic], has_definitions: bool) {
    let bag = rusqlite::Connection::open(path).unwrap();
    bag.execute_batch(
        "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT);
         CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB);",
    )
    .unwrap();
    if has_definitions {
        bag.execute_batch(
            "CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT, encoding TEXT,
             encoded_message_definition TEXT, type_description_hash TEXT);",
        )
        .unwrap();
    }
    let mut messages = Vec::new();
    for (number, (topic, type_name, definition, of_topic)) in (0_i64..).zip(topics) {
        bag.execute("INSERT INTO topics VALUES (?1, ?2, ?3, 'cdr')", (number, topic, type_name))
            .unwrap();
        if has_definitions {
            bag.execute(
                "INSERT INTO message_definitions VALUES (?1, ?2, 'ros2msg', ?3, '')",
                (number, type_name, definition),
            )
            .unwrap();
        }
        messages.extend(of_topic.iter().map(|(time, data)| (*time as i64, number, data)));
    }
    messages.sort_by_key(|(time, ..)| *time);
    for message in messages {
        bag.execute("INSERT INTO messages(timestamp, topic_id, data) VALUES (?1, ?2, ?3)", message)
            .unwrap();
    }
}

/// A message with its numbers at their places in `IMU_OF_ROSBAGS`: 4 bytes of encapsulation, stamp, `imu`.
fn imu(time_ns: u64, heading_rad: f64, yaw_rate_rad_s: f64) -> Vec<u8> {
    let mut message = bytes(IMU_OF_ROSBAGS);
    let mut put = |at: usize, bytes: &[u8]| message[4 + at..][..bytes.len()].copy_from_slice(bytes);
    put(0, &((time_ns / 1_000_000_000) as u32).to_le_bytes());
    put(4, &((time_ns % 1_000_000_000) as u32).to_le_bytes());
    let half_rad = 0.5 * (std::f64::consts::FRAC_PI_2 - heading_rad);
    put(16 + 16, &Real::sin(half_rad).to_le_bytes());
    put(16 + 24, &Real::cos(half_rad).to_le_bytes());
    put(16 + 32 + 72 + 16, &(-yaw_rate_rad_s).to_le_bytes());
    message
}

fn float64(value: f64) -> Vec<u8> {
    [&[0, 1, 0, 0], &value.to_le_bytes()[..]].concat()
}

fn heading_rad(k: u64) -> f64 {
    2.0 + 0.3 * Real::sin(0.1 * k as f64)
}

fn rudder_rad(k: u64) -> f64 {
    if k % 40 < 20 { 0.25 } else { -0.25 }
}

/// 100 headings, stamped 20 ms before they are recorded; a rudder 5 ms before each of these stamps.
fn run() -> Vec<Topic<'static>> {
    let step_ns = 50_000_000;
    let times = |from_ns: u64| (0..100).map(move |k| (k, START_NS + from_ns + k * step_ns));
    vec![
        (
            "/imu/data",
            "sensor_msgs/msg/Imu",
            IMU,
            times(10_000_000)
                .map(|(k, time)| (time + 20_000_000, imu(time, heading_rad(k), 0.5)))
                .collect(),
        ),
        (
            "/rudder/angle",
            "std_msgs/msg/Float64",
            FLOAT64,
            times(5_000_000).map(|(k, time)| (time, float64(rudder_rad(k)))).collect(),
        ),
        (
            "/joints",
            "sensor_msgs/msg/JointState",
            JOINTS,
            times(0).map(|(_, time)| (time, bytes(JOINTS_OF_ROSBAGS))).collect(),
        ),
    ]
}

fn read_bytes(bytes: &[u8]) -> Result<(LogReader, Vec<Sample<f64>>), ReadError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log");
    std::fs::write(&path, bytes).unwrap();
    read(&path, &ChannelChoice::default())
}

fn read(path: &Path, choice: &ChannelChoice) -> Result<(LogReader, Vec<Sample<f64>>), ReadError> {
    let mut reader = open(path, choice)?;
    let samples = reader.by_ref().collect::<Result<_, _>>()?;
    Ok((reader, samples))
}

fn assert_is_the_run(reader: &LogReader, samples: &[Sample<f64>]) {
    let names: Vec<&str> =
        reader.description().channels.iter().map(|channel| channel.column.as_str()).collect();
    assert_eq!(names[..3], ["time_s", "imu/data.orientation.heading_rad", "rudder/angle.data"]);
    assert!(reader.warnings().is_empty(), "{:?}", reader.warnings());
    assert_eq!(samples.len(), 100);
    for (k, sample) in (0..).zip(samples) {
        // Epochs in s are doubles of 0.2 us.
        assert!((sample.time_s - 0.05 * k as f64).abs() < 1e-6);
        assert!((sample.heading_rad - heading_rad(k)).abs() < 1e-12);
        assert_eq!(sample.yaw_rate_rad_s, Some(0.5));
        // 45 of the 50 ms until the next sample the rudder is where it was laid 5 ms before.
        let next = rudder_rad((k + 1).min(99));
        let expected = (45.0 * rudder_rad(k) + 5.0 * next) / 50.0;
        assert!((sample.rudder_rad - expected).abs() < 1e-5, "{k}: {}", sample.rudder_rad);
    }
}

#[test]
fn io_mcap_with_an_imu_and_a_rudder_topic() {
    let (reader, samples) = read_bytes(&mcap_file(&run())).unwrap();
    assert_is_the_run(&reader, &samples);
}

#[test]
fn io_rosbag2_with_and_without_definitions() {
    let folder = tempfile::tempdir().unwrap();
    for (name, has_definitions) in [("new", true), ("old", false)] {
        let path = folder.path().join(name);
        let mut topics = run();
        if !has_definitions {
            topics.truncate(2);
        }
        bag_file(&path, &topics, has_definitions);
        let (reader, samples) = read(&path, &ChannelChoice::default()).unwrap();
        assert_is_the_run(&reader, &samples);
    }
}

#[test]
fn io_rosbag2_whose_messages_are_packed_one_by_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("packed");
    let mut topics = run();
    for (_, data) in topics.iter_mut().flat_map(|topic| &mut topic.3) {
        *data = zstd::bulk::compress(data, 3).unwrap();
    }
    bag_file(&path, &topics, true);
    let (reader, samples) = read(&path, &ChannelChoice::default()).unwrap();
    assert_is_the_run(&reader, &samples);
}

/// Of a recording that was killed: all that was written is in the file beside it.
#[test]
fn io_rosbag2_with_a_write_ahead_log_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    let [live, killed] = ["live.db3", "killed.db3"].map(|name| folder.path().join(name));
    // While this connection is open, that of the writer leaves the file alone when it closes.
    let recording = rusqlite::Connection::open(&live).unwrap();
    recording
        .execute_batch("PRAGMA journal_mode = WAL; CREATE TABLE metadata(id INTEGER PRIMARY KEY);")
        .unwrap();
    bag_file(&live, &run(), true);
    for suffix in ["", "-wal"] {
        let [from, to] = [&live, &killed].map(|path| format!("{}{suffix}", path.display()));
        std::fs::copy(from, to).unwrap();
    }
    let (reader, samples) = read(&killed, &ChannelChoice::default()).unwrap();
    assert_is_the_run(&reader, &samples);
}

/// A field of a message that rosbags wrote, through the channels of heading and rudder.
fn value(topics: &[Topic], column: &str) -> f64 {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log");
    std::fs::write(&path, mcap_file(topics)).unwrap();
    let both = [Quantity::Heading, Quantity::Rudder];
    let mut choice = ChannelChoice::default();
    choice.columns = BTreeMap::from(both.map(|quantity| (quantity, column.to_string())));
    choice.units = BTreeMap::from(both.map(|quantity| (quantity, Unit::Radian)));
    read(&path, &choice).unwrap().1[0].heading_rad
}

/// The numbers that were given to rosbags 0.11.9.
#[test]
fn val_rosbags_writes_what_is_read() {
    let one = |data: &str| vec![(START_NS, bytes(data))];
    let topics = [
        ("/i", "sensor_msgs/msg/Imu", IMU, one(IMU_OF_ROSBAGS)),
        ("/j", "sensor_msgs/msg/JointState", JOINTS, one(JOINTS_OF_ROSBAGS)),
    ];
    for (column, expected) in [
        ("i.header.stamp.sec", 1_780_883_460.0),
        ("i.header.stamp.nanosec", 250_000_000.0),
        ("i.orientation.heading_rad", 1.25),
        ("i.angular_velocity.yaw_rate_rad_s", 0.125),
        ("i.linear_acceleration.z", 9.81),
        ("i.linear_acceleration_covariance[8]", 0.0),
        ("j.position[0]", 0.25),
        ("j.position[1]", -0.5),
        ("j.velocity[2]", 3.0),
    ] {
        let found = value(&topics, column);
        // A heading passes through sines.
        assert!((found - expected).abs() < 1e-14, "{column}: {found}");
    }
}

#[test]
fn io_a_cut_mcap_gives_everything_before_the_cut_and_says_so() {
    let whole = mcap_file(&run());
    let (_, all) = read_bytes(&whole).unwrap();
    let (reader, samples) = read_bytes(&whole[..whole.len() / 2]).unwrap();
    assert!(samples.len() > 20, "{}", samples.len());
    let certain = samples.len() - 1;
    assert_eq!(samples[..certain], all[..certain]);
    let warnings = reader.warnings();
    assert!(warnings.iter().any(|w| w.contains("cut off")), "{warnings:?}");
}

/// What is read without a word about damage is what was written, whatever bit was flipped.
#[test]
fn io_a_flipped_bit_of_an_mcap_changes_no_sample_in_silence() {
    let whole = mcap_file(&run());
    let (reader, all) = read_bytes(&whole).unwrap();
    assert!(!reader.counts().is_damaged, "{:?}", reader.warnings());
    let (mut told, mut rest) = (0, 0);
    for k in 0..600 {
        let at = k * 7919 % whole.len();
        let mut flipped = whole.clone();
        flipped[at] ^= 1 << (k % 8);
        let Ok((reader, samples)) = read_bytes(&flipped) else {
            told += 1;
            continue;
        };
        if reader.counts().is_damaged {
            let warnings = reader.warnings().join(" ");
            assert!(warnings.contains("MCAP: "), "{warnings}");
            told += 1;
            rest += usize::from(samples.len() > 20);
        } else {
            assert_eq!(samples, all, "bit {} of byte {at}", k % 8);
        }
    }
    assert!(told > 400 && rest > 200, "{told} told, {rest} with the rest of the file");
}

#[test]
fn io_mcap_of_other_encodings_is_refused_by_name() {
    let mut file = Cursor::new(Vec::new());
    let mut writer = mcap::Writer::new(&mut file).unwrap();
    let channel = writer.add_channel(0, "/pose", "json", &BTreeMap::new()).unwrap();
    let header = MessageHeader {
        channel_id: channel,
        sequence: 0,
        log_time: START_NS,
        publish_time: START_NS,
    };
    writer.write_to_known_channel(&header, b"{}").unwrap();
    writer.finish().unwrap();
    drop(writer);
    let error = read_bytes(&file.into_inner()).err().unwrap();
    assert!(matches!(error.fault, Fault::NothingToRead { .. }));
    assert!(error.to_string().contains("/pose (json)"), "{error}");
}

#[test]
fn io_damaged_mcap_and_rosbag2_never_panic_and_end_soon() {
    let folder = tempfile::tempdir().unwrap();
    let bag = folder.path().join("bag");
    bag_file(&bag, &run(), true);
    let mut state = 1_u64;
    let mut below = |limit: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (state >> 33) as usize % limit
    };
    for whole in [mcap_file(&run()), std::fs::read(&bag).unwrap()] {
        for _ in 0..120 {
            let mut bytes = whole.clone();
            for _ in 0..=below(10) {
                let at = below(bytes.len());
                bytes[at] ^= 1 << below(8);
            }
            if below(3) == 0 {
                bytes.truncate(below(bytes.len()));
            }
            let begun = Instant::now();
            // What is left of a damaged file is its format's business; that reading returns is what counts.
            let _ = read_bytes(&bytes);
            assert!(begun.elapsed() < Duration::from_secs(2));
        }
    }
}

/// Outputs of an autopilot: which one steers is not in the bag; one of them, or two of which the difference steers.
#[test]
fn io_pulses_of_mavros_are_refused_until_one_or_two_are_named() {
    const PULSES: &str = "std_msgs/Header header\nuint16[] channels\n=====\nMSG: std_msgs/Header\n\
        builtin_interfaces/Time stamp\nstring frame_id";
    let pulses = |k: u64| {
        let mut message = vec![0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0];
        message.extend(3_u32.to_le_bytes());
        message.extend([1600 + k as u16, 1500, 1400].iter().flat_map(|p| p.to_le_bytes()));
        (START_NS + k * 50_000_000, message)
    };
    let mut topics = run();
    topics[1] = ("/mavros/rc/out", "mavros_msgs/msg/RCOut", PULSES, (0..100).map(pulses).collect());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log");
    std::fs::write(&path, mcap_file(&topics)).unwrap();
    let refused = read(&path, &ChannelChoice::default()).err().unwrap();
    let hint = "--rudder mavros/rc/out.channels[0] --unit rudder=pwm";
    assert!(refused.to_string().contains(hint), "{refused}");

    let units = BTreeMap::from([(Quantity::Rudder, Unit::PulseWidth)]);
    let channel = |n: usize| format!("mavros/rc/out.channels[{n}]");
    let mut one = ChannelChoice::default();
    one.columns = BTreeMap::from([(Quantity::Rudder, channel(0))]);
    one.units = units.clone();
    let mut both = ChannelChoice::default();
    both.half_differences = BTreeMap::from([(Quantity::Rudder, [0, 2].map(channel))]);
    both.units = units;
    // Messages come 10 ms before their headings: the mean holds a fifth of the next pulse.
    for (choice, expected_us) in [(one, 104.2), (both, 102.1)] {
        let (_, samples) = read(&path, &choice).unwrap();
        // Epochs in s are doubles of 0.2 us.
        let found_us = 400.0 * samples[4].rudder_rad;
        assert!((found_us - expected_us).abs() < 1e-4, "{found_us}");
    }
}
