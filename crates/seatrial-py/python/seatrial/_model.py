"""Models, what was identified, trials."""

from __future__ import annotations

from dataclasses import dataclass, field
from importlib import import_module
from typing import TYPE_CHECKING, Any, Callable, Iterable, Literal, Mapping, Optional, cast

import numpy as np

from . import _html, _native
from ._columns import Array
from ._documents import (
    IdentificationDocument, Intervals, Parameters, SpeedIdentified, TrialDocument, Validation, Window,
    hashed, reasons_of,
)
from ._errors import RejectedError, UsageError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ._response import Motion

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

    def to_control(self, form: Literal["transfer function", "state space"] = "transfer function") -> Any:
        """As python-control has it: b2 / (s (s - a22)) from rudder to heading, or the states heading and yaw rate; without C0."""
        control: Any = import_module("control")
        names: dict[str, Any] = {"inputs": "rudder", "name": "vehicle"}
        if form == "transfer function":
            return control.tf([self.b2_per_s2], [1.0, -self.a22_per_s, 0.0], outputs="heading", **names)
        if form != "state space":
            raise UsageError(f"form={form!r}: expected 'transfer function' or 'state space'")
        states = ["heading", "yaw_rate"]
        return control.ss(
            [[0.0, 1.0], [0.0, self.a22_per_s]], [[0.0], [self.b2_per_s2]], np.eye(2), np.zeros((2, 1)),
            states=states, outputs=states, **names,
        )


_SAMPLED, _BAND = 200, (2.5, 97.5)
"""Models of which a band is made, and its percentiles."""


@dataclass(frozen=True, repr=False)
class Identification:
    """A model with its uncertainty, its validation and a verdict."""

    document: IdentificationDocument
    """All of it, as ``seatrial identify --json`` prints it."""
    record: Optional[Callable[[], Mapping[str, Array]]] = field(default=None, repr=False, compare=False)
    """Gives the samples of the validation data, or else of what was identified, by name, where they are known: a log is read again."""

    __hash__ = hashed

    @property
    def model(self) -> Model:
        """The model that goes to the controller: the refined one where there is one."""
        part = self.document["refined"] or self.document["online"] or self.document.get("batch")
        if part is None:
            raise RejectedError("; ".join(text for _, text in self.reasons))
        return _model(part)

    @property
    def online(self) -> Optional[Model]:
        """The estimate made sample by sample; None of a batch estimate."""
        part = self.document["online"]
        return None if part is None else _model(part)

    @property
    def interval_95(self) -> Optional[Intervals]:
        """95 % intervals [low, high] by parameter; None without refinement."""
        refined = self.document["refined"]
        return None if refined is None else refined["interval_95"]

    @property
    def covariance(self) -> Optional[Array]:
        """Of [a22, b2, C0] of ``model``, in their units; None without refinement."""
        refined = self.document["refined"]
        return None if refined is None else np.array(refined["covariance"])

    def samples(self, n: int, seed: Optional[int] = None) -> Array:
        """Draw models from the uncertainty of ``model``: n rows of a22, b2, C0, for ``Model(*row)``.

        Raises UsageError where there is no covariance to draw from.
        """
        covariance = self.covariance
        if covariance is None:
            raise UsageError("the estimate has no covariance to draw from; expected one with estimate='refined'")
        drawn: Array = np.random.default_rng(seed).multivariate_normal(self.model.theta, covariance, n)
        return drawn

    def predict(self) -> Motion:
        """What ``model`` makes of the rudder of its validation data, or of its training data where nothing validated."""
        from ._response import predict

        return predict(self.model, *self._window())

    def residuals(self) -> Array:
        """Measured less predicted heading of `predict`, rad."""
        from ._response import residuals

        return residuals(self.model, *self._window())

    def _window(self) -> tuple[Array, Array, Array]:
        """Time, heading and rudder of the validation data, or of the training data."""
        if self.record is None:
            raise UsageError("the samples are not known here; seatrial.predict and residuals take them")
        samples = self.record()
        validation = self.document["validation"]
        span: Optional[Window] = validation["window"] if validation else self.document.get("training")
        time_s = samples["time_s"]
        low, high = (None, None) if span is None else (span["from_s"], span["to_s"])
        inside = (time_s >= (-np.inf if low is None else low)) & (time_s < (np.inf if high is None else high))
        rudder = samples.get("rudder_rad")
        rudder = samples["rudder_of_full"] if rudder is None else rudder
        return time_s[inside], samples["heading_rad"][inside], rudder[inside]

    @property
    def validation(self) -> Optional[Validation]:
        """R^2 on validation data."""
        return self.document["validation"]

    @property
    def accepted(self) -> bool:
        """May the model be used?"""
        return bool(self.document["verdict"]["accepted"])

    @property
    def outcome(self) -> Outcome:
        """What may be done with the model: use, use with care, not validated or do not use."""
        return outcome_of(self.document["verdict"]["outcome"])

    @property
    def reasons(self) -> list[tuple[str, str]]:
        """Why: a code and a text each."""
        return reasons_of(self.document)

    @property
    def actions(self) -> list[str]:
        """What to do about the reasons, in their order, as far as anything is to be done."""
        told = (cast(Mapping[str, Any], reason).get("action") for reason in self.document["verdict"]["reasons"])
        return [action for action in told if action]

    def __repr__(self) -> str:
        verdict = self.outcome
        model = self.model if self._has_model else "without a model"
        return f"<Identification {model}, {verdict}: {self.reasons[0][0]}>"

    @property
    def speeds(self) -> list[SpeedModel]:
        """The model of each speed of a log, slowest first; of one manoeuvre or of arrays the one model, where there is one."""
        found = self.document.get("models")
        if found is None:
            alone = {"identification": self.document, "verdict": self.document["verdict"]}
            found = [cast(SpeedIdentified, alone)] if self._has_model else []
        return [SpeedModel._of(each) for each in found]

    @property
    def _has_model(self) -> bool:
        return any(self.document.get(part) for part in ("refined", "online", "batch"))

    def _repr_html_(self) -> str:
        rows = [
            (
                _html.number(speed.thrust), _html.number(speed.surge_speed_m_s),
                *(_html.bounds(bounds) for bounds in _of_both(speed.interval_95)),
                speed.outcome,
            )
            for speed in self.speeds
        ]
        head = ("thrust", "speed, m/s", "a22, 1/s", "b2, 1/s²", "outcome")
        models = _html.table(head, rows) if rows else ""
        return _html.verdict(self.outcome, self.reasons) + models

    def plot(self, ax: Optional[Axes] = None) -> Axes:
        """Measured heading against that of ``model`` with its 95 % band, over the data of `predict`; without samples, `plot_models`."""
        from . import plot

        if self.record is None or not self._has_model:
            return self.plot_models(ax)
        from ._response import fit

        best = np.array([self.model.theta])
        models = best if self.covariance is None else np.concatenate([best, self.samples(_SAMPLED, seed=1)])
        time_s, measured, found = fit(models, *self._window())
        band = np.percentile(found[1:], _BAND, axis=0) if len(models) > 1 else None
        return plot.fit(time_s, measured, found[0], band, ax)

    def plot_models(self, ax: Optional[Axes] = None) -> Axes:
        """a22 and b2 with their 95 % intervals over speed."""
        from . import plot

        return plot.models(self.speeds, ax)


