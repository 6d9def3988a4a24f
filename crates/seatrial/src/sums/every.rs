//! Theta after every sample of a long record.

use pulp::{Arch, Scalar, Simd, WithSimd};
use seatrial_core::estimator::InvalidSetting;
use seatrial_core::fixed_rate::FixedRateSettings;

use super::lanes::{Filter, Lanes, MOST_LANES, Products, Scales, Single, State};
use super::long::{Stretches, Tile, stretch_length};

/// Samples of a stretch: what is read twice stays in the first cache.
const LONGEST: usize = 128;

/// Theta_k = [a22, b2, C0] of the recursion after every sample: what
/// [`FixedRateEstimator`](seatrial_core::FixedRateEstimator) gives from the sums so far, eight instants at a time. Until the vehicle is excited it
/// is what the ridge 1/P0 makes of it, as in the recursion, and rounding has its say.
///
/// They take the place of what `thetas` holds: a vector that is used again takes two thirds of the time of a new one, whose memory
/// the machine has to clear.
pub fn every_theta(
    settings: &FixedRateSettings<f64>,
    heading_rad: &[f64],
    rudder_rad: &[f64],
    thetas: &mut Vec<[f64; 3]>,
) -> Result<(), InvalidSetting> {
    settings.validate()?;
    let count = heading_rad.len().min(rudder_rad.len());
    thetas.resize(count, [0.0; 3]);
    Arch::new().dispatch(Every {
        filter: Filter::new(settings),
        ridge: 1.0 / settings.initial_covariance,
        heading_rad: &heading_rad[..count],
        rudder_rad: &rudder_rad[..count],
        thetas,
    });
    Ok(())
}

struct Every<'a> {
    filter: Filter<f64>,
    ridge: f64,
    heading_rad: &'a [f64],
    rudder_rad: &'a [f64],
    thetas: &'a mut [[f64; 3]],
}

impl WithSimd for Every<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self {
            filter,
            heading_rad: heading,
            rudder_rad: rudder,
            thetas,
            ..
        } = self;
        let (Some(&first_heading), Some(&first_rudder)) = (heading.first(), rudder.first()) else {
            return;
        };
        let single = |number| Lanes::splat(Scalar, number);
        let c = filter.coefficients(Scalar);
        let of_one = Ridge::new(Scalar, self.ridge, &filter.scales);
        let ridge = Ridge::new(simd, self.ridge, &filter.scales);
        let mut now = filter.started(Scalar, single(first_heading), single(first_rudder));
        let first = now.turning(0);
        let mut sums = Products::zero(Scalar);
        sums.add(now.outputs(&c));
        let theta_at = |k: usize, now: &Single<f64>, sums: &Products<Lanes<Scalar, f64>>| {
            let turned = filter.turned(first, now.turning(0)).map(single);
            let theta = of_one.solve(turned, sums, single((k + 1) as f64));
            theta.map(|parameter| parameter.register)
        };
        thetas[0] = theta_at(0, &now, &sums);

        let mut known = None;
        let mut at = 0;
        while let Some(length) = stretch_length::<S, f64>(heading.len() - 1 - at, LONGEST) {
            let tile = at..at + Lanes::<S, f64>::COUNT * length + 1;
            let (heading, rudder) = (&heading[tile.clone()], &rudder[tile.clone()]);
            let stretches = Stretches::of(&mut known, &filter, length);
            let tile_begin = at + 1;
            let thetas = &mut thetas[tile][1..];
            let tile = stretches.tile(simd, &filter, &now, heading, rudder);
            let begin = Begin {
                order: tile.order,
                state: tile.begin,
                turned: turned_before(simd, &filter, first, &tile.begin),
                sums: sums_before(simd, &mut sums, &tile),
                samples: tile_begin,
            };
            ridge.stretches(simd, &filter, begin, (&heading[1..], &rudder[1..]), thetas);
            now = tile.end;
            at += heading.len() - 1;
        }
        for k in at + 1..heading.len() {
            sums.add(now.advance(single(heading[k]), single(rudder[k]), &c));
            thetas[k] = theta_at(k, &now, &sums);
        }
    }
}

/// The sums of v and u' before each stretch.
#[inline(always)]
fn turned_before<S: Simd>(
    simd: S,
    filter: &Filter<f64>,
    first: [f64; 3],
    begin: &State<Lanes<S, f64>>,
) -> [Lanes<S, f64>; 2] {
    let [mut rates, mut accelerations] = [[0.0; MOST_LANES]; 2];
    let lanes = rates.iter_mut().zip(&mut accelerations);
    for (lane, (rate, acceleration)) in lanes.enumerate().take(S::F64_LANES) {
        [*rate, *acceleration] = filter.turned(first, begin.turning(lane));
    }
    [rates, accelerations].map(|lanes| Lanes::first_of(simd, &lanes))
}

