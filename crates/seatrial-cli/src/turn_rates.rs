//! What `seatrial compare` prints of several logs.

use std::path::Path;

use seatrial::campaign::speeds::ValueInterval;
use seatrial::words::{bounds_text, three_figures};
use seatrial_app::compare_turn_rates::{LogModel, TurnRates};

use crate::screen::{labelled, width, wrapped};
use crate::table::Table;

/// The answer, the models and the fit.
pub fn page(document: &TurnRates) -> String {
    let width = width();
    let mut text = String::new();
    for line in document.text().lines() {
        text += &wrapped(line, width);
    }
    text += "\n";
    for (index, model) in document.models.iter().enumerate() {
        let path = Path::new(&document.sources[model.log].path);
        let file = path.file_name().unwrap_or(path.as_os_str());
        let line = format!("{}: {}", file.to_string_lossy(), model.outcome.name());
        text += &labelled(&format!("{:<4}", index + 1), &line, width);
    }
    let unit = document.models.first().map(|model| model.rudder_unit);
    let rudder = unit.map_or("", |unit| unit.for_people().1);
    let mut table = Table::under(&format!(
        " | speed [m/s] | turn [deg/s] | rudder [{rudder}] | T [s] | K [1/s] | a22, 95 % [1/s] | \
            b2, 95 % [1/s^2]"
    ));
    for (index, model) in document.models.iter().enumerate() {
        table.row(row(index, model));
    }
    text += &table.fitted(width, &["K", "T", "rudder"]);
    text += "\n";
    for speed in &document.speeds {
        if let Some(together) = &speed.over_amplitude {
            text += &labelled(
                "Together    ",
                &format!("{}: {}", speed.name, together.figures_text()),
                width,
            );
        }
    }
    text
}

fn row(index: usize, model: &LogModel) -> Vec<String> {
    let or_dash = |value: Option<f64>| value.map_or_else(|| "-".into(), three_figures);
    let bounds = |bounded: Option<ValueInterval>| {
        bounded.map_or_else(|| "-".into(), |bounded| bounds_text(bounded.interval_95))
    };
    let (scale, _) = model.rudder_unit.for_people();
    vec![
        (index + 1).to_string(),
        or_dash(model.surge_speed_m_s),
        or_dash(model.yaw_rate_amplitude_rad_s.map(f64::to_degrees)),
        or_dash(model.rudder_amplitude.map(|rudder| scale * rudder)),
        or_dash(model.nomoto.map(|nomoto| nomoto.t_s)),
        or_dash(model.nomoto.map(|nomoto| nomoto.k_per_s)),
        bounds(model.a22_per_s),
        bounds(model.b2_per_s2),
    ]
}
