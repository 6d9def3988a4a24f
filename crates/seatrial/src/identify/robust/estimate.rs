//! The robust estimate: which model, how sure, and why.

use seatrial_core::whitening::Covariance;

use super::average::Hypotheses;
use super::edges::of_edges;
use super::hypothesis::{CAUTIOUS, EXPECTED};
use super::misfit::of_the_hull;
use super::nearest::Nearest;
use super::play::likely_play_rad;
use super::record::{A22, B2, C0, DELAY, LAG2, PARAMETERS, Record, three};
use crate::likelihood::leg::fin_behind;
use crate::propagation::NORMAL_95;

/// Model error of a22 and of b2 as a share of them, in every interval: no vehicle is of first order to the last digit.
pub const MODEL_ERROR: [f64; 2] = [0.01, 0.007];

/// A disturbance of less than this share of the rudder's effect hides no hull that matters.
const SMALL_SHARE: f64 = 0.05;

/// From this share on the interval reaches the nearest simulation.
const LARGE_SHARE: f64 = 0.1;

/// From this share on a disturbance explains anything.
const LARGEST_SHARE: f64 = 0.5;

/// Chi-square of three parameters that chance exceeds once in a thousand, and, where much hangs on it, three times in a hundred.
const CHANCE: f64 = 16.3;
const CHANCE_AT_LARGE_SHARES: f64 = 9.0;

/// An interval wider than this share of a22 tells nothing against the nearest simulation.
const WIDEST: f64 = 0.5;

/// Probability of a rudder that acts at once under which a lag is part of the model.
const LEAST_PROMPT: f64 = 0.02;

/// Log of how much likelier a record must be with play than without: play is believed in one rudder of twenty.
pub const LEAST_EVIDENCE: f64 = 3.0;

/// As much where play is named, a thousand times likelier: in the rehearsals 301 to 340 of sound vehicles chance and what a first-order model
/// misses gave more than 6.5 in one run, play of 2 deg under a doublet of 15 deg more than 6.9 in 12 records of 21.
const NAMED_EVIDENCE: f64 = 6.9;

/// Where a model comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// Restricted likelihood, averaged over lag and disturbance.
    Averaged,
    /// The model whose simulation is nearest, where the rest is the hull's and not the sea's.
    Nearest,
}

/// A rudder that lags beyond doubt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lag {
    /// Lag and shift together: what the model behind it takes for its lag, s.
    pub delay_s: f64,
    /// 95 % interval, s.
    pub interval_s: [f64; 2],
    /// Twice the log of how much likelier the record is than without.
    pub likelihood_ratio: f64,
    /// The disturbance that the record would need without, over the rudder's effect.
    pub share_without: f64,
}

/// What a lag would change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LagSlope {
    /// Lag and shift together, s, and its standard deviation if the rudder lags.
    pub delay_s: [f64; 2],
    /// d[a22, b2] / d delay.
    pub slope: [f64; 2],
}

/// The robust estimate of a record.
#[derive(Clone, Debug, PartialEq)]
pub struct RobustEstimate {
    /// Which candidate.
    pub source: Source,
    /// a22, b2, C0.
    pub theta: [f64; 3],
    /// Covariance of theta, with what the candidates disagree about.
    pub covariance: [[f64; 3]; 3],
    /// Covariance of theta with lag and shift held at their estimates, which two records of one vehicle share.
    pub covariance_given_delay: [[f64; 3]; 3],
    /// 95 % intervals of theta.
    pub interval_95: [[f64; 2]; 3],
    /// The rudder's lag, where the record asks for one.
    pub lag: Option<Lag>,
    /// Play of the rudder from stop to stop, rad, where the record asks for it and it moves the model beyond its interval: that holds the
    /// model behind it.
    pub play_rad: Option<f64>,
    /// What a lag does to the model.
    pub lag_slope: LagSlope,
    /// Standard deviation of the heading noise of one sample, rad.
    pub heading_noise_rad: f64,
    /// Standard deviation of the yaw acceleration disturbance, rad/s^2.
    pub disturbance_rad_s2: f64,
    /// The disturbance over the rudder's effect.
    pub share: f64,
    /// Prediction errors of the likeliest model.
    pub innovations: Vec<f64>,
    /// Samples of each comparison.
    pub block: usize,
}

/// Play of the rudder from stop to stop, rad, and the log of how much likelier it makes the record.
#[derive(Clone, Copy)]
struct Play {
    play_rad: f64,
    log_odds: f64,
}

