//! The doublet to take for a given width of the intervals.

use std::fmt;

use seatrial_core::{Excitation, Manoeuvre, Plan};
use serde::{Deserialize, Serialize};

use super::design::{PRIOR_ERROR, fastest_turn_rad_s, thinned};
use super::expected_vehicle::ExpectedVehicle;
use super::information::relative_half_widths;
use super::{Prior, PriorSpeed, excursion_rad};

/// Width of the bound that is aimed at, as a part of the target. The bound knows the rudder's lag; the interval from a
/// record, which does not, is within twice the bound in nine of ten trials.
const AIM: f64 = 0.5;

/// Longest period, in time constants of the vehicle: each deflection lasts until the yaw rate is within 2 % of
/// its steady value. Longer ones determine b2/a22 only.
const LONGEST_PERIOD: f64 = 8.0;
/// Shortest period, in time constants.
const SHORTEST_PERIOD: f64 = 1.0;
/// Ratio of one period to the next.
const PERIOD_RATIO: f64 = 1.19;

/// A period may need this much more rudder than the best one to be preferred for being shorter.
const PREFERRED_WITHIN: f64 = 1.1;

/// Halvings of the range of amplitudes.
const HALVINGS: u32 = 12;

/// Amplitudes are rounded up to this, rad.
const AMPLITUDE_STEP_RAD: f64 = 0.001;

/// Half widths of 95 % intervals to reach, as fractions of the parameter.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Target {
    /// Half width of the interval of a22 as a fraction of it; `None` where it does not matter.
    pub a22: Option<f64>,
    /// Half width of the interval of b2 as a fraction of it; `None` where it does not matter.
    pub b2: Option<f64>,
}

impl Target {
    /// The larger of the widths of a22 and b2 as a part of its target: 1 just reaches it.
    ///
    /// ```
    /// use seatrial::preview::Target;
    ///
    /// let target = Target { a22: Some(0.1), b2: None };
    /// // 8 % of the 10 % wanted of a22; b2 does not matter.
    /// assert!((target.share([0.08, 0.5]) - 0.8).abs() < 1e-12);
    /// ```
    pub fn share(&self, [a22, b2]: [f64; 2]) -> f64 {
        let share = |width: f64, target: Option<f64>| target.map_or(0.0, |target| width / target);
        share(a22, self.a22).max(share(b2, self.b2))
    }

    /// Is it of a22, b2 or both, each a fraction above 0 and below 1?
    ///
    /// ```
    /// use seatrial::preview::Target;
    ///
    /// assert!(Target { a22: Some(0.1), b2: None }.is_valid());
    /// assert!(!Target { a22: None, b2: None }.is_valid());
    /// assert!(!Target { a22: Some(1.5), b2: None }.is_valid());
    /// ```
    pub fn is_valid(&self) -> bool {
        let within = |width: Option<f64>| width.is_none_or(|w| w > 0.0 && w < 1.0);
        within(self.a22) && within(self.b2) && (self.a22.is_some() || self.b2.is_some())
    }
}

/// A target that cannot be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InvalidTarget {
    found: String,
}

impl fmt::Display for InvalidTarget {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(
            f,
            "`{}` is no target: expected a22, b2 or both, each once, with a width above 0 and below 100 %, as in a22:10%,b2:5%",
            self.found
        )
    }
}

impl std::error::Error for InvalidTarget {}

/// Reads a target such as `a22:10%,b2:5%`.
///
/// ```
/// use seatrial::preview::parse_target;
///
/// let target = parse_target("a22:10%,b2:5%")?;
/// assert_eq!((target.a22, target.b2), (Some(0.1), Some(0.05)));
/// assert!(parse_target("c0:10%").is_err());
/// # Ok::<(), seatrial::preview::InvalidTarget>(())
/// ```
pub fn parse_target(text: &str) -> Result<Target, InvalidTarget> {
    let invalid = |found: &str| InvalidTarget { found: found.into() };
    let mut target = Target { a22: None, b2: None };
    for part in text.split(',') {
        let (name, width) = part.trim().split_once(':').ok_or_else(|| invalid(part))?;
        let place = match name.trim() {
            "a22" => &mut target.a22,
            "b2" => &mut target.b2,
            _ => return Err(invalid(part)),
        };
        let fraction = width
            .trim()
            .strip_suffix('%')
            .and_then(|percent| percent.trim().parse::<f64>().ok())
            .map(|percent| percent / 100.0)
            .filter(|fraction| *fraction > 0.0 && *fraction < 1.0);
        if place.is_some() || fraction.is_none() {
            return Err(invalid(part));
        }
        *place = fraction;
    }
    Ok(target)
}

