//! Edges of the rudder that fell between two samples, timed where the heading says.

use std::borrow::Cow;

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use seatrial_core::refine::Peak;
use seatrial_core::{LostRudder, Sample, YawModel};

use crate::record::median_interval_s;
use crate::record_series::{RecordSeries, RecordSpan};
use crate::servo::Servo;

/// With more edges than this each matters little.
const MOST_EDGES: usize = 32;

/// Steps in a22, the largest of them, and the difference over which its effect is taken; over a22.
const STEPS: usize = 6;
const LARGEST_STEP: f64 = 0.4;
const NUDGE: f64 = 1e-4;

/// Lags that the rudder may have, in time constants of the vehicle, and the ratios to the likeliest at which a likelier one is
/// looked for: a share is determined only where the lag is right within a fraction of the lost interval.
const LAGS: [f64; 7] = [0.05, 0.075, 0.11, 0.17, 0.25, 0.38, 0.57];
const FINER_LAGS: [f64; 2] = [1.15, 1.05];

/// Samples further apart than this share of the time constant do not show when the rudder moved.
const SLOW: f64 = 0.12;

/// A rudder movement that nobody saw.
struct Edge {
    /// Index of the sample before it.
    before: usize,
    /// In how many usual intervals it may have been.
    steps: u32,
    /// Were samples lost there?
    is_lost: bool,
}

impl Edge {
    /// The mean of the rudder over the interval when it has moved for this share of it, rad.
    fn mean_rad(&self, samples: &[Sample<f64>], share: f64) -> f64 {
        let (before, after) = (samples[self.before], samples[self.before + 1]);
        before.rudder_rad + share * (after.rudder_rad - before.rudder_rad)
    }

    /// By how much the mean over the interval leaves the heading wrong, over b2, rad s^2.
    fn coarseness_rad_s2(&self, samples: &[Sample<f64>]) -> f64 {
        let (before, after) = (samples[self.before], samples[self.before + 1]);
        let interval_s = after.time_s - before.time_s;
        (after.rudder_rad - before.rudder_rad).abs() * interval_s * interval_s / 8.0
    }

    /// The nearest share that can be.
    fn possible(&self, share: f64) -> f64 {
        match f64::from(self.steps) {
            1.0 => share.clamp(0.0, 1.0),
            steps => (share * steps).round().clamp(0.0, steps - 1.0) / steps,
        }
    }
}

/// A record with its edges timed.
pub struct EdgeTimes<'a> {
    /// The samples.
    pub samples: Cow<'a, [Sample<f64>]>,
    /// What the timing leaves uncertain of a22, b2 and C0.
    pub covariance: Matrix3<f64>,
}

/// The edges that a record hides.
pub struct Edges<'a> {
    samples: &'a [Sample<f64>],
    all: Vec<Edge>,
}

impl<'a> Edges<'a> {
    /// Looks for the intervals in which the rudder moved far while samples were lost, or in which a vehicle of this damping turns far.
    pub fn of(samples: &'a [Sample<f64>], model: Option<YawModel<f64>>) -> Self {
        let usual_s = median_interval_s(samples).unwrap_or(0.0);
        let lost = LostRudder::Interpolated;
        // Of no usual interval, every one may hide an edge.
        const ANY_S: f64 = 0.0;
        let hidden = |(before, pair): (usize, &[Sample<f64>])| {
            let interval_s = pair[1].time_s - pair[0].time_s;
            let moved_rad = pair[1].rudder_rad - pair[0].rudder_rad;
            let may_hide = lost.hides_edge(interval_s, ANY_S, moved_rad);
            may_hide.then(|| Edge {
                before,
                steps: lost.steps(interval_s, usual_s),
                is_lost: lost.hides_edge(interval_s, usual_s, moved_rad),
            })
        };
        let mut all: Vec<Edge> = samples.windows(2).enumerate().filter_map(hidden).collect();
        let first_damping = || {
            let span = RecordSpan::of(samples).ok()?;
            span.first_damping(samples, None).ok()
        };
        // Between samples an edge matters to a vehicle that turns far in a usual interval.
        let is_slow = || {
            let damping_per_s = model.map(|m| m.a22_per_s).or_else(first_damping);
            damping_per_s.is_some_and(|d| usual_s * d.abs() > SLOW)
        };
        if all.iter().any(|edge| !edge.is_lost) && !is_slow() {
            all.retain(|edge| edge.is_lost);
        }
        Self { samples, all }
    }

    /// In how many of them samples were lost.
    pub fn lost(&self) -> usize {
        self.all.iter().filter(|edge| edge.is_lost).count()
    }

    /// By how much the headings are wrong where only the mean of the rudder over an interval is known, over b2, rad s^2.
    pub fn coarseness_rad_s2(&self) -> f64 {
        self.all.iter().map(|edge| edge.coarseness_rad_s2(self.samples)).fold(0.0, f64::max)
    }

