//! Time, memory and rounding over streams of up to a thousand million samples.

use std::hint::black_box;

use seatrial::identify::batch::BatchLeastSquares;
use seatrial_core::FixedRateSettings;
use seatrial_core::state_variable_filter::{FilterStep, Hold, StateVariableFilter};
use seatrial_kernels::Accumulator;
use serde_json::json;

use crate::signals::Signals;
use crate::{LONG, Outcome, machine, online};

/// The longest stream of the recursion, which takes twenty times the time of the kernel, in millions.
const MOST_ONLINE_MILLIONS: i32 = 100;

/// Streams of growing length, of which nothing is kept.
pub fn growth(settings: &FixedRateSettings<f64>, signals: &Signals) -> Outcome<String> {
    let mut text = String::from(
        "\n| samples, streamed | batch, ns a sample | online (to 100e6), ns a sample | peak memory, MB |\n|---|---|---|---|\n",
    );
    for millions in [1, 10, 100, 1000] {
        let begin = machine::processor_s();
        let mut accumulator = Accumulator::new(settings)?;
        for _ in 0..millions {
            accumulator.extend(&signals.heading, &signals.rudder);
        }
        black_box(accumulator.sums());
        let count = f64::from(millions) * LONG as f64;
        let batch_ns = (machine::processor_s() - begin) * 1e9 / count;
        let begin = machine::processor_s();
        let online_millions = millions.min(MOST_ONLINE_MILLIONS);
        for _ in 0..online_millions {
            black_box(online::ours(settings, &signals.heading, &signals.rudder));
        }
        let online_count = f64::from(online_millions) * LONG as f64;
        let online_ns = (machine::processor_s() - begin) * 1e9 / online_count;
        let peak_mb = machine::peak_mb();
        println!(
            "{}",
            json!({"samples": count, "batch_ns": batch_ns, "online_ns": online_ns, "peak_mb": peak_mb})
        );
        text += &format!(
            "| {millions}e6 | {batch_ns:.2} | {online_ns:.2} | {:.0} |\n",
            peak_mb.unwrap_or(f64::NAN)
        );
    }
    Ok(text)
}

/// How far sums are from Givens rotations after a million samples.
pub fn drift(settings: &FixedRateSettings<f64>, signals: &Signals) -> Outcome<String> {
    fn sums<T: seatrial_kernels::Lane>(
        settings: &FixedRateSettings<f64>,
        heading: &[T],
        rudder: &[T],
    ) -> Outcome<[f64; 3]> {
        let mut accumulator = Accumulator::<T>::new(settings)?;
        accumulator.extend(heading, rudder);
        let model = accumulator.sums().model(f64::INFINITY);
        Ok(model.ok_or("not excited")?.theta())
    }
    let reference = |heading: &[f64], rudder: &[f64]| -> Outcome<[f64; 3]> {
        let mut step = FilterStep::new(settings.lambda_rad_s);
        step.set_interval(settings.sample_interval_s);
        let mut yaw = StateVariableFilter::new(heading[0], settings.filter_start);
        let mut helm = StateVariableFilter::new(rudder[0], settings.filter_start);
        let mut batch = BatchLeastSquares::default();
        for (k, (heading, rudder)) in heading.iter().zip(rudder).enumerate() {
            if k > 0 {
                yaw.advance(*heading, Hold::ZeroOrder, &step);
                helm.advance(*rudder, Hold::ZeroOrder, &step);
            }
            let regressor = [yaw.first_derivative(&step), helm.smoothed(), 1.0];
            batch.add(regressor, yaw.second_derivative(&step));
        }
        Ok(batch.solve().ok_or("not excited")?.theta())
    };
    let apart = |a: [f64; 3], b: [f64; 3]| {
        let scale = b.iter().fold(0.0, |m: f64, p| m.max(p.abs()));
        a.iter()
            .zip(b)
            .fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()))
            / scale
    };
    let (heading, rudder) = (&signals.heading, &signals.rudder);
    let double = apart(
        sums(settings, heading, rudder)?,
        reference(heading, rudder)?,
    );
    let heading32: Vec<f32> = heading.iter().map(|w| *w as f32).collect();
    let rudder32: Vec<f32> = rudder.iter().map(|d| *d as f32).collect();
    let heading: Vec<f64> = heading32.iter().map(|w| f64::from(*w)).collect();
    let rudder: Vec<f64> = rudder32.iter().map(|d| f64::from(*d)).collect();
    let single = apart(
        sums(settings, &heading32, &rudder32)?,
        reference(&heading, &rudder)?,
    );
    println!("{}", json!({"drift_f64": double, "drift_f32": single}));
    Ok(format!(
        "\nDrift of Theta from Givens rotations in f64 at 1e6 samples: f64 {double:.1e} (goal 1e-11), f32 {single:.1e} (goal 1e-4).\n"
    ))
}
