"""Identification of arrays, tables and logs."""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import partial
from typing import Any, Literal, Optional

import numpy as np
from numpy.typing import ArrayLike

from . import _native
from ._columns import Array, columns as columns_of, optional
from ._documents import Verdict
from ._errors import UsageError
from ._estimator import Method
from ._logs import read_log
from ._model import Identification
from ._reading import Path, Reading, Span, tell
from ._units import Angle, RudderUnit, Said, doubt_heading, doubt_model, headings, rudders, sound, times, yaw_rates

Estimate = Literal["refined", "online", "batch", "paper"]


def identify(
    time: ArrayLike,
    heading: ArrayLike,
    rudder: ArrayLike,
    speed: Optional[ArrayLike] = None,
    *,
    yaw_rate: Optional[ArrayLike] = None,
    thrust: Optional[ArrayLike] = None,
    training: Span = (None, None),
    validation: Optional[Span] = None,
    estimate: Estimate = "refined",
    method: Optional[Method] = None,
    lambda_rad_s: Optional[float] = None,
    trace: bool = False,
    heading_unit: Optional[Angle] = None,
    rudder_unit: Optional[RudderUnit] = None,
    units: Optional[dict[str, str]] = None,
    drop_invalid: bool = False,
) -> Identification:
    """Identify the yaw model of a record.

    Parameters
    ----------
    time
        s, increasing, or durations, or dates with or without a time zone. Quantities of Pint and Astropy are converted, also below.
    heading
        Wrapped or not, in ``heading_unit``.
    rudder
        In ``rudder_unit``, each angle acting from its time on; positive turns as the model's b2 says.
    speed, yaw_rate, thrust
        m/s, rad/s, fraction of full; NaN or masked where unknown.
    training, validation
        Windows (from, to), s, half open; None is the record's end.
    estimate
        ``refined`` with intervals, ``online`` as on the vehicle, ``paper`` to the letter; ``batch`` is the paper's filters
        and least squares, (16)-(34), in one pass over evenly sampled arrays, for records of a million samples: a damaged
        sample is an error, and nothing is judged.
    method
        Of the estimate made sample by sample; the instrumental variable without.
    lambda_rad_s
        Pole of the state variable filter, derived from the data where None.
    trace
        Keep the estimates after every sample.
    heading_unit, rudder_unit
        ``rad`` or ``deg``; a rudder also ``full``, fractions of full rudder. Float64 arrays in rad are read where they lie.
    units
        The same and more by quantity, as a log is read: ``{"time": "ms", "heading": "deg", "yaw_rate": "deg/s"}``. What is not said is
        taken for s, rad and rad/s and doubted as a log's columns are: the verdict tells.
    drop_invalid
        Leave samples out whose time, heading or rudder is no number, or whose time goes back, instead of refusing the record.

    Returns
    -------
    Identification
        Look at ``outcome`` before using its ``model``.

    Raises
    ------
    RejectedError
        Nothing can be estimated; ``reason`` is the verdict's code, such as ``constant of rudder``.
    InputError
        Samples that are no numbers.
    UsageError
        Arrays that are no columns of numbers, or not in the units that are said.

    Warns
    -----
    SeatrialWarning
        Values look like those of another unit.
    """
    said = Said.of(time, units, heading_unit, rudder_unit)
    time_s = times(time, said.time or "s")
    psi, delta = headings(heading, said.heading or "rad"), rudders(rudder, said.rudder or "rad")
    if psi.size == time_s.size:
        doubt_heading(time_s, psi)
    if estimate == "batch":
        if validation is not None or method not in (None, "least_squares") or trace:
            raise UsageError("estimate='batch' takes no validation, instrument or trace")
        return _batch(time_s, psi, delta, training, lambda_rad_s)
    rate = yaw_rates(yaw_rate, said.yaw_rate or "rad/s")
    columns = time_s, psi, delta, optional(speed, "speed", "m/s"), rate, optional(thrust, "thrust", "")
    time_s, psi, delta, u, rate, throttle = sound(columns, drop_invalid)
    text = _native.identify(
        time_s, psi, delta, u, rate, throttle, "full" if said.rudder == "full" else "rad", said.native(delta), training, validation,
        estimate, method, lambda_rad_s, trace,
    )
    found = Identification(json.loads(text), partial(_record, time_s, psi, delta))
    doubt_model(found.model.a22_per_s, found.model.b2_per_s2, delta, psi)
    return found


