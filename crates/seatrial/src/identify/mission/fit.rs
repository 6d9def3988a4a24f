//! The likeliest vehicle of an ordinary log under one hypothesis, with what is not known of it.

use nalgebra::{DMatrix, DVector, Vector4};

use super::columns::{COLUMNS, Point, SpeedLaw, Sums, each_innovation};
use super::record::Legs;
use crate::identify::robust::estimate::LEAST_EVIDENCE;
use crate::likelihood::fit::log_determinant;
use crate::likelihood::hypothesis::{Noise, Parameter, Scale};
use crate::likelihood::search::{Effort, Landscape, shortened};
use crate::likelihood::steering_model::log_steady_gain;
use crate::likelihood::{Structure, Vehicle};

/// What is supposed of vehicle and disturbance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hypothesis {
    /// How the speed matters.
    pub law: SpeedLaw,
    /// Hull and gear.
    pub structure: Structure,
    /// Are there waves of a narrow band?
    pub waves: bool,
}

impl Hypothesis {
    /// First order whose record of the rudder may be early or late, in a sea.
    const SIMPLE: Self =
        Self { law: SpeedLaw::Constant, structure: Structure::SHIFT, waves: false };

    /// Parameters of the vehicle that the innovations do not depend on linearly.
    fn of_vehicle(&self) -> Vec<Parameter> {
        let mut parameters = self.structure.parameters();
        parameters.retain(|p| *p != Parameter::Authority);
        parameters
    }
}

/// A hypothesis at its largest posterior.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The hypothesis.
    pub hypothesis: Hypothesis,
    /// Scaled parameters, each at its place in the table of parameters.
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
        let vehicle = &self.point.vehicle;
        Vector4::new(vehicle.damping_per_s, b, c, vehicle.shift_s + vehicle.lag_s)
    }

    /// Log of K, 1/s, of the steady turn at a rudder amplitude, rad.
    pub fn log_gain(&self, amplitude_rad: f64) -> f64 {
        log_steady_gain(&self.vehicle(), amplitude_rad)
    }

    /// The vehicle behind its delay.
    pub fn vehicle(&self) -> Vehicle {
        Vehicle { authority_per_s2: self.linear[0], shift_s: 0.0, lag_s: 0.0, ..self.point.vehicle }
    }
}

/// A problem: legs under a scale.
pub struct Problem<'a> {
    pub(super) legs: &'a Legs,
    /// The scale: the unit of a shift is the time constant of the first look.
    pub scale: Scale,
    pub(super) has_gyro: bool,
    turning_rad_s: f64,
}

impl<'a> Problem<'a> {
    /// Of legs under a scale.
    pub fn new(legs: &'a Legs, scale: Scale) -> Self {
        Self {
            legs,
            scale,
            has_gyro: legs.legs.iter().any(|leg| !leg.yaw_rate_rad_s.is_empty()),
            turning_rad_s: legs.mean_turning_rad_s(),
        }
    }

    /// A first look at the damping of these legs. `None` where no damping gives numbers.
    pub fn first_look(legs: &'a Legs) -> Option<(Self, Fit)> {
        const LOOKS: i32 = 14;
        let longest_s = legs.longest_s();
        let yaw_rate_rad_s = legs.yaw_rate_deviation_rad_s();
        let rudder_rad = legs.rudder_amplitude_rad();
        let slew_rad_s = legs.rudder_rate_rad_s() / 3.0;
        let (slowest, fastest) = (libm::log(10.0 / longest_s), libm::log(0.7 / legs.interval_s));
        let mut best: Option<(Self, Fit)> = None;
        for k in 0..LOOKS {
            let rate =
                libm::exp(slowest + (fastest - slowest) * f64::from(k) / f64::from(LOOKS - 1));
            let scale = Scale {
                rate_per_s: rate,
                authority_per_s2: 0.0,
                yaw_rate_rad_s,
                rudder_rad,
                slew_rad_s,
                interval_s: 1.0 / rate,
                heading_rad: 0.0,
            };
            let problem = Self::new(legs, scale);
            for strength in [-4.0, -1.0, 2.0] {
                let mut x = DVector::zeros(Parameter::COUNT);
                x[Parameter::Damping as usize] = 1.0;
                x[Parameter::Sea as usize] = strength;
                let Some(fit) = problem.at(Hypothesis::SIMPLE, &x) else {
                    continue;
                };
                if best.as_ref().is_none_or(|(_, b)| fit.cost < b.cost) {
                    best = Some((Self { ..problem }, fit));
                }
            }
        }
        best
    }

