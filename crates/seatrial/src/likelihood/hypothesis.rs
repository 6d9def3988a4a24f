//! The table of hypotheses: what a vehicle may be, what may disturb it, and what is believed before a record is seen.

use std::collections::BTreeMap;
use std::fmt;

use serde::{Deserialize, Serialize, Serializer};

use super::leg::{Leg, PARTS, deviation};

/// What acts on yaw beside linear damping and a rudder that is where its record says: a set of parameters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(from = "BTreeMap<String, bool>")]
pub struct Structure {
    further: u32,
}

impl Structure {
    /// Linear damping and a rudder as recorded.
    pub const FIRST_ORDER: Self = Self { further: 0 };
    /// First order whose record of the rudder is early or late.
    pub const SHIFT: Self = Self::FIRST_ORDER.with(Parameter::Shift);
    /// First order behind a gear that lags.
    pub const LAG: Self = Self::SHIFT.with(Parameter::Lag);
    /// First order behind a gear that has a largest rate.
    pub const RATE_LIMIT: Self = Self::SHIFT.with(Parameter::RateLimit);
    /// First order behind a gear that has play.
    pub const PLAY: Self = Self::SHIFT.with(Parameter::Play);
    /// Damping that grows with the yaw rate.
    pub const QUADRATIC: Self = Self::SHIFT.with(Parameter::Quadratic);
    /// Sway acts on yaw.
    pub const SWAY: Self = Self::SHIFT.with(Parameter::Coupling).with(Parameter::SwayTime);
    /// Sway and damping that grows with the yaw rate: the most general hull of the table.
    pub const SWAY_QUADRATIC: Self = Self::SWAY.with(Parameter::Quadratic);

    /// Every structure of the table with its flag in documents, where those of others do not say it, and its words: each after the one that it
    /// starts from. Of those that a structure contains the last names it.
    pub const TABLE: [(Self, &str, &str); 9] = [
        (Self::FIRST_ORDER, "", "first order"),
        (Self::SHIFT, "shift", "first order"),
        (Self::LAG, "lag", "first order with a lagging rudder"),
        (Self::RATE_LIMIT, "rate_limit", "first order behind a rate-limited steering gear"),
        (Self::PLAY, "play", "first order behind a steering gear with play"),
        (Self::QUADRATIC, "quadratic", "damping that grows with the yaw rate"),
        (
            Self::QUADRATIC.with(Parameter::Lag),
            "",
            "damping that grows with the yaw rate behind a lagging rudder",
        ),
        (Self::SWAY, "sway", "second order (sway and yaw)"),
        (Self::SWAY_QUADRATIC, "", "sway and yaw with damping that grows with the yaw rate"),
    ];

    /// The most general hull after those that it starts from.
    pub const HULLS: [Self; 4] = [Self::FIRST_ORDER, Self::SHIFT, Self::SWAY, Self::SWAY_QUADRATIC];

    /// With a parameter more.
    #[must_use]
    pub const fn with(self, parameter: Parameter) -> Self {
        Self { further: self.further | 1 << parameter as u32 }
    }

