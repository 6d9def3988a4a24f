//! Every bit that the guarded estimator answers, over clean and damaged streams: what makes it faster must not change any.

use seatrial_core::model::YawState;
use seatrial_core::{
    Estimator, EstimatorSettings, Hold, Intake, LostRudder, Method, Real, YawModel,
};

const SAMPLES: u32 = 3000;

/// FNV-1a of 64 bits.
struct Hash(u64);

impl Hash {
    fn bits(&mut self, bits: u64) {
        for byte in bits.to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    /// The sign of what is no number is the processor's, so that all of these count as one.
    fn number<T: Real>(&mut self, number: T) {
        let number = number.to_f64();
        self.bits(if number.is_nan() { f64::NAN.to_bits() } else { number.to_bits() });
    }

    fn numbers<T: Real>(&mut self, numbers: impl IntoIterator<Item = T>) {
        numbers.into_iter().for_each(|number| self.number(number));
    }

    fn optional<T: Real>(&mut self, number: Option<T>) {
        self.bits(u64::from(number.is_some()));
        self.numbers(number);
    }

    fn words(&mut self, value: impl std::fmt::Debug) {
        format!("{value:?}").bytes().for_each(|byte| self.bits(byte.into()));
    }

    fn estimator<T: Real>(&mut self, estimator: &Estimator<T>) {
        self.numbers(estimator.model().theta());
        self.numbers(estimator.least_squares_model().theta());
        self.numbers(estimator.covariance().into_iter().flatten());
        self.optional(estimator.restoring_per_s2());
        self.number(estimator.step_norm());
        self.optional(estimator.converged_s());
        let filtered = estimator.filtered();
        self.numbers([
            filtered.yaw_acceleration_rad_s2,
            filtered.yaw_rate_rad_s,
            filtered.rudder_rad,
        ]);
        if let Some(instrument) = estimator.instrument() {
            self.numbers(instrument.theta());
            self.numbers(instrument.covariance().into_iter().flatten());
        }
    }
}

/// Numbers in [0, 1), the same on every machine.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
        (self.0 >> 40) as f64 / f64::from(1 << 24)
    }

    fn happens(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }
}

/// What happens to the samples of a stream on their way.
#[derive(Clone, Copy, Debug)]
enum Damage {
    None,
    /// Every interval is another.
    Jitter,
    /// Time stamps in whole milliseconds, intervals of 20 to 80.
    Milliseconds,
    /// Rows lost one by one and many at a time, also over edges of the rudder.
    Lost,
    Repeated,
    Reversed,
    Spikes,
    NoNumbers,
    /// Silences so long that the filters start again.
    Gaps,
    /// The heading jumps for good, the clock is set.
    Jumps,
    /// Finite, but too large to compute with.
    Huge,
    /// Signed zeros only, for the first part.
    Zeros,
    /// All of it but what cannot be computed with.
    All,
}

const DAMAGES: [Damage; 13] = {
    use Damage::{
        All, Gaps, Huge, Jitter, Jumps, Lost, Milliseconds, NoNumbers, None, Repeated, Reversed,
        Spikes, Zeros,
    };
    [
        None,
        Jitter,
        Milliseconds,
        Lost,
        Repeated,
        Reversed,
        Spikes,
        NoNumbers,
        Gaps,
        Jumps,
        Huge,
        Zeros,
        All,
    ]
};

