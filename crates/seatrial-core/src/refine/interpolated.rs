//! The peak of a likelihood between four dampings, from one pass over the record.

use libm::{exp, log, sqrt};

use super::{Disturbance, Peak, Series, SteeringFit};

/// Where a peak is looked for, and how wide it may be.
#[derive(Clone, Copy, Debug)]
pub struct PeakGuess {
    /// 1/s
    pub a22_per_s: f64,
    /// Standard deviation of a22, 1/s.
    pub deviation_per_s: f64,
}

impl PeakGuess {
    /// Where `last` led from the peak before it, in logarithms: as a disturbance grows, both grow with it.
    pub fn after(before: &Peak, last: &Peak) -> Self {
        let ratio = last.a22_per_s / before.a22_per_s;
        let a22_per_s = match ratio > 0.0 {
            true => last.a22_per_s * ratio.clamp(0.4, 2.5),
            false => 2.0 * last.a22_per_s - before.a22_per_s,
        };
        let ratio = sqrt(last.variance / before.variance).clamp(0.5, 2.0);
        Self { a22_per_s, deviation_per_s: sqrt(last.variance) * ratio }
    }
}

impl From<&Peak> for PeakGuess {
    fn from(peak: &Peak) -> Self {
        Self { a22_per_s: peak.a22_per_s, deviation_per_s: sqrt(peak.variance) }
    }
}

/// Distance of neighbouring dampings in standard deviations of a22.
const SPREAD: f64 = 0.5;

/// The distance may be this many standard deviations, or the dampings are chosen anew.
const WIDEST_SPREAD: f64 = 0.8;

/// The distance may be this share of the damping.
const WIDEST_SHARE: f64 = 0.12;

/// In distances of neighbouring dampings from their middle: a peak is read off the cubic no further away than the outermost of them.
const OUTERMOST: f64 = 2.0;

/// No further than this the dampings move at once.
const LONGEST_MOVE: f64 = 4.0;

/// In scales of the damping: a peak this near its start is one that [`Peak::find`] finds, and one this far away one that it does not.
const REACH: [f64; 2] = [3.5, 7.2];

/// Passes after which the search is left to [`Peak::find`].
const MOST_PASSES: u32 = 4;

/// A cubic through values at -1.5, -0.5, 0.5 and 1.5.
#[derive(Clone, Copy, Debug)]
struct Cubic([f64; 4]);

impl Cubic {
    fn through([y0, y1, y2, y3]: [f64; 4]) -> Self {
        Self([
            (9.0 * (y1 + y2) - (y0 + y3)) / 16.0,
            (27.0 * (y2 - y1) - (y3 - y0)) / 24.0,
            ((y3 + y0) - (y2 + y1)) / 4.0,
            ((y3 - y0) - 3.0 * (y2 - y1)) / 6.0,
        ])
    }

    fn at(&self, x: f64) -> f64 {
        let Self([a0, a1, a2, a3]) = self;
        a0 + x * (a1 + x * (a2 + x * a3))
    }

    fn slope(&self, x: f64) -> f64 {
        let Self([_, a1, a2, a3]) = self;
        a1 + x * (2.0 * a2 + x * 3.0 * a3)
    }

    fn curvature(&self, x: f64) -> f64 {
        let Self([_, _, a2, a3]) = self;
        2.0 * a2 + 6.0 * a3 * x
    }

    /// Where it is least.
    fn minimum(&self) -> Option<f64> {
        let Self([_, a1, a2, a3]) = self;
        let root = a2 * a2 - 3.0 * a1 * a3;
        (root > 0.0 && *a2 > 0.0).then(|| -a1 / (a2 + sqrt(root)))
    }
}

/// The search for a peak near an expected one.
pub struct Near {
    /// Where [`Peak::find`] begins, 1/s.
    pub start_per_s: f64,
    pub expected: PeakGuess,
    /// Scale of the damping, 1/s.
    pub scale_per_s: f64,
    /// A peak with a lower log likelihood may be read off from further away.
    pub of_interest: f64,
}

impl Near {
    /// The peak, by a cubic through J(a22) = exp(-2 l / n) at four dampings, half a standard deviation apart.
    ///
    /// b2, C0, their covariance and the noise are read off cubics through their values at the four. J over two standard
    /// deviations is so nearly quadratic that what the cubic leaves out is within the tolerance of [`Peak::find`], which ends where a
    /// step is less than 0.02 standard deviations. Where the dampings do not hold the peak they are moved; where that leads
    /// nowhere, that search decides.
    pub fn peak(&self, record: &Series<'_>, disturbance: Disturbance) -> Option<Peak> {
        let search = || Peak::find(record, disturbance, self.start_per_s, self.scale_per_s);
        let mut expected = self.expected;
        for _ in 0..MOST_PASSES {
            let Some(four) = Four::around(record, disturbance, &expected, self.scale_per_s) else {
                break;
            };
            let Some(minimum) = four.minimum(record.blocks() as f64) else {
                break;
            };
            let a22_per_s = four.at(minimum.place);
            let deviation_per_s = sqrt(minimum.variance);
            let is_inside = minimum.place.abs() <= OUTERMOST
                && four.spread_per_s <= WIDEST_SPREAD * deviation_per_s;
            let is_near =
                minimum.place.abs() <= LONGEST_MOVE && minimum.log_likelihood < self.of_interest;
            if is_inside || is_near {
                let distance = (a22_per_s - self.start_per_s).abs() / self.scale_per_s;
                return match distance {
                    distance if distance > REACH[1] => None,
                    distance if distance > REACH[0] => search(),
                    _ => {
                        Some(four.peak(disturbance, &minimum)).filter(Peak::is_one).or_else(search)
                    }
                };
            }
            expected = PeakGuess {
                a22_per_s: four.at(minimum.place.clamp(-LONGEST_MOVE, LONGEST_MOVE)),
                deviation_per_s,
            };
        }
        search()
    }
}

