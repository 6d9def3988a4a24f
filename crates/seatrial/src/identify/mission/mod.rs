//! A model from an ordinary log: whatever moved the rudder, an autopilot or a helmsman, while the vehicle made way.
//!
//! The likelihood of `filter` compares heading and gyro with a first-order vehicle under the recorded rudder and a disturbance. It needs no
//! manoeuvre and no rest, and a rudder that answers the heading does not bias it: what is predicted is the next sample.
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | d, b, c | damping -a22, rudder effect b2, offset C0 | 1/s, 1/s^2, rad/s^2 |
//! | u | speed over the median speed of the log; d goes with u and b with u^2 where the log asks for it | |
//! | shift, lag | time by which the record of the rudder is early, lag of the gear | s |
//! | sea, waves | Gauss-Markov and narrow-band yaw acceleration | rad/s^2 |
//!
//! Source: prediction error method of Ljung, System Identification (1999), chapters 7 and 13; intervals by Fisher's information, or by the
//! scatter of twelve blocks where that is wider (White 1982).

mod columns;
mod fit;
mod held_out;
mod information;
mod long_turn;
mod play;
mod prediction;
mod record;

use nalgebra::{Matrix4, Vector4};
use seatrial_core::{Sample, YawModel};

use super::intervals::normal_intervals;
use super::log_statistics::LogStatistics;
use super::online::Pass;
use super::robust::estimate::{LEAST_EVIDENCE, MODEL_ERROR};
use super::training::manoeuvre_to_learn_from;
use super::validation::ValidationData;
use super::{IdentifyError, RecordSurvey, valid_range};
use crate::gain_allowance::sampled;
use crate::identification::{
    EstimateMethod, HigherOrder, Identification, LEAST_R2, Refined, Settings, ValidRange,
    Validation, Verdict,
};
use crate::likelihood::evidence::shares;
use crate::likelihood::hypothesis::{Noise, Scale};
use crate::likelihood::posterior::Moments;
use crate::likelihood::{SteeringModel, Structure, Vehicle};
use crate::manoeuvre::Manoeuvre;
use crate::propagation::NORMAL_95;
use crate::record::{Window, logged_s};
use crate::segmentation::{self, Kind};
use columns::SpeedLaw;
use fit::{Fit, Hypothesis, Problem};
pub(super) use held_out::HeldOut;
use information::Uncertainty;
use long_turn::{Beyond, LongTurn, SURE_HULL, hulls};
pub(super) use prediction::LEAST_HORIZON_S;
use record::Legs;

/// Manoeuvres that hold less than this share of the rudder's work are not what the log is.
const MANOEUVRES: f64 = 0.5;

/// A rudder within this share of its usual deflection is held there.
const HELD: f64 = 0.2;

/// Strokes that nobody makes in one manoeuvre, and the share of the time that the rudder is then deflected: trials rest between manoeuvres. Autopilots
/// of course-unstable boats go from stop to stop like this.
const MOST_STROKES: usize = 24;
const RESTLESS: f64 = 0.3;

/// Changes of the rudder a stroke under which somebody gives orders.
const ORDERS: usize = 4;

/// Strokes of the rudder from which a record is more than a manoeuvre.
pub(super) const LEAST_STROKES: usize = 3;

/// Speeds that differ less tell nothing of the damping and the rudder effect over them.
const LEAST_SPEED_CHANGE: f64 = 0.03;

/// Log of how much likelier each comparison must be with play: seas of eight waves, which no hypothesis has, made it likelier by up to half of that in 20
/// missions of 6,000 comparisons, and play of 1 to 3 deg by 1.6 times that at least.
const EVIDENCE_OF_A_SEA: f64 = 0.008;

/// A hypothesis of less weight is passed over.
const NEGLIGIBLE: f64 = 0.01;

