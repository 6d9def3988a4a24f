"""HullBench (bench/hulls): its peers and scores, on a first-order vehicle whose truth is known."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("scipy", reason="skipped: the peers of HullBench need scipy")

BENCH = Path(__file__).resolve().parents[3] / "bench/hulls"
sys.path.insert(0, str(BENCH))

import methods  # noqa: E402
import models  # noqa: E402
import records  # noqa: E402
import scores  # noqa: E402
import tables  # noqa: E402

TRUTH = models.Hull(-0.4, 0.2, 0.003)


def sailed(seed: int, seconds: float = 90.0, h: float = 0.1) -> Any:
    """A zig-zag of steps of random length, with 0.1 deg of compass noise."""
    random = np.random.default_rng(seed)
    time = np.arange(0.0, seconds, h)
    sides = np.repeat(np.resize([1.0, -1.0], 40), random.integers(20, 80, 40))[: time.size]
    record = records.Record("simulated", time, 0.0 * time, 0.3 * sides)
    heading, rate = TRUTH.run(record, np.array([[0.5], [0.0], [0.0]]))
    noise = np.radians(0.1)
    record.heading = heading[:, 0] + random.normal(0.0, noise, time.size)
    record.logged_rate = rate[:, 0] + random.normal(0.0, 0.1 * noise, time.size)
    return record


def test_recover_every_peer_predicts_a_first_order_vehicle() -> None:
    training, left_out = sailed(1), sailed(2)
    fits = [methods.output_error, methods.arx]
    try:
        import sysidentpy  # noqa: F401

        fits.append(methods.narmax)
    except ImportError:
        print("SysIdentPy is not installed: left out")
    if methods.octave_here():
        fits.append(methods.octave)
    still = scores.short_runs(None, left_out)
    for fit in fits:
        for name, model in fit(training).items():
            heading, rate = scores.free_run(model, left_out)
            assert heading > 0.95 and rate > 0.95, (name, heading, rate)
            assert scores.short_runs(model, left_out) < 0.5 * still, name
    first = methods.output_error(training)["output error, 1st order"]
    assert first.a == pytest.approx(TRUTH.a, rel=0.03)
    assert first.b == pytest.approx(TRUTH.b, rel=0.03)


def test_exact_the_free_run_of_the_truth_scores_one() -> None:
    left_out = sailed(3)
    heading, rate = scores.free_run(TRUTH, left_out)
    # Of two samples one is looked at, so that a step of the rudder between them is half a step at both.
    assert heading > 0.9999 and rate > 0.998
    # Short steps say the same to 0.01 deg: the damping of the second is quadratic only in name.
    start = np.array([[0.5], [0.02], [0.001]])
    nearly = models.Hull(TRUTH.a, TRUTH.b, TRUTH.c, d2=1e-12)
    assert nearly.run(left_out, start)[0] == pytest.approx(TRUTH.run(left_out, start)[0], abs=2e-4)


def test_exact_the_band_holds_what_its_noise_explains() -> None:
    left_out = sailed(4)
    noise = float(np.radians(0.1))
    assert scores.coverage(TRUTH, 1e-12 * np.eye(3), noise, left_out) > 0.9
    assert scores.coverage(models.Hull(-0.8, 0.2), 1e-12 * np.eye(3), noise, left_out) < 0.5


def test_exact_equal_scores_share_a_rank() -> None:
    assert tables.ranks({"a": 0.9, "b": 0.9, "c": 0.1}) == {"a": 1.5, "b": 1.5, "c": 3.0}
