//! Units of columns and their conversion to SI.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::words::words;

/// What a unit measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Dimension {
    Time,
    Angle,
    /// An angle, or the command to a servo.
    Steering,
    /// A fraction of full.
    Share,
    AngularRate,
    Speed,
    Length,
}

macro_rules! units {
    ($($unit:ident $symbol:literal $dimension:ident $factor:expr, $spellings:expr;)*) => {
        /// A unit that a column may have.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
        pub enum Unit { $(#[doc = $symbol] #[serde(rename = $symbol)] $unit,)* }

        impl Unit {
            const ALL: &[Self] = &[$(Self::$unit,)*];

            /// As people write it: `deg/s`.
            pub fn symbol(self) -> &'static str {
                match self { $(Self::$unit => $symbol,)* }
            }

            pub(crate) fn dimension(self) -> Dimension {
                match self { $(Self::$unit => Dimension::$dimension,)* }
            }

            /// SI units in one of this unit. Servo units: of full deflection.
            pub(crate) fn factor(self) -> f64 {
                match self { $(Self::$unit => $factor,)* }
            }

            /// Spellings, as lower-case words.
            fn spellings(self) -> &'static [&'static str] {
                match self { $(Self::$unit => $spellings,)* }
            }
        }
    };
}

const DEGREE: f64 = std::f64::consts::PI / 180.0;
/// A whole turn, rad.
const TURN: f64 = std::f64::consts::TAU;

units! {
    Second "s" Time 1.0, &["s", "sec", "secs", "second", "seconds", "sek", "sekunden", "с", "сек", "秒", "초"];
    Millisecond "ms" Time 1e-3, &["ms", "msec", "millis", "milliseconds", "millisekunden", "ミリ秒"];
    Microsecond "us" Time 1e-6, &["us", "µs", "usec", "micros", "microseconds"];
    Tick "100ns" Time 1e-7, &["100ns", "filetime"];
    Centisecond "cs" Time 1e-2, &["cs", "csec", "centisecond", "centiseconds", "hundredths"];
    Nanosecond "ns" Time 1e-9, &["ns", "nsec", "nanos", "nanoseconds"];
    Minute "min" Time 60.0, &["min", "mins", "minute", "minutes", "minuten", "分"];
    Hour "h" Time 3600.0, &["h", "hr", "hrs", "hour", "hours", "stunden", "heures"];
    Day "d" Time 86_400.0, &["d", "day", "days", "tage", "jours", "日"];
    Radian "rad" Angle 1.0, &["rad", "radian", "radians", "radiant", "bogenmaß", "ラジアン"];
    Degree "deg" Angle DEGREE, &["deg", "degree", "degrees", "grad", "grader", "graden", "graus", "gradi", "grados", "derece", "град", "度", "도", "deg t", "deg m", "deg true", "deg mag"];
    Centidegree "cdeg" Angle 0.01 * DEGREE, &["cdeg", "centideg", "centidegree", "centidegrees", "0 01 deg", "deg 100", "deg x100", "x100"];
    Decidegree "ddeg" Angle 0.1 * DEGREE, &["ddeg", "decideg", "decidegree", "decidegrees", "0 deg", "deg 10", "deg x10", "x10"];
    Gradian "gon" Angle TURN / 400.0, &["gon", "gradian", "gradians", "neugrad"];
    Mil "mil" Angle TURN / 6400.0, &["mil", "mils"];
    Milliradian "mrad" Angle 1e-3, &["mrad", "milliradian", "milliradians"];
    TenthMilliradian "1e-4rad" Angle 1e-4, &["1e 4rad", "1e 4 rad", "0 0001 rad"];
    Turn "turn" Angle TURN, &["turn", "turns", "rev", "revolution", "revolutions"];
    Count8 "turn/256" Angle TURN / 256.0, &["turn 256"];
    Count10 "turn/1024" Angle TURN / 1024.0, &["turn 1024"];
    Count12 "turn/4096" Angle TURN / 4096.0, &["turn 4096"];
    Count14 "turn/16384" Angle TURN / 16_384.0, &["turn 16384"];
    Count16 "turn/65536" Angle TURN / 65_536.0, &["turn 65536", "bam", "bams"];
    PulseWidth "pwm" Steering 1.0 / 400.0, &["pwm", "us", "µs"];
    Percent "percent" Steering 0.01, &["percent", "pct", "prozent", "パーセント"];
    Fraction "fraction" Steering 1.0, &["fraction", "norm", "normalised", "normalized"];
    RadianPerSecond "rad/s" AngularRate 1.0, &["rad s", "rads", "radian second", "ラジアン 秒"];
    DegreePerSecond "deg/s" AngularRate DEGREE, &["deg s", "dps", "degs", "deg sec", "degree second", "degrees second", "grad s", "grad sekunde", "度 秒"];
    DegreePerMinute "deg/min" AngularRate DEGREE / 60.0, &["deg min", "dpm", "degree minute", "degrees minute", "grad min", "grad minute", "度 分"];
    MetrePerSecond "m/s" Speed 1.0, &["m s", "mps", "ms"];
    Knot "kn" Speed 1852.0 / 3600.0, &["kn", "kt", "kts", "knot", "knots", "knoten", "noeud", "noeuds", "nœuds", "nudos", "ノット"];
    KilometrePerHour "km/h" Speed 1.0 / 3.6, &["km h", "kmh", "kph"];
    Metre "m" Length 1.0, &["m", "metre", "metres", "meter", "meters", "メートル"];
    Foot "ft" Length 0.3048, &["ft", "foot", "feet"];
}

