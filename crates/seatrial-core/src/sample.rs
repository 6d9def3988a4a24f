//! What goes into the trial and what comes out: [`Sample`], [`Action`] and the [`Vehicle`] between them.

use crate::Real;

/// One instant of a vehicle, in SI units. What a vehicle does not measure is `None`.
///
/// ```
/// use seatrial_core::Sample;
///
/// // A vehicle without depth sensor and gyro: what is not measured is not 0.
/// let sample = Sample { time_s: 12.5, heading_rad: 1.6, rudder_rad: -0.1, ..Sample::default() };
/// assert_eq!((sample.depth_m, sample.yaw_rate_rad_s), (None, None));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Sample<T> {
    /// The vehicle's own clock, s.
    pub time_s: f64,
    /// Heading psi, rad, wrapped or not. On the axis of pitch the pitch, see [`Axis`](crate::Axis).
    pub heading_rad: T,
    /// Rudder angle delta that acts from this instant on, rad. On the axis of pitch the elevator.
    pub rudder_rad: T,
    /// Forward speed u, m/s.
    pub surge_speed_m_s: Option<T>,
    /// Depth below the surface, m, positive down.
    pub depth_m: Option<T>,
    /// Height above the bottom, m.
    pub altitude_m: Option<T>,
    /// Roll phi, rad, positive starboard down.
    pub roll_rad: Option<T>,
    /// Pitch theta, rad, positive bow up.
    pub pitch_rad: Option<T>,
    /// Measured yaw rate r, rad/s, positive with increasing heading.
    pub yaw_rate_rad_s: Option<T>,
    /// Position north of the origin, m.
    pub north_m: Option<T>,
    /// Position east of the origin, m.
    pub east_m: Option<T>,
    /// Thrust that is asked for, as a fraction of full.
    pub thrust: Option<T>,
}

/// How the vehicle is to steer until the next action.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Steering<T> {
    /// Hold this rudder angle, rad.
    Rudder(T),
    /// The vehicle's heading controller holds this heading, rad; on the axis of pitch it holds its depth.
    HoldHeading(T),
}

/// What the vehicle is to do until the next action.
#[must_use = "an action that is not carried out leaves the vehicle on its previous one"]
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Action<T> {
    /// Rudder or heading hold.
    pub steering: Steering<T>,
    /// Thrust as a fraction of full, 0 to 1. `None` gives it back to the vehicle: its own setting
    /// from before the first thrust of the trial.
    pub thrust: Option<T>,
    /// Set once the trial is over: this is the last action.
    pub outcome: Option<Outcome>,
}

/// How a trial ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case", tag = "state", content = "reason"))]
pub enum Outcome {
    /// Every speed was run; the vehicle is sent home.
    Finished,
    /// Stopped for this reason; the vehicle holds its heading with neutral rudder and its first thrust.
    Aborted(AbortReason),
}

/// Why a trial was stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum AbortReason {
    /// The operator asked for it.
    Operator,
    /// Depth outside the envelope.
    Depth,
    /// Too close to the bottom.
    Altitude,
    /// Roll outside the envelope.
    Roll,
    /// Pitch outside the envelope.
    Pitch,
    /// Yaw rate outside the envelope.
    YawRate,
    /// Heading too far from the heading of the run.
    HeadingExcursion,
    /// Outside the area polygon.
    Area,
    /// Speed changed too much during a stage.
    SpeedDrift,
    /// No new usable sample for too long.
    StaleSamples,
    /// A stage took longer than its limit.
    StageTimeLimit,
    /// The vehicle turned against the rudder.
    ReversedRudder,
    /// The vehicle did not settle in the time allowed.
    NotSettled,
    /// The link to the vehicle was lost.
    LinkLost,
    /// The pilot changed the mode.
    ModeChanged,
    /// The pilot moved a stick.
    StickMoved,
    /// The vehicle was disarmed.
    Disarmed,
    /// The battery was low.
    LowBattery,
    /// The autopilot reported a failsafe.
    Failsafe,
    /// The autopilot started again.
    Restarted,
    /// Somebody else commanded the vehicle under our name.
    SecondStation,
    /// The rudder did something else than asked for.
    RudderNotFollowed,
    /// The program that conducts the trial was held up.
    NotAttended,
    /// The heading did not answer the rudder.
    NoAnswer,
}

