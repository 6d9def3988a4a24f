//! What this machine can do at best, measured beside the work.

use std::hint::black_box;

/// Time that this thread had a processor, so that what else runs counts for little.
pub fn processor_s() -> f64 {
    let mut time = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: the pointer is to a timespec of our own.
    unsafe { libc::clock_gettime(libc::CLOCK_THREAD_CPUTIME_ID, &mut time) };
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

/// Operations that wait for each other.
const CHAIN: u32 = 1_000_000;

/// Seconds that `step` takes in a chain of itself.
fn latency(step: impl Fn(f64) -> f64) -> f64 {
    let begin = processor_s();
    let mut value = black_box(1.000_000_1);
    for _ in 0..CHAIN / 10 {
        // Ten at a time, so that counting costs nothing.
        for _ in 0..10 {
            value = step(value);
        }
    }
    black_box(value);
    (processor_s() - begin) / f64::from(CHAIN)
}

pub fn multiply_s() -> f64 {
    let factor = black_box(1.000_000_1);
    latency(|value| value * factor)
}

pub fn add_s() -> f64 {
    let term = black_box(1e-9);
    latency(|value| value + term)
}

pub fn divide_s() -> f64 {
    let numerator = black_box(1.000_000_3);
    latency(|value| numerator / value)
}

/// `None` where the machine has no fused multiply-add.
pub fn fused_s() -> Option<f64> {
    #[target_feature(enable = "fma")]
    fn chain(factor: f64, term: f64) -> f64 {
        let begin = processor_s();
        let mut value = black_box(1.000_000_1);
        for _ in 0..CHAIN / 10 {
            for _ in 0..10 {
                value = f64::mul_add(value, factor, term);
            }
        }
        black_box(value);
        (processor_s() - begin) / f64::from(CHAIN)
    }
    std::arch::is_x86_feature_detected!("fma").then(|| {
        // SAFETY: the machine has what the function is compiled for.
        unsafe { chain(black_box(0.999_999), black_box(1e-6)) }
    })
}

/// Reads both signals once; their sum.
pub fn read(heading: &[f64], rudder: &[f64]) -> f64 {
    let mut sums = [0.0; 16];
    for (heading, rudder) in heading.chunks_exact(16).zip(rudder.chunks_exact(16)) {
        for ((sum, heading), rudder) in sums.iter_mut().zip(heading).zip(rudder) {
            *sum += heading + rudder;
        }
    }
    sums.iter().sum()
}
