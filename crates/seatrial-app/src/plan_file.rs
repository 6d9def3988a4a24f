//! Plans of trials in TOML files.

use std::path::Path;

use seatrial_core::{Axis, Plan, Trial};
use serde::Deserialize;

use crate::Error;

/// The plan of a file, or the axis' own where there is no file: the paper's for yaw, [`Plan::pitch`] for pitch. What a file
/// leaves out is that of the same plan. A file that names another axis than `axis` is refused.
pub fn load_plan(path: Option<&Path>, axis: Option<Axis>) -> Result<Plan<f64>, Error> {
    let Some(path) = path else {
        return Ok(own_plan(axis.unwrap_or_default()));
    };
    let failure = |problem: String| Error::Input(format!("{}: {problem}", path.display()));
    let text = std::fs::read_to_string(path).map_err(|error| failure(error.to_string()))?;
    let named = axis_of(&text);
    if let (Some(named), Some(axis)) = (named, axis)
        && named != axis
    {
        let [named, wanted] = [named, axis].map(Axis::angle);
        return Err(failure(format!(
            "a plan for {named}, not for {wanted}; leave --axis out, or take another plan"
        )));
    }
    let plan = read(&text, named.or(axis).unwrap_or_default())
        .map_err(|error| failure(format!("not a plan: {error}")))?;
    Trial::new(plan).map_err(|error| failure(error.to_string()))?;
    Ok(plan)
}

fn own_plan(axis: Axis) -> Plan<f64> {
    match axis {
        Axis::Yaw => Plan::paper(),
        Axis::Pitch => Plan::pitch(),
    }
}

/// The axis that a plan names, if it names one that there is.
fn axis_of(text: &str) -> Option<Axis> {
    #[derive(Deserialize)]
    struct Named {
        axis: Option<Axis>,
    }
    toml::from_str::<Named>(text).ok()?.axis
}

fn read(text: &str, axis: Axis) -> Result<Plan<f64>, toml::de::Error> {
    if axis == Axis::Yaw {
        // Read as it stands: an error names its line.
        return toml::from_str(text);
    }
    let mut plan = toml::Table::try_from(own_plan(axis)).unwrap_or_default();
    replace(&mut plan, toml::from_str(text)?);
    plan.try_into()
}

/// Fields of `given` go before those of `base`, table by table.
fn replace(base: &mut toml::Table, given: toml::Table) {
    for (name, value) in given {
        match (base.get_mut(&name), value) {
            // A manoeuvre of another kind has other fields.
            (Some(toml::Value::Table(base)), toml::Value::Table(given)) if name != "excitation" => {
                replace(base, given);
            }
            (_, value) => {
                base.insert(name, value);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn io_what_a_plan_of_pitch_leaves_out_is_that_of_the_plan_for_pitch() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plan.toml");
        let load = |text: &str, axis| {
            std::fs::write(&path, text).unwrap();
            load_plan(Some(&path), axis)
        };
        let plan = load(
            "thrusts = [0.8]\n[envelope]\nroll_max_rad = 0.3\n",
            Some(Axis::Pitch),
        )
        .unwrap();
        let mut expected = Plan::pitch();
        expected.thrusts = seatrial_core::List::from_slice(&[0.8]).unwrap();
        expected.envelope.roll_max_rad = 0.3;
        assert_eq!(plan, expected);
        assert_eq!(load("axis = \"pitch\"\n", None).unwrap(), Plan::pitch());
        assert_eq!(load("", None).unwrap(), Plan::paper());
        for (text, axis, said) in [
            (
                "axis = \"pitch\"\n",
                Some(Axis::Yaw),
                "a plan for pitch, not for heading",
            ),
            ("thrusts = []\n", Some(Axis::Pitch), "thrusts must be"),
            (
                "amplitude = 1\n",
                Some(Axis::Pitch),
                "unknown field `amplitude`",
            ),
            ("axis = \"roll\"\n", None, "unknown variant `roll`"),
        ] {
            let refused = load(text, axis).unwrap_err().to_string();
            assert!(refused.contains(said), "{refused}");
        }
    }
}
