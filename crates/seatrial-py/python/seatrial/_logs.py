"""What is in logs: samples, manoeuvres, methods compared, models validated, changes of the vehicle."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from os import fspath
from typing import TYPE_CHECKING, Any, Literal, Optional, Sequence

from . import _html, _native
from ._columns import Array
from ._documents import (
    Channel, ComparisonDocument, InspectionDocument, Intervals, Manoeuvre, ValidationDocument, hashed, reasons_of,
)
from ._model import Model, Outcome
from ._reading import ModelSource, Path, Reading, Span, native_source, tell

if TYPE_CHECKING:
    from matplotlib.axes import Axes


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


def read_log(path: Path, reading: Reading = Reading()) -> Log:
    """The samples of a log of any format that the command reads, as it reads them.

    Of a log with more than 500,000 samples the segment in which the rudder varies most is kept, and a warning says so.

    Parameters
    ----------
    path
        The log.
    reading
        Columns, units and servo, where they are not to be found or assumed.

    Returns
    -------
    Log
        Arrays by name, in SI units, with ``source``.
    """
    samples, source, told = _native.read_log(path, reading.native())
    tell(told)
    return Log(samples, json.loads(source))


def _outcome(document: dict[str, Any]) -> Outcome:
    outcome: Outcome = document["verdict"]["outcome"].replace("_", " ")
    return outcome


@dataclass(frozen=True)
class Inspection:
    """What is in a log, and can a model be identified from it?"""

    path: str
    usable: bool
    """Do rudder and heading both move?"""
    reasons: list[tuple[str, str]]
    """Why: a code and a text each."""
    rate_hz: Optional[float]
    gaps: int
    """Intervals longer than three medians."""
    channels: list[Channel]
    """Quantity, column, unit and whether that was stated or assumed."""
    manoeuvres: list[Manoeuvre]
    document: InspectionDocument
    """All of it, as ``seatrial inspect --json`` prints it."""
    reading: Reading = field(default_factory=Reading, repr=False, compare=False)
    """How the log was read."""

    __hash__ = hashed

    def _repr_html_(self) -> str:
        channels = [(c["quantity"], c["column"], c["unit"], c["unit_source"]) for c in self.channels]
        manoeuvres = [
            (m["kind"], f"{m['from_s']:.2f}", f"{m['to_s']:.2f}", _html.number(m["surge_speed_m_s"]))
            for m in self.manoeuvres
        ]
        return (
            _html.verdict("usable" if self.usable else "not usable", self.reasons)
            + _html.table(("quantity", "column", "unit", "unit is"), channels)
            + _html.table(("manoeuvre", "from, s", "to, s", "speed, m/s"), manoeuvres)
        )

    def plot(self, ax: Optional[Axes] = None) -> Axes:
        """Heading and rudder over time with the manoeuvres shaded; reads the log again."""
        from . import plot

        record = read_log(self.path, self.reading)
        rudder = record["rudder_of_full" if "rudder_of_full" in record else "rudder_rad"]
        ax = plot.record(record["time_s"], record["heading_rad"], rudder, ax)
        for found in self.manoeuvres:
            if found["kind"] != "steady":
                ax.axvspan(found["from_s"], found["to_s"], alpha=0.15)
        return ax


def inspect(path: Path, reading: Reading = Reading()) -> Inspection:
    """What is in a log: channels, rates, gaps, units and signs, manoeuvres; as ``seatrial inspect``.

    Parameters
    ----------
    path
        The log.
    reading
        Columns, units and servo, where they are not to be found or assumed.

    Returns
    -------
    Inspection
        Whether a model can be identified, and why not.
    """
    text, told = _native.inspect(path, reading.native())
    tell(told)
    document = json.loads(text)
    return Inspection(
        path=fspath(path),
        usable=bool(document["verdict"]["accepted"]),
        reasons=reasons_of(document),
        rate_hz=document["sampling"]["rate_hz"],
        gaps=document["sampling"]["gaps"],
        channels=document["source"]["channels"],
        manoeuvres=document["manoeuvres"],
        document=document,
        reading=reading,
    )


@dataclass(frozen=True)
class MethodResult:
    """What one method made of the record."""

    method: str
    model: Optional[Model]
    failure: Optional[str]
    """Why there is no model."""
    interval_95: Optional[Intervals]
    r2_heading: Optional[float]
    """On the validation data."""


@dataclass(frozen=True)
class Comparison:
    """Every method on the identical record."""

    methods: list[MethodResult]
    windows_because: str
    """Which data validate, and why these."""
    document: ComparisonDocument
    """All of it, as ``seatrial compare --json`` prints it."""

    __hash__ = hashed

    def _repr_html_(self) -> str:
        rows = [
            (
                m.method.replace("_", " "), _html.number(m.model and m.model.a22_per_s, 4),
                _html.number(m.model and m.model.b2_per_s2, 4), _html.number(m.r2_heading),
                m.failure or "",
            )
            for m in self.methods
        ]
        return _html.table(("method", "a22, 1/s", "b2, 1/s²", "R² of heading", "without a model"), rows)

    def plot(self, ax: Optional[Axes] = None) -> Axes:
        """a22 and b2 of every method, with 95 % intervals where there are any."""
        from . import plot

        return plot.methods(self.methods, ax)


def compare(
    path: Path,
    *,
    training: Span = (None, None),
    validation: Span = (None, None),
    validate_on: Optional[Path] = None,
    lambda_rad_s: Optional[float] = None,
    reading: Reading = Reading(),
) -> Comparison:
    """Every method on the identical record of a log, as ``seatrial compare``.

    Parameters
    ----------
    path
        The log.
    training, validation, validate_on
        As of `identify_log`; what follows the training window validates where nothing else is said.
    lambda_rad_s
        Pole of the state variable filter of every method but the paper's, rad/s; derived from the data where None.
    reading
        How the log is read.

    Returns
    -------
    Comparison
        A row for each method.
    """
    text, told = _native.compare(
        path, reading.native(), training, validation, validate_on, lambda_rad_s
    )
    tell(told)
    document = json.loads(text)
    methods = [
        MethodResult(
            method=row["method"],
            model=Model(*(row["model"][name] for name in _THETA)) if row["model"] else None,
            failure=row["failure"],
            interval_95=row["interval_95"],
            r2_heading=(row["validation"] or {}).get("r2_heading"),
        )
        for row in document["methods"]
    ]
    return Comparison(methods, document["windows_because"], document)


_THETA = ("a22_per_s", "b2_per_s2", "c0_rad_per_s2")


@dataclass(frozen=True)
class Validated:
    """A given model against a log."""

    model: Model
    outcome: Outcome
    reasons: list[tuple[str, str]]
    """Why: a code and a text each."""
    r2_heading: Optional[float]
    """R^2 of heading with the model's offset."""
    r2_heading_offset_refit: Optional[float]
    """R^2 of heading with the offset estimated again."""
    r2_yaw_rate: Optional[float]
    document: ValidationDocument
    """All of it, as ``seatrial validate --json`` prints it."""

    __hash__ = hashed

    @property
    def accepted(self) -> bool:
        """May the model be used?"""
        return bool(self.document["verdict"]["accepted"])

    def _repr_html_(self) -> str:
        r2 = (self.r2_heading, self.r2_heading_offset_refit, self.r2_yaw_rate)
        head = ("R² of heading", "offset refitted", "of yaw rate")
        return _html.verdict(self.outcome, self.reasons) + _html.table(head, [[_html.number(x) for x in r2]])

    def plot(self, ax: Optional[Axes] = None) -> Axes:
        """The three R^2 beside the 0.60 that a model needs."""
        from . import plot

        return plot.r2((self.r2_heading, self.r2_heading_offset_refit, self.r2_yaw_rate), ax)


