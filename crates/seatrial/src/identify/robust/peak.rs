//! The peak of the restricted likelihood under one noise.

use std::rc::Rc;

use seatrial_core::whitening::Covariance;

use super::belief::{Equations, LOG_TAU};
use super::linearised::{COLUMNS, Linearisation};
use super::noise::{Noise, whitened_products};
use super::record::{A22, B2, C0, DELAY, FIRST, HEADING, LAG2, PARAMETERS, Point, RATE, Record};

/// A lag of more time constants of the vehicle is not looked for: it would be the vehicle.
const LONGEST_LAG: f64 = 1.0;

/// No lag of more than this share of the record is looked for.
const LONGEST_SHARE: f64 = 0.05;

/// A peak that carries weight is found to about so many standard deviations, and another one.
const NEAR: f64 = 0.005;
const NEAR_ENOUGH: f64 = 0.3;

/// The noise is estimated anew so often: its beliefs about lag and first rudder hardly change it.
const MOST_NOISES: u32 = 4;

/// A damping of more than this over a sample interval is none that a record shows: what turns the vehicle is over before the next sample.
const FASTEST: f64 = 2.0;

/// Parameters that no belief bounds: b2, C0, psi0, r0, a22.
const FREE: f64 = 5.0;

/// A peak of the likelihood as a normal distribution of which v < 0 is to be cut off.
#[derive(Clone, Copy, Debug)]
pub struct Peak {
    /// Noise and disturbance.
    pub noise: Noise,
    /// Does the rudder act at once, or with a known delay?
    pub prompt: bool,
    /// Where the likelihood is largest with v >= 0.
    pub point: Point,
    /// Before the cut.
    pub mean: [f64; PARAMETERS],
    /// Before the cut.
    pub covariance: [[f64; PARAMETERS]; PARAMETERS],
    /// Standard deviation of the error of a comparison, rad.
    pub noise_rad: f64,
    /// Log of the probability of the record, before the cut.
    pub log_evidence: f64,
}

impl Peak {
    /// Covariance of the parameters, with the lag held where its bound holds it: there its derivative of the likelihood is
    /// not 0.
    pub fn covariance_at_the_point(&self) -> [[f64; PARAMETERS]; PARAMETERS] {
        let own = &self.covariance;
        if self.mean[LAG2] == self.point.0[LAG2] {
            return *own;
        }
        let mut held = Covariance(*own);
        held.measure(LAG2, 0.0);
        held.0
    }
}

/// The search for peaks of one record.
#[derive(Clone, Debug)]
pub struct Search<'a> {
    record: &'a Record,
    block: usize,
    prompt: bool,
    around: Rc<Linearisation>,
    noise_rad: f64,
}

impl<'a> Search<'a> {
    /// From a point, of a `prompt` rudder, which acts at once or with the known delay, or of one that may lag.
    pub fn new(record: &'a Record, start: &Point, block: usize, prompt: bool) -> Self {
        let mut start = *start;
        if prompt {
            let delay_s = record.known_delay_s.unwrap_or(0.0);
            start.0[FIRST] = 0.0;
            start.0[DELAY] = delay_s;
            start.0[LAG2] = delay_s.max(0.0).powi(2);
        }
        let around = Rc::new(record.linearised(&start, block, prompt));
        let square: f64 = around.rows.iter().map(|row| row[PARAMETERS].powi(2)).sum();
        Self {
            record,
            block,
            prompt,
            noise_rad: (square / around.rows.len() as f64).sqrt(),
            around,
        }
    }

