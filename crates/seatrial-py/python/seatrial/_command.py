"""The command ``seatrial``, which the wheel installs, with its documents and exceptions."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import sysconfig
from os import PathLike, fspath
from typing import Any, Optional

from ._errors import (
    AbortedError,
    InputError,
    NotSavedError,
    RejectedError,
    SeatrialError,
    UsageError,
)
from ._reading import tell

_ERRORS: dict[int, type[SeatrialError]] = {
    error.code: error for error in (UsageError, InputError, RejectedError, AbortedError, NotSavedError)
}


def _program() -> str:
    """The command beside this Python, else the one that a terminal finds."""
    beside = os.path.join(sysconfig.get_path("scripts"), "seatrial" + (".exe" if os.name == "nt" else ""))
    found = beside if os.path.exists(beside) else shutil.which("seatrial")
    if found is None:
        raise SeatrialError("the command seatrial is not installed; a wheel of the package brings it")
    return found


def command(*arguments: str | PathLike[str], timeout_s: Optional[float] = None) -> dict[str, Any]:
    """Run a verb of the command and take its document: every verb, those on real vehicles included.

    Parameters
    ----------
    *arguments
        As in a terminal, without ``--json``: ``command("commission", "--vehicle", "mavlink:udp:0.0.0.0:14550", "--logbook",
        "sea.db", "--yes")``. Nothing is asked: what moves a vehicle is refused without ``--yes``.
    timeout_s
        Interrupt the command after this time, as Ctrl-C does: a vehicle is handed back.

    Returns
    -------
    dict
        The document of ``--json``. One of a model that is not to be used is returned, too: look at its verdict.

    Raises
    ------
    SeatrialError
        The one of the command's exit code, where it has no document.

    Warns
    -----
    SeatrialWarning
        What the command warns of.
    """
    given = [fspath(argument) for argument in arguments]
    process = subprocess.Popen(
        [_program(), *given, "--json"], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
        stderr=subprocess.PIPE, text=True, encoding="utf-8",
    )
    try:
        printed, said = process.communicate(timeout=timeout_s)
    except (subprocess.TimeoutExpired, KeyboardInterrupt):
        process.terminate()
        printed, said = process.communicate()
        sys.stderr.write(said)
        raise
    document: Any = json.loads(printed) if printed.strip() else None
    if isinstance(document, dict):
        lines = (line.removeprefix("seatrial: ") for line in said.splitlines())
        tell([line.removeprefix("warning: ") for line in lines if line.startswith("warning: ")])
        return document
    raise _ERRORS.get(process.returncode, SeatrialError)(said.strip())
