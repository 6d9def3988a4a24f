"""Many logs at once, on this machine, by an executor or on a Ray cluster."""

from __future__ import annotations

import json
from concurrent.futures import Executor, as_completed
from importlib import import_module
from os import PathLike, fspath
from typing import Any, Iterator, Literal, Optional, Sequence

from . import _native
from ._reading import Reading


def fleet(
    inputs: str | PathLike[str] | Sequence[str | PathLike[str]],
    out: str | PathLike[str],
    *,
    estimate: Literal["refined", "online"] = "refined",
    run_column: Optional[str] = None,
    reading: Optional[Reading] = None,
    workers: Optional[int] = None,
    resume: bool = False,
    ray: bool = False,
    executor: Optional[Executor] = None,
    logs_per_task: int = 50,
    max_retries: int = 3,
) -> dict[str, Any]:
    """Identify every manoeuvre of many logs: a Parquet row each, and an error row for each log that cannot be read.

    A second call reads only logs that are new, have changed or could not be read.

    Parameters
    ----------
    inputs
        Folders, logs, patterns or @LIST; also of ``s3://``, ``gs://`` and ``https://``.
    out
        The Parquet file, here or in a store; ``out.journal`` beside it, or in the working folder, keeps what is done.
    estimate
        ``refined`` with intervals, ``online`` without, many times faster.
    run_column
        Column that tells the runs of a log apart.
    reading
        Columns, units and channels of every log; a lag of the rudder is for one log alone.
    workers
        Threads on this machine; all cores without.
    resume
        Go on with the journal of a job that was interrupted.
    ray
        Work by tasks of the Ray cluster that this process is connected to, or of a local one; every node must see the
        logs under the same names. A task whose worker is lost is done again; its rows are kept once.
    executor
        Work by tasks of an executor as in ``concurrent.futures`` (processes, Dask, MPI, loky), whose workers must see the
        logs under the same names. A lost worker ends the job; ``resume`` goes on with it.
    logs_per_task
        Of Ray and of an executor.
    max_retries
        Of Ray's tasks.

    Returns
    -------
    dict
        The summary.
    """
    given = [inputs] if isinstance(inputs, (str, PathLike)) else inputs
    names = [fspath(name) for name in given]
    how = (estimate, run_column, (reading or Reading()).native())
    if not ray and executor is None:
        text = _native.fleet(names, out, how, workers, resume)
    else:
        journal = _native.FleetJournal(names, out, how, resume)
        logs = journal.pending()
        tasks = [logs[i : i + logs_per_task] for i in range(0, len(logs), logs_per_task)]
        done = _by_executor(executor, tasks, how) if executor else _on_ray(tasks, how, max_retries)
        try:
            for lines in done:
                journal.keep(lines)
            text = journal.finish()
        finally:
            # The traceback of a failure would keep it from whoever resumes the job.
            del journal
    summary: dict[str, Any] = json.loads(text)
    return summary


_How = tuple[str, Optional[str], dict[str, Any]]


def _by_executor(executor: Executor, tasks: list[Any], how: _How) -> Iterator[str]:
    waiting = {executor.submit(_native_work, task, how) for task in tasks}
    try:
        for future in as_completed(set(waiting)):
            # What is kept is held no longer.
            waiting.discard(future)
            yield future.result()
    finally:
        for future in waiting:
            future.cancel()


def _on_ray(tasks: list[Any], how: _How, max_retries: int) -> Iterator[str]:
    ray: Any = import_module("ray")
    work = ray.remote(max_retries=max_retries)(_native_work)
    # So many tasks wait at a time that every core has its next one, however many there are.
    at_once = max(4, 4 * int(ray.cluster_resources().get("CPU", 1)) if ray.is_initialized() else 4)
    running: list[Any] = []
    while tasks or running:
        while tasks and len(running) < at_once:
            running.append(work.remote(tasks.pop(0), how))
        [done], running = ray.wait(running, num_returns=1)
        yield ray.get(done)


def _native_work(logs: Any, how: _How) -> str:
    return _native.fleet_work(logs, how)
