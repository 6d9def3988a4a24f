//! Logs of every recorder of NMEA 2000.

use super::ROWS;

pub fn canboat() -> Vec<u8> {
    let mut log = String::new();
    for k in 0..ROWS {
        let angle = (1000 + 10 * k) as u16;
        let [low, high] = angle.to_le_bytes();
        for (pgn, data) in [
            (127_245, format!("fc,f8,ff,7f,{low:02x},{high:02x},ff,ff")),
            (127_250, format!("00,{low:02x},{high:02x},ff,7f,ff,7f,fd")),
            (127_251, "00,10,27,00,00,ff,ff,ff".to_string()),
            (128_259, "00,0a,01,ff,ff,00,ff,ff".to_string()),
        ] {
            log += &format!("2026-06-08T01:51:24.{k}00,2,{pgn},52,255,8,{data}\n");
        }
    }
    log.into_bytes()
}

/// Frames of a rudder and a heading: time in s, identifier, bytes.
fn frames() -> Vec<(f64, u32, [u8; 8])> {
    (0..ROWS)
        .flat_map(|k| {
            let [low, high] = ((1000 + 10 * k) as u16).to_le_bytes();
            let time_s = 0.1 * f64::from(k);
            [
                (time_s, 0x09f1_0d1a, [0xfc, 0xf8, 0xff, 0x7f, low, high, 0xff, 0xff]),
                (time_s, 0x09f1_120f, [0, low, high, 0xff, 0x7f, 0xff, 0x7f, 0xfd]),
            ]
        })
        .collect()
}

/// One log of every recorder.
pub fn nmea2000() -> Vec<Vec<u8>> {
    let mut logs = vec![canboat()];
    logs.extend(LINES.map(lines));
    logs.extend(records());
    logs.push(objects());
    logs.push(differences());
    logs.push(packets());
    logs
}

/// The line of a frame: of its time in s, its identifier and its bytes.
type Line = fn(f64, u32, &[u8; 8]) -> String;

const LINES: [Line; 12] = [
    |t, id, data| format!("00:29:{:06.3} R {id:08X} {}", 10.0 + t, hex(data, " ")),
    |t, id, data| {
        let (number, source) = (number(id), id as u8);
        format!("!PDGY,{number},2,{source},255,{t:.3},{}", base64(data))
    },
    |t, id, data| format!("({:.6}) can0 {id:08X}#{}", 1.6e9 + t, hex(data, "")),
    |t, id, data| {
        let (time_s, data) = (1.6e9 + t, hex(data, " "));
        format!(" ({time_s:.6})  can0  {id:08X}   [8]  {data}")
    },
    |t, id, data| format!("  1)  {:.1}  Rx  {id:08X}  8  {}", 1e3 * t, hex(data, " ")),
    |t, id, data| {
        let (number, source, data) = (number(id), id as u8, hex(data, ""));
        format!("0,{:.0},{number},Name,Maker,{source},255,2,1,8,0x{data}", 1e3 * t)
    },
    |t, id, data| {
        let (number, source, data) = (number(id), id as u8, hex(data, ""));
        let time_ms = (1e3 * t).round() as u32;
        let body = format!("PCDIN,{number:06X},{time_ms:08X},{source:02X},{data}");
        let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
        format!("${body}*{sum:02X}")
    },
    |t, id, data| {
        let (number, source, data) = (number(id), id as u8, hex(data, ""));
        format!("A0029{:06.3} {source:02X}FF2 {number:05X} {data}", 10.0 + t)
    },
    |t, id, data| format!("{:.6},{id:#x},1,0,0,8,{}", 1.6e9 + t, base64(data)),
    |t, id, data| {
        let (time_s, data) = (1.6e9 + t, hex(data, " "));
        format!("Timestamp: {time_s:.6}    ID: {id:08x}    X Rx    DL:  8    {data}")
    },
    |t, id, data| {
        let of_10000 = (1e4 * t).round() as u32;
        format!("00:29:58:{of_10000:04} Rx 1 0x{id:08X} x 8 {}", hex(data, " "))
    },
    |t, id, data| format!("00:29:{:06.3},01-05-2024,R,{id:08X},{}", 10.0 + t, hex(data, ",")),
];

/// As `candump -t d` writes it.
fn differences() -> Vec<u8> {
    let mut before_s = 0.0;
    let line = |(time_s, id, data): (f64, u32, [u8; 8])| {
        let since_s = time_s - std::mem::replace(&mut before_s, time_s);
        format!(" (00{since_s:.6})  can0  {id:08X}   [8]  {}\n", hex(&data, " "))
    };
    frames().into_iter().map(line).collect::<String>().into_bytes()
}

