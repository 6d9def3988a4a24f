//! Several stretches of signals filtered and summed side by side.

use core::ops::{Add, Mul, Sub};

use pulp::bytemuck::{self, Pod};
use pulp::{Scalar, Simd};
use seatrial_core::Real;
use seatrial_core::fixed_rate::FixedRateSettings;
use seatrial_core::model::phi;
use seatrial_core::state_variable_filter::{FilterStart, Hold};

/// A number of which a vector register holds several.
pub trait Lane: Real + Pod {
    /// A register full of them.
    type Register<S: Simd>: Pod;
    /// One number in every lane.
    fn splat<S: Simd>(simd: S, value: Self) -> Self::Register<S>;
    /// a + b
    fn plus<S: Simd>(simd: S, a: Self::Register<S>, b: Self::Register<S>) -> Self::Register<S>;
    /// a - b
    fn minus<S: Simd>(simd: S, a: Self::Register<S>, b: Self::Register<S>) -> Self::Register<S>;
    /// a b
    fn times<S: Simd>(simd: S, a: Self::Register<S>, b: Self::Register<S>) -> Self::Register<S>;
    /// a b + c, rounded once where that is as fast.
    fn fused<S: Simd>(
        simd: S,
        a: Self::Register<S>,
        b: Self::Register<S>,
        c: Self::Register<S>,
    ) -> Self::Register<S>;
    /// Fours that lie one behind the other, as their first, second, third and last numbers.
    fn columns<S: Simd>(simd: S, fours: [Self::Register<S>; 4]) -> [Self::Register<S>; 4];
    /// The way back from [`columns`](Self::columns).
    fn fours<S: Simd>(simd: S, columns: [Self::Register<S>; 4]) -> [Self::Register<S>; 4];
}

macro_rules! lane {
    ($type:ident, $register:ident, $splat:ident, $add:ident, $sub:ident, $mul:ident, $fused:ident, $columns:ident, $fours:ident) => {
        impl Lane for $type {
            type Register<S: Simd> = S::$register;

            #[inline(always)]
            fn splat<S: Simd>(simd: S, value: Self) -> S::$register {
                simd.$splat(value)
            }

            #[inline(always)]
            fn plus<S: Simd>(simd: S, a: S::$register, b: S::$register) -> S::$register {
                simd.$add(a, b)
            }

            #[inline(always)]
            fn minus<S: Simd>(simd: S, a: S::$register, b: S::$register) -> S::$register {
                simd.$sub(a, b)
            }

            #[inline(always)]
            fn times<S: Simd>(simd: S, a: S::$register, b: S::$register) -> S::$register {
                simd.$mul(a, b)
            }

            #[inline(always)]
            fn fused<S: Simd>(
                simd: S,
                a: S::$register,
                b: S::$register,
                c: S::$register,
            ) -> S::$register {
                simd.$fused(a, b, c)
            }

            #[inline(always)]
            fn columns<S: Simd>(simd: S, fours: [S::$register; 4]) -> [S::$register; 4] {
                simd.$columns(fours)
            }

            #[inline(always)]
            fn fours<S: Simd>(simd: S, columns: [S::$register; 4]) -> [S::$register; 4] {
                simd.$fours(columns)
            }
        }
    };
}

lane!(
    f64,
    f64s,
    splat_f64s,
    add_f64s,
    sub_f64s,
    mul_f64s,
    mul_add_e_f64s,
    deinterleave_shfl_f64s,
    interleave_shfl_f64s
);
lane!(
    f32,
    f32s,
    splat_f32s,
    add_f32s,
    sub_f32s,
    mul_f32s,
    mul_add_e_f32s,
    deinterleave_shfl_f32s,
    interleave_shfl_f32s
);

/// The most lanes that a register has, sixteen `f32` in 512 bits.
pub(crate) const MOST_LANES: usize = 16;

/// Samples of every row that are taken together where there are as many.
pub(crate) const TOGETHER: usize = 32;

/// Samples whose products are added up in the signals' own precision.
pub(crate) const BLOCK: usize = 128;

/// The next `N` numbers of every row: of a length that is known none is checked for its end.
pub(crate) type Rows<'a, T, const N: usize> = [&'a [T; N]; MOST_LANES];

/// From number `from` on the next `N` of rows of `length`, one behind the other; of fewer rows than lanes the last is taken again.
#[inline(always)]
pub(crate) fn rows<S: Simd, T: Lane, const N: usize>(
    numbers: &[T],
    length: usize,
    from: usize,
) -> Option<Rows<'_, T, N>> {
    if from + N > length {
        return None;
    }
    let last = (numbers.len() / length).checked_sub(1)?;
    let mut rows = [numbers.get(from..)?.first_chunk()?; MOST_LANES];
    for (row, place) in rows.iter_mut().enumerate().take(Lanes::<S, T>::COUNT) {
        *place = numbers
            .get(row.min(last) * length + from..)?
            .first_chunk()?;
    }
    Some(rows)
}

