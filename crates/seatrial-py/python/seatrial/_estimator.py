"""The estimator that runs on the vehicle."""

from __future__ import annotations

from array import array as numbers
from typing import Any, Literal, Optional

import numpy as np

from . import _native
from ._columns import Array
from ._model import Model

Method = Literal["least_squares", "instrumental_variable"]


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
