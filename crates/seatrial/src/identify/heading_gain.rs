//! The heading gain that holds on every vehicle that explains a record alike.

use crate::course_change::COURSE_CHANGE_RAD;
use crate::gain_allowance::{DAMPING_RATIO, GainAllowance, sampled};
use crate::identification::{GainVehicle, Refined};
use crate::likelihood::Contest;
use crate::likelihood::free_run::heading_step;
use crate::likelihood::hypothesis::Vehicle;

/// Overshoot, and error and swing that stay, of a course change that no vehicle may exceed, shares of the course change.
const MOST_OVERSHOOT: f64 = 0.2;
const MOST_LEFT: f64 = 0.1;

/// Swing that no vehicle at all may keep, a share of the course change: it is not stable. Of the 275 vehicles of the example `hulls`, seed
/// 4711, none loses a gain by it.
const UNSTABLE: f64 = 0.2;

/// Gains that are tried: from the one for the model down, each this share of the one before.
const NEXT_GAIN: f64 = 0.85;
const GAINS: usize = 20;

/// Share of the vehicles on which the gain must hold. With 0.95, of the 567 accepted boats of the example `hulls` (seeds 20777 and 31337) as many
/// gains overshoot (4), and 8 more boats have none.
const LEAST_HOLDING: f64 = 0.8;

/// By how much less may hold under the gain that is taken than under the one under which most do.
const NEARLY: f64 = 0.05;

/// Of a number, to single precision.
const HALVINGS: u32 = 24;

/// Vehicles that explain a record alike, with the share of the weight of each, and the loop that steers them.
#[derive(Clone, Debug)]
pub struct Vehicles {
    vehicles: Vec<(f64, Vehicle)>,
    interval_s: f64,
    amplitude_rad: f64,
}

impl Vehicles {
    /// Of every hypothesis that weighs, under a loop as fast as the samples with the rudder of the record.
    pub fn of(contest: &Contest, interval_s: f64, amplitude_rad: f64) -> Self {
        const LEAST_WEIGHT: f64 = 0.1;
        let vehicles = (contest.candidates.iter())
            .filter(|candidate| candidate.weight >= LEAST_WEIGHT)
            .flat_map(|candidate| {
                let vehicles = candidate.vehicles();
                let share = candidate.weight / vehicles.len() as f64;
                vehicles.into_iter().map(move |vehicle| (share, vehicle))
            })
            .collect();
        Self::new(vehicles, interval_s, amplitude_rad)
    }

    /// These, with the weight of each.
    pub fn new(mut vehicles: Vec<(f64, Vehicle)>, interval_s: f64, amplitude_rad: f64) -> Self {
        let total: f64 = vehicles.iter().map(|(share, _)| share).sum();
        for (share, _) in &mut vehicles {
            *share /= total;
        }
        Self { vehicles, interval_s, amplitude_rad }
    }

    /// The first-order vehicle whose gain is handed out with an estimate: the gain for the less damped end of its interval, or another one that
    /// holds on clearly more of the vehicles. `None` where none holds on [enough](LEAST_HOLDING) of them and is stable on all.
    ///
    /// A smaller gain is not always the safer one: behind play, and where sway drives the turn, it overshoots by more.
    pub fn gain_vehicle(&self, refined: &Refined) -> Option<GainVehicle> {
        let [_, least_damped_per_s] = refined.interval_95.a22_per_s;
        let a22_per_s = refined.model.a22_per_s;
        let largest = self.designed(refined, a22_per_s)?;
        let mut tried = Vec::new();
        // Nothing holds on more than all.
        while tried.len() < GAINS && tried.last().is_none_or(|t: &GainTrial| t.holding < 1.0) {
            tried.push(self.try_gain(largest * NEXT_GAIN.powi(tried.len() as i32)));
        }
        let most = tried.iter().map(|t| t.holding).fold(0.0, f64::max);
        let least = LEAST_HOLDING.max(most - NEARLY);
        let holds = |t: &&GainTrial| t.holding >= least && t.is_stable;
        let asked = self.designed(refined, least_damped_per_s);
        let asked = asked.map(|gain| self.try_gain(gain));
        let largest = tried.iter().find(holds)?;
        let taken = match asked.as_ref().filter(holds) {
            Some(asked) if asked.gain.abs() <= largest.gain.abs() => asked,
            _ => largest,
        };
        Some(GainVehicle {
            a22_per_s: self.vehicle_of(refined, taken.gain),
            overshoot_rad: taken.overshoot.map(|share| share * COURSE_CHANGE_RAD),
        })
    }