/// The other sums before each stretch of a tile from those before it, which become those after it.
#[inline(always)]
fn sums_before<S: Simd>(
    simd: S,
    sums: &mut Products<Lanes<Scalar, f64>>,
    tile: &Tile<S, f64>,
) -> Products<Lanes<S, f64>> {
    let mut lane_of = [0; MOST_LANES];
    for (lane, row) in tile.order.iter().enumerate().take(S::F64_LANES) {
        lane_of[*row] = lane;
    }
    let mut before = Products::zero(simd);
    for ((before, sum), added) in before.0.iter_mut().zip(&mut sums.0).zip(&tile.sums) {
        let mut lanes = [0.0; MOST_LANES];
        for lane in &lane_of[..S::F64_LANES] {
            lanes[*lane] = sum.register;
            sum.register += added[*lane];
        }
        *before = Lanes::first_of(simd, &lanes);
    }
    before
}

/// Where the stretches of a tile begin.
struct Begin<S: Simd> {
    /// Which stretch each lane holds.
    order: [usize; MOST_LANES],
    state: State<Lanes<S, f64>>,
    /// Sums of v and u'.
    turned: [Lanes<S, f64>; 2],
    sums: Products<Lanes<S, f64>>,
    /// Before the first.
    samples: usize,
}

/// The ridge regression from scaled sums.
struct Ridge<V> {
    rate: V,
    rudder: V,
    one: V,
    theta: [V; 3],
}

impl<S: Simd> Ridge<Lanes<S, f64>> {
    #[inline(always)]
    fn new(simd: S, ridge: f64, scales: &Scales) -> Self {
        let lanes = |number| Lanes::splat(simd, number);
        Self {
            rate: lanes(ridge / (scales.rate * scales.rate)),
            rudder: lanes(ridge / (scales.rudder * scales.rudder)),
            one: lanes(ridge),
            theta: [
                scales.acceleration / scales.rate,
                scales.acceleration / scales.rudder,
                scales.acceleration,
            ]
            .map(lanes),
        }
    }

    /// Goes through the stretches again, now with the sums before them.
    #[inline(always)]
    fn stretches(
        &self,
        simd: S,
        filter: &Filter<f64>,
        begin: Begin<S>,
        (mut heading, mut rudder): (&[f64], &[f64]),
        thetas: &mut [[f64; 3]],
    ) {
        let length = thetas.len() / S::F64_LANES;
        let c = filter.coefficients(simd);
        let Begin {
            order,
            mut state,
            turned: [mut rate, mut acceleration],
            mut sums,
            samples,
        } = begin;
        let mut samples = Lanes::from_fn(simd, |lane| (samples + order[lane] * length) as f64);
        let one = Lanes::splat(simd, 1.0);
        let numbers = thetas.as_flattened_mut();
        for at in (0..length).step_by(4) {
            let headings = Lanes::columns(simd, |row| &heading[row * length..]);
            let rudders = Lanes::columns(simd, |row| &rudder[row * length..]);
            (heading, rudder) = (&heading[4..], &rudder[4..]);
            let mut solved = [one; 12];
            let columns = headings.into_iter().zip(rudders);
            for ((heading, rudder), solved) in columns.zip(solved.as_chunks_mut().0) {
                let outputs = state.advance(heading, rudder, &c);
                let [v, _, accelerating] = outputs;
                sums.add(outputs);
                (rate, acceleration) = (rate + v, acceleration + accelerating);
                samples = samples + one;
                *solved = self.solve([rate, acceleration], &sums, samples);
            }
            for (i, four) in solved.as_chunks().0.iter().enumerate() {
                let from = 3 * at + 4 * i;
                Lanes::rows(*four, |row, four| {
                    numbers[3 * row * length + from..][..4].copy_from_slice(four);
                });
            }
        }
    }

    /// The normal equations with the constant eliminated first, which centres the sums, and one division.
    #[inline(always)]
    fn solve(
        &self,
        [r, y]: [Lanes<S, f64>; 2],
        sums: &Products<Lanes<S, f64>>,
        samples: Lanes<S, f64>,
    ) -> [Lanes<S, f64>; 3] {
        let [d, rr, rd, dd, ry, dy] = sums.0;
        let n = samples + self.one;
        let a = (n * (rr + self.rate)).less(r, r);
        let b = (n * rd).less(r, d);
        let c = (n * (dd + self.rudder)).less(d, d);
        let p = (n * ry).less(r, y);
        let q = (n * dy).less(d, y);
        let determinant = (a * c).less(b, b);
        let inverse = (determinant * n).inverse();
        let over_determinant = inverse * n;
        let of_rate = (p * c).less(q, b) * over_determinant;
        let of_rudder = (q * a).less(p, b) * over_determinant;
        let rest = y.less(of_rate, r).less(of_rudder, d);
        let [to_rate, to_rudder, to_one] = self.theta;
        [
            of_rate * to_rate,
            of_rudder * to_rudder,
            rest * (inverse * determinant) * to_one,
        ]
    }
}
