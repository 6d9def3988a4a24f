//! The standard manoeuvres of ships: what a track says of turning and yaw checking, and the criteria of the IMO.
//!
//! Sources: IMO, Standards for ship manoeuvrability, resolution MSC.137(76) (2002), section 5.3, and its explanatory notes
//! MSC/Circ.1053; ITTC, Recommended procedure 7.5-04-02-01, Full scale manoeuvring trials, for the names.

mod criteria;
mod recorded;

use seatrial_core::Side;
use serde::Serialize;

pub use criteria::{Criterion, criteria, stopping_criterion};
pub use recorded::{
    Kind, NoManoeuvre, PullOut, RecordedManoeuvre, Spiral, SpiralLoop, SpiralRate, Stopping,
    recorded,
};

/// An instant of a manoeuvre. Headings are unwrapped, and position and heading count from where one likes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instant {
    /// Time, s.
    pub time_s: f64,
    /// Heading, rad, clockwise positive, without jumps.
    pub heading_rad: f64,
    /// Forward speed, m/s.
    pub surge_speed_m_s: f64,
    /// North, m.
    pub north_m: f64,
    /// East, m.
    pub east_m: f64,
}

/// A zig-zag: the rudder goes to one side until the heading has changed by as much, then to the other, and so on.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ZigZag {
    /// Rudder angle ordered, rad.
    pub rudder_rad: f64,
    /// Heading change at which the rudder is ordered over, rad: the mean of its executes.
    pub heading_rad: f64,
    /// Side of the first turn.
    pub first_side: Side,
    /// Initial turning time: from the first execute to the second, s.
    pub initial_turning_time_s: f64,
    /// Track reach in it, m.
    pub initial_turning_track_m: f64,
    /// First overshoot angle and those that follow, rad.
    pub overshoots_rad: Vec<f64>,
    /// Time from the second execute to the fourth, s.
    pub period_s: Option<f64>,
}

/// A turning circle under one rudder angle.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TurningCircle {
    /// Side of the turn.
    pub side: Side,
    /// Rudder angle ordered, rad.
    pub rudder_rad: f64,
    /// Advance: along the old course until the heading has changed by 90 degrees, m.
    pub advance_m: f64,
    /// Transfer: across it until then, m.
    pub transfer_m: f64,
    /// Tactical diameter: across it until the heading has changed by 180 degrees, m.
    pub tactical_diameter_m: f64,
    /// Time to change the heading by 90 and 180 degrees, s.
    pub times_s: [f64; 2],
}

/// A figure of a manoeuvre, with the name that the ITTC gives it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Index {
    /// The manoeuvre.
    pub manoeuvre: String,
    /// Its name.
    pub name: &'static str,
    /// Its unit in this list: `deg`, `m`, `s`, `deg/s`.
    pub unit: &'static str,
    /// Its value.
    pub value: f64,
    /// What the uncertainty of the model makes of it, `[low, high]`; absent where it is not known.
    pub interval_95: Option<[f64; 2]>,
}

/// Figures and criteria of one vehicle at one speed: the document of `seatrial manoeuvres --json`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ShipManoeuvres {
    /// `seatrial.ship_manoeuvres.v1`
    pub schema: &'static str,
    /// The vehicle, or the log.
    pub vehicle: String,
    /// Are the figures those of a record, or predicted from a model?
    pub is_predicted: bool,
    /// Thrust as a fraction of full, where it is known.
    pub thrust: Option<f64>,
    /// Forward speed at the beginning, m/s.
    pub surge_speed_m_s: f64,
    /// Length between perpendiculars, m, where it was given.
    pub length_m: Option<f64>,
    /// Is the ship straight-line stable? By the pull-outs from both sides or the spiral of a record, or by the model.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub straight_line_stable: Option<bool>,
    /// The figures.
    pub indices: Vec<Index>,
    /// What the IMO requires of them; empty without a length.
    pub criteria: Vec<Criterion>,
    /// What has to be known of them.
    pub notes: Vec<String>,
}