/// Time, heading, rudder; some samples are nowhere, some twice.
fn stream(damage: Damage, interval_s: f64, time_constant_s: f64) -> Vec<[f64; 3]> {
    let model = YawModel::from_theta([-1.0 / time_constant_s, 1.1 / time_constant_s.powi(2), 0.01]);
    let mut random = Random(7);
    let mut state = YawState { heading_rad: 2.9, yaw_rate_rad_s: 0.0 };
    let (mut now_s, mut clock_s, mut compass_rad) = (0.0, 0.0, 0.0);
    let mut lost = 0_u32;
    let mut samples = Vec::new();
    let is = |one: fn(Damage) -> bool| one(damage) || matches!(damage, Damage::All);
    for k in 0..SAMPLES {
        let rudder_rad = match k % 210 {
            40..80 => 0.26,
            80..120 => -0.26,
            150..160 => 0.01 * f64::from(k % 10),
            _ => -0.011,
        };
        let noise_rad = 0.002 * (random.unit() - 0.5);
        let mut sample = [
            now_s + clock_s,
            Real::wrapped(state.heading_rad + noise_rad + compass_rad),
            rudder_rad,
        ];
        let step_s = if is(|damage| matches!(damage, Damage::Jitter)) {
            interval_s * (0.6 + 0.8 * random.unit())
        } else if is(|damage| matches!(damage, Damage::Milliseconds)) {
            interval_s * ((20.0 + 60.0 * random.unit()).floor() * 0.001) / 0.05
        } else {
            interval_s
        };
        if is(|damage| matches!(damage, Damage::Lost)) && lost == 0 && random.happens(0.02) {
            lost = 1 + (random.unit().powi(3) * 12.0) as u32;
        }
        if is(|damage| matches!(damage, Damage::Spikes)) && random.happens(0.02) {
            sample[1] += 2.0;
        }
        if is(|damage| matches!(damage, Damage::NoNumbers)) && random.happens(0.02) {
            sample[(3.0 * random.unit()) as usize] =
                [f64::NAN, f64::INFINITY, f64::NEG_INFINITY][k as usize % 3];
        }
        if matches!(damage, Damage::Huge) && random.happens(0.004) {
            sample[1 + (2.0 * random.unit()) as usize] =
                [1e18, -1e30, 1e300, -1.7e308][k as usize % 4];
        }
        if matches!(damage, Damage::Zeros) && k < 300 {
            sample[1] = if random.happens(0.5) { -0.0 } else { 0.0 };
            sample[2] = if random.happens(0.5) { -0.0 } else { 0.0 };
        }
        if is(|damage| matches!(damage, Damage::Reversed)) && random.happens(0.02) {
            sample[0] -= 3.0 * interval_s;
        }
        if is(|damage| matches!(damage, Damage::Jumps)) && random.happens(0.003) {
            compass_rad += 1.5;
            clock_s -= 20.0 * interval_s * random.unit();
        }
        if lost == 0 {
            samples.push(sample);
            if is(|damage| matches!(damage, Damage::Repeated)) && random.happens(0.05) {
                samples.push(sample);
            }
        }
        lost = lost.saturating_sub(1);
        state = model.advance(state, rudder_rad, step_s);
        now_s += step_s;
        if is(|damage| matches!(damage, Damage::Gaps)) && random.happens(0.003) {
            now_s += 200.0 * interval_s;
        }
    }
    samples
}

/// Two speeds, each warmed, trained and left to the instrument.
fn hash<T: Real>(hash: &mut Hash, settings: EstimatorSettings<T>, samples: &[[f64; 3]]) {
    let mut estimator = Estimator::new(settings).unwrap();
    let speed = samples.len() / 2;
    for (k, [time_s, heading_rad, rudder_rad]) in samples.iter().enumerate() {
        if k == speed {
            estimator.restart();
        }
        if k % speed == 600 {
            estimator.excitation_ended();
        }
        let take_in = match k % speed < 100 {
            true => Estimator::warm,
            false => Estimator::update,
        };
        let intake = take_in(&mut estimator, *time_s, T::of(*heading_rad), T::of(*rudder_rad));
        hash.words(intake);
        hash.estimator(&estimator);
    }
    hash.words(estimator.rejected());
}

