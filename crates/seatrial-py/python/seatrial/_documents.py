"""Types of the documents: what ``--json`` of the command prints, by its keys. A key that is not named here may be there, too."""

from __future__ import annotations

import json
from typing import Any, Literal, Mapping, Optional, TypedDict

Word = Literal["use", "use_with_care", "not_validated", "do_not_use"]


class Reason(TypedDict):
    """Why a verdict is what it is, and what to do."""

    code: str
    text: str


class Verdict(TypedDict):
    """May the model be used?"""

    accepted: bool
    outcome: Word
    reasons: list[Reason]


def reasons_of(document: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Each reason of the verdict: its code, as ``low_r2`` or ``constant of rudder``, and its text."""

    def kind(reason: Mapping[str, Any]) -> str:
        return f"{reason['code']} of {reason['of']}" if "of" in reason else str(reason["code"])

    return [(kind(reason), reason["text"]) for reason in document["verdict"]["reasons"]]


class Window(TypedDict):
    """A part of a record, s, half open."""

    from_s: Optional[float]
    to_s: Optional[float]


class Channel(TypedDict):
    """Which column is which quantity."""

    quantity: str
    column: str
    unit: str
    unit_source: str
    because: Optional[str]


class Source(TypedDict):
    """The log and how it was read."""

    path: str
    sha256: str
    samples_read: int
    median_interval_s: Optional[float]
    rudder_unit: Literal["rad", "full_rudder"]
    format: str
    channels: list[Channel]
    warnings: list[str]


class Parameters(TypedDict):
    """The model r' = a22 r + b2 delta + C0."""

    a22_per_s: float
    b2_per_s2: float
    c0_rad_per_s2: float


class Online(Parameters):
    """The estimate made sample by sample."""

    method: str
    covariance: list[list[float]]


class Intervals(TypedDict):
    """95 % intervals [low, high]."""

    a22_per_s: list[float]
    b2_per_s2: list[float]
    c0_rad_per_s2: list[float]


class Refined(Parameters):
    """The estimate of the whole record, with intervals."""

    method: str
    interval_95: Intervals
    covariance: list[list[float]]


class Fit(TypedDict):
    """R^2 on validation data."""

    r2_heading: Optional[float]
    r2_heading_offset_refit: Optional[float]
    r2_yaw_rate: Optional[float]


class Validation(Fit):
    """R^2 on validation data, and which data these are."""

    window: Window
    samples: int


class ValidRange(TypedDict):
    """What the model was seen to hold for."""

    rudder: list[float]
    heading_amplitude_rad: float
    surge_speed_m_s: Optional[list[float]]


class Identified(TypedDict):
    """One manoeuvre, identified."""

    training: Window
    samples_used: int
    online: Optional[Online]
    refined: Optional[Refined]
    validation: Optional[Validation]
    valid_range: Optional[ValidRange]
    verdict: Verdict


class SpeedIdentified(TypedDict):
    """The model of one speed of a log."""

    thrust: Optional[float]
    surge_speed_m_s: Optional[float]
    identification: Optional[Identified]
    verdict: Verdict


class IdentificationDocument(TypedDict, total=False):
    """``seatrial identify --json``. Of arrays there is no source; ``models`` are those of a log in which manoeuvres were looked for."""

    schema: str
    source: Source
    validation_source: Optional[Source]
    training: Window
    samples_used: int
    online: Optional[Online]
    refined: Optional[Refined]
    batch: Optional[Parameters]
    validation: Optional[Validation]
    valid_range: Optional[ValidRange]
    verdict: Verdict
    models: Optional[list[SpeedIdentified]]


class Sampling(TypedDict):
    """How densely a log is sampled."""

    samples: int
    span: Window
    median_interval_s: Optional[float]
    rate_hz: Optional[float]
    gaps: int


class Range(TypedDict):
    """What the values of a quantity are."""

    quantity: str
    samples: int
    lowest: Optional[float]
    highest: Optional[float]
    mean: Optional[float]
    standard_deviation: Optional[float]


class Manoeuvre(TypedDict):
    """A manoeuvre of the rudder that was found in a log."""

    kind: str
    from_s: float
    to_s: float
    strokes: int
    amplitude_rad: float
    thrust: Optional[float]
    surge_speed_m_s: Optional[float]


class InspectionDocument(TypedDict):
    """``seatrial inspect --json``."""

    schema: str
    source: Source
    sampling: Sampling
    ranges: list[Range]
    manoeuvres: list[Manoeuvre]
    verdict: Verdict


class Method(TypedDict):
    """What one method made of a record."""

    method: str
    model: Optional[Parameters]
    failure: Optional[str]
    interval_95: Optional[Intervals]
    validation: Optional[Fit]


class ComparisonDocument(TypedDict):
    """``seatrial compare --json``."""

    schema: str
    source: Source
    windows_because: str
    methods: list[Method]


class ValidationDocument(TypedDict):
    """``seatrial validate --json``."""

    schema: str
    source: Source
    model: Parameters
    validation: Fit
    verdict: Verdict


class Estimate(TypedDict):
    """A value with its 95 % interval, where there is one."""

    value: float
    interval_95: Optional[list[float]]


class GainPoint(TypedDict):
    """The gain of one model."""

    thrust: Optional[float]
    surge_speed_m_s: Optional[float]
    proportional_gain: Optional[Estimate]
    feed_forward_rudder_rad: Optional[Estimate]
    refused: Optional[str]


class GainsDocument(TypedDict):
    """``seatrial gains --json``."""

    schema: str
    points: list[GainPoint]
    at: Optional[dict[str, Any]]


class Side(TypedDict):
    """Turning limits to one side."""

    hand: Literal["starboard", "port"]
    yaw_rate_rad_s: Optional[Estimate]
    u_turn_time_s: Optional[Estimate]
    steady_turning_radius_m: Optional[Estimate]
    refused: Optional[str]


class TurningPoint(TypedDict):
    """Turning limits of one model."""

    surge_speed_m_s: Optional[float]
    hands: list[Side]


class TurningDocument(TypedDict):
    """``seatrial turn --json``."""

    schema: str
    points: list[TurningPoint]


class Run(TypedDict):
    """A run of a trial."""

    thrust: float
    surge_speed_m_s: Optional[float]
    identification: Optional[Identified]
    verdict: Verdict


class TrialDocument(TypedDict):
    """A trial on a simulated vehicle, with its runs."""

    runs: list[Run]
    outcome: Optional[dict[str, Any]]


def hashed(result: Any) -> int:
    """The hash of a result: equal documents have equal ones."""
    document: Mapping[str, Any] = result.document
    return hash(json.dumps(document, sort_keys=True))
