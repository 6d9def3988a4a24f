//! Small sound logs of every format, built by hand: what fuzzing and the tests of damage start from.
#![allow(missing_docs, dead_code)]

#[path = "boxes.rs"]
pub mod boxes;
#[path = "captures.rs"]
pub mod captures;
#[path = "nmea2000.rs"]
pub mod nmea2000;

use std::collections::BTreeMap;
use std::io::Cursor;

use mcap::records::MessageHeader;
use parquet::basic::{Compression, GzipLevel, ZstdLevel};
use parquet::data_type::DoubleType;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;

use captures::{blocks_of_datagrams, datagrams};
pub use captures::{dataflash_text, long, lsf, pcap, sparse};
use nmea2000::nmea2000;

/// Samples of a sound log.
pub const ROWS: u32 = 6;

/// Every format, and the bytes before those that fuzzing changes.
pub const FORMATS: &[(&str, &[u8])] = &[
    ("dataflash", &[0xa3, 0x95, 0x80]),
    ("tlog", b""),
    ("ulog", b"ULog\x01\x12\x35"),
    ("canboat", b""),
    ("slocum", b"dbd_label:"),
    ("lsf", b"\x54\xfe"),
    ("nmea0183", b""),
    ("alog", b"%%"),
    ("expedition", b""),
    ("csv", b""),
    ("mcap", b"\x89MCAP0\r\n"),
    ("rosbag2", b"SQLite format 3\0"),
    ("parquet", b"PAR1"),
    ("rosbag1", b"#ROSBAG V2.0\n"),
    ("xlsx", b"PK\x03\x04"),
    ("mat", b"MATLAB 5.0 MAT-file"),
    ("signal_k", b"{"),
];

/// Logs of a format.
pub fn of(format: &str) -> Vec<Vec<u8>> {
    match format {
        "dataflash" => vec![dataflash(), dataflash_text().into_bytes()],
        "tlog" => vec![tlog()],
        "ulog" => vec![ulog()],
        "canboat" => nmea2000(),
        "slocum" => vec![slocum()],
        "lsf" => vec![lsf()],
        "nmea0183" => {
            vec![nmea0183(), nmea0183_without_times(), datagrams(), blocks_of_datagrams()]
        }
        "alog" => vec![alog()],
        "expedition" => vec![expedition()],
        "csv" => vec![
            csv(),
            long(),
            boxes::topics(),
            sparse(),
            boxes::key_value(),
            boxes::objects(),
            boxes::glider(),
        ],
        "mcap" => {
            [None, Some(mcap::Compression::Lz4), Some(mcap::Compression::Zstd)].map(mcap_log).into()
        }
        "rosbag2" => vec![rosbag()],
        "rosbag1" => ["none", "bz2", "lz4"].map(boxes::rosbag1).into(),
        "signal_k" => vec![boxes::signal_k(), boxes::signal_k_array()],
        "xlsx" => vec![boxes::xlsx()],
        "mat" => [false, true].map(boxes::mat).into(),
        "parquet" => [
            Compression::UNCOMPRESSED,
            Compression::SNAPPY,
            Compression::GZIP(GzipLevel::default()),
            Compression::ZSTD(ZstdLevel::default()),
        ]
        .map(parquet_log)
        .into(),
        other => panic!("no seeds of {other}"),
    }
}

fn heading_rad(k: u32) -> f32 {
    1.0 + 0.01 * k as f32
}

fn padded(text: &str, width: usize) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    bytes.resize(width, 0);
    bytes
}