    fn try_gain(&self, gain: f64) -> GainTrial {
        let mut tried =
            GainTrial { gain, holding: 0.0, is_stable: true, overshoot: [f64::INFINITY, 0.0] };
        for (share, vehicle) in &self.vehicles {
            let [over, left, swing] =
                heading_step(vehicle, gain, COURSE_CHANGE_RAD, self.amplitude_rad, self.interval_s);
            // In its play the rudder does not act.
            let of_play = 0.5 * vehicle.play_rad / (gain * COURSE_CHANGE_RAD).abs();
            if over < MOST_OVERSHOOT
                && swing < MOST_LEFT
                && left < MOST_LEFT.max(1.5 * of_play).min(0.5)
            {
                tried.holding += share;
            }
            tried.is_stable &= swing < UNSTABLE;
            let [least, most] = &mut tried.overshoot;
            (*least, *most) = (least.min(over), most.max(over));
        }
        tried
    }

    /// a22 of the first-order vehicle for which an estimate is given this gain, 1/s.
    fn vehicle_of(&self, refined: &Refined, gain: f64) -> f64 {
        let [mut more_damped, mut less_damped] = [refined.model.a22_per_s, 0.0];
        for _ in 0..HALVINGS {
            let middle = 0.5 * (more_damped + less_damped);
            match self.designed(refined, middle).is_some_and(|designed| designed.abs() > gain.abs())
            {
                true => more_damped = middle,
                false => less_damped = middle,
            }
        }
        less_damped
    }

    /// The gain for an estimate with another a22, 1/s. `None` where there is none.
    fn designed(&self, refined: &Refined, a22_per_s: f64) -> Option<f64> {
        let allowance = GainAllowance {
            damping_per_s: a22_per_s - refined.model.a22_per_s,
            timing: sampled(self.interval_s, 0.0),
        };
        let gain = allowance.design(&refined.model, DAMPING_RATIO);
        Some(gain.ok()?.proportional_gain)
    }
}

/// A gain, the share of the vehicles on which it holds, whether it is stable on all, and the least and most overshoot on them, shares of
/// the course change.
struct GainTrial {
    gain: f64,
    holding: f64,
    is_stable: bool,
    overshoot: [f64; 2],
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identification::{EstimateMethod, Intervals};
    use crate::likelihood::SteeringModel;
    use seatrial_core::YawModel;

    fn estimate(model: YawModel<f64>, least_damped_per_s: f64) -> Refined {
        Refined {
            method: EstimateMethod::WeighedHypotheses,
            model,
            delta0_rad: None,
            interval_95: Intervals {
                a22_per_s: [2.0 * model.a22_per_s - least_damped_per_s, least_damped_per_s],
                b2_per_s2: [model.b2_per_s2; 2],
                c0_rad_per_s2: [0.0; 2],
                delta0_rad: None,
            },
            covariance: [[0.0; 3]; 3],
            heading_noise_rad: 0.003,
            disturbance_rad_s2: 0.0,
        }
    }

    /// Vehicles behind these plays, rad.
    fn vehicles(model: &YawModel<f64>, plays: &[f64]) -> Vehicles {
        let behind = |play_rad: &f64| {
            let model = SteeringModel {
                play_rad: Some(*play_rad),
                ..SteeringModel::first_order(model, 0.0)
            };
            (1.0, model.vehicle())
        };
        Vehicles::new(plays.iter().map(behind).collect(), 0.05, 0.26)
    }

    /// Behind play a boat overshoots by more the smaller the gain is: a wide interval alone must not make the gain small.
    #[test]
    fn exact_a_smaller_gain_is_not_taken_where_it_overshoots_by_more() {
        let model = YawModel::from_theta([-1.5, 2.0, 0.0]);
        let vehicles = vehicles(&model, &[0.06, 0.065, 0.07]);
        let wide = estimate(model, -0.7);
        let asked = vehicles.designed(&wide, -0.7).unwrap();
        assert!(vehicles.try_gain(asked).holding < 0.1);
        let found = vehicles.gain_vehicle(&wide).unwrap();
        assert!(found.a22_per_s < -1.0, "{found:?}");
        let [least, most] = found.overshoot_rad;
        assert!(0.0 <= least && least <= most && most < MOST_OVERSHOOT * COURSE_CHANGE_RAD);
    }

    #[test]
    fn exact_the_end_of_the_interval_counts_where_its_gain_holds() {
        let model = YawModel::from_theta([-1.5, 2.0, 0.0]);
        let found = vehicles(&model, &[0.0]).gain_vehicle(&estimate(model, -1.2));
        let away = found.unwrap().a22_per_s + 1.2;
        // Bisected to single precision.
        assert!(away.abs() < 1e-6, "{away}");
    }

    #[test]
    fn exact_no_gain_is_given_where_none_holds() {
        let model = YawModel::from_theta([-0.5, 0.6, 0.0]);
        let found = vehicles(&model, &[0.2]).gain_vehicle(&estimate(model, -0.4));
        assert_eq!(found, None);
    }
}
