"""Charts with matplotlib: ``pip install seatrial[plot]``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Mapping, Optional, Sequence

import numpy as np
from numpy.typing import ArrayLike

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from . import Identification, MethodResult, Model, Point, SpeedModel
    from ._columns import Array


def record(time: ArrayLike, heading: ArrayLike, rudder: ArrayLike, ax: Optional[Axes] = None) -> Axes:
    """Heading and rudder over time, deg and s."""
    ax = ax or _axes()
    ax.plot(time, np.degrees(np.unwrap(np.asarray(heading, dtype=np.float64))), label="heading")
    ax.plot(time, np.degrees(rudder), drawstyle="steps-post", label="rudder")
    ax.set_xlabel("time, s")
    ax.set_ylabel("angle, deg")
    ax.legend()
    return ax


def fit(
    time_s: Array, measured_rad: Array, model_rad: Array, band_rad: Optional[Array] = None, ax: Optional[Axes] = None
) -> Axes:
    """Measured heading and that of a model over time, deg and s, with the band in which 95 % of the possible models lie."""
    ax = ax or _axes()
    ax.plot(time_s, np.degrees(measured_rad), ".", markersize=3.0, color="0.5", label="measured")
    [line] = ax.plot(time_s, np.degrees(model_rad), label="model")
    if band_rad is not None:
        low, high = np.degrees(band_rad)
        ax.fill_between(time_s, low, high, alpha=0.3, color=line.get_color(), label="95 %")
    ax.set_xlabel("time, s")
    ax.set_ylabel("heading, deg")
    ax.legend()
    return ax


def convergence(identification: Identification, ax: Optional[Axes] = None) -> Axes:
    """The estimates after every sample; of an identification with ``trace=True``."""
    ax = ax or _axes()
    online: Any = identification.document["online"]
    trace = online["trace"]
    time = [point["time_s"] for point in trace]
    for k, name in enumerate(["a22, 1/s", "b2, 1/s$^2$", "C0, rad/s$^2$"]):
        ax.plot(time, [point["theta"][k] for point in trace], label=name)
    ax.set_xlabel("time, s")
    ax.legend()
    return ax


def schedule(points: Sequence[Point], ax: Optional[Axes] = None) -> Axes:
    """a22 and b2 over speed."""
    ax = ax or _axes()
    speed: list[Any] = [point.surge_speed_m_s for point in points]
    ax.plot(speed, [point.model.a22_per_s for point in points], "o-", label="a22, 1/s")
    ax.plot(speed, [point.model.b2_per_s2 for point in points], "s-", label="b2, 1/s$^2$")
    ax.set_xlabel("forward speed, m/s")
    ax.legend()
    return ax


def step_response(model: Model, rudder_rad: float, duration_s: float, ax: Optional[Axes] = None) -> Axes:
    """Yaw rate after the rudder is laid over from straight ahead, deg/s."""
    ax = ax or _axes()
    time = np.linspace(0.0, duration_s, 200)
    steady = -(model.b2_per_s2 * rudder_rad + model.c0_rad_per_s2) / model.a22_per_s
    ax.plot(time, np.degrees(steady * -np.expm1(model.a22_per_s * time)))
    ax.set_xlabel("time, s")
    ax.set_ylabel("yaw rate, deg/s")
    return ax


def models(speeds: Sequence[SpeedModel], ax: Optional[Axes] = None) -> Axes:
    """a22 and b2 with their 95 % intervals over speed."""
    ax = ax or _axes()
    known = [speed for speed in speeds if speed.model is not None]
    x = [k if s.surge_speed_m_s is None else s.surge_speed_m_s for k, s in enumerate(known)]
    for name, label in [("a22_per_s", "a22, 1/s"), ("b2_per_s2", "b2, 1/s$^2$")]:
        values = [getattr(speed.model, name) for speed in known]
        _bars(ax, x, values, [_bounds(speed.interval_95, name) for speed in known], label)
    ax.set_xlabel("forward speed, m/s")
    ax.legend()
    return ax


def methods(found: Sequence[MethodResult], ax: Optional[Axes] = None) -> Axes:
    """a22 and b2 of every method that has a model."""
    ax = ax or _axes()
    known = [each for each in found if each.model is not None]
    for k, (name, label) in enumerate([("a22_per_s", "a22, 1/s"), ("b2_per_s2", "b2, 1/s$^2$")]):
        x = [place + 0.2 * k for place in range(len(known))]
        intervals = [_bounds(each.interval_95, name) for each in known]
        _bars(ax, x, [getattr(each.model, name) for each in known], intervals, label)
    ax.set_xticks(range(len(known)), [each.method.replace("_", " ") for each in known], rotation=60, ha="right")
    ax.legend()
    return ax


def estimates(points: Sequence[Mapping[str, Any]], name: str, label: str, ax: Optional[Axes] = None) -> Axes:
    """An estimate of every model over speed, with 95 % intervals."""
    ax = ax or _axes()
    known = [point for point in points if point[name] is not None]
    x = [k if p["surge_speed_m_s"] is None else p["surge_speed_m_s"] for k, p in enumerate(known)]
    intervals = [point[name]["interval_95"] for point in known]
    _bars(ax, x, [point[name]["value"] for point in known], intervals, label)
    ax.set_xlabel("forward speed, m/s")
    ax.legend()
    return ax


def expected(speeds: Sequence[Mapping[str, Any]], ax: Optional[Axes] = None) -> Axes:
    """Half widths of the 95 % intervals to expect over thrust, percent."""
    ax = ax or _axes()
    known = [speed for speed in speeds if speed["expected"] is not None]
    for k, label in enumerate(["a22", "b2"]):
        widths = [speed["expected"]["relative_half_width_95"][k] for speed in known]
        ax.plot([speed["thrust"] for speed in known], [100.0 * (w or np.nan) for w in widths], "o-", label=label)
    ax.set_xlabel("thrust, fraction of full")
    ax.set_ylabel("95 % half width, %")
    ax.legend()
    return ax


def r2(values: Sequence[Optional[float]], ax: Optional[Axes] = None) -> Axes:
    """R^2 of heading, of heading with the offset estimated again and of yaw rate, and what a model needs."""
    ax = ax or _axes()
    ax.bar(["heading", "offset refitted", "yaw rate"], [np.nan if value is None else value for value in values])
    ax.axhline(0.6, color="black", linewidth=1.0)
    ax.set_ylabel("R$^2$")
    return ax


def effects(found: Mapping[str, Optional[Mapping[str, Any]]], ax: Optional[Axes] = None) -> Axes:
    """Changes of damping and rudder with their 95 % intervals, percent."""
    ax = ax or _axes()
    known = {name: found[name] for name in ("rudder", "damping") if found.get(name)}
    changes = [100.0 * effect["change"] for effect in known.values() if effect]
    intervals = [[100.0 * bound for bound in effect["interval_95"]] for effect in known.values() if effect]
    _bars(ax, range(len(known)), changes, intervals, "change")
    ax.axhline(0.0, color="black", linewidth=1.0)
    ax.set_xticks(range(len(known)), list(known))
    ax.set_ylabel("change, %")
    return ax


def _bounds(intervals: Optional[Mapping[str, Any]], name: str) -> Optional[list[float]]:
    return None if intervals is None else intervals.get(name)


def _bars(
    ax: Axes, x: Sequence[float], values: Sequence[float], intervals: Sequence[Optional[Sequence[float]]], label: str
) -> None:
    """Values with their intervals, where they have one."""
    below = [0.0 if i is None else max(value - i[0], 0.0) for value, i in zip(values, intervals)]
    above = [0.0 if i is None else max(i[1] - value, 0.0) for value, i in zip(values, intervals)]
    ax.errorbar(x, values, yerr=[below, above], fmt="o", capsize=4.0, label=label)


def _axes() -> Axes:
    from matplotlib import pyplot

    return pyplot.figure().add_subplot()
