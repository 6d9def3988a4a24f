//! Models over speed or thrust: interpolation and marked extrapolation.

use core::fmt;

use crate::{Real, YawModel};

/// The most points that a schedule holds.
pub const CAPACITY: usize = 16;

/// What a schedule is looked up by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum ScheduleKey {
    /// Thrust as a fraction of full.
    Thrust,
    /// Forward speed, m/s.
    Speed,
}

impl ScheduleKey {
    /// As a person reads it.
    ///
    /// ```
    /// use seatrial_core::schedule::ScheduleKey;
    ///
    /// assert_eq!([ScheduleKey::Thrust, ScheduleKey::Speed].map(ScheduleKey::name), ["thrust", "speed"]);
    /// ```
    pub fn name(self) -> &'static str {
        match self {
            Self::Thrust => "thrust",
            Self::Speed => "speed",
        }
    }
}

/// What to do outside the identified range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Beyond {
    /// Answer with [`ScheduleError::Outside`].
    Refuse,
    /// Continue the outermost segment and mark the result.
    Extrapolate,
}

/// A value from a schedule, marked by whether the trial covered it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ScheduleValue<V> {
    /// Inside the identified range.
    Interpolated(V),
    /// Outside it: an assumption, not a measurement.
    Extrapolated(V),
}

impl<V> ScheduleValue<V> {
    /// The value, however it was found.
    ///
    /// ```
    /// use seatrial_core::schedule::ScheduleValue;
    ///
    /// assert_eq!(ScheduleValue::Extrapolated(0.4).value(), ScheduleValue::Interpolated(0.4).value());
    /// ```
    pub fn value(&self) -> &V {
        match self {
            Self::Interpolated(value) | Self::Extrapolated(value) => value,
        }
    }

    /// Outside the identified range?
    ///
    /// ```
    /// use seatrial_core::schedule::ScheduleValue;
    ///
    /// assert!(ScheduleValue::Extrapolated(0.4).is_extrapolated());
    /// ```
    pub fn is_extrapolated(&self) -> bool {
        matches!(self, Self::Extrapolated(_))
    }

    pub(crate) fn marked(value: V, inside: bool) -> Self {
        if inside { Self::Interpolated(value) } else { Self::Extrapolated(value) }
    }
}

/// The model of one speed, equation (10).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SchedulePoint<T> {
    /// Thrust as a fraction of full.
    pub thrust: Option<T>,
    /// Forward speed, m/s.
    pub surge_speed_m_s: Option<T>,
    /// The model identified there.
    pub model: YawModel<T>,
}

impl<T: Real> SchedulePoint<T> {
    /// The point's place in a schedule by this key.
    ///
    /// ```
    /// use seatrial_core::schedule::{ScheduleKey, SchedulePoint};
    ///
    /// let point =
    ///     SchedulePoint { thrust: Some(0.8), surge_speed_m_s: None::<f64>, model: Default::default() };
    /// assert_eq!(point.key(ScheduleKey::Thrust), Some(0.8));
    /// assert_eq!(point.key(ScheduleKey::Speed), None);
    /// ```
    pub fn key(&self, key: ScheduleKey) -> Option<T> {
        match key {
            ScheduleKey::Thrust => self.thrust,
            ScheduleKey::Speed => self.surge_speed_m_s,
        }
    }

    pub(crate) fn is_finite(&self) -> bool {
        self.model.theta().iter().all(|p| p.is_finite())
            && [self.thrust, self.surge_speed_m_s].iter().flatten().all(|k| k.is_finite())
    }
}

/// Why there is no schedule, no fit of authority or no value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ScheduleError {
    /// Fewer points than the task needs.
    TooFewPoints {
        /// Points with what the task needs.
        found: usize,
        /// Points needed.
        needed: usize,
    },
    /// More points than [`CAPACITY`].
    TooManyPoints {
        /// Points given.
        found: usize,
    },
    /// A point without the key of the schedule, or whose key is not positive.
    MissingKey {
        /// Which point, from 0.
        index: usize,
        /// The key of the schedule.
        key: ScheduleKey,
    },
    /// Two points at one key.
    DuplicateKey {
        /// The value that occurs twice.
        at: f64,
    },
    /// NaN or infinite.
    NonFinite {
        /// Which point, from 0.
        index: usize,
    },
    /// Asked outside the identified range without permission to extrapolate.
    Outside {
        /// What was asked for.
        at: f64,
        /// Least key of the schedule.
        from: f64,
        /// Greatest key of the schedule.
        to: f64,
    },
    /// Asked for a key that is negative, NaN or infinite.
    InvalidKey,
    /// Extrapolated so far that speed, rudder authority or gain would change sign.
    TooFar {
        /// What was asked for.
        at: f64,
    },
}

