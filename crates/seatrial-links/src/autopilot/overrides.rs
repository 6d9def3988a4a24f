//! Does the vehicle act on our overrides, or on somebody else's?

use std::collections::VecDeque;

use crate::link::message::RcChannels;

/// The channels that we override: steering and throttle, from 0.
const OURS: [usize; 2] = [0, 2];
/// Overrides of this age may still be on their way, s.
const ON_THE_WAY_S: f64 = 1.5;
/// A pulse this near to one that was asked for is ours, us.
const NEAR_US: u16 = 30;
/// A pulse this near to where the stick was is the stick's, us.
const STICK_US: u16 = 100;
/// Reports in turn that tell of somebody else; they come five times a second.
const REPORTS: u32 = 2;

/// What we asked for of late, and what the vehicle reports.
#[derive(Debug, Default)]
pub(super) struct Overrides {
    asked: VecDeque<(f64, [u16; 2])>,
    /// Has one of ours been reported?
    is_in_force: bool,
    foreign: u32,
}

impl Overrides {
    /// Takes note of an override that was sent.
    pub fn asked(&mut self, now_s: f64, pulses: &[u16; 8]) {
        self.asked.push_back((now_s, OURS.map(|channel| pulses[channel])));
        let is_old = |(asked_s, _): &(f64, _)| now_s - asked_s > ON_THE_WAY_S;
        while self.asked.front().is_some_and(is_old) {
            self.asked.pop_front();
        }
    }

    /// Takes note of a report; `sticks` is where they were when the vehicle was taken.
    pub fn reported(&mut self, channels: &RcChannels, sticks: Option<[u16; 18]>) {
        let found = OURS.map(|channel| channels.pulses[channel]);
        let is_near = |a: u16, b: u16, near_us: u16| a.abs_diff(b) <= near_us;
        let is_ours = |k: usize| {
            let mut asked = self.asked.iter();
            asked.any(|(_, asked)| is_near(asked[k], found[k], NEAR_US))
        };
        let is_stick =
            |k: usize| sticks.is_none_or(|sticks| is_near(sticks[OURS[k]], found[k], STICK_US));
        if is_ours(0) && is_ours(1) {
            (self.is_in_force, self.foreign) = (true, 0);
        } else if self.is_in_force && (0..2).any(|k| !is_ours(k) && !is_stick(k)) {
            self.foreign += 1;
        }
    }

    /// Somebody else overrides the channels that we override.
    pub fn is_foreign(&self) -> bool {
        self.foreign >= REPORTS
    }
}
