"""What follows from models, simulated trials, exceptions, types."""

from __future__ import annotations

import copy
import math
import os
import pickle
import subprocess
import sys
import threading
import time
import warnings
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import seatrial
from conftest import ROOT, code_of, command

PACKAGE = ROOT / "crates/seatrial-py"


def test_val_table_iv() -> None:
    model = seatrial.Model(-1.62, 1.25, 1.25 * 0.036)
    turn = seatrial.turning(model, 0.26, 1.4, hand="port")
    # Half a unit of the last digit printed.
    assert turn.u_turn_time_s == pytest.approx(20.65, abs=0.005)
    assert turn.u_turn_mean_radius_m == pytest.approx(9.20, abs=0.005)


@pytest.mark.parametrize("hand", ["Starboard", "right", " RIGHT "])
def test_exact_words_for_starboard(hand: str) -> None:
    model = seatrial.Model(-1.0, 1.0, 0.1)
    assert seatrial.turning(model, 0.26, hand=hand) == seatrial.turning(model, 0.26)
    assert seatrial.turning(model, 0.26, hand="Left") == seatrial.turning(model, 0.26, hand="port")
    assert seatrial.turning(model, 0.26, hand="left") != seatrial.turning(model, 0.26, hand=hand)
    with pytest.raises(seatrial.UsageError, match="'starboard' or 'port'"):
        seatrial.turning(model, 0.26, hand="larboard")


def test_exact_gain_of_57() -> None:
    gain = seatrial.gains(seatrial.Model(-1.0, 2.0, 0.1), 1.0 / math.sqrt(2.0))
    # a22^2 / (2 b2), but for the rounding of the square root.
    assert gain.proportional_gain == pytest.approx(0.25, rel=1e-15)
    assert gain.feed_forward_rudder_rad == -0.05


def test_exact_schedule_runs_in_speed_squared() -> None:
    points = [
        seatrial.Point(seatrial.Model(-1.0, 1.0), surge_speed_m_s=1.0),
        seatrial.Point(seatrial.Model(-2.0, 4.0), surge_speed_m_s=2.0),
    ]
    between = seatrial.Schedule(points).at(1.5)
    assert between.model == seatrial.Model(-1.5, 1.0 + 3.0 * (1.25 / 3.0), 0.0)
    with pytest.raises(seatrial.UsageError):
        seatrial.Schedule(points).at(3.0)
    assert seatrial.Schedule(points).at(3.0, extrapolate=True).extrapolated


def test_recover_a_trial_on_the_simulator() -> None:
    result = seatrial.trial("sim:starfish", [0.7, 0.9], seed=2)
    assert [found.accepted for found in result.identifications] == [True, True]
    at = result.schedule().at(0.8)
    # Half way between 0.7 and 0.9 thrust; the intervals of both are within 10 %.
    assert at.model.b2_per_s2 == pytest.approx(1.08, rel=0.1)
    assert set(result.samples) >= {"time_s", "heading_rad", "rudder_rad", "surge_speed_m_s"}


def test_prop_the_study_does_not_depend_on_the_workers() -> None:
    alone = seatrial.study(4, workers=1)
    assert alone == seatrial.study(4, workers=2)
    assert [e["estimator"] for e in alone] == ["refined", "instrumental_variable"]


def test_val_the_paper() -> None:
    claims = seatrial.paper_claims()
    assert sum(claim["agreement"] == "agrees" for claim in claims) > 20


def test_cli_exceptions_carry_the_exit_codes_of_the_command(tmp_path: Path) -> None:
    time_s = np.arange(100) * 0.05
    with pytest.raises(seatrial.RejectedError) as rejected:
        seatrial.identify(time_s, np.sin(time_s), np.zeros(100))
    assert (rejected.value.code, rejected.value.reason) == (4, "constant of rudder")
    with pytest.raises(seatrial.UsageError, match="expected as many"):
        seatrial.identify(time_s, time_s, np.zeros(99))
    with pytest.raises(seatrial.UsageError, match="lambda"):
        seatrial.Estimator(lambda_rad_s=-1.0)
    with pytest.raises(seatrial.InputError) as unread:
        seatrial.read_log(tmp_path / "none.csv")
    done = command("identify", str(tmp_path / "none.csv"))
    assert done.returncode == unread.value.code == seatrial.InputError.code == 3
    assert str(unread.value) in done.stderr
    with pytest.raises(seatrial.InputError, match="no column 'rudder_rad'"):
        seatrial.identify_table({"time_s": time_s, "heading_rad": time_s})


