//! A straight line through values over time, by least squares.

/// ```text
/// slope = sum (t - t_mean)(y - y_mean) / sum (t - t_mean)^2
/// ```
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    count: f64,
    mean_s: f64,
    mean: f64,
    /// Sum of (t - t_mean)^2, s^2.
    squares_s2: f64,
    /// Per second.
    pub slope: f64,
}

impl Line {
    /// `None` where all times are the same.
    pub fn through(times_s: &[f64], values: &[f64]) -> Option<Self> {
        let count = times_s.len() as f64;
        let mean_of = |all: &[f64]| all.iter().sum::<f64>() / count;
        let (mean_s, mean) = (mean_of(times_s), mean_of(values));
        let (mut squares_s2, mut products) = (0.0, 0.0);
        for (time_s, value) in times_s.iter().zip(values) {
            let off_s = time_s - mean_s;
            squares_s2 += off_s * off_s;
            products += off_s * (value - mean);
        }
        (squares_s2 > 0.0).then(|| Self {
            count,
            mean_s,
            mean,
            squares_s2,
            slope: products / squares_s2,
        })
    }

    /// The line at a time, s.
    pub fn at(&self, time_s: f64) -> f64 {
        self.mean + self.slope * (time_s - self.mean_s)
    }

    /// Standard deviation of the slope for values with noise of 1.
    pub fn slope_error(&self) -> f64 {
        self.squares_s2.sqrt().recip()
    }

    /// Standard deviation of the line at a time, s, for values with noise of 1.
    pub fn error_at(&self, time_s: f64) -> f64 {
        (self.count.recip() + (time_s - self.mean_s).powi(2) / self.squares_s2).sqrt()
    }
}
