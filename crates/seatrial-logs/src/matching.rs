//! Which column feeds which quantity.

use std::collections::BTreeMap;

use crate::choice::{ChannelChoice, mirrored};
use crate::error::Fault;
use crate::languages::names as names_of;
use crate::name::{ColumnName, StatedUnit};
use crate::no_log::{LOG_INSTEAD, table_of_else};
use crate::table::{Known, KnownChannel};
use crate::words::words;
use crate::{Quantity, Unit, UnitSource};

/// A column that feeds a quantity.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Match {
    pub quantity: Quantity,
    pub column: usize,
    /// By option or by the column's name.
    pub unit: Option<(Unit, crate::UnitSource)>,
    /// Why the format takes this column.
    pub because: Option<String>,
    /// The unit that the name of the column says, where one of another kind was chosen.
    pub against: Option<Unit>,
}

/// The matches, and what people should know about them.
#[derive(Debug, Default)]
pub(crate) struct Matches {
    pub matches: Vec<Match>,
    pub warnings: Vec<String>,
}

impl Matches {
    /// Indices of the matched columns.
    pub fn columns(&self) -> Vec<(Quantity, usize)> {
        self.matches.iter().map(|m| (m.quantity, m.column)).collect()
    }

    /// Takes the integral of a yaw rate of a known unit for the heading that is not there; such a rate is no witness of the heading.
    fn integrates_the_yaw_rate(&mut self) -> bool {
        let of_rate = |m: &&mut Match| m.quantity == Quantity::YawRate && m.unit.is_some();
        let Some(rate) = self.matches.iter_mut().find(of_rate) else {
            return false;
        };
        rate.quantity = Quantity::Heading;
        rate.because = Some("no heading is logged: it is the integral of the yaw rate".into());
        self.warnings.push(
            "no column is named for heading: the integral of the yaw rate is taken for it; say another with --heading NAME".into(),
        );
        true
    }

    /// Units by option or name.
    pub fn stated_units(&self) -> BTreeMap<Quantity, Unit> {
        self.matches.iter().filter_map(|m| Some((m.quantity, m.unit?.0))).collect()
    }
}

/// The word that leaves an optional quantity out.
const NO_COLUMN: &str = "none";

