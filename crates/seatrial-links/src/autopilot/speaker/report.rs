//! What a speaking vehicle sends of itself.

use seatrial_core::{Sample, Vehicle};

use super::defaults::{HALF_US, STICKS, SUB_GAIN, TRIM_US};
use super::{Profile, Speaker};
use crate::autopilot::profile::SUB_YAW;
use crate::link::message::{
    Attitude, EkfStatusReport, EstimatorStatus, GpsRawInt, Heartbeat, LocalPositionNed,
    NamedValueFloat, RcChannels, ServoOutputRaw, SysStatus, Text, VfrHud,
};

impl<V: Vehicle<f64>> Speaker<V> {
    pub(super) fn beat(&mut self) {
        self.send(Heartbeat {
            custom_mode: self.mode,
            // A submarine or a boat; PX4 or ArduPilot.
            kind: if self.profile == Profile::Sub { 12 } else { 11 },
            autopilot: if self.profile == Profile::Px4 { 12 } else { 3 },
            base_mode: 1 | if self.is_armed { 0x80 } else { 0 },
            system_status: if self.failsafe { 5 } else { 4 },
            mavlink_version: 3,
        });
    }

    pub(super) fn report(&mut self, sample: &Sample<f64>) {
        let time_boot_ms = (1e3 * sample.time_s).round() as u32;
        let pulse = |fraction: f64| (TRIM_US + HALF_US * fraction).round() as u16;
        let mut pulses = [0; 8];
        let rudder = sample.rudder_rad / self.full_rudder_rad;
        if self.profile == Profile::Sub {
            for (motor, yaw) in pulses.iter_mut().zip(SUB_YAW) {
                *motor = pulse(yaw * SUB_GAIN * rudder);
            }
        } else {
            pulses[0] = pulse(rudder);
            let thrust = self.guided.asked.map(|[_, thrust]| thrust);
            pulses[2] = pulse(thrust.unwrap_or_else(|| self.fraction(2)));
        }
        self.send(ServoOutputRaw {
            time_us: (1e6 * sample.time_s).round() as u64 as u32,
            pulses,
            port: 0,
            more_pulses: [0; 8],
        });
        self.send(Attitude {
            time_boot_ms,
            roll_rad: number(sample.roll_rad),
            pitch_rad: number(sample.pitch_rad),
            yaw_rad: sample.heading_rad as f32,
            roll_rate_rad_s: 0.0,
            pitch_rate_rad_s: 0.0,
            yaw_rate_rad_s: number(sample.yaw_rate_rad_s),
        });
        let every = |seconds: f64| (seconds / self.interval_s).round().max(1.0) as u64;
        let (fifth, whole) = (every(0.2), every(1.0));
        if self.steps.is_multiple_of(fifth) {
            self.report_motion(sample, time_boot_ms);
        }
        if self.steps.is_multiple_of(whole) {
            self.report_health();
        }
    }

    /// What is sent five times a second.
    fn report_motion(&mut self, sample: &Sample<f64>, time_boot_ms: u32) {
        self.send(VfrHud {
            air_speed_m_s: 0.0,
            ground_speed_m_s: number(sample.surge_speed_m_s),
            altitude_m: 0.0,
            climb_m_s: 0.0,
            heading_deg: 0,
            throttle_percent: (100.0 * self.fraction(2)).max(0.0) as u16,
        });
        self.send(LocalPositionNed {
            time_boot_ms,
            north_m: number(sample.north_m),
            east_m: number(sample.east_m),
            down_m: number(sample.depth_m),
            north_m_s: 0.0,
            east_m_s: 0.0,
            down_m_s: 0.0,
        });
        let mut channels = [0; 18];
        for (channel, pulse) in channels.iter_mut().take(STICKS).enumerate() {
            *pulse = self.input_us(channel);
        }
        self.send(RcChannels {
            time_boot_ms,
            pulses: channels,
            count: if self.has_remote_control { STICKS as u8 } else { 0 },
            rssi: 255,
        });
    }

    fn report_health(&mut self) {
        self.beat();
        self.send(SysStatus {
            present: 0,
            enabled: 0,
            health: 0,
            load: 0,
            voltage_mv: 12_000,
            current_ca: -1,
            drop_rate: 0,
            errors: 0,
            error_counts: [0; 4],
            battery_percent: self.battery_percent,
        });
        self.send(GpsRawInt {
            time_us: (1e6 * self.clock_s) as u64,
            latitude: 0,
            longitude: 0,
            altitude_mm: 0,
            eph: 80,
            epv: 80,
            speed_cm_s: 0,
            course_cdeg: 0,
            fix_type: 3,
            satellites: 12,
        });
        if self.profile == Profile::Sub {
            self.send(NamedValueFloat {
                time_boot_ms: (1e3 * self.clock_s) as u32,
                value: SUB_GAIN as f32,
                name: Text::from("PilotGain"),
            });
        }
        // Attitude, velocity and position are known.
        const FLAGS: u16 = 0x1f;
        if self.profile == Profile::Px4 {
            self.send(EstimatorStatus {
                time_us: (1e6 * self.clock_s) as u64,
                velocity_ratio: 0.1,
                horizontal_ratio: 0.1,
                vertical_ratio: 0.1,
                compass_ratio: 0.1,
                terrain_ratio: 0.0,
                air_speed_ratio: 0.0,
                horizontal_accuracy_m: 1.0,
                vertical_accuracy_m: 1.0,
                flags: FLAGS,
            });
            return;
        }
        self.send(EkfStatusReport {
            velocity_variance: 0.1,
            horizontal_variance: 0.1,
            vertical_variance: 0.1,
            compass_variance: 0.1,
            terrain_variance: 0.0,
            flags: FLAGS,
        });
    }
}

fn number(value: Option<f64>) -> f32 {
    value.unwrap_or(0.0) as f32
}
