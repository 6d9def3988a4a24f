//! Are the parameters known well enough, and does the model describe its own record?

use seatrial_core::YawModel;

use super::record::coarse_step_rad;
use super::{HIGHER_ORDER, MOST_TIMES, Share, Weighing, holds_all_the_same, predicts_closely};
use crate::figures::{degrees, percent, r2_text, three_figures};
use crate::identification::{
    HigherOrder, LagEffect, Reason, ReasonCode, Refined, Subject, Validation, WIDEST_A22, WIDEST_B2,
};
use crate::identify::explanation::{Explanation, MUCH_BETTER};
use crate::identify::model_choice::ModelSource;
use crate::identify::model_evidence::{LEAST_R2_IN_A_SEA, ModelEvidence};
use crate::identify::residual_tests::ResidualTests;
use crate::record::rudder_text;

/// Below this R^2 of heading or yaw rate a model does not even describe the record that it was made from.
const LEAST_TRAINING_R2: f64 = 0.60;

/// Difference between two methods, as a fraction of the parameter and beyond both intervals, from
/// which it is noted, and from which the model is refused.
const NOTED_DISAGREEMENT: f64 = 0.25;
const LARGEST_DISAGREEMENT: f64 = 0.75;

/// Effect of a lag that is not in the log, in half widths of the 95 % interval, from which it is noted.
const NOTED_LAG_EFFECT: f64 = 0.5;

/// Share of the parameter under which the effect of a lag is not noted, whatever the interval; and the share by which repeats of a sound
/// manoeuvre differ, up to which it is not noted either, unless it is many half widths: 0.1 s does nothing to a boat of 5 s.
const LEAST_LAG_EFFECT: f64 = 0.02;
const SMALL_LAG_EFFECT: f64 = 0.1;
const MANY_HALF_WIDTHS: f64 = 2.0;

/// Chance explains as much in one sound record of a thousand.
const NOTED_CHANCE: f64 = 0.001;

/// Noise under this share of the heading's range is the arithmetic's own.
const LEAST_NOISE: f64 = 1e-3;

/// What was found where no heading gain suits all vehicles that explain a record.
pub(super) const NO_GAIN_HOLDS: &str = "there is no heading gain: on many of the vehicles that explain this record alike every one overshoots by more than a fifth or never settles, since at small rudder angles, or in a long turn, the vehicle may not stop turning by itself, or the rudder has play; record small rudder angles and long turns, or tune the autopilot with a rate gain";

impl Weighing {
    pub(super) fn refined(&mut self, refined: &Refined, evidence: &ModelEvidence) {
        self.intervals(refined, evidence);
        if evidence.choice.simulated().is_none() {
            // The online estimate takes a lag, and sway, for damping.
            self.agreement(evidence.online, refined, evidence.explanation.delay_s());
        }
        let Some(fit) = evidence.explanation.first_order() else {
            return;
        };
        if let Some(effect) = &fit.lag_effect {
            self.lag(refined, effect, coarse_step_rad(evidence.log));
        }
        if let Some(residual) = &fit.residual {
            self.residual(residual, refined, evidence.log.heading_range_rad);
        }
    }

    /// Notes that no heading gain suits all vehicles that explain the record. Vehicles that predict validation data worse than the first-order
    /// model that was chosen have no say where it predicts these closely.
    fn no_gain(&mut self, evidence: &ModelEvidence) {
        if let Explanation::HigherOrder { share, .. } = *evidence.explanation
            && evidence.has_no_gain()
            && (evidence.choice.simulated().is_some()
                || leaves_much_less(evidence)
                || !holds_all_the_same(evidence, share))
        {
            self.note(ReasonCode::Unstable, NO_GAIN_HOLDS.into());
        }
    }