    /// With the parameters of another, too.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self { further: self.further | other.further }
    }

    /// Does it have this parameter beyond damping and authority?
    pub fn has(self, parameter: Parameter) -> bool {
        self.contains(Self::FIRST_ORDER.with(parameter))
    }

    fn contains(self, other: Self) -> bool {
        self.union(other) == self
    }

    /// The structure of the table whose solution this one starts from: the last before it that it contains.
    ///
    /// ```
    /// use seatrial::likelihood::Structure;
    ///
    /// assert_eq!(Structure::FIRST_ORDER.parent(), None);
    /// // First order with a shifted record, then first order.
    /// let steps = std::iter::successors(Some(Structure::LAG), Structure::parent).count();
    /// assert_eq!(steps, 3);
    /// ```
    pub fn parent(&self) -> Option<Self> {
        let before = Self::TABLE.map(|(other, ..)| other).into_iter().take_while(|s| s != self);
        before.filter(|other| self.contains(*other)).last()
    }

    /// Does the gear lag, have a largest rate or play?
    pub fn has_own_gear(self) -> bool {
        [Parameter::Lag, Parameter::RateLimit, Parameter::Play].into_iter().any(|p| self.has(p))
    }

    /// Does the hull differ from first order?
    pub fn has_own_hull(self) -> bool {
        PARAMETERS.iter().any(|row| row.is_of_hull && self.has(row.parameter))
    }

    /// Does more than linear damping and a shift of the record explain the heading?
    ///
    /// ```
    /// use seatrial::likelihood::Structure;
    ///
    /// assert!(Structure::LAG.exceeds_first_order() && !Structure::LAG.has_own_hull());
    /// assert!(Structure::SWAY_QUADRATIC.has_own_hull());
    /// ```
    pub fn exceeds_first_order(self) -> bool {
        !Self::SHIFT.contains(self)
    }

    /// Does more than first order behind a gear that lags explain the heading?
    pub(super) fn exceeds_a_lag(self) -> bool {
        !Self::LAG.contains(self)
    }

    /// Its parameters.
    ///
    /// ```
    /// use seatrial::likelihood::Structure;
    ///
    /// // Damping and authority; sway adds its coupling and its time, and both shift the record.
    /// assert_eq!(Structure::FIRST_ORDER.parameters().len(), 2);
    /// assert_eq!(Structure::SWAY_QUADRATIC.parameters().len(), 6);
    /// ```
    pub fn parameters(self) -> Vec<Parameter> {
        let further = PARAMETERS.iter().map(|row| row.parameter).filter(|p| self.has(*p));
        [Parameter::Damping, Parameter::Authority].into_iter().chain(further).collect()
    }

    /// In words.
    ///
    /// ```
    /// use seatrial::likelihood::Structure;
    ///
    /// assert_eq!(Structure::LAG.in_words(), "first order with a lagging rudder");
    /// ```
    pub fn in_words(self) -> &'static str {
        let named = Self::TABLE.into_iter().rfind(|(other, ..)| self.contains(*other));
        named.map_or("first order", |(.., words)| words)
    }

    fn flags() -> impl Iterator<Item = (&'static str, Self)> {
        let flags = Self::TABLE.into_iter().filter(|(_, flag, _)| !flag.is_empty());
        flags.map(|(structure, flag, _)| (flag, structure))
    }
}

impl Serialize for Structure {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(Self::flags().map(|(flag, other)| (flag, self.contains(other))))
    }
}

impl From<BTreeMap<String, bool>> for Structure {
    fn from(flags: BTreeMap<String, bool>) -> Self {
        let named = Self::flags().filter(|(flag, _)| flags.get(*flag) == Some(&true));
        named.map(|(_, structure)| structure).fold(Self::FIRST_ORDER, Self::union)
    }
}

/// What besides the rudder turns the vehicle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Disturbance {
    /// Nothing: output error.
    None,
    /// A random walk of the heading: output error in the yaw rate, which no disturbance can feign a hull with.
    Drift,
    /// A Gauss-Markov yaw acceleration.
    Sea,
}

impl Disturbance {
    /// Every disturbance of the table.
    pub const ALL: [Self; 3] = [Self::None, Self::Drift, Self::Sea];
}

impl fmt::Display for Disturbance {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::None => "no disturbance",
            Self::Drift => "drifting heading",
            Self::Sea => "sea",
        })
    }
}

/// How strong a disturbance is, relative to the heading noise of one comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Deviation of a random walk of the heading after a second, 1/sqrt(s).
    pub drift: f64,
    /// Deviation of a Gauss-Markov yaw acceleration, 1/s^2, and its time constant, s.
    pub sea: [f64; 2],
    /// Deviation of a narrow-band yaw acceleration, 1/s^2, its frequency, rad/s, and its damping ratio.
    pub wave: [f64; 3],
}

impl Noise {
    /// No disturbance.
    pub const NONE: Self = Self { drift: 0.0, sea: [0.0, f64::INFINITY], wave: [0.0, 1.0, 0.5] };
}

/// A parameter that all legs share: first those of a vehicle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parameter {
    /// d0.
    Damping,
    /// b.
    Authority,
    /// tau.
    Shift,
    /// T_l.
    Lag,
    /// rho.
    RateLimit,
    /// Play of the gear.
    Play,
    /// d2.
    Quadratic,
    /// k.
    Coupling,
    /// T_v.
    SwayTime,
    /// Noise of the gyro over that of the heading.
    GyroNoise,
    /// Strength of a sea.
    Sea,
    /// Its time constant.
    SeaTime,
    /// Time by which the speed is logged late.
    SpeedLate,
    /// Strength of narrow-band waves.
    Wave,
    /// Their frequency.
    WaveFrequency,
    /// Their damping ratio.
    WaveRatio,
}