/// Settings with the interval and the time constant of the streams that go with them.
fn variants<T: Real>() -> Vec<(EstimatorSettings<T>, f64, f64)> {
    let improved = EstimatorSettings::<T>::default();
    let paper = EstimatorSettings::<T>::paper();
    vec![
        (improved, 0.05, 1.0),
        // x = lambda h above 0.5, where phi is no series.
        (improved, 0.4, 1.0),
        (improved, 0.002, 1.0),
        (EstimatorSettings { method: Method::LeastSquares, ..improved }, 0.05, 1.0),
        (EstimatorSettings { forgetting_factor: T::of(0.98), ..improved }, 0.05, 1.0),
        (EstimatorSettings { has_restoring_moment: true, ..improved }, 0.05, 1.0),
        (EstimatorSettings::for_time_scale(T::of(60.0)), 1.0, 60.0),
        (EstimatorSettings::for_time_scale(T::of(0.1)), 0.01, 0.1),
        (
            EstimatorSettings {
                lost_rudder: LostRudder::Held,
                heading_hold: Hold::ZeroOrder,
                ..improved
            },
            0.05,
            1.0,
        ),
        (paper, 0.05, 1.0),
        (EstimatorSettings { method: Method::InstrumentalVariable, ..paper }, 0.05, 1.0),
    ]
}

fn hashes<T: Real>() -> Vec<u64> {
    let over_streams = |(settings, interval_s, time_constant_s)| {
        let mut all = Hash(0xcbf2_9ce4_8422_2325);
        for damage in DAMAGES {
            hash(&mut all, settings, &stream(damage, interval_s, time_constant_s));
        }
        all.0
    };
    variants::<T>().into_iter().map(over_streams).collect()
}

/// The streams do what their names say: samples are refused for each cause, filters start again, edges are lost, and the instrument takes over.
#[test]
fn exact_streams_reach_every_branch() {
    let mut estimator = Estimator::new(EstimatorSettings::<f64>::default()).unwrap();
    let (mut used, mut warming) = (0, 0);
    for (k, [time_s, heading_rad, rudder_rad]) in
        stream(Damage::All, 0.05, 1.0).into_iter().enumerate()
    {
        if k == 600 {
            estimator.excitation_ended();
        }
        match estimator.update(time_s, heading_rad, rudder_rad) {
            Intake::Used => used += 1,
            Intake::Warming => warming += 1,
            Intake::Rejected(_) => {}
        }
    }
    let rejected = estimator.rejected();
    let counts = [
        rejected.non_finite,
        rejected.repeated_time,
        rejected.reversed_time,
        rejected.spike,
        rejected.gaps,
        rejected.discontinuities,
        used,
        warming,
    ];
    assert!(counts.iter().all(|count| *count > 0), "{counts:?}");
    assert!(estimator.instrument().is_some());
}

/// Recorded with the recursion written out, without any of what is skipped or taken together since.
#[test]
fn regress_every_bit_f64() {
    let recorded: [u64; 11] = [
        0x4f6d_1e83_6f5b_72f6,
        0x282e_1af9_98c3_d957,
        0x03a7_5110_42b6_7c94,
        0x6ca0_5a4f_49ea_c6b6,
        0x74a0_8727_e7c7_89f4,
        0xce16_1075_dd4e_a46f,
        0x6617_b77a_c159_9ee5,
        0xd50b_2875_0039_3d7f,
        0xf34a_c29e_eb2d_f68b,
        0x88aa_0908_b476_54bd,
        0x8080_2a7b_bf8c_d8df,
    ];
    assert_eq!(hashes::<f64>(), recorded);
}

#[test]
fn regress_every_bit_f32() {
    let recorded: [u64; 11] = [
        0x5567_8619_1774_07f9,
        0xef34_668f_ddff_0915,
        0x3a26_50ca_357d_9619,
        0xd4b6_6297_014d_6d71,
        0xf28f_b732_d45b_e4e5,
        0x7c74_b131_c631_8753,
        0x660d_2ca1_a0c3_b84c,
        0xece0_022e_f022_5a2b,
        0x7f71_48b3_001a_b7bf,
        0x8b9d_801a_4707_f299,
        0xa630_912e_d2c7_2fe1,
    ];
    assert_eq!(hashes::<f32>(), recorded);
}