/// Is this ordinary steering, not a manoeuvre or several with rest between them?
///
/// Who makes a manoeuvre deflects the rudder most of the time, to the same angle; who steers moves it all the time. A step to one side may be a
/// course change.
pub fn is_ordinary_steering(samples: &[Sample<f64>]) -> bool {
    let Some(whole) = Manoeuvre::find(samples).filter(|m| m.strokes.len() >= LEAST_STROKES) else {
        return false;
    };
    let changes =
        samples.windows(2).filter(|pair| pair[0].rudder_rad != pair[1].rudder_rad).count();
    if changes < ORDERS * whole.strokes.len() {
        return false;
    }
    let away = |s: &Sample<f64>| (s.rudder_rad - whole.middle_rad).abs() / whole.amplitude_rad;
    let work = |part: &[Sample<f64>], counts: &dyn Fn(f64) -> bool| -> f64 {
        let squares = part.iter().map(away).filter(|x| counts(*x)).map(|x| x * x);
        squares.filter(|square| square.is_finite()).sum()
    };
    let all = work(samples, &|_| true);
    let held = work(samples, &|x| (x - 1.0).abs() < HELD);
    let deflected = samples.iter().filter(|s| away(s) > 0.5).count();
    if whole.strokes.len() > MOST_STROKES && deflected as f64 > RESTLESS * samples.len() as f64 {
        return true;
    }
    if held > MANOEUVRES * all && 2 * deflected > samples.len() {
        return false;
    }
    let manoeuvres = segmentation::find(samples);
    let of_manoeuvres: f64 = manoeuvres
        .iter()
        .filter(|m| m.kind.uses_both_sides() || m.kind == Kind::TurningCircle)
        .map(|m| work(m.window.of(samples), &|_| true))
        .sum();
    of_manoeuvres < MANOEUVRES * all
}

/// Every hypothesis fitted to legs, each from a simpler one, and the scale of their parameters. `None` where they determine nothing.
fn fits(legs: &Legs) -> Option<(Vec<(Fit, Uncertainty)>, Scale)> {
    let (problem, look) = Problem::first_look(legs)?;
    let simple = look.hypothesis;
    let mut fits = vec![problem.fit(simple, &look.x)?];
    if legs.speed_change() > LEAST_SPEED_CHANGE {
        let law = SpeedLaw::Proportional;
        fits.extend(problem.fit(Hypothesis { law, ..simple }, &fits[0].x));
    }
    for (structure, waves) in
        [(Structure::LAG, false), (Structure::SHIFT, true), (Structure::LAG, true)]
    {
        let simpler = fits
            .iter()
            .filter(|fit| waves || fit.hypothesis.structure == Structure::SHIFT)
            .min_by(|a, b| a.cost.total_cmp(&b.cost))?;
        let law = simpler.hypothesis.law;
        fits.extend(problem.extended(simpler, Hypothesis { law, structure, waves }));
    }
    Some((uncertain(&problem, fits), problem.scale))
}

fn uncertain(problem: &Problem, fits: Vec<Fit>) -> Vec<(Fit, Uncertainty)> {
    let of = |fit: Fit| problem.uncertainty(&fit).map(|u| (fit, u));
    fits.into_iter().filter_map(of).collect()
}

/// Shares of the weight by log evidence, without those that are negligible beside the likeliest.
fn weights(evidence: impl Iterator<Item = f64> + Clone) -> Vec<f64> {
    let most = evidence.clone().fold(f64::NEG_INFINITY, f64::max);
    let is_in = move |log: f64| libm::exp(log - most) > NEGLIGIBLE;
    shares(evidence.map(move |log| if is_in(log) { log } else { f64::NEG_INFINITY }))
}

/// What all hypotheses say of a log.
struct Estimate {
    /// Mean of d, b, c and the delay.
    pub mean: Vector4<f64>,
    /// Their covariance.
    pub covariance: Matrix4<f64>,
    /// The heaviest hypothesis.
    pub heaviest: Fit,
    /// Log evidence of the likeliest hypothesis.
    pub log_evidence: f64,
    /// Play of the rudder from stop to stop, rad, where the log asks for it: the covariance holds the model behind it.
    pub play_rad: Option<f64>,
    /// How a long turn ends, where that is not K of the mean.
    pub long_turn: Option<LongTurn>,
}

