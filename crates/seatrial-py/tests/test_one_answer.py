"""Python's outcome of a log is the one that the command says, over every log that the project has."""

from __future__ import annotations

import json
import os
import re
import warnings
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from conftest import ROOT, command

import seatrial

DATA = Path(os.environ.get("SEATRIAL_DATA", str(ROOT.parent / "shared/data")))
FORMATS = {".csv", ".bin", ".tlog", ".ulg", ".raw", ".all"}
# Logs of every vehicle and format, and of every outcome.
LEAST_LOGS = 60
# Of the command: `--rudder NAME`.
OPTION = re.compile(r"(?<![\w-])--[a-z]")


def recorded() -> list[Path]:
    """Every log of one file of the recorded data; those of gliders need lists of sensors beside them."""
    if not DATA.exists():
        if os.environ.get("CI") == "true" and os.environ.get("SEATRIAL_DATA") != "none":
            pytest.fail(f"no {DATA}")
        pytest.skip(f"no {DATA}")
    folders = ("real", "simulated", "firmware", "native")
    files = (path for folder in folders for path in (DATA / folder).rglob("*"))
    return sorted(path for path in files if path.suffix.lower() in FORMATS)


def said(path: Path) -> str:
    """The outcome that the command's document says, or ``refused``."""
    done = command("identify", "--json", str(path))
    if done.returncode == 3:
        return "refused"
    outcome: str = json.loads(done.stdout)["verdict"]["outcome"]
    return outcome.replace("_", " ")


def outcome(path: Path) -> str:
    """Python's outcome. What it says names none of the command's options."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        try:
            found = seatrial.identify_log(path)
        except seatrial.InputError as error:
            assert not OPTION.search(str(error)), f"{path}: {error}"
            return "refused"
    texts = [str(one.message) for one in told]
    texts += [text for reason in found.document["verdict"]["reasons"] for text in reason.values()]
    for text in texts:
        assert not OPTION.search(text), f"{path}: {text}"
    return found.outcome


def test_a_simulated_log_has_the_same_outcome(log: Path) -> None:
    assert outcome(log) == said(log)


def test_every_recorded_log_has_the_same_outcome() -> None:
    logs = recorded()
    assert len(logs) >= LEAST_LOGS, len(logs)
    with ThreadPoolExecutor(2) as pool:
        expected = list(pool.map(said, logs))
        found = dict(zip(logs, map(outcome, logs)))
    different = {path.name: (found[path], one) for path, one in zip(logs, expected) if found[path] != one}
    assert different == {}
    assert {"use", "use with care", "not validated", "do not use"} <= set(expected)
