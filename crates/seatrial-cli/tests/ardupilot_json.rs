//! `seatrial sim serve --ardupilot-json` seen from an autopilot's side of the interface, over UDP.
#![cfg(unix)]

use std::io::{BufRead, BufReader, Read};
use std::net::UdpSocket;
use std::process::{Child, Stdio};
use std::time::Duration;

use seatrial_dev::program;
use serde_json::Value;

const GRAVITY_M_S2: f64 = 9.81;
const RATE_HZ: u16 = 100;

/// The autopilot's end.
struct Autopilot {
    sea: Child,
    socket: UdpSocket,
}

impl Autopilot {
    fn start(options: &[&str]) -> Self {
        let mut sea = program()
            .args(["sim", "serve", "--ardupilot-json", "--json", "--listen", "127.0.0.1:0"])
            .args(options)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut line = String::new();
        let mut stderr = BufReader::new(sea.stderr.take().unwrap());
        stderr.read_line(&mut line).unwrap();
        // The rest is read so that no line blocks.
        std::thread::spawn(move || std::io::copy(&mut stderr, &mut std::io::sink()));
        let address = line.trim().rsplit(' ').next().unwrap().to_owned();
        let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
        socket.connect(&address).unwrap_or_else(|error| panic!("{line}: {error}"));
        socket.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
        Self { sea, socket }
    }

    fn send(&self, magic: u16, count: u32, pwm: &[u16]) {
        let mut packet = Vec::new();
        packet.extend(magic.to_le_bytes());
        packet.extend(RATE_HZ.to_le_bytes());
        packet.extend(count.to_le_bytes());
        packet.extend(pwm.iter().flat_map(|pulse| pulse.to_le_bytes()));
        self.socket.send(&packet).unwrap();
    }

    fn receive(&self) -> String {
        let mut buffer = [0; 4096];
        let length = self.socket.recv(&mut buffer).unwrap();
        String::from_utf8(buffer[..length].to_vec()).unwrap()
    }

    /// One frame of 16 channels and its answer.
    fn step(&self, count: u32, rudder: u16, elevator: u16, throttle: u16) -> Motion {
        let mut pwm = [1500; 16];
        (pwm[0], pwm[1], pwm[2]) = (rudder, elevator, throttle);
        self.send(18458, count, &pwm);
        Motion::of(&self.receive())
    }

    /// Interrupts it; what it says in the end.
    fn interrupt(mut self) -> Value {
        crate::signal::send(self.sea.id(), "INT");
        assert_eq!(self.sea.wait().unwrap().code(), Some(0));
        let mut stdout = String::new();
        self.sea.stdout.take().unwrap().read_to_string(&mut stdout).unwrap();
        serde_json::from_str(&stdout).unwrap()
    }
}

