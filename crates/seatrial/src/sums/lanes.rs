//! Several stretches of signals filtered and summed side by side.

use pulp::{Simd, WithSimd};
use seatrial_core::Real;
use seatrial_core::fixed_rate::FixedRateSettings;
use seatrial_core::model::phi;
use seatrial_core::state_variable_filter::{FilterStart, Hold};

/// A number of which a vector register holds several.
pub trait Lane: Real {
    /// a b + c, rounded once.
    fn fused(a: Self, b: Self, c: Self) -> Self;
    /// Runs `work` with as many lanes as suit this number and with the widest instructions that this machine has.
    fn dispatch<W: Work<Self>>(work: W) -> W::Output;
}

/// Something to be done in lanes.
pub trait Work<T> {
    /// What it gives.
    type Output;
    /// `FUSED`: the machine has a fused multiply-add, without which it would be slow.
    fn run<const N: usize, const FUSED: bool>(self) -> Self::Output;
}

macro_rules! lane {
    ($type:ident, $lanes:literal) => {
        impl Lane for $type {
            #[inline(always)]
            fn fused(a: Self, b: Self, c: Self) -> Self {
                a.mul_add(b, c)
            }

            fn dispatch<W: Work<Self>>(work: W) -> W::Output {
                struct Dispatched<W>(W);

                impl<W: Work<$type>> WithSimd for Dispatched<W> {
                    type Output = W::Output;

                    #[inline(always)]
                    fn with_simd<S: Simd>(self, _simd: S) -> W::Output {
                        if S::IS_SCALAR {
                            self.0.run::<$lanes, false>()
                        } else {
                            self.0.run::<$lanes, true>()
                        }
                    }
                }
                pulp::Arch::new().dispatch(Dispatched(work))
            }
        }
    };
}

lane!(f64, 8);
lane!(f32, 16);

/// a b + c, rounded once where that is as fast.
#[inline(always)]
pub(super) fn multiply_add<T: Lane, const FUSED: bool>(a: T, b: T, c: T) -> T {
    if FUSED { T::fused(a, b, c) } else { a * b + c }
}

/// The filter (16)-(31) for signals scaled so that one step takes the fewest operations.
///
/// ```text
/// u_k = e u_{k-1} + w_k - w_{k-1},    v_k = e v_{k-1} + u_{k-1} + g (w_k - w_{k-1})     the heading w
/// q_k = e q_{k-1} + d_{k-1},          p_k = e p_{k-1} + q_{k-1} + k d_{k-1}             the rudder d
/// psi''_f = lambda^2 b (u - c v),     psi'_f = lambda c b v,     delta_f = c (1 - e) p
/// ```
///
/// with x = lambda h, e = e^-x, c = x e, and phi1, phi2 of -x as in [`phi`]: k = (phi1 - phi2)/(e phi1); b = 1 and
/// g = 0 where the heading is held, b = phi1 and g = k where it runs on straight lines. Up to scale these are u, v of
/// [`StateVariableFilter`](seatrial_core::StateVariableFilter) for the heading and its two lags themselves for the rudder.
#[derive(Clone, Copy)]
pub(super) struct Coefficients<T> {
    pub decay: T,
    pub coupling: T,
    pub heading_ramp: T,
    pub rudder_ramp: T,
}

/// What takes the scaled signals to those of the model.
#[derive(Clone, Copy)]
pub(super) struct Scales {
    pub acceleration: f64,
    pub rate: f64,
    pub rudder: f64,
}

impl Scales {
    fn of(settings: &FixedRateSettings<f64>) -> Self {
        let lambda = settings.lambda_rad_s;
        let x = lambda * settings.sample_interval_s;
        let (phi1, _) = phi(-x);
        let held = match settings.heading_hold {
            Hold::ZeroOrder => 1.0,
            Hold::FirstOrder => phi1,
        };
        let coupling = x * Real::exp(-x);
        Self {
            acceleration: lambda * lambda * held,
            rate: lambda * coupling * held,
            rudder: coupling * x * phi1,
        }
    }
}

/// The filters' state, scaled, in every lane.
#[derive(Clone, Copy)]
pub(super) struct State<T, const N: usize> {
    pub heading: [T; N],
    pub deviation: [T; N],
    pub lag: [T; N],
    pub rudder: [T; N],
    pub rudder_once: [T; N],
    pub rudder_twice: [T; N],
}

/// Sums of u', v, p and their products, u' = u - c v, in every lane.
#[derive(Clone, Copy)]
pub(super) struct Products<T, const N: usize>(pub [[T; N]; 8]);

/// Filters for one setting: coefficients, scales and where they start.
#[derive(Clone, Copy)]
pub(super) struct Filter<T> {
    pub coefficients: Coefficients<T>,
    pub scales: Scales,
    start: FilterStart,
    /// 1/b.
    held_inverse: T,
}

