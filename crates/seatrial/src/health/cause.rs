//! What a change reads like: the one cause that explains it best.

use nalgebra::DVector;
use serde::Serialize;
use statrs::distribution::ContinuousCDF;

use super::pool::{PooledChange, f_distribution, interval};
use super::{Effect, Effects};

/// A cause does not explain a change if what it leaves is less probable than this.
const LEAST_P_VALUE: f64 = 0.05;

/// A single cause of a change.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Cause {
    /// b2 alone: a damaged, fouled or exchanged rudder, or a slower flow at it.
    Rudder,
    /// a22 alone: another hull shape, fouling.
    Damping,
    /// C0 alone: trim, list, a bent fin, wind and current.
    Offset,
    /// a22, b2 and C0 alike: more or less inertia, a payload.
    Inertia,
    /// a22 as u, b2 and C0 as u^2: another speed at the same thrust.
    Speed,
}

/// The cause that explains a change best.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Explanation {
    /// Which one.
    pub cause: Cause,
    /// How strong: a share of b2, a22, both or the speed; the offset in rad.
    pub size: Effect,
    /// Other causes that explain it within the noise.
    pub also_possible: Vec<Cause>,
}

impl Cause {
    const ALL: [Self; 5] = [Self::Rudder, Self::Inertia, Self::Damping, Self::Offset, Self::Speed];

    /// How a unit of it moves x.
    fn direction(self, delta0_rad: f64) -> [f64; 3] {
        match self {
            Self::Rudder => [0.0, 1.0, 0.0],
            Self::Damping => [1.0, 0.0, 0.0],
            Self::Offset => [0.0, 0.0, 1.0],
            Self::Inertia => [1.0, 1.0, delta0_rad],
            Self::Speed => [1.0, 2.0, 2.0 * delta0_rad],
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Rudder => "the rudder's authority",
            Self::Damping => "the damping",
            Self::Offset => "the offset",
            Self::Inertia => "the inertia",
            Self::Speed => "the speed",
        }
    }
}

impl Explanation {
    /// `None` where no single cause explains the change within the noise. Where the speed is known not to have
    /// changed, it is no cause.
    pub(super) fn of(pooled: &PooledChange, delta0_rad: f64, speed_is_known: bool) -> Option<Self> {
        let information = pooled.information()?;
        let p = pooled.change.len();
        let total = (pooled.change.transpose() * &information * &pooled.change)[(0, 0)];
        let mut possible: Vec<(f64, Cause, Effect)> = Cause::ALL
            .into_iter()
            .filter(|cause| !(speed_is_known && *cause == Cause::Speed))
            .filter_map(|cause| {
                let direction = DVector::from_row_slice(&cause.direction(delta0_rad)[..p]);
                let along = &information * &direction;
                let square = direction.dot(&along);
                if square == 0.0 {
                    return None;
                }
                let size = along.dot(&pooled.change) / square;
                let left = (total - size * size * square).max(0.0) / (p - 1) as f64;
                let p_value = f_distribution((p - 1) as f64, pooled.degrees_of_freedom).sf(left);
                let size = interval(size, 1.0 / square, pooled.degrees_of_freedom);
                (p_value >= LEAST_P_VALUE).then_some((p_value, cause, size))
            })
            .collect();
        possible.sort_by(|a, b| b.0.total_cmp(&a.0));
        let (_, cause, size) = *possible.first()?;
        Some(Self {
            cause,
            size,
            also_possible: possible[1..].iter().map(|(_, cause, _)| *cause).collect(),
        })
    }

    fn words(&self) -> String {
        let size = self.size;
        let less = size.change < 0.0;
        let by = share(size);
        let words = match self.cause {
            Cause::Rudder if less => format!("the rudder is weaker by {by}"),
            Cause::Rudder => format!("the rudder is stronger by {by}"),
            Cause::Damping if less => format!("turning is damped less by {by}"),
            Cause::Damping => format!("turning is damped more by {by}"),
            Cause::Offset => format!(
                "the steering offset has moved by {}, the rest has not; trim, list and a bent fin do this, but wind and current as well: where these differed, test without the offset",
                angle(size)
            ),
            Cause::Inertia if less => format!(
                "rudder and damping both act less by {by}: the vehicle answers more slowly, as with more inertia (payload)"
            ),
            Cause::Inertia => format!(
                "rudder and damping both act more by {by}: the vehicle answers faster, as with less inertia (payload)"
            ),
            Cause::Speed if less => format!("it steers as at a speed lower by {by}"),
            Cause::Speed => format!("it steers as at a speed higher by {by}"),
        };
        let others: Vec<&str> = self.also_possible.iter().map(|cause| cause.name()).collect();
        if others.is_empty() {
            words
        } else {
            format!(
                "{words}; a change of {} alone would explain it as well",
                others.join(" or of ")
            )
        }
    }
}

/// The change in words: its cause, or everything that moved.
pub(super) fn words(explanation: Option<&Explanation>, effects: &Effects) -> String {
    if let Some(explanation) = explanation {
        return explanation.words();
    }
    let mut words = format!(
        "no single cause explains it: the rudder has changed by {}, the damping by {}",
        signed_share(effects.rudder),
        signed_share(effects.damping)
    );
    if let Some(offset) = effects.offset_rad {
        words += &format!(", the offset by {}", angle(offset));
    }
    words
}

/// `20 % (17 to 23 %)`, the sign is in the words before.
fn share(size: Effect) -> String {
    let sign = size.change.signum();
    let [a, b] = size.interval_95.map(|end| 100.0 * sign * end);
    format!("{:.0} % ({:.0} to {:.0} %)", 100.0 * size.change.abs(), a.min(b), a.max(b))
}

/// `-20 % (-23 to -17 %)`
fn signed_share(size: Effect) -> String {
    let [low, high] = size.interval_95.map(|end| 100.0 * end);
    format!("{:+.0} % ({low:+.0} to {high:+.0} %)", 100.0 * size.change)
}

/// `+1.2 deg of rudder (+1.0 to +1.4)`
fn angle(size: Effect) -> String {
    let [low, high] = size.interval_95.map(f64::to_degrees);
    format!("{:+.2} deg of rudder ({low:+.2} to {high:+.2})", size.change.to_degrees())
}
