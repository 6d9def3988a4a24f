//! How near the estimates of many trials come to the truth.

use seatrial::Campaign;
use seatrial_app::Error;
use seatrial_app::trials::estimator_study::Subject;
use seatrial_app::trials::order::rehearse;
use seatrial_cli::table::number;
use seatrial_core::Plan;
use seatrial_sim::SimulatedConfig;
use serde::Serialize;

/// The campaign of a trial of a vehicle that is made like this.
pub fn campaign(
    subject: &Subject,
    config: &SimulatedConfig,
    plan: Plan<f64>,
    seed: u64,
) -> Option<Campaign> {
    let mut vehicle = config.vehicle(seed).ok()?;
    let conducted = rehearse(&mut vehicle, &subject.vehicle, seed, plan);
    Some(conducted.ok()?.campaign)
}

/// An error where no trial gave what the study is of.
pub fn none(subject: &Subject, what: &str) -> Error {
    Error::Rejected(format!("{}: no trial gave a {what}", subject.vehicle))
}

/// How near estimates come to the truth, and how often their 95 % intervals hold it; `None` without any estimate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Coverage {
    /// Mean of the estimates less the truth.
    pub bias: Option<f64>,
    /// Root of their mean squared error.
    pub rms_error: Option<f64>,
    /// Share of them whose interval holds the truth.
    pub coverage: Option<f64>,
}

/// An estimate, its 95 % interval and the truth.
pub type Estimated = (f64, Option<[f64; 2]>, f64);

impl Coverage {
    /// Of these estimates; one without an interval does not hold the truth.
    pub fn of(estimates: &[Estimated]) -> Self {
        let count = estimates.len() as f64;
        let mean = |of: fn(&Estimated) -> f64| {
            (count > 0.0).then(|| estimates.iter().map(of).sum::<f64>() / count)
        };
        let error = |(value, _, truth): &Estimated| value - truth;
        Self {
            bias: mean(error),
            rms_error: mean(|(value, _, truth)| (value - truth) * (value - truth)).map(f64::sqrt),
            coverage: mean(|(_, interval, truth)| {
                let holds = interval.is_some_and(|[low, high]| low <= *truth && *truth <= high);
                f64::from(u8::from(holds))
            }),
        }
    }

    /// Bias and deviation for a table, with so many decimals, and the coverage.
    pub fn cells(&self, decimals: usize) -> [String; 3] {
        let signed = |bias: f64| format!("{bias:+.decimals$}");
        [
            self.bias.map_or("-".into(), signed),
            number(self.rms_error, decimals),
            number(self.coverage, 3),
        ]
    }
}
