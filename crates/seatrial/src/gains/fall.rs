//! A gain that falls far below those of the speeds beside it, and why.

use crate::figures::three_figures;
use crate::gain_allowance::GainAllowance;
use crate::identification::Identification;

/// A gain below this share of those beside it has fallen. In theory a22 grows with the speed and b2 with its square, so that gains of
/// one hull are equal; over the five speeds of the paper's plan they part by a quarter at most from one to the next.
const FALLEN: f64 = 0.5;

/// Of a fall, the share that the allowance for an uncertain damping explains where it is named.
const EXPLAINS: f64 = 0.7;

/// A speed with its gain.
#[derive(Clone, Copy, Debug)]
pub struct SpeedGain<'a> {
    /// `80 % thrust`, or `1.63 m/s`.
    pub name: &'a str,
    /// K_p.
    pub gain: f64,
    /// The model that it is made for.
    pub identification: &'a Identification,
}

/// One sentence for each gain that has fallen. `speeds` stand in the order of speed.
///
/// ```
/// use seatrial::Window;
/// use seatrial::gains::{DAMPING_RATIO, SpeedGain, falls};
/// use seatrial::identify::{IdentifySettings, identify};
///
/// # let vehicle = seatrial_core::YawModel::from_theta([-1.07, 1.08, 0.012]);
/// # let mut state = seatrial_core::model::YawState::<f64>::default();
/// # let sample = |k: u32| {
/// #     let rudder_rad = match k % 330 { 40..80 => 0.26, 80..120 => -0.26, _ => 0.0 };
/// #     let heading_rad = (1000.0 * state.heading_rad).round() / 1000.0;
/// #     state = vehicle.advance(state, rudder_rad, 0.05);
/// #     seatrial::Sample { time_s: 0.05 * f64::from(k), heading_rad, rudder_rad, ..Default::default() }
/// # };
/// # let record: seatrial::Record = (0..660).map(sample).collect();
/// // Two doublets of 0.26 rad on a vehicle with a22 = -1.07 1/s, b2 = 1.08 1/s^2.
/// let found = identify(&record, Window::ALL, None, &IdentifySettings::default())?;
/// let at = |name, gain| SpeedGain { name, gain, identification: &found };
/// // Gains of one hull are much alike; the one in the middle is less than half of its neighbours.
/// let speeds = [at("1.0 m/s", 0.5), at("1.5 m/s", 0.2), at("2.0 m/s", 0.6)];
/// assert_eq!(falls(&speeds, DAMPING_RATIO).len(), 1);
/// assert!(falls(&[at("1.0 m/s", 0.5), at("2.0 m/s", 0.4)], DAMPING_RATIO).is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn falls(speeds: &[SpeedGain], damping_ratio: f64) -> Vec<String> {
    let gains: Vec<f64> = speeds.iter().map(|speed| speed.gain.abs()).collect();
    (0..speeds.len())
        .filter_map(|at| Some(text(&speeds[at], beside(&gains, at)?, damping_ratio)))
        .collect()
}

/// The smaller gain beside this one, where this one has fallen below it.
fn beside(gains: &[f64], at: usize) -> Option<f64> {
    let before = at.checked_sub(1).and_then(|before| gains.get(before));
    let neighbours = [before, gains.get(at + 1)];
    let least = neighbours.into_iter().flatten().copied().reduce(f64::min)?;
    (gains[at] < FALLEN * least).then_some(least)
}

fn text(speed: &SpeedGain, beside: f64, damping_ratio: f64) -> String {
    let SpeedGain { name, gain, identification } = speed;
    let model = identification.model();
    let allowance = GainAllowance::of(identification);
    let certain = GainAllowance { damping_per_s: 0.0, ..allowance };
    let without = certain.design(&model, damping_ratio);
    let is_uncertain = without.is_ok_and(|without| {
        without.proportional_gain.abs() > gain.abs() / EXPLAINS && allowance.damping_per_s > 0.0
    });
    let why = match is_uncertain {
        true => format!(
            "there the boat may be damped by as little as {} 1/s, and the gain is made for that boat",
            three_figures((model.a22_per_s + allowance.damping_per_s).abs())
        ),
        false => format!(
            "the model of that speed, with a time constant of {} s, asks for it",
            three_figures(1.0 / model.a22_per_s.abs())
        ),
    };
    format!(
        "K_p falls to {} at {name}, beside {} at the next speed: {why}. Run that speed again, longer or with more rudder.",
        three_figures(*gain),
        three_figures(beside)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_only_a_gain_far_below_those_beside_it_has_fallen() {
        let of = |gains: &[f64]| -> Vec<usize> {
            (0..gains.len()).filter(|at| beside(gains, *at).is_some()).collect()
        };
        assert_eq!(of(&[0.595, 0.568, 0.433, 0.388, 0.337]), [0; 0]);
        assert_eq!(of(&[0.44, 0.11, 0.42]), [1]);
        assert_eq!(of(&[0.11, 0.44]), [0]);
        assert_eq!(of(&[0.44]), [0; 0]);
    }
}