/// A doublet for a target.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Recommendation {
    /// The thrust that it is for, as a fraction of full; `None`: one doublet for every thrust of the plan.
    pub thrust: Option<f64>,
    /// Does it reach the target? Otherwise it is what comes nearest.
    pub reachable: bool,
    /// Amplitude, rad.
    pub amplitude_rad: f64,
    /// Period, s.
    pub period_s: f64,
    /// Half widths of the 95 % intervals of a22 and b2 to expect at best, as fractions; the widest of all speeds.
    pub relative_half_width_95: [f64; 2],
    /// The half widths that nine of ten trials keep within.
    pub nine_of_ten_within: [f64; 2],
    /// Farthest heading from the heading held, rad, the farthest of all speeds.
    pub heading_excursion_rad: f64,
}

/// The doublet of least amplitude that reaches the target, for each thrust and for all of them, the last one.
///
/// It aims at two thirds of the target, which nine of ten trials then reach. Periods from 1 to 8 time constants of
/// the vehicle are tried; of those within 10 % of the least amplitude the shortest is taken. The lead-in and the time
/// of observation are the plan's. The amplitude stays within the plan's rudder limit, and within 1/1.3 of its
/// envelope of heading and yaw rate, since the prior may be wrong by 30 %. A thrust of whose model no doublet determines
/// anything is left out.
pub fn recommend(plan: &Plan<f64>, prior: &Prior, target: Target) -> Vec<Recommendation> {
    let one_each = prior.speeds.iter().map(std::slice::from_ref);
    let all = (prior.speeds.len() > 1).then_some(prior.speeds.as_slice());
    one_each.chain(all).filter_map(|speeds| Search { plan, prior, speeds, target }.best()).collect()
}

struct Search<'a> {
    plan: &'a Plan<f64>,
    prior: &'a Prior,
    speeds: &'a [PriorSpeed],
    target: Target,
}

/// What a doublet does and determines at the speed where it does most and at that where it determines least.
#[derive(Clone, Copy)]
struct DoubletEffect {
    amplitude_rad: f64,
    period_s: f64,
    relative_half_width_95: [f64; 2],
    heading_excursion_rad: f64,
    /// Part of the target that the widths are.
    share: f64,
    fits: bool,
}

