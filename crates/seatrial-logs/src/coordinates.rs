//! Latitudes and longitudes as recorders write them, and metres between them.

use crate::csv::number;
use crate::table::Cell;

/// Metres of a minute of latitude.
const NAUTICAL_MILE_M: f64 = 1852.0;
/// Positions in 1e-7 deg, or in degrees and minutes, exceed all angles.
const LARGEST_DEG: f64 = 360.0;
/// 180 degrees and no minutes as `dddmm.mmmm`.
const LARGEST_DEG_MIN: f64 = 18_000.0;

/// Metres north and east of another place, both latitude and longitude, deg.
pub(crate) fn metres(
    [latitude, longitude]: [f64; 2],
    [first, first_longitude]: [f64; 2],
) -> [f64; 2] {
    let turned = (longitude - first_longitude + 540.0).rem_euclid(360.0) - 180.0;
    [
        (latitude - first) * 60.0 * NAUTICAL_MILE_M,
        turned * 60.0 * NAUTICAL_MILE_M * libm::cos(first.to_radians()),
    ]
}

/// Latitude and longitude, deg, of a place so many metres north and east of another: [`metres`] the other way.
pub(crate) fn place([north_m, east_m]: [f64; 2], [first, first_longitude]: [f64; 2]) -> [f64; 2] {
    let minute_m = 60.0 * NAUTICAL_MILE_M;
    let longitude = first_longitude + east_m / (minute_m * libm::cos(first.to_radians()));
    [first + north_m / minute_m, (longitude + 540.0).rem_euclid(360.0) - 180.0]
}

/// Degrees of a latitude or longitude, which autopilots log in whole 1e-7 deg, and receivers write as `dddmm.mmmm`.
pub(crate) fn degrees(number: f64) -> f64 {
    let size = number.abs();
    if size <= LARGEST_DEG {
        number
    } else if size.fract() == 0.0 && size > LARGEST_DEG_MIN {
        number * 1e-7
    } else {
        ((size / 100.0).floor() + size % 100.0 / 60.0).copysign(number)
    }
}

/// `33°51.4'S` and `151°12.5'W` are less than 0.
pub(crate) fn coordinate(cell: &Cell) -> Cell {
    let southern = match cell {
        Cell::Text(text) => text.trim().strip_suffix(['S', 's']),
        _ => None,
    };
    let degrees = southern.and_then(|text| number(text.trim_end(), false));
    degrees.map_or_else(|| cell.clone(), |degrees| Cell::Number(-degrees))
}
