"""Identify how a marine vehicle steers, at sea, in one compact manoeuvre per speed.

    psi' = r,   r' = a22 r + b2 delta + C0

Angles are radians, everything else SI. The numbers are those of the command ``seatrial``, bit for bit.
"""

from __future__ import annotations

import json
import math
from array import array as numbers
from dataclasses import dataclass
from os import PathLike
from typing import Any, Iterable, Literal, Optional, Sequence

import numpy as np
from numpy.typing import ArrayLike

from . import _native
from ._columns import Array, array, columns, optional, seconds
from ._degrees import refuse_degrees
from ._errors import (
    AbortedError,
    InputError,
    NotSavedError,
    RejectedError,
    SeatrialError,
    UsageError,
)
from ._fleet import fleet

__all__ = [
    "AbortedError", "Estimator", "Gain", "Identification", "InputError", "Log", "Model", "NotSavedError",
    "Point", "RejectedError", "Schedule", "SeatrialError", "TrialResult", "Turn", "UsageError",
    "fleet", "gains", "identify", "identify_log", "identify_table", "paper_claims",
    "read_log", "study", "trial", "turning",
]

Span = tuple[Optional[float], Optional[float]]
Estimate = Literal["refined", "online", "batch", "paper"]
Method = Literal["least_squares", "instrumental_variable"]
Outcome = Literal["use", "use with care", "not validated", "do not use"]


@dataclass(frozen=True)
class Model:
    """The yaw model r' = a22 r + b2 delta + C0."""

    a22_per_s: float
    """Rotational damping, 1/s; negative for a course-stable vehicle."""
    b2_per_s2: float
    """Rudder authority, 1/s^2; positive where positive rudder turns towards increasing heading."""
    c0_rad_per_s2: float = 0.0
    """Yaw acceleration at neutral rudder, rad/s^2."""

    @property
    def theta(self) -> tuple[float, float, float]:
        """[a22, b2, C0]."""
        return (self.a22_per_s, self.b2_per_s2, self.c0_rad_per_s2)

    @property
    def nomoto_t_s(self) -> float:
        """Nomoto's time constant T = -1/a22, s."""
        return -1.0 / self.a22_per_s

    @property
    def nomoto_k_per_s(self) -> float:
        """Nomoto's gain K = -b2/a22, 1/s."""
        return -self.b2_per_s2 / self.a22_per_s