/// Four dampings at equal distances and what a record says at each.
struct Four {
    centre_per_s: f64,
    spread_per_s: f64,
    fits: [SteeringFit; 4],
}

/// The least J between the four.
struct Minimum {
    /// In distances of neighbouring dampings from their middle.
    place: f64,
    /// Variance of a22, 1/s^2.
    variance: f64,
    log_likelihood: f64,
}

impl Four {
    fn around(
        record: &Series<'_>,
        disturbance: Disturbance,
        expected: &PeakGuess,
        scale_per_s: f64,
    ) -> Option<Self> {
        let centre_per_s = expected.a22_per_s;
        let spread_per_s = (SPREAD * expected.deviation_per_s)
            .max(1e-6 * scale_per_s)
            .min(WIDEST_SHARE * scale_per_s.max(centre_per_s.abs()));
        let dampings = [-1.5, -0.5, 0.5, 1.5].map(|place| centre_per_s + place * spread_per_s);
        let [a, b, c, d] = record.steering_fits(dampings, disturbance);
        Some(Self { centre_per_s, spread_per_s, fits: [a?, b?, c?, d?] })
    }

    fn at(&self, place: f64) -> f64 {
        self.centre_per_s + place * self.spread_per_s
    }

    /// `None` where J has no minimum.
    fn minimum(&self, comparisons: f64) -> Option<Minimum> {
        let reference = self.fits[1].log_likelihood;
        let cost = Cubic::through(
            (self.fits).map(|fit| exp(-2.0 * (fit.log_likelihood - reference) / comparisons)),
        );
        let place = cost.minimum()?;
        let least = cost.at(place);
        let variance = 2.0 * least * self.spread_per_s * self.spread_per_s
            / (comparisons * cost.curvature(place));
        (variance > 0.0).then(|| Minimum {
            place,
            variance,
            log_likelihood: reference - 0.5 * comparisons * log(least),
        })
    }

    fn peak(&self, disturbance: Disturbance, minimum: &Minimum) -> Peak {
        let place = minimum.place;
        let b2_and_c0 = [0, 1].map(|i| Cubic::through(self.fits.map(|fit| fit.linear[i])));
        let between = |values| Cubic::through(values).at(place);
        Peak {
            disturbance,
            a22_per_s: self.at(place),
            variance: minimum.variance,
            fit: SteeringFit {
                log_likelihood: minimum.log_likelihood,
                ..SteeringFit::interpolated(self.fits.each_ref(), between)
            },
            slope: b2_and_c0.map(|of| of.slope(place) / self.spread_per_s),
        }
    }
}

impl Peak {
    /// Has it variances? What is read off a record without noise, where they span many orders, may have none.
    pub fn is_one(&self) -> bool {
        let of_linear = &self.fit.scaled_covariance;
        let variances =
            [self.variance, self.fit.noise_variance_rad2, of_linear[0][0], of_linear[1][1]];
        variances.iter().all(|variance| *variance > 0.0) && self.fit.log_likelihood.is_finite()
    }

    /// The peak at half the strength of `last`, in a series of powers of the strength's square through `none`, `last` and that at twice its
    /// strength, `before`.
    pub fn at_half_the_strength(none: &Self, last: &Self, before: &Self) -> Self {
        let of = |[none, last, before]: [f64; 3]| (45.0 * none + 20.0 * last - before) / 64.0;
        let peaks = [none, last, before];
        Self {
            disturbance: Disturbance {
                relative: 0.5 * last.disturbance.relative,
                ..last.disturbance
            },
            a22_per_s: of(peaks.map(|peak| peak.a22_per_s)),
            variance: of(peaks.map(|peak| peak.variance)),
            fit: SteeringFit::interpolated(peaks.map(|peak| &peak.fit), of),
            slope: core::array::from_fn(|i| of(peaks.map(|peak| peak.slope[i]))),
        }
    }
}

impl SteeringFit {
    /// Each number from those of several fits.
    fn interpolated<const M: usize>(fits: [&Self; M], between: impl Fn([f64; M]) -> f64) -> Self {
        let of = |value: &dyn Fn(&Self) -> f64| between(fits.map(value));
        Self {
            linear: core::array::from_fn(|i| of(&|fit| fit.linear[i])),
            scaled_covariance: core::array::from_fn(|i| {
                core::array::from_fn(|j| of(&|fit| fit.scaled_covariance[i][j]))
            }),
            residual: of(&|fit| fit.residual),
            noise_variance_rad2: of(&|fit| fit.noise_variance_rad2),
            log_likelihood: of(&|fit| fit.log_likelihood),
        }
    }
}
