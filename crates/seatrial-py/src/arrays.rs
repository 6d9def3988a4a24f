//! Samples from arrays and back.

use numpy::{IntoPyArray, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use seatrial::Record;
use seatrial_core::Sample;

use crate::usage;

/// A column of floats, read where it lies.
pub type Column<'py> = PyReadonlyArray1<'py, f64>;

/// The arrays of a record.
pub struct Columns<'a, 'py> {
    pub time: &'a Column<'py>,
    pub heading: &'a Column<'py>,
    pub rudder: &'a Column<'py>,
    pub speed: Option<&'a Column<'py>>,
    pub yaw_rate: Option<&'a Column<'py>>,
    pub thrust: Option<&'a Column<'py>>,
}

impl<'a, 'py> Columns<'a, 'py> {
    /// Without the columns that may be missing.
    pub fn of(time: &'a Column<'py>, heading: &'a Column<'py>, rudder: &'a Column<'py>) -> Self {
        Self { time, heading, rudder, speed: None, yaw_rate: None, thrust: None }
    }

    /// The samples, read from the arrays without copying these first. NaN in an optional column is a missing value.
    pub fn record(&self, py: Python<'_>) -> PyResult<Record> {
        let time = self.time.as_array();
        let length = time.len();
        let needed = |name: &str, column: &Column| match column.as_array().len() {
            found if found == length => Ok(()),
            found => Err(usage(
                py,
                format!("{name} has {found} values and time has {length}; expected as many"),
            )),
        };
        needed("heading", self.heading)?;
        needed("rudder", self.rudder)?;
        for (name, column) in
            [("speed", self.speed), ("yaw_rate", self.yaw_rate), ("thrust", self.thrust)]
        {
            column.map_or(Ok(()), |column| needed(name, column))?;
        }
        let (heading, rudder) = (self.heading.as_array(), self.rudder.as_array());
        let [speed, yaw_rate, thrust] =
            [self.speed, self.yaw_rate, self.thrust].map(|column| column.map(|c| c.as_array()));
        let known = |column: &Option<numpy::ndarray::ArrayView1<f64>>, k: usize| {
            column.as_ref().map(|c| c[k]).filter(|value| value.is_finite())
        };
        Ok((0..length)
            .map(|k| Sample {
                time_s: time[k],
                heading_rad: heading[k],
                rudder_rad: rudder[k],
                surge_speed_m_s: known(&speed, k),
                yaw_rate_rad_s: known(&yaw_rate, k),
                thrust: known(&thrust, k),
                ..Sample::default()
            })
            .collect())
    }
}

/// The samples as a dictionary of arrays by their names; a column without any value is left out.
pub fn dictionary<'py>(py: Python<'py>, samples: &[Sample<f64>]) -> PyResult<Bound<'py, PyDict>> {
    type Value = fn(&Sample<f64>) -> Option<f64>;
    let columns: [(&str, Value); 12] = [
        ("time_s", |s| Some(s.time_s)),
        ("heading_rad", |s| Some(s.heading_rad)),
        ("rudder_rad", |s| Some(s.rudder_rad)),
        ("surge_speed_m_s", |s| s.surge_speed_m_s),
        ("depth_m", |s| s.depth_m),
        ("altitude_m", |s| s.altitude_m),
        ("roll_rad", |s| s.roll_rad),
        ("pitch_rad", |s| s.pitch_rad),
        ("yaw_rate_rad_s", |s| s.yaw_rate_rad_s),
        ("north_m", |s| s.north_m),
        ("east_m", |s| s.east_m),
        ("thrust", |s| s.thrust),
    ];
    let arrays = PyDict::new(py);
    for (name, value) in columns {
        if samples.iter().any(|sample| value(sample).is_some()) {
            let column: Vec<f64> = samples.iter().map(|s| value(s).unwrap_or(f64::NAN)).collect();
            arrays.set_item(name, column.into_pyarray(py))?;
        }
    }
    Ok(arrays)
}