def _of_both(intervals: Optional[Intervals]) -> tuple[Optional[list[float]], Optional[list[float]]]:
    return (None, None) if intervals is None else (intervals["a22_per_s"], intervals["b2_per_s2"])


def _model(part: Parameters) -> Model:
    return Model(part["a22_per_s"], part["b2_per_s2"], part["c0_rad_per_s2"])


def outcome_of(word: str) -> Outcome:
    """An outcome as Python says it."""
    return cast(Outcome, word.replace("_", " "))


@dataclass(frozen=True)
class SpeedModel:
    """The model of one speed."""

    thrust: Optional[float]
    """Fraction of full."""
    surge_speed_m_s: Optional[float]
    model: Optional[Model]
    interval_95: Optional[Intervals]
    """95 % intervals [low, high] by parameter."""
    outcome: Outcome

    @classmethod
    def _of(cls, part: SpeedIdentified) -> SpeedModel:
        found = part["identification"]
        identification = Identification(cast(IdentificationDocument, found)) if found else None
        has_model = identification is not None and identification._has_model
        return cls(
            part.get("thrust"),
            part.get("surge_speed_m_s"),
            identification.model if identification and has_model else None,
            identification.interval_95 if identification and has_model else None,
            outcome_of(part["verdict"]["outcome"]),
        )


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

    document: TrialDocument
    samples: dict[str, Array]

    __hash__ = hashed

    @property
    def identifications(self) -> list[Identification]:
        """The model of each run that has one."""
        runs = self.document["runs"]
        found = (run["identification"] for run in runs)
        return [Identification(cast(IdentificationDocument, each)) for each in found if each]

    def schedule(self) -> Schedule:
        """The accepted models over thrust."""
        accepted = [run for run in self.document["runs"] if run["verdict"]["accepted"]]
        return Schedule(
            (
                Point(
                    Identification(cast(IdentificationDocument, run["identification"])).model,
                    run["thrust"], run["surge_speed_m_s"],
                )
                for run in accepted
            ),
            by="thrust",
        )

    def _repr_html_(self) -> str:
        rows = [
            (
                _html.number(run["thrust"]), _html.number(run["surge_speed_m_s"]),
                run["verdict"]["outcome"].replace("_", " "),
            )
            for run in self.document["runs"]
        ]
        return _html.table(("thrust", "speed, m/s", "outcome"), rows)

    def plot(self, ax: Optional[Axes] = None) -> Axes:
        """Heading and rudder over time, deg and s."""
        from . import plot

        samples = self.samples
        return plot.record(samples["time_s"], samples["heading_rad"], samples["rudder_rad"], ax)
