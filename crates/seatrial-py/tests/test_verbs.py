"""Verbs in Python are those of the command: documents, warnings, exceptions, pages."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import matplotlib
import pytest
from conftest import ROOT, binary, command
from test_parity import without_actions

import seatrial

matplotlib.use("agg")

PACKAGE = ROOT / "crates/seatrial-py"


def printed(*arguments: str) -> Any:
    """The document of the command."""
    done = command(*arguments, "--json")
    assert done.returncode in (0, 4), done.stderr
    return json.loads(done.stdout)


def without_clock(part: Any) -> Any:
    """But for what a clock measured and for what to do."""
    if isinstance(part, dict):
        return {k: without_clock(v) for k, v in without_actions(part).items() if k != "time_ms"}
    return [without_clock(value) for value in part] if isinstance(part, list) else part


def show(result: Any) -> None:
    """A result has a page and a picture."""
    page = result._repr_html_()
    assert "<table>" in page or "<p>" in page
    assert "None" not in page
    assert result.plot().figure is not None
    matplotlib.pyplot.close("all")


@pytest.fixture(scope="module")
def document(log: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What was identified in the log."""
    path = tmp_path_factory.mktemp("document") / "model.json"
    path.write_text(command("identify", str(log), "--json").stdout)
    return path


def test_parity_logs_are_inspected_compared_and_validated(log: Path, document: Path) -> None:
    inspected = seatrial.inspect(log)
    assert without_clock(inspected.document) == without_clock(printed("inspect", str(log)))
    assert inspected.usable and inspected.gaps == 0 and len(inspected.manoeuvres) > 1
    compared = seatrial.compare(log)
    assert without_clock(compared.document) == without_clock(printed("compare", str(log)))
    assert {method.method for method in compared.methods} >= {"paper", "refined"}
    found = seatrial.identify_log(log)
    expected = printed("validate", str(log), "--model", str(document))
    for source in (document, found):
        validated = seatrial.validate(log, source)
        assert without_clock(validated.document) == without_clock(expected)
    wrong = seatrial.validate(log, seatrial.Model(-1.0, -1.0))
    assert not wrong.accepted and wrong.outcome == "do not use"
    for result in (inspected, compared, validated, found):
        show(result)


def test_parity_plans(document: Path) -> None:
    deg = 3.141592653589793 / 180.0
    planned = seatrial.plan(thrusts=[0.6, 0.8], amplitude_rad=12 * deg, target="a22:10%,b2:5%", compare=True)
    expected = printed(
        "plan", "--thrust", "0.6", "--thrust", "0.8", "--amplitude-deg", "12", "--target", "a22:10%,b2:5%", "--compare"
    )
    assert planned.document == expected
    slow = seatrial.plan(time_constant_s=20, sample_interval_s=0.5)
    assert slow.document == printed("plan", "--time-constant", "20", "--sample-interval", "0.5")
    model = seatrial.Model(-0.9, 0.7)
    known = seatrial.plan(models=model, surge_speed_m_s=1.2, thrusts=[0.6], noise_rad=deg, disturbance=(0.005, 2))
    asked = ("--a22=-0.9", "--b2", "0.7", "--speed", "1.2", "--thrust", "0.6", "--noise-deg", "1")
    done = command("plan", *asked, "--disturbance", "0.005,2", "--json")
    assert known.document == json.loads(done.stdout)
    # The exit code of the command: 4 is a plan that will not do.
    assert known.will_do == (done.returncode == 0)
    assert "thrusts" in known.toml
    show(planned)
    with pytest.raises(seatrial.UsageError, match="a22:10%"):
        seatrial.plan(target="narrow")


def test_parity_health(log: Path) -> None:
    part = f"{log}@0..28"
    same = seatrial.health(part, part)
    assert without_clock(same.document) == without_clock(printed("health", part, part))
    assert same.finding != "changed"
    show(same)
    watched = seatrial.watch(part, [log])
    assert without_clock(watched.document) == without_clock(printed("health", part, "--watch", str(log)))
    with pytest.raises(seatrial.InputError, match="no such file"):
        seatrial.health("nobody", "nothing", logbook="none.db")