def validate(
    path: Path, models: ModelSource, *, window: Span = (None, None), reading: Reading = Reading()
) -> Validated:
    """Simulate a model over a log and judge it, as ``seatrial validate``.

    Parameters
    ----------
    path
        The log.
    models
        A model, or a source of models; of several the one of the log's speed is taken.
    window
        (from, to), s of the log, half open.
    reading
        How the log is read.

    Returns
    -------
    Validated
        R^2 and the outcome.
    """
    text, told = _native.validate(path, native_source(models), reading.native(), window)
    tell(told)
    document = json.loads(text)
    found = document["validation"]
    return Validated(
        model=Model(*(document["model"][name] for name in _THETA)),
        outcome=_outcome(document),
        reasons=reasons_of(document),
        r2_heading=found["r2_heading"],
        r2_heading_offset_refit=found["r2_heading_offset_refit"],
        r2_yaw_rate=found["r2_yaw_rate"],
        document=document,
    )


Finding = Literal["unchanged", "changed", "cannot_tell"]


@dataclass(frozen=True)
class Health:
    """Has the vehicle changed?"""

    finding: Finding
    reasons: list[tuple[str, str]]
    """Why: a code and a text each."""
    effects: Optional[dict[str, Any]]
    """Changes of ``damping`` and ``rudder`` as shares of what they were, and ``offset_rad``, each with its 95 % interval."""
    document: dict[str, Any]
    """All of it, as ``seatrial health --json`` prints it."""

    __hash__ = hashed

    def _repr_html_(self) -> str:
        rows = [
            (name, f"{effect['change']:+.3g}", _html.bounds(effect["interval_95"]))
            for name, effect in (self.effects or {}).items()
            if effect
        ]
        return _html.verdict(self.finding.replace("_", " "), self.reasons) + _html.table(
            ("what", "change", "95 %"), rows
        )

    def plot(self, ax: Optional[Axes] = None) -> Axes:
        """The changes with their 95 % intervals."""
        from . import plot

        return plot.effects(self.effects or {}, ax)


