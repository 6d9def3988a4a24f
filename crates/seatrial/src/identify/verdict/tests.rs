use seatrial_core::{GoodnessOfFit, YawModel};

use super::*;
use crate::identification::{EstimateMethod, Intervals, LagEffect, RejectedSamples};
use crate::identify::compass::{CompassError, Jump};
use crate::identify::explanation::{Explanation, FirstOrderFit};
use crate::identify::heading_gain::Vehicles;
use crate::identify::log_statistics::LogStatistics;
use crate::identify::mishap::{Jam, Mishaps};
use crate::identify::model_choice::{ModelChoice, ModelSource};
use crate::identify::model_evidence::Independent;
use crate::identify::pace::Pace;
use crate::identify::residual_tests::{ResidualTest, ResidualTests};
use crate::record::{RudderUnit, Window};

const JUMP: Jump = Jump { size_rad: 0.06, time_s: 21.5 };

fn refined(half_width: f64) -> Refined {
    refined_at([-1.07, 1.08, 0.012], half_width)
}

pub(super) fn refined_at(theta: [f64; 3], half_width: f64) -> Refined {
    let model = YawModel::from_theta(theta);
    let around = |value: f64| [value - half_width * value.abs(), value + half_width * value.abs()];
    Refined {
        method: EstimateMethod::AveragedRestrictedLikelihood,
        model,
        delta0_rad: model.delta0_rad(),
        interval_95: Intervals {
            a22_per_s: around(model.a22_per_s),
            b2_per_s2: around(model.b2_per_s2),
            c0_rad_per_s2: around(model.c0_rad_per_s2),
            delta0_rad: None,
        },
        covariance: core::array::from_fn(|i| {
            let deviation = half_width * theta[i] / 1.96;
            core::array::from_fn(|j| if i == j { deviation * deviation } else { 0.0 })
        }),
        heading_noise_rad: 0.0,
        disturbance_rad_s2: 0.0,
    }
}

fn validation(heading: f64, refit: f64, rate: f64) -> Validation {
    Validation {
        window: Window::ALL,
        r2_heading: Some(heading),
        r2_heading_offset_refit: Some(refit),
        r2_yaw_rate: Some(rate),
        samples: 330,
        horizon_s: None,
    }
}

fn training_fit(heading: f64, yaw_rate: f64) -> GoodnessOfFit<f64> {
    GoodnessOfFit {
        r2_heading_offset_refit: Some(heading),
        r2_yaw_rate: Some(yaw_rate),
        ..GoodnessOfFit::default()
    }
}

/// The links of the chain before the verdict.
#[derive(Clone)]
struct Chain {
    log: LogStatistics,
    online: YawModel<f64>,
    explanation: Explanation,
    choice: ModelChoice,
    training_fit: GoodnessOfFit<f64>,
    validation: Option<Validation>,
    validation_rudder_amplitude_rad: Option<f64>,
    independent: Option<Independent>,
    mishaps: Mishaps,
}

impl Chain {
    fn of(refined: Refined) -> Self {
        Self {
            log: LogStatistics {
                samples_used: 330,
                rejected: RejectedSamples::default(),
                rudder_amplitude_rad: 0.26,
                rudder_sides_rad: Some([0.27, 0.25]),
                rudder_unit: RudderUnit::Rad,
                heading_range_rad: 0.5,
                heading_step_rad: None,
                surge_speed_m_s: None,
                interval_s: None,
                rounded_time_s: None,
                is_turning_circle: false,
                pace: None,
                compass: CompassError::default(),
                jump_beside: None,
                hidden_edges: 0,
                unit_doubts: Vec::new(),
                times_are_shared: false,
                unchecked: Vec::new(),
            },
            online: refined.model,
            explanation: Explanation::FirstOrder { fit: fit(&refined, None) },
            choice: ModelChoice {
                model: refined.model,
                source: ModelSource::Refined,
                refined: Some(refined),
                joined: None,
            },
            training_fit: training_fit(0.95, 0.95),
            validation: Some(validation(0.9, 0.95, 0.96)),
            validation_rudder_amplitude_rad: Some(0.15),
            independent: None,
            mishaps: Mishaps::default(),
        }
    }