    /// Which parameters are free.
    pub(super) fn free(&self, hypothesis: Hypothesis) -> Vec<Parameter> {
        const OTHERS: [Parameter; 7] = [
            Parameter::GyroNoise,
            Parameter::Sea,
            Parameter::SeaTime,
            Parameter::SpeedLate,
            Parameter::Wave,
            Parameter::WaveFrequency,
            Parameter::WaveRatio,
        ];
        let is_free = |parameter: &Parameter| match parameter {
            Parameter::GyroNoise => self.has_gyro,
            Parameter::SpeedLate => hypothesis.law == SpeedLaw::Proportional,
            Parameter::Sea | Parameter::SeaTime => true,
            _ => hypothesis.waves,
        };
        let mut free = hypothesis.of_vehicle();
        free.extend(OTHERS.into_iter().filter(is_free));
        free
    }

    pub(super) fn point(&self, hypothesis: Hypothesis, x: &DVector<f64>) -> Point {
        let of = |parameter: Parameter| x[parameter as usize];
        let exp = |parameter: Parameter| libm::exp(of(parameter).clamp(-14.0, 14.0));
        let rate = self.scale.rate_per_s;
        let parameters = hypothesis.of_vehicle();
        let scaled: Vec<f64> = (parameters.iter())
            .map(|parameter| match parameter {
                Parameter::Shift => of(*parameter).clamp(-3.0, 3.0),
                _ => of(*parameter),
            })
            .collect();
        // Noise of the heading about a hundredth of what the vehicle turns in a time constant.
        let strength = 10.0 * rate * rate;
        let wave = [
            strength * exp(Parameter::Wave),
            rate * exp(Parameter::WaveFrequency),
            0.1 * exp(Parameter::WaveRatio).min(5.0),
        ];
        Point {
            vehicle: self.scale.vehicle(&parameters, &scaled),
            turning_rad_s: self.turning_rad_s,
            gyro_noise: exp(Parameter::GyroNoise),
            noise: Noise {
                sea: [strength * exp(Parameter::Sea), exp(Parameter::SeaTime) / rate],
                wave: match hypothesis.waves {
                    true => wave,
                    false => Noise::NONE.wave,
                },
                ..Noise::NONE
            },
            speed_late_s: of(Parameter::SpeedLate).clamp(-2.0, 2.0) / rate,
            law: hypothesis.law,
        }
    }

    fn prior(&self, hypothesis: Hypothesis, x: &DVector<f64>) -> f64 {
        let squares =
            self.free(hypothesis).into_iter().filter_map(|p| Some((x[p as usize], belief(p)?)));
        0.5 * squares.map(|(x, [mean, deviation])| ((x - mean) / deviation).powi(2)).sum::<f64>()
    }

    /// The linear parameters, noise and cost at a point. `None` where they are no numbers.
    pub fn at(&self, hypothesis: Hypothesis, x: &DVector<f64>) -> Option<Fit> {
        let point = self.point(hypothesis, x);
        // Gear and vehicle are told apart by which is slower.
        if point.vehicle.lag_s * point.vehicle.damping_per_s > 1.0 {
            return None;
        }
        let mut all = Sums::default();
        each_innovation(self.legs, &point, self.scale.yaw_rate_rad_s, |e, variance| {
            all.add(e, variance);
        });
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
        let columns = if self.has_gyro { COLUMNS } else { COLUMNS - 1 };
        let g = |a: usize, b: usize| all.products[a.min(b)][a.max(b)];
        let information = DMatrix::from_fn(columns - 1, columns - 1, |i, j| g(i + 1, j + 1));
        let right = DVector::from_fn(columns - 1, |i, _| g(0, i + 1));
        let factor = information.cholesky()?;
        // The innovation of what a column adds is minus that of the column.
        let solution = -factor.solve(&right);
        let left = g(0, 0) + right.dot(&solution);
        let mut linear = [0.0; 3];
        linear.iter_mut().zip(solution.iter()).for_each(|(l, s)| *l = *s);
        (left > 0.0).then_some((linear, left, log_determinant(&factor)))
    }

