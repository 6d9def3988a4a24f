//! What a file states of a model and its uncertainty, before it is believed: held against itself.

use seatrial::identification::{NORMAL_95, ReasonCode, ReasonKind, ValidRange};
use seatrial_core::{Nomoto, YawModel};
use serde::Deserialize;

/// Relative; what numbers lose in a file.
const ROUNDING: f64 = 1e-6;
/// No interval of 95 % ends more than 3.2 times 1.96 deviations from its mean, whatever the distribution (Cantelli's inequality), and
/// 1.96 deviations of an estimate are at most so many half widths of its interval.
const FARTHEST: f64 = 4.0;
/// No model is accepted whose interval of a22 or b2 has a half width beyond its value: the verdict's own bounds are narrower.
const WIDEST: f64 = 1.0;

/// A model with its uncertainty as a document or a schedule file states it.
#[derive(Default)]
pub(super) struct ModelStatement {
    /// [a22, b2, C0].
    pub theta: [f64; 3],
    /// 95 % intervals of a22, b2 and C0.
    pub intervals: [Option<[f64; 2]>; 3],
    /// Covariance of [a22, b2, C0].
    pub covariance: Option<[[f64; 3]; 3]>,
    /// a22 of the vehicle that the gain is made for, 1/s.
    pub gain_a22_per_s: Option<f64>,
    /// Nomoto form of the model.
    pub nomoto: Option<Nomoto<f64>>,
    /// C0/b2, rad.
    pub delta0_rad: Option<f64>,
    /// Over what it was seen.
    pub valid_range: Option<ValidRange>,
    /// At what speed it is said to be, m/s.
    pub surge_speed_m_s: Option<f64>,
    /// Duration of its training, s, which no delay exceeds.
    pub training_s: Option<f64>,
    /// What cannot be negative, by name: noise, delays, lags.
    pub amounts: Vec<(&'static str, Option<f64>)>,
    /// Does the verdict, and no operator, accept it?
    pub is_accepted: bool,
}

impl ModelStatement {
    /// What is wrong with it, where something is: an interval that does not hold its value would make a gain that allows for
    /// nothing, and a covariance that is none an interval without width.
    pub fn wrong(&self) -> Option<String> {
        self.wrong_interval()
            .or_else(|| self.wrong_gain_vehicle())
            .or_else(|| self.wrong_covariance())
            .or_else(|| self.wrong_form())
            .or_else(|| self.wrong_range())
            .or_else(|| self.wrong_amount())
    }

    fn wrong_interval(&self) -> Option<String> {
        let names = ["a22_per_s", "b2_per_s2", "c0_rad_per_s2"];
        let stated = names.iter().zip(self.theta).zip(self.intervals);
        for (i, ((name, value), interval)) in stated.enumerate() {
            let Some([low, high]) = interval else {
                continue;
            };
            if !(low.is_finite() && high.is_finite() && low <= value && value <= high) {
                return Some(format!(
                    "the 95 % interval of {name} is [{low}, {high}]: expected the least and the greatest value, with {value} between them"
                ));
            }
            if self.is_accepted && i < 2 && high - low > 2.0 * WIDEST * value.abs() {
                return Some(format!(
                    "the 95 % interval of {name} is [{low}, {high}]: no verdict accepts {value} with it"
                ));
            }
        }
        None
    }

    /// a22 of the least damped vehicle that a gain allows for, 1/s: the one that the gain is made for, else the end of the interval.
    pub fn least_damped_per_s(&self) -> Option<f64> {
        let [interval, ..] = self.intervals;
        self.gain_a22_per_s.or(interval.map(|[_, end]| end))
    }

    fn wrong_gain_vehicle(&self) -> Option<String> {
        let stated = self.gain_a22_per_s?;
        let [a22, ..] = self.theta;
        let is_less_damped = a22 <= stated && stated <= 0.0;
        (!is_less_damped).then(|| {
            format!(
                "the gain is made for a vehicle with a22_per_s {stated}: expected one between {a22} and 0"
            )
        })
    }

