use seatrial_core::model::YawState;
use seatrial_core::{Sample, YawModel};

use super::*;
use crate::identify::propose;
use crate::record::Record;

/// The 80 % vehicle steered by `rudder(t)`, 20 Hz, exact.
fn steered(duration_s: f64, rudder: impl Fn(f64) -> f64) -> Vec<Sample<f64>> {
    let model = YawModel::from_theta([-1.07, 1.08, 0.0]);
    let mut state = YawState::default();
    (0..(duration_s * 20.0) as u32)
        .map(|k| {
            let time_s = f64::from(k) * 0.05;
            let rudder_rad = rudder(time_s + 1e-9);
            let sample =
                Sample { time_s, heading_rad: state.heading_rad, rudder_rad, ..Sample::default() };
            state = model.advance(state, rudder_rad, 0.05);
            sample
        })
        .collect()
}

/// Strokes of these lengths from side to side from `from_s` on.
fn strokes(time_s: f64, from_s: f64, lengths_s: &[f64]) -> f64 {
    let mut end_s = from_s;
    for (k, length_s) in lengths_s.iter().enumerate() {
        let begins_s = end_s;
        end_s += length_s;
        if (begins_s..end_s).contains(&time_s) {
            return if k % 2 == 0 { 1.0 } else { -1.0 };
        }
    }
    0.0
}

fn kinds(found: &[Segment]) -> Vec<Kind> {
    found.iter().map(|segment| segment.kind).collect()
}

/// A trim of 2.3 deg makes the sides of 8.6 deg unequal by 1.7 from neutral.
#[test]
fn regress_a_trim_hides_no_doublet() {
    for trim_rad in [-0.04, 0.0, 0.04] {
        let samples = steered(60.0, |t| match strokes(t, 20.0, &[2.0, 2.0]) {
            0.0 => trim_rad,
            side => 0.15 * side,
        });
        let doublets = find(&samples);
        assert!(kinds(&doublets).contains(&Kind::Doublet), "{trim_rad}");
    }
}

/// Doublets that begin while the vehicle is on its way back from the one before, by a heading that is half a second late.
#[test]
fn recover_doublets_that_follow_closely() {
    let mut samples = steered(60.0, |t| {
        let side = |from_s: f64| 0.35 * strokes(t, from_s, &[1.5, 1.5]);
        side(20.0) - side(27.5) + side(35.0)
    });
    for row in (10..samples.len()).rev() {
        samples[row].heading_rad = samples[row - 10].heading_rad;
    }
    let found = find(&samples);
    let doublets = kinds(&found).into_iter().filter(|kind| *kind == Kind::Doublet);
    assert_eq!(doublets.count(), 3, "{found:?}");
}

#[test]
fn exact_every_kind_is_recognised() {
    let cases: [(&[f64], Kind); 6] = [
        (&[2.0, 2.0], Kind::Doublet),
        (&[3.0, 2.0, 1.0, 1.0], Kind::Multistep),
        (&[1.0, 2.0, 1.0], Kind::Multistep),
        (&[1.5, 3.0, 3.0, 3.0], Kind::ZigZag),
        (&[2.0], Kind::Step),
        (&[40.0], Kind::TurningCircle),
    ];
    for (lengths_s, kind) in cases {
        let samples = steered(100.0, |t| 0.26 * strokes(t, 20.0, lengths_s));
        let found: Vec<Segment> =
            find(&samples).into_iter().filter(|s| s.kind != Kind::Steady).collect();
        assert_eq!(kinds(&found), [kind], "{lengths_s:?}");
        assert_eq!(found[0].strokes, lengths_s.len());
        // Times are sums of sample intervals.
        assert!((found[0].window.from_s - 20.0).abs() < 0.051);
        let end_s = 20.0 + lengths_s.iter().sum::<f64>();
        assert!((found[0].window.to_s - end_s).abs() < 0.051);
        assert!((found[0].amplitude_rad - 0.26).abs() < 1e-9);
        assert_eq!(found[0].completeness, 1.0);
    }
}

/// Stroke lengths and amplitudes a hundred times apart in one record.
#[test]
fn prop_large_and_small_slow_and_fast_manoeuvres_are_found_alike() {
    let samples = steered(600.0, |t| {
        0.5 * strokes(t, 20.0, &[1.0, 1.0])
            + 0.02 * strokes(t, 100.0, &[2.0, 2.0])
            + 0.1 * strokes(t, 200.0, &[60.0, 60.0])
            + 0.01
    });
    let found = find(&samples);
    let doublets = found.iter().filter(|s| s.kind == Kind::Doublet).count();
    assert_eq!(doublets, 3, "{found:#?}");
}

