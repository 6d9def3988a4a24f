//! May a model be used? What was measured, what it means and what to do next.

mod compass;
mod contradiction;

use seatrial_core::{GoodnessOfFit, YawModel};

use crate::identification::{HigherOrder, LagEffect, Reason, Refined, Validation, Verdict};
use crate::identify::compass::CompassError;
use crate::identify::second_order::ResidualTests;
use crate::record::RudderUnit;
use contradiction::Limits;

/// Below this R^2 on fresh data the paper repeats the run (section IV-C).
pub const LEAST_VALIDATION_R2: f64 = 0.60;

/// Below this R^2 of heading or yaw rate a model does not even describe the record that it was made from.
const LEAST_TRAINING_R2: f64 = 0.60;

/// Three parameters, two initial conditions and a noise level need some samples each.
const LEAST_SAMPLES: usize = 30;

/// Largest half width of the 95 % interval of a22, as a fraction of it, with which a model is accepted.
pub const WIDEST_A22: f64 = 0.5;
/// The same of b2.
pub const WIDEST_B2: f64 = 0.3;

/// Share of rejected samples from which the record is noted, and from which it is refused.
const NOTED_REJECTED_SHARE: f64 = 0.01;
const LARGEST_REJECTED_SHARE: f64 = 0.25;

/// Steps of the heading over its range from which the record is noted, and from which it is refused.
const NOTED_QUANTISATION: f64 = 0.02;
const COARSEST_QUANTISATION: f64 = 0.2;

/// Change of speed within the training, as a fraction of its mean, from which it is noted: b2 goes with the
/// square of the speed, so this is 20 % of b2.
const NOTED_SPEED_CHANGE: f64 = 0.1;

/// Intervals between samples this many times the usual, one in twenty, are noted.
const NOTED_JITTER: f64 = 1.5;

/// Difference between two methods, as a fraction of the parameter and beyond both intervals, from
/// which it is noted, and from which the model is refused.
const NOTED_DISAGREEMENT: f64 = 0.25;
const LARGEST_DISAGREEMENT: f64 = 0.75;

/// Effect of a lag that nobody told of, in half widths of the 95 % interval, from which it is noted.
const NOTED_LAG_EFFECT: f64 = 0.5;
/// And the share of the parameter under which it is not, whatever the interval.
const LEAST_LAG_EFFECT: f64 = 0.02;

/// One hand of the rudder this share short of the other is noted.
const NOTED_SHORT_HAND: f64 = 0.25;

/// Chance explains as much in one sound record of a thousand.
const NOTED_CHANCE: f64 = 0.001;
/// Noise under this share of the heading's range is the arithmetic's own.
const LEAST_NOISE: f64 = 1e-3;

/// Fresh rudder angles beyond the trained ones by this factor are an extrapolation.
const NOTED_EXTRAPOLATION: f64 = 1.2;

/// A rudder that moves less than this, rad (0.1 deg), was not moved; a heading likewise.
const LEAST_MOVEMENT_RAD: f64 = 0.0017;

/// What was measured of a training record and its model.
#[derive(Clone, Copy, Debug)]
pub struct Evidence<'a> {
    /// Samples that reached the estimator.
    pub samples_used: usize,
    /// Samples that did not.
    pub samples_rejected: u32,
    /// Half of the rudder's range in training, rad.
    pub rudder_amplitude_rad: f64,
    /// How far the rudder went to either hand from rest in training, rad, where it was laid to both.
    pub rudder_hands_rad: Option<[f64; 2]>,
    /// In what these are.
    pub rudder_unit: RudderUnit,
    /// The heading's range in training, rad.
    pub heading_range_rad: f64,
    /// The step in which the heading is given, rad, where it is coarser than its noise.
    pub heading_step_rad: Option<f64>,
    /// Mean speed of the first and of the last quarter of the training, m/s.
    pub surge_speed_m_s: Option<[f64; 2]>,
    /// The usual interval between samples and the one that one in twenty exceeds, s.
    pub interval_s: Option<[f64; 2]>,
    /// The estimate made sample by sample.
    pub online: YawModel<f64>,
    /// Must there be an estimate from the whole record with its interval?
    pub needs_interval: bool,
    /// How the compass parts from the gyro.
    pub compass: CompassError,
    /// The estimate made from the whole record.
    pub refined: Option<&'a Refined>,
    /// The share of the rudder's effect that a disturbance would have to have, where the vehicle is not of first order.
    pub mismatch: Option<f64>,
    /// The share of the rudder's effect that a disturbance has, where it is large.
    pub disturbed: Option<f64>,
    /// The model beyond the first order that explains it.
    pub higher_order: Option<&'a HigherOrder>,
    /// What a lag of the rudder that the log does not tell would do.
    pub lag_effect: Option<&'a LagEffect>,
    /// What a first-order model with the likeliest disturbance leaves unexplained.
    pub residual: Option<ResidualTests>,
    /// Times that the rudder moved far while samples were lost.
    pub hidden_edges: usize,
    /// R^2 on the training record itself.
    pub training_fit: GoodnessOfFit<f64>,
    /// R^2 on fresh data.
    pub validation: Option<Validation>,
    /// The estimate made from the fresh data alone, where they are not those of the training and give one.
    pub fresh: Option<&'a Refined>,
    /// Half of the rudder's range in validation, rad.
    pub validation_rudder_amplitude_rad: Option<f64>,
}

