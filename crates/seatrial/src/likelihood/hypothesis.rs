//! The table of hypotheses: what a vehicle may be, what may disturb it, and what is believed before a record is seen.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::leg::{Leg, PARTS, deviation};

/// What acts on yaw beside linear damping and a rudder that is where its record says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Structure {
    /// The record of the rudder is early or late: tau.
    pub shift: bool,
    /// The gear lags: T_l.
    pub lag: bool,
    /// The gear has a largest rate: rho.
    pub rate_limit: bool,
    /// The gear has play.
    #[serde(default)]
    pub play: bool,
    /// Damping grows with the yaw rate: d2.
    pub quadratic: bool,
    /// Sway acts on yaw: k and T_v.
    pub sway: bool,
}

impl Structure {
    /// Linear damping and a rudder as recorded.
    pub const FIRST_ORDER: Self = Self {
        shift: false,
        lag: false,
        rate_limit: false,
        play: false,
        quadratic: false,
        sway: false,
    };
    /// First order whose record of the rudder is early or late.
    pub const SHIFT: Self = Self { shift: true, ..Self::FIRST_ORDER };
    /// First order behind a gear that lags.
    pub const LAG: Self = Self { lag: true, ..Self::SHIFT };
    const RATE_LIMIT: Self = Self { rate_limit: true, ..Self::SHIFT };
    const PLAY: Self = Self { play: true, ..Self::SHIFT };
    const QUADRATIC: Self = Self { quadratic: true, ..Self::SHIFT };
    const SWAY: Self = Self { sway: true, ..Self::SHIFT };
    /// Sway and damping that grows with the yaw rate: the most general hull of the table.
    pub const SWAY_QUADRATIC: Self = Self { quadratic: true, ..Self::SWAY };

    /// Every structure of the table, each after the one that it starts from.
    pub const TABLE: [Self; 8] = [
        Self::FIRST_ORDER,
        Self::SHIFT,
        Self::LAG,
        Self::RATE_LIMIT,
        Self::PLAY,
        Self::QUADRATIC,
        Self::SWAY,
        Self::SWAY_QUADRATIC,
    ];

    /// The most general hull after those that it starts from.
    pub const HULLS: [Self; 4] = [Self::FIRST_ORDER, Self::SHIFT, Self::SWAY, Self::SWAY_QUADRATIC];

