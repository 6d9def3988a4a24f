//! A long ArduPilot log of a made-up boat, whose every message is one that autopilots write.

/// What announces a message of type `number`.
fn message(number: u8, body: &[&[u8]]) -> Vec<u8> {
    [&[0xa3, 0x95, number], &body.concat()[..]].concat()
}

fn padded(text: &str, width: usize) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    bytes.resize(width, 0);
    bytes
}

/// The FMT message of a type whose body has so many bytes.
fn format(number: u8, body: u8, name: &str, codes: &str, labels: &str) -> Vec<u8> {
    let texts = [padded(name, 4), padded(codes, 16), padded(labels, 64)].concat();
    message(128, &[&[number, body + 3], &texts])
}

/// ArduPilot logs the attitude at 10 Hz by default.
const INTERVAL_S: f64 = 0.1;
/// A log of ArduSub 4.5 has 1.2 kB for each attitude; here messages of the inertial sensors are in place of all others.
const OTHERS: u64 = 33;
const FULL_RUDDER_RAD: f64 = 0.5;

/// A boat whose steering is of first order.
struct Boat {
    heading_rad: f64,
    yaw_rate_rad_s: f64,
}

impl Boat {
    fn step(&mut self, rudder_rad: f64) {
        let (a22_per_s, b2_per_s2) = (-0.8, 1.0);
        self.heading_rad += INTERVAL_S * self.yaw_rate_rad_s;
        let acceleration = a22_per_s * self.yaw_rate_rad_s + b2_per_s2 * rudder_rad;
        self.yaw_rate_rad_s += INTERVAL_S * acceleration;
    }
}

/// Half a minute of doublets every two minutes, as a share of full rudder.
fn rudder_at(time_s: f64) -> f64 {
    let phase_s = time_s % 120.0;
    match (phase_s < 32.0, (phase_s / 4.0) as u32 % 4) {
        (true, 1) => 0.6,
        (true, 3) => -0.6,
        _ => 0.0,
    }
}

/// What describes the messages and the boat.
fn head() -> Vec<u8> {
    let mut log = [
        format(128, 86, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns"),
        format(2, 28, "PARM", "QNf", "TimeUS,Name,Value"),
        format(3, 72, "MSG", "QZ", "TimeUS,Message"),
        format(4, 14, "ATT", "QccC", "TimeUS,Roll,Pitch,Yaw"),
        format(5, 12, "RCOU", "QHH", "TimeUS,C1,C2"),
        format(
            6,
            33,
            "IMU",
            "QBffffff",
            "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ",
        ),
    ]
    .concat();
    let start = 0_u64.to_le_bytes();
    for (name, value) in [
        ("SERVO1_FUNCTION", 26.0_f32),
        ("SERVO1_MIN", 1100.0),
        ("SERVO1_TRIM", 1500.0),
        ("SERVO1_MAX", 1900.0),
    ] {
        let body: [&[u8]; 3] = [&start, &padded(name, 16), &value.to_le_bytes()];
        log.extend(message(2, &body));
    }
    log.extend(message(3, &[&start, &padded("ArduRover V4.5", 64)]));
    log
}

/// Attitude and outputs beside messages of the inertial sensors, up to about this length.
pub fn long_log(bytes: usize) -> Vec<u8> {
    let mut boat = Boat {
        heading_rad: 1.0,
        yaw_rate_rad_s: 0.0,
    };
    let mut log = head();
    let times = (0_u32..).map(|k| f64::from(k) * INTERVAL_S);
    for time_s in times {
        if log.len() >= bytes {
            break;
        }
        let share = rudder_at(time_s);
        let us = (1_000_000.0 + 1e6 * time_s) as u64;
        let pulse = (1500.0 + 400.0 * share) as u16;
        let (pulse, throttle) = (pulse.to_le_bytes(), 1600_u16.to_le_bytes());
        log.extend(message(5, &[&us.to_le_bytes(), &pulse, &throttle]));
        let yaw = boat.heading_rad.to_degrees().rem_euclid(360.0) * 100.0;
        let yaw = (yaw as u16).to_le_bytes();
        log.extend(message(4, &[&us.to_le_bytes(), &[0; 4], &yaw]));
        let gyro = (boat.yaw_rate_rad_s as f32).to_le_bytes();
        for part in 0..OTHERS {
            let us = (us + 3000 * part).to_le_bytes();
            log.extend(message(6, &[&us, &[0], &[0; 8], &gyro, &[0; 12]]));
        }
        boat.step(share * FULL_RUDDER_RAD);
    }
    log
}
