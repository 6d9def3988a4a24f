//! The proof that a vehicle's rudder answers, with the right sense, and that the vehicle lets go of it by itself.

use seatrial_core::Sample;

use super::{Controls, NEUTRAL, Preflight};

/// The small wiggle, as a fraction of full rudder.
const WIGGLE: f64 = 0.2;
/// A rudder may differ from what was asked for by this, as a fraction of full.
const ECHO: f64 = 0.05;
/// A yaw rate that tells the rudder's sense, rad/s.
const TELLING_RATE_RAD_S: f64 = 0.01;

/// How a vehicle's rudder is tried, and what to check where it does not answer.
pub(crate) struct Wiggle {
    /// Thrust, as a fraction of full.
    pub thrust: f64,
    /// Duration of the straight run before, s.
    pub straight_s: f64,
    /// Duration of each side, s.
    pub side_s: f64,
    /// Full rudder, rad.
    pub full_rudder_rad: f64,
    /// Is the rudder reported, so that it can be compared with what was asked for?
    pub is_reported: bool,
    /// A positive rudder turns to port.
    pub is_reversed: bool,
    /// What to check where the rudder does not follow.
    pub echo_hint: &'static str,
    /// What to check where the vehicle turns the wrong way.
    pub sense_hint: &'static str,
}

/// Deflects the rudder to both sides and compares it, and the yaw rate, with what was asked for.
pub(crate) fn prove_rudder(vehicle: &mut impl Controls, wiggle: &Wiggle, found: &mut Preflight) {
    vehicle.drive(0.0, wiggle.thrust, wiggle.straight_s);
    let [starboard, port] = [WIGGLE, -WIGGLE].map(|steer| {
        let samples = vehicle.drive(steer, wiggle.thrust, wiggle.side_s);
        if wiggle.is_reported {
            check_echo(&samples, steer, wiggle, found);
        }
        late_mean(&samples, |sample| sample.yaw_rate_rad_s.unwrap_or(0.0))
    });
    let turned_rad_s = starboard - port;
    let sense = if wiggle.is_reversed { -1.0 } else { 1.0 };
    let tells = turned_rad_s.abs() > 2.0 * TELLING_RATE_RAD_S;
    let is_right = turned_rad_s * sense > 0.0;
    let rates = format!("yaw rate {starboard:+.3} and {port:+.3} rad/s to the two sides");
    let text = match (tells, is_right) {
        (true, true) => rates,
        (true, false) => format!("{rates}, the wrong way round: check {}", wiggle.sense_hint),
        (false, _) => "too slow to tell; the trial itself watches it".into(),
    };
    found.check("rudder sense", !tells || is_right, text);
}

fn check_echo(samples: &[Sample<f64>], steer: f64, wiggle: &Wiggle, found: &mut Preflight) {
    let rudder = late_mean(samples, |sample| sample.rudder_rad / wiggle.full_rudder_rad);
    let follows = (rudder - steer).abs() < ECHO;
    let mut text = format!("rudder {rudder:+.3} of full for {steer:+.3} asked");
    if !follows {
        text = format!("{text}: check {}", wiggle.echo_hint);
    }
    found.check("echo", follows, text);
}

/// How a lost process is played.
pub(crate) struct LostProcess {
    /// The name of what must let go of the rudder.
    pub who: &'static str,
    /// Duration of the deflection before, s.
    pub deflected_s: f64,
    /// After this long it must have let go, s.
    pub longest_s: f64,
    /// What to do where it does not.
    pub remedy: &'static str,
}

/// Deflects the rudder and falls silent: the vehicle must let go of it by itself. Returns whether that was tried to the end;
/// something else may have ended the trial.
pub(crate) fn prove_that_it_lets_go(
    vehicle: &mut impl Controls,
    process: &LostProcess,
    found: &mut Preflight,
) -> bool {
    vehicle.drive(WIGGLE, 0.0, process.deflected_s);
    if vehicle.is_stopped() {
        return false;
    }
    vehicle.fall_silent();
    let start_s = vehicle.clock_s();
    let LostProcess { who, longest_s, remedy, .. } = *process;
    vehicle.wait(2.0 * longest_s + 1.0, |vehicle| {
        vehicle.is_rudder_neutral()
            || vehicle.is_stopped()
            || vehicle.clock_s() - start_s > longest_s
    });
    if vehicle.is_stopped() {
        return false;
    }
    let took_s = vehicle.clock_s() - start_s;
    let lets_go = vehicle.is_rudder_neutral();
    found.check(
        "lost process",
        lets_go,
        match lets_go {
            true => format!("without us {who} let go of the rudder within {took_s:.1} s"),
            false => format!(
                "without us the rudder was still above {NEUTRAL} of full after {took_s:.1} s: {remedy}"
            ),
        },
    );
    true
}

/// Mean of a quantity over the later half of the samples, when the vehicle has followed. Values that are not finite do not
/// count; 0 where none is.
fn late_mean(samples: &[Sample<f64>], of: impl Fn(&Sample<f64>) -> f64) -> f64 {
    let late = samples[samples.len() / 2..].iter().map(of);
    let (sum, count) = late
        .filter(|value| value.is_finite())
        .fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / f64::max(count, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_what_is_not_known_does_not_count() {
        let samples = [9.0, 9.0, 1.0, f64::NAN, 2.0]
            .map(|rudder_rad| Sample { rudder_rad, ..Sample::default() });
        let rudder = |sample: &Sample<f64>| sample.rudder_rad;
        assert_eq!(late_mean(&samples, rudder), 1.5);
        assert_eq!(late_mean(&[], rudder), 0.0);
    }
}
