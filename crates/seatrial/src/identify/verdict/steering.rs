//! May a model of ordinary steering be used?

use super::parameters::NO_GAIN_HOLDS;
use super::{Share, Weighing, first_of_all_the_rudder};
use crate::figures::{percent, r2_text, three_figures};
use crate::identification::{Reason, ReasonCode, Verdict, WIDEST_A22, WIDEST_B2};
use crate::identify::misfit::{disturbance_share, is_large_share};
use crate::identify::mission::{LEAST_HORIZON_S, Steering};
use crate::identify::whole_record::LEAST_SHARE;
use crate::likelihood::Parameter;
use crate::plausibility;

/// Longest interval at which heading or rudder may be renewed, in time constants of the vehicle.
const LONGEST_INTERVAL: f64 = 0.5;

/// Time constants of the vehicle over which a free run is a long one.
const LONG: f64 = 10.0;

/// Share of the log from which it is noted that the rest was cut out.
const MOST_OF_THE_LOG: f64 = 0.8;

/// Weighs intervals, prediction and log. `is_of_a_hull` tells that a hull predicts much better what is taken for a sea.
pub(in crate::identify) fn judge_steering(steering: &Steering, is_of_a_hull: bool) -> Verdict {
    let mut weighing = Weighing::default();
    weighing.doubts(&steering.log.unit_doubts);
    let a22_per_s = steering.refined.model.a22_per_s;
    weighing.doubts(&plausibility::timing_doubts(&steering.samples, a22_per_s));
    weighing.doubts(&steering.log.unchecked);
    weighing.steering_parameters(steering);
    weighing.steering_pace(steering);
    weighing.steering_prediction(steering, is_of_a_hull);
    weighing.steering_notes(steering);
    first_of_all_the_rudder(weighing.steering_verdict(steering), &steering.log)
}

impl Weighing {
    fn steering_parameters(&mut self, steering: &Steering) {
        let refined = &steering.refined;
        let b2 = Share::new(refined.model.b2_per_s2, refined.interval_95.b2_per_s2);
        let a22 = Share::new(refined.model.a22_per_s, refined.interval_95.a22_per_s);
        if refined.model.a22_per_s >= 0.0 {
            return self.reject(
                ReasonCode::Unstable,
                format!(
                    "a22 = {} 1/s is not negative: the vehicle does not stop turning by itself",
                    three_figures(refined.model.a22_per_s)
                ),
            );
        }
        let worst = (a22.half_width / WIDEST_A22).max(b2.half_width / WIDEST_B2);
        if worst > 1.0 || worst.is_nan() {
            let (name, share) = if a22.half_width / WIDEST_A22 > b2.half_width / WIDEST_B2 {
                ("a22", a22.half_width)
            } else {
                ("b2", b2.half_width)
            };
            let minutes = steering.minutes * (worst * worst - 1.0);
            self.reject(
                ReasonCode::UnderExcited,
                format!(
                    "the 95 % interval of {name} is {} % of it: {} more minutes of such steering would narrow it enough, or one zig-zag",
                    percent(share),
                    three_figures(minutes.max(1.0))
                ),
            );
        }
        self.sign(refined.interval_95.b2_per_s2[1]);
    }

    fn steering_pace(&mut self, steering: &Steering) {
        let Some(pace) = steering.log.pace else {
            return;
        };
        let time_constant_s = -1.0 / steering.refined.model.a22_per_s;
        for (channel, interval_s) in [("heading", pace.heading_s), ("rudder", pace.rudder_s)] {
            if interval_s > LONGEST_INTERVAL * time_constant_s && time_constant_s > 0.0 {
                self.reject(
                    ReasonCode::SampledTooSeldom,
                    format!(
                        "the {channel} is new every {} s only, and the vehicle's time constant is {} s: log it faster",
                        three_figures(interval_s),
                        three_figures(time_constant_s)
                    ),
                );
            }
        }
    }

    /// In a sea a vehicle that is steered against it parts from every free run: there the held-out part must give the same model by itself. A short one
    /// does not show that it was a sea.
    fn steering_prediction(&mut self, steering: &Steering, is_of_a_hull: bool) {
        let prediction = &steering.held_out.prediction;
        let Some(r2) = prediction.r2_heading() else {
            return self.reject(
                ReasonCode::NotValidated,
                "the part that was held out is too short to check the model".into(),
            );
        };
        let long_s = LEAST_HORIZON_S.min(-LONG / steering.refined.model.a22_per_s);
        let is_long = prediction.horizon_s >= long_s;
        let is_confirmed = is_long
            && sea_share(steering) > LEAST_SHARE
            && steering.held_out.is_telling
            && !is_of_a_hull;
        if !steering.predicts() && !is_confirmed {
            self.reject(
                ReasonCode::LowR2,
                format!(
                    "over {} s of what was held out, R^2 of the heading is {}, and the error is {} of that of a vehicle that keeps turning as it does",
                    three_figures(prediction.horizon_s),
                    r2_text(Some(r2)),
                    three_figures(prediction.share_of_persistence())
                ),
            );
        }
    }

    fn steering_notes(&mut self, steering: &Steering) {
        let share = sea_share(steering);
        if is_large_share(share) {
            self.note(
                ReasonCode::Disturbed,
                format!("something other than the rudder turned the vehicle, {} % as strongly as the rudder did: waves, gusts or a current; the intervals allow for it", percent(share)),
            );
        }
        self.play(steering.play_rad);
        let Some(beyond) = &steering.beyond_first_order else {
            return;
        };
        if steering.has_no_gain() {
            self.note(ReasonCode::Unstable, NO_GAIN_HOLDS.into());
        }
        if beyond.structure.has(Parameter::Lag) {
            self.note(
                ReasonCode::ModelOrder,
                format!("the rudder acts {} s later than the log says: a22, b2 and C0 are those behind the delay, which gains must allow for", three_figures(beyond.model.rudder_lag_s)),
            );
        }
        let has_another =
            beyond.structure.has_own_hull() || beyond.structure.has(Parameter::RateLimit);
        if has_another && steering.is_surely_beyond {
            self.note(
                ReasonCode::ModelOrder,
                format!("{} explains the log better than first order: a22, b2 and K are those of course changes, a long turn ends at another rate, which `seatrial turn` takes", beyond.structure.in_words()),
            );
        }
    }

    fn steering_verdict(self, steering: &Steering) -> Verdict {
        let accepted = self.rejections.is_empty();
        let mut reasons = self.rejections;
        if accepted {
            let prediction = &steering.held_out.prediction;
            let used = steering.share;
            let cut = if used < MOST_OF_THE_LOG {
                format!(
                    "; {} % of the log was used, the rest has gaps or the vehicle made no way",
                    percent(used)
                )
            } else {
                String::new()
            };
            let speed = steering.speed_m_s.map_or_else(String::new, |speed_m_s| {
                format!("; a22 and b2 are those at {} m/s", three_figures(speed_m_s))
            });
            reasons.push(Reason::new(
                ReasonCode::Ok,
                format!(
                    "the model of {} minutes of ordinary steering predicts what was held out over {} s: R^2 of heading {}, of yaw rate {}{cut}{speed}",
                    three_figures(steering.minutes),
                    three_figures(prediction.horizon_s),
                    r2_text(prediction.r2_heading()),
                    r2_text(prediction.r2_yaw_rate())
                ),
            ));
        }
        reasons.extend(self.notes);
        Verdict { accepted, reasons }
    }
}

/// The disturbance, a share of the rudder's own effect.
fn sea_share(steering: &Steering) -> f64 {
    disturbance_share(&steering.refined, steering.log.rudder_amplitude_rad)
}