    /// A good chain with one thing changed.
    fn with(change: impl FnOnce(&mut Self)) -> Self {
        let mut chain = Self::of(refined(0.05));
        change(&mut chain);
        chain
    }

    /// A vehicle that is not of first order, by this share of the rudder's effect.
    fn with_misfit(mut self, share: f64) -> Self {
        self.explanation = Explanation::HigherOrder {
            refined: self.choice.refined.clone().unwrap(),
            share,
            beyond: None,
            nearest: true,
            alone: None,
            vehicles: None,
            play_rad: None,
        };
        self
    }

    /// Validation data that by themselves give this.
    fn with_independent(mut self, estimate: &Refined, largest_jump: Option<Jump>) -> Self {
        self.independent = Some(Independent {
            length: 1.0,
            rudder_variance_ratio: 1.0,
            surge_speeds_m_s: None,
            largest_jump,
            estimate: Some(estimate.clone()),
        });
        self
    }

    fn judge(&self) -> Verdict {
        judge(&ModelEvidence {
            log: &self.log,
            online: self.online,
            needs_interval: true,
            explanation: &self.explanation,
            doubts: Vec::new(),
            choice: &self.choice,
            higher_order: None,
            training_fit: self.training_fit,
            validation: self.validation,
            validation_rudder_amplitude_rad: self.validation_rudder_amplitude_rad,
            independent: self.independent.clone(),
            mishaps: self.mishaps,
        })
    }
}

fn fit(refined: &Refined, residual: Option<ResidualTests>) -> FirstOrderFit {
    FirstOrderFit {
        refined: refined.clone(),
        residual,
        lag_effect: None,
        delay_s: 0.0,
        covariance_given_delay: refined.covariance,
        play_rad: None,
    }
}

fn codes(verdict: &Verdict) -> Vec<String> {
    verdict.reasons.iter().map(|r| r.kind().to_string()).collect()
}

#[test]
fn exact_good_run_is_accepted() {
    let verdict = Chain::of(refined(0.05)).judge();
    assert!(verdict.accepted);
    assert_eq!(codes(&verdict), ["ok"]);
}

/// Half widths of 5 % and of 1 %: a lag that moves a22 by 4 % is small, unless the interval claims to know it far better.
#[test]
fn exact_a_lag_is_noted_for_what_it_does_to_the_model() {
    let noted = |half_width: f64, effect: f64| {
        let refined = refined(half_width);
        let model = refined.model;
        let mut chain = Chain::of(refined.clone());
        chain.explanation = Explanation::FirstOrder {
            fit: FirstOrderFit {
                lag_effect: Some(LagEffect {
                    lag_s: 0.1,
                    a22_per_s: (1.0 + effect) * model.a22_per_s,
                    b2_per_s2: model.b2_per_s2,
                }),
                ..fit(&refined, None)
            },
        };
        chain.judge().has(&ReasonCode::LagUnknown)
    };
    assert!(!noted(0.05, 0.04) && noted(0.05, 0.12));
    assert!(!noted(0.01, 0.015) && noted(0.01, 0.04));
    assert!(!noted(0.3, 0.12) && noted(0.3, 0.2));
}