impl fmt::Display for ScheduleError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooFewPoints { found, needed } => {
                write!(f, "{found} usable points, at least {needed} at different speeds are needed")
            }
            Self::TooManyPoints { found } => {
                write!(f, "{found} points, a schedule holds at most {CAPACITY}")
            }
            Self::MissingKey { index, key } => write!(
                f,
                "point {} has no positive {}, by which the schedule is ordered",
                index + 1,
                key.name()
            ),
            Self::DuplicateKey { at } => {
                write!(f, "two points at {at}: choose one of the two runs or average them")
            }
            Self::NonFinite { index } => {
                write!(f, "point {} has a value that is not finite", index + 1)
            }
            Self::Outside { at, from, to } => write!(
                f,
                "{at} is outside the identified range {from} to {to}; it can only be extrapolated"
            ),
            Self::InvalidKey => {
                f.write_str("the speed or thrust asked for is negative or not finite")
            }
            Self::TooFar { at } => write!(
                f,
                "{at} is too far from the identified range: speed, rudder authority or gain would change sign on the way"
            ),
        }
    }
}

impl core::error::Error for ScheduleError {}

/// Models at several speeds or thrusts in increasing order of the key: the linear-parameter-varying
/// model of section II.
///
/// Between two points a22, C0 and the other key are linear in the key; b2 is linear in the square of speed, as the force of a fin, and
/// linear in the key where a speed is missing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedSchedule<T> {
    key: ScheduleKey,
    points: [SchedulePoint<T>; CAPACITY],
    len: usize,
}

/// The two points around a key and how far it lies from the first to the second.
struct Segment<T> {
    lower: SchedulePoint<T>,
    upper: SchedulePoint<T>,
    fraction: T,
    inside: bool,
}

impl<T: Real> Segment<T> {
    fn interpolate(&self, lower: T, upper: T) -> T {
        lower + self.fraction * (upper - lower)
    }

    /// The end on the side of the key.
    fn nearest(&self) -> &SchedulePoint<T> {
        if self.fraction < T::ZERO { &self.lower } else { &self.upper }
    }

    fn interpolate_known(&self, lower: Option<T>, upper: Option<T>) -> Option<T> {
        Some(self.interpolate(lower?, upper?))
    }

    /// The fraction of the way in the square of speed, where both speeds are known and differ.
    fn speed_squared_fraction(&self) -> Option<T> {
        let lower = self.lower.surge_speed_m_s?;
        let upper = self.upper.surge_speed_m_s?;
        let speed = self.interpolate(lower, upper);
        let fraction = (speed * speed - lower * lower) / (upper * upper - lower * lower);
        fraction.is_finite().then_some(fraction)
    }
}

impl<T: Real> SpeedSchedule<T> {
    /// A schedule of at least two points, in any order, with b2 linear in speed squared.
    ///
    /// ```
    /// use seatrial_core::schedule::{ScheduleError, ScheduleKey, SchedulePoint};
    /// use seatrial_core::{SpeedSchedule, YawModel};
    ///
    /// let at = |thrust| SchedulePoint {
    ///     thrust: Some(thrust),
    ///     surge_speed_m_s: None,
    ///     model: YawModel::from_theta([-1.0, 1.0, 0.0]),
    /// };
    /// let schedule = SpeedSchedule::<f64>::new(ScheduleKey::Thrust, &[at(1.0), at(0.6)])?;
    /// // In order of the key, whatever the order they came in.
    /// assert_eq!(schedule.points()[0].thrust, Some(0.6));
    /// let twice = SpeedSchedule::new(ScheduleKey::Thrust, &[at(0.6), at(0.6)]);
    /// assert_eq!(twice, Err(ScheduleError::DuplicateKey { at: 0.6 }));
    /// # Ok::<(), ScheduleError>(())
    /// ```
    pub fn new(key: ScheduleKey, points: &[SchedulePoint<T>]) -> Result<Self, ScheduleError> {
        let mut schedule =
            Self { key, points: [SchedulePoint::default(); CAPACITY], len: points.len() };
        let stored = schedule
            .points
            .get_mut(..points.len())
            .ok_or(ScheduleError::TooManyPoints { found: points.len() })?;
        for (index, (place, point)) in stored.iter_mut().zip(points).enumerate() {
            if !point.is_finite() {
                return Err(ScheduleError::NonFinite { index });
            }
            if point.key(key).is_none_or(|k| k <= T::ZERO) {
                return Err(ScheduleError::MissingKey { index, key });
            }
            *place = *point;
        }
        if points.len() < 2 {
            return Err(ScheduleError::TooFewPoints { found: points.len(), needed: 2 });
        }
        stored.sort_unstable_by(|a, b| {
            a.key(key).partial_cmp(&b.key(key)).unwrap_or(core::cmp::Ordering::Equal)
        });
        for (a, b) in stored.iter().zip(stored.iter().skip(1)) {
            if a.key(key) == b.key(key) {
                let at = a.key(key).unwrap_or_default().to_f64();
                return Err(ScheduleError::DuplicateKey { at });
            }
        }
        Ok(schedule)
    }