    fn intervals(&mut self, refined: &Refined, evidence: &ModelEvidence) {
        let b2 = Share::new(refined.model.b2_per_s2, refined.interval_95.b2_per_s2);
        let a22 = Share::new(refined.model.a22_per_s, refined.interval_95.a22_per_s);
        if !(b2.half_width.is_finite() && a22.half_width.is_finite()) {
            return self.reject(
                ReasonCode::NotIdentifiable,
                "the record does not determine the parameters; excite the rudder to both sides"
                    .into(),
            );
        }
        if b2.half_width >= 1.0 {
            return self.holds_0(b2.interval, evidence);
        }
        self.no_gain(evidence);
        if a22.half_width >= 1.0 {
            return self.reject(
                ReasonCode::NotIdentifiable,
                format!(
                    "the 95 % interval of a22, {} to {} 1/s, holds 0: whether the vehicle is course-stable is not known; excite longer or to larger headings",
                    three_figures(a22.interval[0]), three_figures(a22.interval[1])
                ),
            );
        }
        let is_higher_order = matches!(evidence.explanation, Explanation::HigherOrder { .. });
        let allowance = match is_higher_order || predicts_closely(evidence) {
            true => HIGHER_ORDER,
            false => 1.0,
        };
        let (widest_b2, widest_a22) = (allowance * WIDEST_B2, allowance * WIDEST_A22);
        let more = (b2.half_width / widest_b2).max(a22.half_width / widest_a22);
        if more <= 1.0 {
            return;
        }
        let widths = format!(
            "95 % intervals of {} % of b2 (at most {} %) and {} % of a22 (at most {} %) are too wide",
            percent(b2.half_width),
            percent(widest_b2),
            percent(a22.half_width),
            percent(widest_a22),
        );
        let remedy = if is_higher_order {
            "the vehicle is not of first order, so more rudder alone does not narrow them; a longer manoeuvre at one speed and one rudder angle does".into()
        } else if more > MOST_TIMES {
            "a larger and longer manoeuvre is needed, in calmer water".into()
        } else {
            // The interval is inversely proportional to the rudder amplitude at equal noise.
            format!(
                "at this noise {} times the rudder, {} either side, or {} repeats of the manoeuvre would do",
                three_figures(more),
                rudder_text(evidence.log.rudder_unit, more * evidence.log.rudder_amplitude_rad),
                (more * more).ceil()
            )
        };
        self.reject(ReasonCode::UnderExcited, format!("{widths}; {remedy}"));
    }

    /// The interval that reaches the validation data's own estimate must not hold 0 either.
    pub(super) fn reached(&mut self, alone: &Refined, evidence: &ModelEvidence) {
        let Some(reached) = evidence.refined() else {
            return;
        };
        let sides = |refined: &Refined| {
            let intervals = &refined.interval_95;
            [intervals.a22_per_s, intervals.b2_per_s2]
        };
        let names = ["a22", "b2"].into_iter().zip(["1/s", "1/s^2"]);
        for ((name, unit), (alone, reached)) in
            names.zip(sides(alone).into_iter().zip(sides(&reached)))
        {
            if !holds_zero(alone) && holds_zero(reached) {
                self.reject(
                    ReasonCode::NotIdentifiable,
                    format!(
                        "the validation data give another {name} by themselves, and the 95 % interval that reaches both, {} to {} {unit}, holds 0: train and validate at one speed and one rudder angle",
                        three_figures(reached[0]), three_figures(reached[1])
                    ),
                );
            }
        }
    }