#[test]
fn exact_each_defect_is_refused_under_its_own_code() {
    let compass = |error: CompassError| Chain::with(|c| c.log.compass = error);
    let none = CompassError::default();
    let cases = [
        ("under_excited", Chain::of(refined(0.7))),
        ("not_identifiable", Chain::of(refined(1.5))),
        ("unstable", Chain::of(refined_at([0.1, 1.08, 0.012], 0.05))),
        ("low_r2", Chain::with(|c| c.validation = Some(validation(0.3, 0.4, 0.9)))),
        ("does_not_fit", Chain::with(|c| c.training_fit = training_fit(0.95, 0.1))),
        ("does_not_fit", Chain::with(|c| c.training_fit = GoodnessOfFit::default())),
        ("damaged of samples", Chain::with(|c| c.log.rejected.spike = 200)),
        (
            "not_identifiable",
            Chain::with(|c| {
                c.explanation = Explanation::Unrefined;
                c.choice.source = ModelSource::Online;
                c.choice.refined = None;
            }),
        ),
        ("compass_error", compass(CompassError { largest_jump: Some(JUMP), ..none })),
        (
            "yaw_rate_contradicts of heading",
            compass(CompassError { scale_error: Some(-0.06), ..none }),
        ),
        ("late of heading", compass(CompassError { late_s: Some(0.1), ..none })),
        ("quantised", Chain::with(|c| c.log.heading_step_rad = Some(0.2))),
        (
            "contradicted of training",
            Chain::with(|c| c.online = YawModel::from_theta([-0.1, 1.08, 0.012])),
        ),
    ];
    for (code, chain) in cases {
        let verdict = chain.judge();
        assert!(!verdict.accepted, "{code}");
        assert_eq!(codes(&verdict)[0], code);
    }
}

/// What a late compass makes of a vehicle is no other kind of vehicle.
#[test]
fn exact_a_late_compass_explains_the_misfit() {
    let misfit = Chain::of(refined(0.05)).with_misfit(0.5);
    assert!(misfit.judge().has(&ReasonCode::ModelOrder));
    let mut late = misfit;
    late.log.compass.late_s = Some(0.1);
    let verdict = late.judge();
    assert!(verdict.has(ReasonCode::Late.of(Subject::Heading)));
    assert!(!verdict.has(&ReasonCode::ModelOrder));
}

/// What a model misses limits its use where validation data show it, or where it is much.
#[test]
fn exact_a_misfit_that_validation_data_do_not_show_is_not_noted() {
    let noted = |share, heading, rate| {
        let mut chain = Chain::of(refined(0.05)).with_misfit(share);
        chain.validation = Some(validation(0.7, heading, rate));
        chain.judge().has(&ReasonCode::ModelOrder)
    };
    assert!(!noted(0.1, 0.95, 0.96));
    assert!(noted(0.1, 0.85, 0.96) && noted(0.1, 0.95, 0.85) && noted(0.3, 0.95, 0.96));
}

/// Wide intervals are no refusal where validation data show that the model holds.
#[test]
fn exact_wide_intervals_are_taken_where_validation_data_are_predicted_closely() {
    let accepted = |heading| {
        let mut chain = Chain::of(refined(0.55));
        chain.validation = Some(validation(0.7, heading, 0.96));
        chain.judge().accepted
    };
    assert!(accepted(0.95) && !accepted(0.85));
}

/// Vehicles that predict validation data worse than the chosen model have no say on its gain.
#[test]
fn exact_no_gain_is_noted_where_the_vehicles_without_one_predict_as_well() {
    let noted = |heading| {
        let mut chain = Chain::of(refined(0.05)).with_misfit(0.1);
        chain.validation = Some(validation(0.7, heading, 0.96));
        if let Explanation::HigherOrder { vehicles, .. } = &mut chain.explanation {
            *vehicles = Some(Vehicles::new(Vec::new(), 0.05, 0.26));
        }
        chain.judge().has(&ReasonCode::Unstable)
    };
    assert!(!noted(0.95) && noted(0.85));
}

#[test]
fn exact_notes_do_not_refuse() {
    let mut noted = Chain::of(refined_at([-1.07, -1.08, 0.012], 0.05));
    noted.validation = Some(validation(-2.0, 0.9, 0.97));
    noted.validation_rudder_amplitude_rad = Some(0.5);
    let verdict = noted.judge();
    assert!(verdict.accepted);
    assert_eq!(
        codes(&verdict),
        ["ok", "sign_reversed of rudder", "drifted of offset", "extrapolating"]
    );
    noted.validation = None;
    assert!(noted.judge().has(&ReasonCode::NotValidated));
}

