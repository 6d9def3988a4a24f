"""Python's outcome of a log is the one that the command says."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest
from conftest import ROOT, command

import seatrial

DATA = Path(os.environ.get("SEATRIAL_DATA", str(ROOT.parent / "shared/data")))
RECORDED = [
    "real/hakusan_ship.csv",
    "real/esso_zigzag_b.csv",
    "real/kvlcc2hsva_Z_20_10_P.csv",
    "real/slocum_amadeus.csv",
    "simulated/first_order_80_s0p5_h0p7.csv",
    "firmware/a1_1.csv",
]


def outcomes(path: Path) -> tuple[str, str]:
    """The outcome that the command's document says, and Python's."""
    said = command("identify", "--json", str(path))
    document = json.loads(said.stdout)
    return document["verdict"]["outcome"].replace("_", " "), seatrial.identify_log(path).outcome


def test_a_simulated_log_has_the_same_outcome(log: Path) -> None:
    said, outcome = outcomes(log)
    assert outcome == said


@pytest.mark.parametrize("name", RECORDED)
def test_a_recorded_log_has_the_same_outcome(name: str) -> None:
    path = DATA / name
    if not path.exists():
        if os.environ.get("CI") == "true" and os.environ.get("SEATRIAL_DATA") != "none":
            pytest.fail(f"no {path}")
        pytest.skip(f"no {path}")
    said, outcome = outcomes(path)
    assert outcome == said
