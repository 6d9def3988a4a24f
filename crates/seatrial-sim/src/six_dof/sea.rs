//! The sea around the vehicle.

use nalgebra::Vector3;
use serde::Serialize;

/// The current at a depth.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CurrentPoint {
    /// Depth, m.
    pub depth_m: f64,
    /// Towards north, m/s.
    pub north_m_s: f64,
    /// Towards east, m/s.
    pub east_m_s: f64,
}

/// The sea: its water and its current.
///
/// The current is linear in depth between its points and constant beyond them: no point is still water, one
/// a uniform current.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sea {
    /// Density of the water, kg/m^3.
    pub density_kg_m3: f64,
    /// The current, in order of depth.
    pub current: Vec<CurrentPoint>,
}

/// The flow at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flow {
    /// North, east and down, m/s.
    pub velocity_m_s: Vector3<f64>,
    /// Its change with depth, 1/s.
    pub shear_per_s: Vector3<f64>,
}

impl Sea {
    /// The flow at a depth.
    pub fn flow(&self, depth_m: f64) -> Flow {
        let velocity = |point: &CurrentPoint| Vector3::new(point.north_m_s, point.east_m_s, 0.0);
        let below = self.current.partition_point(|p| p.depth_m < depth_m);
        let above = below.checked_sub(1).and_then(|k| self.current.get(k));
        match (above, self.current.get(below)) {
            (Some(above), Some(below)) => {
                let shear_per_s =
                    (velocity(below) - velocity(above)) / (below.depth_m - above.depth_m);
                Flow {
                    velocity_m_s: velocity(above) + shear_per_s * (depth_m - above.depth_m),
                    shear_per_s,
                }
            }
            (Some(nearest), None) | (None, Some(nearest)) => Flow {
                velocity_m_s: velocity(nearest),
                shear_per_s: Vector3::zeros(),
            },
            (None, None) => Flow {
                velocity_m_s: Vector3::zeros(),
                shear_per_s: Vector3::zeros(),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_current_is_linear_between_its_points() {
        let point = |depth_m, north_m_s| CurrentPoint {
            depth_m,
            north_m_s,
            east_m_s: 0.1,
        };
        let sea = Sea {
            density_kg_m3: 1000.0,
            current: vec![point(1.0, 0.4), point(5.0, 0.0)],
        };
        assert_eq!(sea.flow(0.0).velocity_m_s, Vector3::new(0.4, 0.1, 0.0));
        let middle = sea.flow(2.0);
        assert!((middle.velocity_m_s - Vector3::new(0.3, 0.1, 0.0)).norm() < 1e-15);
        assert!((middle.shear_per_s - Vector3::new(-0.1, 0.0, 0.0)).norm() < 1e-15);
        assert_eq!(sea.flow(9.0).shear_per_s, Vector3::zeros());
    }
}
