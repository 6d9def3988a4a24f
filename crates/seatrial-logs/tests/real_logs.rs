//! Logs of real hulls and simulated vehicles open without an option, in the right units.

use std::path::PathBuf;

use seatrial_dev::data;
use seatrial_logs::{Channel, ChannelChoice, Quantity, Unit, UnitSource, open};

fn logs(folder: &str) -> Vec<PathBuf> {
    let Some(folder) = data(folder) else {
        return Vec::new();
    };
    std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|suffix| suffix == "csv"))
        .collect()
}

#[test]
fn io_recorded_and_simulated_logs_open_without_an_option() {
    for path in [logs("real"), logs("simulated")].concat() {
        let mut reader = open(&path, &ChannelChoice::default()).unwrap();
        let rows = reader.by_ref().map(Result::unwrap).count();
        let text = std::fs::read_to_string(&path).unwrap();
        // Some were recorded with times that repeat.
        let repeated = reader.counts().repeated_time as usize;
        let lines = text.lines().count() - 1;
        assert_eq!(rows + repeated, lines, "{}", path.display());
        let description = reader.description();
        // Of a speed without a unit it is said what it was taken for.
        let is_assumed = |channel: &Channel| {
            channel.quantity == Quantity::Speed && channel.unit_source == UnitSource::Assumed
        };
        let warnings = &description.warnings;
        let assumed = usize::from(description.channels.iter().any(is_assumed));
        let are_of_speed = warnings.iter().all(|w| w.starts_with("speed has no unit"));
        let is_all = warnings.len() == assumed && are_of_speed;
        assert!(is_all, "{}: {warnings:?}", path.display());
        let said = reader.warnings().len();
        assert_eq!(said, usize::from(repeated > 0), "{}", path.display());
        for channel in &description.channels {
            let expected = match channel.quantity {
                Quantity::Time => Unit::Second,
                Quantity::Heading | Quantity::Rudder | Quantity::Roll | Quantity::Pitch => {
                    match channel.column.ends_with("_deg") {
                        true => Unit::Degree,
                        false => Unit::Radian,
                    }
                }
                Quantity::YawRate => Unit::RadianPerSecond,
                Quantity::Speed => Unit::MetrePerSecond,
                _ => Unit::Metre,
            };
            assert_eq!(channel.unit, expected, "{}: {}", path.display(), channel.column);
        }
    }
}
