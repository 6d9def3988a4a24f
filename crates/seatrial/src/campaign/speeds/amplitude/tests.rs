use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

use super::*;
use crate::identify::whole_record::robust_estimate;
use crate::propagation::NORMAL_95;

/// A hull whose damping grows with its yaw rate.
const A22: f64 = -0.5;
const QUADRATIC: f64 = -1.5;
const B2: f64 = 0.5;
const C0: f64 = 0.004;

/// Two doublets of this rudder at 10 Hz, between rests, with 0.3 deg of noise in the heading.
fn doublets(rudder_rad: f64, random: &mut Pcg64) -> Vec<Sample<f64>> {
    const PARTS: u32 = 20;
    let part_s = 0.1 / f64::from(PARTS);
    let (mut heading_rad, mut rate) = (0.0, 0.0_f64);
    (0..500_u32)
        .map(|k| {
            let side = match k % 250 {
                30..90 => 1.0,
                90..150 => -1.0,
                _ => 0.0,
            };
            let noise: f64 = StandardNormal.sample(random);
            let sample = Sample {
                time_s: 0.1 * f64::from(k),
                heading_rad: heading_rad + 0.3_f64.to_radians() * noise,
                rudder_rad: side * rudder_rad,
                ..Sample::default()
            };
            for _ in 0..PARTS {
                let slope =
                    |r: f64| A22 * r + QUADRATIC * r.abs() * r + B2 * sample.rudder_rad + C0;
                let middle = rate + 0.5 * part_s * slope(rate);
                heading_rad += part_s * middle;
                rate += part_s * slope(middle);
            }
            sample
        })
        .collect()
}

fn identified(rudder_rad: f64, random: &mut Pcg64) -> SeenModel {
    let samples = doublets(rudder_rad, random);
    let refined = robust_estimate(&samples).unwrap().refined;
    let amplitude = yaw_rate_amplitude_rad_s(refined.model, &[&samples]).unwrap();
    SeenModel::of(&refined, amplitude)
}

fn holds(bounded: &ValueInterval, truth: f64) -> bool {
    let [low, high] = bounded.interval_95;
    (low..=high).contains(&truth)
}

/// A model drawn from its own covariance.
fn drawn(amplitude: f64, b2: f64, random: &mut Pcg64) -> SeenModel {
    let mut normal = || -> f64 { StandardNormal.sample(random) };
    let (deviation_a22, deviation_b2, correlation) = (0.02, 0.01, -0.8);
    let (first, second) = (normal(), normal());
    let rest = f64::sqrt(1.0 - correlation * correlation);
    let shared = correlation * deviation_a22 * deviation_b2;
    SeenModel {
        yaw_rate_amplitude_rad_s: amplitude,
        a22_per_s: A22 + 8.0 / (3.0 * PI) * QUADRATIC * amplitude + deviation_a22 * first,
        b2_per_s2: b2 + deviation_b2 * (correlation * first + rest * second),
        covariance: [
            [deviation_a22 * deviation_a22, shared],
            [shared, deviation_b2 * deviation_b2],
        ],
    }
}

#[test]
fn exact_a_sine_has_its_own_amplitude_and_a_rest_does_not_lower_it() {
    let record = |rest: u32| -> Vec<Sample<f64>> {
        (0..4000)
            .map(|k| {
                let moved = f64::from(k.max(rest) - rest) * 0.01;
                Sample {
                    time_s: 0.01 * f64::from(k),
                    heading_rad: 0.4 * (1.0 - moved.cos()),
                    ..Sample::default()
                }
            })
            .collect()
    };
    let model = YawModel::from_theta([-10.0, 1.0, 0.0]);
    for rest in [0, 2000] {
        let samples = record(rest);
        // Whole periods of 2 pi s.
        let end = rest as usize + if rest == 0 { 3770 } else { 1885 };
        let amplitude = yaw_rate_amplitude_rad_s(model, &[&samples[..end]]).unwrap();
        assert!((amplitude - 0.4).abs() < 2e-3, "{rest}: {amplitude}");
    }
    assert!(yaw_rate_amplitude_rad_s(model, &[]).is_none());
    assert!(yaw_rate_amplitude_rad_s(model, &[&record(4000)]).is_none());
}

