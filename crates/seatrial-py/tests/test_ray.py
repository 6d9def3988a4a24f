"""A real Ray cluster on this machine, of which a worker is killed in mid job."""

from __future__ import annotations

import os
import signal
import threading
import time
from pathlib import Path

import psutil
import pytest

import seatrial
from conftest import command

ray = pytest.importorskip("ray")


def test_io_a_cluster_that_loses_a_worker_gives_the_rows_of_one_machine(tmp_path: Path) -> None:
    first = tmp_path / "run0000.csv"
    assert command("sim", "log", "--seed", "1", "--out", str(first)).returncode == 0
    for copy in range(1, 24):
        os.link(first, tmp_path / f"run{copy:04}.csv")
    (tmp_path / "bad.csv").write_text("time,heading\n")
    alone = seatrial.fleet(tmp_path, tmp_path / "alone.out")
    assert (alone["logs"], alone["manoeuvres"], alone["errors"]) == (25, 240, 1)

    killed: list[int] = []

    def kill_a_worker() -> None:
        end = time.monotonic() + 60.0
        while not killed and time.monotonic() < end:
            for process in psutil.Process().children(recursive=True):
                try:
                    at_work = "_native_work" in " ".join(process.cmdline())
                except psutil.Error:
                    continue
                if at_work:
                    time.sleep(0.1)
                    os.kill(process.pid, signal.SIGKILL)
                    killed.append(process.pid)
                    return
            time.sleep(0.02)

    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
    try:
        killer = threading.Thread(target=kill_a_worker)
        killer.start()
        together = seatrial.fleet(tmp_path, tmp_path / "together.out", ray=True, logs_per_task=3)
        killer.join()
    finally:
        ray.shutdown()
    assert len(killed) == 1
    assert together == alone
    assert (tmp_path / "together.out").read_bytes() == (tmp_path / "alone.out").read_bytes()
