use super::*;
use crate::identification::Intervals;
use crate::identify::second_order::ResidualTest;
use crate::record::Window;

fn refined(half_width: f64) -> Refined {
    refined_at([-1.07, 1.08, 0.012], half_width)
}

pub(super) fn refined_at(theta: [f64; 3], half_width: f64) -> Refined {
    let model = YawModel::from_theta(theta);
    let around = |value: f64| {
        [
            value - half_width * value.abs(),
            value + half_width * value.abs(),
        ]
    };
    Refined {
        method: "test".into(),
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
    }
}

fn training_fit(heading: f64, yaw_rate: f64) -> GoodnessOfFit<f64> {
    GoodnessOfFit {
        r2_heading_offset_refit: Some(heading),
        r2_yaw_rate: Some(yaw_rate),
        ..GoodnessOfFit::default()
    }
}

fn evidence(refined: &Refined) -> Evidence<'_> {
    Evidence {
        samples_used: 330,
        samples_rejected: 0,
        rudder_amplitude_rad: 0.26,
        rudder_hands_rad: Some([0.27, 0.25]),
        rudder_unit: RudderUnit::Rad,
        heading_range_rad: 0.5,
        heading_step_rad: None,
        surge_speed_m_s: None,
        interval_s: None,
        online: refined.model,
        needs_interval: true,
        compass: CompassError::default(),
        refined: Some(refined),
        mismatch: None,
        disturbed: None,
        higher_order: None,
        lag_effect: None,
        residual: None,
        hidden_edges: 0,
        training_fit: training_fit(0.95, 0.95),
        validation: Some(validation(0.9, 0.95, 0.96)),
        fresh_jump_rad: None,
        fresh: None,
        validation_rudder_amplitude_rad: Some(0.15),
    }
}

fn codes(verdict: &Verdict) -> Vec<&str> {
    verdict.reasons.iter().map(|r| r.code.as_str()).collect()
}

#[test]
fn exact_good_run_is_accepted() {
    let refined = refined(0.05);
    let verdict = judge(&evidence(&refined));
    assert!(verdict.accepted);
    assert_eq!(codes(&verdict), ["ok"]);
}

#[test]
fn exact_each_defect_is_refused_under_its_own_code() {
    let good = refined(0.05);
    let wide = refined(0.6);
    let lost = refined(1.5);
    let unstable = refined_at([0.1, 1.08, 0.012], 0.05);
    let base = evidence(&good);
    let cases = [
        ("under_excited", evidence(&wide)),
        ("not_identifiable", evidence(&lost)),
        (
            "unstable",
            Evidence {
                online: unstable.model,
                refined: Some(&unstable),
                ..base
            },
        ),
        (
            "low_r2",
            Evidence {
                validation: Some(validation(0.3, 0.4, 0.9)),
                ..base
            },
        ),
        (
            "does_not_fit",
            Evidence {
                training_fit: training_fit(0.95, 0.1),
                ..base
            },
        ),
        (
            "does_not_fit",
            Evidence {
                training_fit: GoodnessOfFit::default(),
                ..base
            },
        ),
        (
            "rejected_samples",
            Evidence {
                samples_rejected: 200,
                ..base
            },
        ),
        (
            "not_identifiable",
            Evidence {
                refined: None,
                ..base
            },
        ),
        (
            "compass_error",
            Evidence {
                compass: CompassError {
                    largest_jump_rad: Some(0.1),
                    ..CompassError::default()
                },
                ..base
            },
        ),
        (
            "compass_deviation",
            Evidence {
                compass: CompassError {
                    scale_error: Some(-0.06),
                    ..CompassError::default()
                },
                ..base
            },
        ),
        (
            "compass_late",
            Evidence {
                compass: CompassError {
                    late_s: Some(0.1),
                    ..CompassError::default()
                },
                ..base
            },
        ),
        (
            "quantised",
            Evidence {
                heading_step_rad: Some(0.2),
                ..base
            },
        ),
        (
            "disagreement",
            Evidence {
                online: YawModel::from_theta([-0.1, 1.08, 0.012]),
                ..base
            },
        ),
    ];
    for (code, evidence) in cases {
        let verdict = judge(&evidence);
        assert!(!verdict.accepted, "{code}");
        assert_eq!(codes(&verdict)[0], code);
    }
}

#[test]
fn exact_notes_do_not_refuse() {
    let reversed = refined_at([-1.07, -1.08, 0.012], 0.05);
    let noted = Evidence {
        online: reversed.model,
        refined: Some(&reversed),
        validation: Some(validation(-2.0, 0.9, 0.97)),
        validation_rudder_amplitude_rad: Some(0.5),
        ..evidence(&reversed)
    };
    let verdict = judge(&noted);
    assert!(verdict.accepted);
    assert_eq!(
        codes(&verdict),
        ["ok", "sign_reversed", "offset_drifted", "extrapolating"]
    );
    let verdict = judge(&Evidence {
        validation: None,
        ..noted
    });
    assert!(codes(&verdict).contains(&"not_validated"));
}

#[test]
fn exact_records_without_a_model_are_refused() {
    let code = |reason: Option<Reason>| reason.map(|r| r.code);
    assert_eq!(
        code(refuse_record(1, 0.2, RudderUnit::Rad, 0.5)).as_deref(),
        Some("too_few_samples")
    );
    assert_eq!(
        code(refuse_record(330, 0.0, RudderUnit::Rad, 0.5)).as_deref(),
        Some("rudder_constant")
    );
    assert_eq!(
        code(refuse_record(330, 0.2, RudderUnit::Rad, 0.0)).as_deref(),
        Some("heading_constant")
    );
    assert_eq!(refuse_record(330, 0.2, RudderUnit::Rad, 0.5), None);
}

