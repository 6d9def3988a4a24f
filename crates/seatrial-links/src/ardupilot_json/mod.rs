//! ArduPilot's JSON simulation interface: the commands to its servos and the readings of its sensors.
//!
//! ```text
//! from ArduPilot  u16 magic, u16 frame rate, u32 frame count, u16 pwm[16 or 32], little endian
//! to ArduPilot    \\n{"timestamp":s,"imu":{"gyro":[..],"accel_body":[..]},"position":[..],"attitude":[..],"velocity":[..]}\\n
//! ```
//!
//! Source: the readme of `libraries/SITL/examples/JSON` in ArduPilot's repository.

pub mod channel;

use thiserror::Error;

/// Magic of a packet with 16 and with 32 channels.
const MAGICS: [(u16, usize); 2] = [(18458, 16), (29569, 32)];
/// Bytes before the channels.
const HEADER: usize = 8;

/// What ArduPilot tells its servos.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ServoFrame {
    /// Frames a second of simulated time, at least 1.
    pub rate_hz: u16,
    /// Counts the frames.
    pub count: u32,
    pwm_us: [u16; 32],
    channels: usize,
}

/// A packet that is not a servo frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum ServoFrameError {
    /// Not one of ArduPilot's magic numbers.
    #[error("magic {0}, expected 18458 or 29569")]
    Magic(u16),
    /// Too short or too long.
    #[error("{found} bytes, expected {expected}")]
    Length {
        /// Bytes in the packet.
        found: usize,
        /// Bytes that its magic asks for.
        expected: usize,
    },
    /// Time would stand still.
    #[error("a frame rate of 0")]
    Rate,
}

impl ServoFrame {
    /// The frame of a packet.
    pub fn parse(packet: &[u8]) -> Result<Self, ServoFrameError> {
        let word = |at: usize| {
            let bytes = packet.get(at..at + 2)?.try_into().ok()?;
            Some(u16::from_le_bytes(bytes))
        };
        let short = |expected| ServoFrameError::Length { found: packet.len(), expected };
        let magic = word(0).ok_or(short(HEADER))?;
        let (_, channels) = MAGICS
            .into_iter()
            .find(|(known, _)| *known == magic)
            .ok_or(ServoFrameError::Magic(magic))?;
        let expected = HEADER + 2 * channels;
        if packet.len() != expected {
            return Err(short(expected));
        }
        let read = |at: usize| word(at).ok_or(short(expected));
        let mut pwm_us = [0; 32];
        for (k, pwm_us) in pwm_us.iter_mut().take(channels).enumerate() {
            *pwm_us = read(HEADER + 2 * k)?;
        }
        let frame = Self {
            rate_hz: read(2)?,
            count: u32::from(read(4)?) | u32::from(read(6)?) << 16,
            pwm_us,
            channels,
        };
        if frame.rate_hz == 0 {
            return Err(ServoFrameError::Rate);
        }
        Ok(frame)
    }

    /// The pulse of a channel, counted from 1, us; `None` where the frame does not have it.
    pub fn pwm_us(&self, channel: usize) -> Option<u16> {
        self.pwm_us[..self.channels].get(channel.checked_sub(1)?).copied()
    }
}

/// What ArduPilot's sensors are to read. Body axes are forward, starboard, down; earth's north, east, down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorFrame {
    /// Time of the simulation, s.
    pub time_s: f64,
    /// Angular velocity, rad/s.
    pub gyro_rad_s: [f64; 3],
    /// Acceleration less gravity, m/s^2: (0, 0, -9.81) at rest.
    pub accelerometer_m_s2: [f64; 3],
    /// Position, m.
    pub position_m: [f64; 3],
    /// Roll, pitch and heading, rad.
    pub attitude_rad: [f64; 3],
    /// Velocity, m/s.
    pub velocity_m_s: [f64; 3],
}

impl SensorFrame {
    /// The frame as a line of JSON between two newlines, without blanks, as ArduPilot's own parser looks for the fields.
    pub fn line(&self) -> String {
        let vector = |[x, y, z]: [f64; 3]| format!("[{x},{y},{z}]");
        format!(
            "\n{{\"timestamp\":{},\"imu\":{{\"gyro\":{},\"accel_body\":{}}},\"position\":{},\"attitude\":{},\"velocity\":{}}}\n",
            self.time_s,
            vector(self.gyro_rad_s),
            vector(self.accelerometer_m_s2),
            vector(self.position_m),
            vector(self.attitude_rad),
            vector(self.velocity_m_s),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Magic 18458, 50 Hz, frame 65537, channels 1000, 1001 and so on.
    fn packet(channels: u16) -> Vec<u8> {
        let magic: u16 = if channels == 16 { 18458 } else { 29569 };
        let mut bytes: Vec<u8> = [magic, 50, 1, 1].iter().flat_map(|w| w.to_le_bytes()).collect();
        bytes.extend((1000..1000 + channels).flat_map(u16::to_le_bytes));
        bytes
    }

    #[test]
    fn io_both_kinds_of_packets() {
        for channels in [16, 32] {
            let frame = ServoFrame::parse(&packet(channels)).unwrap();
            assert_eq!((frame.rate_hz, frame.count), (50, 65537));
            assert_eq!(frame.pwm_us(1), Some(1000));
            assert_eq!(frame.pwm_us(usize::from(channels)), Some(999 + channels));
            assert_eq!(frame.pwm_us(usize::from(channels) + 1), None);
            assert_eq!(frame.pwm_us(0), None);
        }
    }

    #[test]
    fn io_every_truncation_and_a_wrong_magic_are_refused() {
        let whole = packet(32);
        for length in 0..whole.len() {
            let error = ServoFrame::parse(&whole[..length]).unwrap_err();
            assert!(matches!(error, ServoFrameError::Length { found, .. } if found == length));
        }
        let mut wrong = whole.clone();
        wrong[0] ^= 1;
        assert!(matches!(ServoFrame::parse(&wrong), Err(ServoFrameError::Magic(_))));
        let mut still = whole.clone();
        still[2..4].fill(0);
        assert_eq!(ServoFrame::parse(&still), Err(ServoFrameError::Rate));
        let longer: Vec<u8> = whole.into_iter().chain([0]).collect();
        assert!(ServoFrame::parse(&longer).is_err());
    }

    #[test]
    fn exact_a_line_as_documented() {
        let frame = SensorFrame {
            time_s: 2500.0,
            gyro_rad_s: [0.0; 3],
            accelerometer_m_s2: [0.0, 0.0, -9.81],
            position_m: [0.0, 0.0, 1e-7],
            attitude_rad: [0.0; 3],
            velocity_m_s: [0.0; 3],
        };
        let expected = "\n{\"timestamp\":2500,\"imu\":{\"gyro\":[0,0,0],\"accel_body\":[0,0,-9.81]},\
                        \"position\":[0,0,0.0000001],\"attitude\":[0,0,0],\"velocity\":[0,0,0]}\n";
        assert_eq!(frame.line(), expected);
    }
}
