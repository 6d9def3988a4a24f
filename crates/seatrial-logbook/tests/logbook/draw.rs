//! Steps and runs filled with arbitrary numbers.

use seatrial::campaign::{Run, Stage, StageSpan};
use seatrial::identification::{
    Convergence, EstimateMethod, Identification, Intervals, LeastSquares, Online, Reason,
    ReasonCode, Refined, RejectedSamples, Settings, TracePoint, ValidRange, Validation, Verdict,
};
use seatrial::log::LambdaReason;
use seatrial::{Step, Window};
use seatrial_core::heading_loop::LoopTiming;
use seatrial_core::state_variable_filter::Hold;
use seatrial_core::{AbortReason, Action, Outcome, Sample, Steering, YawModel};

/// Numbers drawn one after the other, to fill a structure with.
pub struct Draw(std::vec::IntoIter<f64>);

impl Draw {
    pub fn from(numbers: Vec<f64>) -> Self {
        Self(numbers.into_iter())
    }

    pub fn step(&mut self) -> Step {
        let angle = self.number();
        Step {
            sample: Sample {
                time_s: self.number(),
                heading_rad: self.number(),
                rudder_rad: self.number(),
                surge_speed_m_s: self.optional(),
                depth_m: self.optional(),
                altitude_m: self.optional(),
                roll_rad: self.optional(),
                pitch_rad: self.optional(),
                yaw_rate_rad_s: self.optional(),
                north_m: self.optional(),
                east_m: self.optional(),
                thrust: self.optional(),
            },
            stage: self.maybe(|draw| if draw.yes() { Stage::Train } else { Stage::Validate }),
            action: Action {
                steering: if self.yes() {
                    Steering::Rudder(angle)
                } else {
                    Steering::HoldHeading(angle)
                },
                thrust: self.optional(),
                outcome: self.maybe(|draw| {
                    if draw.yes() {
                        Outcome::Finished
                    } else {
                        Outcome::Aborted(AbortReason::StaleSamples)
                    }
                }),
            },
            estimate: self.maybe(Self::model),
        }
    }

    pub fn run(&mut self, number: u32, steps: &[Step]) -> Run {
        Run {
            number,
            thrust: self.number(),
            attempt: 1,
            surge_speed_m_s: self.optional(),
            stages: [Stage::Settle, Stage::Train]
                .map(|stage| StageSpan { stage, window: self.window() })
                .to_vec(),
            record: steps.iter().map(|step| step.sample).collect(),
            identification: self.maybe(Self::identification),
            verdict: self.verdict(),
        }
    }

    pub fn identification(&mut self) -> Identification {
        Identification {
            training: self.window(),
            samples_used: self.count() as usize,
            samples_rejected: RejectedSamples { spike: self.count(), ..Default::default() },
            settings: Settings {
                as_paper: self.yes(),
                lambda_rad_s: self.number(),
                lambda_because: LambdaReason::Given,
                heading_hold: Hold::FirstOrder,
                initial_covariance: self.number(),
                forgetting_factor: self.number(),
                servo: None,
            },
            online: Online {
                method: EstimateMethod::InstrumentalVariable,
                model: self.model(),
                delta0_rad: self.optional(),
                covariance: self.matrix(),
                least_squares: LeastSquares { model: self.model(), covariance: self.matrix() },
                batch: self.maybe(Self::model),
                theta_at: [("100".into(), self.numbers())].into(),
                convergence: Convergence {
                    detected_s: self.optional(),
                    threshold: self.number(),
                    consecutive: self.count(),
                },
                trace: (0..3)
                    .map(|_| TracePoint {
                        time_s: self.number(),
                        theta: self.numbers(),
                        step_norm: self.number(),
                    })
                    .collect(),
            },
            refined: self.maybe(|draw| Refined {
                method: EstimateMethod::Other("restricted_likelihood".into()),
                model: draw.model(),
                delta0_rad: draw.optional(),
                interval_95: Intervals {
                    a22_per_s: draw.numbers(),
                    b2_per_s2: draw.numbers(),
                    c0_rad_per_s2: draw.numbers(),
                    delta0_rad: draw.maybe(Self::numbers),
                },
                covariance: draw.matrix(),
                heading_noise_rad: draw.number(),
                disturbance_rad_s2: draw.number(),
            }),
            nomoto: None,
            restoring: None,
            validation: self.maybe(|draw| Validation {
                window: draw.window(),
                r2_heading: draw.optional(),
                r2_heading_offset_refit: draw.optional(),
                r2_yaw_rate: draw.optional(),
                samples: draw.count() as usize,
                horizon_s: draw.maybe(Self::number),
            }),
            higher_order: None,
            lag_effect: None,
            loop_timing: self.maybe(|draw| LoopTiming {
                delay_s: draw.number(),
                sample_interval_s: draw.maybe(Self::number),
            }),
            valid_range: self.maybe(|draw| ValidRange {
                rudder: [draw.number(), draw.number()],
                heading_amplitude_rad: draw.number(),
                surge_speed_m_s: draw.maybe(|draw| [draw.number(), draw.number()]),
                usual_surge_speed_m_s: draw.maybe(Self::number),
                band_rad_s: [draw.number(), draw.number()],
            }),
            verdict: self.verdict(),
        }
    }

    fn number(&mut self) -> f64 {
        self.0.next().expect("enough numbers were drawn")
    }

    fn yes(&mut self) -> bool {
        self.number().to_bits().count_ones().is_multiple_of(2)
    }

    fn maybe<T>(&mut self, value: impl FnOnce(&mut Self) -> T) -> Option<T> {
        self.yes().then(|| value(self))
    }

    fn optional(&mut self) -> Option<f64> {
        self.maybe(Self::number)
    }

    fn count(&mut self) -> u32 {
        self.number().to_bits() as u32
    }

    fn numbers<const N: usize>(&mut self) -> [f64; N] {
        std::array::from_fn(|_| self.number())
    }

    fn matrix(&mut self) -> [[f64; 3]; 3] {
        std::array::from_fn(|_| self.numbers())
    }

    fn model(&mut self) -> YawModel<f64> {
        YawModel::from_theta(self.numbers())
    }

    fn window(&mut self) -> Window {
        Window { from_s: self.number(), to_s: self.number() }
    }

    fn verdict(&mut self) -> Verdict {
        Verdict {
            accepted: self.yes(),
            reasons: vec![Reason::new(
                ReasonCode::Other("code".into()),
                format!("a 'quoted' \"text\", \u{394} {}", self.number()),
            )],
        }
    }
}