/// Finds a column for every quantity: the one chosen, else the one that the format knows, else, where it
/// knows none, the one whose name fits best.
pub(crate) fn match_columns(
    columns: &[String],
    known: &Known,
    choice: &ChannelChoice,
) -> Result<Matches, Fault> {
    let mut found = Matches::default();
    let own_names = columns.iter().filter(|_| known.is_empty());
    let names: Vec<ColumnName> = own_names.map(|name| ColumnName::new(name)).collect();
    if columns.len() < 2 && known.is_empty() {
        return Err(Fault::NoLog { what: "text without columns", instead: LOG_INSTEAD });
    }
    // What is wrong with one column hides nothing that is wrong with another.
    let mut faults = Vec::new();
    let mut no_heading = None;
    for quantity in Quantity::ALL {
        let of_names = Named { columns, names: &names, known };
        let column = match of_names.column(quantity, choice, &mut found.warnings) {
            Ok(column) => column,
            Err(fault @ (Fault::MissingColumn { .. } | Fault::NotLogged { .. }))
                if quantity == Quantity::Heading =>
            {
                no_heading = Some((faults.len(), fault));
                continue;
            }
            Err(fault) => {
                faults.push(fault);
                continue;
            }
        };
        let Some(column) = column else { continue };
        let channel = known.of(quantity, &columns[column]);
        let said = (choice.units.get(&quantity), channel);
        let name = choice.names_unit(quantity).unwrap_or(&columns[column]);
        let stated = match said_unit(name, quantity, said, &mut found.warnings) {
            Ok(stated) => stated,
            Err(fault) => {
                faults.extend(fault);
                continue;
            }
        };
        let named = match ColumnName::new(&columns[column]).unit(quantity) {
            StatedUnit::Known(unit) => Some(unit),
            StatedUnit::None | StatedUnit::Unknown(_) => channel.and_then(|channel| channel.unit),
        };
        let chosen = choice.units.get(&quantity);
        let against =
            named.filter(|named| chosen.is_some_and(|unit| unit.dimension() != named.dimension()));
        if let (Some(named), Some(unit)) = (against, chosen) {
            found.warnings.push(format!(
                "column `{}` is in {named} by its name, and {unit} was chosen",
                columns[column]
            ));
        }
        found.matches.push(Match {
            quantity,
            column,
            against,
            unit: stated,
            because: match choice.corrections.get(&quantity) {
                Some(correction) => Some(correction.to_string()),
                None => channel.and_then(|channel| channel.because.clone()),
            },
        });
        found.warnings.extend(channel.and_then(|channel| channel.doubt.clone()));
    }
    // A heading that is the integral of a yaw rate has no witness in it.
    let heading = found.matches.iter().find(|m| m.quantity == Quantity::Heading);
    if let Some(of_heading) = heading.map(|m| m.column) {
        let is_twice = |m: &Match| m.quantity == Quantity::YawRate && m.column == of_heading;
        found.matches.retain(|m| !is_twice(m));
    }
    if let Some((place, fault)) = no_heading
        && !found.integrates_the_yaw_rate()
    {
        faults.insert(place, fault);
    }
    let lacks = |needed: Quantity| {
        let is_of = |fault: &Fault| matches!(fault, Fault::MissingColumn { quantity, .. } if *quantity == needed);
        faults.iter().any(is_of)
    };
    if lacks(Quantity::Rudder) {
        let has_nothing = found.matches.iter().all(|m| m.quantity == Quantity::Time);
        let else_of = table_of_else(columns, has_nothing && lacks(Quantity::Heading));
        else_of.map_or(Ok(()), Err)?;
    }
    Fault::all(faults).map_or(Ok(found), Err)
}

/// The unit of a column and who says it: the choice, the format, the name. An error is the fault of a column that cannot be read, or none where it is left
/// out with a warning.
fn said_unit(
    column: &str,
    quantity: Quantity,
    (chosen, channel): (Option<&Unit>, Option<&KnownChannel>),
    warnings: &mut Vec<String>,
) -> Result<Option<(Unit, UnitSource)>, Option<Fault>> {
    let stated = |unit| (unit, UnitSource::Stated);
    match (chosen, channel) {
        (Some(unit), _) if unit.fits(quantity.dimension()) => Ok(Some((*unit, UnitSource::Chosen))),
        (Some(unit), _) => Err(Some(unknown_unit(column, unit.symbol(), quantity))),
        _ if quantity == Quantity::Heading
            && let Some(rate) = unit_of_a_rate(column) =>
        {
            warnings.push(format!(
                "column `{column}` is a yaw rate by its name: its integral is taken for the heading"
            ));
            Ok(Some(stated(rate)))
        }
        (None, Some(channel)) => Ok(channel.unit.map(stated)),
        (None, None) => match ColumnName::new(column).unit(quantity) {
            StatedUnit::Known(unit) => Ok(Some(stated(unit))),
            StatedUnit::None => Ok(None),
            StatedUnit::Unknown(text) if quantity.is_required() => {
                Err(Some(unknown_unit(column, &text, quantity)))
            }
            StatedUnit::Unknown(text) => {
                warnings.push(format!(
                    "column `{column}` is left out: `{text}` is no unit of {quantity}; expected one of {}",
                    Unit::that_fit(quantity.dimension())
                ));
                Err(None)
            }
        },
    }
}

/// The unit of a column that is a yaw rate by its name, and no heading.
fn unit_of_a_rate(column: &str) -> Option<Unit> {
    let name = ColumnName::new(column);
    match (name.unit(Quantity::Heading), name.unit(Quantity::YawRate)) {
        (StatedUnit::Known(_), _) => None,
        (_, StatedUnit::Known(unit)) => Some(unit),
        _ => None,
    }
}

