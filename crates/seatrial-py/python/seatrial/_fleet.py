"""Many logs at once, on this machine or on a Ray cluster."""

from __future__ import annotations

import json
from importlib import import_module
from os import PathLike, fspath
from typing import Any, Literal, Optional, Sequence

from . import _native


def fleet(
    inputs: str | PathLike[str] | Sequence[str | PathLike[str]],
    out: str | PathLike[str],
    *,
    estimate: Literal["refined", "online"] = "refined",
    run_column: Optional[str] = None,
    workers: Optional[int] = None,
    resume: bool = False,
    ray: bool = False,
    logs_per_task: int = 50,
    max_retries: int = 3,
) -> dict[str, Any]:
    """Identify every manoeuvre of many logs: a Parquet row each, and an error row for each log that cannot be read.

    Parameters
    ----------
    inputs
        Folders, logs, patterns or @LIST.
    out
        The Parquet file; ``out.journal`` beside it keeps what is done.
    estimate
        ``refined`` with intervals, ``online`` without, many times faster.
    run_column
        Column that tells the runs of a log apart.
    workers
        Threads on this machine; all cores without.
    resume
        Go on with the journal of a job that was interrupted.
    ray
        Work by tasks of the Ray cluster that this process is connected to, or of a local one; every node must see the
        logs under the same names. A task whose worker is lost is done again; its rows are kept once.
    logs_per_task, max_retries
        Of Ray's tasks.

    Returns
    -------
    dict
        The summary.
    """
    given = [inputs] if isinstance(inputs, (str, PathLike)) else inputs
    names = [fspath(name) for name in given]
    if ray:
        return _on_ray(names, out, estimate, run_column, resume, logs_per_task, max_retries)
    text = _native.fleet(names, out, estimate, run_column, workers, resume)
    summary: dict[str, Any] = json.loads(text)
    return summary


def _on_ray(
    inputs: list[str],
    out: str | PathLike[str],
    estimate: str,
    run_column: Optional[str],
    resume: bool,
    logs_per_task: int,
    max_retries: int,
) -> dict[str, Any]:
    ray: Any = import_module("ray")
    journal = _native.FleetJournal(inputs, out, estimate, run_column, resume)
    work = ray.remote(max_retries=max_retries)(_native_work)
    logs = journal.pending()
    tasks = [logs[i : i + logs_per_task] for i in range(0, len(logs), logs_per_task)]
    # So many tasks wait at a time that every core has its next one, however many there are.
    at_once = max(4, 4 * int(ray.cluster_resources().get("CPU", 1)) if ray.is_initialized() else 4)
    running: list[Any] = []
    while tasks or running:
        while tasks and len(running) < at_once:
            running.append(work.remote(tasks.pop(0), estimate, run_column))
        [done], running = ray.wait(running, num_returns=1)
        journal.keep(ray.get(done))
    summary: dict[str, Any] = json.loads(journal.finish())
    return summary


def _native_work(logs: Any, estimate: str, run_column: Optional[str]) -> str:
    return _native.fleet_work(logs, estimate, run_column)
