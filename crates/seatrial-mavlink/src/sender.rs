//! Who sends frames.

/// The sender of a frame: system and component.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Sender {
    /// System id, of a vehicle or a ground station.
    pub system: u8,
    /// Component id.
    pub component: u8,
}
