"""The numbers of Python are those of Rust, bit for bit."""

from __future__ import annotations

import csv
import json
import os
import struct
import subprocess
from pathlib import Path
from typing import Any, Optional

import numpy as np
import pytest

import seatrial
from conftest import ROOT, command


def test_parity_the_estimator_gives_the_vectors_of_the_host() -> None:
    cargo = os.environ.get("CARGO", "cargo")
    made = subprocess.run(
        [cargo, "run", "-q", "-p", "seatrial-parity", "--", "estimator", "f64"],
        cwd=ROOT, capture_output=True, text=True, check=True,
    )
    rows = list(csv.DictReader(made.stdout.splitlines()))
    assert len(rows) > 1000

    def number(digits: str) -> float:
        return float(struct.unpack(">d", bytes.fromhex(digits))[0])

    def bits(value: Optional[float]) -> str:
        return "" if value is None else struct.pack(">d", value).hex()

    estimator = seatrial.Estimator()
    for row in rows:
        if row["call"] in ("warm", "update"):
            step = getattr(estimator, row["call"])
            names = ("time_s", "heading_rad", "rudder_rad")
            assert step(*(number(row[name]) for name in names)) == row["intake"]
        else:
            getattr(estimator, row["call"])()
        model, plain, p = estimator.model, estimator.least_squares_model, estimator.covariance
        for name in ("a22_per_s", "b2_per_s2", "c0_rad_per_s2"):
            assert bits(getattr(model, name)) == row[name]
            assert bits(getattr(plain, name)) == row[f"least_squares_{name}"]
        for i, j in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)]:
            assert bits(p[i, j]) == row[f"p{i + 1}{j + 1}"]
        assert bits(estimator.step_norm) == row["step_norm"]
        assert bits(estimator.converged_s) == row["converged_s"]


def without_actions(part: Any) -> Any:
    """What to do is said with options to one reader and with arguments to the other."""
    if isinstance(part, dict):
        return {name: without_actions(value) for name, value in part.items() if name != "action"}
    return [without_actions(value) for value in part] if isinstance(part, list) else part


def test_parity_identify_log_is_the_document_of_the_command(log: Path) -> None:
    done = command("identify", str(log), "--json")
    found = seatrial.identify_log(log)
    assert without_actions(found.document) == without_actions(json.loads(done.stdout))
    assert found.outcome == json.loads(done.stdout)["verdict"]["outcome"].replace("_", " ")
    assert not any("--" in action for action in found.actions)


@pytest.mark.parametrize("options, estimate", [((), "refined"), (("--as-paper",), "paper")])
def test_parity_identify_is_that_of_the_command(
    log: Path, record: dict[str, Any], options: tuple[str, ...], estimate: Any
) -> None:
    windows = ["--from", "12", "--to", "28.5", "--validate-from", "28.5", "--validate-to", "45"]
    done = command("identify", str(log), "--json", *windows, *options)
    expected = json.loads(done.stdout)
    found = seatrial.identify(
        record["time_s"], record["heading_rad"], record["rudder_rad"], record["surge_speed_m_s"],
        yaw_rate=record.get("yaw_rate_rad_s"), thrust=record.get("thrust"),
        training=(12.0, 28.5), validation=(28.5, 45.0), estimate=estimate,
    )
    for part in ("online", "refined", "nomoto", "validation", "verdict", "settings"):
        assert without_actions(found.document[part]) == without_actions(expected[part]), part


def test_parity_tables_and_strided_arrays_give_what_arrays_give(record: dict[str, Any]) -> None:
    import pandas
    import polars
    import pyarrow

    whole = seatrial.identify_table(record, estimate="online").document
    for table in (pandas.DataFrame(record), polars.DataFrame(record), pyarrow.table(record)):
        assert seatrial.identify_table(table, estimate="online").document == whole

    class Stream:
        """Nothing but an Arrow stream."""

        def __arrow_c_stream__(self, schema: Any = None) -> Any:
            return pyarrow.table(record).__arrow_c_stream__(schema)

    assert seatrial.identify_table(Stream(), estimate="online").document == whole
    names = ["time_s", "heading_rad", "rudder_rad", "surge_speed_m_s"]
    block = np.column_stack([record[name] for name in names])
    strided = seatrial.identify(*block.T, estimate="online")
    assert strided.document["online"] == whole["online"]