class Identification:
    """A model with its uncertainty, its validation and a verdict. ``document`` is all of it, as ``identify --json``."""

    def __init__(self, document: dict[str, Any]) -> None:
        self.document = document

    @property
    def model(self) -> Model:
        """The model that goes to the controller: the refined one where there is one."""
        part = self.document["refined"] or self.document["online"] or self.document.get("batch")
        if part is None:
            raise RejectedError("; ".join(text for _, text in self.reasons))
        return Model(part["a22_per_s"], part["b2_per_s2"], part["c0_rad_per_s2"])

    @property
    def online(self) -> Optional[Model]:
        """The estimate made sample by sample; None of a batch estimate."""
        part = self.document["online"]
        return None if part is None else Model(part["a22_per_s"], part["b2_per_s2"], part["c0_rad_per_s2"])

    @property
    def interval_95(self) -> Optional[dict[str, Any]]:
        """95 % intervals [low, high] by parameter; None without refinement."""
        refined = self.document["refined"]
        return None if refined is None else dict(refined["interval_95"])

    @property
    def validation(self) -> Optional[dict[str, Any]]:
        """R^2 on validation data."""
        found = self.document["validation"]
        return None if found is None else dict(found)

    @property
    def accepted(self) -> bool:
        """May the model be used?"""
        return bool(self.document["verdict"]["accepted"])

    @property
    def outcome(self) -> Outcome:
        """What may be done with the model: use, use with care, not validated or do not use."""
        outcome: Outcome = self.document["verdict"]["outcome"].replace("_", " ")
        return outcome

    @property
    def reasons(self) -> list[tuple[str, str]]:
        """Why: a code and a text each."""
        return [(reason["code"], reason["text"]) for reason in self.document["verdict"]["reasons"]]

    @property
    def actions(self) -> list[str]:
        """What to do about the reasons, in their order, as far as anything is to be done."""
        told = (reason.get("action", "") for reason in self.document["verdict"]["reasons"])
        return [action for action in told if action]

    def __repr__(self) -> str:
        verdict = self.outcome
        has_model = any(self.document.get(part) for part in ("refined", "online", "batch"))
        model = self.model if has_model else "without a model"
        return f"<Identification {model}, {verdict}: {self.reasons[0][0]}>"


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
) -> Identification:
    """Identify the yaw model of a record.

    time: s, increasing, or dates or durations of NumPy. heading: rad, wrapped or not. rudder: rad, each angle acting from its time on. speed: m/s.
    yaw_rate: rad/s. thrust: fraction of full. training, validation: windows (from, to), s, half open; None is the
    record's end. estimate: ``refined`` with intervals, ``online`` as on the vehicle, ``paper`` to the letter; ``batch``
    is the paper's filters and least squares, (16)-(34), in one pass over evenly sampled arrays, for records of a million
    samples: a damaged sample is an error, and nothing is judged.
    lambda_rad_s: pole of the state variable filter, derived from the data where None. Float64 arrays are
    read where they lie. Raises RejectedError where nothing can be estimated; look at ``accepted`` elsewhere. Raises
    UsageError for arrays that are no columns of numbers and for a rudder in degrees.
    """
    time_s, psi, delta = seconds(time), array(heading, "heading"), array(rudder, "rudder")
    refuse_degrees(psi, delta)
    if estimate == "batch":
        if validation is not None or method not in (None, "least_squares") or trace:
            raise UsageError("estimate='batch' takes no validation, instrument or trace")
        return _batch(time_s, psi, delta, training, lambda_rad_s)
    text = _native.identify(
        time_s, psi, delta, optional(speed, "speed"), optional(yaw_rate, "yaw_rate"),
        optional(thrust, "thrust"), training, validation, estimate, method, lambda_rad_s, trace,
    )
    return Identification(json.loads(text))


def identify_log(
    path: str | PathLike[str],
    *,
    channels_file: str | PathLike[str] | None = None,
    columns: Optional[dict[str, str]] = None,
    units: Optional[dict[str, str]] = None,
    full_rudder_rad: Optional[float] = None,
    rudder_delay_s: float = 0.0,
    rudder_lag_s: float = 0.0,
    drop_invalid: bool = False,
    training: Span = (None, None),
    validation: Span = (None, None),
    validate_on: str | PathLike[str] | None = None,
    estimate: Literal["refined", "online", "paper"] = "refined",
    method: Optional[Method] = None,
    lambda_rad_s: Optional[float] = None,
    trace: bool = False,
) -> Identification:
    """Identify a log of any format; ``document`` is what ``seatrial identify LOG --json`` prints,
    to the bit; only what to do is said with the arguments of this function.

    Without windows the manoeuvres of the log are looked for: for each speed the best excited one trains, joined with
    others, and another one validates; ``document["models"]`` has the model of each speed, ``model`` is the surest.
    columns, units: by quantity, as in ``{"heading": "yaw"}`` and ``{"heading": "deg"}``. full_rudder_rad: the angle of a
    full rudder, where the log has pulses or fractions; without, the rudder of the models is a fraction of full.
    Where nothing can be estimated ``document["verdict"]`` says why, and ``model`` raises RejectedError.
    """
    text = _native.identify_log(
        path, channels_file, columns or {}, units or {}, full_rudder_rad, rudder_delay_s,
        rudder_lag_s, drop_invalid, training, validation, validate_on, estimate, method,
        lambda_rad_s, trace,
    )
    return Identification(json.loads(text))


