"""Python's outcome of a log is the one that the command says, over every log that the project has."""

from __future__ import annotations

import json
import os
import re
import warnings
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

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


def cases() -> list[Path]:
    """Logs after public bug reports: every container that people bring."""
    folder = DATA / "cases"
    if not folder.exists():
        recorded()
        pytest.skip(f"no {folder}")
    return sorted(path for path in folder.iterdir() if path.suffix != ".md")


# Arguments of Python, and the command's options in their place.
ARGUMENTS = [
    (r'units=\{"(\w+)": "([^"]+)"\}', r"--unit \1=\2"),
    (r'columns=\{"(\w+)": "(\w+)"\}', r"--\1 \2"),
    (r'columns\["(\w+)"\]', r"--\1"),
    (" and --unit ", " --unit "),
]


def with_options(text: str) -> str:
    """What Python says with the command's options in place of its arguments."""
    for argument, option in ARGUMENTS:
        text = re.sub(argument, option, text)
    return text


def answer(path: Path) -> dict[str, Any] | str:
    """Python's document of a log, or the sentence by which it refuses it."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            return dict(seatrial.identify_log(path).document)
        except seatrial.InputError as error:
            return str(error)


def answer_of_command(path: Path) -> dict[str, Any] | str:
    """The command's document, or its sentence."""
    done = command("identify", "--json", str(path))
    if done.returncode == 3:
        return done.stderr.splitlines()[-1].removeprefix("seatrial: ")
    return dict(json.loads(done.stdout))


def without_advice(value: Any) -> Any:
    """A document, its sentences with the command's options, without what each reader is told to do."""
    if isinstance(value, dict):
        return {key: without_advice(part) for key, part in value.items() if key not in ("action", "warnings")}
    if isinstance(value, list):
        return [without_advice(part) for part in value]
    return with_options(value) if isinstance(value, str) else value


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


@pytest.mark.parametrize("path", cases() if (DATA / "cases").exists() else [None], ids=lambda path: getattr(path, "name", "none"))
def test_a_reported_case_has_the_same_answer(path: Path | None) -> None:
    if path is None:
        cases()
    assert without_advice(answer(path)) == without_advice(answer_of_command(path))


def test_every_recorded_log_has_the_same_outcome() -> None:
    logs = recorded()
    assert len(logs) >= LEAST_LOGS, len(logs)
    with ThreadPoolExecutor(2) as pool:
        expected = list(pool.map(said, logs))
        found = dict(zip(logs, map(outcome, logs)))
    different = {path.name: (found[path], one) for path, one in zip(logs, expected) if found[path] != one}
    assert different == {}
    assert {"use", "use with care", "not validated", "do not use"} <= set(expected)