    /// `delay_s` is that of the rudder behind its column, which the refined estimate knows and the online estimate does not.
    fn agreement(&mut self, online: YawModel<f64>, refined: &Refined, delay_s: Option<f64>) {
        // A rudder that is late by a share of the time constant makes a22 larger by some twice that share.
        let late_s = delay_s.filter(|delay_s| *delay_s < 0.0).map_or(0.0, f64::abs);
        let of_late = 2.0 * late_s * refined.model.a22_per_s.abs();
        let parameters = [
            ("a22", online.a22_per_s, refined.model.a22_per_s, refined.interval_95.a22_per_s),
            ("b2", online.b2_per_s2, refined.model.b2_per_s2, refined.interval_95.b2_per_s2),
        ];
        for (name, online, model, interval) in parameters {
            let difference = ((online - model) / model).abs();
            let half_width = Share::new(model, interval).half_width;
            let text = || {
                format!(
                    "{name} is {} by the online estimator and {} by the refined one, {} % apart; the vehicle may not be of first order here, or something else turned it",
                    three_figures(online),
                    three_figures(model),
                    percent(difference)
                )
            };
            if difference > LARGEST_DISAGREEMENT.max(2.0 * half_width) {
                self.reject(ReasonCode::Contradicted.of(Subject::Training), text());
            } else if difference - of_late <= NOTED_DISAGREEMENT
                && difference > NOTED_DISAGREEMENT.max(2.0 * half_width)
            {
                self.notes.push(rudder_late(late_s, text()));
            } else if difference > NOTED_DISAGREEMENT.max(2.0 * half_width) {
                self.note(ReasonCode::Contradicted.of(Subject::Training), text());
            }
        }
    }

    /// `coarse_step_rad` is the step of the heading where it is coarse.
    fn lag(&mut self, refined: &Refined, effect: &LagEffect, coarse_step_rad: Option<f64>) {
        let (model, intervals) = (&refined.model, &refined.interval_95);
        let parameters = [
            (model.a22_per_s, effect.a22_per_s, intervals.a22_per_s),
            (model.b2_per_s2, effect.b2_per_s2, intervals.b2_per_s2),
        ];
        let matters = parameters.iter().any(|(model, lagging, interval)| {
            let half_width = 0.5 * (interval[1] - interval[0]);
            let small = (SMALL_LAG_EFFECT * model.abs()).min(MANY_HALF_WIDTHS * half_width);
            let least = small.max(LEAST_LAG_EFFECT * model.abs());
            (lagging - model).abs() > least.max(NOTED_LAG_EFFECT * half_width)
        });
        if matters {
            let [a22, b2] = parameters.map(|(model, lagging, _)| 100.0 * (lagging / model - 1.0));
            let reason = Reason::new(
                ReasonCode::LagUnknown,
                format!(
                    "if the rudder lagged {} s behind what the log says, a22 would be {} 1/s ({a22:+.0} %) and b2 {} 1/s^2 ({b2:+.0} %), for which the intervals do not allow: log the rudder's own angle, or give the servo's lag with --rudder-lag",
                    effect.lag_s,
                    three_figures(effect.a22_per_s),
                    three_figures(effect.b2_per_s2)
                ),
            );
            self.notes.push(match coarse_step_rad {
                Some(step_rad) => Reason {
                    text: format!(
                        "The rudder may follow its command late: a heading in steps of {} deg does not show how late.",
                        degrees(step_rad)
                    ),
                    action: "Log the heading with more digits, or the measured rudder angle and say --rudder-lag 0.".into(),
                    ..reason
                },
                None => reason,
            });
        }
    }

    fn residual(&mut self, tests: &ResidualTests, refined: &Refined, heading_range_rad: f64) {
        let (white, rudder) = (&tests.whiteness, &tests.rudder_correlation);
        let chance = white.p_value.min(rudder.p_value);
        if chance > NOTED_CHANCE || refined.heading_noise_rad < LEAST_NOISE * heading_range_rad {
            return;
        }
        let advice = if rudder.p_value < NOTED_CHANCE {
            "what is left follows the rudder: a slow servo, sway, or a rudder that does not do what the log says; log the rudder's own angle, or give the servo's lag with --rudder-lag"
        } else {
            "what is left has a rhythm of its own: waves, or a heading that was filtered; log the compass unfiltered, in calmer water, and take the intervals for too narrow"
        };
        self.note(
            ReasonCode::ModelOrder.of(Subject::Residual),
            format!(
                "of the prediction errors of the first-order model the whiteness statistic is {:.0} where {:.0} is expected, their correlation with earlier rudder angles {:.0} where {:.0} is; chance gives that in {:.1e} of sound records: {advice}",
                white.statistic,
                white.degrees_of_freedom,
                rudder.statistic,
                rudder.degrees_of_freedom,
                chance
            ),
        );
    }

