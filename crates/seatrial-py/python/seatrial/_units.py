"""Arrays in other units than radians and seconds."""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass
from typing import Any, Literal, Mapping, Optional

import numpy as np
from numpy.typing import ArrayLike

from ._columns import Array, array, in_unit, optional, seconds
from ._errors import InputError, SeatrialWarning, UsageError

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


SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0, "d": 86400.0}
"""Units of time."""

ANGLES = {"rad": 1.0, "deg": math.degrees(1.0)}
"""Numbers for one radian."""


@dataclass(frozen=True)
class Said:
    """The units that the caller said; None where nothing was said."""

    time: Optional[str]
    heading: Optional[Angle]
    rudder: Optional[RudderUnit]
    yaw_rate: Optional[str]
    time_is_a_date: bool

    @staticmethod
    def of(
        time: ArrayLike, units: Optional[Mapping[str, str]], heading: Optional[Angle], rudder: Optional[RudderUnit]
    ) -> Said:
        """Of arguments. Raises UsageError for a unit that there is not."""
        known: dict[str, Mapping[str, Any]] = {
            "time": {unit: unit for unit in SECONDS},
            "heading": {unit: unit for unit in ANGLES},
            "rudder": {"rad": "rad", "deg": "deg", "full": "full", "fraction": "full"},
            "yaw_rate": {"rad/s": "rad/s", "deg/s": "deg/s"},
        }
        found: dict[str, Any] = {"time": None, "heading": heading, "rudder": rudder, "yaw_rate": None}
        for quantity, unit in (units or {}).items():
            if quantity not in known:
                raise UsageError(f"units has {quantity!r}; expected {', '.join(known)}")
            if unit not in known[quantity]:
                raise UsageError(f"units={{{quantity!r}: {unit!r}}}: expected {', '.join(known[quantity])}")
            found[quantity] = known[quantity][unit]
        kind = np.asarray(getattr(time, "magnitude", time)).dtype.kind
        return Said(**found, time_is_a_date=kind in "MmO")

    def native(self, rudder: Array) -> dict[str, Any]:
        """Numbers of each column for one SI unit, and who says so: the caller, this package's pages, or nobody."""
        # Nothing tells an angle of more than 45 degrees from a share of full rudder.
        is_usual = _largest(rudder) <= LARGEST_USUAL_RUDDER_RAD
        return {
            "time": (1.0 / SECONDS[self.time or "s"], "given" if self.time or self.time_is_a_date else "stated"),
            "heading": (ANGLES[self.heading or "rad"], "given" if self.heading else "stated"),
            "rudder": (ANGLES.get(self.rudder or "rad", 1.0), "given" if self.rudder else "stated" if is_usual else "assumed"),
            "yaw_rate": (math.degrees(1.0) if self.yaw_rate == "deg/s" else 1.0, "given" if self.yaw_rate else "stated"),
            "time_is_a_date": self.time_is_a_date,
        }


def sound(columns: tuple[Optional[Array], ...], drop_invalid: bool) -> list[Any]:
    """The columns of a record, time, heading and rudder first, without samples that are no numbers or go back in time.

    Raises InputError where there are any and they are not to be left out.
    """
    time, heading, rudder = columns[:3]
    if time is None or heading is None or rudder is None or not time.size == heading.size == rudder.size:
        return list(columns)
    finite = np.isfinite(time) & np.isfinite(heading) & np.isfinite(rudder)
    latest = np.maximum.accumulate(np.where(finite, time, -np.inf))
    kept = finite & (time >= latest)
    if kept.all():
        return list(columns)
    first = int(np.argmin(kept))
    what = f"at {first} with time {time[first]:g}, heading {heading[first]:g}, rudder {rudder[first]:g}"
    count = f"{int(np.sum(~kept))} of {kept.size} samples are no numbers or go back in time, the first {what}"
    if not drop_invalid:
        raise InputError(f"{count}; leave them out of all arrays, or say drop_invalid=True")
    warnings.warn(f"{count}; they were left out", SeatrialWarning, stacklevel=3)
    return [column if column is None or column.size != kept.size else column[kept] for column in columns]


def yaw_rates(values: Optional[ArrayLike], unit: str) -> Optional[Array]:
    """Yaw rates as rad/s; NaN where unknown."""
    found = optional(values, "yaw_rate", unit)
    return found if found is None or unit == "rad/s" else np.radians(found)


def times(values: ArrayLike, unit: str = "s") -> Array:
    """Time as seconds. Raises UsageError for nanoseconds and other units that are none."""
    values = in_unit(values, "s", "time")
    found = seconds(values)
    if np.asarray(values).dtype.kind in "fiu" and unit != "s":
        found = found * SECONDS[unit]
    if found.size < 2:
        return found
    # The mean will do, and costs nothing on a million samples.
    interval = abs(float(found[-1] - found[0])) / (found.size - 1)
    if interval > LONGEST_INTERVAL_S:
        raise UsageError(
            f"time has a sample every {interval:.4g} s; expected seconds: leave datetime64 as it is,"
            " or divide nanoseconds by 1e9"
        )
    if unit == "s" and np.asarray(values).dtype.kind in "iu" and interval >= 10.0:
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