impl Parameter {
    /// How many there are.
    pub(crate) const COUNT: usize = Self::WaveRatio as usize + 1;

    /// What is believed of it, and what it does.
    pub(crate) fn row(self) -> &'static Row {
        &PARAMETERS[self as usize]
    }
}

/// A row of the table of parameters.
pub(crate) struct Row {
    parameter: Parameter,
    /// Standard deviation of what is believed of the scaled value, whose mean is 0 for those of a vehicle; `None` where nothing is.
    pub prior_deviation: Option<f64>,
    /// Scaled values that a search starts from.
    pub starts: &'static [f64],
    /// Does it change how a disturbance moves the heading?
    pub is_of_hull: bool,
    /// Gives a vehicle the parameter by its scaled value.
    set: fn(&mut Vehicle, f64, &Scale),
}

/// Of what is neither believed nor of the hull.
const ROW: Row = Row {
    parameter: Parameter::Authority,
    prior_deviation: None,
    starts: &[],
    is_of_hull: false,
    set: |_, _, _| (),
};

/// The rows of all parameters, in the order of these.
#[rustfmt::skip]
static PARAMETERS: [Row; Parameter::COUNT] = [
    Row { parameter: Parameter::Damping, is_of_hull: true, set: |v, x, of| v.damping_per_s = x * of.rate_per_s, ..ROW },
    Row { parameter: Parameter::Authority, set: |v, x, of| v.authority_per_s2 = x * of.authority_per_s2, ..ROW },
    Row { parameter: Parameter::Shift, prior_deviation: Some(0.6), set: |v, x, of| v.shift_s = x * of.interval_s, ..ROW },
    Row { parameter: Parameter::Lag, prior_deviation: Some(1.2), starts: &[-0.5, 0.8], set: |v, x, of| v.lag_s = positive(x) * 0.15 / of.rate_per_s, ..ROW },
    Row { parameter: Parameter::RateLimit, prior_deviation: Some(1.5), starts: &[-1.0, 0.7], set: |v, x, of| v.rate_limit_rad_s = positive(x) * of.slew_rad_s, ..ROW },
    Row { parameter: Parameter::Play, prior_deviation: Some(1.0), starts: &[-0.7, 0.3], set: |v, x, of| v.play_rad = (positive(x) * 0.3).min(MOST_PLAY) * of.rudder_rad, ..ROW },
    Row { parameter: Parameter::Quadratic, prior_deviation: Some(1.5), starts: &[-1.0], is_of_hull: true, set: |v, x, of| v.quadratic_per_rad = positive(x) * 0.3 * of.rate_per_s / of.yaw_rate_rad_s },
    Row { parameter: Parameter::Coupling, prior_deviation: Some(0.7), starts: &[-0.35, 0.35], is_of_hull: true, set: |v, x, of| v.coupling_per_s2 = x * of.rate_per_s * of.rate_per_s },
    Row { parameter: Parameter::SwayTime, prior_deviation: Some(1.0), starts: &[0.0], is_of_hull: true, set: |v, x, of| v.sway_s = positive(x) / of.rate_per_s },
    Row { parameter: Parameter::GyroNoise, prior_deviation: Some(4.0), ..ROW },
    Row { parameter: Parameter::Sea, prior_deviation: Some(4.0), ..ROW },
    Row { parameter: Parameter::SeaTime, prior_deviation: Some(1.0), ..ROW },
    Row { parameter: Parameter::SpeedLate, prior_deviation: Some(0.3), ..ROW },
    Row { parameter: Parameter::Wave, prior_deviation: Some(4.0), ..ROW },
    Row { parameter: Parameter::WaveFrequency, prior_deviation: Some(1.0), ..ROW },
    Row { parameter: Parameter::WaveRatio, prior_deviation: Some(0.7), ..ROW },
];

fn positive(x: f64) -> f64 {
    libm::exp(x.clamp(-12.0, 12.0))
}

/// A vehicle and its gear in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vehicle {
    /// d0, 1/s.
    pub damping_per_s: f64,
    /// b, 1/s^2.
    pub authority_per_s2: f64,
    /// tau, s.
    pub shift_s: f64,
    /// T_l, s; 0 where the gear does not lag.
    pub lag_s: f64,
    /// rho, rad/s; infinite where the gear has no largest rate.
    pub rate_limit_rad_s: f64,
    /// Play of the gear from stop to stop, rad.
    pub play_rad: f64,
    /// d2, 1/rad.
    pub quadratic_per_rad: f64,
    /// k, 1/s^2.
    pub coupling_per_s2: f64,
    /// T_v, s.
    pub sway_s: f64,
}

