//! Text copies of DataFlash logs, captures of networks, logs of DUNE, long and sparse tables.

use super::*;

/// [`dataflash`] as Mission Planner writes it.
pub fn dataflash_text() -> String {
    let mut log = "FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns
FMT, 2, 31, PARM, QNf, TimeUS,Name,Value
FMT, 3, 75, MSG, QZ, TimeUS,Message
FMT, 4, 21, ATT, QccCf, TimeUS,Roll,Pitch,Yaw,AEKF
FMT, 5, 15, RCOU, QHH, TimeUS,C1,C2
PARM, 0, SERVO1_FUNCTION, 26
PARM, 0, SERVO1_TRIM, 1490
MSG, 0, ArduRover V4.5, a boat
"
    .to_owned();
    for k in 0..ROWS {
        let time_us = 1_000_000 + 20_000 * k;
        let yaw = f64::from(5730 + 57 * k) / 100.0;
        log += &format!("RCOU, {time_us}, 1600, 1500\nATT, {time_us}, 1, 0, {yaw:.2}, 0\n");
    }
    log
}

/// A capture of a network or a bus: packets with their times in s.
pub fn pcap(link: u32, packets: impl Iterator<Item = (f64, Vec<u8>)>) -> Vec<u8> {
    let words = |words: &[u32]| -> Vec<u8> { words.iter().flat_map(|w| w.to_le_bytes()).collect() };
    let mut capture = words(&[0xa1b2_c3d4, 0x0004_0002, 0, 0, 65_535, link]);
    for (time_s, packet) in packets {
        let (us, length) = ((1e6 * time_s).round() as u32, packet.len() as u32);
        capture.extend(words(&[START_S, us, length, length]));
        capture.extend(packet);
    }
    capture
}

/// A heading and a rudder in a datagram each, in frames of Ethernet with their times in s.
fn datagrams_of_sentences() -> impl Iterator<Item = (f64, Vec<u8>)> {
    (0..ROWS).flat_map(|k| {
        let time_s = 0.1 * f64::from(k);
        let heading = format!("HEHDT,{:.2},T", heading_rad(k).to_degrees());
        [heading, format!("RIRSA,{k}.0,A,,")].map(|body| {
            let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
            let sentence = format!("${body}*{sum:02X}\r\n");
            let mut packet = [0; 12].to_vec();
            packet.extend([8, 0, 0x45, 0, 0, 0, 0, 0, 0, 0, 64, 17]);
            packet.extend([0; 18]);
            packet.extend(sentence.bytes());
            (time_s, packet)
        })
    })
}

pub(super) fn datagrams() -> Vec<u8> {
    pcap(1, datagrams_of_sentences())
}

/// [`datagrams`] as pcapng.
pub(super) fn blocks_of_datagrams() -> Vec<u8> {
    let block = |kind: u32, body: &[u8]| {
        let mut padded = body.to_vec();
        padded.resize(body.len().next_multiple_of(4), 0);
        let length = (12 + padded.len() as u32).to_le_bytes();
        [&kind.to_le_bytes()[..], &length, &padded, &length].concat()
    };
    let head = [0x4d, 0x3c, 0x2b, 0x1a, 1, 0, 0, 0];
    let mut capture = block(0x0a0d_0d0a, &[&head[..], &[0xff; 8]].concat());
    // Times count milliseconds.
    let interface = [1, 0, 0, 0, 0, 0, 1, 0, 9, 0, 1, 0, 3, 0, 0, 0, 0, 0, 0, 0];
    capture.extend(block(1, &interface));
    for (time_s, packet) in datagrams_of_sentences() {
        let ms = 1000 * u64::from(START_S) + (1e3 * time_s).round() as u64;
        let length = packet.len() as u32;
        let head = [0, (ms >> 32) as u32, ms as u32, length, length];
        let head: Vec<u8> = head.iter().flat_map(|word| word.to_le_bytes()).collect();
        capture.extend(block(6, &[head, packet].concat()));
    }
    capture
}

/// Columns that are filled at different rates.
pub fn sparse() -> Vec<u8> {
    let mut log = String::from("time_s,yaw_deg,rudder_deg\n");
    for k in 0..ROWS {
        log += &format!("{k}.00,,-3.25\n{k}.05,{},\n", 80 + k);
    }
    log.into_bytes()
}

/// One value a row.
pub fn long() -> Vec<u8> {
    let mut log = String::from("Series;Time;Value\n");
    for k in 0..ROWS {
        for (name, value) in [("steering.rudderAngle", -0.1), ("navigation.headingTrue", 1.5)] {
            log +=
                &format!("{name};2026-03-04T00:29:58.{k}00Z;{:.3}\n", value + 0.01 * f64::from(k));
        }
    }
    log.into_bytes()
}

/// A packet of IMC, sent by an entity of system 30; the numbers of its header and sum in this order of bytes.
pub fn imc(is_little_endian: bool, id: u16, time_s: f64, entity: u8, fields: &[&[u8]]) -> Vec<u8> {
    let word = |word: u16| match is_little_endian {
        true => word.to_le_bytes(),
        false => word.to_be_bytes(),
    };
    let time = match is_little_endian {
        true => time_s.to_le_bytes(),
        false => time_s.to_be_bytes(),
    };
    let fields = fields.concat();
    let mut packet = [word(0xfe54), word(id), word(fields.len() as u16)].concat();
    packet.extend([&time[..], &word(30), &[entity], &word(0xffff), &[0xff], &fields].concat());
    let sum = packet.iter().fold(0_u16, |sum, byte| {
        (0..8).fold(sum ^ u16::from(*byte), |sum, _| (sum >> 1) ^ (0xa001 * (sum & 1)))
    });
    packet.extend(word(sum));
    packet
}

/// A log of DUNE: the vertical fins are servos 0 and 3, and one message of every sample is of a kind that is not read.
pub fn lsf() -> Vec<u8> {
    let servo =
        |time_s, id: u8, angle: f32| imc(true, 281, time_s, 9, &[&[id], &angle.to_le_bytes()]);
    let of_sample = |k: u32| {
        let time_s = f64::from(START_S) + 0.1 * f64::from(k);
        let angles = [0.0, 0.02, -0.05, f64::from(heading_rad(k)), 0.0].map(f64::to_le_bytes);
        [
            servo(time_s, 0, 0.15),
            servo(time_s, 1, 0.3),
            servo(time_s, 3, 0.05),
            imc(true, 150, time_s, 0, &[]),
            imc(true, 254, time_s, 12, &[angles.as_flattened()]),
        ]
        .concat()
    };
    (0..ROWS).flat_map(of_sample).collect()
}
