"""Arrays in other units than radians and seconds."""

from __future__ import annotations

import math
import warnings
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from ._columns import Array, array, in_unit, seconds
from ._errors import SeatrialWarning, UsageError

Angle = Literal["rad", "deg"]
RudderUnit = Literal["rad", "deg", "full"]

LARGEST_USUAL_RUDDER_RAD = math.radians(45.0)
"""Rudders and steered thrusters go further hardly ever."""

FASTEST_TURN_RAD_S = 2.0 * math.pi
"""No vessel turns round faster than once a second."""

LONGEST_INTERVAL_S = 1000.0
"""Between two samples of a manoeuvre, also of the largest ship."""

COASTED_RAD = 6.0
"""A vehicle that turns as far as this within its own time constant is none: real ones turn by 0.1 to 1 rad."""


def times(values: ArrayLike) -> Array:
    """Time as seconds. Raises UsageError for nanoseconds and other units that are none."""
    values = in_unit(values, "s", "time")
    found = seconds(values)
    if found.size < 2:
        return found
    # The mean will do, and costs nothing on a million samples.
    interval = abs(float(found[-1] - found[0])) / (found.size - 1)
    if interval > LONGEST_INTERVAL_S:
        raise UsageError(
            f"time has a sample every {interval:.4g} s; expected seconds: leave datetime64 as it is,"
            " or divide nanoseconds by 1e9"
        )
    if np.asarray(values).dtype.kind in "iu" and interval >= 10.0:
        warnings.warn(
            f"time is in whole numbers, {interval:.4g} apart, and read as seconds; divide milliseconds by 1e3",
            SeatrialWarning,
            stacklevel=3,
        )
    return found


def headings(values: ArrayLike, unit: Angle) -> Array:
    """Headings as radians."""
    return _radians(array(in_unit(values, unit, "heading"), "heading"), unit, "heading_unit")


def rudders(values: ArrayLike, unit: RudderUnit) -> Array:
    """Rudders as radians, or as fractions of full. Raises UsageError for values that are out of their unit."""
    found = array(in_unit(values, "" if unit == "full" else unit, "rudder"), "rudder")
    if unit == "full":
        largest = _largest(found)
        if largest > 1.5:
            raise UsageError(
                f"rudder reaches {largest:.4g} times full; expected fractions, -1 to 1, with rudder_unit='full'"
            )
        return found
    found = _radians(found, unit, "rudder_unit")
    largest = _largest(found)
    if largest > math.pi / 2:
        raise UsageError(
            f"rudder reaches {largest:.4g} rad, beyond a right angle; expected radians: np.radians(rudder)"
            " or rudder_unit='deg' where it is in degrees, rudder_unit='full' where it is a fraction of full"
        )
    if largest > LARGEST_USUAL_RUDDER_RAD:
        warnings.warn(
            f"rudder reaches {largest:.4g} rad, {math.degrees(largest):.0f} degrees; rudder_unit='full' where it is a"
            " fraction of full, rudder_unit='deg' where it is in degrees",
            SeatrialWarning,
            stacklevel=3,
        )
    return found


def _radians(values: Array, unit: str, name: str) -> Array:
    if unit == "rad":
        return values
    if unit == "deg":
        return np.radians(values)
    raise UsageError(f"{name}={unit!r}: expected 'rad' or 'deg'")


def doubt_heading(time: Array, heading: Array) -> None:
    """Warns where the heading looks like degrees: it jumps as a compass does at 360, or turns faster than a vessel can."""
    looked_at = _stretches(heading)
    low, high = _bounds(looked_at)
    if high - low <= 2.0 * math.pi:
        return
    steps, intervals = np.abs(np.diff(looked_at)), np.diff(_stretches(time))
    is_compass = (0.0 <= low and high <= 360.0) or (-180.0 <= low and high <= 180.0)
    jumps = is_compass and bool(np.any(steps >= math.pi / 2))
    # A step of a coarse compass is fast, and rare. What is not finite is not fast.
    is_fast = (intervals > 0.0) & (steps > FASTEST_TURN_RAD_S * intervals)
    turns = float(np.mean(is_fast)) > 0.05
    if jumps or turns:
        how = "jumps" if jumps else "turns faster than a vessel can"
        warnings.warn(
            f"heading goes from {low:.4g} to {high:.4g} and {how}; expected radians: np.radians(heading)"
            " or heading_unit='deg' where it is in degrees",
            SeatrialWarning,
            stacklevel=3,
        )


STRETCHES, STRETCH = 20, 500
"""Of long records so many stretches of so many samples are looked at."""


def _stretches(values: Array) -> Array:
    """All values in one row, or stretches spread over them, a row each."""
    if values.size <= STRETCHES * STRETCH:
        whole: Array = values[np.newaxis]
        return whole
    starts = np.linspace(0, values.size - STRETCH, STRETCHES).astype(np.intp)
    stretches: Array = values[starts[:, np.newaxis] + np.arange(STRETCH)]
    return stretches


def doubt_model(a22: float, b2: float, rudder: Array, heading: Array) -> None:
    """Warns of a model that says that the vehicle turns round within its own time constant: that of degrees."""
    low, high = _bounds(heading)
    if a22 == 0.0 or high - low <= 2.0 * math.pi:
        return
    coasted = abs(b2) * _largest(rudder) / a22**2
    if coasted > COASTED_RAD:
        warnings.warn(
            f"the model turns by {coasted:.3g} rad within its time constant, real vehicles by 0.1 to 1; heading_unit='deg'"
            " where the heading is in degrees",
            SeatrialWarning,
            stacklevel=3,
        )


def _largest(values: Array) -> float:
    """The largest magnitude of the finite values; 0 where there is none."""
    low, high = _bounds(values)
    return max(-low, high)


def _bounds(values: Array) -> tuple[float, float]:
    """The least and the greatest finite value; (0, 0) where there is none."""
    if values.size == 0:
        return 0.0, 0.0
    low, high = float(np.min(values)), float(np.max(values))
    if math.isfinite(low) and math.isfinite(high):
        return low, high
    return _bounds(values[np.isfinite(values)])
