//! Large logs from small ones: their messages again and again, each time with later times.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{BufWriter, Seek, Write};
use std::path::Path;

use mcap::records::MessageHeader;
use seatrial_core::{Real, Sample};
use seatrial_logs::{ChannelChoice, open};

use crate::Outcome;

pub fn log(format: &str, native: &Path, log: &Path, bytes: u64) -> Outcome<()> {
    let out = BufWriter::new(File::create(log)?);
    match format {
        "bin" => dataflash(&fs::read(native.join("ardupilot/ardusub_small.BIN"))?, out, bytes),
        "tlog" => tlog(&fs::read(native.join("ardupilot/rover_json_physics.tlog"))?, out, bytes),
        _ => {
            let log = native.join("ardupilot/rover_json_physics.tlog");
            let samples = open(&log, &ChannelChoice::default())?.collect::<Result<Vec<_>, _>>()?;
            mcap_log(&samples, out, bytes)
        }
    }
}

/// Messages that describe others stand in the first round only; `TimeUS` is the first field of all others.
fn dataflash(log: &[u8], mut out: impl Write, bytes: u64) -> Outcome<()> {
    const DESCRIPTIONS: [&[u8]; 6] = [b"FMT\0", b"FMTU", b"UNIT", b"MULT", b"PARM", b"MSG\0"];
    let mut lengths = BTreeMap::from([(128_u8, 89)]);
    let mut is_description = [false; 256];
    let mut messages = Vec::new();
    let mut at = 0;
    while let Some(&[0xa3, 0x95, kind]) = log[at..].first_chunk() {
        let Some(message) = log.get(at..at + lengths[&kind]) else {
            break;
        };
        if kind == 128 {
            lengths.insert(message[3], usize::from(message[4]));
            let name = &message[5..9];
            is_description[usize::from(message[3])] = DESCRIPTIONS.contains(&name);
        }
        messages.push((message, is_description[usize::from(kind)]));
        at += message.len();
    }
    let time_us =
        |message: &[u8]| u64::from_le_bytes(message[3..11].try_into().unwrap_or_default());
    let times = || messages.iter().filter(|(_, is)| !is).map(|(m, _)| time_us(m));
    let round_us = times().max().unwrap_or(0) - times().min().unwrap_or(0) + 100_000;
    let mut written = 0;
    for round in 0.. {
        for (message, _) in messages.iter().filter(|(_, is)| round == 0 || !is) {
            let mut own = message.to_vec();
            if round > 0 {
                let later_us = time_us(message) + round * round_us;
                own[3..11].copy_from_slice(&later_us.to_le_bytes());
            }
            out.write_all(&own)?;
            written += own.len() as u64;
        }
        if written >= bytes {
            return Ok(out.flush()?);
        }
    }
    Ok(())
}

/// Where a message holds its boot time, units of it in 1 ms, and the seed of its checksum.
const CLOCKS: [(u8, usize, u32, u8); 7] = [
    (2, 8, 1, 137),
    (30, 0, 1, 39),
    (32, 0, 1, 185),
    (33, 0, 1, 104),
    (34, 0, 1, 237),
    (36, 0, 1000, 222),
    (65, 0, 1, 118),
];

fn tlog(log: &[u8], mut out: impl Write, bytes: u64) -> Outcome<()> {
    let mut frames = Vec::new();
    let mut at = 0;
    while let Some(frame) = log.get(at + 8..) {
        let length = match frame.get(..3) {
            Some([0xfd, payload, flags]) => {
                12 + usize::from(*payload) + 13 * usize::from(flags & 1)
            }
            Some([0xfe, payload, _]) => 8 + usize::from(*payload),
            _ => break,
        };
        let Some(whole) = log.get(at..at + 8 + length) else {
            break;
        };
        frames.push(whole);
        at += whole.len();
    }
    let stamp = |frame: &[u8]| u64::from_be_bytes(frame[..8].try_into().unwrap_or_default());
    let span_us = stamp(frames[frames.len() - 1]) - stamp(frames[0]);
    let round_ms = (span_us / 1000 + 100) as u32;
    let mut written = 0;
    for round in 0.. {
        for frame in &frames {
            let mut own = frame.to_vec();
            let later_us = stamp(frame) + u64::from(round * round_ms) * 1000;
            own[..8].copy_from_slice(&later_us.to_be_bytes());
            let (header, id) = match own[8] {
                0xfd => (10, u32::from_le_bytes([own[15], own[16], own[17], 0])),
                _ => (6, own[13].into()),
            };
            let end = 8 + header + usize::from(own[9]);
            let clock = CLOCKS.iter().find(|(of, ..)| u32::from(*of) == id);
            if let Some((_, field, per_ms, seed)) = clock {
                let field = 8 + header + field;
                let before = u32::from_le_bytes(own[field..field + 4].try_into()?);
                let later = before.wrapping_add((round * round_ms).wrapping_mul(*per_ms));
                own[field..field + 4].copy_from_slice(&later.to_le_bytes());
                let sum = checksum(&own[9..end], *seed);
                own[end..end + 2].copy_from_slice(&sum.to_le_bytes());
            }
            out.write_all(&own)?;
            written += own.len() as u64;
        }
        if written >= bytes {
            return Ok(out.flush()?);
        }
    }
    Ok(())
}