    /// The record.
    pub fn record(&self) -> &'a Record {
        self.record
    }

    /// Around the last point.
    pub fn around(&self) -> &Linearisation {
        &self.around
    }

    /// The peak under one noise, by steps of Gauss and Newton from where the last one was found; a step that makes the fit worse
    /// is halved. `None` where the record determines no vehicle, or one that is faster than its samples.
    pub fn peak(
        &mut self,
        noise: Noise,
        passes: u32,
        carries_weight: impl Fn(&Peak) -> bool,
    ) -> Option<Peak> {
        let mut best: Option<(f64, Rc<Linearisation>)> = None;
        let mut found = None;
        for _ in 0..passes {
            let (peak, square_rad2) = self.step(&noise)?;
            if let Some((least_rad2, from)) = &best
                && square_rad2 > *least_rad2 * (1.0 + 1e-9)
            {
                let (here, from) = (self.around.point.0, from.point.0);
                let half = core::array::from_fn(|i| 0.5 * (here[i] + from[i]));
                self.around = self.linearised(&Point(half));
                continue;
            }
            let (next, share) = self.next(&peak);
            let from = self.around.point.0;
            let left = self.left(&peak, &next);
            let mean: [f64; PARAMETERS] =
                core::array::from_fn(|i| from[i] + share * (peak.mean[i] - from[i]));
            if next.0[A22].abs().max(mean[A22].abs()) * self.record.interval_s > FASTEST {
                return None;
            }
            let peak = Peak { point: next, mean, ..peak };
            if left < NEAR || (left < NEAR_ENOUGH && share == 1.0 && !carries_weight(&peak)) {
                return Some(peak);
            }
            found = Some(peak);
            let around = self.linearised(&next);
            best = Some((square_rad2, core::mem::replace(&mut self.around, around)));
        }
        if let Some((_, around)) = best {
            self.around = around;
        }
        found
    }

    fn linearised(&self, point: &Point) -> Rc<Linearisation> {
        Rc::new(self.record.linearised(point, self.block, self.prompt))
    }

    /// How far about a linearisation around the next point would move it again, in standard deviations.
    ///
    /// ```text
    /// max( (delta a22)^2 / (|a22| sigma),  (delta s)^2 / (2 sigma^2),  (delta v)^2 / (2 sigma^2) )
    /// ```
    ///
    /// Steps of Gauss and Newton become small by squares: over the damping itself, and over the own deviations of lag and shift, which
    /// their beliefs bend over.
    fn left(&self, peak: &Peak, next: &Point) -> f64 {
        let from = &self.around.point.0;
        let deviations = |i: usize| (next.0[i] - from[i]).abs() / peak.covariance[i][i].sqrt();
        let rate = from[A22].abs().max(0.5 / self.record.duration_s());
        let of_damping = deviations(A22) * (next.0[A22] - from[A22]).abs() / rate;
        let of_lag = [DELAY, LAG2].map(|i| 0.5 * deviations(i).powi(2));
        of_lag.into_iter().fold(of_damping, f64::max)
    }

    /// A peak with noise and covariance of the linearisation around the last point.
    pub fn relinearised(&mut self, peak: &Peak) -> Peak {
        match self.step(&peak.noise) {
            Some((here, _)) => {
                Peak { covariance: here.covariance, noise_rad: here.noise_rad, ..*peak }
            }
            None => *peak,
        }
    }

    /// The normal distribution that the linearised record gives, and the square at the point itself, rad^2.
    fn step(&mut self, noise: &Noise) -> Option<(Peak, f64)> {
        let (gram, log_variances) = gram(&self.around, noise, self.prompt);
        let point = &self.around.point;
        let n = self.around.rows.len() as f64;
        let floor_rad = self.record.floor_rad / (self.block as f64).sqrt();
        let equations = |noise_rad: f64| {
            let mut equations = of_data(&gram, noise_rad);
            match self.prompt {
                true => equations.believe_in_none(),
                false => equations.believe_in_lag(self.record, point),
            }
            equations
        };
        let mut noise_rad = self.noise_rad.max(floor_rad);
        let mut here = equations(noise_rad);
        for _ in 0..MOST_NOISES {
            let left = here.best_square()?;
            let next = ((left / (n - FREE)).sqrt() * noise_rad).max(floor_rad);
            let is_settled = (next / noise_rad - 1.0).abs() < 1e-4;
            noise_rad = next;
            here = equations(noise_rad);
            if is_settled {
                break;
            }
        }
        self.noise_rad = noise_rad;
        let square_rad2 = here.square * noise_rad * noise_rad;
        let (solution, log_constant) = (here.solve()?, here.log_constant);
        let parameters = if self.prompt { FREE } else { PARAMETERS as f64 };
        let rate = point.0[A22].abs().max(0.5 / self.record.duration_s());
        let peak = Peak {
            noise: *noise,
            prompt: self.prompt,
            point: *point,
            mean: core::array::from_fn(|i| point.0[i] + solution.change[i]),
            covariance: solution.covariance,
            noise_rad,
            log_evidence: 0.5 * parameters * LOG_TAU + log_constant
                - libm::log(rate)
                - 0.5 * (n * (LOG_TAU + 2.0 * libm::log(noise_rad)) + log_variances)
                - 0.5 * (solution.square + solution.log_determinant),
        };
        Some((peak, square_rad2))
    }

    /// The best point with a lag that may be, no further than the linearisation reaches, and the share of the step that is taken.
    fn next(&self, peak: &Peak) -> (Point, f64) {
        let from = &self.around.point.0;
        let rate = from[A22].abs().max(0.5 / self.record.duration_s());
        let longest_s = (LONGEST_LAG / rate).min(LONGEST_SHARE * self.record.duration_s());
        let mut next = peak.mean;
        if !self.prompt {
            let bounded = next[LAG2].clamp(0.0, longest_s * longest_s);
            let away = (bounded - next[LAG2]) / peak.covariance[LAG2][LAG2];
            for (parameter, column) in next.iter_mut().zip(&peak.covariance) {
                *parameter += column[LAG2] * away;
            }
            next[LAG2] = bounded;
        }
        let of_damping = (next[A22] - from[A22]).abs() / (0.4 * rate);
        let of_delay = (next[DELAY] - from[DELAY]).abs() / (0.4 / rate + self.record.interval_s);
        let share = 1.0 / of_damping.max(of_delay).max(1.0);
        let point = Point(core::array::from_fn(|i| from[i] + share * (next[i] - from[i])));
        (point, share)
    }
}