impl Estimate {
    /// Of legs. `None` where they determine nothing.
    fn of(legs: &Legs) -> Option<Self> {
        let (found, scale) = fits(legs)?;
        let estimate = Self::of_fits(&found)?;
        let behind = play::likely_play_rad(legs, scale, &estimate.heaviest)
            .and_then(|play_rad| Some((play_rad, fits(&legs.behind_play(play_rad))?.0)));
        let of_a_sea = LEAST_EVIDENCE.max(EVIDENCE_OF_A_SEA * legs.len() as f64);
        let amplitude_rad = scale.rudder_rad;
        let mut beyond: Vec<Beyond> = hulls(legs, scale, &estimate.heaviest)
            .iter()
            .map(|hull| Beyond::of(hull, 0.0, amplitude_rad, SURE_HULL))
            .collect();
        if let Some((play_rad, fits)) = &behind {
            let of = |fit| Beyond::of(fit, *play_rad, amplitude_rad, of_a_sea);
            beyond.extend(fits.iter().map(of));
        }
        let first_order = (estimate.log_evidence, estimate.heaviest.log_gain(amplitude_rad));
        let estimate =
            Self { long_turn: LongTurn::of(&beyond, first_order, amplitude_rad), ..estimate };
        let behind = behind.and_then(|(play_rad, fits)| Some((play_rad, Self::of_fits(&fits)?)));
        Some(match behind {
            Some((play_rad, behind)) if behind.log_evidence - estimate.log_evidence > of_a_sea => {
                estimate.reaching_behind(play_rad, &behind)
            }
            _ => estimate,
        })
    }

    /// With a covariance that holds the estimate behind play, too. Play that moves the model within its own interval is not named: a sea that no
    /// hypothesis has looks like it.
    fn reaching_behind(mut self, play_rad: f64, other: &Self) -> Self {
        let away = (other.mean - self.mean) / NORMAL_95;
        let is_outside = |i: usize| away[i].powi(2) > self.covariance[(i, i)];
        self.play_rad = [0, 1].into_iter().any(is_outside).then_some(play_rad);
        self.covariance += away * away.transpose();
        self
    }

    /// Of all hypotheses, weighed by their evidence.
    fn of_fits(found: &[(Fit, Uncertainty)]) -> Option<Self> {
        let evidence = found.iter().map(|(_, u)| u.log_evidence);
        let most = evidence.clone().fold(f64::NEG_INFINITY, f64::max);
        let weights = weights(evidence);
        let of = |((fit, u), weight): (&(Fit, Uncertainty), &f64)| {
            let (mean, covariance) = (fit.values(), u.covariance);
            (*weight, Moments { mean, covariance })
        };
        let moments = Moments::of(&found.iter().zip(&weights).map(of).collect::<Vec<_>>())?;
        let ((heaviest, _), _) = (found.iter().zip(&weights)).max_by(|a, b| a.1.total_cmp(b.1))?;
        Some(Self {
            mean: moments.mean,
            covariance: moments.covariance,
            heaviest: heaviest.clone(),
            log_evidence: most,
            play_rad: None,
            long_turn: None,
        })
    }

    /// With a covariance that explains how far a part of the log lies from the rest (Birge 1932), where chance does not.
    fn widened(mut self, apart: Option<f64>) -> Self {
        const CHANCE: f64 = 5.99;
        if let Some(apart) = apart.filter(|apart| *apart > CHANCE) {
            self.covariance *= 0.5 * apart;
        }
        self
    }

    /// The model with its intervals.
    fn refined(&self) -> Refined {
        let model = YawModel::from_theta([-self.mean[0], self.mean[1], self.mean[2]]);
        let sign = |i: usize| if i == 0 { -1.0 } else { 1.0 };
        let mut covariance =
            nalgebra::Matrix3::from_fn(|i, j| sign(i) * sign(j) * self.covariance[(i, j)]);
        for (i, share) in MODEL_ERROR.iter().enumerate() {
            covariance[(i, i)] += (share * model.theta()[i]).powi(2);
        }
        let noise_rad = self.heaviest.variance_rad2.sqrt();
        let Noise { sea, wave, .. } = self.heaviest.point.noise;
        Refined {
            method: match self.steering_model().is_some() {
                true => EstimateMethod::RudderLag,
                false => EstimateMethod::PredictionError,
            },
            model,
            delta0_rad: model.delta0_rad(),
            interval_95: normal_intervals(&model, &covariance),
            covariance: covariance.into(),
            heading_noise_rad: noise_rad,
            disturbance_rad_s2: noise_rad * libm::hypot(sea[0], wave[0]),
        }
    }

