//! The parts of a trial's record that are fitted.

/// An instant of a part of the record.
#[derive(Clone, Copy, Debug)]
pub(super) struct Instant {
    pub time_s: f64,
    pub surge_speed_m_s: f64,
    pub yaw_rate_rad_s: f64,
}

/// A part of the record at one thrust, from the change to it on.
#[derive(Clone, Debug)]
pub(super) struct Part {
    /// Its thrust and the one before, as places in the list of thrusts.
    pub thrust: usize,
    pub before: usize,
    /// Instants before the first doublet.
    pub settling: usize,
    /// Variance of the noise of the yaw rate, (rad/s)^2: what it adds to the mean square.
    pub yaw_rate_variance: f64,
    pub instants: Vec<Instant>,
}

/// First row and number of rows of each part.
pub(super) fn spans(parts: &[Part]) -> Vec<(usize, usize)> {
    let mut from = 0;
    let span = |part: &Part| {
        let rows = part.instants.len();
        from += rows;
        (from - rows, rows)
    };
    parts.iter().map(span).collect()
}
