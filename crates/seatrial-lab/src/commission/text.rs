//! Commissions of many boats as text.

use seatrial_cli::table::{Table, number};

use super::boat::Method;
use super::{Class, Commissions};
use crate::runner::Found;

impl Found for Commissions {
    fn text(&self) -> String {
        let mut table = Table::under(
            "T [s] | gains | overshoot [median %] | [most %] | unsettled [boats] | settled after [median s] | \
                later than defaults [boats] | rudder [median %/s] | [most %/s]",
        );
        for class in &self.classes {
            for row in &class.methods {
                let name = match row.method {
                    Method::Defaults => "defaults",
                    Method::QuickTune => "QuickTune's rule",
                    Method::Proposed => "proposed",
                    Method::Commissioned => "commissioned",
                };
                let [low, high] = class.time_constant_s;
                table.row(vec![
                    format!("{low} to {high}"),
                    name.into(),
                    format!("{:.1}", 100.0 * row.overshoot_median),
                    format!("{:.1}", 100.0 * row.overshoot_most),
                    row.unsettled.to_string(),
                    number(row.settling_median_s, 1),
                    row.later_than_defaults.to_string(),
                    format!("{:.0}", 100.0 * row.activity_median_per_s),
                    format!("{:.0}", 100.0 * row.activity_most_per_s),
                ]);
            }
        }
        let count = |of: fn(&Class) -> u64| self.classes.iter().map(of).sum::<u64>();
        format!(
            "{} boats of each class, {} loops a second; kept {}, no gains proposed for {}; without sea and noise {} would be kept, of them {} were; measured as foreseen {}\n\n{table}",
            self.boats,
            self.loop_rate_hz,
            count(|class| class.kept as u64),
            count(|class| class.refused),
            count(|class| class.better as u64),
            count(|class| class.better_kept as u64),
            count(|class| class.as_foreseen as u64),
        )
    }
}