/// The columns of a log with what is known of them.
struct Named<'a> {
    columns: &'a [String],
    names: &'a [ColumnName],
    known: &'a Known,
}

impl Named<'_> {
    /// The column of a quantity: the one chosen, else the one that the format knows, else the one whose name fits best.
    fn column(
        &self,
        quantity: Quantity,
        choice: &ChannelChoice,
        warnings: &mut Vec<String>,
    ) -> Result<Option<usize>, Fault> {
        let columns = self.columns;
        match choice.columns.get(&quantity) {
            Some(name) => match meant(name, columns, quantity) {
                Some(column) => {
                    warnings.push(format!(
                        "{} {name}: there is no such column; `{}` is taken",
                        quantity.option(),
                        columns[column]
                    ));
                    Ok(Some(column))
                }
                None => chosen(name, columns, quantity),
            },
            None if !self.known.is_empty() => preferred(self.known, columns, quantity),
            None => best(self.names, columns, quantity, choice, warnings),
        }
    }
}

fn unknown_unit(column: &str, found: &str, quantity: Quantity) -> Fault {
    Fault::UnknownUnit {
        column: column.to_string(),
        found: found.to_string(),
        quantity,
        expected: Unit::that_fit(quantity.dimension()),
    }
}

/// The column of this name, of whatever quantity.
pub(crate) fn column_named(name: &str, columns: &[String]) -> Result<usize, Fault> {
    let exact = columns.iter().position(|column| column == name);
    let found = exact.or_else(|| only(columns, |column| column.eq_ignore_ascii_case(name)));
    found.ok_or_else(|| Fault::NoRunColumn { name: name.into(), columns: columns.to_vec() })
}

/// The two columns whose half difference is a quantity; the second may be named with a minus.
pub(crate) fn pair_of_columns(
    pair: &[String; 2],
    columns: &[String],
    quantity: Quantity,
) -> Result<[usize; 2], Fault> {
    let position = |name: &String| {
        chosen(name, columns, quantity)?.ok_or_else(|| Fault::NoSuchColumn {
            quantity,
            name: name.clone(),
            columns: columns.to_vec(),
            nearest: nearest(columns, &[name]),
        })
    };
    let second = mirrored(&pair[1]).map_or_else(|| pair[1].clone(), str::to_owned);
    Ok([position(&pair[0])?, position(&second)?])
}

/// The column of this name: exactly, else whatever the case.
fn chosen(name: &str, columns: &[String], quantity: Quantity) -> Result<Option<usize>, Fault> {
    let exact = positions(columns, |column| column == name);
    let found = if exact.is_empty() {
        positions(columns, |column| column.eq_ignore_ascii_case(name))
    } else {
        exact
    };
    match found[..] {
        [column] => Ok(Some(column)),
        [] if name == NO_COLUMN && !quantity.is_required() => Ok(None),
        [] => Err(Fault::NoSuchColumn {
            quantity,
            name: name.to_string(),
            columns: columns.to_vec(),
            nearest: nearest(columns, &[name]),
        }),
        _ => Err(Fault::AmbiguousColumn {
            quantity,
            candidates: found.iter().map(|&i| columns[i].clone()).collect(),
        }),
    }
}

/// The only column that a name can mean which is not there: without the unit that the column states, or misspelt.
fn meant(name: &str, columns: &[String], quantity: Quantity) -> Option<usize> {
    if columns.iter().any(|column| column.eq_ignore_ascii_case(name)) {
        return None;
    }
    let without_unit = |name: &String| ColumnName::new(name).without_unit(quantity);
    let wanted = without_unit(&name.to_string());
    let plain: Vec<Vec<String>> = columns.iter().map(without_unit).collect();
    let of_the_unit_only = only(&plain, |column| *column == wanted);
    of_the_unit_only.or_else(|| only(&plain, |column| is_misspelt(&wanted, column)))
}