class Log(dict[str, Array]):
    """The samples of a log as arrays by their names, and how they were read.

    The rudder is ``rudder_rad``, or ``rudder_of_full`` where the log has what a servo was told and nobody said which angle
    that is. ``source`` is what ``seatrial identify LOG --json`` prints of the log.
    """

    def __init__(self, samples: dict[str, Array], source: dict[str, Any]) -> None:
        super().__init__(samples)
        self.source = source

    @property
    def rudder_unit(self) -> Literal["rad", "full_rudder"]:
        """In what the rudder is: radians, or fractions of full rudder."""
        unit: Literal["rad", "full_rudder"] = self.source["rudder_unit"]
        return unit

    @property
    def assumptions(self) -> dict[str, str]:
        """Why a unit was assumed, by quantity, where the log does not say it."""
        channels = self.source["channels"]
        return {
            channel["quantity"]: f"{channel['column']} in {channel['unit']}: {channel['because'] or 'by its values'}"
            for channel in channels
            if channel["unit_source"] == "assumed"
        }

    @property
    def warnings(self) -> list[str]:
        """What has to be known before the samples are trusted."""
        return list(self.source["warnings"])


def read_log(path: str | PathLike[str]) -> Log:
    """The samples of a log of any format that the command reads, as it reads them.

    Of a log with more than 500,000 samples the segment in which the rudder varies most is kept, and a warning says so.
    """
    samples, source = _native.read_log(path)
    return Log(samples, json.loads(source))


