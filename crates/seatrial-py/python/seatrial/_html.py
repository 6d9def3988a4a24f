"""Results in a notebook."""

from __future__ import annotations

from html import escape
from typing import Any, Optional, Sequence


def number(value: Any, digits: int = 3) -> str:
    """A number in three figures; a dash for none."""
    return "-" if value is None else f"{value:.{digits}g}"


def bounds(interval: Optional[Sequence[float]]) -> str:
    """The bounds of an interval."""
    return "-" if interval is None else f"{interval[0]:.4g} to {interval[1]:.4g}"


def table(head: Sequence[str], rows: Sequence[Sequence[Any]]) -> str:
    """A table; every cell is text."""
    top = "".join(f"<th>{escape(cell)}</th>" for cell in head)
    lines = ("".join(f"<td>{escape(str(cell))}</td>" for cell in row) for row in rows)
    return f"<table><tr>{top}</tr>{''.join(f'<tr>{line}</tr>' for line in lines)}</table>"


def verdict(outcome: str, reasons: Sequence[Sequence[str]]) -> str:
    """The outcome, and every reason."""
    lines = "".join(f"<li>{escape(reason[1])}</li>" for reason in reasons)
    return f"<p><b>{escape(outcome)}</b></p><ul>{lines}</ul>"