#[test]
fn exact_records_without_a_model_are_refused() {
    let code = |reason: Option<Reason>| reason.map(|r| r.kind().to_string());
    assert_eq!(
        code(refuse_record(1, 0.2, RudderUnit::Rad, 0.5, false)).as_deref(),
        Some("too_few_samples")
    );
    assert_eq!(
        code(refuse_record(330, 0.0, RudderUnit::Rad, 0.5, false)).as_deref(),
        Some("constant of rudder")
    );
    assert_eq!(
        code(refuse_record(330, 0.2, RudderUnit::Rad, 0.0, false)).as_deref(),
        Some("constant of heading")
    );
    // No logging is too slow whose times are too coarse.
    assert_eq!(
        code(refuse_record(1, 0.2, RudderUnit::Rad, 0.5, true)).as_deref(),
        Some("sampled_too_seldom of time")
    );
    assert_eq!(refuse_record(330, 0.2, RudderUnit::Rad, 0.5, true), None);
}

#[test]
fn exact_a_drifting_speed_and_a_jittering_clock_are_noted() {
    let at = |speed, interval| {
        Chain::with(|c| {
            c.log.surge_speed_m_s = Some(speed);
            c.log.interval_s = Some(interval);
        })
    };
    let steady = at([1.6, 1.5], [0.05, 0.06]);
    assert_eq!(codes(&steady.judge()), ["ok"]);
    let verdict = at([1.6, 1.3], [0.05, 0.1]).judge();
    assert!(verdict.accepted);
    assert_eq!(codes(&verdict), ["ok", "drifted of speed", "clock_jitter"]);
}

#[test]
fn exact_a_rudder_of_unknown_angle_is_reported_as_a_share_of_full() {
    let text = |unit| rudder_constant(0.001, unit).detail;
    assert!(text(RudderUnit::Rad).contains("within 0.0573 deg:"));
    assert!(
        text(RudderUnit::FullRudder).contains("within 0.100 % of full:"),
        "{}",
        text(RudderUnit::FullRudder)
    );
    let verdict = Chain::with(|c| {
        c.log.rudder_unit = RudderUnit::FullRudder;
        c.validation_rudder_amplitude_rad = Some(0.5);
    })
    .judge();
    assert_eq!(codes(&verdict), ["ok", "extrapolating"]);
    assert!(
        verdict.reasons[1]
            .detail
            .contains("50.0 % of full of rudder either side, training only 26.0 % of full")
    );
}

/// A rudder that stops at half of the training's angle gives half of b2 there, and all of it at the validation's.
#[test]
fn exact_a_rudder_that_stops_is_reported_with_its_angle() {
    let trained = refined_at([-1.07, 0.54, 0.012], 0.05);
    let unsaturated = refined_at([-1.07, 1.08, 0.012], 0.05);
    let verdict = Chain::of(trained.clone()).with_independent(&unsaturated, None).judge();
    assert!(!verdict.accepted);
    assert_eq!(codes(&verdict), ["rudder_not_followed"]);
    let text = &verdict.reasons[0].detail;
    // Half of 0.26 rad.
    assert!(text.contains("as if it stopped at 7.45 deg"), "{text}");
    // More per degree where there was more of it is something else.
    let other = refined_at([-1.07, 0.27, 0.012], 0.05);
    let verdict = Chain::of(trained.clone()).with_independent(&other, None).judge();
    assert_eq!(codes(&verdict), ["contradicted"]);
    // Validation data through a compass that jumped say nothing of the rudder.
    let verdict = Chain::of(trained).with_independent(&unsaturated, Some(JUMP)).judge();
    assert_eq!(codes(&verdict), ["compass_error"]);
    let Reason { detail, text, .. } = &verdict.reasons[0];
    assert!(detail.contains("in the validation data the heading parts by 3.44 deg"), "{detail}");
    assert_eq!(
        text,
        "At 21.5 s the compass jumped, stuck or was disturbed: it was off by 3.44 deg within a second."
    );
}