#[test]
fn stat_intervals_of_drawn_models_are_honest_and_chance_is_chi_squared() {
    let mut random = Pcg64::seed_from_u64(1);
    let amplitudes = [0.02, 0.05, 0.1, 0.15, 0.2];
    let (mut held, mut sum, runs) = ([0; 4], 0.0, 400);
    for _ in 0..runs {
        let models = amplitudes.map(|amplitude| drawn(amplitude, B2, &mut random));
        let fit = OverAmplitude::of(&models).unwrap();
        assert_eq!(fit.degrees_of_freedom, 7);
        let middle = A22 + 8.0 / (3.0 * PI) * QUADRATIC * 0.12;
        for (held, (bounded, truth)) in held.iter_mut().zip([
            (fit.a22_at_rest_per_s, A22),
            (fit.quadratic_per_rad.unwrap(), QUADRATIC),
            (fit.b2_per_s2, B2),
            (fit.a22_at(0.12), middle),
        ]) {
            *held += i32::from(holds(&bounded, truth));
        }
        sum += fit.chi_squared;
    }
    // 380 +- 4.4 of 400; the few widened intervals add to it.
    assert!(held.iter().all(|held| (365..=396).contains(held)), "{held:?}");
    assert!((sum / f64::from(runs) - 7.0).abs() < 0.6, "{sum}");
}

#[test]
fn exact_what_amplitude_does_not_explain_widens_the_intervals() {
    let mut random = Pcg64::seed_from_u64(2);
    let models = [0.02, 0.1, 0.2].map(|amplitude| drawn(amplitude, B2, &mut random));
    let explained = OverAmplitude::of(&models).unwrap();
    assert!(explained.is_explained());
    assert_eq!(explained.finding, Finding::Grows);
    assert!(explained.text().starts_with("Damping grows with the turn rate: a22 is -0.5"));
    let mut other = models;
    other[1].b2_per_s2 *= 1.5;
    let differing = OverAmplitude::of(&other).unwrap();
    assert!(!differing.is_explained());
    assert_eq!(differing.finding, Finding::Differ);
    assert!(differing.text().contains("more than amplitude explains"));
    let width = |fit: &OverAmplitude| {
        let [low, high] = fit.b2_per_s2.interval_95;
        high - low
    };
    // Student's of three degrees of freedom, and the root of chi-square per degree.
    let widened = (differing.chi_squared / 3.0).sqrt() * 3.182_446 / NORMAL_95;
    assert!((width(&differing) / width(&explained) / widened - 1.0).abs() < 1e-5);
}

#[test]
fn exact_alike_amplitudes_have_one_model() {
    let mut random = Pcg64::seed_from_u64(3);
    let models = [0.1, 0.11]
        .map(|amplitude| SeenModel { a22_per_s: A22, ..drawn(amplitude, B2, &mut random) });
    let fit = OverAmplitude::of(&models).unwrap();
    assert_eq!((fit.quadratic_per_rad, fit.degrees_of_freedom), (None, 2));
    assert_eq!(fit.a22_at(0.1), fit.a22_at_rest_per_s);
    assert!(OverAmplitude::of(&models[..1]).is_none());
    assert!(OverAmplitude::of(&[]).is_none());
    let mut unsure = models;
    unsure[0].covariance = [[f64::NAN; 2]; 2];
    assert!(OverAmplitude::of(&unsure).is_none());
}

/// Six amplitudes of a simulated hull, identified one by one.
#[test]
fn stat_intervals_hold_the_quadratic_damping_of_a_simulated_hull() {
    let runs = 50;
    let mut held = [0; 3];
    let mut grows = 0;
    for seed in 0..runs {
        let mut random = Pcg64::seed_from_u64(seed);
        let models =
            [0.04, 0.08, 0.14, 0.2, 0.28, 0.36].map(|rudder| identified(rudder, &mut random));
        let fit = OverAmplitude::of(&models).unwrap();
        let truths = [
            (fit.a22_at_rest_per_s, A22),
            (fit.quadratic_per_rad.unwrap(), QUADRATIC),
            (fit.b2_per_s2, B2),
        ];
        for (held, (bounded, truth)) in held.iter_mut().zip(truths) {
            *held += i32::from(holds(&bounded, truth));
        }
        grows += i32::from(fit.finding == Finding::Grows);
        if seed < 3 {
            println!("{seed}: {}", fit.figures_text());
        }
    }
    println!("a22_0, a_rr, b2 held {held:?} of {runs}; grows {grows}");
    assert!(held.iter().all(|held| *held >= 45), "{held:?}");
    assert!(grows >= 45, "{grows}");
}