    /// The largest posterior from a start, by Fisher's scoring.
    pub fn fit(&self, hypothesis: Hypothesis, start: &DVector<f64>) -> Option<Fit> {
        Some(self.descend(self.at(hypothesis, start)?, EFFORT))
    }

    /// By how much a step of scoring from a fit lowers the cost, as far as its slope and information tell.
    pub fn next_gain(&self, here: &Fit) -> Option<f64> {
        let (information, slope) = self.linearised(here);
        Some(0.5 * slope.dot(&information.cholesky()?.solve(&slope)))
    }

    /// Fits a hypothesis from the solution of a simpler one.
    pub fn extended(&self, simpler: &Fit, hypothesis: Hypothesis) -> Option<Fit> {
        let x = &simpler.x;
        if !hypothesis.waves || simpler.hypothesis.waves {
            return self.fit(hypothesis, x);
        }
        let looks = [-0.7, 0.0, 0.7, 1.4, 2.1]
            .into_iter()
            .flat_map(|frequency| [-3.0, 0.0].map(|strength| [strength, frequency]));
        let best = looks
            .filter_map(|[strength, frequency]| {
                let mut x = x.clone();
                x[Parameter::Wave as usize] = x[Parameter::Sea as usize] + strength;
                x[Parameter::WaveFrequency as usize] = frequency;
                x[Parameter::Sea as usize] -= 1.0;
                self.at(hypothesis, &x)
            })
            .min_by(|a, b| a.cost.total_cmp(&b.cost))?;
        self.fit(hypothesis, &best.x)
    }
}

/// A log of an hour is fitted to a hundredth of a standard deviation.
const EFFORT: Effort = Effort { tolerance: 0.01, ..Effort::WHOLE };

impl Landscape for Problem<'_> {
    type Point = Fit;

    fn cost(&self, at: &Fit) -> f64 {
        at.cost
    }

    fn linearised(&self, at: &Fit) -> (DMatrix<f64>, DVector<f64>) {
        let derivatives = self.derivatives(at);
        (derivatives.information(), derivatives.slope())
    }

    /// No scaled parameter moves far at once.
    fn moved(&self, from: &Fit, step: DVector<f64>) -> Option<Fit> {
        const LONGEST: f64 = 1.0;
        let free = self.free(from.hypothesis);
        let mut x = from.x.clone();
        for (parameter, step) in free.iter().zip(&shortened(step, free.len(), LONGEST)) {
            x[*parameter as usize] += step;
        }
        self.at(from.hypothesis, &x)
    }

    fn corner(&self, at: &Fit) -> Option<usize> {
        let free = self.free(at.hypothesis);
        free.iter().position(|parameter| *parameter == Parameter::Shift)
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
        if !simpler.hypothesis.structure.has(Parameter::Quadratic) {
            first[Parameter::Quadratic as usize] = Parameter::Quadratic.row().starts[0];
        }
        let with_sway = |[coupling, time, share]: [f64; 3]| {
            let mut x = first.clone();
            (x[Parameter::Coupling as usize], x[Parameter::SwayTime as usize]) = (coupling, time);
            x[Parameter::Damping as usize] += share * coupling * libm::exp(time);
            x
        };
        let with_limit = |rate_limit| {
            let mut x = first.clone();
            x[Parameter::RateLimit as usize] = rate_limit;
            // A slow gear was taken for a late one.
            x[Parameter::Shift as usize] *= 0.3;
            x
        };
        match [Parameter::Coupling, Parameter::RateLimit].map(|p| hypothesis.structure.has(p)) {
            [true, _] => SWAYS.map(with_sway).to_vec(),
            [false, true] => RATE_LIMITS.map(with_limit).to_vec(),
            [false, false] => vec![first],
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
pub(super) fn belief(parameter: Parameter) -> Option<[f64; 2]> {
    /// Of a shift of the record, in time constants.
    const SHIFT_DEVIATION: f64 = 0.2;
    let mean = match parameter {
        Parameter::Shift => return Some([0.0, SHIFT_DEVIATION]),
        Parameter::Sea => -1.0,
        Parameter::SeaTime => 0.7,
        Parameter::WaveFrequency => 0.5,
        _ => 0.0,
    };
    Some([mean, parameter.row().prior_deviation?])
}