impl AbortReason {
    /// Did the vehicle do something that no model of the trial explains? Its models are then not to be used.
    ///
    /// ```
    /// use seatrial_core::AbortReason;
    ///
    /// assert!(AbortReason::ReversedRudder.contradicts_the_models());
    /// assert!(!AbortReason::LowBattery.contradicts_the_models());
    /// assert_eq!(AbortReason::LowBattery.to_string(), "the battery was low");
    /// ```
    pub fn contradicts_the_models(self) -> bool {
        matches!(self, Self::ReversedRudder | Self::RudderNotFollowed)
    }
}

impl core::fmt::Display for AbortReason {
    fn fmt(&self, f: &mut core::fmt::Formatter) -> core::fmt::Result {
        f.write_str(match self {
            Self::Operator => "the operator asked for it",
            Self::Depth => "depth outside the envelope",
            Self::Altitude => "too close to the bottom",
            Self::Roll => "roll outside the envelope",
            Self::Pitch => "pitch outside the envelope",
            Self::YawRate => "yaw rate outside the envelope",
            Self::HeadingExcursion => "heading too far from the heading of the run",
            Self::Area => "outside the area",
            Self::SpeedDrift => "the speed changed too much during a manoeuvre",
            Self::StaleSamples => "no usable sample for too long",
            Self::StageTimeLimit => "a stage took longer than its limit",
            Self::ReversedRudder => "the vehicle turned against the rudder",
            Self::NotSettled => "the vehicle did not settle in the time allowed",
            Self::LinkLost => "the link to the vehicle was lost",
            Self::ModeChanged => "the pilot changed the mode",
            Self::StickMoved => "the pilot moved a stick",
            Self::Disarmed => "the vehicle was disarmed",
            Self::LowBattery => "the battery was low",
            Self::Failsafe => "the autopilot reported a failsafe",
            Self::Restarted => "the autopilot started again",
            Self::SecondStation => "somebody else commanded the vehicle under our name",
            Self::RudderNotFollowed => "the rudder did something else than asked for",
            Self::NotAttended => "the program that conducts the trial was held up",
            Self::NoAnswer => "the heading did not answer the rudder",
        })
    }
}

/// A vehicle, simulated or real: gives the next sample, carries out an action.
///
/// A trial calls [`next_sample`](Vehicle::next_sample) and [`act`](Vehicle::act) in turn, once each, and
/// [`act`](Vehicle::act) alone to give a lost vehicle its heading back. An error of either, or the end
/// of the samples, ends the trial as [`AbortReason::LinkLost`], unless [`ended_for`](Vehicle::ended_for) says otherwise.
pub trait Vehicle<T: Real> {
    /// What can go wrong with this vehicle's link.
    type Error;

    /// Waits for the next sample. Its `rudder_rad` must be the rudder that acts from its `time_s` until the next sample: an
    /// error of one sample moves a22 by about a tenth. `None` when the vehicle has no more (a log's end, a closed link).
    fn next_sample(&mut self) -> Result<Option<Sample<T>>, Self::Error>;

    /// Carries out an action, which holds until the next one. It should not wait for the vehicle to obey.
    fn act(&mut self, action: &Action<T>) -> Result<(), Self::Error>;

    /// Does it go on while nobody asks for its next sample? Time stands still for any other, as in a simulator or a log.
    fn is_live(&self) -> bool {
        false
    }

    /// Has the vehicle's operator taken it over? It then takes no more commands.
    fn is_taken_over(&self) -> bool {
        false
    }

    /// Why it gives no more samples, where that is not a lost link.
    fn ended_for(&self) -> Option<AbortReason> {
        None
    }
}