impl RobustEstimate {
    /// `None` where the record determines no vehicle.
    ///
    /// The averaged likelihood is handed over where the sea explains what the rudder does not. Where the hull does, or nothing can
    /// tell, it is the nearest simulation; under a large disturbance the interval reaches that one.
    pub fn of(record: &Record) -> Option<Self> {
        let hypotheses = Hypotheses::of(record)?;
        let found = Self::under(record, &hypotheses)?;
        let behind = match found.source {
            Source::Averaged => Self::behind_play(record, &hypotheses),
            Source::Nearest => None,
        };
        Some(match behind {
            Some((play, behind)) => found.reaching_behind(play, &behind),
            None => found,
        })
    }

    /// A play of the rudder under which the record is clearly likelier than without, and the estimate behind it.
    fn behind_play(record: &Record, hypotheses: &Hypotheses) -> Option<(Play, Self)> {
        let play_rad = likely_play_rad(record, hypotheses.block, &hypotheses.white)?;
        let fin = record.with_rudder(fin_behind(&record.rudder_rad, play_rad));
        let with_play = Hypotheses::of_comparisons(&fin, hypotheses.block)?;
        let log_odds = with_play.log_evidence(&EXPECTED) - hypotheses.log_evidence(&EXPECTED);
        let play = Play { play_rad, log_odds };
        (log_odds > LEAST_EVIDENCE).then_some((play, Self::under(&fin, &with_play)?))
    }

    /// With intervals and a covariance that hold the estimate behind play, too. Play that moves the model within its own interval is
    /// not named, nor is play that chance explains: a trial looks at ten records.
    fn reaching_behind(mut self, play: Play, other: &Self) -> Self {
        let is_outside = |i: usize| {
            let [low, high] = self.interval_95[i];
            !(low..=high).contains(&other.theta[i])
        };
        let is_named = play.log_odds > NAMED_EVIDENCE && [0, 1].into_iter().any(is_outside);
        self.play_rad = is_named.then_some(play.play_rad);
        let away: [f64; 3] = core::array::from_fn(|i| (other.theta[i] - self.theta[i]) / NORMAL_95);
        for i in 0..3 {
            let [low, high] = &mut self.interval_95[i];
            *low = low.min(other.interval_95[i][0]);
            *high = high.max(other.interval_95[i][1]);
            for j in 0..3 {
                self.covariance[i][j] += away[i] * away[j];
                self.covariance_given_delay[i][j] += away[i] * away[j];
            }
        }
        self
    }

    /// Under these hypotheses, of a rudder that goes where the record says.
    fn under(record: &Record, hypotheses: &Hypotheses) -> Option<Self> {
        let nearest = Nearest::of(record, hypotheses);
        let mean = hypotheses.mean(&EXPECTED);
        let all = hypotheses.covariance(&CAUTIOUS, &mean);
        let averaged = (theta_of(&mean), three(&all));
        let share = hypotheses.mean_of(&EXPECTED, |h| h.share);
        let likeliest = hypotheses.likeliest(&EXPECTED);
        let hull = || of_the_hull(record, hypotheses.block, likeliest).unwrap_or(0.0);
        let is_vague = averaged.1[0][0].sqrt() > WIDEST * averaged.0[0].abs();
        let is_hull = match share {
            0.0..SMALL_SHARE => false,
            SMALL_SHARE..LARGE_SHARE => hull() > CHANCE,
            _ => share > LARGEST_SHARE || is_vague || hull() > CHANCE_AT_LARGE_SHARES,
        };
        let (source, (theta, covariance)) = match is_hull {
            true => (Source::Nearest, (nearest.theta, nearest.covariance)),
            false if share > LARGE_SHARE => (Source::Averaged, reaching(averaged, &nearest.theta)),
            false => (Source::Averaged, averaged),
        };
        let of_edges = of_edges(record, likeliest, hypotheses.block);
        let covariance = with_model_error(&theta, &sum(&covariance, &of_edges));
        let interval_95 = match source {
            Source::Averaged if share <= LARGE_SHARE => mixed(hypotheses, &theta, &of_edges),
            _ => normal(&theta, &covariance),
        };
        Some(Self {
            source,
            theta,
            covariance_given_delay: match source {
                Source::Averaged => with_model_error(&theta, &sum(&given_delay(&all), &of_edges)),
                Source::Nearest => covariance,
            },
            covariance,
            interval_95,
            lag: lag(record, hypotheses, &mean, &all).filter(|_| !is_hull),
            play_rad: None,
            lag_slope: LagSlope {
                delay_s: [mean[DELAY], hypotheses.delay_deviation_s()],
                slope: hypotheses.lag_slope(),
            },
            heading_noise_rad: hypotheses.mean_of(&EXPECTED, |h| h.peak.noise_rad)
                * (hypotheses.block as f64).sqrt(),
            disturbance_rad_s2: hypotheses
                .mean_of(&EXPECTED, |h| h.peak.noise_rad * h.peak.noise.relative),
            share,
            innovations: likeliest.innovations(record, hypotheses.block),
            block: hypotheses.block,
        })
    }
}

