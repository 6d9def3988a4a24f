//! Prints what the core costs on this processor: lines of name, quantity and value.
#![no_std]
#![no_main]

use core::fmt::{self, Write};
use core::hint::black_box;

use cortex_m_rt::entry;
use seatrial_core::{
    Action, Estimator, EstimatorSettings, FixedRateEstimator, FixedRateSettings, Intake, Real,
    Sample, Trial,
};
use seatrial_firmware::meter::{Cost, Meter};
use seatrial_firmware::{Console, finish};

#[unsafe(no_mangle)]
fn fixed_rate_step(
    estimator: &mut FixedRateEstimator<f32>,
    heading_rad: f32,
    rudder_rad: f32,
) -> bool {
    estimator.update(heading_rad, rudder_rad)
}

#[unsafe(no_mangle)]
fn timed_step(
    estimator: &mut FixedRateEstimator<f32>,
    interval_s: f32,
    heading_rad: f32,
    rudder_rad: f32,
) -> bool {
    estimator.set_interval(interval_s) && estimator.update(heading_rad, rudder_rad)
}

fn fixed_rate_step_f64(
    estimator: &mut FixedRateEstimator<f64>,
    heading_rad: f64,
    rudder_rad: f64,
) -> bool {
    estimator.update(heading_rad, rudder_rad)
}

#[entry]
fn main() -> ! {
    finish(report())
}

fn report() -> fmt::Result {
    let mut out = Console::open();
    let meter = Meter::start().ok_or(fmt::Error)?;
    lean(&mut out, &meter)?;
    guarded::<f32>(&mut out, &meter, "estimator_step_f32")?;
    guarded::<f64>(&mut out, &meter, "estimator_step_f64")?;
    executive::<f32>(&mut out, &meter, "trial_step_f32")?;
    executive::<f64>(&mut out, &meter, "trial_step_f64")
}

/// Headings that wrap and a rudder that moves, as in the rehearsal.
fn headings<T: Real>(mut each: impl FnMut(&Sample<T>)) -> fmt::Result {
    seatrial_parity::rehearse::<T>(|sample, trial| {
        if sample.heading_rad.is_finite() {
            each(sample);
        }
        Ok(trial.step(sample))
    })
}

fn lean(out: &mut Console, meter: &Meter) -> fmt::Result {
    let settings = FixedRateSettings::<f32>::for_lambda(1.5, 0.05);
    let single = || FixedRateEstimator::new(&settings, 3.1, 0.0).map_err(|_| fmt::Error);
    let (mut fixed, mut timed) = (single()?, single()?);
    let step = black_box(fixed_rate_step as fn(&mut _, f32, f32) -> bool);
    let step_in = black_box(timed_step as fn(&mut _, f32, f32, f32) -> bool);
    let (mut most, mut most_timed) = (Cost::default(), Cost::default());
    let mut learnt = true;
    headings::<f32>(|sample| {
        let (heading_rad, rudder_rad) = (sample.heading_rad, sample.rudder_rad);
        most.raise(meter.cost(|| learnt &= step(&mut fixed, heading_rad, rudder_rad)));
        most_timed
            .raise(meter.cost(|| learnt &= step_in(&mut timed, 0.05, heading_rad, rudder_rad)));
    })?;
    if !learnt {
        return Err(fmt::Error);
    }
    let bytes = size_of::<FixedRateEstimator<f32>>();
    table(out, "fixed_rate_step", most, bytes)?;
    table(out, "timed_step", most_timed, bytes)?;

    let settings = FixedRateSettings::for_lambda(1.5, 0.05);
    let mut double = FixedRateEstimator::new(&settings, 3.1, 0.0).map_err(|_| fmt::Error)?;
    let step = black_box(fixed_rate_step_f64 as fn(&mut _, f64, f64) -> bool);
    let mut most = Cost::default();
    headings::<f64>(|sample| {
        most.raise(meter.cost(|| {
            black_box(step(&mut double, sample.heading_rad, sample.rudder_rad));
        }));
    })?;
    let bytes = size_of::<FixedRateEstimator<f64>>();
    table(out, "fixed_rate_step_f64", most, bytes)
}

fn guarded<T: Real>(out: &mut Console, meter: &Meter, name: &str) -> fmt::Result {
    let mut estimator =
        Estimator::new(EstimatorSettings::<T>::default()).map_err(|_| fmt::Error)?;
    let step = black_box(Estimator::update as fn(&mut Estimator<T>, f64, T, T) -> Intake);
    let mut most = Cost::default();
    seatrial_parity::rehearse::<T>(|sample, trial| {
        if trial.estimator().instrument().is_some() {
            estimator.excitation_ended();
        }
        most.raise(meter.cost(|| {
            let (heading_rad, rudder_rad) = (sample.heading_rad, sample.rudder_rad);
            let _ = black_box(step(&mut estimator, sample.time_s, heading_rad, rudder_rad));
        }));
        Ok(trial.step(sample))
    })?;
    table(out, name, most, size_of::<Estimator<T>>())
}

fn executive<T: Real>(out: &mut Console, meter: &Meter, name: &str) -> fmt::Result {
    let step = black_box(Trial::step as fn(&mut Trial<T>, &Sample<T>) -> Action<T>);
    let mut most = Cost::default();
    let (mut sum, mut steps) = (0_u32, 0_u32);
    seatrial_parity::rehearse::<T>(|sample, trial| {
        let mut action = None;
        let cost = meter.cost(|| action = Some(step(trial, sample)));
        most.raise(cost);
        sum = sum.saturating_add(cost.instructions);
        steps += 1;
        action.ok_or(fmt::Error)
    })?;
    line(out, name, "mean_instructions", sum.checked_div(steps).unwrap_or(0))?;
    table(out, name, most, size_of::<Trial<T>>())
}

fn table(out: &mut Console, name: &str, most: Cost, state_bytes: usize) -> fmt::Result {
    line(out, name, "instructions", most.instructions)?;
    line(out, name, "stack_bytes", most.stack_bytes)?;
    line(out, name, "state_bytes", state_bytes as u32)
}

fn line(out: &mut Console, name: &str, quantity: &str, value: u32) -> fmt::Result {
    for text in [name, ",", quantity, ","] {
        out.write_str(text)?;
    }
    let mut digits = [0_u8; 10];
    let mut rest = value;
    for digit in digits.iter_mut().rev() {
        *digit = (rest % 10) as u8;
        rest /= 10;
    }
    let mut leading = true;
    for (place, digit) in digits.into_iter().enumerate() {
        leading &= digit == 0 && place < 9;
        if !leading {
            out.write_char(char::from(b'0' + digit))?;
        }
    }
    out.write_char('\n')
}
