"""What a model says that a vehicle does: simulated, and held against a record."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Optional

import numpy as np
from numpy.typing import ArrayLike

from ._columns import Array
from ._errors import InputError, UsageError
from ._model import Model
from ._units import Angle, RudderUnit, headings, rudders, times

_FEWEST = 3
"""Two numbers, heading and yaw rate at the start, are fitted."""


@dataclass(frozen=True, eq=False)
class Motion:
    """How a vehicle turns, sample by sample."""

    time_s: Array
    heading_rad: Array
    """Not wrapped."""
    yaw_rate_rad_s: Array


def simulate(
    model: Model,
    time: ArrayLike,
    rudder: ArrayLike,
    *,
    heading_rad: float = 0.0,
    yaw_rate_rad_s: float = 0.0,
    rudder_unit: RudderUnit = "rad",
) -> Motion:
    """Simulate a model under a rudder, exactly for any intervals between samples.

    Parameters
    ----------
    model
        The model.
    time
        s, increasing, as of `identify`.
    rudder
        In ``rudder_unit``, each angle acting from its time until the next one.
    heading_rad, yaw_rate_rad_s
        At the first sample.
    rudder_unit
        ``rad``, ``deg`` or ``full``.

    Returns
    -------
    Motion
        Heading and yaw rate at every sample.

    Raises
    ------
    UsageError
        Time that does not increase, or values that are missing.
    """
    time_s, delta = times(time), rudders(rudder, rudder_unit)
    if time_s.size != delta.size:
        raise UsageError(f"rudder has {delta.size} values; expected as many as time, {time_s.size}")
    if not (np.isfinite(time_s).all() and np.isfinite(delta).all() and (np.diff(time_s) > 0.0).all()):
        raise UsageError("time must increase, and time and rudder must be finite; leave other samples out")
    yaw_rate, heading = _moved(np.array([model.theta]), time_s, delta, yaw_rate_rad_s)
    return Motion(time_s, heading_rad + heading[0], yaw_rate[0])


def predict(
    model: Model,
    time: ArrayLike,
    heading: ArrayLike,
    rudder: ArrayLike,
    *,
    heading_unit: Angle = "rad",
    rudder_unit: RudderUnit = "rad",
) -> Motion:
    """What a model makes of the rudder of a record, from the start that fits its heading best.

    Parameters
    ----------
    model
        The model.
    time, heading, rudder, heading_unit, rudder_unit
        The record, as of `identify`. Samples with something missing, or with a time that does not increase, are left out.

    Returns
    -------
    Motion
        At the samples that are left.
    """
    time_s, psi, delta = _usable(time, heading, rudder, heading_unit, rudder_unit)
    return Motion(time_s, *_fitted(np.array([model.theta]), time_s, psi, delta)[:, 0])


def residuals(
    model: Model,
    time: ArrayLike,
    heading: ArrayLike,
    rudder: ArrayLike,
    *,
    heading_unit: Angle = "rad",
    rudder_unit: RudderUnit = "rad",
) -> Array:
    """Measured less predicted heading, rad.

    Parameters
    ----------
    model, time, heading, rudder, heading_unit, rudder_unit
        As of `predict`.

    Returns
    -------
    array
        At the samples of `predict`.
    """
    time_s, psi, delta = _usable(time, heading, rudder, heading_unit, rudder_unit)
    left: Array = psi - _fitted(np.array([model.theta]), time_s, psi, delta)[0, 0]
    return left


def fit(
    thetas: Array, time_s: Array, heading_rad: Array, rudder: Array
) -> tuple[Array, Array, Array]:
    """Time and measured heading of the usable samples, and the headings that models predict for them, a row each."""
    time_s, psi, delta = _usable(time_s, heading_rad, rudder, "rad", None)
    return time_s, psi, _fitted(thetas, time_s, psi, delta)[0]


def _usable(
    time: ArrayLike, heading: ArrayLike, rudder: ArrayLike, heading_unit: Angle, rudder_unit: Optional[RudderUnit]
) -> tuple[Array, Array, Array]:
    time_s, psi = times(time), headings(heading, heading_unit)
    delta = np.asarray(rudder, dtype=np.float64) if rudder_unit is None else rudders(rudder, rudder_unit)
    if not time_s.size == psi.size == delta.size:
        raise UsageError(
            f"time, heading and rudder have {time_s.size}, {psi.size} and {delta.size} values; expected as many of each"
        )
    finite = np.isfinite(time_s) & np.isfinite(psi) & np.isfinite(delta)
    time_s, psi, delta = time_s[finite], psi[finite], delta[finite]
    newest = np.maximum.accumulate(time_s)
    later = np.concatenate(([True], time_s[1:] > newest[:-1]))[: time_s.size]
    time_s, psi, delta = time_s[later], np.unwrap(psi[later]), delta[later]
    if time_s.size < _FEWEST:
        raise InputError(f"{time_s.size} usable samples; expected at least {_FEWEST}")
    return time_s, psi, delta


def _fitted(thetas: Array, time_s: Array, psi: Array, delta: Array) -> Array:
    """Headings and yaw rates of models, a row each, from the heading and the yaw rate that fit best.

    The motion is linear in its start: psi = psi_f + psi_0 + r_0 psi_r with psi_r = (e^{at} - 1) / a.
    """
    rates, angles = _moved(thetas, time_s, delta, 0.0)
    since = time_s - time_s[0]
    for k, (a22, _, _) in enumerate(thetas):
        to_rate = _growth(a22, since)[1]
        start = np.column_stack([np.ones_like(since), to_rate])
        (heading, rate), *_ = np.linalg.lstsq(start, psi - angles[k], rcond=None)
        angles[k] += heading + rate * to_rate
        rates[k] += rate * np.exp(a22 * since)
    return np.array([angles, rates])


def _moved(thetas: Array, time_s: Array, delta: Array, yaw_rate_rad_s: float) -> tuple[Array, Array]:
    """Yaw rates and headings from heading 0, a row a model; the rudder is held from sample to sample."""
    a22, b2, c0 = thetas.T[:, :, np.newaxis]
    decay, to_heading, to_both = _growth(a22, np.diff(time_s))
    push = b2 * delta[:-1] + c0
    rates, angles = np.zeros((2, len(thetas), time_s.size))
    rates[:, 0] = rate = np.full(len(thetas), float(yaw_rate_rad_s))
    for k, (kept, gained) in enumerate(zip(decay.T, (push * to_heading).T), 1):
        rates[:, k] = rate = kept * rate + gained
    angles[:, 1:] = np.cumsum(rates[:, :-1] * to_heading + push * to_both, axis=1)
    return rates, angles


def _growth(a22: Any, interval_s: Array) -> tuple[Array, Array, Array]:
    """e^{at}, (e^{at} - 1) / a and (e^{at} - 1 - a t) / a^2, also where a t is small."""
    at = a22 * interval_s
    small = np.abs(at) < 1e-4
    # The series is right to 1e-13 there, where the difference of exponentials is to 1e-12.
    a = np.where(small, 1.0, a22)
    first = np.where(small, interval_s * (1.0 + at / 2.0 + at**2 / 6.0), np.expm1(at) / a)
    second = np.where(
        small, interval_s**2 * (0.5 + at / 6.0 + at**2 / 24.0), (np.expm1(at) - at) / a**2
    )
    return np.exp(at), first, second
