//! One long record, cut into stretches that are filtered side by side.

use pulp::{Arch, Scalar, Simd, WithSimd};
use seatrial_core::InvalidSetting;
use seatrial_core::fixed_rate::FixedRateSettings;

use crate::Sums;
use crate::lanes::{
    BLOCK, Coefficients, Filter, Lane, Lanes, MOST_LANES, PAIRS, Products, Single, State, rows,
};

/// Samples of a stretch: from two pages of memory on, the processor reads ahead in every stretch, and what the state before it adds is
/// soon over.
const LONGEST: usize = 4096;
/// Shorter stretches take longer than one sample after the other.
const SHORTEST: usize = 16;

/// What is left of a state is nothing beside its rounding.
const NEGLIGIBLE: f64 = 1e-20;

/// The sums of one record that comes in pieces of any length.
#[derive(Clone)]
pub struct Accumulator<T: Lane> {
    filter: Filter<T>,
    /// Once the record is long enough for them.
    stretches: Option<Stretches<T>>,
    /// At the first and at the last sample, once there is one.
    ends: Option<[Single<T>; 2]>,
    total: [f64; 6],
    samples: usize,
}

impl<T: Lane> Accumulator<T> {
    /// No sample yet. An invalid setting is an error.
    pub fn new(settings: &FixedRateSettings<f64>) -> Result<Self, InvalidSetting> {
        settings.check()?;
        Ok(Self {
            filter: Filter::new(settings),
            stretches: None,
            ends: None,
            total: [0.0; 6],
            samples: 0,
        })
    }

    /// Takes in the next samples: headings, unwrapped, and the rudder angles, rad; of the longer of the two the rest is ignored.
    pub fn extend(&mut self, heading_rad: &[T], rudder_rad: &[T]) {
        Arch::new().dispatch(Extension {
            accumulator: self,
            heading_rad,
            rudder_rad,
        });
    }

    /// The sums so far.
    pub fn sums(&self) -> Sums {
        let Some([first, last]) = &self.ends else {
            return Sums::default();
        };
        let turned = self.filter.turned(first.turning(0), last.turning(0));
        Sums::scaled(turned, self.total, self.samples, &self.filter.scales)
    }
}

struct Extension<'a, T: Lane> {
    accumulator: &'a mut Accumulator<T>,
    heading_rad: &'a [T],
    rudder_rad: &'a [T],
}

impl<T: Lane> WithSimd for Extension<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Accumulator {
            filter,
            stretches,
            ends,
            total,
            samples,
        } = self.accumulator;
        let count = self.heading_rad.len().min(self.rudder_rad.len());
        let (heading, rudder) = (&self.heading_rad[..count], &self.rudder_rad[..count]);
        let (Some(&first_heading), Some(&first_rudder)) = (heading.first(), rudder.first()) else {
            return;
        };
        let c = filter.coefficients(Scalar);
        let single = |number| Lanes::splat(Scalar, number);
        let mut products = Products::zero(Scalar);
        let (first_heading, first_rudder) = (single(first_heading), single(first_rudder));
        let [first, mut now] = match *ends {
            Some([first, mut now]) => {
                now.advance(first_heading, first_rudder, &c);
                [first, now]
            }
            None => [filter.started(Scalar, first_heading, first_rudder); 2],
        };
        products.add(now.outputs(&c));

        // Every tile begins with the last sample before it.
        let mut at = 0;
        while let Some(length) = stretch_length::<S, T>(count - 1 - at) {
            let stretches = Stretches::of(stretches, filter, length);
            let tile = at..at + Lanes::<S, T>::COUNT * length + 1;
            let tile = stretches.tile(simd, filter, &now, &heading[tile.clone()], &rudder[tile]);
            for (total, sums) in total.iter_mut().zip(&tile.sums) {
                *total += sums.iter().sum::<f64>();
            }
            now = tile.end;
            at += Lanes::<S, T>::COUNT * length;
        }
        for (heading, rudder) in heading[at + 1..].iter().zip(&rudder[at + 1..]) {
            products.add(now.advance(single(*heading), single(*rudder), &c));
        }
        for (total, sum) in total.iter_mut().zip(products.0) {
            *total += sum.number().to_f64();
        }
        *ends = Some([first, now]);
        *samples += count;
    }
}

