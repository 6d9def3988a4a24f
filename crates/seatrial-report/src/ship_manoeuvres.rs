//! The form of the standard manoeuvres of a ship, to print.

use super::headline::{Headline, Tone};
use super::number::{MISSING, significant};
use super::tables::{Cell, Table, under};
use super::{Fact, Page};
use seatrial::sea_trials::ship_manoeuvres::ShipManoeuvres;
use seatrial::words::within;

/// The page of the manoeuvres of a ship.
pub fn render(manoeuvres: &ShipManoeuvres) -> String {
    let broken = manoeuvres.criteria.iter().filter(|c| !c.holds).count();
    let (tone, verdict) = match (manoeuvres.criteria.len(), broken) {
        (0, _) => (Tone::Good, "Manoeuvring figures".to_owned()),
        (all, 0) => (Tone::Good, format!("All {all} criteria of MSC.137(76) that are judged hold")),
        (all, broken) => {
            (Tone::Bad, format!("{broken} of {all} criteria of MSC.137(76) do not hold"))
        }
    };
    Page {
        title: format!("Manoeuvring form of {}", manoeuvres.vehicle),
        subtitle: match manoeuvres.is_predicted {
            true => "Predicted from the identified model",
            false => "Read from a record",
        }
        .to_owned(),
        about: facts(manoeuvres),
        headline: Headline {
            tone,
            verdict,
            findings: manoeuvres.notes.clone(),
            command: String::new(),
            next: Vec::new(),
        },
        summary: Some(indices(manoeuvres)),
        every_run: (!manoeuvres.criteria.is_empty()).then(|| criteria(manoeuvres)),
        ..Page::default()
    }
    .text()
}

fn facts(manoeuvres: &ShipManoeuvres) -> Vec<Fact> {
    let metres = |length_m: f64| format!("{} m", significant(length_m, 4));
    let known = [
        ("Vehicle", Some(manoeuvres.vehicle.clone())),
        ("Thrust", manoeuvres.thrust.map(|thrust| format!("{:.0} %", 100.0 * thrust))),
        ("Speed at the start", Some(format!("{} m/s", significant(manoeuvres.surge_speed_m_s, 3)))),
        ("Length", manoeuvres.length_m.map(metres)),
    ];
    let known = known.into_iter();
    known.filter_map(|(name, value)| Some((name, value?))).collect()
}

fn indices(manoeuvres: &ShipManoeuvres) -> Table {
    let rows = manoeuvres.indices.iter().map(|index| {
        let interval = index.interval_95.map_or(MISSING.to_owned(), |interval| {
            let shown = interval.map(|end| within(end, Some(interval)));
            format!("{} to {}", shown[0], shown[1])
        });
        vec![
            Cell::words(index.manoeuvre.clone()),
            Cell::words(index.name.to_owned()),
            within(index.value, index.interval_95).into(),
            interval.into(),
            Cell::words(index.unit.to_owned()),
        ]
    });
    Table {
        title: "Figures",
        note: "Names as in the ITTC procedure 7.5-04-02-01.".to_owned(),
        columns: under("Manoeuvre | Figure | Value | 95 % interval | Unit"),
        rows: rows.collect(),
    }
}

fn criteria(manoeuvres: &ShipManoeuvres) -> Table {
    let rows = manoeuvres.criteria.iter().map(|criterion| {
        vec![
            Cell::words(criterion.clause.to_owned()),
            Cell::words(criterion.name.to_owned()),
            significant(criterion.value, 3).into(),
            significant(criterion.limit, 3).into(),
            Cell::words(criterion.unit.to_owned()),
            Cell::words(if criterion.holds { "holds" } else { "does not hold" }.to_owned()),
        ]
    });
    Table {
        title: "Criteria of MSC.137(76)",
        note: "Made for ships of 100 m and more; stopping (5.3.4) is not judged.".to_owned(),
        columns: under("Paragraph | Figure | Value | At most | Unit | "),
        rows: rows.collect(),
    }
}
