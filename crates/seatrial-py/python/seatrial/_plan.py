"""Plans of trials, and what to expect of them before anything moves."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Optional, Sequence

from . import _html, _native
from ._documents import hashed
from ._reading import ModelSource, Path, native_source, tell

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True)
class Plan:
    """A plan, and what it will do on the vehicle that is expected."""

    toml: str
    """The plan as ``seatrial trial --plan`` reads it."""
    will_do: bool
    """Does it stay within its envelope and tell enough at every speed, and is the target within reach?"""
    duration_s: float
    """From the first sample to the last, without repeats."""
    speeds: list[dict[str, Any]]
    """What to expect at each speed."""
    document: dict[str, Any]
    """All of it, as ``seatrial plan --json`` prints it."""

    __hash__ = hashed

    def _repr_html_(self) -> str:
        rows = []
        for speed in self.speeds:
            expected = (speed["expected"] or {}).get("relative_half_width_95") or [None, None]
            rows.append((
                _html.number(speed["thrust"]), _html.number(speed["surge_speed_m_s"]),
                *(_html.number(width) for width in expected[:2]),
                _html.number(speed["heading_excursion_rad"]),
            ))
        head = ("thrust", "speed, m/s", "a22, ± share", "b2, ± share", "heading excursion, rad")
        does = "will do" if self.will_do else "will not do"
        return f"<p><b>{does}</b>, {self.duration_s:.0f} s</p>" + _html.table(head, rows)

    def plot(self, ax: Optional[Axes] = None) -> Axes:
        """Half widths of the 95 % intervals to expect over thrust, percent."""
        from . import plot

        return plot.expected(self.speeds, ax)


def plan(
    file: Optional[Path] = None,
    *,
    thrusts: Sequence[float] = (),
    amplitude_rad: Optional[float] = None,
    validation_amplitude_rad: Optional[float] = None,
    period_s: Optional[float] = None,
    repeats: Optional[int] = None,
    time_constant_s: Optional[float] = None,
    sample_interval_s: Optional[float] = None,
    rudder_limit_rad: Optional[float] = None,
    rudder_delay_s: Optional[float] = None,
    rudder_lag_s: Optional[float] = None,
    stop_when: Optional[str] = None,
    target: Optional[str] = None,
    compare: bool = False,
    vehicle: Optional[str] = None,
    models: Optional[ModelSource] = None,
    surge_speed_m_s: Optional[float] = None,
    noise_rad: Optional[float] = None,
    disturbance: Optional[tuple[float, float]] = None,
    hold_gain: Optional[float] = None,
    heading_rad: Optional[float] = None,
) -> Plan:
    """A plan and its preview, as ``seatrial plan``.

    Parameters
    ----------
    file
        Begin with this plan instead of the paper's.
    thrusts
        Fractions of full.
    amplitude_rad, validation_amplitude_rad, period_s
        Of the doublets, rad and s.
    repeats
        Times a run below R^2 0.60 is repeated.
    time_constant_s
        Begin with the paper's plan in the time of a vehicle with this time constant, s.
    sample_interval_s, rudder_limit_rad, rudder_delay_s, rudder_lag_s
        Of the vehicle, s and rad.
    stop_when, target
        Widths such as ``"a22:10%,b2:5%"``: training ends as soon as they are reached; doublets that reach them are recommended.
    compare
        Compare doublet, 3-2-1-1 and a designed manoeuvre.
    vehicle, models, surge_speed_m_s
        What vehicle to expect: a simulated one, or models and the speed of a single one; ``sim:starfish`` without.
    noise_rad, disturbance, hold_gain, heading_rad
        Compass noise, rad; strength, rad/s^2, and time constant, s, of the disturbance; gain of the vehicle's heading
        controller; heading of the trial, rad.

    Returns
    -------
    Plan
        What to expect, and the plan as TOML.
    """
    asked = {
        "file": file, "time_constant_s": time_constant_s, "sample_interval_s": sample_interval_s,
        "thrusts": list(thrusts), "amplitude_rad": amplitude_rad,
        "validation_amplitude_rad": validation_amplitude_rad, "period_s": period_s,
        "rudder_limit_rad": rudder_limit_rad, "rudder_delay_s": rudder_delay_s,
        "rudder_lag_s": rudder_lag_s, "stop_when": stop_when, "repeats": repeats, "target": target,
        "compare": compare,
    }
    believed = {
        "vehicle": vehicle,
        "models": None if models is None else native_source(models, surge_speed_m_s, rudder_limit_rad),
        "noise_rad": noise_rad, "disturbance": disturbance, "hold_gain": hold_gain,
        "heading_rad": heading_rad,
    }
    (text, told), toml, will_do = _native.plan(asked, believed)
    tell(told)
    document = json.loads(text)
    preview = document["preview"]
    return Plan(toml, will_do, preview["duration_s"], preview["speeds"], document)