    /// The model behind the delay of its rudder, where that is proven.
    fn steering_model(&self) -> Option<SteeringModel> {
        let delay_s = self.mean[3];
        (delay_s > NORMAL_95 * self.covariance[(3, 3)].sqrt()).then(|| {
            let model = YawModel::from_theta([-self.mean[0], self.mean[1], self.mean[2]]);
            SteeringModel::first_order(&model, delay_s)
        })
    }

    /// The gear's lag with its interval and the hull, as documents have them.
    fn beyond_first_order(&self, refined: &Refined, interval_s: f64) -> Option<HigherOrder> {
        let lagging = self.steering_model();
        let half_s = NORMAL_95 * self.covariance[(3, 3)].sqrt();
        let lag_s = lagging.map(|model| model.rudder_lag_s);
        let hull = self.long_turn.as_ref().map(|turn| {
            let vehicle = Vehicle { lag_s: lag_s.unwrap_or(0.0), ..turn.vehicle };
            SteeringModel::new(&vehicle, turn.offset_rad_s2)
        });
        let model = hull.or(lagging)?;
        let parts = [
            lag_s.map(|_| Structure::LAG),
            model.rate_limit_rad_s.map(|_| Structure::RATE_LIMIT),
            model.play_rad.map(|_| Structure::PLAY),
            (model.quadratic_per_rad > 0.0).then_some(Structure::QUADRATIC),
            (model.a21_per_s2 != 0.0).then_some(Structure::SWAY),
        ];
        Some(HigherOrder {
            structure: parts.into_iter().flatten().fold(Structure::SHIFT, Structure::union),
            lag_interval_s: lag_s.map(|lag_s| [lag_s - half_s, lag_s + half_s]),
            model,
            steady_log_gain: self.long_turn.as_ref().map(|turn| turn.log_gain),
            steady_rudder_rad: self.long_turn.as_ref().map(|turn| turn.rudder_rad),
            least_r2_left_out: None,
            hypotheses: Vec::new(),
            gain_vehicle: (self.long_turn.as_ref())
                .and_then(|turn| turn.gain_vehicle(refined, lag_s.unwrap_or(0.0), interval_s)),
            validation: None,
        })
    }
}

/// Ordinary steering and the model of it.
pub(super) struct Steering {
    /// The usable samples of the window.
    pub samples: Vec<Sample<f64>>,
    /// How good the log is.
    pub log: LogStatistics,
    /// Minutes of it that were fitted, and their share of the window.
    pub minutes: f64,
    pub share: f64,
    /// The median speed of the log, m/s.
    pub usual_speed_m_s: Option<f64>,
    /// The speed at which a22 and b2 hold, m/s, where the speed of the log changes.
    pub speed_m_s: Option<f64>,
    /// The model.
    pub refined: Refined,
    /// The model behind the delay of its rudder, or of another hull, where there is one.
    pub beyond_first_order: Option<HigherOrder>,
    /// Is the vehicle surely not of first order?
    pub is_surely_beyond: bool,
    /// Play of the rudder from stop to stop, rad, where the log asks for it.
    pub play_rad: Option<f64>,
    /// What it was validated on.
    pub held_out: HeldOut,
}