/// A record that cannot give any model at all: the reason, or `None` where one may be tried.
pub fn refuse_record(
    samples: usize,
    rudder_amplitude_rad: f64,
    rudder_unit: RudderUnit,
    heading_range_rad: f64,
) -> Option<Reason> {
    if samples < LEAST_SAMPLES {
        return Some(reason(
            "too_few_samples",
            format!(
                "{samples} usable samples in the training window, at least {LEAST_SAMPLES} are needed; widen the window or log faster"
            ),
        ));
    }
    if rudder_amplitude_rad < LEAST_MOVEMENT_RAD {
        return Some(rudder_constant(rudder_amplitude_rad, rudder_unit));
    }
    if heading_range_rad < LEAST_MOVEMENT_RAD {
        return Some(reason(
            "heading_constant",
            format!(
                "the heading stays within {} deg while the rudder moves {} either side; check that the heading channel is alive",
                degrees(heading_range_rad),
                rudder(rudder_amplitude_rad, rudder_unit)
            ),
        ));
    }
    None
}

/// The reason to refuse a record in which the rudder stays where it is.
pub fn rudder_constant(rudder_amplitude_rad: f64, rudder_unit: RudderUnit) -> Reason {
    reason(
        "rudder_constant",
        format!(
            "the rudder stays within {}: nothing excites the vehicle; command a doublet, or choose a window with one",
            rudder(rudder_amplitude_rad, rudder_unit)
        ),
    )
}

/// Weighs the evidence.
pub fn judge(evidence: &Evidence) -> Verdict {
    let mut weighing = Weighing::default();
    weighing.record(evidence);
    match evidence.refined {
        Some(refined) => {
            weighing.intervals(refined, evidence);
            weighing.agreement(evidence.online, refined);
            if let Some(effect) = evidence.lag_effect {
                weighing.lag(refined, effect);
            }
            if let (Some(residual), None) = (&evidence.residual, evidence.mismatch) {
                weighing.residual(residual, refined, evidence.heading_range_rad);
            }
        }
        None if evidence.needs_interval => weighing.reject(
            "not_identifiable",
            "the whole record gives no model with an interval: the heading does not follow the rudder as one model; repeat the manoeuvre".into(),
        ),
        None => {}
    }
    weighing.model(evidence);
    weighing.fresh_data(evidence.validation);
    if let (Some(refined), Some(fresh)) = (evidence.refined, evidence.fresh) {
        let covariance = Some(&refined.covariance);
        let saturated = saturated(refined, fresh, evidence);
        let limits = match saturated {
            Some(_) => &contradiction::STOPPED,
            None => &contradiction::TRAINED,
        };
        weighing.contradiction(&refined.model, covariance, fresh, limits, saturated);
    }
    weighing.extrapolation(evidence);
    weighing.verdict(evidence.validation)
}

/// Weighs a given model by fresh data alone, and by the model that they give by themselves.
pub fn judge_fresh_data(
    model: &YawModel<f64>,
    validation: Validation,
    fresh: Option<&Refined>,
) -> Verdict {
    let mut weighing = Weighing::default();
    weighing.fresh_data(Some(validation));
    if let Some(fresh) = fresh {
        weighing.contradiction(model, None, fresh, &contradiction::GIVEN, None);
    }
    weighing.verdict(Some(validation))
}

/// A verdict of one rejecting reason.
pub fn refused(reason: Reason) -> Verdict {
    Verdict {
        accepted: false,
        reasons: vec![reason],
    }
}