/// Samples of the stretches that so many samples are cut into, one stretch a lane.
#[inline(always)]
fn stretch_length<S: Simd, T: Lane>(samples: usize) -> Option<usize> {
    let length = (samples / Lanes::<S, T>::COUNT).min(LONGEST) / 4 * 4;
    (!S::IS_SCALAR && length >= SHORTEST).then_some(length)
}

/// What the state before a stretch of L samples adds to what the filters give from rest.
///
/// ```text
/// u_k + e^k u_0,   v_k + e^k v_0 + k e^(k-1) u_0,   likewise q and p,   k = 1, ..., L
/// y z = (y_k + y_a e^k + y_b k e^(k-1)) (z_k + z_a e^k + z_b k e^(k-1))     for y, z of v, p, u'
/// ```
///
/// so that the sums of a stretch from any state follow from those from rest, and no stretch waits for the one before.
#[derive(Clone)]
struct Stretches<T> {
    /// L.
    length: usize,
    /// e^k and k e^(k-1), as long as they are not negligible, and zeros to the end of that block or stretch.
    decays: Vec<[T; 2]>,
    /// sum e^k, sum k e^(k-1)
    sums: [T; 2],
    /// sum e^2k, sum k e^(2k-1), sum k^2 e^(2k-2)
    products: [T; 3],
    /// e^L, L e^(L-1)
    whole: [T; 2],
}

/// Stretches side by side.
struct Tile<T: Lane> {
    /// Of each stretch.
    sums: [[f64; MOST_LANES]; 6],
    /// After the last one.
    end: Single<T>,
}

/// What stretches give from rest.
struct FromRest<S: Simd, T: Lane> {
    end: State<Lanes<S, T>>,
    sums: [[f64; MOST_LANES]; 6],
    /// sum y e^k and sum y k e^(k-1) for v, p, u'.
    decaying: [[Lanes<S, T>; 2]; 3],
}