impl Steering {
    /// The steering in a window, and its model: validated on the last part of the window or on other data.
    ///
    /// It is cut where the log has gaps and where the vehicle stops or goes astern. `None` where that leaves nothing to fit.
    pub fn of(
        record: &RecordSurvey,
        training: Window,
        data: Option<ValidationData>,
        pass: &Pass,
    ) -> Result<Option<Self>, IdentifyError> {
        let manoeuvre = manoeuvre_to_learn_from(record.record(), record.record().window(training))?;
        let samples = record.record().usable(training);
        let other =
            data.and_then(|data| Some((Legs::of(&data.record.usable(data.window))?, data.window)));
        let found = Legs::of(&without_derived_rate(record, &samples)).and_then(|legs| {
            let estimate = Estimate::of(&legs)?;
            let held_out = HeldOut::of(&legs, &estimate, other)?;
            Some((legs, estimate.widened(held_out.apart), held_out))
        });
        Ok(found.map(|(legs, estimate, held_out)| {
            let refined = estimate.refined();
            let interval_s = interval_s(&samples);
            let beyond_first_order = estimate.beyond_first_order(&refined, interval_s);
            Self {
                log: LogStatistics::of(record, training, &manoeuvre, pass, 0),
                minutes: legs.legs.iter().map(|leg| leg.duration_s()).sum::<f64>() / 60.0,
                share: legs.share,
                usual_speed_m_s: legs.speed_m_s,
                speed_m_s: (legs.speed_m_s).filter(|_| legs.speed_change() > LEAST_SPEED_CHANGE),
                refined,
                beyond_first_order,
                is_surely_beyond: (estimate.long_turn.as_ref()).is_some_and(|turn| turn.is_sure),
                play_rad: estimate.play_rad,
                samples,
                held_out,
            }
        }))
    }

    /// Does no heading gain hold on the vehicles that may have made the log?
    pub fn has_no_gain(&self) -> bool {
        let beyond = self.beyond_first_order.as_ref();
        beyond.is_some_and(|found| found.steady_log_gain.is_some() && found.gain_vehicle.is_none())
    }

    /// Does the model predict what was held out better than a vehicle that keeps turning as it does?
    pub fn predicts(&self) -> bool {
        let prediction = &self.held_out.prediction;
        prediction.r2_heading().is_some_and(|r2| r2 >= LEAST_R2)
            && prediction.share_of_persistence() < 1.0
    }

    /// The model, behind the delay of its rudder where there is one.
    pub fn steering_model(&self) -> SteeringModel {
        let beyond = self.beyond_first_order.as_ref().map(|found| found.model);
        beyond.unwrap_or_else(|| SteeringModel::first_order(&self.refined.model, 0.0))
    }

    /// The identification with its verdict.
    pub fn identification(
        self,
        training: Window,
        pass: Pass,
        settings: Settings,
        validated: &[Sample<f64>],
        verdict: Verdict,
    ) -> Identification {
        let (refined, prediction) = (self.refined, &self.held_out.prediction);
        let interval_s = interval_s(&self.samples);
        let lag_s =
            (self.beyond_first_order.as_ref()).map_or(0.0, |found| found.model.rudder_lag_s);
        let noise_rad = refined.heading_noise_rad;
        Identification {
            training: training.known_part(&self.samples),
            samples_used: self.samples.len(),
            samples_rejected: pass.rejected,
            nomoto: refined.model.nomoto(),
            restoring: None,
            online: pass.online,
            validation: Some(Validation {
                window: self.held_out.window,
                r2_heading: prediction.r2_heading(),
                r2_heading_offset_refit: prediction.r2_heading(),
                r2_yaw_rate: prediction.r2_yaw_rate(),
                samples: prediction.samples,
                horizon_s: Some(prediction.horizon_s),
            }),
            higher_order: self.beyond_first_order,
            lag_effect: None,
            loop_timing: Some(sampled(interval_s, lag_s)),
            valid_range: valid_range(&[&self.samples, validated], &refined.model, noise_rad)
                .map(|range| ValidRange { usual_surge_speed_m_s: self.usual_speed_m_s, ..range }),
            refined: Some(refined),
            verdict,
            settings,
        }
    }
}

/// Mean interval between samples, s.
fn interval_s(samples: &[Sample<f64>]) -> f64 {
    logged_s(samples) / samples.len().max(1) as f64
}

/// A yaw rate that is computed from the heading brings its noise twice.
fn without_derived_rate(record: &RecordSurvey, samples: &[Sample<f64>]) -> Vec<Sample<f64>> {
    let is_derived = record.record().units.yaw_rate_is_derived;
    let rate = |s: &Sample<f64>| s.yaw_rate_rad_s.filter(|_| !is_derived);
    samples.iter().map(|s| Sample { yaw_rate_rad_s: rate(s), ..*s }).collect()
}