impl Search<'_> {
    fn best(&self) -> Option<Recommendation> {
        let tried: Vec<DoubletEffect> = self
            .periods_s()
            .into_iter()
            .filter_map(|period_s| self.least_amplitude(period_s))
            .collect();
        let reaching = || tried.iter().filter(|played| played.share <= AIM);
        let least_rad = reaching().map(|played| played.amplitude_rad).fold(f64::INFINITY, f64::min);
        // Periods are tried in increasing order.
        let preferred = reaching()
            .find(|played| played.amplitude_rad <= PREFERRED_WITHIN * least_rad)
            .or_else(|| tried.iter().min_by(|a, b| a.share.total_cmp(&b.share)))?;
        let thrust = match self.speeds {
            [speed] => Some(speed.thrust),
            _ => None,
        };
        Some(Recommendation {
            thrust,
            reachable: preferred.share <= AIM,
            amplitude_rad: preferred.amplitude_rad,
            period_s: preferred.period_s,
            relative_half_width_95: preferred.relative_half_width_95,
            nine_of_ten_within: preferred.relative_half_width_95.map(|width| width / AIM),
            heading_excursion_rad: preferred.heading_excursion_rad,
        })
    }

    /// Whole samples to either side.
    fn periods_s(&self) -> Vec<f64> {
        let time_constants_s = || self.speeds.iter().map(|s| 1.0 / s.model.a22_per_s.abs());
        let shortest_s = SHORTEST_PERIOD * time_constants_s().fold(f64::INFINITY, f64::min);
        let longest_s = LONGEST_PERIOD * time_constants_s().fold(0.0, f64::max);
        let pair_s = 2.0 * self.prior.sample_interval_s;
        let mut periods_s: Vec<f64> = Vec::new();
        let mut period_s = shortest_s.max(pair_s);
        while period_s <= longest_s && longest_s.is_finite() {
            let whole_s = pair_s * (period_s / pair_s).round();
            let fits =
                self.manoeuvre(0.0, whole_s).duration_s() < self.plan.envelope.stage_time_limit_s;
            if periods_s.last() != Some(&whole_s) && fits {
                periods_s.push(whole_s);
            }
            period_s *= PERIOD_RATIO;
        }
        periods_s
    }

    fn manoeuvre(&self, amplitude_rad: f64, period_s: f64) -> Manoeuvre<f64> {
        Manoeuvre {
            excitation: Excitation::Doublet { amplitude_rad, period_s },
            ..self.plan.training
        }
    }

    /// The least amplitude that reaches the target at this period, otherwise the largest allowed.
    fn least_amplitude(&self, period_s: f64) -> Option<DoubletEffect> {
        let limit_rad = self.plan.rudder_limit_rad.min(self.prior.rudder_limit_rad);
        let largest = self.bisect(period_s, limit_rad, |played| !played.fits);
        let largest_rad = largest.below_rad;
        let most = self.play(largest_rad, period_s);
        if !most.share.is_finite() {
            return None;
        }
        if most.share > AIM {
            return Some(most);
        }
        let enough = self.bisect(period_s, largest_rad, |played| played.share <= AIM);
        let rounded_rad = AMPLITUDE_STEP_RAD * (enough.above_rad / AMPLITUDE_STEP_RAD).ceil();
        Some(self.play(rounded_rad.min(largest_rad), period_s))
    }

    /// Between which amplitudes a condition begins to hold that holds from some amplitude on.
    fn bisect(
        &self,
        period_s: f64,
        most_rad: f64,
        holds: impl Fn(&DoubletEffect) -> bool,
    ) -> Between {
        let mut between = Between { below_rad: 0.0, above_rad: most_rad };
        if !holds(&self.play(most_rad, period_s)) {
            between.below_rad = most_rad;
            return between;
        }
        for _ in 0..HALVINGS {
            let middle_rad = 0.5 * (between.below_rad + between.above_rad);
            if holds(&self.play(middle_rad, period_s)) {
                between.above_rad = middle_rad;
            } else {
                between.below_rad = middle_rad;
            }
        }
        between
    }

    fn play(&self, amplitude_rad: f64, period_s: f64) -> DoubletEffect {
        let manoeuvre = self.manoeuvre(amplitude_rad, period_s);
        let prior = thinned(self.prior, manoeuvre.duration_s());
        let envelope = &self.plan.envelope;
        let room = 1.0 / (1.0 + PRIOR_ERROR);
        let mut played = DoubletEffect {
            amplitude_rad,
            period_s,
            relative_half_width_95: [0.0; 2],
            heading_excursion_rad: 0.0,
            share: 0.0,
            fits: true,
        };
        let thinned = prior
            .speeds
            .iter()
            .filter(|speed| self.speeds.iter().any(|own| own.thrust == speed.thrust));
        for speed in thinned {
            let samples = ExpectedVehicle::train(&prior, *speed, &manoeuvre);
            let widths = relative_half_widths(&samples, speed);
            let excursion_rad = excursion_rad(&samples, prior.heading_rad);
            for (widest, width) in played.relative_half_width_95.iter_mut().zip(widths) {
                *widest = widest.max(width);
            }
            played.heading_excursion_rad = played.heading_excursion_rad.max(excursion_rad);
            played.share = played.share.max(self.target.share(widths));
            played.fits &= excursion_rad <= room * envelope.heading_excursion_max_rad
                && fastest_turn_rad_s(&samples) <= room * envelope.yaw_rate_max_rad_s;
        }
        played
    }
}

/// A condition does not hold below and holds above.
struct Between {
    below_rad: f64,
    above_rad: f64,
}
