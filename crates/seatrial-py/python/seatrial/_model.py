"""Models, what was identified, trials."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Iterable, Literal, Optional

from . import _html, _native
from ._columns import Array
from ._errors import RejectedError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

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


@dataclass(frozen=True, repr=False)
class Identification:
    """A model with its uncertainty, its validation and a verdict."""

    document: dict[str, Any]
    """All of it, as ``seatrial identify --json`` prints it."""

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
        model = self.model if self._has_model else "without a model"
        return f"<Identification {model}, {verdict}: {self.reasons[0][0]}>"

    @property
    def speeds(self) -> list[SpeedModel]:
        """The model of each speed of a log, slowest first; of one manoeuvre or of arrays the one model, where there is one."""
        found = self.document.get("models")
        if found is None:
            alone = {"identification": self.document, "verdict": self.document["verdict"]}
            found = [alone] if self._has_model else []
        return [SpeedModel._of(each) for each in found]

    @property
    def _has_model(self) -> bool:
        return any(self.document.get(part) for part in ("refined", "online", "batch"))

    def _repr_html_(self) -> str:
        rows = [
            (
                _html.number(speed.thrust), _html.number(speed.surge_speed_m_s),
                *(_html.bounds((speed.interval_95 or {}).get(name)) for name in ("a22_per_s", "b2_per_s2")),
                speed.outcome,
            )
            for speed in self.speeds
        ]
        head = ("thrust", "speed, m/s", "a22, 1/s", "b2, 1/s²", "outcome")
        models = _html.table(head, rows) if rows else ""
        return _html.verdict(self.outcome, self.reasons) + models

    def plot(self, ax: Optional[Axes] = None) -> Axes:
        """a22 and b2 with their 95 % intervals over speed."""
        from . import plot

        return plot.models(self.speeds, ax)


@dataclass(frozen=True)
class SpeedModel:
    """The model of one speed."""

    thrust: Optional[float]
    """Fraction of full."""
    surge_speed_m_s: Optional[float]
    model: Optional[Model]
    interval_95: Optional[dict[str, Any]]
    """95 % intervals [low, high] by parameter."""
    outcome: Outcome

    @classmethod
    def _of(cls, part: dict[str, Any]) -> SpeedModel:
        found = part["identification"]
        identification = Identification(found) if found else None
        has_model = identification is not None and identification._has_model
        return cls(
            part.get("thrust"),
            part.get("surge_speed_m_s"),
            identification.model if identification and has_model else None,
            identification.interval_95 if identification and has_model else None,
            part["verdict"]["outcome"].replace("_", " "),
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