def identify_log(
    path: Path,
    *,
    channels_file: Optional[Path] = None,
    columns: Optional[dict[str, str]] = None,
    units: Optional[dict[str, str]] = None,
    full_rudder_rad: Optional[float] = None,
    rudder_delay_s: Optional[float] = None,
    rudder_lag_s: Optional[float] = None,
    drop_invalid: bool = False,
    rudder_trim_us: Optional[float] = None,
    axis: Literal["yaw", "pitch"] = "yaw",
    training: Span = (None, None),
    validation: Span = (None, None),
    validate_on: Optional[Path] = None,
    more_logs: Sequence[Path] = (),
    estimate: Literal["refined", "online", "paper"] = "refined",
    method: Optional[Method] = None,
    lambda_rad_s: Optional[float] = None,
    trace: bool = False,
) -> Identification:
    """Identify a log of any format, with the answer of ``seatrial identify LOG``.

    Parameters
    ----------
    path
        The log; its format is found by its content.
    channels_file, columns, units, full_rudder_rad, rudder_trim_us, rudder_delay_s, rudder_lag_s, drop_invalid
        How it is read: see `Reading`.
    axis
        ``yaw`` under the rudder or ``pitch`` under the elevator.
    training, validation
        Windows (from, to), s of the log, half open. Without any the manoeuvres of the log are looked for: for each speed
        the best excited one trains, joined with others, and another one validates.
    validate_on
        Another log to validate on; the validation window is then one of that log.
    more_logs
        Further logs of the same vehicle and load, without windows: one model a speed is made of all, and one log validates it.
    estimate, method, lambda_rad_s, trace
        As of `identify`.

    Returns
    -------
    Identification
        ``document`` is what ``seatrial identify LOG --json`` prints, to the bit; only what to do is said with the arguments
        of this function. ``speeds`` has the model of each speed, ``model`` is the surest. Where nothing can be estimated
        ``outcome`` is "do not use", ``reasons`` say why, and ``model`` raises RejectedError.

    Warns
    -----
    SeatrialWarning
        What the command warns of.
    """
    reading = Reading(
        channels_file, columns, units, full_rudder_rad, rudder_trim_us, rudder_delay_s, rudder_lag_s,
        drop_invalid,
    )
    text, told = _native.identify_log(
        path, reading.native(), axis, training, validation, validate_on, list(more_logs), estimate, method,
        lambda_rad_s, trace,
    )
    tell(told)
    document = json.loads(text)
    held_out = document.get("validation_source") if document.get("validation") else None
    record = partial(read_log, path if held_out is None else held_out["path"], reading)
    return Identification(document, record if axis == "yaw" else None)


def _record(time_s: Array, heading_rad: Array, rudder: Array) -> dict[str, Array]:
    return {"time_s": time_s, "heading_rad": heading_rad, "rudder_rad": rudder}


def _batch(
    time: Array, heading: Array, rudder: Array, training: Span, lambda_rad_s: Optional[float]
) -> Identification:
    t, psi, delta = (np.ascontiguousarray(column) for column in (time, heading, rudder))
    batch = json.loads(_native.least_squares(t, psi, delta, training, lambda_rad_s))
    why = "batch least squares has no interval and nothing was validated"
    verdict: Verdict = {
        "accepted": False, "outcome": "not_validated", "reasons": [{"code": "not_judged", "text": why}]
    }
    return Identification(
        {"batch": batch, "online": None, "refined": None, "validation": None, "verdict": verdict}
    )


def identify_table(
    table: Any,
    *,
    time: str = "time_s",
    heading: str = "heading_rad",
    rudder: str = "rudder_rad",
    speed: Optional[str] = "surge_speed_m_s",
    yaw_rate: Optional[str] = "yaw_rate_rad_s",
    thrust: Optional[str] = "thrust",
    **settings: Any,
) -> Identification:
    """Identify from the columns of a table: pandas, polars (also lazy), Arrow, DuckDB, a record array, a mapping.

    Parameters
    ----------
    table
        The table.
    time, heading, rudder, speed, yaw_rate, thrust
        Names of its columns; of the last three one that is not there is not known.
    **settings
        Those of `identify`, units among them.

    Returns
    -------
    Identification
        As of `identify`.
    """
    names = dict(
        time=time, heading=heading, rudder=rudder, speed=speed, yaw_rate=yaw_rate, thrust=thrust
    )
    return identify(**columns_of(table, names), **settings)
