//! One long record, cut into stretches that are filtered side by side.

use seatrial_core::estimator::InvalidSetting;
use seatrial_core::fixed_rate::FixedRateSettings;

use super::Sums;
use super::lanes::{Filter, Lane, Products, State, Work, multiply_add, transpose};

/// Samples of a stretch. Eight of them, of heading and rudder, and what they are copied into fit the first cache.
pub(super) const STRETCH: usize = 128;

/// The sums of one record that comes in pieces of any length.
#[derive(Clone)]
pub struct Accumulator<T> {
    filter: Filter<T>,
    /// Once the record is long enough for them.
    stretches: Option<Stretches<T>>,
    /// At the last sample, once there is one.
    state: Option<State<T, 1>>,
    total: [f64; 8],
    samples: usize,
}

impl<T: Lane> Accumulator<T> {
    /// No sample yet. An invalid setting is an error.
    pub fn new(settings: &FixedRateSettings<f64>) -> Result<Self, InvalidSetting> {
        settings.validate()?;
        Ok(Self {
            filter: Filter::new(settings),
            stretches: None,
            state: None,
            total: [0.0; 8],
            samples: 0,
        })
    }

    /// Takes in the next samples: headings, unwrapped, and the rudder angles, rad; of the longer of the two the rest is ignored.
    pub fn extend(&mut self, heading_rad: &[T], rudder_rad: &[T]) {
        T::dispatch(Extension {
            accumulator: self,
            heading_rad,
            rudder_rad,
        });
    }

    /// The sums so far.
    pub fn sums(&self) -> Sums {
        Sums::scaled(self.total, self.samples, &self.filter.scales)
    }
}

struct Extension<'a, T> {
    accumulator: &'a mut Accumulator<T>,
    heading_rad: &'a [T],
    rudder_rad: &'a [T],
}

impl<T: Lane> Work<T> for Extension<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<const N: usize, const FUSED: bool>(self) {
        let Accumulator {
            filter,
            stretches,
            state,
            total,
            samples,
        } = self.accumulator;
        let count = self.heading_rad.len().min(self.rudder_rad.len());
        let (heading, rudder) = (&self.heading_rad[..count], &self.rudder_rad[..count]);
        let (Some(&first_heading), Some(&first_rudder)) = (heading.first(), rudder.first()) else {
            return;
        };
        let c = &filter.coefficients;
        let mut products = Products::ZERO;
        let mut now = match *state {
            Some(mut now) => {
                now.advance::<FUSED>(&[first_heading], &[first_rudder], c);
                now
            }
            None => filter.started(&[first_heading], &[first_rudder]),
        };
        products.add::<FUSED>(&now, c);

        // Every tile begins with the last sample before it.
        let mut at = 0;
        while at + N * STRETCH < count {
            let tile = at..at + N * STRETCH + 1;
            let stretches = stretches.get_or_insert_with(|| Stretches::new(filter));
            let start =
                stretches.states::<N, FUSED>(&now, &heading[tile.clone()], &rudder[tile.clone()]);
            let (end, sums) =
                side_by_side::<T, N, FUSED>(start, &heading[tile.clone()], &rudder[tile], filter);
            for (total, sum) in total.iter_mut().zip(sums.total()) {
                *total += sum;
            }
            now = end.last();
            at += N * STRETCH;
        }
        for (heading, rudder) in heading[at + 1..].iter().zip(&rudder[at + 1..]) {
            now.advance::<FUSED>(&[*heading], &[*rudder], c);
            products.add::<FUSED>(&now, c);
        }
        for (total, sum) in total.iter_mut().zip(products.total()) {
            *total += sum;
        }
        *state = Some(now);
        *samples += count;
    }
}

/// Filters and sums the stretches of a tile, which begins with the sample before it.
#[inline(always)]
pub(super) fn side_by_side<T: Lane, const N: usize, const FUSED: bool>(
    mut state: State<T, N>,
    heading: &[T],
    rudder: &[T],
    filter: &Filter<T>,
) -> (State<T, N>, Products<T, N>) {
    let mut headings = [[T::ZERO; N]; STRETCH];
    let mut rudders = [[T::ZERO; N]; STRETCH];
    transpose(heading[1..].chunks_exact(STRETCH), &mut headings);
    transpose(rudder[1..].chunks_exact(STRETCH), &mut rudders);
    let mut products = Products::ZERO;
    for (heading, rudder) in headings.iter().zip(&rudders) {
        state.advance::<FUSED>(heading, rudder, &filter.coefficients);
        products.add::<FUSED>(&state, &filter.coefficients);
    }
    (state, products)
}

impl<T: Lane, const N: usize> State<T, N> {
    /// That of the last lane.
    #[inline(always)]
    pub(super) fn last(&self) -> State<T, 1> {
        let last = |lanes: &[T; N]| [lanes[N - 1]];
        State {
            heading: last(&self.heading),
            deviation: last(&self.deviation),
            lag: last(&self.lag),
            rudder: last(&self.rudder),
            rudder_once: last(&self.rudder_once),
            rudder_twice: last(&self.rudder_twice),
        }
    }
}

