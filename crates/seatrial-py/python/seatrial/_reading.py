"""How logs are read, what models are made of: the arguments that several functions share."""

from __future__ import annotations

import json
import warnings
from dataclasses import dataclass
from os import PathLike, fspath
from typing import Any, Iterable, Optional, Union

from ._errors import SeatrialWarning
from ._model import Identification, Model, TrialResult

Path = Union[str, "PathLike[str]"]
Span = tuple[Optional[float], Optional[float]]


@dataclass(frozen=True)
class Reading:
    """How a log is read. Everything has a default; what was assumed is told as a warning or in ``source``.

    Parameters
    ----------
    channels_file
        TOML file whose section ``channels`` says which column is which quantity, as ``--channels``.
    columns, units
        Column and unit by quantity, as in ``{"heading": "yaw"}`` and ``{"heading": "deg"}``; they go before the file.
    full_rudder_rad
        Angle of a full rudder, rad, where the log has pulses or fractions. Without it the rudder of the models is a
        fraction of full.
    rudder_trim_us
        Pulse width of the neutral rudder, us; 1500 without.
    rudder_delay_s, rudder_lag_s
        Dead time and time constant of the rudder behind the logged command, s; the model is then the one behind them; 0 of a measured angle.
    drop_invalid
        Leave rows with text, NaN, missing cells or reversed time out instead of refusing the log.
    """

    channels_file: Optional[Path] = None
    columns: Optional[dict[str, str]] = None
    units: Optional[dict[str, str]] = None
    full_rudder_rad: Optional[float] = None
    rudder_trim_us: Optional[float] = None
    rudder_delay_s: Optional[float] = None
    rudder_lag_s: Optional[float] = None
    drop_invalid: bool = False

    def native(self) -> dict[str, Any]:
        """As the native part takes it."""
        return {
            "channels_file": self.channels_file,
            "columns": self.columns or {},
            "units": self.units or {},
            "full_rudder_rad": self.full_rudder_rad,
            "rudder_trim_us": self.rudder_trim_us,
            "rudder_delay_s": self.rudder_delay_s,
            "rudder_lag_s": self.rudder_lag_s,
            "drop_invalid": self.drop_invalid,
        }


@dataclass(frozen=True)
class Campaign:
    """A campaign of a logbook: by its number, or the last one of a configuration; without either the last that was accepted."""

    logbook: Path = "seatrial.db"
    campaign: Union[int, str, None] = None


ModelSource = Union[Model, Identification, TrialResult, Campaign, Path]
"""A model, what was identified, a trial, a campaign, or the file of a document (JSON) or of a schedule (TOML)."""


def native_source(
    source: ModelSource,
    surge_speed_m_s: Optional[float] = None,
    rudder_limit_rad: Optional[float] = None,
) -> dict[str, Any]:
    """Models as the native part takes them."""
    found: dict[str, Any] = dict.fromkeys(
        ("theta", "document", "path", "logbook", "campaign"), None
    )
    found["surge_speed_m_s"], found["rudder_limit_rad"] = surge_speed_m_s, rudder_limit_rad
    if isinstance(source, Model):
        found["theta"] = list(source.theta)
    elif isinstance(source, (Identification, TrialResult)):
        name = "the trial" if isinstance(source, TrialResult) else "the identification"
        found["document"] = (name, json.dumps(source.document))
    elif isinstance(source, Campaign):
        found["logbook"] = fspath(source.logbook)
        found["campaign"] = None if source.campaign is None else str(source.campaign)
    else:
        found["path"] = fspath(source)
    return found


def tell(told: Iterable[str]) -> None:
    """Warns the caller of the function that calls this."""
    for text in told:
        warnings.warn(text, SeatrialWarning, stacklevel=3)