/// CRC-16/MCRF4XX.
fn checksum(bytes: &[u8], seed: u8) -> u16 {
    bytes.iter().chain([&seed]).fold(0xffff_u16, |sum, byte| {
        let mut bits = byte ^ (sum & 0xff) as u8;
        bits ^= bits << 4;
        let wide = u16::from(bits);
        (sum >> 8) ^ (wide << 8) ^ (wide << 3) ^ (wide >> 4)
    })
}

const IMU: &str = "std_msgs/Header header
geometry_msgs/Quaternion orientation
float64[9] orientation_covariance
geometry_msgs/Vector3 angular_velocity
float64[9] angular_velocity_covariance
geometry_msgs/Vector3 linear_acceleration
float64[9] linear_acceleration_covariance
=====
MSG: geometry_msgs/Quaternion
float64 x
float64 y
float64 z
float64 w
=====
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
=====
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
=====
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec";

const START_S: f64 = 1.7e9;

/// Imu and rudder topics in chunks of LZ4.
fn mcap_log(samples: &[Sample<f64>], out: impl Write + Seek, bytes: u64) -> Outcome<()> {
    let [first, .., last] = samples else {
        return Err("no samples".into());
    };
    let round_s = last.time_s - first.time_s + 0.1;
    let mut out =
        mcap::WriteOptions::new().compression(Some(mcap::Compression::Lz4)).create(out)?;
    let imu = out.add_schema("sensor_msgs/msg/Imu", "ros2msg", IMU.as_bytes())?;
    let imu = out.add_channel(imu, "/imu/data", "cdr", &BTreeMap::new())?;
    let number = out.add_schema("std_msgs/msg/Float64", "ros2msg", b"float64 data")?;
    let rudder = out.add_channel(number, "/rudder", "cdr", &BTreeMap::new())?;
    let rounds = bytes / (samples.len() as u64 * BYTES_PER_SAMPLE) + 1;
    let mut message = Vec::new();
    for round in 0..rounds {
        for sample in samples {
            let log_time = ((START_S + sample.time_s + round as f64 * round_s) * 1e9) as u64;
            let half_rad = 0.5 * (std::f64::consts::FRAC_PI_2 - sample.heading_rad);
            message.clear();
            message.extend([0, 1, 0, 0]);
            message.extend(((log_time / 1_000_000_000) as u32).to_le_bytes());
            message.extend(((log_time % 1_000_000_000) as u32).to_le_bytes());
            message.extend(b"\x04\0\0\0imu\0");
            let mut numbers = [0.0; 37];
            numbers[2] = Real::sin(half_rad);
            numbers[3] = Real::cos(half_rad);
            numbers[15] = -sample.yaw_rate_rad_s.unwrap_or(0.0);
            numbers[25] = sample.time_s.sin();
            message.extend(numbers.iter().flat_map(|number: &f64| number.to_le_bytes()));
            let mut write = |channel_id, data: &[u8]| {
                let header =
                    MessageHeader { channel_id, sequence: 0, log_time, publish_time: log_time };
                out.write_to_known_channel(&header, data)
            };
            write(imu, &message)?;
            let rudder_bytes = sample.rudder_rad.to_le_bytes();
            write(rudder, &[&[0, 1, 0, 0], &rudder_bytes[..]].concat())?;
        }
    }
    out.finish()?;
    Ok(())
}

/// Of a sample's two messages, compressed.
const BYTES_PER_SAMPLE: u64 = 92;
