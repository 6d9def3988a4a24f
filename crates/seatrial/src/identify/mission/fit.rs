//! The likeliest vehicle of an ordinary log under one hypothesis, with what is not known of it.

use nalgebra::{DMatrix, DVector, Vector4};

use super::filter::{COLUMNS, Point, SpeedLaw, Sums, each_innovation};
use super::record::Legs;
use crate::identify::robust::estimate::LEAST_EVIDENCE;
use crate::likelihood::fit::log_determinant;
use crate::likelihood::hypothesis::Parameter;
use crate::likelihood::steering_model::log_steady_gain;
use crate::likelihood::{Structure, Vehicle};

/// What is supposed of vehicle and disturbance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hypothesis {
    /// How the speed matters.
    pub law: SpeedLaw,
    /// Does the gear lag, not only the record?
    pub lag: bool,
    /// Are there waves of a narrow band?
    pub waves: bool,
    /// Does damping grow with the turn?
    pub growth: bool,
    /// Does sway act on yaw?
    pub sway: bool,
    /// Has the gear a largest rate?
    pub rate_limit: bool,
}

impl Hypothesis {
    /// What the hull has beside linear damping.
    pub fn hull_parameters(&self) -> Vec<Parameter> {
        let hull = Structure {
            quadratic: self.growth,
            sway: self.sway,
            rate_limit: self.rate_limit,
            ..Structure::FIRST_ORDER
        };
        let is_linear = |p: &Parameter| matches!(p, Parameter::Damping | Parameter::Authority);
        hull.parameters()
            .into_iter()
            .filter(|p| !is_linear(p))
            .collect()
    }
}

/// Sizes of the log by which parameters are scaled.
#[derive(Clone, Copy, Debug)]
pub struct Scale {
    /// Damping of the first look, 1/s.
    pub rate_per_s: f64,
    /// Deviation of the yaw rate, rad/s.
    pub yaw_rate_rad_s: f64,
    /// Amplitude of the rudder, rad.
    pub rudder_rad: f64,
    /// A third of the largest rate of the rudder, rad/s; 0 before a slow gear is looked for.
    pub slew_rad_s: f64,
    /// Mean size of the yaw rate that a filter saw, rad/s; 0 before one ran.
    pub turning_rad_s: f64,
    pub(super) has_gyro: bool,
}

/// A hypothesis at its largest posterior.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The hypothesis.
    pub hypothesis: Hypothesis,
    /// Scaled parameters: damping, shift, noise of the gyro, strength and time of the sea, delay of the speed, lag, waves.
    pub x: DVector<f64>,
    /// What they are.
    pub point: Point,
    /// b, c and the bias of the gyro.
    pub linear: [f64; 3],
    /// Variance of the heading noise, rad^2.
    pub variance_rad2: f64,
    /// Log of the determinant of the information of the linear parameters, in units of that variance.
    pub linear_log_determinant: f64,
    /// Minus log of likelihood and priors, restricted.
    pub cost: f64,
}

impl Fit {
    /// [d, b, c, shift + lag].
    pub fn values(&self) -> Vector4<f64> {
        let [b, c, _] = self.linear;
        Vector4::new(
            self.point.damping_per_s,
            b,
            c,
            self.point.shift_s + self.point.lag_s,
        )
    }

    /// Log of K, 1/s, of the steady turn at a rudder amplitude, rad.
    pub fn log_gain(&self, amplitude_rad: f64) -> f64 {
        log_steady_gain(&self.vehicle(), amplitude_rad)
    }

    /// The vehicle behind its delay.
    pub fn vehicle(&self) -> Vehicle {
        let point = &self.point;
        let [coupling_per_s2, sway_s] = point.sway;
        Vehicle {
            damping_per_s: point.damping_per_s,
            authority_per_s2: self.linear[0],
            shift_s: 0.0,
            lag_s: 0.0,
            rate_limit_rad_s: point.rate_limit_rad_s,
            play_rad: 0.0,
            quadratic_per_rad: point.growth[0],
            coupling_per_s2,
            sway_s: if coupling_per_s2 == 0.0 { 1.0 } else { sway_s },
        }
    }
}