    pub(super) fn model(&mut self, evidence: &ModelEvidence) {
        let model = evidence.choice.model;
        if !model.theta().iter().all(|p| p.is_finite()) {
            return self
                .reject(ReasonCode::NotIdentifiable, "the estimate did not stay finite".into());
        }
        if model.a22_per_s >= 0.0 {
            self.reject(
                ReasonCode::Unstable,
                format!(
                    "a22 = {} 1/s is not negative: the vehicle does not stop turning by itself, or the record does not show it; gains and turning limits need a stable model",
                    three_figures(model.a22_per_s)
                ),
            );
        }
        if evidence.log.hidden_edges > 0 && evidence.log.rounded_time_s.is_none() {
            self.note(
                ReasonCode::SamplesMissing,
                format!(
                    "the rudder moved far {} times while samples were missing; when, is what the heading makes most likely; log without losses",
                    evidence.log.hidden_edges
                ),
            );
        }
        self.misfit(evidence);
        self.lag_like_the_vehicle(evidence);
        let refined = evidence.refined();
        self.sign(refined.map_or(model.b2_per_s2, |refined| refined.interval_95.b2_per_s2[1]));
        self.training_fit(evidence);
    }

    /// `b2_per_s2` is the upper end of its interval.
    pub(super) fn sign(&mut self, b2_per_s2: f64) {
        if b2_per_s2 < 0.0 {
            self.note(
                ReasonCode::SignReversed.of(Subject::Rudder),
                "b2 is negative: a positive rudder angle turns towards decreasing heading in this log; keep this sign, or negate the rudder channel".into(),
            );
        }
    }

    fn misfit(&mut self, evidence: &ModelEvidence) {
        if let Some(share) = evidence.explanation.structural_misfit()
            && !self.says(ReasonCode::Late.of(Subject::Heading))
            && !holds_all_the_same(evidence, share)
        {
            self.beyond(beyond_first_order(evidence, share), evidence);
        }
        self.play(evidence.explanation.play_rad());
        if let Explanation::Disturbed { share, .. } = *evidence.explanation
            && !holds_all_the_same(evidence, share)
        {
            self.note(
                ReasonCode::Disturbed,
                format!(
                    "something other than the rudder turned the vehicle, {} % as strongly as the rudder did, and not as sway or a slow servo would: waves, gusts or a current; the intervals allow for it, calmer water or more rudder narrows them",
                    percent(share)
                ),
            );
        }
    }

    /// Notes play of the rudder from stop to stop, rad, where a record asks for it.
    pub(super) fn play(&mut self, play_rad: Option<f64>) {
        let Some(play_rad) = play_rad else { return };
        self.note(
            ReasonCode::RudderNotFollowed.of(Subject::Linkage),
            format!(
                "the record is likelier of a rudder with about {:.1} deg of play than of one that goes where the log says: a22 and b2 hold for rudder angles like those of the record, their intervals hold the model behind the play; take the slack out of the linkage, or log the rudder's own angle",
                play_rad.to_degrees()
            ),
        );
    }

    fn training_fit(&mut self, evidence: &ModelEvidence) {
        let fit = &evidence.training_fit;
        let heading = fit.r2_heading_offset_refit;
        let yaw_rate = fit.r2_yaw_rate;
        if evidence.is_in_a_sea() && yaw_rate > Some(LEAST_R2_IN_A_SEA) {
            return;
        }
        // A heading that cannot be simulated is not described; a yaw rate may be unknown.
        if heading.unwrap_or(0.0) < LEAST_TRAINING_R2
            || yaw_rate.is_some_and(|r2| r2 < LEAST_TRAINING_R2)
        {
            self.reject(
                ReasonCode::DoesNotFit,
                format!(
                    "R^2 on the training record itself is {} for heading and {} for yaw rate (at least {LEAST_TRAINING_R2:.2} expected of both): noise, waves, current or an autopilot turned the vehicle as well, or the heading is filtered or late; excite more, in calmer water, and log the heading as it is measured",
                    r2_text(heading), r2_text(yaw_rate)
                ),
            );
        }
    }
}

