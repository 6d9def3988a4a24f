"""Where the tree is, and simulated records."""

from __future__ import annotations

import os
import re
import subprocess
from pathlib import Path
from typing import Any

import pytest

import seatrial

ROOT = Path(__file__).resolve().parents[3]


def binary() -> Path:
    """The program that ``SEATRIAL`` names, or else where cargo builds it for a release."""
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    return Path(os.environ.get("SEATRIAL", target / "release/seatrial"))


def command(*arguments: str) -> subprocess.CompletedProcess[str]:
    """The command seatrial of this tree."""
    return subprocess.run([binary(), *arguments], capture_output=True, text=True)


def code_of(page: str, with_text: str) -> str:
    """The Python on a page of the documentation that holds this text."""
    text = (ROOT / "docs" / page).read_text()
    [code] = [part for part in re.findall(r"```python\n(.*?)```", text, re.S) if with_text in part]
    return str(code)


@pytest.fixture(scope="session")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A log of a trial at one speed, as the command simulates it."""
    path = tmp_path_factory.mktemp("log") / "run.csv"
    made = command("sim", "log", "--seed", "3", "--thrust", "0.8", "--out", str(path))
    assert made.returncode == 0, made.stderr
    return path


@pytest.fixture(scope="session")
def record(log: Path) -> dict[str, Any]:
    """Its samples."""
    return dict(seatrial.read_log(log))
