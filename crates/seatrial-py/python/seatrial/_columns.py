"""Columns of tables as NumPy arrays, without copying them where they lie in one piece."""

from __future__ import annotations

from typing import Any, Optional

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._errors import InputError

Array = NDArray[np.float64]


def array(values: ArrayLike) -> Array:
    """As 64-bit floats; what is that already stays where it is."""
    column = np.asarray(values, dtype=np.float64)
    if column.ndim != 1:
        raise InputError(f"found an array of {column.ndim} dimensions; expected one value a sample")
    return column


def optional(values: Optional[ArrayLike]) -> Optional[Array]:
    """The same of a column that may be missing."""
    return None if values is None else array(values)


def columns(table: Any, names: dict[str, Optional[str]]) -> dict[str, Optional[Array]]:
    """The named columns of a pandas, polars or Arrow table, of anything with an Arrow stream, or of a mapping.

    A column that is named and not there is an error where it is needed, else missing.
    """
    if hasattr(table, "__arrow_c_stream__") and not hasattr(table, "__getitem__"):
        import pyarrow

        table = pyarrow.table(table)
    known = [str(name) for name in getattr(table, "column_names", getattr(table, "columns", table))]
    found: dict[str, Optional[Array]] = {}
    for quantity, name in names.items():
        if name is not None and name in known:
            found[quantity] = _column(table[name])
        elif quantity in ("time", "heading", "rudder"):
            raise InputError(f"no column {name!r} for {quantity}; found {', '.join(known)}")
        else:
            found[quantity] = None
    return found


def _column(values: Any) -> Array:
    if hasattr(values, "combine_chunks"):  # pyarrow.ChunkedArray
        chunks = values.chunks
        values = chunks[0] if len(chunks) == 1 else values.combine_chunks()
        return array(values.to_numpy(zero_copy_only=False))
    if hasattr(values, "to_numpy"):
        return array(values.to_numpy())
    return array(values)
