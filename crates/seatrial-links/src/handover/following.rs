//! Does the rudder follow what is asked for?

use std::collections::VecDeque;

/// A rudder this near to what was asked for follows, as a fraction of full.
pub(crate) const FOLLOWS: f64 = 0.15;
/// Demands of this age may still be on their way to the rudder, s.
const ON_THE_WAY_S: f64 = 1.5;
/// A rudder that does not follow for this long ends the trial, s.
const NOT_FOLLOWED_S: f64 = 1.0;

/// The demands of late, and when the rudder last followed one.
#[derive(Debug, Default)]
pub(crate) struct Following {
    /// Time, s, and rudder asked for.
    demands: VecDeque<(f64, f64)>,
    followed_s: f64,
}

impl Following {
    /// Takes note of a demand.
    pub fn asked(&mut self, now_s: f64, rudder: f64) {
        self.demands.push_back((now_s, rudder));
        let is_old = |(asked_s, _): &(f64, f64)| now_s - asked_s > ON_THE_WAY_S;
        while self.demands.front().is_some_and(is_old) {
            self.demands.pop_front();
        }
    }

    /// The rudder counts as following from now on.
    pub fn restart(&mut self, now_s: f64) {
        self.followed_s = now_s;
    }

    /// Takes note of a measured rudder, in the unit of the demands. Returns whether it has not been within `near` of any
    /// recent demand for too long.
    pub fn is_lost(&mut self, now_s: f64, found: f64, near: f64) -> bool {
        let follows = self
            .demands
            .iter()
            .any(|(_, asked)| (asked - found).abs() < near);
        if follows {
            self.followed_s = now_s;
        }
        now_s - self.followed_s > NOT_FOLLOWED_S
    }
}