impl<T: Lane> Stretches<T> {
    /// Those of this length.
    #[inline(always)]
    fn of<'a>(known: &'a mut Option<Self>, filter: &Filter<T>, length: usize) -> &'a Self {
        if known.as_ref().is_none_or(|of| of.length != length) {
            *known = Some(Self::new(filter, length));
        }
        known.get_or_insert_with(|| Self::new(filter, length))
    }

    fn new(filter: &Filter<T>, length: usize) -> Self {
        let e = filter.coefficients.decay.to_f64();
        let mut decays = Vec::with_capacity(length);
        let (mut sums, mut products) = ([0.0; 2], [0.0; 3]);
        let [mut power, mut slope] = [1.0, 0.0];
        for k in 1..=length {
            slope = k as f64 * power;
            if slope < NEGLIGIBLE {
                [power, slope] = [0.0; 2];
                break;
            }
            power *= e;
            decays.push([T::of(power), T::of(slope)]);
            sums = [sums[0] + power, sums[1] + slope];
            products[0] += power * power;
            products[1] += power * slope;
            products[2] += slope * slope;
        }
        let end = decays.len().next_multiple_of(BLOCK).min(length);
        decays.resize(end, [T::ZERO; 2]);
        Self {
            length,
            decays,
            sums: sums.map(T::of),
            products: products.map(T::of),
            whole: [power, slope].map(T::of),
        }
    }

    /// Filters and sums a tile, which begins with the sample before it, where the state is `before`.
    #[inline(always)]
    fn tile<S: Simd>(
        &self,
        simd: S,
        filter: &Filter<T>,
        before: &Single<T>,
        heading: &[T],
        rudder: &[T],
    ) -> Tile<T> {
        let order = Lanes::<S, T>::order(simd);
        let length = self.length;
        let first = |signal: &[T]| Lanes::from_fn(simd, |lane| signal[order[lane] * length]);
        let at_rest = State::at_rest(simd, first(heading), first(rudder));
        let from_rest =
            self.filtered_from_rest(simd, filter, at_rest, (&heading[1..], &rudder[1..]));
        let ends = &from_rest.end;
        let (deviation, lag, end_deviation, end_lag) = self.follow(
            &order,
            before.deviation,
            before.lag,
            ends.deviation,
            ends.lag,
        );
        let (once, twice, end_once, end_twice) = self.follow(
            &order,
            before.rudder_once,
            before.rudder_twice,
            ends.rudder_once,
            ends.rudder_twice,
        );
        let begin = State {
            deviation,
            lag,
            rudder_once: once,
            rudder_twice: twice,
            ..at_rest
        };
        let mut sums = from_rest.sums;
        self.left_by(&begin, &from_rest.decaying, &filter.coefficients(simd))
            .move_to(&mut sums);
        let end = State {
            heading: Lanes::splat(Scalar, heading[heading.len() - 1]),
            deviation: Lanes::splat(Scalar, end_deviation),
            lag: Lanes::splat(Scalar, end_lag),
            rudder: Lanes::splat(Scalar, rudder[rudder.len() - 1]),
            rudder_once: Lanes::splat(Scalar, end_once),
            rudder_twice: Lanes::splat(Scalar, end_twice),
        };
        Tile { sums, end }
    }

    #[inline(always)]
    fn filtered_from_rest<S: Simd>(
        &self,
        simd: S,
        filter: &Filter<T>,
        mut state: State<Lanes<S, T>>,
        (heading, rudder): (&[T], &[T]),
    ) -> FromRest<S, T> {
        let c = filter.coefficients(simd);
        let mut products = Products::zero(simd);
        let mut sums = [[0.0; MOST_LANES]; 6];
        let mut decaying = [[Lanes::splat(simd, T::ZERO); 2]; 3];
        let whole = |at| {
            let headings = rows::<S, T, BLOCK>(heading, self.length, at)?;
            Some((headings, rows::<S, T, BLOCK>(rudder, self.length, at)?))
        };
        let four = |rows: &[T]| Lanes::<S, T>::columns(simd, |row| &rows[row * self.length..]);
        let mut at = 0;
        for block in self.decays.chunks(BLOCK) {
            if let (Some(decays), Some((headings, rudders))) = (block.first_chunk(), whole(at)) {
                let decays: &[_; BLOCK] = decays;
                state.follow(
                    &headings,
                    &rudders,
                    &c,
                    #[inline(always)]
                    |k, outputs| {
                        products.add(outputs);
                        add_decaying(simd, &mut decaying, outputs, decays[k]);
                    },
                );
            } else {
                let (mut headings, mut rudders) = (&heading[at..], &rudder[at..]);
                for decays in block.as_chunks::<4>().0 {
                    let columns = four(headings).into_iter().zip(four(rudders));
                    (headings, rudders) = (&headings[4..], &rudders[4..]);
                    for ((heading, rudder), decays) in columns.zip(decays) {
                        let outputs = state.advance(heading, rudder, &c);
                        products.add(outputs);
                        add_decaying(simd, &mut decaying, outputs, *decays);
                    }
                }
            }
            at += block.len();
            products.move_to(&mut sums);
        }
        while let Some((headings, rudders)) = whole(at) {
            state.follow(
                &headings,
                &rudders,
                &c,
                #[inline(always)]
                |_, outputs| products.add(outputs),
            );
            at += BLOCK;
            products.move_to(&mut sums);
        }
        for at in (at..self.length).step_by(4) {
            let headings = four(&heading[at..]);
            for (heading, rudder) in headings.into_iter().zip(four(&rudder[at..])) {
                products.add(state.advance(heading, rudder, &c));
            }
        }
        products.move_to(&mut sums);
        FromRest {
            end: state,
            sums,
            decaying,
        }
    }

    /// The two states of a signal's poles before each stretch, and after the last, from those before the first and those that the
    /// stretches give from rest.
    #[inline(always)]
    fn follow<S: Simd>(
        &self,
        order: &[usize; MOST_LANES],
        once: Lanes<Scalar, T>,
        twice: Lanes<Scalar, T>,
        once_from_rest: Lanes<S, T>,
        twice_from_rest: Lanes<S, T>,
    ) -> (Lanes<S, T>, Lanes<S, T>, T, T) {
        let [decay, coupling] = self.whole;
        let (mut once, mut twice) = (once.number(), twice.number());
        let mut before = [[T::ZERO; MOST_LANES]; 2];
        let mut from_rest = [[T::ZERO; MOST_LANES]; 2];
        for (lane, row) in order.iter().enumerate().take(Lanes::<S, T>::COUNT) {
            from_rest[0][*row] = once_from_rest.numbers()[lane];
            from_rest[1][*row] = twice_from_rest.numbers()[lane];
        }
        for row in 0..Lanes::<S, T>::COUNT {
            before[0][row] = once;
            before[1][row] = twice;
            twice = from_rest[1][row] + decay * twice + coupling * once;
            once = from_rest[0][row] + decay * once;
        }
        let simd = once_from_rest.simd;
        let before_once = Lanes::from_fn(simd, |lane| before[0][order[lane]]);
        let before_twice = Lanes::from_fn(simd, |lane| before[1][order[lane]]);
        (before_once, before_twice, once, twice)
    }

    /// What the states before the stretches add to the sums.
    #[inline(always)]
    fn left_by<S: Simd>(
        &self,
        begin: &State<Lanes<S, T>>,
        decaying: &[[Lanes<S, T>; 2]; 3],
        c: &Coefficients<Lanes<S, T>>,
    ) -> Products<Lanes<S, T>> {
        let simd = begin.lag.simd;
        // y_a and y_b of v, p and u'.
        let left = [
            [begin.lag, begin.deviation],
            [begin.rudder_twice, begin.rudder_once],
            [
                c.accelerating(begin.deviation, begin.lag),
                c.coupling * begin.deviation,
            ],
        ];
        let mut added = Products::zero(simd);
        let [rudder, of_two @ ..] = &mut added.0;
        let [_, of_rudder, _] = left;
        *rudder = dot(of_rudder, self.sums.map(|sum| Lanes::splat(simd, sum)));
        let [once, mixed, twice] = self.products;
        let mixed = Lanes::splat(simd, mixed);
        let once = [Lanes::splat(simd, once), mixed];
        let twice = [mixed, Lanes::splat(simd, twice)];
        for (added, (y, z)) in of_two.iter_mut().zip(PAIRS) {
            let own = [dot(once, left[z]), dot(twice, left[z])];
            let beside = dot(left[z], decaying[y]) + dot(left[y], decaying[z]);
            *added = beside + dot(left[y], own);
        }
        added
    }
}

#[inline(always)]
fn add_decaying<S: Simd, T: Lane>(
    simd: S,
    decaying: &mut [[Lanes<S, T>; 2]; 3],
    outputs: [Lanes<S, T>; 3],
    [once, twice]: [T; 2],
) {
    let (once, twice) = (Lanes::splat(simd, once), Lanes::splat(simd, twice));
    for (sums, output) in decaying.iter_mut().zip(outputs) {
        let [of_once, of_twice] = *sums;
        *sums = [output.fused(once, of_once), output.fused(twice, of_twice)];
    }
}

#[inline(always)]
fn dot<S: Simd, T: Lane>(a: [Lanes<S, T>; 2], b: [Lanes<S, T>; 2]) -> Lanes<S, T> {
    a[0].fused(b[0], a[1] * b[1])
}