impl ZigZag {
    /// What a track says, from its first instant on; `executes` are the instants at which the rudder was ordered over, the
    /// first of them the first order. `None` under two swings.
    ///
    /// An overshoot angle is how far the heading goes on past the one at which the rudder was ordered over.
    ///
    /// ```
    /// use seatrial::sea_trials::ship_manoeuvres::{Instant, ZigZag};
    ///
    /// // Headings at the first order, at 10 deg, at the furthest and at 10 deg to the other side.
    /// let at = |time_s: f64, heading_deg: f64| Instant {
    ///     time_s,
    ///     heading_rad: heading_deg.to_radians(),
    ///     surge_speed_m_s: 4.0,
    ///     north_m: 4.0 * time_s,
    ///     east_m: 0.0,
    /// };
    /// let track = [at(0.0, 0.0), at(20.0, 10.0), at(30.0, 16.0), at(60.0, -10.0)];
    /// let found = ZigZag::of(&track, &[0, 1, 3], 0.1745).ok_or("two swings")?;
    /// assert!((found.overshoots_rad[0].to_degrees() - 6.0).abs() < 1e-9);
    /// assert_eq!((found.initial_turning_time_s, found.initial_turning_track_m), (20.0, 80.0));
    /// assert!(found.is_of(10.0));
    /// # Ok::<(), &str>(())
    /// ```
    pub fn of(track: &[Instant], executes: &[usize], rudder_rad: f64) -> Option<Self> {
        let at = |k: usize| track.get(*executes.get(k)?);
        let (first, second) = (at(0)?, at(1)?);
        let initial = track.get(executes[0]..=executes[1])?;
        let overshoots_rad = executes
            .windows(3)
            .map(|of| overshoot(track.get(of[1]..=of[2])?, track.get(of[0])?.heading_rad))
            .collect::<Option<Vec<f64>>>()?;
        let changes: Vec<f64> = (1..executes.len())
            .filter_map(|k| Some(at(k)?.heading_rad - first.heading_rad))
            .collect();
        let sum: f64 = changes.iter().map(|change| change.abs()).sum();
        (!overshoots_rad.is_empty()).then(|| Self {
            rudder_rad,
            heading_rad: sum / changes.len() as f64,
            first_side: match second.heading_rad > first.heading_rad {
                true => Side::Starboard,
                false => Side::Port,
            },
            initial_turning_time_s: second.time_s - first.time_s,
            initial_turning_track_m: track_m(initial),
            overshoots_rad,
            period_s: at(3).map(|fourth| fourth.time_s - second.time_s),
        })
    }
}

impl ZigZag {
    /// Is it the zig-zag of this rudder angle and heading change, to 2 degrees?
    pub fn is_of(&self, angle_deg: f64) -> bool {
        let is_near = |angle_rad: f64| (angle_rad.to_degrees() - angle_deg).abs() < 2.0;
        is_near(self.rudder_rad) && is_near(self.heading_rad)
    }
}

/// How far the heading goes on past that of the first instant, away from the one at which the rudder was ordered over before, rad.
fn overshoot(swing: &[Instant], before_rad: f64) -> Option<f64> {
    let executed_rad = swing.first()?.heading_rad - before_rad;
    let side = executed_rad.signum();
    let along = swing.iter().map(|at| side * (at.heading_rad - before_rad));
    Some(along.fold(f64::NEG_INFINITY, f64::max) - side * executed_rad)
}

/// The way along a track, m.
fn track_m(track: &[Instant]) -> f64 {
    let steps = track.windows(2);
    steps
        .map(|pair| libm::hypot(pair[1].north_m - pair[0].north_m, pair[1].east_m - pair[0].east_m))
        .sum()
}

impl TurningCircle {
    /// What a track says, from the execute at its first instant on. `None` where it turns by less than 180 degrees.
    ///
    /// ```
    /// use seatrial::sea_trials::ship_manoeuvres::{Instant, TurningCircle};
    ///
    /// // A circle of 200 m to port at 0.02 rad/s, from north.
    /// let track: Vec<_> = (0..200)
    ///     .map(|k| {
    ///         let turned = 0.02 * f64::from(k);
    ///         Instant {
    ///             time_s: f64::from(k),
    ///             heading_rad: -turned,
    ///             surge_speed_m_s: 4.0,
    ///             north_m: 200.0 * turned.sin(),
    ///             east_m: -200.0 * (1.0 - turned.cos()),
    ///         }
    ///     })
    ///     .collect();
    /// let circle = TurningCircle::of(&track, 0.6).ok_or("half a turn")?;
    /// assert!((circle.advance_m - 200.0).abs() < 0.1);
    /// // Across the course to the side of the turn, whichever it is.
    /// assert!((circle.tactical_diameter_m - 400.0).abs() < 0.1);
    /// assert_eq!(TurningCircle::of(&track[..100], 0.6), None);
    /// # Ok::<(), &str>(())
    /// ```
    pub fn of(track: &[Instant], rudder_rad: f64) -> Option<Self> {
        let start = track.first()?;
        let last = track.last()?;
        let side = (last.heading_rad - start.heading_rad).signum();
        let turned = |at: &Instant| side * (at.heading_rad - start.heading_rad);
        let (sin, cos) = libm::sincos(start.heading_rad);
        let from_start = |at: &Instant| {
            let (north, east) = (at.north_m - start.north_m, at.east_m - start.east_m);
            [north * cos + east * sin, side * (east * cos - north * sin)]
        };
        let after = |angle_rad: f64| {
            let reached = track.iter().position(|at| turned(at) >= angle_rad)?;
            let (before, now) = (track.get(reached.checked_sub(1)?)?, track.get(reached)?);
            let share = (angle_rad - turned(before)) / (turned(now) - turned(before));
            let between = |a: f64, b: f64| a + share * (b - a);
            let [[ahead_a, aside_a], [ahead_b, aside_b]] = [from_start(before), from_start(now)];
            Some([
                between(before.time_s, now.time_s) - start.time_s,
                between(ahead_a, ahead_b),
                between(aside_a, aside_b),
            ])
        };
        let [quarter_s, advance_m, transfer_m] = after(std::f64::consts::FRAC_PI_2)?;
        let [half_s, _, tactical_diameter_m] = after(std::f64::consts::PI)?;
        Some(Self {
            side: if side > 0.0 { Side::Starboard } else { Side::Port },
            rudder_rad,
            advance_m,
            transfer_m,
            tactical_diameter_m,
            times_s: [quarter_s, half_s],
        })
    }
}