/// The only place at which something holds.
fn only<T>(of: &[T], holds: impl Fn(&T) -> bool) -> Option<usize> {
    let mut places = (0..of.len()).filter(|i| holds(&of[*i]));
    places.next().filter(|_| places.next().is_none())
}

/// Is each word the other's, or a long one with a letter behind the first wrong, missing, too many or two exchanged? Digits tell apart.
fn is_misspelt(wanted: &[String], column: &[String]) -> bool {
    const SHORTEST: usize = 5;
    let digits = |word: &str| -> String { word.chars().filter(char::is_ascii_digit).collect() };
    wanted.len() == column.len()
        && wanted.iter().zip(column).all(|(wanted, word)| {
            wanted == word
                || (word.chars().count() >= SHORTEST
                    && wanted.chars().next() == word.chars().next()
                    && digits(wanted) == digits(word)
                    && strsim::osa_distance(wanted, word) <= 1)
        })
}

/// The column that the format prefers.
fn preferred(
    known: &Known,
    columns: &[String],
    quantity: Quantity,
) -> Result<Option<usize>, Fault> {
    if let Some(channel) = known.best(quantity) {
        return Ok(positions(columns, |column| column == channel.column).first().copied());
    }
    if !quantity.is_required() {
        return Ok(None);
    }
    let found = known.lacking.iter().find(|(of, _)| *of == quantity);
    Err(Fault::NotLogged {
        quantity,
        found: found.map_or("nothing of the kind", |(_, found)| found).to_string(),
    })
}

fn positions(columns: &[String], is_it: impl Fn(&str) -> bool) -> Vec<usize> {
    (0..columns.len()).filter(|&i| is_it(&columns[i])).collect()
}

fn best(
    names: &[ColumnName],
    columns: &[String],
    quantity: Quantity,
    choice: &ChannelChoice,
    warnings: &mut Vec<String>,
) -> Result<Option<usize>, Fault> {
    let fits: Vec<(usize, usize)> = (0..names.len())
        .filter(|&i| !choice.columns.values().any(|chosen| *chosen == columns[i]))
        .filter_map(|i| Some((names[i].fit(quantity)?.rank, i)))
        .collect();
    let Some(best) = fits.iter().map(|(rank, _)| *rank).min() else {
        if !quantity.is_required() {
            return Ok(None);
        }
        if let Some(column) = misspelt(columns, quantity) {
            warnings.push(format!(
                "no column is named for {quantity}; `{}` is taken: say another with {} NAME",
                columns[column],
                quantity.option()
            ));
            return Ok(Some(column));
        }
        return Err(missing(names, columns, quantity));
    };
    let candidates: Vec<usize> =
        fits.iter().filter(|(rank, _)| *rank == best).map(|(_, column)| *column).collect();
    let candidate_names = || candidates.iter().map(|&i| columns[i].clone()).collect();
    match candidates[..] {
        [column] => Ok(Some(column)),
        _ if quantity.is_required() => {
            Err(Fault::AmbiguousColumn { quantity, candidates: candidate_names() })
        }
        _ => {
            let list: Vec<String> = candidate_names();
            warnings.push(format!(
                "no {quantity} is read: the columns {} fit equally well; say which with {} NAME",
                list.join(", "),
                quantity.option()
            ));
            Ok(None)
        }
    }
}

/// The fault of a quantity that no name fits, with the nearest of those that are no other quantity.
fn missing(names: &[ColumnName], columns: &[String], quantity: Quantity) -> Fault {
    let known = names_of(quantity).in_english();
    // A column of another quantity would be a bad guess.
    let is_others = |name: &ColumnName| {
        let others = Quantity::ALL.into_iter().filter(|other| *other != quantity);
        others.into_iter().any(|other| name.fit(other).is_some())
    };
    let free: Vec<String> = columns
        .iter()
        .zip(names)
        .filter(|(_, name)| !is_others(name) && !name.is_of_another_kind())
        .map(|(column, _)| column.clone())
        .collect();
    Fault::MissingColumn { quantity, columns: columns.to_vec(), nearest: nearest(&free, &known) }
}

