"""Arrays in degrees that were meant to be in radians."""

from __future__ import annotations

import math
import warnings

import numpy as np

from ._columns import Array
from ._errors import UsageError


def refuse_degrees(heading: Array, rudder: Array) -> None:
    """Raises UsageError where the rudder is beyond a right angle, and warns where the heading looks like degrees."""
    largest = float(np.max(np.abs(rudder[np.isfinite(rudder)]), initial=0.0))
    if largest > math.pi / 2:
        raise UsageError(
            f"rudder reaches {largest:.4g} rad, beyond a right angle; expected radians: np.radians(rudder)"
            " where it is in degrees"
        )
    known = heading[np.isfinite(heading)]
    if known.size < 2:
        return
    low, high = float(known.min()), float(known.max())
    is_compass = (0.0 <= low and high <= 360.0) or (-180.0 <= low and high <= 180.0)
    # One sample to the next: a vehicle turns by less than a right angle, a wrapped compass jumps by a whole turn.
    steps = np.abs(np.diff(known))
    is_unwrapped = bool(np.all(steps < math.pi / 2))
    if high - low > 2.0 * math.pi and is_compass and not is_unwrapped:
        warnings.warn(
            f"heading goes from {low:.4g} to {high:.4g} and jumps; expected radians: np.radians(heading) where it is in degrees",
            UserWarning,
            stacklevel=3,
        )
