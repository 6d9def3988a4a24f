//! The kernels of least squares from sums beside the recursion, sample by sample, and beside an orthogonal factorisation.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use seatrial::identify::batch::BatchLeastSquares;
use seatrial_core::fixed_rate::{FixedRateEstimator, FixedRateSettings};
use seatrial_core::model::{YawModel, YawState};
use seatrial_core::state_variable_filter::{FilterStart, FilterStep, Hold, StateVariableFilter};
use seatrial_kernels::{
    Accumulator, NoisyRuns, every_theta, monte_carlo, normals_of_run, of_records,
};

const INTERVAL_S: f64 = 0.05;
const LAMBDA_RAD_S: f64 = 1.5;

/// A vehicle that steers to both hands all the time, its heading noisy by a third of a degree.
fn signals(samples: usize, seed: u64) -> (Vec<f64>, Vec<f64>) {
    let model = YawModel::from_theta([-1.07, 1.08, 0.012]);
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut state = YawState::default();
    let mut hand = 0.26;
    (0..samples)
        .map(|k| {
            if k % 80 == 0 {
                hand = -hand + random.random_range(-0.02..0.02);
            }
            let noise = random.random_range(-0.006..0.006);
            let now = (state.heading_rad + noise, hand);
            state = model.advance(state, hand, INTERVAL_S);
            now
        })
        .unzip()
}

fn every_setting() -> impl Iterator<Item = FixedRateSettings<f64>> {
    let paper = FixedRateSettings {
        lambda_rad_s: LAMBDA_RAD_S,
        ..FixedRateSettings::paper(INTERVAL_S)
    };
    let improved = FixedRateSettings {
        initial_covariance: 1e6,
        ..FixedRateSettings::for_lambda(LAMBDA_RAD_S, INTERVAL_S)
    };
    let mixed = FixedRateSettings {
        filter_start: FilterStart::Zero,
        heading_hold: Hold::FirstOrder,
        ..paper
    };
    [paper, improved, mixed].into_iter()
}

/// Theta of the recursion after every sample.
fn recursion(settings: &FixedRateSettings<f64>, heading: &[f64], rudder: &[f64]) -> Vec<[f64; 3]> {
    let mut estimator = FixedRateEstimator::new(settings, heading[0], rudder[0]).unwrap();
    assert!(estimator.learn());
    let mut thetas = vec![estimator.model().theta()];
    for (heading, rudder) in heading[1..].iter().zip(&rudder[1..]) {
        assert!(estimator.update(*heading, *rudder));
        thetas.push(estimator.model().theta());
    }
    thetas
}

/// Theta and its distance from a reference, relative to the reference's largest parameter.
fn distance(found: [f64; 3], expected: [f64; 3]) -> f64 {
    let scale = expected.iter().fold(0.0, |m: f64, p| m.max(p.abs()));
    let pairs = found.iter().zip(expected);
    pairs.fold(0.0, |m: f64, (f, e)| m.max((f - e).abs())) / scale
}

/// Lengths below, at and above a tile of 8 x 128, in several tiles, and in stretches over which the state before them decays to nothing.
const LENGTHS: [usize; 8] = [1, 2, 330, 1024, 1025, 1026, 5000, 40_000];

#[test]
fn parity_sums_of_one_record_equal_the_recursion() {
    for settings in every_setting() {
        for samples in LENGTHS {
            let (heading, rudder) = signals(samples, 1);
            let expected = *recursion(&settings, &heading, &rudder).last().unwrap();
            let mut accumulator = Accumulator::new(&settings).unwrap();
            accumulator.extend(&heading, &rudder);
            let found = accumulator.sums().model(settings.initial_covariance);
            // Rounding of the recursion from P0 = 1e6 I: its first gains are a million times larger than the last.
            let apart = distance(found.unwrap().theta(), expected);
            assert!(samples < 330 || apart < 1e-9, "{samples}: {apart:e}");
        }
    }
}

#[test]
fn parity_a_record_in_pieces_is_the_record() {
    let settings = every_setting().next().unwrap();
    let (heading, rudder) = signals(9000, 2);
    let mut whole = Accumulator::new(&settings).unwrap();
    whole.extend(&heading, &rudder);
    let mut pieces = Accumulator::new(&settings).unwrap();
    let mut from = 0;
    for length in [0, 1, 2, 1500, 7, 1025, 4000, 2465] {
        pieces.extend(&heading[from..from + length], &rudder[from..from + length]);
        from += length;
    }
    assert_eq!(from, heading.len());
    let theta = |a: Accumulator<f64>| a.sums().model(100.0).unwrap().theta();
    // Nine thousand sums in another order.
    assert!(distance(theta(pieces), theta(whole)) < 1e-12);
}

#[test]
fn parity_every_theta_equals_the_recursion() {
    for settings in every_setting() {
        for samples in LENGTHS {
            let (heading, rudder) = signals(samples, 3);
            let expected = recursion(&settings, &heading, &rudder);
            let found = {
                let mut thetas = Vec::new();
                every_theta(&settings, &heading, &rudder, &mut thetas).unwrap();
                thetas
            };
            assert_eq!(found.len(), samples);
            // From where the rudder has been laid to both hands; before, the ridge of 1e-6 decides, and rounding.
            for (k, (found, expected)) in found.iter().zip(expected).enumerate().skip(160) {
                let apart = distance(*found, expected);
                assert!(apart < 1e-8, "{samples}, {k}: {apart:e}");
            }
        }
    }
}