fn theta_of(parameters: &[f64; PARAMETERS]) -> [f64; 3] {
    [A22, B2, C0].map(|i| parameters[i])
}

/// Covariance of a22, b2 and C0 at the mean delay.
fn given_delay(covariance: &[[f64; PARAMETERS]; PARAMETERS]) -> [[f64; 3]; 3] {
    const THETA: [usize; 3] = [A22, B2, C0];
    let mut given = Covariance(*covariance);
    given.measure(DELAY, f64::MIN_POSITIVE);
    THETA.map(|i| THETA.map(|j| given.0[i][j]))
}

/// An estimate with a 95 % interval that holds another one, too.
fn reaching(
    (theta, covariance): ([f64; 3], [[f64; 3]; 3]),
    other: &[f64; 3],
) -> ([f64; 3], [[f64; 3]; 3]) {
    let away: [f64; 3] = core::array::from_fn(|i| (other[i] - theta[i]) / NORMAL_95);
    let wide = |i: usize, j: usize| covariance[i][j] + away[i] * away[j];
    let wide = core::array::from_fn(|i| core::array::from_fn(|j| wide(i, j)));
    (theta, wide)
}

fn sum(a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    core::array::from_fn(|i| core::array::from_fn(|j| a[i][j] + b[i][j]))
}

fn with_model_error(theta: &[f64; 3], covariance: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let mut covariance = *covariance;
    for (i, share) in MODEL_ERROR.iter().enumerate() {
        covariance[i][i] += (share * theta[i]).powi(2);
    }
    covariance
}

/// Intervals of the hypotheses together, of which some have long tails; they hold the estimate.
fn mixed(hypotheses: &Hypotheses, theta: &[f64; 3], besides: &[[f64; 3]; 3]) -> [[f64; 2]; 3] {
    let model_error = [MODEL_ERROR[0] * theta[0], MODEL_ERROR[1] * theta[1], 0.0];
    core::array::from_fn(|i| {
        let more = model_error[i] * model_error[i] + besides[i][i];
        let [low, high] = hypotheses.interval_95(&CAUTIOUS, [A22, B2, C0][i], more);
        let least = NORMAL_95 * more.sqrt();
        [low.min(theta[i] - least), high.max(theta[i] + least)]
    })
}

fn normal(theta: &[f64; 3], covariance: &[[f64; 3]; 3]) -> [[f64; 2]; 3] {
    core::array::from_fn(|i| {
        let half_width = NORMAL_95 * covariance[i][i].sqrt();
        [theta[i] - half_width, theta[i] + half_width]
    })
}

/// The lag, where a rudder that acts at once is improbable and the delay is more than a record's timing may be.
fn lag(
    record: &Record,
    hypotheses: &Hypotheses,
    mean: &[f64; PARAMETERS],
    covariance: &[[f64; PARAMETERS]; PARAMETERS],
) -> Option<Lag> {
    let prompt = hypotheses.mean_of(&EXPECTED, |h| f64::from(u8::from(h.peak.prompt)));
    let timing_s = 0.5 * record.timing_s;
    let half_width_s = libm::hypot(NORMAL_95 * covariance[DELAY][DELAY].sqrt(), timing_s);
    let delay_s = mean[DELAY];
    let lag_s = mean[LAG2].max(0.0).sqrt();
    let interval_s = [(delay_s - half_width_s).min(lag_s), (delay_s + half_width_s).max(lag_s)];
    let without = hypotheses.likeliest_of(|h| h.peak.prompt);
    let with = hypotheses.likeliest_of(|h| !h.peak.prompt)?;
    (prompt < LEAST_PROMPT && interval_s[0] > 0.0).then(|| Lag {
        delay_s,
        interval_s,
        likelihood_ratio: without
            .map_or(f64::MAX, |without| 2.0 * (with.log_evidence - without.log_evidence)),
        share_without: without.map_or(0.0, |without| without.share),
    })
}
