from os import PathLike
from typing import Any, Optional, Sequence, final

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "Estimator", "FleetJournal", "GAINS_FORMS", "Schedule", "VEHICLE_FORMS", "__version__", "compare", "export_gains", "export_vehicle",
    "fleet", "fleet_work", "gain", "heading_gains", "health", "identify", "identify_log", "inspect",
    "least_squares", "paper_claims", "plan", "read_log", "save", "study", "trial", "turn", "turning_limits", "validate",
]

__version__: str
GAINS_FORMS: list[str]
VEHICLE_FORMS: list[str]

_Array = NDArray[np.float64]
_Span = tuple[Optional[float], Optional[float]]
_Theta = tuple[float, float, float] | list[float]
_Log = tuple[str | PathLike[str], int, int, Optional[str]]
_How = tuple[str, Optional[str], dict[str, Any]]
_Told = tuple[str, list[str]]
_Mapping = dict[str, Any]
_Point = tuple[Optional[float], Optional[float], _Theta]

def identify(
    time: _Array,
    heading: _Array,
    rudder: _Array,
    speed: Optional[_Array],
    yaw_rate: Optional[_Array],
    thrust: Optional[_Array],
    rudder_unit: str,
    units: _Mapping,
    training: _Span,
    validation: Optional[_Span],
    estimate: str,
    method: Optional[str],
    lambda_rad_s: Optional[float],
    trace: bool,
) -> str: ...
def least_squares(
    time: _Array,
    heading: _Array,
    rudder: _Array,
    training: _Span,
    lambda_rad_s: Optional[float],
) -> str: ...
def identify_log(
    path: str | PathLike[str],
    reading: _Mapping,
    axis: str,
    training: _Span,
    validation: _Span,
    validate_on: str | PathLike[str] | None,
    more_logs: list[str | PathLike[str]],
    estimate: str,
    method: Optional[str],
    lambda_rad_s: Optional[float],
    trace: bool,
) -> _Told: ...
def read_log(
    path: str | PathLike[str], reading: _Mapping
) -> tuple[dict[str, _Array], str, list[str]]: ...
def inspect(path: str | PathLike[str], reading: _Mapping) -> _Told: ...
def compare(
    path: str | PathLike[str],
    reading: _Mapping,
    training: _Span,
    validation: _Span,
    validate_on: str | PathLike[str] | None,
    lambda_rad_s: Optional[float],
) -> _Told: ...
def validate(
    path: str | PathLike[str], source: _Mapping, reading: _Mapping, span: _Span
) -> _Told: ...
def health(
    reference: str,
    now: Optional[str],
    missions: list[str],
    logbook: str | PathLike[str],
    reading: _Mapping,
    false_alarms: float,
    tolerated: Optional[float],
    offset_counts: Optional[bool],
) -> _Told: ...
def heading_gains(source: _Mapping, asked: _Mapping) -> _Told: ...
def turning_limits(
    source: _Mapping,
    heading_change_rad: float,
    up_to_speed_m_s: Optional[float],
    measured_u_turn: Optional[tuple[float, float]],
) -> _Told: ...
def export_gains(
    source: _Mapping, asked: _Mapping, to: str, vehicle_type: str, takes_rehearsals: bool, accept: bool
) -> _Told: ...
def export_vehicle(
    source: _Mapping, said: _Mapping, to: str, at_thrust: Optional[float], accept: bool
) -> tuple[bytes, list[str]]: ...
def save(path: str | PathLike[str], content: bytes, read: list[str]) -> None: ...
def plan(asked: _Mapping, believed: _Mapping) -> tuple[_Told, str, bool]: ...
def paper_claims() -> str: ...
def turn(
    theta: _Theta, rudder_limit_rad: float, starboard: bool, surge_speed_m_s: Optional[float]
) -> tuple[float, float, float, float, Optional[float], Optional[float]]: ...
def gain(theta: _Theta, damping_ratio: float) -> tuple[float, float]: ...
def trial(
    vehicle: str, thrusts: Optional[list[float]], seed: int
) -> tuple[str, dict[str, _Array]]: ...
def study(
    runs: int,
    thrust: float,
    seed: int,
    compass_noise_rad: float,
    disturbance_rad_s2: float,
    disturbance_time_s: float,
    estimators: list[str],
    workers: Optional[int],
) -> str: ...
def fleet(
    inputs: list[str],
    out: str | PathLike[str],
    how: _How,
    workers: Optional[int],
    resume: bool,
) -> str: ...
def fleet_work(logs: list[_Log], how: _How) -> str: ...

@final
class FleetJournal:
    def __new__(
        cls,
        inputs: list[str],
        out: str | PathLike[str],
        how: _How,
        resume: bool,
    ) -> FleetJournal: ...
    def pending(self) -> list[_Log]: ...
    def keep(self, lines: str) -> None: ...
    def finish(self) -> str: ...

@final
class Schedule:
    def __new__(cls, points: Sequence[_Point], by_speed: bool) -> Schedule: ...
    def lookup(self, at: float, extrapolate: bool) -> tuple[_Point, bool]: ...

@final
class Estimator:
    def __new__(
        cls, lambda_rad_s: Optional[float], method: Optional[str], as_paper: bool
    ) -> Estimator: ...
    def warm(self, time_s: float, heading_rad: float, rudder_rad: float) -> str: ...
    def update(self, time_s: float, heading_rad: float, rudder_rad: float) -> str: ...
    def excitation_ended(self) -> None: ...
    def restart(self) -> None: ...
    @property
    def model(self) -> list[float]: ...
    @property
    def least_squares_model(self) -> list[float]: ...
    @property
    def covariance(self) -> list[list[float]]: ...
    @property
    def step_norm(self) -> float: ...
    @property
    def converged_s(self) -> Optional[float]: ...