pub(super) const SHIFT: usize = 1;
const GYRO: usize = 2;
const SEA: usize = 3;
const SEA_TIME: usize = 4;
const SPEED_LATE: usize = 5;
pub(super) const LAG: usize = 6;
const GROWTH: usize = 7;
const COUPLING: usize = 8;
const SWAY_TIME: usize = 9;
const RATE_LIMIT: usize = 10;
const WAVE: usize = 11;
const WAVE_FREQUENCY: usize = 12;
const WAVE_RATIO: usize = 13;

/// Prior deviation of the logarithm of a lag about 0.15 time constants.
pub(super) const LAG_DEVIATION: f64 = 1.2;
/// Prior deviation of the time by which the speed is logged late, in time constants.
const SPEED_LATE_DEVIATION: f64 = 0.3;
/// Prior deviation of a shift of the record, in time constants.
const SHIFT_DEVIATION: f64 = 0.2;

/// A problem: legs under a scale.
pub struct Problem<'a> {
    pub(super) legs: &'a Legs,
    /// The scale.
    pub scale: Scale,
}

impl<'a> Problem<'a> {
    /// A first look at the damping of these legs. `None` where no damping gives numbers.
    pub fn new(legs: &'a Legs) -> Option<(Self, Fit)> {
        const LOOKS: i32 = 14;
        let longest_s = legs
            .legs
            .iter()
            .map(|leg| leg.duration_s())
            .fold(0.0, f64::max);
        let yaw_rate_rad_s = legs.yaw_rate_deviation_rad_s();
        let rudder_rad = legs.rudder_amplitude_rad();
        let has_gyro = legs.legs.iter().any(|leg| !leg.yaw_rate_rad_s.is_empty());
        let (slowest, fastest) = (
            libm::log(10.0 / longest_s),
            libm::log(0.7 / legs.interval_s),
        );
        let hypothesis = Hypothesis {
            law: SpeedLaw::Constant,
            lag: false,
            waves: false,
            growth: false,
            sway: false,
            rate_limit: false,
        };
        let mut best: Option<(Self, Fit)> = None;
        for k in 0..LOOKS {
            let rate =
                libm::exp(slowest + (fastest - slowest) * f64::from(k) / f64::from(LOOKS - 1));
            let problem = Self {
                legs,
                scale: Scale {
                    rate_per_s: rate,
                    yaw_rate_rad_s,
                    rudder_rad,
                    slew_rad_s: 0.0,
                    turning_rad_s: 0.0,
                    has_gyro,
                },
            };
            for strength in [-4.0, -1.0, 2.0] {
                let mut x = problem.start(hypothesis);
                x[SEA] = strength;
                let Some(fit) = problem.at(hypothesis, &x) else {
                    continue;
                };
                if best.as_ref().is_none_or(|(_, b)| fit.cost < b.cost) {
                    best = Some((Self { ..problem }, fit));
                }
            }
        }
        best
    }

    fn start(&self, hypothesis: Hypothesis) -> DVector<f64> {
        let size = if hypothesis.waves { WAVE + 3 } else { WAVE };
        let mut x = DVector::zeros(size);
        x[0] = 1.0;
        x
    }

    /// Which parameters are free.
    pub(super) fn free(&self, hypothesis: Hypothesis) -> Vec<usize> {
        let is_free = |i: &usize| match *i {
            GYRO => self.scale.has_gyro,
            LAG => hypothesis.lag,
            GROWTH => hypothesis.growth,
            COUPLING | SWAY_TIME => hypothesis.sway,
            RATE_LIMIT => hypothesis.rate_limit,
            SPEED_LATE => hypothesis.law == SpeedLaw::Proportional,
            _ => true,
        };
        (0..self.start(hypothesis).len()).filter(is_free).collect()
    }