    fn wrong_covariance(&self) -> Option<String> {
        let covariance = self.covariance?;
        let is_finite = covariance.iter().flatten().all(|entry| entry.is_finite());
        let variances = [covariance[0][0], covariance[1][1], covariance[2][2]];
        let is_correlated = |i: usize, j: usize| {
            let most = (variances[i] * variances[j]).sqrt() * (1.0 + ROUNDING);
            covariance[i][j].abs() <= most
                && (covariance[i][j] - covariance[j][i]).abs() <= ROUNDING * most
        };
        let is_one = is_finite
            && variances.iter().all(|variance| *variance >= 0.0)
            && [(0, 1), (0, 2), (1, 2)].into_iter().all(|(i, j)| is_correlated(i, j));
        if !is_one {
            return Some(format!(
                "covariance of [a22, b2, C0]: expected finite numbers, the same on both sides of the diagonal, with variances of at least 0 and correlations within 1, found {covariance:?}"
            ));
        }
        let apart = (0..3).find(|i| !self.belong_together(*i, variances[*i].sqrt()))?;
        Some(format!(
            "the 95 % interval of {} and its variance {} are not of one estimate: take the document as seatrial wrote it",
            ["a22", "b2", "C0"][apart],
            variances[apart]
        ))
    }

    /// Are an interval and a deviation those of one estimate? That of a22 may reach a damping at which a gain still holds.
    fn belong_together(&self, i: usize, deviation: f64) -> bool {
        let Some([low, high]) = self.intervals[i] else {
            return true;
        };
        let value = self.theta[i];
        let of_deviation = NORMAL_95 * deviation;
        let farthest = FARTHEST * of_deviation + ROUNDING * value.abs();
        let least_damped = if i == 0 { -value } else { 0.0 };
        let is_narrow = value - low <= farthest && high - value <= farthest.max(least_damped);
        is_narrow && (deviation == 0.0 || of_deviation <= FARTHEST * 0.5 * (high - low))
    }

    /// What follows from the parameters, where it is stated and does not.
    fn wrong_form(&self) -> Option<String> {
        let model = YawModel::from_theta(self.theta);
        let form = model.nomoto();
        let checked = [
            ("nomoto T", self.nomoto.map(|n| n.t_s), form.map(|n| n.t_s)),
            ("nomoto K", self.nomoto.map(|n| n.k_per_s), form.map(|n| n.k_per_s)),
            ("delta0", self.delta0_rad, model.delta0_rad()),
        ];
        let differs = |(_, stated, follows): &(_, Option<f64>, Option<f64>)| match (stated, follows)
        {
            (Some(stated), Some(follows)) => (stated - follows).abs() > ROUNDING * follows.abs(),
            (Some(_), None) => true,
            (None, _) => false,
        };
        let (name, stated, follows) = checked.into_iter().find(differs)?;
        let [stated, follows] =
            [stated, follows].map(|value| value.map_or("none".into(), |value| value.to_string()));
        Some(format!(
            "{name} is {stated}, and {follows} follows from a22, b2 and C0: take the document as seatrial wrote it"
        ))
    }

    fn wrong_range(&self) -> Option<String> {
        let range = self.valid_range?;
        // Of a model that is not accepted the noise may hide all frequencies.
        let band = Some(range.band_rad_s).filter(|_| self.is_accepted);
        let ranges = [
            ("rudder", Some(range.rudder)),
            ("surge_speed_m_s", range.surge_speed_m_s),
            ("band_rad_s", band),
        ];
        let is_none = |[low, high]: [f64; 2]| !(low.is_finite() && high.is_finite() && low <= high);
        let reversed = ranges
            .into_iter()
            .filter_map(|(name, range)| Some((name, range?)))
            .find(|(_, range)| is_none(*range));
        if let Some((name, [low, high])) = reversed {
            return Some(format!(
                "valid_range: {name} is [{low}, {high}]: expected the least and the greatest value"
            ));
        }
        let ([low, high], speed) = (range.surge_speed_m_s?, self.surge_speed_m_s?);
        let is_seen = (1.0 - ROUNDING) * low <= speed && speed <= (1.0 + ROUNDING) * high;
        (!is_seen).then(|| {
            format!("surge_speed_m_s is {speed}: expected one of its valid_range, [{low}, {high}]")
        })
    }

