//! What the rudder of samples is measured in.

/// The unit of [`Sample::rudder_rad`](crate::Sample::rudder_rad).
///
/// A log may hold what a servo was told (a pulse width, a percentage, a fraction) without the angle that it stands for.
/// Then `rudder_rad` is a fraction of full deflection, and b2, K and controller gains are per full rudder.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum RudderUnit {
    /// An angle in rad.
    #[default]
    Rad,
    /// A fraction of full deflection, whose angle is not known.
    FullRudder,
}

impl RudderUnit {
    /// How many of the displayed unit one is, and the name of that unit: degrees, or percent of full.
    ///
    /// ```
    /// use seatrial_core::RudderUnit;
    ///
    /// assert_eq!(RudderUnit::FullRudder.for_people(), (100.0, "% of full"));
    /// let (scale, name) = RudderUnit::Rad.for_people();
    /// assert_eq!(format!("{:.1} {name}", scale * 0.26), "14.9 deg");
    /// ```
    pub fn for_people(self) -> (f64, &'static str) {
        match self {
            Self::Rad => (1_f64.to_degrees(), "deg"),
            Self::FullRudder => (100.0, "% of full"),
        }
    }

    /// What to write behind the unit of a quantity per rudder angle.
    ///
    /// ```
    /// use seatrial_core::RudderUnit;
    ///
    /// assert_eq!(format!("1/s^2{}", RudderUnit::FullRudder.per()), "1/s^2 per full rudder");
    /// assert_eq!(RudderUnit::Rad.per(), "");
    /// ```
    pub fn per(self) -> &'static str {
        match self {
            Self::Rad => "",
            Self::FullRudder => " per full rudder",
        }
    }
}
