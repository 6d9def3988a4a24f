//! Many records of equal length, side by side.

use seatrial_core::estimator::InvalidSetting;
use seatrial_core::fixed_rate::FixedRateSettings;

use super::Sums;
use super::lanes::{Filter, Lane, Products, State, Work, transpose};

/// Samples that are put side by side at a time.
const BLOCK: usize = 64;

/// The sums of many records of `samples_per_record` each, one behind the other: unwrapped headings and rudder angles, rad. What
/// is left of an incomplete record is ignored.
pub fn of_records<T: Lane>(
    settings: &FixedRateSettings<f64>,
    samples_per_record: usize,
    heading_rad: &[T],
    rudder_rad: &[T],
) -> Result<Vec<Sums>, InvalidSetting> {
    settings.validate()?;
    if samples_per_record == 0 {
        return Err(InvalidSetting {
            field: "samples_per_record",
            requirement: "at least 1",
        });
    }
    Ok(T::dispatch(Records {
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

impl<T: Lane> Work<T> for Records<'_, T> {
    type Output = Vec<Sums>;

    #[inline(always)]
    fn run<const N: usize, const FUSED: bool>(self) -> Vec<Sums> {
        let samples = self.samples_per_record;
        let records = (self.heading_rad.len() / samples).min(self.rudder_rad.len() / samples);
        let group = N * samples;
        let mut all = Vec::with_capacity(records);
        let mut headings = [[T::ZERO; N]; BLOCK];
        let mut rudders = [[T::ZERO; N]; BLOCK];
        for (heading, rudder) in (self.heading_rad[..records * samples].chunks(group))
            .zip(self.rudder_rad[..records * samples].chunks(group))
        {
            let mut totals = [[0.0; N]; 8];
            let mut state = None;
            for from in (0..samples).step_by(BLOCK) {
                let block = from..samples.min(from + BLOCK);
                for (signal, columns) in [(heading, &mut headings), (rudder, &mut rudders)] {
                    let records = signal.chunks_exact(samples);
                    transpose(records.map(|record| &record[block.clone()]), columns);
                }
                let pairs = headings.iter().zip(&rudders).take(block.len());
                let products = self.sums_of_block::<N, FUSED>(&mut state, pairs);
                for (totals, products) in totals.iter_mut().zip(&products.0) {
                    for (total, product) in totals.iter_mut().zip(products) {
                        *total += product.to_f64();
                    }
                }
            }
            all.extend(
                (0..heading.len() / samples).map(|j| {
                    Sums::scaled(totals.map(|total| total[j]), samples, &self.filter.scales)
                }),
            );
        }
        all
    }
}

impl<T: Lane> Records<'_, T> {
    #[inline(always)]
    fn sums_of_block<'b, const N: usize, const FUSED: bool>(
        &self,
        state: &mut Option<State<T, N>>,
        mut pairs: impl Iterator<Item = (&'b [T; N], &'b [T; N])>,
    ) -> Products<T, N> {
        let c = &self.filter.coefficients;
        let mut products = Products::ZERO;
        let mut now = match *state {
            Some(now) => now,
            None => {
                let Some((heading, rudder)) = pairs.next() else {
                    return products;
                };
                let now = self.filter.started(heading, rudder);
                products.add::<FUSED>(&now, c);
                now
            }
        };
        for (heading, rudder) in pairs {
            now.advance::<FUSED>(heading, rudder, c);
            products.add::<FUSED>(&now, c);
        }
        *state = Some(now);
        products
    }
}
