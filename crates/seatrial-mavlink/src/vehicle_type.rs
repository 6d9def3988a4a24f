//! What a `MAV_TYPE` is.

/// The aircraft of a `MAV_TYPE`, with its article; `None` of what drives, floats or dives, or says nothing.
///
/// ```
/// assert_eq!(seatrial_mavlink::aircraft(2), Some("a copter"));
/// assert_eq!(seatrial_mavlink::aircraft(11), None);
/// ```
pub fn aircraft(mav_type: u8) -> Option<&'static str> {
    match mav_type {
        1 => Some("a plane"),
        2..=4 | 13..=15 | 29 | 35 => Some("a copter"),
        7 => Some("an airship"),
        8 => Some("a balloon"),
        9 => Some("a rocket"),
        16 => Some("a flapping wing"),
        17 => Some("a kite"),
        19..=25 => Some("a plane that takes off upright"),
        28 => Some("a parafoil"),
        _ => None,
    }
}
