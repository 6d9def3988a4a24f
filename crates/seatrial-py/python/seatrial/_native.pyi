from os import PathLike
from typing import Optional, Sequence, final

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "Estimator", "FleetJournal", "Schedule", "fleet", "fleet_work", "gain", "identify", "identify_log",
    "least_squares", "paper_claims", "read_log", "study", "trial", "turn",
]

_Array = NDArray[np.float64]
_Span = tuple[Optional[float], Optional[float]]
_Theta = tuple[float, float, float] | list[float]
_Log = tuple[str | PathLike[str], int, int]
_Point = tuple[Optional[float], Optional[float], _Theta]

def identify(
    time: _Array,
    heading: _Array,
    rudder: _Array,
    speed: Optional[_Array],
    yaw_rate: Optional[_Array],
    thrust: Optional[_Array],
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
    channels_file: str | PathLike[str] | None,
    columns: dict[str, str],
    units: dict[str, str],
    full_rudder_rad: Optional[float],
    rudder_delay_s: float,
    rudder_lag_s: float,
    drop_invalid: bool,
    training: tuple[Optional[float], Optional[float]],
    validation: tuple[Optional[float], Optional[float]],
    validate_on: str | PathLike[str] | None,
    estimate: str,
    method: Optional[str],
    lambda_rad_s: Optional[float],
    trace: bool,
) -> str: ...
def read_log(path: str | PathLike[str]) -> tuple[dict[str, _Array], str]: ...
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
    estimate: str,
    run_column: Optional[str],
    workers: Optional[int],
    resume: bool,
) -> str: ...
def fleet_work(logs: list[_Log], estimate: str, run_column: Optional[str]) -> str: ...

@final
class FleetJournal:
    def __new__(
        cls,
        inputs: list[str],
        out: str | PathLike[str],
        estimate: str,
        run_column: Optional[str],
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