impl<T: Lane> Filter<T> {
    /// `settings` are valid.
    pub fn new(settings: &FixedRateSettings<f64>) -> Self {
        let x = settings.lambda_rad_s * settings.sample_interval_s;
        let (phi1, phi2) = phi(-x);
        let decay = Real::exp(-x);
        let ramp = (phi1 - phi2) / (decay * phi1);
        let (held, heading_ramp) = match settings.heading_hold {
            Hold::ZeroOrder => (1.0, 0.0),
            Hold::FirstOrder => (phi1, ramp),
        };
        Self {
            coefficients: Coefficients {
                decay: T::of(decay),
                coupling: T::of(x * decay),
                heading_ramp: T::of(heading_ramp),
                rudder_ramp: T::of(ramp),
            },
            scales: Scales::of(settings),
            start: settings.filter_start,
            held_inverse: T::of(1.0 / held),
        }
    }

    /// At the first samples.
    #[inline(always)]
    pub fn started<const N: usize>(&self, heading: &[T; N], rudder: &[T; N]) -> State<T, N> {
        let zero = [T::ZERO; N];
        let (once, twice) = (
            T::of(1.0 / (1.0 - self.coefficients.decay.to_f64())),
            T::of(1.0 / self.scales.rudder),
        );
        match self.start {
            FilterStart::Zero => State {
                heading: *heading,
                deviation: heading.map(|w| w * self.held_inverse),
                lag: zero,
                rudder: *rudder,
                rudder_once: zero,
                rudder_twice: zero,
            },
            FilterStart::Equilibrium => State {
                heading: *heading,
                deviation: zero,
                lag: zero,
                rudder: *rudder,
                rudder_once: rudder.map(|d| d * once),
                rudder_twice: rudder.map(|d| d * twice),
            },
        }
    }
}

impl<T: Lane, const N: usize> Products<T, N> {
    pub const ZERO: Self = Self([[T::ZERO; N]; 8]);

    /// Adds what the filters of every lane give now.
    #[inline(always)]
    pub fn add<const FUSED: bool>(&mut self, state: &State<T, N>, c: &Coefficients<T>) {
        let [
            rate,
            rudder,
            acceleration,
            rate2,
            rate_rudder,
            rudder2,
            rate_acc,
            rudder_acc,
        ] = &mut self.0;
        for j in 0..N {
            let (v, p) = (state.lag[j], state.rudder_twice[j]);
            let u = multiply_add::<T, FUSED>(-c.coupling, v, state.deviation[j]);
            rate[j] += v;
            rudder[j] += p;
            acceleration[j] += u;
            rate2[j] = multiply_add::<T, FUSED>(v, v, rate2[j]);
            rate_rudder[j] = multiply_add::<T, FUSED>(v, p, rate_rudder[j]);
            rudder2[j] = multiply_add::<T, FUSED>(p, p, rudder2[j]);
            rate_acc[j] = multiply_add::<T, FUSED>(v, u, rate_acc[j]);
            rudder_acc[j] = multiply_add::<T, FUSED>(p, u, rudder_acc[j]);
        }
    }

    /// The sums of all lanes together, in double precision.
    pub fn total(&self) -> [f64; 8] {
        self.0.map(|sums| sums.map(Real::to_f64).iter().sum())
    }
}

impl<T: Lane, const N: usize> State<T, N> {
    /// Takes in the next sample of every lane.
    #[inline(always)]
    pub fn advance<const FUSED: bool>(
        &mut self,
        heading: &[T; N],
        rudder: &[T; N],
        c: &Coefficients<T>,
    ) {
        for (j, (heading, laid)) in heading.iter().zip(&self.rudder).enumerate() {
            let turned = *heading - self.heading[j];
            let lag = multiply_add::<T, FUSED>(c.heading_ramp, turned, self.deviation[j]);
            self.lag[j] = multiply_add::<T, FUSED>(c.decay, self.lag[j], lag);
            self.deviation[j] = multiply_add::<T, FUSED>(c.decay, self.deviation[j], turned);
            let twice = multiply_add::<T, FUSED>(c.rudder_ramp, *laid, self.rudder_once[j]);
            self.rudder_twice[j] = multiply_add::<T, FUSED>(c.decay, self.rudder_twice[j], twice);
            self.rudder_once[j] = multiply_add::<T, FUSED>(c.decay, self.rudder_once[j], *laid);
        }
        self.heading = *heading;
        self.rudder = *rudder;
    }
}

/// Rows side by side: `columns[i][j]` is the sample i of row j.
#[inline(always)]
pub(super) fn transpose<'a, T: Lane, const N: usize>(
    rows: impl Iterator<Item = &'a [T]>,
    columns: &mut [[T; N]],
) {
    for (j, row) in rows.enumerate().take(N) {
        for (column, value) in columns.iter_mut().zip(row) {
            column[j] = *value;
        }
    }
}