/// A capture of SocketCAN.
fn packets() -> Vec<u8> {
    let packets = frames().into_iter().map(|(time_s, id, data)| {
        let head = [&(id | 1 << 31).to_be_bytes()[..], &[8, 0, 0, 0], &data].concat();
        (time_s, head)
    });
    super::pcap(227, packets)
}

fn lines(line: Line) -> Vec<u8> {
    let lines = frames().into_iter().map(|(time_s, id, data)| line(time_s, id, &data) + "\n");
    lines.collect::<String>().into_bytes()
}

fn number(identifier: u32) -> u32 {
    identifier >> 8 & 0x1_ffff
}

fn hex(data: &[u8], between: &str) -> String {
    let digits: Vec<String> = data.iter().map(|byte| format!("{byte:02X}")).collect();
    digits.join(between)
}

/// Logs of the recorders that write bytes.
fn records() -> [Vec<u8>; 5] {
    let mut boxes: [Vec<u8>; 5] = Default::default();
    for (time_s, id, data) in frames() {
        let milliseconds = ((1e3 * time_s).round() as u16).to_le_bytes();
        boxes[0].extend(milliseconds);
        boxes[0].extend(id.to_le_bytes());
        boxes[0].extend(data);
        let message = long(time_s, id, &data);
        boxes[1].extend([0x10, 0x02]);
        boxes[1].extend(escaped(&[&message[..], &[0]].concat(), 0x10));
        boxes[1].extend([0x10, 0x03]);
        boxes[2].extend([0x1b, 0x01]);
        boxes[2].extend(escaped(&[&[0x07], &message[..]].concat(), 0x1b));
        boxes[2].extend([0x1b, 0x0a]);
        let [_, format, specific, _] = id.to_be_bytes();
        let short =
            [&[0x07, 0x95, 14][..], &milliseconds, &[id as u8, specific, format, 0x09], &data];
        boxes[3].extend([0x1b, 0x01]);
        boxes[3].extend(escaped(&short.concat(), 0x1b));
        boxes[3].extend([0x1b, 0x0a]);
        // Times between messages that have none.
        let ticks = 133_590_384_000_000_000_u64 + (1e7 * time_s).round() as u64;
        boxes[4].extend([0x1b, 0x01]);
        boxes[4].extend(escaped(&[&[0x03][..], &ticks.to_le_bytes()].concat(), 0x1b));
        boxes[4].extend([0x1b, 0x0a, 0x10, 0x02]);
        let message = [&long(0.0, id, &data)[..], &[0]].concat();
        boxes[4].extend(escaped(&escaped(&message, 0x10), 0x1b));
        boxes[4].extend([0x10, 0x03]);
    }
    boxes
}

/// A message as an NGT-1 gives it.
fn long(time_s: f64, id: u32, data: &[u8; 8]) -> Vec<u8> {
    let mut message = vec![0x93, 19, 2];
    message.extend(&number(id).to_le_bytes()[..3]);
    message.extend([255, id as u8]);
    message.extend(((1e3 * time_s).round() as u32).to_le_bytes());
    message.push(8);
    message.extend(data);
    message
}

fn escaped(message: &[u8], escape: u8) -> Vec<u8> {
    let twice = |byte: &u8| vec![*byte; 1 + usize::from(*byte == escape)];
    message.iter().flat_map(twice).collect()
}

/// Messages that were decoded to JSON.
fn objects() -> Vec<u8> {
    (0..ROWS)
        .flat_map(|k| {
            let angle = 10.0 + f64::from(k);
            [
                format!("\"pgn\":127245,\"src\":26,\"fields\":{{\"Position\":{angle:.1}}}"),
                format!("\"pgn\":127250,\"src\":15,\"fields\":{{\"Heading\":{angle:.1}}}"),
            ]
            .map(|rest| format!("{{\"timestamp\":\"2026-06-08-01:51:24.{k}00\",{rest}}}\n"))
        })
        .collect::<String>()
        .into_bytes()
}

fn base64(data: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for three in data.chunks(3) {
        let number = three.iter().fold(0_u32, |number, byte| number << 8 | u32::from(*byte));
        let number = number << (8 * (3 - three.len()));
        for place in 0..4 {
            let digit = DIGITS[(number >> (18 - 6 * place) & 63) as usize];
            text.push(if place > three.len() { '=' } else { char::from(digit) });
        }
    }
    text
}