    pub(super) fn point(&self, hypothesis: Hypothesis, x: &DVector<f64>) -> Point {
        let rate = self.scale.rate_per_s;
        let exp = |x: f64| libm::exp(x.clamp(-14.0, 14.0));
        // Noise of the heading about a hundredth of what the vehicle turns in a time constant.
        Point {
            damping_per_s: x[0] * rate,
            shift_s: x[SHIFT].clamp(-3.0, 3.0) / rate,
            lag_s: if hypothesis.lag {
                0.15 * exp(x[LAG]) / rate
            } else {
                0.0
            },
            gyro_noise: exp(x[GYRO]),
            sea: [10.0 * exp(x[SEA]) * rate * rate, exp(x[SEA + 1]) / rate],
            wave: match hypothesis.waves {
                true => [
                    10.0 * exp(x[WAVE]) * rate * rate,
                    exp(x[WAVE_FREQUENCY]) * rate,
                    0.1 * exp(x[WAVE_RATIO]).min(5.0),
                ],
                false => [0.0, 1.0, 0.5],
            },
            speed_late_s: x[SPEED_LATE].clamp(-2.0, 2.0) / rate,
            law: hypothesis.law,
            growth: match hypothesis.growth {
                true => [
                    0.3 * exp(x[GROWTH]) * rate / self.scale.yaw_rate_rad_s,
                    self.scale.turning_rad_s,
                ],
                false => [0.0; 2],
            },
            sway: match hypothesis.sway {
                true => [x[COUPLING] * rate * rate, exp(x[SWAY_TIME]) / rate],
                false => [0.0; 2],
            },
            rate_limit_rad_s: match hypothesis.rate_limit {
                true => exp(x[RATE_LIMIT]) * self.scale.slew_rad_s,
                false => f64::INFINITY,
            },
        }
    }

    fn prior(&self, hypothesis: Hypothesis, x: &DVector<f64>) -> f64 {
        let squares = self
            .free(hypothesis)
            .into_iter()
            .filter_map(|i| Some((x[i], belief(i)?)));
        0.5 * squares
            .map(|(x, [mean, deviation])| ((x - mean) / deviation).powi(2))
            .sum::<f64>()
    }

    /// The linear parameters, noise and cost at a point. `None` where they are no numbers.
    pub fn at(&self, hypothesis: Hypothesis, x: &DVector<f64>) -> Option<Fit> {
        let point = self.point(hypothesis, x);
        // Gear and vehicle are told apart by which is slower.
        if point.lag_s * point.damping_per_s > 1.0 {
            return None;
        }
        let mut all = Sums::default();
        each_innovation(
            self.legs,
            &point,
            self.scale.yaw_rate_rad_s,
            |e, variance| {
                all.add(e, variance);
            },
        );
        let (linear, left, log_determinant) = self.linear(&all)?;
        let freedom = all.count - 3.0;
        let variance_rad2 = left / freedom;
        let cost = 0.5 * freedom * libm::log(variance_rad2)
            + all.log_deviations
            + 0.5 * log_determinant
            + self.prior(hypothesis, x);
        cost.is_finite().then(|| Fit {
            hypothesis,
            x: x.clone(),
            point,
            linear,
            variance_rad2,
            linear_log_determinant: log_determinant,
            cost,
        })
    }

