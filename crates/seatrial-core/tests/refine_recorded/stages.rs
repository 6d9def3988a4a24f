//! Simulated training stages of all kinds, the same on every machine.

use libm::{cos, exp, log, sqrt};

/// Intervals, headings and rudder of a stage, as `Series` takes them.
pub struct Stage {
    pub interval_s: Vec<f64>,
    pub heading_rad: Vec<f64>,
    pub rudder_rad: Vec<f64>,
}

/// splitmix64
struct Random(u64);

impl Random {
    /// In 0..1.
    fn share(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
        ((z >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.share()
    }

    /// Any order of magnitude alike.
    fn of_scale(&mut self, low: f64, high: f64) -> f64 {
        exp(self.between(log(low), log(high)))
    }

    fn normal(&mut self) -> f64 {
        let radius = sqrt(-2.0 * log(self.share()));
        radius * cos(core::f64::consts::TAU * self.share())
    }

    fn one_of<const N: usize>(&mut self, of: [f64; N]) -> f64 {
        of[(self.share() * N as f64) as usize]
    }
}

/// A vehicle and how it is looked at.
struct Vehicle {
    a22_per_s: f64,
    b2_per_s2: f64,
    c0_rad_per_s2: f64,
    noise_rad: f64,
    disturbance_rad_s2: f64,
    disturbance_time_s: f64,
    /// Steps in which the compass reads, rad; 0 for none.
    step_rad: f64,
    /// Time constant of the rudder, s; 0 where it acts at once.
    lag_s: f64,
    rate_rad_s: f64,
}

/// Rudder to one side and the other.
struct Manoeuvre {
    begin_s: f64,
    leg_s: f64,
    legs: f64,
    amplitude_rad: f64,
}

impl Manoeuvre {
    fn rudder_rad(&self, time_s: f64) -> f64 {
        let leg = (time_s - self.begin_s) / self.leg_s;
        match leg {
            leg if leg < 0.0 || leg >= self.legs => 0.0,
            leg if (leg as u32).is_multiple_of(2) => self.amplitude_rad,
            _ => -self.amplitude_rad,
        }
    }
}

/// The stage of a number: noise of 0.05 to 1 deg, disturbances up to 0.02 rad/s^2, a22 of -0.3 to -3 1/s, clocks that are even, that jitter and
/// that lose samples, 60 to 1500 samples, and rudders too small to learn from.
pub fn stage(number: u64) -> Stage {
    let mut random = Random(number.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x2545_f491_4f6c_dd1d);
    let damping_per_s = random.of_scale(0.3, 3.0);
    let in_time_constants = |time: f64| time / damping_per_s;
    let mut vehicle = Vehicle {
        a22_per_s: -damping_per_s,
        b2_per_s2: damping_per_s * random.between(0.5, 2.0),
        c0_rad_per_s2: random.between(-0.02, 0.02),
        noise_rad: random.of_scale(0.05, 1.0).to_radians(),
        disturbance_rad_s2: random.one_of([0.0, 0.001, 0.004, 0.01, 0.02]),
        disturbance_time_s: in_time_constants(random.of_scale(0.3, 10.0)),
        step_rad: 0.0,
        lag_s: 0.0,
        rate_rad_s: 0.0,
    };
    let jitter = random.one_of([0.0, 0.0, 1e-8, 0.02, 0.3]);
    let lost = random.one_of([0.0, 0.0, 0.0, 0.02]);
    vehicle.step_rad = random.one_of([0.0, 0.0, 0.1, 1.0]).to_radians();
    vehicle.lag_s = in_time_constants(random.one_of([0.0, 0.0, 0.1, 0.3]));
    let amplitude_rad = random.one_of([0.26, 0.26, 0.15, 0.05, 0.01, 0.002]);
    let samples = random.of_scale(60.0, 1500.0) as usize;
    let usual_s = in_time_constants(random.between(8.0, 30.0)) / samples as f64;
    let manoeuvre = Manoeuvre {
        amplitude_rad,
        legs: random.one_of([2.0, 2.0, 3.0, 5.0]),
        leg_s: in_time_constants(random.between(1.5, 4.0)),
        begin_s: in_time_constants(random.between(0.5, 3.0)),
    };
    vehicle.rate_rad_s = random.one_of([0.0, 0.0, 0.05]);
    let intervals = (0..samples).map(|_| {
        let mut interval_s = usual_s * (1.0 + jitter * (random.share() - 0.5));
        while random.share() < lost {
            interval_s += usual_s;
        }
        interval_s
    });
    let interval_s = intervals.collect();
    simulated(&vehicle, &manoeuvre, interval_s, &mut random)
}

fn simulated(
    vehicle: &Vehicle,
    manoeuvre: &Manoeuvre,
    mut interval_s: Vec<f64>,
    random: &mut Random,
) -> Stage {
    /// Steps in which rudder and disturbance change within a sample interval.
    const STEPS: u32 = 8;
    let a22 = vehicle.a22_per_s;
    let (mut psi, mut r, mut acting, mut time_s) = (0.0, vehicle.rate_rad_s, 0.0, 0.0);
    let mut d = vehicle.disturbance_rad_s2 * random.normal();
    let (mut heading_rad, mut rudder_rad) = (Vec::new(), Vec::new());
    for interval_s in &interval_s {
        let rudder = manoeuvre.rudder_rad(time_s);
        let measured = psi + vehicle.noise_rad * random.normal();
        heading_rad.push(match vehicle.step_rad > 0.0 {
            true => f64::round(measured / vehicle.step_rad) * vehicle.step_rad,
            false => measured,
        });
        rudder_rad.push(rudder);
        let h = interval_s / f64::from(STEPS);
        let decay = exp(a22 * h);
        let gain = (decay - 1.0) / a22;
        let memory = exp(-h / vehicle.disturbance_time_s);
        let follow = match vehicle.lag_s > 0.0 {
            true => 1.0 - exp(-h / vehicle.lag_s),
            false => 1.0,
        };
        for _ in 0..STEPS {
            acting += follow * (rudder - acting);
            let u = vehicle.b2_per_s2 * acting + vehicle.c0_rad_per_s2 + d;
            psi += gain * r + (gain - h) / a22 * u;
            r = decay * r + gain * u;
            let new = vehicle.disturbance_rad_s2 * sqrt(1.0 - memory * memory);
            d = memory * d + new * random.normal();
        }
        time_s += interval_s;
    }
    if let Some(last) = interval_s.last_mut() {
        *last = 0.0;
    }
    let first = heading_rad[0];
    heading_rad.iter_mut().for_each(|heading| *heading -= first);
    Stage { interval_s, heading_rad, rudder_rad }
}