    /// The samples with the mean of the rudder over the intervals that hide an edge.
    ///
    /// ```text
    /// psi = b2 (psi_b + sum over edges s_e (psi_e - psi_b)) + C0 psi_c + psi0 + r0 psi_r      least squares in b2, b2 s_e, C0, psi0, r0
    /// mean = delta_before + s_e (delta_after - delta_before)
    /// ```
    ///
    /// with psi_b the response to the rudder that moves at the end of every such interval, psi_e to the one that moves at the start
    /// of interval e. An edge that is a lost sample late turns the vehicle by b2 times its step times the interval less for
    /// good, which many headings show. Lost rows of an even record hide the edge at one of their own instants: s_e is one of the
    /// shares that these allow. The vehicle is of first order, and its rudder acts at once or lags, whatever is likelier by more
    /// than Schwarz's price.
    pub fn edge_times(&self, start: Option<YawModel<f64>>) -> EdgeTimes<'a> {
        self.likeliest(start).unwrap_or_else(|| EdgeTimes {
            samples: Cow::Borrowed(self.samples),
            covariance: Matrix3::zeros(),
        })
    }

    fn likeliest(&self, start: Option<YawModel<f64>>) -> Option<EdgeTimes<'a>> {
        if self.all.is_empty() || self.all.len() > MOST_EDGES {
            return None;
        }
        let span = RecordSpan::of(self.samples).ok()?;
        let start_per_s = span.first_damping(self.samples, start).ok()?;
        let timed = self.behind_likeliest_lag(&span, start_per_s, true)?;
        // Where nothing was lost the rudder may have moved at the samples' own times.
        let at_samples = match self.lost() {
            0 => self.behind_likeliest_lag(&span, start_per_s, false),
            _ => None,
        };
        let price = self.all.len() as f64 * libm::log(self.samples.len() as f64);
        if at_samples.is_some_and(|held| 2.0 * (timed.log_likelihood - held.log_likelihood) < price)
        {
            return None;
        }
        Some(EdgeTimes {
            covariance: timed.covariance(&span, self)?,
            samples: Cow::Owned(timed.samples),
        })
    }

    /// The likelier of a rudder that acts at once and one behind its likeliest lag, with edges in their likeliest places or at the samples.
    fn behind_likeliest_lag(
        &self,
        span: &RecordSpan,
        start_per_s: f64,
        is_timed: bool,
    ) -> Option<Timing> {
        let scale = span.rate_scale(start_per_s);
        let behind = |lag_s: f64| Timing::new(span, self, start_per_s, lag_s, is_timed);
        let prompt = behind(0.0);
        let mut lagging = likelier(None, LAGS.map(|lag| behind(lag / scale)));
        for ratio in FINER_LAGS {
            let around = lagging.as_ref().map_or(0.0, |timing| timing.lag_s);
            lagging = likelier(lagging, [around / ratio, around * ratio].map(behind));
        }
        let price = libm::log(self.samples.len() as f64);
        let pays = |lagging: &Timing| {
            prompt
                .as_ref()
                .is_none_or(|prompt| 2.0 * (lagging.log_likelihood - prompt.log_likelihood) > price)
        };
        lagging.filter(pays).or(prompt)
    }
}

fn likelier<const N: usize>(best: Option<Timing>, others: [Option<Timing>; N]) -> Option<Timing> {
    best.into_iter()
        .chain(others.into_iter().flatten())
        .max_by(|a, b| a.log_likelihood.total_cmp(&b.log_likelihood))
}

/// Edges timed for a rudder of some lag.
struct Timing {
    lag_s: f64,
    peak: Peak,
    samples: Vec<Sample<f64>>,
    /// Log likelihood of output error, with what the means leave wrong counted as noise.
    log_likelihood: f64,
}

impl Timing {
    /// `None` where the record does not determine them.
    fn new(
        span: &RecordSpan,
        edges: &Edges,
        start_per_s: f64,
        lag_s: f64,
        is_timed: bool,
    ) -> Option<Self> {
        let servo = Servo::new(0.0, lag_s).ok()?;
        let prepared =
            |samples: &[Sample<f64>]| span.prepare(&servo.acting(samples), start_per_s).ok();
        let samples = edges.samples;
        let (a22_per_s, timed) = match is_timed {
            true => Self::timed(edges, start_per_s, &prepared)?,
            false => (start_per_s, samples.to_vec()),
        };
        let record = prepared(&timed)?;
        let peak = span.nearest_simulation(&record, a22_per_s)?;
        let comparisons = record.blocks() as f64;
        let floor_rad2 = match is_timed {
            true => (peak.fit.linear[0] * edges.coarseness_rad_s2()).powi(2),
            false => 0.0,
        };
        let mean_square_rad2 = peak.fit.residual / comparisons + floor_rad2;
        Some(Self {
            lag_s,
            peak,
            samples: timed,
            log_likelihood: -0.5 * comparisons * libm::log(mean_square_rad2),
        })
    }