def health(
    reference: str,
    now: str,
    *,
    logbook: Path = "seatrial.db",
    false_alarms: float = 0.05,
    tolerated: Optional[float] = None,
    offset_counts: Optional[bool] = None,
    reading: Reading = Reading(),
) -> Health:
    """Has the vehicle changed between two trials, runs or logs? As ``seatrial health REFERENCE NOW``.

    Parameters
    ----------
    reference, now
        ``"3"`` or ``"payload"`` for a campaign of the logbook, ``"3:2"`` for a run of it, a document, a schedule, or a log of
        one manoeuvre, ``"run.csv@40..56.5"`` for a part of it.
    logbook
        The logbook with the campaigns.
    false_alarms
        How often an unchanged vehicle may be called changed, a share of all answers.
    tolerated
        Changes of damping and rudder up to this share are none; 0 without.
    offset_counts
        Is an offset that moved a change? True without.
    reading
        How logs are read.

    Returns
    -------
    Health
        The finding, and the changes with their intervals.
    """
    told = _native.health(
        fspath(reference), fspath(now), [], logbook, reading.native(), false_alarms, tolerated,
        offset_counts,
    )
    return _health(*told)


def watch(
    reference: str,
    missions: Sequence[Path],
    *,
    logbook: Path = "seatrial.db",
    false_alarms: float = 0.05,
    tolerated: Optional[float] = None,
    offset_counts: Optional[bool] = None,
    reading: Reading = Reading(),
) -> Health:
    """Has the vehicle changed over ordinary missions? As ``seatrial health REFERENCE --watch LOG...``.

    Parameters
    ----------
    reference
        As of `health`.
    missions
        The logs since the trial, in order of time.
    logbook, false_alarms, reading
        As of `health`.
    tolerated
        0.05 without.
    offset_counts
        False without: wind, current and trim move it.

    Returns
    -------
    Health
        The finding over all windows in which the rudder worked.
    """
    told = _native.health(
        fspath(reference), None, [fspath(name) for name in missions], logbook, reading.native(),
        false_alarms, tolerated, offset_counts,
    )
    return _health(*told)


def _health(text: str, told: list[str]) -> Health:
    tell(told)
    document = json.loads(text)
    reasons = [(document["finding"], document["because"])]
    return Health(document["finding"], reasons, document["effects"], document)
