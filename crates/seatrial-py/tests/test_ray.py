"""Real Ray clusters on this machine: one of which a worker is killed in mid job, one that jobs are submitted to."""

from __future__ import annotations

import os
import secrets
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import psutil
import pytest

import seatrial
from conftest import code_of, command

ray = pytest.importorskip("ray")


def test_io_a_cluster_that_loses_a_worker_gives_the_rows_of_one_machine(tmp_path: Path) -> None:
    first = tmp_path / "run0000.csv"
    assert command("sim", "log", "--seed", "1", "--out", str(first)).returncode == 0
    count = int(os.environ.get("SEATRIAL_FLEET_LOGS", 24))
    # Read by a choice of columns and units that no default makes.
    name, *rows = first.read_text().splitlines()
    first.write_text("\n".join([name.replace("heading_rad", "angle"), *rows]))
    reading = seatrial.Reading(columns={"heading": "angle"}, units={"heading": "rad"})
    for copy in range(1, count):
        os.link(first, tmp_path / f"run{copy:04}.csv")
    (tmp_path / "bad.csv").write_text("time,heading\n")
    alone = seatrial.fleet(tmp_path, tmp_path / "alone.out", reading=reading)
    assert (alone["logs"], alone["manoeuvres"], alone["errors"]) == (count + 1, 10 * count, 1)
    with pytest.raises(seatrial.UsageError, match="rudder_lag_s"):
        seatrial.fleet(tmp_path, tmp_path / "late.out", reading=seatrial.Reading(rudder_lag_s=0.1))

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
        together = seatrial.fleet(
            tmp_path, tmp_path / "together.out", reading=reading, ray=True, logs_per_task=3
        )
        killer.join()
    finally:
        ray.shutdown()
    assert len(killed) == 1
    assert together == alone
    assert (tmp_path / "together.out").read_bytes() == (tmp_path / "alone.out").read_bytes()


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as server:
        return int(server.getsockname()[1])


def test_io_the_job_of_the_documentation_is_submitted(tmp_path: Path) -> None:
    logs, job = tmp_path / "logs", tmp_path / "job"
    logs.mkdir()
    job.mkdir()
    for seed in range(3):
        made = command("sim", "log", "--seed", str(seed), "--out", str(logs / f"run{seed}.csv"))
        assert made.returncode == 0
    code = code_of("python.md", "# fleet_job.py").replace("/mnt/", f"{tmp_path}/")
    (job / "fleet_job.py").write_text(code)
    token = {"RAY_AUTH_MODE": "token", "RAY_AUTH_TOKEN": secrets.token_hex(32)}
    environment = {**os.environ, **token, "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}

    def run(*arguments: str) -> str:
        done = subprocess.run(
            ["ray", *arguments], env=environment, text=True, timeout=120,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        )
        assert done.returncode == 0, done.stdout
        return done.stdout

    dashboard = free_port()
    # The paths of its sockets must be short.
    sessions = tempfile.mkdtemp(prefix="ray")
    head = subprocess.Popen(
        ["ray", "start", "--head", "--block", "--num-cpus=2", f"--port={free_port()}",
         f"--dashboard-port={dashboard}", f"--temp-dir={sessions}"],
        env=environment, stdout=subprocess.DEVNULL,
    )
    try:
        end = time.monotonic() + 60.0
        while time.monotonic() < end:
            with socket.socket() as probe:
                if probe.connect_ex(("127.0.0.1", dashboard)) == 0:
                    break
            time.sleep(0.2)
        said = run("job", "submit", "--address", f"http://127.0.0.1:{dashboard}",
                   "--working-dir", str(job), "--", "python", "fleet_job.py")
    finally:
        # At once: asked to end, it would first wait for work that does not come.
        for process in [*psutil.Process(head.pid).children(recursive=True), head]:
            process.kill()
        head.wait()
        shutil.rmtree(sessions)
    assert "'logs': 3" in said and "succeeded" in said, said
    alone = seatrial.fleet(logs, tmp_path / "alone.parquet")
    assert alone["logs"] == 3
    assert (tmp_path / "fleet.parquet").read_bytes() == (tmp_path / "alone.parquet").read_bytes()
