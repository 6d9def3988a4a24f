"""Arrays in degrees that were meant to be in radians."""

from __future__ import annotations

import math
import warnings

import numpy as np

from ._columns import Array
from ._errors import UsageError


def refuse_degrees(heading: Array, rudder: Array) -> None:
    """Raises UsageError where the rudder is beyond a right angle, and warns where the heading looks like degrees."""
    low, high = _bounds(rudder)
    largest = max(-low, high)
    if largest > math.pi / 2:
        raise UsageError(
            f"rudder reaches {largest:.4g} rad, beyond a right angle; expected radians: np.radians(rudder)"
            " where it is in degrees"
        )
    low, high = _bounds(heading)
    is_compass = (0.0 <= low and high <= 360.0) or (-180.0 <= low and high <= 180.0)
    if high - low <= 2.0 * math.pi or not is_compass:
        return
    # One sample to the next: a vehicle turns by less than a right angle, a wrapped compass jumps by a whole turn.
    steps = np.abs(np.diff(heading[np.isfinite(heading)]))
    if np.any(steps >= math.pi / 2):
        warnings.warn(
            f"heading goes from {low:.4g} to {high:.4g} and jumps; expected radians: np.radians(heading) where it is in degrees",
            UserWarning,
            stacklevel=3,
        )


def _bounds(values: Array) -> tuple[float, float]:
    """The least and the greatest finite value; (0, 0) where there is none."""
    if values.size == 0:
        return 0.0, 0.0
    low, high = float(np.min(values)), float(np.max(values))
    if math.isfinite(low) and math.isfinite(high):
        return low, high
    finite = values[np.isfinite(values)]
    return _bounds(finite)