#[test]
fn exact_a_drifting_speed_and_a_jittering_clock_are_noted() {
    let refined = refined(0.05);
    let steady = Evidence {
        surge_speed_m_s: Some([1.6, 1.5]),
        interval_s: Some([0.05, 0.06]),
        ..evidence(&refined)
    };
    assert_eq!(codes(&judge(&steady)), ["ok"]);
    let unsteady = Evidence {
        surge_speed_m_s: Some([1.6, 1.3]),
        interval_s: Some([0.05, 0.1]),
        ..evidence(&refined)
    };
    let verdict = judge(&unsteady);
    assert!(verdict.accepted);
    assert_eq!(codes(&verdict), ["ok", "speed_drifted", "clock_jitter"]);
}

#[test]
fn exact_a_rudder_of_unknown_angle_is_told_as_a_share_of_full() {
    let text = |unit| rudder_constant(0.001, unit).text;
    assert!(text(RudderUnit::Rad).contains("within 0.0573 deg:"));
    assert!(
        text(RudderUnit::FullRudder).contains("within 0.100 % of full:"),
        "{}",
        text(RudderUnit::FullRudder)
    );
    let refined = refined(0.05);
    let verdict = judge(&Evidence {
        rudder_unit: RudderUnit::FullRudder,
        validation_rudder_amplitude_rad: Some(0.5),
        ..evidence(&refined)
    });
    assert_eq!(codes(&verdict), ["ok", "extrapolating"]);
    assert!(
        verdict.reasons[1]
            .text
            .contains("50.0 % of full of rudder either side, training only 26.0 % of full")
    );
}

/// A rudder that stops at half of the training's angle gives half of b2 there, and all of it at the validation's.
#[test]
fn exact_a_rudder_that_stops_is_told_with_its_angle() {
    let trained = refined_at([-1.07, 0.54, 0.012], 0.05);
    let fresh = refined_at([-1.07, 1.08, 0.012], 0.05);
    let stopped = Evidence {
        fresh: Some(&fresh),
        ..evidence(&trained)
    };
    let verdict = judge(&stopped);
    assert!(!verdict.accepted);
    assert_eq!(codes(&verdict), ["rudder_saturated"]);
    let text = &verdict.reasons[0].text;
    // Half of 0.26 rad.
    assert!(text.contains("as if it stopped at 7.45 deg"), "{text}");
    // More per degree where there was more of it is something else.
    let other = refined_at([-1.07, 0.27, 0.012], 0.05);
    let verdict = judge(&Evidence {
        fresh: Some(&other),
        ..stopped
    });
    assert_eq!(codes(&verdict), ["contradicted"]);
    // Fresh data through a compass that jumped say nothing of the rudder.
    let verdict = judge(&Evidence {
        fresh_jump_rad: Some(0.06),
        ..stopped
    });
    assert_eq!(codes(&verdict), ["compass_error"]);
    let text = &verdict.reasons[0].text;
    assert!(
        text.contains("in the fresh data the heading parts by 3.44 deg"),
        "{text}"
    );
}

/// Of a rudder that jams, a slow drift of the heading can be simulated, and no yaw rate.
#[test]
fn exact_fresh_data_decide_where_their_yaw_rate_follows_the_rudder() {
    let vague = refined(1.2);
    let judged = |yaw_rate: f64| {
        judge(&Evidence {
            mismatch: Some(0.2),
            validation: Some(validation(0.9, 0.95, yaw_rate)),
            ..evidence(&vague)
        })
    };
    assert!(judged(0.96).accepted);
    let jammed = judged(0.06);
    assert!(!jammed.accepted);
    assert_eq!(codes(&jammed)[0], "not_identifiable");
}

#[test]
fn exact_a_hand_that_falls_short_is_noted() {
    let refined = refined(0.05);
    let short = Evidence {
        rudder_hands_rad: Some([0.26, 0.15]),
        ..evidence(&refined)
    };
    let verdict = judge(&short);
    assert!(verdict.accepted);
    assert_eq!(codes(&verdict), ["ok", "rudder_saturated"]);
    let text = &verdict.reasons[1].text;
    assert!(
        text.contains("14.9 deg") && text.contains("8.59 deg"),
        "{text}"
    );
}

#[test]
fn exact_a_residual_that_chance_does_not_explain_is_noted() {
    let refined = Refined {
        heading_noise_rad: 0.01,
        ..refined(0.05)
    };
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
    let judged = |residual, mismatch| {
        judge(&Evidence {
            residual,
            mismatch,
            ..evidence(&refined)
        })
    };
    assert_eq!(codes(&judged(tests(0.01, 0.01), None)), ["ok"]);
    for (residual, said) in [
        (tests(0.5, 1e-5), "follows the rudder"),
        (tests(1e-5, 0.5), "a rhythm of its own"),
    ] {
        let verdict = judged(residual, None);
        assert!(verdict.accepted);
        assert_eq!(codes(&verdict), ["ok", "residual_not_white"]);
        let text = &verdict.reasons[1].text;
        assert!(
            text.contains(said) && text.contains("is 40 where 20"),
            "{text}"
        );
    }
    // A higher order has been named already.
    assert!(!codes(&judged(tests(0.5, 1e-5), Some(0.2))).contains(&"residual_not_white"));
}
