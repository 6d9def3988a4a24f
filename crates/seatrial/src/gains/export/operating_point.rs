//! The one model that an autopilot without a gain schedule is tuned for.

use std::fmt::Write as _;

use seatrial_core::{HeadingGain, HeadingLoop, SchedulePoint, Side, Turn, YawModel};

use super::cascade::Steering;
use super::{comment_lines, delays};
use crate::gain_allowance::GainAllowance;
use crate::propagation::interval_95;

/// A record whose rudder went at least to this share of full rudder has seen full rudder.
const NEARLY: f64 = 0.95;

/// A model and what is wanted of it.
#[derive(Clone, Debug, PartialEq)]
pub struct OperatingPoint {
    /// Where the model comes from, for people.
    pub source: String,
    /// Thrust, speed and model.
    pub at: SchedulePoint<f64>,
    /// zeta of the heading loop.
    pub damping_ratio: f64,
    /// The vehicle's rudder angle at full steering, rad; a trial may have kept its rudder within a smaller one.
    pub full_rudder_rad: f64,
    /// The largest rudder angle of the record that the model is of, rad, where it is known.
    pub seen_rudder_rad: Option<f64>,
    /// What the gains allow for.
    pub allowance: GainAllowance,
    /// Covariance of [a22, b2, C0], where known.
    pub covariance: Option<[[f64; 3]; 3]>,
    /// What has to be known of the source, a comment each.
    pub notes: Vec<String>,
}

/// A parameter and what it follows from: name, value where the model determines it, unit, derivation.
pub(super) type Row = (&'static str, Option<f64>, &'static str, &'static str);

/// A parameter of an autopilot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Its name there.
    pub name: &'static str,
    /// Its value, in the autopilot's unit.
    pub value: f64,
    /// That unit.
    pub unit: &'static str,
    /// How it follows from the model.
    pub because: &'static str,
    /// What the uncertainty of the model makes of it, `[low, high]`.
    pub interval_95: Option<[f64; 2]>,
    /// Is it a limit of what the vehicle does under full rudder?
    pub is_limit: bool,
    /// Of a limit that is extrapolated: its value at the largest rudder of the record.
    pub seen: Option<f64>,
}

impl Parameter {
    /// The parameters that the model determines.
    pub(super) fn determined(rows: &[Row]) -> Vec<Self> {
        let parameter = |&(name, value, unit, because): &Row| {
            Some(Self {
                name,
                value: value?,
                unit,
                because,
                interval_95: None,
                is_limit: false,
                seen: None,
            })
        };
        rows.iter().filter_map(parameter).collect()
    }

    /// These as limits of what the vehicle does under full rudder.
    pub(super) fn as_limits(mut limits: Vec<Self>) -> Vec<Self> {
        limits.iter_mut().for_each(|limit| limit.is_limit = true);
        limits
    }

    /// The comment above it in a file.
    pub(super) fn comment(&self) -> String {
        let interval = self
            .interval_95
            .map_or(String::new(), |[low, high]| format!("; 95 %: {low:.4} to {high:.4}"));
        let seen = self.seen.map_or(String::new(), |seen| {
            format!("; EXTRAPOLATED, {seen:.4} at the rudder of the record")
        });
        comment_lines(&format!("{} [{}]{interval}{seen}", self.because, self.unit))
    }
}

/// The steady yaw rate under full rudder to the weaker side, rad/s. `None` where it does not turn there.
pub(super) fn yaw_rate_limit_rad_s(model: &YawModel<f64>, rudder_limit_rad: f64) -> Option<f64> {
    let rate = |side| Some(Turn::new(model, rudder_limit_rad, side).ok()?.yaw_rate_rad_s);
    Some(rate(Side::Starboard)?.min(rate(Side::Port)?))
}

impl OperatingPoint {
    /// What `design` makes of this point, with intervals where a parameter depends on the model.
    pub(super) fn parameters(&self, design: fn(&Self) -> Vec<Parameter>) -> Vec<Parameter> {
        let mut parameters = design(self);
        self.add_seen(&mut parameters, design);
        let Some(covariance) = &self.covariance else {
            return parameters;
        };
        for parameter in &mut parameters {
            let of_model = |model: &YawModel<f64>| {
                let at = SchedulePoint { model: *model, ..self.at };
                let designed = design(&Self { at, ..self.clone() });
                let same = designed.into_iter().find(|p| p.name == parameter.name)?;
                Some(same.value)
            };
            parameter.interval_95 =
                interval_95(&self.at.model, covariance, of_model).filter(|[low, high]| low < high);
        }
        parameters
    }