/// Data that a compass jumped in are not predicted, and the jump is the cause.
#[test]
fn exact_a_jump_comes_before_the_r2_that_it_lowers() {
    let estimate = refined(0.05);
    let mut chain = Chain::of(estimate.clone()).with_independent(&estimate, Some(JUMP));
    chain.validation = Some(validation(0.2, 0.3, 0.4));
    assert_eq!(codes(&chain.judge()), ["compass_error", "low_r2"]);
}

/// An interval that holds 0 is a veto, whatever validation data say: a slow drift of the heading can be simulated.
#[test]
fn exact_an_interval_that_holds_0_is_a_veto() {
    let judged = |yaw_rate: f64| {
        let mut vague = Chain::of(refined(1.2)).with_misfit(0.2);
        vague.validation = Some(validation(0.9, 0.95, yaw_rate));
        vague.judge()
    };
    assert_eq!(codes(&judged(0.96))[0], "not_identifiable");
    let jammed = judged(0.06);
    assert!(!jammed.accepted);
    assert_eq!(codes(&jammed)[0], "not_identifiable");
}

/// Nor does an interval hold 0 that reaches what the validation data say by themselves.
#[test]
fn exact_an_interval_that_reaches_0_is_a_veto() {
    let judged = |apart: f64| {
        let other = refined_at([-1.07 - apart, 1.08, 0.012], 0.05);
        Chain::of(refined(0.05)).with_independent(&other, None).judge()
    };
    assert_eq!(codes(&judged(0.5))[0], "ok");
    assert_eq!(codes(&judged(1.2))[0], "not_identifiable");
}

/// An interval that holds 0 holds a vehicle as slow as can be, for which no log is too slow.
#[test]
fn exact_a_pace_is_judged_by_the_slowest_vehicle() {
    let judged = |half_width: f64| {
        let pace = Pace { row_s: 0.5, heading_s: 0.5, rudder_s: 0.5 };
        let mut chain = Chain::of(refined(half_width));
        chain.log.pace = Some(pace);
        codes(&chain.judge())
    };
    // Once for both channels.
    let seldom = |code: &&String| *code == "sampled_too_seldom";
    assert_eq!(judged(0.1).iter().filter(seldom).count(), 1);
    assert_eq!(judged(30.0)[0], "not_identifiable");
}

/// The online estimate takes a column that is late for less damping; nothing else turned the vehicle.
#[test]
fn exact_a_late_rudder_explains_a_disagreement() {
    let refined = refined(0.05);
    let a22 = refined.model.a22_per_s;
    let verdict = Chain::with(|c| {
        c.online.a22_per_s = 1.3 * a22;
        c.explanation = Explanation::FirstOrder {
            fit: FirstOrderFit { delay_s: 0.15 / a22, ..fit(&refined, None) },
        };
    })
    .judge();
    assert_eq!(codes(&verdict), ["ok", "contradicted of training"]);
    let late = &verdict.reasons[1];
    assert!(late.text.contains("is logged"), "{late:?}");
}

#[test]
fn exact_a_hand_that_falls_short_is_noted() {
    let verdict = Chain::with(|c| c.log.rudder_sides_rad = Some([0.26, 0.15])).judge();
    assert!(verdict.accepted);
    assert_eq!(codes(&verdict), ["ok", "rudder_not_followed"]);
    let text = &verdict.reasons[1].detail;
    assert!(text.contains("14.9 deg") && text.contains("8.59 deg"), "{text}");
}

