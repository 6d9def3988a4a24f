//! The model that a record is held against, of several.

use seatrial_core::Sample;

use super::{ModelPoint, Models};
use crate::Error;

/// Speeds of a record that lie within this share of each other are one speed; a model of a speed that is farther from it is of another.
const ONE_SPEED: f64 = 0.15;

impl Models {
    /// The model whose speed is nearest to that of a record. Refused where the record has several speeds, or another one than the
    /// models.
    pub fn of_record(&self, samples: &[Sample<f64>]) -> Result<ModelPoint, Error> {
        if let [only] = self.points.as_slice() {
            return Ok(*only);
        }
        let mut speeds: Vec<f64> = samples
            .iter()
            .filter_map(|sample| sample.surge_speed_m_s)
            .filter(|speed| speed.is_finite())
            .collect();
        speeds.sort_by(f64::total_cmp);
        let at = |share: f64| speeds.get((share * speeds.len() as f64) as usize).copied();
        let refused = |why: String| {
            let known: Vec<String> = self.points.iter().map(ModelPoint::name).collect();
            Error::Setting(format!("{}: models of {}; {why}", self.origin, known.join(", ")))
        };
        // A few samples on the way from one speed to the next are none of it.
        let (Some(low), Some(middle), Some(high)) = (at(0.05), at(0.5), at(0.95)) else {
            return Err(refused(
                "the log has no speed that says which: name its column with --speed".into(),
            ));
        };
        if high - low > 2.0 * ONE_SPEED * middle {
            return Err(refused(format!(
                "the log goes at {low:.2} to {high:.2} m/s: say with --from and --to which part has one speed"
            )));
        }
        let distance = |point: &&ModelPoint| {
            let speed = point.point.surge_speed_m_s;
            speed.map_or(f64::INFINITY, |speed| (speed / middle - 1.0).abs())
        };
        let nearest = self.points.iter();
        let nearest = nearest.min_by(|a, b| distance(a).total_cmp(&distance(b)));
        nearest
            .filter(|point| distance(point) <= ONE_SPEED)
            .copied()
            .ok_or_else(|| refused(format!("the log goes at {middle:.2} m/s")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use seatrial_core::{SchedulePoint, YawModel};

    fn models() -> Models {
        let point = |speed: f64| {
            ModelPoint::exact(SchedulePoint {
                thrust: None,
                surge_speed_m_s: Some(speed),
                model: YawModel::from_theta([-speed, speed, 0.0]),
            })
        };
        Models { points: vec![point(1.0), point(2.0)], ..Models::given(YawModel::default(), None) }
    }

    fn going(speeds: &[f64]) -> Vec<Sample<f64>> {
        let sample = |speed: &f64| Sample { surge_speed_m_s: Some(*speed), ..Sample::default() };
        speeds.iter().map(sample).collect()
    }

    #[test]
    fn exact_a_record_is_held_against_the_model_of_its_speed() {
        let found = models().of_record(&going(&[1.9, 1.95, 2.0])).unwrap();
        assert_eq!(found.point.surge_speed_m_s, Some(2.0));
        for (speeds, said) in [
            (&[][..], "no speed"),
            (&[1.0, 1.0, 2.0, 2.0][..], "--from and --to"),
            (&[1.5, 1.5][..], "the log goes at 1.50 m/s"),
        ] {
            let refused = models().of_record(&going(speeds)).unwrap_err().to_string();
            assert!(refused.contains(said), "{refused}");
        }
    }
}