    /// What the schedule is looked up by.
    pub fn key(&self) -> ScheduleKey {
        self.key
    }

    /// The points in increasing order of the key.
    pub fn points(&self) -> &[SchedulePoint<T>] {
        self.points.get(..self.len).unwrap_or_default()
    }

    /// The model at a key.
    ///
    /// ```
    /// use seatrial_core::schedule::{Beyond, ScheduleError, ScheduleKey, SchedulePoint};
    /// use seatrial_core::{SpeedSchedule, YawModel};
    ///
    /// let at = |speed_m_s, a22, b2| SchedulePoint {
    ///     thrust: None,
    ///     surge_speed_m_s: Some(speed_m_s),
    ///     model: YawModel::from_theta([a22, b2, 0.0]),
    /// };
    /// let schedule = SpeedSchedule::new(ScheduleKey::Speed, &[at(1.0, -0.5, 0.5), at(2.0, -1.0, 2.0)])?;
    /// // b2 = 0.5 V^2, not the middle of 0.5 and 2.
    /// let found = schedule.lookup(1.5, Beyond::Refuse)?.value().model;
    /// assert_eq!((found.a22_per_s, found.b2_per_s2), (-0.75, 1.125));
    /// let outside = schedule.lookup(3.0, Beyond::Refuse);
    /// assert_eq!(outside, Err(ScheduleError::Outside { at: 3.0, from: 1.0, to: 2.0 }));
    /// # Ok::<(), ScheduleError>(())
    /// ```
    pub fn lookup(
        &self,
        at: T,
        beyond: Beyond,
    ) -> Result<ScheduleValue<SchedulePoint<T>>, ScheduleError> {
        let segment = self.segment(at, beyond)?;
        let (lower, upper) = (segment.lower.model, segment.upper.model);
        let authority_fraction = segment.speed_squared_fraction().unwrap_or(segment.fraction);
        let point = SchedulePoint {
            thrust: segment.interpolate_known(segment.lower.thrust, segment.upper.thrust),
            surge_speed_m_s: segment
                .interpolate_known(segment.lower.surge_speed_m_s, segment.upper.surge_speed_m_s),
            model: YawModel {
                a22_per_s: segment.interpolate(lower.a22_per_s, upper.a22_per_s),
                b2_per_s2: lower.b2_per_s2
                    + authority_fraction * (upper.b2_per_s2 - lower.b2_per_s2),
                c0_rad_per_s2: segment.interpolate(lower.c0_rad_per_s2, upper.c0_rad_per_s2),
            },
        };
        let turned = point.model.b2_per_s2 * segment.nearest().model.b2_per_s2 < T::ZERO;
        let backwards = point.surge_speed_m_s.is_some_and(|speed| speed < T::ZERO);
        if !segment.inside && (turned || backwards) {
            return Err(ScheduleError::TooFar { at: at.to_f64() });
        }
        Ok(ScheduleValue::marked(point, segment.inside))
    }

    fn segment(&self, at: T, beyond: Beyond) -> Result<Segment<T>, ScheduleError> {
        if !at.is_finite() || at < T::ZERO {
            return Err(ScheduleError::InvalidKey);
        }
        let key_of = |point: &SchedulePoint<T>| point.key(self.key).unwrap_or_default();
        let pairs = || self.points().iter().zip(self.points().iter().skip(1));
        let (lower, upper) = pairs()
            .find(|(_, upper)| at <= key_of(upper))
            .or_else(|| pairs().last())
            .ok_or(ScheduleError::TooFewPoints { found: self.len, needed: 2 })?;
        let inside = key_of(lower) <= at && at <= key_of(upper);
        if !inside && beyond == Beyond::Refuse {
            return Err(ScheduleError::Outside {
                at: at.to_f64(),
                from: self.points().first().map_or(0.0, |p| key_of(p).to_f64()),
                to: self.points().last().map_or(0.0, |p| key_of(p).to_f64()),
            });
        }
        Ok(Segment {
            lower: *lower,
            upper: *upper,
            fraction: (at - key_of(lower)) / (key_of(upper) - key_of(lower)),
            inside,
        })
    }
}

#[cfg(test)]
pub(crate) mod tests;
