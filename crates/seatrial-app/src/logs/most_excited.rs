//! What is kept of a log that is too long to keep whole.

use std::collections::VecDeque;
use std::rc::Rc;

use seatrial::Record;
use seatrial_core::Sample;

/// The most samples that are kept of a log: 84 MB.
const MOST_SAMPLES: usize = 500_000;
/// Samples that are kept or left out together.
const CHUNK_SAMPLES: usize = 50_000;

/// The segment of at most 500,000 successive samples whose rudder varies most.
#[derive(Default)]
pub(super) struct MostExcited {
    recent: VecDeque<Rc<Chunk>>,
    best: Vec<Rc<Chunk>>,
    best_variance: f64,
    growing: Chunk,
}

#[derive(Default)]
struct Chunk {
    samples: Vec<Sample<f64>>,
    rudder_sum: f64,
    rudder_square_sum: f64,
}

impl MostExcited {
    pub(super) fn push(&mut self, sample: Sample<f64>) {
        self.growing.rudder_sum += sample.rudder_rad;
        self.growing.rudder_square_sum += sample.rudder_rad * sample.rudder_rad;
        self.growing.samples.push(sample);
        if self.growing.samples.len() == CHUNK_SAMPLES {
            self.close_chunk();
        }
    }

    fn close_chunk(&mut self) {
        if self.recent.len() == MOST_SAMPLES / CHUNK_SAMPLES {
            self.recent.pop_front();
        }
        self.recent.push_back(Rc::new(std::mem::take(&mut self.growing)));
        let total = |of: fn(&Chunk) -> f64| self.recent.iter().map(|chunk| of(chunk)).sum::<f64>();
        let count = total(|chunk| chunk.samples.len() as f64);
        let mean = total(|chunk| chunk.rudder_sum) / count;
        let variance = total(|chunk| chunk.rudder_square_sum) / count - mean * mean;
        let is_longer = self.recent.len() > self.best.len();
        if is_longer || variance > self.best_variance {
            self.best = self.recent.iter().cloned().collect();
            self.best_variance = variance;
        }
    }

    pub(super) fn into_record(mut self) -> Record {
        if !self.growing.samples.is_empty() {
            self.close_chunk();
        }
        drop(self.recent);
        let mut samples = Vec::with_capacity(self.best.iter().map(|c| c.samples.len()).sum());
        for chunk in self.best {
            samples.extend_from_slice(&chunk.samples);
        }
        samples.into_iter().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn io_a_long_log_keeps_its_most_excited_segment() {
        let mut segment = MostExcited::default();
        for k in 0..1_500_000 {
            let excited = (900_000..1_000_000).contains(&k);
            let rudder_rad = if excited && k / 40 % 2 == 0 { 0.3 } else { 0.0 };
            segment.push(Sample { time_s: f64::from(k) * 0.05, rudder_rad, ..Sample::default() });
        }
        let record = segment.into_record();
        assert_eq!(record.samples.len(), MOST_SAMPLES);
        assert!(record.samples[0].time_s <= 900_000.0 * 0.05);
        assert!(record.samples[MOST_SAMPLES - 1].time_s >= 999_999.0 * 0.05);
    }

    #[test]
    fn io_a_short_log_is_kept_whole() {
        let mut segment = MostExcited::default();
        for k in 0..120_001 {
            segment.push(Sample { time_s: f64::from(k), ..Sample::default() });
        }
        let record = segment.into_record();
        assert_eq!(record.samples.len(), 120_001);
        assert!(record.samples.is_sorted_by(|a, b| a.time_s < b.time_s));
    }
}