impl Vehicle {
    const NONE: Self = Self {
        damping_per_s: 0.0,
        authority_per_s2: 0.0,
        shift_s: 0.0,
        lag_s: 0.0,
        rate_limit_rad_s: f64::INFINITY,
        play_rad: 0.0,
        quadratic_per_rad: 0.0,
        coupling_per_s2: 0.0,
        sway_s: 1.0,
    };
}

/// Most play from stop to stop in deviations of the rudder: a gear that hardly moves has none. A tanker's zig-zag was once best explained by play
/// of 1.5 times its rudder, which predicts another zig-zag with R^2 -0.6, and another hypothesis with 0.96.
const MOST_PLAY: f64 = 1.0;

/// Sizes of a record by which parameters are scaled, so that priors hold for a torpedo and a tanker alike.
#[derive(Clone, Copy, Debug)]
pub struct Scale {
    /// Rate of the vehicle, 1/s.
    pub rate_per_s: f64,
    /// Rudder authority, 1/s^2, with its sign.
    pub authority_per_s2: f64,
    /// Yaw rate, rad/s.
    pub yaw_rate_rad_s: f64,
    /// Standard deviation of the rudder, rad.
    pub rudder_rad: f64,
    /// Rate of a gear that needs half the time between strokes from side to side, rad/s.
    pub slew_rad_s: f64,
    /// Time by which a record of the rudder may be early or late, s: its largest usual interval between samples.
    pub interval_s: f64,
    /// Standard deviation of the heading, rad, mean over the legs.
    pub heading_rad: f64,
}

impl Scale {
    /// Of these legs, around a vehicle of this rate and authority.
    pub fn of(legs: &[Leg], interval_s: f64, rate_per_s: f64, authority_per_s2: f64) -> Self {
        let rates = legs.iter().map(|leg| deviation(&leg.slopes_rad_s()));
        let duration_s: f64 = legs.iter().map(Leg::duration_s).sum();
        let mut rudder_rad: f64 = 0.0;
        let mut strokes = 0;
        for leg in legs {
            let command = leg.commands(0.0, PARTS);
            let mean = command.iter().sum::<f64>() / command.len().max(1) as f64;
            rudder_rad = rudder_rad.max(deviation(&command));
            strokes += command.windows(2).filter(|c| (c[0] > mean) != (c[1] > mean)).count();
        }
        let headings = legs.iter().map(Leg::heading_deviation_rad);
        Self {
            rate_per_s,
            authority_per_s2,
            yaw_rate_rad_s: rates.fold(f64::MIN_POSITIVE, f64::max),
            rudder_rad,
            slew_rad_s: 4.0 * rudder_rad * (strokes + 1) as f64 / duration_s,
            interval_s,
            heading_rad: headings.sum::<f64>() / legs.len().max(1) as f64,
        }
    }

    /// The vehicle of scaled parameters.
    pub fn vehicle(&self, parameters: &[Parameter], scaled: &[f64]) -> Vehicle {
        let mut vehicle = Vehicle::NONE;
        for (parameter, x) in parameters.iter().zip(scaled) {
            (parameter.row().set)(&mut vehicle, *x, self);
        }
        vehicle
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_rows_are_in_the_order_of_the_parameters() {
        assert!(PARAMETERS.iter().enumerate().all(|(at, row)| row.parameter as usize == at));
    }

    /// Documents keep their flags and the order of these; play came later than the others.
    #[test]
    fn io_a_structure_is_written_as_before() {
        let of = |sway| {
            format!(
                r#"{{"shift":true,"lag":false,"rate_limit":false,"play":false,"quadratic":true,"sway":{sway}}}"#
            )
        };
        for (structure, text) in
            [(Structure::QUADRATIC, of(false)), (Structure::SWAY_QUADRATIC, of(true))]
        {
            assert_eq!(serde_json::to_string(&structure).unwrap(), text);
            let earlier = text.replace("\"play\":false,", "");
            assert_eq!(serde_json::from_str::<Structure>(&earlier).unwrap(), structure);
        }
    }
}