    /// Least squares of the linear parameters: their values, the sum of squares that is left, and the log determinant.
    fn linear(&self, all: &Sums) -> Option<([f64; 3], f64, f64)> {
        let columns = if self.scale.has_gyro {
            COLUMNS
        } else {
            COLUMNS - 1
        };
        let g = |a: usize, b: usize| all.products[a.min(b)][a.max(b)];
        let information = DMatrix::from_fn(columns - 1, columns - 1, |i, j| g(i + 1, j + 1));
        let right = DVector::from_fn(columns - 1, |i, _| g(0, i + 1));
        let factor = information.cholesky()?;
        // The innovation of what a column adds is minus that of the column.
        let solution = -factor.solve(&right);
        let left = g(0, 0) + right.dot(&solution);
        let mut linear = [0.0; 3];
        linear
            .iter_mut()
            .zip(solution.iter())
            .for_each(|(l, s)| *l = *s);
        (left > 0.0).then_some((linear, left, log_determinant(&factor)))
    }

    /// The largest posterior from a start, by Fisher's scoring with Levenberg's damping.
    pub fn fit(&self, hypothesis: Hypothesis, start: &DVector<f64>) -> Option<Fit> {
        const STEPS: usize = 25;
        const TOLERANCE: f64 = 0.01;
        let free = self.free(hypothesis);
        let mut here = self.at(hypothesis, start)?;
        let mut damping = 1e-3;
        for _ in 0..STEPS {
            let derivatives = self.derivatives(&here);
            let (information, slope) = (derivatives.information(), derivatives.slope());
            let before = here.cost;
            // At a corner of the shift the others go on alone.
            for holds_shift in [false, true] {
                for _ in 0..6 {
                    let mut damped = information.clone();
                    for i in 0..damped.nrows() {
                        damped[(i, i)] *= 1.0 + damping;
                    }
                    if holds_shift {
                        damped[(SHIFT, SHIFT)] *= 1e9;
                    }
                    let step = damped.cholesky().map(|factor| -factor.solve(&slope));
                    let next = step.and_then(|step| self.moved(&here, &free, &step));
                    if let Some(next) = next {
                        here = next;
                        damping = (0.1 * damping).max(1e-6);
                        break;
                    }
                    damping *= 10.0;
                }
                if before - here.cost > TOLERANCE {
                    break;
                }
                damping = 1e-3;
            }
            if before - here.cost < TOLERANCE {
                break;
            }
        }
        Some(here)
    }

    /// By how much a step of scoring from a fit lowers the cost, as far as its slope and information tell.
    pub fn next_gain(&self, here: &Fit) -> Option<f64> {
        let derivatives = self.derivatives(here);
        let (information, slope) = (derivatives.information(), derivatives.slope());
        Some(0.5 * slope.dot(&information.cholesky()?.solve(&slope)))
    }

    /// The fit a step further, where that is better. No scaled parameter moves far at once.
    fn moved(&self, here: &Fit, free: &[usize], step: &DVector<f64>) -> Option<Fit> {
        const LONGEST: f64 = 1.0;
        let longest = step.rows(0, free.len()).amax();
        let share = if longest > LONGEST {
            LONGEST / longest
        } else {
            1.0
        };
        let mut x = here.x.clone();
        free.iter()
            .zip(step.iter())
            .for_each(|(i, s)| x[*i] += share * s);
        self.at(here.hypothesis, &x)
            .filter(|fit| fit.cost < here.cost)
    }

    /// Fits a hypothesis from the solution of a simpler one.
    pub fn extended(&self, simpler: &Fit, hypothesis: Hypothesis) -> Option<Fit> {
        let mut x = self.start(hypothesis);
        let common = x.len().min(simpler.x.len());
        x.rows_mut(0, common).copy_from(&simpler.x.rows(0, common));
        if !hypothesis.waves || simpler.hypothesis.waves {
            return self.fit(hypothesis, &x);
        }
        let looks = [-0.7, 0.0, 0.7, 1.4, 2.1]
            .into_iter()
            .flat_map(|frequency| [-3.0, 0.0].map(|strength| [strength, frequency]));
        let best = looks
            .filter_map(|[strength, frequency]| {
                let mut x = x.clone();
                x[WAVE] = simpler.x[SEA] + strength;
                x[WAVE_FREQUENCY] = frequency;
                x[SEA] -= 1.0;
                self.at(hypothesis, &x)
            })
            .min_by(|a, b| a.cost.total_cmp(&b.cost))?;
        self.fit(hypothesis, &best.x)
    }
}

