//! Numbers by chance.

use seatrial_sim::sensors::Chance;

/// A source of chance for the choices of a kind.
pub struct Draw(Chance);

impl Draw {
    /// The source of a seed.
    pub fn new(seed: u64) -> Self {
        let [chance] = Chance::sources(seed);
        Self(chance)
    }

    /// A number between two, each as likely as the other.
    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.uniform()
    }

    /// A number between two whose logarithm is uniform.
    pub fn log_within(&mut self, low: f64, high: f64) -> f64 {
        libm::exp(self.within(libm::log(low), libm::log(high)))
    }

    /// One of several.
    pub fn one_of<T: Copy>(&mut self, of: &[T]) -> T {
        let index = (self.0.uniform() * of.len() as f64) as usize;
        of[index.min(of.len() - 1)]
    }

    /// 1 or -1.
    pub fn sign(&mut self) -> f64 {
        self.one_of(&[1.0, -1.0])
    }

    /// A normal deviate.
    pub fn normal(&mut self) -> f64 {
        self.0.normal()
    }

    /// True in this share of draws.
    pub fn chance(&mut self, share: f64) -> bool {
        self.0.uniform() < share
    }
}
