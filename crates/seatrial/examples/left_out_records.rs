//! What a model of one log predicts of another: `cargo run -p seatrial --example left_out_records -- TRAIN VALIDATE [TRAIN VALIDATE ...]`.
//!
//! Of each pair the verdict, the model, and R^2 of heading and yaw rate on the second log with its own start and offset, of the model
//! that is handed over and of the hypothesis that explains the first log best.

use std::error::Error;
use std::path::Path;

use seatrial::identification::Validation;
use seatrial::identify::{IdentifySettings, ValidationData, identify};
use seatrial::{GainAllowance, Record, Window};

fn main() -> Result<(), Box<dyn Error>> {
    let logs: Vec<String> = std::env::args().skip(1).collect();
    for pair in logs.chunks_exact(2) {
        let [training, held_out] = [read(&pair[0])?, read(&pair[1])?];
        let data = ValidationData { record: &held_out, window: Window::ALL };
        let found = identify(&training, Window::ALL, Some(data), &IdentifySettings::default())?;
        let higher = found.higher_order.as_ref();
        let gain =
            GainAllowance::of(&found).design(&found.model(), core::f64::consts::FRAC_1_SQRT_2);
        println!(
            "{} -> {}: {} {:.4?}, gain {:.3?}; handed over {}, best hypothesis {} {}; {}",
            pair[0],
            pair[1],
            found.verdict.outcome().name(),
            found.model().theta(),
            gain.ok().map(|gain| gain.proportional_gain),
            scores(found.validation.as_ref()),
            scores(higher.and_then(|higher| higher.validation.as_ref())),
            higher.map_or_else(String::new, |higher| higher.structure.in_words().into()),
            found
                .verdict
                .reasons
                .iter()
                .map(|r| r.kind().to_string())
                .collect::<Vec<_>>()
                .join(" ")
        );
    }
    Ok(())
}

fn read(path: &str) -> Result<Record, Box<dyn Error>> {
    let log = seatrial_logs::open(Path::new(path), &Default::default())?;
    Ok(log.collect::<Result<_, _>>()?)
}

fn scores(validation: Option<&Validation>) -> String {
    let text = |r2: Option<f64>| r2.map_or("-".into(), |r2| format!("{r2:.3}"));
    let of = |read: fn(&Validation) -> Option<f64>| text(validation.and_then(read));
    format!("{} {}", of(|v| v.r2_heading_offset_refit), of(|v| v.r2_yaw_rate))
}