    /// The structure of the table whose solution this one starts from.
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
        match *self {
            Self::FIRST_ORDER => None,
            Self::SHIFT => Some(Self::FIRST_ORDER),
            Self::SWAY_QUADRATIC => Some(Self::SWAY),
            _ => Some(Self::SHIFT),
        }
    }

    /// Does the hull differ from first order?
    pub fn has_own_hull(&self) -> bool {
        self.quadratic || self.sway
    }

    /// Does more than linear damping and a shift of the record explain the heading?
    ///
    /// ```
    /// use seatrial::likelihood::Structure;
    ///
    /// assert!(Structure::LAG.exceeds_first_order() && !Structure::LAG.has_own_hull());
    /// assert!(Structure::SWAY_QUADRATIC.has_own_hull());
    /// ```
    pub fn exceeds_first_order(&self) -> bool {
        self.exceeds_a_lag() || self.lag
    }

    /// Does more than first order behind a gear that lags explain the heading?
    pub(super) fn exceeds_a_lag(&self) -> bool {
        self.has_own_hull() || self.rate_limit || self.play
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
    pub fn parameters(&self) -> Vec<Parameter> {
        let has = |parameter: &Parameter| match parameter {
            Parameter::Damping | Parameter::Authority => true,
            Parameter::Shift => self.shift,
            Parameter::Lag => self.lag,
            Parameter::RateLimit => self.rate_limit,
            Parameter::Play => self.play,
            Parameter::Quadratic => self.quadratic,
            Parameter::Coupling | Parameter::SwayTime => self.sway,
            _ => false,
        };
        Parameter::ALL.into_iter().filter(has).collect()
    }

    /// In words.
    ///
    /// ```
    /// use seatrial::likelihood::Structure;
    ///
    /// assert_eq!(Structure::LAG.in_words(), "first order with a lagging rudder");
    /// ```
    pub fn in_words(&self) -> &'static str {
        if self.play {
            return "first order behind a steering gear with play";
        }
        match (self.sway, self.quadratic, self.rate_limit, self.lag) {
            (false, false, false, false) => "first order",
            (false, false, false, true) => "first order with a lagging rudder",
            (false, false, true, _) => "first order behind a rate-limited steering gear",
            (false, true, ..) => "damping that grows with the yaw rate",
            (true, false, ..) => "second order (sway and yaw)",
            (true, true, ..) => "sway and yaw with damping that grows with the yaw rate",
        }
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
    const ALL: [Self; 9] = [
        Self::Damping,
        Self::Authority,
        Self::Shift,
        Self::Lag,
        Self::RateLimit,
        Self::Play,
        Self::Quadratic,
        Self::Coupling,
        Self::SwayTime,
    ];

    /// How many there are.
    pub(crate) const COUNT: usize = Self::WaveRatio as usize + 1;

    /// Standard deviation of what is believed of the scaled parameter, whose mean is 0 for those of a vehicle; `None` where nothing is.
    ///
    /// ```
    /// use seatrial::likelihood::hypothesis::Parameter;
    ///
    /// assert_eq!(Parameter::Damping.prior_deviation(), None);
    /// assert_eq!(Parameter::Shift.prior_deviation(), Some(0.6));
    /// ```
    pub fn prior_deviation(self) -> Option<f64> {
        match self {
            Self::Damping | Self::Authority => None,
            Self::Shift => Some(0.6),
            Self::Lag => Some(1.2),
            Self::RateLimit | Self::Quadratic => Some(1.5),
            Self::Coupling => Some(0.7),
            Self::SwayTime | Self::Play | Self::SeaTime | Self::WaveFrequency => Some(1.0),
            Self::GyroNoise | Self::Sea | Self::Wave => Some(4.0),
            Self::SpeedLate => Some(0.3),
            Self::WaveRatio => Some(0.7),
        }
    }

    /// Scaled values that a search starts from.
    pub fn starts(self) -> &'static [f64] {
        match self {
            Self::Lag => &[-0.5, 0.8],
            Self::RateLimit => &[-1.0, 0.7],
            Self::Play => &[-0.7, 0.3],
            Self::Quadratic => &[-1.0],
            Self::Coupling => &[-0.35, 0.35],
            Self::SwayTime => &[0.0],
            _ => &[],
        }
    }

    /// Does it change how a disturbance moves the heading?
    pub fn is_dynamic(self) -> bool {
        matches!(self, Self::Damping | Self::Quadratic | Self::Coupling | Self::SwayTime)
    }
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
    /// Mean commands of a leg over parts of each interval between comparisons, rad: finer where the gear has a largest rate or play.
    pub fn commands(&self, leg: &Leg) -> Vec<f64> {
        let is_linear = self.rate_limit_rad_s.is_infinite() && self.play_rad == 0.0;
        let parts = if is_linear { PARTS } else { leg.fine_parts() };
        leg.commands(self.shift_s, parts)
    }
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
        let rate = self.rate_per_s;
        let mut vehicle = Vehicle {
            damping_per_s: rate,
            authority_per_s2: self.authority_per_s2,
            shift_s: 0.0,
            lag_s: 0.0,
            rate_limit_rad_s: f64::INFINITY,
            play_rad: 0.0,
            quadratic_per_rad: 0.0,
            coupling_per_s2: 0.0,
            sway_s: 1.0 / rate,
        };
        for (parameter, x) in parameters.iter().zip(scaled) {
            let positive = libm::exp(x.clamp(-12.0, 12.0));
            match parameter {
                Parameter::Damping => vehicle.damping_per_s = x * rate,
                Parameter::Authority => vehicle.authority_per_s2 = x * self.authority_per_s2,
                Parameter::Shift => vehicle.shift_s = x * self.interval_s,
                Parameter::Lag => vehicle.lag_s = positive * 0.15 / rate,
                Parameter::RateLimit => vehicle.rate_limit_rad_s = positive * self.slew_rad_s,
                Parameter::Play => {
                    vehicle.play_rad = (positive * 0.3).min(MOST_PLAY) * self.rudder_rad;
                }
                Parameter::Quadratic => {
                    vehicle.quadratic_per_rad = positive * 0.3 * rate / self.yaw_rate_rad_s;
                }
                Parameter::Coupling => vehicle.coupling_per_s2 = x * rate * rate,
                Parameter::SwayTime => vehicle.sway_s = positive / rate,
                _ => {}
            }
        }
        vehicle
    }
}
