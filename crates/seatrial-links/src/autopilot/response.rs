//! How long commands take.

/// Width of a bin, s.
const BIN_S: f64 = 10e-6;
/// Bins; what takes longer is counted in the last.
const BINS: usize = 1000;

/// The time from the bytes that complete a sample to the command that answers it, counted in bins of 10 us.
#[derive(Clone, Debug)]
pub struct Response {
    bins: Box<[u64; BINS]>,
    count: u64,
    longest_s: f64,
}

impl Default for Response {
    fn default() -> Self {
        Self { bins: Box::new([0; BINS]), count: 0, longest_s: 0.0 }
    }
}

impl Response {
    pub(super) fn took(&mut self, duration_s: f64) {
        let bin = (duration_s / BIN_S) as usize;
        self.bins[bin.min(BINS - 1)] += 1;
        self.count += 1;
        self.longest_s = self.longest_s.max(duration_s);
    }

    /// Commands.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The longest, s.
    pub fn longest_s(&self) -> f64 {
        self.longest_s
    }

    /// This share of them took no longer, s, to the next 10 us; `None`: there were none.
    pub fn quantile_s(&self, share: f64) -> Option<f64> {
        let wanted = share * self.count as f64;
        let mut sum = 0;
        let bin = self.bins.iter().position(|count| {
            sum += count;
            sum > 0 && sum as f64 >= wanted
        })?;
        let is_last = bin == BINS - 1;
        Some(if is_last { self.longest_s } else { (bin + 1) as f64 * BIN_S })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_a_share_took_no_longer() {
        let mut response = Response::default();
        assert_eq!(response.quantile_s(0.5), None);
        // 999 of 15 us, one of 0.1 s.
        (0..999).for_each(|_| response.took(15e-6));
        response.took(0.1);
        // The end of the bin from 10 to 20 us.
        assert_eq!(response.quantile_s(0.999), Some(2.0 * BIN_S));
        assert_eq!(response.quantile_s(1.0), Some(0.1));
        assert_eq!((response.count(), response.longest_s()), (1000, 0.1));
    }
}
