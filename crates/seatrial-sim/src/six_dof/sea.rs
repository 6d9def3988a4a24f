//! The sea around the vehicle.

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use super::waves::{WaveField, Waves};

/// The current at a depth.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CurrentPoint {
    /// Depth, m.
    pub depth_m: f64,
    /// Towards north, m/s.
    pub north_m_s: f64,
    /// Towards east, m/s.
    pub east_m_s: f64,
}

/// The sea: its water, current, waves and bottom.
///
/// The current is linear in depth between its points and constant beyond them: no point is still water, one
/// a uniform current.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sea {
    /// Density of the water, kg/m^3.
    pub density_kg_m3: f64,
    /// The current, in order of depth.
    pub current: Vec<CurrentPoint>,
    /// Waves; absent: none.
    pub waves: Option<Waves>,
    /// The bottom; absent: out of reach.
    pub bottom: Option<Bottom>,
}

/// A plane bottom.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bottom {
    /// Its depth at the origin, m.
    pub depth_m: f64,
    /// Metres deeper for each metre north.
    #[serde(default)]
    pub slope_north: f64,
    /// Metres deeper for each metre east.
    #[serde(default)]
    pub slope_east: f64,
}

/// The flow at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flow {
    /// North, east and down, m/s.
    pub velocity_m_s: Vector3<f64>,
    /// Its change with time at the place, m/s^2.
    pub acceleration_m_s2: Vector3<f64>,
    /// Its change with the place, 1/s: column j is the change towards north, east and down.
    pub gradient_per_s: Matrix3<f64>,
}

impl Flow {
    /// Acceleration of the water itself, m/s^2.
    pub fn of_the_water_m_s2(&self) -> Vector3<f64> {
        self.changes_along_m_s2(&self.velocity_m_s)
    }

    /// How fast the flow changes for one who moves with this velocity, m/s^2.
    pub fn changes_along_m_s2(&self, velocity_m_s: &Vector3<f64>) -> Vector3<f64> {
        self.acceleration_m_s2 + self.gradient_per_s * velocity_m_s
    }
}

impl Sea {
    /// The flow at a place and a time, in the waves of this sea.
    pub fn flow(&self, waves: Option<&WaveField>, position_m: &Vector3<f64>, time_s: f64) -> Flow {
        let mut flow = self.current(position_m.z);
        if let Some(waves) = waves {
            let motion = waves.motion(position_m, time_s);
            flow.velocity_m_s += motion.velocity_m_s;
            flow.acceleration_m_s2 += motion.acceleration_m_s2;
            flow.gradient_per_s += motion.gradient_per_s;
        }
        flow
    }

    /// Height above the bottom, m.
    pub fn altitude_m(&self, position_m: &Vector3<f64>) -> Option<f64> {
        self.bottom.map(|bottom| {
            bottom.depth_m + bottom.slope_north * position_m.x + bottom.slope_east * position_m.y
                - position_m.z
        })
    }

    /// The current at a depth.
    fn current(&self, depth_m: f64) -> Flow {
        let steady = |velocity_m_s, shear_per_s: Vector3<f64>| {
            let mut gradient_per_s = Matrix3::zeros();
            gradient_per_s.set_column(2, &shear_per_s);
            Flow { velocity_m_s, acceleration_m_s2: Vector3::zeros(), gradient_per_s }
        };
        let velocity = |point: &CurrentPoint| Vector3::new(point.north_m_s, point.east_m_s, 0.0);
        let below = self.current.partition_point(|p| p.depth_m < depth_m);
        let above = below.checked_sub(1).and_then(|k| self.current.get(k));
        match (above, self.current.get(below)) {
            (Some(above), Some(below)) => {
                let shear_per_s =
                    (velocity(below) - velocity(above)) / (below.depth_m - above.depth_m);
                let velocity_m_s = velocity(above) + shear_per_s * (depth_m - above.depth_m);
                steady(velocity_m_s, shear_per_s)
            }
            (Some(nearest), None) | (None, Some(nearest)) => {
                steady(velocity(nearest), Vector3::zeros())
            }
            (None, None) => steady(Vector3::zeros(), Vector3::zeros()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_current_is_linear_between_its_points() {
        let point = |depth_m, north_m_s| CurrentPoint { depth_m, north_m_s, east_m_s: 0.1 };
        let sea = Sea {
            density_kg_m3: 1000.0,
            current: vec![point(1.0, 0.4), point(5.0, 0.0)],
            waves: None,
            bottom: None,
        };
        let flow = |z| sea.flow(None, &Vector3::new(7.0, -3.0, z), 5.0);
        assert_eq!(flow(0.0).velocity_m_s, Vector3::new(0.4, 0.1, 0.0));
        let middle = flow(2.0);
        assert!((middle.velocity_m_s - Vector3::new(0.3, 0.1, 0.0)).norm() < 1e-15);
        assert!((middle.gradient_per_s.column(2) - Vector3::new(-0.1, 0.0, 0.0)).norm() < 1e-15);
        assert_eq!(flow(9.0).gradient_per_s, Matrix3::zeros());
        assert_eq!(middle.of_the_water_m_s2(), Vector3::zeros());
    }

    #[test]
    fn exact_a_sloping_bottom() {
        let sea = Sea {
            density_kg_m3: 1000.0,
            current: Vec::new(),
            waves: None,
            bottom: Some(Bottom { depth_m: 12.0, slope_north: -0.1, slope_east: 0.02 }),
        };
        let altitude_m = sea.altitude_m(&Vector3::new(50.0, 100.0, 3.0)).unwrap();
        assert!((altitude_m - 6.0).abs() < 1e-12);
    }
}