def _batch(
    time: Array, heading: Array, rudder: Array, training: Span, lambda_rad_s: Optional[float]
) -> Identification:
    t, psi, delta = (np.ascontiguousarray(column) for column in (time, heading, rudder))
    batch = json.loads(_native.least_squares(t, psi, delta, training, lambda_rad_s))
    why = "batch least squares has no interval and nothing was validated"
    verdict = {
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
    """Identify from the columns of a pandas, polars or Arrow table (SI units); ``settings`` are those of identify."""
    names = dict(
        time=time, heading=heading, rudder=rudder, speed=speed, yaw_rate=yaw_rate, thrust=thrust
    )
    return identify(**columns(table, names), **settings)


class Estimator:
    """The estimator that runs on the vehicle, one sample at a time.

    Give it the settling data with ``warm``, the training data with ``update``, and call ``excitation_ended`` when the
    doublet is over; ``restart`` before the next speed. Times are s, angles rad. It can be copied and pickled; for that it
    keeps what it was given, 32 bytes a sample.
    """

    _WARM, _UPDATE, _ENDED, _RESTART = range(4)

    def __init__(
        self,
        lambda_rad_s: Optional[float] = None,
        method: Optional[Method] = None,
        as_paper: bool = False,
    ) -> None:
        self._settings = (lambda_rad_s, method, as_paper)
        self._native = _native.Estimator(lambda_rad_s, method, as_paper)
        self._given = numbers("d")

    def __getstate__(self) -> tuple[Any, ...]:
        return (self._settings, self._given.tobytes())

    def __setstate__(self, state: tuple[Any, ...]) -> None:
        self._settings, given = state
        self._native = _native.Estimator(*self._settings)
        self._given = numbers("d", given)
        for k in range(0, len(self._given), 4):
            what, *sample = self._given[k : k + 4]
            if what == self._WARM:
                self._native.warm(*sample)
            elif what == self._UPDATE:
                self._native.update(*sample)
            elif what == self._ENDED:
                self._native.excitation_ended()
            else:
                self._native.restart()

    def warm(self, time_s: float, heading_rad: float, rudder_rad: float) -> str:
        """Take in a sample of the settling phase: 'warming' or 'rejected'."""
        self._given.extend((self._WARM, time_s, heading_rad, rudder_rad))
        return self._native.warm(time_s, heading_rad, rudder_rad)

    def update(self, time_s: float, heading_rad: float, rudder_rad: float) -> str:
        """Take in a sample of the training phase: 'used', 'warming' or 'rejected'."""
        self._given.extend((self._UPDATE, time_s, heading_rad, rudder_rad))
        return self._native.update(time_s, heading_rad, rudder_rad)

    def excitation_ended(self) -> None:
        """The doublet is over: convergence counts from now on and the instrument takes over."""
        self._given.extend((self._ENDED, 0.0, 0.0, 0.0))
        self._native.excitation_ended()

    def restart(self) -> None:
        """Forget the estimate for the next speed; filters and guard run on."""
        self._given.extend((self._RESTART, 0.0, 0.0, 0.0))
        self._native.restart()

    @property
    def model(self) -> Model:
        """The estimate."""
        return Model(*self._native.model)

    @property
    def least_squares_model(self) -> Model:
        """The estimate of plain least squares, which runs on beside the instrument."""
        return Model(*self._native.least_squares_model)

    @property
    def covariance(self) -> Array:
        """P of plain least squares, before scaling by any noise."""
        return np.array(self._native.covariance)

    @property
    def step_norm(self) -> float:
        """|Theta(t_k) - Theta(t_k-1)| (39)."""
        return self._native.step_norm

    @property
    def converged_s(self) -> Optional[float]:
        """Seconds from the first training sample to the detection of convergence."""
        return self._native.converged_s


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
    """Turning limits of a model: rates in rad/s, times in s, radii in m where the speed is given.

    hand: starboard or right, port or left, in any case.
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


def gains(model: Model, damping_ratio: float = 1.0) -> Gain:
    """The gain that gives the closed heading loop this damping ratio; 1/sqrt(2) is (57)."""
    return Gain(*_native.gain(model.theta, damping_ratio))


@dataclass(frozen=True)
class Point:
    """A model and its place in a schedule."""

    model: Model
    thrust: Optional[float] = None
    """Fraction of full."""
    surge_speed_m_s: Optional[float] = None
    extrapolated: bool = False


class Schedule:
    """Models over speed or thrust: b2 linear in speed squared between the points, the rest linear."""

    def __init__(self, points: Iterable[Point], by: Literal["speed", "thrust"] = "speed") -> None:
        known = [(p.thrust, p.surge_speed_m_s, p.model.theta) for p in points]
        self._native = _native.Schedule(known, by == "speed")

    def at(self, key: float, extrapolate: bool = False) -> Point:
        """The model at a speed, m/s, or thrust, fraction of full."""
        (thrust, speed, theta), beyond = self._native.lookup(key, extrapolate)
        return Point(Model(*theta), thrust, speed, beyond)


@dataclass(frozen=True)
class TrialResult:
    """A trial: its runs with their models, and every sample by the name of its column."""

    document: dict[str, Any]
    samples: dict[str, Array]

    @property
    def identifications(self) -> list[Identification]:
        """The model of each run that has one."""
        runs = self.document["runs"]
        return [Identification(r["identification"]) for r in runs if r["identification"]]

    def schedule(self) -> Schedule:
        """The accepted models over thrust."""
        accepted = [run for run in self.document["runs"] if run["verdict"]["accepted"]]
        return Schedule(
            (
                Point(Identification(r["identification"]).model, r["thrust"], r["surge_speed_m_s"])
                for r in accepted
            ),
            by="thrust",
        )


def trial(
    vehicle: str = "sim:starfish", thrusts: Optional[Sequence[float]] = None, seed: int = 1
) -> TrialResult:
    """Run a whole sea trial, by the paper's plan, on a simulated vehicle.

    vehicle: sim:starfish, sim:starfish-6dof, sim:remus100 or sim:FILE.toml. thrusts: fractions of full. Raises
    AbortedError where the trial was aborted.
    """
    text, samples = _native.trial(vehicle, None if thrusts is None else list(thrusts), seed)
    document = json.loads(text)
    outcome = document["outcome"]
    if outcome and outcome["state"] == "aborted":
        raise AbortedError(f"{vehicle}: the trial was aborted: {outcome['reason']}")
    return TrialResult(document, samples)


def study(
    runs: int = 100,
    *,
    thrust: float = 0.8,
    seed: int = 1,
    compass_noise_rad: float = math.radians(0.5),
    disturbance_rad_s2: float = 0.0,
    disturbance_time_s: float = 1.0,
    estimators: Sequence[str] = ("refined", "instrumental-variable"),
    workers: Optional[int] = None,
) -> list[dict[str, Any]]:
    """How far estimators are from the truth and from the Cramer-Rao bound, on simulated runs of the paper's vehicle."""
    text = _native.study(
        runs, thrust, seed, compass_noise_rad, disturbance_rad_s2, disturbance_time_s,
        list(estimators), workers,
    )
    accuracy: list[dict[str, Any]] = json.loads(text)
    return accuracy


def paper_claims() -> list[dict[str, Any]]:
    """Every number that the paper prints and that follows from others, beside the recomputed one."""
    claims: list[dict[str, Any]] = json.loads(_native.paper_claims())
    return claims
