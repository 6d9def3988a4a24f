//! Frames of MAVLink: as pymavlink writes them, in garbage, cut, forged and repeated.

use std::process::Command;

use proptest::prelude::*;
use seatrial_dev::python_with;
use seatrial_links::link::message::{Heartbeat, ParamValue, RcChannelsOverride, Text};
use seatrial_links::link::{Decoder, Encoder, Frame, Key, Message, Refused, Sender, Signing};

const SENDER: Sender = Sender { system: 7, component: 190 };
/// s from 1970 to 2015, from where timestamps count.
const EPOCH_S: f64 = 1_420_070_400.0;

fn key() -> Key {
    Key::new(std::array::from_fn(|k| k as u8))
}

fn heartbeat(custom_mode: u32) -> Message {
    Message::from(Heartbeat {
        custom_mode,
        kind: 11,
        autopilot: 3,
        base_mode: 0x81,
        system_status: 4,
        mavlink_version: 3,
    })
}

fn parameter(value: f32) -> Message {
    Message::from(ParamValue {
        value,
        count: 900,
        index: 65535,
        name: Text::from("RC_OVERRIDE_TIME"),
        kind: 9,
    })
}

fn decoded(bytes: &[u8]) -> Vec<Frame> {
    let mut decoder = Decoder::default();
    decoder.push(bytes);
    std::iter::from_fn(|| decoder.next(None, 0.0)).collect()
}

fn bytes(hexadecimal: &str) -> Vec<u8> {
    (0..hexadecimal.len() / 2)
        .map(|k| u8::from_str_radix(&hexadecimal[2 * k..2 * k + 2], 16).unwrap())
        .collect()
}