/// The verdict on a run that the trial itself did not take: live, its R^2 on fresh data was under what the plan
/// asks for.
pub fn not_taken(
    judged: Verdict,
    live: &GoodnessOfFit<f64>,
    accept_from_r2: f64,
    is_repeated: bool,
) -> Verdict {
    let then = if is_repeated {
        "the run was repeated"
    } else {
        "no tries were left"
    };
    let low_r2 = reason(
        "low_r2",
        format!(
            "with the live model R^2 on fresh data was {} for heading, {} with the offset estimated again, {} for yaw rate; the plan accepts from {accept_from_r2:.2}: {then}",
            r2_text(live.r2_heading),
            r2_text(live.r2_heading_offset_refit),
            r2_text(live.r2_yaw_rate)
        ),
    );
    let others = judged.reasons.into_iter().filter(|r| r.code != "ok");
    Verdict {
        accepted: false,
        reasons: std::iter::once(low_r2).chain(others).collect(),
    }
}

/// Where a larger angle in training than in the fresh data turned the vehicle less per degree, at which angle the rudder
/// seems to stop, in words.
fn saturated(trained: &Refined, fresh: &Refined, evidence: &Evidence) -> Option<String> {
    let fresh_rad = evidence.validation_rudder_amplitude_rad?;
    let share = trained.model.b2_per_s2 / fresh.model.b2_per_s2;
    let is_larger = evidence.rudder_amplitude_rad > NOTED_EXTRAPOLATION * fresh_rad;
    (is_larger && (0.0..1.0).contains(&share)).then(|| {
        format!(
            "in training, with {} either side, the rudder did less per degree than with {}, as if it stopped at {}; look at its own angle, and train with less than that",
            rudder(evidence.rudder_amplitude_rad, evidence.rudder_unit),
            rudder(fresh_rad, evidence.rudder_unit),
            rudder(share * evidence.rudder_amplitude_rad, evidence.rudder_unit)
        )
    })
}

/// What the higher order is, in words.
fn beyond_first_order(higher: &HigherOrder) -> String {
    let estimate = &higher.estimate;
    let mut text = estimate.order.to_string();
    if let Some([low, high]) = estimate.interval_95.rudder_lag_s {
        text += &format!(
            "; the rudder lags by {} s ({} to {} s): log the measured angle rather than the command",
            three_figures(estimate.model.rudder_lag_s),
            three_figures(low),
            three_figures(high)
        );
    }
    if let Some(validation) = &higher.validation {
        text += &format!(
            "; R^2 of heading on fresh data is then {}",
            r2_text(validation.r2_heading)
        );
    }
    text
}

#[derive(Default)]
struct Weighing {
    rejections: Vec<Reason>,
    notes: Vec<Reason>,
}

impl Weighing {
    fn reject(&mut self, code: &str, text: String) {
        self.rejections.push(reason(code, text));
    }

    fn note(&mut self, code: &str, text: String) {
        self.notes.push(reason(code, text));
    }

    fn record(&mut self, evidence: &Evidence) {
        let read = evidence.samples_used + evidence.samples_rejected as usize;
        let share = f64::from(evidence.samples_rejected) / read.max(1) as f64;
        let text = format!(
            "{} of {read} samples were rejected; check the log's clock and its heading channel",
            evidence.samples_rejected
        );
        if share > LARGEST_REJECTED_SHARE {
            self.reject("rejected_samples", text);
        } else if share > NOTED_REJECTED_SHARE {
            self.note("rejected_samples", text);
        }

        if let Some([first, last]) = evidence.surge_speed_m_s {
            let change = (last - first).abs() / (0.5 * (first + last));
            if change > NOTED_SPEED_CHANGE {
                self.note(
                    "speed_drifted",
                    format!(
                        "the speed went from {} to {} m/s within the training, and b2 goes with its square: the model is that of a mean speed; settle longer, or use less rudder",
                        three_figures(first),
                        three_figures(last)
                    ),
                );
            }
        }
        if let Some([usual, long]) = evidence.interval_s
            && long > NOTED_JITTER * usual
        {
            self.note(
                "clock_jitter",
                format!(
                    "one in twenty intervals between samples is longer than {} s, the usual one is {} s: samples were lost or the clock jitters; log without losses, with the time of the measurement",
                    three_figures(long),
                    three_figures(usual)
                ),
            );
        }

        if let Some(hands @ [positive, negative]) = evidence.rudder_hands_rad {
            let (less, more) = (positive.min(negative), positive.max(negative));
            if less < (1.0 - NOTED_SHORT_HAND) * more {
                let [positive, negative] = hands.map(|hand| rudder(hand, evidence.rudder_unit));
                self.note(
                    "rudder_saturated",
                    format!(
                        "from rest the rudder went {positive} to the positive hand and {negative} to the other: if it was asked for the same, it stops at the lesser; train with less than that, or trim the rudder"
                    ),
                );
            }
        }

        self.compass(evidence);

        let Some(step) = evidence.heading_step_rad else {
            return;
        };
        let text = format!(
            "the heading comes in steps of {} deg over a range of {} deg; log it finer or turn further",
            degrees(step),
            degrees(evidence.heading_range_rad)
        );
        if step > COARSEST_QUANTISATION * evidence.heading_range_rad {
            self.reject("quantised", text);
        } else if step > NOTED_QUANTISATION * evidence.heading_range_rad {
            self.note("quantised", text);
        }
    }