impl Problem<'_> {
    /// Where the search for a hull or a slow gear starts.
    fn hull_starts(&self, simpler: &Fit, hypothesis: Hypothesis) -> Vec<DVector<f64>> {
        // Coupling, log of the time constant of sway, and the share of what sway then takes of the damping in the long run that is given back to it.
        // Without a coupling the slope tells of one, whatever its sign.
        const SWAYS: [[f64; 3]; 7] = [
            [0.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [-0.35, 0.0, 0.0],
            [0.35, 0.0, 0.0],
            [0.35, 0.0, 0.5],
            [0.7, 0.7, 0.5],
            [0.7, 0.7, 1.0],
        ];
        const RATE_LIMITS: [f64; 4] = [-0.3, 0.4, 0.9, 1.4];
        let mut first = simpler.x.clone();
        if !simpler.hypothesis.growth {
            first[GROWTH] = Parameter::Quadratic.starts()[0];
        }
        let with_sway = |[coupling, time, share]: [f64; 3]| {
            let mut x = first.clone();
            (x[COUPLING], x[SWAY_TIME]) = (coupling, time);
            x[0] += share * coupling * libm::exp(time);
            x
        };
        let with_limit = |rate_limit| {
            let mut x = first.clone();
            x[RATE_LIMIT] = rate_limit;
            // A slow gear was taken for a late one.
            x[SHIFT] *= 0.3;
            x
        };
        match (hypothesis.sway, hypothesis.rate_limit) {
            (true, _) => SWAYS.map(with_sway).to_vec(),
            (false, true) => RATE_LIMITS.map(with_limit).to_vec(),
            (false, false) => vec![first],
        }
    }

    /// Fits a hull or a slow gear from the two starts from which a step of scoring promises most. `None` where no step promises that it is
    /// clearly likelier than a fit without.
    pub fn with_hull(&self, simpler: &Fit, hypothesis: Hypothesis) -> Option<Fit> {
        let starts = self.hull_starts(simpler, hypothesis);
        let mut looks: Vec<(f64, Fit)> = (starts.iter())
            .filter_map(|x| {
                let here = self.at(hypothesis, x)?;
                Some((here.cost - self.next_gain(&here)?, here))
            })
            .collect();
        looks.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (cost, _) = looks.first()?;
        if simpler.cost - cost <= LEAST_EVIDENCE {
            return None;
        }
        let fits = looks.iter().take(2);
        let fits = fits.filter_map(|(_, look)| self.fit(hypothesis, &look.x));
        fits.min_by(|a, b| a.cost.total_cmp(&b.cost))
    }
}

/// Mean and deviation of what is believed of a scaled parameter; `None` of the damping.
pub(super) fn belief(parameter: usize) -> Option<[f64; 2]> {
    match parameter {
        0 => None,
        SHIFT => Some([0.0, SHIFT_DEVIATION]),
        SPEED_LATE => Some([0.0, SPEED_LATE_DEVIATION]),
        SEA => Some([-1.0, 4.0]),
        SEA_TIME => Some([0.7, 1.0]),
        LAG => Some([0.0, LAG_DEVIATION]),
        GROWTH => Some([0.0, Parameter::Quadratic.prior_deviation()?]),
        COUPLING => Some([0.0, Parameter::Coupling.prior_deviation()?]),
        SWAY_TIME => Some([0.0, Parameter::SwayTime.prior_deviation()?]),
        RATE_LIMIT => Some([0.0, Parameter::RateLimit.prior_deviation()?]),
        WAVE_FREQUENCY => Some([0.5, 1.0]),
        WAVE_RATIO => Some([0.0, 0.7]),
        _ => Some([0.0, 4.0]),
    }
}