def doublet() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time, heading and rudder of a first-order vehicle."""
    time_s = np.arange(400) * 0.05
    rudder = np.where(time_s < 2, 0.0, np.where(time_s < 4, 0.2, np.where(time_s < 6, -0.2, 0.0)))
    heading, rate = np.zeros(400), 0.0
    for k in range(399):
        heading[k + 1] = heading[k] + 0.05 * rate
        rate += 0.05 * (-rate + rudder[k])
    return time_s, heading, rudder


def test_exact_dates_and_durations_are_seconds() -> None:
    time_s, heading, rudder = doublet()
    expected = seatrial.identify(time_s, heading, rudder).model
    nanoseconds = np.round(time_s * 1e9).astype("timedelta64[ns]")
    start = np.datetime64("2026-06-01T12:00:00", "ns")
    for dates in (start + nanoseconds, nanoseconds, (start + nanoseconds).astype("datetime64[us]")):
        found = seatrial.identify(dates, heading, rudder).model
        # Nanoseconds are rounded.
        assert found.theta == pytest.approx(expected.theta, rel=1e-6, abs=1e-9)
    with pytest.raises(seatrial.UsageError, match="heading has dates"):
        seatrial.identify(time_s, start + nanoseconds, rudder)


def test_exact_what_is_no_column_of_numbers_is_a_usage_error() -> None:
    time_s, heading, rudder = doublet()
    masked = np.ma.masked_array(heading, mask=time_s > 19)
    for wrong, found in [
        (heading + 1j, "complex"),
        (masked, "masked"),
        (heading[:, None], "2 dimensions"),
        (heading[1:], "as many"),
        (["north"] * 400, "expected numbers"),
    ]:
        with pytest.raises(seatrial.UsageError, match=found):
            seatrial.identify(time_s, wrong, rudder)
    # A speed that is masked is not known, and the model is found all the same.
    speed = np.ma.masked_array(np.full(400, 1.5), mask=time_s < 1)
    assert seatrial.identify(time_s, heading, rudder, speed).document["online"]


def test_exact_units_are_never_mistaken_in_silence() -> None:
    """Degrees as radians, fractions as radians, other units of time: refused, or warned of."""
    time_s, heading, rudder = doublet()
    nanoseconds = np.round(time_s * 1e9).astype("timedelta64[ns]")
    epoch = np.datetime64("2026-06-01T12:00:00", "ns") + nanoseconds
    refused: list[tuple[Any, Any, Any, dict[str, Any]]] = [
        (time_s, heading, np.degrees(rudder), {}),
        (time_s, heading, np.degrees(rudder), {"rudder_unit": "full"}),
        (nanoseconds.astype(np.int64), heading, rudder, {}),
        (epoch.astype(np.int64), heading, rudder, {}),
        (epoch.astype("datetime64[us]").astype(np.int64), heading, rudder, {}),
        (time_s, heading, rudder, {"heading_unit": "gon"}),
    ]
    for time, psi, delta, units in refused:
        with pytest.raises(seatrial.UsageError, match="expected"):
            seatrial.identify(time, psi, delta, **units)
    doubted: list[tuple[Any, Any, Any]] = [
        (time_s, np.degrees(heading - 0.1) % 360.0, rudder),
        (time_s, np.degrees(heading), rudder),
        (time_s, np.degrees(4.0 * heading) + 120.0, rudder),
        (time_s, heading, 5.0 * rudder),
        (np.arange(400) * 50, heading, rudder),
    ]
    for time, psi, delta in doubted:
        with pytest.warns(seatrial.SeatrialWarning, match="heading_unit|rudder_unit|milliseconds"):
            seatrial.identify(time, psi, delta)


def test_exact_samples_that_are_no_numbers_are_refused_or_left_out() -> None:
    time_s, heading, rudder = doublet()
    for place in range(3):
        columns = [time_s.copy(), heading.copy(), rudder.copy()]
        columns[place][7] = np.nan
        with pytest.raises(seatrial.InputError, match="at 7 .*drop_invalid"):
            seatrial.identify(*columns)
        with pytest.warns(seatrial.SeatrialWarning, match="1 of 400 samples"):
            found = seatrial.identify(*columns, drop_invalid=True)
        assert found.model.theta == pytest.approx(seatrial.identify(time_s, heading, rudder).model.theta, rel=0.1, abs=0.01)
    back = time_s.copy()
    back[200:] -= 5.0
    with pytest.raises(seatrial.InputError, match="go back in time"):
        seatrial.identify(back, heading, rudder)


def test_parity_arrays_get_the_doubts_of_a_file(tmp_path: Path) -> None:
    """Milliseconds, degrees and shares of full rudder: never plain use, and the codes of the same numbers in a file."""
    time_s, heading, rudder = doublet()
    for time, psi, delta in [
        (time_s, heading, rudder),
        (time_s, np.degrees(heading), rudder),
        (time_s, np.degrees(heading - 0.1) % 360.0, rudder),
        (np.arange(400) * 50, heading, rudder),
        (np.arange(400) * 50.5, heading, rudder),
    ]:
        log = tmp_path / "log.csv"
        rows = "\n".join(f"{a!r},{b!r},{c!r}" for a, b, c in zip(time.tolist(), psi.tolist(), delta.tolist()))
        log.write_text(f"time_s,heading_rad,rudder_rad\n{rows}\n")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            of_file = seatrial.identify_log(log, training=(float(time[0]), float(time[-1]) + 1e-6))
            found = seatrial.identify(time, psi, delta)
        codes = [{code for code, _ in of.reasons} for of in (found, of_file)]
        assert found.outcome == of_file.outcome and found.outcome != "use"
        assert codes[0] >= {code for code in codes[1] if "doubtful" in code or "unchecked" in code}, codes
    with pytest.warns(seatrial.SeatrialWarning, match="rudder_unit"):
        shares = seatrial.identify(time_s, heading, 5.0 * rudder)
    assert "unit_unknown of rudder" in dict(shares.reasons) and not shares.accepted


def test_exact_units_of_arrays_are_said_as_those_of_a_log() -> None:
    time_s, heading, rudder = doublet()
    expected = seatrial.identify(time_s, heading, rudder).model
    units = {"time": "ms", "heading": "deg", "rudder": "deg", "yaw_rate": "deg/s"}
    rate = np.degrees(np.gradient(heading, time_s))
    found = seatrial.identify(1e3 * time_s, np.degrees(heading), np.degrees(rudder), yaw_rate=rate, units=units)
    assert found.model.theta == pytest.approx(expected.theta, rel=1e-3, abs=1e-6)
    for wrong in ({"time": "fortnight"}, {"depth": "m"}):
        with pytest.raises(seatrial.UsageError, match="expected"):
            seatrial.identify(time_s, heading, rudder, units=wrong)


def test_exact_units_that_are_said_are_taken() -> None:
    time_s, heading, rudder = doublet()
    expected = seatrial.identify(time_s, heading, rudder).model
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        in_degrees = seatrial.identify(
            time_s, np.degrees(heading), np.degrees(rudder), heading_unit="deg", rudder_unit="deg"
        )
        of_full = seatrial.identify(time_s, heading, rudder / 0.2, rudder_unit="full")
    assert in_degrees.model.theta == pytest.approx(expected.theta, rel=1e-6, abs=1e-9)
    assert of_full.model.b2_per_s2 == pytest.approx(0.2 * expected.b2_per_s2, rel=1e-3)


def test_parity_an_estimator_that_was_pickled_goes_on_with_the_same_bits() -> None:
    whole, rows = seatrial.Estimator(), list(zip(*doublet()))
    for row in rows[:20]:
        whole.warm(*row)
    for row in rows[20:200]:
        whole.update(*row)
    whole.excitation_ended()
    again = pickle.loads(pickle.dumps(whole))
    for row in rows[200:]:
        assert whole.update(*row) == again.update(*row)
        assert whole.model == again.model
    assert (whole.covariance == again.covariance).all()
    assert copy.deepcopy(again).model == whole.model


def test_io_a_log_says_how_it_was_read(tmp_path: Path) -> None:
    time_s, heading, rudder = doublet()
    log = tmp_path / "run.csv"
    rows = zip(time_s, np.degrees(heading), 1500.0 + 1000.0 * rudder)
    lines = [f"{t},{psi},{pwm}" for t, psi, pwm in rows]
    log.write_text("\n".join(["time_s,heading_deg,rudder_pwm", *lines]))
    found = seatrial.read_log(log)
    assert found.rudder_unit == "full_rudder"
    assert "rudder_of_full" in found and "rudder_rad" not in found
    assert any("full_rudder_rad" in warning for warning in found.warnings)
    assert isinstance(found.assumptions, dict)
    assert found.source["samples_read"] == 400


def test_prop_other_threads_run_while_a_study_does() -> None:
    ticks = 0
    over = threading.Event()

    def tick() -> None:
        nonlocal ticks
        while not over.is_set():
            ticks += 1
            time.sleep(0.001)

    thread = threading.Thread(target=tick)
    thread.start()
    seatrial.study(20, workers=1)
    over.set()
    thread.join()
    # A study of 0.2 s and more; held back, the thread would have ticked once or twice.
    assert ticks > 20


def test_val_types() -> None:
    mypy = [sys.executable, "-m", "mypy", "--strict", "--ignore-missing-imports", "python/seatrial"]
    done = subprocess.run(mypy, cwd=PACKAGE, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout
    stubs = [sys.executable, "-m", "mypy.stubtest", "seatrial._native"]
    done = subprocess.run(stubs, cwd=PACKAGE / "tests", capture_output=True, text=True)
    assert done.returncode == 0, done.stdout


def test_val_the_notebook_runs() -> None:
    import nbclient
    import nbformat

    notebook: Any = nbformat.read(PACKAGE / "paper.ipynb", as_version=4)
    done = nbclient.NotebookClient(notebook, timeout=120).execute()
    cells = [cell for cell in done.cells if cell.cell_type == "code"]
    pictures = [o for cell in cells for o in cell.outputs if "image/png" in o.get("data", {})]
    assert len(pictures) == 3


def write_logs(folder: Path, count: int) -> Path:
    folder.mkdir(parents=True)
    for seed in range(count):
        log = folder / f"{seed}.csv"
        made = command("sim", "log", "--seed", str(seed), "--thrust", "0.8", "--out", str(log))
        assert made.returncode == 0, made.stderr
    return folder


def test_io_executors_give_the_rows_of_one_machine(tmp_path: Path) -> None:
    logs = write_logs(tmp_path / "logs", 8)
    (logs / "bad.csv").write_text("time,heading\n")
    alone = seatrial.fleet(logs, tmp_path / "alone.parquet")
    assert (alone["logs"], alone["errors"]) == (9, 1)
    table = tmp_path / "together.parquet"
    for executor in [ThreadPoolExecutor(2), ProcessPoolExecutor(2, get_context("spawn"))]:
        with executor:
            assert seatrial.fleet(logs, table, executor=executor, logs_per_task=2) == alone
        assert table.read_bytes() == (tmp_path / "alone.parquet").read_bytes()
        # Only what could not be read is read again.
        again = seatrial.fleet(logs, table)
        assert (again["logs"], again["done_before"]) == (9, 8)
        table.unlink()


def test_io_a_job_whose_worker_is_killed_is_gone_on_with(tmp_path: Path) -> None:
    logs = write_logs(tmp_path / "logs", 4)
    alone, table = tmp_path / "alone.parquet", tmp_path / "together.parquet"
    seatrial.fleet(logs, alone)
    with ProcessPoolExecutor(1, get_context("spawn")) as executor:
        executor.submit(os._exit, 9)
        with pytest.raises(BrokenProcessPool):
            seatrial.fleet(logs, table, executor=executor, logs_per_task=1)
    assert not table.exists()
    with ProcessPoolExecutor(1, get_context("spawn")) as executor:
        seatrial.fleet(logs, table, executor=executor, resume=True)
    assert table.read_bytes() == alone.read_bytes()


def test_io_the_query_of_the_docs_finds_the_vehicle_that_changed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    months = [1_777_900_000, 1_780_600_000]
    # In June beta's rudder moves a fifth less than its log says.
    for vehicle, scales in [("alpha", (1.0, 1.0)), ("beta", (1.0, 1.25))]:
        folder = write_logs(tmp_path / f"logs/vehicle={vehicle}", 2)
        for log, scale, time_s in zip(sorted(folder.iterdir()), scales, months):
            columns, *rows = (line.split(",") for line in log.read_text().splitlines())
            rudder = columns.index("rudder_rad")
            for row in rows:
                row[rudder] = str(float(row[rudder]) * scale)
            log.write_text("\n".join(",".join(row) for row in [columns, *rows]) + "\n")
            os.utime(log, (time_s, time_s))
    seatrial.fleet(tmp_path / "logs", tmp_path / "fleet.parquet")
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    exec(code_of("fleet.md", "import duckdb"), names)
    [found] = names["changed"].fetchall()
    row = dict(zip(names["changed"].columns, found))
    assert row["vehicle"] == "beta"
    assert (row["month"].year, row["month"].month) == (2026, 6)
    assert -0.3 < row["change"] < -0.1