    fn intervals(&mut self, refined: &Refined, evidence: &Evidence) {
        let b2 = Share::new(refined.model.b2_per_s2, refined.interval_95.b2_per_s2);
        let a22 = Share::new(refined.model.a22_per_s, refined.interval_95.a22_per_s);
        if !(b2.half_width.is_finite() && a22.half_width.is_finite()) {
            return self.reject(
                "not_identifiable",
                "the record does not determine the parameters; excite the rudder to both hands"
                    .into(),
            );
        }
        // Of a vehicle that is not of first order the interval tells how far the methods are apart; fresh data
        // tell whether the model holds all the same, unless its yaw rate is worse than none: that of a jammed rudder.
        let fresh_data_decide = evidence.mismatch.is_some()
            && evidence
                .validation
                .is_some_and(|fresh| fresh.r2_yaw_rate.is_none_or(|r2| r2 >= 0.0));
        if b2.half_width >= 1.0 && !fresh_data_decide {
            return self.reject(
                "not_identifiable",
                format!(
                    "the 95 % interval of b2, {} to {} 1/s^2, holds 0: the heading does not follow the rudder measurably; check that the two channels belong together, then excite with more rudder",
                    three_figures(b2.interval[0]), three_figures(b2.interval[1])
                ),
            );
        }
        if a22.half_width >= 1.0 && !fresh_data_decide {
            return self.reject(
                "not_identifiable",
                format!(
                    "the 95 % interval of a22, {} to {} 1/s, holds 0: whether the vehicle is course-stable is not known; excite longer or to larger headings",
                    three_figures(a22.interval[0]), three_figures(a22.interval[1])
                ),
            );
        }
        if evidence.mismatch.is_some() {
            // More rudder does not make the vehicle a first-order one.
            return;
        }
        // The interval is inversely proportional to the rudder amplitude at equal noise.
        let more = (b2.half_width / WIDEST_B2).max(a22.half_width / WIDEST_A22);
        if more > 1.0 {
            self.reject(
                "under_excited",
                format!(
                    "95 % intervals of {} % of b2 (at most {} %) and {} % of a22 (at most {} %) are too wide; at this noise {} times the rudder, {} either side, or {} repeats of the manoeuvre would do",
                    percent(b2.half_width), percent(WIDEST_B2),
                    percent(a22.half_width), percent(WIDEST_A22),
                    three_figures(more), rudder(more * evidence.rudder_amplitude_rad, evidence.rudder_unit), (more * more).ceil()
                ),
            );
        }
    }