/// The only column whose name is one of the quantity's misspelt.
fn misspelt(columns: &[String], quantity: Quantity) -> Option<usize> {
    let known = names_of(quantity).in_english();
    let plain: Vec<String> = columns
        .iter()
        .map(|column| ColumnName::new(column).without_unit(quantity).concat())
        .collect();
    only(&plain, |column| {
        known.iter().any(|name| is_misspelt(&[(*name).to_string()], std::slice::from_ref(column)))
    })
}

/// The column whose name is most like one of these.
fn nearest(columns: &[String], wanted: &[&str]) -> Option<String> {
    // Under this similarity a hint would rather mislead.
    const ALIKE: f64 = 0.75;
    columns
        .iter()
        .map(|column| (words(column).concat(), column))
        .filter(|(plain, _)| plain.len() > 2)
        .map(|(plain, column)| {
            let alike = wanted
                .iter()
                .filter(|name| name.len() > 2)
                .map(|name| strsim::jaro_winkler(&plain, name))
                .fold(0.0, f64::max);
            (alike, column)
        })
        .filter(|(alike, _)| *alike >= ALIKE)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, column)| column.clone())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The column of the heading and what was said of it.
    fn heading(columns: &[&str], name: Option<&str>) -> Result<(String, String), Fault> {
        let columns: Vec<String> = columns.iter().map(|name| (*name).into()).collect();
        let mut choice = ChannelChoice::default();
        if let Some(name) = name {
            choice.columns.insert(Quantity::Heading, name.into());
        }
        let found = match_columns(&columns, &Known::default(), &choice)?;
        let heading = found.matches.iter().find(|m| m.quantity == Quantity::Heading);
        Ok((columns[heading.unwrap().column].clone(), found.warnings.join("\n")))
    }

    #[test]
    fn io_a_name_without_its_unit_or_misspelt_is_taken_and_said() {
        for (column, name) in [
            ("Course steered [deg]", "Course steered"),
            ("yaw (rad)", "YAW"),
            ("ship_head_deg", "ship_head"),
            ("compass_reading", "compas_reading"),
            ("heading_deg", "haeding_deg"),
        ] {
            let (taken, said) = heading(&["time_s", column, "rudder_deg"], Some(name)).unwrap();
            assert_eq!(taken, column);
            assert!(said.contains(&format!("--heading {name}: there is no such column")), "{said}");
        }
        let (taken, said) = heading(&["time_s", "headng [deg]", "rudder_deg"], None).unwrap();
        assert_eq!(taken, "headng [deg]");
        assert!(said.contains("no column is named for heading"), "{said}");
        let (_, said) = heading(&["time_s", "heading_deg", "rudder_deg"], None).unwrap();
        assert_eq!(said, "");
    }

    #[test]
    fn io_a_column_of_another_quantity_is_not_suggested() {
        // The integral of a rate whose unit is known would be taken; of this one it is not.
        for (columns, expected) in [
            (["time_s", "alpha", "yaw_rate", "rudder"], None),
            (["time_s", "headi", "yaw_rate", "rudder"], Some("headi")),
        ] {
            match heading(&columns, None) {
                Err(Fault::MissingColumn { nearest, .. }) => {
                    assert_eq!(nearest.as_deref(), expected);
                }
                found => panic!("{found:?}"),
            }
        }
    }

    #[test]
    fn io_a_name_that_may_be_several_is_refused() {
        for (columns, name) in [
            (["time_s", "yaw [deg]", "yaw [rad]", "rudder"], "yaw"),
            (["time_s", "compass1", "yaw", "rudder"], "compass2"),
            (["time_s", "m_fin", "yaw", "rudder"], "c_fin"),
            (["time_s", "headingx", "headingz", "rudder"], "headingy"),
        ] {
            let refused = heading(&columns, Some(name));
            assert!(matches!(refused, Err(Fault::NoSuchColumn { .. })), "{refused:?}");
        }
    }
}