/// Numbers side by side in a register of the machine `S`; [`Scalar`] has one lane.
#[derive(Clone, Copy)]
pub(crate) struct Lanes<S: Simd, T: Lane> {
    pub simd: S,
    pub register: T::Register<S>,
}

impl<S: Simd, T: Lane> Lanes<S, T> {
    pub const COUNT: usize = size_of::<T::Register<S>>() / size_of::<T>();

    #[inline(always)]
    pub fn splat(simd: S, value: T) -> Self {
        Self {
            simd,
            register: T::splat(simd, value),
        }
    }

    /// Number j of what is asked for in lane j.
    #[inline(always)]
    pub fn from_fn(simd: S, number: impl Fn(usize) -> T) -> Self {
        let mut lanes = Self::splat(simd, T::ZERO);
        let numbers = bytemuck::cast_slice_mut(core::slice::from_mut(&mut lanes.register));
        for (j, lane) in numbers.iter_mut().enumerate() {
            *lane = number(j);
        }
        lanes
    }

    #[inline(always)]
    pub fn numbers(&self) -> &[T] {
        bytemuck::cast_slice(core::slice::from_ref(&self.register))
    }

    /// The first numbers of a row.
    #[inline(always)]
    pub fn first_of(simd: S, row: &[T]) -> Self {
        let register = bytemuck::pod_read_unaligned(bytemuck::cast_slice(&row[..Self::COUNT]));
        Self { simd, register }
    }

    /// a b + c, a = self.
    #[inline(always)]
    pub fn fused(self, b: Self, c: Self) -> Self {
        self.with(T::fused(self.simd, self.register, b.register, c.register))
    }

    #[inline(always)]
    fn with(self, register: T::Register<S>) -> Self {
        Self { register, ..self }
    }

    /// The next four numbers of every row: the first, second, third and last of each, with the rows in lanes of the [`order`](Self::order)
    /// that the machine can do best.
    #[inline(always)]
    pub fn columns<'a>(simd: S, row: impl Fn(usize) -> &'a [T]) -> [Self; 4] {
        let mut fours = [T::splat(simd, T::ZERO); 4];
        let numbers: &mut [T] = bytemuck::cast_slice_mut(&mut fours);
        for (j, four) in numbers.as_chunks_mut::<4>().0.iter_mut().enumerate() {
            if let Some(next) = row(j).first_chunk::<4>() {
                *four = *next;
            }
        }
        let [a, b, c, d] = T::columns(simd, fours);
        let lanes = |register| Self { simd, register };
        [lanes(a), lanes(b), lanes(c), lanes(d)]
    }

    /// The way back from [`columns`](Self::columns): four numbers of every row.
    #[inline(always)]
    pub fn rows(columns: [Self; 4], mut row: impl FnMut(usize, &[T])) {
        let [a, b, c, d] = columns;
        let registers = [a.register, b.register, c.register, d.register];
        let fours = T::fours(a.simd, registers);
        for (j, four) in bytemuck::cast_slice(&fours).chunks_exact(4).enumerate() {
            row(j, four);
        }
    }

    /// Which row each lane holds.
    #[inline(always)]
    pub fn order(simd: S) -> [usize; MOST_LANES] {
        let mut numbered = [[T::ZERO; 4]; MOST_LANES];
        for (j, row) in numbered.iter_mut().enumerate() {
            *row = [T::of(j as f64); 4];
        }
        let [rows, ..] = Self::columns(simd, |j| &numbered[j]);
        let mut order = [0; MOST_LANES];
        for (place, row) in order.iter_mut().zip(rows.numbers()) {
            *place = row.to_f64() as usize;
        }
        order
    }
}

impl<S: Simd, T: Lane> Add for Lanes<S, T> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.with(T::plus(self.simd, self.register, other.register))
    }
}

impl<S: Simd, T: Lane> Sub for Lanes<S, T> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.with(T::minus(self.simd, self.register, other.register))
    }
}

impl<S: Simd, T: Lane> Mul for Lanes<S, T> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.with(T::times(self.simd, self.register, other.register))
    }
}

impl<T: Lane> Lanes<Scalar, T> {
    /// The only one.
    #[inline(always)]
    pub fn number(self) -> T {
        self.numbers()[0]
    }
}

impl<S: Simd> Lanes<S, f64> {
    /// a - b c, a = self.
    #[inline(always)]
    pub fn less(self, b: Self, c: Self) -> Self {
        let simd = self.simd;
        self.with(simd.negate_mul_add_e_f64s(b.register, c.register, self.register))
    }