pub fn dataflash() -> Vec<u8> {
    let message = |number: u8, body: &[u8]| [&[0xa3, 0x95, number], body].concat();
    let format = |number: u8, body: u8, name: &str, codes: &str, labels: &str| {
        let head = [number, body + 3];
        let texts = [padded(name, 4), padded(codes, 16), padded(labels, 64)].concat();
        message(128, &[&head, &texts[..]].concat())
    };
    let mut log = [
        format(128, 86, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns"),
        format(1, 41, "FMTU", "QBNN", "TimeUS,FmtType,UnitIds,MultIds"),
        format(2, 28, "PARM", "QNf", "TimeUS,Name,Value"),
        format(3, 72, "MSG", "QZ", "TimeUS,Message"),
        format(4, 18, "ATT", "QccCf", "TimeUS,Roll,Pitch,Yaw,AEKF"),
        format(5, 12, "RCOU", "QHH", "TimeUS,C1,C2"),
        format(6, 18, "IMU", "QBBff", "TimeUS,I,Z,GyrZ,T"),
        format(7, 18, "GPS", "QBBLe", "TimeUS,I,Z,Lat,Spd"),
    ]
    .concat();
    let units = [&0_u64.to_le_bytes()[..], &[6], &padded("s#-E", 16), &padded("F---", 16)];
    log.extend(message(1, &units.concat()[..41]));
    for (name, value) in [("SERVO1_FUNCTION", 26.0_f32), ("SERVO1_TRIM", 1490.0)] {
        let time = 0_u64.to_le_bytes();
        log.extend(message(2, &[&time[..], &padded(name, 16), &value.to_le_bytes()].concat()));
    }
    log.extend(message(3, &[&[0; 8][..], &padded("ArduRover V4.5", 64)].concat()));
    for k in 0..ROWS {
        let time = (1_000_000 + 20_000 * u64::from(k)).to_le_bytes();
        let yaw = (5730 + 57 * k) as u16;
        log.extend(message(
            5,
            &[&time[..], &1600_u16.to_le_bytes(), &1500_u16.to_le_bytes()].concat(),
        ));
        let angles = [&100_i16.to_le_bytes()[..], &[0; 2], &yaw.to_le_bytes()].concat();
        log.extend(message(4, &[&time[..], &angles, &[0; 4]].concat()));
        log.extend(message(
            6,
            &[&time[..], &[(k % 2) as u8, 0], &0.5_f32.to_le_bytes(), &[0; 4]].concat(),
        ));
    }
    log
}

/// Messages of [`tlog_frame`]: number and seed of the checksum.
pub const MAVLINK: [(u32, u8); 10] = [
    (0, 50),
    (2, 137),
    (22, 220),
    (30, 39),
    (32, 185),
    (33, 104),
    (34, 237),
    (36, 222),
    (65, 118),
    (74, 20),
];

/// A sound frame behind its time of arrival; version 1 or 2.
pub fn tlog_frame(arrival_us: u64, is_second: bool, message: (u32, u8), payload: &[u8]) -> Vec<u8> {
    let (id, seed) = message;
    let length = payload.len() as u8;
    let mut checked = match is_second {
        true => vec![length, 0, 0, 7, 1, 1, id as u8, (id >> 8) as u8, 0],
        false => vec![length, 7, 1, 1, id as u8],
    };
    checked.extend(payload);
    let mut sum = 0xffff_u16;
    for byte in checked.iter().chain([&seed]) {
        let mut bits = byte ^ (sum & 0xff) as u8;
        bits ^= bits << 4;
        let wide = u16::from(bits);
        sum = (sum >> 8) ^ (wide << 8) ^ (wide << 3) ^ (wide >> 4);
    }
    let mark = if is_second { 0xfd } else { 0xfe };
    [&arrival_us.to_be_bytes()[..], &[mark], &checked, &sum.to_le_bytes()].concat()
}

pub const ARRIVAL_US: u64 = 1_700_000_000_000_000;

pub fn tlog() -> Vec<u8> {
    let mut log = tlog_frame(ARRIVAL_US, true, MAVLINK[0], &[0, 0, 0, 0, 11, 3, 0, 4, 3]);
    let parameter =
        [&26.0_f32.to_le_bytes()[..], &[1, 0, 0, 0], &padded("SERVO1_FUNCTION", 16), &[9]];
    log.extend(tlog_frame(ARRIVAL_US, false, MAVLINK[2], &parameter.concat()));
    for k in 0..ROWS {
        let boot_ms = 5000 + 20 * k;
        let arrival_us = ARRIVAL_US + 20_000 * u64::from(k);
        let mut servos = (1000 * boot_ms).to_le_bytes().to_vec();
        servos.extend([1600_u16; 8].iter().flat_map(|pulse| pulse.to_le_bytes()));
        servos.push(0);
        log.extend(tlog_frame(arrival_us, k % 2 == 0, MAVLINK[7], &servos));
        let mut attitude = boot_ms.to_le_bytes().to_vec();
        for value in [0.1, 0.2, heading_rad(k), 0.0, 0.0, 0.5] {
            attitude.extend(value.to_le_bytes());
        }
        log.extend(tlog_frame(arrival_us, k % 2 == 1, MAVLINK[3], &attitude));
        log.extend(tlog_frame(arrival_us, true, MAVLINK[9], &[0; 19]));
    }
    log
}

pub fn ulog() -> Vec<u8> {
    let message =
        |kind: u8, body: &[u8]| [&(body.len() as u16).to_le_bytes()[..], &[kind], body].concat();
    let mut log = b"ULog\x01\x12\x35\x01\0\0\0\0\0\0\0\0".to_vec();
    log.extend(message(b'B', &[0; 40]));
    for format in [
        "vehicle_attitude:uint64_t timestamp;float[4] q;uint8_t[4] _padding0;",
        "actuator_controls_0:uint64_t timestamp;float[8] control;pair_s p;",
        "pair_s:int16_t a;bool b;char[3] c;",
    ] {
        log.extend(message(b'F', format.as_bytes()));
    }
    let key = b"int32_t MAV_TYPE";
    let parameter = [&[key.len() as u8][..], key, &12_i32.to_le_bytes()];
    log.extend(message(b'P', &parameter.concat()));
    log.extend(message(b'A', b"\0\x01\0vehicle_attitude"));
    log.extend(message(b'A', b"\0\x02\0actuator_controls_0"));
    for k in 0..ROWS {
        let time = (1_000_000 + 20_000 * u64::from(k)).to_le_bytes();
        let mut controls = [&[2, 0], &time[..]].concat();
        controls.extend([0.25_f32; 8].iter().flat_map(|value| value.to_le_bytes()));
        controls.extend([0; 6]);
        log.extend(message(b'D', &controls));
        let mut attitude = [&[1, 0], &time[..]].concat();
        let half_rad = 0.5 * heading_rad(k);
        for value in [half_rad.cos(), 0.0, 0.0, half_rad.sin()] {
            attitude.extend(value.to_le_bytes());
        }
        log.extend(message(b'D', &attitude));
    }
    log.extend(message(b'O', &[10, 0]));
    log.extend(message(b'S', &[0x2f, 0x73, 0x13, 0x20, 0x25, 0x0c, 0xbb, 0x12]));
    log
}

pub fn expedition() -> Vec<u8> {
    let mut log = String::from("!Boat,Utc,BSP,RudderFwd,HDG\n!boat,0,1,10,13\n!v12.7.16\n");
    for k in 0..ROWS {
        log += &format!("0,44259.52083{k},1,6.1,10,-3.25,13,{}.5\n", 80 + k);
    }
    log.into_bytes()
}

/// Sentences between the times of others.
pub fn nmea0183_without_times() -> Vec<u8> {
    let mut log = String::new();
    for k in 0..ROWS {
        for sentence in [
            format!("GPRMC,12000{k}.00,A,5000.0,N,00100.0,W,4.2,81.0,080626,,,A"),
            "IIRSA,-3.5,A,,V".into(),
            format!("HCHDG,{}.5,,,2.0,W", 80 + k),
        ] {
            let sum = sentence.bytes().fold(0, |sum, byte| sum ^ byte);
            log += &format!("${sentence}*{sum:02X}\r\n");
        }
    }
    log.into_bytes()
}

pub fn slocum() -> Vec<u8> {
    let mut log = b"dbd_label: DBD_ASC(dinkum_binary_data)file\nencoding_ver: 5\nnum_ascii_tags: 7\n\
        sensor_list_crc: 468fd1be\nsensor_list_factored: 0\nsensors_per_cycle: 4\nstate_bytes_per_cycle: 1\n\
        s: T 0 0 8 m_present_time timestamp\ns: T 1 1 4 m_heading rad\ns: T 2 2 4 m_fin rad\ns: T 3 3 1 x_mode enum\n"
        .to_vec();
    log.extend([b's', b'a', 0x34, 0x12]);
    log.extend(123.456_f32.to_le_bytes());
    log.extend(123_456_789.123_45_f64.to_le_bytes());
    for k in 0..ROWS {
        log.extend([b'd', 0b1010_1010]);
        log.extend((1.4e9 + 4.0 * f64::from(k)).to_le_bytes());
        log.extend(heading_rad(k).to_le_bytes());
        log.extend(0.1_f32.to_le_bytes());
        log.push(2);
    }
    log.push(b'X');
    log
}

pub fn nmea0183() -> Vec<u8> {
    let mut log = String::from("$GPRMC,120000.00,A,5000.0,N,00100.0,W,4.2,81.0,080626,,,A\n");
    for k in 0..ROWS {
        for sentence in [
            format!("HEHDT,{}.5,T", 80 + k),
            "IIRSA,-3.5,A,,V".into(),
            "TIROT,12.0,A".into(),
            "VWVHW,81.0,T,80.0,M,4.1,N,7.6,K".into(),
        ] {
            let sum = sentence.bytes().fold(0, |sum, byte| sum ^ byte);
            log += &format!("{}.25 ${sentence}*{sum:02X}\r\n", 100 + k);
        }
    }
    log.into_bytes()
}

pub fn alog() -> Vec<u8> {
    let mut log = String::from("%% LOG FILE: run.alog\n%% LOGSTART 12345.0\n");
    for k in 0..ROWS {
        for (name, value) in [("NAV_HEADING", 80.0), ("NAV_RUDDER", -4.0), ("NAV_SPEED", 1.5)] {
            log += &format!("{}.250  {name}  pNav  {}\n", 10 + k, value + f64::from(k));
        }
    }
    log.into_bytes()
}

pub fn csv() -> Vec<u8> {
    let mut log = String::from("# a run\ntime_s,heading_deg,rudder [deg],\"speed\"\n");
    for k in 0..ROWS {
        log += &format!("0.{k}5,{},-3.25,\"1.5\"\n", 80 + k);
    }
    log.into_bytes()
}

const POSE: &str = "std_msgs/Header header\nPart[2] parts\nfloat64 heading\nstring note\nint16[] counts\n\
    geometry_msgs/Quaternion orientation\n=====\nMSG: seed_msgs/Part\nuint8 a\nfloat32[2] b\n=====\n\
    MSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n=====\n\
    MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id";

/// Topic, type, definition and message of sample k.
fn ros_topics(k: u32) -> [(&'static str, &'static str, &'static str, Vec<u8>); 3] {
    let number = |value: f64| [&[0, 1, 0, 0], &value.to_le_bytes()[..]].concat();
    let mut pose = vec![0, 1, 0, 0];
    pose.extend((START_S + k).to_le_bytes());
    pose.extend([0; 4]);
    pose.extend([4, 0, 0, 0, b'i', b'm', b'u', 0]);
    pose.extend([7; 24]);
    pose.extend(1.25_f64.to_le_bytes());
    pose.extend([2, 0, 0, 0, b'n', 0, 0, 0, 2, 0, 0, 0, 1, 0, 2, 0]);
    pose.extend([0.0, 0.0, 0.0, 1.0].iter().flat_map(|value: &f64| value.to_le_bytes()));
    [
        ("/heading", "std_msgs/msg/Float64", "float64 data", number(heading_rad(k).into())),
        ("/rudder", "std_msgs/msg/Float64", "float64 data", number(0.25)),
        ("/pose", "seed_msgs/msg/Pose", POSE, pose),
    ]
}

const START_S: u32 = 1_780_883_460;

pub fn mcap_log(compression: Option<mcap::Compression>) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    let mut writer = mcap::WriteOptions::new()
        .compression(compression)
        .chunk_size(Some(400))
        .create(&mut file)
        .unwrap();
    for k in 0..ROWS {
        for (topic, type_name, definition, data) in ros_topics(k) {
            let schema = writer.add_schema(type_name, "ros2msg", definition.as_bytes()).unwrap();
            let channel_id = writer.add_channel(schema, topic, "cdr", &BTreeMap::new()).unwrap();
            let time = u64::from(START_S + k) * 1_000_000_000;
            let header =
                MessageHeader { channel_id, sequence: k, log_time: time, publish_time: time };
            writer.write_to_known_channel(&header, &data).unwrap();
        }
    }
    writer.finish().unwrap();
    drop(writer);
    file.into_inner()
}

pub fn rosbag() -> Vec<u8> {
    let path = std::env::temp_dir().join(format!("seatrial-seed-{}", std::process::id()));
    let _ = std::fs::remove_file(&path);
    let bag = rusqlite::Connection::open(&path).unwrap();
    bag.execute_batch(
        "PRAGMA page_size = 512;
         CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT);
         CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB);
         CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT, encoding TEXT,
         encoded_message_definition TEXT);",
    )
    .unwrap();
    for k in 0..ROWS {
        for (number, (topic, type_name, definition, data)) in (0_i64..).zip(ros_topics(k)) {
            if k == 0 {
                let row = (number, topic, type_name);
                bag.execute("INSERT INTO topics VALUES (?1, ?2, ?3, 'cdr')", row).unwrap();
                let row = (number, type_name, definition);
                bag.execute("INSERT INTO message_definitions VALUES (?1, ?2, 'ros2msg', ?3)", row)
                    .unwrap();
            }
            let row = (number, i64::from(START_S + k) * 1_000_000_000, data);
            bag.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES (?1, ?2, ?3)", row)
                .unwrap();
        }
    }
    drop(bag);
    let bytes = std::fs::read(&path).unwrap();
    std::fs::remove_file(&path).unwrap();
    bytes
}

pub fn parquet_log(compression: Compression) -> Vec<u8> {
    let schema = "message log { required double time_s; optional double heading_rad; required double rudder_rad; }";
    let properties = WriterProperties::builder().set_compression(compression).build();
    let schema = parse_message_type(schema).unwrap().into();
    let mut file = Vec::new();
    let mut writer = SerializedFileWriter::new(&mut file, schema, properties.into()).unwrap();
    let mut group = writer.next_row_group().unwrap();
    let columns: [fn(u32) -> f64; 3] =
        [|k| 0.05 * f64::from(k), |k| heading_rad(k).into(), |_| 0.1];
    for (column, value) in columns.iter().enumerate() {
        let values: Vec<f64> = (0..ROWS).map(value).collect();
        let levels = vec![1_i16; values.len()];
        let mut writer = group.next_column().unwrap().unwrap();
        writer
            .typed::<DoubleType>()
            .write_batch(&values, (column == 1).then_some(&levels[..]), None)
            .unwrap();
        writer.close().unwrap();
    }
    group.close().unwrap();
    writer.close().unwrap();
    file
}