impl Drop for Autopilot {
    fn drop(&mut self) {
        let _ = self.sea.kill();
        let _ = self.sea.wait();
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Motion {
    time_s: f64,
    gyro: [f64; 3],
    accelerometer: [f64; 3],
    position: [f64; 3],
    attitude: [f64; 3],
    velocity: [f64; 3],
}

impl Motion {
    fn of(line: &str) -> Self {
        assert!(line.starts_with("\n{") && line.ends_with("}\n"), "{line:?}");
        let value: Value = serde_json::from_str(line).unwrap();
        let vector = |value: &Value| -> [f64; 3] {
            let numbers = value.as_array().unwrap();
            assert_eq!(numbers.len(), 3);
            std::array::from_fn(|i| numbers[i].as_f64().unwrap())
        };
        Self {
            time_s: value["timestamp"].as_f64().unwrap(),
            gyro: vector(&value["imu"]["gyro"]),
            accelerometer: vector(&value["imu"]["accel_body"]),
            position: vector(&value["position"]),
            attitude: vector(&value["attitude"]),
            velocity: vector(&value["velocity"]),
        }
    }

    /// The accelerometer's reading turned to north, east and down, with gravity: what the velocity has to change by.
    fn acceleration(&self) -> [f64; 3] {
        let [(sr, cr), (sp, cp), (sy, cy)] = self.attitude.map(f64::sin_cos);
        let [x, y, z] = self.accelerometer;
        [
            cy * cp * x + (cy * sp * sr - sy * cr) * y + (cy * sp * cr + sy * sr) * z,
            sy * cp * x + (sy * sp * sr + cy * cr) * y + (sy * sp * cr - cy * sr) * z,
            -sp * x + cp * sr * y + cp * cr * z + GRAVITY_M_S2,
        ]
    }
}

#[test]
fn cli_an_autopilot_drives_the_vehicle() {
    let autopilot = Autopilot::start(&["--vehicle", "sim:remus100", "--elevator", "2"]);
    // Straight ahead for 20 s, then 5 s of starboard rudder, then 5 s of up elevator.
    let mut motions = Vec::new();
    for count in 0..3000 {
        let (rudder, elevator) = match count {
            0..2000 => (1500, 1500),
            2000..2500 => (1800, 1500),
            _ => (1500, 1700),
        };
        motions.push(autopilot.step(count, rudder, elevator, 1900));
    }
    for (k, motion) in motions.iter().enumerate() {
        // Frames of 10 ms; sums of 0.005 s round.
        let time_s = 0.01 * (k + 1) as f64;
        assert!((motion.time_s - time_s).abs() < 1e-9, "{k}: {}", motion.time_s);
    }
    for pair in motions.windows(2) {
        let (before, after) = (pair[0], pair[1]);
        let (a, b) = (before.acceleration(), after.acceleration());
        for i in 0..3 {
            let moved = after.position[i] - before.position[i];
            let expected = 0.005 * (before.velocity[i] + after.velocity[i]);
            // Trapezes of 10 ms under accelerations that change by less than 20 m/s^3.
            assert!((moved - expected).abs() < 1e-5, "{i}: {moved} {expected}");
            let change = after.velocity[i] - before.velocity[i];
            // The disturbance takes a new value at every frame.
            assert!((change - 0.005 * (a[i] + b[i])).abs() < 1e-4, "{i}: {change}");
        }
        let turned = after.attitude[2] - before.attitude[2];
        let wrapped = turned - std::f64::consts::TAU * (turned / std::f64::consts::TAU).round();
        let rate = |motion: &Motion| {
            let [(sr, cr), (_, cp), _] = motion.attitude.map(f64::sin_cos);
            (sr * motion.gyro[1] + cr * motion.gyro[2]) / cp
        };
        assert!((wrapped - 0.005 * (rate(&before) + rate(&after))).abs() < 1e-5);
    }
    // At rest and upright the accelerometer feels the weight, up.
    assert!((motions[0].accelerometer[2] + GRAVITY_M_S2).abs() < 0.05, "{:?}", motions[0]);
    let at = |seconds: usize| motions[100 * seconds - 1];
    assert!(at(20).velocity[0] > 1.5, "{:?}", at(20));
    assert!(at(24).gyro[2] > 0.05, "{:?}", at(24));
    assert!(at(28).attitude[1] > at(25).attitude[1] + 0.1, "{:?}", at(28));
    let document = autopilot.interrupt();
    assert_eq!(document["schema"], "seatrial.ardupilot_json.v1");
    assert_eq!(document["frames"], 3000);
    assert_eq!(document["bad_packets"], 0);
}

#[test]
fn cli_repeats_resets_and_bad_packets() {
    let autopilot = Autopilot::start(&["--seed", "7"]);
    let first: Vec<Motion> = (0..50).map(|k| autopilot.step(k, 1700, 1500, 1800)).collect();
    assert_eq!(autopilot.step(49, 1500, 1500, 1500), first[49]);
    for packet in [&b""[..], b"\x1aH", &[0xff; 40], &[0x1a; 1400]] {
        autopilot.socket.send(packet).unwrap();
    }
    // Channel 17 and further: the same frame, another packet.
    let mut pwm = [1500; 32];
    (pwm[0], pwm[2]) = (1700, 1800);
    autopilot.send(29569, 50, &pwm);
    let next = Motion::of(&autopilot.receive());
    assert!((next.time_s - 0.51).abs() < 1e-9, "{next:?}");
    // One frame never came; time goes on by the one that did.
    assert!((autopilot.step(52, 1700, 1500, 1800).time_s - 0.52).abs() < 1e-9);
    let again: Vec<Motion> = (0..50).map(|k| autopilot.step(k, 1700, 1500, 1800)).collect();
    assert_eq!(first, again);
    let document = autopilot.interrupt();
    for (name, count) in [("frames", 102), ("repeated", 1), ("lost", 1), ("resets", 1)] {
        assert_eq!(document[name], count, "{name}");
    }
    assert_eq!(document["bad_packets"], 4);
}

/// A yaw model alone is a plant, too: it starts at rest, gathers way and turns to starboard.
#[test]
fn cli_a_vehicle_that_only_turns_is_driven() {
    let autopilot = Autopilot::start(&["--vehicle", "sim:starfish"]);
    let motions: Vec<Motion> = (0..1500).map(|k| autopilot.step(k, 1700, 1500, 1900)).collect();
    assert!(motions[0].velocity[0].abs() < 0.1, "{:?}", motions[0]);
    let last = motions.last().unwrap();
    let speed_m_s = last.velocity[0].hypot(last.velocity[1]);
    // Thrust of 80 %: 1.63 m/s in the table of the Starfish, after seven time constants of its speed.
    assert!((speed_m_s - 1.63).abs() < 0.01, "{last:?}");
    assert!(last.gyro[2] > 0.05, "{last:?}");
}
