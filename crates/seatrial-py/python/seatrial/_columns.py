"""Columns of tables as NumPy arrays, without copying them where they lie in one piece."""

from __future__ import annotations

from datetime import datetime
from typing import Any, Callable, Mapping, Optional

import narwhals as nw
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._errors import InputError, UsageError

Array = NDArray[np.float64]


def array(values: ArrayLike, name: str = "the array") -> Array:
    """As 64-bit floats; what is that already stays where it is.

    Raises UsageError for what is no column of numbers: complex numbers, text, dates, several dimensions, masked values.
    """
    if np.ma.is_masked(values):
        raise UsageError(
            f"{name} has masked values; leave their rows out of all arrays, or put in what is meant"
        )
    return _floats(values, name)


def in_unit(values: Any, unit: str, name: str) -> Any:
    """The numbers of a quantity of Pint or Astropy in a unit; what has no unit of its own stays as it is."""
    own = getattr(values, "units", getattr(values, "unit", None))
    if own is None or not (hasattr(values, "magnitude") or hasattr(values, "to_value")):
        return values
    try:
        return values.to_value(unit) if hasattr(values, "to_value") else values.to(unit).magnitude
    except Exception as error:  # Each library has its own.
        raise UsageError(f"{name} is in {own}; expected what converts to {unit or 'a number'}") from error


def optional(values: Optional[ArrayLike], name: str, unit: str) -> Optional[Array]:
    """A column that may be missing, in a unit; a masked value is a missing one."""
    if values is None:
        return None
    values = in_unit(values, unit, name)
    if np.ma.is_masked(values):
        values = np.ma.filled(np.ma.asarray(values, dtype=np.float64), np.nan)
    return _floats(values, name)


def seconds(values: ArrayLike, name: str = "time") -> Array:
    """Time as seconds; of dates, with or without a time zone, and of durations since the first."""
    found = np.asarray(values)
    if found.dtype.kind == "O" and found.ndim == 1 and found.size and isinstance(found[0], datetime):
        return _since_first(found, name)
    if found.dtype.kind == "M" and found.ndim == 1 and not np.ma.is_masked(values):
        return _durations(found - found[:1], name)
    if found.dtype.kind == "m" and found.ndim == 1 and not np.ma.is_masked(values):
        return _durations(found, name)
    return array(values, name)


def _since_first(found: NDArray[Any], name: str) -> Array:
    """Seconds of dates of Python or pandas."""
    try:
        passed = np.array([(date - found[0]).total_seconds() for date in found], dtype=np.float64)
    except (AttributeError, TypeError) as error:
        raise UsageError(f"{name}: {error}; expected dates that all have a time zone, or none of which has one") from error
    if np.isnan(passed).any():
        raise UsageError(f"{name} has dates that are no dates (NaT); leave their rows out of all arrays")
    return passed


def _durations(found: NDArray[Any], name: str) -> Array:
    if np.isnat(found).any():
        raise UsageError(f"{name} has dates that are no dates (NaT); leave their rows out of all arrays")
    whole = found.astype("timedelta64[ns]").astype(np.int64)
    return whole / 1e9


def _floats(values: ArrayLike, name: str) -> Array:
    found = np.asarray(values)
    if found.dtype.kind in "Mm":
        raise UsageError(f"{name} has dates or durations; expected numbers")
    if found.dtype.kind == "c":
        raise UsageError(f"{name} has complex numbers; expected real ones")
    try:
        column = np.asarray(found, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise UsageError(f"{name}: {error}; expected numbers") from error
    if column.ndim != 1:
        raise UsageError(
            f"{name} has {column.ndim} dimensions; expected an array of one, with one value a sample"
        )
    return column


def columns(table: Any, names: dict[str, Optional[str]]) -> dict[str, Any]:
    """The named columns of a mapping, a record array, or a table of pandas, polars, Arrow, DuckDB and others that narwhals knows.

    A column that is named and not there is an error where it is needed, else missing.
    """
    known, column = _table(table, [name for name in names.values() if name is not None])
    found: dict[str, Any] = {}
    for quantity, name in names.items():
        if name is not None and name in known:
            found[quantity] = column(name)
        elif quantity in ("time", "heading", "rudder"):
            raise InputError(f"no column {name!r} for {quantity}; found {', '.join(known)}")
        else:
            found[quantity] = None
    return found


def _table(table: Any, wanted: list[str]) -> tuple[list[str], Callable[[str], Any]]:
    """The names of all columns, and what gives one; of a lazy table those that are wanted are computed at once."""
    if isinstance(table, np.ndarray) and table.dtype.names:
        return list(table.dtype.names), table.__getitem__
    if isinstance(table, Mapping):
        return [str(name) for name in table], lambda name: _column(table[name])
    try:
        frame: Any = nw.from_native(table)
    except TypeError as error:
        if not hasattr(table, "__arrow_c_stream__"):
            raise UsageError(f"a {type(table).__name__} is no table; expected a mapping, a record array or a table") from error
        import pyarrow

        frame = nw.from_native(pyarrow.table(table))
    if isinstance(frame, nw.LazyFrame):
        known = frame.collect_schema().names()
        collected = frame.select([name for name in dict.fromkeys(wanted) if name in known]).collect()
        return known, lambda name: _column(collected[name].to_native())
    return frame.columns, lambda name: _column(frame[name].to_native())


def _column(values: Any) -> Any:
    if hasattr(values, "combine_chunks"):  # pyarrow.ChunkedArray
        chunks = values.chunks
        values = chunks[0] if len(chunks) == 1 else values.combine_chunks()
        return values.to_numpy(zero_copy_only=False)
    if hasattr(values, "to_numpy"):
        return values.to_numpy()
    return values