/// Every message, 40 times with random fields: byte by byte the same in version 2 and signed, read from version 1.
#[test]
fn val_pymavlink_writes_and_reads_the_same_bytes() {
    let Some(python) = python_with("pymavlink") else {
        return;
    };
    let ids =
        [0, 1, 20, 21, 22, 23, 24, 30, 32, 33, 36, 65, 69, 70, 74, 76, 77, 111, 193, 230, 253];
    let output = Command::new(python)
        .arg(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/vehicle/frames.py"))
        .args(["40", &ids.map(|id| id.to_string()).join(",")])
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    let mut count = 0;
    for line in text.lines() {
        let fields: Vec<&str> = line.split(' ').collect();
        let [_, sequence, timestamp, plain, old, signed] = fields[..] else {
            panic!("{line}");
        };
        let expected = bytes(plain);
        let frames = decoded(&expected);
        assert_eq!(frames.len(), 1, "{line}");
        assert_eq!(frames[0].sender, SENDER);
        let message = frames[0].message().expect(line);
        let sequence: u8 = sequence.parse().unwrap();
        let encoder = || {
            let mut encoder = Encoder::new(SENDER);
            (0..sequence).for_each(|_| drop(encoder.encode(&heartbeat(0), None, 0.0)));
            encoder
        };
        assert_eq!(encoder().encode(&message, None, 0.0), expected, "{line}");
        if old != "-" {
            let frames = decoded(&bytes(old));
            assert_eq!(frames[0].message(), Some(message), "{line}");
        }
        // Their first timestamp is the one given; ours is the clock's, in units of 10 us.
        let timestamp: f64 = timestamp.parse().unwrap();
        let mut ours = Signing::new(key(), 3, EPOCH_S + (timestamp + 0.5) / 1e5);
        let expected = bytes(signed);
        assert_eq!(encoder().encode(&message, Some(&mut ours), 0.0), expected, "{line}");
        let mut theirs = Signing::new(key(), 0, EPOCH_S + timestamp / 1e5);
        let mut decoder = Decoder::default();
        decoder.push(&expected);
        let frame = decoder.next(Some(&mut theirs), 0.0).expect(line);
        assert_eq!(frame.message(), Some(message));
        count += 1;
    }
    assert_eq!(count, 40 * ids.len());
}

#[test]
fn io_a_signature_is_asked_for_checked_and_taken_once() {
    let signing = || Signing::new(key(), 1, EPOCH_S + 1e8);
    let mut sender = signing();
    let mut encoder = Encoder::new(SENDER);
    let good = encoder.encode(&heartbeat(1), Some(&mut sender), 0.0);
    let unsigned = encoder.encode(&heartbeat(2), None, 0.0);
    let mut other_key = Signing::new(Key::new([1; 32]), 1, EPOCH_S + 1e8);
    let forged = encoder.encode(&heartbeat(3), Some(&mut other_key), 0.0);
    let mut slow = Signing::new(key(), 2, EPOCH_S + 1e8 - 61.0);
    let old = encoder.encode(&heartbeat(4), Some(&mut slow), 0.0);
    let next = encoder.encode(&heartbeat(5), Some(&mut sender), 0.0);
    let mut receiver = signing();
    let mut decoder = Decoder::default();
    for frame in [&good, &unsigned, &forged, &old, &good, &next] {
        decoder.push(frame);
    }
    let modes: Vec<_> = std::iter::from_fn(|| decoder.next(Some(&mut receiver), 0.0))
        .map(|frame| frame.message().unwrap())
        .collect();
    assert_eq!(modes, [heartbeat(1), heartbeat(5)]);
    assert_eq!(decoder.damage().refused_frames, 4);
    let (frame, signature) = good.split_at(good.len() - 13);
    let mut check = |frame: &[u8], signature: &[u8]| receiver.check(SENDER, frame, signature, 0.0);
    assert_eq!(check(frame, signature), Err(Refused::Replayed));
    let mut changed = frame.to_vec();
    changed[10] ^= 1;
    assert_eq!(check(&changed, signature), Err(Refused::Forged));
    assert_eq!(check(frame, &signature[..5]), Err(Refused::Unsigned));
}

#[test]
fn io_a_key_is_never_shown() {
    let shown = format!("{:?} {:?}", key(), Signing::new(key(), 0, 0.0));
    assert!(!shown.contains("1, 2, 3") && !shown.contains("010203"), "{shown}");
}

#[test]
fn io_a_key_is_32_bytes_or_64_digits() {
    let folder = tempfile::tempdir().unwrap();
    let load = |content: &[u8]| {
        let path = folder.path().join("key");
        std::fs::write(&path, content).unwrap();
        Key::load(&path)
    };
    let frame = |key: Key| {
        let mut signing = Signing::new(key, 0, EPOCH_S);
        Encoder::new(SENDER).encode(&heartbeat(0), Some(&mut signing), 0.0)
    };
    let raw: Vec<u8> = (0..32).collect();
    let digits: String = raw.iter().map(|byte| format!("{byte:02X}")).collect();
    let expected = frame(key());
    assert_eq!(frame(load(&raw).unwrap()), expected);
    assert_eq!(frame(load(format!("{digits}\n").as_bytes()).unwrap()), expected);
    for wrong in [&b""[..], b"0123", digits.replace('0', "g").as_bytes()] {
        let error = load(wrong).unwrap_err().to_string();
        assert!(error.contains("32 bytes or 64 hexadecimal digits"), "{error}");
    }
    assert!(Key::load(&folder.path().join("none")).is_err());
}

#[test]
fn io_unknown_messages_are_passed_over_whole() {
    // A message of number 77777, whose payload looks like the start of frames.
    let mut stream = vec![0xfd, 4, 0, 0, 0, 1, 1, 0xd1, 0x2f, 0x01, 0xfd, 0xfe, 0xfd, 0xfe, 0, 0];
    let mut encoder = Encoder::new(SENDER);
    stream.extend(encoder.encode(&heartbeat(1), None, 0.0));
    assert_eq!(decoded(&stream).len(), 1);
    // One that must not be understood for its flags.
    let mut strange = encoder.encode(&heartbeat(2), None, 0.0);
    strange[2] = 2;
    strange.extend(encoder.encode(&heartbeat(3), None, 0.0));
    let frames = decoded(&strange);
    assert_eq!(frames.len(), 1);
    assert_eq!(frames[0].message(), Some(heartbeat(3)));
}

/// Bytes of the longest frame: head, payload, checksum and signature.
const LONGEST_FRAME: usize = 280;

proptest! {
    /// Whatever the garbage and however it is cut, the frames in it come out, and nothing else that was not there.
    #[test]
    fn prop_frames_are_found_in_garbage(
        pieces in prop::collection::vec((prop::collection::vec(any::<u8>(), 0..60), any::<u32>()), 1..12),
        cut in 1..97_usize,
    ) {
        let mut encoder = Encoder::new(SENDER);
        let mut stream = Vec::new();
        let (mut last_head, mut may_be_hidden) = (None, 0);
        for (garbage, mode) in &pieces {
            let head = garbage.iter().rposition(|byte| matches!(byte, 0xfd | 0xfe));
            last_head = head.map(|at| stream.len() + at).or(last_head);
            stream.extend(garbage);
            may_be_hidden += usize::from(last_head.is_some_and(|at| stream.len() - at < LONGEST_FRAME));
            stream.extend(encoder.encode(&heartbeat(*mode), None, 0.0));
        }
        // The longest frame that garbage can pretend to be has ended by then.
        stream.extend([0; 300]);
        let mut decoder = Decoder::default();
        let mut found = Vec::new();
        for part in stream.chunks(cut) {
            decoder.push(part);
            found.extend(std::iter::from_fn(|| decoder.next(None, 0.0)));
        }
        let modes: Vec<_> = found.iter().filter(|f| f.sender == SENDER).filter_map(Frame::message).collect();
        let expected: Vec<_> = pieces.iter().map(|(_, mode)| heartbeat(*mode)).collect();
        // A head in the garbage of a message that nobody knows hides what begins within its length.
        prop_assert!(modes.len() + may_be_hidden >= expected.len());
        prop_assert!(modes.iter().all(|mode| expected.contains(mode)));
    }

    /// A frame with any one byte changed is not taken for another message of its sender.
    #[test]
    fn prop_a_changed_byte_is_noticed(value in any::<f32>(), at in 0..40_usize, change in 1..=255_u8) {
        let mut frame = Encoder::new(SENDER).encode(&parameter(value), None, 0.0);
        let at = at % frame.len();
        frame[at] ^= change;
        frame.extend([0; 300]);
        prop_assert_eq!(decoded(&frame).len(), 0);
    }

    #[test]
    fn prop_garbage_never_panics(bytes in prop::collection::vec(prop_oneof![Just(0xfd_u8), Just(0xfe), any::<u8>()], 0..2000)) {
        let mut signing = Signing::new(key(), 0, EPOCH_S);
        let mut decoder = Decoder::default();
        decoder.push(&bytes);
        prop_assert!(decoder.next(Some(&mut signing), 0.0).is_none());
        for frame in decoded(&bytes) {
            let _ = frame.message();
        }
    }

    #[test]
    fn prop_every_message_comes_back(pulses in prop::array::uniform8(any::<u16>()), target_system in any::<u8>()) {
        let message = Message::from(RcChannelsOverride { pulses, target_system, target_component: 0 });
        let frames = decoded(&Encoder::new(SENDER).encode(&message, None, 0.0));
        prop_assert_eq!(frames.len(), 1);
        prop_assert_eq!(frames[0].message(), Some(message));
    }
}