    fn wrong_amount(&self) -> Option<String> {
        let amounts = self.amounts.iter();
        let mut amounts = amounts.filter_map(|(name, amount)| Some((name, (*amount)?)));
        let most = |name: &str| match self.training_s {
            Some(training_s) if name.ends_with("_s") => training_s,
            _ => f64::MAX,
        };
        let (name, amount) =
            amounts.find(|(name, amount)| !(*amount >= 0.0 && *amount <= most(name)))?;
        Some(format!("{name} is {amount}: expected at least 0, and no delay beyond the training"))
    }
}

/// A verdict as a document states it.
#[derive(Deserialize)]
pub(super) struct StatedVerdict {
    pub accepted: bool,
    outcome: Option<String>,
    #[serde(default)]
    reasons: Vec<StatedReason>,
}

#[derive(Deserialize)]
struct StatedReason {
    #[serde(flatten)]
    kind: ReasonKind,
    #[serde(default)]
    text: String,
}

impl StatedVerdict {
    /// Does it give this reason?
    pub fn has(&self, kind: &ReasonKind) -> bool {
        self.reasons.iter().any(|reason| reason.kind == *kind)
    }

    /// Why it refuses, in words.
    pub fn refusal(&self) -> &str {
        let first = self.reasons.first().map(|reason| reason.text.as_str());
        let first = first.filter(|text| !text.is_empty());
        first.unwrap_or("the verdict on this model is not `accepted`: see the reasons there")
    }

    /// What is wrong with it: it does not follow from its reasons.
    pub fn wrong(&self) -> Option<String> {
        let says = |code: &ReasonCode| {
            use ReasonCode::{AcceptedByOperator, Ok, Other};
            matches!(code, Ok | AcceptedByOperator | Other(_))
        };
        let first = self.reasons.first().map(|reason| &reason.kind.code);
        let follows = match self.accepted {
            true => first.is_none() || self.reasons.iter().any(|reason| says(&reason.kind.code)),
            false => first != Some(&ReasonCode::Ok),
        };
        let is_of_outcome = match self.outcome.as_deref() {
            Some("use" | "use_with_care") => self.accepted,
            Some("not_validated" | "do_not_use") => !self.accepted,
            _ => true,
        };
        (!follows || !is_of_outcome).then(|| {
            format!(
                "the verdict, accepted: {}, does not follow from its own reasons and outcome: take the document as seatrial wrote it",
                self.accepted
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_an_interval_holds_its_value_and_a_covariance_is_one() {
        let of = |a22: [f64; 2], variance: f64| ModelStatement {
            theta: [-1.0, 1.0, 0.0],
            intervals: [Some(a22), None, None],
            covariance: Some([[variance, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]]),
            ..ModelStatement::default()
        };
        for (a22, variance) in [
            ([-1.25, -0.75], 0.1),
            ([-1.0, -1.0], 0.0),
            ([-2.5, 0.5], 0.1),
            // As far as a damping at which a gain still holds.
            ([-1.01, 0.0], 2.5e-5),
        ] {
            assert_eq!(of(a22, variance).wrong(), None, "{a22:?}");
        }
        // No estimate has both.
        assert!(of([-2.0, -0.9], 1e-4).wrong().is_some());
        assert!(of([-1e300, 1e300], 0.1).wrong().is_some());
        assert!(of([-1.25, -0.75], 1e30).wrong().is_some());
        let (inf, nan) = (f64::INFINITY, f64::NAN);
        let none = [[-0.75, -1.25], [-0.9, -0.8], [-inf, 0.0], [-1.5, nan], [-1.5, inf]];
        for a22 in none {
            assert!(of(a22, 0.1).wrong().is_some(), "{a22:?}");
        }
        let mut other = of([-1.25, -0.75], 0.1);
        other.covariance.as_mut().unwrap()[0][1] = 0.01;
        assert!(other.wrong().is_some());
        for variance in [-0.1, nan, inf] {
            assert!(of([-1.25, -0.75], variance).wrong().is_some(), "{variance}");
        }
    }
}
