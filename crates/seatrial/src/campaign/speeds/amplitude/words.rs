//! What several turn rates tell together, in sentences.

use super::{Finding, OverAmplitude, ValueInterval};
use crate::figures::{bounds_text, three_figures, within};

impl OverAmplitude {
    /// One or two sentences for people.
    pub fn text(&self) -> String {
        let what = match self.finding {
            Finding::Grows => format!("Damping grows with the turn rate: {}.", self.ends()),
            Finding::Falls => format!("Damping falls with the turn rate: {}.", self.ends()),
            Finding::Agree => match self.quadratic_per_rad {
                Some(_) => "The records agree: one model serves all amplitudes.".into(),
                None => "The records agree: one model serves all of them.".into(),
            },
            Finding::Differ => match self.quadratic_per_rad {
                Some(_) => "They differ by more than amplitude explains.".into(),
                None => "They differ by more than their intervals allow, at one turn rate.".into(),
            },
        };
        let use_of_it = match self.finding {
            Finding::Grows | Finding::Falls => {
                " Use the model of the turn rate that you steer with."
            }
            Finding::Agree => "",
            Finding::Differ => " Look for what else was different: load, trim, depth, wind.",
        };
        let more = match self.finding {
            Finding::Grows | Finding::Falls if !self.is_explained() => {
                " They differ by more than amplitude explains; the intervals are widened for it."
            }
            _ => "",
        };
        format!("{what}{use_of_it}{more}")
    }

    /// a_rr and chi^2 in a line.
    pub fn figures_text(&self) -> String {
        let quadratic = self
            .quadratic_per_rad
            .map_or_else(String::new, |a_rr| format!("a_rr {} 1/rad, ", with_bounds(&a_rr)));
        let [low, high] = self.chi_squared_95.map(three_figures);
        format!(
            "a22 at no turn rate {} 1/s, {quadratic}b2 {} 1/s^2; chi-square {}, degrees of freedom {}, 95 % are in {low} to {high}",
            with_bounds(&self.a22_at_rest_per_s),
            with_bounds(&self.b2_per_s2),
            three_figures(self.chi_squared),
            self.degrees_of_freedom,
        )
    }

    /// `a22 is -0.10 1/s at 0.2 deg/s and -0.16 1/s at 0.6 deg/s`
    fn ends(&self) -> String {
        let [slow, fast] = self.seen_rad_s.map(|rate| three_figures(rate.to_degrees()));
        let [weak, strong] =
            self.a22_at_seen_per_s.map(|a22| within(a22.value, Some(a22.interval_95)));
        format!("a22 is {weak} 1/s at {slow} deg/s and {strong} 1/s at {fast} deg/s")
    }
}

fn with_bounds(bounded: &ValueInterval) -> String {
    let interval = bounded.interval_95;
    let value = within(bounded.value, Some(interval));
    format!("{value} ({})", bounds_text(interval))
}