    /// The damping and the samples with the edges in their likeliest places.
    fn timed(
        edges: &Edges,
        start_per_s: f64,
        prepared: &dyn Fn(&[Sample<f64>]) -> Option<RecordSeries>,
    ) -> Option<(f64, Vec<Sample<f64>>)> {
        let samples = edges.samples;
        let at_the_start = |edge: &Edge| {
            let mut moved = samples.to_vec();
            moved[edge.before].rudder_rad = edge.mean_rad(samples, 1.0);
            prepared(&moved)
        };
        let responses = Responses {
            at_the_end: prepared(samples)?,
            at_the_start: edges.all.iter().map(at_the_start).collect::<Option<_>>()?,
        };
        let (a22_per_s, shares) = responses.likeliest(start_per_s)?;
        let mut timed = samples.to_vec();
        for (edge, share) in edges.all.iter().zip(shares) {
            timed[edge.before].rudder_rad = edge.mean_rad(samples, edge.possible(share));
        }
        Some((a22_per_s, timed))
    }

    /// ```text
    /// V = sum over edges (theta_e - theta)(theta_e - theta)^T
    /// ```
    ///
    /// with theta_e by output error when edge e comes h/sqrt(12) sooner: it is known to a usual interval h, because rudder and
    /// heading may come in messages of their own.
    fn covariance(&self, span: &RecordSpan, edges: &Edges) -> Option<Matrix3<f64>> {
        let servo = Servo::new(0.0, self.lag_s).ok()?;
        let theta = Vector3::from(self.peak.normal().0);
        let mut covariance = Matrix3::zeros();
        for edge in &edges.all {
            let sooner = 1.0 / (f64::from(edge.steps) * 12_f64.sqrt());
            let (before, after) = (edges.samples[edge.before], edges.samples[edge.before + 1]);
            let mut samples = self.samples.clone();
            samples[edge.before].rudder_rad += sooner * (after.rudder_rad - before.rudder_rad);
            let acting = servo.acting(&samples);
            let record = span.prepare(&acting, self.peak.a22_per_s).ok()?;
            let moved = span.nearest_simulation(&record, self.peak.a22_per_s)?;
            let off = Vector3::from(moved.normal().0) - theta;
            covariance += off * off.transpose();
        }
        Some(covariance)
    }
}

/// The record with every edge at the end of its interval, and with one of them at the start.
struct Responses {
    at_the_end: RecordSeries,
    at_the_start: Vec<RecordSeries>,
}

impl Responses {
    /// a22 and the shares s_e, by steps of Gauss and Newton in a22 with the rest solved for at each (variable projection).
    fn likeliest(&self, start_per_s: f64) -> Option<(f64, Vec<f64>)> {
        let mut a22_per_s = start_per_s;
        let mut shares = Vec::new();
        for _ in 0..STEPS {
            let (now, heading) = self.columns(a22_per_s);
            let nudge_per_s = NUDGE * a22_per_s;
            let (nudged, _) = self.columns(a22_per_s + nudge_per_s);
            let linear = least_squares(&now, &heading)?;
            let slope = (nudged - &now) * &linear / nudge_per_s;
            let known = now.ncols();
            let mut extended = now.insert_column(known, 0.0);
            extended.set_column(known, &slope);
            let solution = least_squares(&extended, &heading)?;
            shares = (4..known).map(|edge| solution[edge] / solution[0]).collect();
            let largest = LARGEST_STEP * a22_per_s.abs();
            a22_per_s += solution[known].clamp(-largest, largest);
        }
        Some((a22_per_s, shares))
    }

    /// Columns psi_b, psi_c, 1, psi_r and psi_e - psi_b of each edge, and the heading.
    fn columns(&self, a22_per_s: f64) -> (DMatrix<f64>, DVector<f64>) {
        let at_the_end = self.at_the_end.comparisons(a22_per_s);
        let at_the_start: Vec<_> =
            self.at_the_start.iter().map(|r| r.comparisons(a22_per_s)).collect();
        let matrix =
            DMatrix::from_fn(
                at_the_end.len(),
                4 + at_the_start.len(),
                |row, column| match column {
                    0..4 => at_the_end[row][column],
                    edge => at_the_start[edge - 4][row][0] - at_the_end[row][0],
                },
            );
        let heading = DVector::from_fn(at_the_end.len(), |row, _| at_the_end[row][4]);
        (matrix, heading)
    }
}

fn least_squares(columns: &DMatrix<f64>, heading: &DVector<f64>) -> Option<DVector<f64>> {
    let scale = DVector::from_fn(columns.ncols(), |column, _| columns.column(column).norm());
    if !scale.iter().all(|length| *length > 0.0) {
        return None;
    }
    let scaled = DMatrix::from_fn(columns.nrows(), columns.ncols(), |row, column| {
        columns[(row, column)] / scale[column]
    });
    let normal = scaled.tr_mul(&scaled).cholesky()?;
    Some(normal.solve(&scaled.tr_mul(heading)).component_div(&scale))
}