#[test]
fn parity_many_records_equal_each_alone() {
    for settings in every_setting() {
        let (records, samples) = (19, 330);
        let (heading, rudder): (Vec<_>, Vec<_>) =
            (0..records).map(|seed| signals(samples, seed)).unzip();
        let sums = of_records(&settings, samples, &heading.concat(), &rudder.concat()).unwrap();
        assert_eq!(sums.len(), records as usize);
        for ((sums, heading), rudder) in sums.iter().zip(&heading).zip(&rudder) {
            let mut alone = Accumulator::new(&settings).unwrap();
            alone.extend(heading, rudder);
            let p = settings.initial_covariance;
            let expected = alone.sums().model(p).unwrap().theta();
            // 330 sums in another order.
            let apart = distance(sums.model(p).unwrap().theta(), expected);
            assert!(apart < 1e-12, "{apart:e}");
        }
    }
    let none = of_records::<f64>(
        &every_setting().next().unwrap(),
        330,
        &[0.0; 329],
        &[0.0; 700],
    );
    assert_eq!(none.unwrap(), []);
}

/// Least squares by Givens rotations on filters that take one sample after the other.
fn orthogonal(settings: &FixedRateSettings<f64>, heading: &[f64], rudder: &[f64]) -> [f64; 3] {
    let mut step = FilterStep::new(settings.lambda_rad_s);
    step.set_interval(settings.sample_interval_s);
    let mut yaw = StateVariableFilter::new(heading[0], settings.filter_start);
    let mut helm = StateVariableFilter::new(rudder[0], settings.filter_start);
    let mut batch = BatchLeastSquares::default();
    for (heading, rudder) in heading.iter().zip(rudder) {
        yaw.advance(*heading, settings.heading_hold, &step);
        helm.advance(*rudder, Hold::ZeroOrder, &step);
        let regressor = [yaw.first_derivative(&step), helm.smoothed(), 1.0];
        batch.add(regressor, yaw.second_derivative(&step));
    }
    batch.solve().unwrap().theta()
}

#[test]
fn parity_a_million_samples_stay_with_an_orthogonal_factorisation() {
    let settings = every_setting().nth(1).unwrap();
    let samples = 1_000_000;
    let (heading, rudder) = signals(samples, 4);
    // In f32 a heading that has gone round is precise to nothing: the course is held on the whole.
    let mean = heading.last().unwrap() / samples as f64;
    let heading: Vec<f64> = (heading.iter().enumerate())
        .map(|(k, w)| w - mean * k as f64)
        .collect();
    let expected = orthogonal(&settings, &heading, &rudder);
    let mut accumulator = Accumulator::new(&settings).unwrap();
    accumulator.extend(&heading, &rudder);
    let apart = distance(
        accumulator.sums().model(f64::INFINITY).unwrap().theta(),
        expected,
    );
    // A million roundings each, which partly average out.
    assert!(apart < 1e-11, "f64 {apart:e}");

    let single = |signal: &[f64]| -> Vec<f32> { signal.iter().map(|w| *w as f32).collect() };
    let (heading, rudder) = (single(&heading), single(&rudder));
    let double = |signal: &[f32]| -> Vec<f64> { signal.iter().map(|w| f64::from(*w)).collect() };
    let expected = orthogonal(&settings, &double(&heading), &double(&rudder));
    let mut accumulator = Accumulator::<f32>::new(&settings).unwrap();
    accumulator.extend(&heading, &rudder);
    let apart = distance(
        accumulator.sums().model(f64::INFINITY).unwrap().theta(),
        expected,
    );
    // Three roundings of f32, of which those of e^-x do not average out; sums of 128 in f32, those in f64, add nothing to it.
    assert!(apart < 5e-7, "f32 {apart:e}");
}

#[test]
fn parity_monte_carlo_runs_are_records_with_that_noise() {
    let settings = every_setting().nth(1).unwrap();
    let (heading, rudder) = signals(330, 5);
    let runs = NoisyRuns {
        heading_rad: &heading,
        rudder_rad: &rudder,
        heading_noise_rad: 0.02,
        seed: 0x1234_5678_9abc_def0,
        runs: 11,
    };
    let sums = monte_carlo(&settings, &runs).unwrap();
    assert_eq!(sums.len(), 11);
    for (run, sums) in sums.iter().enumerate() {
        let drawn = normals_of_run(runs.seed, run as u64, 330);
        let noisy: Vec<f64> = heading
            .iter()
            .zip(drawn)
            .map(|(w, z)| w + 0.02 * z)
            .collect();
        let mut alone = Accumulator::new(&settings).unwrap();
        alone.extend(&noisy, &rudder);
        let p = settings.initial_covariance;
        let expected = alone.sums().model(p).unwrap().theta();
        // 330 sums in another order.
        assert!(distance(sums.model(p).unwrap().theta(), expected) < 1e-12);
    }
}

#[test]
fn prop_without_excitation_or_with_not_a_number_there_is_no_model() {
    let settings = every_setting().nth(1).unwrap();
    for heading in [[0.3; 2000], [f64::NAN; 2000]] {
        let mut accumulator = Accumulator::new(&settings).unwrap();
        accumulator.extend(&heading, &[0.1; 2000]);
        assert_eq!(accumulator.sums().model(f64::INFINITY), None);
    }
    assert_eq!(
        Accumulator::<f64>::new(&settings).unwrap().sums().count,
        0.0
    );
    let wrong = FixedRateSettings {
        sample_interval_s: 0.0,
        ..settings
    };
    assert!(Accumulator::<f64>::new(&wrong).is_err());
}