/// Products of the whitened columns, and the sum of the log variances; the held columns of a prompt rudder are 0.
fn gram(around: &Linearisation, noise: &Noise, prompt: bool) -> ([[f64; COLUMNS]; COLUMNS], f64) {
    const PROMPT: [usize; 6] = [B2, C0, HEADING, RATE, A22, PARAMETERS];
    // A column more makes the number of them even.
    const LAGGING: [usize; 10] =
        [B2, C0, HEADING, RATE, FIRST, A22, DELAY, LAG2, PARAMETERS, PARAMETERS];
    match prompt {
        true => gram_of(around, noise, &PROMPT, |row| PROMPT.map(|column| row[column])),
        false => gram_of(around, noise, &LAGGING, |row| LAGGING.map(|column| row[column])),
    }
}

/// The Gram matrix of these columns.
#[inline(always)]
fn gram_of<const N: usize>(
    around: &Linearisation,
    noise: &Noise,
    columns: &[usize; N],
    of_row: impl Fn(&[f64; COLUMNS]) -> [f64; N],
) -> ([[f64; COLUMNS]; COLUMNS], f64) {
    let rows = around.rows.iter().map(of_row);
    let (products, log_variances) = whitened_products(&around.time_s, rows, noise);
    let mut gram = [[0.0; COLUMNS]; COLUMNS];
    for (i, of_i) in columns.iter().zip(&products) {
        for (j, product) in columns.iter().zip(of_i).filter(|(j, _)| *j >= i) {
            gram[*i][*j] = *product;
        }
    }
    (gram, log_variances)
}

fn of_data(gram: &[[f64; COLUMNS]; COLUMNS], noise_rad: f64) -> Equations {
    let precision = 1.0 / (noise_rad * noise_rad);
    let mut equations = Equations {
        information: [[0.0; PARAMETERS]; PARAMETERS],
        right: [0.0; PARAMETERS],
        square: gram[PARAMETERS][PARAMETERS] * precision,
        log_constant: 0.0,
    };
    for (i, products) in gram.iter().take(PARAMETERS).enumerate() {
        for (j, product) in products.iter().enumerate().take(PARAMETERS).skip(i) {
            equations.information[i][j] = product * precision;
            equations.information[j][i] = product * precision;
        }
        equations.right[i] = products[PARAMETERS] * precision;
    }
    equations
}