/// What a stretch makes of the state before it.
///
/// ```text
/// u_L = e^L u_0 + sum e^m w'        m = L-1, ..., 0
/// v_L = e^L v_0 + L e^(L-1) u_0 + sum (m e^(m-1) + g e^m) w'
/// ```
///
/// where w' are the increments of the heading, or the angles of the rudder with its k instead of g: sums of products that wait
/// for nothing, after which the states at the ends of all stretches follow one from the other.
#[derive(Clone)]
pub(super) struct Stretches<T> {
    once: [T; STRETCH],
    heading: [T; STRETCH],
    rudder: [T; STRETCH],
    /// e^L
    decay: T,
    /// L e^(L-1)
    coupling: T,
}

impl<T: Lane> Stretches<T> {
    pub(super) fn new(filter: &Filter<T>) -> Self {
        let c = &filter.coefficients;
        let e = c.decay.to_f64();
        // e^m, and m e^(m-1).
        let mut powers = [(0.0, 0.0); STRETCH + 1];
        let (mut power, mut slope) = (1.0, 0.0);
        for at in powers.iter_mut().rev() {
            *at = (power, slope);
            slope = e * slope + power;
            power *= e;
        }
        let of = |weight: &dyn Fn((f64, f64)) -> f64| {
            std::array::from_fn(|i| T::of(weight(powers[i + 1])))
        };
        let [(decay, coupling), ..] = powers;
        Self {
            once: of(&|(power, _)| power),
            heading: of(&|(power, slope)| slope + c.heading_ramp.to_f64() * power),
            rudder: of(&|(power, slope)| slope + c.rudder_ramp.to_f64() * power),
            decay: T::of(decay),
            coupling: T::of(coupling),
        }
    }

    /// The states before the stretches of a tile, which begins with the sample before it.
    #[inline(always)]
    pub(super) fn states<const N: usize, const FUSED: bool>(
        &self,
        before: &State<T, 1>,
        heading: &[T],
        rudder: &[T],
    ) -> State<T, N> {
        let lanes = |of: &[T; 1]| [of[0]; N];
        let mut states = State {
            heading: lanes(&before.heading),
            deviation: lanes(&before.deviation),
            lag: lanes(&before.lag),
            rudder: lanes(&before.rudder),
            rudder_once: lanes(&before.rudder_once),
            rudder_twice: lanes(&before.rudder_twice),
        };
        for j in 1..N {
            let from = (j - 1) * STRETCH;
            let heading = &heading[from..=from + STRETCH];
            let rudder = &rudder[from..=from + STRETCH];
            let (turned_once, turned_twice, laid_once, laid_twice) =
                self.forced::<N, FUSED>(heading, rudder);
            let follow = |once: T, twice: T, forced: T| {
                let coupled = multiply_add::<T, FUSED>(self.coupling, once, forced);
                multiply_add::<T, FUSED>(self.decay, twice, coupled)
            };
            states.heading[j] = heading[STRETCH];
            states.rudder[j] = rudder[STRETCH];
            states.lag[j] = follow(states.deviation[j - 1], states.lag[j - 1], turned_twice);
            states.rudder_twice[j] = follow(
                states.rudder_once[j - 1],
                states.rudder_twice[j - 1],
                laid_twice,
            );
            states.deviation[j] =
                multiply_add::<T, FUSED>(self.decay, states.deviation[j - 1], turned_once);
            states.rudder_once[j] =
                multiply_add::<T, FUSED>(self.decay, states.rudder_once[j - 1], laid_once);
        }
        states
    }

    /// The four sums over one stretch.
    #[inline(always)]
    fn forced<const N: usize, const FUSED: bool>(
        &self,
        heading: &[T],
        rudder: &[T],
    ) -> (T, T, T, T) {
        let mut sums = [[T::ZERO; N]; 4];
        let [turned_once, turned_twice, laid_once, laid_twice] = &mut sums;
        let before = heading[..STRETCH].chunks_exact(N);
        let after = heading[1..].chunks_exact(N);
        let laid = rudder[..STRETCH].chunks_exact(N);
        let weights = (self.once.chunks_exact(N).zip(self.heading.chunks_exact(N)))
            .zip(self.rudder.chunks_exact(N));
        for (((before, after), laid), ((once, of_heading), of_rudder)) in
            before.zip(after).zip(laid).zip(weights)
        {
            for j in 0..N {
                let turned = after[j] - before[j];
                turned_once[j] = multiply_add::<T, FUSED>(once[j], turned, turned_once[j]);
                turned_twice[j] = multiply_add::<T, FUSED>(of_heading[j], turned, turned_twice[j]);
                laid_once[j] = multiply_add::<T, FUSED>(once[j], laid[j], laid_once[j]);
                laid_twice[j] = multiply_add::<T, FUSED>(of_rudder[j], laid[j], laid_twice[j]);
            }
        }
        let [a, b, c, d] = sums.map(|lanes| lanes.into_iter().sum());
        (a, b, c, d)
    }
}