/// A rudder that is never held, however it moves, and one that rests.
#[test]
fn prop_nothing_is_invented() {
    let sine = steered(600.0, |t| 0.2 * (0.7 * t).sin());
    let decaying = steered(600.0, |t| 0.3 * (-0.1 * (t % 60.0)).exp() * (1.3 * t).sin());
    let still = steered(600.0, |_| 0.1);
    for samples in [sine, decaying, still, Vec::new()] {
        assert_eq!(kinds(&find(&samples)), []);
    }
}

/// The controller's way back, as large as the doublet but shorter, is no part of it.
#[test]
fn exact_recovery_is_not_part_of_a_doublet() {
    let samples = steered(60.0, |t| 0.26 * strokes(t, 20.0, &[2.0, 2.0, 0.8]));
    let found = find(&samples);
    let doublet = found.iter().find(|s| s.kind == Kind::Doublet).unwrap();
    // Times are sums of sample intervals.
    assert!((doublet.window.to_s - 24.0).abs() < 0.051);
}

#[test]
fn exact_proposal_trains_and_validates_at_each_speed_without_overlap() {
    let mut samples = steered(200.0, |t| {
        0.26 * strokes(t, 20.0, &[2.0, 2.0])
            + 0.15 * strokes(t, 35.0, &[2.0, 2.0])
            + 0.2 * strokes(t, 50.0, &[2.0, 2.0])
            + 0.2 * strokes(t, 120.0, &[2.0, 2.0])
    });
    for sample in &mut samples {
        sample.thrust = Some(if sample.time_s < 100.0 { 0.6 } else { 0.9 });
    }
    let segments = find(&samples);
    let record: Record = samples.into_iter().collect();
    let [slow, fast] = &propose(&record, &segments)[..] else {
        panic!("two speeds");
    };
    // Means of equal numbers, to rounding.
    assert!((slow.thrust.unwrap() - 0.6).abs() < 1e-9 && (fast.thrust.unwrap() - 0.9).abs() < 1e-9);
    // The largest trains first, the second largest validates, the third is joined.
    let starts = |windows: &[Window]| -> Vec<u32> {
        windows.iter().map(|w| w.from_s.round() as u32).collect()
    };
    // The vehicle's time constant is 0.93 s: two of them before each manoeuvre.
    assert_eq!(starts(&slow.training), [18, 33]);
    assert_eq!(starts(&[slow.validation.unwrap()]), [48]);
    assert_eq!((fast.training.len(), fast.validation), (1, None));
    let mut windows: Vec<Window> = slow.training.to_vec();
    windows.extend(slow.validation);
    windows.sort_by(|a, b| a.from_s.total_cmp(&b.from_s));
    assert!(windows.is_sorted_by(|a, b| a.to_s <= b.from_s), "{windows:?}");
}

/// A doublet while the vehicle still gains way, as in the check before a trial: b2 grows with the square of the speed.
#[test]
fn exact_a_manoeuvre_at_another_speed_is_not_joined_though_the_thrust_is_the_same() {
    let trained_from = |first_speed_m_s: f64, first_rad: f64| -> Vec<u32> {
        let mut samples = steered(100.0, |t| {
            first_rad * strokes(t, 20.0, &[2.0, 2.0])
                + 0.26 * strokes(t, 50.0, &[2.0, 2.0])
                + 0.15 * strokes(t, 75.0, &[2.0, 2.0])
        });
        for sample in &mut samples {
            let gained = ((sample.time_s - 15.0) / 10.0).clamp(0.0, 1.0);
            sample.thrust = Some(0.5);
            sample.surge_speed_m_s = Some(first_speed_m_s + gained * (1.5 - first_speed_m_s));
        }
        let segments = find(&samples);
        let record: Record = samples.into_iter().collect();
        let [one] = &propose(&record, &segments)[..] else {
            panic!("one thrust");
        };
        let validation = one.validation.unwrap();
        assert!(validation.from_s > 40.0 || first_speed_m_s > 1.0);
        one.training.iter().map(|w| w.from_s.round() as u32).collect()
    };
    assert_eq!(trained_from(1.45, 0.1), [48, 18]);
    assert_eq!(trained_from(0.0, 0.1), [48]);
    // Not even where it turned the vehicle furthest.
    assert_eq!(trained_from(0.0, 0.4), [48]);
}
