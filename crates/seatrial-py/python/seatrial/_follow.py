"""What follows from a model: gains, turns, files for controllers and simulators."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, Optional

from . import _html, _native
from ._documents import Estimate, GainPoint, GainsDocument, TurningDocument, TurningPoint, hashed
from ._errors import UsageError
from ._model import Model
from ._reading import ModelSource, Path, native_source, tell

if TYPE_CHECKING:
    from matplotlib.axes import Axes


_HANDS = {"starboard": True, "right": True, "port": False, "left": False}


@dataclass(frozen=True)
class Turn:
    """A turn under full rudder, (40)-(50)."""

    yaw_rate_rad_s: float
    rudder_rad: float
    rise_time_s: float
    u_turn_time_s: float
    u_turn_mean_radius_m: Optional[float]
    steady_turning_radius_m: Optional[float]


def turning(
    model: Model,
    rudder_limit_rad: float,
    surge_speed_m_s: Optional[float] = None,
    hand: str = "starboard",
) -> Turn:
    """Turning limits of one model to one side.

    Parameters
    ----------
    model
        The model.
    rudder_limit_rad
        Full rudder, rad.
    surge_speed_m_s
        Forward speed, m/s; without, there are no radii.
    hand
        starboard or right, port or left, in any case.

    Returns
    -------
    Turn
        Rates in rad/s, times in s, radii in m.
    """
    starboard = _HANDS.get(hand.strip().lower())
    if starboard is None:
        raise UsageError(f"hand={hand!r}: expected 'starboard' or 'port', 'right' or 'left'")
    return Turn(*_native.turn(model.theta, rudder_limit_rad, starboard, surge_speed_m_s))


@dataclass(frozen=True)
class Gain:
    """The heading controller delta = K_p (psi_d - psi) - delta0."""

    proportional_gain: float
    """K_p, rad/rad."""
    feed_forward_rudder_rad: float
    """-delta0, rad."""


def gains(model: Model, damping_ratio: float = 0.5**0.5) -> Gain:
    """The gain of one model that gives the closed heading loop a damping ratio, with no allowance for delays.

    Parameters
    ----------
    model
        The model.
    damping_ratio
        1/sqrt(2), as that of `heading_gains`, is (57).

    Returns
    -------
    Gain
        K_p and the feed-forward rudder. `heading_gains` allows for delays and for the uncertainty of the model.
    """
    return Gain(*_native.gain(model.theta, damping_ratio))


def _estimate(found: Optional[Estimate]) -> str:
    return "-" if found is None else _html.number(found["value"])


@dataclass(frozen=True)
class HeadingGains:
    """Gains of the heading controller for every model, with margins."""

    points: list[GainPoint]
    """Of each model: its gain, what the gain allows for and the closed loop."""
    at: Optional[dict[str, Any]]
    """The gain at the speed or thrust that was asked for."""
    document: GainsDocument
    """All of it, as ``seatrial gains --json`` prints it."""

    __hash__ = hashed

    def _repr_html_(self) -> str:
        rows = [
            (
                _html.number(p["thrust"]), _html.number(p["surge_speed_m_s"]),
                _estimate(p["proportional_gain"]), _estimate(p["feed_forward_rudder_rad"]),
                p["refused"] or "",
            )
            for p in self.points
        ]
        return _html.table(("thrust", "speed, m/s", "K_p", "feed-forward, rad", "no gain"), rows)

    def plot(self, ax: Optional[Axes] = None) -> Axes:
        """K_p over speed, with 95 % intervals."""
        from . import plot

        return plot.estimates(self.points, "proportional_gain", "K_p, rudder per heading", ax)


def _asked(
    damping_ratio: float = 0.5**0.5,
    delay_s: Optional[float] = None,
    interval_s: Optional[float] = None,
    at_speed_m_s: Optional[float] = None,
    at_thrust: Optional[float] = None,
    extrapolate: bool = False,
    full_rudder_rad: Optional[float] = None,
) -> dict[str, Any]:
    return dict(locals())


def heading_gains(
    models: ModelSource,
    *,
    surge_speed_m_s: Optional[float] = None,
    rudder_limit_rad: Optional[float] = None,
    damping_ratio: float = 0.5**0.5,
    delay_s: Optional[float] = None,
    interval_s: Optional[float] = None,
    at_speed_m_s: Optional[float] = None,
    at_thrust: Optional[float] = None,
    extrapolate: bool = False,
) -> HeadingGains:
    """Gains of models of any source, allowing for delays and the uncertainty of the model, as ``seatrial gains``.

    Parameters
    ----------
    models
        Where they come from.
    surge_speed_m_s
        Forward speed of a single model, m/s.
    rudder_limit_rad
        Largest rudder angle, rad; the source's, else 0.26.
    damping_ratio
        Of the closed loop.
    delay_s, interval_s
        Dead time of the loop and interval of a sampled controller, s, 0 for a continuous one; what the record tells without.
    at_speed_m_s, at_thrust
        A place in the schedule for which the gain is interpolated.
    extrapolate
        Allow one outside the identified range.

    Returns
    -------
    HeadingGains
        A row for each model.
    """
    source = native_source(models, surge_speed_m_s, rudder_limit_rad)
    asked = _asked(damping_ratio, delay_s, interval_s, at_speed_m_s, at_thrust, extrapolate)
    text, told = _native.heading_gains(source, asked)
    tell(told)
    document = json.loads(text)
    return HeadingGains(document["points"], document["at"], document)


@dataclass(frozen=True)
class TurningLimits:
    """Turning limits of every model, to either side."""

    points: list[TurningPoint]
    """Of each model: ``hands``, its limits to starboard and to port."""
    document: TurningDocument
    """All of it, as ``seatrial turn --json`` prints it."""

    __hash__ = hashed

    def _repr_html_(self) -> str:
        rows = [
            (
                _html.number(p["surge_speed_m_s"]), side["hand"], _estimate(side["yaw_rate_rad_s"]),
                _estimate(side["u_turn_time_s"]), _estimate(side["steady_turning_radius_m"]),
                side["refused"] or "",
            )
            for p in self.points
            for side in p["hands"]
        ]
        head = ("speed, m/s", "side", "yaw rate, rad/s", "U-turn, s", "steady radius, m", "no turn")
        return _html.table(head, rows)

    def plot(self, ax: Optional[Axes] = None) -> Axes:
        """Steady radius over speed to either side, with 95 % intervals."""
        from . import plot

        for k, side in enumerate(("starboard", "port")):
            points = [{**p["hands"][k], "surge_speed_m_s": p["surge_speed_m_s"]} for p in self.points]
            ax = plot.estimates(points, "steady_turning_radius_m", f"steady radius to {side}, m", ax)
        assert ax is not None
        return ax


def turning_limits(
    models: ModelSource,
    *,
    surge_speed_m_s: Optional[float] = None,
    rudder_limit_rad: Optional[float] = None,
    heading_change_rad: float = 3.141592653589793,
    up_to_speed_m_s: Optional[float] = None,
    measured_u_turn: Optional[tuple[float, float]] = None,
) -> TurningLimits:
    """Turning limits of models of any source, as ``seatrial turn``.

    Parameters
    ----------
    models, surge_speed_m_s, rudder_limit_rad
        As of `heading_gains`.
    heading_change_rad
        Heading change whose time is wanted, rad.
    up_to_speed_m_s
        Look for the least radius up to this speed, m/s.
    measured_u_turn
        Speed before a U-turn under full rudder that was measured, m/s, and the radius of a circle through its track, m.

    Returns
    -------
    TurningLimits
        A row for each model.
    """
    source = native_source(models, surge_speed_m_s, rudder_limit_rad)
    text, told = _native.turning_limits(
        source, heading_change_rad, up_to_speed_m_s, measured_u_turn
    )
    tell(told)
    document = json.loads(text)
    return TurningLimits(document["points"], document)


GAINS_FORMS: tuple[str, ...] = tuple(_native.GAINS_FORMS)
"""What `export` takes of gains, such as ``ardupilot``."""
VEHICLE_FORMS: tuple[str, ...] = tuple(_native.VEHICLE_FORMS)
"""What `export` takes of the vehicle, such as ``gazebo``."""


def export(
    models: ModelSource,
    to: str,
    *,
    out: Optional[Path] = None,
    surge_speed_m_s: Optional[float] = None,
    rudder_limit_rad: Optional[float] = None,
    at_speed_m_s: Optional[float] = None,
    at_thrust: Optional[float] = None,
    extrapolate: bool = False,
    full_rudder_rad: Optional[float] = None,
    damping_ratio: float = 0.5**0.5,
    delay_s: Optional[float] = None,
    interval_s: Optional[float] = None,
    vehicle_type: Literal["surface", "underwater"] = "surface",
    rehearsal: bool = False,
    accept: bool = False,
    name: Optional[str] = None,
    lag_s: Optional[float] = None,
    dead_time_s: Optional[float] = None,
    rudder_rate_rad_s: Optional[float] = None,
    surge_time_constant_s: Optional[float] = None,
) -> str:
    """A file for a controller, as ``seatrial gains --export``, or for a simulator or planner, as ``seatrial export``.

    Parameters
    ----------
    models
        Where they come from.
    to
        Of gains one of `GAINS_FORMS`; of the vehicle one of `VEHICLE_FORMS`, where ``vehicle`` and ``vehicle-json`` are its file.
    out
        The file; without, nothing is written. ``fmu`` needs one.
    surge_speed_m_s, rudder_limit_rad, damping_ratio, delay_s, interval_s, at_speed_m_s, at_thrust, extrapolate
        As of `heading_gains`.
    full_rudder_rad
        Rudder at full steering, rad, where the models do not know it.
    vehicle_type
        Whose parameters ``ardupilot`` and ``px4`` are: Rover, or Sub and UUV.
    rehearsal
        Take gains of a rehearsal on a simulator, too.
    accept
        Take gains that are warned of, too: of models that are not to be used, or whose interval holds 0.
    name, lag_s, dead_time_s, rudder_rate_rad_s, surge_time_constant_s
        What is said of the vehicle besides its models.

    Returns
    -------
    str
        The text of the file; empty for ``fmu``, which is none.

    Raises
    ------
    RejectedError
        Gains that are warned of.
    UsageError
        A logbook, a log or what was read is in the place of ``out``.

    Warns
    -----
    SeatrialWarning
        What was assumed, and what is said against the models.
    """
    if to == "fmu" and out is None:
        raise UsageError("to='fmu' writes no text; expected out=FILE.fmu")
    source = native_source(models, surge_speed_m_s, rudder_limit_rad)
    if to in GAINS_FORMS:
        asked = _asked(
            damping_ratio, delay_s, interval_s, at_speed_m_s, at_thrust, extrapolate, full_rudder_rad
        )
        text, told = _native.export_gains(source, asked, to, vehicle_type, rehearsal, accept)
        file = text.encode()
    else:
        said = {
            "name": name, "full_rudder_rad": full_rudder_rad, "lag_s": lag_s, "delay_s": dead_time_s,
            "rate_limit_rad_s": rudder_rate_rad_s, "surge_time_constant_s": surge_time_constant_s,
        }
        file, told = _native.export_vehicle(source, said, to, at_thrust, accept)
    tell(told)
    if out is not None:
        read = [path for path in (source["path"], source["logbook"]) if path is not None]
        _native.save(out, file, read)
    return "" if to == "fmu" else file.decode()
