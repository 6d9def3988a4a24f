//! Tracks seen from above, both axes to one scale.

use super::axis::extent;
use super::chart::PLOT_WIDTH;

/// How much room a picture of tracks takes beside them.
pub(super) struct Room {
    /// Height of the picture over that of the tracks.
    pub over_tracks: f64,
    /// The tracks are at most this high, user units.
    pub highest: f64,
    /// The picture is at least this high, user units.
    pub least_height: f64,
}

/// The axes of a picture of tracks.
pub(super) struct PlanView {
    /// Length of the tracks to the right, m.
    pub length_m: f64,
    /// Their width, m.
    pub width_m: f64,
    /// Ends of the horizontal axis, m.
    pub along_m: [f64; 2],
    /// Ends of the vertical axis, m.
    pub across_m: [f64; 2],
    /// Height of the panel, user units.
    pub height: f64,
}

impl PlanView {
    /// The axes for points to the right and up. `None` where there are none.
    pub fn new<'a>(
        points: impl Iterator<Item = &'a [f64; 2]> + Clone,
        room: &Room,
    ) -> Option<Self> {
        let [rear, front] = extent(points.clone().map(|point| point[0]));
        let [right, left] = extent(points.map(|point| point[1]));
        if !((front - rear).is_finite() && (left - right).is_finite()) {
            return None;
        }
        let m_per_unit = (1.1 * (front - rear) / PLOT_WIDTH).max((left - right) / room.highest);
        let height = (room.over_tracks * (left - right) / m_per_unit).max(room.least_height);
        let half_width = 0.5 * PLOT_WIDTH * m_per_unit;
        // The panel widens its range by 6 % on either side.
        let half_height = 0.5 * height * m_per_unit / 1.12;
        let (middle, across) = (0.5 * (rear + front), 0.5 * (right + left));
        Some(Self {
            length_m: front - rear,
            width_m: left - right,
            along_m: [middle - half_width, middle + half_width],
            across_m: [across - half_height, across + half_height],
            height,
        })
    }
}
