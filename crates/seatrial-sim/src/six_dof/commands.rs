//! What a driven vehicle of six degrees of freedom is commanded.

/// Commands to fins and propeller.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Commands {
    /// Rudder, rad; positive turns towards increasing heading.
    pub rudder_rad: f64,
    /// Elevator, rad; positive pitches the bow up. Absent: the vehicle holds its depth.
    pub elevator_rad: Option<f64>,
    /// Thrust as a fraction of full, 0 to 1.
    pub thrust: f64,
}