def test_parity_gains_turns_and_files(log: Path, document: Path, tmp_path: Path) -> None:
    found = seatrial.identify_log(log)
    gains = seatrial.heading_gains(document)
    assert gains.document == printed("gains", "--model", str(document))
    assert seatrial.heading_gains(found).points == gains.points
    turns = seatrial.turning_limits(document)
    assert turns.document == printed("turn", "--model", str(document))
    show(gains)
    show(turns)
    for form in seatrial.GAINS_FORMS:
        said = command("gains", "--model", str(document), "--export", form).stdout
        assert seatrial.export(document, form) == said
    with pytest.warns(seatrial.SeatrialWarning, match="ASSUMED"):
        out = tmp_path / "boat.toml"
        text = seatrial.export(document, "vehicle", name="boat", surge_speed_m_s=1.6, out=out)
    said = command("export", "--to", "vehicle", "--model", str(document), "--name", "boat", "--speed", "1.6")
    assert text == said.stdout == out.read_text()
    trial = seatrial.trial(f"sim:{out}", [1.0], seed=2)
    show(trial)
    with pytest.raises(seatrial.UsageError, match="rehearsal"):
        seatrial.export(trial, "ardupilot")


def test_exact_gains_that_are_warned_of_and_files_that_are_kept_are_refused(tmp_path: Path, log: Path) -> None:
    schedule = tmp_path / "s.toml"
    text = (
        "[[point]]\nsurge_speed_m_s = 1.0\na22_per_s = -1.0\nb2_per_s2 = 0.4\n"
        "covariance = [[0.01, 0, 0], [0, 0.09, 0], [0, 0, 0.0001]]\n"
    )
    schedule.write_text(text)
    for form in ("ardupilot", "ros2_control"):
        with pytest.raises(seatrial.RejectedError, match="holds 0"):
            seatrial.export(schedule, form, name="b")
        assert seatrial.export(schedule, form, name="b", accept=True)
    for kept in (log, schedule):
        before = kept.read_bytes()
        with pytest.raises(seatrial.UsageError, match="not written"):
            seatrial.export(schedule, "vehicle", name="b", out=kept)
        assert kept.read_bytes() == before


def test_cli_every_verb_is_reached(
    log: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", f"{binary().parent}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.chdir(tmp_path)
    trial = seatrial.command("trial", "--yes", "--logbook", "sea.db", "--seed", "1")
    assert trial["verdict"]["accepted"]
    commissioned = seatrial.command(
        "commission", "--vehicle", "sim:starfish", "--logbook", "sea.db", "--yes"
    )
    assert commissioned["schema"] == "seatrial.own_commission.v1"
    gains = seatrial.heading_gains(seatrial.Campaign("sea.db", 1))
    assert gains.document == printed("gains", "--logbook", "sea.db", "--campaign", "1")
    with pytest.raises(seatrial.InputError, match="none.csv"):
        seatrial.command("identify", "none.csv")
    with pytest.raises(seatrial.UsageError, match="no-such-option"):
        seatrial.command("identify", log, "--no-such-option")


def test_io_warnings_of_a_log_are_warnings(tmp_path: Path, log: Path) -> None:
    rows = log.read_text().splitlines()
    hollow = tmp_path / "hollow.csv"
    hollow.write_text("\n".join([*rows[:200], rows[200].replace(rows[200].split(",")[1], "nan"), *rows[201:]]))
    said = command("identify", str(hollow), "--drop-invalid").stderr.splitlines()
    warned = [line for line in said if line.startswith("warning: ")]
    with pytest.warns(seatrial.SeatrialWarning) as told:
        seatrial.identify_log(hollow, drop_invalid=True)
    assert len(told) == len(warned) >= 1
    for warning, line in zip(told, warned):
        assert str(warning.message) in line


def test_val_the_examples_of_the_page_run_and_have_types(tmp_path: Path, log: Path) -> None:
    import re

    page = (ROOT / "docs/python.md").read_text()
    examples = re.findall(r"```python\n(.*?)```", page, re.S)
    assert len(examples) >= 6
    (tmp_path / "logs").mkdir()
    for name in ("run.csv", "logs/run.csv"):
        (tmp_path / name).write_bytes(log.read_bytes())
    for number, code in enumerate(examples):
        path = tmp_path / f"example_{number}.py"
        path.write_text(code)
        if "import ray" not in code:
            done = subprocess.run([sys.executable, str(path)], cwd=tmp_path, capture_output=True, text=True)
            assert done.returncode == 0, code + done.stderr
    mypy = [sys.executable, "-m", "mypy", "--strict", "--ignore-missing-imports", *map(str, tmp_path.glob("example_*.py"))]
    done = subprocess.run(mypy, cwd=PACKAGE / "tests", capture_output=True, text=True)
    assert done.returncode == 0, done.stdout


def test_val_the_version_is_that_of_the_command() -> None:
    assert command("--version").stdout == f"seatrial {seatrial.__version__}\n"