#[test]
fn exact_a_residual_that_chance_does_not_explain_is_noted() {
    let refined = Refined { heading_noise_rad: 0.01, ..refined(0.05) };
    let tests = |whiteness: f64, rudder: f64| {
        let test = |p_value, degrees_of_freedom| ResidualTest {
            statistic: 40.0,
            degrees_of_freedom,
            p_value,
        };
        Some(ResidualTests {
            whiteness: test(whiteness, 20.0),
            rudder_correlation: test(rudder, 6.0),
        })
    };
    let judged = |residual| {
        let mut chain = Chain::of(refined.clone());
        chain.explanation = Explanation::FirstOrder { fit: fit(&refined, residual) };
        chain.judge()
    };
    assert_eq!(codes(&judged(tests(0.01, 0.01))), ["ok"]);
    for (residual, said) in
        [(tests(0.5, 1e-5), "follows the rudder"), (tests(1e-5, 0.5), "a rhythm of its own")]
    {
        let verdict = judged(residual);
        assert!(verdict.accepted);
        assert_eq!(codes(&verdict), ["ok", "model_order of residual"]);
        let text = &verdict.reasons[1].detail;
        assert!(text.contains(said) && text.contains("is 40 where 20"), "{text}");
    }
}

/// What happened once comes before what it led to, and rejects nothing that holds.
#[test]
fn exact_a_mishap_is_named_where_the_model_does_not_hold() {
    let jam = Jam { from_s: 8.0, to_s: None, rudder_rad: 0.2 };
    let with = |mishaps, heading| {
        Chain::with(|c| {
            c.mishaps = mishaps;
            c.validation = Some(validation(heading, heading, heading));
        })
    };
    let jumped = Mishaps { jump: Some((JUMP, "in training")), jam: None };
    let stuck = Mishaps { jump: None, jam: Some((jam, "in the validation data")) };
    for (mishaps, code) in [(jumped, "compass_error"), (stuck, "rudder_not_followed of rudder")] {
        assert_eq!(codes(&with(mishaps, 0.2).judge())[..2], [code, "low_r2"]);
        assert_eq!(codes(&with(mishaps, 0.95).judge()), ["ok"]);
    }
}

/// A heading that went on while a rounded time stood still did not jump.
#[test]
fn exact_a_rounded_time_comes_before_a_jump_of_the_heading() {
    let rounded = Chain::with(|chain| {
        chain.validation = Some(validation(0.1, 0.1, 0.1));
        chain.mishaps.jump = Some((JUMP, "in training"));
        chain.log.compass.largest_jump = Some(JUMP);
        chain.log.jump_beside = Some(JUMP);
        chain.log.interval_s = Some([1.0, 10.0]);
        chain.log.times_are_shared = true;
    });
    assert_eq!(codes(&rounded.judge())[..2], ["sampled_too_seldom of time", "low_r2"]);
}

/// Rows that come evenly were not lost where their time is rounded.
#[test]
fn exact_a_rounded_time_is_said_in_place_of_lost_samples() {
    let rounded = Chain::with(|chain| {
        chain.log.interval_s = Some([0.864, 1.728]);
        chain.log.rounded_time_s = Some([0.864, 1.0]);
        chain.log.hidden_edges = 2;
    });
    let verdict = rounded.judge();
    assert_eq!(codes(&verdict), ["ok", "clock_jitter"]);
    let text = &verdict.reasons[1].text;
    assert!(text.contains("steps of 0.864 s, while rows come every 1.00 s"), "{text}");
}

#[test]
fn exact_a_turning_circle_is_sent_to_the_command_that_reads_it() {
    let circle = |half_width, is_validated: bool| {
        let mut chain = Chain::of(refined(half_width));
        chain.log.is_turning_circle = true;
        chain.validation = chain.validation.filter(|_| is_validated);
        chain.judge().reasons[0].clone()
    };
    for reason in [circle(0.05, false), circle(0.7, true)] {
        assert!(reason.action.contains("seatrial manoeuvres read"), "{reason:?}");
        assert!(!reason.action.contains("more rudder"), "{reason:?}");
    }
    assert!(circle(0.05, true).action.is_empty());
}