fn holds_zero([low, high]: [f64; 2]) -> bool {
    low <= 0.0 && high >= 0.0
}

/// What a first-order model does not explain, and of what the model is.
fn beyond_first_order(evidence: &ModelEvidence, share: f64) -> String {
    let found = evidence.higher_order.as_ref();
    format!(
        "the rudder and a first-order model do not explain this log: something else turned the vehicle {} % as strongly as the rudder did ({}); {}",
        percent(share),
        found.map_or_else(
            || "sway or a slow servo".into(),
            |higher| higher_order(higher, evidence.log.is_heading_unchecked())
        ),
        match evidence.choice.source {
            ModelSource::BehindLag(_) =>
                "a22, b2 and C0 are those behind the lag, which gains must allow for as a delay",
            ModelSource::Beyond(_) if evidence.has_no_gain() =>
                "a22, b2 and C0 are those of the first-order vehicle with the same steady turn at the rudder of the record",
            ModelSource::Beyond(_) =>
                "a22, b2 and C0 are those of the first-order vehicle with the same steady turn at the rudder of the record; the heading gain also suits the vehicle itself",
            _ =>
                "the model is the first-order one whose simulation is nearest, and holds for rudder and headings like those of the record",
        }
    )
}

/// Does the model beyond first order leave much less of the heading of validation data than the chosen one?
fn leaves_much_less(evidence: &ModelEvidence) -> bool {
    let beyond = evidence.higher_order.as_ref().and_then(|h| h.validation);
    let left = |validation: Option<Validation>| Some(1.0 - validation?.r2_heading_offset_refit?);
    left(beyond)
        .zip(left(evidence.validation))
        .is_some_and(|(beyond, choice)| beyond < MUCH_BETTER * choice)
}

/// What the higher order is, in words.
fn higher_order(higher: &HigherOrder, is_heading_unchecked: bool) -> String {
    let model = &higher.model;
    let mut text = format!("the record asks for {}", higher.structure.in_words());
    if let Some(heaviest) = higher.hypotheses.first() {
        text += &format!(
            ", {} % of the weight of {} hypotheses by what they predict of data left out",
            percent(heaviest.weight),
            higher.hypotheses.len()
        );
    }
    if let Some([low, high]) = higher.lag_interval_s {
        let (late, action) = match is_heading_unchecked {
            true => (
                "the rudder lags, or the heading is late or smoothed,",
                "log the measured rudder angle, and a gyro's yaw rate, which tells which of the two",
            ),
            false => ("the rudder lags", "log the measured angle rather than the command"),
        };
        text += &format!(
            "; {late} by {} s ({} to {} s): {action}",
            three_figures(model.rudder_lag_s),
            three_figures(low),
            three_figures(high)
        );
    }
    if let Some(rate_rad_s) = model.rate_limit_rad_s {
        text += &format!(
            "; the steering gear moves at most {} deg/s: log the measured angle rather than the order",
            three_figures(rate_rad_s.to_degrees())
        );
    }
    if let Some(validation) = &higher.validation {
        text += &format!(
            "; R^2 of heading on validation data is then {}",
            r2_text(validation.r2_heading)
        );
    }
    text
}

/// Two estimates disagree because the column of the rudder is late, which the model holds.
fn rudder_late(late_s: f64, text: String) -> Reason {
    Reason {
        text: format!(
            "The rudder is logged {} s late: the vehicle turns before it. The model holds that time.",
            three_figures(late_s)
        ),
        action:
            "Log the rudder with the time of its measurement, or take a column that is not late."
                .into(),
        ..Reason::new(ReasonCode::Contradicted.of(Subject::Training), text)
    }
}