    fn agreement(&mut self, online: YawModel<f64>, refined: &Refined) {
        let parameters = [
            (
                "a22",
                online.a22_per_s,
                refined.model.a22_per_s,
                refined.interval_95.a22_per_s,
            ),
            (
                "b2",
                online.b2_per_s2,
                refined.model.b2_per_s2,
                refined.interval_95.b2_per_s2,
            ),
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
                self.reject("disagreement", text());
            } else if difference > NOTED_DISAGREEMENT.max(2.0 * half_width) {
                self.note("disagreement", text());
            }
        }
    }

    fn lag(&mut self, refined: &Refined, effect: &LagEffect) {
        let (model, intervals) = (&refined.model, &refined.interval_95);
        let parameters = [
            (model.a22_per_s, effect.a22_per_s, intervals.a22_per_s),
            (model.b2_per_s2, effect.b2_per_s2, intervals.b2_per_s2),
        ];
        let matters = parameters.iter().any(|(model, lagging, interval)| {
            let half_width = 0.5 * (interval[1] - interval[0]);
            (lagging - model).abs()
                > (NOTED_LAG_EFFECT * half_width).max(LEAST_LAG_EFFECT * model.abs())
        });
        if matters {
            let [a22, b2] = parameters.map(|(model, lagging, _)| 100.0 * (lagging / model - 1.0));
            self.note(
                "lag_unknown",
                format!(
                    "if the rudder lagged {} s behind what the log says, a22 would be {} 1/s ({a22:+.0} %) and b2 {} 1/s^2 ({b2:+.0} %), for which the intervals do not allow: log the rudder's own angle, or give the servo's lag with --rudder-lag",
                    effect.lag_s,
                    three_figures(effect.a22_per_s),
                    three_figures(effect.b2_per_s2)
                ),
            );
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
            "residual_not_white",
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

    fn model(&mut self, evidence: &Evidence) {
        let model = evidence.refined.map_or(evidence.online, |r| r.model);
        if !model.theta().iter().all(|p| p.is_finite()) {
            return self.reject(
                "not_identifiable",
                "the estimate did not stay finite".into(),
            );
        }
        if model.a22_per_s >= 0.0 {
            self.reject(
                "unstable",
                format!(
                    "a22 = {} 1/s is not negative: the vehicle does not stop turning by itself, or the record does not show it; gains and turning limits need a stable model",
                    three_figures(model.a22_per_s)
                ),
            );
        }
        if evidence.hidden_edges > 0 {
            self.note(
                "samples_missing",
                format!(
                    "the rudder moved far {} times while samples were missing; when, is what the heading makes most likely; log without losses",
                    evidence.hidden_edges
                ),
            );
        }
        if let Some(share) = evidence.mismatch {
            self.note(
                "model_order",
                format!(
                    "what a first-order model does not explain is {} % of the rudder's own effect: {}; {}",
                    percent(share),
                    evidence.higher_order.map_or_else(|| "sway or a slow servo".into(), beyond_first_order),
                    if evidence.refined.is_some_and(|r| r.method == "rudder_lag") {
                        "a22, b2 and C0 are those behind the lag, which gains must allow for as a delay"
                    } else {
                        "the online estimate is used and its interval widened"
                    }
                ),
            );
        }
        if let Some(share) = evidence.disturbed {
            self.note(
                "disturbed",
                format!(
                    "something other than the rudder turned the vehicle with {} % of the rudder's own effect, and not as sway or a slow servo would: waves, gusts or a current; the intervals allow for it, calmer water or more rudder narrows them",
                    percent(share)
                ),
            );
        }
        if model.b2_per_s2 < 0.0 {
            self.note(
                "sign_reversed",
                "b2 is negative: a positive rudder angle turns towards decreasing heading in this log; keep this sign, or negate the rudder channel".into(),
            );
        }
        let heading = evidence.training_fit.r2_heading_offset_refit;
        let yaw_rate = evidence.training_fit.r2_yaw_rate;
        // A heading that cannot be simulated is not described; a yaw rate may be unknown.
        if heading.unwrap_or(0.0) < LEAST_TRAINING_R2
            || yaw_rate.is_some_and(|r2| r2 < LEAST_TRAINING_R2)
        {
            self.reject(
                "does_not_fit",
                format!(
                    "R^2 on the training record itself is {} for heading and {} for yaw rate (at least {LEAST_TRAINING_R2:.2} expected of both): noise, waves, current or an autopilot rather than the rudder turned the vehicle; excite more, in calmer water",
                    r2_text(heading), r2_text(yaw_rate)
                ),
            );
        }
    }

    fn fresh_data(&mut self, validation: Option<Validation>) {
        let Some(validation) = validation else {
            return self.note(
                "not_validated",
                "no fresh data were given; validate with --validate-from and --validate-to, or --validate-on another log".into(),
            );
        };
        let good = |r2: Option<f64>| r2.is_some_and(|r2| r2 >= LEAST_VALIDATION_R2);
        if good(validation.r2_heading) {
        } else if good(validation.r2_heading_offset_refit) && good(validation.r2_yaw_rate) {
            self.note(
                "offset_drifted",
                format!(
                    "R^2 of heading on fresh data is {} with the trained offset and {} with the offset estimated again: the model steers right, but wind, current or trim changed",
                    r2_text(validation.r2_heading), r2_text(validation.r2_heading_offset_refit)
                ),
            );
        } else {
            self.reject(
                "low_r2",
                format!(
                    "R^2 on fresh data is {} for heading, {} with the offset estimated again, {} for yaw rate; at least {LEAST_VALIDATION_R2} is needed: repeat the run",
                    r2_text(validation.r2_heading), r2_text(validation.r2_heading_offset_refit), r2_text(validation.r2_yaw_rate)
                ),
            );
        }
    }

    fn contradiction(
        &mut self,
        model: &YawModel<f64>,
        covariance: Option<&[[f64; 3]; 3]>,
        fresh: &Refined,
        limits: &Limits,
        saturated: Option<String>,
    ) {
        let Some(found) = contradiction::contradiction(model, covariance, fresh, limits) else {
            if let Some(times) = contradiction::weakness(model, covariance, fresh, limits) {
                self.note(
                    "weakly_validated",
                    format!(
                        "the fresh data by themselves are too uncertain to tell a model that is 30 % wrong, as one trained with a rudder that stops: validate with {} times the rudder, or with {} manoeuvres, or in calmer water",
                        three_figures(times),
                        (times * times).ceil()
                    ),
                );
            }
            return;
        };
        match saturated {
            Some(saturated) => self.reject(
                "rudder_saturated",
                format!("the fresh data by themselves give {found}: {saturated}"),
            ),
            None => self.reject(
                "contradicted",
                format!(
                    "the fresh data by themselves give {found}: a rudder that saturates or jammed, another speed, or a vehicle that changed; look at the rudder's own angle, then train again"
                ),
            ),
        }
    }

    fn extrapolation(&mut self, evidence: &Evidence) {
        if let Some(fresh) = evidence
            .validation_rudder_amplitude_rad
            .filter(|fresh| *fresh > NOTED_EXTRAPOLATION * evidence.rudder_amplitude_rad)
        {
            self.note(
                "extrapolating",
                format!(
                    "the fresh data use {} of rudder either side, training only {}",
                    rudder(fresh, evidence.rudder_unit),
                    rudder(evidence.rudder_amplitude_rad, evidence.rudder_unit)
                ),
            );
        }
    }

    fn verdict(self, validation: Option<Validation>) -> Verdict {
        let accepted = self.rejections.is_empty();
        let mut reasons = self.rejections;
        if accepted {
            reasons.push(reason(
                "ok",
                match validation {
                    Some(v) => {
                        let trained = v.r2_heading >= Some(LEAST_VALIDATION_R2);
                        let (heading, offset) = if trained {
                            (v.r2_heading, "")
                        } else {
                            (v.r2_heading_offset_refit, " with the offset estimated again")
                        };
                        format!(
                            "the model holds on fresh data: R^2 of heading{offset} {}, of yaw rate {}",
                            r2_text(heading),
                            r2_text(v.r2_yaw_rate)
                        )
                    }
                    None => "the model describes its training record".into(),
                },
            ));
        }
        reasons.extend(self.notes);
        Verdict { accepted, reasons }
    }
}

/// A 95 % interval as a share of its parameter.
struct Share {
    interval: [f64; 2],
    half_width: f64,
}

impl Share {
    fn new(value: f64, interval: [f64; 2]) -> Self {
        Self {
            interval,
            half_width: 0.5 * (interval[1] - interval[0]) / value.abs(),
        }
    }
}

fn reason(code: &str, text: String) -> Reason {
    Reason {
        code: code.into(),
        text,
    }
}

fn r2_text(r2: Option<f64>) -> String {
    r2.map_or_else(|| "not known".into(), |r2| format!("{r2:.2}"))
}

fn degrees(angle_rad: f64) -> String {
    three_figures(angle_rad.to_degrees())
}

/// A rudder as people read it.
fn rudder(amplitude: f64, unit: RudderUnit) -> String {
    let (scale, name) = unit.for_people();
    format!("{} {name}", three_figures(scale * amplitude))
}

fn percent(share: f64) -> String {
    format!("{:.0}", 100.0 * share)
}

/// A number to three significant figures, as people read it.
pub fn three_figures(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let digits = 2 - value.abs().log10().floor().clamp(-6.0, 2.0) as i32;
    format!("{value:.*}", digits.max(0) as usize)
}

#[cfg(test)]
mod tests;
