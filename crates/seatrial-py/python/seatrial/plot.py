"""Charts with matplotlib: ``pip install seatrial[plot]``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Optional, Sequence

import numpy as np
from numpy.typing import ArrayLike

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from . import Identification, Model, Point


def record(time: ArrayLike, heading: ArrayLike, rudder: ArrayLike, ax: Optional[Axes] = None) -> Axes:
    """Heading and rudder over time, deg and s."""
    ax = ax or _axes()
    ax.plot(time, np.degrees(np.unwrap(np.asarray(heading, dtype=np.float64))), label="heading")
    ax.plot(time, np.degrees(rudder), drawstyle="steps-post", label="rudder")
    ax.set_xlabel("time, s")
    ax.set_ylabel("angle, deg")
    ax.legend()
    return ax


def convergence(identification: Identification, ax: Optional[Axes] = None) -> Axes:
    """The estimates after every sample; of an identification with ``trace=True``."""
    ax = ax or _axes()
    trace = identification.document["online"]["trace"]
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


def _axes() -> Axes:
    from matplotlib import pyplot

    return pyplot.figure().add_subplot()