    /// Beside each limit that is extrapolated its value at the largest rudder of the record.
    fn add_seen(&self, parameters: &mut [Parameter], design: fn(&Self) -> Vec<Parameter>) {
        let Some(seen_rudder_rad) = self.extrapolated_from() else {
            return;
        };
        let at_seen = design(&Self { full_rudder_rad: seen_rudder_rad, ..self.clone() });
        for limit in parameters.iter_mut().filter(|p| p.is_limit) {
            let same = at_seen.iter().find(|p| p.name == limit.name);
            limit.seen = same.map(|same| same.value);
        }
    }

    /// The largest rudder of the record, where it is well below full rudder.
    fn extrapolated_from(&self) -> Option<f64> {
        self.seen_rudder_rad.filter(|seen| *seen > 0.0 && *seen < NEARLY * self.full_rudder_rad)
    }

    /// That the limits go beyond the record, or may, for people.
    pub fn extrapolation(&self) -> Option<String> {
        match (self.extrapolated_from(), self.seen_rudder_rad) {
            (Some(seen_rad), _) => Some(format!(
                "limits of turns are EXTRAPOLATED to full rudder: in the record the rudder went to {:.0} % of it; a hull that drifts turns slower and wider in a long turn, so try full rudder before you rely on them",
                100.0 * seen_rad / self.full_rudder_rad
            )),
            (None, None) => Some(
                "limits of turns are those of full rudder; how far the rudder went in the record is not known here".into(),
            ),
            (None, Some(_)) => None,
        }
    }

    /// K_p, for the damping ratio and what it allows for. `None` for a vehicle that is course unstable or does not steer.
    pub(super) fn gain(&self) -> Option<HeadingGain<f64>> {
        let gain = self.allowance.design(&self.at.model, self.damping_ratio);
        gain.ok()
    }

    /// A cascade where the full steering moves the rudder by `rudder_rad`, with the poles that K_p gives the heading.
    pub(super) fn cascade<C>(
        &self,
        rudder_rad: f64,
        design: impl FnOnce(Steering, f64) -> C,
    ) -> Option<C> {
        let model = &self.at.model;
        let closed = HeadingLoop::new(model, self.gain()?.proportional_gain).ok()?;
        let steering = Steering {
            damping_per_s: -model.a22_per_s,
            authority_rad_s2: model.b2_per_s2.abs() * rudder_rad,
        };
        Some(design(steering, closed.damping_ratio()))
    }

    /// r_max, rad/s.
    pub(super) fn yaw_rate_limit_rad_s(&self) -> Option<f64> {
        yaw_rate_limit_rad_s(&self.at.model, self.full_rudder_rad)
    }

    /// alpha r_max, the yaw acceleration from straight ahead under full rudder to the weaker side, rad/s^2.
    pub(super) fn yaw_acceleration_limit_rad_s2(&self) -> Option<f64> {
        Some(self.yaw_rate_limit_rad_s()? * -self.at.model.a22_per_s)
    }

    /// The first lines of a parameter file, each a comment.
    pub(super) fn heading(&self, title: &str) -> String {
        let mut from = format!("From {}", self.source);
        if let Some(thrust) = self.at.thrust {
            let _ = write!(from, ", at {:.0} % thrust", 100.0 * thrust);
        }
        if let Some(speed) = self.at.surge_speed_m_s {
            let _ = write!(from, ", at {speed:.2} m/s");
        }
        let model = self.at.model;
        let mut lines = vec![
            title.to_owned(),
            from,
            format!(
                "Model r' = a22 r + b2 delta + C0: a22 {} 1/s, b2 {} 1/s^2, C0 {} rad/s^2",
                model.a22_per_s, model.b2_per_s2, model.c0_rad_per_s2
            ),
            format!(
                "Full rudder {} rad at steering 1; alpha = -a22; r_max: steady yaw rate under full rudder, weaker side",
                self.full_rudder_rad
            ),
            format!(
                "w^2 = K_p |b2|; K_p is for a damping ratio of {} with {} and the least damped model of the 95 % interval",
                self.damping_ratio,
                delays(&self.allowance.timing)
            ),
        ];
        lines.extend(model.delta0_rad().map(|offset| {
            format!(
                "Rudder that holds a straight course: {:.1} % of full. Trim the steering servo so that it is there at centre.",
                0.0 - 100.0 * offset / self.full_rudder_rad
            )
        }));
        lines.extend(self.notes.iter().cloned().chain(self.extrapolation()));
        let mut text = String::new();
        for line in &lines {
            let _ = writeln!(text, "{}", comment_lines(line));
        }
        text
    }
}