    /// 1/a
    #[inline(always)]
    pub fn inverse(self) -> Self {
        let simd = self.simd;
        self.with(simd.div_f64s(simd.splat_f64s(1.0), self.register))
    }
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
pub(crate) struct Coefficients<V> {
    pub decay: V,
    /// -c
    pub coupling: V,
    pub heading_ramp: V,
    pub rudder_ramp: V,
}

/// What takes the scaled signals to those of the model.
#[derive(Clone, Copy)]
pub(crate) struct Scales {
    pub acceleration: f64,
    pub rate: f64,
    pub rudder: f64,
}

/// The filters' state, scaled, in every lane.
#[derive(Clone, Copy)]
pub(crate) struct State<V> {
    pub heading: V,
    pub deviation: V,
    pub lag: V,
    pub rudder: V,
    pub rudder_once: V,
    pub rudder_twice: V,
}

/// The state of one record.
pub(crate) type Single<T> = State<Lanes<Scalar, T>>;

/// Of v, p and u' those whose products are summed.
pub(crate) const PAIRS: [(usize, usize); 5] = [(0, 0), (0, 1), (1, 1), (0, 2), (1, 2)];

/// Sums of p and of the products in [`PAIRS`], in every lane; those of v and u' = u - c v follow from the states:
/// [`Filter::turned`].
#[derive(Clone, Copy)]
pub(crate) struct Products<V>(pub [V; 6]);

/// Filters for one setting: coefficients, scales and where they start.
#[derive(Clone, Copy)]
pub(crate) struct Filter<T> {
    pub coefficients: Coefficients<T>,
    pub scales: Scales,
    start: FilterStart,
    /// 1/b.
    held_inverse: T,
}

impl<T: Lane> Filter<T> {
    /// `settings` are valid.
    pub fn new(settings: &FixedRateSettings<f64>) -> Self {
        let lambda = settings.lambda_rad_s;
        let x = lambda * settings.sample_interval_s;
        let (phi1, phi2) = phi(-x);
        let decay = Real::exp(-x);
        let coupling = x * decay;
        let ramp = (phi1 - phi2) / (decay * phi1);
        let (held, heading_ramp) = match settings.heading_hold {
            Hold::ZeroOrder => (1.0, 0.0),
            Hold::FirstOrder => (phi1, ramp),
        };
        Self {
            coefficients: Coefficients {
                decay: T::of(decay),
                coupling: T::of(-coupling),
                heading_ramp: T::of(heading_ramp),
                rudder_ramp: T::of(ramp),
            },
            scales: Scales {
                acceleration: lambda * lambda * held,
                rate: lambda * coupling * held,
                rudder: coupling * x * phi1,
            },
            start: settings.filter_start,
            held_inverse: T::of(1.0 / held),
        }
    }

    /// Sums of v and u' from a first sample to a last, from the [`turning`](State::turning) at both.
    ///
    /// ```text
    /// sum u = u_0 + (w - e u)/(1 - e),    sum v = v_0 + ((w - e u)/(1 - e) - u - e v + g w)/(1 - e)
    /// ```
    ///
    /// with w, u and v less those at the first: the filters' equations, added up.
    pub fn turned(&self, first: [f64; 3], last: [f64; 3]) -> [f64; 2] {
        let c = &self.coefficients;
        let [e, coupling, g] = [c.decay, c.coupling, c.heading_ramp].map(T::to_f64);
        let [w, u, v] = core::array::from_fn(|i| last[i] - first[i]);
        let [_, first_u, first_v] = first;
        let of_u = (w - e * u) / (1.0 - e);
        let sum_v = first_v + (of_u - u - e * v + g * w) / (1.0 - e);
        [sum_v, first_u + of_u + coupling * sum_v]
    }

    /// The coefficients in every lane.
    #[inline(always)]
    pub fn coefficients<S: Simd>(&self, simd: S) -> Coefficients<Lanes<S, T>> {
        let c = &self.coefficients;
        Coefficients {
            decay: Lanes::splat(simd, c.decay),
            coupling: Lanes::splat(simd, c.coupling),
            heading_ramp: Lanes::splat(simd, c.heading_ramp),
            rudder_ramp: Lanes::splat(simd, c.rudder_ramp),
        }
    }

