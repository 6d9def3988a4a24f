//! What the hand-over needs of a vehicle.

use seatrial_core::Sample;

use super::WAIT_S;

/// Between two questions that are not answered, s.
const ASK_AGAIN_S: f64 = 0.3;
/// Times that a release is sent. Each may be lost, and a damaged message before them may take the next 280 bytes with it.
const RELEASES: u32 = 15;
/// Between two releases, s.
const RELEASE_S: f64 = 0.03;

/// A vehicle whose rudder and thrust can be taken.
pub(crate) trait Controls: Sized {
    /// Our clock, s.
    fn now_s(&self) -> f64;

    /// The clock on which the vehicle times its commands out, as far as it is known, s.
    fn clock_s(&self) -> f64;

    /// Sends what is due, waits until a time at most, and takes in what has come.
    fn pump_until(&mut self, until_s: f64);

    /// Asks for steering and thrust, fractions of full, for this long; returns the samples of that time.
    fn drive(&mut self, steer: f64, thrust: f64, duration_s: f64) -> Vec<Sample<f64>>;

    /// Sends no more demands, as if this program had died.
    fn fall_silent(&mut self);

    /// Makes rudder and thrust neutral.
    fn release(&mut self);

    /// Has something ended the trial?
    fn is_stopped(&self) -> bool;

    /// Was the rudder last seen amidships?
    fn is_rudder_neutral(&self) -> bool;

    /// Pumps until `done`, or for this long on our clock. Returns whether it is done.
    fn wait(&mut self, longest_s: f64, mut done: impl FnMut(&mut Self) -> bool) -> bool {
        let end_s = self.now_s() + longest_s;
        loop {
            if done(self) {
                return true;
            }
            let now_s = self.now_s();
            if now_s >= end_s {
                return false;
            }
            self.pump_until((now_s + WAIT_S).min(end_s));
        }
    }

    /// Asks `question` again and again until `done`, or for this long. Returns whether it is done.
    fn insist(
        &mut self,
        longest_s: f64,
        mut question: impl FnMut(&mut Self),
        mut done: impl FnMut(&mut Self) -> bool,
    ) -> bool {
        let mut asked_s = f64::NEG_INFINITY;
        self.wait(longest_s, |vehicle| {
            if done(vehicle) {
                return true;
            }
            let now_s = vehicle.now_s();
            if now_s - asked_s >= ASK_AGAIN_S {
                asked_s = now_s;
                question(vehicle);
            }
            false
        })
    }

    /// Sends a release often enough that one arrives.
    fn release_repeatedly(&mut self, mut release: impl FnMut(&mut Self)) {
        for _ in 0..RELEASES {
            release(self);
            self.wait(RELEASE_S, |_| false);
        }
    }
}
