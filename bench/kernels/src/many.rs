//! Many records of equal length, side by side.

use core::hint::black_box;
use core::slice::ChunksExact;

use pulp::{Arch, Simd, WithSimd};
use seatrial_core::InvalidSetting;
use seatrial_core::fixed_rate::FixedRateSettings;

use crate::Sums;
use crate::lanes::{
    BLOCK, Coefficients, Filter, Lane, Lanes, MOST_LANES, Products, Rows, State, TOGETHER, rows,
};

/// Bytes.
const CACHE_LINE: usize = 64;

/// The sums of many records of `samples_per_record` each, one behind the other: unwrapped headings and rudder angles, rad. What
/// is left of an incomplete record is ignored.
pub fn of_records<T: Lane>(
    settings: &FixedRateSettings<f64>,
    samples_per_record: usize,
    heading_rad: &[T],
    rudder_rad: &[T],
) -> Result<Vec<Sums>, InvalidSetting> {
    settings.check()?;
    if samples_per_record == 0 {
        return Err(InvalidSetting {
            field: "samples_per_record",
            requirement: "at least 1",
        });
    }
    Ok(Arch::new().dispatch(Records {
        filter: Filter::new(settings),
        samples_per_record,
        heading_rad,
        rudder_rad,
    }))
}

struct Records<'a, T> {
    filter: Filter<T>,
    samples_per_record: usize,
    heading_rad: &'a [T],
    rudder_rad: &'a [T],
}

impl<T: Lane> WithSimd for Records<'_, T> {
    type Output = Vec<Sums>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Vec<Sums> {
        let samples = self.samples_per_record;
        let records = (self.heading_rad.len() / samples).min(self.rudder_rad.len() / samples);
        let whole = records * samples;
        let together = Lanes::<S, T>::COUNT * samples;
        let order = Lanes::<S, T>::order(simd);
        let mut all = Vec::with_capacity(records);
        let headings = self.heading_rad[..whole].chunks(together);
        let rudders = self.rudder_rad[..whole].chunks(together);
        let nothing: &[T] = &[];
        let next = headings.clone().zip(rudders.clone()).skip(1);
        let next = next.chain([(nothing, nothing)]);
        for ((heading, rudder), next) in headings.zip(rudders).zip(next) {
            let group = self.group(simd, &order, heading, rudder, next);
            let here = heading.len() / samples;
            all.resize(all.len() + here, Sums::default());
            let from = all.len() - here;
            for (lane, row) in order.iter().enumerate().take(Lanes::<S, T>::COUNT) {
                if *row < here {
                    let [first, last] = [group.first, group.last].map(|state| state.turning(lane));
                    let turned = self.filter.turned(first, last);
                    let products = group.products.map(|lanes| lanes[lane]);
                    all[from + row] = Sums::scaled(turned, products, samples, &self.filter.scales);
                }
            }
        }
        all
    }
}

/// What records side by side give.
struct Group<S: Simd, T: Lane> {
    /// At the first sample.
    first: State<Lanes<S, T>>,
    /// At the last.
    last: State<Lanes<S, T>>,
    /// As in [`Products`].
    products: [[f64; MOST_LANES]; 6],
}

impl<T: Lane> Records<'_, T> {
    /// Of as many records as there are lanes, in their order, or of fewer, of which the last is taken again.
    #[inline(always)]
    fn group<S: Simd>(
        &self,
        simd: S,
        order: &[usize; MOST_LANES],
        heading: &[T],
        rudder: &[T],
        next: (&[T], &[T]),
    ) -> Group<S, T> {
        let samples = self.samples_per_record;
        let last_record = heading.len() / samples - 1;
        let at = |signal: &[T], k: usize| {
            Lanes::from_fn(simd, |lane| {
                signal[order[lane].min(last_record) * samples + k]
            })
        };
        let c = self.filter.coefficients(simd);
        let first = self.filter.started(simd, at(heading, 0), at(rudder, 0));
        let mut state = first;
        let mut products = Products::zero(simd);
        products.add(state.outputs(&c));
        let mut sums = [[0.0; MOST_LANES]; 6];
        let mut ahead = Ahead::new::<S>(next);
        let mut k = 1;
        while let (Some(headings), Some(rudders)) = (
            rows::<S, T, TOGETHER>(heading, samples, k),
            rows::<S, T, TOGETHER>(rudder, samples, k),
        ) {
            take(
                &mut state,
                &mut products,
                &mut ahead,
                (&headings, &rudders),
                &c,
            );
            k += TOGETHER;
            if k % BLOCK < TOGETHER {
                products.move_to(&mut sums);
            }
        }
        while let (Some(headings), Some(rudders)) = (
            rows::<S, T, 4>(heading, samples, k),
            rows::<S, T, 4>(rudder, samples, k),
        ) {
            take(
                &mut state,
                &mut products,
                &mut ahead,
                (&headings, &rudders),
                &c,
            );
            k += 4;
        }
        for k in k..samples {
            products.add(state.advance(at(heading, k), at(rudder, k), &c));
        }
        products.move_to(&mut sums);
        Group {
            first,
            last: state,
            products: sums,
        }
    }
}

/// Takes in the next samples of every record of a group, and reads on in the next one.
#[inline(always)]
fn take<S: Simd, T: Lane, const N: usize>(
    state: &mut State<Lanes<S, T>>,
    products: &mut Products<Lanes<S, T>>,
    ahead: &mut Ahead<T>,
    (headings, rudders): (&Rows<T, N>, &Rows<T, N>),
    c: &Coefficients<Lanes<S, T>>,
) {
    state.follow(
        headings,
        rudders,
        c,
        #[inline(always)]
        |k, outputs| {
            if k % 4 == 0 {
                ahead.read();
            }
            products.add(outputs);
        },
    );
}

/// The group after the one at work, which is read in order meanwhile, as the processor expects: records side by side are more streams
/// than it reads ahead in.
struct Ahead<'a, T> {
    signals: [ChunksExact<'a, T>; 2],
}

impl<'a, T: Lane> Ahead<'a, T> {
    #[inline(always)]
    fn new<S: Simd>((heading, rudder): (&'a [T], &'a [T])) -> Self {
        Self {
            signals: [heading, rudder].map(|signal| signal.chunks_exact(4 * Lanes::<S, T>::COUNT)),
        }
    }

    /// As much as four samples of each row.
    #[inline(always)]
    fn read(&mut self) {
        for signal in &mut self.signals {
            if let Some(four) = signal.next() {
                for line in four.chunks_exact(CACHE_LINE / size_of::<T>()) {
                    black_box(line[0]);
                }
            }
        }
    }
}