    /// At the first samples.
    #[inline(always)]
    pub fn started<S: Simd>(
        &self,
        simd: S,
        heading: Lanes<S, T>,
        rudder: Lanes<S, T>,
    ) -> State<Lanes<S, T>> {
        let factor = |factor: f64| Lanes::splat(simd, T::of(factor));
        let at_rest = State::at_rest(simd, heading, rudder);
        match self.start {
            FilterStart::Zero => State {
                deviation: heading * Lanes::splat(simd, self.held_inverse),
                ..at_rest
            },
            FilterStart::Equilibrium => State {
                rudder_once: rudder * factor(1.0 / (1.0 - self.coefficients.decay.to_f64())),
                rudder_twice: rudder * factor(1.0 / self.scales.rudder),
                ..at_rest
            },
        }
    }
}

impl<S: Simd, T: Lane> Coefficients<Lanes<S, T>> {
    /// u' = u - c v.
    #[inline(always)]
    pub fn accelerating(&self, u: Lanes<S, T>, v: Lanes<S, T>) -> Lanes<S, T> {
        self.coupling.fused(v, u)
    }
}

impl<S: Simd, T: Lane> Products<Lanes<S, T>> {
    #[inline(always)]
    pub fn zero(simd: S) -> Self {
        Self([Lanes::splat(simd, T::ZERO); 6])
    }

    /// Adds what the filters of every lane give now.
    #[inline(always)]
    pub fn add(&mut self, [v, p, u]: [Lanes<S, T>; 3]) {
        let [rudder, rate2, rate_rudder, rudder2, rate_acc, rudder_acc] = self.0;
        self.0 = [
            rudder + p,
            v.fused(v, rate2),
            v.fused(p, rate_rudder),
            p.fused(p, rudder2),
            v.fused(u, rate_acc),
            p.fused(u, rudder_acc),
        ];
    }

    /// Adds the sums of each lane to those in double precision, and begins again.
    #[inline(always)]
    pub fn move_to(&mut self, sums: &mut [[f64; MOST_LANES]; 6]) {
        for (sums, products) in sums.iter_mut().zip(&mut self.0) {
            for (sum, product) in sums.iter_mut().zip(products.numbers()) {
                *sum += product.to_f64();
            }
            *products = Lanes::splat(products.simd, T::ZERO);
        }
    }
}

impl<S: Simd, T: Lane> State<Lanes<S, T>> {
    /// Filters that have seen nothing before these samples.
    #[inline(always)]
    pub fn at_rest(simd: S, heading: Lanes<S, T>, rudder: Lanes<S, T>) -> Self {
        let zero = Lanes::splat(simd, T::ZERO);
        Self {
            heading,
            deviation: zero,
            lag: zero,
            rudder,
            rudder_once: zero,
            rudder_twice: zero,
        }
    }

    /// Takes in the next sample of every lane and gives v, p and u'.
    #[inline(always)]
    pub fn advance(
        &mut self,
        heading: Lanes<S, T>,
        rudder: Lanes<S, T>,
        c: &Coefficients<Lanes<S, T>>,
    ) -> [Lanes<S, T>; 3] {
        self.turn(heading, c);
        self.lay(rudder, c);
        self.outputs(c)
    }

    /// Takes in the next samples of every row and shows the place in the row and v, p and u' of each.
    #[inline(always)]
    pub fn follow<const N: usize>(
        &mut self,
        headings: &Rows<T, N>,
        rudders: &Rows<T, N>,
        c: &Coefficients<Lanes<S, T>>,
        mut see: impl FnMut(usize, [Lanes<S, T>; 3]),
    ) {
        let simd = self.lag.simd;
        for k in (0..N).step_by(4) {
            let headings = Lanes::columns(simd, |row| &headings[row][k..k + 4]);
            let rudders = Lanes::columns(simd, |row| &rudders[row][k..k + 4]);
            for (i, (heading, rudder)) in headings.into_iter().zip(rudders).enumerate() {
                see(k + i, self.advance(heading, rudder, c));
            }
        }
    }

    /// w, u and v of a lane.
    pub fn turning(&self, lane: usize) -> [f64; 3] {
        [self.heading, self.deviation, self.lag].map(|lanes| lanes.numbers()[lane].to_f64())
    }

    /// Takes in the next headings.
    #[inline(always)]
    pub fn turn(&mut self, heading: Lanes<S, T>, c: &Coefficients<Lanes<S, T>>) {
        let turned = heading - self.heading;
        let lag = c.heading_ramp.fused(turned, self.deviation);
        self.lag = c.decay.fused(self.lag, lag);
        self.deviation = c.decay.fused(self.deviation, turned);
        self.heading = heading;
    }

    /// Takes in the next rudder angles.
    #[inline(always)]
    pub fn lay(&mut self, rudder: Lanes<S, T>, c: &Coefficients<Lanes<S, T>>) {
        let twice = c.rudder_ramp.fused(self.rudder, self.rudder_once);
        self.rudder_twice = c.decay.fused(self.rudder_twice, twice);
        self.rudder_once = c.decay.fused(self.rudder_once, self.rudder);
        self.rudder = rudder;
    }

    /// v, p and u' = u - c v.
    #[inline(always)]
    pub fn outputs(&self, c: &Coefficients<Lanes<S, T>>) -> [Lanes<S, T>; 3] {
        [
            self.lag,
            self.rudder_twice,
            c.accelerating(self.deviation, self.lag),
        ]
    }
}
