"""Columns of tables as NumPy arrays, without copying them where they lie in one piece."""

from __future__ import annotations

from typing import Any, Optional

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._errors import InputError, UsageError

Array = NDArray[np.float64]


def array(values: ArrayLike, name: str = "the array") -> Array:
    """As 64-bit floats; what is that already stays where it is.

    Raises UsageError for what is no column of numbers: complex numbers, text, dates, several dimensions, masked values,
    quantities with units of their own.
    """
    if hasattr(values, "magnitude") and hasattr(values, "units"):
        raise UsageError(f"{name} has units of its own, {values.units}; give its magnitude in SI units")
    if np.ma.is_masked(values):
        raise UsageError(
            f"{name} has masked values; leave their rows out of all arrays, or put in what is meant"
        )
    return _floats(values, name)


def optional(values: Optional[ArrayLike], name: str = "the array") -> Optional[Array]:
    """The same of a column that may be missing; a masked value is a missing one."""
    if values is None:
        return None
    if np.ma.is_masked(values):
        values = np.ma.filled(np.ma.asarray(values, dtype=np.float64), np.nan)
    return _floats(values, name)


def seconds(values: ArrayLike, name: str = "time") -> Array:
    """Time as seconds; of dates and durations since the first."""
    found = np.asarray(values)
    if found.dtype.kind == "M" and found.ndim == 1 and not np.ma.is_masked(values):
        return _durations(found - found[:1], name)
    if found.dtype.kind == "m" and found.ndim == 1 and not np.ma.is_masked(values):
        return _durations(found, name)
    return array(values, name)


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
    """The named columns of a pandas, polars or Arrow table, of anything with an Arrow stream, or of a mapping.

    A column that is named and not there is an error where it is needed, else missing.
    """
    if hasattr(table, "__arrow_c_stream__") and not hasattr(table, "__getitem__"):
        import pyarrow

        table = pyarrow.table(table)
    known = [str(name) for name in getattr(table, "column_names", getattr(table, "columns", table))]
    found: dict[str, Any] = {}
    for quantity, name in names.items():
        if name is not None and name in known:
            found[quantity] = _column(table[name])
        elif quantity in ("time", "heading", "rudder"):
            raise InputError(f"no column {name!r} for {quantity}; found {', '.join(known)}")
        else:
            found[quantity] = None
    return found


def _column(values: Any) -> Any:
    if hasattr(values, "combine_chunks"):  # pyarrow.ChunkedArray
        chunks = values.chunks
        values = chunks[0] if len(chunks) == 1 else values.combine_chunks()
        return values.to_numpy(zero_copy_only=False)
    if hasattr(values, "to_numpy"):
        return values.to_numpy()
    return values