/// Pulse width of a servo in the middle, us.
pub(crate) const NEUTRAL_PULSE_US: f64 = 1500.0;

impl Unit {
    /// The unit of a quantity with these dimensions, spelt as these words; `per` and the exponent of
    /// `s-1` do not matter.
    pub(crate) fn of_words(words: &[&str], dimension: Dimension) -> Option<Self> {
        let spelt = words
            .iter()
            .filter(|word| !matches!(**word, "per" | "1"))
            .copied()
            .collect::<Vec<_>>()
            .join(" ");
        Self::ALL
            .iter()
            .copied()
            .find(|unit| unit.fits(dimension) && unit.spellings().contains(&spelt.as_str()))
    }

    pub(crate) fn fits(self, dimension: Dimension) -> bool {
        self.dimension() == dimension
            || (dimension == Dimension::Steering && self.dimension() == Dimension::Angle)
            || (dimension == Dimension::Share && matches!(self, Self::Percent | Self::Fraction))
    }

    /// The units that fit.
    pub(crate) fn that_measure(dimension: Dimension) -> Vec<Self> {
        let all = Self::ALL.iter().copied();
        all.filter(|unit| unit.fits(dimension)).collect()
    }

    /// Symbols of the units that fit, for messages.
    pub(crate) fn that_fit(dimension: Dimension) -> String {
        symbols(|unit| unit.fits(dimension))
    }
}

/// Symbols of some units, for messages.
fn symbols(is_shown: impl Fn(Unit) -> bool) -> String {
    let shown = Unit::ALL.iter().filter(|unit| is_shown(**unit));
    shown.map(|unit| unit.symbol()).collect::<Vec<_>>().join(", ")
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.symbol())
    }
}

/// A text that is no unit.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is no unit; expected one of {expected}", expected = symbols(|_| true))]
pub struct UnknownUnit(pub String);

impl FromStr for Unit {
    type Err = UnknownUnit;

    fn from_str(text: &str) -> Result<Self, UnknownUnit> {
        let lower = text.to_lowercase();
        let words = words(&lower);
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        Self::ALL
            .iter()
            .copied()
            .find(|unit| unit.symbol() == lower)
            .or_else(|| {
                Self::ALL
                    .iter()
                    .copied()
                    .find(|unit| Self::of_words(&words, unit.dimension()) == Some(*unit))
            })
            .ok_or_else(|| UnknownUnit(text.into()))
    }
}

/// value_si = (value - offset) factor
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Conversion {
    pub offset: f64,
    pub factor: f64,
}
