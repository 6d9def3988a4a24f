//! Does the rudder follow what is asked for?

use std::collections::VecDeque;

/// A rudder this near to what was asked for follows, as a fraction of full.
pub(crate) const FOLLOWS: f64 = 0.15;
/// Demands of this age may still be on their way to the rudder, s, where the round trip is not known.
const ON_THE_WAY_S: f64 = 1.5;
/// How long an autopilot takes over a demand once it has it, s.
const TAKES_S: f64 = 0.3;
/// A rudder that does not follow for this long ends the trial, s. A pilot who has taken it is told by a heartbeat once a second.
const NOT_FOLLOWED_S: f64 = 1.0;

/// The demands of late, and when the rudder last followed one.
#[derive(Debug, Default)]
pub(crate) struct Following {
    /// Time, s, and rudder asked for.
    demands: VecDeque<(f64, f64)>,
    followed_s: f64,
    round_trip_s: Option<f64>,
}

impl Following {
    /// Takes note of a demand.
    pub fn asked(&mut self, now_s: f64, rudder: f64) {
        self.demands.push_back((now_s, rudder));
        let arrives_s = |round_trip_s: f64| ON_THE_WAY_S.min(2.0 * round_trip_s + TAKES_S);
        let on_the_way_s = self.round_trip_s.map_or(ON_THE_WAY_S, arrives_s);
        let is_old = |(asked_s, _): &mut (f64, f64)| now_s - *asked_s > on_the_way_s;
        while self.demands.pop_front_if(is_old).is_some() {}
    }

    /// The round trip of the link, s: an older demand has arrived.
    pub fn over(&mut self, round_trip_s: Option<f64>) {
        self.round_trip_s = round_trip_s;
    }

    /// The rudder counts as following from now on.
    pub fn restart(&mut self, now_s: f64) {
        self.followed_s = now_s;
    }

    /// Takes note of a measured rudder, in the unit of the demands. Returns whether it has not been within `near` of any
    /// recent demand for too long.
    pub fn is_lost(&mut self, now_s: f64, found: f64, near: f64) -> bool {
        let follows = self.demands.iter().any(|(_, asked)| (asked - found).abs() < near);
        if follows {
            self.followed_s = now_s;
        }
        now_s - self.followed_s > NOT_FOLLOWED_S
    }
}
