"""Identify how a marine vehicle steers, at sea, in one compact manoeuvre per speed.

    psi' = r,   r' = a22 r + b2 delta + C0

Angles are radians, everything else SI. The numbers are those of the command ``seatrial``, bit for bit.
"""

from __future__ import annotations

from . import _native
from ._command import command
from ._errors import (
    AbortedError,
    InputError,
    NotSavedError,
    RejectedError,
    SeatrialError,
    SeatrialWarning,
    UsageError,
)
from ._estimator import Estimator
from ._fleet import fleet
from ._follow import (
    GAINS_FORMS,
    VEHICLE_FORMS,
    Gain,
    HeadingGains,
    Turn,
    TurningLimits,
    export,
    gains,
    heading_gains,
    turning,
    turning_limits,
)
from ._identify import identify, identify_log, identify_table
from ._logs import (
    Comparison,
    Health,
    Inspection,
    Log,
    MethodResult,
    Validated,
    compare,
    health,
    inspect,
    read_log,
    validate,
    watch,
)
from ._model import Identification, Model, Point, Schedule, SpeedModel, TrialResult
from ._plan import Plan, plan
from ._reading import Campaign, Reading
from ._response import Motion, predict, residuals, simulate
from ._simulate import paper_claims, study, trial

__version__ = _native.__version__

__all__ = [
    "AbortedError", "Campaign", "Comparison", "Estimator", "GAINS_FORMS", "Gain", "HeadingGains", "Health",
    "Identification", "InputError", "Inspection", "Log", "MethodResult", "Model", "Motion", "NotSavedError", "Plan",
    "Point", "Reading", "RejectedError", "Schedule", "SeatrialError", "SeatrialWarning", "SpeedModel",
    "TrialResult", "Turn", "TurningLimits", "UsageError", "VEHICLE_FORMS", "Validated", "command", "compare", "export",
    "fleet", "gains", "heading_gains", "health", "identify", "identify_log", "identify_table", "inspect",
    "paper_claims", "plan", "predict", "read_log", "residuals", "simulate", "study", "trial", "turning", "turning_limits", "validate", "watch",
]
