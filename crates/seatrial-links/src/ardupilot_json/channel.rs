//! Servo channels: which pulses are which deflection.

use std::str::FromStr;

use thiserror::Error;

use super::ServoFrame;

/// A servo channel and its pulses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Channel {
    number: usize,
    /// Least, middle and greatest deflection, us.
    pulses_us: [f64; 3],
}

/// Text that is no channel.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum ChannelError {
    /// The text has another form.
    #[error("{0}: expected NUMBER or NUMBER:MIN:TRIM:MAX in us, as in 1:1100:1500:1900")]
    Form(String),
    /// There is no channel of this number.
    #[error("{0}: channels are 1 to 32")]
    Number(String),
    /// The pulses are not in order.
    #[error("{0}: the trim has to lie between MIN and MAX")]
    Trim(String),
}

impl FromStr for Channel {
    type Err = ChannelError;

    fn from_str(text: &str) -> Result<Self, ChannelError> {
        let expected = || ChannelError::Form(text.into());
        let numbers: Vec<u16> = text
            .split(':')
            .map(|part| part.parse().map_err(|_| expected()))
            .collect::<Result<_, _>>()?;
        let (number, pulses_us) = match numbers[..] {
            [number] => (number, [1000, 1500, 2000]),
            [number, min, trim, max] => (number, [min, trim, max]),
            _ => return Err(expected()),
        };
        if !(1..=32).contains(&number) {
            return Err(ChannelError::Number(text.into()));
        }
        let pulses_us = pulses_us.map(f64::from);
        let [min, trim, max] = pulses_us;
        let in_order = (min <= trim && trim < max) || (min >= trim && trim > max);
        if !in_order {
            return Err(ChannelError::Trim(text.into()));
        }
        Ok(Self { number: usize::from(number), pulses_us })
    }
}

impl Channel {
    /// The deflection of a frame, -1 to 1; `None` where the frame does not have the channel.
    pub fn deflection(&self, frame: &ServoFrame) -> Option<f64> {
        let [min, trim, max] = self.pulses_us;
        let pulse_us = match frame.pwm_us(self.number)? {
            0 => trim,
            pulse_us => f64::from(pulse_us),
        };
        let off = pulse_us - trim;
        let towards_max = off * (max - trim) >= 0.0;
        Some(match towards_max {
            true => (off / (max - trim)).min(1.0),
            false if min == trim => 0.0,
            false => (-off / (min - trim)).max(-1.0),
        })
    }
}

/// What thrusters do together, -1 to 1; `None` where the frame does not have one of them.
pub fn mean_deflection(channels: &[Channel], frame: &ServoFrame) -> Option<f64> {
    let deflections = channels.iter().map(|channel| channel.deflection(frame));
    let sum = deflections.sum::<Option<f64>>()?;
    Some(sum / channels.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(pulse_us: u16) -> ServoFrame {
        let words = [18458_u16, 50, 0, 0].into_iter().chain([pulse_us; 16]);
        let packet: Vec<u8> = words.flat_map(u16::to_le_bytes).collect();
        ServoFrame::parse(&packet).unwrap()
    }

    #[test]
    fn exact_deflections_of_a_channel() {
        let of = |channel: &str, pulse_us| {
            let channel: Channel = channel.parse().unwrap();
            channel.deflection(&frame(pulse_us))
        };
        for (channel, pulse_us, expected) in [
            ("1", 1500, 0.0),
            ("1", 1750, 0.5),
            ("1", 800, -1.0),
            ("1", 0, 0.0),
            ("4:1100:1600:1900", 1750, 0.5),
            ("4:1100:1600:1900", 1350, -0.5),
            ("4:1900:1500:1100", 1900, -1.0),
            ("4:1900:1500:1100", 1300, 0.5),
            ("3:1000:1000:2000", 1250, 0.25),
            ("3:1000:1000:2000", 900, 0.0),
        ] {
            assert_eq!(of(channel, pulse_us), Some(expected), "{channel} {pulse_us}");
        }
        assert_eq!(of("17", 1500), None);
    }

    /// ArduSub's horizontal thrusters at a yaw of 0.2 and a thrust of 0.3.
    #[test]
    fn exact_thrusters_that_share_rudder_and_throttle() {
        let mut words = [1500_u16; 20];
        words[..4].copy_from_slice(&[18458, 50, 0, 0]);
        words[4..8].copy_from_slice(&[1460, 1300, 1540, 1700]);
        let packet: Vec<u8> = words.into_iter().flat_map(u16::to_le_bytes).collect();
        let frame = ServoFrame::parse(&packet).unwrap();
        let shared = |text: &str| {
            let channels: Vec<Channel> = text.split(',').map(|c| c.parse().unwrap()).collect();
            mean_deflection(&channels, &frame).unwrap()
        };
        let yaw = shared("1:1100:1500:1900,2:1900:1500:1100,3:1900:1500:1100,4:1100:1500:1900");
        let forward = shared("1:1900:1500:1100,2:1900:1500:1100,3:1100:1500:1900,4:1100:1500:1900");
        // Few roundings.
        assert!((yaw - 0.2).abs() < 1e-12 && (forward - 0.3).abs() < 1e-12);
    }

    #[test]
    fn io_channels_that_make_no_sense_are_refused() {
        for text in ["", "x", "0", "33", "1:1000", "1:1000:2100:2000", "1:1500:1500:1500"] {
            assert!(text.parse::<Channel>().is_err(), "{text}");
        }
    }
}
