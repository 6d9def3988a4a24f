"""Trials and studies on simulated vehicles, and the paper's numbers."""

from __future__ import annotations

import json
import math
from typing import Any, Optional, Sequence

from . import _native
from ._errors import AbortedError
from ._model import TrialResult


def trial(
    vehicle: str = "sim:starfish", thrusts: Optional[Sequence[float]] = None, seed: int = 1
) -> TrialResult:
    """Run a whole sea trial, by the paper's plan, on a simulated vehicle.

    Parameters
    ----------
    vehicle
        sim:starfish, sim:starfish-6dof, sim:remus100 or sim:FILE.toml.
    thrusts
        Fractions of full; the plan's without.
    seed
        Of noise and disturbance.

    Returns
    -------
    TrialResult
        The runs with their models, and every sample.

    Raises
    ------
    AbortedError
        The trial was aborted.
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
    """How far estimators are from the truth and from the Cramer-Rao bound, on simulated runs of the paper's vehicle.

    Parameters
    ----------
    runs, thrust, seed
        How many runs, at what fraction of full thrust, from which seed on.
    compass_noise_rad, disturbance_rad_s2, disturbance_time_s
        Standard deviation of the compass; standard deviation and time constant of the disturbance.
    estimators
        Names, as of ``seatrial-lab estimators --estimator``.
    workers
        Threads; all cores without. The result does not depend on them.

    Returns
    -------
    list of dict
        The accuracy of each estimator.
    """
    text = _native.study(
        runs, thrust, seed, compass_noise_rad, disturbance_rad_s2, disturbance_time_s,
        list(estimators), workers,
    )
    accuracy: list[dict[str, Any]] = json.loads(text)
    return accuracy


def paper_claims() -> list[dict[str, Any]]:
    """Every number that the paper prints and that follows from others, beside the recomputed one.

    Returns
    -------
    list of dict
        What is printed, what is recomputed, and whether they agree.
    """
    claims: list[dict[str, Any]] = json.loads(_native.paper_claims())
    return claims
