//! Standard manoeuvres of ship trials: turning, zig-zag, spiral.

use seatrial_core::{Real, Sample, Steering, Vehicle};
use serde::Serialize;

use super::pilot::{Pilot, mean, turned_rad};
use super::{FieldError, FieldSettings};

/// Time on each rudder angle of the spiral, s; the mean of its last third counts.
const SPIRAL_STEP_S: f64 = 40.0;
/// Switches of the rudder in a zig-zag.
const SWITCHES: usize = 5;
/// Longest that a zig-zag may take, s.
const LONGEST_S: f64 = 600.0;

/// Turning, zig-zag and spiral at one thrust.
///
/// Source: IMO, Standards for ship manoeuvrability, MSC.137(76) (2002), for the zig-zag; Dieudonne's spiral and its
/// definition in the ITTC procedure 7.5-04-02-01. A vehicle that is stable on its course draws one curve r(delta)
/// however it came to delta; one that is not draws a loop.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StandardManoeuvres {
    /// Thrust as a fraction of full.
    pub thrust: f64,
    /// Mean forward speed straight ahead, m/s.
    pub straight_speed_m_s: f64,
    /// The zig-zags, by the heading change at which the rudder is laid over.
    pub zig_zags: Vec<ZigZag>,
    /// From starboard to port and back.
    pub spiral: Vec<SpiralPoint>,
}

/// Rudder to one side until the heading has changed by as much, then to the other.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ZigZag {
    /// Rudder angle asked for, rad.
    pub rudder_rad: f64,
    /// Heading change at which it is laid over, rad.
    pub heading_rad: f64,
    /// Time until the first time, s.
    pub initial_turning_time_s: f64,
    /// Heading past the change, of each swing but the last, rad.
    pub overshoots_rad: Vec<f64>,
    /// Time between the first and the third, s.
    pub period_s: f64,
    /// Time, heading and rudder, s and rad.
    #[serde(skip)]
    pub series: Vec<[f64; 3]>,
}

/// The steady turn of a rudder angle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SpiralPoint {
    /// Rudder angle, rad.
    pub rudder_rad: f64,
    /// Yaw rate, rad/s.
    pub yaw_rate_rad_s: f64,
    /// Forward speed, m/s.
    pub surge_speed_m_s: f64,
}

impl StandardManoeuvres {
    /// Makes them at a thrust: zig-zags of 10 and 20 degrees, a spiral over `spiral_rudders_rad` and back.
    pub fn make<V: Vehicle<f64>>(
        vehicle: &mut V,
        thrust: f64,
        spiral_rudders_rad: &[f64],
    ) -> Result<Self, FieldError> {
        let settle_s = FieldSettings::default().settle_s;
        let mut pilot = Pilot::new(vehicle);
        let course = pilot.hold(settle_s, thrust)?;
        let later = &course[course.len() / 2..];
        let straight_speed_m_s = mean(later, "forward speed", |s| s.surge_speed_m_s)?;
        let mut zig_zags = Vec::new();
        for degrees in [10_f64, 20.0] {
            zig_zags.push(ZigZag::make(&mut pilot, thrust, degrees.to_radians())?);
            pilot.hold(settle_s, thrust)?;
        }
        let back = spiral_rudders_rad.iter().rev().skip(1);
        let spiral = spiral_rudders_rad
            .iter()
            .chain(back)
            .map(|rudder_rad| SpiralPoint::make(&mut pilot, thrust, *rudder_rad))
            .collect::<Result<_, _>>()?;
        Ok(Self {
            thrust,
            straight_speed_m_s,
            zig_zags,
            spiral,
        })
    }
}

impl ZigZag {
    fn make<V: Vehicle<f64>>(
        pilot: &mut Pilot<V>,
        thrust: f64,
        angle_rad: f64,
    ) -> Result<Self, FieldError> {
        let mut base_rad = None;
        let mut side = 1.0;
        let mut switches_s: Vec<f64> = Vec::new();
        let samples = pilot.steer(LONGEST_S, thrust, |sample: &Sample<f64>| {
            let base_rad = *base_rad.get_or_insert(sample.heading_rad);
            let turned_rad = (sample.heading_rad - base_rad).wrapped();
            if side * turned_rad >= angle_rad {
                side = -side;
                switches_s.push(sample.time_s);
            }
            (switches_s.len() < SWITCHES).then_some(Steering::Rudder(side * angle_rad))
        })?;
        let start_s = samples[0].time_s;
        let [first_s, _, third_s, ..] = switches_s[..] else {
            return Err(FieldError::NotRound {
                thrust,
                turned_rad: turned_rad(&samples).last().copied().unwrap_or(0.0),
                seconds: LONGEST_S,
            });
        };
        let headings = turned_rad(&samples);
        let overshoot = |between: &[f64]| {
            let swing = samples.iter().zip(&headings);
            let inside = swing.filter(|(s, _)| between[0] <= s.time_s && s.time_s < between[1]);
            let furthest = inside.map(|(_, heading)| heading.abs()).fold(0.0, f64::max);
            furthest - angle_rad
        };
        Ok(Self {
            rudder_rad: angle_rad,
            heading_rad: angle_rad,
            initial_turning_time_s: first_s - start_s,
            overshoots_rad: switches_s.windows(2).map(overshoot).collect(),
            period_s: third_s - first_s,
            series: samples
                .iter()
                .zip(&headings)
                .map(|(s, heading)| [s.time_s - start_s, *heading, s.rudder_rad])
                .collect(),
        })
    }
}

impl SpiralPoint {
    fn make<V: Vehicle<f64>>(
        pilot: &mut Pilot<V>,
        thrust: f64,
        rudder_rad: f64,
    ) -> Result<Self, FieldError> {
        let samples = pilot.steer(SPIRAL_STEP_S, thrust, |_| {
            Some(Steering::Rudder(rudder_rad))
        })?;
        let settled = &samples[2 * samples.len() / 3..];
        let turned = turned_rad(settled);
        let lasted_s = settled[settled.len() - 1].time_s - settled[0].time_s;
        Ok(Self {
            rudder_rad,
            yaw_rate_rad_s: turned.last().copied().unwrap_or(0.0) / lasted_s,
            surge_speed_m_s: mean(settled, "forward speed", |s| s.surge_speed_m_s)?,
        })
    }
}
